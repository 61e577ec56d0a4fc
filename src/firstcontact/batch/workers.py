"""Parts of the questions handed to threads, processes or a cluster, and put together again.

Compiled walks release the interpreter, so threads do for them; what is left, exact arithmetic and curved bodies, goes
to processes as soon as it would take seconds.  Bodies go to a process once; parts are as large as so many questions as
are answered in about PART seconds.  A part whose worker was lost is done again.
"""

from __future__ import annotations

import os
import pickle
import sys
import threading
import time
import uuid
from collections import deque
from collections.abc import Callable
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Future,
    ThreadPoolExecutor,
    as_completed,
    wait,
)
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from firstcontact.batch.culling import free_by_boxes
from firstcontact.batch.part import VerbCall, answer, answers, is_plain
from firstcontact.batch.questions import Questions
from firstcontact.body.kept import KeptOfTwo
from firstcontact.motion.moving import shape_of
from firstcontact.result_table import Rows

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from distributed import Client

    from firstcontact.batch.processes import Processes
    from firstcontact.body.kinds import Body

MOST = 1024
"""Workers: more than any machine has cores."""
PART, FIRST_PART, LARGEST_PART = 0.5, 16, 1 << 16
"""Seconds of a part, questions of the first ones, of which nothing is known yet, and of any."""
WORTH = 10.0
"""Seconds of work from which on it is worth starting processes, which load the library first."""
TRIED = 0.5
"""Seconds after which what the work will take is judged."""
THREAD_PART, FIRST_WALKED = 0.1, 512
"""Seconds of a part that is walked by a thread.

And questions of the first one, which makes what the others share; a second one of as many tells what one takes, where
the first does not show that one part for each thread will do.
"""
_PACES = KeptOfTwo[float]()
"""What a question about two bodies takes, in seconds: then no first part is walked to tell it."""
RETRIES, HOPELESS = 3, 40
"""How often a part is done again beside others, and losses in a row from which on it is not the questions' fault."""
LOST = "the worker that looked at it was lost every time, as if it ran out of memory; ask it alone, with a budget"

Reached = Callable[[int, int], None] | None
Executing: TypeAlias = "Executor | Client | Elsewhere"
"""Who takes parts of the questions."""


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def is_worth_processes(passed: float, done: int, left: int, started: bool = False) -> bool:
    """Whether processes are worth while for what is left, after `done` questions in so many seconds.

    started: whether they are there already.
    """
    tried, worth = (TRIED / 10, TRIED) if started else (TRIED, WORTH)
    return done > 0 and passed > tried and passed / done * left > worth


def next_size(size: int, done: int, passed: float, seconds: float, most: int) -> int:
    """How many questions to take next, so that they take so long: up to four times as many as the last time.

    size: what was to be taken; done, passed: what was, and the seconds it took.
    """
    return max(1, min(int(seconds * done / max(passed, 1e-6)), 4 * size, most))


class Count:
    """How many questions are answered, told to who asked for it."""

    def __init__(self, total: int, progress: Reached) -> None:
        self.done, self.total, self.progress = 0, total, progress

    def add(self, n: int) -> None:
        self.done += n
        if self.progress is not None and n:
            self.progress(self.done, self.total)


class Spare:
    """Processes that were started for one batch, kept for the next ones about the same bodies."""

    def __init__(self) -> None:
        self.processes: Processes | None = None

    def started(self, n: int, bodies: tuple[Body, ...]) -> Processes:
        from firstcontact.batch.processes import Processes

        if self.processes is None or not _same(self.processes.about, bodies):
            self.__exit__()
            self.processes = Processes(n, bodies)
        return self.processes

    def __enter__(self) -> Spare:
        return self

    def __exit__(self, kind: type[BaseException] | None = None, *_: object) -> None:
        if self.processes is not None:
            self.processes.stop(at_once=kind is not None)
            self.processes = None


def _same(bodies: tuple[Body, ...], others: tuple[Body, ...]) -> bool:
    return len(bodies) == len(others) and all(x is y for x, y in zip(bodies, others, strict=True))


def answered(
    questions: Questions,
    asking: VerbCall,
    workers: int | None,
    executor: Executing | None,
    progress: Reached,
    spare: Spare,
    boxes: bool | None = None,
) -> Rows:
    """All answers, by whoever takes part.  boxes: whether these are looked at first, as `free_by_boxes` has it."""
    count, left = Count(len(questions), progress), np.ones(len(questions), bool)
    free = free_by_boxes(questions, boxes if is_plain(asking.arguments) else False)
    by_threads = asking.walks and executor is None
    n = cores() if workers is None else workers
    rows = asking.rows(len(questions), cleared=not by_threads)
    count.add(len(free))
    left[free] = False
    if by_threads:
        left &= ~_by_threads(n, questions, asking, rows, count)
    rows.free(free, np.ones(len(free)))
    if executor is None:
        _one_by_one(n, questions, asking, np.flatnonzero(left), rows, count, spare)
    else:
        _Spread(questions, asking, rows, count).over(_elsewhere(executor, questions), np.flatnonzero(left))
    return rows


def _one_by_one(
    n: int, questions: Questions, asking: VerbCall, left: np.ndarray, rows: Rows, count: Count, spare: Spare
) -> None:
    """Answers the rows that are left, by processes as soon as that is worth while."""
    begin, done = time.thread_time(), 0  # work, whatever else the machine does
    while done < len(left):
        passed = time.thread_time() - begin
        if n > 1 and is_worth_processes(passed, done, len(left) - done, spare.processes is not None):
            _Spread(questions, asking, rows, count).over(spare.started(n, questions.bodies), left[done:])
            break
        answer(questions, asking, int(left[done]), rows)
        count.add(1)
        done += 1


def _by_threads(n: int, questions: Questions, asking: VerbCall, rows: Rows, count: Count) -> np.ndarray:
    """Answers by compiled walks; tells of each row whether they did.

    Each thread clears its rows first, which is when the system finds memory for them.
    """
    from firstcontact.batch.together import walk_together  # loads what polyhedra need

    begun, done = threading.Event(), np.zeros(len(questions), bool)

    def walk(where: slice) -> int:
        begun.wait()
        own = rows.part(where)
        own.clear()
        done[where] = some = walk_together(questions.part(where), asking, own)
        return int(np.count_nonzero(some))

    begun.set()
    at, n_all = 0, len(questions)
    n_parts = _parts(n, n_all, _pace(questions))
    while at < min(2 * FIRST_WALKED, n_all) and n_parts != n:
        begin, part = time.perf_counter(), slice(at, min(at + FIRST_WALKED, n_all))
        count.add(walk(part))
        seconds, at = (time.perf_counter() - begin) / (part.stop - at), part.stop
        n_parts = _parts(n, n_all - at, seconds)
        _keep_pace(questions, seconds)
    if at == n_all:
        return done
    size = -(-(n_all - at) // n_parts)
    pool = ThreadPoolExecutor(n)
    begun.clear()  # threads are slow to start beside one that is at work
    try:
        parts = [pool.submit(walk, slice(k, min(k + size, n_all))) for k in range(at, n_all, size)]
        begun.set()
        for future in as_completed(parts):
            count.add(future.result())
    finally:
        begun.set()
        pool.shutdown(cancel_futures=True)
    return done


def _parts(n: int, left: int, seconds: float) -> int:
    """How many parts to cut questions into that take so long each: of one size, as many for each of n threads."""
    return n * max(1, round(seconds * left / (n * THREAD_PART))) if seconds > 0.0 else 0


def _pace(questions: Questions) -> float:
    """Seconds that a question about the same two bodies took before; 0 where nothing is known."""
    if len(questions.bodies) != 2:
        return 0.0
    a, b = map(shape_of, questions.bodies)
    return _PACES.get(a, b) or 0.0


def _keep_pace(questions: Questions, seconds: float) -> None:
    if len(questions.bodies) == 2:
        a, b = map(shape_of, questions.bodies)
        _PACES.put(a, b, seconds)


# -- parts for others ---------------------------------------------------------------------------------------------


@dataclass
class Elsewhere:
    """Who answers parts.

    submit(questions, asking): the future of `timed_answers`; the questions are without bodies, which are there already.
    renew: called where workers were lost, or None where nothing can be done about it.
    seconds: what a part should take.
    """

    submit: Callable[[Questions, VerbCall], Future[tuple[Rows, float]]]
    workers: int
    renew: Callable[[], None] | None = None
    seconds: float = PART


class _Spread:
    """Hands parts to others, as many questions at once as take so long as they say, and puts the answers together.

    A worker that dies takes along all that is at work in its pool: parts that were lost too often are asked again each
    alone, in halves, down to the question that ends whoever looks at it; that row is an error.
    """

    def __init__(self, questions: Questions, asking: VerbCall, rows: Rows, count: Count) -> None:
        self.questions, self.asking, self.rows, self.count = questions.about(()), asking, rows, count
        self.size = FIRST_PART
        self.waiting: deque[_Part] = deque()
        self.suspects: list[np.ndarray] = []
        self.lost = 0
        """Parts that were alone when their worker was lost, since the last answer."""

    def over(self, others: Elsewhere, where: np.ndarray) -> None:
        """Answers the rows `where`."""
        begun: dict[Future[tuple[Rows, float]], _Part] = {}
        at = 0
        try:
            while begun or self.waiting or self.suspects or at < len(where):
                while len(begun) < 2 * others.workers:
                    if not self.waiting and at < len(where):
                        self.waiting.append(_Part(where[at : at + self.size]))
                        at += self.size
                    if not self.waiting and not begun and self.suspects:
                        self.waiting.append(_Part(self.suspects.pop(), RETRIES, alone=True))
                    if not self.waiting:
                        break
                    part = self.waiting.popleft()
                    try:
                        begun[others.submit(self.questions.part(part.where), self.asking)] = part
                    except BrokenExecutor as error:
                        self._again(part, others, error)
                for future in wait(begun, return_when=FIRST_COMPLETED).done:
                    part = begun.pop(future)
                    try:
                        self._take(part.where, future.result(), others.seconds)
                    except Exception as error:
                        self._again(part, others, error)
        finally:
            for future in begun:
                future.cancel()

    def _take(self, where: np.ndarray, answers: tuple[Rows, float], wanted: float) -> None:
        rows, seconds = answers
        self.lost = 0
        self.rows.put(where, rows)
        self.count.add(len(where))
        self.size = next_size(self.size, len(where), seconds, wanted, LARGEST_PART)

    def _again(self, part: _Part, others: Elsewhere, error: Exception) -> None:
        """Have the part of a worker that was lost done again; raises all other errors, and where nothing is left."""
        if not isinstance(error, (BrokenExecutor, CancelledError, *_lost())):
            raise error
        if part.tries < RETRIES:
            self.waiting.append(_Part(part.where, part.tries + 1))
        elif self.lost == HOPELESS or isinstance(error, BrokenExecutor) and others.renew is None:
            raise error
        elif not part.alone:
            self.suspects.append(part.where)
        elif len(part.where) > 1:
            self.lost += 1
            self.suspects += np.array_split(part.where, 2)[::-1]
        else:
            self.lost += 1
            self.rows.refuse(int(part.where[0]), LOST)
            self.count.add(1)
        if others.renew is not None:
            others.renew()


@dataclass(frozen=True)
class _Part:
    """Rows that are asked about together, how often they were in vain, and whether nothing is at work beside them."""

    where: np.ndarray
    tries: int = 0
    alone: bool = False


def timed_answers(bodies: tuple[Body, ...], questions: Questions, asking: VerbCall) -> tuple[Rows, float]:
    """Where it is answered: all that can be told of the questions, nothing put off, and the seconds it took."""
    begin = time.perf_counter()
    rows = answers(questions.about(bodies), asking).settle()
    return rows, time.perf_counter() - begin


def _elsewhere(executor: Any, questions: Questions) -> Elsewhere:
    """The executor, or the client of dask.distributed."""
    if isinstance(executor, Elsewhere):
        return executor
    if hasattr(executor, "scatter") and hasattr(executor, "get_executor"):
        from firstcontact.batch.cluster import Cluster

        return Cluster(executor, questions.bodies)
    from firstcontact.batch.processes import kept_answers

    batch, bodies = uuid.uuid4().hex, pickle.dumps(questions.bodies)

    def ask(part: Questions, asking: VerbCall) -> Future[tuple[Rows, float]]:
        future: Future[tuple[Rows, float]] = executor.submit(kept_answers, batch, bodies, part, asking)
        return future

    return Elsewhere(ask, getattr(executor, "_max_workers", cores()))


def _lost() -> tuple[type[Exception], ...]:
    """What tells that a worker of a cluster was lost, where there may be one."""
    if "distributed" not in sys.modules:
        return ()
    from firstcontact.batch.cluster import LOST

    return LOST
