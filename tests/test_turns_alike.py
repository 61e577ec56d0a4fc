"""Intervals of curved bodies that turn many times: each turn as one turn alone is told."""

from __future__ import annotations

import math
from fractions import Fraction as F
from typing import Any

import pytest

import firstcontact as fc
from firstcontact import Status

BAR = fc.box((4, "2/5", 1)).rotated((0, 0, 1), degrees=30)
BALL = fc.sphere("1/4").translated((2, 0, 0))
Z = (0, 0, 1)
BODIES = {
    "bar and ball": (BAR, BALL),
    "mesh and ball": (fc.examples.box((4, 0.5, 1)), BALL),
    "tube and plate": (
        fc.box((4, "1/2", 1)) - fc.cylinder("1/8", 2), fc.RuledSurface("(u+3/2,-1/4,0)", "(u+3/2,1/4,0)"),
    ),
}  # fmt: skip
"""Some in contact at the start, some not."""


def ends(found):
    return [t for x in found for t in (x.start, x.end)]


@pytest.mark.parametrize("name", BODIES)
def test_turns_are_as_one_alone(name):
    a, b = BODIES[name]
    one = ends(fc.contact_intervals(a.moving(fc.Rotation(Z, turns=1)), b, (0, 1)))
    turning = a.moving(fc.Rotation(Z, turns=12))
    for pair in ((turning, b), (b, turning)):
        found = fc.contact_intervals(*pair)
        expected = [(k + t) / 12 for k in range(12) for t in one]
        if one[0] == 0:  # what touches at the end of a turn goes on in the next one
            at = set(range(len(one), len(expected), len(one)))
            expected = [t for k, t in enumerate(expected) if k not in at and k + 1 not in at]
        assert found.status is (Status.INITIAL_CONTACT if one[0] == 0 else Status.CONTACT)
        assert ends(found) == pytest.approx(expected, abs=1e-11)
        for x in found:
            assert x.start_interval[0] <= x.start <= x.start_interval[1] <= x.end_interval[1]
        assert ends(found)[-1] <= 1 and (one[0] != 0 or found[-1].end == 1)
        part = fc.contact_intervals(*pair, ("1/7", "5/7"))
        inside = [(max(s, 1 / 7), min(e, 5 / 7)) for s, e in zip(expected[::2], expected[1::2], strict=True)]
        assert ends(part) == pytest.approx([t for s, e in inside if s <= e for t in (s, e)], abs=1e-11)


SPINS: list[Any] = [
    ({"radians": 40}, None), ({"turns": 5}, {"turns": -3}), ({"turns": 8}, {"turns": 8}),
    pytest.param(({"radians": 20}, {"turns": -3}), marks=pytest.mark.thorough),
]  # fmt: skip


@pytest.mark.parametrize("motions", SPINS)
def test_turns_of_both_and_in_radians(motions):
    """Turned against each other by so many turns: bars meet the ball twice in each."""
    own, other = (None if m is None else fc.Rotation(Z, **m) for m in motions)
    a, b = BAR.moving(own), BALL if other is None else BALL.moving(other)
    turns = sum(s * m.radians / math.tau for s, m in ((1, own), (-1, other)) if m is not None)
    found = fc.contact_intervals(a, b)
    assert found.status is (Status.CONTACT if turns else Status.FREE)
    one = ends(fc.contact_intervals(BAR.moving(fc.Rotation(Z, turns=1)), BALL))
    expected = [(k + t) / turns for k in range(int(turns) + 1) for t in one if turns and k + t <= turns]
    assert ends(found)[: len(expected)] == pytest.approx(expected, abs=1e-9)


def test_exact_ends_of_many_turns():
    a = BAR.moving(fc.Rotation(Z, turns=4))
    found, told = fc.contact_intervals(a, BALL, exact=True), fc.contact_intervals(a, BALL)
    assert len(found) == len(told) == 8
    for x, y in zip(found, told, strict=True):
        assert y.start_interval[0] <= float(x.start_exact) <= y.start_interval[1]
        assert float(x.end_exact) == pytest.approx(y.end, abs=1e-12)


def test_a_contact_in_one_instant_of_each_turn():
    """The ball on a bar grazes the other one a quarter turn from the start."""
    a = fc.sphere(1).translated((3, 0, 0)).moving(fc.Rotation(Z, turns=6))
    b = fc.sphere(1).translated((0, 5, 0))
    found = fc.contact_intervals(a, b)
    assert [x.start for x in found] == pytest.approx([(4 * k + 1) / 24 for k in range(6)], abs=1e-12)
    assert all(x.start_interval[0] <= F(4 * k + 1, 24) <= x.end_interval[1] for k, x in enumerate(found))


def test_budgets_of_many_turns():
    few = fc.contact_intervals(BAR.moving(fc.Rotation(Z, turns=50)), BALL, budget=3)
    assert few.status is Status.UNDECIDED and few.reason == "budget"
    assert few.free_until <= fc.first_contact(BAR.moving(fc.Rotation(Z, turns=50)), BALL).time


BALL_OFF = fc.sphere(1).translated((3, 0, 0))
APART = 2 * math.asin(1 / 3)
"""The angle at which two such balls, turned against each other about z, touch: 6 sin(angle / 2) = 2."""


@pytest.mark.parametrize("span", [(F(-1, 4), F(3, 2)), (-1, 1), (0, F(3, 4))], ids=str)
@pytest.mark.parametrize("degrees", [1447, 3000, 4350, 7120, 8289, 8977, 10181])
def test_balls_that_touch_where_turns_begin(degrees, span):
    """They were in contact twice there, for turns that end between doubles, or it ended in a division by zero."""
    found = fc.contact_intervals(BALL_OFF.moving(fc.Rotation(Z, degrees=degrees)), BALL_OFF, span)
    turns = F(degrees, 360)
    lo, hi = (s * turns for s in span)
    away = APART / math.tau
    expected = [(k - away, k + away) for k in range(math.floor(lo) - 1, math.ceil(hi) + 2)]
    expected = [(max(s, lo), min(e, hi)) for s, e in expected if e >= lo and s <= hi]
    assert len(found) == len(expected)
    for x, (s, e) in zip(found, expected, strict=True):
        assert [x.start * float(turns), x.end * float(turns)] == pytest.approx([float(s), float(e)], abs=1e-10)
        assert x.start_interval[0] <= x.start_interval[1] <= x.end_interval[0] <= x.end_interval[1]
