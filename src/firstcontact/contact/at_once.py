"""Spans of one instant: whether bodies share a point then is all that there is to tell of their intervals."""

from __future__ import annotations

from typing import Protocol

from firstcontact.body.compound.compound import about_models
from firstcontact.exact.numbers import above, below, fraction, to_double
from firstcontact.result import ContactInterval, ContactIntervals, FirstContact, Status
from firstcontact.work import Query


class _Room(Protocol):
    def first(self, query: Query) -> FirstContact: ...
    def intervals(self, query: Query) -> ContactIntervals: ...


def intervals(room: _Room, query: Query) -> ContactIntervals:
    """What a room tells of all intervals of contact."""
    if query.first != query.last:
        return room.intervals(query)
    found = room.first(query)
    time, around = query.first, (below(query.first), above(query.first))
    exact = fraction(time) if query.exact else None
    own = ContactInterval(to_double(time), to_double(time), around, around, exact, exact)
    met = found.status in (Status.CONTACT, Status.INITIAL_CONTACT)
    return ContactIntervals(
        (own,) if met else (), Status.INITIAL_CONTACT if met else found.status, found.free_until, found.reason,
        found.stats, **query.shared, **about_models(*query.bodies),
    )  # fmt: skip
