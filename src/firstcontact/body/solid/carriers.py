"""Carriers of features: complete planes, quadrics, lines, conics, points and degree-4 curves, exact, without trimming.

Points are homogeneous columns X = (x, y, z, w).  Surfaces are forms: a plane N.X, a quadric X^T Q X, both negative
inside their half-space.  Curves and points are parameter matrices P: their points are X = P y.  Under a pose M a
curve becomes M P with the same form in y; planes and quadrics go by the inverse of M (Choi et al. 2014, section 3).
All entries are fmpq; forms are kept as coprime integers, scaled by positive factors only, so that signs keep meaning.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from operator import mul
from typing import Any

from flint import arb, fmpq, fmpq_mat, fmpz

from firstcontact.exact.numbers import to_double
from firstcontact.exact.vectors import cross

Vector = tuple[fmpq, ...]
Rows = tuple[Vector, ...]
"""A matrix as a tuple of its rows."""
Box = tuple[Vector, Vector]
"""Lower and upper corner."""

ZERO, ONE = fmpq(0), fmpq(1)


@dataclass(frozen=True, slots=True)
class Plane:
    """The half-space N.X <= 0 and its plane; normal: (a, b, c, d) for a x + b y + c z + d."""

    normal: Vector

    @property
    def basis(self) -> Rows:
        """4x3: two orthogonal directions of the plane and its point nearest the origin."""
        a, b, c, d = self.normal
        n = (a, b, c)
        k = min(range(3), key=lambda i: abs(n[i]))
        first = primitive(cross(n, tuple(ONE if i == k else ZERO for i in range(3))))
        second = primitive(cross(n, first))
        square = dot(n, n)
        foot = tuple(-d * x / square for x in n)
        return columns((*first, ZERO), (*second, ZERO), (*foot, ONE))

    def value(self, x: Sequence[Any]) -> Any:
        return dot(self.normal, x)

    def gradient(self, x: Sequence[fmpq | arb]) -> Vector:
        return self.normal[:3]

    def polar(self, x: Vector, y: Vector) -> fmpq:
        """The symmetric bilinear form of N.X times w."""
        twice: fmpq = dot(self.normal, x) * y[3] + dot(self.normal, y) * x[3]
        return twice / 2

    def matrix(self) -> Rows:
        """The form N.X times w as a symmetric 4x4 matrix."""
        a, b, c, d = (x / 2 for x in self.normal)
        return ((ZERO, ZERO, ZERO, a), (ZERO, ZERO, ZERO, b), (ZERO, ZERO, ZERO, c), (a, b, c, 2 * d))

    def placed(self, inverse: Rows) -> Plane:
        """The plane under the map whose inverse is given."""
        return Plane(primitive(times(transposed(inverse), columns(self.normal))[i][0] for i in range(4)))

    def negated(self) -> Plane:
        return Plane(tuple(-x for x in self.normal))


@dataclass(frozen=True, slots=True)
class Quadric:
    """The solid X^T Q X <= 0 and its surface; form: Q, symmetric 4x4."""

    form: Rows

    def value(self, x: Sequence[Any]) -> Any:
        return sum(x[i] * self.form[i][j] * x[j] for i in range(4) for j in range(4))

    def gradient(self, x: Sequence[Any]) -> Any:
        return tuple(2 * sum(self.form[i][j] * x[j] for j in range(4)) for i in range(3))

    def polar(self, x: Vector, y: Vector) -> fmpq:
        value: fmpq = bilinear(self.form, x, y)
        return value

    def matrix(self) -> Rows:
        return self.form

    def placed(self, inverse: Rows) -> Quadric:
        return Quadric(primitive_rows(restricted(self.form, inverse)))

    def negated(self) -> Quadric:
        return Quadric(tuple(tuple(-x for x in row) for row in self.form))

    @property
    def apex(self) -> Vector | None:
        """The finite singular point (x, y, z, 1) of a cone, None for every other quadric."""
        kernel = null_space(self.form)
        if len(kernel) != 1 or kernel[0][3] == 0:
            return None
        return tuple(x / kernel[0][3] for x in kernel[0])


Surface = Plane | Quadric


@dataclass(frozen=True, slots=True)
class Line:
    """Points P (s, 1)^T; basis: P, 4x2, a direction (w = 0) and a point (w = 1)."""

    basis: Rows

    def placed(self, matrix: Rows) -> Line:
        return Line(times(matrix, self.basis))


@dataclass(frozen=True, slots=True)
class Conic:
    """Points P y with y^T C y = 0; basis: P, 4x3, spans the plane; form: C, symmetric 3x3.

    C has rank 3, or rank 2 when the conic is a pair of real lines that no rational matrix describes.
    """

    basis: Rows
    form: Rows

    def placed(self, matrix: Rows) -> Conic:
        return Conic(times(matrix, self.basis), self.form)


@dataclass(frozen=True, slots=True)
class Point:
    """One point; basis: 4x1."""

    basis: Rows

    def placed(self, matrix: Rows) -> Point:
        return Point(times(matrix, self.basis))


@dataclass(frozen=True, slots=True)
class AlgebraicPoint:
    """(x, y, z, 1), each a polynomial in one root of an irreducible polynomial.

    polynomial: integers, ascending; lo, hi: rational ends of an interval with that root and no other.
    coordinates: x, y, z as ascending rational coefficients, of lower degree than the polynomial.
    """

    polynomial: Vector
    lo: fmpq
    hi: fmpq
    coordinates: Rows


@dataclass(frozen=True, slots=True)
class EnclosedPoint:
    """A common point of three surfaces near `centre`.

    proved: it exists in the box of half-width `radius` about the centre, and no second one does (Krawczyk's test).
    Not so where the gradients of the surfaces are dependent: then `radius` is the last step of Newton's method.
    """

    centre: Vector
    radius: fmpq
    proved: bool


@dataclass(frozen=True, slots=True)
class QuarticCurve:
    """The common curve of two quadrics: of degree 4, or conics in planes that no rational matrix describes."""

    first: Quadric
    second: Quadric

    def placed(self, matrix: Rows) -> QuarticCurve:
        back = inverse(matrix)
        return QuarticCurve(self.first.placed(back), self.second.placed(back))


Curve = Line | Conic | QuarticCurve


# -- small exact matrices -----------------------------------------------------------------------------------


def dot(x: Sequence[Any], y: Sequence[Any]) -> Any:
    return sum(map(mul, x, y))


def bilinear(form: Rows, x: Sequence[Any], y: Sequence[Any]) -> Any:
    """x^T form y."""
    return sum((a * dot(row, y) for a, row in zip(x, form, strict=True) if a), ZERO)


def transposed(rows: Rows) -> Rows:
    return tuple(zip(*rows, strict=True))


def columns(*vectors: Sequence[fmpq]) -> Rows:
    """The matrix with these columns."""
    return tuple(zip(*vectors, strict=True))


def times(first: Rows, second: Rows) -> Rows:
    other = transposed(second)
    return tuple(tuple(dot(row, column) for column in other) for row in first)


def restricted(form: Rows, basis: Rows) -> Rows:
    """P^T form P."""
    return times(transposed(basis), times(form, basis))


def inverse(rows: Rows) -> Rows:
    return tuple(tuple(row) for row in fmpq_mat([list(row) for row in rows]).inv().tolist())


def null_space(rows: Rows) -> list[Vector]:
    """A basis of the vectors that the matrix maps to zero, coprime integers."""
    reduced, rank = fmpq_mat([list(row) for row in rows]).rref()
    n = len(rows[0])
    pivots = [next(j for j in range(n) if reduced[i, j] != 0) for i in range(rank)]
    basis = []
    for free in (j for j in range(n) if j not in pivots):
        vector = [ZERO] * n
        vector[free] = ONE
        for i, pivot in enumerate(pivots):
            vector[pivot] = -reduced[i, free]
        basis.append(primitive(vector))
    return basis


NEARLY_NONE = fmpq(1, 10**6)
"""Of the largest value of a form at vectors of one length."""


def diagonalised(form: Rows) -> list[tuple[fmpq, Vector]]:
    """(value, column) pairs, independent and mutually conjugate columns with values column^T form column.

    Lagrange's reduction: exact, and the signs of the values are the inertia of the form.  Values that are nearly 0, as
    along the axis of a cylinder that is turned by rounding, are divided by last: the columns stay short.
    """
    n = len(form)
    rest = [tuple(ONE if i == j else ZERO for i in range(n)) for j in range(n)]
    found: list[tuple[fmpq, Vector]] = []
    while rest:
        sizes = [abs(bilinear(form, v, v)) / max(x * x for x in v) for v in rest]
        least = NEARLY_NONE * max(sizes)
        pivot = next((v for v, size in zip(rest, sizes, strict=True) if size > least), None)
        if pivot is None:
            pair = next(((v, w) for v in rest for w in rest if bilinear(form, v, w)), None)
            if pair is None:
                return found + [(ZERO, v) for v in rest]
            rest[rest.index(pair[0])] = pivot = tuple(a + b for a, b in zip(*pair, strict=True))
        value = bilinear(form, pivot, pivot)
        found.append((value, pivot))
        rest.remove(pivot)
        shares = [bilinear(form, pivot, v) / value for v in rest]
        rest = [
            primitive(a - k * b for a, b in zip(v, pivot, strict=True)) if k else primitive(v)
            for v, k in zip(rest, shares, strict=True)
        ]
    return found


def scaled_axes(form: Rows) -> Rows:
    """Columns as in `diagonalised` whose values are about +-1 (or 0): what is narrow looks wide in this frame."""
    return columns(*(tuple(x / rough_root(abs(value)) for x in vector) for value, vector in diagonalised(form)))


def rough_root(value: fmpq) -> fmpq:
    """A power of two, less than twice and more than half the square root; 1 for 0."""
    exponent = (int(value.p).bit_length() - int(value.q).bit_length()) // 2 if value else 0
    return fmpq(2) ** exponent if exponent >= 0 else 1 / fmpq(2) ** -exponent


def inertia(form: Rows) -> tuple[int, int]:
    """How many positive and negative squares the form is a sum of."""
    values = [value for value, _ in diagonalised(form)]
    return sum(v > 0 for v in values), sum(v < 0 for v in values)


def primitive(vector: Iterable[fmpq]) -> Vector:
    """The positive multiple with coprime integers (zero stays zero)."""
    values = tuple(vector)
    common, content = fmpz(1), fmpz(0)
    for x in values:
        common = common.lcm(x.q)
    for x in values:
        content = content.gcd((x * common).p)
    return values if content == 0 else tuple(x * common / content for x in values)


def primitive_rows(rows: Rows) -> Rows:
    flat = primitive(x for row in rows for x in row)
    n = len(rows[0])
    return tuple(flat[i : i + n] for i in range(0, len(flat), n))


def upright(vector: Vector) -> Vector:
    """The multiple with coprime integers whose first nonzero one is positive."""
    values = primitive(vector)
    return values if next((x for x in values if x), ONE) > 0 else tuple(-x for x in values)


def doubles(rows: Rows) -> list[list[float]]:
    """The matrix divided by its largest entry (integers of exact rotations exceed all doubles), rounded."""
    largest = max((abs(x) for row in rows for x in row), default=ONE) or ONE
    return [[to_double(x / largest) for x in row] for row in rows]
