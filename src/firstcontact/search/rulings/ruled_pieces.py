"""A ruled piece as the numeric search sees it: its parameter range in parts, each with its directrices in doubles.

On every part the parameter is a + b x, or its inverse, with x in [-1, 1] exactly, so that all of the projective line is
covered by small numbers.  Coefficients are rounded once; the kernels count that rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from flint import fmpq, fmpq_mat, fmpq_poly, fmpz, fmpz_poly

from firstcontact.body.ruled.rational_curve import RationalCurve
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import rational, to_double
from firstcontact.exact.systems.ruled_systems import Curve
from firstcontact.kernels.rulings.models import MOST_DEGREE

if TYPE_CHECKING:
    from fractions import Fraction

Coefficients = Sequence[Sequence[fmpq | int]]
"""c[i][j]: that of u^i T^j, exactly."""
Directrix = Sequence[Coefficients]
"""Four of them: X, Y, Z, W."""

OVERLAP = fmpq(1, 16)
"""How far, in units of half its length, a part may be exceeded where the next one begins."""


class RangePart(NamedTuple):
    """u = middle + half x, or its inverse, for lowest <= x <= highest; the part proper is |x| <= 1."""

    inverted: bool
    middle: fmpq
    half: fmpq
    lowest: fmpq
    highest: fmpq
    ends: tuple[bool, bool]
    """Whether x = -1 and x = 1 are ends of the piece."""

    def in_doubles(self, x: float) -> float | None:
        """u at x, rounded; None stands for infinity."""
        y = self.middle + self.half * fmpq(*float(x).as_integer_ratio())
        if self.inverted and y == 0:
            return None
        return to_double(1 / y if self.inverted else y)

    def side(self, of_x: int) -> int:
        """The end of u at the low (-1) or high (1) end of x."""
        return -of_x if self.inverted else of_x


@dataclass(frozen=True)
class RuledPiece:
    """P(u, s) = (1 - s) P1(u) + s P2(u), 0 <= s <= 1, with u in a closed range or, for None, on the projective line.

    Coefficients of the directrices are polynomials in time.
    """

    first: Directrix
    second: Directrix
    u: tuple[fmpq, fmpq] | None

    @classmethod
    def of(cls, sides: tuple[RationalCurve, RationalCurve], u: tuple[Fraction, Fraction] | None) -> RuledPiece:
        """The piece between two curves (`RuledSurface.sides`, `DirectrixPiece.p`) over this range of u."""
        ends = None if u is None else (rational(u[0], "u"), rational(u[1], "u"))
        return cls(sides[0].coefficients, sides[1].coefficients, ends)

    @cached_property
    def parts(self) -> tuple[RangePart, ...]:
        return _closed_parts() if self.u is None else _range_parts(*self.u)

    @property
    def off(self) -> tuple[float, float]:
        """How far the coefficients' points, and derivatives by the parameter and s, are from the piece at most."""
        return 0.0, 0.0

    def reversed(self) -> RuledPiece:
        """The same with time running backwards: at time -T."""
        first, second = (tuple(tuple(tuple(-a if j % 2 else a for j, a in enumerate(row)) for row in c) for c in d)
                         for d in (self.first, self.second))  # fmt: skip
        return RuledPiece(first, second, self.u)

    @cached_property
    def size(self) -> tuple[int, int]:
        """Degrees in u and in T, plus one each."""
        curves = [c for d in (self.first, self.second) for c in d]
        return max(len(c) for c in curves), max(len(row) for c in curves for row in c)

    @cached_property
    def degrees(self) -> tuple[int, int]:
        """Degree of either directrix in u, by which it is inverted."""
        first, second = (max((i for c in d for i, row in enumerate(c) if any(row)), default=0)
                         for d in (self.first, self.second))  # fmt: skip
        return first, second

    @cached_property
    def arrays(self) -> tuple[np.ndarray, np.ndarray]:
        """(parts, 2, 4, n, m) coefficients of x^i T^j; (parts, 4) lowest and highest x, whether they are ends."""
        n, m = self.size
        if max(n, m) > MOST_DEGREE + 1:
            raise UnsupportedPair(f"a ruled surface of degree {n - 1} in its parameter and {m - 1} in time")
        table = np.zeros((len(self.parts), 2, 4, n, m))
        domain = np.zeros((len(self.parts), 4))
        for k, part in enumerate(self.parts):
            for i in range(2):
                rows, below = self._local(k, i)
                divisor = int(below)
                try:  # the quotient of two whole numbers is rounded once
                    numbers = [int(c) / divisor for row in rows for c in row]
                except OverflowError as error:
                    raise UnsupportedPair("a ruled surface with numbers beyond the range of doubles") from error
                table[k, i, :, : len(rows)] = np.array(numbers).reshape(-1, 4, m).transpose(1, 0, 2)
            domain[k] = to_double(part.lowest), to_double(part.highest), *part.ends
        return table, domain

    def curves(self, part: int) -> tuple[Curve, Curve]:
        """The directrices over a part, exactly."""
        if part not in self._curves:
            self._curves[part] = Curve(self.components(part, 0)), Curve(self.components(part, 1))
        return self._curves[part]

    @cached_property
    def _curves(self) -> dict[int, tuple[Curve, Curve]]:
        return {}

    def components(self, part: int, which: int) -> list[list[fmpz_poly]]:
        """X, Y, Z, W of a directrix up to one factor: the coefficients of the powers of x, as polynomials in T."""
        rows, _ = self._local(part, which)
        m = self.size[1]
        found = [[fmpz_poly(row[j : j + m]) for row in rows] for j in range(0, 4 * m, m)]
        for c in found:
            while len(c) > 1 and not c[-1]:
                c.pop()
        return found

    def _local(self, part: int, which: int) -> tuple[list[list[fmpz]], fmpz]:
        """For every power of x the coefficients of the powers of T in X, then Y, Z, W; their common denominator."""
        key = part, which
        if key not in self._locals:
            self._locals[key] = self._find_local(part, which)
        return self._locals[key]

    @cached_property
    def _locals(self) -> dict[tuple[int, int], tuple[list[list[fmpz]], fmpz]]:
        return {}

    def _find_local(self, part: int, which: int) -> tuple[list[list[fmpz]], fmpz]:
        inverted, middle, half = self.parts[part][:3]
        n = self.degrees[which] + 1
        argument, powers = fmpq_poly([middle, half]), [fmpq_poly([1])]
        for _ in range(n - 1):
            powers.append(powers[-1] * argument)
        if inverted:
            powers.reverse()
        change = fmpq_mat(n, n, [p[k] for k in range(n) for p in powers])
        rows, below = (change * self._tables[which]).numer_denom()
        return rows.tolist(), below

    @cached_property
    def _tables(self) -> tuple[fmpq_mat, fmpq_mat]:
        """Of either directrix, for every power of u, the coefficients of the powers of T in X, then Y, Z, W."""
        m = self.size[1]
        found = []
        for directrix, degree in zip((self.first, self.second), self.degrees, strict=True):
            numbers = [row[j] if j < len(row) else 0 for i in range(degree + 1) for c in directrix
                       for row in [c[i] if i < len(c) else ()] for j in range(m)]  # fmt: skip
            found.append(fmpq_mat(degree + 1, 4 * m, numbers))
        return found[0], found[1]


def _closed_parts() -> tuple[RangePart, ...]:
    beyond = 1 + OVERLAP
    return tuple(RangePart(inverted, fmpq(0), fmpq(1), -beyond, beyond, (False, False)) for inverted in (False, True))


def _range_parts(lo: fmpq, hi: fmpq) -> tuple[RangePart, ...]:
    """[lo, hi] cut at -1 and 1 where it reaches well beyond; what is outside is inverted."""
    room = fmpq(1, 2)
    cuts = [lo, *(c for c in (fmpq(-1), fmpq(1)) if lo + room <= c <= hi - room), hi]
    parts = []
    for k, (a, b) in enumerate(zip(cuts, cuts[1:], strict=False)):
        ends = (k == 0, k == len(cuts) - 2)
        if a >= 1 or b <= -1:
            parts.append(_part(True, 1 / b, 1 / a, (ends[1], ends[0])))
        else:
            parts.append(_part(False, a, b, ends))
    return tuple(parts)


def _part(inverted: bool, lo: fmpq, hi: fmpq, ends: tuple[bool, bool]) -> RangePart:
    # the next part is long enough for the overlap, see `_range_parts`
    lowest = fmpq(-1) if ends[0] else -1 - OVERLAP
    highest = fmpq(1) if ends[1] else 1 + OVERLAP
    return RangePart(inverted, (lo + hi) / 2, (hi - lo) / 2, lowest, highest, ends)
