"""What is said of bodies that touch, overlap thinly or nearly touch at the start, or hold one another.

Scenes are made in a frame in which the answer is plain: one body below the plane z = 0, one above it, both with the
origin on their surface and their insides right below and above it; the upper one is then moved by -g along z.
"""

from __future__ import annotations

from fractions import Fraction as F
from itertools import product
from random import Random

import numpy as np
import pytest

import firstcontact as fc
from standing_bodies import STANDING, UPSIDE_DOWN, half_turn

REST = fc.Translation((0, 0, 0))
INITIAL = fc.Status.INITIAL_CONTACT


def test_no_cone_is_walked_into_its_axis():
    """A large flat ellipsoid on a frustum, whose function has kinks where Newton's method may stay."""
    scene = "frustum", "flat ellipsoid", F(1, 10**18), (3, -3, -2), F(2) ** 40, (0, 0, 0)
    judge(*scene[:3], fc.first_contact(*pair(*scene), exact=True))


def test_the_rim_stands_on_its_lowest_point():
    lo, hi = STANDING["rim"].bounds()
    assert abs(lo[2]) < 1e-12 and hi[2] > 1 and STANDING["rim"].contains((0, 0, 0))


def pair(lower, upper, g, turn=(1, 0, 0), scale=F(1), motion=(0, 0, 0)):
    """(a, b) with b above and moving; all under one half-turn and one scale."""
    a = STANDING[lower].transformed(UPSIDE_DOWN)
    b = STANDING[upper].translated((0, 0, -g))
    m = half_turn(turn)
    placed = [[x * scale for x in row] for row in m[:3]] + [m[3]]
    way = [scale * sum(m[i][j] * motion[j] for j in range(3)) for i in range(3)]
    return a.transformed(placed), b.transformed(placed).moving(fc.Translation(way))


def strictly_inside(body, point):
    """By the signs of the surfaces' forms, in whole numbers."""
    x = [*map(F, point), F(1)]
    for surface in body.surfaces:
        rows = [[F(int(c.p), int(c.q)) for c in row] for row in surface.matrix()]
        if not sum(x[i] * rows[i][j] * x[j] for i in range(4) for j in range(4)) < 0:
            return False
    return True


def judge(lower, upper, g, hit):
    if g < 0:
        assert hit.status is fc.Status.FREE
    else:
        assert (hit.status, hit.initial, hit.time) == (INITIAL, "overlapping" if g > 0 else "touching", 0)
        assert hit.time_interval == (0, 0) and not np.signbit(hit.time) and hit.free_until == 0


def scenes(count, seed):
    rng = np.random.default_rng(seed)
    names, gaps = list(STANDING), [F(0), *(s * F(1, 10**k) for s in (1, -1) for k in (3, 7, 12, 18, 30))]
    for _ in range(count):
        lower, upper = (names[k] for k in rng.integers(len(names), size=2))
        g, turn = gaps[rng.integers(len(gaps))], tuple(int(x) for x in rng.integers(-4, 5, size=3))
        motion = [(0, 0, 0), (0, 0, 1)][rng.integers(2)]
        scale = [F(1), F(2) ** 40, F(1, 2**40)][rng.integers(3)]
        yield lower, upper, g, turn if any(turn) else (1, 2, 3), scale, motion


@pytest.mark.share(16)
@pytest.mark.parametrize("scene", list(scenes(16, 1)), ids=str)
def test_depths_and_gaps_of_any_size(scene):
    lower, upper, g, *rest = scene
    a, b = pair(*scene)
    if g > 0:
        middle = (0, 0, -g / 2)
        assert strictly_inside(STANDING[lower].transformed(UPSIDE_DOWN), middle)
        assert strictly_inside(STANDING[upper].translated((0, 0, -g)), middle)
    judge(lower, upper, g, fc.first_contact(a, b))
    judge(lower, upper, g, fc.first_contact(b, a))
    judge(lower, upper, g, fc.first_contact(a, b, exact=True))


def test_a_thin_lens_is_no_free_start():
    """Depth 1e-7 in a ball of 20, both turned by the angle with cosine 3/5; with the motion towards and away."""
    turn = [["3/5", "-4/5", 0, 0], ["4/5", "3/5", 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    a = fc.sphere(20).transformed(turn)
    b = fc.cylinder(5, 10).translated((25 - F(1, 10**7), 0, 0)).transformed(turn)
    for way, exact in (((1, 0, 0), False), ((-1, 0, 0), False), ((-1, 0, 0), True)):
        hit = fc.first_contact(a.moving(fc.Translation(way)), b, exact=exact)
        assert (hit.status, hit.initial) == (INITIAL, "overlapping")
    (interval,) = fc.contact_intervals(a.moving(fc.Translation((-1, 0, 0))), b)
    assert interval.start_interval == (0, 0) and 1.6e-7 < interval.end < 1.7e-7


def test_bodies_that_part_soon_began_in_contact():
    s = F(1, 10**4)
    a = fc.cylinder(s, 2 * s).translated(((2 - F(1, 1000)) * s, 0, 0)).moving(fc.Translation((s, 0, 0)))
    b = fc.sphere(s)
    for hit in (fc.first_contact(a, b), fc.first_contact(b, a), fc.first_contact(a, b, exact=True)):
        assert (hit.status, hit.initial, str(hit.time)) == (INITIAL, "overlapping", "0.0")
    assert fc.contact_intervals(a, b)[0].start_interval == (0, 0)


@pytest.mark.parametrize("exact", [False, True])
def test_a_rim_that_touches_a_lying_cylinder_in_one_point(exact):
    b = fc.cylinder(2, 6).rotated((0, 1, 0), degrees=90).translated((0, -1, 2))
    for a in (fc.cylinder(1, 2).translated((0, 0, -1)), fc.cone(1, 2).transformed(UPSIDE_DOWN)):
        assert fc.first_contact(a, b.moving(REST), exact=exact).initial == "touching"


def test_a_ball_that_fills_a_room_touches_its_wall():
    for room in (fc.sphere(2) - fc.sphere(1), fc.box((4, 4, 4)) - fc.sphere(1)):
        hit = fc.first_contact(room, fc.sphere(1).moving(REST))
        assert (hit.status, hit.initial) == (INITIAL, "touching")


HOLDING = {
    "ball": (fc.sphere(2), (0, 0, 0), (0, 0, 2)),
    "ellipsoid": (fc.ellipsoid((1, 2, 3)), (0, 0, 0), (0, 2, 0)),
    "cylinder": (fc.cylinder(2, 6), (1, 0, 1), (0, 2, 0)),
    "cone": (fc.cone(2, 3), (0, 0, 1), (0, 0, 3)),
    "box": (fc.box((2, 3, 4)), (0, 0, 1), (1, F(3, 2), 2)),
    "mesh": (fc.examples.box((2, 2, 2)), (0, 0, 0), (1, 0, 0)),
}


def shrunk(body, centre, k):
    """By the factor k towards the centre."""
    rows = [[k if i == j else 0 for j in range(3)] + [(1 - k) * centre[i]] for i in range(3)]
    return body.transformed([*rows, [0, 0, 0, 1]])


@pytest.mark.share(6)
@pytest.mark.parametrize("name", HOLDING)
def test_one_in_the_other(name):
    """Containment where the surfaces are apart; not for equal bodies, nor where they touch from inside."""
    body, inner, border = HOLDING[name]
    turn = half_turn((1, 2, 3))
    for other, word in (
        (shrunk(body, inner, F(1, 2)), "containment"), (shrunk(body, inner, 1 - F(1, 10**9)), "containment"),
        (shrunk(body, border, F(1, 2)), "overlapping"), (body, "overlapping"),
    ):  # fmt: skip
        a, b = other.transformed(turn), body.transformed(turn)
        assert fc.first_contact(a, b.moving(fc.Translation((0, 0, 1)))).initial == word
        assert fc.first_contact(b, a.moving(REST), exact=True).initial == word


def test_bounds_of_a_large_turned_ellipsoid():
    """Its box scales with it, exactly by powers of two."""
    turn = half_turn((-2, 2, -2))
    body, large = (
        STANDING["flat ellipsoid"].transformed([[x * F(2) ** k for x in row] for row in turn[:3]] + [turn[3]])
        for k in (0, 60)
    )
    assert np.allclose(np.array(large.bounds()) / 2.0**60, body.bounds(), rtol=1e-9)


def quarter_turned(x, axis, point, advance):
    """x after a quarter turn about an axis with a rational length, and a way along it; by Rodrigues' formula."""
    length = F(np.sqrt(float(sum(c * c for c in axis)))).limit_denominator(1000)
    k = [c / length for c in axis]
    y = [p - q for p, q in zip(x, point, strict=True)]
    along = sum(p * q for p, q in zip(k, y, strict=True))
    side = k[1] * y[2] - k[2] * y[1], k[2] * y[0] - k[0] * y[2], k[0] * y[1] - k[1] * y[0]
    return [q + along * c + s + advance * c for q, c, s in zip(point, k, side, strict=True)]


AXES = [(F(-2, 9), F(16, 9), F(8, 9)), (F(1), F(2), F(2)), (F(2, 7), F(-3, 7), F(6, 7)), (F(0), F(3), F(-4))]


@pytest.mark.share(3)
@pytest.mark.parametrize("seed, kind", [(0, "solid"), (1, "mesh")])
def test_a_corner_on_a_plane_a_quarter_turn_into_a_screw(seed, kind):
    """Poses of screws are rational there, though their doubles are rounded."""
    r = Random(seed)
    axis, n = r.choice(AXES), r.choice([(F(-3, 7), F(2, 7), F(6, 7)), (F(1, 9), F(4, 9), F(-8, 9)), (0, 0, F(1))])
    point, advance = [F(r.randint(-9, 9), 3) for _ in range(3)], F(r.randint(-9, 9), 2)
    pose = half_turn([r.randint(1, 5) for _ in range(3)])
    sizes = [F(r.randint(1, 9), 2) for _ in range(3)]
    if kind == "solid":
        body = fc.box(tuple(sizes))
    else:
        body = fc.examples.box((1, 1, 1)).transformed(np.diag([*map(float, sizes), 1.0]))
    corners = [[s * c / 2 for s, c in zip(sizes, signs, strict=True)] for signs in product((-1, 1), repeat=3)]
    placed = [[sum(m * c for m, c in zip(row, x, strict=False)) for row in pose[:3]] for x in corners]
    ends = [quarter_turned(x, axis, point, advance) for x in placed]
    lowest = min(sum(p * q for p, q in zip(n, x, strict=True)) for x in ends)
    mover = fc.Screw(axis, point, degrees=360, advance=4 * advance)
    for depth, kinds in ((0, ("touching",)), (F(1, 1000), ("overlapping",)), (F(1, 10**15), ("overlapping", None))):
        hit = fc.first_contact(fc.half_space(n, lowest + depth), body.transformed(pose).moving(mover), (0.25, 1))
        assert hit.status is INITIAL and hit.initial in kinds


def test_a_screw_that_begins_in_an_irrational_pose_tells_deep_overlaps():
    """Where rounded poses cannot change the word."""
    ring, turn = fc.cylinder(3, 2) - fc.cylinder(1, 4), fc.Screw((0, 0, 1), degrees=100, advance=1)
    for body, word in ((fc.box((1, 1, 1)).translated((2, 0, -1)), "overlapping"),
                       (fc.sphere("1/4").translated((2, 0, 0)), "containment")):  # fmt: skip
        assert fc.first_contact(body.moving(turn), ring, (0.125, 1)).initial == word
        assert fc.first_contact(ring, body.moving(turn), (0.125, 1)).initial == word


def test_a_corner_that_only_touches_a_half_space_at_a_quarter_turn():
    a = fc.half_space((F(-3, 7), F(2, 7), F(6, 7)), -0.25).transformed([
        [F(22, 455), F(-1559, 1820), F(-227, 364), F(14, 5)],
        [F(-549, 910), F(-661, 1820), F(137, 182), F(1, 5)],
        [F(-173, 260), F(57, 130), F(-17, 26), F(157, 80)],
        [0, 0, 0, 1],
    ])  # fmt: skip
    b = fc.examples.box((8, 5.5, 3)).transformed([
        [F(-6137, 49815), F(-40943, 39852), F(-93961, 199260), F(-1545211, 265680)],
        [F(-13289, 199260), F(-3047, 9963), F(40763, 49815), F(227063, 66420)],
        [F(-52987, 49815), F(9503, 39852), F(1666, 49815), F(519259, 265680)],
        [0, 0, 0, 1],
    ])  # fmt: skip
    screw = fc.Screw((F(-2, 9), F(16, 9), F(8, 9)), (-2, -6, -1), degrees=-360, advance=-3.5)
    hit = fc.first_contact(a, b.moving(screw), (0.25, 1))
    assert (hit.status, hit.initial) == (INITIAL, "touching")


def test_a_small_cone_touches_an_ellipsoid_as_a_screw_starts():
    """A rational plane through the lowest point of the rim has the bodies on either side."""
    cone = fc.cone(F(3, 425984), F(5, 1703936)).transformed(
        [[F(434, 507), F(167, 507), F(-202, 507), F(-80973155, 3455582208)],
         [F(7, 507), F(-398, 507), F(-314, 507), F(-270029417, 17277911040)],
         [F(-262, 507), F(266, 507), F(-343, 507), F(31927, 34555822080)], [0, 0, 0, 1]])  # fmt: skip
    screw = fc.Screw((F(-12, 7), F(6, 7), F(4, 7)), (-0.0390625, -0.0078125, -0.0234375), turns=-0.25,
                     advance=0.0859375)  # fmt: skip
    ellipsoid = fc.ellipsoid((0.5, 0.15625, 0.15625)).transformed(
        [[F(-74, 435), F(19, 87), F(418, 435), F(-1933, 723840)], [F(19, 87), F(-82, 87), F(22, 87), F(-9527, 72384)],
         [F(418, 435), F(22, 87), F(49, 435), F(-81481, 180960)], [0, 0, 0, 1]])  # fmt: skip
    assert fc.first_contact(cone.moving(screw), ellipsoid).initial == "touching"


def test_a_tiny_ellipsoid_touches_a_ball_as_a_turn_starts():
    ball = fc.sphere(0.0625).transformed(
        [[F(79612, 113985), F(76784, 113985), F(-5509, 22797), F(15, 272)],
         [F(8324, 22797), F(-14267, 22797), F(-15712, 22797), F(-1, 34)],
         [F(-4127, 6705), F(2636, 6705), F(-916, 1341), 0], [0, 0, 0, 1]])  # fmt: skip
    tiny = fc.ellipsoid((F(1, 5242880), 4.76837158203125e-07, 7.152557373046875e-07)).transformed(
        [[0, 1, 0, F(-40959, 2621440)], [-1, 0, 0, F(-3276797, 26214400)], [0, 0, 1, 0], [0, 0, 0, 1]])  # fmt: skip
    turn = fc.Rotation((0, 0, 15), (-0.0703125, -0.0546875, 0.0234375), degrees=-1080)
    assert fc.first_contact(ball, tiny.moving(turn), (0.25, 1)).initial == "touching"


def test_an_apex_in_the_bowl_of_a_hyperboloid_at_the_origin():
    """The bowl's lowest point is the origin, and its box was told to end above it."""
    bowl = fc.hyperboloid((F(288, 65), F(288, 65), 2), F(91, 10), sheets=2).translated((0, 0, -2))
    for depth in (F(15, 468374361246531584), F(1, 10**6), F(1, 10)):
        cone = fc.cone(F(15, 13), F(25, 52)).translated((0, 0, depth - F(25, 52))).moving(fc.Translation((0, 0, 0.5)))
        for method in ("auto", "algebraic"):
            hit = fc.first_contact(cone, bowl, method=method)
            assert (hit.status, hit.initial) == (fc.Status.INITIAL_CONTACT, "overlapping")


ABOVE = {
    "ball": fc.sphere(1).translated((0, 0, 1)),
    "can": fc.cylinder(1, 2).translated((0, 0, 1)),
    "lying can": fc.cylinder(1, 2).rotated((1, 0, 0), degrees=90).translated((0, 0, 1)),
    "tip": fc.frustum(0, 1, 1),
    "wide tip": fc.frustum(0, 3, 1),
    "bowl": fc.paraboloid((1, 1), 1),
    "egg": fc.ellipsoid((1, 2, 1)).translated((0, 0, 1)),
    "sheet": fc.hyperboloid((1, 1, 1), 2, sheets=2).translated((0, 0, -1)),
}
"""Solids in z >= 0 that hold the origin: there all terms of a form vanish, its rounding error too."""


@pytest.mark.share(8)
@pytest.mark.parametrize("name", ABOVE)
def test_touching_at_the_origin_is_no_overlap(name):
    upside_down = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]
    cone = fc.cone(1, 1).translated((0, 0, -1))
    for body in [*(other.transformed(upside_down) for other in ABOVE.values()), cone]:
        hit = fc.first_contact(ABOVE[name], body)
        assert hit.status is INITIAL and hit.initial == "touching", body
        deeper = fc.first_contact(ABOVE[name], body.translated((0, 0, F(1, 2**20))))
        assert deeper.initial == "overlapping", body
