"""What is drawn of ruled surfaces: triangles, their borders and some rulings; of whole rulings what is in sight."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from firstcontact.body.ruled.mesh import clipped, ends_of, grid_triangles, parameters_of, piece_triangles, welded
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.errors import InputError
from firstcontact.result import Element

if TYPE_CHECKING:
    from firstcontact.body.kinds import Ruled

# Rulings drawn on a piece, and chords of a curve.
RULINGS, CHORDS = 17, 128
# Points along a ruling where trimming decides which parts of it are drawn.
POINTS = 65
# Rulings and points on each of a surface that deforms: the same at all times.
COLUMNS, ROWS = 97, 5

Parts = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Vertices (n, 3), triangles (m, 3), the piece of each triangle (m,), and lines (k, 2) of vertex numbers."""


def bounded_parts(body: Ruled, tolerance: float) -> Parts:
    """A RuledSurface or RuledStrip with bounded rulings, at rest."""
    return _joined([_piece(piece, *piece_triangles(piece, tolerance)) for piece in body.pieces])


def parts_in_sight(body: Ruled, centre: np.ndarray, reach: float) -> Parts:
    """Of whole rulings: of each that comes within `reach` of the centre, `reach` to both sides of its nearest point."""
    return _joined([_window(piece, centre, reach) for piece in body.pieces])


def deforming_parts(body: Ruled, times: np.ndarray) -> tuple[np.ndarray, Parts]:
    """(k,) those of the times at which all of it is finite, and the parts, whose vertices are (k, n, 3)."""
    if not body.bounded:
        raise InputError(f"cannot draw {body.name or 'a ruled surface'} while its whole rulings deform; give .at(t)")
    grids = [_grid(piece) for piece in body.pieces]
    with np.errstate(all="ignore"):
        frames = np.array([
            np.concatenate([_points_at(piece, x, t) for piece, (x, _, _) in zip(body.pieces, grids, strict=True)])
            for t in times
        ])  # fmt: skip
    finite = np.isfinite(frames).all(axis=(1, 2))
    if not finite.any():
        raise InputError(f"cannot draw {body.name or 'a ruled surface'}: it has a pole at every time; give .at(t)")
    count = np.cumsum([0, *(len(x) for x, _, _ in grids)])
    triangles, lines = (
        np.concatenate([grid[k] + start for grid, start in zip(grids, count, strict=False)]) for k in (1, 2)
    )
    owner = np.repeat(np.arange(len(grids)), [len(faces) for _, faces, _ in grids])
    return times[finite], (frames[finite], triangles, owner, lines)


def _grid(piece: RuledSurface) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Parameters (n, 2), u and s; triangles and lines (borders and rulings) of their numbers."""
    assert piece.s is not None
    x = np.linspace(*ends_of(piece), COLUMNS)
    s = np.linspace(float(piece.s[0]), float(piece.s[1]), ROWS)
    parameters = np.stack(np.broadcast_arrays(x[:, None], s), axis=-1).reshape(-1, 2)
    triangles = grid_triangles(COLUMNS, ROWS)
    for trim in piece.trim:
        parameters, triangles = clipped(parameters, triangles, trim, piece)
    used, triangles = np.unique(triangles, return_inverse=True)
    parameters, triangles = parameters[used], triangles.reshape(-1, 3)
    borders = _borders(triangles)
    if piece.u is None:  # the first ruling is the last
        at = parameters[borders][..., 0]
        borders = borders[(at[:, 0] != at[:, 1]) | ~np.isin(at[:, 0], x[[0, -1]])]
    rulings = _ruling_parameters(piece)
    parameters = np.column_stack([parameters_of(piece, parameters[:, 0]), parameters[:, 1]])
    lines = len(parameters) + np.arange(len(rulings)).reshape(-1, 2)
    return np.concatenate([parameters, rulings]), triangles, np.concatenate([borders, lines])


def _points_at(piece: RuledSurface, parameters: np.ndarray, t: float) -> np.ndarray:
    try:
        first, second = (side.at(t).points(parameters[:, 0]) for side in (piece.first, piece.second))
    except InputError:  # no curve at this time, as with the denominator T at 0
        return np.full((len(parameters), 3), np.nan)
    s = parameters[:, 1:]
    return (1 - s) * first + s * second


def _borders(triangles: np.ndarray) -> np.ndarray:
    """(k, 2) the sides that belong to one triangle."""
    sides, count = np.unique(
        np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0, return_counts=True
    )
    return sides[count == 1]


def element_corners(body: Ruled, parts: Parts, element: Element) -> np.ndarray:
    """(3 k, 3) triangles of a face, (2 k, 3) ends of segments along a directrix, ruling or edge, (1, 3) of a vertex."""
    vertices, triangles, owner, _ = parts
    if element.kind == "edge":
        borders = [(piece, k) for piece in body.pieces for k in range(len(piece.trim))]
        if element.index < len(borders):
            return _trim_border(*borders[element.index])
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


def _trim_border(piece: RuledSurface, number: int) -> np.ndarray:
    """(2 k, 3) ends of segments on the border of an inequality, where the others hold: its zeros on a grid's sides."""
    assert piece.s is not None
    x, s = np.linspace(*ends_of(piece), COLUMNS), np.linspace(float(piece.s[0]), float(piece.s[1]), COLUMNS)
    u, v = (c.ravel() for c in np.broadcast_arrays(parameters_of(piece, x)[:, None], s))
    triangles = grid_triangles(COLUMNS, COLUMNS)
    values = piece.trim[number].values(u, v)[triangles]
    others = piece._with(trim=piece.trim[:number] + piece.trim[number + 1 :]).keeps(u, v)
    near = others[triangles].all(axis=1) & (np.sign(values).min(axis=1) < 0) & (np.sign(values).max(axis=1) >= 0)
    places, values = np.stack([u, v], axis=1)[triangles[near]], values[near]
    ahead, after = np.roll(places, -1, axis=1), np.roll(values, -1, axis=1)
    crossed = (values < 0) != (after < 0)  # two sides of each triangle
    share = (values[crossed] / (values[crossed] - after[crossed]))[:, None]
    found = places[crossed] * (1 - share) + ahead[crossed] * share
    return piece.points(found[:, 0], found[:, 1])


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
    borders = vertices[_borders(triangles).ravel()]
    u, s = _ruling_parameters(piece).T
    return vertices, triangles, np.concatenate([borders, piece.points(u, s)])


def _ruling_parameters(piece: RuledSurface) -> np.ndarray:
    """(2 k, 2) u and s at the ends of what trimming leaves of evenly spaced rulings."""
    assert piece.s is not None
    u = parameters_of(piece, np.linspace(*ends_of(piece), RULINGS))
    s = np.linspace(float(piece.s[0]), float(piece.s[1]), POINTS if piece.trim else 2)
    kept = piece.keeps(u[:, None], s)
    grid = np.stack(np.broadcast_arrays(u[:, None], s), axis=-1)
    segments = np.stack([grid[:, :-1], grid[:, 1:]], axis=2)
    return segments[kept[:, :-1] & kept[:, 1:]].reshape(-1, 2)


def _window(piece: RuledSurface, centre: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rulings as lines point + s direction, of moment point x direction, from their Pluecker coordinates."""
    u = parameters_of(piece, np.linspace(*ends_of(piece), 2 * CHORDS + 1))
    near, way, seen = nearest(piece, u, centre)
    seen &= np.linalg.norm(near - centre, axis=1) <= reach
    turned = np.einsum("ni,ni->n", way[1:], way[:-1]) < 0
    way[1:] *= np.where(np.cumsum(turned) % 2 == 1, -1.0, 1.0)[:, None]  # neighbours point the same way
    grid = np.stack([near - reach * way, near + reach * way], axis=1)
    triangles = grid_triangles(len(u), 2)
    both = seen[:-1] & seen[1:]
    vertices, triangles = welded(grid.reshape(-1, 3)[triangles[np.tile(both, 2)]])
    moved = np.linalg.norm(np.diff(grid, axis=0), axis=2).max(axis=1)
    place = np.cumsum([0.0, *np.where(both, moved, 0.0)])  # rulings as far apart as they lie in sight
    drawn = np.unique(np.searchsorted(place, np.linspace(0, place[-1], RULINGS)))
    drawn = drawn[seen[drawn]]
    return vertices, triangles, grid[drawn].reshape(-1, 3)


def nearest(piece: RuledSurface, u: np.ndarray, centre: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of rulings: the point nearest to the centre (n, 3), unit direction (n, 3), whether it is a finite line (n,).

    centre: one point (3,), or one for each ruling (n, 3).
    """
    p, q = (side.homogeneous(u) for side in (piece.first, piece.second))
    way = p[:, 3:] * q[:, :3] - q[:, 3:] * p[:, :3]
    moment = np.cross(p[:, :3], q[:, :3])
    length = np.linalg.norm(way, axis=1)
    finite = length > 1e-9 * np.linalg.norm(p, axis=1) * np.linalg.norm(q, axis=1)
    scale = np.where(finite, length, 1.0)[:, None]
    way, moment = way / scale, moment / scale
    return centre + np.cross(way, moment - np.cross(centre, way)), way, finite
