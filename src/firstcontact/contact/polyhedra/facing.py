"""Of pairs of elements that meet at one place, the normal that keeps the bodies best apart.

A vertex that lands on a corner touches all faces there, and the plane of a face that looks away from it parts nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.contact.polyhedra.earliest import Pair
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.search.trees.elements import FACE, Feature, vertices_of

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

# Of the size of what is near a place: as close as doubles tell what lies at it, and of unit vectors.
NEAR = 1e-9
# A few dozen roundings.
ROUNDING = 2.0**-48


def best_apart(
    a: Body, b: Body, time: float, pairs: list[Pair], point: np.ndarray, normals: Iterable[np.ndarray]
) -> np.ndarray:
    """The first of the normals, from b towards a, into which the bodies reach least about the point; world frame.  One
    that parts them the other way round is turned.

    pairs: those that meet, of which the bodies' elements at the point are taken.
    """
    spokes_a = _spokes(a, time, {pair[1] for pair in pairs}, point)
    spokes_b = _spokes(b, time, {pair[2] for pair in pairs}, point)
    spokes = np.vstack([spokes_a, -spokes_b])
    lengths = np.linalg.norm(spokes, axis=1)
    # far from the origin, doubles tell where corners are to no more than this
    near = max(NEAR, ROUNDING * float(np.abs(point).max()) / float(lengths.min(initial=np.inf)))
    best, least, seen = None, np.inf, list[np.ndarray]()
    for n in normals:
        reach = float((-(spokes @ n) / lengths).max(initial=0.0))
        if reach < least - near:
            best, least = n, reach
        if least <= near:
            break
        seen.append(n)
    assert best is not None  # there is one at least
    if least > near:  # corners that only pass each other move along a face, which does not tell its side
        return next((-n for n in seen if float((spokes @ n / lengths).max(initial=0.0)) <= near), best)
    return best


def _spokes(body: Body, time: float, elements: set[Feature], point: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) from the point to the other corners of the elements there, and of the triangles beside these."""
    shape = shape_of(body)
    corners = np.array(shape.vertices, float)
    if isinstance(body, Moving):
        pose = body.motion(time)
        corners = corners @ pose[:3, :3].T + pose[:3, 3]
    triangles = [t for kind, t in elements if kind == FACE]
    sides = [vertices_of(shape, e) for e in elements]
    beside = np.flatnonzero(np.isin(shape.triangles, [v for side in sides for v in side]).any(axis=1))
    facets = shape.triangles[sorted({*triangles, *beside.tolist()})]
    rounding = ROUNDING * float(np.abs(point).max())
    ways = [np.zeros((0, 3))]
    for cell in [*facets[_boxes_hold(point, corners[facets], rounding)].tolist(), *sides]:
        spokes = corners[cell] - point
        near = max(NEAR * float(np.abs(spokes).max()), rounding)
        if _is_at(spokes, near):
            ways.append(spokes[np.linalg.norm(spokes, axis=1) > near])
    return np.vstack(ways)


def _boxes_hold(point: np.ndarray, facets: np.ndarray, rounding: float) -> np.ndarray:
    """Whether the box of each triangle, of corners (n, 3, 3), holds the point; with more room than `_is_at` gives."""
    spokes = facets - point
    room = 4.0 * np.maximum(NEAR * np.abs(spokes).max(axis=(1, 2), initial=0.0), rounding)[:, None]
    holds = (spokes.min(axis=1) <= room) & (spokes.max(axis=1) >= -room)
    return np.asarray(holds.all(axis=1))


def _is_at(spokes: np.ndarray, near: float) -> bool:
    """Whether the origin lies in the hull of one, two or three points, to within a length."""
    p = spokes[0]
    sides = (spokes[1:] - p).T
    if not sides.size:
        return bool(np.linalg.norm(p) <= near)
    shares = np.linalg.lstsq(sides, -p, rcond=None)[0]
    inside = shares.min() >= -NEAR and shares.sum() <= 1.0 + NEAR
    return bool(inside and np.linalg.norm(p + sides @ shares) <= near)
