"""Vertices against facets by the plane sweep, group by group; edges against edges by halving, as `lifted` does.

The groups are swept in rounds, each from the best time at its beginning, shared out to threads; what is asked does not
depend on how many there are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from firstcontact.contact.polyhedra.engines import ByEngine
from firstcontact.contact.polyhedra.problems.lifted_problem import lifted_scratch, motion_of, walk_lifted
from firstcontact.errors import FirstContactError
from firstcontact.kernels.angle import TWO_PI
from firstcontact.search.lifted.lifted_elements import Elements, corners_of_tree, facets_of
from firstcontact.search.lifted.lifted_walk import CORNERS, FACETS
from firstcontact.search.sweep.sheets import sheets_of
from firstcontact.search.sweep.sweep import LARGEST_GROUP, LOST, GroupCells, Order, cells_of, order_of, sweep_group
from firstcontact.search.trees.frame import frame_of
from firstcontact.search.trees.rounds import Finds, shared
from firstcontact.search.trees.state import (
    ALLOWED,
    BEYOND,
    CANDIDATES,
    DECIDE,
    DONE,
    FULL,
    QUERY,
    SLICE_SPENT,
    TESTS,
    VISITS,
    WalkState,
)
from firstcontact.search.trees.tree import Tree

ROUND = 8
"""Groups in a round."""
LARGEST_TURNING_GROUP = 300
"""Of facets of which each may give several sheets."""
# The plane of the sweep is turned by this angle, so that common directions of sides are not across the sweep line.
_TURN = 0.7297
# Coordinates in the frame are off by this share of the largest one; facets are taken to be at least a 4096th of that,
# and so many times as large as the errors of their corners.
_ROUNDING, _FARTHEST, _LEAST = 2.0**-48, 4096.0, 2.0**40


@dataclass(slots=True)
class SweepSide:
    """Vertices (k, 4) of one body in the order of the sweep (x, y, height, number) and facets (f, 3, 3) of the other.

    noise: how far coordinates in the frame may be off.  pace: heights per unit of time.  turning: heights are angles.
    """

    points: np.ndarray
    askers: np.ndarray
    facets: np.ndarray
    parts: np.ndarray
    noise: float
    pace: float
    swapped: bool
    turning: bool

    def group(self, k: int) -> tuple[GroupCells, Order, np.ndarray, float]:
        """Cells, their order, the parts of sheets, and by how much any two heights may be out of order."""
        chosen = slice(k * self.size, (k + 1) * self.size)
        facets, parts = self.facets[chosen], self.parts[chosen]
        if self.turning:
            owners, x, arcs, heights, tolerances, slacks = sheets_of(facets, self.noise)
            sheets, parts = np.arange(len(owners), dtype=np.int32), parts[owners]
        else:
            sheets, x, arcs, heights, tolerances = cells_of(facets, self.noise)
            # neighbours are in order but for their tolerances: any two, but for those of all between
            slacks = 2.0 * tolerances
        cells = GroupCells(sheets, x, arcs)
        order = Order(heights, *order_of(cells, heights, tolerances))
        return cells, order, parts, float(slacks[~order.loose].sum()) + 64.0 * self.noise

    @property
    def size(self) -> int:
        most = LARGEST_TURNING_GROUP if self.turning else LARGEST_GROUP
        return min(most, max(1, math.isqrt(len(self.facets))))

    @property
    def count(self) -> int:
        return -(-len(self.facets) // self.size)


@dataclass(slots=True)
class SweptProblem:
    """The search among vertices and facets; `work`: arguments of the pair test that stay (motion, parts, errors)."""

    sides: dict[int, SweepSide]
    work: tuple[Any, ...]
    threads: int

    def advance(self, state: WalkState, phase: int, limit: int) -> int:
        """Go on with the groups of a phase; the reason it came back.  QUERY counts the groups that are done."""
        side, integers = self.sides.get(phase), state.integers
        if side is None:  # a turn is searched in arcs, of which the first one swept it all
            return DONE
        while integers[QUERY] < side.count and len(side.points):
            first, allowed = int(integers[QUERY]), int(integers[ALLOWED])
            if 0 < allowed < integers[VISITS] + integers[TESTS] + len(side.points):  # a group takes about as many
                return BEYOND
            last = min(first + (1 if allowed else ROUND), side.count)
            jobs = [(k, Finds(state)) for k in range(first, last)]
            shared(lambda job: self._sweep(side, *job), jobs, self.threads)
            for _, finds in jobs:
                finds.hand_to(state)
            integers[QUERY] = first + len(jobs)
            if integers[VISITS] >= limit:
                return SLICE_SPENT
            if integers[CANDIDATES]:
                return DECIDE
        del self.sides[phase]
        return DONE

    def _sweep(self, side: SweepSide, k: int, finds: Finds) -> None:
        cells, order, parts, tolerance = side.group(k)
        starts, ends = (np.argsort(cells.x[:, i]) for i in range(2))
        first, last = cells.x[starts[0], 0], cells.x[ends[-1], 1]
        points = side.points[slice(*np.searchsorted(side.points[:, 0], [first, np.nextafter(last, np.inf)]))]
        while True:
            reason = sweep_group(
                cells, starts, ends, order, tolerance, points, side.pace, side.askers, parts, side.swapped,
                *self.work, finds.floats, finds.integers, finds.times, finds.candidates,
            )  # fmt: skip
            if reason != FULL:
                break
            finds.grow()  # and sweep again, now from a better time
            finds.integers[CANDIDATES] = 0
        if reason == LOST:
            raise FirstContactError("the sweep lost the order of its arcs; engine 'lifted' does without")


def advance_sweep(problem: ByEngine, state: WalkState, limit: int) -> int:
    """Go on with the search of a translation or rotation; the reason it came back."""
    if state.scratch is None:
        motion, _, errors = motion_of(problem)
        a, b = problem.tree_a, problem.tree_b
        side = _side if len(motion) == 1 else _side_about
        sides = {
            CORNERS: side(a, b, motion, 1.0, sum(errors)),
            FACETS: side(b, a, motion, -1.0, sum(errors)),
        }
        state.scratch = lifted_scratch(problem), SweptProblem(sides, (motion, a.xyz, b.xyz, *errors), problem.threads)
    scratch, swept = state.scratch
    searches = {}
    motion = motion_of(problem)[0]
    if len(motion) > 1 or motion[0, 6:9].any():
        searches = {p: lambda arc, p=p: swept.advance(state, p, limit) for p in (CORNERS, FACETS)}
    return walk_lifted(problem, scratch, state, limit, searches)


def _side(moving: Tree, resting: Tree, motion: np.ndarray, sense: float, error: float) -> SweepSide:
    """The vertices of one tree, as they move against the other one, and the facets of that one."""
    found, faced, parts, facets, points = _vertices_and_facets(moving, resting)
    v = sense * motion[0, 6:9]
    speed = float(np.abs(v).max(initial=0.0))
    if not len(facets) or not len(points) or speed == 0.0:
        return SweepSide(np.empty((0, 4)), found.parts, facets, faced.parts, 0.0, 1.0, sense < 0.0, False)
    frame = np.array(frame_of(tuple((v / speed).tolist())), float)
    frame[:2] = np.array([[math.cos(_TURN), math.sin(_TURN)], [-math.sin(_TURN), math.cos(_TURN)]]) @ frame[:2]
    origin = 0.5 * (facets.min(axis=(0, 1)) + facets.max(axis=(0, 1)))
    far = float(max(np.abs(facets - origin).max(), np.abs(points - origin).max()))
    scale = max(float(np.abs(facets - origin).max()), far / _FARTHEST, _LEAST * error, 1e-300)
    noise = _ROUNDING * (4.0 + far / scale) + 4.0 * error / scale
    return SweepSide(
        _in_order((points - origin) @ frame.T / scale), found.parts,
        np.ascontiguousarray((facets - origin) @ frame.T / scale), parts,
        noise, float(frame[2] @ v) / scale, sense < 0.0, False,
    )  # fmt: skip


def _side_about(moving: Tree, resting: Tree, motion: np.ndarray, sense: float, error: float) -> SweepSide:
    """The same for a rotation.  What turns backward turns forward in the mirror image y -> -y."""
    found, faced, parts, facets, points = _vertices_and_facets(moving, resting)
    if not len(facets) or not len(points):
        return SweepSide(np.empty((0, 4)), found.parts, facets, faced.parts, 0.0, 1.0, sense < 0.0, True)
    low, high = float(facets[..., 2].min()), float(facets[..., 2].max())
    origin = np.array([motion[-1, 0], motion[-1, 1], 0.5 * (low + high)])
    facets, points = ((x - origin) * np.array([1.0, sense, 1.0]) for x in (facets, points))
    across = max(float(np.hypot(facets[..., 0], facets[..., 1]).max()), _LEAST * error, 1e-150)
    along = max(0.5 * (high - low), max(abs(low), abs(high)) / _FARTHEST, _LEAST * error, 1e-150)
    facets, points = (x / np.array([across, across, along]) for x in (facets, points))
    x, y = points[:, 0], points[:, 1]
    seen = np.column_stack([points[:, 2], x * x + y * y, np.arctan2(y, x) % TWO_PI])
    noise = _ROUNDING * (1.0 + max(abs(low), abs(high)) / along) + 4.0 * error / min(across, along)
    return SweepSide(
        _in_order(seen), found.parts, np.ascontiguousarray(facets), parts, noise, 1.0, sense < 0.0, True
    )  # fmt: skip


def _vertices_and_facets(moving: Tree, resting: Tree) -> tuple[Elements, Elements, np.ndarray, np.ndarray, np.ndarray]:
    """Elements, parts and corners; facets in the order of the tree, so that neighbours come into one group."""
    found, faced = corners_of_tree(moving), facets_of(resting)
    order = np.argsort(faced.parts[:, 0])
    parts = np.ascontiguousarray(faced.parts[order])
    return found, faced, parts, faced.corners[order].reshape(-1, 3, 3), found.corners[:, :3]


def _in_order(seen: np.ndarray) -> np.ndarray:
    """Points (k, 4) in the order of the sweep, with their numbers."""
    place = np.column_stack([seen, np.arange(len(seen))])
    return np.ascontiguousarray(place[np.argsort(place[:, 0])])
