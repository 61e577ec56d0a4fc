"""Models round about an axis that they, or the other body, turn about: the shift that is left is decided."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.contact.models.idle_turns import without_common_turn, without_idle_turn

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


TURNS = {
    "rest": None,
    "shift": fc.Translation((0, 0, 5)),
    "turn": fc.Rotation(Z, degrees=40),
    "turns": fc.Rotation(Z, turns=-2),
    "screw": fc.Screw(Z, degrees=90, advance=3),
    "other way": fc.Screw(Z, (0, 0, 7), degrees=37, advance=-4),
}
DRILLED = fc.box((8, 8, 2)) - fc.cylinder(2, 4)


def bolt(radius):
    return fc.cylinder(radius, 40)


def under(body, motion):
    return body if TURNS[motion] is None else body.moving(TURNS[motion])


@pytest.mark.thorough
@pytest.mark.parametrize("of_bolt, of_plate", [
    ("rest", "screw"), ("shift", "turn"), ("shift", "screw"), ("turn", "turns"), ("turns", "other way"),
    ("screw", "rest"), ("screw", "turn"), ("screw", "screw"), ("screw", "other way"), ("other way", "shift"),
])  # fmt: skip
def test_a_bolt_in_its_bore_touches_at_the_start_and_a_thinner_one_never(of_bolt, of_plate):
    plate, fit, near = under(DRILLED, of_plate), under(bolt(2), of_bolt), under(bolt("1.999"), of_bolt)
    for hit in (fc.first_contact(fit, plate), fc.first_contact(plate, fit)):
        assert hit.status is fc.Status.INITIAL_CONTACT and hit.initial == "touching"
    assert fc.first_contact(near, plate).status is fc.Status.FREE
    assert fc.first_contact(plate, near).status is fc.Status.FREE


def test_what_is_seen_from_the_turning_body_is_told_where_it_happens():
    """A ball comes down the axis on another one that turns about it: 5/2 from it at the height 3/2."""
    ball = fc.sphere(2).translated((0, 0, 6)).moving(fc.Screw(Z, degrees=500, advance=-12))
    other = fc.sphere("1/2").translated((2, 0, 0)) | fc.box(("1/2", "1/2", "1/2")).translated((2, 0, 0))
    turning = other.moving(fc.Rotation(Z, degrees=240))
    hit = fc.first_contact(ball, turning)
    assert hit.time == pytest.approx(3 / 8, abs=1e-12)
    up = np.array([-0.8 * np.cos(np.pi / 2), -0.8 * np.sin(np.pi / 2), 0.6])
    assert hit.normal == pytest.approx(up, abs=1e-9)
    assert hit.point == pytest.approx([0, 2 * 0.8, 0.3], abs=1e-9)
    back = fc.first_contact(turning, ball)
    assert back.time == pytest.approx(3 / 8)
    assert back.point == pytest.approx(hit.point) and back.normal == pytest.approx(-up)
    listed = fc.first_contact(ball, turning, method="algebraic")
    places = [x.point for s in listed.subproblems for x in s.candidates if x.verdict == "contact"]
    assert any(np.allclose(place, hit.point, atol=1e-9) for place in places)
    assert fc.first_contact(ball, turning, exact=True).time_exact == Fraction(3, 8)


def test_a_patch_is_told_where_the_turning_body_is():
    """A headed bolt screws down on a bar whose square top turns by a right angle until then."""
    head = fc.cylinder(3, 2).translated((0, 0, 4)) | bolt("1/2")
    bar = fc.box((4, 1, 2)) - fc.cylinder("3/4", 4)
    hit = fc.first_contact(head.moving(fc.Screw(Z, degrees=-70, advance=-4)), bar.moving(fc.Rotation(Z, degrees=180)))
    assert hit.time == 0.5 and hit.contact_set == "patch"
    reach = np.abs(hit.contact_set.points).max(axis=0)
    assert reach == pytest.approx([0.5, 2, 1])


def test_a_polyhedral_plate_turns_about_the_bolt_in_it():
    """The walls of a square hole, 4 wide, come no nearer to the axis than 2."""
    frame = (fc.box((8, 8, 2)) - fc.box((4, 4, 4))).to_mesh(0.1)
    turn = fc.Screw(Z, degrees=140, advance=3)
    assert fc.first_contact(bolt(2).moving(fc.Screw(Z, degrees=90, advance=1)), frame.moving(turn)).status is (
        fc.Status.INITIAL_CONTACT
    )
    assert fc.first_contact(bolt("1.999"), frame.moving(turn)).status is fc.Status.FREE
    assert fc.contact_intervals(bolt("1.999"), frame.moving(turn)).status is fc.Status.FREE


@pytest.mark.parametrize("round_one, turn", [
    (bolt(1), fc.Rotation(Z, (1, 0, 0), degrees=50)),
    (bolt(1).moving(fc.Translation((1, 0, 1))), fc.Screw(Z, degrees=50, advance=1)),
    (fc.cylinder((1, 2), 3), fc.Screw(Z, degrees=50, advance=1)),
    (bolt(1).moving(fc.Rotation((1, 0, 0), degrees=50)), fc.Screw(Z, degrees=50, advance=1)),
])  # fmt: skip
def test_turns_beside_what_is_not_round_about_their_axis_stay(round_one, turn):
    turning = DRILLED.moving(turn)
    assert without_common_turn(round_one, turning, (0.0, 1.0)) == (round_one, turning, None)


def pin(x):
    return fc.cylinder("1/2", 4).translated((x, 0, 4))


def post(x, y):
    return fc.cylinder("1/4", 20).translated((x, y, 0))


@pytest.mark.share(2)
@pytest.mark.parametrize("plate", [DRILLED, DRILLED.translated((0, 0, 1)).moving(fc.Translation((0, 0, -1)))])
def test_a_plate_need_be_round_about_the_axis_no_farther_than_the_other_body_comes(plate):
    """A pin within the hole never touches it; one that reaches over it lands on the plate after a third of the way."""
    screw = fc.Screw(Z, degrees=77, advance=-3)
    down, _, turn = without_common_turn(pin("5/4").moving(screw), plate, (0.0, 1.0))
    assert isinstance(down.motion, fc.Translation) and turn is not None
    assert fc.first_contact(pin("5/4").moving(screw), plate).status is fc.Status.FREE
    assert fc.first_contact(plate, pin("5/4").moving(screw)).status is fc.Status.FREE
    lands = pin("7/4").moving(screw)
    for hit in (fc.first_contact(lands, DRILLED), fc.first_contact(DRILLED, lands)):
        assert hit.time == 1 / 3 and hit.point[2] == 1 and 2 <= np.hypot(*hit.point[:2]) <= 2.25 + 1e-9
        assert np.hypot(*(hit.point[:2] - screw(1 / 3)[:2, :2] @ [1.75, 0])) <= 0.5 + 1e-9
    assert fc.first_contact(lands, DRILLED, exact=True).time_exact == Fraction(1, 3)


@pytest.mark.share(3)
@pytest.mark.parametrize("about, time", [((3, 0), None), ((0, 3), 1 / 4), ((-3, 0), 1 / 2)])
def test_what_the_other_body_meets_by_its_turn_alone_keeps_the_turn(about, time):
    """A pin turns about the axis, 3 from it, towards a post: their axes are 3/4 apart when they touch."""
    turning, body = pin(3).moving(fc.Rotation(Z, degrees=360)), DRILLED | post(*about)
    left, _, turn = without_common_turn(turning, body, (0.0, 1.0))
    assert turn is None and left is turning
    hit = fc.first_contact(turning, body)
    if time is None:
        assert hit.status is fc.Status.INITIAL_CONTACT
    else:
        assert hit.time == pytest.approx(time - 2 * np.arcsin(0.75 / 6) / (2 * np.pi), abs=1e-12)


@pytest.mark.parametrize("swapped", [False, True])
def test_what_is_not_round_and_comes_along_is_seen(swapped):
    """A square collar far below a round shaft rises to a block, which turns from beside it to above its corner."""
    shaft = fc.cylinder(1, 30) | fc.box((4, 4, 1)).translated((0, 0, -10))
    block = fc.box(("1/4", "1/4", "1/2")).translated(("47/20", 0, 0)).moving(fc.Rotation(Z, degrees=45))
    rising = shaft.moving(fc.Translation((0, 0, 10)))
    hit = fc.first_contact(*((block, rising) if swapped else (rising, block)))
    lo, hi = hit.time_interval
    assert lo <= 0.925 <= hi and hi - lo < 1e-11  # the collar's top from -9.5 to the block's bottom at -0.25
    still = block.body.moving(fc.Rotation(Z, degrees=1))
    assert fc.first_contact(rising, still).status is fc.Status.FREE
