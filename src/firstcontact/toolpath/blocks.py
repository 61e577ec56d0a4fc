"""What readers of programs tell: blocks with their ways, and faults with line and word."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from flint import fmpq

from firstcontact.errors import InputError
from firstcontact.exact.numbers import MOST_DIGITS
from firstcontact.motion.translation import LARGEST
from firstcontact.toolpath.moves import Stretch

INCH = fmpq(254, 10)
"""Millimetres."""


@dataclass(frozen=True)
class Block:
    """A line of a program that moves the tool.

    line: its number in the file, from 1.  stretches: its ways, one after the other.  tool: the number that was called
    last, None without one.  unknown: why it begins or ends at a place that the program does not tell, "" where it does
    not; then it has no stretches.
    """

    line: int
    text: str
    stretches: tuple[Stretch, ...]
    tool: int | None = None
    unknown: str = ""


class Fault(InputError):
    """What a reader does not read."""

    def __init__(self, path: Path, line: int, word: str, what: str) -> None:
        super().__init__(f"{path}: line {line}: {word}: {what}")


def lines_of(path: Path) -> Iterator[tuple[int, str]]:
    """(number, text) of each line; read as they are asked for."""
    try:
        with path.open(encoding="utf-8-sig", errors="replace") as file:
            for number, text in enumerate(file, 1):
                yield number, text.rstrip("\r\n")
    except OSError as error:
        raise InputError(f"{path}: {(error.strerror or str(error)).lower()}; give the path of a program") from error


def number(text: str, fault: Callable[[str, str], Fault]) -> fmpq:
    """The exact value of "-12.50" or "1.5E-3"; fault: makes an error of the text and what is wrong with it."""
    if len(text) > MOST_DIGITS:
        raise fault(f"{text[:20]}...", f"a number of {len(text)} digits; give at most {MOST_DIGITS}")
    digits, _, power = text.partition("E")
    sign, digits = (-1, digits[1:]) if digits[0] == "-" else (1, digits.lstrip("+"))
    whole, _, part = digits.partition(".")
    value = fmpq(sign * int(f"{whole}{part}" or "0"), 10 ** len(part))
    value = value * fmpq(10) ** int(power) if power else value
    if abs(value) >= LARGEST:
        raise fault(text if len(text) < 60 else f"{text[:20]}...", "give a number below 2^150")
    return value
