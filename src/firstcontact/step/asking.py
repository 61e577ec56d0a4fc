"""What is asked of OpenCASCADE about points: whether they are inside of a solid, or on its faces.

Its classifier takes a ray to all faces, for each point anew.  Here a line is taken to the faces whose boxes it meets,
of three that are nearly along axes the one whose faces have the fewest edges, by the same intersections of OpenCASCADE.
Where they do not tell - at edges, along faces, where ways in and out do not take turns all along the line - its
classifier is asked.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.step.solids import StepSolid, explored

if TYPE_CHECKING:
    from OCP.BRepClass3d import BRepClass3d_SolidClassifier
    from OCP.gp import gp_Lin
    from OCP.TopAbs import TopAbs_State
    from OCP.TopoDS import TopoDS_Face

LINES = np.array([[1.0, 0.0127, 0.0291], [0.0291, 1.0, 0.0127], [0.0127, 0.0291, 1.0]])
"""Directions, of positive numbers: not along axes, where faces are."""
CLOSE = 1e-7
"""Of the solid's size: crossings as near to each other, or to the point, do not tell."""
TOLERANCE, ENDLESS, MOST = 1e-9, 1e100, 50_000
"""Of OpenCASCADE's questions; how far lines go; and boxes of faces that are looked at in one go."""


class Asking:
    """Of one solid."""

    def __init__(self, solid: StepSolid) -> None:
        from OCP.IntCurvesFace import IntCurvesFace_Intersector

        self.solid = solid
        self.faces = [IntCurvesFace_Intersector(face, TOLERANCE) for face in solid.faces]
        self.near = room = CLOSE * solid.size
        boxes = np.array([_box(face) for face in solid.faces])
        self.lo, self.hi = boxes[:, 0] - room, boxes[:, 1] + room
        self.costs = np.array([4.0 + len(uses) for uses in solid.uses])

    def inside(self, points: np.ndarray) -> np.ndarray:
        """(n,) whether the points (n, 3) are inside."""
        count = max(1, MOST // len(self.faces))
        parts = [self._inside(points[k : k + count]) for k in range(0, len(points), count)]
        return np.concatenate([np.empty(0, bool), *parts])

    def _inside(self, points: np.ndarray) -> np.ndarray:
        from OCP.gp import gp_Dir, gp_Lin, gp_Pnt

        met = np.stack([self._met(points, direction) for direction in LINES])  # (lines, n, faces)
        best = (met @ self.costs).argmin(axis=0)
        directions = [gp_Dir(*direction) for direction in LINES.tolist()]
        found = np.empty(len(points), bool)
        for k, (point, line) in enumerate(zip(points.tolist(), best.tolist(), strict=True)):
            faces = np.flatnonzero(met[line, k]).tolist()
            told = self._crossed(gp_Lin(gp_Pnt(*point), directions[line]), faces) if faces else False
            found[k] = self._is_inside(point) if told is None else told
        return found

    def _met(self, points: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """(n, faces) whether lines through the points meet the faces' boxes."""
        first, last = -np.inf, np.inf
        for x, lo, hi, rate in zip(points.T[:, :, None], self.lo.T, self.hi.T, 1.0 / direction, strict=True):
            first, last = np.maximum(first, (lo - x) * rate), np.minimum(last, (hi - x) * rate)
        met: np.ndarray = np.asarray(first <= last)
        return met

    def _crossed(self, line: gp_Lin, faces: list[int]) -> bool | None:
        """Whether the line's point is inside, by its ways in and out through the faces; None where they do not tell."""
        from OCP.IntCurveSurface import IntCurveSurface_TransitionOnCurve as Way
        from OCP.TopAbs import TopAbs_State

        here, along, inward = TopAbs_State.TopAbs_IN, Way.IntCurveSurface_Tangent, Way.IntCurveSurface_In
        crossings: list[tuple[float, bool]] = []
        for number in faces:
            face = self.faces[number]
            face.Perform(line, -ENDLESS, ENDLESS)
            if not face.IsDone():
                return None
            for k in range(1, face.NbPnt() + 1):
                way = face.Transition(k)
                if face.State(k) != here or way == along:
                    return None
                crossings.append((face.WParameter(k), way == inward))
        crossings.sort()
        before, turn, found = -np.inf, True, False
        for at, is_inward in crossings:
            if is_inward != turn or at - before <= self.near or abs(at) <= self.near:
                return None
            before, turn = at, not turn
            found ^= at > 0.0
        return found if turn else None

    @cached_property
    def _classifier(self) -> BRepClass3d_SolidClassifier:
        from OCP.BRepClass3d import BRepClass3d_SolidClassifier

        return BRepClass3d_SolidClassifier(self.solid.shape)

    def _state(self, point: Sequence[float], near: float) -> TopAbs_State:
        from OCP.gp import gp_Pnt

        self._classifier.Perform(gp_Pnt(*point), near)
        return self._classifier.State()

    def _is_inside(self, point: Sequence[float]) -> bool:
        from OCP.TopAbs import TopAbs_State

        return bool(self._state(point, TOLERANCE) == TopAbs_State.TopAbs_IN)

    def off_faces(self, point: Sequence[float], surely: float) -> float:
        """How far a point is from the faces; 0 within the distance `surely`."""
        from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
        from OCP.BRepExtrema import BRepExtrema_DistShapeShape
        from OCP.gp import gp_Pnt
        from OCP.TopAbs import TopAbs_ShapeEnum, TopAbs_State

        if self._state(point, surely) == TopAbs_State.TopAbs_ON:
            return 0.0
        # on seams it does not tell
        vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*point)).Vertex()
        shells = explored(self.solid.shape, TopAbs_ShapeEnum.TopAbs_SHELL)
        off: float = min(BRepExtrema_DistShapeShape(vertex, shell).Value() for shell in shells)
        return 0.0 if off <= surely else off


def _box(face: TopoDS_Face) -> list[list[float]]:
    """Corners of a box that the face is in."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    box = Bnd_Box()
    BRepBndLib.Add_s(face, box, False)
    lo, hi = box.CornerMin(), box.CornerMax()
    return [[lo.X(), lo.Y(), lo.Z()], [hi.X(), hi.Y(), hi.Z()]]
