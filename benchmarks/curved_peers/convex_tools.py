"""coal, python-fcl and mujoco: distances of convex primitives; coal also of triangle meshes."""

from __future__ import annotations

import numpy as np

NOWHERE = 1e3
"""Farther than any two of the bodies ever are."""


def _lift(kind, numbers):
    """Height of the tool's centre above ours: its cones are centred half-way up."""
    return 0.5 * numbers[1] if kind == "cone" else 0.0


def _raised(pose, lift):
    rotation, vector = pose
    return (rotation, vector + lift * rotation[:, 2]) if lift else pose


class Coal:
    name = "coal"

    def __init__(self):
        import coal

        self.tool = coal
        self.request = coal.DistanceRequest()
        self.request.enable_signed_distance = False

    def shape(self, kind, numbers):
        make = {"sphere": "Sphere", "ellipsoid": "Ellipsoid", "cylinder": "Cylinder", "cone": "Cone", "box": "Box"}
        make["capsule"] = "Capsule"
        return getattr(self.tool, make[kind])(*numbers), _lift(kind, numbers)

    def mesh(self, vertices, triangles):
        model = self.tool.BVHModelOBBRSS()
        model.beginModel(len(triangles), len(vertices))
        model.addVertices(np.ascontiguousarray(vertices))
        model.addTriangles(np.ascontiguousarray(triangles, dtype=np.int64))
        model.endModel()
        return model, 0.0

    def distance(self, a, b):
        (shape_a, lift_a), (shape_b, lift_b) = a, b
        place, ask, result = self.tool.Transform3s, self.tool.distance, self.tool.DistanceResult

        def gap(pose_a, pose_b):
            at_a, at_b = place(*_raised(pose_a, lift_a)), place(*_raised(pose_b, lift_b))
            return ask(shape_a, at_a, shape_b, at_b, self.request, result())

        return gap


class PythonFcl:
    name = "python-fcl"

    def __init__(self):
        import fcl

        self.tool = fcl
        self.request = fcl.DistanceRequest()

    def shape(self, kind, numbers):
        make = {"sphere": "Sphere", "ellipsoid": "Ellipsoid", "cylinder": "Cylinder", "cone": "Cone", "box": "Box"}
        make["capsule"] = "Capsule"
        return getattr(self.tool, make[kind])(*numbers), _lift(kind, numbers)

    def distance(self, a, b):
        (shape_a, lift_a), (shape_b, lift_b) = a, b
        body_a, body_b = self.tool.CollisionObject(shape_a), self.tool.CollisionObject(shape_b)
        place, ask, result = self.tool.Transform, self.tool.distance, self.tool.DistanceResult

        def gap(pose_a, pose_b):
            body_a.setTransform(place(*_raised(pose_a, lift_a)))
            body_b.setTransform(place(*_raised(pose_b, lift_b)))
            return ask(body_a, body_b, self.request, result())

        return gap


class Mujoco:
    """mj_geomDistance, its iterations allowed to converge."""

    name = "mujoco"

    def __init__(self):
        import mujoco

        self.tool = mujoco

    def shape(self, kind, numbers):
        match kind:
            case "cone":
                return None
            case "cylinder" | "capsule":
                sizes = numbers[0], 0.5 * numbers[1]
            case "box":
                sizes = tuple(0.5 * x for x in numbers)
            case _:
                sizes = numbers
        return f'<geom type="{kind}" size="{" ".join(map(repr, sizes))}"/>'

    def distance(self, a, b):
        option = '<option ccd_tolerance="1e-12" ccd_iterations="200"/>'
        model = self.tool.MjModel.from_xml_string(f"<mujoco>{option}<worldbody>{a}{b}</worldbody></mujoco>")
        data = self.tool.MjData(model)
        self.tool.mj_forward(model, data)
        ask = self.tool.mj_geomDistance

        def gap(pose_a, pose_b):
            for k, (rotation, vector) in enumerate((pose_a, pose_b)):
                data.geom_xmat[k] = rotation.ravel()
                data.geom_xpos[k] = vector
            return ask(model, data, 0, 1, NOWHERE, None)

        return gap
