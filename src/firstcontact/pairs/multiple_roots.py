"""Multiple roots of det(l A - B) in l: for which u they appear, and what they are at one u.

The coefficients are polynomials in u.  The discriminant in l vanishes for every u when a multiple root is permanent
(spheres, concentric circles, surfaces of revolution about one axis); then the events are where two different factors
of the square-free part over Q(u) share a root, or one of them gets a double one (re-derived; the paper's
discriminant says nothing there).
"""

from __future__ import annotations

from typing import Any

from flint import Ordering, fmpz_mpoly, fmpz_mpoly_ctx, fmpz_poly

from firstcontact.pairs.carrier_contact import ONE, Equation, Radical, common_factor, sign

_BIVARIATE = fmpz_mpoly_ctx.get(("l", "u"), Ordering.lex)


def multiple_root_equation(coefficients: list[fmpz_poly]) -> Equation:
    """Equation of the u at which the polynomial (ascending in l) has a multiple root that it has not always.

    The u at which it vanishes identically are among them.
    """
    while coefficients and coefficients[-1] == 0:
        coefficients = coefficients[:-1]
    if not coefficients:
        return Equation(None, "identically zero: the pencil is degenerate")
    degree = len(coefficients) - 1
    if degree < 2:
        return Equation(common_factor(coefficients))
    polynomial = discriminant(coefficients)
    if polynomial == 0:
        polynomial = _square_free_equation(coefficients)
    return Equation(polynomial)


def discriminant(c: list[Any]) -> Any:
    """Discriminant of a polynomial of degree 2, 3 or 4, ascending, up to a positive constant; any commutative ring."""
    if len(c) == 3:
        return c[1] * c[1] - 4 * c[0] * c[2]
    if len(c) == 4:
        p, q, r = c[2] * c[2] - 3 * c[1] * c[3], c[1] * c[2] - 9 * c[0] * c[3], c[1] * c[1] - 3 * c[0] * c[2]
        return 4 * p * r - q * q  # three times the discriminant
    e, d, m, b, a = c
    i = 12 * a * e - 3 * b * d + m * m
    j = 72 * a * m * e + 9 * b * m * d - 27 * (a * d * d + e * b * b) - 2 * m * m * m
    return 4 * i * i * i - j * j  # 27 times the discriminant


def _square_free_equation(coefficients: list[fmpz_poly]) -> fmpz_poly:
    """Content times discriminants times mutual resultants of the distinct factors over Q(u)."""
    powers = {(i, k): int(x) for i, p in enumerate(coefficients) for k, x in enumerate(p.coeffs()) if x != 0}
    whole = _BIVARIATE.from_dict(powers)
    result = ONE
    factors = []
    for factor, _ in whole.factor_squarefree()[1]:
        if factor.degrees()[0] == 0:
            result *= _in_u(factor)
        else:
            factors.append(factor)
    for i, factor in enumerate(factors):
        if factor.degrees()[0] > 1:
            result *= _in_u(factor.discriminant("l"))
        for other in factors[:i]:
            result *= _in_u(factor.resultant(other, "l"))
    return result


def _in_u(p: fmpz_mpoly) -> fmpz_poly:
    powers = p.to_dict()
    coefficients = [0] * (1 + max((k[1] for k in powers), default=0))
    for k, x in powers.items():
        coefficients[k[1]] = x
    return fmpz_poly(coefficients)


def multiple_roots(coefficients: list[Any]) -> tuple[list[tuple[Any, Any, int]], bool]:
    """Real multiple roots of a polynomial over a field (ascending, not identically zero), degree at most 4.

    Rows (p, q, multiplicity) for the root p/q; a pair of double roots that needs a square root has `Radical`s.  The
    flag says that a complex pair of double roots was left out.
    """
    f = _trim(coefficients)
    if len(f) < 3:
        return [], False
    g = _gcd(f, [k * x for k, x in enumerate(f)][1:])
    degree = len(g) - 1
    if degree == 0:
        return [], False
    if degree != 2:  # x - l0, or its cube
        return [(-g[degree - 1], degree * g[degree], degree + 1)], False
    d = g[1] * g[1] - 4 * g[0] * g[2]
    side = sign(d)
    if side == 0:
        return [(-g[1], 2 * g[2], 3)], False
    if side < 0:
        return [], True
    zero = g[2] * 0
    return [(Radical(-g[1], zero + r, d), Radical(2 * g[2], zero, d), 2) for r in (-1, 1)], False


def _trim(f: list[Any]) -> list[Any]:
    n = len(f)
    while n and f[n - 1].is_zero():
        n -= 1
    return f[:n]


def _gcd(f: list[Any], g: list[Any]) -> list[Any]:
    """Greatest common divisor over a field by pseudo-remainders; each step lowers a degree."""
    f, g = _trim(f), _trim(g)
    while g:
        while len(f) >= len(g):
            shift = len(f) - len(g)
            lead, top = g[-1], f[-1]
            f = [lead * x - (top * g[k - shift] if k >= shift else 0) for k, x in enumerate(f[:-1])]
            f = _trim(f)
        f, g = g, f
    return f
