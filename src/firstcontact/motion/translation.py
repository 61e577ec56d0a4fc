"""Straight motion at constant velocity."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq

from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import rational, to_double
from firstcontact.exact.rigid import turned
from firstcontact.exact.vectors import Vector, dot, scaled
from firstcontact.motion.value import Motion, numbers

if TYPE_CHECKING:
    from firstcontact.exact.numbers import Given
    from firstcontact.exact.rigid import Matrix
    from firstcontact.result import Table

SPAN = (0.0, 1.0)

# Largest number of a motion: with coordinates below the same bound nothing overflows.
LARGEST = fmpq(2) ** 150
NOWHERE = fmpq(0), fmpq(0), fmpq(0)


def vector3(values: Iterable[Given], what: str) -> tuple[fmpq, fmpq, fmpq]:
    """Three exact numbers; InputError names `what`."""
    try:
        x, y, z = values
    except (TypeError, ValueError) as error:
        raise InputError(f"{what} is {shown(values)}; give three numbers") from error
    return bounded(x, what, 0), bounded(y, what, 1), bounded(z, what, 2)


def bounded(x: Given, what: str, place: int | None = None) -> fmpq:
    """The exact number, which lies below LARGEST; InputError names `what`, or its entry at that place."""
    if isinstance(x, float):
        x = float(x)  # NumPy's own are slow
        if -(2.0**150) < x < 2.0**150:
            return fmpq(*x.as_integer_ratio())
    named = what if place is None else f"{what}[{place}]"
    value = rational(x, named)
    if abs(value) >= LARGEST:
        raise InputError(f"{named} is {shown(x)}; give a number below 2^150")
    return value


def double_of(t: float) -> float:
    """A time as a finite double, or InputError."""
    time = to_double(rational(t, "time"))
    if not math.isfinite(time):
        raise InputError(f"time is {shown(t)}; give one that is a finite double")
    return time


class Translation(Motion):
    """Motion by ``t * vector``: over the default span (0, 1) the body moves by ``vector``.

    vector: three finite numbers (doubles are the exact binary rationals they are; "1/3", Fraction exact).
    The motion goes on at constant speed beyond (0, 1), to infinity too, when the query's span asks for it.

    >>> Translation((1, 0, 0))(0.25)[:3, 3]
    array([0.25, 0.  , 0.  ])
    """

    __slots__ = ("vector",)
    span = SPAN
    extends = True
    is_one_step = True

    def __init__(self, vector: Iterable[Given]) -> None:
        self.vector = vector3(vector, "Translation vector")

    def __call__(self, t: float) -> np.ndarray:
        """The (4, 4) float64 pose at time t."""
        pose, time = np.eye(4), double_of(t)
        pose[:3, 3] = [time * to_double(x) for x in self.vector]
        return pose

    @property
    def rests(self) -> bool:
        return not any(self.vector)

    @property
    def is_rational(self) -> bool:
        return True

    @property
    def axes(self) -> tuple[Vector, ...]:
        return ()

    @property
    def generators(self) -> tuple[tuple[Vector, Vector], ...]:
        return ((NOWHERE, self.vector),)

    def is_across(self, normal: Vector) -> bool:
        across: bool = dot(self.vector, normal) == 0
        return across

    def paced(self, share: fmpq) -> Translation:
        """The motion that goes so many times as far in the same time."""
        return Translation(scaled(share, self.vector))

    def carried(self, by: Matrix) -> Translation:
        """The same motion in a world that was turned and shifted by a rational map."""
        return Translation(turned(by, self.vector))

    def shifted(self, by: Vector) -> Translation:
        """The same motion in a world shifted by a vector."""
        return self

    def magnified(self, factor: fmpq) -> Translation:
        """The same motion in a world whose lengths are so many times as long."""
        return Translation(scaled(factor, self.vector))

    def _facts(self) -> tuple[Hashable, ...]:
        return self.vector

    def _quick(self) -> Iterable[fmpq]:
        return self.vector

    def _table(self) -> Table:
        return {"type": "translation", "vector": numbers(self.vector)}

    def __repr__(self) -> str:
        return "Translation(({}, {}, {}))".format(*map(to_double, self.vector))

    def __reduce__(self) -> tuple[object, ...]:
        from firstcontact.exact.numbers import fraction

        return Translation, (tuple(map(fraction, self.vector)),)
