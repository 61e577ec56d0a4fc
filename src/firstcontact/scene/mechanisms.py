"""Mechanisms in scene files: links of bodies, joints, and their values over the time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import StrictStr

from firstcontact.errors import InputError
from firstcontact.mechanism.course import Course
from firstcontact.mechanism.joints import Joint
from firstcontact.mechanism.mechanism import Mechanism
from firstcontact.scene.values import Number, Numbers, Table, Vector, at_key, list_of

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

Limits = Annotated[tuple[Number, Number], list_of(2, "two values; write [least, greatest]")]


class MimicTable(Table):
    joint: StrictStr
    ratio: Number = 1
    offset: Number = 0


class JointTable(Table):
    type: Literal["fixed", "revolute", "prismatic", "screw"]
    parent: StrictStr
    child: StrictStr
    axis: Vector = (0, 0, 1)
    point: Vector = (0, 0, 0)
    unit: Literal["deg", "rad", "turn"] | None = None
    lead: Number = None
    limits: Limits | None = None
    mimic: MimicTable | None = None

    def build(self, name: str) -> Joint:
        keys = ("parent", "child", "axis", "point", "unit", "lead", "limits")
        mimic = None if self.mimic is None else (self.mimic.joint, self.mimic.ratio, self.mimic.offset)
        return Joint(name, self.type, **{key: getattr(self, key) for key in keys}, mimic=mimic)


class LinkTable(Table):
    bodies: list[StrictStr]


class CourseTable(Table):
    """Times and values, or a table file of both."""

    times: list[Number] | None = None
    values: dict[str, Numbers] = {}
    velocities: dict[str, list[Number]] | None = None
    file: StrictStr | None = None
    interpolation: Literal["linear", "cubic"] = "linear"

    def build(self, mechanism: Mechanism, folder: Path) -> Course:
        if (self.times is None) == (self.file is None):
            raise InputError("give times with values, or a file (CSV)")
        if self.times is not None:
            return mechanism.course(
                self.times, self.values, interpolation=self.interpolation, velocities=self.velocities
            )
        if self.values or self.velocities:
            raise InputError("values and velocities do not go with a file; leave them out")
        assert self.file is not None
        return mechanism.read_course(folder / self.file, interpolation=self.interpolation)


class Linked:
    """The mechanism of a scene.  Links are those of tables, and each body that a joint names itself."""

    def __init__(
        self, joints: Mapping[str, JointTable], links: Mapping[str, LinkTable], bodies: Mapping[str, Body]
    ) -> None:
        self.keys: dict[str, tuple[str, ...]] = {}
        for name, table in links.items():
            with at_key(f"link.{name}.bodies"):
                self._add(name, table.bodies, bodies)
        for name, joint in joints.items():
            for key in ("parent", "child"):
                with at_key(f"joint.{name}.{key}"):
                    link = getattr(joint, key)
                    if link not in self.keys:
                        self._add(link, [link], bodies)
        built = []
        for name, joint in joints.items():
            with at_key(f"joint.{name}"):
                built.append(joint.build(name))
        with at_key("joint"):
            self.mechanism = Mechanism({name: [bodies[key] for key in keys] for name, keys in self.keys.items()}, built)

    def _add(self, link: str, keys: list[str], bodies: Mapping[str, Body]) -> None:
        for key in keys:
            if key not in bodies:
                raise InputError(f"no body {key!r}; the bodies are {', '.join(map(repr, bodies))}")
            other = next((name for name, taken in self.keys.items() if key in taken), None)
            if other is not None:
                raise InputError(f"body {key!r} is part of link {other!r} already; name that link")
        self.keys[link] = tuple(keys)

    def moving(self, course: Course) -> dict[str, Body]:
        """The bodies of all links as they move, by their keys."""
        moving = course.bodies
        pairs = ((key, body) for link, keys in self.keys.items() for key, body in zip(keys, moving[link], strict=True))
        return dict(pairs)

    def are_one(self, a: str, b: str) -> bool:
        """Whether two bodies are parts of one link."""
        return any(a in keys and b in keys for keys in self.keys.values())
