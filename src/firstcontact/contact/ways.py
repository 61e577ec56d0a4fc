"""The ways to an answer, asked one after the other; what one of them has proved is told to the next."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from firstcontact.errors import UnsupportedPair
from firstcontact.result import Asked, ContactIntervals, FirstContact, Status
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.search.convex.advance import Advance

Answer = FirstContact | ContactIntervals
R = TypeVar("R", FirstContact, ContactIntervals)


@dataclass(frozen=True, slots=True)
class Passed:
    """That a way leaves the question to the next one.

    proved: what it found all the same; an answer stands where no other way gives one.
    refused: whether it does not take such questions at all.
    """

    reason: str
    proved: Any = None
    refused: bool = False


T = TypeVar("T")


def tried(ask: Callable[[], T]) -> T | Passed:
    """What `ask` tells; its refusal passes."""
    try:
        return ask()
    except UnsupportedPair as refusal:
        return Passed(str(refusal), refused=True)


def decided(answer: R, query: Query) -> R | Passed:
    """The answer; what it leaves open passes, unless the caller's budget is spent."""
    if answer.status is not Status.UNDECIDED or query.is_spent(answer.reason):
        return answer
    return Passed(str(answer.reason), answer)


def _always(query: Query, proved: Advance | ContactIntervals | None) -> bool:
    return True


def is_proved(query: Query, proved: Advance | ContactIntervals | None) -> bool:
    """For ways that begin with a proof."""
    return proved is not None


@dataclass(frozen=True, slots=True)
class Way(Generic[R]):
    """One way to an answer.

    run(query, proved)    an answer or `Passed`; UnsupportedPair passes too.
    takes(query, proved)  whether the way is asked.
    proved                what the way before, or one before that, has proved; None: nothing.
    """

    name: str
    run: Callable[[Query, Any], R | Passed]
    takes: Callable[[Query, Any], bool] = _always


def answered(ways: Sequence[Way[R]], query: Query) -> R:
    """The first answer, else the last one that was proved on the way; its stats tell the ways asked.

    Raises UnsupportedPair with the reasons of all that refused.
    """
    asked: list[Asked] = []
    refusals: dict[str, str] = {}  # reasons, and who gave each last
    proved: Any = None
    for way in ways:
        if not way.takes(query, proved):
            continue
        begin = clock.perf_counter()
        found: R | Passed = tried(partial(way.run, query, proved))
        told = f"passed: {found.reason}" if isinstance(found, Passed) else found.status.name
        asked.append(Asked(way.name, told, clock.perf_counter() - begin))
        if not isinstance(found, Passed):
            return _told(found, asked)
        if found.refused:
            refusals[found.reason] = way.name
        proved = found.proved if found.proved is not None else proved
    stands = isinstance(proved, Answer)
    if stands:
        last: R = proved  # ways to one kind of answer prove no other kind
        return _told(last, [*asked, Asked("as proved before", last.status.name, 0.0)])
    if len(refusals) == 1:
        raise UnsupportedPair(next(iter(refusals)))
    raise UnsupportedPair("; ".join(f"{name}: {reason}" for reason, name in refusals.items()))


def _told(found: R, asked: Sequence[Asked]) -> R:
    """The answer, fresh from its search, with the ways that were asked before those that it tells already."""
    found.stats.note((*asked, *found.stats.ways))
    return found
