"""What `first_contacts` answers: one row for each question, in columns."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Generic, NoReturn, Self, TypeVar

import numpy as np

from firstcontact.errors import InputError
from firstcontact.result import ContactIntervals, Element, FirstContact, Status

if TYPE_CHECKING:
    from pathlib import Path

    import pandas
    import pyarrow

ROW = np.dtype([
    ("status", "u1"), ("initial", "u1"), ("reason", "u1"), ("kind_a", "u1"), ("kind_b", "u1"), ("error", "?"),
    ("index_a", "i4"), ("index_b", "i4"), ("multiplicity", "i4"), ("work", "i8"),
    ("time", "f8"), ("lo", "f8"), ("hi", "f8"), ("free_until", "f8"), ("point", "f8", 3), ("normal", "f8", 3),
])  # fmt: skip
"""A row: numbers of words in the lists below, nan for what is not known, -1 for no element."""
STATUSES = ("", *(status.name for status in Status))
INITIALS = ("", "touching", "overlapping", "containment")
REASONS = ("", "budget", "precision", "memory")
KINDS = ("", "vertex", "edge", "face", "apex", "directrix", "end_ruling")
WORDS = {"status": STATUSES, "initial": INITIALS, "reason": REASONS, "kind_a": KINDS, "kind_b": KINDS}
MOST_HELD = 10_000
"""Results that a table holds until it is asked for their places: a few kilobytes each."""
PLACED = "kind_a", "kind_b", "index_a", "index_b", "multiplicity", "point", "normal"
"""Columns of contacts that are worked out when one of them is first asked for."""


INTERVAL_ROW = np.dtype([
    ("status", "u1"), ("reason", "u1"), ("error", "?"), ("count", "i4"), ("work", "i8"), ("free_until", "f8"),
])  # fmt: skip
"""Of contact intervals: how many there are; they stand beside the rows."""
INTERVAL = np.dtype([
    ("question", "i8"), ("start", "f8"), ("end", "f8"),
    ("start_lo", "f8"), ("start_hi", "f8"), ("end_lo", "f8"), ("end_hi", "f8"),
])  # fmt: skip


class Rows:
    """Rows with what goes beside them: texts of errors, and work that is put off until it is asked for."""

    dtype = ROW

    def __init__(self, n: int, cleared: bool = True) -> None:
        """cleared: rows of which nothing is known; else what is there is arbitrary until `clear`."""
        self.array = np.empty(n, self.dtype)
        self.errors: dict[int, str] = {}
        self.later: list[Callable[[], None]] = []
        """Each fills the columns PLACED of some contacts."""
        if cleared:
            self.clear()

    def clear(self) -> None:
        """Nothing is known of any row."""
        row = np.zeros(1, self.dtype)
        for name in row.dtype.names or ():
            if row.dtype[name].base.kind == "f":
                row[name] = np.nan
            elif name.startswith("index"):
                row[name] = -1
        whole = np.dtype((np.void, self.dtype.itemsize))  # row by row, not field by field
        self.array.view(whole)[:] = row.view(whole)

    def __len__(self) -> int:
        return len(self.array)

    def part(self, where: slice) -> Self:
        """Some rows in the same memory, without errors of their own."""
        rows = object.__new__(type(self))
        rows.array, rows.errors, rows.later = self.array[where], {}, self.later
        return rows

    def free(self, where: np.ndarray, ends: np.ndarray) -> None:
        """The rows `where` are proved free until the ends of their spans."""
        self.array["status"][where] = STATUSES.index("FREE")
        self.array["free_until"][where] = ends

    def fill(self, row: int, found: FirstContact | ContactIntervals) -> None:
        """Write one answer into its row; where it is waits, of some, until it is asked for."""
        assert isinstance(found, FirstContact)
        record = self.array[row]
        self._fill_shared(record, found)
        record["initial"] = INITIALS.index(found.initial or "")
        if found.time is not None:
            record["time"] = found.time
        if found.time_interval is not None:
            record["lo"], record["hi"] = found.time_interval
        place = partial(_fill_found, record, found)
        if len(self.later) < MOST_HELD:
            self.later.append(place)
        else:
            place()

    @staticmethod
    def _fill_shared(record: np.void, found: FirstContact | ContactIntervals) -> None:
        record["status"], record["reason"] = STATUSES.index(found.status.name), REASONS.index(found.reason or "")
        record["work"] = found.stats.node_visits + found.stats.pair_tests
        if found.free_until is not None:
            record["free_until"] = found.free_until

    def refuse(self, row: int, error: str) -> None:
        """The question of that row has no answer but this error."""
        self.part(slice(row, row + 1)).clear()
        self.array["error"][row] = True
        self.errors[row] = error

    def settle(self) -> Self:
        """Fill in what was put off."""
        while self.later:
            self.later[-1]()
            self.later.pop()
        return self

    def __eq__(self, other: object) -> bool:
        """Of settled rows."""
        if not isinstance(other, Rows) or type(self) is not type(other):
            return NotImplemented
        names = [name for name in self.dtype.names or () if name != "work"]
        columns = ((self.array[name], other.array[name]) for name in names)
        return self.errors == other.errors and all(np.array_equal(x, y, equal_nan=True) for x, y in columns)

    __hash__ = None  # type: ignore[assignment] # they are filled

    def put(self, where: np.ndarray, rows: Self) -> None:
        """Take over settled answers to the questions `where`."""
        assert not rows.later
        self.array[where] = rows.array
        self.errors |= {int(where[row]): text for row, text in rows.errors.items()}


def fill_place(
    record: np.void,
    elements: tuple[Element | None, Element | None],
    multiplicity: int,
    point: np.ndarray | None,
    normal: np.ndarray | None,
) -> None:
    """Write the columns PLACED of a row."""
    record["multiplicity"] = multiplicity
    for side, element in zip("ab", elements, strict=True):
        if element is not None:
            record[f"kind_{side}"], record[f"index_{side}"] = KINDS.index(element.kind), element.index
    for name, vector in (("point", point), ("normal", normal)):
        if vector is not None:
            record[name] = vector


def _fill_found(record: np.void, found: FirstContact) -> None:
    fill_place(record, (found.element_a, found.element_b), found.multiplicity, found.point, found.normal)


class IntervalRows(Rows):
    """Rows of contact intervals; `found` has those of each question that has any, (k, 6) in the columns of INTERVAL."""

    dtype = INTERVAL_ROW

    def __init__(self, n: int, cleared: bool = True) -> None:
        super().__init__(n, cleared)
        self.found: dict[int, np.ndarray] = {}

    def fill(self, row: int, found: FirstContact | ContactIntervals) -> None:
        assert isinstance(found, ContactIntervals)
        self._fill_shared(self.array[row], found)
        self.array["count"][row] = len(found)
        if len(found):
            self.found[row] = np.array([(x.start, x.end, *x.start_interval, *x.end_interval) for x in found])

    def __eq__(self, other: object) -> bool:
        alike = super().__eq__(other)
        if alike is not True:
            return alike
        assert isinstance(other, IntervalRows)
        return all(np.array_equal(x, other.found[row]) for row, x in self.found.items())

    __hash__ = None

    def put(self, where: np.ndarray, rows: Self) -> None:
        super().put(where, rows)
        self.found |= {int(where[row]): found for row, found in rows.found.items()}


R = TypeVar("R", bound=Rows)
A = TypeVar("A")


def _from_pickle(kind: type[_Table[R, A]], rows: R) -> _Table[R, A]:
    """A table without its questions, whose bodies would be most of it."""
    return kind(rows, _unasked)


def _unasked(row: int) -> NoReturn:
    raise InputError(f"a table from a pickle holds columns alone; ask question {row} again for its full result")


class _Table(Generic[R, A]):
    """What tables have in common."""

    __slots__ = ("_ask", "_rows")

    def __init__(self, rows: R, ask: Callable[[int], A]) -> None:
        """ask: answers one of the questions again."""
        self._rows, self._ask = rows, ask

    def __reduce__(self) -> tuple[object, ...]:
        return _from_pickle, (type(self), self._rows.settle())

    def __eq__(self, other: object) -> bool:
        """By the columns but for the work: the questions may be others."""
        if not isinstance(other, _Table) or type(self) is not type(other):
            return NotImplemented
        return bool(self._rows.settle() == other._rows.settle())

    def __hash__(self) -> int:
        return hash((type(self), len(self)))

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, row: int) -> A:
        """The full result of one question: asked again, so that a table holds numbers only.

        Raises what the question raised.
        """
        if not isinstance(row, int | np.integer):
            raise TypeError(f"question {row!r}; questions are counted from 0, columns are attributes")
        if not -len(self) <= row < len(self):
            raise IndexError(f"question {row} of {len(self)}")
        return self._ask(int(row) % len(self))

    def __iter__(self) -> Iterator[A]:
        return (self._ask(row) for row in range(len(self)))

    def column(self, name: str) -> np.ndarray:
        """One of the columns, as NumPy has them; do not write into it."""
        names = self._rows.dtype.names or ()
        if name == "error":
            texts = np.full(len(self), None, object)
            for row, text in self._rows.errors.items():
                texts[row] = text
            return texts
        if name not in names:
            raise InputError(f"no column {name!r}; there are {', '.join(names)}")
        if name in PLACED:
            self._rows.settle()
        column: np.ndarray = self._rows.array[name]
        return np.array(WORDS[name])[column] if name in WORDS else column

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> np.ndarray:
            if name.startswith("_") or name not in self._rows.dtype.names:
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            return self.column(name)

    @property
    def counts(self) -> dict[str, int]:
        """How many questions ended how; those without an answer are counted as "error"."""
        found = np.bincount(self._rows.array["status"], minlength=len(STATUSES)).tolist()
        return {name or "error": n for name, n in zip(STATUSES, found, strict=True) if n}

    def to_numpy(self) -> np.ndarray:
        """A structured array, with words for statuses, kinds and reasons; errors are left out."""
        columns = {name: self.column(name) for name in self._rows.dtype.names or () if name != "error"}
        dtype = np.dtype([(name, x.dtype, x.shape[1:]) for name, x in columns.items()])
        table = np.empty(len(self), dtype)
        for name, x in columns.items():
            table[name] = x
        return table

    def to_arrow(self) -> pyarrow.Table:
        """A pyarrow.Table (extra batch): nan, "" and -1 are nulls, words are dictionaries, vectors three columns."""
        from firstcontact.batch.arrow import table_of

        return table_of(self._rows.settle())

    def to_pandas(self) -> pandas.DataFrame:
        """A pandas.DataFrame of the same columns (extra batch)."""
        from firstcontact.batch.arrow import frame_of

        return frame_of(self._rows.settle())

    def to_parquet(self, path: str | Path) -> None:
        """Write a Parquet file (extra batch)."""
        from firstcontact.batch.arrow import write_parquet

        write_parquet(self._rows.settle(), path)

    def __repr__(self) -> str:
        told = ", ".join(f"{n} {name}" for name, n in self.counts.items())
        return f"<{type(self).__name__} of {len(self)}: {told}>"

    def __str__(self) -> str:
        lines = [f"{len(self)} questions: " + ", ".join(f"{n} {name}" for name, n in self.counts.items())]
        lines += self._first()
        lines += [f"  question {row}: {text}" for row, text in list(self._rows.errors.items())[:3]]
        return "\n".join(lines)

    def _first(self) -> list[str]:
        return []


class ContactTable(_Table[Rows, FirstContact]):
    """The first contact of each question, in columns; `table[i]` is the full result of question i.

    status         FREE, CONTACT, INITIAL_CONTACT, UNDECIDED; "" where `error` says why there is no answer
    time, lo, hi   the double nearest the time of contact, and its enclosure; nan where there is none
    free_until     no shared point before this time; proved
    point, normal  (n, 3), world; nan where there are none
    kind_a, index_a, kind_b, index_b   the elements that meet: "vertex", "edge", "face" and its number, -1: none
    multiplicity   pairs of elements that meet at that time
    initial, reason   of INITIAL_CONTACT and UNDECIDED
    work           node visits and pair tests; 0 where boxes alone told that bodies are apart
    error          (n,) texts, None where there is an answer
    """

    __slots__ = ()

    def _first(self) -> list[str]:
        times = self._rows.array["time"]
        if not np.isfinite(times).any():
            return []
        row = int(np.nanargmin(times))
        return [f"  first: question {row} at time {float(times[row])!r}"]


class ContactIntervalTable(_Table[IntervalRows, ContactIntervals]):
    """The contact intervals of each question, in columns; `table[i]` is the full result of question i.

    status, free_until, reason, work, error   as in ContactTable, of the intervals of the question
    count       how many there are
    intervals   all of them, a structured array in the order of the questions: question, start, end, start_lo, start_hi,
                end_lo, end_hi
    """

    __slots__ = ()

    @property
    def intervals(self) -> np.ndarray:
        rows = self._rows
        table = np.empty(int(rows.array["count"].sum()), INTERVAL)
        table["question"] = np.repeat(np.arange(len(self)), rows.array["count"])
        found = [rows.found[row] for row in sorted(rows.found)]
        values = np.concatenate(found) if found else np.empty((0, 6))
        for k, name in enumerate((INTERVAL.names or ())[1:]):
            table[name] = values[:, k]
        return table
