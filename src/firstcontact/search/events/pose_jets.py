"""Poses and their derivatives by the time, in ball arithmetic."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from flint import arb, arb_mat, ctx, fmpq, fmpq_poly

from firstcontact.exact.numbers import exact_value
from firstcontact.exact.rigid import ball_rotation, inverse_map
from firstcontact.exact.vectors import dot
from firstcontact.motion.moving import Moving
from firstcontact.motion.product import Product
from firstcontact.motion.relative.curved import own_series, terms
from firstcontact.motion.relative.polynomial import own_pose
from firstcontact.motion.relative.stretches import Window, known_steps, step_index
from firstcontact.motion.rotation import Rotation, angle_ball
from firstcontact.motion.screw import Screw
from firstcontact.motion.steps import REST, Step

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body


class PoseJet:
    """The pose of a body over one step of its motion and its derivative by the time, as (4, 4) matrices of balls.

    way: -1 where times are those of the motion backwards, at -t.
    """

    def __init__(self, body: Body, window: Window, way: int = 1) -> None:
        self.way = way
        motion = body.motion if isinstance(body, Moving) else REST
        middle = way * (exact_value(window.first) + exact_value(window.last)) / 2
        steps = known_steps(motion)
        self.step: Step = steps[step_index(steps, middle, middle)]
        self.before = _square(self.step.before.matrix())
        own = self.step.motion
        self.turns = isinstance(own, Rotation | Screw)
        if not self.turns and not isinstance(own, Product):
            rows = [[fmpq_poly(c) for c in row] for row in own_pose(own, "a body")]
            self.rows = [[(c, c.derivative()) for c in row] for row in rows]

    def at(self, t: arb) -> tuple[arb_mat, arb_mat]:
        local = (self.way * t - arb(self.step.origin)) / arb(self.step.unit)
        if isinstance(self.step.motion, Product):
            value, slope = self._product(local)
        else:
            value, slope = self._turning(local) if self.turns else self._rational(local)
        return value * self.before, slope * self.before * (self.way / arb(self.step.unit))

    def _rational(self, x: arb) -> tuple[arb_mat, arb_mat]:
        weight, change = (_at(p, x) for p in self.rows[3][3])
        value, slope = arb_mat(4, 4), arb_mat(4, 4)
        value[3, 3] = 1
        for i in range(3):
            for j in range(4):
                p, q = (_at(c, x) for c in self.rows[i][j])
                value[i, j] = p / weight
                slope[i, j] = (q - p / weight * change) / weight
        return value, slope

    def _product(self, x: arb) -> tuple[arb_mat, arb_mat]:
        with terms(2, ctx.prec):
            rows = own_series(self.step.motion, x, fmpq(1))
        slope = arb_mat([[c[1] for c in row] for row in rows] + [[0, 0, 0, 0]])
        return _square([[c[0] for c in row] for row in rows]), slope

    def _turning(self, x: arb) -> tuple[arb_mat, arb_mat]:
        """A point p of the axis stays: the derivative of R (y - p) + p + x h is rate [k] R (y - p) + h."""
        own = self.step.motion
        whole = angle_ball(own.angle, own.unit)
        length = arb(dot(own.axis, own.axis)).sqrt()
        k, p = [arb(c) / length for c in own.axis], [arb(c) for c in own.point]
        value = _square(ball_rotation(own.axis, own.point, x * whole))
        about = arb_mat([[value[i, j] for j in range(3)] + [value[i, 3] - p[i]] for i in range(3)])
        skew = arb_mat([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
        turned = skew * about * whole
        slope = arb_mat(4, 4)
        for i in range(3):
            for j in range(4):
                slope[i, j] = turned[i, j]
        if isinstance(own, Screw):
            for i in range(3):
                value[i, 3] += x * arb(own.advance) * k[i]
                slope[i, 3] += arb(own.advance) * k[i]
        return value, slope


def relative_jet(poses: tuple[PoseJet, PoseJet], t: arb) -> tuple[arb_mat, arb_mat]:
    """From the first body's frame to the second one's, and its derivative."""
    (a, by_a), (b, by_b) = (pose.at(t) for pose in poses)
    back = _square(inverse_map(tuple(tuple(b[i, j] for j in range(4)) for i in range(3))))  # type: ignore[arg-type]
    m = back * a
    return m, back * (by_a - by_b * m)


def _at(p: fmpq_poly, x: arb) -> arb:
    total = arb(0)
    for c in reversed(p.coeffs()):
        total = total * x + arb(c)
    return total


def _square(rows: Sequence[Sequence[arb | fmpq]]) -> arb_mat:
    return arb_mat([[arb(c) for c in row] for row in rows] + [[0, 0, 0, 1]])
