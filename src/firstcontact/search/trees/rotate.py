"""The walk under a rotation about +z: a rotation is a translation of the angle.

In cylindrical coordinates about the axis a node has ranges of radius, angle and height (see `cylinder`).  Nodes whose
ranges of height and radius overlap meet no earlier than the gap of their angles.

`motion` is one array (q + r + 1, 8): a row per node of a, then per node of b; the last row holds the point (x, y)
where the axis meets the plane z = 0 of the frame of both trees, and q.  (One array, because every further one costs
reference counts in the inner loop; rows as long as a cache line, with all that a visit reads.)
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.angle import ANGLE_EPS, TWO_PI
from firstcontact.kernels.jit import implements, uncounted
from firstcontact.kernels.verdict import CERTAIN, NONE, UNSURE
from firstcontact.pairs.elements.line_line_rotation import rotation_filter as edge_edge
from firstcontact.pairs.elements.point_plane_rotation import rotation_filter as vertex_facet
from firstcontact.pairs.elements.segment_facet import crossing_filter
from firstcontact.search.trees.cylinder import KNOWN, PHI, R_HI, R_LO, SIZE, WIDTH, Z_HI, Z_LO, learn
from firstcontact.search.trees.state import BEST, EDGE_EDGE, FACE_VERTEX, FIRST, TESTS, VERTEX_FACE, WHOLE
from firstcontact.search.trees.tree import CORNER, FACET, POINT
from firstcontact.search.trees.walk import earliest_meeting, first_is_larger, get_ready, is_new, record, test_events
from firstcontact.search.trees.windows import meeting_window, part_windows

_SLACK = 8.0 * ANGLE_EPS  # two angles, their difference and a sum, each within ANGLE_EPS


@uncounted
def entry_angle(motion, a, b, pad, first, last):
    """An angle not later than any contact of nodes a and b in [first, last]; inf when there is none."""
    i, j = a, int(motion[motion.shape[0] - 1, 2]) + b
    if motion[i, Z_LO] > motion[j, Z_HI] + pad or motion[j, Z_LO] > motion[i, Z_HI] + pad:
        return np.inf
    if motion[i, R_LO] > motion[j, R_HI] or motion[j, R_LO] > motion[i, R_HI]:
        return np.inf
    # a covers [phi, phi + width] and moves forward; b's range begins `ahead` of phi and ends at `leave`
    ahead = motion[j, PHI] - motion[i, PHI]
    if ahead < 0.0:
        ahead += TWO_PI
    gap = ahead - motion[i, WIDTH] - _SLACK
    leave = ahead + motion[j, WIDTH] + _SLACK
    if gap <= first:
        if leave >= first or leave >= TWO_PI:
            return first
        return np.inf if TWO_PI + gap > last else max(first, TWO_PI + gap)
    if leave - TWO_PI >= first:
        return first  # b's range reaches around to where a's begins
    return gap if gap <= last else np.inf


def _events(
    motion, pa, mask_a, xa, pb, mask_b, xb, sides, err_a, err_b, floats, integers, times, candidates
):
    end = motion.shape[0] - 1
    cx, cy, first = motion[end, 0], motion[end, 1], floats[FIRST]
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
            v0, lo0, hi0, v1, lo1, hi1 = edge_edge(
                xa[i] - cx, xa[i + 1] - cy, xa[i + 2], xa[j] - cx, xa[j + 1] - cy, xa[j + 2],
                xb[k] - cx, xb[k + 1] - cy, xb[k + 2], xb[m] - cx, xb[m + 1] - cy, xb[m + 2], err_a, err_b,
            )  # fmt: skip
            if v0 != NONE and hi0 >= first and lo0 <= floats[BEST]:
                record(floats, integers, times, candidates, EDGE_EDGE, pa, s, pb, r, v0, lo0, hi0)
            if v1 != NONE and hi1 >= first and lo1 <= floats[BEST]:
                record(floats, integers, times, candidates, EDGE_EDGE, pa, s, pb, r, v1, lo1, hi1)
    for s in range(3):
        i = 3 * s
        if mask_a & (1 << (CORNER + s)) and mask_b & FACET:
            integers[TESTS] += 1
            v0, lo0, hi0, v1, lo1, hi1 = vertex_facet(
                xa[i] - cx, xa[i + 1] - cy, xa[i + 2], xb[0] - cx, xb[1] - cy, xb[2],
                xb[3] - cx, xb[4] - cy, xb[5], xb[6] - cx, xb[7] - cy, xb[8], err_a, err_b,
            )  # fmt: skip
            if v0 != NONE and hi0 >= first and lo0 <= floats[BEST]:
                record(floats, integers, times, candidates, VERTEX_FACE, pa, s, pb, WHOLE, v0, lo0, hi0)
            if v1 != NONE and hi1 >= first and lo1 <= floats[BEST]:
                record(floats, integers, times, candidates, VERTEX_FACE, pa, s, pb, WHOLE, v1, lo1, hi1)
        if mask_b & (1 << (CORNER + s)) and mask_a & FACET:
            integers[TESTS] += 1
            # the facet turns forward: in the mirror image y -> -y the vertex turns forward past the facet
            v0, lo0, hi0, v1, lo1, hi1 = vertex_facet(
                xb[i] - cx, cy - xb[i + 1], xb[i + 2], xa[0] - cx, cy - xa[1], xa[2],
                xa[3] - cx, cy - xa[4], xa[5], xa[6] - cx, cy - xa[7], xa[8], err_b, err_a,
            )  # fmt: skip
            if v0 != NONE and hi0 >= first and lo0 <= floats[BEST]:
                record(floats, integers, times, candidates, FACE_VERTEX, pa, WHOLE, pb, s, v0, lo0, hi0)
            if v1 != NONE and hi1 >= first and lo1 <= floats[BEST]:
                record(floats, integers, times, candidates, FACE_VERTEX, pa, WHOLE, pb, s, v1, lo1, hi1)


turning_events = uncounted(_events)
"""`test_events` for callers whose motion may be a translation too."""


@implements(earliest_meeting, 2)
def _earliest_meeting(motion, boxes_a, a, boxes_b, b, pad, first, last):
    if motion.ndim == 2:
        return lambda motion, boxes_a, a, boxes_b, b, pad, first, last: entry_angle(
            motion, a, b, pad, first, last
        )
    return None


@implements(is_new, 2)
def _is_new(motion, side, node):
    if motion.ndim == 2:
        return lambda motion, side, node: (
            motion[node + (int(motion[motion.shape[0] - 1, 2]) if side else 0), KNOWN] == 0.0
        )
    return None


@implements(get_ready, 2)
def _get_ready(motion, side, boxes, links, xyz, ids, node, pad):
    if motion.ndim == 2:
        return lambda motion, side, boxes, links, xyz, ids, node, pad: learn(
            motion, int(motion[motion.shape[0] - 1, 2]) if side else 0, boxes, links, xyz, ids, np.int64(node), pad
        )
    return None


@implements(first_is_larger, 2)
def _first_is_larger(motion, boxes_a, a, boxes_b, b):
    if motion.ndim == 2:
        return lambda motion, boxes_a, a, boxes_b, b: (
            motion[a, SIZE] >= motion[int(motion[motion.shape[0] - 1, 2]) + b, SIZE]
        )
    return None


@implements(test_events, 2)
def _test_events(
    motion, pa, mask_a, xa, pb, mask_b, xb, sides, err_a, err_b, floats, integers, times, candidates
):
    if motion.ndim == 2:
        return _events
    return None


@uncounted
def angle_window(motion, a, b, pad, last):
    """(entry, exit) of the angles in [0, last] at which the nodes may overlap; entry inf for none."""
    entry = entry_angle(motion, a, b, pad, 0.0, last)
    if entry == np.inf:
        return np.inf, np.inf
    i, j = a, int(motion[motion.shape[0] - 1, 2]) + b
    ahead = motion[j, PHI] - motion[i, PHI]
    if ahead < 0.0:
        ahead += TWO_PI
    leave = ahead + motion[j, WIDTH] + _SLACK
    if leave >= TWO_PI or entry == 0.0:
        return entry, last  # it may come around: no need to say when it leaves
    return entry, min(leave, last)


@uncounted
def _add_event(scratch, n, verdict, lo, hi):
    """Note a certain event; -1 when the floats are unsure or there is no room."""
    if n < 0 or verdict == UNSURE or n == scratch.shape[0]:
        return -1 if verdict != NONE or n < 0 else n
    if verdict == NONE:
        return n
    k = n
    while k > 0 and scratch[k - 1, 0] > lo:
        scratch[k, 0], scratch[k, 1] = scratch[k - 1, 0], scratch[k - 1, 1]
        k -= 1
    scratch[k, 0], scratch[k, 1] = lo, hi
    return n + 1


@uncounted
def _crossing_at(angle, xa, sides_a, facet_a, xb, sides_b, facet_b, cx, cy, err_a, err_b, turned):
    """1: the parts certainly cross when a has turned by about `angle`; 0: certainly apart; -1: unsure.

    The turn used is the rational one of the double tan(angle / 2): within a few roundings of `angle`.
    """
    tau = np.tan(0.5 * angle)
    c, s = (1.0 - tau * tau) / (1.0 + tau * tau), 2.0 * tau / (1.0 + tau * tau)
    size = 0.0
    for k in range(3):
        x, y = xa[3 * k] - cx, xa[3 * k + 1] - cy
        size = max(size, abs(x) + abs(y))
        turned[3 * k], turned[3 * k + 1], turned[3 * k + 2] = c * x - s * y, s * x + c * y, xa[3 * k + 2]
    err = 1.5 * err_a + 16.0 * 2.0**-53 * size  # c and s carry 4 roundings each, the sums 3
    unsure = False
    for k in range(3):
        i, j = 3 * k, 3 * ((k + 1) % 3)
        if facet_b and k < sides_a:
            verdict = crossing_filter(
                turned[i], turned[i + 1], turned[i + 2], turned[j], turned[j + 1], turned[j + 2],
                xb[0] - cx, xb[1] - cy, xb[2], xb[3] - cx, xb[4] - cy, xb[5], xb[6] - cx, xb[7] - cy, xb[8],
                err, err_b,
            )  # fmt: skip
            if verdict == CERTAIN:
                return 1
            unsure = unsure or verdict != NONE
        if facet_a and k < sides_b:
            verdict = crossing_filter(
                xb[i] - cx, xb[i + 1] - cy, xb[i + 2], xb[j] - cx, xb[j + 1] - cy, xb[j + 2],
                turned[0], turned[1], turned[2], turned[3], turned[4], turned[5], turned[6], turned[7], turned[8],
                err_b, err,
            )  # fmt: skip
            if verdict == CERTAIN:
                return 1
            unsure = unsure or verdict != NONE
    return -1 if unsure else 0


def _windows(motion, mask_a, xa, mask_b, xb, err_a, err_b, last, scratch, out):
    # between two consecutive events nothing changes: one look into each gap decides it
    end = motion.shape[0] - 1
    cx, cy = motion[end, 0], motion[end, 1]
    facet_a, facet_b = mask_a & FACET != 0, mask_b & FACET != 0
    sides_a, sides_b = 3 if facet_a else 1, 3 if facet_b else 1
    n = np.int64(0)
    for s in range(sides_a):
        i, j = 3 * s, 3 * ((s + 1) % 3)
        for r in range(sides_b):
            k, m = 3 * r, 3 * ((r + 1) % 3)
            v0, lo0, hi0, v1, lo1, hi1 = edge_edge(
                xa[i] - cx, xa[i + 1] - cy, xa[i + 2], xa[j] - cx, xa[j + 1] - cy, xa[j + 2],
                xb[k] - cx, xb[k + 1] - cy, xb[k + 2], xb[m] - cx, xb[m + 1] - cy, xb[m + 2], err_a, err_b,
            )  # fmt: skip
            n = _add_event(scratch, n, v0, lo0, hi0)
            n = _add_event(scratch, n, v1, lo1, hi1)
            if n < 0:
                return -1
    for s in range(3):
        i = 3 * s
        if facet_b and s <= sides_a:
            v0, lo0, hi0, v1, lo1, hi1 = vertex_facet(
                xa[i] - cx, xa[i + 1] - cy, xa[i + 2], xb[0] - cx, xb[1] - cy, xb[2],
                xb[3] - cx, xb[4] - cy, xb[5], xb[6] - cx, xb[7] - cy, xb[8], err_a, err_b,
            )  # fmt: skip
            n = _add_event(scratch, n, v0, lo0, hi0)
            n = _add_event(scratch, n, v1, lo1, hi1)
        if facet_a and s <= sides_b:
            v0, lo0, hi0, v1, lo1, hi1 = vertex_facet(
                xb[i] - cx, cy - xb[i + 1], xb[i + 2], xa[0] - cx, cy - xa[1], xa[2],
                xa[3] - cx, cy - xa[4], xa[5], xa[6] - cx, cy - xa[7], xa[8], err_b, err_a,
            )  # fmt: skip
            n = _add_event(scratch, n, v0, lo0, hi0)
            n = _add_event(scratch, n, v1, lo1, hi1)
        if n < 0:
            return -1
    turned = np.empty(9)
    count = 0
    open_window = False
    for k in range(n + 1):
        lo = 0.0 if k == 0 else scratch[k - 1, 1]
        hi = last if k == n else scratch[k, 0]
        if k < n and (not hi > lo + 1e-13 or (hi <= last + 1e-14 and scratch[k, 1] >= last - 1e-14)):
            return -1  # too close to another event or to the end to look in between
        inside = 0
        if hi > lo:
            inside = _crossing_at(
                0.5 * (lo + hi), xa, sides_a, facet_a, xb, sides_b, facet_b, cx, cy, err_a, err_b, turned
            )
        if inside < 0:
            return -1
        if inside and not open_window:
            out[count, 0], out[count, 1] = (0.0, 0.0) if k == 0 else (scratch[k - 1, 0], scratch[k - 1, 1])
            open_window = True
        elif not inside:
            if open_window:
                out[count, 2], out[count, 3] = scratch[k - 1, 0], scratch[k - 1, 1]
                count += 1
                open_window = False
            elif k > 0:  # an instant between two gaps without contact
                out[count, 0], out[count, 1] = scratch[k - 1, 0], scratch[k - 1, 1]
                out[count, 2], out[count, 3] = scratch[k - 1, 0], scratch[k - 1, 1]
                count += 1
        if hi >= last:
            break
    if open_window:
        out[count, 2], out[count, 3] = last, last
        count += 1
    return count


@implements(meeting_window, 2)
def _meeting_window(motion, boxes_a, a, boxes_b, b, pad, last):
    if motion.ndim == 2:
        return lambda motion, boxes_a, a, boxes_b, b, pad, last: angle_window(motion, a, b, pad, last)
    return None


@implements(part_windows, 2)
def _part_windows(motion, mask_a, xa, mask_b, xb, err_a, err_b, last, scratch, out):
    if motion.ndim == 2:
        return _windows
    return None
