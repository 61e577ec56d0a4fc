"""The motion of a link of a mechanism: the joints between it and the world, each a function of one clock."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Hashable, Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import arb, fmpq

from firstcontact.errors import InputError
from firstcontact.exact.numbers import ball_bounds, exact_value, precision, rational, to_double
from firstcontact.exact.rigid import IDENTITY
from firstcontact.exact.vectors import Vector, add, scaled
from firstcontact.motion.placement import HERE, Placement, advanced
from firstcontact.motion.product import JointFactor, Product, Simple, Value, at
from firstcontact.motion.rational import RationalMotion
from firstcontact.motion.rotation import turns_of
from firstcontact.motion.screw import simple
from firstcontact.motion.translation import Translation, double_of
from firstcontact.motion.value import Motion, numbers
from firstcontact.result import JointValue

if TYPE_CHECKING:
    from collections.abc import Sequence

    from firstcontact.exact.numbers import Given
    from firstcontact.result import Table

# Bits of joint values in answers.
_BITS = 192
Part = tuple[fmpq, fmpq, Any, Placement, tuple[fmpq, fmpq] | None]
"""Start, end, motion, the pose before it, and (origin, unit) of the motion's own time where it is not that from start
to end."""


class Drive(Motion):
    """A joint at work: its motion by one unit of its value, and the value over the time.

    values: for each stretch of time a polynomial, of degree 3 at most, of the share of the stretch that has passed.
    limits, mimic: of the joint, (least, greatest) and (leader, ratio, offset), for pictures; no answer asks for them.
    """

    __slots__ = ("name", "unit", "motion", "values", "limits", "mimic", "_doubles")

    def __init__(
        self, name: str, unit: str, motion: Simple, values: Iterable[Value], *,
        limits: tuple[fmpq, fmpq] | None = None, mimic: tuple[str, fmpq, fmpq] | None = None,
    ) -> None:  # fmt: skip
        self.name, self.unit, self.motion = name, unit, simple(motion)
        self.values = tuple(values)
        self.limits, self.mimic = limits, mimic
        self._doubles: np.ndarray | None = None

    @property
    def doubles(self) -> np.ndarray:
        """(stretches, 4): the coefficients of the values, rounded; worked out once."""
        if self._doubles is None:
            self._doubles = np.zeros((len(self.values), 4))
            for row, value in zip(self._doubles, self.values, strict=True):
                row[: len(value)] = [to_double(c) for c in value]
        return self._doubles

    def during(self, lo: int, hi: int) -> Drive:
        """In the stretches from lo on, before hi."""
        made = self._with(self.motion, self.values[lo:hi])
        made._doubles = None if self._doubles is None else self._doubles[lo:hi]
        return made

    def shifted(self, by: Vector) -> Drive:
        """The same joint in a world shifted by a vector."""
        return self._with(self.motion.shifted(by), self.values)

    def magnified(self, factor: fmpq) -> Drive:
        """The same joint in a world whose lengths are so many times as long."""
        return self._with(self.motion.magnified(factor), self.values)

    def _with(self, motion: Simple, values: Iterable[Value]) -> Drive:
        return Drive(self.name, self.unit, motion, values, limits=self.limits, mimic=self.mimic)

    def _facts(self) -> tuple[Hashable, ...]:
        return self.name, self.unit, self.motion, self.values

    def _quick(self) -> Iterable[fmpq]:
        return (*self.motion._quick(), *(x for value in (self.values[0], self.values[-1]) for x in value))

    def _table(self) -> Table:
        told = {"limits": self.limits and numbers(self.limits)}
        told["mimic"] = self.mimic and [self.mimic[0], *numbers(self.mimic[1:])]
        return {
            "name": self.name, "unit": self.unit, "motion": self.motion._table(), "values": numbers(self.values),
            **{key: x for key, x in told.items() if x is not None},
        }  # fmt: skip

    def __repr__(self) -> str:
        return f"<Drive of {self.name!r}: {len(self.values)} stretches>"


class Linkage(Motion):
    """The motion of a link: the product of the motions of its joints, from the root outward, on one clock.

    times: ascending; between two of them every joint's value is one polynomial of the time.
    drives: the joints between the root and the link; axes and points are those of the world in which all values are 0.

    It is made by a mechanism (`Mechanism.motion`).  Where the joints that stand do so in rational poses, a link makes
    plain steps, turns, shifts or screws, while one joint goes evenly, and shifts, by polynomials of the time at most,
    while all that go are prismatic.
    """

    __slots__ = ("times", "drives", "_parts")
    extends = False

    def __init__(self, times: Iterable[fmpq], drives: Iterable[Drive]) -> None:
        self.times, self.drives = tuple(times), tuple(drives)
        self._parts: dict[int, Part] = {}

    @property
    def span(self) -> tuple[float, float]:
        return to_double(self.times[0]), to_double(self.times[-1])

    @property
    def exact_span(self) -> tuple[fmpq, fmpq]:
        return self.times[0], self.times[-1]

    @property
    def steps(self) -> tuple[JointFactor, ...]:
        """The motion of each stretch."""
        return tuple(part[2] for part in self.parts())

    def parts(self) -> Iterator[Part]:
        """The stretches in order."""
        return (self.part(k) for k in range(len(self.times) - 1))

    def part(self, k: int) -> Part:
        """Stretch k; worked out once."""
        if k not in self._parts:
            self._parts[k] = self._part(k)
        return self._parts[k]

    def _part(self, k: int) -> Part:
        start, end = self.times[k], self.times[k + 1]
        standing, moving = self.at_work(k)
        if not moving:
            return start, end, Translation((0, 0, 0)), standing, None
        if not standing.is_exact:
            return start, end, self._product(k), HERE, None
        if len(moving) == 1 and not any(moving[0].value[2:]):
            (motion, (begin, share, *_)), length = moving[0], end - start
            return start, end, motion.paced(share), standing, (start - begin / share * length, length)
        if all(isinstance(f.motion, Translation) for f in moving):
            first, *ways = _ways(moving)
            shift = _along(ways) if len(ways) > 1 else Translation(ways[0])
            return start, end, shift, standing.shifted(first), None
        return start, end, self._product(k), HERE, None

    def _product(self, k: int) -> Product:
        return Product(JointFactor(d.motion, d.values[k]) for d in self.drives if any(d.values[k]))

    def moving(self, k: int) -> list[Drive]:
        """The joints whose values change in stretch k."""
        return [d for d in self.drives if any(d.values[k][1:])]

    def at_work(self, k: int) -> tuple[Placement, list[JointFactor]]:
        """The pose by the joints that stand in stretch k, and those that move, as they move a body that stands so;
        where that pose is irrational, as they are."""
        factors = [JointFactor(d.motion, d.values[k]) for d in self.drives if any(d.values[k])]
        standing = placed(f for f in factors if not any(f.value[1:]))
        return standing, _moving(factors) if standing.is_exact else [f for f in factors if any(f.value[1:])]

    @property
    def turns(self) -> float:
        """How many full turns the link makes in the longest of its stretches, at most."""
        ways = [np.abs(d.doubles) @ np.arange(4.0) * to_double(turns_of(d.motion)) for d in self.drives]
        return float(np.sum(ways, axis=0).max()) if ways else 0.0

    def stretch(self, time: fmpq) -> int:
        """The stretch in charge at a time of the span."""
        return max(0, min(bisect_right(self.times, time), len(self.times) - 1) - 1)

    def during(self, first: fmpq, last: fmpq) -> Linkage:
        """The motion from the stretch of one time to that of another."""
        lo, hi = self.stretch(first), self.stretch(last) + 1
        if (lo, hi) == (0, len(self.times) - 1):
            return self
        made = Linkage(self.times[lo : hi + 1], [d.during(lo, hi) for d in self.drives])
        made._parts = {k - lo: part for k, part in self._parts.items() if lo <= k < hi}
        return made

    def __call__(self, t: float) -> np.ndarray:
        """The (4, 4) float64 pose at time t of the span, rounded once."""
        t = double_of(t)
        if not self.span[0] <= t <= self.span[1]:
            raise InputError(f"time {t} is outside the span {self.span} of the mechanism")
        return self.pose(rational(t, "time")).doubles()

    def pose(self, time: fmpq) -> Placement:
        """Where the link stands then."""
        time = min(max(time, self.times[0]), self.times[-1])
        k = self.stretch(time)
        share = (time - self.times[k]) / (self.times[k + 1] - self.times[k])
        return placed([JointFactor(d.motion, (at(d.values[k], share),)) for d in self.drives])

    def joint_values(self, time: float, interval: tuple[float, float]) -> list[JointValue]:
        """The values of the joints at a time, and enclosed at all times of the interval around it."""
        near, lo, hi = (min(max(exact_value(t), self.times[0]), self.times[-1]) for t in (time, *interval))
        stretches = range(self.stretch(lo), self.stretch(hi) + 1)
        with precision(_BITS):
            return [
                JointValue(drive.name, self._value(drive, near), self._enclosed(drive, stretches, lo, hi), drive.unit)
                for drive in self.drives
            ]

    def _value(self, drive: Drive, time: fmpq) -> float:
        k = self.stretch(time)
        return to_double(at(drive.values[k], (time - self.times[k]) / (self.times[k + 1] - self.times[k])))

    def _enclosed(self, drive: Drive, stretches: range, lo: fmpq, hi: fmpq) -> tuple[float, float]:
        found: Any = None
        for k in stretches:
            start, length = self.times[k], self.times[k + 1] - self.times[k]
            times = arb((max(lo, start) - start) / length).union(arb((min(hi, start + length) - start) / length))
            value = arb(at(drive.values[k], times))
            found = value if found is None else found.union(value)
        return ball_bounds(found)

    def shifted(self, by: Vector) -> Linkage:
        """The same motion in a world shifted by a vector."""
        return Linkage(self.times, [d.shifted(by) for d in self.drives])

    def magnified(self, factor: fmpq) -> Linkage:
        """The same motion in a world whose lengths are so many times as long."""
        return Linkage(self.times, [d.magnified(factor) for d in self.drives])

    def _facts(self) -> tuple[Hashable, ...]:
        return self.times, self.drives

    def _quick(self) -> Iterable[fmpq]:
        return (*self.times[:2], self.times[-1], *(x for d in self.drives for x in d._quick()))

    def _table(self) -> Table:
        return {"type": "linkage", "times": numbers(self.times), "drives": [d._table() for d in self.drives]}

    def __repr__(self) -> str:
        names = ", ".join(d.name for d in self.drives)
        return f"<Linkage by {names}, from {self.span[0]:g} to {self.span[1]:g}>"

    def __reduce__(self) -> tuple[object, ...]:
        from firstcontact.exact.numbers import fraction

        rows = [
            (d.name, d.unit, d.motion, [tuple(map(fraction, v)) for v in d.values],
             None if d.limits is None else tuple(map(fraction, d.limits)),
             None if d.mimic is None else (d.mimic[0], *map(fraction, d.mimic[1:])))
            for d in self.drives
        ]  # fmt: skip
        return _rebuilt, (tuple(map(fraction, self.times)), rows)


def apart(a: Linkage, b: Linkage) -> tuple[Linkage, Linkage, Linkage] | None:
    """Both motions without the joints that they begin with both, and the motion by these; None where there are none."""
    if a.times != b.times:
        return None
    count = 0
    for x, y in zip(a.drives, b.drives, strict=False):
        if x != y:
            break
        count += 1
    if count == 0:
        return None
    return Linkage(a.times, a.drives[count:]), Linkage(b.times, b.drives[count:]), Linkage(a.times, a.drives[:count])


def placed(factors: Iterable[JointFactor]) -> Placement:
    """The pose by factors whose values do not change."""
    pose = HERE
    for motion, value in reversed(tuple(factors)):
        pose = advanced(pose, motion, value[0] if value else fmpq(0))
    return pose


def _moving(factors: Iterable[JointFactor]) -> list[JointFactor]:
    """Those whose values change, as they move a body to which all that stand, in rational poses, have been applied:
    F m = (F m F^-1) F."""
    moving: list[JointFactor] = []
    standing: list[JointFactor] = []
    for f in factors:
        if any(f.value[1:]):
            by = placed(standing).matrix()
            moving.append(f if by is IDENTITY else JointFactor(f.motion.carried(by), f.value))
        else:
            standing.append(f)
    return moving


def _ways(shifts: Iterable[JointFactor]) -> list[Vector]:
    """The coefficients of the sum of shifts, a polynomial of the time of degree 1 at least."""
    ways = [(fmpq(0), fmpq(0), fmpq(0))] * 4
    for motion, value in shifts:
        assert isinstance(motion, Translation)
        for k, c in enumerate(value):
            ways[k] = add(ways[k], scaled(c, motion.vector))
    while len(ways) > 2 and not any(ways[-1]):
        ways.pop()
    return ways


def _along(ways: Iterable[Vector]) -> RationalMotion:
    """The shift by a polynomial without constant term."""
    still = [[int(i == j) for j in range(4)] for i in range(4)]
    return RationalMotion([still, *([*([0, 0, 0, c] for c in way), [0] * 4] for way in ways)])


def _rebuilt(times: Iterable[Given], rows: Iterable[tuple[Any, ...]]) -> Linkage:
    return Linkage([rational(t, "time") for t in times], [drive(*row) for row in rows])


def drive(
    name: str, unit: str, motion: Simple, values: Iterable[Iterable[Given]], limits: Sequence[Given] | None,
    mimic: tuple[str, Given, Given] | None,
) -> Drive:  # fmt: skip
    """A drive of numbers of any kind."""
    return Drive(
        name, unit, motion, [tuple(rational(x, "values") for x in v) for v in values],
        limits=None if limits is None else (rational(limits[0], "limits"), rational(limits[1], "limits")),
        mimic=None if mimic is None else (mimic[0], rational(mimic[1], "mimic"), rational(mimic[2], "mimic")),
    )  # fmt: skip
