"""How large the derivatives of a surface's chart are at most: proofs for how far triangles are from it.

A function f on a triangle differs from the linear one of its corners by at most
(f_uu du^2 + 2 f_uv du dv + f_vv dv^2) / 8, with du and dv the sides of a box around the triangle and bounds of the
second derivatives over the box (Filip, Magedson, Markot 1986; for any triangle: the corners have in u a variance of
at most du^2 / 4, whatever their weights).  The same with one parameter of curves.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from OCP.collections import Array1_double
    from OCP.Geom import Geom_BezierSurface, Geom_Curve, Geom_Surface
    from OCP.Geom2d import Geom2d_Curve
    from OCP.gp import gp_Ax1, gp_Pnt, gp_Pnt2d

SAFE = 1.0 + 1e-9
"""Far more than the roundings of a bound."""
PIECES = 4
"""Equal parts, in each direction, of a Bezier patch or curve in which derivatives are bounded."""
MOST_PATCHES = 4000


class NotBounded(Exception):
    """A surface or curve of a kind without bounds; the text says which."""


@dataclass(frozen=True)
class SurfaceBounds:
    """over: boxes (n, 4) of u, u', v, v' to (n, 5) bounds of |S_u|, |S_v|, |S_uu|, |S_uv|, |S_vv| over each."""

    over: Callable[[np.ndarray], np.ndarray]


def chart_of(surface: Geom_Surface, box: tuple[float, float, float, float]) -> SurfaceBounds:
    """Bounds for a surface of OpenCASCADE over any boxes within `box` (u, u', v, v').  Raises NotBounded."""
    kind = surface.DynamicType().Name()
    if kind == "Geom_RectangularTrimmedSurface":
        return chart_of(surface.BasisSurface(), box)
    if kind == "Geom_Plane":
        return _even(1.0, 1.0, 0.0, 0.0, 0.0)
    if kind == "Geom_CylindricalSurface":
        r = surface.Radius()
        return _even(r, 1.0, r, 0.0, 0.0)
    if kind == "Geom_SphericalSurface":
        r = surface.Radius()
        return SurfaceBounds(lambda boxes: _ringed(0.0, r, boxes))
    if kind == "Geom_ToroidalSurface":
        big, small = surface.MajorRadius(), surface.MinorRadius()
        return SurfaceBounds(lambda boxes: _ringed(big, small, boxes))
    if kind == "Geom_ConicalSurface":
        sine, radius = abs(math.sin(surface.SemiAngle())), surface.RefRadius()

        def cone(boxes: np.ndarray) -> np.ndarray:
            r = abs(radius) + np.abs(boxes[:, 2:]).max(axis=1) * sine
            one = np.ones(len(boxes))
            return np.column_stack([r, one, r, sine * one, 0.0 * one])

        return SurfaceBounds(cone)
    if kind == "Geom_SurfaceOfLinearExtrusion":
        curve = CurveBounds(surface.BasisCurve(), box[0], box[1])
        return SurfaceBounds(lambda boxes: _extruded(curve, boxes))
    if kind == "Geom_SurfaceOfRevolution":
        curve = CurveBounds(surface.BasisCurve(), box[2], box[3])
        axis = surface.Axis()
        return SurfaceBounds(lambda boxes: _turned(curve, boxes, curve.reach(axis)))
    if kind in ("Geom_BSplineSurface", "Geom_BezierSurface"):
        return SurfaceBounds(_Patches(surface).over)
    raise NotBounded(kind.removeprefix("Geom_"))


def _even(*values: float) -> SurfaceBounds:
    row = np.array(values)
    return SurfaceBounds(lambda boxes: np.tile(row, (len(boxes), 1)))


def _ringed(big: float, small: float, boxes: np.ndarray) -> np.ndarray:
    """Of (big + small cos v) turned by u; cos v and sin v differ from those of the middle by half the width at most."""
    middle, half = 0.5 * (boxes[:, 2] + boxes[:, 3]), 0.5 * (boxes[:, 3] - boxes[:, 2])
    cosine, sine = (np.minimum(np.abs(f(middle)) + half, 1.0) for f in (np.cos, np.sin))
    out, one = big + small * cosine, np.ones(len(boxes))
    return np.column_stack([out, small * one, out, small * sine, small * one])


def _extruded(curve: CurveBounds, boxes: np.ndarray) -> np.ndarray:
    first, second = curve.over(boxes[:, :2])
    one = np.ones(len(boxes))
    return np.column_stack([first, one, second, 0.0 * one, 0.0 * one])


def _turned(curve: CurveBounds, boxes: np.ndarray, radius: float) -> np.ndarray:
    """S = turn(u) c(v): derivatives by u are those of points at most `radius` from the axis."""
    first, second = curve.over(boxes[:, 2:])
    r = np.full(len(boxes), radius)
    return np.column_stack([r, first, r, first, second])


class CurveBounds:
    """Bounds of the first two derivatives of a curve of OpenCASCADE, in space or in parameters, on [lo, hi]."""

    def __init__(self, curve: Geom_Curve | Geom2d_Curve, lo: float, hi: float) -> None:
        kind = curve.DynamicType().Name().removeprefix("Geom2d_").removeprefix("Geom_")
        while kind == "TrimmedCurve":
            curve = curve.BasisCurve()
            kind = curve.DynamicType().Name().removeprefix("Geom2d_").removeprefix("Geom_")
        self.kind, self.curve = kind, curve
        self.knots = np.array([-np.inf, np.inf])
        self.nets: list[np.ndarray] | None = None
        size = 2 if "Geom2d" in curve.DynamicType().Name() else 3
        if kind == "Line":
            self.first, self.second = np.array([1.0]), np.zeros(1)
            self.axes = np.zeros((1, size))
        elif kind in ("Circle", "Ellipse"):
            r = curve.Radius() if kind == "Circle" else curve.MajorRadius()
            self.first, self.second = np.array([r]), np.array([r])
            self.axes = np.full((1, size), r)
        elif kind in ("BSplineCurve", "BezierCurve"):
            self._from_nets(curve, size)
        else:
            raise NotBounded(kind)
        self.lo, self.hi = lo, hi
        self.is_straight = not self.axes.any()

    def _from_nets(self, curve: Geom_Curve | Geom2d_Curve, size: int) -> None:
        nets, knots = _curve_nets(curve, size)
        self.nets = nets
        first, second, axes = [], [], []
        for net, (t0, t1) in zip(nets, zip(knots, knots[1:], strict=False), strict=True):
            one, two, each = _curve_bounds(net, t1 - t0)
            first.append(one)
            second.append(two)
            axes.append(each)
        self.first, self.second, self.axes = np.array(first), np.array(second), np.array(axes)
        self.knots = np.array(knots)

    def _pieces(self, lo: float, hi: float) -> slice:
        if len(self.first) == 1:
            return slice(0, 1)
        slack = 1e-9 * (self.knots[-1] - self.knots[0])
        period = self.knots[-1] - self.knots[0]
        if lo < self.knots[0] - slack or hi > self.knots[-1] + slack or hi - lo > period:  # periodic: all of it
            return slice(0, len(self.first))
        start = int(np.searchsorted(self.knots, lo - slack, "right")) - 1
        stop = int(np.searchsorted(self.knots, hi + slack, "left"))
        return slice(max(start, 0), max(min(stop, len(self.first)), max(start, 0) + 1))

    def over(self, spans: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(n,) bounds of |c'| and |c''| on the (n, 2) stretches."""
        pieces = [self._pieces(lo, hi) for lo, hi in spans.tolist()]
        return np.array([self.first[p].max() for p in pieces]), np.array([self.second[p].max() for p in pieces])

    def bends(self, lo: float, hi: float) -> np.ndarray:
        """Bounds of the second derivative of each coordinate on [lo, hi]."""
        found: np.ndarray = self.axes[self._pieces(lo, hi)].max(axis=0)
        return found

    def reach(self, axis: gp_Ax1) -> float:
        """Bound of the distance of the curve's points on its stretch from an axis."""
        place, direction = axis.Location(), axis.Direction()
        p = np.array([place.X(), place.Y(), place.Z()])
        d = np.array([direction.X(), direction.Y(), direction.Z()])
        if self.nets is not None:
            points = np.concatenate([net[:, :3] / net[:, 3:] for net in self.nets])
            room = 0.0
        else:
            steps = 64
            t = np.linspace(self.lo, self.hi, steps + 1)
            places = [self.curve.Value(float(x)) for x in t]
            points = np.array([[q.X(), q.Y(), q.Z()] for q in places])
            room = float(self.first[0]) * (self.hi - self.lo) / steps
        away = points - p
        return float(np.linalg.norm(away - np.outer(away @ d, d), axis=1).max()) * SAFE + room


def _curve_nets(curve: Geom_Curve | Geom2d_Curve, size: int) -> tuple[list[np.ndarray], list[float]]:
    """Homogeneous nets (k, size + 1) of Bezier pieces, and the parameters between them."""
    if size == 2:
        from OCP.Geom2d import Geom2d_BSplineCurve
        from OCP.Geom2dConvert import Geom2dConvert
        from OCP.Geom2dConvert import Geom2dConvert_BSplineCurveToBezierCurve as Cutter

        spline = curve if isinstance(curve, Geom2d_BSplineCurve) else Geom2dConvert.CurveToBSplineCurve_s(curve)
    else:
        from OCP.Geom import Geom_BSplineCurve
        from OCP.GeomConvert import GeomConvert
        from OCP.GeomConvert import GeomConvert_BSplineCurveToBezierCurve as Cutter

        spline = curve if isinstance(curve, Geom_BSplineCurve) else GeomConvert.CurveToBSplineCurve_s(curve)
    cutter = Cutter(spline)
    count = cutter.NbArcs()
    nets = []
    knots = _real_array(count + 1)
    cutter.Knots(knots)
    ends = [knots.Value(k) for k in range(1, count + 2)]
    inner = [ends[0]]
    for k in range(1, count + 1):
        arc = cutter.Arc(k)
        net = np.array([[*_place(arc.Pole(i), size), arc.Weight(i)] for i in range(1, arc.NbPoles() + 1)])
        net[:, :size] *= net[:, size:]
        for part in _cut(net, PIECES):
            nets.append(part)
        inner += np.linspace(ends[k - 1], ends[k], PIECES + 1)[1:].tolist()
    return nets, inner


def _real_array(count: int) -> Array1_double:
    from OCP.collections import Array1_double

    return Array1_double(1, count)


def _place(p: gp_Pnt | gp_Pnt2d, size: int) -> list[float]:
    return [p.X(), p.Y()] if size == 2 else [p.X(), p.Y(), p.Z()]


def _cut(net: np.ndarray, parts: int) -> list[np.ndarray]:
    """The nets of equal parts of a Bezier net (k, ...), along its first axis; parts: a power of two."""
    if parts == 1:
        return [net]
    left, right, row = [net[0]], [net[-1]], net
    while len(row) > 1:
        row = 0.5 * (row[:-1] + row[1:])
        left.append(row[0])
        right.append(row[-1])
    return _cut(np.array(left), parts // 2) + _cut(np.array(right[::-1]), parts // 2)


def _slopes(net: np.ndarray, width: float) -> np.ndarray:
    """The net of the derivative along the first axis, for a parameter that runs over `width`."""
    if len(net) == 1:
        return np.zeros_like(net)
    found: np.ndarray = (len(net) - 1) / width * np.diff(net, axis=0)
    return found


def _longest(net: np.ndarray) -> float:
    return float(np.linalg.norm(net, axis=-1).max())


def _curve_bounds(net: np.ndarray, width: float) -> tuple[float, float, np.ndarray]:
    """|c'|, |c''| and each coordinate's |c''| at most, of a homogeneous Bezier net."""
    bounds, each = _derivative_bounds(net[:, None, :], width, 1.0)
    return bounds[0], bounds[2], each


class _Patches:
    """Bounds for a B-spline surface, from the control nets of its Bezier patches and their parts."""

    def __init__(self, surface: Geom_Surface) -> None:
        from OCP.Geom import Geom_BSplineSurface
        from OCP.GeomConvert import GeomConvert, GeomConvert_BSplineSurfaceToBezierSurface

        if not isinstance(surface, Geom_BSplineSurface):
            surface = GeomConvert.SurfaceToBSplineSurface_s(surface)
        cutter = GeomConvert_BSplineSurfaceToBezierSurface(surface)
        nu, nv = cutter.NbUPatches(), cutter.NbVPatches()
        u, v = _real_array(nu + 1), _real_array(nv + 1)
        cutter.UKnots(u)
        cutter.VKnots(v)
        parts = PIECES
        while parts > 1 and nu * nv * parts * parts > MOST_PATCHES:
            parts //= 2
        self.u = _divided([u.Value(k) for k in range(1, nu + 2)], parts)
        self.v = _divided([v.Value(k) for k in range(1, nv + 2)], parts)
        self.table = np.zeros((nu * parts, nv * parts, 5))
        for i in range(nu):
            for j in range(nv):
                net = _net(cutter.Patch(i + 1, j + 1))
                for a, row in enumerate(_cut(net, parts)):
                    for b, cell in enumerate(_cut(np.swapaxes(row, 0, 1), parts)):
                        m, n = i * parts + a, j * parts + b
                        widths = self.u[m + 1] - self.u[m], self.v[n + 1] - self.v[n]
                        self.table[m, n] = _patch_bounds(np.swapaxes(cell, 0, 1), *widths)

    def over(self, boxes: np.ndarray) -> np.ndarray:
        rows, columns = _ranges(self.u, boxes[:, :2]), _ranges(self.v, boxes[:, 2:])
        found = np.empty((len(boxes), 5))
        for k, ((m0, m1), (n0, n1)) in enumerate(zip(rows.tolist(), columns.tolist(), strict=True)):
            found[k] = self.table[m0:m1, n0:n1].max(axis=(0, 1))
        return found


def _divided(knots: list[float], parts: int) -> np.ndarray:
    pieces = [np.linspace(a, b, parts + 1)[:-1] for a, b in zip(knots, knots[1:], strict=False)]
    return np.append(np.concatenate(pieces), knots[-1])


def _ranges(knots: np.ndarray, spans: np.ndarray) -> np.ndarray:
    """(n, 2) first and behind the last of the cells that hold each stretch; all of them beyond the ends (periods)."""
    last, slack = len(knots) - 1, 1e-9 * (knots[-1] - knots[0])
    lo = np.clip(np.searchsorted(knots, spans[:, 0] - slack, "right") - 1, 0, last - 1)
    hi = np.clip(np.searchsorted(knots, spans[:, 1] + slack, "left"), lo + 1, last)
    beyond = (spans[:, 0] < knots[0] - slack) | (spans[:, 1] > knots[-1] + slack)
    return np.column_stack([np.where(beyond, 0, lo), np.where(beyond, last, hi)])


def _net(patch: Geom_BezierSurface) -> np.ndarray:
    """(m, n, 4) homogeneous control points."""
    rows = []
    for i in range(1, patch.NbUPoles() + 1):
        row = []
        for j in range(1, patch.NbVPoles() + 1):
            p, w = patch.Pole(i, j), patch.Weight(i, j)
            row.append([p.X() * w, p.Y() * w, p.Z() * w, w])
        rows.append(row)
    return np.array(rows)


def _patch_bounds(net: np.ndarray, du: float, dv: float) -> np.ndarray:
    """|S_u|, |S_v|, |S_uu|, |S_uv|, |S_vv| at most, of a homogeneous Bezier net."""
    return _derivative_bounds(net, du, dv)[0]


def _derivative_bounds(net: np.ndarray, du: float, dv: float) -> tuple[np.ndarray, np.ndarray]:
    """(bounds as of patches, bounds of each coordinate of S_uu) of a net (m, n, d + 1).

    S = P / w has S_u = A / w^2 with A = P_u w - P w_u, and S_uv = (A_v w - 2 A w_v) / w^3: numerators as nets, in which
    what cancels does so, about the middle of the net, over the least weight.
    """
    w = net[..., -1:]
    p = net[..., :-1] - w * (net[..., :-1] / w).mean(axis=(0, 1))
    least = float(w.min())
    if np.ptp(w) == 0.0:
        first = [_along(p, 0, du) / least, _along(p, 1, dv) / least]
        second = [_along(first[0], 0, du), _along(first[0], 1, dv), _along(first[1], 1, dv)]
    else:
        slopes = [_along(w, 0, du), _along(w, 1, dv)]
        a = [_less(_times(_along(p, k, d), w), _times(p, slopes[k])) for k, d in ((0, du), (1, dv))]

        def again(x: np.ndarray, k: int, d: float) -> np.ndarray:
            return _less(_times(_along(x, k, d), w), 2.0 * _times(x, slopes[k])) / least**3

        first = [x / least**2 for x in a]
        second = [again(a[0], 0, du), again(a[0], 1, dv), again(a[1], 1, dv)]
    found = np.array([*map(_longest, (*first, *second))]) * SAFE
    return found, np.abs(second[0]).max(axis=(0, 1)) * SAFE


def _along(net: np.ndarray, axis: int, width: float) -> np.ndarray:
    """The net of the derivative along an axis."""
    return np.swapaxes(_slopes(np.swapaxes(net, 0, axis), width), 0, axis)


def _times(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The net of the product of two polynomials, the second of one coordinate."""
    (m, n), (p, q) = a.shape[:2], b.shape[:2]
    x = a * _binomials(m, n)
    y = b[..., 0] * _binomials(p, q)[..., 0]
    found = np.zeros((m + p - 1, n + q - 1, a.shape[2]))
    for i in range(p):
        for j in range(q):
            found[i : i + m, j : j + n] += x * y[i, j]
    product: np.ndarray = found / _binomials(m + p - 1, n + q - 1)
    return product


def _less(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The difference of two nets, each raised to the higher of their degrees."""
    m, n = max(a.shape[0], b.shape[0]), max(a.shape[1], b.shape[1])
    one: np.ndarray = _raised(a, m, n) - _raised(b, m, n)
    return one


def _raised(net: np.ndarray, m: int, n: int) -> np.ndarray:
    if net.shape[:2] == (m, n):
        return net
    return _times(net, np.ones((m - net.shape[0] + 1, n - net.shape[1] + 1, 1)))


@cache
def _binomials(m: int, n: int) -> np.ndarray:
    """(m, n, 1)."""
    rows = np.array([math.comb(m - 1, i) for i in range(m)], float)
    columns = np.array([math.comb(n - 1, j) for j in range(n)], float)
    return np.outer(rows, columns)[..., None]
