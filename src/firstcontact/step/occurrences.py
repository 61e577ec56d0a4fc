"""Parts in the assemblies of a STEP file: each has a place there."""

from __future__ import annotations

import re
from pathlib import Path

from firstcontact.errors import InputError
from firstcontact.step.written.words import REPRESENTATION, USED

_RELATING = re.compile(
    rb"#(\d+)\s*=\s*(NEXT_ASSEMBLY_USAGE_OCCURRENCE|PRODUCT_DEFINITION_SHAPE|CONTEXT_DEPENDENT_SHAPE_REPRESENTATION|"
    rb"SHAPE_DEFINITION_REPRESENTATION)\s*\(([^;]*);"
)
"""Entities that tell which part is used where; the last entity that a shape refers to is what it is of."""


def check_places(path: Path, data: bytes) -> None:
    """InputError where a part with a shape is used in an assembly without a place there: OpenCASCADE leaves it out."""
    entities = {int(x[1]): (x[2], [int(y) for y in USED.findall(x[3])]) for x in _RELATING.finditer(data)}
    uses = {k: ids for k, (kind, ids) in entities.items() if kind == b"NEXT_ASSEMBLY_USAGE_OCCURRENCE" and len(ids) > 1}
    shapes = {k: ids[-1] for k, (kind, ids) in entities.items() if kind == b"PRODUCT_DEFINITION_SHAPE" and ids}
    shown: dict[int, set[int]] = {}  # definitions, and what represents them
    placed: set[int] = set()
    for kind, ids in entities.values():
        if kind == b"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION":
            placed.update(shapes[x] for x in ids if x in shapes)
        elif kind == b"SHAPE_DEFINITION_REPRESENTATION" and ids and ids[0] in shapes:
            shown.setdefault(shapes[ids[0]], set()).update(ids[1:])
    parents = {ids[0] for ids in uses.values()}
    for number, (parent, child, *_) in uses.items():
        if number in placed or not (child in shown or child in parents) or _maps(data, shown.get(parent, set())):
            continue
        raise InputError(f"{path}: entity #{number} (NEXT_ASSEMBLY_USAGE_OCCURRENCE) uses a part without telling where "
                         "it is (no CONTEXT_DEPENDENT_SHAPE_REPRESENTATION); export the assembly again")  # fmt: skip


def _maps(data: bytes, representations: set[int]) -> bool:
    """Whether one of them holds a part by a MAPPED_ITEM, which tells where it is."""
    items = {int(x) for x in re.findall(rb"#(\d+)\s*=\s*MAPPED_ITEM\b", data)}
    held = REPRESENTATION.finditer(data) if items else ()
    return any(int(x[1]) in representations and items & set(map(int, USED.findall(x[2]))) for x in held)
