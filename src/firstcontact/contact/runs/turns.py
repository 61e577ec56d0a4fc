"""Bodies that turn many times about one line: what they do in one full turn they do in all.

Of turns that are no rational part of the span, and where exact times are asked for, each is asked about.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise

from flint import fmpq

from firstcontact.contact.runs import seams
from firstcontact.exact.numbers import above, below, exact_value
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative.pieces import MotionPiece, pieces
from firstcontact.motion.rotation import Rotation, turns_of
from firstcontact.result import ContactInterval, ContactIntervals, Stats, Status
from firstcontact.timeline.answers import likely_time
from firstcontact.work import Query

FEW = 2
"""Turns that are asked about at once."""


def intervals(answer: Callable[[Query], ContactIntervals], query: Query) -> ContactIntervals:
    """What `answer` tells of the query."""
    piece = _turning(query)
    if piece is None:
        return answer(query)
    if piece.rate[0] != 0 or query.exact:
        return seams.intervals(answer, query, _parts(query, piece))
    turn = 1 / abs(piece.rate[1])
    count = int(((query.end - query.first) / turn).floor())
    if not count:  # both turn often, and less than once about each other
        return answer(query)
    whole = query.first + count * turn
    first, *others = [query.part(query.first + k * turn, query.first + (k + 1) * turn) for k in range(count)]
    own = answer(first)
    if own.status is Status.UNDECIDED:
        return replace(own, **query.shared)

    def told(part: Query) -> ContactIntervals:
        return answer(part) if part.first == whole else _later(own, first, part)

    rest = [query.part(whole, query.end)] if whole < query.end else []
    return seams.intervals(told, query, [first, *others, *rest])


def _turning(query: Query) -> MotionPiece | None:
    """The relative motion of bodies that make more than a few turns about one line."""
    if query.last is None:
        return None
    motions = [body.motion for body in query.bodies if isinstance(body, Moving)]
    if not motions or not all(isinstance(x, Rotation) for x in motions):
        return None
    if sum(turns_of(x) for x in motions) * (query.end - query.first) <= FEW:
        return None
    if any(getattr(shape_of(body), "deforming", False) for body in query.bodies):
        return None
    (piece,) = pieces(query.a, query.b, query.first, query.end)
    return piece if isinstance(piece, MotionPiece) and any(piece.rate) else None


def _parts(query: Query, piece: MotionPiece) -> Iterator[Query]:
    """The span cut into parts of about one turn each."""
    turns = abs(piece.rate[0]) / 6 + abs(piece.rate[1])
    count = max(1, int(((query.end - query.first) * turns).ceil()))
    times = [query.first + (query.end - query.first) * fmpq(k, count) for k in range(count + 1)]
    for start, end in pairwise(times):
        yield query.part(start, end)


def _later(found: ContactIntervals, own: Query, part: Query) -> ContactIntervals:
    """What was found in a turn, as long after the beginning of another one; what lasts to its ends does so there."""
    (first, last), after = own.span, part.first - own.first
    if not after:
        return found

    def moved(times: tuple[float, float]) -> tuple[float, float]:
        lo, hi = (min(max(exact_value(t) + after, part.first), part.end) for t in times)
        return below(part.first if times[0] <= first else lo), above(part.end if times[1] >= last else hi)

    told = []
    for x in found.intervals:
        start, end = moved(x.start_interval), moved(x.end_interval)
        told.append(ContactInterval(likely_time(start), likely_time(end), start, end))
    return replace(found, intervals=tuple(told), span=part.span, stats=Stats())
