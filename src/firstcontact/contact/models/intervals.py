"""All times of contact of two models under any motion, by the sweep: their free time."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.contact.models.certified import both_bounded
from firstcontact.contact.models.last_instant import landing
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import above, below, simplest
from firstcontact.kernels.events.event_search import CHART, FREE
from firstcontact.kernels.poses import pose_at
from firstcontact.kernels.workspace import HERE_A, workspace
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.curved import CurvedPiece
from firstcontact.motion.relative.pieces import curved_pieces
from firstcontact.motion.relative.stretches import Untold, Window, windows
from firstcontact.search.convex import advance
from firstcontact.search.convex.convex import NotConvex, convex_pieces
from firstcontact.search.events import events
from firstcontact.search.events.charts import NotCharted
from firstcontact.search.events.event_tables import tables_of
from firstcontact.timeline.lasting import LastingOfModels, LastingSolid
from firstcontact.timeline.sweep import Certified, Found, Pass, TimeSweep
from firstcontact.work import Work

if TYPE_CHECKING:
    from firstcontact.body.kinds import Model
    from firstcontact.search.events.events import EventSearch

STRIDES, BOXES = 10_000, events.MOST_BOXES
SEEDS = 4


def certified_intervals(
    models: tuple[Model, Model],
    first: fmpq,
    last: fmpq,
    tolerance: float,
    work: Work,
    touches_at_start: Callable[[], np.ndarray | None],
) -> Found:
    """All closed times of contact over [first, last]; events within `tolerance` of the span are not told apart.

    touches_at_start: gives a common point at the start that is known otherwise, or None; asked where nothing is proved.
    Raises UnsupportedPair where the models or motions are beyond the searches.
    """
    span = below(first), above(last)
    models = both_bounded(models, span)
    try:
        parts = windows(*models, first, last)
        width = tolerance * (parts[-1].last - parts[0].first)
        lasting = LastingOfModels(*(LastingSolid(shape_of(x)) for x in models))
        free = _FreeOfModels(models, width, parts, curved_pieces(*models, first, last), work)
        found = TimeSweep(free, lasting, parts, width, work, touches_at_start).run()
    except (NotCharted, Untold) as reason:
        raise UnsupportedPair(f"contact intervals are not decided: {reason}") from reason
    return _with_landing(found, models, last, width)


def _with_landing(found: Found, models: tuple[Model, Model], last: fmpq, width: float) -> Found:
    """With the contact of the last instant, where all before it is decided and they are proved to touch then."""
    follows = found.intervals and found.intervals[-1].open
    if found.reason != "precision" or follows or above(last) - found.until > width or landing(*models, last) is None:
        return found
    touch = Certified((found.until, above(last)), (below(last), above(last)))
    return Found((*found.intervals, touch), above(last), None)


class _FreeOfModels:
    """Two models: by convex pieces where the models consist of them, else by events."""

    def __init__(
        self, models: tuple[Model, Model], width: float, parts: list[Window], motions: list[CurvedPiece], work: Work
    ) -> None:
        self.models, self.width, self.parts, self.motions, self.work = models, width, parts, motions, work
        bodies: list[Any] = [shape_of(x) for x in models]
        try:
            self.pieces = [convex_pieces(body) for body in bodies]
            self.tables = None
        except NotConvex:
            self.pieces, self.tables = [], tables_of(*bodies)

    def at(self, window: Window, t: float) -> bool:
        if self.tables is None:
            return self._advanced(window, t, t).status == "free"
        return self._events(window, True, t, t)[1]

    def until(self, window: Window, t: float, end: float) -> tuple[float, list[np.ndarray]]:
        if self.tables is None:
            found = self._advanced(window, t, end)
            if found.status == "free":
                return end, []
            until = min(found.free_until, math.nextafter(end, t))
            return until, [] if found.point is None else [found.point]
        search, is_free = self._events(window, False, t, end)
        if is_free:
            return end, []
        until, places = max(t, float(search.result[0])), self._places(search, window)
        if not self._runs_on(window):
            return until, places
        done = search.taken
        ahead = search.free_in_balls(window, until, 0)  # rounding may hide how long they stay apart
        self.work.done += search.taken - done
        if ahead is None or not until < ahead[0] < end:
            return until, places
        search, is_free = self._events(window, False, ahead[0], end)
        return (end, []) if is_free else (max(ahead[0], float(search.result[0])), self._places(search, window))

    def _events(self, window: Window, still: bool, t: float, end: float) -> tuple[events.EventSearch, bool]:
        """(a search for events, or at t = end for common points, which counts as work; whether there is none)."""
        assert self.tables is not None
        most = self.work.allowed(events.MOST_STILL if still else BOXES)
        search = events.EventSearch(*self.models, self.tables, [window], 1.0, most)
        search.width = self.width
        outcome = search.searched(still, window, t, end, most)
        self.work.done += search.taken
        return search, outcome == FREE

    def near_start(self, window: Window) -> list[np.ndarray]:
        return self.until(window, window.first, window.first)[1] if self.tables is None else []

    def passage(self, window: Window, t: float) -> Pass | None:
        if self.tables is not None:
            return None
        search = self._search(window, t, window.last)
        found = search.passage(t)
        if found is None:
            return None
        passage, point = found
        instant = None
        if passage.graze is not None:
            instant = simplest(*passage.graze)
            if landing(*self.models, instant) is None:
                instant = None
        return Pass(passage, point, instant)

    def _advanced(self, window: Window, t: float, end: float) -> advance.Advance:
        return self._search(window, t, end).run()

    def _search(self, window: Window, t: float, end: float) -> advance.PieceSearch:
        part = window._replace(first=t, last=end, inner=min(end, window.inner))
        search = advance.PieceSearch(self.pieces[0], self.pieces[1], [part], 1.0, STRIDES)
        search.width = self.width
        if self._runs_on(window):
            search.motions = lambda: self.motions
        return search

    def _runs_on(self, window: Window) -> bool:
        """Whether the window is one of the motions, and not its mirror, in which time runs backwards."""
        return any(window.a is w.a and window.b is w.b for w in self.parts)

    def _places(self, search: EventSearch, window: Window) -> list[np.ndarray]:
        """The middles of boxes that survive, in the world."""
        count, start = int(search.result[2]), int(search.result[3])
        tables: Any = self.tables
        scratch, found = workspace()[0], []
        for box in search.pool[start : start + min(count, SEEDS)]:
            chart, u, v = int(box[CHART]), box[2], box[4]
            side = int(tables.info[chart, 0])
            x = np.array([1.0, u, v, u * u, u * v, v * v]) @ tables.charts[chart, :24].reshape(6, 4)
            place = tables.units[side, :3] + tables.units[side, 3] * x[:3] / x[3]
            pose_at((window.a, window.b)[side], float(search.result[0]), scratch, HERE_A)
            found.append(scratch[HERE_A, :9].reshape(3, 3) @ place + scratch[HERE_A, 9:12])
        return found
