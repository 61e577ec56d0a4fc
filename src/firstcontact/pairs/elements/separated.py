"""Elements that shift are apart throughout where a plane is between all of what one of them sweeps and the other.

For what no precision tells by the conditions of contact, as in irrational poses a vertex that stays in a facet's plane,
far from the facet: doubles propose the plane, and balls bear it out.  And for many pairs at once that shift in one
plane, as of parts that lie on each other: doubles alone, rounded outward.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.exact.numbers import exact_value, to_double
from firstcontact.exact.vectors import Vector, add, dot, scaled

if TYPE_CHECKING:
    from flint import arb, fmpq

LOST = 2.0**-900
"""Heights below it have lost digits."""


def are_apart(a: Sequence[Vector], b: Sequence[Vector], v: Vector, last: fmpq | arb) -> bool:
    """Whether the hull of points a, on its way by t v, 0 <= t <= last, certainly shares no point with that of points b.

    Coordinates are rational or balls; False where no plane is found.
    """
    swept = [*a, *(add(p, scaled(last, v)) for p in a)]
    axis = _axis(np.array([_doubles(p) for p in swept]), np.array([_doubles(q) for q in b]))
    if axis is None:
        return False
    exact = exact_value(float(axis[0])), exact_value(float(axis[1])), exact_value(float(axis[2]))
    low, high = [dot(exact, p) for p in swept], [dot(exact, q) for q in b]
    return all(p < q for p in low for q in high)


def apart_in_doubles(a: np.ndarray, b: np.ndarray, shift: np.ndarray, error: float) -> np.ndarray:
    """(n,) bools: True proves that the hull of points a[k], on its way by `shift`, shares no point with that of b[k].

    a, b: (n, 3, 3) corners of triangles, those of edges and points repeated; error: what coordinates are off by in all,
    of both and the shift.  Planes looked for are those of facets, and those across them through edges.
    """
    sides = np.concatenate([np.roll(x, -1, axis=1) - x for x in (a, b)], axis=1)
    between = b[:, 0] - a[:, 0]
    pairs = ((0, 1), (3, 4), (0, 3))
    normals = [np.cross(sides[:, i], sides[:, j]) for i, j in pairs] + [np.cross(sides[:, k], between) for k in (0, 3)]
    flat = np.stack(normals, axis=1)
    largest = np.abs(flat).sum(axis=2).argmax(axis=1)
    normal = np.take_along_axis(flat, largest[:, None, None], axis=1)
    axes = np.concatenate([normal, np.cross(sides, normal), sides[:, ::3]], axis=1)
    heights_a, heights_b = (np.einsum("nik,njk->nij", axes, x) for x in (a, b))
    way = axes @ shift
    above = heights_b.min(axis=2) - heights_a.max(axis=2) - np.maximum(way, 0.0)
    below = heights_a.min(axis=2) - heights_b.max(axis=2) + np.minimum(way, 0.0)
    rounding = 2.0**-48 * (np.abs(a).max() + np.abs(b).max() + np.abs(shift).max()) + error
    told: np.ndarray = (np.maximum(above, below) > np.abs(axes).sum(axis=2) * rounding + LOST).any(axis=1)
    return told


def _doubles(point: Vector) -> list[float]:
    return [float(x.mid()) if hasattr(x, "mid") else to_double(x) for x in point]


def _axis(a: np.ndarray, b: np.ndarray) -> np.ndarray | None:
    """A unit vector along which points b lie beyond points a, as far as doubles tell; None where there is none.

    It is along a line through two of the points, across two such lines, or within the plane of two across a third.
    """
    sides = np.array([q - p for p, q in itertools.combinations(np.concatenate([a, b]), 2)])
    across = np.cross(sides[:, None], sides[None]).reshape(-1, 3)
    axes = np.concatenate([sides, across, np.cross(across[:, None], sides[None]).reshape(-1, 3)])
    length = np.linalg.norm(axes, axis=1)
    axes = axes[length > 1e-9 * length.max()]
    if not len(axes):  # all points are one
        return None
    axes = np.concatenate([axes, -axes]) / np.tile(np.linalg.norm(axes, axis=1), 2)[:, None]
    gaps = (axes @ b.T).min(axis=1) - (axes @ a.T).max(axis=1)
    best: np.ndarray = axes[int(gaps.argmax())]
    return best if gaps.max() > 0.0 else None
