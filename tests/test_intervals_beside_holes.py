"""Intervals of contact with solids that have holes or grooves, which nothing convex fills."""

from __future__ import annotations

from fractions import Fraction as F

import pytest

import firstcontact as fc
from firstcontact import Status
from firstcontact.kernels.events.event_search import VISITS
from firstcontact.search.events.events import EventSearch

GROOVE = fc.box((6, 6, 2)) - fc.cylinder(1, 8).rotated((0, 1, 0), degrees=90).translated((0, 0, 1))
"""Along x, with straight edges at y = +-1, z = 1."""
CORNER = fc.Polyhedron([(1, 1, 1), (0, 1, 3), (1, 2, 3)], [[0, 1, 2]])


@pytest.mark.parametrize("last", [1, 2])
def test_a_corner_lands_on_the_edge_of_a_groove(last):
    """It leaves the plate over the groove at 3/5, and its lowest corner lands on the far edge at 1."""
    moving = CORNER.translated((1, -4, -2)).moving(fc.Translation((-1, 4, 2)))
    for pair in ((moving, GROOVE), (GROOVE, moving)):
        found = fc.contact_intervals(*pair, span=(0, last))
        assert [(x.start, x.end) for x in found] == [(0, 0.6), (1, 1)]
        exact = fc.contact_intervals(*pair, span=(0, last), exact=True)
        assert [(x.start_exact, x.end_exact) for x in exact] == [(0, F(3, 5)), (1, 1)]
        (late,) = fc.contact_intervals(*pair, span=("4/5", last))
        assert (late.start, late.end) == (1, 1)


UNIT = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
BENT = [["1/4", 0, "-1/2", 5], ["1/4", "-1/4", "1/2", -3], ["-1/2", "-1/4", "1/2", -2], [0] * 4]


@pytest.mark.parametrize("last", ["24/25", 1])
@pytest.mark.parametrize("inner", [2, 0])
def test_a_ball_on_a_screw_meets_the_rim_of_a_ring_that_deforms(inner, last):
    """Whether the ring has a hole does not matter: the ball comes from outside."""
    ball = fc.sphere(3).translated((0, 6, 4)).moving(fc.Screw((1, 1, 1), point=(-1, 1, 0), degrees=100, advance=-6))
    ring = fc.cylinder(3, 2) - fc.cylinder(inner, 4) if inner else fc.cylinder(3, 2)
    ring = ring.moving(fc.RationalMotion([UNIT, BENT]))
    for pair in ((ball, ring), (ring, ball)):
        hit = fc.first_contact(*pair, (0, last))
        (found,) = fc.contact_intervals(*pair, (0, last))
        assert hit.status is Status.CONTACT
        assert found.start == pytest.approx(0.95671208866965, abs=2e-12)
        assert found.start_interval[0] <= hit.time <= found.start_interval[1]
        assert found.end == float(F(last))


def test_looks_in_balls_count_as_work(monkeypatch):
    """As if a look had taken a million boxes."""
    def slow(search, window, lo, stage):
        search.counters[VISITS] += 10**6

    monkeypatch.setattr(EventSearch, "free_in_balls", slow)
    ball = fc.sphere(1).translated((-5, 0, "1/3")).moving(fc.Screw((1, 0, 0), degrees=30, advance=4))
    ring = fc.cylinder(3, 2) - fc.cylinder(2, 4)
    assert fc.contact_intervals(ball, ring).stats.node_visits >= 10**6
    few = fc.contact_intervals(ball, ring, budget=10**5)
    assert (few.status, few.reason) == (Status.UNDECIDED, "budget")
