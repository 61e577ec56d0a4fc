"""Ranges of nodes in cylindrical coordinates about the axis of a rotation, worked out when a walk first needs them.

A row of `motion` (see `rotate`) holds what a visit reads of a node: squared radius lo, hi, first angle, width of the
angles, height lo, hi, a measure of the size, and 1 where it is known.  Boxes are fat about the axis where the body
lies obliquely; the triangles themselves and unions of small boxes are not, so the row of a node is that of the
boxes, or the parts of leaves, two levels below.  It depends on the tree alone, whatever was visited before.

All ranges are outward: they hold the true parts, whose coordinates are off by `pad` at most.
"""

from __future__ import annotations

import math

import numpy as np

from firstcontact.kernels.angle import ANGLE_EPS, TWO_PI, angle_of
from firstcontact.kernels.jit import kernel, uncounted
from firstcontact.kernels.lifted.boxes import CLIP_EPS, clip_to_box
from firstcontact.search.trees.tree import SPLIT

R_LO, R_HI, PHI, WIDTH, Z_LO, Z_HI, SIZE, KNOWN = range(8)
COLUMNS = 8
FULL_CIRCLE = 2.0 * TWO_PI  # width of a range around the axis: overlaps every range of angles


@uncounted
def learn(motion, offset, boxes, links, xyz, ids, node, pad):
    """Fill the node's row, `offset` rows behind its number, from two levels below it."""
    end = motion.shape[0] - 1
    cx, cy = motion[end, 0], motion[end, 1]
    found = _range_of(boxes, links, xyz, ids, node, cx, cy, pad)
    if links[node, 1] >= 0:
        left = _range_below(boxes, links, xyz, ids, np.int64(links[node, 0]), cx, cy, pad)
        right = _range_below(boxes, links, xyz, ids, np.int64(links[node, 1]), cx, cy, pad)
        found = unite(left, right)
    row = motion[offset + node]
    row[R_LO], row[R_HI], row[PHI], row[WIDTH], row[Z_LO], row[Z_HI] = found
    near, far = math.sqrt(row[R_LO]), math.sqrt(row[R_HI])
    x, y, z = far - near, min(row[WIDTH], TWO_PI) * 0.5 * (near + far), row[Z_HI] - row[Z_LO]
    row[SIZE] = x * y + y * z + z * x
    row[KNOWN] = 1.0


@uncounted
def _range_below(boxes, links, xyz, ids, node, cx, cy, pad):
    """The range of a node from one level below it."""
    if links[node, 1] < 0:
        return range_of_part(boxes[node], xyz[links[node, 0]], ids[links[node, 0], 1], cx, cy, pad)
    left = _range_of(boxes, links, xyz, ids, np.int64(links[node, 0]), cx, cy, pad)
    return unite(left, _range_of(boxes, links, xyz, ids, np.int64(links[node, 1]), cx, cy, pad))


@uncounted
def _range_of(boxes, links, xyz, ids, node, cx, cy, pad):
    if links[node, 1] < 0:
        return range_of_part(boxes[node], xyz[links[node, 0]], ids[links[node, 0], 1], cx, cy, pad)
    return range_of_box(boxes[node], cx, cy, pad)


@kernel
def range_of_part(box, xyz, mask, cx, cy, pad):
    """The range of a leaf's triangle, edge or point about (cx, cy), cut to the leaf's box where it is split."""
    polygon = np.empty((12, 3))
    off = 1.5 * pad  # the true point lies within sqrt(2) pad across the axis
    n = 0
    if mask & SPLIT:
        n = clip_to_box(xyz, box, polygon, np.empty((12, 3)))
        largest = 0.0
        for k in range(9):
            largest = max(largest, abs(xyz[k]))
        off += 4.0 * CLIP_EPS * largest
    if n == 0:
        n = 3
        for k in range(9):
            polygon[k // 3, k % 3] = xyz[k]
    x, y = polygon[n - 1, 0] - cx, polygon[n - 1, 1] - cy
    start = angle_of(x, y) if x != 0.0 or y != 0.0 else 0.0
    near, far, lo, hi = np.inf, 0.0, 0.0, 0.0
    for k in range(n):  # the side from (x, y) to (u, v)
        u, v = polygon[k, 0] - cx, polygon[k, 1] - cy
        radius = u * u + v * v
        near, far = min(near, radius), max(far, radius)
        e, f = u - x, v - y
        length, ahead = e * e + f * f, -(x * e + y * f)
        if 0.0 < ahead < length:
            across = x * f - y * e
            near = min(near, across * across / length)
        turn = (angle_of(u, v) if radius > 0.0 else 0.0) - start
        turn = turn - TWO_PI if turn > math.pi else turn + TWO_PI if turn < -math.pi else turn
        lo, hi = min(lo, turn), max(hi, turn)
        x, y = u, v
    far = math.sqrt(far)
    near = math.sqrt(near) - 1e-14 * far - off
    far = far * (1.0 + 1e-14) + off
    first, width = 0.0, FULL_CIRCLE
    if hi - lo >= 3.14159265:  # corners in less than a half plane say that the axis lies outside
        near = 0.0
    elif near > 0.0:
        extra = 1.58 * off / near + 4.0 * ANGLE_EPS  # asin(x) <= 1.58 x
        first, width = start + lo - extra, hi - lo + 2.0 * extra
        first = first + TWO_PI if first < 0.0 else first
    near = max(near, 0.0)
    return near * near * (1.0 - 1e-15), far * far * (1.0 + 1e-15), first, width, box[2], box[5]


@uncounted
def range_of_box(box, cx, cy, pad):
    """The range of a box about (cx, cy), grown by `pad`."""
    x0, x1 = box[0] - cx - pad, box[3] - cx + pad
    y0, y1 = box[1] - cy - pad, box[4] - cy + pad
    # the differences round by 2^-53 relative to their own size: widen by twice that
    x0, x1, y0, y1 = x0 - 4e-16 * abs(x0), x1 + 4e-16 * abs(x1), y0 - 4e-16 * abs(y0), y1 + 4e-16 * abs(y1)
    dx, dy = max(x0, -x1, 0.0), max(y0, -y1, 0.0)
    fx, fy = max(-x0, x1), max(-y0, y1)
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
        first, last = 0.0, FULL_CIRCLE
    width = last - first if last >= first else last - first + TWO_PI
    near, far = (dx * dx + dy * dy) * (1.0 - 1e-15), (fx * fx + fy * fy) * (1.0 + 1e-15)
    return near, far, first, width, box[2], box[5]


@uncounted
def unite(i, j):
    """The range of two ranges together; angles the shorter way round, a little wider than rounding makes them."""
    ahead = j[PHI] - i[PHI]
    if ahead < 0.0:
        ahead += TWO_PI
    from_i = max(i[WIDTH], ahead + j[WIDTH])
    from_j = max(j[WIDTH], TWO_PI - ahead + i[WIDTH])
    first, width = (i[PHI], from_i) if from_i <= from_j else (j[PHI], from_j)
    first, width = first - 4e-15, width + 8e-15
    if width >= TWO_PI:
        first, width = 0.0, FULL_CIRCLE
    first = first + TWO_PI if first < 0.0 else first
    near, far = min(i[R_LO], j[R_LO]), max(i[R_HI], j[R_HI])
    return near, far, first, width, min(i[Z_LO], j[Z_LO]), max(i[Z_HI], j[Z_HI])
