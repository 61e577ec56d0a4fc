"""The elements of a contact by elimination: of bare points and a model, where a proved contact leaves one pair alone.

In the time in which contact begins, balls tell which points may be in the model at all, and on which of its surfaces.
Where that is one point and one surface with a single face, these meet: contact begins on the model's boundary.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from flint import arb

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.csg import possible
from firstcontact.contact.models.answer import element
from firstcontact.exact.numbers import ball, exact_value
from firstcontact.motion.moving import pose_of, shape_of
from firstcontact.motion.relative.curved import CurvedPiece, terms
from firstcontact.motion.relative.pieces import curved_pieces
from firstcontact.result import ContactSet, Element

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.result import ContactFields

BITS = 128
MOST_POINTS = 64
Pair = tuple[int, int, tuple[float, ...] | None]


def sole_pair(
    moving_mesh: Body, moving_model: Body, mesh_is_a: bool, times: tuple[float, float], point: np.ndarray | None
) -> ContactFields:
    """Elements, normal and multiplicity of a contact that begins within the times, at a point that is nearly this one.

    Nothing where more than one pair may meet.
    """
    mesh, model = shape_of(moving_mesh), shape_of(moving_model)
    bare = not len(mesh.triangles) and not len(mesh.segments) and mesh.irrational_pose is None
    if not bare or not isinstance(model, CompositeQuadric) or len(mesh.vertices) > MOST_POINTS or point is None:
        return {}
    known = {pair for piece in curved_pieces(moving_mesh, moving_model, *map(exact_value, times))
             for pair in _possible(mesh, model, piece)}  # fmt: skip
    if len(known) != 1:
        return {}
    ((vertex, surface, normal),) = known
    faces = [face for face in model.faces if surface in face.surfaces]
    if len(faces) != 1 or normal is None:
        return {}
    which, other = ("a", "b") if mesh_is_a else ("b", "a")
    pose = pose_of(moving_model, 0.5 * (times[0] + times[1]))
    outward = outward_normal(pose, np.array(normal) * faces[0].orientation)
    name = mesh.name or which
    elements = Element("vertex", name, vertex, name), element(model, faces[0], other, point)
    first, second = elements if mesh_is_a else elements[::-1]
    return {
        "element_a": first, "element_b": second, "normal": outward if mesh_is_a else -outward, "multiplicity": 1,
        "contact_set": ContactSet("point", point[None]),
    }  # fmt: skip


def outward_normal(pose: np.ndarray, gradient: np.ndarray) -> np.ndarray:
    """(3,): unit, where a gradient in the model's frame points in the pose."""
    normal = np.linalg.solve(pose[:3, :3].T, gradient)
    unit: np.ndarray = normal / np.linalg.norm(normal)
    return unit


def _possible(mesh: Polyhedron, model: CompositeQuadric, piece: CurvedPiece) -> set[Pair]:
    """Points that may be in the model during the piece, with surfaces on which they may be, and their gradients there.

    A gradient is None where it is not told from zero, as at the apex of a cone.
    """
    found: set[Pair] = set()
    with terms(1, BITS):
        pose = [[x[0] for x in row] for row in piece.series(ball(piece.start).union(ball(piece.end)))]
        for vertex in range(len(mesh.vertices)):
            p = mesh.exact_vertex(vertex)
            x = [sum((row[k] * p[k] for k in range(3)), row[3]) for row in pose]
            values = [surface.value((*x, arb(1))) for surface in model.surfaces]
            below, above = [not v > 0 for v in values], [not v < 0 for v in values]
            if not possible(model.tree, below, above)[0]:
                continue
            for k, surface in enumerate(model.surfaces):
                if below[k] and above[k]:
                    gradient = [arb(c) for c in surface.gradient((*x, arb(1)))]
                    sure = not all(c.contains(0) for c in gradient)
                    found.add((vertex, k, tuple(float(c.mid()) for c in gradient) if sure else None))
    return found
