"""An equation from conditions x y <= 0: where x y is nowhere negative, they hold at its zeros alone.

Where all rulings of two pieces are parallel, Delta is zero and tells nothing.  But both ends of a ruling of Q are then
equally far from any plane through a ruling of P: their brackets are one polynomial up to a positive factor.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import prod

from flint import fmpq, fmpz_mpoly

from firstcontact.exact.fields.roots import roots_in
from firstcontact.exact.numbers import sign
from firstcontact.exact.polynomials.trivariate import RING, FactorSet, degree, product, univariate

Range = tuple[fmpq, fmpq] | None


def forced_equation(pairs: Iterable[tuple[fmpz_mpoly, fmpz_mpoly]], u: Range, v: Range) -> fmpz_mpoly:
    """A polynomial that is zero wherever x y <= 0 for all pairs, u and v in their ranges; zero where none is found.

    Of several the one of least degree, without multiple factors.
    """
    found = [f for x, y in pairs if not x.is_zero() and not y.is_zero() and (f := _forced(x, y, u, v)) is not None]
    return min(found, key=lambda f: sum(int(d) for d in f.degrees()), default=RING.constant(0))


def _forced(x: fmpz_mpoly, y: fmpz_mpoly, u: Range, v: Range) -> fmpz_mpoly | None:
    """The zeros of x y, where it is nowhere negative; None where that is not proved."""
    both = FactorSet()
    both.add(x)
    both.add(y)
    odd = [f for f in both if both.count(f) % 2]
    signs = [_one_sign(f, u, v) for f in odd]
    leading = sign(x.leading_coefficient()) * sign(y.leading_coefficient())
    # factors come with positive leading coefficients, and the leading term of a product is that of the leading terms
    if leading * prod(signs) <= 0:
        return None
    return product(f for f in both if both.count(f) % 2 == 0 and not _one_sign(f, u, v))


def _one_sign(f: fmpz_mpoly, u: Range, v: Range) -> int:
    """The sign of an irreducible polynomial in u or v alone that has no zero in its range; 0 for others."""
    used = [k for k in range(3) if degree(f, k)]
    if used not in ([0], [1]):
        return 0
    ends, p = (u, v)[used[0]], univariate(f, used[0])
    if roots_in(p, ends) or (ends is None and p.degree() % 2):
        return 0
    return sign(p(ends[0] if ends else fmpq(0)))
