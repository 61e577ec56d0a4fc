"""A ruled piece as the numeric search sees it: its parameter range in parts, each with its directrices in doubles.

On every part the parameter is a + b x, or its inverse, with x in [-1, 1] exactly, so that all of the projective line is
covered by small numbers.  Coefficients are rounded once; the kernels count that rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from flint import fmpq, fmpq_poly, fmpz, fmpz_poly

from firstcontact.body.rational_curve import RationalCurve
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import rational, to_double
from firstcontact.exact.ruled_systems import Curve
from firstcontact.kernels.ruled_models import MOST_DEGREE

Coefficients = Sequence[Sequence[fmpq | int]]
"""c[i][j]: that of u^i T^j, exactly."""
Directrix = Sequence[Coefficients]
"""Four of them: X, Y, Z, W."""

OVERLAP = fmpq(1, 16)
"""How far, in units of half its length, a part may be exceeded where the next one begins."""


class Part(NamedTuple):
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
    def of(cls, sides: tuple[RationalCurve, RationalCurve], u: tuple[Any, Any] | None) -> RuledPiece:
        """The piece between two curves (`RuledSurface.sides`, `DirectrixPiece.p`) over this range of u."""
        ends = None if u is None else (rational(u[0], "u"), rational(u[1], "u"))
        return cls(sides[0].coefficients, sides[1].coefficients, ends)

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        return _closed_parts() if self.u is None else _range_parts(*self.u)

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
                for j, component in enumerate(self._local(k, i)):
                    for power, c in enumerate(component):
                        table[k, i, j, : len(c.coeffs()), power] = [to_double(x) for x in c.coeffs()]
            domain[k] = to_double(part.lowest), to_double(part.highest), *part.ends
        if not np.isfinite(table).all():
            raise UnsupportedPair("a ruled surface with numbers beyond the range of doubles")
        return table, domain

    def curves(self, part: int) -> tuple[Curve, Curve]:
        """The directrices over a part, exactly."""
        if part not in self._curves:
            first, second = (Curve(_by_power(self._local(part, i))) for i in range(2))
            self._curves[part] = first, second
        return self._curves[part]

    @cached_property
    def _curves(self) -> dict[int, tuple[Curve, Curve]]:
        return {}

    def _local(self, part: int, which: int) -> list[list[fmpq_poly]]:
        """For each component of a directrix, the coefficients of the powers of T as polynomials in x."""
        key = part, which
        if key not in self._locals:
            self._locals[key] = self._find_local(part, which)
        return self._locals[key]

    @cached_property
    def _locals(self) -> dict[tuple[int, int], list[list[fmpq_poly]]]:
        return {}

    def _find_local(self, part: int, which: int) -> list[list[fmpq_poly]]:
        inverted, middle, half = self.parts[part][:3]
        argument = fmpq_poly([middle, half])
        top = self.degrees[which]
        found = []
        for component in (self.first, self.second)[which]:
            rows = [list(row) for row in component]
            powers = []
            for j in range(max((len(row) for row in rows), default=0)):
                c = [row[j] if j < len(row) else fmpq(0) for row in rows]
                if inverted:
                    c = [c[top - i] if top - i < len(c) else fmpq(0) for i in range(top + 1)]
                powers.append(fmpq_poly(c)(argument))
            found.append(powers)
        return found


def _by_power(local: list[list[fmpq_poly]]) -> list[list[fmpz_poly]]:
    """The same over the integers, common denominators cleared, as coefficients of the powers of x."""
    common = fmpz(1)
    for component in local:
        for c in component:
            common = common.lcm(c.denom())
    found = []
    for component in local:
        n = max((len(c.coeffs()) for c in component), default=0)
        rows = [fmpz_poly([(common * c[i]).p for c in component]) for i in range(n)]
        found.append(rows or [fmpz_poly([0])])
    return found


def _closed_parts() -> tuple[Part, ...]:
    beyond = 1 + OVERLAP
    return tuple(Part(inverted, fmpq(0), fmpq(1), -beyond, beyond, (False, False)) for inverted in (False, True))


def _range_parts(lo: fmpq, hi: fmpq) -> tuple[Part, ...]:
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


def _part(inverted: bool, lo: fmpq, hi: fmpq, ends: tuple[bool, bool]) -> Part:
    # the next part is long enough for the overlap, see `_range_parts`
    lowest = fmpq(-1) if ends[0] else -1 - OVERLAP
    highest = fmpq(1) if ends[1] else 1 + OVERLAP
    return Part(inverted, (lo + hi) / 2, (hi - lo) / 2, lowest, highest, ends)
