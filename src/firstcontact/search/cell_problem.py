"""What the walk that cuts space and time needs of a problem of translation or rotation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from firstcontact.search.cell_walk import Cells, cell_walk
from firstcontact.search.lifted_problem import parting
from firstcontact.search.state import BEST, CROWDED, DONE, FIRST, WalkState
from firstcontact.search.translation_problem import TranslationProblem
from firstcontact.search.tree import FACET, Tree


class Primitives(NamedTuple):
    """Parts to put on lists, and ids (m, 2) by part: primitive and mask, the same for all parts of a primitive."""

    parts: np.ndarray
    ids: np.ndarray


@dataclass(slots=True)
class Search:
    """What waits; at_start: still looking for edges that cross facets at the start."""

    a: Primitives
    b: Primitives
    cells: Cells
    at_start: bool


def advance_cells(problem: Any, state: WalkState, limit: int, with_start: bool) -> int:
    """Go on with the walk; the reason it came back.  What waits is kept on the state."""
    a, b, floats = problem.tree_a, problem.tree_b, state.floats
    if state.scratch is None:
        at_start = with_start and (_has_facets(a) or _has_facets(b))
        state.scratch = Search(primitives_of(problem.a, a), primitives_of(problem.b, b), Cells(), at_start)
        _begin(problem, state)
    search: Search = state.scratch
    if isinstance(problem, TranslationProblem):
        motion, error_a, error_b = problem.velocity, a.error, b.error
    else:
        motion, error_a, error_b = problem.motion, problem.error_a, problem.error_b
    cells = search.cells
    while True:
        reason, cells.waiting = cell_walk(
            a.xyz, search.a.ids, b.xyz, search.b.ids, motion, error_a, error_b, search.at_start, limit,
            cells.boxes, cells.frames, cells.lists, cells.waiting, cells.pays,
            floats, state.integers, state.times, state.candidates,
        )  # fmt: skip
        if reason == CROWDED:
            cells.lists = np.concatenate([cells.lists, np.empty_like(cells.lists)])
        elif reason == DONE and search.at_start:
            search.at_start = False
            _begin(problem, state)
        else:
            return reason


def _begin(problem: Any, state: WalkState) -> None:
    search: Search = state.scratch
    first, last = (0.0, 0.0) if search.at_start else (float(state.floats[FIRST]), float(state.floats[BEST]))
    if isinstance(problem, TranslationProblem):
        last = min(last, parting(problem))
    search.cells.start(search.a.parts, search.b.parts, problem.tree_b.boxes[0], first, last)


def primitives_of(body: Any, tree: Tree) -> Primitives:
    """One part for each primitive, with all elements that its parts own; kept on the body for the next query."""
    cached = body._search.get("cells")
    if cached is None or cached[0] is not tree:
        _, first = np.unique(tree.ids[:, 0], return_index=True)
        masks = np.zeros(len(tree.corners), np.int32)
        np.bitwise_or.at(masks, tree.ids[:, 0], tree.ids[:, 1])
        ids = np.stack([tree.ids[:, 0], masks[tree.ids[:, 0]]], axis=1)
        cached = body._search["cells"] = tree, Primitives(np.sort(first), ids)
    return cached[1]


def _has_facets(tree: Tree) -> bool:
    return bool(np.any(tree.ids[:, 1] & FACET))
