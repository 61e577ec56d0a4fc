"""Paths of points against facets by halving both sets in turn, leaving out at each step what certainly does not meet.

A path is that of a vertex during the arc, or at the start an edge; it lies in the hull of two points, or of three for
an arc of a circle.  As with edges (`halving`), a half, as a cell, can be met by a part of the other set only.  A cell
of facets is a box, a box of planes and one of side lines, put to each path; a cell of paths is two or three boxes, put
to each facet by separating axes: its normal, and the directions across its sides and the way of the paths.  Under a
rotation height and distance from the axis tell more: those of a vertex do not change at all.

Which set is cut is learnt on the way: the one whose cutting left least of the other.  Vertices stand in random order,
and a small share of them goes first, then a larger one: the best time they find leaves little to do for all the others
(Chan 1999, "Geometric applications of a randomized optimization technique").
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from firstcontact.kernels.jit import kernel, uncounted
from firstcontact.kernels.lifted.principal import box_columns, fit_box
from firstcontact.kernels.lifted.query import (
    LINES,
    PLANES,
    REACH,
    ROWS,
    line_slack,
    may_meet,
    one_sign,
    write_segment,
)
from firstcontact.kernels.lifted.swept_cell import (
    HULLS,
    PATH_ROWS,
    WHOLE,
    begin_cell,
    facet_may_meet,
    put_path,
    turns,
)
from firstcontact.kernels.selection import select
from firstcontact.search.lifted.halving import (
    A_FIRST,
    A_LAST,
    B_FIRST,
    B_LAST,
    FEW_PAIRS,
    GO_ON,
    TOP,
    second_moments,
    why_pause,
)
from firstcontact.search.lifted.lifted_motion import lay_corner, lay_path, test_pair
from firstcontact.search.trees.state import (
    CROSSING_FOUND,
    CROWDED,
    DONE,
    QUERY,
    STACK,
    VISITS,
)
from firstcontact.search.trees.tree import SIDE
from firstcontact.search.trees.walk import meet_at_start

# The first share of the vertices, and how much larger each next one is.
FIRST_SHARE, SHARES = 8, 16
# What a set is believed to leave of the other one fades by this much at each step in which the other set is cut.
FADING = 0.98


class FacetTables(NamedTuple):
    """The facets of a body: two side lines each (2m, 6), planes (m, 4), boxes (m, 6), sizes (m, 3), corners (m, 9)."""

    lines: np.ndarray
    planes: np.ndarray
    boxes: np.ndarray
    sizes: np.ndarray
    corners: np.ndarray
    parts: np.ndarray


class Paths(NamedTuple):
    """Vertices, or edges at the start: corners (m, 9), lines (m, 6) of the edges, parts (m, 2)."""

    corners: np.ndarray
    lines: np.ndarray
    parts: np.ndarray


@kernel
def halve_facets(paths, facets, origin, scale, room, still, swapped, motion, arc, reach, xyz_a, xyz_b, err_a, err_b,
                 limit, floats, integers, times, candidates):  # fmt: skip
    """Go on with all pairs of path and facet; returns why it stopped.  STACK counts the frames that wait.

    still: edges against the facets they pierce at the start.  swapped: the paths are of b, the facets of a.
    """
    arena, frames, shares = room.arena, room.frames, room.shares
    m, n = paths.parts.shape[0], facets.parts.shape[0]
    if m == 0 or n == 0:
        return DONE
    if integers[QUERY] == 0:
        _begin(m, n, not still and arc == 0, room, integers)
    query, work = np.zeros((ROWS, 6)), np.empty((8, 3))
    row, cell = np.zeros(PLANES + box_columns(4)), np.zeros((PATH_ROWS, 6))
    scratch = np.empty((6, 6)), np.empty((6, 6)), np.empty((3, 6))
    planes = np.empty((4, 4)), np.empty((4, 4)), np.empty((3, 4))
    sense, err = -1.0 if swapped else 1.0, err_a + err_b
    sided = still or not turns(motion)  # of straight paths the side lines tell, too
    while integers[STACK] > 0:
        reason = why_pause(integers, times.shape[0], limit, FEW_PAIRS)
        if reason != GO_ON:
            return reason
        here = integers[STACK] - 1
        frame = frames[here]
        a0, b0 = frame[A_FIRST], frame[B_FIRST]
        m, n = frame[A_LAST] - a0, frame[B_LAST] - b0
        if m * n <= FEW_PAIRS or m == 1:
            count = min(n, FEW_PAIRS) if m == 1 else n
            if count == n:
                integers[STACK] = here
            else:
                frame[B_FIRST] += count
            for p in range(m * count):
                i, j = arena[a0 + p // count], arena[b0 + p % count]
                a, b = (facets.parts[j], paths.parts[i]) if swapped else (paths.parts[i], facets.parts[j])
                if still:
                    if meet_at_start(a[0], a[1], xyz_a[a[0]], b[0], b[1], xyz_b[b[0]], err_a, err_b,
                                     floats, integers, times, candidates):  # fmt: skip
                        return CROSSING_FOUND
                else:
                    test_pair(motion, a[0], a[1], xyz_a[a[0]], b[0], b[1], xyz_b[b[0]], 1 << SIDE, err_a, err_b,
                                floats, integers, times, candidates)  # fmt: skip
            continue
        if frame[TOP] + 2 * (m + n) > arena.shape[0]:
            return CROWDED
        cut_paths = shares[here, 0] < shares[here, 1] or (shares[here, 0] == shares[here, 1] and m >= n)
        x_slot, y_slot = (A_FIRST, B_FIRST) if cut_paths or n == 1 else (B_FIRST, A_FIRST)
        first, last, y0, y1 = frame[x_slot], frame[x_slot + 1], frame[y_slot], frame[y_slot + 1]
        reason = why_pause(integers, times.shape[0], limit, 2 * (y1 - y0))
        if reason != GO_ON:
            return reason
        top, count = frame[TOP], last - first
        for i in range(count):
            arena[top + i] = arena[first + i]
        integers[STACK] = here
        kept = 0
        used = top + count
        if x_slot == A_FIRST:
            _cut_paths(paths, room, top, count, still, motion, arc, sense, reach, floats, cell, work)
        else:
            _cut_facets(facets, paths, room, top, count, y0, y1, scale, origin, scratch)
        waiting = here
        for half in range(2):
            first, last = (top, top + count // 2) if half == 0 else (top + count // 2, top + count)
            begin = used
            if x_slot == A_FIRST:
                _write_path_cell(paths, arena, first, last, still, motion, arc, sense, reach, floats, cell, work)
                if still:
                    one, lines = np.int64(1), np.int64(LINES)
                    fit_box(paths.lines, arena, first, last, one, row, lines, scratch[0], scratch[1], scratch[2])
                for k in range(y0, y1):
                    if not facet_may_meet(cell, facets.corners[arena[k]], err):
                        continue
                    if still and _passes_by(row, cell, facets, arena[k], query, origin, scale, err):
                        continue
                    arena[used] = arena[k]
                    used += 1
            else:
                _write_facet_cell(facets, arena, first, last, sided, row, scratch, planes)
                for k in range(y0, y1):
                    x = paths.corners[arena[k]]
                    if still:
                        for c in range(3):
                            work[0, c], work[1, c] = 0.0, x[3 + c] - x[c]
                        write_segment(query, x[0:3], work[0], work[1], origin, scale)
                    else:
                        lay_corner(motion, arc, x[0:3], sense, reach, floats, origin, scale, query, work)
                    if may_meet(row, query, True, scale, origin, err):
                        arena[used] = arena[k]
                        used += 1
            integers[VISITS] += y1 - y0
            kept += used - begin
            if used > begin:
                frame = frames[waiting]
                frame[x_slot], frame[x_slot + 1], frame[y_slot], frame[y_slot + 1] = first, last, begin, used
                frame[TOP] = used
                waiting += 1
        mine, other = (0, 1) if x_slot == A_FIRST else (1, 0)
        left, faded = kept / (y1 - y0), FADING * shares[here, other]
        for i in range(here, waiting):
            shares[i, mine], shares[i, other] = left, faded
        integers[STACK] = waiting
    return DONE


@uncounted
def _begin(m, n, sampling, room, integers):
    """One frame of everything, and behind it, to be taken first, those of the first few paths."""
    for i in range(m + n):
        room.arena[i] = i if i < m else i - m
    count, waiting = FIRST_SHARE, 1
    while sampling and count * SHARES <= m:
        count, waiting = count * SHARES, waiting + 1
    taken = m
    for k in range(waiting):
        frame = room.frames[k]
        frame[A_FIRST], frame[A_LAST], frame[B_FIRST], frame[B_LAST], frame[TOP] = 0, taken, m, m + n, m + n
        room.shares[k, 0], room.shares[k, 1] = 0.0, 0.0
        taken, count = count, count // SHARES
    integers[STACK], integers[QUERY] = waiting, 1


# ------------------------------------------------------------------------------------------ cells of paths


@uncounted
def _lay(paths, i, still, motion, arc, sense, reach, floats, work):
    """Write the corners of the hull of path i into the first rows of work; their number."""
    x = paths.corners[i]
    if still:
        for c in range(3):
            work[0, c], work[1, c] = x[c], x[3 + c]
        return 2
    return lay_path(motion, arc, x[0:3], sense, reach, floats, work)


@uncounted
def _write_path_cell(paths, order, first, last, still, motion, arc, sense, reach, floats, cell, work):
    begin_cell(cell, still, motion)
    for i in range(first, last):
        corners = _lay(paths, order[i], still, motion, arc, sense, reach, floats, work)
        put_path(cell, work, corners)


@uncounted
def _cut_paths(paths, room, top, count, still, motion, arc, sense, reach, floats, cell, work):
    """Across the coordinate, of the first or the last corner of the hulls, in which they differ most."""
    arena, keys = room.arena, room.keys
    _write_path_cell(paths, arena, top, top + count, still, motion, arc, sense, reach, floats, cell, work)
    widest, corner, axis = -1.0, 0, 0
    for c in range(2):
        box = cell[int(cell[HULLS, 0]) - 1 if c else 0]
        for k in range(3):
            if box[k + 3] - box[k] > widest:
                widest, corner, axis = box[k + 3] - box[k], c, k
    for i in range(count):
        corners = _lay(paths, arena[top + i], still, motion, arc, sense, reach, floats, work)
        keys[i] = work[corners - 1 if corner else 0, axis]
    select(keys, arena[top : top + count], 0, count, count // 2)


@uncounted
def _passes_by(row, cell, facets, j, query, origin, scale, err):
    """Whether the lines of all edges of the cell pass both longer sides of the facet on one side."""
    e = 0.0
    for g in range(2):
        y = facets.lines[2 * j + g]
        for k in range(3):
            query[g, k], query[g, k + 3] = y[k + 3], y[k]
        e = max(e, abs(y[0]) + abs(y[1]) + abs(y[2]))
    far, reach, whole = facets.sizes[j, 1], 0.0, cell[WHOLE]
    for k in range(3):
        far = max(far, abs(whole[k] - origin[k]), abs(whole[k + 3] - origin[k]))
        reach += max(cell[1, k + 3] - cell[0, k], cell[0, k + 3] - cell[1, k])
    return one_sign(row, LINES, 6, query, 0, 2, line_slack(far, reach, e, scale, err))


# ----------------------------------------------------------------------------------------- cells of facets


@uncounted
def _write_facet_cell(facets, order, first, last, sided, row, scratch, planes):
    for k in range(3):
        row[k], row[k + 3], row[REACH + k] = np.inf, -np.inf, 0.0
    for i in range(first, last):
        b, size = facets.boxes[order[i]], facets.sizes[order[i]]
        for k in range(3):
            row[k], row[k + 3] = min(row[k], b[k]), max(row[k + 3], b[k + 3])
            row[REACH + k] = max(row[REACH + k], size[k])
    if sided:
        fit_box(facets.lines, order, first, last, np.int64(2), row, np.int64(LINES), scratch[0], scratch[1], scratch[2])
    fit_box(facets.planes, order, first, last, np.int64(1), row, np.int64(PLANES), planes[0], planes[1], planes[2])


@uncounted
def _cut_facets(facets, paths, room, top, count, y0, y1, scale, origin, scratch):
    """Across the form in the planes that varies most for the places of the paths."""
    arena, keys = room.arena, room.keys
    vary, weigh, vectors = scratch[0], scratch[1], scratch[2]
    form, turned = vectors[0], vectors[1]
    second_moments(facets.planes, arena, top, top + count, True, vary, form)
    _moments_of_places(paths, arena, y0, y1, origin, scale, weigh, form)
    for k in range(4):
        form[k] = 1.0 / (1.0 + k)
    for _ in range(12):
        largest = 0.0
        for j in range(4):
            turned[j] = 0.0
            for k in range(4):
                turned[j] += vary[j, k] * form[k]
        for j in range(4):
            form[j] = 0.0
            for k in range(4):
                form[j] += weigh[j, k] * turned[k]
            largest = max(largest, abs(form[j]))
        if not 0.0 < largest < np.inf:
            break
        for k in range(4):
            form[k] /= largest
    for i in range(count):
        s = 0.0
        for k in range(4):
            s += form[k] * facets.planes[arena[top + i], k]
        keys[i] = s
    select(keys, arena[top : top + count], 0, count, count // 2)


@uncounted
def _moments_of_places(paths, order, first, last, origin, scale, moments, place):
    """Second moments of (x - origin, 1) / scale of a sample, as they stand."""
    step = max(1, (last - first) // 64)
    for j in range(4):
        for k in range(4):
            moments[j, k] = 0.0
    place[3] = 1.0
    for i in range(first, last, step):
        x = paths.corners[order[i]]
        for k in range(3):
            place[k] = (x[k] - origin[k]) / scale
        for j in range(4):
            for k in range(4):
                moments[j, k] += place[j] * place[k]
