"""The walk over lifted trees: edges against edges by halving, and vertices and facets by queries.

Corners of a query the facets of b, corners of b those of a, and at the start edges query facets: in random order, with
one best time for all, so that most queries only learn that they meet nothing earlier and the expected number of those
that lower it is logarithmic (Chan 1999, "Geometric applications of a randomized optimization technique").  The pair
tests, their bounds and what is noted are those of the walk over boxes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from firstcontact.kernels.jit import kernel
from firstcontact.kernels.lifted_query import ROWS, may_meet, write_segment
from firstcontact.search.halving import Edges, Room, halve
from firstcontact.search.lifted_motion import arc_of, lay_corner
from firstcontact.search.state import (
    ARC,
    BEST,
    CANDIDATES,
    CROSSING_FOUND,
    DECIDE,
    DONE,
    FULL,
    KEY,
    LEAF_ROOM,
    LIFTED,
    PHASE,
    QUERY,
    SLICE_SPENT,
    STACK,
    UNSURE_BATCH,
    UNSURE_COUNT,
    VISITS,
)
from firstcontact.search.tree import SIDE
from firstcontact.search.walk import meet_at_start, test_events

# Phases: edges against facets at the start, then within each arc the three kinds of contact.
EDGES_AT_START, FACETS_AT_START, EDGES, CORNERS, FACETS, PHASES = range(6)


class Facets(NamedTuple):
    """The tree over the facets of a body (`lifted_tree`)."""

    nodes: np.ndarray
    links: np.ndarray
    parts: np.ndarray
    origin: np.ndarray
    scale: float


class Askers(NamedTuple):
    """Elements that query: corners (m, 9) and parts (m, 2)."""

    corners: np.ndarray
    parts: np.ndarray


class Body(NamedTuple):
    """What the walk needs of one body; xyz: its tree's parts."""

    edges: Edges
    corners: Askers
    facets: Facets
    xyz: np.ndarray


@kernel
def _lay_still_edge(x, query, facets, work):
    """Write the query for the facets that the edge x (9,) pierces."""
    for k in range(3):
        work[0, k], work[1, k] = 0.0, x[3 + k] - x[k]
    write_segment(query, x[0:3], work[0], work[1], facets.origin, facets.scale)


def lifted_walk(
    a: Body, b: Body, room: Room, motion: np.ndarray, reach: float, errors: tuple[float, float], limit: int, state: Any,
    searches: Mapping[int, Callable[[int], int]] = MappingProxyType({}),
) -> int:  # fmt: skip
    """Go on with the walk until one of the reasons of `state` to come back; returns it.

    reach: a time after which certainly nothing meets (translations).  errors: of the parts of a and of b.
    searches: what to ask, by phase and with the number of the arc, instead of `halve` or `ask`.
    """
    floats, integers, stack = state.floats, state.integers, state.stack
    search = limit, floats, integers, stack, state.times, state.candidates
    still_a, still_b = Askers(a.edges.corners, a.edges.parts), Askers(b.edges.corners, b.edges.parts)
    if integers[PHASE] == EDGES_AT_START and integers[LIFTED] == 2:
        integers[PHASE] = EDGES
    while True:
        phase, arc = int(integers[PHASE]), int(integers[ARC])
        if phase >= EDGES:
            exists, over = arc_of(motion, floats, arc)
            if not exists:
                floats[KEY] = floats[BEST]
                return DONE
            if over:
                integers[ARC] += 1
                continue
        if phase in searches:
            reason = searches[phase](arc)
        elif phase == EDGES:
            reason = halve(
                a.edges, b.edges, b.facets.origin, b.facets.scale, room, motion, arc, reach, a.xyz, b.xyz, *errors,
                limit, floats, integers, state.times, state.candidates,
            )  # fmt: skip
        else:
            by_a = phase in (EDGES_AT_START, CORNERS)
            asker, asked = (a, b) if by_a else (b, a)
            still = phase < EDGES
            elements = (still_a if by_a else still_b) if still else asker.corners
            reason = ask(elements, asked.facets, still, not by_a, motion, arc, reach, a.xyz, b.xyz, *errors, *search)
        if reason != DONE:
            return reason
        stack[0, 0] = 0
        integers[STACK], integers[QUERY] = 1, 0
        integers[PHASE] = phase + 1
        if phase + 1 == PHASES:
            integers[PHASE] = EDGES
            integers[ARC] += 1


@kernel
def ask(askers, facets, still, swapped, motion, arc, reach, xyz_a, xyz_b, err_a, err_b, limit,
        floats, integers, stack, times, candidates):  # fmt: skip
    """Go on with every element's query against the tree; returns why it stopped.  STACK counts the nodes that wait.

    still: edges against the facets they pierce at the start.  swapped: the elements are of b, the tree is of a.
    """
    nodes, links, parts = facets.nodes, facets.links, facets.parts
    query, work = np.zeros((ROWS, 6)), np.empty((8, 3))
    if parts.shape[0] == 0:
        return DONE
    for q in range(integers[QUERY], askers.parts.shape[0]):
        integers[QUERY] = q
        if still:
            _lay_still_edge(askers.corners[q], query, facets, work)
        else:
            lay_corner(motion, arc, askers.corners[q, 0:3], -1.0 if swapped else 1.0, reach, floats,
                       facets.origin, facets.scale, query, work)  # fmt: skip
        while integers[STACK] > 0:
            if integers[CANDIDATES] + LEAF_ROOM > times.shape[0] or integers[STACK] + 4 > stack.shape[0]:
                return FULL
            if integers[UNSURE_COUNT] >= UNSURE_BATCH:
                return DECIDE
            if integers[VISITS] >= limit:
                return SLICE_SPENT
            integers[STACK] -= 1
            node = stack[integers[STACK], 0]
            integers[VISITS] += 1
            if not may_meet(nodes[node], query, True, facets.scale, facets.origin, err_a + err_b):
                continue
            if links[node, 1] >= 0:
                n = integers[STACK]
                stack[n, 0], stack[n + 1, 0] = links[node, 0], links[node, 1]
                integers[STACK] = n + 2
                continue
            for i in range(links[node, 0], -links[node, 1]):
                a, b = (parts[i], askers.parts[q]) if swapped else (askers.parts[q], parts[i])
                xa, xb = xyz_a[a[0]], xyz_b[b[0]]
                if still:
                    if meet_at_start(
                        a[0], a[1], xa, b[0], b[1], xb, err_a, err_b, floats, integers, times, candidates
                    ):
                        return CROSSING_FOUND
                else:
                    test_events(
                        motion, a[0], a[1], xa, b[0], b[1], xb, 1 << SIDE, err_a, err_b,
                        floats, integers, times, candidates,
                    )  # fmt: skip
        stack[0, 0] = 0
        integers[STACK] = 1
    return DONE
