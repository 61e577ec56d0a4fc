"""Solids of planes with straight edges as polyhedra, whose faces are the file's planes, exactly.

A corner is the file's point where that lies on all planes that meet there, else the common point of these planes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq, fmpq_mat

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.errors import InputError
from firstcontact.exact.numbers import exact_value, fraction, to_double
from firstcontact.exact.vectors import dot
from firstcontact.step.solids import StepSolid, forward

if TYPE_CHECKING:
    from OCP.gp import gp_Dir, gp_Pnt
    from OCP.TopoDS import TopoDS_Edge, TopoDS_Face

Point = tuple[fmpq, fmpq, fmpq]


@dataclass(frozen=True)
class PlanarPart:
    """polyhedron: with a polygon for each face; moved: how far corners are from the file's points, at most."""

    polyhedron: Polyhedron
    moved: float


def polyhedron_of(solid: StepSolid) -> PlanarPart | None:
    """None for solids that have other faces or edges, or planes without a common point where the file has a corner."""
    planes = [plane_of(face) for face in solid.faces]
    if any(plane is None for plane in planes) or not all(map(_is_straight, solid.edges)):
        return None
    meeting: list[set[int]] = [set() for _ in solid.vertices]
    rings = []
    for number in range(len(solid.faces)):
        rings.append(_rings(solid, number))
        for ring in rings[-1]:
            for vertex in ring:
                meeting[vertex].add(number)
    points = []
    for place, around in zip(solid.points.tolist(), meeting, strict=True):
        point = _corner(place, [planes[k] for k in sorted(around)])  # type: ignore[misc]
        if point is None:
            return None
        points.append(point)
    moved = np.array([[to_double(x - exact_value(y)) for x, y in zip(p, q, strict=True)]
                      for p, q in zip(points, solid.points.tolist(), strict=True)])  # fmt: skip
    faces = [ring[0] if len(ring) == 1 else ring for ring in rings]
    corners = [tuple(fraction(x) for x in p) for p in points]
    try:
        made = Polyhedron(corners, faces, solid=True)
    except InputError:  # polygons that cross themselves
        return None
    return PlanarPart(made, float(np.linalg.norm(moved, axis=1).max()) * (1 + 1e-9))


def plane_of(face: TopoDS_Face) -> tuple[Point, fmpq] | None:
    """(n, d) of the plane n.x = d that a face lies on, from the numbers of the file; None of other faces."""
    from OCP.BRep import BRep_Tool

    surface = BRep_Tool.Surface_s(face)
    while surface.DynamicType().Name() == "Geom_RectangularTrimmedSurface":
        surface = surface.BasisSurface()
    if surface.DynamicType().Name() != "Geom_Plane":
        return None
    axis = surface.Position().Axis()
    n, p = _exact(axis.Direction()), _exact(axis.Location())
    return n, dot(n, p)


def _exact(v: gp_Pnt | gp_Dir) -> Point:
    return exact_value(v.X()), exact_value(v.Y()), exact_value(v.Z())


def _is_straight(edge: TopoDS_Edge) -> bool:
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.GeomAbs import GeomAbs_CurveType

    return bool(BRepAdaptor_Curve(edge).GetType() == GeomAbs_CurveType.GeomAbs_Line)


def _rings(solid: StepSolid, number: int) -> list[list[int]]:
    """The corners around a face as it looks outward, the outer ring first."""
    from OCP.BRepTools import BRepTools, BRepTools_WireExplorer
    from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
    from OCP.TopoDS import TopoDS

    from firstcontact.step.solids import explored

    face = solid.faces[number]
    plain = forward(face)
    outer = BRepTools.OuterWire_s(plain)
    found: list[list[int]] = []
    for wire in explored(plain, TopAbs_ShapeEnum.TopAbs_WIRE):
        walk = BRepTools_WireExplorer(TopoDS.Wire(wire), plain)
        ring = []
        while walk.More():
            ring.append(solid.vertex_number(walk.CurrentVertex()))
            walk.Next()
        if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
            ring.reverse()
        found.insert(0, ring) if wire.IsSame(outer) else found.append(ring)
    return found


def _corner(place: Sequence[float], planes: Sequence[tuple[Point, fmpq]]) -> Point | None:
    """The common point of the planes that is near the place."""
    point = exact_value(place[0]), exact_value(place[1]), exact_value(place[2])
    if all(dot(n, point) == d for n, d in planes):
        return point
    normals = np.array([[to_double(x) for x in n] for n, _ in planes])
    if len(planes) < 3:
        return None
    best = max(combinations(range(len(planes)), 3), key=lambda c: abs(np.linalg.det(normals[list(c)])))
    if abs(np.linalg.det(normals[list(best)])) < 1e-6:
        return None
    system = fmpq_mat([list(planes[k][0]) for k in best])
    x, y, z = (row[0] for row in system.solve(fmpq_mat([[planes[k][1]] for k in best])).tolist())
    return (x, y, z) if all(dot(n, (x, y, z)) == d for n, d in planes) else None
