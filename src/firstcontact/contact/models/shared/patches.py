"""Patches that arcs bound: where to look for them, and the points of plane ones in order."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

# How far beside an arc to look, as a share of the height of the arc's middle above its chord: of a whole circle of its
# diameter.
_BESIDE = 0.05
# Between two arcs there may be little room.
_NEARER = 1.0, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12


def beside(arc: np.ndarray) -> np.ndarray:
    """(n, 3) points to either side of an arc given by points (n, 3), nearer and nearer to its middle."""
    n = len(arc)
    middle, chord = arc[n // 2], (arc[n // 4] + arc[(3 * n) // 4 % n]) / 2
    return np.array([middle + s * share * _BESIDE * (chord - middle) for share in _NEARER for s in (1, -1)])


def along_surface(form: np.ndarray, arc: np.ndarray) -> np.ndarray:
    """(2, 4) the same on the quadric of a form (4, 4) that holds the arc, homogeneous."""
    n = len(arc)
    middle, step = arc[n // 2], arc[(n // 2 + 1) % n] - arc[n // 2 - 1]
    across = np.cross((form @ np.append(middle, 1.0))[:3], step)
    reach = _BESIDE * np.linalg.norm(arc[n // 4] - arc[(3 * n) // 4 % n]) / np.linalg.norm(across)
    places = np.array([np.append(middle + s * reach * across, 1.0) for s in (1, -1)])
    for _ in range(4):  # Newton's method along the gradient
        gradients = 2.0 * places @ form
        values = np.einsum("ni,ni->n", gradients, places) / 2.0
        steps = values / np.einsum("ni,ni->n", gradients[:, :3], gradients[:, :3])
        places[:, :3] -= gradients[:, :3] * steps[:, None]
    return places


def border(arcs: Sequence[np.ndarray], corners: ArrayLike) -> np.ndarray:
    """(n, 3) the points of the arcs and the corners of a plane patch, in order about their middle."""
    points = np.concatenate([*arcs, np.reshape(corners, (-1, 3))])
    away = points - points.mean(axis=0)
    axes = np.linalg.svd(away, full_matrices=False)[2][:2]
    return points[np.argsort(np.arctan2(away @ axes[1], away @ axes[0]), kind="stable")]
