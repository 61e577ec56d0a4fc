"""A body that turns beside one that shifts along its axis: seen from that one it is on a screw, and the other rests.

Searches follow one moving body closer than two, and know more of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

from firstcontact.contact.carried import carried
from firstcontact.exact.rigid import rational_sqrt
from firstcontact.exact.vectors import cross, dot
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw, simple
from firstcontact.motion.translation import Translation
from firstcontact.result import ContactIntervals, FirstContact
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body


R = TypeVar("R", FirstContact, ContactIntervals)


def asked(answer: Callable[[Query], R], query: Query) -> R:
    """What `answer` tells of the query, of one body at rest where that is the same question."""
    for turning, other in (query.bodies, query.bodies[::-1]):
        if isinstance(other, Moving) and (seen := _seen_from(turning, other)) is not None:
            still = shape_of(other)
            own = replace(query, a=seen, b=still) if turning is query.a else replace(query, a=still, b=seen)
            return _back(answer(own), query, other)
    return answer(query)


def _seen_from(turning: Body, other: Moving) -> Moving | None:
    """The body that turns as the other one sees it; None where it would be on no screw."""
    if not isinstance(turning, Moving):
        return None
    motion, shift = turning.motion, other.motion
    if not isinstance(motion, Rotation | Screw) or not isinstance(shift, Translation):
        return None
    length = rational_sqrt(dot(motion.axis, motion.axis))
    if length is None or any(cross(motion.axis, shift.vector)):
        return None
    ahead = (motion.advance if isinstance(motion, Screw) else 0) - dot(shift.vector, motion.axis) / length
    screw = Screw(motion.axis, motion.point, **{motion.unit: motion.angle}, advance=ahead)
    return Moving(shape_of(turning), simple(screw))


def _back(found: R, query: Query, other: Moving) -> R:
    """The answer in the world in which both move."""
    if isinstance(found, ContactIntervals):
        return replace(found, a=query.a, b=query.b)
    return carried(found, other.motion, query.a, query.b)
