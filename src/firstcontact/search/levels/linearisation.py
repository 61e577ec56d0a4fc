"""When does a moving edge meet an edge at rest?  The answer as linear inequalities in vectors of the latter.

Schoemer & Thiel 1995, sections 4 and 5: for a moving edge ab and a time t, the edges cd that ab meets in [0, t] are
those that satisfy one of a few conjunctions of conjuncts  delta . zeta(cd) >= 0  (or > 0), where delta depends on ab
and t only and zeta on cd only.  That is what makes range searching apply, and what lifted trees prune with.

The same formulas run on rational numbers (exact) and on arrays of doubles with error bounds (`Bounded`), many
edges cd at once.  Strict conjuncts make the conjunctions disjoint: a contact satisfies exactly one, so they
also count.  Translation: 2 conjunctions of 7 conjuncts.  Rotation about the z axis by an angle below pi: 2 labels x 3
ways for the time x 3 for the height x 4 for the common range of heights = 72 conjunctions of at most 12.

Not covered are pairs in which the equations degenerate (`is_degenerate`): the pair tests decide those.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
from flint import fmpq

from firstcontact.exact.numbers import fraction, sign
from firstcontact.exact.times.instants import AngleInstant
from firstcontact.exact.times.turning import Axis
from firstcontact.exact.vectors import Vector, cross, dot, sub
from firstcontact.kernels import running
from firstcontact.pairs.elements import line_line, line_line_rotation

if TYPE_CHECKING:
    from firstcontact.exact.ring import N, Number, VectorOf


Floats = float | np.ndarray
"""Several numbers at once, or one."""


class Bounded:
    """Arrays of doubles with bounds on their errors (`kernels.running`); numbers without error mix freely."""

    __slots__ = ("error", "value")
    value: Any
    error: Any
    __array_ufunc__ = None  # arrays do not try to take this apart

    def __init__(self, value: Floats, error: Floats = 0.0) -> None:
        self.value, self.error = value, error

    def __add__(self, other: Bounded | Floats) -> Bounded:
        return Bounded(*running.add.py_func(self.value, self.error, *_both(other)))

    def __sub__(self, other: Bounded | Floats) -> Bounded:
        return Bounded(*running.sub.py_func(self.value, self.error, *_both(other)))

    def __mul__(self, other: Bounded | Floats) -> Bounded:
        return Bounded(*running.mul.py_func(self.value, self.error, *_both(other)))

    def __rsub__(self, other: Floats) -> Bounded:
        return -self + other

    def __neg__(self) -> Bounded:
        return Bounded(-self.value, self.error)

    __radd__, __rmul__ = __add__, __mul__

    def signs(self) -> tuple[Floats, Floats]:
        """(signs, whether they are certain); a zero without error is certain."""
        return np.sign(self.value), (abs(self.value) > self.error) | ((self.value == 0) & (self.error == 0))


def _both(x: Bounded | Floats) -> tuple[Floats, Floats]:
    return (x.value, x.error) if isinstance(x, Bounded) else (x, 0.0)


P = TypeVar("P", np.ndarray, tuple[Any, Any, Any])
"""A point, in doubles or exactly."""


class Form(NamedTuple):
    """The linear form delta . zeta; `feature` names the vector zeta of the edge at rest."""

    feature: str
    delta: tuple[Any, ...]

    def of(self, features: Features) -> Any:
        first, *rest = (d * z for d, z in zip(self.delta, features[self.feature], strict=True))
        return sum(rest, first)


class Conjunct(NamedTuple):
    """way * form >= 0, or > 0 if strict; way is 1 or -1."""

    form: Form
    way: int
    strict: bool = False


Conjunction = tuple[Conjunct, ...]
Features = dict[str, tuple[Any, ...]]


def _scaled(k: int, x: Sequence[N]) -> tuple[N, ...]:
    return tuple(k * c for c in x)


# ---------------------------------------------------------------------------------------------- translation


def translation_features(c: Vector, d: Vector) -> Features:
    """line (f; k) with f = d - c, k = c x f; the end points with a one."""
    f = sub(d, c)
    return {"line": (*f, *cross(c, f)), "start": (*c, 1), "end": (*d, 1)}


def translation_conjunctions(a: Vector, b: Vector, v: Vector, last: Number) -> tuple[Conjunction, ...]:
    """The edges cd that ab, moving by t v, meets at a time in [0, last], unless v.((b - a) x (d - c)) = 0.

    u0 + t u1 is the product of the lines of cd and of ab at the time t; D = u1.
    """
    e = sub(b, a)
    m, turned = cross(a, e), cross(v, e)
    later = tuple(x + last * y for x, y in zip(m, turned, strict=True))
    zero = e[0] - e[0]
    side = cross(e, v)
    forms = (
        Form("line", (*turned, zero, zero, zero)),  # D
        Form("line", (*_scaled(-1, m), *_scaled(-1, e))),  # -u0: not before 0
        Form("line", (*later, *e)),  # u0 + last u1: not after last
        Form("line", (*_scaled(-1, cross(v, a)), *v)),  # where on ab: behind a
        Form("line", (*cross(v, b), *_scaled(-1, v))),  # before b
        Form("start", (*side, -dot(v, m))),  # where on cd: behind c
        Form("end", (*_scaled(-1, side), dot(v, m))),  # before d
    )
    return tuple(tuple(Conjunct(form, way, form is forms[0]) for form in forms) for way in (1, -1))


# ------------------------------------------------------------------------------------------------- rotation


def rotation_features(c: Vector, d: Vector) -> Features:
    """Of an edge that rises, c below d.  Multiplied by f3^2 > 0 where the derivation divides by it."""
    f = sub(d, c)
    k = cross(c, f)
    w2, w1, w0, ff = *_squared_radius(f, k), f[2] * f[2]
    radius_c, radius_d = c[0] * c[0] + c[1] * c[1], d[0] * d[0] + d[1] * d[1]
    return {
        "line": (*f, *k),
        "discriminant": (k[0] * k[0] + k[1] * k[1], f[0] * f[0] + f[1] * f[1], f[1] * k[0] - f[0] * k[1],
                         k[2] * k[2], ff),  # fmt: skip
        "at c": (c[2] * c[2], c[2], 1, radius_c),
        "at d": (d[2] * d[2], d[2], 1, radius_d),
        "slope at c": (c[2] * ff, ff, 2 * c[2] * w2 + w1),
        "slope at d": (d[2] * ff, ff, 2 * d[2] * w2 + w1),
        "squares": (w2, w1, w0, ff),
        "c": (c[2], 1),
        "d": (d[2], 1),
    }  # fmt: skip


def _squared_radius(e: VectorOf[N], m: VectorOf[N]) -> VectorOf[N]:
    """(v2, v1, v0): the squared radius of a rising line (e; m) at the height z is (v2 z^2 + v1 z + v0) / e3^2."""
    return (e[0] * e[0] + e[1] * e[1], 2 * (e[1] * m[0] - e[0] * m[1]), m[0] * m[0] + m[1] * m[1])


def rotation_conjunctions(a: Vector, b: Vector, tangent: Number) -> tuple[Conjunction, ...]:
    """The rising edges cd that the rising edge ab, turning about +z, meets within the angle 2 atan(tangent) < pi.

    Only pairs that share more than one height.
    """
    e = sub(b, a)
    m, ee, t = cross(a, e), e[2] * e[2], tangent
    v2, v1, v0 = _squared_radius(e, m)
    zero = e[2] - e[2]
    # forms in the line: g(0), g'(0) and (1 + t^2) g at the end of the turn, g the product of the lines
    still, pace = (*m, *e), (-m[1], m[0], zero, -e[1], e[0], zero)
    c, s = 1 - t * t, 2 * t
    end = tuple(
        x for y in (m, e) for x in (c * y[0] - s * y[1], s * y[0] + c * y[1], (1 + t * t) * y[2])
    )  # fmt: skip
    # p = (1 + tau^2) g has p(0) = g(0), p'(0) = 2 g'(0), t p'(t) = 2 p(t) - 2 p(0) - t p'(0), being a quadratic
    slope = tuple(2 * x - 2 * y - 2 * t * z for x, y, z in zip(end, still, pace, strict=True))
    time = Form("line", still), Form("line", _scaled(2, pace)), Form("line", end), Form("line", slope)
    discriminant = Form("discriminant", (v2, v0, -2 * (e[1] * m[0] - e[0] * m[1]), -ee, -(m[2] * m[2])))
    # squared radius of ab less that of cd, at a height Z, and its slope there; times e3^2 (or f3^2, or both)
    at = {
        "c": (Form("at c", (v2, v1, v0, -ee)), Form("slope at c", (2 * v2, v1, -ee))),
        "d": (Form("at d", (v2, v1, v0, -ee)), Form("slope at d", (2 * v2, v1, -ee))),
    }
    for name, z in (("a", a), ("b", b)):
        radius, growth = z[0] * z[0] + z[1] * z[1], 2 * z[2] * v2 + v1
        at[name] = (
            Form("squares", (-z[2] * z[2], -z[2], zero - 1, radius)),
            Form("squares", (-2 * z[2] * ee, -ee, zero, growth)),
        )
    above = {(x, y): Form(x, (zero + 1, -p[2])) for x in "cd" for y, p in (("a", a), ("b", b))}  # x over y
    overlap = Conjunct(above["d", "a"], 1, True), Conjunct(above["c", "b"], -1, True)
    found = []
    for lo, higher in (("a", Conjunct(above["c", "a"], -1)), ("c", Conjunct(above["c", "a"], 1, True))):
        for hi, lower in (("b", Conjunct(above["d", "b"], 1)), ("d", Conjunct(above["d", "b"], -1, True))):
            for label in (1, -1):
                # at a contact of rising edges the product of lines rises where the difference of radii falls; of a
                # double root only one label counts
                real = Conjunct(discriminant, 1, label < 0)
                for when in _root(-label, *time):
                    for where in _root(label, *at[lo], *at[hi]):
                        found.append((higher, lower, *overlap, real, *when, *where))
    return tuple(found)


def _root(way: int, lo: Form, slope_lo: Form, hi: Form, slope_hi: Form) -> Iterator[Conjunction]:
    """The root at which a quadratic has slopes of sign `way` lies between two points: its values and slopes there.

    lo < hi: a single point that is a root has one label, but satisfies the first line for both.
    """
    yield Conjunct(lo, -way), Conjunct(hi, way)
    yield Conjunct(lo, way, True), Conjunct(hi, way), Conjunct(slope_lo, -way, True), Conjunct(slope_hi, way)
    yield Conjunct(lo, -way), Conjunct(hi, -way, True), Conjunct(slope_lo, way), Conjunct(slope_hi, -way, True)


# ------------------------------------------------------------------------------------------------- queries


@dataclass(slots=True)
class Translated:
    """Which of many edges at rest does an edge meet that moves by t v, 0 <= t <= last?"""

    v: Vector
    last: fmpq

    features = staticmethod(translation_features)

    def conjunctions(self, a: Vector, b: Vector, v: Vector, last: Number) -> tuple[Conjunction, ...]:
        return translation_conjunctions(a, b, v, last)

    def parameters(self) -> tuple[Vector, fmpq]:
        return self.v, self.last

    def oriented(self, c: P, d: P) -> tuple[P, P]:
        return c, d

    def is_degenerate(self, a: Vector, b: Vector, c: Vector, d: Vector) -> bool:
        return sign(dot(self.v, cross(sub(b, a), sub(d, c)))) == 0

    def contacts(self, a: Vector, b: Vector, c: Vector, d: Vector) -> int:
        """The number of contacts by the pair test; 1 where they last."""
        window = line_line.translation_window(a, b, c, d, self.v)
        if window is None:
            return 0
        begin, end = window
        return int((end is None or sign(end) >= 0) and (begin is None or sign(self.last - begin) >= 0))


@dataclass(slots=True)
class Turned:
    """The same for an edge that turns about +z by the angles up to 2 atan(tangent), 0 < tangent."""

    tangent: fmpq

    features = staticmethod(rotation_features)

    def conjunctions(self, a: Vector, b: Vector, tangent: Number) -> tuple[Conjunction, ...]:
        return rotation_conjunctions(a, b, tangent)

    def parameters(self) -> tuple[fmpq]:
        return (self.tangent,)

    def oriented(self, c: P, d: P) -> tuple[P, P]:
        """The lower end first."""
        return (d, c) if c[2] > d[2] else (c, d)

    def is_degenerate(self, a: Vector, b: Vector, c: Vector, d: Vector) -> bool:
        """Edges across the axis, edges that share one height only, and lines on one surface of revolution."""
        e, f = sub(b, a), sub(d, c)
        if sign(e[2]) == 0 or sign(f[2]) == 0:
            return True
        if max(min(a[2], b[2]), min(c[2], d[2])) == min(max(a[2], b[2]), max(c[2], d[2])):
            return True
        ours, theirs = _squared_radius(e, cross(a, e)), _squared_radius(f, cross(c, f))
        ee, ff = e[2] * e[2], f[2] * f[2]
        return all(sign(x * ff - y * ee) == 0 for x, y in zip(ours, theirs, strict=True))

    def contacts(self, a: Vector, b: Vector, c: Vector, d: Vector) -> int:
        t, one = self.tangent, fmpq(1)
        end = AngleInstant(one - t * t, 2 * t, one + t * t, one)
        found = line_line_rotation.rotation_contacts(Axis((fmpq(0), fmpq(0), one)), a, b, c, d)
        return sum(instant.compare(end) <= 0 for instant, _ in found)


class EdgeSet:
    """Edges at rest, ready for the queries of one kind: emptiness, counting, reporting.

    ends: (n, 2, 3) doubles, the exact coordinates.
    """

    def __init__(self, ends: np.ndarray, motion: Translated | Turned) -> None:
        self.ends, self.motion = ends, motion
        oriented = ends
        if isinstance(motion, Turned):
            falling = ends[:, 0, 2] > ends[:, 1, 2]
            oriented = np.where(falling[:, None, None], ends[:, ::-1], ends)
        c, d = (tuple(Bounded(oriented[:, k, j]) for j in range(3)) for k in range(2))
        self.features: Features = motion.features(c, d)  # type: ignore[arg-type]

    def counts(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """Number of contacts of the moving edge from a to b (doubles) with every edge of the set."""
        motion, total = self.motion, np.zeros(len(self.ends), np.int64)
        unsure = np.zeros(len(self.ends), bool)
        parameters = [_rounded(x) for x in motion.parameters()]
        bounded = [tuple(Bounded(np.float64(x)) for x in p) for p in motion.oriented(a, b)]
        known: dict[int, tuple[Any, Any]] = {}  # by form: few, in many conjunctions
        conjunctions = motion.conjunctions(*bounded, *parameters)  # type: ignore[arg-type]
        for conjunction in conjunctions:
            fails, holds = np.zeros(len(total), bool), np.ones(len(total), bool)
            for form, way, strict in conjunction:
                if id(form) not in known:
                    known[id(form)] = form.of(self.features).signs()
                signs, certain = known[id(form)]
                meets = way * signs > 0 if strict else way * signs >= 0
                fails |= certain & ~meets
                holds &= certain & meets
            total += holds
            unsure |= ~holds & ~fails
        for k in np.flatnonzero(unsure):
            total[k] = count_exactly(motion, *map(_exact, (a, b, *self.ends[k])))
        return total

    def hit(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """The edges that the moving edge meets."""
        return np.flatnonzero(self.counts(a, b))

    def is_free(self, a: np.ndarray, b: np.ndarray) -> bool:
        return not self.counts(a, b).any()


def count_exactly(motion: Translated | Turned, a: Vector, b: Vector, c: Vector, d: Vector) -> int:
    """Number of contacts of the moving ab with cd, all coordinates rational."""
    if motion.is_degenerate(a, b, c, d):
        return motion.contacts(a, b, c, d)
    features = motion.features(*motion.oriented(c, d))
    conjunctions = motion.conjunctions(*motion.oriented(a, b), *motion.parameters())
    forms = {id(x.form): x.form for conjunction in conjunctions for x in conjunction}
    signs = {key: sign(form.of(features)) for key, form in forms.items()}
    return sum(
        all(way * signs[id(form)] > (0 if strict else -1) for form, way, strict in conjunction)
        for conjunction in conjunctions
    )


def _exact(point: Sequence[float]) -> Vector:
    x, y, z = (fmpq(*float(c).as_integer_ratio()) for c in point)
    return x, y, z


def _rounded(x: Any) -> Any:
    """Doubles with their errors, for numbers and for vectors of them."""
    if isinstance(x, tuple):
        return tuple(_rounded(y) for y in x)
    rounded = float(fraction(x))
    return Bounded(np.float64(rounded), abs(rounded) * running.U)
