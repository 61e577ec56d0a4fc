"""Answers to a part of the questions, in this process."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact import query
from firstcontact.batch.questions import Questions
from firstcontact.errors import FirstContactError
from firstcontact.result_table import IntervalRows, Rows
from firstcontact.work import FirstArguments

if TYPE_CHECKING:
    from firstcontact.work import Arguments


@dataclass(frozen=True)
class VerbCall:
    """The verb, "first_contact" or "contact_intervals", and its arguments beside the bodies and the span."""

    verb: str
    arguments: FirstArguments = field(default_factory=FirstArguments)

    @property
    def walks(self) -> bool:
        """Whether compiled walks may answer."""
        return self.verb == "first_contact" and self.arguments.get("engine", "auto") in ("auto", "boxes")

    def rows(self, n: int, cleared: bool = True) -> Rows:
        """Those of n answers, of which nothing is known; if not `cleared`, arbitrary ones."""
        return (Rows if self.verb == "first_contact" else IntervalRows)(n, cleared)

    @property
    def budget(self) -> int | None:
        return self.arguments.get("budget")

    def one(self, questions: Questions, row: int) -> Any:
        """The answer to one question."""
        a, b, span = questions[row]
        return getattr(query, self.verb)(a, b, span, **self.arguments)


def is_plain(arguments: Arguments) -> bool:
    """Whether bodies that are apart all the time are FREE, whatever else is asked.

    Other questions may be refused, or spend their budget, first.
    """
    chosen = {arguments.get(key, "auto") for key in ("method", "engine")}
    return chosen == {"auto"} and not arguments.get("exact") and arguments.get("budget") is None


def answers(questions: Questions, asking: VerbCall) -> Rows:
    """All answers."""
    rows = asking.rows(len(questions))
    left = np.ones(len(questions), bool)
    if asking.walks and len(questions):
        from firstcontact.batch.together import walk_together  # loads what polyhedra need

        left &= ~walk_together(questions, asking, rows)
    for row in np.flatnonzero(left).tolist():
        answer(questions, asking, row, rows)
    return rows


def answer(questions: Questions, asking: VerbCall, row: int, rows: Rows) -> None:
    """The answer to one question, or the error that it raises, into its row."""
    try:
        rows.fill(row, asking.one(questions, row))
    except FirstContactError as error:
        rows.refuse(row, str(error))
    except Exception as error:  # a fault of one question is no end of the others
        rows.refuse(row, f"{type(error).__name__}: {error}")
