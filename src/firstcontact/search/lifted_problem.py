"""What the walk over lifted trees needs of a problem of translation or rotation, kept on its bodies."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from firstcontact.search.lifted_tree import Elements, LiftedTree, corners_of_tree, edges_of, facets_of, lifted_tree
from firstcontact.search.lifted_walk import lifted_walk
from firstcontact.search.state import WalkState
from firstcontact.search.translation_problem import TranslationProblem
from firstcontact.search.tree import Tree


@dataclass(slots=True)
class Lifted:
    """What queries need of one body in one frame."""

    edges: Elements
    corners: Elements
    facet_tree: LiftedTree
    edge_tree: LiftedTree | None = None


def advance_lifted(problem: Any, state: WalkState, limit: int) -> int:
    """Go on with the walk of a translation or rotation over lifted trees; the reason it came back."""
    a, b = lifted_of(problem.a, problem.tree_a), lifted_of(problem.b, problem.tree_b)
    if b.edge_tree is None:
        b.edge_tree = lifted_tree(problem.tree_b, b.edges, facets=False)
    if isinstance(problem, TranslationProblem):
        motion, reach = problem.velocity, _parting(problem)
        error_a, error_b = problem.tree_a.error, problem.tree_b.error
    else:
        motion, reach, error_a, error_b = problem.motion, math.inf, problem.error_a, problem.error_b
    tree, facets_a, facets_b = b.edge_tree, a.facet_tree, b.facet_tree
    return lifted_walk(
        tree.nodes, tree.links, tree.elements.parts, tree.origin, tree.scale,
        facets_a.nodes, facets_a.links, facets_a.elements.parts, facets_a.origin, facets_a.scale,
        facets_b.nodes, facets_b.links, facets_b.elements.parts, facets_b.origin, facets_b.scale,
        a.edges.corners, a.edges.parts, b.edges.corners, b.edges.parts,
        a.corners.corners, a.corners.parts, b.corners.corners, b.corners.parts,
        problem.tree_a.xyz, problem.tree_b.xyz, motion, reach, error_a, error_b, limit,
        state.floats, state.integers, state.stack, state.times, state.candidates,
    )  # fmt: skip


def _parting(problem: TranslationProblem) -> float:
    """A time at which the boxes of the bodies have passed each other for good; 0 where nothing moves."""
    box_a, box_b = problem.tree_a.boxes[0].tolist(), problem.tree_b.boxes[0].tolist()
    v = problem.velocity[6:].tolist()
    pad = 2.0 * (problem.tree_a.error + problem.tree_b.error)
    last = math.inf if any(v) else 0.0
    for k in range(3):
        if v[k]:
            gap = box_b[k + 3] - box_a[k] if v[k] > 0 else box_a[k + 3] - box_b[k]
            last = min(last, max(0.0, gap + pad) / abs(v[k]))
    return last * (1.0 + 1e-14)


def lifted_of(body: Any, tree: Tree) -> Lifted:
    """Elements and facet tree of the body in the frame of the tree; kept on the body for the next query."""
    cached = body._search.get("lifted")
    if cached is None or cached[0] is not tree:
        edges, corners = edges_of(tree), corners_of_tree(tree)
        cached = body._search["lifted"] = tree, Lifted(edges, corners, lifted_tree(tree, facets_of(tree), facets=True))
    return cached[1]
