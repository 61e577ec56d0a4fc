"""rapier3d: linear and nonlinear shape casts of one triangle mesh against another, in single precision."""

import numpy as np
import rapier3d as rapier

from peers.answer import Answer


class ShapeCast:
    """QueryPipeline.cast_shape for translations, cast_shape_nonlinear for rotations."""

    name = "rapier3d"

    def prepare(self, scene):
        world = rapier.PhysicsWorld(gravity=(0.0, 0.0, 0.0))
        world.add_collider(rapier.Collider.trimesh(*_buffers(scene.vb, scene.fb)))
        world.step()
        return world, rapier.SharedShape.trimesh(*_buffers(scene.va, scene.fa))

    def query(self, state, scene):
        world, shape = state
        start = rapier.Isometry3()
        if scene.kind == "translation":
            options = rapier.ShapeCastOptions(max_time_of_impact=1.0)
            found = world.query_pipeline.cast_shape(start, tuple(scene.vector), shape, options)
        else:
            motion = rapier.NonlinearRigidMotion(
                start=start,
                local_center=tuple(scene.point),
                linvel=(0.0, 0.0, 0.0),
                angvel=tuple(scene.axis * scene.radians),
            )
            options = rapier.ShapeCastOptions()
            found = world.query_pipeline.cast_shape_nonlinear(motion, shape, options, 0.0, 1.0)
        if found is None:
            return Answer("free")
        hit = found[1]
        overlap = hit.status == rapier.ShapeCastStatus.PENETRATING_OR_WITHIN_TARGET_DIST
        return Answer("overlap" if overlap else "contact", float(hit.time_of_impact))


def _buffers(vertices, faces):
    return np.ascontiguousarray(vertices, dtype=np.float32), np.ascontiguousarray(faces, dtype=np.uint32)
