"""Is a point inside a closed polyhedron?  Crossing parity of the ray along an axis, decided exactly.

The ray's origin counts as shifted by eps and eps^2 along the next two axes, eps infinitesimal (half-open rule), so that
the ray passes through no edge and no vertex; floats decide the triangles it certainly hits or misses.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Protocol, TypeVar

import numpy as np
from flint import fmpq

from firstcontact.body.kept import Kept, KeptOfTwo
from firstcontact.body.polyhedron.topology import component_of_vertices
from firstcontact.exact.numbers import PRECISIONS, Undecidable, precision, sign, to_double
from firstcontact.exact.rigid import IDENTITY, Matrix, apply, inverse_map
from firstcontact.exact.vectors import Vector, cross, dot, sub
from firstcontact.kernels.jit import kernel, uncounted
from firstcontact.kernels.selection import select
from firstcontact.kernels.signs import cross_sign, det_sign, order
from firstcontact.kernels.verdict import DET_EPS, TINY, cross_size
from firstcontact.kernels.verdict import cross as cross_f
from firstcontact.search.trees.frame import tree_of
from firstcontact.search.trees.tree import FACET, Tree

if TYPE_CHECKING:
    from firstcontact.body.polyhedron.polyhedron import Polyhedron
    from firstcontact.exact.rigid import Matrix

T = TypeVar("T")
At = TypeVar("At")
At_contra = TypeVar("At_contra", contravariant=True)
# Boxes of components that are looked at one by one.
_LEAF = 4
_LABELS = Kept[np.ndarray]()
_COMPONENTS = Kept[list[int]]()
_BOXES = Kept[np.ndarray]()
_CONTAINED = KeptOfTwo[tuple["tuple[str, int] | None"]]()


@uncounted
def _side(ay, az, by, bz, err):
    """Certain sign of the turn of (a, b) about the origin, 0 when unsure."""
    left, right = ay * bz, az * by
    size = abs(ay) + abs(az) + abs(by) + abs(bz)
    bound = DET_EPS * (abs(left) + abs(right)) + err * (size + err) * 2.0 + TINY
    o = left - right
    return 1 if o > bound else -1 if o < -bound else 0


@kernel
def ray_crossings(boxes, links, xyz, ids, p, axis, err, hits):
    """Fill hits with (triangle, 1 certain | 0 unsure) met by the ray from p (3,) along +axis; returns their number.

    err bounds the error of every difference of coordinates.  Stops short when hits is full: returns -1.
    """
    stack = np.empty(256, np.int64)
    stack[0] = 0
    depth, n = 1, 0
    i, j, k = axis, (axis + 1) % 3, (axis + 2) % 3
    while depth > 0:
        depth -= 1
        node = stack[depth]
        box = boxes[node]
        if (
            box[i + 3] < p[i] - err or box[j] > p[j] + err or box[j + 3] < p[j] - err
            or box[k] > p[k] + err or box[k + 3] < p[k] - err
        ):  # fmt: skip
            continue
        if links[node, 1] >= 0:
            stack[depth], stack[depth + 1] = links[node, 0], links[node, 1]
            depth += 2
            continue
        part = links[node, 0]
        if not ids[part, 1] & FACET:
            continue
        x = xyz[part]
        a0, a1, a2 = x[i] - p[i], x[j] - p[j], x[k] - p[k]
        b0, b1, b2 = x[i + 3] - p[i], x[j + 3] - p[j], x[k + 3] - p[k]
        c0, c1, c2 = x[i + 6] - p[i], x[j + 6] - p[j], x[k + 6] - p[k]
        ab, bc, ca = _side(a1, a2, b1, b2, err), _side(b1, b2, c1, c2, err), _side(c1, c2, a1, a2, err)
        if max(ab, bc, ca) > 0 and min(ab, bc, ca) < 0:
            continue
        g0, g1, g2 = cross_f(b0, b1, b2, c0, c1, c2)
        s0, s1, s2 = cross_size(b0, b1, b2, c0, c1, c2)
        det = a0 * g0 + a1 * g1 + a2 * g2
        size = (abs(a0) + abs(a1) + abs(a2)) * (abs(b0) + abs(b1) + abs(b2)) * (abs(c0) + abs(c1) + abs(c2))
        bound = DET_EPS * (abs(a0) * s0 + abs(a1) * s1 + abs(a2) * s2) + TINY
        if err > 0.0:
            r = 3.0 * err
            a, b, c = abs(a0) + abs(a1) + abs(a2) + r, abs(b0) + abs(b1) + abs(b2) + r, abs(c0) + abs(c1) + abs(c2) + r
            bound += 1.000001 * (a * b * c - size) + 1e-14 * a * b * c
        certain = ab * bc * ca != 0 and abs(det) > bound
        if certain and (det > 0.0) != (ab > 0):
            continue  # the plane is met behind the origin
        known = False
        for m in range(n):
            known = known or hits[m, 0] == ids[part, 0]
        if not known:
            if n == hits.shape[0]:
                return -1
            hits[n, 0], hits[n, 1] = ids[part, 0], 1 if certain else 0
            n += 1
    return n



def contains(solid: Polyhedron, tree: Tree, point: Vector, axis: int = 0, skip: Sequence[int] = ()) -> bool:
    """Whether the exact point lies inside the closed polyhedron.

    skip: the triangles that hold the point, if any; then what is told is whether points next to it are inside, those
    along the axis and infinitely less along the axes after it.
    Raises Undecidable where irrational poses leave it open.
    """
    p = np.array([to_double(x) if isinstance(x, fmpq) else float(x) for x in point])
    doubles = p.tolist()
    exact = all(
        isinstance(x, fmpq) and fmpq(*y.as_integer_ratio()) == x for x, y in zip(point, doubles, strict=True)
    )
    err = 2.0 * tree.error + (0.0 if exact else float(np.abs(p).max()) * 2.0**-51 + 1e-300)
    order = axis, (axis + 1) % 3, (axis + 2) % 3
    inside = False
    for triangle, certain in hits_of_ray(tree, p, axis, err).tolist():
        if triangle in skip:
            continue
        if not certain:
            corners = [point, *(solid.exact_vertex(i) for i in solid.triangles[triangle].tolist())]
            certain = _crosses(*(tuple(x[k] for k in order) for x in corners))  # type: ignore[arg-type]
        inside = inside != bool(certain)
    return inside


def hits_of_ray(tree: Tree, p: np.ndarray, axis: int, err: float) -> np.ndarray:
    """(n, 2) triangle and whether the ray certainly crosses it."""
    hits = np.empty((64, 2), np.int64)
    while (n := ray_crossings(tree.boxes, tree.links, tree.xyz, tree.ids, p, axis, err, hits)) < 0:
        hits = np.empty((4 * len(hits), 2), np.int64)
    return hits[:n]


@kernel
def parity_of_hits(high, low, err, room, first, triangles, hits, x, axis, skip):
    """`contains` of point x, with signs that are exact; first: the number of the solid's first vertex."""
    inside = False
    for n in range(hits.shape[0]):
        t = hits[n, 0]
        at = False
        for m in range(skip.shape[0]):
            at = at or skip[m] == t
        if at:
            continue
        if hits[n, 1] == 1:
            inside = not inside
            continue
        a, b, c = first + triangles[t, 0], first + triangles[t, 1], first + triangles[t, 2]
        turn = _turn_sign(high, low, err, room, axis, a, b, x)
        if turn != 0 and (
            _turn_sign(high, low, err, room, axis, b, c, x) == turn
            and _turn_sign(high, low, err, room, axis, c, a, x) == turn
            and det_sign(high, low, err, room, a, x, b, x, c, x) == turn
        ):
            inside = not inside
    return inside


@kernel
def _turn_sign(high, low, err, room, axis, q, r, x):
    """`_shifted_side` of two points seen from x along the axis, with exact signs."""
    turn = cross_sign(high, low, err, room, axis, q, x, r, x)
    if turn == 0:
        turn = order(high, low, err, room, (axis + 2) % 3, q, r)
    return turn if turn != 0 else order(high, low, err, room, (axis + 1) % 3, r, q)


def _crosses(p: Vector, a: Vector, b: Vector, c: Vector) -> bool:
    """Whether the shifted ray from p towards +x crosses the triangle; exact."""
    x, y, z = sub(a, p), sub(b, p), sub(c, p)
    turns = {_shifted_side(x, y), _shifted_side(y, z), _shifted_side(z, x)}
    if len(turns) != 1 or 0 in turns:
        return False
    return sign(dot(x, cross(y, z))) == turns.pop()


def _shifted_side(q: Vector, r: Vector) -> int:
    """Sign of the turn of (q, r) about (eps, eps^2) in the plane (y, z)."""
    for value in (q[1] * r[2] - q[2] * r[1], q[2] - r[2], r[1] - q[1]):
        s = sign(value)
        if s:
            return s
    return 0


def component_labels(body: Polyhedron) -> np.ndarray:
    """(n,) for every vertex the smallest vertex of its component."""
    return _LABELS.of(body, lambda: component_of_vertices(body.segments, len(body.vertices)))


def component_vertices(body: Polyhedron) -> list[int]:
    """One vertex of every connected component of the body."""
    def found() -> list[int]:
        used = np.zeros(len(body.vertices), bool)
        used[body.triangles.ravel()] = True
        used[body.segments.ravel()] = True
        if not used.any():
            used[:] = True
        vertices: list[int] = np.unique(component_labels(body)[used]).tolist()
        return vertices

    return _COMPONENTS.of(body, found)


def contained(a: Polyhedron, b: Polyhedron) -> tuple[str, int] | None:
    """("a", vertex) when a component of a lies inside the solid b, ("b", vertex) the other way round, or None.

    The surfaces share no point.  The answer is kept for the next motion of the same two bodies.
    Raises Undecidable.
    """
    return _CONTAINED.of(a, b, lambda: (_find_contained(a, b),))[0]


def _find_contained(a: Polyhedron, b: Polyhedron) -> tuple[str, int] | None:
    """The answer of `contained`."""
    for inner, outer, side in ((a, b, "a"), (b, a, "b")):
        if not outer.solid:
            continue
        tree, pad = tree_of(outer), outer.error + inner.error
        x0, y0, z0, x1, y1, z1 = tree.boxes[0].tolist()
        u0, v0, w0, u1, v1, w1 = tree_of(inner).boxes[0].tolist()
        if u0 > x1 + pad or v0 > y1 + pad or w0 > z1 + pad or x0 > u1 + pad or y0 > v1 + pad or z0 > w1 + pad:
            return None
        vertices, fits = component_vertices(inner), _fit_into(component_boxes(inner), component_boxes(outer), pad)
        for v in (vertices[k] for k in np.flatnonzero(fits)):
            if decide(partial(_holds, outer, tree, inner, v)):
                return side, v
    return None


def component_boxes(body: Polyhedron) -> np.ndarray:
    """(k, 6) the box of each of `component_vertices`."""
    def found() -> np.ndarray:
        labels, first = component_labels(body), np.array(component_vertices(body))
        order = np.argsort(labels, kind="stable")
        starts = np.searchsorted(labels[order], first)
        # a vertex that nothing uses is a component of its own, and ends the one before it
        ends = np.searchsorted(labels[order], first, side="right")
        places = body.vertices[order]
        cuts = np.stack([starts, ends], axis=1).ravel()
        padded = np.concatenate([places, places[-1:]])  # a cut may be the end
        low, high = (f.reduceat(padded, cuts, axis=0)[::2] for f in (np.minimum, np.maximum))
        return np.concatenate([low, high], axis=1)

    return _BOXES.of(body, found)


@kernel
def _fit_into(inner, outer, pad):
    """(k,) whether the box lies in one of `outer`: else its component is in none, for each is a closed surface.

    The others, as points with six coordinates, stand in a tree of halves; a node holds lowest lows and highest highs.
    """
    fits = np.zeros(inner.shape[0], np.bool_)
    n = outer.shape[0]
    order, keys, bounds = np.arange(n), np.empty(n), np.empty((2 * n + 1, 6))
    stack = np.empty((128, 3), np.int64)
    stack[0, 0], stack[0, 1], stack[0, 2] = 0, 0, n
    depth = 1
    while depth > 0:
        depth -= 1
        node, first, last = stack[depth]
        widest, axis = -1.0, 0
        for k in range(6):
            low, high = np.inf, -np.inf
            for i in range(first, last):
                low, high = min(low, outer[order[i], k]), max(high, outer[order[i], k])
            bounds[node, k] = low if k < 3 else high
            if high - low > widest:
                widest, axis = high - low, k
        if last - first > _LEAF:
            for i in range(first, last):
                keys[i] = outer[order[i], axis]
            select(keys, order, first, last, (first + last) // 2)
            depth = _push_halves(stack, depth, node, first, last)
    for i in range(inner.shape[0]):
        stack[0, 0], stack[0, 1], stack[0, 2] = 0, 0, n
        depth = 1
        while depth > 0 and not fits[i]:
            depth -= 1
            node, first, last = stack[depth]
            if not _fits(inner[i], bounds[node], pad):
                continue
            if last - first > _LEAF:
                depth = _push_halves(stack, depth, node, first, last)
                continue
            for k in range(first, last):
                fits[i] = fits[i] or _fits(inner[i], outer[order[k]], pad)
    return fits


@uncounted
def _push_halves(stack, depth, node, first, last):
    middle = (first + last) // 2
    stack[depth, 0], stack[depth, 1], stack[depth, 2] = 2 * node + 1, first, middle
    stack[depth + 1, 0], stack[depth + 1, 1], stack[depth + 1, 2] = 2 * node + 2, middle, last
    return depth + 2


@uncounted
def _fits(x, y, pad):
    for k in range(3):
        if y[k] > x[k] + pad or y[k + 3] < x[k + 3] - pad:
            return False
    return True


class Posed(Protocol[At_contra]):
    """Two bodies under a motion with instants of one kind."""

    a: Polyhedron
    b: Polyhedron

    def pose_between(self, x: At_contra, y: At_contra, /) -> Matrix: ...


def contained_at(problem: Posed[At], left: At, right: At) -> bool:
    """Whether one body lies inside the other at a time between two instants without surface contact.

    Raises Undecidable.
    """
    a, b = problem.a, problem.b
    pose = problem.pose_between(left, right)
    back = inverse_map(pose)
    for inner, outer, to_outer in ((a, b, pose), (b, a, back)):
        if not outer.solid:
            continue
        tree = tree_of(outer)
        for v in component_vertices(inner):
            if decide(partial(_holds, outer, tree, inner, v, to_outer)):
                return True
    return False


def _holds(outer: Polyhedron, tree: Tree, inner: Polyhedron, vertex: int, to_outer: Matrix = IDENTITY) -> bool:
    """Whether the vertex of the inner body, in the pose given, is in the outer one; at the present precision."""
    place = inner.exact_vertex(vertex)
    return contains(outer, tree, place if to_outer is IDENTITY else apply(to_outer, place))


def decide(question: Callable[[], T]) -> T:
    """The answer at the first precision that decides it; Undecidable behind the last."""
    for bits in PRECISIONS:
        with precision(bits):
            try:
                return question()
            except Undecidable:
                continue
    raise Undecidable
