"""Bodies that jump: what they share right after a jump is a contact at that time."""

from __future__ import annotations

from fractions import Fraction as F

import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact import Status
from firstcontact.contact import jumps
from firstcontact.result import FirstContact, Stats
from firstcontact.work import Query

NOTHING = [[0] * 4] * 4


def jump(x=0, y=0, z=0, ahead=(0, 0, 0)):
    """By (x, y, z), and then on by `ahead` within the step."""
    pose = [[1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z], [0, 0, 0, 1]]
    return fc.RationalMotion([pose, [[0, 0, 0, c] for c in ahead] + [[0] * 4]])


INTO = fc.Sequence([fc.Translation((0, 0, "1/8")), jump(-100, ahead=("1/10", 0, 0))])
TUBE = (fc.cylinder(10, 20) - fc.cylinder(3, 30)).translated(("13/2", 0, 0))
CORNERS = [(x, y, z) for z in (-9, 9) for x, y in ((-9, -9), (19, -9), (19, 9), (9, 9), (9, 19), (-9, 19))]
ANGLE = fc.Polyhedron(
    CORNERS, [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *([i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6] for i in range(6))]
)
FAR = {
    "ruled": fc.RuledSurface("(u/2,0,0)", "(u/2,1/2,u/2)").translated((100, 0, 0)),
    "point": fc.Polyhedron([(100, 0, 0)], []),
    "edge": fc.Polyhedron([(100, 0, 0), (100.5, 0, 0)], [], edges=[[0, 1]]),
    "ball": fc.sphere("1/2").translated((100, 0, 0)),
    "shell": (fc.sphere("1/2") - fc.sphere("1/4")).translated((100, 0, 0)),
    "mesh": fc.examples.box((1, 1, 1)).translated((100, 0, 0)),
    "ring": fc.torus("1/2", "1/4").translated((100, 0, 0)),
}
"""All within 1 of (100, 0, 0): after the jump within 2 of the origin."""
AROUND = {"box": fc.examples.box((20, 20, 20)), "angle": ANGLE, "ball": fc.sphere(9), "tube": TUBE}
"""All hold the ball of radius 3 about the origin."""


@pytest.mark.share(10)
@pytest.mark.parametrize("around", AROUND)
@pytest.mark.parametrize("inner", FAR)
def test_a_body_jumps_into_another(inner, around):
    a, b = FAR[inner].moving(INTO), AROUND[around]
    for pair in ((a, b), (b, a)):
        hit = fc.first_contact(*pair)
        assert (hit.status, hit.time, hit.initial) == (Status.CONTACT, 0.5, None)
        assert hit.time_interval == (0.5, 0.5)
        found = fc.contact_intervals(*pair)
        assert [(x.start, x.end) for x in found] == [(0.5, 1)]


SHEET = fc.Polyhedron([(-90, -90, 0), (90, -90, 0), (0, 90, 0)], [[0, 1, 2]])
PLATE = fc.box((60, 60, 5)).translated((0, 0, "-5/2")) - fc.cylinder(1, 50).translated((20, 20, 0))
ABOVE = {
    "ball": (fc.sphere(1).translated((0, 0, 2)), SHEET),
    "tube": ((fc.cylinder(2, 1) - fc.cylinder(1, 3)).translated((0, 0, "3/2")), SHEET),
    "point": (fc.Polyhedron([(0, 0, 1)], []), PLATE),
    "triangle": (fc.Polyhedron([(0, 0, 1), (1, 0, 2), (0, 1, 2)], [[0, 1, 2]]), PLATE),
}
"""Of height 1 above the sheet, or the top of the plate, in z = 0."""


@pytest.mark.share(2)
@pytest.mark.parametrize("depth", [F(1, 10**16), F(1, 10**6), F(1, 100)], ids=str)
@pytest.mark.parametrize("name", ABOVE)
def test_a_shallow_jump(name, depth):
    a, b = ABOVE[name]
    sinks = fc.Sequence([fc.Translation((0, 1, 0)), jump(z=-1 - depth, ahead=(0, 0, "-1/5"))])
    hit = fc.first_contact(a.moving(sinks), b)
    assert hit.status is Status.CONTACT
    assert hit.time_interval[0] <= 0.5 <= hit.time_interval[1]


def test_exact_times_of_jumps_and_what_follows():
    """A ball jumps into a box at 1/3 and out of it at 2/3."""
    motion = fc.Sequence([fc.Translation((0, 0, 1)), jump(-100), jump(200)])
    ball, box = fc.sphere(1).translated((100, 0, 0)).moving(motion), fc.box((8, 8, 8))
    assert fc.first_contact(ball, box, exact=True).time_exact == F(1, 3)
    (window,) = fc.contact_intervals(ball, box, exact=True)
    assert (window.start_exact, window.end_exact) == (F(1, 3), F(2, 3))
    assert fc.first_contact(ball, box, (0, 0.3)).status is Status.FREE
    assert fc.first_contact(ball, box, (F(1, 3), F(1, 2))).status is Status.INITIAL_CONTACT
    assert fc.first_contact(ball, box, (0.7, 1)).status is Status.FREE


def test_a_landing_before_a_jump_away():
    """It touches at 1/2, where it jumps away: told of the pose before."""
    lands = fc.Sequence([fc.Translation((0, 0, -1)), jump(0, 0, 100)])
    hit = fc.first_contact(fc.box((1, 1, 1)).translated((0, 0, "5/2")).moving(lands), fc.box((2, 2, 2)))
    assert (hit.status, hit.time) == (Status.CONTACT, 0.5)


TURNS = {
    "between": fc.RationalMotion.between((0, 0, 0), (0, 0, -1), quat_wxyz=((1, 0, 0, 0), (2, 0, 0, 1))),
    "screw": fc.Screw((0, 0, 1), (1, 1, 0), turns="1/4", advance=-1),
}
TABLE = fc.box((60, 60, 5)).translated((0, 0, "-5/2"))


@pytest.mark.share(3)
@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("table", [TABLE, PLATE], ids=["table", "plate"])
def test_a_turn_that_lands_before_a_jump_away(turn, table):
    """What is looked at in the last instant before the jump is the pose before it."""
    tube = (fc.cylinder(2, 1) - fc.cylinder(1, 3)).translated((0, 0, "3/2"))
    lands = tube.moving(fc.Sequence([TURNS[turn], jump(0, 0, 100)]))
    hit = fc.first_contact(lands, table)
    assert (hit.status, hit.time) == (Status.CONTACT, 0.5)
    assert [(x.start, x.end) for x in fc.contact_intervals(lands, table)] == [(0.5, 0.5)]


def test_stretches_share_the_budget_and_the_tolerance():
    asked = []

    def answer(query):
        asked.append((query.span, query.budget, query.tolerance))
        return FirstContact.free(Stats(3, 4), **query.shared)

    motion = fc.Sequence([fc.Translation((0, 0, 1)), jump(-100), jump(200)], durations=["1/2", "1/4", "1/4"])
    ball = fc.sphere(1).moving(motion)
    query = Query(ball, fc.box((1, 1, 1)), fmpq(0), fmpq(1), tolerance=1e-9, budget=10)
    found = jumps.first(answer, query)
    assert asked == [((0, 0.5), 10, 2e-9), ((0.5, 0.75), 3, 4e-9), ((0.75, 1), 0, 4e-9)]
    assert (found.status, found.stats.node_visits, found.span) == (Status.FREE, 9, (0, 1))


def test_jumps_of_both_bodies_and_budgets():
    """The block jumps beside the ball at 1/3; both jump to one place at 1/2."""
    block = fc.box((1, 1, 1)).translated((100, 0, 0))
    a = block.moving(fc.Sequence([fc.Translation((0, 0, 0)), jump(-60), jump(-20)], durations=["1/3", "1/6", "1/2"]))
    b = fc.sphere(1).moving(fc.Sequence([fc.Translation((0, 0, 0)), jump(20)]))
    hit = fc.first_contact(a, b)
    assert (hit.status, hit.time) == (Status.CONTACT, 0.5)
    few = fc.first_contact(a, b, budget=1)
    assert few.status in (Status.UNDECIDED, Status.CONTACT)
    assert few.free_until <= 0.5


def test_the_pose_at_a_jump_is_that_after_it():
    assert INTO(0.5)[0, 3] == -100
    assert INTO(0.49999)[0, 3] == 0
    assert INTO.jumps == (fmpq(1, 2),)
    assert fc.Sequence([fc.Translation((1, 0, 0)), jump()]).jumps == ()


THIN = fc.Polyhedron([(-1, -1, 0), (1, -1, 0), (0, 1, 0)], [[0, 1, 2]])
AWAY = {
    "mesh": fc.examples.box((2, 2, 2)), "sheet": THIN, "point": fc.Polyhedron([(0, 0, 0)], []),
    "box": fc.box((2, 2, 2)), "ball": fc.sphere(1), "ring": fc.torus(2, 1).translated((2, 0, 0)),
    "ruled": fc.RuledSurface("(u,-1,0)", "(u,1,0)"),
}  # fmt: skip


@pytest.mark.share(3)
@pytest.mark.parametrize("name", AWAY)
@pytest.mark.parametrize("other", ["mesh", "point", "ball", "ring"])
def test_times_between_two_jumps_are_free(name, other):
    """Of meshes a contact that ends with one step and one that begins with the next but one were told as one."""
    if (name, other) == ("ruled", "point"):
        pytest.skip("not taken")
    away = fc.Sequence([jump(), jump(9), jump(-9)])
    for a, b in ((AWAY[name].moving(away), AWAY[other]), (AWAY[other], AWAY[name].moving(away))):
        found = fc.contact_intervals(a, b)
        assert [(x.start, x.end) for x in found] == [(0, 1 / 3), (2 / 3, 1)] and found.status is Status.INITIAL_CONTACT
        assert fc.first_contact(a, b, (0.4, 0.6)).status is Status.FREE


def test_an_interval_that_ends_with_its_step_and_one_after_a_free_step():
    slides = fc.Sequence([jump(-9, ahead=(8, 0, 0)), jump(9), jump(-8), jump(1)])
    found = fc.contact_intervals(AWAY["mesh"].moving(slides), AWAY["mesh"], exact=True)
    assert [(x.start_exact, x.end_exact) for x in found] == [(F(7, 32), F(1, 4)), (F(1, 2), 1)]


KINDS = {
    "mesh": fc.examples.box((2, 2, 2)), "ball": fc.sphere(1), "torus": fc.torus(1, "1/2"),
    "ruled": fc.RuledSurface("(u, 0, 0)", "(u, 1, 1)"),
}  # fmt: skip
"""All come near (1/2, 1/2, 1/2), and lie within 2 of the origin."""
WALLS = {**KINDS, "ruled": fc.RuledSurface("(u, 0, 1)", "(u, 1, 0)")}
STRAIGHT_OR_TURNING = {"straight": fc.Translation((2, 0, 0)), "turning": fc.Screw((1, 0, 0), degrees=37, advance=2)}


@pytest.mark.share(4)
@pytest.mark.parametrize("before", STRAIGHT_OR_TURNING)
@pytest.mark.parametrize("wall", WALLS)
@pytest.mark.parametrize("name", KINDS)
def test_spans_that_end_or_begin_at_a_jump_or_are_its_instant(name, wall, before):
    """A body jumps from 2 to 12 at the time 1, and goes on to 13: spans are closed, and at 1 it stands at 12."""
    path = fc.Sequence([STRAIGHT_OR_TURNING[before], jump(10, ahead=(1, 0, 0))], durations=[1, 1])
    a, b = KINDS[name].moving(path), WALLS[wall]
    if before == "turning":
        b = b.rotated((1, 0, 0), degrees=37)  # as the body is then
    b = b.translated((12, 0, 0))
    for pair in ((a, b), (b, a)):
        assert fc.first_contact(*pair, (0, 0.5)).status is Status.FREE
        for span in ((0, 1), (0, 2)):
            hit = fc.first_contact(*pair, span)
            assert (hit.status, hit.time, hit.initial) == (Status.CONTACT, 1.0, None)
        for span in ((1, 1), (1, 2)):
            assert fc.first_contact(*pair, span).status is Status.INITIAL_CONTACT
        (at,) = fc.contact_intervals(*pair, (1, 1))
        (end,) = fc.contact_intervals(*pair, (0, 1))
        assert (at.start, at.end, end.start, end.end) == (1, 1, 1, 1)
        assert fc.contact_intervals(*pair, (0, 2))[0].start == 1


def test_what_is_left_by_a_jump_is_not_there_after_it():
    lands = fc.Sequence([fc.Translation((2, 0, 0)), jump(10)], durations=[1, 1])
    for name, body in KINDS.items():
        a, b = body.moving(lands), body.translated((2, 0, 0))
        assert fc.first_contact(a, b, (1, 1)).status is Status.FREE, name
        assert fc.first_contact(a, b, (1, 2)).status is Status.FREE, name
        assert fc.contact_intervals(a, b, (1, 1)).status is Status.FREE, name


def test_meshes_that_jump_at_the_end_of_the_span_after_a_screw():
    """The last instant is one of a pose that is not rational."""
    path = fc.Sequence([STRAIGHT_OR_TURNING["turning"], jump(10, ahead=(1, 0, 0))], durations=[1, 1])
    a, b = KINDS["mesh"].moving(path), KINDS["mesh"].translated((12, 0, 0))
    for pair in ((a, b), (b, a)):
        assert fc.first_contact(*pair, (0, 1)).time == 1
        assert [(x.start, x.end) for x in fc.contact_intervals(*pair, (0, 1))] == [(1, 1)]
        assert fc.contact_intervals(*pair, (0, "9/10")).status is Status.FREE
