"""Corners in whole numbers of one scale, beside the fractions that bodies were made of."""

from fractions import Fraction as F
from random import Random

import pytest
from flint import fmpq, fmpz

import firstcontact as fc
from firstcontact.search.trees.elements import EDGE, FACE, MOST_BITS, VERTEX, WholeCorners

TRIANGLES = [(0, 1, 2), (2, 1, 3), (3, 1, 4)]


def body(random, denominators):
    """(five vertices, the polyhedron on them)."""
    places = [[F(random.randint(-99, 99), random.choice(denominators)) for _ in range(3)] for _ in range(5)]
    return places, fc.Polyhedron(places, TRIANGLES)


@pytest.mark.parametrize("number", [int, fmpz])
@pytest.mark.parametrize("seed", range(20))
def test_corners_and_vector_are_the_bodies_own_times_one_scale(seed, number):
    """Vertices ask for larger scales one after the other; with these denominators some pairs need one of their own."""
    random = Random(seed)
    huge = [random.getrandbits(90) | 1 for _ in range(4)]
    (of_a, a), (of_b, b) = body(random, [1, 2, 2**30, 3, 7]), body(random, [1, 5, 2**44, *huge[: seed % 5]])
    vector = F(1, 6), F(-5, 4), F(2)
    corners = WholeCorners(a, b, tuple(fmpq(x.numerator, x.denominator) for x in vector), number)
    sides, alone = a.segments.tolist(), False
    elements = [(VERTEX, k) for k in range(5)] + [(EDGE, k) for k in range(len(sides))] + [(FACE, k) for k in range(3)]
    for _ in range(60):
        x, y = random.choice(elements), random.choice(elements)
        scale, p, q, v = corners.of(x, y)
        alone = alone or int(scale).bit_length() > MOST_BITS
        for found, element, places in ((p, x, of_a), (q, y, of_b)):
            kind, k = element
            own = [k] if kind == VERTEX else sides[k] if kind == EDGE else TRIANGLES[k]
            assert [[F(int(c), int(scale)) for c in point] for point in found] == [places[n] for n in own]
            assert all(type(c) is number for point in found for c in point)
        assert tuple(F(int(c), int(scale)) for c in v) == vector and scale > 0
    assert alone or seed % 5 < 4
    assert not alone or seed % 5 > 2
