"""Tables as pyarrow has them (extra batch).

A vector is three columns, `point_x`, `point_y`, `point_z`: any tool sorts, sums and writes them, CSV included.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.errors import InputError
from firstcontact.result_table import INTERVAL, ROW, WORDS, IntervalRows, Rows

if TYPE_CHECKING:
    from types import ModuleType

    from pandas import DataFrame
    from pyarrow import Array, Table

XYZ = "x", "y", "z"
ERROR = "error"


def pyarrow(part: str = "") -> ModuleType:
    """The package, or a module of it."""
    return module(f"pyarrow{part and '.'}{part}")


def module(name: str) -> ModuleType:
    """One that the extra batch brings.  InputError says what to install."""
    try:
        return import_module(name)
    except ImportError as error:
        what = name.partition(".")[0]
        how = "pip install 'firstcontact[batch]', or '.[batch]' in a checkout"
        raise InputError(f"tables of batches need {what}: {how}") from error


def columns_of(name: str) -> list[str]:
    """The names of the columns of one of ROW."""
    return [f"{name}_{x}" for x in XYZ] if ROW[name].shape else [name]


def answer_columns() -> list[str]:
    """The names of the columns of `table_of`."""
    return [*(key for name in ROW.names or () if name != ERROR for key in columns_of(name)), ERROR]


def table_of(rows: Rows) -> Table:
    """A pyarrow.Table of settled rows: their columns, nulls for what is not there, words as dictionaries.

    Contact intervals stand in one more column, a list of structures for each row.
    """
    pa = pyarrow()
    table: dict[str, Array] = {}
    for name in rows.dtype.names or ():
        if name != ERROR:
            values = rows.array[name]
            parts = values.T if values.ndim > 1 else [values]
            names = columns_of(name) if values.ndim > 1 else [name]
            table |= {key: _array(pa, name, x) for key, x in zip(names, parts, strict=True)}
    if isinstance(rows, IntervalRows):
        table["intervals"] = _intervals(pa, rows)
    texts: list[str | None] = [None] * len(rows)
    for row, text in rows.errors.items():
        texts[row] = text
    return pa.table({**table, ERROR: pa.array(texts, pa.string())})


def _array(pa: ModuleType, name: str, values: np.ndarray) -> Array:
    if name in WORDS:
        words = values.astype(np.int8) - np.int8(1)
        return pa.DictionaryArray.from_arrays(pa.array(words, mask=values == 0), pa.array(WORDS[name][1:]))
    missing = np.isnan(values) if values.dtype.kind == "f" else values < 0
    return pa.array(np.ascontiguousarray(values), mask=missing)


def _intervals(pa: ModuleType, rows: IntervalRows) -> Array:
    found = np.concatenate([np.empty((0, 6)), *(rows.found[row] for row in sorted(rows.found))])
    names = [name for name in INTERVAL.names or () if name != "question"]
    values = pa.StructArray.from_arrays([pa.array(np.ascontiguousarray(x)) for x in found.T], names)
    ends = np.concatenate([[0], np.cumsum(rows.array["count"])]).astype(np.int32)
    return pa.ListArray.from_arrays(pa.array(ends), values)


def frame_of(rows: Rows) -> DataFrame:
    """A pandas.DataFrame: words are categories, whole numbers stay whole beside missing ones."""
    pd, pa = module("pandas"), pyarrow()
    return table_of(rows).to_pandas(types_mapper={pa.int32(): pd.Int32Dtype(), pa.int64(): pd.Int64Dtype()}.get)


def write_parquet(rows: Rows, path: str | Path) -> None:
    """A Parquet file of settled rows."""
    pyarrow("parquet").write_table(table_of(rows), path)
