"""Edges against edges by halving both sets in turn, leaving out at each step what is certainly not met.

Edges that do not pass closely everywhere are told apart by the space they pass through (`space_cut`), all others so:
A frame is a set of edges of a and one of b.  The larger set is cut in two; each half, as a cell (box and box of
lines), can be met by a part of the other set only.  The cut goes across the direction in which the products of its
lines with those of the other set vary most: what is left lies near the few surfaces on which these products vanish, and
is to be cut as thin across them as its cells bend along them.  Then each halving of either set shrinks the other by
2^(-1/d) in d effective dimensions, and T(n) = 4 T(n / 2^(1 + 1/d)) + O(n) is the n^(2d/(d+1)) of cuttings (Schoemer
& Thiel 1995, section 5: n^(8/5) for d = 4), where a tree with cells fixed in advance tests n^(2 - 1/d) pairs.  That is
what is measured, not proved: nothing bounds how good the cells are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from firstcontact.kernels.jit import kernel, uncounted
from firstcontact.kernels.lifted.principal import box_columns, fit_box
from firstcontact.kernels.lifted.query import E_FORMS, L_QUERY, LINES, N_FORMS, REACH, ROWS, SIZES, line_slack, may_meet
from firstcontact.kernels.lifted.swept_cell import axis_of, edge_keeps_off
from firstcontact.kernels.selection import select
from firstcontact.search.lifted.lifted_motion import PLACE, lay_edge, test_pair
from firstcontact.search.lifted.space_cut import (
    A_FIRST,
    A_LAST,
    B_FIRST,
    B_LAST,
    CELL,
    DIFFERENT,
    FRAME,
    KIND,
    OPEN,
    PARTS,
    PAYS,
    SPACE,
    TESTED,
    TOP,
    WORTH,
    begin_space,
    cut_space,
    slack_of,
)
from firstcontact.search.trees.state import (
    ALLOWED,
    BEYOND,
    CANDIDATES,
    CROWDED,
    DECIDE,
    DONE,
    FULL,
    LEAF_ROOM,
    QUERY,
    SLICE_SPENT,
    STACK,
    TESTS,
    UNSURE_BATCH,
    UNSURE_COUNT,
    VISITS,
)
from firstcontact.search.trees.tree import SIDE
from firstcontact.work import doubled

# A frame of at most so many pairs is tested pair by pair.
FEW_PAIRS = 64
# No reason to come back: none of those of `state`.
GO_ON = -2
# One pair of edges in so many is tested before anything is cut, per edge of the larger set.
SAMPLE_SHARE = 8
# Each frame copies the set that it cuts, and the other one twice at most: three times the larger set, which every
# second step halves.  So no path takes more than 12 times the larger set, but for odd halves, nor more frames than
# there are halvings of both sets.
ARENA_SHARE, ARENA_LEAST, MOST_FRAMES = 13, 2048, 512
_SAMPLE = 64


class Edges(NamedTuple):
    """The edges of a body: lines (m, 6) and sizes (m, 3) about the common origin, boxes (m, 6), ends (m, 9), parts."""

    lines: np.ndarray
    boxes: np.ndarray
    sizes: np.ndarray
    corners: np.ndarray
    parts: np.ndarray
    distances: np.ndarray
    """(m, 2) least and largest distance from the axis of a rotation, else (0, 2)."""


class Room(NamedTuple):
    """Scratch of a search: edges by number, their keys, and the stack of frames."""

    arena: np.ndarray
    ends: np.ndarray
    """(len(arena), 2): in cells of space, where the piece of the edge begins and ends."""
    keys: np.ndarray
    frames: np.ndarray
    shares: np.ndarray
    bounds: np.ndarray
    cells: np.ndarray
    place: np.ndarray
    rest: np.ndarray
    """Where a stands, and where b does, as in `place_at`."""
    way: np.ndarray
    spare: np.ndarray
    """Pieces on their way to the parts of a cell, `pieces`, the parts they go to, how many do, and where it is cut."""
    pieces: np.ndarray
    where: np.ndarray
    counts: np.ndarray
    cuts: np.ndarray
    block: np.ndarray
    """(9, FEW_PAIRS): lines, entry by entry, and the range of their products with the forms of an edge."""
    pays: int = PAYS
    worth: int = WORTH
    """Of `space_cut`; smaller where a test wants space cut to the last."""


def larger(room: Room) -> Room:
    """With twice the room for lists."""
    arena, ends = doubled(room.arena, room.ends)
    return room._replace(arena=arena, ends=ends)


def room_for(m: int, n: int) -> Room:
    size = m + n + ARENA_SHARE * max(m, n) + ARENA_LEAST
    frames, shares = np.zeros((MOST_FRAMES, FRAME), np.int64), np.zeros((MOST_FRAMES, 2))
    most = PARTS * (m + n)
    return Room(
        np.empty(size, np.int32), np.empty((size, 2)), np.empty(max(m, n)), frames, shares, np.empty((2, 3)),
        np.empty((MOST_FRAMES, CELL)), np.empty(PLACE), np.zeros(PLACE), np.empty(6),
        np.empty(most, np.int32), np.empty((most, 2)), np.empty(most, np.int8),
        np.zeros((2, PARTS), np.int64), np.empty((3, 6)), np.empty((9, FEW_PAIRS)),
    )  # fmt: skip


@uncounted
def why_pause(integers, room, limit, cost):
    """GO_ON, or the reason to come back before the next frame: no room for its candidates, doubts, the limit, and that
    so many visits and tests more are not allowed."""
    if integers[CANDIDATES] + 2 * FEW_PAIRS + LEAF_ROOM > room:
        return FULL
    if integers[UNSURE_COUNT] >= UNSURE_BATCH:
        return DECIDE
    if integers[VISITS] >= limit:
        return SLICE_SPENT
    if 0 < integers[ALLOWED] < integers[VISITS] + integers[TESTS] + cost:
        return BEYOND
    return GO_ON


@kernel
def halve(a, b, origin, scale, room, motion, arc, reach, xyz_a, xyz_b, err_a, err_b, limit,
          floats, integers, times, candidates):  # fmt: skip
    """Go on with all pairs of edges; returns why it stopped.  STACK counts the frames that wait."""
    arena, frames = room.arena, room.frames
    m, n = a.parts.shape[0], b.parts.shape[0]
    if m == 0 or n == 0:
        return DONE
    if integers[QUERY] == 0:
        for i in range(m + n):
            arena[i] = i if i < m else i - m
        frames[0, :] = 0
        frames[0, A_LAST], frames[0, B_FIRST], frames[0, B_LAST], frames[0, TOP] = m, m, m + n, m + n
        integers[STACK], integers[QUERY] = 1, 1
    # pairs at random, for both sets are in random order, bound the best time from the beginning
    samples = max(m, n) // SAMPLE_SHARE if arc == 0 else 0
    row, query, work = np.zeros(LINES + box_columns(6)), np.zeros((ROWS, 6)), np.empty((8, 3))
    scratch = np.empty((6, 6)), np.empty((6, 6)), np.empty((3, 6))
    err = err_a + err_b
    slack = slack_of(a, b, motion, arc, reach, err, floats)
    while integers[STACK] > 0:
        reason = why_pause(integers, times.shape[0], limit, FEW_PAIRS)
        if reason != GO_ON:
            return reason
        done = integers[QUERY] - 1
        if done < samples:
            _test_samples(a, b, done, min(samples - done, FEW_PAIRS), motion, xyz_a, xyz_b, err_a, err_b,
                          floats, integers, times, candidates)  # fmt: skip
            continue
        here = integers[STACK] - 1
        frame = frames[here]
        m, n = frame[A_LAST] - frame[A_FIRST], frame[B_LAST] - frame[B_FIRST]
        if m * n <= FEW_PAIRS or (frame[KIND] == SPACE and m * n <= room.pays * (m + n)):
            reason = _test_pairs(a, b, room, here, origin, scale, query, work, motion, arc, reach,
                                 xyz_a, xyz_b, err_a, err_b, limit, floats, integers, times, candidates)  # fmt: skip
            if reason != GO_ON:
                return reason
            integers[STACK] = here
            continue
        if frame[TOP] + 2 * (m + n) > arena.shape[0]:
            return CROWDED
        cost = m + n if frame[KIND] == SPACE else 2 * min(m, n)
        reason = why_pause(integers, times.shape[0], limit, cost)
        if reason != GO_ON:
            return reason
        if frame[KIND] == OPEN and m * n >= room.worth:
            begin_space(a, b, room, here, motion, arc, reach, slack, floats, integers)
        integers[STACK] = here
        if frame[KIND] == SPACE:
            if not cut_space(a, b, room, motion, slack, floats, integers):
                integers[STACK] = here + 1
                return CROWDED
            continue
        cut_a = m >= n
        x, y = (a, b) if cut_a else (b, a)
        _split(x, A_FIRST if cut_a else B_FIRST, y, B_FIRST if cut_a else A_FIRST, -1.0 if cut_a else 1.0, origin,
               scale, room, row, scratch, query, work, motion, arc, reach, err, floats, integers)  # fmt: skip
    return DONE


@uncounted
def _test_samples(a, b, done, count, motion, xyz_a, xyz_b, err_a, err_b, floats, integers, times, candidates):
    """Test so many pairs after those that are done, each edge of the smaller set in turn with several of the other."""
    m, n = a.parts.shape[0], b.parts.shape[0]
    integers[QUERY] += count
    for p in range(done, done + count):
        part_a, part_b = a.parts[p % m], b.parts[p % n]
        test_pair(
            motion, part_a[0], part_a[1], xyz_a[part_a[0]], part_b[0], part_b[1], xyz_b[part_b[0]],
            1 << SIDE, err_a, err_b, floats, integers, times, candidates,
        )  # fmt: skip


@uncounted
def _test_pairs(a, b, room, here, origin, scale, query, work, motion, arc, reach,
                xyz_a, xyz_b, err_a, err_b, limit, floats, integers, times, candidates):  # fmt: skip
    """Test the pairs of the frame but those whose lines pass on one side all the time; GO_ON, or why it stopped.

    The edges of the smaller set are put to the lines of the other one, up to FEW_PAIRS of them together.
    """
    arena, frame, block = room.arena, room.frames[here], room.block
    by_a = frame[A_LAST] - frame[A_FIRST] <= frame[B_LAST] - frame[B_FIRST]
    x, x0, x1 = (a, frame[A_FIRST], frame[A_LAST]) if by_a else (b, frame[B_FIRST], frame[B_LAST])
    y, y0, y1 = (b, frame[B_FIRST], frame[B_LAST]) if by_a else (a, frame[A_FIRST], frame[A_LAST])
    m, written = x1 - x0, -1
    while frame[TESTED] < m * ((y1 - y0 + FEW_PAIRS - 1) // FEW_PAIRS):
        reason = why_pause(integers, times.shape[0], limit, FEW_PAIRS)
        if reason != GO_ON:
            return reason
        first = y0 + FEW_PAIRS * (frame[TESTED] // m)
        count = min(FEW_PAIRS, y1 - first)
        if written != first:
            written, far, longest = first, 0.0, 0.0
            for j in range(count):
                line, size = y.lines[arena[first + j]], y.sizes[arena[first + j]]
                far, longest = max(far, size[1]), max(longest, size[0])
                for k in range(6):
                    block[k, j] = line[k]
        edge = arena[x0 + frame[TESTED] % m]
        e = x.corners[edge]
        lay_edge(motion, arc, e[0:3], e[3:6], 1.0 if by_a else -1.0, reach, floats, origin, scale, query, work)
        sizes = query[SIZES]
        slack = line_slack(max(far, sizes[L_QUERY]), longest, sizes[E_FORMS], scale, err_a + err_b)
        _products(block, query, count, int(sizes[N_FORMS]))
        before = integers[TESTS]
        for j in range(count):
            if (block[6, j] > slack or block[7, j] < -slack) and block[8, j] == 0.0:
                continue
            i, k = (edge, arena[first + j]) if by_a else (arena[first + j], edge)
            part_a, part_b = a.parts[i], b.parts[k]
            test_pair(
                motion, part_a[0], part_a[1], xyz_a[part_a[0]], part_b[0], part_b[1], xyz_b[part_b[0]],
                1 << SIDE, err_a, err_b, floats, integers, times, candidates,
            )  # fmt: skip
        integers[TESTS] = max(integers[TESTS], before + count)  # a pair counts once, whatever settled it
        frame[TESTED] += 1
    return GO_ON


@uncounted
def _products(block, query, count, forms):
    """Write the least and the largest product of each line with the forms, and 0 if all are finite."""
    low, high, finite = block[6], block[7], block[8]
    for j in range(count):
        low[j], high[j], finite[j] = np.inf, -np.inf, 0.0
    for r in range(forms):
        q0, q1, q2, q3, q4, q5 = query[r, 0], query[r, 1], query[r, 2], query[r, 3], query[r, 4], query[r, 5]
        for j in range(count):
            v = (q0 * block[0, j] + q1 * block[1, j] + q2 * block[2, j]) + (
                q3 * block[3, j] + q4 * block[4, j] + q5 * block[5, j]
            )
            low[j] = v if v < low[j] else low[j]
            high[j] = v if v > high[j] else high[j]
            finite[j] += v - v


@uncounted
def _split(x, x_slot, y, y_slot, sense, origin, scale, room, row, scratch, query, work,
           motion, arc, reach, err, floats, integers):  # fmt: skip
    """Cut the set x of the frame taken last, and push one for each half with what of y may meet it.

    sense: that of the motion of y past x.
    """
    arena, frames = room.arena, room.frames
    frame = frames[integers[STACK]]
    x0, x1, y0, y1, top = frame[x_slot], frame[x_slot + 1], frame[y_slot], frame[y_slot + 1], frame[TOP]
    count, kind = x1 - x0, frame[KIND]
    for i in range(count):
        arena[top + i] = arena[x0 + i]
    if not _cut_by_size(x, top, count, room):
        _cut(x.lines, top, count, y.lines, y0, y1, room, scratch)
    cx, cy = axis_of(motion)
    used = top + count
    for half in range(2):
        first, last = (top, top + count // 2) if half == 0 else (top + count // 2, top + count)
        _write_cell(x, arena, first, last, row, scratch)
        nearest, farthest = _range_of_distances(x, arena, first, last)
        begin = used
        for k in range(y0, y1):
            e = y.corners[arena[k]]
            if farthest >= 0.0 and edge_keeps_off(e, row[2], row[5], nearest, farthest, cx, cy, err):
                continue
            lay_edge(motion, arc, e[0:3], e[3:6], sense, reach, floats, origin, scale, query, work)
            if may_meet(row, query, False, scale, origin, err):
                arena[used] = arena[k]
                used += 1
        integers[VISITS] += y1 - y0
        if used > begin:
            frame = frames[integers[STACK]]
            frame[x_slot], frame[x_slot + 1], frame[y_slot], frame[y_slot + 1] = first, last, begin, used
            frame[TOP], frame[KIND], frame[TESTED] = used, kind, 0
            integers[STACK] += 1


@uncounted
def _write_cell(x, order, first, last, row, scratch):
    """The cell of the edges order[first:last] in the form of a node of a lifted tree."""
    for k in range(3):
        row[k], row[k + 3], row[REACH + k] = np.inf, -np.inf, 0.0
    for i in range(first, last):
        b, size = x.boxes[order[i]], x.sizes[order[i]]
        for k in range(3):
            row[k], row[k + 3] = min(row[k], b[k]), max(row[k + 3], b[k + 3])
            row[REACH + k] = max(row[REACH + k], size[k])
    fit_box(x.lines, order, first, last, np.int64(1), row, np.int64(LINES), scratch[0], scratch[1], scratch[2])


@uncounted
def _range_of_distances(x, order, first, last):
    """(least, largest) distance from the axis in order[first:last]; the largest is -1 where nothing turns."""
    nearest, farthest = np.inf, -1.0
    if x.distances.shape[0]:
        for i in range(first, last):
            d = x.distances[order[i]]
            nearest, farthest = min(nearest, d[0]), max(farthest, d[1])
    return nearest, farthest


@uncounted
def _cut_by_size(x, top, count, room):
    """Cut edges of very different length by length, and edges that are short beside their box across it; or neither.

    Lines tell long edges apart, boxes those that are so much shorter than they; in a cell with both, neither do.
    """
    arena, keys = room.arena, room.keys
    low, high = room.bounds[0], room.bounds[1]
    for k in range(3):
        low[k], high[k] = np.inf, -np.inf
    shortest, longest = np.inf, 0.0
    for i in range(count):
        edge = arena[top + i]
        shortest, longest = min(shortest, x.sizes[edge, 0]), max(longest, x.sizes[edge, 0])
        for k in range(3):
            low[k], high[k] = min(low[k], x.boxes[edge, k]), max(high[k], x.boxes[edge, k + 3])
    axis = 0
    for k in range(1, 3):
        if high[k] - low[k] > high[axis] - low[axis]:
            axis = k
    by_length = longest > DIFFERENT * shortest
    if not by_length and high[axis] - low[axis] < DIFFERENT * longest:
        return False
    for i in range(count):
        edge = arena[top + i]
        keys[i] = x.sizes[edge, 0] if by_length else x.boxes[edge, axis] + x.boxes[edge, axis + 3]
    select(keys, arena[top : top + count], 0, count, count // 2)
    return True


@uncounted
def _cut(lines, top, count, others, y0, y1, room, scratch):
    """Put one half of arena[top : top + count] after the other.

    The key of a line Y is a form in it that maximises the variance over this set among combinations of the products
    with the other set: the eigenvector of (second moments of the others) (covariance of these), by power iteration.
    """
    arena, keys = room.arena, room.keys
    vary, weigh, vectors = scratch
    form, turned = vectors[0], vectors[1]
    second_moments(lines, arena, top, top + count, True, vary, form)
    second_moments(others, arena, y0, y1, False, weigh, form)
    for k in range(6):
        form[k] = 1.0 / (1.0 + k)
    for _ in range(12):
        largest = 0.0
        for j in range(6):
            turned[j] = 0.0
            for k in range(6):
                turned[j] += vary[j, k] * form[k]
        for j in range(6):  # products pair the direction of one line with the moment of the other
            s = 0.0
            for k in range(6):
                s += weigh[j, k] * turned[(k + 3) % 6]
            form[(j + 3) % 6] = s
            largest = max(largest, abs(s))
        if not 0.0 < largest < np.inf:
            break
        for k in range(6):
            form[k] /= largest
    for i in range(count):
        s = 0.0
        for k in range(6):
            s += form[k] * lines[arena[top + i], k]
        keys[i] = s
    select(keys, arena[top : top + count], 0, count, count // 2)


@uncounted
def second_moments(vectors, order, first, last, centred, moments, mean):
    """Those of a sample, evenly spaced in the order."""
    step = max(1, (last - first) // _SAMPLE)
    for j in range(6):
        mean[j] = 0.0
        for k in range(6):
            moments[j, k] = 0.0
    if centred:
        for i in range(first, last, step):
            for j in range(6):
                mean[j] += vectors[order[i], j] / ((last - first + step - 1) // step)
    for i in range(first, last, step):
        y = vectors[order[i]]
        for j in range(6):
            for k in range(6):
                moments[j, k] += (y[j] - mean[j]) * (y[k] - mean[k])
