"""A mechanism at work: its bodies as they move, and what they meet."""

from __future__ import annotations

import itertools
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from flint import fmpq

from firstcontact import query
from firstcontact.contact.table import as_body, kind_of
from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import exact_value
from firstcontact.mechanism.values import followed, known, polynomials, read_times
from firstcontact.motion.linkage import Drive, Linkage
from firstcontact.motion.product import Value
from firstcontact.result import ContactIntervals, FirstContact

if TYPE_CHECKING:
    from typing import Unpack

    from firstcontact.body.kinds import Body, Shape
    from firstcontact.exact.numbers import Given
    from firstcontact.mechanism.mechanism import Mechanism
    from firstcontact.mechanism.values import JointValues
    from firstcontact.work import Arguments, FirstArguments


class Course:
    """Joint values over one clock; `bodies` are the mechanism's as they move, for every verb of the library."""

    def __init__(
        self, mechanism: Mechanism, times: Iterable[Given], values: JointValues, interpolation: str = "linear",
        velocities: Mapping[str, Iterable[Given]] | None = None,
    ) -> None:  # fmt: skip
        self.mechanism = mechanism
        self.times: tuple[fmpq, ...] = read_times(times)
        known(mechanism.free, values, "values")
        known(mechanism.free, velocities or {}, "velocities")
        if velocities and interpolation == "linear":
            raise InputError('velocities are for interpolation="cubic"; "linear" takes none')
        given = {
            name: polynomials(name, self.times, values.get(name, 0), interpolation, (velocities or {}).get(name))
            for name in mechanism.free
        }
        self._drives = {name: drive for name in mechanism.joints if (drive := self._drive(name, given)) is not None}
        self._motions = {link: self._motion(link) for link in mechanism.links}

    def during(self, begin: int, end: int) -> Course:
        """The same course from one waypoint to another, which are counted from 0."""
        part: Course = object.__new__(type(self))
        part.mechanism, part.times = self.mechanism, self.times[begin : end + 1]
        part._drives = {name: drive.during(begin, end) for name, drive in self._drives.items()}
        part._motions = {link: part._motion(link) for link in self.mechanism.links}
        return part

    def _drive(self, name: str, given: dict[str, tuple[Value, ...]]) -> Drive | None:
        joint = self.mechanism.joints[name]
        if joint.motion is None:
            return None
        mimic = joint.mimic
        values = given[name] if mimic is None else followed(given[mimic.joint], mimic.ratio, mimic.offset)
        return Drive(name, joint.unit, joint.motion, values, limits=joint.limits, mimic=mimic)

    def _chain(self, link: str) -> list[str]:
        """The joints from the root to the link that are not fixed."""
        return [joint.name for joint in self.mechanism.chain(link) if joint.name in self._drives]

    def _motion(self, link: str) -> Linkage | None:
        drives = [self._drives[name] for name in self._chain(link)]
        return Linkage(self.times, drives) if drives else None

    def motion(self, link: str) -> Linkage | None:
        """How a link moves; None where it stands still."""
        return self._motions[link]

    @property
    def bodies(self) -> dict[str, list[Body]]:
        """The bodies of each link as they move."""
        return {link: [self._moving(body, link) for body in own] for link, own in self.mechanism.links.items()}

    def _moving(self, body: Shape, link: str) -> Body:
        motion = self._motions[link]
        return body if motion is None else body.moving(motion)

    def pairs(self, against: Iterable[Body] = (), *, moving: bool = False) -> Iterator[tuple[Body, Body]]:
        """All pairs of bodies, as they move, of links with a joint between that is not fixed; moving: that moves.

        against: other bodies, each of which is paired with all that moves beside it.
        """
        against = _others(against)
        bodies = self.bodies
        for x, y in itertools.combinations(self.mechanism.links, 2):
            between = set(self._chain(x)) ^ set(self._chain(y))
            if moving:
                between = {name for name in between if any(len(value) > 1 for value in self._drives[name].values)}
            if between and frozenset((x, y)) not in self.mechanism.skip:
                yield from itertools.product(bodies[x], bodies[y])
        for link, other in itertools.product(bodies, against):
            if self._motions[link] is not None or hasattr(other, "motion"):
                yield from ((body, other) for body in bodies[link])

    def first_contacts(self, against: Iterable[Body] = (), **arguments: Unpack[FirstArguments]) -> list[FirstContact]:
        """The first contact of each pair, with the values of the joints; arguments as of `first_contact`."""
        return [query.first_contact(a, b, **arguments) for a, b in self.pairs(against)]

    def contact_intervals(self, against: Iterable[Body] = (), **arguments: Unpack[Arguments]) -> list[ContactIntervals]:
        """All times of contact of each pair; arguments as of `contact_intervals`."""
        return [query.contact_intervals(a, b, **arguments) for a, b in self.pairs(against)]

    def stretch(self, time: float) -> int:
        """Between which given times a time lies: that many of them, less one, are not after it."""
        return max(0, min(bisect_right(self.times, exact_value(time)), len(self.times) - 1) - 1)

    def __repr__(self) -> str:
        return f"<Course of {len(self._drives)} joints at {len(self.times)} times>"


def _others(against: Iterable[Body]) -> list[Body]:
    """Bodies beside a mechanism.  InputError for what is none."""
    if isinstance(against, str | Mapping) or not hasattr(against, "__iter__"):
        raise InputError(f"against is {shown(against)}; give a list of bodies")
    others = [as_body(x) for x in against]
    for other in others:
        kind_of(other)
    return others
