"""The walk that cuts space and time: what of a and of b may meet in one cell, in lists that are halved while it pays.

Long parts that pass each other have boxes that all overlap; cut into short pieces they do not.  Here nothing is cut
beforehand: a cell is a box and an interval of time, with the parts of b that enter the box and those of a that do so
during the interval.  Halves of the cell get those that enter them; where testing all pairs costs about as much as going
on, they are tested.  n generic rods a body are so cut into about sqrt(n) pieces each, and n^1.5 pairs are tested.

Invariant: a contact at the point q and a time not after the best time, not yet recorded, lies in a waiting cell whose
lists hold both parts.  Halves are closed, lists are grown by the error of the parts: nothing falls between them.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numba.extending import overload

from firstcontact.kernels.boxes import segment_meets_box, triangle_meets_box
from firstcontact.kernels.jit import kernel
from firstcontact.search.state import (
    BEST,
    CANDIDATES,
    CROSSING_FOUND,
    CROWDED,
    DECIDE,
    DONE,
    FULL,
    KEY,
    LEAF_ROOM,
    SLICE_SPENT,
    UNSURE_BATCH,
    UNSURE_COUNT,
    VISITS,
)
from firstcontact.search.tree import FACET, SIDE
from firstcontact.search.walk import meet_at_start, test_events

# A cell with i and j parts is tested pair by pair when i j <= PAYS (i + j): a pair test takes several times as long as
# a look at a part, and the parts of a cell are looked at again on the way to smaller ones.
PAYS = 8
# Nor are cells halved further where that has multiplied the pairs: parts that share a line are together in every cell
# along it.  SPREAD grows by the pairs of both halves of a box over those of the whole.
MOST_SPREAD = 8.0
# Cells are halved so often at most: many parts may share a point.
DEEPEST = 160
# Time is halved where a moves farther during it than this share of the cell's longest side.
FAR = 0.5

# Slots of a frame: box (6), time from, to, spread; and of its integers: lists of a and b (first, last each), the end of
# the room they lie in, depth, pairs already tested.
FROM, TO, SPREAD = 6, 7, 8
A_FIRST, A_LAST, B_FIRST, B_LAST, ROOM, DEPTH, TESTED = range(7)


@dataclass(slots=True)
class Cells:
    """The cells that wait, the last one next; `lists` holds numbers of parts."""

    boxes: np.ndarray = field(default_factory=lambda: np.empty((DEEPEST + 4, 9)))
    frames: np.ndarray = field(default_factory=lambda: np.zeros((DEEPEST + 4, 7), np.int64))
    lists: np.ndarray = field(default_factory=lambda: np.empty(0, np.int32))
    waiting: int = 0
    pays: int = PAYS

    def start(self, parts_a: np.ndarray, parts_b: np.ndarray, box: np.ndarray, first: float, last: float) -> None:
        """One cell: the box of b, the parts on both lists, the times from first to last."""
        m, n = len(parts_a), len(parts_b)
        if len(self.lists) < 4 * (m + n):
            self.lists = np.empty(4 * (m + n), np.int32)
        self.lists[:m], self.lists[m : m + n] = parts_a, parts_b
        self.boxes[0, :6], self.boxes[0, FROM], self.boxes[0, TO] = box, first, last
        self.boxes[0, SPREAD] = 1.0
        self.frames[0] = 0, m, m, m + n, m + n, 0, 0
        self.waiting = 1


def way(motion, box, duration):
    """No point of a that is in the box at one time of `duration` was farther away at another, in any coordinate."""
    raise NotImplementedError("compiled only, by the type of the motion")


def lay(motion, box, err, query, turn):
    """Write the box that parts of a enter, posed as in `turn`, that are in the cell at one of its times; returns how

    much it is to be grown for rounding and for `err`, that of the parts of both bodies.
    """
    raise NotImplementedError("compiled only, by the type of the motion")


@kernel
def cell_walk(
    xyz_a, ids_a, xyz_b, ids_b, motion, err_a, err_b, at_start, limit,
    boxes, frames, lists, waiting, pays, floats, integers, times, candidates,
):  # fmt: skip
    """(reason to come back, cells that wait).  at_start: edges against facets at time 0, not contacts.  pays: PAYS."""
    query, turn, work = np.empty(6), np.zeros(5), np.empty((1, 9))
    while waiting > 0:
        if integers[VISITS] >= limit:
            return SLICE_SPENT, waiting
        box, frame = boxes[waiting - 1], frames[waiting - 1]
        box[TO] = min(box[TO], floats[BEST])
        m, n = frame[A_LAST] - frame[A_FIRST], frame[B_LAST] - frame[B_FIRST]
        if box[FROM] > floats[BEST] or m == 0 or n == 0:
            waiting -= 1
            continue
        if m * n <= pays * (m + n) or box[SPREAD] > MOST_SPREAD or frame[DEPTH] >= DEEPEST:
            reason = _test_pairs(
                xyz_a, ids_a, xyz_b, ids_b, motion, err_a, err_b, at_start, frame, lists,
                floats, integers, times, candidates,
            )  # fmt: skip
            if reason != DONE:
                return reason, waiting
            waiting -= 1
            continue
        if frame[ROOM] + 2 * (m + n) > lists.shape[0]:
            return CROWDED, waiting
        integers[VISITS] += 2 * (m + n)
        _halve(xyz_a, ids_a, xyz_b, ids_b, motion, err_a, err_b, boxes, frames, lists, waiting, query, turn, work)
        waiting += 1
    if not at_start:
        floats[KEY] = floats[BEST]
    return DONE, waiting


@kernel
def _test_pairs(
    xyz_a, ids_a, xyz_b, ids_b, motion, err_a, err_b, at_start, frame, lists, floats, integers, times, candidates
):
    """Test the pairs of a cell that are left to test; the reason to stop."""
    n = frame[B_LAST] - frame[B_FIRST]
    count = (frame[A_LAST] - frame[A_FIRST]) * n
    while frame[TESTED] < count:
        if integers[CANDIDATES] + LEAF_ROOM > times.shape[0]:
            return FULL
        if integers[UNSURE_COUNT] >= UNSURE_BATCH:
            return DECIDE
        pa, pb = lists[frame[A_FIRST] + frame[TESTED] // n], lists[frame[B_FIRST] + frame[TESTED] % n]
        frame[TESTED] += 1
        if at_start:
            if meet_at_start(
                pa, ids_a[pa, 1], xyz_a[pa], pb, ids_b[pb, 1], xyz_b[pb], err_a, err_b,
                floats, integers, times, candidates,
            ):  # fmt: skip
                return CROSSING_FOUND
        else:
            test_events(
                motion, pa, ids_a[pa, 1], xyz_a[pa], pb, ids_b[pb, 1], xyz_b[pb], 1 << SIDE, err_a, err_b,
                floats, integers, times, candidates,
            )  # fmt: skip
    return DONE


@kernel
def _halve(
    xyz_a, ids_a, xyz_b, ids_b, motion, err_a, err_b, boxes, frames, lists, waiting, query, turn, work
):
    """Put the halves of the last cell in its place: of its time, the earlier half last, or of its longest side."""
    parent, frame = boxes[waiting - 1], frames[waiting - 1]
    axis = 0
    for k in range(1, 3):
        if parent[k + 3] - parent[k] > parent[axis + 3] - parent[axis]:
            axis = k
    length = parent[axis + 3] - parent[axis]
    in_time = way(motion, parent, parent[TO] - parent[FROM]) > FAR * length
    if in_time:
        lo, hi, cut_lo, cut_hi = parent[FROM], parent[TO], TO, FROM
    else:
        lo, hi, cut_lo, cut_hi = parent[axis], parent[axis + 3], axis + 3, axis
    middle = lo + 0.5 * (hi - lo)
    first_a, last_a, first_b, last_b = frame[A_FIRST], frame[A_LAST], frame[B_FIRST], frame[B_LAST]
    room, depth = frame[ROOM], frame[DEPTH] + 1
    pairs, before = 0, (last_a - first_a) * (last_b - first_b)
    for k in range(8):
        boxes[waiting, k] = parent[k]
    parent[cut_hi], boxes[waiting, cut_lo] = middle, middle  # the upper half goes first, into the parent's place
    for half in range(2):
        box, frame = boxes[waiting - 1 + half], frames[waiting - 1 + half]
        pad = lay(motion, box, err_a + err_b, query, turn)
        frame[A_FIRST] = room
        for i in range(first_a, last_a):
            part = lists[i]
            if _enters(xyz_a, part, ids_a[part, 1], query, turn, pad, work):
                lists[room] = part
                room += 1
        frame[A_LAST] = room
        if in_time:
            frame[B_FIRST], frame[B_LAST] = first_b, last_b
        else:
            frame[B_FIRST] = room
            for i in range(first_b, last_b):
                part = lists[i]
                if _meets(xyz_b, part, ids_b[part, 1], box, 2.0 * err_b):
                    lists[room] = part
                    room += 1
            frame[B_LAST] = room
        frame[ROOM], frame[DEPTH], frame[TESTED] = room, depth, 0
        pairs += (frame[A_LAST] - frame[A_FIRST]) * (frame[B_LAST] - frame[B_FIRST])
    spread = parent[SPREAD] if in_time else max(1.0, parent[SPREAD] * pairs / before)
    parent[SPREAD], boxes[waiting, SPREAD] = spread, spread


@kernel
def _enters(xyz, part, mask, query, turn, pad, work):
    """False only when the part of a, posed as in `turn`, certainly misses the box."""
    if turn[4] == 0.0:
        return _meets(xyz, part, mask, query, pad)
    c, s, cx, cy = turn[0], turn[1], turn[2], turn[3]
    for k in range(0, 9, 3):
        x, y = xyz[part, k] - cx, xyz[part, k + 1] - cy
        work[0, k], work[0, k + 1], work[0, k + 2] = cx + (c * x - s * y), cy + (s * x + c * y), xyz[part, k + 2]
    return _meets(work, 0, mask, query, pad)


@kernel
def _meets(xyz, part, mask, box, pad):
    """False only when the triangle, edge or point certainly misses the box grown by `pad`."""
    if mask & FACET:
        return triangle_meets_box(xyz[part], box, pad)
    return segment_meets_box(xyz[part, 0:3], xyz[part, 3:6], box, pad)


# ---------------------------------------------------------------------------------------------- translation

# Beyond roundings of a product and two sums of coordinates.
_ROUNDING = 2.0**-50
# The cosine and sine of an angle come from the mathematical library, which gives no bound: far beyond what it is off.
_TURNING = 1e-12


@overload(way)
def _way(motion, box, duration):
    if motion.ndim == 1:

        def shift(motion, box, duration):
            return max(abs(motion[6]), abs(motion[7]), abs(motion[8])) * duration

        return shift

    def turn_by(motion, box, duration):
        return _farthest(motion, box) * min(duration, 2.0)

    return turn_by


@overload(lay)
def _lay(motion, box, err, query, turn):
    return _lay_shifted if motion.ndim == 1 else _lay_turned


def _lay_shifted(motion, box, err, query, turn):
    size = 0.0
    for k in range(3):
        start, end = 0.0, 0.0
        if motion[6 + k] != 0.0:  # times may be infinite
            start, end = box[FROM] * motion[6 + k], box[TO] * motion[6 + k]
        query[k], query[k + 3] = box[k] - max(start, end), box[k + 3] - min(start, end)
        size = max(size, abs(box[k]), abs(box[k + 3]), abs(start), abs(end))
    return 2.0 * err + _ROUNDING * size


def _lay_turned(motion, box, err, query, turn):
    # a as it stands when the cell's time begins; from then on a point in the box moves along a circle, and no
    # farther than the chord, which is shorter than the arc and than the diameter
    end = motion.shape[0] - 1
    turn[0], turn[1], turn[4] = np.cos(box[FROM]), np.sin(box[FROM]), 1.0
    turn[2], turn[3] = motion[end, 0], motion[end, 1]
    far = _farthest(motion, box)
    grown = far * min(box[TO] - box[FROM], 2.0)
    for k in range(2):
        query[k], query[k + 3] = box[k] - grown, box[k + 3] + grown
    query[2], query[5] = box[2], box[5]
    size = far + abs(turn[2]) + abs(turn[3]) + abs(box[2]) + abs(box[5])
    return 3.0 * err + (_TURNING + _ROUNDING) * size


@kernel
def _farthest(motion, box):
    """A bound on the distance of the box's points from the axis."""
    end = motion.shape[0] - 1
    x = max(abs(box[0] - motion[end, 0]), abs(box[3] - motion[end, 0]))
    y = max(abs(box[1] - motion[end, 1]), abs(box[4] - motion[end, 1]))
    return np.sqrt(x * x + y * y) * (1.0 + 1e-15)
