"""A closed mesh taken in by a depth: what of it lies deeper is in the mesh that is left.

All corners go inward by the depth at most, and so does every point of the surface, along a straight line.  A point that
is farther from the surface than that is passed by none of them, so the surface winds around it as often as before.
"""

from __future__ import annotations

import numpy as np

from firstcontact.body.polyhedron.polyhedron import Polyhedron

ROUNDING = 2.0**-50
"""Of the largest coordinate: far more than the roundings of a moved corner."""


def taken_in(mesh: Polyhedron, depth: float) -> Polyhedron | None:
    """The same triangles with corners up to `depth` farther in; None where rounding leaves nothing of the depth.

    Every point of the solid that is more than `depth` from its surface is inside of the result, which may cross itself.
    """
    points, triangles = mesh.vertices, mesh.triangles
    depth -= 2.0 * mesh.error + ROUNDING * float(np.abs(points).max())
    if depth <= 0.0:
        return None
    return Polyhedron(points - depth * (1.0 - ROUNDING) * _outward(points, triangles), triangles, solid=True)


def _outward(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(n, 3) at each corner the mean of its triangles' normals, by their angles there; of length 1 at most."""
    corners = points[triangles]
    sides = np.roll(corners, -1, axis=1) - corners
    normals = np.cross(sides[:, 0], sides[:, 1])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    back = -np.roll(sides, 1, axis=1)
    angles = np.arctan2(np.linalg.norm(np.cross(sides, back), axis=2), (sides * back).sum(axis=2))
    total = np.zeros_like(points)
    np.add.at(total, triangles.ravel(), (angles[..., None] * normals[:, None]).reshape(-1, 3))
    lengths = np.linalg.norm(total, axis=1, keepdims=True)
    outward: np.ndarray = total / np.maximum(lengths, 1e-300) * (1.0 - ROUNDING)
    return outward
