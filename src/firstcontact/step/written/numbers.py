"""Numbers in the text of a STEP file: OpenCASCADE reads something else for what is none, and tells nobody."""

from __future__ import annotations

import math
import re
from pathlib import Path

from firstcontact.errors import InputError
from firstcontact.motion.translation import LARGEST
from firstcontact.step.written.words import DEFINED

_REAL = rb"\s*[-+]?(?:\d+\.\d*(?:E[-+]?\d+)?|\.\d+(?:E[-+]?\d+)?|\d+)\s*"
_NUMBER = re.compile(_REAL, re.I)
_BEYOND = rb"\s*[-+]?[\d.]+E\+?0*(?:[1-9]\d{3,}|[4-9]\d\d|3[1-9]\d|30[89])\s*(?=[,)])"  # of the range of doubles
_LIKE_A_NUMBER = re.compile(
    rb"[(,](" + _BEYOND + rb"|(?!" + _REAL + rb"[,)])\s*(?:[-+.]*\d|[-+]\s*[,)]|[-+]?(?:NAN|INF(?:INITY)?)\b)[^,()]*)",
    re.I,
)
"""What begins as a number and is none, or no double, or has the name of none."""
_POINT = re.compile(rb"\b(?:CARTESIAN_POINT|DIRECTION)\s*\([^();]*(?:\(([^();]*)\))?")
_SIZES = {
    b"CIRCLE": 1, b"ELLIPSE": 2, b"HYPERBOLA": 2, b"PARABOLA": 1, b"VECTOR": 1, b"CYLINDRICAL_SURFACE": 1,
    b"CONICAL_SURFACE": 2, b"SPHERICAL_SURFACE": 1, b"TOROIDAL_SURFACE": 2, b"DEGENERATE_TOROIDAL_SURFACE": 2,
}  # fmt: skip
"""How many numbers the arguments of an entity have, after a name and an entity."""
_SIZED = re.compile(rb"\b(" + b"|".join(_SIZES) + rb")\s*\(([^();]*)\)")
_MEASURE = re.compile(rb"\b(?:[A-Z_]*(?:LENGTH|ANGLE|RATIO)_MEASURE|PARAMETER_VALUE)\s*\(([^();]*)\)")
_LARGEST = float(LARGEST)
MOST_SHOWN = 40
"""Letters of what is no number."""


def check_numbers(path: Path, data: bytes, text: bytes) -> None:
    """InputError where OpenCASCADE would read 0, or something else, for what is no number, or leave out what has
    numbers of a size that it takes for none.  text: what `data` is with its strings."""
    odd = _LIKE_A_NUMBER.search(data)
    wrong = min((x for x in (odd and odd.span(1), _no_point(data), _no_size(data)) if x), default=None)
    if wrong:
        at, end = wrong
        number, kind = DEFINED.findall(data, 0, at)[-1]
        given = " ".join(text[at:end].decode(errors="replace").split()) or "nothing"
        given = "".join(c if c.isprintable() else "?" for c in given[:MOST_SHOWN]) + "..." * (len(given) > MOST_SHOWN)
        wanted = "a number (as 10. or 1.E1)"
        if _NUMBER.fullmatch(data[at:end]):
            wanted = "a number below 2^150"
        elif b"," in data[at:end]:
            wanted = "at most three numbers"
        who = f"{path}: entity #{int(number)} ({kind.decode().strip('(')})"
        raise InputError(f"{who} has {given} in the place of {wanted}; export the model again")


Wrong = tuple[int, int]
"""Where what is no number begins and ends."""


def _no_point(data: bytes) -> Wrong | None:
    """Of the coordinates of points and directions, two or three of which there are."""
    for found in _POINT.finditer(data):
        if found[1] is None:
            return found.end(), found.end()
        if (wrong := _first_wrong(found.start(1), found[1])) is not None:
            return wrong
        if found[1].count(b",") > 2:
            return found.span(1)
    return None


def _no_size(data: bytes) -> Wrong | None:
    """Of radii, angles and the like, and of measures, as those of units."""
    for found in _SIZED.finditer(data):
        arguments = found[2].split(b",", 2)
        numbers = arguments[2].split(b",")[: _SIZES[found[1]]] if len(arguments) == 3 else [b""]
        at = found.start(2) + sum(len(x) + 1 for x in arguments[:2])
        if (wrong := _first_wrong(at, b",".join(numbers))) is not None:
            return wrong
    for found in _MEASURE.finditer(data):
        if (wrong := _first_wrong(found.start(1), found[1], math.inf)) is not None:
            return wrong
    return None


def _first_wrong(at: int, numbers: bytes, bound: float = _LARGEST) -> Wrong | None:
    """Where the first of them is none, or too large; at: where they begin."""
    for x in numbers.split(b","):
        if not _NUMBER.fullmatch(x) or abs(float(x)) >= bound:
            return at, at + len(x)
        at += len(x) + 1
    return None
