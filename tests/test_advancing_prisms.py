"""Prisms that turn about their direction and advance along it: against separating axes of their bases, and heights."""

from fractions import Fraction as F
from itertools import product

import numpy as np
import pytest

import firstcontact as fc
from amount import amount

ACROSS = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])


def block(middle, size, box=fc.examples.box):
    """A box, and its corners (4, 2) seen along z with its least and greatest height."""
    (x, y, z), (dx, dy, dz) = middle, size
    corners = np.array([x, y]) + ACROSS * [dx / 2, dy / 2]
    return box(size).translated(middle), (corners, z - dz / 2, z + dz / 2)


def turned(corners, degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return corners @ np.array([[c, s], [-s, c]])


def gap(p, q):
    """Of two rectangles: the greatest distance along a normal of a side, below 0 where they overlap."""
    normals = [np.array([-e[1], e[0]]) / np.hypot(*e) for c in (p, q) for e in np.diff(c[:3], axis=0)]
    apart = [max((q @ n).min() - (p @ n).max(), (p @ n).min() - (q @ n).max()) for n in normals]
    return max(apart)


def distance(a, b, degrees, advance, t):
    (p, low, high), (q, least, most) = a, b
    return max(gap(turned(p, degrees * t), q), least - high - advance * t, low + advance * t - most)


def test_boxes_flush_at_the_side():
    """Their sides lie in one plane at half the time; trees took 5 s of the processor, or did not tell."""
    a = fc.examples.box((2, 2, 2)).translated((0, -4, -1)).moving(fc.Screw((0, 0, 1), degrees=180, advance=1))
    b = fc.examples.box((2, 2, 4)).translated((2, 0, 0))
    (x,) = fc.contact_intervals(a, b)
    # the side at a distance of 3 from the axis passes the corner at (3, -1)
    start = np.degrees(np.arcsin(3 / np.sqrt(10)) - np.arctan2(1, 3)) / 180
    assert (x.start, x.end) == pytest.approx((start, 1 - start), abs=1e-14)
    assert [(y.start, y.end) for y in fc.contact_intervals(b, a)] == [(x.start, x.end)]


def test_solids_of_planes_flush_at_the_side():
    """UNDECIDED: gradients of both sides are parallel all along the edge, and a screw has no rational poses."""
    a = fc.box((2, 2, 2)).translated((0, -4, -1)).moving(fc.Screw((0, 0, 1), degrees=180, advance=1))
    b = fc.box((2, 2, 4)).translated((2, 0, 0))
    start = np.degrees(np.arcsin(3 / np.sqrt(10)) - np.arctan2(1, 3)) / 180
    for pair in ((a, b), (b, a)):
        (x,) = fc.contact_intervals(*pair)
        assert (x.start, x.end) == pytest.approx((start, 1 - start), abs=1e-14)
        hit = fc.first_contact(*pair)
        assert hit.time == pytest.approx(start, abs=1e-14) and hit.point[:2] == pytest.approx((3, -1))
        assert {hit.element_a.label, hit.element_b.label} == {"x+/y+/z-", "x+"}
        assert hit.contact_set is None


@pytest.mark.share(2)
@pytest.mark.parametrize("cut", ["drilled", "rounded"])
def test_solids_with_round_walls_flush_at_the_side(cut):
    """Intervals were UNDECIDED from half the time on, where sides come flush."""
    box, r = fc.box((2, 2, 2)), F(11, 10)
    body = box - fc.cylinder("1/2", 4) if cut == "drilled" else box & fc.cylinder(r, 2)
    moving = body.translated((0, -4, -1)).moving(fc.Screw((0, 0, 1), degrees=180, advance=1))
    (x,) = fc.contact_intervals(moving, fc.box((2, 2, 4)).translated((2, 0, 0)))
    # the corner at (3, -1) comes to the side, or before its end to the round wall about (0, -4)
    angle = np.arcsin(3 / np.sqrt(10)) - np.arctan2(1, 3)
    if cut == "rounded":  # as far as r from the middle of the wall, 4 from the axis
        angle = np.arctan2(-1, 3) + np.pi / 2 - np.arccos((10 + 16 - float(r) ** 2) / (8 * np.sqrt(10)))
    assert (x.start, x.end) == pytest.approx((np.degrees(angle) / 180, 1 - np.degrees(angle) / 180), abs=1e-12)


@pytest.mark.share(5)
@pytest.mark.parametrize("seed", range(amount(300, 20)))
def test_boxes_on_a_screw(seed):
    rng = np.random.default_rng(seed)
    size_a, size_b = rng.integers(1, 4, (2, 3)).tolist()
    box = fc.box if seed % 3 == 0 else fc.examples.box
    a, flat_a = block([int(rng.integers(2, 5)), int(rng.integers(-1, 2)), int(rng.integers(-3, 1))], size_a, box)
    b, flat_b = block([int(rng.integers(-2, 3)), int(rng.integers(2, 5)), int(rng.integers(-1, 2))], size_b, box)
    degrees, advance = int(rng.choice([90, 180, 270, 360])), F(int(rng.integers(-6, 7)), 2)
    scale = int(rng.integers(1, 3))
    moving = a.moving(fc.Screw((0, 0, scale), degrees=degrees, advance=advance))
    pair = (moving, b) if seed % 2 else (b, moving)
    found = fc.contact_intervals(*pair)
    assert found.reason is None
    ends = [0.0, *(t for x in found for t in (x.start, x.end)), 1.0]
    for k, (lo, hi) in enumerate(zip(ends, ends[1:], strict=False)):
        for t in lo + (hi - lo) * np.array([1e-6, 0.1, 0.35, 0.6, 0.9, 1 - 1e-6]):
            d = distance(flat_a, flat_b, degrees, float(advance), t)
            assert d < 1e-12 if k % 2 else d > -1e-12 or lo == hi, (t, d, found)
    for x in found:
        inside = [distance(flat_a, flat_b, degrees, float(advance), t) for t in (x.start, x.end)]
        assert max(inside) < 1e-12


@pytest.mark.parametrize(("advance", "status", "window"), [
    (4, fc.Status.CONTACT, (F(1, 2), F(1))),  # lands on the heights of the other when its sides overlap already
    (-1, fc.Status.FREE, None),
    (F(2), fc.Status.CONTACT, (F(1), F(1))),
])  # fmt: skip
def test_one_that_turns_in_place_rises_to_the_other(advance, status, window):
    post = fc.examples.box((1, 1, 2)).translated((0, 0, -3)).moving(fc.Screw((0, 0, 1), degrees=90, advance=advance))
    found = fc.contact_intervals(post, fc.examples.box((4, 4, 2)).translated((0, 0, 1)))
    assert found.status is status and [(x.start, x.end) for x in found] == ([] if window is None else [window])


def test_two_screws_and_a_shift():
    """The heights meet from 1/4 on; until then nothing is shared, and with a shift along the axis it is the same."""
    a, b = fc.examples.box((1, 1, 1)), fc.examples.box((1, 1, 1)).translated((0, 0, 2))
    up, down = fc.Screw((0, 0, 1), turns=1, advance=2), fc.Screw((0, 0, -2), turns="1/2", advance=2)
    for one, other in product((up, fc.Translation((0, 0, 2))), (down, fc.Translation((0, 0, -2)))):
        (x,) = fc.contact_intervals(a.moving(one), b.moving(other))
        assert (x.start, x.end) == (0.25, 0.75)
