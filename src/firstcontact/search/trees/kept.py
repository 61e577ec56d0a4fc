"""What is made of a body once and kept on it; that it cannot be made is kept, too."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

T = TypeVar("T")


def kept(body: Any, key: str, make: Callable[[], T], refusal: type[Exception]) -> T:
    """What `make` gives, or raises of the class `refusal`; it is asked once."""
    known = body._search.get(key)
    if known is None:
        try:
            known = make()
        except refusal as reason:
            known = reason
        body._search[key] = known
    if isinstance(known, refusal):
        raise known
    return known
