"""A cluster of dask.distributed (extra batch)."""

from __future__ import annotations

from concurrent.futures import Future
from functools import partial
from typing import TYPE_CHECKING

from distributed import CancelledError, Client, KilledWorker
from distributed.comm import CommClosedError

from firstcontact.batch.part import VerbCall
from firstcontact.batch.questions import Questions
from firstcontact.batch.workers import PART, RETRIES, Elsewhere, timed_answers
from firstcontact.errors import InputError
from firstcontact.result_table import Rows

if TYPE_CHECKING:
    import distributed

    from firstcontact.body.kinds import Body

LOST: tuple[type[Exception], ...] = (KilledWorker, CancelledError, CommClosedError)
"""What a part ends with whose worker was lost, with the part or with the bodies."""
PATIENCE = 60
"""Seconds for which a cluster may have no worker."""
RATE = 100
"""Parts a second, of all workers together, that a scheduler handles with ease: on large clusters parts are longer."""


class Cluster(Elsewhere):
    """The workers of a client, each of which is given the bodies once."""

    def __init__(self, client: Client, bodies: tuple[Body, ...]) -> None:
        self.client, self.bodies = client, bodies
        self._place()
        workers = sum(client.nthreads().values())
        super().__init__(self._ask, workers, self._renew, max(PART, workers / RATE))

    def _place(self) -> None:
        """Have the bodies on every worker; those that come later fetch them from one another."""
        try:
            self.client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError as error:
            raise InputError(f"{self.client.scheduler.address}: a cluster without workers for {PATIENCE} s") from error
        (self.there,) = self.client.scatter([self.bodies], broadcast=True, hash=False)

    def _ask(self, questions: Questions, asking: VerbCall) -> Future[tuple[Rows, float]]:
        """Not by `client.get_executor`, whose futures never end where a part is lost with the bodies."""
        part = self.client.submit(timed_answers, self.there, questions, asking, pure=False, retries=RETRIES)
        told: Future[tuple[Rows, float]] = Future()
        told.add_done_callback(lambda _: part.cancel() if told.cancelled() else part.release())
        part.add_done_callback(partial(_tell, told))
        return told

    def _renew(self) -> None:
        """Have the bodies there again where they went with the last worker that held them."""
        if self.there.status != "finished" or not any(self.client.who_has([self.there]).values()):
            self._place()


def _tell(told: Future[tuple[Rows, float]], part: distributed.Future[tuple[Rows, float]]) -> None:
    """How a part ended, unless nobody asks any longer."""
    if not told.set_running_or_notify_cancel():
        return
    try:
        answers = part.result()
    except Exception as error:
        told.set_exception(error)
    else:
        told.set_result(answers)
