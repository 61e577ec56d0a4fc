"""When moving boxes meet: never said too late, never denied."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from amount import amount
from firstcontact.kernels.angle import TWO_PI
from firstcontact.kernels.lifted.boxes import CLIP_EPS, clip_to_box, segment_meets_box
from firstcontact.search.trees.cylinder import COLUMNS, range_of_box
from firstcontact.search.trees.rotate import angle_window, entry_angle
from firstcontact.search.trees.translate import entry_time, slab_window

INF = math.inf


def random_boxes(rng, n: int, kind: str) -> np.ndarray:
    if kind == "lattice":
        centre, half = rng.integers(-4, 5, (n, 3)), rng.integers(0, 3, (n, 3))
    else:
        centre, half = rng.uniform(-4, 4, (n, 3)), rng.uniform(0, 1, (n, 3)) ** 3
    return np.concatenate([centre - half, centre + half], axis=1).astype(float)


def exact_window(box_a, box_b, v, slack: Fraction):
    """The closed times at which box_a + t v comes within `slack` of box_b in every axis; None for never."""
    lo, hi = None, None
    for k in range(3):
        ahead = Fraction(box_b[k]) - Fraction(box_a[k + 3]) - slack
        behind = Fraction(box_b[k + 3]) - Fraction(box_a[k]) + slack
        if v[k] == 0:
            if ahead > 0 or behind < 0:
                return None
            continue
        t0, t1 = sorted((ahead / Fraction(v[k]), behind / Fraction(v[k])))
        lo, hi = (t0 if lo is None else max(lo, t0)), (t1 if hi is None else min(hi, t1))
    return (-INF if lo is None else lo, INF if hi is None else hi) if lo is None or lo <= hi else None


def motion_of(v) -> np.ndarray:
    with np.errstate(divide="ignore"):
        return np.concatenate([v, 1.0 / np.array(v)])


@pytest.mark.share(2)
@pytest.mark.parametrize("kind", ["random", "lattice"])
def test_entry_time_is_never_late(kind):
    rng = np.random.default_rng(91)
    n = amount(6000, 3)
    boxes_a, boxes_b = random_boxes(rng, n, kind), random_boxes(rng, n, kind)
    met = missed = sharp = 0
    for k in range(n):
        v = rng.integers(-2, 3, 3).astype(float) if kind == "lattice" else rng.uniform(-2, 2, 3)
        if kind == "random" and k % 2:  # aim
            v = (boxes_b[k, :3] - boxes_a[k, :3] + rng.uniform(-0.5, 0.5, 3)) / rng.uniform(0.2, 1.5)
        pad = float(rng.choice([0.0, 1e-12, 0.25]))
        first = float(rng.choice([0.0, 0.25, 0.75]))
        last = first + float(rng.choice([0.0, 0.5, INF]))
        got = entry_time(motion_of(v), boxes_a, k, boxes_b, k, pad, first, last)
        near = exact_window(boxes_a[k], boxes_b[k], v, Fraction(pad) / 2)  # half the pad is for roundings
        if near is not None and near[0] <= last and near[1] >= first:
            met += 1
            assert got <= max(near[0], first)
            grown = exact_window(boxes_a[k], boxes_b[k], v, Fraction(pad))
            sharp += got >= max(float(grown[0]), first) * (1 - 1e-14) - 1e-300
        else:
            missed += got == INF
    assert met > n / 12 and missed > n / 12 and sharp == met


@pytest.mark.share(2)
@pytest.mark.parametrize("kind", ["random", "lattice"])
def test_slab_window_encloses(kind):
    rng = np.random.default_rng(92)
    n = amount(5000, 3)
    boxes_a, boxes_b = random_boxes(rng, n, kind), random_boxes(rng, n, kind)
    met = missed = 0
    for k in range(n):
        v = rng.integers(-2, 3, 3).astype(float) if kind == "lattice" else rng.uniform(-2, 2, 3)
        if kind == "random" and k % 2:
            v = (boxes_b[k, :3] - boxes_a[k, :3]) / rng.uniform(0.2, 1.5)
        pad, last = float(rng.choice([0.0, 0.25])), float(rng.choice([1.0, 3.0, INF]))
        entry, leave = slab_window(boxes_a[k], boxes_b[k], motion_of(v), pad, last)
        near = exact_window(boxes_a[k], boxes_b[k], v, Fraction(pad) / 2)
        if near is not None and near[0] <= last and near[1] >= 0:
            met += 1
            assert entry <= max(near[0], 0) and leave >= min(near[1], last)
        else:
            missed += entry == INF
    assert met > 100 and missed > 500


# ------------------------------------------------------------------------------------------------- rotation


def planted(rng, kind: str):
    """Boxes a, b and the angle at which a point of a, turned about (cx, cy), lies in b."""
    if kind == "lattice":
        lo, size = rng.integers(-3, 4, 3).astype(float), rng.integers(0, 3, 3).astype(float)
        centre = rng.integers(-1, 2, 2).astype(float)
        quarter = int(rng.integers(4))
        phi = quarter * math.pi / 2
        c, s = [(1, 0), (0, 1), (-1, 0), (0, -1)][quarter]
    else:
        lo, size = rng.uniform(-3, 3, 3), rng.uniform(0, 1, 3) ** 2 * rng.choice([0.05, 1, 4])
        centre = rng.uniform(-1, 1, 2)
        phi = float(rng.uniform(0, 2 * math.pi))
        c, s = math.cos(phi), math.sin(phi)
    inner = rng.choice([0.0, 1.0, 0.5], 3) if rng.integers(2) else rng.uniform(0, 1, 3)
    p = lo + inner * size
    x, y = p[:2] - centre
    q = np.array([centre[0] + c * x - s * y, centre[1] + s * x + c * y, p[2]])
    if kind == "lattice":
        down, up = rng.integers(0, 2, 3), rng.integers(0, 2, 3)
    else:
        down, up = (rng.uniform(0, 1, 3) ** 2 * rng.choice([0.0, 0.05, 2]) for _ in range(2))
    return np.concatenate([lo, lo + size]), np.concatenate([q - down, q + up]), centre, phi


def turning(centre, a, b, pad) -> np.ndarray:
    """The motion array of two trees of one box each (see `search.trees.rotate`)."""
    motion = np.zeros((3, COLUMNS))
    motion[2, :3] = centre[0], centre[1], 1
    for row, box in zip(motion, (a, b), strict=False):
        row[:6] = range_of_box(box, centre[0], centre[1], pad)
    return motion


@pytest.mark.share(2)
@pytest.mark.parametrize("kind", ["random", "lattice"])
def test_entry_angle_is_never_late(kind):
    """A point of a meets a point of b at phi: no window around phi may start its contacts later."""
    rng = np.random.default_rng(93)
    later_than_first = 0
    pad = 1e-12  # the plant itself is rounded
    n = amount(8000, 4)
    for _ in range(n):
        a, b, centre, phi = planted(rng, kind)
        motion = turning(centre, a, b, pad)
        for first in (0.0, phi * float(rng.uniform(0, 1)), phi):
            for last in (phi, float(rng.uniform(phi, TWO_PI)), TWO_PI + 1e-14):
                got = entry_angle(motion, 0, 0, pad, first, max(first, last))
                assert got <= phi, (a, b, centre, first, last)
                assert got >= first
                later_than_first += got > first
    assert later_than_first > n / 2


@pytest.mark.share(2)
@pytest.mark.parametrize("kind", ["random", "lattice"])
def test_angle_window_encloses(kind):
    rng = np.random.default_rng(94)
    early_exit = 0
    n = amount(8000, 4)
    for _ in range(n):
        a, b, centre, phi = planted(rng, kind)
        last = max(phi, float(rng.uniform(0, TWO_PI)))
        entry, leave = angle_window(turning(centre, a, b, 1e-12), 0, 0, 1e-12, last)
        assert entry <= phi <= leave
        early_exit += leave < last
    assert early_exit > n / 80


def test_boxes_that_cannot_meet_in_a_turn():
    one = np.array([2.0, -0.1, 0.0, 2.2, 0.1, 1.0])
    higher = np.array([-2.2, -0.1, 1.5, -2.0, 0.1, 2.0])
    nearer = np.array([-1.2, -0.1, 0.0, -1.0, 0.1, 1.0])
    behind = np.array([-0.1, -2.2, 0.0, 0.1, -2.0, 1.0])  # reached after three quarters
    for other in (higher, nearer):
        assert entry_angle(turning((0, 0), one, other, 1e-9), 0, 0, 1e-9, 0.0, TWO_PI) == INF
    motion = turning((0, 0), one, behind, 1e-9)
    assert 4.5 < entry_angle(motion, 0, 0, 1e-9, 0.0, TWO_PI) < 3 * math.pi / 2
    assert entry_angle(motion, 0, 0, 1e-9, 0.0, 4.5) == INF


# ------------------------------------------------------------------------------------------------- clipping


def test_clipped_triangles_keep_what_lies_in_the_box():
    """Points of the triangle inside the box lie in the box of the clipped corners, but for CLIP_EPS."""
    rng = np.random.default_rng(95)
    polygon, scratch = np.empty((12, 3)), np.empty((12, 3))
    kept = 0
    for k in range(amount(1500, 2)):
        xyz = rng.integers(-3, 4, 9).astype(float) if k % 2 else rng.uniform(-3, 3, 9)
        lo = rng.integers(-2, 2, 3).astype(float) if k % 3 else rng.uniform(-2, 1, 3)
        box = np.concatenate([lo, lo + rng.integers(0, 3, 3)])
        n = clip_to_box(xyz, box, polygon, scratch)
        w = rng.dirichlet(np.ones(3), 60)
        points = w @ xyz.reshape(3, 3)
        # strictly inside: a point at the border may be out by the sample's own rounding
        inside = points[np.all((points > box[:3] + 1e-9) & (points < box[3:] - 1e-9), axis=1)]
        kept += len(inside)
        if not len(inside):
            continue
        assert n >= 3
        pad = CLIP_EPS * np.abs(xyz).max() + 1e-15
        corners = polygon[:n]
        assert np.all(inside >= corners.min(axis=0) - pad) and np.all(inside <= corners.max(axis=0) + pad)
        assert np.all(corners >= box[:3] - pad) and np.all(corners <= box[3:] + pad)
    assert kept > 200


def test_segment_meets_box_denies_no_meeting():
    rng = np.random.default_rng(96)
    denied = 0
    for k in range(4000):
        p, q = (rng.integers(-3, 4, 3).astype(float) if k % 2 else rng.uniform(-3, 3, 3) for _ in range(2))
        inner = p + float(rng.uniform(0, 1)) * (q - p)
        lo, hi = inner - rng.uniform(0, 1, 3), inner + rng.uniform(0, 1, 3)
        assert segment_meets_box(p, q, np.concatenate([lo, hi]), 1e-14)
        other = np.concatenate([lo + 3, hi + 3])
        denied += not segment_meets_box(p, q, other, 0.0)
    assert denied > 1000
