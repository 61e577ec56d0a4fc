"""Flat ruled pieces that move in one plane, against closed forms and against distances of sampled points."""

from __future__ import annotations

import math
import random
from fractions import Fraction as F

import numpy as np
import pytest
from scipy.spatial import cKDTree

import firstcontact as fc
from amount import amount
from firstcontact.contact.ruled.in_one_plane import _NORMAL, _WALLS, _normal_of, _walls_of

UP = (0, 0, 1)
CIRCLE = "(1 - u**2)/(1 + u**2), 2*u/(1 + u**2)"
DISC = "(0, 0, 0)", f"({CIRCLE}, 0)", None
STRIP = "(u, 0, 0)", "(u, 1, 0)", (0, 1)
PIECES = [
    DISC, STRIP, ("(1/2, 1/3, 0)", f"({CIRCLE}, 0)", None), ("(0, 0, 0)", f"({CIRCLE}, 0)", (F(-1, 2), 1)),
    ("((1 - u**2)/(1 + u**2)/2, u/(1 + u**2), 0)", f"({CIRCLE}, 0)", None),
    ("(u, u**2, 0)", "(u + 1/2, 2, 0)", (0, 1)), ("(u, u**2/2 - 1/2, 0)", "(u, 1 + u/3 - u**2/4, 0)", (-1, 1)),
]  # fmt: skip
"""Directrices and the range of u."""
FOLD = "(u - 1, u**2 - 2*u, 0)", "(u + 1, u**2 + 2*u, 0)", (-1, 1)
"""Its rulings touch a parabola in their middle."""


def piece(first, second, u, name=None):
    return fc.RuledSurface(first, second, u=u, name=name)


def turn(degrees, point=(0, 0, 0)):
    return fc.Rotation(UP, point, degrees=degrees)


def ways(found):
    return [x.way for x in found.stats.ways]


@pytest.mark.parametrize("low, then, point, met", [
    (2, math.acos(2 / 3), (1, math.sqrt(5), 0), ("end_ruling", 1)),  # its centre is 1 beside the end x = 1
    (F(5, 2), math.atan2(15, 6) - math.acos(15.25 / math.hypot(15, 6)), (1, 2.5, 0), ("vertex", 2)),
])  # fmt: skip
def test_a_disc_that_turns_meets_a_side_or_a_corner_of_a_sheet(low, then, point, met):
    """Of radius 1, its centre at radius 3, which is 1 from (1, 5/2) where 6 cos + 15 sin = 15 1/4."""
    disc = piece(*DISC, name="disc").translated((3, 0, 0)).moving(turn(90))
    sheet = piece(*STRIP, name="sheet").translated((0, low, 0))
    for a, b in ((disc, sheet), (sheet, disc)):
        hit = fc.first_contact(a, b)
        assert ways(hit)[0] == "in one plane"
        assert hit.time == pytest.approx(then / (math.pi / 2), abs=1e-11)
        assert hit.time_interval[1] - hit.time_interval[0] < 1e-11
        assert hit.point == pytest.approx(point, abs=1e-9)
        names = {e.body: (e.kind, e.index) for e in (hit.element_a, hit.element_b)}
        assert names == {"disc": ("directrix", 1), "sheet": met}


def test_a_plate_holds_a_coin_for_a_while():
    """The coin, of radius 1/2, comes round at radius 6; the plate reaches from 5 to 7 and from x = -2 to 2."""
    coin = piece("(0, 0, 0)", "((1 - u**2)/(1 + u**2)/2, u/(1 + u**2), 0)", None).translated((6, 0, 0))
    plate = piece("(u, 5, 0)", "(u, 7, 0)", (-2, 2))
    (x,) = fc.contact_intervals(coin.moving(turn(180)), plate)
    start = math.acos(2.5 / 6) / math.pi  # its centre is 1/2 beside the end x = 2
    assert (x.start, x.end) == pytest.approx((start, 1 - start), abs=1e-9)
    held = coin.moving(turn(10, (6, 0, 0)))
    around = piece("(u, -3, 0)", "(u, 3, 0)", (3, 9))
    assert fc.first_contact(held, around).status.name == "INITIAL_CONTACT"
    assert [(y.start, y.end) for y in fc.contact_intervals(held, around)] == [(0, 1)]


def test_one_inside_a_hole_is_free():
    ring = piece("(2*(1 - u**2)/(1 + u**2), 4*u/(1 + u**2), 0)", "(3*(1 - u**2)/(1 + u**2), 6*u/(1 + u**2), 0)", None)
    coin = piece("(0, 0, 0)", "((1 - u**2)/(1 + u**2)/2, u/(1 + u**2), 0)", None).translated((1, 0, 0))
    for a, b in ((coin.moving(turn(300)), ring), (ring.moving(turn(77)), coin.moving(turn(-40)))):
        assert fc.first_contact(a, b).status.name == "FREE"
        assert fc.contact_intervals(a, b).status.name == "FREE"


def test_folds_and_what_is_not_flat_have_no_walls():
    tangents = piece(*FOLD)
    normal = _NORMAL.of(tangents, lambda: _normal_of(tangents))
    assert normal and _WALLS.of(tangents, lambda: _walls_of(tangents, normal)) == ()
    assert _normal_of(fc.RuledSurface("(u, 0, 0)", "(u, 1, u)")) == ()
    assert _normal_of(fc.RuledSurface("(u, 0, 0)", "(u, 1, 0)", trim=["u*s <= 1/2"])) == ()


def test_a_fold_is_met_first():
    """All of the rulings touch y = u^2 from below, so that the piece ends there, between its directrices."""
    fold = piece(*FOLD)
    point = piece("(u, 0, 0)", "(u, 1/4, 0)", (F(-1, 100), F(1, 100))).translated((0, 1, 0))
    hit = fc.first_contact(point.moving(fc.Sequence([fc.Translation((0, -2, 0)), turn(20)])), fold)
    assert hit.status.name == "UNDECIDED" or hit.time == pytest.approx(F(1, 4), abs=0.01)


def points_of(piece, many=40):
    first, second, u = piece
    surface = fc.RuledSurface(first, second, u=u)
    ends = np.tan(np.linspace(-1.5707, 1.5707, 5 * many)) if u is None else np.linspace(*map(float, u), 5 * many)
    s = np.linspace(0, 1, many)
    return surface.points(*np.meshgrid(ends, s)).reshape(-1, 3)


def motion(rng):
    point = (rng.randint(-4, 4), rng.randint(-4, 4), 0)
    own = fc.Translation((rng.randint(-5, 5), rng.randint(-5, 5), 0))
    around = turn(rng.choice([-90, 45, 77, 120, -200]), point)
    return rng.choice([None, own, around, fc.Sequence([own, turn(45, point)])])


@pytest.mark.parametrize("seed", range(amount(40)))
def test_random_pieces_against_sampled_points(seed):
    rng = random.Random(f"in one plane {seed}")
    shapes = [rng.choice(PIECES) for _ in range(2)]
    places = [(rng.randint(-4, 4), rng.randint(-4, 4), 0) for _ in range(2)]
    motions = [motion(rng) or turn(30), motion(rng)]
    bodies = [piece(*x).translated(p) for x, p in zip(shapes, places, strict=True)]
    moving = [x if m is None else x.moving(m) for x, m in zip(bodies, motions, strict=True)]
    times = np.linspace(0, 1, 81)
    sampled = [points_of(x) + p for x, p in zip(shapes, places, strict=True)]
    gaps = np.array([_gap(sampled, motions, t) for t in times])
    hit, swapped = fc.first_contact(*moving), fc.first_contact(*moving[::-1])
    found = fc.contact_intervals(*moving)
    assert hit.status is swapped.status and (hit.time is None or abs(hit.time - swapped.time) < 1e-9)
    if hit.status.name == "FREE":
        assert gaps.min() > 0.004
    elif hit.time is not None:
        assert (gaps[times < hit.time - 1e-3] > 0.004).all()
        assert _gap(sampled, motions, hit.time) < 0.1
    if found.status.name != "UNDECIDED":
        for t, gap in zip(times, gaps, strict=True):
            near = any(x.start - 2e-3 < t < x.end + 2e-3 for x in found)
            within = any(x.start + 2e-3 < t < x.end - 2e-3 for x in found)
            assert gap > 0.004 or near
            assert gap < 0.1 or not within


def _gap(sampled, motions, t):
    one, two = (
        p if m is None else p @ np.asarray(m(t))[:3, :3].T + np.asarray(m(t))[:3, 3]
        for p, m in zip(sampled, motions, strict=True)
    )
    return cKDTree(one).query(two)[0].min()
