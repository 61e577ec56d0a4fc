"""`first_contacts` and `many_contact_intervals`."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from firstcontact.batch import workers as work
from firstcontact.batch.part import VerbCall
from firstcontact.batch.questions import Questions, asked
from firstcontact.errors import InputError, shown
from firstcontact.query import check_arguments
from firstcontact.result_table import ContactIntervalTable, ContactTable, IntervalRows, Rows

if TYPE_CHECKING:
    from firstcontact.batch.questions import Queries
    from firstcontact.batch.workers import Executing, Reached
    from firstcontact.work import FirstArguments


def first_contacts(
    queries: Queries,
    *,
    workers: int | None = None,
    executor: Executing | None = None,
    exact: bool = False,
    method: str = "auto",
    engine: str = "auto",
    tolerance: float = 1e-12,
    budget: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> ContactTable:
    """ContactTable: the first contact of each of many questions, as `first_contact` answers them, bit for bit.

    The answers are the same in any order and for any number of workers.  Translations of one polyhedron before another
    are walked in compiled code, all of them in one call; so are rotations about one axis.  What one question raises
    stands in its row, in the column `error`.

    queries: pairs (a, b) or (a, b, span), one after the other; or one pair of which a body moves by an array of
    motions, `(a.moving(fc.Translations(vectors)), b)`, with fc.Rotations and fc.Poses likewise; or
    `fc.columns(bodies, pairs)`, a list of bodies and an array of two of their numbers for each question.
    workers: how many cores take part, default None: all of them.  Compiled walks share this process; where what is left
    would take seconds, processes are started for it.
    executor: a `concurrent.futures.Executor`, or a client of dask.distributed, that takes parts of the questions.
    exact, method, engine, tolerance, budget: of each question, as `first_contact` has them.  `table[i]` has its exact
    time with exact=True.
    progress: called with (answered, all) now and then; default None.

    >>> import firstcontact as fc
    >>> cube = fc.examples.box((1, 1, 1))
    >>> moving = cube.moving(fc.Translations([(4, 0, 0), (0, 4, 0), (8, 0, 0)]))
    >>> table = fc.first_contacts((moving, cube.translated((3, 0, 0))))
    >>> table.status.tolist(), table.time.tolist()
    (['CONTACT', 'FREE', 'CONTACT'], [0.5, nan, 0.25])
    >>> print(table[2].element_a)
    box vertex 4
    """
    check_arguments(method, engine, tolerance, budget)
    arguments: FirstArguments = {
        "exact": exact, "method": method, "engine": engine, "tolerance": tolerance, "budget": budget,
    }  # fmt: skip
    asking, questions = VerbCall("first_contact", arguments), asked(queries)
    rows = _rows(questions, asking, workers, executor, progress)
    return ContactTable(rows, lambda row: asking.one(questions, row))


def many_contact_intervals(
    queries: Queries,
    *,
    workers: int | None = None,
    executor: Executing | None = None,
    exact: bool = False,
    method: str = "auto",
    tolerance: float = 1e-12,
    budget: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> ContactIntervalTable:
    """ContactIntervalTable: all times of contact of each of many questions, as `contact_intervals` answers them.

    Arguments as in `first_contacts`.

    >>> import firstcontact as fc
    >>> cube = fc.examples.box((1, 1, 1))
    >>> moving = cube.moving(fc.Translations([(8, 0, 0), (0, 4, 0)]))
    >>> table = fc.many_contact_intervals((moving, cube.translated((3, 0, 0))))
    >>> table.count.tolist(), table.intervals[["question", "start", "end"]].tolist()
    ([1, 0], [(0, 0.25, 0.5)])
    """
    check_arguments(method, "auto", tolerance, budget)
    arguments: FirstArguments = {"exact": exact, "method": method, "tolerance": tolerance, "budget": budget}
    asking, questions = VerbCall("contact_intervals", arguments), asked(queries)
    rows = _rows(questions, asking, workers, executor, progress)
    assert isinstance(rows, IntervalRows)
    return ContactIntervalTable(rows, lambda row: asking.one(questions, row))


def _rows(
    questions: Questions, asking: VerbCall, workers: int | None, executor: Executing | None, progress: Reached
) -> Rows:
    """The answers, after a look at who is to give them."""
    if workers is not None and (not isinstance(workers, int) or not 1 <= workers <= work.MOST):
        raise InputError(f"workers is {shown(workers)}; give a whole number up to {work.MOST}, or None")
    if executor is not None and not hasattr(executor, "submit"):
        raise InputError(f"executor is {shown(executor)}; give a concurrent.futures.Executor or a client of dask")
    with work.Spare() as spare:
        return work.answered(questions, asking, workers, executor, progress, spare)
