"""Solids as OpenCASCADE has them: their faces, edges and vertices by number, with the file's entities.

Numbers are those in which the file's shell lists them.  What makes a solid none is one InputError that names the
entity: borders that are open, edges of three faces, tolerances beyond all sense.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.errors import InputError
from firstcontact.step.reader import Shape

if TYPE_CHECKING:
    from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopoDS import TopoDS_Edge, TopoDS_Face, TopoDS_Shape, TopoDS_Vertex

MOST_TOLERANCE = 1e-2
"""Of a solid's size: what edges and vertices may be off; beyond that they say nothing."""


@dataclass(frozen=True, eq=False)
class Use:
    """A face's use of an edge: `edge` as the face has it that is not turned over, its number, and whether the solid's
    face runs along it backwards."""

    edge: TopoDS_Edge
    number: int
    reversed: bool


class StepSolid:
    """who: what errors call it, the part; shape: the solid of OpenCASCADE."""

    def __init__(self, shape: TopoDS_Shape, part: Shape) -> None:
        from OCP.TopAbs import TopAbs_ShapeEnum as Kind
        from OCP.TopoDS import TopoDS

        self.shape, self.part = shape, part
        self._maps = {}
        for kind in (Kind.TopAbs_FACE, Kind.TopAbs_EDGE, Kind.TopAbs_VERTEX):
            self._maps[kind] = _mapped(shape, kind)
        self.faces = [TopoDS.Face(x) for x in explored(shape, Kind.TopAbs_FACE)]
        self.edges = [TopoDS.Edge(x) for x in _all(self._maps[Kind.TopAbs_EDGE])]
        self.vertices = [TopoDS.Vertex(x) for x in _all(self._maps[Kind.TopAbs_VERTEX])]

    @property
    def who(self) -> str:
        number = self.part.entity(self.shape)
        return self.part.name + ("" if number is None else f" (#{number})")

    # -- numbers ----------------------------------------------------------------------------------------------

    def edge_number(self, edge: TopoDS_Edge) -> int:
        from OCP.TopAbs import TopAbs_ShapeEnum as Kind

        return int(self._maps[Kind.TopAbs_EDGE].FindIndex(edge)) - 1

    def vertex_number(self, vertex: TopoDS_Vertex) -> int:
        from OCP.TopAbs import TopAbs_ShapeEnum as Kind

        return int(self._maps[Kind.TopAbs_VERTEX].FindIndex(vertex)) - 1

    @cached_property
    def labels(self) -> dict[str, list[str]]:
        """What the file calls faces, edges and vertices: "#123", or nothing where that is not known."""
        kinds = {"face": self.faces, "edge": self.edges, "vertex": self.vertices}
        return {kind: [self.called(x) for x in shapes] for kind, shapes in kinds.items()}

    def called(self, shape: TopoDS_Shape) -> str:
        number = self.part.entity(shape)
        return "" if number is None else f"#{number}"

    def named(self, kind: str, number: int) -> str:
        """How errors call a face, edge or vertex."""
        label = self.labels[kind][number]
        return f"{kind} {label or number}"

    # -- looking ----------------------------------------------------------------------------------------------

    @cached_property
    def uses(self) -> list[list[Use]]:
        """Of each face the edges around it; a seam comes twice."""
        from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
        from OCP.TopoDS import TopoDS

        back = TopAbs_Orientation.TopAbs_REVERSED
        return [
            [
                Use(TopoDS.Edge(x), self.edge_number(x), (x.Orientation() == back) != (face.Orientation() == back))
                for x in explored(forward(face), TopAbs_ShapeEnum.TopAbs_EDGE)
            ]
            for face in self.faces
        ]

    @cached_property
    def incidence(self) -> tuple[tuple[frozenset[int], ...], tuple[frozenset[int], ...]]:
        """Of each edge, and of each vertex, the faces that it belongs to."""
        from OCP.TopExp import TopExp

        edges: list[set[int]] = [set() for _ in self.edges]
        vertices: list[set[int]] = [set() for _ in self.vertices]
        for face, uses in enumerate(self.uses):
            for use in uses:
                edges[use.number].add(face)
                for end in (TopExp.FirstVertex_s(use.edge), TopExp.LastVertex_s(use.edge)):
                    vertices[self.vertex_number(end)].add(face)
        return tuple(map(frozenset, edges)), tuple(map(frozenset, vertices))

    @cached_property
    def points(self) -> np.ndarray:
        """(n, 3) places of the vertices."""
        from OCP.BRep import BRep_Tool

        places = [BRep_Tool.Pnt_s(v) for v in self.vertices]
        return np.array([[p.X(), p.Y(), p.Z()] for p in places]).reshape(-1, 3)

    @cached_property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """Corners of a box around it, a little larger than it is."""
        from OCP.Bnd import Bnd_Box
        from OCP.BRepBndLib import BRepBndLib

        box = Bnd_Box()
        BRepBndLib.AddOptimal_s(self.shape, box, False, False)
        lo, hi = box.CornerMin(), box.CornerMax()
        return np.array([lo.X(), lo.Y(), lo.Z()]), np.array([hi.X(), hi.Y(), hi.Z()])

    @cached_property
    def size(self) -> float:
        lo, hi = self.box
        return float((hi - lo).max())

    @cached_property
    def volume_and_area(self) -> tuple[float, float]:
        from OCP.BRepGProp import BRepGProp
        from OCP.GProp import GProp_GProps

        volume, area = GProp_GProps(), GProp_GProps()
        BRepGProp.VolumeProperties_s(self.shape, volume)
        BRepGProp.SurfaceProperties_s(self.shape, area)
        return volume.Mass(), area.Mass()

    def is_degenerate(self, number: int) -> bool:
        from OCP.BRep import BRep_Tool

        return bool(BRep_Tool.Degenerated_s(self.edges[number]))

    # -- checking ---------------------------------------------------------------------------------------------

    def check(self) -> None:
        """InputError where it is no solid."""
        if not self.faces:
            raise InputError(f"{self.who}: it has no faces; export the model again")
        self.check_borders()
        self._check_tolerances()

    def check_borders(self) -> None:
        """InputError where an edge borders one face, or more than two."""
        ahead: Counter[int] = Counter()
        back: Counter[int] = Counter()
        for uses in self.uses:
            for use in uses:
                (back if use.reversed else ahead)[use.number] += 1
        for number in range(len(self.edges)):
            if self.is_degenerate(number) or (ahead[number] == back[number] == 1):
                continue
            count = ahead[number] + back[number]
            here = [k for k, uses in enumerate(self.uses) if any(use.number == number for use in uses)]
            faces = " and ".join(self.named("face", k) for k in here[:3])
            if count < 2:
                raise InputError(
                    f"{self.who}: its shell is open at {self.named('edge', number)}, which borders {faces} alone; a "
                    "face is missing there or could not be read: close the solid and export it again"
                )
            raise InputError(
                f"{self.who}: {self.named('edge', number)} borders {count} faces in directions that do not match "
                f"({faces}); a solid has two at each edge: mend it and export it again"
            )

    def _check_tolerances(self) -> None:
        from OCP.BRep import BRep_Tool

        most = MOST_TOLERANCE * self.size
        for kind, shapes in (("edge", self.edges), ("vertex", self.vertices)):
            for number, shape in enumerate(shapes):
                off = BRep_Tool.Tolerance_s(shape)
                if off > most:
                    raise InputError(
                        f"{self.who}: {self.named(kind, number)} is known to within {off:.3g} only, of a solid of size "
                        f"{self.size:.3g}; faces do not meet there: mend the model and export it again"
                    )


def forward(face: TopoDS_Face) -> TopoDS_Face:
    """The face as its surface lies, not turned over."""
    from OCP.TopAbs import TopAbs_Orientation
    from OCP.TopoDS import TopoDS

    return TopoDS.Face(face.Oriented(TopAbs_Orientation.TopAbs_FORWARD))


def explored(shape: TopoDS_Shape, kind: TopAbs_ShapeEnum) -> Iterator[TopoDS_Shape]:
    """Parts of a shape of one kind, as often as they are there, in its order."""
    from OCP.TopExp import TopExp_Explorer

    walk = TopExp_Explorer(shape, kind)
    while walk.More():
        yield walk.Current()
        walk.Next()


def _mapped(shape: TopoDS_Shape, kind: TopAbs_ShapeEnum) -> IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher:
    from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher
    from OCP.TopExp import TopExp

    found = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
    TopExp.MapShapes_s(shape, kind, found)
    return found


def _all(found: IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher) -> list[TopoDS_Shape]:
    return [found.FindKey(k) for k in range(1, found.Extent() + 1)]
