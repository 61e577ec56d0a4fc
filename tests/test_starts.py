"""What is said of bodies that touch, overlap thinly or nearly touch at the start, or hold one another.

Scenes are made in a frame in which the answer is plain: one body below the plane z = 0, one above it, both with the
origin on their surface and their insides right below and above it; the upper one is then moved by -g along z.
"""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc

REST = fc.Translation((0, 0, 0))
INITIAL = fc.Status.INITIAL_CONTACT
LYING = [[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]
UPSIDE_DOWN = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]

# Bodies above z = 0 that touch it at the origin.
STANDING = {
    "ball": fc.sphere(20).translated((0, 0, 20)),
    "small ball": fc.sphere("1/7").translated((0, 0, "1/7")),
    "ellipsoid": fc.ellipsoid((1, 2, 3)).translated((0, 0, 3)),
    "flat ellipsoid": fc.ellipsoid((30, 2, "1/3")).translated((0, 0, "1/3")),
    "cylinder": fc.cylinder(5, 10).translated((1, 1, 5)),
    "cylinder on its side": fc.cylinder(5, 10).transformed(LYING).translated((1, 0, 5)),
    "rim": fc.cylinder(2, 6).transformed([["3/5", 0, "4/5", 0], [0, 1, 0, 0], ["-4/5", 0, "3/5", 0], [0, 0, 0, 1]])
    .translated(("6/5", 0, "17/5")),
    "cone": fc.cone(3, 4),
    "tip": fc.cone(1, 2).transformed(UPSIDE_DOWN).translated((0, 0, 2)),
    "frustum": fc.frustum(1, 2, 3),
    "bowl": fc.paraboloid((1, 2), 3),
    "box": fc.box((2, 3, 4)).translated((0, 0, 2)),
}  # fmt: skip


def half_turn(n):
    """By 180 degrees about n, as a rational matrix."""
    size = sum(x * x for x in n)
    return [[F(2 * n[i] * n[j], size) - (i == j) for j in range(3)] + [0] for i in range(3)] + [[0, 0, 0, 1]]


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
