"""What the text of a STEP file tells before anything is made of it: whether it is one, whole, and refers to what is
there."""

from __future__ import annotations

import re
from pathlib import Path

from firstcontact.errors import InputError

_DEFINED = re.compile(rb"(?:^|[;\s])#(\d+)\s*=\s*(\(|[A-Z_0-9]+)")
_USED = re.compile(rb"#(\d+)")
_STRINGS = re.compile(rb"'(?:[^']|'')*'")
_COMMENTS = re.compile(rb"/\*.*?\*/", re.S)


def checked(path: Path) -> dict[int, str]:
    """The kind of each entity of the file by its number.  InputError where the text is no whole STEP file."""
    try:
        text = path.read_bytes()
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(f"{path}: {reason}; give the path of a STEP file (.stp, .step)") from error
    if b"ISO-10303-21" not in text[:2000]:
        raise InputError(f"{path}: no STEP file (it does not begin with ISO-10303-21;); export the model as STEP")
    bare = _STRINGS.sub(b"''", _COMMENTS.sub(b" ", text))
    data = bare.find(b"DATA;")
    kinds = {int(number): kind.decode() for number, kind in _DEFINED.findall(bare, max(data, 0))}
    if b"END-ISO-10303-21" not in bare:
        last = f"in or after entity #{list(kinds)[-1]}" if kinds else "before any entity"
        raise InputError(f"{path}: the file ends {last}, without END-ISO-10303-21; it was cut off: export it again")
    for number in _USED.findall(bare, max(data, 0)):
        if int(number) not in kinds:
            raise InputError(f"{path}: {_user(bare, data, number)}refers to #{int(number)}, which is not in the file; "
                             "export it again")  # fmt: skip
    return kinds


def _user(bare: bytes, data: int, number: bytes) -> str:
    """The first entity that refers to the number."""
    for entity in bare[max(data, 0) :].split(b";"):
        head = _DEFINED.search(b";" + entity)
        if head and re.search(rb"#" + number + rb"(?!\d)", entity.split(b"=", 1)[1]):
            kind = head[2].decode().strip("(")
            return f"entity #{int(head[1])}{' (' + kind + ')' if kind else ''} "
    return "an entity "
