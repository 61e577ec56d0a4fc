"""Exact times of contact, in the local clock of one piece of the motion.

`RationalInstant` under translation, `AngleInstant` under rotation.  Both compare exactly, enclose themselves by
balls at any precision, and know their time in the world.  In irrational poses their numbers are balls; then
comparing may raise Undecidable.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, Self, TypeAlias

from flint import arb, ctx, fmpq

from firstcontact.exact.fields.surd import Surd, sign_two_radicals, surd
from firstcontact.exact.numbers import (
    PRECISIONS,
    Undecidable,
    ball,
    ball_bounds,
    dyadic,
    likely,
    precision,
    sign,
    to_double,
)

if TYPE_CHECKING:
    from firstcontact.exact.ring import Scalar

QUARTER = 0.5 * math.pi


Radical: TypeAlias = "int | Scalar | Surd"


def enclose(number: Callable[[], fmpq | arb]) -> tuple[float, tuple[float, float]]:
    """(nearest double, (lo, hi) doubles around it) of a number given at the present precision.

    The precision rises until the double is certain; a number that lies exactly between two doubles, or is known
    as a ball only, ends with the likely one of the ball.
    """
    for bits in PRECISIONS:
        with precision(bits):
            value = number()
            if isinstance(value, fmpq):
                return _around(value)
            x = ball(value)
            lo, hi = float(x.lower()), float(x.upper())  # each rounds to nearest, which is monotone
            if lo == hi:
                break
            nearest = to_double(likely(dyadic(x.lower()), dyadic(x.upper())))
    return lo if lo == hi else nearest, (math.nextafter(lo, -math.inf), math.nextafter(hi, math.inf))


def _around(value: fmpq) -> tuple[float, tuple[float, float]]:
    t = to_double(value)
    if math.isinf(t):
        largest = math.copysign(sys.float_info.max, t)
        return t, (min(t, largest), max(t, largest))
    exact = fmpq(*t.as_integer_ratio())
    if exact == value:
        return t, (t, t)
    return t, ((t, math.nextafter(t, math.inf)) if exact < value else (math.nextafter(t, -math.inf), t))


class Instant(Protocol):
    """A time in the local clock of one piece; it compares with those of the same clock."""

    def compare(self, other: Self) -> int: ...
    def local(self) -> arb: ...
    def bounds(self) -> tuple[float, float]: ...
    def is_zero(self) -> bool: ...


def same_instant(x: Instant, y: Instant) -> bool:
    """Whether two instants are equal, or cannot be told apart at the present precision."""
    try:
        return x is y or x.compare(y) == 0
    except Undecidable:
        return bool(x.local().overlaps(y.local()))


class RationalInstant:
    """The time `value` (fmpq, or a ball) in the local clock."""

    __slots__ = ("value",)

    def __init__(self, value: fmpq | arb) -> None:
        self.value = value

    def compare(self, other: RationalInstant) -> int:
        """-1, 0, 1: before, at, after the other."""
        return sign(self.value - other.value)

    def local(self) -> arb:
        return ball(self.value)

    def bounds(self) -> tuple[float, float]:
        """Doubles around the time."""
        if type(self.value) is fmpq:
            t = to_double(self.value)
            return math.nextafter(t, -math.inf), math.nextafter(t, math.inf)
        with precision(PRECISIONS[0]):
            return ball_bounds(self.local())

    def is_zero(self) -> bool:
        return sign(self.value) == 0


class AngleInstant:
    """The time at which the turn has reached the angle with cosine X/R and sine sqrt(K) Y/R, in [0, 2 pi).

    X, Y, R > 0 are Surds over one radical.
    """

    __slots__ = ("K", "R", "X", "Y", "_ball", "_bounds", "_rational", "_settled")

    def __init__(  # noqa: N803
        self, X: Radical, Y: Radical, R: Radical, K: Scalar, bounds: tuple[float, float] | None = None
    ) -> None:
        """bounds: doubles around the angle, where they are known."""
        self.X, self.Y, self.R, self.K = surd(X), surd(Y), surd(R), K
        x, y = self.X, self.Y
        self._rational = arb not in (type(x.x), type(x.y), type(x.d), type(y.x), type(y.y), type(y.d))
        self._bounds = bounds
        self._settled = self._rational  # balls may be known better at another precision
        self._ball: tuple[int, arb] | None = None
        """Precision and value of the best enclosure so far, of rational ones."""

    def bounds(self) -> tuple[float, float]:
        """Doubles around the angle in radians."""
        if self._bounds is None or not self._settled:
            with precision(max(ctx.prec, PRECISIONS[0])):
                self._bounds = ball_bounds(self.local())
        return self._bounds

    def _half(self) -> int:
        s = self.Y.sign()
        return 0 if s > 0 or (s == 0 and self.X.sign() >= 0) else 1

    def is_zero(self) -> bool:
        if self._rational and self.bounds()[0] > 0.0:
            return False
        return self.Y.sign() == 0 and self.X.sign() >= 0

    def compare(self, other: AngleInstant) -> int:
        """-1, 0, 1: before, at, after the other, exactly: half turns first, then the sign of X1 Y2 - Y1 X2."""
        (lo, hi), (other_lo, other_hi) = self.bounds(), other.bounds()
        if hi < other_lo:
            return -1
        if lo > other_hi:
            return 1
        if not (self._rational and other._rational):
            return sign(self.local() - other.local())
        if self._half() != other._half():
            return self._half() - other._half()
        x1, y1, x2, y2 = self.X, self.Y, other.X, other.Y
        d1 = x1._d(y1)
        # X1 Y2 - Y1 X2 = P + Q sqrt(d2) with P, Q over sqrt(d1)
        p = Surd(x1.x * y2.x - y1.x * x2.x, x1.y * y2.x - y1.y * x2.x, d1)
        q = Surd(x1.x * y2.y - y1.x * x2.y, x1.y * y2.y - y1.y * x2.y, d1)
        return -sign_two_radicals(p, q, x2._d(y2))

    def local(self) -> arb:
        """The angle in radians, enclosed at the present precision or, where the numbers cancel, a higher one.

        Raises Undecidable for balls around the origin or the direction of angle 0.
        """
        if not self._rational:
            return _angle(self.X.ball(), self.Y.ball() * ball(self.K).sqrt())
        if self._ball is None or self._ball[0] < ctx.prec:
            self._ball = ctx.prec, self._enclosed()
        return self._ball[1]

    def _enclosed(self) -> arb:
        """`local` of a rational one."""
        bits, angle = ctx.prec, self._seen()
        if angle is None and self.Y.sign() == 0:
            return arb(0) if self.X.sign() >= 0 else arb.pi()
        while angle is None:  # Y is not zero: some precision shows its sign
            bits *= 2
            with precision(bits):
                angle = self._seen()
        return angle

    def _seen(self) -> arb | None:
        """`local` where the present precision shows the sign of Y."""
        y = self.Y.ball() * ball(self.K).sqrt()
        return _angle(self.X.ball(), y) if y > 0 or y < 0 else None

    def is_rational(self) -> bool:
        """Whether its numbers are rational or square roots of rationals, not balls."""
        return self._rational

    def quarter(self) -> int | None:
        """0 .. 3 when the angle is that many quarter turns exactly."""
        lo, hi = self.bounds()
        if math.floor(lo / QUARTER - 4e-15) == math.floor(hi / QUARTER + 4e-15):
            return None  # all whole numbers of quarters lie outside the bounds, by more than these divisions round
        x, y = self.X.sign(), self.Y.sign()
        return {(1, 0): 0, (0, 1): 1, (-1, 0): 2, (0, -1): 3}.get((x, y))

    def cosine_sine(self) -> tuple[Surd, Surd]:
        """(cos, sin / sqrt(K)) as Surds."""
        X, Y, R = (s.divisible() for s in (self.X, self.Y, self.R))  # noqa: N806
        n = R.x * R.x - R.y * R.y * R.d
        inverse = Surd(R.x / n, -R.y / n, R.d)
        return X * inverse, Y * inverse


def _angle(x: arb, y: arb) -> arb:
    """The angle of the vector (x, y) in [0, 2 pi)."""
    if y > 0:
        return arb.atan2(y, x)
    if y < 0:
        return arb.atan2(y, x) + 2 * arb.pi()
    if x < 0:  # y straddles zero about the angle pi: turn the vector by pi first
        return arb.atan2(-y, -x) + arb.pi()
    raise Undecidable


class LimitInstant:
    """A given angle: rational radians plus rational turns, such as the end of a motion.

    It equals no contact angle unless the radians are zero (Lindemann); two angles that agree to 2048 bits count as
    equal.
    """

    __slots__ = ("radians", "turns")

    def __init__(self, radians: fmpq, turns: fmpq) -> None:
        self.radians, self.turns = radians, turns

    def bounds(self) -> tuple[float, float]:
        with precision(PRECISIONS[0]):
            return ball_bounds(self.local())

    def local(self) -> arb:
        return arb(self.radians) + 2 * arb(self.turns) * arb.pi()

    def is_zero(self) -> bool:
        return self.radians == 0 and self.turns == 0

    def is_rational(self) -> bool:
        return False

    def compare(self, other: TurnInstant) -> int:
        return compare_angles(self, other)


TurnInstant = AngleInstant | LimitInstant
"""In the clock of a rotation."""


def compare_angles(x: TurnInstant, y: TurnInstant) -> int:
    """-1, 0, 1: x before, at, after y; any two instants of a rotation."""
    if not (isinstance(x, LimitInstant) or isinstance(y, LimitInstant)):
        return x.compare(y)
    if x.is_zero() or y.is_zero():
        return y.is_zero() - x.is_zero() if x.is_zero() != y.is_zero() else 0
    for bits in PRECISIONS:
        with precision(bits):
            gap = x.local() - y.local()
            if gap > 0:
                return 1
            if gap < 0:
                return -1
    return 0
