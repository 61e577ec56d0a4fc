"""A body that lies inside another one at the start is in contact from then on, wherever a budget ends the search."""

from __future__ import annotations

from fractions import Fraction as F

import pytest

import firstcontact as fc
from firstcontact import Status

HALL = fc.examples.box((4, 4, 4))
PAIRS = {
    "a point in a box": (fc.Polyhedron([(0, 0, 0)], []), HALL),
    "points in and out of a box": (fc.Polyhedron([(0, 0, 0), (9, 9, 9), (8, 8, 8)], []), HALL),
    "a box in a box": (fc.examples.box((1, 1, 1)), HALL),
    "a ball in a box": (fc.sphere("1/2"), HALL),
    "a ball in a ball": (fc.sphere("1/2"), fc.sphere(2)),
    "a point in a ball": (fc.Polyhedron([(0, 0, 0)], []), fc.sphere(2)),
    "a corner in a tube's wall": (
        fc.Polyhedron([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [[0, 1, 2]]).translated((4, 0, 0)),
        fc.cylinder(6, 4) - fc.cylinder(3, 5),
    ),
    "a ruled surface in a ball": (fc.RuledSurface("(u/2, 0, 0)", "(u/2, 1/2, u/2)"), fc.sphere(2)),
    "a ruled surface in a box": (fc.RuledSurface("(u/2, 0, 0)", "(u/2, 1/2, u/2)"), HALL),
}
MOTIONS = {
    "translation": fc.Translation((20, 0, 0)),
    "rotation": fc.Rotation((0, 0, 1), (7, 0, 0), turns=F(3, 4)),
    "screw": fc.Screw((0, 0, 1), (7, 0, 0), degrees=200, advance=3),
    "rational": fc.RationalMotion.between((0, 0, 0), (20, 0, 0), quat_wxyz=((1, 0, 0, 0), (3, 0, 1, 0))),
}


@pytest.mark.share(12)
@pytest.mark.parametrize("swap", [False, True], ids=["", "swapped"])
@pytest.mark.parametrize("motion", list(MOTIONS))
@pytest.mark.parametrize("pair", list(PAIRS))
def test_no_time_is_free(pair, motion, swap):
    inner, outer = PAIRS[pair]
    bodies = (inner.moving(MOTIONS[motion]), outer)[:: -1 if swap else 1]
    for budget in (0, 1, 2, 5, 8, 20, 100, 1000):
        hit = fc.first_contact(*bodies, budget=budget)
        assert hit.status is Status.INITIAL_CONTACT or (hit.status is Status.UNDECIDED and hit.free_until == 0.0)
    assert fc.first_contact(*bodies, method="certified").status in (Status.INITIAL_CONTACT, Status.UNDECIDED)


def test_how_a_start_overlaps_is_worked_out_when_it_is_read():
    """Doubles prove it in a step; all that touches is asked of 300 pairs of features, beyond a budget of 1."""
    cross = (fc.box(("7/4", 1, "3/4")) | fc.cylinder("1/2", "9/4")).translated(("1/2", 0, "1/4"))
    block = fc.examples.box((1, 1, 1.5))
    turning = cross.moving(fc.Rotation((1, 0, -1), (1, F(1, 2), F(1, 2)), radians=1))
    for budget in (1, None):
        hit = fc.first_contact(turning, block, budget=budget)
        assert hit.status is Status.INITIAL_CONTACT
        assert hit.stats.node_visits + hit.stats.pair_tests <= 3
        assert hit.initial == "overlapping"
    assert hit.time_interval == (0.0, 0.0) and hit.element_a is not None
    told = fc.first_contact(cross, block)  # at rest, exactly
    assert (told.initial, told.multiplicity) == ("overlapping", hit.multiplicity)
    assert str(told.element_a) == str(hit.element_a)
