"""First contacts and all contacts of bodies that meet by their heights, where other ways leave them open."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any, TypeVar

import numpy as np
from flint import fmpq

from firstcontact.contact.advancing import Apart, without_advance
from firstcontact.contact.heights.landing import common_point, landed
from firstcontact.contact.heights.meeting import Ascents, Span, ascents_of, rest_within
from firstcontact.contact.upright_parts import parts_of, upright
from firstcontact.contact.ways import Passed, tried
from firstcontact.exact.numbers import below, exact_value
from firstcontact.result import Asked, ContactInterval, ContactIntervals, FirstContact, Stats, Status
from firstcontact.timeline.answers import all_told, lasting
from firstcontact.work import Query

MOMENT = fmpq(1, 2**20)
"""Part of a time next to whose ends a point is followed."""

HALVINGS = 6
"""Of a time in which one body lies on another."""

R = TypeVar("R", FirstContact, ContactIntervals)
First = Callable[[Query], FirstContact]
Intervals = Callable[[Query], ContactIntervals]
OfRoom = Callable[[str, Query], Any]


def first(query: Query, found: FirstContact | None, of_room: OfRoom) -> FirstContact | None:
    """The first contact, where heights tell it.

    found: what is told of it, and leaves it open; None where nothing is asked yet: then bodies are taken whose heights
    meet at instants alone.  of_room(verb, query): tells of others.
    """
    ask: First = partial(of_room, "first")
    if found is None:
        return _noted(query, query.stats(), lambda ascents: _first_of_instants(query, ascents, ask))
    return _noted(query, found.stats, lambda ascents: _first(found, query, ascents, ask))


def intervals(query: Query, found: ContactIntervals | None, of_room: OfRoom) -> ContactIntervals | None:
    """The same of all contacts, which are at times at which the bodies have a height in common; of unions of solids by
    their parts."""
    ask: Intervals = partial(of_room, "intervals")
    ask_first: First = partial(of_room, "first")
    if found is None:
        return _noted(query, query.stats(), lambda ascents: _all_of_instants(query, ascents, ask, ask_first))
    return _noted(query, found.stats, lambda ascents: _intervals(query, ascents, ask, ask_first))


def _noted(query: Query, stats: Stats, tell: Callable[[Ascents], R | None]) -> R | None:
    """What heights tell, as a way that was asked after those of the stats."""
    begin, ascents = clock.perf_counter(), ascents_of(query)
    told = None if ascents is None else tried(lambda: tell(ascents))
    if told is None or isinstance(told, Passed):
        return None
    end = clock.perf_counter()
    ways = *stats.ways, Asked("by heights", told.status.name, end - begin)
    return replace(told, stats=replace(stats, ways=ways, seconds=end - query.begin), **query.shared)


# -- of instants, and of rests ---------------------------------------------------------------------------------


def _instants(query: Query, ascents: Ascents) -> list[Span] | None:
    """The times at which the bodies have a height in common, one alone; None where they have more, and of one instant
    of a question."""
    spans = ascents.meetings()
    return spans if query.first < query.end and all(map(ascents.is_touch, spans)) else None


def _first_of_instants(query: Query, ascents: Ascents, ask: First) -> FirstContact | None:
    spans = _instants(query, ascents)
    for start, end in spans or ():
        meets, point = _meet_at(query, ascents, start, ask)
        if meets is None or (meets and start == query.first) or (not meets and start < end):
            return None
        if meets:
            return landed(query, ascents.normal, start, ask, point)
    return None if spans is None else FirstContact.free(query.stats(), **query.shared)


def _all_of_instants(query: Query, ascents: Ascents, ask: Intervals, ask_first: First) -> ContactIntervals | None:
    spans, told = _instants(query, ascents), list[ContactInterval]()
    for span in spans or ():
        own = _at_rest(query, ascents, span, ask) if span[0] < span[1] else None
        if span[0] == span[1]:
            meets, _ = _meet_at(query, ascents, span[0], ask_first)
            own = None if meets is None else [lasting(*span)] if meets else []
        if own is None:
            return None
        told += own
    return None if spans is None else all_told(query, told)


def _at_rest(query: Query, ascents: Ascents, span: Span, ask: Intervals) -> list[ContactInterval] | None:
    """The contacts while one body is on the other; None where they are left open."""
    if _is_flush(query, ascents, span, HALVINGS):
        return [lasting(*span)]
    turn = ascents.level(query, span)
    found = None if turn is None else ask(turn)
    return None if found is None or found.status is Status.UNDECIDED else list(found)


def _meet_at(
    query: Query, ascents: Ascents, time: fmpq, ask_first: First
) -> tuple[bool | None, np.ndarray | None]:
    """(whether the bodies share a point at an instant, None where that is left open; the point, where it is known)."""
    point = common_point(query, ascents, time)
    if point is not None:
        return True, point
    then = ask_first(replace(query, first=time, last=time, progress=None)).status
    return True if then is Status.INITIAL_CONTACT else False if then is Status.FREE else None, None


# -- first contacts that are left open ------------------------------------------------------------------------


def _first(found: FirstContact, query: Query, ascents: Ascents, ask: First) -> FirstContact | None:
    assert found.free_until is not None
    until = max(exact_value(found.free_until), query.first)
    later = [span for span in ascents.meetings() if span[1] >= until]
    if not later:
        return FirstContact.free(found.stats, **query.shared)
    time = later[0][0]
    if time == query.first and (point := common_point(query, ascents, time)) is not None:
        return _touching(query, point)
    if query.first < time and until <= time:
        meets, point = _meet_at(query, ascents, time, ask)
        if meets:
            return landed(query, ascents.normal, time, ask, point)
    if (told := _by_turns(query, ascents, ask)) is not None:
        return told
    return replace(found, free_until=below(time)) if time > until else None


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
    assert found.time is not None
    point = None if found.point is None else ascents.raised(found.point, exact_value(found.time))
    return replace(found, point=point, element_a=None, element_b=None, others=(), multiplicity=0, contact_set=None)


# -- all contacts that are left open --------------------------------------------------------------------------


def _intervals(query: Query, ascents: Ascents, ask: Intervals, ask_first: First) -> ContactIntervals | None:
    parts = list(product(*map(parts_of, query.bodies)))
    told: list[ContactInterval] = []
    for a, b in parts:
        part = replace(query, a=a, b=b)
        own = _of_part(part, ascents if len(parts) == 1 else ascents_of(part), ask, ask_first, len(parts) == 1)
        if own is None:
            return None
        told += own
    return all_told(query, told)


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
        part = replace(query, first=start, last=end, progress=None)
        found = ask(ascents.level(query, span) or part)
        return _but_for_ends(query, ascents, span, ask) if found.status is Status.UNDECIDED else list(found)
    meets, _ = _meet_at(query, ascents, start, ask_first)
    return None if meets is None else [lasting(start, end)] if meets else []


def _but_for_ends(query: Query, ascents: Ascents, span: Span, ask: Intervals) -> list[ContactInterval] | None:
    """The same, where a point that is shared next to an end stays so, which those who are asked do not tell."""
    (start, end), told = span, []
    room = MOMENT * (end - start)
    if common_point(query, ascents, start, (start, start + room)) is not None:
        told.append(lasting(start, start + room))
        start += room
    if common_point(query, ascents, end, (end - room, end)) is not None:
        told.append(lasting(end - room, end))
        end -= room
    if not told:
        return None
    found = ask(replace(query, first=start, last=end, progress=None))
    if found.status is not Status.UNDECIDED:
        return [*told, *found]
    return [*told, lasting(start, end)] if _is_flush(query, ascents, (start, end), HALVINGS) else None


def _is_flush(query: Query, ascents: Ascents, span: Span, halvings: int) -> bool:
    """Whether points are shared all the time, each of which is followed for a part of it."""
    start, end = span
    if common_point(query, ascents, start, span) is not None:
        return True
    middle = (start + end) / 2
    return halvings > 0 and all(_is_flush(query, ascents, x, halvings - 1) for x in ((start, middle), (middle, end)))
