"""What is drawn of a part or an assembly: the triangles of its pieces, each with the element that it belongs to."""

from __future__ import annotations

import numpy as np

from firstcontact.body.compound.compound import Compound, CompoundPiece
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.result import Element
from firstcontact.view.geometry import sharp_edges


def parts(body: Compound) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (n, 3), triangles (m, 3) and lines (k, 2) of all that is shown of it."""
    vertices, triangles, lines, count = [], [], [], 0
    for piece in body.shown:
        mesh: Polyhedron = piece.body
        vertices.append(mesh.vertices)
        triangles.append(np.asarray(mesh.triangles, np.int64) + count)
        lines.append(sharp_edges(mesh) + count)
        count += len(mesh.vertices)
    return np.concatenate(vertices), np.concatenate(triangles), np.concatenate(lines)


def element_corners(body: Compound, element: Element) -> np.ndarray:
    """(1, 3) vertex, (2 k, 3) ends of segments along an edge, (3 m, 3) triangles of a face."""
    found = [_corners(piece, element) for piece in body.shown]
    return np.concatenate([np.empty((0, 3)), *found])


def _corners(piece: CompoundPiece, element: Element) -> np.ndarray:
    mesh: Polyhedron = piece.body
    if element.kind == "face":
        own = np.array([_is(piece, element, "face", k) for k in range(mesh.n_faces)])
        return mesh.vertices[mesh.triangles[own[mesh.triangle_face]].ravel()]
    if element.kind == "edge":
        sides = [k for k in range(len(mesh.edges)) if _is(piece, element, "edge", k)]
        return mesh.vertices[mesh.edges[sides].ravel()]
    return mesh.vertices[[k for k in range(len(mesh.vertices)) if _is(piece, element, "vertex", k)]]


def _is(piece: CompoundPiece, element: Element, kind: str, index: int) -> bool:
    return piece.element(Element(kind, "", index, ""), element.body) == element
