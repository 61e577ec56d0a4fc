"""How far triangles with corners on a cylinder, cone, sphere or torus are from it, whatever their parameters are.

Triangles T have corners S(p) at the corners p of triangles in parameters; L is linear on these and S the surface.  Let
D bound the distance of points of T from the surface, r(x) the nearest point of the surface to x.

Every point of the face is near the triangles: r((1 - t) S + t L) runs from S to r L.  A point of S that it does not
pass on the border keeps its degree, 1, so it is r(x) for an x of a triangle, within D.  What is passed on a border side
is as near to its chord as the side's curve is, which D and `drift` together bound.

Every point of the triangles is near the face: all triangles lie along the surface (`along`), so that r L has positive
degree where it is; where S is not, that is on what the border passes.  That is `drift` from the side's curve at most:
nothing on meridians, whose chords are in their own plane; on circles about the axis, below which chords sink by g,
nothing on cylinders, whose nearest points are at their height, g |sin| on cones, g / cos(d / 2) with sin d <= g / r on
spheres and tori; twice the distance of the chord anywhere else, r(x) being no farther from x than the curve is.

The bounds D: with weights l of the corners sum l |p|^2 - |sum l p|^2 = sum l l' |p - p'|^2 <= `_spread`.  So a chord
sinks below a circle of radius R by R - sqrt(R^2 - spread) at most (`_sunk`).  About the axis of a cone, where radii q
differ, the mean of |q| less |sum l q| is m - sqrt(m^2 - sum l l' a), a = |q - q'|^2 - (|q| - |q'|)^2, m the mean; a
corner in the tip adds to neither.  On a torus both sink: about the axis, and in the plane through it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from firstcontact.step.charts import Elementary

WIDEST = 1.5
"""Radians: how far a triangle may turn about an axis; less than half a turn keeps all that is between off the axis."""
LONGER, FLAT = 1.01, 0.25
"""1 / cos(d / 2) for g up to FLAT r."""
THIN = 1e-12
"""Parameters that count as equal: what that moves is far below the rounding of files."""
_SIDES = ((0, 1), (1, 2), (2, 0))


@dataclass(frozen=True)
class Sagitta:
    """away: (n,) the bounds D of triangles; of_sides: (n, 3) those of their sides; along: (n,) whether a triangle lies
    along the surface and is so near to it that what is between is nowhere on the axis."""

    away: np.ndarray
    of_sides: np.ndarray
    along: np.ndarray


def is_round(chart: Elementary) -> bool:
    """Whether it has these bounds: planes have not, nor tori that meet themselves."""
    surface = chart.surface
    return chart.kind != "Plane" and bool(chart.kind != "Toroidal" or surface.MinorRadius() < surface.MajorRadius())


def sagitta(chart: Elementary, uv: np.ndarray, parametric: np.ndarray) -> Sagitta:
    """Of triangles with corners at parameters (n, 3, 2) of a round surface; parametric: (n,) bounds of |S - L|."""
    surface, kind = chart.surface, chart.kind
    points = chart.at(uv.reshape(-1, 2)).reshape(-1, 3, 3)
    x = (points - chart.origin) @ chart.axes.T
    radius = np.hypot(x[..., 0], x[..., 1])
    about = np.stack([_turned(x[:, i], x[:, j], radius[:, i], radius[:, j]) for i, j in _SIDES], axis=1)
    tip = radius <= THIN * np.abs(points).max(initial=0.0)  # that is what roundings leave of it, in small triangles too
    least = np.where(tip, np.inf, radius).min(axis=1)
    angles = np.sqrt(_over(about, np.stack([radius[:, i] * radius[:, j] for i, j in _SIDES], axis=1)).max(axis=1))
    narrow = np.ptp(uv[..., 0], axis=1) < WIDEST
    if kind == "Spherical":
        r = surface.Radius()
        squares = _squares(x)
        away, of_sides = _sunk(r, squares)
        turn, narrow = np.sqrt(squares.max(axis=1)) / np.maximum(r - away, 1e-300), parametric < r
    elif kind == "Toroidal":
        r = surface.MinorRadius()
        squares = _squares(np.stack([radius, x[..., 2]], axis=2))
        down, sides_down = _sunk(r, squares)
        inward, sides_inward = _sunk(least, about)
        away, of_sides = down + inward, sides_down + sides_inward
        turn = angles + np.sqrt(squares.max(axis=1)) / r + np.pi / 2 * inward / np.maximum(r - down, 1e-300)
        narrow &= parametric < min(r, surface.MajorRadius() - r)
    else:
        cosine = np.cos(surface.SemiAngle()) if kind == "Conical" else 1.0
        away, of_sides = (cosine * bound for bound in _sunk(least, about))
        turn = angles
    return Sagitta(away, of_sides, narrow & (_facing(chart, uv, points, tip) > turn))


def drift(chart: Elementary, uv: np.ndarray, bends: np.ndarray) -> np.ndarray:
    """(n,) of border sides with ends at parameters (n, 2, 2), whose curves are `bends` from them at most: see above."""
    du, dv = np.abs(uv[:, 1] - uv[:, 0]).T
    x = (chart.at(uv.reshape(-1, 2)).reshape(-1, 2, 3) - chart.origin) @ chart.axes.T
    radius = np.hypot(x[..., 0], x[..., 1])
    least = radius.min(axis=1)
    turned = _turned(x[:, 0], x[:, 1], radius[:, 0], radius[:, 1])
    down = _sunk(least, np.column_stack([turned, 0.0 * turned, 0.0 * turned]))[0]
    surface = chart.surface
    if chart.kind == "Cylindrical":
        down = 0.0 * down
    elif chart.kind == "Conical":
        down = down * abs(np.sin(surface.SemiAngle()))
    else:
        r = surface.Radius() if chart.kind == "Spherical" else surface.MinorRadius()
        down = np.where(down <= FLAT * r, LONGER, 2.0) * down
    return np.where(du <= THIN, 0.0, np.where(dv <= THIN, down, 2.0 * bends))


def _turned(x: np.ndarray, y: np.ndarray, r: np.ndarray, s: np.ndarray) -> np.ndarray:
    """2 (r s - x.y) = |x - y|^2 - (r - s)^2 across the axis, without cancellation where the angle is small."""
    dot = x[:, 0] * y[:, 0] + x[:, 1] * y[:, 1]
    cross = x[:, 0] * y[:, 1] - x[:, 1] * y[:, 0]
    found: np.ndarray = np.where(dot > 0.0, 2.0 * cross**2 / np.maximum(r * s + dot, 1e-300), 2.0 * (r * s - dot))
    return found


def _squares(x: np.ndarray) -> np.ndarray:
    return np.stack([((x[:, i] - x[:, j]) ** 2).sum(axis=1) for i, j in _SIDES], axis=1)


def _over(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    found: np.ndarray = np.divide(a, b, out=np.zeros_like(a), where=b > 0.0)
    return found


def _spread(squares: np.ndarray) -> np.ndarray:
    """The largest sum l l' squares over weights l: the square of the circumradius, or of half the longest side."""
    total, most = squares.sum(axis=1), squares.max(axis=1)
    sixteen_areas = total**2 - 2.0 * (squares**2).sum(axis=1)
    acute = 2.0 * most < total
    found: np.ndarray = np.where(acute, squares.prod(axis=1) / np.where(acute, sixteen_areas, 1.0), most / 4.0)
    return found


def _sunk(radius: np.ndarray | float, squares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far triangles, and their sides, sink below circles of that radius."""
    r = np.broadcast_to(np.asarray(radius, float), len(squares))

    def below(r: np.ndarray, spread: np.ndarray) -> np.ndarray:
        left = r * r - spread
        return np.where(left > 0.0, spread / np.maximum(r + np.sqrt(np.maximum(left, 0.0)), 1e-300), np.inf)

    return below(r, _spread(squares)), below(r[:, None], squares / 4.0)


def _facing(chart: Elementary, uv: np.ndarray, points: np.ndarray, tip: np.ndarray) -> np.ndarray:
    """(n,) cosines between triangles and the surface in a corner that is no tip; 2 of triangles without area."""
    rows = np.arange(len(points))
    corner = tip.argmin(axis=1)
    u, v = uv[rows, corner].T
    radial = np.stack([np.cos(u), np.sin(u)])
    rise = {
        "Cylindrical": np.zeros_like(v), "Spherical": np.sin(v), "Toroidal": np.sin(v),
        "Conical": np.full_like(v, -np.sin(chart.surface.SemiAngle()) if chart.kind == "Conical" else 0.0),
    }[chart.kind]  # fmt: skip
    flat = np.cos(v) if chart.kind in ("Spherical", "Toroidal") else np.sqrt(1.0 - rise**2)
    outward = np.stack([flat * radial[0], flat * radial[1], rise], axis=1) @ chart.axes
    if chart.kind == "Conical":  # on the other nappe
        outward *= np.where(chart._profile(v)[0] < 0.0, -1.0, 1.0)[:, None]
    a, b = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    normal = np.cross(a, b)
    p, q = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    turned = np.sign(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]) * np.sign(np.linalg.det(chart.axes))
    length = np.linalg.norm(normal, axis=1)
    squares = _squares(points)
    none = squares.min(axis=1) <= THIN**2 * squares.max(axis=1)
    cosine = turned * (normal * outward).sum(axis=1) / np.maximum(length, 1e-300)
    return np.where(none, 2.0, cosine)
