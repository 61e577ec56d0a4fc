"""A program of either kind."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.errors import InputError
from firstcontact.motion.translation import vector3
from firstcontact.toolpath import job
from firstcontact.toolpath.blocks import Block
from firstcontact.toolpath.check import Setup, Verdict
from firstcontact.toolpath.cl import read_cl
from firstcontact.toolpath.gcode import read_gcode
from firstcontact.toolpath.rules import CUTTING, Allowed
from firstcontact.toolpath.tool import Tool

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.exact.numbers import Given

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

    def __init__(self, path: str | Path, *, start: Iterable[Given] | None = None, unit: str = "mm") -> None:
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
        self, tools: Tool | Iterable[Tool], bodies: Mapping[str, Body], *, allow: Iterable[Allowed] = CUTTING,
        workers: int | None = None, resume: str | Path | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> Iterator[Verdict]:  # fmt: skip
        """What each block brings together, in order, as it is found.

        tools: one, or several that the program calls by their numbers.  bodies: at rest, by name.  allow: what may
        touch; by default the cutter may be in bodies called "stock..." in feed.  workers: how many cores take part,
        default None: all of them.  resume: a file that keeps what is finished, and tells it again when the same job is
        asked for.  progress: called with (done, all) blocks.

        FREE proves that no part of the tool shares a point with a body at any time of the block.

        >>> import firstcontact as fc
        >>> mill = fc.Tool([("flutes", "cutter", 6, 20), ("collet", "holder", 30, 40)])
        >>> path = fc.ToolPath("examples/pocket.nc", start=(0, 0, 60))
        >>> wall = fc.box((2, 90, 60)).translated((55, 0, 0))
        >>> {verdict.status for verdict in path.verdicts(mill, {"wall": wall})}
        {'FREE'}
        """
        setup = Setup(tools, bodies, tuple(allow), workers)
        return job.verdicts(self, setup, resume=resume, progress=progress)
