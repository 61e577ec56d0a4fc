"""All times of contact of two bodies under any motion, proved in doubles and balls.

Free time is passed by the searches for the first contact, contact by `lasting`.  Where contact may end, a later time is
proved free; the last contact before it is the first one with time running backwards, and from there contact is proved
back to where it was lost.  Where bodies nearly graze that is too coarse, and a `Passage` in finer arithmetic steps in.
What is proved neither way ends the answer.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import ClassVar, Generic, Protocol, TypeVar

import numpy as np
from flint import fmpq

from firstcontact.exact.numbers import above, below, exact_value
from firstcontact.kernels.poses import CENTRE, KIND, TURNING
from firstcontact.motion.relative.stretches import Window
from firstcontact.search.convex.close_up import Passage
from firstcontact.work import Spent, Work

AHEAD = (0.3, 0.3), (1e-3, 1e-4)
"""(Part of the longest step below which a proof of lasting contact gives up, part of the time passed in contact that
the first look ahead is from there).  Contact is told quickly back from where it is lost, so the end is sought soon;
what that does not settle is asked in small steps."""
LEAST_BACK = 1e-6
"""As the first of them, from the end of contact back."""
MOST_TURNS = 20
"""Stretches of one contact followed one after the other in one window before the rest is left open."""
MOST_PACES, SLOWLY = 1000, 4
"""Finer looks at the pace of the last ones that the rest of a window may ask for, and how many in a row may ask for
more before it is left open: each takes up to a second."""
TRIES = 8
"""Times without contact looked for between two times in contact."""


@dataclass(frozen=True)
class Certified:
    """start, end: enclosures of either end; open: whether it is followed no farther than to end[0]."""

    start: tuple[float, float]
    end: tuple[float, float]
    open: bool = False


@dataclass(frozen=True)
class Found:
    """intervals: all up to `until`, in order; those that may go on then end at (until, end of the span).

    reason: "precision" or "budget" where `until` is before the end of the span.
    """

    intervals: tuple[Certified, ...]
    until: float
    reason: str | None


class Unproved(Exception):
    """Nothing is proved from that time on."""

    def __init__(self, time: float) -> None:
        self.time = time


@dataclass(frozen=True)
class FirstTouch:
    """The first contact after free time.

    lo, hi   no contact before lo; sure: one at or before hi.
    at       a later time, or hi, up to which contact does not begin or end again; None where none is known.
    point    a common one at that time; None where there is contact at one instant only.
    """

    lo: float
    hi: float
    sure: bool = True
    at: float | None = None
    point: np.ndarray | None = None


def reversed_in_time(window: Window) -> Window:
    """The window as seen at times -t."""
    tables = []
    for m in (window.a, window.b):
        table = m.copy()
        table[0, CENTRE] = -m[0, CENTRE]
        odd = [1, 3] if m[0, KIND] == TURNING else list(range(1, m.shape[1], 2))
        table[1:, odd] = -m[1:, odd]
        tables.append(table)
    return Window(-window.last, -window.first, -math.nextafter(window.first, math.inf), *tables)


class Timed(Protocol):
    """What the sweep knows of a `Window` or the like."""

    @property
    def first(self) -> float: ...
    @property
    def last(self) -> float: ...
    @property
    def inner(self) -> float: ...


W = TypeVar("W", bound=Timed)
V = TypeVar("V", contravariant=True)


class Free(Protocol[V]):
    """How free time is passed; window: any that the sweep was given, or its mirror."""

    def at(self, window: V, t: float) -> bool:
        """Whether the bodies are proved apart at t."""

    def until(self, window: V, t: float, end: float) -> tuple[float, list[np.ndarray]]:
        """(a time until which the bodies, apart at t, stay apart; where they may touch then).

        Without such places they are apart at that time too.
        """

    def near_start(self, window: V) -> list[np.ndarray]:
        """Where the bodies may touch at the start of the window."""

    def passage(self, window: V, t: float) -> Pass | None:
        """What finer arithmetic proves from t on; None where that is nothing."""


class Following(Protocol[V]):
    """How contact is followed, see `lasting.Lasting`."""

    worth: ClassVar[int]

    def deepest(self, window: V, t: float, seeds: Sequence[np.ndarray]) -> np.ndarray | None: ...

    def kept(self, window: V, t: float, place: np.ndarray) -> np.ndarray | None: ...

    def anywhere(self, window: V, t: float) -> np.ndarray | None: ...

    def until(
        self, window: V, t: float, end: float, point: np.ndarray, least: float, step: Callable[[], None]
    ) -> tuple[float, np.ndarray]: ...


@dataclass(frozen=True)
class Pass:
    """passage: what is proved of all times up to its end; point: a common one near its end, if there is contact then.

    instant: the time of a graze, proved to be one of contact; None where there is no graze, or it is not proved.
    """

    passage: Passage
    point: np.ndarray | None
    instant: fmpq | None


class TimeSweep(Generic[W]):
    """Follows two bodies from window to window, free or in contact.

    width: of the enclosures of events; touches_at_start: gives a common point at the start that is known otherwise, or
    None; asked where nothing is proved.
    """

    most_turns = MOST_TURNS

    def __init__(
        self,
        free: Free[W],
        lasting: Following[W],
        parts: list[W],
        width: float,
        work: Work,
        touches_at_start: Callable[[], np.ndarray | None],
    ) -> None:
        self.free, self.lasting = free, lasting
        self.windows, self.width, self.work = parts, width, work
        self.touches_at_start = touches_at_start
        self.intervals: list[Certified] = []
        self.start: tuple[float, float] | None = None
        self.loose: tuple[float, float] | None = None
        """When contact begins, or ends if `start` is told, if the window before and this one both hold that time."""
        self.turns = 0
        self.reached = parts[0].first
        self.looked, self.pace, self.slowly = self.reached, 0.0, 0
        """When finer arithmetic was asked last, how long after the time before, how often it went no faster since."""

    def run(self) -> Found:
        reason, point = None, None
        try:
            for k, window in enumerate(self.windows):
                self.reached = window.first
                point = self._window(window, point, k == 0)
        except Unproved as stopped:
            self.reached = max(self.reached, stopped.time)
            reason = "precision" if self.work.allowed(1) else "budget"
        except Spent:
            reason = "budget"
        last = self.windows[-1].last
        if reason is None:
            self.reached = last
        if self.start is None and self.loose is not None:
            self.intervals.append(Certified(self.loose, self.loose))
        if self.start is not None:
            self._close((self.reached, last), reason is not None)
        return Found(tuple(self.intervals), self.reached, reason)

    def _begin(self, start: tuple[float, float]) -> None:
        """Contact begins."""
        loose, self.loose = self.loose, None
        if loose is not None and start[0] > loose[1]:  # it began before, and ended
            self.intervals.append(Certified(loose, loose))
            loose = None
        self.start = start if loose is None else (min(loose[0], start[0]), start[1])
        self.turns = 0

    def _close(self, end: tuple[float, float], open: bool = False) -> None:
        assert self.start is not None
        start, self.start = self.start, None
        loose, self.loose = self.loose, None
        if loose is not None and end[0] <= loose[1]:
            end = min(loose[0], end[0]), end[1]
        joined = self.intervals[-1] if self.intervals else None
        if joined is not None and start[1] <= joined.end[0]:  # from one window to the next
            self.intervals[-1] = replace(joined, end=end, open=open)
        else:
            self.intervals.append(Certified(start, end, open))

    def _follows(self) -> None:
        self._step(self.lasting.worth)

    def _step(self, worth: int = 1) -> None:
        starts = [x.start[0] for x in self.intervals[:1]] or ([self.reached] if self.start is None else [self.start[0]])
        self.work.free_until = starts[0]
        self.work.step(worth)

    def _window(self, window: W, point: np.ndarray | None, is_first: bool) -> np.ndarray | None:
        """Follow the state through one window; a common point at its end, None where there is none."""
        t, self.turns = window.first, 0
        self._step()
        if self.free.at(window, t):
            self._apart_at_start(t)
            point = None
        else:
            try:
                point = self._at_start(window, point, is_first)
                self._together_at_start(t)
            except Unproved:
                t, point = self._finer_start(window)
        while t < window.last:
            if self.start is None:
                t, point = self._enter(window, t)
            else:
                assert point is not None
                t, point = self._leave(window, t, point)
            self.reached = t
        return point

    def _at_start(self, window: W, point: np.ndarray | None, is_first: bool) -> np.ndarray:
        t = window.first
        found = self.lasting.kept(window, t, point) if point is not None else None
        if found is None:
            found = self.lasting.anywhere(window, t)
        if found is not None:
            return found
        if seeds := self.free.near_start(window):
            return seeds[0]
        if is_first and (seed := self.touches_at_start()) is not None:
            return seed
        raise Unproved(t)

    def _finer_start(self, window: W) -> tuple[float, np.ndarray | None]:
        """As `_finer`, from the start of a window at which doubles tell neither contact nor none.  May raise Open."""
        t = window.first
        found = self.free.passage(window, t)
        if found is None:
            raise Unproved(t)
        first = found.passage.stretches[0]
        if not first.contact:
            self._apart_at_start(t)
        elif first.lo == exact_value(t):
            self._together_at_start(t)
        return self._finer(window, t)

    def _apart_at_start(self, t: float) -> None:
        """The bodies are apart at t, the start of a window, which the one before ends a little after."""
        if self.start is not None and self.start[1] > t:
            self.loose, self.start = self.start, None
        elif self.start is not None:
            self._close((t, t))

    def _together_at_start(self, t: float) -> None:
        """As `_apart_at_start`, in contact at t."""
        if self.start is not None:
            return
        last = self.intervals[-1] if self.intervals else None
        if last is not None and last.end[1] >= t:
            self.intervals.pop()
            self.start, self.loose = last.start, last.end
        else:
            self._begin((t, t))

    def _finer(self, window: W, t: float) -> tuple[float, np.ndarray | None]:
        """As `_enter` or `_leave`, by a passage from t on.  May raise Open."""
        self._step()
        self._keep_pace(window, t)
        found = self.free.passage(window, t)
        if found is None or found.passage.stretches[0].contact != (self.start is not None):
            raise Unproved(t)
        passage, until = found.passage, min(below(found.passage.until), window.last)
        if until <= t:  # less than doubles tell apart
            raise Unproved(t)
        for before, after in zip(passage.stretches, passage.stretches[1:], strict=False):
            event = below(before.hi), above(after.lo)
            if before.contact and after.contact or passage.graze is not None:
                if found.instant is None:
                    raise Unproved(event[0])
                if not after.contact:
                    at = below(found.instant), above(found.instant)
                    self._begin((event[0], at[1]))
                    self._close((at[0], event[1]))
            elif after.contact:
                self._begin(event)
            else:
                self._close(event)
        return until, found.point

    def _keep_pace(self, window: W, t: float) -> None:
        """Unproved where finer looks follow each other in steps that do not grow, and would for minutes."""
        pace = t - self.looked
        is_slow = 0.0 < pace <= 2.0 * self.pace and window.last - t > MOST_PACES * pace
        self.slowly = self.slowly + 1 if is_slow else 0
        self.looked, self.pace = t, pace
        if self.slowly >= SLOWLY:
            raise Unproved(t)

    def _enter(self, window: W, t: float) -> tuple[float, np.ndarray | None]:
        """(the time up to which all is settled, a common point then or None), from t, which is free."""
        self._step()
        found = self.touch(window, t, window.last)
        if found is None:
            return window.last, None
        self.reached = found.lo
        if not found.sure:
            return self._finer(window, found.lo)
        self._begin((found.lo, found.hi))
        if found.at is None:
            raise Unproved(found.hi)
        if found.point is None:
            self._close((found.lo, found.hi))
        return found.at, found.point

    def touch(self, window: W, t: float, end: float) -> FirstTouch | None:
        """The first contact from t, which is free, to the time `end`; None where there is none."""
        lo, seeds = self.free.until(window, t, end)
        if lo >= end and not seeds:
            return None
        hi, point = self._soon(window, lo, min(window.inner, end), seeds)
        return FirstTouch(lo, hi, point is not None, hi, point)

    def _soon(
        self, window: W, lo: float, latest: float, seeds: list[np.ndarray]
    ) -> tuple[float, np.ndarray | None]:
        """(a time within the width after lo, a point proved common then)."""
        for share in (0.25, 0.9):
            at = min(lo + share * self.width, latest)
            if lo <= at <= lo + self.width and (point := self.lasting.deepest(window, at, seeds)) is not None:
                return at, point
        return lo, None

    def _leave(self, window: W, t: float, point: np.ndarray) -> tuple[float, np.ndarray | None]:
        """(a later time up to which all is settled, a common point then or None), from t, which is in contact."""
        self.turns += 1
        if self.turns > self.most_turns:
            raise Unproved(t)
        begin = t
        for least, share in AHEAD:
            t, point = self.lasting.until(window, t, window.last, point, least, self._follows)
            self.reached = t
            if t >= window.last:
                return t, point
            if t > begin or share == AHEAD[-1][1]:  # where nothing can be followed, small steps are all there is
                with suppress(Unproved):
                    return self._left(window, t, point, share)
        return self._finer(window, t)

    def _left(self, window: W, t: float, point: np.ndarray, share: float) -> tuple[float, np.ndarray | None]:
        """As `_leave`, from t where contact is not proved to last; share: of the time passed, to look ahead."""
        for later in self._ahead(window, t, share):
            self._step()
            if self.free.at(window, later):
                return self._back(window, t, later)
            there = self.lasting.deepest(window, later, [point])
            if there is None:
                there = self.lasting.anywhere(window, later)
            if there is not None:
                gap = self._lost_before(window, t, later, there)
                return (later, there) if gap is None else self._back(window, t, gap)
        raise Unproved(t)

    def _ahead(self, window: W, t: float, share: float) -> Iterator[float]:
        """Times after t, ever farther apart, up to the window's end."""
        passed = t - (self.start[1] if self.start is not None else t)
        step = max(0.5 * self.width, 8.0 * math.ulp(t), share * passed)  # in few turns, however little each proves
        while t + step < window.last:
            yield t + step
            step *= 2.0
        yield window.last

    def _back(self, window: W, t: float, later: float) -> tuple[float, None]:
        """Where contact at t ends before the time `later`, which is free; a time that is free."""
        mirror = self._mirrored(window)
        for _ in range(TRIES):
            self._step()
            last = self.touch(mirror, -later, -t)
            hi = t if last is None else -last.lo
            if hi - t <= self.width:
                self._close((t, max(hi, t)))
                return later, None
            if last is None or last.at is None or not last.sure:
                raise Unproved(t)
            gap: float | None = -last.at
            if last.point is not None:
                gap = self._lost_before(window, t, -last.at, last.point)
            if gap is None:
                self._close((-last.hi, hi))
                return later, None
            later = gap
        raise Unproved(t)

    def _mirrored(self, window: W) -> W:
        return reversed_in_time(window)  # type: ignore[arg-type, return-value]

    def _lost_before(self, window: W, t: float, later: float, point: np.ndarray) -> float | None:
        """None if contact lasts from t to `later`, both in contact; else a free time between.  May raise Open."""
        mirror = self._mirrored(window)
        back, _ = self.lasting.until(mirror, -later, -t, point, LEAST_BACK, self._follows)
        if -back - t <= self.width:
            return None
        for k in range(1, TRIES):
            middle = t + (-back - t) * k / TRIES
            if t < middle < later and self.free.at(window, middle):
                return middle
        raise Unproved(t)
