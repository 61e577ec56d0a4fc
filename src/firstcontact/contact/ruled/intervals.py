"""All times of contact of two moving ruled pieces, proved in doubles and balls.

`contact.models.intervals` follows them: free time is passed by the search for the next event, contact by stretches
proved to hold a contact at all their times, and where it may end the last contact is the first one with time running
backwards.  Nothing changes between two events next to each other, listed in doubles or, closer up, in balls; the state
there is decided at rest.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import ClassVar, NamedTuple

import numpy as np
from flint import fmpq

from firstcontact.exact.numbers import above, ball_bounds, below, exact_value
from firstcontact.kernels.rulings.search import ALL_EVENTS, DONE, SURE
from firstcontact.search.rulings.ruled_events import ROUNDINGS, Held, RuledContact, RulingSearch, first_event_of
from firstcontact.search.rulings.ruled_pieces import RuledPiece
from firstcontact.timeline.sweep import FirstTouch, Found, TimeSweep, Unproved
from firstcontact.work import Work

REACHES = tuple(2.0**-k for k in (6, 9))
"""Parts of the span over which events are listed at a time, until they are few enough."""
CLOSE_REACHES = tuple(2.0**-k for k in (11, 15, 20, 30))
"""The same in balls."""
LONGEST = 1 / 16
"""Part of the span: the longest step in one proof of lasting contact."""
AHEAD = 2.0**-14
"""Part of the span: how far ahead contact is looked for where it cannot be followed."""
AT_REST_BUDGET, STRETCH_BUDGET, MOST_STRETCH_BUDGET, EVENTS_BUDGET, FREE_BUDGET = 20_000, 200, 8_000, 8_000, 200_000
ROUNDS = 2
"""How often the search for a first event starts anew from where it has come to."""
BALLS_BUDGET, NEAR_BUDGET = 30_000, 100
MOST_IN_BALLS = 64
NEARBY = 1 / 64
"""How far from a known contact, in u, s, v and t of a part, the next one is looked for at first."""
BUDGET = 1_000_000
"""Boxes after which the rest stays open, where the caller sets no limit."""
SHARED = np.zeros(0)
"""Stands for a common point, which no proof here asks for."""


class TimeWay(NamedTuple):
    """A stretch of time for the sweep; its times run backwards where the pieces are to be seen at times -t."""

    first: float
    last: float
    inner: float
    backwards: bool


@dataclass(frozen=True)
class Change:
    """Events that are not told apart in time; is_contact: one of them certainly is a contact."""

    lo: float
    hi: float
    is_contact: bool


def certified_intervals(
    p: RuledPiece, q: RuledPiece, first: fmpq, last: fmpq, tolerance: float = 1e-12, work: Work | None = None
) -> Found:
    """All closed times of contact over [first, last]; events within `tolerance` of the span are not told apart.

    work: its budget counts boxes.
    """
    return _RuledSweep(p, q, first, last, tolerance, work or Work()).run()


class Known(NamedTuple):
    """The state at a time, the contact that was found, and how many boxes that took."""

    time: float
    state: bool | None
    held: Held | None
    visits: int


class _PieceTimes:
    """Both pieces, forwards and backwards, as the sweep asks for free time and lasting contact."""

    def __init__(self, p: RuledPiece, q: RuledPiece, span: float, width: float, budget: int | None) -> None:
        self.pieces, self.span, self.width = (p, q), span, width
        self.most = BUDGET if budget is None else budget
        self.limit = math.inf if budget is None else budget
        self.searches: dict[bool, RulingSearch] = {}
        self.known: dict[bool, Known] = {}
        """Backwards and forwards, the state asked for last."""

    def search(self, way: TimeWay) -> RulingSearch:
        if way.backwards not in self.searches:
            p, q = self.pieces
            if way.backwards:
                p, q = p.reversed(), q.reversed()
            self.searches[way.backwards] = RulingSearch(p, q, self.limit)
        return self.searches[way.backwards]

    def allowed(self, boxes: int) -> int:
        """As many boxes as that, if so many are left."""
        return max(1, min(boxes, self.most - self.visits))

    @property
    def visits(self) -> int:
        return sum(s.spent for s in self.searches.values())

    def state(self, way: TimeWay, t: float) -> bool | None:
        """Whether there is contact at t."""
        known = self.known.get(way.backwards)
        if known is None or known.time != t:
            search = self.search(way)
            before = search.visits
            state = search.at_rest(t, t, self.width, self.allowed(AT_REST_BUDGET))
            known = Known(t, state, search.proved() if state else None, search.visits - before)
            self.known[way.backwards] = known
        return known.state

    def first_event(self, way: TimeWay, t: float, end: float, width: float) -> RuledContact:
        """The first contact from t to `end`, its time enclosed within `width` where that is possible."""
        search = self.search(way)
        for _ in range(ROUNDS):
            budget = self.allowed(FREE_BUDGET)
            found = first_event_of(search, exact_value(t), exact_value(end), width / (end - t), budget)
            if found.reason != "budget" or not t < found.free_until < end:
                break
            t = found.free_until
        return found

    def changes(self, way: TimeWay, t: float, end: float) -> Iterator[tuple[list[Change], float]]:
        """(all changes from t on, in order, to a time up to `end`), ever closer up."""
        yield from self.in_doubles(way, t, end)
        yield from self.in_balls(way, t, end)

    def in_doubles(self, way: TimeWay, t: float, end: float) -> Iterator[tuple[list[Change], float]]:
        """As `changes`: once, where they are few enough."""
        return islice(self._closer(self.in_doubles_until, REACHES, way, t, end), 1)

    def in_balls(self, way: TimeWay, t: float, end: float) -> Iterator[tuple[list[Change], float]]:
        return self._closer(self.in_balls_until, CLOSE_REACHES, way, t, end)

    def _closer(
        self, listed: Callable[[TimeWay, float, float], list[Change] | None],
        reaches: Sequence[float], way: TimeWay, t: float,
        end: float,
    ) -> Iterator[tuple[list[Change], float]]:
        for reach in reaches:
            until = min(t + reach * self.span, end)
            found = listed(way, t, until)
            if found is not None:
                yield found, until

    def in_doubles_until(self, way: TimeWay, t: float, until: float) -> list[Change] | None:
        s = self.search(way)
        if s.run(t, until, ALL_EVENTS, self.width, self.allowed(EVENTS_BUDGET)) != DONE:
            return None
        rows = []
        for k, (lo, hi) in enumerate(s.found[: s.count, 4].tolist()):
            if s.found_kinds[k, SURE]:  # of a contact in the box or near it
                lo, hi = min(lo, float(s.times[k, 0])), max(hi, float(s.times[k, 1]))
            rows.append(Change(lo, hi, bool(s.found_kinds[k, SURE])))
        return self._merged(rows)

    def in_balls_until(self, way: TimeWay, t: float, until: float) -> list[Change] | None:
        listed = self.search(way).listed(t, self.width, until - t, self.allowed(BALLS_BUDGET), MOST_IN_BALLS)
        if listed is None:
            return None
        return self._merged([Change(*ball_bounds(x.time), x.is_contact) for x in listed])

    def _merged(self, events: Sequence[Change]) -> list[Change]:
        """Those that are not told apart made one."""
        found: list[Change] = []
        for x in sorted(events, key=lambda x: x.lo):
            if found and x.lo <= found[-1].hi + 8 * self.width:
                last = found[-1]
                found[-1] = Change(last.lo, max(last.hi, x.hi), last.is_contact or x.is_contact)
            else:
                found.append(x)
        return found


class _FreeOfPieces:
    def __init__(self, pair: _PieceTimes) -> None:
        self.pair = pair

    def at(self, way: TimeWay, t: float) -> bool:
        return self.pair.state(way, t) is False

    def until(self, way: TimeWay, t: float, end: float) -> tuple[float, list[np.ndarray]]:
        raise NotImplementedError  # the sweep's own `touch` passes free time

    def near_start(self, way: TimeWay) -> list[np.ndarray]:
        return []

    def passage(self, way: TimeWay, t: float) -> None:
        return None


class _Lasting:
    worth: ClassVar[int] = 1

    def __init__(self, pair: _PieceTimes) -> None:
        self.pair = pair

    def deepest(self, way: TimeWay, t: float, seeds: Sequence[np.ndarray]) -> np.ndarray | None:
        return SHARED if self.pair.state(way, t) else None

    def kept(self, way: TimeWay, t: float, place: np.ndarray) -> np.ndarray | None:
        return self.deepest(way, t, (place,))

    def anywhere(self, way: TimeWay, t: float) -> np.ndarray | None:
        return self.deepest(way, t, ())

    def until(
        self, way: TimeWay, t: float, end: float, point: np.ndarray, least: float, step: Callable[[], None]
    ) -> tuple[float, np.ndarray]:
        """(a time up to which there is contact from t on, a common point then)."""
        pair, search = self.pair, self.pair.search(way)
        pair.state(way, t)
        known = pair.known[way.backwards]
        held, budget = known.held, min(STRETCH_BUDGET + 4 * known.visits, MOST_STRETCH_BUDGET)
        length, longest = LONGEST * pair.span, 0.0
        while t < end and held is not None:
            step()
            least_part = max(least * longest, pair.width)
            found = None
            for part, near, reach, allowed in _tries(length, held, budget):
                later = min(t + part, end)
                if part >= least_part and later > t:
                    found = search.held(t, later, pair.width, pair.allowed(allowed), near, reach)
                if found is not None:
                    longest = max(longest, later - t)
                    t, length = later, 2.0 * part
                    pair.known[way.backwards] = Known(t, True, found, known.visits)
                    break
            held = found
        return t, point


def _tries(length: float, held: Held, budget: int) -> Iterator[tuple[float, Held | None, float, int]]:
    """(length of a stretch, near which contact one is looked for, how near, boxes): what is cheap first."""
    for k in range(3):
        yield length / 4**k, held, NEARBY, NEAR_BUDGET
    for k in range(1, 3):
        yield length / 4**k, None, 0.0, budget
    for k in range(3, 24):
        yield length / 4**k, held, NEARBY, NEAR_BUDGET


class _RuledSweep(TimeSweep[TimeWay]):
    most_turns = 200

    def __init__(
        self, p: RuledPiece, q: RuledPiece, first: fmpq, last: fmpq, tolerance: float, work: Work
    ) -> None:
        way = TimeWay(below(first), above(last), below(last), False)
        span = way.last - way.first
        width = max(tolerance * span, 10 * ROUNDINGS * max(abs(way.first), abs(way.last)))
        self.pair = _PieceTimes(p, q, span, 0.1 * width, work.budget)
        super().__init__(_FreeOfPieces(self.pair), _Lasting(self.pair), [way], width, work, lambda: None)

    def run(self) -> Found:
        found = super().run()
        if found.reason is not None and self.pair.visits >= self.pair.most:  # the last proofs had not all they ask for
            return replace(found, reason="budget")
        return found

    def _step(self, worth: int = 1) -> None:
        """Count the boxes since the last time."""
        self.work.done = self.pair.visits
        if self.work.budget is None and self.work.done > BUDGET:
            raise Unproved(self.reached)
        super()._step(worth)

    def _ahead(self, way: TimeWay, t: float, share: float) -> Iterator[float]:
        return (x for x in super()._ahead(way, t, share) if x - t >= AHEAD * self.pair.span or x == way.last)

    def _mirrored(self, way: TimeWay) -> TimeWay:
        return TimeWay(-way.last, -way.first, -math.nextafter(way.first, math.inf), not way.backwards)

    def touch(self, way: TimeWay, t: float, end: float) -> FirstTouch | None:
        found = self.pair.first_event(way, t, end, self.width)
        if found.status == "free":
            return None
        lo = max(t, found.free_until)
        if found.time_interval is None:
            return FirstTouch(lo, lo, sure=False)
        hi = max(lo, found.time_interval[1])
        for listed in (self.pair.in_doubles, self.pair.in_balls):
            for changes, reached in listed(way, lo, end):
                if not changes or changes[0].hi - lo > self.width:
                    continue
                after = self._between(way, max(hi, changes[0].hi), changes[1].lo if len(changes) > 1 else reached)
                if after is not None:
                    at, state = after
                    if state:
                        return FirstTouch(lo, hi, True, at, SHARED)
                    return FirstTouch(lo, max(hi, changes[0].hi), True, at)
            at = min(lo + 0.9 * self.width, end, way.inner)
            if hi <= at and self.pair.state(way, at):
                return FirstTouch(lo, at, True, at, SHARED)
        return FirstTouch(lo, hi)

    def _lost_before(self, way: TimeWay, t: float, later: float, point: np.ndarray) -> float | None:
        try:
            return super()._lost_before(way, t, later, point)
        except Unproved:
            if self.pair.in_balls_until(way, t, later) == []:
                return None
            raise

    def _finer(self, way: TimeWay, t: float) -> tuple[float, np.ndarray | None]:
        """As `_enter` or `_leave`: by all changes from t on."""
        self._step()
        for changes, reached in self.pair.changes(way, t, way.last):
            if changes and changes[0].hi - changes[0].lo > self.width:
                break  # closer up it will not be told, either
            if any(x.hi - x.lo > self.width for x in changes):
                continue
            limits = [*(x.lo for x in changes[1:]), reached]
            after = [self._between(way, x.hi, limit) for x, limit in zip(changes, limits, strict=False)]
            known = [x for x in after if x is not None]
            if len(known) == len(changes):
                return self._passed(changes, known, reached)
        raise Unproved(t)

    def _passed(
        self, changes: list[Change], after: list[tuple[float, bool]], reached: float
    ) -> tuple[float, np.ndarray | None]:
        """(the time reached, a common point then or None), with all that begins or ends at the changes."""
        contact = self.start is not None
        for change, (at, state) in zip(changes, after, strict=True):
            if not contact and not state and not change.is_contact:
                raise Unproved(change.lo)
            if not contact and (state or change.is_contact):
                self.start, self.turns = (change.lo, change.hi), 0
            if not state:
                self._close((change.lo, change.hi))
            contact, self.reached = state, at
        return reached, SHARED if contact else None

    def _between(self, way: TimeWay, lo: float, hi: float) -> tuple[float, bool] | None:
        """(a time from lo to hi, whether there is contact then); None where no such time shows that."""
        for share in (0.5, 0.9):
            t = lo + share * (hi - lo)
            if lo < t < hi and (state := self.pair.state(way, t)) is not None:
                return t, state
        return None
