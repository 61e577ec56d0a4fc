"""Edge against edge under rotation: edge ab turns about an axis through the origin, edge cd rests.

A contact joins points of equal height and radius.  Equal height is one linear equation between the parameters
lam on ab and mu on cd; along it the difference of the squared radii is a quadratic, whose roots are the contacts;
the angle between the two points is their time (form (B) of the derivation; Schoemer & Thiel 1995, section 4.2, give
the equivalent time form, equation (6)).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.exact.fields.surd import Surd
from firstcontact.exact.numbers import sign
from firstcontact.exact.times.instants import AngleInstant
from firstcontact.exact.times.turning import Axis
from firstcontact.exact.vectors import Vector, along, cross, divisible, dot, scaled, sub
from firstcontact.kernels.angle import TWO_PI, angle_bounds
from firstcontact.kernels.jit import uncounted
from firstcontact.kernels.running import add, cross2, div, dot2, mul, root
from firstcontact.kernels.running import sub as minus
from firstcontact.kernels.verdict import CERTAIN, NONE, UNSURE
from firstcontact.pairs.elements import point_line_rotation
from firstcontact.pairs.elements.line_line import contact_point, segments_meet
from firstcontact.pairs.elements.point_line_rotation import Contact, angle_between

if TYPE_CHECKING:
    from flint import arb, fmpq, fmpz

    from firstcontact.exact.ring import Scalar


@uncounted
def rotation_filter(a0, a1, a2, b0, b1, b2, c0, c1, c2, d0, d1, d2, err_a, err_b):
    """Two (verdict, lo, hi) of the possible contacts of ab, turning about +z, with cd; angles in [0, 2 pi].

    err_a, err_b bound the error of every coordinate of ab and of cd.
    """
    none = NONE, 0.0, 0.0, NONE, 0.0, 0.0
    if min(a2, b2) - err_a > max(c2, d2) + err_b or min(c2, d2) - err_b > max(a2, b2) + err_a:
        return none
    ez, eez = minus(b2, err_a, a2, err_a)
    fz, efz = minus(d2, err_b, c2, err_b)
    if _radii_differ(a0, a1, a2, b0, b1, b2, c0, c1, c2, d0, d1, d2, ez, fz, err_a, err_b):
        return none
    if abs(ez) <= eez and abs(fz) <= efz:
        lo = planar_bound(a0, a1, b0, b1, c0, c1, d0, d1, err_a, err_b)
        return (UNSURE, lo, TWO_PI, NONE, 0.0, 0.0) if lo < TWO_PI else none
    # the divisor of the parametrisation must be certain, and is better the larger one
    if abs(ez) <= eez or (abs(fz) > efz and abs(ez) < abs(fz)):
        # exchange the edges: turning cd backwards meets ab at the same angles; a mirror image turns it forwards
        v0, lo0, hi0, v1, lo1, hi1 = _steeper_first(
            c0, -c1, c2, d0, -d1, d2, a0, -a1, a2, b0, -b1, b2, fz, efz, ez, eez, err_b, err_a
        )
    else:
        v0, lo0, hi0, v1, lo1, hi1 = _steeper_first(
            a0, a1, a2, b0, b1, b2, c0, c1, c2, d0, d1, d2, ez, eez, fz, efz, err_a, err_b
        )
    if v0 == UNSURE or v1 == UNSURE:
        # projected along the axis the edges must meet as well: a bound where heights tell little
        lo = planar_bound(a0, a1, b0, b1, c0, c1, d0, d1, err_a, err_b)
        if lo >= TWO_PI:
            return none
        lo0, lo1 = max(lo0, lo), max(lo1, lo)
        if v0 == UNSURE and lo0 > hi0:
            v0 = NONE
        if v1 == UNSURE and lo1 > hi1:
            v1 = NONE
    return v0, lo0, hi0, v1, lo1, hi1


@uncounted
def _radii_differ(a0, a1, a2, b0, b1, b2, c0, c1, c2, d0, d1, d2, ez, fz, err_a, err_b):
    """Whether the radii of ab and cd certainly differ at all common heights: cheap, rejects most pairs.

    Over the common heights the difference of the squared radii is a quadratic with the values q0, q1 at the ends
    and a second-order part of at most ||P1 - P0|^2 - |Q1 - Q0|^2| / 4 in between.  Points of an edge are within
    2 `delta` of their place: the parameter carries the errors of heights over the edge's own height, at least four
    times as large.  Two squares then err by 8 R delta in all, half of the margin.
    """
    z0, z1 = max(min(a2, b2), min(c2, d2)), min(max(a2, b2), max(c2, d2))
    z_err = 8.0 * 2.0**-53 * (abs(a2) + abs(b2) + abs(c2) + abs(d2)) + 4.0 * (err_a + err_b)
    if not (abs(ez) > 4.0 * z_err and abs(fz) > 4.0 * z_err):
        return False
    i, j = 1.0 / ez, 1.0 / fz
    e0, e1, f0, f1 = b0 - a0, b1 - a1, d0 - c0, d1 - c1
    s, t = (z0 - a2) * i, (z1 - a2) * i
    p0, p1, r0, r1 = a0 + s * e0, a1 + s * e1, a0 + t * e0, a1 + t * e1
    s, t = (z0 - c2) * j, (z1 - c2) * j
    q0, q1, u0, u1 = c0 + s * f0, c1 + s * f1, c0 + t * f0, c1 + t * f1
    size_a, size_b = abs(a0) + abs(a1) + abs(b0) + abs(b1), abs(c0) + abs(c1) + abs(d0) + abs(d1)
    delta_a = (abs(e0) + abs(e1)) * abs(i) * z_err + 16.0 * 2.0**-53 * size_a + 4.0 * err_a
    delta_b = (abs(f0) + abs(f1)) * abs(j) * z_err + 16.0 * 2.0**-53 * size_b + 4.0 * err_b
    first = p0 * p0 + p1 * p1 - q0 * q0 - q1 * q1
    last = r0 * r0 + r1 * r1 - u0 * u0 - u1 * u1
    x0, x1, y0, y1 = r0 - p0, r1 - p1, u0 - q0, u1 - q1
    bow = 0.25 * abs(x0 * x0 + x1 * x1 - y0 * y0 - y1 * y1)
    margin = 16.0 * ((size_a + delta_a) * delta_a + (size_b + delta_b) * delta_b)
    margin += 32.0 * 2.0**-53 * (size_a * size_a + size_b * size_b)
    return (first > 0.0) == (last > 0.0) and min(abs(first), abs(last)) > bow + margin


@uncounted
def _steeper_first(a0, a1, a2, b0, b1, b2, c0, c1, c2, d0, d1, d2, ez, eez, fz, efz, err_a, err_b):
    """The filter for |ez| >= |fz|, |ez| > its error: parametrised by mu on cd, lam = (wz + mu fz) / ez."""
    none = NONE, 0.0, 0.0, NONE, 0.0, 0.0
    wz, ewz = minus(c2, err_b, a2, err_a)
    lam0, elam0 = div(wz, ewz, ez, eez)
    slope, eslope = div(fz, efz, ez, eez)
    e0, ee0 = minus(b0, err_a, a0, err_a)
    e1, ee1 = minus(b1, err_a, a1, err_a)
    f0, ef0 = minus(d0, err_b, c0, err_b)
    f1, ef1 = minus(d1, err_b, c1, err_b)
    # P(mu) = P + mu G on the line of ab, Q(mu) = C + mu F on the line of cd, both at one height
    t, et = mul(lam0, elam0, e0, ee0)
    p0, ep0 = add(a0, err_a, t, et)
    t, et = mul(lam0, elam0, e1, ee1)
    p1, ep1 = add(a1, err_a, t, et)
    g0, eg0 = mul(slope, eslope, e0, ee0)
    g1, eg1 = mul(slope, eslope, e1, ee1)
    ep, eg, ef = max(ep0, ep1), max(eg0, eg1), max(ef0, ef1)
    gg, egg = dot2(g0, g1, eg, g0, g1, eg)
    ff, eff = dot2(f0, f1, ef, f0, f1, ef)
    pg, epg = dot2(p0, p1, ep, g0, g1, eg)
    cf, ecf = dot2(c0, c1, err_b, f0, f1, ef)
    pp, epp = dot2(p0, p1, ep, p0, p1, ep)
    cc, ecc = dot2(c0, c1, err_b, c0, c1, err_b)
    qa, eqa = minus(gg, egg, ff, eff)
    qb, eqb = minus(pg, epg, cf, ecf)
    qc, eqc = minus(pp, epp, cc, ecc)
    if abs(qc) - eqc > (abs(qa) + eqa + 2.0 * (abs(qb) + eqb)) * (1.0 + 1e-15):
        return none  # the radii differ all along cd
    t, et = mul(qb, eqb, qb, eqb)
    s, es = mul(qa, eqa, qc, eqc)
    disc, edisc = minus(t, et, s, es)
    if disc < -edisc:
        return none
    w, ew = root(disc, edisc)
    if qb >= 0.0:
        k, ek = add(qb, eqb, w, ew)
    else:
        k, ek = minus(qb, eqb, w, ew)
    k = -k
    if abs(k) <= ek:
        return UNSURE, 0.0, TWO_PI, NONE, 0.0, 0.0
    v0, lo0, hi0 = NONE, 0.0, 0.0
    if abs(qa) > eqa:
        mu, emu = div(k, ek, qa, eqa)
        v0, lo0, hi0 = _at(
            mu, emu, lam0, elam0, slope, eslope, p0, p1, ep, g0, g1, eg, c0, c1, err_b, f0, f1, ef
        )
    elif abs(k) - ek <= (abs(qa) + eqa) * (1.0 + 1e-15):
        v0, lo0, hi0 = UNSURE, 0.0, TWO_PI
    mu, emu = div(qc, eqc, k, ek)
    v1, lo1, hi1 = _at(
        mu, emu, lam0, elam0, slope, eslope, p0, p1, ep, g0, g1, eg, c0, c1, err_b, f0, f1, ef
    )
    if disc <= edisc:
        v0, v1 = (UNSURE if v0 != NONE else NONE), (UNSURE if v1 != NONE else NONE)
    return v0, lo0, hi0, v1, lo1, hi1


@uncounted
def _at(mu, emu, lam0, elam0, slope, eslope, p0, p1, ep, g0, g1, eg, c0, c1, ec, f0, f1, ef):
    """(verdict, lo, hi) of the contact at parameter mu."""
    if mu + emu < 0.0 or mu - emu > 1.0:
        return NONE, 0.0, 0.0
    t, et = mul(mu, emu, slope, eslope)
    lam, elam = add(lam0, elam0, t, et)
    if lam + elam < 0.0 or lam - elam > 1.0:
        return NONE, 0.0, 0.0
    t, et = mul(mu, emu, g0, eg)
    x0, ex0 = add(p0, ep, t, et)
    t, et = mul(mu, emu, g1, eg)
    x1, ex1 = add(p1, ep, t, et)
    t, et = mul(mu, emu, f0, ef)
    y0, ey0 = add(c0, ec, t, et)
    t, et = mul(mu, emu, f1, ef)
    y1, ey1 = add(c1, ec, t, et)
    x, ex = dot2(x0, x1, max(ex0, ex1), y0, y1, max(ey0, ey1))
    y, ey = cross2(x0, x1, max(ex0, ex1), y0, y1, max(ey0, ey1))
    lo, hi = angle_bounds(x, ex, y, ey)
    inside = mu > emu and mu < 1.0 - emu and lam > elam and lam < 1.0 - elam
    return (CERTAIN if inside and hi < TWO_PI else UNSURE), lo, hi


@uncounted
def planar_bound(a0, a1, b0, b1, c0, c1, d0, d1, err_a, err_b):
    """A lower bound of the angles at which ab, turning about the origin of the plane, meets cd; 2 pi for never.

    Segments that do not meet at angle 0 first meet at an end point of one of them.
    """
    if _may_cross(a0, a1, b0, b1, c0, c1, d0, d1, err_a + err_b):
        return 0.0
    lo = planar_point_bound(a0, a1, c0, c1, d0, d1, err_a, err_b)
    lo = min(lo, planar_point_bound(b0, b1, c0, c1, d0, d1, err_a, err_b))
    lo = min(lo, planar_point_bound(c0, -c1, a0, -a1, b0, -b1, err_b, err_a))
    return min(lo, planar_point_bound(d0, -d1, a0, -a1, b0, -b1, err_b, err_a))


@uncounted
def _may_cross(a0, a1, b0, b1, c0, c1, d0, d1, err):
    """False when the plane segments ab and cd certainly share no point."""
    s = planar_turn(a0, a1, b0, b1, c0, c1, err) * planar_turn(a0, a1, b0, b1, d0, d1, err)
    r = planar_turn(c0, c1, d0, d1, a0, a1, err) * planar_turn(c0, c1, d0, d1, b0, b1, err)
    if s > 0 or r > 0:
        return False
    return not (
        max(a0, b0) + err < min(c0, d0) or max(c0, d0) + err < min(a0, b0)
        or max(a1, b1) + err < min(c1, d1) or max(c1, d1) + err < min(a1, b1)
    )  # fmt: skip


@uncounted
def planar_turn(a0, a1, b0, b1, p0, p1, err):
    """Certain sign of the turn a, b, p; 0 when unsure."""
    e0, ee0 = minus(b0, err, a0, err)
    e1, ee1 = minus(b1, err, a1, err)
    p, ep = minus(p0, err, a0, err)
    q, eq = minus(p1, err, a1, err)
    t, et = cross2(e0, e1, max(ee0, ee1), p, q, max(ep, eq))
    return 1 if t > et else -1 if t < -et else 0


@uncounted
def planar_point_bound(p0, p1, c0, c1, d0, d1, err_p, err_c):
    """A lower bound of the angles at which p, turning about the origin, meets the segment cd; 2 pi: never."""
    f0, ef0 = minus(d0, err_c, c0, err_c)
    f1, ef1 = minus(d1, err_c, c1, err_c)
    ef = max(ef0, ef1)
    qa, eqa = dot2(f0, f1, ef, f0, f1, ef)
    qb, eqb = dot2(c0, c1, err_c, f0, f1, ef)
    cc, ecc = dot2(c0, c1, err_c, c0, c1, err_c)
    pp, epp = dot2(p0, p1, err_p, p0, p1, err_p)
    qc, eqc = minus(cc, ecc, pp, epp)
    if abs(qc) - eqc > (abs(qa) + eqa + 2.0 * (abs(qb) + eqb)) * (1.0 + 1e-15):
        return TWO_PI
    t, et = mul(qb, eqb, qb, eqb)
    s, es = mul(qa, eqa, qc, eqc)
    disc, edisc = minus(t, et, s, es)
    if disc < -edisc:
        return TWO_PI
    w, ew = root(disc, edisc)
    if qb >= 0.0:
        k, ek = add(qb, eqb, w, ew)
    else:
        k, ek = minus(qb, eqb, w, ew)
    k = -k
    if abs(k) <= ek or abs(qa) <= eqa:
        return 0.0
    mu, emu = div(k, ek, qa, eqa)
    lo = _bound_at(mu, emu, p0, p1, err_p, c0, c1, err_c, f0, f1, ef)
    mu, emu = div(qc, eqc, k, ek)
    return min(lo, _bound_at(mu, emu, p0, p1, err_p, c0, c1, err_c, f0, f1, ef))


@uncounted
def _bound_at(mu, emu, p0, p1, ep, c0, c1, ec, f0, f1, ef):
    if mu + emu < 0.0 or mu - emu > 1.0:
        return TWO_PI
    t, et = mul(mu, emu, f0, ef)
    y0, ey0 = add(c0, ec, t, et)
    t, et = mul(mu, emu, f1, ef)
    y1, ey1 = add(c1, ec, t, et)
    ey = max(ey0, ey1)
    x, ex = dot2(p0, p1, ep, y0, y1, ey)
    y, ey2 = cross2(p0, p1, ep, y0, y1, ey)
    lo, _ = angle_bounds(x, ex, y, ey2)
    return lo


def rotation_contacts(axis: Axis, a: Vector, b: Vector, c: Vector, d: Vector) -> list[Contact]:
    """The isolated contacts of ab, turning, with cd; exact, without divisions.

    Where the edges stay in contact over a whole window of angles, the ends of the window are listed
    (angle 0 when they meet at the start).
    """
    e, f, w = sub(b, a), sub(d, c), sub(c, a)
    ez, fz, wz = axis.height(e), axis.height(f), axis.height(w)
    if sign(ez) == 0 and sign(fz) == 0:
        return _horizontal(axis, a, b, c, d) if sign(wz) == 0 else []
    # points of equal heights: a + lam e and c + mu f, n lam = k + s fz, n mu = l + s ez; p + s u and q + s v are n
    # times these points
    way = sign(ez) or sign(fz)
    n, k, l = (way * ez, way * wz, 0 * wz) if sign(ez) else (way * fz, 0 * wz, -way * wz)  # noqa: E741
    p, q = along(scaled(n, a), k, e), along(scaled(n, c), l, f)
    u, v = scaled(fz, e), scaled(ez, f)
    # squares of radii are equal where squares are: p and q, u and v are equally high
    qq, qv, vv = dot(q, q), dot(q, v), dot(v, v)
    qa, qb, qc = dot(u, u) - vv, dot(p, u) - qv, dot(p, p) - qq
    if sign(qa) == 0 and sign(qb) == 0:
        return _same_surface(axis, *divisible(a, b, c, d)) if sign(qc) == 0 else []
    found: list[Contact] = []
    for s, z in _roots(qa, qb, qc):  # s / z, z > 0
        whole = n * z
        if not (_within(k * z + s.x * fz, s.y * fz, s.d, whole) and _within(l * z + s.x * ez, s.y * ez, s.d, whole)):
            continue
        x, y, z0 = (Surd(z * q[i] + s.x * v[i], s.y * v[i], s.d) for i in range(3))
        found.append((_angle_between(axis, p, u, q, v, ez * fz, (qq, qv, vv), s, z), (x, y, z0, whole)))
    return found


def _within(x: Scalar, y: Scalar, d: Scalar, whole: Scalar) -> bool:
    """Whether 0 <= x + y sqrt(d) <= whole."""
    return Surd(x, y, d).sign() >= 0 and Surd(whole - x, -y, d).sign() >= 0


def _angle_between(
    axis: Axis,
    p: Vector,
    u: Vector,
    q: Vector,
    v: Vector,
    vz: Scalar,
    squares: tuple[Scalar, Scalar, Scalar],
    s: Surd,
    z: Scalar,
) -> AngleInstant:
    """`angle_between` of z p + s u and z q + s v, of equal heights and radii.

    Its three numbers are quadratic in s: products of the four vectors are their coefficients.  vz: height of u and v.
    squares: q.q, q.v and v.v.
    """
    (qq, qv, vv), h, K = squares, axis.h, axis.K  # noqa: N806
    qz = dot(h, q)
    zz, zv, vv_z = qz * qz, 2 * (qz * vz), vz * vz
    one, first, second = z * z, z * s.x, s.x * s.x + s.y * s.y * s.d
    y1, y2 = z * s.y, 2 * (s.x * s.y)

    def number(c0: Scalar, c1: Scalar, c2: Scalar) -> Surd:
        return Surd(one * c0 + first * c1 + second * c2, y1 * c1 + y2 * c2, s.d)

    r = number(K * qq - zz, 2 * (K * qv) - zv, K * vv - vv_z)
    if r.sign() == 0:
        return AngleInstant(1, 0, 1, K)
    x = number(K * dot(p, q) - zz, K * (dot(p, v) + dot(u, q)) - zv, K * dot(u, v) - vv_z)
    hp, hu = cross(h, p), cross(h, u)
    return AngleInstant(x, number(dot(hp, q), dot(hp, v) + dot(hu, q), dot(hu, v)), r, K)


def _roots(a: Scalar, b: Scalar, c: Scalar) -> list[tuple[Surd, fmpz | fmpq | arb]]:
    """Real roots of a s^2 + 2 b s + c, not constant, as (numerator, positive denominator)."""
    if sign(a) == 0:
        return [(Surd(-c * sign(b)), 2 * b * sign(b))]
    way = sign(a)
    d = b * b - a * c
    s = sign(d)
    if s < 0:
        return []
    b, a = b * way, a * way
    return [(Surd(-b, y * way, d), a) for y in (-1, 1)] if s else [(Surd(-b), a)]


def _horizontal(axis: Axis, a: Vector, b: Vector, c: Vector, d: Vector) -> list[Contact]:
    """Both edges lie in one plane across the axis: contacts begin and end at end points."""
    found = point_line_rotation.rotation_contacts(axis, a, c, d)
    found += point_line_rotation.rotation_contacts(axis, b, c, d)
    for end in (c, d):
        found += [(at, (*end, 1)) for at, _ in point_line_rotation.rotation_contacts(axis.reversed(), end, a, b)]
    return found + _at_start(axis, a, b, c, d)


def _at_start(axis: Axis, a: Vector, b: Vector, c: Vector, d: Vector) -> list[Contact]:
    a, b, c, d = divisible(a, b, c, d)
    if not segments_meet(a, b, c, d):
        return []
    point = contact_point(a, b, c, d, (0, 0, 0), 0)
    return [(AngleInstant(1, 0, 1, axis.K), (*point, 1))]


def _same_surface(axis: Axis, a: Vector, b: Vector, c: Vector, d: Vector) -> list[Contact]:
    """Both lines lie on one surface of revolution.

    The angle is monotone or piecewise constant along them, so contacts begin at the ends of the common range of
    heights, or at the start.
    """
    e, f = sub(b, a), sub(d, c)
    ez, fz, wz = axis.height(e), axis.height(f), axis.height(sub(c, a))
    n = ez * ez + fz * fz
    lo, hi = None, None
    for base, rate in ((wz * ez / n, fz), (-wz * fz / n, ez)):  # lam and mu of `rotation_contacts`
        if sign(rate) == 0:
            if sign(base) < 0 or sign(1 - base) < 0:
                return []
            continue
        s0, s1 = -base / rate, (1 - base) / rate
        if sign(s1 - s0) < 0:
            s0, s1 = s1, s0
        lo = s0 if lo is None or sign(s0 - lo) > 0 else lo
        hi = s1 if hi is None or sign(hi - s1) > 0 else hi
    if sign(hi - lo) < 0:  # type: ignore[operator]
        return []
    ends = [
        (along(a, wz * ez / n + s * fz, e), along(c, -wz * fz / n + s * ez, f)) for s in (lo, hi)  # type: ignore[operator]
    ]
    return [(angle_between(axis, x, y), (*y, 1)) for x, y in ends] + _at_start(axis, a, b, c, d)
