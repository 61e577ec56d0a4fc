"""All contacts of polyhedra that touch at the start of a motion without rational poses, told from a moment later on.

Flush faces have many pairs of elements that all meet then, and to follow each of them from that instant takes long, or
is not decided; a moment later they are apart, or overlap, and both are soon told.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from flint import fmpq

from firstcontact.contact.ways import Passed, decided
from firstcontact.exact.numbers import above, below, to_double
from firstcontact.result import ContactInterval, ContactIntervals, FirstContact, Status
from firstcontact.timeline.answers import likely_time, union
from firstcontact.work import Query

MOMENT = fmpq(1, 2**40)
"""Of the span: within 1e-12 of it, contacts are told as one, and their ends no closer."""


def intervals(
    query: Query, first: Callable[[Query], FirstContact], rest: Callable[[Query], ContactIntervals]
) -> ContactIntervals | Passed:
    """What `first` or `rest` tells of the times from a moment after the start on, with the touch then."""
    later = query.first + MOMENT * (query.end - query.first)
    if not _is_touching(first(query.at_start)):
        return Passed("they do not touch at the start alone")
    own = replace(query, first=later)
    soon = first(own)
    if soon.status is Status.UNDECIDED or _is_touching(soon):
        return Passed("they still touch a moment later")
    found = ContactIntervals.free(soon.stats, **own.shared) if soon.status is Status.FREE else rest(own)
    start, end = _around(query.first, query.first), _around(query.first, later)
    touch = ContactInterval(to_double(query.first), likely_time(end), start, end)
    known = replace(found, intervals=tuple(union([touch, *found.intervals])), **query.shared)
    if found.status is Status.UNDECIDED:
        return decided(known, query)
    return replace(known, status=Status.INITIAL_CONTACT, free_until=start[0])


def _is_touching(found: FirstContact) -> bool:
    return found.status is Status.INITIAL_CONTACT and found.initial not in ("overlapping", "containment")


def _around(first: fmpq, last: fmpq) -> tuple[float, float]:
    return below(first), above(last)
