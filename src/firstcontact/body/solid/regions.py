"""Where each surface may bound a solid, so that features are sought among surfaces that come near each other alone.

A surface of an operand bounds `a & b` and `a - b` only within the boxes of both (of `a - b`: those of b).  In a region
most other surfaces have one sign; the Boolean tree with these signs put in is small.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from firstcontact.body.solid.carriers import Box, Surface, doubles
from firstcontact.body.solid.csg import And, Leaf, Not, Or, Tree
from firstcontact.exact.numbers import to_double

Region = tuple[np.ndarray, np.ndarray]
"""Lower and upper corner (3,) of a box; infinite where nothing is known."""
# By which boxes are enlarged, of their size and of their coordinates: points on their sides count as inside.
_ROOM, _SLACK = 1e-6, 1e-9
# Of the size of a form's terms: far more than the roundings of its value.
_ROUNDING = 2.0**-45


class Regions:
    """Of all surfaces of a solid; reaches: exact boxes in which they may bound it, None for all of space."""

    def __init__(self, surfaces: Sequence[Surface], reaches: Sequence[Box | None]) -> None:
        self.forms = np.array([doubles(s.matrix()) for s in surfaces]).reshape(-1, 4, 4)
        found = [_enlarged(box) for box in reaches]
        self.lo = np.array([lo for lo, _ in found]).reshape(-1, 3)
        self.hi = np.array([hi for _, hi in found]).reshape(-1, 3)

    def of(self, i: int) -> Region:
        return self.lo[i], self.hi[i]

    def pairs(self) -> Iterator[tuple[int, int, Region]]:
        """The surfaces i < j that may both bound the solid somewhere, and where."""
        for i in range(len(self.lo)):
            lo, hi = np.maximum(self.lo[i], self.lo[i + 1 :]), np.minimum(self.hi[i], self.hi[i + 1 :])
            for k in np.flatnonzero((lo <= hi).all(axis=1)):
                yield i, i + 1 + int(k), (lo[k], hi[k])

    def signs(self, region: Region) -> tuple[int, ...]:
        """Of each surface's form the sign that it has all over the region; 0: not known."""
        lo, hi = region
        if not (np.isfinite(lo).all() and np.isfinite(hi).all()):
            return (0,) * len(self.forms)
        x, h = np.append(0.5 * (lo + hi), 1.0), np.append(0.5 * (hi - lo) * 1.0000001, 0.0)
        image = self.forms @ x
        sizes = np.abs(self.forms)
        reach = np.abs(x) + h
        value, spread = image @ x, 2.0 * np.abs(image) @ h + (sizes @ h) @ h + _ROUNDING * ((sizes @ reach) @ reach)
        return tuple(((value > spread).astype(int) - (value < -spread)).tolist())


def holds(region: Region, point: Sequence[float]) -> bool:
    """Whether the point lies in it; a point that is no number in no bounded one."""
    lo, hi = region
    return bool(((lo <= point) & (point <= hi)).all()) or not np.isfinite(lo).all()


def hull(first: Region, second: Region) -> Region:
    return np.minimum(first[0], second[0]), np.maximum(first[1], second[1])


def simplified(tree: Tree, signs: Sequence[int]) -> Tree | bool:
    """What is left of the tree where surfaces have these signs; 0: either."""
    if isinstance(tree, Leaf):
        return tree if signs[tree.surface] == 0 else signs[tree.surface] < 0
    if isinstance(tree, Not):
        inner = simplified(tree.inner, signs)
        return not inner if isinstance(inner, bool) else Not(inner)
    first, second = simplified(tree.first, signs), simplified(tree.second, signs)
    settles = isinstance(tree, Or)  # the value of one operand that settles the whole
    if isinstance(first, bool):
        return settles if first == settles else second
    if isinstance(second, bool):
        return settles if second == settles else first
    return Or(first, second) if settles else And(first, second)


def _enlarged(box: Box | None) -> Region:
    if box is None:
        return np.full(3, -math.inf), np.full(3, math.inf)
    lo, hi = (np.array([to_double(x) for x in corner]) for corner in box)
    room = _ROOM * float((hi - lo).max()) + _SLACK * float(np.maximum(np.abs(lo), np.abs(hi)).max())
    return lo - room, hi + room
