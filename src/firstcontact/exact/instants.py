"""Exact times of contact, in the local clock of one piece of the motion.

`RationalInstant` under translation, `AngleInstant` under rotation.  Both compare exactly, enclose themselves by
balls at any precision, and know their time in the world.  In irrational poses their numbers are balls; then
comparing may raise Undecidable.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from flint import arb, fmpq

from firstcontact.exact.numbers import PRECISIONS, ball, ball_bounds, nearest_double, precision, sign, to_double


def enclose(number: Callable[[], Any]) -> tuple[float, tuple[float, float]]:
    """(nearest double, (lo, hi) doubles around it) of a number given at the present precision.

    The precision rises until the double is certain; a number that lies exactly between two doubles, or is known
    as a ball only, ends with the best there is.
    """
    value = number()
    if isinstance(value, fmpq):
        t = to_double(value)
        exact = fmpq(*t.as_integer_ratio())
        if exact == value:
            return t, (t, t)
        return t, ((t, math.nextafter(t, math.inf)) if exact < value else (math.nextafter(t, -math.inf), t))
    for bits in PRECISIONS:
        with precision(bits):
            x = ball(number())
            t = nearest_double(x)
        if t is not None:
            break
    lo, hi = ball_bounds(x)
    return float(x.mid()) if t is None else t, (lo, hi)


class RationalInstant:
    """The time `value` (fmpq, or a ball) in the local clock."""

    __slots__ = ("value",)

    def __init__(self, value: Any) -> None:
        self.value = value

    def compare(self, other: RationalInstant) -> int:
        """-1, 0, 1: before, at, after the other."""
        return sign(self.value - other.value)

    def local(self) -> arb:
        return ball(self.value)

    def is_zero(self) -> bool:
        return sign(self.value) == 0

    def is_exact(self) -> bool:
        return isinstance(self.value, fmpq)
