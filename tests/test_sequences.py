"""Steps one after the other, and two bodies that both move."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from flint import arb, fmpq

import firstcontact as fc
import generators as g
import naive
from agreement import polyhedron
from amount import amount
from curved import assert_first_by_sampling
from vectors import Body

CUBE = g.box()
Z = (0, 0, 1)


# -------------------------------------------------------------------------------------- truth, step by step


def end_pose(motion):
    if isinstance(motion, naive.Shift):
        return motion.pose(fmpq(1))
    return motion.pose(motion.quarter_turns(int(motion.turns * 4)))


def chain_truth(a: Body, b: Body, steps, ends) -> tuple[str, float | None]:
    """First contact of a moved by the steps; step k runs from ends[k-1] to ends[k]."""
    points = [naive.vector(p) for p in a.v]
    for motion, (start, end) in zip(steps, pairwise([Fraction(0), *ends]), strict=True):
        status, time, _ = naive.first_contact(points, a.e, a.f, b.v, b.e, b.f, motion, 1)
        if status != naive.FREE:
            return (
                naive.INITIAL if start == 0 else naive.CONTACT
            ) if status == naive.INITIAL else status, world_time(motion, time, start, end)
        points = [end_pose(motion)(p) for p in points]
    return naive.FREE, None


def world_time(motion, time, start: Fraction, end: Fraction) -> float:
    if isinstance(motion, naive.Shift):
        return float(start + (end - start) * Fraction(int(time.numer()), int(time.denom())))
    s, d = naive.rational(start), naive.rational(end - start)
    return naive.nearest_double(lambda: arb(s) + arb(d) * motion.angle(time) / motion.total())


def random_steps(rng):
    """[(library motion, reference motion)]: translations and quarter turns about lattice axes."""
    steps = []
    for _ in range(rng.integers(2, 5)):
        if rng.integers(2):
            v = rng.integers(-3, 4, 3).tolist()
            steps.append((fc.Translation(v), naive.Shift(v)))
        else:
            axis = np.roll([0, 0, 1], rng.integers(3)).tolist()
            keys = {
                "point": rng.integers(-2, 3, 3).tolist(),
                "turns": Fraction(int(rng.choice([-2, -1, 1, 2, 3])), 4),
            }
            steps.append((fc.Rotation(axis, **keys), naive.Turn(axis, **keys)))
    return steps


@pytest.mark.thorough
@pytest.mark.parametrize("first", range(0, amount(300, 6), 100))
def test_random_steps_with_exact_joints(first):
    seen = set()
    for seed in range(first, first + 100):
        rng = np.random.default_rng(seed)
        scene = g.lattice_scene(seed, rotating=False)
        steps = random_steps(rng)
        durations = [Fraction(int(k), 4) for k in rng.integers(1, 9, len(steps))]
        ends = [sum(durations[: k + 1], Fraction(0)) for k in range(len(steps))]
        status, time = chain_truth(scene.a, scene.b, [ref for _, ref in steps], ends)
        motion = fc.Sequence([lib for lib, _ in steps], durations=durations)
        hit = fc.first_contact(polyhedron(scene.a).moving(motion), polyhedron(scene.b))
        assert (hit.status.name, hit.time) == (status, time), f"seed {seed}, {steps}: {scene}"
        seen.add(status)
    assert len(seen) == 3


# -------------------------------------------------------------------------------------------------- by hand


def box_at(at, name=None) -> fc.Polyhedron:
    return polyhedron(g.box((1, 1, 1), at), solid=True, name=name)


def test_contact_in_a_later_step():
    around = fc.Sequence([fc.Translation((0, 3, 0)), fc.Translation((4, 0, 0)), fc.Translation((0, -3, 0))])
    hit = fc.first_contact(box_at((-2, 0, 0)).moving(around), box_at((2, 0, 0)))
    assert hit.status is fc.Status.CONTACT
    assert hit.time == pytest.approx(2 / 3 + 2 / 9, abs=1e-15)
    assert hit.normal == pytest.approx((0, 1, 0)) or hit.normal is None


def test_contact_exactly_at_a_joint_and_at_the_end():
    right, up = fc.Translation((1, 0, 0)), fc.Translation((0, 1, 0))
    for steps, time in (([right, up], 0.5), ([up, right], 1.0)):
        hit = fc.first_contact(
            box_at((-2, 0, 0)).moving(fc.Sequence(steps)), polyhedron(g.box((1, 5, 1))), exact=True
        )
        assert hit.status is fc.Status.CONTACT
        assert hit.time == time and hit.time_exact == Fraction(time)


def test_durations_set_the_clock():
    motion = fc.Sequence([fc.Translation((0, 0, 3)), fc.Translation((0, 0, 1))], durations=[10, 1])
    hit = fc.first_contact(box_at((0, 0, -4.5)).moving(motion), box_at((0, 0, 0)))
    assert hit.time == 10.5
    assert hit.span == (0, 11)


def test_a_span_outside_the_sequence_is_refused():
    moving = box_at((-3, 0, 0)).moving(fc.Sequence([fc.Translation((1, 0, 0))] * 2))
    for span in ((0, 1.5), (-0.5, 1), (0, math.inf)):
        with pytest.raises(fc.InputError):
            fc.first_contact(moving, box_at((0, 0, 0)), span)


def test_part_of_a_sequence():
    moving = box_at((-2, 0, 0)).moving(fc.Sequence([fc.Translation((4, 0, 0)), fc.Translation((-4, 0, 0))]))
    assert fc.first_contact(moving, box_at((0, 0, 0)), (0, 0.1)).status is fc.Status.FREE
    assert fc.first_contact(moving, box_at((0, 0, 0)), (0.1, 1)).time == 0.125
    late = fc.first_contact(moving, box_at((0, 0, 0)), (0.5, 1))  # starts beyond the box, comes back
    assert late.time == 0.5 + 0.125
    assert fc.first_contact(moving, box_at((0, 0, 0)), (0.9, 1)).status is fc.Status.FREE


def test_intervals_across_joints_are_merged():
    steps = [fc.Translation((2, 0, 0)), fc.Translation((2, 0, 0)), fc.Translation((-4, 0, 0))]
    found = fc.contact_intervals(
        box_at((-2, 0, 0)).moving(fc.Sequence(steps, durations=[2, 2, 4])), box_at((0, 0, 0))
    )
    assert [(i.start, i.end) for i in found] == [(1, 3), (5, 7)]


# -------------------------------------------------------------------------------- poses that are irrational

ONE = fc.Rotation(Z, radians=1)
BACK = fc.Rotation(Z, radians=-1)


def test_step_after_an_irrational_turn():
    """A point turned by one radian goes straight on to a wall: sin(1) of its way remain."""
    steps = fc.Sequence([ONE, fc.Translation((0, 2, 0))])
    wall = Body([[-9, 2, -9], [9, 2, -9], [0, 2, 9]], [], [[0, 1, 2]])
    hit = fc.first_contact(polyhedron(Body([[1, 0, 0]], [], [])).moving(steps), polyhedron(wall))
    assert hit.status is fc.Status.CONTACT
    truth = 0.5 + 0.5 * (2 - math.sin(1)) / 2
    assert hit.time == pytest.approx(truth, abs=1e-14)
    assert hit.time_interval[0] <= truth + 1e-15 and truth - 1e-15 <= hit.time_interval[1]
    assert hit.time_interval[1] - hit.time_interval[0] <= 1e-12


def test_free_after_an_irrational_turn_is_proved():
    steps = fc.Sequence([ONE, fc.Translation((0, 0, 5))])
    wall = Body([[0.55, -9, 1], [9, -9, 1], [0.55, 9, 1]], [], [[0, 1, 2]])
    point = Body([[1, 0, 0]], [], [])
    assert (
        fc.first_contact(polyhedron(point).moving(steps), polyhedron(wall)).status is fc.Status.FREE
    )  # cos(1) = 0.54


def test_a_graze_after_an_irrational_turn_is_never_called_free():
    """Turned by one radian and back, the point passes through the corner of a triangle, exactly."""
    steps = fc.Sequence([ONE, BACK, fc.Translation((0, 0, 5))])
    corner = Body([[1, 0, 1], [2, 0, 1], [2, -3, 1]], [], [[0, 1, 2]])
    hit = fc.first_contact(polyhedron(Body([[1, 0, 0]], [], [])).moving(steps), polyhedron(corner))
    assert hit.status in (fc.Status.CONTACT, fc.Status.UNDECIDED)
    if hit.status is fc.Status.UNDECIDED:
        assert hit.reason == "precision"
        assert hit.free_until <= 2 / 3 + 1 / 15
    else:
        assert hit.time == pytest.approx(2 / 3 + 1 / 15, abs=1e-14)


# ----------------------------------------------------------------------------------------- both bodies move


def test_two_translations():
    a, b = box_at((-3, 0, 0)), box_at((3, 0, 0))
    hit = fc.first_contact(
        a.moving(fc.Translation((4, 1, 0))), b.moving(fc.Translation((-6, 1, 0))), exact=True
    )
    assert hit.time_exact == Fraction(1, 2)
    assert hit.point[0] == pytest.approx(0) and 0.5 <= hit.point[1] <= 1.5  # world frame, at that time
    together = fc.first_contact(a.moving(fc.Translation((4, 1, 0))), b.moving(fc.Translation((4, 1, 0))))
    assert together.status is fc.Status.FREE


def test_two_turns_about_one_axis():
    """Two clock hands; the axis written in three ways."""
    hand_a = polyhedron(Body([[1, 0, 0], [3, 0, 0]], [[0, 1]], []))
    hand_b = polyhedron(Body([[0, 2, -1], [0, 2, 1]], [[0, 1]], []))
    for axis, point, turns in (
        (Z, (0, 0, 0), -0.125),
        ((0, 0, 2), (0, 0, 7), -0.125),
        ((0, 0, -1), (0, 0, -1), 0.125),
    ):
        half_turn = hand_a.moving(fc.Rotation(Z, turns=0.5))
        other = hand_b.moving(fc.Rotation(axis, point=point, turns=turns))
        hit = fc.first_contact(half_turn, other)
        assert hit.time == 0.4  # they close in on each other at 5/8 turns
        angle = 2 * math.pi * 0.2  # and meet where the first hand is by then
        assert hit.point == pytest.approx((2 * math.cos(angle), 2 * math.sin(angle), 0), abs=1e-12)


def test_two_turns_in_step_never_meet():
    turn = fc.Rotation((1, 1, 1), point=(5, 0, 0), degrees=200)
    assert (
        fc.first_contact(box_at((0, 0, 0)).moving(turn), box_at((2, 0, 0)).moving(turn)).status
        is fc.Status.FREE
    )
    hit = fc.first_contact(box_at((0, 0, 0)).moving(turn), box_at((1, 0, 0)).moving(turn))
    assert hit.status is fc.Status.INITIAL_CONTACT and hit.initial == "touching"


def test_only_the_second_body_turns():
    arm, post = Body([[1, 0, 0], [3, 0, 0]], [[0, 1]], []), Body([[0, 2, -1], [0, 2, 1]], [[0, 1]], [])
    hit = fc.first_contact(polyhedron(arm), polyhedron(post).moving(fc.Rotation(Z, degrees=-180)))
    assert hit.time == 0.5
    assert hit.point == pytest.approx((2, 0, 0), abs=1e-12)
    assert hit.normal == pytest.approx((0, 1, 0), abs=1e-12) or hit.normal == pytest.approx(
        (0, -1, 0), abs=1e-12
    )
    # n points from b towards a: b comes from above, a lies below it.
    assert hit.normal[1] < 0


def test_two_sequences_of_translations_with_different_joints():
    a = box_at((-4, 0, 0)).moving(
        fc.Sequence([fc.Translation((1, 0, 0)), fc.Translation((5, 0, 0))], durations=[1, 1])
    )
    b = box_at((4, 0, 0)).moving(
        fc.Sequence(
            [fc.Translation((0, 1, 0)), fc.Translation((-2, 0, 0)), fc.Translation((0, -1, 0))],
            durations=[0.5, 1, 0.5],
        )
    )
    # gap 7; to time 0.5: -0.5, to 1: -0.5 -1, to 1.5: -2.5 -1 leaves 1.5, at 5 per unit of time
    hit = fc.first_contact(a, b)
    assert hit.status is fc.Status.CONTACT
    assert hit.time == 1.8


def test_sequence_against_translation():
    a = box_at((-3, 0, 0)).moving(fc.Sequence([fc.Translation((1, 0, 0)), fc.Translation((0, 0, 0))]))
    b = box_at((3, 0, 0)).moving(fc.Translation((-6, 0, 0)))
    hit = fc.first_contact(a, b, exact=True)  # gap 5: 0.5 * (2 + 6) = 4, the last 1 at speed 6
    assert hit.time_exact == Fraction(1, 2) + Fraction(1, 6)


BOTH_MOVE = {
    "translation and rotation": (fc.Translation((6, 0.3, 0)), fc.Rotation(Z, turns="1/50")),
    "rotation and translation": (fc.Rotation(Z, turns="-1/50"), fc.Translation((-6, 0.3, 0))),
    "axes that cross": (fc.Rotation(Z, turns="1/2"), fc.Rotation((1, 0, 0), turns="1/12")),
    "axes that are parallel": (fc.Rotation(Z, turns="1/2"), fc.Rotation(Z, point=(1, 0, 0), turns="-1/3")),
    "screw and rotation": (fc.Screw((1, 0, 0), turns=1, advance=6), fc.Rotation(Z, turns="1/50")),
    "turn inside a sequence": (
        fc.Sequence([fc.Translation((2, 0, 0)), fc.Rotation(Z, (1, 0, 0), turns="1/2")]),
        fc.Translation((-1, 0, 0.5)),
    ),
}


@pytest.mark.share(6)
@pytest.mark.parametrize("motions", BOTH_MOVE.values(), ids=BOTH_MOVE)
def test_two_moving_bodies_whose_relative_motion_is_curved(motions):
    """Against samples at rest; one body is tilted, so that no two faces slide in one plane."""
    lid = fc.examples.box().rotated((1, 2, 3), degrees=20).translated((-3, 0, 0.125)).named("lid")
    a, b = lid.moving(motions[0]), box_at((3, 0, 0), "plate").moving(motions[1])
    hit = fc.first_contact(a, b)
    assert hit.status is fc.Status.CONTACT
    assert_first_by_sampling(a, b, hit)
    swapped = fc.first_contact(b, a)
    assert abs(swapped.time - hit.time) <= 4e-16 and swapped.element_a == hit.element_b
    windows = fc.contact_intervals(a, b)
    assert windows[0].start == hit.time


def test_any_steps_against_a_resting_body():
    motion = fc.Sequence([fc.Translation((0, 0, 1)), fc.Rotation(Z, turns=Fraction(1, 2)), ONE])
    hit = fc.first_contact(box_at((-3, 0, 0)).moving(motion), box_at((9, 0, 0)))
    assert hit.status is fc.Status.FREE
