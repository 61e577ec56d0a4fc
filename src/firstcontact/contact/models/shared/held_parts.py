"""Which parts of a conic two models may hold, as doubles tell it with proof: stretches, and spots left open.

Along X(t) = frame (cos t, sin t, 1) a form is a trigonometric polynomial F of degree 2.  With M a bound of its second
derivative it has one sign between two places at the distance h where |F| > M h^2 / 8 at both.  Stretches in which all
forms have one sign are held or not; others are halved until they are SHORT.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from firstcontact.body.solid.csg import Tree, outcomes, possible
from firstcontact.contact.models.shared.membership import On

TURN = 2.0 * math.pi
PARTS = 720
"""Stretches of a whole turn at the start."""
SHORT = 1e-11
"""Length of a stretch that is not halved further."""
SLACK = 1e-12
"""Values of forms that are not told from zero, in parts of what they are made of."""
ALONG = 100.0
"""So many times as much, and a form may vanish all along the conic, as far as doubles tell."""
MOST = 20_000
"""Stretches at once, beyond which they stay as they are."""


class ModelForms(NamedTuple):
    """A model: its tree, its forms (s, 4, 4), which of them hold the curve, and the faces asked for."""

    tree: Tree
    forms: np.ndarray
    holds: np.ndarray
    on: On


class ConicPart(NamedTuple):
    """From lo to hi; inner: a place that is held, or None for a spot that is left open."""

    lo: float
    hi: float
    inner: float | None


class FourierSeries(NamedTuple):
    """c + a cos t + b sin t + d cos 2t + e sin 2t, a row for each form."""

    c: np.ndarray
    a: np.ndarray
    b: np.ndarray
    d: np.ndarray
    e: np.ndarray

    @classmethod
    def of(cls, forms: np.ndarray, frame: np.ndarray) -> FourierSeries:
        g = np.einsum("ki,skl,lj->sij", frame, forms, frame)[..., None]
        return cls(0.5 * (g[:, 0, 0] + g[:, 1, 1]) + g[:, 2, 2], 2 * g[:, 0, 2], 2 * g[:, 1, 2],
                   0.5 * (g[:, 0, 0] - g[:, 1, 1]), g[:, 0, 1])  # fmt: skip

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """(forms, n) values."""
        cos, sin = np.cos(t), np.sin(t)
        twice = self.d * (cos * cos - sin * sin) + self.e * (2 * sin * cos)
        found: np.ndarray = self.c + self.a * cos + self.b * sin + twice
        return found

    @property
    def bend(self) -> np.ndarray:
        """(forms, 1): no second derivative is larger."""
        found: np.ndarray = np.hypot(self.a, self.b) + 4 * np.hypot(self.d, self.e)
        return found

    def turning(self, k: int, t: float, lo: float, hi: float) -> float:
        """Where form k turns between lo and hi; Newton from t."""
        for _ in range(8):
            cos, sin, cos2, sin2 = np.cos(t), np.sin(t), np.cos(2 * t), np.sin(2 * t)
            a, b, d, e = (float(x[k, 0]) for x in (self.a, self.b, self.d, self.e))
            slope = b * cos - a * sin + 2 * (e * cos2 - d * sin2)
            curve = -a * cos - b * sin - 4 * (d * cos2 + e * sin2)
            if curve == 0.0:
                break
            t = min(max(t - slope / curve, lo), hi)
        return float(t)


class HeldParts:
    """The parts of the conic that the models may hold.  nought: least size of coordinates, in parts of the largest."""

    def __init__(self, frame: np.ndarray, trims: Sequence[ModelForms], nought: float) -> None:
        self.frame, self.trims = frame, trims
        reach = np.abs(frame).sum(axis=1)
        reach = reach + nought * reach.max()
        self.series = [FourierSeries.of(trim.forms, frame) for trim in trims]
        self.slack = [SLACK * np.einsum("i,sij,j->s", reach, np.abs(trim.forms), reach)[:, None] for trim in trims]
        self.free = [trim.holds[:, None] | (self._size(s) <= ALONG * slack)
                     for trim, s, slack in zip(trims, self.series, self.slack, strict=True)]  # fmt: skip

    @staticmethod
    def _size(series: FourierSeries) -> np.ndarray:
        size: np.ndarray = sum((np.abs(x) for x in series), np.zeros_like(series.c))
        return size

    @property
    def along(self) -> list[tuple[int, int]]:
        """(model, form) of those that may vanish all along, but for those that hold the conic."""
        pairs = enumerate(zip(self.trims, self.free, strict=True))
        return [(m, int(k)) for m, (trim, free) in pairs for k in np.flatnonzero(free[:, 0] & ~trim.holds)]

    def found(self) -> list[ConicPart]:
        """Held stretches and open spots, in order."""
        h = TURN / PARTS
        lo = np.arange(PARTS) * h
        held: list[np.ndarray] = []
        while True:
            may, sure = self._told(lo, h)
            held.append(np.stack([lo[may & sure], np.full((may & sure).sum(), h)], axis=1))
            lo = lo[may & ~sure]
            if not len(lo) or h < SHORT or len(lo) > MOST:
                break
            h = 0.5 * h
            lo = np.concatenate([lo, lo + h])
        rows = np.concatenate([*(np.column_stack([x, np.ones(len(x))]) for x in held),
                               np.column_stack([lo, np.full(len(lo), h), np.zeros(len(lo))])])  # fmt: skip
        return list(self._joined(rows[np.argsort(rows[:, 0])]))

    def _told(self, lo: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
        """Of stretches: whether both models may hold some of it, and whether all forms have one sign there."""
        may, sure = np.ones(len(lo), bool), np.ones(len(lo), bool)
        for trim, series, slack, free in zip(self.trims, self.series, self.slack, self.free, strict=True):
            first, last = series(lo), series(lo + h)
            room = series.bend * (h * h / 8) + slack
            below = (np.minimum(first, last) < room) | free
            above = (np.maximum(first, last) > -room) | free
            may &= possible(trim.tree, below, above)[0]
            if trim.on.faces:
                may &= on_faces(trim.tree, below, above, trim.on)
            sure &= (~(below & above) | free).all(axis=0)
        return may, sure

    def _joined(self, rows: np.ndarray) -> Iterator[ConicPart]:
        """Neighbours as one, around the curve; rows: lo, length, whether held."""
        groups: list[list[tuple[float, float, float]]] = []
        for lo, h, is_held in rows.tolist():
            if groups and lo <= groups[-1][-1][0] + groups[-1][-1][1] + SHORT:
                groups[-1].append((lo, h, is_held))
            else:
                groups.append([(lo, h, is_held)])
        if len(groups) > 1 and groups[0][0][0] <= SHORT and sum(groups[-1][-1][:2]) >= TURN - SHORT:
            groups[0] = [(lo - TURN, h, is_held) for lo, h, is_held in groups.pop()] + groups[0]
        for group in groups:
            first, last = group[0][0], sum(group[-1][:2])
            held = [(h, lo) for lo, h, is_held in group if is_held]
            inner = 0.5 * (first + last)
            if held and not any(lo <= inner <= lo + h for h, lo in held):
                inner = max(held)[1] + 0.5 * max(held)[0]
            yield ConicPart(first, last, inner if held else None)

    def places(self, spot: ConicPart) -> list[float]:
        """Where more than a point of a spot is held, if anywhere: its middle, and where forms turn."""
        middle = 0.5 * (spot.lo + spot.hi)
        turns = [series.turning(k, middle, spot.lo, spot.hi)
                 for series, k in ((self.series[m], k) for m, k in self.open_forms(spot))]  # fmt: skip
        return [middle, *turns]

    def open_forms(self, spot: ConicPart) -> list[tuple[int, int]]:
        """(model, form) of those that may vanish in a spot."""
        ends, middle = np.array([spot.lo, spot.hi]), np.array([0.5 * (spot.lo + spot.hi)])
        found = []
        for m, (series, slack, free) in enumerate(zip(self.series, self.slack, self.free, strict=True)):
            values = np.concatenate([series(ends), series(middle)], axis=1)
            room = slack + series.bend * (spot.hi - spot.lo) ** 2
            told = (values > room).all(axis=1) | (values < -room).all(axis=1)
            found += [(m, int(k)) for k in np.flatnonzero(~told & ~free[:, 0])]
        return found

    def may_hold(self, spot: ConicPart) -> bool:
        """Whether some signs of the forms that may vanish in a spot are those of points of both models."""
        open_ = self.open_forms(spot)
        middle = np.array([0.5 * (spot.lo + spot.hi)])
        for m, (trim, series, free) in enumerate(zip(self.trims, self.series, self.free, strict=True)):
            signs = np.where(free[:, 0], 0, np.sign(series(middle)[:, 0])).astype(int)
            signs[[k for n, k in open_ if n == m]] = 0
            if True not in outcomes(trim.tree, signs.tolist()):
                return False
        return True

    def changes(self, m: int, k: int, spot: ConicPart, line: np.ndarray | None) -> int:
        """At least how many zeros the form has outside a spot.

        line: of a plane, the coefficients of (cos t, sin t, 1): its form has zeros at infinity too.
        """
        t = np.concatenate([[spot.hi], spot.hi + (TURN - (spot.hi - spot.lo)) * np.arange(1, PARTS) / PARTS,
                            [spot.lo + TURN]])  # fmt: skip
        if line is None:
            values, slack = self.series[m](t)[k], float(self.slack[m][k, 0])
        else:
            values = line @ np.stack([np.cos(t), np.sin(t), np.ones(len(t))])
            slack = SLACK * float(np.abs(line).sum())
        signs = np.sign(values[np.abs(values) > slack])
        return int((signs[1:] != signs[:-1]).sum())


def on_faces(tree: Tree, below: np.ndarray, above: np.ndarray, on: On) -> np.ndarray:
    """(n,) bools: the faces asked for may be there, where form i may be negative (below) or positive (above)."""
    there = {k: np.zeros(below.shape[1], bool) for k, _ in on.faces}
    for k, side in on.faces:
        free = [i for i in on.surfaces if i != k]
        for choice in product((True, False), repeat=len(free)):
            low, high = below.copy(), above.copy()
            for i, negative in zip(free, choice, strict=True):
                low[i], high[i] = negative, not negative
            sides = []
            for negative in (side > 0, side < 0):
                low[k], high[k] = negative, not negative
                sides.append(possible(tree, list(low.copy()), list(high.copy())))
            there[k] |= sides[0][0] & sides[1][1]
    enough: np.ndarray = np.sum(list(there.values()), axis=0) >= on.fewest
    return enough
