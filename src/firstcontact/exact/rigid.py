"""Poses as 3x4 matrices of exact numbers (or balls), and the rational rotations among them.

A matrix is a tuple of three rows (m0, m1, m2, shift).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from flint import arb, fmpq

from firstcontact.exact.numbers import ball, exact_value, precision

Row = tuple[Any, Any, Any, Any]
Matrix = tuple[Row, Row, Row]
Vector = tuple[Any, Any, Any]

_0, _1 = fmpq(0), fmpq(1)
IDENTITY: Matrix = ((_1, _0, _0, _0), (_0, _1, _0, _0), (_0, _0, _1, _0))


def shift(v: Vector) -> Matrix:
    return ((_1, _0, _0, v[0]), (_0, _1, _0, v[1]), (_0, _0, _1, v[2]))


def is_shift(m: Matrix) -> bool:
    """Whether a map is a translation, or none at all."""
    return all(x == int(i == k) for i, row in enumerate(m) for k, x in enumerate(row[:3]))


def to_origin(middle: Sequence[float], size: float) -> Vector:
    """The shift, of few binary digits, that brings the middle of something of this size to the origin, or near it."""
    unit = 2.0 ** math.floor(math.log2(size))
    x, y, z = (exact_value(-unit * round(c / unit)) for c in middle)
    return x, y, z


def apply(m: Matrix, p: Vector) -> Vector:
    x, y, z = p
    r0, r1, r2 = m
    return (
        r0[0] * x + r0[1] * y + r0[2] * z + r0[3],
        r1[0] * x + r1[1] * y + r1[2] * z + r1[3],
        r2[0] * x + r2[1] * y + r2[2] * z + r2[3],
    )


def turned(m: Matrix, v: Vector) -> Vector:
    """A direction under a map."""
    x, y, z = (r[0] * v[0] + r[1] * v[1] + r[2] * v[2] for r in m)
    return x, y, z


def compose(m: Matrix, n: Matrix) -> Matrix:
    """The map "first n, then m"."""
    (a, b, c, x), (d, e, f, y), (g, h, i, z) = n
    return tuple(
        (p * a + q * d + r * g, p * b + q * e + r * h, p * c + q * f + r * i, p * x + q * y + r * z + s)
        for p, q, r, s in m
    )  # type: ignore[return-value]


def determinant(m: Matrix) -> fmpq | arb:
    (a, b, c, _), (d, e, f, _), (g, h, i, _) = m
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def inverse_map(m: Matrix) -> Matrix:
    """Inverse of an affine map, by the adjugate."""
    (a, b, c, x), (d, e, f, y), (g, h, i, z) = m
    rows = (
        (e * i - f * h, c * h - b * i, b * f - c * e),
        (f * g - d * i, a * i - c * g, c * d - a * f),
        (d * h - e * g, b * g - a * h, a * e - b * d),
    )
    w = determinant(m)
    return tuple((*(k / w for k in r), -(r[0] * x + r[1] * y + r[2] * z) / w) for r in rows)  # type: ignore[return-value]


def quaternion_rotation(w: fmpq | arb, axis: Vector, point: Vector) -> Matrix:
    """Rotation of the (unnormalised) quaternion w + axis, about the line through `point`.

    Rational for rational input: R = I + 2 (w [q] + [q]^2) / (w^2 + q.q).
    """
    x, y, z = axis
    n = w * w + x * x + y * y + z * z
    r = (
        (_1 - 2 * (y * y + z * z) / n, 2 * (x * y - w * z) / n, 2 * (x * z + w * y) / n),
        (2 * (x * y + w * z) / n, _1 - 2 * (x * x + z * z) / n, 2 * (y * z - w * x) / n),
        (2 * (x * z - w * y) / n, 2 * (y * z + w * x) / n, _1 - 2 * (x * x + y * y) / n),
    )
    return _about(r, point)


def _about(r: tuple[Vector, Vector, Vector], point: Vector) -> Matrix:
    """The linear map r with `point` fixed."""
    return tuple(  # type: ignore[return-value]
        (*row, point[k] - row[0] * point[0] - row[1] * point[1] - row[2] * point[2])
        for k, row in enumerate(r)
    )


def rational_sqrt(x: fmpq) -> fmpq | None:
    """The square root of x >= 0 when it is rational."""
    p, q = x.p.isqrt(), x.q.isqrt()
    return fmpq(p, q) if p * p == x.p and q * q == x.q else None


def quarter_turns(turns: fmpq) -> int | None:
    """How many quarter turns (mod 4), when `turns` is a whole number of them."""
    quarters = turns * 4
    return int(quarters.p) % 4 if quarters.q == 1 else None


def exact_rotation(axis: Vector, point: Vector, angle: fmpq, unit: str) -> Matrix | None:
    """The rotation by `angle` ("turns" or "radians") where it is rational, else None.

    Half turns always are; quarter turns where the axis has rational length; other rational angles never
    have both cosine and sine rational (Niven), and nonzero rational radians never (Lindemann).
    """
    if angle == 0:
        return IDENTITY
    quarters = quarter_turns(angle) if unit == "turns" else None
    if quarters is None:
        return None
    if quarters == 0:
        return IDENTITY
    if quarters == 2:
        return quaternion_rotation(_0, axis, point)
    length = rational_sqrt(axis[0] ** 2 + axis[1] ** 2 + axis[2] ** 2)
    if length is None:
        return None
    return quaternion_rotation(length if quarters == 1 else -length, axis, point)


def ball_rotation(axis: Vector, point: Vector, radians: arb) -> Matrix:
    """Enclosure of the rotation by `radians` at the present precision."""
    x, y, z = (ball(c) for c in axis)
    length = (x * x + y * y + z * z).sqrt()
    half = radians / 2
    s = half.sin() / length
    return quaternion_rotation(half.cos(), (x * s, y * s, z * s), tuple(ball(c) for c in point))  # type: ignore[arg-type]


def near_rotation(axis: Vector, point: Vector, turns: fmpq) -> Matrix:
    """A rational rotation about exactly this axis, by `turns` to within 2^-60 radians."""
    turns = turns - turns.floor() if hasattr(turns, "floor") else turns
    size = max(map(abs, axis))
    if not fmpq(1, 2**20) < size < 2**20:  # the scale below is for lengths about 1
        axis = axis[0] / size, axis[1] / size, axis[2] / size
    exact = exact_rotation(axis, point, turns, "turns")
    if exact is not None:
        return exact
    with precision(256):
        length = arb(axis[0] ** 2 + axis[1] ** 2 + axis[2] ** 2).sqrt()
        half = arb(turns) * arb.pi()
        # cot(half) * length to 2^-80 absolute of a number scaled to be O(1) in the larger of w and axis
        c, s = half.cos(), half.sin() / length
        scale = arb(2) ** 90
        w, v = _nearest_integer(c * scale), _nearest_integer(s * length * scale)
        ratio = _nearest_integer(length * scale)
    weight = fmpq(v) * fmpq(2) ** 90 / fmpq(ratio)
    return quaternion_rotation(fmpq(w), (axis[0] * weight, axis[1] * weight, axis[2] * weight), point)


def _nearest_integer(x: arb) -> int:
    mantissa, exponent = x.mid().man_exp()
    m, e = int(mantissa), int(exponent)
    return m << e if e >= 0 else (m + (1 << (-e - 1))) >> -e
