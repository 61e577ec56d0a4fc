"""Bodies with pairs of straight edges that no rational matrix tells apart: flats of bars, keyways, crossing cylinders.

Such an edge comes to lie in the plane of a rim, or in one line with another such edge, at irrational times.
"""

from __future__ import annotations

from fractions import Fraction as F

import pytest
from flint import fmpq, fmpz_poly

import firstcontact as fc
from firstcontact import Status
from firstcontact.exact.fields.number_field import sign
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.pairs.carriers import conic_conic, line_conic

BAR = fc.cylinder(3, 2) & fc.half_space((0, 1, 0), 1)
"""With a flat at y = 1: straight edges at x = +-sqrt(8), z from -1 to 1."""
PIN = fc.cylinder(2, 2).rotated((0, 1, 0), degrees=90).translated((0, 0, 9))
"""z from 7 to 11."""
PAST = fc.Translation((-16, 0, 0))


@pytest.mark.parametrize("exact", [False, True])
def test_an_edge_in_the_plane_of_a_rim_that_is_far_above(exact):
    bar = BAR.translated((8, 0, 0)).moving(PAST)
    for pair in ((bar, PIN), (PIN, bar)):
        assert fc.first_contact(*pair, exact=exact).status is Status.FREE
        assert not len(fc.contact_intervals(*pair, exact=exact))


def test_a_ball_on_the_bar_grazes_the_pin():
    body = (BAR | fc.sphere(1).translated((0, 0, 6))).translated((8, 0, 0)).moving(PAST)
    for pair in ((body, PIN), (PIN, body)):
        assert fc.first_contact(*pair).time == 7 / 16
        assert fc.first_contact(*pair, exact=True).time_exact == F(7, 16)
        (only,) = fc.contact_intervals(*pair)
        assert (only.start, only.end) == (7 / 16, 9 / 16)


def test_a_keyway_that_leaves_a_pin():
    """They touch at the start; after it one has x < -2, the other x >= -2."""
    keyed = (fc.cylinder(3, 2) - fc.box((4, 1, 4)).translated((3, 0, 0))).transformed(
        [[0, 0, 1, -3], [0, -1, 0, 2], [-1, 0, 0, 0], [0, 0, 0, 1]]
    )
    body, pin = keyed.moving(fc.Translation((-1, 1, 5))), fc.cylinder(2, 2)
    for pair in ((body, pin), (pin, body)):
        assert [(x.start, x.end) for x in fc.contact_intervals(*pair)] == [(0, 0)]
        assert fc.first_contact(*pair, span=("1/3", "1/2"), exact=True).status is Status.FREE


@pytest.mark.parametrize("way", [1, -1])
def test_an_edge_lands_in_the_middle_of_another_body(way):
    """The edge at x = sqrt(8) meets the end of a rim, or an edge of a box, at the height of both."""
    wall = fc.box((2, 2, 1)).translated((10, 1, 0))  # x from 9, y from 0 to 2
    bar = BAR if way == 1 else BAR.rotated((0, 1, 0), degrees=180)
    run = bar.moving(fc.Translation((8, 0, 0)))
    for pair in ((run, wall), (wall, run)):
        hit = fc.first_contact(*pair, exact=True)
        assert float(hit.time_exact) == pytest.approx((9 - 3) / 8, abs=1e-15)  # the round side at y = 0 is foremost
    high = wall.translated((0, 1, 0))  # y from 1: it meets the edge alone
    for pair in ((run, high), (high, run)):
        hit = fc.first_contact(*pair, exact=True)
        assert float(hit.time_exact) == pytest.approx((9 - 8**0.5) / 8, abs=1e-14)
        assert fc.first_contact(*pair).time == pytest.approx((9 - 8**0.5) / 8, abs=1e-12)


@pytest.mark.parametrize("beside", [0, 3], ids=["in one line", "beside each other"])
def test_edges_of_two_bars_come_in_one_line(beside):
    """Of bars on both sides of the plane y = 1, whose edges meet where they are in one line, and as high."""
    other = BAR.rotated((0, 0, 1), degrees=180).translated((0, 2, beside)).translated((8, 0, 0))
    run = BAR.moving(fc.Translation((8, 0, 0)))
    for pair in ((run, other), (other, run)):
        hit = fc.first_contact(*pair, exact=True)
        if beside:
            assert hit.status is Status.FREE
        else:
            assert float(hit.time_exact) == pytest.approx((8 - 2 * 8**0.5) / 8, abs=1e-14)
            assert hit.point[1] == pytest.approx(1)


def test_edges_of_flats_in_different_planes_come_in_one_line():
    """The edge at (sqrt(8), 1) + 8 t (1, 1) and that at (5, 6 - sqrt(8)) are the foremost of both bars."""
    other = BAR.rotated((0, 0, 1), degrees=90).translated((6, 6, 0))
    run = BAR.moving(fc.Translation((8, 8, 0)))
    for pair in ((run, other), (other, run)):
        hit = fc.first_contact(*pair, exact=True)
        assert float(hit.time_exact) == pytest.approx((5 - 8**0.5) / 8, abs=1e-14)
        assert hit.point[:2] == pytest.approx([5, 6 - 8**0.5])
        assert abs(hit.point[2]) <= 1
    aloft = other.translated((0, 0, 3))
    for pair in ((run, aloft), (aloft, run)):
        assert fc.first_contact(*pair, exact=True).status is Status.FREE


def poly(*coefficients):
    return fmpz_poly(list(coefficients))


def rows(*values):
    """Numbers as constants, `U` as the parameter."""
    return tuple(tuple(poly(0, 1) if c == "u" else poly(c) for c in row) for row in values)


AT_ROOT_2 = AlgebraicRoot(fmpz_poly([-2, 0, 1]), fmpq(1), fmpq(2))
BASIS, PAIR = rows((1, 0, 0), (0, 0, 0), (0, 1, 0), (0, 0, 1)), rows((1, 0, 0), (0, 0, 0), (0, 0, -2))
"""x^2 = 2 in the plane y = 0, of points (x, z)."""


def test_pairs_of_edges_in_two_planes_have_a_line_in_common():
    """The other pair is y = 0 and y = 2 in the plane x = u, which meets the first one in x = u, y = 0."""
    across, other = rows((0, 0, "u"), (1, 0, 0), (0, 1, 0), (0, 0, 1)), rows((1, 0, -1), (0, 0, 0), (-1, 0, 0))
    for sides in (((BASIS, PAIR), (across, other)), ((across, other), (BASIS, PAIR))):
        (only,) = conic_conic.contacts(*sides, AT_ROOT_2).found
        assert only.kind == "line"
        for x in only.span:
            assert [sign(c) for c in (x[1], x[0] * x[0] - 2 * x[3] * x[3])] == [0, 0]


def test_an_edge_comes_to_lie_on_one_of_a_pair():
    line = rows((0, "u"), (0, 0), (1, 0), (0, 1))
    (only,) = line_conic.contacts(line, BASIS, PAIR, AT_ROOT_2).found
    assert only.kind == "line"
    (beside,) = (rows((0, 1), (0, 0), (1, 0), (0, 1)),)
    assert not line_conic.contacts(beside, BASIS, PAIR, AT_ROOT_2).found


def test_edges_that_come_in_one_line_share_a_segment():
    for other, way in (
        (BAR.rotated((0, 0, 1), degrees=90).translated((6, 6, "3/2")), (8, 8, 0)),
        (fc.box((2, 2, 1)).translated((10, 2, "5/4")), (8, 0, 0)),
    ):
        hit = fc.first_contact(BAR.moving(fc.Translation(way)), other, exact=True)
        assert str(hit.contact_set) == "segment"
