"""Queries from a file, answers to a file, part by part, so that it goes on where it was stopped."""

from __future__ import annotations

import hashlib
import json
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from heapq import nlargest
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.batch import arrow
from firstcontact.batch.answer_files import writer
from firstcontact.batch.arrow import pyarrow
from firstcontact.batch.culling import is_worth_boxes
from firstcontact.batch.kept_parts import KeptParts
from firstcontact.batch.part import VerbCall
from firstcontact.batch.query_files import QueryFile
from firstcontact.batch.query_rows import Bodies, QueryRows, carried, check_columns
from firstcontact.batch.workers import Reached, Spare, answered, next_size
from firstcontact.errors import InputError
from firstcontact.query import check_arguments
from firstcontact.result import finite
from firstcontact.result_table import Rows

if TYPE_CHECKING:
    from pyarrow import BooleanArray, Schema, Table

    from firstcontact.batch.workers import Executing
    from firstcontact.body.kinds import Body
    from firstcontact.work import FirstArguments

SECONDS, FIRST_ROWS, MOST_ROWS = 20.0, 64, 1 << 18
"""A part takes about so long: what is lost, at most, where a job is killed.  Rows of the first part, and of any."""
TOLD = 3
"""Rows of each kind that a summary names."""


@dataclass
class Summary:
    """What a job found, of all parts.  work: (node visits and pair tests, row), the greatest ones."""

    path: Path
    counts: Counter[str] = field(default_factory=Counter)
    undecided: list[int] = field(default_factory=list)
    errors: list[tuple[int, str]] = field(default_factory=list)
    work: list[tuple[int, int]] = field(default_factory=list)

    @property
    def rows(self) -> int:
        return self.counts.total()

    def add(self, table: Table) -> None:
        """Count a table of answers, the next one in order."""
        pc = pyarrow("compute")
        begin = self.rows
        status = pc.fill_null(table["status"].cast("string"), "error")
        self.counts.update({x["values"]: x["counts"] for x in pc.value_counts(status).to_pylist()})
        for row in _first(pc.equal(status, "UNDECIDED"), TOLD - len(self.undecided)):
            self.undecided.append(begin + row)
        for row in _first(pc.is_valid(table["error"]), TOLD - len(self.errors)):
            self.errors.append((begin + row, table["error"][row].as_py()))
        work = table["work"].to_numpy()
        most = [(int(work[row]), begin + row) for row in np.argsort(-work, kind="stable")[:TOLD].tolist()]
        self.work = nlargest(TOLD, [*self.work, *most], key=lambda x: (x[0], -x[1]))


def _first(chosen: BooleanArray, n: int) -> list[int]:
    """The first n rows that are chosen."""
    rows: list[int] = np.flatnonzero(chosen.to_numpy())[:n].tolist()
    return rows


def answer_file(
    queries: str | Path,
    bodies: Mapping[str, Body],
    out: str | Path,
    *,
    arguments: FirstArguments,
    workers: int | None = None,
    executor: Callable[[tuple[Body, ...]], Executing] | None = None,
    progress: Reached = None,
) -> Summary:
    """Answers all queries of a file about the bodies, and writes them to `out`.

    Looks through the whole file first, so that a fault ends it before the work begins.  What a job that was stopped has
    finished is taken over, if bodies, queries and arguments are the same.
    arguments: of `first_contact`.  executor: made for the bodies, then as `first_contacts` has it.
    progress: called with (answered, all).
    """
    check_arguments("auto", "auto", 1e-12, arguments.get("budget"))
    file, out = QueryFile(queries), Path(out)
    if out.exists() and file.path.exists() and out.samefile(file.path):
        raise InputError(f"{out}: holds the queries; choose another file for the answers")
    known = Bodies(bodies)
    total, schema = _looked_through(file, known)
    write = writer(out, schema)
    kept = KeptParts(out, _about(file, bodies, arguments))
    missing = list(kept.gaps(total))
    try:
        if missing:
            others = executor(known.shapes) if executor is not None else None
            with Spare() as spare:
                asking = VerbCall("first_contact", arguments)
                boxes = is_worth_boxes(len(bodies), total)  # of all parts alike: answers do not tell where these end
                ask = partial(answered, asking=asking, workers=workers, executor=others, spare=spare, boxes=boxes)
                if progress is not None:
                    progress(kept.rows(), total)
                job = _Job(file, known, schema, kept, ask, total, progress, FIRST_ROWS)
                for begin, end in missing:
                    job.fill(begin, end)
    except KeyboardInterrupt:
        text = f"{kept.rows():,} of {total:,} rows are kept in {kept.folder}; the same command goes on from there"
        raise KeyboardInterrupt(text) from None
    summary = Summary(out)
    kept.finish(lambda path: write(path, _counted(kept.tables(), summary)))
    return summary


def _looked_through(file: QueryFile, bodies: Bodies) -> tuple[int, Schema]:
    """(how many queries there are, the schema of what is carried along); InputError names the first fault."""
    pa = pyarrow()
    total, schema = 0, pa.schema([])
    for begin, table in file.tables():
        check_columns(file, table.column_names)
        QueryRows(file, begin, table, bodies).questions()
        total = begin + len(table)
        try:
            kept = table.select(carried(table.column_names)).schema.remove_metadata()
            schema = pa.unify_schemas([schema, kept], promote_options="permissive")
        except pa.ArrowException as error:
            raise InputError(f"{file.path}: row {begin} or later: a column of several kinds: {error}") from error
    if not total:
        raise InputError(f"{file.path}: holds no query; give one row for each")
    return total, schema


def _about(file: QueryFile, bodies: Mapping[str, Body], arguments: FirstArguments) -> dict[str, object]:
    """What two runs of one job have in common."""
    from firstcontact import __version__

    with file.path.open("rb") as data:
        queries = hashlib.file_digest(data, "sha256").hexdigest()
    return {
        "queries": queries,
        "bodies": digest(bodies),
        "options": arguments,
        "version": __version__,
    }


def digest(bodies: Mapping[str, Body]) -> str:
    """The same for the same bodies alone."""
    tables = {key: finite(body.to_dict()) for key, body in bodies.items()}
    return hashlib.sha256(json.dumps(tables).encode()).hexdigest()


def _counted(tables: Iterator[Table], summary: Summary) -> Iterator[Table]:
    for table in tables:
        summary.add(table)
        yield table


@dataclass
class _Job:
    """ask: the answers to questions, with progress=.  size: rows of the next part."""

    file: QueryFile
    bodies: Bodies
    schema: Schema
    kept: KeptParts
    ask: Callable[..., Rows]
    total: int
    progress: Reached
    size: int

    def fill(self, begin: int, end: int) -> None:
        """Answer the queries from row `begin` to before row `end`."""
        for at, table in self.file.pieces(begin, end, lambda: self.size):
            since = time.monotonic()
            self.kept.add(at, self._answers(at, table))
            self.size = next_size(self.size, len(table), time.monotonic() - since, SECONDS, MOST_ROWS)

    def _answers(self, begin: int, table: Table) -> Table:
        """What is carried along, and the answers beside it."""
        pa = pyarrow()
        rows, done = Rows(len(table)), self.kept.rows()
        for where, questions in QueryRows(self.file, begin, table, self.bodies).questions():
            reached = partial(self._reached, done)
            rows.put(where, self.ask(questions, progress=reached).settle())
            done += len(where)
        missing = pa.nulls(len(table))
        names = table.column_names
        carried = [(table[f.name] if f.name in names else missing).cast(f.type) for f in self.schema]
        told = arrow.table_of(rows)
        return pa.table([*carried, *told.columns], names=[*self.schema.names, *told.column_names])

    def _reached(self, before: int, done: int, _: int) -> None:
        if self.progress is not None:
            self.progress(before + done, self.total)
