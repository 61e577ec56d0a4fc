"""Pieces of ruled surfaces: whole families of lines, or parts bounded in u, in s, and by polynomial inequalities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from flint import fmpq, fmpz, fmpz_mpoly, fmpz_poly

from firstcontact.body.kept import Kept
from firstcontact.body.ruled.rational_curve import terms
from firstcontact.exact.fields.roots import AlgebraicRoot, reversed_polynomial
from firstcontact.exact.numbers import dyadic, fraction, precision, rational
from firstcontact.pairs.ruled_ruled import Parameter, Rulings

if TYPE_CHECKING:
    from fractions import Fraction

    from firstcontact.body.ruled.surface import RuledSurface
    from firstcontact.exact.ring import Rational

Inequality = Mapping[tuple[int, int], int]
"""sum c[i, j] u^i s^j >= 0."""

P = TypeVar("P", fmpz_poly, fmpz_mpoly)
_PIECE = Kept["RulingPiece"]()


@dataclass(frozen=True)
class RulingPiece:
    """The part of a ruled surface with u in the closed interval (None: the projective line) and 0 <= s <= 1.

    rulings    directrices at s = 0 and s = 1, their weights positive on the piece where it is bounded
    bounded    whether s is bounded at all
    s_range    what the user calls s = 0 and s = 1 here
    trim       polynomials in u and this s that are not negative on the piece
    shift      the parameter here is 1 / (u - shift) for the user's u; None where it is u itself
    """

    rulings: Rulings
    u: tuple[fmpq, fmpq] | None
    bounded: bool
    s_range: tuple[fmpq, fmpq] = (fmpq(0), fmpq(1))
    trim: tuple[Inequality, ...] = ()
    shift: int | None = None

    @classmethod
    def of(cls, surface: RuledSurface) -> RulingPiece:
        """That of a RuledSurface at rest, kept on it."""
        return _PIECE.of(surface, lambda: cls._of(surface))

    @classmethod
    def _of(cls, surface: RuledSurface) -> RulingPiece:
        first, second = (side.components for side in surface.sides)
        s = (fmpq(0), fmpq(1)) if surface.s is None else _ends(surface.s)
        trim = tuple(g for t in surface.trim if (g := _substituted(terms(t.polynomial), s)))
        u = range_of(surface.u)
        return cls(Rulings.of(first, second), u, surface.s is not None, s, trim)

    def away_from_infinity(self, shift: int) -> RulingPiece:
        """The same with the parameter 1 / (u - shift): the ruling at infinity becomes that at 0."""
        r = self.rulings
        first, second, line = (_moved(x, shift) for x in (r.first, r.second, r.line))
        rulings = Rulings(first, second, line, _moved((r.common,), shift)[0])  # type: ignore[arg-type]
        return replace(self, rulings=rulings, trim=tuple(_trim_moved(g, shift) for g in self.trim), shift=shift)

    def reversed_rulings(self, reverse: bool) -> Rulings:
        return self.rulings.reversed() if reverse else self.rulings

    def user_parameter(self, own: Parameter) -> Parameter:
        """The user's u of a parameter here."""
        if self.shift is None:
            return own
        if own is None:
            return AlgebraicRoot.of(fmpq(self.shift))
        if own.rational is not None:
            return None if own.rational == 0 else AlgebraicRoot.of(self.shift + 1 / own.rational)
        ball = own.enclosure(96)
        with precision(192):
            lo, hi = dyadic(ball.lower()), dyadic(ball.upper())
        shifted = reversed_polynomial(own.polynomial, own.polynomial.degree())(fmpz_poly([-self.shift, 1]))
        return AlgebraicRoot(shifted, self.shift + 1 / hi, self.shift + 1 / lo)

    def user_s(self, s: np.ndarray) -> np.ndarray:
        """The user's s of values here (floats), of points of the piece.

        Beside the size of their coordinates short rulings may be no more than rounding: that leads out of no bounds.
        """
        low, high = (float(fraction(x)) for x in self.s_range)
        own = s if (low, high) == (0.0, 1.0) else low + (high - low) * s
        return np.clip(own, low, high) if self.bounded else own


def at_place(
    g: Mapping[tuple[int, int], Rational], u: P, n: P, d: P, power: int | None = None
) -> P:
    """d^power g(u, n / d), by default with the least power that leaves no denominator; an even one keeps signs."""
    top = max((j for _, j in g), default=0) if power is None else power
    return sum((u**i * n**j * d ** (top - j) * int(c) for (i, j), c in g.items()), 0 * d)


def range_of(u: tuple[Fraction, Fraction] | None) -> tuple[fmpq, fmpq] | None:
    """A surface's range of u."""
    return None if u is None else _ends(u)


def _ends(interval: tuple[Fraction, Fraction]) -> tuple[fmpq, fmpq]:
    return rational(interval[0], "range"), rational(interval[1], "range")


def _moved(polynomials: Sequence[fmpz_poly], shift: int) -> tuple[fmpz_poly, ...]:
    degree = max(x.degree() for x in polynomials)
    return tuple(reversed_polynomial(x(fmpz_poly([shift, 1])), degree) for x in polynomials)


def _trim_moved(g: Inequality, shift: int) -> Inequality:
    rows: dict[int, dict[int, int]] = {}
    for (i, j), c in g.items():
        rows.setdefault(j, {})[i] = c
    even = max(i for i, _ in g)
    even += even % 2  # an even power of the denominator keeps the sign
    found: dict[tuple[int, int], int] = {}
    for j, row in rows.items():
        polynomial = fmpz_poly([row.get(i, 0) for i in range(max(row) + 1)])(fmpz_poly([shift, 1]))
        found.update({(i, j): int(c) for i, c in enumerate(reversed_polynomial(polynomial, even).coeffs()) if c})
    return found


def _substituted(g: Mapping[tuple[int, int], fmpz], bounds: tuple[fmpq, fmpq]) -> Inequality:
    """g(u, s) with s = bounds[0] + (bounds[1] - bounds[0]) s', times a positive number that makes it whole."""
    low, width = bounds[0], bounds[1] - bounds[0]
    total: dict[tuple[int, int], fmpq] = {}
    for (i, j), c in g.items():
        power = [fmpq(c)]
        for _ in range(j):  # times (low + width s')
            power = [x + y for x, y in zip([low * a for a in power] + [fmpq(0)],
                                           [fmpq(0)] + [width * a for a in power], strict=True)]  # fmt: skip
        for k, x in enumerate(power):
            total[i, k] = total.get((i, k), fmpq(0)) + x
    scale = fmpz(1)
    for x in total.values():
        scale = scale.lcm(x.q)
    return {key: int(x.p * (scale // x.q)) for key, x in total.items() if x}
