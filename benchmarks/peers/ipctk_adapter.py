"""ipctk: Tight-Inclusion on linear motion of the vertices.

A translation is cut into equal steps, more of them for finer meshes: in one step the boxes swept by 1e5
triangles make 3e7 candidate pairs.  A rotation goes by conservative chords.

A chord of h radians stays within r h^2 / 8 of the arc at radius r.  With that as minimum distance a clear
chord proves the arc clear.  Where a chord is not clear, the proved part is taken and the next one is shorter,
until its error is below ARC_ERROR.
"""

import ipctk
import numpy as np

from peers.answer import Answer

TOLERANCE = 1e-9
ARC_ERROR = 1e-10
"""Of the farthest radius; chords of 2.8e-5 radians."""
FIRST_CHORD, LONGEST_CHORD = 0.02, 0.2
"""Radians."""


class TightInclusion:
    """compute_collision_free_stepsize with the Tight-Inclusion narrow phase and the default broad phase."""

    name = "ipctk"

    def prepare(self, scene):
        ipctk.set_logger_level(ipctk.LoggerLevel.error)
        count = len(scene.va)
        vertices = np.asfortranarray(np.concatenate([scene.va, scene.vb]))
        faces = np.asfortranarray(np.concatenate([scene.fa, scene.fb + count]).astype(np.int32))
        mesh = ipctk.CollisionMesh(vertices, ipctk.edges(faces), faces)
        patch = np.zeros(len(vertices), dtype=np.int32)
        patch[count:] = 1
        mesh.can_collide = ipctk.make_vertex_patches_filter(patch)
        # A rescaling of nearly 1: else the answer stops at a fifth of the initial distance before contact.
        narrow = ipctk.TightInclusionCCD(tolerance=TOLERANCE, conservative_rescaling=1.0 - 1e-12)
        return mesh, vertices, narrow

    def query(self, state, scene):
        mesh, vertices, narrow = state
        if scene.expect == "overlap":
            # Its continuous test asks for disjoint bodies at the start, so this is a question of its own.
            return Answer("overlap", 0.0) if ipctk.has_intersections(mesh, vertices) else Answer("free")
        if scene.kind == "translation":
            return self._steps(mesh, vertices, narrow, scene)
        return self._chords(mesh, vertices, narrow, scene)

    def _steps(self, mesh, vertices, narrow, scene):
        count = max(1, round(np.sqrt(len(scene.fa)) / 10.0))
        start = vertices
        for step in range(count):
            end = self._pose(vertices, scene, (step + 1) / count)
            part = ipctk.compute_collision_free_stepsize(mesh, start, end, 0.0, None, narrow)
            if part < 1.0:
                return Answer("contact", (step + part) / count, {"steps": step + 1})
            start = end
        return Answer("free", counts={"steps": count})

    def _chords(self, mesh, vertices, narrow, scene):
        """Every turn proves the arc clear up to ``t`` or shortens the chord; the shortest one decides."""
        off = vertices[: len(scene.va)] - scene.point
        reach = np.sqrt(np.max(np.einsum("ij,ij->i", off, off) - (off @ scene.axis) ** 2))
        angle, shortest = abs(scene.radians), np.sqrt(8.0 * ARC_ERROR)
        t, chord, steps = 0.0, FIRST_CHORD, 0
        start = vertices
        while t < 1.0:
            chord = max(min(chord, (1.0 - t) * angle), min(shortest, (1.0 - t) * angle))
            end = self._pose(vertices, scene, t + chord / angle)
            margin = reach * chord * chord / 8.0
            part = ipctk.compute_collision_free_stepsize(mesh, start, end, margin, None, narrow)
            steps += 1
            if part < 1.0 and chord <= shortest * 1.001:
                return Answer("contact", t + part * chord / angle, {"steps": steps})
            t = min(1.0, t + part * chord / angle)
            start = self._pose(vertices, scene, t)
            chord = min(2.0 * chord, LONGEST_CHORD) if part == 1.0 else chord / 8.0
        return Answer("free", counts={"steps": steps})

    @staticmethod
    def _pose(vertices, scene, t):
        turn, shift = scene.pose(t)
        moved = vertices.copy(order="F")
        moved[: len(scene.va)] = scene.va @ turn.T + shift
        return moved
