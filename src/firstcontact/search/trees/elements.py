"""From parts of trees to elements of bodies: which vertex, edge or face a candidate means."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flint import fmpq, fmpz

from firstcontact.exact.numbers import Undecidable
from firstcontact.exact.rigid import Matrix, apply
from firstcontact.exact.vectors import Vector, scaled, whole, whole_doubles
from firstcontact.pairs.elements.line_line import segments_meet
from firstcontact.pairs.elements.segment_facet import APART, relation
from firstcontact.search.trees.state import EDGE_EDGE, EDGE_FACE, FACE_EDGE, FACE_VERTEX, VERTEX_FACE
from firstcontact.search.trees.tree import Tree

if TYPE_CHECKING:
    from firstcontact.body.polyhedron.polyhedron import Polyhedron
    from firstcontact.exact.ring import VectorOf

VERTEX, EDGE, FACE = range(3)
KINDS = {
    int(VERTEX_FACE): (VERTEX, FACE),
    int(EDGE_EDGE): (EDGE, EDGE),
    int(FACE_VERTEX): (FACE, VERTEX),
    int(EDGE_FACE): (EDGE, FACE),
    int(FACE_EDGE): (FACE, EDGE),
}

# An element inside the search: (kind, index) with index a vertex, a segment or a triangle.
Feature = tuple[int, int]


def feature(tree: Tree, kind: int, part: int, local: int) -> Feature:
    """The element of the body: `local` counts the part's corners or sides."""
    primitive = int(tree.ids[part, 0])
    if kind == VERTEX:
        return VERTEX, int(tree.corners[primitive, local])
    if kind == EDGE:
        return EDGE, int(tree.sides[primitive, local])
    return FACE, primitive


def vertices_of(body: Polyhedron, element: Feature) -> list[int]:
    """Its corners: one of a vertex, two of an edge (both the same for a bare point), three of a triangle."""
    kind, index = element
    if kind == VERTEX:
        return [index]
    if kind == EDGE:
        if index >= len(body._segments):
            return [index - len(body._segments)] * 2
        return body._segments[index].tolist()
    return body.triangles[index].tolist()


def corners_of(body: Polyhedron, element: Feature) -> list[VectorOf[fmpq]]:
    """The exact corners of the element."""
    return [body.exact_vertex(i) for i in vertices_of(body, element)]


def whole_corners(
    a: Polyhedron, element_a: Feature, b: Polyhedron, element_b: Feature, per: fmpz, vector: Vector, number: type = fmpz
) -> tuple[Any, list[Vector], list[Vector], Vector]:
    """(scale > 0, scale times the corners of both elements, scale times vector / per), all whole numbers.

    Sums of whole numbers have no denominators to find.  Corners in irrational poses are balls, and the scale is `per`.
    number: what corners given by doubles become; `int` is quicker than fmpz as far as some 200 bits.
    """
    if a._pose is not None or b._pose is not None:
        x, y = ([scaled(per, p) for p in corners_of(*which)] for which in ((a, element_a), (b, element_b)))
        return per, x, y, vector
    first, second = vertices_of(a, element_a), vertices_of(b, element_b)
    if a.error == 0.0 and b.error == 0.0:  # the coordinates are the doubles
        doubles = [a.vertices[i].tolist() for i in first] + [b.vertices[i].tolist() for i in second]
        scale, points = whole_doubles(doubles, per, number)
    else:
        exact = [a.exact_vertex(i) for i in first] + [b.exact_vertex(i) for i in second]
        scale, points = whole(*exact, per=per)
    return scale, points[: len(first)], points[len(first) :], scaled(scale // number(per), vector)


class Primitive:
    """A triangle, bare edge or bare point with its exact corners."""

    __slots__ = ("corners", "is_facet", "sides")
    corners: Any
    sides: Any

    def __init__(self, body: Polyhedron, tree: Tree, index: int) -> None:
        self.is_facet = index < len(body.triangles)
        corners = [body.exact_vertex(i) for i in tree.corners[index].tolist()]
        self.corners = corners if self.is_facet else corners[:2]
        self._find_sides()

    def _find_sides(self) -> None:
        c = self.corners
        self.sides = [(c[0], c[1]), (c[1], c[2]), (c[2], c[0])] if self.is_facet else [(c[0], c[1])]

    @classmethod
    def of(cls, corners: list[VectorOf[fmpq]]) -> Primitive:
        """The primitive spanned by one, two or three corners."""
        other = object.__new__(cls)
        other.is_facet = len(corners) == 3
        other.corners = corners if len(corners) > 1 else corners * 2
        other._find_sides()
        return other

    def moved(self, pose: Matrix) -> Primitive:
        return self.of([apply(pose, p) for p in self.corners])

    def meets(self, other: Primitive) -> bool:
        """Whether the two, at rest, share a point."""
        if not (self.is_facet or other.is_facet):
            return segments_meet(*self.sides[0], *other.sides[0])
        return any(
            relation(*side, *facet.corners) != APART
            for facet, edges in ((self, other), (other, self))
            if facet.is_facet
            for side in edges.sides
        )


def certainly_meet(x: Primitive, y: Primitive) -> bool:
    """Whether a side of one certainly meets the other, a facet; False too where balls leave it open."""
    for facet, edges in ((x, y), (y, x)):
        for side in edges.sides if facet.is_facet else ():
            try:
                if relation(*side, *facet.corners) != APART:
                    return True
            except Undecidable:
                continue  # another side may tell
    return False
