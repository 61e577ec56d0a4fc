"""A cluster of dask.distributed (extra batch)."""

from __future__ import annotations

from typing import Any

from firstcontact.batch.workers import Elsewhere

LOST: tuple[type[Exception], ...] = ()


class Cluster(Elsewhere):
    """The workers of a client, each of which is given the bodies once."""

    def __init__(self, client: Any, bodies: tuple[Any, ...]) -> None:
        raise NotImplementedError
