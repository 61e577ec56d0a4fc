"""Exact times of contact under rational motions: roots of polynomials in the time."""

from __future__ import annotations

from flint import arb, ctx, fmpq

from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import PRECISIONS, ball, ball_bounds, precision


class RootInstant:
    """The time `root`, in a local clock that starts at `origin`."""

    __slots__ = ("_bounds", "origin", "root")

    def __init__(self, root: AlgebraicRoot, origin: fmpq) -> None:
        self.root, self.origin = root, origin
        self._bounds: tuple[float, float] | None = None

    @classmethod
    def at(cls, time: fmpq, origin: fmpq) -> RootInstant:
        """A rational time."""
        return cls(AlgebraicRoot.of(time), origin)

    def compare(self, other: RootInstant) -> int:
        """-1, 0, 1: before, at, after the other, exactly."""
        (lo, hi), (other_lo, other_hi) = self.bounds(), other.bounds()
        if hi < other_lo:
            return -1
        return 1 if other_hi < lo else self.root.compare(other.root)

    def local(self) -> arb:
        return ball(self.root.enclosure(ctx.prec)) - self.origin

    def bounds(self) -> tuple[float, float]:
        """Doubles around the local time."""
        if self._bounds is None:
            with precision(PRECISIONS[0]):
                self._bounds = ball_bounds(self.local())
        return self._bounds

    def is_zero(self) -> bool:
        return self.root.compare(self.origin) == 0
