"""Processes of this machine, which keep the bodies of the batch at which they work."""

from __future__ import annotations

import pickle
import sys
import types
import uuid
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any

from firstcontact.batch.part import Asking
from firstcontact.batch.questions import Questions
from firstcontact.batch.workers import Elsewhere, timed_answers
from firstcontact.result_table import Rows

_kept: dict[str, tuple[Any, ...]] = {}
"""The bodies of the batch at which this process works, by its name."""


def keep(batch: str, bodies: bytes) -> None:
    """Have the bodies of a batch ready, and no others."""
    if batch not in _kept:
        _kept.clear()
        _kept[batch] = pickle.loads(bodies)  # noqa: S301 - written by `pickle.dumps` in the process that asks


def kept_bodies(batch: str) -> tuple[Any, ...]:
    """The bodies of the batch."""
    return _kept[batch]


def kept_answers(batch: str, bodies: bytes, questions: Questions, asking: Asking) -> tuple[Rows, float]:
    """`timed_answers` of bodies that are kept; bodies: pickled, "" where they are there."""
    if bodies:
        keep(batch, bodies)
    return timed_answers(kept_bodies(batch), questions, asking)


class Processes(Elsewhere):
    """Processes of this machine, each of which is given the bodies as it starts."""

    def __init__(self, n: int, bodies: tuple[Any, ...]) -> None:
        super().__init__(self._ask, n, self._start)
        self.batch, self.bodies = uuid.uuid4().hex, pickle.dumps(bodies)
        self._start()

    def _start(self) -> None:
        self.pool = ProcessPoolExecutor(
            self.workers, mp_context=_Spawning(), initializer=keep, initargs=(self.batch, self.bodies)
        )

    def _ask(self, questions: Questions, asking: Asking) -> Future[tuple[Rows, float]]:
        return self.pool.submit(kept_answers, self.batch, b"", questions, asking)

    def __enter__(self) -> Processes:
        return self

    def __exit__(self, *_: Any) -> None:
        self.pool.shutdown(cancel_futures=True)


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
    Process = _SpawnedAlone
