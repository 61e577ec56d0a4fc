"""Tables as pyarrow has them (extra batch)."""

from __future__ import annotations

from typing import Any

from firstcontact.result_table import Rows


def table_of(rows: Rows) -> Any:
    raise NotImplementedError


def write_parquet(rows: Rows, path: Any) -> None:
    raise NotImplementedError
