"""Motions as text and as poses of their own: what a body's 4x4 matrix is at a rational time, from the definitions.

`pose` is exact where the motion's pose is rational, and good to 50 digits elsewhere; `quick` is the same in doubles.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction as F
from math import cos, pi, sin
from typing import Any

from . import exact as ex
from .exact import IDENTITY, Matrix, Vector


@dataclass(frozen=True)
class Rest:
    kind: str = "rest"

    def text(self) -> str:
        return ""

    def pose(self, t: Any) -> Matrix:
        return IDENTITY

    quick = pose

    def sure(self, t: F) -> bool:
        """Whether the pose at t is exact."""
        return True


@dataclass(frozen=True)
class Shift:
    vector: Vector
    kind: str = "translation"

    def text(self) -> str:
        return f"fc.Translation({ex.texts(tuple(self.vector))})"

    def pose(self, t: Any) -> Matrix:
        return ex.shifting(ex.scale(t, self.vector))

    def quick(self, t: float) -> Matrix:
        return ex.shifting([t * float(x) for x in self.vector])

    def sure(self, t: F) -> bool:
        return True


@dataclass(frozen=True)
class Turn:
    """A rotation, or with `advance` a screw; the axis is `unit` times `factor`, both rational."""

    unit: Vector
    point: Vector
    turns: F
    advance: F | None = None
    factor: int = 1
    degrees: bool = False

    @property
    def kind(self) -> str:
        return "rotation" if self.advance is None else "screw"

    def text(self) -> str:
        angle = f"degrees={ex.text(self.turns * 360)}" if self.degrees else f"turns={ex.text(self.turns)}"
        axis, point = ex.texts(ex.scale(self.factor, self.unit)), ex.texts(tuple(self.point))
        if self.advance is None:
            return f"fc.Rotation({axis}, {point}, {angle})"
        return f"fc.Screw({axis}, {point}, {angle}, advance={ex.text(self.advance)})"

    def pose(self, t: F) -> Matrix:
        return ex.about(self.unit, *ex.turned(self.turns * t), self.point, (self.advance or 0) * t)

    def quick(self, t: float) -> Matrix:
        angle = 2 * pi * float(self.turns) * t
        axis, point = tuple(map(float, self.unit)), tuple(map(float, self.point))
        return ex.about(axis, cos(angle), sin(angle), point, float(self.advance or 0) * t)

    def sure(self, t: F) -> bool:
        return (4 * self.turns * t).denominator == 1


@dataclass(frozen=True)
class Rolling:
    """Rational: the turn about an axis by the quaternion (1 - t) p + t q, then the shift t v.

    About the line through `point`; p = (p0, p1 axis), q = (q0, q1 axis), the axis of whole numbers, any length.
    """

    axis: Vector
    point: Vector
    real: tuple[F, F]
    imaginary: tuple[F, F]
    vector: Vector
    kind: str = "rational"

    def _turn(self, t: Any) -> tuple[Any, Any, Any, Any]:
        """Of the unnormalised matrix: its value (as a function of the quaternion) and the weight."""
        w = self.real[0] + (self.real[1] - self.real[0]) * t
        k = self.imaginary[0] + (self.imaginary[1] - self.imaginary[0]) * t
        return (k * self.axis[0], k * self.axis[1], k * self.axis[2], w)

    def pose(self, t: Any) -> Matrix:
        lin = turn_of(self._turn(t))
        shift = [self.point[i] - ex.dot(lin[i], self.point) + t * self.vector[i] for i in range(3)]
        return [*([*lin[i], shift[i]] for i in range(3)), IDENTITY[3]]

    def quick(self, t: float) -> Matrix:
        return Rolling(*(tuple(map(float, v)) for v in (self.axis, self.point, self.real, self.imaginary, self.vector))
                       ).pose(t)  # type: ignore[arg-type]

    def sure(self, t: F) -> bool:
        return True

    def text(self) -> str:
        """By its coefficients: of degree 3, weight the square of the quaternion's norm."""
        nodes = (F(0), F(1), F(-1), F(2))
        values = []
        for t in nodes:
            q = self._turn(t)
            weight = sum(x * x for x in q)
            pose = self.pose(t) if weight else None
            assert pose is not None
            values.append([[x * weight for x in row] for row in pose[:3]] + [[F(0), F(0), F(0), weight]])
        at = [[interpolated(nodes, [v[i][j] for v in values]) for j in range(4)] for i in range(4)]
        degree = max(k for k in range(4) for i in range(4) for j in range(4) if at[i][j][k] or k == 0)
        powers = [[[at[i][j][k] for j in range(4)] for i in range(4)] for k in range(degree + 1)]
        return f"fc.RationalMotion({ex.texts(powers)})"


def turn_of(q: Any) -> list[list[Any]]:
    x, y, z, w = q
    n = w * w + x * x + y * y + z * z
    return [[(w * w + x * x - y * y - z * z) / n, 2 * (x * y - w * z) / n, 2 * (x * z + w * y) / n],
            [2 * (x * y + w * z) / n, (w * w - x * x + y * y - z * z) / n, 2 * (y * z - w * x) / n],
            [2 * (x * z - w * y) / n, 2 * (y * z + w * x) / n, (w * w - x * x - y * y + z * z) / n]]


def interpolated(nodes: tuple[F, ...], values: list[F]) -> list[F]:
    """Coefficients, ascending, of the polynomial through the values at four nodes."""
    total = [F(0)] * 4
    for i, x in enumerate(nodes):
        basis, scale = [F(1)], values[i]
        for j, y in enumerate(nodes):
            if j != i:
                basis = [a - y * b for a, b in zip([F(0), *basis], [*basis, F(0)], strict=True)]
                scale /= x - y
        total = [a + scale * b for a, b in zip(total, basis, strict=True)]
    return total


@dataclass(frozen=True)
class Between:
    """RationalMotion.between, or a Trajectory of two poses: unit quaternions along a line, shifts along a line.

    quaternions: rational, of unit length, (x, y, z, w), their inner product positive.
    """

    first: tuple[F, F, F, F]
    last: tuple[F, F, F, F]
    start: Vector
    end: Vector
    times: tuple[F, F] | None = None
    kind: str = "between"

    def pose(self, t: Any) -> Matrix:
        if self.times:
            t = (t - self.times[0]) / (self.times[1] - self.times[0])
        lin = turn_of([a + (b - a) * t for a, b in zip(self.first, self.last, strict=True)])
        return [*([*lin[i], self.start[i] + (self.end[i] - self.start[i]) * t] for i in range(3)), IDENTITY[3]]

    def quick(self, t: float) -> Matrix:
        return [[float(x) for x in row] for row in self.pose(F(t))]

    def sure(self, t: F) -> bool:
        return True

    def text(self) -> str:
        a, b = ([*([*turn_of(q)[i], v[i]] for i in range(3)), IDENTITY[3]]
                for q, v in ((self.first, self.start), (self.last, self.end)))
        if self.times:
            return f"fc.Trajectory({ex.texts(list(self.times))}, {ex.texts([a, b])})"
        return f"fc.RationalMotion.between({ex.texts(a)}, {ex.texts(b)})"


@dataclass(frozen=True)
class Steps:
    """A Sequence; all steps but the one asked for end in rational poses."""

    steps: tuple[Any, ...]
    durations: tuple[F, ...]
    kind: str = "sequence"

    def text(self) -> str:
        inner = ", ".join(step.text() for step in self.steps)
        return f"fc.Sequence([{inner}], durations={ex.texts(list(self.durations))})"

    def _at(self, t: Any) -> tuple[int, Any]:
        k = 0
        while k + 1 < len(self.steps) and t > self.durations[k]:
            t, k = t - self.durations[k], k + 1
        return k, t / self.durations[k]

    def pose(self, t: F) -> Matrix:
        k, part = self._at(t)
        pose = self.steps[k].pose(part)
        for step in self.steps[k - 1 :: -1] if k else ():
            pose = ex.product(pose, step.pose(F(1)))
        return pose

    def quick(self, t: float) -> Matrix:
        k, part = self._at(F(t))
        pose = self.steps[k].quick(float(part))
        for step in self.steps[k - 1 :: -1] if k else ():
            pose = ex.product(pose, step.quick(1.0))
        return pose

    def sure(self, t: F) -> bool:
        k, part = self._at(t)
        return self.steps[k].sure(part) and all(step.sure(F(1)) for step in self.steps[:k])


def moved(body: str, motion: Any) -> str:
    return body if motion.kind == "rest" else f"{body}.moving({motion.text()})"
