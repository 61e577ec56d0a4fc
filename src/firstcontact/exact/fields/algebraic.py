"""Minimal polynomials and isolating intervals of the numbers that rotations give."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from flint import arb, fmpq, fmpq_poly

from firstcontact.exact.fields.surd import Surd
from firstcontact.exact.numbers import PRECISIONS, ball, dyadic, fraction, precision
from firstcontact.exact.rigid import rational_sqrt
from firstcontact.result import AlgebraicNumber


def algebraic(x: Surd, k: fmpq) -> AlgebraicNumber | Fraction:
    """The number x sqrt(k), k > 0 rational: a Fraction where it is one."""
    root = rational_sqrt(k)
    if root is not None:
        x, k = x * root, fmpq(1)
    if x.d != 0 and (r := rational_sqrt(x.d)) is not None:
        x = Surd(x.x + x.y * r)
    if x.y == 0 or x.d == 0:
        if k == 1 or x.x == 0:
            return fraction(x.x)
        polynomial = fmpq_poly([-x.x * x.x * k, 0, 1])
    elif k == 1:
        polynomial = fmpq_poly([x.x * x.x - x.y * x.y * x.d, -2 * x.x, 1])
    else:
        # s = x sqrt k: (s^2 - k (p^2 + q^2 d))^2 = 4 k^2 p^2 q^2 d
        middle = k * (x.x * x.x + x.y * x.y * x.d)
        product = 2 * k * x.x * x.y
        polynomial = fmpq_poly([middle * middle - product * product * x.d, 0, -2 * middle, 0, 1])
    return isolate(polynomial, lambda: x.ball() * ball(k).sqrt())


def isolate(polynomial: fmpq_poly, enclose: Callable[[], arb]) -> AlgebraicNumber | Fraction:
    """The root of the polynomial that `enclose` encloses at the present precision: factor and isolating interval."""
    _, factors = polynomial.factor()
    for bits in PRECISIONS:
        with precision(bits):
            value = enclose()
            candidates = [f for f, _ in factors if _value(f, value).contains(0)]
        if len(candidates) != 1:
            continue
        (factor,) = candidates
        if factor.degree() == 1:
            return fraction(-fmpq(factor[0]) / fmpq(factor[1]))
        with precision(bits):
            lo, hi = dyadic(value.lower()), dyadic(value.upper())
            if _value(factor.derivative(), value).contains(0):
                continue
        whole = factor * factor.denom()
        coefficients = tuple(int(fmpq(whole[i]).p) for i in range(whole.degree() + 1))
        return AlgebraicNumber(coefficients, fraction(lo), fraction(hi))
    raise ArithmeticError("two roots agree to 2048 bits")


def _value(polynomial: fmpq_poly, x: arb) -> arb:
    total = arb(0)
    for i in range(polynomial.degree(), -1, -1):
        total = total * x + arb(fmpq(polynomial[i]))
    return total
