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
    from firstcontact.body.polyhedron.polyhedron import Polyhedron

# Of the size of what is near a place: as close as doubles tell what lies at it, and of unit vectors.
NEAR = 1e-9
# A few dozen roundings.
ROUNDING = 2.0**-48


def best_apart(
    a: Body, b: Body, time: float, pairs: list[Pair], point: np.ndarray, normals: Iterable[np.ndarray]
) -> np.ndarray:
    """The first of the normals, from b towards a, into which the bodies reach least about the point; world frame.

    pairs: those that meet, of which the bodies' elements at the point are taken.  normals: of those of them in whose
    planes the bodies do not move; where none of these parts the bodies, the other planes are tried, which may.
    """
    both = [(shape_of(body), _corners(body, time)) for body in (a, b)]
    met = [{pair[1] for pair in pairs}, {pair[2] for pair in pairs}]
    spokes_a, spokes_b = (_spokes(*body, elements, point) for body, elements in zip(both, met, strict=True))
    spokes = np.vstack([spokes_a, -spokes_b])
    lengths = np.linalg.norm(spokes, axis=1)
    # far from the origin, doubles tell where corners are to no more than this
    near = max(NEAR, ROUNDING * float(np.abs(point).max()) / float(lengths.min(initial=np.inf)))
    best, least, seen = None, np.inf, list[np.ndarray]()

    def reach(n: np.ndarray) -> float:
        return float((-(spokes @ n) / lengths).max(initial=0.0))

    for n in normals:
        if reach(n) < least - near:
            best, least = n, reach(n)
        if least <= near:
            break
        seen.append(n)
    assert best is not None  # there is one at least
    if least <= near:
        return best
    planes = (
        _across(*(corners[vertices_of(shape, e)] for (shape, corners), e in zip(both, pair[1:], strict=True)))
        for pair in pairs
    )
    others = [n for n in planes if n is not None and not any(abs(n @ told) > 1.0 - NEAR for told in seen)]
    return next((side for n in others for side in (n, -n) if reach(side) <= near), best)


def _across(cell_a: np.ndarray, cell_b: np.ndarray) -> np.ndarray | None:
    """The unit normal of the plane that two elements span, of either side; None where they span none."""
    ways = [x for cell in (cell_a, cell_b) for x in cell[1:] - cell[0] if x.any()]
    if len(ways) < 2:
        return None
    n = np.cross(ways[0], ways[1])
    size = float(np.linalg.norm(n))
    return None if size <= NEAR * float(np.linalg.norm(ways[0]) * np.linalg.norm(ways[1])) else n / size


def _corners(body: Body, time: float) -> np.ndarray:
    """Of a polyhedron, (n, 3), where they are then."""
    corners = np.array(shape_of(body).vertices, float)
    if isinstance(body, Moving):
        pose = body.motion(time)
        corners = corners @ pose[:3, :3].T + pose[:3, 3]
    return corners


def _spokes(shape: Polyhedron, corners: np.ndarray, elements: set[Feature], point: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) from the point to the other corners of the elements there, and of the triangles beside these."""
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
