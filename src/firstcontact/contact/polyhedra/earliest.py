"""The earliest contact of one piece of motion: the float walk, its undecided pairs, the exact winner."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

from firstcontact.contact.polyhedra.engines import ByEngine
from firstcontact.contact.polyhedra.planar import BeginsNothing
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import PRECISIONS, Undecidable, precision
from firstcontact.exact.times.instants import Instant
from firstcontact.search.trees.elements import KINDS, Feature, feature
from firstcontact.search.trees.state import (
    ALL,
    ALLOWED,
    BEST,
    BEYOND,
    CANDIDATES,
    CERTAIN_KIND,
    CROSSING_FOUND,
    DECIDE,
    DONE,
    EDGE_FACE,
    FULL,
    KEY,
    SLICE,
    SLICE_SPENT,
    TESTS,
    UNSURE_COUNT,
    UNSURE_TOTAL,
    VISITS,
    WalkState,
    borrow_state,
    return_state,
    share_of,
)
from firstcontact.work import WORTH, NoMemory, Progress, Spent

if TYPE_CHECKING:
    import numpy as np

    from firstcontact.body.polyhedron.polyhedron import Polyhedron
    from firstcontact.exact.rigid import Matrix
    from firstcontact.exact.vectors import Vector
    from firstcontact.motion.relative.curved import CurvedPiece
    from firstcontact.motion.relative.pieces import MotionPiece
    from firstcontact.result import ExactTime
    from firstcontact.search.trees.touch import Touch
    from firstcontact.search.trees.tree import Tree

# A contact in doubt need not be decided where the bodies certainly meet within this share of the window after it.
SOON = 2.0**-40
# Candidates from which on doubles are asked which of them are apart.
MANY = 64
# Certain pairs from which on it is worth asking which of them are told together.
SEVERAL = 8

# A pair of elements in contact: kind (see `state`), element of a, element of b.
Pair = tuple[int, Feature, Feature]


# A closed time of contact; the end None: never.
Window = tuple[Instant, Instant | None]
# The same, each end with the number of full turns before it.
Repeated = tuple[Instant, int, Instant | None, int]


class Problem(Protocol):
    """One piece of relative motion, as the search sees it.  Its methods take instants of the kind that it gives."""

    a: Polyhedron
    b: Polyhedron
    tree_a: Tree
    tree_b: Tree
    is_exact: bool
    looks: int
    """Stretches of time looked at in balls, each worth `work.WORTH` visits."""
    most_looks: int | None
    """After how many of them Spent is raised."""

    @property
    def piece(self) -> MotionPiece | CurvedPiece: ...
    @property
    def begin(self) -> tuple[float, float]: ...
    def window(self) -> tuple[float, float]: ...

    # the first contact
    def advance(self, state: WalkState, limit: int, with_start: bool, all_sides: bool) -> int: ...
    def apart(self, rows: np.ndarray) -> np.ndarray: ...
    def contact(self, element_a: Feature, element_b: Feature) -> Instant | None: ...
    def contact_within(self, element_a: Feature, element_b: Feature, lo: float, hi: float) -> Instant | None: ...
    def between(self, lo: float, hi: float) -> Any: ...
    def tied_with(self, pair: Pair, instant: Any, others: Sequence[Pair]) -> Sequence[Pair]: ...
    def meets_by(self, element_a: Feature, element_b: Feature, after: float) -> float | None: ...

    # all windows
    def collect(
        self, limit: int, integers: np.ndarray, stack: np.ndarray, cover: np.ndarray, times: np.ndarray,
        parts: np.ndarray,
    ) -> int: ...  # fmt: skip
    def windows_of(self, primitive_a: int, primitive_b: int) -> Sequence[Window]: ...
    def float_window(self, lo: float, hi: float) -> Window: ...
    def repeated(self, windows: list[Any]) -> Iterable[Repeated]: ...

    # instants
    def start_instant(self) -> Instant: ...
    def end_instant(self) -> Instant | None: ...
    def order(self, x: Any, y: Any) -> int: ...
    def pose_between(self, x: Any, y: Any) -> Matrix: ...
    def is_end(self, at: Any, turn: int) -> bool: ...
    def touch(self, element_a: Feature, element_b: Feature, at: Any) -> Touch: ...

    # the motions' clock
    def world_instant(self, at: Any, turn: int = 0) -> tuple[float, tuple[float, float]]: ...
    def world_exact(self, at: Any, turn: int = 0) -> ExactTime | None: ...
    def world_time(self, local: float) -> float: ...


class Searched(Problem, Protocol):
    """A problem that is asked about its start too, and what it leaves in doubt.

    Those of curved motion are not: their start is that of another problem.
    """

    def possible(self, element_a: Feature, element_b: Feature) -> float: ...
    def start_relation(self, element_a: Feature, element_b: Feature) -> int: ...
    def start_point(self, element_a: Feature, element_b: Feature) -> Vector: ...
    def is_contained(self) -> bool: ...


@dataclass(slots=True)
class FoundFirst:
    """What a search proved.

    instant   exact time of the first contact, None when there is none
    pairs     the pairs that realise it, lowest first
    start     pairs (edge, facet) that share a point at the start: (pair, crossing) - then no events were sought
    doubtful  pairs that no precision decides
    open      None, or "budget" / "precision" / "memory": what stopped the search; free_until (local) is proved
    """

    instant: Instant | None = None
    pairs: list[Pair] = field(default_factory=list)
    start: list[tuple[Pair, bool]] = field(default_factory=list)
    doubtful: list[Pair] = field(default_factory=list)
    open: str | None = None
    free_until: float = 0.0
    visits: int = 0
    tests: int = 0
    unsure: int = 0
    exact: int = 0
    looks: int = 0
    engine: str = "boxes"

    @property
    def work(self) -> int:
        return self.visits + self.tests + WORTH * self.looks


def earliest(
    problem: Searched, budget: int | None = None, progress: Progress | None = None, with_start: bool = True
) -> FoundFirst:
    """The first contact of the piece, proved.

    The float walk returns pairs that certainly meet and pairs it cannot decide.  Every undecided pair that could
    still be first is decided exactly; at the end the certain ones are recomputed exactly too, in the order of
    their lower bounds, until the next bound lies behind the best exact time.
    """
    state = borrow_state()
    found = FoundFirst()
    try:
        _Search(problem, state, found, budget, progress).run(with_start)
    finally:
        found.visits += int(state.integers[VISITS])
        found.tests += int(state.integers[TESTS])
        found.looks, problem.most_looks = problem.looks, None
        found.unsure += int(state.integers[UNSURE_TOTAL])
        found.engine = engine_of(problem, state)
        return_state(state)
    return found


def all_pairs(problem: Searched, with_start: bool = True) -> FoundFirst:
    """`pairs`: every vertex/face, edge/edge and face/vertex pair that meets in the piece; `start`: edges through

    faces at its start.  Undecided pairs are decided exactly.
    """
    state = borrow_state()
    found = FoundFirst()
    try:
        search = _Search(problem, state, found, None, None)
        last, sure_last = problem.window()
        state.start(*problem.begin, last, sure_last, want_all=True)
        search.stop_at_start = False
        if not search.walk(with_start, all_sides=True):
            raise UnsupportedPair("a list of all pairs that meet needs more than 2 GB; ask about a shorter span")
        met = [pair for pair, instant in search.decided.items() if instant is not None]
        found.pairs = sorted({*met, *(search._pair(row) for _, _, row in search.waiting)})
        found.doubtful = sorted(search.doubtful)
    finally:
        found.visits, found.tests = int(state.integers[VISITS]), int(state.integers[TESTS])
        found.engine = engine_of(problem, state)
        return_state(state)
    return found


def pairs_at_start(problem: Searched) -> list[tuple[Pair, bool]]:
    """All (edge, facet) pairs that share a point at the start of the piece, and whether they cross."""
    state = borrow_state()
    try:
        search = _Search(problem, state, FoundFirst(), None, None)
        state.start(0.0, float("inf"), 0.0, float("-inf"), want_all=True)
        search.stop_at_start = False
        if not search.walk(with_start=True, all_sides=False) or search.doubtful:
            raise Undecidable
        return search.found.start
    finally:
        return_state(state)


def engine_of(problem: Problem, state: WalkState) -> str:
    """The engine that answered."""
    return problem.answered(state) if isinstance(problem, ByEngine) else "boxes"


class _Search:
    def __init__(
        self, problem: Searched, state: WalkState, found: FoundFirst, budget: int | None, progress: Progress | None
    ) -> None:
        self.problem, self.state, self.found = problem, state, found
        self.budget, self.progress = budget, progress
        self.waiting: list[tuple[float, float, list[int]]] = []  # candidates the floats are sure of: lo, hi, row
        self.decided: dict[Pair, Instant | None] = {}  # exact times
        self.doubtful: dict[Pair, float] = {}  # pairs no precision decides, with their lower bounds
        self.stop_at_start = True
        self.best: Instant | None = None
        """The earliest exact time so far, and the pairs that realise it."""
        self.tied: list[Pair] = []
        self.met_by = float("inf")
        """A time by which the bodies certainly meet, if not in which elements."""

    def run(self, with_start: bool) -> None:
        last, sure_last = self.problem.window()
        self.state.start(*self.problem.begin, last, sure_last)
        if not self.walk(with_start, all_sides=False):
            return
        try:
            self._settle_waiting()
        except Spent:
            self._stopped("budget")
            return
        if self.found.start:
            return
        self._conclude()

    # -- the walk -------------------------------------------------------------------------------------------

    def walk(self, with_start: bool, all_sides: bool) -> bool:
        """Walk to the end, answering what the floats ask; False when the budget, or memory, ended it."""
        state, integers = self.state, self.state.integers
        while True:
            limit = int(integers[VISITS]) + SLICE
            if self.budget is not None:
                limit = min(limit, int(integers[VISITS]) + share_of(self.budget - self._work()))
                integers[ALLOWED] = max(1, self.budget - WORTH * self.problem.looks)
            try:
                reason = self.problem.advance(state, limit, with_start, all_sides)
                self._collect()
                if reason in (DONE, CROSSING_FOUND) or (self.found.start and self.stop_at_start):
                    return True
                if reason == FULL:
                    state.grow()
            except NoMemory:
                return self._stopped("memory")
            except Spent:
                return self._stopped("budget")
            if reason == BEYOND:
                return self._stopped("budget")
            if reason not in (DECIDE, FULL):
                assert reason == SLICE_SPENT
                if self.progress is not None:
                    self.progress(float(state.floats[KEY]), self._work())
                if self.budget is not None and self._work() >= self.budget:
                    return self._stopped("budget")

    def _work(self) -> int:
        return int(self.state.integers[VISITS] + self.state.integers[TESTS]) + WORTH * self.problem.looks

    def _stopped(self, reason: str) -> bool:
        self.found.open, self.found.free_until = reason, self._proved_free()
        return False

    def _proved_free(self) -> float:
        """No contact before this: neither among the nodes that wait nor among the pairs that may or do meet."""
        bounds = [float(self.state.floats[KEY]), *(lo for lo, _, _ in self.waiting), *self.doubtful.values()]
        return min(bounds if self.best is None else [*bounds, self.best.bounds()[0]])

    def _collect(self) -> None:
        """Take the candidates over; decide the unsure ones now, they may end the walk."""
        integers = self.state.integers
        n = int(integers[CANDIDATES])
        if n == 0:
            return
        times = self.state.times[:n].tolist()
        rows = self.state.candidates[:n].tolist()
        apart = self.problem.apart(self.state.candidates[:n]).tolist() if n >= MANY else [False] * n
        integers[CANDIDATES] = 0
        integers[UNSURE_COUNT] = 0
        best = float(self.state.floats[BEST])
        unsure = []
        for (lo, hi), row, is_apart in zip(times, rows, apart, strict=True):
            if lo > best or is_apart:
                continue
            if row[0] >= CERTAIN_KIND:
                if row[0] >= CERTAIN_KIND + EDGE_FACE:
                    self._decide_start(self._pair(row), certain=True)
                else:
                    self.waiting.append((lo, hi, row))
            elif row[0] >= EDGE_FACE:
                self._decide_start(self._pair(row), certain=False)
            elif (pair := self._pair(row)) not in self.decided:
                unsure.append((lo, pair))
        unsure.sort()
        for k, (lo, pair) in enumerate(unsure):
            if lo <= self.state.floats[BEST]:
                try:
                    self._decide(pair, lo)
                except Spent:
                    self.doubtful.update((left, bound) for bound, left in unsure[k:])
                    raise

    def _pair(self, row: list[int]) -> Pair:
        kind, part_a, local_a, part_b, local_b = row
        kind %= CERTAIN_KIND
        kind_a, kind_b = KINDS[kind]
        return (
            kind,
            feature(self.problem.tree_a, kind_a, part_a, local_a),
            feature(self.problem.tree_b, kind_b, part_b, local_b),
        )

    def _decide_start(self, pair: Pair, certain: bool) -> None:
        if certain:
            self.found.start.append((pair, True))
            return
        self.found.exact += 1
        relation = self._exactly(lambda: self.problem.start_relation(pair[1], pair[2]))
        if relation is None:
            self.doubtful[pair] = 0.0
        elif relation:
            self.found.start.append((pair, relation == 2))

    def _decide(self, pair: Pair, lo: float, sure_until: float | None = None) -> None:
        """The exact time of the pair; a contact shortens the walk.  sure_until: it is certainly in [lo, sure_until]."""
        if pair in self.decided or pair in self.doubtful:  # boxes of a wide element ask more than once
            return
        self.found.exact += 1
        answer = self._contact_and_bound(pair, lo, sure_until)
        if answer is None:
            return
        instant, hi = answer
        self.decided[pair] = instant
        if instant is not None:
            floats = self.state.floats
            if floats[ALL] == 0.0:
                floats[BEST] = min(floats[BEST], hi)
            order = -1 if self.best is None else self._order(instant, self.best)
            if order < 0:
                self.best, self.tied = instant, [pair]
            elif order == 0:
                self.tied.append(pair)

    def _contact_and_bound(
        self, pair: Pair, lo: float, sure_until: float | None
    ) -> tuple[Instant | None, float] | None:
        """The exact time of the pair and a double not before it; None where it is left in doubt.

        That is so when no precision decides it, and when the bodies certainly meet so soon after that it need not be.
        """
        _, x, y = pair
        problem = self.problem
        if self.budget is not None:
            visits = int(self.state.integers[VISITS] + self.state.integers[TESTS])
            problem.most_looks = max(self.budget - visits, 0) // WORTH
        for bits in PRECISIONS:
            with precision(bits):
                try:
                    instant = (
                        problem.contact(x, y) if sure_until is None else problem.contact_within(x, y, lo, sure_until)
                    )
                    return instant, 0.0 if instant is None else instant.bounds()[1]
                except BeginsNothing:
                    if self.state.floats[ALL] == 0.0:
                        return None, 0.0
                    possible = lo
                    break
                except Undecidable:
                    possible = max(lo, problem.possible(x, y))
            if bits > PRECISIONS[0] and self._is_met_soon(pair, possible):
                break
        self.doubtful[pair] = possible
        return None

    def _is_met_soon(self, pair: Pair, possible: float) -> bool:
        """Whether the bodies certainly meet so soon after a possible contact of a pair that they are not told apart."""
        floats = self.state.floats
        if floats[ALL] != 0.0:
            return False
        if not self._is_soon(possible):
            until = self.problem.meets_by(pair[1], pair[2], possible)
            if until is None:
                return False
            self.met_by = min(self.met_by, until)
            floats[BEST] = min(floats[BEST], until)
        return self._is_soon(possible)

    def _is_soon(self, after: float) -> bool:
        return after <= self.met_by <= after + SOON * self.problem.window()[0]

    def _exactly(self, question: Callable[[], int]) -> int | None:
        """The answer of the exact face, at rising precision where it is in balls; None when none decides."""
        for bits in PRECISIONS:
            with precision(bits):
                try:
                    return question()
                except Undecidable:
                    continue
        return None

    def _order(self, x: Instant, y: Instant) -> int:
        """-1, 0, 1: x before, at, after y; 0 also where no ball tells them apart."""
        for bits in PRECISIONS:
            with precision(bits):
                try:
                    return x.compare(y)
                except Undecidable:
                    continue
        return 0

    # -- the end --------------------------------------------------------------------------------------------

    def _settle_waiting(self) -> None:
        """Exact times of the certain pairs, until the next lower bound lies behind the best."""
        waiting = sorted(self.waiting)
        if len(waiting) > SEVERAL:
            waiting = self._without_tied(waiting)
        for lo, hi, row in waiting:
            if lo > self.state.floats[BEST]:
                break
            self._decide(self._pair(row), lo, hi)
        self.waiting.clear()

    def _without_tied(self, waiting: list[tuple[float, float, list[int]]]) -> list[tuple[float, float, list[int]]]:
        """Decides the first two, and where they tie what is told to meet at the very same time too; what is left."""
        firsts = []
        for lo, hi, row in waiting[:2]:
            if lo > self.state.floats[BEST]:
                return []
            firsts.append(self._pair(row))
            self._decide(firsts[-1], lo, hi)
        best = self.state.floats[BEST]
        left = [x for x in waiting[2:] if x[0] <= best]
        instant, second = map(self.decided.get, firsts)
        if len(left) < SEVERAL or instant is None or second is None or self._order(instant, second) != 0:
            return left
        pairs = [self._pair(row) for _, _, row in left]
        tied = set(self.problem.tied_with(firsts[0], instant, pairs)).difference(self.decided)
        self.decided.update(dict.fromkeys(tied, instant))
        self.found.exact += len(tied)
        if self.best is not None and self._order(instant, self.best) == 0:
            self.tied += tied
        return [x for x, pair in zip(left, pairs, strict=True) if pair not in self.decided]

    def _conclude(self) -> None:
        found = self.found
        horizon = float(self.state.floats[BEST])
        open_until = min(self.doubtful.values(), default=float("inf"))
        # a contact certain to be no later than any doubtful one is the first, whatever becomes of those
        if self.doubtful and open_until <= horizon and not (self.best and self.best.bounds()[0] <= open_until):
            found.free_until = open_until
            if self.best is not None:
                self.met_by = min(self.met_by, self.best.bounds()[1])
            found.instant = self.problem.between(open_until, self.met_by) if self._is_soon(open_until) else None
            if found.instant is None:
                found.open = "precision"
                return
            near = [pair for pair, possible in self.doubtful.items() if possible <= self.met_by]
            found.pairs = sorted({*near, *self.tied})
            return
        found.free_until = horizon
        if self.best is None:
            return
        found.instant = self.best
        found.pairs = sorted(self.tied)
