"""Triangles, bare edges and points of a polyhedron as a model without inside, so that exact arithmetic meets them.

Each triangle is the intersection of both sides of its plane with the insides of its three sides: a point of the
plane counts as in it, since a form that vanishes there may have either sign (`csg.outcomes`).  Edges and points alike.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from flint import fmpq

from firstcontact.body.kept import Kept
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.carriers import ONE, ZERO, Line, Plane, Point, Surface, Vector, columns, dot, primitive
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.csg import Leaf, Or, Tree, conjunction
from firstcontact.body.solid.features import Edge, EdgePiece, Face, Vertex
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import to_double
from firstcontact.exact.vectors import cross
from firstcontact.search.trees.frame import tree_of

ROOM = 0.125
"""Of the size of a patch, by which its box is larger."""


_SIDES = (0, 1), (1, 2), (0, 2)
"""Of a triangle, in the order of its edges."""


@dataclass(frozen=True, eq=False)
class Patch:
    """What `contact.models.algorithm` reads of a model, for some primitives of the polyhedron `source`."""

    source: Polyhedron
    name: str | None
    surfaces: tuple[Surface, ...]
    tree: Tree
    faces: tuple[Face, ...]
    edges: tuple[Edge, ...]
    vertices: tuple[Vertex, ...]
    seams: tuple[Edge, ...] = ()
    whole: None = None
    regular: bool = False
    corners: tuple[np.ndarray, np.ndarray] = field(default_factory=lambda: (np.zeros(3), np.zeros(3)))
    hulls: dict[Face | Edge, list[Vector]] = field(default_factory=dict)
    """The corners of every face and edge."""
    _search: dict[Any, Any] = field(default_factory=dict)
    """What was worked out of these triangles."""

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner, (3,) float64 each, of a box that holds them."""
        return self.corners


def patch(body: Polyhedron, primitives: Iterable[int], outward: Sequence[float]) -> Patch:
    """Triangles, bare edges and bare points, by their numbers in the body's tree; with the edges and vertices of
    triangles that are not inside flat faces.

    outward: a point (x, y, z) in the body's frame; normals of faces point to its side.  A triangle without area is its
    longest side, or the point where all its corners are.  Raises UnsupportedPair for bare edges without length, and for
    triangles whose longest side is no edge.
    """
    chosen = sorted(set(primitives))
    parts = _Parts(body, tuple(fmpq(*float(x).as_integer_ratio()) for x in outward))
    for k in chosen:
        first = len(parts.surfaces)
        if k < len(body.triangles):
            parts.add_triangle(k)
        else:
            parts.add_bare(k)
        parts.trees.append(conjunction([Leaf(i) for i in range(first, len(parts.surfaces))]))
    edges, vertices = parts.edges(), parts.vertices()
    for e in edges:
        parts.hulls[e] = [body.exact_vertex(i) for i in body.segments[e.index].tolist()]
    return Patch(
        body, body.name, tuple(parts.surfaces), _union(parts.trees), tuple(parts.faces), tuple(edges), tuple(vertices),
        corners=_box(body, chosen), hulls=parts.hulls,
    )  # fmt: skip


class _Parts:
    """Of a patch: on_edge, on_vertex: the surfaces that hold each; bare: vertices of bare edges and bare points."""

    def __init__(self, body: Polyhedron, toward: Vector) -> None:
        self.body, self.who, self.toward = body, body.name or "polyhedron", toward
        self.surfaces: list[Surface] = []
        self.trees: list[Tree] = []
        self.faces: list[Face] = []
        self.on_edge: dict[int, set[int]] = defaultdict(set)
        self.on_vertex: dict[int, set[int]] = defaultdict(set)
        self.faces_at: dict[int, set[int]] = defaultdict(set)
        self.bare: set[int] = set()
        self.hulls: dict[Face | Edge, Any] = {}

    def add_triangle(self, k: int) -> None:
        body, first = self.body, len(self.surfaces)
        corners = body.triangles[k].tolist()
        points = [body.exact_vertex(i) for i in corners]
        forms = triangle_forms(points, self.toward)
        if forms is None:
            side, ends = longest_side(body, k), [corners[i] for i in spanning(points)]
            if side is not None and not 0 <= side < len(body.edges):
                raise UnsupportedPair(f"{self.who}: triangle {k} has no area, and its longest side is no edge")
            self._add_segment(side, ends)
            return
        self.surfaces += [forms[0], forms[0].negated(), *forms[1:]]
        for s in range(3):
            side = int(body.side_edge[k, s])
            self.on_edge[side] |= {first, first + 1, first + 2 + s}
            self.faces_at[side].add(len(self.faces))
            self.on_vertex[corners[s]] |= {first, first + 1, first + 2 + s, first + 2 + (s + 2) % 3}
        polygon = int(body.triangle_face[k])
        self.faces.append(Face(polygon, f"{self.who}.{polygon}", forms[0], (first, first + 1), 1))
        self.hulls[self.faces[-1]] = points

    def add_bare(self, k: int) -> None:
        self._add_segment(*bare_primitive(self.body, k))

    def _add_segment(self, edge: int | None, corners: list[int]) -> None:
        """An edge with its two vertices, or a point."""
        along = set(range(len(self.surfaces), len(self.surfaces) + 4))
        ends = len(self.surfaces) + 4, len(self.surfaces) + 5
        self.surfaces += _bare_forms([self.body.exact_vertex(i) for i in corners])
        self.bare |= set(corners)
        if edge is None:
            self.on_vertex[corners[0]] |= {*along, *ends}
            return
        self.on_edge[edge] |= along
        for v, end in zip(corners, ends, strict=True):
            self.on_vertex[v] |= {*along, end}

    def edges(self) -> list[Edge]:
        sharp = (k for k in sorted(self.on_edge) if is_sharp_edge(self.body, k))
        return [_edge(self.body, self.who, k, self.on_edge[k], self.faces_at[k]) for k in sharp]

    def vertices(self) -> list[Vertex]:
        sharp = (v for v in sorted(self.on_vertex) if v in self.bare or is_sharp_vertex(self.body, v))
        return [_vertex(self.body, self.who, v, self.on_vertex[v]) for v in sharp]


def bare_primitive(body: Polyhedron, k: int) -> tuple[int | None, list[int]]:
    """(the edge, its two vertices) of a bare edge, (None, [the vertex]) of a bare point."""
    tree = tree_of(body)
    e = int(tree.sides[k][0])
    if e >= len(body.segments):
        return None, [int(tree.corners[k][0])]
    return e, body.segments[e].tolist()


def _bare_forms(points: Sequence[Vector]) -> list[Plane]:
    """Planes from both sides through a point, or along an edge; then the two across it, that of its first end first."""
    p = points[0]
    if len(points) == 1:
        return [_plane(n, p) for k in range(3) for n in (_axis(k, 1), _axis(k, -1))]
    d = _minus(points[1], p)
    if not any(d):
        raise UnsupportedPair("an edge without length; exact arithmetic does not take it")
    m = tuple(cross(d, _axis(min(range(3), key=lambda k: abs(d[k])), 1)))
    across = m, tuple(cross(d, m))
    back = tuple(-c for c in d)
    return [
        *(_plane(n, p) for m in across for n in (m, tuple(-c for c in m))), _plane(back, p), _plane(d, points[1]),
    ]  # fmt: skip


def _axis(k: int, sign: int) -> Vector:
    return tuple(fmpq(sign if i == k else 0) for i in range(3))


def _box(body: Polyhedron, primitives: Iterable[int]) -> tuple[np.ndarray, np.ndarray]:
    """With some room on all sides, so that it is not flat."""
    x = body.vertices[tree_of(body).corners[list(primitives)].ravel()]
    lo, hi = x.min(axis=0), x.max(axis=0)
    room = body.error + ROOM * float(np.max(hi - lo))
    return lo - room, hi + room


def _union(trees: Sequence[Tree]) -> Tree:
    if len(trees) == 1:
        return trees[0]
    half = len(trees) // 2
    return Or(_union(trees[:half]), _union(trees[half:]))


def triangle_forms(points: Sequence[Vector], toward: Vector) -> list[Plane] | None:
    """The plane, positive at `toward` (either way where that lies in it), and the sides, negative inside.

    None for a triangle without area.
    """
    n = _cross_of(*points)
    if not any(n):
        return None
    if dot(n, [x - y for x, y in zip(toward, points[0], strict=True)]) < 0:
        n = tuple(-x for x in n)
    planes = [_plane(n, points[0])]
    for s in range(3):
        p, q, r = points[s], points[(s + 1) % 3], points[(s + 2) % 3]
        m = cross(_minus(q, p), n)
        planes.append(_plane(m if dot(m, _minus(r, p)) < 0 else tuple(-x for x in m), p))
    return planes


def _plane(n: Sequence[fmpq], point: Vector) -> Plane:
    return Plane(primitive((*n, -dot(n, point))))


def _minus(x: Vector, y: Vector) -> Vector:
    return tuple(a - b for a, b in zip(x, y, strict=True))


def _cross_of(a: Vector, b: Vector, c: Vector) -> Vector:
    return tuple(cross(_minus(b, a), _minus(c, a)))


def _edge(body: Polyhedron, who: str, e: int, surfaces: set[int], faces: set[int]) -> Edge:
    i, j = body.segments[e].tolist()
    a, b = body.exact_vertex(i), body.exact_vertex(j)
    line = Line(columns((*_minus(b, a), ZERO), (*a, ONE)))
    frame = np.array([[to_double(c) for c in row] for row in line.basis])
    pieces = (EdgePiece(0.0, 1.0, i, j),)
    return Edge(e, f"{who}.{e}", line, tuple(sorted(surfaces)), "convex", pieces, tuple(sorted(faces)), frame)


def _vertex(body: Polyhedron, who: str, v: int, surfaces: set[int]) -> Vertex:
    x = body.exact_vertex(v)
    where = to_double(x[0]), to_double(x[1]), to_double(x[2])
    return Vertex(v, f"{who}.{v}", Point(columns((*x, ONE))), tuple(sorted(surfaces)), where, body.error)


def is_sharp_edge(body: Polyhedron, e: int) -> bool:
    """Whether a segment is an edge that users know, and the surface does not go on flat across it."""
    if not 0 <= e < len(body.edges):
        return False
    is_bent = e < body.given_edges or _BENT.of(body, lambda: _bent(body))[e]
    return bool(is_bent) or not _in_one_plane(body, triangles_at_edge(body, e)) or not _has_two_sides(body, e)


def is_sharp_vertex(body: Polyhedron, v: int) -> bool:
    """Whether the triangles at a vertex do not lie in one plane, or end there: on the rim of an open or folded one."""
    around = triangles_at_vertex(body, v)
    sides = [e for e in set(body.side_edge[around].ravel().tolist()) if e >= 0 and v in body.segments[e]]
    if _BENT.of(body, lambda: _bent(body))[sides].any() or any(len(triangles_at_edge(body, e)) < 2 for e in sides):
        return True
    return not _in_one_plane(body, around) or not all(_has_two_sides(body, e) for e in sides)


_BENT = Kept[np.ndarray]()
_TWO_SIDED = Kept[np.ndarray]()
_AT_EDGES = Kept[tuple[np.ndarray, np.ndarray]]()
_AT_VERTICES = Kept[tuple[np.ndarray, np.ndarray]]()


def triangles_at_edge(body: Polyhedron, e: int) -> np.ndarray:
    return _at(body, _AT_EDGES, body.side_edge, e)


def triangles_at_vertex(body: Polyhedron, v: int) -> np.ndarray:
    return _at(body, _AT_VERTICES, body.triangles, v)


def _at(body: Polyhedron, place: Kept[tuple[np.ndarray, np.ndarray]], numbers: np.ndarray, k: int) -> np.ndarray:
    """The rows (n, 3) that name the number, ascending."""
    rows, ordered = _rows_of(body, place, numbers)
    return rows[np.searchsorted(ordered, k) : np.searchsorted(ordered, k, side="right")]


def _rows_of(
    body: Polyhedron, place: Kept[tuple[np.ndarray, np.ndarray]], numbers: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The rows (n, 3) that name numbers, and these, in their order; kept on the body."""
    def sort() -> tuple[np.ndarray, np.ndarray]:
        order = np.argsort(numbers.ravel(), kind="stable")
        return order // 3, numbers.ravel()[order]

    return place.of(body, sort)


def _has_two_sides(body: Polyhedron, e: int) -> bool:
    """Whether triangles lie on both sides of a segment, which lie in one plane but for those without area; exact."""
    if _TWO_SIDED.of(body, lambda: _two_sided(body))[e]:
        return True
    i, j = body.segments[e].tolist()
    p, q = body.exact_vertex(i), body.exact_vertex(j)
    thirds = [body.exact_vertex(sum(t) - i - j) for t in body.triangles[triangles_at_edge(body, e)].tolist()]
    normals = [n for n in (_cross_of(p, q, r) for r in thirds) if any(n)]
    return any(dot(n, normals[0]) < 0 for n in normals)


def _in_one_plane(body: Polyhedron, triangles: np.ndarray) -> bool:
    """Whether there are several triangles, all in one plane, and not all without area; exact."""
    if len(triangles) < 2:
        return False
    points = [[body.exact_vertex(i) for i in t] for t in body.triangles[triangles].tolist()]
    n = next((n for n in (_cross_of(*t) for t in points) if any(n)), None)
    if n is None:
        return False
    height = dot(n, points[0][0])
    return all(dot(n, p) == height for t in points for p in t)


def _bent(body: Polyhedron) -> np.ndarray:
    """(segments,) whether doubles prove that two triangles of it do not lie in one plane.

    Of u, v, w, each entry at most D and off by e, the determinant is off by 18 D^2 e at most, and its roundings are 48
    of D^3 at most.
    """
    bent = np.zeros(len(body.segments), bool)
    edges, one, other = _neighbours(body)
    if not len(edges):
        return bent
    one, other = body.vertices[one], body.vertices[other]
    u, v, w = one[:, 1] - one[:, 0], one[:, 2] - one[:, 0], other - one[:, :1]
    off, most = _sizes(body, u, v, w)
    bound = 20.0 * most * most * off + 2.0**-46 * most**3 + 1e-300  # where products underflow
    heights = np.einsum("nsd,nd->ns", w, np.cross(u, v))
    bent[edges[(np.abs(heights) > bound[:, None]).any(axis=1)]] = True
    return bent


def _two_sided(body: Polyhedron) -> np.ndarray:
    """(segments,) whether doubles prove of two triangles of it that their normals, as if turned alike about it, differ
    by more than a right angle: that they lie on two sides of it, if in one plane.

    The entries of both normals are at most 2 D^2, and off by 8 D e and roundings of D^2.
    """
    found = np.zeros(len(body.segments), bool)
    edges, one, other = _neighbours(body)
    if not len(edges):
        return found
    ends = body.segments[edges]
    p = body.vertices[ends[:, 0]]
    d, u, v = (body.vertices[k] - p for k in (ends[:, 1], *(t.sum(axis=1) - ends.sum(axis=1) for t in (one, other))))
    off, most = _sizes(body, d, u, v)
    bound = 200.0 * most**3 * off + 2.0**-44 * most**4 + 1e-300
    found[edges[np.einsum("nd,nd->n", np.cross(d, u), np.cross(d, v)) < -bound]] = True
    return found


def _neighbours(body: Polyhedron) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(segments (n,), corners (n, 3) of one of its triangles, and of the next one)."""
    rows, ordered = _rows_of(body, _AT_EDGES, body.side_edge)
    twice = np.flatnonzero((ordered[1:] == ordered[:-1]) & (ordered[1:] >= 0))  # not of diagonals
    return ordered[twice], body.triangles[rows[twice]], body.triangles[rows[twice + 1]]


def _sizes(body: Polyhedron, *vectors: np.ndarray) -> tuple[float, np.ndarray]:
    """(how far differences of vertices may be off, (n,) the largest entry of those vectors (n, ...), that far off)."""
    off = 2.0 * body.error + 2.0**-51 * float(np.abs(body.vertices).max())
    return off, np.max([np.abs(x).reshape(len(x), -1).max(axis=1) for x in vectors], axis=0) + off


def spanning(points: Sequence[Vector]) -> list[int]:
    """Which corners span a triangle: all, the ends of its longest side where it has no area, one where all are one."""
    if any(_cross_of(*points)):
        return [0, 1, 2]
    square = {side: sum((x - y) ** 2 for x, y in zip(*(points[k] for k in side), strict=True)) for side in _SIDES}
    longest = max(_SIDES, key=lambda side: square[side])
    return list(longest) if square[longest] else [0]


def has_area(body: Polyhedron, k: int) -> bool:
    return any(_cross_of(*(body.exact_vertex(i) for i in body.triangles[k].tolist())))


def longest_side(body: Polyhedron, k: int) -> int | None:
    """The segment that a triangle without area is; None for one that is a point."""
    spanned = spanning([body.exact_vertex(i) for i in body.triangles[k].tolist()])
    return int(body.side_edge[k, _SIDES.index((spanned[0], spanned[1]))]) if len(spanned) > 1 else None


def prisms(points: Sequence[Vector]) -> list[CompositeQuadric]:
    """The two solids between a triangle and its shift by its size to either side; none where it has no area."""
    n = _cross_of(*points)
    sides = [tuple(p + sign * c for p, c in zip(points[0], n, strict=True)) for sign in (1, -1)]
    return [_prism(points, toward) for toward in sides] if any(n) else []


def _prism(points: Sequence[Vector], toward: Vector) -> CompositeQuadric:
    """The solid on the other side of a triangle than `toward`."""
    forms = triangle_forms(points, toward)
    assert forms is not None
    plane = forms[0]
    n = plane.normal[:3]
    size = max(abs(x - y) for p in points for x, y in zip(p, points[0], strict=True))
    depth = size * max(abs(x) for x in n)  # of the form, so about a size in space
    floor = Plane(primitive((*(-x for x in n), -plane.normal[3] - depth)))
    surfaces: list[Surface] = [plane, floor, *forms[1:]]
    step = depth / dot(n, n) / 2
    middle = tuple(sum((p[k] for p in points), ZERO) / 3 - step * n[k] for k in range(3))
    ends = [*points, *(tuple(p[k] - 2 * step * n[k] for k in range(3)) for p in points)]
    box = tuple(tuple(f(p[k] for p in ends) for k in range(3)) for f in (min, max))
    tree = conjunction([Leaf(i) for i in range(len(surfaces))])
    return CompositeQuadric(surfaces, tree, box=box, witness=middle)  # type: ignore[arg-type]
