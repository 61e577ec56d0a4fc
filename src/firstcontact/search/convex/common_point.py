"""Two moving convex pieces about the time at which they touch, by their exact forms in balls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb

from firstcontact.body.solid.carriers import Surface
from firstcontact.exact.numbers import exact_value
from firstcontact.motion.relative.curved import CurvedPiece, Series, inverse, terms
from firstcontact.search.convex.convex import HalfSpaces

BITS = 160
ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3), (3, 3))
"""Of a form's matrix, in the order of the coefficients in tables of pieces."""

Active = Sequence[tuple[int, int, float, list[float]]]
"""Of each active form its side, number, multiplier and coefficients as the table of its piece has them."""


@dataclass(frozen=True)
class PieceMeeting:
    """A step of the motion, and the half-spaces of the piece of a and of that of b, each in its own frame."""

    motion: CurvedPiece
    own: HalfSpaces
    other: HalfSpaces

    def is_at(self, t: float, x: Sequence[float]) -> bool:
        """Whether the point (3,), in the frame of b, is proved to be in both pieces at a time."""
        with terms(1, BITS):
            there, here = self._places(t, x)[0]
            return _holds(self.own[0], there) and _holds(self.other[0], here)

    def correction(self, t: float, x: Sequence[float], active: Active, rate: float) -> float:
        """By how much later than t the pieces touch, where x and the multipliers are rounded, the forms are not.

        rate: of the sum of these forms times multipliers.  That sum has no gradient at the touch, so what x is off
        counts by its square.
        """
        with terms(1, BITS):
            places, total = self._places(t, x)[0], arb(0)
            for side, number, multiplier, row in active:
                form = (self.own, self.other)[side][0][number]
                total += multiplier * _scale(form, row) * form.value(places[side])
            return -float(total.mid()) / rate

    def nearer(self, t: float, x: Sequence[float], active: Active) -> np.ndarray:
        """The place of the touch (3,), by a step of Newton's method with exact residuals from what doubles tell."""
        values, gradients, bends, weights = [], [], [], []
        with terms(1, BITS):
            places, back = self._places(t, x)
            turn = np.array([[float(c[0].mid()) for c in row[:3]] for row in back])
            for side, number, multiplier, row in active:
                place = places[side]
                frame = turn if side == 0 else None
                gradient, bend = _slopes(row, [float(c.mid()) for c in place[:3]])
                length = float(np.sqrt(gradient @ gradient))
                if not length > 0.0:  # at the tip of a cone
                    return np.array(x)
                form = (self.own, self.other)[side][0][number]
                values.append(float((form.value(place) * _scale(form, row)).mid()) / length)
                gradients.append((gradient if frame is None else gradient @ frame) / length)
                bends.append((bend if frame is None else frame.T @ bend @ frame) / length)
                weights.append(multiplier * length)
        total = sum(weights)
        if not total > 0.0:
            return np.array(x)
        step = _step(np.array(values), np.array(gradients), np.array(bends), np.array(weights) / total)
        return np.array(x) + step

    def _places(self, t: float, x: Sequence[float]) -> tuple[tuple[list[arb], list[arb]], Series]:
        """The point of b's frame in that of a and in its own, homogeneous, and the map to the first; under `terms`."""
        here = [arb(exact_value(c)) for c in x]
        back = inverse(self.motion.series(arb(exact_value(t))), self.motion.is_rigid)
        there = [row[0][0] * here[0] + row[1][0] * here[1] + row[2][0] * here[2] + row[3][0] for row in back]
        return ([*there, arb(1)], [*here, arb(1)]), back


def _scale(form: Surface, row: list[float]) -> arb:
    """By what a form is multiplied in the table of its piece."""
    largest = max(range(10), key=lambda k: abs(row[k]))
    i, j = ENTRIES[largest]
    return row[largest] / (arb(form.matrix()[i][j]) * (1 if i == j else 2))


def _slopes(row: list[float], p: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Gradient (3,) at a point, and second derivatives (3, 3), of a form as the table of its piece has it."""
    xx, yy, zz, xy, xz, yz, *linear, _ = row
    bend = np.array([[2.0 * xx, xy, xz], [xy, 2.0 * yy, yz], [xz, yz, 2.0 * zz]])
    return bend @ p + linear, bend


def _step(values: np.ndarray, units: np.ndarray, bends: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """(3,) towards where all forms are equal and a sum of their gradients, with weights of sum 1, vanishes.

    Values (n,), gradients (n, 3) and second derivatives (n, 3, 3) of forms with gradients of length 1, and weights (n,)
    near those.  Along what is flat the step stays where it is.
    """
    n = len(values)
    bend = (weights @ bends.reshape(n, 9)).reshape(3, 3)
    unit = 1.0 / (float(np.abs(bend).max()) or 1.0)
    system, right = np.zeros((n + 4, n + 4)), np.zeros(n + 4)
    system[:n, :3], system[:n, 3], right[:n] = units, -1.0, -values / unit
    system[n : n + 3, :3], system[n : n + 3, 4:], right[n : n + 3] = bend * unit, units.T, -(weights @ units)
    system[n + 3, 4:] = 1.0
    found: np.ndarray = np.linalg.lstsq(system, right, rcond=1e-9)[0][:3] * unit
    return found


def _holds(forms: Sequence[Surface], point: list[arb]) -> bool:
    return all(form.value(point) <= 0 for form in forms)
