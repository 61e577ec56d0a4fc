"""Which rows of a tool's way are proved apart from a mesh: compiled.

A row is the hull of a round segment in two places, grown by a pad: four discs.  It holds all places between: those of a
shift exactly, those of an arc or a swing of the axis within the pad.  The support function of discs is exact but for
its rounding, which `gap` counts, so a separating direction is a proof.
"""

from __future__ import annotations

import math

import numpy as np

from firstcontact.kernels.convex.flat import ONLY, ROWS, across, write_box, write_corners
from firstcontact.kernels.convex.separation import gap, separating_direction
from firstcontact.kernels.convex.support import ARCS, BOX, VERTICES
from firstcontact.kernels.jit import kernel, uncounted
from firstcontact.kernels.workspace import HERE_A, HERE_B, WIDTH
from firstcontact.search.trees.containment import ray_crossings

APART, OPEN, INSIDE = 0, 1, 2
"""Of a row: no point shared; not proved; proved inside the solid all the time."""
U = 2.0**-53
DISCS = np.int64(4)
MOST_VISITS = 2000
"""Of nodes, in search of a point inside."""
SLACK = 1e-14
"""Of all sizes: places and axes are exact numbers rounded, and a disc's frame is made of a few such."""


@uncounted
def _write_disc(q, k, c0, c1, c2, u0, u1, u2, r):
    """Row k of q is the disc about a centre, across the unit vector u."""
    a0, a1, a2 = across(u0, u1, u2)
    length = math.sqrt(a0 * a0 + a1 * a1 + a2 * a2)
    a0, a1, a2 = a0 / length, a1 / length, a2 / length
    b0, b1, b2 = u1 * a2 - u2 * a1, u2 * a0 - u0 * a2, u0 * a1 - u1 * a0
    q[k, 0], q[k, 1], q[k, 2] = c0, c1, c2
    q[k, 3], q[k, 4], q[k, 5] = r * a0, r * a1, r * a2
    q[k, 6], q[k, 7], q[k, 8] = r * b0, r * b1, r * b2
    q[k, 9], q[k, 10], q[k, 11] = 1.0, 0.0, -2.0
    # as `search.convex.convex` has it: eight roundings of sums, square root included
    q[k, 12] = 12.0 * U * (abs(c0) + abs(c1) + abs(c2) + 6.0 * r)


@uncounted
def _write_hull(q, tips, axes, segment, pad):
    """Piece 0 of q is the hull; its box is grown by the pad.  Returns the pad with all roundings of what was given."""
    size = 0.0
    for end in range(2):
        for side in range(2):
            z, r = segment[2 * side], segment[2 * side + 1]
            u0, u1, u2 = axes[end, 0], axes[end, 1], axes[end, 2]
            c0, c1, c2 = tips[end, 0] + z * u0, tips[end, 1] + z * u1, tips[end, 2] + z * u2
            _write_disc(q, 1 + 2 * end + side, c0, c1, c2, u0, u1, u2, r)
            size = max(size, abs(tips[end, 0]) + abs(tips[end, 1]) + abs(tips[end, 2]) + abs(z) + r)
    q[0, VERTICES], q[0, VERTICES + 1], q[0, ARCS], q[0, ARCS + 1] = 1, 1, 1, 1 + DISCS
    for k in range(ARCS + 2, BOX):
        q[0, k] = 1 + DISCS
    grown = pad + SLACK * size
    for k in range(3):
        lo, hi = math.inf, -math.inf
        for d in range(1, 1 + DISCS):
            half = math.sqrt(q[d, 3 + k] ** 2 + q[d, 6 + k] ** 2)
            lo, hi = min(lo, q[d, k] - half), max(hi, q[d, k] + half)
        q[0, BOX + k], q[0, BOX + 3 + k] = 0.5 * (lo + hi), 0.5 * (hi - lo) + grown
    return grown


@uncounted
def _parted(p, q, pad, hint, w):
    """Whether piece 0 of p and piece 0 of q, grown by the pad, are proved apart; `hint` keeps the direction."""
    n0, n1, n2 = hint[0], hint[1], hint[2]
    pad *= 1.0 + 1e-14  # directions have the length 1 but for a few roundings
    if gap(p, ONLY, q, ONLY, n0, n1, n2, w) > pad:
        return True
    n0, n1, n2 = q[0, BOX] - p[0, BOX], q[0, BOX + 1] - p[0, BOX + 1], q[0, BOX + 2] - p[0, BOX + 2]
    if n0 == 0.0 and n1 == 0.0 and n2 == 0.0:
        n0 = 1.0
    distance, n0, n1, n2, _ = separating_direction(p, ONLY, q, ONLY, n0, n1, n2, w)
    if distance > pad and gap(p, ONLY, q, ONLY, n0, n1, n2, w) > pad:
        hint[0], hint[1], hint[2] = n0, n1, n2
        return True
    return False


@uncounted
def _apart(boxes, links, xyz, error, p, q, pad, hint, stack, w):
    """Whether the hull is proved apart from all parts of the tree."""
    stack[0] = 0
    depth = 1
    while depth > 0:
        depth -= 1
        node = stack[depth]
        box, away = boxes[node], False
        for k in range(3):
            lo, hi = q[0, BOX + k] - q[0, BOX + 3 + k], q[0, BOX + k] + q[0, BOX + 3 + k]
            away = away or box[k] - error > hi or box[k + 3] + error < lo
        if away:
            continue
        if links[node, 1] >= 0:
            write_box(p, box, error)
            if not _parted(p, q, pad, hint, w):
                stack[depth], stack[depth + 1] = links[node, 0], links[node, 1]
                depth += 2
            continue
        write_corners(p, xyz[links[node, 0]], error)
        if not _parted(p, q, pad, hint, w):
            return False
    return True


@kernel
def told_of_rows(boxes, links, xyz, ids, error, solid, tips, axes, pads, segment, w, out):
    """Fill `out` (n,) with what is told of each row.

    boxes, links, xyz, ids, error: of the mesh's tree in the world's axes; solid: whether the mesh owns its inside.
    tips, axes (n, 2, 3): tip and unit axis of the tool at both ends; pads (n,); segment (4,): low, bottom, high, top.
    w: a workspace.
    """
    p, q = np.empty((ROWS, WIDTH)), np.empty((1 + DISCS, WIDTH))
    stack, hint, point = np.empty(256, np.int64), np.array([1.0, 0.0, 0.0]), np.empty(3)
    hits = np.empty((64, 2), np.int64)
    for row in (HERE_A, HERE_B):
        for k in range(WIDTH):
            w[row, k] = 1.0 if k < 9 and k % 4 == 0 else 0.0
    for n in range(len(out)):
        pad = _write_hull(q, tips[n], axes[n], segment, pads[n])
        out[n] = APART if _apart(boxes, links, xyz, error, p, q, pad, hint, stack, w) else OPEN
        if out[n] == APART and solid:
            for k in range(3):  # any point of the segment will do, and its middle is far from its surface
                point[k] = tips[n, 0, k] + 0.5 * (segment[0] + segment[2]) * axes[n, 0, k]
            out[n] = _side_of(boxes, links, xyz, ids, error, point, hits)


@kernel
def begun_inside(boxes, links, xyz, error, tips, axes, segment, found):
    """Fill `found` (n, 3) with a point of a side of the mesh, rounded, that is proved to lie inside the segment.

    nan where there is none.

    boxes, links, xyz, error: as of `told_of_rows`; tips, axes (n, 3): of the tool; segment (4,).
    """
    stack = np.empty(256, np.int64)
    low, bottom, high, top = segment[0], segment[1], segment[2], segment[3]
    slope, widest = (top - bottom) / (high - low), max(bottom, top)
    for n in range(len(found)):
        tip, u = tips[n], axes[n]
        size = abs(tip[0]) + abs(tip[1]) + abs(tip[2]) + abs(high) + widest
        margin = (1e-13 * size + 4.0 * error) * (1.0 + abs(slope))  # of distances, whose roundings are a few 1e-16
        found[n, 0] = found[n, 1] = found[n, 2] = math.nan
        stack[0], depth, left = 0, 1, MOST_VISITS
        while depth > 0 and left > 0:
            depth -= 1
            left -= 1
            node = stack[depth]
            away = False
            for k in range(3):
                a, b = tip[k] + low * u[k], tip[k] + high * u[k]
                away = away or boxes[node, k] > max(a, b) + widest or boxes[node, k + 3] < min(a, b) - widest
            if away:
                continue
            if links[node, 1] >= 0:
                stack[depth], stack[depth + 1] = links[node, 0], links[node, 1]
                depth += 2
                continue
            x = xyz[links[node, 0]]
            for c in range(3):
                s = _nearest(x, c, tip, u, low + 2.0 * margin, high - 2.0 * margin)
                d = (c + 1) % 3
                p0 = x[3 * c] + s * (x[3 * d] - x[3 * c])
                p1 = x[3 * c + 1] + s * (x[3 * d + 1] - x[3 * c + 1])
                p2 = x[3 * c + 2] + s * (x[3 * d + 2] - x[3 * c + 2])
                h, off = _along_and_off(p0 - tip[0], p1 - tip[1], p2 - tip[2], u)
                far = abs(x[3 * d] - p0) + abs(x[3 * d + 1] - p1) + abs(x[3 * d + 2] - p2)
                m = margin + 1e-13 * far * (1.0 + abs(slope))  # the point is on the side but for its roundings
                if low + m < h < high - m and off < bottom + slope * (h - low) - m:
                    found[n, 0], found[n, 1], found[n, 2] = p0, p1, p2
                    depth = 0
                    break


@uncounted
def _along_and_off(d0, d1, d2, u):
    """Of a vector how far it goes along the unit vector u, and how far off its line."""
    c0, c1, c2 = d1 * u[2] - d2 * u[1], d2 * u[0] - d0 * u[2], d0 * u[1] - d1 * u[0]
    return d0 * u[0] + d1 * u[1] + d2 * u[2], math.sqrt(c0 * c0 + c1 * c1 + c2 * c2)


@uncounted
def _nearest(x, c, tip, u, low, high):
    """Where side c of a triangle is nearest the axis, between two heights above the tip: a number in [0, 1]."""
    d = (c + 1) % 3
    a0, a1, a2 = x[3 * c] - tip[0], x[3 * c + 1] - tip[1], x[3 * c + 2] - tip[2]
    e0, e1, e2 = x[3 * d] - x[3 * c], x[3 * d + 1] - x[3 * c + 1], x[3 * d + 2] - x[3 * c + 2]
    h, rise = a0 * u[0] + a1 * u[1] + a2 * u[2], e0 * u[0] + e1 * u[1] + e2 * u[2]
    square = e0 * e0 + e1 * e1 + e2 * e2 - rise * rise
    s = -((a0 * e0 + a1 * e1 + a2 * e2) - h * rise) / square if square > 0.0 else 0.0
    if rise != 0.0:
        first, last = (low - h) / rise, (high - h) / rise
        s = min(max(s, min(first, last)), max(first, last))
    return min(max(s, 0.0), 1.0)


@kernel
def _side_of(boxes, links, xyz, ids, error, point, hits):
    """Whether a point that is off the surface is inside, by the crossings of a ray."""
    err = 2.0 * error + 1e-300
    for axis in range(3):
        count = ray_crossings(boxes, links, xyz, ids, point, axis, err, hits)
        certain, inside = count >= 0, False
        for k in range(count):
            certain = certain and hits[k, 1] == 1
            inside = not inside
        if certain:
            return INSIDE if inside else APART
    return OPEN
