"""Long trajectories: asked about while the bodies may be near, so many steps at a time, with only these made.

What touches at the end of such a run does at the beginning of the next one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from firstcontact.body.compound.compound import about_models
from firstcontact.contact.jumps import at_jump
from firstcontact.contact.later import waiting
from firstcontact.contact.runs.near import Run, runs
from firstcontact.motion.moving import Moving
from firstcontact.motion.trajectory import Trajectory
from firstcontact.result import ContactInterval, ContactIntervals, FirstContact, Stats, Status
from firstcontact.work import Query

LONG = 32
"""Steps from which on it is worth looking when bodies are near, and that are asked about at a time."""


def first(answer: Callable[[Query], FirstContact], query: Query) -> FirstContact:
    """What `answer` tells of the query."""
    if not _longest(query):
        return answer(query)
    stats = Stats()
    for run in _runs(query):
        found = answer(_during(query, run, stats))
        stats = replace(stats + found.stats, seconds=query.stats().seconds)
        if found.status is Status.INITIAL_CONTACT and run[0] > query.first:
            return at_jump(found, run[0], query, stats)  # a screw ends 2^-60 beside the next pose
        if found.status is not Status.FREE:
            return waiting(found, dict, stats=stats, **query.shared)
    free, models = FirstContact.free(stats, **query.shared), about_models(*query.bodies)
    return free if models["model_deviation"] is None else replace(free, **models)


def intervals(answer: Callable[[Query], ContactIntervals], query: Query) -> ContactIntervals:
    """What `answer` tells of the query."""
    if not _longest(query):
        return answer(query)
    stats, known, status = Stats(), list[ContactInterval](), Status.FREE
    models = about_models(*query.bodies)
    for run in _runs(query):
        found = answer(_during(query, run, stats))
        stats = replace(stats + found.stats, seconds=query.stats().seconds)
        goes_on = run[0] > query.first and _starts_at_once(found)
        known = _joined(known, list(found.intervals)) if goes_on else [*known, *found.intervals]
        if found.status is Status.UNDECIDED:
            return replace(found, intervals=tuple(known), stats=stats, **query.shared, **models)
        if found.status is not Status.FREE and status is Status.FREE:
            status = Status.CONTACT if goes_on else found.status
    until = known[0].start_interval[0] if known else query.span[1]
    return ContactIntervals(tuple(known), status, until, None, stats, **query.shared, **models)


def _longest(query: Query) -> int:
    """Steps within the span of what has most of them; 0 where they are few."""
    motions = [x.motion for x in query.bodies if isinstance(x, Moving) and isinstance(x.motion, Trajectory)]
    most = max((len(x.steps) for x in motions), default=0)
    return most if most > LONG and query.last is not None else 0


def _runs(query: Query) -> Iterator[Run]:
    """The times in which the bodies may meet, cut where one of them has made so many steps."""
    motions = [x.motion for x in query.bodies if isinstance(x, Moving) and isinstance(x.motion, Trajectory)]
    for first, last in runs(query):
        cuts = {t for x in motions for t in x.times[x.stretch(first) + LONG : x.stretch(last) + 1 : LONG]}
        inside = sorted(t for t in cuts if first < t < last)
        yield from zip([first, *inside], [*inside, last], strict=True)


def _during(query: Query, run: Run, stats: Stats) -> Query:
    """The query about one run, with what is left of the budget; the tolerance is a share of all of the span."""
    a, b = (_cut(body, run) for body in query.bodies)
    left, tolerance = query.budget_after(stats), query.tolerance_within(*run)
    return replace(query, a=a, b=b, first=run[0], last=run[1], budget=left, tolerance=tolerance)


def _cut(body: object, run: Run) -> object:
    if not isinstance(body, Moving) or not isinstance(body.motion, Trajectory):
        return body
    return Moving(body.body, body.motion.during(*run))


def _starts_at_once(found: ContactIntervals) -> bool:
    if found.status is Status.UNDECIDED:
        return bool(found.intervals) and found.intervals[0].start <= found.span[0]
    return found.status is Status.INITIAL_CONTACT


def _joined(known: list[ContactInterval], more: list[ContactInterval]) -> list[ContactInterval]:
    """With what goes on from where another run begins: one with the last, where that lasts until there."""
    if known and more and known[-1].end_interval[1] >= more[0].start_interval[0]:
        last, own = known[-1], more[0]
        more[0] = replace(own, start=last.start, start_interval=last.start_interval, start_exact=last.start_exact)
        return [*known[:-1], *more]
    return [*known, *more]
