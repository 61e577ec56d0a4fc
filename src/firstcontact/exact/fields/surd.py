"""Numbers x + y sqrt(d), x and y rational or whole, with exact signs; on balls the same class works with enclosures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, final

from flint import arb, fmpq, fmpz

from firstcontact.exact.numbers import ball, sign

if TYPE_CHECKING:
    from firstcontact.exact.ring import Scalar

ZERO = fmpq(0)


@final
class Surd:
    """x + y sqrt(d), d >= 0.  Sums and products need one common d (or y = 0)."""

    __slots__ = ("d", "x", "y")
    x: Any
    y: Any
    d: Any

    def __init__(self, x: int | Scalar, y: int | Scalar = ZERO, d: int | Scalar = ZERO) -> None:
        self.x, self.y, self.d = x, y, d

    def _d(self, other: Surd) -> Scalar:
        return other.d if type(self.y) is not arb and not self.y else self.d

    def __add__(self, other: int | Scalar | Surd) -> Surd:
        if type(other) is not Surd:
            return Surd(self.x + other, self.y, self.d)
        return Surd(self.x + other.x, self.y + other.y, self._d(other))

    __radd__ = __add__

    def __neg__(self) -> Surd:
        return Surd(-self.x, -self.y, self.d)

    def __sub__(self, other: int | Scalar | Surd) -> Surd:
        return self + (-other)

    def __rsub__(self, other: int | Scalar | Surd) -> Surd:
        return -self + other

    def __mul__(self, other: int | Scalar | Surd) -> Surd:
        if type(other) is not Surd:
            return Surd(self.x * other, self.y * other, self.d)
        d = self._d(other)
        return Surd(self.x * other.x + self.y * other.y * d, self.x * other.y + self.y * other.x, d)

    __rmul__ = __mul__

    def __truediv__(self, other: int | Scalar) -> Surd:
        return Surd(self.x / other, self.y / other, self.d)

    def sign(self) -> int:
        """Exact: equal signs decide, otherwise x^2 against y^2 d."""
        x, y, d = self.x, self.y, self.d
        if type(x) is arb or type(y) is arb or type(d) is arb:
            return sign(self.ball())
        sx, sy = (x > 0) - (x < 0), (y > 0) - (y < 0) if d else 0
        if sx == sy or sy == 0:
            return sx
        if sx == 0:
            return sy
        gap = x * x - y * y * d
        return sx * ((gap > 0) - (gap < 0))

    def divisible(self) -> Surd:
        """The same number of numbers that divide: fmpq for fmpz."""
        return Surd(*(fmpq(v) if type(v) is fmpz else v for v in (self.x, self.y, self.d)))

    def ball(self) -> arb:
        return ball(self.x) + ball(self.y) * ball(self.d).sqrt()


def surd(x: int | Scalar | Surd) -> Surd:
    return x if isinstance(x, Surd) else Surd(fmpq(x) if isinstance(x, int) else x)


def sign_of(x: Scalar | Surd) -> int:
    """Sign of a Surd, fmpq or ball."""
    return x.sign() if isinstance(x, Surd) else sign(x)


def sign_two_radicals(p: Surd, q: Surd, d: Scalar) -> int:
    """Sign of p + q sqrt(d) with p, q over one common radical of their own; all rational."""
    sp, sq = p.sign(), q.sign()
    if d == 0 or sq == 0:
        return sp
    if sp == sq or sp == 0:
        return sq
    return sp * (p * p - q * q * d).sign()


def quadratic_roots(a: Scalar, b: Scalar, c: Scalar) -> list[Surd] | None:
    """Real roots of a s^2 + 2 b s + c, ascending multiplicity ignored; None when identically zero."""
    if sign(a) == 0:
        if sign(b) == 0:
            return None if sign(c) == 0 else []
        return [Surd(-c / (2 * b))]
    d = b * b - a * c
    s = sign(d)
    if s < 0:
        return []
    if s == 0:
        return [Surd(-b / a)]
    return [Surd(-b / a, -1 / a, d), Surd(-b / a, 1 / a, d)]
