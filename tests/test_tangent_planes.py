"""Discs that slide in a plane which stays tangent to a quadric: they meet while the tangent point is on the disc.

The section of the quadric by the plane is one point at all times, so the pencil of rim and section has a root for all
times, and where the rim passes the point that root is double.
"""

import math
from fractions import Fraction as F

import pytest

import firstcontact as fc

ROUND = {
    "ball": fc.sphere(1).translated((0, 0, 1)),
    "ellipsoid": fc.ellipsoid((2, 3, 1)).translated((0, 0, 1)),
    "bowl": fc.paraboloid((2, 1), 1),
    "two sheets": fc.hyperboloid((2, 1, 3), 12, sheets=2).translated((0, 0, -3)),
}
WAYS = {
    "straight": ((0, 0), F(2, 5), F(3, 5)),
    "beside the middle": ((0, F(3, 5)), F(21, 50), F(29, 50)),  # half a chord is 4/5
    "grazing": ((0, 1), F(1, 2), F(1, 2)),
}


@pytest.mark.share(6)
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("body", ROUND)
def test_a_disc_slides_over_the_point_in_which_its_plane_touches(body, way):
    (x, y), start, end = WAYS[way]
    disc = fc.cylinder(1, 2).translated((5 + x, y, -1)).moving(fc.Translation((-10, 0, 0)))
    for a, b in ((disc, ROUND[body]), (ROUND[body], disc)):
        first = fc.first_contact(a, b, exact=True)
        assert (first.status.name, first.time_exact) == ("CONTACT", start)
        assert fc.first_contact(a, b).time_interval[0] <= start <= fc.first_contact(a, b).time_interval[1]
        all_times = fc.contact_intervals(a, b, exact=True)
        assert [(x.start_exact, x.end_exact) for x in all_times] == [(start, end)]


def test_a_small_frustum_leaves_the_point_in_which_it_touches_a_ball():
    """Found by the soak: `contact_intervals` told FREE."""
    ball = fc.sphere(2).translated((0, 0, -2))
    r, c, v = F(3, 2**18), (F(-1, 327680), F(3, 1310720)), (F(-1, 8), F(1, 14))
    disc = fc.frustum(r, r / 2, F(1, 2**17)).translated((*c, 0)).moving(fc.Translation((*v, 0)))
    end = fc.contact_intervals(ball, disc, exact=True)[0].end
    low, high = (F(math.nextafter(end, way)) for way in (0.0, 1.0))

    def beyond(t):
        return (c[0] + t * v[0]) ** 2 + (c[1] + t * v[1]) ** 2 - r**2

    assert beyond(low) < 0 < beyond(high)
    assert fc.contact_intervals(ball, disc)[0].start == 0.0
