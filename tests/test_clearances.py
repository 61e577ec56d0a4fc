"""Balls and pins in and over bores that they nearly fill, of all sizes."""

from __future__ import annotations

from fractions import Fraction as F
from random import Random

import numpy as np
import pytest

import firstcontact as fc

METHODS = {"method": "auto"}, {"exact": True}, {"method": "algebraic"}


def tube(s):
    return fc.box((64 * s, 64 * s, 24 * s)) - fc.cylinder(8 * s, 60 * s)


@pytest.mark.share(3)
@pytest.mark.parametrize("clearance", ["1e-8", "1e-9", "1e-11"])
def test_a_ball_begins_free_in_the_middle_of_a_bore(clearance):
    e = F(clearance)
    ball = fc.sphere(8 - 8 * e).translated((0, 0, F(39, 8))).moving(fc.Translation((16 * e, 0, 0)))
    hit = fc.first_contact(ball, tube(1))
    assert hit.status is fc.Status.CONTACT and hit.time == 0.5
    assert hit.point == pytest.approx([8, 0, 4.875]) and hit.normal == pytest.approx([-1, 0, 0])


@pytest.mark.share(6)
@pytest.mark.parametrize("power", [-40, -30, 0, 20, 36])
@pytest.mark.parametrize("along", [0, 3])
def test_a_ball_in_a_bore_of_any_size(power, along):
    s, e = F(2) ** power, F(1, 1000)
    ball = fc.sphere(8 * s * (1 - e)).translated((0, 0, 3 * s)).moving(fc.Translation((16 * s * e, 0, along * s)))
    assert fc.first_contact(ball, tube(s), exact=True).time_exact == F(1, 2)
    assert fc.first_contact(ball, tube(s)).time == 0.5


@pytest.mark.share(12)
@pytest.mark.parametrize("seed", range(10))
def test_balls_that_cross_bores(seed):
    """From a place within the bore to its wall: where the way is the clearance, times a known share of it."""
    rng = Random(seed)
    c, n = rng.choice(((F(1), F(0)), (F(3, 5), F(4, 5)), (F(-5, 13), F(12, 13))))
    s = F(2) ** rng.choice((-30, -9, 0, 14, 36))
    gap, when = 8 * s * F(1, rng.choice((3, 1000, 10**6, 10**9))), F(rng.randint(1, 7), 8)
    ball = fc.sphere(8 * s - gap).translated((0, 0, s))
    moving = ball.moving(fc.Translation((gap * c / when, gap * n / when, rng.choice((0, 1)) * s)))
    hit = fc.first_contact(moving, tube(s))
    assert hit.time == pytest.approx(float(when), rel=1e-9)
    assert hit.normal == pytest.approx(-np.array([c, n, 0], float), abs=1e-6)


@pytest.mark.share(6)
@pytest.mark.parametrize("how", METHODS, ids=str)
@pytest.mark.parametrize("power", [-30, 24, 28, 36])
def test_a_pin_a_little_wider_than_the_bore(power, how):
    s, e = F(2) ** power, F(1, 10**9)
    plate = fc.box((64 * s, 64 * s, 8 * s)) - fc.cylinder(8 * s, 16 * s)
    pin = fc.cylinder(8 * s * (1 + e), 32 * s).translated((0, 0, 30 * s)).moving(fc.Translation((0, 0, -64 * s)))
    hit = fc.first_contact(pin, plate, **how)
    assert hit.status is fc.Status.CONTACT and hit.time == pytest.approx(10 / 64, rel=1e-11)
