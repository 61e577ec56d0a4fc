"""One body carries far more rounding than the other: nearly level edges must not be decided by noise.

A far vertex with fractional coordinates makes the error of body a large; it changes no contact.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc

FAR = 2**30 + Fraction(1, 3)


def level_edges(heights, far: bool):
    """A post of a, nearly level, turns onto a nearly level spoke of b."""
    corners = [[2, -2, heights[0]], [2, 2, heights[1]]]
    edges = [[0, 1]]
    if far:
        corners += [[FAR, FAR, 50], [FAR, FAR + 1, 60]]
        edges += [[2, 3]]
    spoke = [[0, Fraction(1, 2), heights[2] / 64], [0, 8, heights[3] / 64]]
    return fc.Polyhedron(corners, [], edges=edges), fc.Polyhedron(spoke, [], edges=[[0, 1]])


@pytest.mark.parametrize("swapped", [False, True])
def test_nearly_level_edges_in_a_turn(swapped):
    rng = np.random.default_rng(71)
    statuses = set()
    for _ in range(40):
        heights = [Fraction(int(x), 2**28) for x in rng.integers(-16, 17, 4)]
        answers = []
        for far in (False, True):
            a, b = level_edges(heights, far)
            turn = fc.Rotation((0, 0, 1), turns=Fraction(-1 if swapped else 1, 2))
            hit = fc.first_contact(b.moving(turn), a) if swapped else fc.first_contact(a.moving(turn), b)
            answers.append((hit.status, hit.time))
        assert answers[0] == answers[1], heights
        statuses.add(answers[0][0])
    assert statuses == {fc.Status.FREE, fc.Status.CONTACT}


def test_nearly_vertical_edges_in_a_translation():
    rng = np.random.default_rng(72)
    statuses = set()
    for _ in range(40):
        heights = [Fraction(int(x), 2**28) for x in rng.integers(-16, 17, 4)]
        answers = []
        for far in (False, True):
            a, b = level_edges(heights, far)
            hit = fc.first_contact(a.moving(fc.Translation((-4, 1, 2.0**-26))), b)
            answers.append((hit.status, hit.time))
        assert answers[0] == answers[1], heights
        statuses.add(answers[0][0])
    assert statuses == {fc.Status.FREE, fc.Status.CONTACT}
