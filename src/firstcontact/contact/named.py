"""Elements of ruled surfaces and polyhedra by the pieces and triangles they belong to."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.ruled.triangles import element_of
from firstcontact.motion.moving import shape_of
from firstcontact.result import Element

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

PER_PIECE = {"vertex": 4, "directrix": 2, "end_ruling": 2, "face": 1}
"""Elements of a piece; those of a strip count on from piece to piece, as inequalities ("edge") do."""


def element(body: Body, kind: str, index: int, number: int, which: str) -> Element:
    """That of piece, or triangle, `number`; which: "a" or "b", the name of a body without one."""
    name, shape = getattr(body, "name", None) or which, shape_of(body)
    if isinstance(shape, Polyhedron):
        kind, index = element_of(shape, number, kind, index)
    elif kind == "edge":
        index += sum(len(piece.trim) for piece in shape.pieces[:number])
    else:
        index += number * PER_PIECE[kind]
    return Element(kind, name, index, name)
