"""Whether points of surfaces are in the faces that a file has on them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from firstcontact.step.charts import Elementary
from firstcontact.step.solids import StepSolid

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Face

CLOSE = 1e-7
"""How near to its border a point counts as one of the face, in its parameters."""


class Trims:
    """Of a solid of planes, cylinders, cones and spheres: its faces in their parameters, by OpenCASCADE."""

    def __init__(self, solid: StepSolid) -> None:
        self.solid = solid
        self.faces: dict[int, TrimFace] = {}
        self.borders = Counter(face for faces in solid.incidence[0] for face in faces)
        """How many edges each face has: the more, the longer its answers take."""

    def outside(self, points: np.ndarray, group: np.ndarray, groups: Sequence[Iterable[int]]) -> np.ndarray:
        """(n,) whether points (n, 3), on the surfaces of all faces of their groups, are in none of these."""
        member = np.zeros((len(groups), len(self.solid.faces)), bool)
        for own, faces in zip(member, groups, strict=True):
            own[list(faces)] = True
        left = np.ones(len(points), bool)
        for number in sorted(np.flatnonzero(member.any(axis=0)).tolist(), key=self.borders.__getitem__):
            here = np.flatnonzero(left & member[group, number])
            if len(here):
                left[here] = ~self._face(number).holds(points[here])
        return left

    def within(self, points: np.ndarray, faces: Iterable[int]) -> np.ndarray:
        """Those that are in one of them."""
        found = np.zeros(len(points), bool)
        for number in faces:
            found |= self._face(number).holds(points)
        within: np.ndarray = points[found]
        return within

    def _face(self, number: int) -> TrimFace:
        if number not in self.faces:
            self.faces[number] = _TrimFace(self.solid.faces[number])
        return self.faces[number]


class TrimFace(Protocol):
    def holds(self, points: np.ndarray) -> np.ndarray:
        """(n,) of points of the surface, (n, 3): whether they are in the face or on its border."""


class _TrimFace:
    def __init__(self, face: TopoDS_Face) -> None:
        from OCP.BRep import BRep_Tool
        from OCP.BRepTools import BRepTools
        from OCP.IntTools import IntTools_FClass2d

        self.chart = Elementary(BRep_Tool.Surface_s(face))
        low, high = BRepTools.UVBounds_s(face)[:2]
        self.least = 0.5 * (low + high) - np.pi
        self.asked = IntTools_FClass2d(face, CLOSE)

    def holds(self, points: np.ndarray) -> np.ndarray:
        """(n,) of points of the surface, (n, 3): whether they are in the face or on its border."""
        from OCP.gp import gp_Pnt2d
        from OCP.TopAbs import TopAbs_State

        parameters = self.chart.parameters(points, self.least).tolist()
        out, told = TopAbs_State.TopAbs_OUT, self.asked.Perform
        return np.array([told(gp_Pnt2d(u, v)) != out for u, v in parameters], bool)
