"""OpenCASCADE (cadquery-ocp-novtk): distances of boundary representations, and the Boolean operations of parts."""

from __future__ import annotations

import numpy as np


class OpenCascade:
    name = "OpenCASCADE"

    def __init__(self):
        from OCP import BRepAlgoAPI, BRepBuilderAPI, BRepExtrema, BRepPrimAPI, TopLoc, gp

        self.gp, self.make, self.location = gp, BRepPrimAPI, TopLoc.TopLoc_Location
        self.algo, self.build = BRepAlgoAPI, BRepBuilderAPI
        self.extrema = BRepExtrema.BRepExtrema_DistShapeShape

    def shape(self, kind, numbers):
        match kind:
            case "capsule":
                radius, height = numbers
                balls = [self._moved(self.shape("sphere", (radius,)), z) for z in (-0.5 * height, 0.5 * height)]
                return self.fuse(self.fuse(self.shape("cylinder", numbers), balls[0]), balls[1])
            case "ellipsoid":
                stretch = self.gp.gp_GTrsf()
                for k, radius in enumerate(numbers, 1):
                    stretch.SetValue(k, k, radius)
                return self.build.BRepBuilderAPI_GTransform(self.shape("sphere", (1.0,)), stretch, True).Shape()
            case "sphere":
                return self.make.BRepPrimAPI_MakeSphere(*numbers).Shape()
            case "box":
                low, high = (self.gp.gp_Pnt(*(s * x for x in numbers)) for s in (-0.5, 0.5))
                return self.make.BRepPrimAPI_MakeBox(low, high).Shape()
            case "cylinder":
                return self.make.BRepPrimAPI_MakeCylinder(self._upright(-0.5 * numbers[1]), *numbers).Shape()
            case "cone":
                return self.frustum(numbers[0], 0.0, numbers[1], (0, 0, 0))

    def distance(self, a, b):
        def gap(pose_a, pose_b):
            found = self.extrema(self._placed(a, *pose_a), self._placed(b, *pose_b))
            return found.Value() if found.IsDone() else float("nan")

        return gap

    # -- parts: the same words as `parts.Ours` ----------------------------------------------------------------

    def box(self, size, at):
        return self._placed(self.shape("box", size), np.eye(3), at)

    def cylinder(self, radius, height, at, axis="z"):
        turn = {"z": np.eye(3), "x": np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])}[axis]
        return self._placed(self.shape("cylinder", (radius, height)), turn, at)

    def frustum(self, bottom, top, height, at):
        shape = self.make.BRepPrimAPI_MakeCone(self._upright(0.0), bottom, top, height).Shape()
        return self._placed(shape, np.eye(3), at)

    def cut(self, a, b):
        return self.algo.BRepAlgoAPI_Cut(a, b).Shape()

    def fuse(self, a, b):
        return self.algo.BRepAlgoAPI_Fuse(a, b).Shape()

    # -- inside -----------------------------------------------------------------------------------------------

    def _upright(self, z):
        return self.gp.gp_Ax2(self.gp.gp_Pnt(0, 0, z), self.gp.gp_Dir(0, 0, 1))

    def _moved(self, shape, z):
        return self._placed(shape, np.eye(3), (0, 0, z))

    def _placed(self, shape, rotation, vector):
        pose = self.gp.gp_Trsf()
        pose.SetRotation(self.gp.gp_Quaternion(self.gp.gp_Mat(*rotation.ravel().tolist())))
        pose.SetTranslationPart(self.gp.gp_Vec(*map(float, vector)))
        return shape.Moved(self.location(pose))
