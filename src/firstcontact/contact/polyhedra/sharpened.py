"""Enclosures of ends of contact made closer: balls tell the last digits of times whose neighbourhood doubles tell."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from firstcontact.exact.numbers import exact_value
from firstcontact.result import ContactInterval, ContactIntervals
from firstcontact.work import Query

MOST = 16
"""Ends that are looked at."""

Ask = Callable[[Query], ContactIntervals]
Enclosed = tuple[float, tuple[float, float]]


def sharpened(found: ContactIntervals, query: Query, ask: Ask) -> ContactIntervals:
    """The same with what `ask` tells of each end, about a short span around it."""
    if 2 * len(found) > MOST:
        return found
    return replace(found, intervals=tuple(_closer(x, query, ask) for x in found))


def _closer(x: ContactInterval, query: Query, ask: Ask) -> ContactInterval:
    start = _end((x.start, x.start_interval), query, ask, lambda y: (y.start, y.start_interval))
    end = _end((x.end, x.end_interval), query, ask, lambda y: (y.end, y.end_interval))
    return replace(x, start=start[0], start_interval=start[1], end=end[0], end_interval=end[1])


def _end(known: Enclosed, query: Query, ask: Ask, end_of: Callable[[ContactInterval], Enclosed]) -> Enclosed:
    """An end that is known to be in an interval: of the one contact around it, if there is but one, it is the end."""
    lo, hi = known[1]
    if hi <= math.nextafter(lo, math.inf):
        return known
    room = 2 * exact_value(hi - lo)
    first = max(exact_value(lo) - room, query.first)
    last = exact_value(hi) + room
    last = last if query.last is None else min(last, query.last)
    told = ask(replace(query, first=first, last=last, progress=None))
    if told.reason is not None or len(told) != 1:
        return known
    time, (least, most) = end_of(told[0])
    least, most = max(lo, least), min(hi, most)
    return (min(max(time, least), most), (least, most)) if least <= most else known
