"""Ruled surfaces as cells: control points of both sides of a part, and which part of the surface that is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq, fmpq_poly, fmpz_poly

from firstcontact.contact.signs.conditions import local_trims, reversed_trims
from firstcontact.contact.signs.exclusion import halves
from firstcontact.contact.torus.cells import Cells
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import to_double
from firstcontact.exact.polynomials.bernstein import coefficients
from firstcontact.search.events.charts import NotCharted
from firstcontact.search.events.ruled_charts import ChartSheet, sheets_of

if TYPE_CHECKING:
    from firstcontact.body.ruled.surface import RuledSurface

MOST_HALVINGS = 12
"""Of parts whose weights are not all positive."""


def sheets_at_rest(ruled: RuledSurface) -> list[ChartSheet]:
    """The sheets of a ruled surface.  Raises UnsupportedPair for what is no net of points."""
    who = ruled.name or "the ruled surface"
    if ruled.deforming:
        raise UnsupportedPair(f"{who} deforms, which is not followed beside a torus; take .at(t)")
    if not ruled.bounded:
        raise UnsupportedPair(f"{who} has whole rulings, which are not followed beside a torus; bound s")
    try:
        return sheets_of(ruled, [(given, reversed_trims(given)) for given in map(local_trims, ruled.pieces)])
    except NotCharted as reason:
        raise UnsupportedPair(f"{reason}, which is not followed beside a torus") from reason


class Nets(Cells):
    """Rows: number of a sheet; x from, to; s from, to; homogeneous points of the first side, then of the other."""

    def __init__(self, ruled: RuledSurface) -> None:
        self.sheets = sheets_at_rest(ruled)
        self.order = max(sheet.degree for sheet in self.sheets) + 1
        rows = self.all()
        weights = self._homogeneous(rows)[..., 3]
        self.off = float(np.abs(self.points(rows)).max() * weights.max() / weights.min()) * 2.0**-46
        """Weights are positive; roundings of halves, again and again."""

    def samples(self) -> np.ndarray:
        """The corners of sheets: those that inequalities leave."""
        rows = self.all()
        rows = rows[[not self.sheets[int(row[0])].cuts for row in rows]]
        if not len(rows):
            return np.empty((0, 3))
        ends = self.points(rows).reshape(len(rows), 2, self.order, 3)[:, :, [0, -1]]
        return ends.reshape(-1, 3)

    def all(self) -> np.ndarray:
        rows = np.array([self._row(k, sheet) for k, sheet in enumerate(self.sheets)])
        for _ in range(MOST_HALVINGS):
            rows[:, 5:] *= np.where(self._homogeneous(rows)[:, 0, 0, 3] < 0.0, -1.0, 1.0)[:, None]
            good = np.all(self._homogeneous(rows)[..., 3] > 0.0, axis=(1, 2))
            if good.all():
                return rows
            rows = np.concatenate([rows[good], self._halves_in_x(rows[~good])])
        raise UnsupportedPair("a directrix comes near a pole, which is not followed beside a torus; shorten u")

    def points(self, cells: np.ndarray) -> np.ndarray:
        x = self._homogeneous(cells).reshape(len(cells), -1, 4)
        found: np.ndarray = x[..., :3] / x[..., 3:]
        return found

    def away(self, cells: np.ndarray) -> np.ndarray:
        x, w = self.points(cells).reshape(len(cells), 2, self.order, 3), self._homogeneous(cells)[..., 3]
        bent = np.abs(x[:, :, 2:] - 2.0 * x[:, :, 1:-1] + x[:, :, :-2]).sum(axis=(1, 2, 3))
        uneven = w.max(axis=(1, 2)) / w.min(axis=(1, 2)) - 1.0
        found: np.ndarray = self.order * bent + uneven * np.ptp(x.reshape(len(cells), -1, 3), axis=1).max(axis=1)
        return found

    def halves(self, cells: np.ndarray) -> np.ndarray:
        """Without those that the surface's inequalities cut off."""
        x = self.points(cells).reshape(len(cells), 2, self.order, 3)
        along = np.sqrt(((x[:, :, 1:] - x[:, :, :-1]) ** 2).sum(axis=3)).sum(axis=2).max(axis=1)
        across = np.sqrt(((x[:, 1] - x[:, 0]) ** 2).sum(axis=2)).max(axis=1)
        longer = along > across
        found = np.concatenate([self._halves_in_x(cells[longer]), self._halves_in_s(cells[~longer])])
        kept: np.ndarray = found[self._may_be_kept(found)]
        return kept

    def seeds(self, cells: np.ndarray, pose: np.ndarray) -> list[np.ndarray]:
        """(number of the sheet, x, s) of their middles."""
        return list(np.column_stack([cells[:, 0], 0.5 * (cells[:, 1:4:2] + cells[:, 2:5:2])]))

    def _row(self, number: int, sheet: ChartSheet) -> list[float]:
        sides = sheet.first, sheet.second
        largest = max(int(abs(c)) for side in sides for p in side for c in p.coeffs())
        return [float(number), -1.0, 1.0, 0.0, 1.0, *(c for side in sides for c in self._net(side, largest))]

    def _net(self, side: list[fmpz_poly], largest: int) -> list[float]:
        """Bernstein's coefficients over [-1, 1], one point after the other."""
        rows = [coefficients(fmpq_poly(p, largest), fmpq(-1), fmpq(1), self.order - 1) for p in side]
        return [to_double(row[k]) for k in range(self.order) for row in rows]

    def _homogeneous(self, cells: np.ndarray) -> np.ndarray:
        """(n, 2, order, 4)."""
        return cells[:, 5:].reshape(len(cells), 2, self.order, 4)

    def _halves_in_x(self, cells: np.ndarray) -> np.ndarray:
        return _parts(cells, 1, *np.split(halves(self._homogeneous(cells), 2), 2))

    def _halves_in_s(self, cells: np.ndarray) -> np.ndarray:
        return _parts(cells, 3, *np.split(halves(self._homogeneous(cells), 1), 2))

    def _may_be_kept(self, cells: np.ndarray) -> np.ndarray:
        """(n,) False where an inequality of the surface fails all over the cell."""
        kept = np.ones(len(cells), bool)
        for k, sheet in enumerate(self.sheets):
            mine = np.flatnonzero(cells[:, 0] == k)
            for cut in sheet.cuts:
                x, a = 0.5 * (cells[mine, 1] + cells[mine, 2]), 0.5 * (cells[mine, 2] - cells[mine, 1])
                s, b = 0.5 * (cells[mine, 3] + cells[mine, 4]), 0.5 * (cells[mine, 4] - cells[mine, 3])
                value, room = 0.0 * x, 0.0 * x
                for j, p in enumerate(cut.powers):
                    for i, c in enumerate(p.coeffs()):
                        factor = to_double(fmpq(c, cut.size))
                        value = value + factor * x**i * s**j
                        room = room + abs(factor) * (i * a + j * b + 1e-13)
                kept[mine] &= ~(value < -room)
        return kept


def _parts(cells: np.ndarray, at: int, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Both halves of the range in columns at, at + 1, with their points."""
    net = len(cells), cells.shape[1] - 5
    one = np.column_stack([cells[:, :5], low.reshape(net)])
    other = np.column_stack([cells[:, :5], high.reshape(net)])
    one[:, at + 1] = other[:, at] = 0.5 * (cells[:, at] + cells[:, at + 1])
    return np.concatenate([one, other])
