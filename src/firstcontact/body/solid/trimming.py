"""One curve against all surfaces of its solid: where it crosses them, and a point on every arc in between.

Every line and conic, of whatever kind, is a closed loop of the projective space and is written

    X(m) = a + b m + sheet sqrt(N(m)) (c + e m),    m in (-inf, inf), sheet in {+1, -1},

with rational a, b, c, e, N: lines have one sheet and N = 0.  For a conic y^T C y = 0 take a point O with C(O) < 0 and
the pencil of lines through it, y = r O + K d(m): N = G^2 - F K with K = C(O), G = O^T C d, F = C(d) is positive for
all m, and the two sheets follow each other.  No rational point of the conic is needed, so nothing is rounded: a
surface is crossed at roots of a rational polynomial of degree <= 4, and signs at rational m are signs of u + v sqrt(n).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cmp_to_key
from itertools import product
from typing import TYPE_CHECKING, Any

from flint import arb, fmpq, fmpq_poly, fmpz_poly

from firstcontact.body.solid.carriers import (
    ONE,
    ZERO,
    Conic,
    Line,
    Plane,
    Rows,
    Surface,
    Vector,
    bilinear,
    diagonalised,
    dot,
    times,
    transposed,
)
from firstcontact.exact.fields.surd import Surd
from firstcontact.exact.numbers import Undecidable, dyadic, precision

if TYPE_CHECKING:
    from firstcontact.exact.ring import E

# Working precision (bits) of enclosures; distinct roots closer than that are refused, not guessed.
BITS = 400
INFINITY = -1  # stands for the plane w = 0 where surfaces are numbered


@dataclass(frozen=True)
class Loop:
    """The parametrisation of the module's text; joined: whether sheet -1 continues sheet +1."""

    a: Vector
    b: Vector
    c: Vector
    e: Vector
    n: fmpq_poly
    sheets: tuple[int, ...]
    joined: bool

    def restricted(self, surface: Surface | None) -> tuple[fmpq_poly, fmpq_poly]:
        """(U, V): the surface's form (None: w) on the curve is U + sheet sqrt(N) V."""
        a, b, c, e = self.a, self.b, self.c, self.e
        if surface is None or isinstance(surface, Plane):
            n = (ZERO, ZERO, ZERO, ONE) if surface is None else surface.normal
            return fmpq_poly([dot(n, a), dot(n, b)]), fmpq_poly([dot(n, c), dot(n, e)])
        form = surface.form
        plain = _square(form, a, b)
        if len(self.sheets) == 1:
            return plain, fmpq_poly(0)
        mixed = [bilinear(form, a, c), bilinear(form, a, e) + bilinear(form, b, c), bilinear(form, b, e)]
        return plain + self.n * _square(form, c, e), 2 * fmpq_poly(mixed)

    def point(self, m: arb, sheet: int) -> list[arb]:
        """Enclosure of X(m) at the present precision."""
        if len(self.sheets) == 1:
            return [p + m * q for p, q in zip(self.a, self.b, strict=True)]
        root = sheet * _at(self.n, m).sqrt()
        return [
            p + m * q + root * (r + m * s) for p, q, r, s in zip(self.a, self.b, self.c, self.e, strict=True)
        ]

    def tangent(self, m: arb, sheet: int) -> list[arb]:
        """Enclosure of dX/dm."""
        if len(self.sheets) == 1:
            return [arb(q) for q in self.b]
        root = sheet * _at(self.n, m).sqrt()
        slope = _at(self.n.derivative(), m) / (2 * root)
        return [q + slope * (r + m * s) + root * s for q, r, s in zip(self.b, self.c, self.e, strict=True)]


def _square(form: Rows, a: Vector, b: Vector) -> fmpq_poly:
    return fmpq_poly([bilinear(form, a, a), 2 * bilinear(form, a, b), bilinear(form, b, b)])


def _at(p: fmpq_poly, x: E) -> E:
    value = x * 0
    for coefficient in reversed(p.coeffs()):
        value = value * x + coefficient
    return value


@dataclass(frozen=True, eq=False)
class Root:
    """A real root of an irreducible polynomial; equal numbers are the same object within one loop."""

    polynomial: fmpz_poly
    ball: arb

    @property
    def rational(self) -> fmpq | None:
        p = self.polynomial
        return fmpq(-p[0], p[1]) if p.degree() == 1 else None


@dataclass(frozen=True, eq=False)
class Break:
    """A point where the curve meets surfaces (numbers; INFINITY for w = 0)."""

    root: Root
    sheet: int
    surfaces: tuple[int, ...]

    @property
    def finite(self) -> bool:
        return INFINITY not in self.surfaces


@dataclass(frozen=True, eq=False)
class Arc:
    """An open arc between neighbouring breaks (None: the whole loop), with the sample point X(m)."""

    start: Break | None
    end: Break | None
    m: fmpq
    sheet: int
    signs: tuple[int, ...]
    """Sign of every surface's form at the sample (w > 0), and so on the whole arc; 0: contains the curve."""


@dataclass(frozen=True, eq=False)
class Trimmed:
    """All arcs of one loop (both lines of a pair count as one loop each)."""

    loop: Loop
    surfaces: tuple[int, ...]
    arcs: tuple[Arc, ...]


def trim(curve: Line | Conic, surfaces: Sequence[Surface], known: Sequence[int] | None = None) -> list[Trimmed]:
    """The curve cut at all surfaces and at infinity; one entry per loop.

    known: signs of forms where they are asked for, taken as they are; at surfaces that have one the curve is not cut.
    """
    for bits in (BITS, 4 * BITS, 16 * BITS):
        try:
            return _trimmed(curve, surfaces, known or (0,) * len(surfaces), bits)
        except Undecidable:
            continue
    raise Undecidable


def _trimmed(curve: Line | Conic, surfaces: Sequence[Surface], known: Sequence[int], bits: int) -> list[Trimmed]:
    loop, crossings = _generic_loop(curve, {i: surfaces[i] for i, sign in enumerate(known) if sign == 0})
    containing = tuple(i for i, crossing in crossings.items() if crossing is None)
    breaks = _breaks(loop, crossings, bits)
    groups = [loop.sheets] if loop.joined else [(sheet,) for sheet in loop.sheets]
    found = []
    for sheets in groups:
        own = [b for sheet in sheets for b in breaks[sheet]]
        arcs = _arcs(loop, sheets, own, _SurfaceSigns(loop, surfaces, known, crossings), bits)
        found.append(Trimmed(loop, containing, tuple(arcs)))
    return found


Crossing = tuple[fmpq_poly, fmpq_poly, fmpq_poly]
"""(U, V, U^2 - N V^2)."""


def _generic_loop(curve: Line | Conic, surfaces: dict[int, Surface]) -> tuple[Loop, dict[int, Crossing | None]]:
    """A parametrisation in which m = infinity is no crossing and no line of the pencil meets two crossings.

    Among finitely many bad choices of (k, j) the search runs into a good one soon; where the second wish cannot be
    had at all (both lines of a pair through one point), the wish is dropped.
    """
    for k, j in sorted(product(range(40), range(4)), key=sum):
        loop = parametrised(curve, k, j)
        crossings = {i: _crossing(loop, surface) for i, surface in surfaces.items()}
        crossings[INFINITY] = _crossing(loop, None)
        if all(c is None or _is_generic(loop, c, i, surfaces) for i, c in crossings.items()):
            return loop, crossings
    raise Undecidable


def _crossing(loop: Loop, surface: Surface | None) -> Crossing | None:
    u, v = loop.restricted(surface)
    norm = u if len(loop.sheets) == 1 else u * u - loop.n * v * v
    return None if norm.is_zero() else (u, v, norm)


def _is_generic(loop: Loop, crossing: Crossing, i: int, surfaces: dict[int, Surface]) -> bool:
    u, v, norm = crossing
    degree = (1 if i == INFINITY or isinstance(surfaces[i], Plane) else 2) * len(loop.sheets)
    if norm.degree() < degree:
        return False
    if len(loop.sheets) == 1:
        return True
    shared = u.gcd(v)
    if not loop.joined:
        while shared.degree() > 0 and shared[0] == 0:  # m = 0 is where the two lines of a pair meet
            shared = shared.right_shift(1)
    return shared.degree() <= 0


def parametrised(curve: Line | Conic, k: int, j: int) -> Loop:
    """The curve as a Loop; (k, j) choose among equivalent parametrisations."""
    zero = (ZERO,) * 4
    curve = balanced(curve)
    if isinstance(curve, Line):
        direction, point = transposed(curve.basis)
        return Loop(direction, _plus(point, k * ONE + j * fmpq(1, 7), direction), zero, zero, fmpq_poly(0), (1,), False)
    sizes = [(value, vector, power_of_two(vector)) for value, vector in diagonalised(curve.form)]
    parts = sorted(((value / s**2, _scaled(1 / s, vector)) for value, vector, s in sizes), key=lambda part: part[0])
    if all(value for value, _ in parts):
        return _conic_loop(curve, [vector for _, vector in parts], k, j)
    (p, u), (_, vertex), (q, v) = parts
    # both lines through the vertex: q u +- sqrt(-p q) v, sheared by j + k sqrt(-p q) towards the vertex
    up, vp, kernel = (_mapped(curve.basis, y) for y in (u, v, vertex))
    b = tuple(q * x + j * y for x, y in zip(up, kernel, strict=True))
    e = tuple(x + k * y for x, y in zip(vp, kernel, strict=True))
    return Loop(kernel, b, zero, e, fmpq_poly([-p * q]), (1, -1), False)


def balanced(curve: Line | Conic) -> Line | Conic:
    """The same curve with basis columns of length about one: exact rotations make integers of hundreds of digits."""
    sizes = [power_of_two(column) for column in transposed(curve.basis)]
    basis = tuple(tuple(x / s for x, s in zip(row, sizes, strict=True)) for row in curve.basis)
    if isinstance(curve, Line):
        return Line(basis)
    form = [[x / (s * t) for x, t in zip(row, sizes, strict=True)] for row, s in zip(curve.form, sizes, strict=True)]
    size = power_of_two([x for row in form for x in row])
    return Conic(basis, tuple(tuple(x / size for x in row) for row in form))


def power_of_two(vector: Sequence[fmpq]) -> fmpq:
    """A power of two within a factor of four of the largest entry."""
    largest = max(abs(x) for x in vector)
    bits = int(largest.p).bit_length() - int(largest.q).bit_length()
    return fmpq(2) ** bits if bits >= 0 else 1 / fmpq(2) ** -bits


def _conic_loop(curve: Conic, frame: list[Vector], k: int, j: int) -> Loop:
    o, first, second = frame
    first, second = _plus(first, fmpq(k, 3), second), _plus(second, fmpq(-k, 3), first)
    step = fmpq(j, 5)
    while True:
        centre = _plus(_plus(o, step, first), step * fmpq(2, 3), second)
        weight = bilinear(curve.form, centre, centre)
        if weight < 0:
            break
        step /= 2
    polar = [bilinear(curve.form, centre, d) for d in (first, second)]
    g = fmpq_poly(polar)
    f = _square(curve.form, first, second)
    a, b = (
        _mapped(curve.basis, _plus(_scaled(weight, d), -p, centre))
        for d, p in zip((first, second), polar, strict=True)
    )
    return Loop(a, b, _mapped(curve.basis, centre), (ZERO,) * 4, g * g - f * weight, (1, -1), True)


def _plus(x: Vector, k: fmpq, y: Vector) -> Vector:
    return tuple(a + k * b for a, b in zip(x, y, strict=True))


def _scaled(k: fmpq, x: Vector) -> Vector:
    return tuple(k * a for a in x)


def _mapped(rows: Rows, y: Vector) -> Vector:
    return tuple(row[0] for row in times(rows, tuple((x,) for x in y)))


def _breaks(loop: Loop, crossings: dict[int, Crossing | None], bits: int) -> dict[int, list[Break]]:
    """For each sheet the breaks in ascending order of m."""
    factors: dict[tuple[Any, ...], tuple[fmpz_poly, list[int]]] = {}
    for i, crossing in crossings.items():
        if crossing is not None:
            for factor, _ in crossing[2].numer().factor()[1]:
                if factor.degree() > 0:
                    factors.setdefault(tuple(factor.coeffs()), (factor, []))[1].append(i)
    found: dict[int, list[Break]] = {sheet: [] for sheet in loop.sheets}
    with precision(bits):
        for factor, on in factors.values():
            for found_root in factor.complex_roots():
                value: Any = found_root[0]  # type: ignore[index]
                if value.imag != 0:
                    continue
                root = Root(factor, arb(value.real))
                for sheet in loop.sheets:
                    here = tuple(i for i in on if _vanishes(loop, crossings[i], root, sheet))  # type: ignore[arg-type]
                    if here:
                        found[sheet].append(Break(root, sheet, here))
        return {sheet: sorted(breaks, key=cmp_to_key(_order)) for sheet, breaks in found.items()}


def _vanishes(loop: Loop, crossing: Crossing, root: Root, sheet: int) -> bool:
    """Whether U + sheet sqrt(N) V is zero at a root of U^2 - N V^2: both are zero, or their signs are opposite."""
    u, v, _ = crossing
    if len(loop.sheets) == 1 or (v % fmpq_poly(root.polynomial)).is_zero():
        return True
    return _sign(_at(u, root.ball)) == -sheet * _sign(_at(v, root.ball))


def _sign(x: arb) -> int:
    if x > 0:
        return 1
    if x < 0:
        return -1
    raise Undecidable


def _order(p: Break, q: Break) -> int:
    return 0 if p is q else _sign(p.root.ball - q.root.ball)


def _arcs(
    loop: Loop,
    sheets: tuple[int, ...],
    cycle: list[Break],
    signs: _SurfaceSigns,
    bits: int,
) -> list[Arc]:
    """The arcs between the breaks of one cycle."""

    def arc(start: Break | None, end: Break | None, m: fmpq, sheet: int) -> Arc:
        return Arc(start, end, m, sheet, signs.at(m, sheet))

    if not cycle:
        return [arc(None, None, ZERO, sheets[0])]
    arcs = []
    with precision(bits):
        for start, end in zip(cycle, cycle[1:] + cycle[:1], strict=True):
            follows = start.sheet == end.sheet and start is not end and start.root.ball < end.root.ball
            m = between(start.root.ball, end.root.ball) if follows else beyond(start.root.ball)
            arcs.append(arc(start, end, m, start.sheet))
    return arcs


def between(lo: arb, hi: arb) -> fmpq:
    """A short rational strictly between two disjoint balls, lo < hi."""
    low, high = dyadic(arb(lo.upper())), dyadic(arb(hi.lower()))
    scale = ONE
    while True:
        m = ((low + high) / 2 * scale).floor() / fmpq(scale)
        if low < m < high:
            return m
        scale *= 4


def beyond(x: arb) -> fmpq:
    return fmpq(dyadic(arb(x.upper())).ceil() + 1)


@dataclass(frozen=True, eq=False)
class _SurfaceSigns:
    """Of all forms along a loop."""

    loop: Loop
    surfaces: Sequence[Surface]
    known: Sequence[int]
    crossings: dict[int, Crossing | None]

    def at(self, m: fmpq, sheet: int) -> tuple[int, ...]:
        """Exact, at X(m), taken at positive w."""
        n = _at(self.loop.n, m)

        def value(crossing: Crossing | None) -> int:
            if crossing is None:
                return 0
            u, v, _ = crossing
            return Surd(_at(u, m), sheet * _at(v, m), n).sign()

        w = value(self.crossings[INFINITY])
        signs = list(self.known)
        for i, crossing in self.crossings.items():
            if i != INFINITY:
                signs[i] = value(crossing) * (w if isinstance(self.surfaces[i], Plane) else 1)
        return tuple(signs)


def largest(values: Sequence[arb]) -> arb:
    """The largest midpoint in absolute value: to divide by before rounding, since balls may exceed all doubles."""
    size = abs(values[0].mid())
    for value in values[1:]:
        if abs(value.mid()) > size:
            size = abs(value.mid())
    return arb(size)
