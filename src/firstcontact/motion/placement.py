"""A rigid pose as a product of exact steps: rational where it can be, otherwise enclosed at any precision."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flint import fmpq

from firstcontact.exact.numbers import ball, precision
from firstcontact.exact.rigid import (
    IDENTITY,
    Matrix,
    ball_rotation,
    compose,
    exact_rotation,
    rational_sqrt,
    shift,
)
from firstcontact.exact.vectors import dot, scaled
from firstcontact.motion.rotation import angle_ball


@dataclass(frozen=True, slots=True)
class Turn:
    """Rotation about an axis by `radians` + `turns` full turns, both rational."""

    axis: tuple[fmpq, fmpq, fmpq]
    point: tuple[fmpq, fmpq, fmpq]
    radians: fmpq
    turns: fmpq

    def exact(self) -> Matrix | None:
        """The rotation where it is rational: no rational radians but zero give one (Lindemann)."""
        return exact_rotation(self.axis, self.point, self.turns, "turns") if self.radians == 0 else None

    def enclose(self) -> Matrix:
        angle = angle_ball(self.radians, "radians") + angle_ball(self.turns, "turns")
        return ball_rotation(self.axis, self.point, angle)


@dataclass(frozen=True, slots=True)
class Twist:
    """A turn followed by an advance along its axis by a rational length."""

    turn: Turn
    advance: fmpq

    def exact(self) -> Matrix | None:
        """The map where it is rational: turn and shift both are."""
        turned = self.turn.exact()
        length = rational_sqrt(dot(self.turn.axis, self.turn.axis)) if self.advance else fmpq(1)
        if turned is None or length is None:
            return None
        return compose(shift(scaled(self.advance / length, self.turn.axis)), turned)

    def enclose(self) -> Matrix:
        ahead = ball(self.advance) / ball(dot(self.turn.axis, self.turn.axis)).sqrt()
        return compose(shift(scaled(ahead, self.turn.axis)), self.turn.enclose())


@dataclass(frozen=True, slots=True)
class Placement:
    """``factors``, last one applied last: rational matrices, and Turns and Twists that no rational matrix describes."""

    factors: tuple[Any, ...] = ()

    def then(self, factor: Matrix | Turn | Twist) -> Placement:
        matrix = factor.exact() if isinstance(factor, Turn | Twist) else factor
        if matrix is None:
            return Placement((*self.factors, factor))
        if matrix == IDENTITY:
            return self
        if self.factors and not isinstance(self.factors[-1], Turn | Twist):
            return Placement((*self.factors[:-1], compose(matrix, self.factors[-1])))
        return Placement((*self.factors, matrix))

    def shifted(self, v: tuple[fmpq, fmpq, fmpq]) -> Placement:
        return self.then(shift(v))

    @property
    def is_exact(self) -> bool:
        return not any(isinstance(f, Turn | Twist) for f in self.factors)

    def matrix(self) -> Matrix:
        """The rational matrix (exact placements), or its enclosure at the present precision."""
        total: Matrix | None = None
        for factor in self.factors:
            m = factor.enclose() if isinstance(factor, Turn | Twist) else factor
            total = m if total is None else compose(m, total)
        return IDENTITY if total is None else total

    def place(self, body: Any) -> Any:
        """The body in this pose; its `exact_vertex` gives balls where the pose is irrational."""
        if not self.factors:
            return body
        if self.is_exact:
            return body._mapped(self.matrix())
        with precision(128):
            doubles = [[float(ball(x)) for x in row] for row in self.matrix()]
        return body._placed(self, doubles)
