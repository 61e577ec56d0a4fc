"""Spans of one instant at which solids overlap while other features of theirs meet, and what is led back to them."""

from __future__ import annotations

from fractions import Fraction as F

import pytest

import firstcontact as fc
from firstcontact import Status

UPPER, LOWER = fc.box((1, 1, 1)).translated((0, 0, "1/2")), fc.box((3, 3, 1)).translated((0, 0, "-1/2"))
LIFT = fc.Screw((0, 0, 1), point=(2, 1, 0), turns="1/2", advance=2)


@pytest.mark.parametrize("exact", [False, True], ids=["default", "exact"])
def test_a_box_is_screwed_off_a_box(exact):
    """They share the square |x|, |y| <= 1/2 at the start and nothing later."""
    for pair in ((UPPER.moving(LIFT), LOWER), (LOWER, UPPER.moving(LIFT))):
        found = fc.contact_intervals(*pair, exact=exact)
        assert found.status is Status.INITIAL_CONTACT
        assert [(x.start, x.end) for x in found] == [(0, 0)]


def test_a_box_is_screwed_onto_a_box():
    """From a unit above: heights meet at the end alone, half a turn about (2, 1) later, in x = 4, y = 2."""
    above = UPPER.translated((4, 2, 1)).moving(fc.Screw((0, 0, 1), point=(2, 1, 0), turns="1/2", advance=-1))
    found = fc.contact_intervals(above, LOWER)
    assert [(x.start, x.end) for x in found] == [(1, 1)]
    assert fc.first_contact(above, LOWER).time == 1


TALL = fc.box((1, 1, 5)).translated((0, 0, "-1/2"))
SPIN = fc.Rotation((0, 0, 1), (2, 1, 0), turns="1/2")


@pytest.mark.share(2)
@pytest.mark.parametrize("time", [0, F(1, 2), F(1, 3), 1])
def test_one_instant_of_a_turn(time):
    """Its middle is at (0, 0), then after 60 degrees at (1.87, -1.23), 90 (3, -1), 180 (4, 2); it is a unit wide."""
    found = fc.contact_intervals(TALL.moving(SPIN), LOWER, (time, time), exact=True)
    there = fc.first_contact(TALL.moving(SPIN), LOWER, (time, time), exact=True)
    assert found.status is there.status
    assert (found.status is Status.INITIAL_CONTACT) is (time < F(1, 2))
    assert [(x.start, x.end) for x in found] == ([(float(time),) * 2] if time < F(1, 2) else [])


@pytest.mark.parametrize("exact", [False, True], ids=["default", "exact"])
def test_one_instant_of_touching(exact):
    """Side by side in x = 3/2 at the start of the turn."""
    beside = TALL.translated((2, "1/3", 0)).moving(SPIN)
    found = fc.contact_intervals(beside, LOWER, (0, 0), exact=exact)
    assert found.status is Status.INITIAL_CONTACT
    assert [(x.start, x.end) for x in found] == [(0, 0)]
    off = TALL.translated((2 + F(1, 10**12), "1/3", 0)).moving(SPIN)
    assert fc.contact_intervals(off, LOWER, (0, 0), exact=exact).status is Status.FREE
