"""Flat meshes that touch, cross or miss a solid by next to nothing at the start.

In a frame in which the answer is plain: a triangle below the plane z = 0 that holds the origin, and a solid above it
with the origin on its surface, moved by -g along z.  So the origin is inside for g > 0, and z = 0 parts them for g < 0.
"""

from __future__ import annotations

from fractions import Fraction as F
from itertools import product
from random import Random

import pytest

import firstcontact as fc
from standing_bodies import STANDING, half_turn

INITIAL = fc.Status.INITIAL_CONTACT
HOLED = {
    "plate": (fc.box((6, 6, 4)) - fc.cylinder(1, 9)).translated((2, 0, 2)),
    "hollow ball": (fc.sphere(20) - fc.sphere(5)).translated((0, 0, 20)),
    "ring": (fc.cylinder(5, 4) - fc.cylinder(1, 9)).translated((3, 0, 2)),
}
FLAT = {
    "tip": [(0, 0, 0), (70, -30, -90), (-20, 80, -60)],
    "edge": [(90, 60, 0), (-60, -40, 0), (10, 0, -80)],
    "face": [(90, 80, 0), (-100, 70, 0), (10, -90, 0)],
}
DEPTHS = [s * F(1, 10**k) for s in (1, -1) for k in (3, 8, 11, 13, 15, 16, 18, 25, 40)]


def judge(g, hit, words=("overlapping",)):
    if g < 0:
        assert hit.status is fc.Status.FREE
    else:
        assert hit.status is INITIAL and hit.time == 0 and hit.initial in words


def turned(r):
    """A half turn, as a matrix, and with a shift: so that no coordinate is a double."""
    m = half_turn([r.randint(1, 4) * r.choice((-1, 1)) for _ in range(3)])
    return [[*row[:3], F(r.randint(-40, 40), 7)] for row in m[:3]] + [m[3]]


def scenes(count, seed):
    r = Random(seed)
    for k in range(count):
        yield list(FLAT)[k % 3], r.choice(list(STANDING)), r.choice(DEPTHS), r.randint(0, 10**6)


@pytest.mark.share(8)
@pytest.mark.parametrize("flat, name, g, seed", list(scenes(24, 3)))
def test_depths_and_gaps_of_any_size(flat, name, g, seed):
    r = Random(seed)
    pose = turned(r)
    mesh = fc.Polyhedron(FLAT[flat], [[0, 1, 2]]).transformed(pose)
    body = STANDING[name].translated((0, 0, -g)).transformed(pose)
    up = [row[2] for row in pose[:3]]
    still = fc.Translation((0, 0, 0))
    scene = [(mesh.moving(still), body), (body.moving(fc.Translation(up)), mesh)][r.randint(0, 1)]
    judge(g, fc.first_contact(*scene))
    if seed % 3 == 0:
        judge(g, fc.first_contact(*scene, exact=True))


@pytest.mark.share(6)
@pytest.mark.parametrize("flat", FLAT)
@pytest.mark.parametrize("name", HOLED)
def test_solids_with_holes(flat, name):
    mesh = fc.Polyhedron(FLAT[flat], [[0, 1, 2]])
    pose = turned(Random(len(name)))
    for g in (F(1, 10**15), F(-1, 10**15)):
        body = HOLED[name].translated((0, 0, -g))
        hit = fc.first_contact(mesh.transformed(pose).moving(fc.Translation((0, 0, 0))), body.transformed(pose))
        judge(g, hit, ("overlapping", None))


@pytest.mark.share(5)
@pytest.mark.parametrize("flat", ["tip", "face"])
@pytest.mark.parametrize("k", [8, 13, 16, 25])
def test_starts_in_irrational_poses(flat, k):
    """The mesh turns about z, so all of it keeps its height; a screw takes it down."""
    mesh = fc.Polyhedron(FLAT[flat], [[0, 1, 2]])
    for g in (F(1, 10**k), F(-1, 10**k)):
        body = STANDING["small ball"].translated((0, 0, -g))
        turn = fc.Rotation((0, 0, 1), degrees=50)
        judge_at(g, fc.first_contact(mesh.moving(turn), body, (0.25, 0.75)), 0.25)
        if g < 0:
            continue  # under a screw nothing is exact
        screw = fc.Screw((0, 0, 1), degrees=50, advance=-4)
        judge_at(g, fc.first_contact(body, mesh.translated((0, 0, 1)).moving(screw), (0.25, 0.75)), 0.25)


def judge_at(g, hit, t):
    if g < 0:
        assert hit.status is fc.Status.FREE
    else:
        assert hit.status is INITIAL and hit.time == t and hit.initial in ("overlapping", None)


def test_the_tip_of_a_triangle_is_inside_a_cylinder_by_next_to_nothing():
    x = F(3071999999999987, 998400000000000)
    a = fc.cylinder(8, 2.5).translated((x, F(3071999999999987, 416000000000000), 0.625))
    b = fc.Polyhedron([(0, 0, 0), (0.75, 0, 0), (-3, 5, 0)], [[0, 1, 2]]).transformed([
        [F(-1782, 2275), F(141, 455), F(1226, 2275), F(-8871, 2275)],
        [F(-274, 455), F(-54, 91), F(-243, 455), F(528, 455)],
        [F(27, 175), F(-26, 35), F(114, 175), F(731, 175)],
        [0, 0, 0, 1],
    ])  # fmt: skip
    still, aside = fc.Translation((0, 0, 0)), fc.Translation((1, 0, 0))
    for hit in (fc.first_contact(a.moving(still), b), fc.first_contact(a, b.moving(aside)),
                fc.first_contact(b.moving(aside), a, exact=True)):  # fmt: skip
        assert (hit.status, hit.initial, hit.time) == (INITIAL, "overlapping", 0)


def test_a_bowl_and_a_ball_that_overlap_by_rounding():
    a = fc.paraboloid(1, 8).translated((F(-83, 26), F(443, 312), F(-313, 576)))
    b = fc.sphere(1).transformed([
        [F(-85526, 91767), F(-9638, 91767), F(2449, 7059), F(-16104872267476893761, 6088866696204910592)],
        [F(-9638, 91767), F(-76883, 91767), F(-3782, 7059), F(120408239637377580731, 73066400354458927104)],
        [F(2449, 7059), F(-3782, 7059), F(418, 543), F(-666532744850833395, 468374361246531584)],
        [0, 0, 0, 1],
    ])  # fmt: skip
    b = b.moving(fc.Translation((-0.75, 1, F(-5, 39))))
    for method in ("auto", "algebraic"):
        hit = fc.first_contact(a, b, method=method)
        assert (hit.status, hit.initial) == (INITIAL, "overlapping")


@pytest.mark.parametrize("shift", [(0, 0, 0), (1, 0, 0), (0, F(1, 8), 0), (0, 0, 1)])
def test_an_edge_across_a_cap_meets_its_rim_all_the_time(shift):
    """In the plane of the cap the edge crosses the rim at every instant, so no root of an equation tells."""
    edge, pin = fc.Polyhedron([(-3, 0, 1), (3, 0, 1)], [], edges=[(0, 1)]), fc.cylinder(1, 2)
    moving = edge.moving(fc.Translation(shift)) if any(shift) else edge
    for exact in (False, True):
        hit = fc.first_contact(moving, pin, exact=exact)
        assert hit.status is fc.Status.INITIAL_CONTACT and hit.initial in (None, "touching")
        assert hit.point[2] == 1.0 and abs(hit.point[0]) <= 1.0


@pytest.mark.parametrize("swap", [False, True])
def test_the_normal_where_an_edge_lands_across_a_cap(swap):
    edge, pin = fc.Polyhedron([(-3, 0, 2), (3, 0, 2)], [], edges=[(0, 1)]), fc.cylinder(1, 2)
    landing = edge.moving(fc.Translation((0, 0, -1)))
    hit = fc.first_contact(*((pin, landing) if swap else (landing, pin)))
    assert hit.time == 1.0 and hit.normal.tolist() == pytest.approx([0, 0, -1 if swap else 1], abs=1e-15)


def test_a_corner_on_a_side_is_no_inner_point():
    """A quarter turn about an oblique axis has brought a corner of the triangle onto the side of the frustum."""
    k = F(1, 2**40)
    frustum = fc.frustum(F(29, 5629499534213120), F(1, 2**48), F(3, 1407374883553280)).transformed([
        [F(7, 65), F(-24, 25), F(-84, 325), F(-44087, 17592186044416000)],
        [F(-24, 25), F(-21, 125), F(28, 125), F(-1600609, 703687441776640000)],
        [F(-84, 325), F(28, 125), F(-1527, 1625), F(480203, 175921860444160000)],
        [0, 0, 0, 1],
    ])  # fmt: skip
    triangle = fc.Polyhedron([(0, 0, 0), (F(3, 4) * k, 0, 0), (k, F(11, 4) * k, 0)], [[0, 1, 2]]).transformed([
        [F(476, 2349), F(1093, 2349), F(-2024, 2349), F(-1921, 10331011254583296)],
        [F(-11080, 30537), F(130232, 152685), F(57299, 152685), F(-998303, 167878932886978560)],
        [F(27775, 30537), F(36124, 152685), F(52168, 152685), F(305017, 83939466443489280)],
        [0, 0, 0, 1],
    ])  # fmt: skip
    a = frustum.moving(fc.Translation((7 * k, 6 * k, -6 * k)))
    b = triangle.moving(fc.Rotation((F(2, 3), F(-1, 3), F(-2, 3)), (-k / 2, F(-11, 2) * k, F(3, 2) * k), turns=-5))
    hit = fc.first_contact(a, b, (0.25, 1))
    assert hit.status is INITIAL and hit.initial in (None, "touching")


ON_THE_BALL = [(F(2, 3), F(2, 3), F(1, 3)), (F(6, 7), F(-2, 7), F(3, 7)), (0, 0, -1)]


@pytest.mark.parametrize("at", ON_THE_BALL)
@pytest.mark.parametrize("swap", [False, True], ids=["", "swapped"])
def test_points_and_edges_that_touch_are_told_so(at, swap):
    """An edge in the tangent plane, the point alone, and both a little deeper."""
    x, y, z = at
    across = (y, -x, 0) if (x, y) != (0, 0) else (1, 0, 0)
    ends = [tuple(c + k * d for c, d in zip(at, across, strict=True)) for k in (-1, 2)]
    point, edge = fc.Polyhedron([at], []), fc.Polyhedron(ends, [], edges=[(0, 1)])
    ball = fc.sphere(1)
    for body, deeper in ((point, "containment"), (edge, "overlapping")):
        for other, kind in ((ball, "touching"), (fc.sphere(1 + F(1, 2**30)), deeper)):
            hit = fc.first_contact(*((other, body) if swap else (body, other)))
            assert hit.status is INITIAL and hit.initial == kind, (body, kind)


def test_a_point_at_a_tip_is_not_told_more_than_is_proved():
    point, cone = fc.Polyhedron([(0, 0, 1)], []), fc.cone(1, 1)
    assert cone.vertices[0].position == (0, 0, 1)
    hit = fc.first_contact(point, cone)
    assert hit.status is INITIAL and hit.initial in (None, "touching")


@pytest.mark.parametrize("exact", [False, True])
def test_places_whose_common_denominator_leaves_the_doubles(exact):
    """Found by the soak: an eighth of a turn has rounded poses; a flat piece and a solid that stands on its plane."""
    piece = fc.Polyhedron([(0, F(5, 2), 0), (0, F(1, 2), 0), (2, F(1, 2), 0), (2, F(5, 2), 0)], [[0, 1, 2], [0, 2, 3]])
    solid = fc.Polyhedron([(0, 2, 0), (1, 2, 0), (0, 4, 0), (0, 2, 3)], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    turning = solid.moving(fc.Rotation((0, 0, 1), (0, 1, -2), turns=F(-1, 4)))
    for a, b in ((piece, turning), (turning, piece)):
        assert fc.first_contact(a, b, (F(1, 2), 1), exact=exact).initial == "touching"


def _least_height(p, q):
    """The least |x| + |y| + |z| on the segment: at an end, or where a coordinate is 0."""
    times = [F(0), F(1), *(F(a, a - b) for a, b in zip(p, q, strict=True) if a * b < 0)]
    return min(sum(abs(a + t * (b - a)) for a, b in zip(p, q, strict=True)) for t in times)


def test_bare_edges_through_tips_edges_and_faces_of_an_octahedron():
    """Found by the soak: a pin through two tips was told to touch."""
    rng, seen = Random(5), set()
    tips = [tuple(2 * s * (k == j) for j in range(3)) for k in range(3) for s in (1, -1)]
    signs = list(product((1, -1), repeat=3))
    faces = [[(1 - x) // 2, 2 + (1 - y) // 2, 4 + (1 - z) // 2][:: x * y * z] for x, y, z in signs]
    octahedron = fc.Polyhedron(tips, faces)
    for _ in range(300):
        p, q = ([rng.choice((-3, -2, -1, 0, 0, 0, 0, 1, 2, 3)) for _ in range(3)] for _ in "pq")
        height = _least_height(p, q)
        if p == q or height > 2:
            continue
        known = "overlapping" if height < 2 else "touching"
        if all(sum(map(abs, end)) < 2 for end in (p, q)):
            known = "containment"
        seen.add(known)
        pin = fc.Polyhedron([p, q], [], edges=[[0, 1]]).moving(fc.Translation((1, 2, 3)))
        for a, b in ((pin, octahedron), (octahedron, pin)):
            assert fc.first_contact(a, b).initial == known, (p, q)
    assert seen == {"overlapping", "touching", "containment"}


def test_bare_points_too_small_for_doubles():
    """Found by the soak: an IndexError; a point in a box of 2^-300, whose signs kernels leave open."""
    u = F(1, 2**300)
    corners = [(x * u, y * u, z * u) for z in (0, 2) for x, y in ((0, 0), (1, 0), (1, 4), (0, 4))]
    sides = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    box = fc.Polyhedron(corners, [half for p, q, r, s in sides for half in ([p, q, r], [p, r, s])])
    for place, known in (((1, 2, 1), "touching"), ((1, 4, 2), "touching"), ((F(1, 2), 2, 1), "containment")):
        points = fc.Polyhedron([tuple(c * u for c in place)] * 2, [])
        for a, b in ((box, points), (points, box)):
            assert fc.first_contact(a.moving(fc.Translation((0, 0, 10 * u))), b).initial == known


@pytest.mark.share(4)
@pytest.mark.parametrize("method", ["auto", "certified", "algebraic"])
@pytest.mark.parametrize("away", [(0, 0, 0), (-3, -3, 3), (5, 0, -1)])
def test_a_corner_on_a_disc_about_a_tip(away, method):
    """The corner is the middle of the cone's base, the bodies are on the two sides of its plane: they touch there.

    Right there the function of the cone has no gradient, which ended in an error where the origin is elsewhere.
    """
    corners = [(-1, 0, 1), (0, 0, 0), (-1, 1, 0), (-1, -1, -1)]
    wedge = fc.Polyhedron(corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]).translated(away)
    cone = fc.cone(1, 2).rotated((0, 1, 0), degrees=90).translated(away)
    found = fc.first_contact(wedge.moving(fc.Translation((1, 0, 0))), cone, method=method)
    assert found.status is INITIAL and found.initial == "touching" and found.point.tolist() == list(away)
