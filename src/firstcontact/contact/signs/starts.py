"""The start of a span in exact arithmetic, where the search in doubles stops and the motions have no exact times.

Bodies that turn by any angle stand in rational poses at the start more often than not; how they lie to each other then
is a question of two bodies at rest.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from flint import fmpq

from firstcontact.errors import UnsupportedPair
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.pieces import placement_at
from firstcontact.result import FirstContact, Status


def is_open(found: FirstContact) -> bool:
    """Whether something is left to tell of the start."""
    if found.status is Status.INITIAL_CONTACT:
        return found.initial is None
    if found.status is not Status.UNDECIDED or found.free_until is None:
        return False
    return found.reason == "precision" and found.free_until <= found.span[0]


def told_at_rest(found: FirstContact, first: fmpq, decide: Callable[[Any, Any], FirstContact]) -> FirstContact:
    """What `decide` says of the bodies at rest in their poses then; else what was found.

    UNDECIDED remains where they are apart: nothing is proved of the times after the start.
    """
    try:
        told = decide(_placed(found.a, first), _placed(found.b, first))
    except UnsupportedPair:
        return found
    if told.status is not Status.INITIAL_CONTACT:
        return found
    return replace(told, a=found.a, b=found.b, span=found.span, stats=found.stats + told.stats)


def _placed(body: Any, time: fmpq) -> Any:
    pose = placement_at(body, time)
    if not pose.is_exact:
        raise UnsupportedPair("an irrational pose at the start")
    return pose.place(shape_of(body))
