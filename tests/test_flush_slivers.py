"""Flush caps that share a thin sliver of their plane, or miss by as little: true by construction, down to 1e-16."""

import random
from fractions import Fraction

import pytest

import firstcontact as fc

F = Fraction
WAYS = [(F(3, 5), F(4, 5)), (F(-7, 25), F(-24, 25))]
DEPTHS = [F(0), *(sign * F(1, 10**k) for k in (3, 6, 9, 13, 16) for sign in (1, -1))]


def _disc(way, distance):
    """A cylinder of radius 1 that stands on the plane z = 1/2, so far from the axis."""
    return fc.cylinder(1, 1).translated((*(distance * x for x in way), 1))


def _turned(body, way):
    """By the rotation that takes the x axis to the way."""
    c, s = way
    return body.transformed([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])


def _scenes(way, depth):
    ring = fc.cylinder(3, 1) - fc.cylinder(2, 2)
    box = _turned(fc.box((2, 2, 1)).translated((2 - depth, 0, 1)), way)
    corner = _turned(fc.box((2, 2, 1)).translated((2 - depth, 1, 1)), way)
    disc = fc.cylinder(1, 1)
    yield "disc beside disc", _disc(way, 2 - depth), disc
    yield "disc in a hole", _disc(way, 1 + depth), ring
    yield "disc beside a ring", _disc(way, 4 - depth), ring
    yield "side of a box", box, disc
    yield "corner of a box", corner, disc


@pytest.mark.thorough
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("depth", DEPTHS, ids=lambda x: f"{float(x):g}")
def test_touch_at_rest_is_told(way, depth):
    for name, a, b in _scenes(way, depth):
        near = name == "corner of a box" and -F(1, 10**12) < depth < 0
        allowed = {"INITIAL_CONTACT"} if depth >= 0 else {"FREE", "UNDECIDED"} if near else {"FREE"}
        for pair in ((a, b), (b, a)):
            hit = fc.first_contact(*pair)
            assert hit.status.name in allowed, (name, depth, way)
            assert depth < 0 or hit.initial == "touching"


@pytest.mark.share(4)
@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("depth", [F(1, 10**k) for k in (2, 5, 7, 10)], ids=lambda x: f"{float(x):g}")
def test_intervals_of_discs_that_slide_past_each_other(depth, exact):
    (x, y), far = WAYS[0], 2 - depth
    start = -far * y - 5 * x, far * x - 5 * y, 1
    passing = fc.cylinder(1, 1).translated(start).moving(fc.Translation((10 * x, 10 * y, 0)))
    found = fc.contact_intervals(passing, fc.cylinder(1, 1), exact=exact)
    reach = float(4 - far * far) ** 0.5 / 10
    assert [(x.start, x.end) for x in found] == [pytest.approx((0.5 - reach, 0.5 + reach), abs=1e-13)]


def _ellipse(columns, centre, z):
    """A cylinder of height 1 over the image of the unit disc."""
    (a, c), (b, d) = columns
    placed = [[a, b, 0, centre[0]], [c, d, 0, centre[1]], [0, 0, 1, z], [0, 0, 0, 1]]
    return fc.cylinder(1, 1).transformed(placed)


@pytest.mark.share(18)
@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("depth", [F(0), *(s * F(1, 10**k) for k in (4, 8, 12) for s in (1, -1))], ids=float)
def test_ellipses_in_one_plane(seed, depth):
    """Built about a common tangent: n is normal to both in p, and the second one is shifted along n."""
    rng = random.Random(seed)
    pick = [F(rng.randint(-9, 9), rng.randint(1, 5)) for _ in range(12)]
    n, p = (pick[0] or 1, pick[1] or 2), pick[2:4]
    square, across = n[0] ** 2 + n[1] ** 2, (-n[1], n[0])

    def columns(v, w):
        """Of a matrix B with B^T n = v."""
        return [[n[i] * v[k] / square + across[i] * w[k] for i in range(2)] for k in range(2)]

    bodies = []
    for v, w, way, shift in (((F(3, 5), F(4, 5)), pick[4:6], 1, 0), ((F(5, 13), F(-12, 13)), pick[6:8], -1, depth)):
        if v[0] * w[1] == v[1] * w[0]:
            w = w[0] + 1, w[1]
        b = columns(v, w)
        edge = [b[0][i] * v[0] + b[1][i] * v[1] for i in range(2)]  # where n is normal, seen from the centre
        bodies.append(_ellipse(b, [p[i] - way * edge[i] - shift * n[i] for i in range(2)], len(bodies)))
    for pair in (bodies, bodies[::-1]):
        assert fc.first_contact(*pair).status.name == ("INITIAL_CONTACT" if depth >= 0 else "FREE")


@pytest.mark.thorough
@pytest.mark.parametrize("depth", [F(0), *(s * F(1, 10**k) for k in (3, 9, 11, 13, 17) for s in (1, -1))], ids=float)
def test_a_lid_and_a_pin_about_the_axis_of_a_hole(depth):
    """Circles about one centre, whose forms are nearly the same all along."""
    plate = fc.box((8, 8, 2)) - fc.cylinder(1, 4)
    for a in (fc.cylinder(1 + depth, 2), fc.cylinder(1 + depth, 1).translated((0, 0, F(3, 2)))):
        for pair in ((a, plate), (plate, a)):
            assert fc.first_contact(*pair).status.name == ("INITIAL_CONTACT" if depth >= 0 else "FREE")


@pytest.mark.share(4)
@pytest.mark.parametrize("depth", [F(1, 10**k) for k in (4, 9, 11, 13)], ids=float)
def test_a_lid_that_is_nearly_round_touches_the_rim_where_it_is_longer(depth):
    """An ellipse with the half diameters 1 + depth and 1 - depth over a hole of radius 1: it crosses the rim."""
    plate = fc.box((8, 8, 2)) - fc.cylinder(1, 4)
    lid = fc.cylinder(1, 1).transformed([[1 + depth, 0, 0, 0], [0, 1 - depth, 0, 0], [0, 0, 1, F(3, 2)], [0, 0, 0, 1]])
    for pair in ((lid, plate), (plate, lid)):
        assert fc.first_contact(*pair).status.name in ("INITIAL_CONTACT", "UNDECIDED")
