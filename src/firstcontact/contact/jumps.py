"""Motions that jump: what happens before and after a jump are questions of their own.

A search follows bodies from where they start, outside of each other; after a jump they may be anywhere, as they may be
at a start.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise
from typing import Any

from flint import fmpq

from firstcontact.contact.runs import seams
from firstcontact.exact.numbers import fraction
from firstcontact.motion.moving import Moving
from firstcontact.motion.relative.pieces import placement_at
from firstcontact.motion.sequence import Sequence
from firstcontact.result import ContactIntervals, FirstContact, Stats, Status
from firstcontact.work import Query


def first(answer: Callable[[Query], FirstContact], query: Query) -> FirstContact:
    """What `answer` tells of the query."""
    times = _jumps(query)
    if not times:
        still = _at_an_instant(query)
        return answer(query) if still is query else replace(answer(still), **query.shared)
    return seams.first(answer, query, _stretches(query, times))


def intervals(answer: Callable[[Query], ContactIntervals], query: Query) -> ContactIntervals:
    """What `answer` tells of the query."""
    times = _jumps(query)
    if not times:
        return replace(answer(_at_an_instant(query)), **query.shared)
    from firstcontact.contact.compound.answer import joined  # few motions jump

    told, stats = list[ContactIntervals](), Stats()
    for own in _stretches(query, times):
        told.append(answer(replace(own, budget=query.budget_after(stats))))
        stats = stats + told[-1].stats
        if told[-1].status is Status.UNDECIDED:
            break
    return replace(joined(query, told), stats=replace(stats, seconds=query.stats().seconds))


def _jumps(query: Query) -> list[fmpq]:
    """The times after the start of the span at which a body jumps, ascending; where one makes steps, spans have an end.
    """
    if query.last is None:
        return []
    motions = [body.motion for body in query.bodies if isinstance(body, Moving)]
    times = {t for motion in motions if isinstance(motion, Sequence) for t in motion.jumps}
    return sorted(t for t in times if query.first < t <= query.last)


def _at_an_instant(query: Query) -> Query:
    """A question about one instant at which a body jumps, of this body at rest where it stands after that."""
    if query.first != query.last:
        return query
    a, b = (_placed(body, query.first) for body in query.bodies)
    return query if a is query.a and b is query.b else replace(query, a=a, b=b)


def _placed(body: Any, time: fmpq) -> Any:
    if not isinstance(body, Moving) or not isinstance(body.motion, Sequence) or time not in body.motion.jumps:
        return body
    place = placement_at(body, time)
    return place.place(body.body) if place.is_exact else body


def _stretches(query: Query, times: list[fmpq]) -> Iterator[Query]:
    """The question about each stretch between jumps, of bodies that stand at its end as they do before the jump; the
    last instant is a stretch where they jump then."""
    for start, end in pairwise([query.first, *times, query.end]):
        a, b = (_until(body, end) if start < end in times else body for body in query.bodies)
        yield _at_an_instant(replace(query.part(start, end), a=a, b=b))


def _until(body: object, end: fmpq) -> object:
    """The body without its steps from then on."""
    if not isinstance(body, Moving) or not isinstance(body.motion, Sequence) or end not in body.motion.jumps:
        return body
    steps = [step for step, start in zip(body.motion.steps, body.motion.starts, strict=True) if start < end]
    return Moving(body.body, Sequence(steps, [fraction(x) for x in body.motion.durations[: len(steps)]]))
