"""Rationals and balls: how numbers of users become exact, and how exact ones become doubles.

Two kinds of numbers flow through the exact faces of the pair files: ``fmpq`` (always decidable) and ``arb``
balls (poses that no rational number describes).  `sign` is the only place that tells them apart.
"""

from __future__ import annotations

import math
import re
import sys
import threading
from collections.abc import Iterable
from decimal import Decimal
from fractions import Fraction
from numbers import Real
from typing import TYPE_CHECKING, TypeAlias

from flint import arb, ctx, fmpq, fmpz

from firstcontact.errors import InputError, shown

if TYPE_CHECKING:
    import numpy as np

    from firstcontact.exact.ring import Ordered, Rational

# Exponents that would ask for gigabytes of digits.
_ENDLESS = re.compile(r"[eE][+-]?0*[1-9]\d{4}")
# Digits of a number as users give it: more than any measurement has, and as many as Python reads and prints (4300).
MOST_DIGITS = 4000
# How likely by chance a fraction as short may lie in an interval that is told by it.
CHANCE = fmpq(1, 1000)
# Precisions (bits) tried in turn where balls have to decide a sign; behind the last one: Undecidable.
PRECISIONS = (128, 256, 512, 1024, 2048)


# A number as users give it, and what stands in files instead of one.
Given: TypeAlias = "float | Fraction | Decimal | fmpz | fmpq | str | np.floating | np.integer | None"
# Numbers in rows, in arrays, or deeper.
Nested: TypeAlias = "Iterable[Given | Nested]"


class Undecidable(Exception):
    """A ball still contains zero at this precision; the caller raises it or answers UNDECIDED."""


def sign(x: Ordered) -> int:
    """Sign of an fmpq (always) or of an arb ball (Undecidable when it straddles zero)."""
    if type(x) is arb:
        if x > 0:
            return 1
        if x < 0:
            return -1
        if x.is_zero():
            return 0
        raise Undecidable
    if type(x) is fmpq:
        x = x.p  # whole numbers compare in a tenth of the time
    return (x > 0) - (x < 0)


def rational(x: Given, what: str) -> fmpq:
    """The exact value of a double, int, Fraction, Decimal, fmpq or of a string such as "1/3" or "0.1".

    `what` names the argument in the InputError for anything else, NaN and infinities included.
    """
    if isinstance(x, float):
        if not math.isfinite(x):
            raise InputError(f"{what} is {x}; give a finite number")
        return fmpq(*x.as_integer_ratio())
    if isinstance(x, fmpq):
        return x
    if isinstance(x, int | fmpz):
        if int(x).bit_length() > MOST_DIGITS * math.log2(10):
            raise InputError(f"{what} is a whole number of more than {MOST_DIGITS} digits; give fewer")
        return fmpq(int(x))
    if isinstance(x, Fraction):
        return fmpq(x.numerator, x.denominator)
    if isinstance(x, Decimal):
        x = str(x)
    if hasattr(x, "as_integer_ratio"):  # NumPy's other floats
        if not math.isfinite(x):  # type: ignore[arg-type]  # no text has a ratio
            raise InputError(f"{what} is {x}; give a finite number")
        return fmpq(*map(int, x.as_integer_ratio()))  # type: ignore[union-attr]  # nor has None
    if isinstance(x, str):
        if _ENDLESS.search(x):
            raise InputError(f"{what} is {x!r}; give an exponent below 10000")
        if len(x) > MOST_DIGITS:
            raise InputError(f"{what} is a text of {len(x)} letters; give a number of at most {MOST_DIGITS} digits")
        try:
            f = Fraction(x)
        except (ValueError, ZeroDivisionError) as error:
            raise InputError(f"{what} is {x!r}; give a number such as 0.5, '1/3' or '0.1'") from error
        return fmpq(f.numerator, f.denominator)
    try:
        return rational(x.item(), what)  # type: ignore[union-attr]  # NumPy scalars
    except (AttributeError, TypeError, ValueError) as error:
        raise InputError(f"{what} is {shown(x)}; give a number") from error


def positive_double(x: object, what: str, kind: str = "number") -> float:
    """A positive number whose double is positive and finite too, as that double."""
    if type(x) is float and 0.0 < x < math.inf:
        return x
    try:
        value = float(x) if isinstance(x, Real) else math.nan
    except OverflowError:
        value = math.inf
    if not 0 < value < math.inf:
        raise InputError(f"{what} is {shown(x)}; give a positive {kind}, neither 0 nor infinite in doubles")
    return value


def exact_value(x: float) -> fmpq:
    """The rational number that a finite double is."""
    return fmpq(*float(x).as_integer_ratio())


def fraction(x: fmpq) -> Fraction:
    return Fraction(int(x.p), int(x.q))


def to_double(x: fmpq) -> float:
    """The double nearest x (ties to even), infinite beyond the largest."""
    if not x:
        return 0.0
    near = arb(x)
    if near.is_exact():  # whatever the precision; most numbers come from doubles
        return float(near)
    try:
        return int(x.p) / int(x.q)  # Python's integer division rounds correctly
    except OverflowError:
        return math.inf if x > 0 else -math.inf


def below(x: fmpq) -> float:
    """The largest double <= x, -inf below the least.

    >>> below(fmpq(1, 2)), below(fmpq(1, 10)) < 0.1, below(-(fmpq(10) ** 400)), above(-(fmpq(10) ** 400))
    (0.5, True, -inf, -1.7976931348623157e+308)
    """
    near = to_double(x)
    if math.isinf(near):
        return sys.float_info.max if x > 0 else near
    return near if fmpq(*near.as_integer_ratio()) <= x else math.nextafter(near, -math.inf)


def above(x: fmpq) -> float:
    """The least double >= x."""
    return 0.0 - below(-x)  # never -0.0


def simplest(lo: fmpq, hi: fmpq) -> fmpq:
    """The fraction of least denominator in the closed [lo, hi].

    >>> simplest(fmpq(33, 100), fmpq(34, 100)), simplest(fmpq(-1, 2), fmpq(1, 8))
    (1/3, 0)
    """
    whole = fmpq(lo.ceil())
    if whole <= hi:
        return fmpq(0) if lo <= 0 <= hi else whole
    below = whole - 1
    return below + 1 / simplest(1 / (hi - below), 1 / (lo - below))


def simplest_in(ball: arb) -> fmpq:
    """The fraction of least denominator in a finite ball."""
    return simplest(dyadic(arb(ball.lower())), dyadic(arb(ball.upper())))


def likely(lo: fmpq, hi: fmpq) -> fmpq:
    """What stands for a number that is known to be in [lo, hi]: a fraction so short that no chance puts it there.

    The middle where there is none.  Of times of degenerate scenes the fraction is the truth.

    >>> likely(fmpq(1, 4) - fmpq(1, 10**13), fmpq(1, 4) + fmpq(2, 10**13)), likely(fmpq(33, 100), fmpq(34, 100))
    (1/4, 67/200)
    """
    short = simplest(lo, hi)
    return short if (hi - lo) * short.q**2 < CHANCE else (lo + hi) / 2


def ball(x: Rational | arb) -> arb:
    """An enclosure of x at the present precision."""
    return x if isinstance(x, arb) else arb(x)


def ball_bounds(x: arb) -> tuple[float, float]:
    """Doubles lo <= x <= hi, at most one step wider than the ball."""
    return (
        math.nextafter(float(x.lower()), -math.inf),
        math.nextafter(float(x.upper()), math.inf),
    )


def nearest_double(x: arb) -> float | None:
    """The double nearest every point of the ball, or None when the ball is too wide to tell."""
    lo, hi = float(x.lower()), float(x.upper())  # each rounds to nearest, which is monotone
    return lo if lo == hi else None


def dyadic(x: arb) -> fmpq:
    """The exact value of an arb of radius zero."""
    mantissa, exponent = x.man_exp()
    e = int(exponent)
    return fmpq(mantissa) * (fmpq(2) ** e if e >= 0 else 1 / (fmpq(2) ** -e))


# FLINT keeps one working precision for the whole process; whoever computes with balls holds this lock.
_lock = threading.RLock()


class precision:  # noqa: N801 - reads as `with precision(256):`
    """Context: work with balls of that many bits, one thread at a time."""

    __slots__ = ("before", "bits")

    def __init__(self, bits: int) -> None:
        self.bits = bits

    def __enter__(self) -> None:
        _lock.acquire()
        self.before = ctx.prec
        ctx.prec = self.bits

    def __exit__(self, *exception: object) -> None:
        ctx.prec = self.before
        _lock.release()
