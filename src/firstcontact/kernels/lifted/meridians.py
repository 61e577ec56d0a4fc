"""Which parts of two bodies may meet in a turn about an axis along z at all: a turn keeps heights and distances.

In a slab of heights the values of r^2 - q(z) on a part fill an interval; q, a quadratic near r^2 of one side, makes all
of them narrow where the parts line surfaces of revolution, as rulings of hyperboloids do.  Parts whose interval misses
the hull of those of the other body meet nothing there.  What is left is looked at again in both halves of the slab,
while that drops enough; so the work is a few looks at every part.

On a side r^2 - q is quadratic: its Bernstein coefficients bound it.  A triangle has a chord between two sides at each
height: r^2 is convex along it, and a chord of length d sinks by d^2 / 4 at most below the nearer of its ends.

Rounding: with e = `slack_of` the common points of two parts have heights and distances within e of those of the parts
as they are stored; then r^2 differs by (2 R + e) 1.5 e and q by |q'| e.  Coefficients are sums of 20 products of
the sizes of R^2 and q, each off by 2^-53.
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.jit import kernel, uncounted
from firstcontact.kernels.lifted.swept_cell import between, slack_of

# Looks at parts, per part; slabs; and parts that are so few that to drop some of them gains nothing.
LOOKS, SLABS, FEW = 12, 1024, 16
# Slabs of this depth are cut only if so small a share of their parts is left; any but the first, of all parts.
PATIENCE, SHARE, NEARLY_ALL = 2, 0.75, 0.99
# Squares of sizes between these neither overflow nor vanish.
_TINY, _HUGE = 1e-100, 1e100
_U = 2.0**-53


@kernel
def may_meet_turning(xyz, m, cx, cy, err):
    """Of the parts (m + n, 9), the first m of a: false only where a part meets none of the other body at any angle."""
    count = xyz.shape[0]
    meets = np.zeros(count, np.bool_)
    far, size, bottom, top = _extent(xyz, m, cx, cy)
    if not _TINY < far < _HUGE:
        meets[:] = True
        return meets
    slack = slack_of(far, err)
    lists, ranges = np.empty(LOOKS * count, np.int32), np.empty((count, 2))
    slabs, heights = np.empty((SLABS, 4), np.int64), np.empty((SLABS, 2))
    for i in range(count):
        lists[i] = i
    slabs[0, 0], slabs[0, 1], slabs[0, 2], slabs[0, 3] = 0, m, count, 0
    heights[0, 0], heights[0, 1] = bottom - slack, top + slack
    known, used, done = 1, count, 0
    while done < known:
        first, middle, last, depth = slabs[done]
        lo, hi = heights[done]
        done += 1
        left_a, left = _keep(xyz, lists, first, middle, last, lo - slack, hi + slack, cx, cy, size, slack, ranges)
        idle = depth >= PATIENCE and left > SHARE * (last - first) or depth > 0 and left > NEARLY_ALL * count
        if left <= FEW or idle or known + 2 > SLABS or used + 2 * left > lists.shape[0]:
            for k in range(first, first + left):
                meets[lists[k]] = True
            continue
        for half in range(2):
            low, high = (lo, 0.5 * (lo + hi)) if half == 0 else (0.5 * (lo + hi), hi)
            begin, split = used, used
            for k in range(first, first + left):
                x = xyz[lists[k]]
                if min(x[2], x[5], x[8]) <= high + slack and max(x[2], x[5], x[8]) >= low - slack:
                    lists[used] = lists[k]
                    used += 1
                    if k < first + left_a:
                        split = used
            slabs[known, 0], slabs[known, 1], slabs[known, 2], slabs[known, 3] = begin, split, used, depth + 1
            heights[known, 0], heights[known, 1] = low, high
            known += 1
    return meets


@uncounted
def _extent(xyz, m, cx, cy):
    """(largest coordinate, largest distance or a little more, bottom and top of the heights that both have)."""
    far, size = max(abs(cx), abs(cy)), 0.0
    bottom, top = -np.inf, np.inf
    low, high = np.inf, -np.inf
    for i in range(xyz.shape[0]):
        if i == m:
            bottom, top, low, high = low, high, np.inf, -np.inf
        x = xyz[i]
        for k in range(0, 9, 3):
            if not abs(x[k]) + abs(x[k + 1]) + abs(x[k + 2]) < _HUGE:
                return np.inf, np.inf, bottom, top
            far = max(far, abs(x[k]), abs(x[k + 1]), abs(x[k + 2]))
            size = max(size, abs(x[k] - cx) + abs(x[k + 1] - cy))
            low, high = min(low, x[k + 2]), max(high, x[k + 2])
    return far, size, max(bottom, low), min(top, high)


@uncounted
def _keep(xyz, lists, first, middle, last, bottom, top, cx, cy, size, slack, ranges):
    """Move to the front of lists[first:last] what may meet the other body between two heights: (of a, of both)."""
    base, q0, q1, q2 = _reference(xyz, lists, first, last, bottom, top, cx, cy)
    half = 0.5 * (top - bottom)
    steep, high = abs(q1) + 2.0 * q2 * half, abs(q0) + (abs(q1) + q2 * half) * half
    pad = slack * (1.5 * (2.0 * size + slack) + steep) + 256.0 * _U * (size * size + high)
    for k in range(first, last):
        ranges[k - first, 0], ranges[k - first, 1] = _range(xyz[lists[k]], bottom, top, cx, cy, base, q0, q1, q2)
    end_a, end_b, before = middle, last, last - first + 1
    while end_a - first + end_b - middle < before:
        before = end_a - first + end_b - middle
        low, high = _hull(ranges, middle - first, end_b - first)
        end_a = _near(lists, ranges, first, first, end_a, low - pad, high + pad)
        low, high = _hull(ranges, 0, end_a - first)
        end_b = _near(lists, ranges, first, middle, end_b, low - pad, high + pad)
    end = end_a
    for k in range(middle, end_b):
        lists[end] = lists[k]
        end += 1
    return end_a - first, end - first


@uncounted
def _hull(ranges, first, last):
    low, high = np.inf, -np.inf
    for k in range(first, last):
        low, high = min(low, ranges[k, 0]), max(high, ranges[k, 1])
    return low, high


@uncounted
def _near(lists, ranges, base, first, last, low, high):
    """Move to the front what has a range (not an empty one) that meets [low, high]; where that ends."""
    end = first
    for k in range(first, last):
        lo, hi = ranges[k - base]
        if lo <= high and hi >= low and lo <= hi:
            lists[end] = lists[k]
            ranges[end - base, 0], ranges[end - base, 1] = lo, hi
            end += 1
    return end


@uncounted
def _reference(xyz, lists, first, last, bottom, top, cx, cy):
    """(base, q0, q1, q2): r^2 of a side that rises through most of the slab, by powers of z - base; else zeros."""
    base, longest = 0.5 * (bottom + top), 0.5 * (top - bottom)
    q0, q1, q2 = 0.0, 0.0, 0.0
    for k in range(first, last, max(1, (last - first) // 64)):
        x = xyz[lists[k]]
        for i in range(0, 9, 3):
            j = (i + 3) % 9
            rise = x[j + 2] - x[i + 2]
            inside = min(top, max(x[i + 2], x[j + 2])) - max(bottom, min(x[i + 2], x[j + 2]))
            if inside > longest:
                longest = inside
                u, v = (x[j] - x[i]) / rise, (x[j + 1] - x[i + 1]) / rise
                p, q = x[i] - cx + (base - x[i + 2]) * u, x[i + 1] - cy + (base - x[i + 2]) * v
                q0, q1, q2 = p * p + q * q, 2.0 * (p * u + q * v), u * u + v * v
    return base, q0, q1, q2


@uncounted
def _range(x, bottom, top, cx, cy, base, q0, q1, q2):
    """Bounds of r^2 - q on the part between two heights; (inf, -inf) where it has no point there."""
    low, high = np.inf, -np.inf
    for i in range(0, 9, 3):
        j = (i + 3) % 9
        s, t = between(x[i + 2], x[j + 2], bottom, top)
        if s > t:
            continue
        d, e, rise = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
        p0, p1, p2 = x[i] - cx + s * d, x[i + 1] - cy + s * e, x[i + 2] - base + s * rise
        r0, r1, r2 = x[i] - cx + t * d, x[i + 1] - cy + t * e, x[i + 2] - base + t * rise
        c = p0 * p0 + p1 * p1 - (q0 + (q1 + q2 * p2) * p2)
        f = p0 * r0 + p1 * r1 - (q0 + 0.5 * q1 * (p2 + r2) + q2 * p2 * r2)
        g = r0 * r0 + r1 * r1 - (q0 + (q1 + q2 * r2) * r2)
        low, high = min(low, c, f, g), max(high, c, f, g)
    return low - 0.25 * _squared_chord(x), high


@uncounted
def _squared_chord(x):
    """Not less than that of the longest horizontal chord of a triangle but for rounding; 0 of an edge or a point."""
    if x[3] == x[6] and x[4] == x[7] and x[5] == x[8]:
        return 0.0
    i, j, k = 0, 3, 6  # lowest, middle, highest corner
    if x[j + 2] < x[i + 2]:
        i, j = j, i
    if x[k + 2] < x[j + 2]:
        j, k = k, j
    if x[j + 2] < x[i + 2]:
        i, j = j, i
    rise = x[k + 2] - x[i + 2]
    if rise == 0.0:
        most = 0.0
        for a in range(0, 9, 3):
            b = (a + 3) % 9
            most = max(most, (x[b] - x[a]) ** 2 + (x[b + 1] - x[a + 1]) ** 2)
        return most
    t = (x[j + 2] - x[i + 2]) / rise
    return (x[i] + t * (x[k] - x[i]) - x[j]) ** 2 + (x[i + 1] + t * (x[k + 1] - x[i + 1]) - x[j + 1]) ** 2
