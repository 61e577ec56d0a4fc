"""Bodies: what is read, what is refused, how elements are numbered, and that placing is exact."""

from __future__ import annotations

import math
import pickle
from collections import Counter
from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
import generators as g

SQUARE = [[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]]


def area(body: fc.Polyhedron) -> float:
    """Sum of triangle areas; signed areas along z cancel where triangles overlap."""
    a, b, c = (body.vertices[body.triangles[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def signed_area(body: fc.Polyhedron) -> float:
    a, b, c = (body.vertices[body.triangles[:, k]] for k in range(3))
    return float(np.cross(b - a, c - a)[:, 2].sum() / 2)


# ------------------------------------------------------------------------------------------------- polygons

SHAPES = {
    "convex": (SQUARE, [[0, 1, 2, 3]], 16),
    "arrow": ([[0, 0, 0], [4, 0, 0], [4, 4, 0], [2, 1, 0], [0, 4, 0]], [[0, 1, 2, 3, 4]], 10),
    "comb": (
        [[0, 0, 0], [7, 0, 0], [7, 3, 0], [6, 3, 0], [6, 1, 0], [4, 1, 0], [4, 3, 0], [3, 3, 0], [3, 1, 0],
         [1, 1, 0], [1, 3, 0], [0, 3, 0]],
        [list(range(12))],
        13,
    ),
    "collinear corners": (
        [[0, 0, 0], [1, 0, 0], [2, 0, 0], [4, 0, 0], [4, 4, 0], [4, 2, 0]], [[0, 1, 2, 3, 5, 4]], 8
    ),
    "hole": (SQUARE + [[1, 1, 0], [2, 1, 0], [2, 2, 0], [1, 2, 0]], [[[0, 1, 2, 3], [4, 5, 6, 7]]], 15),
    "hole the same way round": (
        SQUARE + [[1, 1, 0], [1, 2, 0], [2, 2, 0], [2, 1, 0]], [[[0, 1, 2, 3], [4, 5, 6, 7]]], 15
    ),
    "two holes": (
        SQUARE + [[1, 1, 0], [2, 1, 0], [1, 2, 0], [3, 3, 0], [3, 2, 0], [2, 3, 0]],
        [[[0, 1, 2, 3], [4, 5, 6], [7, 8, 9]]],
        15,
    ),
}  # fmt: skip


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("turned", [False, True], ids=["flat", "tilted"])
@pytest.mark.parametrize("reverse", [False, True])
def test_polygons_are_cut_without_gap_or_overlap(shape, turned, reverse):
    vertices, faces, truth = SHAPES[shape]
    if reverse:
        faces = [[r[::-1] for r in f] if isinstance(f[0], list) else f[::-1] for f in faces]
    points = np.array(vertices, float)
    scale = 1.0
    if turned:  # (1, 2, 2) / 3 and its fellows, times 3: a scaled rotation
        points, scale = points @ np.array([[1, 2, 2], [2, 1, -2], [-2, 2, -1]]), 9.0
    body = fc.Polyhedron(points, faces)
    assert area(body) == pytest.approx(truth * scale, rel=1e-12)
    if not turned:
        assert signed_area(body) == pytest.approx(-truth if reverse else truth, rel=1e-12)
    assert set(body.triangle_face.tolist()) == {0} and body.n_faces == 1
    rings = faces[0] if isinstance(faces[0][0], list) else faces
    sides = {tuple(sorted(s)) for r in rings for s in zip(r, r[1:] + r[:1], strict=True)}
    assert [tuple(e) for e in body.edges.tolist()] == sorted(sides)  # diagonals are no edges
    assert not body.solid


def test_polygons_of_a_box_make_a_solid_with_twelve_edges():
    body = fc.Polyhedron(g.CORNERS, g.SQUARES)
    assert body.solid and body.closed and len(body.edges) == 12 and body.n_faces == 6
    assert Counter(body.triangle_face.tolist()) == dict.fromkeys(range(6), 2)


@pytest.mark.parametrize(
    ("vertices", "face", "says"),
    [
        (SQUARE[:3] + [[0, 4, 1]], [0, 1, 2, 3], "not a planar polygon"),
        (SQUARE, [0, 1], "ring of 2"),
        (SQUARE, [0, 1, 2, 9], "vertex 9"),
        (SQUARE, [0, 1, 2, -1], "vertex -1"),
        (SQUARE + [[9, 9, 0], [9, 8, 0], [8, 9, 0]], [[0, 1, 2, 3], [4, 5, 6]], "hole"),
        ([[0, 0, 0], [4, 4, 0], [4, 0, 0], [0, 4, 0], [2, 7, 0]], [0, 1, 2, 3, 4], "cross"),
    ],
)
def test_bad_polygons_are_named(vertices, face, says):
    with pytest.raises(fc.InputError, match=f"plate: face 1.*{says}"):
        fc.Polyhedron(vertices, [[0, 1, 2], face], name="plate")


# ---------------------------------------------------------------------------------------------------- edges


def test_given_edges_come_first_and_missing_ones_follow():
    body = fc.Polyhedron(SQUARE, [[0, 1, 2], [0, 2, 3]], edges=[[2, 0], [3, 1]])
    assert body.edges.tolist() == [[2, 0], [3, 1], [0, 1], [0, 3], [1, 2], [2, 3]]


def test_edges_are_sorted_pairs_by_default():
    body = fc.Polyhedron(SQUARE, [[2, 1, 0], [3, 2, 0]])
    assert body.edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]


def test_edge_sets_and_point_sets():
    rods = fc.Polyhedron(SQUARE, [], edges=[[3, 0], [1, 2]])
    assert rods.edges.tolist() == [[3, 0], [1, 2]] and not rods.solid and rods.triangles.shape == (0, 3)
    points = fc.Polyhedron(SQUARE, [])
    assert points.edges.shape == (0, 2) and not points.closed


def test_the_number_of_a_given_edge_is_reported():
    rods = fc.Polyhedron([[-1, 0, 0], [1, 0, 0], [-1, 5, 0], [1, 5, 0]], [], edges=[[2, 3], [0, 1]], name="rods")
    bar = fc.Polyhedron([[0, -1, 2], [0, 1, 2]], [], edges=[[0, 1]])
    hit = fc.first_contact(rods.moving(fc.Translation((0, 0, 4))), bar)
    assert (hit.element_a.kind, hit.element_a.index, hit.element_a.label) == ("edge", 1, "rods")


# -------------------------------------------------------------------------------------------- what is refused

TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 2.0**150, -1e300])
def test_bad_coordinates_are_named(bad):
    with pytest.raises(fc.InputError, match="lid: vertex 2, coordinate 1 is"):
        fc.Polyhedron([[0, 0, 0], [1, 0, 0], [0, bad, 0]], [[0, 1, 2]], name="lid")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (dict(vertices=[], faces=[]), "no vertices"),
        (dict(vertices=[[0, 0], [1, 1]], faces=[]), r"\(n, 3\) array"),
        (dict(vertices=[[0, 0, 0], [1, 1]], faces=[]), r"\(n, 3\) array"),
        (dict(vertices=[[0, 0, "x"]], faces=[]), "vertex 0, coordinate 2 is 'x'"),
        (dict(vertices=[[10**400, 0, 0]], faces=[]), "vertex 0, coordinate 0 is inf"),
        (dict(vertices=TRIANGLE, faces=None), "faces is None"),
        (dict(vertices=TRIANGLE, faces=[[0, 1, 2], [0, 1.7, 2, 1]]), "face 1 is"),
        (dict(vertices=TRIANGLE, faces=[[0, 1, 3]]), "face 0 is .0, 1, 3., but there are 3 vertices"),
        (dict(vertices=TRIANGLE, faces=[[0, 1, 2], [0, -1, 2]]), "face 1 is"),
        (dict(vertices=TRIANGLE, faces=np.array([[0.0, 1.0, 2.0]])), "integer"),
        (dict(vertices=TRIANGLE, faces=[], edges=[[0, 1], [1, 7]]), "edge 1 is .1, 7."),
        (dict(vertices=TRIANGLE, faces=[], edges=[[0, 1, 2]]), "edges have shape"),
    ],
)
def test_bad_input_is_named(arguments, says):
    with pytest.raises(fc.InputError, match=f"lid: .*{says}"):
        fc.Polyhedron(**arguments, name="lid")


def test_an_open_mesh_is_no_solid():
    body = g.box()
    with pytest.raises(fc.InputError, match=r"lid: solid=True, but the mesh is open .*vertices \[0, 1\]"):
        fc.Polyhedron(body.v, [f for f in body.f if not {0, 1} <= set(f)] + [[0, 1, 5]], solid=True, name="lid")
    assert not fc.Polyhedron(body.v, body.f[1:]).solid
    assert fc.Polyhedron(body.v, body.f, solid=True).solid
    assert not fc.Polyhedron(body.v, body.f, solid=False).solid


def test_inside_out_and_unoriented_meshes_are_solid():
    body = g.box()
    assert fc.Polyhedron(body.v, [f[::-1] for f in body.f]).solid
    assert fc.Polyhedron(body.v, [f[::-1] if k % 3 else f for k, f in enumerate(body.f)]).solid


def test_bodies_do_not_change():
    body = fc.Polyhedron(SQUARE, [[0, 1, 2, 3]])
    for array in (body.vertices, body.triangles, body.edges):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    mine = np.array(SQUARE, float)
    other = fc.Polyhedron(mine, [[0, 1, 2, 3]])
    mine[0] = 99
    assert other.vertices[0].tolist() == [0, 0, 0]


# ------------------------------------------------------------------------------------------- exact placement


def fractions_of(body: fc.Polyhedron) -> list[tuple[Fraction, ...]]:
    return [tuple(Fraction(int(x.p), int(x.q)) for x in body.exact_vertex(i)) for i in range(len(body.vertices))]


def assert_error_holds(body: fc.Polyhedron) -> None:
    for true, double in zip(fractions_of(body), body.vertices.tolist(), strict=True):
        for x, y in zip(true, double, strict=True):
            assert abs(x - Fraction(y)) <= Fraction(body.error)


MIXED = [["1/3", "0.1", 2], [Fraction(1, 7), -5, 0], [7, 0, "-2/9"]]


def test_numbers_stay_what_they_are():
    body = fc.Polyhedron(MIXED, [[0, 1, 2]])
    assert fractions_of(body)[0] == (Fraction(1, 3), Fraction(1, 10), Fraction(2))
    assert fractions_of(body)[2] == (Fraction(7), Fraction(0), Fraction(-2, 9))
    assert 0 < body.error < 1e-15
    assert_error_holds(body)
    doubles = fc.Polyhedron([[0.1, 1 / 3, 2.5]], [])
    assert doubles.error == 0 and fractions_of(doubles)[0] == tuple(map(Fraction, (0.1, 1 / 3, 2.5)))
    small = fc.Polyhedron(np.array([[0.1, 0.2, 0.3]], np.float32), [])
    assert fractions_of(small)[0] == tuple(Fraction(float(np.float32(x))) for x in (0.1, 0.2, 0.3))
    whole = fc.Polyhedron([[2**60 + 1, 0, 0]], [])
    assert fractions_of(whole)[0][0] == 2**60 + 1 and whole.error > 0


def test_numbers_of_several_kinds_in_one_list():
    """Each stays what it is: no common type for the whole list."""
    body = fc.Polyhedron([[2**60 + 1, 0.5, "1/3"], [0.1, Fraction(1, 10), 0]], [])
    assert fractions_of(body) == [
        (Fraction(2**60 + 1), Fraction(1, 2), Fraction(1, 3)),
        (Fraction(0.1), Fraction(1, 10), Fraction(0)),
    ]
    long = fc.Polyhedron(np.array([[1, 2, 3]], np.longdouble) / 3, [])
    assert fractions_of(long)[0][2] == 1
    assert abs(fractions_of(long)[0][0] - Fraction(1, 3)) <= Fraction(1, 2**53)


def random_body(seed: int) -> fc.Polyhedron:
    return fc.Polyhedron(np.random.default_rng(seed).uniform(-9, 9, (12, 3)), [[0, 1, 2]])


@pytest.mark.parametrize("v", [(0.1, 0.2, -0.3), ("1/3", 0, 0), (2.0**40, 1e-9, 0)])
def test_translated_is_exact(v):
    body = random_body(1)
    moved = body.translated(v)
    shift = [Fraction(x) for x in v]
    truth = [tuple(x + s for x, s in zip(p, shift, strict=True)) for p in fractions_of(body)]
    assert fractions_of(moved) == truth
    assert_error_holds(moved)


def test_maps_that_doubles_hold_leave_no_error():
    body = fc.examples.box((1, 2, 3))
    for exact in (
        body.translated((0.5, 3, -7)),
        body.rotated((0, 0, 1), degrees=90),
        body.rotated((0, 2, 0), degrees=-180, point=(1, 0, 0.25)),
        body.transformed(np.diag([2.0, -4.0, 0.125, 1.0])),
        body.rotated((1, 0, 0), degrees=90).translated((1, 2, 3)).rotated((0, 0, 1), degrees=270),
    ):
        assert exact.error == 0
        assert fractions_of(exact) == [tuple(map(Fraction, p)) for p in exact.vertices.tolist()]
    assert body.rotated((0, 0, 1), degrees=90).vertices.tolist() == [[-y, x, z] for x, y, z in body.vertices.tolist()]


def test_a_map_that_only_looks_exact_is_not():
    """0.1 + 2^60 rounds: the body keeps the sum, and knows its error."""
    moved = fc.Polyhedron([[0.1, 0, 0]], []).translated((2.0**60, 0, 0))
    assert moved.error > 0
    assert fractions_of(moved)[0][0] == Fraction(0.1) + 2**60
    assert_error_holds(moved)


@pytest.mark.parametrize("degrees", [30, "22.5", 123.456, -1, 359, 1e-9])
@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 2, 2), (0.3, -1, 0.7)])
def test_rotated_is_rational_rigid_and_close(axis, degrees):
    body = random_body(2)
    turned = body.rotated(axis, degrees=degrees, point=(1, 0, 2))
    before, after = fractions_of(body), fractions_of(turned)
    for i in range(3):  # exactly rigid
        assert distance2(before[i], before[i + 1]) == distance2(after[i], after[i + 1])
        assert distance2(before[i], (1, 0, 2)) == distance2(after[i], (1, 0, 2))
    assert_error_holds(turned)
    pose = fc.Rotation(axis, point=(1, 0, 2), degrees=degrees)(1.0)
    truth = body.vertices @ pose[:3, :3].T + pose[:3, 3]
    assert np.abs(turned.vertices - truth).max() < 1e-13


def distance2(p, q) -> Fraction:
    return sum(((x - y) ** 2 for x, y in zip(p, q, strict=True)), Fraction(0))


@pytest.mark.parametrize("degrees", [90, 180, 270, 360, 720, -90])
def test_quarter_turns_about_rational_axes_are_exact(degrees):
    """(1, 2, 2) has length 3, so its quarter turns are rational; by hand from Rodrigues' formula."""
    body = random_body(3)
    h = [Fraction(1, 3), Fraction(2, 3), Fraction(2, 3)]
    c, s = {0: (1, 0), 90: (0, 1), 180: (-1, 0), 270: (0, -1)}[degrees % 360]
    truth = []
    for p in fractions_of(body):
        along = sum(x * y for x, y in zip(h, p, strict=True))
        side = [h[1] * p[2] - h[2] * p[1], h[2] * p[0] - h[0] * p[2], h[0] * p[1] - h[1] * p[0]]
        truth.append(tuple(c * x + s * y + (1 - c) * along * k for x, y, k in zip(p, side, h, strict=True)))
    assert fractions_of(body.rotated((1, 2, 2), degrees=degrees)) == truth


def test_transformed_composes_exactly():
    rng = np.random.default_rng(5)
    body = fc.Polyhedron(MIXED, [[0, 1, 2]])
    matrices = [np.vstack([rng.uniform(-1, 1, (3, 4)), [0, 0, 0, 1]]) for _ in range(3)]
    moved, truth = body, fractions_of(body)
    for m in matrices:
        moved = moved.transformed(m)
        rows = [[Fraction(x) for x in row] for row in m[:3].tolist()]
        truth = [tuple(sum(a * b for a, b in zip(row, (*p, 1), strict=True)) for row in rows) for p in truth]
    assert fractions_of(moved) == truth
    assert_error_holds(moved)


def test_mirrored_bodies_stay_solid_and_meet_at_the_mirrored_place():
    body = fc.Polyhedron(*(lambda b: (b.v, b.f))(g.icosphere(1, 1.0, 0.1, 3)))
    mirror = np.diag([-1.0, 1.0, 1.0, 1.0])
    wall = fc.examples.box((1, 9, 9)).translated((5, 0, 0))
    right = fc.first_contact(body.moving(fc.Translation((9, 0, 0))), wall)
    left = fc.first_contact(body.transformed(mirror).moving(fc.Translation((-9, 0, 0))), wall.transformed(mirror))
    assert body.transformed(mirror).solid and body.transformed(mirror).error == 0
    assert right.time == left.time and right.element_a.index == left.element_a.index
    assert (right.point * [-1, 1, 1]).tolist() == left.point.tolist()
    assert (right.normal * [-1, 1, 1] == left.normal).all()


@pytest.mark.parametrize(
    ("matrix", "says"),
    [
        (np.zeros((4, 4)), "last row"),
        (np.diag([1, 1, 0, 1]), "singular"),
        (np.eye(3), "4x4"),
        (np.diag([1, math.nan, 1, 1]), r"matrix\[1\]\[1\]"),
        (np.diag([1.0, 1, 1, 2]), "last row"),
        (np.diag([1e200, 1, 1, 1]), "range"),
    ],
)
def test_bad_maps_are_named(matrix, says):
    with pytest.raises(fc.InputError, match=says):
        fc.Polyhedron(SQUARE, [[0, 1, 2]]).transformed(matrix)


def test_a_zero_axis_is_refused():
    with pytest.raises(fc.InputError, match="axis is zero"):
        fc.Polyhedron(SQUARE, [[0, 1, 2]]).rotated((0, 0, 0), degrees=10)


# ------------------------------------------------------------------------------------------ loading, pickling


def test_load_welds_equal_corners_and_nothing_else(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    corners = np.array(g.CORNERS, float)
    soup = np.concatenate([corners[list(f)] for f in g.box().f])
    mesh = trimesh.Trimesh(soup, np.arange(len(soup)).reshape(-1, 3), process=False)
    mesh.export(tmp_path / "cube.stl")
    cube = fc.Polyhedron.load(tmp_path / "cube.stl")
    assert len(cube.vertices) == 8 and cube.solid and len(cube.edges) == 18 and cube.name == "cube"
    soup[0] += [1e-6, 0, 0]
    trimesh.Trimesh(soup, mesh.faces, process=False).export(tmp_path / "gap.stl")
    assert not fc.Polyhedron.load(tmp_path / "gap.stl").closed


def test_trimesh_and_back():
    pytest.importorskip("trimesh")
    body = random_body(6)
    again = fc.Polyhedron.from_trimesh(body.to_trimesh(), name="again")
    assert np.array_equal(again.vertices, body.vertices) and again.name == "again"
    assert np.array_equal(again.triangles, body.triangles)


@pytest.mark.share(2)
@pytest.mark.parametrize(
    "body",
    [
        fc.examples.box((1, 2, 3)),
        fc.Polyhedron(MIXED, [[0, 1, 2]], name="mixed").rotated((1, 1, 1), degrees=10),
        fc.Polyhedron(SQUARE, [], edges=[[0, 2]]).translated(("1/3", 0, 0)),
        random_body(7).moving(
            fc.Sequence([fc.Translation(("1/3", 0, 0)), fc.Rotation((1, 1, 1), turns="1/7")], [1, "2/3"])
        ),
    ],
)
def test_bodies_survive_pickling(body):
    again = pickle.loads(pickle.dumps(body))
    old, new = (x.body if isinstance(x, fc.Moving) else x for x in (body, again))
    assert np.array_equal(old.vertices, new.vertices) and old.error == new.error and old.name == new.name
    assert np.array_equal(old.edges, new.edges) and np.array_equal(old.triangles, new.triangles)
    assert fractions_of(old) == fractions_of(new) and old.solid == new.solid
    assert repr(again) == repr(body)
    target = fc.examples.box((1, 1, 1)).translated((30, 0, 0))
    moving, its = (x if isinstance(x, fc.Moving) else x.moving(fc.Translation((60, 0, 0))) for x in (body, again))
    one, two = fc.first_contact(moving, target), fc.first_contact(its, target)
    assert (one.status, one.time, one.time_interval) == (two.status, two.time, two.time_interval)


def test_names_and_poses():
    body = fc.examples.box((1, 1, 1)).named("pin")
    assert body.name == "pin" and body.at(0.5) is body
    moving = body.moving(fc.Translation((2, 0, 0)))
    assert moving.name == "pin" and moving.named("other").name == "other" and body.name == "pin"
    assert np.array_equal(moving.at(0.5).vertices, body.vertices + [1, 0, 0])
    with pytest.raises(fc.InputError, match="is no motion"):
        body.moving("left")


# --------------------------------------------------------------------------------------------------- bounds

TURNS = [
    fc.Translation((3, -2, 1)),
    fc.Rotation((0, 0, 1), point=(1, 0, 0), turns=1),
    fc.Rotation((1, 2, -1), point=(0, 3, 0), degrees=200),
    fc.Rotation((1, 1, 1), turns=64),
    fc.Rotation((0, 0, 1), turns=-100.5),
    fc.Sequence([fc.Translation((1, 0, 0)), fc.Rotation((0, 1, 0), degrees=90), fc.Translation((0, 0, 5))]),
    fc.Sequence([fc.Translation((100, 0, 0)), fc.Translation((-100, 0, 0)), fc.Translation((0, 0, 1))],
                durations=[1e-3, 1e-3, 1]),
]  # fmt: skip


@pytest.mark.share(9)
@pytest.mark.parametrize("motion", TURNS, ids=str)
@pytest.mark.parametrize("part", [1.0, 0.37])
def test_bounds_hold_the_moving_body(motion, part):
    body = random_body(8).translated((5, 0, 0))
    span = (0.0, motion.span[1] * part)
    lo, hi = body.moving(motion).bounds(span)
    fine = np.concatenate([np.linspace(*span, 4001), np.linspace(0, min(3e-3, span[1]), 301)])
    for t in fine:
        pose = motion(float(t))
        points = body.vertices @ pose[:3, :3].T + pose[:3, 3]
        slack = 1e-12
        assert np.all(points.min(axis=0) >= lo - slack) and np.all(points.max(axis=0) <= hi + slack), t
    assert np.all(hi - lo < 400)


def test_bounds_of_a_body_at_rest():
    body = fc.Polyhedron(MIXED, [[0, 1, 2]])
    lo, hi = body.bounds()
    for p in fractions_of(body):
        assert all(Fraction(a) <= x <= Fraction(b) for a, x, b in zip(lo.tolist(), p, hi.tolist(), strict=True))


def test_bounds_are_the_callers_own():
    """They are kept on the body, and what a caller does to them is not."""
    box = fc.examples.box((2, 2, 2))
    before = [x.copy() for x in box.bounds()]
    box.bounds()[0][:] = 7
    assert all(np.array_equal(x, y) for x, y in zip(box.bounds(), before, strict=True))
