"""`first_contact`, `contact_intervals` and `contact_pairs` of two polyhedra."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Sequence
from dataclasses import replace

from firstcontact.contact.advancing import Apart, in_longer_span, without_advance
from firstcontact.contact.polyhedra import after_start
from firstcontact.contact.polyhedra.answers import (
    JoinedInterval,
    contact_of,
    contained_at_start,
    element_pairs,
    initial_contact,
    interval_of,
    join,
)
from firstcontact.contact.polyhedra.earliest import FoundFirst, Pair, Problem, all_pairs, earliest
from firstcontact.contact.polyhedra.intervals import Windows, contact_windows
from firstcontact.contact.polyhedra.overlap import initial_kind
from firstcontact.contact.polyhedra.prisms import in_one_plane, upright
from firstcontact.contact.polyhedra.problems.problem import (
    far_apart,
    piece_at_start,
    problem_of,
    problems_in_order,
    stretches,
)
from firstcontact.contact.polyhedra.sharpened import sharpened
from firstcontact.contact.ways import Passed, Way, answered, decided
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import Undecidable, above, below, to_double
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.curved import CurvedPiece
from firstcontact.motion.relative.pieces import MotionPiece, curved_pieces, pieces
from firstcontact.result import ContactInterval, ContactIntervals, ContactPairs, FirstContact, Stats, Status
from firstcontact.timeline.answers import union
from firstcontact.work import WORTH, NoMemory, Query, Spent

NO_WORK = Stats()

SOON = 2000 * WORTH
"""Work of trees on small convex parts, before solids are asked: about a second in balls."""


def first(query: Query) -> FirstContact:
    """The first contact, proved; its time exact, or enclosed where it has no exact form."""
    return answered(_FIRST, query)


def _by_trees(query: Query, _: None) -> FirstContact | Passed:
    return decided(_first_contact(query, _pieces(query)), query)


def _in_balls(query: Query, proved: FirstContact) -> FirstContact | Passed:
    """By the motions themselves, which tell more of bodies in irrational poses."""
    left = query.budget_after(proved.stats)
    found = _first_contact(replace(query, budget=left), curved_pieces(query.a, query.b, query.first, query.end))
    found = replace(found, stats=replace(proved.stats + found.stats, seconds=found.stats.seconds, ways=()))
    if found.status is Status.UNDECIDED and (found.free_until or 0.0) <= (proved.free_until or 0.0):
        return Passed(str(found.reason))
    return found


def _are_in_doubt(query: Query, proved: FirstContact | None) -> bool:
    """Whether shifts or turns were left open, as they may be in irrational poses."""
    if proved is None or proved.reason != "precision" or query.exact or query.last is None:
        return False
    if query.engine not in ("auto", "boxes"):
        return False
    return any(isinstance(piece, MotionPiece) for piece in _pieces(query))


def _first_contact(query: Query, parts: Sequence[MotionPiece | CurvedPiece]) -> FirstContact:
    if query.engine not in ("auto", "boxes") and any(isinstance(piece, CurvedPiece) for piece in parts):
        raise UnsupportedPair(
            f"engine {query.engine!r} searches translations and rotations; other motions take 'auto'"
        )
    stats, begin, exact, shared, work = NO_WORK, query.begin, query.exact, query.shared, query.work()
    try:
        for problem, with_start in problems_in_order(query.a, query.b, parts, query.engine, query.threads, work):
            begins = with_start and problem.piece.start == parts[0].start
            found = earliest(problem, work.left, query.progress, with_start=with_start)
            stats = _added(stats, found)
            work.done += found.work
            until = None if found.open is None else problem.world_time(found.free_until)
            if until is not None and (not with_start or until <= to_double(problem.piece.start)):
                return _undecided(str(found.open), until, stats, query)
            if found.start or (begins and _starts_at_once(found)):
                try:
                    kind = initial_kind(problem, found) if begins else None
                except (Undecidable, NoMemory):
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
    except Spent:
        return _undecided("budget", work.free_until, stats, query)
    return FirstContact.free(_timed(stats, begin), **shared)


_FIRST: tuple[Way[FirstContact], ...] = (
    Way("by trees", _by_trees),
    Way("in balls", _in_balls, _are_in_doubt),
)


def intervals(query: Query) -> ContactIntervals:
    """All closed times of contact, with exact ends where these have an exact form."""
    return answered([
        Way("in the plane", _in_the_plane),
        Way("after the start", _after_the_start, _starts_on_a_curve),
        Way("by trees, if soon", _by_trees_soon, lambda query, _: _are_small_and_convex(query)),
        Way("as convex solids", _as_solids, lambda query, _: _are_small_and_convex(query)),
        Way("by trees", lambda query, _: decided(_contact_intervals(query), query), _is_left_to_trees),
    ], query)  # fmt: skip


def _in_the_plane(query: Query, _: None) -> ContactIntervals | Passed:
    """Of prisms along the normal of a plane in which they move, or along which they also advance, and of parts that lie
    on each other there."""
    if not any(isinstance(piece, CurvedPiece) for piece in _pieces(query)):
        return Passed("shifts and turns are exact")
    other = in_one_plane(query)
    other = without_advance(query, upright) if other is None else other
    if other is None:
        return Passed("they are no prisms that move in one plane, nor is one on the other")
    if isinstance(other, Apart):
        return ContactIntervals.free(query.stats(), **query.shared)
    return decided(in_longer_span(_contact_intervals(other), other, query), query)


def _starts_on_a_curve(query: Query, _: None) -> bool:
    """Whether the motion at the start has no rational poses, in a question of more than that instant."""
    free = not query.is_algebraic and query.budget is None
    return free and query.last is not None and query.first < query.last and isinstance(_pieces(query)[0], CurvedPiece)


def _after_the_start(query: Query, _: None) -> ContactIntervals | Passed:
    return after_start.intervals(query, first, _contact_intervals)


def _by_trees_soon(query: Query, _: None) -> ContactIntervals | Passed:
    """What trees tell with no more work than solids take, who follow parts that slide on each other sooner."""
    return decided(_contact_intervals(query.limited(SOON)), query)


def _is_left_to_trees(query: Query, proved: ContactIntervals | None) -> bool:
    """Whether trees were not asked yet, or stopped before they had told all they can."""
    return proved is None or proved.reason == "budget"


def _are_small_and_convex(query: Query) -> bool:
    """Whether the doubles of curved solids may be asked, which follow parts that slide on each other."""
    from firstcontact.contact.reduce import is_small_and_convex

    free = not query.is_algebraic and query.budget is None
    return free and all(is_small_and_convex(shape_of(x)) for x in query.bodies)


def _as_solids(query: Query, _: ContactIntervals) -> ContactIntervals | Passed:
    """What these tell, to the digits of trees where these tell more; what trees proved stands where solids do not."""
    from firstcontact.contact.models.first import intervals as of_solids

    found = of_solids(replace(query, method="certified"))
    if found.status is Status.UNDECIDED:
        return Passed(str(found.reason))
    return sharpened(found, query, lambda part: _contact_intervals(part.limited(SOON)))


def _contact_intervals(query: Query) -> ContactIntervals:
    parts = _pieces(query)
    stats, work = NO_WORK, query.work()
    ends: list[JoinedInterval] = []
    try:
        for piece in stretches(query.a, query.b, parts, work):
            if isinstance(piece, CurvedPiece) and far_apart(query.a, query.b, piece):
                continue
            if isinstance(piece, CurvedPiece) and piece.start == piece.end:
                piece = piece_at_start(piece)
            problem = problem_of(query.a, query.b, piece)
            found = contact_windows(problem, work.left, query.progress)
            stats = _added(stats, found)
            work.done += found.work
            lasts = not isinstance(piece, CurvedPiece) and piece.start != piece.end
            if found.open == "precision" and lasts and piece.end is not None:
                (curved,) = curved_pieces(query.a, query.b, piece.start, piece.end)  # in irrational poses balls tell
                problem = problem_of(query.a, query.b, curved)
                found = contact_windows(problem, work.left, query.progress)
                stats = _added(stats, found)
                work.done += found.work
            join(ends, problem, found.windows, work)
            if found.open is not None:
                until = max(to_double(piece.start), problem.world_time(found.until))
                if found.open == "precision" and not ends:  # a first contact may be easier to tell than all windows
                    own = replace(query, first=piece.start, budget=work.left, exact=False)
                    rest = _first_contact(own, _pieces(own))
                    if rest.status is Status.FREE:
                        break
                    until = max(until, rest.free_until or until)
                return _intervals_of(ends, parts[0], query, stats, (found.open, until))
    except Spent:
        return _intervals_of(ends, parts[0], query, stats, ("budget", work.free_until))
    return _intervals_of(ends, parts[0], query, stats, None)


def _intervals_of(
    ends: list[JoinedInterval], first: MotionPiece | CurvedPiece, query: Query, stats: Stats,
    left: tuple[str, float] | None,
) -> ContactIntervals:  # fmt: skip
    """The answer; left: what stopped the search, and when."""
    intervals = tuple(_within(interval_of(e, query.exact), query) for e in ends)
    if any(_is_in_balls(problem) for x in ends for problem in (x.start[0], x.end[0])):
        intervals = tuple(union(intervals))  # what these do not tell apart
    if left is not None:
        status, until, reason = Status.UNDECIDED, left[1], left[0]
    else:
        status = Status.FREE if not ends else Status.INITIAL_CONTACT if ends[0].at_start(first) else Status.CONTACT
        until, reason = query.span[1] if not ends else intervals[0].start, None
    return ContactIntervals(intervals, status, until, reason, _timed(stats, query.begin), **query.shared)


def _is_in_balls(problem: Problem) -> bool:
    """Whether its times are; those of others are exact."""
    return isinstance(problem.piece, CurvedPiece) and not problem.piece.is_rational


def _within(x: ContactInterval, query: Query) -> ContactInterval:
    """With enclosures that do not reach beyond the span: balls may by one rounding."""
    first, last = below(query.first), math.inf if query.last is None else above(query.last)
    (lo, start), (end, hi) = x.start_interval, x.end_interval
    if first <= lo and hi <= last:
        return x
    return replace(x, start_interval=(max(lo, first), start), end_interval=(end, min(hi, last)))


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


def _pieces(query: Query) -> list[MotionPiece | CurvedPiece]:
    """The pieces of the relative motion; UnsupportedPair where exact times are asked of one that has none."""
    parts = pieces(query.a, query.b, query.first, query.last)
    if query.exact:
        for piece in parts:
            if isinstance(piece, CurvedPiece) and not piece.is_rational:
                raise UnsupportedPair(piece.why_inexact())
    return parts


def _starts_at_once(found: FoundFirst) -> bool:
    return found.instant is not None and found.instant.is_zero()


def _undecided(reason: str, free_until: float, stats: Stats, query: Query) -> FirstContact:
    return FirstContact(
        Status.UNDECIDED, free_until=free_until, reason=reason, stats=_timed(stats, query.begin), **query.shared
    )


def _added(stats: Stats, found: FoundFirst | Windows) -> Stats:
    """The work so far with that of one more search."""
    return Stats(
        stats.node_visits + found.visits,
        stats.pair_tests + found.tests,
        stats.undecided + found.unsure,
        stats.exact_evaluations + found.exact,
        engine=found.engine or stats.engine,
    )


def _timed(stats: Stats, begin: float) -> Stats:
    """The work of a search that is over, and the time since `begin`."""
    told = Stats() if stats is NO_WORK else stats
    told.note_time(clock.perf_counter() - begin)
    return told
