"""Relative motion that is neither one translation nor one rotation: power series of the pose at any time, and the
pose itself as a rational function of the time where it is one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import arb, arb_poly, arb_series, ctx, fmpq, fmpq_poly, fmpz_poly

from firstcontact.exact.numbers import ball, precision, rational
from firstcontact.exact.rigid import IDENTITY, Matrix
from firstcontact.exact.vectors import Vector, cross, dot
from firstcontact.motion.placement import Placement, Turn, Twist, advanced
from firstcontact.motion.product import Product, at
from firstcontact.motion.rational import RationalMotion
from firstcontact.motion.relative.polynomial import PolynomialPiece, relative, step_pieces
from firstcontact.motion.relative.polynomial import PolynomialStep as PolynomialStep
from firstcontact.motion.relative.turns import bits_of_distance
from firstcontact.motion.rotation import Rotation, angle_ball
from firstcontact.motion.screw import Screw
from firstcontact.motion.translation import Translation

if TYPE_CHECKING:
    from firstcontact.exact.ring import N
    from firstcontact.motion.kinds import AnyMotion, Single
    from firstcontact.motion.relative.pieces import MotionPiece

# A pose as power series in (time - t): three rows of four.
Series = list[list[Any]]
Balls = list[list[arb]]


class terms(precision):  # noqa: N801 - reads as `with terms(8, 128):`
    """Context: power series of that many terms in balls of that many bits."""

    def __init__(self, count: int, bits: int) -> None:
        super().__init__(bits)
        self.count = count

    def __enter__(self) -> None:
        super().__enter__()
        self.cap = ctx.cap
        ctx.cap = self.count

    def __exit__(self, *exception: object) -> None:
        ctx.cap = self.cap
        super().__exit__(*exception)


@dataclass(frozen=True, slots=True)
class Leg:
    """One body's motion during a piece: `motion` at its own time (t - origin) / unit, after the pose `before`."""

    motion: Any
    origin: fmpq
    unit: fmpq
    before: Placement
    of: str

    @property
    def rests(self) -> bool:
        """Whether the body stands in the identity at all times."""
        rests: bool = self.motion.rests
        return rests and not self.before.factors

    @property
    def is_rigid(self) -> bool:
        """Whether the pose is a rotation and a shift at all times."""
        rigid: bool = self.motion.is_rigid
        return rigid and all(_is_rotation(f) for f in self.before.factors if isinstance(f, tuple))

    def part(self, start: fmpq, end: fmpq) -> tuple[int, int, int, int]:
        """(p, q, m, n): of its motion's own time, the body makes m / n from p / q on; whole numbers are quick to hash.
        """
        begin, share = (start - self.origin) / self.unit, (end - start) / self.unit
        return int(begin.p), int(begin.q), int(share.p), int(share.q)

    def fixed_direction(self, v: Vector) -> Vector | None:
        """Where the motion takes the line of direction v, if to one and the same at all times that is known exactly."""
        for factor in self.before.factors:
            if isinstance(factor, Turn | Twist):
                axis = (factor.turn if isinstance(factor, Twist) else factor).axis
                if any(cross(v, axis)):
                    return None
            else:
                v = _turned(factor, v)
        if isinstance(self.motion, RationalMotion):
            return _fixed_image(self.motion, v)
        return None if any(any(cross(v, axis)) for axis in turning_axes(self.motion)) else v

    def series(self, t: arb) -> Series:
        """The pose around the time t."""
        pose = own_series(self.motion, (t - self.origin) / self.unit, 1 / self.unit)
        if not self.before.factors:
            return pose
        return after(pose, self.before.matrix())

    def place(self, time: fmpq) -> Placement:
        """The pose at that time."""
        return advanced(self.before, self.motion, (time - self.origin) / self.unit)


@dataclass(frozen=True)
class CurvedPiece:
    """Motion of a seen from b during [start, end], by the motions of both; local time is t - start.

    The working frame is that of body b as it was given; `carry` brings points of it to the world.
    """

    start: fmpq
    end: fmpq
    leg_a: Leg
    leg_b: Leg

    @property
    def reference(self) -> fmpq:
        return self.start

    def series(self, t: arb) -> Series:
        """The pose of a seen from b around the time t, power series in the time; under `terms`."""
        pose = self.leg_a.series(t)
        return pose if self.leg_b.rests else composed(inverse(self.leg_b.series(t), self.leg_b.is_rigid), pose)

    @property
    def is_rigid(self) -> bool:
        return self.leg_a.is_rigid and self.leg_b.is_rigid

    @property
    def is_rational(self) -> bool:
        """Whether the relative motion is a rational function of the time."""
        return _is_rational(self.leg_a) and _is_rational(self.leg_b)

    @cached_property
    def polynomial(self) -> PolynomialPiece | None:
        """The relative motion as a rational function of the time, where it is one."""
        return _relative(self.leg_a, self.leg_b, self.start, self.end) if self.is_rational else None

    def carry(self, t: float) -> np.ndarray | None:
        """Float pose (4, 4) of the working frame in the world at time t; None where it rests."""
        if self.leg_b.rests:
            return None
        time = min(max(rational(t, "time"), self.start), self.end)
        with terms(1, 128):
            rows = self.leg_b.series(ball(time))
            return np.array([[float(x[0]) for x in row] for row in rows] + [[0.0, 0.0, 0.0, 1.0]])

    def placed_at_start(self) -> tuple[Placement, Placement]:
        """Both bodies' poses in the world at the start."""
        return self.leg_a.place(self.start), self.leg_b.place(self.start)

    def continues(self, before: MotionPiece | CurvedPiece | None) -> bool:
        """Whether both bodies certainly start where they stand at the end of the piece before."""
        if not isinstance(before, CurvedPiece):
            return False
        return (self.leg_a, self.leg_b) == (before.leg_a, before.leg_b) or all(
            mine.place(self.start).factors == theirs.place(before.end).factors  # one pose, whether rational or not
            for mine, theirs in ((self.leg_a, before.leg_a), (self.leg_b, before.leg_b))
        )

    def why_inexact(self) -> str:
        """Why the contact times of the piece have no exact form."""
        return (
            f"{self.leg_a.of} with {self.leg_b.of}: their relative motion is no rational function of the time, so "
            "times of contact have no exact form; ask without exact=True for certified enclosures"
        )


def step_at(motions: Sequence[CurvedPiece], time: fmpq) -> CurvedPiece:
    """The step that holds a time, or the nearest one where rounding took that beyond all."""
    return min(motions, key=lambda m: max(m.start - time, time - m.end))


def _turned(m: Sequence[Sequence[N]], v: Vector) -> Vector:
    return dot(m[0][:3], v), dot(m[1][:3], v), dot(m[2][:3], v)


def _fixed_image(motion: RationalMotion, v: Vector) -> Vector | None:
    """A direction to which all others are parallel that the motion takes v to; None where there is none."""
    images = [_turned(m, v) for m in motion.coefficients]
    first = next((x for x in images if any(x)), None)
    return None if first is None or any(any(cross(first, x)) for x in images) else first


def turning_axes(motion: AnyMotion) -> list[Vector]:
    """The axes about which it turns, of a motion that is not a rational function of the time."""
    parts = [f.motion for f in motion.factors] if isinstance(motion, Product) else [motion]
    return [part.axis for part in parts if isinstance(part, Rotation | Screw) and part.angle != 0]


def _is_rational(leg: Leg) -> bool:
    rational: bool = leg.motion.is_rational
    return rational and leg.before.is_exact


@lru_cache(maxsize=64)
def _relative(leg_a: Leg, leg_b: Leg, start: fmpq, end: fmpq) -> PolynomialPiece:
    return relative(*(_polynomial(leg, start, end) for leg in (leg_a, leg_b)))


def _polynomial(leg: Leg, start: fmpq, end: fmpq) -> PolynomialPiece:
    step = PolynomialStep(leg.motion, None, None, leg.before.matrix(), True, leg.origin, leg.unit)
    return next(step_pieces(step, start, end, leg.of))


def _is_rotation(m: Matrix) -> bool:
    """Whether the linear part of a rational matrix is a rotation or a reflection."""
    return all(
        sum((m[k][i] * m[k][j] for k in range(3)), fmpq(0)) == (i == j) for i in range(3) for j in range(i, 3)
    )


# ------------------------------------------------------------------------------------------------------ series


def own_series(motion: Single, t: arb, speed: fmpq) -> Series:
    """The pose of one motion at its own time t + speed x, in powers of x."""
    if isinstance(motion, RationalMotion):
        argument = arb_poly([t, arb(speed)])
        weight = _series(motion.pose[3][3], argument)
        return [[_divided(_series(x, argument), weight) for x in row] for row in motion.pose[:3]]
    time = arb_series([t, arb(speed)])
    if not isinstance(motion, Product):
        return _simple_series(motion, time)
    pose: Series | None = None
    for factor in motion.factors:
        own = _simple_series(factor.motion, at(factor.value, time))
        pose = own if pose is None else composed(pose, own)
    assert pose is not None
    return pose


def _simple_series(motion: Translation | Rotation | Screw, time: arb_series) -> Series:
    """The pose of a motion at its own time, a series."""
    if isinstance(motion, Translation):
        return [
            [*(arb_series([int(i == j)]) for j in range(3)), time * ball(motion.vector[i])] for i in range(3)
        ]
    with precision(ctx.prec + bits_of_distance(motion)):
        angle = time * angle_ball(motion.angle, motion.unit)
        cosine, sine = angle.cos(), angle.sin()
        rest, swing, across, ahead = turning(motion, ctx.prec)
        rows = [
            [cosine * s + sine * c + r for r, s, c in zip(*row, strict=True)]
            for row in zip(rest, swing, across, strict=True)
        ]
        if any(ahead):
            rows = [[*row[:3], row[3] + time * x] for row, x in zip(rows, ahead, strict=True)]
        return rows


@lru_cache(maxsize=256)
def turning(motion: Rotation | Screw, bits: int) -> tuple[Balls, Balls, Balls, list[arb]]:
    """Maps P, 1 - P and N about the axis, three rows of four, and the way along it, in balls of that many bits.

    The pose turned by an angle is P + (1 - P) cos(angle) + N sin(angle), P the projection on the axis n through the
    motion's point and N the product with n.
    """
    with precision(bits):
        length = ball(dot(motion.axis, motion.axis)).sqrt()
        n = [ball(x) / length for x in motion.axis]
        nil = arb(0)
        along = [[x * y for y in n] for x in n]
        swing = [[int(i == j) - along[i][j] for j in range(3)] for i in range(3)]
        across = [[nil, -n[2], n[1]], [n[2], nil, -n[0]], [-n[1], n[0], nil]]
        p = [ball(x) for x in motion.point]
        placed = [[sum((x * y for x, y in zip(row, p, strict=True)), nil) for row in m] for m in (swing, across)]
        shifts = placed[0], [-x for x in placed[0]], [-x for x in placed[1]]
        rest, swing, across = (
            [[*row, x] for row, x in zip(m, shift, strict=True)]
            for m, shift in zip((along, swing, across), shifts, strict=True)
        )
        ahead = [ball(motion.advance) * x if motion.advance else nil for x in n]
        return rest, swing, across, ahead


def _series(p: fmpz_poly | Sequence[fmpq], argument: arb_poly) -> arb_series:
    return arb_series((arb_poly(fmpq_poly(p)) if p else arb_poly([0]))(argument))


def _divided(x: arb_series, y: arb_series) -> arb_series:
    """x / y; not finite where balls do not tell y from zero, over a time too long for them."""
    return arb_series([arb("nan")] * ctx.cap) if y[0].contains(0) else x / y


def after(pose: Series, first: Matrix) -> Series:
    """The pose applied after a fixed map."""
    if first is IDENTITY:
        return pose
    columns = [[ball(first[k][j]) for k in range(3)] for j in range(4)]
    return [
        [
            row[0] * columns[j][0] + row[1] * columns[j][1] + row[2] * columns[j][2] + (row[3] if j == 3 else 0)
            for j in range(4)
        ]
        for row in pose
    ]


def composed(m: Series, n: Series) -> Series:
    """First n, then m."""
    return [
        [
            row[0] * n[0][j] + row[1] * n[1][j] + row[2] * n[2][j] + (row[3] if j == 3 else 0) for j in range(4)
        ]
        for row in m
    ]


def cofactors(m: Series) -> Series:
    """The matrix of cofactors of the linear part: det(m) m^-T, what cross products are mapped by."""
    out = []
    for i in range(3):
        p, q = m[(i + 1) % 3], m[(i + 2) % 3]
        out.append([p[(j + 1) % 3] * q[(j + 2) % 3] - p[(j + 2) % 3] * q[(j + 1) % 3] for j in range(3)])
    return out


def inverse(m: Series, rigid: bool) -> Series:
    """The inverse map; the transpose does for rotations."""
    linear = [[m[j][i] for j in range(3)] for i in range(3)]
    if not rigid:
        c = cofactors(m)
        determinant = m[0][0] * c[0][0] + m[0][1] * c[0][1] + m[0][2] * c[0][2]
        linear = [[_divided(c[j][i], determinant) for j in range(3)] for i in range(3)]
    return [
        [*row, -(row[0] * m[0][3] + row[1] * m[1][3] + row[2] * m[2][3])] for row in linear
    ]
