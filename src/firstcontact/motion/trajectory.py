"""Motion through given poses at given times."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, TypeAlias, overload

import numpy as np
from flint import arb, fmpq

from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import dyadic, fraction, precision, rational, to_double
from firstcontact.exact.vectors import Vector, add, cross, dot, scaled, sub
from firstcontact.motion.placement import HERE, Placement
from firstcontact.motion.poses import BITS, SNAP, Pose, Quaternion, read_poses, sqrt_near
from firstcontact.motion.rational import RationalMotion, join, refuse_half_turn, refuse_opposite
from firstcontact.motion.screw import Screw
from firstcontact.motion.translation import LARGEST, Translation, double_of
from firstcontact.motion.value import Motion, numbers

if TYPE_CHECKING:
    from zz import T

    from firstcontact.exact.numbers import Given, Nested
    from firstcontact.result import Table

INTERPOLATIONS = ("linear-quaternion", "screw")
Between: TypeAlias = "RationalMotion | Screw | Translation"
"""What makes one step."""
_LARGE, NEARLY = fmpq(2) ** 64, fmpq(1, 2**120)
"""Coordinates of poses, and squares of sines between them, on this side of which no number of a step reaches LARGEST.
"""
MOST_KEPT, MOST_PARTS = 4096, 128
"""Steps that a motion keeps, kilobytes each; parts of it that are kept."""


class Steps(Sequence[Between]):
    """The motions between poses, made as they are looked at: there may be a hundred thousand of them."""

    def __init__(self, make: Callable[[int], Between], first: int, count: int) -> None:
        """count: of those from the first on, by the numbers that `make` takes."""
        self._make, self._first, self._count = make, first, count
        self._made: dict[int, Between] = {}

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, k: int) -> Between: ...
    @overload
    def __getitem__(self, k: slice) -> Steps: ...
    def __getitem__(self, k: int | slice) -> Between | Steps:
        if isinstance(k, slice):
            first, last, _ = k.indices(self._count)
            return Steps(self._make, self._first + first, max(last - first, 0))
        k = range(self._count)[k]
        if k not in self._made:
            if len(self._made) >= MOST_KEPT:
                self._made.clear()
            self._made[k] = self._make(self._first + k)
        return self._made[k]


class Trajectory(Motion):
    """The body stands in ``poses[k]`` at ``times[k]`` and moves from each pose to the next one meanwhile.

    times: two or more numbers, ascending; the span is (times[0], times[-1]).
    poses: one per time, 4x4 arrays or (scipy Rotation, vector); with ``quat_xyzw=`` or ``quat_wxyz=`` (one quaternion
    per time, any length) ``poses`` are the vectors.
    interpolation: "linear-quaternion": each step is ``RationalMotion.between``; "screw": each step turns and advances
    at constant speed about the one axis that carries a pose to the next.  Both take the short way round, and both
    refuse neighbouring poses half a turn apart.  Under "linear-quaternion" the frame's origin goes straight, which a
    link of a robot does not: docs/motions.md tells by how much.

    snap: matrices that miss a rotation by more, as entries of R^T R - 1 tell, are an InputError; others stand for the
    nearest rotation, and ``correction`` tells by how much an entry of them is off it, at most.  The default is what
    float32 needs.

    Poses are exact where they are rational rotations, otherwise within 2^-60 (see `RationalMotion.between`).  A step
    starts exactly in its pose; under "linear-quaternion" it also ends exactly in the next one.  Under "screw" axis and
    point are exact, angle and advance are irrational in general: they are rational within 2^-60 (the angle in radians,
    the advance relative to itself), so a step ends that near the start of the next one.

    >>> path = Trajectory([0, 2, 3], [(0, 0, 0), (4, 0, 0), (4, 4, 0)], quat_wxyz=[(1, 0, 0, 0)] * 3)
    >>> path.span, path(2.5)[:3, 3]
    ((0.0, 3.0), array([4., 2., 0.]))
    """

    __slots__ = ("times", "poses", "interpolation", "steps", "correction", "_worlds", "_parts")
    extends = False

    times: tuple[fmpq, ...]
    poses: tuple[Pose, ...]
    steps: Steps
    """The motion from each pose to the next over (0, 1); see `before`."""
    correction: float
    """By how much an entry of a matrix that was given is off the rotation that it stands for, at most."""

    def __init__(
        self,
        times: Iterable[Given],
        poses: Iterable[Nested],
        interpolation: str = "linear-quaternion",
        *,
        quat_xyzw: Nested | None = None,
        quat_wxyz: Nested | None = None,
        snap: Given = SNAP,
    ) -> None:
        if interpolation not in INTERPOLATIONS:
            raise InputError(f"Trajectory interpolation is {interpolation!r}; use one of {INTERPOLATIONS}")
        self.interpolation = interpolation
        self.times = _times(times)
        poses = _listed(poses, "poses")
        if len(poses) != len(self.times):
            raise InputError(f"Trajectory has {len(self.times)} times but {len(poses)} poses; give one for each")
        names = [f"Trajectory poses[{k}]" for k in range(len(poses))]
        self.poses = tuple(read_poses(poses, names, quat_xyzw, quat_wxyz, snap))
        self.correction = max(pose.correction for pose in self.poses)
        self.steps = Steps(self._step, 0, len(self.poses) - 1)
        for k, (p, q) in enumerate(pairwise(self.poses)):
            cosine = refuse_opposite(p, q, _names(k))
            if _are_large(p, q) or 1 - NEARLY < cosine < 1:
                self.steps[k]  # refused where its numbers are too large
        self._worlds: tuple[Hashable, ...] = ()
        self._parts: dict[tuple[int, int], Trajectory] = {}

    def _step(self, k: int) -> Between:
        make = join if self.interpolation == "linear-quaternion" else screw_between
        return make(self.poses[k], self.poses[k + 1], _names(k))

    @property
    def span(self) -> tuple[float, float]:
        return to_double(self.times[0]), to_double(self.times[-1])

    @property
    def exact_span(self) -> tuple[fmpq, fmpq]:
        return self.times[0], self.times[-1]

    @property
    def starts(self) -> tuple[fmpq, ...]:
        """When each step starts."""
        return self.times[:-1]

    @property
    def ends(self) -> tuple[fmpq, ...]:
        """When each step ends."""
        return self.times[1:]

    def before(self, k: int) -> Placement:
        """The exact pose that step k is applied to: the identity where the step contains it."""
        return HERE if self.interpolation == "linear-quaternion" else HERE.then(self.poses[k].matrix())

    def __call__(self, t: float) -> np.ndarray:
        """The (4, 4) float64 pose at time t of the span."""
        t = double_of(t)
        if not self.span[0] <= t <= self.span[1]:
            raise InputError(f"time {t} is outside the span {self.span} of the Trajectory")
        time = min(max(rational(t, "time"), self.times[0]), self.times[-1])
        k = min(bisect_right(self.times, time), len(self.steps)) - 1
        share = (time - self.times[k]) / (self.times[k + 1] - self.times[k])
        step = self.steps[k]
        if isinstance(step, RationalMotion):
            return np.array([[to_double(x) for x in row] for row in step.exact(share)])
        start = self.before(k).doubles()
        if isinstance(step, Translation):
            start[:3, 3] = [to_double(x + share * v) for x, v in zip(self.poses[k].vector, step.vector, strict=True)]
            return start
        pose: np.ndarray = step.pose(share) @ start
        return pose

    def stretch(self, time: fmpq) -> int:
        """The step in charge at a time of the span."""
        return max(0, min(bisect_right(self.times, time), len(self.steps)) - 1)

    def during(self, begin: fmpq, end: fmpq) -> Trajectory:
        """The steps in charge from one time to another, as a motion of its own; kept, for what searches find out about
        it."""
        first = self.stretch(begin)
        last = max(bisect_left(self.times, end), first + 1)
        if last - first == len(self.steps):
            return self
        if (first, last) not in self._parts:
            if len(self._parts) >= MOST_PARTS:
                self._parts.clear()
            made = self._like(self.times[first : last + 1], self.poses[first : last + 1], self.steps[first:last])
            self._parts[first, last] = made
        return self._parts[first, last]

    def _like(self, times: tuple[fmpq, ...], poses: tuple[Pose, ...], steps: Steps, *world: Hashable) -> Trajectory:
        made = Trajectory.__new__(Trajectory)
        made.interpolation, made.correction, made.times, made.poses = self.interpolation, self.correction, times, poses
        made.steps, made._worlds, made._parts = steps, (*self._worlds, *world), {}
        return made

    def shifted(self, by: Vector) -> Trajectory:
        """The same motion in a world shifted by a vector.

        Its steps are no longer those between its poses, so it is not for pickles.
        """
        turned = (_turned(p.quaternion[0], p.quaternion[1:], by) for p in self.poses)
        vectors = [add(p.vector, sub(by, x)) for p, x in zip(self.poses, turned, strict=True)]
        steps = Steps(lambda k: self.steps[k].shifted(by), 0, len(self.steps))
        return self._like(self.times, self._at(vectors), steps, by)

    def magnified(self, factor: fmpq) -> Trajectory:
        """The same motion in a world whose lengths are so many times as long; not for pickles, as above."""
        vectors = [scaled(factor, p.vector) for p in self.poses]
        steps = Steps(lambda k: self.steps[k].magnified(factor), 0, len(self.steps))
        made = self._like(self.times, self._at(vectors), steps, factor)
        for k, (p, q) in enumerate(pairwise(made.poses)):
            if _are_large(p, q):
                steps[k]  # refused where its numbers are too large
        return made

    def _at(self, vectors: Iterable[Vector]) -> tuple[Pose, ...]:
        return tuple(replace(p, vector=v) for p, v in zip(self.poses, vectors, strict=True))

    def _facts(self) -> tuple[Hashable, ...]:
        return self.interpolation, self.times, tuple((p.quaternion, p.vector) for p in self.poses), self._worlds

    def _quick(self) -> Iterable[fmpq]:
        return (x for pose in self.poses for x in (*pose.vector, *pose.quaternion))

    def _table(self) -> Table:
        return {
            "type": "trajectory",
            "times": numbers(self.times),
            "poses": [numbers(p.vector) for p in self.poses],
            "quat_wxyz": [numbers(p.quaternion) for p in self.poses],
            "interpolation": self.interpolation,
            **({"correction": self.correction} if self.correction else {}),
        }

    def __repr__(self) -> str:
        first, last = self.span
        return f"<Trajectory: {len(self.times)} poses from {first:g} to {last:g}, {self.interpolation}>"

    def __reduce__(self) -> tuple[object, ...]:
        vectors, quaternions = zip(*((p.vector, p.quaternion) for p in self.poses), strict=True)
        rows = [tuple(map(fraction, v)) for v in vectors], [tuple(map(fraction, q)) for q in quaternions]
        return rebuilt, (tuple(map(fraction, self.times)), *rows, self.interpolation, self.correction)


def rebuilt(
    times: Iterable[Given],
    vectors: Iterable[Nested],
    quaternions: Nested,
    interpolation: str,
    correction: float = 0.0,
) -> Trajectory:
    """The motion, with what is known of the matrices it was made of."""
    made = Trajectory(times, vectors, interpolation, quat_wxyz=quaternions)
    made.correction = correction
    return made


def _are_large(*poses: Pose) -> bool:
    return any(abs(x) >= _LARGE for pose in poses for x in pose.vector)


def _names(k: int) -> str:
    """What errors call two poses."""
    return f"Trajectory poses[{k}] and poses[{k + 1}]"


def _times(values: Iterable[Given]) -> tuple[fmpq, ...]:
    values = _listed(values, "times")
    times = tuple(rational(t, f"Trajectory times[{k}]") for k, t in enumerate(values))
    if len(times) < 2:
        raise InputError(f"Trajectory has {len(times)} times; give at least two")
    for k, time in enumerate(times):
        if abs(time) >= LARGEST:
            raise InputError(f"Trajectory times[{k}] is {shown(values[k])}; give a time below 2^150")
    for k, (early, late) in enumerate(zip(times, times[1:], strict=False)):
        if not early < late:
            raise InputError(f"Trajectory times[{k + 1}] does not lie after times[{k}]; give ascending times")
        if late - early <= 1 / LARGEST:
            raise InputError(f"Trajectory times[{k + 1}] lies within 2^-150 of times[{k}]; give times further apart")
    return times


def _listed(values: Iterable[T], key: str) -> list[T]:
    try:
        return list(values)
    except TypeError as error:
        raise InputError(f"Trajectory {key} is {values!r}; give a list") from error


def screw_between(start: Pose, end: Pose, names: str) -> Screw | Translation:
    """The motion S over (0, 1) with S(1) start = end: about one axis, the short way round.

    With the quaternion (w, v) of the relative rotation R and its displacement d (end = R start + d): the angle is
    2 atan(|v| / w), the advance d.v / |v|, and the axis passes through d' / 2 + (w / 2) v x d' / v.v, where d' is
    the part of d across v.  Axis and point are rational; angle and advance within 2^-60.
    """
    p, q = start.quaternion, end.quaternion
    w, axis = _quotient(q, p)
    square = dot(axis, axis)
    refuse_half_turn(w, w * w + square, fmpq(1), names)
    if not any(axis):
        return Translation(sub(end.vector, start.vector))
    displacement = sub(end.vector, _turned(w, axis, start.vector))
    along = dot(displacement, axis)
    across = sub(displacement, scaled(along / square, axis))
    point = scaled(fmpq(1, 2), add(across, scaled(w / square, cross(axis, across))))
    advance = along / sqrt_near(square, BITS)
    return Screw(axis, point, radians=_twice_arctangent(square, w), advance=advance)


def _quotient(q: Quaternion, p: Quaternion) -> tuple[fmpq, Vector]:
    """The quaternion q p^-1 up to a positive factor, as (scalar >= 0, vector)."""
    (a, *x), (b, *y) = q, p
    v, u = (x[0], x[1], x[2]), (y[0], y[1], y[2])
    scalar, vector = a * b + dot(v, u), sub(sub(scaled(b, v), scaled(a, u)), cross(v, u))
    size: fmpq = max(abs(c) for c in (scalar, *vector))
    return abs(scalar) / size, scaled((1 if scalar >= 0 else -1) / size, vector)


def _turned(w: fmpq, v: Vector, x: Vector) -> Vector:
    """x turned by the quaternion (w, v)."""
    once = cross(v, x)
    return add(x, scaled(2 / (w * w + dot(v, v)), add(scaled(w, once), cross(v, once))))


def _twice_arctangent(square: fmpq, w: fmpq) -> fmpq:
    """2 atan(sqrt(square) / w) within 2^-62 of itself."""
    with precision(4 * BITS):
        angle = dyadic((2 * arb.atan2(arb(square).sqrt(), arb(w))).mid())
    places = 1 << max(BITS + int(angle.q).bit_length() - int(angle.p).bit_length(), 0)
    return fmpq((angle * places + fmpq(1, 2)).floor(), places)
