"""When the heights of two bodies have one in common: the bodies share no point at other times.

All motions are turns about one direction, shifts and screws along it.  So a body's points rise alike, by an exact
height at every time, which grows at a constant speed in every step.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.contact.advancing import level, rise_of
from firstcontact.contact.heights.ranges import Heights, heights
from firstcontact.exact.numbers import fraction, to_double
from firstcontact.exact.rigid import rational_sqrt
from firstcontact.exact.vectors import Vector, dot, scaled
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.placement import Placement, Twist
from firstcontact.motion.relative.stretches import known_steps
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw
from firstcontact.motion.sequence import Sequence
from firstcontact.motion.steps import RESTING, Step
from firstcontact.motion.trajectory import Trajectory
from firstcontact.motion.translation import Translation
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.motion.kinds import AnyMotion

Span = tuple[fmpq, fmpq]
Knots = list[tuple[fmpq, fmpq]]
"""(time, height), with straight lines between."""

MOST_STEPS = 200
"""Of a motion that is looked at."""


@dataclass(frozen=True)
class Ascents:
    """What is known of two bodies along a direction: their heights at rest, and what motions add to these."""

    normal: Vector
    ranges: tuple[Heights, Heights]
    rises: tuple[Knots, Knots]

    def gaps_at(self, time: fmpq) -> tuple[fmpq, fmpq]:
        """By how much all of a is above all of b, and b above a; at most 0 both where they have a height in common."""
        (low_a, high_a), (low_b, high_b) = self.ranges
        up_a, up_b = (_at(knots, time) for knots in self.rises)
        return low_a + up_a - high_b - up_b, low_b + up_b - high_a - up_a

    def has_from(self, which: int, height: fmpq, first: fmpq, last: fmpq) -> bool:
        """Whether a point of one body, at that height of its own, stays between the heights of the other one."""
        own, other = self.rises[which], self.rises[1 - which]
        low, high = self.ranges[1 - which]
        times = self._bends(first, last)
        return all(low <= height + _at(own, t) - _at(other, t) <= high for t in times)

    def is_touch(self, span: Span) -> bool:
        """Whether one of them is on the other all the time, so that they have one height in common."""
        gaps = [self.gaps_at(t) for t in self._bends(*span)]
        return any(all(gap[k] == 0 for gap in gaps) for k in (0, 1))

    def level(self, query: Query, span: Span) -> Query | None:
        """The question about times in which heights stay as they are, of bodies that turn and shift at these heights
        alone; None where heights change, and of motions that are not taken apart."""
        first, last = span
        bodies: list[Any] = []
        for body, knots in zip(query.bodies, self.rises, strict=True):
            rise = _at(knots, first)
            if any(_at(knots, t) != rise for t in self._bends(first, last)):
                return None
            shape: Any = shape_of(body).translated(scaled(rise / dot(self.normal, self.normal), self.normal))
            motion = _without_advance(body, self.normal)
            if motion is None and isinstance(body, Moving):
                return None
            bodies.append(shape if motion is None else Moving(shape, motion))
        return replace(query, a=bodies[0], b=bodies[1], first=first, last=last, progress=None)

    def _bends(self, first: fmpq, last: fmpq) -> list[fmpq]:
        """These times, and those between at which a speed changes."""
        return [first, *(t for knots in self.rises for t, _ in knots if first < t < last), last]

    def raised(self, point: np.ndarray, time: fmpq) -> np.ndarray:
        """The point at the lowest of the heights that they have in common then, a time that is rounded."""
        time = min(max(time, self.rises[0][0][0]), self.rises[0][-1][0])
        lowest = max(low + _at(knots, time) for (low, _), knots in zip(self.ranges, self.rises, strict=True))
        n = np.array([to_double(c) for c in self.normal])
        place: np.ndarray = point + n * (to_double(lowest) - float(n @ point)) / float(n @ n)
        return place

    def meetings(self) -> list[Span]:
        """The closed times at which they have a height in common, in order."""
        times = sorted({t for knots in self.rises for t, _ in knots})
        if len(times) == 1:
            return [(times[0], times[0])] if max(self.gaps_at(times[0])) <= 0 else []
        found: list[Span] = []
        for first, last in pairwise(times):
            own = _where_both(first, last, self.gaps_at(first), self.gaps_at(last))
            if own is None:
                continue
            if found and found[-1][1] == own[0]:
                found[-1] = found[-1][0], own[1]
            else:
                found.append(own)
        return found


def _without_advance(body: Body, normal: Vector) -> AnyMotion | None:
    """The motion of a body, each step without its advance; None of bodies at rest and of other motions."""
    if not isinstance(body, Moving):
        return None
    motion: Any = body.motion
    steps = motion.steps if isinstance(motion, Sequence) else [motion]
    flat = [level(Moving(body.body, step), normal) for step in steps]
    if any(x is None for x in flat):
        return None
    motions: list[Any] = [x[0].motion for x in flat if x is not None and isinstance(x[0], Moving)]
    return Sequence(motions, [fraction(x) for x in motion.durations]) if isinstance(motion, Sequence) else motions[0]


def _where_both(first: fmpq, last: fmpq, start: tuple[fmpq, fmpq], end: tuple[fmpq, fmpq]) -> Span | None:
    """The part of a time in which two heights, which change at constant speed, are at most 0.

    Their sum never is more, so that one is not positive still when the other one is no longer.
    """
    lo, hi = fmpq(0), fmpq(1)
    for x, y in zip(start, end, strict=True):
        if x > 0 and y > 0:
            return None
        if x > 0:
            lo = max(lo, x / (x - y))
        elif y > 0:
            hi = min(hi, x / (x - y))
    return first + lo * (last - first), first + hi * (last - first)


def _at(knots: Knots, time: fmpq) -> fmpq:
    for (t, h), (t_next, h_next) in pairwise(knots):
        if t <= time <= t_next:
            return h if t == t_next else h + (h_next - h) * (time - t) / (t_next - t)
    raise AssertionError(f"{time} is no time of the span")


def ascents_of(query: Query) -> Ascents | None:
    """None where the motions keep no direction, or heights are not told."""
    normal = _direction(query)
    return None if normal is None else ascents_along(query, normal)


def ascents_along(query: Query, normal: Vector) -> Ascents | None:
    """The same in a given direction."""
    rises = [_rise(x, normal, query.first, query.end) for x in query.bodies]
    if rises[0] is None or rises[1] is None:
        return None
    found = [heights(shape_of(x), normal) for x in query.bodies]
    if found[0] is None or found[1] is None:
        return None
    return Ascents(normal, (found[0], found[1]), (rises[0], rises[1]))


def _direction(query: Query) -> Vector | None:
    """The axis of the first turn of either body over the span."""
    steps = (step for body in query.bodies for step in steps_in(body, query.first, query.end) or ())
    return next((axis for step in steps for axis in step.motion.axes or ()), None)


def steps_in(body: Body, first: fmpq, last: fmpq) -> list[Step] | None:
    """The steps that a body makes from first to last; None of motions that are not looked at."""
    if not isinstance(body, Moving):
        return [RESTING]
    motion: Any = body.motion
    if not isinstance(motion, Translation | Rotation | Screw | Sequence | Trajectory):
        return None
    if isinstance(motion, Sequence) and any(first <= t <= last for t in motion.jumps):
        return None
    steps = [x for x in known_steps(motion) if x.end is None or (first < x.end and x.start < last)]
    return steps if len(steps) <= MOST_STEPS else None


def rest_within(body: Body, first: fmpq, last: fmpq) -> bool:
    """Whether a body stands still all the time."""
    steps = steps_in(body, first, last)
    return bool(steps) and all(isinstance(x.motion, Translation) and not any(x.motion.vector) for x in steps or ())


def _rise(body: Body, normal: Vector, first: fmpq, last: fmpq) -> Knots | None:
    """What the motion adds to the height of every point; None where it does not add the same to all."""
    steps, found = steps_in(body, first, last), []
    if not steps:
        return None
    for k, step in enumerate(steps):
        start = first if k == 0 else step.start  # motions without end have none before zero, either
        end = last if step.end is None or step.end > last else step.end
        speed, base = speed_of(step, normal), _height_of(step.before, normal)
        if speed is None or base is None:
            return None
        found += [(t, base + speed * (t - step.origin)) for t in (start, end)]
    return found if all(x[1] == y[1] for x, y in pairwise(found) if x[0] == y[0]) else None


def _height_of(pose: Placement, normal: Vector) -> fmpq | None:
    """What a pose adds to the height of every point; None where it turns heights, or adds what is not rational."""
    twists = [x for x in pose.factors if isinstance(x, Twist) and x.advance]
    if any(rational_sqrt(dot(x.turn.axis, x.turn.axis)) is None for x in twists):
        return None
    *rows, shift = ([row[k] for row in pose.near()] for k in range(4))
    if any(dot(normal, rows[k]) != normal[k] for k in range(3)):
        return None
    total: fmpq = dot(normal, shift)
    return total


def speed_of(step: Step, normal: Vector) -> fmpq | None:
    """How fast heights grow in a step; None where it turns about another direction, or at irrational speed."""
    rise = rise_of(step.motion, normal)
    return None if rise is None else rise / step.unit
