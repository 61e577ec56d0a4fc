"""Support functions of convex pieces: the largest n.x over a piece, with a proved upper bound.

A bounded convex piece of planes and convex quadrics attains it at a vertex, on an edge conic, or where a face of
nonzero curvature has its normal along n; the rulings of cylinders and cones end on edges or vertices.  Points that
lie outside the piece by less than a tolerance may enter: they only raise the bound.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from firstcontact.kernels.jit import kernel

U = 2.0**-53
VERTEX, ARC, SMOOTH = 0, 1, 2
# Kinds of curved faces: where a point of the unit ball, of w >= sqrt(1 + u^2), of w >= u^2 goes.
BALL, SHEET, BOWL = 0.0, 1.0, 2.0
# A point of a curved face counts when no other form exceeds this part of the piece's size there.  The tangent
# points concerned are that near the rim, where the bound is then too large by the square of it at most; forms are
# scaled to gradients of about 1, and their rounding errors are below 1e-12 of the size.
INCLUDED = 1e-9


class Pieces(NamedTuple):
    """Convex pieces in the coordinates of their body.

    vertices (n, 4): x, y, z, error.
    arcs (n, 13): centre, two conjugate half diameters a, b (the curve is c + a cos s + b sin s), direction (cos, sin)
        of the middle of the arc, cosine of half its extent (-2: all of it), error.
    smooth (n, 14): centre c, 3x3 rows L (the face is c + L u), kind, error.
    leaves (n, 11): xx, yy, zz, 2xy, 2xz, 2yz, 2x, 2y, 2z, 1 of forms <= 0 inside; number of the surface.
    ranges (n, 8) int64: first and end of the vertices, arcs, smooth faces, leaves of every piece.
    boxes (n, 6): middle and half-widths of a box around the piece.
    Errors are per unit of the largest |n_k|.
    """

    vertices: np.ndarray
    arcs: np.ndarray
    smooth: np.ndarray
    leaves: np.ndarray
    ranges: np.ndarray
    boxes: np.ndarray


@kernel
def form_value(leaves, k, x, y, z):
    """(value, sum of the absolute values of its terms) of form k."""
    xx, yy, zz = leaves[k, 0] * x * x, leaves[k, 1] * y * y, leaves[k, 2] * z * z
    xy, xz, yz = leaves[k, 3] * x * y, leaves[k, 4] * x * z, leaves[k, 5] * y * z
    lx, ly, lz, c = leaves[k, 6] * x, leaves[k, 7] * y, leaves[k, 8] * z, leaves[k, 9]
    value = ((xx + yy) + (zz + xy)) + ((xz + yz) + (lx + ly)) + (lz + c)
    size = abs(xx) + abs(yy) + abs(zz) + abs(xy) + abs(xz) + abs(yz) + abs(lx) + abs(ly) + abs(lz) + abs(c)
    return value, size


@kernel
def form_gradient(leaves, k, x, y, z):
    return (
        2.0 * leaves[k, 0] * x + leaves[k, 3] * y + leaves[k, 4] * z + leaves[k, 6],
        leaves[k, 3] * x + 2.0 * leaves[k, 1] * y + leaves[k, 5] * z + leaves[k, 7],
        leaves[k, 4] * x + leaves[k, 5] * y + 2.0 * leaves[k, 2] * z + leaves[k, 8],
    )


@kernel
def support(p, i, n0, n1, n2):
    """(bound, x, y, z, kind, number): max n.x over piece i is at most `bound`; the point that gave it, rounded.

    n: any doubles, not all zero.
    """
    largest = max(abs(n0), abs(n1), abs(n2))
    best, bx, by, bz, kind, number = -math.inf, 0.0, 0.0, 0.0, -1, -1
    for k in range(p.ranges[i, 0], p.ranges[i, 1]):
        x, y, z = p.vertices[k, 0], p.vertices[k, 1], p.vertices[k, 2]
        h = n0 * x + n1 * y + n2 * z + largest * p.vertices[k, 3]
        if h > best:
            best, bx, by, bz, kind, number = h, x, y, z, VERTEX, k
    for k in range(p.ranges[i, 2], p.ranges[i, 3]):
        alpha = n0 * p.arcs[k, 3] + n1 * p.arcs[k, 4] + n2 * p.arcs[k, 5]
        beta = n0 * p.arcs[k, 6] + n1 * p.arcs[k, 7] + n2 * p.arcs[k, 8]
        r = math.sqrt(alpha * alpha + beta * beta)
        h = n0 * p.arcs[k, 0] + n1 * p.arcs[k, 1] + n2 * p.arcs[k, 2] + r + largest * p.arcs[k, 12]
        if h <= best:
            continue
        # r * cosine of the angle between the highest point and the middle of the arc
        if alpha * p.arcs[k, 9] + beta * p.arcs[k, 10] < r * p.arcs[k, 11]:
            continue
        c, s = (alpha / r, beta / r) if r > 0.0 else (p.arcs[k, 9], p.arcs[k, 10])
        best, kind, number = h, ARC, k
        bx = p.arcs[k, 0] + c * p.arcs[k, 3] + s * p.arcs[k, 6]
        by = p.arcs[k, 1] + c * p.arcs[k, 4] + s * p.arcs[k, 7]
        bz = p.arcs[k, 2] + c * p.arcs[k, 5] + s * p.arcs[k, 8]
    for k in range(p.ranges[i, 4], p.ranges[i, 5]):
        found, h, x, y, z = _tangent_point(p.smooth, k, n0, n1, n2, largest)
        if found and h > best and _included(p, i, k, x, y, z):
            best, bx, by, bz, kind, number = h, x, y, z, SMOOTH, k
    return best, bx, by, bz, kind, number


@kernel
def _tangent_point(smooth, k, n0, n1, n2, largest):
    """(exists, bound of n.x, x, y, z): the highest point of a curved face's surface."""
    m0 = n0 * smooth[k, 3] + n1 * smooth[k, 6] + n2 * smooth[k, 9]
    m1 = n0 * smooth[k, 4] + n1 * smooth[k, 7] + n2 * smooth[k, 10]
    m2 = n0 * smooth[k, 5] + n1 * smooth[k, 8] + n2 * smooth[k, 11]
    kind, stretch = smooth[k, 12], 1.0
    if kind == BALL:
        r = math.sqrt(m0 * m0 + m1 * m1 + m2 * m2)
        if r == 0.0:
            return False, 0.0, 0.0, 0.0, 0.0
        u, v, w = m0 / r, m1 / r, m2 / r
    elif kind == SHEET:
        square = (m2 - m0) * (m2 + m0) - m1 * m1
        if m2 >= 0.0 or square <= 0.0:
            return False, 0.0, 0.0, 0.0, 0.0
        r = math.sqrt(square)
        u, v, w = m0 / r, m1 / r, -m2 / r
        stretch = w * w * w
        r = -r
    else:
        if m2 >= 0.0:
            return False, 0.0, 0.0, 0.0, 0.0
        u, v = -0.5 * m0 / m2, -0.5 * m1 / m2
        w = u * u + v * v
        stretch = 1.0 + w
        r = -m2 * w
    h = n0 * smooth[k, 0] + n1 * smooth[k, 1] + n2 * smooth[k, 2] + r + largest * smooth[k, 13] * stretch
    x = smooth[k, 0] + smooth[k, 3] * u + smooth[k, 4] * v + smooth[k, 5] * w
    y = smooth[k, 1] + smooth[k, 6] * u + smooth[k, 7] * v + smooth[k, 8] * w
    z = smooth[k, 2] + smooth[k, 9] * u + smooth[k, 10] * v + smooth[k, 11] * w
    return True, h, x, y, z


@kernel
def _included(p, i, own, x, y, z):
    """False only when a point of a curved face certainly violates a form of the piece."""
    tolerance = INCLUDED * (p.boxes[i, 3] + p.boxes[i, 4] + p.boxes[i, 5])
    for k in range(p.ranges[i, 6], p.ranges[i, 7]):
        value, size = form_value(p.leaves, k, x, y, z)
        if value > tolerance + 1e-12 * size:
            return False
    return True
