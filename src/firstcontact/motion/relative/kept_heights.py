"""Heights along a direction that both bodies keep: all axes about which they turn are parallel to it.

A turn about an axis leaves the heights along that axis as they are, whatever its angle, and an advance adds the same to
all.  So a point x of a body is at the height row . x + offset + rate t at the time t, and two sets of points share none
while their heights are apart: exactly known times, where enclosures of poses only come close.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb, fmpq

from firstcontact.exact.numbers import ball, dyadic
from firstcontact.exact.vectors import Vector, cross, dot
from firstcontact.motion.placement import Turn, Twist
from firstcontact.motion.relative.curved import CurvedPiece, Leg, turning_axes
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw
from firstcontact.motion.translation import Translation

Times = tuple[fmpq, fmpq]


@dataclass(frozen=True, slots=True)
class KeptHeights:
    """Of the points x of a body at the local time t of a piece: row . x + offset + rate t."""

    row: Vector
    offset: arb
    rate: arb


def heights_in(piece: CurvedPiece) -> tuple[KeptHeights, KeptHeights] | None:
    """Of both bodies, at the present precision; None where no direction is kept."""
    legs = piece.leg_a, piece.leg_b
    normal = next((axis for leg in legs for axis in turning_axes(leg.motion)), None)
    if normal is None:
        return None
    a, b = (_heights_of(leg, normal, piece.start) for leg in legs)
    return None if a is None or b is None else (a, b)


def _heights_of(leg: Leg, normal: Vector, start: fmpq) -> KeptHeights | None:
    row, motion = normal, leg.motion
    if isinstance(motion, Translation):
        speed = arb(dot(row, motion.vector))
    elif isinstance(motion, Rotation | Screw) and not any(cross(motion.axis, row)):
        speed = _rise(row, motion.axis, motion.advance) if motion.advance else arb(0)
    else:
        return None
    offset = speed * ((start - leg.origin) / leg.unit)
    for factor in reversed(leg.before.factors):
        if isinstance(factor, Turn | Twist):
            axis = (factor.turn if isinstance(factor, Twist) else factor).axis
            if any(cross(axis, row)):
                return None
            if isinstance(factor, Twist):
                offset += _rise(row, axis, factor.advance)
        else:
            offset += dot(row, [m[3] for m in factor])
            row = tuple(dot(row, [m[k] for m in factor]) for k in range(3))
    return KeptHeights(row, offset, speed / leg.unit)


def _rise(row: Vector, axis: Vector, advance: fmpq) -> arb:
    """What an advance along a parallel axis adds to the heights."""
    return ball(advance * dot(row, axis)) / ball(dot(axis, axis)).sqrt()


def times_level(
    heights: tuple[KeptHeights, KeptHeights], points: tuple[Sequence[Vector], Sequence[Vector]], lo: fmpq, hi: fmpq
) -> Times | None:
    """The part of the time from lo to hi outside which two sets of points certainly share no height; None: all of it.

    points: corners of convex sets, each in the frame of its body.
    """
    a, b = heights
    of_a, of_b = ([dot(h.row, x) for x in some] for h, some in zip(heights, points, strict=True))
    offset, rate = a.offset - b.offset, a.rate - b.rate
    # the gap between the one below and the one above is first + rise t, and no contact is where that is positive
    for first, rise in (
        (offset + (min(of_a) - max(of_b)), rate), ((min(of_b) - max(of_a)) - offset, -rate),
    ):  # fmt: skip
        if first + rise * arb(lo) > 0 and first + rise * arb(hi) > 0:
            return None
        if rise > 0:
            hi = min(hi, dyadic((-first / rise).upper()))
        elif rise < 0:
            lo = max(lo, dyadic((-first / rise).lower()))
        if lo > hi:
            return None
    return lo, hi
