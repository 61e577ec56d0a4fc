"""What is drawn of ruled surfaces: triangles, their borders and some rulings; of whole rulings what is in sight."""

from __future__ import annotations

from typing import Any

import numpy as np

from firstcontact.body.ruled_mesh import ends_of, grid_triangles, parameters_of, piece_triangles, welded
from firstcontact.body.ruled_surface import RuledSurface
from firstcontact.errors import InputError
from firstcontact.result import Element

# Rulings drawn on a piece, and chords of a curve.
RULINGS, CHORDS = 17, 128
# Points along a ruling where trimming decides which parts of it are drawn.
POINTS = 65

Parts = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Vertices (n, 3), triangles (m, 3), the piece of each triangle (m,), and lines (k, 2) of vertex numbers."""


def bounded_parts(body: Any, tolerance: float) -> Parts:
    """A RuledSurface or RuledStrip with bounded rulings, at rest."""
    return _joined([_piece(piece, *piece_triangles(piece, tolerance)) for piece in body.pieces])


def parts_in_sight(body: Any, centre: np.ndarray, reach: float) -> Parts:
    """Of whole rulings: of each that comes within `reach` of the centre, `reach` to both sides of its nearest point."""
    return _joined([_window(piece, centre, reach) for piece in body.pieces])


def element_corners(body: Any, parts: Parts, element: Element) -> np.ndarray:
    """(3 k, 3) triangles of a face, (2 k, 3) ends of segments along a directrix or ruling, (1, 3) of a vertex."""
    vertices, triangles, owner, _ = parts
    if element.kind == "face":
        return vertices[triangles[owner == element.index].ravel()]
    per_piece = {"directrix": 2, "end_ruling": 2, "vertex": 4}.get(element.kind)
    if per_piece is None:
        raise ValueError(f"no picture for an element of kind {element.kind!r}")
    piece: RuledSurface = body.pieces[element.index // per_piece]
    number = element.index % per_piece
    lo, hi = ends_of(piece)
    if element.kind == "directrix":
        points = piece.sides[number].points(parameters_of(piece, np.linspace(lo, hi, CHORDS + 1)))
        return np.repeat(points, 2, axis=0)[1:-1]
    if element.kind == "end_ruling":
        u = parameters_of(piece, np.array([lo, hi]))[number]
        return np.array([side.points(u) for side in piece.sides])
    u = parameters_of(piece, np.array([lo, hi]))[number // 2]
    return piece.sides[number % 2].points(u)[None]


def _joined(found: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> Parts:
    """Pieces, each vertices, triangles and (2 k, 3) ends of its lines, in one numbering; the lines' ends come last."""
    count = np.cumsum([0, *(len(vertices) for vertices, _, _ in found)])
    triangles = [faces + start for (_, faces, _), start in zip(found, count, strict=False)]
    ends = np.concatenate([ends for _, _, ends in found])
    owner = np.repeat(np.arange(len(found)), [len(faces) for faces in triangles])
    vertices = np.concatenate([*(vertices for vertices, _, _ in found), ends])
    if not len(vertices):
        raise InputError("cannot draw a ruled surface of which nothing is in sight")
    return vertices, np.concatenate(triangles), owner, count[-1] + np.arange(len(ends)).reshape(-1, 2)


def _piece(piece: RuledSurface, points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    vertices, triangles = welded(points[triangles])
    sides, count = np.unique(
        np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0, return_counts=True
    )
    borders = vertices[sides[count == 1].ravel()]
    return vertices, triangles, np.concatenate([borders, _rulings(piece)])


def _rulings(piece: RuledSurface) -> np.ndarray:
    """(2 k, 3) ends of what trimming leaves of evenly spaced rulings."""
    assert piece.s is not None
    u = parameters_of(piece, np.linspace(*ends_of(piece), RULINGS))
    s = np.linspace(float(piece.s[0]), float(piece.s[1]), POINTS if piece.trim else 2)
    kept = piece.keeps(u[:, None], s)
    points = piece.points(u[:, None], s)
    segments = np.stack([points[:, :-1], points[:, 1:]], axis=2)
    return segments[kept[:, :-1] & kept[:, 1:]].reshape(-1, 3)


def _window(piece: RuledSurface, centre: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rulings as lines point + s direction, of moment point x direction, from their Pluecker coordinates."""
    u = parameters_of(piece, np.linspace(*ends_of(piece), 2 * CHORDS + 1))
    near, way, seen = _nearest(piece, u, centre)
    seen &= np.linalg.norm(near - centre, axis=1) <= reach
    turned = np.einsum("ni,ni->n", way[1:], way[:-1]) < 0
    way[1:] *= np.where(np.cumsum(turned) % 2 == 1, -1.0, 1.0)[:, None]  # neighbours point the same way
    grid = np.stack([near - reach * way, near + reach * way], axis=1)
    triangles = grid_triangles(len(u), 2)
    both = seen[:-1] & seen[1:]
    vertices, triangles = welded(grid.reshape(-1, 3)[triangles[np.tile(both, 2)]])
    drawn = np.flatnonzero(seen)[:: 2 * CHORDS // (RULINGS - 1)]
    return vertices, triangles, grid[drawn].reshape(-1, 3)


def _nearest(piece: RuledSurface, u: np.ndarray, centre: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of rulings: the point nearest to the centre (n, 3), unit direction (n, 3), whether it is a finite line (n,)."""
    p, q = (side.homogeneous(u) for side in (piece.first, piece.second))
    way = p[:, 3:] * q[:, :3] - q[:, 3:] * p[:, :3]
    moment = np.cross(p[:, :3], q[:, :3])
    length = np.linalg.norm(way, axis=1)
    finite = length > 1e-9 * np.linalg.norm(p, axis=1) * np.linalg.norm(q, axis=1)
    scale = np.where(finite, length, 1.0)[:, None]
    way, moment = way / scale, moment / scale
    return centre + np.cross(way, moment - np.cross(centre, way)), way, finite
