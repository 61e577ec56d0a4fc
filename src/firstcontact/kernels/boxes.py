"""Axis-parallel boxes of triangles and of their parts inside a cell."""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.jit import kernel

# A clipped corner lies within CLIP_EPS * (largest coordinate) of its true place: one division, one product
# and two sums of numbers no larger than that.  Smaller: parts of a triangle could leave their box.
CLIP_EPS = 1e-15


@kernel
def clip_to_box(xyz, box, polygon, scratch):
    """Corners of the triangle `xyz` (9,) inside `box` (6,): fills polygon (12, 3), returns their number."""
    for k in range(3):
        for j in range(3):
            polygon[k, j] = xyz[3 * k + j]
    n = 3
    for axis in range(3):
        for upper in range(2):
            limit = box[axis + 3 * upper]
            sign = -1.0 if upper else 1.0
            inside = True
            for k in range(n):
                inside = inside and sign * (polygon[k, axis] - limit) >= 0.0
            if inside:
                continue
            kept = 0
            for k in range(n):
                here, there = k, (k + 1) % n
                d0 = sign * (polygon[here, axis] - limit)
                d1 = sign * (polygon[there, axis] - limit)
                if d0 >= 0.0:
                    for j in range(3):
                        scratch[kept, j] = polygon[here, j]
                    kept += 1
                if (d0 > 0.0 and d1 < 0.0) or (d0 < 0.0 and d1 > 0.0):
                    s = d0 / (d0 - d1)
                    for j in range(3):
                        scratch[kept, j] = polygon[here, j] + s * (polygon[there, j] - polygon[here, j])
                    scratch[kept, axis] = limit
                    kept += 1
            n = kept
            for k in range(n):
                for j in range(3):
                    polygon[k, j] = scratch[k, j]
    return n


@kernel
def segment_meets_box(p, q, box, pad):
    """False only when the segment between p and q (3,) certainly misses the box grown by `pad`."""
    t0, t1 = 0.0, 1.0
    for k in range(3):
        lo, hi = box[k] - pad, box[k + 3] + pad
        d = q[k] - p[k]
        if d == 0.0:
            if p[k] < lo or p[k] > hi:
                return False
            continue
        ta, tb = (lo - p[k]) / d, (hi - p[k]) / d
        if ta > tb:
            ta, tb = tb, ta
        # a division and a difference: relative error below 4 * 2^-53, so widen by 1e-15
        t0 = max(t0, ta - 1e-15 * (1.0 + abs(ta)))
        t1 = min(t1, tb + 1e-15 * (1.0 + abs(tb)))
    return t0 <= t1


@kernel
def triangle_meets_box(xyz, box, pad):
    """False only when the triangle `xyz` (9,) certainly misses the box grown by `pad`.

    Looks at the box's axes, the triangle's plane and the planes through its sides across it, so that a triangle that
    passes a corner of the box closely may count.  Of e, f (two sides) and n = e x f the sums |e| + |f| carry the error
    of n and of m = n x side: a few roundings of products of their sizes.
    """
    for k in range(3):
        if min(xyz[k], xyz[k + 3], xyz[k + 6]) > box[k + 3] + pad or max(xyz[k], xyz[k + 3], xyz[k + 6]) < box[k] - pad:
            return False
    e0, e1, e2 = xyz[3] - xyz[0], xyz[4] - xyz[1], xyz[5] - xyz[2]
    f0, f1, f2 = xyz[6] - xyz[0], xyz[7] - xyz[1], xyz[8] - xyz[2]
    n0, n1, n2 = e1 * f2 - e2 * f1, e2 * f0 - e0 * f2, e0 * f1 - e1 * f0
    size = max(abs(e0) + abs(e1) + abs(e2), abs(f0) + abs(f1) + abs(f2))
    # the box's middle and half lengths, seen from the first corner
    h0, h1, h2 = 0.5 * (box[3] - box[0]) + pad, 0.5 * (box[4] - box[1]) + pad, 0.5 * (box[5] - box[2]) + pad
    c0, c1, c2 = 0.5 * (box[0] + box[3]), 0.5 * (box[1] + box[4]), 0.5 * (box[2] + box[5])
    x0, x1, x2 = c0 - xyz[0], c1 - xyz[1], c2 - xyz[2]
    # differences round by the size of what is subtracted
    far = abs(c0) + abs(c1) + abs(c2) + abs(xyz[0]) + abs(xyz[1]) + abs(xyz[2]) + h0 + h1 + h2 + size
    reach = abs(n0) * h0 + abs(n1) * h1 + abs(n2) * h2
    height = abs(n0 * x0 + n1 * x1 + n2 * x2)
    if reach + 2.0**-48 * size * size * far < height < np.inf:
        return False
    slack = 2.0**-46 * size * size * size * far
    for k in range(3):
        i, j = 3 * k, 3 * ((k + 1) % 3)
        g0, g1, g2 = xyz[j] - xyz[i], xyz[j + 1] - xyz[i + 1], xyz[j + 2] - xyz[i + 2]
        m0, m1, m2 = n1 * g2 - n2 * g1, n2 * g0 - n0 * g2, n0 * g1 - n1 * g0  # inward
        x0, x1, x2 = c0 - xyz[i], c1 - xyz[i + 1], c2 - xyz[i + 2]
        if -np.inf < m0 * x0 + m1 * x1 + m2 * x2 + abs(m0) * h0 + abs(m1) * h1 + abs(m2) * h2 < -slack:
            return False
    return True
