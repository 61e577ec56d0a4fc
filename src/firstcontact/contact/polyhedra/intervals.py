"""All closed times of one piece at which two bodies share a point: floats cover the inside, exact ends."""

from __future__ import annotations

import time as clock
from dataclasses import dataclass, field
from functools import cmp_to_key
from itertools import pairwise
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from flint import fmpq

from firstcontact.contact.polyhedra.doubts import Doubt, merged, settled
from firstcontact.contact.polyhedra.earliest import Problem, Window
from firstcontact.exact.numbers import PRECISIONS, Undecidable, below, precision
from firstcontact.exact.times.instants import RationalInstant
from firstcontact.motion.relative.curved import CurvedPiece
from firstcontact.search.trees.containment import contained_at, decide
from firstcontact.search.trees.state import SLICE, share_of
from firstcontact.search.trees.windows import COVERS, DONE, FOUND, FULL, STACK, TESTS, VISITS
from firstcontact.work import WORTH, Progress, Spent, may_grow

if TYPE_CHECKING:
    from firstcontact.contact.polyhedra.problems.enclosed_problem import EnclosedProblem


# Primitives that are in doubt for long, such as those that slide along each other: after so many no answer is expected.
# With one of them, so many looks at times in all are enough: those with many sides take long each.
MOST_WIDE, MOST_LOOKS = 16, 5000

# Visits of the first slice of a walk, and seconds that one should take: a visit may look at all the times of two
# facets that slide in one another, so that slices adapt.
FIRST_SLICE, SHORT = 1024, 0.1


@dataclass(slots=True)
class Windows:
    """Windows of contact (start, end), exact instants, disjoint and ascending.

    open: what stopped the search, if anything; then they are those before `until` in the local clock.
    """

    windows: list[Window] = field(default_factory=list)
    open: str | None = None
    until: float = 0.0
    visits: int = 0
    tests: int = 0
    unsure: int = 0
    exact: int = 0
    looks: int = 0
    engine: str = "boxes"

    @property
    def work(self) -> int:
        """Of which the exact part is as much of it as any other: pairs of primitives that are looked at exactly."""
        return self.visits + self.tests + self.exact + WORTH * self.looks


def contact_windows(problem: Problem, budget: int | None, progress: Progress | None) -> Windows:
    """All windows of contact of the piece, its solids' interiors included."""
    answer = Windows()
    collected = _collect(problem, answer, budget, progress)
    if collected is None:
        return answer
    cover, parts = collected
    try:
        last = problem.window()[0]
        items = [problem.float_window(lo, hi) for lo, hi in cover if hi >= 0.0 and lo <= last]
        items = [(start, end) for start, end in items if problem.order(start, end) <= 0]
        doubts: list[Doubt] = []
        known: list[Window] = []
        for item in items:
            known = _joined(problem, known, item)
        wide = 0
        for (part_a, part_b), spans in parts:
            if all(_is_within(problem, span, known) for span in spans):
                continue  # they meet at no other times
            if budget is not None and answer.work >= budget:
                answer.open = "budget"
                return answer
            if progress is not None:
                progress(0.0, answer.work)
            answer.exact += 1
            certain, open_times = _counted(problem, part_a, part_b, answer, budget)
            items, doubts = items + certain, doubts + open_times
            for item in certain:
                known = _joined(problem, known, item)
            wide += any(doubt.is_wide(_in_balls(problem).length) for doubt in merged(open_times))
            if wide == MOST_WIDE or (wide and problem.looks > MOST_LOOKS):
                raise Undecidable
        with precision(PRECISIONS[-1]):  # ends that balls tell to many digits lose none
            windows, open_from = _settled(problem, items, doubts)
            until = None if open_from is None else below(open_from)
            if problem.a.solid or problem.b.solid:
                windows, untold = _with_containment(problem, windows, open_from)
                until = until if untold is None else untold
            answer.windows = windows
            if until is not None:
                answer.open, answer.until = "precision", until
    except Undecidable:
        answer.open = "precision"
    except Spent:
        answer.open = "budget"
    return answer


def _counted(
    problem: Problem, part_a: int, part_b: int, answer: Windows, budget: int | None
) -> tuple[list[Window], list[Doubt]]:
    """As `_windows_of`, within the budget.  Raises Spent."""
    if budget is not None:
        problem.most_looks = max(budget - answer.visits - answer.tests - answer.exact, 0) // WORTH
    try:
        return _windows_of(problem, part_a, part_b)
    finally:
        answer.looks, problem.most_looks = problem.looks, None


def _windows_of(problem: Problem, part_a: int, part_b: int) -> tuple[list[Window], list[Doubt]]:
    """The windows of contact of two primitives, and the times left open; where times are exact there are none."""
    try:
        enclosed = _in_balls(problem)
    except Undecidable:
        return list(decide(lambda: problem.windows_of(part_a, part_b))), []
    try:
        return list(enclosed.windows_of(part_a, part_b)), []
    except Undecidable:
        certain, open_times = enclosed.windows_and_doubts(part_a, part_b)
        return list(certain), open_times


def _settled(
    problem: Problem, items: list[Window], doubts: list[Doubt]
) -> tuple[list[Window], fmpq | None]:
    """The union of the windows, and the time from which on it is open what else there is."""
    if not doubts:
        try:
            return _union(items, problem), None
        except Undecidable:
            pass  # equal times, perhaps
    windows, open_from = settled(items, doubts, _in_balls(problem).length)
    return list(windows), open_from


def _in_balls(problem: Problem) -> EnclosedProblem:
    """The problem, if its times are balls: those of others are exact, and what they leave open stays so.

    Raises Undecidable.
    """
    if not isinstance(problem.piece, CurvedPiece) or problem.piece.is_rational:
        raise Undecidable
    return cast("EnclosedProblem", problem)


def _collect(
    problem: Problem, answer: Windows, budget: int | None, progress: Progress | None
) -> tuple[list[tuple[float, float]], list[tuple[tuple[int, int], list[tuple[float, float]]]]] | None:
    """(certain cover, primitive pairs that matter at its ends); None when the budget is spent, or memory.

    Each pair with the times outside of which it does not meet, those with the longest ones first.
    """
    integers = np.zeros(5, np.int64)
    integers[STACK] = 1
    stack = np.zeros((1024, 2), np.int32)
    cover = np.empty((64, 2))
    times, parts = np.empty((4096, 4)), np.empty((4096, 2), np.int32)
    slice_ = FIRST_SLICE
    while True:
        limit = int(integers[VISITS]) + slice_
        if budget is not None:
            limit = min(limit, int(integers[VISITS]) + share_of(budget - answer.visits - answer.tests))
        begin = clock.perf_counter()
        reason = problem.collect(limit, integers, stack, cover, times, parts)
        if clock.perf_counter() - begin < SHORT:
            slice_ = min(2 * slice_, SLICE)
        else:
            slice_ = max(slice_ // 2, 1)
        answer.visits, answer.tests = int(integers[VISITS]), int(integers[TESTS])
        if reason == DONE:
            break
        if reason == FULL:
            if not may_grow(times, parts, stack):
                answer.open = "memory"
                return None
            times, parts = _drop_covered(integers, cover, times, parts)
            if integers[STACK] * 2 > len(stack):
                stack = np.concatenate([stack, np.zeros_like(stack)])
            continue
        if progress is not None:
            progress(0.0, answer.visits + answer.tests)
        if budget is not None and answer.visits + answer.tests >= budget:
            answer.open = "budget"
            return None
    times, parts = _drop_covered(integers, cover, times, parts)
    n = int(integers[FOUND])
    answer.unsure = int(_are_unsure(times[:n]).sum())
    ids_a, ids_b = problem.tree_a.ids[parts[:n, 0], 0], problem.tree_b.ids[parts[:n, 1], 0]
    spans: dict[tuple[int, int], list[tuple[float, float]]] = {}
    for i, k, lo, hi in zip(ids_a.tolist(), ids_b.tolist(), *_spans(times[:n]).T.tolist(), strict=True):
        spans.setdefault((i, k), []).append((lo, hi))
    pairs = sorted(spans.items(), key=lambda item: (-max(hi - lo for lo, hi in item[1]), item[0]))
    return [tuple(c) for c in cover[: int(integers[COVERS])].tolist()], pairs


def _joined(problem: Problem, known: list[Window], window: Window) -> list[Window]:
    """Windows of certain contact with one more; those that certainly share a time become one."""
    apart = []
    for other in known:
        try:
            if problem.order(window[0], other[1]) > 0 or problem.order(other[0], window[1]) > 0:
                apart.append(other)
                continue
            start = window[0] if problem.order(window[0], other[0]) <= 0 else other[0]
            window = start, window[1] if problem.order(window[1], other[1]) >= 0 else other[1]
        except Undecidable:
            apart.append(other)
    return [*apart, window]


def _is_within(problem: Problem, span: tuple[float, float], known: list[Window]) -> bool:
    """Whether times, as far as they are of the piece, certainly lie within one of the windows."""
    first, last = problem.float_window(max(span[0], 0.0), min(span[1], problem.window()[0]))
    for start, end in known:
        try:
            if problem.order(start, first) <= 0 and problem.order(last, end) <= 0:
                return True
        except Undecidable:
            continue
    return False


def _are_unsure(times: np.ndarray) -> np.ndarray:
    """Of which rows of `collect` doubles do not tell whether the pair meets; they end with the meeting of its boxes."""
    unsure: np.ndarray = np.isinf(times[:, 0])
    return unsure


def _spans(times: np.ndarray) -> np.ndarray:
    """(n, 2): of rows of `collect`, the times outside of which there is nothing of each."""
    return np.column_stack([np.where(_are_unsure(times), times[:, 2], times[:, 0]), times[:, 3]])


def _drop_covered(
    integers: np.ndarray, cover: np.ndarray, times: np.ndarray, parts: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Forget windows strictly inside the cover; keep room for as many again."""
    n = int(integers[FOUND])
    lo, hi = _spans(times[:n]).T
    inside = np.zeros(n, bool)
    for c0, c1 in cover[: int(integers[COVERS])]:
        inside |= (c0 < lo) & (hi < c1)
    keep = np.flatnonzero(~inside)
    size = max(4096, 2 * len(keep))
    new_times, new_parts = np.empty((size, 4)), np.empty((size, 2), np.int32)
    new_times[: len(keep)], new_parts[: len(keep)] = times[keep], parts[keep]
    integers[FOUND] = len(keep)
    return new_times, new_parts


def _union(items: list[Window], problem: Problem) -> list[Window]:
    """The union of closed windows as disjoint windows, ascending; windows that touch become one."""

    def by_start(x: Window, y: Window) -> int:
        return problem.order(x[0], y[0])

    items = sorted(items, key=cmp_to_key(by_start))
    out: list[Window] = []
    for start, end in items:
        if out and problem.order(start, out[-1][1]) <= 0:
            if problem.order(end, out[-1][1]) > 0:
                out[-1] = out[-1][0], end
        else:
            out.append((start, end))
    return out


def _with_containment(
    problem: Problem, windows: list[Window], open_from: fmpq | None
) -> tuple[list[Window], float | None]:
    """(the disjoint windows and those gaps between them in which a body lies inside the other, before what is open;
    the start of the first gap of which that is not told, before which these are, or None).

    The surfaces share no point in a gap, so one time in it decides the whole gap.
    """
    begin = problem.start_instant()
    end: Any = problem.end_instant() if open_from is None else RationalInstant(open_from)
    ends: list[tuple[Any, Any]] = [(None, begin), *windows, (end, None)]
    out: list[Window] = []
    for k, (before, after) in enumerate(pairwise(ends)):
        left, right = before[1], after[0]
        is_all = not windows and open_from is None
        try:
            inside = (is_all or _is_gap(problem, left, right)) and contained_at(problem, left, right)
        except Undecidable:
            return out, left.bounds()[0]
        if inside:  # from the end of what came before, which needs no comparison: it may be a ball
            out = [*out[:-1], (out[-1][0] if out else left, right)]
        if k < len(windows):  # whose end may be None: never
            out = [*out[:-1], (out[-1][0], after[1])] if inside else [*out, after]
    return out, None


def _is_gap(problem: Problem, left: Any, right: Any) -> bool:
    """Whether there are times between; of two that are not told apart one is an end that encloses them."""
    try:
        return problem.order(left, right) < 0
    except Undecidable:
        return False
