"""Triangles that land flat on a trimmed piece: however their corners are listed, they touch then, by the same elements.

A triangle is ruled from its first corner, and where one of these rulings lay along one of the disc, contact was not
decided.  Truths are by hand: the plane of the triangle reaches that of the disc at a known time.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.body.ruled.rational_curve import RationalCurve
from firstcontact.contact.ruled.crossing import across
from firstcontact.contact.ruled.triangles import triangles_of

DISC = fc.RuledSurface("(u,-1,0)", "(u,1,0)", u=(-1, 1), trim=["u**2+(2*s-1)**2<=1"])
DOWN = fc.Translation((0, 0, -2))
OVER = [(-3, -3, 1), (3, -3, 1), (0, 4, 1)]
ORDERS = list(itertools.permutations(range(3)))


def triangle(corners, order):
    """The same triangle, its corners listed in this order."""
    return fc.Polyhedron([corners[k] for k in order], [[0, 1, 2]])


def places(body, element):
    """The corners of an element of a triangle, in no order."""
    if element.kind == "vertex":
        return {tuple(body.vertices[element.index].tolist())}
    rows = body.triangles[0] if element.kind == "face" else body.edges[element.index]
    return {tuple(body.vertices[k].tolist()) for k in rows}


@pytest.mark.parametrize("order", ORDERS)
def test_a_disc_in_the_middle_of_a_triangle(order):
    hit = fc.first_contact(triangle(OVER, order).moving(DOWN), DISC)
    assert (hit.status, hit.time) == (fc.Status.CONTACT, 0.5)
    assert [(x.start, x.end) for x in fc.contact_intervals(triangle(OVER, order).moving(DOWN), DISC)] == [(0.5, 0.5)]


@pytest.mark.parametrize("corners", [
    [(0, 0, 1), (2, 0, 1), (0, 2, 1)],  # a corner in the disc's middle, sides along its rulings and across
    [(0, -3, 1), (0, 3, 1), (3, 0, 1)],  # a side along its middle ruling
    [(1, 0, 1), (3, 1, 1), (3, -1, 1)],  # a corner on its rim
])  # fmt: skip
def test_the_same_elements_touch_whatever_comes_first(corners):
    seen = set()
    for order in ORDERS:
        body = triangle(corners, order)
        for a, b in ((body.moving(DOWN), DISC), (DISC, body.moving(DOWN))):
            hit = fc.first_contact(a, b)
            assert (hit.status, hit.time) == (fc.Status.CONTACT, 0.5)
            pairs = [(hit.element_a, hit.element_b), *((x.element_a, x.element_b) for x in hit.others)]
            own = [pair if a is not DISC else pair[::-1] for pair in pairs]
            seen.add(frozenset((frozenset(places(body, x)), y.kind, y.index) for x, y in own))
    assert len(seen) == 1


@pytest.mark.parametrize("order", ORDERS)
def test_from_the_middle_outwards_about_a_ruling(order):
    wedge = triangle([(0, 0, 1), (1, 4, 1), (-1, 4, 1)], order)
    for a, b in ((wedge.moving(DOWN), DISC), (DISC, wedge.moving(DOWN))):
        hit = fc.first_contact(a, b)
        assert (hit.status, hit.time) == (fc.Status.CONTACT, 0.5)


@pytest.mark.parametrize("faces", [
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]],
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
     [1, 5, 7], [1, 7, 3]],
    [[1, 3, 2], [1, 2, 0], [6, 7, 5], [6, 5, 4], [4, 5, 1], [4, 1, 0], [3, 7, 6], [3, 6, 2], [2, 6, 4], [2, 4, 0],
     [5, 7, 3], [5, 3, 1]],
])  # fmt: skip
@pytest.mark.parametrize("way", [-1, 1])
def test_a_cube_on_either_side_by_any_diagonal(faces, way):
    cube = fc.Polyhedron(list(itertools.product((-1, 1), repeat=3)), faces).translated((0, 0, -2 * way))
    hit = fc.first_contact(cube.moving(fc.Translation((0, 0, 2 * way))), DISC)
    assert (hit.status, hit.time) == (fc.Status.CONTACT, 0.5)
    assert abs(hit.point[2]) < 1e-12 and np.hypot(*hit.point[:2]) <= 1 + 1e-12


@pytest.mark.parametrize("order", ORDERS)
def test_no_ruling_of_the_triangle_lies_along_the_disc(order):
    """By the directions of its end rulings, both on one side of the disc's way."""
    piece, _, _ = across(triangles_of(triangle(OVER, order))[0], DISC)
    corner, *ends = (np.array([float(x(u) / c.components[3](u)) for x in c.components[:2]])
                     for c, u in ((piece.first, 0), (piece.second, 0), (piece.second, 1)))  # fmt: skip
    first, last = (end - corner for end in ends)
    assert first[0] * last[0] > 0


@pytest.mark.parametrize("k", [0, 1, 2])
@pytest.mark.parametrize("inner", [0, 1, 2])
def test_inner_sides_stay_inner_when_the_triangle_is_ruled_from_another_corner(k, inner):
    """A diagonal of a face, by the corners at both of its ends; u0, s1 and u1 go around from the first corner."""
    names, corners = ("u0", "s1", "u1"), [tuple(map(fmpq, x)) for x in ((0, 0, 0), (2, 0, 1), (2, 3, 0))]
    a, b, c = corners
    piece = fc.RuledSurface(RationalCurve.segment(a, a), RationalCurve.segment(b, c))
    turned = piece._with(joined=frozenset({names[inner]})).ruled_from(k)
    (told,) = turned.joined
    side, around = names.index(told), turned.corners()
    assert around[0] == corners[k]
    assert {around[side], around[(side + 1) % 3]} == {corners[inner], corners[(inner + 1) % 3]}
