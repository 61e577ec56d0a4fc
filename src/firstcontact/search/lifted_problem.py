"""Problems of translation and rotation whose walk asks lifted trees instead of trees of boxes (`lifted_walk`).

Everything else is the same: pair tests, exact answers, results.  Lists of all pairs stay with the boxes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from firstcontact.search.lifted_tree import Elements, LiftedTree, corners_of_tree, edges_of, facets_of, lifted_tree
from firstcontact.search.lifted_walk import lifted_walk
from firstcontact.search.rotation_problem import RotationProblem
from firstcontact.search.state import ALL, WalkState
from firstcontact.search.translation_problem import TranslationProblem
from firstcontact.search.tree import Tree


@dataclass(slots=True)
class Lifted:
    """What queries need of one body in one frame."""

    edges: Elements
    corners: Elements
    facet_tree: LiftedTree
    edge_tree: LiftedTree | None = None


class LiftedAdvance:
    """`advance` over lifted trees; the rest comes from the problem it is mixed into."""

    tree_a: Any
    tree_b: Any

    def advance(self, state: WalkState, limit: int, with_start: bool, all_sides: bool) -> int:
        if all_sides or state.floats[ALL]:
            return super().advance(state, limit, with_start, all_sides)  # type: ignore[misc]
        (a, b), (motion, reach, error_a, error_b) = self.lifted, self.asked()
        tree, facets_a, facets_b = b.edge_tree, a.facet_tree, b.facet_tree
        assert tree is not None
        return lifted_walk(
            tree.nodes, tree.links, tree.elements.parts, tree.origin, tree.scale,
            facets_a.nodes, facets_a.links, facets_a.elements.parts, facets_a.origin, facets_a.scale,
            facets_b.nodes, facets_b.links, facets_b.elements.parts, facets_b.origin, facets_b.scale,
            a.edges.corners, a.edges.parts, b.edges.corners, b.edges.parts,
            a.corners.corners, a.corners.parts, b.corners.corners, b.corners.parts,
            self.tree_a.xyz, self.tree_b.xyz, motion, reach, error_a, error_b, with_start, limit,
            state.floats, state.integers, state.stack, state.times, state.candidates,
        )  # fmt: skip

    def asked(self) -> tuple[Any, float, float, float]:
        """(motion, a time after which certainly nothing meets, errors of the parts of a and of b)."""
        raise NotImplementedError

    @cached_property
    def lifted(self) -> tuple[Lifted, Lifted]:
        a, b = lifted_of(self.a, self.tree_a), lifted_of(self.b, self.tree_b)  # type: ignore[attr-defined]
        if b.edge_tree is None:
            b.edge_tree = lifted_tree(self.tree_b, b.edges, facets=False)
        return a, b


class LiftedTranslation(LiftedAdvance, TranslationProblem):
    def asked(self) -> tuple[Any, float, float, float]:
        return self.velocity, self._reach, self.tree_a.error, self.tree_b.error

    @cached_property
    def _reach(self) -> float:
        """A time at which the boxes of the bodies have passed each other for good, unless nothing moves."""
        box_a, box_b, v = self.tree_a.boxes[0].tolist(), self.tree_b.boxes[0].tolist(), self.velocity[6:].tolist()
        pad = 2.0 * (self.tree_a.error + self.tree_b.error)
        last = math.inf if any(v) else 0.0
        for k in range(3):
            if v[k]:
                gap = box_b[k + 3] - box_a[k] if v[k] > 0 else box_a[k + 3] - box_b[k]
                last = min(last, max(0.0, gap + pad) / abs(v[k]))
        return last * (1.0 + 1e-14)


class LiftedRotation(LiftedAdvance, RotationProblem):
    def asked(self) -> tuple[Any, float, float, float]:
        return self.motion, math.inf, self.error_a, self.error_b


def lifted_of(body: Any, tree: Tree) -> Lifted:
    """Elements and facet tree of the body in the frame of the tree; kept on the body for the next query."""
    cached = body._search.get("lifted")
    if cached is None or cached[0] is not tree:
        edges, corners = edges_of(tree), corners_of_tree(tree)
        cached = body._search["lifted"] = tree, Lifted(edges, corners, lifted_tree(tree, facets_of(tree), facets=True))
    return cached[1]
