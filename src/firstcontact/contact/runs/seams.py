"""Answers to questions that were asked in parts of the span, one after the other.

What touches at the end of a part does at the beginning of the next one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from flint import fmpq

from firstcontact.body.compound.compound import about_models
from firstcontact.contact.later import waiting
from firstcontact.exact.numbers import above, below, fraction, to_double
from firstcontact.result import ContactInterval, ContactIntervals, FirstContact, Stats, Status
from firstcontact.work import Query


def first(answer: Callable[[Query], FirstContact], query: Query, parts: Iterable[Query]) -> FirstContact:
    """All of the query, from what `answer` tells of its parts, ascending, outside of which nothing touches."""
    stats = Stats()
    for own in parts:
        found = answer(replace(own, budget=query.budget_after(stats)))
        stats = replace(stats + found.stats, seconds=query.stats().seconds)
        if found.status is Status.INITIAL_CONTACT and own.first > query.first:
            return _at_seam(found, own.first, query, stats)  # a screw ends 2^-60 beside the next pose
        if found.status is not Status.FREE:
            return waiting(found, dict, stats=stats, **query.shared)
    return free(query, stats)


def _at_seam(found: FirstContact, time: fmpq, query: Query, stats: Stats) -> FirstContact:
    """A start in contact of a part of the span, as the contact that it is in all of it."""
    around = below(time), above(time)
    return waiting(
        found, lambda: {"initial": None}, status=Status.CONTACT, time=to_double(time), time_interval=around,
        time_exact=fraction(time) if query.exact else None, free_until=around[0], stats=stats, **query.shared,
    )  # fmt: skip


def intervals(
    answer: Callable[[Query], ContactIntervals], query: Query, parts: Iterable[Query]
) -> ContactIntervals:
    """All of the query, from what `answer` tells of its parts, ascending, outside of which nothing touches.

    What touches at the end of a part does at the beginning of the next one, if that begins there.
    """
    stats, known, status = Stats(), list[ContactInterval](), Status.FREE
    models = about_models(*query.bodies)
    for own in parts:
        found = answer(replace(own, budget=query.budget_after(stats)))
        stats = replace(stats + found.stats, seconds=query.stats().seconds)
        goes_on = own.first > query.first and _starts_at_once(found)
        known = _joined(known, list(found.intervals)) if goes_on else [*known, *found.intervals]
        if found.status is Status.UNDECIDED:
            return replace(found, intervals=tuple(known), stats=stats, **query.shared, **models)
        if found.status is not Status.FREE and status is Status.FREE:
            status = Status.CONTACT if goes_on else found.status
    until = known[0].start_interval[0] if known else query.span[1]
    return ContactIntervals(tuple(known), status, until, None, stats, **query.shared, **models)


def free(query: Query, stats: Stats) -> FirstContact:
    """Where all parts are."""
    found, models = FirstContact.free(stats, **query.shared), about_models(*query.bodies)
    return found if models["model_deviation"] is None else replace(found, **models)


def _starts_at_once(found: ContactIntervals) -> bool:
    if found.status is Status.UNDECIDED:
        return bool(found.intervals) and found.intervals[0].start <= found.span[0]
    return found.status is Status.INITIAL_CONTACT


def _joined(known: list[ContactInterval], more: list[ContactInterval]) -> list[ContactInterval]:
    """With what goes on from where another part begins: one with the last, where that lasts until there."""
    if known and more and known[-1].end_interval[1] >= more[0].start_interval[0]:
        last, own = known[-1], more[0]
        own = replace(own, start=last.start, start_interval=last.start_interval, start_exact=last.start_exact)
        return [*known[:-1], own, *more[1:]]
    return [*known, *more]
