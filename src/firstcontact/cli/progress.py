"""A line on stderr that tells, when the work takes long, how far it is; results that are printed as they come."""

from __future__ import annotations

import math
import shutil
import sys
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Self

from firstcontact.cli.outputs import tell

# Seconds of work before the line appears: shorter runs stay silent.
PATIENCE = 0.5
# Seconds between two looks of the line on a terminal, and between two lines in a log.
TICK, LOG_TICK = 0.2, 10.0
# Share of the work from which on it tells how long the rest may take.
TELLING = 0.02
ERASE = "\r\x1b[2K"


class Progress:
    """Context for `total` checks; `report` is the verbs' progress callback.

    say: prints a line on standard output.  wanted: True shows the line, False never does, None does when stderr is a
    terminal.  A thread shows it, so that it goes on where a search reports nothing.
    """

    def __init__(self, wanted: bool | None, total: int, say: Callable[[str], object]) -> None:
        self._say = say
        self._on_terminal = sys.stderr is not None and sys.stderr.isatty()
        self._wanted = self._on_terminal if wanted is None else wanted
        self._total = total
        self._begun = 0
        self._since = time.monotonic()
        self._label, self._span = "", (0.0, math.inf)
        self._proved: float | None = None
        self._work = 0
        self._ended = threading.Event()
        self._writing = threading.Lock()
        self._shown = False
        self._ticker = threading.Thread(target=self._tick, daemon=True)

    def start(self, label: str, span: tuple[float, float] = (0.0, math.inf), number: int | None = None) -> None:
        """A check begins, over that span of time; number: which of all, from 1, default: the next."""
        self._begun = self._begun + 1 if number is None else number
        self._proved, self._work, self._span = None, 0, span
        self._label = label if self._total == 1 else f"{label} ({self._begun} of {self._total})"

    def report(self, free_until: float | None, work: int) -> None:
        """Called by a verb now and then: proved free so far, units of work done."""
        self._proved = free_until if free_until is not None and math.isfinite(free_until) else None
        self._work = work

    def say(self, text: str) -> None:
        """Print a result, out of the line's way."""
        with self._writing:
            self._erase()
            self._say(text)

    @property
    def state(self) -> str:
        """What is known of the check at work."""
        proved = "searching" if self._proved is None else f"free until {self._proved:.6g}"
        return f"{self._label}: {proved}, {self._work:,} steps" if self._work else self._label

    def _line(self) -> str:
        spent = time.monotonic() - self._since
        share = (self._begun - 1 + self._share()) / self._total
        left = f", about {_duration(spent * (1 - share) / share)} left" if TELLING < share < 1 else ""
        return f"{self.state}; {_duration(spent)}{left}"

    def _share(self) -> float:
        """How much of the present check's span is proved."""
        first, last = self._span
        if self._proved is None or not math.isfinite(last - first) or last <= first:
            return 0.0
        return min(max((self._proved - first) / (last - first), 0.0), 1.0)

    def _tick(self) -> None:
        wait = PATIENCE
        while not self._ended.wait(wait):
            self._show()
            wait = TICK if self._on_terminal else LOG_TICK

    def _show(self) -> None:
        with self._writing:
            self._erase()
            line = self._line()
            if self._on_terminal:
                line = line[: shutil.get_terminal_size().columns - 1]
            tell(line, "" if self._on_terminal else "\n")
            self._shown = self._on_terminal

    def _erase(self) -> None:
        if self._shown:
            tell(ERASE, "")
            self._shown = False

    def __enter__(self) -> Self:
        if self._wanted:
            self._ticker.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ended.set()
        if self._wanted:
            self._ticker.join()
            if not self._on_terminal and time.monotonic() - self._since >= PATIENCE:
                self._show()  # a log ends with how far it came
        self._erase()


class RowsProgress(Progress):
    """The same for the rows of a file; `rows` is the callback of a job."""

    def __init__(self, wanted: bool | None, label: str, say: Callable[[str], object]) -> None:
        super().__init__(wanted, 1, say)
        self.start(label)
        self._at: tuple[int, int] | None = None
        self._first = 0

    def rows(self, done: int, total: int) -> None:
        """So many of all rows are answered."""
        if self._at is None:  # what was kept, if anything, has cost nothing now
            self._since, self._first = time.monotonic(), done
        self._at = done, total

    @property
    def state(self) -> str:
        """How far it is."""
        if self._at is None:
            return f"{self._label}: looking through it"
        done, total = self._at
        return f"{self._label}: {done:,} of {total:,}"

    def _line(self) -> str:
        spent = time.monotonic() - self._since
        if self._at is None or self._at[0] == self._first or not spent:
            return f"{self.state}; {_duration(spent)}"
        done, total = self._at
        rate = (done - self._first) / spent
        left = f", about {_duration((total - done) / rate)} left" if done < total else ""
        return f"{self.state}, {rate:,.3g} a second; {_duration(spent)}{left}"


def _duration(seconds: float) -> str:
    """In words as short as they are useful.

    >>> _duration(4.2), _duration(75), _duration(7300)
    ('4 s', '1 min 15 s', '2 h 1 min')
    """
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    return f"{whole // 60} min {whole % 60} s" if whole < 3600 else f"{whole // 3600} h {whole % 3600 // 60} min"
