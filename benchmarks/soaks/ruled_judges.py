"""Judges of times of contact: what is known of them beforehand, and how an answer is held against it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction as F
from typing import Any

import numpy as np

from .exact_numbers import Near
from .ruled_bodies import Body, Motion, Piece

Window = tuple[Near, Near]
WIDTH = 1e-12  # the default tolerance, relative to the span


@dataclass(frozen=True)
class Truth:
    """What is known of the contact of two bodies.

    windows  closed times of contact, disjoint, ascending.
    whole    whether there are no others; else only that there is none before the first of them.
    witness  whether earlier contact is possible too: then windows are times at which the bodies certainly meet.
    domain   the times within which all that holds.
    initial  what `initial` must be at a start in contact, None where it is not known; by default "touching".
    """

    windows: tuple[Window, ...]
    domain: tuple[F, F] = (F(0), F(1))
    whole: bool = True
    witness: bool = False
    initial: Callable[[F], str | None] = lambda t: "touching"


@dataclass(frozen=True)
class Moved:
    body: Body
    motion: Motion | None

    def off(self, x: np.ndarray, t: float) -> float:
        if self.motion is not None:
            m = self.motion.pose(t)
            x = np.linalg.solve(m[:3, :3], x - m[:3, 3])
        if isinstance(self.body, Piece):
            x = x - self.body.shift(t)
        return self.body.off(x)


def inside(window: Window, t: F) -> bool:
    return window[0][1] <= t <= window[1][0]


def first_window(truth: Truth, span: tuple[F, F]) -> Window | None:
    for window in truth.windows:
        if window[1][1] >= span[0] and window[0][0] <= span[1]:
            return window
    return None


def point_judgement(hit: Any, a: Moved, b: Moved) -> str | None:
    """Whether the point is on both bodies, and the normal of length one."""
    if hit.point is None:
        return "CONTACT without a point" if hit.status.name == "CONTACT" else None
    size = max(a.body.size, b.body.size, float(np.abs(hit.point).max()))
    for name, moved in (("a", a), ("b", b)):
        off = moved.off(np.asarray(hit.point), hit.time)
        if not off <= 1e-9 * size:
            return f"point {hit.point.tolist()} is {off:.3g} off body {name}, of size {size:.3g}, at {hit.time!r}"
    if hit.normal is not None and abs(float(np.linalg.norm(hit.normal)) - 1) > 1e-9:
        return f"normal of length {np.linalg.norm(hit.normal)!r}"
    return None


def time_judgement(interval: tuple[float, float], time: float, true: Near, span: tuple[F, F]) -> str | None:
    lo, hi = F(interval[0]), F(interval[1])
    told = f"{float(true[0])!r}" + (f" = {true[0]}" if true[0] == true[1] else "")
    slack = F(4e-16) * max(abs(lo), abs(hi), F(1, 10**300))
    if lo > true[1] or hi < true[0]:
        return f"time interval {interval} is not about the true time {told}"
    if hi - lo > F(WIDTH) * (span[1] - span[0]) + 2 * slack:
        return f"time interval {interval} is wider than it may be"
    if abs(F(time) - true[0]) > F(WIDTH) * (span[1] - span[0]) + slack:
        return f"time {time!r} is not the true one, {told}"
    return None


def judge_first(truth: Truth, span: tuple[F, F], a: Moved, b: Moved) -> Callable[[Any], str | None]:
    expected = first_window(truth, span)

    def judge(hit: Any) -> str | None:
        status = hit.status.name
        at = None if expected is None else max(expected[0], (span[0], span[0]))
        told = "no time" if at is None else f"{float(at[0])!r}" + (f" = {at[0]}" if at[0] == at[1] else "")
        if status == "UNDECIDED":
            if at is not None and hit.free_until is not None and F(hit.free_until) > at[1]:
                return f"UNDECIDED, but free until {hit.free_until!r} with contact at {told}"
            return None
        if status == "FREE":
            return None if at is None else f"FREE, but they meet at {told}"
        wrong = point_judgement(hit, a, b)
        if truth.witness:
            if at is not None and F(hit.time_interval[0] if hit.time_interval else hit.time) > at[1]:
                return f"{status} at {hit.time!r}, but they meet at {told}"
            return wrong
        if at is None:
            return f"{status} at {hit.time!r}, but they never meet"
        if at[1] > span[0] and status == "INITIAL_CONTACT":
            return f"INITIAL_CONTACT, but they first meet at {told}"
        if at[1] <= span[0]:
            if status != "INITIAL_CONTACT":
                return f"{status} at {hit.time!r}, but they meet at the start {float(span[0])!r}"
            initial = truth.initial(span[0])
            if initial is not None and hit.initial not in (None, initial):
                return f"initial is {hit.initial!r}, not {initial!r}"
            return wrong
        return time_judgement(hit.time_interval, hit.time, at, span) or exact_judgement(hit.time_exact, at) or wrong

    return judge


def exact_judgement(told: Any, true: Near) -> str | None:
    """`time_exact`, where it is given and the true time is a fraction."""
    if told is None or true[0] != true[1]:
        return None
    if isinstance(told, F):
        return None if told == true[0] else f"time_exact is {told}, not {true[0]}"
    if type(told).__name__ == "AlgebraicNumber":
        value = F(0)
        for c in reversed(told.polynomial):
            value = value * true[0] + c
        if value != 0 or not F(told.lo) <= true[0] <= F(told.hi):
            return f"time_exact is {told}, not {true[0]}"
    return None


def clipped(truth: Truth, span: tuple[F, F]) -> list[Window]:
    lo, hi = (span[0], span[0]), (span[1], span[1])
    return [(max(w[0], lo), min(w[1], hi)) for w in truth.windows if w[1][1] >= span[0] and w[0][0] <= span[1]]


def judge_intervals(truth: Truth, span: tuple[F, F]) -> Callable[[Any], str | None]:
    expected = clipped(truth, span)

    def ends(interval: Any, window: Window) -> str | None:
        return (time_judgement(interval.start_interval, interval.start, window[0], span)
                or time_judgement(interval.end_interval, interval.end, window[1], span)
                or exact_judgement(interval.start_exact, window[0]) or exact_judgement(interval.end_exact, window[1]))

    def begins(interval: Any, window: Window) -> str | None:
        return time_judgement(interval.start_interval, interval.start, window[0], span)

    def judge(answer: Any) -> str | None:
        found = list(answer)
        told = [(float(w[0][0]), float(w[1][0])) for w in expected]
        got = [(i.start, i.end) for i in found]
        if truth.witness:
            for w in expected:
                if not any(F(i.start_interval[0]) <= w[0][1] and F(i.end_interval[1]) >= w[1][0] for i in found):
                    if answer.status.name != "UNDECIDED" or answer.free_until > float(w[1][1]):
                        return f"intervals {got} leave out the contact at {told}"
            return None
        if answer.status.name == "UNDECIDED":
            until = F(answer.free_until)
            for w in expected:
                if w[1][1] < until and not any((ends if truth.whole else begins)(i, w) is None for i in found):
                    return f"intervals {got} until {answer.free_until!r} leave out one of {told}"
            return None
        if not truth.whole:
            if bool(expected) != bool(found):
                return f"intervals {got}, but the first contact is at {told}"
            if not expected:
                return None
            return time_judgement(found[0].start_interval, found[0].start, expected[0][0], span)
        if len(found) != len(expected):
            return f"intervals {got} are not {told}"
        for interval, window in zip(found, expected, strict=True):
            wrong = ends(interval, window)
            if wrong:
                return f"{wrong}: intervals {got} are not {told}"
        return None

    return judge
