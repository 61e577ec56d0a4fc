"""What bodies, motions and results wrote of themselves by `to_dict` and `to_json`, read again."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import TypeAdapter, ValidationError

from firstcontact.errors import InputError, shown
from firstcontact.result import SCHEMA
from firstcontact.scene import answers, load

if TYPE_CHECKING:
    from firstcontact.result import Json

KINDS: dict[str, Any] = {
    "shape": load.Body,
    "type": load.Motion,
    "branches": answers.IntersectionCurveTable,
    "intervals": answers.IntervalsTable,
    "pairs": answers.PairsTable,
    "status": answers.FirstTable,
}
"""What is read, by a key that no kind before it has."""


def from_dict(data: Mapping[str, Json]) -> Any:
    """The body, motion or result of a dictionary that `to_dict` wrote; bodies and motions also of a scene's table.

    Raises InputError that names what it does not know: a key, a kind of body or motion, another schema.

    >>> from_dict({"shape": "cylinder", "radius": "1/3", "height": 2})
    <CompositeQuadric: 3 faces, 2 edges, 0 vertices>
    >>> from_dict({"type": "translation", "vector": [0, 0, 1]})
    Translation((0.0, 0.0, 1.0))
    """
    if not isinstance(data, dict):
        raise InputError(f"{shown(data)} is no dictionary; give what to_dict() wrote")
    if data.get("schema", SCHEMA) != SCHEMA:
        raise InputError(f"schema {shown(data['schema'])} is unknown; this version reads schema {SCHEMA}")
    table = {key: value for key, value in data.items() if key != "schema"}
    kind = next((kind for key, kind in KINDS.items() if key in table), None)
    if kind is None:
        raise InputError(
            f"no kind among the keys {', '.join(map(str, table)) or '(none)'}; a body has shape, a motion type, a "
            "result status, pairs or branches"
        )
    try:
        read = _adapter(kind).validate_python(table)
        return load.build_body(read, None, Path()) if kind is load.Body else read.build()
    except ValidationError as error:
        raise InputError(load.first_fault(error, table)) from error
    except RecursionError as error:
        raise InputError("the tables are nested too deeply; give flatter ones") from error


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)
