"""Support functions of convex pieces: the largest n.x over a piece, with a proved upper bound.

A bounded convex piece of planes and convex quadrics attains it at a vertex, on an edge conic, or where a face of
nonzero curvature has its normal along n; the rulings of cylinders and cones end on edges or vertices.  Points that
lie outside the piece by less than a tolerance may enter: they only raise the bound.
"""

from __future__ import annotations

import math

from firstcontact.kernels.jit import uncounted

U = 2.0**-53
# Kinds of curved faces: where a point of the unit ball, of w >= sqrt(1 + u^2), of w >= u^2 goes.
BALL, SHEET, BOWL = 0.0, 1.0, 2.0
# A point of a curved face counts when no other form exceeds this part of the piece's size there.  The tangent
# points concerned are that near the rim, where the bound is then too large by the square of it at most; forms are
# scaled to gradients of about 1, and their rounding errors are below 1e-12 of the size.
INCLUDED = 1e-9


# Pieces are rows of one array (n, 14) float64, in the coordinates of their body.  Errors are per unit of max |n_k|.
#   piece: first and end row of its vertices, arcs, curved faces, forms; middle and half-widths of a box around it.
#       One without forms is the union of all pieces in the rows before it, which is convex; its curved faces are
#       whole ellipsoids.
#   vertex: x, y, z, error.
#   arc: centre c, two conjugate half diameters a, b (the curve is c + a cos s + b sin s), direction (cos, sin) of the
#       middle of the arc, cosine of half its extent (-2: all of it), error.
#   curved face: centre c, 3x3 rows L (it is c + L u), kind, error.
#   form, <= 0 inside: xx, yy, zz, 2xy, 2xz, 2yz, 2x, 2y, 2z, 1; number of the surface; 1 where the piece is flat
#       (`kernels.convex.flat`): no point is inside it then, and its forms serve guesses only; EITHER for the two that
#       vanish along a line, whose normals may be taken either way.
VERTICES, ARCS, CURVED, FORMS, BOX = 0, 2, 4, 6, 8
FLAT, EITHER = 11, 2.0


@uncounted
def form_value(p, k, x, y, z):
    """(value, sum of the absolute values of its terms) of form k."""
    xx, yy, zz = p[k, 0] * x * x, p[k, 1] * y * y, p[k, 2] * z * z
    xy, xz, yz = p[k, 3] * x * y, p[k, 4] * x * z, p[k, 5] * y * z
    lx, ly, lz, c = p[k, 6] * x, p[k, 7] * y, p[k, 8] * z, p[k, 9]
    value = ((xx + yy) + (zz + xy)) + ((xz + yz) + (lx + ly)) + (lz + c)
    size = abs(xx) + abs(yy) + abs(zz) + abs(xy) + abs(xz) + abs(yz) + abs(lx) + abs(ly) + abs(lz) + abs(c)
    return value, size


@uncounted
def form_gradient(p, k, x, y, z):
    return (
        2.0 * p[k, 0] * x + p[k, 3] * y + p[k, 4] * z + p[k, 6],
        p[k, 3] * x + 2.0 * p[k, 1] * y + p[k, 5] * z + p[k, 7],
        p[k, 4] * x + p[k, 5] * y + 2.0 * p[k, 2] * z + p[k, 8],
    )


@uncounted
def support(p, i, n0, n1, n2):
    """(bound, x, y, z): max n.x over piece i is at most `bound`; the point that gave it, rounded.

    n: any doubles, not all zero.
    """
    largest = max(abs(n0), abs(n1), abs(n2))
    best, bx, by, bz = -math.inf, 0.0, 0.0, 0.0
    for k in range(int(p[i, VERTICES]), int(p[i, VERTICES + 1])):
        x, y, z = p[k, 0], p[k, 1], p[k, 2]
        h = n0 * x + n1 * y + n2 * z + largest * p[k, 3]
        if h > best:
            best, bx, by, bz = h, x, y, z
    for k in range(int(p[i, ARCS]), int(p[i, ARCS + 1])):
        alpha = n0 * p[k, 3] + n1 * p[k, 4] + n2 * p[k, 5]
        beta = n0 * p[k, 6] + n1 * p[k, 7] + n2 * p[k, 8]
        r = math.sqrt(alpha * alpha + beta * beta)
        h = n0 * p[k, 0] + n1 * p[k, 1] + n2 * p[k, 2] + r + largest * p[k, 12]
        if h <= best:
            continue
        # r * cosine of the angle between the highest point and the middle of the arc
        if alpha * p[k, 9] + beta * p[k, 10] < r * p[k, 11]:
            continue
        c, s = (alpha / r, beta / r) if r > 0.0 else (p[k, 9], p[k, 10])
        best = h
        bx = p[k, 0] + c * p[k, 3] + s * p[k, 6]
        by = p[k, 1] + c * p[k, 4] + s * p[k, 7]
        bz = p[k, 2] + c * p[k, 5] + s * p[k, 8]
    for k in range(int(p[i, CURVED]), int(p[i, CURVED + 1])):
        found, h, x, y, z = _tangent_point(p, k, n0, n1, n2, largest)
        if found and h > best and _included(p, i, x, y, z):
            best, bx, by, bz = h, x, y, z
    return best, bx, by, bz


@uncounted
def _tangent_point(p, k, n0, n1, n2, largest):
    """(exists, bound of n.x, x, y, z): the highest point of a curved face's surface."""
    m0 = n0 * p[k, 3] + n1 * p[k, 6] + n2 * p[k, 9]
    m1 = n0 * p[k, 4] + n1 * p[k, 7] + n2 * p[k, 10]
    m2 = n0 * p[k, 5] + n1 * p[k, 8] + n2 * p[k, 11]
    kind, stretch = p[k, 12], 1.0
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
    h = n0 * p[k, 0] + n1 * p[k, 1] + n2 * p[k, 2] + r + largest * p[k, 13] * stretch
    x = p[k, 0] + p[k, 3] * u + p[k, 4] * v + p[k, 5] * w
    y = p[k, 1] + p[k, 6] * u + p[k, 7] * v + p[k, 8] * w
    z = p[k, 2] + p[k, 9] * u + p[k, 10] * v + p[k, 11] * w
    return True, h, x, y, z


@uncounted
def _included(p, i, x, y, z):
    """False only when a point of a curved face certainly violates a form of the piece."""
    tolerance = INCLUDED * (p[i, BOX + 3] + p[i, BOX + 4] + p[i, BOX + 5])
    for k in range(int(p[i, FORMS]), int(p[i, FORMS + 1])):
        value, size = form_value(p, k, x, y, z)
        if not value <= tolerance + 1e-12 * size:  # points beyond the doubles are outside too
            return False
    return True
