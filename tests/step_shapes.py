"""Shapes of OpenCASCADE for tests, and STEP files of them; import after `pytest.importorskip("OCP")`."""

from __future__ import annotations

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakeVertex,
    BRepBuilderAPI_MakeWire,
    BRepBuilderAPI_Transform,
)
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeBox,
    BRepPrimAPI_MakeCone,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakePrism,
    BRepPrimAPI_MakeRevol,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)
from OCP.collections import Array1_gp_Pnt
from OCP.GeomAbs import GeomAbs_CurveType
from OCP.GeomAPI import GeomAPI_PointsToBSpline
from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec
from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_ShapeEnum, TopAbs_State
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool


def axis(place=(0, 0, 0), direction=(0, 0, 1)):
    return gp_Ax2(gp_Pnt(*place), gp_Dir(*direction))


def box(size, at=(0, 0, 0)):
    return BRepPrimAPI_MakeBox(gp_Pnt(*at), *size).Shape()


def cylinder(radius, height, place=(0, 0, 0), direction=(0, 0, 1)):
    return BRepPrimAPI_MakeCylinder(axis(place, direction), radius, height).Shape()


def cone(bottom, top, height, place=(0, 0, 0), direction=(0, 0, 1)):
    return BRepPrimAPI_MakeCone(axis(place, direction), bottom, top, height).Shape()


def sector(bottom, top, height, angle):
    """Of a cone about an axis along none of the coordinates."""
    place = gp_Ax2(gp_Pnt(0.3, -0.4, 0.1), gp_Dir(0.45, -0.53, 0.72))
    return BRepPrimAPI_MakeCone(place, bottom, top, height, angle).Shape()


def sphere(radius, at=(0, 0, 0)):
    return BRepPrimAPI_MakeSphere(gp_Pnt(*at), radius).Shape()


def torus(big, small):
    return BRepPrimAPI_MakeTorus(big, small).Shape()


def cut(a, b):
    return BRepAlgoAPI_Cut(a, b).Shape()


def fuse(a, b):
    return BRepAlgoAPI_Fuse(a, b).Shape()


def filleted(shape, radius, which=lambda edge: True):
    made = BRepFilletAPI_MakeFillet(shape)
    walk = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_EDGE)
    while walk.More():
        edge = TopoDS.Edge(walk.Current())
        if which(edge):
            made.Add(radius, edge)
        walk.Next()
    return made.Shape()


def ends_at(point):
    """Of edges: whether they go through a point."""
    vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*point)).Vertex()
    return lambda edge: BRepExtrema_DistShapeShape(vertex, edge).Value() < 1e-9


def circle_at(point):
    """Of edges: whether they are circles, or arcs, through a point."""
    near = ends_at(point)
    return lambda edge: BRepAdaptor_Curve(edge).GetType() == GeomAbs_CurveType.GeomAbs_Circle and near(edge)


def upright(edge):
    """Whether an edge is a line along z."""
    curve = BRepAdaptor_Curve(edge)
    return curve.GetType() == GeomAbs_CurveType.GeomAbs_Line and abs(curve.Line().Direction().Z()) > 0.9


def level_at(z):
    """Of edges: whether all of them is at that height."""
    def is_level(edge):
        curve = BRepAdaptor_Curve(edge)
        times = np.linspace(curve.FirstParameter(), curve.LastParameter(), 5)
        return all(abs(curve.Value(float(t)).Z() - z) < 1e-9 for t in times)

    return is_level


def spline(points):
    array = Array1_gp_Pnt(1, len(points))
    for k, p in enumerate(points, 1):
        array.SetValue(k, gp_Pnt(*p))
    return GeomAPI_PointsToBSpline(array).Curve()


def outline(curve, corners):
    """A face bounded by a curve and straight edges through the corners back to its start."""
    first, last = curve.Value(curve.FirstParameter()), curve.Value(curve.LastParameter())
    wire = BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(curve).Edge())
    chain = [last, *(gp_Pnt(*c) for c in corners), first]
    for p, q in zip(chain, chain[1:], strict=False):
        wire.Add(BRepBuilderAPI_MakeEdge(p, q).Edge())
    return BRepBuilderAPI_MakeFace(wire.Wire()).Face()


def wave(height=3.0):
    """A prism over an outline with a B-spline: an extruded B-spline surface."""
    curve = spline([(x, 1.5 + np.sin(1.3 * x), 0) for x in np.linspace(0, 5, 12)])
    return BRepPrimAPI_MakePrism(outline(curve, [(5, -1, 0), (0, -1, 0)]), gp_Vec(0, 0, height)).Shape()


def vase():
    """A B-spline turned about an axis."""
    curve = spline([(1.5 + 0.4 * np.sin(2 * z), 0, z) for z in np.linspace(0, 4, 10)])
    face = outline(curve, [(0, 0, 4), (0, 0, 0)])
    return BRepPrimAPI_MakeRevol(face, gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))).Shape()


def moved(shape, vector=(0, 0, 0), turn=None):
    """turn: (axis, radians)."""
    trsf = gp_Trsf()
    if turn is not None:
        trsf.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(*turn[0])), turn[1])
    shift = gp_Trsf()
    shift.SetTranslation(gp_Vec(*vector))
    return BRepBuilderAPI_Transform(shape, shift.Multiplied(trsf), True).Shape()


def write(path, *shapes):
    writer = STEPControl_Writer()
    for shape in shapes:
        writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
    writer.Write(str(path))
    return path


def assembly(path):
    """A plate with two pins, the second one turned by a quarter about z and shifted."""
    document = TDocStd_Document(TCollection_ExtendedString("made"))
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    colours = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    root = tool.NewShape()

    def named(label, name):
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(name))

    named(root, "jig")
    plate = tool.AddShape(box((10, 8, 1)), False)
    pin = tool.AddShape(box((1, 2, 3)), False)
    named(plate, "plate")
    named(pin, "pin")
    colours.SetColor(pin, Quantity_Color(1.0, 0.0, 0.0, Quantity_TypeOfColor.Quantity_TOC_RGB),
                     XCAFDoc_ColorType.XCAFDoc_ColorSurf)  # fmt: skip
    turn = gp_Trsf()
    turn.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), np.pi / 2)
    shift = gp_Trsf()
    shift.SetTranslation(gp_Vec(5, 2, 4))
    first = gp_Trsf()
    first.SetTranslation(gp_Vec(1, 1, 4))
    named(tool.AddComponent(root, plate, TopLoc_Location()), "plate")
    named(tool.AddComponent(root, pin, TopLoc_Location(first)), "pin")
    named(tool.AddComponent(root, pin, TopLoc_Location(shift.Multiplied(turn))), "pin")
    tool.UpdateAssemblies()
    writer = STEPCAFControl_Writer()
    writer.SetNameMode(True)
    writer.SetColorMode(True)
    writer.Transfer(document)
    writer.Write(str(path))
    return path


def distance(shape, point):
    """From a point to the faces of a shape."""
    shell = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_SHELL).Current()
    return BRepExtrema_DistShapeShape(BRepBuilderAPI_MakeVertex(gp_Pnt(*point)).Vertex(), shell).Value()


def offset_prism():
    """A prism with an offset of a sphere for its top."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
    from OCP.Geom import Geom_OffsetSurface, Geom_SphericalSurface
    from OCP.gp import gp_Ax3

    ball = Geom_SphericalSurface(gp_Ax3(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), 4.0)
    face = BRepBuilderAPI_MakeFace(Geom_OffsetSurface(ball, 0.5), 0.0, 0.4, 0.2, 0.6, 1e-7).Face()
    return BRepPrimAPI_MakePrism(face, gp_Vec(0, 0, 3)).Shape()


def inside(shape, points):
    """(n,) by OpenCASCADE's classifier."""
    asked = BRepClass3d_SolidClassifier(shape)
    found = []
    for p in points.tolist():
        asked.Perform(gp_Pnt(*p), 1e-9)
        found.append(asked.State() == TopAbs_State.TopAbs_IN)
    return np.array(found)


def same_points(shape, body):
    """That points anywhere, and next to faces, where it matters, are inside as OpenCASCADE has it."""
    rng = np.random.default_rng(11)
    lo, hi = body.bounds()
    random = rng.uniform(2 * lo - hi, 2 * hi - lo, (700, 3))
    mesh = body.shown[0].body
    corners = mesh.vertices[mesh.triangles[rng.integers(0, len(mesh.triangles), 500)]]
    near = np.einsum("nk,nkj->nj", rng.dirichlet((1, 1, 1), 500), corners) + rng.normal(0, 3e-3, (500, 3))
    points = np.concatenate([random, near])
    wrong = np.flatnonzero(body.contains(points) != inside(shape, points))
    assert all(distance(shape, points[k]) <= body.deviation + 1e-7 for k in wrong)
