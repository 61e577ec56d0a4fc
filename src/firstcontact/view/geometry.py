"""Lines and corners to draw on a polyhedron: sharp edges and single elements."""

from __future__ import annotations

import math

import numpy as np

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.result import Element

# Edges are drawn where the surface bends by more than this.  Smaller: scanned meshes turn into wire nets;
# larger: gear flanks and bevels lose their outline.
SHARP = math.radians(35)


def sharp_edges(body: Polyhedron) -> np.ndarray:
    """(k, 2) vertex indices of the edges worth drawing: sharp ones, borders, and all of a bare edge set."""
    if not len(body.triangles):
        return np.asarray(body.edges, np.int64).reshape(-1, 2)
    sides, owner = _sides(np.asarray(body.triangles, np.int64))
    order = np.lexsort((sides[:, 1], sides[:, 0]))
    sides, owner = sides[order], owner[order]
    starts = np.flatnonzero(np.r_[True, np.any(sides[1:] != sides[:-1], axis=1)])
    count = np.diff(np.r_[starts, len(sides)])
    normals = _normals(body)
    drawn = count != 2  # borders, and edges where more than two triangles meet
    two = starts[~drawn]
    bend = np.einsum("ij,ij->i", normals[owner[two]], normals[owner[two + 1]])
    # Neighbours that run through the edge in the same direction are oriented against each other.
    drawn[~drawn] = np.abs(bend) < math.cos(SHARP)
    return sides[starts[drawn]]


def element_vertices(body: Polyhedron, element: Element) -> np.ndarray:
    """Corners of an element in the body's frame: (1, 3) vertex, (2, 3) edge, (3 m, 3) triangles of a face."""
    if element.kind == "vertex":
        return body.vertices[[element.index]]
    if element.kind == "edge":
        return body.vertices[body.edges[element.index]]
    if element.kind == "face":
        return body.vertices[body.triangles[body.triangle_face == element.index].ravel()]
    raise ValueError(f"no picture for an element of kind {element.kind!r}")


def face_outline(body: Polyhedron, index: int) -> np.ndarray:
    """(2 k, 3) ends of the border segments of polygon `index`: sides that belong to one of its triangles."""
    sides, _ = _sides(np.asarray(body.triangles[body.triangle_face == index], np.int64))
    unique, count = np.unique(sides, axis=0, return_counts=True)
    return body.vertices[unique[count == 1].ravel()]


def _sides(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(3 m, 2) sides with the smaller vertex first, and (3 m,) the triangle of each."""
    sides = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    return sides, np.repeat(np.arange(len(triangles)), 3)


def _normals(body: Polyhedron) -> np.ndarray:
    """(m, 3) unit normals of the triangles; zero for triangles without area."""
    p, q, r = (body.vertices[body.triangles[:, k]] for k in range(3))
    normals = np.cross(q - p, r - p)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
