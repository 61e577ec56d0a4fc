"""Spans of one instant: there is an interval exactly where the bodies share a point then."""

from __future__ import annotations

from fractions import Fraction as F

import pytest

import firstcontact as fc
from firstcontact import Status

CUBE = fc.examples.box((2, 2, 2))
FLAG = fc.Polyhedron([(0, 0, 0), (3, 0, 0), (0, 3, 1)], [[0, 1, 2]])
TURNS = {
    "turns about two axes": (fc.Rotation((0, 0, 1), degrees=37), fc.Rotation((1, 0, 0), degrees=37)),
    "a screw": (fc.Screw((0, 0, 1), degrees=37, advance="1/100"), None),
    "a turn beside a shift": (fc.Rotation((1, 2, 3), radians=2), fc.Translation(("1/10", 0, 0))),
    "between": (fc.RationalMotion.between((0, 0, 0), (0, 0, "1/10"), quat_wxyz=((1, 0, 0, 0), (5, 1, 2, 0))), None),
}


@pytest.mark.parametrize("time", [F(0), F(1, 7), F(1)], ids=str)
@pytest.mark.parametrize("body", [CUBE, FLAG, fc.sphere(1)], ids=["cube", "flag", "ball"])
@pytest.mark.parametrize("motions", TURNS)
def test_bodies_that_hold_the_origin_nearly_all_along(motions, body, time):
    """The flag's corner is at the origin at the start alone, and what the others hold there is all around it."""
    a, b = (CUBE if m is TURNS[motions][0] and body is not FLAG else body for m in TURNS[motions])
    a, b = (x if m is None else x.moving(m) for x, m in zip((a, b), TURNS[motions], strict=True))
    told = fc.first_contact(a, b, (time, time)).status
    if body is not FLAG or time == 0:
        assert told is Status.INITIAL_CONTACT
    found = fc.contact_intervals(a, b, (time, time))
    assert found.status is told
    assert [(x.start, x.end) for x in found] == ([] if told is Status.FREE else [(float(time), float(time))])


def test_an_instant_at_a_knot_of_a_screw_trajectory():
    path = fc.Trajectory(
        [0, 1, 2], [(0, 0, 0), (1, 0, 0), (2, 1, 0)], "screw", quat_wxyz=[(1, 0, 0, 0), (4, 1, 0, 0), (4, 1, 1, 0)]
    )
    wall = fc.examples.box((1, 1, 1)).translated((1, "1/5", 0))
    for span in ((1, 1), (1, 2)):
        assert fc.contact_intervals(CUBE.moving(path), wall, span).status is Status.INITIAL_CONTACT
    far = wall.translated((5, 0, 0))
    assert fc.contact_intervals(CUBE.moving(path), far, (1, 1)).status is Status.FREE


def test_contact_that_goes_on_to_the_end_of_a_screw_is_one_interval():
    """It was told twice: up to the end, enclosed to one unit in the last place beyond it, and at the end."""
    path = fc.Trajectory([0, 1], [(-2, 1, 0), (-1, 0, 2)], "screw", quat_wxyz=[(-1, 3, 3, -2), (1, 1, 0, 0)])
    box = fc.examples.box((1, 2, 3))
    for pair in ((box.moving(path), box), (box, box.moving(path))):
        (only,) = fc.contact_intervals(*pair)
        assert (only.start, only.end) == (0, 1)
        assert only.end_interval[1] == 1
