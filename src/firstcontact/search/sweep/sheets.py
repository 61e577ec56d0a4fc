"""Facets as seen along circles about an axis: sheets over the plane of x, the height, and y, the squared distance.

Without its angle a point of a plane is (x, y) with y = d^2 + q^2: d = d0 + d1 x is how far the plane is from the axis
at that height, q how far the point is from the foot there.  The feet form the fold line q = 0.  A circle meets the
plane on both sides of it, at the angles of the foot plus and less atan(|q| / d).

So facets are cut along q = +-w and by the half-plane of the angle 0.  What is left has one angle over each point, and
the images of its sides are parabolas, of which the lower and upper one between two heights of corners bound a cell.
The strip |q| < w next to the fold line, where angles change quickly, is loose; it is seen as a thin cell.

Why looking at corners tells the order of two sheets P and Q over all that they share, if they keep off their fold
lines by w or more.  At one height the difference of the angles has one sense in y.  So it is least on an arc, say of P.
Along that side of P, a straight line, the distance l from the plane of Q is linear; where the angle of P passes that of
Q, l is zero.  In units in which no distance is more than 1: if Q is behind P by no more than t, as a length along the
circle, wherever the arc begins or ends, and cells reach so little beyond their sheets that l is not linear by t at
most, then |l| <= 4 t wherever Q is behind P.  Then it is behind by 4 t / (0.7 w) at most, unless 4 t > 0.35 w^2.  With
t = REACH MARGIN (1/w + 1/w') and w, w' >= LEAST_WIDTH it is not, and the angles of two neighbours are in order but for
366 REACH MARGIN (1/w^2 + 1/w'^2) / 32.
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.angle import TWO_PI, angle_of
from firstcontact.kernels.jit import kernel, uncounted
from firstcontact.search.sweep.sweep import MARGIN, STEEP_SIDE, at

# A sheet is off by REACH * MARGIN / w at most within its cells; others are loose.
REACH = 32.0
LEAST_WIDTH = 2.0**-6
# The strip next to the fold line is so much narrower than its facet.
STRIP = 8.0
# Angles of all in one tree are in order but for the sum of SLACK / w^2.
SLACK = 768.0 * MARGIN
# Cells of one facet: four pieces of at most 6 corners and the strip.
MOST_CELLS = 21


@kernel
def sheets_of(corners, noise):
    """The cells of facets with corners (f, 3, 3): across the axis in units in which the farthest is at 1, and height.

    Returns, per cell: the facet, x, arcs, heights, tolerances (inf: loose) and slacks in the order of angles.
    """
    f = corners.shape[0]
    most = MOST_CELLS * f
    owners, x, bounds = np.empty(most, np.int32), np.empty((most, 2)), np.zeros((most, 2, 4))
    heights, tolerances, slacks = np.zeros((most, 4)), np.full(most, np.inf), np.zeros(most)
    whole, half, piece = np.empty((12, 2)), np.empty((12, 2)), np.empty((12, 2))
    plane, levels = np.empty(4), np.empty(12)
    count = 0
    for i in range(f):
        first, p = count, corners[i]
        if _write_plane(p, noise, plane):
            widest = 0.0
            for k in range(3):
                whole[k, 0], whole[k, 1] = p[k, 2], plane[2] * p[k, 1] - plane[3] * p[k, 0]
                widest = max(widest, abs(whole[k, 1]))
            strip = max(LEAST_WIDTH, widest / STRIP)
            n = _clip(whole, 3, 0.0, 1.0, strip, half)
            n = _clip(half, n, 0.0, -1.0, strip, piece)
            if n > 0:
                _write_strip(piece, n, plane, strip, x[count], bounds[count])
                count += 1
            for side in (-1.0, 1.0):
                n = _clip(whole, 3, 0.0, side, -strip, half)
                if n < 3:
                    continue
                if _holds_angle_zero(half, n, plane):
                    for way in (-1.0, 1.0):
                        a, b, c = plane[1] * plane[3], plane[2], plane[0] * plane[3]
                        m = _clip(half, n, way * a, way * b, way * c, piece)
                        count = _add_cells(piece, m, plane, side, levels, count, x, bounds, heights, tolerances, slacks)
                else:
                    count = _add_cells(half, n, plane, side, levels, count, x, bounds, heights, tolerances, slacks)
        if count == first:
            _write_box(p, x[count], bounds[count])
            count += 1
        owners[first:count] = i
    arcs = bounds[:count].copy().reshape(-1, 4)
    return owners[:count], x[:count], arcs, heights[:count], tolerances[:count], slacks[:count]


@uncounted
def _write_plane(p, noise, plane):
    """Write d0, d1 and the direction of the foot, cosine and sine; False where the plane is too level or uncertain."""
    shortest, longest, k = np.inf, 0.0, 0
    for i in range(3):
        j = i + 1 if i < 2 else 0
        length = abs(p[j, 0] - p[i, 0]) + abs(p[j, 1] - p[i, 1]) + abs(p[j, 2] - p[i, 2])
        longest = max(longest, length)
        if length < shortest:
            shortest, k = length, i
    i, j = (k + 1) % 3, (k + 2) % 3
    # with its shortest side a slender facet has a product of the size of its area: roundings turn it about its length
    e0, e1, e2 = p[i, 0] - p[k, 0], p[i, 1] - p[k, 1], p[i, 2] - p[k, 2]
    f0, f1, f2 = p[j, 0] - p[k, 0], p[j, 1] - p[k, 1], p[j, 2] - p[k, 2]
    n0, n1, n2 = e1 * f2 - e2 * f1, e2 * f0 - e0 * f2, e0 * f1 - e1 * f0
    across = np.hypot(n0, n1)
    # beyond its sides a plane is off by more
    beyond = REACH * MARGIN / LEAST_WIDTH * longest
    if not (16.0 * noise * (across + beyond) <= MARGIN * across and 2.0 * abs(n2) <= REACH * across):
        return False
    plane[2], plane[3] = n0 / across, n1 / across
    plane[1] = -n2 / across
    plane[0] = plane[2] * p[0, 0] + plane[3] * p[0, 1] - plane[1] * p[0, 2]
    return True


@uncounted
def _clip(polygon, count, a, b, c, out):
    """Write what of the convex polygon (x, q) has a x + b q + c >= 0; returns the number of its corners."""
    n = 0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        s, t = a * polygon[i, 0] + b * polygon[i, 1] + c, a * polygon[j, 0] + b * polygon[j, 1] + c
        if s >= 0.0:
            out[n, 0], out[n, 1] = polygon[i, 0], polygon[i, 1]
            n += 1
        if (s > 0.0 and t < 0.0) or (s < 0.0 and t > 0.0):
            u = s / (s - t)
            for k in range(2):
                out[n, k] = polygon[i, k] + u * (polygon[j, k] - polygon[i, k])
            n += 1
    return n


@uncounted
def _place(plane, x, q):
    """The point across the axis."""
    d = plane[0] + plane[1] * x
    return d * plane[2] - q * plane[3], d * plane[3] + q * plane[2]


@uncounted
def _holds_angle_zero(polygon, count, plane):
    """Whether the half-plane of the angle 0 passes through a polygon on one side of its fold line."""
    low, high, x_low, x_high = 0.0, 0.0, 0.0, 0.0
    for i in range(count):
        x, y = _place(plane, polygon[i, 0], polygon[i, 1])
        if y < low:
            low, x_low = y, x
        if y > high:
            high, x_high = y, x
    return low < 0.0 and high > 0.0 and x_low * high - x_high * low > 0.0


@uncounted
def _write_strip(polygon, count, plane, strip, x, arcs):
    """The cell of what lies within `strip` of the fold line."""
    x[0], x[1] = polygon[0, 0], polygon[0, 0]
    for i in range(1, count):
        x[0], x[1] = min(x[0], polygon[i, 0]), max(x[1], polygon[i, 0])
    middle, half = 0.5 * (x[0] + x[1]), 0.5 * (x[1] - x[0])
    for way in range(2):
        _write_arc(arcs[way], middle, half, plane, strip * way, 0.0, 2.0 * way - 1.0)
    x[0], x[1] = x[0] - MARGIN, x[1] + MARGIN


@uncounted
def _write_arc(arc, middle, half, plane, q, rise, way):
    """The image of q + rise (x - middle) and MARGIN away in the way -1 or 1; returns the slope's size.

    Where it is steep, a level line beyond it over all the cell.
    """
    d = plane[0] + plane[1] * middle
    arc[0], arc[1] = middle, d * d + q * q
    arc[2], arc[3] = 2.0 * (d * plane[1] + q * rise), plane[1] * plane[1] + rise * rise
    steepest = abs(arc[2]) + 2.0 * arc[3] * (half + MARGIN)
    if steepest <= STEEP_SIDE:
        arc[1] += way * MARGIN * (1.0 + steepest)
        return steepest
    y, z = at(arc, middle - half), at(arc, middle + half)
    if way > 0.0:
        y = max(y, z)
    else:
        y = min(y, z)
        lowest = middle - 0.5 * arc[2] / arc[3]
        if abs(lowest - middle) < half:
            y = min(y, at(arc, lowest))
    arc[1], arc[2], arc[3] = y + way * MARGIN * (1.0 + 2.0**-16 * steepest * half), 0.0, 0.0
    return np.inf


@uncounted
def _write_box(p, x, arcs):
    """The cell of a facet of which nothing is known but its corners."""
    x[0], x[1] = min(p[0, 2], p[1, 2], p[2, 2]) - MARGIN, max(p[0, 2], p[1, 2], p[2, 2]) + MARGIN
    far, near, turns = 0.0, np.inf, 0
    for k in range(3):
        j = k + 1 if k < 2 else 0
        u, v, e, f = p[k, 0], p[k, 1], p[j, 0] - p[k, 0], p[j, 1] - p[k, 1]
        far = max(far, u * u + v * v)
        s = 0.0
        if e != 0.0 or f != 0.0:
            s = min(max(-(u * e + v * f) / (e * e + f * f), 0.0), 1.0)
        u, v = u + s * e, v + s * f
        near = min(near, u * u + v * v)
        side = p[k, 0] * f - p[k, 1] * e
        turns += 1 if side > 0.0 else -1 if side < 0.0 else 0
    if abs(turns) == 3:  # around the axis
        near = 0.0
    for way in range(2):
        arcs[way, 0], arcs[way, 1] = 0.5 * (x[0] + x[1]), far + MARGIN if way else near - MARGIN
        arcs[way, 2], arcs[way, 3] = 0.0, 0.0


@uncounted
def _add_cells(polygon, count, plane, side, levels, at_cell, x, arcs, heights, tolerances, slacks):
    """The cells of a polygon on one side of the fold line, from `at_cell` on; returns where they end."""
    if count < 3:
        return at_cell
    mean_x, mean_q = 0.0, 0.0
    for i in range(count):
        mean_x, mean_q = mean_x + polygon[i, 0] / count, mean_q + polygon[i, 1] / count
        k = i
        while k > 0 and levels[k - 1] > polygon[i, 0]:
            levels[k] = levels[k - 1]
            k -= 1
        levels[k] = polygon[i, 0]
    d = plane[0] + plane[1] * mean_x
    u, v = _place(plane, mean_x, mean_q)
    base = angle_of(plane[2], plane[3])
    base += TWO_PI * np.floor((angle_of(u, v) - base - np.arctan2(mean_q, d)) / TWO_PI + 0.5)
    cell = at_cell
    for k in range(count - 1):
        middle, half = 0.5 * (levels[k] + levels[k + 1]), 0.5 * (levels[k + 1] - levels[k])
        if not half > 0.125 * MARGIN:
            continue  # its neighbours reach over it; those of a sheet that is all so thin: below
        near, far, near_rise, far_rise = np.inf, 0.0, 0.0, 0.0
        for i in range(count):
            j = i + 1 if i + 1 < count else 0
            wide = polygon[j, 0] - polygon[i, 0]
            if (polygon[i, 0] <= middle) == (polygon[j, 0] <= middle):
                continue
            rise = (polygon[j, 1] - polygon[i, 1]) / wide
            q = polygon[i, 1] + rise * (middle - polygon[i, 0])
            if side * q < near:
                near, near_rise = side * q, rise
            if side * q > far:
                far, far_rise = side * q, rise
        x[cell, 0], x[cell, 1] = levels[k] - MARGIN, levels[k + 1] + MARGIN
        steepest = _write_arc(arcs[cell, 0], middle, half, plane, side * near, near_rise, -1.0)
        steepest = max(steepest, _write_arc(arcs[cell, 1], middle, half, plane, side * far, far_rise, 1.0))
        width = near - abs(near_rise) * (half + MARGIN)
        heights[cell, 0], heights[cell, 1], heights[cell, 2], heights[cell, 3] = plane[0], plane[1], base, side
        if 2.0 * (2.0 + steepest + 2.0 * abs(plane[1])) <= REACH and width >= 0.99 * LEAST_WIDTH:
            tolerances[cell], slacks[cell] = REACH * MARGIN / width, SLACK / (width * width)
        cell += 1
    if cell == at_cell:
        _write_thin(polygon, count, plane, x[cell], arcs[cell])
        cell += 1
    return cell


@uncounted
def _write_thin(polygon, count, plane, x, arcs):
    """The cell of a polygon that is level but for a share of MARGIN."""
    x[0], x[1] = polygon[0, 0], polygon[0, 0]
    low, high = np.inf, 0.0
    for i in range(count):
        d = plane[0] + plane[1] * polygon[i, 0]
        y = d * d + polygon[i, 1] * polygon[i, 1]
        x[0], x[1] = min(x[0], polygon[i, 0]), max(x[1], polygon[i, 0])
        low, high = min(low, y), max(high, y)
    for way in range(2):
        arcs[way, 0] = 0.5 * (x[0] + x[1])
        arcs[way, 1] = high + 2.0 * REACH * MARGIN if way else low - 2.0 * REACH * MARGIN
        arcs[way, 2], arcs[way, 3] = 0.0, 0.0
    x[0], x[1] = x[0] - MARGIN, x[1] + MARGIN
