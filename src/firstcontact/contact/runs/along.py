"""Long trajectories: asked about while the bodies may be near, so many steps at a time, with only these made.

What touches at the end of such a run does at the beginning of the next one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from firstcontact.contact.jumps import at_jump
from firstcontact.contact.later import waiting
from firstcontact.contact.runs import seams
from firstcontact.contact.runs.near import Run, during, runs
from firstcontact.motion.moving import Moving
from firstcontact.motion.trajectory import Trajectory
from firstcontact.result import ContactIntervals, FirstContact, Stats, Status
from firstcontact.work import Query

LONG = 32
"""Steps from which on it is worth looking when bodies are near, and that are asked about at a time."""


def first(answer: Callable[[Query], FirstContact], query: Query) -> FirstContact:
    """What `answer` tells of the query."""
    if not _is_long(query):
        return answer(query)
    stats = Stats()
    for run in _runs(query):
        found = answer(replace(during(query, run), budget=query.budget_after(stats)))
        stats = replace(stats + found.stats, seconds=query.stats().seconds)
        if found.status is Status.INITIAL_CONTACT and run[0] > query.first:
            return at_jump(found, run[0], query, stats)  # a screw ends 2^-60 beside the next pose
        if found.status is not Status.FREE:
            return waiting(found, dict, stats=stats, **query.shared)
    return seams.free(query, stats)


def intervals(answer: Callable[[Query], ContactIntervals], query: Query) -> ContactIntervals:
    """What `answer` tells of the query."""
    if not _is_long(query):
        return answer(query)
    return seams.intervals(answer, query, (during(query, run) for run in _runs(query)))


def _trajectories(query: Query) -> list[Trajectory]:
    return [x.motion for x in query.bodies if isinstance(x, Moving) and isinstance(x.motion, Trajectory)]


def _is_long(query: Query) -> bool:
    return any(len(x.steps) > LONG for x in _trajectories(query))


def _runs(query: Query) -> Iterator[Run]:
    """The times in which the bodies may meet, cut where one of them has made so many steps."""
    motions = _trajectories(query)
    for first, last in runs(query):
        cuts = {t for x in motions for t in x.times[x.stretch(first) + LONG : x.stretch(last) + 1 : LONG]}
        inside = sorted(t for t in cuts if first < t < last)
        yield from zip([first, *inside], [*inside, last], strict=True)
