"""A pose as a product of exact steps: rational where it can be, otherwise enclosed at any precision.

`advanced` is the one place that says where a motion has taken a body after a part of it, its end too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from flint import arb, ctx, fmpq

from firstcontact.exact.numbers import ball, dyadic, precision
from firstcontact.exact.rigid import (
    IDENTITY,
    Matrix,
    ball_rotation,
    compose,
    exact_rotation,
    near_rotation,
    rational_sqrt,
    shift,
)
from firstcontact.exact.vectors import dot, scaled
from firstcontact.motion.poses import sqrt_near
from firstcontact.motion.product import Product
from firstcontact.motion.rational import RationalMotion
from firstcontact.motion.rotation import Rotation, angle_ball, sense_about
from firstcontact.motion.screw import Screw
from firstcontact.motion.translation import Translation

if TYPE_CHECKING:
    from firstcontact.body.placing import Placing
    from firstcontact.motion.kinds import Single

_0 = fmpq(0)
# Bits of the rational length that stands for an irrational one, and of the enclosures that become doubles.
LENGTH_BITS = 128
DOUBLE_BITS = 256


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

    def near(self) -> Matrix:
        """A rational rotation about the axis within 2^-60 radians of it."""
        with precision(DOUBLE_BITS):
            turns = self.turns + dyadic((arb(self.radians) / (2 * arb.pi())).mid())
        return near_rotation(self.axis, self.point, turns)


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

    def near(self) -> Matrix:
        """A rational map: the turn within 2^-60 radians, the advance within 2^-128 of itself."""
        ahead = self.advance / sqrt_near(dot(self.turn.axis, self.turn.axis), LENGTH_BITS)
        return compose(shift(scaled(ahead, self.turn.axis)), self.turn.near())


S = TypeVar("S", bound="Placing")


@dataclass(frozen=True, slots=True)
class Placement:
    """``factors``, last one applied last: rational matrices, and Turns and Twists that no rational matrix describes.

    earlier  the placement without the last factor, if there are more: what is known of it is not worked out again.
    """

    factors: tuple[Any, ...] = ()
    earlier: Placement | None = field(default=None, repr=False, compare=False)
    _known: dict[Any, Matrix] = field(default_factory=dict, repr=False, compare=False)

    def then(self, factor: Matrix | Turn | Twist) -> Placement:
        """The placement and then the factor; turns about one line are one."""
        last = self.factors[-1] if self.factors else None
        if isinstance(factor, Turn) and isinstance(last, Turn) and (sense := sense_about(factor, last)):
            radians, turns = last.radians + sense * factor.radians, last.turns + sense * factor.turns
            return (self.earlier or HERE).then(Turn(last.axis, last.point, radians, turns))
        matrix = factor.exact() if isinstance(factor, Turn | Twist) else factor
        if matrix is None:
            return Placement((*self.factors, factor), self)
        if matrix == IDENTITY:
            return self
        if self.factors and not isinstance(self.factors[-1], Turn | Twist):
            return Placement((*self.factors[:-1], compose(matrix, self.factors[-1])), self.earlier)
        return Placement((*self.factors, matrix), self)

    def shifted(self, v: tuple[fmpq, fmpq, fmpq]) -> Placement:
        return self.then(shift(v))

    @property
    def is_exact(self) -> bool:
        return not any(isinstance(f, Turn | Twist) for f in self.factors)

    def matrix(self) -> Matrix:
        """The rational matrix (exact placements), or its enclosure at the present precision."""
        return self._product(ctx.prec, lambda factor: factor.enclose())

    def near(self) -> Matrix:
        """A rational matrix: each Turn and Twist replaced by the one that it is `near`."""
        return self._product("near", lambda factor: factor.near())

    def doubles(self) -> np.ndarray:
        """The (4, 4) pose, rounded once."""
        with precision(DOUBLE_BITS):
            return np.array([*([float(ball(x)) for x in row] for row in self.matrix()), [0.0, 0.0, 0.0, 1.0]])

    def _product(self, form: int | str, of: Callable[[Turn | Twist], Matrix]) -> Matrix:
        """The factors multiplied, each irrational one as `of` gives it; known for each form once asked for."""
        waiting: list[Placement] = []
        here: Placement | None = self
        while here is not None and here.factors and form not in here._known:
            waiting.append(here)
            here = here.earlier
        total = here._known[form] if here is not None and here.factors else IDENTITY
        for placement in reversed(waiting):
            last = placement.factors[-1]
            m = of(last) if isinstance(last, Turn | Twist) else last
            total = m if total is IDENTITY else compose(m, total)
            placement._known[form] = total
        return total

    def place(self, body: S) -> S:
        """The body in this pose; its `exact_vertex` gives balls where the pose is irrational."""
        if not self.factors:
            return body
        if self.is_exact:
            return body._mapped(self.matrix())
        with precision(128):
            doubles = [[float(ball(x)) for x in row] for row in self.matrix()]
        return body._placed(self, doubles)  # type: ignore[attr-defined, no-any-return]  # of polyhedra


HERE = Placement()


def advanced(before: Placement, motion: Single, share: fmpq) -> Placement:
    """The pose `before` and then `share` of the motion; the end of a step is where all of it leads."""
    if isinstance(motion, RationalMotion):
        rows = motion.exact(share)
        matrix: Matrix = (tuple(rows[0]), tuple(rows[1]), tuple(rows[2]))  # type: ignore[assignment]
        return before.then(matrix)
    if isinstance(motion, Product):
        for factor in reversed(motion.factors):
            before = advanced(before, factor.motion, factor.at(share))
        return before
    if share == 0:
        return before
    if isinstance(motion, Translation):
        return before.shifted(scaled(share, motion.vector))
    turn = Turn(motion.axis, motion.point, *angle_of(motion, share))
    return before.then(Twist(turn, share * motion.advance) if isinstance(motion, Screw) else turn)


def angle_of(motion: Rotation | Screw, share: fmpq) -> tuple[fmpq, fmpq]:
    """(radians, turns) of that share of a rotation."""
    angle = motion.angle * share
    return (angle, _0) if motion.unit == "radians" else (_0, angle)
