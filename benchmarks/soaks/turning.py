"""Exact first contacts and contact intervals of polyhedra about one axis, by brute force over all pairs of features.

With C = cos(angle) and S = sin(angle) / |axis| a rotated point is rational in C and S, which lie on the ellipse
C^2 + N S^2 = 1, N = |axis|^2.  Each pair (vertex, plane) or (edge, edge) meets where A + B C + G S = 0, so C and S lie
in Q(sqrt(E)) with E = N B^2 + G^2 - N A^2, and everything about such a pose is decided by signs of p + q sqrt(E).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction as F
from itertools import product
from typing import Any

from flint import arb, ctx

from .brute import Mesh, Point, contained, cross, dot, minus, plus, share, start_of, times, touch, whole

DIGITS = 400
"""Bits of angles; two that agree in 300 of them are taken for equal."""
NEAR = F(1, 2**300)


class Surd:
    """p + q sqrt(e), e a positive integer, the same for all that meet."""

    __slots__ = ("p", "q", "e")

    def __init__(self, p: Any, q: Any, e: int) -> None:
        self.p, self.q, self.e = p, q, e

    def _other(self, x: Any) -> tuple[Any, Any]:
        return (x.p, x.q) if isinstance(x, Surd) else (x, 0)

    def __add__(self, x: Any) -> Surd:
        p, q = self._other(x)
        return Surd(self.p + p, self.q + q, self.e)

    __radd__ = __add__

    def __neg__(self) -> Surd:
        return Surd(-self.p, -self.q, self.e)

    def __sub__(self, x: Any) -> Surd:
        p, q = self._other(x)
        return Surd(self.p - p, self.q - q, self.e)

    def __rsub__(self, x: Any) -> Surd:
        return -(self - x)

    def __mul__(self, x: Any) -> Surd:
        p, q = self._other(x)
        return Surd(self.p * p + self.q * q * self.e, self.p * q + self.q * p, self.e)

    __rmul__ = __mul__

    def sign(self) -> int:
        one, two = (self.p > 0) - (self.p < 0), (self.q > 0) - (self.q < 0)
        if two == 0 or self.e == 0:
            return one
        if one == 0 or one == two:
            return two
        squares = self.p * self.p - self.q * self.q * self.e
        return 0 if squares == 0 else one if squares > 0 else two

    def __eq__(self, x: object) -> bool:
        return (self - x).sign() == 0

    def __hash__(self) -> int:
        return hash((self.p, self.q))

    def __lt__(self, x: Any) -> bool:
        return (self - x).sign() < 0

    def __le__(self, x: Any) -> bool:
        return (self - x).sign() <= 0

    def __gt__(self, x: Any) -> bool:
        return (self - x).sign() > 0

    def __ge__(self, x: Any) -> bool:
        return (self - x).sign() >= 0


@dataclass(frozen=True)
class Speed:
    """How far a body turns in a unit of time: rational in turns, or in radians."""

    rate: F
    unit: str

    def turns(self) -> F:
        """To DIGITS bits where not exact."""
        return self.rate if self.unit == "turns" else self.rate / _two_pi()


def _fraction(x: Any) -> F:
    mantissa, exponent = x.mid().man_exp()
    return F(int(mantissa)) * F(2) ** int(exponent)


def _arb(x: F) -> Any:
    return arb(int(x.numerator)) / arb(int(x.denominator))


def _two_pi() -> F:
    with ctx.workprec(DIGITS):
        return _fraction(2 * arb.pi())


@dataclass(frozen=True)
class Axis:
    """Direction of integers and a point of it."""

    way: tuple[int, int, int]
    point: Point

    @property
    def square(self) -> int:
        return int(dot(self.way, self.way))

    def turned(self, p: Point, c: Any, s: Any) -> Point:
        """p turned to C = c, S = s."""
        y = minus(p, self.point)
        along = times(F(dot(self.way, y), self.square), self.way)
        return plus(self.point, plus(along, plus(times(c, minus(y, along)), times(s, cross(self.way, y)))))

    def near(self, turns: F) -> tuple[F, F]:
        """C and S of an angle, to DIGITS bits, exact for rational ones."""
        exact = self.exact(turns)
        if exact is not None and not isinstance(exact[0], Surd) and not isinstance(exact[1], Surd):
            return exact
        with ctx.workprec(DIGITS):
            angle = 2 * arb.pi() * _arb(turns)
            return _fraction(angle.cos()), _fraction(angle.sin() / arb(self.square).sqrt())

    def exact(self, turns: F) -> tuple[Any, Any] | None:
        """C and S of an angle that is a part of a turn with one square root; None for others."""
        turns -= math.floor(turns)
        root = math.isqrt(self.square)
        if turns.denominator <= 2:
            return (F(1) if turns == 0 else F(-1)), F(0)
        half = F(1, 2)
        third = math.isqrt(self.square // 3)
        if 3 * third * third == self.square and turns.denominator in (3, 6):
            # sin = +-sqrt(3) / 2
            root = third
            return (half if turns.denominator == 6 else -half), F(1 if turns < half else -1, 2 * root)
        if root * root != self.square:
            return None
        if turns.denominator == 4:
            return F(0), F(1 if turns < half else -1, root)
        if turns.denominator == 8:
            k = int(turns * 8)
            return Surd(0, half * (1 if k in (1, 7) else -1), 2), Surd(0, F(1 if k < 4 else -1, 2 * root), 2)
        if turns.denominator in (3, 6):
            cosine = half if turns.denominator == 6 else -half
            return Surd(cosine, 0, 3), Surd(0, F(1 if turns < half else -1, 2 * root), 3)
        if turns.denominator == 12:
            k = int(turns * 12)
            return Surd(0, half * (1 if k in (1, 11) else -1), 3), Surd(F(1 if k < 6 else -1, 2 * root), 0, 3)
        return None


def posed(body: Mesh, axis: Axis, c: Any, s: Any) -> Mesh:
    return body.mapped(lambda p: axis.turned(p, c, s))


def turned(body: Mesh, axis: Axis, turns: F) -> Mesh:
    """The body in a pose of DIGITS bits, exact where the pose is rational."""
    return posed(body, axis, *axis.near(turns))


# ---- events ----


@dataclass(frozen=True)
class Event:
    """An angle in [0, 1) turns at which two features share a point."""

    turns: F
    exact: bool


Forms = tuple[Point, Point, Point]
"""U, V, W of a turned vector: (U + C V + S W) / N."""


class Turning:
    """All events of a, turned about an axis, and b at rest."""

    def __init__(self, a: Mesh, b: Mesh, axis: Axis) -> None:
        self.a, self.b, self.axis = a, b, axis
        self.N = axis.square
        moved_a = [minus(p, axis.point) for p in a.vertices]
        moved_b = [minus(p, axis.point) for p in b.vertices]
        _, places = whole(*moved_a, *moved_b)
        self.first, self.second = places[: len(moved_a)], places[len(moved_a) :]
        self.size = max((abs(x) for p in places for x in p), default=1) or 1
        self.turned_first = [self._forms(p) for p in self.first]

    def _forms(self, y: Point) -> Forms:
        n, N = self.axis.way, self.N
        along = times(dot(n, y), n)
        return along, minus(times(N, y), along), times(N, cross(n, y))

    def equations(self) -> Iterator[tuple[int, int, int, tuple[int, ...], tuple[int, ...]]]:
        """(A, B, G, feature of a, feature of b), features as vertex numbers."""
        a, b, N = self.a, self.b, self.N
        ours, theirs = _features(a), _features(b)
        flat = any(len(p) < 3 for p in (*a.pieces, *b.pieces))
        planes = [(t, cross(minus(self.second[t[1]], self.second[t[0]]), minus(self.second[t[2]], self.second[t[0]])))
                  for t in theirs[3]]
        for (i,), (t, m) in product(ours[1], planes):
            U, V, W = self.turned_first[i]
            A, B, G = dot(m, U) - N * dot(m, self.second[t[0]]), dot(m, V), dot(m, W)
            flat = flat or A == B == G == 0
            yield A, B, G, (i,), t
        back = [self._forms(p) for p in self.second]
        planes = [(t, cross(minus(self.first[t[1]], self.first[t[0]]), minus(self.first[t[2]], self.first[t[0]])))
                  for t in ours[3]]
        for (j,), (t, m) in product(theirs[1], planes):
            U, V, W = back[j]
            A, B, G = dot(m, U) - N * dot(m, self.first[t[0]]), dot(m, V), -dot(m, W)
            flat = flat or A == B == G == 0
            yield A, B, G, t, (j,)
        lines = []
        for i, j in ours[2]:
            p, q = self.first[i], self.first[j]
            lines.append(((i, j), self._forms(minus(q, p)), self._forms(cross(p, q))))
        others = [((i, j), minus(self.second[j], self.second[i]), cross(self.second[i], self.second[j]))
                  for i, j in theirs[2]]
        for (e, d, m), (f, k, h) in product(lines, others):
            A, B, G = (dot(h, d[n]) + dot(k, m[n]) for n in range(3))
            flat = flat or A == B == G == 0
            yield A, B, G, e, f
        if not flat:
            return
        for (i,), (f, k, h) in product(ours[1], others):
            forms = self.turned_first[i]
            # x on the line: x cross direction = moment
            rows = [cross(forms[n], k) for n in range(3)]
            for c in range(3):
                yield rows[0][c] - N * h[c], rows[1][c], rows[2][c], (i,), f
        for (e, _, _), (j,) in product(lines, theirs[1]):
            p, q = self.first[e[0]], self.first[e[1]]
            k, h = minus(q, p), cross(p, q)
            rows = [cross(form, k) for form in back[j]]
            for c in range(3):
                yield rows[0][c] - N * h[c], rows[1][c], -rows[2][c], e, (j,)
        for (i,), (j,) in product(ours[1], theirs[1]):
            for c in range(3):
                U, V, W = (form[c] for form in self.turned_first[i])
                yield U - N * self.second[j][c], V, W, (i,), (j,)

    def candidates(self) -> list[tuple[float, tuple[int, ...], tuple[int, ...], tuple[int, ...]]]:
        """(turns in [0, 1), root as (c0, c1, s0, s1, K, E), feature, feature), by angle; floats drop far ones."""
        N, scale = self.N, self.size
        small = [tuple(tuple(x / (scale * N) for x in v) for v in forms) for forms in self.turned_first]
        rest = [tuple(x / scale for x in p) for p in self.second]
        found = []
        for A, B, G, e, f in self.equations():
            K = N * B * B + G * G
            if K == 0:
                continue
            E = K - N * A * A
            if E < 0:
                continue
            r = math.sqrt(E / K)
            mean_c = -_root_of(A * B * N, A * A * B * B * N * N, K * K)
            mean_s = -_root_of(A * G, A * A * G * G * N, K * K)
            part_c, part_s = _root_of(G, G * G, K), _root_of(B, N * B * B, K)
            for sigma in (1, -1) if E else (1,):
                c, s = mean_c - sigma * part_c * r, mean_s + sigma * part_s * r
                S = s / math.sqrt(N)
                x = [[u[k] + c * v[k] + S * w[k] for k in range(3)] for u, v, w in (small[i] for i in e)]
                y = [rest[j] for j in f]
                if _far(x, y):
                    continue
                turns = math.atan2(s, c) / (2 * math.pi) % 1.0
                root = (-N * A * B, -sigma * G, -A * G, sigma * B, K, E)
                found.append((turns, root, e, f))
        found.sort(key=lambda item: item[0])
        return found

    def verified(self, root: tuple[int, ...], e: tuple[int, ...], f: tuple[int, ...]) -> bool:
        """Whether the two features share a point in that pose."""
        c0, c1, s0, s1, K, E = root
        k = math.isqrt(E)
        x: list[Any] = []
        for i in e:
            U, V, W = self.turned_first[i]
            fixed = [K * U[n] + c0 * V[n] + s0 * W[n] for n in range(3)]
            bent = [c1 * V[n] + s1 * W[n] for n in range(3)]
            if k * k == E:
                x.append(tuple(p + k * q for p, q in zip(fixed, bent, strict=True)))
            else:
                x.append(tuple(Surd(p, q, E) for p, q in zip(fixed, bent, strict=True)))
        y = [times(K * self.N, self.second[j]) for j in f]
        return share(x, y)

    def event(self, root: tuple[int, ...]) -> Event:
        c0, c1, s0, s1, K, E = root
        cosine, sine = Surd(c0, c1, E).sign(), Surd(s0, s1, E).sign()
        if sine == 0 or cosine == 0:
            return Event(F(1 - cosine, 4) if sine == 0 else F(2 - sine, 4), True)
        # no more is lost where the two parts cancel than they are long
        with ctx.workprec(DIGITS + 2 * max(x.bit_length() for x in root)):
            e = arb(E).sqrt()
            sine = (arb(s0) + arb(s1) * e) * arb(self.N).sqrt()
            turns = _fraction(arb.atan2(sine, arb(c0) + arb(c1) * e) / (2 * arb.pi()))
        for parts in (24, 5):
            nearest = F(round(turns * parts), parts)
            if abs(turns - nearest) < NEAR:
                return Event(nearest % 1, True)
        return Event(turns % 1, False)

    def within(self, start: F, end: F, all_: bool = False) -> list[tuple[F, bool]]:
        """Angles in (start, end] turns of verified events, ascending: the first, or all of them."""
        found: list[tuple[F, bool]] = []
        rounds = range(math.floor(start) - 1, math.ceil(end) + 1)
        waiting = sorted(
            ((turns + n, root, e, f) for turns, root, e, f in self.candidates() for n in rounds
             if start - F(1, 10**9) <= turns + n <= end + F(1, 10**9)),
            key=lambda item: item[0],
        )
        known: dict[tuple[int, ...], bool] = {}
        for turns, root, e, f in waiting:
            if found and not all_ and turns > float(found[0][0]) + 1e-9:
                break
            key = (*root, *e, -1, *f)
            if key not in known:
                known[key] = self.verified(root, e, f)
            if not known[key]:
                continue
            event = self.event(root)
            at = event.turns + round(F(turns) - event.turns)
            if start < at <= end and not any(abs(at - other) < NEAR for other, _ in found):
                found.append((at, event.exact))
        found.sort()
        return found


def _features(body: Mesh) -> dict[int, list[tuple[int, ...]]]:
    corners = {i for piece in body.pieces for i in piece}
    edges = {(min(i, j), max(i, j)) for piece in body.pieces for i in piece for j in piece if i != j}
    return {1: sorted((i,) for i in corners), 2: sorted(edges), 3: [p for p in body.pieces if len(p) == 3]}


def _far(x: Sequence[Sequence[float]], y: Sequence[Sequence[float]]) -> bool:
    """Whether the boxes are apart by more than rounding; coordinates are below 1 or so."""
    for k in range(3):
        p, q = [point[k] for point in x], [point[k] for point in y]
        if min(p) > max(q) + 1e-6 or min(q) > max(p) + 1e-6:
            return True
    return False


def _root_of(sign: int, top: int, bottom: int) -> float:
    """sign * sqrt(top / bottom), for integers of any size."""
    return math.copysign(math.sqrt(top / bottom), sign) if sign else 0.0


# ---- answers ----


@dataclass(frozen=True)
class Turn:
    """First contact in time: exact or to some 300 bits."""

    time: F | None
    exact: bool
    initial: str | None


def first_contact(a: Mesh, b: Mesh, axis: Axis, speed: Speed, first: F, last: F) -> Turn | None:
    """a turns about the axis with `speed` from its pose at 0, b rests; None where the start is not decided here."""
    rate = speed.turns()
    if rate < 0:
        axis, rate = Axis(tuple(-x for x in axis.way), axis.point), -rate  # type: ignore[arg-type]
    start, end = rate * first, rate * last
    pose = axis.exact(start) if speed.unit == "turns" or first == 0 else None
    if pose is None:
        return None
    initial = start_of(posed(a, axis, *pose), b)
    if initial:
        return Turn(first, True, initial)
    if rate == 0:
        return Turn(None, True, None)
    found = Turning(a, b, axis).within(start, end)
    if not found:
        return Turn(None, True, None)
    at, exact = found[0]
    return Turn(at / rate, exact and speed.unit == "turns", None)


def contact_times(a: Mesh, b: Mesh, axis: Axis, speed: Speed, first: F, last: F) -> list[tuple[F, F]] | None:
    """All closed intervals of contact, their ends to some 300 bits; None where the start is not decided here."""
    rate = speed.turns()
    if rate < 0:
        axis, rate = Axis(tuple(-x for x in axis.way), axis.point), -rate  # type: ignore[arg-type]
    start, end = rate * first, rate * last
    pose = axis.exact(start) if speed.unit == "turns" or first == 0 else None
    if pose is None or rate == 0:
        return None
    marks = [start, *(at for at, _ in Turning(a, b, axis).within(start, end, all_=True))]
    points = [(start, start_of(posed(a, axis, *pose), b) is not None), *((at, True) for at in marks[1:])]
    joined: list[list[F]] = []

    def add(lo: F, hi: F) -> None:
        if joined and lo <= joined[-1][1]:
            joined[-1][1] = max(joined[-1][1], hi)
        else:
            joined.append([lo, hi])

    for n, (at, meets) in enumerate(points):
        if meets:
            add(at, at)
        following = points[n + 1][0] if n + 1 < len(points) else end
        if at < following:
            here = posed(a, axis, *_between(axis.square, at, following))
            if touch(here, b) or contained(here, b):
                add(at, following)
    return [(lo / rate, hi / rate) for lo, hi in joined]


def _between(N: int, lo: F, hi: F) -> tuple[F, F]:
    """Rational C and S of an angle within (lo, hi) turns, that of a half turn excepted."""
    middle = lo + (hi - lo) * F(11, 23)
    if middle.denominator == 2:
        middle = lo + (hi - lo) * F(10, 23)
    reach = (hi - lo) / 8
    with ctx.workprec(DIGITS):
        u = _fraction((arb.pi() * _arb(middle)).tan() / arb(N).sqrt())
    u = u.limit_denominator(max(100, int(100 * (1 + u * u) / reach)))
    return (1 - N * u * u) / (1 + N * u * u), 2 * u / (1 + N * u * u)
