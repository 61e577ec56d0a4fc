"""Tools in scene files: segments from the tip upwards."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, StrictStr

from firstcontact.errors import InputError
from firstcontact.scene.values import Number, Table, parse_number
from firstcontact.toolpath.tool import Tool

if TYPE_CHECKING:
    from fractions import Fraction

    from firstcontact.result import Json


def _diameter(value: Json) -> float | int | Fraction | tuple[float | int | Fraction, ...]:
    """A number, or two of a cone."""
    if not isinstance(value, list):
        return parse_number(value)
    if len(value) != 2:
        raise ValueError(f"{value!r} is no diameter; write a number, or [bottom, top]")
    return tuple(parse_number(x) for x in value)


class SegmentTable(Table):
    name: StrictStr
    kind: StrictStr
    diameter: Annotated[Any, BeforeValidator(_diameter)]
    length: Number


class ToolTable(Table):
    segments: list[SegmentTable]
    number: int | None = None

    def build(self, name: str) -> Tool:
        """The tool; `number` is that by which programs call it."""
        given = [(x.name, x.kind, x.diameter, x.length) for x in self.segments]
        if self.number is not None and self.number < 0:
            raise InputError(f"number is {self.number}; give that of the T word")
        return Tool(given, name, number=self.number)
