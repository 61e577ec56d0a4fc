"""Lids: bodies that turn off what they lie on about hinges beside them, against heights by trigonometry."""

import math
import random

import numpy as np
import pytest

import firstcontact as fc
from firstcontact import Rotation, Screw, Sequence, Status, Translation
from firstcontact.assembly.lifts import _rises, _stays

FLOORS = {
    "mesh": fc.examples.box((60, 60, 1)).translated((0, 0, "-1/2")),
    "box": fc.box((60, 60, 1)).translated((0, 0, "-1/2")),
    "round": fc.cylinder(30, 1).translated((0, 0, "-1/2")),
}
LIDS = {
    "mesh": fc.examples.box((2, 2, 1)).translated((0, 0, "1/2")),
    "box": fc.box((2, 2, 1)).translated((0, 0, "1/2")),
    "disc": fc.cylinder(1, 1).translated((0, 0, "1/2")),
}


def asked_both_ways(a, b):
    """The new contact of a and b, which is that of b and a."""
    hit, turned = fc.first_new_contact(a, b), fc.first_new_contact(b, a)
    assert (hit.status, hit.time) == (turned.status, turned.time)
    return hit


TURNS = {
    "mesh": Rotation((0, -3, 0), (-3, 0, "-1/2"), degrees=60),
    "box": Rotation((0, 1, 0), (-3, 0, 0), degrees=-60),
    "disc": Screw((0, -1, 0), (-3, 0, "1/2"), degrees=60, advance=1),
}
"""Of lids, that all turn up."""


@pytest.mark.share(6)
@pytest.mark.parametrize("lid", LIDS)
@pytest.mark.parametrize("floor", FLOORS)
def test_a_lid_is_lifted(lid, floor):
    assert asked_both_ways(LIDS[lid].moving(TURNS[lid]), FLOORS[floor]).status is Status.FREE


@pytest.mark.share(3)
@pytest.mark.parametrize("lid", LIDS)
def test_a_floor_that_turns_up_meets_the_lid_at_once(lid):
    hit = fc.first_new_contact(FLOORS["box"].moving(TURNS["box"]), LIDS[lid])
    assert hit.status is Status.CONTACT and hit.time == 0
    assert fc.first_new_contact(FLOORS["box"].moving(TURNS["disc"]), LIDS[lid]).status is not Status.FREE


@pytest.mark.share(6)
@pytest.mark.parametrize("lid", LIDS)
@pytest.mark.parametrize("floor", FLOORS)
def test_a_lid_comes_down_on_the_other_side(lid, floor):
    """Its upper near corner, (2, 1) from the hinge, is down again after half a turn less atan(1/2)."""
    hit = asked_both_ways(LIDS[lid].moving(Rotation((0, -1, 0), (-3, 0, 0), degrees=170)), FLOORS[floor])
    assert hit.status is Status.CONTACT
    assert hit.time == pytest.approx((math.pi - math.atan2(1, 2)) / math.radians(170), abs=1e-12)


@pytest.mark.share(6)
@pytest.mark.parametrize("lid", LIDS)
@pytest.mark.parametrize("floor", FLOORS)
def test_a_lid_about_a_line_below_comes_back(lid, floor):
    """Its lower near corner, (2, 2) from the hinge, is as high again after a quarter turn."""
    hit = asked_both_ways(LIDS[lid].moving(Rotation((0, -1, 0), (-3, 0, -2), degrees=120)), FLOORS[floor])
    assert hit.status is Status.CONTACT and hit.time == pytest.approx(0.75, abs=1e-12)
    assert hit.time_interval[0] <= 0.75 <= hit.time_interval[1]


@pytest.mark.share(3)
@pytest.mark.parametrize("tall", [fc.cylinder(1, 4), fc.box((2, 2, 4)), fc.examples.box((2, 2, 4))])
def test_what_is_taller_than_its_hinge_is_far_falls_on_its_side(tall):
    """Its upper near corner, (2, 4) from the hinge, is down after more than a quarter turn."""
    moving = tall.translated((0, 0, 2)).moving(Rotation((0, -1, 0), (-3, 0, 0), degrees=140))
    hit = asked_both_ways(moving, FLOORS["box"])
    assert hit.status is Status.CONTACT
    assert hit.time == pytest.approx((math.pi - math.atan2(4, 2)) / math.radians(140), abs=1e-9)


@pytest.mark.share(4)
@pytest.mark.parametrize("lid", LIDS)
@pytest.mark.parametrize("degrees", [200, 330])
def test_a_lid_that_goes_most_of_a_round(lid, degrees):
    """About a line as high as its middle it lies on its back after half a turn."""
    hit = asked_both_ways(LIDS[lid].moving(Rotation((0, -1, 0), (-3, 0, "1/2"), degrees=degrees)), FLOORS["box"])
    assert hit.status is Status.CONTACT and hit.time == pytest.approx(180 / degrees, abs=1e-9)


@pytest.mark.share(6)
@pytest.mark.parametrize("lid", LIDS)
@pytest.mark.parametrize("hinge", [(-3, 1), ("1/2", 1), ("1/2", -1), (0, -1)])
def test_a_lid_that_is_pressed_in_meets_at_once(lid, hinge):
    x, sense = hinge
    hit = fc.first_new_contact(LIDS[lid].moving(Rotation((0, sense, 0), (x, 0, 0), degrees=60)), FLOORS["box"])
    assert hit.status is Status.CONTACT and hit.time == 0


@pytest.mark.share(3)
@pytest.mark.parametrize(("degrees", "back"), [(53, 60), (30, 40)])
def test_a_lid_is_lifted_and_laid_down_beside(degrees, back):
    """Before the end of its way back, which is longer."""
    up, down = (Rotation((0, -1, 0), (-3, 0, 0), degrees=x) for x in (degrees, -back))
    hit = fc.first_new_contact(LIDS["disc"].moving(Sequence([up, Translation((0, 1, 0)), down])), FLOORS["box"])
    assert hit.status is Status.CONTACT and hit.time == pytest.approx((2 + degrees / back) / 3, abs=1e-9)


@pytest.mark.share(2)
@pytest.mark.parametrize("solid", [False, True])
def test_a_bar_that_is_lifted_about_a_tilted_line_comes_down_at_its_end(solid):
    """Against the heights of its corners by Rodrigues' formula."""
    make, axis, hinge = (fc.box if solid else fc.examples.box), np.array([0, -3, 4]) / 5, np.array([-3, 0, 0])
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-10, 10) for z in (0, 1)], float) - hinge

    def lowest(share):
        angle = math.radians(60) * share
        turned = math.cos(angle) * corners + math.sin(angle) * np.cross(axis, corners)
        return (turned + (1 - math.cos(angle)) * np.outer(corners @ axis, axis))[:, 2].min()

    times = np.linspace(0, 1, 10_001)[1:]
    low = np.array([lowest(t) for t in times])
    first = times[np.argmax(low <= 0)]
    assert low[0] > 0 and low.min() < 0
    turn = Rotation((0, -3, 4), (-3, 0, 0), degrees=60)
    hit = fc.first_new_contact(make((2, 20, 1)).translated((0, 0, "1/2")).moving(turn), FLOORS["box"])
    assert hit.status is not Status.FREE and hit.free_until <= first
    assert hit.status is Status.UNDECIDED or first - 1e-4 <= hit.time <= first


@pytest.mark.share(3)
@pytest.mark.parametrize("lid", LIDS)
def test_a_floor_that_rises_sooner_than_the_lid_presses_it(lid):
    rising = FLOORS["box"].moving(Translation((0, 0, 5)))
    hit = fc.first_new_contact(LIDS[lid].moving(Rotation((0, -1, 0), (-3, 0, 0), degrees=60)), rising)
    assert hit.status is not Status.FREE and hit.free_until == 0


@pytest.mark.parametrize("kind", ["mesh", "box"])
def test_a_lid_that_stands_where_no_rational_numbers_tell(kind):
    """It was turned to the other side of the hinge before, and is pressed in."""
    aside, down = Rotation((0, 0, 1), degrees=170), Rotation((0, -1, 0), degrees=30)
    moving = LIDS[kind].translated((3, 0, 0)).moving(Sequence([aside, down]))
    hit = fc.first_new_contact(moving, FLOORS[kind], ("1/2", 1))
    assert hit.status is not Status.FREE and (hit.free_until or 0.5) == 0.5


def test_a_cap_is_less_than_its_ball():
    """It lies on a flat that reaches beyond the hinge, as its ball would not that touched there."""
    cap = fc.sphere(2).translated((0, 0, 1)) & fc.half_space((0, 0, -1), 0)
    hit = fc.first_new_contact(cap.moving(Rotation((0, -1, 0), (-1, 0, 0), degrees=60)), FLOORS["box"])
    assert hit.status is not Status.FREE and hit.free_until == 0


@pytest.mark.share(4)
@pytest.mark.parametrize("turn", [
    Rotation((0, 1, 0), (0, 0, 5), degrees=60), Rotation((0, -1, 0), (-3, 0, 0), degrees=60),
    Screw((0, -1, 0), (-3, 0, 0), degrees=60, advance=1), Screw((0, 1, 0), (0, 0, 5), degrees=60, advance=1),
])  # fmt: skip
def test_a_ball_swings_off_what_it_touches(turn):
    """First order, or second: a pendulum at its lowest point."""
    ball = fc.sphere(1).translated((0, 0, 1))
    for below in (FLOORS["box"], FLOORS["mesh"], fc.sphere(2).translated((0, 0, -2))):
        assert asked_both_ways(ball.moving(turn), below).status is Status.FREE


def test_a_ball_that_comes_back_to_a_ball_meets_it_anew():
    """The plane between them is kept, but none in which they slide."""
    ball, below = fc.sphere(1).translated((0, 0, 1)), fc.sphere(2).translated((0, 0, -2))
    hit = asked_both_ways(ball.moving(Sequence([Translation((3, 1, 0)), Translation((-3, -1, 0))])), below)
    assert hit.status is Status.CONTACT and hit.time == 1


def test_a_ball_that_swings_over_its_hinge_presses_in():
    """A pendulum at its highest point sinks on both sides."""
    hit = fc.first_new_contact(
        fc.sphere(1).translated((0, 0, 1)).moving(Rotation((0, 1, 0), (0, 0, -1), degrees=30)), FLOORS["box"]
    )
    assert hit.status is not Status.FREE and hit.free_until == 0


def test_a_cone_swings_about_a_line_above_its_tip():
    cone = fc.quadric([[4, 0, 0, 0], [0, 4, 0, 0], [0, 0, -1, 0], [0, 0, 0, 0]])
    cone = cone & fc.half_space((0, 0, 1), 2) & fc.half_space((0, 0, -1), 0)
    for below in (FLOORS["box"], fc.sphere(2).translated((0, 0, -2))):
        hit = asked_both_ways(cone.moving(Rotation((0, 1, 0), (0, 0, 5), degrees=60)), below)
        assert hit.status is Status.FREE


def when_down(outline, hinge, angle):
    """The share of a turn after which a corner of the outline is down on z = 0: infinite, or 0 if it sinks at once."""
    first = math.inf
    for x, z in outline:
        x, z = x - hinge[0], z - hinge[1]
        length, start = math.hypot(x, z), math.atan2(z, x)
        if z + hinge[1] == 0 and x <= 0:
            return 0.0
        if length < abs(hinge[1]):
            continue
        level = math.asin(-hinge[1] / length)  # z + hinge = 0 at the angles level and pi - level
        for at in (level, math.pi - level):
            theta = (at - start) % (2 * math.pi)
            if 1e-9 < theta < angle + 1e-9 and math.cos(at) < 0:
                first = min(first, theta / angle)
    return first


@pytest.mark.share(2)
@pytest.mark.parametrize("solid", [False, True])
def test_random_lids(solid):
    rng = random.Random(20260 + solid)
    print("seed", 20260 + solid)
    told = 0
    for _ in range(14):
        low = sorted(rng.sample(range(1, 9), 2))
        high = rng.randint(1, 4)
        outline = [(low[0], 0), (low[1], 0), (low[1] + rng.randint(-1, 2), high), (low[0], high)]
        if outline[2][0] <= low[0]:
            continue
        hinge = rng.randint(-3, 0), rng.choice([-3, -2, -1, 0, 1, 3])
        degrees = rng.choice([40, 90, 135, 170])
        expected = when_down(outline, hinge, math.radians(degrees))
        n = len(outline)
        lid = fc.Polyhedron(
            [(x, y, z) for y in (-1, 1) for x, z in outline],
            [[3, 2, 1, 0], [4, 5, 6, 7], *([i, (i + 1) % n, (i + 1) % n + n, i + n] for i in range(n))],
        )
        if solid:
            walls = [fc.half_space((0, 0, -1), 0), fc.half_space((0, 0, 1), high)]
            (x, z), (u, w) = outline[1:3]
            walls += [fc.half_space((-1, 0, 0), -low[0]), fc.half_space((w - z, 0, x - u), (w - z) * x + (x - u) * z)]
            lid = walls[0] & walls[1] & walls[2] & walls[3] & fc.half_space((0, 1, 0), 1) & fc.half_space((0, -1, 0), 1)
        floor = FLOORS["box" if solid else "mesh"]
        hit = fc.first_new_contact(lid.moving(Rotation((0, -1, 0), (hinge[0], 0, hinge[1]), degrees=degrees)), floor)
        where = outline, hinge, degrees
        if math.isinf(expected):
            assert hit.status is Status.FREE, where
        else:
            assert hit.status is Status.CONTACT and hit.time == pytest.approx(expected, abs=1e-9), where
        told += 1
    assert told > 8


@pytest.mark.parametrize("quadratic", [(0, 0, 0), (0, -1, 5), (0, 0, -1), (-1, 3, 0)])
def test_what_does_not_rise(quadratic):
    assert not _rises(quadratic)


@pytest.mark.parametrize(("quadratic", "end", "holds"), [
    ((1, -4, 4), 2, False),  # touches zero at 1/2
    ((1, -4, 5), 2, True), ((0, 1, -1), 1, False), ((0, 2, -1), 1, True), ((1, -4, 4), 0.25, True),
    ((3, -4, 1), 4, False),  # below between 1 and 3
])  # fmt: skip
def test_what_stays_positive(quadratic, end, holds):
    from flint import fmpq

    assert _stays(tuple(map(fmpq, quadratic)), fmpq(int(end * 4), 4)) is holds
