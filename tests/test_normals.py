"""Normals where formulas lose their sign or their length."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc

SHEET = fc.Polyhedron([(2, -1, 0), (3, -1, 0), (3, 1, 0), (2, 1, 0)], [[0, 1, 2, 3]])


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("over", [1, -1], ids=["above", "below"])
@pytest.mark.parametrize("ball_moves", [True, False])
@pytest.mark.parametrize("swapped", [False, True])
def test_a_ball_comes_round_to_the_other_side_of_a_sheet(exact, over, ball_moves, swapped):
    """It starts on one side of the plane of the sheet and touches it from the other one, beside the full turn."""
    ball = fc.sphere("1/2").translated(("5/2", 0, over))
    size, begin = math.hypot(2.5, 1.0), math.atan2(1.0, 2.5)
    turns = (2 * math.pi - begin - math.asin(0.5 / size)) / (2 * math.pi)
    turn = fc.Rotation((0, -over, 0), turns=1)  # away from the plane first
    back = fc.Rotation((0, over, 0), turns=1)
    a, b = (ball.moving(turn), SHEET) if ball_moves else (ball, SHEET.moving(back))
    hit = fc.first_contact(b, a, exact=exact) if swapped else fc.first_contact(a, b, exact=exact)
    assert hit.status is fc.Status.CONTACT and hit.time == pytest.approx(turns, abs=1e-12)
    n = np.array([0.0, 0.0, -over])  # from the sheet to the ball
    if not ball_moves:
        c, s = math.cos(2 * math.pi * turns), over * math.sin(2 * math.pi * turns)
        n = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) @ n
    assert hit.normal == pytest.approx(-n if swapped else n, abs=1e-9)


@pytest.mark.share(4)
@pytest.mark.parametrize("size", [F(1), F(1, 1000), F(1, 2**30), F(2**20)], ids=str)
@pytest.mark.parametrize("exact", [False, True])
def test_a_point_on_the_tip_of_a_cone_has_no_normal(size, exact):
    """A gradient of 0 was rounded to a direction, one for each order of the bodies."""
    tip, other = fc.cone(3 * size, 4 * size).translated((0, 0, -4 * size)), fc.Polyhedron([(0, 0, 0)], [])
    for way, turned in itertools.product(((3, -6, 0), (3, 1, 1), (0, 1, -2)), (False, True)):
        v = [size * x for x in way]
        moving = other.translated([-x / 3 for x in v]).moving(fc.Translation(v))
        a, b = (tip, moving) if turned else (moving, tip)
        hit = fc.first_contact(a, b, exact=exact)
        assert hit.status is fc.Status.CONTACT
        assert hit.time == pytest.approx(1 / 3) and hit.normal is None


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("radius", [F(1), F(1, 6144), F(100)], ids=str)
def test_a_contact_at_the_origin_has_its_normal(radius, swapped):
    """All terms of a form are 0 there, so their size told nothing and the normal was lost."""
    ball = fc.sphere(radius).translated((0, 0, radius))
    leaf = fc.Polyhedron([(0, 0, 0), (3, 0, -1), (0, 3, -1)], [[0, 1, 2]])
    moving = leaf.translated((0, 1, -4)).moving(fc.Translation((0, -1, 4)))
    hit = fc.first_contact(*((moving, ball) if swapped else (ball, moving)), exact=True)
    assert hit.time_exact == 1 and hit.normal == pytest.approx([0, 0, -1 if swapped else 1])
