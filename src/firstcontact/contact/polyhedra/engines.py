"""Which engine a search asks.

Trees of boxes are best where bodies meet in few places; halving by lines, space and planes ("lifted") where everything
passes everything.

`auto` begins with boxes, in the order of their times, and goes on by halving once they have spent their pair tests,
with what they proved so far: nothing meets before the present key, and the best time.  How many they may spend depends
on how the bodies look (`tests_of_boxes`):

- The leaves of either tree are so large that a leaf meets many leaves of the other one wherever they lie: rods, combs,
  wide plates, long prisms.  Boxes would test nearly all pairs, unless facets are crossed at the start, which shows
  almost at once.
- One body is a set of points: there halving needs 10 to 20 tests a point, and boxes get TESTS_A_POINT; where all pairs
  are FEW_PAIRS at most, boxes need no more than that.
- Else, as on ordinary meshes, they may spend more than ordinary scenes ever do; and once all that is left is what meets
  at the best time itself, as bodies that meet flat do in many places, about as much as halving takes.

The plane sweep and the levels of `composed` are asked only by name, the latter also for lists of all pairs.
"""

from __future__ import annotations

import numpy as np

from firstcontact.body.kept import Kept
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.problems.by_trees import ByTrees
from firstcontact.search.trees.crowding import crowding
from firstcontact.search.trees.elements import Feature
from firstcontact.search.trees.state import (
    ALL,
    BEST,
    CANDIDATES,
    CROSSING_FOUND,
    DONE,
    HEAP,
    KEY,
    LIFTED,
    SLICE_SPENT,
    STACK,
    TESTS,
    VISITS,
    WalkState,
)
from firstcontact.search.trees.tree import FACET, POINT, Tree

# A leaf meets many others: this share of all leaves, and so many of them.
CROWDED_SHARE, CROWDED_LEAVES = 0.02, 32
# Pair tests of boxes in that case, per facet of the larger body and at most, and against a set of points, per point.
TESTS_AT_ONCE, MOST_AT_ONCE, TESTS_A_POINT, FEW_PAIRS = 1 / 256, 32, 1, 1 << 14
# Boxes make so many visits in any case: bodies that nowhere come near each other need no other engine.
FEW_VISITS = 4
# Pair tests that ordinary scenes stay below: per primitive of both bodies, and never fewer than FEWEST.
SHARE, FEWEST = 4, 4096
# The same where what is left to look at meets within this share of the best time before it: halving takes a primitive
# some 5 us, a pair test 0.1 us.
TIED_SHARE, TIED = 32, 2.0**-30
# Lists of all pairs change over at so many tests for each primitive and each pair listed so far; looked at every so
# many node visits.
LISTING_SHARE, LISTING_SLICE = 8, 16384
# Below this size products of coordinates, and errors beside them, leave the range of doubles.  Boxes and halving bear
# that.
LEAST_SIZE = 2.0**-450
_TESTS_OF_BOXES = Kept[tuple[Tree, Tree, int]]()


def tests_of_boxes(tree_a: Tree, tree_b: Tree) -> int:
    """Pair tests after which `auto` leaves the boxes."""
    m, n = len(tree_a.corners), len(tree_b.corners)
    leaves = min(len(tree_a.boxes), len(tree_b.boxes)) // 2 + 1
    if leaves >= CROWDED_LEAVES:
        share = crowding(tree_a.boxes, tree_a.links, tree_b.boxes, tree_b.links)
        if share >= CROWDED_SHARE and share * leaves >= CROWDED_LEAVES:
            facets = any(np.any(tree.ids[:, 1] & FACET) for tree in (tree_a, tree_b))
            return min(int(TESTS_AT_ONCE * max(m, n)), MOST_AT_ONCE) if facets else 0
    for tree, count in ((tree_a, m), (tree_b, n)):
        if tree.ids[0, 1] & POINT and m * n > FEW_PAIRS:  # then all its parts are points
            return TESTS_A_POINT * count
    return max(FEWEST, SHARE * (m + n))


class ByEngine(ByTrees):
    """A problem of translation or rotation that is searched by the engine it is given."""

    engine = "boxes"
    threads = 1
    listed = 0
    looks = 0
    most_looks: int | None = None
    a: Polyhedron
    b: Polyhedron

    def advance(self, state: WalkState, limit: int, with_start: bool, all_sides: bool) -> int:
        """Go on with the walk; the reason it came back.  What is pierced at the start is always found with boxes."""
        integers = state.integers
        if self.engine in ("composed", "sweep") and self._is_tiny():
            self.engine = "lifted"
        if self.engine == "boxes" or (state.floats[ALL] and not all_sides):
            return self.advance_boxes(state, limit, with_start, all_sides)
        if self.engine == "composed":
            return self._advance_composed(state, limit, with_start, all_sides)
        if self.engine == "sweep" and not all_sides:
            from firstcontact.contact.polyhedra.problems.sweep_problem import advance_sweep

            if not integers[LIFTED]:
                begin_lifted(state, with_start)
            return advance_sweep(self, state, limit)
        if all_sides:
            return self._list_pairs(state, limit, with_start)
        if self.engine == "auto" and not integers[LIFTED]:
            while (most := self._tests_by_now(state)) or integers[VISITS] < FEW_VISITS:
                left = most - int(integers[TESTS])
                # a visit may be 15 tests: short steps where tests are few
                step = max(FEW_VISITS, left if left >= FEWEST // 2 else left // 8)
                slice_end = min(limit, int(integers[VISITS]) + step)
                reason = self.advance_boxes(state, slice_end, with_start, all_sides)
                spent = int(integers[TESTS])
                if reason in (DONE, CROSSING_FOUND) or spent <= most or spent <= self._tests_by_now(state):
                    if reason != SLICE_SPENT or integers[VISITS] >= limit:
                        return reason
                    continue
                # boxes look at pairs that overlap at the start first: once none is left there, the start is settled
                with_start = with_start and integers[STACK] > 0
                begin_lifted(state, with_start)
                return reason
        if not integers[LIFTED]:
            begin_lifted(state, with_start)
        from firstcontact.contact.polyhedra.problems.lifted_problem import advance_lifted

        return advance_lifted(self, state, limit)

    def _tests_by_now(self, state: WalkState) -> int:
        """Pair tests after which `auto` leaves the boxes, as far as the walk has come."""
        most, floats = self.most_tests(), state.floats
        if state.integers[TESTS] > most >= FEWEST and floats[KEY] >= (1.0 - TIED) * floats[BEST]:
            return max(most, TIED_SHARE * (len(self.tree_a.corners) + len(self.tree_b.corners)))
        return most

    def _is_tiny(self) -> bool:
        """Whether the bodies are, and what lies between them."""
        return all(float(np.abs(tree.boxes[0]).max()) < LEAST_SIZE for tree in (self.tree_a, self.tree_b))

    def most_tests(self) -> int:
        """`tests_of_boxes`, kept on body a while the trees stay the same."""
        trees = self.tree_a, self.tree_b
        known = _TESTS_OF_BOXES.get(self.a)
        if known is None or known[0] is not trees[0] or known[1] is not trees[1]:
            known = _TESTS_OF_BOXES.put(self.a, (*trees, tests_of_boxes(*trees)))
        return known[2]

    def _advance_composed(self, state: WalkState, limit: int, with_start: bool, all_sides: bool) -> int:
        from firstcontact.contact.polyhedra.problems.composed_problem import advance_composed

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
        if reason != DONE and integers[TESTS] > max(FEWEST, most) and not self._is_tiny():
            begin_lifted(state, with_start and integers[STACK] > 0)
        return reason

    def answered(self, state: WalkState) -> str:
        """The engine that answered."""
        if not state.integers[LIFTED]:
            return "boxes"
        if self.engine == "auto":
            return "composed" if state.floats[ALL] else "lifted"
        return self.engine

    def meets_by(self, element_a: Feature, element_b: Feature, after: float) -> float | None:
        """A time soon after that one by which the bodies certainly share a point: none is sought, pairs are exact."""
        return None

def begin_lifted(state: WalkState, with_start: bool) -> None:
    """Ready for `lifted_walk`, which finds its place in zeros."""
    integers = state.integers
    integers[LIFTED] = 1 if with_start else 2
    integers[HEAP] = 0
    integers[STACK] = 1
    state.stack[0] = 0
