"""The planes and quadrics that faces of a file lie on, of the rational numbers that the file's are."""

from __future__ import annotations

import math
from typing import Any

from flint import fmpq

from firstcontact.body.solid.carriers import ONE, ZERO, Plane, Quadric, Surface, Vector, dot, primitive, primitive_rows
from firstcontact.exact.numbers import exact_value


def carrier_of(face: Any) -> Surface | None:
    """None of faces on other surfaces than planes, cylinders, cones and spheres."""
    from OCP.BRep import BRep_Tool

    surface = BRep_Tool.Surface_s(face)
    kind = surface.DynamicType().Name()
    while kind == "Geom_RectangularTrimmedSurface":
        surface = surface.BasisSurface()
        kind = surface.DynamicType().Name()
    if kind not in ("Geom_Plane", "Geom_CylindricalSurface", "Geom_ConicalSurface", "Geom_SphericalSurface"):
        return None
    place = surface.Position()
    p, d = _exact(place.Location()), _exact(place.Direction())
    if kind == "Geom_Plane":
        return Plane(primitive((*d, -dot(d, p))))
    if kind == "Geom_SphericalSurface":
        return _round(p, d, ZERO, exact_value(surface.Radius()), ZERO)
    if kind == "Geom_CylindricalSurface":
        return _round(p, d, ONE, exact_value(surface.Radius()), ZERO)
    return _round(p, d, ONE, exact_value(surface.RefRadius()), exact_value(math.tan(surface.SemiAngle())))


def _exact(v: Any) -> Vector:
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
