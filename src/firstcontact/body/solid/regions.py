"""Where each surface may bound a solid, so that features are sought among surfaces that come near each other alone.

A surface of an operand bounds `a & b` only within the boxes of both, one of b bounds `a - b` only within the box of a.
So a solid is made of primitives, intersections of half-spaces, each of which matters in its reach alone: where it has
no point it may be taken for empty.  In a region that leaves few surfaces, and most of them have one sign there; the
Boolean tree with these signs put in is small.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from flint import arb

from firstcontact.body.solid import truth
from firstcontact.body.solid.carriers import Box, Plane, Surface, doubles
from firstcontact.body.solid.csg import And, Leaf, Not, Or, Tree, possible, surfaces_of
from firstcontact.exact.numbers import to_double

Region = tuple[np.ndarray, np.ndarray]
"""Lower and upper corner (3,) of a box; infinite where nothing is known."""
# By which boxes are enlarged, of their size and of their coordinates: points on their sides count as inside.
_ROOM, _SLACK = 1e-6, 1e-9
# Of the size of a form's terms: far more than the roundings of its value.
_ROUNDING = 2.0**-45
# How often cells are halved at most.
FEW = 8
_LEVELS = 10
# Numbers of surfaces of which it is sooner seen where the boundary is than which of all pairs meet: cells in which two
# surfaces may meet are halved in each direction until they are too many.
_MANY, _HALVINGS, _MOST_CELLS = range(12, 64), 6, 4000
# Points times forms that are looked at in one go.
_AT_ONCE = 10_000


class SurfaceReach(NamedTuple):
    """Of a surface of a solid.

    box: exact corners of a box in which it may bound the solid, None for all of space.
    outside: the sign of its form that makes its primitives empty, to be put in beyond the box; 0: they differ.
    """

    box: Box | None
    outside: int


def reaches_of(tree: Tree, count: int, box: Box | None) -> tuple[SurfaceReach, ...]:
    """Of the surfaces of a primitive, or of a solid that is taken as it is."""
    leaves = leaves_of(tree)
    return tuple(SurfaceReach(box, leaves.get(i, 0)) for i in range(count))


def leaves_of(tree: Tree) -> dict[int, int]:
    """The sign of each surface's form outside, for an intersection of half-spaces; {} for other trees."""
    if isinstance(tree, Leaf):
        return {tree.surface: 1}
    if isinstance(tree, Not):
        return {tree.inner.surface: -1} if isinstance(tree.inner, Leaf) else {}
    if isinstance(tree, Or):
        return {}
    first, second = leaves_of(tree.first), leaves_of(tree.second)
    return {**first, **second} if first and second and not first.keys() & second.keys() else {}


def grows_with_leaves(tree: Tree) -> bool:
    """Whether nothing but half-spaces is negated: a solid of fewer primitives is then a part of it."""
    if isinstance(tree, Not):
        return isinstance(tree.inner, Leaf)
    return isinstance(tree, Leaf) or (grows_with_leaves(tree.first) and grows_with_leaves(tree.second))


class _Cells(NamedTuple):
    """Boxes with corners lo, hi (n, 3), and which surfaces may bound the solid there: passing (n, surfaces)."""

    lo: np.ndarray
    hi: np.ndarray
    passing: np.ndarray


_OCTANTS = np.array([(i, j, k) for i in (-1.0, 1.0) for j in (-1.0, 1.0) for k in (-1.0, 1.0)])


def halved(centre: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The eight parts of each of the cells centre (n, 3) +- half (3,)."""
    return (centre[:, None] + _OCTANTS * (0.5 * half)).reshape(-1, 3), 0.5 * half


def _hull_of(cells: _Cells, which: np.ndarray) -> Region | None:
    return (cells.lo[which].min(axis=0), cells.hi[which].max(axis=0)) if which.any() else None


class Regions:
    """Of all surfaces of one solid."""

    def __init__(self, surfaces: Sequence[Surface], reaches: Sequence[SurfaceReach]) -> None:
        self.forms = np.array([doubles(s.matrix()) for s in surfaces]).reshape(-1, 4, 4)
        boxes = [_enlarged(reach.box) for reach in reaches]
        own = [_on_plane(s, box) if isinstance(s, Plane) else box for s, box in zip(surfaces, boxes, strict=True)]
        self.primitives = _corners(boxes)
        self.lo, self.hi = _corners(own)
        self.outside = np.array([reach.outside for reach in reaches], int)
        self._bounds: _Cells | None = None
        self._known = False
        self._decides: dict[bytes, np.ndarray] = {}
        self._seen: dict[bytes, tuple[Tree | bool, tuple[int, ...]]] = {}
        self._cells: dict[tuple[int, ...], Tree | bool] = {}
        finite = np.isfinite(self.lo).all(axis=1) & np.isfinite(self.hi).all(axis=1)
        self.origin = self.lo[finite].min(axis=0, initial=math.inf)
        self.size = float((self.hi[finite].max(axis=0, initial=-math.inf) - self.origin).max()) if finite.any() else 0.0

    def of(self, i: int) -> Region:
        return self.lo[i], self.hi[i]

    def pairs(self, tree: Tree) -> Iterator[tuple[int, int, Region]]:
        """The surfaces i < j that may both bound the solid somewhere, and where: a box that holds all such points."""
        cells = self._boundary(tree)
        for i in range(len(self.lo)):
            lo, hi = np.maximum(self.lo[i], self.lo[i + 1 :]), np.minimum(self.hi[i], self.hi[i + 1 :])
            for k in np.flatnonzero((lo <= hi).all(axis=1)).tolist():
                j = i + 1 + k
                both = None if cells is None else _hull_of(cells, cells.passing[:, i] & cells.passing[:, j])
                if cells is None:
                    yield i, j, (lo[k], hi[k])
                elif both is not None:
                    low, high = np.maximum(lo[k], both[0]), np.minimum(hi[k], both[1])
                    if (low <= high).all():
                        yield i, j, (low, high)

    def bounding(self, tree: Tree, i: int) -> Region | None:
        """Where a surface may bound the solid; None where it does nowhere."""
        cells = self._boundary(tree)
        if cells is None:
            return self.of(i)
        region = _hull_of(cells, cells.passing[:, i])
        if region is None:
            return None
        return np.maximum(region[0], self.lo[i]), np.minimum(region[1], self.hi[i])

    def _boundary(self, tree: Tree) -> _Cells | None:
        """Cells that hold the whole boundary; None where that is not worth it, or the reaches are endless."""
        if not self._known:
            lo, hi = self.primitives
            finite = bool(np.isfinite(lo).all() and np.isfinite(hi).all())
            self._bounds = self._divided(tree) if finite and len(lo) in _MANY else None
            self._known = True
        return self._bounds

    def _divided(self, tree: Tree) -> _Cells:
        """All space in which surfaces may bound, halved where two of them may meet on the boundary."""
        lo, hi = self.primitives[0].min(axis=0), self.primitives[1].max(axis=0)
        centre, half = (0.5 * (lo + hi))[None], 0.5 * (hi - lo)
        done: list[_Cells] = []
        for level in range(_HALVINGS + 1):
            passing = self.passing(tree, centre, half)
            crowded = passing.sum(axis=1) > 1
            last = level == _HALVINGS or 8 * crowded.sum() > _MOST_CELLS
            room = half * (1.0 + _ROOM) + _SLACK * np.abs(centre)
            kept = passing.any(axis=1) & (last | ~crowded)
            done.append(_Cells((centre - room)[kept], (centre + room)[kept], passing[kept]))
            if last or not crowded.any():
                break
            centre, half = halved(centre[crowded], half)
        return _Cells(*(np.concatenate(x) for x in zip(*done, strict=True)))

    def passing(self, tree: Tree, centre: np.ndarray, half: np.ndarray) -> np.ndarray:
        """(cells, surfaces): which may bound the solid in the cells centre (n, 3) +- half (3,)."""
        signs = self._signs(centre, half).astype(np.int8)
        found = np.zeros(signs.shape, bool)
        few = (signs == 0).sum(axis=1) <= truth.MOST
        found[few] = truth.deciding(tree, signs[few])
        many = np.flatnonzero(~few)
        if len(many):
            below, above = list((signs[many] <= 0).T), list((signs[many] >= 0).T)
            for row in many[np.logical_and(*possible(tree, below, above))].tolist():
                found[row] = self._deciding(tree, signs[row])
        return found

    def _deciding(self, tree: Tree, signs: np.ndarray) -> np.ndarray:
        """(surfaces,) those whose sides decide where the others have these signs, or may do so."""
        key = signs.tobytes()
        if key not in self._decides:
            found = np.zeros(len(signs), bool)
            found[list(deciding(simplified(tree, signs.tolist())))] = True
            self._decides[key] = found
        return self._decides[key]

    def seen_in(self, tree: Tree, region: Region) -> tuple[Tree | bool, tuple[int, ...]]:
        """The tree as it is in the region, and `signs` there; kept, as several curves have one region."""
        if len(self.forms) <= FEW:
            return tree, (0,) * len(self.forms)
        key = region[0].tobytes() + region[1].tobytes()
        if key not in self._seen:
            signs = self.signs(region)
            self._seen[key] = simplified(self._around(tree, region), signs), signs
        return self._seen[key]

    def next_to(self, tree: Tree, point: Sequence[float]) -> Tree | bool:
        """The tree as it is in a cell that holds few of the surfaces and the point."""
        if not (np.isfinite(point).all() and self.size > 0.0):
            return tree
        level = min(_LEVELS, (len(self.forms) // 4).bit_length() // 2)
        step = self.size / 2.0**level
        at = np.floor((np.asarray(point) - self.origin) / step - 0.5).astype(int)
        return self._in_cell(tree, level, at)

    def _around(self, tree: Tree, region: Region) -> Tree | bool:
        """The tree as it is in the least cell that holds the region: small, and found by way of larger cells.

        Cells of a level are as wide as two of their steps, and steps are halved from level to level.
        """
        width = float((region[1] - region[0]).max())
        if not 0.0 < width <= self.size / 2:
            return tree
        level = min(_LEVELS, int(math.log2(self.size / width)))
        at = np.floor((region[0] - self.origin) * (2.0**level / self.size)).astype(int)
        return self._in_cell(tree, level, at)

    def _in_cell(self, tree: Tree, level: int, at: np.ndarray) -> Tree | bool:
        if level <= 0:
            return tree
        key = (level, *at.tolist())
        if key not in self._cells:
            step = self.size / 2.0**level
            lo = self.origin + at * step - _ROOM * step
            near = self._in_cell(tree, level - 1, at // 2)
            self._cells[key] = simplified(near, self.signs((lo, lo + (2 + 2 * _ROOM) * step)))
        return self._cells[key]

    def around(self, point: Sequence[float], surfaces: Iterable[int]) -> frozenset[int]:
        """Those of the surfaces in whose reach the point is."""
        return frozenset(i for i in surfaces if holds(self.of(i), point))

    def signs(self, region: Region) -> tuple[int, ...]:
        """Of each surface's form the sign that it may be taken to have all over the region; 0: not known."""
        lo, hi = region
        if not (np.isfinite(lo).all() and np.isfinite(hi).all()):
            return (0,) * len(self.forms)
        return tuple(self._signs(0.5 * (lo + hi)[None], 0.5 * (hi - lo))[0].tolist())

    def _signs(self, centre: np.ndarray, half: np.ndarray) -> np.ndarray:
        """(n, surfaces) signs, as of `signs`, in the boxes centre (n, 3) +- half (3,)."""
        return np.concatenate([self._signs_of(centre[part], half) for part in parts(len(centre), len(self.forms))])

    def _signs_of(self, centre: np.ndarray, half: np.ndarray) -> np.ndarray:
        x, h = np.column_stack([centre, np.ones(len(centre))]), np.append(half * 1.0000001, 0.0)
        sizes = np.abs(self.forms)
        reach = np.abs(x) + h
        image = np.tensordot(x, self.forms, (1, 2))  # (n, surfaces, 4)
        value = np.einsum("nsi,ni->ns", image, x)
        terms = np.einsum("nsi,ni->ns", np.tensordot(reach, sizes, (1, 2)), reach)
        spread = 2.0 * np.abs(image) @ h + (sizes @ h) @ h + _ROUNDING * terms
        signs = (value > spread).astype(int) - (value < -spread)
        least, most = self.primitives
        beyond = np.zeros(signs.shape, bool)
        for k in range(3):
            at = centre[:, k, None]
            beyond |= (least[:, k] > at + half[k]) | (most[:, k] < at - half[k])
        found: np.ndarray = np.where(beyond & (self.outside != 0), self.outside, signs)
        return found


def parts(count: int, forms: int) -> Iterator[slice]:
    """Parts of so many points, of which the forms' values stay in the caches: for more BLAS takes a second thread,
    which costs more than it brings."""
    step = max(1, _AT_ONCE // max(1, forms))
    for first in range(0, max(1, count), step):
        yield slice(first, first + step)


def holds(region: Region, point: Sequence[float]) -> bool:
    """Whether the point lies in it; a point that is no number in no bounded one."""
    lo, hi = region
    return bool(((lo <= point) & (point <= hi)).all()) or not np.isfinite(lo).all()


def holds_ball(region: Region, x: Sequence[arb]) -> bool:
    """The same of a homogeneous point in balls; the region has room for their width."""
    return holds(region, [float(c / x[3]) for c in x[:3]])


def hull(first: Region, second: Region) -> Region:
    return np.minimum(first[0], second[0]), np.maximum(first[1], second[1])


def simplified(tree: Tree | bool, signs: Sequence[int]) -> Tree | bool:
    """What is left of the tree where surfaces have these signs; 0: either."""
    if isinstance(tree, bool):
        return tree
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


def deciding(tree: Tree | bool) -> set[int]:
    """The surfaces whose side makes a difference somewhere; of a tree of many, all of them."""
    if isinstance(tree, bool):
        return set()
    known = surfaces_of(tree)
    if len(known) > truth.MOST:
        return known
    signs = np.ones((1, max(known) + 1), np.int8)
    signs[0, list(known)] = 0
    return set(np.flatnonzero(truth.deciding(tree, signs)[0]).tolist())


def _enlarged(box: Box | None) -> Region:
    if box is None:
        return np.full(3, -math.inf), np.full(3, math.inf)
    lo, hi = (np.array([to_double(x) for x in corner]) for corner in box)
    room = _ROOM * float((hi - lo).max()) + _SLACK * float(np.maximum(np.abs(lo), np.abs(hi)).max())
    return lo - room, hi + room


def _on_plane(plane: Plane, region: Region) -> Region:
    """What a plane across an axis has of a region."""
    *normal, offset = (to_double(x) for x in plane.normal)
    across = [k for k in range(3) if normal[k] != 0.0]
    lo, hi = region
    if len(across) != 1 or not np.isfinite(lo).all():
        return region
    (k,) = across
    place = -offset / normal[k]
    room = _ROOM * float((hi - lo).max()) + _SLACK * abs(place)
    lo, hi = lo.copy(), hi.copy()
    lo[k], hi[k] = max(lo[k], place - room), min(hi[k], place + room)
    return lo, hi


def _corners(regions: Sequence[Region]) -> Region:
    return np.array([lo for lo, _ in regions]).reshape(-1, 3), np.array([hi for _, hi in regions]).reshape(-1, 3)
