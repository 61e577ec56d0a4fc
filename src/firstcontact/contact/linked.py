"""Links of a mechanism: asked about without the joints that both hang on, and only while they may be near.

What two links share moves both: dropped, it carries the answer back to the world.  A link is near another body in the
stretches of the clock in which balls that cover them may meet, by the proved speeds of the joints.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from flint import fmpq

from firstcontact.body.compound.compound import about_models
from firstcontact.body.kept import Kept
from firstcontact.contact.carried import carried
from firstcontact.contact.later import LATER
from firstcontact.motion.linkage import Linkage, apart
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative.reach import places
from firstcontact.result import ContactInterval, ContactIntervals, ContactPairs, FirstContact, JointValue, Stats, Status
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Shape

# Balls that cover a body's box: doublings, halving its longest sides.
_HALVINGS = 4
Run = tuple[fmpq, fmpq]


class BallCover(NamedTuple):
    """Balls that hold a body in its own frame: centres (k, 3), and the radius of each of them."""

    centres: tuple[tuple[float, ...], ...]
    radius: float


_COVERS = Kept[tuple[BallCover, BallCover] | None]()


def first(answer: Callable[[Query], FirstContact], query: Query) -> FirstContact:
    """What `answer` tells of the query, asked about each time in which the bodies are near."""
    if not _linkages(query):
        return answer(query)
    own, shared = _without_shared(query)
    stats = Stats()
    for run in _runs(own):
        found = answer(_during(own, run, stats))
        stats = stats + found.stats
        if found.status is not Status.FREE:
            return _told(found, query, shared, _timed(stats, query))
    free, models = FirstContact.free(_timed(stats, query), **query.shared), about_models(*query.bodies)
    return free if models["model_deviation"] is None else replace(free, **models)


def intervals(answer: Callable[[Query], ContactIntervals], query: Query) -> ContactIntervals:
    """The same of all intervals of contact."""
    if not _linkages(query):
        return answer(query)
    own, _ = _without_shared(query)
    stats, known, status = Stats(), list[ContactInterval](), Status.FREE
    for run in _runs(own):
        found = answer(_during(own, run, stats))
        stats = stats + found.stats
        if found.status is not Status.FREE and status is Status.FREE:
            status = found.status
        known += found.intervals
        if found.status is Status.UNDECIDED:
            return replace(found, intervals=tuple(known), stats=_timed(stats, query), **query.shared)
    until = known[0].start if known else query.span[1]
    models = about_models(*query.bodies)
    return ContactIntervals(tuple(known), status, until, None, _timed(stats, query), **query.shared, **models)


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


def _during(query: Query, run: Run, stats: Stats) -> Query:
    """The query about one run, with what is left of the budget; the tolerance is a share of all of the span."""
    a, b = (_cut(body, run) for body in query.bodies)
    left, tolerance = query.budget_after(stats), query.tolerance_within(*run)
    return replace(query, a=a, b=b, first=run[0], last=run[1], budget=left, tolerance=tolerance)


def _cut(body: Body, run: Run) -> Body:
    if not isinstance(body, Moving) or not isinstance(body.motion, Linkage):
        return body
    return Moving(body.body, body.motion.during(*run))


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


# ------------------------------------------------------------------------------------------------ where they are near


def _runs(query: Query) -> Iterator[Run]:
    """The times of the query, stretches of the clock joined, outside of which the bodies are proved to be apart."""
    linkages, last = _linkages(query), query.end
    whole = [(query.first, last)]
    if not linkages or any(isinstance(x, Moving) and not isinstance(x.motion, Linkage) for x in query.bodies):
        yield from whole
        return
    times = linkages[0].times
    covers = [_covers(shape_of(body)) for body in query.bodies]
    if any(x.times != times for x in linkages) or any(cover is None for cover in covers):
        yield from whole
        return
    lo, hi = linkages[0].stretch(query.first), linkages[0].stretch(last) + 1
    asked = np.arange(lo, hi)
    for fineness in range(2):
        both = zip(query.bodies, covers, strict=True)
        sides = [_balls(body, cover[fineness], asked) for body, cover in both if cover]
        asked = asked[_may_meet(*sides)]
    yield from _joined(asked.tolist(), times, query.first, last)


def _balls(body: Body, cover: BallCover, asked: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, k, 3) and radii (n, k) of balls that hold the body in all of each stretch."""
    if not isinstance(body, Moving):
        return np.array(cover.centres)[None], np.full((1, len(cover.centres)), cover.radius)
    middles, far = _paths(body.motion, cover.centres)
    return middles[asked], far[asked] + cover.radius


@lru_cache(maxsize=16)
def _paths(motion: Linkage, centres: tuple[tuple[float, ...], ...]) -> tuple[np.ndarray, np.ndarray]:
    """`places` over all stretches of the clock: the same for all bodies that a link is asked about with."""
    return places(motion, np.array(centres))


def _may_meet(a: tuple[np.ndarray, np.ndarray], b: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """(n,) whether some ball of a may meet one of b in each stretch."""
    between = a[0][:, :, None] - b[0][:, None]
    square = np.einsum("nijk,nijk->nij", between, between)
    reach = (a[1][:, :, None] + b[1][:, None]) * (1.0 + 1e-12)
    near: np.ndarray = ~(square > reach * reach).all(axis=(1, 2))  # what is no number proves nothing
    return near


def _joined(stretches: list[int], times: tuple[fmpq, ...], first: fmpq, last: fmpq) -> Iterator[Run]:
    begin = 0
    for k in range(1, len(stretches) + 1):
        if k == len(stretches) or stretches[k] != stretches[k - 1] + 1:
            yield max(first, times[stretches[begin]]), min(last, times[stretches[k - 1] + 1])
            begin = k


def _covers(body: Shape) -> tuple[BallCover, BallCover] | None:
    """One ball around the body, and several around parts of its box; None of a body that has no box of its own."""
    def made() -> tuple[BallCover, BallCover] | None:
        lo, hi = body.bounds()
        return (_cover(lo, hi, 0), _cover(lo, hi, _HALVINGS)) if np.isfinite([lo, hi]).all() else None

    return None if getattr(body, "deforming", False) else _COVERS.of(body, made)


def _cover(lo: np.ndarray, hi: np.ndarray, halvings: int) -> BallCover:
    counts, sides = np.ones(3, int), hi - lo
    for _ in range(halvings):
        longest = int(np.argmax(sides))
        counts[longest] *= 2
        sides[longest] *= 0.5
    grid = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in counts), indexing="ij"), axis=-1).reshape(-1, 3)
    radius = 0.5 * float(np.linalg.norm(sides)) * (1 + 1e-14) + 1e-14 * float(np.abs([lo, hi]).max())
    return BallCover(tuple(map(tuple, (lo + grid * sides).tolist())), radius)
