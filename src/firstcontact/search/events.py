"""First contact of any two charted models under any motion: the first event, by branch and prune in order of time.

At a first contact from apart a vertex, an edge or a face of one model begins to touch a face or an edge of the other.
`kernels.event_search` proves all times before the first slab that may hold such an event free; a point proved inside
both models at a time shortly after closes the interval from above.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from flint import fmpq

from firstcontact.body.moving import Moving
from firstcontact.kernels.event_search import (
    AT_U,
    AT_V,
    CHART,
    FREE,
    HALF_U,
    HALF_V,
    SLABS,
    SPENT,
    TESTS,
    VISITS,
    search,
)
from firstcontact.search.advance import Advance
from firstcontact.search.charts import NotCharted
from firstcontact.search.event_tables import Tables, tables_of
from firstcontact.search.instants import Instant, scratch_for
from firstcontact.search.shared_points import shared_point
from firstcontact.search.stretches import Untold, Window, below, windows

LEAST = 1.0 / 64.0
"""Of the width of the answer: slabs that short are not cut any more."""
SPREAD = 1e-4
"""Part of the body's size beyond which places that may touch count as more than one point."""
MOST_STILL = 30_000
"""Boxes looked at to prove the models apart at the start."""
MOST_BOXES = 1_000_000
"""Boxes looked at before the answer is "budget"."""
CAPACITY = 1 << 15
FRAMES = 400


def first_event(a: Any, b: Any, first: fmpq, last: fmpq, tolerance: float, budget: int) -> Advance:
    """The first common point of two bodies over [first, last]; as `search.advance`.  budget: boxes at most."""
    try:
        models: list[Any] = [x.body if isinstance(x, Moving) else x for x in (a, b)]
        tables = tables_of(*models)
        stretches = windows(a, b, first, last)
    except (NotCharted, Untold) as reason:
        return Advance("open", below(first), reason=str(reason))
    return _Search(a, b, tables, stretches, tolerance, budget).run(last)


class _Search:
    def __init__(self, a: Any, b: Any, tables: Tables, stretches: list[Window], tolerance: float, budget: int) -> None:
        self.bodies = a, b
        self.tables = tables
        self.windows = stretches
        self.width = tolerance * (stretches[-1].last - stretches[0].first)
        self.budget = budget
        self.counters = np.zeros(4, np.int64)
        self.pool, self.work = np.empty((CAPACITY, 8)), np.empty((CAPACITY, 8))
        self.result = np.zeros(4)
        self.scratch, self.frames = scratch_for(tables), np.zeros((FRAMES, 4))

    def run(self, last: fmpq) -> Advance:
        start = self.windows[0]
        if self._searched(self.tables.still, start, start.first, start.first, MOST_STILL) != FREE:
            return self._answer("open", start.first, reason="precision")
        self.counters[:] = 0
        for window in self.windows:
            outcome = self._searched(self.tables.boxes, window, window.first, window.last, self.budget)
            if outcome == SPENT:
                return self._answer("open", max(window.first, float(self.result[0])), reason="budget")
            if outcome != FREE:
                return self._contact(window, last)
        return self._answer("free", self.windows[-1].last)

    def _searched(self, boxes: np.ndarray, window: Window, first: float, last: float, budget: int) -> int:
        t = self.tables
        count = len(boxes)
        if count > CAPACITY // 2:
            return int(SPENT)
        self.pool[:count] = boxes
        self.pool[:count, 6], self.pool[:count, 7] = first, last
        return int(search(
            t.charts, t.info, t.pairs, t.layout, t.program, t.raw, t.kinds, t.kinds_of, t.units, window.a, window.b,
            *self.scratch, self.frames, self.pool, self.work, count, first, last, LEAST * self.width, budget,
            self.result, self.counters,
        ))  # fmt: skip

    def _contact(self, window: Window, last: fmpq) -> Advance:
        """The contact in the slab that the search stopped at, if a common point soon after is proved."""
        lo, hi = float(self.result[0]), float(self.result[1])
        count, start = int(self.result[2]), int(self.result[3])
        boxes = self.pool[start : start + count].copy()
        instant = Instant(self.tables, window, self.scratch)
        found = shared_point(self.bodies, instant, boxes, lo, hi, self.width, last)
        if found is None:
            return self._answer("open", lo, reason="precision")
        return self._answer(
            "contact", lo, time=found.time, time_interval=(lo, found.proved_at), point=found.point,
            normal=found.normal, features_a=found.features_a, features_b=found.features_b,
            frames=found.frames, spread=self._is_spread(boxes),
        )  # fmt: skip

    def _is_spread(self, boxes: np.ndarray) -> bool:
        """Whether the boxes are more than the surroundings of one point, in either body's own units."""
        places: tuple[list[np.ndarray], list[np.ndarray]] = [], []
        for box in boxes:
            chart = int(box[CHART])
            u, hu, v, hv = box[AT_U], box[HALF_U], box[AT_V], box[HALF_V]
            for p, q in ((u - hu, v - hv), (u - hu, v + hv), (u + hu, v - hv), (u + hu, v + hv)):
                powers = np.array([1.0, p, q, p * p, p * q, q * q])
                x = powers @ self.tables.charts[chart, :24].reshape(6, 4)
                places[self.tables.info[chart, 0]].append(x[:3] / x[3])
        return any(len(side) > 0 and float(np.ptp(side, axis=0).max()) > SPREAD for side in places)

    def _answer(self, status: str, free_until: float, **fields: Any) -> Advance:
        c = self.counters
        return Advance(
            status, free_until, steps=int(c[VISITS]), newton=int(c[SLABS]), gaps=int(c[TESTS]), **fields
        )

