"""When which pieces of two bodies may meet: boxes around all that moves, slab of time by slab."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.compound.compound import Compound, CompoundPiece
from firstcontact.body.kept import Kept
from firstcontact.exact.numbers import above, below, to_double
from firstcontact.motion.moving import Moving, drift_of, shape_of
from firstcontact.motion.relative.sweep import ROUNDING, swept_box
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Shape
    from firstcontact.exact.vectors import Vector

SLABS = 16
"""Equal parts of the span that are looked at one by one, where more than a few pairs may meet."""
FEW = 2
STEPS = 4096
"""Of the span, at which windows of bodies that only shift begin and end."""
MOST_LATE = 2**20
"""Of the span: how far from 0 it may be for times in doubles to be told apart well within such steps."""

Boxes = tuple[np.ndarray, np.ndarray]
Spans = Sequence[tuple[float, float]]
_BOXES = Kept[Boxes]()
_REACH = Kept[float]()


@dataclass(frozen=True)
class CompoundSide:
    """A body of the question as its pieces, each under the body's motion; `piece` is None of a body without pieces."""

    body: Any
    pieces: tuple[CompoundPiece | None, ...]
    bodies: tuple[Any, ...]

    @property
    def name(self) -> str | None:
        name: str | None = self.body.name
        return name

    def boxes(self, numbers: np.ndarray, times: Spans) -> Boxes:
        """Corners (m, n, 3) of boxes that hold these pieces at all times of each of the spans."""
        body, shape = self.body, (len(times), len(numbers), 3)
        vector = _drift_of(body)
        if vector is not None:
            lo, hi = (x[numbers] for x in _boxes_of(shape_of(body)))
            if not isinstance(body, Moving):
                return np.broadcast_to(lo, shape), np.broadcast_to(hi, shape)
            if np.all(np.isfinite(times)) and np.all(np.isfinite(hi - lo)):
                return _along(np.array([to_double(x) for x in vector]), lo, hi, np.array(times))
        found = [self._box(k, first, last) for first, last in times for k in numbers.tolist()]
        return np.array([lo for lo, _ in found]).reshape(shape), np.array([hi for _, hi in found]).reshape(shape)

    def _box(self, k: int, first: float, last: float) -> Boxes:
        body, piece = self.bodies[k], self.pieces[k]
        if piece is None or piece.corners is None or not isinstance(body, Moving):
            found: Boxes = body.bounds((first, last))
            return found
        return swept_box(body.motion, first, last, piece.corners, 0.0)


def _boxes_of(shape: Shape) -> Boxes:
    """Corners (n, 3) of boxes around the pieces of a body, in its own frame; kept on it."""
    def found() -> Boxes:
        if not isinstance(shape, Compound):
            return tuple(x[None] for x in _own_box(shape, None))  # type: ignore[return-value]
        boxes = [_own_box(piece.body, piece.corners) for piece in shape.pieces]
        return np.array([lo for lo, _ in boxes]), np.array([hi for _, hi in boxes])

    return _BOXES.of(shape, found)


def _own_box(body: Shape, corners: np.ndarray | None) -> Boxes:
    found: Boxes = body.bounds() if corners is None else (corners.min(axis=0), corners.max(axis=0))
    return found


def _along(vector: np.ndarray, lo: np.ndarray, hi: np.ndarray, times: np.ndarray) -> Boxes:
    """(m, n, 3) around boxes (n, 3) that go along a vector, over spans (m, 2)."""
    ways = times[:, :, None] * vector
    pad = ROUNDING * max(float(np.abs(x).max()) for x in (lo, hi, ways))
    return lo + (ways.min(axis=1) - pad)[:, None], hi + (ways.max(axis=1) + pad)[:, None]


def side_of(body: Body) -> CompoundSide:
    shape = shape_of(body)
    if not isinstance(shape, Compound):
        return CompoundSide(body, (None,), (body,))
    bodies = tuple(Moving(x.body, body.motion) if isinstance(body, Moving) else x.body for x in shape.pieces)
    return CompoundSide(body, shape.pieces, bodies)


@dataclass(frozen=True, order=True)
class PairWindow:
    """A stretch of time in which two pieces, by their numbers, may meet; outside of their windows they do not."""

    first: fmpq
    last: fmpq | None
    a: int
    b: int


def windows(a: CompoundSide, b: CompoundSide, query: Query) -> list[PairWindow]:
    """All of them, in order of time."""
    shift = _shift_of(a, b, query)
    if shift is not None:
        return _while_boxes_meet(a, b, query, shift)
    whole = [(below(query.first), np.inf if query.last is None else above(query.last))]
    all_a, all_b = np.arange(len(a.bodies)), np.arange(len(b.bodies))
    pairs = overlapping(a.boxes(all_a, whole), b.boxes(all_b, whole))
    if len(pairs) <= FEW or query.last is None or query.last <= query.first:
        return [PairWindow(query.first, query.last, i, j) for i, j in pairs.tolist()]
    return sorted(_runs(a, b, query, pairs))


def _shift_of(a: CompoundSide, b: CompoundSide, query: Query) -> np.ndarray | None:
    """(3,) by which a is shifted in one unit of time as seen from b; None where they do more than shift, are unbounded
    or the span is a short one far from 0."""
    vectors = [_drift_of(side.body) for side in (a, b)]
    if vectors[0] is None or vectors[1] is None or query.last is None:
        return None
    span = query.last - query.first
    if not (span > 0 and max(abs(query.first), abs(query.last)) <= MOST_LATE * span):
        return None
    shift = np.array([to_double(x - y) for x, y in zip(*vectors, strict=True)])
    finite = all(math.isfinite(_reach_of(shape_of(side.body))) for side in (a, b))
    return shift if finite and np.isfinite(shift).all() else None


def _reach_of(shape: Shape) -> float:
    """The largest coordinate of the boxes around the pieces; kept on the body."""
    return _REACH.of(shape, lambda: max(float(np.abs(x).max(initial=0.0)) for x in _boxes_of(shape)))


def _drift_of(body: Body) -> Vector | None:
    return None if getattr(shape_of(body), "deforming", False) else drift_of(body)


def _while_boxes_meet(a: CompoundSide, b: CompoundSide, query: Query, shift: np.ndarray) -> list[PairWindow]:
    """The times in which boxes of pairs overlap, in order, with some room: they are free when these begin.

    Room is a whole step of the grid of times, which is far beyond what rounding does to these.
    """
    (lo_a, hi_a), (lo_b, hi_b) = _boxes_of(shape_of(a.body)), _boxes_of(shape_of(b.body))
    pad = ROUNDING * max(_reach_of(shape_of(side.body)) for side in (a, b))
    least, most = lo_b - hi_a[:, None] - pad, hi_b - lo_a[:, None] + pad  # shifts with which they overlap
    moves = shift != 0.0
    still = ~moves
    with np.errstate(over="ignore"):  # of what hardly moves
        ends = np.array([least[..., moves], most[..., moves]]) / shift[moves]
    enter = ends.min(axis=0).max(axis=2, initial=-np.inf)
    leave = ends.max(axis=0).min(axis=2, initial=np.inf)
    first, span = query.first, query.end - query.first
    begin, step = to_double(first), to_double(span / STEPS)
    starts = np.clip(np.floor((enter - begin) / step) - 1.0, 0.0, STEPS)
    stops = np.clip(np.ceil((leave - begin) / step) + 1.0, 0.0, STEPS)
    meet = (enter <= leave) & (starts < stops) & ((least <= 0.0) & (most >= 0.0))[..., still].all(axis=2)
    of_a, of_b = np.nonzero(meet)
    begun, ended = (x[of_a, of_b].astype(int).tolist() for x in (starts, stops))
    rows = zip(begun, ended, of_a.tolist(), of_b.tolist(), strict=True)
    unit = span / STEPS
    return [PairWindow(first + unit * start, first + unit * stop, i, j) for start, stop, i, j in sorted(rows)]


def _runs(a: CompoundSide, b: CompoundSide, query: Query, pairs: np.ndarray) -> Iterator[PairWindow]:
    """The slabs in which each pair may meet, neighbouring ones joined."""
    of_a, of_b = np.unique(pairs[:, 0]), np.unique(pairs[:, 1])
    i, j = np.searchsorted(of_a, pairs[:, 0]), np.searchsorted(of_b, pairs[:, 1])
    ends = [query.first + (query.end - query.first) * fmpq(k, SLABS) for k in range(SLABS + 1)]
    slabs = [(below(first), above(last)) for first, last in pairwise(ends)]
    (lo_a, hi_a), (lo_b, hi_b) = a.boxes(of_a, slabs), b.boxes(of_b, slabs)
    near = np.zeros((SLABS + 2, len(pairs)), bool)
    near[1:-1] = ~((lo_a[:, i] > hi_b[:, j]) | (lo_b[:, j] > hi_a[:, i])).any(axis=2)
    change = np.diff(near.astype(int), axis=0)
    for k, (one, other) in enumerate(pairs.tolist()):
        starts, stops = np.flatnonzero(change[:, k] > 0), np.flatnonzero(change[:, k] < 0)
        for start, stop in zip(starts.tolist(), stops.tolist(), strict=True):
            yield PairWindow(ends[start], ends[stop], one, other)


def overlapping(a: Boxes, b: Boxes) -> np.ndarray:
    """(k, 2) numbers of boxes that may share a point over the only span; those with numbers that are none may."""
    (lo_a,), (hi_a,), (lo_b,), (hi_b,) = *a, *b
    return np.argwhere(~((lo_a[:, None] > hi_b) | (lo_b > hi_a[:, None])).any(axis=2))
