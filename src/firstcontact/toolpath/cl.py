"""APT / CL data, in three axes and in five: GOTO and GODLTA, RAPID, FROM, UNITS, MULTAX.

Words that move nothing (`STILL`) are passed over; anything else stops with its line and word.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from flint import fmpq

from firstcontact.exact.vectors import Vector, add
from firstcontact.toolpath.blocks import INCH, Block, Fault, lines_of, number
from firstcontact.toolpath.moves import UP, StraightMove, Stretch, Swing, is_half_turn

STILL = {
    "MACHIN", "LOADTL", "LOAD", "TOOLNO", "TURRET", "SPINDL", "FEDRAT", "COOLNT", "CUTTER", "CUTCOM",
    "INTOL", "OUTTOL", "DELAY", "STOP", "OPSTOP", "END", "FINI", "PREFUN", "AUXFUN",
    "CLEARP", "SEQNO", "LEADER", "DISPLY", "MODE", "PAINT",
}  # fmt: skip
TEXTS = {"PARTNO", "PPRINT", "TPRINT", "REMARK"}
"""Words that a text follows, after a blank or a stroke; it ends with its line."""
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:E[-+]?\d{1,3})?")


def read_cl(path: Path, start: Vector | None = None, unit: str = "mm") -> Iterator[Block]:
    """The blocks of a program that move the tool; arguments as of `read_gcode`."""
    inch = fmpq(1) if unit in ("in", "inch") else INCH
    per_unit = fmpq(1)
    at, axis = start, UP
    rapid = five = ended = False
    tool: int | None = None
    for line, statement in _statements(path):
        if _is_text(statement):
            continue
        word, _, rest = statement.partition("/")
        word, rest = word.strip().upper(), rest.strip().upper()
        if word in ("GOTO", "GODLTA", "FROM"):
            if ended:
                raise Fault(path, line, word, "after FINI, where the program ends; give what follows as one of its own")
            numbers = [per_unit * x if k < 3 else x for k, x in enumerate(_numbers(path, line, word, rest))]
            if len(numbers) not in ((3,) if word == "GODLTA" else (3, 6)):
                wanted = "x, y, z" if word == "GODLTA" else "x, y, z, or x, y, z, i, j, k"
                raise Fault(path, line, word, f"{len(numbers)} numbers; give {wanted}")
            before, old = at, axis
            at = _vector(numbers[:3])
            if word == "GODLTA":
                at = None if before is None else add(before, at)
            if len(numbers) == 6:
                axis = _vector(numbers[3:])
                if not any(axis):
                    raise Fault(path, line, word, "the tool axis is zero; give a direction")
                if not five and not _is_up(axis):
                    raise Fault(path, line, word, "a tool axis that is not +z without MULTAX; add MULTAX before")
            if word == "FROM":
                continue
            kind, rapid = "rapid" if rapid else "feed", False
            if before is None or at is None:
                yield Block(line, statement, (), tool, "it begins where the program does not tell")
                continue
            if is_half_turn(old, axis):
                raise Fault(path, line, word, "the tool axis turns by half a turn, either way round; give one between")
            ways = _way(kind, before, at, old, axis)
            yield Block(line, statement, ways, tool)
        elif word == "RAPID":
            rapid = True
        elif word == "MULTAX":
            five = rest != "OFF"
        elif word == "UNITS":
            if rest not in ("MM", "INCH", "INCHES"):
                raise Fault(path, line, f"UNITS/{rest}", "not read; give MM or INCH")
            per_unit = inch / INCH if rest == "MM" else inch
        elif word in STILL or word == "CYCLE" and rest == "OFF":
            ended = ended or word == "FINI"
            if word in ("LOADTL", "TOOLNO"):
                digits = re.match(r"\d+", rest)
                tool = int(digits[0]) if digits else tool
        else:
            raise Fault(path, line, word.split()[0] if word else "/", "not read; see docs/toolpaths.md")


def _statements(path: Path) -> Iterator[tuple[int, str]]:
    """(line, statement): `$` at the end goes on in the next line, `$$` begins a comment."""
    first, held = 0, ""
    for line, text in lines_of(path):
        plain = text.partition("$$")[0].strip()
        first = first or line
        if plain.endswith("$") and (held or not _is_text(plain)):
            held += plain[:-1].strip()
            continue
        statement, number_of = held + plain, first
        first, held = 0, ""
        if statement and not statement.startswith("%"):
            yield number_of, statement
    if held:
        yield first, held


def _is_text(statement: str) -> bool:
    return re.split(r"[\s/]", statement, maxsplit=1)[0].upper() in TEXTS


def _numbers(path: Path, line: int, word: str, rest: str) -> list[fmpq]:
    def fault(told: str, what: str) -> Fault:
        return Fault(path, line, word, f"{told}: {what}")

    made = []
    for text in (x.strip() for x in rest.split(",")):
        if not NUMBER.fullmatch(text):
            raise Fault(path, line, word, f"{text!r} is no number; give x, y, z")
        made.append(number(text, fault))
    return made


def _vector(numbers: list[fmpq]) -> Vector:
    x, y, z = numbers
    return x, y, z


def _is_up(axis: Vector) -> bool:
    return axis[0] == axis[1] == 0 and axis[2] > 0


def _way(kind: str, begin: Vector, end: Vector, old: Vector, axis: Vector) -> tuple[Stretch, ...]:
    if _is_up(old) and _is_up(axis):
        if kind == "rapid" and begin[:2] == end[:2] and end[2] > begin[2]:
            kind = "back"
        return (StraightMove(kind, begin, end),) if begin != end else ()
    return (Swing(kind, begin, end, old, axis),) if begin != end or old != axis else ()
