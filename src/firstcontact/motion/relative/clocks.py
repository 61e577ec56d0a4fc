"""From the parameter u of a polynomial piece of motion to the time, exactly.

A root is the parameter of an event: an algebraic number with `polynomial` (irreducible), `rational`, `enclosure(bits)`,
`sign_of(polynomial)` and `number()`; or one known by enclosures only, with `polynomial` None.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from flint import arb, ctx, fmpq, fmpq_poly, fmpz, fmpz_poly

from firstcontact.exact.fields.algebraic import algebraic, isolate
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.fields.surd import Surd
from firstcontact.exact.numbers import ball, dyadic, fraction, precision
from firstcontact.exact.rigid import rational_sqrt
from firstcontact.exact.systems.square_systems import MOST_BITS, EnclosedRoot, OpenRoot
from firstcontact.exact.times.instants import enclose
from firstcontact.result import AlgebraicNumber, ExactAngle

# Bits of the rational bounds of u, and of the rational times near quarter turns given in radians.
BITS = 160

Root = AlgebraicRoot | EnclosedRoot | OpenRoot


@dataclass(frozen=True, slots=True)
class StraightClock:
    """u is the time."""

    def parameters(self, start: fmpq, end: fmpq | None) -> tuple[fmpq, fmpq | None]:
        """Rational bounds of u from `start` to `end`; None: without end."""
        return start, end

    def time(self, u: fmpq | arb) -> arb:
        """An enclosure of the time at u, at the present precision."""
        return ball(u)

    def compare(self, root: Root, time: fmpq) -> int:
        """-1, 0, 1: the root's time lies before, at, after `time`; exact."""
        return root.sign_of(fmpz_poly([-time.p, time.q]))

    def exact_time(self, root: AlgebraicRoot) -> Fraction | AlgebraicNumber:
        """The root's time."""
        return root.number()


@dataclass(frozen=True, slots=True)
class AngleClock:
    """u = tan((angle - reference) / 2) / sqrt(square), for an angle that grows with the time.

    The angle is rate (t - origin), rate > 0 in `unit` ("radians" or "turns") per unit of time; the reference is
    `halves` half turns.  `square` is that of the length of the axis vector h, so that the quaternion of the turn
    beyond the reference is 1 + u h, which is rational.
    """

    origin: fmpq
    rate: fmpq
    unit: str
    square: fmpq
    halves: int

    def cut(self) -> fmpq:
        """The time a quarter turn beyond the reference; a rational number near it when the rate is in radians."""
        if self.unit == "turns":
            return self.origin + fmpq(2 * self.halves + 1, 4) / self.rate
        with precision(BITS):
            return self.origin + dyadic((arb(fmpq(2 * self.halves + 1, 2)) * arb.pi() / arb(self.rate)).mid())

    def reference_time(self) -> fmpq | None:
        """When u = 0; None where that is irrational."""
        if self.unit == "turns":
            return self.origin + fmpq(self.halves, 2) / self.rate
        return self.origin if self.halves == 0 else None

    def matches(self, other: AngleClock) -> bool:
        """Whether u of one is that of the other up to a rational factor: the same angle at all times."""
        if (self.unit, self.rate) != (other.unit, other.rate) or rational_sqrt(self.square / other.square) is None:
            return False
        if self.unit == "radians":
            return (self.origin, self.halves) == (other.origin, other.halves)
        return self.reference_time() == other.reference_time()

    def _half_angle(self, time: fmpq) -> arb:
        """Half the angle from the reference to that at the rational time, in radians."""
        angle = arb(self.rate * (time - self.origin))
        radians = angle if self.unit == "radians" else 2 * angle * arb.pi()
        return (radians - self.halves * arb.pi()) / 2

    def parameters(self, start: fmpq, end: fmpq | None) -> tuple[fmpq, fmpq]:
        """Rational bounds of u from `start` to `end`, exact at quarter turns of rational tangent, else outward."""
        assert end is not None  # the caller cuts at quarter turns
        return self._parameter(start, -1), self._parameter(end, 1)

    def _parameter(self, time: fmpq, side: int) -> fmpq:
        length = rational_sqrt(self.square)
        passed = 2 * self.rate * (time - self.origin) - self.halves  # half turns, where the rate is in turns
        if time == self.reference_time():
            return fmpq(0)
        if self.unit == "turns" and abs(passed) == fmpq(1, 2) and length is not None:
            return (1 if passed > 0 else -1) / length
        with precision(BITS):
            u = self._half_angle(time).tan() / arb(self.square).sqrt()
            return dyadic(u.lower() if side < 0 else u.upper())

    def time(self, u: fmpq | arb) -> arb:
        """An enclosure of the time at u, at the present precision."""
        half = (ball(u) * arb(self.square).sqrt()).atan()
        if self.unit == "radians":
            return arb(self.origin) + (self.halves * arb.pi() + 2 * half) / arb(self.rate)
        return arb(self.origin) + (arb(fmpq(self.halves, 2)) + half / arb.pi()) / arb(self.rate)

    def compare(self, root: Root, time: fmpq) -> int:
        """-1, 0, 1: the root's time lies before, at, after `time`; exact.

        Balls decide all but equality.  Radians: no angle but 0 has an algebraic tangent (Lindemann).  Turns: equality
        is decided in the field of the root; two angles that could be confused differ by pi over the denominator.
        Roots known by enclosures count as equal to times that they cannot be told from.
        """
        share = (2 * self.rate * (time - self.origin) - self.halves) / 2
        bits, equal, apart = 128, None, fmpq(1, 2 * int(share.q))
        while True:
            x = root.enclosure(bits)
            with precision(bits):
                gap = (x * arb(self.square).sqrt()).atan() - self._half_angle(time)
                if gap > 0 or gap < 0:
                    return 1 if gap > 0 else -1
                near = abs(gap) < arb(apart) * arb.pi()
            if root.polynomial is None:
                if bits >= MOST_BITS:
                    return 0
                bits *= 2
                continue
            if equal is None:
                if self.unit == "radians":
                    equal = time == self.reference_time() and root.sign_of(fmpz_poly([0, 1])) == 0
                else:
                    equal = _is_part_of_half_turn(root.polynomial, self.square, int(share.q))
            if equal and (near or self.unit == "radians"):
                return 0
            bits *= 2

    def exact_time(self, root: AlgebraicRoot) -> Fraction | ExactAngle:
        """The root's time: a Fraction at quarter turns, else the angle turned, in [0, 2 pi), and its time."""
        quarter = self._quarter(root)
        if quarter is not None:
            return fraction(quarter)
        time = enclose(lambda: self.time(root.enclosure(ctx.prec)))[0]
        return ExactAngle(*self._cosine_sine(root), time)

    def _quarter(self, root: AlgebraicRoot) -> fmpq | None:
        reference = self.reference_time()
        if reference is None:
            return None
        if root.sign_of(fmpz_poly([0, 1])) == 0:
            return reference
        unit = fmpz_poly([-self.square.q, 0, self.square.p])
        if self.unit != "turns" or root.sign_of(unit) != 0:
            return None
        return reference + root.sign_of(fmpz_poly([0, 1])) * fmpq(1, 4) / self.rate

    def _cosine_sine(self, root: AlgebraicRoot) -> tuple[AlgebraicNumber | Fraction, AlgebraicNumber | Fraction]:
        """(1 - K u^2) / (1 + K u^2) and 2 sqrt(K) u / (1 + K u^2), negated at odd half turns; K = square."""
        k, way = self.square, -1 if self.halves % 2 else 1
        u = root.rational
        if u is not None:
            n = 1 + k * u * u
            return fraction(way * (1 - k * u * u) / n), algebraic(Surd(way * 2 * u / n), k)

        def cosine() -> arb:
            x = root.enclosure(ctx.prec)
            return way * (1 - k * x * x) / (1 + k * x * x)

        def sine() -> arb:
            x = root.enclosure(ctx.prec)
            return way * 2 * arb(k).sqrt() * x / (1 + k * x * x)

        p = _cosine_polynomial(root.polynomial, k, way)
        return isolate(p, cosine), isolate(_sine_polynomial(p), sine)


def _cosine_polynomial(p: fmpz_poly, k: fmpq, way: int) -> fmpq_poly:
    """A polynomial with root c = way (1 - k u^2) / (1 + k u^2) for every root u of p.

    u^2 is a root of N(v) = even(v)^2 - v odd(v)^2, and v = (way - c) / (k (c + way)).
    """
    squares = _even_part_of_product(fmpq_poly(p))
    n = squares.degree()
    above, below = fmpq_poly([way, -1]), fmpq_poly([k * way, k])
    total, power = fmpq_poly([0]), fmpq_poly([1])
    for j in range(n, -1, -1):  # sum of N_j above^j below^(n-j), by Horner's rule
        total = total * above + fmpq(squares[j]) * power
        power *= below
    return total


def _sine_polynomial(cosine: fmpq_poly) -> fmpq_poly:
    """A polynomial with the roots +-sqrt(1 - c^2) for every root c."""
    return _even_part_of_product(cosine)(fmpq_poly([1, 0, -1]))


def _even_part_of_product(p: fmpq_poly) -> fmpq_poly:
    """N with N(x^2) = p(x) p(-x): its roots are the squares of those of p."""
    coefficients = p.coeffs()
    even, odd = fmpq_poly(coefficients[::2]), fmpq_poly(coefficients[1::2])
    return even * even - fmpq_poly([0, 1]) * odd * odd


def _is_part_of_half_turn(p: fmpz_poly, square: fmpq, b: int) -> bool:
    """Whether atan(sqrt(square) u) is a whole multiple of pi / b, for the roots u of the irreducible p.

    That is: (1 + i sqrt(square) u)^b is real; decided in Q[u] / p.  tan(pi a / b) in lowest terms has degree phi(b),
    or half of it where 4 divides b (Calcut, Rationality and the tangent function), and the square root at most halves
    that once more: roots of a lower degree are none.
    """
    if b > 32 * p.degree() ** 2 or 4 * p.degree() < _totient(b):  # phi(b) >= sqrt(b / 2)
        return False
    modulus = fmpq_poly(p)
    # numbers x + i sqrt(square) y as pairs (x, y)
    x, y = fmpq_poly([1]), fmpq_poly([0])
    for bit in bin(b)[2:]:
        x, y = (x * x - square * y * y) % modulus, (2 * x * y) % modulus
        if bit == "1":
            u = fmpq_poly([0, 1])
            x, y = (x - square * u * y) % modulus, (y + u * x) % modulus
    return y.is_zero()


def _totient(b: int) -> int:
    phi = b
    for prime, _ in fmpz(b).factor():
        phi -= phi // int(prime)
    return phi
