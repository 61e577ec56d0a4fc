"""A tool: cylinders and cones one above the other along its axis."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import hypot
from typing import TYPE_CHECKING, Any

from flint import fmpq

from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.primitives import frustum
from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import rational, to_double

if TYPE_CHECKING:
    from firstcontact.exact.numbers import Given

KINDS = "cutter", "holder"


@dataclass(frozen=True)
class Segment:
    """A cylinder or cone from height `low` to `high` above the tip, with the radii `bottom` and `top`, exact.

    kind: "cutter" or "holder".
    """

    name: str
    kind: str
    low: fmpq
    high: fmpq
    bottom: fmpq
    top: fmpq

    @cached_property
    def solid(self) -> CompositeQuadric:
        """The segment with the tool's tip at the origin, its axis +z."""
        made = frustum(self.bottom, self.top, self.high - self.low, name=self.name)
        return made.translated((0, 0, self.low)) if self.low else made

    @property
    def doubles(self) -> tuple[float, float, float, float]:
        """(low, bottom, high, top)."""
        low, bottom, high, top = (to_double(x) for x in (self.low, self.bottom, self.high, self.top))
        return low, bottom, high, top

    @property
    def reach(self) -> float:
        """How far from the tip a point of it is at most."""
        low, bottom, high, top = self.doubles
        return max(hypot(low, bottom), hypot(high, top)) * (1.0 + 1e-15)


class Tool:
    """A stack of cylinders and cones; its tip is at the origin and its axis is +z.

    segments: from the tip upwards, each (name, kind, diameter, length): kind is "cutter" or "holder", diameter a number
    or (bottom, top) of a cone; lengths are in the unit of the bodies that it is asked about.  Numbers are exact, as
    those of bodies are ("1/3", 0.5, Fraction).  number: by which programs call it (T1), where there are several.

    >>> Tool([("flutes", "cutter", 6, 20), ("collet", "holder", (20, 30), 40)])
    <Tool: flutes (cutter), collet (holder); 60.0 long>
    """

    def __init__(
        self, segments: Iterable[Sequence[Given | Sequence[Given]]], name: str | None = None, *,
        number: int | None = None,
    ) -> None:  # fmt: skip
        self.name, self.number = name, number
        who = name or "tool"
        made: list[Segment] = []
        for k, given in enumerate(segments):
            made.append(_segment(given, made[-1].high if made else fmpq(0), f"{who}: segments[{k}]"))
            if [x.name for x in made].count(made[-1].name) > 1:
                raise InputError(f"{who}: two segments are called {made[-1].name!r}; give each its own name")
        if not made:
            raise InputError(f"{who}: no segments; give (name, kind, diameter, length), from the tip upwards")
        self.segments = tuple(made)

    def __repr__(self) -> str:
        told = ", ".join(f"{x.name} ({x.kind})" for x in self.segments)
        return f"<Tool{f' {self.name}' if self.name else ''}: {told}; {to_double(self.segments[-1].high)} long>"

    @property
    def solids(self) -> list[CompositeQuadric]:
        """The segments as solids, for every verb."""
        return [segment.solid for segment in self.segments]


def _segment(given: Sequence[Any], low: fmpq, who: str) -> Segment:
    if isinstance(given, str) or not hasattr(given, "__len__") or len(given) != 4:
        raise InputError(f"{who} is {shown(given)}; give (name, kind, diameter, length)")
    name, kind, diameter, length = given
    if not isinstance(name, str) or not name:
        raise InputError(f"{who}: its name is {shown(name)}; give a text")
    if not isinstance(kind, str) or kind not in KINDS:
        raise InputError(f"{who} ({name}): kind {shown(kind)} is unknown; give one of {', '.join(KINDS)}")
    pair = diameter if isinstance(diameter, tuple | list) else (diameter, diameter)
    if len(pair) != 2:
        raise InputError(f"{who} ({name}): diameter is {shown(diameter)}; give a number, or (bottom, top)")
    bottom, top = (rational(x, f"{who} ({name}): diameter") / 2 for x in pair)
    height = rational(length, f"{who} ({name}): length")
    if min(bottom, top) < 0 or max(bottom, top) == 0 or height <= 0:
        raise InputError(f"{who} ({name}): diameters have to be positive (one of a cone may be 0), lengths too")
    return Segment(name, kind, low, low + height, bottom, top)
