"""First contact of edges by the paper's structure: queries in random order, in rounds that double.

Parametric search would find the first time out of the structure that decides "is any edge met in [0, t]?".  Instead
(Chan 1999, "Geometric applications of a randomized optimization technique"): the moving edges ask in random order
whether they meet anything before the best time so far; what they do meet is put to the pair test and gives the new
best time.  The k-th edge is the one that meets earliest with probability 1/k: ln n edges in all are expected to
improve the best time.  All queries of a round ask about the best time at the round's beginning, and each round is as
long as all before it, so that a round holds a constant number of improvements on average.

A round is shared out to threads, which bring their best times together at its end.  What is asked and tested does not
depend on their number, nor does the answer.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from firstcontact.contact.polyhedra.engines import ByEngine
from firstcontact.contact.polyhedra.problems.lifted_problem import lifted_scratch, motion_of, walk_lifted
from firstcontact.search.levels.composed import (
    FEATURE,
    FORM,
    NODE,
    PLACE,
    QUERY,
    STACK_FULL,
    TREE_MISSING,
    WANTED,
    WAY,
    WIDTH,
    EdgeQueries,
    Levels,
    Plan,
    add_tree,
    ask_levels,
    empty_levels,
    room_for_tree,
)
from firstcontact.search.levels.linearisation import (
    Bounded,
    Conjunction,
    Features,
    Form,
    rotation_conjunctions,
    rotation_features,
    translation_conjunctions,
    translation_features,
)
from firstcontact.search.lifted.lifted_elements import Elements, edges_of
from firstcontact.search.lifted.lifted_motion import ARC_STARTS, arc_tangent
from firstcontact.search.lifted.lifted_walk import EDGES
from firstcontact.search.trees.rounds import Finds, shared
from firstcontact.search.trees.state import BEST, CANDIDATES, DECIDE, DONE, FULL, SLICE_SPENT, VISITS, WalkState
from firstcontact.search.trees.state import QUERY as ROUND
from firstcontact.search.trees.state import STACK as PART
from firstcontact.search.trees.tree import FLAT_SIDE, SIDE
from firstcontact.work import doubled

Point = tuple[Bounded, Bounded, Bounded]

FIRST_ROUND = 16
_building = threading.Lock()
_U = 2.0**-53


@dataclass(slots=True)
class Frame:
    """Where forms are worked out: about the origin, in units of scale (a power of two); errors of coordinates."""

    origin: np.ndarray
    scale: float
    error_a: float
    error_b: float

    def points(self, corners: np.ndarray, column: int, error: float) -> Point:
        """Corners (m, 9) from that column on; the difference to the origin rounds once, and both may be off."""
        found = []
        for k in range(3):
            x = (corners[:, column + k] - self.origin[k]) / self.scale
            found.append(Bounded(x, error / self.scale + 2.0 * _U * np.abs(x)))
        return found[0], found[1], found[2]


class RestingLevels:
    """Edges at rest in levels of trees, for one kind of conjunctions."""

    def __init__(self, features: Features, count: int, parts: np.ndarray) -> None:
        self.parts, self.count = parts, count
        self.names = list(features)
        self.vectors = np.zeros((len(features), count, WIDTH))
        self.size, self.error = np.zeros((len(features), WIDTH)), np.zeros((len(features), WIDTH))
        for f, vector in enumerate(features.values()):
            for k, entry in enumerate(vector):
                value, error = (entry.value, entry.error) if isinstance(entry, Bounded) else (entry, 0.0)
                self.vectors[f, :, k] = value
                self.size[f, k] = np.max(np.abs(self.vectors[f, :, k]), initial=0.0)
                self.error[f, k] = np.max(error, initial=0.0)
        self.levels = empty_levels(64, 64, len(features))
        self.tops = np.full(len(features), -1, np.int32)
        self.plan: Plan | None = None

    def begin(self, conjunctions: tuple[Conjunction, ...]) -> None:
        """Ready for queries by these conjunctions, of any moving edges."""
        self.plan = plan_of(conjunctions, self.names)
        # a first node with all edges below which the trees of the first steps hang
        self.levels = room_for_tree(self.levels, self.count)
        self.levels.ids[: self.count] = np.arange(self.count)
        self.levels.counts[1] = self.count
        for feature in {int(step[FEATURE]) for step in self.plan.steps[: self.plan.roots]}:
            self.tops[feature] = self._add(feature, 0, self.count)

    def add_below(self, node: int, feature: int) -> None:
        """The tree of the node's edges by the feature, unless another thread has made it."""
        if self.levels.below[node, feature] < 0:
            first, last = self.levels.nodes[node, :2]
            self.levels.below[node, feature] = self._add(feature, int(first), int(last))

    def _add(self, feature: int, first: int, last: int) -> int:
        self.levels = room_for_tree(self.levels, last - first)
        return int(add_tree(self.vectors[feature], first, last, self.levels))

    def questions(self, conjunctions: tuple[Conjunction, ...], parts: np.ndarray) -> EdgeQueries:
        """The forms of the conjunctions of moving edges with these parts (k, 2), and how far each may be off.

        A form's value at a node may be off by the errors of either vector, and by 2^-44 of the sizes for its roundings:
        at most 6 axes, each with 6 products, of vectors whose axes mix entries.
        """
        forms = _distinct(conjunctions)
        out = np.zeros((len(parts), len(forms), WIDTH))
        slacks = np.zeros((len(parts), len(forms)))
        for j, form in enumerate(forms):
            f = self.names.index(form.feature)
            size, error = self.size[f], self.error[f]
            total = np.zeros(len(parts))
            for k, entry in enumerate(form.delta):
                value, off = (entry.value, entry.error) if isinstance(entry, Bounded) else (entry, 0.0)
                out[:, j, k] = value
                total += np.abs(out[:, j, k])
                slacks[:, j] += off * (size[k] + error[k]) + np.abs(out[:, j, k]) * error[k]
            slacks[:, j] = slacks[:, j] * (1.0 + 1e-12) + 2.0**-44 * total * size.max()
        return EdgeQueries(out, slacks, parts)


def _distinct(conjunctions: tuple[Conjunction, ...]) -> list[Form]:
    """The forms, each once, in the order in which they appear."""
    return list({id(x.form): x.form for conjunction in conjunctions for x in conjunction}.values())


def plan_of(conjunctions: tuple[Conjunction, ...], names: list[str]) -> Plan:
    """The conjunctions as a tree of steps; strict conjuncts count as closed, the pair test decides."""
    forms = _distinct(conjunctions)
    numbers = {id(form): k for k, form in enumerate(forms)}
    begin: dict[Any, Any] = {}
    for conjunction in conjunctions:
        at = begin
        for form, way, _ in conjunction:
            at = at.setdefault((numbers[id(form)], way), {})
    rows = [[form, way, names.index(forms[form].feature), 0, 0] for form, way in begin]
    waiting = list(begin.values())
    done = 0
    while done < len(waiting):
        after = waiting[done]
        rows[done][3:] = len(rows), len(rows) + len(after)
        rows += [[form, way, names.index(forms[form].feature), 0, 0] for form, way in after]
        waiting += after.values()
        done += 1
    steps = np.array(rows, np.int64)
    assert steps[:, FORM].max() < len(forms) and set(steps[:, WAY]) <= {-1, 1}
    return Plan(steps, len(begin))


# ------------------------------------------------------------------------------------------------- motions


@dataclass(slots=True)
class EdgeGroup:
    """Moving edges (k of them) that ask one set of resting edges; `conjunctions` of some of them, by their indices."""

    resting: RestingLevels
    parts: np.ndarray
    conjunctions: Callable[[slice, int], tuple[Conjunction, ...]]


def translation_groups(
    moving: Elements, resting: Elements, frame: Frame, v: np.ndarray, last: Callable[[], float]
) -> list[EdgeGroup]:
    """v (3,): the velocity, rounded once; last: the time until which the moving edges ask."""
    if not len(moving.parts) or not len(resting.parts):
        return []
    a, b = (frame.points(moving.corners, k, frame.error_a) for k in (0, 3))
    c, d = (frame.points(resting.corners, k, frame.error_b) for k in (0, 3))
    x, y, z = (Bounded(x / frame.scale, _U * abs(x) / frame.scale) for x in v.tolist())
    way: Any = x, y, z

    def conjunctions(chosen: slice, arc: int) -> tuple[Conjunction, ...]:
        return translation_conjunctions(_some(a, chosen), _some(b, chosen), way, np.float64(last()))

    asked = RestingLevels(translation_features(c, d), len(resting.parts), resting.parts)
    return [EdgeGroup(asked, moving.parts, conjunctions)]


def rotation_groups(
    moving: Elements, resting: Elements, frame: Frame, tangent: Callable[[int], float]
) -> list[EdgeGroup]:
    """tangent(arc): of half the angle until which the moving edges ask, from the beginning of the arc on.

    The conditions on heights suit edges that surely rise; of others the conditions on the time alone are asked.
    """
    groups = []
    for x, rising_a in _by_slope(moving, frame.error_a):
        a, b = (frame.points(x.corners, k, frame.error_a) for k in (0, 3))
        for y, rising_b in _by_slope(resting, frame.error_b):
            c, d = (frame.points(y.corners, k, frame.error_b) for k in (0, 3))
            full = rising_a and rising_b
            features = rotation_features(c, d)
            kept = features if full else {"line": features["line"]}
            groups.append(EdgeGroup(RestingLevels(kept, len(y.parts), y.parts), x.parts, _turned(a, b, tangent, full)))
    return groups


def _turned(
    a: Point, b: Point, tangent: Callable[[int], float], full: bool
) -> Callable[[slice, int], tuple[Conjunction, ...]]:
    def conjunctions(chosen: slice, arc: int) -> tuple[Conjunction, ...]:
        c, s = (Bounded(x, _U) for x in ARC_STARTS[arc].tolist())
        begin, end = ((c * x - s * y, s * x + c * y, z) for x, y, z in (_some(p, chosen) for p in (a, b)))
        found = rotation_conjunctions(begin, end, np.float64(tangent(arc)))
        return found if full else tuple({_on_time(x): None for x in found})

    return conjunctions


def _on_time(conjunction: Conjunction) -> Conjunction:
    return tuple(x for x in conjunction if x.form.feature == "line")


def _by_slope(elements: Elements, error: float) -> Iterator[tuple[Elements, bool]]:
    """(those that surely rise, lower ends first; True) and (those that may be level; False), where there are any."""
    lower, upper = elements.corners[:, 0:3], elements.corners[:, 3:6]
    falls = lower[:, 2] > upper[:, 2]
    ends = np.where(falls[:, None], elements.corners[:, [3, 4, 5, 0, 1, 2, 6, 7, 8]], elements.corners)
    rises = np.abs(upper[:, 2] - lower[:, 2]) > 4.0 * error
    for rising in (True, False):
        chosen = rises == rising
        if chosen.any():
            yield Elements(elements.parts[chosen], ends[chosen]), rising


def _some(p: Point, chosen: slice) -> Any:
    return tuple(Bounded(x.value[chosen], x.error[chosen]) for x in p)


# ------------------------------------------------------------------------------------------------- rounds


@dataclass(slots=True)
class Worker:
    """One thread's share of a round: its questions, its place among them, and what it has found."""

    questions: EdgeQueries
    asked: np.ndarray
    finds: Finds
    place: np.ndarray = field(default_factory=lambda: np.zeros(PLACE, np.int64))
    stack: np.ndarray = field(default_factory=lambda: np.empty((512, 2), np.int32))

    def is_done(self) -> bool:
        return int(self.place[QUERY]) == len(self.questions.parts)


@dataclass(slots=True)
class Composed:
    """The search among edges; `work`: arguments of the pair test that stay (motion, parts, errors, sides)."""

    groups: list[EdgeGroup]
    work: tuple[Any, ...]
    threads: int = 1
    workers: list[Worker] = field(default_factory=list)

    def advance(self, state: WalkState, arc: int, limit: int) -> int:
        """Go on with the rounds of the arc; the reason it came back.  PART and ROUND keep the place."""
        integers = state.integers
        while True:
            for worker in self.workers:
                worker.finds.floats[BEST] = state.floats[BEST]
            if not self.workers:
                part = int(integers[PART]) - 1
                if part >= len(self.groups):
                    return DONE
                if not self._share_out(self.groups[part], int(integers[ROUND]), arc, state):
                    integers[PART], integers[ROUND] = part + 2, 0
                    continue
            self._work_on(self.groups[int(integers[PART]) - 1].resting, limit - int(integers[VISITS]))
            for worker in self.workers:
                worker.finds.hand_to(state)
            if all(worker.is_done() for worker in self.workers):
                integers[ROUND] += sum(len(worker.questions.parts) for worker in self.workers)
                self.workers = []
            if integers[VISITS] >= limit:
                return SLICE_SPENT
            if integers[CANDIDATES]:
                return DECIDE

    def _share_out(self, group: EdgeGroup, first: int, arc: int, state: WalkState) -> bool:
        """Begin the round at the moving edge `first`; False when there is none."""
        last = min(len(group.parts), max(FIRST_ROUND, 2 * first))
        if first >= last:
            return False
        conjunctions = group.conjunctions(slice(first, last), arc)
        if group.resting.plan is None:
            group.resting.begin(conjunctions)
        questions = group.resting.questions(conjunctions, group.parts[first:last])
        ends = np.linspace(0, last - first, min(self.threads, last - first) + 1).astype(int)
        for lo, hi in zip(ends, ends[1:], strict=False):
            share = EdgeQueries(*(np.ascontiguousarray(x[lo:hi]) for x in questions))
            asked = np.full(group.resting.count, -1, np.int32)
            self.workers.append(Worker(share, asked, Finds(state)))
        return True

    def _work_on(self, resting: RestingLevels, limit: int) -> None:
        """Let every worker go on with its share; limit: node visits of all together."""
        waiting = [worker for worker in self.workers if not worker.is_done()]
        allowed = max(1, limit // len(waiting))
        shared(lambda worker: self._run(worker, resting, allowed), waiting, self.threads)

    def _run(self, worker: Worker, resting: RestingLevels, limit: int) -> None:
        """Ask until the share is done, the limit is reached or candidates fill the worker's room."""
        assert resting.plan is not None
        finds = worker.finds
        while True:
            levels: Levels = resting.levels
            reason = ask_levels(
                levels, resting.vectors, resting.plan, resting.tops, worker.questions, resting.parts, *self.work, limit,
                worker.place, worker.stack, worker.asked, finds.floats, finds.integers, finds.times, finds.candidates,
            )  # fmt: skip
            if reason == STACK_FULL:
                (worker.stack,) = doubled(worker.stack)
            elif reason == TREE_MISSING:
                with _building:
                    resting.add_below(int(worker.place[NODE]), int(worker.place[WANTED]))
            elif reason == FULL:
                finds.grow()
            else:
                return


# ------------------------------------------------------------------------------------------------- problems


def advance_composed(problem: ByEngine, state: WalkState, limit: int, all_sides: bool = False) -> int:
    """Go on with the search of a translation or rotation; the reason it came back.

    Corners against facets, and edges through facets at the start, are asked of lifted trees.
    """
    if state.scratch is None:
        state.scratch = lifted_scratch(problem), _composed(problem, state, all_sides)
    scratch, composed = state.scratch
    return walk_lifted(problem, scratch, state, limit, {EDGES: lambda arc: composed.advance(state, arc, limit)})


def _composed(problem: ByEngine, state: WalkState, all_sides: bool) -> Composed:
    a, b, floats = problem.tree_a, problem.tree_b, state.floats
    moving, resting = edges_of(a, all_sides), edges_of(b, all_sides)
    motion, reach, errors = motion_of(problem)
    sides = (1 << SIDE) | ((1 << FLAT_SIDE) if all_sides else 0)
    work = problem.motion, a.xyz, b.xyz, *errors, sides
    if len(motion) == 1:
        frame = _frame_about(b.xyz.reshape(-1, 3).mean(axis=0), resting, errors)
        groups = translation_groups(moving, resting, frame, motion[0, 6:9], lambda: min(float(floats[BEST]), reach))
    else:
        end = len(motion) - 1
        frame = _frame_about(np.array([motion[end, 0], motion[end, 1], 0.0]), resting, errors)
        groups = rotation_groups(moving, resting, frame, lambda arc: float(arc_tangent(arc, floats)))
    return Composed(groups, work, problem.threads)


def _frame_about(origin: np.ndarray, resting: Elements, errors: tuple[float, float]) -> Frame:
    size = float(np.abs(resting.corners[:, 0:6].reshape(-1, 3) - origin).max(initial=0.0))
    return Frame(origin, 2.0 ** math.frexp(size)[1] if 0.0 < size < math.inf else 1.0, *errors)
