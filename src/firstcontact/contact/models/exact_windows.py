"""All times of contact of models as exact arithmetic tells them, from the candidates of `contact.models.algorithm`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from flint import fmpq

from firstcontact.contact.models.algorithm import Candidate, CandidateSearch, Root, between
from firstcontact.contact.models.answer import world_time
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import fraction, to_double
from firstcontact.exact.systems.square_systems import OpenRoot
from firstcontact.result import ContactIntervals, Status
from firstcontact.timeline.answers import interval_of
from firstcontact.work import Query, Spent, Work

if TYPE_CHECKING:
    from firstcontact.result import ExactTime


def decided_intervals(
    query: Query, searches: Iterator[CandidateSearch], work: Work, free_until: float
) -> ContactIntervals:
    """The answer of exact arithmetic: between two candidates the bodies overlap all the time or not at all.

    searches: one for every piece of the relative motion, in time order, which `work` pays.
    free_until: a time before which they are proved apart.
    """
    found: list[tuple[WindowEnd, WindowEnd]] = []
    tests = evaluations = 0
    reason = None
    try:
        for search in searches:
            for start, end in list(_windows(search, free_until)):
                if found and found[-1][1].is_same_time(start):
                    found[-1] = found[-1][0], end
                else:
                    found.append((start, end))
            tests, evaluations = tests + len(search.tasks), evaluations + len(search.verdicts)
    except Spent:
        reason = "budget"
    intervals = tuple(interval_of(start, end, query.exact) for start, end in found)
    at_start = bool(found) and found[0][0].is_at(query.first)
    status = Status.FREE if not found else Status.INITIAL_CONTACT if at_start else Status.CONTACT
    until = intervals[0].start if intervals else query.span[1]
    if reason is not None:
        status, until = Status.UNDECIDED, work.free_until
    return ContactIntervals(intervals, status, until, reason, query.stats(0, tests, evaluations), **query.shared)


class WindowEnd:
    """An end of an interval of contact: a root of the piece's u, or one of the piece's ends."""

    def __init__(self, search: CandidateSearch, root: Root | None, time: fmpq | None = None) -> None:
        self.search, self.root, self.time = search, root, time

    def is_at(self, time: fmpq) -> bool:
        if self.root is None:
            return self.time == time
        return self.search.pair.piece.clock.compare(self.root, time) == 0

    def is_same_time(self, other: WindowEnd) -> bool:
        """For an end of one piece and a start of the next: they can only meet where the pieces do."""
        return self.is_at(other.search.pair.piece.start) and other.is_at(other.search.pair.piece.start)

    def value(self, exact: bool) -> tuple[float, tuple[float, float], ExactTime | None]:
        if self.root is None:
            assert self.time is not None
            t = to_double(self.time)
            return t, (t, t), fraction(self.time) if exact else None
        t, around = world_time(self.search.pair, self.root)
        known = exact and isinstance(self.root, AlgebraicRoot)
        return t, around, self.search.pair.piece.exact_time(self.root) if known else None


def _windows(search: CandidateSearch, free_until: float) -> Iterator[tuple[WindowEnd, WindowEnd]]:
    """The closed windows of contact in one piece: between two candidates nothing changes.

    Models that are apart stay so until candidates that are contacts.  free_until: a time before which they are proved
    apart.
    """
    piece = search.pair.piece
    if piece.start == piece.end:
        yield from _instant(search)
        return
    start: WindowEnd | None = None
    apart = False
    doubt = ""  # why a candidate is open that may be all there is of a contact
    passed: list[Candidate] | None = None
    if any(isinstance(candidate.root, OpenRoot) for candidate in search.candidates):
        raise UnsupportedPair("an edge of degree 4 leaves a stretch of time undecided; its intervals are not supported")
    lo = piece.u_lo
    before = WindowEnd(search, None, piece.start)
    for group in search.groups():
        root = group[0].root
        if world_time(search.pair, root)[1][1] < free_until:
            apart, before, lo = True, WindowEnd(search, root), search.beyond(root)
            continue
        if piece.clock.compare(root, piece.start) > 0:
            if not apart and _share(search, between(lo, root), passed if start else None):
                start = start or before
            else:
                _refuse(doubt)
                if start is not None:
                    yield start, before
                start, apart = None, True
        here, doubt = WindowEnd(search, root), ""
        if start is None:
            start = here if search.meetings(group) else None
            doubt = "" if start else search.doubt(group)
        apart = apart and start is None and not doubt
        before, lo, passed = here, search.beyond(root), group
    assert piece.u_hi is not None and piece.end is not None
    if before.root is None or piece.clock.compare(before.root, piece.end) < 0:
        if not apart and _share(search, (lo + piece.u_hi) / 2, passed if start else None):
            yield start or before, WindowEnd(search, None, piece.end)
            return
        if apart and search.may_share_a_point_at_end():
            raise UnsupportedPair("the models share a point though no candidate is a contact")
    _refuse(doubt)
    if start is not None:
        yield start, before


def _refuse(doubt: str) -> None:
    if doubt:
        raise UnsupportedPair(doubt)


def _instant(search: CandidateSearch) -> Iterator[tuple[WindowEnd, WindowEnd]]:
    """That of a piece that is one instant: no times between candidates are left at which to look.

    u_lo is the instant, or before it where that is irrational, with no candidate between.
    """
    touching = search.at_start()
    if touching or _share(search, search.pair.piece.u_lo, None):
        end = WindowEnd(search, None, search.pair.piece.start)
        yield end, end
    elif touching is None:
        raise UnsupportedPair("the models come so close that it is not told whether they touch")


def _share(search: CandidateSearch, u: fmpq, passed: list[Candidate] | None) -> bool:
    """Whether the models share a point at u, which is no candidate; passed: as for `share_a_point`."""
    shared = search.share_a_point(u, passed)
    if shared is None:
        raise UnsupportedPair("the models come so close that it is not proved whether they touch")
    return shared
