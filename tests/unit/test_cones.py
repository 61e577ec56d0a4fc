"""Cones that share inner points though no edge of one goes into the other."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.search.trees.cones import cones_overlap
from firstcontact.search.trees.elements import EDGE
from firstcontact.search.trees.shared_points import RestingVertices, shared_points

TURN = [[F(3, 5), F(-4, 5), 0, 0], [F(4, 5), F(3, 5), 0, 0], [0, 0, 1, F(1, 3)], [0, 0, 0, 1]]
SIDES = [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]


def wedge(along, across, height):
    """A tetrahedron with an edge through the origin, and the opposite one at some height."""
    along, across, up = (np.array(v) for v in (along, across, (0, 0, height)))
    return fc.Polyhedron([along, -along, up + across, up - across], SIDES)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("height, expected", [(1, True), (-1, False)])
def test_thin_wedges_across_each_other(height, expected, turned):
    """Of the cell that they share every corner is where two facets cross."""
    a, b = wedge((8, 0, 0), (0, 1, 0), 8), wedge((0, 8, 0), (1, 0, 0), 8 * height)
    if turned:  # fifths are no doubles
        a, b = (body.transformed(TURN) for body in (a, b))
    resting = RestingVertices(a, b)
    shared = shared_points(resting)
    crossings = [pair for pair in shared if pair[0][0] == pair[1][0] == EDGE]
    at_origin = [pair for pair in crossings if pair[0][1] == 0 and pair[1][1] == 0]
    assert len(at_origin) == 1 and cones_overlap(resting, at_origin[0]) is expected
