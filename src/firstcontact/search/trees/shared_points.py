"""Two bodies at rest: the points where what their surfaces share begins, ends or turns.

Those are the vertices of one on the other, and the places where two edges cross.  An edge through the inside of a
facet ends the search.  Signs that kernels leave open are told in exact numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpz

from firstcontact import work
from firstcontact.body.kept import Kept
from firstcontact.exact.numbers import exact_value, to_double
from firstcontact.exact.vectors import Vector
from firstcontact.kernels.jit import kernel
from firstcontact.kernels.signs import UNSURE, are_in_range, cross_sign, det_sign, work_room
from firstcontact.pairs.elements.line_line import segments_cross
from firstcontact.pairs.elements.point_line import on_segment
from firstcontact.pairs.elements.point_plane import on_triangle
from firstcontact.pairs.elements.segment_facet import APART, CROSSING, relation
from firstcontact.search.trees.elements import EDGE, FACE, VERTEX, Feature, corners_of
from firstcontact.search.trees.frame import tree_of
from firstcontact.search.trees.tree import CORNER, FACET, FLAT_SIDE, SIDE, Tree

if TYPE_CHECKING:
    from firstcontact.body.polyhedron.polyhedron import Polyhedron

# What a row of the search tells: a vertex of a on a facet of b, a facet of a under a vertex of b, edges that cross,
# an edge through a facet, a facet around an edge; and how much more where the kernel is not sure.
VERTEX_FACET, FACET_VERTEX, EDGES, PIERCING, PIERCED = range(5)
IN_DOUBT = 8
_KINDS = ((VERTEX, FACE), (FACE, VERTEX), (EDGE, EDGE), (EDGE, FACE), (FACE, EDGE))

# Where a point or an edge meets a triangle, beside the sides of it as bits.
NOWHERE, OPEN, NO_AREA = -1, -2, -3
THROUGH, IN_PLANE = 8, 16

# Reasons to come back, slots of the state, and the room that a pair of leaves needs.
_DONE, _FULL, _SLICE_SPENT = range(3)
_STACK, _FOUND, _VISITS = range(3)
_LEAF_ROOM = 64
_SLICE = 1_000_000
_ODD_DENOMINATOR = Kept[fmpz]()
# What a pair takes among those found.
PAIR_BYTES = 300


NEARLY_A_LINE = 1e-12
"""Of a facet's size times that with its coordinates: far above what doubles make of the area of a line."""


class RestingVertices:
    """Two bodies at rest, their vertices one behind the other, and one point more.

    places   as the trees have them
    signs    all times `scale`, as `kernels.signs` takes points
    """

    def __init__(self, a: Polyhedron, b: Polyhedron) -> None:
        self.bodies, self.trees = (a, b), (tree_of(a), tree_of(b))
        self.firsts = 0, len(a.vertices)
        spare = np.zeros((1, 3))
        self.places = np.concatenate([a.vertices, b.vertices, spare])
        self.error = max(a.error, b.error)
        parts = _in_parts(a, b)
        self.is_exact = parts is not None
        parts = parts or (fmpz(1), self.places, np.empty((0, 3)), self.error)
        self.scale, self.high = parts[:2]
        self.signs = self.high, parts[2], parts[3], work_room(self.is_exact)

    def put(self, x: Vector) -> int:
        """Take x for the last point, rounded; its number."""
        last = len(self.places) - 1
        self.places[last] = [to_double(c) for c in x]
        self.high[last] = [to_double(self.scale * c) for c in x]
        return last

    @cached_property
    def steepness(self) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
        """Of the facets of each body the axis that they are steepest to, and how much area they show along it."""
        found = []
        for body in self.bodies:
            a, b, c = (body.vertices[body.triangles[:, k]] for k in range(3))
            normals = np.abs(np.cross(b - a, c - a))
            found.append((normals.argmax(axis=1), normals.max(axis=1)))
        return found[0], found[1]

    @cached_property
    def without_area(self) -> tuple[np.ndarray, np.ndarray]:
        """Of the facets of each body whether they may have no area."""
        a, b = self.steepness
        return _may_be_lines(self.bodies[0], a[1]), _may_be_lines(self.bodies[1], b[1])

    @cached_property
    def around(self) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
        """Of each body the sides of triangles, 3 * triangle + side, in the order of their segments; and whose begin."""
        found = []
        for body in self.bodies:
            sides = body.side_edge.ravel()
            order = np.argsort(sides, kind="stable")
            found.append((order, np.searchsorted(sides[order], np.arange(len(body.segments) + 1))))
        return found[0], found[1]

    def is_bare(self, side: int, segment: int) -> bool:
        """Whether a segment bounds no facet; one that stands for a point is none."""
        return segment < len(self.bodies[side].segments) and not self.facets_around(side, segment)

    def facets_around(self, side: int, segment: int) -> list[int]:
        """The triangles of a body (0: a) that have the segment for a side."""
        order, starts = self.around[side]
        return (order[starts[segment] : starts[segment + 1]] // 3).tolist()


def _may_be_lines(body: Polyhedron, areas: np.ndarray) -> np.ndarray:
    """Of facets with these areas along the axis that they are steepest to, which are as good as lines to doubles."""
    corners = body.vertices[body.triangles]
    size = np.ptp(corners, axis=1).max(axis=1)
    found: np.ndarray = areas <= NEARLY_A_LINE * size * (size + np.abs(corners).max(axis=(1, 2)))
    return found


def _in_parts(a: Polyhedron, b: Polyhedron) -> tuple[fmpz, np.ndarray, np.ndarray, float] | None:
    """(scale, high, low, largest low): all vertices times one whole number; None where two doubles do not hold them."""
    vertices = np.concatenate([a.vertices, b.vertices, np.zeros((1, 3))])
    if a.error == b.error == 0.0:
        return (fmpz(1), vertices, np.zeros_like(vertices), 0.0) if are_in_range(vertices) else None
    if a.irrational_pose is not None or b.irrational_pose is not None:
        return None
    scale = _odd_denominator(a).lcm(_odd_denominator(b))
    high: np.ndarray = np.zeros(vertices.shape)
    low: np.ndarray = np.zeros(vertices.shape)
    rows = (body.exact_vertex(i) for body in (a, b) for i in range(len(body.vertices)))
    for i, row in enumerate(rows):
        for k, x in enumerate(row):
            x *= scale
            high[i, k] = to_double(x)
            if not math.isfinite(high[i, k]):
                return None
            low[i, k] = to_double(rest := x - exact_value(high[i, k]))
            if exact_value(low[i, k]) != rest:
                return None
    return (scale, high, low, float(np.abs(low).max())) if are_in_range(np.stack([high, low])) else None


def _odd_denominator(body: Polyhedron) -> fmpz:
    """The least odd number by which all coordinates have to be multiplied to have a power of two below."""
    def found() -> fmpz:
        odd = fmpz(1)
        for i in range(len(body.vertices)) if body.error else ():
            for q in (int(x.q) for x in body.exact_vertex(i)):
                odd = odd.lcm(q // (q & -q))
        return odd

    return _ODD_DENOMINATOR.of(body, found)


# -- one pair of elements -------------------------------------------------------------------------------------


@kernel
def where_on(high, low, err, room, x, a, b, c):
    """The sides of triangle abc that hold point x, as bits: 0 inside it; NOWHERE, NO_AREA, or OPEN in doubt."""
    height = det_sign(high, low, err, room, a, x, b, x, c, x)
    if height == 1 or height == -1:
        return NOWHERE
    axis, turn = _normal(high, low, err, room, a, b, c)
    if turn == 0 or turn == UNSURE:
        return NO_AREA if turn == 0 else OPEN
    bits = 0
    for s in range(3):
        p, q = (a, b) if s == 0 else (b, c) if s == 1 else (c, a)
        sign = cross_sign(high, low, err, room, axis, p, x, q, x)
        if sign == -turn:
            return NOWHERE
        if sign != turn:
            bits |= 1 << s
    return bits if room.shape[0] > 0 else OPEN


@kernel
def _normal(high, low, err, room, a, b, c):
    """(k, sign) of a coordinate of the triangle's normal that is not zero; sign 0 where all are, or UNSURE."""
    start, largest = 0, -1.0
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        size = abs(
            (high[b, i] - high[a, i]) * (high[c, j] - high[a, j])
            - (high[b, j] - high[a, j]) * (high[c, i] - high[a, i])
        )
        if size > largest:
            start, largest = k, size
    for t in range(3):
        k = (start + t) % 3
        sign = cross_sign(high, low, err, room, k, b, a, c, a)
        if sign != 0:
            return k, sign
    return 0, 0


@kernel
def where_through(high, low, err, room, p, q, a, b, c):
    """Where the inside of edge pq meets triangle abc: THROUGH its inside, or its sides, as bits; two for a corner.

    0 where neither, OPEN in doubt; for an edge in the plane of the triangle insides of sides, and the bit IN_PLANE.
    """
    above = det_sign(high, low, err, room, b, a, c, a, p, a)
    below = det_sign(high, low, err, room, b, a, c, a, q, a)
    if above == below and (above == 1 or above == -1):
        return 0
    ab = det_sign(high, low, err, room, q, p, a, p, b, p)
    bc = det_sign(high, low, err, room, q, p, b, p, c, p)
    ca = det_sign(high, low, err, room, q, p, c, p, a, p)
    if (ab == 1 or bc == 1 or ca == 1) and (ab == -1 or bc == -1 or ca == -1):
        return 0
    if above == UNSURE or below == UNSURE or ab == UNSURE or bc == UNSURE or ca == UNSURE:
        return OPEN
    if above == 0 and below == 0:
        turn = _normal(high, low, err, room, a, b, c)[1]
        if turn == 0:
            return 0  # its sides are those of its neighbours
        first = _cross(high, low, err, room, p, q, a, b)
        second = _cross(high, low, err, room, p, q, b, c)
        return IN_PLANE + first + 2 * second + 4 * _cross(high, low, err, room, p, q, c, a)
    if above * below == 0:
        return 0
    bits = (1 if ab == 0 else 0) + (2 if bc == 0 else 0) + (4 if ca == 0 else 0)
    return THROUGH if bits == 0 else bits


@kernel
def _cross(high, low, err, room, p, q, r, s):
    """1 where the insides of two segments of one plane cross, else 0; with exact signs."""
    for k in range(3):
        if cross_sign(high, low, err, room, k, q, p, s, r) != 0:
            one = cross_sign(high, low, err, room, k, q, p, r, p) * cross_sign(high, low, err, room, k, q, p, s, p)
            two = cross_sign(high, low, err, room, k, s, r, p, r) * cross_sign(high, low, err, room, k, s, r, q, r)
            return 1 if one < 0 and two < 0 else 0
    return 0


# -- all of them ----------------------------------------------------------------------------------------------


def shared_points(resting: RestingVertices) -> list[tuple[Feature, Feature]] | None:
    """The pairs (vertex, facet), (facet, vertex) and (edge, edge) that share such a point, each point at least once.

    A vertex on an edge that bounds no facet is told as such a pair.  None: an edge passes through a facet.
    Raises NoMemory.
    """
    found: set[tuple[Feature, Feature]] = set()
    for rows in _search(resting):
        for kind, x, y in rows.tolist():
            if kind in (PIERCING, PIERCED):
                return None
            kind_a, kind_b = _KINDS[kind % IN_DOUBT]
            pair = (kind_a, x), (kind_b, y)
            if kind < IN_DOUBT:
                found.add(pair)
                continue
            decided = _decided(resting, kind - IN_DOUBT, *pair)
            if decided is None:
                return None
            found.update(decided)
        if PAIR_BYTES * len(found) > work.MOST_BYTES:
            raise work.NoMemory
    return _one_each(found)


def _one_each(pairs: set[tuple[Feature, Feature]]) -> list[tuple[Feature, Feature]]:
    """A vertex on several facets is one point."""
    points = {}
    for pair in sorted(pairs, reverse=True):
        x, y = pair
        points[x if x[0] == VERTEX else (3, *y) if y[0] == VERTEX else pair] = pair
    return list(points.values())


def _decided(
    resting: RestingVertices, kind: int, x: Feature, y: Feature
) -> list[tuple[Feature, Feature]] | None:
    """The points that a pair in doubt shares, in exact numbers; None: the edge passes through the facet."""
    a, b = resting.bodies
    corners_x, corners_y = corners_of(a, x), corners_of(b, y)
    if kind == VERTEX_FACET:
        return [(x, y)] if on_triangle(corners_x[0], *corners_y) else []
    if kind == FACET_VERTEX:
        return [(x, y)] if on_triangle(corners_y[0], *corners_x) else []
    (p, q), facet, other = (corners_x, corners_y, b) if kind == PIERCING else (corners_y, corners_x, a)
    how = relation(p, q, *facet)
    if how in (APART, CROSSING):
        return None if how == CROSSING else []
    edge, triangle = (x, y[1]) if kind == PIERCING else (y, x[1])
    met = [
        (EDGE, segment) for s, segment in enumerate(other.side_edge[triangle].tolist())
        if segment >= 0 and segments_cross(p, q, facet[s], facet[(s + 1) % 3])
    ]  # fmt: skip
    if resting.is_bare(0 if kind == PIERCING else 1, edge[1]):
        corners = zip(other.triangles[triangle].tolist(), facet, strict=True)
        met += [(VERTEX, v) for v, corner in corners if on_segment(corner, p, q)]
    return [(edge, found) if kind == PIERCING else (found, edge) for found in met]


def _search(resting: RestingVertices) -> Iterator[np.ndarray]:
    """Rows (kind, index in a, index in b) of what the kernel finds."""
    (a, b), (tree_a, tree_b) = resting.bodies, resting.trees
    state = np.array([1, 0, 0])
    stack, rows = np.zeros((1024, 2), np.int64), np.empty((4096, 3), np.int64)
    flat_a, flat_b = _flat(a, tree_a), _flat(b, tree_b)
    pad = 2.0 * (tree_a.error + tree_b.error)
    while True:
        reason = _collect(
            tree_a.boxes, tree_a.links, tree_a.ids, tree_a.corners, tree_a.sides, flat_a,
            tree_b.boxes, tree_b.links, tree_b.ids, tree_b.corners, tree_b.sides, flat_b,
            *resting.signs, resting.firsts[1], pad, state[_VISITS] + _SLICE, state, stack, rows,
        )  # fmt: skip
        yield rows[: state[_FOUND]].copy()
        state[_FOUND] = 0
        if reason == _DONE:
            return
        if state[_STACK] + 4 > len(stack):
            (stack,) = work.doubled(stack)


def _flat(body: Polyhedron, tree: Tree) -> np.ndarray:
    """(segments,) whether contacts on the segment are contacts of the facets beside it."""
    flat = np.zeros(len(body.segments) + len(body.vertices), bool)
    for s in range(3):
        flat[tree.sides[tree.ids[(tree.ids[:, 1] >> (FLAT_SIDE + s)) & 1 == 1, 0], s]] = True
    return flat


@kernel
def _collect(
    boxes_a, links_a, ids_a, corners_a, sides_a, flat_a, boxes_b, links_b, ids_b, corners_b, sides_b, flat_b,
    high, low, err, room, first_b, pad, limit, state, stack, rows,
):  # fmt: skip
    """Go on collecting rows until one of the reasons to come back."""
    while state[_STACK] > 0:
        if state[_FOUND] + _LEAF_ROOM > rows.shape[0] or state[_STACK] + 4 > stack.shape[0]:
            return _FULL
        if state[_VISITS] >= limit:
            return _SLICE_SPENT
        state[_STACK] -= 1
        state[_VISITS] += 1
        a, b = stack[state[_STACK], 0], stack[state[_STACK], 1]
        apart = False
        for k in range(3):
            apart = apart or boxes_a[a, k] > boxes_b[b, k + 3] + pad or boxes_b[b, k] > boxes_a[a, k + 3] + pad
        if apart:
            continue
        if links_a[a, 1] < 0 and links_b[b, 1] < 0:
            pa, pb = links_a[a, 0], links_b[b, 0]
            one, two = ids_a[pa, 0], ids_b[pb, 0]
            if ids_b[pb, 1] & FACET:
                _meet(
                    ids_a[pa, 1], corners_a[one], sides_a[one], 0, two, corners_b[two], sides_b[two], flat_b, first_b,
                    high, low, err, room, False, state, rows,
                )  # fmt: skip
            if ids_a[pa, 1] & FACET:
                _meet(
                    ids_b[pb, 1], corners_b[two], sides_b[two], first_b, one, corners_a[one], sides_a[one], flat_a, 0,
                    high, low, err, room, True, state, rows,
                )  # fmt: skip
            continue
        open_a = links_b[b, 1] < 0
        if links_a[a, 1] >= 0 and not open_a:
            wide_a = wide_b = 0.0
            for k in range(3):
                wide_a = max(wide_a, boxes_a[a, k + 3] - boxes_a[a, k])
                wide_b = max(wide_b, boxes_b[b, k + 3] - boxes_b[b, k])
            open_a = wide_a >= wide_b
        for k in range(2):
            stack[state[_STACK], 0] = links_a[a, k] if open_a else a
            stack[state[_STACK], 1] = b if open_a else links_b[b, k]
            state[_STACK] += 1
    return _DONE


@kernel
def _meet(
    mask, corners, sides, first, facet, facet_corners, facet_sides, flat, first_facet, high, low, err, room, swapped,
    state, rows,
):  # fmt: skip
    """Vertices and edges that a part owns against a facet of the other body; swapped: the part is of b."""
    a, b, c = first_facet + facet_corners[0], first_facet + facet_corners[1], first_facet + facet_corners[2]
    for s in range(3):
        p = first + corners[s]
        if mask & (1 << (CORNER + s)):
            place = where_on(high, low, err, room, p, a, b, c)
            if place != NOWHERE:
                _note(VERTEX_FACET + (IN_DOUBT if place < 0 else 0), corners[s], facet, swapped, state, rows)
        if mask & (1 << (SIDE + s)) and sides[s] >= 0:
            place = where_through(high, low, err, room, p, first + corners[(s + 1) % 3], a, b, c)
            by_corner = place == 3 or place == 5 or place == 6
            if place == THROUGH or place == OPEN or (by_corner and not mask & FACET):
                _note(PIERCING + (0 if place == THROUGH else IN_DOUBT), sides[s], facet, swapped, state, rows)
            elif place > 0 and not by_corner:
                for t in range(3):
                    side = facet_sides[t]
                    if place & (1 << t) and side >= 0 and not (place & IN_PLANE and flat[side]):
                        _note(EDGES, sides[s], side, swapped, state, rows)


@kernel
def _note(kind, x, y, swapped, state, rows):
    n = state[_FOUND]
    if swapped:
        x, y = y, x
        kind = kind if kind == EDGES else kind + 1  # FACET_VERTEX, PIERCED
    rows[n, 0], rows[n, 1], rows[n, 2] = kind, x, y
    state[_FOUND] = n + 1
