"""Doubles and elimination in turn, for ruled surfaces: who is asked first, how far each goes, who has the last word.

Doubles prove most free spans in a small part of the time that elimination takes, so they begin, within a limit.
Elimination follows where degrees are low: it tells what touches, exactly.  Then both go on, as far as it takes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from flint import fmpq

from firstcontact.contact.signs.sheets import MOST_DEGREE, QUICK_DEGREE
from firstcontact.contact.ways import Passed, Way, answered, decided
from firstcontact.exact.numbers import exact_value
from firstcontact.result import ContactIntervals, FirstContact, Status
from firstcontact.work import Query, Work

QUICK_BOXES = 50_000
"""Boxes that the search in doubles looks at before elimination is asked: a third of a second."""
QUICK_STEPS = 100
"""Cells and instants that elimination decides before doubles go on: a second, more in high fields."""
NEARBY = fmpq(1, 2**30)
"""Part of the span around a time proved in doubles in which it is decided exactly."""

InDoubles = Callable[[Query], FirstContact]
Exactly = Callable[[Query, int], FirstContact]
"""Of a question and the most degree of equations; raises TooLarge beyond it."""


def first_in_turn(
    query: Query, in_doubles: InDoubles, exactly: Exactly, is_told: Callable[[FirstContact], bool]
) -> FirstContact:
    """The first contact.  is_told: of what doubles prove, whether elimination has nothing to add."""
    def quickly(query: Query, _: None) -> FirstContact | Passed:
        return judged(in_doubles(query.limited(QUICK_BOXES) if query.is_auto else query), query)

    def judged(proved: FirstContact, query: Query) -> FirstContact | Passed:
        told = query.is_certified or query.is_spent(proved.reason) or is_told(proved)
        return proved if told else Passed(proved.reason or "it is not told what touches", proved)

    def low_degrees(query: Query, proved: FirstContact | None) -> FirstContact | Passed:
        if query.is_algebraic:
            return exactly(query, MOST_DEGREE)
        quick = query.limited(QUICK_STEPS)
        if proved is None or proved.time_interval is None:
            told = decided(exactly(quick, QUICK_DEGREE), query)
            return Passed(told.reason) if isinstance(told, Passed) else told
        found = exactly(_nearby(quick, proved.time_interval), QUICK_DEGREE)
        if found.status is not proved.status:
            return Passed("it denies what doubles proved" if found.reason is None else found.reason)
        return replace(found, span=query.span)

    def is_open(query: Query, proved: FirstContact | None) -> bool:
        return query.is_auto and (proved is None or proved.status is Status.UNDECIDED)

    def is_cut_short(query: Query, proved: FirstContact | None) -> bool:
        return is_open(query, proved) and proved is not None and proved.reason == "budget"

    return answered([
        Way("in doubles", quickly, lambda query, _: not query.is_algebraic),
        Way("exactly", low_degrees, lambda query, _: not query.is_certified),
        Way("in doubles, on and on", lambda query, _: judged(in_doubles(query), query), is_cut_short),
        Way("exactly, all degrees", lambda query, _: exactly(query, MOST_DEGREE), is_open),
    ], query)  # fmt: skip


def _nearby(query: Query, times: tuple[float, float]) -> Query:
    """Around a time that is proved."""
    room = NEARBY * (query.end - query.first)
    lo, hi = (exact_value(t) for t in times)
    return replace(query, first=max(query.first, lo - room), last=min(query.end, hi + room))


def intervals_in_turn(
    query: Query, first: InDoubles, in_doubles: Callable[[Query, Work], ContactIntervals],
    exactly: Callable[[Query, Work, int], ContactIntervals],
) -> ContactIntervals:  # fmt: skip
    """All contacts.  first: the first one in doubles, which tells of free spans without more."""
    work = query.work()
    quick = work if query.budget is not None else query.limited(QUICK_STEPS).work()

    def if_free(query: Query, _: None) -> ContactIntervals | Passed:
        proved = first(replace(query, budget=QUICK_BOXES))
        if proved.status is not Status.FREE:
            return Passed("contact")
        return ContactIntervals((), Status.FREE, query.span[1], None, proved.stats, **query.shared)

    def soon(query: Query, _: None) -> ContactIntervals | Passed:
        return decided(exactly(query, quick, QUICK_DEGREE), query)

    def all_in_doubles(query: Query, _: None) -> ContactIntervals | Passed:
        return decided(in_doubles(query, work), query)

    return answered([
        Way("in doubles, if free", if_free, lambda query, _: not query.is_algebraic and query.budget is None),
        Way("soon exactly", soon, lambda query, _: query.is_auto),
        Way("in doubles", all_in_doubles, lambda query, _: not query.is_algebraic),
        Way("exactly", lambda query, _: exactly(query, work, MOST_DEGREE), lambda query, _: not query.is_certified),
    ], query)  # fmt: skip
