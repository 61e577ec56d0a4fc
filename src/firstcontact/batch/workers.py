"""Parts of the questions handed to threads, processes or a cluster, and put together again.

Compiled walks release the interpreter, so threads do for them; what is left, exact arithmetic and curved bodies, goes
to processes as soon as it would take seconds.  Bodies go to a process once; parts are as large as so many questions as
are answered in about PART seconds.  A part whose worker was lost is done again, RETRIES times.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
import time
import types
import uuid
from collections import deque
from collections.abc import Callable
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    as_completed,
    wait,
)
from dataclasses import dataclass
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any

import numpy as np

from firstcontact.batch.part import Asking, answer, answers, walk_together
from firstcontact.batch.questions import Questions
from firstcontact.result_table import Rows

MOST = 1024
"""Workers: more than any machine has cores."""
PART, FIRST_PART, LARGEST_PART = 0.5, 16, 1 << 16
"""Seconds of a part, questions of the first ones, of which nothing is known yet, and of any."""
WORTH = 4.0
"""Seconds of work from which on it is worth starting processes, which load the library first."""
TRIED = 0.5
"""Seconds after which what the work will take is judged."""
THREAD_PART = 1 << 14
"""Questions of a part that is walked by a thread."""
RETRIES = 3

Reached = Callable[[int, int], None] | None


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


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
        self.processes: _Processes | None = None

    def started(self, n: int, bodies: tuple[Any, ...]) -> _Processes:
        if self.processes is None or self.processes.about != bodies:
            self.__exit__()
            self.processes = _Processes(n, bodies)
        return self.processes

    def __enter__(self) -> Spare:
        return self

    def __exit__(self, kind: Any = None, *_: Any) -> None:
        if self.processes is not None:
            self.processes.stop(at_once=kind is not None)
            self.processes = None


def answered(
    questions: Questions, asking: Asking, workers: int | None, executor: Any, progress: Reached, spare: Spare
) -> Rows:
    """All answers, by whoever takes part."""
    count, rows = Count(len(questions), progress), Rows(len(questions))
    if executor is not None:
        _Spread(questions, asking, rows, count).over(_elsewhere(executor, questions), np.arange(len(questions)))
        return rows
    n = cores() if workers is None else workers
    left = _by_threads(n, questions, asking, rows, count)
    begin, done = time.perf_counter(), 0
    while done < len(left):
        passed = time.perf_counter() - begin
        tried, worth = (TRIED, WORTH) if spare.processes is None else (TRIED / 10, TRIED)
        if n > 1 and done and passed > tried and passed / done * (len(left) - done) > worth:
            _Spread(questions, asking, rows, count).over(spare.started(n, questions.bodies), left[done:])
            break
        answer(questions, asking, int(left[done]), rows)
        count.add(1)
        done += 1
    return rows


def _by_threads(n: int, questions: Questions, asking: Asking, rows: Rows, count: Count) -> np.ndarray:
    """What compiled walks answer; gives the rows that they leave."""
    cuts = range(0, len(questions), THREAD_PART)
    parts = [slice(first, min(first + THREAD_PART, len(questions))) for first in cuts]
    left = np.ones(len(questions), bool)

    def walk(where: slice) -> tuple[slice, np.ndarray]:
        return where, walk_together(questions.part(where), asking, rows.part(where))

    for where, done in map(walk, parts[:1]):  # which makes what the others share
        left[where][done] = False
        count.add(len(done))
    with ThreadPoolExecutor(n) as pool:
        for future in as_completed([pool.submit(walk, where) for where in parts[1:]]):
            where, done = future.result()
            left[where][done] = False
            count.add(len(done))
    return np.flatnonzero(left)


# -- parts for others ---------------------------------------------------------------------------------------------


@dataclass
class Elsewhere:
    """Who answers parts.

    submit(questions, asking): the future of `timed_answers`; the questions are without bodies, which are there already.
    renew: called where workers were lost, or None where nothing can be done about it.
    seconds: what a part should take.
    """

    submit: Callable[[Questions, Asking], Future[tuple[Rows, float]]]
    workers: int
    renew: Callable[[], None] | None = None
    seconds: float = PART


class _Spread:
    """Hands parts to others, as many questions at once as take so long as they say, and puts the answers together."""

    def __init__(self, questions: Questions, asking: Asking, rows: Rows, count: Count) -> None:
        self.questions, self.asking, self.rows, self.count = questions.about(()), asking, rows, count
        self.size = FIRST_PART
        self.waiting: deque[_Part] = deque()

    def over(self, others: Elsewhere, where: np.ndarray) -> None:
        """Answers the rows `where`."""
        begun: dict[Future[Any], _Part] = {}
        at = 0
        try:
            while begun or self.waiting or at < len(where):
                while len(begun) < 2 * others.workers and (self.waiting or at < len(where)):
                    if not self.waiting:
                        self.waiting.append(_Part(where[at : at + self.size]))
                        at += self.size
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
        self.rows.put(where, rows)
        self.count.add(len(where))
        able = int(wanted * len(where) / max(seconds, 1e-6))
        self.size = max(1, min(able, 4 * self.size, LARGEST_PART))

    def _again(self, part: _Part, others: Elsewhere, error: Exception) -> None:
        """Have the part of a worker that was lost done again; raises all other errors."""
        if part.tries >= RETRIES or not isinstance(error, (BrokenExecutor, CancelledError, *_lost())):
            raise error
        self.waiting.append(_Part(part.where, part.tries + 1))
        if others.renew is not None:
            others.renew()


@dataclass(frozen=True)
class _Part:
    """Rows that are asked about together, and how often they were in vain."""

    where: np.ndarray
    tries: int = 0


def timed_answers(bodies: tuple[Any, ...], questions: Questions, asking: Asking) -> tuple[Rows, float]:
    """Where it is answered: all that can be told of the questions, nothing put off, and the seconds it took."""
    begin = time.perf_counter()
    rows = answers(questions.about(bodies), asking).settle()
    return rows, time.perf_counter() - begin


_kept: dict[str, tuple[Any, ...]] = {}
"""The bodies of the batch at which this process works, by its name."""


def keep(batch: str, bodies: bytes) -> None:
    """Have the bodies of a batch ready, and no others."""
    if batch not in _kept:
        _kept.clear()
        _kept[batch] = pickle.loads(bodies)  # noqa: S301 - written by `pickle.dumps` in the process that asks


def kept_answers(batch: str, bodies: bytes, questions: Questions, asking: Asking) -> tuple[Rows, float]:
    """`timed_answers` of bodies that are kept; bodies: pickled, "" where they are there."""
    if bodies:
        keep(batch, bodies)
    return timed_answers(_kept[batch], questions, asking)


class _Processes(Elsewhere):
    """Processes of this machine, each of which is given the bodies as it starts."""

    def __init__(self, n: int, bodies: tuple[Any, ...]) -> None:
        super().__init__(self._ask, n, self._renew)
        self.about = bodies
        self.batch, self.bodies = uuid.uuid4().hex, pickle.dumps(bodies)
        self._start()

    def _start(self) -> None:
        self.spawning = _Spawning()
        self.pool = ProcessPoolExecutor(
            self.workers, mp_context=self.spawning, initializer=_begin, initargs=(self.batch, self.bodies)
        )

    def _ask(self, questions: Questions, asking: Asking) -> Future[tuple[Rows, float]]:
        return self.pool.submit(kept_answers, self.batch, b"", questions, asking)

    def _renew(self) -> None:
        """A new pool, unless that was done already: all parts of a broken one fail."""
        try:
            self.pool.submit(cores)
        except BrokenExecutor:
            self._start()

    def stop(self, at_once: bool) -> None:
        """at_once: without waiting for what is at work, which nobody asks for any longer."""
        if at_once:
            for process in self.spawning.started:
                process.terminate()
        self.pool.shutdown(cancel_futures=True)


def _begin(batch: str, bodies: bytes) -> None:
    """A process starts; whether it is interrupted is told by the one that started it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    keep(batch, bodies)


class _SpawnedAlone(SpawnProcess):
    """A process that does not run the caller's script again: it needs nothing of it."""

    def start(self) -> None:
        main = sys.modules["__main__"]
        sys.modules["__main__"] = types.ModuleType("__main__")
        try:
            super().start()
        finally:
            sys.modules["__main__"] = main


class _Spawning(SpawnContext):
    """started: its processes."""

    def __init__(self) -> None:
        super().__init__()
        self.started: list[SpawnProcess] = []

    def Process(self, *arguments: Any, **named: Any) -> SpawnProcess:  # type: ignore[override]
        self.started.append(_SpawnedAlone(*arguments, **named))
        return self.started[-1]


def _elsewhere(executor: Any, questions: Questions) -> Elsewhere:
    """The executor, or the client of dask.distributed."""
    if isinstance(executor, Elsewhere):
        return executor
    if hasattr(executor, "scatter") and hasattr(executor, "get_executor"):
        from firstcontact.batch.cluster import Cluster

        return Cluster(executor, questions.bodies)
    batch, bodies = uuid.uuid4().hex, pickle.dumps(questions.bodies)

    def ask(part: Questions, asking: Asking) -> Future[tuple[Rows, float]]:
        future: Future[tuple[Rows, float]] = executor.submit(kept_answers, batch, bodies, part, asking)
        return future

    return Elsewhere(ask, getattr(executor, "_max_workers", cores()))


def _lost() -> tuple[type[Exception], ...]:
    """What tells that a worker of a cluster was lost, where there may be one."""
    if "distributed" not in sys.modules:
        return ()
    from firstcontact.batch.cluster import LOST

    return LOST
