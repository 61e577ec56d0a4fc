"""The first new contact of polyhedra that touch at the start, by their triangles.

Let F, G be what the two have of one plane that the motion keeps, or off which they part, and in which they touch, with
the bodies on different sides. A triangle of a that lies on a's side and meets the plane within F, and one of b that
does so with G, share points of F and G alone, at all times: an old contact. All other pairs of triangles that share no
point at the start are searched for their first contact; those that part at once, for their next one; those that meet on
the axis of a rotation, which stays as it is, for one beside it. Before the earliest of these times all contacts are
old. Nor do the bodies overlap before it: where they begin to, triangles cross along a curve, and where that is in F and
G, the bodies are on different sides.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.assembly.kept import generators, parting, standing
from firstcontact.assembly.lifts import lifted_until
from firstcontact.assembly.new_contact import Lasts, NewContactQuery, after_start, earliest, renamed
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.carriers import Plane, Rows, doubles, upright
from firstcontact.exact.numbers import fraction, sign
from firstcontact.exact.vectors import Vector, along, cross, dot, sub
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.rotation import Rotation, sense_about
from firstcontact.result import Element, FirstContact
from firstcontact.search.trees.containment import contains
from firstcontact.search.trees.frame import tree_of

if TYPE_CHECKING:
    from fractions import Fraction

    from flint import fmpq

    from firstcontact.body.kinds import Body

MOST_PAIRS = 400
"""Pairs of triangles that are looked at one by one; more take too long."""
ROUNDING = 1e-12
"""Of the coordinates: how far doubles may have points of a plane from it."""


def by_faces(a: Body, b: Body, asking: NewContactQuery) -> FirstContact | None:
    """None for other bodies, and where too many triangles touch.  Raises Lasts."""
    if not all(isinstance(shape_of(x), Polyhedron) and len(shape_of(x).triangles) for x in (a, b)):
        return None
    stands = [standing(x, asking.first) for x in (a, b)]
    by = None if stands[0] is None or stands[1] is None else generators(a, b, asking.first, asking.last)
    sides = Mesh(a, stands[0]), Mesh(b, stands[1])
    met = _met_at_start(sides, asking)
    if met is None:
        return None
    stars = _stars(sides, met, by)
    alone = {pair for pair in met if not any(pair[0] in x and pair[1] in y for x, y in stars)}
    if len(alone) > MOST_PAIRS:
        return None
    found: list[FirstContact] = []
    for x, y in sorted(alone):
        found += _after_start(sides[0].part([x]), sides[1].part([y]), asking)
        if any(map(asking.is_open, found)):
            return earliest(found, asking)  # whatever the others are
    return earliest([*found, *_apart_at_start(sides, stars, alone, asking)], asking)


class Mesh:
    """A polyhedron as the answer looks at it: triangles by numbers, exactly, where it stands at the start."""

    def __init__(self, body: Any, stands: Any, face: int | None = None) -> None:
        """stands: the shape there, None where that is not known; face: of which the triangles are pieces, if any."""
        self.body, self.shape, self.face = body, shape_of(body), face
        self.stands = self.shape if stands is None else stands
        self.is_in_place = self.stands is self.shape
        self.is_known = stands is not None
        self.triangles: np.ndarray = self.shape.triangles
        self._exact: dict[int, Vector] = {}
        self._planes: dict[int, Plane | None] = {}
        self._facets: dict[Plane, list[tuple[frozenset[int], int]]] = {}

    def point(self, vertex: int) -> Vector:
        if vertex not in self._exact:
            self._exact[vertex] = self.stands.exact_vertex(vertex)
        return self._exact[vertex]

    def corners(self, triangle: int) -> list[int]:
        corners: list[int] = self.triangles[triangle].tolist()
        return corners

    def plane(self, triangle: int) -> Plane | None:
        """By coprime integers, alike for all triangles in it; None of a triangle without area."""
        if triangle not in self._planes:
            p, q, r = map(self.point, self.corners(triangle))
            n = cross(sub(q, p), sub(r, p))
            self._planes[triangle] = Plane(upright((*n, -dot(n, p)))) if any(n) else None
        return self._planes[triangle]

    def all_planes(self) -> list[Plane]:
        """Those of all triangles with an area, each once."""
        return list(dict.fromkeys(x for x in map(self.plane, range(len(self.triangles))) if x is not None))

    @cached_property
    def _around(self) -> dict[tuple[int, int], list[int]]:
        """The triangles along each edge, by its vertices."""
        around = defaultdict(list)
        for k, corners in enumerate(self.triangles.tolist()):
            for edge in _edges(corners):
                around[edge].append(k)
        return around

    def facets(self, plane: Plane) -> list[tuple[frozenset[int], int]]:
        """The triangles in the plane, those together that hang together by edges of two triangles.

        And the sign of the plane's form on the body's side of each facet; 0 where it has no inside.
        """
        if plane not in self._facets:
            near = np.flatnonzero(self._near(plane)[self.triangles].all(axis=1))
            left = {k for k in near.tolist() if self.plane(k) == plane}
            found = []
            while left:
                facet = self._hanging_together(min(left), left)
                left -= facet
                found.append((facet, self._inner_side(min(facet), plane)))
            self._facets[plane] = found
        return self._facets[plane]

    def within(self, plane: Plane, side: int) -> frozenset[int]:
        """The triangles of all facets in the plane that look away from that side of it, or have no inside."""
        return frozenset().union(*(facet for facet, inner in self.facets(plane) if inner in (side, 0)))

    def _near(self, plane: Plane) -> np.ndarray:
        """(n,) bools: vertices that may lie in the plane."""
        normal = np.array(doubles((plane.normal,))[0])
        length = float(np.linalg.norm(normal[:3]))
        heights = np.abs(self.stands.vertices @ normal[:3] + normal[3]) / length
        size = float(np.abs(self.stands.vertices).max()) + abs(float(normal[3])) / length
        near: np.ndarray = heights <= ROUNDING * size + 2.0 * self.stands.error
        return near

    def _on(self, plane: Plane) -> set[int]:
        """Vertices in the plane."""
        return {v for v in np.flatnonzero(self._near(plane)).tolist() if plane.value((*self.point(v), 1)) == 0}

    def _hanging_together(self, triangle: int, among: set[int]) -> frozenset[int]:
        facet, waiting = {triangle}, [triangle]
        while waiting:
            for edge in _edges(self.corners(waiting.pop())):
                beside = self._around[edge]
                new = [k for k in beside if k in among and k not in facet and len(beside) == 2]
                facet.update(new)
                waiting += new
        return frozenset(facet)

    def _inner_side(self, triangle: int, plane: Plane) -> int:
        if not self.stands.solid:
            return 0
        centre = [(x + 2 * y + 4 * z) / 7 for x, y, z in zip(*map(self.point, self.corners(triangle)), strict=True)]
        axis = next(k for k in range(3) if plane.normal[k])
        ahead = contains(self.stands, tree_of(self.stands), tuple(centre), axis, (triangle,))
        return sign(plane.normal[axis]) * (1 if ahead else -1)

    def side(self, triangle: int, plane: Plane) -> int | None:
        """The sign of the plane's form on the triangle, or inside of one in it; 0 where it has no inside.

        None of a triangle on both sides.
        """
        heights = {sign(plane.value((*self.point(v), 1))) for v in self.corners(triangle)}
        if heights == {0}:
            return next((inner for facet, inner in self.facets(plane) if triangle in facet), None)
        return None if {-1, 1} <= heights else max(heights, key=abs)

    def star(self, plane: Plane, side: int) -> frozenset[int]:
        """The triangles on that side of the plane that meet it within its facets, and somewhere.

        Of a body without one there, in corners and edges.
        """
        facet = self.within(plane, side)
        on = self._on(plane) if not facet else {v for k in facet for v in self.corners(k)}
        edges = {edge for k in facet for edge in _edges(self.corners(k))}
        near = np.flatnonzero(np.isin(self.triangles, list(on)).any(axis=1))
        if not facet:
            edges = {edge for k in near.tolist() for edge in _edges(self.corners(k)) if on.issuperset(edge)}
        return facet | {k for k in near.tolist() if self._is_within(k, on, edges, plane, side)}

    def _is_within(
        self, triangle: int, vertices: set[int], edges: set[tuple[int, int]], plane: Plane, side: int
    ) -> bool:
        corners = self.corners(triangle)
        heights = [side * sign(plane.value((*self.point(v), 1))) for v in corners]
        on = [v for v, height in zip(corners, heights, strict=True) if height == 0]
        if min(heights) < 0 or len(on) == 3:
            return False
        return set(on) <= vertices if len(on) == 1 else _edge(*on) in edges

    def part(self, triangles: Iterable[int]) -> MeshPart:
        """These triangles as a surface that moves as the body does."""
        chosen = np.array(sorted(triangles))
        vertices, faces = np.unique(self.triangles[chosen], return_inverse=True)
        return self._part(vertices, faces.reshape(-1, 3), [], chosen)

    def points(self, vertices: Sequence[int]) -> MeshPart:
        return self._part(np.array(vertices), [], None, np.empty(0, int))

    def rods(self, edges: Sequence[tuple[int, int]]) -> MeshPart:
        vertices, ends = np.unique(np.array(edges), return_inverse=True)
        return self._part(vertices, [], ends.reshape(-1, 2), np.empty(0, int))

    def _part(
        self, vertices: np.ndarray, faces: Sequence[Sequence[int]] | np.ndarray,
        edges: Sequence[Sequence[int]] | np.ndarray | None, triangles: np.ndarray,
    ) -> MeshPart:  # fmt: skip
        shape = self.shape
        if shape.error == 0.0:
            places: Any = shape.vertices[vertices]
        else:
            places = [[fraction(x) for x in shape.exact_vertex(v)] for v in vertices.tolist()]
        body: Any = Polyhedron(places, faces, edges=edges if len(faces) == 0 else None, solid=False, name=shape.name)
        moving = Moving(body, self.body.motion) if isinstance(self.body, Moving) else body
        return MeshPart(self, moving, vertices, triangles)


@dataclass(frozen=True)
class MeshPart:
    """Some elements of a mesh as a body; vertices, triangles: their numbers in the mesh."""

    mesh: Mesh
    body: Any
    vertices: np.ndarray
    triangles: np.ndarray

    def element(self, element: Element) -> Element:
        """What users call an element of the part."""
        shape, own = self.mesh.shape, shape_of(self.body)
        if self.mesh.face is not None:
            return replace(element, kind="face", index=self.mesh.face)
        if element.kind == "vertex":
            return replace(element, index=int(self.vertices[element.index]))
        if element.kind == "face":
            return replace(element, index=int(shape.triangle_face[self.triangles[element.index]]))
        ends = _edge(*self.vertices[own.edges[element.index]].tolist())
        index = np.flatnonzero((np.sort(shape.edges, axis=1) == ends).all(axis=1))
        if len(index):
            return replace(element, index=int(index[0]))
        return replace(element, kind="face", index=int(shape.triangle_face[self.mesh._around[ends][0]]))  # a diagonal


def _edge(p: int, q: int) -> tuple[int, int]:
    return (p, q) if p < q else (q, p)


def _edges(corners: Sequence[int]) -> Iterator[tuple[int, int]]:
    p, q, r = corners
    return iter((_edge(p, q), _edge(q, r), _edge(r, p)))


def _met_at_start(sides: tuple[Mesh, Mesh], asking: NewContactQuery) -> set[tuple[int, int]] | None:
    """Pairs of triangles, among them all that share a point at the start; None of sheets that pierce each other."""
    found = asking.pairs_at_start(sides[0].body, sides[1].body)
    if len(found.piercing) and not (sides[0].shape.solid or sides[1].shape.solid):
        return None
    met: set[tuple[int, int]] = set()
    for pair in (*found.pairs, *found.piercing, *found.undecided):
        met.update(product(_holding(sides[0], pair.element_a), _holding(sides[1], pair.element_b)))
    return met


def _holding(mesh: Mesh, element: Element) -> list[int]:
    """The triangles of the element, or around it."""
    if element.kind == "face":
        return np.flatnonzero(mesh.shape.triangle_face == element.index).tolist()
    if element.kind == "edge":
        return mesh._around[_edge(*mesh.shape.edges[element.index].tolist())]
    return np.flatnonzero((mesh.triangles == element.index).any(axis=1)).tolist()


Star = tuple[frozenset[int], frozenset[int]]
"""Triangles of a and of b whose pairs share old contacts alone."""


def _stars(sides: tuple[Mesh, Mesh], met: set[tuple[int, int]], by: list[Rows] | None) -> list[Star]:
    if by is None:
        return []
    stars: dict[tuple[Plane, int], Star] = {}
    for pair in sorted(met):
        for plane in dict.fromkeys(mesh.plane(x) for mesh, x in zip(sides, pair, strict=True)):
            if plane is None or (off := parting(plane, by)) is None:
                continue
            own, other = (mesh.side(x, plane) for mesh, x in zip(sides, pair, strict=True))
            if own is None or own == other or other is None:  # across it, on the same side, or both without an inside
                continue
            side = own or -other
            if off in (0, side) and (plane, side) not in stars:
                stars[plane, side] = sides[0].star(plane, side), sides[1].star(plane, -side)
    return list(stars.values())


def _apart_at_start(
    sides: tuple[Mesh, Mesh], stars: list[Star], alone: set[tuple[int, int]], asking: NewContactQuery
) -> Iterator[FirstContact]:
    """First contacts of all pairs of triangles that are neither in one star nor alone."""
    partners = defaultdict(set)
    for x, y in alone:
        partners[x].add(y)
    groups: dict[frozenset[int], list[int]] = defaultdict(list)
    for x in range(len(sides[0].triangles)):
        left_out = partners[x].union(*(star[1] for star in stars if x in star[0]))
        groups[frozenset(left_out)].append(x)
    everything = set(range(len(sides[1].triangles)))
    for known, group in groups.items():
        if others := everything - known:
            part, other = sides[0].part(group), sides[1].part(others)
            yield renamed(asking.first_contact(part.body, other.body), part.element, other.element)


def _after_start(x: MeshPart, y: MeshPart, asking: NewContactQuery) -> list[FirstContact]:
    """New contacts of two triangles that may touch at the start.  Raises Lasts."""
    off = _lifted_until(x, y, asking)
    if off is not None:
        return [renamed(asking.first_contact(x.body, y.body, off), x.element, y.element)]
    try:
        return [renamed(after_start(x.body, y.body, asking), x.element, y.element)]
    except Lasts:
        axis = _axis(x.mesh.body, y.mesh.body)
        if axis is None or not (x.mesh.is_in_place and y.mesh.is_in_place):
            raise
    pieces = product(_cut_along(x, axis), _cut_along(y, axis))
    pairs = [pair for piece in pieces for pair in _beside_axis(*piece, axis)]
    return [renamed(after_start(p.body, q.body, asking), p.element, q.element) for p, q in pairs]


def _lifted_until(x: MeshPart, y: MeshPart, asking: NewContactQuery) -> Fraction | None:
    """A time until which two triangles are off each other, as one turns off the plane of one of them."""
    if not (x.mesh.is_known and y.mesh.is_known):
        return None
    pairs = [(part.mesh, int(part.triangles[0])) for part in (x, y)]
    below, above = ([mesh.point(v) for v in mesh.corners(k)] for mesh, k in pairs)
    own = [plane for mesh, k in pairs if (plane := mesh.plane(k)) is not None]

    def separates(plane: Plane) -> bool:
        return all(plane.value((*p, 1)) <= 0 for p in below) and all(plane.value((*p, 1)) >= 0 for p in above)

    sides = [side for plane in own for side in (plane, plane.negated())]
    off = lifted_until((x.body, y.body), (lambda: below, lambda: above), sides, separates, asking.first, asking.last)
    return None if off is None else fraction(off)


def _axis(a: Body, b: Body) -> Rotation | None:
    """A rotation about the line about which they turn, if at most one of them rests."""
    motions = [x.motion for x in (a, b) if isinstance(x, Moving)]
    turns = [x for x in motions if isinstance(x, Rotation)]
    if not turns or len(turns) != len(motions) or not all(sense_about(turns[0], x) for x in turns):
        return None
    return turns[0]


def _cut_along(part: MeshPart, axis: Rotation) -> list[MeshPart]:
    """The triangle, in pieces that meet the axis at corners alone.  Raises Lasts where it does not meet it."""
    mesh, (triangle,) = part.mesh, part.triangles.tolist()
    plane, corners = mesh.plane(triangle), [mesh.point(v) for v in mesh.corners(triangle)]
    if plane is None:
        raise Lasts
    pieces = _halves(corners, plane, axis) if _holds(plane, axis) else _fan(corners, plane, axis)
    if len(pieces) == 1:
        return [part]
    places = [[fraction(x) for x in p] for piece in pieces for p in piece]
    faces = [[k, k + 1, k + 2] for k in range(0, len(places), 3)]
    shape: Any = Polyhedron(places, faces, solid=False, name=mesh.shape.name)
    moving = Moving(shape, mesh.body.motion) if isinstance(mesh.body, Moving) else shape
    cut = Mesh(moving, shape, int(mesh.shape.triangle_face[triangle]))
    return [cut.part([k]) for k in range(len(faces))]


def _halves(corners: list[Vector], plane: Plane, axis: Rotation) -> list[list[Vector]]:
    """Triangles on either side of the axis, which lies in the plane."""
    beside = [dot(plane.normal, cross(sub(p, axis.point), axis.axis)) for p in corners]
    if min(beside) < 0 < max(beside):
        sides = [_clipped(corners, beside, side) for side in (1, -1)]
        return [[side[0], side[k], side[k + 1]] for side in sides for k in range(1, len(side) - 1)]
    if 0 not in beside:
        raise Lasts
    return [corners]


def _fan(corners: list[Vector], plane: Plane, axis: Rotation) -> list[list[Vector]]:
    """Triangles around the point where the axis passes through the plane."""
    steep = dot(plane.normal, axis.axis)
    if steep == 0:
        raise Lasts
    through = along(axis.point, -plane.value((*axis.point, 1)) / steep, axis.axis)
    turns = [dot(plane.normal, cross(sub(q, p), sub(through, p))) for p, q in _sides(corners)]
    if min(turns) < 0 < max(turns):
        raise Lasts
    return [[through, p, q] for (p, q), turn in zip(_sides(corners), turns, strict=True) if turn != 0]


def _sides(corners: Sequence[Vector]) -> list[tuple[Vector, Vector]]:
    p, q, r = corners
    return [(p, q), (q, r), (r, p)]


def _holds(plane: Plane, axis: Rotation) -> bool:
    return dot(plane.normal, axis.axis) == 0 and plane.value((*axis.point, 1)) == 0


def _is_on(point: Vector, axis: Rotation) -> bool:
    return not any(cross(sub(point, axis.point), axis.axis))


def _clipped(corners: Sequence[Vector], beside: Sequence[fmpq], side: int) -> list[Vector]:
    """The corners of what lies on one side of the axis."""
    kept: list[Vector] = []
    for k, (p, height) in enumerate(zip(corners, beside, strict=True)):
        q, other = corners[k - 1], beside[k - 1]
        if height * other < 0:
            kept.append(along(q, other / (other - height), sub(p, q)))
        if side * height >= 0:
            kept.append(p)
    return kept


def _beside_axis(x: MeshPart, y: MeshPart, axis: Rotation) -> Iterator[tuple[MeshPart, MeshPart]]:
    """Parts of two triangles that meet where these begin to meet beside the axis.

    Two edges from one point of the axis meet beside it no sooner than the end of one of them meets the other one.
    """
    on = [{v for v in part.mesh.corners(int(part.triangles[0])) if _is_on(part.mesh.point(v), axis)}
          for part in (x, y)]  # fmt: skip
    edges = []
    for part, own in zip((x, y), on, strict=True):
        corners = part.mesh.corners(int(part.triangles[0]))
        loose = part.mesh.points([v for v in corners if v not in own])
        yield (loose, y) if part is x else (x, loose)
        edges.append([edge for edge in _edges(corners) if not set(edge) <= own])
    for p, q in product(*edges):
        if not ({x.mesh.point(v) for v in on[0] & set(p)} & {y.mesh.point(v) for v in on[1] & set(q)}):
            yield x.mesh.rods([p]), y.mesh.rods([q])
