"""Processes of this machine, which keep the bodies of the batch at which they work."""

from __future__ import annotations

import os
import pickle
import signal
import sys
import threading
import types
import uuid
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor
from multiprocessing import parent_process
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import TYPE_CHECKING, Any

from firstcontact.batch.part import VerbCall
from firstcontact.batch.questions import Questions
from firstcontact.batch.workers import Elsewhere, cores, timed_answers
from firstcontact.result_table import Rows

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

_kept: dict[str, tuple[Body, ...]] = {}
"""The bodies of the batch at which this process works, by its name."""


def keep(batch: str, bodies: bytes) -> None:
    """Have the bodies of a batch ready, and no others."""
    if batch not in _kept:
        _kept.clear()
        _kept[batch] = pickle.loads(bodies)  # noqa: S301 - written by `pickle.dumps` in the process that asks


def kept_bodies(batch: str) -> tuple[Body, ...]:
    """The bodies of the batch."""
    return _kept[batch]


def kept_answers(batch: str, bodies: bytes, questions: Questions, asking: VerbCall) -> tuple[Rows, float]:
    """`timed_answers` of bodies that are kept; bodies: pickled, "" where they are there."""
    if bodies:
        keep(batch, bodies)
    return timed_answers(kept_bodies(batch), questions, asking)


class Processes(Elsewhere):
    """Processes of this machine, each of which is given the bodies as it starts."""

    def __init__(self, n: int, bodies: tuple[Body, ...]) -> None:
        super().__init__(self._ask, n, self._renew)
        self.about = bodies
        self.batch, self.bodies = uuid.uuid4().hex, pickle.dumps(bodies)
        self._start()

    def _start(self) -> None:
        self.spawning = _Spawning()
        self.pool = ProcessPoolExecutor(
            self.workers, mp_context=self.spawning, initializer=_begin, initargs=(self.batch, self.bodies)
        )

    def _ask(self, questions: Questions, asking: VerbCall) -> Future[tuple[Rows, float]]:
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
    threading.Thread(target=_end_with_it, daemon=True).start()
    keep(batch, bodies)


def _end_with_it() -> None:
    """The one that started this process may be killed; its queue would be waited at for ever."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


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
