"""Edges of degree 4 and corners of three quadrics that touch at one point, which both bodies hold by construction.

All forms vanish at the origin, and the direction (0, 0, 1), or its image, goes inside all of those of one body.
"""

import pytest

import firstcontact as fc


def _quadrics(*matrices):
    first, *rest = (fc.quadric(matrix) for matrix in matrices)
    for other in rest:
        first = first & other
    return first


def _lens():
    return _quadrics(
        [[3, -2, -1, "1/24"], [-2, "11/2", -1, "1/8"], [-1, -1, 2, "-17/24"], ["1/24", "1/8", "-17/24", 0]],
        [["13/3", "-10/3", "11/3", "-13/288"], ["-10/3", "20/3", -6, "-13/96"], ["11/3", -6, "17/3", "-1/2"],
         ["-13/288", "-13/96", "-1/2", 0]],
    ).transformed([["4/5", "-3/5", 0, 0], ["3/5", "4/5", 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])  # fmt: skip


def _corner():
    return _quadrics(
        [[4, "10/3", -2, "1/2"], ["10/3", 3, "-5/3", 0], [-2, "-5/3", "5/3", "-23/24"], ["1/2", 0, "-23/24", 0]],
        [["4/3", "-1/3", "7/3", "-1/2"], ["-1/3", "4/3", "5/3", "1/2"], ["7/3", "5/3", "25/3", "-3/8"],
         ["-1/2", "1/2", "-3/8", 0]],
        [[5, 6, "-1/2", "1/4"], [6, 8, 1, "-1/2"], ["-1/2", 1, "7/2", "-1/3"], ["1/4", "-1/2", "-1/3", 0]],
    ).transformed([[0, 0, 1, 0], ["12/13", "5/13", 0, 0], ["-5/13", "12/13", 0, 0], [0, 0, 0, 1]])  # fmt: skip


def _led():
    """Its origin goes straight, and is the world's at 3/4."""
    quaternions = [[-17, 19, 17, -19], [0, 1, 0, -1]]
    poses = [(0, "-12/13", "189/52"), (0, "4/13", "-63/52")]
    return _lens().moving(fc.Trajectory([0, 1], poses, quat_wxyz=quaternions, interpolation="linear-quaternion"))


@pytest.mark.thorough
@pytest.mark.parametrize("span", [None, ("3/4", "3/4"), ("3/4", 1)])
def test_a_graze_at_one_instant_is_no_freedom(span):
    for a, b in ((_led(), _corner()), (_corner(), _led())):
        found = fc.contact_intervals(a, b, span)
        assert [(x.start, x.end) for x in found] == [(0.75, 0.75)]
        hit = fc.first_contact(a, b, span)
        assert hit.time_interval == (0.75, 0.75) and abs(hit.point).max() < 1e-12


@pytest.mark.thorough
def test_at_rest_they_touch():
    hit = fc.first_contact(_led().at(0.75), _corner())
    assert hit.status is fc.Status.INITIAL_CONTACT and hit.initial == "touching"
    assert [(x.start, x.end) for x in fc.contact_intervals(_led().at(0.75), _corner(), (0, 2))] == [(0, 2)]


def test_rational_corners_are_points():
    carriers = [type(x.carrier).__name__ for x in _corner().vertices]
    assert "Point" in carriers


@pytest.mark.thorough
@pytest.mark.parametrize(("shift", "status"), [(0, "INITIAL_CONTACT"), ("1/1000000", "FREE"), (-1, "INITIAL_CONTACT")])
def test_an_edge_of_degree_four_on_a_plane_at_rest(shift, status):
    """x^2 + y^2 <= 1 and x^2 + z^2 <= 4, with y >= 0: the highest points of the edge are (0, y, 2)."""
    bicylinder = fc.quadric([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, -1]]) & fc.quadric(
        [[1, 0, 0, 0], [0, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, -4]]
    )
    table = fc.box((8, 8, 2)).translated((0, 0, 3)).translated((0, 0, shift))
    assert fc.first_contact(bicylinder, table).status.name == status


@pytest.mark.thorough
@pytest.mark.parametrize(("shift", "allowed"), [(0, {"INITIAL_CONTACT", "UNDECIDED"}), ("1/1000000", {"FREE"})])
def test_an_edge_that_touches_a_plane_in_irrational_points(shift, allowed):
    """z <= y^2 - x^2 within x^2 + y^2 <= 2: the highest points (0, +-sqrt(2), 2) are on the edge alone."""
    saddle = fc.quadric([[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, "1/2"], [0, 0, "1/2", 0]])
    body = saddle & fc.quadric([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, -2]]) & fc.box((8, 8, 8))
    table = fc.box((8, 8, 2)).translated((0, 0, 3)).translated((0, 0, shift))
    for pair in ((body, table), (table, body)):
        assert fc.first_contact(*pair).status.name in allowed
