"""How a ruled surface and a model are followed in time: free by events, in contact by a point of the surface.

A point stands as (number of its sheet, x, s), see `search.events.ruled_charts`; it stays where it is on the surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from flint import arb, fmpq

from firstcontact.exact.numbers import exact_value, precision, to_double
from firstcontact.kernels.events.event_search import CHART, FREE
from firstcontact.motion.relative.stretches import Window
from firstcontact.search.events import events
from firstcontact.search.events.event_tables import Tables
from firstcontact.search.events.ruled_charts import ChartSheet, RuledFeature, TrimCut, backwards
from firstcontact.search.events.ruled_solids import STAGES, RuledSearch, RuledSolidEvent
from firstcontact.timeline.lasting import BITS, SIGNS, Lasting, LastingSolid, descended, linear
from firstcontact.work import Work

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

SEEDS = 4
BOXES = events.MOST_BOXES
GRID = 41, 11
"""Points of a sheet in x and in s among which a common one is sought where nothing is known."""
LOWEST, HIGHEST = np.array([-1.0, 0.0]), np.array([1.0, 1.0])
AROUND = np.array([(np.cos(k * np.pi / 8), np.sin(k * np.pi / 8)) for k in range(16)])


class RuledFree:
    """As `contact.models.intervals` asks for free time."""

    def __init__(
        self, bodies: tuple[Body, Body], side: int, tables: Tables, sheets: list[ChartSheet], parts: list[Window],
        width: float, work: Work,
    ) -> None:
        self.bodies, self.side, self.tables, self.width, self.work = bodies, side, tables, width, work
        self.windows, self.mirrored = parts, backwards(tables)
        self.numbers = {id(feature.sheet): sheets.index(feature.sheet) for feature in _features(tables)}

    def at(self, window: Window, t: float) -> bool:
        most = self.work.allowed(events.MOST_STILL)
        search = events.EventSearch(*self.bodies, self._tables(window), [window], 1.0, most)
        outcome = search.searched(True, window, t, t, most)
        self.work.done += search.taken
        return outcome == FREE

    def until(self, window: Window, t: float, end: float) -> tuple[float, list[np.ndarray]]:
        search = RuledSearch(*self.bodies, self._tables(window), [window], 1.0, self.work.allowed(BOXES), self.side)
        search.width, search.way = self.width, way_of(window, self.windows)
        try:
            return self._until(search, window, t, end)
        finally:
            self.work.done += search.taken

    def _until(
        self, search: RuledSearch, window: Window, t: float, end: float
    ) -> tuple[float, list[np.ndarray]]:
        for stage in range(STAGES):
            if search.searched(False, window, t, end, search.budget) == FREE:
                return end, []
            count, start = int(search.result[2]), int(search.result[3])
            t, left = max(t, float(search.result[0])), search.pool[start : start + min(count, SEEDS)].copy()
            ahead = search.in_balls(window, t, stage)
            if ahead is None:
                return t, self.places(left)
            t, known = ahead
            if known is not None:
                return min(t, end), [self._seed(event) for event, _ in known.events[:SEEDS]] or self.places(left)
            if t >= end:
                return end, []
        return t, []

    def _tables(self, window: Window) -> Tables:
        return self.tables if way_of(window, self.windows) > 0 else self.mirrored

    def near_start(self, window: Window) -> list[np.ndarray]:
        return []

    def passage(self, window: Window, t: float) -> None:
        return None

    def _seed(self, event: RuledSolidEvent) -> np.ndarray:
        return np.array([self.numbers[id(event.own.sheet)], *(to_double(c) for c in event.place)])

    def places(self, boxes: np.ndarray) -> list[np.ndarray]:
        """The points at the middles of boxes."""
        found = []
        for box in boxes:
            feature: Any = self.tables.features[int(box[CHART])]
            place = np.clip(feature.place(float(box[2]), float(box[4])), LOWEST, HIGHEST)
            found.append(np.array([self.numbers[id(feature.sheet)], *place]))
        return found


def way_of(window: Window, forwards: Sequence[Window]) -> int:
    """1 for one of these windows, -1 for one in which time runs backwards, so that t stands for -t."""
    return 1 if any(window is known for known in forwards) else -1


def _features(tables: Tables) -> Sequence[RuledFeature]:
    return tables.features  # type: ignore[return-value]


class RuledLasting(Lasting[np.ndarray]):
    """A ruled surface, body `side`, and a model; places are points too.  parts: the windows in which time runs on."""

    worth: ClassVar[int] = 400

    def __init__(self, sheets: list[ChartSheet], solid: LastingSolid, side: int, parts: list[Window]) -> None:
        super().__init__()
        self.sheets, self.solid, self.side, self.windows = sheets, solid, side, parts
        self.tables = [_doubles(sheet) for sheet in sheets]
        self.cuts = [[_cut_in_doubles(cut) for cut in sheet.cuts] for sheet in sheets]
        corners = np.array(list(product((-1.0, 1.0), (0.0, 1.0))))
        sizes = (float(np.ptp(self._points(table[0], corners)[:, :3], axis=0).max()) for table in self.tables)
        self.sizes = [size or 1.0 for size in sizes]

    # -- the proof ------------------------------------------------------------------------------------------

    def follow(self, window: Window, t: float, end: float, point: np.ndarray) -> np.ndarray | None:
        return point if self.stays(window, t, end, point) else None

    def place(self, window: Window, t: float, point: np.ndarray) -> np.ndarray:
        return point

    def stays(self, window: Window, t: float, end: float, point: np.ndarray) -> bool:
        """Whether the model is proved to hold the point over [t, end]."""
        own, other = (window.a, window.b) if self.side == 0 else (window.b, window.a)
        p, q = self.pose(own, t), self.pose(other, t)
        sheet, place, way = self.sheets[int(point[0])], [exact_value(c) for c in point[1:]], self._way(window)
        if not sheet.keeps(*place):
            return False
        here = sheet.at(way * exact_value(t)).point(*place)
        near = np.array([to_double(c / here[3]) for c in here[:3]])
        y = np.linalg.solve(linear(q), linear(p) @ near + p[9:12] - q[9:12])
        with precision(BITS):
            if sheet.later:  # all places over these times
                here = sheet.at(way * arb(t).union(arb(end))).point(*place)
            x = [arb(c / here[3]) for c in here[:3]]
            return self.solid.holds([arb(c) for c in y.tolist()], self.drift(own, other, t, end, x, y))

    # -- points ---------------------------------------------------------------------------------------------

    def anywhere(self, window: Window, t: float) -> np.ndarray | None:
        """A point proved common at t, from samples of the sheets."""
        there, grid = self._placed(window, t), _grid()
        seeds, heights = [], []
        for k in range(len(self.sheets)):
            here = self._heights(there, k, self._now(k, window, t), grid)
            best = int(np.argmin(here))
            seeds.append(np.array([k, *grid[best]]))
            heights.append(float(here[best]))
        return self.deepest(window, t, [seeds[k] for k in np.argsort(heights)[:4]])

    def near(self, window: Window, t: float, point: np.ndarray) -> np.ndarray:
        """The place of the sheets' samples that is nearest to a point of the world at t."""
        pose, grid = self.pose(window.a if self.side == 0 else window.b, t), _grid()
        own = np.linalg.solve(linear(pose), point - pose[9:12])
        away = [np.linalg.norm(self._points(self._now(k, window, t), grid)[:, :3] - own, axis=1)
                for k in range(len(self.sheets))]  # fmt: skip
        k = int(np.argmin([x.min() for x in away]))
        return np.array([k, *grid[int(np.argmin(away[k]))]])

    def held(self, window: Window, t: float, seeds: Sequence[np.ndarray]) -> np.ndarray | None:
        there = self._placed(window, t)
        for seed in seeds:
            k = int(seed[0])
            table = self._now(k, window, t)
            place, depth = descended(
                lambda x, steps: self._heights(there, k, table, x + steps),  # noqa: B023
                lambda x: self._directions(there, k, table, x),  # noqa: B023
                np.asarray(seed[1:], float),
            )
            point = np.array([k, *np.clip(place, LOWEST, HIGHEST)])
            if depth < 0.0 and self.stays(window, t, t, point):
                return point
        return None

    def in_world(self, window: Window, t: float, point: np.ndarray) -> np.ndarray:
        """Where a point is, rounded."""
        pose = self.pose(window.a if self.side == 0 else window.b, t)
        table = self._now(int(point[0]), window, t)
        place: np.ndarray = linear(pose) @ self._points(table, point[None, 1:])[0, :3] + pose[9:12]
        return place

    def _way(self, window: Window) -> int:
        return way_of(window, self.windows)

    def _now(self, k: int, window: Window, t: float) -> np.ndarray:
        """(2, n, 4) coefficients of the sides of a sheet at t."""
        table: np.ndarray = np.tensordot((self._way(window) * t) ** np.arange(len(self.tables[k])), self.tables[k], 1)
        return table

    def _placed(self, window: Window, t: float) -> np.ndarray:
        """The map from the ruled surface's frame to the model's at t."""
        own, other = (window.a, window.b) if self.side == 0 else (window.b, window.a)
        p, q = self.pose(own, t), self.pose(other, t)
        turn = np.linalg.solve(linear(p), linear(q))
        return self.solid.placed(turn, np.linalg.solve(linear(p), q[9:12] - p[9:12]))

    def _points(self, table: np.ndarray, places: np.ndarray) -> np.ndarray:
        """(n, 4) with weight 1, at places clipped to the sheet."""
        x, s = np.clip(places, LOWEST, HIGHEST).T
        first, second = (np.polynomial.polynomial.polyval(x, side).T for side in table)
        points = first * (1 - s)[:, None] + second * s[:, None]
        scaled: np.ndarray = points / points[:, 3:]
        return scaled

    def _heights(self, there: np.ndarray, k: int, table: np.ndarray, places: np.ndarray) -> np.ndarray:
        heights = self.solid.height(there, np.zeros(3), self._points(table, places)[:, :3])
        highest: np.ndarray = np.max([heights, *self._cut_off(k, places)], axis=0)
        return highest

    def _cut_off(self, k: int, places: np.ndarray) -> np.ndarray:
        """(m, n) by how much the inequalities of a sheet fail, negative where they hold, in units of its size."""
        x, s = np.clip(places, LOWEST, HIGHEST).T
        found = [-self.sizes[k] * np.polynomial.polynomial.polyval2d(x, s, cut) for cut in self.cuts[k]]
        return np.array(found).reshape(-1, len(x))

    def _directions(self, there: np.ndarray, k: int, table: np.ndarray, place: np.ndarray) -> np.ndarray:
        """(n, 2): all around, and across and away from the nearest surfaces."""
        step = 1e-5
        around = place + step * np.array([[1, 0], [-1, 0], [0, 1], [0, -1], [0, 0]])
        ends = self._points(table, around)
        values = np.vstack([self.solid.values(there, ends), self._cut_off(k, around)])
        slopes = np.column_stack([values[:, 0] - values[:, 1], values[:, 2] - values[:, 3]]) / (2 * step)
        near = np.argsort(np.abs(values[:, 4]))[:3]
        rows = slopes[near] / np.maximum(np.linalg.norm(slopes[near], axis=1, keepdims=True), 1e-300)
        signs = SIGNS[:, : len(near)]
        mixed = np.concatenate([signs @ rows, signs @ _inverse_of(slopes[near])])
        mixed = mixed / np.maximum(np.linalg.norm(mixed, axis=1, keepdims=True), 1e-300)
        return np.concatenate([AROUND, mixed])


def _grid() -> np.ndarray:
    """(n, 2) places of a sheet."""
    x, s = (c.ravel() for c in np.meshgrid(np.linspace(-1, 1, GRID[0]), np.linspace(0, 1, GRID[1])))
    return np.column_stack([x, s])


def _inverse_of(slopes: np.ndarray) -> np.ndarray:
    """(n, 2) transpose of the pseudo-inverse of n slopes (n, 2)."""
    (p, q), (_, r) = (slopes.T @ slopes).tolist()
    det = p * r - q * q
    if det > 1e-9 * (p + r) ** 2:  # in a tenth of the time
        found: np.ndarray = slopes @ (np.array([[r, -q], [-q, p]]) / det)
        return found
    return np.linalg.pinv(slopes, rcond=1e-9).T


def _doubles(sheet: ChartSheet) -> np.ndarray:
    """(m, 2, n, 4) coefficients of powers of T, of either side, ascending; all over the largest."""
    blocks = sheet, *sheet.later
    largest = max(abs(c) for block in blocks for side in (block.first, block.second) for p in side for c in p.coeffs())
    table = np.zeros((len(blocks), 2, sheet.degree + 1, 4))
    for block, rows in zip(blocks, table, strict=True):
        for row, side in zip(rows, (block.first, block.second), strict=True):
            for i, p in enumerate(side):
                for j, c in enumerate(p.coeffs()):
                    row[j, i] = to_double(fmpq(c, largest))
    return table


def _cut_in_doubles(cut: TrimCut) -> np.ndarray:
    """(n, m) coefficients of x^i s^j, the largest 1."""
    table = np.zeros(np.add(cut.degrees, 1))
    for j, p in enumerate(cut.powers):
        for i, c in enumerate(p.coeffs()):
            table[i, j] = to_double(fmpq(c, cut.size))
    return table
