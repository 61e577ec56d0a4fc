"""One piece of curved motion without a rational pose: contact times as balls of any precision."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator
from functools import cached_property, cmp_to_key
from itertools import pairwise, product
from typing import Any

import numpy as np
from flint import arb, arb_series, ctx, fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.doubts import WIDEST, Doubt, merged
from firstcontact.contact.polyhedra.earliest import SOON
from firstcontact.contact.polyhedra.generic_turns import Rows, relative_pose
from firstcontact.contact.polyhedra.planar import BeginsNothing, generic_poses, has_walls, normal_of_motion
from firstcontact.contact.polyhedra.problems.curved_problem import Corners, CurvedProblem, element_pairs, ids_of
from firstcontact.exact.fields.conditions import ParameterConditions
from firstcontact.exact.numbers import (
    PRECISIONS,
    Undecidable,
    above,
    ball,
    ball_bounds,
    dyadic,
    exact_value,
    nearest_double,
    precision,
    simplest_in,
    to_double,
)
from firstcontact.exact.rigid import Matrix, apply, compose, inverse_map
from firstcontact.exact.times.instants import RationalInstant, enclose
from firstcontact.exact.vectors import Vector, cross, sub
from firstcontact.kernels.verdict import CERTAIN, NONE
from firstcontact.motion.relative.curved import CurvedPiece, inverse, terms
from firstcontact.motion.relative.kept_heights import KeptHeights, Times, heights_in, times_level
from firstcontact.pairs.elements import moving
from firstcontact.result import ExactTime
from firstcontact.search.trees import curve, curve_windows
from firstcontact.search.trees.containment import contains
from firstcontact.search.trees.elements import (
    EDGE,
    FACE,
    VERTEX,
    Feature,
    Primitive,
    certainly_meet,
    corners_of,
    vertices_of,
)
from firstcontact.search.trees.frame import tree_of
from firstcontact.search.trees.state import EDGE_EDGE, FACE_VERTEX, VERTEX_FACE
from firstcontact.search.trees.touch import spanning
from firstcontact.search.trees.tree import FACET
from firstcontact.search.trees.windows import PART_ROOM
from firstcontact.work import Spent

# Bits of poses between two instants.
_BITS = 512
# Where times are cut and looked into: at no power of two, elements are aligned at those.
_SHARE = fmpq(15, 31)
# What looking at a stretch of time answers when it is not clear.
OPEN = "open"
# Terms of the series that stand for the motion over a short time, the last one enclosing the rest.
_TERMS = 8
# Times looked at before a pair counts as undecidable at a precision.
_MOST_LOOKS = 200
# The same for the times in which primitives meet throughout, and bits of the poses there: those are wide balls.
_FEW_LOOKS, _COARSE = 80, 128
_MOST_KEPT = 4096
# The last row of a pose.
_LAST = [[0, 0, 0, arb_series([1])]]
# Bits of a slope that need no better one.
_STEEP = 24
# The first time to look into around a bound of the floats, as a share of the piece.
_NEAR = 2.0**-28


# The kind of a pair of elements by their numbers of corners.
_KIND_OF = {(1, 3): VERTEX_FACE, (2, 2): EDGE_EDGE, (3, 1): FACE_VERTEX}
# A pair of elements, named.
Named = tuple[Hashable, Corners]


class EnclosedProblem(CurvedProblem[RationalInstant]):
    """A piece whose pose has no rational form, such as a screw: contact times are balls of any precision.

    What no precision decides, such as a graze, raises Undecidable.
    """

    def __init__(self, a: Polyhedron, b: Polyhedron, piece: CurvedPiece) -> None:
        super().__init__(a, b, piece)
        self._instants: dict[Hashable, list[tuple[RationalInstant, arb]]] = {}
        self._solved: dict[tuple[Hashable, int], list[tuple[fmpq, fmpq, list[RationalInstant]]]] = {}
        self._possible: dict[tuple[Feature, Feature], float] = {}
        self._kept_poses: dict[tuple[fmpq, fmpq, int], list[tuple[Rows, Rows]]] = {}
        self._poses_at: dict[fmpq, tuple[Rows, Rows, bool] | None] = {}
        self._directions: dict[tuple[Any, ...], Vector | None] = {}
        self._heights: dict[int, tuple[KeptHeights, KeptHeights] | None] = {}

    @cached_property
    def _generic(self) -> tuple[Rows, Rows] | None:
        """The generic pose of motions in the plane, and its inverse; None where this motion is in no plane."""
        normal = normal_of_motion(self.piece)
        return None if normal is None or not self.is_exact else generic_poses(normal)

    @cached_property
    def _have_walls(self) -> bool:
        normal = normal_of_motion(self.piece)
        return normal is not None and has_walls(self.a, normal) and has_walls(self.b, normal)

    def _lasting(self, pair: Corners) -> list[list[bool]] | None:
        """For every part of the conditions, which of `least` and `more` vanish at all times; None where none may.

        Raises BeginsNothing for elements that slide in one another; Undecidable where contact may begin so.
        """
        if self._generic is None:
            return None
        parts = self.conditions(pair, *self._generic)
        if all(not any(c.zero) for c in parts):
            raise BeginsNothing if self._have_walls else Undecidable
        return [[not p for p in (*c.least, *c.more)] for c in parts]

    def conditions(self, pair: Corners, pose: Rows, back: Rows) -> list[ParameterConditions]:
        """When the two elements share a point, but for parallel edges; power series in the time."""
        x, y = pair
        if len(x) == 1:
            return moving.vertex_facet(moving.times(pose, x[0], 1), *y)
        if len(y) == 1:
            return moving.vertex_facet(moving.times(back, y[0], 1), *x)
        edge = moving.turned(pose, sub(x[1], x[0]))
        return [moving.edge_edge_crossing(moving.times(pose, x[0], 1), edge, *y)]

    def contact(self, element_a: Feature, element_b: Feature) -> RationalInstant | None:
        """The earliest time of the window at which the two elements share a point, as a ball.

        Floats say before when there is none; from there on balls decide.
        """
        if element_a[0] == element_b[0] == EDGE and self._stay_parallel(element_a, element_b):
            return None
        xa, xb = (corners_as_doubles(body, e) for body, e in ((self.a, element_a), (self.b, element_b)))
        pair = corners_of(self.a, element_a), corners_of(self.b, element_b)
        lasting = self._lasting(pair)
        for lo, hi in self._possible_times(pair, xa, xb, 0.0, self.window()[0]):
            self._possible[element_a, element_b] = lo
            try:
                found = self._contacts_in(pair, exact_value(lo), exact_value(hi), True, lasting)
            except Undecidable as unclear:
                self._possible[element_a, element_b] = max(lo, *unclear.args)
                raise
            if found:
                return RationalInstant(found[0][0])
        return None

    def _possible_times(
        self, pair: Corners, xa: np.ndarray, xb: np.ndarray, first: float, last: float
    ) -> Iterator[tuple[float, float]]:
        """The times in which floats leave open whether two elements meet, or prove that they do, in order.

        xa, xb (9,): their corners as doubles, the last one repeated.
        """
        kind, near = _KIND_OF[len(pair[0]), len(pair[1])], _NEAR * self.window()[0]
        errors = self.tree_a.error, self.tree_b.error
        while True:
            verdict, lo, hi = curve.pair_window(self.motion, kind, xa, xb, *errors, first, last)
            if verdict == NONE:
                return
            until = hi if verdict == CERTAIN and first < hi < lo + near else lo + near
            yield lo, until
            if until >= last:
                return
            first, near = until, 4.0 * near

    def contact_within(self, element_a: Feature, element_b: Feature, lo: float, hi: float) -> RationalInstant | None:
        """The same, of two elements of which floats have proved that they meet in [lo, hi], and not before lo.

        Elements that meet lie in a plane: where they do so once in that time, it is then.
        """
        if 0.0 < lo and exact_value(hi) < self.length:
            self._count_look()
            found = self._root_within(corners_of(self.a, element_a), corners_of(self.b, element_b), lo, hi)
            if found is not None:
                return RationalInstant(found)
        return self.contact(element_a, element_b)

    def _root_within(self, x: list[Vector], y: list[Vector], lo: float, hi: float) -> arb | None:
        """The time at which the elements lie in a plane, if they do once in [lo, hi]."""
        pair, left, right = (x, y), exact_value(lo), exact_value(hi)
        found = None if _is_flat(pair) else self._root(pair, 0, left, right)
        return None if found is None or found is OPEN else self._rounded(pair, 0, found[0], left, right)

    def _stay_parallel(self, edge_a: Feature, edge_b: Feature) -> bool:
        """Whether the edges are parallel at all times, and a facet at one of them.

        Then they share a point only where an end of one lies in the other: a corner of that facet on the other body, or
        a corner of the other on the facet.
        """
        has_facet = _has_facet(self.a, edge_a) or _has_facet(self.b, edge_b)
        return has_facet and self._are_parallel((corners_of(self.a, edge_a), corners_of(self.b, edge_b)))

    def _are_parallel(self, pair: Corners) -> bool:
        """Whether two edges are parallel at all times, as those that stand for points are to all."""
        if any(edge[0] == edge[1] for edge in pair):
            return True
        directions = []
        for leg, edge in zip((self.piece.leg_a, self.piece.leg_b), pair, strict=True):
            key = leg is self.piece.leg_b, *edge
            if key not in self._directions:
                self._directions[key] = leg.fixed_direction(sub(*edge))
            directions.append(self._directions[key])
        x, y = directions
        return x is not None and y is not None and not any(cross(x, y))

    def _without_parallel(self, a: Primitive, b: Primitive, pairs: Iterable[Named]) -> list[Named]:
        """The pairs of elements of two primitives but for edges as in `_stay_parallel`."""
        if not (a.is_facet or b.is_facet):
            return list(pairs)
        return [
            (name, pair) for name, pair in pairs
            if not (len(pair[0]) == len(pair[1]) == 2 and self._are_parallel(pair))
        ]  # fmt: skip

    def _contacts_in(
        self, pair: Corners, lo: fmpq, hi: fmpq, first_only: bool = False, lasting: list[list[bool]] | None = None,
        doubts: list[tuple[fmpq, fmpq]] | None = None,
    ) -> list[tuple[arb | fmpq, arb]]:  # fmt: skip
        """The contacts of two elements from lo to hi, or the first of them, each with a time in which it is alone.

        They are balls, but rational at an end of the piece and where balls would leave them open.

        lasting: as `_lasting` tells.  doubts: takes the times that are left open.
        Undecidable, without a place for doubts, carries a double before which there certainly is none.
        """
        level = self._level(pair, lo, hi)
        if level is None:
            return []
        waiting, looks = [level], 0
        most, least = _MOST_LOOKS, fmpq(1, 2 ** (ctx.prec // 2)) * self.length
        if doubts is not None:
            most, least = _FEW_LOOKS, WIDEST / 16 * self.length
        out: list[tuple[arb | fmpq, arb]] = []
        # `waiting` holds, last one first, the times at which contacts may be that are not in `out`.
        while waiting and not (first_only and out):
            left, right = waiting.pop()
            looks += 1
            self._count_look()
            try:
                found = self._look(pair, left, right, lasting)
                if found not in (None, OPEN) and not self._in_window(found[0]):
                    found = None
            except Undecidable:
                if doubts is None:
                    raise
                found = OPEN
            if found == OPEN and self._keep_apart(pair, left, right):
                continue
            if found == OPEN:
                if looks > most or right - left < least:
                    if doubts is None:
                        raise Undecidable(to_double(left))
                    doubts.append((max(left, fmpq(0)), min(right, self.length)))
                    continue
                cut = left + (right - left) * _SHARE
                waiting += [(cut, right), (left, cut)]
            elif found is not None:
                out.append(found)
        return out

    def _level(self, pair: Corners, lo: fmpq, hi: fmpq) -> Times | None:
        """The part of a time in which two elements may share a height along a direction that the motion keeps, with a
        little room for a root at its end; None where they never do."""
        if ctx.prec not in self._heights:
            self._heights[ctx.prec] = heights_in(self.piece) if self.is_exact else None
        heights = self._heights[ctx.prec]
        level = (lo, hi) if heights is None else times_level(heights, pair, lo, hi)
        room = self.length / 2 ** (ctx.prec // 2)
        return None if level is None else (level[0] - room, level[1] + room)

    def _keep_apart(self, pair: Corners, left: fmpq, right: fmpq) -> bool:
        """Whether a plane along the second of two edges parts them from left to right: edges that become parallel lie
        in a plane then, however far apart they are, and no condition tells."""
        x, y = pair
        if not len(x) == len(y) == 2:
            return False
        with terms(1, ctx.prec):
            pose = self.piece.series(arb(left).union(arb(right)) + self.piece.start)
            ends = [[sum((r[k][0] * p[k] for k in range(3)), r[3][0]) for r in pose] for p in x]
        along = np.array([to_double(c) for c in sub(y[1], y[0])])
        along /= max(float(np.abs(along).max()), 1e-300)  # 0 for a point
        offset = np.array([float((p + q).mid()) / 2 - to_double(c) for p, q, c in zip(*ends, y[0], strict=True)])
        if not np.isfinite(offset).all():
            return False
        away = offset - (offset @ along) / max(float(along @ along), 1.0) * along
        normal = [arb(c) for c in away.tolist()]
        return all(
            sum((n * (p - q) for n, p, q in zip(normal, end, corner, strict=True)), arb(0)) > 0
            for end, corner in product(ends, y)
        )

    def _count_look(self) -> None:
        if self.looks == self.most_looks:
            raise Spent
        self.looks += 1

    def _look(self, pair: Corners, left: fmpq, right: fmpq, lasting: list[list[bool]] | None) -> Any:
        """None: certainly no contact from left to right; OPEN: not clear; else the contact and a time it has alone."""
        parts = self._conditions_over(pair, left, right)
        open_parts = [k for k, c in enumerate(parts) if not _excluded(c, ball((right - left) / 2))]
        if len(open_parts) != 1:
            return OPEN if open_parts else None
        index = open_parts[0]
        found = self._root(pair, index, left, right)
        if found is None or found is OPEN:
            return found
        root, alone = found
        with terms(1, ctx.prec):
            at = self.conditions(pair, *self._poses(root))[index]
        held = [False] * 9 if lasting is None else lasting[index]
        values = [x[0] for x, always in zip((*at.least, *at.more), held, strict=False) if not always]
        if any(x < 0 for x in values):
            return None
        is_clear = all(x > 0 for x in values)
        if is_clear and 0 < root < arb(self.length):
            return self._rounded(pair, index, root, left, right), alone
        time = self._rational_contact(pair, index, root, at)
        if time is OPEN and not is_clear:
            raise Undecidable(ball_bounds(root)[0])
        return None if time is None else (root if time is OPEN else time, alone)

    def _rounded(self, pair: Corners, index: int, root: arb, left: fmpq, right: fmpq) -> arb:
        """The root, narrow enough to tell the double nearest its time, where some precision does."""
        bits = 2 * ctx.prec
        while bits <= PRECISIONS[-1] and nearest_double(root + self.piece.start) is None:
            with precision(bits):
                found = self._root(pair, index, left, right)
            if found is None or found is OPEN or not found[0].rad() < root.rad():
                break
            root, bits = found[0], 2 * bits
        return root

    # -- times that are rational ----------------------------------------------------------------------------

    def _rational_contact(self, pair: Corners, index: int, root: arb, at: ParameterConditions) -> Any:
        """The time of contact where it is a rational one of few bits, or an end of the piece, in the ball `root`.

        None: there is no contact; OPEN: it is not proved that the equation holds at that time.
        at: the conditions in balls, for those that are not told exactly.
        """
        time = self._rational_in(root)
        poses = self._exact_poses(time)
        if poses is None:
            return OPEN
        pose, back, is_exact = poses
        exact = self.conditions(pair, pose, back)[index]
        if any(exact.zero):
            return OPEN
        for name in ("least", "more"):
            for polynomial, around in zip(getattr(exact, name), getattr(at, name), strict=True):
                value = polynomial[0] if is_exact or not polynomial else around[0]
                if value < 0 or (value == 0 and name == "more"):
                    return None
                if not value >= 0:
                    raise Undecidable(ball_bounds(root)[0])
        return time

    def _rational_in(self, root: arb) -> fmpq:
        for end in (self.length, fmpq(0)):
            if root.contains(end):
                return end
        return simplest_in(root)

    def _exact_poses(self, time: fmpq) -> tuple[Rows, Rows, bool] | None:
        if not self.is_exact:
            return None
        if time not in self._poses_at:
            there = time + self.piece.start
            self._poses_at[time] = relative_pose(self.piece.leg_a.place(there), self.piece.leg_b.place(there))
        return self._poses_at[time]

    def _conditions_over(self, pair: Corners, left: fmpq, right: fmpq) -> list[ParameterConditions]:
        """The conditions as series about the middle of a time, their last terms enclosing the rest."""
        with terms(_TERMS, ctx.prec):
            poses = self._poses_over(left, right)
            sharp, blurred = (self.conditions(pair, *pose) for pose in poses)
        return [
            ParameterConditions(*(  # type: ignore[arg-type]
                tuple(_joined(f, g) for f, g in zip(getattr(c, name), getattr(d, name), strict=True))
                for name in ("zero", "least", "more")
            ))
            for c, d in zip(sharp, blurred, strict=True)
        ]  # fmt: skip

    def _poses_over(self, left: fmpq, right: fmpq) -> list[tuple[Rows, Rows]]:
        """The poses about the middle of a time, and over all of it; kept, for other elements meet there too."""
        key = left, right, ctx.prec
        if key not in self._kept_poses:
            if len(self._kept_poses) == _MOST_KEPT:
                self._kept_poses.clear()
            times = ball((left + right) / 2), arb(left).union(arb(right))
            self._kept_poses[key] = [self._poses(t) for t in times]
        return self._kept_poses[key]

    def _poses(self, t: arb) -> tuple[Rows, Rows]:
        """The pose of a seen from b at the local time, and its inverse, with their last rows."""
        pose = self.piece.series(t + self.piece.start)
        return pose + _LAST, inverse(pose, self.piece.is_rigid) + _LAST

    def _root(self, pair: Corners, index: int, left: fmpq, right: fmpq) -> Any:
        """The one zero from left to right by Newton's method: (ball, time alone), None, or OPEN.

        The time is blown up a little, so that a zero at its end is inside; m - f(m) / f'(X) inside X proves one zero.
        """
        margin = (right - left) / 8
        x = alone = arb(left - margin).union(arb(right + margin))
        inside, slope = False, None
        for _ in range(2 * PRECISIONS[-1].bit_length()):
            m = arb(x.mid())
            if slope is None or slope.rel_accuracy_bits() < _STEEP:
                slope = self._value(pair, index, x, 2)[1]
            if slope.contains(0):
                return OPEN
            value = self._value(pair, index, m, 1)[0]
            step = m - value / slope
            if not step.overlaps(x):
                return None
            inside = inside or bool(x.contains_interior(step))
            narrower = x.intersection(step)
            # neither where it stands still nor where roundings of the value are most of what is left
            done = not narrower.rad() < 0.5 * x.rad() or 2 * (arb(value.rad()) / slope).abs_upper() > step.rad()
            x = narrower
            if done:
                break
        if not inside:
            return OPEN
        if x < left or x > right:
            return None
        return x, alone

    def _value(self, pair: Corners, index: int, t: arb, count: int) -> Any:
        """The equation of the condition, that many terms of its series."""
        with terms(count, ctx.prec):
            if _is_flat(pair):
                return self.conditions(pair, *self._poses(t))[index].zero[0]
            return self._coplanar(pair, self.piece.series(t + self.piece.start) + _LAST)

    def _coplanar(self, pair: Corners, pose: Rows) -> Any:
        """What vanishes where the two elements lie in a plane."""
        x, y = pair
        if len(x) == 1:
            return moving.above_facet(moving.times(pose, x[0], 1), *y)
        if len(y) == 1:
            return moving.above_facet(moving.times(inverse(pose[:3], self.piece.is_rigid) + _LAST, y[0], 1), *x)
        return moving.above_line(moving.times(pose, x[0], 1), moving.turned(pose, sub(x[1], x[0])), *y)

    def _in_window(self, t: arb | fmpq) -> bool:
        """Whether the time lies in the piece; Undecidable for balls at its ends."""
        if t < 0 or t > self.length:
            return False
        if isinstance(t, fmpq) or (t > 0 and t < self.length):
            return True
        raise Undecidable(ball_bounds(t)[0])

    def meets_by(self, element_a: Feature, element_b: Feature, after: float) -> float | None:
        """A time soon after that one at which the bodies certainly share a point at the two elements, or None.

        That settles a first contact no precision names, such as an edge that lands on an edge: it is in between.
        """
        beside = [_beside(body, e) for body, e in ((self.a, element_a), (self.b, element_b))]
        with precision(_BITS):
            for share in (2.0**-12, 2.0**-6, 0.5):
                t = min(exact_value(after) + exact_value(share * SOON) * self.length, self.length)
                pose = self._pose_at(t + self.piece.start)
                if (
                    any(certainly_meet(x.moved(pose), y) for x, y in product(*beside))
                    or _certainly_holds(self.b, self.a, element_a, pose)
                    or _certainly_holds(self.a, self.b, element_b, inverse_map(pose))
                ):
                    return above(t)
        return None

    def _pose_at(self, t: fmpq) -> Matrix:
        """The pose of a seen from b at that time of the clock: rational where both are, else in balls."""
        pose_a, pose_b = (leg.place(t).matrix() for leg in (self.piece.leg_a, self.piece.leg_b))
        return compose(inverse_map(pose_b), pose_a)

    def possible(self, element_a: Feature, element_b: Feature) -> float:
        """A time before which the two elements, which no precision could decide, certainly do not meet."""
        return self._possible.get((element_a, element_b), 0.0)

    def events(
        self, a: Primitive, b: Primitive, pairs: list[Named]
    ) -> list[tuple[RationalInstant, bool]]:
        """The instants of contact of elements where floats leave open whether contact begins or ends there."""
        found: dict[int, RationalInstant] = {}
        pairs = self._without_parallel(a, b, pairs)
        with precision(max(ctx.prec, _BITS)):
            for name, pair, lo, hi in self._possible_contacts(a, b, pairs):
                found |= {id(instant): instant for instant in self._contacts_of(name, pair, lo, hi)}
            return [(instant, True) for instant in sorted(found.values(), key=cmp_to_key(self.order))]

    def windows_and_doubts(
        self, primitive_a: int, primitive_b: int
    ) -> tuple[list[tuple[RationalInstant, RationalInstant]], list[Doubt]]:
        """(times in which two primitives certainly meet, times in which it is left open when they do)."""
        a, b = Primitive(self.a, self.tree_a, primitive_a), Primitive(self.b, self.tree_b, primitive_b)
        with precision(_COARSE):
            level = self._level((a.corners, b.corners), fmpq(0), self.length)
        if level is None:
            return [], []
        first, last = self._within(*level)
        ids = ids_of(self.tree_a, primitive_a), ids_of(self.tree_b, primitive_b)
        stretches: list[tuple[fmpq, fmpq]] = []
        doubts = [Doubt(time, time, False) for time in (first, last)]
        pairs = self._without_parallel(a, b, element_pairs(a, ids[0], b, ids[1]))
        with precision(_COARSE):
            for _, pair, lo, hi in self._possible_contacts(a, b, pairs):
                for root, _ in self._contacts_in(pair, lo, hi, doubts=stretches):
                    found = ball(root)
                    doubts.append(Doubt(*self._within(dyadic(found.lower()), dyadic(found.upper())), True))
            doubts += [Doubt(*self._within(lo, hi), False) for lo, hi in stretches if lo < self.length and hi > 0]
            windows = self._times_between(a, b, merged(doubts), doubts)
        with precision(_COARSE):
            refined = [self._refined(a, b, d) for d in merged(doubts) if d.is_contact or d.lo < d.hi]
        for more, _ in refined:
            windows += more
        doubts = [doubt for _, left in refined for doubt in left]
        for time in (first, last):
            if self._certainly_meet(a, b, self._pose_at(time + self.piece.start)):
                windows.append((RationalInstant(time), RationalInstant(time)))
        return windows, doubts

    def _within(self, lo: fmpq, hi: fmpq) -> tuple[fmpq, fmpq]:
        return max(lo, fmpq(0)), min(hi, self.length)

    def _times_between(
        self, a: Primitive, b: Primitive, events: list[Doubt], doubts: list[Doubt]
    ) -> list[tuple[RationalInstant, RationalInstant]]:
        """The times between the events in which two primitives meet; those left open go to the doubts."""
        windows = []
        for left, right in pairwise(events):
            start, end = RationalInstant(left.hi), RationalInstant(right.lo)
            meet = self._certainly_meet(a, b, self.pose_between(start, end))
            if meet:
                windows.append((start, end))
            elif meet is None:
                doubts.append(Doubt(left.hi, right.lo, False))
        return windows

    def _refined(
        self, a: Primitive, b: Primitive, doubt: Doubt
    ) -> tuple[list[tuple[RationalInstant, RationalInstant]], list[Doubt]]:
        """A doubt cut into times in which two primitives certainly meet throughout, and what is left of it."""
        least, looks = WIDEST * self.length, 0
        windows, doubts, waiting = [], [], [(doubt.lo, doubt.hi)]
        while waiting:
            lo, hi = waiting.pop()
            if hi - lo <= least or looks == _FEW_LOOKS:
                doubts.append(Doubt(lo, hi, doubt.is_contact))
                continue
            looks += 1
            self._count_look()
            with terms(1, ctx.prec):
                pose = self.piece.series(arb(lo).union(arb(hi)) + self.piece.start)
            meet = self._certainly_meet(a, b, tuple(tuple(x[0] for x in row) for row in pose))  # type: ignore[arg-type]
            if meet:
                windows.append((RationalInstant(lo), RationalInstant(hi)))
            elif meet is None:
                cut = lo + (hi - lo) * _SHARE
                waiting += [(cut, hi), (lo, cut)]
        return windows, doubts

    def _certainly_meet(self, a: Primitive, b: Primitive, pose: Matrix) -> bool | None:
        """Whether two primitives share a point in the pose, or in all of a ball of poses; None in doubt."""
        try:
            return a.moved(pose).meets(b)
        except Undecidable:
            return None

    def _contacts_of(self, name: Hashable, pair: Corners, lo: fmpq, hi: fmpq) -> list[RationalInstant]:
        """The contacts of two elements from lo to hi, and maybe such beside: triangles share elements, so that they are
        asked for again over nearly the same time."""
        solved = self._solved.setdefault((name, ctx.prec), [])
        for left, right, instants in solved:
            if left <= lo and hi <= right:
                return instants
        room = min(hi - lo, exact_value(_NEAR) * self.length)
        left, right = lo - room, hi + room
        instants = [self._known(name, root, alone) for root, alone in self._contacts_in(pair, left, right)]
        solved.append((left, right, instants))
        return instants

    def _known(self, name: Hashable, root: arb | fmpq, alone: arb) -> RationalInstant:
        """The instant of that contact of two elements: one object, whichever primitives ask, equal to itself."""
        known = self._instants.setdefault(name, [])
        for instant, around in known:
            if around.contains(root):
                return instant
        known.append((RationalInstant(root), alone))
        return known[-1][0]

    def order(self, x: RationalInstant, y: RationalInstant) -> int:
        """-1, 0, 1: x before, at, after y; Undecidable for different contacts that balls do not tell apart."""
        return 0 if x is y else x.compare(y)

    def _possible_contacts(
        self, a: Primitive, b: Primitive, pairs: list[Named]
    ) -> Iterator[tuple[Hashable, Corners, fmpq, fmpq]]:
        """Pairs of elements, and the times in which floats do not know whether these meet, nor the primitives."""
        for lo, hi in self._open_times(a, b):
            begin, end = max(to_double(lo), 0.0), min(to_double(hi), self.window()[0])
            for name, pair in pairs:
                xa, xb = (np.ravel([[to_double(x) for x in p] for p in (*c, c[-1], c[-1])][:3]) for c in pair)
                for left, right in self._possible_times(pair, xa, xb, begin, end):
                    yield name, pair, exact_value(left), exact_value(right)

    def _open_times(self, a: Primitive, b: Primitive) -> list[tuple[fmpq, fmpq]]:
        """Disjoint times in which the floats do not know whether two primitives meet."""
        xa, xb = (np.array([[to_double(x) for x in p] for p in (*c.corners, c.corners[-1])][:3]) for c in (a, b))
        mask_a, mask_b = (np.int64(FACET if c.is_facet else 0) for c in (a, b))
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
        return [(exact_value(lo), exact_value(hi)) for lo, hi in zones]

    def pose_between(self, x: RationalInstant, y: RationalInstant) -> Matrix:
        """The pose of a at a time between x and y, in balls."""
        with terms(1, _BITS):
            time = (1 - _SHARE) * ball(x.value) + _SHARE * ball(y.value)
            pose = self.piece.series(time + self.piece.start)
            return tuple(tuple(entry[0] for entry in row) for row in pose)  # type: ignore[return-value]

    def float_window(self, lo: float, hi: float) -> tuple[RationalInstant, RationalInstant]:
        """A certain window given by doubles, clipped to the piece."""
        first, last = (min(max(exact_value(x), fmpq(0)), self.length) for x in (lo, hi))
        return RationalInstant(first), RationalInstant(last)

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



def _beside(body: Polyhedron, element: Feature) -> list[Primitive]:
    """The triangles and bare edges that share a corner with the element."""
    corners = vertices_of(body, element)
    primitives = [t for t in body.triangles.tolist() if not set(corners).isdisjoint(t)]
    if not primitives:
        primitives = [s for s in body.segments.tolist() if not set(corners).isdisjoint(s)] or [corners]
    return [Primitive.of([body.exact_vertex(i) for i in p]) for p in primitives]


def _certainly_holds(solid: Polyhedron, body: Polyhedron, element: Feature, pose: Matrix) -> bool:
    """Whether the element is a vertex of the body that certainly lies inside the solid."""
    if not solid.solid or element[0] != VERTEX:
        return False
    try:
        return contains(solid, tree_of(solid), apply(pose, body.exact_vertex(element[1])))
    except Undecidable:
        return False


def _is_flat(pair: Corners) -> bool:
    """Whether one of the elements is a facet without area."""
    return any(len(x) == 3 and not any(cross(*spanning(x))) for x in pair)


def _has_facet(body: Polyhedron, edge: Feature) -> bool:
    """Whether the edge is a side of a triangle."""
    return bool(np.any(np.isin(body.triangles, vertices_of(body, edge)).sum(axis=1) >= 2))


def corners_as_doubles(body: Polyhedron, element: Feature) -> np.ndarray:
    """The corners of an element as the doubles of the body, the last one repeated."""
    kind, index = element
    if kind == FACE:
        rows = body.triangles[index]
    elif kind == EDGE:
        n = len(body.segments)
        rows = body.segments[index][[0, 1, 1]] if index < n else np.full(3, index - n)
    else:
        rows = np.full(3, index)
    return np.ascontiguousarray(body.vertices[rows], np.float64).reshape(9)


def _joined(sharp: arb_series, blurred: arb_series) -> list[arb]:
    """Coefficients about the middle, the last one those of all the time (Lagrange's remainder)."""
    return [*(sharp[k] for k in range(_TERMS - 1)), blurred[_TERMS - 1]]


def _excluded(c: Any, half: arb) -> bool:
    """Whether some condition certainly fails all the time of that half length."""
    return any(_signed(f, half) != 0 for f in c.zero) or any(_signed(f, half) < 0 for f in (*c.least, *c.more))


def _signed(f: list[arb], half: arb) -> int:
    """The sign a function certainly has all the time, else 0."""
    span, power = arb(0), arb(1)
    for c in f[1:]:
        power *= half
        span += abs(c) * power
    return 1 if f[0] > span else -1 if f[0] < -span else 0
