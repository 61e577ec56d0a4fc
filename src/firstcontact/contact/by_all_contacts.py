"""First contacts that are left open, told by all contacts, without elements.

Times of grazes, and of upright solids on a screw, are known where what touches is not.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import replace

from firstcontact.contact import upright_parts
from firstcontact.contact.ways import Passed, tried
from firstcontact.result import Asked, ContactIntervals, FirstContact, Status
from firstcontact.timeline.answers import as_far_as_decided
from firstcontact.work import Query

WORK = 20_000
"""Budget of a question: some tenths of a second."""


def first(query: Query, found: FirstContact, intervals: Callable[[Query], ContactIntervals]) -> FirstContact | None:
    """None where contacts are left open before the first one, or begin at the start.

    found: what is told, and leaves it open.  intervals: tells all contacts.
    """
    def ask(own: Query) -> ContactIntervals:
        return as_far_as_decided(intervals(own.limited(WORK)))

    told = tried(lambda: ask(query))
    if isinstance(told, Passed) or (told.status is Status.UNDECIDED and not told.intervals):
        told = tried(lambda: upright_parts.intervals(query, None, ask))
    if isinstance(told, Passed) or told.status is Status.INITIAL_CONTACT:
        return None
    ways = *found.stats.ways, Asked("by all contacts", told.status.name, clock.perf_counter() - query.begin)
    stats = replace(found.stats + replace(told.stats, ways=()), seconds=query.stats().seconds, ways=ways)
    if told.status is Status.FREE:
        return FirstContact.free(stats, **query.shared)
    if not told.intervals:
        return None
    start = told.intervals[0]
    lo, hi = start.start_interval
    lo = min(max(lo, found.free_until or lo), hi)
    time = min(max(start.start, lo), hi)
    return FirstContact(Status.CONTACT, time, (lo, hi), free_until=lo, stats=stats, **query.shared)
