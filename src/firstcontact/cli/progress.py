"""A progress line on stderr that appears only when the work takes long."""

from __future__ import annotations

import math
import sys
import threading
import time
from types import TracebackType
from typing import Any

# Seconds of work before the line appears: shorter runs stay silent, and never pay the import of rich.
PATIENCE = 0.5


class Progress:
    """Context for `total` checks; `report` is the verbs' progress callback.

    wanted: True shows it, False never does, None does when stderr is a terminal.
    """

    def __init__(self, wanted: bool | None, total: int) -> None:
        self._wanted = sys.stderr.isatty() if wanted is None else wanted
        self._total = total
        self._begun = 0
        self._since = time.monotonic()
        self._label = ""
        self._display: Any = None
        self._task: Any = None
        self._patience: threading.Timer | None = None

    def start(self, label: str) -> None:
        """The next check begins."""
        self._begun += 1
        self._label = label if self._total == 1 else f"{label} ({self._begun} of {self._total})"

    def report(self, free_until: float | None, work: int) -> None:
        """Called by a verb now and then: proved free so far, units of work done."""
        if not self._wanted or time.monotonic() - self._since < PATIENCE:
            return
        if self._display is None:
            self._open()
        known = free_until is not None and math.isfinite(free_until)
        proved = f"free until {free_until:.6g}" if known else "searching"
        description = f"{self._label}: {proved}, {work:,} steps"
        self._display.update(self._task, description=description, completed=self._begun - 1)

    def wait_for(self, label: str) -> None:
        """The next check begins, of which nothing is reported: only its name and the time are shown."""
        self.start(label)
        if self._display is not None:
            self._display.update(self._task, description=self._label, completed=self._begun - 1)
        elif self._wanted and self._patience is None:
            self._patience = threading.Timer(PATIENCE, self._open)
            self._patience.daemon = True
            self._patience.start()

    def _open(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
        from rich.progress import Progress as Display

        columns = (BarColumn(20), TextColumn("{task.description}"), TimeElapsedColumn())
        # Off a terminal rich prints the line once, at the end: someone asked for it in a log.
        self._display = Display(*columns, console=Console(stderr=True), transient=sys.stderr.isatty())
        self._task = self._display.add_task(self._label, total=self._total if self._total > 1 else None)
        self._display.start()

    def __enter__(self) -> Progress:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._patience is not None:
            self._patience.cancel()
            self._patience.join()  # it may be opening the display
        if self._display is not None:
            self._display.stop()
