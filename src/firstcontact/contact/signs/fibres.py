"""How many rulings v of q meet one ruling u of p at one time, exactly; one of u and T may be irrational."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import reduce

from flint import fmpq, fmpq_poly, fmpz_mpoly, fmpz_poly

from firstcontact.contact.signs.conditions import Conditions
from firstcontact.contact.signs.sheets import samples
from firstcontact.exact.fields.roots import AlgebraicRoot, roots_in
from firstcontact.exact.polynomials import bivariate
from firstcontact.exact.polynomials.trivariate import at, coefficients, terms, univariate


class Moment:
    """One rational T, for many u: what is left then of polynomials in u, v and T, as those in u by powers of v."""

    def __init__(self, t: fmpq) -> None:
        self.t = t
        self._known: dict[int, tuple[fmpz_mpoly, list[fmpz_poly]]] = {}

    def over(self, f: fmpz_mpoly, u: fmpq) -> fmpz_poly:
        """A positive multiple of f there, in v."""
        if id(f) not in self._known:
            self._known[id(f)] = f, [univariate(p, 0) for p in coefficients(at(f, 2, self.t), 1)]
        return fmpq_poly([p(u) for p in self._known[id(f)][1]]).numer()


@dataclass(frozen=True)
class RulingFibre:
    """All v over one u and T: what is left there of polynomials in u, v and T.  moment: of T, where that is rational
    and it is known already."""

    u: AlgebraicRoot
    t: AlgebraicRoot
    moment: Moment | None = None
    _known: dict[int, tuple[fmpz_mpoly, fmpz_poly | fmpz_mpoly]] = field(default_factory=dict)

    def zeros(self, f: fmpz_mpoly) -> fmpz_poly:
        """A polynomial in v that vanishes where f does; zero only where f is zero at all v."""
        rest = self._restricted(f)
        if isinstance(rest, fmpz_poly):
            return rest
        if rest.is_zero():
            return fmpz_poly([])
        return bivariate.resultant(bivariate.in_u(self._moving.polynomial), rest, "u")

    def sign(self, f: fmpz_mpoly, v: AlgebraicRoot) -> int:
        rest = self._restricted(f)
        if rest.is_zero():
            return 0
        return v.sign_of(rest) if isinstance(rest, fmpz_poly) else bivariate.sign_at(rest, self._moving, v)

    @property
    def _moving(self) -> AlgebraicRoot:
        """The one that may be irrational."""
        return self.t if self.t.rational is None else self.u

    def _restricted(self, f: fmpz_mpoly) -> fmpz_poly | fmpz_mpoly:
        """In v; in v and the irrational one, where one is."""
        if id(f) not in self._known:
            self._known[id(f)] = f, self._rest(f)  # f is kept, so that no other one gets its number
        return self._known[id(f)][1]

    def _rest(self, f: fmpz_mpoly) -> fmpz_poly | fmpz_mpoly:
        if self.moment is not None and self.u.rational is not None:
            return self.moment.over(f, self.u.rational)
        if self.t.rational is not None:
            f = at(f, 2, self.t.rational)
        if self.u.rational is not None:
            f = at(f, 0, self.u.rational)
        if self._moving.rational is not None:
            return univariate(f, 1)
        return bivariate.polynomial({(i + k, j): c for (i, j, k), c in terms(f)})


def count(c: Conditions, u: AlgebraicRoot, t: AlgebraicRoot, moment: Moment | None = None) -> float:
    """The number of v that meet the ruling u at the time t; infinite for a range of them.

    moment: as for a `RulingFibre`.
    """
    if c.u is not None and not (u.compare(c.u[0]) >= 0 and u.compare(c.u[1]) <= 0):
        return 0
    if not all(c.bounded) and t.rational is not None and c.moment != t.rational:
        c = c.at(t.rational)  # of whole rulings, which may lose a factor then
    fibre, found = RulingFibre(u, t, moment), 0

    def meets(conditions: Conditions, v: AlgebraicRoot) -> bool:
        return conditions.holds(lambda f: fibre.sign(f, v))

    if c.v is None:  # v = infinity
        found += meets(c.charts[False, True], AlgebraicRoot.of(fmpq(0)))
    zeros = fibre.zeros(c.delta)
    if not zeros.is_zero():
        return found + sum(meets(c, v) for v in roots_in(zeros, c.v))
    walls = [fibre.zeros(f) for f in c.polynomials]
    critical = roots_in(reduce(lambda x, y: x * y, (w for w in walls if not w.is_zero()), fmpz_poly([1])), c.v)
    if any(meets(c, AlgebraicRoot.of(v)) for v in samples(critical, c.v)):
        return math.inf
    return found + sum(meets(c, v) for v in critical)
