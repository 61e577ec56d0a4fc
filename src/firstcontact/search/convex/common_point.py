"""Two moving convex pieces about the time at which they touch, by their exact forms in balls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb

from firstcontact.body.solid.carriers import Surface
from firstcontact.exact.numbers import exact_value, to_double
from firstcontact.motion.relative.curved import CurvedPiece, inverse, terms
from firstcontact.search.convex.convex import HalfSpaces

BITS = 160
ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3), (3, 3))
"""Of a form's matrix, in the order of the coefficients in tables of pieces."""


@dataclass(frozen=True)
class Meeting:
    """A step of the motion, and the half-spaces of the piece of a and of that of b, each in its own frame."""

    motion: CurvedPiece
    own: HalfSpaces
    other: HalfSpaces

    def is_at(self, t: float, x: Sequence[float]) -> bool:
        """Whether the point (3,), in the frame of b, is proved to be in both pieces at a time."""
        with terms(1, BITS):
            there, here = self._places(t, x)
            return _holds(self.own[0], there) and _holds(self.other[0], here)

    def correction(
        self, t: float, x: Sequence[float], active: Sequence[tuple[int, int, float, list[float]]], rate: float
    ) -> float:
        """By how much later than t the pieces touch, where x and the multipliers are rounded, the forms are not.

        active: of each active form its side, number, multiplier and coefficients as the table of its piece has them.
        rate: of the sum of these forms times multipliers.  That sum has no gradient at the touch, so what x is off
        counts by its square.
        """
        with terms(1, BITS):
            places = self._places(t, x)
            total = arb(0)
            for side, number, multiplier, row in active:
                form = (self.own, self.other)[side][0][number]
                largest = max(range(10), key=lambda k: abs(row[k]))
                i, j = ENTRIES[largest]
                coefficient = to_double(form.matrix()[i][j]) * (1.0 if i == j else 2.0)
                total += multiplier * row[largest] / coefficient * form.value(places[side])
            return -float(total.mid()) / rate

    def _places(self, t: float, x: Sequence[float]) -> tuple[list[arb], list[arb]]:
        """The point of b's frame in that of a and in its own, homogeneous; under `terms`."""
        here = [arb(exact_value(c)) for c in x]
        back = inverse(self.motion.series(arb(exact_value(t))), self.motion.is_rigid)
        there = [row[0][0] * here[0] + row[1][0] * here[1] + row[2][0] * here[2] + row[3][0] for row in back]
        return [*there, arb(1)], [*here, arb(1)]


def _holds(forms: Sequence[Surface], point: list[arb]) -> bool:
    return all(form.value(point) <= 0 for form in forms)
