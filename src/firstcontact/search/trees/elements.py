"""From parts of trees to elements of bodies: which vertex, edge or face a candidate means."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from flint import fmpq, fmpz

from firstcontact.exact.numbers import Undecidable
from firstcontact.exact.rigid import Matrix, apply
from firstcontact.exact.vectors import Vector, scaled, whole, whole_doubles
from firstcontact.pairs.elements.line_line import segments_meet
from firstcontact.pairs.elements.segment_facet import APART, relation
from firstcontact.search.trees.state import CERTAIN_KIND, EDGE_EDGE, EDGE_FACE, FACE_EDGE, FACE_VERTEX, VERTEX_FACE
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
_KINDS = np.array([KINDS[k] for k in range(len(KINDS))])
_AHEAD = np.array([[0, 0, 0], [0, 1, 1], [0, 1, 2]])  # corners of an element of a kind, counted from its first one

# Of a scale that all elements share; doubles of one size need some 110.
MOST_BITS = 256
# By which it grows ahead, so that it seldom grows.
SPARE = 32

# An element inside the search: (kind, index) with index a vertex, a segment or a triangle.
Feature = tuple[int, int]
Scale: TypeAlias = "int | fmpz"


def feature(tree: Tree, kind: int, part: int, local: int) -> Feature:
    """The element of the body: `local` counts the part's corners or sides."""
    primitive = int(tree.ids[part, 0])
    if kind == VERTEX:
        return VERTEX, int(tree.corners[primitive, local])
    if kind == EDGE:
        return EDGE, int(tree.sides[primitive, local])
    return FACE, primitive


def places(tree_a: Tree, tree_b: Tree, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3, 3) corners of the elements of candidates (n, 5) in the trees' frames; edges and vertices repeat theirs."""
    kinds = _KINDS[rows[:, 0] % CERTAIN_KIND]
    return _places(tree_a, kinds[:, 0], rows[:, 1], rows[:, 2]), _places(tree_b, kinds[:, 1], rows[:, 3], rows[:, 4])


def _places(tree: Tree, kinds: np.ndarray, parts: np.ndarray, local: np.ndarray) -> np.ndarray:
    first = np.where(kinds == FACE, 0, local)
    found: np.ndarray = tree.xyz.reshape(-1, 3, 3)[parts[:, None], (first[:, None] + _AHEAD[kinds]) % 3]
    return found


def vertices_of(body: Polyhedron, element: Feature) -> list[int]:
    """Its corners: one of a vertex, two of an edge (both the same for a bare point), three of a triangle."""
    kind, index = element
    if kind == VERTEX:
        return [index]
    if kind == EDGE:
        if index >= len(body.segments):
            return [index - len(body.segments)] * 2
        return body.segments[index].tolist()
    return body.triangles[index].tolist()


def corners_of(body: Polyhedron, element: Feature) -> list[VectorOf[fmpq]]:
    """The exact corners of the element."""
    return [body.exact_vertex(i) for i in vertices_of(body, element)]


class WholeCorners:
    """The corners of elements of two bodies and one vector, all times a scale that makes them whole numbers.

    Sums of whole numbers have no denominators to find.  The first pair of elements, mostly the only one, has a scale of
    its own, which is soonest done; all others share one, and vertices that many elements share are read once: the scale
    grows as vertices ask for it.  Where it would grow beyond `MOST_BITS`, elements have scales of their own again.
    number: what they are of, fmpz or, quicker as far as some 200 bits, int; balls in irrational poses stay balls.
    """

    def __init__(self, a: Polyhedron, b: Polyhedron, vector: Vector, number: type = fmpz) -> None:
        self.bodies, self.number = (a, b), number
        self._are_balls = a.irrational_pose is not None or b.irrational_pose is not None
        self._are_doubles = a.error == b.error == 0.0
        self._per, (self._vector,) = whole(vector)
        self._is_first = True
        self._begin(self._per, self._vector)

    def _begin(self, scale: fmpz, vector: Vector) -> None:
        """Anew, with a scale for all and the vector times it."""
        self._scale: Scale = self.number(scale)
        self._common = self._as_numbers(vector)
        self._places: tuple[dict[int, Vector], dict[int, Vector]] = {}, {}

    def of(self, element_a: Feature, element_b: Feature) -> tuple[Scale, list[Vector], list[Vector], Vector]:
        """(scale > 0, scale times the corners of the first element, of the second, scale times the vector)."""
        a, b = self.bodies
        if self._are_balls:
            x, y = ([scaled(self._per, p) for p in corners_of(*of)] for of in ((a, element_a), (b, element_b)))
            return self._per, x, y, self._vector
        first, second = vertices_of(a, element_a), vertices_of(b, element_b)
        if self._is_first:
            self._is_first = False
            return self._alone(first, second)
        while True:
            scale = self._scale
            x, y = [self._place(0, v) for v in first], [self._place(1, v) for v in second]
            if self._scale.bit_length() > MOST_BITS:
                self._begin(self._per, self._vector)
                return self._alone(first, second)
            if self._scale is scale:
                return scale, x, y, self._common

    def _place(self, side: int, vertex: int) -> Vector:
        found = self._places[side].get(vertex)
        if found is None:
            body, number = self.bodies[side], self.number
            if self._are_doubles:
                (x, p), (y, q), (z, r) = [c.as_integer_ratio() for c in body.vertices[vertex].tolist()]
            else:
                (x, p), (y, q), (z, r) = [(number(c.p), number(c.q)) for c in body.exact_vertex(vertex)]
            if self._scale % p or self._scale % q or self._scale % r:
                grown = fmpz(self._scale).lcm(p).lcm(q).lcm(r) << SPARE
                self._begin(grown, scaled(grown // self._per, self._vector))
            scale = self._scale
            found = number(x) * (scale // p), number(y) * (scale // q), number(z) * (scale // r)
            self._places[side][vertex] = found
        return found

    def _alone(self, first: list[int], second: list[int]) -> tuple[Scale, list[Vector], list[Vector], Vector]:
        """The same of vertices by a scale of their own."""
        a, b = self.bodies
        if self._are_doubles:  # the coordinates are the vertices' doubles
            doubles = [a.vertices[v].tolist() for v in first] + [b.vertices[v].tolist() for v in second]
            scale, points = whole_doubles(doubles, self._per, self.number)
        else:
            exact = [a.exact_vertex(v) for v in first] + [b.exact_vertex(v) for v in second]
            scale, points = whole(*exact, per=self._per)
            points = [self._as_numbers(p) for p in points]
        vector = self._as_numbers(scaled(fmpz(scale) // self._per, self._vector))
        return self.number(scale), points[: len(first)], points[len(first) :], vector

    def _as_numbers(self, x: Vector) -> Vector:
        return x if self.number is fmpz else (int(x[0]), int(x[1]), int(x[2]))


class Corners:
    """The corners of elements of two bodies and one vector in whole numbers of either kind, found when first asked."""

    def __init__(self, a: Polyhedron, b: Polyhedron, vector: Vector) -> None:
        self._of = a, b, vector
        self._whole: WholeCorners | None = None
        self._ints: WholeCorners | None = None

    @property
    def whole(self) -> WholeCorners:
        if self._whole is None:
            self._whole = WholeCorners(*self._of, fmpz)
        return self._whole

    @property
    def ints(self) -> WholeCorners:
        if self._ints is None:
            self._ints = WholeCorners(*self._of, int)
        return self._ints


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
