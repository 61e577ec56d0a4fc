"""Motions that are a shift, a rotation or a screw over the span: told by what is known of these."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.contact.plain import plainly
from firstcontact.exact.numbers import rational

ONE = np.eye(4, dtype=int).tolist()
RING = fc.torus(3, 2)
CONTACT = fc.Status.CONTACT


def shifted(by: tuple[int, int, int]) -> list[list[int]]:
    return [[*row[:3], x] for row, x in zip(ONE, (*by, 1), strict=True)]


def shift(by: tuple[int, int, int]) -> fc.RationalMotion:
    """t times that."""
    return fc.RationalMotion([ONE, [[0, 0, 0, x] for x in (*by, 0)]])


DOWN = (0, 0, -2)
HALF = fc.Translation((0, 0, -1))
SHIFTS = {
    "of the first degree": shift(DOWN),
    "between poses": fc.RationalMotion.between(ONE, shifted(DOWN)),
    "a trajectory": fc.Trajectory([0, 1], [ONE, shifted(DOWN)]),
    "a trajectory in screws": fc.Trajectory([0, 1], [ONE, shifted(DOWN)], interpolation="screw"),
    "steps that go on": fc.Sequence([HALF, HALF]),
    "uneven steps": fc.Sequence([fc.Translation((0, 0, z)) for z in (F(-1, 2), F(-3, 2))], [F(1, 4), F(3, 4)]),
}


@pytest.mark.thorough
@pytest.mark.parametrize("motion", SHIFTS.values(), ids=SHIFTS)
def test_a_ball_lands_on_a_ring_however_its_shift_is_told(motion):
    """All about one axis they touch along a circle: the centre is at 4 above the ring's, as 3, 4, 5."""
    ball = fc.sphere(3).translated((0, 0, 5)).moving(motion)
    hit = fc.first_contact(ball, RING)
    assert (hit.status, hit.time, hit.a, hit.b) == (CONTACT, 0.5, ball, RING)
    found = fc.contact_intervals(RING, ball)
    assert (len(found), found[0].start, found[0].end, found.b) == (1, 0.5, 1.0, ball)


@pytest.mark.share(6)
@pytest.mark.parametrize("motion", SHIFTS.values(), ids=SHIFTS)
def test_a_block_that_slides_meets_what_is_new(motion):
    """Along a wall in which it touches at the start, down to a floor at a third."""
    block = fc.box((2, 2, 2)).translated((0, 0, 1)).moving(motion)
    corner = fc.box((2, 20, 20)).translated((2, 0, 0)) | fc.box((20, 20, 2)).translated((0, 0, F(-5, 3)))
    hit = fc.first_new_contact(block, corner)
    assert (hit.status, hit.time, hit.a) == (CONTACT, 1 / 3, block)


def test_what_is_plain_is_told_over_the_span_alone():
    turn, ahead = fc.Rotation((0, 0, 1), degrees=90), fc.Translation((4, 0, 0))
    body = fc.box((1, 1, 1)).moving(fc.Sequence([turn, ahead]))
    first, half, last = (rational(x, "time") for x in (0, F(1, 2), 1))
    assert plainly(body, first, last) is body
    assert plainly(body, first, half).motion == fc.Rotation((0, 0, 1), degrees=180)
    then = plainly(body, half, last)
    assert then.motion == fc.Translation((8, 0, 0))
    for t in (F(1, 2), F(3, 4), 1):
        assert np.abs(then.at(t).bounds() - np.array(body.at(t).bounds())).max() < 1e-12


@pytest.mark.parametrize("motion", (
    fc.RationalMotion([ONE, [[0] * 4] * 4, [[0, 0, 0, x] for x in (*DOWN, 0)]]),
    fc.RationalMotion([ONE, [[1, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]]),
    fc.RationalMotion.between(ONE, [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]),
    fc.Sequence([HALF, fc.Translation((0, 1, 0))]),
))  # fmt: skip
def test_what_speeds_up_stretches_turns_or_bends_off_is_no_shift(motion):
    body = fc.sphere(1).moving(motion)
    assert plainly(body, rational(0, "time"), rational(1, "time")) is body
