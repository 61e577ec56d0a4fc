"""How far points are from the branches of a curve."""

from __future__ import annotations

import numpy as np


def distance(points: np.ndarray, branches) -> float:
    """The largest one of the points to the polylines."""
    best = np.full(len(points), np.inf)
    for branch in branches:
        start, along = branch.points[:-1], np.diff(branch.points, axis=0)
        length = np.maximum((along * along).sum(1), 1e-300)
        for k, x in enumerate(points):
            t = np.clip(((x - start) * along).sum(1) / length, 0, 1)
            best[k] = min(best[k], np.linalg.norm(start + t[:, None] * along - x, axis=1).min())
    return float(best.max(initial=0.0))


def told_twice(curve) -> bool:
    """Whether an isolated point is on a branch."""
    return any(distance(x[None], curve.branches) <= 1e-9 * max(1.0, np.abs(x).max()) for x in curve.isolated_points
               if curve.branches)  # fmt: skip
