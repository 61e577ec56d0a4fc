"""Two ruled surfaces under motions that no rational function describes: screws, turns about different axes.

The relative motion is cut into windows in which it is a polynomial but for a proved rest
(`search.rulings.posed_pieces`).  In each the search in doubles decides, and events are refined in balls with the motion
itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.contact.ruled.certified import BUDGET, described
from firstcontact.contact.ruled.intervals import certified_intervals
from firstcontact.contact.ruled.triangles import MOST_PAIRS, Interior, near_pairs, triangles_of
from firstcontact.contact.ruled.trimmed_cells import MOST_DEPTH, PieceCell
from firstcontact.contact.signs.conditions import check_weight
from firstcontact.contact.swapped import swapped
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import below
from firstcontact.exact.rigid import compose, inverse_map
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative import projective
from firstcontact.motion.relative.clocks import StraightClock
from firstcontact.motion.relative.curved import CurvedPiece
from firstcontact.motion.relative.pieces import curved_pieces
from firstcontact.motion.relative.polynomial import PolynomialPiece
from firstcontact.result import ContactIntervals, FirstContact, Status
from firstcontact.search.rulings.directrices import signed
from firstcontact.search.rulings.posed_pieces import PosedPiece, PoseWindow, in_local_time, pose_windows
from firstcontact.search.rulings.ruled_events import RuledContact, RulingSearch, told_event_of
from firstcontact.search.rulings.ruled_pieces import RuledPiece
from firstcontact.timeline.answers import proved_intervals
from firstcontact.timeline.sweep import Certified, Found
from firstcontact.work import Query, Spent, Work

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, RuledBody

MOST_TOLERANCE = 1e-3
"""Of a window's time."""


MOST_SPLITS = 500
"""Of the cells of trimmed pieces in a window."""


@dataclass(frozen=True, eq=False)
class _Found:
    """What is proved of two cells in a window, in true time."""

    contact: RuledContact
    cells: tuple[PieceCell, PieceCell]
    free_until: float
    interval: tuple[float, float] | None

    @property
    def is_free(self) -> bool:
        return self.contact.status == "free"

    @property
    def is_initial(self) -> bool:
        return self.contact.status == "initial"

    @property
    def is_sure(self) -> bool:
        """Whether the bodies share what the cells are proved to share."""
        return self.interval is not None and all(cell.is_sure for cell in self.cells)


def first(query: Query, work: Work) -> FirstContact:
    """The first contact with an enclosure of its time; UNDECIDED where doubles and balls do not tell."""
    ordered = _mover_first(query)
    found = _first(ordered, work)
    return found if ordered is query else swapped(found)


def _mover_first(query: Query) -> Query:
    """With a body at rest as b: poses seen from it are shorter polynomials than those of the rest seen from a turn."""
    rests = [not isinstance(x, Moving) for x in query.bodies]
    return replace(query, a=query.b, b=query.a) if rests[0] and not rests[1] else query


def _first(query: Query, work: Work) -> FirstContact:
    pair = _Pair(query)
    for window in pair.windows():
        work.reached(max(below(window.start), query.span[0]))
        try:
            found = _split([pair.searched(window, *cells, work) for cells in pair.near(window)], pair, window, work)
        except Spent:
            return _undecided(work.free_until, "budget", work, query)
        met = [x for x in found if x.is_sure]
        left = [x for x in found if not x.is_free and not x.is_sure]
        at_start = window.start == query.first
        if at_start and not any(x.is_initial for x in met) and pair.is_contained(window.motion):
            time = query.span[0]
            how = None if any(x.free_until <= time for x in left) else "containment"
            return FirstContact(
                Status.INITIAL_CONTACT, time, (time, time), initial=how, free_until=time, stats=query.stats(work.done),
                **query.shared,
            )  # fmt: skip
        best = min(met, key=lambda x: x.interval, default=None)  # type: ignore[arg-type,return-value]
        until = min((x.free_until for x in left), default=None)
        if best is not None and best.interval is not None and (until is None or best.interval[1] <= until):
            later = (x.is_free or best.interval[1] < x.free_until for x in found if x is not best)
            alone = best.contact.isolated and all(later)
            return _answer(pair, window, best, at_start, alone, work)
        if until is not None:
            reason = "budget" if any(x.contact.reason == "budget" for x in left) else "precision"
            return _undecided(until, reason, work, query)
    return FirstContact.free(query.stats(work.done), **query.shared)


def _split(found: list[_Found], pair: _Pair, window: PoseWindow, work: Work) -> list[_Found]:
    """What meets first, if trimming may cut it away, as its quarters: again and again, until that is told."""
    for _ in range(MOST_SPLITS):
        first = min((x for x in found if not x.is_free), key=lambda x: x.free_until, default=None)
        if first is None or first.is_sure or first.interval is None:
            break
        split = min((cell for cell in first.cells if not cell.is_sure), key=lambda cell: cell.depth)
        if split.depth == MOST_DEPTH:
            break
        pairs = [[x] if x is not split else split.quarters for x in first.cells]
        found = [x for x in found if x is not first]
        found += [pair.searched(window, x, y, work) for x, y in product(*pairs)]
    return found


def intervals(query: Query, work: Work) -> ContactIntervals:
    """All contacts with enclosures of their ends; UNDECIDED from the first time on at which nothing is proved."""
    return replace(_intervals(_mover_first(query), work), a=query.a, b=query.b)


def _intervals(query: Query, work: Work) -> ContactIntervals:
    pair, intervals, last = _Pair(query), list[Certified](), query.span[1]
    if pair.interior is not None or not all(cell.is_sure for own in pair.cells for cell in own):
        return _by_first_contact(query, work)
    for window in pair.windows():
        work.reached(max(below(window.start), query.span[0]))
        found = [pair.followed(window, *cells, work) for cells in pair.near(window)]
        intervals = _united([*intervals, *(x for own in found for x in own.intervals)])
        stopped = min((own for own in found if own.reason is not None), key=lambda own: own.until, default=None)
        if stopped is not None:
            return proved_intervals(Found(tuple(intervals), stopped.until, stopped.reason), work, query)
    return proved_intervals(Found(tuple(intervals), last, None), work, query)


def _by_first_contact(query: Query, work: Work) -> ContactIntervals:
    """Up to the first contact, the end of which is left open, for contact may be with what is cut off or inside."""
    found, last = _first(query, work), query.span[1]
    if found.status is Status.FREE:
        return proved_intervals(Found((), last, None), work, query)
    if found.time_interval is None:
        assert found.free_until is not None
        return proved_intervals(Found((), found.free_until, found.reason), work, query)
    hi = found.time_interval[1]
    return proved_intervals(Found((Certified(found.time_interval, (hi, last), True),), hi, "precision"), work, query)


def _united(intervals: list[Certified]) -> list[Certified]:
    """The union; ends of one and starts of another that are not told apart count as one time."""
    found: list[Certified] = []
    for x in sorted(intervals, key=lambda x: x.start):
        if found and x.start[0] <= found[-1].end[1]:
            y = found[-1]
            ends = tuple(map(max, x.end, y.end))
            found[-1] = replace(y, start=(y.start[0], min(x.start[1], y.start[1])), end=ends)  # type: ignore[arg-type]
        else:
            found.append(x)
    return found


def _undecided(until: float, reason: str, work: Work, query: Query) -> FirstContact:
    until = max(until, query.span[0])
    return FirstContact(
        Status.UNDECIDED, free_until=until, reason=reason, stats=query.stats(work.done), **query.shared
    )


def _answer(pair: _Pair, window: PoseWindow, found: _Found, at_start: bool, alone: bool, work: Work) -> FirstContact:
    """alone: whether its point is all that the bodies share then."""
    query = pair.query
    assert found.interval is not None
    lo, hi = found.interval
    initial = at_start and found.is_initial
    status = Status.INITIAL_CONTACT if initial else Status.CONTACT
    assert found.contact.time is not None
    time = lo if initial else min(max(window.true_time(found.contact.time), lo), hi)
    answer: dict[str, Any] = {"free_until": lo, "stats": query.stats(work.done), **query.shared}
    if initial and pair.interior is None:
        answer["initial"] = "touching"
    if found.contact.event is not None:
        pose = window.motion.carry(time)
        pose = np.eye(4) if pose is None else pose
        joined = tuple(cell.surface.joined for cell in found.cells)
        numbers = tuple(cell.number for cell in found.cells)
        answer |= described(found.contact.event, pose, not initial, query.shared, numbers, joined, alone)  # type: ignore[arg-type]
    return FirstContact(status, time, found.interval, **answer)


class _Pair:
    """The pieces of both surfaces and the windows of their relative motion."""

    def __init__(self, query: Query) -> None:
        self.query, self.bodies, self.first, self.last = query, query.bodies, query.first, query.end
        self.interior = Interior.of(*query.bodies)
        self.cells: list[list[PieceCell]] = []
        for body in query.bodies:
            shape = shape_of(body)
            pieces = triangles_of(shape) if isinstance(shape, Polyhedron) else shape.pieces
            for piece in pieces:
                if piece.s is None:
                    raise UnsupportedPair(f"{piece!r} has whole rulings, which doubles do not take; bound s")
                for side in piece.sides:
                    check_weight(piece, side, (self.first, self.last))
            self.cells.append([PieceCell.of(piece, number) for number, piece in enumerate(pieces)])
        self.piece_of = cache(self._piece_of)

    def _piece_of(self, cell: PieceCell) -> RuledPiece:
        surface = cell.surface
        return RuledPiece.of(signed(surface.sides, surface, (self.first + self.last) / 2), surface.u)

    def windows(self) -> Iterator[PoseWindow]:
        for motion in curved_pieces(self.query.a, self.query.b, self.first, self.last):
            yield from pose_windows(motion, motion.start, motion.end)

    def is_contained(self, motion: CurvedPiece) -> bool:
        """Whether a solid polyhedron holds a piece at the start, where the surfaces share no point."""
        if self.interior is None:
            return False
        placed = motion.placed_at_start()
        if not all(place.is_exact for place in placed):
            raise UnsupportedPair("{!r} and {!r} start in an irrational pose".format(*self.bodies))
        pose = compose(inverse_map(placed[1].matrix()), placed[0].matrix())
        t = self.first
        still = PolynomialPiece(t, t, projective.fixed(pose), t, t, StraightClock(), True, "a body at the start")
        return self.interior.holds(still, t)

    def near(self, window: PoseWindow) -> list[tuple[PieceCell, PieceCell]]:
        """The cells that may meet."""
        if all(len(own) == 1 for own in self.cells):
            return [(self.cells[0][0], self.cells[1][0])]
        both = zip(self.cells, self.bodies, strict=True)
        a, b = ([_moving(cell.surface, body) for cell in own] for own, body in both)
        found = near_pairs(a, b, window.start, window.end, slabs=1)  # windows are short
        if len(found) > MOST_PAIRS:
            who = "{!r} and {!r}".format(*self.bodies)
            raise UnsupportedPair(f"{who}: {len(found)} pairs of pieces and triangles come near each other, too many")
        return [(self.cells[0][i], self.cells[1][j]) for i, j in found]

    def searched(self, window: PoseWindow, a: PieceCell, b: PieceCell, work: Work) -> _Found:
        budget = BUDGET if work.budget is None else work.budget - work.done
        if budget <= 0:
            raise Spent
        p, q = PosedPiece.posed(self.piece_of(a), window), in_local_time(self.piece_of(b), window)
        search = RulingSearch(p, q, math.inf if work.budget is None else budget)
        found = told_event_of(search, fmpq(-1), fmpq(1), self.local(window), budget)
        work.done += found.boxes
        interval = None if found.time_interval is None else window.true_times(*found.time_interval)
        return _Found(found, (a, b), window.true_times(found.free_until, 1.0)[0], interval)

    def followed(self, window: PoseWindow, a: PieceCell, b: PieceCell, work: Work) -> Found:
        """All contacts of two pieces in a window."""
        p, q = PosedPiece.posed(self.piece_of(a), window), in_local_time(self.piece_of(b), window)
        own = Work(None if work.budget is None else max(work.budget - work.done, 1), None)
        found = certified_intervals(p, q, fmpq(-1), fmpq(1), self.local(window), own)
        work.done += own.done
        intervals = (
            replace(x, start=window.true_times(*x.start), end=window.true_times(*x.end)) for x in found.intervals
        )
        return Found(tuple(intervals), window.true_times(found.until, 1.0)[0], found.reason)

    def local(self, window: PoseWindow) -> float:
        """The tolerance, a part of the span, as a part of the window's time."""
        width = float(window.end - window.start)
        if width == 0.0:
            return MOST_TOLERANCE
        return min(self.query.tolerance * float(self.last - self.first) / width, MOST_TOLERANCE)


def _moving(surface: RuledSurface, body: Body) -> RuledBody:
    return Moving(surface, body.motion) if isinstance(body, Moving) else surface
