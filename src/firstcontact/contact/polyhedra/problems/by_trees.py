"""Walks over the trees of two polyhedra, of which kernels choose what they do by the type of the motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import arb

from firstcontact.exact.numbers import exact_value
from firstcontact.exact.times.instants import RationalInstant
from firstcontact.search.trees.state import WalkState
from firstcontact.search.trees.tree import Tree
from firstcontact.search.trees.walk import walk
from firstcontact.search.trees.windows import collect

if TYPE_CHECKING:
    from firstcontact.contact.polyhedra.earliest import Pair


class ByTrees:
    """A problem that is asked by walks.

    boxes_a, boxes_b: those of the trees, or others that suit the motion.  motion: as `search.trees.walk` has it.
    error_a, error_b: what coordinates of parts are off by.  pad: what those of two boxes together are, on all the way.
    """

    tree_a: Tree
    tree_b: Tree
    boxes_a: np.ndarray
    boxes_b: np.ndarray
    motion: np.ndarray
    error_a: float
    error_b: float
    pad: float

    def window(self) -> tuple[float, float]:
        """(last, sure last): outward and inward doubles around the end of the window."""
        raise NotImplementedError

    def between(self, lo: float, hi: float) -> Any:
        """Some instant of the local clock between two; None where there are none but exact ones."""
        return RationalInstant(arb(exact_value(lo)).union(arb(exact_value(hi))))

    def tied_with(self, pair: Pair, instant: Any, others: Sequence[Pair]) -> Sequence[Pair]:
        """Of pairs that floats have proved to meet, once, some that meet at the very instant of the pair."""
        return ()

    def apart(self, rows: np.ndarray) -> np.ndarray:
        """(n,) bools: True proves that the elements of a candidate share no point, of an edge and a face at the start.
        """
        return np.zeros(len(rows), bool)

    def advance_boxes(self, state: WalkState, limit: int, with_start: bool, all_sides: bool) -> int:
        """Go on with the walk over trees of boxes; the reason it came back."""
        a, b = self.tree_a, self.tree_b
        reason: int = walk(
            self.boxes_a, a.links, a.xyz, a.ids, self.boxes_b, b.links, b.xyz, b.ids,
            self.motion, self.error_a, self.error_b, self.pad, with_start, all_sides, limit,
            state.floats, state.integers, state.keys, state.pairs, state.stack, state.times, state.candidates,
        )  # fmt: skip
        return reason

    def collect(
        self, limit: int, integers: np.ndarray, stack: np.ndarray, cover: np.ndarray, times: np.ndarray,
        parts: np.ndarray,
    ) -> int:  # fmt: skip
        """Go on collecting windows (`windows.collect`)."""
        a, b = self.tree_a, self.tree_b
        reason: int = collect(
            self.boxes_a, a.links, a.xyz, a.ids, self.boxes_b, b.links, b.xyz, b.ids, self.motion,
            self.error_a, self.error_b, self.pad, self.window()[0], limit, integers, stack, cover, times, parts,
        )  # fmt: skip
        return reason
