"""Long trajectories: asked about while the bodies may be near, so many steps at a time, with only these made."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from firstcontact.contact.runs import seams
from firstcontact.contact.runs.near import Run, during, runs
from firstcontact.motion.moving import Moving
from firstcontact.motion.trajectory import Trajectory
from firstcontact.result import ContactIntervals, FirstContact
from firstcontact.work import Query

LONG = 32
"""Steps from which on it is worth looking when bodies are near, and that are asked about at a time."""


def first(answer: Callable[[Query], FirstContact], query: Query) -> FirstContact:
    """What `answer` tells of the query."""
    if not _is_long(query):
        return answer(query)
    return seams.first(answer, query, (during(query, run) for run in _runs(query)))


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
