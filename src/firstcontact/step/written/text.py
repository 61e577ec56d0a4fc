"""What the text of a STEP file tells before anything is made of it: whether it is one, whole, and refers to what is
there."""

from __future__ import annotations

import re
from pathlib import Path

from firstcontact.errors import InputError
from firstcontact.step.occurrences import check_places
from firstcontact.step.written.numbers import check_numbers
from firstcontact.step.written.words import DEFINED, REPRESENTATION, USED

_NO_FACES = re.compile(rb"#(\d+)\s*=\s*(CLOSED_SHELL|OPEN_SHELL)\s*\([^;()]*\(\s*\)\s*\)")
_HIDDEN = re.compile(rb"'(?:[^']|'')*'|/\*.*?\*/", re.S)


class Entities(dict[int, str]):
    """The kind of each entity of a file by its number; `shown`: what shapes are represented by."""

    shown: frozenset[int] = frozenset()


def checked(path: Path) -> Entities:
    """The entities of the file.  InputError where the text is no whole STEP file."""
    try:
        text = path.read_bytes()
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(f"{path}: {reason}; give the path of a STEP file (.stp, .step)") from error
    if b"ISO-10303-21" not in text[:2000]:
        raise InputError(f"{path}: no STEP file (it does not begin with ISO-10303-21;); export the model as STEP")
    bare = bared(text)
    data = bare.find(b"DATA;")
    kinds = Entities((int(number), kind.decode()) for number, kind in DEFINED.findall(bare, max(data, 0)))
    if b"END-ISO-10303-21" not in bare:
        last = f"in or after entity #{list(kinds)[-1]}" if kinds else "before any entity"
        raise InputError(f"{path}: the file ends {last}, without END-ISO-10303-21; it was cut off: export it again")
    if empty := _NO_FACES.search(bare, max(data, 0)):  # OpenCASCADE leaves it out
        raise InputError(f"{path}: entity #{int(empty[1])} ({empty[2].decode()}) has no faces; export the model again")
    check_numbers(path, bare[max(data, 0) :], text[max(data, 0) :])
    check_places(path, bare[max(data, 0) :])
    for number in USED.findall(bare, max(data, 0)):
        if int(number) not in kinds:
            raise InputError(f"{path}: {_user(bare, data, number)}refers to #{int(number)}, which is not in the file; "
                             "export it again")  # fmt: skip
    kinds.shown = frozenset(int(x) for found in REPRESENTATION.finditer(bare) for x in USED.findall(found[2]))
    return kinds


def bared(text: bytes) -> bytes:
    """The text with blanks for all that strings and comments hold: all else stands where it stood."""
    return _HIDDEN.sub(lambda found: b" " * len(found[0]), text)


def _user(bare: bytes, data: int, number: bytes) -> str:
    """The first entity that refers to the number."""
    for entity in bare[max(data, 0) :].split(b";"):
        head = DEFINED.search(b";" + entity)
        if head and re.search(rb"#" + number + rb"(?!\d)", entity.split(b"=", 1)[1]):
            kind = head[2].decode().strip("(")
            return f"entity #{int(head[1])}{' (' + kind + ')' if kind else ''} "
    return "an entity "
