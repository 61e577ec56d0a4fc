"""Rounds of a randomised search: what several workers found, each with a state of its own, comes together."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numpy as np

from firstcontact.search.trees.state import (
    BEST,
    CANDIDATES,
    LEAF_ROOM,
    TESTS,
    UNSURE_COUNT,
    UNSURE_TOTAL,
    VISITS,
    WalkState,
)
from firstcontact.work import doubled

T = TypeVar("T")


class Finds:
    """What one worker finds in a round: the arrays that kernels fill."""

    __slots__ = ("candidates", "floats", "integers", "times")

    def __init__(self, state: WalkState) -> None:
        self.floats, self.integers = state.floats.copy(), np.zeros_like(state.integers)
        self.times, self.candidates = np.empty((512, 2)), np.empty((512, 5), np.int32)

    def grow(self) -> None:
        """Room for twice as many candidates."""
        self.times, self.candidates = doubled(self.times, self.candidates)

    def hand_to(self, state: WalkState) -> None:
        """Add all to the state and lower its best time."""
        state.floats[BEST] = min(state.floats[BEST], self.floats[BEST])
        found, at = int(self.integers[CANDIDATES]), int(state.integers[CANDIDATES])
        while at + found + LEAF_ROOM > len(state.times):
            state.times, state.candidates = doubled(state.times, state.candidates)
        state.times[at : at + found] = self.times[:found]
        state.candidates[at : at + found] = self.candidates[:found]
        for slot in (CANDIDATES, VISITS, TESTS, UNSURE_COUNT, UNSURE_TOTAL):
            state.integers[slot] += self.integers[slot]
            self.integers[slot] = 0


def shared(work: Callable[[T], None], items: Iterable[T], threads: int) -> None:
    """work(item) of each item, by so many threads."""
    todo: Sequence[T] = list(items)
    if min(len(todo), threads) < 2:
        for item in todo:
            work(item)
        return
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(work, todo))
