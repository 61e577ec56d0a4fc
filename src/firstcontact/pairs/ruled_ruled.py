"""Two ruled surfaces at rest: where two of their rulings meet, and where they are one line (Chen, Shen, Yuan 2011).

A surface is taken as its family of lines: the Pluecker vector l(u) = P1 ^ P2 of the directrices without the common
factor of its six components.  Base points and weights drop out with that factor, u = infinity is an ordinary
parameter, and Delta(u, v) = <l(u), m(v)> has the bidegree of the two vectors.

With L the matrix of l (the line as a set of points) and M* that of m (as a set of planes), column k of L M* is the
point in which l(u) meets the plane of m(v) and the unit point k.  So on Delta = 0 the matrix is I h^T: the meeting
point times the common plane of the two rulings.  It vanishes where they are one line, and only there.  Its columns are
the meeting points of the paper for the four auxiliary points, without superfluous factors (re-derived).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property, reduce
from typing import TYPE_CHECKING, Any

from flint import fmpq, fmpz, fmpz_mat, fmpz_mpoly, fmpz_poly

from firstcontact.errors import InputError
from firstcontact.exact.fields.field_towers import gcd, trimmed
from firstcontact.exact.fields.number_field import NumberField
from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots, reversed_polynomial
from firstcontact.exact.polynomials import bivariate
from firstcontact.exact.polynomials.bivariate import CONTEXT, in_u, in_v
from firstcontact.pairs import apex_rulings

if TYPE_CHECKING:
    from firstcontact.exact.ring import N

Vector = tuple[Any, Any, Any, Any]
Matrix = tuple[Vector, ...]
Parameter = AlgebraicRoot | None
"""A point of the projective line; None is infinity."""
Range = tuple[fmpq, fmpq] | None
"""An interval of parameters; None is the projective line."""

_ORIGIN = AlgebraicRoot.of(fmpq(0))
PAIRS = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
# Components of a line, and of the dual vector: that of the complementary pair, with its sign.
DUAL = ((5, 1), (4, -1), (3, 1), (2, 1), (1, -1), (0, 1))
# Three combinations stand for the fifteen minors.  Any weights are right: a bad choice only lets more candidates
# through, and every candidate is tested against the minors themselves.  Where they give zero, others are taken.
_WEIGHTS = (
    (3, -5, 7, 2, -11, 13, 17, -4, 19, 23, -6, 29, 31, -37, 41),
    (-2, 9, 4, -15, 8, 1, -21, 27, 5, -10, 33, 14, -7, 12, 22),
    (11, 6, -13, 20, 3, -9, 5, 16, -25, 2, 18, -1, 30, 7, -8),
)


@dataclass(frozen=True)
class Rulings:
    """The lines of one surface.

    first, second   the directrices (X, Y, Z, W), integer polynomials in the parameter
    line            the primitive Pluecker vector, components 01, 02, 03, 12, 13, 23
    common          the factor divided out: at its real roots the directrices share a point (degenerate rulings)
    """

    first: Vector
    second: Vector
    line: tuple[fmpz_poly, ...]
    common: fmpz_poly

    @classmethod
    def of(cls, first: Sequence[fmpz_poly], second: Sequence[fmpz_poly]) -> Rulings:
        """The lines through corresponding points; InputError where these are no surface."""
        p, q = ([x // _gcd(curve) for x in curve] for curve in (first, second))
        line = [p[i] * q[j] - p[j] * q[i] for i, j in PAIRS]
        common = _gcd(line)
        if common == 0:
            raise InputError("the directrices of a ruled surface are one curve; give two different ones")
        line = [x // common for x in line]
        if max(x.degree() for x in line) < 1:
            raise InputError("all rulings of a ruled surface are one line; give directrices that span a surface")
        return cls(_vector(p), _vector(q), tuple(line), common)

    @property
    def degree(self) -> int:
        return max(x.degree() for x in self.line)

    def reversed(self) -> Rulings:
        """The same lines with the parameter 1/u: infinity becomes 0."""
        first, second, line = (_reversed(x) for x in (self.first, self.second, self.line))
        return Rulings(_vector(first), _vector(second), line, _reversed([self.common])[0])

    def chart(self, parameter: Parameter) -> tuple[Rulings, AlgebraicRoot]:
        """A chart in which the parameter is finite, and its value there."""
        return (self.reversed(), _ORIGIN) if parameter is None else (self, parameter)

    @cached_property
    def apex(self) -> tuple[fmpz, ...] | None:
        """The point on all lines, if there is one; at infinity for cylinders."""
        return _kernel(row for line in self._coefficients for row in planes_through(line))

    @cached_property
    def plane(self) -> tuple[fmpz, ...] | None:
        """The plane of all lines, if there is one."""
        return _kernel(row for line in self._coefficients for row in points_on(line))

    @cached_property
    def _coefficients(self) -> list[tuple[fmpz, ...]]:
        return [tuple(fmpz(x[i]) for x in self.line) for i in range(self.degree + 1)]


def delta(p: Rulings, q: Rulings) -> fmpz_mpoly:
    """Delta(u, v), of bidegree (p.degree, q.degree) with both parameters projective."""
    return _sum(in_u(x) * in_v(q.line[j]) * sign for x, (j, sign) in zip(p.line, DUAL, strict=True))


def meeting(p: Rulings, q: Rulings) -> Matrix:
    """L M*: on Delta = 0 every column is the meeting point (X, Y, Z, W), every row the common plane of the rulings."""
    lines = points_on([in_u(x) for x in p.line])
    dual = planes_through([in_v(x) for x in q.line])
    return tuple(tuple(_sum(x * row[k] for x, row in zip(line, dual, strict=True)) for k in range(4)) for line in lines)


def brackets(p: Rulings, q: Rulings) -> tuple[Vector, Vector, Vector, Vector]:
    """[P1 P2 Q1 e], [P1 P2 Q2 e], [P1 Q1 Q2 e], [P2 Q1 Q2 e] for the unit points e = X, Y, Z, W, primitive lines.

    On Delta = 0, with one e off the common plane of the rulings: t = 0, t = 1, s = 0 and s = 1 are their zeros.
    """
    of_p = planes_through([in_u(x) for x in p.line])
    of_q = planes_through([in_v(x) for x in q.line])
    ends_q = [[in_v(x) for x in point] for point in (q.first, q.second)]
    ends_p = [[in_u(x) for x in point] for point in (p.first, p.second)]
    found = [[_sum(x * row[k] for x, row in zip(end, planes, strict=True)) for k in range(4)]
             for ends, planes in ((ends_q, of_p), (ends_p, of_q)) for end in ends]  # fmt: skip
    return tuple(map(tuple, found))  # type: ignore[return-value]


def points_on(line: Sequence[N]) -> Matrix:
    """The skew matrix of a Pluecker vector: its columns are points of the line."""
    a, b, c, d, e, f = line
    o = a - a
    return (o, a, b, c), (-a, o, d, e), (-b, -d, o, f), (-c, -e, -f, o)


def planes_through(line: Sequence[N]) -> Matrix:
    """The skew matrix whose columns are planes through the line."""
    return points_on([line[k] if sign > 0 else -line[k] for k, sign in DUAL])


@dataclass(frozen=True)
class CommonRulings:
    """S1, the pairs (u, v) of rulings that are one line.

    correspondence   a polynomial in u, v without repeated factors whose real zeros are such pairs; constant if none
    pairs            all others on finite lines, ascending in u, then v, infinity last
    """

    correspondence: fmpz_mpoly
    pairs: tuple[tuple[Parameter, Parameter], ...]


def common_rulings(p: Rulings, q: Rulings, u_range: Range = None, v_range: Range = None) -> CommonRulings:
    """S1, exactly: the 2x2 minors of (l(u); m(v)) vanish.  Pairs only from closed ranges, where these are given."""
    minors = _minors([in_u(x) for x in p.line], [in_v(x) for x in q.line])
    common = reduce(lambda x, y: x.gcd(y), minors)
    minors = [x // common for x in minors]
    found: list[tuple[Parameter, Parameter]] = []
    u_values, v_values = _candidates(minors, "u"), _candidates(minors, "v")
    is_apex_shared = p.apex is not None and p.apex == q.apex
    for u in _within(u_values, u_range):
        partners = apex_rulings.partners(p, q, u, u_values, v_values) if is_apex_shared else None
        if partners is None:
            partners = _partners(minors, u, v_values) or [v for v in v_values if _one_line(p, u, q, v)]
        found += [(u, v) for v in _within(partners, v_range)]
    if v_range is None:
        found += [(u, None) for u in _within(_equal_to(p, q.reversed()), u_range)]
    if u_range is None:
        found += [(None, v) for v in _within(_equal_to(q, p.reversed()), v_range)]
    if u_range is None and v_range is None and _one_line(p.reversed(), _ORIGIN, q.reversed(), _ORIGIN):
        found.append((None, None))
    found = [(u, v) for u, v in found if not at_infinity(p, u)]
    return CommonRulings(squarefree(common), tuple(_off(found, common)))


def _within(roots: list[AlgebraicRoot], ends: Range) -> list[AlgebraicRoot]:
    return roots if ends is None else [x for x in roots if x.compare(ends[0]) >= 0 and x.compare(ends[1]) <= 0]


def _off(found: list[tuple[Parameter, Parameter]], curve: fmpz_mpoly) -> list[tuple[Parameter, Parameter]]:
    """The pairs that are not on the curve."""
    if curve.is_constant():
        return found
    degrees = curve.degrees()
    return [pair for pair in found if sign_at(curve, *pair, degrees) != 0]


def _candidates(minors: Sequence[fmpz_mpoly], variable: str) -> list[AlgebraicRoot]:
    """All real values of one parameter at which the minors may vanish together."""
    other = "v" if variable == "u" else "u"
    if any(x.is_constant() and not x.is_zero() for x in minors):
        return []
    for turn in range(len(minors)):
        turned = [*minors[turn:], *minors[:turn]]
        sums = [_sum(w * x for w, x in zip(weights, turned, strict=True)) for weights in _WEIGHTS]
        sums = [x for x in sums if not x.is_zero()]
        bound = fmpz_poly([0])
        for g in sums[1:]:
            bound = bound.gcd(bivariate.resultant(sums[0], g, other))
        if bound != 0:
            return all_real_roots(bound)
    raise ArithmeticError("many combinations of the minors share a factor that the minors do not")


def _partners(minors: Sequence[fmpz_mpoly], u: AlgebraicRoot, v_values: Sequence[AlgebraicRoot]) -> list[AlgebraicRoot]:
    """The v, among all candidates, at which the minors vanish with u, if it is one in the field of u; else [].

    Quicker than to decide for each candidate whether it is that: the product of the degrees of u and v may be hundreds.
    """
    if u.rational is not None or not v_values:
        return []
    field = NumberField(u)
    over = [[field(c) for c in bivariate.rows(minor)] for minor in minors if not minor.is_zero()]
    common = trimmed(reduce(gcd, sorted(over, key=len)))
    if len(common) != 2:
        return []
    v, left, bits = -common[0] / common[1], list(v_values), 64
    while len(left) > 1:  # v is real, and one of them
        ball = v.ball(bits)
        left = [x for x in left if x.enclosure(bits).overlaps(ball)]
        bits *= 2
    return left


def _one_line(p: Rulings, u: AlgebraicRoot, q: Rulings, v: AlgebraicRoot) -> bool:
    """Whether l(u) and m(v) are proportional: five minors, with a component of l that is not zero."""
    k = next(i for i, x in enumerate(p.line) if u.sign_of(x) != 0)
    minors = (in_u(p.line[k]) * in_v(q.line[j]) - in_u(p.line[j]) * in_v(q.line[k]) for j in range(6) if j != k)
    return all(minor.is_zero() or bivariate.sign_at(minor, u, v) == 0 for minor in minors)


def _equal_to(p: Rulings, q: Rulings) -> list[AlgebraicRoot]:
    """The finite u with l(u) = m(0)."""
    line = [x[0] for x in q.line]
    return all_real_roots(reduce(fmpz_poly.gcd, _minors(p.line, line), fmpz_poly([0])))


def _minors(x: Sequence[Any], y: Sequence[Any]) -> list[Any]:
    return [x[i] * y[j] - x[j] * y[i] for i in range(6) for j in range(i)]


class FactorKind(Enum):
    """What the zeros of a factor of Delta are in space."""

    CURVE = "a curve"
    RULING = "a ruling of one surface that meets all rulings of the other"
    POINT = "the apex of one surface, on a ruling of the other"
    INFINITE = "nothing finite: the rulings are parallel"
    COMMON = "common rulings"


@dataclass(frozen=True)
class Factor:
    """An irreducible factor of Delta in both variables."""

    polynomial: fmpz_mpoly
    multiplicity: int
    kind: FactorKind


@dataclass(frozen=True)
class SpecialRuling:
    """A ruling that meets all rulings of the other surface: a real zero of a factor of Delta in one variable.

    side    0 for a ruling of p (u = parameter), 1 for one of q
    point   for FactorKind.POINT: the apex of the other surface (X, Y, Z, W)
    """

    side: int
    parameter: Parameter
    multiplicity: int
    kind: FactorKind
    point: tuple[fmpz, ...] | None = None


def factors(
    p: Rulings, q: Rulings, d: fmpz_mpoly, points: Matrix, correspondence: fmpz_mpoly
) -> tuple[list[Factor], list[SpecialRuling]]:
    """The factors of d = Delta != 0, with their meaning; `points` is meeting(p, q).

    A factor in both variables never contracts to a point: then all rulings of both surfaces would pass through it, and
    Delta would vanish.
    """
    curves: list[Factor] = []
    special: list[SpecialRuling] = []
    found = bivariate.factors(d)
    for factor, multiplicity in found.curves:
        curves.append(Factor(factor, multiplicity, _kind(factor, points, correspondence)))
    for side, own in enumerate((found.in_u, found.in_v)):
        for polynomial, multiplicity in own:
            special += [_special(p, q, side, root, multiplicity) for root in all_real_roots(polynomial)]
    for side, (whole, seen) in enumerate(zip((p.degree, q.degree), d.degrees(), strict=True)):
        if seen < whole:
            special.append(_special(p, q, side, None, whole - seen))
    return curves, special


def _kind(factor: fmpz_mpoly, points: Matrix, correspondence: fmpz_mpoly) -> FactorKind:
    if divides(factor, correspondence):
        return FactorKind.COMMON
    return FactorKind.INFINITE if all(divides(factor, x) for x in points[3]) else FactorKind.CURVE


def _special(p: Rulings, q: Rulings, side: int, parameter: Parameter, multiplicity: int) -> SpecialRuling:
    own, other = (p, q) if side == 0 else (q, p)
    chart, root = own.chart(parameter)
    apex = other.apex
    if apex is not None and _holds(chart, root, apex):
        if apex[3] == 0:
            return SpecialRuling(side, parameter, multiplicity, FactorKind.INFINITE)
        return SpecialRuling(side, parameter, multiplicity, FactorKind.POINT, apex)
    kind = FactorKind.INFINITE if at_infinity(own, parameter) else FactorKind.RULING
    return SpecialRuling(side, parameter, multiplicity, kind)


def at_infinity(lines: Rulings, parameter: Parameter) -> bool:
    """Whether the ruling is in the plane at infinity."""
    chart, root = lines.chart(parameter)
    return root.sign_of(rulings_at_infinity(chart)) == 0


def rulings_at_infinity(lines: Rulings) -> fmpz_poly:
    """Its zeros are the rulings in the plane at infinity; 0 where all are."""
    return _gcd(lines.line[k] for k in (2, 4, 5))


def _holds(lines: Rulings, root: AlgebraicRoot, point: Sequence[fmpz]) -> bool:
    """Whether the point is on the ruling at the root."""
    rows = planes_through(lines.line)
    return all(root.sign_of(_sum(x * y for x, y in zip(row, point, strict=True))) == 0 for row in rows)


def rulings_through(lines: Rulings, point: Sequence[fmpz]) -> fmpz_poly:
    """Its zeros are the finite parameters of the rulings that hold the point; 0 where all do."""
    return _gcd(_sum(x * y for x, y in zip(row, point, strict=True)) for row in planes_through(lines.line))


def divides(f: fmpz_mpoly, g: fmpz_mpoly) -> bool:
    return g.is_zero() or f.gcd(g).degrees() == f.degrees()


def squarefree(f: fmpz_mpoly) -> fmpz_mpoly:
    return reduce(lambda x, y: x * y, (g for g, _ in bivariate.squarefree_factors(f)), CONTEXT.constant(1))


def all_real_roots(f: fmpz_poly) -> list[AlgebraicRoot]:
    """All real roots, ascending (Cauchy's bound)."""
    if f.degree() < 1:
        return []
    bound = fmpq(1 + max(abs(c) for c in f.coeffs()) // abs(f.leading_coefficient()) + 1)
    return real_roots(f, -bound, bound)


def sign_at(f: fmpz_mpoly, u: Parameter, v: Parameter, degrees: tuple[int, ...]) -> int:
    """Sign of f, homogenised with these degrees, at a point of the projective parameters."""
    terms = f.to_dict()
    if not terms:
        return 0
    if u is None:
        terms, u = {(degrees[0] - i, j): c for (i, j), c in terms.items()}, _ORIGIN
    if v is None:
        terms, v = {(i, degrees[1] - j): c for (i, j), c in terms.items()}, _ORIGIN
    return bivariate.sign_at(CONTEXT.from_dict(terms), u, v)


def _vector(x: Sequence[N]) -> Vector:
    return x[0], x[1], x[2], x[3]


def _sum(terms: Iterable[N]) -> N:
    return reduce(lambda x, y: x + y, terms)


def _gcd(polynomials: Iterable[fmpz_poly]) -> fmpz_poly:
    return reduce(fmpz_poly.gcd, polynomials, fmpz_poly([0]))


def _reversed(polynomials: Sequence[fmpz_poly]) -> tuple[fmpz_poly, ...]:
    degree = max(x.degree() for x in polynomials)
    return tuple(reversed_polynomial(x, degree) for x in polynomials)


def _kernel(rows: Iterable[Sequence[fmpz]]) -> tuple[fmpz, ...] | None:
    """The only vector, up to a factor, that is orthogonal to all rows; primitive, its first component positive."""
    matrix = fmpz_mat([list(row) for row in rows])
    basis, dimension = matrix.nullspace()
    if dimension != 1:
        return None
    vector = [basis[i, 0] for i in range(matrix.ncols())]
    divisor = reduce(fmpz.gcd, vector, fmpz(0))
    if next(x for x in vector if x) < 0:
        divisor = -divisor
    return tuple(x // divisor for x in vector)
