"""The field Q(r) of one algebraic root r, and square roots over it: exact zero tests, signs by refined balls.

The same algorithms run on fmpq, on elements of a field and on elements of a quadratic extension; `sign`, `is_zero`
and `ball` below take all three.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from flint import arb, fmpq, fmpq_poly, fmpz, fmpz_poly, nmod_poly

from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import PRECISIONS, precision

if TYPE_CHECKING:
    from firstcontact.exact.ring import Divisible, Number, Ordered

Rows = Sequence[Sequence[Any]]

# Up to this degree products are reduced at once.  A reduction costs as many factors of the leading coefficient as it
# lowers the degree, so in fields of high degree unreduced products stay far smaller: at degree 60, a contact of two
# ellipsoids was classified in 130 ms with reductions, 6 ms without.  Any value is correct.
EAGER_DEGREE = 8


class NumberField:
    """Q(r) for an AlgebraicRoot r; for a rational root, Q itself.

    `field(q)` is the value q(r) of a polynomial or a rational.
    """

    __slots__ = ("_residue", "modulus", "root")

    def __init__(self, root: AlgebraicRoot) -> None:
        self.root = root
        self.modulus = fmpq_poly(root.polynomial)
        self._residue: tuple[int, int] | None = None

    def __call__(self, q: FieldElement | fmpz_poly | fmpq_poly | fmpz | fmpq | int) -> FieldElement:
        if isinstance(q, FieldElement):
            return q
        if isinstance(q, fmpz_poly | fmpq_poly):
            if self.root.rational is not None:
                return FieldElement(self, fmpq_poly([q(self.root.rational)]))
            return FieldElement(self, self.reduced(fmpq_poly(q)))
        return FieldElement(self, fmpq_poly([q]))

    def reduced(self, q: fmpq_poly) -> fmpq_poly:
        """q modulo the minimal polynomial, where that is cheap."""
        degree = self.modulus.degree()
        return q % self.modulus if degree <= q.degree() and degree <= EAGER_DEGREE else q

    @property
    def residue(self) -> tuple[int, int]:
        """That of the minimal polynomial."""
        if self._residue is None:
            self._residue = residue(self.root.polynomial)
        return self._residue

    def generator(self) -> FieldElement:
        """The root itself."""
        return self(fmpz_poly([0, 1]))

    def matrix(self, m: Sequence[Sequence[fmpz_poly | fmpq_poly | fmpq | int]]) -> tuple[tuple[FieldElement, ...], ...]:
        """A polynomial matrix at the root."""
        return tuple(tuple(self(x) for x in row) for row in m)


def residue(f: fmpz_poly) -> tuple[int, int]:
    """A prime p and a zero of the irreducible f modulo p, which every such f has for some primes (Chebotarev).

    Taking that zero for r maps numbers of Q(r) whose denominators p does not divide to p numbers, and keeps sums and
    products.  A common divisor of polynomials over Q(r), made primitive at a prime above p, maps to one of their
    images; it keeps its degree where one of their leading coefficients is not mapped to 0.  So degrees of greatest
    common divisors are at most those of the images.
    """
    p = fmpz(2**31)
    while True:
        p += 1
        if p.is_prime() and f.leading_coefficient() % p:
            for zero, _ in nmod_poly(f.coeffs(), int(p)).roots():
                return int(p), int(zero)


class ExactNumber:
    """A number with `sign()`, `is_zero()` and `ball(bits)`: what `sign`, `is_zero` and `ball` below ask of it."""

    __slots__ = ()

    def sign(self) -> int:
        raise NotImplementedError

    def is_zero(self) -> bool:
        return self.sign() == 0

    def ball(self, bits: int) -> arb:
        raise NotImplementedError


class FieldElement(ExactNumber):
    """A polynomial in the root: zero exactly where the minimal polynomial divides it."""

    __slots__ = ("_sign", "field", "value")

    def __init__(self, field: NumberField, value: fmpq_poly) -> None:
        self.field, self.value = field, value
        self._sign: int | None = None

    def _of(self, other: object) -> fmpq_poly | None:
        if type(other) is FieldElement:
            return other.value
        return fmpq_poly([other]) if isinstance(other, fmpq | int) else None

    def __add__(self, other: FieldElement | fmpq | int) -> FieldElement:
        y = self._of(other)
        return NotImplemented if y is None else FieldElement(self.field, self.value + y)

    __radd__ = __add__

    def __neg__(self) -> FieldElement:
        return FieldElement(self.field, -self.value)

    def __sub__(self, other: FieldElement | fmpq | int) -> FieldElement:
        y = self._of(other)
        return NotImplemented if y is None else FieldElement(self.field, self.value - y)

    def __rsub__(self, other: FieldElement | fmpq | int) -> FieldElement:
        return -self + other

    def __mul__(self, other: FieldElement | fmpq | int) -> FieldElement:
        y = self._of(other)
        if y is None:
            return NotImplemented
        return FieldElement(self.field, self.field.reduced(self.value * y))

    __rmul__ = __mul__

    def inverse(self) -> FieldElement:
        if self.is_zero():
            raise ZeroDivisionError("1 / 0 in a number field")
        if self.value.degree() == 0:
            return FieldElement(self.field, fmpq_poly([1 / self.value[0]]))
        _, s, _ = (self.value % self.field.modulus).xgcd(self.field.modulus)
        return FieldElement(self.field, s)

    def __truediv__(self, other: FieldElement | fmpq | int) -> FieldElement:
        if isinstance(other, fmpq | int):
            return FieldElement(self.field, self.value / fmpq(other))
        return self * other.inverse() if type(other) is FieldElement else NotImplemented

    def __rtruediv__(self, other: fmpq | int) -> FieldElement:
        return self.inverse() * other

    def __eq__(self, other: object) -> bool:
        y = self._of(other)
        return NotImplemented if y is None else FieldElement(self.field, self.value - y).is_zero()

    __hash__ = None  # type: ignore[assignment]  # equal to rationals, which hash otherwise

    def reduced(self) -> FieldElement:
        """The same number as a polynomial of the lowest degree."""
        return FieldElement(self.field, self.value % self.field.modulus)

    def modulo_prime(self) -> int | None:
        """The image of the number under `residue`; None where that prime divides its denominator."""
        p, r = self.field.residue
        below = int(self.value.denom() % p)
        if below == 0:
            return None
        return int(nmod_poly(self.value.numer().coeffs(), p)(r)) * pow(below, -1, p) % p

    def is_zero(self) -> bool:
        if self.value.degree() < self.field.modulus.degree():
            return bool(self.value.is_zero())
        return self.sign() == 0

    def sign(self) -> int:
        """-1, 0, 1, exactly."""
        if self._sign is None:
            self._sign = self.field.root.sign_of(self.value.numer())
        return self._sign

    def ball(self, bits: int) -> arb:
        """An enclosure with `bits` correct bits, relative to its size; exactly 0 for zero."""
        if self.value.degree() > 0 and self.is_zero():
            return arb(0)
        if self.value.degree() <= 0:
            with precision(bits):
                return arb(self.value[0])
        work = bits + 32
        while True:
            x = self.field.root.enclosure(work)
            with precision(work):
                found = self.value.numer()(x) / arb(self.value.denom())
            if found.rel_accuracy_bits() >= bits:
                return found
            work *= 2

    def __repr__(self) -> str:
        return f"FieldElement({self.ball(64).str(12)})"


class QuadraticElement(ExactNumber):
    """x + y sqrt(d), d >= 0, for x, y, d of one field: fmpq, FieldElement or QuadraticElement."""

    __slots__ = ("d", "x", "y")

    def __init__(self, x: Divisible, y: Divisible, d: Divisible) -> None:
        self.x, self.y, self.d = x, y, d

    def _of(self, other: Divisible | int) -> tuple[Divisible | int, Divisible | int]:
        if type(other) is QuadraticElement and other.d is self.d:
            return other.x, other.y
        return other, 0

    def __add__(self, other: Divisible | int) -> QuadraticElement:
        x, y = self._of(other)
        return QuadraticElement(self.x + x, self.y + y, self.d)

    __radd__ = __add__

    def __neg__(self) -> QuadraticElement:
        return QuadraticElement(-self.x, -self.y, self.d)

    def __sub__(self, other: Divisible | int) -> QuadraticElement:
        x, y = self._of(other)
        return QuadraticElement(self.x - x, self.y - y, self.d)

    def __rsub__(self, other: Divisible | int) -> QuadraticElement:
        return -self + other

    def __mul__(self, other: Divisible | int) -> QuadraticElement:
        x, y = self._of(other)
        return QuadraticElement(self.x * x + self.y * y * self.d, self.x * y + self.y * x, self.d)

    __rmul__ = __mul__

    def inverse(self) -> QuadraticElement:
        norm = self.x * self.x - self.y * self.y * self.d
        if not is_zero(norm):
            return QuadraticElement(self.x / norm, -self.y / norm, self.d)
        # d is a square of the field: either the element is 0, or its conjugate is, and then it equals 2 x
        if self.is_zero():
            raise ZeroDivisionError("1 / 0 in a quadratic extension")
        return QuadraticElement(1 / (2 * self.x), self.y * 0, self.d)

    def __truediv__(self, other: Divisible | int) -> QuadraticElement:
        if type(other) is QuadraticElement and other.d is self.d:
            return self * other.inverse()
        return QuadraticElement(self.x / other, self.y / other, self.d)

    def __rtruediv__(self, other: Divisible | int) -> QuadraticElement:
        return self.inverse() * other

    def is_zero(self) -> bool:
        return self.sign() == 0

    def sign(self) -> int:
        """Equal signs decide, otherwise x^2 against y^2 d."""
        sx = sign(self.x)
        sy = sign(self.y) if sign(self.d) else 0
        if sx == sy or sy == 0:
            return sx
        if sx == 0:
            return sy
        return sx * sign(self.x * self.x - self.y * self.y * self.d)

    def ball(self, bits: int) -> arb:
        """As that of a FieldElement."""
        if self.is_zero():
            return arb(0)
        work = bits + 32
        while True:
            x, y, d = ball(self.x, work), ball(self.y, work), ball(self.d, work)
            with precision(work):
                found = x + y * d.nonnegative_part().sqrt()
            if found.rel_accuracy_bits() >= bits:
                return found
            work *= 2

    def __repr__(self) -> str:
        return f"QuadraticElement({self.ball(64).str(12)})"


def sign(x: Number) -> int:
    """Exact sign of an fmpq, a field element or an int."""
    return x.sign() if isinstance(x, ExactNumber) else (x > 0) - (x < 0)  # type: ignore[operator]  # all others compare


def is_zero(x: Number) -> bool:
    return x.is_zero() if isinstance(x, ExactNumber) else x == 0


def ball(x: Number, bits: int) -> arb:
    if isinstance(x, ExactNumber):
        return x.ball(bits)
    with precision(bits):
        return arb(x)  # type: ignore[arg-type]  # rationals and balls


def filtered_sign(formula: Callable[[Rows], Ordered], rows: Rows) -> int:
    """Sign of formula(rows), a polynomial in the entries: by balls where they decide, exactly otherwise."""
    if not all(type(x) is fmpq for row in rows for x in row):
        for bits in PRECISIONS[:3]:
            balls = [[ball(x, bits) for x in row] for row in rows]
            with precision(bits):
                value = formula(balls)
            if value > 0 or value < 0:
                return 1 if value > 0 else -1
    return sign(formula(rows))


def square_root(d: Divisible) -> Any:
    """sqrt(d), d >= 0: in the quadratic extension by itself, rational where that shows at once."""
    if type(d) is fmpq:
        p, q = d.p.isqrt(), d.q.isqrt()
        if p * p == d.p and q * q == d.q:
            return fmpq(p, q)
    return QuadraticElement(d * 0, d * 0 + 1, d)
