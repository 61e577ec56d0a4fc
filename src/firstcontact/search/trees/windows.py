"""When do parts of two trees share points?  A walk that collects closed windows of times, and what it can skip.

`cover` holds disjoint intervals in which contact is certain throughout.  A pair of nodes whose boxes overlap only
strictly inside one of them can change no end of the answer and is skipped, so deep overlap costs little more
than its ends.  What depends on the motion is chosen by its type: `meeting_window`, `part_windows`.
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.jit import kernel, uncounted
from firstcontact.search.trees.walk import first_is_larger, get_ready, is_new

# Slots of `integers`.
STACK, FOUND, COVERS, VISITS, TESTS = range(5)
# Most windows one pair of parts can give.
PART_ROOM = 64
# Reasons to come back.
DONE, FULL, SLICE_SPENT = range(3)


def meeting_window(motion, boxes_a, a, boxes_b, b, pad, last):
    """(entry, exit): every contact inside the two boxes in [0, last] lies between; entry inf for none."""
    raise NotImplementedError("compiled only, by the type of the motion")


def part_windows(motion, mask_a, xa, mask_b, xb, err_a, err_b, last, scratch, out):
    """Windows (start lo, hi, end lo, hi) of contact of two parts: fills out (PART_ROOM, 4).

    Returns their number, or -1 when the floats cannot tell.
    """
    raise NotImplementedError("compiled only, by the type of the motion")


@uncounted
def covered(cover, n, lo, hi):
    """Whether [lo, hi] lies strictly inside one interval of the cover."""
    for k in range(n):
        if cover[k, 0] < lo and hi < cover[k, 1]:
            return True
    return False


@uncounted
def extend_cover(cover, n, lo, hi):
    """Join [lo, hi] to the cover; returns the number of its intervals.  Ignored when there is no room."""
    k = 0
    while k < n:
        if cover[k, 0] <= hi and lo <= cover[k, 1]:
            lo, hi = min(lo, cover[k, 0]), max(hi, cover[k, 1])
            n -= 1
            cover[k, 0], cover[k, 1] = cover[n, 0], cover[n, 1]
            k = 0
        else:
            k += 1
    if n < cover.shape[0]:
        cover[n, 0], cover[n, 1] = lo, hi
        n += 1
    return n


@kernel
def collect(
    boxes_a, links_a, xyz_a, ids_a, boxes_b, links_b, xyz_b, ids_b,
    motion, err_a, err_b, pad, last, limit, integers, stack, cover, times, parts,
):  # fmt: skip
    """Go on collecting: times (n, 4), parts (n, 2) of the windows that may matter.

    A pair the floats are unsure of has times[0] = inf, and in times[2], times[3] when its boxes meet.
    """
    scratch = np.empty((PART_ROOM, 2))
    out = np.empty((PART_ROOM, 4))
    while integers[STACK] > 0:
        if integers[STACK] + 4 > stack.shape[0] or integers[FOUND] + PART_ROOM > times.shape[0]:
            return FULL
        if integers[VISITS] >= limit:
            return SLICE_SPENT
        integers[STACK] -= 1
        a, b = stack[integers[STACK], 0], stack[integers[STACK], 1]
        integers[VISITS] += 1
        if is_new(motion, 0, a):
            get_ready(motion, 0, boxes_a, links_a, xyz_a, ids_a, a, pad)
        if is_new(motion, 1, b):
            get_ready(motion, 1, boxes_b, links_b, xyz_b, ids_b, b, pad)
        entry, leave = meeting_window(motion, boxes_a, a, boxes_b, b, pad, last)
        if entry == np.inf or covered(cover, integers[COVERS], entry, leave):
            continue
        leaf_a, leaf_b = links_a[a, 1] < 0, links_b[b, 1] < 0
        if not (leaf_a and leaf_b):
            n = integers[STACK]
            if leaf_b or (not leaf_a and first_is_larger(motion, boxes_a, a, boxes_b, b)):
                stack[n, 0], stack[n, 1], stack[n + 1, 0], stack[n + 1, 1] = links_a[a, 0], b, links_a[a, 1], b
            else:
                stack[n, 0], stack[n, 1], stack[n + 1, 0], stack[n + 1, 1] = a, links_b[b, 0], a, links_b[b, 1]
            integers[STACK] = n + 2
            continue
        pa, pb = links_a[a, 0], links_b[b, 0]
        integers[TESTS] += 1
        count = part_windows(
            motion, ids_a[pa, 1], xyz_a[pa], ids_b[pb, 1], xyz_b[pb], err_a, err_b, last, scratch, out
        )
        n = integers[FOUND]
        if count < 0:
            times[n, 0], times[n, 1], times[n, 2], times[n, 3] = np.inf, np.inf, entry, leave
            parts[n, 0], parts[n, 1] = pa, pb
            integers[FOUND] = n + 1
            continue
        for k in range(count):
            w = out[k]
            if covered(cover, integers[COVERS], w[0], w[3]):
                continue
            n = integers[FOUND]
            times[n, 0], times[n, 1], times[n, 2], times[n, 3] = w[0], w[1], w[2], w[3]
            parts[n, 0], parts[n, 1] = pa, pb
            integers[FOUND] = n + 1
            if w[1] < w[2]:
                integers[COVERS] = extend_cover(cover, integers[COVERS], w[1], w[2])
    return DONE
