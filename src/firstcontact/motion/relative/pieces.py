"""Two moving bodies -> one: pieces of time in which the relative motion is one translation, one rotation, or curved.

In every piece of the first two kinds both bodies stand placed at its reference time, b is at rest in the working
frame, and a moves in it.  The working frame itself follows b: `carry` brings points of it back to the world.
Curved pieces (`curved`) hold both motions.

The reference is the start of the piece, but where a rotation's pose is irrational there: then it is the
time at which the rotation began in a rational pose, or would have begun with the turns about its axis before it, and
the piece is a window of its angles.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from flint import fmpq

from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.exact.numbers import to_double
from firstcontact.exact.vectors import scaled, sub
from firstcontact.motion.moving import Moving
from firstcontact.motion.placement import HERE, Placement, Turn, angle_of
from firstcontact.motion.product import Product
from firstcontact.motion.rational import RationalMotion
from firstcontact.motion.relative.curved import CurvedPiece, Leg
from firstcontact.motion.rotation import Rotation, rotation_matrix, sense_about, turns_of
from firstcontact.motion.screw import Screw
from firstcontact.motion.sequence import Sequence
from firstcontact.motion.steps import RESTING, Step, steps_of
from firstcontact.motion.translation import Translation

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.motion.kinds import AnyMotion

_0 = fmpq(0)
# Motions of which two may be one, and all that polyhedra can be followed under.
SIMPLE = Translation, Rotation
SUPPORTED = *SIMPLE, Screw, RationalMotion, Product
# Full turns that polynomials over cells of time follow well.  Bodies tend to be aligned after simple shares of a turn:
# at no such place is a motion cut.
FEW_TURNS = fmpq(316, 101)


class MotionPiece(NamedTuple):
    """Relative motion of a seen from b during [start, end] (end None: for ever); local time is t - reference.

    velocity (translation) per unit of time, or axis, point and rate (radians, turns) per unit of time.
    steps: what both bodies make of their motions, of a piece of these.
    """

    start: fmpq
    end: fmpq | None
    reference: fmpq
    place_a: Placement
    place_b: Placement
    velocity: tuple[fmpq, fmpq, fmpq] | None
    axis: tuple[fmpq, fmpq, fmpq] | None
    point: tuple[fmpq, fmpq, fmpq] | None
    rate: tuple[fmpq, fmpq]
    carry_velocity: tuple[fmpq, fmpq, fmpq] | None = None
    carry_rate: tuple[fmpq, fmpq] | None = None
    steps: tuple[Step, Step] | None = None

    def carry(self, t: float) -> np.ndarray | None:
        """Float pose (4, 4) of the working frame in the world at time t; None where it rests."""
        local = t - to_double(self.reference)
        if self.carry_velocity is not None:
            pose = np.eye(4)
            pose[:3, 3] = [to_double(x) * local for x in self.carry_velocity]
            return pose
        if self.carry_rate is not None and self.axis is not None and self.point is not None:
            angle = (to_double(self.carry_rate[0]) + 2 * np.pi * to_double(self.carry_rate[1])) * local
            axis, point = (np.array([to_double(x) for x in v]) for v in (self.axis, self.point))
            return rotation_matrix(axis, point, angle)
        return None

    def turn_from_rest(self) -> tuple[fmpq, fmpq] | None:
        """(radians, turns) of a rotation of bodies that stand as they are given at first; None of any other piece."""
        if self.axis is None or self.end is None or self.velocity is not None or self.reference != self.start:
            return None
        return None if self.place_a.factors or self.place_b.factors else _times(self.end - self.start, self.rate)

    def at_start(self) -> MotionPiece:
        """The instant in which a rotation's window starts, both bodies as they stand in the world then."""
        assert self.axis is not None and self.point is not None
        passed, carry = self.start - self.reference, self.carry_rate or (_0, _0)
        rate_a = self.rate[0] + carry[0], self.rate[1] + carry[1]
        turn_a, turn_b = (Turn(self.axis, self.point, *_times(passed, rate)) for rate in (rate_a, carry))
        placed = self.place_a.then(turn_a), self.place_b.then(turn_b)
        return MotionPiece(self.start, self.start, self.start, *placed, (_0, _0, _0), None, None, (_0, _0))


def pieces(a: Body, b: Body, first: fmpq, last: fmpq | None) -> list[MotionPiece | CurvedPiece]:
    """The pieces of the relative motion over [first, last], in time order.

    Raises UnsupportedPair for motions of other classes.
    """
    steps_a, steps_b = _steps(a), _steps(b)
    if len(steps_a) == len(steps_b) == 1:
        return [_reduce(a, b, steps_a[0], steps_b[0], first, last)]
    assert last is not None  # sequences have bounded spans
    times = _cut(steps_a, steps_b, first, last)
    if first < last and any(_jumps_at(body, last) for body in (a, b)):
        times.append((last, last))  # the span is closed
    return [_reduce(a, b, _step_at(steps_a, t0), _step_at(steps_b, t0), t0, t1) for t0, t1 in times]


def curved_pieces(a: Body, b: Body, first: fmpq, last: fmpq) -> list[CurvedPiece]:
    """The pieces over [first, last] by the motions themselves, whatever they are: poses as power series at any time."""
    steps_a, steps_b = _steps(a), _steps(b)
    return [
        _curved(a, b, _step_at(steps_a, t0), _step_at(steps_b, t0), t0, t1)
        for t0, t1 in _cut(steps_a, steps_b, first, last)
    ]


def by_motions(a: Body, b: Body, piece: MotionPiece) -> CurvedPiece | None:
    """A piece of the motions of both, one that has an end, by these motions themselves."""
    if piece.steps is None or piece.end is None:
        return None
    return _curved(a, b, *piece.steps, piece.start, piece.end)


def in_few_turns(piece: CurvedPiece) -> Iterator[CurvedPiece]:
    """Stretches of the piece, one after the other, each of a few turns at most."""
    speed = max(turns_of(leg.motion) / leg.unit for leg in (piece.leg_a, piece.leg_b))
    start = piece.start
    while speed and (end := start + FEW_TURNS / speed) < piece.end:
        yield replace(piece, start=start, end=end)
        start = end
    yield piece if start == piece.start else replace(piece, start=start)


def placement_at(body: Body, time: fmpq) -> Placement:
    """Where the body stands at the time, one of its motion's span."""
    return _step_at(_steps(body), time).pose(time)


def _cut(steps_a: list[Step], steps_b: list[Step], first: fmpq, last: fmpq) -> list[tuple[fmpq, fmpq]]:
    """The stretches of [first, last] in which both bodies make one step; the first one goes on before its start."""
    inside = [s.end for s in (*steps_a, *steps_b) if s.end is not None and first < s.end < last]
    if not inside:
        return [(first, last)]  # a rational number takes microseconds to hash
    return list(pairwise(sorted({first, last, *inside})))


def _jumps_at(body: Body, time: fmpq) -> bool:
    return isinstance(body, Moving) and isinstance(body.motion, Sequence) and time in body.motion.jumps


def _step_at(steps: list[Step], time: fmpq) -> Step:
    """The step that is made from that time on."""
    return steps[max(0, bisect_right(steps, time, key=lambda s: s.start) - 1)]


def _steps(body: Body) -> list[Step]:
    if not isinstance(body, Moving):
        return [RESTING]
    if isinstance(body.motion, SIMPLE):
        return [Step(_0, None, body.motion, HERE)]
    for k, part in enumerate(getattr(body.motion, "steps", [body.motion])):
        if not isinstance(part, SUPPORTED):
            where = f"step {k} of the Sequence, " if isinstance(body.motion, Sequence) else ""
            raise UnsupportedPair(
                f"{where}{part!r} of {_who(body)}: polyhedra take Translation, Rotation, Screw, RationalMotion, "
                "Trajectory and a Sequence of them"
            )
    return list(steps_of(body.motion))


def _times(factor: fmpq, rate: tuple[fmpq, fmpq]) -> tuple[fmpq, fmpq]:
    return factor * rate[0], factor * rate[1]


def _rests(motion: AnyMotion) -> bool:
    if isinstance(motion, Translation):
        return not any(motion.vector)
    return isinstance(motion, Rotation) and motion.angle == 0


def _reduce(a: Body, b: Body, step_a: Step, step_b: Step, start: fmpq, end: fmpq | None) -> MotionPiece | CurvedPiece:
    """One piece; the table of section 6 of the derivation: which pairs of motions are one motion.

    All others are curved.
    """
    motion_a, motion_b = step_a.motion, step_b.motion
    if not (_is_straight_or_turn(step_a) and _is_straight_or_turn(step_b)):
        return _curved(a, b, step_a, step_b, start, end)
    rest_a, rest_b = _rests(motion_a), _rests(motion_b)
    straight_a = rest_a or isinstance(motion_a, Translation)
    straight_b = rest_b or isinstance(motion_b, Translation)
    if straight_a and straight_b:
        v_a, v_b = _velocity(step_a, rest_a), _velocity(step_b, rest_b)
        return MotionPiece(
            start, end, start, step_a.pose(start), step_b.pose(start),
            sub(v_a, v_b), None, None, (_0, _0),
            carry_velocity=v_b if any(v_b) else None, steps=(step_a, step_b),
        )  # fmt: skip
    if (straight_a and not rest_a) or (straight_b and not rest_b):
        return _curved(a, b, step_a, step_b, start, end)
    lead = motion_b if rest_a else motion_a
    assert isinstance(lead, Rotation)
    rate_a, rate_b = _rate(step_a, rest_a, lead), _rate(step_b, rest_b, lead)
    if rate_a is None or rate_b is None:
        return _curved(a, b, step_a, step_b, start, end)
    rate = rate_a[0] - rate_b[0], rate_a[1] - rate_b[1]
    placed = step_a.pose(start), step_b.pose(start)
    carry_rate = rate_b if any(rate_b) else None
    if not any(rate):
        zero = (_0, _0, _0)
        return MotionPiece(
            start, end, start, *placed, zero, lead.axis, lead.point, rate, None, carry_rate, (step_a, step_b)
        )
    reference = start
    if not (placed[0].is_exact and placed[1].is_exact):
        since = [_exact_since(step, rests) for step, rests in ((step_a, rest_a), (step_b, rest_b))]
        times = {time for time, _ in since if time is not None}
        if len(times) == 1 and all(pose.is_exact for _, pose in since):
            reference, placed = times.pop(), (since[0][1], since[1][1])
    steps = step_a, step_b
    return MotionPiece(start, end, reference, *placed, None, lead.axis, lead.point, rate, None, carry_rate, steps)


def _exact_since(step: Step, rests: bool) -> tuple[fmpq | None, Placement]:
    """A time and a pose from which on the rotation takes the body all the way to where it does; no time at rest.

    That is where the step begins or, after turns about the same line, where it would have begun with these; full turns
    before that are left out.
    """
    if rests:
        return None, step.before
    motion = step.motion
    assert isinstance(motion, Rotation)
    done = step.before.factors[-1] if step.before.factors else None
    if isinstance(done, Turn) and (sense := sense_about(done, motion)):
        radians, turns = angle_of(motion, sense / step.unit)
        if done.radians == 0 and radians == 0:
            passed = done.turns / turns
            return step.origin - (passed - (passed * abs(turns)).floor() / abs(turns)), step.before.earlier or HERE
        if done.turns == 0 and turns == 0 and done.radians / radians > 0:
            return step.origin - done.radians / radians, step.before.earlier or HERE
    return step.origin, step.before


def _is_straight_or_turn(step: Step) -> bool:
    return isinstance(step.motion, SIMPLE)


def _curved(a: Body, b: Body, step_a: Step, step_b: Step, start: fmpq, end: fmpq | None) -> CurvedPiece:
    """The piece by the motions themselves."""
    steps = (step_a, _who(a, "a")), (step_b, _who(b, "b"))
    named = [(step, f"{type(step.motion).__name__} of {who}") for step, who in steps]
    if end is None:
        bent = [name for s, name in named if not isinstance(s.motion, SIMPLE)]  # straight ones and turns need none
        raise InputError(
            f"the span has no end, but {' with '.join(bent or [name for _, name in named])} needs one; "
            "give span=(first, last)"
        )
    return CurvedPiece(start, end, *[Leg(s.motion, s.origin, s.unit, s.before, name) for s, name in named])


def _velocity(step: Step, rests: bool) -> tuple[fmpq, fmpq, fmpq]:
    if rests or not isinstance(step.motion, Translation):
        return (_0, _0, _0)
    return step.motion.vector if step.end is None else scaled(1 / step.unit, step.motion.vector)


def _rate(step: Step, rests: bool, lead: Rotation) -> tuple[fmpq, fmpq] | None:
    """(radians, turns) per unit of time about the axis of `lead`; None when the axes differ."""
    if rests:
        return (_0, _0)
    motion = step.motion
    assert isinstance(motion, Rotation)
    sense = 1
    if motion is not lead:
        sense = sense_about(motion, lead)
        if not sense:
            return None
    return angle_of(motion, sense / step.unit)


def _who(body: Body, default: str = "a body") -> str:
    return repr(body.name) if getattr(body, "name", None) else f"body {default}" if len(default) == 1 else default
