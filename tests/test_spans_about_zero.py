"""Rotations over spans that begin before 0, where the motion's own step does, and end after it."""

import math
from fractions import Fraction

import pytest

import firstcontact as fc

F = Fraction
TURN = fc.Rotation((0, 0, 1), (1, -2, 0), degrees=270)


@pytest.mark.share(4)
@pytest.mark.parametrize("depth", [F(1, 10), F(1, 10**9), F(1, 10**14), F(0)], ids=lambda x: f"{float(x):g}")
def test_a_box_that_slides_over_a_drum(depth):
    """The same turn told from the pose before it is the truth: by spans that do not pass 0."""
    drum = fc.cylinder("1/2", 1).translated((-2, 3, F(1, 2) + depth))
    box = fc.box((2, 1, 1)).translated((-4, "1/2", "3/2")).moving(TURN)
    (due,) = fc.contact_intervals(box, drum, (F(-1, 3), 0))
    for span in ((F(-1, 3), F(2, 3)), (F(-1, 4), F(1, 2)), (F(-1, 5), F(2, 3))):
        hit = fc.first_contact(box, drum, span)
        assert hit.status is fc.Status.CONTACT and hit.time == pytest.approx(due.start, abs=1e-12)
        assert [(x.start, x.end) for x in fc.contact_intervals(box, drum, span)] == [
            pytest.approx((due.start, due.end), abs=1e-12)
        ]


@pytest.mark.share(4)
@pytest.mark.parametrize("degrees", [(-90, 135), (-180, 360), (-135, 180), (-90, 90)])
@pytest.mark.parametrize("depth", [F(1, 10**9), F(1, 10**12)], ids=lambda x: f"{float(x):g}")
def test_drums_that_graze_at_zero_do_not_touch_at_the_start(degrees, depth):
    """Centres at 3 and 5 from the axis: 34 - 30 cos = (2 + depth)^2 where contact begins."""
    small = fc.cylinder(1, 1).translated((3, 0, "3/2")).moving(fc.Rotation((0, 0, 1), degrees=90))
    other = fc.cylinder(1 + depth, 2).translated((5, 0, 1))
    hit = fc.first_contact(small, other, tuple(F(x, 90) for x in degrees))
    angle = 2 * math.asin(math.sqrt(float(4 * depth + depth * depth) / 60))  # 60 sin^2 (x / 2) = 30 (1 - cos x)
    assert hit.status is fc.Status.CONTACT
    assert hit.time == pytest.approx(-math.degrees(angle) / 90, rel=1e-6)
