"""Edge against edge under translation: edge ab moves by t v, edge cd rests.

With e = b - a, f = d - c, w = c - a the lines meet at t = N/D,

    D = v.(e x f)    N = w.(e x f)    lam = v.(w x f)/D    mu = v.(w x e)/D,

(Schoemer & Thiel 1995, section 4; the side product of Pluecker vectors is -N + t D).  A contact forces D,
D lam, D (1 - lam), D mu and D (1 - mu) to have one common sign, zeros allowed, whether D vanishes or not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from flint import fmpz

from firstcontact.exact.numbers import sign
from firstcontact.exact.times.windows import ALWAYS, Window, hull
from firstcontact.exact.vectors import Vector, along, cross, dot, ratio, scaled, sub
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.verdict import CERTAIN, DET_EPS, NONE, TINY, UNSURE, cross_size, quotient, slack3
from firstcontact.kernels.verdict import cross as cross_f
from firstcontact.pairs.elements import point_line

if TYPE_CHECKING:
    from firstcontact.exact.ring import Scalar


@uncounted
def translation_filter(
    a0, a1, a2, b0, b1, b2, c0, c1, c2, d0, d1, d2, v0, v1, v2, t_first, t_last, err_a, err_b
):
    """(verdict, lo, hi): no contact in [t_first, t_last], or certainly one, in [lo, hi], or unsure.

    err_a, err_b bound the error of every coordinate of ab and of cd.  Unsure: any contact lies in [lo, hi].
    """
    e0, e1, e2 = b0 - a0, b1 - a1, b2 - a2
    f0, f1, f2 = d0 - c0, d1 - c1, d2 - c2
    w0, w1, w2 = c0 - a0, c1 - a1, c2 - a2
    p0, p1, p2 = b0 - c0, b1 - c1, b2 - c2
    q0, q1, q2 = d0 - a0, d1 - a1, d2 - a2
    g0, g1, g2 = cross_f(e0, e1, e2, f0, f1, f2)
    s0, s1, s2 = cross_size(e0, e1, e2, f0, f1, f2)
    den = v0 * g0 + v1 * g1 + v2 * g2
    num = w0 * g0 + w1 * g1 + w2 * g2
    den_err = DET_EPS * (abs(v0) * s0 + abs(v1) * s1 + abs(v2) * s2) + TINY
    num_err = DET_EPS * (abs(w0) * s0 + abs(w1) * s1 + abs(w2) * s2) + TINY
    h0, h1, h2 = cross_f(v0, v1, v2, w0, w1, w2)
    s0, s1, s2 = cross_size(v0, v1, v2, w0, w1, w2)
    lam = h0 * f0 + h1 * f1 + h2 * f2
    mu = h0 * e0 + h1 * e1 + h2 * e2
    lam_err = DET_EPS * (s0 * abs(f0) + s1 * abs(f1) + s2 * abs(f2)) + TINY
    mu_err = DET_EPS * (s0 * abs(e0) + s1 * abs(e1) + s2 * abs(e2)) + TINY
    h0, h1, h2 = cross_f(v0, v1, v2, p0, p1, p2)
    s0, s1, s2 = cross_size(v0, v1, v2, p0, p1, p2)
    lam1 = h0 * f0 + h1 * f1 + h2 * f2
    lam1_err = DET_EPS * (s0 * abs(f0) + s1 * abs(f1) + s2 * abs(f2)) + TINY
    h0, h1, h2 = cross_f(v0, v1, v2, q0, q1, q2)
    s0, s1, s2 = cross_size(v0, v1, v2, q0, q1, q2)
    mu1 = -(h0 * e0 + h1 * e1 + h2 * e2)
    mu1_err = DET_EPS * (s0 * abs(e0) + s1 * abs(e1) + s2 * abs(e2)) + TINY
    if err_a + err_b > 0.0:
        v = abs(v0) + abs(v1) + abs(v2)
        e, de = abs(e0) + abs(e1) + abs(e2), 6.0 * err_a
        f, df = abs(f0) + abs(f1) + abs(f2), 6.0 * err_b
        w, dw = abs(w0) + abs(w1) + abs(w2), 3.0 * (err_a + err_b)
        p, q = abs(p0) + abs(p1) + abs(p2), abs(q0) + abs(q1) + abs(q2)
        den_err += slack3(v, e, f, 0.0, de, df)
        num_err += slack3(w, e, f, dw, de, df)
        lam_err += slack3(v, w, f, 0.0, dw, df)
        mu_err += slack3(v, w, e, 0.0, dw, de)
        lam1_err += slack3(v, p, f, 0.0, dw, df)
        mu1_err += slack3(v, q, e, 0.0, dw, de)
    plus = den > den_err or lam > lam_err or lam1 > lam1_err or mu > mu_err or mu1 > mu1_err
    minus = den < -den_err or lam < -lam_err or lam1 < -lam1_err or mu < -mu_err or mu1 < -mu1_err
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
    sure = abs(lam) > lam_err and abs(lam1) > lam1_err and abs(mu) > mu_err and abs(mu1) > mu1_err
    return (CERTAIN if sure else UNSURE), lo, hi


def translation_window(a: Vector, b: Vector, c: Vector, d: Vector, v: Vector) -> Window | None:
    """The times t at which the segments ab + t v and cd share a point; exact.

    The segments are convex, so these times form one closed interval.
    """
    e, f, w = sub(b, a), sub(d, c), sub(c, a)
    g = cross(e, f)
    den = dot(v, g)
    s = sign(den)
    if s == 0:
        return _degenerate_window(a, b, c, d, v)
    h = cross(v, w)
    for share in (dot(h, f), dot(h, e)):  # D lam and D mu
        if sign(share) * s < 0 or sign(den - share) * s < 0:
            return None
    t = ratio(dot(w, g), den)
    return t, t


def _degenerate_window(a: Vector, b: Vector, c: Vector, d: Vector, v: Vector) -> Window | None:
    """e, f, v are dependent: contacts begin and end at end points (spec of D = 0), unless v = 0."""
    if all(sign(x) == 0 for x in v):
        return ALWAYS if segments_meet(a, b, c, d) else None
    back = (-v[0], -v[1], -v[2])
    return hull([
        point_line.translation_window(a, v, c, d),
        point_line.translation_window(b, v, c, d),
        point_line.translation_window(c, back, a, b),
        point_line.translation_window(d, back, a, b),
    ])  # fmt: skip


def segments_meet(a: Vector, b: Vector, c: Vector, d: Vector) -> bool:
    """Whether the closed segments ab and cd share a point; exact."""
    e, f, w = sub(b, a), sub(d, c), sub(c, a)
    n = cross(e, f)
    nn = dot(n, n)
    if sign(nn) != 0:
        if sign(dot(w, n)) != 0:
            return False
        lam, mu = dot(cross(w, f), n), dot(cross(w, e), n)
        return sign(lam) >= 0 and sign(nn - lam) >= 0 and sign(mu) >= 0 and sign(nn - mu) >= 0
    ends = [(a, c, d), (b, c, d), (c, a, b), (d, a, b)]
    return any(point_line.on_segment(p, q, r) for p, q, r in ends)


def segments_cross(a: Vector, b: Vector, c: Vector, d: Vector) -> bool:
    """Whether the insides of segments ab and cd share one point and no more; exact."""
    e, f, w = sub(b, a), sub(d, c), sub(c, a)
    n = cross(e, f)
    nn = dot(n, n)
    if sign(nn) == 0 or sign(dot(w, n)) != 0:
        return False
    lam, mu = dot(cross(w, f), n), dot(cross(w, e), n)
    return sign(lam) > 0 and sign(nn - lam) > 0 and sign(mu) > 0 and sign(nn - mu) > 0


def contact_place(
    a: Vector, b: Vector, c: Vector, d: Vector, v: Vector, t: object
) -> tuple[Scalar, Scalar, Scalar, Scalar | int]:
    """`contact_point` as numerators and denominator, of whole numbers without divisions."""
    e, f, w = sub(b, a), sub(d, c), sub(c, a)
    h = cross(v, e)
    den = dot(h, f)
    if type(den) is not fmpz or den == 0:
        return *contact_point(a, b, c, d, v, t), 1
    return *along(scaled(den, c), -dot(h, w), f), den


def contact_point(a: Vector, b: Vector, c: Vector, d: Vector, v: Vector, t: object) -> Vector:
    """A shared point of ab + t v and cd, given that there is one; exact, frame of cd."""
    shift = (t * v[0], t * v[1], t * v[2])  # type: ignore[operator]
    p, q = (tuple(x + y for x, y in zip(end, shift, strict=True)) for end in (a, b))
    e, f, w = sub(q, p), sub(d, c), sub(c, p)  # type: ignore[arg-type]
    n = cross(e, f)
    nn = dot(n, n)
    if sign(nn) != 0:
        mu = dot(cross(w, e), n) / nn
        return c[0] + mu * f[0], c[1] + mu * f[1], c[2] + mu * f[2]
    for r, s0, s1 in ((p, c, d), (q, c, d), (c, p, q), (d, p, q)):
        if point_line.on_segment(r, s0, s1):  # type: ignore[arg-type]
            return r  # type: ignore[return-value]
    raise ArithmeticError("contact_point was asked for segments that do not meet")
