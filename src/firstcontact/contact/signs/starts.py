"""The start of a span in exact arithmetic, where the search in doubles stops and the motions have no exact times.

Bodies that turn by any angle stand in rational poses at the start more often than not; how they lie to each other then
is a question of two bodies at rest.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from flint import fmpq

from firstcontact.contact.later import told_later
from firstcontact.contact.ways import Passed, tried
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import fraction
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative.pieces import placement_at
from firstcontact.result import FirstContact, Status
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Shape


def with_start(query: Query, answer: Callable[[Query], FirstContact]) -> FirstContact:
    """What `answer` says of the query, and where it leaves the start open, of the bodies at rest in their poses then.

    Exact arithmetic is asked of those first: two bodies at rest take it little beside a motion, whose times of contact
    it would have to tell all; surfaces that deform in their own places take it no more.  UNDECIDED remains where they
    are apart: nothing is proved of the times after the start.
    """
    moves = any(isinstance(body, Moving) for body in query.bodies)
    if query.is_algebraic and query.budget is None and moves:
        told = _of_start(query, answer)
        return answer(query) if told is None else told
    found = answer(query)
    if not query.is_auto:
        return found
    if found.status is Status.INITIAL_CONTACT and _is_untold(found):
        return told_later(found, lambda: _of_start(replace(query, progress=None), answer))
    told = _of_start(query, answer) if query.budget is None and _is_open(found) else None
    return found if told is None else replace(told, stats=found.stats + told.stats)


def _of_start(query: Query, answer: Callable[[Query], FirstContact]) -> FirstContact | None:
    """What is told of the bodies at rest, as to the query; None where they are not proved to share a point."""
    told = tried(lambda: answer(_at_rest(query)))
    if isinstance(told, Passed) or told.status is not Status.INITIAL_CONTACT:
        return None
    return replace(told, time_exact=fraction(query.first) if query.exact else None, **query.shared)


def _is_untold(found: FirstContact) -> bool:
    """Whether something is left to tell of a start in contact: doubles know a place, not a point that both have."""
    return found.initial != "containment"


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
