"""When which pieces of two bodies may meet: boxes around all that moves, slab of time by slab."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.compound.compound import Compound, Piece
from firstcontact.exact.numbers import above, below
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative.sweep import swept_box
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

SLABS = 16
"""Equal parts of the span that are looked at one by one, where more than a few pairs may meet."""
FEW = 2

Boxes = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Side:
    """A body of the question as its pieces, each under the body's motion; `piece` is None of a body without pieces."""

    body: Any
    pieces: tuple[Piece | None, ...]
    bodies: tuple[Any, ...]

    @property
    def name(self) -> str | None:
        name: str | None = self.body.name
        return name

    def boxes(self, numbers: np.ndarray, first: float, last: float) -> Boxes:
        """Corners (n, 3) of boxes that hold these pieces at all times from first to last."""
        found = [self._box(k, first, last) for k in numbers.tolist()]
        return np.array([lo for lo, _ in found]).reshape(-1, 3), np.array([hi for _, hi in found]).reshape(-1, 3)

    def _box(self, k: int, first: float, last: float) -> Boxes:
        body, piece = self.bodies[k], self.pieces[k]
        if piece is None or piece.corners is None:
            found: Boxes = body.bounds((first, last))
            return found
        if not isinstance(body, Moving):
            return piece.corners.min(axis=0), piece.corners.max(axis=0)
        return swept_box(body.motion, first, last, piece.corners, 0.0)


def side_of(body: Body) -> Side:
    shape = shape_of(body)
    if not isinstance(shape, Compound):
        return Side(body, (None,), (body,))
    bodies = tuple(Moving(x.body, body.motion) if isinstance(body, Moving) else x.body for x in shape.pieces)
    return Side(body, shape.pieces, bodies)


@dataclass(frozen=True, order=True)
class Window:
    """A stretch of time in which two pieces, by their numbers, may meet; outside of their windows they do not."""

    first: fmpq
    last: fmpq | None
    a: int
    b: int


def windows(a: Side, b: Side, query: Query) -> list[Window]:
    """All of them, in order of time."""
    lo, hi = below(query.first), np.inf if query.last is None else above(query.last)
    all_a, all_b = np.arange(len(a.bodies)), np.arange(len(b.bodies))
    pairs = _overlapping(a.boxes(all_a, lo, hi), b.boxes(all_b, lo, hi))
    if len(pairs) <= FEW or query.last is None or query.last <= query.first:
        return [Window(query.first, query.last, i, j) for i, j in pairs.tolist()]
    return sorted(_runs(a, b, query, pairs))


def _runs(a: Side, b: Side, query: Query, pairs: np.ndarray) -> Iterator[Window]:
    """The slabs in which each pair may meet, neighbouring ones joined."""
    of_a, of_b = np.unique(pairs[:, 0]), np.unique(pairs[:, 1])
    i, j = np.searchsorted(of_a, pairs[:, 0]), np.searchsorted(of_b, pairs[:, 1])
    ends = [query.first + (query.end - query.first) * fmpq(k, SLABS) for k in range(SLABS + 1)]
    near = np.zeros((SLABS + 2, len(pairs)), bool)
    for k in range(SLABS):
        lo, hi = below(ends[k]), above(ends[k + 1])
        (lo_a, hi_a), (lo_b, hi_b) = a.boxes(of_a, lo, hi), b.boxes(of_b, lo, hi)
        near[k + 1] = ((lo_a[i] <= hi_b[j]) & (lo_b[j] <= hi_a[i])).all(axis=1)
    change = np.diff(near.astype(int), axis=0)
    for k, (one, other) in enumerate(pairs.tolist()):
        starts, stops = np.flatnonzero(change[:, k] > 0), np.flatnonzero(change[:, k] < 0)
        for start, stop in zip(starts.tolist(), stops.tolist(), strict=True):
            yield Window(ends[start], ends[stop], one, other)


def _overlapping(a: Boxes, b: Boxes) -> np.ndarray:
    """(k, 2) numbers of boxes that share a point."""
    meet = np.ones((len(a[0]), len(b[0])), bool)
    for axis in range(3):
        meet &= a[0][:, None, axis] <= b[1][None, :, axis]
        meet &= b[0][None, :, axis] <= a[1][:, None, axis]
    return np.argwhere(meet)
