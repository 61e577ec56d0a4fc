"""Motions of any kind as text and, beside it, as poses of rational numbers computed here from their definitions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction as F
from typing import Any

from .brute import Mesh, Point, dot, minus, plus, times
from .laws import rotation
from .shapes import number, vector
from .turning import Axis, Speed

Matrix = list[list[Any]]
"""Rows of a 4x4 pose."""


@dataclass(frozen=True)
class Path:
    """A motion.

    text   the call that makes it; kind: its name in the table.
    pose   the pose at a time, exact where it is rational, otherwise to some 100 digits.
    span   of the motion itself; None where it goes on.
    """

    text: str
    kind: str
    pose: Callable[[F], Matrix]
    span: tuple[F, F] = (F(0), F(1))

    def moved(self, body: Mesh, t: F) -> Mesh:
        m = self.pose(t)
        return body.mapped(lambda p: applied(m, p))


def applied(m: Matrix, p: Point) -> Point:
    return tuple(sum(m[i][j] * p[j] for j in range(3)) + m[i][3] for i in range(3))  # type: ignore[return-value]


def product(m: Matrix, n: Matrix) -> Matrix:
    return [[sum(m[i][k] * n[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def rigid(turn: Any, shift: Sequence[Any]) -> Matrix:
    return [[*turn[i][:3], shift[i]] for i in range(3)] + [[F(0), F(0), F(0), F(1)]]


UNIT: Matrix = rigid([[F(int(i == j)) for j in range(3)] for i in range(3)], (F(0), F(0), F(0)))
REST = Path("", "rest", lambda t: UNIT)


def inverse(m: Matrix) -> Matrix:
    """Of a rigid motion."""
    turn = [[m[j][i] for j in range(3)] for i in range(3)]
    return rigid(turn, [-sum(turn[i][j] * m[j][3] for j in range(3)) for i in range(3)])


def shift(v: Point) -> Path:
    return Path(f"fc.Translation({vector(v)})", "translation", lambda t: rigid(UNIT, times(t, v)))


def _about(axis: Axis, turns: F, advance: F) -> Matrix:
    c, s = axis.near(turns)
    columns = [minus(axis.turned(plus(axis.point, e), c, s), axis.point) for e in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    rows = [[columns[j][i] for j in range(3)] for i in range(3)]
    moved = minus(axis.point, tuple(dot(row, axis.point) for row in rows))  # type: ignore[arg-type]
    if advance:
        length = _root(axis.square)
        moved = plus(moved, times(advance / length, axis.way))
    return rigid(rows, moved)


def _root(n: int) -> F:
    root = int(n**0.5 + 0.5)
    if root * root != n:
        raise ValueError("an axis of irrational length")
    return F(root)


def turn(axis: Axis, speed: Speed, advance: F = F(0)) -> Path:
    """A rotation, or a screw."""
    angle = f"{speed.unit}={number(speed.rate)}"
    arguments = f"{vector(axis.way)}, {vector(axis.point)}, {angle}"
    pose = lambda t: _about(axis, speed.turns() * t, advance * t)  # noqa: E731
    if advance:
        return Path(f"fc.Screw({arguments}, advance={number(advance)})", "screw", pose)
    return Path(f"fc.Rotation({arguments})", "rotation", pose)


def rational(coefficients: Sequence[Matrix]) -> Path:
    """RationalMotion of these matrices."""

    def pose(t: F) -> Matrix:
        total = [[sum(c[i][j] * t**k for k, c in enumerate(coefficients)) for j in range(4)] for i in range(4)]
        return [[x / total[3][3] for x in row] for row in total]

    def listed(c: Matrix) -> str:
        return "[" + ", ".join("[" + ", ".join(map(number, row)) + "]" for row in c) + "]"

    return Path(f"fc.RationalMotion([{', '.join(map(listed, coefficients))}])", "rational", pose)


def _mixed(p: Sequence[F], q: Sequence[F], s: F) -> Matrix:
    """The rotation of the line of unit quaternions, the short way."""
    if sum(x * y for x, y in zip(p, q, strict=True)) < 0:
        q = [-x for x in q]
    lengths = [_root(int(sum(x * x for x in r))) for r in (p, q)]
    return rotation(tuple((1 - s) * x / lengths[0] + s * y / lengths[1] for x, y in zip(p, q, strict=True)))  # type: ignore


def trajectory(moments: Sequence[F], places: Sequence[Point], quaternions: Sequence[Sequence[int]]) -> Path:
    """Linear quaternions of whole length, w first; with two poses at 0 and 1 it is RationalMotion.between."""

    def pose(t: F) -> Matrix:
        k = max(i for i in range(len(moments) - 1) if i == 0 or moments[i] <= t)
        s = (t - moments[k]) / (moments[k + 1] - moments[k])
        turned = _mixed([F(x) for x in quaternions[k]], [F(x) for x in quaternions[k + 1]], s)
        return rigid(turned, plus(times(1 - s, places[k]), times(s, places[k + 1])))

    poses = ", ".join(map(vector, places))
    turns = ", ".join(str(tuple(q)) for q in quaternions)
    if tuple(moments) == (0, 1):
        return Path(f"fc.RationalMotion.between({poses}, quat_wxyz=[{turns}])", "between", pose)
    text = f"fc.Trajectory([{', '.join(map(number, moments))}], [{poses}], quat_wxyz=[{turns}])"
    return Path(text, "trajectory", pose, (F(moments[0]), F(moments[-1])))


def sequence(steps: Sequence[Path], durations: Sequence[F]) -> Path:
    def pose(t: F) -> Matrix:
        before, done = UNIT, F(0)
        for step, duration in zip(steps, durations, strict=True):
            if t <= done + duration:
                return product(step.pose((t - done) / duration), before)
            before, done = product(step.pose(F(1)), before), done + duration
        return before

    inner = ", ".join(step.text for step in steps)
    text = f"fc.Sequence([{inner}], durations=[{', '.join(map(number, durations))}])"
    return Path(text, "sequence", pose, (F(0), sum(durations, F(0))))


def carried(direction: Point, point: Point, turned: Matrix) -> tuple[Point, Point]:
    """A direction and a point under a rigid placement."""
    return minus(applied(turned, direction), applied(turned, (0, 0, 0))), applied(turned, point)

