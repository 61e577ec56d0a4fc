"""The walk that asks, one element after the other, what it may meet: queries against lifted trees.

Edges and corners of a query its edges, corners of the facets of b, and so on, in random order with one best time for
all: most queries only learn that they meet nothing earlier, and the expected number of those that lower the best time
is logarithmic (Chan 1999, "Geometric applications of a randomized optimization technique").  The pair tests, their
bounds and what is noted are those of the walk over boxes.  Translations are one arc; rotations are searched arc by arc.

What depends on the motion is chosen by its type, as in `walk`.
"""

from __future__ import annotations

import numpy as np
from numba.extending import overload

from firstcontact.kernels.angle import ANGLE_EPS
from firstcontact.kernels.jit import kernel
from firstcontact.kernels.lifted_query import (
    ROWS,
    may_meet,
    write_segment,
    write_swept_edge,
    write_turned_edge,
    write_turned_point,
)
from firstcontact.search.state import (
    ARC,
    BEST,
    CANDIDATES,
    CROSSING_FOUND,
    DECIDE,
    DONE,
    FIRST,
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

# An arc turns by 2 atan(1/5): its cosine and sine are rational.  Sixteen make more than a full turn.
ARC_ANGLE, ARC_TANGENT = 0.3947911196997615, 0.2
ARCS = 16


def _arc_starts() -> np.ndarray:
    """Cosine and sine where each arc starts, rounded once."""
    x, y, whole, rows = 1, 0, 1, []
    for _ in range(ARCS + 1):
        rows.append((x / whole, y / whole))
        x, y, whole = 12 * x - 5 * y, 5 * x + 12 * y, 13 * whole
    return np.array(rows)


ARC_STARTS = _arc_starts()


def arc_of(motion, floats, arc):
    """(whether there is such an arc before the best time, whether it ends before the window begins)."""
    raise NotImplementedError("compiled only, by the type of the motion")


def lay_edge(motion, arc, x, y, reach, floats, origin, scale, query, work):
    """Write the query for the edge from x to y of a."""
    raise NotImplementedError("compiled only, by the type of the motion")


def lay_corner(motion, arc, x, sense, reach, floats, origin, scale, query, work):
    """Write the query for the corner x of a (sense 1), or of b (sense -1: it moves the other way past a)."""
    raise NotImplementedError("compiled only, by the type of the motion")


@kernel
def lay_still_edge(x, y, origin, scale, query, work):
    """Write the query for the facets that the edge from x to y pierces."""
    for k in range(3):
        work[0, k], work[1, k] = 0.0, y[k] - x[k]
    write_segment(query, x, work[0], work[1], origin, scale)


@kernel
def lifted_walk(
    nodes, links, parts, origin, scale,
    facet_nodes_a, facet_links_a, facet_parts_a, origin_a, scale_a,
    facet_nodes_b, facet_links_b, facet_parts_b, origin_b, scale_b,
    edges_a, edge_parts_a, edges_b, edge_parts_b, corners_a, corner_parts_a, corners_b, corner_parts_b,
    xyz_a, xyz_b, motion, reach, err_a, err_b, limit,
    floats, integers, stack, times, candidates,
):  # fmt: skip
    """Go on with the walk until one of the reasons of `state` to come back; returns it.

    nodes, links, parts: the tree over edges of b; then those over facets of a and of b; then the elements that ask.
    reach: a time after which certainly nothing meets (translations).
    """
    query, work = np.zeros((ROWS, 6)), np.empty((8, 3))
    err = err_a + err_b
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
        if phase == EDGES_AT_START:
            count = edge_parts_a.shape[0] if facet_parts_b.shape[0] else 0
        elif phase == FACETS_AT_START:
            count = edge_parts_b.shape[0] if facet_parts_a.shape[0] else 0
        elif phase == EDGES:
            count = edge_parts_a.shape[0] if parts.shape[0] else 0
        elif phase == CORNERS:
            count = corner_parts_a.shape[0] if facet_parts_b.shape[0] else 0
        else:
            count = corner_parts_b.shape[0] if facet_parts_a.shape[0] else 0
        for q in range(integers[QUERY], count):
            integers[QUERY] = q
            if phase == EDGES_AT_START:
                lay_still_edge(edges_a[q, 0:3], edges_a[q, 3:6], origin_b, scale_b, query, work)
                reason = _descend(facet_nodes_b, facet_links_b, facet_parts_b, origin_b, scale_b, True, query, motion,
                                  edge_parts_a[q, 0], edge_parts_a[q, 1], False, True, xyz_a, xyz_b, err_a, err_b, err,
                                  limit, floats, integers, stack, times, candidates)  # fmt: skip
            elif phase == FACETS_AT_START:
                lay_still_edge(edges_b[q, 0:3], edges_b[q, 3:6], origin_a, scale_a, query, work)
                reason = _descend(facet_nodes_a, facet_links_a, facet_parts_a, origin_a, scale_a, True, query, motion,
                                  edge_parts_b[q, 0], edge_parts_b[q, 1], True, True, xyz_a, xyz_b, err_a, err_b, err,
                                  limit, floats, integers, stack, times, candidates)  # fmt: skip
            elif phase == EDGES:
                lay_edge(motion, arc, edges_a[q, 0:3], edges_a[q, 3:6], reach, floats, origin, scale, query, work)
                reason = _descend(nodes, links, parts, origin, scale, False, query, motion,
                                  edge_parts_a[q, 0], edge_parts_a[q, 1], False, False, xyz_a, xyz_b, err_a, err_b, err,
                                  limit, floats, integers, stack, times, candidates)  # fmt: skip
            elif phase == CORNERS:
                lay_corner(motion, arc, corners_a[q, 0:3], 1.0, reach, floats, origin_b, scale_b, query, work)
                reason = _descend(facet_nodes_b, facet_links_b, facet_parts_b, origin_b, scale_b, True, query, motion,
                                  corner_parts_a[q, 0], corner_parts_a[q, 1], False, False, xyz_a, xyz_b,
                                  err_a, err_b, err, limit, floats, integers, stack, times, candidates)  # fmt: skip
            else:
                lay_corner(motion, arc, corners_b[q, 0:3], -1.0, reach, floats, origin_a, scale_a, query, work)
                reason = _descend(facet_nodes_a, facet_links_a, facet_parts_a, origin_a, scale_a, True, query, motion,
                                  corner_parts_b[q, 0], corner_parts_b[q, 1], True, False, xyz_a, xyz_b,
                                  err_a, err_b, err, limit, floats, integers, stack, times, candidates)  # fmt: skip
            if reason != DONE:
                return reason
            stack[0, 0] = 0
            integers[STACK] = 1
        integers[QUERY] = 0
        integers[PHASE] = phase + 1
        if phase + 1 == PHASES:
            integers[PHASE] = EDGES
            integers[ARC] += 1


@kernel
def _descend(
    nodes, links, parts, origin, scale, facets, query, motion, part, mask, swapped, at_start,
    xyz_a, xyz_b, err_a, err_b, err, limit, floats, integers, stack, times, candidates,
):  # fmt: skip
    """Go on with one query; swapped: its element is one of b, the tree's are of a.  Returns the reason to stop."""
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
        if not may_meet(nodes[node], query, facets, scale, origin, err):
            continue
        if links[node, 1] >= 0:
            n = integers[STACK]
            stack[n, 0], stack[n + 1, 0] = links[node, 0], links[node, 1]
            integers[STACK] = n + 2
            continue
        for i in range(links[node, 0], -links[node, 1]):
            if swapped:
                pa, mask_a, pb, mask_b = parts[i, 0], parts[i, 1], part, mask
            else:
                pa, mask_a, pb, mask_b = part, mask, parts[i, 0], parts[i, 1]
            if at_start:
                if meet_at_start(
                    pa, mask_a, xyz_a[pa], pb, mask_b, xyz_b[pb], err_a, err_b, floats, integers, times, candidates
                ):
                    return CROSSING_FOUND
            else:
                test_events(
                    motion, pa, mask_a, xyz_a[pa], pb, mask_b, xyz_b[pb], 1 << SIDE, err_a, err_b,
                    floats, integers, times, candidates,
                )  # fmt: skip
    return DONE


# ---------------------------------------------------------------------------------------------- translation


@overload(arc_of)
def _arc_of(motion, floats, arc):
    if motion.ndim == 1:
        return lambda motion, floats, arc: (arc == 0, False)
    return _arc_of_rotation


@overload(lay_edge)
def _lay_edge(motion, arc, x, y, reach, floats, origin, scale, query, work):
    return _lay_shifted_edge if motion.ndim == 1 else _lay_turned_edge


@overload(lay_corner)
def _lay_corner(motion, arc, x, sense, reach, floats, origin, scale, query, work):
    return _lay_shifted_corner if motion.ndim == 1 else _lay_turned_corner


@kernel
def _shifts(motion, sense, reach, floats, work):
    """Write how far a moves until the window begins, and from there to its end."""
    lo = floats[KEY]
    hi = max(lo, min(floats[BEST], reach))
    for k in range(3):
        work[0, k], work[1, k] = sense * lo * motion[6 + k], sense * (hi - lo) * motion[6 + k]


def _lay_shifted_edge(motion, arc, x, y, reach, floats, origin, scale, query, work):
    _shifts(motion, 1.0, reach, floats, work)
    write_swept_edge(query, x, y, work[0], work[1], origin, scale)


def _lay_shifted_corner(motion, arc, x, sense, reach, floats, origin, scale, query, work):
    _shifts(motion, sense, reach, floats, work)
    write_segment(query, x, work[0], work[1], origin, scale)


# ------------------------------------------------------------------------------------------------- rotation


def _arc_of_rotation(motion, floats, arc):
    # products of whole numbers and the arc's angle round once; times are within ANGLE_EPS
    start = arc * ARC_ANGLE - 4.0 * ANGLE_EPS
    over = (arc + 1) * ARC_ANGLE + 4.0 * ANGLE_EPS < floats[FIRST]
    exists = arc < ARCS and start <= floats[BEST]
    if exists and not over:
        floats[KEY] = max(floats[KEY], start)
    return exists, over


@kernel
def _tangent(arc, floats):
    """tan of half the angle from the start of the arc to its end or the best time: not less, at most 0.2 or so.

    For x <= 0.2, x (1 + x^2/3 + 2 x^4/15 + 17 x^6/315 + 62 x^8/2835 + 0.0091 x^10) is beyond tan x.
    """
    x = 0.5 * (floats[BEST] - arc * ARC_ANGLE) + 8.0 * ANGLE_EPS
    if not x < 0.5 * ARC_ANGLE:
        return ARC_TANGENT * (1.0 + 1e-12)
    x = max(x, 8.0 * ANGLE_EPS)
    s = x * x
    p = 1.0 + s * (1.0 / 3.0 + s * (2.0 / 15.0 + s * (17.0 / 315.0 + s * (62.0 / 2835.0 + s * 0.0091))))
    return x * p * (1.0 + 1e-13)


@kernel
def _turned(x, c, s, cx, cy, place, out):
    """Write the point x, turned about (cx, cy), into row `place` of out, and its velocity there into the next."""
    p, q = x[0] - cx, x[1] - cy
    out[place, 0], out[place, 1], out[place, 2] = cx + (c * p - s * q), cy + (s * p + c * q), x[2]
    out[place + 1, 0], out[place + 1, 1], out[place + 1, 2] = -(s * p + c * q), c * p - s * q, 0.0


def _lay_turned_edge(motion, arc, x, y, reach, floats, origin, scale, query, work):
    end = motion.shape[0] - 1
    cx, cy = motion[end, 0], motion[end, 1]
    c, s = ARC_STARTS[arc, 0], ARC_STARTS[arc, 1]
    tc = _tangent(arc, floats)
    w = 1.0 / (1.0 + tc * tc)
    dc, ds = (1.0 - tc * tc) * w, 2.0 * tc * w
    _turned(x, c, s, cx, cy, 0, work)
    _turned(y, c, s, cx, cy, 2, work)
    _turned(work[0], dc, ds, cx, cy, 4, work)
    _turned(work[2], dc, ds, cx, cy, 6, work)
    write_turned_edge(query, work[0], work[2], work[1], work[3], work[4], work[6], tc, origin, scale)


def _lay_turned_corner(motion, arc, x, sense, reach, floats, origin, scale, query, work):
    end = motion.shape[0] - 1
    cx, cy = motion[end, 0], motion[end, 1]
    c, s = ARC_STARTS[arc, 0], sense * ARC_STARTS[arc, 1]
    tc = _tangent(arc, floats)
    w = 1.0 / (1.0 + tc * tc)
    dc, ds = (1.0 - tc * tc) * w, sense * 2.0 * tc * w
    _turned(x, c, s, cx, cy, 0, work)
    _turned(work[0], dc, ds, cx, cy, 2, work)
    for k in range(2):
        work[1, k] *= sense
    write_turned_point(query, work[0], work[1], work[2], tc, origin, scale)
