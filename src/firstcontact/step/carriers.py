"""The planes and quadrics that faces of a file lie on, of the rational numbers that the file's are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq

from firstcontact.body.solid.carriers import (
    ONE,
    ZERO,
    Plane,
    Quadric,
    Surface,
    Vector,
    dot,
    doubles,
    primitive,
    primitive_rows,
)
from firstcontact.exact.numbers import exact_value
from firstcontact.step.charts import bare

if TYPE_CHECKING:
    from OCP.Geom import Geom_ConicalSurface
    from OCP.gp import gp_Dir, gp_Pnt
    from OCP.TopoDS import TopoDS_Face


STRAIGHT = 1e-12
"""Tangent of an angle below which lines are along the axis, or across it."""


class NotExact(Exception):
    """A solid is not made of its surfaces here; the text says why."""


@dataclass(frozen=True)
class Carrier:
    """What a face lies on; nappe: of a cone, the plane through its tip with the face's nappe on its negative side.

    A point is inside of a cone in its nappe alone: the other one bounds nothing of the file.
    """

    surface: Surface
    nappe: Plane | None = None

    def beyond(self, lo: np.ndarray, hi: np.ndarray) -> bool:
        """Whether some of a box is on the side of the other nappe, or too near to it to tell."""
        if self.nappe is None:
            return False
        n = np.array(doubles((self.nappe.normal,))[0])
        reach = np.abs(n[:3]) @ (0.5 * (hi - lo))
        room = 1e-9 * (np.abs(n[:3]) @ np.maximum(np.abs(lo), np.abs(hi)) + abs(n[3]))
        return bool(n[:3] @ (0.5 * (lo + hi)) + n[3] + reach > -room)


def carrier_of(face: TopoDS_Face) -> Carrier | None:
    """None of faces on other surfaces than planes, cylinders, cones and spheres, and on both nappes of a cone."""
    from OCP.BRep import BRep_Tool

    surface = bare(BRep_Tool.Surface_s(face))
    kind = surface.DynamicType().Name()
    if kind not in ("Geom_Plane", "Geom_CylindricalSurface", "Geom_ConicalSurface", "Geom_SphericalSurface"):
        return None
    place = surface.Position()
    p, d = _exact(place.Location()), _exact(place.Direction())
    if kind == "Geom_Plane":
        return Carrier(Plane(primitive((*d, -dot(d, p)))))
    if kind == "Geom_SphericalSurface":
        return Carrier(_round(p, d, ZERO, exact_value(surface.Radius()), ZERO))
    if kind == "Geom_CylindricalSurface":
        return Carrier(_round(p, d, ONE, exact_value(surface.Radius()), ZERO))
    return _cone(p, d, surface, face)


def through_tips(carriers: Sequence[Carrier | None], room: float) -> list[Carrier | None]:
    """The carriers, planes that pass the tip of a cone within that distance through it.

    Sides of a sector do in the file, but for roundings: left as they are, they cut the cone in a curve that is next to
    straight, and its tip would be a point of the solid, or not, by these.
    """
    apexes = (x.surface.apex for x in carriers if x is not None and isinstance(x.surface, Quadric))
    tips = [tip for tip in apexes if tip is not None]
    return [_through(x, tips, exact_value(room)) for x in carriers]


def _through(carrier: Carrier | None, tips: list[Vector], room: fmpq) -> Carrier | None:
    if carrier is None or not isinstance(carrier.surface, Plane):
        return carrier
    *normal, constant = carrier.surface.normal
    for tip in tips:
        height = dot(normal, tip[:3]) + constant
        if height * height <= room * room * dot(normal, normal):
            return carrier if height == 0 else Carrier(Plane(primitive((*normal, -dot(normal, tip[:3])))))
    return carrier


def is_on_torus(face: TopoDS_Face) -> bool:
    from OCP.BRep import BRep_Tool

    return bool(bare(BRep_Tool.Surface_s(face)).DynamicType().Name() == "Geom_ToroidalSurface")


def _cone(p: Vector, d: Vector, surface: Geom_ConicalSurface, face: TopoDS_Face) -> Carrier | None:
    from OCP.BRepTools import BRepTools

    radius, slope = exact_value(surface.RefRadius()), exact_value(math.tan(surface.SemiAngle()))
    lo, hi = (surface.RefRadius() + v * math.sin(surface.SemiAngle()) for v in BRepTools.UVBounds_s(face)[2:])
    if min(lo, hi) < -1e-6 * max(lo, hi) and max(lo, hi) > -1e-6 * min(lo, hi):
        return None
    return Carrier(_round(p, d, ONE, radius, slope), _nappe(p, d, radius, slope, -1 if lo + hi > 0 else 1))


def _nappe(p: Vector, d: Vector, radius: fmpq, slope: fmpq, side: int) -> Plane:
    """Through the tip; the radius at x is radius + slope d.(x - p), negative on the other nappe."""
    normal = [side * slope * x for x in d]
    return Plane(primitive((*normal, side * radius - dot(normal, p))))


def revolved(p: Vector, d: Vector, a: float, b: float, c: float) -> Carrier:
    """a rho + b h = c for the height h above p along d, of length about 1, and the distance rho from that axis."""
    if abs(a) < STRAIGHT * abs(b):
        return Carrier(Plane(primitive((*d, -dot(d, p) - exact_value(c / b)))))
    radius = exact_value(c / a)
    if abs(b) < STRAIGHT * abs(a):
        return Carrier(_round(p, d, ONE, radius, ZERO))
    slope = exact_value(-b / a)
    return Carrier(_round(p, d, ONE, radius, slope), _nappe(p, d, radius, slope, -1))


def plane(normal: np.ndarray, place: np.ndarray) -> Carrier:
    n, at = ([exact_value(x) for x in v.tolist()] for v in (normal, place))
    return Carrier(Plane(primitive((*n, -dot(n, at)))))


def _exact(v: gp_Pnt | gp_Dir) -> Vector:
    return exact_value(v.X()), exact_value(v.Y()), exact_value(v.Z())


def _round(p: Vector, d: Vector, flat: fmpq, radius: fmpq, slope: fmpq) -> Quadric:
    """|x - p|^2 - flat h^2 / d.d - (radius + slope h)^2 with h = d.(x - p), for a direction d of length about 1."""
    k = flat / dot(d, d) + slope * slope
    block = [[(ONE if i == j else ZERO) - k * d[i] * d[j] for j in range(3)] for i in range(3)]
    # in y = x - p: y^T block y - 2 radius slope d.y - radius^2
    half = [-radius * slope * x for x in d]
    moved = [half[i] - dot(block[i], p) for i in range(3)]
    constant = sum((p[i] * dot(block[i], p) for i in range(3)), ZERO) - 2 * dot(half, p) - radius * radius
    rows = (*((*block[i], moved[i]) for i in range(3)), (*moved, constant))
    return Quadric(primitive_rows(rows))
