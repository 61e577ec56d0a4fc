"""Poses as 4x4 matrices of integer polynomials in one variable u, up to a positive factor.

The last row is (0, 0, 0, w); a point (x, y, z) goes to the first three entries of M (x, y, z, 1), divided by w.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from flint import fmpq, fmpq_poly, fmpz, fmpz_poly

from firstcontact.exact import rigid
from firstcontact.exact.rigid import Matrix as Fixed

Matrix = tuple[tuple[fmpz_poly, ...], ...]
_NIL, _ONE = fmpz_poly([0]), fmpz_poly([1])


def integral(rows: Iterable[Iterable[fmpq_poly]]) -> Matrix:
    """The matrix times the least common denominator of its coefficients."""
    entries = [[fmpq_poly(x) for x in row] for row in rows]
    below = fmpz(1)
    for row in entries:
        for x in row:
            below = below.lcm(x.denom())
    return tuple(tuple((x * below).numer() for x in row) for row in entries)


def reduced(m: Matrix, u: fmpq) -> Matrix:
    """m over the common factor of its entries, numbers and polynomials, with positive weight at u.

    The factor divides the weight: where the weight has no zero, neither has the factor.
    """
    common = _NIL
    for row in m:
        for x in row:
            common = common.gcd(x)
    if (m[3][3](u) > 0) != (common(u) > 0):
        common = -common
    return tuple(tuple(x // common for x in row) for row in m)


def fixed(m: Fixed) -> Matrix:
    """The constant matrix of a pose (3x4, rational)."""
    zero, one = fmpq_poly([0]), fmpq_poly([1])
    return integral([*([fmpq_poly([x]) for x in row] for row in m), [zero, zero, zero, one]])


IDENTITY = fixed(rigid.IDENTITY)


def product(m: Matrix, n: Matrix) -> Matrix:
    """The map "first n, then m"."""
    columns = list(zip(*n, strict=True))
    return tuple(tuple(sum((a * b for a, b in zip(row, c, strict=True)), _NIL) for c in columns) for row in m)


def substituted(m: Matrix, argument: fmpq_poly) -> Matrix:
    """m with u replaced by a polynomial in another variable."""
    return integral([[fmpq_poly(x)(argument) for x in row] for row in m])


def degree(m: Matrix) -> int:
    """The highest degree of an entry."""
    return max(x.degree() for row in m for x in row)


def linear_determinant(m: Matrix) -> fmpz_poly:
    """det of the upper left 3x3 part."""
    (a, b, c, _), (d, e, f, _), (g, h, i, _) = m[:3]
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def square_scale(m: Matrix) -> fmpz_poly | None:
    """s with R R^T = s for the linear part R (a rotation or reflection, scaled), else None."""
    gram = [[sum((x * y for x, y in zip(p[:3], q[:3], strict=True)), _NIL) for q in m[:3]] for p in m[:3]]
    s = gram[0][0]
    return s if all(gram[i][j] == (s if i == j else _NIL) for i in range(3) for j in range(3)) else None


def is_rigid(m: Matrix) -> bool:
    """Whether the linear part is a rotation times the weight, exactly; the weight must be positive."""
    w = m[3][3]
    return square_scale(m) == w * w and linear_determinant(m) == w * w * w


def inverse(m: Matrix, u: fmpq) -> Matrix:
    """The inverse map, reduced, with positive weight at u: by the transpose where R R^T = s, else the adjugate.

    (R v; 0 w)^-1 = (w R^-1, -R^-1 v; 0, 1) / w, with R^-1 = R^T / s or adj(R) / det(R).
    """
    s, w = square_scale(m), m[3][3]
    linear: Sequence[Sequence[fmpz_poly]]
    if s is not None:
        linear, scale = list(zip(*(row[:3] for row in m[:3]), strict=True)), s
    else:
        linear, scale = _adjugate(m), linear_determinant(m)
    rows = [
        (*(w * x for x in row), -sum((x * m[k][3] for k, x in enumerate(row)), _NIL)) for row in linear
    ]
    return reduced((*rows, (_NIL, _NIL, _NIL, scale)), u)


def _adjugate(m: Matrix) -> list[list[fmpz_poly]]:
    (a, b, c, _), (d, e, f, _), (g, h, i, _) = m[:3]
    return [
        [e * i - f * h, c * h - b * i, b * f - c * e],
        [f * g - d * i, a * i - c * g, c * d - a * f],
        [d * h - e * g, b * g - a * h, a * e - b * d],
    ]


def value(m: Matrix, u: Any) -> list[list[Any]]:
    """The affine 4x4 pose at u, divided by the weight: fmpq for rational u, balls for a ball."""
    w = m[3][3](u)
    return [[x(u) / w for x in row] for row in m]


def of_quaternion(q: Sequence[fmpq_poly], vector: Sequence[fmpq_poly]) -> list[list[fmpq_poly]]:
    """(|q|^2 R, |q|^2 vector; 0, |q|^2) for the rotation R of the quaternion polynomial (w, x, y, z)."""
    w, x, y, z = q
    n, zero = w * w + x * x + y * y + z * z, fmpq_poly([0])
    return [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y), n * vector[0]],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x), n * vector[1]],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z, n * vector[2]],
        [zero, zero, zero, n],
    ]
