"""Polyhedra that screw down to a plate: the time told is the double nearest the true one, at the end of a step too."""

from __future__ import annotations

from fractions import Fraction as F
from random import Random

import pytest

import firstcontact as fc

PLATE = fc.Polyhedron([(-60, -60, 0), (60, -60, 0), (60, 60, 0), (-60, 60, 0)], [[0, 1, 2], [0, 2, 3]])
BIPYRAMID = fc.Polyhedron(
    [(-9, 8, F(7, 3)), (-9, 5, F(13, 3)), (-9, 2, F(7, 3)), (-9, 5, F(1, 3)), (-6, 5, F(7, 3)), (-12, 5, F(7, 3))],
    [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5]],
)
TURNS = {"turns": F(1, 4)}, {"turns": F(1, 7)}, {"radians": F(3, 2)}, {"degrees": -540}


@pytest.mark.parametrize("turn", TURNS, ids=str)
def test_a_vertex_seats_as_the_screw_ends(turn):
    seating = BIPYRAMID.moving(fc.Screw((0, 0, 1), (-8, 6, 0), advance=F(-1, 3), **turn))
    hit = fc.first_contact(seating, PLATE)
    assert hit.time == 1.0 and hit.time_interval == (1.0, 1.0) and str(hit.element_a) == "a vertex 3"
    assert fc.first_contact(seating, PLATE, span=(0, hit.time)).status is fc.Status.CONTACT
    short = BIPYRAMID.moving(fc.Screw((0, 0, 1), (-8, 6, 0), advance=F(-1, 3) + F(1, 2**60), **turn))
    assert fc.first_contact(short, PLATE).status is fc.Status.FREE


@pytest.mark.parametrize("turn", TURNS, ids=str)
def test_a_block_seats_flat_as_a_step_ends(turn):
    block = fc.Polyhedron(
        [(x, y, z) for x in (0, 1) for y in (0, 2) for z in (F(1, 3), F(4, 3))],
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]],
    )
    down = fc.Screw((0, 0, 1), (-8, 6, 0), advance=F(-1, 3), **turn)
    hit = fc.first_contact(block.moving(fc.Sequence([down, fc.Translation((1, 0, 1))], [2, 3])), PLATE)
    assert (hit.time, hit.multiplicity) == (2.0, 4) and hit.normal.tolist() == [0, 0, 1]


@pytest.mark.parametrize("seed", range(24))
def test_times_are_the_nearest_doubles(seed):
    """The lowest vertex comes down along the axis as (height - fall t), whatever the turn: the time is a fraction."""
    rng = Random(seed)
    height = F(rng.randint(1, 40), rng.choice((3, 5, 7, 8)))
    x, y = rng.randint(-9, 9), rng.randint(-9, 9)
    top = [(x + 2, y, height + 3), (x - 1, y + 2, height + 2), (x - 1, y - 2, height + 4)]
    body = fc.Polyhedron([(x, y, height), *top], [[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])
    begins, length = F(rng.choice((0, 0, 1)), 3), F(rng.choice((1, 3, 10)), rng.choice((1, 7)))
    share = rng.choice((F(1), F(1), F(1, 3), F(2, 3), F(5, 11), 1 - F(1, 2**60), 1 + F(1, 2**60)))
    axis = rng.choice(((0, 0, 1), (0, 0, -2)))
    fall = height / share * (1 if axis[2] > 0 else -1)
    screw = fc.Screw(axis, (F(1, 3), 2, 5), advance=-fall, turns=F(rng.choice((1, -3, 5)), rng.choice((4, 7, 9))))
    wait = [fc.Rotation((0, 0, 1), (x, y, 0), turns=F(1, 4))] if begins else []
    motion = fc.Sequence([*wait, screw], [begins, length] if begins else [length])
    hit = fc.first_contact(body.moving(motion), PLATE)
    if share > 1:
        assert hit.status is fc.Status.FREE
        return
    time = begins + length * share
    assert hit.time == float(time) and hit.time_interval[0] <= time <= hit.time_interval[1]
    if share == 1:
        assert fc.first_contact(body.moving(motion), PLATE, span=(0, time)).status is fc.Status.CONTACT
