"""Full results of many questions, one after the other, by processes where that is worth while."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor
from dataclasses import dataclass, replace
from importlib import import_module
from typing import TYPE_CHECKING, Any

from firstcontact.batch import culling
from firstcontact.batch.part import is_plain
from firstcontact.batch.questions import asked
from firstcontact.batch.workers import PART, Spare, is_worth_processes
from firstcontact.errors import FirstContactError
from firstcontact.result import ContactIntervals, FirstContact, Stats

if TYPE_CHECKING:
    from typing import Unpack

    from firstcontact.body.kinds import Body
    from firstcontact.contact.ways import Answer
    from firstcontact.work import Arguments, CheckArguments, QuestionFields

_NO_WORK = Stats()
"""One for all: to make one takes as long as to make the answer."""


@dataclass(frozen=True)
class Question:
    """A verb, two bodies, and its arguments beside them."""

    verb: str
    a: Any
    b: Any
    arguments: CheckArguments
    module: str = "firstcontact.query"
    """Where the verb is."""

    def asked(self, a: Body, b: Body, **more: Unpack[Arguments]) -> Answer:
        found: Answer = getattr(import_module(self.module), self.verb)(a, b, **self.arguments, **more)
        return found


def told_by_boxes(questions: Sequence[Question]) -> dict[int, Answer]:
    """Results of questions over the motions' own spans whose bodies are told to be apart by swept boxes."""
    able = [k for k, x in enumerate(questions) if x.arguments.get("span") is None and is_plain(x.arguments)]
    pairs = asked([(questions[k].a, questions[k].b) for k in able])
    found: dict[int, Answer] = {}
    for k in (able[row] for row in culling.free_by_boxes(pairs).tolist()):
        shared: QuestionFields = {"a": questions[k].a, "b": questions[k].b, "span": culling.SPAN}
        kind = ContactIntervals if questions[k].verb == "contact_intervals" else FirstContact
        found[k] = kind.free(_NO_WORK, **shared)
    return found


def in_order(
    questions: Sequence[Question], known: Mapping[int, Answer], here: Callable[[int], Answer],
    reached: Callable[[int], None], workers: int,
) -> Iterator[Answer]:
    """The results in order; `here` answers question k in this process, as long as what is left is soon done.

    known: results that are there.  reached: told of each other question that other processes have answered.  Raises
    what a question raised.
    """
    asking = _asked_in_order(questions, [k for k in range(len(questions)) if k not in known], here, reached, workers)
    for k in range(len(questions)):
        yield known[k] if k in known else next(asking)


def _asked_in_order(
    questions: Sequence[Question], left: Sequence[int], here: Callable[[int], Answer], reached: Callable[[int], None],
    workers: int,
) -> Iterator[Answer]:
    begin, n = time.thread_time(), len(left)
    for k, number in enumerate(left):
        done, passed = k - 1, time.thread_time() - begin  # without the first one, which loads compiled code
        if workers > 1 and is_worth_processes(passed, done, n - k):
            yield from _elsewhere(questions, left[k:], here, reached, workers, max(1, int(PART * done / passed)))
            return
        yield here(number)
        if k == 0:
            begin = time.thread_time()


def _elsewhere(
    questions: Sequence[Question],
    left: Sequence[int],
    here: Callable[[int], Answer],
    reached: Callable[[int], None],
    workers: int,
    size: int,
) -> Iterator[Answer]:
    """By processes; here, what a process that was lost leaves."""
    bodies = list({id(x): x for k in left for x in (questions[k].a, questions[k].b)}.values())
    numbers = {id(x): number for number, x in enumerate(bodies)}
    work = [(replace(q, a=None, b=None), numbers[id(q.a)], numbers[id(q.b)]) for q in (questions[k] for k in left)]
    done = 0
    with Spare() as spare:
        processes = spare.started(workers, tuple(bodies))
        try:
            parts = [work[first : first + size] for first in range(0, len(work), size)]
            for results in processes.pool.map(_answers, [processes.batch] * len(parts), parts):
                for result in results:
                    if isinstance(result, FirstContactError):
                        raise result
                    question = questions[left[done]]
                    reached(left[done])
                    done += 1
                    yield replace(result, a=question.a, b=question.b)
            return
        except BrokenExecutor:
            pass
    yield from map(here, left[done:])


def _answers(batch: str, part: list[tuple[Question, int, int]]) -> list[Answer | FirstContactError]:
    """The results, or what is raised instead; then it ends."""
    from firstcontact.batch.processes import kept_bodies

    bodies = kept_bodies(batch)
    out: list[Answer | FirstContactError] = []
    for question, a, b in part:
        try:
            out.append(question.asked(bodies[a], bodies[b]))
        except FirstContactError as error:
            return [*out, error]
    return out
