"""When do polynomial conditions hold?  Systems of equations and inequalities in one variable, decided exactly."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cmp_to_key

from flint import fmpq, fmpz_poly

from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots
from firstcontact.exact.numbers import dyadic, precision


@dataclass(frozen=True, slots=True)
class ParameterConditions:
    """Polynomials that must vanish, be zero or more, and be more than zero, all at one parameter."""

    zero: tuple[fmpz_poly, ...]
    least: tuple[fmpz_poly, ...] = ()
    more: tuple[fmpz_poly, ...] = ()

    @property
    def lasting(self) -> bool:
        """Whether the equations hold at all times: then the conditions hold over intervals, not at instants."""
        return not any(self.zero)

    def events(self, lo: fmpq, hi: fmpq) -> list[AlgebraicRoot]:
        """The parameters of [lo, hi], ascending, outside of which nothing begins or ends."""
        common = fmpz_poly([0])
        for p in self.zero:
            common = common.gcd(p)
        if common != 0:
            return real_roots(common, lo, hi)
        found = [AlgebraicRoot.of(lo), AlgebraicRoot.of(hi)]
        for p in (*self.least, *self.more):
            if p.degree() > 0:
                found += real_roots(p, lo, hi)
        return distinct(found)

    def hold(self, root: AlgebraicRoot) -> bool:
        """Whether they hold at one of the events."""
        return all(root.sign_of(p) >= 0 for p in self.least) and all(root.sign_of(p) > 0 for p in self.more)

    def earliest(self, lo: fmpq, hi: fmpq) -> AlgebraicRoot | None:
        """The first event of [lo, hi] at which they hold.

        That is the first parameter at which they hold but where `more` is not empty and `lasting`: then they may hold
        from (not at) an event on.
        """
        return next((root for root in self.events(lo, hi) if self.hold(root)), None)


def distinct(roots: Iterable[AlgebraicRoot]) -> list[AlgebraicRoot]:
    """Ascending, each number once."""
    out: list[AlgebraicRoot] = []
    for root in sorted(roots, key=cmp_to_key(AlgebraicRoot.compare)):
        if not out or out[-1].compare(root) != 0:
            out.append(root)
    return out


def between(x: AlgebraicRoot, y: AlgebraicRoot) -> fmpq:
    """A rational number strictly between x < y."""
    bits = 64
    while not (left := x.enclosure(bits)) < (right := y.enclosure(bits)):
        bits *= 2
    with precision(bits):
        lo = dyadic(left.upper()) if x.rational is None else x.rational
        hi = dyadic(right.lower()) if y.rational is None else y.rational
    return (lo + hi) / 2
