"""Matrices of integer polynomials in the motion parameter u: poses, quadrics and planes as projective objects.

A matrix is known up to a positive factor only, so that the signs of its forms keep their meaning.  Every function
here multiplies or divides by positive numbers, or by polynomials that are positive on the span.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations
from math import gcd, lcm
from typing import TYPE_CHECKING, Any

from flint import arb, fmpq, fmpz_poly

from firstcontact.exact.fields.roots import real_roots
from firstcontact.exact.polynomials.inertia import dot

if TYPE_CHECKING:
    from firstcontact.exact.ring import N

Matrix = tuple[tuple[fmpz_poly, ...], ...]

_0 = fmpz_poly([0])


def constant(rows: Iterable[Iterable[fmpq]]) -> Matrix:
    """The matrix of these rationals, cleared of denominators and of common divisors: a positive multiple."""
    entries = [[fmpq(x) for x in row] for row in rows]
    scale = lcm(*(int(x.q) for row in entries for x in row))
    divisor = gcd(*(int(x.p) * (scale // int(x.q)) for row in entries for x in row)) or 1
    factor = fmpq(scale, divisor)
    return tuple(tuple(fmpz_poly([(x * factor).p]) for x in row) for row in entries)


def evaluate(m: Matrix, u: fmpq | arb) -> tuple[tuple[fmpq | arb, ...], ...]:
    """The matrix at u: an fmpq or a ball."""
    return tuple(tuple(x(u) for x in row) for row in m)


def transpose(m: Sequence[Sequence[N]]) -> tuple[tuple[N, ...], ...]:
    return tuple(zip(*m, strict=True))


def product(m: Sequence[Sequence[N]], n: Sequence[Sequence[N]]) -> tuple[tuple[N, ...], ...]:
    """m n, for entries of any ring."""
    columns = tuple(zip(*n, strict=True))
    return tuple(tuple(dot(row, column) for column in columns) for row in m)


def congruent(p: Sequence[Sequence[N]], q: Sequence[Sequence[N]]) -> tuple[tuple[N, ...], ...]:
    """P^T Q P for a symmetric Q (n, n) and P (n, k): the form Q on the points P y, (k, k)."""
    columns = tuple(zip(*p, strict=True))
    images = [tuple(dot(row, column) for row in q) for column in columns]  # Q P, column by column
    k = len(columns)
    upper: list[list[Any]] = [[dot(columns[i], images[j]) if i <= j else None for j in range(k)] for i in range(k)]
    return tuple(tuple(upper[min(i, j)][max(i, j)] for j in range(k)) for i in range(k))


def determinant(m: Sequence[Sequence[N]]) -> N:
    """Determinant of a square matrix up to 4x4, without divisions: entries of any commutative ring."""
    n = len(m)
    if n == 1:
        return m[0][0]
    if n == 2:
        return m[0][0] * m[1][1] - m[0][1] * m[1][0]
    if n == 3:
        (a, b, c), (d, e, f), (g, h, i) = m
        return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    # Laplace along the first two rows
    p, q, r, s = m
    total: Any = None
    for (first, second), (third, fourth), sign in _LAPLACE:
        term = (p[first] * q[second] - p[second] * q[first]) * (r[third] * s[fourth] - r[fourth] * s[third])
        total = term if total is None else total + term if sign > 0 else total - term
    return total


# column pairs of rows 1, 2, of rows 3, 4, and the sign of the term; the first sign is +
_LAPLACE = (
    ((0, 1), (2, 3), 1),
    ((0, 2), (1, 3), -1),
    ((0, 3), (1, 2), 1),
    ((1, 2), (0, 3), 1),
    ((1, 3), (0, 2), -1),
    ((2, 3), (0, 1), 1),
)


def adjugate(m: Sequence[Sequence[N]]) -> tuple[tuple[N, ...], ...]:
    """adj(m) with m adj(m) = det(m) I, for 2x2 to 4x4."""
    n = len(m)
    rows = []
    for i in range(n):
        row = []
        for j in range(n):  # cofactor of entry (j, i)
            minor = tuple(tuple(m[r][c] for c in range(n) if c != i) for r in range(n) if r != j)
            value = determinant(minor)
            row.append(value if (i + j) % 2 == 0 else -value)
        rows.append(tuple(row))
    return tuple(rows)


def minors(m: Sequence[Sequence[N]], k: int) -> list[N]:
    """All k x k minors; they vanish together exactly where the rank is below k."""
    columns = list(combinations(range(len(m[0])), k))
    return [
        determinant(tuple(tuple(row[c] for c in chosen) for row in rows))
        for rows in combinations(m, k)
        for chosen in columns
    ]


def content(m: Sequence[Sequence[fmpz_poly]]) -> fmpz_poly:
    """The greatest common divisor of all entries, leading coefficient positive; zero for the zero matrix."""
    divisor = _0
    for row in m:
        for x in row:
            divisor = divisor.gcd(x)
            if divisor.is_one():
                return divisor
    return divisor


def primitive(m: Sequence[Sequence[fmpz_poly]], span: tuple[fmpq, fmpq] | None = None) -> Matrix:
    """The matrix divided by the integer content and, given a closed span of u, by the common factors without a
    root there, each with the sign that makes it positive on the span.
    """
    whole = content(m)
    if whole.is_zero():
        return tuple(tuple(row) for row in m)
    divisor = fmpz_poly([whole.content()])
    if span is not None and whole.degree() > 0:
        lo, hi = span
        for factor, power in whole.factor()[1]:
            if not real_roots(factor, lo, hi):
                divisor *= (factor if factor(lo) > 0 else -factor) ** power
    if divisor.is_one():
        return tuple(tuple(row) for row in m)
    return tuple(tuple(x // divisor for x in row) for row in m)
