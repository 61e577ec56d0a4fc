"""Parts that OpenCASCADE makes, as STEP files: a drilled plate, a gear, a filleted bracket.

python benchmarks/step_parts.py FOLDER
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeBox,
    BRepPrimAPI_MakeCone,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakePrism,
)
from OCP.collections import Array1_gp_Pnt, List_TopoDS_Shape
from OCP.GeomAPI import GeomAPI_PointsToBSpline
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt, gp_Vec
from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS


def upright(x, y, z):
    return gp_Ax2(gp_Pnt(x, y, z), gp_Dir(0, 0, 1))


def plate():
    """100 x 60 x 5 with 60 countersunk holes."""
    tools = List_TopoDS_Shape()
    for i in range(10):
        for j in range(6):
            at = 5.0 + 10 * i, 5.0 + 10 * j
            tools.Append(BRepPrimAPI_MakeCylinder(upright(*at, -2), 1.5, 9).Shape())
            tools.Append(BRepPrimAPI_MakeCone(upright(*at, 1.5), 0.5, 4.5, 4).Shape())
    base = List_TopoDS_Shape()
    base.Append(BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), 100, 60, 5).Shape())
    cut = BRepAlgoAPI_Cut()
    cut.SetArguments(base)
    cut.SetTools(tools)
    cut.Build()
    return cut.Shape()


def gear(teeth=40, module=2.0, width=10.0):
    """Involute flanks as B-splines, straight tips and roots."""
    pitch, pressure = module * teeth / 2, math.radians(20)
    base, tip, root = pitch * math.cos(pressure), pitch + module, pitch - 1.25 * module
    involute = math.tan(pressure) - pressure
    half = math.pi / (2 * teeth) + involute

    def at(r, angle):
        return gp_Pnt(r * math.cos(angle), r * math.sin(angle), 0)

    def flank(middle, side):
        radii = np.linspace(max(base, root) * 1.0001, tip, 9)
        angles = [half - (math.tan(a) - a) for a in np.arccos(base / radii)]
        points = [at(r, middle + side * a) for r, a in zip(radii, angles, strict=True)]
        return points if side < 0 else points[::-1]

    wire = BRepBuilderAPI_MakeWire()
    chain = []
    for k in range(teeth):
        middle = 2 * math.pi * k / teeth
        up, down = flank(middle, -1), flank(middle, 1)
        chain += [("line", at(root, middle - half), up[0]), ("spline", up), ("line", up[-1], down[0])]
        chain += [("spline", down), ("line", down[-1], at(root, middle + half))]
        chain += [("line", at(root, middle + half), at(root, middle + 2 * math.pi / teeth - half))]
    for kind, *points in chain:
        if kind == "line":
            wire.Add(BRepBuilderAPI_MakeEdge(*points).Edge())
            continue
        array = Array1_gp_Pnt(1, len(points[0]))
        for k, p in enumerate(points[0], 1):
            array.SetValue(k, p)
        wire.Add(BRepBuilderAPI_MakeEdge(GeomAPI_PointsToBSpline(array).Curve()).Edge())
    solid = BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(wire.Wire()).Face(), gp_Vec(0, 0, width)).Shape()
    return BRepAlgoAPI_Cut(solid, BRepPrimAPI_MakeCylinder(upright(0, 0, -1), 8, width + 2).Shape()).Shape()


def bracket():
    """An angle with two holes; the edges along x are filleted."""
    angle = BRepAlgoAPI_Fuse(
        BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), 60, 40, 8).Shape(), BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), 60, 8, 50).Shape()
    )
    angle.SimplifyResult()
    made = BRepFilletAPI_MakeFillet(angle.Shape())
    walk, seen = TopExp_Explorer(angle.Shape(), TopAbs_ShapeEnum.TopAbs_EDGE), []
    from OCP.BRepAdaptor import BRepAdaptor_Curve

    while walk.More():
        edge = TopoDS.Edge(walk.Current())
        line = BRepAdaptor_Curve(edge).Line().Direction()
        if abs(line.X()) > 0.9 and not any(edge.IsSame(x) for x in seen):
            seen.append(edge)
            made.Add(3.0, edge)
        walk.Next()
    shape = made.Shape()
    for x in (15, 45):
        shape = BRepAlgoAPI_Cut(shape, BRepPrimAPI_MakeCylinder(upright(x, 25, -1), 4, 12).Shape()).Shape()
    return shape


PARTS = {"plate": plate, "gear": gear, "bracket": bracket}


def write(folder: Path) -> list[Path]:
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, make in PARTS.items():
        writer = STEPControl_Writer()
        writer.Transfer(make(), STEPControl_StepModelType.STEPControl_AsIs)
        paths.append(folder / f"{name}.stp")
        writer.Write(str(paths[-1]))
    return paths


if __name__ == "__main__":
    print(*write(Path(sys.argv[1] if len(sys.argv) > 1 else ".")), sep="\n")
