"""The curve of one ruled piece with a planar facet of a polyhedron of any shape, trimmed to the polygon exactly.

A facet is all triangles that hang together in one plane.  Its curve is cut by the planes of the facets beyond its
edges, so that whatever starts on an edge in either facet is a place of both; diagonals are cut by planes across.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq

from firstcontact.body.kept import Kept
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.carriers import Plane, Vector, dot, primitive
from firstcontact.contact.signs.pieces import RulingPiece
from firstcontact.curves.certified.cover import Cover
from firstcontact.curves.exactly.branches import Joints
from firstcontact.curves.with_solids.solid_curve import SheetCurve, sign_at
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import to_double
from firstcontact.exact.vectors import cross

if TYPE_CHECKING:
    from typing import Unpack

    from firstcontact.curves.exactly.spots import Box
    from firstcontact.curves.with_solids.solid_curve import Joining
    from firstcontact.exact.curves.plane_curves import Node, PlaneEdge


@dataclass(frozen=True)
class Facet:
    """Triangles of one plane.

    surfaces   its plane, then those through sides of triangles
    triangles  three (number in surfaces, sign of that on the triangle) each
    edges      the numbers in surfaces that are edges of the polyhedron and no diagonals
    borders    the numbers of the edges beyond which there is no other face, by the number in surfaces
    """

    who: str
    face: int
    surfaces: tuple[Plane, ...]
    triangles: tuple[tuple[tuple[int, int], ...], ...]
    edges: frozenset[int]
    borders: dict[int, int]


class Facets:
    """Those of a polyhedron with rational vertices, made where they are asked for."""

    def __init__(self, body: Polyhedron) -> None:
        self.body, self.who = body, body.name or "the polyhedron"
        corners = body.vertices[body.triangles]
        self.low, self.high = corners.min(1) - body.error, corners.max(1) + body.error
        self.at: dict[int, list[int]] = defaultdict(list)
        """Triangles by the segment along a side."""
        for k, sides in enumerate(body.side_edge.tolist()):
            for e in sides:
                self.at[e].append(k)
        self._points: dict[int, Vector] = {}
        self._planes: dict[int, Plane | None] = {}

    def near(self, cover: Cover) -> Iterator[Facet]:
        """The facets, without triangles that the piece of the cover certainly does not meet."""
        left = {k for k in cover.near(self.low, self.high).tolist() if self._may_meet(k, cover)}
        while left:
            waiting, group = [min(left)], []
            left.remove(waiting[0])
            while waiting:
                k = waiting.pop()
                group.append(k)
                beside = {j for e in self.body.side_edge[k].tolist() for j in self.at[e] if j in left}
                fresh = {j for j in beside if self._coplanar(j, k)}
                left -= fresh
                waiting += sorted(fresh)
            yield self._facet(sorted(group))

    def _point(self, i: int) -> Vector:
        if i not in self._points:
            self._points[i] = self.body.exact_vertex(i)
        return self._points[i]

    def _plane(self, k: int) -> Plane | None:
        """That of a triangle; None where it has no area."""
        if k not in self._planes:
            a, b, c = (self._point(i) for i in self.body.triangles[k].tolist())
            n = cross(_way(a, b), _way(a, c))
            self._planes[k] = Plane(primitive((*n, -dot(n, a)))) if any(n) else None
        return self._planes[k]

    def _may_meet(self, k: int, cover: Cover) -> bool:
        plane = self._plane(k)
        if plane is None:
            return False
        size = max(abs(c) for c in plane.normal[:3])
        return cover.may_cross(np.array([to_double(c / size) for c in plane.normal]), self.low[k], self.high[k])

    def _coplanar(self, j: int, k: int) -> bool:
        a, b = self._plane(j), self._plane(k)
        return a is not None and b is not None and (a == b or a.normal == tuple(-c for c in b.normal))

    def _facet(self, group: list[int]) -> Facet:
        plane = self._plane(group[0])
        assert plane is not None
        surfaces: dict[Plane, int] = {plane: 0}
        triangles, edges, borders = [], set(), {}
        for k in group:
            corners = self.body.triangles[k].tolist()
            signs = []
            for e in self.body.side_edge[k].tolist():
                others = [j for j in self.at[e] if j != k and self._plane(j) is not None]
                beyond = [j for j in others if not self._coplanar(j, k)]
                cut = self._plane(beyond[0]) if beyond else self._across(plane, e)
                assert cut is not None
                number = surfaces.setdefault(cut, len(surfaces))
                ends = self.body.segments[e].tolist()
                value = cut.value((*self._point(next(i for i in corners if i not in ends)), fmpq(1)))
                signs.append((number, 1 if value > 0 else -1))
                if beyond or not others:
                    edges.add(number)
                if not others:
                    borders[number] = e
            triangles.append(tuple(signs))
        face = int(min(self.body.triangle_face[k] for k in group))
        return Facet(self.who, face, tuple(surfaces), tuple(triangles), frozenset(edges), borders)

    def _across(self, plane: Plane, e: int) -> Plane:
        """The plane through a segment at right angles to that of its facet."""
        a, b = (self._point(i) for i in self.body.segments[e].tolist())
        n = cross(_way(a, b), plane.normal[:3])
        return Plane(primitive((*n, -dot(n, a))))


_FACETS = Kept[dict[str | None, Facets]]()


def facets(body: Polyhedron) -> Facets:
    """Kept on the body; UnsupportedPair where it has no faces or no rational vertices."""
    who = body.name or "the polyhedron"
    if not len(body.triangles):
        raise UnsupportedPair(f"{who} has no faces; intersection_curve is with faces of polyhedra")
    if body.irrational_pose is not None:
        raise UnsupportedPair(f"{who} is in an irrational pose, in which intersection_curve does not take polyhedra")
    known = _FACETS.of(body, dict)
    if body.name not in known:
        known[body.name] = Facets(body)
    return known[body.name]


def _way(a: Vector, b: Vector) -> Vector:
    return tuple(y - x for x, y in zip(a, b, strict=True))


class FacetCurve(SheetCurve):
    """joining: as `knots` and `joins` of SheetCurve."""

    def __init__(
        self, piece: RulingPiece, facet: Facet, tolerance: float, box: Box | None, first: bool,
        **joining: Unpack[Joining],
    ) -> None:  # fmt: skip
        super().__init__(piece, facet.surfaces, 1, tolerance, box, first, **joining)
        self.facet = facet
        self.clip.marks += [(f"edge {e}", self.forms[k], self.sheet.degree) for k, e in facet.borders.items()]

    def lies_in_surface(self) -> None:
        raise UnsupportedPair(f"{self.facet.who}: the ruled piece lies in the plane of face {self.facet.face}")

    def is_part(self, where: Node | PlaneEdge, joints: Joints) -> bool:
        signs: dict[int, int] = {}

        def holds(number: int, own: int) -> bool:
            if number not in signs:
                signs[number] = sign_at(self.forms[number], where)
            return signs[number] * own >= 0

        return any(all(holds(*side) for side in triangle) for triangle in self.facet.triangles)

    def is_stop(self, node: Node) -> bool:
        return super().is_stop(node) or any(sign_at(self.forms[k], node) == 0 for k in self.facet.edges)
