"""`first_contact` and `contact_intervals` of bodies of several pieces.

What two such bodies share is what a piece of one shares with a piece of the other: closed sets, whose union holds the
same points.  So the first contact is the earliest of the pieces, and the times of contact are those of all pairs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq

from firstcontact.body.compound.compound import as_triangles, both_taken_in, deviation_of
from firstcontact.body.torus.torus import Torus
from firstcontact.contact.compound.answer import PieceAnswer, combined, joined
from firstcontact.contact.compound.windows import PairWindow, side_of, windows
from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.exact.numbers import Undecidable, above, below, exact_value
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.result import Asked, ContactIntervals, FirstContact, Status
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.contact.compound.windows import CompoundSide


ROOM = fmpq(7, 8)
"""Of the enclosure that may be told: how wide it becomes at most where pieces touch nearly at once."""
MOST_PARTS = 4
"""Of a window, asked about one by one."""
BESIDE = 16.0
"""Deviations of triangles that these go on at most from where their surfaces touch: along a slope of 1 in 16."""


def first(query: Query) -> FirstContact:
    """The earliest contact of two pieces; each pair is asked of the times at which its boxes meet, early ones first."""
    from firstcontact.contact import table

    _refuse(query)
    sides = side_of(query.a), side_of(query.b)
    asked = windows(*sides, query)
    told: list[PieceAnswer] = []
    end, left, enough = query.last, query.budget, None
    for k, window in enumerate(asked):
        if end is not None and window.first > end:
            break
        if left is not None and left <= 0:
            told.append(PieceAnswer(sides, window, _spent(query, window)))
            break
        found = _asked(table.first_contact, _about(query, sides, window, end, left, enough, whole=True))
        if left is not None:
            left -= found.stats.node_visits + found.stats.pair_tests + found.stats.exact_evaluations
        told.append(PieceAnswer(sides, window, found))
        if found.status is Status.CONTACT or found.status is Status.INITIAL_CONTACT:
            assert found.time_interval is not None
            # others that touch just as soon cost as much again: they are asked only where the time itself is wanted, or
            # how all lie at the start, or where what touches here is a wall between pieces
            told_all = not query.exact and found.status is Status.CONTACT and bool(told[-1].named)
            ends = exact_value(found.time_interval[0 if told_all else 1])
            end = ends if end is None else min(end, ends)
            if told_all and query.last is not None:  # times within one enclosure need not be told apart
                room = ROOM * exact_value(query.tolerance) * (query.last - query.first)
                enough = exact_value(found.time_interval[1]) - room
        if query.progress is not None and k + 1 < len(asked):
            query.progress(min(below(asked[k + 1].first), query.span[1] if end is None else above(end)), k + 1)
    found = combined(query, sides, told, lambda: _is_within_deviation(query))
    if found.reason == "precision" and (closer := _more_closely(query, sides, told)) is not None:
        found = combined(query, sides, closer, lambda: _is_within_deviation(query))
    return found if found.status is not Status.UNDECIDED else _by_triangles(query, found)


def _more_closely(
    query: Query, sides: tuple[CompoundSide, CompoundSide], told: Sequence[PieceAnswer]
) -> list[PieceAnswer] | None:
    """The answers with their first contact asked about in a short span around it: an enclosure as wide as is allowed
    leaves no room for what others leave open just before.  None where there is no such answer."""
    from firstcontact.contact import table

    met = [(x.found.time_interval, x) for x in told if x.found.time_interval is not None]
    if not met or query.budget is not None:
        return None
    (lo, hi), first = min(met, key=lambda x: x[0][1])
    begin, end = exact_value(lo), exact_value(hi)
    around = replace(first.window, first=max(2 * begin - end, first.window.first), last=2 * end - begin)
    found = _asked(table.first_contact, _about(query, sides, around, query.last, None))
    if found.status is not Status.CONTACT or found.time_interval is None:
        return None
    lo, hi = max(lo, found.time_interval[0]), min(hi, found.time_interval[1])
    if found.time is None or not lo <= found.time <= hi:
        return None
    closer = replace(first, found=replace(found, time_interval=(lo, hi), free_until=lo))
    return [closer if x is first else x for x in told]


def _by_triangles(query: Query, found: FirstContact) -> FirstContact:
    """What is left open of bodies with the surfaces of files, as where they touch along all of a circle: the contact of
    their triangles, which tells by how much these deviate.

    No more than that: what triangles miss may touch.  So their contact counts where it comes as soon after what is
    proved free of the surfaces, or as little before, as the deviations let it.
    """
    from firstcontact.contact import table

    a, b = map(as_triangles, query.bodies)
    if not query.is_auto or found.reason != "precision" or (a is query.a and b is query.b):
        return found
    other = table.first_contact(replace(query, a=a, b=b))
    if other.status is not Status.CONTACT or not _is_beside(query, found, other):
        return found
    asked = Asked("by pieces", "passed: precision", found.stats.seconds), *other.stats.ways
    stats = replace(found.stats + other.stats, ways=asked)
    until = min(x.free_until for x in (found, other) if x.free_until is not None)
    return replace(other, a=query.a, b=query.b, free_until=until, stats=stats)


def _is_beside(query: Query, found: FirstContact, other: FirstContact) -> bool:
    """Whether the points at which triangles touch are as near to each other when the surfaces are left open as they may
    be where these touch then."""
    until, then = found.free_until, other.time
    if until is None or then is None or other.point is None or other.model_deviation is None:
        return False
    there = np.append(other.point, 1.0)
    a, b = (
        x.motion(until) @ np.linalg.solve(x.motion(then), there) if isinstance(x, Moving) else there
        for x in query.bodies
    )
    return float(np.linalg.norm((a - b)[:3])) <= BESIDE * other.model_deviation


def _is_within_deviation(query: Query) -> bool | None:
    """Of bodies that overlap at the start: whether they do not, taken in by what they deviate from their files'; None
    of bodies that deviate by nothing."""
    from firstcontact.contact import table

    if not any(map(deviation_of, query.bodies)):
        return None
    pair = both_taken_in(query.a, query.b)
    if pair is None:
        return False
    found = table.first_contact(replace(query, a=pair[0], b=pair[1], last=query.first, exact=False, progress=None))
    return found.status is Status.FREE or found.initial == "touching"


def _about(
    query: Query, sides: tuple[CompoundSide, CompoundSide], window: PairWindow, end: fmpq | None, left: int | None,
    enough: fmpq | None = None, whole: bool = False,
) -> Query:  # fmt: skip
    """The question about two pieces, up to the end of their window or the first contact known.

    whole: with the enclosure that the whole question allows, whose span is longer.
    """
    a, b = sides
    last = window.last if end is None or window.last is None else min(window.last, end)
    last = end if last is None else last
    whole = whole and last is not None and query.last is not None and last > window.first
    tolerance = query.tolerance if not whole or last is None else query.tolerance_within(window.first, last)
    return replace(
        query, a=a.bodies[window.a], b=b.bodies[window.b], first=window.first,
        last=None if last is None else max(last, window.first), budget=left, progress=None, enough=enough,
        tolerance=tolerance,
    )  # fmt: skip


def _asked(ask: Callable[[Query], FirstContact], query: Query) -> FirstContact:
    """The answer about two pieces; none where no precision tells how surfaces of one lie that are all but tangent."""
    try:
        return ask(query)
    except Undecidable:
        start = query.span[0]
        return FirstContact(Status.UNDECIDED, free_until=start, reason="precision", **query.shared)


def _spent(query: Query, window: PairWindow) -> FirstContact:
    free_until = max(query.span[0], below(window.first))
    return FirstContact(Status.UNDECIDED, free_until=free_until, reason="budget", span=query.span)


def intervals(query: Query) -> ContactIntervals:
    """All times at which some pair of pieces is in contact; pairs with tori, which take longer, are asked last, and all
    of the times alone that others do not fill."""
    from firstcontact.contact import table

    _refuse(query)
    sides, told = (side_of(query.a), side_of(query.b)), list[ContactIntervals]()
    try:
        for window in sorted(windows(*sides, query), key=lambda x: _has_torus(sides, x)):
            for part in [window] if query.exact else _not_filled(window, told):
                found = table.contact_intervals(_about(query, sides, part, None, query.budget, whole=True))
                told.append(_as_early(query, part, found, told))
        return joined(query, told)
    except Undecidable as reason:
        raise UnsupportedPair("surfaces of a part are all but tangent; its intervals are not decided") from reason


def _has_torus(sides: tuple[CompoundSide, CompoundSide], window: PairWindow) -> bool:
    bodies = sides[0].bodies[window.a], sides[1].bodies[window.b]
    return any(isinstance(shape_of(x), Torus) for x in bodies)


def _not_filled(window: PairWindow, told: Sequence[ContactIntervals]) -> list[PairWindow]:
    """What of a window lies outside of what is proved to be in contact throughout, with its ends; what happens within
    the enclosures of these is not told apart."""
    first, parts = window.first, list[PairWindow]()
    filled = sorted((exact_value(x.start_interval[0]), exact_value(x.end_interval[1])) for found in told for x in found)
    for begin, end in filled:
        if end <= first or (window.last is not None and begin >= window.last):
            continue
        if begin > first:
            parts.append(replace(window, first=first, last=begin))
        first = end
        if window.last is not None and first >= window.last:
            break
    else:
        parts.append(replace(window, first=first))
    return parts if len(parts) <= MOST_PARTS else [window]


def _as_early(
    query: Query, part: PairWindow, found: ContactIntervals, told: Sequence[ContactIntervals]
) -> ContactIntervals:  # fmt: skip
    """The answer about times up to a known contact; what it leaves open just before is within that one's enclosure."""
    until = found.free_until
    if found.reason != "precision" or until is None or query.last is None or query.exact:
        return found
    room = exact_value(query.tolerance) * (query.last - query.first)
    for x in (x for other in told for x in other):
        lo, hi = x.start_interval
        if exact_value(lo) == part.last and exact_value(hi) - exact_value(until) <= room:
            known = *found.intervals, replace(x, start_interval=(min(until, lo), hi))
            begins = known[0].start_interval[1] <= found.span[0]
            status = Status.INITIAL_CONTACT if begins else Status.CONTACT
            return replace(found, status=status, reason=None, intervals=known)
    return found


def _refuse(query: Query) -> None:
    """Bodies whose lengths are of different units."""
    units = [getattr(shape_of(body), "unit", None) for body in query.bodies]
    if None not in units and units[0] != units[1]:
        names = [body.name or which for body, which in zip(query.bodies, "ab", strict=True)]
        raise InputError(
            f"{names[0]} is in {units[0]} and {names[1]} in {units[1]}; load both with the same unit="
        )
