"""What searches work out about a body once and keep on it, each kind in a typed place of its own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar

T = TypeVar("T")


class Kept(Generic[T]):
    """A place on every body, empty at first: ``TREE = Kept[Tree]()`` in the file that works trees out.

    Bodies that are placed or changed begin anew; copies by other names share what is kept; pickles leave it out.
    """

    def of(self, body: Any, make: Callable[[], T]) -> T:
        """What is kept; `make` is asked for it where nothing is.  None is not kept."""
        kept: dict[Any, Any] = body._search
        found: T | None = kept.get(self)
        if found is None:
            found = kept[self] = make()
        return found

    def get(self, body: Any) -> T | None:
        found: T | None = body._search.get(self)
        return found

    def put(self, body: Any, value: T) -> T:
        body._search[self] = value
        return value
