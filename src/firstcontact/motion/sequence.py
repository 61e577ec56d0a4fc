"""Steps executed one after the other."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Hashable, Iterable
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq

from firstcontact.errors import InputError
from firstcontact.exact.numbers import fraction, rational, to_double
from firstcontact.exact.vectors import Vector
from firstcontact.motion.placement import HERE, Placement, advanced
from firstcontact.motion.rational import RationalMotion
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw, simple
from firstcontact.motion.translation import LARGEST, Translation, double_of
from firstcontact.motion.value import Motion, numbers

if TYPE_CHECKING:
    from firstcontact.exact.numbers import Given
    from firstcontact.result import Table

Step = Translation | Rotation | Screw | RationalMotion
FEW = 4
"""Steps that `repr` lists."""


class Sequence(Motion):
    """Steps one after the other, each with axes and vectors fixed in the world.

    steps: Translation, Rotation, Screw or RationalMotion objects.  A step runs from its t = 0 to its t = 1 and is
    applied after (multiplied from the left to) the pose in which the step before it ended.  The first three start
    where that one ended; a RationalMotion does when its own pose at t = 0 is the identity, else the body jumps.
    durations: one positive number per step, default equal parts of 1.  The span is (0, sum of durations).

    >>> Sequence([Translation((1, 0, 0)), Translation((0, 2, 0))])(0.75)[:3, 3]
    array([1., 1., 0.])
    """

    __slots__ = ("steps", "ends", "_before")
    extends = False

    def __init__(self, steps: Iterable[Step], durations: Iterable[Given] | None = None) -> None:
        try:
            self.steps = tuple(steps)
            given = None if durations is None else tuple(durations)
        except TypeError as error:
            raise InputError(f"Sequence steps or durations are no lists ({error}); give [step, ...]") from error
        if not self.steps:
            raise InputError("Sequence has no steps; give at least one motion")
        for k, step in enumerate(self.steps):
            if not isinstance(step, Step):
                raise InputError(
                    f"Sequence step {k} is {step!r}; give a Translation, Rotation, Screw or RationalMotion"
                )
        if given is None:
            parts = [fmpq(1, len(self.steps))] * len(self.steps)
        else:
            parts = [rational(d, f"Sequence durations[{k}]") for k, d in enumerate(given)]
        if len(parts) != len(self.steps):
            raise InputError(f"Sequence has {len(self.steps)} steps but {len(parts)} durations")
        total = fmpq(0)
        self.ends: tuple[fmpq, ...] = ()
        for k, part in enumerate(parts):
            if part <= 0:
                raise InputError(f"Sequence durations[{k}] is {part}; give a positive number")
            if not fmpq(1) / LARGEST < part < LARGEST:
                raise InputError(f"Sequence durations[{k}] is {part}; give a number between 2^-150 and 2^150")
            total += part
            self.ends += (total,)
        self._before: tuple[Placement, ...] = ()

    @property
    def starts(self) -> tuple[fmpq, ...]:
        """When each step starts."""
        return fmpq(0), *self.ends[:-1]

    @property
    def exact_span(self) -> tuple[fmpq, fmpq]:
        return fmpq(0), self.ends[-1]

    @property
    def is_rigid(self) -> bool:
        return all(step.is_rigid for step in self.steps)

    @property
    def axes(self) -> tuple[Vector, ...] | None:
        own = [step.axes for step in self.steps]
        known = [axes for axes in own if axes is not None]
        return tuple(axis for axes in known for axis in axes) if len(known) == len(own) else None

    def is_across(self, normal: Vector) -> bool:
        return all(step.is_across(normal) for step in self.steps)

    @property
    def correction(self) -> float:
        """By how much an entry of a rounded pose is off the rotation that it stands for, at most, over all steps."""
        return max((step.correction for step in self.steps if isinstance(step, RationalMotion)), default=0.0)

    @property
    def jumps(self) -> tuple[fmpq, ...]:
        """When the body jumps: at starts of steps, but for the first, whose own pose at t = 0 is not the identity."""
        later = zip(self.steps[1:], self.ends, strict=False)
        return tuple(end for step, end in later if isinstance(step, RationalMotion) and not step.starts_here)

    def before(self, k: int) -> Placement:
        """The pose that step k is applied to: where the steps before it end."""
        if not self._before:
            reached = [HERE]
            for step in self.steps[:-1]:
                reached.append(advanced(reached[-1], simple(step), fmpq(1)))
            self._before = tuple(reached)
        return self._before[k]

    @property
    def span(self) -> tuple[float, float]:
        return 0.0, to_double(self.ends[-1])

    def __call__(self, t: float) -> np.ndarray:
        """The (4, 4) float64 pose at time t of the span; that after the jump where the body jumps then."""
        t = double_of(t)
        if not 0 <= t <= self.span[1]:
            raise InputError(f"time {t} is outside the span {self.span} of the Sequence")
        k = min(bisect_right([to_double(end) for end in self.ends], t), len(self.steps) - 1)
        start, end = self.starts[k], self.ends[k]
        local = (float(t) - to_double(start)) / to_double(end - start)
        pose: np.ndarray = self.steps[k](min(max(local, 0.0), 1.0)) @ self.before(k).doubles()
        return pose

    @property
    def durations(self) -> tuple[fmpq, ...]:
        """How long each step takes."""
        return tuple(end - start for start, end in zip(self.starts, self.ends, strict=True))

    def shifted(self, by: Vector) -> Sequence:
        """The same motion in a world shifted by a vector."""
        return Sequence([step.shifted(by) for step in self.steps], self.durations)

    def magnified(self, factor: fmpq) -> Sequence:
        """The same motion in a world whose lengths are so many times as long."""
        return Sequence([step.magnified(factor) for step in self.steps], self.durations)

    def _facts(self) -> tuple[Hashable, ...]:
        return self.steps, self.ends

    def _quick(self) -> Iterable[fmpq]:
        return (x for step in self.steps for x in step._quick())

    def _table(self) -> Table:
        steps = [step._table() for step in self.steps]
        return {"type": "sequence", "durations": numbers(self.durations), "steps": steps}

    def __repr__(self) -> str:
        if len(self.steps) > FEW:
            return f"<Sequence: {len(self.steps)} steps from 0 to {self.span[1]:g}>"
        return f"Sequence({list(self.steps)!r})"

    def __reduce__(self) -> tuple[object, ...]:
        return Sequence, (self.steps, tuple(map(fraction, self.durations)))
