"""Whether a point that was found alone lies on what else two surfaces share: a piece may pass through it twice."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.polynomial.polynomial import polyder, polyval

from firstcontact.contact.signs.pieces import RulingPiece
from firstcontact.curves.exactly.tracing import Powers, Surfaces, rows
from firstcontact.pairs.ruled_ruled import DUAL
from firstcontact.result_curve import Branch

# Points this near, in parts of their size, are one.
ONE_POINT = 1e-8
# Halvings of a chord, and Newton's steps in each.
HALVINGS, STEPS = 52, 12


def is_on_lines(point: np.ndarray, lines: Iterable[np.ndarray], whole: bool = False) -> bool:
    """Whether it is on one of the segments (2, 3); whole: on the lines that these are of."""
    near = _near(point)
    for start, end in lines:
        along = end - start
        share = (point - start) @ along / (along @ along)
        foot = start + (share if whole else min(max(share, 0.0), 1.0)) * along
        if np.abs(point - foot).max() <= near:
            return True
    return False


def is_on_branches(
    point: np.ndarray, branches: Iterable[Branch], p: Sequence[RulingPiece], q: Sequence[RulingPiece], tolerance: float
) -> bool:
    """Whether a branch of these pieces, between the points of its polyline too, passes through it."""
    near = _near(point)
    for branch in branches:
        if (np.abs(branch.points - point).max(1) <= near).any():
            return True
        start, along = branch.points[:-1], np.diff(branch.points, axis=0)
        share = ((point - start) * along).sum(1) / np.maximum((along * along).sum(1), 1e-300)
        off = np.linalg.norm(start + share[:, None] * along - point, axis=1)
        for k in np.flatnonzero((share > 0.0) & (share < 1.0) & (off <= 2.0 * tolerance + near)):
            ends = branch.parameters[k : k + 2, :2]
            own, other = (
                next((x for x in pieces if _holds(x, u)), None) for pieces, u in zip((p, q), ends.T, strict=True)
            )
            if own is None or other is None:
                continue
            if np.abs(_Chord(own, other, ends).nearest(point, along[k]) - point).max() <= near:
                return True
    return False


def _near(point: np.ndarray) -> float:
    return ONE_POINT * max(1.0, float(np.abs(point).max()))


def _holds(piece: RulingPiece, u: np.ndarray) -> bool:
    return piece.u is None or bool(float(piece.u[0]) <= u.min() and u.max() <= float(piece.u[1]))


class _Chord:
    """The curve between two of its points, given by u and v, in charts in which these are finite."""

    def __init__(self, p: RulingPiece, q: RulingPiece, ends: np.ndarray) -> None:
        self.surfaces = Surfaces(p, q)
        self.reverse = np.abs(ends).min(0) > 1.0
        with np.errstate(divide="ignore"):
            self.ends = np.where(self.reverse, 1.0 / ends, ends)
        lines = [rows(x.reversed_rulings(bool(r)).line) for x, r in zip((p, q), self.reverse, strict=True)]
        self.run = int(np.argmax(np.abs(self.ends[1] - self.ends[0])))
        # Delta is symmetric in the two lines
        self.fixed, self.moving = lines[self.run], np.array([lines[1 - self.run][j] * sign for j, sign in DUAL])

    def nearest(self, point: np.ndarray, along: np.ndarray) -> np.ndarray:
        """The point of the curve on the plane through this one across the chord."""
        low, high = 0.0, 1.0
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            found = self._at(middle)
            if (found - point) @ along < 0.0:
                low = middle
            else:
                high = middle
        return found

    def _at(self, share: float) -> np.ndarray:
        place = (1.0 - share) * self.ends[0] + share * self.ends[1]
        delta = polyval(place[self.run], self.fixed.T) @ self.moving
        slope = polyder(delta)
        for _ in range(STEPS):
            change = polyval(place[1 - self.run], slope)
            if change == 0.0:
                break
            place[1 - self.run] -= polyval(place[1 - self.run], delta) / change
        at = (Powers(place[k : k + 1], self.reverse[k : k + 1]) for k in range(2))
        return self.surfaces.points(*at)[0][0]
