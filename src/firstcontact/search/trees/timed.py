"""The double nearest to the time of a contact under a translation, as far as pairs of doubles tell it.

The equation is that of `pairs.elements.coplanar`: gap = t speed, both triple products of differences of coordinates.
In units of u^2 (see `double_double`) a difference is within 3.01 of the true one, a minor within 7 + 6.02 + 3.01 of its
permanent, a triple product within 7 + 3.01 + 16.03 + 6.02 < 33 of its own, beside what coordinates are off by; the
quotient is within NEAR where these bounds are not above SHARE of what they bound.
"""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.double_double import add, divide, minor, multiply
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.verdict import TINY, slack3
from firstcontact.search.trees.state import EDGE_EDGE, VERTEX_FACE

DD_EPS = 64.0 * 2.0**-106
SHARE, NEAR = 2.0**-77, 2.0**-74
LEAST = 2.0**-900
"""Times below are not told: nothing here may leave the range of doubles."""


@uncounted
def time_of(kind, xa, ra, side_a, xb, rb, side_b, v0, v1, v2):
    """(t, r): t the double nearest to the time of a contact that is certain, r about what it is off by.

    xa + ra, xb + rb: coordinates (9,) of parts, to the last digit of ra and rb; side_a, side_b: of the candidate; v:
    exact.  (nan, nan) where it is not told: the time's rounding, and which way it goes, are certain otherwise.
    """
    i, j = 3 * side_a, 3 * side_b
    if kind == EDGE_EDGE:
        x, rx, x0, x1, y, ry, y0, y1 = xa, ra, i, 3 * ((side_a + 1) % 3), xb, rb, j, 3 * ((side_b + 1) % 3)
    elif kind == VERTEX_FACE:
        x, rx, x0, x1, y, ry, y0, y1, j = xb, rb, 0, 3, xb, rb, 0, 6, 0
    else:
        x, rx, x0, x1, y, ry, y0, y1, i = xa, ra, 0, 3, xa, ra, 0, 6, 0
    e0, f0 = add(x[x1], rx[x1], -x[x0], -rx[x0])
    e1, f1 = add(x[x1 + 1], rx[x1 + 1], -x[x0 + 1], -rx[x0 + 1])
    e2, f2 = add(x[x1 + 2], rx[x1 + 2], -x[x0 + 2], -rx[x0 + 2])
    g0, h0 = add(y[y1], ry[y1], -y[y0], -ry[y0])
    g1, h1 = add(y[y1 + 1], ry[y1 + 1], -y[y0 + 1], -ry[y0 + 1])
    g2, h2 = add(y[y1 + 2], ry[y1 + 2], -y[y0 + 2], -ry[y0 + 2])
    n0, m0 = minor(e1, f1, e2, f2, g1, h1, g2, h2)
    n1, m1 = minor(e2, f2, e0, f0, g2, h2, g0, h0)
    n2, m2 = minor(e0, f0, e1, f1, g0, h0, g1, h1)
    w0, z0 = add(xb[j], rb[j], -xa[i], -ra[i])
    w1, z1 = add(xb[j + 1], rb[j + 1], -xa[i + 1], -ra[i + 1])
    w2, z2 = add(xb[j + 2], rb[j + 2], -xa[i + 2], -ra[i + 2])
    gap, gap_rest = _dot(n0, m0, n1, m1, n2, m2, w0, z0, w1, z1, w2, z2)
    speed, speed_rest = _dot(n0, m0, n1, m1, n2, m2, v0, 0.0, v1, 0.0, v2, 0.0)
    s0, s1, s2 = abs(e1 * g2) + abs(e2 * g1), abs(e2 * g0) + abs(e0 * g2), abs(e0 * g1) + abs(e1 * g0)
    gap_err = DD_EPS * (s0 * abs(w0) + s1 * abs(w1) + s2 * abs(w2)) + TINY
    speed_err = DD_EPS * (s0 * abs(v0) + s1 * abs(v1) + s2 * abs(v2)) + TINY
    off = 0.0  # of a coordinate
    for k in range(9):
        off = max(off, 2.0**-53 * max(abs(ra[k]), abs(rb[k])))
    if off > 0.0:
        w, v = abs(w0) + abs(w1) + abs(w2), abs(v0) + abs(v1) + abs(v2)
        e, g = abs(e0) + abs(e1) + abs(e2), abs(g0) + abs(g1) + abs(g2)
        gap_err += slack3(w, e, g, 6.0 * off, 6.0 * off, 6.0 * off)
        speed_err += slack3(v, e, g, 0.0, 6.0 * off, 6.0 * off)
    if not (gap_err <= SHARE * abs(gap) and speed_err <= SHARE * abs(speed)):
        return np.nan, np.nan
    t, r = divide(gap, gap_rest, speed, speed_rest)
    err = 2.0 * NEAR * abs(t)
    if not (LEAST < t < 1.0 / LEAST and abs(r) > err and t + (r - err) == t and t + (r + err) == t):
        return np.nan, np.nan
    return t, r


@uncounted
def _dot(x0, r0, x1, r1, x2, r2, y0, s0, y1, s1, y2, s2):
    p, e = multiply(x0, r0, y0, s0)
    q, f = multiply(x1, r1, y1, s1)
    p, e = add(p, e, q, f)
    q, f = multiply(x2, r2, y2, s2)
    return add(p, e, q, f)


@uncounted
def is_before(t, r, other, rest):
    """Whether one of two such times is certainly before the other."""
    return (other - t) + (rest - r) > 4.0 * NEAR * other
