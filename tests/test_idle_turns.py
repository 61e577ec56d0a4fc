"""Models that turn about their own axis: what is decided is that of the shift that is left."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.contact.models.idle_turns import without_idle_turn

Z = (0, 0, 1)
PLATE = fc.box((6, 6, 2))
PIN = fc.cylinder(1, 2).translated((0, 0, 4))
CONE = fc.cone(2, 2).rotated((1, 0, 0), degrees=180)
SCREW = fc.cylinder(1, 3).translated((0, 0, 2)) | CONE.translated((0, 0, 5))
SEAT = fc.box((8, 8, 4)) - fc.cylinder("5/4", 8) - CONE.translated((0, 0, 2))


def test_a_pin_seats_flat_at_the_last_instant():
    hit = fc.first_contact(PIN.moving(fc.Screw(Z, degrees=77, advance=-2)), PLATE)
    assert hit.status is fc.Status.CONTACT and hit.time == 1 and hit.contact_set == "patch"
    assert hit.a.motion.advance == -2  # the answer names the bodies of the question


def test_a_pin_slides_into_a_bore_of_its_own_radius():
    turning = PIN.moving(fc.Screw(Z, degrees=360, advance=-6))
    bored = PLATE - fc.cylinder(1, 4)
    assert fc.first_contact(turning, bored, exact=True).time_exact == Fraction(1, 3)
    assert fc.first_contact(turning, PLATE - fc.cylinder("11/10", 4)).status is fc.Status.FREE
    (lasting,) = fc.contact_intervals(turning, bored)
    assert (lasting.start, lasting.end) == (1 / 3, 1)
    assert fc.first_contact(PIN.translated((0, 0, -4)).moving(fc.Rotation(Z, turns=3)), bored).initial == "touching"


def test_a_screw_seats_in_its_countersink_at_the_last_instant():
    turn = fc.Screw((0, 0, -2), point=(5, 0, 1), degrees=720, advance=3)
    hit = fc.first_contact(SCREW.translated((5, 0, 0)).moving(turn), SEAT.translated((5, 0, 0)))
    assert hit.status is fc.Status.CONTACT and hit.time == 1 and hit.contact_set == "patch"


@pytest.mark.parametrize("body, turn", [
    (fc.sphere(1), fc.Rotation((1, 2, 3), degrees=50)),
    (fc.sphere(1).translated((1, 0, 0)), fc.Rotation((1, 2, 3), (0, -2, -3), degrees=50)),
    (fc.cylinder(1, 2), fc.Screw((0, 0, -2), (0, 0, 5), degrees=50, advance="1/3")),
    (fc.hyperboloid((1, 1, 2), 2) & fc.paraboloid((2, 2), 3), fc.Rotation(Z, degrees=50)),
])  # fmt: skip
def test_what_is_round_only_shifts(body, turn):
    left = without_idle_turn(body.moving(turn)).motion
    assert isinstance(left, fc.Translation)
    shift = turn(1.0)[:3, 3] - turn(0.0)[:3, 3] if isinstance(turn, fc.Screw) else np.zeros(3)
    assert left(1.0)[:3, 3] == pytest.approx(shift)


@pytest.mark.parametrize("body, turn", [
    (fc.sphere(1).translated((1, 0, 0)), fc.Rotation(Z, degrees=50)),
    (fc.ellipsoid((1, 2, 1)), fc.Rotation(Z, degrees=50)),
    (fc.cylinder(1, 2), fc.Rotation((0, 1, 0), degrees=50)),
    (fc.cylinder(1, 2) & fc.half_space((1, 0, 0), 0), fc.Rotation(Z, degrees=50)),
    (fc.cylinder(1, 2), fc.Screw((0, 0, 1), (0, 1, 0), degrees=50, advance=1)),
])  # fmt: skip
def test_what_is_not_round_keeps_its_turn(body, turn):
    moving = body.moving(turn)
    assert without_idle_turn(moving) is moving
