"""Answers as rows: CSV and JSON lines, written as they come."""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import IO, TYPE_CHECKING, Any

from firstcontact.errors import InputError

if TYPE_CHECKING:
    from firstcontact.result import FirstContact

COLUMNS = (
    "a", "b", "status", "time", "time_lo", "time_hi", "x", "y", "z", "nx", "ny", "nz", "element_a", "element_b",
    "initial", "allowed", "free_until", "reason", "moved",
)  # fmt: skip
INTERVAL_COLUMNS = ("a", "b", "status", "start", "end", "free_until", "reason")

Put = Callable[[Any], None]


@contextmanager
def written(target: str, make: Callable[[IO[str]], Put]) -> Iterator[Put]:
    """What takes results and writes them to a file, or to standard output for "-"."""
    if target == "-":
        yield make(sys.stdout)
        return
    try:
        file = open(target, "w", encoding="utf-8", newline="")
    except OSError as error:
        raise InputError(f"{target}: {(error.strerror or str(error)).lower()}; choose another file") from error
    with file:
        yield make(file)


def json_lines(file: IO[str]) -> Put:
    """One object a line, as "checks" in the JSON output has them."""
    from firstcontact.result import finite

    def put(result: Any) -> None:
        file.write(json.dumps({k: x for k, x in finite(result.to_dict()).items() if k != "schema"}) + "\n")
        file.flush()

    return put


def comma_separated(unit: str) -> Callable[[IO[str]], Put]:
    """A head of columns, then one row for each first contact, or for each interval; lengths in that unit."""

    def make(file: IO[str]) -> Put:
        writer = csv.writer(file, lineterminator="\n")
        begun = False

        def put(result: Any) -> None:
            nonlocal begun
            of_intervals = hasattr(result, "intervals")
            if not begun:
                writer.writerow(INTERVAL_COLUMNS if of_intervals else COLUMNS)
                begun = True
            writer.writerows(_interval_rows(result) if of_intervals else [_row(result, unit)])
            file.flush()

        return put

    return make


def _row(x: FirstContact, unit: str) -> list[str | float | None]:
    from firstcontact.assembly.words import progress

    none = [None] * 3
    elements = [None if e is None else str(e) for e in (x.element_a, x.element_b)]
    return [
        x.a.name, x.b.name, x.status.name, x.time, *(x.time_interval or (None, None)),
        *(none if x.point is None else x.point.tolist()), *(none if x.normal is None else x.normal.tolist()), *elements,
        x.initial, x.allowed, x.free_until, x.reason, progress(x, unit) if x.time is not None else None,
    ]  # fmt: skip


def _interval_rows(x: Any) -> list[list[Any]]:
    ends = [(i.start, i.end) for i in x] or [(None, None)]
    return [[x.a.name, x.b.name, x.status.name, *end, x.free_until, x.reason] for end in ends]
