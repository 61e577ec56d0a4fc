"""A joint: what it lets its child do beside its parent."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

from flint import fmpq

from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import rational, to_double
from firstcontact.motion.product import Simple
from firstcontact.motion.rotation import Rotation, direction
from firstcontact.motion.screw import Screw, simple
from firstcontact.motion.translation import bounded, vector3

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from firstcontact.exact.numbers import Given

KINDS = "fixed", "revolute", "prismatic", "screw"
UNITS = {"deg": "degrees", "rad": "radians", "turn": "turns"}


class Mimic(NamedTuple):
    """A joint whose value is `ratio` times that of another one, and `offset`."""

    joint: str
    ratio: Any = 1
    offset: Any = 0


class Joint:
    """A joint from one link to another.

    kind: "fixed", "revolute" (turns about an axis), "prismatic" (shifts along it) or "screw" (turns and advances by
    `lead`, a length per full turn).
    parent, child: names of links; every link is the child of one joint at most.
    axis, point: a direction of any length and a point of the axis, in the world in which all values are 0.
    unit: of the value: "deg", "rad" or "turn" where the joint turns; a prismatic joint's value is a length.
    limits: (least, greatest) value, which a sweep goes through; a course may go beyond.
    mimic: Mimic("other", ratio, offset), or a tuple: this joint follows another one, as gears and racks do.

    >>> Joint("hinge", "revolute", "frame", "door", axis=(0, 0, 1), limits=(0, 110))
    <Joint 'hinge': revolute, from 'frame' to 'door'>
    """

    __slots__ = ("name", "kind", "parent", "child", "motion", "unit", "limits", "mimic")
    motion: Simple | None
    """By one unit of the value; None of a fixed one."""
    limits: tuple[fmpq, fmpq] | None
    mimic: Mimic | None

    def __init__(
        self,
        name: str,
        kind: str,
        parent: str,
        child: str,
        *,
        axis: Iterable[Given] = (0, 0, 1),
        point: Iterable[Given] = (0, 0, 0),
        unit: str | None = None,
        lead: Given = None,
        limits: Sequence[Given] | None = None,
        mimic: Sequence[Given] | str | None = None,
    ) -> None:
        if kind not in KINDS:
            raise InputError(f"joint {name!r}: kind {shown(kind)} is unknown; give one of {', '.join(KINDS)}")
        self.name, self.kind, self.parent, self.child = name, kind, parent, child
        self.unit = _unit(name, kind, unit)
        if (lead is None) == (kind == "screw"):
            raise InputError(f"joint {name!r}: lead is for screws, and each has one; give the length per full turn")
        self.motion = None if kind == "fixed" else _motion(self, axis, point, lead)
        self.limits = None if limits is None else _limits(name, limits)
        self.mimic = None if mimic is None else _mimic(name, mimic)

    def __repr__(self) -> str:
        return f"<Joint {self.name!r}: {self.kind}, from {self.parent!r} to {self.child!r}>"

    def __reduce__(self) -> tuple[Callable[..., Joint], tuple[object, ...]]:
        return _restored, tuple(getattr(self, key) for key in self.__slots__)


def _restored(*values: object) -> Joint:
    joint: Joint = object.__new__(Joint)
    for key, value in zip(Joint.__slots__, values, strict=True):
        setattr(joint, key, value)
    return joint


def _unit(name: str, kind: str, unit: str | None) -> str:
    if kind in ("fixed", "prismatic"):
        if unit not in (None, ""):
            raise InputError(f"joint {name!r}: the value of a {kind} joint is a length; leave unit out")
        return ""
    if unit is None:
        return "deg"
    if unit not in UNITS:
        raise InputError(f"joint {name!r}: unit {shown(unit)} is unknown; give one of {', '.join(UNITS)}")
    return unit


def _motion(joint: Joint, axis: Iterable[Given], point: Iterable[Given], lead: Given) -> Simple:
    line = direction(axis, f"joint {joint.name!r}: axis"), vector3(point, f"joint {joint.name!r}: point")
    if joint.kind == "prismatic":
        made: Simple = simple(Screw(*line, turns=0, advance=1))
        return made
    angle: dict[str, Any] = {UNITS[joint.unit]: 1}
    if joint.kind == "revolute":
        return Rotation(*line, **angle)
    per_turn = rational(lead, f"joint {joint.name!r}: lead")
    if joint.unit == "rad":
        raise InputError(f"joint {joint.name!r}: a screw's unit is \"deg\" or \"turn\"; its lead is per turn")
    made = simple(Screw(*line, **angle, advance=per_turn if joint.unit == "turn" else per_turn / 360))
    return made


def _limits(name: str, limits: Sequence[Given]) -> tuple[fmpq, fmpq]:
    try:
        lo, hi = limits
    except (TypeError, ValueError) as error:
        raise InputError(f"joint {name!r}: limits are {shown(limits)}; give (least, greatest)") from error
    least, greatest = rational(lo, f"joint {name!r}: limits[0]"), rational(hi, f"joint {name!r}: limits[1]")
    if not least < greatest:
        raise InputError(f"joint {name!r}: limits {to_double(least)}, {to_double(greatest)} do not ascend")
    return least, greatest


def _mimic(name: str, given: Any) -> Mimic:
    try:
        leader, *rest = (given,) if isinstance(given, str) else tuple(given)
        found = Mimic(leader, *rest)
    except (TypeError, ValueError) as error:
        raise InputError(f"joint {name!r}: mimic is {shown(given)}; give (joint, ratio, offset)") from error
    keys = zip(("ratio", "offset"), found[1:], strict=True)
    return Mimic(found.joint, *(bounded(x, f"joint {name!r}: mimic {key}") for key, x in keys))
