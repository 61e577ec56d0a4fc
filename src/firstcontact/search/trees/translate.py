"""The walk under a relative translation: `motion` is an array (9,): v and 1/v of body a in the frame of the
boxes, and v in that of the parts."""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.jit import implements, inlined, uncounted
from firstcontact.kernels.verdict import NONE, UNSURE
from firstcontact.pairs.elements.facet_facet import translation_window as both_straddle
from firstcontact.pairs.elements.line_line import translation_filter as edge_edge
from firstcontact.pairs.elements.point_plane import translation_filter as vertex_facet
from firstcontact.search.trees.state import BEST, EDGE_EDGE, FACE_VERTEX, FIRST, TESTS, VERTEX_FACE, WHOLE
from firstcontact.search.trees.tree import CORNER, FACET, POINT
from firstcontact.search.trees.walk import (
    area,
    earliest_meeting,
    first_is_larger,
    get_ready,
    is_new,
    record,
    test_events,
)
from firstcontact.search.trees.windows import meeting_window, part_windows

LEAST_FRAMED = 1e-300
"""Coordinates of velocities in a frame below it are roundings of zero."""


@uncounted
def lay_motion(v, frame, motion):
    """Fill a motion by the velocity v (3,) of the parts; frame: of the boxes, rows (3, 3), or (0, 3): it is theirs.

    Gives what the velocity of boxes is off by: 4 roundings of sums over |v| in a frame of their own.
    """
    for k in range(3):
        x = v[k]
        if len(frame) > 0:
            x = frame[k, 0] * v[0] + frame[k, 1] * v[1] + frame[k, 2] * v[2]
            if abs(x) < LEAST_FRAMED:
                x = 0.0
        motion[k] = x
        motion[k + 3] = 1.0 / x if x != 0.0 else np.inf
        motion[k + 6] = v[k]
    return 2.0**-50 * (abs(v[0]) + abs(v[1]) + abs(v[2])) if len(frame) > 0 else 0.0


@inlined
def entry_time(motion, boxes_a, a, boxes_b, b, pad, first, last):
    """A time not later than any contact of box a and box b in [first, last]; inf when there is none.

    Each time carries at most 4 roundings: widen by 1e-15 relative.
    """
    lo, hi = first, last
    for k in range(3):
        ahead = boxes_b[b, k] - boxes_a[a, k + 3] - pad
        behind = boxes_b[b, k + 3] - boxes_a[a, k] + pad
        v = motion[k + 3]
        if motion[k] == 0.0:
            if ahead > 0.0 or behind < 0.0:
                return np.inf
            continue
        t0, t1 = ahead * v, behind * v
        if v < 0.0:
            t0, t1 = t1, t0
        lo, hi = max(lo, t0 - 1e-15 * abs(t0)), min(hi, t1 + 1e-15 * abs(t1))
    return lo if lo <= hi else np.inf


def _events(
    motion, pa, mask_a, xa, pb, mask_b, xb, sides, err_a, err_b, floats, integers, times, candidates
):
    v0, v1, v2 = motion[6], motion[7], motion[8]
    first = floats[FIRST]
    if mask_a & mask_b & FACET:
        integers[TESTS] += 1
        lo, hi = both_straddle(xa, xb, v0, v1, v2, err_a, err_b, first, floats[BEST])
        if lo > hi:
            return
    points_only = (mask_a & POINT and mask_b & FACET) or (mask_b & POINT and mask_a & FACET)
    for s in range(3):
        if not mask_a & (sides << s) or points_only:
            continue
        i, j = 3 * s, 3 * ((s + 1) % 3)
        for r in range(3):
            if not mask_b & (sides << r):
                continue
            k, m = 3 * r, 3 * ((r + 1) % 3)
            integers[TESTS] += 1
            verdict, lo, hi = edge_edge(
                xa[i], xa[i + 1], xa[i + 2], xa[j], xa[j + 1], xa[j + 2],
                xb[k], xb[k + 1], xb[k + 2], xb[m], xb[m + 1], xb[m + 2],
                v0, v1, v2, first, floats[BEST], err_a, err_b,
            )  # fmt: skip
            if verdict != NONE:
                record(floats, integers, times, candidates, EDGE_EDGE, pa, s, pb, r, verdict, lo, hi)
    for s in range(3):
        i = 3 * s
        if mask_a & (1 << (CORNER + s)) and mask_b & FACET:
            integers[TESTS] += 1
            verdict, lo, hi = vertex_facet(
                xa[i], xa[i + 1], xa[i + 2],
                xb[0], xb[1], xb[2], xb[3], xb[4], xb[5], xb[6], xb[7], xb[8],
                v0, v1, v2, first, floats[BEST], err_a, err_b,
            )  # fmt: skip
            if verdict != NONE:
                record(floats, integers, times, candidates, VERTEX_FACE, pa, s, pb, WHOLE, verdict, lo, hi)
        if mask_b & (1 << (CORNER + s)) and mask_a & FACET:
            integers[TESTS] += 1
            verdict, lo, hi = vertex_facet(
                xb[i], xb[i + 1], xb[i + 2],
                xa[0], xa[1], xa[2], xa[3], xa[4], xa[5], xa[6], xa[7], xa[8],
                -v0, -v1, -v2, first, floats[BEST], err_b, err_a,
            )  # fmt: skip
            if verdict != NONE:
                record(floats, integers, times, candidates, FACE_VERTEX, pa, WHOLE, pb, s, verdict, lo, hi)


shifting_events = uncounted(_events)
"""`test_events` for callers whose motion may be a rotation too."""


@implements(earliest_meeting, 1, inlined=True)
def _earliest_meeting(motion, boxes_a, a, boxes_b, b, pad, first, last):
    if motion.ndim == 1:
        return lambda motion, boxes_a, a, boxes_b, b, pad, first, last: entry_time(
            motion, boxes_a, a, boxes_b, b, pad, first, last
        )
    return None


@implements(is_new, 1)
def _is_new(motion, side, node):
    return (lambda motion, side, node: False) if motion.ndim == 1 else None


@implements(get_ready, 1)
def _get_ready(motion, side, boxes, links, xyz, ids, node, pad):
    return (lambda motion, side, boxes, links, xyz, ids, node, pad: None) if motion.ndim == 1 else None


@implements(first_is_larger, 1)
def _first_is_larger(motion, boxes_a, a, boxes_b, b):
    if motion.ndim == 1:
        return lambda motion, boxes_a, a, boxes_b, b: area(boxes_a, a) >= area(boxes_b, b)
    return None


@implements(test_events, 1, inlined=True)
def _test_events(
    motion, pa, mask_a, xa, pb, mask_b, xb, sides, err_a, err_b, floats, integers, times, candidates
):
    if motion.ndim == 1:
        return _events
    return None


@uncounted
def slab_window(box_a, box_b, motion, pad, last):
    """(entry, exit) of the slab test in [0, last]; entry inf when the boxes never overlap there."""
    lo, hi = 0.0, last
    for k in range(3):
        ahead = box_b[k] - box_a[k + 3] - pad
        behind = box_b[k + 3] - box_a[k] + pad
        if motion[k] == 0.0:
            if ahead > 0.0 or behind < 0.0:
                return np.inf, np.inf
            continue
        t0, t1 = ahead * motion[k + 3], behind * motion[k + 3]
        if motion[k] < 0.0:
            t0, t1 = t1, t0
        lo, hi = max(lo, t0 - 1e-15 * abs(t0)), min(hi, t1 + 1e-15 * abs(t1))
    return (lo, hi) if lo <= hi else (np.inf, np.inf)


def _windows(motion, mask_a, xa, mask_b, xb, err_a, err_b, last, scratch, out):
    # parts of convex elements: the times form one interval, from the first event to the last
    v0, v1, v2 = motion[6], motion[7], motion[8]
    if mask_a & mask_b & FACET:
        lo, hi = both_straddle(xa, xb, v0, v1, v2, err_a, err_b, 0.0, last)
        if lo > hi:
            return 0
    sides_a = 3 if mask_a & FACET else 1
    sides_b = 3 if mask_b & FACET else 1
    first_lo = first_hi = np.inf
    last_lo = last_hi = -np.inf
    for s in range(sides_a):
        i, j = 3 * s, 3 * ((s + 1) % 3)
        for r in range(sides_b):
            k, m = 3 * r, 3 * ((r + 1) % 3)
            verdict, lo, hi = edge_edge(
                xa[i], xa[i + 1], xa[i + 2], xa[j], xa[j + 1], xa[j + 2],
                xb[k], xb[k + 1], xb[k + 2], xb[m], xb[m + 1], xb[m + 2],
                v0, v1, v2, -np.inf, np.inf, err_a, err_b,
            )  # fmt: skip
            if verdict == UNSURE:
                return -1
            if verdict != NONE:
                first_lo, first_hi = min(first_lo, lo), min(first_hi, hi)
                last_lo, last_hi = max(last_lo, lo), max(last_hi, hi)
    for s in range(3):
        i = 3 * s
        for swap in range(2):
            if swap == 0:
                if not mask_b & FACET or s > sides_a:
                    continue
                verdict, lo, hi = vertex_facet(
                    xa[i], xa[i + 1], xa[i + 2],
                    xb[0], xb[1], xb[2], xb[3], xb[4], xb[5], xb[6], xb[7], xb[8],
                    v0, v1, v2, -np.inf, np.inf, err_a, err_b,
                )  # fmt: skip
            else:
                if not mask_a & FACET or s > sides_b:
                    continue
                verdict, lo, hi = vertex_facet(
                    xb[i], xb[i + 1], xb[i + 2],
                    xa[0], xa[1], xa[2], xa[3], xa[4], xa[5], xa[6], xa[7], xa[8],
                    -v0, -v1, -v2, -np.inf, np.inf, err_b, err_a,
                )  # fmt: skip
            if verdict == UNSURE:
                return -1
            if verdict != NONE:
                first_lo, first_hi = min(first_lo, lo), min(first_hi, hi)
                last_lo, last_hi = max(last_lo, lo), max(last_hi, hi)
    if first_lo > last or last_hi < 0.0 or first_lo == np.inf:
        return 0
    out[0, 0], out[0, 1], out[0, 2], out[0, 3] = first_lo, first_hi, last_lo, last_hi
    return 1


@implements(meeting_window, 1)
def _meeting_window(motion, boxes_a, a, boxes_b, b, pad, last):
    if motion.ndim == 1:
        return lambda motion, boxes_a, a, boxes_b, b, pad, last: slab_window(
            boxes_a[a], boxes_b[b], motion, pad, last
        )
    return None


@implements(part_windows, 1)
def _part_windows(motion, mask_a, xa, mask_b, xb, err_a, err_b, last, scratch, out):
    if motion.ndim == 1:
        return _windows
    return None
