"""The start of a span in exact arithmetic, where the search in doubles stops and the motions have no exact times.

Bodies that turn by any angle stand in rational poses at the start more often than not; how they lie to each other then
is a question of two bodies at rest.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from flint import fmpq

from firstcontact.contact.later import LATER, waiting
from firstcontact.contact.ways import Passed, tried
from firstcontact.errors import UnsupportedPair
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.pieces import placement_at
from firstcontact.result import FirstContact, Status
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Shape


def with_start(query: Query, answer: Callable[[Query], FirstContact]) -> FirstContact:
    """What `answer` says of the query, and where it leaves the start open, of the bodies at rest in their poses then.

    UNDECIDED remains where they are apart: nothing is proved of the times after the start.
    """
    found = answer(query)
    if query.method != "auto" or query.budget is not None:
        return found
    if found.status is Status.INITIAL_CONTACT:
        return told_later(found, lambda: _of_start(query, found, answer) if _is_untold(found) else None)
    told = _of_start(query, found, answer) if _is_open(found) else None
    return found if told is None else told


def told_later(found: FirstContact, ask: Callable[[], FirstContact | None]) -> FirstContact:
    """A contact: what touches, and how, is what `ask` tells when that is read, and as found where it has None."""
    def places() -> dict[str, object]:
        told = ask()
        if told is None:
            return {}
        return {name: getattr(told, name) for name in LATER} | {"initial": told.initial or found.initial}

    return waiting(found, places)


def _of_start(query: Query, found: FirstContact, answer: Callable[[Query], FirstContact]) -> FirstContact | None:
    """What is told of the bodies at rest, as to the query; None where they are not proved to share a point."""
    told = tried(lambda: answer(_at_rest(query)))
    if isinstance(told, Passed) or told.status is not Status.INITIAL_CONTACT:
        return None
    initial, stats = told.initial or found.initial, found.stats + told.stats
    return replace(told, initial=initial, a=query.a, b=query.b, span=query.span, stats=stats)


def _is_untold(found: FirstContact) -> bool:
    """Whether something is left to tell of a start in contact."""
    return found.initial is None or (found.initial != "containment" and found.point is None)


def _is_open(found: FirstContact) -> bool:
    """Whether it is not told that the bodies are apart at the start, and doubles will not tell it."""
    if found.status is not Status.UNDECIDED or found.free_until is None:
        return False
    return found.reason == "precision" and found.free_until <= found.span[0]


def _at_rest(query: Query) -> Query:
    """About the bodies as they stand at the start, exactly."""
    a, b = (_placed(body, query.first) for body in query.bodies)
    return replace(query, a=a, b=b, last=query.first, exact=False, method="algebraic")


def _placed(body: Body, time: fmpq) -> Shape:
    pose = placement_at(body, time)
    if not pose.is_exact:
        raise UnsupportedPair("an irrational pose at the start")
    placed: Shape = pose.place(shape_of(body))
    return placed
