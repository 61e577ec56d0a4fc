"""What `first_contacts` answers: one row for each question, in columns."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.errors import InputError
from firstcontact.result import FirstContact, Status

if TYPE_CHECKING:
    from pathlib import Path

ROW = np.dtype([
    ("status", "u1"), ("initial", "u1"), ("reason", "u1"), ("kind_a", "u1"), ("kind_b", "u1"), ("error", "?"),
    ("index_a", "i4"), ("index_b", "i4"), ("multiplicity", "i4"), ("work", "i8"),
    ("time", "f8"), ("lo", "f8"), ("hi", "f8"), ("free_until", "f8"), ("point", "f8", 3), ("normal", "f8", 3),
])  # fmt: skip
"""A row: numbers of words in the lists below, nan for what is not known, -1 for no element."""
STATUSES = ("", *(status.name for status in Status))
INITIALS = ("", "touching", "overlapping", "containment")
REASONS = ("", "budget", "precision")
KINDS = ("", "vertex", "edge", "face", "apex", "directrix", "end_ruling")
WORDS = {"status": STATUSES, "initial": INITIALS, "reason": REASONS, "kind_a": KINDS, "kind_b": KINDS}
PLACED = "kind_a", "kind_b", "index_a", "index_b", "multiplicity", "point", "normal"
"""Columns of contacts that are worked out when one of them is first asked for."""


def empty_rows(n: int) -> np.ndarray:
    """Rows of which nothing is known."""
    rows = np.zeros(n, ROW)
    for name in ("time", "lo", "hi", "free_until", "point", "normal"):
        rows[name] = np.nan
    rows["index_a"] = rows["index_b"] = -1
    return rows


def fill_row(row: Any, hit: FirstContact) -> None:
    """Write one answer into a row."""
    row["status"] = STATUSES.index(hit.status.name)
    row["initial"], row["reason"] = INITIALS.index(hit.initial or ""), REASONS.index(hit.reason or "")
    row["work"] = hit.stats.node_visits + hit.stats.pair_tests
    row["multiplicity"] = hit.multiplicity
    if hit.time is not None:
        row["time"] = hit.time
    if hit.time_interval is not None:
        row["lo"], row["hi"] = hit.time_interval
    if hit.free_until is not None:
        row["free_until"] = hit.free_until
    for name, element in (("a", hit.element_a), ("b", hit.element_b)):
        if element is not None:
            row[f"kind_{name}"], row[f"index_{name}"] = KINDS.index(element.kind), element.index
    for name, vector in (("point", hit.point), ("normal", hit.normal)):
        if vector is not None:
            row[name] = vector


class Rows:
    """Rows with what goes beside them: texts of errors, and work that is put off until it is asked for."""

    def __init__(self, n: int) -> None:
        self.array = empty_rows(n)
        self.errors: dict[int, str] = {}
        self.later: list[Callable[[], None]] = []
        """Each fills the columns PLACED of some contacts."""

    def __len__(self) -> int:
        return len(self.array)

    def part(self, where: slice) -> Rows:
        """Some rows in the same memory, without errors of their own."""
        rows = object.__new__(Rows)
        rows.array, rows.errors, rows.later = self.array[where], {}, self.later
        return rows

    def refuse(self, row: int, error: str) -> None:
        """The question of that row has no answer but this error."""
        self.array[row : row + 1] = empty_rows(1)
        self.array["error"][row] = True
        self.errors[row] = error

    def settle(self) -> Rows:
        """Fill in what was put off."""
        while self.later:
            self.later[-1]()
            self.later.pop()
        return self

    def put(self, where: np.ndarray, rows: Rows) -> None:
        """Take over settled answers to the questions `where`."""
        assert not rows.later
        self.array[where] = rows.array
        self.errors |= {int(where[row]): text for row, text in rows.errors.items()}


class ContactTable:
    """The first contact of each question, in columns; `table[i]` is the full result of question i.

    status         FREE, CONTACT, INITIAL_CONTACT, UNDECIDED; "" where `error` says why there is no answer
    time, lo, hi   the double nearest the time of contact, and its enclosure; nan where there is none
    free_until     no shared point before this time; proved
    point, normal  (n, 3), world; nan where there are none
    kind_a, index_a, kind_b, index_b   the elements that meet: "vertex", "edge", "face" and its number, -1: none
    multiplicity   pairs of elements that meet at that time
    initial, reason   of INITIAL_CONTACT and UNDECIDED
    work           node visits and pair tests
    error          (n,) texts, None where there is an answer
    """

    __slots__ = ("_ask", "_rows")

    def __init__(self, rows: Rows, ask: Callable[[int], FirstContact]) -> None:
        """ask: answers one of the questions again."""
        self._rows, self._ask = rows, ask

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, row: int) -> FirstContact:
        """The full result of one question: asked again, so that a table holds numbers only.

        Raises what the question raised.
        """
        if not -len(self) <= row < len(self):
            raise IndexError(f"question {row} of {len(self)}")
        return self._ask(int(row) % len(self))

    def __iter__(self) -> Iterator[FirstContact]:
        return (self._ask(row) for row in range(len(self)))

    def column(self, name: str) -> np.ndarray:
        """One of the columns, as NumPy has them; do not write into it."""
        if name == "error":
            texts = np.full(len(self), None, object)
            for row, text in self._rows.errors.items():
                texts[row] = text
            return texts
        if name not in (ROW.names or ()):
            raise InputError(f"no column {name!r}; there are {', '.join(ROW.names or ())}")
        if name in PLACED:
            self._rows.settle()
        column: np.ndarray = self._rows.array[name]
        return np.array(WORDS[name])[column] if name in WORDS else column

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> np.ndarray:
            if name not in ROW.names:
                raise AttributeError(f"'ContactTable' object has no attribute {name!r}")
            return self.column(name)

    @property
    def counts(self) -> dict[str, int]:
        """How many questions ended how; those without an answer are counted as "error"."""
        found = np.bincount(self._rows.array["status"], minlength=len(STATUSES)).tolist()
        return {name or "error": n for name, n in zip(STATUSES, found, strict=True) if n}

    def to_numpy(self) -> np.ndarray:
        """A structured array, with words for statuses, kinds and reasons; errors are left out."""
        names = [name for name in ROW.names or () if name != "error"]
        columns = {name: self.column(name) for name in names}
        dtype = np.dtype([(name, x.dtype, x.shape[1:]) for name, x in columns.items()])
        table = np.empty(len(self), dtype)
        for name, x in columns.items():
            table[name] = x
        return table

    def to_arrow(self) -> Any:
        """A pyarrow.Table (extra batch): nan, "" and -1 are nulls, words are dictionaries, vectors three columns."""
        from firstcontact.batch.arrow import table_of

        return table_of(self._rows.settle())

    def to_pandas(self) -> Any:
        """A pandas.DataFrame of the same columns (extra batch)."""
        from firstcontact.batch.arrow import frame_of

        return frame_of(self._rows.settle())

    def to_parquet(self, path: str | Path) -> None:
        """Write a Parquet file (extra batch)."""
        from firstcontact.batch.arrow import write_parquet

        write_parquet(self._rows.settle(), path)

    def __repr__(self) -> str:
        told = ", ".join(f"{n} {name}" for name, n in self.counts.items())
        return f"<ContactTable of {len(self)}: {told}>"

    def __str__(self) -> str:
        lines = [f"{len(self)} questions: " + ", ".join(f"{n} {name}" for name, n in self.counts.items())]
        times = self._rows.array["time"]
        if np.isfinite(times).any():
            row = int(np.nanargmin(times))
            lines.append(f"  first: question {row} at time {float(times[row])!r}")
        lines += [f"  question {row}: {text}" for row, text in list(self._rows.errors.items())[:3]]
        return "\n".join(lines)
