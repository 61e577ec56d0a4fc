"""Three-dimensional vectors of exact numbers as plain tuples; the same code runs on fmpz, fmpq and balls."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from flint import arb, fmpq, fmpz

if TYPE_CHECKING:
    from firstcontact.exact.ring import N, Number, Scalar

Vector = tuple[Any, Any, Any]


def sub(x: Vector, y: Vector) -> Vector:
    return x[0] - y[0], x[1] - y[1], x[2] - y[2]


def add(x: Vector, y: Vector) -> Vector:
    return x[0] + y[0], x[1] + y[1], x[2] + y[2]


def scaled(k: Number, x: Vector) -> Vector:
    return k * x[0], k * x[1], k * x[2]


def dot(x: Sequence[N], y: Sequence[N]) -> N:
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]


def cross(x: Sequence[N], y: Sequence[N]) -> Vector:
    return (
        x[1] * y[2] - x[2] * y[1],
        x[2] * y[0] - x[0] * y[2],
        x[0] * y[1] - x[1] * y[0],
    )


def det(x: Sequence[N], y: Sequence[N], z: Sequence[N]) -> N:
    """Of the matrix with these rows."""
    return dot(x, cross(y, z))


def along(p: Vector, t: Number, v: Vector) -> Vector:
    """p + t v."""
    return p[0] + t * v[0], p[1] + t * v[1], p[2] + t * v[2]


def whole(*points: Vector, per: fmpz | int = 1) -> tuple[fmpz, list[Vector]]:
    """(scale > 0, the rational points times it as fmpz): sums of whole numbers have no denominators to find.

    per: a number of which the scale is to be a multiple.
    """
    denominators = [x.q for p in points for x in p]
    scale = max(denominators)  # of numbers that come from doubles, their common multiple at once
    if scale == 1 and per == 1:
        return scale, [(x.p, y.p, z.p) for x, y, z in points]
    for q in (*denominators, per):
        if scale % q:
            scale = scale.lcm(q)
    numbers = iter([x.p * (scale / q) if q != scale else x.p for p in points for x in p for q in (x.q,)])
    return scale, list(zip(numbers, numbers, numbers))  # noqa: B905 - three of one iterator


def whole_doubles(points: list[list[float]], per: fmpz, number: type = fmpz) -> tuple[Any, list[Vector]]:
    """`whole` of points given by doubles, in numbers of type fmpz or int."""
    ratios = [x.as_integer_ratio() for p in points for x in p]
    power = max([q for _, q in ratios])  # of two, as all of them: their common multiple
    bits = power.bit_length()
    scale = number(per.lcm(power))
    more = scale // power
    whole = [number(n) << (bits - q.bit_length()) for n, q in ratios]  # from large ints fmpz are slow to make
    numbers = iter(whole if more == 1 else [more * n for n in whole])
    return scale, list(zip(numbers, numbers, numbers))  # noqa: B905 - three of one iterator


def ratio(x: Scalar, y: Scalar) -> fmpq | arb:
    """x / y, whole numbers included."""
    return fmpq(x, y) if type(x) is fmpz else x / y  # type: ignore[arg-type, return-value]  # both are whole, or none


def divisible(*vectors: Vector) -> tuple[Vector, ...]:
    """The same vectors of numbers that divide: fmpq for fmpz."""
    return tuple(tuple(fmpq(x) if type(x) is fmpz else x for x in v) for v in vectors)  # type: ignore[misc]
