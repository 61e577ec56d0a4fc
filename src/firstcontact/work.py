"""What was asked, how much work may be done for it, and how much has been done."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np
from flint import fmpq

from firstcontact.exact.numbers import below, exact_value, to_double
from firstcontact.result import Stats

if TYPE_CHECKING:
    from fractions import Fraction

    from firstcontact.body.kinds import Body


Progress = Callable[[float, int], None]
"""Called with the time before which all is proved, and how much was done."""


# Largest budget: more than any run reaches; sums of it stay within the 64 bits in which the kernels count.
MOST_BUDGET = 2**60


# Node visits, or boxes of a search in doubles, that take as long as one look in balls, for which budgets count it.
WORTH = 64

# What tables that grow while a question is answered may take, in bytes: a process stays below 2 GB.
MOST_BYTES = 3 * 2**29


def may_grow(*tables: np.ndarray, by: int = 2) -> bool:
    """Whether arrays may become so many times as long: the old ones stand beside the new ones meanwhile."""
    size: int = sum(table.nbytes for table in tables)
    return (1 + by) * size <= MOST_BYTES


class Spent(Exception):
    """The budget is used up."""


class NoMemory(Exception):
    """A table may not grow any more."""


def doubled(*tables: np.ndarray) -> tuple[np.ndarray, ...]:
    """The tables with as much room again.  Raises NoMemory."""
    if not may_grow(*tables):
        raise NoMemory
    return tuple(np.concatenate([table, np.empty_like(table)]) for table in tables)


@dataclass
class Work:
    """budget: subproblems and candidates at most, None without end; progress: called with (free_until, done)."""

    budget: int | None = None
    progress: Progress | None = None
    free_until: float = 0.0
    done: int = 0

    @property
    def left(self) -> int | None:
        """What is left of the budget."""
        return None if self.budget is None else max(0, self.budget - self.done)

    def reached(self, time: float) -> None:
        """Tell that all before the time is free, or known."""
        self.free_until = time
        if self.progress is not None:
            self.progress(self.free_until, self.done)

    def allowed(self, most: int) -> int:
        """How much of that the budget allows."""
        return most if self.budget is None else min(most, max(self.budget - self.done, 0))

    def step(self, count: int = 1) -> None:
        """Count a subproblem or candidate, or one as large as more, before it is taken up.  Raises Spent."""
        if self.budget is not None and self.done + count > self.budget:
            raise Spent
        self.done += count
        if self.progress is not None:
            self.progress(self.free_until, self.done)


class Arguments(TypedDict, total=False):
    """What verbs take beside the bodies and the span of a question."""

    exact: bool
    method: str
    tolerance: float
    budget: int | None
    progress: Progress | None


class FirstArguments(Arguments, total=False):
    """What `first_contact` takes."""

    engine: str
    threads: int


class CheckArguments(Arguments, total=False):
    """What a check of a scene says, its span with it."""

    span: Sequence[float | Fraction] | None


class QuestionFields(TypedDict):
    """What every result says of its question."""

    a: Body
    b: Body
    span: tuple[float, float]


@dataclass(frozen=True)
class Query:
    """Two bodies, at rest or moving, over the closed span [first, last]; a sub-question is `replace(query, ...)`.

    last: None without end.  exact, method, engine, tolerance, budget, progress, threads: as
    `firstcontact.first_contact` has them.  begin: when it was asked, by `time.perf_counter`.
    enough: UNDECIDED will do where all is proved free up to then; None: nowhere.
    """

    a: Any
    b: Any
    first: fmpq
    last: fmpq | None
    exact: bool = False
    method: str = "auto"
    engine: str = "auto"
    tolerance: float = 1e-12
    budget: int | None = None
    progress: Progress | None = None
    threads: int = 1
    begin: float = field(default_factory=clock.perf_counter)
    enough: fmpq | None = None

    @property
    def span(self) -> tuple[float, float]:
        """The span in doubles."""
        return to_double(self.first), float("inf") if self.last is None else to_double(self.last)

    @property
    def end(self) -> fmpq:
        """`last`, of a query that has an end."""
        assert self.last is not None
        return self.last

    @property
    def bodies(self) -> tuple[Body, Body]:
        return self.a, self.b

    @property
    def shared(self) -> QuestionFields:
        """What every result says of its question."""
        return {"a": self.a, "b": self.b, "span": self.span}

    @property
    def is_algebraic(self) -> bool:
        """Whether only exact arithmetic may answer."""
        return self.exact or self.method == "algebraic"

    @property
    def is_certified(self) -> bool:
        """Whether only doubles may answer."""
        return not self.exact and self.method == "certified"

    @property
    def is_auto(self) -> bool:
        """Whether any way may answer."""
        return not self.exact and self.method == "auto"

    def budget_after(self, done: Stats) -> int | None:
        """What such work leaves of the budget."""
        return None if self.budget is None else max(self.budget - done.node_visits - done.pair_tests, 0)

    def tolerance_within(self, first: fmpq, last: fmpq) -> float:
        """The tolerance of a part of the span whose answer is to be as close in time as that to the whole."""
        return self.tolerance * to_double((self.end - self.first) / (last - first)) if last > first else self.tolerance

    def part(self, first: fmpq, last: fmpq) -> Query:
        """The question about a part of the span, whose answer is as close in time."""
        return replace(self, first=first, last=last, tolerance=self.tolerance_within(first, last))

    @property
    def at_start(self) -> Query:
        """The question about the start alone, however long that takes."""
        return replace(self, last=self.first, budget=None, progress=None)

    def is_enough(self, free_until: float) -> bool:
        """Whether it does not matter what is proved of later times."""
        return self.enough is not None and exact_value(free_until) >= self.enough

    def limited(self, budget: int) -> Query:
        """With that budget where the caller gave none."""
        return self if self.budget is not None else replace(self, budget=budget)

    def is_spent(self, reason: str | None) -> bool:
        """Whether what stopped a search is the caller's budget, not one of its own: then no other way goes on."""
        return reason == "budget" and self.budget is not None

    def work(self) -> Work:
        """A new account of the work, with all of the budget."""
        return Work(self.budget, self.progress, below(self.first) if self.first else 0.0)

    def stats(self, node_visits: int = 0, pair_tests: int = 0, exact_evaluations: int = 0) -> Stats:
        """The work done, and the time since the question was asked."""
        return Stats(node_visits, pair_tests, 0, exact_evaluations, clock.perf_counter() - self.begin)
