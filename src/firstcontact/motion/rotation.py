"""Turn about a fixed axis at constant speed, right-hand rule."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable
from typing import TYPE_CHECKING, Protocol

import numpy as np
from flint import arb, fmpq

from firstcontact.errors import InputError
from firstcontact.exact.numbers import fraction, to_double
from firstcontact.exact.rigid import apply, turned
from firstcontact.exact.vectors import Vector, add, cross, dot, scaled, sub
from firstcontact.motion.translation import SPAN, bounded, double_of, vector3
from firstcontact.motion.value import Motion, number, numbers

if TYPE_CHECKING:
    from firstcontact.exact.numbers import Given
    from firstcontact.exact.rigid import Matrix
    from firstcontact.motion.kinds import AnyMotion
    from firstcontact.motion.screw import Screw
    from firstcontact.result import Table

# Length from which directions stay as they are given; shorter ones take a power of two.
_SHORTEST = fmpq(2) ** -200


class Rotation(Motion):
    """Turn about the line through ``point`` along ``axis``, right-hand rule, at constant speed.

    axis: three numbers, not all zero, any length.  point: any point of the axis.
    Exactly one of ``radians``, ``degrees``, ``turns`` gives the angle over the default span (0, 1); it may be
    negative or more than a full turn, and it is exact ("1/3" of a turn is exactly that).

    >>> Rotation((0, 0, 1), degrees=90)(1.0)[:3, :3].round(6) + 0.0
    array([[ 0., -1.,  0.],
           [ 1.,  0.,  0.],
           [ 0.,  0.,  1.]])
    """

    __slots__ = ("axis", "point", "angle", "unit")
    span = SPAN
    extends = True
    is_one_step = True
    advance = fmpq(0)
    """As of a Screw that does not advance."""

    def __init__(
        self,
        axis: Iterable[Given],
        point: Iterable[Given] = (0, 0, 0),
        *,
        radians: Given = None,
        degrees: Given = None,
        turns: Given = None,
    ) -> None:
        self.axis = direction(axis, "Rotation axis")
        self.point = vector3(point, "Rotation point")
        self.angle, self.unit = read_angle("Rotation", radians, degrees, turns)
        """`unit` is what one unit of `angle` is: an angle in "radians" or in "turns"."""

    def __call__(self, t: float) -> np.ndarray:
        """The (4, 4) float64 pose at time t."""
        return rotation_matrix(
            np.array([to_double(x) for x in self.axis]),
            np.array([to_double(x) for x in self.point]),
            double_of(t) * self.radians,
        )

    @property
    def radians(self) -> float:
        """The angle over the span (0, 1), rounded."""
        return to_double(self.angle) * (1.0 if self.unit == "radians" else 2 * math.pi)

    @property
    def rests(self) -> bool:
        return self.angle == 0

    @property
    def is_rational(self) -> bool:
        return self.angle == 0

    @property
    def axes(self) -> tuple[Vector, ...]:
        return (self.axis,)

    @property
    def generators(self) -> tuple[tuple[Vector, Vector], ...]:
        return ((self.axis, cross(self.point, self.axis)),)

    def is_across(self, normal: Vector) -> bool:
        return not any(cross(self.axis, normal))

    def paced(self, share: fmpq) -> Rotation:
        """The motion that turns so many times as far in the same time."""
        return _rebuild(self.axis, self.point, self.unit, share * self.angle)

    def carried(self, by: Matrix) -> Rotation:
        """The same motion in a world that was turned and shifted by a rational map."""
        return _rebuild(turned(by, self.axis), apply(by, self.point), self.unit, self.angle)

    def shifted(self, by: Vector) -> Rotation:
        """The same motion in a world shifted by a vector."""
        return _rebuild(self.axis, add(self.point, by), self.unit, self.angle)

    def magnified(self, factor: fmpq) -> Rotation:
        """The same motion in a world whose lengths are so many times as long."""
        return _rebuild(self.axis, scaled(factor, self.point), self.unit, self.angle)

    def _facts(self) -> tuple[Hashable, ...]:
        return self.axis, self.point, self.unit, self.angle

    def _quick(self) -> Iterable[fmpq]:
        return *self.axis, *self.point, self.angle

    def _table(self) -> Table:
        return {"type": "rotation", **turn_table(self)}

    def __repr__(self) -> str:
        axis, point = (tuple(map(to_double, v)) for v in (self.axis, self.point))
        return f"Rotation({axis}, point={point}, {self.unit}={to_double(self.angle)})"

    def __reduce__(self) -> tuple[object, ...]:
        axis, point = (tuple(map(fraction, v)) for v in (self.axis, self.point))
        return _rebuild, (axis, point, self.unit, fraction(self.angle))


def direction(values: Iterable[Given], what: str) -> tuple[fmpq, fmpq, fmpq]:
    """Three exact numbers, not all zero, whose squares doubles hold; InputError names `what`."""
    x, y, z = vector3(values, what)
    if not (x or y or z):
        raise InputError(f"{what} is zero; give a direction such as (0, 0, 1)")
    largest = max(abs(x), abs(y), abs(z))
    if largest > _SHORTEST:
        return x, y, z
    scale = fmpq(2) ** (int(largest.q).bit_length() - int(largest.p).bit_length())
    return x * scale, y * scale, z * scale


def turn_table(motion: Rotation | Screw) -> Table:
    """Axis, point and angle as a scene file has them, of a Rotation or a Screw."""
    return {"axis": numbers(motion.axis), "point": numbers(motion.point), motion.unit: number(motion.angle)}


def read_angle(what: str, radians: Given, degrees: Given, turns: Given) -> tuple[fmpq, str]:
    """(angle, "radians" | "turns") of the one keyword given."""
    if (radians is not None) + (degrees is not None) + (turns is not None) != 1:
        raise InputError(f"{what} needs exactly one of radians=, degrees=, turns=")
    if radians is not None:
        return bounded(radians, f"{what} radians"), "radians"
    if turns is not None:
        return bounded(turns, f"{what} turns"), "turns"
    return bounded(degrees, f"{what} degrees") / 360, "turns"


def _rebuild(axis: Iterable[Given], point: Iterable[Given], unit: str, angle: Given) -> Rotation:
    return Rotation(axis, point, **{unit: angle})


def rotation_matrix(axis: np.ndarray, point: np.ndarray, radians: float) -> np.ndarray:
    """Float pose (4, 4) of a turn by `radians` about the line through `point` along `axis`."""
    axis = axis / np.abs(axis).max()  # the squares of the least doubles are 0
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    pose = np.eye(4)
    pose[:3, :3] += math.sin(radians) * cross + (1 - math.cos(radians)) * (cross @ cross)
    pose[:3, 3] = point - pose[:3, :3] @ point
    return pose


def turns_of(motion: AnyMotion) -> fmpq:
    """About how many full turns a motion makes in its unit of time, none too few."""
    if hasattr(motion, "turns"):  # of several joints
        turns: fmpq = motion.turns  # type: ignore[assignment]  # within a product
        return turns
    angle: fmpq = abs(getattr(motion, "angle", fmpq(0)))
    return angle if getattr(motion, "unit", "turns") == "turns" else angle / 6


class About(Protocol):
    """What turns about the line through `point` along `axis`."""

    @property
    def axis(self) -> Vector: ...
    @property
    def point(self) -> Vector: ...


def sense_about(x: About, y: About) -> int:
    """1 or -1 where both turn about one line, forward along it or against each other; 0 where they do not."""
    if any(cross(x.axis, y.axis)) or any(cross(sub(x.point, y.point), y.axis)):
        return 0
    return 1 if dot(x.axis, y.axis) > 0 else -1


def angle_ball(angle: fmpq, unit: str) -> arb:
    """Enclosure of an angle in radians at the present precision."""
    return arb(angle) if unit == "radians" else 2 * arb(angle) * arb.pi()
