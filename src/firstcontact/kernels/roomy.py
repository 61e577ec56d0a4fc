"""Calls with room for the frames of all that they call."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

Asked = ParamSpec("Asked")
Told = TypeVar("Told")

ROOM = 1 << 16
"""Words of memory, for a thousand frames.  The memory is taken from the system as it is written to."""


def roomy(function: Callable[Asked, Told], *arguments: Asked.args, **named: Asked.kwargs) -> Told:
    """What the function returns.

    Python takes memory for frames in chunks of 16 KiB, and gives one back as soon as nothing is in it: a call made
    often where a chunk is full costs two calls of the system and a fault of a page, each time.  This function's own
    frame is said to be so large that its chunk has room for the frames above it.
    """
    return function(*arguments, **named)


roomy.__code__ = roomy.__code__.replace(co_stacksize=ROOM + 1)
