"""Resultants and discriminants of polynomials in two variables, interpolated between their values at whole numbers.

A value is the resultant of two polynomials in one variable, which FLINT computes modulo primes; elimination in two
variables by subresultants takes far longer where degrees are high (`benchmarks/COST.md`).  Polynomials are given by
*rows*: the coefficients of the powers of the variable that goes, ascending, polynomials in the one that stays.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import count, islice

from flint import fmpz, fmpz_poly

Rows = Sequence[fmpz_poly]

MANY = 12
"""Degrees of both in the variable that goes, together, from which values are quicker: by up to forty times at 48."""


def is_quicker(m: int, n: int) -> bool:
    """Whether values are, for polynomials of these degrees in the variable that goes."""
    return min(m, n) > 0 and m + n >= MANY


def resultant(f: Rows, g: Rows) -> fmpz_poly:
    """That of f and g, neither zero."""
    m, n = len(f) - 1, len(g) - 1
    most = m * _degree(g) + n * _degree(f)
    return _interpolated([f, g], most, lambda values: values[0].resultant(values[1]))


def discriminant(f: Rows) -> fmpz_poly:
    """That of f, of degree 2 or more."""
    return _interpolated([f], 2 * (len(f) - 2) * _degree(f), lambda values: values[0].discriminant())


def _degree(rows: Rows) -> int:
    return max(int(c.degree()) for c in rows)


def _interpolated(
    polynomials: Sequence[Rows], degree: int, ask: Callable[[list[fmpz_poly]], fmpz]
) -> fmpz_poly:
    """The polynomial of at most this degree with the values of `ask`, by Newton's divided differences.

    Places at which a leading coefficient vanishes are left out: the resultant there is not that of what is left.
    Divided differences of a polynomial over Z between whole numbers are whole, so all divisions are exact.
    """
    places = list(islice(_regular([rows[-1] for rows in polynomials]), degree + 1))
    known = [ask([fmpz_poly([c(x) for c in rows]) for rows in polynomials]) for x in places]
    for k in range(1, len(places)):
        known[k:] = [
            (later - former) // (x - y)
            for former, later, x, y in zip(known[k - 1 :], known[k:], places[k:], places, strict=False)
        ]
    total = fmpz_poly([])
    for x, c in zip(reversed(places), reversed(known), strict=True):
        total = total * fmpz_poly([-x, 1]) + c
    return total


def _regular(leading: Sequence[fmpz_poly]) -> Iterator[fmpz]:
    """Whole numbers at which none of these vanishes, small ones first: 0, 1, -1, 2, -2, ..."""
    every = (fmpz(-(k // 2) if k % 2 == 0 else (k + 1) // 2) for k in count())
    return (x for x in every if all(c(x) != 0 for c in leading))
