"""Vertex against facet under rotation: vertex p turns about an axis through the origin, facet ABC rests.

The circle of p meets the facet's plane n.x = n.A in at most two points; each counts when it lies in the closed
triangle (Schoemer & Thiel 1995, section 6).
"""

from __future__ import annotations

import numpy as np

from firstcontact.exact.fields.surd import Surd
from firstcontact.exact.numbers import sign
from firstcontact.exact.times.instants import AngleInstant
from firstcontact.exact.times.turning import Axis
from firstcontact.exact.vectors import Vector, along, cross, dot, scaled, sub
from firstcontact.kernels.angle import TWO_PI, angle_bounds
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.running import add, cross2, div, dot2, mul, root
from firstcontact.kernels.running import sub as minus
from firstcontact.kernels.verdict import CERTAIN, NONE, UNSURE
from firstcontact.pairs.elements import point_line_rotation
from firstcontact.pairs.elements.line_line_rotation import planar_point_bound, planar_turn
from firstcontact.pairs.elements.point_line_rotation import Contact


@uncounted
def rotation_filter(p0, p1, p2, a0, a1, a2, b0, b1, b2, c0, c1, c2, err_p, err_f):
    """Two (verdict, lo, hi) of the possible contacts of p, turning about +z, with ABC; angles in [0, 2 pi].

    err_p, err_f bound the error of every coordinate of p and of ABC.
    """
    none = NONE, 0.0, 0.0, NONE, 0.0, 0.0
    if p2 - err_p > max(a2, b2, c2) + err_f or p2 + err_p < min(a2, b2, c2) - err_f:
        return none
    if _radius_misses(p0, p1, p2, a0, a1, a2, b0, b1, b2, c0, c1, c2, err_p, err_f):
        return none
    e0, ee0 = minus(b0, err_f, a0, err_f)
    e1, ee1 = minus(b1, err_f, a1, err_f)
    e2, ee2 = minus(b2, err_f, a2, err_f)
    f0, ef0 = minus(c0, err_f, a0, err_f)
    f1, ef1 = minus(c1, err_f, a1, err_f)
    f2, ef2 = minus(c2, err_f, a2, err_f)
    ee, ef = max(ee0, ee1, ee2), max(ef0, ef1, ef2)
    n0, en0 = cross2(e1, e2, ee, f1, f2, ef)
    n1, en1 = cross2(e2, e0, ee, f2, f0, ef)
    n2, en2 = cross2(e0, e1, ee, f0, f1, ef)
    en = max(en0, en1)
    # the plane at the height of p: n0 x + n1 y = h
    h, eh = dot2(n0, n1, en, a0, a1, err_f)
    d, ed = minus(a2, err_f, p2, err_p)
    t, et = mul(n2, en2, d, ed)
    h, eh = add(h, eh, t, et)
    nn, enn = dot2(n0, n1, en, n0, n1, en)
    rr, err = dot2(p0, p1, err_p, p0, p1, err_p)
    t, et = mul(nn, enn, rr, err)
    s, es = mul(h, eh, h, eh)
    disc, edisc = minus(t, et, s, es)
    if disc < -edisc:
        return none
    if abs(nn) <= 4.0 * enn:
        lo = _flat_bound(p0, p1, a0, a1, b0, b1, c0, c1, err_p, err_f)
        return (UNSURE, lo, TWO_PI, NONE, 0.0, 0.0) if lo < TWO_PI else none
    w, ew = root(disc, edisc)
    v0, lo0, hi0 = _at(-1.0, w, ew, h, eh, n0, n1, en, nn, enn, n2, en2,
                       p0, p1, p2, err_p, a0, a1, a2, b0, b1, b2, c0, c1, c2, err_f)  # fmt: skip
    v1, lo1, hi1 = _at(1.0, w, ew, h, eh, n0, n1, en, nn, enn, n2, en2,
                       p0, p1, p2, err_p, a0, a1, a2, b0, b1, b2, c0, c1, c2, err_f)  # fmt: skip
    if disc <= edisc:
        v0, v1 = (UNSURE if v0 != NONE else NONE), (UNSURE if v1 != NONE else NONE)
    return v0, lo0, hi0, v1, lo1, hi1


@uncounted
def _slice_point(p2, a0, a1, a2, b0, b1, b2, z_err, err):
    """(x, y, its error) where ab has the height p2; error -1 where it has not, inf where that is unclear."""
    below, above = a2 - p2, b2 - p2
    if (below > z_err and above > z_err) or (below < -z_err and above < -z_err):
        return 0.0, 0.0, -1.0
    if not ((below > z_err and above < -z_err) or (below < -z_err and above > z_err)):
        return 0.0, 0.0, np.inf
    i = 1.0 / (above - below)
    s = -below * i
    e0, e1 = b0 - a0, b1 - a1
    delta = (abs(e0) + abs(e1)) * abs(i) * z_err + 16.0 * 2.0**-53 * (abs(a0) + abs(a1) + abs(b0) + abs(b1))
    return a0 + s * e0, a1 + s * e1, delta + 4.0 * err


@uncounted
def _radius_misses(p0, p1, p2, a0, a1, a2, b0, b1, b2, c0, c1, c2, err_p, err_f):
    """Whether p's radius certainly lies outside the radii of the facet at p's height: cheap, rejects most pairs."""
    z_err = 8.0 * 2.0**-53 * (abs(p2) + abs(a2) + abs(b2) + abs(c2)) + 4.0 * (err_p + err_f)
    u0, u1, eu = _slice_point(p2, a0, a1, a2, b0, b1, b2, z_err, err_f)
    v0, v1, ev = _slice_point(p2, b0, b1, b2, c0, c1, c2, z_err, err_f)
    w0, w1, ew = _slice_point(p2, c0, c1, c2, a0, a1, a2, z_err, err_f)
    if max(eu, ev, ew) == np.inf:
        return False
    if eu < 0.0:
        u0, u1, eu = w0, w1, ew
    elif ev < 0.0:
        v0, v1, ev = w0, w1, ew
    if eu < 0.0 or ev < 0.0:
        return False
    delta = max(eu, ev)
    size = abs(u0) + abs(u1) + abs(v0) + abs(v1) + abs(p0) + abs(p1)
    margin = 8.0 * (size + delta) * (delta + err_p) + 32.0 * 2.0**-53 * size * size
    radius, far = p0 * p0 + p1 * p1, max(u0 * u0 + u1 * u1, v0 * v0 + v1 * v1)
    if radius > far + margin:
        return True
    x0, x1 = v0 - u0, v1 - u1
    near = min(u0 * u0 + u1 * u1, v0 * v0 + v1 * v1)
    first, last = u0 * x0 + u1 * x1, v0 * x0 + v1 * x1
    if (first < 0.0 and last > 0.0) or (first > 0.0 and last < 0.0):  # a product of the two might vanish
        near -= x0 * x0 + x1 * x1  # the foot may lie in between: a bound on how much nearer it is
    return radius < near - margin


@uncounted
def _at(side, w, ew, h, eh, n0, n1, en, nn, enn, n2, en2,
        p0, p1, p2, ep, a0, a1, a2, b0, b1, b2, c0, c1, c2, ef):  # fmt: skip
    """(verdict, lo, hi) of the meeting point q = ((h n0 -+ n1 w), (h n1 +- n0 w)) / nn at the height of p."""
    t, et = mul(h, eh, n0, en)
    s, es = mul(n1, en, side * w, ew)
    x, ex = add(t, et, s, es)
    q0, eq0 = div(x, ex, nn, enn)
    t, et = mul(h, eh, n1, en)
    s, es = mul(n0, en, -side * w, ew)
    y, ey = add(t, et, s, es)
    q1, eq1 = div(y, ey, nn, enn)
    eq = max(eq0, eq1)
    ab = _inside(q0, q1, p2, eq, ep, a0, a1, a2, b0, b1, b2, ef, n0, n1, n2, max(en, en2))
    bc = _inside(q0, q1, p2, eq, ep, b0, b1, b2, c0, c1, c2, ef, n0, n1, n2, max(en, en2))
    ca = _inside(q0, q1, p2, eq, ep, c0, c1, c2, a0, a1, a2, ef, n0, n1, n2, max(en, en2))
    if ab < 0 or bc < 0 or ca < 0:
        return NONE, 0.0, 0.0
    x, ex = dot2(p0, p1, ep, q0, q1, eq)
    y, ey = cross2(p0, p1, ep, q0, q1, eq)
    lo, hi = angle_bounds(x, ex, y, ey)
    return (CERTAIN if ab > 0 and bc > 0 and ca > 0 and hi < TWO_PI else UNSURE), lo, hi


@uncounted
def _inside(q0, q1, q2, eq, eq2, a0, a1, a2, b0, b1, b2, ef, n0, n1, n2, en):
    """Certain sign of n.((b - a) x (q - a)), 0 when unsure."""
    e0, ee0 = minus(b0, ef, a0, ef)
    e1, ee1 = minus(b1, ef, a1, ef)
    e2, ee2 = minus(b2, ef, a2, ef)
    g0, eg0 = minus(q0, eq, a0, ef)
    g1, eg1 = minus(q1, eq, a1, ef)
    g2, eg2 = minus(q2, eq2, a2, ef)
    ee, eg = max(ee0, ee1, ee2), max(eg0, eg1, eg2)
    x0, ex0 = cross2(e1, e2, ee, g1, g2, eg)
    x1, ex1 = cross2(e2, e0, ee, g2, g0, eg)
    x2, ex2 = cross2(e0, e1, ee, g0, g1, eg)
    t, et = dot2(n0, n1, en, x0, x1, max(ex0, ex1))
    s, es = mul(n2, en, x2, ex2)
    t, et = add(t, et, s, es)
    return 1 if t > et else -1 if t < -et else 0


@uncounted
def _flat_bound(p0, p1, a0, a1, b0, b1, c0, c1, err_p, err_f):
    """A lower bound of the contact angles with a facet (nearly) across the axis: p enters through a side."""
    err = err_p + err_f
    ab = planar_turn(a0, a1, b0, b1, p0, p1, err)
    bc = planar_turn(b0, b1, c0, c1, p0, p1, err)
    ca = planar_turn(c0, c1, a0, a1, p0, p1, err)
    if not (max(ab, bc, ca) > 0 and min(ab, bc, ca) < 0):
        return 0.0
    lo = planar_point_bound(p0, p1, a0, a1, b0, b1, err_p, err_f)
    lo = min(lo, planar_point_bound(p0, p1, b0, b1, c0, c1, err_p, err_f))
    return min(lo, planar_point_bound(p0, p1, c0, c1, a0, a1, err_p, err_f))


def rotation_contacts(axis: Axis, p: Vector, a: Vector, b: Vector, c: Vector) -> list[Contact]:
    """The isolated contacts of p, turning, with the closed triangle abc; exact, without divisions.

    Where p stays in the facet over a whole window of angles, the ends of the window are listed.
    """
    n = cross(sub(b, a), sub(c, a))
    K, h = axis.K, axis.h  # noqa: N806
    height = axis.height(p)
    arm, side = sub(scaled(K, p), scaled(height, h)), cross(h, p)
    # K p(phi) = height h + cos phi arm + sqrt(K) sin phi side
    if all(sign(x) == 0 for x in arm):
        return _resting(axis, p, a, b, c)
    alpha, beta, gamma = dot(n, arm), dot(n, side), K * dot(n, a) - height * dot(n, h)
    # n.(p(phi) - a) = 0:  alpha cos phi + sqrt(K) beta sin phi = gamma
    norm = alpha * alpha + K * (beta * beta)
    if sign(norm) == 0:
        return _resting(axis, p, a, b, c) if sign(gamma) == 0 else []
    d = K * (norm - gamma * gamma)
    s = sign(d)
    if s < 0:
        return []
    R, Kb = K * norm, K * beta  # noqa: N806
    # q(phi) lies inside side v w iff m.(q - v) >= 0, m = n x (w - v): linear in cosine and sine
    inside = []
    for v, w in ((a, b), (b, c), (c, a)):
        m = cross(n, sub(w, v))
        inside.append((R * (height * dot(m, h) - K * dot(m, v)), dot(m, arm), K * dot(m, side)))
    found: list[Contact] = []
    for way in (-1, 1) if s else (1,):
        Xx, Xy, Yx, Yy = K * (gamma * alpha), -way * Kb, gamma * Kb, way * alpha  # noqa: N806
        if all(Surd(k + Xx * x + Yx * y, Xy * x + Yy * y, d).sign() >= 0 for k, x, y in inside):
            X, Y = Surd(Xx, Xy, d), Surd(Yx, Yy, d)  # noqa: N806
            q = along(along(scaled(R * height, h), X, arm), Y * K, side)
            found.append((AngleInstant(X, Y, R, K), (*q, K * R)))
    return found


def _resting(axis: Axis, p: Vector, a: Vector, b: Vector, c: Vector) -> list[Contact]:
    """p stays in the facet's plane (or does not move, or the facet has no area): it enters through sides."""
    sides = ((a, b), (b, c), (c, a))
    n = cross(sub(b, a), sub(c, a))
    found = [contact for q, r in sides for contact in point_line_rotation.rotation_contacts(axis, p, q, r)]
    flat = all(sign(x) == 0 for x in n)
    if not flat and sign(dot(n, sub(p, a))) == 0:
        if all(sign(dot(n, cross(sub(w, v), sub(p, v)))) >= 0 for v, w in sides):
            found.append((AngleInstant(1, 0, 1, axis.K), (*p, 1)))
    return found
