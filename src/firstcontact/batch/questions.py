"""What a batch asks: bodies, each once, and for each question two of them, their motions and a span."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from firstcontact.contact.table import as_body
from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import exact_value, to_double
from firstcontact.motion.arrays import Motions, MovingEach, Rotations, Translations
from firstcontact.motion.moving import Moving
from firstcontact.motion.translation import Translation

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from firstcontact.body.kinds import AnyBody, Body
    from firstcontact.exact.numbers import Given
    from firstcontact.motion.kinds import AnyMotion

Span: TypeAlias = "Sequence[Given]"
Each: TypeAlias = "Motions | Sequence[AnyMotion | None] | None"
"""A motion, or None, for each question; None: nothing moves."""
PairAsked: TypeAlias = (
    "tuple[AnyBody | MovingEach, AnyBody | MovingEach] | tuple[AnyBody | MovingEach, AnyBody | MovingEach, Span | None]"
)
Queries: TypeAlias = "Questions | PairAsked | Iterable[PairAsked]"
"""What is asked: questions one after the other, or one, of a body that moves by many motions."""


@dataclass(frozen=True)
class Questions:
    """bodies: at rest in their shapes.  a, b (n,): which of them each question asks about.

    moves_a, moves_b, spans: of each question; spans None: the motions' own.
    """

    bodies: tuple[Body, ...]
    a: np.ndarray
    b: np.ndarray
    moves_a: Each = None
    moves_b: Each = None
    spans: Sequence[Span | None] | None = None

    def __len__(self) -> int:
        return len(self.a)

    def __getitem__(self, row: int) -> tuple[Body, Body, Span | None]:
        """(a, b, span) of one question, as `first_contact` takes them."""
        a, b = (
            shape if moves is None or (motion := moves[row]) is None else Moving(shape, motion)
            for shape, moves in ((self.bodies[self.a[row]], self.moves_a), (self.bodies[self.b[row]], self.moves_b))
        )
        return a, b, None if self.spans is None else self.spans[row]

    def part(self, rows: slice | np.ndarray) -> Questions:
        """Those of a slice, or of an array of rows, about the same bodies."""
        each = (_taken(x, rows) for x in (self.moves_a, self.moves_b, self.spans))
        return Questions(self.bodies, self.a[rows], self.b[rows], *each)

    def about(self, bodies: tuple[Body, ...]) -> Questions:
        """The same questions about other bodies, or without any."""
        return replace(self, bodies=bodies)

    def walkable(self) -> list[tuple[np.ndarray, Translations | Rotations, np.ndarray]]:
        """(rows, motions, ends): where b rests, and a moves by a motion in doubles from 0 to an end, a double."""
        moves, rows = self.moves_a, np.arange(len(self))
        if moves is None:
            return []
        if self.moves_b is not None:
            rows = np.array([k for k in rows.tolist() if self.moves_b[k] is None], np.int64)
        ends = np.ones(len(rows))
        if self.spans is not None:
            ends = np.array([_end(self.spans[k]) for k in rows.tolist()])
            rows, ends = rows[np.isfinite(ends)], ends[np.isfinite(ends)]
        if isinstance(moves, Translations | Rotations):
            return [(rows, moves if len(rows) == len(moves) else moves[rows], ends)]
        if isinstance(moves, Motions):
            return []
        vectors = {k: v for k, row in enumerate(rows.tolist()) if (v := _vector(moves[row])) is not None}
        known = np.array(list(vectors), np.int64)
        return [(rows[known], Translations(list(vectors.values())), ends[known])] if vectors else []


def asked(queries: Queries) -> Questions:
    """The questions of what `first_contacts` is given.  InputError names the one that is none."""
    if isinstance(queries, Questions):
        return queries
    if isinstance(queries, tuple) and any(isinstance(x, MovingEach) for x in queries):
        return _one_pair(queries)
    if isinstance(queries, str | bytes | dict) or not isinstance(queries, Iterable):
        raise InputError(f"queries are {shown(queries)}; {WANTED}")
    return _listed(queries)


WANTED = "give pairs (a, b) or (a, b, span) one after the other, or (a.moving(fc.Translations(vectors)), b)"


def columns(
    bodies: Sequence[AnyBody], pairs: ArrayLike, motions: Motions | None = None, span: Span | None = None
) -> Questions:
    """Questions about pairs of a list of bodies.

    bodies: at rest or moving.  pairs (n, 2): numbers of bodies.  motions: one for each pair, by which its first body,
    then one at rest, moves.  span: of all questions, default None: the motions' own.
    """
    indices = np.asarray(pairs)
    if indices.ndim != 2 or indices.shape[1] != 2 or not np.issubdtype(indices.dtype, np.integer):
        raise InputError(f"pairs have the shape {indices.shape}; give (n, 2) whole numbers, two for each question")
    wrong = np.argwhere((indices < 0) | (indices >= len(bodies)))
    if len(wrong):
        row, side = wrong[0].tolist()
        raise InputError(f"pairs[{row}] names body {indices[row, side]}, but there are bodies 0 to {len(bodies) - 1}")
    if motions is not None and len(motions) != len(indices):
        raise InputError(f"there are {len(motions)} motions for {len(indices)} pairs; give one for each")
    shapes = [as_body(x) for x in bodies]
    own = [x.motion if isinstance(x, Moving) else None for x in shapes]
    a, b = indices.T.astype(np.int32)
    if motions is not None and any(own[k] is not None for k in set(a.tolist())):
        raise InputError("the first body of a pair moves already; give motions for bodies at rest, or none")
    moves = [[own[k] for k in side.tolist()] if any(own) else None for side in (a, b)]
    spans = None if span is None else [span] * len(a)
    shapes = [x.body if isinstance(x, Moving) else x for x in shapes]
    return Questions(tuple(shapes), a, b, motions if motions is not None else moves[0], moves[1], spans)


def _one_pair(query: PairAsked) -> Questions:
    if len(query) not in (2, 3):
        raise InputError(f"queries are a tuple of {len(query)}; {WANTED}")
    a, b, span = (*query, None)[:3]
    counts = {len(x) for x in (a, b) if isinstance(x, MovingEach)}
    if len(counts) > 1:
        raise InputError(f"a and b have {sorted(counts)} motions; give as many of both")
    n = counts.pop()
    shapes: list[Body] = []
    moves: list[Each] = []
    for body in (a, b):
        if isinstance(body, MovingEach):
            shapes.append(as_body(body.body))
            moves.append(body.motions)
        else:
            resting = as_body(body)
            moving = isinstance(resting, Moving)
            shapes.append(resting.body if moving else resting)
            moves.append([resting.motion] * n if moving else None)
    ones = np.zeros(n, np.int32)
    return Questions(tuple(shapes), ones, ones + 1, moves[0], moves[1], None if span is None else [span] * n)


def _listed(queries: Iterable[object]) -> Questions:
    numbers: dict[int, int] = {}
    shapes: list[Any] = []
    sides: tuple[list[int], list[int]] = [], []
    moves: tuple[list[Any], list[Any]] = [], []
    spans: list[Any] = []
    for row, query in enumerate(queries):
        if not isinstance(query, tuple | list) or len(query) not in (2, 3):
            raise InputError(f"query {row} is {shown(query)}; {WANTED}")
        for side, body in enumerate(query[:2]):
            if isinstance(body, MovingEach):
                raise InputError(f"query {row}: {body!r} has many motions; ask about them alone")
            moving = isinstance(body, Moving)
            shape = body.body if moving else body
            number = numbers.setdefault(id(shape), len(shapes))
            if number == len(shapes):
                shapes.append(shape)
            sides[side].append(number)
            moves[side].append(body.motion if moving else None)
        spans.append(query[2] if len(query) == 3 else None)
    a, b = (np.array(side, np.int32) for side in sides)
    spare = [None if not any(x is not None for x in column) else column for column in (*moves, spans)]
    return Questions(tuple(map(as_body, shapes)), a, b, *spare)


def _taken(values: Any, rows: slice | np.ndarray) -> Any:
    if values is None or isinstance(values, Motions) or isinstance(rows, slice):
        return None if values is None else values[rows]
    return [values[k] for k in rows.tolist()]


def _vector(motion: AnyMotion | None) -> list[float] | None:
    """The vector of a translation that doubles hold."""
    if not isinstance(motion, Translation):
        return None
    v = [to_double(x) for x in motion.vector]
    return v if all(exact_value(x) == y for x, y in zip(v, motion.vector, strict=True)) else None


def _end(span: Any) -> float:
    """The end of a span from 0 on, where it is a double; else nan."""
    if span is None:
        return 1.0
    try:
        first, last = span
    except (TypeError, ValueError):
        return math.nan
    plain = all(type(x) in (int, float) for x in (first, last))
    return float(last) if plain and first == 0 and 0 <= last < 2.0**53 else math.nan
