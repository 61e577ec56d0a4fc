"""Numbers of two algebraic numbers: polynomials in a fixed root s with coefficients in the field of a root r.

Q(r)(s) need not be a field extension of the degree of s: the minimal polynomial m of s over Q may split over Q(r).
So zero tests go by the greatest common divisor with m over Q(r), which holds the conjugates of s at which the
polynomial vanishes; s is one of them exactly when that divisor changes its sign around s (re-derived).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from flint import acb, arb, fmpq, fmpq_poly, fmpz_poly

from firstcontact.exact.fields.number_field import ExactNumber, FieldElement, NumberField, is_zero, sign
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import precision

if TYPE_CHECKING:
    from firstcontact.exact.ring import N

BITS = (96, 384)
"""Precisions at which balls may show a sign before zero is tested exactly."""


class TowerElement(ExactNumber):
    """sum c_k s^k with c_k in the field of r; degree below that of s."""

    __slots__ = ("_sign", "coefficients", "field", "over")

    def __init__(self, field: NumberField, over: AlgebraicRoot, coefficients: Sequence[FieldElement]) -> None:
        self.field, self.over = field, over
        self.coefficients = _reduced(coefficients, over.polynomial)
        self._sign: int | None = None

    def _of(self, other: TowerElement | FieldElement | fmpq | int) -> Sequence[FieldElement] | None:
        if type(other) is TowerElement:
            return other.coefficients if other.over is self.over else None
        if isinstance(other, ExactNumber) and not isinstance(other, FieldElement):
            return None
        return [self.field(other)]

    def _new(self, coefficients: Sequence[FieldElement]) -> TowerElement:
        return TowerElement(self.field, self.over, coefficients)

    def __add__(self, other: TowerElement | FieldElement | fmpq | int) -> TowerElement:
        y = self._of(other)
        if y is None:
            return NotImplemented
        x = self.coefficients
        longer, shorter = (x, y) if len(x) >= len(y) else (y, x)
        return self._new([c + shorter[k] if k < len(shorter) else c for k, c in enumerate(longer)])

    __radd__ = __add__

    def __neg__(self) -> TowerElement:
        return self._new([-c for c in self.coefficients])

    def __sub__(self, other: TowerElement | FieldElement | fmpq | int) -> TowerElement:
        y = self._of(other)
        return NotImplemented if y is None else self + self._new([-c for c in y])

    def __rsub__(self, other: TowerElement | FieldElement | fmpq | int) -> TowerElement:
        return -self + other

    def __mul__(self, other: TowerElement | FieldElement | fmpq | int) -> TowerElement:
        y = self._of(other)
        return NotImplemented if y is None else self._new(product(self.coefficients, y))

    __rmul__ = __mul__

    def enclosed(self, bits: int) -> arb:
        """A ball around the number, computed with `bits` bits."""
        r, s = self.field.root.enclosure(bits), self.over.enclosure(bits)
        with precision(bits):
            return _horner(self.coefficients, r, s)

    def sign(self) -> int:
        if self._sign is None:
            self._sign = self._decided()
        return self._sign

    def _decided(self) -> int:
        bits = BITS[0]
        while True:
            x = self.enclosed(bits)
            if x > 0 or x < 0:
                return 1 if x > 0 else -1
            if bits == BITS[-1] and self._vanishes():
                return 0
            bits *= 2

    def _vanishes(self) -> bool:
        modulus = [self.field(c) for c in fmpq_poly(self.over.polynomial).coeffs()]
        common = gcd(modulus, list(self.coefficients))
        if len(common) == 1:
            return False
        if self.over.rational is not None:
            return True
        ends = [sign(_horner(common, None, self.field(end))) for end in (self.over.lo, self.over.hi)]
        return ends[0] * ends[1] < 0

    def only_conjugates_differ(self) -> bool:
        """Whether balls show that no other conjugate of s is a zero of the polynomial.

        With a norm that vanishes this proves the number zero.
        """
        bits = BITS[0]
        s = self.over.enclosure(bits)
        r = self.field.root.enclosure(bits)
        with precision(bits):
            roots: list[acb] = [pair[0] for pair in self.over.polynomial.complex_roots()]  # type: ignore[misc,index]
            values = [_horner(self.coefficients, r, z) for z in roots]
            own = [z.imag.contains(0) and z.real.overlaps(s) for z in roots]
        return sum(own) == 1 and all(mine or not v.contains(0) for mine, v in zip(own, values, strict=True))

    def ball(self, bits: int) -> arb:
        """An enclosure with `bits` correct bits; exactly 0 for zero."""
        if self.sign() == 0:
            return arb(0)
        work = bits + 32
        while True:
            x = self.enclosed(work)
            if x.rel_accuracy_bits() >= bits:
                return x
            work *= 2

    def __repr__(self) -> str:
        return f"TowerElement({self.ball(64).str(12)})"


def _reduced(coefficients: Sequence[FieldElement], modulus: fmpz_poly) -> list[FieldElement]:
    """The remainder of the polynomial in s by its minimal polynomial."""
    m = fmpq_poly(modulus)
    m = m / m[m.degree()]
    n = m.degree()
    rest = list(coefficients)
    while len(rest) > n:
        top = rest.pop()
        for k in range(n):
            if m[k]:
                rest[len(rest) - n + k] = rest[len(rest) - n + k] - top * m[k]
    return rest


def product(x: Sequence[N], y: Sequence[N]) -> list[N]:
    """Of polynomials over any ring, coefficients ascending, none of them empty."""
    found: list[Any] = [None] * (len(x) + len(y) - 1)
    for i, a in enumerate(x):
        for j, b in enumerate(y):
            found[i + j] = a * b if found[i + j] is None else found[i + j] + a * b
    return found


def _horner(coefficients: Sequence[FieldElement], r: arb | None, s: N) -> N:
    """The polynomial at s; coefficients at the ball r, or as they are."""
    total: Any = None
    for c in reversed(coefficients):
        value = c if r is None else c.value.numer()(r) / arb(c.value.denom())
        total = value if total is None else total * s + value
    return total


def gcd(f: list[FieldElement], g: list[FieldElement]) -> list[FieldElement]:
    """Greatest common divisor of polynomials over a field, ascending."""
    while g := trimmed(g):
        f, g = g, division(f, g)[1]
    return f


def trimmed(f: list[N]) -> list[N]:
    """Without the leading coefficients that are zero."""
    n = len(f)
    while n and is_zero(f[n - 1]):
        n -= 1
    return f[:n]


def pseudo_division(f: Sequence[N], g: Sequence[N]) -> tuple[list[N], list[N]]:
    """Quotient and remainder of lc(g)^(deg f - deg g + 1) f by g, over any ring."""
    rest, lead, quotient = list(f), g[-1], list[Any]()
    for _ in range(len(f) - len(g) + 1):
        top = rest.pop()
        rest = [lead * c for c in rest]
        for k in range(1, len(g)):
            rest[-k] = rest[-k] - top * g[-1 - k]
        quotient = [*(lead * c for c in quotient), top]
    return quotient[::-1], rest


def division(f: list[FieldElement], g: list[FieldElement]) -> tuple[list[FieldElement], list[FieldElement]]:
    """Quotient and remainder; the leading coefficient of g is not zero."""
    rest, inverse, quotient = list(f), 1 / g[-1], []
    while len(rest) >= len(g):
        factor = rest.pop() * inverse
        quotient.append(factor)
        for k in range(1, len(g)):
            rest[-k] = rest[-k] - factor * g[-1 - k]
    return quotient[::-1], rest
