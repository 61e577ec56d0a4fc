"""Cusps on polylines found in doubles: where a branch passes the edge of regression of a developable piece.

There the normal P_u x P_s passes zero, as nowhere else: along a ruling of a developable it keeps its line.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyder, polyval

from firstcontact.body.kept import Kept
from firstcontact.contact.signs.pieces import RulingPiece
from firstcontact.curves.certified.chains import Chain
from firstcontact.curves.exactly.cusps import torsal_rulings

if TYPE_CHECKING:
    from firstcontact.body.ruled.surface import RuledSurface

_HAS_EDGE = Kept[bool]()
"""Whether a piece has an edge of regression."""
# Volumes of four control points, in parts of their sizes, above which a piece is certainly no developable; cosine of
# the turn of a normal that passes zero; lengths of normals, in parts of the largest, below which they show nothing.
NOT_FLAT, REVERSED, AT_EDGE = 1e-9, -0.5, 1e-9
# Newton's steps to a cusp and the gap at which they end, in parts of the size; the step by which the edge is
# differentiated, in parts of a range that is not shorter than this; parameters beyond which polylines are not looked
# at, and what divides at least.
STEPS, SETTLED, SLOPE, SHORTEST, FAR, LEAST = 12, 1e-13, 1e-2, 1e-6, 1e6, 1e-300


class Directrices(NamedTuple):
    """Of a surface in another parameter."""

    first: Any
    second: Any


def with_edges(chain: Chain) -> list[RuledSurface]:
    """The developable pieces with an edge of regression."""
    if any(_HAS_EDGE.get(piece) is None for piece in chain.pieces):
        flat = _may_be_flat(chain) if len(chain.irregular) else []
        for k, piece in enumerate(chain.pieces):
            _HAS_EDGE.put(piece, k in flat and not chain.is_regular(k) and _has_edge(piece))
    return [piece for piece in chain.pieces if _HAS_EDGE.get(piece)]


def passed(
    edged: Sequence[RuledSurface], others: Sequence[RuledSurface], parameters: np.ndarray
) -> list[tuple[int, int, np.ndarray, np.ndarray]]:
    """Where a polyline, given by u, v, s, t, passes the edge of regression of a piece, but for its ends.

    (rows before and after, point, parameters); rows between them are at the edge too.
    """
    found = []
    for surface in edged:
        inside = _inside(surface, parameters[:, 0])
        normals = np.where(inside[:, None], _normals(surface, parameters[:, 0], parameters[:, 2]), np.nan)
        sizes = np.linalg.norm(normals, axis=1)
        off = np.flatnonzero(sizes > AT_EDGE * np.nanmax(sizes, initial=0.0))
        unit = normals[off] / sizes[off, None]
        for n in np.flatnonzero((unit[1:] * unit[:-1]).sum(1) < REVERSED):
            i, j = int(off[n]), int(off[n + 1])
            piece = next((x for x in others if x.u is None or _inside(x, parameters[[i, j], 1]).all()), None)
            place = None if piece is None else _passing(surface, piece, parameters[i], parameters[j])
            if place is not None:
                found.append((i, j, *place))
    return sorted(found, key=lambda x: x[0])


def _inside(surface: RuledSurface, u: np.ndarray) -> np.ndarray:
    low, high = (-FAR, FAR) if surface.u is None else (float(x) for x in surface.u)
    return (u >= low) & (u <= high)


def _passing(
    own: RuledSurface, other: RuledSurface, before: np.ndarray, after: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """As _on_edge, v in the chart of 1/v where the other surface is closed and that is smaller."""
    if other.u is not None or min(abs(before[1]), abs(after[1])) <= 1.0:
        return _on_edge(own, other, before, after)
    before, after = (np.array([row[0], 1.0 / row[1], *row[2:]]) for row in (before, after))
    found = _on_edge(own, Directrices(other.first.reversed(), other.second.reversed()), before, after)
    if found is not None:
        found[1][1] = 1.0 / found[1][1] if found[1][1] else np.inf
    return found


def _on_edge(
    own: RuledSurface, other: RuledSurface | Directrices, before: np.ndarray, after: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """The point between two rows u, v, s, t at which the edge meets the other surface, and u, v, s, t there; Newton."""
    u, v, _, t = 0.5 * (before + after)
    step = SLOPE * max(abs(after[0] - before[0]), SHORTEST)
    for _ in range(STEPS):
        ahead, behind, edge = (_edge(own, x) for x in (u + step, u - step, u))
        ends, slopes = _ends(other, np.array([v]))
        point, along = ((1 - t) * x[0][0] + t * x[1][0] for x in (ends, slopes))
        matrix = np.stack([(ahead[:3] - behind[:3]) / (2 * step), -along, ends[0][0] - ends[1][0]], axis=1)
        gap = edge[:3] - point
        size = max(1.0, float(np.abs(point).max()))
        if np.abs(gap).max() <= SETTLED * size:
            inside = min(before[0], after[0]) <= u <= max(before[0], after[0])
            return (point, np.array([u, v, edge[3], t])) if inside else None
        if not (np.isfinite(matrix).all() and abs(np.linalg.det(matrix)) > LEAST):
            return None
        u, v, t = np.array([u, v, t]) - np.linalg.solve(matrix, gap)
    return None


def _edge(surface: RuledSurface, u: float) -> np.ndarray:
    """(4,) the point of the edge of regression on a ruling, and s there: where (P1' + s d') x d = 0, d = P2 - P1."""
    (first, second), (slope, other) = _ends(surface, np.array([u]))
    along = second[0] - first[0]
    turn = np.cross(other[0] - slope[0], along)
    s = -float(np.cross(slope[0], along) @ turn) / max(float(turn @ turn), LEAST)
    return np.append(first[0] + s * along, s)


def _may_be_flat(chain: Chain) -> list[int]:
    """Pieces on whose first part l and l' meet at the start, as far as doubles tell: control points in a plane."""
    firsts = np.unique(chain.piece_of, return_index=True)[1]
    corners = chain.points[firsts][:, :, :2]
    corners = np.concatenate([corners[:, :4].transpose(0, 2, 1), corners[:, 4:].transpose(0, 2, 1)], axis=1)
    sizes = np.maximum(np.linalg.norm(corners, axis=2), 1e-300)
    volumes = np.abs(np.linalg.det(corners / sizes[:, :, None]))
    return np.flatnonzero(volumes < NOT_FLAT).tolist()


def _has_edge(surface: RuledSurface) -> bool:
    """Whether all tangent planes touch along rulings, which do not pass through one point; exactly."""
    rulings = RulingPiece.of(surface).rulings
    return bool(torsal_rulings(rulings) == 0 and rulings.apex is None)


def _normals(surface: RuledSurface, u: np.ndarray, s: np.ndarray) -> np.ndarray:
    """(n, 3) P_u x P_s."""
    (first, second), (slope, other) = _ends(surface, u)
    return np.cross((1 - s)[:, None] * slope + s[:, None] * other, second - first)


def _ends(surface: RuledSurface | Directrices, u: np.ndarray) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """(n, 3) points of both directrices, and derivatives."""
    points, slopes = [], []
    for curve in (surface.first, surface.second):
        rows = [np.array([float(c) for c in x.coeffs()] or [0.0]) for x in curve.components]
        with np.errstate(all="ignore"):
            *values, w = (polyval(u, x) for x in rows)
            *changes, dw = (polyval(u, polyder(x)) for x in rows)
            points.append(np.stack([x / w for x in values], axis=1))
            slopes.append(np.stack([(dx * w - x * dw) / w**2 for x, dx in zip(values, changes, strict=True)], axis=1))
    return points, slopes
