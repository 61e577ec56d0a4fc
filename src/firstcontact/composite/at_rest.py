"""Two models at one rational instant: do their interiors overlap, and does one hold the other?"""

from __future__ import annotations

from itertools import product

import numpy as np
from flint import fmpq

from firstcontact.body.composite_quadric import CompositeQuadric
from firstcontact.composite.moving_pair import Pair
from firstcontact.errors import InputError
from firstcontact.exact.numbers import to_double


def placed(pair: Pair, u: fmpq) -> CompositeQuadric:
    """Model a where it stands at u, in the frame of b; exact."""
    pose = [[x(u) for x in row] for row in pair.piece.pose]
    weight = pose[3][3]
    return pair.a.transformed([[x / weight for x in row] for row in pose])


def overlap(pair: Pair, u: fmpq) -> bool:
    """Whether the interiors of the two models share a point at u; exact (the Boolean intersection is not empty)."""
    (lo, hi), (low, high) = _box_of_a(pair, u), pair.b.bounds()
    if np.any(lo > high) or np.any(low > hi):
        return False
    return _meet(placed(pair, u), pair.b)


def _box_of_a(pair: Pair, u: fmpq) -> tuple[np.ndarray, np.ndarray]:
    """Corners of a box around model a at u, in the frame of b: that of the turned corners of its own box."""
    lo, hi = pair.a.bounds()
    if not np.all(np.isfinite([lo, hi])):
        return np.full(3, -np.inf), np.full(3, np.inf)
    rows = [[x(u) for x in row] for row in pair.piece.pose]
    pose = np.array([[to_double(x / rows[3][3]) for x in row] for row in rows[:3]])
    corners = np.array(list(product(*zip(lo, hi, strict=True))))
    moved = corners @ pose[:, :3].T + pose[:, 3]
    # entries, products and sums: a handful of roundings relative to the sizes of the terms
    pad = 1e-14 * (np.abs(corners) @ np.abs(pose[:, :3]).T + np.abs(pose[:, 3])).max(axis=0)
    return moved.min(axis=0) - pad, moved.max(axis=0) + pad


def is_containment(pair: Pair, u: fmpq) -> bool:
    """Whether one model holds the other at u, for models whose interiors overlap."""
    a = placed(pair, u)
    return not _meet_difference(a, pair.b) or not _meet_difference(pair.b, a)


def _meet(a: CompositeQuadric, b: CompositeQuadric) -> bool:
    try:
        a & b
    except InputError:
        return False
    return True


def _meet_difference(a: CompositeQuadric, b: CompositeQuadric) -> bool:
    try:
        a - b
    except InputError:
        return False
    return True
