"""A start in contact: do the bodies touch, or do they share interior points?  Exact.

An edge that passes through the inside of a facet settles it.  Otherwise the bodies overlap iff a whole component
of one lies inside the other, or at some vertex of the shared set the two tangent cones have a common interior
direction; the cones are unions of cells of the arrangement of the facets' planes there, so one direction per
cell is enough.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, combinations

import numpy as np
from flint import fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.earliest import Found, Pair, Searched, earliest, pairs_at_start
from firstcontact.exact.numbers import Undecidable, sign, to_double
from firstcontact.exact.vectors import Vector, add, along, cross, dot, scaled, sub
from firstcontact.pairs.elements import point_line
from firstcontact.pairs.elements.line_line import segments_meet
from firstcontact.pairs.elements.point_plane import in_triangle
from firstcontact.pairs.elements.segment_facet import APART, relation
from firstcontact.search.trees.containment import component_labels, component_vertices, contains
from firstcontact.search.trees.elements import EDGE, FACE, VERTEX, Feature, corners_of
from firstcontact.search.trees.frame import tree_of

# Separating planes are sought among this many facets and edge pairs in contact before looking at every point.
PLANES_TRIED = 12


def initial_kind(problem: Searched, found: Found) -> str:
    """ "touching" or "overlapping", for bodies whose surfaces share a point at the start.

    Overlapping: some point of one lies in the interior of the other, which is a solid.
    Raises Undecidable in irrational poses.
    """
    a, b = problem.a, problem.b
    if not (a.solid or b.solid):
        return "touching"
    if any(crossing for _, crossing in found.start):
        return "overlapping"
    pairs = pairs_at_start(problem)
    if any(crossing for _, crossing in pairs):
        return "overlapping"
    if a._pose is not None or b._pose is not None:
        # what follows asks whether numbers are equal: no question for balls
        from firstcontact.contact.polyhedra.standstill import Standstill  # loads the walk of rotations

        if not isinstance(problem, Standstill):
            raise Undecidable
        nearby = problem.soon()
        return initial_kind(nearby, earliest(nearby))
    touching = [pair for pair, _ in pairs] or found.pairs
    if _separated(a, b, touching):
        return "touching"
    if _component_inside(a, b, [p[1] for p in touching]) or _component_inside(b, a, [p[2] for p in touching]):
        return "overlapping"
    shared = {x for pair in touching for x in _shared_vertices(a, b, pair)}
    return "overlapping" if any(_cones_overlap(a, b, x) for x in sorted(shared, key=_key)) else "touching"


def _key(x: Vector) -> tuple[float, float, float]:
    return to_double(x[0]), to_double(x[1]), to_double(x[2])


# -- cheap answers ------------------------------------------------------------------------------------------


def _separated(a: Polyhedron, b: Polyhedron, touching: list[Pair]) -> bool:
    """Whether a plane through the contact certainly has the two bodies on its two sides."""
    for pair in touching[:PLANES_TRIED]:
        for normal, point in _planes(corners_of(a, pair[1]), corners_of(b, pair[2])):
            if any(sign(x) for x in normal):
                sides_a, sides_b = _sides(a, normal, point), _sides(b, normal, point)
                if not ({1, -1} <= set(sides_a)) and not ({1, -1} <= set(sides_b)):
                    if not set(sides_a) & set(sides_b) & {1, -1}:
                        return True
    return False


def _planes(x: list[Vector], y: list[Vector]) -> Iterator[tuple[Vector, Vector]]:
    """Planes of the facets among the two elements, and across every two of their edges."""
    for corners in (x, y):
        if len(corners) == 3:
            yield cross(sub(corners[1], corners[0]), sub(corners[2], corners[0])), corners[0]
    sides_x, sides_y = _sides_of(x), _sides_of(y)
    for (p, q), (r, s) in ((i, j) for i in sides_x for j in sides_y):
        if segments_meet(p, q, r, s):
            yield cross(sub(q, p), sub(s, r)), p


def _sides_of(corners: Sequence[Vector]) -> list[tuple[Vector, Vector]]:
    if len(corners) == 3:
        return [(corners[0], corners[1]), (corners[1], corners[2]), (corners[2], corners[0])]
    return [(corners[0], corners[1])] if len(corners) == 2 else []


def _sides(body: Polyhedron, normal: Vector, point: Vector) -> tuple[int, ...]:
    """On which sides of the plane vertices lie: a sorted subset of -1, 0, 1; exact."""
    n, p = (np.array([to_double(x) for x in v]) for v in (normal, point))
    values = (body.vertices - p) @ n
    size = (np.abs(body.vertices).max() + np.abs(p).max() + body.error) * np.abs(n).sum()
    near = np.flatnonzero(np.abs(values) <= 1e-14 * size + 4.0 * body.error * np.abs(n).sum())
    found = set(np.unique(np.sign(np.delete(values, near))).astype(int).tolist())
    for i in near.tolist():
        found.add(sign(dot(normal, sub(body.exact_vertex(i), point))))
        if len(found) == 3:
            break
    return tuple(sorted(found))


def _component_inside(inner: Polyhedron, outer: Polyhedron, touching: list[Feature]) -> bool:
    """Whether a component of `inner` that touches nothing lies inside `outer`."""
    vertices = component_vertices(inner)
    if not outer.solid or len(vertices) == 1:
        return False
    label = component_labels(inner)
    touched = {int(label[_some_vertex(inner, element)]) for element in touching}
    tree = tree_of(outer)
    free = [v for v in vertices if int(label[v]) not in touched]
    return any(contains(outer, tree, inner.exact_vertex(v)) for v in free)


def _some_vertex(body: Polyhedron, element: Feature) -> int:
    kind, index = element
    if kind == VERTEX:
        return index
    if kind == EDGE:
        return int(body._segments[index, 0]) if index < len(body._segments) else index - len(body._segments)
    return int(body.triangles[index, 0])


# -- tangent cones ------------------------------------------------------------------------------------------


def _shared_vertices(a: Polyhedron, b: Polyhedron, pair: Pair) -> Iterator[Vector]:
    """The vertices of the set the two elements share: corners of one on the other, crossings of edges."""
    x, y = corners_of(a, pair[1]), corners_of(b, pair[2])
    yield from (p for p in x if _on(p, y))
    yield from (p for p in y if _on(p, x))
    for (p, q), (r, s) in ((i, j) for i in _sides_of(x) for j in _sides_of(y)):
        e, f = sub(q, p), sub(s, r)
        n = cross(e, f)
        if any(n) and segments_meet(p, q, r, s):
            yield along(r, dot(cross(sub(r, p), e), n) / dot(n, n), f)


def _on(p: Vector, corners: Sequence[Vector]) -> bool:
    """Whether p lies on the closed vertex, edge or triangle."""
    if len(corners) == 1:
        return p == corners[0]
    if len(corners) == 2:
        return point_line.on_segment(p, *corners)
    n = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]))
    if not any(n):
        return any(point_line.on_segment(p, *side) for side in _sides_of(corners))
    return dot(n, sub(p, corners[0])) == 0 and in_triangle(p, *corners, n)  # type: ignore[call-arg]


def _facets_at(body: Polyhedron, x: Vector) -> list[list[Vector]]:
    """Corners of the triangles that contain x."""
    p = np.array([to_double(c) for c in x])
    corners = body.vertices[body.triangles]
    pad = 2.0 * body.error + np.abs(p) * 2.0**-50
    near = np.all((corners.min(axis=1) <= p + pad) & (corners.max(axis=1) >= p - pad), axis=1)
    triangles = [corners_of(body, (FACE, int(t))) for t in np.flatnonzero(near)]
    return [t for t in triangles if _on(x, t)]


def _cones_overlap(a: Polyhedron, b: Polyhedron, x: Vector) -> bool:
    """Whether near x some point of one body lies in the interior of the other (solid) one."""
    facets_a, facets_b = _facets_at(a, x), _facets_at(b, x)
    normals: list[Vector] = []
    for t in facets_a + facets_b:
        n = cross(sub(t[1], t[0]), sub(t[2], t[0]))
        if any(n) and not any(_parallel(n, m) for m in normals):
            normals.append(n)
    if a.solid and b.solid:
        directions = _cell_directions(normals)
    else:
        surface, facets = (b, facets_b) if a.solid else (a, facets_a)
        directions = chain(_edge_directions(surface, x), _facet_directions(facets, x, normals))
    seen = set()
    for g in directions:
        signs = tuple(sign(dot(n, g)) for n in normals)
        if a.solid and b.solid:
            if 0 in signs or signs in seen:
                continue
            seen.add(signs)
        if all(_inside_along(body, x, g) for body in (a, b) if body.solid):
            return True
    return False


def _parallel(n: Vector, m: Vector) -> bool:
    return not any(cross(n, m))


def _cell_directions(normals: list[Vector]) -> Iterator[Vector]:
    """At least one direction inside every cell of the arrangement of planes through a point."""
    if len(normals) == 1:
        yield normals[0]
        yield scaled(-1, normals[0])
        return
    for n, m in combinations(normals, 2):
        line = cross(n, m)
        for r in (line, scaled(-1, line)):
            through = [k for k in normals if dot(k, r) == 0]
            others = [k for k in normals if dot(k, r) != 0]
            rays = [scaled(s, cross(k, r)) for k in through for s in (1, -1)]
            for u, v in combinations(rays, 2):
                w = add(u, v)
                if any(w):
                    # turn r towards w by so little that no other plane is reached
                    reach = [abs(dot(k, r)) / abs(dot(k, w)) for k in others if dot(k, w) != 0]
                    yield along(r, min(reach, default=fmpq(2)) / 2, w)


def _edge_directions(body: Polyhedron, x: Vector) -> Iterator[Vector]:
    """Directions along the edges that contain x."""
    p = np.array([to_double(c) for c in x])
    ends = body.vertices[body._segments]
    pad = 2.0 * body.error + np.abs(p) * 2.0**-50
    near = np.all((ends.min(axis=1) <= p + pad) & (ends.max(axis=1) >= p - pad), axis=1)
    for e in np.flatnonzero(near):
        edge = corners_of(body, (EDGE, int(e)))
        if _on(x, edge):
            yield from (sub(end, x) for end in edge if end != x)


def _facet_directions(facets: list[list[Vector]], x: Vector, normals: list[Vector]) -> Iterator[Vector]:
    """Directions into every piece that the planes cut from the facets at x."""
    for t in facets:
        n = cross(sub(t[1], t[0]), sub(t[2], t[0]))
        rays = [scaled(s, cross(n, m)) for m in normals if not _parallel(n, m) for s in (1, -1)]
        rays += [sub(c, x) for c in t if c != x] + [sub(c, d) for c in t for d in t if c != d]
        for u, v in combinations(rays, 2):
            w = add(u, v)
            size = max((abs(c) for c in w), default=fmpq(0))
            reach = max(abs(c) for p in t for c in sub(p, x))
            if size and reach and _on(along(x, reach / size / 2**40, w), t):
                yield w


def _inside_along(body: Polyhedron, x: Vector, g: Vector) -> bool:
    """Whether x + s g lies in the interior of the solid for all small s > 0; g lies in no facet's plane there."""
    size = max(abs(c) for c in g)
    span = max(float(np.ptp(body.vertices)), 1e-300)
    step = fmpq(*span.as_integer_ratio()) / size / 16
    tree = tree_of(body)
    while _meets_far_facet(body, x, along(x, step, g)):
        step /= 16
    y = along(x, step, g)
    if any(_on(y, t) for t in _facets_at(body, y)):
        return False
    return contains(body, tree, y)


def _meets_far_facet(body: Polyhedron, x: Vector, y: Vector) -> bool:
    """Whether the segment from x to y meets a triangle of the body that does not contain x."""
    p, q = (np.array([to_double(c) for c in v]) for v in (x, y))
    corners = body.vertices[body.triangles]
    pad = 2.0 * body.error + np.maximum(np.abs(p), np.abs(q)) * 2.0**-50
    near = np.all(
        (corners.min(axis=1) <= np.maximum(p, q) + pad) & (corners.max(axis=1) >= np.minimum(p, q) - pad), axis=1
    )
    for t in np.flatnonzero(near):
        triangle = corners_of(body, (FACE, int(t)))
        if not _on(x, triangle) and relation(x, y, *triangle) != APART:
            return True
    return False
