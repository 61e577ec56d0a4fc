"""A whole program, chunk by chunk, so that it goes on where it was stopped.

The file of `resume` holds a line of JSON that tells what the job is about, and one for each chunk of blocks that is
finished: how many there are, and what was found in which of them.  A line is written at once and counts when it is
whole; of a process that is killed at any moment a torn last line stays, which is cut off.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator
from dataclasses import asdict
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from firstcontact.errors import InputError
from firstcontact.result import finite
from firstcontact.toolpath.check import CHUNK, Finding, Setup, Verdict

if TYPE_CHECKING:
    from firstcontact.toolpath.block import Block
    from firstcontact.toolpath.program import ToolPath

Found = dict[int, tuple[Finding, ...]]


def verdicts(
    path: ToolPath, setup: Setup, *, resume: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None, chunk: int = CHUNK,
) -> Iterator[Verdict]:  # fmt: skip
    """What each block brings together, in order.

    Reads the whole program first, so that a fault ends it before the work begins.
    resume: a file that keeps what is finished, and tells it again when the same job is asked for.
    progress: called with (done, all) blocks.
    """
    total = 0
    for block in path:
        setup.check(block)
        total += 1
    kept = None if resume is None else KeptChunks(Path(resume), about(path, setup))
    blocks, done = iter(path), 0
    if progress is not None:
        progress(0, total)
    try:
        for count, found in kept.chunks() if kept is not None else ():
            yield from _with(list(islice(blocks, count)), found)
            done += count
        if progress is not None and done:
            progress(done, total)
        while some := list(islice(blocks, chunk)):
            told = setup.of_chunk(some)
            if kept is not None:
                kept.add(len(some), {k: x.findings for k, x in enumerate(told) if x.findings})
            done += len(some)
            yield from told
            if progress is not None:
                progress(done, total)
    except KeyboardInterrupt:
        where = "" if kept is None else f"; they are kept in {kept.path}, and the same command goes on from there"
        raise KeyboardInterrupt(f"{done:,} of {total:,} blocks are done{where}") from None


def _with(blocks: list[Block], found: Found) -> Iterator[Verdict]:
    return (Verdict(block, found.get(k, ())) for k, block in enumerate(blocks))


def about(path: ToolPath, setup: Setup) -> dict[str, object]:
    """What two runs of one job have in common, by words that an error may name."""
    from firstcontact import __version__

    bodies = {target.name: finite(target.body.to_dict()) for target in setup.targets}
    try:
        with path.path.open("rb") as data:
            program = hashlib.file_digest(data, "sha256").hexdigest()
    except OSError as error:
        raise InputError(f"{path.path}: {(error.strerror or str(error)).lower()}") from error
    return {
        "program": program,
        "bodies": hashlib.sha256(json.dumps(bodies).encode()).hexdigest(),
        "tools": [[tool.number, *(str(x) for x in tool.segments)] for tool in setup.tools],
        "allowed": [list(asdict(rule).values()) for rule in setup.allow],
        "start": None if path.start is None else [str(x) for x in path.start],
        "unit": path.unit,
        "version": __version__,
    }


class KeptChunks:
    """The file of finished chunks."""

    def __init__(self, path: Path, about: dict[str, object]) -> None:
        self.path, self.about = path, about
        try:
            if path.exists() and not path.is_file():
                raise InputError(f"{path}: is no file; choose another one")
            if not path.exists():
                self._append(about, "w")
            known = self._known()
            if known != about:
                other = " and ".join(key for key in about if known.get(key) != about[key])
                raise InputError(f"{path}: holds blocks of another job ({other} differ); finish that one, or remove it")
            whole = self._whole()
            with path.open("r+b") as file:
                file.truncate(whole)
        except OSError as error:
            raise InputError(f"{path}: {(error.strerror or str(error)).lower()}; choose another file") from error

    def _known(self) -> dict[str, object]:
        with self.path.open(encoding="utf-8") as file:
            line = file.readline()
        try:
            known = json.loads(line)
        except ValueError as error:
            raise InputError(f"{self.path}: keeps no tool path; choose another file") from error
        return known if isinstance(known, dict) else {}

    def _whole(self) -> int:
        """Bytes of the lines that are whole."""
        end = 0
        with self.path.open("rb") as file:
            for line in file:
                if not line.endswith(b"\n"):
                    break
                end += len(line)
        return end

    def chunks(self) -> Iterator[tuple[int, Found]]:
        """(number of blocks, what was found in which of them) of each chunk that is finished, in order."""
        with self.path.open(encoding="utf-8") as file:
            file.readline()
            for number, line in enumerate(file, 2):
                try:
                    kept = json.loads(line)
                    chunk = int(kept["blocks"]), {int(k): tuple(map(_finding, x)) for k, x in kept["found"].items()}
                except (ValueError, TypeError, KeyError, AttributeError) as error:
                    raise InputError(f"{self.path}: line {number} is damaged; remove the file to begin anew") from error
                yield chunk

    def add(self, count: int, found: Found) -> None:
        """Keep a chunk."""
        self._append({"blocks": count, "found": {k: [asdict(x) for x in some] for k, some in found.items()}}, "a")

    def _append(self, table: dict[str, object], mode: str) -> None:
        with self.path.open(mode, encoding="utf-8") as file:
            file.write(json.dumps(table) + "\n")
            file.flush()
            os.fsync(file.fileno())


def _finding(table: dict[str, Any]) -> Finding:
    point, tip = table["point"], table["tip"]
    return Finding(**{**table, "point": None if point is None else tuple(point), "tip": tuple(tip)})

