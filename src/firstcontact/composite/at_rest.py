"""Two models at one rational instant: do their interiors overlap, and does one hold the other?"""

from __future__ import annotations

import numpy as np
from flint import fmpq

from firstcontact.body.composite_quadric import CompositeQuadric
from firstcontact.composite.moving_pair import Pair
from firstcontact.errors import InputError


def placed(pair: Pair, u: fmpq) -> CompositeQuadric:
    """Model a where it stands at u, in the frame of b; exact."""
    pose = [[x(u) for x in row] for row in pair.piece.pose]
    weight = pose[3][3]
    return pair.a.transformed([[x / weight for x in row] for row in pose])


def overlap(pair: Pair, u: fmpq) -> bool:
    """Whether the interiors of the two models share a point at u; exact (the Boolean intersection is not empty)."""
    a = placed(pair, u)
    (lo, hi), (low, high) = a.bounds(), pair.b.bounds()
    if np.any(lo > high) or np.any(low > hi):
        return False
    return _meet(a, pair.b)


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
