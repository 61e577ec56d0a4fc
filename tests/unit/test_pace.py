"""A sweep in time that creeps: finer looks that do not grow are given up, those that do go on to the end."""

from __future__ import annotations

from typing import ClassVar, NamedTuple

import pytest
from flint import fmpq

from firstcontact.exact.numbers import exact_value
from firstcontact.search.convex.close_up import Passage, Stretch
from firstcontact.timeline.sweep import Pass, TimeSweep
from firstcontact.work import Work


class Span(NamedTuple):
    first: float = 0.0
    last: float = 1.0
    inner: float = 1.0


class ProvedInSteps:
    """Apart at all times, which is proved in steps by finer arithmetic alone."""

    def __init__(self, step, growth):
        self.step, self.growth, self.looks = step, growth, 0

    def at(self, window, t):
        return True

    def until(self, window, t, end):
        return t, []

    def near_start(self, window):
        return []

    def passage(self, window, t):
        self.looks += 1
        end = min(exact_value(t) + exact_value(self.step), fmpq(1))
        self.step *= self.growth
        return Pass(Passage([Stretch(False, exact_value(t), end)]), None, None)


class NeverInContact:
    worth: ClassVar[int] = 1

    def deepest(self, window, t, seeds):
        return None

    def anywhere(self, window, t):
        return None


@pytest.mark.parametrize(
    ("step", "growth", "decided"), [(2.0**-40, 1.0, False), (2.0**-40, 4.0, True), (2.0**-8, 1.0, True)]
)
def test_a_window_that_would_take_minutes_is_left_open(step, growth, decided):
    free = ProvedInSteps(step, growth)
    found = TimeSweep(free, NeverInContact(), [Span()], 2.0**-44, Work(), lambda: None).run()
    assert (found.reason, found.intervals) == (None if decided else "precision", ())
    assert free.looks <= 300 if decided else free.looks <= 8
    assert found.until == 1.0 if decided else 0.0 < found.until < 2.0**-36
