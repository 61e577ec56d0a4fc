"""One piece of curved relative motion: the walk over cells of time, and exact or enclosed answers for pairs of elements.

The bodies stay in their own frames; the working frame is that of body b.  The local clock is the time since the start.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cmp_to_key
from itertools import pairwise
from typing import Any

import numpy as np
from flint import arb, arb_series, ctx, fmpq

from firstcontact.exact.conditions import Conditions, between, distinct
from firstcontact.exact.instants import RationalInstant, enclose
from firstcontact.exact.numbers import PRECISIONS, Undecidable, ball, ball_bounds, to_double
from firstcontact.exact.rigid import Matrix, apply
from firstcontact.exact.root_instants import RootInstant
from firstcontact.exact.roots import AlgebraicRoot
from firstcontact.exact.vectors import Vector, add, cross, dot, sub, whole
from firstcontact.motion import projective
from firstcontact.motion.curved import CurvedPiece, inverse, terms
from firstcontact.motion.polynomial import PolynomialPiece
from firstcontact.pairs import moving
from firstcontact.result import ExactTime
from firstcontact.search import curve, curve_windows  # noqa: F401 - the walks under this motion
from firstcontact.search.cells import cells_of
from firstcontact.kernels.verdict import CERTAIN, NONE
from firstcontact.search.containment import contained_at, decide
from firstcontact.search.elements import EDGE, FACE, KINDS, VERTEX, Feature, Primitive, corners_of
from firstcontact.search.frame import tree_of
from firstcontact.search.state import WalkState
from firstcontact.search.touch import Touch, doubles, unit_against
from firstcontact.search.walk import walk
from firstcontact.search.tree import FACET
from firstcontact.search.windows import PART_ROOM, collect

# Bits of poses between two instants.
_BITS = 128


# Two elements by their exact corners: one, two or three of each.
Corners = tuple[list[Vector], list[Vector]]


class CurvedProblem:
    """Body a moves by the piece's pose, body b rests; both in the frames they are given in."""

    begin = 0.0, 0.0

    def __init__(self, a: Any, b: Any, piece: CurvedPiece) -> None:
        self.a, self.b, self.piece = a, b, piece
        self.is_exact = a._pose is None and b._pose is None
        self.tree_a, self.tree_b = tree_of(a), tree_of(b)
        sizes = [float(np.abs(tree.boxes[0]).max()) for tree in (self.tree_a, self.tree_b)]
        self.motion = cells_of(piece, *sizes)
        self.length = piece.end - piece.start
        errors = self.tree_a.error + self.tree_b.error
        stretch = self.motion[: len(self.motion) - 64, 47, :6]
        finite = stretch[np.isfinite(stretch).all(axis=1)]
        self.pad = 4.0 * (1.0 + float(finite.max(initial=0.0))) * errors

    def window(self) -> tuple[float, float]:
        """(last, sure last): outward and inward doubles around the end of the window."""
        last = to_double(self.length)
        if fmpq(*last.as_integer_ratio()) == self.length:
            return last, last
        return math.nextafter(last, math.inf), math.nextafter(last, -math.inf)

    def advance(self, state: WalkState, limit: int, with_start: bool, all_sides: bool) -> int:
        """Go on with the walk; the reason it came back.  The start is another problem's (`problem`)."""
        a, b = self.tree_a, self.tree_b
        return walk(
            a.boxes, a.links, a.xyz, a.ids, b.boxes, b.links, b.xyz, b.ids,
            self.motion, a.error, b.error, self.pad, False, all_sides, limit,
            state.floats, state.integers, state.keys, state.pairs, state.stack, state.times, state.candidates,
        )  # fmt: skip

    # -- all windows ----------------------------------------------------------------------------------------

    def collect(self, limit: int, integers: Any, stack: Any, cover: Any, times: Any, parts: Any) -> int:
        """Go on collecting windows (`windows.collect`)."""
        a, b = self.tree_a, self.tree_b
        return collect(
            a.boxes, a.links, a.xyz, a.ids, b.boxes, b.links, b.xyz, b.ids, self.motion,
            a.error, b.error, self.pad, self.window()[0], limit, integers, stack, cover, times, parts,
        )  # fmt: skip

    def windows_of(self, primitive_a: int, primitive_b: int) -> list[tuple[Any, Any]]:
        """The windows of contact of two primitives: between two consecutive events nothing changes."""
        a, b = Primitive(self.a, self.tree_a, primitive_a), Primitive(self.b, self.tree_b, primitive_b)
        windows: list[tuple[Any, Any]] = []
        begin, end = self.start_instant(), self.end_instant()
        events = [(begin, False), *self.events(a, b), (end, False)]
        open_since: Any = None
        for (left, touching), (right, _) in pairwise(events):
            if self.order(left, right) < 0 and self.meet_between(a, b, left, right):
                open_since = left if open_since is None else open_since
                continue
            if open_since is not None:
                windows.append((open_since, left))
            elif touching:
                windows.append((left, left))
            open_since = None
        return windows if open_since is None else [*windows, (open_since, end)]

    def events(self, a: Primitive, b: Primitive) -> list[tuple[Any, bool]]:
        """The instants within the piece at which contact may begin or end, ascending, and whether they are contacts."""
        raise NotImplementedError

    def meet_between(self, a: Primitive, b: Primitive, left: Any, right: Any) -> bool:
        """Whether two primitives share a point at a time between two instants."""
        pose = self.pose_between(left, right)
        return bool(decide(lambda: a.moved(pose).meets(b)))

    def pose_between(self, x: Any, y: Any) -> Matrix:
        raise NotImplementedError

    # -- answers --------------------------------------------------------------------------------------------

    def world_time(self, local: float) -> float:
        """A double not later than the local time, in the motions' clock."""
        t = to_double(self.piece.start)
        return local if t == 0.0 else math.nextafter(t + local, -math.inf)

    def is_end(self, at: Any, turn: int) -> bool:
        """Whether the instant is the end of the piece."""
        return self.order(at, self.end_instant()) == 0

    def order(self, x: Any, y: Any) -> int:
        """-1, 0, 1: x before, at, after y."""
        return x.compare(y)

    def end_instant(self) -> Any:
        raise NotImplementedError

    def repeated(self, windows: list[tuple[Any, Any]]) -> list[tuple[Any, int, Any, int]]:
        """The windows as (start, turn, end, turn): there are no turns."""
        return [(start, 0, end, 0) for start, end in windows]

    def touch(self, element_a: Feature, element_b: Feature, at: Any) -> Touch:
        """(point, unit normal or None) of the two elements at the instant, working frame."""
        corners_a, corners_b = corners_of(self.a, element_a), corners_of(self.b, element_b)
        for bits in PRECISIONS:
            with terms(2, bits):
                pose = self.piece.series(at.local() + self.piece.start)
                now: Any = [tuple(x[0] for x in row) for row in pose]
                speed = [tuple(x[1] for x in row) for row in pose]
                moved = [apply(now, _balls(p)) for p in corners_a]
                rest = [_balls(p) for p in corners_b]
                point = _shared_point(element_a, moved, element_b, rest)
                back = inverse(pose, self.piece.is_rigid)
                own = apply([tuple(x[0] for x in row) for row in back], point)  # type: ignore[arg-type]
                velocity = apply(speed, own)  # type: ignore[arg-type]
                normal = unit_against(_normal(element_a, moved, element_b, rest), velocity)
            if normal is not None:
                break
        return doubles(point), normal


def _balls(p: Vector) -> Vector:
    return ball(p[0]), ball(p[1]), ball(p[2])


def _normal(element_a: Feature, a: list[Vector], element_b: Feature, b: list[Vector]) -> Vector:
    if element_a[0] == VERTEX:
        return cross(sub(b[1], b[0]), sub(b[2], b[0]))
    if element_b[0] == VERTEX:
        return cross(sub(a[1], a[0]), sub(a[2], a[0]))
    return cross(sub(a[1], a[0]), sub(b[1], b[0]))


def _shared_point(element_a: Feature, a: list[Vector], element_b: Feature, b: list[Vector]) -> Vector:
    """A point of both elements, given that they share one, in balls."""
    if element_a[0] == VERTEX:
        return a[0]
    if element_b[0] == VERTEX:
        return b[0]
    (p, q), (r, s) = a, b
    e, f, w = sub(q, p), sub(s, r), sub(r, p)
    n = cross(e, f)
    square = dot(n, n)
    if not square.contains(0):
        mu = dot(cross(w, e), n) / square
        return add(r, (mu * f[0], mu * f[1], mu * f[2]))
    return min(
        ((_distance(x, y, z), x) for x, y, z in ((p, r, s), (q, r, s), (r, p, q), (s, p, q))), key=lambda found: found[0]
    )[1]


def _distance(x: Vector, c: Vector, d: Vector) -> float:
    """About the distance of x from the segment cd."""
    p, q, r = (np.array([float(v.mid()) for v in point]) for point in (x, c, d))
    f = r - q
    length = float(f @ f)
    share = min(max(float((p - q) @ f) / length, 0.0), 1.0) if length > 0 else 0.0
    return float(np.linalg.norm(p - q - share * f))


class RationalProblem(CurvedProblem):
    """A piece whose pose is a rational function of the time: every answer is exact."""

    def __init__(self, a: Any, b: Any, piece: CurvedPiece) -> None:
        super().__init__(a, b, piece)
        assert piece.polynomial is not None
        self.path: PolynomialPiece = piece.polynomial
        self.lo, self.hi = piece.start, piece.end
        self._back: projective.Matrix | None = None

    @property
    def back(self) -> projective.Matrix:
        """The pose of b seen from a."""
        if self._back is None:
            self._back = projective.inverse(self.path.pose, self.lo)
        return self._back

    def conditions(self, pair: Corners) -> list[Conditions]:
        """When the two elements share a point: when one of these holds."""
        scale, corners = whole(*pair[0], *pair[1])
        x, y = corners[: len(pair[0])], corners[len(pair[0]) :]
        if len(x) == 1:
            return moving.vertex_facet(moving.times(self.path.pose, x[0], scale), *y)  # type: ignore[call-arg]
        if len(y) == 1:
            return moving.vertex_facet(moving.times(self.back, y[0], scale), *x)  # type: ignore[call-arg]
        return self._edges(x, y, scale)

    def _edges(self, x: list[Vector], y: list[Vector], scale: Any) -> list[Conditions]:
        """Edges that cross, and where that is not all, ends of one on the other."""
        pose = self.path.pose
        start = moving.times(pose, x[0], scale)
        crossing = moving.edge_edge_crossing(start, moving.turned(pose, sub(x[1], x[0])), *y)  # type: ignore[call-arg]
        if not crossing.lasting and not self._parallel_at_events(crossing):
            return [crossing]
        found = [crossing]
        for p in x:
            found += moving.vertex_edge(moving.times(pose, p, scale), *y)  # type: ignore[call-arg]
        for p in y:
            found += moving.vertex_edge(moving.times(self.back, p, scale), *x)  # type: ignore[call-arg]
        return found

    def _parallel_at_events(self, crossing: Conditions) -> bool:
        return any(root.sign_of(crossing.more[0]) == 0 for root in crossing.events(self.lo, self.hi))

    def contact(self, element_a: Feature, element_b: Feature) -> RootInstant | None:
        """The earliest time of the window at which the two elements share a point; exact."""
        pair = corners_of(self.a, element_a), corners_of(self.b, element_b)
        found = [c.earliest(self.lo, self.hi) for c in self.conditions(pair)]
        roots = distinct(r for r in found if r is not None)
        return RootInstant(roots[0], self.lo) if roots else None

    def events(self, a: Primitive, b: Primitive) -> list[tuple[RootInstant, bool]]:
        """The instants at which contact may begin or end, both ends of the piece too where there is contact."""
        found: list[AlgebraicRoot] = []
        touching: list[AlgebraicRoot] = []
        for pair in _element_pairs(a, b):
            for c in self.conditions(pair):
                events = c.events(self.lo, self.hi)
                held = [root for root in events if c.hold(root)]
                found += events if c.lasting else held
                touching += held
        contacts = distinct(touching)
        out = [
            (RootInstant(root, self.lo), any(root.compare(other) == 0 for other in contacts))
            for root in distinct(found)
        ]
        return out

    def pose_between(self, x: RootInstant, y: RootInstant) -> Matrix:
        """The pose of a at a time between x and y (at x when they are equal); exact."""
        time = x.root.rational if x.root.compare(y.root) == 0 else between(x.root, y.root)
        assert time is not None
        rows = projective.value(self.path.pose, time)
        return tuple(rows[0]), tuple(rows[1]), tuple(rows[2])  # type: ignore[return-value]

    def float_window(self, lo: float, hi: float) -> tuple[RootInstant, RootInstant]:
        """A certain window given by doubles, clipped to the piece."""
        first = min(max(self.lo + _exact(lo), self.lo), self.hi)
        last = min(max(self.lo + _exact(hi), self.lo), self.hi)
        return RootInstant.at(first, self.lo), RootInstant.at(last, self.lo)

    # -- answers --------------------------------------------------------------------------------------------

    def start_instant(self) -> RootInstant:
        return RootInstant.at(self.lo, self.lo)

    def end_instant(self) -> RootInstant:
        return RootInstant.at(self.hi, self.lo)

    def world_instant(self, at: RootInstant, turn: int = 0) -> tuple[float, tuple[float, float]]:
        """(nearest double, enclosure) of the instant in the motions' clock."""
        value = at.root.rational
        return enclose(lambda: at.root.enclosure(ctx.prec) if value is None else value)

    def world_exact(self, at: RootInstant, turn: int = 0) -> ExactTime:
        return at.root.number()


# -- enclosures ---------------------------------------------------------------------------------------------

# Terms of the series that stand for the motion over a short time, the last one enclosing the rest.
_TERMS = 8
# Times looked at before a pair counts as undecidable at a precision.
_MOST_LOOKS = 200
# The first time to look into around a bound of the floats, as a share of the piece.
_NEAR = 2.0**-28


class EnclosedProblem(CurvedProblem):
    """A piece whose pose has no rational form, such as a screw: contact times are balls of any precision.

    What no precision decides, such as a graze, raises Undecidable.
    """

    def __init__(self, a: Any, b: Any, piece: CurvedPiece) -> None:
        super().__init__(a, b, piece)
        self._possible: dict[tuple[Feature, Feature], float] = {}

    def conditions(self, pair: Corners, pose: Any, back: Any) -> list[Conditions]:
        """When the two elements share a point, but for parallel edges; power series in the time."""
        x, y = pair
        if len(x) == 1:
            return moving.vertex_facet(moving.times(pose, x[0], 1), *y)  # type: ignore[call-arg]
        if len(y) == 1:
            return moving.vertex_facet(moving.times(back, y[0], 1), *x)  # type: ignore[call-arg]
        edge = moving.turned(pose, sub(x[1], x[0]))
        return [moving.edge_edge_crossing(moving.times(pose, x[0], 1), edge, *y)]  # type: ignore[call-arg]

    def contact(self, element_a: Feature, element_b: Feature) -> RationalInstant | None:
        """The earliest time of the window at which the two elements share a point, as a ball.

        Floats say before when there is none; from there on balls decide.
        """
        kind = next(k for k, pair in KINDS.items() if pair == (element_a[0], element_b[0]))
        xa, xb = (_nine(body, e) for body, e in ((self.a, element_a), (self.b, element_b)))
        pair = corners_of(self.a, element_a), corners_of(self.b, element_b)
        first, last = 0.0, self.window()[0]
        near = _NEAR * last
        while True:
            verdict, lo, hi = curve.pair_window(
                self.motion, kind, xa, xb, self.tree_a.error, self.tree_b.error, first, last
            )
            if verdict == NONE:
                return None
            self._possible[element_a, element_b] = lo
            until = hi if verdict == CERTAIN and hi - lo < near else lo + near
            try:
                found = self._contacts_in(pair, _exact(lo), _exact(until), first_only=True)
            except Undecidable as unclear:
                self._possible[element_a, element_b] = max(lo, *unclear.args)
                raise
            if found:
                return found[0]
            if until >= last:
                return None
            first, near = until, 4.0 * near

    def _contacts_in(self, pair: Corners, lo: fmpq, hi: fmpq, first_only: bool = False) -> list[RationalInstant]:
        """The contacts of two elements from lo to hi, or the first of them.

        Undecidable carries a double before which there certainly is none.
        """
        waiting, looks, out = [(lo, hi)], 0, []
        # `waiting` holds, last one first, the times at which contacts may be that are not in `out`.
        while waiting and not (first_only and out):
            left, right = waiting.pop()
            looks += 1
            found = self._look(pair, left, right)
            if found == OPEN:
                if looks > _MOST_LOOKS or right - left < fmpq(1, 2 ** (ctx.prec // 2)) * self.length:
                    raise Undecidable(to_double(left))
                cut = left + (right - left) * fmpq(15, 31)  # no power of two: events like those
                waiting += [(cut, right), (left, cut)]
            elif found is not None and self._in_window(found):
                out.append(RationalInstant(found))
        return out

    def _look(self, pair: Corners, left: fmpq, right: fmpq) -> Any:
        """None: certainly no contact from left to right; OPEN: not clear; else the ball of the one contact."""
        parts = self._conditions_over(pair, left, right)
        open_parts = [k for k, c in enumerate(parts) if not _excluded(c, ball((right - left) / 2))]
        if len(open_parts) != 1:
            return OPEN if open_parts else None
        index = open_parts[0]
        root = self._root(pair, index, left, right)
        if root is None or root is OPEN:
            return root
        with terms(1, ctx.prec):
            at = self.conditions(pair, *self._poses(root))[index]
        values = [x[0] for x in (*at.least, *at.more)]
        if any(x < 0 for x in values):
            return None
        if not all(x > 0 for x in values):
            raise Undecidable(ball_bounds(root)[0])
        return root

    def _conditions_over(self, pair: Corners, left: fmpq, right: fmpq) -> list[Conditions]:
        """The conditions as series about the middle of a time, their last terms enclosing the rest."""
        middle = (left + right) / 2
        with terms(_TERMS, ctx.prec):
            poses = self._poses(ball(middle)), self._poses(arb(left).union(arb(right)))
            sharp, blurred = (self.conditions(pair, *pose) for pose in poses)
        return [
            Conditions(*(
                tuple(_joined(f, g) for f, g in zip(getattr(c, name), getattr(d, name), strict=True))
                for name in ("zero", "least", "more")
            ))
            for c, d in zip(sharp, blurred, strict=True)
        ]  # fmt: skip

    def _poses(self, t: arb) -> tuple[Any, Any]:
        """The pose of a seen from b at the local time, and its inverse, with their last rows."""
        pose = self.piece.series(t + self.piece.start)
        last = [[0, 0, 0, arb_series([1])]]
        return pose + last, inverse(pose, self.piece.is_rigid) + last

    def _root(self, pair: Corners, index: int, left: fmpq, right: fmpq) -> Any:
        """The one zero from left to right by Newton's method: a ball, None where there is none, else OPEN.

        The time is blown up a little, so that a zero at its end is inside; m - f(m) / f'(X) inside X proves one zero.
        """
        margin = (right - left) / 8
        x = arb(left - margin).union(arb(right + margin))
        inside = False
        for _ in range(2 * PRECISIONS[-1].bit_length()):
            m = arb(x.mid())
            value, slope = self._value(pair, index, m)[0], self._value(pair, index, x)[1]
            if slope.contains(0):
                return OPEN
            step = m - value / slope
            if not step.overlaps(x):
                return None
            inside = inside or bool(x.contains_interior(step))
            narrower = x.intersection(step)
            done = not narrower.rad() < 0.5 * x.rad()
            x = narrower
            if done:
                break
        if not inside:
            return OPEN
        if x < left or x > right:
            return None
        return x

    def _value(self, pair: Corners, index: int, t: arb) -> Any:
        with terms(2, ctx.prec):
            return self.conditions(pair, *self._poses(t))[index].zero[0]

    def _in_window(self, t: arb) -> bool:
        """Whether the time lies in the piece; Undecidable at its ends."""
        if t < 0 or t > arb(self.length):
            return False
        if t > 0 and t < arb(self.length):
            return True
        raise Undecidable(ball_bounds(t)[0])

    def possible(self, element_a: Feature, element_b: Feature) -> float:
        """A time before which the two elements, which no precision could decide, certainly do not meet."""
        return self._possible.get((element_a, element_b), 0.0)

    def events(self, a: Primitive, b: Primitive) -> list[tuple[RationalInstant, bool]]:
        """The instants of contact of elements where floats leave open whether contact begins or ends there."""
        found: list[RationalInstant] = []
        for lo, hi in self._open_times(a, b):
            for pair in _element_pairs(a, b):
                found += self._contacts_in(pair, lo, hi)
        found.sort(key=cmp_to_key(RationalInstant.compare))
        return [(instant, True) for instant in found]

    def _open_times(self, a: Primitive, b: Primitive) -> list[tuple[fmpq, fmpq]]:
        """Disjoint times in which the floats do not know whether two primitives meet."""
        xa, xb = (np.array([[to_double(x) for x in p] for p in (*c.corners, c.corners[-1])][:3]) for c in (a, b))
        masks = (np.int64(FACET if c.is_facet else 0) for c in (a, b))
        mask_a, mask_b = masks
        out = np.empty((PART_ROOM, 4))
        last = self.window()[0]
        errors = self.tree_a.error, self.tree_b.error
        count = curve_windows.windows_of_parts(self.motion, mask_a, xa.ravel(), mask_b, xb.ravel(), *errors, last, out)
        if count < 0:
            return [(fmpq(0), self.length)]
        zones: list[tuple[float, float]] = []
        for w0, w1, w2, w3 in out[:count].tolist():
            for lo, hi in ((w0, w1), (w2, w3)) if w1 < w2 else ((w0, w3),):
                if hi < 0.0 or lo > last or lo == hi:
                    continue
                if zones and lo <= zones[-1][1]:
                    zones[-1] = zones[-1][0], max(hi, zones[-1][1])
                else:
                    zones.append((lo, hi))
        return [(_exact(lo), _exact(hi)) for lo, hi in zones]

    def pose_between(self, x: RationalInstant, y: RationalInstant) -> Matrix:
        """The pose of a half way between x and y, in balls."""
        with terms(1, 4 * _BITS):
            middle = self.piece.series((ball(x.value) + ball(y.value)) / 2 + self.piece.start)
            return tuple(tuple(entry[0] for entry in row) for row in middle)  # type: ignore[return-value]

    def float_window(self, lo: float, hi: float) -> tuple[RationalInstant, RationalInstant]:
        """A certain window given by doubles, clipped to the piece."""
        return tuple(RationalInstant(min(max(_exact(x), fmpq(0)), self.length)) for x in (lo, hi))  # type: ignore[return-value]

    def start_instant(self) -> RationalInstant:
        return RationalInstant(fmpq(0))

    def end_instant(self) -> RationalInstant:
        return RationalInstant(self.length)

    def world_instant(self, at: RationalInstant, turn: int = 0) -> tuple[float, tuple[float, float]]:
        """(nearest double, enclosure) of the instant in the motions' clock."""
        return enclose(lambda: at.value + self.piece.start)

    def world_exact(self, at: RationalInstant, turn: int = 0) -> ExactTime | None:
        """None: no exact form."""
        return None


OPEN = "open"


def _exact(x: float) -> fmpq:
    return fmpq(*x.as_integer_ratio())


def _element_pairs(a: Primitive, b: Primitive) -> Iterator[Corners]:
    """The pairs of elements of two primitives whose contacts are the events of theirs."""
    yield from (([*x], [*y]) for x in a.sides for y in b.sides)
    if b.is_facet:
        yield from (([p], [*b.corners]) for p in a.corners)
    if a.is_facet:
        yield from (([*a.corners], [q]) for q in b.corners)


def _nine(body: Any, element: Feature) -> np.ndarray:
    """The corners of an element as the doubles of the body, the last one repeated."""
    kind, index = element
    if kind == FACE:
        rows = body.triangles[index]
    elif kind == EDGE:
        n = len(body._segments)
        rows = body._segments[index][[0, 1, 1]] if index < n else np.full(3, index - n)
    else:
        rows = np.full(3, index)
    return np.ascontiguousarray(body.vertices[rows], np.float64).reshape(9)


def _joined(sharp: Any, blurred: Any) -> list[arb]:
    """Coefficients about the middle, the last one those of all the time (Lagrange's remainder)."""
    return [*(sharp[k] for k in range(_TERMS - 1)), blurred[_TERMS - 1]]


def _excluded(c: Conditions, half: arb) -> bool:
    """Whether some condition certainly fails all the time of that half length."""
    return any(_signed(f, half) != 0 for f in c.zero) or any(_signed(f, half) < 0 for f in (*c.least, *c.more))


def _signed(f: list[arb], half: arb) -> int:
    """The sign a function certainly has all the time, else 0."""
    span, power = arb(0), arb(1)
    for c in f[1:]:
        power *= half
        span += abs(c) * power
    return 1 if f[0] > span else -1 if f[0] < -span else 0
