"""Motions of many turns: cut into a few turns each, which count as work; answers as of the motion cut by hand."""

from __future__ import annotations

import math

import pytest

import firstcontact as fc
from firstcontact.contact.polyhedra.problems.enclosed_problem import EnclosedProblem
from firstcontact.work import WORTH

BOX = fc.examples.box((1, 1, 1))
TURNED = BOX.rotated((1, 2, 3), degrees=25).translated((0, 0, -2))
OTHER = BOX.translated((0.9, 0.4, 1.5))
Status = fc.Status


def screw(turns, advance=3):
    return fc.Screw((0, 0, 1), point=(0.3, 0.2, 0), turns=turns, advance=advance)


@pytest.mark.parametrize("turns", [7, 100, 300])
def test_the_first_contact_is_that_of_the_turns_in_which_it_is(turns):
    hit = fc.first_contact(TURNED.moving(screw(turns)), OTHER)
    assert hit.status is Status.CONTACT
    near = 1 / turns
    assert fc.first_contact(TURNED.moving(screw(turns)), OTHER, (hit.time - near, hit.time + near)).time == hit.time
    assert fc.first_contact(TURNED.moving(screw(turns)), OTHER, (0, hit.time - 1e-9)).status is Status.FREE


def test_a_contact_goes_on_through_the_cuts():
    rod = fc.examples.box((0.2, 0.2, 2)).rotated((1, 2, 3), degrees=25)
    plate = fc.examples.box((3, 3, 1))
    told = fc.contact_intervals(rod.translated((0, 0, -4)).moving(fc.Screw((0, 0, 1), turns=7, advance=8)), plate)
    (one,) = told.intervals
    low, high = rod.vertices[:, 2].min(), rod.vertices[:, 2].max()
    assert (one.start, one.end) == (pytest.approx((3.5 - high) / 8), pytest.approx((4.5 - low) / 8))


@pytest.mark.share(4)
@pytest.mark.parametrize("budget", [50, 1000])
@pytest.mark.parametrize("turns", [10**5, "1e30"])
@pytest.mark.parametrize("kind", [fc.Rotation, fc.Screw])
def test_turns_count_as_work(kind, turns, budget):
    way = kind((0, 0, 1), turns=turns)
    told = fc.contact_intervals(BOX.moving(way), BOX.translated((1.05, 0, 0)), budget=budget)
    assert (told.status, told.reason) == (Status.UNDECIDED, "budget")
    assert len(told) <= budget and told.stats.node_visits + told.stats.pair_tests <= 1.2 * budget
    assert all(one.end <= told.free_until for one in told)
    if kind is fc.Rotation and budget > 500:
        assert len(told) > 500
        short = fc.contact_intervals(BOX.moving(fc.Rotation((0, 0, 1), turns=100)), BOX.translated((1.05, 0, 0)))
        share = float(turns) / 100
        assert told[150].start * share == pytest.approx(short[150].start, rel=1e-12)


def test_bodies_that_never_meet_or_never_part_need_no_turns():
    way = fc.Rotation((0, 0, 1), turns="1e30")
    assert fc.contact_intervals(BOX.moving(way), BOX.translated((5, 0, 0)), budget=1000).status is Status.FREE
    told = fc.contact_intervals(BOX.moving(way), BOX.translated((0.05, 0, 0)), budget=1000)
    assert [(one.start, one.end) for one in told] == [(0, 1)]
    way = screw("1e30", 1)
    assert fc.first_contact(BOX.moving(way), BOX.translated((3, 0, 0)), budget=10).status is Status.FREE


def test_the_first_contact_of_a_screw_counts_its_turns():
    far = BOX.translated((0.9, 0.4, 2.6))
    told = fc.first_contact(TURNED.moving(screw("1e30")), far, budget=1000)
    assert (told.status, told.reason) == (Status.UNDECIDED, "budget") and 0 < told.free_until < 1e-25
    with pytest.raises(fc.InputError, match="full turns"):
        fc.first_contact(TURNED.moving(screw("1e30")), far)


@pytest.mark.parametrize("budget", [10, 300])
def test_intervals_in_a_holed_solid_end_with_their_budget(budget):
    solid, ball = fc.box((8, 8, 2)) - fc.cylinder(2, 4), fc.examples.noisy_sphere(1280).translated((0, 0, 5))
    told = fc.contact_intervals(ball.moving(fc.Translation((1, 0.5, -10))), solid, budget=budget)
    assert (told.status, told.reason, told.free_until) == (Status.UNDECIDED, "budget", 0.0)


@pytest.mark.parametrize("verb", [fc.first_contact, fc.contact_intervals])
def test_looks_at_pairs_in_balls_count_as_the_work_that_they_are(verb, monkeypatch):
    """One look takes as long as many visits: a budget ends them within a pair, which may take a tenth of a second."""
    looked = []
    for name in ("_look", "_root_within"):
        look = getattr(EnclosedProblem, name)
        monkeypatch.setattr(EnclosedProblem, name, lambda *args, look=look: looked.append(1) or look(*args))
    pair = TURNED.moving(screw(3)), OTHER
    told = verb(*pair)
    visits, whole = told.stats.node_visits + told.stats.pair_tests, len(looked)
    assert told.status is Status.CONTACT and whole > 0
    for share in (0, whole // 2):
        looked.clear()
        few = verb(*pair, budget=visits + WORTH * share)
        assert (few.status, few.reason) == (Status.UNDECIDED, "budget")
        assert WORTH * len(looked) <= visits + WORTH * share and 0.0 <= few.free_until <= told.free_until


def test_a_contact_in_the_last_turns():
    """After whole stretches of a few turns each: the corner of the box lands on the plate at a time in closed form."""
    low = min(p[2] for p in TURNED.vertices)
    plate = fc.examples.box((9, 9, 1)).translated((0, 0, low - 3.5))
    hit = fc.first_contact(TURNED.moving(screw(10, advance=-3.0625)), plate)
    assert hit.status is Status.CONTACT and hit.time == pytest.approx(3 / 3.0625, rel=1e-12)
    (only,) = fc.contact_intervals(TURNED.moving(screw(10, advance=-3.0625)), plate)
    assert only.start == pytest.approx(3 / 3.0625, rel=1e-12) and only.end == 1.0


BALL = fc.sphere(1).translated((3, 0, 2))
ARM = fc.box((6, 1, 1)).translated((0, 0, 2))


@pytest.mark.parametrize("turns", [400, 1000])
def test_a_curved_body_beside_one_that_makes_many_turns(turns):
    """In a rotation the first turn tells all; a screw is looked at some hundred turns at a time."""
    there = ARM.rotated((0, 0, 1), degrees=90)
    once = fc.first_contact(there.moving(fc.Rotation((0, 0, 1), turns=1)), BALL)
    many = fc.first_contact(there.moving(fc.Rotation((0, 0, 1), turns=turns)), BALL)
    assert once.status is many.status is Status.CONTACT and many.span == (0.0, 1.0)
    assert many.time == pytest.approx(once.time / turns, rel=1e-9)
    free = fc.first_contact(there.moving(fc.Rotation((0, 0, 1), turns=turns)), BALL.translated((2, 0, 0)))
    assert free.status is Status.FREE and free.free_until == 1.0
    disc = fc.cylinder(4, 1).translated((0, 0, "-1/2"))  # its top, at 0, rises to the ball's lowest point at 1
    screw = fc.Screw((0, 0, 1), turns=turns, advance=2)
    for verb in (fc.first_contact, fc.contact_intervals):
        found = verb(disc.moving(screw), BALL)
        begin = found.time if verb is fc.first_contact else found[0].start
        assert found.status is Status.CONTACT and begin == pytest.approx(0.5, abs=1e-9)
    rising = BOX.translated((2, 0, 0)).moving(screw)  # its lid is at 1/2 + 2 t, its corners at 6.5^1/2 from the axis
    hit, near = fc.first_contact(rising, BALL), 1.5 / turns
    due = (1.5 - (1 - (3 - 6.5**0.5) ** 2) ** 0.5) / 2  # the ball is that near to the axis then
    assert hit.status is Status.CONTACT and due <= hit.time <= due + near
    assert fc.first_contact(rising, BALL, (hit.time - near, 1)).time == pytest.approx(hit.time, abs=1e-12)
    assert fc.first_contact(rising, BALL, (0, hit.time - 1e-9)).status is Status.FREE


def test_a_surface_that_rises_while_it_turns_does_not_come_round():
    """It is under the ceiling after half of three turns, not in the first one."""
    rising, ceiling = fc.RuledSurface("(1,u,2*T)", "(2,u,2*T)"), fc.box((10, 10, 1)).translated((0, 0, "3/2"))
    hit = fc.first_contact(rising.moving(fc.Rotation((0, 0, 1), turns=3)), ceiling)
    assert hit.status is Status.CONTACT and hit.time == 0.5


def test_bodies_that_turn_often_together_and_less_than_once_about_each_other():
    """In the frame of the tube the point makes three quarters of a turn.  From a soak: it raised a ValueError."""
    axis = {"axis": (0, 0, 1), "turns": -1.5}
    point = fc.Polyhedron([(3, 0, 0)], [])
    tube = fc.cylinder(1, 4).translated((0, 3, 0))
    (told,) = fc.contact_intervals(point.moving(fc.Rotation(**axis)), tube.moving(fc.Rotation((0, 0, 1), turns=-0.75)))
    half = math.asin(1 / 6) / math.pi  # of the turn, as the chord from the point to the tube's axis is 1
    assert (told.start, told.end) == pytest.approx([(0.75 - half) / 0.75, 1.0])
