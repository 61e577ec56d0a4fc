"""Which engine a search asks.

Trees of boxes are best where bodies meet in few places; lifted trees where everything passes everything closely; cells
of space and time where long parts cross in general position.

`auto` begins with boxes.  Once they have spent more pair tests than lifted trees are likely to need in all, it goes on
with those, with what the boxes have proved so far: nothing meets before the present key, and the best time.  Cells are
asked only by name.
"""

from __future__ import annotations

from typing import Any

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

# Pair tests after which `auto` changes over: a share of the primitives of both bodies, and never fewer than FEWEST.
# Ordinary meshes stay below.  Where everything passes everything the boxes' tests come on top of those of the lifted
# trees, which may need far fewer (a tenth on layers of 30,000 edges), but take less time than building such trees does.
SHARE, FEWEST = 0.6, 4096


class ByEngine:
    """A problem of translation or rotation that is searched by the engine it is given."""

    engine = "boxes"
    threads = 1
    tree_a: Any
    tree_b: Any

    def advance(self, state: WalkState, limit: int, with_start: bool, all_sides: bool) -> int:
        """Go on with the walk; the reason it came back.  Lists of all pairs are always made with boxes."""
        integers = state.integers
        if self.engine == "composed" and not all_sides and not state.floats[ALL]:
            from firstcontact.search.composed_problem import advance_composed

            if not integers[LIFTED]:
                begin_lifted(state, with_start)
            return advance_composed(self, state, limit)
        if self.engine == "boxes" or all_sides or state.floats[ALL]:
            return self.advance_boxes(state, limit, with_start, all_sides)
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

    def answered(self, state: WalkState) -> str:
        """The engine that answered."""
        if not state.integers[LIFTED]:
            return "boxes"
        return "lifted" if self.engine == "auto" else self.engine

    def advance_boxes(self, state: WalkState, limit: int, with_start: bool, all_sides: bool) -> int:
        raise NotImplementedError


def begin_lifted(state: WalkState, with_start: bool) -> None:
    """Ready for `lifted_walk`, which finds its place in zeros but for one root on the stack."""
    integers = state.integers
    integers[LIFTED] = 1 if with_start else 2
    integers[HEAP] = 0
    integers[STACK] = 1
    state.stack[0] = 0
