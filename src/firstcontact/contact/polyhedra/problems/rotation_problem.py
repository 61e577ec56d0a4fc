"""One piece of relative rotation: the walk over two trees, and exact answers for pairs of elements.

The local clock of the search is the angle in radians, forward about `axis`, from the pose at the piece's
reference time; the piece's own rate turns it into time.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from fractions import Fraction
from functools import cached_property, cmp_to_key
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import arb, fmpq

from firstcontact.body.kept import Kept
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.engines import ByEngine
from firstcontact.errors import InputError
from firstcontact.exact.fields.algebraic import algebraic
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
from firstcontact.exact.times.instants import (
    AngleInstant,
    LimitInstant,
    TurnInstant,
    compare_angles,
    enclose,
    same_instant,
)
from firstcontact.exact.times.turning import Axis
from firstcontact.exact.vectors import Vector, divisible, scaled, sub, whole
from firstcontact.kernels.angle import TWO_PI
from firstcontact.motion.relative.pieces import MotionPiece
from firstcontact.motion.rotation import angle_ball
from firstcontact.pairs.elements import coplanar, line_line_rotation, point_plane_rotation, segment_facet
from firstcontact.pairs.elements.point_line_rotation import Contact
from firstcontact.result import ExactAngle
from firstcontact.search.trees import rotate  # noqa: F401 - the walk under this motion
from firstcontact.search.trees.containment import contained
from firstcontact.search.trees.cylinder import COLUMNS
from firstcontact.search.trees.elements import (
    EDGE,
    VERTEX,
    Corners,
    Feature,
    Primitive,
    Scale,
    WholeCorners,
    corners_of,
)
from firstcontact.search.trees.frame import frame_of, view_in
from firstcontact.search.trees.touch import Touch, place_doubles, rotation_normal
from firstcontact.search.trees.tree import Tree

if TYPE_CHECKING:
    from collections.abc import Sequence

Angle = tuple[fmpq, fmpq]  # radians, turns
Window = tuple[TurnInstant, TurnInstant]

# Squares of lengths below it leave the range of doubles.
LOST_LENGTH = 2.0**-500

_ZERO = fmpq(0), fmpq(0)
_FULL = fmpq(0), fmpq(1)


class WindowBegin(LimitInstant):
    """The angle at which a piece begins that is a window of a turn: the zero of the piece's time."""

    def is_zero(self) -> bool:
        return True


class RotationProblem(ByEngine):
    """Body a turns forward about an axis by angles [first, last] after `turn` whole turns, body b rests.

    Angles are pairs (radians, turns).  A piece that starts at another time than its reference starts at the
    angle `opening` of the first turn; the problem searches that turn from zero, its `parts` from there.
    """

    def __init__(self, a: Polyhedron, b: Polyhedron, piece: MotionPiece) -> None:
        assert piece.axis is not None and piece.point is not None
        self.a, self.b, self.piece = a, b, piece
        self.is_exact = a.irrational_pose is None and b.irrational_pose is None
        self._contacts: dict[tuple[Feature, Feature], list[Contact]] = {}
        self.backward = _sign_of_angle(piece.rate) < 0
        sense = -1 if self.backward else 1
        self.rate = sense * piece.rate[0], sense * piece.rate[1]
        h, self.origin = piece.axis, piece.point
        self._corners = Corners(a, b, self.origin)
        _, (direction,) = whole(h)
        self._whole_axis = Axis(scaled(-1, direction) if self.backward else direction)
        self.first, self.opening, self.turn = _ZERO, _ZERO, 0
        if piece.reference != piece.start:
            radians, turns = self._angle_at(piece.start)
            self.turn = _whole_turns(radians, turns)
            self.opening = radians, turns - self.turn
        self.last = None if piece.end is None else self._angle_at(piece.end)
        if self.last is not None and self.turn:
            self.last = self.last[0], self.last[1] - self.turn
        self._window: tuple[float, float] | None = None
        self._prepare()

    @cached_property
    def axis(self) -> Axis:
        """The axis in numbers that divide."""
        return Axis(*divisible(self._whole_axis.h))

    def _angle_at(self, time: fmpq) -> tuple[fmpq, fmpq]:
        """(radians, turns) forward from the reference."""
        passed = time - self.piece.reference
        return self.rate[0] * passed, self.rate[1] * passed

    def parts(self) -> list[RotationProblem]:
        """The problem from its opening on, one turn at most, as problems within one turn each."""
        if self.opening == _ZERO:
            return [self]
        # a turn that ends with the last instant is none of this: its contacts there have the angle zero of the next one
        if self.last is not None and compare_angles(LimitInstant(*self.last), LimitInstant(*_FULL)) < 0:
            return [self._part(0, self.opening, self.last)]
        rest = self.opening if self.last is None else (self.last[0], self.last[1] - 1)
        if compare_angles(LimitInstant(*rest), LimitInstant(*self.opening)) > 0:
            rest = self.opening
        return [self.after_opening(), self._part(1, _ZERO, rest)]

    def _part(self, turn: int, first: Angle, last: Angle) -> RotationProblem:
        part = copy.copy(self)
        part._window = None
        part.turn, part.first, part.last, part.opening = self.turn + turn, first, last, _ZERO
        return part

    def until(self, radians: fmpq, turns: fmpq) -> RotationProblem:
        """The same problem, which ends at that angle."""
        return self._part(0, self.first, (radians, turns))

    def after_opening(self) -> RotationProblem:
        """The rest of the first turn from the opening on, whenever the piece ends."""
        return self._part(0, self.opening, _FULL)

    @property
    def begin(self) -> tuple[float, float]:
        """Doubles (not after, not before) around the angle `first`."""
        return (0.0, 0.0) if self.first is _ZERO else ball_bounds(LimitInstant(*self.first).local())

    def _prepare(self) -> None:
        """Views of both trees in the axis frame, with the ranges of their boxes about this axis."""
        h = [int(x) for x in self._whole_axis.h]
        longest = max(map(abs, h))
        frame = frame_of((h[0] / longest, h[1] / longest, h[2] / longest))
        self.tree_a, self.tree_b = view_in(self.a, frame), view_in(self.b, frame)
        self.boxes_a, self.boxes_b = self.tree_a.boxes, self.tree_b.boxes
        origin = [to_double(x) for x in self.origin]
        self.centre = tuple(row[0] * origin[0] + row[1] * origin[1] + row[2] * origin[2] for row in frame[:2])
        shifted = LOST_LENGTH
        if any(origin):
            # the centre and the differences to it round: 2^-53 of the sizes each, a few times
            size = max(map(abs, (*self.tree_a.boxes[0].tolist(), *self.tree_b.boxes[0].tolist())))
            shifted += 2.0**-50 * (size + 3.0 * max(map(abs, origin)))
        self.error_a, self.error_b = self.tree_a.error + shifted, self.tree_b.error + shifted
        self.pad = 2.0 * (self.error_a + self.error_b)
        key = (frame, self.centre, self.pad)
        self.motion = _ranges(self.a, self.tree_a, self.tree_b, key)

    def window(self) -> tuple[float, float]:
        """(last, sure last) in radians; a full turn at most."""
        if self._window is None:
            lo = hi = TWO_PI + 1e-14
            if self.last is not None and not self.last[1] and self.last[0] < 6:
                t = to_double(self.last[0])
                lo, hi = math.nextafter(t, -math.inf), math.nextafter(t, math.inf)
            elif not (self.last is None or self._beyond_full_turn()):
                with precision(PRECISIONS[0]):
                    lo, hi = ball_bounds(self._last_ball())
            self._window = hi, lo
        return self._window

    def _beyond_full_turn(self) -> bool:
        assert self.last is not None
        radians, turns = self.last
        return turns >= 1 if radians == 0 else bool(self._last_ball() >= 2 * arb.pi())

    def _last_ball(self) -> arb:
        assert self.last is not None
        return angle_ball(self.last[0], "radians") + angle_ball(self.last[1], "turns")

    def contacts(self, element_a: Feature, element_b: Feature) -> list[Contact]:
        """All contacts of the two elements during one full turn: (instant, point of b about `origin`)."""
        key = element_a, element_b
        if not self.is_exact:  # balls depend on the precision
            return self._find_contacts(*key)
        if key not in self._contacts:
            self._contacts[key] = self._find_contacts(*key)
        return self._contacts[key]

    def _find_contacts(self, element_a: Feature, element_b: Feature) -> list[Contact]:
        """The contacts from corners in whole numbers: angles stay, and no sum has to find a denominator."""
        scale, a, b = _about_origin(self._corners.whole, element_a, element_b)
        axis = self._whole_axis
        if element_a[0] == VERTEX:
            found = point_plane_rotation.rotation_contacts(axis, a[0], *b)
        elif element_b[0] == VERTEX:
            back = point_plane_rotation.rotation_contacts(axis.reversed(), b[0], *a)
            found = [(instant, (*b[0], 1)) for instant, _ in back]
        else:
            found = line_line_rotation.rotation_contacts(axis, *a, *b)
        return [(instant, (x, y, z, w * scale)) for instant, (x, y, z, w) in found]

    def contact(self, element_a: Feature, element_b: Feature) -> AngleInstant | None:
        """The earliest angle of the window at which the two elements share a point; exact."""
        best = None
        for instant, _ in self.contacts(element_a, element_b):
            if (best is None or instant.compare(best) < 0) and self._in_window(instant):
                best = instant
        return best

    def contact_within(self, element_a: Feature, element_b: Feature, lo: float, hi: float) -> AngleInstant | None:
        """The first contact of the two elements, of which floats have proved that it is in [lo, hi]; exact."""
        if self.is_exact:
            _, a, b = _about_origin(self._corners.ints, element_a, element_b)
            instant = coplanar.rotation_instant(self._whole_axis, a, b, lo, hi)
            if instant is not None:
                return instant
        return self.contact(element_a, element_b)

    def _in_window(self, instant: AngleInstant) -> bool:
        """Whether the angle lies in [first, last], exactly.

        A limit of nonzero rational radians equals no contact angle (Lindemann), so balls decide; whole turns
        are compared with a full turn.  Two algebraic angles that agree to 2048 bits count as equal.
        """
        if self.first is not _ZERO and compare_angles(instant, LimitInstant(*self.first)) < 0:
            return False
        if instant.bounds()[1] <= self.window()[1]:
            return True
        if self.last is None or self._beyond_full_turn() or instant.is_zero():
            return True
        for bits in PRECISIONS:
            with precision(bits):
                gap = self._last_ball() - instant.local()
                if gap > 0 or gap < 0:
                    return bool(gap > 0)
        return True

    def possible(self, element_a: Feature, element_b: Feature) -> float:
        """A time before which the two elements, which no precision could decide, certainly do not meet."""
        return 0.0

    # -- all windows ----------------------------------------------------------------------------------------

    def windows_of(self, primitive_a: int, primitive_b: int) -> list[Window]:
        """The windows of contact of two primitives in the first turn, exact."""
        a, b = Primitive(self.a, self.tree_a, primitive_a), Primitive(self.b, self.tree_b, primitive_b)
        return self._windows(a, b)

    def meet_at_opening(self, element_a: Feature, element_b: Feature) -> bool:
        """Whether the two elements share a point at the opening; exact: it asks only the rational pose."""
        a, b = Primitive.of(corners_of(self.a, element_a)), Primitive.of(corners_of(self.b, element_b))
        opening = LimitInstant(*self.opening)
        return any(
            compare_angles(start, opening) <= 0 <= compare_angles(end, opening)
            for start, end in self._windows(a, b)
        )

    def _windows(self, a: Primitive, b: Primitive) -> list[Window]:
        """Between two consecutive events nothing changes: one look into each gap decides it."""
        end: TurnInstant = self.end_instant()
        events: list[TurnInstant] = [self.start_instant()]
        for event in sorted(self._events(a, b), key=cmp_to_key(compare_angles)):
            if compare_angles(event, events[-1]) > 0 and compare_angles(event, end) < 0:
                events.append(event)
            elif compare_angles(event, end) == 0:
                end = event
        events.append(end)
        windows: list[Window] = []
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

    def _touching(self, events: list[TurnInstant], a: Primitive, b: Primitive) -> list[TurnInstant]:
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
        return LimitInstant(*self.first)

    def end_instant(self) -> LimitInstant:
        """The end of the search, a full turn at most."""
        if self.last is None or self._beyond_full_turn():
            return LimitInstant(*_FULL)
        return LimitInstant(*self.last)

    def order(self, x: TurnInstant, y: TurnInstant) -> int:
        """-1, 0, 1: x before, at, after y."""
        return compare_angles(x, y)

    def pose_between(self, x: TurnInstant, y: TurnInstant) -> Matrix:
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
        _, corners_a, corners_b, _ = self._corners.ints.of(element_a, element_b)
        segment, facet = (corners_a, corners_b) if element_a[0] == EDGE else (corners_b, corners_a)
        return segment_facet.relation(*segment, *facet)

    def start_point(self, element_a: Feature, element_b: Feature) -> Vector:
        return segment_facet.start_point(corners_of(self.a, element_a), corners_of(self.b, element_b))

    def between(self, lo: float, hi: float) -> None:
        """None: its instants are exact angles; the motions themselves tell what balls can (`polyhedra.first`)."""

    def is_contained(self) -> bool:
        """Whether a body lies inside the other one at the start; their surfaces share no point."""
        return contained(self.a, self.b) is not None

    # -- what users read ------------------------------------------------------------------------------------

    def touch(self, element_a: Feature, element_b: Feature, at: TurnInstant) -> Touch:
        """(point, unit normal or None) of the two elements at the instant, working frame."""
        contacts = self.contacts(element_a, element_b)
        point = next(q for instant, q in contacts if len(contacts) == 1 or same_instant(instant, at))
        where = place_doubles(point)
        _, corners_a, corners_b = _about_origin(self._corners.whole, element_a, element_b)
        normal = rotation_normal(corners_a, corners_b, self._whole_axis, point, where, at)
        return np.array([x + to_double(y) for x, y in zip(where, self.origin, strict=True)]), normal

    def world_instant(self, at: TurnInstant, turn: int = 0) -> tuple[float, tuple[float, float]]:
        """(nearest double, enclosure) of the instant, `turn` full turns later, in the motions' clock."""
        exact = self._rational_time(at, turn)
        return enclose(lambda: self._time(at.local(), turn) if exact is None else exact)

    def _time(self, angle: arb, turn: int = 0) -> arb:
        radians, turns = self.rate
        per_time = angle_ball(turns, "turns") + radians if turns else arb(radians)
        passed = turn + self.turn
        return self.piece.reference + (angle_ball(fmpq(passed), "turns") + angle if passed else angle) / per_time

    def _rational_time(self, at: TurnInstant, turn: int = 0) -> fmpq | None:
        """The time where it is rational because the angle is: quarter turns, the limits of the motion."""
        if isinstance(at, LimitInstant):
            share, turns = at.radians, at.turns + turn + self.turn
        else:
            quarter = at.quarter() if at.is_rational() else None
            if quarter is None:
                return None
            share, turns = fmpq(0), fmpq(quarter, 4) + turn + self.turn
        for time in (self.piece.start, self.piece.end):
            if time is not None and self._angle_at(time) == (share, turns):
                return time
        for unit, other, angle in ((0, 1, share), (1, 0, turns)):
            if self.rate[other] == 0 and (share, turns)[other] == 0:
                return self.piece.reference + angle / self.rate[unit]
        return None

    def world_exact(self, at: Any, turn: int = 0) -> Fraction | ExactAngle | None:
        """The exact time: a Fraction where it is one, otherwise the angle by its cosine and sine."""
        exact = self._rational_time(at, turn)
        if exact is not None:
            return fraction(exact)
        if not at.is_rational():
            return None
        cosine, sine = at.cosine_sine()
        return ExactAngle(algebraic(cosine, fmpq(1)), algebraic(sine, self.axis.K), self.world_instant(at, turn)[0])

    def is_end(self, at: TurnInstant, turn: int) -> bool:
        """Whether the instant, `turn` full turns later, is the end of the piece."""
        if self.last is None:
            return False
        return compare_angles(at, LimitInstant(self.last[0], self.last[1] - turn)) == 0

    def repeated(self, windows: list[Window]) -> Iterator[tuple[TurnInstant, int, TurnInstant, int]]:
        """The windows of the first turn, (start, turn, end, turn), through all turns of the piece."""
        if self.last is None:
            raise InputError("contact_intervals needs a bounded span for a rotation; give span=(first, last)")
        opened = self._from_opening(windows)
        if not self._beyond_full_turn():
            yield from ((start, 0, end, 0) for start, end in opened)
            return
        full = LimitInstant(fmpq(0), fmpq(1))
        if [(start.is_zero(), compare_angles(end, full)) for start, end in windows] == [(True, 0)]:  # for ever
            turns = _whole_turns(*self.last)
            yield opened[0][0], 0, LimitInstant(self.last[0], self.last[1] - turns), turns
            return
        held: tuple[TurnInstant, int, TurnInstant, int] | None = None  # the next turn may go on with it
        turn = 0
        while compare_angles(left := LimitInstant(self.last[0], self.last[1] - turn), self.start_instant()) >= 0:
            for start, end in windows if turn else opened:
                if compare_angles(start, left) > 0:
                    break
                end = end if compare_angles(end, left) <= 0 else left
                if held and start.is_zero() and held[3] == turn - 1 and compare_angles(held[2], full) == 0:
                    held = (*held[:2], end, turn)
                else:
                    if held:
                        yield held
                    held = start, turn, end, turn
            if not windows or compare_angles(left, full) < 0:
                break
            turn += 1
        if held:
            yield held

    def _from_opening(self, windows: list[Window]) -> list[Window]:
        """The windows of the first turn, from the opening on."""
        if self.opening == _ZERO:
            return windows
        opening = LimitInstant(*self.opening)
        return [
            (start if compare_angles(start, opening) > 0 else WindowBegin(*self.opening), end)
            for start, end in windows
            if compare_angles(end, opening) >= 0
        ]

    def world_time(self, local: float) -> float:
        """A double not later than the local angle, in the motions' clock."""
        if local >= TWO_PI and self.first is _ZERO:  # a whole turn without contact: so are all others
            return math.inf if self.piece.end is None else to_double(self.piece.end)
        with precision(PRECISIONS[0]):
            t = ball_bounds(self._time(arb(min(max(local, 0.0), TWO_PI))))[0]
        return max(t, to_double(self.piece.start))


def _sign_of_angle(rate: tuple[fmpq, fmpq]) -> int:
    """Sign of radians + 2 pi turns, not both zero (then it is never zero: pi is irrational)."""
    if not (rate[0] and rate[1]):
        return sign(rate[0] or rate[1])
    for bits in PRECISIONS:
        with precision(bits):
            try:
                return sign(angle_ball(rate[0], "radians") + angle_ball(rate[1], "turns"))
            except Undecidable:
                continue
    raise Undecidable


def _whole_turns(radians: fmpq, turns: fmpq) -> int:
    """The largest whole number of turns not beyond the angle."""
    if radians == 0:
        return int(turns.p) // int(turns.q)
    bits = PRECISIONS[0]
    while True:  # nonzero rational radians are no rational number of turns: some precision tells
        with precision(bits):
            whole = (arb(radians) / (2 * arb.pi()) + arb(turns)).floor().unique_fmpz()
        if whole is not None:
            return int(whole)
        bits *= 2


_RANGES = Kept[tuple[Any, Tree, Tree, np.ndarray]]()


def _ranges(body: Polyhedron, tree_a: Tree, tree_b: Tree, key: tuple[object, Sequence[float], object]) -> np.ndarray:
    """The array walks fill with ranges of nodes; kept while trees and axis stay the same."""
    cached = _RANGES.get(body)
    if cached is None or cached[0] != key or cached[1] is not tree_a or cached[2] is not tree_b:
        q, r = len(tree_a.boxes), len(tree_b.boxes)
        ranges = np.zeros((q + r + 1, COLUMNS))
        ranges[-1, :3] = (*key[1], q)
        cached = _RANGES.put(body, (key, tree_a, tree_b, ranges))
    return cached[3]


def _about_origin(
    corners: WholeCorners, element_a: Feature, element_b: Feature
) -> tuple[Scale, list[Vector], list[Vector]]:
    """(scale, scale times the exact corners about the axis' point)."""
    scale, a, b, o = corners.of(element_a, element_b)
    return (scale, [sub(p, o) for p in a], [sub(p, o) for p in b]) if any(o) else (scale, a, b)
