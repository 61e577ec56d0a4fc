"""What the algebraic pair files share: contact equations, contact sets, and linear algebra at one root.

An *equation* is a polynomial in the motion parameter u whose real roots contain every u at which the two carriers
touch; at one of its roots a pair file gives the *contact set* over the number field of that root, or says why the
root carries none.  Everything is homogeneous and free of divisions, so the functions below run on any exact field
(fmpq, `NumberField`, `Radical` over either).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any, Literal

from flint import arb, fmpq, fmpz_poly

from firstcontact.exact.number_field import NumberField
from firstcontact.exact.numbers import precision
from firstcontact.exact.polynomial_matrix import Matrix, determinant
from firstcontact.exact.roots import AlgebraicRoot

Vector = tuple[Any, ...]
Form = tuple[tuple[Any, ...], ...]

ONE = fmpz_poly([1])
ZERO = fmpz_poly([0])

CROSSING = "crossing tangency"
AT_INFINITY = "at infinity"
IMAGINARY = "imaginary"
PARALLEL = "planes parallel"


@dataclass(frozen=True)
class Equation:
    """Contact equation of two carriers: `polynomial`, or None and the `reason` why this pair needs none.

    polynomial  every u at which the carriers touch is a root, but for those of `parallel`
    parallel    its real roots are the u at which the carriers' planes are parallel or equal (cases VII, VIII, IX);
                its multiplicity is the one the paper's representation of the common line gives them
    """

    polynomial: fmpz_poly | None
    reason: str = ""
    parallel: fmpz_poly = ONE

    @property
    def candidates(self) -> fmpz_poly | None:
        """The polynomial whose real roots, with multiplicity, are the candidate times of Choi et al. 2014."""
        return None if self.polynomial is None else self.polynomial * self.parallel


@dataclass(frozen=True)
class Contact:
    """One connected real contact set of two whole carriers, in the frame they were given in.

    kind        "point", "line" or "conic"
    span        homogeneous 4-vectors: the point, two points of the line, three points of the conic's plane
    form        for a conic: symmetric 3x3 C, the points sum(y_i span[i]) with y^T C y = 0; else None
    multiplier  sign of l0 where the contact is a null vector of l0 A - B (cases I, III, VIII); solids that touch from
                outside have -1 in case I, +1 says that one is inside the other; 0 where nothing is defined
    note        "" or what the carriers do there: "crossing tangency", "apex", "inside the surface" ...
    """

    kind: Literal["point", "line", "conic"]
    span: tuple[Vector, ...]
    form: Form | None = None
    multiplier: int = 0
    note: str = ""

    def point(self, bits: int = 128) -> tuple[arb, arb, arb]:
        """Balls of the Cartesian coordinates of the point; `bits` more give as many more digits."""
        if self.kind != "point":
            raise ValueError(f"a {self.kind} is not a point")
        x = [coordinate.ball(bits) for coordinate in self.span[0]]
        with precision(bits):
            return x[0] / x[3], x[1] / x[3], x[2] / x[3]


@dataclass(frozen=True)
class Contacts:
    """Real contact sets at one root, and the reason when there are none (or what the root is besides)."""

    found: tuple[Contact, ...]
    reason: str = ""


def nothing(reason: str) -> Contacts:
    return Contacts((), reason)


class Radical:
    """x + y sqrt(d), d > 0, over a field whose elements have `sign` and `ball`, or over Radicals of another d."""

    __slots__ = ("d", "depth", "x", "y")

    def __init__(self, x: Any, y: Any, d: Any) -> None:
        self.x, self.y, self.d = x, y, d
        self.depth: int = 1 + getattr(d, "depth", 0)

    def __add__(self, other: Any) -> Radical:
        depth = getattr(other, "depth", 0)
        if depth > self.depth:
            return Radical(other.x + self, other.y, other.d)
        if depth == self.depth:
            return Radical(self.x + other.x, self.y + other.y, self.d)
        return Radical(self.x + other, self.y, self.d)

    __radd__ = __add__

    def __neg__(self) -> Radical:
        return Radical(-self.x, -self.y, self.d)

    def __sub__(self, other: Any) -> Radical:
        return self + (-other)

    def __rsub__(self, other: Any) -> Radical:
        return -self + other

    def __mul__(self, other: Any) -> Radical:
        depth = getattr(other, "depth", 0)
        if depth > self.depth:
            return Radical(other.x * self, other.y * self, other.d)
        if depth == self.depth:
            return Radical(self.x * other.x + self.y * other.y * self.d, self.x * other.y + self.y * other.x, self.d)
        return Radical(self.x * other, self.y * other, self.d)

    __rmul__ = __mul__

    def sign(self) -> int:
        """Exact: equal signs decide, otherwise x^2 against y^2 d."""
        s, r = sign(self.x), sign(self.y)
        if s == r or r == 0:
            return s
        return r if s == 0 else s * sign(self.x * self.x - self.y * self.y * self.d)

    def is_zero(self) -> bool:
        return self.sign() == 0

    def ball(self, bits: int) -> arb:
        parts = [ball_of(part, bits) for part in (self.x, self.y, self.d)]
        with precision(bits):
            return parts[0] + parts[1] * parts[2].sqrt()


def sign(x: Any) -> int:
    """Sign of a field element, of an fmpq or of an int."""
    return (x > 0) - (x < 0) if isinstance(x, int | fmpq) else x.sign()


def ball_of(x: Any, bits: int) -> arb:
    if isinstance(x, int | fmpq):
        with precision(bits):
            return arb(x)
    return x.ball(bits)


# --- polynomials -------------------------------------------------------------------------------------------------


def without(p: fmpz_poly, factor: fmpz_poly) -> fmpz_poly:
    """p divided by every power of every factor that it shares with `factor`."""
    while p.degree() > 0 and (g := p.gcd(factor)).degree() > 0:
        p = p // g
    return p


def common_factor(entries: Any) -> fmpz_poly:
    """Greatest common divisor of the polynomials; 0 when all vanish."""
    g = ZERO
    for p in entries:
        g = g.gcd(p)
        if g.is_one():
            break
    return g


def columns(matrix: Matrix) -> tuple[Vector, ...]:
    return tuple(zip(*matrix, strict=True))


def dot(x: Any, y: Any) -> Any:
    total = x[0] * y[0]
    for a, b in zip(x[1:], y[1:], strict=True):
        total = total + a * b
    return total


def pull_plane(basis: Matrix, plane: Vector) -> Vector:
    """P^T N: the plane N as a linear form of the parameters of the carrier P."""
    return tuple(dot(column, plane) for column in columns(basis))


def cross(x: Vector, y: Vector) -> Vector:
    return x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]


def determinant3(a: Vector, b: Vector, c: Vector) -> Any:
    return dot(cross(a, b), c)


def plane_through(a: Vector, b: Vector, c: Vector) -> Vector:
    """The plane N of three points, N.X = det[a b c X]."""
    minors = []
    for k in range(4):
        rows = [i for i in range(4) if i != k]
        minor = determinant3(*(tuple(v[i] for i in rows) for v in (a, b, c)))
        minors.append(minor if k % 2 else -minor)
    return tuple(minors)


def left_inverse(basis: Matrix) -> tuple[Matrix, Any]:
    """(S, s) with S P = s I (3x4 times 4x3), s = N.N the square of the plane of P, hence positive."""
    a, b, c = columns(basis)
    plane = plane_through(a, b, c)
    # The plane of two columns and the vector N contains no third column: det[b c N a] = -det[a b c N] up to order.
    rows = (plane_through(b, c, plane), plane_through(c, a, plane), plane_through(a, b, plane))
    s = dot(rows[0], a)
    positive = dot(plane, plane)
    if s != positive:
        rows = tuple(tuple(-x for x in row) for row in rows)  # type: ignore[assignment]
    return rows, positive


# --- at one root -------------------------------------------------------------------------------------------------


def at(field: NumberField, matrix: Any) -> Form:
    """The matrix over fmpz_poly with its entries in the number field of the root."""
    return tuple(tuple(field(p) for p in row) for row in matrix)


def vector_at(field: NumberField, vector: Vector) -> Vector:
    return tuple(field(p) for p in vector)


def number_field(root: AlgebraicRoot) -> NumberField:
    return NumberField(root)


def zero(vector: Any) -> bool:
    return all(x.is_zero() for x in vector)


def apply(matrix: Form, vector: Vector) -> Vector:
    return tuple(dot(row, vector) for row in matrix)


def combine(basis: tuple[Vector, ...], y: Vector) -> Vector:
    """sum y_i basis[i]."""
    return apply(tuple(zip(*basis, strict=True)), y)


def value(form: Form, x: Vector) -> Any:
    return dot(apply(form, x), x)


def restrict(form: Form, basis: tuple[Vector, ...]) -> Form:
    """The symmetric form on the span of `basis`."""
    images = [apply(form, b) for b in basis]
    rows = [[dot(images[i], basis[j]) if j >= i else None for j in range(len(basis))] for i in range(len(basis))]
    return tuple(tuple(rows[min(i, j)][max(i, j)] for j in range(len(basis))) for i in range(len(basis)))


def null_space(form: Form) -> tuple[Vector, ...]:
    """A basis of the null space of a symmetric n x n form, n <= 4, by Cramer's rule.

    A symmetric form of rank r has a nonzero principal minor of size r and every larger one vanishes.
    """
    n = len(form)
    for r in range(n, 0, -1):
        for kept in combinations(range(n), r):
            block = [[form[i][j] for j in kept] for i in kept]
            d = determinant(block)
            if not d.is_zero():
                return tuple(_cramer(form, kept, j, d) for j in range(n) if j not in kept)
    one = form[0][0] * 0 + 1
    return tuple(tuple(one if i == j else one * 0 for i in range(n)) for j in range(n))


def _cramer(form: Form, kept: tuple[int, ...], j: int, d: Any) -> Vector:
    """The null vector whose free coordinate j is d = det of the block `kept`, the other free ones 0."""
    solution: list[Any] = [d * 0] * len(form)
    solution[j] = d
    for position, k in enumerate(kept):
        block = [[form[i][j] if at == position else form[i][c] for at, c in enumerate(kept)] for i in kept]
        solution[k] = -determinant(block)
    return tuple(solution)


def binary_roots(form: Form) -> list[Vector]:
    """Real points (s, t) of s^2 a + 2 s t b + t^2 c = 0, not identically zero: none, one (double) or two.

    Coordinates stay in the field for one point and are `Radical`s over it for two, unless a or c vanishes.
    """
    (a, b), (_, c) = form
    zero_ = a * 0
    if a.is_zero() and c.is_zero():
        return [(zero_ + 1, zero_), (zero_, zero_ + 1)]
    d = b * b - a * c
    side = d.sign()
    if side < 0:
        return []
    if a.is_zero():
        return [(zero_ + 1, zero_)] if side == 0 else [(zero_ + 1, zero_), (-c, 2 * b)]
    if c.is_zero():
        return [(zero_, zero_ + 1)] if side == 0 else [(zero_, zero_ + 1), (-2 * b, a)]
    if side == 0:
        return [(-b, a)]
    return [(Radical(-b, zero_ + r, d), Radical(a, zero_, d)) for r in (1, -1)]


def finite(span: tuple[Vector, ...], **fields: Any) -> Contacts:
    """The contact set with that span, or "at infinity" when no point of it is finite."""
    if all(x[3].is_zero() for x in span):
        return nothing(AT_INFINITY)
    kind: Any = ("point", "line", "conic")[len(span) - 1]
    return Contacts((Contact(kind, span, **fields),))


def gather(sets: list[Contacts], otherwise: str) -> Contacts:
    """All of them in one; the reasons of the empty ones, or `otherwise` when there is no set at all."""
    found = tuple(contact for s in sets for contact in s.found)
    reasons = dict.fromkeys(s.reason for s in sets if s.reason)
    return Contacts(found, "; ".join(reasons) or ("" if found else otherwise))
