"""The state of one walk over two trees, in arrays that kernels fill and Python reads between slices."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np

from firstcontact.work import NoMemory, doubled, may_grow

# Kinds of candidate pairs: element of a, element of b.  In this order the lowest kind is reported.  NumPy integers,
# because Numba compiles a function anew for every Python integer written into a call.
VERTEX_FACE, EDGE_EDGE, FACE_VERTEX, EDGE_FACE, FACE_EDGE = (np.int64(k) for k in range(5))
# What stands for the side or corner where the element is the whole facet.
WHOLE = np.int64(0)

# Added to the kind of a candidate that needs no exact answer to count.
CERTAIN_KIND = 8

# Why a kernel came back.  BEYOND: the next step would take more than ALLOWED.
DONE, SLICE_SPENT, FULL, DECIDE, CROSSING_FOUND, BEYOND = range(6)
# Lists of a walk that cuts sets need more room.
CROWDED = -1

# Slots of the integer state.  LIFTED: 1 when the walk halves sets, 2 when it need not look at the start there; ARC,
# PHASE, QUERY: its place.  ALLOWED: visits and tests, of such a walk, whose steps are large; 0: any number.
HEAP, STACK, CANDIDATES, VISITS, TESTS, UNSURE_COUNT, UNSURE_TOTAL, LIFTED, ARC, PHASE, QUERY, ALLOWED = range(12)
# Slots of the float state: earliest time, the same certain, latest certain, best time so far, present key, and
# whether all contacts are wanted (then certain ones do not lower the best time).
FIRST, SURE_FIRST, SURE_LAST, BEST, KEY, ALL = range(6)

# A slice of work between two looks at the keyboard and the progress bar: about 0.1 s.
SLICE = 1_000_000
# The same of walks under curved motions, whose visits look at cells of time.
CURVED_SLICE = 20_000
# Undecided pairs that send the walk back for exact answers: few, because each may end the search.
UNSURE_BATCH = 16
# Room a leaf pair may need among the candidates: 9 edge/edge, 6 vertex/face, 6 edge/face.
LEAF_ROOM = 32


class WalkState:
    """Scratch arrays of a walk.  `keys`/`pairs`: heap; `stack`: pairs that overlap at the start."""

    __slots__ = ("floats", "integers", "keys", "pairs", "stack", "times", "candidates", "scratch")

    def __init__(self) -> None:
        self.keys = np.empty(4096)
        self.pairs = np.empty((4096, 2), np.int32)
        self.stack = np.empty((1024, 2), np.int32)
        self.times = np.empty((512, 2))
        self.candidates = np.empty((512, 5), np.int32)  # kind, part a, feature a, part b, feature b
        self.floats = np.zeros(6)
        self.integers = np.zeros(12, np.int64)
        self.scratch: Any = None  # of a walk that halves sets

    def start(
        self, first: float, sure_first: float, last: float, sure_last: float, want_all: bool = False
    ) -> None:
        """Ready for a new walk over [first, last]; contacts count as certain inside the sure window."""
        f, n = self.floats, self.integers
        f[FIRST], f[SURE_FIRST], f[SURE_LAST] = first, sure_first, sure_last
        f[BEST], f[KEY], f[ALL] = last, first, want_all
        n.fill(0)
        self.scratch = None
        n[STACK] = 1
        self.stack[0] = 0

    def grow(self) -> None:
        """Double every array that is close to full.  Raises NoMemory."""
        if not may_grow(self.keys, self.pairs, self.stack, self.times, self.candidates):
            raise NoMemory
        n = self.integers
        if n[HEAP] + 4 > len(self.keys):
            self.keys, self.pairs = doubled(self.keys, self.pairs)
        if n[STACK] + 4 > len(self.stack):
            (self.stack,) = doubled(self.stack)
        if n[CANDIDATES] + LEAF_ROOM > len(self.times):
            self.times, self.candidates = doubled(self.times, self.candidates)


def share_of(budget: int) -> int:
    """Visits after which to look at what is left of a budget again: to each may belong a dozen tests and more."""
    return max(1, budget // 16)


_local = threading.local()


def borrow_state() -> WalkState:
    """This thread's scratch, so that short queries allocate nothing."""
    state = getattr(_local, "state", None)
    _local.state = None
    return state or WalkState()


def return_state(state: WalkState) -> None:
    state.scratch = None
    if len(state.keys) <= 1 << 18:
        _local.state = state
