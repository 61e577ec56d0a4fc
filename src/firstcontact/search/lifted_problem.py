"""What the walk over lifted trees needs of a problem of translation or rotation, kept on its bodies."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from firstcontact.search.halving import Edges, Room, room_for
from firstcontact.search.lifted_tree import WAY, Elements, corners_of_tree, edges_of, facets_of, lift, lifted_tree
from firstcontact.search.lifted_walk import Askers, Facets, lifted_walk
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
    """Of one search: the edges of both bodies about one origin, and room to halve them."""

    edges_a: Edges
    edges_b: Edges
    room: Room


def advance_lifted(problem: Any, state: WalkState, limit: int) -> int:
    """Go on with the walk of a translation or rotation over lifted trees; the reason it came back."""
    a, b = lifted_of(problem.a, problem.tree_a), lifted_of(problem.b, problem.tree_b)
    if state.scratch is None:
        state.scratch = _scratch(a, b)
    scratch: Scratch = state.scratch
    if isinstance(problem, TranslationProblem):
        motion, reach = problem.velocity, _parting(problem)
        error_a, error_b = problem.tree_a.error, problem.tree_b.error
    else:
        motion, reach, error_a, error_b = problem.motion, math.inf, problem.error_a, problem.error_b
    return lifted_walk(
        scratch.edges_a, a.facets, a.corners, scratch.edges_b, b.facets, b.corners,
        b.facets.origin, b.facets.scale, scratch.room,
        problem.tree_a.xyz, problem.tree_b.xyz, motion, reach, error_a, error_b, limit,
        state.floats, state.integers, state.stack, state.times, state.candidates,
    )  # fmt: skip


def _scratch(a: Lifted, b: Lifted) -> Scratch:
    room = room_for(len(a.edges.parts), len(b.edges.parts))
    return Scratch(_edges(a, b.facets), _edges(b, b.facets), room)


def _edges(of: Lifted, about: Facets) -> Edges:
    lines, _, boxes, sizes, _ = lift(of.edges.corners, False, about.origin, about.scale, WAY)
    return Edges(lines, boxes, sizes, of.edges.corners, of.edges.parts)


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
        corners, found = corners_of_tree(tree), lifted_tree(tree, facets_of(tree))
        facets = Facets(found.nodes, found.links, found.elements.parts, found.origin, found.scale)
        lifted = Lifted(edges_of(tree), Askers(corners.corners, corners.parts), facets)
        cached = body._search["lifted"] = tree, lifted
    return cached[1]
