"""Flush caps that share a thin sliver of their plane, or miss by as little: true by construction, down to 1e-16."""

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


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("depth", [F(1, 10**k) for k in (2, 5, 7, 10)], ids=lambda x: f"{float(x):g}")
def test_intervals_of_discs_that_slide_past_each_other(depth, exact):
    (x, y), far = WAYS[0], 2 - depth
    start = -far * y - 5 * x, far * x - 5 * y, 1
    passing = fc.cylinder(1, 1).translated(start).moving(fc.Translation((10 * x, 10 * y, 0)))
    found = fc.contact_intervals(passing, fc.cylinder(1, 1), exact=exact)
    reach = float(4 - far * far) ** 0.5 / 10
    assert [(x.start, x.end) for x in found] == [pytest.approx((0.5 - reach, 0.5 + reach), abs=1e-13)]


def test_two_ellipses_in_one_plane():
    """Images of two discs under a shear and a stretch that keep the plane."""
    image = [[2, F(1, 3), 0, 0], [0, F(1, 2), 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    for depth in (F(1, 10**7), F(0), -F(1, 10**7)):
        a, b = (x.transformed(image) for x in (_disc(WAYS[0], 2 - depth), fc.cylinder(1, 1)))
        assert fc.first_contact(a, b).status.name == ("FREE" if depth < 0 else "INITIAL_CONTACT")
