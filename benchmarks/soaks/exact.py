"""Vectors, 4x4 matrices and rotations over fractions, and their text; what oracles of curved scenes compute with."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction as F
from math import isqrt
from random import Random
from typing import Any

from flint import arb, ctx, fmpq

Vector = tuple[Any, Any, Any]
Matrix = list[list[Any]]

UNITS = tuple(
    tuple(F(x, d) for x in v)
    for *v, d in ((0, 0, 1, 1), (3, 4, 0, 5), (1, 2, 2, 3), (2, 3, 6, 7), (5, 12, 0, 13), (4, 4, 7, 9), (1, 4, 8, 9))
)
ANGLES = tuple((F(a, c), F(b, c)) for a, b, c in ((3, 4, 5), (4, 3, 5), (5, 12, 13), (12, 5, 13), (8, 15, 17)))
"""Cosine and sine of angles strictly within the first quadrant."""


def add(p: Sequence[Any], q: Sequence[Any]) -> Vector:
    return (p[0] + q[0], p[1] + q[1], p[2] + q[2])


def sub(p: Sequence[Any], q: Sequence[Any]) -> Vector:
    return (p[0] - q[0], p[1] - q[1], p[2] - q[2])


def scale(k: Any, p: Sequence[Any]) -> Vector:
    return (k * p[0], k * p[1], k * p[2])


def dot(p: Sequence[Any], q: Sequence[Any]) -> Any:
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


def cross(p: Sequence[Any], q: Sequence[Any]) -> Vector:
    return (p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0])


def length(p: Sequence[Any]) -> float:
    """Without under- or overflow of squares."""
    top = max(abs(float(x)) for x in p)
    return top * sum((float(x) / top) ** 2 for x in p) ** 0.5 if top else 0.0


def root(x: F, bits: int = 200) -> F:
    """The square root, `bits` significant bits."""
    if x <= 0:
        return F(0)
    shift = max(0, 2 * bits - x.numerator.bit_length() + x.denominator.bit_length()) // 2 + 1
    return F(isqrt((x.numerator << 2 * shift) // x.denominator), 1 << shift)


def fraction(x: arb) -> F:
    man, exp = x.mid().man_exp()
    return F(int(man)) * F(2) ** int(exp)


def turned(turns: F) -> tuple[F, F]:
    """Cosine and sine of a part of a full turn: exact for quarters, otherwise to 180 bits."""
    quarters = 4 * turns
    if quarters.denominator == 1:
        return ((F(1), F(0)), (F(0), F(1)), (F(-1), F(0)), (F(0), F(-1)))[quarters.numerator % 4]
    before, ctx.prec = ctx.prec, 220
    try:
        angle = arb(fmpq(2 * turns.numerator, turns.denominator))
        return fraction(angle.cos_pi()), fraction(angle.sin_pi())
    finally:
        ctx.prec = before


IDENTITY: Matrix = [[F(int(i == j)) for j in range(4)] for i in range(4)]


def product(m: Matrix, n: Matrix) -> Matrix:
    """Of affine 4x4 matrices."""
    rows = [[sum((m[i][k] * n[k][j] for k in range(3)), m[i][3] * (j == 3)) for j in range(4)] for i in range(3)]
    return [*rows, IDENTITY[3]]


def inverse(m: Matrix) -> Matrix:
    a, b, c = (m[i][:3] for i in range(3))
    rows = [cross(b, c), cross(c, a), cross(a, b)]
    det = dot(a, rows[0])
    lin = [[rows[j][i] / det for j in range(3)] for i in range(3)]
    shift = [m[i][3] for i in range(3)]
    return [*([*row, -dot(row, shift)] for row in lin), IDENTITY[3]]


def apply(m: Matrix, p: Sequence[Any]) -> Vector:
    return tuple(row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3] for row in m[:3])  # type: ignore[return-value]


def turn(m: Matrix, v: Sequence[Any]) -> Vector:
    """The linear part on a direction."""
    return tuple(row[0] * v[0] + row[1] * v[1] + row[2] * v[2] for row in m[:3])  # type: ignore[return-value]


def pull(m: Matrix, n: Sequence[Any]) -> Vector:
    """The linear part, transposed, on a covector: n . (m x) = pull(m, n) . x + constant."""
    return tuple(sum(m[i][j] * n[i] for i in range(3)) for j in range(3))  # type: ignore[return-value]


def shifting(v: Sequence[Any]) -> Matrix:
    return [*([*IDENTITY[i][:3], v[i]] for i in range(3)), IDENTITY[3]]


def about(axis: Sequence[Any], cosine: Any, sine: Any, point: Sequence[Any] = (0, 0, 0), advance: Any = 0) -> Matrix:
    """The turn about the line through point along the unit vector axis, and the advance along it."""
    x, y, z = axis
    k = 1 - cosine
    lin = [
        [cosine + k * x * x, k * x * y - sine * z, k * x * z + sine * y],
        [k * x * y + sine * z, cosine + k * y * y, k * y * z - sine * x],
        [k * x * z - sine * y, k * y * z + sine * x, cosine + k * z * z],
    ]
    return [*([*row, point[i] - dot(row, point) + advance * axis[i]] for i, row in enumerate(lin)), IDENTITY[3]]


def unit(rng: Random) -> Vector:
    """A rational unit vector with small numbers."""
    v = [x * rng.choice((1, -1)) for x in rng.choice(UNITS)]
    rng.shuffle(v)
    return tuple(v)  # type: ignore[return-value]


def bringing(u: Sequence[Any], w: Sequence[Any], rng: Random) -> Matrix:
    """A rational rotation that takes the unit vector u to the unit vector w; any roll about w."""
    middle = add(u, w)
    if not any(middle):  # half a turn about what is across
        middle = next(c for c in (cross(u, e) for e in ((1, 0, 0), (0, 1, 0))) if any(c))
    norm = dot(middle, middle)
    half = [[2 * middle[i] * middle[j] / F(norm) - (i == j) for j in range(3)] for i in range(3)]
    c, s = rng.choice((*ANGLES[:3], (F(1), F(0)), (F(1), F(0)), (F(1), F(0)), (F(0), F(1)), (F(-1), F(0))))
    return product(about(w, c, rng.choice((1, -1)) * s), [*([*row, F(0)] for row in half), IDENTITY[3]])


def text(x: Any) -> str:
    """A number as source text: an int, a double of few digits, or F(n, d)."""
    if isinstance(x, str):
        return x
    x = F(x)
    if x.denominator == 1:
        n = abs(x.numerator)
        return str(x.numerator) if n < 10**7 or n & (n - 1) else f"{'-' * (x < 0)}2**{n.bit_length() - 1}"
    try:
        double = float(x)
    except OverflowError:
        double = 0.0
    if double and F(double) == x:
        return repr(double)
    return f"F({x.numerator}, {x.denominator})"


def texts(v: Any) -> str:
    """Vectors and matrices as source text."""
    if isinstance(v, (list, tuple)):
        inner = ", ".join(texts(x) for x in v)
        return f"[{inner}]" if isinstance(v, list) else f"({inner},)" if len(v) == 1 else f"({inner})"
    return text(v)
