"""python-fcl: continuousCollide by conservative advancement, asked for 1e-9 and enough iterations."""

import fcl
import numpy as np

from peers.answer import Answer

LONGEST_TURN = 1.0
"""Radians in one call: the tool's screw motion takes the short way round."""


class ContinuousCollide:
    """CCDM_TRANS for translations, CCDM_SCREW for rotations, in equal parts of at most LONGEST_TURN."""

    name = "python-fcl"

    def prepare(self, scene):
        bodies = (scene.va, scene.fa), (scene.vb, scene.fb)
        return [fcl.CollisionObject(_model(vertices, faces)) for vertices, faces in bodies]

    def query(self, state, scene):
        a, b = state
        linear = scene.kind == "translation"
        motion = fcl.CCDMotionType.CCDM_TRANS if linear else fcl.CCDMotionType.CCDM_SCREW
        request = fcl.ContinuousCollisionRequest(
            num_max_iterations=10_000,
            toc_err=1e-9,
            ccd_motion_type=motion,
            ccd_solver_type=fcl.CCDSolverType.CCDC_CONSERVATIVE_ADVANCEMENT,
        )
        parts = 1 if linear else int(np.ceil(abs(scene.radians) / LONGEST_TURN))
        for part in range(parts):
            result = fcl.ContinuousCollisionResult()
            a.setTransform(_transform(scene, part / parts))
            end = _transform(scene, (part + 1) / parts)
            fcl.continuousCollide(a, end, b, fcl.Transform(), request, result)
            if result.is_collide:
                time = (part + result.time_of_contact) / parts
                return Answer("overlap" if time == 0.0 else "contact", time)
        return Answer("free")


def _model(vertices, faces):
    model = fcl.BVHModel()
    model.beginModel(len(faces), len(vertices))
    model.addSubModel(vertices, faces)
    model.endModel()
    return model


def _transform(scene, t):
    return fcl.Transform(*scene.pose(t))
