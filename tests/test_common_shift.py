"""A body that turns beside one that shifts along its axis is told as on a screw beside one at rest."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.contact import common_shift
from firstcontact.work import Query

UP = (0, 0, 1)
LIFT = fc.Translation((0, 0, F(3, 2)))
STRIP = fc.RuledSurface.from_nurbs(
    [[(x, y, 1), (x, y, F(3, 2))] for x, y in ((-1, -1), (3, -1), (0, 2), (-1, -1))], knots=[0, 0, 1, 2, 3, 3]
)
WALL = fc.Polyhedron([(1, -9, 0), (1, 9, 0), (1, 9, 3), (1, -9, 3)], [[0, 1, 2, 3]]).named("wall")
POST = fc.box((1, 1, 9)).translated((F(5, 2), F(5, 2), 0))
PAIRS = {
    "a strip and a wall": (STRIP, WALL),
    "a ring and a post": (fc.torus(3, F(1, 2)).translated((1, 0, 0)), POST),
    "a cone and a post": (fc.cone(1, 2).translated((3, 0, 0)), POST),
}


@pytest.mark.thorough
@pytest.mark.parametrize("swap", (False, True))
@pytest.mark.parametrize("turned, other", PAIRS.values(), ids=PAIRS)
def test_the_same_relative_motion_is_told_alike(turned, other, swap):
    both = turned.moving(fc.Screw(UP, turns=F(2, 7), advance=F(5, 2))), other.moving(LIFT)
    seen = turned.moving(fc.Screw(UP, turns=F(2, 7), advance=1)), other
    first, then = (fc.contact_intervals(*(pair[::-1] if swap else pair)) for pair in (both, seen))
    assert (first.status, len(first)) == (then.status, len(then))
    for x, y in zip(first, then, strict=True):
        assert max(abs(x.start - y.start), abs(x.end - y.end)) < 1e-12
    hit, still = fc.first_contact(*both), fc.first_contact(*seen)
    assert (hit.a, hit.b, hit.status) == (*both, still.status)
    if still.point is not None:
        assert hit.time == still.time
        assert np.abs(hit.point - still.point - [0, 0, 1.5 * hit.time]).max() < 1e-9


@pytest.mark.share(2)
@pytest.mark.parametrize("turn", (fc.Rotation(UP, degrees=90), fc.Screw((0, 3, 4), degrees=90, advance=F(1, 2))))
def test_a_shift_along_the_axis_is_taken_off(turn):
    asked = []
    way = fc.Translation([3 * x for x in turn.axis])
    query = Query(STRIP.moving(turn), WALL.moving(way), 0, 1)
    a, b = query.bodies
    common_shift.asked(lambda own: asked.append(own) or fc.contact_intervals(a, b), query)
    seen = asked[0].a
    assert asked[0].b is WALL
    for t in (0.25, 1.0):
        moved = np.linalg.inv(way(t)) @ turn(t)
        assert np.abs(seen.motion(t) - moved).max() < 1e-12


@pytest.mark.parametrize("turn, way", (
    (fc.Rotation(UP, degrees=90), (0, 1, 1)),
    (fc.Rotation((1, 1, 0), degrees=90), (1, 1, 0)),  # of an axis whose length is no rational number
    (fc.Translation((1, 0, 0)), (1, 0, 0)),
))  # fmt: skip
def test_other_motions_are_asked_about_as_they_are(turn, way):
    query, asked = Query(STRIP.moving(turn), WALL.moving(fc.Translation(way)), 0, 1), []
    common_shift.asked(asked.append, query)
    assert asked == [query]
