"""What the walk over lifted trees needs of a problem of translation or rotation, kept on its bodies."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from firstcontact.search.halving import Edges, Room, room_for
from firstcontact.search.lifted_tree import WAY, Elements, corners_of_tree, edges_of, facets_of, lift, lifted_tree
from firstcontact.search.lifted_walk import Askers, Body, Facets, lifted_walk
from firstcontact.search.state import WalkState
from firstcontact.search.translation_problem import TranslationProblem
from firstcontact.search.tree import Tree


@dataclass(slots=True)
class Lifted:
    """The elements of one body in one frame, and the tree over its facets."""

    edges: Elements
    corners: Askers
    facets: Facets


@dataclass(slots=True)
class Scratch:
    """Of one search."""

    a: Body
    b: Body
    room: Room


def advance_lifted(problem: Any, state: WalkState, limit: int) -> int:
    """Go on with the walk of a translation or rotation over lifted trees; the reason it came back."""
    if state.scratch is None:
        state.scratch = lifted_scratch(problem)
    return walk_lifted(problem, state.scratch, state, limit)


def lifted_scratch(problem: Any) -> Scratch:
    a, b = lifted_of(problem.a, problem.tree_a), lifted_of(problem.b, problem.tree_b)
    bodies = (_body(x, tree, b.facets) for x, tree in ((a, problem.tree_a), (b, problem.tree_b)))
    return Scratch(next(bodies), next(bodies), room_for(len(a.edges.parts), len(b.edges.parts)))


def walk_lifted(
    problem: Any, scratch: Scratch, state: WalkState, limit: int,
    searches: Mapping[int, Callable[[int], int]] = MappingProxyType({}),
) -> int:  # fmt: skip
    """`lifted_walk` of the problem."""
    motion, reach, errors = motion_of(problem)
    return lifted_walk(scratch.a, scratch.b, scratch.room, motion, reach, errors, limit, state, searches)


def motion_of(problem: Any) -> tuple[np.ndarray, float, tuple[float, float]]:
    """(the motion for kernels, a time after which certainly nothing meets, errors of the parts of a and of b)."""
    if isinstance(problem, TranslationProblem):
        return problem.velocity, parting(problem), (problem.tree_a.error, problem.tree_b.error)
    return problem.motion, math.inf, (problem.error_a, problem.error_b)


def _body(of: Lifted, tree: Tree, about: Facets) -> Body:
    """The body with its edges' lines about the origin of the other one's tree."""
    lines, _, boxes, sizes, _ = lift(of.edges.corners, False, about.origin, about.scale, WAY)
    return Body(Edges(lines, boxes, sizes, of.edges.corners, of.edges.parts), of.corners, of.facets, tree.xyz)


def parting(problem: TranslationProblem) -> float:
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
        corners, found = corners_of_tree(tree), lifted_tree(tree, facets_of(tree))
        facets = Facets(found.nodes, found.links, found.elements.parts, found.origin, found.scale)
        lifted = Lifted(edges_of(tree), Askers(corners.corners, corners.parts), facets)
        cached = body._search["lifted"] = tree, lifted
    return cached[1]
