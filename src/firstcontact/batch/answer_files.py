"""Tables of answers as files: Parquet, CSV, JSON lines."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.batch.arrow import pyarrow
from firstcontact.errors import InputError

if TYPE_CHECKING:
    from pyarrow import Array, DataType, Schema, Table

    from firstcontact.result import Json

GROUP = 1 << 16
"""Rows of a row group, but for the last one: parts that are smaller are put together."""


def writer(path: Path, kept: Schema) -> Callable[[Path, Iterator[Table]], None]:
    """What writes tables to a file of the kind that the name tells.  kept: the schema of what is carried along."""
    write = WRITERS.get(path.suffix.lower())
    if write is None:
        raise InputError(f"{path}: answers go to files that end with {', '.join(WRITERS)}")
    if write is _csv:
        nested = next((field.name for field in kept if _is_nested(field.type)), None)
        if nested is not None:
            raise InputError(f"{path}: column {nested} holds lists, which CSV has not; choose .parquet")
    return write


def _is_nested(kind: DataType) -> bool:
    return bool(pyarrow().types.is_nested(kind))


def _parquet(path: Path, tables: Iterator[Table]) -> None:
    pa, pq = pyarrow(), pyarrow("parquet")
    first = next(tables)
    held, n = [first], len(first)
    with pq.ParquetWriter(path, first.schema) as file:
        for table in tables:
            if n >= GROUP:
                file.write_table(pa.concat_tables(held), row_group_size=GROUP)
                held, n = [], 0
            held.append(table)
            n += len(table)
        file.write_table(pa.concat_tables(held), row_group_size=GROUP)


def _csv(path: Path, tables: Iterator[Table]) -> None:
    csv = pyarrow("csv")
    first = _plain(next(tables))
    with csv.CSVWriter(path, first.schema) as file:
        file.write_table(first)
        for table in tables:
            file.write_table(_plain(table))


def _plain(table: Table) -> Table:
    """Without dictionaries."""
    pa = pyarrow()
    plain = [(f.name, f.type.value_type if pa.types.is_dictionary(f.type) else f.type) for f in table.schema]
    return table.cast(pa.schema(plain))


def _json_lines(path: Path, tables: Iterator[Table]) -> None:
    """A line for each row; numbers that JSON has not are texts, as `to_dict` of a result has them."""
    pc = pyarrow("compute")
    with path.open("w", encoding="utf-8") as file:
        for table in tables:
            pieces: list[str | Array] = []
            for name, column in zip(table.column_names, table.columns, strict=True):
                pieces += [f"{', ' if pieces else '{'}{json.dumps(name)}: ", _written(column.combine_chunks())]
            lines = pc.binary_join_element_wise(*pieces, "}\n", "")
            file.writelines(lines.to_pylist())


def _written(column: Array) -> Array:
    """The values as JSON has them."""
    pa, pc = pyarrow(), pyarrow("compute")
    kind = column.type
    if pa.types.is_floating(kind):
        plain = pc.replace_substring_regex(column.cast(pa.string()), r"^(-?\d+)$", r"\1.0")
        infinite = pc.if_else(pc.less(column, 0.0), '"-inf"', '"inf"')
        texts = pc.if_else(pc.is_inf(column), infinite, pc.if_else(pc.is_nan(column), "null", plain))
    elif pa.types.is_integer(kind):
        texts = column.cast(pa.string())
    elif _is_nested(kind):
        texts = pa.array([_dumped(x) for x in column.to_pylist()], pa.string())
    else:  # each word once
        words = column if pa.types.is_dictionary(kind) else column.dictionary_encode()
        texts = pa.array([_dumped(x) for x in words.dictionary.to_pylist()], pa.string()).take(words.indices)
    return pc.fill_null(texts, "null")


def _dumped(value: Json) -> str:
    return json.dumps(value, default=str)


WRITERS: dict[str, Callable[[Path, Iterator[Table]], None]] = {
    ".parquet": _parquet,
    ".csv": _csv,
    ".jsonl": _json_lines,
}
