"""Polynomials in Bernstein form over an interval: the values lie between the least and the largest coefficient."""

from __future__ import annotations

import math
from collections.abc import Mapping

from flint import fmpq, fmpq_poly, fmpz, fmpz_poly


def coefficients(p: fmpz_poly | fmpq_poly, lo: fmpq, hi: fmpq, degree: int) -> list[fmpq]:
    """The degree + 1 Bernstein coefficients of p over [lo, hi], exactly; degree >= that of p.

    The first and the last are the values at the ends.
    """
    moved = fmpq_poly(p)(fmpq_poly([lo, hi - lo]))
    scaled = [fmpq(moved[j]) / math.comb(degree, j) for j in range(degree + 1)]
    return [sum((math.comb(i, j) * scaled[j] for j in range(i + 1)), fmpq(0)) for i in range(degree + 1)]


def zero_between(p: fmpz_poly, lo: fmpq, hi: fmpq, width: fmpq) -> tuple[fmpq, fmpq] | None:
    """The first zero of p in the closed [lo, hi], as an interval at most `width` wide; None proves there is none.

    p must not be the zero polynomial.  Descartes' rule in Bernstein form: no sign change, no zero inside; one sign
    change, exactly one.  Repeated factors are divided out first, so halving comes to an end (Vincent's theorem).
    """
    p = p // p.gcd(p.derivative()) if p.degree() > 0 else p
    waiting = [(lo, hi)]
    # `waiting` holds, last one first, the intervals that may have a zero; all before them have none.
    while waiting:
        left, right = waiting.pop()
        values = coefficients(p, left, right, max(p.degree(), 0))
        if values[0] == 0:
            return left, left
        if values[-1] == 0 and _changes(values) == 0:
            return right, right
        changes = _changes(values)
        if changes == 1 and right - left <= width:
            return left, right
        if changes:
            middle = (left + right) / 2
            waiting += [(middle, right), (left, middle)]
    return None


def _changes(values: list[fmpq]) -> int:
    signs = [v > 0 for v in values if v != 0]
    return sum(x != y for x, y in zip(signs, signs[1:], strict=False))


def grid(
    terms: Mapping[tuple[int, int], fmpz], first: tuple[fmpq, fmpq], second: tuple[fmpq, fmpq], degrees: tuple[int, int]
) -> list[list[fmpq]]:
    """Bernstein coefficients of the polynomial sum c x^i y^j, for c = terms[i, j], over the box first x second.

    Row i, column j of (degrees[0] + 1) x (degrees[1] + 1); the values on the box lie between the least and the largest.
    """
    rows: list[list[fmpz]] = [[fmpz(0)] * (degrees[0] + 1) for _ in range(degrees[1] + 1)]
    for (i, j), c in terms.items():
        rows[j][i] = c
    in_x = [coefficients(fmpz_poly(row), *first, degrees[0]) for row in rows]
    if degrees[1] == 0:
        return [[c] for c in in_x[0]]
    return [coefficients(fmpq_poly(list(column)), *second, degrees[1]) for column in zip(*in_x, strict=True)]
