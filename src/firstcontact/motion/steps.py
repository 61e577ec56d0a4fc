"""A motion as steps in time, each with the pose that the body has before it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from flint import fmpq

from firstcontact.motion.linkage import Linkage
from firstcontact.motion.placement import HERE, Placement, advanced
from firstcontact.motion.screw import simple
from firstcontact.motion.sequence import Sequence
from firstcontact.motion.trajectory import Trajectory
from firstcontact.motion.translation import Translation

if TYPE_CHECKING:
    from firstcontact.motion.kinds import AnyMotion

REST = Translation((0, 0, 0))


class Step(NamedTuple):
    """Over [start, end] it makes all of `motion`, after the pose `before`; end None: it goes on, beyond 0 and 1.

    clock: (origin, unit) of the motion's own time where it is not that from start to end.
    """

    start: fmpq
    end: fmpq | None
    motion: Any
    before: Placement
    clock: tuple[fmpq, fmpq] | None = None

    @property
    def origin(self) -> fmpq:
        """When the motion's own time is zero: the body stands in `before` then."""
        return self.start if self.clock is None else self.clock[0]

    @property
    def unit(self) -> fmpq:
        """The unit of the motion's own time."""
        if self.clock is not None:
            return self.clock[1]
        return fmpq(1) if self.end is None else self.end - self.start

    def covers(self, first: fmpq, last: fmpq) -> bool:
        """Whether the step is in charge of all of [first, last]."""
        return self.end is None or (self.start <= first and last <= self.end)

    def share(self, time: fmpq) -> fmpq:
        """The motion's own time then."""
        if self.clock is None and self.end is None:
            return time - self.start
        return (time - self.origin) / self.unit

    def pose(self, time: fmpq) -> Placement:
        """Where the body stands at that time of the step."""
        return self.before if self.motion is REST else advanced(self.before, self.motion, self.share(time))


RESTING = Step(fmpq(0), None, REST, HERE)


def steps_of(motion: AnyMotion) -> Iterator[Step]:
    """The steps in order of time."""
    if isinstance(motion, Linkage):
        yield from (Step(*part) for part in motion.parts())
        return
    if not isinstance(motion, Sequence | Trajectory):
        yield Step(fmpq(0), None, simple(motion), HERE)
        return
    for k, (part, start, end) in enumerate(zip(motion.steps, motion.starts, motion.ends, strict=True)):
        yield Step(start, end, simple(part), motion.before(k))
