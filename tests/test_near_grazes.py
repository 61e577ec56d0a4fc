"""Bodies that pass in mid-span and touch at one instant, or miss or hit by less than doubles tell, in any motion."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest
from flint import arb, fmpq

import firstcontact as fc
from firstcontact.exact.numbers import exact_value, precision
from firstcontact.exact.rigid import IDENTITY
from firstcontact.motion.relative.pieces import curved_pieces
from firstcontact.search.convex.close_up import CloseUp
from firstcontact.search.convex.convex import convex_pieces
from firstcontact.search.convex.relation import Relation
from firstcontact.search.convex.resting import relation
from firstcontact.search.convex.separation import STATIC

Z = (0, 0, 1)
BALL = fc.sphere(1).named("ball")
SCREW = fc.Screw(Z, degrees=180, advance=4)
HALF = fc.Rotation(Z, degrees=180)
TINY = F(1, 10**12)

# Pairs that are `gap` apart, or deep, at 1/2, when they are nearest.
PASSING = {
    "balls": lambda gap: (BALL.translated((3, 0, 0)).moving(SCREW), BALL.translated((0, 5 + gap, 2))),
    "ellipsoids": lambda gap: (
        fc.ellipsoid((1, 2, 1)).translated((3, 0, 0)).moving(SCREW),
        fc.ellipsoid((2, 1, 1)).translated((0, 5 + gap, 2)),
    ),
    "cylinder": lambda gap: (
        fc.cylinder(1, 2).translated((3, 0, 0)).moving(SCREW), BALL.translated((0, 5 + gap, 2)),
    ),
    "cone's rim": lambda gap: (fc.cone(1, 2).translated((3, 0, 0)).moving(SCREW), BALL.translated((0, 5 + gap, 2))),
    "beside a shift": lambda gap: (
        BALL.translated((3, 0, 0)).moving(HALF), BALL.translated((0, 5 + gap, -2)).moving(fc.Translation((0, 0, 4))),
    ),
    "two screws": lambda gap: (
        BALL.translated((3, 0, 0)).moving(SCREW),
        BALL.translated((3, 8 + gap, 0)).moving(fc.Screw(Z, (0, 8 + gap, 0), degrees=-180, advance=4)),
    ),
    "gears": lambda gap: (
        fc.ellipsoid((2, 1, 1)).moving(HALF),
        fc.ellipsoid((1, 2, 1)).translated((0, 4 + gap, 0)).moving(fc.Rotation(Z, (0, 4 + gap, 0), turns=-1)),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", PASSING)
def test_a_graze_a_miss_and_a_hit(name):
    touch, miss, hit = (fc.first_contact(*PASSING[name](gap)) for gap in (0, TINY, -TINY))
    assert touch.status is fc.Status.CONTACT and touch.time == 0.5
    assert 0.5 - 1e-15 < touch.time_interval[0] <= 0.5 <= touch.time_interval[1] < 0.5 + 1e-15
    assert miss.status is fc.Status.FREE and miss.free_until == 1
    assert hit.status is fc.Status.CONTACT and 0.5 - 1e-6 < hit.time < 0.5
    assert hit.time_interval[1] - hit.time_interval[0] <= 1e-12
    assert {hit.element_a.kind, touch.element_a.kind} == {"edge" if name == "cone's rim" else "face"}


LONG = {"ellipsoid": fc.ellipsoid((1, 2, 1)), "cylinder": fc.cylinder((1, 2), 2)}


@pytest.mark.parametrize("name", LONG)
@pytest.mark.parametrize("degrees", [90, 180])
@pytest.mark.parametrize("scale", [F(1), F(1, 3), F(10**6)])
def test_what_is_longest_across_grazes_a_wall_after_a_quarter_turn(name, degrees, scale):
    """In both orders: next to a graze so gentle the bodies counted as touching all along, and nothing was proved."""
    body = LONG[name].transformed([[scale, 0, 0, 0], [0, scale, 0, 0], [0, 0, scale, 0], [0, 0, 0, 1]])
    moving = body.moving(fc.Screw(Z, degrees=degrees, advance=scale))
    wall = fc.box((scale, 8 * scale, 8 * scale)).translated((F(5, 2) * scale, 0, 0))
    for hit in (fc.first_contact(moving, wall), fc.first_contact(wall, moving)):
        assert hit.status is fc.Status.CONTACT and hit.time == 90 / degrees


@pytest.mark.share(4)
@pytest.mark.parametrize("gap", [F(1, 10**9), F(1, 10**12), F(1, 10**15), F(1, 10**40)])
def test_times_against_the_distance_of_balls(gap):
    """4 is the square of the distance from (0, 5 - gap, 2) to (3 cos, 3 sin, 4 t) when they touch."""
    a, b = PASSING["balls"](-gap)
    hit, (interval,) = fc.first_contact(a, b), fc.contact_intervals(a, b)
    for lo, hi in (hit.time_interval, interval.start_interval, [1 - t for t in interval.end_interval[::-1]]):
        assert apart(lo, gap) and not apart(hi, gap) and hi - lo <= 1e-12
    assert np.allclose(hit.normal, (0, -1, 0), atol=1e-4) and np.allclose(hit.point, (0, 4, 2), atol=1e-3)


def apart(t: float, gap: F) -> bool:
    with precision(400):
        time, y = arb(exact_value(t)), 5 - arb(fmpq(gap.numerator, gap.denominator))
        square = 9 + y * y - 6 * y * (time * arb.pi()).sin() + (4 * time - 2) ** 2
        assert square > 4 or square < 4
        return bool(square > 4)


def test_an_interval_of_one_instant():
    (touch,) = fc.contact_intervals(*PASSING["balls"](0))
    assert (touch.start, touch.end) == (0.5, 0.5) and touch.end_interval[1] - touch.start_interval[0] < 1e-15
    assert fc.contact_intervals(*PASSING["cylinder"](TINY)).status is fc.Status.FREE


def test_a_sliver_of_contact_under_a_rotation():
    """The bodies share a lens 1e-15 thick, across the time at which the motion is cut."""
    a = BALL.translated((3, 0, 0)).moving(fc.Rotation(Z, degrees=200))
    (interval,) = fc.contact_intervals(a, fc.ellipsoid((2, 1, 1)).translated((0, 5 - F(1, 10**15), 0)))
    assert interval.start < 0.45 - 1e-9 and interval.end > 0.45 + 1e-9
    for x, lie in ((F(1, 10**40), Relation.OVERLAPPING), (0, Relation.NEAR), (-F(1, 10**40), Relation.APART)):
        assert relation(BALL, BALL.translated((2 - x, 0, 0)), IDENTITY) is lie


def test_gears_touch_at_an_angle_with_rational_cosine():
    """A ball on one arm at (3, 4) / 5 of the way meets one on another arm that turns twice as fast."""
    angle = F(1, 2)
    a = BALL.translated((5, 0, 0)).moving(fc.Rotation(Z, turns=angle))
    meets = np.array([F(3), F(4)])  # where the first ball is then; the other one is beside it, outward from its axis
    axis = meets + np.array([F(3), F(4)])  # its arm points back along (3, 4): 3 long, its tip 2 away
    arm = -np.array([F(3), F(4)]) * F(3, 5)
    cosine, sine = F(-7, 25), F(24, 25)  # of twice the angle; the arm turned back by it
    start = np.array([cosine * arm[0] + sine * arm[1], -sine * arm[0] + cosine * arm[1]])
    b = BALL.translated((*(axis + start), 0)).moving(fc.Rotation(Z, (*axis, 0), turns=2 * angle))
    hit = fc.first_contact(a, b, exact=True)
    theta = 2 * np.pi * float(angle) * hit.time
    assert hit.status is fc.Status.CONTACT and (np.cos(theta), np.sin(theta)) == pytest.approx((0.6, 0.8), abs=1e-12)


def test_a_bound_holds_at_sampled_times():
    """The separation solved for at other times lies above the bound proved around one."""
    a, b = PASSING["ellipsoids"](TINY)
    (motion,) = curved_pieces(a, b, fmpq(0), fmpq(1))
    system = CloseUp(motion, convex_pieces(a.body), 0, convex_pieces(b), 0).separation
    state = system.solve(system.guess(fmpq(1, 2)), STATIC)
    bound = system.apart(state, system.paths(state), fmpq(1, 1000))
    assert bound.is_positive(fmpq(499, 1000), fmpq(501, 1000))
    for k in range(-4, 5):
        r = fmpq(k, 4000)
        there = system.solve(system.guess(state.time + r), STATIC)
        with precision(256):
            low = bound.c0 + bound.c1[k > 0] * abs(r) + bound.c2 * r * r
            assert not arb(there.s) < low and there.s >= state.s


def test_nothing_is_proved_that_does_not_hold():
    """A ball that passes another one from 1/6 to 5/6: no proof of contact, or of none, over times that hold both."""
    a = BALL.translated((-3, 0, 0)).moving(fc.Translation((6, 0, 0)))
    (motion,) = curved_pieces(a, BALL, fmpq(0), fmpq(1))
    close = CloseUp(motion, convex_pieces(a.body), 0, convex_pieces(BALL), 0)
    system = close.separation
    before, after = (system.solve(system.guess(t), STATIC) for t in (fmpq(1, 10), fmpq(3, 10)))
    for lo, hi, contact, state, holds in (
        ("1/20", "3/20", False, before, True),
        ("1/20", "1/5", False, before, False),
        ("1/20", "3/20", True, before, False),
        ("7/25", "8/25", True, after, True),
        ("3/20", "8/25", True, after, False),
        ("7/25", "8/25", False, after, False),
    ):
        times = (fmpq(F(t).numerator, F(t).denominator) for t in (lo, hi))
        assert close._holds_at_once(*times, contact, [state]) is holds, (lo, hi, contact)
    assert close._common(before.time, [before]) is None and close._common(after.time, [after]) is not None


def test_weights_that_may_be_negative_bound_nothing():
    """Of functions of a body alone, weighted 2 and -1, the sum may be positive where both are not."""
    a, b = PASSING["balls"](TINY)
    (motion,) = curved_pieces(a, b, fmpq(0), fmpq(1))
    system = CloseUp(motion, convex_pieces(a.body), 0, convex_pieces(b), 0).separation
    state = system.solve(system.guess(fmpq(1, 2)), STATIC)
    paths = system.paths(state)
    assert len(paths) == 5 and system.apart(state, paths, fmpq(1, 1000)) is not None
    paths[3][0], paths[4][0] = fmpq(2), fmpq(-1)
    assert system.apart(state, paths, fmpq(1, 1000)) is None


HAIR = {"ball": fc.sphere(1), "egg": fc.ellipsoid((1, 2, 3)), "can": fc.cylinder(1, 1), "block": fc.box((2, 2, 2))}


@pytest.mark.share(3)
@pytest.mark.parametrize("name, gap", list(zip(HAIR, [F(1, 10**15), F(1, 10**30)] * 2, strict=True)))
def test_a_hair_apart_at_the_start(name, gap):
    """x = 2 + gap turns about (0, -5), clockwise away from x = 0: "free until 0" was all that was told, in two motions
    or a screw.  The other way they meet at once."""
    shape = HAIR[name]
    for radians, status in ((-0.3, fc.Status.FREE), (0.3, fc.Status.CONTACT)):
        body, turn = shape.translated((2 + gap, 0, 0)), {"axis": Z, "point": (0, -5, 0), "radians": radians}
        for a, b in (
            (body.moving(fc.Screw(**turn, advance=1)), shape),
            (body.moving(fc.Rotation(**turn)), shape.moving(fc.Translation((0, 0, -1)))),
        ):
            hit = fc.first_contact(a, b)
            assert hit.status is status and (hit.time is None or hit.time < 1e-12)
            if status is fc.Status.FREE or name in ("ball", "egg"):
                assert fc.contact_intervals(a, b).status is status


@pytest.mark.share(3)
@pytest.mark.parametrize("radians, end", [(-0.3, 0), (0.3, 1)])
def test_a_hair_deep_at_the_start(radians, end):
    """Balls that overlap by 1e-15 and part, or go on: intervals were UNDECIDED, as those of balls a hair apart."""
    ball = fc.sphere(1)
    a = ball.translated((2 - F(1, 10**15), 0, 0)).moving(fc.Screw(Z, (0, -5, 0), radians=radians, advance=1))
    (found,) = fc.contact_intervals(a, ball)
    assert found.start == 0 and abs(found.end - end) < 1e-12
