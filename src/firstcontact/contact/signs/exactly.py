"""Contact of two ruled pieces, or of one and a solid, decided by signs of polynomials: first contacts, all windows."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cmp_to_key
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from flint import arb, ctx, fmpq

from firstcontact.contact.leading import leads
from firstcontact.contact.signs.shared_points import FieldPoint
from firstcontact.contact.signs.sheets import between
from firstcontact.contact.signs.touches import RuledTouch, most_of
from firstcontact.contact.ways import Passed, tried
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import fraction, precision
from firstcontact.exact.times.instants import enclose
from firstcontact.motion.relative.clocks import StraightClock
from firstcontact.motion.relative.polynomial import PolynomialPiece
from firstcontact.result import (
    MOST_OTHERS,
    ContactIntervals,
    ContactSet,
    Element,
    ElementPair,
    FirstContact,
    Status,
)
from firstcontact.search.trees.touch import carried_normal
from firstcontact.timeline.answers import interval_of
from firstcontact.work import Query, Spent, Work

if TYPE_CHECKING:
    from firstcontact.motion.moving import Moving
    from firstcontact.result import ExactTime

BITS = 128
_ORDER = {"vertex": 0, "apex": 0, "edge": 1, "directrix": 1, "end_ruling": 2, "face": 3}


@dataclass(frozen=True)
class PiecePair:
    """Two ruled pieces, or one and a solid, over one piece of their motion.

    times    when they share points
    touch    what meets at a contact
    named    an element of a body ("a" or "b") as users call it; None for a point inside a solid
    lies     how they lie to each other at the motion's first parameter, where they are in contact
    """

    motion: PolynomialPiece
    times: Any
    touch: Callable[[FieldPoint], RuledTouch]
    named: Callable[[tuple[str, Any], str], Element | None]
    lies: Callable[[fmpq], str] = lambda u: "touching"


class Holding(Protocol):
    """A solid polyhedron that may hold pieces of the ruled body."""

    @property
    def is_convex(self) -> bool: ...
    def holds(self, motion: PolynomialPiece, x: fmpq) -> bool: ...
    def lies(self, motion: PolynomialPiece, x: fmpq) -> str: ...
    def shares_inner_points(self, motion: PolynomialPiece, x: fmpq) -> bool: ...


Stretches = Iterable[tuple[PolynomialPiece, list[PiecePair]]]
"""The pieces of the relative motion in time order, with the pairs of pieces of the bodies that may meet."""
Windows = list[tuple["TimeEnd", "TimeEnd"]]


def span_of(motion: PolynomialPiece) -> tuple[fmpq, fmpq]:
    """The parameters of a motion; UnsupportedPair where its poses are irrational."""
    if not motion.exact:
        raise UnsupportedPair(f"{motion.of}: the pose before this step is irrational; such steps are not supported")
    assert motion.u_hi is not None
    return motion.u_lo, motion.u_hi


@dataclass(frozen=True)
class TimeEnd:
    """A time: a value of the motion's parameter, or an end of the piece of motion."""

    motion: PolynomialPiece
    root: AlgebraicRoot
    time: fmpq | None

    @classmethod
    def of(cls, motion: PolynomialPiece, root: AlgebraicRoot) -> TimeEnd:
        assert motion.end is not None
        if motion.clock.compare(root, motion.start) <= 0:
            return cls(motion, root, motion.start)
        return cls(motion, root, motion.end if motion.clock.compare(root, motion.end) >= 0 else None)

    def compare(self, other: TimeEnd) -> int:
        """Of two ends in one piece of motion."""
        if self.time is not None and other.time is not None:
            return int(self.time > other.time) - int(self.time < other.time)
        return self.root.compare(other.root)

    def value(self, exact: bool) -> tuple[float, tuple[float, float], ExactTime | None]:
        """(nearest double, enclosure, exact time)."""
        if self.time is not None:
            time = self.time
            return *enclose(lambda: time), fraction(time) if exact else None
        rational = self.root.rational
        if rational is not None and isinstance(self.motion.clock, StraightClock):
            found = enclose(lambda: rational)
        else:
            found = enclose(lambda: self.motion.time_of(self.root.enclosure(ctx.prec)))
        return *found, self.motion.exact_time(self.root) if exact else None


def all_windows(stretches: Stretches, interior: Holding | None) -> tuple[Windows, str | None]:
    """All closed windows of contact, as far as the budget goes: then the reason is "budget"."""
    windows: Windows = []
    try:
        for motion, pairs in stretches:
            found_here = _joined([w for pair in pairs for w in _windows(pair)])
            if interior is not None:
                found_here = _joined([*found_here, *_inside(interior, motion, found_here)])
            for start, end in found_here:
                if windows and start.time is not None and windows[-1][1].time == start.time:
                    windows[-1] = windows[-1][0], end
                else:
                    windows.append((start, end))
    except Spent:
        return windows, "budget"
    return windows, None


def as_intervals(windows: Windows, reason: str | None, query: Query, work: Work) -> ContactIntervals:
    """The windows as a result."""
    intervals = tuple(interval_of(start, end, query.exact) for start, end in windows)
    at_start = bool(windows) and windows[0][0].time == query.first
    status = Status.FREE if not windows else Status.INITIAL_CONTACT if at_start else Status.CONTACT
    until = intervals[0].start if intervals else query.span[1]
    if reason is not None:
        status, until = Status.UNDECIDED, work.free_until
    stats = query.stats(exact_evaluations=work.done)
    return ContactIntervals(intervals, status, until, reason, stats, **query.shared)


def first(query: Query, stretches: Stretches, interior: Holding | None, work: Work) -> FirstContact:
    """The first contact in exact arithmetic."""
    try:
        for motion, pairs in stretches:
            starts = [(start, pair, lasts) for pair in pairs for start, lasts in _starts(pair)]
            earliest = min((start for start, _, _ in starts), key=cmp_to_key(TimeEnd.compare), default=None)
            at_start = earliest is not None and earliest.time == query.first
            if interior is not None and motion.start == query.first and not at_start:
                end = AlgebraicRoot.of(motion.u_hi) if earliest is None else earliest.root  # type: ignore[arg-type]
                if interior.holds(motion, _inner(motion, AlgebraicRoot.of(motion.u_lo), end)):
                    return _contained(query, work)
            if earliest is not None:
                now = [(pair, lasts) for start, pair, lasts in starts if start.compare(earliest) == 0]
                work.budget = None  # it is for the time; what meets then is found in any case
                found = _contact(earliest, now, query, interior)
                return replace(found, stats=query.stats(exact_evaluations=work.done))
    except Spent:
        stats = query.stats(exact_evaluations=work.done)
        return FirstContact(
            Status.UNDECIDED, free_until=work.free_until, reason="budget", stats=stats, **query.shared
        )
    return FirstContact.free(query.stats(exact_evaluations=work.done), **query.shared)


def _windows(pair: PiecePair) -> Iterator[tuple[TimeEnd, TimeEnd]]:
    """Closed windows of contact within the piece of motion, whose parameter may reach beyond it."""
    motion = pair.motion
    assert motion.end is not None
    for start, end in pair.times.windows():
        if motion.clock.compare(end, motion.start) >= 0 and motion.clock.compare(start, motion.end) <= 0:
            yield TimeEnd.of(motion, start), TimeEnd.of(motion, end)


def _starts(pair: PiecePair) -> Iterator[tuple[TimeEnd, bool]]:
    """The first time of contact in the piece of motion, if there is one, and whether contact lasts after it."""
    motion = pair.motion
    assert motion.end is not None
    for wall, touched, after in pair.times.states():
        if motion.clock.compare(wall, motion.end) > 0:
            return
        if after or (touched and motion.clock.compare(wall, motion.start) >= 0):
            # a cell that begins before the piece does may end before it, too
            if motion.clock.compare(wall, motion.start) < 0 and _next_wall(pair, wall) < 0:
                continue
            yield TimeEnd.of(motion, wall), after
            return


def _next_wall(pair: PiecePair, wall: AlgebraicRoot) -> int:
    """How the end of the cell after the wall compares with the start of the piece of motion."""
    later = [x for x in pair.times.candidates if x.compare(wall) > 0]
    end = later[0] if later else AlgebraicRoot.of(pair.times.span[1])
    return pair.motion.clock.compare(end, pair.motion.start)


def _by_start(x: tuple[TimeEnd, TimeEnd], y: tuple[TimeEnd, TimeEnd]) -> int:
    return x[0].compare(y[0])


def _joined(windows: list[tuple[TimeEnd, TimeEnd]]) -> list[tuple[TimeEnd, TimeEnd]]:
    """The union of closed windows in one piece of motion."""
    found: list[tuple[TimeEnd, TimeEnd]] = []
    for start, end in sorted(windows, key=cmp_to_key(_by_start)):
        if found and start.compare(found[-1][1]) <= 0:
            if end.compare(found[-1][1]) > 0:
                found[-1] = found[-1][0], end
        else:
            found.append((start, end))
    return found


def _inside(
    interior: Holding, motion: PolynomialPiece, windows: list[tuple[TimeEnd, TimeEnd]]
) -> Iterator[tuple[TimeEnd, TimeEnd]]:
    """The windows between those of contact of the surfaces in which the solid holds a piece."""
    assert motion.u_hi is not None and motion.end is not None
    walls = [AlgebraicRoot.of(motion.u_lo), *(end.root for w in windows for end in w), AlgebraicRoot.of(motion.u_hi)]
    for k, (lo, hi) in enumerate(zip(walls[::2], walls[1::2], strict=True)):
        at_start, at_end = k == 0, k == len(windows)
        if windows and ((at_start and windows[0][0].time == motion.start) or
                        (at_end and windows[-1][1].time == motion.end)):  # fmt: skip
            continue
        if interior.holds(motion, _inner(motion, lo, hi)):
            yield TimeEnd.of(motion, lo), TimeEnd.of(motion, hi)


def _inner(motion: PolynomialPiece, lo: AlgebraicRoot, hi: AlgebraicRoot) -> fmpq:
    """A parameter between two walls within the piece of motion; of an instant, its own."""
    if lo.compare(hi) >= 0 or motion.start == motion.end:
        return motion.u_lo
    while True:
        x = between(lo, hi)
        root = AlgebraicRoot.of(x)
        assert motion.end is not None
        if motion.clock.compare(root, motion.start) < 0:
            lo = root
        elif motion.clock.compare(root, motion.end) > 0:
            hi = root
        else:
            return x


def _contained(query: Query, work: Work) -> FirstContact:
    """The result for a start at which the solid holds a piece, and the surfaces share no point."""
    start = query.span[0]
    return FirstContact(
        Status.INITIAL_CONTACT, start, (start, start), fraction(query.first) if query.exact else None,
        initial="containment", free_until=start, stats=query.stats(exact_evaluations=work.done), **query.shared,
    )  # fmt: skip


# -- what meets -----------------------------------------------------------------------------------------------


def _contact(
    start: TimeEnd, pairs: list[tuple[PiecePair, bool]], query: Query, interior: Holding | None
) -> FirstContact:
    """The result at the first time, the lowest pair of elements first, by (kind, index) of that of the leading body."""
    time, interval, known = start.value(query.exact)
    initial = start.time == query.first
    touches: dict[tuple[tuple[int, int], ...], tuple[ElementPair, RuledTouch]] = {}
    for pair, lasts in pairs:
        for contact in _shared(pair, start, initial, lasts):
            found = pair.touch(contact)
            named = [pair.named(element, which) for element, which in zip(found.elements, "ab", strict=True)]
            key = tuple((_ORDER[e.kind], e.index) for e in named if e is not None)
            touches.setdefault(key, (ElementPair(*named), found))  # type: ignore[arg-type]
    status = Status.INITIAL_CONTACT if initial else Status.CONTACT
    answer = FirstContact(status, time, interval, known, free_until=interval[0], **query.shared)
    if initial:
        lies = (pair.lies(pair.motion.u_lo) for pair, _ in pairs)
        answer = replace(answer, initial=most_of(lies) if interior is None else _overlap(start, interior))
    if not touches:
        return answer
    way = 1 if len(touches) < 2 or leads(*query.bodies) else -1
    (lowest, best), *rest = (touches[key] for key in sorted(touches, key=lambda key: key[::way]))
    if lowest.element_b is None:  # inside a solid of planes and quadrics
        lowest = ElementPair(None, None)
    pose = _pose_of_b(start, query.b, time)
    point = pose[:3, :3] @ best.point + pose[:3, 3]
    shown = None
    if not rest and (len(best.shared) > 1 or (not initial and pairs[0][0].times.is_isolated(start.root))):
        shown = _contact_set(best.shared @ pose[:3, :3].T + pose[:3, 3])
    normal = None if best.normal is None or initial else carried_normal(pose, best.normal)
    return replace(
        answer, point=point, normal=normal, element_a=lowest.element_a, element_b=lowest.element_b,
        others=tuple(p for p, _ in rest[:MOST_OTHERS]), multiplicity=len(touches),
        contact_set=shown,
    )  # fmt: skip


def _shared(pair: PiecePair, start: TimeEnd, initial: bool, lasts: bool) -> list[FieldPoint]:
    """What the pieces share; [] where it is not told, while the time is proved."""
    at_start = initial and start.root.rational == pair.times.span[0]
    ask = pair.times.contact_at_start if at_start else lambda: pair.times.contacts_from(start.root, lasts)
    found = tried(ask)
    return [] if isinstance(found, Passed) else found


def _overlap(start: TimeEnd, interior: Holding) -> str | None:
    """How a surface meets a polyhedron at the start; None where that may hold inner points that were not found."""
    if start.root.rational is None:
        return None
    if interior.is_convex:
        return interior.lies(start.motion, start.root.rational)
    return "overlapping" if interior.shares_inner_points(start.motion, start.root.rational) else None


def _contact_set(points: np.ndarray) -> ContactSet:
    return ContactSet("point" if len(points) == 1 else "segment", points)


def _pose_of_b(start: TimeEnd, b: Moving, time: float) -> np.ndarray:
    frame = start.motion.frame
    if frame is None:  # bodies that turn about one line at different speeds
        return np.asarray(b.motion(time), float)
    u = start.root.enclosure(BITS)
    with precision(BITS):
        rows = [[x(u) for x in row] for row in frame]
        return np.array([[float((x / arb(rows[3][3])).mid()) for x in row] for row in rows])
