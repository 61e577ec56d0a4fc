"""Files of queries, as tables of some thousand rows, one after the other: Parquet, CSV, JSON lines.

Memory is that of a few such tables, however long the file is.  Faults name the file, the row (the first one is 0) and
the column.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.batch.arrow import pyarrow
from firstcontact.errors import InputError, shown

if TYPE_CHECKING:
    from types import ModuleType

    from pyarrow import Array, Table

    from firstcontact.result import Json

CHUNK = 1 << 14
"""Rows that are read at once."""
BLOCK = 1 << 20
"""Bytes that are read at once."""


class QueryFile:
    """The rows of a file."""

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._read = FORMATS.get(self.path.suffix.lower())
        if self._read is None:
            raise InputError(f"{path}: queries stand in files that end with {', '.join(FORMATS)}")

    def tables(self, begin: int = 0) -> Iterator[tuple[int, Table]]:
        """(number of the first row, pyarrow.Table) one after the other, from row `begin` on."""
        assert self._read is not None
        at = begin
        with _named(self.path):
            for table in self._read(self.path, begin):
                if len(table):
                    yield at, table
                    at += len(table)

    def pieces(self, begin: int, end: int, size: Callable[[], int]) -> Iterator[tuple[int, Table]]:
        """The same, to before row `end`, in tables of as many rows as `size` says when one begins."""
        pa = pyarrow()
        held: list[Table] = []
        wanted = min(size(), end - begin)
        for _, table in self.tables(begin):
            held.append(table)
            while sum(map(len, held)) >= wanted:
                together = pa.concat_tables(held, promote_options="permissive")
                yield begin, together.slice(0, wanted)
                begin += wanted
                if begin >= end:
                    return
                held, wanted = [together.slice(wanted)], min(size(), end - begin)

    def fault(self, row: int, column: str, text: str) -> InputError:
        return InputError(f"{self.path}: row {row}, column {column}: {text}")


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """Faults of the system and of pyarrow in one line."""
    try:
        yield
    except InputError:
        raise
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not text in UTF-8") from error
    except OSError as error:
        reason = error.strerror or str(error).partition("\n")[0]
        raise InputError(f"{path}: {reason[:1].lower()}{reason[1:]}; give a file of queries") from error
    except pyarrow().ArrowException as error:
        reason = str(error).partition("\n")[0]
        raise InputError(f"{path}: no {path.suffix.lower()[1:]} file that can be read: {reason}") from error


def _parquet(path: Path, begin: int) -> Iterator[Table]:
    pa, pq = pyarrow(), pyarrow("parquet")
    with path.open("rb"):  # whose faults are plain
        pass
    with pq.ParquetFile(path, pre_buffer=False, buffer_size=BLOCK) as file:
        groups = list(range(file.num_row_groups))
        while groups and begin >= file.metadata.row_group(groups[0]).num_rows:
            begin -= file.metadata.row_group(groups.pop(0)).num_rows
        for batch in file.iter_batches(CHUNK, row_groups=groups):
            yield pa.table(batch).slice(begin)
            begin = max(begin - len(batch), 0)


def _csv(path: Path, begin: int) -> Iterator[Table]:
    """Texts alone: what is a number is told by what it stands for, what is carried along stays as it is written."""
    pa, csv = pyarrow(), pyarrow("csv")
    reading = csv.ReadOptions(block_size=BLOCK)
    with path.open("rb") as file:
        if not file.read(1):
            raise InputError(f"{path}: empty; give a line with the names of the columns and one for each query")
    with csv.open_csv(path, reading) as file:
        names = file.schema.names
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"{path}: two columns are called {twice}")
    texts = csv.ConvertOptions(
        column_types=dict.fromkeys(names, pa.string()), null_values=[""], strings_can_be_null=True
    )
    with csv.open_csv(path, reading, convert_options=texts) as file:
        for batch in file:
            yield pa.table(batch).slice(begin)
            begin = max(begin - len(batch), 0)


def _json_lines(path: Path, begin: int) -> Iterator[Table]:
    pa = pyarrow()
    with path.open(encoding="utf-8-sig") as file:
        lines = islice((line for line in file if line.strip()), begin, None)
        while some := list(islice(lines, CHUNK)):
            yield _columns(pa, path, begin, _json_rows(path, begin, some))
            begin += len(some)


def _json_rows(path: Path, begin: int, lines: list[str]) -> list[dict[str, Json]]:
    """Read together, which is quicker, if they are what they should be."""
    try:
        rows: list[dict[str, Json]] = json.loads(f"[{','.join(lines)}]")
    except (ValueError, RecursionError):
        rows = []
    if len(rows) == len(lines) and all(isinstance(row, dict) for row in rows):
        return rows
    return [_json_row(path, begin + k, line) for k, line in enumerate(lines)]


def _json_row(path: Path, number: int, line: str) -> dict[str, Json]:
    try:
        row = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: row {number} is no JSON: {error}") from error
    if not isinstance(row, dict):
        raise InputError(f'{path}: row {number} is {shown(row)}; write an object, {{"a": ..., "b": ...}}')
    return row


def _columns(pa: ModuleType, path: Path, begin: int, rows: list[dict[str, Json]]) -> Table:
    names = dict.fromkeys(key for row in rows for key in row)
    return pa.table({name: _column(pa, path, begin, name, [row.get(name) for row in rows]) for name in names})


def _column(pa: ModuleType, path: Path, begin: int, name: str, values: list[Json]) -> Array:
    column = _array(pa, values)
    if column is None:
        row = first_wrong(len(values), lambda n: _array(pa, values[:n]) is not None)
        text = f"{shown(values[row])} is of several kinds, or of another one than the values before it"
        raise InputError(f"{path}: row {begin + row}, column {name}: {text}")
    return column


def _array(pa: ModuleType, values: list[Json]) -> Array | None:
    """A column of the values; None where they do not go into one."""
    try:
        return pa.array(values)
    except (pa.ArrowException, TypeError, ValueError, OverflowError):
        return None


def first_wrong(n: int, right: Callable[[int], bool]) -> int:
    """The first of n values with which those up to it are no longer right; with all of them they are not."""
    low, high = 0, n - 1
    while low < high:
        middle = (low + high) // 2
        low, high = (middle + 1, high) if right(middle + 1) else (low, middle)
    return low


FORMATS: dict[str, Callable[[Path, int], Iterator[Table]]] = {
    ".parquet": _parquet,
    ".csv": _csv,
    ".jsonl": _json_lines,
}
"""How the rows from a number on are read, by the end of the file's name."""
