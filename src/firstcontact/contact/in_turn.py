"""Doubles and elimination in turn, for ruled surfaces: who is asked first, how far each goes, who has the last word.

Which of them is quicker is not known beforehand.  So each is asked within a limit that grows from round to round, and
no answer takes many times what the quicker one takes.  Doubles begin, for they prove most free spans at once; what they
prove to be in contact is looked at exactly near that time alone, which tells what touches: when it is read.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple, TypeVar

from flint import fmpq

from firstcontact.contact.later import told_later
from firstcontact.contact.signs.sheets import FARTHER, FARTHEST, QUICK, Reach, TooLarge
from firstcontact.contact.ways import Passed, R, Way, answered, decided, tried
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import exact_value
from firstcontact.result import ContactIntervals, FirstContact, Status
from firstcontact.work import Query, Work


class Round(NamedTuple):
    """How far either goes: boxes that doubles look at; cells and instants that elimination decides, and its reach.

    None: as far as it takes.
    """

    boxes: int | None
    steps: int | None
    reach: Reach


ROUNDS = (
    Round(2_500, 130, QUICK), Round(100_000, 300, FARTHER),
    Round(200_000, 1_000, FARTHEST), Round(None, None, FARTHEST),
)  # fmt: skip
"""About 0.1, 2, 5 s and more of either."""
STILL = 2.0**-20
"""Part of the span: doubles that get no farther in a longer search are stuck, and wait until elimination has ended."""
NEARBY = fmpq(1, 2**30)
"""Part of the span around a time proved in doubles in which it is decided exactly."""

IN_DOUBLES = "in doubles"

T = TypeVar("T")


@dataclass
class AskedSoFar:
    """What is known of a question's rounds.

    refused    whether elimination does not take it, however far it goes: then doubles go on without a limit.
    ended      whether doubles went as far as it takes.
    exhausted  whether elimination did.
    until      up to when doubles told all; None: they were not asked yet.
    stuck      whether they got no farther when they were asked again.
    looked     right after which time elimination was asked.
    """

    refused: bool = False
    ended: bool = False
    exhausted: bool = False
    until: float | None = None
    stuck: bool = False
    looked: float | None = None

    def boxes(self, own: Round) -> int | None:
        """How far doubles go in a round."""
        boxes = None if self.refused else own.boxes
        self.ended = boxes is None
        return boxes

    def note(self, proved: FirstContact | ContactIntervals) -> None:
        """What doubles tell in a round."""
        if proved.free_until is not None:
            step = STILL * (proved.span[1] - proved.span[0])
            self.stuck = self.until is not None and proved.free_until <= self.until + step
            self.until = proved.free_until

    def asked(self, eliminate: Callable[[], T]) -> T:
        """What elimination tells."""
        try:
            return eliminate()
        except TooLarge:
            raise
        except UnsupportedPair:
            self.refused = True
            raise

    def reach(self, own: Round, proved: FirstContact | ContactIntervals | None) -> Round:
        """How far elimination goes in a round: as far as it takes where it need not wait for doubles."""
        far = own if _may_tell_more(proved) else ROUNDS[-1]
        self.exhausted = far is ROUNDS[-1]
        return far

    def is_cut_short(self, query: Query, proved: FirstContact | ContactIntervals | None) -> bool:
        """Whether doubles may tell more in a longer search."""
        waits = self.stuck and not self.refused and not self.exhausted
        return not query.is_algebraic and not self.ended and not waits and _may_tell_more(proved)

    def has_stopped(self, query: Query, proved: FirstContact | None) -> bool:
        """Whether doubles stopped at a time right after which nothing is told yet."""
        if proved is None or proved.reason != "budget" or proved.free_until in (None, proved.span[0], self.looked):
            return False
        return self.is_open(query, proved)

    def is_open(self, query: Query, _: FirstContact | ContactIntervals | None) -> bool:
        """Whether elimination may."""
        return not query.is_certified and not self.refused and not self.exhausted


def _may_tell_more(proved: FirstContact | ContactIntervals | None) -> bool:
    """Whether doubles were not asked yet, or stopped at their limit."""
    return proved is None or proved.reason == "budget"


InDoubles = Callable[[Query], FirstContact]
Exactly = Callable[[Query, Reach], FirstContact]
"""Of a question and how far to go; raises TooLarge beyond that."""


def first_in_turn(
    query: Query, in_doubles: InDoubles, exactly: Exactly, is_told: Callable[[FirstContact], bool]
) -> FirstContact:
    """The first contact.  is_told: of what doubles prove, whether elimination has nothing to add."""
    ways: list[Way[FirstContact]] = []
    turns = AskedSoFar()
    for own in ROUNDS if query.is_auto else ROUNDS[-1:]:
        ways += _first_ways(own, turns, in_doubles, exactly, is_told)
    return answered(_to_the_end(ways), query)


def _first_ways(
    own: Round, turns: AskedSoFar, in_doubles: InDoubles, exactly: Exactly, is_told: Callable[[FirstContact], bool]
) -> list[Way[FirstContact]]:
    """Those of one round."""
    def by_doubles(query: Query, _: FirstContact | None) -> FirstContact | Passed:
        proved = in_doubles(_limited(query, turns.boxes(own)))
        turns.note(proved)
        if query.is_certified or query.is_spent(proved.reason) or is_told(proved):
            return proved
        if proved.status is Status.CONTACT:
            return told_later(proved, partial(_told_nearby, replace(query, progress=None), own, exactly, proved))
        return Passed(str(proved.reason), proved)

    def by_elimination(query: Query, proved: FirstContact | None) -> FirstContact | Passed:
        if query.is_algebraic:
            return _with_advice(query, partial(exactly, query, own.reach), in_doubles)
        far = turns.reach(own, proved)
        ask = partial(exactly, _limited(query, far.steps), far.reach)
        return _beside(proved, decided(turns.asked(ask), query))

    def soon(query: Query, proved: FirstContact | None) -> FirstContact | Passed:
        assert proved is not None and proved.free_until is not None
        turns.looked = proved.free_until
        return _seen_soon(_limited(query, own.steps), exactly, proved.free_until, own.reach)

    first = Way(IN_DOUBLES, by_doubles, turns.is_cut_short)
    # a search of the first round is too short to tell much
    then = [] if own is ROUNDS[0] else [Way("exactly, soon", soon, turns.has_stopped)]
    return [first, *then, Way("exactly", by_elimination, turns.is_open)]


def _to_the_end(ways: list[Way[R]]) -> list[Way[R]]:
    """With doubles once more at the end, without a limit, where they waited for elimination."""
    return ways + [way for way in ways if way.name == IN_DOUBLES][-1:]


def _seen_soon(query: Query, exactly: Exactly, until: float, reach: Reach) -> FirstContact | Passed:
    """What elimination tells of the time right after one up to which all is free: doubles seldom stop elsewhere."""
    first = max(query.first, exact_value(until))
    near = exactly(replace(query, first=first, last=min(query.end, first + NEARBY * (query.end - query.first))), reach)
    if near.status is not Status.CONTACT:
        return Passed("no contact soon" if near.reason is None else near.reason)
    return replace(near, span=query.span)


def _seen_nearby(query: Query, exactly: Exactly, proved: FirstContact) -> FirstContact | Passed:
    """What elimination tells of a time at which contact is proved."""
    assert proved.time_interval is not None
    near = exactly(_nearby(query, proved.time_interval), QUICK)
    if near.status is not proved.status:
        return Passed("it denies what doubles proved" if near.reason is None else near.reason)
    return replace(near, span=query.span)


def _told_nearby(query: Query, own: Round, exactly: Exactly, proved: FirstContact) -> FirstContact | None:
    """The same; None where elimination does not tell."""
    found = tried(partial(_seen_nearby, _limited(query, own.steps), exactly, proved))
    return None if isinstance(found, Passed) else found


def _with_advice(query: Query, ask: Callable[[], T], in_doubles: InDoubles) -> T:
    """What it tells; its refusal where only exact arithmetic may answer says whether doubles take the question."""
    told = tried(ask)
    if not isinstance(told, Passed):
        return told
    others = replace(query, exact=False, method="certified", budget=0)
    if not query.is_algebraic or isinstance(tried(partial(in_doubles, others)), Passed):
        raise UnsupportedPair(told.reason)
    option = "exact=True" if query.exact else f"method={query.method!r}"
    raise UnsupportedPair(f"{told.reason}; without {option} there may be enclosures")


def _beside(proved: R | None, told: R | Passed) -> R | Passed:
    """What elimination tells; of what it leaves open, that of doubles stands, which knows whether these would go on."""
    return Passed(told.reason) if proved is not None and isinstance(told, Passed) else told


def _limited(query: Query, budget: int | None) -> Query:
    return query if budget is None else query.limited(budget)


def _nearby(query: Query, times: tuple[float, float]) -> Query:
    """Around a time that is proved."""
    room = NEARBY * (query.end - query.first)
    lo, hi = (exact_value(t) for t in times)
    return replace(query, first=max(query.first, lo - room), last=min(query.end, hi + room))


def intervals_in_turn(
    query: Query, first: InDoubles, in_doubles: Callable[[Query, Work], ContactIntervals],
    exactly: Callable[[Query, Work, Reach], ContactIntervals],
) -> ContactIntervals:  # fmt: skip
    """All contacts.  first: the first one in doubles, which tells whether these take the question."""
    shared, turns = query.work(), AskedSoFar()

    def work(budget: int | None) -> Work:
        return shared if query.budget is not None else _limited(query, budget).work()

    def by_doubles(own: Round, query: Query, _: ContactIntervals | None) -> ContactIntervals | Passed:
        proved = in_doubles(query, work(turns.boxes(own)))
        turns.note(proved)
        return decided(proved, query)

    def by_elimination(own: Round, query: Query, proved: ContactIntervals | None) -> ContactIntervals | Passed:
        far = turns.reach(own, proved)
        ask = partial(turns.asked, partial(exactly, query, work(far.steps), far.reach))
        return _beside(proved, decided(_with_advice(query, ask, first), query))

    ways: list[Way[ContactIntervals]] = []
    for own in ROUNDS if query.is_auto else ROUNDS[-1:]:
        if not query.is_algebraic:
            ways.append(Way(IN_DOUBLES, partial(by_doubles, own), turns.is_cut_short))
        ways.append(Way("exactly", partial(by_elimination, own), turns.is_open))
    return answered(_to_the_end(ways), query)
