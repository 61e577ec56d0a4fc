"""Each joint driven over its limits, the others at rest: the clock is the joint's own value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from firstcontact import query
from firstcontact.errors import InputError
from firstcontact.exact.numbers import to_double
from firstcontact.mechanism.course import Course
from firstcontact.mechanism.values import known
from firstcontact.result import ContactIntervals

if TYPE_CHECKING:

    from firstcontact.mechanism.mechanism import Mechanism
    from firstcontact.mechanism.values import JointValues
    from firstcontact.result import Json


@dataclass(frozen=True)
class Sweep:
    """What one joint meets within its limits: for each pair of bodies the values at which they share a point.

    found: `ContactIntervals` whose times are the joint's values, in its unit.
    """

    joint: str
    unit: str
    limits: tuple[float, float]
    found: tuple[ContactIntervals, ...]

    def __str__(self) -> str:
        lo, hi = self.limits
        unit = f" {self.unit}" if self.unit else ""
        lines = [f"{self.joint} over [{lo:g}, {hi:g}]{unit}"]
        for pair in self.found:
            lines += [f"  {line}" for line in str(pair).splitlines()]
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Json]:
        """The joint, and the answers by pair; exact numbers are strings."""
        pairs = [pair.to_dict() for pair in self.found]
        return {"joint": self.joint, "unit": self.unit, "limits": list(self.limits), "pairs": pairs}


def swept(mechanism: Mechanism, joint: str | None, at: JointValues) -> list[Sweep]:
    """The sweeps of all joints with limits, or of one."""
    known(mechanism.free, at, "at")
    if joint is not None and joint in at:
        raise InputError(f"joint {joint!r} is driven through its limits; leave it out of at")
    return [sweep_of(mechanism, name, at) for name in swept_joints(mechanism, joint)]


def swept_joints(mechanism: Mechanism, joint: str | None) -> list[str]:
    """The joints to drive."""
    if joint is not None:
        if joint not in mechanism.free:
            names = ", ".join(map(repr, mechanism.free)) or "none"
            raise InputError(f"no joint {joint!r} takes a value; {names} do")
        if mechanism.joints[joint].limits is None:
            raise InputError(f"joint {joint!r} has no limits; give it limits=(least, greatest)")
        return [joint]
    found = [name for name in mechanism.free if mechanism.joints[name].limits is not None]
    if not found:
        raise InputError("no joint has limits; give one limits = [least, greatest]")
    return found


def course_over(mechanism: Mechanism, joint: str, at: JointValues) -> Course:
    """The mechanism while the value of one joint goes through its limits: the time is that value."""
    limits = mechanism.joints[joint].limits
    assert limits is not None
    return Course(mechanism, limits, {**at, joint: limits})


def sweep_of(mechanism: Mechanism, joint: str, at: JointValues) -> Sweep:
    """The sweep of one joint."""
    course = course_over(mechanism, joint, at)
    found = tuple(query.contact_intervals(a, b) for a, b in course.pairs(moving=True))
    first, last = map(to_double, course.times)
    return Sweep(joint, mechanism.joints[joint].unit, (first, last), found)
