"""Rational invariants of points under rotation about an axis through the origin along h, any length.

With K = h.h:  height(x) = h.x is |h| times the height, `perp` K times the dot product and `turn` |h| times
the cross product of the parts perpendicular to the axis; the angle from x to y is atan2(sqrt(K) turn, perp).
Arguments may be Surds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.exact.numbers import ball
from firstcontact.exact.vectors import Vector, cross, dot

if TYPE_CHECKING:
    from firstcontact.exact.ring import N, VectorOf


class Axis:
    """A direction h with its K = h.h."""

    __slots__ = ("K", "h")

    def __init__(self, h: Vector) -> None:
        self.h = h
        self.K = dot(h, h)

    def reversed(self) -> Axis:
        """The axis that turns the other way."""
        return Axis((-self.h[0], -self.h[1], -self.h[2]))

    def as_balls(self) -> Axis:
        """The axis in balls of the present precision."""
        return Axis((ball(self.h[0]), ball(self.h[1]), ball(self.h[2])))

    def height(self, x: VectorOf[N]) -> N:
        return dot(x, self.h)

    def perp(self, x: VectorOf[N], y: VectorOf[N]) -> N:
        return dot(x, y) * self.K - self.height(x) * self.height(y)

    def turn(self, x: VectorOf[N], y: VectorOf[N]) -> N:
        return dot(cross(x, y), self.h)
