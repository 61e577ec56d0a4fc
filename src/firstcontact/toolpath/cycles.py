"""Drilling cycles G81 to G83."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flint import fmpq

from firstcontact.exact.vectors import Vector
from firstcontact.toolpath.moves import StraightMove, Stretch

if TYPE_CHECKING:
    from firstcontact.toolpath.gcode import _Reader

CYCLES = {"81", "82", "83"}
MOST_PECKS = 10_000


def drilled(
    reader: _Reader, words: dict[str, tuple[str, fmpq]], begin: list[Any], end: list[Any]
) -> list[Stretch] | None:
    """The ways of one hole; None where it begins at a place that the program does not tell.

    To the place at the height that the tool has (first up to R, if it is below), down to R, in feed to Z (G83: by Q at
    a time, each time out to R and back), and out: to R by G99, by G98 to the height at which the cycle was called.
    """
    m = reader.machine
    top, bottom, peck = _heights(reader, words)
    if None in begin or end[0] is None or end[1] is None:
        known = m.cycle.get("begin")
        m.at = [end[0], end[1], top if not m.to_initial else known]
        return None
    z, high = begin[2], m.cycle.setdefault("begin", begin[2])
    ways = _Ways(tuple(begin))
    if z < top:
        ways.to("rapid", z=top)
    for _ in range(_times(reader, words)):
        ways.to("rapid", x=end[0], y=end[1])
        ways.to("rapid", z=top)
        depth = top
        while peck and depth - peck > bottom:
            depth -= peck
            if len(ways.made) > 3 * MOST_PECKS:
                raise reader.fault(f"Q{words.get('Q', ('',))[0]}", f"more than {MOST_PECKS} pecks; give a larger Q")
            ways.to("feed", z=depth)
            ways.to("back", z=top)
            ways.to("back", z=depth)
        ways.to("feed", z=bottom)
        ways.to("back", z=max(top, high) if m.to_initial else top)
    m.at = list(ways.at)
    return ways.made


def _times(reader: _Reader, words: dict[str, tuple[str, fmpq]]) -> int:
    if "L" in words and words["L"][1] != 1:
        raise reader.fault(f"L{words['L'][0]}", "repeated cycles are not read; write each hole")
    return 1


def _heights(reader: _Reader, words: dict[str, tuple[str, fmpq]]) -> tuple[fmpq, fmpq, fmpq]:
    """R, Z and Q of the cycle, which stay until others are given."""
    m = reader.machine
    for letter in "IJK":
        if letter in words:
            raise reader.fault(f"{letter}{words[letter][0]}", f"does not go with G{m.mode}; leave it out")
    for letter in "RZQ":
        if letter in words:
            m.cycle[letter] = words[letter][1] * m.per_unit
    for letter in "RZ" if m.mode != "83" else "RZQ":
        if letter not in m.cycle:
            raise reader.fault(f"G{m.mode}", f"{letter} is missing; give it")
    top, bottom = m.cycle["R"], m.cycle["Z"]
    if not m.absolute:
        top = m.cycle.get("begin", fmpq(0)) + top
        bottom = top + bottom
    if bottom > top:
        raise reader.fault(f"G{m.mode}", "Z is above R; give a depth below it")
    peck = m.cycle["Q"] if m.mode == "83" else fmpq(0)
    if peck < 0 or m.mode == "83" and not peck:
        raise reader.fault(f"G{m.mode}", "Q is not positive; give the depth of a peck")
    return top, bottom, peck


class _Ways:
    """Straight ways one after the other."""

    def __init__(self, at: Vector) -> None:
        self.at = at
        self.made: list[Stretch] = []

    def to(self, kind: str, x: fmpq | None = None, y: fmpq | None = None, z: fmpq | None = None) -> None:
        place: Vector = tuple(  # type: ignore[assignment]
            old if new is None else new for old, new in zip(self.at, (x, y, z), strict=True)
        )
        if place != self.at:
            self.made.append(StraightMove(kind, self.at, place))
        self.at = place
