"""The folder in which a job keeps what is finished, until all of it is.

Beside OUT stands the folder OUT.parts.  It holds `job.json`, what the job is about, and a file for each part that is
finished, named by its rows: Parquet of a batch, JSON of what a course has met from one waypoint to another.  A file is
written under another name first and takes its own at once when it is whole, so that a process that is killed at any
moment leaves whole parts and, of the one at work, nothing that counts.
A part that is torn all the same, as by a full disk or a machine that stops, is told by its size and its checksums, and
done again.  The last step is one change of names too: OUT of a batch is there whole, or not at all.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict

from firstcontact.batch.arrow import pyarrow
from firstcontact.errors import InputError

if TYPE_CHECKING:
    from pyarrow import Table

    from firstcontact.result import Json

NAME = re.compile(r"rows-(\d+)-(\d+)(\.\w+)")


class MetRow(TypedDict):
    """A pair of a course, by its number, and what it meets, as `to_dict` has it."""

    pair: int
    hit: dict[str, Json]


class KeptFiles:
    """The finished parts of a job: whole files, each of the rows that its name tells."""

    suffix: str
    """Of a part's file."""

    def __init__(self, out: Path, about: Mapping[str, object]) -> None:
        """about: what the job is about, by words that an error may name.  InputError where the folder is of another."""
        self.out, self.folder = out, self.folder_of(out)
        shutil.rmtree(self._done, ignore_errors=True)
        known = self._known()
        if known is None:
            with _faults(self.folder):
                self.folder.mkdir(exist_ok=True)
            self._write("job.json", lambda path: path.write_text(json.dumps(about, indent=1), encoding="utf-8"))
        elif known != about:
            other = " and ".join(key for key in about if known.get(key) != about[key]) or "its questions"
            raise InputError(
                f"{self.folder}: holds parts of another job ({other} differ); finish that one, or remove the folder"
            )
        self.parts = {(begin, end): path for begin, end, path in self._whole()}

    @staticmethod
    def folder_of(out: Path) -> Path:
        """Where the parts are of what becomes OUT."""
        return out.with_name(f"{out.name}.parts")

    @property
    def _done(self) -> Path:
        return self.folder.with_name(f"{self.folder.name}.done")

    def _known(self) -> Mapping[str, object] | None:
        try:
            known = json.loads((self.folder / "job.json").read_text(encoding="utf-8"))
        except FileNotFoundError:
            return None
        except (OSError, ValueError):
            return {}
        return known if isinstance(known, dict) else {}

    def _whole(self) -> Iterator[tuple[int, int, Path]]:
        """Parts that are what their names say; others are removed."""
        for path in sorted(self.folder.iterdir()):
            named = NAME.fullmatch(path.name)
            if named is None or named[3] != self.suffix:
                continue
            begin, end = int(named[1]), int(named[2])
            if self._is_whole(path, end - begin):
                yield begin, end, path
            else:
                path.unlink()

    def _is_whole(self, path: Path, rows: int) -> bool:
        raise NotImplementedError

    def gaps(self, total: int) -> Iterator[tuple[int, int]]:
        """Rows that are not answered yet, from one to before another."""
        at = 0
        for begin, end in sorted(self.parts):
            if begin > at:
                yield at, begin
            at = max(at, end)
        if at < total:
            yield at, total

    def rows(self) -> int:
        return sum(end - begin for begin, end in self.parts)

    def _keep(self, begin: int, end: int, write: Callable[[Path], object]) -> None:
        self.parts[begin, end] = self._write(f"rows-{begin:012}-{end:012}{self.suffix}", write)

    def _write(self, name: str, write: Callable[[Path], object]) -> Path:
        """A file that is there whole or not at all."""
        path, torn = self.folder / name, self.folder / f"{name}.torn"
        with _faults(path):
            write(torn)
            _sync(torn)
            os.replace(torn, path)
        return path

    def finish(self, write: Callable[[Path], None]) -> None:
        """`write` writes all of it to a path, which becomes OUT; the parts go."""
        torn = self.folder / f"whole{self.out.suffix}"
        with _faults(self.out):
            write(torn)
            _sync(torn)
            os.replace(torn, self.out)
        self.remove()

    def remove(self) -> None:
        """The parts go, all at once."""
        with _faults(self.folder):
            os.replace(self.folder, self._done)
            shutil.rmtree(self._done)


class KeptParts(KeptFiles):
    """Parts of a batch, as tables of answers."""

    suffix = ".parquet"

    def _is_whole(self, path: Path, rows: int) -> bool:
        try:
            table = pyarrow("parquet").read_table(path, page_checksum_verification=True)
            whole: bool = table.num_rows == rows
        except (pyarrow().ArrowException, OSError):
            return False
        return whole

    def add(self, begin: int, table: Table) -> None:
        """Keep a part."""
        write = pyarrow("parquet").write_table
        self._keep(begin, begin + len(table), lambda path: write(table, path, write_page_checksum=True))

    def tables(self) -> Iterator[Table]:
        """The parts in order; a damaged one is removed and named."""
        pa, pq = pyarrow(), pyarrow("parquet")
        for key in sorted(self.parts):
            path = self.parts[key]
            try:
                yield pq.read_table(path, page_checksum_verification=True)
            except (pa.ArrowException, OSError) as error:
                path.unlink(missing_ok=True)
                raise InputError(f"{path}: damaged, and removed; the same command does it again") from error


class KeptLines(KeptFiles):
    """Parts of a course: what was met from one waypoint to another, as JSON with its checksum."""

    suffix = ".json"

    def _is_whole(self, path: Path, rows: int) -> bool:
        try:
            kept = json.loads(path.read_bytes())
            return bool(kept["checksum"] == _checksum(kept["rows"]))
        except (OSError, ValueError, TypeError, KeyError):
            return False

    def add(self, begin: int, end: int, rows: list[MetRow]) -> None:
        """Keep a part."""
        text = json.dumps({"checksum": _checksum(rows), "rows": rows})
        self._keep(begin, end, lambda path: path.write_text(text, encoding="utf-8"))

    def taken_over(self) -> tuple[int, list[MetRow]]:
        """To where all of it is finished, from the start on, and the rows of these parts; what lies beyond goes."""
        done, rows = 0, list[MetRow]()
        for (begin, end), path in sorted(self.parts.items()):
            if begin == done:
                done, rows = end, rows + json.loads(path.read_bytes())["rows"]
            else:
                path.unlink()
                del self.parts[begin, end]
        return done, rows


def _checksum(rows: list[MetRow]) -> str:
    return hashlib.sha256(json.dumps(rows).encode()).hexdigest()


@contextmanager
def _faults(path: Path) -> Iterator[None]:
    """What the system refuses, in one line."""
    try:
        yield
    except OSError as error:
        reason = (error.strerror or str(error).partition("\n")[0]).lower()
        raise InputError(f"{path}: {reason}; what is finished is kept, and the same command goes on") from error


def _sync(path: Path) -> None:
    """Have the system write it down."""
    with path.open("rb+") as file:
        os.fsync(file.fileno())
