"""Whether the tangent cones of two bodies at a point that their surfaces share have inner points in common; exact.

Seen from the point, every facet that holds it is one or more arcs between directions, each shorter than half a turn,
and a body is a region of the sphere of directions that its arcs bound.  Where no arc of one body crosses one of the
other, the edge of a cell that the regions share goes on to the end of its arc without leaving the other region, so it
is enough to go around each end once.  All that this needs are three tables of signs:

S[r, d]  of det(first, second, d), with the ends of arc r
L[i, j]  of det(g, i, j)
C[i]     of dot(g, i)

where g is a coordinate axis turned by an infinitesimal towards the next one, and by a smaller one towards the third: it
lies in no plane through two directions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from firstcontact.exact.numbers import sign, to_double
from firstcontact.exact.vectors import Vector, along, cross, dot, sub
from firstcontact.kernels.jit import kernel
from firstcontact.kernels.signs import UNSURE, cross_sign, det_sign, order
from firstcontact.pairs.elements.point_line import on_segment
from firstcontact.pairs.elements.point_plane import on_triangle
from firstcontact.search.trees.containment import contains, hits_of_ray, parity_of_hits
from firstcontact.search.trees.elements import VERTEX, Feature, corners_of, vertices_of
from firstcontact.search.trees.shared_points import NOWHERE, RestingVertices, where_on
from firstcontact.search.trees.tree import FACET

# A bare edge among the facets at a point.
_BARE = -4


@dataclass(slots=True)
class _Star:
    """What meets in a point.

    directions   pairs of points (head, tail), or vectors, each with its number
    arcs         (first direction, second direction, body)
    bare         (direction, body) of edges of a surface that bound no facet
    facets       of either body, those that hold the point
    """

    directions: dict = field(default_factory=dict)
    arcs: list[tuple[int, int, int]] = field(default_factory=list)
    bare: list[tuple[int, int]] = field(default_factory=list)
    facets: tuple[list[int], list[int]] = field(default_factory=lambda: ([], []))

    def index(self, direction: object) -> int:
        return int(self.directions.setdefault(direction, len(self.directions)))

    def add(self, first: object, second: object, side: int) -> None:
        self.arcs.append((self.index(first), self.index(second), side))


def cones_overlap(resting: RestingVertices, pair: tuple[Feature, Feature]) -> bool:
    """Whether near the point that the two elements share some point of one body lies in the interior of the other.

    pair: as from `shared_points`.  A wall, a facet that a solid has twice, counts as a part of it.
    """
    found = _at_vertex(resting, pair) if VERTEX in (pair[0][0], pair[1][0]) else _at_crossing(resting, pair)
    return _exactly(resting, _place(resting, pair)) if found is None else found


def _place(resting: RestingVertices, pair: tuple[Feature, Feature]) -> Vector:
    """The point."""
    x, y = (corners_of(body, element) for body, element in zip(resting.bodies, pair, strict=True))
    if len(x) == 1 or len(y) == 1:
        return x[0] if len(x) == 1 else y[0]
    e, f = sub(x[1], x[0]), sub(y[1], y[0])
    n = cross(e, f)
    return along(y[0], dot(cross(sub(y[0], x[0]), e), n) / dot(n, n), f)


# -- stars of points, and whether kernels can tell ------------------------------------------------------------


def _at_vertex(resting: RestingVertices, pair: tuple[Feature, Feature]) -> bool | None:
    """None where doubles do not hold what is asked."""
    if not resting.is_exact:
        return None
    side = 0 if pair[0][0] == VERTEX else 1
    x = resting.firsts[side] + pair[side][1]
    star = _Star()
    for k, (body, first) in enumerate(zip(resting.bodies, resting.firsts, strict=True)):
        for primitive, place in _facets_near(resting, k, x, resting.signs[2], resting.signs[3]):
            if place < 0:
                return None
            star.facets[k].append(primitive)
            a, b, c = (first + v for v in body.triangles[primitive].tolist())
            for s, (p, q) in enumerate(((a, b), (b, c), (c, a))):
                if not place >> s & 1:
                    star.add((p, x), (q, x), k)
    return _told(resting, star, x)


def _at_crossing(resting: RestingVertices, pair: tuple[Feature, Feature]) -> bool | None:
    """None where doubles do not hold what is asked, or more than the facets around the two edges meets there."""
    if not resting.is_exact:
        return None
    place = _place(resting, pair)
    x = resting.put(place)
    err = resting.signs[2] + float(np.abs(resting.high[x]).max()) * 2.0**-52
    star = _Star()
    for k, (body, first, element) in enumerate(zip(resting.bodies, resting.firsts, pair, strict=True)):
        around = resting.facets_around(k, element[1])
        near = {t for t, _ in _facets_near(resting, k, x, err, resting.signs[3][:0])}
        if not around or not near <= set(around) or any(resting.without_area[k][t] for t in around):
            return None
        ends = vertices_of(body, element)
        p, q = (first + v for v in ends)
        for t in around:
            third = [first + v for v in body.triangles[t].tolist() if v not in ends]
            if len(third) != 1:
                return None
            star.facets[k].append(t)
            star.add((q, p), (third[0], p), k)
            star.add((third[0], p), (p, q), k)
    return _told(resting, star, place)


def _facets_near(
    resting: RestingVertices, side: int, x: int, err: float, room: np.ndarray
) -> list[tuple[int, int]]:
    """(primitive, where the point is on it) of all that hold the point or may."""
    tree, out = resting.trees[side], np.empty((64, 2), np.int64)
    pad = 2.0 * resting.error + float(np.abs(resting.places[x]).max()) * 2.0**-51
    while True:
        n = _holding(
            tree.boxes, tree.links, tree.ids, tree.corners, resting.firsts[side],
            *resting.signs[:2], err, room, x, resting.places[x], pad, out,
        )  # fmt: skip
        if n >= 0:
            return out[:n].tolist()
        out = np.empty((4 * len(out), 2), np.int64)


@kernel
def _holding(boxes, links, ids, corners, first, high, low, err, room, x, place, pad, out):
    """Fill out with (primitive, `where_on` or _BARE) of those near a point; -1 where there is no room."""
    stack = np.empty(256, np.int64)
    stack[0] = 0
    depth, n = 1, 0
    while depth > 0:
        depth -= 1
        node = stack[depth]
        box = boxes[node]
        apart = False
        for k in range(3):
            apart = apart or box[k] > place[k] + pad or box[k + 3] < place[k] - pad
        if apart:
            continue
        if links[node, 1] >= 0:
            stack[depth], stack[depth + 1] = links[node, 0], links[node, 1]
            depth += 2
            continue
        part = links[node, 0]
        primitive = ids[part, 0]
        known = False
        for i in range(n):
            known = known or out[i, 0] == primitive
        if known:
            continue
        kind = _BARE
        if ids[part, 1] & FACET:
            a, b, c = first + corners[primitive, 0], first + corners[primitive, 1], first + corners[primitive, 2]
            kind = where_on(high, low, err, room, x, a, b, c)
        if kind != NOWHERE:
            if n == out.shape[0]:
                return -1
            out[n, 0], out[n, 1] = primitive, kind
            n += 1
    return n


def _told(resting: RestingVertices, star: _Star, x: int | Vector) -> bool | None:
    """Whether the cones overlap, by signs of kernels; None where one is in doubt."""
    axis = _steepest(resting, star)
    directions, arcs = np.array(list(star.directions)), np.array(star.arcs, np.int64).reshape(-1, 3)
    tables = _tables(*resting.signs, axis, directions, arcs)
    if tables[3]:
        return None
    inside = [
        body.solid and _is_inside(resting, k, x, star.facets[k], axis) for k, body in enumerate(resting.bodies)
    ]
    return bool(_regions_meet(*tables[:3], arcs, np.empty((0, 2), np.int64), *inside, *_solid(resting)))


def _solid(resting: RestingVertices) -> tuple[bool, bool]:
    a, b = resting.bodies
    return a.solid, b.solid


def _steepest(resting: RestingVertices, star: _Star) -> int:
    """The axis that goes most steeply through the largest facet: rays along facets would meet many."""
    largest, axis = -1.0, 0
    for (axes, areas), facets in zip(resting.steepness, star.facets, strict=True):
        for t in facets:
            if areas[t] > largest:
                largest, axis = areas[t], int(axes[t])
    return axis


def _is_inside(resting: RestingVertices, side: int, x: int | Vector, facets: list[int], axis: int) -> bool:
    """Whether points next to x in the direction g lie inside the body; facets: those that hold x."""
    body, tree = resting.bodies[side], resting.trees[side]
    if isinstance(x, int):
        first, skip = resting.firsts[side], np.array(facets, np.int64)
        hits = hits_of_ray(tree, resting.places[x], axis, 2.0 * resting.error)
        return bool(parity_of_hits(*resting.signs, first, body.triangles, hits, x, axis, skip))
    return contains(body, tree, x, axis, facets)


@kernel
def _tables(high, low, err, room, axis, directions, arcs):
    """(S, L, C, whether a sign is UNSURE)."""
    m, k = directions.shape[0], arcs.shape[0]
    s, line, forward = np.zeros((k, m), np.int8), np.zeros((m, m), np.int8), np.zeros(m, np.int8)
    unsure = False
    for i in range(m):
        p0, p1 = directions[i, 0], directions[i, 1]
        for t in range(3):
            if forward[i] == 0:
                forward[i] = order(high, low, err, room, (axis + t) % 3, p0, p1)
        unsure = unsure or forward[i] == UNSURE
        for j in range(i):
            for t in range(3):
                if line[i, j] == 0:
                    line[i, j] = cross_sign(
                        high, low, err, room, (axis + t) % 3, p0, p1, directions[j, 0], directions[j, 1]
                    )
            line[j, i] = -line[i, j]
            unsure = unsure or line[i, j] == UNSURE
    for r in range(k):
        x, y = arcs[r, 0], arcs[r, 1]
        for i in range(m):
            if i != x and i != y:
                s[r, i] = det_sign(
                    high, low, err, room, directions[x, 0], directions[x, 1], directions[y, 0], directions[y, 1],
                    directions[i, 0], directions[i, 1],
                )  # fmt: skip
                unsure = unsure or s[r, i] == UNSURE
    return s, line, forward, unsure


# -- stars of vectors -----------------------------------------------------------------------------------------


def _exactly(resting: RestingVertices, x: Vector) -> bool:
    """Whether the cones overlap, in exact numbers."""
    star = _Star()
    p = np.array([to_double(c) for c in x])
    for k, (body, tree) in enumerate(zip(resting.bodies, resting.trees, strict=True)):
        pad = 2.0 * body.error + np.abs(p) * 2.0**-50
        corners = body.vertices[tree.corners]
        near = np.all((corners.min(axis=1) <= p + pad) & (corners.max(axis=1) >= p - pad), axis=1)
        for primitive in np.flatnonzero(near).tolist():
            _add_exactly(star, body, k, primitive, tree.corners[primitive].tolist(), x)
    axis = _steepest(resting, star)
    inside = [
        body.solid and _is_inside(resting, k, x, star.facets[k], axis) for k, body in enumerate(resting.bodies)
    ]
    bare = np.array(star.bare, np.int64).reshape(-1, 2)
    arcs = np.array(star.arcs, np.int64).reshape(-1, 3)
    return bool(_regions_meet(*_exact_tables(star, axis), arcs, bare, *inside, *_solid(resting)))


def _add_exactly(star: _Star, body: object, side: int, primitive: int, vertices: list[int], x: Vector) -> None:
    """What one primitive adds to the star, if it holds x."""
    corners = [body.exact_vertex(v) for v in vertices]  # type: ignore[attr-defined]
    is_facet = primitive < len(body.triangles)  # type: ignore[attr-defined]
    sides = list(zip(corners, corners[1:] + corners[:1], strict=True))
    if is_facet and any(cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]))):
        if on_triangle(x, *corners):
            star.facets[side].append(primitive)
            for p, q in sides:
                if not on_segment(x, p, q):
                    star.add(sub(p, x), sub(q, x), side)
    else:
        for p, q in sides:
            if p != q and on_segment(x, p, q):
                star.bare += [(star.index(sub(end, x)), side) for end in (p, q) if end != x]


def _exact_tables(star: _Star, axis: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(S, L, C)."""
    directions = list(star.directions)
    m = len(directions)
    line = np.zeros((m, m), np.int8)
    for i in range(m):
        for j in range(i):
            line[i, j] = _leading(cross(directions[i], directions[j]), axis)
    s = [[sign(dot(n, d)) for d in directions] for n in _normals(star)]
    forward = [_leading(d, axis) for d in directions]
    return np.array(s, np.int8).reshape(-1, m), line - line.T, np.array(forward, np.int8)


def _normals(star: _Star) -> list[Vector]:
    """Of the planes of the arcs."""
    directions = list(star.directions)
    return [cross(directions[i], directions[j]) for i, j, _ in star.arcs]


def _leading(v: Sequence, axis: int) -> int:
    """The sign of dot(g, v)."""
    return next((sign(v[(axis + t) % 3]) for t in range(3) if v[(axis + t) % 3] != 0), 0)


# -- regions of the sphere ------------------------------------------------------------------------------------


@kernel
def _regions_meet(s, line, forward, arcs, bare, inside_a, inside_b, solid_a, solid_b):
    """Whether the regions share inner points, or an arc or direction of one body lies inside the region of the other.

    inside_a, inside_b: whether g is in the region; of a body that is no solid there is none.
    """
    k, m = s.shape
    for r in range(k):
        for q in range(r):
            if arcs[r, 2] != arcs[q, 2] and _do_cross(s, arcs, r, q):
                return True
    lines = np.empty((2 * k, 3), np.int64)
    for p in range(m):
        again = False
        for i in range(p):
            again = again or (line[i, p] == 0 and forward[i] == forward[p])
        if not again and _meet_around(s, line, forward, arcs, bare, inside_a, inside_b, solid_a, solid_b, p, lines):
            return True
    return False


@kernel
def _do_cross(s, arcs, r, q):
    """Whether the insides of two arcs cross."""
    one, two = s[r, arcs[q, 0]], s[r, arcs[q, 1]]
    three, four = s[q, arcs[r, 0]], s[q, arcs[r, 1]]
    return one * two < 0 and three * four < 0 and one * three < 0


@kernel
def _place_on(s, line, forward, arcs, r, p):
    """Where a direction is on an arc: 1 its first end, -1 its second, 2 inside, 0 nowhere."""
    x, y = arcs[r, 0], arcs[r, 1]
    if line[x, p] == 0 and forward[x] == forward[p]:
        return 1
    if line[y, p] == 0 and forward[y] == forward[p]:
        return -1
    if s[r, p] == 0 and line[x, p] == line[x, y] and line[p, y] == line[x, y]:
        return 2
    return 0


@kernel
def _meet_around(s, line, forward, arcs, bare, inside_a, inside_b, solid_a, solid_b, p, lines):
    """What `_regions_meet` asks, of the directions infinitely near to p.

    lines: room for the arcs that leave p: (arc, 1 towards its second end or -1, body), in turn from g on.
    """
    n, lines_a, lines_b = 0, 0, 0
    now_a, now_b = inside_a, inside_b
    for r in range(arcs.shape[0]):
        place = _place_on(s, line, forward, arcs, r, p)
        for way in (1, -1):
            if place == 2 or place == way:
                _insert(s, line, arcs, p, lines, n, r, way)
                n += 1
                lines_a, lines_b = lines_a + (arcs[r, 2] == 0), lines_b + (arcs[r, 2] == 1)
        if place == 0 and _crosses_to_g(s, line, arcs, r, p):
            now_a = now_a != (solid_a and arcs[r, 2] == 0)
            now_b = now_b != (solid_b and arcs[r, 2] == 1)
    if now_a and now_b:
        return True
    for i in range(bare.shape[0]):
        if line[bare[i, 0], p] == 0 and forward[bare[i, 0]] == forward[p]:
            if (bare[i, 1] == 0 and now_b and lines_b == 0) or (bare[i, 1] == 1 and now_a and lines_a == 0):
                return True
    i = 0
    while i < n:
        j, of_a, of_b = i, 0, 0
        while j < n and (j == i or _are_one(s, line, arcs, lines, p, i, j)):
            of_a, of_b = of_a + (lines[j, 2] == 0), of_b + (lines[j, 2] == 1)
            j += 1
        if (now_a and of_a == 0) or (now_b and of_b == 0):  # then it is lines of the other body alone
            return True
        now_a = now_a != (solid_a and of_a % 2 == 1)
        now_b = now_b != (solid_b and of_b % 2 == 1)
        if now_a and now_b:
            return True
        i = j
    return False


@kernel
def _crosses_to_g(s, line, arcs, r, p):
    """Whether the way from p to g crosses an arc that does not hold p."""
    x, y = arcs[r, 0], arcs[r, 1]
    one, two = line[p, x], line[p, y]
    return one * two < 0 and line[x, y] * s[r, p] < 0 and one * line[x, y] < 0


@kernel
def _target(arcs, r, way):
    return arcs[r, 1] if way == 1 else arcs[r, 0]


@kernel
def _insert(s, line, arcs, p, lines, n, r, way):
    """Put a line into its place among n."""
    at = n
    while at > 0 and _is_before(s, line, arcs, p, r, way, lines[at - 1, 0], lines[at - 1, 1]):
        for t in range(3):
            lines[at, t] = lines[at - 1, t]
        at -= 1
    lines[at, 0], lines[at, 1], lines[at, 2] = r, way, arcs[r, 2]


@kernel
def _is_before(s, line, arcs, p, r, way, q, other_way):
    """Whether turning from g about p meets the first of two lines strictly before the second."""
    one, two = line[_target(arcs, r, way), p], line[_target(arcs, q, other_way), p]
    if one != two:
        return one > two
    return way * s[r, _target(arcs, q, other_way)] > 0


@kernel
def _are_one(s, line, arcs, lines, p, i, j):
    """Whether two lines at p are the same."""
    r, way, q, other_way = lines[i, 0], lines[i, 1], lines[j, 0], lines[j, 1]
    one, two = line[_target(arcs, r, way), p], line[_target(arcs, q, other_way), p]
    return one == two and s[r, _target(arcs, q, other_way)] == 0
