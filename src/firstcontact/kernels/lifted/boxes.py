"""Axis-parallel boxes of triangles and of their parts inside a cell."""

from __future__ import annotations

from firstcontact.kernels.jit import uncounted

# A clipped corner lies within CLIP_EPS * (largest coordinate) of its true place: one division, one product
# and two sums of numbers no larger than that.  Smaller: parts of a triangle could leave their box.
CLIP_EPS = 1e-15


@uncounted
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


@uncounted
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
