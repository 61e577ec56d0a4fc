"""A product of simple motions within one step of time: links of a mechanism, each joint driven at its own pace."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from flint import fmpq, fmpq_poly

from firstcontact.exact.numbers import rational
from firstcontact.exact.vectors import Vector
from firstcontact.motion.rotation import Rotation, turns_of
from firstcontact.motion.screw import Screw
from firstcontact.motion.translation import SPAN, Translation, double_of
from firstcontact.motion.value import Motion, numbers

if TYPE_CHECKING:
    from firstcontact.result import Table

Simple = Translation | Rotation | Screw
Value = tuple[fmpq, ...]
"""A polynomial: its coefficients, ascending."""


class JointFactor(NamedTuple):
    """What a joint does: `motion` at its own time `value`, a polynomial of the step's time of degree 3 at most."""

    motion: Simple
    value: Value

    def at(self, time: fmpq) -> fmpq:
        """The value then."""
        value: fmpq = at(self.value, time)
        return value

    def within(self, begin: fmpq, share: fmpq) -> Value:
        """The value as a polynomial of s, at the time begin + share s."""
        return tuple(fmpq_poly(list(self.value))(fmpq_poly([begin, share])).coeffs())


class Product(Motion):
    """The motions of the factors multiplied, from the root outward: the last one moves the body first.

    Axes, points and vectors are those of the world in which all values are 0.
    """

    __slots__ = ("factors",)
    span = SPAN
    extends = False

    def __init__(self, factors: Iterable[JointFactor]) -> None:
        self.factors = tuple(factors)

    def __call__(self, t: float) -> np.ndarray:
        """The (4, 4) float64 pose at time t, rounded once."""
        from firstcontact.motion.placement import HERE, advanced  # it knows all motions

        return advanced(HERE, self, rational(double_of(t), "time")).doubles()

    @property
    def turns(self) -> fmpq:
        """About how many full turns the body makes, none too few."""
        return sum((way(f.value) * turns_of(f.motion) for f in self.factors), fmpq(0))

    def shifted(self, by: Vector) -> Product:
        """The same motion in a world shifted by a vector."""
        return Product(JointFactor(f.motion.shifted(by), f.value) for f in self.factors)

    def magnified(self, factor: fmpq) -> Product:
        """The same motion in a world whose lengths are so many times as long."""
        return Product(JointFactor(f.motion.magnified(factor), f.value) for f in self.factors)

    def _facts(self) -> tuple[Hashable, ...]:
        return self.factors

    def _quick(self) -> Iterable[fmpq]:
        return (x for f in self.factors for x in f.value)

    def _table(self) -> Table:
        factors = [{"motion": f.motion._table(), "value": numbers(f.value)} for f in self.factors]
        return {"type": "product", "factors": factors}

    def __repr__(self) -> str:
        return f"<Product of {len(self.factors)} motions>"


def at(value: Value, time: Any) -> Any:
    """The polynomial at an exact time, a ball or a power series, by Horner's rule."""
    total = 0 * time
    for c in reversed(value):
        total = total * time + c
    return total


def way(value: Value) -> fmpq:
    """How far the polynomial goes from 0 to 1, back and forth, at most."""
    return sum((k * abs(c) for k, c in enumerate(value)), fmpq(0))
