"""Turn about a fixed axis and advance along it, both at constant speed."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from flint import arb, fmpq

from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import fraction, precision, rational, to_double
from firstcontact.exact.rigid import apply, ball_rotation, rational_sqrt, turned
from firstcontact.exact.vectors import Vector, add, cross, dot, scaled
from firstcontact.motion.rotation import Rotation, angle_ball, direction, read_angle, turn_table
from firstcontact.motion.translation import LARGEST, NOWHERE, SPAN, Translation, double_of, vector3
from firstcontact.motion.value import Motion, number

if TYPE_CHECKING:
    from firstcontact.exact.numbers import Given
    from firstcontact.exact.rigid import Matrix
    from firstcontact.motion.kinds import AnyMotion
    from firstcontact.result import Table

# Bits at which a pose is enclosed before it is rounded: even an axis 2^60 away leaves more than a double holds.
POSE_BITS = 256

M = TypeVar("M", bound="AnyMotion")


class Screw(Motion):
    """Turn about the line through ``point`` along ``axis``, and advance along ``axis`` meanwhile.

    axis: three numbers, not all zero, any length.  point: any point of the axis.
    Exactly one of ``radians``, ``degrees``, ``turns`` gives the angle over the default span (0, 1), right-hand rule;
    ``advance`` is the length of the way along the axis over that span.  Both may be negative; both are exact.
    The motion goes on at constant speed beyond (0, 1).

    >>> Screw((0, 0, 1), degrees=90, advance=3)(1.0)[:3].round(6) + 0.0
    array([[ 0., -1.,  0.,  0.],
           [ 1.,  0.,  0.,  0.],
           [ 0.,  0.,  1.,  3.]])
    """

    __slots__ = ("axis", "point", "angle", "unit", "advance")
    span = SPAN
    extends = True

    def __init__(
        self,
        axis: Iterable[Given],
        point: Iterable[Given] = (0, 0, 0),
        *,
        radians: Given = None,
        degrees: Given = None,
        turns: Given = None,
        advance: Given = 0,
    ) -> None:
        self.axis = direction(axis, "Screw axis")
        self.point = vector3(point, "Screw point")
        self.angle, self.unit = read_angle("Screw", radians, degrees, turns)
        self.advance = rational(advance, "Screw advance")
        if abs(self.advance) >= LARGEST:
            raise InputError(f"Screw advance is {shown(advance)}; give a number below 2^150")

    def __call__(self, t: float) -> np.ndarray:
        """The (4, 4) float64 pose at time t, from an enclosure at 256 bits."""
        return self.pose(rational(double_of(t), "time"))

    def pose(self, t: fmpq) -> np.ndarray:
        """The (4, 4) float64 pose at the exact time t."""
        with precision(POSE_BITS):
            rows = ball_rotation(self.axis, self.point, t * angle_ball(self.angle, self.unit))
            ahead = arb(t * self.advance) / arb(dot(self.axis, self.axis)).sqrt()
            doubles = [
                [*(float(x) for x in row[:3]), float(row[3] + ahead * arb(h))]
                for row, h in zip(rows, self.axis, strict=True)
            ]
        return np.array([*doubles, [0.0, 0.0, 0.0, 1.0]])

    @property
    def radians(self) -> float:
        """The angle over the span (0, 1), rounded."""
        return to_double(self.angle) * (1.0 if self.unit == "radians" else 2 * math.pi)

    def reduced(self) -> Screw | Rotation | Translation:
        """The same motion as a Rotation where it does not advance, a Translation where it does not turn.

        A Screw still: one that does both, and one that advances along an axis of irrational length.
        """
        if self.advance == 0:
            return Rotation(self.axis, self.point, **{self.unit: self.angle})
        if self.angle != 0:
            return self
        length = rational_sqrt(dot(self.axis, self.axis))
        return self if length is None else Translation(scaled(self.advance / length, self.axis))

    @property
    def is_one_step(self) -> bool:
        return self.reduced() is self

    @property
    def axes(self) -> tuple[Vector, ...]:
        return (self.axis,)

    @property
    def generators(self) -> tuple[tuple[Vector, Vector], ...]:
        return (self.axis, cross(self.point, self.axis)), (NOWHERE, scaled(self.advance, self.axis))

    def is_across(self, normal: Vector) -> bool:
        return self.advance == 0 and not any(cross(self.axis, normal))

    def paced(self, share: fmpq) -> Screw:
        """The motion that turns and advances so many times as far in the same time."""
        return _rebuild(self.axis, self.point, self.unit, share * self.angle, share * self.advance)

    def carried(self, by: Matrix) -> Screw:
        """The same motion in a world that was turned and shifted by a rational map."""
        return _rebuild(turned(by, self.axis), apply(by, self.point), self.unit, self.angle, self.advance)

    def shifted(self, by: Vector) -> Screw:
        """The same motion in a world shifted by a vector."""
        return _rebuild(self.axis, add(self.point, by), self.unit, self.angle, self.advance)

    def magnified(self, factor: fmpq) -> Screw:
        """The same motion in a world whose lengths are so many times as long."""
        return _rebuild(self.axis, scaled(factor, self.point), self.unit, self.angle, factor * self.advance)

    def _facts(self) -> tuple[Hashable, ...]:
        return self.axis, self.point, self.unit, self.angle, self.advance

    def _quick(self) -> Iterable[fmpq]:
        return *self.axis, *self.point, self.angle, self.advance

    def _table(self) -> Table:
        return {"type": "screw", **turn_table(self), "advance": number(self.advance)}

    def __repr__(self) -> str:
        axis, point = (tuple(map(to_double, v)) for v in (self.axis, self.point))
        angle, advance = to_double(self.angle), to_double(self.advance)
        return f"Screw({axis}, point={point}, {self.unit}={angle}, advance={advance})"

    def __reduce__(self) -> tuple[object, ...]:
        axis, point = (tuple(map(fraction, v)) for v in (self.axis, self.point))
        return _rebuild, (axis, point, self.unit, fraction(self.angle), fraction(self.advance))


def simple(motion: M) -> M | Screw | Rotation | Translation:
    """A screw that only turns, or only advances, as a Rotation or Translation; any other motion itself."""
    return motion.reduced() if isinstance(motion, Screw) else motion


def _rebuild(axis: Iterable[Given], point: Iterable[Given], unit: str, angle: Given, advance: Given) -> Screw:
    return Screw(axis, point, **{unit: angle}, advance=advance)
