"""The walk over lifted trees: edges against edges by halving, and vertices and facets by queries.

Corners of a query the facets of b, corners of b those of a, and at the start edges query facets: in random order, with
one best time for all, so that most queries only learn that they meet nothing earlier and the expected number of those
that lower it is logarithmic (Chan 1999, "Geometric applications of a randomized optimization technique").  The pair
tests, their bounds and what is noted are those of the walk over boxes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from firstcontact.kernels.jit import kernel
from firstcontact.kernels.lifted_query import ROWS, may_meet, write_segment
from firstcontact.search.halving import halve
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


@kernel
def _lay_still_edge(x, query, facets, work):
    """Write the query for the facets that the edge x (9,) pierces."""
    for k in range(3):
        work[0, k], work[1, k] = 0.0, x[3 + k] - x[k]
    write_segment(query, x[0:3], work[0], work[1], facets.origin, facets.scale)


@kernel
def lifted_walk(
    edges_a, facets_a, corners_a, edges_b, facets_b, corners_b, origin, scale, room,
    xyz_a, xyz_b, motion, reach, err_a, err_b, limit, floats, integers, stack, times, candidates,
):  # fmt: skip
    """Go on with the walk until one of the reasons of `state` to come back; returns it.

    origin, scale: of the lines of both bodies' edges.  reach: time after which certainly nothing meets (translations).
    """
    query, work = np.zeros((ROWS, 6)), np.empty((8, 3))
    still_a, still_b = Askers(edges_a.corners, edges_a.parts), Askers(edges_b.corners, edges_b.parts)
    if integers[PHASE] == EDGES_AT_START and integers[LIFTED] == 2:
        integers[PHASE] = EDGES
    while True:
        phase, arc = integers[PHASE], integers[ARC]
        if phase >= EDGES:
            exists, over = arc_of(motion, floats, arc)
            if not exists:
                floats[KEY] = floats[BEST]
                return DONE
            if over:
                integers[ARC] += 1
                continue
        if phase == EDGES_AT_START or phase == CORNERS:
            reason = _ask(
                still_a if phase == EDGES_AT_START else corners_a, facets_b, phase, False, query, work, motion, arc,
                reach, xyz_a, xyz_b, err_a, err_b, limit, floats, integers, stack, times, candidates,
            )  # fmt: skip
        elif phase == FACETS_AT_START or phase == FACETS:
            reason = _ask(
                still_b if phase == FACETS_AT_START else corners_b, facets_a, phase, True, query, work, motion, arc,
                reach, xyz_a, xyz_b, err_a, err_b, limit, floats, integers, stack, times, candidates,
            )  # fmt: skip
        else:
            reason = halve(edges_a, edges_b, origin, scale, room, query, work, motion, arc, reach, xyz_a, xyz_b,
                           err_a, err_b, limit, floats, integers, times, candidates)  # fmt: skip
        if reason != DONE:
            return reason
        stack[0, 0] = 0
        integers[STACK], integers[QUERY] = 1, 0
        integers[PHASE] = phase + 1
        if phase + 1 == PHASES:
            integers[PHASE] = EDGES
            integers[ARC] += 1


@kernel
def _ask(askers, facets, phase, swapped, query, work, motion, arc, reach, xyz_a, xyz_b, err_a, err_b, limit,
         floats, integers, stack, times, candidates):  # fmt: skip
    """Every element's query against the tree; swapped: the elements are of b, the tree is of a."""
    at_start = phase < EDGES
    if facets.parts.shape[0] == 0:
        return DONE
    for q in range(integers[QUERY], askers.parts.shape[0]):
        integers[QUERY] = q
        if at_start:
            _lay_still_edge(askers.corners[q], query, facets, work)
        else:
            lay_corner(motion, arc, askers.corners[q, 0:3], -1.0 if swapped else 1.0, reach, floats,
                       facets.origin, facets.scale, query, work)  # fmt: skip
        reason = _descend(facets, askers.parts[q], query, motion, swapped, at_start, xyz_a, xyz_b, err_a, err_b,
                          limit, floats, integers, stack, times, candidates)  # fmt: skip
        if reason != DONE:
            return reason
        stack[0, 0] = 0
        integers[STACK] = 1
    return DONE


@kernel
def _descend(facets, asker, query, motion, swapped, at_start, xyz_a, xyz_b, err_a, err_b, limit,
             floats, integers, stack, times, candidates):  # fmt: skip
    """Go on with one query: STACK counts the nodes that wait.  Returns the reason to stop."""
    nodes, links, parts = facets.nodes, facets.links, facets.parts
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
            a, b = (parts[i], asker) if swapped else (asker, parts[i])
            xa, xb = xyz_a[a[0]], xyz_b[b[0]]
            if at_start:
                if meet_at_start(
                    a[0], a[1], xa, b[0], b[1], xb, err_a, err_b, floats, integers, times, candidates
                ):
                    return CROSSING_FOUND
            else:
                test_events(
                    motion, a[0], a[1], xa, b[0], b[1], xb, 1 << SIDE, err_a, err_b,
                    floats, integers, times, candidates,
                )  # fmt: skip
    return DONE
