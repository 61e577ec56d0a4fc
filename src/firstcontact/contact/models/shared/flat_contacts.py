"""What two models share where they touch along something flat: a segment, an arc, or a patch of a plane.

For bodies that keep directions.  Whether flat things are parallel is then decided exactly, from their carriers; they
touch, so parallel ones lie in one line or plane, and doubles measure what both hold of it.  Doubles answer only
where every point they judge is clear of all surfaces but its own; all else is left to exact arithmetic (None).
"""

from __future__ import annotations

import math
from collections.abc import Sequence as Listing
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import chain, combinations, product
from typing import Any

import numpy as np
from flint import fmpq_mat

from firstcontact.body.kept import Kept
from firstcontact.body.solid.carriers import (
    Conic,
    Line,
    Plane,
    QuarticCurve,
    dot,
    inertia,
    null_space,
    restricted,
    transposed,
)
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.csg import And, Leaf, Not, Or, Tree, inside
from firstcontact.body.solid.features import Edge, Face, Vertex
from firstcontact.contact.models.forms import Form, forms_of, value
from firstcontact.contact.models.kept_directions import Axis, stay_parallel
from firstcontact.contact.models.shared.patches import beside, border
from firstcontact.contact.models.shared.touched import Flat, Flats, Point, coprime, is_parallel
from firstcontact.exact.vectors import along, cross, sub
from firstcontact.search.convex.convex import NotConvex, convex_pieces

CLEAR = 1e-7
"""Of the size of its terms: a form smaller than that may vanish in truth."""

SAMPLES = 720
"""Points of a rim looked at."""
MOST_PLANS = 256
"""Kept of a model: turning ones meet lines in ever new directions."""

UPRIGHT = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
IN, OUT = 1, 2
UNCLEAR = -1
"""Numbers from this one down: parts of a boundary at which more may touch than is told here."""

Feature = Face | Edge | Vertex
_SHAPE = Kept["_Shape"]()
_WIDENED_BOX = Kept[tuple[list[float], list[float]]]()
_AT_SURFACES = Kept[dict[tuple[Feature, int], tuple[list[Face], list[Vertex], list[Edge]]]]()
_ONE_SIDED = Kept[dict[Feature, frozenset[int]]]()
_OUTLINES = Kept[dict[Face, "_Outline"]]()
Pair = tuple[Feature, Feature, Point]
"""A feature of a, one of b, and a point at which they meet, world."""


@dataclass(slots=True)
class FlatShared:
    """kind and points as for `ContactSet`; pairs: all features that meet in it, as exact arithmetic lists them."""

    kind: str
    points: Listing[Point] | np.ndarray
    pairs: list[Pair]


class _Unclear(Exception):
    """A point too near another surface, or a shape that is not described here."""


def shared_set(
    models: tuple[CompositeQuadric, CompositeQuadric],
    poses: tuple[list[float], list[float]],
    flats: tuple[Flats, Flats],
    where: Point,
    axes: frozenset[Axis],
    also: Listing[tuple[frozenset[int], frozenset[int]]] | None = None,
) -> FlatShared | None:
    """The contact set at the touched point `where`, of models in such poses; None where doubles do not tell.

    poses: R by rows, T; axes: one that all turns are about, none where both only shift.
    also: the surfaces of either that touch elsewhere then; None where that is not known, but for convex models.
    """
    try:
        a, b = bodies = _Body(models[0], poses[0], bool(axes)), _Body(models[1], poses[1], bool(axes))
        pair = _parallel(*flats, axes)
        if pair is None or (also is None and not (a.shape.pieces and b.shape.pieces)):
            return None
        x, y = pair
        if also and not all(_on(x) <= on_a and _on(y) <= on_b for on_a, on_b in also):
            return None
        if x.direction is None and y.direction is None:
            return _in_plane(bodies, x.feature, y.feature)
        # what both surfaces hold is one line: whatever touches in them does so there
        line, own = (y, b) if x.direction is None else (x, a)
        direction = _tangent(line, y if line is x else x) if line.exact is None else line.exact
        return _in_line(bodies, (x, y), where, own.turned(_unit(direction)))
    except _Unclear:
        return None


# -- what is parallel -----------------------------------------------------------------------------------------


def _parallel(a: Flats, b: Flats, axes: frozenset[Axis]) -> tuple[Flat, Flat] | None:
    """The one pair of flat things that may touch in more than a point, exactly parallel; None: not exactly one.

    Planes count before the lines in them.
    """
    planes_a = [f for f in a if f[1] is None]
    planes_b = [f for f in b if f[1] is None]
    pairs = [(x, y) for x in planes_a or a for y in planes_b or b]
    if not axes:
        parallel = [(x, y) for (x, _), (y, _) in pairs if _is_parallel(x, y)]
        return parallel[0] if len(parallel) == 1 else None
    # of turning bodies what seems parallel may be so
    near = [(x, y) for (x, d), (y, e) in pairs if d is None or e is None or is_parallel(d, e)]
    (axis,) = axes
    return near[0] if len(near) == 1 and stay_parallel(*near[0], axis) else None


def _is_parallel(x: Flat, y: Flat) -> bool:
    if (x.direction is None) == (y.direction is None):
        return x.exact is not None and x.exact == y.exact
    plane, line = (x, y) if x.direction is None else (y, x)
    if plane.exact is None:
        return False
    across: bool = dot(plane.exact, _tangent(line, plane) if line.exact is None else line.exact) == 0
    return across


def _tangent(cone: Flat, plane: Flat) -> tuple[int, ...]:
    """The direction of the cone's ruling that planes parallel to this one touch, if they touch any."""
    if plane.exact is None or plane.direction is not None or not isinstance(cone.feature, Face):
        raise _Unclear
    form = cone.feature.carrier.matrix()
    normal = fmpq_mat([[x] for x in plane.exact])
    return coprime(row[0] for row in fmpq_mat([list(row[:3]) for row in form[:3]]).solve(normal).tolist())


@lru_cache(maxsize=256)
def _unit(exact: tuple[int, ...]) -> Point:
    size = max(map(abs, exact))
    x, y, z = (v / size for v in exact)
    length = math.sqrt(x * x + y * y + z * z)
    return x / length, y / length, z / length


# -- a model in doubles ---------------------------------------------------------------------------------------


End = tuple[float, int]
"""Where a line passes a surface, and the number of that."""
_Plan = list[tuple[int, Form, float | None]]
"""What bounds a line in a piece: number of the surface, its form (of planes x, y, z, 1) and its slope along the line,
None if it is no plane."""


@dataclass(frozen=True)
class _Shape:
    """The forms of a model's surfaces, and of a convex one its pieces: where all forms of these numbers are negative.

    plans: see `plan`.
    """

    model: CompositeQuadric
    forms: list[Form]
    pieces: list[frozenset[int]]
    plans: dict[tuple[Feature, Point], tuple[list[_Plan], bool]]

    def plan(self, feature: Feature, d: Point) -> tuple[list[_Plan], bool]:
        """The pieces that lines along d in a feature's surfaces may pass through; whether it is one, and the lines
        pass planes alone, none of them nearly parallel."""
        known = self.plans.get((feature, d))
        if known is None:
            if len(self.plans) >= MOST_PLANS:
                self.plans.clear()
            tangent, on = _tangent_surfaces(self.model, feature), set(feature.surfaces)
            plans = [[self._step(k, d) for k in sorted(piece - on)] for piece in self.pieces if not piece & tangent]
            plain = len(plans) == 1 and all(_is_plain(form, slope) for _, form, slope in plans[0])
            known = self.plans[feature, d] = plans, plain
        return known

    def _step(self, k: int, d: Point) -> tuple[int, Form, float | None]:
        form = self.forms[k]
        if any(form[:6]):
            return k, form, None
        slope = form[6] * d[0] + form[7] * d[1] + form[8] * d[2]
        return k, form[6:], slope if abs(slope) > 1e-13 * max(map(abs, form[6:9])) else 0.0


def _is_plain(form: Form, slope: float | None) -> bool:
    return slope is not None and (slope == 0.0 or abs(slope) > CLEAR * max(map(abs, form[:3])))


def _shape(model: CompositeQuadric) -> _Shape:
    return _SHAPE.of(
        model, lambda: _Shape(model, forms_of(model), _pieces(model.tree) if _is_convex(model) else [], {})
    )


def _is_convex(model: CompositeQuadric) -> bool:
    """Convex models have one piece, or one union of all."""
    if len(_pieces(model.tree)) == 1:
        return True
    try:
        return convex_pieces(model).union is not None
    except NotConvex:
        return False


def _pieces(tree: Tree) -> list[frozenset[int]]:
    """The tree as a union of intersections of its leaves; none where it takes complements."""
    if isinstance(tree, Leaf):
        return [frozenset([tree.surface])]
    if isinstance(tree, Not):
        return []
    first, second = _pieces(tree.first), _pieces(tree.second)
    if not (first and second):
        return []
    return first + second if isinstance(tree, Or) else [x | y for x in first for y in second]


def _tangent_surfaces(model: CompositeQuadric, feature: Feature) -> frozenset[int]:
    """Surfaces that a line in the face does not pass through, since they join it smoothly.

    Two quadrics tangent along a conic have a member of rank 1 in their pencil: on either the other one's form is a
    multiple of the square of a plane's.
    """
    if not isinstance(feature, Face):
        return frozenset()
    return frozenset(
        face.surfaces[0]
        for seam in model.seams if isinstance(seam.carrier, Conic) and seam.frame.shape[1] == 3
        for face in _joined(model, seam, feature) if not _is_plane(face)
    )  # fmt: skip


def _joined(model: CompositeQuadric, seam: Edge, face: Face) -> list[Face]:
    """The other faces at a seam of the face."""
    return [model.faces[k] for k in seam.faces if k != face.index] if face.index in seam.faces else []


class _Body:
    """A model in a pose.

    turn: the rows of its rotation, () where it has not turned.
    """

    __slots__ = ("forms", "model", "shape", "shift", "turn")

    def __init__(self, model: CompositeQuadric, pose: list[float], turns: bool) -> None:
        self.model, self.shift = model, (pose[9], pose[10], pose[11])
        turned = turns and pose[:9] != UPRIGHT
        self.turn = (tuple(pose[0:3]), tuple(pose[3:6]), tuple(pose[6:9])) if turned else ()
        self.shape = _shape(model)
        self.forms = self.shape.forms

    def local(self, p: Any) -> Any:
        """A world point, or the three rows of such, in the frame of the model."""
        s = self.shift
        p = p[0] - s[0], p[1] - s[1], p[2] - s[2]
        return self.back(p) if self.turn else p

    def world(self, p: Any) -> Any:
        s, (x, y, z) = self.shift, self.turned(p)
        return x + s[0], y + s[1], z + s[2]

    def turned(self, d: Point) -> Point:
        """A direction of the model's frame in the world."""
        if not self.turn:
            return d
        x, y, z = d
        p, q, r = (a * x + b * y + c * z for a, b, c in self.turn)
        return p, q, r

    def back(self, d: Any) -> Any:
        """A direction of the world in the model's frame."""
        if not self.turn:
            return d
        (a, b, c), (e, f, g), (p, q, r) = self.turn
        x, y, z = d
        return a * x + e * y + p * z, b * x + f * y + q * z, c * x + g * y + r * z

    def holds(self, p: Point, on: frozenset[int]) -> bool:
        """Whether a world point is in the model, given the surfaces that hold it.  Raises _Unclear near others."""
        if not self.shape.pieces:
            return self._bounds(p, on)
        local = self.local(p)
        judged = [self._in_piece(piece, local, on) for piece in self.shape.pieces]
        if True in judged:
            return True
        if None in judged:
            raise _Unclear
        return False

    def _in_piece(self, piece: frozenset[int], p: Point, on: frozenset[int]) -> bool | None:
        inside: bool | None = True
        for k in piece - on:
            v, size = value(self.forms[k], *p)
            if v > CLEAR * size:
                return False
            if v >= -CLEAR * size:
                inside = None
        return inside

    def stretch(self, where: Point, d: Point, feature: Feature, near: float) -> tuple[End, End] | None:
        """Where a line in the feature's surfaces, through a world point along d, enters the model and leaves it."""
        p = self.local(where)
        d = self.back(d) if self.turn else d
        found = []
        for plan in self.shape.plan(feature, d)[0]:
            ends = self._passed(plan, p, d, near)
            if ends is not None:
                found.append(ends)
        if len(found) < 2:
            return found[0] if found else None
        return _last([lo for lo, _ in found], -1.0, near), _last([hi for _, hi in found], 1.0, near)

    def _passed(self, plan: _Plan, p: Point, d: Point, near: float) -> tuple[End, End] | None:
        """The same for one piece, in the frame of the body."""
        entries: list[End] = []
        exits: list[End] = []
        x, y, z = p
        for k, form, slope in plan:
            if slope is None:
                roots = _roots(form, p, d)
                if not roots and value(form, x, y, z)[0] > 0.0:
                    return None
                if len(roots) == 2 and roots[0][1]:  # outside between them: another nappe, or p is there
                    if len(self.shape.pieces) > 1 or roots[0][0] < -near and roots[1][0] > near:
                        raise _Unclear
                    roots = roots[1:] if roots[1][0] <= near else roots[:1]
                for s, leaves in roots:
                    (exits if leaves else entries).append((s, k))
                continue
            a, b, e, c = form
            u, v, w = a * x, b * y, e * z
            height = u + v + w + c
            if slope:
                (exits if slope > 0.0 else entries).append((-height / slope, k))
            else:
                size = CLEAR * (abs(u) + abs(v) + abs(w) + abs(c))
                if height > size:
                    return None
                if height >= -size:
                    raise _Unclear
        lo, hi = _last(entries, 1.0, near), _last(exits, -1.0, near)
        return (lo, hi) if hi[0] - lo[0] > near else None

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
                v, size = value(self.forms[tree.surface], *x)
                found = known[tree.surface] = IN * (v <= CLEAR * size) + OUT * (v >= -CLEAR * size)
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
        return any(c < p or c > q for c, p, q in zip(x, *_WIDENED_BOX.of(self.model, self._widened_box), strict=True))

    def _widened_box(self) -> tuple[list[float], list[float]]:
        low, high = self.model.bounds()
        off = 10.0 * CLEAR * (1.0 + max(np.abs(low).max(), np.abs(high).max()))
        return (low - off).tolist(), (high + off).tolist()


def _last(ends: list[End], way: float, near: float) -> End:
    """The last of the ends (way 1), or the first (-1).  Raises _Unclear where another one is near it."""
    if len(ends) == 1:
        return ends[0]
    best, other = (-way * math.inf, -1), -way * math.inf
    for end in ends:
        if way * end[0] > way * best[0]:
            best, other = end, best[0]
        elif way * end[0] > way * other:
            other = end[0]
    if abs(best[0] - other) <= near:
        raise _Unclear
    return best


def _roots(f: Form, o: Point, d: Point) -> list[tuple[float, bool]]:
    """The s at which o + s d crosses the surface, ascending, and whether it leaves the inside there.

    Both ends of what a tangent line shares would be unclear.
    """
    v, size = value(f, *o)
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
            return [(-v / b, b > 0.0)]
        if abs(v) <= CLEAR * size:
            raise _Unclear
        return []
    square = b * b - 4.0 * a * v
    if abs(square) <= CLEAR * (b * b + abs(4.0 * a * v)):
        raise _Unclear
    if square < 0.0:
        return []
    q = -0.5 * (b + math.copysign(math.sqrt(square), b))
    r, s = q / a, v / q
    return [(min(r, s), a < 0.0), (max(r, s), a > 0.0)]


# -- lines ----------------------------------------------------------------------------------------------------


def _on(flat: Flat) -> frozenset[int]:
    return frozenset(flat.feature.surfaces)


def _in_line(bodies: tuple[_Body, _Body], flats: tuple[Flat, Flat], where: Point, d: Point) -> FlatShared | None:
    """The segment of the line through the touched point that both bodies hold."""
    convex, near = bodies[0].shape.pieces and bodies[1].shape.pieces, CLEAR * (1.0 + max(map(abs, where)))
    found = (_held_by_convex if convex else _held)(bodies, flats, where, d, near)
    if found is None:
        return None
    (side_lo, lo), (side_hi, hi) = found
    if hi[0] - lo[0] <= near or lo[0] > near or hi[0] < -near:
        return None
    middle = along(where, 0.5 * (lo[0] + hi[0]), d)
    # a line that only touches a surface seems to pass it where rounding puts it a little deeper
    for body, flat in zip(bodies, flats, strict=True):
        way = body.back(d) if body.turn else d
        if not (body.shape.plan(flat.feature, way)[1] or body.holds(middle, _on(flat))):
            return None
    ends = along(where, lo[0], d), along(where, hi[0], d)
    pairs = _end_pairs(bodies, flats, ends[0], side_lo, lo[1])
    pairs += _end_pairs(bodies, flats, ends[1], side_hi, hi[1])
    x, y = flats[0].feature, flats[1].feature
    if isinstance(x, Face) and isinstance(y, Face) and not (_is_plane(x) or _is_plane(y)):
        pairs.append((x, y, middle))
    return FlatShared("segment", ends, pairs)


def _held_by_convex(
    bodies: tuple[_Body, _Body], flats: tuple[Flat, Flat], where: Point, d: Point, near: float
) -> tuple[tuple[int, End], tuple[int, End]] | None:
    """(side, end) of both ends of what convex bodies hold of the line, with the side that ends there."""
    in_a = bodies[0].stretch(where, d, flats[0].feature, near)
    in_b = None if in_a is None else bodies[1].stretch(where, d, flats[1].feature, near)
    if in_a is None or in_b is None:
        return None
    (lo_a, hi_a), (lo_b, hi_b) = in_a, in_b
    if abs(lo_a[0] - lo_b[0]) <= near or abs(hi_a[0] - hi_b[0]) <= near:
        return None
    return (0, lo_a) if lo_a[0] > lo_b[0] else (1, lo_b), (0, hi_a) if hi_a[0] < hi_b[0] else (1, hi_b)


def _held(
    bodies: tuple[_Body, _Body], flats: tuple[Flat, Flat], where: Point, d: Point, near: float
) -> tuple[tuple[int, End], tuple[int, End]] | None:
    """The same for bodies of any shape, of the one stretch that both hold: from surface to surface."""
    breaks: list[tuple[float, int, int]] = []
    begin, end = -math.inf, math.inf  # of what the convex ones hold, whose other breaks do not matter
    for side, (body, flat) in enumerate(zip(bodies, flats, strict=True)):
        if body.shape.pieces:
            held = body.stretch(where, d, flat.feature, near)
            if held is None:
                return None
            begin, end = max(begin, held[0][0]), min(end, held[1][0])
            breaks += [(s, side, k) for s, k in held]
        else:
            breaks += _breaks(body, flat, where, d, side)
    breaks.sort()
    shared: list[tuple[tuple[float, int, int], tuple[float, int, int]]] = []
    for lo, hi in zip(breaks, breaks[1:], strict=False):
        if hi[0] - lo[0] <= near or hi[0] <= begin or lo[0] >= end:
            continue
        middle = along(where, 0.5 * (lo[0] + hi[0]), d)
        if all(x.shape.pieces or x.holds(middle, _on(flat)) for x, flat in zip(bodies, flats, strict=True)):
            if shared and shared[-1][1] is lo:  # a surface that bounds nothing here
                lo = shared.pop()[0]
            shared.append((lo, hi))
    if len(shared) != 1:
        return None
    lo, hi = shared[0]
    if any(abs(other[0] - end[0]) <= near for end in (lo, hi) for other in breaks if other is not end):
        return None
    return (lo[1], (lo[0], lo[2])), (hi[1], (hi[0], hi[2]))


def _breaks(body: _Body, flat: Flat, where: Point, d: Point, side: int) -> list[tuple[float, int, int]]:
    """Where a line in the flat passes surfaces of the body, with the side and their numbers."""
    p, way, feature = body.local(where), body.back(d), flat.feature
    left_out = _one_sided(body.model, feature).union(feature.surfaces)
    forms = [(k, form) for k, form in enumerate(body.forms) if k not in left_out]
    return [(s, side, k) for k, form in forms for s, _ in _roots(form, p, way)]


def _one_sided(model: CompositeQuadric, feature: Feature) -> frozenset[int]:
    """The surfaces of which the plane of a face has one side alone, as a fillet's: lines in it pass none of them."""
    if not (isinstance(feature, Face) and isinstance(feature.carrier, Plane)):
        return frozenset()
    known, normal = _ONE_SIDED.of(model, dict), feature.carrier.normal
    found = known.get(feature)
    if found is None:
        basis = transposed(tuple(null_space((normal,))))
        found = known[feature] = frozenset(
            k for k, surface in enumerate(model.surfaces)
            if 0 in inertia(restricted(surface.matrix(), basis)) and k not in feature.surfaces
        )  # fmt: skip
    return found


def _is_plane(feature: Feature) -> bool:
    return isinstance(feature, Face) and isinstance(feature.carrier, Plane)


def _end_pairs(
    bodies: tuple[_Body, _Body], flats: tuple[Flat, Flat], end: Point, side: int, surface: int
) -> list[Pair]:
    """The pairs that meet at an end of the segment, where the flat of one side ends at one more of its surfaces."""
    mine, other = flats[side].feature, flats[1 - side].feature
    corner = _boundary(bodies[side], mine, surface, end)
    if not (isinstance(corner, Vertex) and isinstance(other, Edge)):
        return [(corner, other, end) if side == 0 else (other, corner, end)]
    found: list[tuple[Feature, Feature]]
    found = [(corner, bodies[1 - side].model.faces[k]) for k in other.faces]
    beside = [e for e in bodies[side].model.edges if set(e.surfaces) <= set(corner.surfaces) and e is not mine]
    found += [(e, other) for e in beside]
    return [(x, y, end) if side == 0 else (y, x, end) for x, y in found]


def _boundary(body: _Body, feature: Feature, surface: int, end: Point) -> Feature:
    """The edge or vertex where a flat feature ends at that surface; the face that goes on where it ends smoothly."""
    faces, vertices, edges = _at_surface(body.model, feature, surface)
    if faces:
        return faces[0]
    at_end = []
    if vertices:
        near = CLEAR * (1.0 + max(map(abs, end)))
        x, y, z = body.local(end)
        for v in vertices:
            p, q, r = v.position
            if abs(p - x) < near and abs(q - y) < near and abs(r - z) < near:
                at_end.append(v)
    if len(at_end) == 1 and (isinstance(feature, Edge) or not edges):
        return at_end[0]
    if at_end or len(edges) != 1 or isinstance(feature, Edge):
        raise _Unclear
    return edges[0]


def _at_surface(
    model: CompositeQuadric, feature: Feature, surface: int
) -> tuple[list[Face], list[Vertex], list[Edge]]:
    """The faces that join a face smoothly along a curve in the surface; the vertices and edges of the feature there."""
    known = _AT_SURFACES.of(model, dict)
    found = known.get((feature, surface))
    if found is None:
        around = {*feature.surfaces, surface}
        seams = [s for s in model.seams if around <= set(s.surfaces)]
        found = known[feature, surface] = (
            [f for s in seams for f in _joined(model, s, feature)] if isinstance(feature, Face) else [],
            [v for v in model.vertices if around <= set(v.surfaces)],
            [e for e in model.edges if around == set(e.surfaces) and not isinstance(e.carrier, QuarticCurve)],
        )
    return found


# -- planes ---------------------------------------------------------------------------------------------------


def _in_plane(bodies: tuple[_Body, _Body], x: Feature, y: Feature) -> FlatShared | None:
    """What two faces share that lie in one plane: a patch by its border."""
    assert isinstance(x, Face) and isinstance(y, Face) and isinstance(x.carrier, Plane)
    (a, b), on = bodies, (frozenset(x.surfaces), frozenset(y.surfaces))
    own, others = _outline(a, x), _outline(b, y)
    if own.is_unclear_near(others) or others.is_unclear_near(own):  # what joins smoothly there may touch as well
        raise _Unclear
    if own.lines and others.lines:
        pairs = _of_polygons(x, y, own, others)
        points = [p for _, _, p in pairs]
        return FlatShared("patch", border([], points), pairs) if _spread(points) else None
    i, j = own.axes
    pairs = [(v, y, p) for v, p in own.corners if _is_in(b, others, p, on[1])]
    pairs += [(x, v, p) for v, p in others.corners if _is_in(a, own, p, on[0])]
    for e, p, q in own.sides:
        for f, r, s in others.sides:
            share = _crossing(p[i], p[j], q[i], q[j], r[i], r[j], s[i], s[j])
            if share is not None:
                pairs.append((e, f, _between(p, q, share)))
        pairs += [(e, f, r) for f in others.rims for r in _through(b, f, on[1], p, q)]
    for f, p, q in others.sides if own.rims else ():
        pairs += [(e, f, r) for e in own.rims for r in _through(a, e, on[0], p, q)]
    arcs: list[tuple[Feature, Feature, np.ndarray]]
    arcs = [(x, f, run) for f in others.rims if not own.is_far(f, others) for run in _arcs(b, f, a, on[0])]
    arcs += [(e, y, run) for e in own.rims if not others.is_far(e, own) for run in _arcs(a, e, b, on[1])]
    if arcs:
        corners = [p for _, _, p in pairs]
        pairs += [(e, f, tuple(run[len(run) // 2].tolist())) for e, f, run in arcs]
        beside_arcs = [tuple(p) for _, _, run in arcs for p in beside(run).tolist()]
        if any(_is_in(a, own, p, on[0]) and _is_in(b, others, p, on[1]) for p in beside_arcs):
            return FlatShared("patch", border([run for _, _, run in arcs], corners), pairs)
        return None  # an arc alone, or a patch that is thinner than doubles tell
    points = [p for _, _, p in pairs]
    return FlatShared("patch", border([], points), pairs) if _spread(points) else None


def _of_polygons(x: Face, y: Face, own: _Outline, others: _Outline) -> list[Pair]:
    """The pairs of features that meet where two convex polygons in one plane do."""
    over_other = {p: others.heights(p) for _, p in own.corners}
    over_own = {p: own.heights(p) for _, p in others.corners}
    near = CLEAR * (1.0 + max(map(abs, chain(*over_other, *over_own))))
    pairs: list[Pair] = [(v, y, p) for v, p in own.corners if _is_below(over_other[p], near)]
    pairs += [(x, v, p) for v, p in others.corners if _is_below(over_own[p], near)]
    # no corner is near the other's boundary now
    for k, (e, p, q) in enumerate(own.sides):
        for (f, r, s), g, h in zip(others.sides, over_other[p], over_other[q], strict=True):
            if g * h < 0.0 and (m := over_own[r][k]) * (n := over_own[s][k]) < 0.0:
                if min(abs(g), abs(h), abs(m), abs(n)) <= near:
                    raise _Unclear
                pairs.append((e, f, _between(p, q, g / (g - h))))
    return pairs


def _is_in(body: _Body, outline: _Outline, p: Point, on: frozenset[int]) -> bool:
    """Whether the face of the outline holds a world point of its plane."""
    if not outline.lines:
        return body.holds(p, on)
    return _is_below(outline.heights(p), CLEAR * (1.0 + max(map(abs, p))))


def _is_below(heights: list[float], near: float) -> bool:
    highest = max(heights)
    if abs(highest) <= near:
        raise _Unclear
    return highest < 0.0


def _spread(points: list[Point]) -> bool:
    """Whether three of the points are the corners of a proper triangle."""
    for x, y, z in combinations(points[:12], 3):
        d, e = sub(y, x), sub(z, x)
        if max(map(abs, cross(d, e))) > CLEAR * max(dot(d, d), dot(e, e)):
            return True
    return False


def _between(p: Point, q: Point, share: float) -> Point:
    return along(p, share, sub(q, p))


@dataclass(slots=True)
class _Outline:
    """The boundary of a plane face: corners with their points, straight sides with both ends, round rims.

    axes: coordinates that tell its points apart; lines: of a face of a convex model without rims its sides as
    a u + b v + c, a and b of a unit vector, negative inside.  boxes: around the rims, by their numbers, around smooth
    seams and sides in several pieces, by numbers from UNCLEAR down, and around all of it, local: (low, high corner);
    shift: to the world.
    """

    corners: list[tuple[Vertex, Point]]
    sides: list[tuple[Edge, Point, Point]]
    rims: list[Edge]
    axes: tuple[int, int] = (0, 1)
    lines: Listing[tuple[float, float, float]] = ()
    boxes: dict[int | None, np.ndarray] = field(default_factory=dict)
    shift: Point = (0.0, 0.0, 0.0)

    def heights(self, p: Point) -> list[float]:
        """How far outside its lines a point is."""
        u, v = p[self.axes[0]], p[self.axes[1]]
        return [a * u + b * v + c for a, b, c in self.lines]

    def is_unclear_near(self, other: _Outline) -> bool:
        """Whether a part of the boundary that is not described is not clear of the other outline."""
        return any(not other._is_clear(box, self) for k, box in self.boxes.items() if k is not None and k <= UNCLEAR)

    def is_far(self, rim: Edge, other: _Outline) -> bool:
        """Whether a rim of the other outline is clear of this one."""
        return self._is_clear(other.boxes[rim.index], other)

    def _is_clear(self, box: np.ndarray, other: _Outline) -> bool:
        lo, hi = box + np.subtract(other.shift, self.shift)
        low, high = self.boxes[None]
        off = 10.0 * CLEAR * (1.0 + max(np.abs(lo).max(), np.abs(hi).max()))
        return bool(np.any(hi < low - off) or np.any(lo > high + off))


def _outline(body: _Body, face: Face) -> _Outline:
    """In the world; its local form is kept on the model."""
    known = _OUTLINES.of(body.model, dict)
    outline = known.get(face)
    if outline is None:
        outline = known[face] = _local_outline(body.model, face)
    if body.turn:
        return _turned_outline(body, outline)
    x, y, z = shift = body.shift
    if not (x or y or z):
        return outline
    moved = {v: (p[0] + x, p[1] + y, p[2] + z) for v, p in outline.corners}
    ends = {p: moved[v] for v, p in outline.corners}
    u, v = shift[outline.axes[0]], shift[outline.axes[1]]
    return _Outline(
        list(moved.items()), [(e, ends[p], ends[q]) for e, p, q in outline.sides], outline.rims, outline.axes,
        [(a, b, c - a * u - b * v) for a, b, c in outline.lines], outline.boxes, shift,
    )  # fmt: skip


def _turned_outline(body: _Body, outline: _Outline) -> _Outline:
    """In the world, of a body that turned about the normal."""
    moved = {v: body.world(p) for v, p in outline.corners}
    ends = {p: moved[v] for v, p in outline.corners}
    found = _Outline(
        list(moved.items()), [(e, ends[p], ends[q]) for e, p, q in outline.sides], outline.rims, outline.axes
    )
    if outline.lines:
        found.lines = [_side_line(p, q, found) for _, p, q in found.sides]
    reach = np.abs(body.turn)
    for k, (low, high) in outline.boxes.items():
        if not np.all(np.isfinite([low, high])):
            found.boxes[k] = outline.boxes[k]
            continue
        middle, half = np.array(body.world(0.5 * (low + high))), reach @ (0.5 * (high - low))
        found.boxes[k] = np.array([middle - half, middle + half])
    return found


def _local_outline(model: CompositeQuadric, face: Face) -> _Outline:
    (surface,) = face.surfaces
    sizes = [abs(c) for c in face.carrier.normal[:3]]  # type: ignore[union-attr]
    flat = sizes.index(max(sizes))
    outline, vertices = _Outline([], [], [], ((flat + 1) % 3, (flat + 2) % 3)), model.vertices
    for seam in model.seams:
        if face.index in seam.faces:
            outline.boxes[UNCLEAR - seam.index] = _box_around_unclear(seam)
    corners: dict[int, tuple[Vertex, Point]] = {}
    for edge in model.edges:
        if surface not in edge.surfaces or edge.convexity == "reentrant":  # nothing touches those alone
            continue
        ends = {k for piece in edge.pieces for k in (piece.start, piece.end) if k is not None}
        corners |= {k: (vertices[k], vertices[k].position) for k in ends}
        if isinstance(edge.carrier, Conic) and edge.frame.shape[1] == 3 and not edge.frame[3, 1:].any():
            if ends and len(_shape(model).pieces) > 1:  # other pieces may hold the rest of the curve
                raise _Unclear
            outline.rims.append(edge)
            outline.boxes[edge.index] = _box_around(edge)
        elif isinstance(edge.carrier, Line) and len(edge.pieces) == 1 and len(ends) == 2:
            start, end = edge.pieces[0].start, edge.pieces[0].end
            assert start is not None and end is not None
            outline.sides.append((edge, vertices[start].position, vertices[end].position))
        else:
            outline.boxes[UNCLEAR - len(model.seams) - edge.index] = _box_around_unclear(edge)
    outline.corners.extend(corners.values())
    if not (outline.rims or outline.boxes) and _shape(model).pieces:
        outline.lines = [_side_line(p, q, outline) for _, p, q in outline.sides]
    parts = [*outline.boxes.values(), *(np.array([p, p]) for _, p in outline.corners)]
    low, high = np.full(3, -np.inf), np.full(3, np.inf)
    if parts and not any(surface in e.surfaces and e.convexity == "reentrant" for e in model.edges):
        low, high = np.min([lo for lo, _ in parts], axis=0), np.max([hi for _, hi in parts], axis=0)
    outline.boxes[None] = np.array([low, high])
    return outline


def _side_line(p: Point, q: Point, outline: _Outline) -> tuple[float, float, float]:
    i, j = outline.axes
    a, b = p[j] - q[j], q[i] - p[i]
    length = math.hypot(a, b)
    a, b = a / length, b / length
    c = -(a * p[i] + b * p[j])
    inside = sum(a * r[i] + b * r[j] + c for _, r in outline.corners)
    return (a, b, c) if inside < 0.0 else (-a, -b, -c)


def _box_around(rim: Edge) -> np.ndarray:
    frame = rim.frame[:3] / rim.frame[3, 0]
    reach = np.abs(frame[:, 1:]).sum(axis=1)
    return np.array([frame[:, 0] - reach, frame[:, 0] + reach])


def _box_around_unclear(seam: Edge) -> np.ndarray:
    """Around all of a seam or side."""
    if isinstance(seam.carrier, QuarticCurve):
        raise _Unclear
    if seam.frame.shape[1] == 3:
        if seam.frame[3, 1:].any():
            raise _Unclear
        return _box_around(seam)
    ends = [x for piece in seam.pieces for x in (piece.lo, piece.hi)]
    if not np.all(np.isfinite(ends)):
        raise _Unclear
    points = seam.points(ends)
    return np.array([points.min(axis=0), points.max(axis=0)])


def _in_pieces(edge: Edge, angles: np.ndarray) -> np.ndarray:
    held: np.ndarray = np.any([(angles - p.lo) % (2.0 * np.pi) <= p.hi - p.lo for p in edge.pieces], axis=0)
    return held


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
    d = sub(q, p)
    found = []
    for s, _ in _roots(body.forms[surface], body.local(p), body.back(d)):
        if min(abs(s), abs(1.0 - s)) <= CLEAR:
            raise _Unclear
        point = along(p, s, d)
        if 0.0 < s < 1.0 and body.holds(point, on | {surface}):
            found.append(point)
    return found


def _arcs(body: _Body, rim: Edge, other: _Body, on: frozenset[int]) -> list[np.ndarray]:
    """The parts (n, 3) of a rim of one body that the other one's face holds, sampled."""
    angles = np.linspace(0.0, 2.0 * np.pi, SAMPLES, endpoint=False)
    points = np.stack(body.world(rim.points(angles).T), axis=1)
    good = _in_pieces(rim, angles)
    x, y, z = other.local(points.T)
    negative: list[Any] = [value(form, x, y, z)[0] < 0.0 for form in other.forms]
    either = []
    for choice in product((True, False), repeat=len(on)):
        for k, side in zip(on, choice, strict=True):
            negative[k] = np.full(SAMPLES, side)
        either.append(inside(other.model.tree, negative))
    return [points[run] for run in _runs(good & np.any(either, axis=0) & ~np.all(either, axis=0))]


def _runs(good: np.ndarray) -> list[np.ndarray]:
    """The runs of True around the circle, as indices."""
    if good.all():
        return [np.arange(len(good))]
    if not good.any():
        return []
    start = int(np.flatnonzero(~good)[0])
    order = (np.arange(len(good)) + start) % len(good)
    cuts = np.flatnonzero(np.diff(good[order].astype(int))) + 1
    return [run for run in np.split(order, cuts) if good[run[0]]]
