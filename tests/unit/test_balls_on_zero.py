"""Balls that shrank on zero, as those of events at the time 0 do: bounds of few bits, however small they are."""

from __future__ import annotations

import pytest
from flint import arb, fmpq

from firstcontact.exact.numbers import NOTHING, lowest, middle, precision


def shrunk(times):
    """[+/- 2^-2^times]"""
    x = arb(0, 0.5)
    for _ in range(times):
        x = x * x
    return x


@pytest.mark.parametrize("times", [1, 20, 40])
def test_a_ball_about_zero_has_a_short_lower_bound(times):
    for sign in (1, -1):
        x = sign * shrunk(times)
        low = lowest(x)
        assert low <= 0 and not x < arb(low)
        assert low.q.bit_length() < 5000
        assert abs(middle(x)) <= NOTHING


def test_elsewhere_bounds_are_the_lower_ends_and_the_middles():
    with precision(128):
        x = arb(fmpq(3, 8), fmpq(1, 8))
        assert lowest(x) <= fmpq(1, 4) and fmpq(1, 4) - lowest(x) < fmpq(1, 2**28)
        assert middle(x) == fmpq(3, 8)
        assert lowest(arb(fmpq(-5, 4))) == fmpq(-5, 4)
