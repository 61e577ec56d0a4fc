"""Values of scene files: exact numbers, vectors, matrices, and tables that refuse unknown keys."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, StrictInt, StrictStr, model_validator

from firstcontact.errors import FirstContactError, InputError, shown
from firstcontact.exact.numbers import MOST_DIGITS

if TYPE_CHECKING:
    from firstcontact.body.placing import Placing
    from firstcontact.result import Json

# Digits "1/3", "-0.1", "2.5e-3".  The short exponent keeps a typing error from asking for gigabytes.
_EXACT = re.compile(r"[+-]?(\d+(\s*/\s*\d+)?|(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?)")


def parse_number(value: Json) -> float | int | Fraction:
    """A finite number: floats and integers as they are, strings exactly; ValueError says what is wrong."""
    number = _exact(value) if isinstance(value, str) else value
    if isinstance(number, bool) or not isinstance(number, int | float | Fraction):
        raise ValueError(f"{shown(value)} is not a number; write 0.5, or \"1/3\" for an exact one")
    try:
        finite = math.isfinite(float(number))
    except OverflowError:
        finite = False
    if not finite:
        raise ValueError(f"{shown(value)} is not a finite double; give a finite number")
    return number


def parse_time(value: Json) -> float | int | Fraction:
    """An end of a span: a number, or an infinity ("inf" and "-inf" too)."""
    if isinstance(value, float) and math.isinf(value):
        return value
    if isinstance(value, str) and re.fullmatch(r"[+-]?inf", value.strip()):
        return float(value)
    return parse_number(value)


def _exact(text: str) -> Fraction:
    text = text.strip()
    if len(text) > MOST_DIGITS:
        raise ValueError(f"{text!r} has {len(text)} letters; give a number of at most {MOST_DIGITS} digits")
    if not _EXACT.fullmatch(text):
        raise ValueError(f"{text!r} is not a number; write 0.5, \"1/3\" or \"0.1\"")
    try:
        return Fraction(re.sub(r"\s", "", text))
    except ZeroDivisionError as error:
        raise ValueError(f"{text!r} divides by zero; give a finite number") from error


def list_of(count: int, what: str) -> BeforeValidator:
    """Check a list's length first: pydantic would report every missing item by itself."""

    def check(value: Json) -> tuple[Json, ...]:
        if not isinstance(value, list) or len(value) != count:
            raise ValueError(f"{shown(value)} is not {what}")
        return tuple(value)

    return BeforeValidator(check)


def _matrix(value: Json) -> list[list[float | int | Fraction]]:
    """Four rows of four numbers."""
    if not isinstance(value, list) or len(value) != 4 or any(not isinstance(r, list) or len(r) != 4 for r in value):
        raise ValueError(f"{value!r} is not a 4x4 matrix; write four rows [a, b, c, d]")
    return [[parse_number(x) for x in row] for row in value]


def _pose(value: Json) -> list[float | int | Fraction] | list[list[float | int | Fraction]]:
    """A 4x4 matrix, or a vector whose rotation stands in quat_xyzw or quat_wxyz."""
    if isinstance(value, list) and len(value) == 3 and not any(isinstance(x, list) for x in value):
        return [parse_number(x) for x in value]
    try:
        return _matrix(value)
    except ValueError as error:
        raise ValueError(f"{error}, or a vector [x, y, z] with quat_xyzw or quat_wxyz") from error


def _face(value: Json) -> Json:
    """A ring of vertex numbers, or a list of such rings (the outer one, then its holes)."""
    rings = value if isinstance(value, list) and value and isinstance(value[0], list) else [value]
    for ring in rings:
        if not isinstance(ring, list) or not all(type(i) is int for i in ring):
            raise ValueError(f"{value!r} is not a face; write [0, 1, 2], or [[...], [...]] with holes")
    return value


def _range(value: Json) -> tuple[float | int | Fraction, ...] | None:
    """Two numbers, or None for "all"."""
    if value == "all":
        return None
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError(f"{value!r} is no range; write [lo, hi], or \"all\"")
    return tuple(parse_number(x) for x in value)


def _directrix(value: Json) -> Json:
    """A string in u and T, or a table of coefficients: numerators and denominator."""
    if isinstance(value, str):
        return value
    if not isinstance(value, dict) or "numerators" not in value or set(value) - {"numerators", "denominator"}:
        table = "{ numerators = [[...], [...], [...]], denominator = [...] }"
        raise ValueError(f"{value!r} is no curve; write \"(u, u**2, 0)\", or {table}")
    return {key: _numbers(x) for key, x in value.items()}


def _numbers(value: Any) -> Any:
    """Numbers in lists of any depth."""
    return [_numbers(x) for x in value] if isinstance(value, list) else parse_number(value)


Number = Annotated[Any, BeforeValidator(parse_number)]
Time = Annotated[Any, BeforeValidator(parse_time)]
Vector = Annotated[tuple[Number, Number, Number], list_of(3, "three numbers; write [x, y, z]")]
Pair = Annotated[tuple[StrictStr, StrictStr], list_of(2, "two body names; write [\"a\", \"b\"]")]
Span = Annotated[tuple[Time, Time], list_of(2, "two times; write [start, end]")]
Quaternion = Annotated[tuple[Number, Number, Number, Number], list_of(4, "four numbers; write [a, b, c, d]")]
Matrix = Annotated[Any, BeforeValidator(_matrix)]
Pose = Annotated[Any, BeforeValidator(_pose)]
Range = Annotated[Any, BeforeValidator(_range)]
Directrix = Annotated[Any, BeforeValidator(_directrix)]
Numbers = Annotated[Any, BeforeValidator(_numbers)]
Corners = Annotated[tuple[Vector, Vector], list_of(2, "two corners; write [[x0, y0, z0], [x1, y1, z1]]")]
Index = Annotated[StrictInt, Field(ge=0)]
Edge = Annotated[tuple[Index, Index], list_of(2, "two vertex numbers; write [i, j]")]
Face = Annotated[Any, BeforeValidator(_face)]


class Table(BaseModel):
    """A TOML table: unknown keys are refused with the known ones listed."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)  # built once, with the whole scene

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, table: Json) -> Json:
        if not isinstance(table, dict):
            raise ValueError(f"{table!r} is not a table; use one with keys {', '.join(cls.model_fields)}")
        for key in table:
            if key not in cls.model_fields:
                near = "".join(f", perhaps {name!r}" for name in get_close_matches(key, cls.model_fields, 1))
                raise ValueError(f"unknown key {key!r}{near}; keys here are {', '.join(cls.model_fields)}")
        return table


class RotateTable(Table):
    axis: Vector
    degrees: Number
    point: Vector = (0, 0, 0)


class Placed(Table):
    """What has a place: `scale` times as large, mapped by `transform`, then turned by `rotate` and shifted by `at`."""

    scale: Annotated[Number, Field(gt=0)] = 1
    at: Vector | None = None
    rotate: RotateTable | None = None
    transform: Matrix = None


S = TypeVar("S", bound="Placing")


def placed(body: S, table: Placed) -> S:
    """The body in its place."""
    if table.scale != 1:
        k = table.scale
        with at_key("scale"):
            body = body.transformed([[k, 0, 0, 0], [0, k, 0, 0], [0, 0, k, 0], [0, 0, 0, 1]])
    if table.transform is not None:
        with at_key("transform"):
            body = body.transformed(table.transform)
    if table.rotate is not None:
        with at_key("rotate"):
            turn = table.rotate
            body = body.rotated(turn.axis, degrees=turn.degrees, point=turn.point)
    if table.at is not None:
        with at_key("at"):
            body = body.translated(table.at)
    return body


class KeyFault(InputError):
    """A fault with the key of the scene file that it stands under."""

    def __init__(self, key: str, fault: str) -> None:
        super().__init__(f"{key}: {fault}")
        self.key, self.fault = key, fault


@contextmanager
def at_key(key: str) -> Iterator[None]:
    """Errors of the block as KeyFaults under this key; blocks within each other join their keys by dots."""
    try:
        yield
    except KeyFault as error:
        raise KeyFault(f"{key}.{error.key}", error.fault) from error
    except FirstContactError as error:
        raise KeyFault(key, str(error)) from error
