"""What two models share where they touch along something flat: a segment, an arc, or a patch of a plane.

For bodies that keep their directions.  Whether flat things are parallel is then decided exactly, from their carriers;
they touch, so parallel ones lie in one line or plane, and doubles measure what both hold of it.  Doubles answer only
where every point they judge is clear of all surfaces but its own; all else is left to exact arithmetic (None).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

import numpy as np
from flint import fmpq_mat

from firstcontact.body.carriers import Conic, Line, Plane, QuarticCurve, Vector, cross, dot
from firstcontact.body.composite_quadric import CompositeQuadric
from firstcontact.body.csg import And, Leaf, Not, Tree, inside
from firstcontact.body.features import Edge, Face, Vertex
from firstcontact.body.moving import Moving
from firstcontact.composite.contact_sets import SAMPLES, runs
from firstcontact.composite.touched import Flat, Point
from firstcontact.motion import sequence
from firstcontact.motion.translation import Translation

CLEAR = 1e-7
"""Of the size of its terms: a form smaller than that may vanish in truth."""

IN, OUT = 1, 2

Feature = Face | Edge | Vertex
Pair = tuple[Feature, Feature, Point]
"""A feature of a, one of b, and a point at which they meet, world."""


@dataclass(frozen=True)
class Shared:
    """kind and points as in `ContactSet`; pairs: all features that meet in it, as exact arithmetic lists them."""

    kind: str
    points: np.ndarray
    pairs: list[Pair]


class _Unclear(Exception):
    """A point too near another surface, or a shape that is not described here."""


def keeps_directions(body: Any) -> bool:
    """Whether the body only shifts."""
    if not isinstance(body, Moving) or isinstance(body.motion, Translation):
        return True
    steps = body.motion.steps if isinstance(body.motion, sequence.Sequence) else ()
    return len(steps) > 0 and all(isinstance(step, Translation) for step in steps)


def shared_set(
    models: tuple[CompositeQuadric, CompositeQuadric],
    shifts: tuple[Point, Point],
    flats: tuple[list[Flat], list[Flat]],
    where: Point,
    also: Sequence[tuple[set[int], set[int]]] | None = None,
) -> Shared | None:
    """The contact set at the touched point `where`, of models shifted so; None where doubles do not tell.

    also: the surfaces of either that touch elsewhere then; None where that is not known, but for convex models.
    """
    try:
        bodies = _Body(models[0], shifts[0]), _Body(models[1], shifts[1])
        pair = _parallel(*flats)
        if pair is None or (also is None and not (bodies[0].is_meet and bodies[1].is_meet)):
            return None
        x, y = pair
        if not all(_on(x) <= on_a and _on(y) <= on_b for on_a, on_b in also or ()):
            return None
        if x.direction is None and y.direction is None:
            return _in_plane(bodies, x.feature, y.feature)
        if also:
            return None
        line = y if x.direction is None else x
        direction = _tangent(line, y if line is x else x) if line.exact is None else line.exact
        return _in_line(bodies, (x, y), where, _unit(direction))
    except _Unclear:
        return None


# -- what is parallel -----------------------------------------------------------------------------------------


def _parallel(a: list[Flat], b: list[Flat]) -> tuple[Flat, Flat] | None:
    """The one pair of flat things that may touch in more than a point, exactly parallel; None: not exactly one.

    Planes count before the lines in them.
    """
    planes_a, planes_b = ([f for f in side if f.direction is None] for side in (a, b))
    found = [(x, y) for x in planes_a or a for y in planes_b or b]
    parallel = [pair for pair in found if _is_parallel(*pair)]
    return parallel[0] if len(parallel) == 1 else None


def _is_parallel(x: Flat, y: Flat) -> bool:
    if x.direction is None and y.direction is None:
        return x.exact is not None and y.exact is not None and not any(cross(x.exact, y.exact))
    if x.direction is None or y.direction is None:
        plane, line = (x, y) if x.direction is None else (y, x)
        if plane.exact is None:
            return False
        return dot(plane.exact, _tangent(line, plane) if line.exact is None else line.exact) == 0
    if x.exact is None or y.exact is None:
        return False
    return not any(cross(x.exact, y.exact))


def _tangent(cone: Flat, plane: Flat) -> Vector:
    """The direction of the cone's ruling that planes parallel to this one touch, if they touch any."""
    if plane.exact is None or plane.direction is not None or not isinstance(cone.feature, Face):
        raise _Unclear
    form = cone.feature.carrier.matrix()
    normal = fmpq_mat([[x] for x in plane.exact])
    return tuple(row[0] for row in fmpq_mat([list(row[:3]) for row in form[:3]]).solve(normal).tolist())


def _unit(exact: Vector) -> Point:
    size = max(abs(x) for x in exact)
    x, y, z = (float((v / size).p) / float((v / size).q) for v in exact)
    length = math.sqrt(x * x + y * y + z * z)
    return x / length, y / length, z / length


# -- a model in doubles ---------------------------------------------------------------------------------------


class _Body:
    """A model, shifted."""

    def __init__(self, model: CompositeQuadric, shift: Point) -> None:
        self.model, self.shift = model, shift
        self.forms = _forms(model)
        self.is_meet = _is_meet(model.tree)

    def local(self, p: Point) -> Point:
        s = self.shift
        return p[0] - s[0], p[1] - s[1], p[2] - s[2]

    def world(self, p: Any) -> Point:
        s = self.shift
        return p[0] + s[0], p[1] + s[1], p[2] + s[2]

    def holds(self, p: Point, on: frozenset[int]) -> bool:
        """Whether a world point is in the model, given the surfaces that hold it.  Raises _Unclear near others."""
        if not self.is_meet:
            return self._bounds(p, on)
        x, y, z = self.local(p)
        for k, form in enumerate(self.forms):
            if k in on:
                continue
            value, size = _value(form, x, y, z)
            if abs(value) <= CLEAR * size:
                raise _Unclear
            if value > 0.0:
                return False
        return True


    def _bounds(self, p: Point, on: frozenset[int]) -> bool:
        """The same for any tree: whether either side of the surfaces that hold the point makes a difference.

        Nothing touches a point inside at a first contact: that is unclear, too.
        """
        x = self.local(p)
        if self.is_far(x):
            return False
        known: dict[int, int] = {}
        seen = 0
        for choice in product((IN, OUT), repeat=len(on)):
            known.update(zip(on, choice, strict=True))
            found = self._sides(self.model.tree, x, known)
            if found == IN | OUT:
                raise _Unclear
            seen |= found
        if seen == IN:
            raise _Unclear
        return seen == IN | OUT

    def _sides(self, tree: Tree, x: Point, known: dict[int, int]) -> int:
        """IN, OUT or both where the signs of forms leave that open; the sides of forms are kept."""
        if isinstance(tree, Leaf):
            found = known.get(tree.surface)
            if found is None:
                value, size = _value(self.forms[tree.surface], *x)
                found = known[tree.surface] = IN * (value <= CLEAR * size) + OUT * (value >= -CLEAR * size)
            return found
        if isinstance(tree, Not):
            found = self._sides(tree.inner, x, known)
            return IN * (found >= OUT) + OUT * (found & IN)
        settled = OUT if isinstance(tree, And) else IN
        first = self._sides(tree.first, x, known)
        if first == settled:
            return settled
        second = self._sides(tree.second, x, known)
        return ((first | second) & settled) | (first & second & (IN + OUT - settled))

    def is_far(self, x: Point) -> bool:
        """Whether a local point is clear of the model's box."""
        known = self.model._search.get("box")
        if known is None:
            low, high = self.model.bounds()
            off = 10.0 * CLEAR * (1.0 + max(np.abs(low).max(), np.abs(high).max()))
            known = self.model._search["box"] = (low - off).tolist(), (high + off).tolist()
        return any(c < p or c > q for c, p, q in zip(x, *known, strict=True))


Form = tuple[float, ...]


def _forms(model: CompositeQuadric) -> list[Form]:
    """xx, yy, zz, 2 xy, 2 xz, 2 yz, 2 x, 2 y, 2 z, 1 of every surface, negative inside."""
    known = model._search.get("half-spaces")
    if known is None:
        known = model._search["half-spaces"] = [_form(m) for m in model._forms_f.tolist()]
    return known


def _form(m: list[list[float]]) -> Form:
    twice = [2.0 * x for x in (m[0][1], m[0][2], m[1][2], m[0][3], m[1][3], m[2][3])]
    return (m[0][0], m[1][1], m[2][2], *twice, m[3][3])


def _is_meet(tree: Tree) -> bool:
    """Whether the solid is where all its forms are negative."""
    return _is_meet(tree.first) and _is_meet(tree.second) if isinstance(tree, And) else isinstance(tree, Leaf)


def _value(f: Form, x: float, y: float, z: float) -> tuple[float, float]:
    """(value, sum of the sizes of its terms)."""
    a, b, c = f[0] * x * x, f[1] * y * y, f[2] * z * z
    d, e, g = f[3] * x * y, f[4] * x * z, f[5] * y * z
    p, q, r = f[6] * x, f[7] * y, f[8] * z
    size = abs(a) + abs(b) + abs(c) + abs(d) + abs(e) + abs(g) + abs(p) + abs(q) + abs(r) + abs(f[9])
    return a + b + c + d + e + g + p + q + r + f[9], size


def _roots(f: Form, o: Point, d: Point) -> list[float]:
    """The s at which o + s d crosses the surface; both ends of what a tangent line shares would be unclear."""
    value, size = _value(f, *o)
    x, y, z = d
    a = f[0] * x * x + f[1] * y * y + f[2] * z * z + f[3] * x * y + f[4] * x * z + f[5] * y * z
    b = (
        2.0 * (f[0] * o[0] * x + f[1] * o[1] * y + f[2] * o[2] * z)
        + f[3] * (o[0] * y + o[1] * x) + f[4] * (o[0] * z + o[2] * x) + f[5] * (o[1] * z + o[2] * y)
        + f[6] * x + f[7] * y + f[8] * z
    )  # fmt: skip
    largest = max(map(abs, f[:9]))
    if abs(a) <= 1e-13 * largest:
        if abs(b) > 1e-13 * (largest + size):
            return [-value / b]
        if abs(value) <= CLEAR * size:
            raise _Unclear
        return []
    square = b * b - 4.0 * a * value
    if abs(square) <= CLEAR * (b * b + abs(4.0 * a * value)):
        raise _Unclear
    if square < 0.0:
        return []
    q = -0.5 * (b + math.copysign(math.sqrt(square), b))
    return [q / a, value / q] if q else [0.0]


# -- lines ----------------------------------------------------------------------------------------------------


def _on(flat: Flat) -> frozenset[int]:
    return frozenset(flat.feature.surfaces)


def _in_line(bodies: tuple[_Body, _Body], flats: tuple[Flat, Flat], where: Point, d: Point) -> Shared | None:
    """The segment of the line through the touched point that both bodies hold."""
    on = _on(flats[0]), _on(flats[1])
    breaks = [
        (s, side, k)
        for side, body in enumerate(bodies)
        for k, form in enumerate(body.forms) if k not in on[side]
        for s in _roots(form, body.local(where), d)
    ]  # fmt: skip
    breaks.sort()
    size = 1.0 + max(map(abs, where))
    shared: list[tuple[Any, Any]] = []
    for lo, hi in zip(breaks, breaks[1:], strict=False):
        if hi[0] - lo[0] <= CLEAR * size:
            continue
        middle = _along(where, 0.5 * (lo[0] + hi[0]), d)
        if bodies[0].holds(middle, on[0]) and bodies[1].holds(middle, on[1]):
            if shared and shared[-1][1] is lo:  # a surface that bounds nothing here
                lo = shared.pop()[0]
            shared.append((lo, hi))
    if len(shared) != 1 or not shared[0][0][0] - CLEAR * size <= 0.0 <= shared[0][1][0] + CLEAR * size:
        return None
    lo, hi = shared[0]
    if any(abs(other[0] - end[0]) <= CLEAR * size for end in (lo, hi) for other in breaks if other is not end):
        return None
    ends = [_along(where, lo[0], d), _along(where, hi[0], d)]
    pairs = [*_end_pairs(bodies, flats, ends[0], *lo[1:]), *_end_pairs(bodies, flats, ends[1], *hi[1:])]
    x, y = flats[0].feature, flats[1].feature
    if all(isinstance(f, Face) and not _is_plane(f) for f in (x, y)):
        pairs.append((x, y, _along(where, 0.5 * (lo[0] + hi[0]), d)))
    return Shared("segment", np.array(ends), pairs)


def _is_plane(feature: Feature) -> bool:
    return isinstance(feature, Face) and isinstance(feature.carrier, Plane)


def _along(p: Point, s: float, d: Point) -> Point:
    return p[0] + s * d[0], p[1] + s * d[1], p[2] + s * d[2]


def _end_pairs(
    bodies: tuple[_Body, _Body], flats: tuple[Flat, Flat], end: Point, side: int, surface: int
) -> Iterator[Pair]:
    """The pairs that meet at an end of the segment, where the flat of one side ends at one more of its surfaces."""
    mine, other = flats[side].feature, flats[1 - side].feature
    model = bodies[side].model
    corner = _boundary(bodies[side], mine, surface, end)
    found: list[tuple[Feature, Feature]]
    if isinstance(corner, Vertex) and isinstance(other, Edge):
        found = [(corner, bodies[1 - side].model.faces[k]) for k in other.faces]
        beside = [e for e in model.edges if set(e.surfaces) <= set(corner.surfaces) and e is not mine]
        found += [(e, other) for e in beside]
    else:
        found = [(corner, other)]
    for x, y in found:
        yield (x, y, end) if side == 0 else (y, x, end)


def _boundary(body: _Body, feature: Feature, surface: int, end: Point) -> Edge | Vertex:
    """The edge or vertex where a flat feature ends at that surface."""
    around = {*feature.surfaces, surface}
    near = CLEAR * (1.0 + max(map(abs, end)))
    x = body.local(end)
    at_surface = [v for v in body.model.vertices if around <= set(v.surfaces)]
    vertices = [v for v in at_surface if max(map(abs, _minus(v.position, x))) < near]
    edges = [e for e in body.model.edges if around == set(e.surfaces) and not isinstance(e.carrier, QuarticCurve)]
    if len(vertices) == 1 and (isinstance(feature, Edge) or not edges):
        return vertices[0]
    if vertices or len(edges) != 1 or isinstance(feature, Edge):
        raise _Unclear
    return edges[0]


# -- planes ---------------------------------------------------------------------------------------------------


def _in_plane(bodies: tuple[_Body, _Body], x: Feature, y: Feature) -> Shared | None:
    """What two faces share that lie in one plane: the patch by its corners, or the arcs that bound it."""
    assert isinstance(x, Face) and isinstance(y, Face) and isinstance(x.carrier, Plane)
    (a, b), on = bodies, (frozenset(x.surfaces), frozenset(y.surfaces))
    own, others = _outline(a, x), _outline(b, y)
    sizes = [abs(c) for c in x.carrier.normal[:3]]
    flat = sizes.index(max(sizes))
    i, j = (flat + 1) % 3, (flat + 2) % 3
    pairs: list[Pair] = [(v, y, p) for v, p in own.corners if b.holds(p, on[1])]
    pairs += [(x, v, p) for v, p in others.corners if a.holds(p, on[0])]
    for e, p, q in own.sides:
        for f, r, s in others.sides:
            share = _crossing(p[i], p[j], q[i], q[j], r[i], r[j], s[i], s[j])
            if share is not None:
                pairs.append((e, f, _between(p, q, share)))
        pairs += [(e, f, r) for f in others.rims for r in _through(b, f, on[1], p, q)]
    for f, p, q in others.sides:
        pairs += [(e, f, r) for e in own.rims for r in _through(a, e, on[0], p, q)]
    arcs: list[tuple[Feature, Feature, np.ndarray]]
    arcs = [(x, f, run) for f in others.rims if not own.is_far(f, others) for run in _arcs(b, f, a, on[0])]
    arcs += [(e, y, run) for e in own.rims if not others.is_far(e, own) for run in _arcs(a, e, b, on[1])]
    if arcs:
        pairs += [(e, f, tuple(run[len(run) // 2].tolist())) for e, f, run in arcs]
        return Shared("conic arc", arcs[0][2], pairs)
    points = [p for _, _, p in pairs]
    return Shared("patch", np.array(points), pairs) if _spread(points) else None


def _spread(points: list[Point]) -> bool:
    """Whether three of the points are the corners of a proper triangle."""
    for x, y, z in combinations(points[:12], 3):
        d, e = _minus(y, x), _minus(z, x)
        if max(map(abs, cross(d, e))) > CLEAR * max(dot(d, d), dot(e, e)):
            return True
    return False


def _minus(p: Point, q: Point) -> Point:
    return p[0] - q[0], p[1] - q[1], p[2] - q[2]


def _between(p: Point, q: Point, share: float) -> Point:
    return _along(p, share, _minus(q, p))


@dataclass(frozen=True)
class _Outline:
    """The boundary of a plane face: corners with their points, straight sides with both ends, round rims.

    boxes: around the rims, by their numbers, and around all of it, local: (low, high corner); shift: to the world.
    """

    corners: list[tuple[Vertex, Point]]
    sides: list[tuple[Edge, Point, Point]]
    rims: list[Edge]
    boxes: dict[int | None, np.ndarray]
    shift: Point = (0.0, 0.0, 0.0)

    def is_far(self, rim: Edge, other: _Outline) -> bool:
        """Whether a rim of the other outline is clear of this one."""
        lo, hi = other.boxes[rim.index] + np.subtract(other.shift, self.shift)
        low, high = self.boxes[None]
        off = 10.0 * CLEAR * (1.0 + max(np.abs(lo).max(), np.abs(hi).max()))
        return bool(np.any(hi < low - off) or np.any(lo > high + off))


def _outline(body: _Body, face: Face) -> _Outline:
    """In the world; its local form is kept on the model."""
    known = body.model._search.setdefault("outlines", {})
    outline = known.get(face.index)
    if outline is None:
        outline = known[face.index] = _local_outline(body.model, face)
    world = body.world
    return _Outline(
        [(v, world(p)) for v, p in outline.corners], [(e, world(p), world(q)) for e, p, q in outline.sides],
        outline.rims, outline.boxes, body.shift,
    )  # fmt: skip


def _local_outline(model: CompositeQuadric, face: Face) -> _Outline:
    (surface,) = face.surfaces
    outline, vertices = _Outline([], [], [], {}), model.vertices
    corners: dict[int, tuple[Vertex, Point]] = {}
    for edge in model.edges:
        if surface not in edge.surfaces or edge.convexity == "reentrant":  # nothing touches those alone
            continue
        ends = {k for piece in edge.pieces for k in (piece.start, piece.end) if k is not None}
        corners |= {k: (vertices[k], vertices[k].position) for k in ends}
        if isinstance(edge.carrier, Conic) and edge.frame.shape[1] == 3 and not edge.frame[3, 1:].any():
            outline.rims.append(edge)
            outline.boxes[edge.index] = _box_around(edge)
        elif isinstance(edge.carrier, Line) and len(edge.pieces) == 1 and len(ends) == 2:
            start, end = edge.pieces[0].start, edge.pieces[0].end
            assert start is not None and end is not None
            outline.sides.append((edge, vertices[start].position, vertices[end].position))
        else:
            raise _Unclear
        if not _is_meet(model.tree) and _runs_on(model, edge):
            raise _Unclear
    outline.corners.extend(corners.values())
    parts = [*outline.boxes.values(), *(np.array([p, p]) for _, p in outline.corners)]
    low, high = np.full(3, -np.inf), np.full(3, np.inf)
    if parts:
        low, high = np.min([lo for lo, _ in parts], axis=0), np.max([hi for _, hi in parts], axis=0)
    outline.boxes[None] = np.array([low, high])
    return outline


def _box_around(rim: Edge) -> np.ndarray:
    frame = rim.frame[:3] / rim.frame[3, 0]
    reach = np.abs(frame[:, 1:]).sum(axis=1)
    return np.array([frame[:, 0] - reach, frame[:, 0] + reach])


def _runs_on(model: CompositeQuadric, edge: Edge) -> bool:
    """Whether the edge's line or conic lies on the model beyond its pieces, as at a reentrant corner of a face.

    Exact arithmetic counts what touches it there as touching the edge.
    """
    body, on = _Body(model, (0.0, 0.0, 0.0)), frozenset(edge.surfaces)
    if isinstance(edge.carrier, Conic):
        angles = np.linspace(0.0, 2.0 * np.pi, SAMPLES // 8, endpoint=False)
        bare = angles[~_in_pieces(edge, angles)]
    else:
        (dx, px), (dy, py), (dz, pz), _ = edge.frame.tolist()
        ends = sorted(
            s for k, form in enumerate(body.forms) if k not in on for s in _roots(form, (px, py, pz), (dx, dy, dz))
        )
        middles = np.array([0.5 * (lo + hi) for lo, hi in zip(ends, ends[1:], strict=False) if hi - lo > CLEAR])
        bare = middles[~np.any([(p.lo <= middles) & (middles <= p.hi) for p in edge.pieces], axis=0)]
    return any(body.holds((x, y, z), on) for x, y, z in edge.points(bare).tolist())


def _in_pieces(edge: Edge, angles: np.ndarray) -> np.ndarray:
    return np.any([(angles - p.lo) % (2.0 * np.pi) <= p.hi - p.lo for p in edge.pieces], axis=0)


def _crossing(
    px: float, py: float, qx: float, qy: float, rx: float, ry: float, sx: float, sy: float
) -> float | None:
    """The share of pq at which it crosses rs, both in a plane.  Raises _Unclear for what ends on the other."""
    dx, dy, ex, ey, wx, wy = qx - px, qy - py, sx - rx, sy - ry, rx - px, ry - py
    d, n = abs(dx) + abs(dy), dx * ey - dy * ex
    if abs(n) <= CLEAR * d * (abs(ex) + abs(ey)):
        if abs(wx * dy - wy * dx) <= CLEAR * d * (abs(wx) + abs(wy) + d):
            raise _Unclear
        return None
    share, other = (wx * ey - wy * ex) / n, (wx * dy - wy * dx) / n
    if not (-CLEAR < share < 1.0 + CLEAR and -CLEAR < other < 1.0 + CLEAR):
        return None
    if min(share, 1.0 - share, other, 1.0 - other) < CLEAR:
        raise _Unclear
    return share


def _through(body: _Body, rim: Edge, on: frozenset[int], p: Point, q: Point) -> list[Point]:
    """Where the side pq of the other's face passes through a rim of this body's face."""
    (surface,) = set(rim.surfaces) - on
    d = _minus(q, p)
    found = []
    for s in _roots(body.forms[surface], body.local(p), d):
        if min(abs(s), abs(1.0 - s)) <= CLEAR:
            raise _Unclear
        point = _along(p, s, d)
        if 0.0 < s < 1.0 and body.holds(point, on | {surface}):
            found.append(point)
    return found


def _arcs(body: _Body, rim: Edge, other: _Body, on: frozenset[int]) -> list[np.ndarray]:
    """The parts (n, 3) of a rim of one body that the other one's face holds, sampled."""
    angles = np.linspace(0.0, 2.0 * np.pi, SAMPLES, endpoint=False)
    points = rim.points(angles) + body.shift
    good = _in_pieces(rim, angles)
    x, y, z = (points - other.shift).T
    negative: list[Any] = [_value(form, x, y, z)[0] < 0.0 for form in other.forms]  # type: ignore[arg-type]
    either = []
    for choice in product((True, False), repeat=len(on)):
        for k, side in zip(on, choice, strict=True):
            negative[k] = np.full(SAMPLES, side)
        either.append(inside(other.model.tree, negative))
    return [points[run] for run in runs(good & np.any(either, axis=0) & ~np.all(either, axis=0))]
