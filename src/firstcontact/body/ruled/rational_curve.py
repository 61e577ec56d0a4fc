"""Rational curves with exact coefficients, at rest or deforming with the time: the directrices of ruled surfaces."""

from __future__ import annotations

import re
from collections.abc import Hashable, Iterable, Sequence
from functools import reduce
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq, fmpq_poly, fmpz, fmpz_mpoly, fmpz_mpoly_ctx, fmpz_poly

from firstcontact.errors import InputError
from firstcontact.exact.expressions import context, read_tuple
from firstcontact.exact.numbers import rational, to_double
from firstcontact.exact.rigid import Matrix
from firstcontact.exact.vectors import Vector
from firstcontact.motion.translation import LARGEST
from firstcontact.motion.value import numbers

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from firstcontact.exact.numbers import Given
    from firstcontact.result import Table

VARIABLES = ("u", "T")
RING = context(VARIABLES)
"""The polynomials in the parameter u and the time T, of deforming curves."""

Component = Any
"""fmpz_poly in u at rest, fmpz_mpoly in u and T of what deforms."""
Components = tuple[Component, Component, Component, Component]


class RationalCurve:
    """The curve u -> (X, Y, Z)(u) / W(u); immutable.

    numerators: three lists of coefficients of 1, u, u^2, ...; denominator: one such list.  Numbers are exact: doubles
    are the binary rationals they are, "1/3", "0.1" and Fractions stay exact.  A coefficient may be a list itself, of
    coefficients of 1, T, T^2, ...: the curve then deforms with the time T.

    >>> circle = RationalCurve([[1, 0, -1], [0, 2], [0]], [1, 0, 1])
    >>> print(circle)
    ((-u**2 + 1)/(u**2 + 1), 2*u/(u**2 + 1), 0)
    >>> circle.points([0, 1, float("inf")]).tolist()
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
    >>> RationalCurve.parse("(u, T, u*T)").at("1/2")
    RationalCurve('(u, 1/2, u/2)')
    """

    __slots__ = ("components",)

    components: Components
    """(X, Y, Z, W): integer polynomials without common factor, in u, or of a deforming curve in u and T (RING)."""

    def __init__(self, numerators: Iterable[Iterable[Given]], denominator: Iterable[Given] = (1,)) -> None:
        rows = list(numerators) if np.iterable(numerators) and not isinstance(numerators, str) else []
        if len(rows) != 3:
            raise InputError(f"RationalCurve numerators are {numerators!r}; give three lists of coefficients")
        named = zip((*rows, denominator), (*(f"numerators[{k}]" for k in range(3)), "denominator"), strict=True)
        self.components = _checked(_homogeneous([_ratio(row, name) for row, name in named]), "RationalCurve")

    @classmethod
    def parse(cls, text: str, what: str = "RationalCurve") -> RationalCurve:
        """The curve of a string such as "((1-u**2)/(1+u**2), 2*u/(1+u**2), T)"; `what` names it in errors."""
        parts = read_tuple(text, VARIABLES, what)
        if len(parts) != 3:
            raise InputError(f"{what} {text!r} has {len(parts)} coordinates; write \"(x, y, z)\"")
        below = reduce(_lcm, (x.denominator for x in parts))
        rows = [x.numerator * (below // x.denominator) for x in parts]
        curve = cls.of((*rows, below))
        _checked(curve.components, f"{what} {text!r}")
        return curve

    @classmethod
    def of(cls, components: Sequence[Component]) -> RationalCurve:
        """The curve of homogeneous polynomials X, Y, Z, W in u, or in u and T (ring RING)."""
        curve = object.__new__(cls)
        curve.components = _primitive(components)
        return curve

    @classmethod
    def segment(cls, a: Vector, b: Vector) -> RationalCurve:
        """From a to b over 0 <= u <= 1; a point where they are one."""
        w = fmpz(1)
        for x in (*a, *b):
            w = w.lcm(x.q)
        rows = [fmpz_poly([(x * w).p, ((y - x) * w).p]) for x, y in zip(a, b, strict=True)]
        return cls.of([*rows, fmpz_poly([w])])

    # -- looking --------------------------------------------------------------------------------------------

    @property
    def deforming(self) -> bool:
        """Whether the curve depends on the time."""
        return isinstance(self.components[0], fmpz_mpoly)

    @property
    def velocity(self) -> Vector | None:
        """By how much the curve shifts in a unit of time, where it does nothing else; None of other deforming ones.

        >>> RationalCurve.parse("(u, 1 - 2*T, 1/3)").velocity
        (0, -2, 0)
        """
        *rows, below = map(terms, self.components)
        if any(j for _, j in below) or any(j > 1 for row in rows for _, j in row):
            return None
        weight = {i: c for (i, _), c in below.items()}
        one = next(iter(weight))
        ahead = [{i: c for (i, j), c in row.items() if j} for row in rows]
        way = [fmpq(row.get(one, 0), weight[one]) for row in ahead]
        shifts = all(row == {i: v * c for i, c in weight.items() if v} for row, v in zip(ahead, way, strict=True))
        return (way[0], way[1], way[2]) if shifts else None

    @property
    def degree(self) -> int:
        """In u, as a projective curve."""
        return max(i for x in self.components for i, _ in terms(x))

    @property
    def is_constant(self) -> bool:
        """Whether the curve is one point, which may move."""
        return is_point(self.components)

    def at(self, t: Given) -> RationalCurve:
        """The curve at rest at time t, a number of any kind, taken exactly; itself where it does not deform."""
        curve = self.projective_at(rational(t, "time"))
        if curve.components[3] == 0:
            raise InputError(f"a directrix has denominator 0 at T = {t}; give a time at which it is a curve")
        return curve

    def projective_at(self, time: fmpq) -> RationalCurve:
        """The same; all of it may be at infinity."""
        if not self.deforming:
            return self
        highest = max(j for x in self.components for _, j in terms(x))
        powers = [time.p**j * time.q ** (highest - j) for j in range(highest + 1)]
        rows = []
        for x in self.components:
            row = [fmpz(0)] * (self.degree + 1)
            for (i, j), c in terms(x).items():
                row[i] += c * powers[j]
            rows.append(fmpz_poly(row))
        return RationalCurve.of(rows)

    def reversed(self) -> RationalCurve:
        """The same curve with the parameter 1/u: infinity becomes 0."""
        n = self.degree
        return RationalCurve.of(
            [RING.from_dict({(n - i, j): c for (i, j), c in terms(x).items()}) for x in self.components]
        )

    def flipped(self) -> RationalCurve:
        """The same curve with the signs of X, Y, Z and W changed."""
        curve = object.__new__(RationalCurve)
        curve.components = tuple(-x for x in self.components)
        return curve

    def positive_at(self, u: fmpq, t: fmpq) -> RationalCurve:
        """The curve with W > 0 at u and time t, where W is not 0 there."""
        value = sum((c * u**i * t**j for (i, j), c in terms(self.components[3]).items()), fmpq(0))
        return self if value > 0 else self.flipped()

    @property
    def coefficients(self) -> tuple[tuple[tuple[int, ...], ...], ...]:
        """Of X, Y, Z and W: entry [i][j] is that of u^i T^j; all four of one size.

        >>> RationalCurve.parse("(u, T, 1/2)").coefficients[0]
        ((0, 0), (2, 0))
        """
        tables = [terms(x) for x in self.components]
        n, m = (max(key[k] for table in tables for key in table) + 1 for k in (0, 1))
        return tuple(tuple(tuple(int(t.get((i, j), 0)) for j in range(m)) for i in range(n)) for t in tables)

    def samples(self, u: np.ndarray, times: np.ndarray) -> np.ndarray:
        """(n, m, 3) float64 points at parameters (n,) and times (m,), deforming or not; infinite at poles."""
        tables = self.coefficients
        scale = max(abs(c) for table in tables for row in table for c in row)
        rows = np.array([[[to_double(fmpq(c, scale)) for c in row] for row in table] for table in tables])
        powers = (np.power.outer(x, np.arange(count)) for x, count in zip((u, times), rows.shape[1:], strict=True))
        values = np.einsum("kij,ui,tj->utk", rows, *powers)
        with np.errstate(all="ignore"):
            found: np.ndarray = values[..., :3] / values[..., 3:]
            return found

    def mapped(self, matrix: Matrix) -> RationalCurve:
        """The curve under an affine map (3x4, rational)."""
        scale = reduce(fmpz.lcm, (x.q for row in matrix for x in row))
        rows = [[(x * scale).p for x in row] for row in matrix]
        x, y, z, w = self.components
        return RationalCurve.of([*(a * x + b * y + c * z + d * w for a, b, c, d in rows), scale * w])

    def place(self, u: int | fmpq) -> Vector:
        """The point at a parameter, of a curve that rests."""
        x, y, z, below = (fmpq(1) * c(u) for c in self.components)
        x, y, z = x / below, y / below, z / below
        return x, y, z

    def height(self, normal: Vector) -> fmpq | None:
        """normal . x where it is the same at all points of a curve that rests; None of others.

        >>> RationalCurve.parse("(1/(1 + u), u, 1/3)").height((fmpq(0), fmpq(0), fmpq(3)))
        1
        """
        total = sum((fmpq_poly(p) * c for p, c in zip(self.components[:3], normal, strict=True)), fmpq_poly())
        weight = fmpq_poly(self.components[3])
        height: fmpq = total[weight.degree()] / weight[weight.degree()]
        return height if total == height * weight else None

    def points(self, u: ArrayLike) -> np.ndarray:
        """(..., 3) float64 points at rest, for u of any shape; it may be infinite, poles give NaN or infinity."""
        values = self.homogeneous(u)
        with np.errstate(all="ignore"):
            found: np.ndarray = values[..., :3] / values[..., 3:]
            return found

    def homogeneous(self, u: ArrayLike) -> np.ndarray:
        """(..., 4) float64 values of X, Y, Z, W at rest, up to a factor, finite at all u."""
        u = np.asarray(u, float)
        if np.any(np.isnan(u)):
            raise InputError("u holds NaN; give parameters")
        near = np.abs(u) <= 1
        with np.errstate(divide="ignore"):
            x = np.where(near, u, 1 / u)
        rows = self.floats()
        return np.moveaxis(np.where(near, _horner(rows, x), _horner(rows[:, ::-1], x)), 0, -1)

    def floats(self) -> np.ndarray:
        """(4, degree + 1) float64 ascending coefficients at rest, scaled together."""
        parts = self._resting()
        scale = max(abs(int(c)) for x in parts for c in x.coeffs())
        return np.array([[to_double(fmpq(x[i], scale)) for i in range(self.degree + 1)] for x in parts])

    def _resting(self) -> tuple[fmpz_poly, ...]:
        if self.deforming:
            raise InputError("this curve deforms with the time T; take .at(t)")
        return self.components

    def __eq__(self, other: object) -> bool:
        """Whether the parametrisations agree: the same point at every u, and T."""
        if not isinstance(other, RationalCurve):
            return NotImplemented
        p, q = (lifted(curve.components) for curve in (self, other))
        return all(p[i] * q[3] == q[i] * p[3] for i in range(3))

    def __hash__(self) -> int:
        return hash(self.key())

    def key(self) -> tuple[Hashable, ...]:
        """The same, and hashable, for equal curves: their coefficients, the first one positive."""
        tables = [sorted((power, int(c)) for power, c in terms(x).items()) for x in self.components]
        sign = 1 if next(c for table in tables for _, c in table) > 0 else -1
        return tuple(tuple((power, sign * c) for power, c in table) for table in tables)

    def table(self) -> Table:
        """Coefficients as the class and scene files take them: by powers of u, of T within these."""
        size = fmpz(max(abs(c) for x in self.components for c in terms(x).values()))
        scale = size if size >= LARGEST else fmpz(1)
        rows = [numbers([[fmpq(c, scale) for c in own] for own in x]) for x in self.coefficients]
        if not self.deforming:
            rows = [[own[0] for own in row] for row in rows]
        return {"numerators": rows[:3], "denominator": rows[3]}

    def __str__(self) -> str:
        w = self.components[3]
        return "(" + ", ".join(_text_of_ratio(x, w) for x in self.components[:3]) + ")"

    def __repr__(self) -> str:
        return f"RationalCurve({str(self)!r})"

    def __reduce__(self) -> tuple[object, ...]:
        return _restored, (tuple(tuple((key, int(c)) for key, c in terms(x).items()) for x in self.components),)


# -- polynomials in u, or in u and T ------------------------------------------------------------------------


def terms(p: Component) -> dict[tuple[int, int], fmpz]:
    """The coefficients of u^i T^j by (i, j)."""
    if isinstance(p, fmpz_mpoly):
        return {(int(i), int(j)): c for (i, j), c in p.to_dict().items()}
    return {(i, 0): c for i, c in enumerate(p.coeffs()) if c}


def is_point(components: Sequence[Component]) -> bool:
    """Whether homogeneous x, y, z, w are one point for all u."""
    w = components[3]
    return all(x * derivative(w) == derivative(x) * w for x in components[:3])


def derivative(p: Component) -> Component:
    """By u."""
    return p.derivative(0) if isinstance(p, fmpz_mpoly) else p.derivative()


def lifted(
    components: Sequence[Component], ring: fmpz_mpoly_ctx = RING, parameter: str = "u", clock: str = "T"
) -> tuple[fmpz_mpoly, ...]:
    """The polynomials in a ring of more variables, u and T under these names; resting ones need no `clock` there.

    >>> from firstcontact.exact.expressions import context
    >>> moving = RationalCurve.parse("(u, T, u*T)").components
    >>> [str(x) for x in lifted(moving, context(("u", "v", "T")), "v")]
    ['v', 'T', 'v*T', '1']
    """
    names = ring.names()
    place, time = names.index(parameter), names.index(clock) if clock in names else None
    found = []
    for p in components:
        placed = {}
        for (i, j), c in terms(p).items():
            if j and time is None:
                raise ValueError(f"the ring {names} has no {clock}")
            placed[tuple(i if k == place else j if k == time else 0 for k in range(len(names)))] = c
        found.append(ring.from_dict(placed))
    return tuple(found)


def _primitive(components: Sequence[Component]) -> Components:
    """Without common factor, as polynomials in u alone where T does not occur."""
    common = reduce(lambda x, y: x.gcd(y), components)
    found = [x // common for x in components]
    if isinstance(common, fmpz_mpoly) and not any(j for x in found for _, j in terms(x)):
        found = [in_u(x) for x in found]
        common = reduce(fmpz_poly.gcd, found)
        found = [x // common for x in found]
    return tuple(found)


def in_u(p: Component) -> fmpz_poly:
    """A component without T as a polynomial in u alone."""
    if isinstance(p, fmpz_poly):
        return p
    row = [fmpz(0)] * (max(p.degrees()[0], 0) + 1)
    for (i, _), c in p.to_dict().items():
        row[i] = c
    return fmpz_poly(row)


def _lcm(p: fmpz_mpoly, q: fmpz_mpoly) -> fmpz_mpoly:
    return p * (q // p.gcd(q))


def _horner(coefficients: np.ndarray, x: np.ndarray) -> np.ndarray:
    """(4, ...) values of the polynomials with ascending coefficients (4, n)."""
    total = np.zeros((4, *x.shape))
    for column in coefficients.T[::-1]:
        total = total * x + column.reshape(4, *(1 for _ in x.shape))
    return total


# -- reading and showing ------------------------------------------------------------------------------------


def _homogeneous(parts: list[dict[tuple[int, int], fmpq]]) -> Components:
    """The integer components of rational coefficients by (i, j)."""
    scale = reduce(fmpz.lcm, (c.q for part in parts for c in part.values()), fmpz(1))
    rows = [RING.from_dict({key: (c * scale).p for key, c in part.items() if c}) for part in parts]
    if rows[3].is_zero():
        raise InputError("RationalCurve denominator is 0; give one such as [1], or [1, 0, 1] for 1 + u**2")
    return _primitive(rows)


def _checked(components: Components, what: str) -> Components:
    """The components; InputError where doubles cannot hold the curve."""
    sizes = [[abs(c) for c in terms(x).values()] for x in components]
    every = [c for some in sizes for c in some]
    if max(every) >= max(sizes[3]) * 2**150 or max(every) > min(every) * 2**1000:
        raise InputError(
            f"{what} has coefficients of sizes too far apart for doubles; give numbers below 2^150 and none near 1e-300"
        )
    return components


def _ratio(row: Iterable[Given], what: str) -> dict[tuple[int, int], fmpq]:
    """Coefficients by (i, j) of a list of numbers, or of lists of such."""
    row = list(row) if np.iterable(row) and not isinstance(row, str) else row
    if not isinstance(row, list) or not row:
        raise InputError(f"RationalCurve {what} is {row!r}; give a list of coefficients of 1, u, u**2, ...")
    found = {}
    for i, entry in enumerate(row):
        nested = np.iterable(entry) and not isinstance(entry, str)
        for j, c in enumerate(entry if nested else [entry]):
            value = rational(c, f"RationalCurve {what}[{i}]" + (f"[{j}]" if nested else ""))
            if abs(value) >= LARGEST:
                raise InputError(f"RationalCurve {what}[{i}] is {c}; give a number below 2^150")
            found[i, j] = value
    return found


def _restored(table: Iterable[Iterable[tuple[tuple[int, ...], int]]]) -> RationalCurve:
    return RationalCurve.of([RING.from_dict(dict(x)) for x in table])


def _text_of_ratio(x: Component, w: Component) -> str:
    """x / w in lowest terms, as `parse` reads it."""
    common = x.gcd(w)
    above, below = x // common, w // common
    if below == -1 or below.leading_coefficient() < 0:
        above, below = -above, -below
    if below == 1:
        return text_of(above)
    shown = text_of(above) if len(terms(above)) == 1 else f"({text_of(above)})"
    divisor = text_of(below)
    return f"{shown}/{divisor}" if re.fullmatch(r"\d+|\w(\*\*\d+)?", divisor) else f"{shown}/({divisor})"


def text_of(p: Component, variables: tuple[str, ...] = VARIABLES) -> str:
    """The polynomial as Python writes it, highest powers first.

    >>> text_of(fmpz_poly([1, -1, 3]))
    '3*u**2 - u + 1'
    """
    text = ""
    for powers, c in sorted(terms(p).items(), reverse=True):
        factors = [f"{x}**{n}" if n > 1 else x for x, n in zip(variables, powers, strict=True) if n]
        if abs(c) != 1 or not factors:
            factors.insert(0, str(abs(c)))
        sign = ("-" if c < 0 else "") if not text else (" - " if c < 0 else " + ")
        text += sign + "*".join(factors)
    return text or "0"
