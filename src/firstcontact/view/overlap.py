"""The common part of two ruled surfaces that has an area, as triangles: for pictures only, nothing is proved here."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from firstcontact.body.ruled.mesh import Inequality, clipped, ends_of, grid_triangles, parameters_of
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.view.ruled import nearest

if TYPE_CHECKING:
    from firstcontact.body.kinds import Ruled
    from firstcontact.view.drawing import Drawing

COLUMNS, ROWS = 65, 17
# Rulings among which the one nearest to a point is looked for, and steps of the search between two of them.
RULINGS, STEPS = 65, 32
# A point this near to a surface, as a part of the size of the larger one, is on it.
NEAR = 1e-6
HALVINGS = 8
_GOLDEN = (5**0.5 - 1) / 2


def overlap_triangles(a: Drawing, b: Drawing) -> np.ndarray:
    """(m, 3, 3) corners: the common part of two ruled surfaces, of whole rulings what is drawn of a."""
    near = NEAR * max(a.frame[1], b.frame[1])
    for one, other in ((a, b), (b, a)):
        if one.body.bounded:
            parts = [_part(piece, other.body, near) for piece in one.body.pieces]
            return np.concatenate([np.empty((0, 3, 3)), *parts])
    on = _on(b.body, a.vertices, near)
    return a.vertices[a.triangles[on[a.triangles].all(axis=1)]]


def _on(body: Ruled, points: np.ndarray, near: float) -> np.ndarray:
    return np.any([distances(piece, points) <= near for piece in body.pieces], axis=0)


class _OnOther:
    """Stands for an inequality in the parameters of a piece: whether its point lies on the other body."""

    def __init__(self, piece: RuledSurface, other: Ruled, near: float) -> None:
        self.piece, self.other, self.near = piece, other, near

    def values(self, u: np.ndarray, s: np.ndarray) -> np.ndarray:
        return np.where(_on(self.other, self.piece.points(u, s), self.near), 1.0, -1.0)


def _part(piece: RuledSurface, other: Ruled, near: float) -> np.ndarray:
    """The part of a piece with bounded rulings, cut out of a grid of its parameters."""
    assert piece.s is not None
    x = np.linspace(*ends_of(piece), COLUMNS)
    s = np.linspace(float(piece.s[0]), float(piece.s[1]), ROWS)
    parameters = np.stack(np.broadcast_arrays(x[:, None], s), axis=-1).reshape(-1, 2)
    triangles = grid_triangles(COLUMNS, ROWS)
    conditions: list[Inequality] = [*piece.trim, _OnOther(piece, other, near)]
    for condition in conditions:
        parameters, triangles = clipped(parameters, triangles, condition, piece, HALVINGS)
    return piece.points(parameters_of(piece, parameters[:, 0]), parameters[:, 1])[triangles]


def distances(piece: RuledSurface, points: np.ndarray) -> np.ndarray:
    """(n,) from points (n, 3) to the piece; infinite where trimming leaves out the nearest point of it."""
    x = np.linspace(*ends_of(piece), RULINGS)
    found, _ = _to_rulings(piece, np.tile(x, len(points)), np.repeat(points, RULINGS, axis=0))
    best = found.reshape(-1, RULINGS).argmin(axis=1)
    lo, hi = x[best] - (x[1] - x[0]), x[best] + (x[1] - x[0])
    if piece.u is not None:
        lo, hi = np.maximum(lo, x[0]), np.minimum(hi, x[-1])
    for _ in range(STEPS):  # golden section: the distance has one minimum between neighbours of the best ruling
        left, right = hi - _GOLDEN * (hi - lo), lo + _GOLDEN * (hi - lo)
        nearer = _to_rulings(piece, left, points)[0] <= _to_rulings(piece, right, points)[0]
        lo, hi = np.where(nearer, lo, left), np.where(nearer, right, hi)
    middle = _around(piece, (lo + hi) / 2)
    distance, s = _to_rulings(piece, middle, points)
    if piece.trim:
        distance = np.where(piece.keeps(parameters_of(piece, middle), s), distance, np.inf)
    return distance


def _to_rulings(piece: RuledSurface, x: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n,) distances from points to the rulings at mesh parameters x, and (n,) s of the nearest points there."""
    u = parameters_of(piece, _around(piece, x))
    if piece.s is None:
        near, _, finite = nearest(piece, u, points)
        return np.where(finite, np.linalg.norm(near - points, axis=1), np.inf), np.zeros(len(x))
    start, end = (side.points(u) for side in piece.sides)
    along = end - start
    length = np.einsum("ni,ni->n", along, along)
    r = np.einsum("ni,ni->n", points - start, along) / np.where(length > 0, length, 1.0)
    r = np.clip(r, 0.0, 1.0)
    distance = np.linalg.norm(start + r[:, None] * along - points, axis=1)
    return distance, float(piece.s[0]) + r * float(piece.s[1] - piece.s[0])


def _around(piece: RuledSurface, x: np.ndarray) -> np.ndarray:
    """Mesh parameters beyond the ends of the whole projective line, where it closes, as ones within."""
    return x if piece.u is not None else (x + 1) % 4 - 1
