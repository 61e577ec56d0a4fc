"""Best-first walk over two trees, whatever the motion.

What depends on the motion is chosen by the type of the `motion` argument (see `translate` and `rotate`):
`earliest_meeting` bounds the contact time of two boxes from below, `first_is_larger` says which one to open,
`test_events` looks at two parts.
Invariant: every contact earlier than `best` lies in a pair on the heap, on the stack, or among the candidates.
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.heap import heap_pop, heap_push
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.verdict import CERTAIN, NONE, UNSURE
from firstcontact.pairs.elements.segment_facet import crossing_filter
from firstcontact.search.trees.state import (
    ALL,
    BEST,
    CANDIDATES,
    CERTAIN_KIND,
    CROSSING_FOUND,
    DECIDE,
    DONE,
    EDGE_FACE,
    FACE_EDGE,
    FIRST,
    FULL,
    HEAP,
    KEY,
    LEAF_ROOM,
    SLICE_SPENT,
    STACK,
    SURE_FIRST,
    SURE_LAST,
    TESTS,
    UNSURE_BATCH,
    UNSURE_COUNT,
    UNSURE_TOTAL,
    VISITS,
    WHOLE,
)
from firstcontact.search.trees.tree import FACET, FLAT_SIDE, SIDE


def earliest_meeting(motion, boxes_a, a, boxes_b, b, pad, first, last):
    """A time not later than any contact inside box a and box b in [first, last]; inf when there is none."""
    raise NotImplementedError("compiled only, by the type of the motion")


def is_new(motion, side, node):
    """Whether a node of a (side 0) or b (side 1) is to be got ready before its first meeting."""
    raise NotImplementedError("compiled only, by the type of the motion")


def get_ready(motion, side, boxes, links, xyz, ids, node, pad):
    """Work out what `earliest_meeting` needs to know of the node."""
    raise NotImplementedError("compiled only, by the type of the motion")


def first_is_larger(motion, boxes_a, a, boxes_b, b):
    """Whether box a is the one to open before box b; a matter of speed."""
    raise NotImplementedError("compiled only, by the type of the motion")


def test_events(motion, pa, mask_a, xa, pb, mask_b, xb, sides, err_a, err_b, floats, integers, times, candidates):
    """Record edge/edge, vertex/face and face/vertex contacts of two parts; `sides`: the side bits that count."""
    raise NotImplementedError("compiled only, by the type of the motion")


test_events.__test__ = False  # type: ignore[attr-defined]  # no test, whatever its name says to collectors


@uncounted
def area(boxes, node):
    x, y, z = boxes[node, 3] - boxes[node, 0], boxes[node, 4] - boxes[node, 1], boxes[node, 5] - boxes[node, 2]
    return x * y + y * z + z * x


@uncounted
def record(floats, integers, times, candidates, kind, part_a, side_a, part_b, side_b, verdict, lo, hi):
    """Note a contact, certainly in [lo, hi] or unsure and not before lo; a certain one bounds the search."""
    if verdict == CERTAIN and (lo < floats[SURE_FIRST] or hi > floats[SURE_LAST]):
        verdict = UNSURE
    bound = max(lo, floats[KEY])
    if bound > floats[BEST]:
        return
    n = integers[CANDIDATES]
    times[n, 0], times[n, 1] = lo if verdict == CERTAIN else bound, hi
    candidates[n, 0], candidates[n, 1], candidates[n, 2] = kind, part_a, side_a
    candidates[n, 3], candidates[n, 4] = part_b, side_b
    if verdict == CERTAIN:
        if floats[ALL] == 0.0:
            floats[BEST] = min(floats[BEST], hi)
        candidates[n, 0] += CERTAIN_KIND
    else:
        integers[UNSURE_COUNT] += 1
        integers[UNSURE_TOTAL] += 1
    integers[CANDIDATES] = n + 1


@uncounted
def boxes_overlap(x, y, pad):
    return not (
        x[0] > y[3] + pad or x[1] > y[4] + pad or x[2] > y[5] + pad
        or y[0] > x[3] + pad or y[1] > x[4] + pad or y[2] > x[5] + pad
    )  # fmt: skip


@uncounted
def meet_at_start(pa, mask_a, xa, pb, mask_b, xb, err_a, err_b, floats, integers, times, candidates):
    """Edges of either part against the facet of the other at the start; True when they certainly cross."""
    for s in range(3):
        if mask_a & (1 << (SIDE + s)) and mask_b & FACET:
            i, j = 3 * s, 3 * ((s + 1) % 3)
            integers[TESTS] += 1
            verdict = crossing_filter(
                xa[i], xa[i + 1], xa[i + 2], xa[j], xa[j + 1], xa[j + 2],
                xb[0], xb[1], xb[2], xb[3], xb[4], xb[5], xb[6], xb[7], xb[8], err_a, err_b,
            )  # fmt: skip
            if verdict != NONE:
                first = floats[FIRST]
                record(floats, integers, times, candidates, EDGE_FACE, pa, s, pb, WHOLE, verdict, first, first)
                if verdict == CERTAIN and floats[ALL] == 0.0:
                    return True
        if mask_b & (1 << (SIDE + s)) and mask_a & FACET:
            i, j = 3 * s, 3 * ((s + 1) % 3)
            integers[TESTS] += 1
            verdict = crossing_filter(
                xb[i], xb[i + 1], xb[i + 2], xb[j], xb[j + 1], xb[j + 2],
                xa[0], xa[1], xa[2], xa[3], xa[4], xa[5], xa[6], xa[7], xa[8], err_b, err_a,
            )  # fmt: skip
            if verdict != NONE:
                first = floats[FIRST]
                record(floats, integers, times, candidates, FACE_EDGE, pa, WHOLE, pb, s, verdict, first, first)
                if verdict == CERTAIN and floats[ALL] == 0.0:
                    return True
    return False


@uncounted
def walk(
    boxes_a, links_a, xyz_a, ids_a, boxes_b, links_b, xyz_b, ids_b,
    motion, err_a, err_b, pad, with_start, all_sides, limit,
    floats, integers, keys, pairs, stack, times, candidates,
):  # fmt: skip
    """Go on with the walk until one of the reasons of `state` to come back; returns it.

    err_a, err_b: errors of the parts' coordinates.  pad: how much two boxes may be apart and still overlap in truth.
    with_start: test edges against facets at the start of the window.  all_sides: flat sides count too.
    limit: node visits after which to come back.
    """
    sides = (1 << SIDE) | ((1 << FLAT_SIDE) if all_sides else 0)
    first, root = floats[FIRST], np.int32(0)  # of the type of all nodes
    if is_new(motion, 0, root):
        get_ready(motion, 0, boxes_a, links_a, xyz_a, ids_a, root, pad)
    if is_new(motion, 1, root):
        get_ready(motion, 1, boxes_b, links_b, xyz_b, ids_b, root, pad)
    while True:
        if integers[STACK] + 4 > stack.shape[0] or integers[HEAP] + 4 > keys.shape[0]:
            return FULL  # either may fill while the walk goes on with the other
        if integers[STACK] > 0:
            integers[STACK] -= 1
            a, b = stack[integers[STACK], 0], stack[integers[STACK], 1]
            key = first
        elif integers[HEAP] > 0:
            key = keys[0]
            floats[KEY] = key
            if key > floats[BEST]:
                return DONE
            a, b = pairs[0, 0], pairs[0, 1]
            integers[HEAP] = heap_pop(keys, pairs, integers[HEAP])
        else:
            floats[KEY] = floats[BEST]
            return DONE
        # descend as long as a child may meet as early as anything that waits
        while True:
            floats[KEY] = key
            integers[VISITS] += 1
            leaf_a, leaf_b = links_a[a, 1] < 0, links_b[b, 1] < 0
            if leaf_a and leaf_b:
                pa, pb = links_a[a, 0], links_b[b, 0]
                mask_a, mask_b = ids_a[pa, 1], ids_b[pb, 1]
                xa, xb = xyz_a[pa], xyz_b[pb]
                if with_start and boxes_overlap(boxes_a[a], boxes_b[b], pad) and meet_at_start(
                    pa, mask_a, xa, pb, mask_b, xb, err_a, err_b, floats, integers, times, candidates
                ):
                    return CROSSING_FOUND
                test_events(
                    motion, pa, mask_a, xa, pb, mask_b, xb, sides, err_a, err_b,
                    floats, integers, times, candidates,
                )  # fmt: skip
                break
            if leaf_b or (not leaf_a and first_is_larger(motion, boxes_a, a, boxes_b, b)):
                a0, b0, a1, b1 = links_a[a, 0], b, links_a[a, 1], b
            else:
                a0, b0, a1, b1 = a, links_b[b, 0], a, links_b[b, 1]
            best = floats[BEST]
            for k in range(2):
                if is_new(motion, 0, a1 if k else a0):
                    get_ready(motion, 0, boxes_a, links_a, xyz_a, ids_a, a1 if k else a0, pad)
                if is_new(motion, 1, b1 if k else b0):
                    get_ready(motion, 1, boxes_b, links_b, xyz_b, ids_b, b1 if k else b0, pad)
            key0 = earliest_meeting(motion, boxes_a, a0, boxes_b, b0, pad, key, best)
            key1 = earliest_meeting(motion, boxes_a, a1, boxes_b, b1, pad, key, best)
            if key1 < key0:
                key0, key1 = key1, key0
                a0, b0, a1, b1 = a1, b1, a0, b0
            if key0 == np.inf:
                break
            if key1 <= first:
                stack[integers[STACK], 0], stack[integers[STACK], 1] = a1, b1
                integers[STACK] += 1
            elif key1 != np.inf:
                integers[HEAP] = heap_push(keys, pairs, integers[HEAP], key1, a1, b1)
            full = integers[STACK] + 4 > stack.shape[0] or integers[HEAP] + 4 > keys.shape[0]
            if key0 <= first and not full:
                a, b, key = a0, b0, key0
                continue
            if integers[STACK] > 0 or full or (integers[HEAP] > 0 and keys[0] < key0):
                if key0 <= first:
                    stack[integers[STACK], 0], stack[integers[STACK], 1] = a0, b0
                    integers[STACK] += 1
                else:
                    integers[HEAP] = heap_push(keys, pairs, integers[HEAP], key0, a0, b0)
                break
            a, b, key = a0, b0, key0
        if integers[CANDIDATES] + LEAF_ROOM > times.shape[0]:
            return FULL
        if integers[UNSURE_COUNT] >= UNSURE_BATCH and floats[ALL] == 0.0:  # where all are wanted none ends the walk
            return DECIDE
        if integers[VISITS] >= limit:
            return SLICE_SPENT
