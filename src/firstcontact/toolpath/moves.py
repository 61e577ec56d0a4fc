"""The ways of a tool, exact: straight, along an arc, and with a turning axis.

Each tells the solid in motion, for the verbs, and places of the tool in doubles with a bound of how far it strays from
the hulls of neighbouring places, for `walk`.  A tool is round, so how it turns about its own axis does not matter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.exact.numbers import exact_value, to_double
from firstcontact.exact.vectors import Vector, add, cross, dot, scaled, sub
from firstcontact.motion.moving import Moving
from firstcontact.motion.poses import BITS, sqrt_near
from firstcontact.motion.rational import RationalMotion
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw

if TYPE_CHECKING:
    from firstcontact.body.kinds import Shape

ZERO, ONE = fmpq(0), fmpq(1)
UP: Vector = (ZERO, ZERO, ONE)
BOTH_UP, BOTH_ENDS = np.tile((0.0, 0.0, 1.0), (2, 1)), np.array([0.0, 1.0])
ROUNDED = 1e-14
"""Part of sizes by which sines, cosines and what is made of them are off, at most."""
MOST_PARTS = 4096


@dataclass(frozen=True)
class ToolPlaces:
    """Places of the tool along a way, in doubles: tips, axes (n + 1, 3), the fractions of the way (n + 1,).

    Between neighbours points of the tool stray from the hull by at most pad + swing * their distance from the tip.
    """

    tips: np.ndarray
    axes: np.ndarray
    fractions: np.ndarray
    pad: float = 0.0
    swing: float = 0.0


@dataclass(frozen=True)
class StraightMove:
    """Straight from start to end, the axis being +z.  kind: "rapid", "feed" or "back", over a way just cut."""

    kind: str
    start: Vector
    end: Vector

    deviation = 0.0

    @property
    def length(self) -> float:
        return _norm(sub(self.end, self.start))

    def moving(self, solid: Shape) -> Moving:
        """The solid, whose tip is at the origin, along the way over the time (0, 1)."""
        # not the solid placed at the start: what searches keep on it serves every block
        placed: Moving = solid.moving(RationalMotion(_shifts([self.start, sub(self.end, self.start)], [ONE, ZERO])))
        return placed

    def tip(self, t: float) -> list[float]:
        """Where the tip is at a time, rounded."""
        return _between(self.start, self.end, t)

    def places(self, fine: float, reach: float) -> ToolPlaces:
        """fine: how far hulls may be off; reach: of the tool's points from its tip."""
        return ToolPlaces(np.array([_doubles(self.start), _doubles(self.end)]), BOTH_UP, BOTH_ENDS)


@dataclass(frozen=True)
class ArcMove:
    """About the line through centre along +z, the tool's axis: by radians (turns, of full circles), advancing too.

    A round tool is carried along such an arc as it turns about the line, so that the motion is an exact one.
    deviation: how far the end of the arc is from the one that was programmed.
    """

    kind: str
    start: Vector
    centre: Vector
    radians: float
    turns: int
    advance: fmpq
    deviation: float = 0.0

    @property
    def radius(self) -> float:
        return math.hypot(*_doubles(sub(self.start, self.centre))[:2])

    @property
    def angle(self) -> float:
        return 2.0 * math.pi * self.turns if self.turns else self.radians

    @property
    def length(self) -> float:
        return math.hypot(self.angle * self.radius, to_double(self.advance))

    def moving(self, solid: Shape) -> Moving:
        given: dict[str, Any] = {"turns": self.turns} if self.turns else {"radians": self.radians}
        motion: Any = Rotation(UP, self.centre, **given)
        if self.advance:
            motion = Screw(UP, self.centre, **given, advance=self.advance)
        placed: Moving = solid.translated(self.start).moving(motion)
        return placed

    def tip(self, t: float) -> list[float]:
        x, y, _ = _doubles(sub(self.start, self.centre))
        angle, (cx, cy, _), z = self.angle * t, _doubles(self.centre), to_double(self.start[2])
        c, s = math.cos(angle), math.sin(angle)
        return [cx + c * x - s * y, cy + s * x + c * y, z + t * to_double(self.advance)]

    def places(self, fine: float, reach: float) -> ToolPlaces:
        bend = self.radius * self.angle**2 / 8.0  # a chord of a curve strays by |f''| / 8 times the square of the part
        n = _parts(bend, fine)
        fractions = np.linspace(0.0, 1.0, n + 1)
        x, y, _ = _doubles(sub(self.start, self.centre))
        begin = math.atan2(y, x)
        angles = begin + self.angle * fractions
        cx, cy, _ = _doubles(self.centre)
        z0, dz = to_double(self.start[2]), to_double(self.advance)
        tips = np.column_stack([
            cx + self.radius * np.cos(angles), cy + self.radius * np.sin(angles), z0 + dz * fractions,
        ])  # fmt: skip
        size = abs(cx) + abs(cy) + abs(z0) + abs(dz) + self.radius
        pad = 1.0001 * bend / n**2 + self.deviation + ROUNDED * (1.0 + abs(self.angle)) * size
        return ToolPlaces(tips, np.tile((0.0, 0.0, 1.0), (n + 1, 1)), fractions, pad)


@dataclass(frozen=True)
class Bow:
    """Along an arc about a line that is no axis of the tool, which does not turn: in the planes G18 and G19.

    normal: a unit vector of the coordinates; tangent: of half the angle.  Rational: the point at time t is at the angle
    2 atan(tangent t), and advances in proportion to t.
    """

    kind: str
    start: Vector
    centre: Vector
    normal: Vector
    tangent: fmpq
    advance: fmpq
    deviation: float = 0.0

    @property
    def _out(self) -> Vector:
        out = sub(self.start, self.centre)
        return sub(out, scaled(dot(out, self.normal), self.normal))

    @property
    def length(self) -> float:
        angle = 2.0 * math.atan(to_double(self.tangent))
        return math.hypot(angle * _norm(self._out), to_double(self.advance))

    @property
    def end(self) -> Vector:
        k = self.tangent
        side = cross(self.normal, self._out)
        shift = scaled(2 / (1 + k * k), add(scaled(-k * k, self._out), scaled(k, side)))
        return add(self.start, add(shift, scaled(self.advance, self.normal)))

    def moving(self, solid: Shape) -> Moving:
        k, out, side = self.tangent, self._out, cross(self.normal, self._out)
        places = [  # of 1, t, t^2, t^3, times the weight 1 + k^2 t^2
            self.start,
            add(scaled(2 * k, side), scaled(self.advance, self.normal)),
            add(scaled(k * k, self.start), scaled(-2 * k * k, out)),
            scaled(self.advance * k * k, self.normal),
        ]
        n = 4 if self.advance else 3
        placed: Moving = solid.moving(RationalMotion(_shifts(places[:n], [ONE, ZERO, k * k, ZERO][:n])))
        return placed

    def tip(self, t: float) -> list[float]:
        k = to_double(self.tangent)
        out, side = _doubles(self._out), _doubles(cross(self.normal, self._out))
        shift = [(2 * k * t * y - 2 * k * k * t * t * x) / (1 + k * k * t * t) for x, y in zip(out, side, strict=True)]
        along = [t * to_double(self.advance * x) for x in self.normal]
        return [x + y + z for x, y, z in zip(_doubles(self.start), shift, along, strict=True)]

    def places(self, fine: float, reach: float) -> ToolPlaces:
        k, radius = to_double(self.tangent), _norm(self._out)
        bend = radius * (4.0 * k * k + 4.0 * abs(k) ** 3) / 8.0  # of the angle 2 atan(k t)
        n = _parts(bend, fine)
        t = np.linspace(0.0, 1.0, n + 1)
        out, side = np.array(_doubles(self._out)), np.array(_doubles(cross(self.normal, self._out)))
        shift = np.outer(-2.0 * k * k * t * t, out) + np.outer(2.0 * k * t, side)
        tips = np.array(_doubles(self.start)) + shift / (1.0 + k * k * t * t)[:, None]
        tips += np.outer(to_double(self.advance) * t, _doubles(self.normal))
        size = sum(map(abs, _doubles(self.centre))) + radius + abs(to_double(self.advance)) + np.abs(tips).max()
        pad = 1.0001 * bend / n**2 + self.deviation + ROUNDED * float(size)
        return ToolPlaces(tips, np.tile((0.0, 0.0, 1.0), (n + 1, 1)), t, pad)


@dataclass(frozen=True)
class Swing:
    """The tip goes straight from start to end while the axis turns the short way from axis0 to axis1.

    Axes: vectors of any length.  The turn is the straight line of unit quaternions.
    """

    kind: str
    start: Vector
    end: Vector
    axis0: Vector
    axis1: Vector

    deviation = 0.0

    @property
    def length(self) -> float:
        return _norm(sub(self.end, self.start))

    def moving(self, solid: Shape) -> Moving:
        first = _turn_between(UP, self.axis0)
        turns = [first, _product(_turn_between(self.axis0, self.axis1), first)]
        motion = RationalMotion.between(self.start, self.end, quat_wxyz=turns)
        placed: Moving = solid.moving(motion)
        return placed

    def tip(self, t: float) -> list[float]:
        return _between(self.start, self.end, t)

    def places(self, fine: float, reach: float) -> ToolPlaces:
        u, v = _unit(self.axis0), _unit(self.axis1)
        cosine = dot(u, v)
        across = [y - cosine * x for x, y in zip(u, v, strict=True)]
        half, size = 0.5 * math.atan2(math.hypot(*cross(u, v)), cosine), math.hypot(*across)
        sine, cosine = math.sin(half), math.cos(half)
        # the angle at time t is 2 atan2(t sin, 1 - t + t cos) of half the whole one: its first two derivatives
        rate = 2.0 * sine / math.cos(0.5 * half) ** 2
        change = 4.0 * sine * (1.0 - cosine) / math.cos(0.5 * half) ** 4
        bend = (rate * rate + change) / 8.0
        n = _parts(bend * reach, fine)
        t = np.linspace(0.0, 1.0, n + 1)
        angle = 2.0 * np.arctan2(t * sine, (1.0 - t) + t * cosine)
        sines = np.sin(angle) / size if size else 0.0 * angle
        axes = np.cos(angle)[:, None] * u + sines[:, None] * across
        axes[-1] = v
        start, end = _doubles(self.start), _doubles(self.end)
        tips = (1.0 - t)[:, None] * start + t[:, None] * end
        pad = ROUNDED * max(map(abs, start + end))
        return ToolPlaces(tips, axes, t, pad, 1.0001 * bend / n**2 + ROUNDED)


Stretch = StraightMove | ArcMove | Bow | Swing
Quaternion = tuple[fmpq, fmpq, fmpq, fmpq]
"""(w, x, y, z)."""


def _parts(bend: float, fine: float) -> int:
    """Into how many parts of equal time a way is cut whose whole strays from its chord by `bend`, at most."""
    return min(max(1, math.ceil(math.sqrt(bend / fine))), MOST_PARTS)


def _turn_between(u: Vector, v: Vector) -> Quaternion:
    """A quaternion (w, x, y, z) that turns the direction u the short way into v, within 2^-60."""
    x, y, z = cross(u, v)
    if dot(u, v) < 0 and not (x or y or z):  # only +z into -z: any way round does
        return ZERO, ONE, ZERO, ZERO
    length = sqrt_near(dot(u, u) * dot(v, v), BITS)
    return length + dot(u, v), x, y, z


def _product(p: Quaternion, q: Quaternion) -> Quaternion:
    """Of quaternions: q first, then p."""
    a, x = p[0], p[1:]
    b, y = q[0], q[1:]
    return a * b - dot(x, y), *add(add(scaled(a, y), scaled(b, x)), cross(x, y))


def is_half_turn(u: Vector, v: Vector) -> bool:
    """Whether two axes are opposite, or all but so: then neither way round is the short one."""
    cosine = dot(u, v)
    return cosine < 0 and cosine * cosine >= dot(u, u) * dot(v, v) * (1 - fmpq(1, 10**12))


def _shifts(places: list[Vector], weights: list[fmpq]) -> list[list[list[fmpq]]]:
    """Coefficients of a motion without turns: the way of the origin and the weight, by powers of the time."""
    return [
        [*([w if i == j else ZERO for j in range(3)] + [v[i]] for i in range(3)), [ZERO, ZERO, ZERO, w]]
        for v, w in zip(places, weights, strict=True)
    ]


def _between(start: Vector, end: Vector, t: float) -> list[float]:
    return [x + t * (y - x) for x, y in zip(_doubles(start), _doubles(end), strict=True)]


def _unit(x: Vector) -> list[float]:
    doubles = _doubles(x)
    length = math.hypot(*doubles)
    return [c / length for c in doubles]


def _doubles(x: Vector) -> list[float]:
    return [to_double(c) for c in x]


def _norm(x: Vector) -> float:
    return math.hypot(*_doubles(x))


def tangent_of_half(angle: float) -> fmpq:
    """The tangent of half an angle, rounded to a double."""
    return exact_value(math.tan(0.5 * angle))
