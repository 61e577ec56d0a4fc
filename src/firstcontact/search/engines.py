"""Which engine a search asks.

Trees of boxes are best where bodies meet in few places; lifted trees where everything passes everything closely; cells
of space and time where long parts cross in general position.

`auto` begins with boxes.  Once they have spent more pair tests than lifted trees are likely to need in all, it goes on
with those, with what the boxes have proved so far: nothing meets before the present key, and the best time.  Cells, the
plane sweep and the levels of `composed` are asked only by name, the latter also for lists of all pairs.
"""

from __future__ import annotations

from typing import Any

from firstcontact.search.state import (
    ALL,
    CANDIDATES,
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

# Pair tests after which `auto` changes over: a share of the primitives of both bodies, and never fewer than FEWEST.
# Ordinary meshes stay below.  Where everything passes everything the boxes' tests come on top of those of the lifted
# trees, which may need far fewer (a tenth on layers of 30,000 edges), but take less time than building such trees does.
SHARE, FEWEST = 0.6, 4096
# Lists of all pairs change over at so many tests for each primitive and each pair listed so far; looked at every so
# many node visits.
LISTING_SHARE, LISTING_SLICE = 8, 16384


class ByEngine:
    """A problem of translation or rotation that is searched by the engine it is given."""

    engine = "boxes"
    threads = 1
    listed = 0
    tree_a: Any
    tree_b: Any

    def advance(self, state: WalkState, limit: int, with_start: bool, all_sides: bool) -> int:
        """Go on with the walk; the reason it came back.  What is pierced at the start is always found with boxes."""
        integers = state.integers
        if self.engine == "boxes" or (state.floats[ALL] and not all_sides):
            return self.advance_boxes(state, limit, with_start, all_sides)
        if self.engine == "composed":
            return self._advance_composed(state, limit, with_start, all_sides)
        if self.engine == "sweep" and not all_sides:
            from firstcontact.search.sweep_problem import advance_sweep

            if not integers[LIFTED]:
                begin_lifted(state, with_start)
            return advance_sweep(self, state, limit)
        if all_sides:
            return self._list_pairs(state, limit, with_start)
        if self.engine == "cells":
            from firstcontact.search.cell_problem import advance_cells

            integers[LIFTED] = 3
            return advance_cells(self, state, limit, with_start)
        if self.engine == "auto" and not integers[LIFTED]:
            most = max(FEWEST, int(SHARE * (len(self.tree_a.corners) + len(self.tree_b.corners))))
            while True:
                slice_end = min(limit, int(integers[VISITS]) + max(256, most - int(integers[TESTS])))
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

    def _advance_composed(self, state: WalkState, limit: int, with_start: bool, all_sides: bool) -> int:
        from firstcontact.search.composed_problem import advance_composed

        if not state.integers[LIFTED]:
            begin_lifted(state, with_start)
        return advance_composed(self, state, limit, all_sides)

    def _list_pairs(self, state: WalkState, limit: int, with_start: bool) -> int:
        """All pairs that meet: with boxes as long as these test few pairs for each one that does, then by the levels of

        the linearisation, which report what is met without looking at all that is passed.
        """
        integers = state.integers
        if integers[LIFTED]:
            return self._advance_composed(state, limit, with_start, True)
        reason = self.advance_boxes(state, min(limit, int(integers[VISITS]) + LISTING_SLICE), with_start, True)
        self.listed += int(integers[CANDIDATES])
        most = LISTING_SHARE * (len(self.tree_a.corners) + len(self.tree_b.corners) + self.listed)
        if reason != DONE and integers[TESTS] > max(FEWEST, most):
            begin_lifted(state, with_start and integers[STACK] > 0)
        return reason

    def answered(self, state: WalkState) -> str:
        """The engine that answered."""
        if not state.integers[LIFTED]:
            return "boxes"
        if self.engine == "auto":
            return "composed" if state.floats[ALL] else "lifted"
        return self.engine

    def advance_boxes(self, state: WalkState, limit: int, with_start: bool, all_sides: bool) -> int:
        raise NotImplementedError


def begin_lifted(state: WalkState, with_start: bool) -> None:
    """Ready for `lifted_walk`, which finds its place in zeros but for one root on the stack."""
    integers = state.integers
    integers[LIFTED] = 1 if with_start else 2
    integers[HEAP] = 0
    integers[STACK] = 1
    state.stack[0] = 0
