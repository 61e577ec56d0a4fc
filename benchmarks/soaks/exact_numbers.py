"""Vectors, matrices and polynomials of fractions for oracles: plain Python, nothing of the library.

A polynomial is a list of its coefficients, lowest first.  A number that may be irrational is a pair of fractions
(lo, hi) that encloses it, equal where it is rational.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction as F
from math import isqrt

Vector = tuple[F, F, F]
Matrix = tuple[Vector, Vector, Vector]
Polynomial = list[F]
Near = tuple[F, F]


def vector(x: Sequence[object]) -> Vector:
    return F(x[0]), F(x[1]), F(x[2])  # type: ignore[arg-type]


def add(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def sub(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scaled(a: Vector, k: F | int) -> Vector:
    return a[0] * k, a[1] * k, a[2] * k


def dot(a: Vector, b: Vector) -> F:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def image(m: Matrix, x: Vector) -> Vector:
    return dot(m[0], x), dot(m[1], x), dot(m[2], x)


def product(a: Matrix, b: Matrix) -> Matrix:
    columns = tuple(zip(*b, strict=True))
    return tuple(tuple(dot(row, column) for column in columns) for row in a)  # type: ignore[return-value,arg-type]


def inverse(m: Matrix) -> Matrix:
    rows = cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])
    det = dot(m[0], rows[0])
    return tuple(tuple(row[i] / det for row in rows) for i in range(3))  # type: ignore[return-value]


def turn(w: int, x: int, y: int, z: int) -> Matrix:
    """The rotation of the quaternion (w, x, y, z) of any length."""
    n = F(w * w + x * x + y * y + z * z)
    return (
        (1 - 2 * (y * y + z * z) / n, 2 * (x * y - w * z) / n, 2 * (x * z + w * y) / n),
        (2 * (x * y + w * z) / n, 1 - 2 * (x * x + z * z) / n, 2 * (y * z - w * x) / n),
        (2 * (x * z - w * y) / n, 2 * (y * z + w * x) / n, 1 - 2 * (x * x + y * y) / n),
    )


def polynomial_sum(p: Sequence[F], q: Sequence[F]) -> Polynomial:
    n = max(len(p), len(q))
    return [(p[i] if i < len(p) else F(0)) + (q[i] if i < len(q) else F(0)) for i in range(n)]


def times(p: Sequence[F], q: Sequence[F]) -> Polynomial:
    out = [F(0)] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            out[i + j] += a * b
    return out


def power(p: Sequence[F], n: int) -> Polynomial:
    out = [F(1)]
    for _ in range(n):
        out = times(out, p)
    return out


def value(p: Sequence[F], x: F) -> F:
    out = F(0)
    for c in reversed(p):
        out = out * x + c
    return out


def derivative(p: Sequence[F]) -> Polynomial:
    return [i * c for i, c in enumerate(p)][1:] or [F(0)]


def trimmed(p: Sequence[F]) -> Polynomial:
    out = list(p)
    while out and out[-1] == 0:
        out.pop()
    return out


def remainder(p: Sequence[F], q: Sequence[F]) -> Polynomial:
    out, q = trimmed(p), trimmed(q)
    while len(out) >= len(q):
        k = out[-1] / q[-1]
        for i, c in enumerate(q):
            out[len(out) - len(q) + i] -= k * c
        out = trimmed(out[:-1])
    return out


def quotient(p: Sequence[F], q: Sequence[F]) -> Polynomial:
    rest, q = trimmed(p), trimmed(q)
    out = [F(0)] * max(len(rest) - len(q) + 1, 1)
    while len(rest) >= len(q):
        k = rest[-1] / q[-1]
        out[len(rest) - len(q)] = k
        for i, c in enumerate(q):
            rest[len(rest) - len(q) + i] -= k * c
        rest = trimmed(rest[:-1])
    return out


def squarefree(p: Sequence[F]) -> Polynomial:
    a, b = trimmed(p), trimmed(derivative(p))
    while b:
        a, b = b, remainder(a, b)
    return quotient(p, a)


def roots(p: Sequence[F], lo: F, hi: F) -> list[Near]:
    """The distinct real roots in [lo, hi], ascending; rational ones that bisection meets are told exactly."""
    p = trimmed(p)
    if len(p) < 2:
        return []
    p = squarefree(p)
    chain = [p, derivative(p)]
    while len(trimmed(chain[-1])) > 1:
        chain.append([-c for c in remainder(chain[-2], chain[-1])])

    def changes(x: F) -> int:
        signs = [s for s in (value(q, x) for q in chain) if s]
        return sum((a > 0) != (b > 0) for a, b in zip(signs, signs[1:], strict=False))

    found: list[Near] = [(lo, lo)] if value(p, lo) == 0 else []
    stack = [(lo, hi, changes(lo), changes(hi))]  # roots in (a, b] are changes(a) - changes(b)
    while stack:
        a, b, ca, cb = stack.pop()
        if ca == cb:
            continue
        if ca - cb == 1:
            found.append(_refined(p, a, b))
            continue
        m = (a + b) / 2
        cm = changes(m)
        stack += [(m, b, cm, cb), (a, m, ca, cm)]
    return sorted(found)


def _refined(p: Sequence[F], a: F, b: F) -> Near:
    """The only root in (a, b], within 2^-80 of the size of the range, or exactly where it is a simple fraction."""
    if value(p, b) == 0:
        return b, b
    size = max(b - a, abs(a), abs(b))
    below = value(p, b) < 0  # the sign just before the root is that of the other side
    slope = derivative(p)
    x = (a + b) / 2
    for _ in range(12):  # by halves, then by tangents
        at = value(p, x)
        if at == 0:
            return x, x
        a, b = (a, x) if (at < 0) == below else (x, b)
        x = (a + b) / 2
    for step in range(8):
        steep = value(slope, x)
        if steep == 0:
            break
        x -= value(p, x) / steep
        x = F(round(x / size * 2 ** min(120, 24 << step)), 2 ** min(120, 24 << step)) * size
        if not a <= x <= b:
            break
    guess = x.limit_denominator(10**7)
    if a < guess <= b and value(p, guess) == 0:
        return guess, guess
    lo, hi = x - size / 2**85, x + size / 2**85
    if a < lo and hi <= b and (value(p, lo) < 0) != below and (value(p, hi) < 0) == below:
        return lo, hi
    while b - a > size / 2**80:
        x = (a + b) / 2
        at = value(p, x)
        if at == 0:
            return x, x
        a, b = (a, x) if (at < 0) == below else (x, b)
    return a, b


def windows_below(p: Sequence[F], lo: F, hi: F, bound: F = F(0)) -> list[tuple[Near, Near]]:
    """The closed times in [lo, hi] at which the polynomial is at most `bound`."""
    shifted = polynomial_sum(p, [-bound])
    cuts = [(lo, lo), *(r for r in roots(shifted, lo, hi) if r[0] != lo and r[1] != hi), (hi, hi)]
    out: list[tuple[Near, Near]] = []
    for i, cut in enumerate(cuts):
        is_root = cut[0] != cut[1] or value(shifted, cut[0]) <= 0
        if is_root and not (out and out[-1][1] == cut):
            out.append((cut, cut))
        if i + 1 < len(cuts) and value(shifted, (cut[1] + cuts[i + 1][0]) / 2) <= 0:
            out[-1] = (out[-1][0], cuts[i + 1])
    return out


def root_of_square(x: F) -> Near:
    """The square root of x >= 0."""
    scale = 1 << 200
    k = isqrt(x.numerator * scale * scale // x.denominator)
    if F(k, scale) ** 2 == x:
        return F(k, scale), F(k, scale)
    top, bottom = isqrt(x.numerator), isqrt(x.denominator)
    if top * top == x.numerator and bottom * bottom == x.denominator:
        return F(top, bottom), F(top, bottom)
    return F(k, scale), F(k + 1, scale)


def common(first: list[tuple[Near, Near]], second: list[tuple[Near, Near]]) -> list[tuple[Near, Near]]:
    """What two lists of closed windows share."""
    out = []
    for a, b in first:
        for c, d in second:
            lo, hi = max(a, c), min(b, d)
            if lo[0] <= hi[1]:
                out.append((lo, hi))
    return sorted(out)


def merged(windows: list[tuple[Near, Near]]) -> list[tuple[Near, Near]]:
    """Their union, as disjoint windows."""
    out: list[tuple[Near, Near]] = []
    for a, b in sorted(windows):
        if out and a[0] <= out[-1][1][1]:
            out[-1] = (out[-1][0], max(out[-1][1], b))
        else:
            out.append((a, b))
    return out
