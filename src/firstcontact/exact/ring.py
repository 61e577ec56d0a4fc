"""What formulas ask of numbers, so that one text serves doubles, rationals, balls, polynomials and field elements."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, Self, TypeVar

from flint import arb, fmpq, fmpz


class Number(Protocol):
    """An element of a commutative ring: a double, int, ``fmpz``, ``fmpq``, ball, polynomial, or element of a field."""

    def __add__(self, other: Self | int, /) -> Self: ...
    def __sub__(self, other: Self | int, /) -> Self: ...
    def __mul__(self, other: Self | int, /) -> Self: ...
    def __radd__(self, other: int, /) -> Self: ...
    def __rsub__(self, other: int, /) -> Self: ...
    def __rmul__(self, other: int, /) -> Self: ...
    def __neg__(self) -> Self: ...


class Divisible(Number, Protocol):
    """An element of a field, or of what divides without a rest where it is divided."""

    def __truediv__(self, other: Self | int, /) -> Self: ...
    def __rtruediv__(self, other: int, /) -> Self: ...


class Ordered(Number, Protocol):
    """A number that compares; balls do where they do not overlap."""

    def __lt__(self, other: Self | int, /) -> bool: ...
    def __gt__(self, other: Self | int, /) -> bool: ...
    def __le__(self, other: Self | int, /) -> bool: ...
    def __ge__(self, other: Self | int, /) -> bool: ...


# What is taken is given back: any number, what divides, what compares, and rationals or balls.
N = TypeVar("N", bound=Number)
D = TypeVar("D", bound=Divisible)
C = TypeVar("C", bound=Ordered)
E = TypeVar("E", fmpq, arb)
MatrixOf = Sequence[Sequence[N]]
"""Row by row."""
VectorOf = tuple[N, N, N]
Rational = int | fmpz | fmpq
Scalar = fmpz | fmpq | arb
"""A rational, or a ball around a number that is none."""
