"""First contacts and all contacts of bodies that meet by their heights, where other ways leave them open."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import TypeVar

import numpy as np
from flint import fmpq

from firstcontact.contact.advancing import Apart, without_advance
from firstcontact.contact.levels.landing import common_point, without_turns
from firstcontact.contact.levels.meeting import Ascents, Span, ascents_of, rest_within
from firstcontact.contact.upright_parts import parts_of, upright
from firstcontact.contact.ways import Passed, tried
from firstcontact.exact.numbers import above, below, exact_value, to_double
from firstcontact.result import Asked, ContactInterval, ContactIntervals, FirstContact, Status
from firstcontact.timeline.answers import union
from firstcontact.work import Query

MOMENT = fmpq(1, 2**20)
"""Part of a time next to whose ends a point is followed."""

R = TypeVar("R", FirstContact, ContactIntervals)
First = Callable[[Query], FirstContact]
Intervals = Callable[[Query], ContactIntervals]


def first(found: FirstContact, query: Query, ask: First) -> FirstContact:
    """What heights tell of a first contact that is left open; found: what is told of it, ask: tells of others."""
    return _noted(found, query, lambda ascents: _first(found, query, ascents, ask))


def intervals(found: ContactIntervals, query: Query, ask: Intervals, ask_first: First) -> ContactIntervals:
    """The same of all contacts: those of the times at which the bodies have a height in common; of unions of solids
    those of each part."""
    return _noted(found, query, lambda ascents: _intervals(query, ascents, ask, ask_first))


def first_at_once(query: Query, ask: First) -> FirstContact | None:
    """The first contact of bodies whose heights meet at instants alone, if at all; None of others, and where that is
    left open."""
    def tell(ascents: Ascents) -> FirstContact | None:
        instants = _instants(query, ascents)
        for instant in instants or ():
            meets = _meet_at(query, ascents, instant, ask)
            if meets is not False:
                return _landed(query, ascents, instant, ask) if meets and instant > query.first else None
        return None if instants is None else FirstContact.free(query.stats(), **query.shared)

    return _told_at_once(query, tell)


def intervals_at_once(query: Query, ask_first: First) -> ContactIntervals | None:
    """The same of all contacts."""
    def tell(ascents: Ascents) -> ContactIntervals | None:
        instants = _instants(query, ascents)
        meets = [_meet_at(query, ascents, t, ask_first) for t in instants or ()]
        if instants is None or None in meets:
            return None
        return _all(query, [_lasting(t, t) for t, met in zip(instants, meets, strict=True) if met])

    return _told_at_once(query, tell)


def _told_at_once(query: Query, tell: Callable[[Ascents], R | None]) -> R | None:
    begin, ascents = clock.perf_counter(), ascents_of(query)
    told = None if ascents is None else tried(lambda: tell(ascents))
    if told is None or isinstance(told, Passed):
        return None
    end = clock.perf_counter()
    asked = Asked("by heights", told.status.name, end - begin)
    return replace(told, stats=replace(query.stats(), ways=(asked,), seconds=end - query.begin), **query.shared)


def _instants(query: Query, ascents: Ascents) -> list[fmpq] | None:
    """The times at which the bodies have a height in common; None where that lasts, or of one instant alone."""
    spans = ascents.meetings()
    if query.first == query.end or any(start < end for start, end in spans):
        return None
    return [start for start, _ in spans]


def _meet_at(query: Query, ascents: Ascents, time: fmpq, ask_first: First) -> bool | None:
    """Whether the bodies share a point at an instant; None where that is left open."""
    if common_point(query, ascents, time) is not None:
        return True
    then = ask_first(replace(query, first=time, last=time, progress=None)).status
    return True if then is Status.INITIAL_CONTACT else False if then is Status.FREE else None


def _noted(found: R, query: Query, tell: Callable[[Ascents], R | None]) -> R:
    """What heights tell, as a way that was asked; else what was found."""
    begin, ascents = clock.perf_counter(), ascents_of(query)
    told = None if ascents is None else tried(lambda: tell(ascents))
    if told is None or isinstance(told, Passed):
        return found
    end = clock.perf_counter()
    ways = *found.stats.ways, Asked("by heights", told.status.name, end - begin)
    return replace(told, stats=replace(found.stats, ways=ways, seconds=end - query.begin), **query.shared)


def _first(found: FirstContact, query: Query, ascents: Ascents, ask: First) -> FirstContact | None:
    assert found.free_until is not None
    until = max(exact_value(found.free_until), query.first)
    later = [span for span in ascents.meetings() if span[1] >= until]
    if not later:
        return FirstContact.free(found.stats, **query.shared)
    time = later[0][0]
    if time == query.first and (point := common_point(query, ascents, time)) is not None:
        return _touching(query, point)
    if time > query.first and time >= until and (told := _landed(query, ascents, time, ask)) is not None:
        return told
    if (told := _by_turns(query, ascents, ask)) is not None:
        return told
    return replace(found, free_until=below(time)) if time > until else None


def _landed(query: Query, ascents: Ascents, time: fmpq, ask: First) -> FirstContact | None:
    """Contact at an instant up to which all is free; None where none is proved.  What meets is told without turns."""
    point = common_point(query, ascents, time)
    if point is None and ask(replace(query, first=time, last=time, progress=None)).status is not Status.INITIAL_CONTACT:
        return None
    times = below(time), above(time)
    told = FirstContact(Status.CONTACT, to_double(time), times, point=point, free_until=times[0], **query.shared)
    straight = tried(lambda: ask(without_turns(query, ascents, time)))
    if isinstance(straight, Passed) or straight.status is not Status.CONTACT or straight.time_interval is None:
        return told
    if straight.time_interval[1] < times[0]:
        return told
    return replace(
        told, point=straight.point, normal=straight.normal, element_a=straight.element_a, element_b=straight.element_b,
        contact_set=straight.contact_set, others=straight.others, multiplicity=straight.multiplicity,
    )  # fmt: skip


def _touching(query: Query, point: np.ndarray) -> FirstContact:
    """A start at which one body is on the other: what they share is at a height at which neither has inner points."""
    start = query.span[0]
    return FirstContact(
        Status.INITIAL_CONTACT, start, (start, start), initial="touching", point=point, free_until=start,
        **query.shared,
    )  # fmt: skip


def _by_turns(query: Query, ascents: Ascents, ask: First) -> FirstContact | None:
    """Of two bodies that are the same at all heights and advance on a screw: what their turn alone tells."""
    other = without_advance(query, upright)
    if isinstance(other, Apart):
        return FirstContact.free(query.stats(), **query.shared)
    found = None if other is None else ask(other)
    if found is None or found.status not in (Status.FREE, Status.CONTACT):
        return None
    if found.status is Status.FREE:
        return FirstContact.free(query.stats(), **query.shared)
    # what meets of a taller body may be beyond the own one
    point = _raised(found, ascents)
    return replace(found, point=point, element_a=None, element_b=None, others=(), multiplicity=0, contact_set=None)


def _raised(found: FirstContact, ascents: Ascents) -> np.ndarray | None:
    """The point of contact, at the lowest height that the bodies have in common then."""
    if found.point is None or found.time is None:
        return None
    low, n = to_double(ascents.lowest_at(exact_value(found.time))), np.array([to_double(c) for c in ascents.normal])
    point: np.ndarray = found.point + n * (low - float(n @ found.point)) / float(n @ n)
    return point


def _intervals(query: Query, ascents: Ascents, ask: Intervals, ask_first: First) -> ContactIntervals | None:
    parts = list(product(*map(parts_of, query.bodies)))
    told: list[ContactInterval] = []
    for a, b in parts:
        part = replace(query, a=a, b=b)
        own = _of_part(part, ascents if len(parts) == 1 else ascents_of(part), ask, ask_first, len(parts) == 1)
        if own is None:
            return None
        told += own
    return _all(query, told)


def _all(query: Query, told: list[ContactInterval]) -> ContactIntervals:
    """The answer that these, and no others, are the contacts."""
    merged = tuple(union(told))
    if not merged:
        return ContactIntervals.free(query.stats(), **query.shared)
    begins = merged[0].start_interval[1] <= above(query.first)
    status = Status.INITIAL_CONTACT if begins else Status.CONTACT
    return ContactIntervals(merged, status, merged[0].start, None, query.stats(), **query.shared)


def _of_part(
    query: Query, ascents: Ascents | None, ask: Intervals, ask_first: First, is_whole: bool
) -> list[ContactInterval] | None:
    """The contacts of two bodies, or two parts of them; None where they are left open."""
    spans = [(query.first, query.end)] if ascents is None else ascents.meetings()
    if ascents is None or (spans == [(query.first, query.end)] and query.first < query.end):
        found = None if is_whole else ask(query)
        return None if found is None or found.status is Status.UNDECIDED else list(found)
    told: list[ContactInterval] = []
    for span in spans:
        own = _within(query, ascents, span, ask, ask_first)
        if own is None:
            return None
        told += own
    return told


def _within(
    query: Query, ascents: Ascents, span: Span, ask: Intervals, ask_first: First
) -> list[ContactInterval] | None:
    """The contacts in one of those times; None where they are left open."""
    start, end = span
    if start < end and not all(rest_within(x, start, end) for x in query.bodies):
        found = ask(replace(query, first=start, last=end, progress=None))
        return _but_for_ends(query, ascents, span, ask) if found.status is Status.UNDECIDED else list(found)
    meets = _meet_at(query, ascents, start, ask_first)
    return None if meets is None else [_lasting(start, end)] if meets else []


def _but_for_ends(query: Query, ascents: Ascents, span: Span, ask: Intervals) -> list[ContactInterval] | None:
    """The same, where a point that is shared next to an end stays so, which those who are asked do not tell."""
    (start, end), told = span, []
    room = MOMENT * (end - start)
    if common_point(query, ascents, start, (start, start + room)) is not None:
        told.append(_lasting(start, start + room))
        start += room
    if common_point(query, ascents, end, (end - room, end)) is not None:
        told.append(_lasting(end - room, end))
        end -= room
    if not told:
        return None
    found = ask(replace(query, first=start, last=end, progress=None))
    return None if found.status is Status.UNDECIDED else [*told, *found]


def _lasting(start: fmpq, end: fmpq) -> ContactInterval:
    ends = (below(start), above(start)), (below(end), above(end))
    return ContactInterval(to_double(start), to_double(end), *ends)
