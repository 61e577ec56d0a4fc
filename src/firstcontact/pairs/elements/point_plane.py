"""Vertex against facet under translation: vertex p moves by t v, facet ABC rests (v reversed: facet moves).

With n = (B - A) x (C - A) the vertex meets the plane at t = N/D, N = n.(A - p), D = n.v; it does so inside
the closed triangle iff the three side products v.((A-p) x (B-p)), v.((B-p) x (C-p)), v.((C-p) x (A-p)) and D
have one common sign, zeros allowed (Schoemer & Thiel 1995, section 6).
"""

from __future__ import annotations

from firstcontact.exact.numbers import sign
from firstcontact.exact.times.windows import ALWAYS, Window, hull
from firstcontact.exact.vectors import Vector, cross, dot, ratio, sub
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.verdict import CERTAIN, DET_EPS, NONE, TINY, UNSURE, cross_size, quotient, slack3
from firstcontact.kernels.verdict import cross as cross_f
from firstcontact.pairs.elements import point_line


@uncounted
def translation_filter(
    p0, p1, p2, a0, a1, a2, b0, b1, b2, c0, c1, c2, v0, v1, v2, t_first, t_last, err_p, err_f
):
    """(verdict, lo, hi): no contact in [t_first, t_last], or certainly one, in [lo, hi], or unsure.

    err_p, err_f bound the error of every coordinate of p and of ABC.  Unsure: any contact lies in [lo, hi].
    """
    x0, x1, x2 = a0 - p0, a1 - p1, a2 - p2
    y0, y1, y2 = b0 - p0, b1 - p1, b2 - p2
    z0, z1, z2 = c0 - p0, c1 - p1, c2 - p2
    g0, g1, g2 = cross_f(v0, v1, v2, y0, y1, y2)
    s0, s1, s2 = cross_size(v0, v1, v2, y0, y1, y2)
    ab = -(g0 * x0 + g1 * x1 + g2 * x2)
    bc = g0 * z0 + g1 * z1 + g2 * z2
    ab_err = DET_EPS * (s0 * abs(x0) + s1 * abs(x1) + s2 * abs(x2)) + TINY
    bc_err = DET_EPS * (s0 * abs(z0) + s1 * abs(z1) + s2 * abs(z2)) + TINY
    g0, g1, g2 = cross_f(v0, v1, v2, z0, z1, z2)
    s0, s1, s2 = cross_size(v0, v1, v2, z0, z1, z2)
    ca = g0 * x0 + g1 * x1 + g2 * x2
    ca_err = DET_EPS * (s0 * abs(x0) + s1 * abs(x1) + s2 * abs(x2)) + TINY
    e0, e1, e2 = b0 - a0, b1 - a1, b2 - a2
    f0, f1, f2 = c0 - a0, c1 - a1, c2 - a2
    n0, n1, n2 = cross_f(e0, e1, e2, f0, f1, f2)
    s0, s1, s2 = cross_size(e0, e1, e2, f0, f1, f2)
    den = v0 * n0 + v1 * n1 + v2 * n2
    num = x0 * n0 + x1 * n1 + x2 * n2
    den_err = DET_EPS * (abs(v0) * s0 + abs(v1) * s1 + abs(v2) * s2) + TINY
    num_err = DET_EPS * (abs(x0) * s0 + abs(x1) * s1 + abs(x2) * s2) + TINY
    if err_p + err_f > 0.0:
        v = abs(v0) + abs(v1) + abs(v2)
        x, y, z = abs(x0) + abs(x1) + abs(x2), abs(y0) + abs(y1) + abs(y2), abs(z0) + abs(z1) + abs(z2)
        e, f = abs(e0) + abs(e1) + abs(e2), abs(f0) + abs(f1) + abs(f2)
        de, dx = 6.0 * err_f, 3.0 * (err_p + err_f)
        ab_err += slack3(v, x, y, 0.0, dx, dx)
        bc_err += slack3(v, y, z, 0.0, dx, dx)
        ca_err += slack3(v, z, x, 0.0, dx, dx)
        den_err += slack3(v, e, f, 0.0, de, de)
        num_err += slack3(x, e, f, dx, de, de)
    plus = den > den_err or ab > ab_err or bc > bc_err or ca > ca_err
    minus = den < -den_err or ab < -ab_err or bc < -bc_err or ca < -ca_err
    if plus and minus:
        return NONE, 0.0, 0.0
    if abs(den) <= den_err:
        # a contact at t has |N| = |t| |D|
        reach = max(abs(t_first), abs(t_last))
        if abs(num) - num_err > reach * (abs(den) + den_err) * (1.0 + 2.0**-50):
            return NONE, 0.0, 0.0
        return UNSURE, t_first, t_last
    lo, hi = quotient(num, num_err, den, den_err)
    if hi < t_first or lo > t_last:
        return NONE, 0.0, 0.0
    if not lo <= hi:  # beyond the range of doubles
        return UNSURE, t_first, t_last
    sure = abs(ab) > ab_err and abs(bc) > bc_err and abs(ca) > ca_err
    return (CERTAIN if sure else UNSURE), lo, hi


def translation_window(p: Vector, a: Vector, b: Vector, c: Vector, v: Vector) -> Window | None:
    """The times t at which p + t v lies in the closed triangle abc; exact, one closed interval."""
    n = cross(sub(b, a), sub(c, a))
    den = dot(n, v)
    side = sign(den)
    if side != 0:
        x, y, z = sub(a, p), sub(b, p), sub(c, p)
        h = cross(v, y)
        if -sign(dot(h, x)) * side < 0 or sign(dot(h, z)) * side < 0 or sign(dot(cross(v, z), x)) * side < 0:
            return None
        t = ratio(dot(n, x), den)
        return t, t
    sides = [point_line.translation_window(p, v, q, r) for q, r in ((a, b), (b, c), (c, a))]
    if all(sign(x) == 0 for x in n):
        return hull(sides)
    if sign(dot(n, sub(a, p))) != 0:
        return None
    if all(sign(x) == 0 for x in v):
        return ALWAYS if in_triangle(p, a, b, c, n) else None
    return hull(sides)  # the vertex stays in the facet's plane: it enters and leaves through sides


def in_triangle(q: Vector, a: Vector, b: Vector, c: Vector, n: Vector) -> bool:
    """Whether q, a point of the triangle's plane with normal n, lies in the closed triangle."""
    return (
        sign(dot(n, cross(sub(b, a), sub(q, a)))) >= 0
        and sign(dot(n, cross(sub(c, b), sub(q, b)))) >= 0
        and sign(dot(n, cross(sub(a, c), sub(q, c)))) >= 0
    )


def on_triangle(q: Vector, a: Vector, b: Vector, c: Vector) -> bool:
    """Whether q lies on the closed triangle, which may have no area; exact."""
    n = cross(sub(b, a), sub(c, a))
    if all(sign(x) == 0 for x in n):
        return any(point_line.on_segment(q, *side) for side in ((a, b), (b, c), (c, a)))
    return sign(dot(n, sub(q, a))) == 0 and in_triangle(q, a, b, c, n)
