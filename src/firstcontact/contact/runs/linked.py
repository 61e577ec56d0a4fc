"""Links of a mechanism: asked about without the joints that both hang on, and only while they may be near.

What two links share moves both: dropped, it carries the answer back to the world.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from firstcontact.body.compound.compound import about_models
from firstcontact.contact.carried import carried
from firstcontact.contact.later import LATER
from firstcontact.contact.runs import seams
from firstcontact.contact.runs.near import during, runs
from firstcontact.motion.linkage import Linkage, apart
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.result import ContactIntervals, ContactPairs, FirstContact, JointValue, Stats, Status
from firstcontact.work import Query


def first(answer: Callable[[Query], FirstContact], query: Query) -> FirstContact:
    """What `answer` tells of the query, asked about each time in which the bodies are near."""
    if not _linkages(query):
        return answer(query)
    own, shared = _without_shared(query)
    stats = Stats()
    for run in runs(own):
        found = answer(replace(during(own, run), budget=query.budget_after(stats)))
        stats = stats + found.stats
        if found.status is not Status.FREE:
            return _told(found, query, shared, _timed(stats, query))
    return seams.free(query, _timed(stats, query))


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


def _timed(stats: Stats, query: Query) -> Stats:
    return replace(stats, seconds=query.stats().seconds)


LAST = "within_deviation"
"""Asked for last: it costs another question."""
_TOLD = "status", "time", "time_interval", "time_exact", "free_until", "reason", "keeps_bodies"


def _told(found: FirstContact, query: Query, shared: Linkage | None, stats: Stats) -> FirstContact:
    """The answer as to the query itself, with the joints' values; of places it is as slow to tell as the answer."""
    def places() -> dict[str, object]:
        there = found if shared is None else carried(found, shared, query.a, query.b)
        return {key: getattr(there, key) for key in LATER} | {"_rest": lambda: {LAST: getattr(found, LAST)}}

    joints: dict[str, JointValue] = {}
    if (time := found.time) is not None:
        interval = found.time_interval or (time, time)
        joints = {x.name: x for motion in _linkages(query) for x in motion.joint_values(time, interval)}
    known = {key: getattr(found, key) for key in _TOLD} | {"joints": tuple(joints.values()), "stats": stats}
    return FirstContact.deferring({**known, **query.shared, **about_models(*query.bodies)}, places, LAST)
