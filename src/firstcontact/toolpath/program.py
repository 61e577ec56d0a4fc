"""A program of either kind."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from firstcontact.errors import InputError
from firstcontact.motion.translation import vector3
from firstcontact.toolpath.blocks import Block
from firstcontact.toolpath.check import Setup, Verdict
from firstcontact.toolpath.cl import read_cl
from firstcontact.toolpath.gcode import read_gcode
from firstcontact.toolpath.rules import CUTTING, Allowed
from firstcontact.toolpath.tool import Tool

READERS = {
    **dict.fromkeys((".nc", ".ngc", ".gcode", ".tap", ".cnc", ".ncc", ".gc", ".mpf", ".txt"), read_gcode),
    **dict.fromkeys((".cl", ".cls", ".apt", ".aptsource", ".ncl", ".cldata"), read_cl),
}


class ToolPath:
    """The blocks of a file of G-code (`.nc`, `.ngc`, `.tap` ...) or APT / CL data (`.apt`, `.cl`, `.cls` ...).

    path: of the file, which is read each time that the blocks are gone through.  start: the tip before it begins,
    default None: not known, so that what goes away from there is not looked at.  unit: of the bodies, "mm" or "inch".
    Raises InputError that names line and word, when it comes to what it does not read.
    """

    def __init__(self, path: str | Path, *, start: Any = None, unit: str = "mm") -> None:
        self.path, self.unit = Path(path), unit or "mm"
        if self.unit not in ("mm", "in", "inch"):
            raise InputError(f"{self.path}: lengths of the scene are in {unit!r}; tool paths are read in mm or inch")
        self.start = None if start is None else vector3(start, "start")
        read = READERS.get(self.path.suffix.lower())
        if read is None:
            raise InputError(f"{self.path}: programs end with {', '.join(READERS)}")
        self._read = read

    def __iter__(self) -> Iterator[Block]:
        return self._read(self.path, self.start, self.unit)

    def verdicts(
        self, tools: Tool | Iterable[Tool], bodies: Mapping[str, Any], *, allow: Iterable[Allowed] = CUTTING,
        workers: int | None = None,
    ) -> Iterator[Verdict]:  # fmt: skip
        """What each block brings together, in order, as it is found; arguments as of `Setup`."""
        return Setup(tools, bodies, tuple(allow), workers).verdicts(self)
