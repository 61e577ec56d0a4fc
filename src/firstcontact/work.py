"""How much exact work a query has done, whom to tell, and where to stop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

Progress = Callable[[float, int], None]
"""Called with the time before which all is proved, and how much was done."""


class Spent(Exception):
    """The budget is used up."""


@dataclass
class Work:
    """budget: subproblems and candidates at most, None without end; progress: called with (free_until, done)."""

    budget: int | None = None
    progress: Progress | None = None
    free_until: float = 0.0
    done: int = 0

    def reached(self, time: float) -> None:
        """Tell that all before the time is free, or known."""
        self.free_until = time
        if self.progress is not None:
            self.progress(self.free_until, self.done)

    def step(self) -> None:
        """Count one subproblem or candidate before it is taken up.  Raises Spent."""
        if self.budget is not None and self.done >= self.budget:
            raise Spent
        self.done += 1
        if self.progress is not None:
            self.progress(self.free_until, self.done)
