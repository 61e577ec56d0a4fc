"""Bodies that move by one motion: they rest with each other, and are asked about so."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

from firstcontact.contact.carried import carried
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw
from firstcontact.motion.trajectory import Trajectory
from firstcontact.motion.translation import Translation
from firstcontact.result import ContactIntervals, FirstContact

if TYPE_CHECKING:
    from firstcontact.motion.kinds import AnyMotion
    from firstcontact.work import Query

R = TypeVar("R", FirstContact, ContactIntervals)


def asked(answer: Callable[[Query], R], query: Query) -> R:
    """What `answer` tells of the query, of two bodies at rest where one motion carries both."""
    a, b = query.a, query.b
    if not (isinstance(a, Moving) and isinstance(b, Moving)) or a.motion != b.motion or not _is_rigid(a.motion):
        return answer(query)
    found = answer(replace(query, a=shape_of(a), b=shape_of(b)))
    if isinstance(found, ContactIntervals):
        return replace(found, a=a, b=b)
    return carried(found, a.motion, a, b)


def _is_rigid(motion: AnyMotion) -> bool:
    """Whether it keeps bodies apart that are apart: no pose of it is singular, as those of other motions may be."""
    if isinstance(motion, Trajectory):
        return True
    steps = getattr(motion, "steps", (motion,))
    return all(isinstance(x, Translation | Rotation | Screw) or getattr(x, "rigid", False) for x in steps)
