"""First contact of two polyhedra the slow way: all pairs, all exact, one screen per idea.

The truth that the library is tested against.  It imports nothing of the library.  Every candidate time solves
one of three incidence equations (edge meets edge, vertex meets edge, vertex meets face) over the rationals or
over Q(sqrt D), and is then verified by its definition.  No filter, no tree, no float decides anything.

Numbers are `fmpq` or `Surd`; points are triples of them; faces are triples of vertex indices, edges pairs.
A point set is written as edges with two equal ends.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, cmp_to_key
from itertools import combinations, product

from flint import arb, ctx, fmpq

FREE, CONTACT, INITIAL = "FREE", "CONTACT", "INITIAL_CONTACT"
MAX_BITS = 4000  # limits that agree with a contact angle to this many bits are called equal


# -------------------------------------------------------------------------------------------------- numbers


def rational(x) -> fmpq:
    """The exact value of an int, float, Fraction, fmpq or string such as "p/q"."""
    if isinstance(x, fmpq):
        return x
    f = Fraction(x) if isinstance(x, (int, str, Fraction)) else Fraction(float(x))
    return fmpq(f.numerator, f.denominator)


class Surd:
    """x + y sqrt(d) with rational x, y, d > 0; d is no square and y is not 0."""

    __slots__ = ("x", "y", "d")

    def __init__(self, x, y, d):
        self.x, self.y, self.d = x, y, d

    def __add__(self, other):
        if isinstance(other, Surd):
            return surd(self.x + other.x, self.y + other.y, self.d)
        return Surd(self.x + other, self.y, self.d)

    def __neg__(self):
        return Surd(-self.x, -self.y, self.d)

    def __mul__(self, other):
        if isinstance(other, Surd):
            return surd(
                self.x * other.x + self.y * other.y * self.d, self.x * other.y + self.y * other.x, self.d
            )
        return surd(self.x * other, self.y * other, self.d)

    def inverse(self):
        norm = self.x * self.x - self.y * self.y * self.d
        return Surd(self.x / norm, -self.y / norm, self.d)

    def __sub__(self, other):
        return self + (-other)

    def __rsub__(self, other):
        return (-self) + other

    def __truediv__(self, other):
        return (
            self * other.inverse()
            if isinstance(other, Surd)
            else surd(self.x / other, self.y / other, self.d)
        )

    def __rtruediv__(self, other):
        return self.inverse() * other

    __radd__, __rmul__ = __add__, __mul__


def surd(x, y, d):
    return Surd(x, y, d) if y != 0 else x


def square_root(d: fmpq):
    """sqrt(d) for d >= 0, as a rational where it is one."""
    p, q = d.numer(), d.denom()
    r, s = p.isqrt(), q.isqrt()
    return fmpq(r, s) if r * r == p and s * s == q else Surd(fmpq(0), fmpq(1), d)


def sign(v) -> int:
    if isinstance(v, Surd):
        return _sign_of_sum(v.x, v.y, v.d)
    return (v > 0) - (v < 0)


def _sign_of_sum(x, y, d) -> int:
    """Sign of x + y sqrt(d), d >= 0 rational, x and y in any field whose signs are known."""
    sx, sy = sign(x), sign(y) if d != 0 else 0
    if sx == sy or sy == 0:
        return sx
    if sx == 0:
        return sy
    return sx * sign(x * x - y * y * d)


def parts(v):
    return (v.x, v.y, v.d) if isinstance(v, Surd) else (v, fmpq(0), fmpq(1))


def sign_of_cross(c1, s1, c2, s2) -> int:
    """Sign of c1 s2 - s1 c2, (c1, s1) in one quadratic field and (c2, s2) in another."""
    d1 = next((v.d for v in (c1, s1) if isinstance(v, Surd)), fmpq(1))
    d2 = next((v.d for v in (c2, s2) if isinstance(v, Surd)), fmpq(1))
    (c2x, c2y, _), (s2x, s2y, _) = parts(c2), parts(s2)
    if d1 == d2:
        return sign(c1 * s2 - s1 * c2)
    return _sign_of_sum(c1 * s2x - s1 * c2x, c1 * s2y - s1 * c2y, d2)


def ball(v) -> arb:
    return arb(v.x) + arb(v.y) * arb(v.d).sqrt() if isinstance(v, Surd) else arb(v)


def nearest_double(enclosure) -> float:
    """The double nearest the real number that `enclosure()` encloses at the working precision of flint."""
    bits = 64
    while True:
        with ctx.workprec(bits):
            x = enclosure()
            lo, hi = (float(_dyadic(end)) for end in (x.mid() - x.rad(), x.mid() + x.rad()))
        if lo == hi:
            return lo
        bits *= 2
        assert bits < 2**15, "the number lies on a rounding boundary"


def _dyadic(x: arb) -> Fraction:
    man, exp = (int(part) for part in x.mid().man_exp())
    return Fraction(man) * Fraction(2) ** exp


# -------------------------------------------------------------------------------------------------- vectors


def vector(p):
    return tuple(rational(x) for x in p)


def add(p, q):
    return (p[0] + q[0], p[1] + q[1], p[2] + q[2])


def sub(p, q):
    return (p[0] - q[0], p[1] - q[1], p[2] - q[2])


def scale(k, p):
    return (p[0] * k, p[1] * k, p[2] * k)


def dot(p, q):
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


def cross(p, q):
    return (p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0])


def det(p, q, r):
    return dot(p, cross(q, r))


def is_zero(p) -> bool:
    return all(sign(x) == 0 for x in p)


# --------------------------------------------------------------------------------------------- static tests


def on_segment(p, c, d) -> bool:
    f, w = sub(d, c), sub(p, c)
    return (
        is_zero(cross(w, f))
        and 0 <= sign(dot(w, f))
        and sign(dot(f, f) - dot(w, f)) >= 0
        and (not is_zero(f) or is_zero(w))
    )


def segments_meet(a, b, c, d) -> bool:
    e, f, w = sub(b, a), sub(d, c), sub(c, a)
    n = cross(e, f)
    if is_zero(n):
        return on_segment(a, c, d) or on_segment(b, c, d) or on_segment(c, a, b) or on_segment(d, a, b)
    if sign(dot(w, n)) != 0:
        return False
    nn, lam, mu = dot(n, n), det(w, f, n), det(w, e, n)
    return sign(lam) >= 0 and sign(nn - lam) >= 0 and sign(mu) >= 0 and sign(nn - mu) >= 0


def in_triangle(q, triangle, normal) -> bool:
    """Whether a point of the triangle's plane lies in the closed triangle; normal != 0."""
    a, b, c = triangle
    return all(sign(det(normal, sub(y, x), sub(q, x))) >= 0 for x, y in ((a, b), (b, c), (c, a)))


def plane_normal(triangle):
    a, b, c = triangle
    return cross(sub(b, a), sub(c, a))


def segment_meets_triangle(p, q, triangle) -> bool:
    normal = plane_normal(triangle)
    at_p, at_q = dot(normal, sub(p, triangle[0])), dot(normal, sub(q, triangle[0]))
    if at_p * at_q > 0:
        return False
    if at_p == at_q == 0:
        sides = any(segments_meet(p, q, x, y) for x, y in combinations(triangle, 2))
        return sides or (not is_zero(normal) and in_triangle(p, triangle, normal))
    return in_triangle(add(p, scale(at_p / (at_p - at_q), sub(q, p))), triangle, normal)


# --------------------------------------------------------------------------------------------------- shapes


@dataclass(frozen=True)
class Shape:
    """A body at rest: rational points, edges (with all face sides), triangles; a solid owns its interior."""

    points: tuple
    edges: tuple
    faces: tuple
    solid: bool = False

    def moved(self, place) -> Shape:
        return Shape(tuple(place(p) for p in self.points), self.edges, self.faces, self.solid)

    @cached_property
    def segments(self):
        return [(self.points[i], self.points[j]) for i, j in self.edges]

    @cached_property
    def triangles(self):
        return [tuple(self.points[i] for i in face) for face in self.faces]

    @cached_property
    def components(self):
        """One point of every connected component."""
        label = list(range(len(self.points)))
        for i, j in self.edges:
            old, new = label[i], label[j]
            label = [new if k == old else k for k in label]
        used = {i for edge in self.edges for i in edge}
        return [self.points[i] for i in used if i == min(k for k in used if label[k] == label[i])]


def shape(vertices, edges=(), faces=(), solid=False) -> Shape:
    faces = tuple(tuple(int(i) for i in face) for face in faces)
    given = [tuple(sorted(int(i) for i in edge)) for edge in edges]
    sides = [tuple(sorted(side)) for f in faces for side in combinations(f, 2)]
    all_edges = tuple(dict.fromkeys(given + sides)) or tuple((i, i) for i in range(len(vertices)))
    return Shape(tuple(vector(p) for p in vertices), all_edges, faces, solid)


def surfaces_meet(a: Shape, b: Shape) -> bool:
    return (
        any(segments_meet(*ab, *cd) for ab, cd in product(a.segments, b.segments))
        or any(segment_meets_triangle(*ab, abc) for ab, abc in product(a.segments, b.triangles))
        or any(segment_meets_triangle(*cd, abc) for abc, cd in product(a.triangles, b.segments))
    )


def inside(p, body: Shape) -> bool:
    """Whether p is in the closed solid: on its surface, or a generic ray from p crosses it oddly often."""
    if any(segment_meets_triangle(p, p, triangle) for triangle in body.triangles):
        return True
    for k in range(1, 50):
        crossings = _crossings(p, (fmpq(1), fmpq(k, 7 * k + 3), fmpq(-k * k - 1, 11)), body)
        if crossings is not None:
            return crossings % 2 == 1
    raise AssertionError("no generic ray found")


def _crossings(p, ray, body) -> int | None:
    """How many faces the ray crosses, p on none of them; None when its line meets the border of a face."""
    count = 0
    for triangle in body.triangles:
        a, b, c = (sub(x, p) for x in triangle)
        sides = {sign(det(ray, x, y)) for x, y in ((a, b), (b, c), (c, a))}
        if {1, -1} <= sides:
            continue
        if 0 in sides:
            return None
        normal = plane_normal(triangle)
        count += sign(dot(normal, a)) == sign(dot(normal, ray))
    return count


def bodies_meet(a: Shape, b: Shape) -> bool:
    """Whether the closed sets share a point; a solid owns its interior."""
    return (
        surfaces_meet(a, b)
        or (b.solid and any(inside(p, b) for p in a.components))
        or (a.solid and any(inside(p, a) for p in b.components))
    )


def convex_interiors_overlap(points_a, faces_a, points_b, faces_b) -> bool:
    """Whether convex solids share interior points: no face normal, no edge cross product separates them."""
    a, b = shape(points_a, faces=faces_a), shape(points_b, faces=faces_b)
    axes = [plane_normal(t) for t in a.triangles + b.triangles]
    axes += [cross(sub(q, p), sub(s, r)) for (p, q), (r, s) in product(a.segments, b.segments)]
    for axis in axes:
        heights_a, heights_b = [dot(axis, p) for p in a.points], [dot(axis, p) for p in b.points]
        if not is_zero(axis) and (max(heights_a) <= min(heights_b) or max(heights_b) <= min(heights_a)):
            return False
    return True


# ---------------------------------------------------------------------------------------------- translation


class Shift:
    """A moves by t * vector; times are rationals t >= 0."""

    zero = fmpq(0)

    def __init__(self, vector_):
        self.v = vector(vector_)

    def pose(self, t):
        return lambda p: add(p, scale(t, self.v))

    def nearest(self, t) -> float:
        return float(Fraction(int(t.numer()), int(t.denom())))

    def enclosed(self, t, lo: float, hi: float) -> bool:
        return rational(lo) <= t <= rational(hi)

    def compare(self, s, t) -> int:
        return sign(s - t)

    def within(self, t, limit) -> bool:
        return t >= 0 and (limit is None or t <= rational(limit))

    def between(self, s, t, limit):
        """A time strictly between s and t (t = None: between s and the limit); None where there is none."""
        if t is None and limit is None:
            return s + 1
        end = rational(limit) if t is None else t
        return (s + end) / 2 if s < end else None

    def edge_edge(self, a, b, c, d):
        """[t] where a + lam e + t v = c + mu f with lam, mu in [0, 1], by Cramer's rule; [] when singular."""
        e, f, w = sub(b, a), sub(d, c), sub(c, a)
        minus_f = scale(fmpq(-1), f)
        full = det(e, minus_f, self.v)
        if full == 0:
            return []
        lam, mu, t = det(w, minus_f, self.v) / full, det(e, w, self.v) / full, det(e, minus_f, w) / full
        return [t] if 0 <= lam <= 1 and 0 <= mu <= 1 else []

    def vertex_edge(self, p, c, d):
        """Times at which moving p is on cd; for a slide along the edge, its two ends."""
        f, w = sub(d, c), sub(c, p)
        n = cross(self.v, f)
        if is_zero(self.v):
            return [fmpq(0)] if on_segment(p, c, d) else []
        if is_zero(n):
            vv = dot(self.v, self.v)
            return [dot(x, self.v) / vv for x in (w, sub(d, p))] if is_zero(cross(w, self.v)) else []
        mu = det(w, self.v, n) / dot(n, n)
        return [det(w, f, n) / dot(n, n)] if dot(w, n) == 0 and 0 <= mu <= 1 else []

    def vertex_face(self, p, triangle):
        normal = plane_normal(triangle)
        speed = dot(normal, self.v)
        if speed == 0:
            return []
        t = dot(normal, sub(triangle[0], p)) / speed
        return [t] if in_triangle(add(p, scale(t, self.v)), triangle, normal) else []

    def reversed(self):
        return Shift(scale(fmpq(-1), self.v))


# ------------------------------------------------------------------------------------------------- rotation


@dataclass(frozen=True)
class Angle:
    """The turn with cosine c and sine s * |axis|, in [0, 2 pi)."""

    c: object
    s: object

    def half(self) -> int:
        sine = sign(self.s)
        return 0 if sine > 0 or (sine == 0 and sign(self.c) > 0) else 1


class Turn:
    """A turns about the axis through `point` by a total of `turns` * 2 pi or `radians`, right-hand rule.

    Times are `Angle`s; as floats they are fractions of the total angle.  At most one turn is looked at.
    """

    zero = Angle(fmpq(1), fmpq(0))

    def __init__(self, axis, point=(0, 0, 0), *, turns=None, radians=None):
        assert (turns is None) != (radians is None)
        self.turns, self.radians = (None if x is None else rational(x) for x in (turns, radians))
        h = vector(axis)
        if (self.turns or self.radians) < 0:
            h = scale(fmpq(-1), h)
            self.turns, self.radians = (None if x is None else -x for x in (self.turns, self.radians))
        self.h, self.o, self.hh = h, vector(point), dot(h, h)

    def total(self) -> arb:
        return 2 * arb.pi() * arb(self.turns) if self.turns is not None else arb(self.radians)

    def angle(self, t: Angle) -> arb:
        phi = arb.atan2(arb(self.hh).sqrt() * ball(t.s), ball(t.c))
        return phi + 2 * arb.pi() if t.half() == 1 and sign(t.s) < 0 else phi

    def nearest(self, t: Angle) -> float:
        return nearest_double(lambda: self.angle(t) / self.total())

    def enclosed(self, t: Angle, lo: float, hi: float) -> bool:
        """Whether lo <= t <= hi, as far as MAX_BITS can tell them apart."""

        def off(bound, side):
            return _sign_of_ball(lambda: side * (self.angle(t) / self.total() - arb(rational(bound)))) < 0

        return not off(lo, 1) and not off(hi, -1)

    def pose(self, t: Angle):
        return lambda p: add(self.turned(t, sub(p, self.o)), self.o)

    def turned(self, t: Angle, x):
        """x, taken from a point of the axis, after the turn."""
        along = scale(dot(x, self.h) / self.hh, self.h)
        return add(along, add(scale(t.c, sub(x, along)), scale(t.s, cross(self.h, x))))

    def compare(self, s: Angle, t: Angle) -> int:
        if s.half() != t.half():
            return s.half() - t.half()
        return -sign_of_cross(s.c, s.s, t.c, t.s)

    def within(self, t: Angle, limit) -> bool:
        """Whether the angle of t is at most `limit` (a rational part of the total; None: 1)."""
        part = rational(1 if limit is None else limit)
        if self.turns is not None:
            quarters = part * self.turns * 4
            if quarters >= 4:
                return True
            if quarters.denom() == 1 and (
                quarters.numer() % 2 == 0 or not isinstance(square_root(self.hh), Surd)
            ):
                return self.compare(t, self.quarter_turns(int(quarters.numer()))) <= 0
        return _sign_of_ball(lambda: self.total() * arb(part) - self.angle(t)) >= 0

    def quarter_turns(self, k: int) -> Angle:
        c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[k % 4]
        return Angle(fmpq(c), fmpq(0) if s == 0 else s / square_root(self.hh))

    def between(self, s: Angle, t, limit):
        """A rational pose strictly between s and t (t = None: the limit); None where the limit is at s."""
        part = rational(1 if limit is None else limit)
        for step in range(7):
            with ctx.workprec(64 << step):
                end = self.angle(t) if t is not None else self.limit_angle(part)
                weight = arb(7 + step) / 16  # the half-way point may be pi, where the tangent is infinite
                tau = ((self.angle(s) * weight + end * (1 - weight)) / 2).tan() / arb(self.hh).sqrt()
                if not tau.is_finite():
                    continue
                f = _dyadic(tau)
                found = self.half_tangent(fmpq(f.numerator, f.denominator))
                before_end = self.compare(found, t) < 0 if t is not None else end - self.angle(found) > 0
            if before_end and self.compare(s, found) < 0:
                return found
        return None

    def limit_angle(self, part) -> arb:
        whole = self.turns is not None and self.turns * part >= 1
        return 2 * arb.pi() if whole else self.total() * arb(part)

    def half_tangent(self, tau) -> Angle:
        """The pose with tan(phi/2) = tau |axis|."""
        w = 1 + self.hh * tau * tau
        return Angle((1 - self.hh * tau * tau) / w, 2 * tau / w)

    def solve(self, alpha, beta, gamma):
        """All angles with alpha c + beta s = gamma; [] also when alpha = beta = 0."""
        norm = alpha * alpha + beta * beta / self.hh
        if norm == 0:
            return []
        delta = (norm - gamma * gamma) / self.hh
        if delta < 0:
            return []
        r = square_root(delta)
        return [
            Angle((gamma * alpha - k * beta * r) / norm, (gamma * beta / self.hh + k * alpha * r) / norm)
            for k in ((1, -1) if delta != 0 else (1,))
        ]

    def heights_apart(self, moving, resting) -> bool:
        """Whether the two point sets share no height along the axis, which no turn changes."""
        low, high = ([dot(self.h, p) for p in points] for points in (moving, resting))
        return max(low) < min(high) or max(high) < min(low)

    def edge_edge(self, a, b, c, d):
        """Angles at which the two lines are coplanar, kept where the segments meet."""
        if self.heights_apart((a, b), (c, d)):
            return []
        a, b, c, d = (sub(x, self.o) for x in (a, b, c, d))
        e, f = sub(b, a), sub(d, c)
        m, k = cross(a, e), cross(c, f)
        e_along, m_along = (scale(dot(x, self.h) / self.hh, self.h) for x in (e, m))
        constant = dot(e_along, k) + dot(f, m_along)
        of_c = dot(sub(e, e_along), k) + dot(f, sub(m, m_along))
        of_s = dot(cross(self.h, e), k) + dot(f, cross(self.h, m))
        times = self.solve(of_c, of_s, -constant)
        return [t for t in times if segments_meet(self.turned(t, a), self.turned(t, b), c, d)]

    def vertex_edge(self, p, c, d):
        """Angles at which moving p is on cd; none for p on the axis, where nothing changes."""
        p, c, d = (sub(x, self.o) for x in (p, c, d))
        if self.squared_radius(p) == 0:
            return []
        return [self.carries(p, q) for q in self.points_at(c, d, p)]

    def edge_vertex(self, a, b, c):
        a, b, c = (sub(x, self.o) for x in (a, b, c))
        if self.squared_radius(c) == 0:
            return []
        return [self.carries(q, c) for q in self.points_at(a, b, c)]

    def squared_radius(self, p):
        return self.hh * dot(p, p) - dot(self.h, p) * dot(self.h, p)

    def carries(self, p, q) -> Angle:
        """The turn that takes p to q, equal in height and radius."""
        r = self.squared_radius(p)
        return Angle((self.hh * dot(p, q) - dot(self.h, p) * dot(self.h, q)) / r, det(self.h, p, q) / r)

    def points_at(self, c, d, p):
        """Points of the segment cd with the height and the radius of p."""
        f = sub(d, c)
        rise, height, radius = dot(self.h, f), dot(self.h, sub(p, c)), self.squared_radius(p)
        if rise != 0:
            mus = [height / rise]
        elif height != 0:
            return []
        else:
            mus = self.quadratic(
                self.squared_radius(f),
                2 * (self.hh * dot(c, f) - dot(self.h, c) * dot(self.h, f)),
                self.squared_radius(c) - radius,
            )
        found = [add(c, scale(mu, f)) for mu in mus if sign(mu) >= 0 and sign(1 - mu) >= 0]
        return [q for q in found if sign(self.squared_radius(q) - radius) == 0]

    @staticmethod
    def quadratic(a, b, c):
        """Roots of a mu^2 + b mu + c; a segment of no length is looked at in mu = 0."""
        delta = b * b - 4 * a * c
        if a == 0:
            return [fmpq(0)]
        if delta < 0:
            return []
        r = square_root(delta)
        return [(-b + r) / (2 * a), (-b - r) / (2 * a)]

    def vertex_face(self, p, triangle):
        """Angles at which moving p is in the plane of the triangle, kept where it is in the triangle."""
        if self.heights_apart((p,), triangle):
            return []
        normal = plane_normal(triangle)
        x, first = sub(p, self.o), sub(triangle[0], self.o)
        along = scale(dot(x, self.h) / self.hh, self.h)
        alpha, beta = dot(normal, sub(x, along)), dot(normal, cross(self.h, x))
        times = self.solve(alpha, beta, dot(normal, sub(first, along)))
        return [t for t in times if in_triangle(self.pose(t)(p), triangle, normal)]

    def reversed(self):
        return Turn(scale(fmpq(-1), self.h), self.o, turns=self.turns, radians=self.radians)


def _sign_of_ball(enclosure) -> int:
    """Sign of a real number given by enclosures, 0 when MAX_BITS cannot tell it from 0."""
    bits = 64
    while bits <= MAX_BITS:
        with ctx.workprec(bits):
            x = enclosure()
            if x > 0 or x < 0:
                return 1 if x > 0 else -1
        bits *= 2
    return 0


# ---------------------------------------------------------------------------------------------------- verbs


def meeting_times(a: Shape, b: Shape, motion):
    """Times, in no order, at which some vertex or edge pair of moving a and resting b meets for the first or
    the last time.  All ends of the surfaces' contact intervals inside the span are among them."""
    for ab, cd in product(a.segments, b.segments):
        yield from motion.edge_edge(*ab, *cd)
    for p, cd in product(_ends(a), b.segments):
        yield from motion.vertex_edge(p, *cd)
    for ab, p in product(a.segments, _ends(b)):
        yield from _edge_vertex(motion, *ab, p)
    for p, triangle in product(_ends(a), b.triangles):
        yield from motion.vertex_face(p, triangle)
    for triangle, p in product(a.triangles, _ends(b)):
        yield from _face_vertex(motion, triangle, p)


def _ends(body: Shape):
    return [body.points[i] for i in sorted({i for edge in body.edges for i in edge})]


def _edge_vertex(motion, a, b, p):
    if isinstance(motion, Turn):
        return motion.edge_vertex(a, b, p)
    return motion.reversed().vertex_edge(p, a, b)


def _face_vertex(motion, triangle, p):
    """Seen from the face the vertex makes the reversed motion, by the same parameter."""
    return motion.reversed().vertex_face(p, triangle)


def first_contact(va, ea, fa, vb, eb, fb, motion, until=None, solid_a=False, solid_b=False):
    """(status, exact time or None, nearest double or None) of moving a against resting b over [0, until]."""
    a, b = shape(va, ea, fa, solid_a), shape(vb, eb, fb, solid_b)
    if bodies_meet(a, b):
        return INITIAL, motion.zero, 0.0
    best = None
    for t in meeting_times(a, b, motion):
        if (best is None or motion.compare(t, best) < 0) and motion.within(t, until):
            best = t
    return (FREE, None, None) if best is None else (CONTACT, best, motion.nearest(best))


def contact_intervals(va, ea, fa, vb, eb, fb, motion, until=None, solid_a=False, solid_b=False):
    """[(start, end)]: all closed times of contact in [0, until], exact; None means the end of the span."""
    a, b = shape(va, ea, fa, solid_a), shape(vb, eb, fb, solid_b)
    times = sorted(
        (t for t in meeting_times(a, b, motion) if motion.within(t, until)), key=cmp_to_key(motion.compare)
    )
    starts = bodies_meet(a, b)
    if not times or motion.compare(times[0], motion.zero) > 0:
        times.insert(0, motion.zero)
    steps = times[:1] + [t for s, t in zip(times, times[1:], strict=False) if motion.compare(s, t) < 0]
    found: list[list] = []
    for t, following in zip(steps, [*steps[1:], None], strict=True):
        goes_on = bool(found) and found[-1][1] is t
        # Every step is a time of contact, but for a start that is free.
        if not goes_on and (starts or t is not steps[0]):
            found.append([t, t])
        middle = motion.between(t, following, until)
        if middle is not None and bodies_meet(a.moved(motion.pose(middle)), b):
            found[-1][1] = following
    return _with_end_of_turn(found, motion, until)


def _with_end_of_turn(found, motion, until):
    """A full turn ends in the pose it starts from."""
    if (
        isinstance(motion, Turn)
        and motion.turns is not None
        and motion.turns * rational(1 if until is None else until) == 1
    ):
        if found and motion.compare(found[0][0], motion.zero) == 0 and found[-1][1] is not None:
            found.append([None, None])
    return [tuple(pair) for pair in found]


def meeting_pairs(va, ea, fa, vb, eb, fb, motion, until=None) -> set[tuple]:
    """(kind, index, kind, index) of all edge/edge, vertex/face and face/vertex pairs that meet in [0, until].

    Edges count in the order of `Shape.edges`.
    """
    a, b = shape(va, ea, fa), shape(vb, eb, fb)

    def met(times) -> bool:
        return any(motion.within(t, until) for t in times)

    pairs = set()
    for (i, (p, q)), (j, (r, s)) in product(enumerate(a.segments), enumerate(b.segments)):
        touches = segments_meet(p, q, r, s) or met(motion.edge_edge(p, q, r, s))
        touches = touches or any(met(motion.vertex_edge(x, r, s)) for x in (p, q))
        if touches or any(met(_edge_vertex(motion, p, q, x)) for x in (r, s)):
            pairs.add(("edge", i, "edge", j))
    for (i, p), (j, triangle) in product(enumerate(a.points), enumerate(b.triangles)):
        touches = segment_meets_triangle(p, p, triangle) or met(motion.vertex_face(p, triangle))
        if touches or any(met(motion.vertex_edge(p, x, y)) for x, y in combinations(triangle, 2)):
            pairs.add(("vertex", i, "face", j))
    for (i, triangle), (j, p) in product(enumerate(a.triangles), enumerate(b.points)):
        touches = segment_meets_triangle(p, p, triangle) or met(_face_vertex(motion, triangle, p))
        if touches or any(met(_edge_vertex(motion, x, y, p)) for x, y in combinations(triangle, 2)):
            pairs.add(("face", i, "vertex", j))
    return pairs
