"""Results out of what was proved of all times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Protocol

from firstcontact.exact.numbers import above, below, exact_value, likely, to_double
from firstcontact.result import ContactInterval, ContactIntervals, Status
from firstcontact.timeline.sweep import Found
from firstcontact.work import Query, Work

if TYPE_CHECKING:
    from flint import fmpq

    from firstcontact.result import ExactTime


def proved_intervals(found: Found, work: Work, query: Query) -> ContactIntervals:
    """What the certified path found, as a result."""
    first, last = query.span
    intervals = []
    for x in found.intervals:
        # windows end at doubles beyond the span's end, which is between doubles; never -0.0
        start, end = (
            (min(max(lo, first), last) + 0.0, max(min(hi, last), first) + 0.0) for lo, hi in (x.start, x.end)
        )
        intervals.append(ContactInterval(likely_time(start), end[0] if x.open else likely_time(end), start, end))
    status, until = Status.FREE, last
    if intervals:
        until = intervals[0].start_interval[0]
        status = Status.INITIAL_CONTACT if intervals[0].start_interval == (first, first) else Status.CONTACT
    if found.reason is not None:
        status, until = Status.UNDECIDED, max(first, found.until)
    merged = tuple(union(intervals))  # one instant where two windows meet may be told of both
    return ContactIntervals(merged, status, until, found.reason, query.stats(work.done), **query.shared)


def enclosing(found: ContactIntervals, query: Query) -> ContactIntervals:
    """The answer; ends that are told as those of the span enclose these, which may lie between doubles."""
    ends = [(to_double(t), below(t), above(t)) for t in (query.first, query.last) if t is not None]
    if all(lo == hi for _, lo, hi in ends):
        return found

    def wide(times: tuple[float, float]) -> tuple[float, float]:
        lo, hi = times
        for end, before, after in ends:
            lo, hi = before if lo == end else lo, after if hi == end else hi
        return lo, hi

    told = (replace(x, start_interval=wide(x.start_interval), end_interval=wide(x.end_interval)) for x in found)
    return replace(found, intervals=tuple(told))


def as_far_as_decided(found: ContactIntervals) -> ContactIntervals:
    """The answer; of one that is UNDECIDED, what is before the time until which all is told.

    An interval that may go on then has the rest of the span to end in.
    """
    if found.status is not Status.UNDECIDED or found.free_until is None:
        return found
    until, last = found.free_until, found.span[1]
    told = [x for x in found.intervals if x.start_interval[0] <= until]
    if told and told[-1].end_interval[1] >= until:
        end = max(told[-1].start, min(told[-1].end_interval[0], until))
        told[-1] = replace(told[-1], end=end, end_interval=(end, last), end_exact=None)
    return replace(found, intervals=tuple(told))


def likely_time(interval: tuple[float, float]) -> float:
    """The double that is nearest to the simplest number of an enclosure."""
    lo, hi = interval
    return min(max(to_double(likely(exact_value(lo), exact_value(hi))), lo), hi)


def union(intervals: Sequence[ContactInterval]) -> list[ContactInterval]:
    """Disjoint, ascending: those that meet, as far as their enclosures tell, are one."""
    merged: list[ContactInterval] = []
    for x in sorted(intervals, key=lambda x: (x.start_interval, x.start)):
        if merged and x.start_interval[0] <= merged[-1].end_interval[1]:
            last = merged[-1]
            later = x if x.end_interval > last.end_interval else last
            merged[-1] = replace(
                last, end=later.end, end_interval=later.end_interval, end_exact=later.end_exact
            )
        else:
            merged.append(x)
    return merged


def all_told(query: Query, told: Sequence[ContactInterval]) -> ContactIntervals:
    """The answer that these, which may meet, and no others are the contacts."""
    merged = tuple(union(told))
    if not merged:
        return ContactIntervals.free(query.stats(), **query.shared)
    begins = merged[0].start_interval[1] <= above(query.first)
    status = Status.INITIAL_CONTACT if begins else Status.CONTACT
    return ContactIntervals(merged, status, merged[0].start, None, query.stats(), **query.shared)


def lasting(start: fmpq, end: fmpq) -> ContactInterval:
    """From one exact time to another."""
    return ContactInterval(to_double(start), to_double(end), (below(start), above(start)), (below(end), above(end)))


class Told(Protocol):
    """A time that tells its nearest double, an enclosure, and itself where it is known exactly."""

    def value(self, exact: bool) -> tuple[float, tuple[float, float], ExactTime | None]: ...


def interval_of(start: Told, end: Told, exact: bool) -> ContactInterval:
    """From ends whose `value(exact)` is the nearest double, an enclosure and the exact time."""
    (t0, lo, exact0), (t1, hi, exact1) = start.value(exact), end.value(exact)
    return ContactInterval(t0, t1, lo, hi, exact0, exact1)
