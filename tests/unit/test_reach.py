"""How far points of links pass: never farther than `reach` says, and boxes of moving bodies hold them."""

from __future__ import annotations

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.motion.linkage import Drive, Linkage
from firstcontact.motion.relative.reach import places

TIMES = [fmpq(x) for x in (0, 1, 3, 7)]


def linkage(rng, joints=4):
    """Joints of all kinds, driven by cubic polynomials; now and then one rests."""
    drives = []
    for k in range(joints):
        axis, point = rng.integers(-3, 4, 3).tolist(), rng.normal(size=3).tolist()
        axis = axis if any(axis) else [0, 0, 1]
        kind = rng.integers(3)
        if kind == 0:
            motion = fc.Rotation(axis, point, radians=1)
        elif kind == 1:
            motion = fc.Screw(axis, point, radians=1, advance=float(rng.normal()))
        else:
            motion = fc.Screw(axis, point, turns=0, advance=1)
        count = rng.integers(1, 5)
        rows = rng.normal(size=(3, count)) * rng.choice([0.01, 0.3, 2.0])
        drives.append(Drive(str(k), "", motion, [tuple(fmpq(*x.as_integer_ratio()) for x in row) for row in rows]))
    return Linkage(TIMES, drives)


@pytest.mark.parametrize("seed", range(8))
def test_points_stay_near_where_they_are_in_the_middle(seed):
    rng = np.random.default_rng(seed)
    motion = linkage(rng)
    points = rng.normal(size=(5, 3)) * 3
    middles, far = places(motion, points)
    for k in range(3):
        start, end = float(TIMES[k].p), float(TIMES[k + 1].p)
        for share in (0.0, 0.5, 1.0 - 1e-12, *rng.uniform(size=6)):  # values jump where stretches meet
            pose = motion(start + share * (end - start))
            moved = points @ pose[:3, :3].T + pose[:3, 3]
            gap = np.linalg.norm(moved - middles[k], axis=1)
            assert (gap <= far[k] + 1e-12).all()
            if share == 0.5:
                assert gap.max() < 1e-11


@pytest.mark.parametrize("seed", range(4))
def test_bounds_of_a_link_hold_it(seed):
    rng = np.random.default_rng(50 + seed)
    body = fc.examples.box((1, 2, 0.5)).translated((0.5, 0, 1)).moving(linkage(rng))
    for span in ((0, 7), (2.5, 3), (3.0, 6.5)):
        lo, hi = body.bounds(span)
        for t in np.linspace(*span, 40):
            placed = body.at(t).vertices
            assert (placed >= lo - 1e-12).all() and (placed <= hi + 1e-12).all()
