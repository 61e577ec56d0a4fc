"""One piece of relative rotation: the walk over two trees, and exact answers for pairs of elements.

The local clock of the search is the angle in radians, forward about `axis`; the piece's own rate turns it into time.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb, fmpq

from firstcontact.exact.algebraic import algebraic
from firstcontact.exact.instants import AngleInstant, enclose, same_instant
from firstcontact.exact.numbers import (
    PRECISIONS,
    Undecidable,
    ball,
    ball_bounds,
    fraction,
    precision,
    sign,
    to_double,
)
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
from firstcontact.search.elements import EDGE, VERTEX, Feature, corners_of
from firstcontact.search.frame import frame_of, view_in
from firstcontact.search.state import WalkState
from firstcontact.search.walk import walk


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

    def world_instant(self, at: AngleInstant) -> tuple[float, tuple[float, float]]:
        """(nearest double, enclosure) of the instant in the motions' clock."""
        exact = self._rational_time(at)
        return enclose(lambda: self._time(at.local()) if exact is None else exact)

    def _time(self, angle: arb) -> arb:
        per_time = angle_ball(self.rate[0], "radians") + angle_ball(self.rate[1], "turns")
        return self.piece.start + angle / per_time

    def _rational_time(self, at: AngleInstant) -> fmpq | None:
        """The time where the angle is a whole number of quarter turns and so is a rational time."""
        if self.rate[0] != 0 or not at.is_rational():
            return self.piece.start if at.is_zero() else None
        quarter = at.quarter()
        return None if quarter is None else self.piece.start + fmpq(quarter, 4) / self.rate[1]

    def world_exact(self, at: AngleInstant) -> Fraction | ExactAngle | None:
        """The exact time: a Fraction where it is one, otherwise the angle by its cosine and sine."""
        exact = self._rational_time(at)
        if exact is not None:
            return fraction(exact)
        if not at.is_rational():
            return None
        cosine, sine = at.cosine_sine()
        return ExactAngle(algebraic(cosine, fmpq(1)), algebraic(sine, at.K), self.world_instant(at)[0])

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
