"""Bodies that move by one motion: they rest with each other, and are asked about so."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

from firstcontact.contact.carried import carried
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.result import ContactIntervals, FirstContact

if TYPE_CHECKING:
    from firstcontact.work import Query

R = TypeVar("R", FirstContact, ContactIntervals)


def asked(answer: Callable[[Query], R], query: Query) -> R:
    """What `answer` tells of the query, of two bodies at rest where one motion carries both.

    A rigid one, that keeps bodies apart that are apart: other poses may be singular.
    """
    a, b = query.a, query.b
    if not (isinstance(a, Moving) and isinstance(b, Moving)) or a.motion != b.motion or not a.motion.is_rigid:
        return answer(query)
    found = answer(replace(query, a=shape_of(a), b=shape_of(b)))
    if isinstance(found, ContactIntervals):
        return replace(found, a=a, b=b)
    return carried(found, a.motion, a, b)
