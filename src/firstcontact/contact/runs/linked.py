"""Links of a mechanism: asked about without the joints that both hang on, and only while they may be near.

What two links share moves both: dropped, it carries the answer back to the world.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from firstcontact.body.compound.compound import about_models
from firstcontact.contact.carried import carried
from firstcontact.contact.later import waiting
from firstcontact.contact.runs import seams
from firstcontact.contact.runs.near import during, runs
from firstcontact.motion.linkage import Linkage, apart
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.result import ContactIntervals, ContactPairs, FirstContact, JointValue, Status
from firstcontact.work import Query


def first(answer: Callable[[Query], FirstContact], query: Query) -> FirstContact:
    """What `answer` tells of the query, asked about each time in which the bodies are near."""
    if not _linkages(query):
        return answer(query)
    own, shared = _without_shared(query)
    found = seams.first(answer, own, (during(own, run) for run in runs(own)))
    return replace(found, **query.shared) if found.status is Status.FREE else _told(found, query, shared)


def intervals(answer: Callable[[Query], ContactIntervals], query: Query) -> ContactIntervals:
    """The same of all intervals of contact."""
    if not _linkages(query):
        return answer(query)
    own, _ = _without_shared(query)
    return seams.intervals(answer, query, (during(own, run) for run in runs(own)))


def pairs(answer: Callable[[Query], ContactPairs], query: Query) -> ContactPairs:
    """The same of pairs of elements, at all times."""
    return answer(_without_shared(query)[0] if _linkages(query) else query)


def _linkages(query: Query) -> list[Linkage]:
    return [x.motion for x in query.bodies if isinstance(x, Moving) and isinstance(x.motion, Linkage)]


def _without_shared(query: Query) -> tuple[Query, Linkage | None]:
    """The query about the bodies as the link sees them that both hang on, and how that moves."""
    a, b = query.bodies
    moving = _linkages(query)
    parted = apart(*moving) if len(moving) == 2 else None
    if parted is None:
        return query, None
    bodies = [Moving(shape_of(x), own) if own.drives else shape_of(x) for x, own in zip((a, b), parted, strict=False)]
    return replace(query, a=bodies[0], b=bodies[1]), parted[2]


def _told(found: FirstContact, query: Query, shared: Linkage | None) -> FirstContact:
    """The answer as to the query itself, with the joints' values."""
    there = found if shared is None else carried(found, shared, query.a, query.b)
    joints: dict[str, JointValue] = {}
    if (time := found.time) is not None:
        interval = found.time_interval or (time, time)
        joints = {x.name: x for motion in _linkages(query) for x in motion.joint_values(time, interval)}
    return waiting(there, dict, joints=tuple(joints.values()), **query.shared, **about_models(*query.bodies))
