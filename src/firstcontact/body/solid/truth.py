"""Boolean trees at many places at once: what they are for either sign of the few surfaces that are not told there.

The sign patterns of six surfaces are 64, so that one number of 64 bits holds what a tree makes of all of them.
"""

from __future__ import annotations

import numpy as np

from firstcontact.body.solid.csg import Tree, inside

MOST = 6
"""Surfaces whose signs may be unknown in one place."""
_ALL = np.uint64(2**64 - 1)
_SIDES = np.array([sum(1 << c for c in range(64) if c >> k & 1) for k in range(MOST)], np.uint64)
"""Of the k-th unknown surface the patterns in which its form is negative: those with bit k."""
_PLACES = np.array([1 << k for k in range(MOST)], np.uint64)
"""How far from a pattern the one is that has bit k too."""


def is_open(tree: Tree, signs: np.ndarray) -> np.ndarray:
    """(n,) whether the tree has both values at places of signs (n, surfaces), -1, 1 or, of at most MOST, 0: unknown."""
    values = _values(tree, signs, _ranks(signs))
    found: np.ndarray = (values != 0) & (values != _ALL)
    return found


def deciding(tree: Tree, signs: np.ndarray) -> np.ndarray:
    """(n, surfaces) whether the value depends on the side of an unknown surface, for some sides of the others."""
    ranks = _ranks(signs)
    values = _values(tree, signs, ranks)[:, None]
    found: np.ndarray = (signs == 0) & ((values ^ values >> _PLACES[ranks]) & ~_SIDES[ranks] != 0)
    return found


def _ranks(signs: np.ndarray) -> np.ndarray:
    """Of each unknown surface how many there are before it."""
    found: np.ndarray = np.clip(np.cumsum(signs == 0, axis=1) - 1, 0, MOST - 1)
    return found


def _values(tree: Tree, signs: np.ndarray, ranks: np.ndarray) -> np.ndarray:
    """(n,) of all patterns the Boolean values, as bits."""
    sides = np.where(signs == 0, _SIDES[ranks], np.where(signs < 0, _ALL, np.uint64(0)))
    found: np.ndarray = inside(tree, list(np.ascontiguousarray(sides.T)))
    return found
