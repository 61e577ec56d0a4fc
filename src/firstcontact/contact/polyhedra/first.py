"""`first_contact`, `contact_intervals` and `contact_pairs` of two polyhedra."""

from __future__ import annotations

import time as clock
from dataclasses import replace

from firstcontact.contact.polyhedra.answers import (
    JoinedInterval,
    contact_of,
    contained_at_start,
    element_pairs,
    initial_contact,
    interval_of,
    join,
)
from firstcontact.contact.polyhedra.earliest import Found, Pair, all_pairs, earliest
from firstcontact.contact.polyhedra.intervals import Windows, contact_windows
from firstcontact.contact.polyhedra.overlap import initial_kind
from firstcontact.contact.polyhedra.problem import problem_of, problems_in_order
from firstcontact.contact.ways import Way, answered
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import Undecidable, to_double
from firstcontact.motion.relative.curved import CurvedPiece
from firstcontact.motion.relative.pieces import Piece, pieces
from firstcontact.result import ContactIntervals, ContactPairs, FirstContact, Stats, Status
from firstcontact.work import Query

NO_WORK = Stats()


def first(query: Query) -> FirstContact:
    """The first contact, proved; its time exact, or enclosed where it has no exact form."""
    return answered([Way("by trees", _first_contact)], query)


def _first_contact(query: Query, _: None = None) -> FirstContact:
    parts = _pieces(query)
    if query.engine not in ("auto", "boxes") and any(isinstance(piece, CurvedPiece) for piece in parts):
        raise UnsupportedPair(
            f"engine {query.engine!r} searches translations and rotations; other motions take 'auto'"
        )
    stats, begin, exact, shared = NO_WORK, query.begin, query.exact, query.shared
    problems = problems_in_order(query.a, query.b, parts, query.engine, query.threads)
    for problem, with_start in problems:
        begins = with_start and problem.piece.start == parts[0].start
        found = earliest(problem, _left(query, stats), query.progress, with_start=with_start)
        stats = _added(stats, found)
        until = None if found.open is None else problem.world_time(found.free_until)
        if until is not None and (not with_start or until <= to_double(problem.piece.start)):
            return _undecided(str(found.open), until, stats, query)
        if found.start or (begins and _starts_at_once(found)):
            try:
                kind = initial_kind(problem, found) if begins else None
            except Undecidable:
                kind = None
            return initial_contact(problem, found, kind, exact, _timed(stats, begin), shared, jump=not begins)
        if with_start:
            try:
                inside = problem.is_contained()
            except Undecidable:
                return _undecided("precision", query.span[0], stats, query)
            if inside:
                return contained_at_start(problem, exact, _timed(stats, begin), shared, jump=not begins)
        if until is not None:
            return _undecided(str(found.open), until, stats, query)
        if found.instant is not None:
            return contact_of(problem, found, exact, _timed(stats, begin), shared)
    return FirstContact(Status.FREE, free_until=query.span[1], stats=_timed(stats, begin), **shared)


def intervals(query: Query) -> ContactIntervals:
    """All closed times of contact, with exact ends where these have an exact form."""
    return answered([Way("by trees", _contact_intervals)], query)


def _contact_intervals(query: Query, _: None) -> ContactIntervals:
    parts = _pieces(query)
    stats, begin, exact, shared = NO_WORK, query.begin, query.exact, query.shared
    ends: list[JoinedInterval] = []
    for piece in parts:
        problem = problem_of(query.a, query.b, piece)
        found = contact_windows(problem, _left(query, stats), query.progress)
        stats = _added(stats, found)
        if found.open is not None:
            until = max(to_double(piece.start), problem.world_time(found.until))
            ends = join(ends, problem, found.windows)
            if found.open == "precision" and not ends:  # where a first contact is easier to tell than all windows
                rest = _first_contact(
                    Query(query.a, query.b, piece.start, query.last, progress=query.progress)
                )
                if rest.status is Status.FREE:
                    break
                until = max(until, rest.free_until or until)
            intervals = tuple(interval_of(e, exact) for e in ends)
            return ContactIntervals(
                intervals, Status.UNDECIDED, until, found.open, _timed(stats, begin), **shared
            )
        ends = join(ends, problem, found.windows)
    intervals = tuple(interval_of(e, exact) for e in ends)
    status = Status.FREE if not ends else Status.INITIAL_CONTACT if ends[0].at_start(parts[0]) else Status.CONTACT
    until = query.span[1] if not ends else intervals[0].start
    return ContactIntervals(intervals, status, until, None, _timed(stats, begin), **shared)


def pairs(query: Query) -> ContactPairs:
    """All pairs of elements that meet during the span."""
    stats = NO_WORK
    met: list[Pair] = []
    pierced: list[Pair] = []
    doubtful: list[Pair] = []
    for problem, with_start in problems_in_order(query.a, query.b, _pieces(query), "auto"):
        found = all_pairs(problem, with_start=with_start)
        stats = _added(stats, found)
        met += found.pairs
        pierced += [pair for pair, _ in found.start]
        doubtful += found.doubtful
    named = [[p for p, _ in element_pairs(query.a, query.b, some)] for some in (met, pierced, doubtful)]
    undecided = tuple(p for p in named[2] if p not in named[0] and p not in named[1])
    return ContactPairs(tuple(named[0]), tuple(named[1]), undecided, _timed(stats, query.begin))


def _pieces(query: Query) -> list[Piece | CurvedPiece]:
    """The pieces of the relative motion; UnsupportedPair where exact times are asked of one that has none."""
    parts = pieces(query.a, query.b, query.first, query.last)
    if query.exact:
        for piece in parts:
            if isinstance(piece, CurvedPiece) and not piece.is_rational:
                raise UnsupportedPair(piece.why_inexact())
    return parts


def _left(query: Query, stats: Stats) -> int | None:
    """What is left of the budget."""
    return None if query.budget is None else max(0, query.budget - int(stats.node_visits + stats.pair_tests))


def _starts_at_once(found: Found) -> bool:
    return found.instant is not None and found.instant.is_zero()


def _undecided(reason: str, free_until: float, stats: Stats, query: Query) -> FirstContact:
    return FirstContact(
        Status.UNDECIDED, free_until=free_until, reason=reason, stats=_timed(stats, query.begin), **query.shared
    )


def _added(stats: Stats, found: Found | Windows) -> Stats:
    """The work so far with that of one more search."""
    return Stats(
        stats.node_visits + found.visits,
        stats.pair_tests + found.tests,
        stats.undecided + found.unsure,
        stats.exact_evaluations + found.exact,
        engine=found.engine or stats.engine,
    )


def _timed(stats: Stats, begin: float) -> Stats:
    """The work of a search, and the time since `begin`."""
    return replace(stats, seconds=clock.perf_counter() - begin)
