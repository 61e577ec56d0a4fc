"""The walk under a rotation about +z: a rotation is a translation of the angle.

In cylindrical coordinates about the axis a box has ranges of squared radius and angle, computed when a walk first
visits it.  Boxes whose ranges of height and radius overlap meet no earlier than the gap of their angles.

`motion` is the tuple (ranges_a, seen_a, ranges_b, seen_b, centre): ranges (q, 4) squared radius lo, hi, first
angle, width; seen (q,) uint8; centre (x, y) where the axis meets the plane z = 0 of the frame of both trees.
"""

from __future__ import annotations

import numpy as np
from numba import types
from numba.extending import overload

from firstcontact.kernels.angle import ANGLE_EPS, TWO_PI, angle_of
from firstcontact.kernels.jit import kernel
from firstcontact.kernels.verdict import NONE
from firstcontact.pairs.line_line_rotation import rotation_filter as edge_edge
from firstcontact.pairs.point_plane_rotation import rotation_filter as vertex_facet
from firstcontact.search.state import BEST, EDGE_EDGE, FACE_VERTEX, FIRST, TESTS, VERTEX_FACE
from firstcontact.search.tree import CORNER, FACET, POINT
from firstcontact.search.walk import earliest_meeting, record, test_events

_FULL = 2.0 * TWO_PI  # width of a box around the axis: overlaps every range of angles
_SLACK = 8.0 * ANGLE_EPS  # two angles, their difference and a sum, each within ANGLE_EPS


@kernel
def find_range(box, centre, pad, out):
    """Fill out (4,): squared radii lo, hi and angles first, width of the box grown by `pad` about the axis."""
    x0, x1 = box[0] - centre[0] - pad, box[3] - centre[0] + pad
    y0, y1 = box[1] - centre[1] - pad, box[4] - centre[1] + pad
    # the differences round by 2^-53 relative to their own size: widen by twice that
    x0, x1, y0, y1 = x0 - 4e-16 * abs(x0), x1 + 4e-16 * abs(x1), y0 - 4e-16 * abs(y0), y1 + 4e-16 * abs(y1)
    dx, dy = max(x0, -x1, 0.0), max(y0, -y1, 0.0)
    fx, fy = max(-x0, x1), max(-y0, y1)
    out[0] = (dx * dx + dy * dy) * (1.0 - 1e-15)
    out[1] = (fx * fx + fy * fy) * (1.0 + 1e-15)
    if x0 > 0.0:
        first = angle_of(x0 if y0 < 0.0 else x1, y0)
        last = angle_of(x0 if y1 > 0.0 else x1, y1)
    elif x1 < 0.0:
        first = angle_of(x1 if y1 > 0.0 else x0, y1)
        last = angle_of(x1 if y0 < 0.0 else x0, y0)
    elif y0 > 0.0:
        first, last = angle_of(x1, y0), angle_of(x0, y0)
    elif y1 < 0.0:
        first, last = angle_of(x0, y1), angle_of(x1, y1)
    else:
        out[2], out[3] = 0.0, _FULL
        return
    out[2] = first
    out[3] = last - first if last >= first else last - first + TWO_PI


@kernel
def entry_angle(motion, boxes_a, a, boxes_b, b, pad, first, last):
    """An angle not later than any contact of the two boxes in [first, last]; inf when there is none."""
    ranges_a, seen_a, ranges_b, seen_b, centre = motion
    if boxes_a[a, 2] > boxes_b[b, 5] + pad or boxes_b[b, 2] > boxes_a[a, 5] + pad:
        return np.inf
    if not seen_a[a]:
        find_range(boxes_a[a], centre, pad, ranges_a[a])
        seen_a[a] = 1
    if not seen_b[b]:
        find_range(boxes_b[b], centre, pad, ranges_b[b])
        seen_b[b] = 1
    if ranges_a[a, 0] > ranges_b[b, 1] or ranges_b[b, 0] > ranges_a[a, 1]:
        return np.inf
    phi_a, width_a, phi_b, width_b = ranges_a[a, 2], ranges_a[a, 3], ranges_b[b, 2], ranges_b[b, 3]
    ahead = phi_b - phi_a
    if ahead < 0.0:
        ahead += TWO_PI
    # a covers [phi_a, phi_a + width_a] and moves forward; b's range begins `ahead` of phi_a
    gap = ahead - width_a - _SLACK
    leave = ahead + width_b + _SLACK  # the angle at which a has left b's range, once around at most
    if gap <= first:
        if leave >= first or ahead + width_b + _SLACK >= TWO_PI:
            return first
        return np.inf if TWO_PI + gap > last else max(first, TWO_PI + gap)
    if ahead + width_b + _SLACK >= TWO_PI and ahead + width_b - TWO_PI + _SLACK >= first:
        return first  # b's range reaches around to where a's begins
    return gap if gap <= last else np.inf


def _events(
    motion, pa, mask_a, xa, pb, mask_b, xb, sides, err_a, err_b, floats, integers, times, candidates
):
    cx, cy = motion[4][0], motion[4][1]
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
            note(floats, integers, times, candidates, EDGE_EDGE, pa, s, pb, r, v0, lo0, hi0)
            note(floats, integers, times, candidates, EDGE_EDGE, pa, s, pb, r, v1, lo1, hi1)
    for s in range(3):
        i = 3 * s
        if mask_a & (1 << (CORNER + s)) and mask_b & FACET:
            integers[TESTS] += 1
            v0, lo0, hi0, v1, lo1, hi1 = vertex_facet(
                xa[i] - cx, xa[i + 1] - cy, xa[i + 2], xb[0] - cx, xb[1] - cy, xb[2],
                xb[3] - cx, xb[4] - cy, xb[5], xb[6] - cx, xb[7] - cy, xb[8], err_a, err_b,
            )  # fmt: skip
            note(floats, integers, times, candidates, VERTEX_FACE, pa, s, pb, 0, v0, lo0, hi0)
            note(floats, integers, times, candidates, VERTEX_FACE, pa, s, pb, 0, v1, lo1, hi1)
        if mask_b & (1 << (CORNER + s)) and mask_a & FACET:
            integers[TESTS] += 1
            # the facet turns forward: in the mirror image y -> -y the vertex turns forward past the facet
            v0, lo0, hi0, v1, lo1, hi1 = vertex_facet(
                xb[i] - cx, cy - xb[i + 1], xb[i + 2], xa[0] - cx, cy - xa[1], xa[2],
                xa[3] - cx, cy - xa[4], xa[5], xa[6] - cx, cy - xa[7], xa[8], err_b, err_a,
            )  # fmt: skip
            note(floats, integers, times, candidates, FACE_VERTEX, pa, 0, pb, s, v0, lo0, hi0)
            note(floats, integers, times, candidates, FACE_VERTEX, pa, 0, pb, s, v1, lo1, hi1)


@kernel
def note(floats, integers, times, candidates, kind, part_a, side_a, part_b, side_b, verdict, lo, hi):
    """Record a possible contact that may lie in the window."""
    if verdict != NONE and hi >= floats[FIRST] and lo <= floats[BEST]:
        record(floats, integers, times, candidates, kind, part_a, side_a, part_b, side_b, verdict, lo, hi)


@overload(earliest_meeting)
def _earliest_meeting(motion, boxes_a, a, boxes_b, b, pad, first, last):
    if isinstance(motion, types.BaseTuple):
        return lambda motion, boxes_a, a, boxes_b, b, pad, first, last: entry_angle(
            motion, boxes_a, a, boxes_b, b, pad, first, last
        )
    return None


@overload(test_events)
def _test_events(
    motion, pa, mask_a, xa, pb, mask_b, xb, sides, err_a, err_b, floats, integers, times, candidates
):
    if isinstance(motion, types.BaseTuple):
        return _events
    return None
