"""One piece of relative rotation: the walk over two trees, and exact answers for pairs of elements.

The local clock of the search is the angle in radians, forward about `axis`; the piece's own rate turns it into time.
"""

from __future__ import annotations

import math
from functools import cmp_to_key
from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb, fmpq

from firstcontact.errors import InputError
from firstcontact.exact.algebraic import algebraic
from firstcontact.exact.instants import AngleInstant, LimitInstant, compare_angles, enclose, same_instant
from firstcontact.exact.numbers import (
    PRECISIONS,
    Undecidable,
    ball,
    ball_bounds,
    dyadic,
    fraction,
    precision,
    sign,
    to_double,
)
from firstcontact.exact.rigid import Matrix, quaternion_rotation
from firstcontact.exact.surd import Surd
from firstcontact.exact.turning import Axis
from firstcontact.exact.vectors import Vector, add, cross, sub
from firstcontact.kernels.angle import TWO_PI
from firstcontact.motion.relative import Piece
from firstcontact.motion.rotation import angle_ball
from firstcontact.pairs import line_line, line_line_rotation, point_plane_rotation, segment_facet
from firstcontact.pairs.point_line_rotation import Contact
from firstcontact.result import ExactAngle
from firstcontact.search import rotate  # noqa: F401 - the walk under this motion
from firstcontact.search.elements import EDGE, VERTEX, Feature, Primitive, corners_of
from firstcontact.search.frame import frame_of, view_in
from firstcontact.search.state import WalkState
from firstcontact.search.walk import walk
from firstcontact.search.windows import collect


class RotationProblem:
    """Body a turns forward about an axis by angles [0, total], body b rests."""

    def __init__(self, a: Any, b: Any, piece: Piece) -> None:
        assert piece.axis is not None and piece.point is not None
        self.a, self.b, self.piece = a, b, piece
        self.backward = _sign_of_angle(piece.rate) < 0
        sense = -1 if self.backward else 1
        self.rate = sense * piece.rate[0], sense * piece.rate[1]
        h, self.origin = piece.axis, piece.point
        self.axis = Axis((-h[0], -h[1], -h[2]) if self.backward else h)
        span = None if piece.end is None else piece.end - piece.start
        self.total = None if span is None else (self.rate[0] * span, self.rate[1] * span)
        self._prepare()

    def _prepare(self) -> None:
        """Views of both trees in the axis frame, with the ranges of their boxes about this axis."""
        frame = frame_of(tuple(to_double(x) for x in self.axis.h))  # type: ignore[arg-type]
        self.tree_a, self.tree_b = view_in(self.a, frame), view_in(self.b, frame)
        origin = [to_double(x) for x in self.origin]
        self.centre = np.array(frame, float)[:2] @ np.array(origin)
        pad = 2.0 * (self.tree_a.error + self.tree_b.error)
        shifted = 0.0
        if any(origin):
            # the centre and the differences to it round: 2^-53 of the sizes each, a few times
            size = max(float(np.abs(t.boxes[0]).max()) for t in (self.tree_a, self.tree_b))
            shifted = 2.0**-50 * (size + 3.0 * max(map(abs, origin)))
        self.error_a, self.error_b = self.tree_a.error + shifted, self.tree_b.error + shifted
        pad = 2.0 * (self.error_a + self.error_b)
        key = (frame, tuple(self.centre.tolist()), pad)
        self.motion = (*_ranges(self.a, self.tree_a, key), *_ranges(self.b, self.tree_b, key), self.centre)

    def window(self) -> tuple[float, float]:
        """(last, sure last) in radians; a full turn at most."""
        if self.total is None or self._beyond_full_turn():
            return TWO_PI + 1e-14, TWO_PI + 1e-14
        lo, hi = ball_bounds(self._total_ball())
        return hi, lo

    def _beyond_full_turn(self) -> bool:
        assert self.total is not None
        radians, turns = self.total
        return turns >= 1 if radians == 0 else bool(self._total_ball() >= 2 * arb.pi())

    def _total_ball(self) -> arb:
        assert self.total is not None
        return angle_ball(self.total[0], "radians") + angle_ball(self.total[1], "turns")

    def advance(self, state: WalkState, limit: int, with_start: bool, all_sides: bool) -> int:
        """Go on with the walk; the reason it came back."""
        a, b = self.tree_a, self.tree_b
        return walk(
            a.boxes, a.links, a.xyz, a.ids, b.boxes, b.links, b.xyz, b.ids,
            self.motion, self.error_a, self.error_b, with_start, all_sides, limit,
            state.floats, state.integers, state.keys, state.pairs, state.stack, state.times, state.candidates,
        )  # fmt: skip

    def _corners(self, element_a: Feature, element_b: Feature) -> tuple[list[Vector], list[Vector]]:
        """Exact corners about the axis' point."""
        o = self.origin
        return (
            [sub(p, o) for p in corners_of(self.a, element_a)],
            [sub(p, o) for p in corners_of(self.b, element_b)],
        )

    def contacts(self, element_a: Feature, element_b: Feature) -> list[Contact]:
        """All contacts of the two elements during one full turn: (instant, point of b about `origin`)."""
        corners_a, corners_b = self._corners(element_a, element_b)
        if element_a[0] == VERTEX:
            return point_plane_rotation.rotation_contacts(self.axis, corners_a[0], *corners_b)
        if element_b[0] == VERTEX:
            back = Axis((-self.axis.h[0], -self.axis.h[1], -self.axis.h[2]))
            found = point_plane_rotation.rotation_contacts(back, corners_b[0], *corners_a)
            return [(instant, corners_b[0]) for instant, _ in found]
        return line_line_rotation.rotation_contacts(self.axis, *corners_a, *corners_b)

    def contact(self, element_a: Feature, element_b: Feature) -> AngleInstant | None:
        """The earliest angle of the window at which the two elements share a point; exact."""
        best = None
        for instant, _ in self.contacts(element_a, element_b):
            if (best is None or instant.compare(best) < 0) and self._in_window(instant):
                best = instant
        return best

    def _in_window(self, instant: AngleInstant) -> bool:
        """Whether the angle is at most the total, exactly.

        A total of nonzero rational radians equals no contact angle (Lindemann), so balls decide; whole turns are
        compared with a full turn.  Two algebraic angles that agree to 2048 bits count as equal.
        """
        if self.total is None or self._beyond_full_turn() or instant.is_zero():
            return True
        for bits in PRECISIONS:
            with precision(bits):
                gap = self._total_ball() - instant.local()
                if gap > 0 or gap < 0:
                    return bool(gap > 0)
        return True

    # -- all windows ----------------------------------------------------------------------------------------

    def collect(self, limit: int, integers: Any, stack: Any, cover: Any, times: Any, parts: Any) -> int:
        """Go on collecting windows (`windows.collect`)."""
        a, b = self.tree_a, self.tree_b
        return collect(
            a.boxes, a.links, a.xyz, a.ids, b.boxes, b.links, b.xyz, b.ids, self.motion,
            self.error_a, self.error_b, self.window()[0], limit, integers, stack, cover, times, parts,
        )  # fmt: skip

    def windows_of(self, primitive_a: int, primitive_b: int) -> list[tuple[Any, Any]]:
        """The windows of contact of two primitives in the first turn, exact.

        Between two consecutive events nothing changes: one look into each gap decides it.
        """
        a, b = Primitive(self.a, self.tree_a, primitive_a), Primitive(self.b, self.tree_b, primitive_b)
        begin, end = self.start_instant(), self.end_instant()
        events = [begin]
        for event in sorted(self._events(a, b), key=cmp_to_key(compare_angles)):
            if compare_angles(event, events[-1]) > 0 and compare_angles(event, end) < 0:
                events.append(event)
            elif compare_angles(event, end) == 0:
                end = event
        events.append(end)
        windows = []
        instants = {id(e) for e in self._touching(events, a, b)}
        start = None
        for left, right in zip(events, events[1:], strict=False):
            if compare_angles(left, right) < 0 and a.moved(self.pose_between(left, right)).meets(b):
                start = left if start is None else start
                continue
            if start is not None:
                windows.append((start, left))
            elif id(left) in instants:
                windows.append((left, left))
            start = None
        if start is not None:
            windows.append((start, events[-1]))
        elif id(events[-1]) in instants and compare_angles(events[-2], events[-1]) < 0:
            windows.append((events[-1], events[-1]))
        return windows

    def _events(self, a: Primitive, b: Primitive) -> list[AngleInstant]:
        """The instants at which the contact of two primitives can change, in [0, 2 pi)."""
        o = self.origin
        sides_a, sides_b = [[sub(p, o) for p in s] for s in a.sides], [[sub(p, o) for p in s] for s in b.sides]
        corners_a, corners_b = [sub(p, o) for p in a.corners], [sub(p, o) for p in b.corners]
        back = Axis((-self.axis.h[0], -self.axis.h[1], -self.axis.h[2]))
        found = [c for x in sides_a for y in sides_b for c in line_line_rotation.rotation_contacts(self.axis, *x, *y)]
        if b.is_facet:
            found += [c for p in corners_a for c in point_plane_rotation.rotation_contacts(self.axis, p, *corners_b)]
        if a.is_facet:
            found += [c for p in corners_b for c in point_plane_rotation.rotation_contacts(back, p, *corners_a)]
        return [instant for instant, _ in found]

    def _touching(self, events: list[Any], a: Primitive, b: Primitive) -> list[Any]:
        """Which of the instants are instants of contact: all events are, the start where the primitives meet."""
        inner = events[1:-1]
        if a.meets(b):
            inner.append(events[0])
        if isinstance(events[-1], AngleInstant):
            inner.append(events[-1])
        return inner

    def float_window(self, lo: float, hi: float) -> tuple[LimitInstant, LimitInstant]:
        """A certain window given by doubles, clipped to the piece."""
        end = self.end_instant()
        last = LimitInstant(fmpq(*hi.as_integer_ratio()), fmpq(0))
        start = LimitInstant(fmpq(*max(lo, 0.0).as_integer_ratio()), fmpq(0))
        return start, last if compare_angles(last, end) < 0 else end

    def start_instant(self) -> LimitInstant:
        return LimitInstant(fmpq(0), fmpq(0))

    def end_instant(self) -> LimitInstant:
        """The end of the piece, a full turn at most."""
        if self.total is None or self._beyond_full_turn():
            return LimitInstant(fmpq(0), fmpq(1))
        return LimitInstant(*self.total)

    def order(self, x: Any, y: Any) -> int:
        """-1, 0, 1: x before, at, after y."""
        return compare_angles(x, y)

    def pose_between(self, x: Any, y: Any) -> Matrix:
        """A rational pose of a at an angle strictly between x and y."""
        with precision(512):
            half = (x.local() + y.local()) / 4
            length = ball(self.axis.K).sqrt()
            # tan(half) = ratio |h|; near a half turn the cotangent is the tame one
            if abs(float(half) - math.pi / 2) < 0.7:
                weight, ratio = dyadic((length * half.cos() / half.sin()).mid()), fmpq(1)
            else:
                weight, ratio = fmpq(1), dyadic((half.sin() / half.cos() / length).mid())
        h = self.axis.h
        return quaternion_rotation(weight, (ratio * h[0], ratio * h[1], ratio * h[2]), self.origin)

    # -- answers --------------------------------------------------------------------------------------------

    def start_relation(self, element_a: Feature, element_b: Feature) -> int:
        """How an edge and a facet relate at the start (`segment_facet.relation`); exact."""
        corners_a, corners_b = corners_of(self.a, element_a), corners_of(self.b, element_b)
        segment, facet = (corners_a, corners_b) if element_a[0] == EDGE else (corners_b, corners_a)
        return segment_facet.relation(*segment, *facet)

    def start_point(self, element_a: Feature, element_b: Feature) -> Vector:
        return segment_facet.start_point(corners_of(self.a, element_a), corners_of(self.b, element_b))

    # -- what users read ------------------------------------------------------------------------------------

    def _moved(self, corners: list[Vector], at: AngleInstant) -> list[Vector]:
        """Corners of a (about `origin`) turned to the instant, as balls."""
        cosine, sine = at.cosine_sine()
        c, s = cosine.ball(), sine.ball()
        h, k = tuple(ball(x) for x in self.axis.h), ball(self.axis.K)
        out = []
        for p in corners:
            x = tuple(ball(v) for v in p)
            along_axis = sum((u * v for u, v in zip(h, x, strict=True)), arb(0)) / k
            foot = tuple(along_axis * v for v in h)
            side = cross(h, x)  # type: ignore[arg-type]
            out.append(tuple(f + c * (v - f) + s * w for f, v, w in zip(foot, x, side, strict=True)))
        return out  # type: ignore[return-value]

    def point(self, element_a: Feature, element_b: Feature, at: AngleInstant) -> Vector:
        """A shared point of the two elements at the instant, in the working frame, as balls."""
        for instant, q in self.contacts(element_a, element_b):
            if same_instant(instant, at):
                return add(tuple(x.ball() if isinstance(x, Surd) else ball(x) for x in q), self.origin)  # type: ignore[arg-type]
        raise ArithmeticError("the elements do not meet at this instant")

    def normal(self, element_a: Feature, element_b: Feature, at: AngleInstant) -> tuple[Vector, Vector]:
        """(direction across the contact, velocity of a there), working frame, as balls.

        The direction is zero where exact arithmetic says that it is undefined: parallel edges, grazing.
        """
        corners_a, corners_b = self._corners(element_a, element_b)
        moved = self._moved(corners_a, at)
        if element_a[0] == VERTEX:
            n = line_line.normal(corners_b[0], corners_b[1], corners_b[0], corners_b[2])
        elif element_b[0] == VERTEX:
            n = line_line.normal(moved[0], moved[1], moved[0], moved[2])
        else:
            n = line_line.normal(*moved, *corners_b)
        point = sub(self.point(element_a, element_b, at), self.origin)
        return n, cross(self.axis.h, point)

    def world_instant(self, at: Any, turn: int = 0) -> tuple[float, tuple[float, float]]:
        """(nearest double, enclosure) of the instant, `turn` full turns later, in the motions' clock."""
        exact = self._rational_time(at, turn)
        return enclose(lambda: self._time(at.local() + 2 * turn * arb.pi()) if exact is None else exact)

    def _time(self, angle: arb) -> arb:
        per_time = angle_ball(self.rate[0], "radians") + angle_ball(self.rate[1], "turns")
        return self.piece.start + angle / per_time

    def _rational_time(self, at: Any, turn: int = 0) -> fmpq | None:
        """The time where it is rational because the angle is: quarter turns, the end of the motion."""
        if isinstance(at, LimitInstant):
            if self.total is not None and (at.radians, at.turns + turn) == self.total:
                return self.piece.end
            share, turns = at.radians, at.turns + turn
        else:
            quarter = at.quarter() if at.is_rational() else None
            if quarter is None:
                return None
            share, turns = fmpq(0), fmpq(quarter, 4) + turn
        if share == 0 and turns == 0:
            return self.piece.start
        for unit, other, angle in ((0, 1, share), (1, 0, turns)):
            if self.rate[other] == 0 and (share, turns)[other] == 0:
                return self.piece.start + angle / self.rate[unit]
        return None

    def world_exact(self, at: Any, turn: int = 0) -> Fraction | ExactAngle | None:
        """The exact time: a Fraction where it is one, otherwise the angle by its cosine and sine."""
        exact = self._rational_time(at, turn)
        if exact is not None:
            return fraction(exact)
        if not at.is_rational():
            return None
        cosine, sine = at.cosine_sine()
        return ExactAngle(algebraic(cosine, fmpq(1)), algebraic(sine, at.K), self.world_instant(at, turn)[0])

    def is_end(self, at: Any, turn: int) -> bool:
        """Whether the instant, `turn` full turns later, is the end of the piece."""
        return self.total is not None and compare_angles(at, LimitInstant(self.total[0], self.total[1] - turn)) == 0

    def repeated(self, windows: list[tuple[Any, Any]]) -> list[tuple[Any, int, Any, int]]:
        """The windows of the first turn, (start, turn, end, turn), through all turns of the piece."""
        if self.total is None:
            raise InputError("contact_intervals needs a bounded span for a rotation; give span=(first, last)")
        if not self._beyond_full_turn():
            return [(start, 0, end, 0) for start, end in windows]
        out: list[tuple[Any, int, Any, int]] = []
        full, turn = LimitInstant(fmpq(0), fmpq(1)), 0
        while compare_angles(left := LimitInstant(self.total[0], self.total[1] - turn), self.start_instant()) >= 0:
            for start, end in windows:
                if compare_angles(start, left) > 0:
                    break
                end, last = (end, turn) if compare_angles(end, left) <= 0 else (left, turn)
                joined = out and start.is_zero() and out[-1][3] == turn - 1 and compare_angles(out[-1][2], full) == 0
                if joined:
                    out[-1] = (*out[-1][:2], end, last)
                else:
                    out.append((start, turn, end, last))
            if compare_angles(left, full) < 0:
                break
            turn += 1
        return out

    def world_time(self, local: float) -> float:
        """A double not later than the local angle, in the motions' clock."""
        if math.isinf(local) or local >= TWO_PI:
            return math.inf if self.piece.end is None else to_double(self.piece.end)
        with precision(PRECISIONS[0]):
            t = ball_bounds(self._time(arb(max(local, 0.0))))[0]
        return max(t, to_double(self.piece.start))


def _sign_of_angle(rate: tuple[fmpq, fmpq]) -> int:
    """Sign of radians + 2 pi turns, not both zero (then it is never zero: pi is irrational)."""
    for bits in PRECISIONS:
        with precision(bits):
            try:
                return sign(angle_ball(rate[0], "radians") + angle_ball(rate[1], "turns"))
            except Undecidable:
                continue
    raise Undecidable


def _ranges(body: Any, tree: Any, key: Any) -> tuple[np.ndarray, np.ndarray]:
    """Arrays for the ranges of the tree's boxes about the axis; kept while the axis stays the same."""
    cached = body._search.get("ranges")
    if cached is None or cached[0] != key:
        n = len(tree.boxes)
        cached = body._search["ranges"] = key, np.empty((n, 4)), np.zeros(n, np.uint8)
    return cached[1], cached[2]
