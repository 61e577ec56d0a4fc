"""What a room tells, about times that lie between doubles; and of spans of one instant, whose intervals are whether
bodies share a point then."""

from __future__ import annotations

from typing import Protocol

from firstcontact.body.compound.compound import about_models
from firstcontact.contact.later import changed
from firstcontact.exact.numbers import above, below, fraction, to_double
from firstcontact.result import ContactInterval, ContactIntervals, FirstContact, Status
from firstcontact.timeline.answers import enclosing
from firstcontact.work import Query


class _Room(Protocol):
    def first(self, query: Query) -> FirstContact: ...
    def intervals(self, query: Query) -> ContactIntervals: ...


def first(room: _Room, query: Query) -> FirstContact:
    """What a room tells of the first contact; that at the start encloses it."""
    found = room.first(query)
    if found.status is not Status.INITIAL_CONTACT:
        return found
    around = below(query.first), above(query.first)
    return found if found.time_interval == around else changed(found, time_interval=around)


def intervals(room: _Room, query: Query) -> ContactIntervals:
    """What a room tells of all intervals of contact."""
    if query.first != query.last:
        return enclosing(room.intervals(query), query)
    found = room.first(query)
    time, around = query.first, (below(query.first), above(query.first))
    exact = fraction(time) if query.exact else None
    own = ContactInterval(to_double(time), to_double(time), around, around, exact, exact)
    met = found.status in (Status.CONTACT, Status.INITIAL_CONTACT)
    return ContactIntervals(
        (own,) if met else (), Status.INITIAL_CONTACT if met else found.status, found.free_until, found.reason,
        found.stats, **query.shared, **about_models(*query.bodies),
    )  # fmt: skip
