"""G-code in three axes (RS-274, ISO 6983): blocks to ways of the tool.

Read are G0 to G3 (arcs by I J K, also G90.1, or R, helical, in the planes G17 to G19), G4, drilling by G81 to G83 with
G80, G98, G99, absolute and incremental (G90, G91), inches and millimetres (G20, G21), and words that move nothing
(`STILL`, F, S, T, M, N, O, comments).  Anything else stops with its line and word.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from flint import fmpq

from firstcontact.exact.numbers import to_double
from firstcontact.exact.vectors import Vector
from firstcontact.motion.poses import BITS, sqrt_near
from firstcontact.toolpath.blocks import INCH, Block, Fault, lines_of, number
from firstcontact.toolpath.cycles import CYCLES, drilled
from firstcontact.toolpath.moves import ArcMove, Bow, StraightMove, Stretch, tangent_of_half

WORD = re.compile(r"([A-Z])\s*([-+]?(?:\d+\.?\d*|\.\d+))|(\S+)")
"""A letter and its number; or else what no word is."""
COMMENT = re.compile(r"\([^()]*\)|;.*")
XYZ = "XYZ"
STILL = {"4", "9", "40", "43", "49", "54", "55", "56", "57", "58", "59", "61", "64", "80", "94", "95", "96", "97"}
"""Numbers of G words, beside those that are looked at, that move nothing (zeros of work have to stay the same one)."""
ZEROS = {"54", "55", "56", "57", "58", "59"}
AWAY = {"28", "30", "53"}
"""These go to places of the machine, which a program does not tell."""
ARGUMENTS = "XYZIJKRQPLFSTMNODHG"
PLANES = {"17": (0, 1, 2), "18": (2, 0, 1), "19": (1, 2, 0)}
"""The two axes of a plane and its normal, right-handed."""
BOW = fmpq(1, 8)
"""Tangent of half the angle of the parts of an arc in G18 and G19."""
OFF, OFF_PART = 0.01, 1e-3
"""How far the end of an arc may be off the circle: millimetres, part of the radius."""
MODAL = tuple(PLANES), ("90", "91"), ("90.1", "91.1"), ("20", "21"), ("98", "99")
"""Of which one holds at a time."""
PLAIN = {"0", "1", "2", "3", *CYCLES}
CHANGE = "M6"


@dataclass
class Machine:
    """What stays from block to block.  at: the tip, None for axes whose place no word has told."""

    at: list[fmpq | None]
    per_unit: fmpq
    """Units of the scene in one of the program."""
    inch: fmpq
    """Units of the scene in an inch."""
    mode: str | None = None
    plane: str = "17"
    absolute: bool = True
    centre_absolute: bool = False
    to_initial: bool = True
    zero: str = ""
    ended: str = ""
    """The word after which nothing moves any more."""
    tool: int | None = None
    chosen: int | None = None
    cycle: dict[str, fmpq] = field(default_factory=dict)
    """R, Z, Q of the drilling cycle, and the height at which it began."""


def read_gcode(path: Path, start: Vector | None = None, unit: str = "mm") -> Iterator[Block]:
    """The blocks of a program that move the tool.

    start: the tip before it begins, in the unit of the scene, default: the program does not tell.  unit: of the scene.
    Raises InputError at the first line that is not read.
    """
    inch = fmpq(1) if unit in ("in", "inch") else INCH
    machine = Machine(list(start) if start is not None else [None] * 3, fmpq(1), inch)
    reader = _Reader(path, machine)
    for line, text in lines_of(path):
        block = reader.block(line, text)
        if block is not None:
            yield block


class _Reader:
    """One line after the other."""

    def __init__(self, path: Path, machine: Machine) -> None:
        self.path, self.machine, self.line = path, machine, 0
        self.ending = ""
        """What ends the program in this line."""
        self.has_begun = False

    def fault(self, word: str, what: str) -> Fault:
        return Fault(self.path, self.line, word, what)

    def block(self, line: int, text: str) -> Block | None:
        """What the line does; None where it moves nothing."""
        self.line = line
        words, codes = self._words(text)
        m = self.machine
        self._settings(codes, words)
        away = next((code for code in codes if code in AWAY), None)
        if away is not None:
            return self._away(away, words, text)
        named = [x for x in XYZ if x in words]
        moving = named or [x for x in "IJK" if x in words and m.mode in ("2", "3")]
        if m.ended and moving:
            word = f"{moving[0]}{words[moving[0]][0]}"
            raise self.fault(word, f"after {m.ended}, where the program ends; give what follows as one of its own")
        m.ended = m.ended or self.ending
        if "4" in codes or not moving:
            self._without_motion(words, codes)
            return None
        if m.mode is None:
            raise self.fault(f"{named[0]}{words[named[0]][0]}", "no motion is chosen; write G0, G1, G2 or G3 before")
        begin, end = list(m.at), self._end(words)
        if m.mode in CYCLES:
            stretches = drilled(self, words, begin, end)
        else:
            m.at = list(end)
            stretches = None if None in begin or None in end else self._way(words, tuple(begin), tuple(end))
        if stretches is None:
            return Block(line, text.strip(), (), m.tool, "it begins where the program does not tell")
        moves = tuple(x for x in stretches if not isinstance(x, StraightMove) or x.start != x.end)
        return Block(line, text.strip(), moves, m.tool)

    def _words(self, text: str) -> tuple[dict[str, tuple[str, fmpq]], list[str]]:
        """Words but G by letter, as text and value, and the numbers of G words."""
        plain = (COMMENT.sub(" ", text) if "(" in text or ";" in text else text).upper().strip().removeprefix("/")
        self.ending = "%" if plain.startswith("%") and self.has_begun else ""
        if plain.startswith("%") or not plain:
            return {}, []
        self.has_begun = True
        words: dict[str, tuple[str, fmpq]] = {}
        codes: list[str] = []
        for letter, digits, other in WORD.findall(plain):
            if other or letter not in ARGUMENTS:
                raise self.fault(other or f"{letter}{digits}", "not read; see docs/toolpaths.md")
            if letter == "G":
                codes.append(digits.lstrip("+0") or "0")
            elif letter == "M":
                codes += self._miscellaneous(digits)
            elif letter in words:
                raise self.fault(f"{letter}{digits}", f"a second {letter} in one block; give one")
            else:
                words[letter] = digits, number(digits, lambda told, what: self.fault(f"{letter}{told}", what))  # noqa: B023
        return words, codes

    def _miscellaneous(self, digits: str) -> list[str]:
        """M words move nothing; a change of tools counts, and the end."""
        if digits.lstrip("0") in ("2", "30"):
            self.ending = f"M{digits}"
        if digits.lstrip("0") in ("97", "98", "99"):
            raise self.fault(f"M{digits}", "subprograms are not read; write their blocks in their place")
        return [CHANGE] if digits.lstrip("0") == "6" else []

    def _settings(self, codes: list[str], words: dict[str, tuple[str, fmpq]]) -> None:
        m = self.machine
        if "T" in words:
            m.chosen = int(words["T"][1])
        if CHANGE in codes:
            m.tool = m.chosen
            codes.remove(CHANGE)
        if "80" in codes:
            m.mode = None
        motions = [code for code in codes if code in PLAIN]
        if len(motions) > 1:
            raise self.fault(f"G{motions[1]}", f"beside G{motions[0]} in one block; give one motion")
        for group in MODAL:
            given = list(dict.fromkeys(code for code in codes if code in group))
            if len(given) > 1:
                raise self.fault(f"G{given[1]}", f"beside G{given[0]} in one block; give one of them")
        for code in codes:
            if code in PLAIN:
                if code in CYCLES and m.mode not in CYCLES:
                    m.cycle = {} if m.at[2] is None else {"begin": m.at[2]}
                m.mode = code
            elif code in PLANES:
                m.plane = code
            elif code in ("90", "91"):
                m.absolute = code == "90"
            elif code in ("90.1", "91.1"):
                m.centre_absolute = code == "90.1"
            elif code in ("20", "21"):
                m.per_unit = m.inch if code == "20" else m.inch / INCH
            elif code in ("98", "99"):
                m.to_initial = code == "98"
            elif code in ZEROS:
                if m.zero not in ("", code):
                    raise self.fault(f"G{code}", f"another zero than G{m.zero}; give a program for each zero")
                m.zero = code
            elif code not in STILL and code not in AWAY:
                raise self.fault(f"G{code}", "not read; see docs/toolpaths.md")

    def _without_motion(self, words: dict[str, tuple[str, fmpq]], codes: list[str]) -> None:
        """Takes what a cycle may be told beforehand, and refuses words that would have meant a motion."""
        if "4" in codes:
            return
        for letter in "IJKRQL":
            if letter in words and self.machine.mode not in CYCLES:
                raise self.fault(f"{letter}{words[letter][0]}", "no X, Y or Z in this block; give the place to go to")

    def _away(self, code: str, words: dict[str, tuple[str, fmpq]], text: str) -> Block:
        """Axes that are named, all where none is, go to a place of the machine."""
        named = [k for k, x in enumerate(XYZ) if x in words]
        for k in named or range(3):
            self.machine.at[k] = None
        return Block(self.line, text.strip(), (), self.machine.tool, f"G{code} goes to a place of the machine")

    def _end(self, words: dict[str, tuple[str, fmpq]]) -> list[fmpq | None]:
        m, end = self.machine, list(self.machine.at)
        for k, x in enumerate(XYZ):
            if x in words:
                value, here = words[x][1] * m.per_unit, end[k]
                end[k] = value if m.absolute else None if here is None else here + value
        return end

    def _way(self, words: dict[str, tuple[str, fmpq]], begin: Any, end: Any) -> list[Stretch]:
        mode = self.machine.mode
        if mode in ("0", "1"):
            for letter in "IJKRQL":
                if letter in words:
                    raise self.fault(f"{letter}{words[letter][0]}", f"does not go with G{mode}; leave it out")
            return [StraightMove(_kind(mode, begin, end), begin, end)]
        return self._arc(words, begin, end)

    def _arc(self, words: dict[str, tuple[str, fmpq]], begin: Vector, end: Vector) -> list[Stretch]:
        m = self.machine
        p, q, n = PLANES[m.plane]
        centre = list(begin)
        out = [k for k in (p, q) if "IJK"[k] in words]
        if "R" in words:
            if out:
                raise self.fault(f"R{words['R'][0]}", "beside I, J or K; give one of them")
            centre[p], centre[q] = self._centre_by_radius(words["R"], begin, end)
        elif not out:
            raise self.fault(f"G{m.mode}", "an arc without centre; give I, J, K or R")
        for k in out:
            value = words["IJK"[k]][1] * m.per_unit
            centre[k] = value if m.centre_absolute else begin[k] + value
        if "IJK"[n] in words and words["IJK"[n]][1]:
            raise self.fault(f"{'IJK'[n]}{words['IJK'[n]][0]}", f"not in the plane G{m.plane}; leave it out")
        for letter in "PL":
            if letter in words and words[letter][1] != 1:
                raise self.fault(f"{letter}{words[letter][0]}", "arcs of several turns are not read; write each turn")
        a, b = (math.atan2(to_double(x[q] - centre[q]), to_double(x[p] - centre[p])) for x in (begin, end))
        radius, other = (math.hypot(*(to_double(x[k] - centre[k]) for k in (p, q))) for x in (begin, end))
        word = next((f"{'IJK'[k]}{words['IJK'[k]][0]}" for k in out), f"R{words.get('R', ('',))[0]}")
        most = max(OFF * to_double(m.inch / INCH), OFF_PART * radius)
        if not radius:
            raise self.fault(word, "a circle of radius 0; give the centre as seen from the place where the arc begins")
        if abs(radius - other) > most:
            raise self.fault(word, f"the end is {abs(radius - other):.4g} off the circle of radius {radius:.6g}")
        angle = (b - a) % (2.0 * math.pi)
        full = begin[p] == end[p] and begin[q] == end[q]
        angle = 0.0 if full else angle if m.mode == "3" else angle - 2.0 * math.pi
        turns = (1 if m.mode == "3" else -1) if full else 0
        off = abs(radius - other)
        if n == 2:
            return [ArcMove("feed", begin, tuple(centre), angle, turns, end[2] - begin[2], off)]
        return _bows(begin, tuple(centre), n, angle or 2.0 * math.pi * turns, end[n] - begin[n], off)

    def _centre_by_radius(self, word: tuple[str, fmpq], begin: Vector, end: Vector) -> tuple[fmpq, fmpq]:
        """The centre on the side that the sign of R and the sense tell, rounded to doubles where it is no fraction."""
        m = self.machine
        p, q, _ = PLANES[m.plane]
        radius = word[1] * m.per_unit
        x, y = end[p] - begin[p], end[q] - begin[q]
        square = x * x + y * y
        if not square:
            raise self.fault(f"R{word[0]}", "the arc ends where it begins; give I, J or K")
        height = radius * radius - square / 4
        if height < 0:
            if -to_double(height) > 2 * OFF_PART * to_double(radius * radius):
                raise self.fault(f"R{word[0]}", "the end is farther away than two radii; mend it")
            height = fmpq(0)
        share = sqrt_near(height / square, BITS) if height else height
        if (radius > 0) == (m.mode == "2"):  # the centre is to the right of the way
            share = -share
        return begin[p] + x / 2 - share * y, begin[q] + y / 2 + share * x


def _kind(mode: str | None, begin: Vector, end: Vector) -> str:
    """A rapid straight upwards, away from the tip, goes back over what the tool has just passed."""
    if mode == "1":
        return "feed"
    return "back" if begin[:2] == end[:2] and end[2] > begin[2] else "rapid"


def _bows(begin: Vector, centre: Vector, n: int, angle: float, advance: fmpq, off: float) -> list[Stretch]:
    """An arc in a plane that holds the tool's axis, in parts that join exactly."""
    normal: Vector = tuple(fmpq(int(k == n)) for k in range(3))  # type: ignore[assignment]
    step = 2.0 * math.atan(to_double(BOW))
    whole = int(abs(angle) / step)
    sign = 1 if angle > 0 else -1
    rest = angle - sign * whole * step
    parts = [(sign * BOW, step)] * whole + ([(tangent_of_half(rest), abs(rest))] if abs(rest) > 1e-12 else [])
    made: list[Stretch] = []
    start = begin
    given = fmpq(0)
    for k, (tangent, _) in enumerate(parts):
        share = advance - given if k == len(parts) - 1 else advance * fmpq(round(step / abs(angle) * 2**40), 2**40)
        bow = Bow("feed", start, centre, normal, tangent, share, off)
        made.append(bow)
        start, given = bow.end, given + share
    return made
