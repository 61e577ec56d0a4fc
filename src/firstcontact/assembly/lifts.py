"""Bodies that turn off a plane in which they touch, as a lid about its hinge, decided exactly.

Let a plane part two bodies at the start, and one of them turn, as seen from the other, about a line parallel to it; an
advance along that line changes no height.  A point that stands at the height H over the plane, and at S along the
direction into which turning raises it (both times the length of the normal), where the line runs D below the plane,
stands after a turn by the angle theta at a height whose sign is that of

    H + 2 S tau - (H + 2 D) W tau^2,    tau = tan(theta / 2) / |axis|,    W = axis . axis,    H, S, W, D rational.

Where that is positive for 0 < tau <= T at all points of the body, the bodies share no point until it has turned so far.
It is at all points of a hull if it is at the corners.  Of a box whose inside keeps to H >= 0, turned by 90 degrees at
most, the worst point would have H = 0 and the least S; of a ball, H = 0 and its centre's S and H + D stand for all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from collections.abc import Sequence as Listing
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
from flint import arb, fmpq

from firstcontact.body.solid.carriers import Plane, Quadric, primitive
from firstcontact.exact.numbers import dyadic, exact_value, precision
from firstcontact.exact.vectors import Vector, cross, dot, scaled, sub
from firstcontact.motion.moving import Moving
from firstcontact.motion.rotation import Rotation, angle_ball
from firstcontact.motion.screw import Screw
from firstcontact.motion.steps import Step, steps_of

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.body.solid.carriers import Surface

_0 = fmpq(0)
MOST_HALVINGS = 24
"""Of the time for which a lift is proved."""
LONGEST = fmpq(2, 5)
"""Turns for which it is proved at most: below a half, where tau is infinite."""
BITS = 128


class Lift(NamedTuple):
    """How one body turns, seen from another, about a line: forward about the axis."""

    step: Step
    axis: Vector
    point: Vector

    def reversed(self) -> Lift:
        """How the other one turns, seen from this."""
        return self._replace(axis=scaled(-1, self.axis))

    def is_along(self, plane: Plane) -> bool:
        """Whether the line is parallel to the plane."""
        return bool(dot(plane.normal[:3], self.axis) == 0)

    def until(self, first: fmpq, last: fmpq | None) -> fmpq:
        """The last time at which the step is in charge and the turn is not too long."""
        motion = self.step.motion
        turns = abs(motion.angle) / (1 if motion.unit == "turns" else 6) / self.step.unit
        ends = [x for x in (last, self.step.end) if x is not None]
        longest: fmpq = min([first + LONGEST / turns, *ends])
        return longest

    def tau(self, first: fmpq, time: fmpq) -> fmpq:
        """An upper bound, for the turn from first to time."""
        motion = self.step.motion
        with precision(BITS):
            angle = angle_ball(abs(motion.angle) * (time - first) / self.step.unit, motion.unit)
            return dyadic(((angle / 2).tan() / arb(dot(self.axis, self.axis)).sqrt()).upper())


Quadratic = tuple[fmpq, fmpq, fmpq]
"""Ascending."""


@dataclass(frozen=True)
class Clearance:
    """Quadratics in tau: while all are positive, the body is off the plane; only for tau^2 up to `most`, if given."""

    of_points: list[Quadratic]
    most: fmpq | None = None

    def rise(self) -> bool:
        """Whether they are positive right after zero."""
        return all(map(_rises, self.of_points))

    def stay(self, tau: fmpq) -> bool:
        """Whether, if they rise, they are positive for all from there up to tau."""
        if self.most is not None and tau * tau > self.most:
            return False
        return all(_stays(x, tau) for x in self.of_points)


@dataclass(frozen=True)
class Hull:
    """What holds a solid at the start: a box, lower and upper corner, and surfaces, negative inside."""

    box: tuple[np.ndarray, np.ndarray]
    sides: Iterable[Surface]


Reach: TypeAlias = "list[Vector] | Hull"
"""Points in whose convex hull a body lies at the start, or what holds it then."""


def lifted_until(
    bodies: tuple[Body, Body], reaches: Listing[Callable[[], Reach]], sides: Iterable[Surface],
    separates: Callable[[Plane], bool], first: fmpq, last: fmpq | None,
) -> fmpq | None:  # fmt: skip
    """A time until which bodies share no point from the first one on, which may be left out; None if none is found.

    sides: surfaces, of which planes are looked at.  separates: whether one has all of the first body where its form is
    not positive, and all of the second where it is not negative, at the start.
    """
    lift = lift_of(*bodies, first)
    if lift is None:
        return None
    for plane in sides:
        if not (isinstance(plane, Plane) and lift.is_along(plane) and separates(plane)):
            continue
        for own, reach, under in ((lift, reaches[0], plane.negated()), (lift.reversed(), reaches[1], plane)):
            heights = [x for x in _heights(reach(), under, own) if x.rise()]
            time = own.until(first, last)
            for _ in range(MOST_HALVINGS if heights else 0):
                tau = own.tau(first, time)
                if any(x.stay(tau) for x in heights):
                    return time
                time = (first + time) / 2
    return None


def lift_of(body: Body, other: Body, time: fmpq) -> Lift | None:
    """Of the body as seen from the other, where one of them alone moves then, and turns."""
    moving = [x for x in (body, other) if isinstance(x, Moving)]
    if len(moving) != 1:
        return None
    sense = 1 if moving[0] is body else -1
    step = next((x for x in steps_of(moving[0].motion) if x.end is None or time < x.end), None)
    if step is None or not isinstance(step.motion, Rotation | Screw) or step.motion.angle == 0 or time < step.start:
        return None
    forward = sense * step.motion.angle > 0
    return Lift(step, step.motion.axis if forward else scaled(-1, step.motion.axis), step.motion.point)


def _heights(reach: Reach, plane: Plane, lift: Lift) -> Iterator[Clearance]:
    """Of a body where the plane's form is not negative, in more than one way."""
    along, under = cross(plane.normal[:3], lift.axis), -plane.value((*lift.point, 1))
    square = dot(lift.axis, lift.axis)

    def quadratic(height: fmpq, ahead: fmpq, below: fmpq = under) -> Quadratic:
        return height, 2 * ahead, -(height + 2 * below) * square

    def ahead(point: Vector) -> fmpq:
        length: fmpq = dot(along, sub(point, lift.point))
        return length

    if not isinstance(reach, Hull):
        yield Clearance([quadratic(plane.value((*p, 1)), ahead(p)) for p in reach])
        return
    for centre in _centres_of_balls_over(plane, reach.sides):
        yield Clearance([quadratic(_0, ahead(centre), plane.value((*centre, 1)) + under)])
    corners = list(product(*zip(*reach.box, strict=True)))
    if np.isfinite(reach.box).all():
        least = min(ahead((exact_value(x), exact_value(y), exact_value(z))) for x, y, z in corners)
        yield Clearance([quadratic(_0, least)], 1 / square)


def _centres_of_balls_over(plane: Plane, sides: Iterable[Surface]) -> Iterator[Vector]:
    """Of those in which the plane's form is not negative."""
    for side in sides:
        ball = _ball(side)
        if ball is not None:
            centre, square = ball
            height, normal = plane.value((*centre, 1)), plane.normal[:3]
            if height > 0 and height * height >= square * dot(normal, normal):
                yield centre


def planes_between_balls(below: Iterable[Surface], above: Iterable[Surface]) -> Iterator[Plane]:
    """Radical planes: of balls that touch from outside the one in which they do."""
    for x, y in product(below, above):
        one, other = _ball(x), _ball(y)
        if one is not None and other is not None and any(normal := sub(other[0], one[0])):
            (p, r), (q, s) = one, other
            yield Plane(primitive((*scaled(2, normal), dot(p, p) - r - dot(q, q) + s)))


def _ball(side: Surface) -> tuple[Vector, fmpq] | None:
    """Centre and squared radius of a sphere with its inside; None of any other surface."""
    if not isinstance(side, Quadric):
        return None
    form, k = side.form, side.form[0][0]
    if k <= 0 or any(form[i][j] != (k if i == j else 0) for i in range(3) for j in range(3)):
        return None
    centre = (-form[0][3] / k, -form[1][3] / k, -form[2][3] / k)
    return centre, dot(centre, centre) - form[3][3] / k


def _rises(x: Quadratic) -> bool:
    """Whether it is positive right after zero."""
    lowest = next((c for c in x if c != 0), None)
    return lowest is not None and lowest > 0


def _stays(x: Quadratic, end: fmpq) -> bool:
    """Whether one that is positive right after zero has no root from there up to the end."""
    c, b, a = x
    if c + end * (b + end * a) <= 0:
        return False
    lowest = -b / (2 * a) if a > 0 else None
    return lowest is None or not 0 < lowest < end or c + lowest * (b + lowest * a) > 0
