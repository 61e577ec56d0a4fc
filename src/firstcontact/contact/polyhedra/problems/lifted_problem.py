"""What the walk by lines and planes needs of a problem of translation or rotation, kept on its bodies."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from firstcontact.body.kept import Kept
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.engines import ByEngine
from firstcontact.contact.polyhedra.problems.translation_problem import TranslationProblem
from firstcontact.kernels.lifted.meridians import may_meet_turning
from firstcontact.kernels.lifted.swept_cell import edge_distances
from firstcontact.search.lifted.facet_halving import FacetTables, Paths
from firstcontact.search.lifted.halving import Edges, Room, larger, room_for
from firstcontact.search.lifted.lifted_elements import (
    WAY,
    Elements,
    corners_of_tree,
    edges_of,
    facets_of,
    frame_of,
    lift,
)
from firstcontact.search.lifted.lifted_walk import LiftedBody, lifted_walk
from firstcontact.search.trees.state import CROWDED, WalkState
from firstcontact.search.trees.tree import FACET, POINT, Tree


@dataclass(slots=True)
class Lifted:
    """The elements of one body in one frame."""

    edges: Elements
    corners: Elements
    facets: Elements


@dataclass(slots=True)
class LiftedScratch:
    """Of one search."""

    a: LiftedBody
    b: LiftedBody
    frame: tuple[np.ndarray, float]
    room: Room


def advance_lifted(problem: ByEngine, state: WalkState, limit: int) -> int:
    """Go on with the walk of a translation or rotation by lines and planes; the reason it came back."""
    if state.scratch is None:
        state.scratch = lifted_scratch(problem)
    return walk_lifted(problem, state.scratch, state, limit)


def lifted_scratch(problem: ByEngine) -> LiftedScratch:
    frame = frame_of(problem.tree_b)
    of_a, of_b = lifted_of(problem.a, problem.tree_a), lifted_of(problem.b, problem.tree_b)
    motion, _, _ = motion_of(problem)
    meets_a, meets_b = _parts_that_may_meet(problem)
    a = _body(of_a, of_b, problem.tree_a, frame, motion, meets_a)
    b = _body(of_b, of_a, problem.tree_b, frame, motion, meets_b)
    most = (max(len(x.edges.parts), len(x.corners.parts), len(x.facets.parts)) for x in (a, b))
    return LiftedScratch(a, b, frame, room_for(*most))


def walk_lifted(
    problem: ByEngine, scratch: LiftedScratch, state: WalkState, limit: int,
    searches: Mapping[int, Callable[[int], int]] = MappingProxyType({}),
) -> int:  # fmt: skip
    """`lifted_walk` of the problem."""
    motion, reach, errors = motion_of(problem)
    while True:
        reason = lifted_walk(
            scratch.a, scratch.b, scratch.frame, scratch.room, motion, reach, errors, limit, state, searches
        )
        if reason != CROWDED:
            return reason
        scratch.room = larger(scratch.room)


def motion_of(problem: ByEngine) -> tuple[np.ndarray, float, tuple[float, float]]:
    """(the motion as rows, a time after which certainly nothing meets, errors of the parts of a and of b)."""
    reach = parting(problem) if isinstance(problem, TranslationProblem) else math.inf
    return np.atleast_2d(problem.motion), reach, (problem.error_a, problem.error_b)


def _parts_that_may_meet(problem: ByEngine) -> tuple[np.ndarray, np.ndarray]:
    """Of the parts of a and of b, false for those that meet nothing of the other body at any time."""
    xyz_a, xyz_b = problem.tree_a.xyz, problem.tree_b.xyz
    if isinstance(problem, TranslationProblem):
        return np.ones(len(xyz_a), bool), np.ones(len(xyz_b), bool)
    error = problem.error_a + problem.error_b
    meets = may_meet_turning(np.concatenate([xyz_a, xyz_b]), len(xyz_a), *problem.motion[-1, :2], error)
    return meets[: len(xyz_a)], meets[len(xyz_a) :]


def _body(
    whole: Lifted, other: Lifted, tree: Tree, frame: tuple[np.ndarray, float], motion: np.ndarray, meets: np.ndarray
) -> LiftedBody:
    """The elements of the body's parts that may meet the other one, with lines and planes in the frame."""
    of = Lifted(*(_of_parts(x, meets) for x in (whole.edges, whole.corners, whole.facets)))
    corners, parts = of.edges.corners, of.edges.parts
    if np.all(other.edges.parts[:, 1] & FACET):  # points meet edges of edge sets only
        counts = parts[:, 1] & POINT == 0
        corners, parts = corners[counts], parts[counts]
    lines, boxes, sizes, _ = lift(corners, False, *frame, WAY)
    edges = Edges(lines, boxes, sizes, corners, parts, edge_distances(corners, motion))
    sides, boxes, sizes, planes = lift(of.facets.corners, True, *frame, WAY)
    facets = FacetTables(sides, planes, boxes, sizes, of.facets.corners, of.facets.parts)
    vertices = Paths(of.corners.corners, np.zeros((0, 6)), of.corners.parts)
    return LiftedBody(edges, Paths(corners, lines, parts), vertices, facets, tree.xyz)


def _of_parts(elements: Elements, meets: np.ndarray) -> Elements:
    """The elements that such parts own; what a part owns lies in it."""
    chosen = meets[elements.parts[:, 0]]
    return elements if chosen.all() else Elements(elements.parts[chosen], elements.corners[chosen])


def parting(problem: TranslationProblem) -> float:
    """A time at which the boxes of the bodies have passed each other for good; 0 where nothing moves."""
    box_a, box_b = problem.tree_a.boxes[0].tolist(), problem.tree_b.boxes[0].tolist()
    v = problem.motion[6:].tolist()
    pad = 2.0 * (problem.tree_a.error + problem.tree_b.error)
    last = math.inf if any(v) else 0.0
    for k in range(3):
        if v[k]:
            gap = box_b[k + 3] - box_a[k] if v[k] > 0 else box_a[k + 3] - box_b[k]
            last = min(last, max(0.0, gap + pad) / abs(v[k]))
    return last * (1.0 + 1e-14)


_LIFTED = Kept[tuple[Tree, Lifted]]()


def lifted_of(body: Polyhedron, tree: Tree) -> Lifted:
    """Elements of the body in the frame of the tree; kept on the body for the next query."""
    cached = _LIFTED.get(body)
    if cached is None or cached[0] is not tree:
        cached = _LIFTED.put(body, (tree, Lifted(edges_of(tree), corners_of_tree(tree), facets_of(tree))))
    return cached[1]
