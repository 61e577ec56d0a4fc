"""Answers as rows: CSV and JSON lines, written as they come."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from firstcontact.cli.outputs import Put, Writing

if TYPE_CHECKING:
    from firstcontact.result import ContactIntervals, FirstContact, Json
    from firstcontact.view.pair import Result

COLUMNS = (
    "a", "b", "status", "time", "time_lo", "time_hi", "x", "y", "z", "nx", "ny", "nz", "element_a", "element_b",
    "initial", "allowed", "free_until", "reason", "moved",
)  # fmt: skip
INTERVAL_COLUMNS = ("a", "b", "status", "start", "end", "free_until", "reason")

More = Mapping[str, Callable[[Any], Any]]
"""Further columns by their names, and what a result says there."""


def row(result: Result, more: More) -> dict[str, Json]:
    """A result as "checks" in the JSON output has it."""
    from firstcontact.result import finite

    told = {key: x for key, x in finite(result.to_dict()).items() if key != "schema"}
    return told | {key: of(result) for key, of in more.items()}


def json_lines(more: More) -> Callable[[Writing], Put]:
    """One object a line."""

    def make(file: Writing) -> Put:
        def put(result: Result) -> None:
            file.write(json.dumps(row(result, more)) + "\n")
            file.flush()

        return put

    return make


def comma_separated(unit: str, more: More) -> Callable[[Writing], Put]:
    """A head of columns, then one row for each first contact, or for each interval; lengths in that unit.

    more: of first contacts.
    """

    from firstcontact.result import ContactIntervals

    def make(file: Writing) -> Put:
        writer = csv.writer(file, lineterminator="\n")
        begun = False

        def put(result: FirstContact | ContactIntervals) -> None:
            nonlocal begun
            of_intervals = isinstance(result, ContactIntervals)
            if not begun:
                writer.writerow(INTERVAL_COLUMNS if of_intervals else (*COLUMNS, *more))
                begun = True
            if isinstance(result, ContactIntervals):
                writer.writerows(_interval_rows(result))
            else:
                writer.writerow([*_row(result, unit), *(of(result) for of in more.values())])
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


def _interval_rows(x: ContactIntervals) -> list[list[str | float | None]]:
    ends: list[tuple[float | None, float | None]] = [(i.start, i.end) for i in x] or [(None, None)]
    return [[x.a.name, x.b.name, x.status.name, *end, x.free_until, x.reason] for end in ends]
