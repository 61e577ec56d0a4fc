"""What searches work out about a body once and keep on it, each kind in a typed place of its own."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any, Generic, Protocol, TypeVar

T = TypeVar("T")


class Keeping(Protocol):
    """What has room for what is kept: every body."""

    _search: dict[Any, Any]


class Kept(Generic[T]):
    """A place on every body, empty at first: ``TREE = Kept[Tree]()`` in the file that works trees out.

    Bodies that are placed or changed begin anew; copies by other names share what is kept; pickles leave it out.
    """

    def of(self, body: Keeping, make: Callable[[], T]) -> T:
        """What is kept; `make` is asked for it where nothing is.  None is not kept."""
        kept: dict[Any, Any] = body._search
        found: T | None = kept.get(self)
        if found is None:
            found = kept[self] = make()
        return found

    def of_or_refusal(self, body: Keeping, make: Callable[[], T], refusal: type[Exception]) -> T:
        """As `of`; where `make` raises an exception of that class, that is kept and raised whenever it is asked."""
        def made() -> Any:
            try:
                return make()
            except refusal as reason:
                return reason

        found = self.of(body, made)
        if isinstance(found, refusal):
            raise found
        return found

    def get(self, body: Keeping) -> T | None:
        found: T | None = body._search.get(self)
        return found

    def put(self, body: Keeping, value: T) -> T:
        body._search[self] = value
        return value


class KeptOfTwo(Generic[T]):
    """A place on every body for what is worked out about it and another one, kept while that is the same.

    The other one is not kept alive.
    """

    def __init__(self) -> None:
        self._place = Kept[tuple[weakref.ref[Keeping], T]]()

    def of(self, body: Keeping, other: Keeping, make: Callable[[], T]) -> T:
        """What is kept; `make` is asked for it where nothing is.  None is not kept."""
        found = self.get(body, other)
        return self.put(body, other, make()) if found is None else found

    def get(self, body: Keeping, other: Keeping) -> T | None:
        known = self._place.get(body)
        return known[1] if known is not None and known[0]() is other else None

    def put(self, body: Keeping, other: Keeping, value: T) -> T:
        return self._place.put(body, (weakref.ref(other), value))[1]
