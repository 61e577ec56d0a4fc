"""Which engine a search asks.

Trees of boxes are best where bodies meet in few places; halving by lines and planes ("lifted") where everything passes
everything closely.  Cells of space and time are asked only by name.

`auto` begins with boxes, in the order of their times, and goes on by halving once they have spent their pair tests,
with what they proved so far: nothing meets before the present key, and the best time.  How many they may spend depends
on how the bodies look (`tests_of_boxes`):

- The leaves of either tree are so large that a leaf meets many leaves of the other one wherever they lie: rods, combs,
  wide plates, long prisms.  Boxes would test nearly all pairs, unless they are done almost at once.
- One body is a set of points: there halving needs 10 to 20 tests a point, and boxes get TESTS_A_POINT.
- Else, as on ordinary meshes, they may spend more than ordinary scenes ever do.
"""

from __future__ import annotations

from typing import Any

from firstcontact.search.crowding import crowding
from firstcontact.search.state import (
    ALL,
    CROSSING_FOUND,
    DONE,
    HEAP,
    LIFTED,
    SLICE_SPENT,
    STACK,
    TESTS,
    VISITS,
    WalkState,
)
from firstcontact.search.tree import POINT, Tree

# A leaf meets many others: this share of all leaves, and so many of them.
CROWDED_SHARE, CROWDED_LEAVES = 0.02, 32
# Pair tests of boxes in that case, per primitive of the larger body, and against a set of points, per point.
TESTS_AT_ONCE, TESTS_A_POINT = 1 / 64, 1
# Pair tests that ordinary scenes stay below: per primitive of both bodies, and never fewer than FEWEST.
SHARE, FEWEST = 4, 4096


def tests_of_boxes(tree_a: Tree, tree_b: Tree) -> int:
    """Pair tests after which `auto` leaves the boxes."""
    m, n = len(tree_a.corners), len(tree_b.corners)
    leaves = min(len(tree_a.boxes), len(tree_b.boxes)) // 2 + 1
    if leaves >= CROWDED_LEAVES:
        share = crowding(tree_a.boxes, tree_a.links, tree_b.boxes, tree_b.links)
        if share >= CROWDED_SHARE and share * leaves >= CROWDED_LEAVES:
            return int(TESTS_AT_ONCE * max(m, n))
    for tree, count in ((tree_a, m), (tree_b, n)):
        if tree.ids[0, 1] & POINT:  # then all its parts are points
            return TESTS_A_POINT * count
    return max(FEWEST, SHARE * (m + n))


class ByEngine:
    """A problem of translation or rotation that is searched by the engine it is given."""

    engine = "boxes"
    tree_a: Tree
    tree_b: Tree

    def advance(self, state: WalkState, limit: int, with_start: bool, all_sides: bool) -> int:
        """Go on with the walk; the reason it came back.  Lists of all pairs are always made with boxes."""
        integers = state.integers
        if self.engine == "boxes" or all_sides or state.floats[ALL]:
            return self.advance_boxes(state, limit, with_start, all_sides)
        if self.engine == "cells":
            from firstcontact.search.cell_problem import advance_cells

            integers[LIFTED] = 3
            return advance_cells(self, state, limit, with_start)
        if self.engine == "auto" and not integers[LIFTED]:
            most = tests_of_boxes(self.tree_a, self.tree_b)
            while True:
                left = most - int(integers[TESTS])
                # a visit may be 15 tests: short steps where tests are few
                slice_end = min(limit, int(integers[VISITS]) + max(4, left if left >= FEWEST // 2 else left // 8))
                reason = self.advance_boxes(state, slice_end, with_start, all_sides)
                if reason in (DONE, CROSSING_FOUND) or integers[TESTS] <= most:
                    if reason != SLICE_SPENT or integers[VISITS] >= limit:
                        return reason
                    continue
                # boxes look at pairs that overlap at the start first: once none is left there, the start is settled
                with_start = with_start and integers[STACK] > 0
                begin_lifted(state, with_start)
                return reason
        if not integers[LIFTED]:
            begin_lifted(state, with_start)
        from firstcontact.search.lifted_problem import advance_lifted

        return advance_lifted(self, state, limit)

    def meets_by(self, element_a: Any, element_b: Any, after: float) -> float | None:
        """A time soon after that one by which the bodies certainly share a point: none is sought, pairs are exact."""
        return None

    def advance_boxes(self, state: WalkState, limit: int, with_start: bool, all_sides: bool) -> int:
        raise NotImplementedError


def begin_lifted(state: WalkState, with_start: bool) -> None:
    """Ready for `lifted_walk`, which finds its place in zeros."""
    integers = state.integers
    integers[LIFTED] = 1 if with_start else 2
    integers[HEAP] = 0
    integers[STACK] = 1
    state.stack[0] = 0
