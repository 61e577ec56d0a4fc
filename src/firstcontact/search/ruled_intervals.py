"""All times at which two moving ruled pieces are in contact: the changes between contact and none, with enclosures.

Free time is passed by the search for the next event, contact by stretches proved to hold a contact at all their times;
where neither goes on, all events nearby are isolated, and the state between two of them is decided at rest.
"""

from __future__ import annotations

from dataclasses import dataclass

from flint import fmpq

from firstcontact.search.ruled_events import ROUNDINGS, RuledEvent, Search
from firstcontact.search.ruled_pieces import RuledPiece
from firstcontact.search.ruled_search import ALL_EVENTS, DONE, FIRST_EVENT, SURE
from firstcontact.search.stretches import above, below

REACH = 1 / 64
"""Part of the span over which events are listed at a time, where no more is known."""
LEAST_REACH = REACH / 4096
LEAST_STEP = 1e-8
"""Part of the span below which neither proofs nor lists are tried."""
COVER = 1 / 4096
"""Part of the span below which proofs of contact over stretches are given up for a list of events."""
AT_REST_BUDGET, STRETCH_BUDGET, MOST_STRETCH_BUDGET, EVENTS_BUDGET, FREE_BUDGET = 4_000, 200, 2_000, 8_000, 200_000


@dataclass(frozen=True)
class RuledInterval:
    """Closed times of contact; start and end are enclosures (lo, hi) of either end."""

    start: tuple[float, float]
    end: tuple[float, float]
    first: RuledEvent | None = None
    last: RuledEvent | None = None


@dataclass(frozen=True)
class RuledIntervals:
    """intervals: of contact, in order; unsettled: times (lo, hi) at which the state is not decided, all others are.

    An interval that ends (or starts) beside unsettled times has these as the enclosure of its end.
    """

    intervals: tuple[RuledInterval, ...]
    unsettled: tuple[tuple[float, float], ...]
    boxes: int


@dataclass(frozen=True)
class _Change:
    """Events that are not told apart in time; sure: one of them certainly is a contact."""

    lo: float
    hi: float
    event: RuledEvent | None
    sure: bool


def contact_times(
    p: RuledPiece, q: RuledPiece, first: fmpq, last: fmpq, tolerance: float = 1e-12, budget: int = 1_000_000
) -> RuledIntervals:
    """All contacts of two pieces over the closed [first, last]; budget: boxes after which the rest stays unsettled."""
    return _Sweep(p, q, below(first), above(last), tolerance, budget).run()


class _Sweep:
    def __init__(self, p: RuledPiece, q: RuledPiece, lo: float, hi: float, tolerance: float, budget: int) -> None:
        self.search, self.backward, self.budget = Search(p, q), (p, q), budget
        self.lo, self.hi = lo, hi
        self.span = hi - lo
        self.width = max(0.1 * tolerance * self.span, ROUNDINGS * max(abs(lo), abs(hi)))
        self.intervals: list[RuledInterval] = []
        self.unsettled: list[tuple[float, float]] = []
        self.start: _Change | None = None
        self.jump = LEAST_STEP * self.span

    def run(self) -> RuledIntervals:
        t, state = self.lo, self._state(self.lo)
        if state is None:
            t, state = self._jump(self.lo)
        elif state:
            self.start = _Change(self.lo, self.lo, None, True)
        while t < self.hi:
            t = self._covered(t) if state else self._freed(t)
            if t >= self.hi:
                break
            if self.search.visits > self.budget:
                self._give_up(t)
                break
            changes, reach = self._changes(t)
            if changes is None:
                t, state = self._jump(self._covered(t, LEAST_STEP) if state else t)
                continue
            limits = [*(c.lo for c in changes[1:]), reach]
            t = reach
            for change, limit in zip(changes, limits, strict=False):
                middle = 0.5 * (change.hi + limit)
                after = self._state(middle) if change.hi < middle < self.hi else None
                if after is None and change.hi < self.hi:
                    t, state = self._jump(change.lo)
                    break
                if after is None:
                    t = self._end_of_span(change, bool(state))
                    break
                self._pass(change, bool(state), after)
                state = after
        if self.start is not None:  # the contact lasts
            self._close(_Change(self.hi, self.hi, None, True))
        return RuledIntervals(tuple(self.intervals), tuple(_joined(self.unsettled)), self.search.visits)

    def _pass(self, change: _Change, before: bool, after: bool) -> None:
        if after and not before:
            self.start = change
        elif before and not after:
            self._close(change)
        elif not before:
            if change.sure and change.event is not None:
                self.intervals.append(
                    RuledInterval((change.lo, change.hi), (change.lo, change.hi), change.event, change.event)
                )
            else:
                self.unsettled.append((change.lo, change.hi))

    def _give_up(self, t: float) -> None:
        """What is left of the span stays unsettled."""
        self.unsettled.append((t, self.hi))
        if self.start is not None:
            self._close(_Change(t, self.hi, None, False))

    def _end_of_span(self, change: _Change, before: bool) -> float:
        """Events that are not told apart from the end of the span."""
        if not before:
            self.unsettled.append((change.lo, self.hi))
        return self.hi

    def _close(self, end: _Change) -> None:
        assert self.start is not None
        start, self.start = self.start, None
        self.intervals.append(RuledInterval((start.lo, start.hi), (end.lo, end.hi), start.event, end.event))

    def _state(self, t: float) -> bool | None:
        return self.search.at_rest(t, t, self.width, AT_REST_BUDGET)

    def _freed(self, t: float) -> float:
        """A time from t, free at t, until which there is no contact."""
        self.search.run(t, self.hi, FIRST_EVENT, self.width, FREE_BUDGET)
        return min(float(self.search.limit[0]), self.hi)

    def _covered(self, t: float, least: float = COVER) -> float:
        """A time from t, in contact at t, until which there is contact; least: of the steps, in parts of the span."""
        before = self.search.visits
        self._state(t)
        budget = min(STRETCH_BUDGET + 4 * (self.search.visits - before), MOST_STRETCH_BUDGET)
        step = self.span / 16
        while t < self.hi and step > least * self.span:
            end = min(t + step, self.hi)
            if self.search.at_rest(t, end, self.width, budget):
                t, step = end, 2 * step
            else:
                step /= 4
        return t

    def _changes(self, t: float) -> tuple[list[_Change] | None, float]:
        """All events from t on to a later time; None where they are too many."""
        reach = REACH
        while reach >= LEAST_REACH:
            end = min(t + reach * self.span, self.hi)
            if self.search.run(t, end, ALL_EVENTS, self.width, EVENTS_BUDGET) == DONE:
                return self._clusters(), end
            reach /= 8
        return None, t

    def _clusters(self) -> list[_Change]:
        s = self.search
        order = sorted(range(s.count), key=lambda k: float(s.found[k, 4, 0]))
        found: list[_Change] = []
        rows: list[int] = []
        hi = 0.0
        for k in order:
            if rows and float(s.found[k, 4, 0]) > hi + 8 * self.width:
                found.append(self._change(rows, hi))
                rows = []
            hi = max(hi, float(s.found[k, 4, 1])) if rows else float(s.found[k, 4, 1])
            rows.append(k)
        return [*found, self._change(rows, hi)] if rows else found

    def _change(self, rows: list[int], hi: float) -> _Change:
        s = self.search
        sure = [k for k in rows if s.found_kinds[k, SURE]]
        lo = min(float(s.found[k, 4, 0]) for k in rows)
        event = None
        if sure:
            row = min(sure, key=lambda k: (int(s.found_kinds[k, 2]).bit_count(), k))
            event = s.event(row)
        return _Change(lo, hi, event, bool(sure))

    def _jump(self, t: float) -> tuple[float, bool]:
        """A later time with a decided state, where what follows t is not; what lies between is unsettled."""
        begin, state = t, None
        self.jump *= 8  # lest there be many
        step = self.jump
        while t < self.hi and state is None:
            t = min(t + step, self.hi)
            step *= 4
            state = self._state(t)
        if state is not None:
            t = self._back(begin, t, state)
        self.unsettled.append((begin, t))
        if self.start is not None:
            self._close(_Change(begin, t, None, False))
        if state:
            self.start = _Change(begin, t, None, False)
        return t, bool(state)

    def _back(self, lo: float, t: float, state: bool) -> float:
        """An earlier time than t in the same state, without any change between."""
        if not state:
            p, q = (x.reversed() for x in self.backward)
            backward = Search(p, q)
            backward.run(-t, -lo, FIRST_EVENT, self.width, FREE_BUDGET)
            self.search.visits += backward.visits
            return max(-float(backward.limit[0]), lo)
        step, least = 0.25 * (t - lo), 1e-3 * (t - lo)
        while step > least:
            if t - step > lo and self.search.at_rest(t - step, t, self.width, STRETCH_BUDGET):
                t -= step
            else:
                step *= 0.5
        return t


def _joined(stretches: list[tuple[float, float]]) -> list[tuple[float, float]]:
    joined: list[tuple[float, float]] = []
    for lo, hi in sorted(stretches):
        if joined and lo <= joined[-1][1]:
            joined[-1] = joined[-1][0], max(hi, joined[-1][1])
        else:
            joined.append((lo, hi))
    return joined
