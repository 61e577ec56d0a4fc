"""Boxes and triangles of a tree as convex pieces: the rows that `kernels.convex.support` reads, filled anew for each.

A triangle is flat, so no point lies strictly inside it.  Its forms serve guesses only; they are marked, and proofs of
shared points by forms refuse them.  A point proved to be in the triangle is one made of its corners.
"""

from __future__ import annotations

import math

import numpy as np

from firstcontact.kernels.convex.separation import local_direction, placed
from firstcontact.kernels.convex.support import (
    ARCS,
    BOX,
    EITHER,
    FLAT,
    FORMS,
    VERTICES,
    form_gradient,
    form_value,
    support,
)
from firstcontact.kernels.convex.touch_system import local_point
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.workspace import HERE_A, POSE_A, SIDE_A

U = 2.0**-53
# Rows of a triangle: its corners, the point last made of them, its plane, its three sides, its plane from below.
CORNERS, MADE, PLANE, SIDES, BELOW = np.int64(1), np.int64(4), np.int64(5), np.int64(6), np.int64(9)
# Rows that a piece takes here; its own number.
ROWS, ONLY = np.int64(10), np.int64(0)


@uncounted
def _write_box(p, error):
    """Fill in the head's box from the rows of vertices."""
    for k in range(3):
        lo, hi = math.inf, -math.inf
        for r in range(int(p[0, VERTICES]), int(p[0, VERTICES + 1])):
            lo, hi = min(lo, p[r, k]), max(hi, p[r, k])
        middle = 0.5 * (lo + hi)
        p[0, BOX + k] = middle
        p[0, BOX + 3 + k] = (max(hi - middle, middle - lo) + error) * (1.0 + 1e-15) + 1e-300


@uncounted
def write_box(p, box, error):
    """Piece 0 of p (ROWS, 14) is the box (6,); error: of its coordinates."""
    p[0, VERTICES], p[0, VERTICES + 1] = 1, 9
    for k in range(ARCS, BOX):
        p[0, k] = 9
    for r in range(8):
        x, y, z = box[3 * (r & 1)], box[1 + 3 * (r >> 1 & 1)], box[2 + 3 * (r >> 2)]
        p[1 + r, 0], p[1 + r, 1], p[1 + r, 2] = x, y, z
        p[1 + r, 3] = 3.0 * error + 8.0 * U * (abs(x) + abs(y) + abs(z))
    _write_box(p, error)


@uncounted
def write_corners(p, xyz, error):
    """Piece 0 of p (ROWS, 14) is the triangle with corners xyz (9,), without forms: for separating directions alone."""
    p[0, VERTICES], p[0, VERTICES + 1] = CORNERS, MADE
    for k in range(ARCS, BOX):
        p[0, k] = MADE
    for r in range(3):
        x, y, z = xyz[3 * r], xyz[3 * r + 1], xyz[3 * r + 2]
        p[CORNERS + r, 0], p[CORNERS + r, 1], p[CORNERS + r, 2] = x, y, z
        p[CORNERS + r, 3] = 3.0 * error + 8.0 * U * (abs(x) + abs(y) + abs(z))
    _write_box(p, error)


@uncounted
def write_triangle(p, xyz, error):
    """Piece 0 of p (ROWS, 14) is the triangle with corners xyz (9,), without area or length too."""
    write_corners(p, xyz, error)
    p[0, FORMS], p[0, FORMS + 1] = PLANE, BELOW
    for r in range(PLANE, ROWS):
        for k in range(11):
            p[r, k] = 0.0
        p[r, 10], p[r, FLAT] = r - PLANE, 1.0
    n0, n1, n2, line = _normal(p)
    for sign, r in ((1.0, PLANE), (-1.0, BELOW)):
        p[r, 6], p[r, 7], p[r, 8] = sign * n0, sign * n1, sign * n2
        p[r, 9] = -sign * (n0 * p[CORNERS, 0] + n1 * p[CORNERS, 1] + n2 * p[CORNERS, 2])
    for s in range(3):
        i, j = CORNERS + s, CORNERS + (s + 1) % 3
        e0, e1, e2 = p[j, 0] - p[i, 0], p[j, 1] - p[i, 1], p[j, 2] - p[i, 2]
        m0, m1, m2 = e1 * n2 - e2 * n1, e2 * n0 - e0 * n2, e0 * n1 - e1 * n0
        length = math.sqrt(m0 * m0 + m1 * m1 + m2 * m2)
        r = SIDES + s
        if length == 0.0:  # a side without length bounds nothing
            p[r, 9] = -(p[0, BOX + 3] + p[0, BOX + 4] + p[0, BOX + 5])
            continue
        p[r, 6], p[r, 7], p[r, 8] = m0 / length, m1 / length, m2 / length
        p[r, 9] = -(p[r, 6] * p[i, 0] + p[r, 7] * p[i, 1] + p[r, 8] * p[i, 2])
    if line >= 0:
        _leave_line(p, line)


@uncounted
def _leave_line(p, line):
    """Of the forms of a triangle without area, all but its plane and the one side that tell its line."""
    for s in range(3):
        r = SIDES + s
        if s == line:
            p[r, FLAT] = EITHER
            continue
        p[r, 6], p[r, 7], p[r, 8] = 0.0, 0.0, 0.0
        p[r, 9] = -(p[0, BOX + 3] + p[0, BOX + 4] + p[0, BOX + 5])
    p[PLANE, FLAT] = p[BELOW, FLAT] = EITHER


@uncounted
def across(e0, e1, e2):
    """A vector across another one, as far from zero as its length allows: by its least coordinate."""
    if abs(e0) <= abs(e1) and abs(e0) <= abs(e2):
        return 0.0, -e2, e1
    if abs(e1) <= abs(e2):
        return e2, 0.0, -e0
    return -e1, e0, 0.0


@uncounted
def _normal(p):
    """(unit normal of the triangle, -1); of one without area some direction across its longest side, and that side."""
    best, longest, m0, m1, m2, n0, n1, n2 = -1.0, 0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0
    for s in range(3):
        i, j, k = CORNERS + s, CORNERS + (s + 1) % 3, CORNERS + (s + 2) % 3
        e0, e1, e2 = p[j, 0] - p[i, 0], p[j, 1] - p[i, 1], p[j, 2] - p[i, 2]
        f0, f1, f2 = p[k, 0] - p[j, 0], p[k, 1] - p[j, 1], p[k, 2] - p[j, 2]
        square = e0 * e0 + e1 * e1 + e2 * e2
        if s == 0:
            n0, n1, n2 = e1 * f2 - e2 * f1, e2 * f0 - e0 * f2, e0 * f1 - e1 * f0
        if square > best:
            best, longest = square, s
            m0, m1, m2 = across(e0, e1, e2)
    line, length = -1, math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    if length <= 1e-14 * best:
        n0, n1, n2, line = m0, m1, m2, longest
        length = math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    if length == 0.0:  # a point
        return 0.0, 0.0, 1.0, -1
    return n0 / length, n1 / length, n2 / length, line


@uncounted
def is_flat(p, i):
    k = int(p[i, FORMS])
    return k < int(p[i, FORMS + 1]) and p[k, FLAT] != 0.0


@uncounted
def face_along(a, i, n0, n1, n2, w):
    """Let the forms of a flat piece of a tell its plane from the side towards which n points (pose: row HERE_A)."""
    if not is_flat(a, i):
        return
    m0, m1, m2 = local_direction(w, HERE_A, n0, n1, n2)
    below = a[PLANE, 6] * m0 + a[PLANE, 7] * m1 + a[PLANE, 8] * m2 < 0.0
    a[i, FORMS], a[i, FORMS + 1] = (SIDES, ROWS) if below else (PLANE, BELOW)


@uncounted
def make_point(p, w, x, y, z):
    """Write the point of triangle 0 of p near the world point, in the frames of a, into row MADE; returns that row.

    It is corners times weights >= 0 of sum 1, and its slot 3 bounds how far from that it is rounded.
    """
    y0, y1, y2 = local_point(w, SIDE_A, x, y, z)
    worst, side, size = -math.inf, 0, 0.0
    u, v = 0.0, 0.0  # weights of the second and the third corner
    for s in range(3):
        value, terms = form_value(p, SIDES + s, y0, y1, y2)
        size = max(size, terms)
        if value > worst:
            worst, side = value, s
        k = CORNERS + (s + 2) % 3
        depth = form_value(p, SIDES + s, p[k, 0], p[k, 1], p[k, 2])[0]
        share = min(max(value / depth, 0.0), 1.0) if depth < 0.0 else 0.0
        if s == 0:  # the side opposite the third corner; the first one's weight is what the others leave
            v = share
        elif s == 2:
            u = share
    if worst > -4e-15 * size:  # on a side: along it, since other weights may be ill-conditioned
        i, j = CORNERS + side, CORNERS + (side + 1) % 3
        along, square = 0.0, 0.0
        for k in range(3):
            e = p[j, k] - p[i, k]
            along += e * ((y0 if k == 0 else y1 if k == 1 else y2) - p[i, k])
            square += e * e
        s = min(max(along / square, 0.0), 1.0) if square > 0.0 else 0.0
        u, v = (s, 0.0) if side == 0 else (1.0 - s, s) if side == 1 else (0.0, 1.0 - s)
    v = min(v, 1.0 - u)
    largest = 0.0
    for k in range(3):
        first = p[CORNERS, k]
        p[MADE, k] = first + (u * (p[CORNERS + 1, k] - first) + v * (p[CORNERS + 2, k] - first))
        largest = max(largest, abs(first), abs(p[CORNERS + 1, k]), abs(p[CORNERS + 2, k]))
    error = max(p[CORNERS, 3], p[CORNERS + 1, 3], p[CORNERS + 2, 3])
    p[MADE, 3] = error + 16.0 * U * largest
    return MADE


@uncounted
def made_point(p, w):
    """The world point of row MADE."""
    return placed(w, POSE_A, p[MADE, 0], p[MADE, 1], p[MADE, 2])


@uncounted
def middle_of(q, j):
    """A point inside piece j, away from its boundary: a mean of extreme points.

    Those along the axes may all lie in one face; so those farthest behind each form take part as well.
    """
    x, y, z = 0.0, 0.0, 0.0
    for k in range(6):
        s = 1.0 - 2.0 * (k & 1)
        _, s0, s1, s2 = support(q, j, s if k < 2 else 0.0, s if 2 <= k < 4 else 0.0, s if k >= 4 else 0.0)
        x, y, z = x + s0 / 6.0, y + s1 / 6.0, z + s2 / 6.0
    n, m0, m1, m2 = 1.0, x, y, z
    for k in range(int(q[j, FORMS]), int(q[j, FORMS + 1])):
        g0, g1, g2 = form_gradient(q, k, m0, m1, m2)
        if g0 != 0.0 or g1 != 0.0 or g2 != 0.0:
            _, s0, s1, s2 = support(q, j, -g0, -g1, -g2)
            n, x, y, z = n + 1.0, x + s0, y + s1, z + s2
    return x / n, y / n, z / n
