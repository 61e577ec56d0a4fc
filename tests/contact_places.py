"""Whether the place that a contact names is on both bodies, and its normal parts them: told in plain numpy.

Bodies are taken as given: corners and faces of meshes, forms of quadrics, directrices; no search of the library.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar

import firstcontact as fc

CLOSE = 1e-9
"""Of the bodies' size."""


def assert_place(hit, a, b):
    """The point of a CONTACT is on both bodies at its time; the normal is unit."""
    if hit.status is not fc.Status.CONTACT or hit.point is None:
        return
    assert_on_both(hit, a, b)
    if hit.normal is not None:
        assert abs(np.linalg.norm(hit.normal) - 1) < 1e-12


def assert_on_both(hit, a, b):
    """The point is on the surfaces of both bodies at the time told."""
    lo, hi = hit.time_interval
    for body in (a, b):
        pose = pose_of(body, hit.time)
        size = max(1e-300, *(np.abs(x).max() for x in world_box(body, pose)))
        way = max(np.abs(pose_of(body, t) - pose).max() for t in (lo, hi)) * (size + 1)
        off = beside(shape(body).at(hit.time), pose, hit.point, CLOSE * size)
        assert off <= CLOSE * size + 2 * way, (off, hit.point, body)


def shape(body):
    return getattr(body, "body", body)


def pose_of(body, t):
    motion = getattr(body, "motion", None)
    return np.eye(4) if motion is None else np.asarray(motion(min(max(t, motion.span[0]), motion.span[1])
                                                              if not motion.extends else t))  # fmt: skip


def world_box(body, pose):
    lo, hi = shape(body).bounds() if not isinstance(shape(body), fc.Polyhedron) else (
        shape(body).vertices.min(axis=0), shape(body).vertices.max(axis=0))  # fmt: skip
    corners = np.array([lo, hi])
    corners = np.where(np.isfinite(corners), corners, 1.0)
    return np.abs(corners) @ np.abs(pose[:3, :3]).T + np.abs(pose[:3, 3])


def beside(body, pose, point, close):
    """How far the point is from the surface of the body in the pose, about; of solids: 0 within `close`, else inf."""
    if isinstance(body, fc.Polyhedron):
        return of_mesh(body, body.vertices @ pose[:3, :3].T + pose[:3, 3], point)
    if isinstance(body, fc.RuledSurface):
        own = np.linalg.solve(pose[:3, :3], point - pose[:3, 3])
        return min(of_sheet(x, own) for x in body.pieces) * np.linalg.norm(pose[:3, :3])
    return of_solid(body, np.linalg.inv(pose), point, close)


def of_mesh(mesh, x, point):
    found = [np.linalg.norm(x - point, axis=1).min()] if not len(mesh.edges) and not len(mesh.triangles) else []
    if len(mesh.edges):
        found.append(to_segments(x[mesh.edges[:, 0]], x[mesh.edges[:, 1]], point).min())
    if len(mesh.triangles):
        p, q, r = (x[mesh.triangles[:, k]] for k in range(3))
        n = np.cross(q - p, r - p)
        square = np.maximum((n * n).sum(axis=1), 1e-300)
        d = point - p
        height = (d * n).sum(axis=1) / np.sqrt(square)
        v, w = (np.cross(d, r - p) * n).sum(axis=1) / square, (np.cross(q - p, d) * n).sum(axis=1) / square
        within = (v >= 0) & (w >= 0) & (v + w <= 1)
        sides = np.minimum.reduce([to_segments(*ends, point) for ends in ((p, q), (q, r), (r, p))])
        found.append(np.where(within, np.minimum(np.abs(height), sides), sides).min())
    return min(found)


def to_segments(p, q, x):
    d = q - p
    share = np.clip(((x - p) * d).sum(axis=1) / np.maximum((d * d).sum(axis=1), 1e-300), 0, 1)
    return np.linalg.norm(p + share[:, None] * d - x, axis=1)


def of_solid(model, inverse, point, close):
    """0 where the signs of forms, those within `close` of their surface taken as either, allow inside and outside."""
    x, signs = np.append(point, 1.0), []
    for surface in model.surfaces:
        rows = surface.matrix()
        largest = max(abs(c) for row in rows for c in row)
        form = np.array([[int((c / largest).p) / int((c / largest).q) for c in row] for row in rows])
        form = inverse.T @ form @ inverse
        value, gradient = x @ form @ x, 2 * np.linalg.norm((form @ x)[:3])
        bend = np.abs(np.linalg.eigvalsh(form[:3, :3])).max()
        reach = gradient * close + bend * close**2 + 1e-14 * (np.abs(x) @ np.abs(form) @ np.abs(x))
        signs.append(0 if abs(value) <= reach else -1 if value < 0 else 1)
    return 0.0 if all(either(model.tree, signs)) else np.inf


def either(tree, signs):
    """(may be inside, may be outside)."""
    kind = type(tree).__name__
    if kind == "Leaf":
        return signs[tree.surface] <= 0, signs[tree.surface] >= 0
    if kind == "Not":
        return either(tree.inner, signs)[::-1]
    (a, b), (c, d) = either(tree.first, signs), either(tree.second, signs)
    return (a and c, b or d) if kind == "And" else (a or c, b and d)


def of_sheet(surface, x):
    """Over u by a grid and a search near its best; each ruling is a segment between its sides."""
    if surface.u is None or surface.s is None:
        return 0.0
    lo, hi = map(float, surface.u)
    s = [float(c) for c in surface.s]

    def off(u):
        u = np.atleast_1d(u)
        ends = [surface.points(u, np.full(len(u), c)) for c in s]
        return to_segments(*ends, x)

    grid = np.linspace(lo, hi, 401)
    values = off(grid)
    best = values.min()
    for k in np.argsort(values)[:3]:
        ends = grid[max(k - 1, 0)], grid[min(k + 1, 400)]
        found = minimize_scalar(lambda u: off(u)[0], bounds=ends, method="bounded", options={"xatol": 1e-15})
        best = min(best, found.fun)
        for _ in range(60):  # golden section ends near 1e-8 of u: bisection of the slope of the square is finer
            middle = (ends[0] + ends[1]) / 2
            h = 1e-7 * (hi - lo)
            slope = off(min(middle + h, hi))[0] ** 2 - off(max(middle - h, lo))[0] ** 2
            ends = (middle, ends[1]) if slope < 0 else (ends[0], middle)
            best = min(best, off(middle)[0])
    return float(best)


def assert_parted(hit, points_a, points_b, close=1e-7):
    """Of convex bodies, by points (n, 3) in the world: the plane at the point has a before it and b behind it."""
    size = max(np.abs(points_a).max(), np.abs(points_b).max(), 1.0)
    assert ((points_a - hit.point) @ hit.normal).min() >= -close * size
    assert ((points_b - hit.point) @ hit.normal).max() <= close * size
