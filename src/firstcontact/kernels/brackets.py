"""Brackets in floats, with a proof: the sign of a bracket and whether it is certain.

Two proofs.  The error bound of `verdict.py` holds for all doubles; it decides no zero.  On a grid, that is for whole
multiples of a power of two below 2^16 times it, every number of this file is an integer below 2^53 times a power of
two: nothing rounds, and zeros are certain too.
"""

from __future__ import annotations

import math

from firstcontact.kernels.jit import kernel
from firstcontact.kernels.verdict import DET_EPS, TINY, cross_size

SEPARATE, POINT, OVERLAP, OVERLAP_POINT, UNSURE = 0, 1, 2, 3, 4
# Values per pair that `relations` writes: s, t, point (or start of the overlap) x, y, z, its end x, y, z, and whether
# the directions of two lines are parallel.
WIDTH, PARALLEL = 9, 8
# Coordinates on a grid are below 2^GRID_BITS steps, their differences below 2^(GRID_BITS+1): six products of three
# stay below 2^53.  Larger: rounded determinants pass for exact.
GRID_BITS = 15


@kernel
def bracket4(a, b, c, d):
    """([abcd], bound of its error) of four rows (3,): -det(b - a, c - a, d - a)."""
    x0, x1, x2 = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    y0, y1, y2 = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    z0, z1, z2 = d[0] - a[0], d[1] - a[1], d[2] - a[2]
    det = x0 * (y1 * z2 - y2 * z1) + x1 * (y2 * z0 - y0 * z2) + x2 * (y0 * z1 - y1 * z0)
    s0, s1, s2 = cross_size(y0, y1, y2, z0, z1, z2)
    return -det, DET_EPS * (abs(x0) * s0 + abs(x1) * s1 + abs(x2) * s2) + TINY


@kernel
def bracket4_sign(a, b, c, d):
    """(sign of [abcd], whether it is certain)."""
    value, error = bracket4(a, b, c, d)
    if value > error:
        return 1, True
    if value < -error:
        return -1, True
    if on_grid(a, b, c, d):
        return (1 if value > 0.0 else -1 if value < 0.0 else 0), True
    return 0, False


@kernel
def on_grid(a, b, c, d):
    """Whether all coordinates of four rows (3,) are whole multiples, below 2^15 times, of a common power of two."""
    largest = 0.0
    for k in range(3):
        largest = max(largest, max(max(abs(a[k]), abs(b[k])), max(abs(c[k]), abs(d[k]))))
    if largest == 0.0:
        return True
    exponent = math.frexp(largest)[1]
    if exponent > 300 or exponent < -300:  # no product of three under- or overflows
        return False
    step = math.ldexp(1.0, GRID_BITS - exponent)
    for k in range(3):
        for x in (a[k], b[k], c[k], d[k]):
            steps = x * step
            if steps != math.floor(steps) or (steps == 0.0 and x != 0.0):  # the latter: it underflowed
                return False
    return True


@kernel
def _cross(p, q, x, y):
    """(q - p) x (y - x)."""
    u0, u1, u2 = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    v0, v1, v2 = y[0] - x[0], y[1] - x[1], y[2] - x[2]
    return u1 * v2 - u2 * v1, u2 * v0 - u0 * v2, u0 * v1 - u1 * v0


@kernel
def _dot(p, q, x, y):
    """(q - p) . (y - x)."""
    return (q[0] - p[0]) * (y[0] - x[0]) + (q[1] - p[1]) * (y[1] - x[1]) + (q[2] - p[2]) * (y[2] - x[2])


@kernel
def _bracket3(a, b, c, dropped):
    j, k = (dropped + 1) % 3, (dropped + 2) % 3
    return (b[j] - a[j]) * (c[k] - a[k]) - (b[k] - a[k]) * (c[j] - a[j])


@kernel
def _projection(p1, p2, q1, q2):
    """The coordinate to drop, as exact.brackets.projection has it; -1 where the points lie on one line."""
    for n in range(4):
        if n < 2:
            m0, m1, m2 = _cross(p1, p2, p1, q1 if n == 0 else q2)
        else:
            m0, m1, m2 = _cross(q1, q2, q1, p1 if n == 2 else p2)
        if m0 != 0.0:
            return 0
        if m1 != 0.0:
            return 1
        if m2 != 0.0:
            return 2
    return -1


@kernel
def _same_side(x, y):
    return (x > 0.0 and y > 0.0) or (x < 0.0 and y < 0.0)


@kernel
def _write(out, s, t, x):
    out[0], out[1] = s, t
    for k in range(3):
        out[2 + k] = x[k]


@kernel
def _point_on(p1, p2, x):
    """The parameter of x on the closed segment; -1 where x is not on it, 0 where p1 = p2 = x.  On a grid."""
    length = _dot(p1, p2, p1, p2)
    m0, m1, m2 = _cross(p1, p2, p1, x)
    if m0 != 0.0 or m1 != 0.0 or m2 != 0.0:
        return -1.0
    if length == 0.0:
        return 0.0 if _dot(p1, x, p1, x) == 0.0 else -1.0
    s = _dot(p1, p2, p1, x)
    return s / length if 0.0 <= s <= length else -1.0


@kernel
def _overlap(p1, p2, q1, q2, out):
    """Two proper segments of one line, on a grid."""
    e, f = _dot(p1, p2, p1, p2), _dot(q1, q2, q1, q2)
    along = _dot(p1, p2, q1, q2) > 0.0
    q_lo, q_hi = (q1, q2) if along else (q2, q1)
    start = q_lo if _dot(p1, p2, p1, q_lo) > 0.0 else p1
    end = q_hi if _dot(p1, p2, q_hi, p2) > 0.0 else p2
    gap = _dot(p1, p2, start, end)
    if gap < 0.0:
        return SEPARATE
    _write(out, _dot(p1, p2, p1, start) / e, _dot(q1, q2, q1, start) / f, start)
    if gap == 0.0:
        return OVERLAP_POINT
    for k in range(3):
        out[5 + k] = end[k]
    return OVERLAP


@kernel
def _apart(p1, p2, q1, q2):
    """Whether the boxes of two segments share no point."""
    for k in range(3):
        if max(p1[k], p2[k]) < min(q1[k], q2[k]) or max(q1[k], q2[k]) < min(p1[k], p2[k]):
            return True
    return False


@kernel
def relation(p1, p2, q1, q2, bounded, out):
    """The kind of relation of two segments (bounded) or lines, UNSURE where floats prove none.

    Rows (3,) in, the row out (WIDTH,) is written.  On a grid the quotients s, t are rounded once and points
    q1 + t (q2 - q1) three times; all else is exact.
    """
    if bounded and _apart(p1, p2, q1, q2):
        return SEPARATE
    d, error = bracket4(p1, p2, q1, q2)
    if abs(d) > error:
        return SEPARATE
    if not on_grid(p1, p2, q1, q2):
        return UNSURE
    if d != 0.0:
        return SEPARATE
    p, q = _dot(p1, p2, p1, p2), _dot(q1, q2, q1, q2)
    if bounded and (p == 0.0 or q == 0.0):
        found = _point_on(q1, q2, p1) if p == 0.0 else _point_on(p1, p2, q1)
        if found < 0.0:
            return SEPARATE
        if p == 0.0:
            _write(out, 0.0, found, p1)
        else:
            _write(out, found, 0.0, q1)
        return POINT
    dropped = _projection(p1, p2, q1, q2)
    if dropped < 0:
        out[PARALLEL] = 1.0
        return _overlap(p1, p2, q1, q2, out) if bounded else OVERLAP
    b1, b2 = _bracket3(p1, p2, q1, dropped), _bracket3(p1, p2, q2, dropped)
    b3, b4 = _bracket3(p1, q1, q2, dropped), _bracket3(p2, q1, q2, dropped)
    if b1 == b2:
        out[PARALLEL] = 1.0
        return SEPARATE
    if bounded and (_same_side(b1, b2) or _same_side(b3, b4)):
        return SEPARATE
    t = b1 / (b1 - b2)
    _write(out, b3 / (b3 - b4), t, q1)
    for k in range(3):
        out[2 + k] += t * (q2[k] - q1[k])
    return POINT


@kernel
def relations(p1, p2, q1, q2, bounded, kinds, out):
    """`relation` of all n pairs: rows (n, 3), kinds (n,) int64 and out (n, WIDTH) are written."""
    for i in range(len(kinds)):
        kinds[i] = relation(p1[i], p2[i], q1[i], q2[i], bounded, out[i])


@kernel
def bracket4_signs(a, b, c, d, signs, certain):
    """`bracket4_sign` of n rows: signs (n,) int64 and certain (n,) bool are written."""
    for i in range(len(signs)):
        signs[i], certain[i] = bracket4_sign(a[i], b[i], c[i], d[i])
