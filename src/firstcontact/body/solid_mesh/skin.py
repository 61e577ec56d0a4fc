"""The faces of a solid as triangles with smooth normals, as pictures have them."""

from __future__ import annotations

import numpy as np

from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid_mesh.quadric_mesh import face_triangles


def skin(
    body: CompositeQuadric, tolerance: float, lo: np.ndarray, hi: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """As `face_triangles`, and the normals (n, 3, 3) at the corners."""
    corners, owner = face_triangles(body, tolerance, lo, hi)
    return corners, owner, _normals(body, corners, owner)


def _normals(body: CompositeQuadric, corners: np.ndarray, owner: np.ndarray) -> np.ndarray:
    """(n, 3, 3) outward unit normals at the corners: gradients of the faces' forms; of triangles at tips of cones."""
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(flat, axis=1, keepdims=True)
    flat = np.divide(flat, length, out=np.zeros_like(flat), where=length > 0)
    normals = np.repeat(flat[:, None], 3, axis=1)
    x = np.concatenate([corners, np.ones((*corners.shape[:2], 1))], axis=2)
    for face in body.faces:
        form = face.orientation * body.forms[face.surfaces[0]]
        own = owner == face.index
        gradient = (x[own] @ form)[..., :3]
        steep = np.linalg.norm(gradient, axis=2, keepdims=True)
        clear = steep > 1e-7 * steep.max(initial=0.0)
        normals[own] = np.where(clear, gradient / np.where(clear, steep, 1.0), normals[own])
    return normals
