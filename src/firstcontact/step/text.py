"""What the text of a STEP file tells before anything is made of it: whether it is one, whole, and refers to what is
there."""

from __future__ import annotations

import re
from pathlib import Path

from firstcontact.errors import InputError

_DEFINED = re.compile(rb"(?:^|[;\s])#(\d+)\s*=\s*(\(|[A-Z_0-9]+)")
_USED = re.compile(rb"#(\d+)")
_HIDDEN = re.compile(rb"'(?:[^']|'')*'|/\*.*?\*/", re.S)
_BEYOND = rb"\d*\.?\d*[ED]\+?0*(?:[1-9]\d{3,}|[4-9]\d\d|3[1-9]\d|30[89])"  # of the range of doubles
_NO_NUMBER = re.compile(rb"[(,]\s*([-+]?(?:NAN|INF(?:INITY)?|1\.#\w+|" + _BEYOND + rb"))\s*(?=[,)])", re.I)
_NO_FACES = re.compile(rb"#(\d+)\s*=\s*(CLOSED_SHELL|OPEN_SHELL)\s*\([^;()]*\(\s*\)\s*\)")


def checked(path: Path) -> dict[int, str]:
    """The kind of each entity of the file by its number.  InputError where the text is no whole STEP file."""
    try:
        text = path.read_bytes()
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(f"{path}: {reason}; give the path of a STEP file (.stp, .step)") from error
    if b"ISO-10303-21" not in text[:2000]:
        raise InputError(f"{path}: no STEP file (it does not begin with ISO-10303-21;); export the model as STEP")
    bare = bared(text)
    data = bare.find(b"DATA;")
    kinds = {int(number): kind.decode() for number, kind in _DEFINED.findall(bare, max(data, 0))}
    if b"END-ISO-10303-21" not in bare:
        last = f"in or after entity #{list(kinds)[-1]}" if kinds else "before any entity"
        raise InputError(f"{path}: the file ends {last}, without END-ISO-10303-21; it was cut off: export it again")
    _check_values(path, bare[max(data, 0) :])
    for number in _USED.findall(bare, max(data, 0)):
        if int(number) not in kinds:
            raise InputError(f"{path}: {_user(bare, data, number)}refers to #{int(number)}, which is not in the file; "
                             "export it again")  # fmt: skip
    return kinds


def bared(text: bytes) -> bytes:
    """The text with blanks for all that strings and comments hold: all else stands where it stood."""
    return _HIDDEN.sub(lambda found: b" " * len(found[0]), text)


def _check_values(path: Path, data: bytes) -> None:
    """InputError where a number is none, which OpenCASCADE reads as 0, or no double, or a shell has no faces, which it
    leaves out."""
    empty, wrong = _NO_FACES.search(data), _NO_NUMBER.search(data)
    if empty:
        raise InputError(f"{path}: entity #{int(empty[1])} ({empty[2].decode()}) has no faces; export the model again")
    if wrong:
        number, kind = _DEFINED.findall(data, 0, wrong.start())[-1]
        told = f"entity #{int(number)} ({kind.decode().strip('(')})"
        raise InputError(f"{path}: {told} has {wrong[1].decode()} where a number belongs; export the model again")


def _user(bare: bytes, data: int, number: bytes) -> str:
    """The first entity that refers to the number."""
    for entity in bare[max(data, 0) :].split(b";"):
        head = _DEFINED.search(b";" + entity)
        if head and re.search(rb"#" + number + rb"(?!\d)", entity.split(b"=", 1)[1]):
            kind = head[2].decode().strip("(")
            return f"entity #{int(head[1])}{' (' + kind + ')' if kind else ''} "
    return "an entity "
