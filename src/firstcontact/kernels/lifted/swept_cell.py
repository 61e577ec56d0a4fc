"""A set of paths as boxes, and whether a facet may be met by one of them: separating axes, heights, distances.

What turns keeps its heights and its distances from the axis: they alone tell that edges never meet.

A path lies in the hull of two or three points; a cell (PATH_ROWS, 6) holds the box of each of them over all paths of
the set, and of circles about an axis along z the distances.  With u = 2^-53 and L the largest coordinate: any direction
m serves as a separating axis, however it was rounded, since sums along it are within 4 u |m| L; corners of hulls of
circles within 11 u L; coordinates of paths and facets are off by `err` in all.  `slack_of` is beyond all of that.
"""

from __future__ import annotations

import math

import numpy as np

from firstcontact.kernels.jit import kernel, uncounted
from firstcontact.kernels.verdict import LOST

# Rows: boxes of the corners of the hulls; the box of all; then the number of corners, whether paths are circles, axis,
# the largest coordinate; and the distances from the axis.
WHOLE, HULLS, ROUND, PATH_ROWS = 3, 4, 5, 6
CIRCLES, CENTRE, FAR = 1, 2, 4
_U = 2.0**-53


@uncounted
def turns(motion):
    """Whether a motion turns.  All are of one type here: that of `translate` is one row, that of `rotate` several."""
    return motion.shape[0] > 1


@uncounted
def axis_of(motion):
    """x and y of the axis; zeros where nothing turns."""
    if not turns(motion):
        return 0.0, 0.0
    return motion[motion.shape[0] - 1, 0], motion[motion.shape[0] - 1, 1]


@uncounted
def begin_cell(cell, still, motion):
    cx, cy = axis_of(motion)
    for r in range(4):
        for k in range(3):
            cell[r, k], cell[r, k + 3] = np.inf, -np.inf
    cell[HULLS, 0], cell[HULLS, CIRCLES] = 0.0, 1.0 if turns(motion) and not still else 0.0
    cell[HULLS, CENTRE], cell[HULLS, CENTRE + 1], cell[HULLS, FAR] = cx, cy, max(abs(cx), abs(cy))
    cell[ROUND, 0], cell[ROUND, 1] = np.inf, 0.0


@uncounted
def put_path(cell, work, corners):
    """Add the path with so many corners of its hull, the first rows of work."""
    cell[HULLS, 0] = corners
    whole = cell[WHOLE]
    for c in range(corners):
        box = cell[c]
        for k in range(3):
            x = work[c, k]
            box[k], box[k + 3] = min(box[k], x), max(box[k + 3], x)
            whole[k], whole[k + 3] = min(whole[k], x), max(whole[k + 3], x)
            cell[HULLS, FAR] = max(cell[HULLS, FAR], abs(x))
    if cell[HULLS, CIRCLES] != 0.0:
        x, y = work[0, 0] - cell[HULLS, CENTRE], work[0, 1] - cell[HULLS, CENTRE + 1]
        r = math.sqrt(x * x + y * y)
        cell[ROUND, 0], cell[ROUND, 1] = min(cell[ROUND, 0], r), max(cell[ROUND, 1], r)


@uncounted
def slack_of(far, err):
    return 2.0 * err + 64.0 * _U * far


@uncounted
def facet_may_meet(cell, x, err):
    """False only when no path of the cell meets the triangle x (9,)."""
    whole = cell[WHOLE]
    far = cell[HULLS, FAR]
    for k in range(9):
        far = max(far, abs(x[k]))
    slack = slack_of(far, err)
    for k in range(3):
        if whole[k] > max(x[k], x[k + 3], x[k + 6]) + slack or whole[k + 3] < min(x[k], x[k + 3], x[k + 6]) - slack:
            return False
    if cell[HULLS, CIRCLES] != 0.0 and _distances_differ(cell, x, slack):
        return False
    a0, a1, a2 = x[3] - x[0], x[4] - x[1], x[5] - x[2]
    b0, b1, b2 = x[6] - x[0], x[7] - x[1], x[8] - x[2]
    if _separates(cell, x, a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0, slack):
        return False
    start, end = cell[0], cell[int(cell[HULLS, 0]) - 1]
    d0 = (end[0] + end[3]) - (start[0] + start[3])
    d1 = (end[1] + end[4]) - (start[1] + start[4])
    d2 = (end[2] + end[5]) - (start[2] + start[5])
    return not (
        _separates(cell, x, a1 * d2 - a2 * d1, a2 * d0 - a0 * d2, a0 * d1 - a1 * d0, slack)
        or _separates(cell, x, b1 * d2 - b2 * d1, b2 * d0 - b0 * d2, b0 * d1 - b1 * d0, slack)
        or _separates(
            cell, x, (b1 - a1) * d2 - (b2 - a2) * d1, (b2 - a2) * d0 - (b0 - a0) * d2,
            (b0 - a0) * d1 - (b1 - a1) * d0, slack,
        )
    )  # fmt: skip


@uncounted
def _separates(cell, x, m0, m1, m2, slack):
    """Whether the triangle lies strictly on one side of all paths along the axis m; false when that is not a number."""
    p, q = (m0 * x[0] + m1 * x[1]) + m2 * x[2], (m0 * x[3] + m1 * x[4]) + m2 * x[5]
    r = (m0 * x[6] + m1 * x[7]) + m2 * x[8]
    pad = slack * (abs(m0) + abs(m1) + abs(m2)) + LOST
    lo, hi = min(p, q, r) - pad, max(p, q, r) + pad
    above, below = True, True
    for c in range(int(cell[HULLS, 0])):
        box = cell[c]
        u0, v0 = (box[0], box[3]) if m0 >= 0.0 else (box[3], box[0])
        u1, v1 = (box[1], box[4]) if m1 >= 0.0 else (box[4], box[1])
        u2, v2 = (box[2], box[5]) if m2 >= 0.0 else (box[5], box[2])
        above = above and (m0 * u0 + m1 * u1) + m2 * u2 > hi
        below = below and (m0 * v0 + m1 * v1) + m2 * v2 < lo
    return above or below


@uncounted
def _distances_differ(cell, x, slack):
    """Whether, at the heights of the circles, the triangle is farther from the axis than all of them, or nearer.

    What lies between two heights is the hull of what its sides have there.  The distance is convex: its largest value
    is at a corner of that, and along any direction no point is farther than its distance.
    """
    whole, cx, cy = cell[WHOLE], cell[HULLS, CENTRE], cell[HULLS, CENTRE + 1]
    bottom, top = whole[2] - slack, whole[5] + slack
    farthest, u, v = -1.0, 0.0, 0.0
    for s in range(3):
        found, p0, q0, p1, q1 = _clipped_side(x, s, bottom, top, cx, cy)
        if found:
            farthest = max(farthest, math.sqrt(p0 * p0 + q0 * q0), math.sqrt(p1 * p1 + q1 * q1))
            u, v = u + p0 + p1, v + q0 + q1
    if farthest < 0.0:
        return False
    if farthest < cell[ROUND, 0] - 2.0 * slack:
        return True
    length = math.sqrt(u * u + v * v)
    if not length > 0.0:
        return False
    u, v = u / length, v / length
    nearest = np.inf
    for s in range(3):
        found, p0, q0, p1, q1 = _clipped_side(x, s, bottom, top, cx, cy)
        if found:
            nearest = min(nearest, u * p0 + v * q0, u * p1 + v * q1)
    return nearest > cell[ROUND, 1] + 2.0 * slack


@uncounted
def _clipped_side(x, s, bottom, top, cx, cy):
    """(whether there is any, p, q, p', q'): the ends, from the axis, of what of a side lies between two heights."""
    i, j = 3 * s, 3 * ((s + 1) % 3)
    lo, hi = between(x[i + 2], x[j + 2], bottom, top)
    p, q, d, e = x[i], x[i + 1], x[j] - x[i], x[j + 1] - x[i + 1]
    return lo <= hi, p + lo * d - cx, q + lo * e - cy, p + hi * d - cx, q + hi * e - cy


@uncounted
def edge_keeps_off(x, bottom, top, nearest, farthest, cx, cy, err):
    """Whether the edge x (9,), turning about the axis, meets nothing between two heights and two distances."""
    far = max(abs(cx), abs(cy), abs(bottom), abs(top))
    for k in range(6):
        far = max(far, abs(x[k]))
    slack = slack_of(far, err)
    lo, hi = between(x[2], x[5], bottom - slack, top + slack)
    if lo > hi:
        return True
    least, most = _distances(x, lo, hi, cx, cy)
    return least > farthest + 2.0 * slack or most < nearest - 2.0 * slack


@uncounted
def _distances(x, lo, hi, cx, cy):
    """(least, largest) distance from the axis on the share [lo, hi] of the edge."""
    p, q, d, e = x[0] - cx, x[1] - cy, x[3] - x[0], x[4] - x[1]
    length = d * d + e * e
    w = min(hi, max(lo, -(p * d + q * e) / length)) if length > 0.0 else lo
    first = math.sqrt((p + lo * d) ** 2 + (q + lo * e) ** 2)
    last = math.sqrt((p + hi * d) ** 2 + (q + hi * e) ** 2)
    return min(first, last, math.sqrt((p + w * d) ** 2 + (q + w * e) ** 2)), max(first, last)


@kernel
def edge_distances(corners, motion):
    """(m, 2) least and largest distance of edges (m, 9) from the axis; (0, 2) where nothing turns."""
    cx, cy = axis_of(motion)
    out = np.empty((corners.shape[0] if turns(motion) else 0, 2))
    for i in range(out.shape[0]):
        out[i, 0], out[i, 1] = _distances(corners[i], 0.0, 1.0, cx, cy)
    return out


@uncounted
def between(z0, z1, bottom, top):
    """The share [lo, hi] of a side from height z0 to z1 that lies between two heights; lo > hi where there is none."""
    if max(z0, z1) < bottom or min(z0, z1) > top:
        return 1.0, 0.0
    rise = z1 - z0
    if rise == 0.0:
        return 0.0, 1.0
    s, t = (bottom - z0) / rise, (top - z0) / rise
    if rise < 0.0:
        s, t = t, s
    return max(0.0, s), min(1.0, t)
