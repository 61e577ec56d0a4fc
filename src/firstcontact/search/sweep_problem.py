"""Vertices against facets by the plane sweep, group by group; edges against edges by halving, as `lifted` does.

The groups are swept in rounds, each from the best time at its beginning, shared out to threads; what is asked does not
depend on how many there are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from firstcontact.errors import FirstContactError
from firstcontact.search.frame import frame_of
from firstcontact.search.lifted_elements import corners_of_tree, facets_of
from firstcontact.search.lifted_problem import lifted_scratch, motion_of, walk_lifted
from firstcontact.search.lifted_walk import CORNERS, FACETS
from firstcontact.search.rounds import Finds, shared
from firstcontact.search.state import CANDIDATES, DECIDE, DONE, FULL, QUERY, SLICE_SPENT, VISITS
from firstcontact.search.sweep import LARGEST_GROUP, LOST, Cells, Order, cells_of, order_of, sweep_group

ROUND = 8
"""Groups in a round."""
# The plane of the sweep is turned by this angle, so that common directions of sides are not across the sweep line.
_TURN = 0.7297
# Coordinates in the frame are off by this share of the largest one; facets are taken to be at least a 4096th of that.
_ROUNDING, _FARTHEST = 2.0**-48, 4096.0


@dataclass(slots=True)
class Side:
    """Vertices (k, 4) of one body in the order of the sweep (x, y, height, number) and facets (f, 3, 3) of the other.

    noise: how far coordinates in the frame may be off.  pace: heights per unit of time.
    """

    points: np.ndarray
    askers: np.ndarray
    facets: np.ndarray
    parts: np.ndarray
    noise: float
    pace: float
    swapped: bool

    def group(self, k: int) -> slice:
        return slice(k * self.size, (k + 1) * self.size)

    @property
    def size(self) -> int:
        return min(LARGEST_GROUP, max(1, math.isqrt(len(self.facets))))

    @property
    def count(self) -> int:
        return -(-len(self.facets) // self.size)


@dataclass(slots=True)
class Swept:
    """The search among vertices and facets; `work`: arguments of the pair test that stay (motion, parts, errors)."""

    sides: dict[int, Side]
    work: tuple[Any, ...]
    threads: int

    def advance(self, state: Any, phase: int, limit: int) -> int:
        """Go on with the groups of a phase; the reason it came back.  QUERY counts the groups that are done."""
        side, integers = self.sides[phase], state.integers
        while integers[QUERY] < side.count and len(side.points):
            first = int(integers[QUERY])
            jobs = [(k, Finds(state)) for k in range(first, min(first + ROUND, side.count))]
            shared(lambda job: self._sweep(side, *job), jobs, self.threads)
            for _, finds in jobs:
                finds.hand_to(state)
            integers[QUERY] = first + len(jobs)
            if integers[VISITS] >= limit:
                return SLICE_SPENT
            if integers[CANDIDATES]:
                return DECIDE
        return DONE

    def _sweep(self, side: Side, k: int, finds: Finds) -> None:
        chosen = side.group(k)
        facets, x, arcs, planes, tolerances = cells_of(side.facets[chosen], side.noise)
        cells = Cells(facets, x, arcs)
        loose, precedes = order_of(cells, planes, tolerances)
        order = Order(planes, loose, precedes)
        # neighbours are in order but for their tolerances: any two, but for those of all between
        tolerance = 2.0 * float(tolerances[~loose].sum()) + 64.0 * side.noise
        while True:
            reason = sweep_group(
                cells, order, tolerance, side.points, side.pace, side.askers, side.parts[chosen], side.swapped,
                *self.work, finds.floats, finds.integers, finds.times, finds.candidates,
            )  # fmt: skip
            if reason != FULL:
                break
            finds.grow()  # and sweep again, now from a better time
            finds.integers[CANDIDATES] = 0
        if reason == LOST:
            raise FirstContactError("the sweep lost the order of its arcs; engine 'lifted' does without")


def advance_sweep(problem: Any, state: Any, limit: int) -> int:
    """Go on with the search of a translation; the reason it came back."""
    if state.scratch is None:
        motion, _, errors = motion_of(problem)
        a, b = problem.tree_a, problem.tree_b
        sides = {
            phase: _side(x, y, sense * motion[6:9], sum(errors), phase == FACETS)
            for phase, x, y, sense in ((CORNERS, a, b, 1.0), (FACETS, b, a, -1.0))
        }
        state.scratch = lifted_scratch(problem), Swept(sides, (motion, a.xyz, b.xyz, *errors), problem.threads)
    scratch, swept = state.scratch
    searches = {}
    if scratch is not None and motion_of(problem)[0][6:9].any():
        searches = {p: lambda arc, p=p: swept.advance(state, p, limit) for p in (CORNERS, FACETS)}
    return walk_lifted(problem, scratch, state, limit, searches)


def _side(moving: Any, resting: Any, v: np.ndarray, error: float, swapped: bool) -> Side:
    """The vertices of one tree, as they move by v, and the facets of the other."""
    found, faced = corners_of_tree(moving), facets_of(resting)
    order = np.argsort(faced.parts[:, 0])  # in the order of the tree: neighbours come into one group
    facets, points = faced.corners[order].reshape(-1, 3, 3), found.corners[:, :3]
    speed = float(np.abs(v).max(initial=0.0))
    if not len(facets) or not len(points) or speed == 0.0:
        return Side(np.empty((0, 4)), found.parts, facets, faced.parts, 0.0, 1.0, swapped)
    frame = np.array(frame_of(tuple((v / speed).tolist())), float)  # type: ignore[arg-type]
    frame[:2] = np.array([[math.cos(_TURN), math.sin(_TURN)], [-math.sin(_TURN), math.cos(_TURN)]]) @ frame[:2]
    origin = 0.5 * (facets.min(axis=(0, 1)) + facets.max(axis=(0, 1)))
    far = float(max(np.abs(facets - origin).max(), np.abs(points - origin).max()))
    scale = max(float(np.abs(facets - origin).max()), far / _FARTHEST, 2.0**30 * error, 1e-300)
    place = np.column_stack([(points - origin) @ frame.T / scale, np.arange(len(points))])
    noise = _ROUNDING * (4.0 + far / scale) + 4.0 * error / scale
    return Side(
        np.ascontiguousarray(place[np.argsort(place[:, 0])]), found.parts,
        np.ascontiguousarray((facets - origin) @ frame.T / scale), np.ascontiguousarray(faced.parts[order]),
        noise, float(frame[2] @ v) / scale, swapped,
    )  # fmt: skip
