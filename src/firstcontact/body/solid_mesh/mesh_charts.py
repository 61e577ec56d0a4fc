"""Charts of planes and quadrics for meshing: every sheet of a surface as a part of the sphere of rays.

A sheet that is a graph over a plane (planes, paraboloids, parabolic cylinders, each half of cones, of hyperboloids of
two sheets and of hyperbolic cylinders) sends its point (u, v, h) to the ray (u, v, 1).  The others (ellipsoids,
hyperboloids of one sheet, elliptic cylinders) meet every ray from their centre once at most: a point is its own ray.
So sides, turns and triangulations are those of great circles on one sphere, whatever the surface.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from firstcontact.body.solid.carriers import Plane, Quadric, Surface, doubles
from firstcontact.body.solid.features import middle
from firstcontact.exact.numbers import to_double


@dataclass(frozen=True, eq=False)
class MeshChart:
    """One sheet.

    origin, axes: y = axes (x - origin) are the coordinates of the text, h last.
    form: (4, 4) the surface in these coordinates.  sheet: +1, -1 for the upper and lower half of a graph over both
    sides of its plane, 0 for a whole graph, None for rays from the centre.
    base: (n, 3) rays of a first triangulation; whole: whether they meet the surface (it is closed), or none does.
    """

    origin: np.ndarray
    axes: np.ndarray
    form: np.ndarray
    sheet: int | None
    base: np.ndarray
    whole: bool = False

    def coordinates(self, points: np.ndarray) -> np.ndarray:
        y: np.ndarray = (points - self.origin) @ self.axes.T
        return y

    def holds(self, points: np.ndarray) -> np.ndarray:
        """(n,) bools: which points of the surface are on this sheet (tips of cones are on both)."""
        if not self.sheet:
            return np.ones(len(points), bool)
        y = self.coordinates(points)
        on_sheet: np.ndarray = self.sheet * y[:, 2] > -1e-9 * (1 + np.abs(y).max(axis=1))
        return on_sheet

    def rays(self, points: np.ndarray) -> np.ndarray:
        """(n, 3) rays, of any length, of (n, 3) points."""
        y = self.coordinates(points)
        if self.sheet is not None:
            y[:, 2] = 1.0
        return y

    def lifted(self, rays: np.ndarray) -> np.ndarray:
        """(n, 3) points of the surface on the rays; nan where a ray misses it."""
        g = self.form
        with np.errstate(invalid="ignore", divide="ignore"):
            if self.sheet is None:
                square = np.einsum("ni,ij,nj->n", rays, g[:3, :3], rays)
                y = rays * np.sqrt(-g[3, 3] / square)[:, None]
            else:
                y = rays / rays[:, 2:]
                flat = np.column_stack([y[:, :2], np.zeros(len(y)), np.ones(len(y))])
                b, c = flat @ g[2], np.einsum("ni,ij,nj->n", flat, g, flat)
                if self.sheet:
                    a = g[2, 2]
                    y[:, 2] = (self.sheet * math.copysign(1.0, a) * np.sqrt(np.maximum(b * b - a * c, 0.0)) - b) / a
                else:
                    y[:, 2] = -c / (2 * b)
        return self.origin + np.linalg.solve(self.axes, y.T).T


def charts(surface: Surface, points: np.ndarray) -> list[MeshChart]:
    """The charts of all sheets; points: (n, 3) points on the surface whose rays are well inside the charts."""
    matrix = np.array(doubles(surface.matrix()))
    if isinstance(surface, Plane):
        normal = matrix[3, :3]
        basis = np.linalg.svd(normal[None])[2]
        return [_graph(matrix, points[0], basis[[1, 2, 0]], 0, points)]
    start, values, axes, slope, constant = _normal_form(surface, matrix)
    match int(np.sum(values != 0)):
        case 3 if values[2] > 0:
            scaled = np.sqrt(np.abs(values / constant))[:, None] * axes.T
            return [_central(matrix, start, scaled, _icosahedron(), whole=True)]
        case 3 if constant < 0:
            scaled = np.sqrt(np.abs(values / constant))[:, None] * axes.T
            return [_central(matrix, start, scaled, _rings(1.2))]
        case 3:
            return [_graph(matrix, start, axes.T, sheet, points) for sheet in (1, -1)]
        case 2 if slope[2]:
            return [_graph(matrix, start, axes.T, 0, points)]
        case 2 if values[1] > 0:
            along = (points - start) @ axes[:, 2]
            height = max(float(np.ptp(along)) / 2, 1e-300)
            sizes = np.array([*np.sqrt(np.abs(values[:2] / constant)), 1 / height])
            shifted = start + axes[:, 2] * (along.max() + along.min()) / 2
            return [_central(matrix, shifted, sizes[:, None] * axes.T, _rings(3.0))]
        case 2:
            first = 0 if constant < 0 else 1  # the axis that the two branches cross
            return [_graph(matrix, start, axes.T[[1 - first, 2, first]], sheet, points) for sheet in (1, -1)]
        case _:
            down = axes @ np.array([0.0, slope[1], slope[2]]) / math.hypot(slope[1], slope[2])
            return [_graph(matrix, start, np.array([axes[:, 0], np.cross(axes[:, 0], down), down]), 0, points)]


def _normal_form(
    quadric: Quadric, form: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]:
    """(start, values, axes, slope, constant): the sum of values[k] y_k^2 + 2 slope . y + constant in the frame of the
    axes (columns) about the start; values in the order +, -, 0."""
    values, axes = np.linalg.eigh(form[:3, :3])
    values[np.abs(values) < 1e-9 * np.abs(values).max()] = 0.0
    if np.sum(values < 0) > np.sum(values > 0):
        form, values = -form, -values
    order = np.array(sorted(range(3), key=lambda k: (values[k] == 0, -values[k])))
    values, axes = values[order], axes[:, order]
    start = np.array([to_double(x) for x in middle(quadric)])
    constant = float(start @ form[:3, :3] @ start + 2 * form[3, :3] @ start + form[3, 3])
    slope = (form[:3, :3] @ start + form[:3, 3]) @ axes
    slope[np.abs(slope) < 1e-9 * np.abs(form).max()] = 0.0
    return start, values, axes, slope, 0.0 if quadric.apex is not None else constant


def _in_frame(form: np.ndarray, origin: np.ndarray, axes: np.ndarray) -> np.ndarray:
    to_space = np.eye(4)
    to_space[:3, :3], to_space[:3, 3] = np.linalg.inv(axes), origin
    here: np.ndarray = to_space.T @ form @ to_space
    return here


def _graph(form: np.ndarray, start: np.ndarray, axes: np.ndarray, sheet: int, points: np.ndarray) -> MeshChart:
    """Over the plane of the first two axes, with the points in the square |u|, |v| <= 1."""
    flat = (points - start) @ axes[:2].T
    lo, hi = flat.min(axis=0), flat.max(axis=0)
    origin = start + (lo + hi) / 2 @ axes[:2]
    axes = axes / np.array([*np.maximum((hi - lo) / 2, 1e-9 * (hi - lo).max()), 1.0])[:, None]
    corners = np.array([[4.1, 3.9, 1], [-3.7, 4.3, 1], [-4.2, -3.8, 1], [3.9, -4.4, 1], [0.01, 0.02, -1]])
    return MeshChart(origin, axes, _in_frame(form, origin, axes), sheet, corners)


def _central(
    form: np.ndarray, origin: np.ndarray, axes: np.ndarray, base: np.ndarray, whole: bool = False
) -> MeshChart:
    return MeshChart(origin, axes, _in_frame(form, origin, axes), None, base, whole)


def _icosahedron() -> np.ndarray:
    """Its corners, in no special position to the axes."""
    g = (1 + math.sqrt(5)) / 2
    quarter = [(0, a, b * g) for a in (1, -1) for b in (1, -1)]
    corners = np.array([np.roll(c, k) for c in quarter for k in range(3)])
    turn = np.linalg.qr(np.array([[0.83, 0.31, -0.47], [0.22, 0.91, 0.35], [-0.57, 0.41, 0.79]]))[0]
    turned: np.ndarray = corners @ turn
    return turned


def _rings(height: float) -> np.ndarray:
    """Two rings of nine rays about the last axis and the axis itself, in no special position."""
    around = np.linspace(0, 2 * math.pi, 9, endpoint=False)
    rings = [np.column_stack([np.cos(around + a), np.sin(around + a), np.full(9, h)]) for a, h in
             ((0.123, height), (0.345, -1.05 * height))]  # fmt: skip
    return np.concatenate([*rings, [[0.011, 0.007, 1.0], [0.013, -0.005, -1.0]]])
