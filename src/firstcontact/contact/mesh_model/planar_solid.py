"""A solid of planes as a polyhedron, exact, with its elements known by its own.

A face's border is the rings of its edges.  Triangles that all look the face's way, decided in rational numbers, and
whose border these rings are, fill the face and nothing else: no two sets of triangles in a plane have one border.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from itertools import pairwise

from flint import fmpq

from firstcontact.body.kept import Kept
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.carriers import Line, Plane, Point
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.features import Edge, Face, Vertex
from firstcontact.errors import InputError
from firstcontact.exact.numbers import fraction
from firstcontact.exact.vectors import Vector, cross, dot, sub
from firstcontact.result import Element

MOST_VERTICES = 2000
"""Of a solid that is looked at as a polyhedron."""

Ring = list[int]
_PLANAR = Kept["PlanarSolid | None"]()


@dataclass(frozen=True)
class PlanarSolid:
    """A solid of planes and the polyhedron that is the same body, with its vertices by the same numbers.

    face_of: of each polygon the number of the solid's face; edge_of: of two vertices, ascending, that of its edge.
    """

    model: CompositeQuadric
    polyhedron: Polyhedron
    face_of: tuple[int, ...]
    edge_of: dict[tuple[int, int], int]

    def own(self, element: Element) -> Face | Edge | Vertex:
        """What an element of the polyhedron is of the solid."""
        if element.kind == "vertex":
            return self.model.vertices[element.index]
        if element.kind == "face":
            return self.model.faces[self.face_of[element.index]]
        i, j = sorted(self.polyhedron.edges[element.index].tolist())
        return self.model.edges[self.edge_of[i, j]]


def planar(model: CompositeQuadric) -> PlanarSolid | None:
    """Kept on the model; None of others than bounded solids of planes, where edges are those of two faces each."""
    return _PLANAR.of(model, lambda: _planar(model))


def _planar(model: CompositeQuadric) -> PlanarSolid | None:
    if not model.bounded or model.whole is not None or not all(isinstance(x, Plane) for x in model.surfaces):
        return None
    if len(model.vertices) > MOST_VERTICES or model.seams:
        return None
    points = [_point(x) for x in model.vertices]
    sides, edge_of = _sides(model)
    if sides is None or None in points:
        return None
    corners = [x for x in points if x is not None]
    polygons: list[list[Ring]] = []
    face_of: list[int] = []
    normals = [_normal(face) for face in model.faces]
    for face in model.faces:
        rings = _rings(sides[face.index])
        if rings is None:
            return None
        own = _polygons(rings, corners, normals[face.index])
        polygons += own
        face_of += [face.index] * len(own)
    try:
        places = [[fraction(c) for c in p] for p in corners]
        polyhedron = Polyhedron(places, polygons, name=model.name)
    except InputError:  # rounded corners, which triangles are cut by, do not tell the polygons
        return None
    looks = zip(polyhedron.triangles.tolist(), polyhedron.triangle_face.tolist(), strict=True)
    if not polyhedron.solid or any(_turn([corners[i] for i in t], normals[face_of[f]]) <= 0 for t, f in looks):
        return None
    return PlanarSolid(model, polyhedron, tuple(face_of), edge_of)


def _point(vertex: Vertex) -> Vector | None:
    if not isinstance(vertex.carrier, Point):
        return None
    (x,), (y,), (z,), (w,) = vertex.carrier.basis
    return x / w, y / w, z / w


def _normal(face: Face) -> Vector:
    assert isinstance(face.carrier, Plane)
    x, y, z, _ = face.carrier.normal
    return x, y, z


def _sides(model: CompositeQuadric) -> tuple[dict[int, list[tuple[int, int]]] | None, dict[tuple[int, int], int]]:
    """The sides of each face, and the edge of each side; None where an edge has not two faces or ends nowhere."""
    sides: dict[int, list[tuple[int, int]]] = defaultdict(list)
    edge_of: dict[tuple[int, int], int] = {}
    for edge in model.edges:
        if len(set(edge.faces)) != 2 or not isinstance(edge.carrier, Line):
            return None, {}
        for piece in edge.pieces:
            if piece.start is None or piece.end is None:
                return None, {}
            side = min(piece.start, piece.end), max(piece.start, piece.end)
            if side in edge_of:
                return None, {}
            edge_of[side] = edge.index
            for face in edge.faces:
                sides[face].append(side)
    return sides, edge_of


def _rings(sides: list[tuple[int, int]]) -> list[Ring] | None:
    """The sides in rings; None where more than two of them meet."""
    beside: dict[int, list[int]] = defaultdict(list)
    for i, j in sides:
        beside[i].append(j)
        beside[j].append(i)
    if any(len(x) != 2 for x in beside.values()):
        return None
    rings, left = [], set(beside)
    while left:
        ring = [min(left)]
        left.discard(ring[0])
        while ahead := [k for k in beside[ring[-1]] if k in left]:
            ring.append(ahead[0])
            left.discard(ahead[0])
        rings.append(ring)
    return rings


def _polygons(rings: list[Ring], points: list[Vector], normal: Vector) -> list[list[Ring]]:
    """Each ring that is within an even number of others with the rings next within it, its holes; outer ones look along
    the normal."""
    held = [[j for j, other in enumerate(rings) if j != k and _holds(other, points[ring[0]], points, normal)]
            for k, ring in enumerate(rings)]  # fmt: skip
    polygons = []
    for k, ring in enumerate(rings):
        if len(held[k]) % 2 == 0:
            outer = ring if _turn([points[i] for i in ring], normal) > 0 else ring[::-1]
            holes = [other for j, other in enumerate(rings) if k in held[j] and len(held[j]) == len(held[k]) + 1]
            polygons.append([outer, *holes])
    return polygons


def _turn(corners: list[Vector], normal: Vector) -> fmpq:
    """Twice the area of a plane polygon, seen against the normal, times its length."""
    first = corners[0]
    spokes = [sub(p, first) for p in corners[1:]]
    return sum((dot(normal, cross(p, q)) for p, q in pairwise(spokes)), fmpq(0))


def _holds(ring: Ring, point: Vector, points: list[Vector], normal: Vector) -> bool:
    """Whether the point, which is not on it, is within the ring: seen along an axis, by a ray along another one."""
    axis = next(k for k in range(3) if normal[k])
    x, y = (axis + 1) % 3, (axis + 2) % 3
    crossed = False
    for i, j in zip(ring, ring[1:] + ring[:1], strict=True):
        p, q = points[i], points[j]
        if (p[y] > point[y]) != (q[y] > point[y]):
            at = p[x] + (point[y] - p[y]) / (q[y] - p[y]) * (q[x] - p[x])
            crossed ^= at > point[x]
    return crossed
