"""Cells of a ruled piece with their boxes, in doubles with room for rounding: which triangles may meet the piece."""

from __future__ import annotations

import numpy as np

from firstcontact.curves.certified.chains import Chain

HALVINGS = 4
"""Of every part along u; along its rulings it is cut into as many cells."""
ROUNDING = 1e-11


class Cover:
    """sides  (cells along u, 2, n + 1, 3) points whose hull holds both sides of a cell."""

    def __init__(self, chain: Chain, k: int) -> None:
        parts = chain.points[chain.piece_of == k]
        for _ in range(HALVINGS):
            parts = np.concatenate(_halves(parts))
        self.sides = np.stack([parts[:, i : i + 3] / parts[:, i + 3 : i + 4] for i in (0, 4)], axis=1).swapaxes(2, 3)
        self.slack = ROUNDING * float(np.abs(self.sides).max())
        self.r = np.linspace(0.0, 1.0, 2**HALVINGS + 1)
        self.low, self.high = (self._ends(x) for x in (self.sides.min(2), self.sides.max(2)))
        self.low = np.minimum(self.low[:, :-1], self.low[:, 1:]) - self.slack
        self.high = np.maximum(self.high[:, :-1], self.high[:, 1:]) + self.slack

    def _ends(self, bounds: np.ndarray) -> np.ndarray:
        """(cells along u, ends along r, ...) of bounds of both sides (cells, 2, ...)."""
        first, second = bounds[:, 0, None], bounds[:, 1, None]
        r = self.r.reshape(1, -1, *[1] * (bounds.ndim - 2))
        return (1 - r) * first + r * second

    def near(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Indices of those of boxes (n, 3) that meet the box of a cell."""
        whole = (self.low.min((0, 1)), self.high.max((0, 1)))
        found = np.flatnonzero((low <= whole[1]).all(1) & (high >= whole[0]).all(1))
        low, high = low[found], high[found]
        meet = np.zeros(len(found), bool)
        for a, b in zip(self.low.reshape(-1, 3), self.high.reshape(-1, 3), strict=True):
            meet |= (low <= b).all(1) & (high >= a).all(1)
        return found[meet]

    def may_cross(self, normal: np.ndarray, low: np.ndarray, high: np.ndarray) -> bool:
        """Whether a cell that meets the box has points on both sides of the plane normal . (x, y, z, 1) = 0."""
        values = self.sides @ normal[:3] + normal[3]
        least, most = self._ends(values.min(2)), self._ends(values.max(2))
        slack = 4 * (self.slack * np.abs(normal[:3]).sum() + ROUNDING * abs(normal[3]))
        cut = (np.minimum(least[:, :-1], least[:, 1:]) <= slack) & (np.maximum(most[:, :-1], most[:, 1:]) >= -slack)
        return bool((cut & (self.low <= high).all(2) & (self.high >= low).all(2)).any())


def _halves(parts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Bernstein coefficients (parts, 8, n + 1) of both halves."""
    left, right, row = [parts[..., 0]], [parts[..., -1]], parts
    while row.shape[-1] > 1:
        row = 0.5 * (row[..., :-1] + row[..., 1:])
        left.append(row[..., 0])
        right.append(row[..., -1])
    return np.stack(left, axis=-1), np.stack(right[::-1], axis=-1)
