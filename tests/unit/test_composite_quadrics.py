"""Builders of composite quadric models, their features, combinations, placements and bad input."""

from __future__ import annotations

import math
import pickle
from collections import Counter
from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.body.solid.carriers import AlgebraicPoint, Conic, EnclosedPoint, Line, Point, QuarticCurve


def counts(body):
    return len(body.faces), len(body.edges), len(body.vertices)


def names(features):
    return [feature.name for feature in features]


def kinds(body):
    return Counter((type(e.carrier).__name__, e.convexity) for e in body.edges)


BUILT = [
    (fc.box((1, 2, 3)), (6, 12, 8), ["x-", "x+", "y-", "y+", "z-", "z+"], (1, 2, 3), (-0.5, -1, -1.5)),
    (fc.sphere("1/2"), (1, 0, 0), ["surface"], (1, 1, 1), (-0.5, -0.5, -0.5)),
    (fc.ellipsoid((1, 2, 3)), (1, 0, 0), ["surface"], (2, 4, 6), (-1, -2, -3)),
    (fc.cylinder(1, 2), (3, 2, 0), ["side", "top", "bottom"], (2, 2, 2), (-1, -1, -1)),
    (fc.cylinder((5, 10), 10), (3, 2, 0), ["side", "top", "bottom"], (10, 20, 10), (-5, -10, -5)),
    (fc.cone(1, 2), (2, 1, 1), ["side", "bottom"], (2, 2, 2), (-1, -1, 0)),
    (fc.frustum(2, 1, 1), (3, 2, 0), ["side", "top", "bottom"], (4, 4, 1), (-2, -2, 0)),
    (fc.frustum(0, 1, 1), (2, 1, 1), ["side", "top"], (2, 2, 1), (-1, -1, 0)),
    (fc.frustum(1, 1, 2), (3, 2, 0), ["side", "top", "bottom"], (2, 2, 2), (-1, -1, 0)),
    (fc.paraboloid((1, "1/2"), 4), (2, 1, 0), ["side", "top"], (4, 2, 4), (-2, -1, 0)),
    (fc.hyperboloid((1, 2, 1), 2), (3, 2, 0), ["side", "top", "bottom"], None, None),
    (fc.hyperboloid((1, 1, 1), 2, sheets=2), (2, 1, 0), ["side", "top"], None, None),
]


@pytest.mark.parametrize(("body", "expected", "labels", "size", "corner"), BUILT)
def test_builders(body, expected, labels, size, corner):
    assert counts(body) == expected
    assert names(body.faces) == labels
    assert all(e.convexity == "convex" for e in body.edges)
    assert body.bounded
    if size is not None:
        lo, hi = body.bounds()
        assert np.all(lo <= corner) and np.allclose(lo, corner, atol=1e-7)
        assert np.allclose(hi - lo, size, atol=1e-7)


def test_names_of_rims_and_tips():
    assert names(fc.cylinder(1, 2, name="pin").edges) == ["pin.rim.top", "pin.rim.bottom"]
    cone = fc.cone(1, 2).named("tip")
    assert names(cone.edges) == ["tip.rim.bottom"]
    assert names(cone.vertices) == ["tip.apex"]
    assert cone.vertices[0].position == (0.0, 0.0, 2.0) and cone.vertices[0].error == 0.0


def drilled(*cutters):
    body = fc.box((4, 4, 1)).named("slab")
    for cutter in cutters:
        body = body - cutter
    return names(body.named("plate").edges)[12:]


def test_edges_between_parts_are_named_after_the_one_that_cuts():
    through = fc.cylinder(1, 2).named("hole")
    assert drilled(through) == ["plate.hole.rim.bottom", "plate.hole.rim.top"]
    assert drilled(through.rotated((1, 0, 0), degrees=180)) == ["plate.hole.rim.top", "plate.hole.rim.bottom"]
    blind = fc.cylinder(1, 1).translated((0, 0, "1/2")).named("hole")
    assert drilled(blind) == ["plate.hole.rim.top", "plate.hole.rim.bottom"]
    dimple = fc.sphere(1).translated((0, 0, 1)).named("dimple")
    assert drilled(dimple) == ["plate.dimple.rim"]
    bore, counterbore = fc.cylinder("1/2", 2).named("bore"), fc.cylinder(1, "1/2").translated((0, 0, "1/2"))
    assert drilled(bore, counterbore.named("counterbore")) == [
        "plate.bore.rim.bottom",
        "plate.counterbore.rim.top",
        "plate.bore.rim.top",  # in the floor of the counterbore
        "plate.counterbore.rim.bottom",
    ]
    pocket = fc.box((1, 1, 1)).translated((0, 0, "1/2")).named("pocket")
    assert {"plate.pocket.rim.x+", "plate.pocket.x+/z-"} <= set(drilled(pocket))


def test_edges_of_unions_and_intersections():
    chamfer = fc.frustum(1, "4/5", "1/5").translated((0, 0, 1)).named("chamfer")
    pin = (fc.cylinder(1, 2).named("shaft") | chamfer).named("pin")
    assert names(pin.edges) == ["pin.chamfer.rim.bottom", "pin.shaft.rim.bottom", "pin.chamfer.rim.top"]
    boss = (fc.cylinder(1, 4).named("boss") | fc.box((4, 4, 1)).named("base")).named("part")
    assert {"part.boss.rim.top", "part.boss.rim.z+", "part.boss.rim.z-"} <= set(names(boss.edges))
    flat = fc.half_space((-1, 0, 0), "-1/2").named("flat")
    shaft = fc.cylinder(1, 2) - flat
    assert {"flat.rim.top", "flat.rim.bottom", "flat.rim.side", "flat.rim.side.2"} < set(names(shaft.edges))


def test_equal_unnamed_primitives_have_different_names():
    hole = fc.cylinder("1/2", 2).translated((-1, 0, 0)) | fc.cylinder("1/2", 2).translated((1, 0, 0))
    plate = (fc.box((4, 4, 1)) - hole.named("hole")).named("plate")
    assert names(plate.faces)[6:] == ["plate.hole.side", "plate.hole.side.2"]
    assert names(plate.edges)[12:] == [
        "plate.hole.rim.bottom", "plate.hole.rim.bottom.2", "plate.hole.rim.top", "plate.hole.rim.top.2",
    ]  # fmt: skip


@pytest.mark.share(4)
@pytest.mark.parametrize("body", [built[0] for built in BUILT])
def test_names_are_unique_whatever_is_combined(body):
    other = body.translated(("1/5", "1/7", "1/4"))
    for solid in (body | other, (body - other).named("rest")):
        for features in (solid.faces, [*solid.edges, *solid.seams], solid.vertices):
            assert len(set(names(features))) == len(features)


def test_corners_of_a_box_are_exact_points():
    corners = fc.box(("1/3", 1, 1)).vertices
    assert all(isinstance(v.carrier, Point) for v in corners)
    assert {abs(v.carrier.basis[0][0]) for v in corners} == {fmpq(1, 6)}
    assert len({v.position for v in corners}) == 8


def test_half_space_and_unbounded_quadric():
    half = fc.half_space((1, 2, 2), 3)
    assert counts(half) == (1, 0, 0) and not half.bounded
    assert half.contains([(1, 1, 0), (1, 1, 0.01), (0, 0, 0)]).tolist() == [True, False, True]
    tube = fc.quadric(np.diag([1, 1, 0, -1]))
    assert counts(tube) == (1, 0, 0) and not tube.bounded
    assert np.all(np.isinf(tube.bounds()[0]))


def test_quadric_of_rank_two_is_taken_apart():
    wedge = fc.quadric(np.diag([1, -4, 0, 0]))  # |x| <= 2 |y|
    assert counts(wedge) == (4, 1, 0)
    assert wedge.contains([(1, 1, 0), (1, 0, 0), (2, 1, 5), (3, -1, 0)]).tolist() == [True, False, True, False]
    half = fc.quadric([[0, 0, 0, 1], [0, 0, 0, 0], [0, 0, 0, 0], [1, 0, 0, -4]])  # 2 x <= 4
    assert counts(half) == (1, 0, 0)
    assert half.contains([(1.9, 0, 0), (2.1, 0, 0)]).tolist() == [True, False]


def test_capsule_has_seams_but_no_edges():
    capsule = fc.cylinder(1, 2) | fc.sphere(1).translated((0, 0, 1)) | fc.sphere(1).translated((0, 0, -1))
    assert counts(capsule) == (3, 0, 0)
    assert [s.convexity for s in capsule.seams] == ["smooth", "smooth"]
    assert np.allclose(capsule.bounds()[1], (1, 1, 2))


def test_pin_with_chamfer():
    pin = fc.cylinder(1, 2) | fc.frustum(1, "4/5", "1/5").translated((0, 0, 1))
    assert counts(pin) == (4, 3, 0)
    assert kinds(pin) == {("Conic", "convex"): 3}


def test_plate_with_counterbored_hole():
    hole = (fc.cylinder("1/2", 2) | fc.cylinder(1, "1/2").translated((0, 0, "1/2"))).named("hole")
    plate = (fc.box((4, 4, 1)) - hole).named("plate")
    assert counts(plate) == (9, 16, 8)
    assert kinds(plate) == {("Line", "convex"): 12, ("Conic", "convex"): 3, ("Conic", "reentrant"): 1}
    assert "plate.hole.side" in names(plate.faces) and "plate.z+" in names(plate.faces)
    step = next(f for f in plate.faces if f.name == "plate.hole.bottom")
    assert step.orientation == -1  # the hole's floor bounds the plate from above
    assert plate.contains([(0, 0, 0), (0.75, 0, 0), (0.75, 0, 0.3), (0.75, 0, 0.25)]).tolist() == [0, 1, 0, 1]


def test_equal_crossing_cylinders_meet_in_two_ellipses():
    upright, lying = fc.cylinder(1, 6), fc.cylinder(1, 6).rotated((1, 0, 0), degrees=90)
    union, common = upright | lying, upright & lying
    assert counts(union) == (6, 6, 0)
    assert kinds(union) == {("Conic", "convex"): 4, ("Conic", "reentrant"): 2}
    assert counts(common) == (2, 2, 0)
    for edge in common.edges:  # ellipses with semi-axes 1 and sqrt 2
        assert isinstance(edge.carrier, Conic)
        p = edge.points(np.linspace(0, 2 * math.pi, 400))
        assert np.linalg.norm(p, axis=1).max() == pytest.approx(math.sqrt(2), abs=1e-4)
        assert np.allclose(p[:, 0] ** 2 + p[:, 1] ** 2, 1) and np.allclose(p[:, 0] ** 2 + p[:, 2] ** 2, 1)


def test_cylinders_of_different_radius_meet_in_a_quartic():
    wide, narrow = fc.cylinder(1, 6), fc.cylinder("1/2", 6).rotated((1, 0, 0), degrees=90)
    drilled = wide - narrow
    assert counts(drilled) == (4, 3, 0)
    edge = next(e for e in drilled.edges if isinstance(e.carrier, QuarticCurve))
    assert edge.convexity == "convex" and len(edge.pieces) == 2
    for piece in edge.pieces:
        p = edge.points(np.linspace(piece.lo, piece.hi, 50))
        assert np.allclose(p[:, 0] ** 2 + p[:, 1] ** 2, 1, atol=1e-12)
        assert np.allclose(p[:, 0] ** 2 + p[:, 2] ** 2, 0.25, atol=1e-12)
        assert np.allclose(p[0], p[-1])
    union = wide | narrow
    assert next(e for e in union.edges if isinstance(e.carrier, QuarticCurve)).convexity == "reentrant"


def test_quartic_edge_that_ends_on_a_cap():
    body = fc.cylinder(1, 6) | fc.cylinder("1/2", 6).rotated((1, 0, 0), degrees=90).translated((0, 0, "27/10"))
    # the narrow cylinder leaves through the top z = 3 where x^2 + 0.09 = 0.25, y^2 = 1 - x^2
    y = math.sqrt(0.84)
    expected = [(-0.4, -y, 3), (-0.4, y, 3), (0.4, -y, 3), (0.4, y, 3)]
    assert np.allclose(sorted(v.position for v in body.vertices), expected, rtol=0, atol=1e-15)
    quartic = next(e for e in body.edges if isinstance(e.carrier, QuarticCurve))
    assert sorted(v for p in quartic.pieces for v in (p.start, p.end)) == [0, 1, 2, 3]


def test_three_cylinders_meet_in_enclosed_points():
    body = (
        fc.cylinder(1, 6)
        & fc.cylinder("3/4", 6).rotated((1, 0, 0), degrees=90)
        & fc.cylinder("4/5", 6).rotated((0, 1, 0), degrees=90).translated((0, "1/10", 0))
    )
    assert counts(body) == (3, 3, 8)
    for vertex in body.vertices:
        assert isinstance(vertex.carrier, EnclosedPoint) and vertex.carrier.proved
        x, y, z = vertex.position
        assert (x * x + y * y, x * x + z * z) == pytest.approx((1, 0.5625), abs=1e-14)
        assert (y - 0.1) ** 2 + z * z == pytest.approx(0.64, abs=1e-14)


def test_flat_on_a_shaft_gives_irrational_lines():
    shaft = fc.cylinder(1, 2) - fc.half_space((-1, 0, 0), "-1/2")  # keeps x <= 1/2
    assert counts(shaft) == (4, 6, 4)
    lines = [e for e in shaft.edges if isinstance(e.carrier, Conic) and e.frame.shape[1] == 2]
    assert len(lines) == 2 and lines[0].carrier is lines[1].carrier
    corner = shaft.vertices[0]
    assert isinstance(corner.carrier, AlgebraicPoint) and len(corner.carrier.polynomial) == 3
    assert abs(corner.position[1]) == pytest.approx(math.sqrt(0.75), abs=1e-15)
    assert 0 < corner.error < 1e-15
    assert np.allclose(shaft.bounds(), [(-1, -1, -1), (0.5, 1, 1)])


def test_bracket_has_one_reentrant_corner_line():
    bracket = fc.box((4, 1, 1)) | fc.box((1, 1, 4)).translated(("3/2", 0, "3/2"))
    assert counts(bracket) == (8, 18, 12)
    reentrant = [e for e in bracket.edges if e.convexity == "reentrant"]
    assert len(reentrant) == 1 and isinstance(reentrant[0].carrier, Line)
    ends = reentrant[0].points([reentrant[0].pieces[0].lo, reentrant[0].pieces[0].hi])
    assert sorted(map(tuple, ends.tolist())) == [(1.0, -0.5, 0.5), (1.0, 0.5, 0.5)]


def test_cavity_is_a_face_of_its_own():
    hollow = fc.box((4, 4, 4)) - fc.sphere(1).named("bubble")
    assert counts(hollow) == (7, 12, 8)
    inner = hollow.faces[6]
    assert inner.name == "bubble.surface" and inner.orientation == -1
    assert hollow.contains([(0, 0, 0), (0, 0, 1), (0, 0, 1.5)]).tolist() == [False, True, True]


def test_touching_boxes_leave_no_wall():
    pair = fc.box((1, 1, 1)) | fc.box((1, 1, 1)).translated((1, 0, 0))
    assert counts(pair) == (6, 12, 8)
    assert pair.contains([(0.5, 0, 0), (0.5, 0.5, 0.5), (0.5, 0.6, 0)]).tolist() == [True, True, False]


def test_touching_cylinders_side_by_side_share_no_wedge():
    pair = fc.cylinder(1, 2) | fc.cylinder(1, 2).translated((2, 0, 0))
    assert len(pair.faces) == 4
    assert kinds(pair) == {("Conic", "convex"): 4} and not pair.seams
    assert sorted(v.position for v in pair.vertices) == [(1.0, 0.0, -1.0), (1.0, 0.0, 1.0)]


def test_thin_cusp_of_tangent_cylinders_is_convex():
    crescent = fc.cylinder(2, 2) - fc.cylinder(1, 4).translated((1, 0, 0))
    inner = next(e for e in crescent.edges if isinstance(e.carrier, Line))
    assert inner.convexity == "convex"
    assert np.allclose(inner.points([0.0])[:, :2], (2, 0))


def test_cone_with_its_tip_cut_off():
    stump = fc.cone(1, 2) - fc.half_space((0, 0, -1), -1)
    assert counts(stump) == (3, 2, 0)
    assert np.allclose(stump.bounds()[1], (1, 1, 1))


def test_double_cone_meets_in_its_apex():
    both = fc.cone(1, 1) | fc.cone(1, 1).rotated((1, 0, 0), degrees=180).translated((0, 0, 2))
    assert counts(both) == (3, 2, 1)
    assert both.vertices[0].position == (0.0, 0.0, 1.0)


def test_parts_of_one_curve_are_pieces_of_one_edge():
    comb = fc.box((6, 2, 2)) - fc.box((1, 1, 1)).translated(("3/2", 0, 1)) - fc.box((2, 4, 1)).translated((-1, 0, 1))
    top = [e for e in comb.edges if e.name == "y+/z+"]
    assert len(top) == 1 and len(top[0].pieces) == 2
    assert all(e.convexity in ("convex", "reentrant") for e in comb.edges)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: fc.sphere(-1), "sphere radius is -1"),
        (lambda: fc.sphere(0), "sphere radius is 0"),
        (lambda: fc.sphere(float("nan")), "nan"),
        (lambda: fc.box((1, 2)), "three numbers"),
        (lambda: fc.box(1), "three numbers"),
        (lambda: fc.box((1, 2, "x")), r"box size\[2\]"),
        (lambda: fc.cylinder((1, 2, 3), 1), "one number or two"),
        (lambda: fc.frustum(0, 0, 1), "both 0"),
        (lambda: fc.hyperboloid((1, 1, 2), 1, sheets=2), "cap is empty"),
        (lambda: fc.hyperboloid((1, 1, 2), 1, sheets=3), "sheets is 3"),
        (lambda: fc.half_space((0, 0, 0), 1), "normal is zero"),
        (lambda: fc.quadric(np.eye(4)), "never negative"),
        (lambda: fc.quadric(-np.eye(4)), "all of space"),
        (lambda: fc.quadric(np.diag([1.0, 0, 0, 0])), "never negative"),
        (lambda: fc.quadric(np.diag([1, -2, 0, 0])), "not rational"),
        (lambda: fc.quadric(np.triu(np.ones((4, 4)))), "not symmetric"),
        (lambda: fc.quadric(np.eye(3)), "4x4"),
        (lambda: fc.sphere(1).transformed(np.diag([1, 1, 0, 1])), "singular"),
        (lambda: fc.sphere(1).rotated((0, 0, 0), degrees=1), "axis is zero"),
        (lambda: fc.box((1, 1, 1)) & fc.box((1, 1, 1)).translated((3, 0, 0)), "is empty"),
        (lambda: fc.box((1, 1, 1)) & fc.box((1, 1, 1)).translated((1, 0, 0)), "is empty"),
        (lambda: fc.box((1, 1, 1)) - fc.box((2, 2, 2)), "is empty"),
        (lambda: fc.half_space((1, 0, 0), 0) | fc.half_space((-1, 0, 0), 0), "all of space"),
        (lambda: fc.sphere(1).contains([(0, 0)]), "shape"),
        (lambda: fc.sphere(1).to_mesh(0), "tolerance"),
    ],
)
def test_bad_input_stops_with_one_line(make, text):
    with pytest.raises(fc.InputError, match=text) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_combining_with_something_else_is_a_type_error():
    with pytest.raises(TypeError):
        fc.sphere(1) | 3


def test_a_thin_overlap_is_not_empty():
    thin = fc.box((1, 1, 1)) & fc.box((1, 1, 1)).translated((1 - Fraction(1, 10**12), 0, 0))
    assert counts(thin) == (6, 12, 8)


def test_contains_is_exact_at_the_boundary():
    ball = fc.sphere(1)
    up = np.nextafter(1.0, 2.0)
    assert ball.contains([(1, 0, 0), (up, 0, 0), (0.6, 0.8, 0)]).tolist() == [True, False, False]
    assert ball.contains((Fraction(3, 5), Fraction(4, 5), 0))
    assert not ball.contains((Fraction(3, 5), Fraction(4, 5), Fraction(1, 10**40)))


def test_placing_is_exact_and_keeps_features():
    pin = fc.cylinder(1, 2).named("pin")
    turned = pin.rotated((1, 2, 2), degrees=37, point=(1, 0, 0)).translated(("1/3", 0, 0))
    assert counts(turned) == counts(pin) and names(turned.edges) == names(pin.edges)
    mirrored = pin.transformed([[-1, 0, 0, 5], [0, 2, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    assert np.allclose(mirrored.bounds(), [(4, -2, -1), (6, 2, 1)])
    assert mirrored.contains([(4, 0, 0), (5, 2, 1), (3.9, 0, 0)]).tolist() == [True, True, False]
    quarter = fc.box((2, 4, 6)).rotated((0, 0, 1), degrees=90)
    assert {v.position for v in quarter.vertices} == {v.position for v in fc.box((4, 2, 6)).vertices}


def test_pickles_are_equal():
    plate = (fc.box((4, 4, 1)) - fc.cylinder(1, 2).named("hole")).named("plate")
    copy = pickle.loads(pickle.dumps(plate))
    assert repr(copy) == repr(plate) == "<CompositeQuadric 'plate': 7 faces, 14 edges, 8 vertices>"
    assert names(copy.faces) == names(plate.faces)
    assert copy == plate and copy is not plate and len({copy, plate}) == 1


def test_moving_places_the_body():
    moving = fc.sphere(1).moving(fc.Translation((4, 0, 0)))
    assert np.allclose(moving.at(0.5).bounds(), [(1, -1, -1), (3, 1, 1)])


def test_box_of_a_raw_intersection_is_found():
    lying = [[0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, "-0.64"]]
    body = fc.quadric(np.diag([1, 1, 0, -1])) & fc.quadric(lying)
    assert body.bounded
    lo, hi = body.bounds()
    assert np.all(lo <= (-1, -0.8, -0.8)) and np.all(hi >= (1, 0.8, 0.8)) and np.all(hi < 1.2)
    assert len(body.edges) == 1 and len(body.vertices) == 0


def test_faces_without_edges_are_found_beside_ones_with():
    """Whole components of surfaces: a face that no curve bounds, on surfaces that others meet and on two-piece ones."""
    block = fc.box((8, 8, 8)) - fc.sphere(1).translated((2, 0, 0))
    assert len(block.faces) == 7
    hyperboloid = fc.quadric(np.diag([1, 1, -1, 1]))  # two sheets
    cut = hyperboloid & fc.half_space((0, 0, -1), 2)  # the upper sheet whole, a cap of the lower one
    assert counts(cut) == (2, 1, 0)
    assert cut.contains([(0, 0, 5), (0, 0, -1.5), (0, 0, -3)]).tolist() == [True, True, False]
    slab = fc.half_space((0, 0, 1), 1) & fc.half_space((0, 0, -1), 1)
    assert counts(slab) == (2, 0, 0)
    tangent = fc.sphere(1) | fc.half_space((0, 0, 1), -1)
    assert len(tangent.faces) == 2
    nappes = fc.quadric(np.diag([1, 1, -1, 0])) & fc.half_space((0, 0, 1), 1)  # both nappes, one cut
    assert counts(nappes) == (2, 1, 1)


@pytest.mark.parametrize(
    ("form", "connected"),
    [
        (np.diag([1, 2, 3, -1]), True), (np.diag([1, 1, -1, -1]), True), (np.diag([1, 1, -1, 1]), False),
        (np.diag([1, 1, -1, 0]), False), (np.diag([1, 1, 0, -1]), True), (np.diag([1, -1, 0, -1]), False),
        ([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1], [0, 0, 1, 0]], True),
        ([[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1], [0, 0, 1, 0]], True),
        ([[1, 0, 0, 0], [0, 0, 0, 1], [0, 0, 0, 0], [0, 1, 0, 0]], True),
    ],
)  # fmt: skip
def test_which_surfaces_are_one_piece(form, connected):
    from firstcontact.body.solid.features import _is_connected

    (surface,) = fc.quadric(form).surfaces
    assert _is_connected(surface) is _is_connected(surface.negated()) is connected


@pytest.mark.parametrize("power", [-100, -40, 36, 37, 60, 100])
@pytest.mark.parametrize("radii", [(7, 7, 7), (5, 6, 7)])
def test_balls_of_all_sizes_have_bounds_also_far_from_the_origin(power, radii):
    scale = Fraction(2) ** power
    radii = [r * scale for r in radii]
    for off in (0, Fraction(10) ** 9):
        lo, hi = fc.ellipsoid(radii).translated([off * scale] * 3).bounds()
        loose = 1 + Fraction(1, 10**8) + off / 10**8
        for k, r in enumerate(radii):
            assert float(off * scale - loose * r) <= lo[k] <= float(off * scale - r)
            assert float(off * scale + r) <= hi[k] <= float(off * scale + loose * r)


def test_an_ellipse_many_times_longer_than_wide():
    """A plane nearly along a cylinder: doubles would call the section's smaller curvature zero or negative."""
    turn = [[Fraction(x, 135) for x in row] for row in ([34, 38, -125], [-62, -109, -50], [-115, 70, -10])]
    bore = fc.cylinder(1, 2**60).transformed([*([*row, 0] for row in turn), [0, 0, 0, 1]])
    for k in (0, 1):  # across the axis but for the rounding of its numbers
        normal = [Fraction(float(row[k])) for row in turn]
        off = abs(float(sum(n * row[2] for n, row in zip(normal, turn, strict=True))))
        frames = [e.frame for e in (fc.half_space(normal, 0) & bore).edges if e.frame.shape[1] == 3]
        lengths = [np.linalg.norm(frame[:3, 1:], axis=0) for frame in frames]
        assert any(x == pytest.approx([1 / off, 1], rel=1e-6) for x in (sorted(y, reverse=True) for y in lengths))


def test_boxes_of_solids_whose_surface_passes_the_origin():
    """There all terms of a form are small together, and the farthest point along an axis is no less on the solid."""
    for r in (Fraction(n, d) for d in (1, 3, 7, 13, 65) for n in (1, 2, 6, 7, 15, 58)):
        sheet = 2 * r * math.sqrt(15)  # of the bowl's rim: 2 r sqrt((h / r)^2 - 1), h = 4 r
        solids = [
            (fc.sphere(r), (-r, -r, -r), (r, r, r), (0, 0, r)),
            (fc.sphere(r), (-r, -r, -r), (r, r, r), (0, 0, -r)),
            (fc.ellipsoid((r, 2 * r, r / 3)), (-r, -2 * r, -r / 3), (r, 2 * r, r / 3), (0, 0, r / 3)),
            (fc.ellipsoid((r, 2 * r, r / 3)), (-r, -2 * r, -r / 3), (r, 2 * r, r / 3), (-r, 0, 0)),
            (fc.hyperboloid((2 * r, 2 * r, r), 4 * r, sheets=2), (-sheet, -sheet, r), (sheet, sheet, 4 * r),
             (0, 0, -r)),
        ]  # fmt: skip
        for solid, low, high, shift in solids:
            found = solid.translated(shift).bounds()
            for corner, true in zip(found, (low, high), strict=True):
                there = [float(x) + float(y) for x, y in zip(true, shift, strict=True)]
                assert np.abs(corner - there).max() <= 1e-6 * float(r), (r, solid, shift)
            assert np.all(found[0] <= np.add(*([float(x) for x in v] for v in (low, shift))) + 1e-12 * float(r))


def test_numbers_of_vertices_do_not_depend_on_the_pose():
    """Of vertices on different surfaces; those on the same ones have numbers next to each other, in any order."""
    solids = [fc.box((2, 3, 4)), fc.cylinder(2, 6) & fc.box((3, 9, 2)), fc.cone(2, 3) - fc.box((1, 1, 9))]
    turns = [[[Fraction(x, 39) for x in row] for row in rows] for rows in (
        [(-29, 22, -14), (-2, 19, 34), (26, 26, -13)], [(39, 0, 0), (0, -15, 36), (0, -36, -15)],
        [(0, 0, 39), (39, 0, 0), (0, 39, 0)])]  # fmt: skip
    for solid in solids:
        surfaces = [v.surfaces for v in solid.vertices]
        places = np.array([v.position for v in solid.vertices])
        for turn in turns:
            placed = solid.transformed([*([*row, k] for k, row in enumerate(turn)), [0, 0, 0, 1]])
            carried = places @ np.array(turn, float).T + np.arange(3.0)
            assert [v.surfaces for v in placed.vertices] == surfaces
            for k, vertex in enumerate(placed.vertices):
                same = [i for i, on in enumerate(surfaces) if on == surfaces[k]]
                assert np.abs(carried[same] - vertex.position).max(axis=1).min() < 1e-12
                assert len(same) > 1 or vertex.name == solid.vertices[k].name
