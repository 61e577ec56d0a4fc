"""Pencils l A - B of quadrics and conics: characteristic polynomial, discriminants, and where the two touch.

Entries may be fmpq, elements of a number field, or integer polynomials in the motion parameter for everything that
needs no division.  Two quadrics touch at X exactly where (l0 A - B) X = 0 and X^T A X = 0 (Choi et al. 2014), and
then l0 is a multiple root of det(l A - B); what happens there is read from the member l0 A - B restricted to the
tangent plane (re-derived; it reproduces the contact classes of Tu et al. 2009).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, Any

from flint import Ordering, fmpz_mpoly_ctx, fmpz_poly
from flint.utils.flint_exceptions import DomainError

from firstcontact.exact.fields.field_towers import product
from firstcontact.exact.fields.number_field import filtered_sign, is_zero, sign, square_root
from firstcontact.exact.polynomials.bivariate import squarefree_factors
from firstcontact.exact.polynomials.inertia import Rows, inertia, null_space, times
from firstcontact.exact.polynomials.polynomial_matrix import congruent, determinant

if TYPE_CHECKING:
    from firstcontact.exact.ring import D, MatrixOf, N, Number

Vector = tuple[Any, ...]
IDENTICALLY_DEGENERATE = "identically degenerate pencil"


# ------------------------------------------------------------------------------- characteristic polynomial


def characteristic(a: MatrixOf[N], b: MatrixOf[N]) -> list[N]:
    """Coefficients c_0 .. c_n of det(l A - B), ascending in l, for n x n matrices, n = 2, 3, 4."""
    n = len(a)
    if n == 2:
        return _pair(a, b, 0, 1, 0, 1)
    if n == 3:
        total: list[Any] = []
        for k, (i, j) in enumerate(((1, 2), (0, 2), (0, 1))):
            term = product(_pair(a, b, 0, 1, i, j), [-b[2][k], a[2][k]])
            total = _combined(total, term, -1 if k == 1 else 1)
        return total
    total = []
    for i, j, g, h, s in _LAPLACE:
        total = _combined(total, product(_pair(a, b, 0, 1, i, j), _pair(a, b, 2, 3, g, h)), s)
    return total


# columns of rows 1, 2; columns of rows 3, 4; sign
_LAPLACE = ((0, 1, 2, 3, 1), (0, 2, 1, 3, -1), (0, 3, 1, 2, 1), (1, 2, 0, 3, 1), (1, 3, 0, 2, -1), (2, 3, 0, 1, 1))


def _pair(a: MatrixOf[N], b: MatrixOf[N], r: int, s: int, i: int, j: int) -> list[N]:
    """The 2x2 minor of l A - B in rows r, s and columns i, j, ascending in l."""
    ari, arj, asi, asj = a[r][i], a[r][j], a[s][i], a[s][j]
    bri, brj, bsi, bsj = b[r][i], b[r][j], b[s][i], b[s][j]
    return [
        bri * bsj - brj * bsi,
        arj * bsi + brj * asi - ari * bsj - bri * asj,
        ari * asj - arj * asi,
    ]


def _combined(f: list[N], g: list[N], s: int) -> list[N]:
    if not f:
        return g
    return [x + y if s > 0 else x - y for x, y in zip(f, g, strict=True)]


def discriminant(c: Sequence[N]) -> N:
    """Discriminant of the binary form with coefficients c (ascending), degree 2, 3 or 4, in closed form.

    It vanishes where two of the projective roots coincide, those at infinity included.
    """
    if len(c) == 3:
        return c[1] * c[1] - 4 * (c[0] * c[2])
    if len(c) == 4:
        d, x, b, a = c
        bx, ad = b * x, a * d
        return 18 * (ad * bx) - 4 * (b * b * b * d) + bx * bx - 4 * (a * x * x * x) - 27 * (ad * ad)
    e, d, x, b, a = c
    i = 12 * (a * e) - 3 * (b * d) + x * x
    j = 72 * (a * x * e) + 9 * (b * x * d) - 27 * (a * d * d) - 27 * (e * b * b) - 2 * (x * x * x)
    total: Any = 4 * (i * i * i) - j * j
    return total // 27 if isinstance(total, fmpz_poly | int) else total / 27  # type: ignore[return-value]  # as c


def resultant(f: Sequence[N], g: Sequence[N]) -> N:
    """Resultant of two binary forms (ascending), one of them linear or both quadratic; up to its sign."""
    if len(g) == 2:
        f, g = g, f
    if len(f) == 2:  # g at the root -f0 / f1
        total: Any = None
        for k, c in enumerate(g):
            term = c
            for _ in range(k):
                term = term * -f[0]
            for _ in range(len(g) - 1 - k):
                term = term * f[1]
            total = term if total is None else total + term
        return total
    (f0, f1, f2), (g0, g1, g2) = f, g
    outer = f0 * g2 - f2 * g0
    return outer * outer - (f0 * g1 - f1 * g0) * (f1 * g2 - f2 * g1)


# ------------------------------------------------------------------------------------- candidates in motion


@dataclass(frozen=True, slots=True)
class ContactEquation:
    """Candidates of a moving pair are the roots of all `factors` (polynomials in u, none of them zero).

    `deflated`: roots of the characteristic polynomial coincide for all u (two spheres, coaxial surfaces), and the
    factors are discriminants and resultants of its squarefree parts instead of its discriminant.
    `reason`: why there is no equation, where there is none.
    """

    factors: tuple[fmpz_poly, ...]
    deflated: bool = False
    reason: str | None = None


def contact_equation(coefficients: Sequence[fmpz_poly]) -> ContactEquation:
    """The contact equation of a pencil with these coefficients c_0 .. c_n of det(l A - B).

    The roots 0 and infinity that cones and cylinders have for all u are taken out first; an apex on the other surface
    is a question of its own.
    """
    c = list(coefficients)
    while c and c[-1].is_zero():
        c.pop()
    while c and c[0].is_zero():
        c.pop(0)
    if not c:
        return ContactEquation((), reason=IDENTICALLY_DEGENERATE)
    if len(c) <= 2:
        return ContactEquation(())
    whole = discriminant(c)
    if not whole.is_zero():
        return ContactEquation((whole,))
    parts = squarefree_parts(c)
    factors = [discriminant(p) for p in parts if len(p) > 2]
    factors += [resultant(p, q) for k, p in enumerate(parts) for q in parts[:k]]
    return ContactEquation(tuple(factors), deflated=True)


def squarefree_parts(c: Sequence[fmpz_poly]) -> list[list[fmpz_poly]]:
    """The squarefree factors, one per multiplicity, of sum c_k l^k over Q(u): each ascending in l, degree >= 1."""
    return [part for part, _ in _squarefree(c)]


def _squarefree(c: Sequence[fmpz_poly]) -> Iterator[tuple[list[fmpz_poly], int]]:
    """As `squarefree_parts`, each with its multiplicity."""
    terms: dict[tuple[int, ...], Any] = {(k, i): x for k, p in enumerate(c) for i, x in enumerate(p.coeffs()) if x}
    polynomial = _PLANE.from_dict(terms)
    for factor, multiplicity in squarefree_factors(polynomial):
        degree = factor.degrees()[0]
        if degree:
            rows: list[dict[int, Any]] = [{} for _ in range(degree + 1)]
            for (k, i), x in factor.to_dict().items():
                rows[k][i] = x
            part = [fmpz_poly([row.get(i, 0) for i in range(max(row, default=0) + 1)]) for row in rows]
            yield part, multiplicity


def permanent_roots(c: Sequence[fmpz_poly]) -> list[tuple[fmpz_poly, fmpz_poly]]:
    """(alpha, beta) of the roots l = alpha / beta of sum c_k l^k, rational in u, that are multiple for all u; but 0."""
    found = []
    for part, multiplicity in _squarefree(c):
        if multiplicity == 1:
            continue
        if len(part) == 2:
            found.append((-part[0], part[1]))
        elif len(part) == 3:
            try:
                root = discriminant(part).sqrt()
            except DomainError:  # two that are conjugate
                continue
            found += [(s * root - part[1], 2 * part[2]) for s in (-1, 1)]
    return [(alpha, beta) for alpha, beta in found if alpha != 0]


_PLANE = fmpz_mpoly_ctx.get(("l", "u"), Ordering.lex)


# ------------------------------------------------------------------------------- multiple roots over a field


def multiple_roots(c: Sequence[D]) -> list[tuple[D, D, int]]:
    """(alpha, beta, multiplicity) of the real projective roots l = alpha / beta of multiplicity 2 or more.

    c: coefficients of a binary form of degree 2 to 4, ascending, over a field with exact signs, not all zero.
    Two conjugate double roots lie in a quadratic extension; complex ones are not returned.  One double root alone,
    the generic case, is found without divisions: over fields of high degree they dwarf everything else.
    """
    c = list(c)
    zero, one = c[0] * 0, c[0] * 0 + 1
    found = []
    at_infinity = at_zero = 0
    while is_zero(c[-1]):
        c.pop()
        at_infinity += 1
    while is_zero(c[0]):
        c.pop(0)
        at_zero += 1
    if at_zero > 1:
        found.append((zero, one, at_zero))
    if at_infinity > 1:
        found.append((one, zero, at_infinity))
    if len(c) < 3 or not is_zero(discriminant(c)):
        return found
    s0, s1 = double_root(c)
    if not is_zero(s1):
        return [*found, (-s0, s1, 2)]
    h = polynomial_gcd(c, derivative(c))
    if len(h) == 2:
        found.append((-h[0], h[1], 2))
    elif len(h) == 3:
        d = h[1] * h[1] - 4 * (h[0] * h[2])
        if is_zero(d):
            found.append((-h[1] / (2 * h[2]), one, 3))
        elif sign(d) > 0:
            root = square_root(d)
            found += [((s * root - h[1]) / (2 * h[2]), one, 2) for s in (-1, 1)]
    elif len(h) == 4:
        found.append((-h[2] / (3 * h[3]), one, 4))
    return found


def double_root(c: Sequence[N]) -> tuple[N, N]:
    """(s0, s1) of the subresultant s1 l + s0 of f and f', for degree 2, 3, 4 (up to a factor).

    Where the discriminant is zero and s1 is not, -s0 / s1 is the only multiple root, and double.
    """
    if len(c) == 3:
        return c[1], 2 * c[2]
    if len(c) == 4:
        d, x, b, a = c
        return b * x - 9 * (a * d), 2 * (b * b - 3 * (a * x))
    e, d, x, b, a = c
    # 16 a f - (4 a l + b) f' = p l^2 + q l + r
    p, q, r = 8 * (a * x) - 3 * (b * b), 12 * (a * d) - 2 * (b * x), 16 * (a * e) - b * d
    if is_zero(p):
        return r, q
    k = 3 * (b * p) - 4 * (a * q)
    pp = p * p
    return d * pp - k * r, 2 * (x * pp) - 4 * (a * (p * r)) - k * q


def derivative(c: Sequence[N]) -> list[N]:
    return [k * x for k, x in enumerate(c)][1:]


def polynomial_gcd(f: Sequence[D], g: Sequence[D]) -> list[D]:
    """A greatest common divisor over a field, ascending; [1]-like for coprime f and g."""
    f, g = list(f), list(g)
    while g:
        f, g = g, remainder(f, g)
    return f


def remainder(f: Sequence[D], g: Sequence[D]) -> list[D]:
    """f modulo g, without leading zeros."""
    r = list(f)
    while len(r) >= len(g):
        factor, shift = r[-1] / g[-1], len(r) - len(g)
        for k, x in enumerate(g[:-1]):
            r[shift + k] = r[shift + k] - factor * x
        r.pop()
        while r and is_zero(r[-1]):
            r.pop()
    while r and is_zero(r[-1]):
        r.pop()
    return r


# ------------------------------------------------------------------------------------ what happens at a root


class PencilMeeting(Enum):
    """How two quadrics meet at a singular member of their pencil."""

    POINT = "isolated contact in one point"
    TWO_POINTS = "isolated contacts in two points"
    LINE = "contact along a line"
    LINE_PAIR = "contact along two lines"
    CONIC = "contact along a conic"
    SURFACE = "the same surface"
    CROSSING = "tangent, but the surfaces cross there"
    CUSP = "tangent, with a cusp or worse in the curve of intersection"
    PLANES = "two real planes: the surfaces cross along conics"
    IMAGINARY = "no real point"
    SINGULAR = "both surfaces are singular there"

    @property
    def is_contact(self) -> bool:
        """Whether near the shared points each surface lies on one side of the other."""
        return self in _CONTACTS


_CONTACTS = frozenset({
    PencilMeeting.POINT, PencilMeeting.TWO_POINTS, PencilMeeting.LINE, PencilMeeting.LINE_PAIR,
    PencilMeeting.CONIC, PencilMeeting.SURFACE,
})  # fmt: skip


@dataclass(frozen=True, slots=True)
class Tangency:
    """The member alpha A - beta B of a pencil, a multiple root of it, and the real points shared there.

    points       homogeneous 4-vectors over the field or a quadratic extension
    lines        pairs of points
    plane, form  for a conic: a basis of its plane (three 4-vectors) and A on it (3x3)
    side         -1: the gradients of A and B are opposite there (solids {q <= 0} touch from outside); +1: equal
                 directions; 0: the member is A or B itself, the point one of its singular points (an apex)
    """

    meeting: PencilMeeting
    alpha: Any
    beta: Any
    multiplicity: int
    rank: int
    points: tuple[Vector, ...] = ()
    lines: tuple[tuple[Vector, Vector], ...] = ()
    plane: tuple[Vector, ...] = ()
    form: Rows = ()

    @property
    def side(self) -> int:
        return sign(self.alpha) * sign(self.beta)


@dataclass(frozen=True, slots=True)
class PencilContacts:
    """All tangencies of two quadrics at rest; `reason` instead where the pencil has no nonzero determinant."""

    tangencies: tuple[Tangency, ...]
    reason: str | None = None

    @property
    def contacts(self) -> tuple[Tangency, ...]:
        """Those in which the surfaces touch without crossing."""
        return tuple(t for t in self.tangencies if t.meeting.is_contact)


def pencil_contacts(a: MatrixOf[D], b: MatrixOf[D], coefficients: Sequence[D] | None = None) -> PencilContacts:
    """Where the quadrics A and B (symmetric 4x4, over one field) touch: proved complete, singular points aside.

    coefficients: those of `characteristic(a, b)` where they are known already.
    """
    c = characteristic(a, b) if coefficients is None else coefficients
    if all(is_zero(x) for x in c):
        return PencilContacts((), IDENTICALLY_DEGENERATE)
    return PencilContacts(tuple(tangency(a, b, *root) for root in multiple_roots(c)))


def member(a: Rows, b: Rows, alpha: Number, beta: Number) -> Rows:
    """alpha A - beta B."""
    return [[alpha * x - beta * y for x, y in zip(r, s, strict=True)] for r, s in zip(a, b, strict=True)]


def tangency(a: Rows, b: Rows, alpha: Number, beta: Number, multiplicity: int) -> Tangency:
    """What the multiple root alpha : beta of the pencil means (the local criterion; re-derived)."""
    g = member(a, b, alpha, beta)
    other = b if is_zero(beta) else a  # a form of the pencil independent of g
    vertex = singular_point(g)
    if vertex is not None:
        return _at_point(_Maker(alpha, beta, multiplicity, 3), g, other, vertex)
    null = null_space(g)
    make = _Maker(alpha, beta, multiplicity, 4 - len(null))
    if len(null) == 2:
        return _on_line(make, g, other, null)
    if len(null) == 3:
        return _on_plane(make, other, null)
    return make(PencilMeeting.SURFACE)


def singular_point(g: Rows) -> Vector | None:
    """The only null vector of a singular symmetric matrix, without divisions; None where there are more."""
    n = len(g)
    for i in range(n):
        minor = [[g[r][c] for c in range(n)] for r in range(n) if r != i]
        x = []
        for j in range(n):
            cofactor = determinant([[row[c] for c in range(n) if c != j] for row in minor])
            x.append(cofactor if (i + j) % 2 == 0 else -cofactor)
        if not all(is_zero(y) for y in x):
            return tuple(x)
    return None


@dataclass(frozen=True, slots=True)
class _Maker:
    alpha: Any
    beta: Any
    multiplicity: int
    rank: int
    more: dict[str, Any] = field(default_factory=dict)

    def __call__(self, meeting: PencilMeeting, **more: Any) -> Tangency:
        return Tangency(meeting, self.alpha, self.beta, self.multiplicity, self.rank, **more)


def _at_point(make: _Maker, g: Rows, other: Rows, x: Vector) -> Tangency:
    """Rank 3: the sign of g on the tangent plane at its vertex tells isolated points from crossings.

    There g has the null vector x and two more eigenvalues; their product is the second coefficient of the
    characteristic polynomial.
    """
    gradient = times(other, x)
    k = next((i for i, y in enumerate(gradient) if not is_zero(y)), None)
    if k is None:
        return make(PencilMeeting.SINGULAR, points=(x,))
    rows = [*g, gradient]
    found = filtered_sign(lambda m: _second_coefficient(m[:4], m[4], k), rows)
    meeting = {1: PencilMeeting.POINT, -1: PencilMeeting.CROSSING, 0: PencilMeeting.CUSP}[found]
    return make(meeting, points=(x,))


def _second_coefficient(g: MatrixOf[N], h: Sequence[N], k: int) -> N:
    """Sum of the principal 2x2 minors of g on the plane h: in the basis h_k e_i - h_i e_k, h_k not zero."""
    rest, scale = [i for i in range(4) if i != k], h[k]
    f = {
        (i, j): scale * (scale * g[i][j] - h[j] * g[i][k] - h[i] * g[k][j]) + h[i] * h[j] * g[k][k]
        for i in rest
        for j in rest
        if i <= j
    }
    minors = [f[i, i] * f[j, j] - f[i, j] * f[i, j] for i, j in f if i < j]
    return minors[0] + minors[1] + minors[2]


def _on_line(make: _Maker, g: Rows, other: Rows, null: list[Vector]) -> Tangency:
    """Rank 2: planes through the singular line, real or imaginary."""
    form = congruent(tuple(zip(*null, strict=True)), other)
    if all(is_zero(x) for row in form for x in row):
        return make(PencilMeeting.LINE, lines=((null[0], null[1]),))
    positive, negative, _ = inertia(g)
    if positive and negative:
        return make(PencilMeeting.PLANES, lines=((null[0], null[1]),))
    points = tuple(combination(null, y) for y in binary_zeros(form))
    return make((PencilMeeting.IMAGINARY, PencilMeeting.POINT, PencilMeeting.TWO_POINTS)[len(points)], points=points)


def _on_plane(make: _Maker, other: Rows, null: list[Vector]) -> Tangency:
    """Rank 1: a double plane; the surfaces touch wherever it meets them."""
    form = congruent(tuple(zip(*null, strict=True)), other)
    positive, negative, zero = inertia(form)
    if zero == 0:
        if positive and negative:
            return make(PencilMeeting.CONIC, plane=tuple(null), form=form)
        return make(PencilMeeting.IMAGINARY)
    kernel = [combination(null, y) for y in null_space(form)]
    if zero == 1 and positive != negative:
        return make(PencilMeeting.POINT, points=tuple(kernel))
    if zero == 2:
        return make(PencilMeeting.LINE, lines=((kernel[0], kernel[1]),))
    if zero == 3:
        return make(PencilMeeting.SINGULAR, plane=tuple(null))
    # two lines through the kernel: the zeros of the form on a line of the plane that misses it
    k = next(i for i, y in enumerate(null_space(form)[0]) if not is_zero(y))
    rest = [i for i in range(3) if i != k]
    small = [[form[i][j] for j in rest] for i in rest]
    basis = [null[i] for i in rest]
    return make(PencilMeeting.LINE_PAIR, lines=tuple((kernel[0], combination(basis, y)) for y in binary_zeros(small)))


def combination(basis: Sequence[Vector], y: Sequence[Number]) -> Vector:
    """sum y_k basis_k."""
    total = [y[0] * x for x in basis[0]]
    for k in range(1, len(basis)):
        total = [t + y[k] * x for t, x in zip(total, basis[k], strict=True)]
    return tuple(total)


def binary_zeros(form: MatrixOf[D]) -> list[tuple[D, D]]:
    """The real zeros (s, t) of a nonzero form p s^2 + 2 q s t + r t^2, given as the matrix (p, q; q, r)."""
    (p, q), (_, r) = form
    d = q * q - p * r
    s = sign(d)
    if s < 0:
        return []
    one = d * 0 + 1
    if s == 0:
        return [(one, one * 0)] if is_zero(p) and is_zero(q) else [(-q, p)]
    if is_zero(p):
        return [(one, one * 0), (-r, 2 * q)]
    root = square_root(d)
    return [(-q - root, p), (-q + root, p)]
