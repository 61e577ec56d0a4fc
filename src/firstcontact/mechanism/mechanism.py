"""The tree of links and joints."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from firstcontact.contact.table import as_body, kind_of
from firstcontact.errors import InputError, shown
from firstcontact.mechanism import tables
from firstcontact.mechanism.course import Course
from firstcontact.mechanism.joints import Joint
from firstcontact.mechanism.sweep import Sweep, swept
from firstcontact.motion.moving import Moving

if TYPE_CHECKING:
    from collections.abc import Sequence

    from firstcontact.body.kinds import AnyBody
    from firstcontact.exact.numbers import Given
    from firstcontact.mechanism.values import JointValues


class Mechanism:
    """Links of bodies, and the joints between them: a tree, or several, whose roots stand in the world.

    links: the bodies of each link, one or a list, placed in the world in which all joint values are 0.
    joints: see `Joint`; links that are no joint's child stand still.
    skip: pairs of links that are not asked about.

    >>> import firstcontact as fc
    >>> door = fc.Mechanism(
    ...     {"wall": fc.box((1, 4, 2)).translated((-2, 0, 0)), "door": fc.box((2, "1/5", 2)).translated((1, 0, 0))},
    ...     [fc.Joint("hinge", "revolute", "wall", "door", axis=(0, 0, 1), limits=(0, 180))],
    ... )
    >>> hit = door.course([0, 1], {"hinge": [0, 180]}).first_contacts()[0]
    >>> print(hit.joints[0])
    hinge = 135.646980363 deg
    """

    def __init__(
        self, links: Mapping[str, AnyBody | Sequence[AnyBody]], joints: Iterable[Joint], *,
        skip: Iterable[Iterable[str]] = (),
    ) -> None:  # fmt: skip
        if not isinstance(links, Mapping):
            raise InputError(f"links are {shown(links)}; give a dict of bodies by the names of their links")
        self.links = {name: _bodies(name, given) for name, given in links.items()}
        self.joints = {joint.name: joint for joint in _joints(joints)}
        self._above = self._parents()
        self.skip = frozenset(self._skipped(skip))
        for name in self.links:
            self.chain(name)
        self._check_mimics()

    def chain(self, link: str) -> list[Joint]:
        """The joints from the root to the link."""
        self._known(link, "chain")
        found: list[Joint] = []
        while link in self._above:
            joint = self._above[link]
            if joint in found:
                raise InputError(f"joint {joint.name!r} hangs on itself: the joints run in a ring; give a tree")
            found.append(joint)
            link = joint.parent
        return found[::-1]

    @cached_property
    def free(self) -> list[str]:
        """The names of the joints that take a value."""
        return [name for name, joint in self.joints.items() if joint.motion is not None and joint.mimic is None]

    def course(
        self, times: Iterable[Given], values: JointValues, *, interpolation: str = "linear",
        velocities: Mapping[str, Iterable[Given]] | None = None,
    ) -> Course:  # fmt: skip
        """The mechanism at work.

        times: ascending.  values: by the joints' names, one number that stays or one for each time (numbers, texts such
        as "1/3", a NumPy array); joints without any stay at 0.  interpolation: "linear", or "cubic" with `velocities`,
        without which it is the natural spline.
        """
        return Course(self, times, values, interpolation, velocities)

    def read_course(self, path: str | Path, *, interpolation: str = "linear") -> Course:
        """The course of a file: a table (CSV), arrays (NPZ) or a JointTrajectory of ROS (JSON), as the docs tell."""
        read = tables.read(path)
        velocities = read.velocities if interpolation == "cubic" else None
        try:
            return self.course(read.times, read.values, interpolation=interpolation, velocities=velocities)
        except InputError as error:
            raise InputError(f"{path}: {error}") from error

    def sweep(self, joint: str | None = None, *, at: JointValues | None = None) -> list[Sweep]:
        """The values of each joint, or of one, within its limits at which links share a point; others at `at`, or 0."""
        return swept(self, joint, at or {})

    def _known(self, link: str, who: str) -> None:
        if link not in self.links:
            raise InputError(f"{who}: no link {link!r}; the links are {', '.join(map(repr, self.links))}")

    def _skipped(self, skip: Iterable[Iterable[str]]) -> Iterator[frozenset[str]]:
        for k, pair in enumerate(skip):
            names = () if isinstance(pair, str) else tuple(pair)
            if len(set(names)) != 2 or len(names) != 2:
                raise InputError(f"skip[{k}] is {shown(pair)}; give the names of two links")
            for link in names:
                self._known(link, f"skip[{k}]")
            yield frozenset(names)

    def _parents(self) -> dict[str, Joint]:
        above: dict[str, Joint] = {}
        for joint in self.joints.values():
            for link in (joint.parent, joint.child):
                self._known(link, f"joint {joint.name!r}")
            if joint.child in above:
                other = above[joint.child].name
                raise InputError(f"link {joint.child!r} hangs on two joints, {other!r} and {joint.name!r}; give a tree")
            above[joint.child] = joint
        return above

    def _check_mimics(self) -> None:
        for joint in self.joints.values():
            if joint.mimic is None:
                continue
            leader = self.joints.get(joint.mimic.joint)
            if leader is None or leader.mimic is not None or leader.motion is None:
                raise InputError(f"joint {joint.name!r} mimics {joint.mimic.joint!r}; name a joint that takes a value")

    def __repr__(self) -> str:
        return f"<Mechanism: {len(self.links)} links, {len(self.joints)} joints>"


def _bodies(link: str, given: Any) -> list[Any]:
    bodies = [as_body(x) for x in (given if isinstance(given, list | tuple) else [given])]
    for k, body in enumerate(bodies):
        kind_of(body)
        if isinstance(body, Moving):
            raise InputError(f"link {link!r}: {body!r} moves; give a body at rest, the joints move it")
        if body.name is None:
            bodies[k] = body.named(link if len(bodies) == 1 else f"{link}.{k}")
    return bodies


def _joints(joints: Iterable[Joint]) -> list[Joint]:
    if not isinstance(joints, Iterable):
        raise InputError(f"joints are {shown(joints)}; give a list of Joints")
    found = list(joints)
    for k, joint in enumerate(found):
        if not isinstance(joint, Joint):
            raise InputError(f"joints[{k}] is {shown(joint)}; give a Joint")
        if any(other.name == joint.name for other in found[:k]):
            raise InputError(f"two joints are called {joint.name!r}; give each its own name")
    return found
