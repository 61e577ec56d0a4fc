"""Cutting the space that edges pass through: of each edge a cell holds the piece inside it.

Boxes of whole rods all overlap; those of pieces do not.  A cell is a box and an interval of time, with the edges of b
that enter the box, those of a that do so during the interval, and where along each edge.  Its long sides are halved
together as long as testing all its pairs would cost more; n rods in general position are so cut into about sqrt(n)
pieces each, and n^1.5 pairs are left.  Where pairs pass closely everywhere (`begin_space`), or cutting has only
multiplied them, lines tell more (`halving`).

Invariant: a contact at the point q, at a time not after the best one and not yet recorded, lies in a waiting cell that
holds q, on pieces of both edges.  Limits are moved out by the errors of coordinates and all roundings (`slack_of`).
"""

from __future__ import annotations

import math

import numpy as np

from firstcontact.kernels.jit import kernel, uncounted
from firstcontact.search.lifted.lifted_motion import PLACE, drift, place_at, times_of
from firstcontact.search.trees.state import BEST, STACK, VISITS

# Slots of a frame: ranges of a and of b in the arena, where the arena is free, what it is, pairs already tested, and
# how often its space was cut.
A_FIRST, A_LAST, B_FIRST, B_LAST, TOP, KIND, TESTED, DEPTH, FRAME = range(9)
# Kinds: cut by lines, or by space should that pay; cut by space; cut by lines, for space did not pay.
OPEN, SPACE, LINES_ONLY = range(3)
# Slots of a frame's cell: box, times, and how often it holds each pair by now (SPREAD).
FROM, TO, SPREAD, CELL = 6, 7, 8, 9
# A cell with i and j pieces is tested pair by pair when i j <= PAYS (i + j).
PAYS = 12
# Space does not pay where it has multiplied the pairs by so much, nor where boxes have been halved so often.
MOST_SPREAD, DEEPEST = 4.0, 50
# Sides longer than this share of the longest one are cut.
LONG = 0.6
# Parts of a cell at most.
PARTS = 8
# Time is halved where a moves farther during it than this share of the cell's longest side.
FAR = 0.5
# A frame of at least WORTH pairs is worth a look at SAMPLE^2 of them, of which this share may be close; cells of AGAIN
# times as many are looked at again.
WORTH, SAMPLE, CLOSE, AGAIN = 8192, 8, 0.5, 4
# Lengths that are very different.
DIFFERENT = 8.0
# Beyond the roundings of positions (an end, its pose, a difference, a product) beside the largest coordinate, and what
# the mathematical library may be off in sine and cosine, for which it gives no bound.
_ROUNDING, _TURNING = 2.0**-48, 1e-12


@kernel
def slack_of(a, b, motion, arc, reach, err, floats):
    """How much limits are moved out: twice the errors of coordinates, and roundings beside the largest of them."""
    place = np.empty(PLACE)
    size = 0.0
    for body in (a, b):
        for i in range(body.boxes.shape[0]):
            for k in range(6):
                size = max(size, abs(body.boxes[i, k]))
    for t in times_of(motion, arc, reach, floats):
        place_at(motion, t, place)
        for k in range(3, PLACE):  # shift and axis
            size = max(size, abs(place[k]))
    return 2.0 * err + (_ROUNDING + (_TURNING if place[0] != 0.0 else 0.0)) * 8.0 * size


@uncounted
def begin_space(a, b, room, here, motion, arc, reach, slack, floats, integers):
    """Make the frame a cell of space, the box of its edges of b, unless they pass closely everywhere.

    Nor where lengths differ much: few long ones that do so would be taken for none.
    """
    arena, frame, cell = room.arena, room.frames[here], room.cells[here]
    if _lengths_differ(a, arena, frame[A_FIRST], frame[A_LAST]) or _lengths_differ(
        b, arena, frame[B_FIRST], frame[B_LAST]
    ):
        return
    integers[VISITS] += SAMPLE * SAMPLE
    for k in range(3):
        cell[k], cell[k + 3] = np.inf, -np.inf
    for i in range(frame[B_FIRST], frame[B_LAST]):
        box = b.boxes[arena[i]]
        for k in range(3):
            cell[k], cell[k + 3] = min(cell[k], box[k] - slack), max(cell[k + 3], box[k + 3] + slack)
    cell[FROM], cell[TO] = times_of(motion, arc, reach, floats)
    cell[SPREAD] = 1.0
    if not _pass_closely(a, b, room, here, motion):
        frame[KIND], frame[DEPTH] = SPACE, 0
        for first, last in ((frame[A_FIRST], frame[A_LAST]), (frame[B_FIRST], frame[B_LAST])):
            for i in range(first, last):
                room.ends[i, 0], room.ends[i, 1] = 0.0, 1.0


@uncounted
def _lengths_differ(x, order, first, last):
    shortest, longest = np.inf, 0.0
    for i in range(first, last):
        size = x.sizes[order[i], 0]
        shortest, longest = min(shortest, size), max(longest, size)
    return longest > DIFFERENT * shortest


@uncounted
def _pass_closely(a, b, room, here, motion):
    """Whether many of some pairs are closer, or may come closer, than the cells that would tell them apart are wide."""
    arena, frame, cell = room.arena, room.frames[here], room.cells[here]
    m, n = frame[A_LAST] - frame[A_FIRST], frame[B_LAST] - frame[B_FIRST]
    near = _longest(cell) / math.sqrt(max(m, n)) + drift(motion, cell, cell[TO] - cell[FROM], room.way)
    place_at(motion, cell[FROM], room.place)
    close = 0
    for p in range(SAMPLE):
        edge = a.corners[arena[frame[A_FIRST] + p * m // SAMPLE]]
        for q in range(SAMPLE):
            close += _distance(edge, room.place, b.corners[arena[frame[B_FIRST] + q * n // SAMPLE]]) <= near
    return close > CLOSE * SAMPLE * SAMPLE


@uncounted
def _longest(cell):
    return max(cell[3] - cell[0], cell[4] - cell[1], cell[5] - cell[2])


@uncounted
def _ends(x, axis, place):
    """A coordinate of both ends of an edge (9,) of a in its place."""
    if place[0] == 0.0 or axis == 2:
        return x[axis] + place[5 + axis], x[axis + 3] + place[5 + axis]
    p, q, r, s = x[0] - place[3], x[1] - place[4], x[3] - place[3], x[4] - place[4]
    if axis == 0:
        return place[3] + (place[1] * p - place[2] * q), place[3] + (place[1] * r - place[2] * s)
    return place[4] + (place[2] * p + place[1] * q), place[4] + (place[2] * r + place[1] * s)


@uncounted
def _distance(x, place, y):
    """That of two edges, nearly: the nearest places on both lines, one after the other cut to their edges."""
    x0, x3 = _ends(x, 0, place)
    x1, x4 = _ends(x, 1, place)
    x2, x5 = _ends(x, 2, place)
    d0, d1, d2, e0, e1, e2 = x3 - x0, x4 - x1, x5 - x2, y[3] - y[0], y[4] - y[1], y[5] - y[2]
    w0, w1, w2 = x0 - y[0], x1 - y[1], x2 - y[2]
    dd, ee, de = d0 * d0 + d1 * d1 + d2 * d2, e0 * e0 + e1 * e1 + e2 * e2, d0 * e0 + d1 * e1 + d2 * e2
    dw, ew = d0 * w0 + d1 * w1 + d2 * w2, e0 * w0 + e1 * w1 + e2 * w2
    den = dd * ee - de * de
    s = min(1.0, max(0.0, (de * ew - ee * dw) / den)) if den > 0.0 else 0.0
    t = min(1.0, max(0.0, (ew + s * de) / ee)) if ee > 0.0 else 0.0
    s = min(1.0, max(0.0, (t * de - dw) / dd)) if dd > 0.0 else 0.0
    w0, w1, w2 = w0 + s * d0 - t * e0, w1 + s * d1 - t * e1, w2 + s * d2 - t * e2
    return math.sqrt(w0 * w0 + w1 * w1 + w2 * w2)


@uncounted
def cut_space(a, b, room, motion, slack, floats, integers):
    """Put the parts of the cell of the frame taken last in its place; False when there is no room for their lists."""
    here = integers[STACK]
    frame, cell = room.frames[here], room.cells[here]
    cell[TO] = min(cell[TO], floats[BEST])
    if cell[FROM] > cell[TO]:
        return True
    m, n = frame[A_LAST] - frame[A_FIRST], frame[B_LAST] - frame[B_FIRST]
    if m * n >= AGAIN * room.worth and frame[DEPTH] > 0:  # of several bundles each may pass closely
        integers[VISITS] += SAMPLE * SAMPLE
        if _pass_closely(a, b, room, here, motion):
            frame[KIND] = LINES_ONLY
            integers[STACK] = here + 1
            return True
    if drift(motion, cell, cell[TO] - cell[FROM], room.way) > FAR * _longest(cell):
        _halve_time(a, room, here, motion, slack)
        integers[VISITS] += 2 * m
        _keep_parts(room, here, 2, 2 * m * n, integers)
        return True
    place_at(motion, cell[FROM], room.place)
    parts = _divide(cell, room, slack)
    room.counts[:] = 0
    of_a = _share_out(a.corners, room, frame[A_FIRST], frame[A_LAST], room.place, 0, 0)
    total = _share_out(b.corners, room, frame[B_FIRST], frame[B_LAST], room.rest, 1, of_a)
    if frame[TOP] + total > room.arena.shape[0]:
        return False
    _write_parts(room, here, parts, of_a, total)
    integers[VISITS] += m + n
    _keep_parts(room, here, parts, m * n, integers)
    return True


@uncounted
def _divide(cell, room, slack):
    """Choose where the long sides are cut, and the limits of a and of b below and above; returns how many parts."""
    longest, parts = _longest(cell), 1
    for k in range(3):
        cut = room.cuts[k]
        cut[0] = 0.0
        if cell[k + 3] - cell[k] > LONG * longest:
            middle = cell[k] + 0.5 * (cell[k + 3] - cell[k])
            cut[0], cut[1] = parts, middle
            cut[2], cut[3] = middle - room.way[k] + slack, middle - room.way[k + 3] - slack
            cut[4], cut[5] = middle + slack, middle - slack
            parts *= 2
    return parts


@uncounted
def _share_out(corners, room, first, last, place, side, used):
    """Append the pieces of a list in each part to the spare list, from `used` on; returns where they end.

    The number of a part has the bit of an axis where it lies above the middle.
    """
    arena, ends, spare, pieces, where = room.arena, room.ends, room.spare, room.pieces, room.where
    for i in range(first, last):
        edge, count = arena[i], 1
        pieces[used, 0], pieces[used, 1], where[used] = ends[i, 0], ends[i, 1], 0
        for k in range(3):
            cut = room.cuts[k]
            if cut[0] == 0.0:
                continue
            x, y = _ends(corners[edge], k, place)
            d, low, high = y - x, cut[2 + 2 * side], cut[3 + 2 * side]
            below, above = (low - x) / d, (high - x) / d
            for p in range(used, used + count):
                u0 = v0 = pieces[p, 0]
                u1 = v1 = pieces[p, 1]
                if d > 0.0:
                    u1, v0 = min(u1, below), max(v0, above)
                elif d < 0.0:
                    u0, v1 = max(u0, below), min(v1, above)
                else:
                    u1, v1 = u1 if x <= low else -1.0, v1 if x >= high else -1.0
                if u0 <= u1:
                    pieces[p, 0], pieces[p, 1] = u0, u1
                    if v0 <= v1:
                        q = used + count
                        pieces[q, 0], pieces[q, 1], where[q] = v0, v1, where[p] + int(cut[0])
                        count += 1
                else:  # none at all where v0 > v1, which stays so
                    pieces[p, 0], pieces[p, 1], where[p] = v0, v1, where[p] + int(cut[0])
        kept = used
        for p in range(used, used + count):
            if pieces[p, 0] <= pieces[p, 1]:
                spare[kept], where[kept] = edge, where[p]
                pieces[kept, 0], pieces[kept, 1] = pieces[p, 0], pieces[p, 1]
                room.counts[side, where[kept]] += 1
                kept += 1
        used = kept
    return used


@kernel
def _write_parts(room, here, parts, of_a, total):
    """Sort the spare list into the lists of the parts, and write their frames and cells."""
    top = room.frames[here, TOP]
    used = top
    for part in range(parts - 1, -1, -1):
        frame, cell = room.frames[here + part], room.cells[here + part]
        frame[:], cell[:] = room.frames[here], room.cells[here]
        for k in range(3):
            cut = room.cuts[k]
            if cut[0] != 0.0:
                cell[k if part & int(cut[0]) else k + 3] = cut[1]
        for side in range(2):
            slot = A_FIRST if side == 0 else B_FIRST
            frame[slot] = frame[slot + 1] = used
            used += room.counts[side, part]
    for part in range(parts):
        room.frames[here + part, TOP] = used
    for i in range(total):
        slot = A_LAST if i < of_a else B_LAST
        at = room.frames[here + room.where[i], slot]
        room.arena[at], room.ends[at, 0], room.ends[at, 1] = room.spare[i], room.pieces[i, 0], room.pieces[i, 1]
        room.frames[here + room.where[i], slot] = at + 1


@kernel
def _halve_time(a, room, here, motion, slack):
    """The later half first, for the other one is taken first; to both what of a enters the box during it."""
    arena, ends, frames, cells, way = room.arena, room.ends, room.frames, room.cells, room.way
    frames[here + 1, :], cells[here + 1, :] = frames[here], cells[here]
    first, last, used = frames[here, A_FIRST], frames[here, A_LAST], frames[here, TOP]
    middle = cells[here, FROM] + 0.5 * (cells[here, TO] - cells[here, FROM])
    cells[here, FROM], cells[here + 1, TO] = middle, middle
    for half in range(2):
        cell = cells[here + half]
        place_at(motion, cell[FROM], room.place)
        drift(motion, cell, cell[TO] - cell[FROM], way)
        frames[here + half, A_FIRST] = used
        for i in range(first, last):
            x, s0, s1 = a.corners[arena[i]], ends[i, 0], ends[i, 1]
            for k in range(3):
                p, q = _ends(x, k, room.place)
                d, low, high = q - p, cell[k] - way[k + 3] - slack, cell[k + 3] - way[k] + slack
                if d > 0.0:
                    s0, s1 = max(s0, (low - p) / d), min(s1, (high - p) / d)
                elif d < 0.0:
                    s0, s1 = max(s0, (high - p) / d), min(s1, (low - p) / d)
                elif p < low or p > high:
                    s1 = -1.0
            if s0 <= s1:
                arena[used], ends[used, 0], ends[used, 1] = arena[i], s0, s1
                used += 1
        frames[here + half, A_LAST] = used
    frames[here, TOP] = frames[here + 1, TOP] = used


@kernel
def _keep_parts(room, here, parts, before, integers):
    """Leave the parts with edges of both bodies on the stack; `before`: the pairs there were."""
    frames, cells = room.frames, room.cells
    pairs, waiting = 0, here
    for i in range(here, here + parts):
        count = (frames[i, A_LAST] - frames[i, A_FIRST]) * (frames[i, B_LAST] - frames[i, B_FIRST])
        if count > 0:
            frames[waiting, :], cells[waiting, :] = frames[i], cells[i]
            pairs += count
            waiting += 1
    for i in range(here, waiting):
        cells[i, SPREAD] = max(1.0, cells[i, SPREAD] * pairs / before)
        frames[i, TESTED] = 0
        frames[i, DEPTH] += 1
        if cells[i, SPREAD] > MOST_SPREAD or frames[i, DEPTH] >= DEEPEST:
            frames[i, KIND] = LINES_ONLY
    integers[STACK] = waiting
