"""Compile every kernel by asking tiny questions whose paths together use all of them."""

from __future__ import annotations

from collections.abc import Callable

from firstcontact import query
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw
from firstcontact.motion.sequence import Sequence
from firstcontact.motion.translation import Translation
from firstcontact.search.trees.crowding import crowding
from firstcontact.search.trees.frame import tree_of


def warm(progress: Callable[[str], object] | None = None) -> None:
    """Run each verb on each motion once; `progress` is told what comes next."""
    base = _tetrahedron()
    raised = base.translated((0.125, 0.0625, 2))  # off the symmetric place, where screws leave pairs undecided
    shift = Translation((0, 0, -2))
    # An oblique axis: kernels for axes along z alone would leave the general ones uncompiled.
    swing = Rotation((1, 2, 0), (3, 0, 0), degrees=200)
    screw = Screw((0.1, 1, 2), (0.3, -0.2, 0.1), degrees=40, advance=-3)
    motions = {"translation": shift, "rotation": swing, "screw": screw, "sequence": Sequence([shift, swing])}
    for name, motion in motions.items():
        moving = raised.moving(motion)
        for verb in (query.first_contact, query.contact_intervals, query.contact_pairs):
            if name == "sequence" and verb is query.contact_pairs:
                continue
            if progress is not None:
                progress(f"{verb.__name__} under {name}")
            verb(moving, base)
    query.first_contact(base.translated((0.1, 0.1, 0)), base)
    inside = base.transformed([[0.1, 0, 0, 0.1], [0, 0.1, 0, 0.1], [0, 0, 0.1, 0.1], [0, 0, 0, 1]])
    query.first_contact(inside, base)
    open_mesh = Polyhedron(base.vertices, base.triangles[:2])
    query.first_contact(raised.moving(shift), open_mesh)
    tree = tree_of(base)
    crowding(tree.boxes, tree.links, tree.boxes, tree.links)  # asked only of larger bodies
    if progress is not None:
        progress("intersection_curve of ruled surfaces")
    saddle, level = RuledSurface("(u, 0, 0)", "(u, 1, u)"), RuledSurface("(u, 0, 1/2)", "(u, 1, 1/2)")
    query.intersection_curve(saddle, level, method="certified")


def _tetrahedron() -> Polyhedron:
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    return Polyhedron(vertices, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
