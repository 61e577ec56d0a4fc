"""First contact of any two charted models under any motion: the first event, by branch and prune in order of time.

At a first contact from apart a vertex, an edge or a face of one model begins to touch a face or an edge of the other.
`kernels.events.event_search` proves all times before the first slab that may hold such an event free; a point proved
inside both models at a time shortly after closes the interval from above.  Convex pieces that cover the models are
advanced
first: nothing touches before they do, and where they touch at a point of the models, that is the answer.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.exact.numbers import below, exact_value, likely, to_double
from firstcontact.kernels.events.event_search import (
    AT_U,
    AT_V,
    CHART,
    END_PAIR,
    FIRST_PAIR,
    FREE,
    GOING,
    KNOWN,
    RESULTS,
    SLABS,
    SLICE_SPENT,
    SPENT,
    STOPPED,
    TESTS,
    TRAVEL,
    VISITS,
    search,
)
from firstcontact.kernels.events.feature_boxes import SLAB
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.stretches import Untold, Window, windows
from firstcontact.search.convex.advance import Advance, advance
from firstcontact.search.convex.convex import covering_pieces
from firstcontact.search.events.charts import NotCharted, TooFine
from firstcontact.search.events.event_tables import Tables, tables_of
from firstcontact.search.events.instants import PlacedForms, scratch_for
from firstcontact.search.events.shared_points import proved_at, shared_point, without_corners
from firstcontact.search.events.solid_certificate import earliest_event
from firstcontact.work import WORTH

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

LEAST = 1.0 / 64.0
"""Of the width of the answer: slabs that short are not cut any more."""
REACH, STAGES = 256.0, 10
"""Widths of the answer over which balls look for events at first, and how often they do."""
BEFORE = 0.25
"""Of the width of the answer: how long before an event that balls know doubles go on."""
SHARES = (0.25, 0.98)
"""Of the width of the answer: how long after a touch of covers the models are looked at."""
SPREAD = 1e-4
"""Part of the body's size beyond which places that may touch count as more than one point."""
STRIDE = 0.1
"""Of the half-sizes of the bodies: how far one of them moves in the first slab of time."""
LEAST_STRIDE = 2.0**-6
"""Of the time that is left."""
MOST_STILL = 100_000
"""Boxes and pairs looked at to prove the models apart at the start."""
MOST_BOXES = 4_000_000
"""Boxes and pairs looked at before the answer is "budget"."""
STRIDES = 10_000
"""Of the convex pieces that cover the models, at most."""
CAPACITY = 1 << 15
SIGNS_U, SIGNS_V = np.array([-1.0, -1.0, 1.0, 1.0]), np.array([-1.0, 1.0, -1.0, 1.0])
"""Corners of a box."""
FRAMES = 400
SLICE = 2000
"""Boxes and pairs after which a compiled search comes back for a moment, so that it can be interrupted."""


def first_event(
    a: Body, b: Body, first: fmpq, last: fmpq, tolerance: float, budget: int, apart: bool = False,
    enough: fmpq | None = None,
) -> Advance:  # fmt: skip
    """The first common point of two bodies over [first, last]; as `search.convex.advance`.

    budget: strides, boxes and pairs of features at most.  apart: they are known to share no point at `first`.
    """
    covers = advance(a, b, first, last, tolerance, min(STRIDES, budget), covering=True, enough=enough)
    if covers.status == "free":
        return covers
    if enough is not None and exact_value(covers.free_until) >= enough:
        return Advance("open", covers.free_until, reason="precision", steps=covers.steps, spent=covers.spent)
    try:
        models: list[Any] = [shape_of(x) for x in (a, b)]
        tables = tables_of(*models)
        stretches = windows(a, b, first, last)
    except (NotCharted, Untold) as reason:
        return Advance("open", below(first), reason="precision" if isinstance(reason, TooFine) else str(reason))
    search = EventSearch(a, b, tables, stretches, tolerance, budget)
    search.counters[VISITS] = covers.steps  # one budget for both
    if covers.status == "contact" and (touched := search.touched(covers, last)) is not None:
        return touched
    return search.run(below(first) if covers.beyond else covers.free_until, last, apart)


class EventSearch:
    def __init__(
        self, a: Body, b: Body, tables: Tables, stretches: list[Window], tolerance: float, budget: int
    ) -> None:
        self.bodies = a, b
        self.tables = tables
        self.windows = stretches
        self.width = tolerance * (stretches[-1].last - stretches[0].first)
        self.budget = budget
        self.is_spent = False
        """Whether a search has ended for want of budget."""
        self.counters = np.zeros(4, np.int64)
        self.result = np.zeros(RESULTS)
        self.scratch, self.frames = scratch_for(tables), np.zeros((FRAMES, 4))

    @cached_property
    def slice(self) -> int:
        """Boxes and pairs after which the compiled search comes back."""
        info = self.tables.info
        return max(SLICE, 1 + int((info[:, END_PAIR] - info[:, FIRST_PAIR]).max(initial=0)))

    @cached_property
    def pool(self) -> np.ndarray:
        """Boxes of a search, and those of its next round: room that a contact that pieces tell does not need."""
        return np.empty((CAPACITY, 8))

    @cached_property
    def work(self) -> np.ndarray:
        return np.empty((CAPACITY, 8))

    @cached_property
    def known(self) -> np.ndarray:
        """What is known of each box, and of those of the next round."""
        return np.empty((CAPACITY, KNOWN), np.int64)

    @cached_property
    def told(self) -> np.ndarray:
        return np.empty((CAPACITY, KNOWN), np.int64)

    def touched(self, covers: Advance, last: fmpq) -> Advance | None:
        """The contact of convex pieces that cover the models, if it is one of the models."""
        time, interval = covers.time, covers.time_interval
        assert time is not None and interval is not None and covers.point is not None
        lo, hi = interval
        model_a, model_b = (shape_of(x) for x in self.bodies)
        if not (covering_pieces(model_a).labels and covering_pieces(model_b).labels):
            return None
        features, *also = [
            (without_corners(model_a, x), without_corners(model_b, y))
            for x, y in ((covers.features_a, covers.features_b), *(covers.also or ()))
        ]
        covers = replace(
            covers, features_a=features[0], features_b=features[1], also=None if covers.also is None else tuple(also),
            complete=True,
        )  # fmt: skip
        window = next(w for w in self.windows if time <= w.last)
        instant = PlacedForms(self.tables, window, self.scratch)
        times = [min(max(hi, lo + share * self.width), window.last) for share in SHARES]
        at = proved_at(self.bodies, instant, covers, times, last)
        return None if at is None else replace(covers, time=min(time, at), time_interval=(lo, at))

    def run(self, begin: float, last: fmpq, apart: bool = False) -> Advance:
        """The first event from a time on before which the models are apart; at the start that is proved here, unless it
        is known."""
        for k, window in enumerate(self.windows):
            if begin >= window.last > window.first:
                continue
            t = max(begin, window.first)
            known = apart and k == 0
            if t == window.first and not known and not self._apart(window, t):  # a motion starts there, and may jump
                return self._answer("open", t, reason="budget" if self.is_spent else "precision")
            stopped = self._first_event(window, t, last)
            if stopped is not None:
                return stopped
        return self._answer("free", self.windows[-1].last)

    def _apart(self, window: Window, t: float) -> bool:
        return self.searched(True, window, t, t, min(self.done + MOST_STILL, self.budget)) == FREE

    @property
    def done(self) -> int:
        """Boxes and pairs looked at."""
        return int(self.counters[VISITS] + self.counters[TESTS])

    @property
    def taken(self) -> int:
        """Of the budget: all where the search has ended for want of it."""
        return self.budget if self.is_spent else self.done

    def _first_event(self, window: Window, t: float, last: fmpq) -> Advance | None:
        """From t on; None where there is none.  Where rounding errors hide it, balls take over for a while."""
        event: fmpq | None = None
        for stage in range(STAGES):
            found = self._in_doubles(window, t, last)
            if found is None or found.status != "open" or found.reason != "precision":
                return found if found is None or event is None else self._timed(found, event)
            ahead = self.free_in_balls(window, found.free_until, stage)
            if ahead is None:
                return found
            t, event = ahead
            if t >= window.last:
                return None
        return self._answer("open", t, reason="precision")

    def _timed(self, found: Advance, event: fmpq) -> Advance:
        """A contact at the time at which balls know an event, if it may be that."""
        if found.status != "contact" or found.time_interval is None:
            return found
        near = likely(event, event + 2 * exact_value(LEAST * self.width))
        lo, hi = map(exact_value, found.time_interval)
        return replace(found, time=to_double(near)) if lo <= near <= hi else found

    def free_in_balls(self, window: Window, lo: float, stage: int) -> tuple[float, fmpq | None] | None:
        """A time after lo before which all is free, shortly before an event, or that of the look ahead, and the event;
        None where that is not told.  stage: how often balls have told before; they look four times as far each time."""
        end = min(lo + REACH * 4.0**stage * self.width, window.last)
        outcome = self.covered(window, lo, end)
        if outcome != STOPPED:
            return (end, None) if outcome == FREE else None
        count, start = int(self.result[2]), int(self.result[3])
        boxes = self.pool[start : start + count].copy()
        first, last, fine = (exact_value(x) for x in (lo, end, LEAST * self.width))
        most = max(self.budget - self.done, 0) // WORTH
        told, event, looked = earliest_event(self.bodies, self.tables, window, boxes, first, last, fine, most)
        self.counters[VISITS] += WORTH * looked
        ahead = end if event is None else below(event) - BEFORE * self.width
        return (ahead, event) if told and ahead > lo else None

    def covered(self, window: Window, lo: float, end: float) -> int:
        """As `searched` for events in [lo, end], which is not cut."""
        width, self.width = self.width, (end - lo) / LEAST
        outcome = self.searched(False, window, lo, end, self.budget)
        self.width = width
        return outcome

    def _in_doubles(self, window: Window, t: float, last: fmpq) -> Advance | None:
        """From t on; None where there is no event."""
        outcome = self.first(window, t)
        if outcome == SPENT:
            return self._answer("open", max(window.first, float(self.result[0])), reason="budget")
        return None if outcome == FREE else self._contact(window, last)

    def first(self, window: Window, t: float) -> int:
        """The outcome of `searched` for events from t to the end of the window, in slabs of time that grow."""
        step = self._stride(window, t)
        while True:
            end = min(t + step, window.last)
            outcome = self.searched(False, window, t, end, self.budget)
            if outcome != FREE or end >= window.last:
                return outcome
            t, step = end, 2.0 * step

    def _stride(self, window: Window, t: float) -> float:
        """A time in which the models move by a part of their size."""
        rest = window.last - t
        trial = LEAST_STRIDE * rest
        if not PlacedForms(self.tables, window, self.scratch).place(t, t + trial):
            return trial
        slab = self.scratch.boxes[SLAB]
        travel = max(float(slab[TRAVEL]), float(slab[TRAVEL + 1]), 1e-300)
        return max(trial, min(rest, trial * STRIDE / travel))

    def searched(self, still: bool, window: Window, first: float, last: float, budget: int) -> int:
        """As `kernels.events.event_search.search`; still: at the time first = last, else for events."""
        t = self.tables
        boxes, known = (t.still, t.known_still) if still else (t.boxes, t.known)
        count = len(boxes)
        if count > CAPACITY // 2:
            return int(SPENT)
        self.pool[:count], self.known[:count] = boxes, known
        self.pool[:count, 6], self.pool[:count, 7] = first, last
        self.result[GOING] = 0.0
        while True:
            stop = min(self.done + self.slice, budget)
            outcome = search(
                t.charts, t.info, t.pairs, t.layout, t.program, t.raw, t.kinds, t.units, window.a, window.b,
                *self.scratch, self.frames, self.pool, self.known, self.work, self.told, count, first, last,
                LEAST * self.width, stop, self.result, self.counters,
            )  # fmt: skip
            if outcome != SLICE_SPENT:
                return int(outcome)
            if stop >= budget:
                self.is_spent = self.is_spent or budget >= self.budget
                return int(SPENT)

    def _contact(self, window: Window, last: fmpq) -> Advance:
        """The contact in the slab that the search stopped at, if a common point soon after is proved."""
        lo, hi = float(self.result[0]), float(self.result[1])
        count, start = int(self.result[2]), int(self.result[3])
        boxes = self.pool[start : start + count].copy()
        instant = PlacedForms(self.tables, window, self.scratch)
        found = shared_point(self.bodies, instant, boxes, lo, hi, self.width, last)
        if found is None:
            return self._answer("open", lo, reason="precision")
        return self._answer(
            "contact", lo, time=found.time, time_interval=(lo, found.proved_at), point=found.point,
            normal=found.normal, features_a=found.features_a, features_b=found.features_b,
            frames=found.frames, spread=self._is_spread(boxes), one_event=True,
        )  # fmt: skip

    def _is_spread(self, boxes: np.ndarray) -> bool:
        """Whether the boxes are more than the surroundings of one point, in either body's own units."""
        t, charts = self.tables, boxes[:, CHART].astype(int)
        u, v = (boxes[:, k, None] + boxes[:, k + 1, None] * signs for k, signs in ((AT_U, SIGNS_U), (AT_V, SIGNS_V)))
        powers = np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=2)
        x = powers @ t.charts[charts, :24].reshape(-1, 6, 4)
        places, sides = x[:, :, :3] / x[:, :, 3:], t.info[charts, 0]
        own = (places[sides == side].reshape(-1, 3) for side in (0, 1))
        return any(len(points) > 0 and float(np.ptp(points, axis=0).max()) > SPREAD for points in own)

    def _answer(self, status: str, free_until: float, **fields: Any) -> Advance:
        c = self.counters
        return Advance(
            status, free_until, steps=int(c[VISITS]), newton=int(c[SLABS]), gaps=int(c[TESTS]), spent=self.taken,
            **fields,
        )
