"""Motions that are a shift, a rotation or a screw over the span: told by what is known of these."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest
import trimesh

import firstcontact as fc
from firstcontact.contact.plain import _PLACED, MOST_PLACED, plainly
from firstcontact.exact.numbers import rational

ONE = np.eye(4, dtype=int).tolist()
RING = fc.torus(3, 2)
CONTACT = fc.Status.CONTACT


def shifted(by: tuple[int, int, int]) -> list[list[int]]:
    return [[*row[:3], x] for row, x in zip(ONE, (*by, 1), strict=True)]


def shift(by: tuple[int, int, int]) -> fc.RationalMotion:
    """t times that."""
    return fc.RationalMotion([ONE, [[0, 0, 0, x] for x in (*by, 0)]])


DOWN = (0, 0, -2)
HALF = fc.Translation((0, 0, -1))
SHIFTS = {
    "of the first degree": shift(DOWN),
    "between poses": fc.RationalMotion.between(ONE, shifted(DOWN)),
    "a trajectory": fc.Trajectory([0, 1], [ONE, shifted(DOWN)]),
    "a trajectory in screws": fc.Trajectory([0, 1], [ONE, shifted(DOWN)], interpolation="screw"),
    "steps that go on": fc.Sequence([HALF, HALF]),
    "uneven steps": fc.Sequence([fc.Translation((0, 0, z)) for z in (F(-1, 2), F(-3, 2))], [F(1, 4), F(3, 4)]),
}


@pytest.mark.thorough
@pytest.mark.parametrize("motion", SHIFTS.values(), ids=SHIFTS)
def test_a_ball_lands_on_a_ring_however_its_shift_is_told(motion):
    """All about one axis they touch along a circle: the centre is at 4 above the ring's, as 3, 4, 5."""
    ball = fc.sphere(3).translated((0, 0, 5)).moving(motion)
    hit = fc.first_contact(ball, RING)
    assert (hit.status, hit.time, hit.a, hit.b) == (CONTACT, 0.5, ball, RING)
    found = fc.contact_intervals(RING, ball)
    assert (len(found), found[0].start, found[0].end, found.b) == (1, 0.5, 1.0, ball)


@pytest.mark.share(6)
@pytest.mark.parametrize("motion", SHIFTS.values(), ids=SHIFTS)
def test_a_block_that_slides_meets_what_is_new(motion):
    """Along a wall in which it touches at the start, down to a floor at a third."""
    block = fc.box((2, 2, 2)).translated((0, 0, 1)).moving(motion)
    corner = fc.box((2, 20, 20)).translated((2, 0, 0)) | fc.box((20, 20, 2)).translated((0, 0, F(-5, 3)))
    hit = fc.first_new_contact(block, corner)
    assert (hit.status, hit.time, hit.a) == (CONTACT, 1 / 3, block)


def test_what_is_plain_is_told_over_the_span_alone():
    turn, ahead = fc.Rotation((0, 0, 1), degrees=90), fc.Translation((4, 0, 0))
    body = fc.box((1, 1, 1)).moving(fc.Sequence([turn, ahead]))
    first, half, last = (rational(x, "time") for x in (0, F(1, 2), 1))
    assert plainly(body, first, last) is body
    assert plainly(body, first, half).motion == fc.Rotation((0, 0, 1), degrees=180)
    then = plainly(body, half, last)
    assert then.motion == fc.Translation((8, 0, 0))
    for t in (F(1, 2), F(3, 4), 1):
        assert np.abs(then.at(t).bounds() - np.array(body.at(t).bounds())).max() < 1e-12


@pytest.mark.parametrize("motion", (
    fc.RationalMotion([ONE, [[0] * 4] * 4, [[0, 0, 0, x] for x in (*DOWN, 0)]]),
    fc.RationalMotion([ONE, [[1, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]]),
    fc.RationalMotion.between(ONE, [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]),
    fc.Sequence([HALF, fc.Translation((0, 1, 0))]),
))  # fmt: skip
def test_what_speeds_up_stretches_turns_or_bends_off_is_no_shift(motion):
    body = fc.sphere(1).moving(motion)
    assert plainly(body, rational(0, "time"), rational(1, "time")) is body


@pytest.mark.parametrize("kind", ["linear-quaternion", "screw", "between"])
def test_a_straight_way_of_poses_is_asked_about_as_the_shift_that_it_is(kind):
    """Boxes of many triangles that overlap at the start: events of balls took over a minute."""
    a, b = (fc.Polyhedron.from_trimesh(trimesh.creation.box(sides).subdivide().subdivide())
            for sides in ((5, 1, 1), (3, 1, 1)))  # fmt: skip
    away = np.eye(4)
    away[:3, 3] = -4, 2, 4
    motion = (
        fc.RationalMotion.between((0, 0, 0), (-4, 2, 4), quat_wxyz=((1, 0, 0, 0), (1, 0, 0, 0)))
        if kind == "between" else fc.Trajectory([0, 1], [np.eye(4), away], interpolation=kind)
    )  # fmt: skip
    (told,) = fc.contact_intervals(a.moving(motion), b)
    assert (told.start, told.end) == (0.0, 0.25)
    hit = fc.first_contact(a.translated((9, 0, 0)).moving(motion), b)
    plain = fc.first_contact(a.translated((9, 0, 0)).moving(fc.Translation((-4, 2, 4))), b)
    assert (hit.status, hit.time) == (plain.status, plain.time)
    assert hit.a.motion is motion


def test_a_span_that_ends_with_a_jump_is_not_that_of_the_step_before():
    """A step whose own pose at its start is elsewhere: the bodies share a point at the very end of the span alone."""
    shift = [[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1], [0, 0, 0, 0]]
    there = [[int(i == j) if j < 3 else (0, 0, 10, 1)[i] for j in range(4)] for i in range(4)]
    motion = fc.Sequence([fc.Translation((1, 0, 0)), fc.RationalMotion([there, shift])], [1, 1])
    ball = fc.sphere(1)
    hit = fc.first_contact(ball.moving(motion), ball.translated((1, 0, 11)), (0, 1))
    assert (hit.status, hit.time) == (fc.Status.CONTACT, 1.0)
    assert [x.start for x in fc.contact_intervals(ball.moving(motion), ball.translated((1, 0, 11)), (0, 1))] == [1.0]


def test_copies_by_other_names_are_told_by_their_own():
    """Both ways are straight and begin elsewhere, in one pose; what is kept of the shape is kept of all its copies."""
    box = fc.examples.box((1, 1, 1))
    there = fc.Trajectory([0, 1], [shifted((0, 0, 5)), shifted((0, 0, 1))])
    for name in ("left", "right"):
        hit = fc.first_contact(box.named(name).moving(there), fc.examples.box((4, 4, 1)).named("floor"))
        assert (hit.time, hit.element_a.body, hit.element_b.body) == (1.0, name, "floor")
        ball = fc.sphere(1).named("ball")
        hit = fc.first_contact(ball.named(name).moving(there), fc.examples.box((4, 4, 1)).named("floor"))
        assert hit.element_a.body == name


def test_few_copies_of_a_shape_are_kept():
    """A path of many straight parts puts a shape into as many poses."""
    box, floor = fc.examples.box((1, 1, 1)), fc.examples.box((4, 4, 1))
    for height in range(4, 4 + 2 * MOST_PLACED):
        there = fc.Trajectory([0, 1], [shifted((0, 0, height)), shifted((0, 0, 1))])
        assert fc.first_contact(box.moving(there), floor).time == 1.0
        assert 0 < len(_PLACED.of(box, dict)) <= MOST_PLACED


DISC = ("(u, -1, {0})", "(u, 1, {0})", ["u**2 + (2*s - 1)**2 <= 1"])


@pytest.mark.parametrize("height, velocity", [("2*T", (0, 0, 2)), ("1/3 - T/7", (0, 0, F(-1, 7))), ("1", (0, 0, 0)),
                                              ("T**2", None), ("u*T", None), ("1/(1 + T)", None)])  # fmt: skip
def test_what_deforms_by_a_shift_alone_is_known(height, velocity):
    first, second, trim = DISC
    piece = fc.RuledSurface(first.format(height), second.format(height), u=(-1, 1), trim=trim)
    told = piece.velocity if piece.deforming or velocity is not None else None
    assert told == velocity or [F(int(x.p), int(x.q)) for x in told] == list(velocity)


def test_the_sides_of_a_piece_that_shift_unlike_are_no_shift():
    assert fc.RuledSurface("(u, 0, T)", "(u, 1, 2*T)").velocity is None
    assert fc.RuledSurface("(u, 0, 0)", "(u, 1, 2*T)").velocity is None
    assert fc.RuledSurface("(u/(1 + u), 0, T)", "(u, 1, T)").velocity == (0, 0, 1)


@pytest.mark.parametrize("span", [(0, 1), (F(1, 4), 3)])
def test_a_piece_that_shifts_is_told_as_one_that_is_moved(span):
    """Found outside: a plate (u, -1, 2 T) that comes flush with a disc was undecided, not one that is moved."""
    first, second, trim = DISC
    shifting = fc.RuledSurface("(u, -1, 2*T)", "(u, 1, 2*T)", u=(-1, 1), name="plate")
    moved = fc.RuledSurface("(u, -1, 0)", "(u, 1, 0)", u=(-1, 1), name="plate").moving(fc.Translation((0, 0, 2)))
    disc = fc.RuledSurface(first.format(1), second.format(1), u=(-1, 1), trim=trim)
    boxes = (x.translated((0, 0, "3/2")) for x in (fc.box((1, 1, 1)), fc.examples.box((1, 1, 1))))
    for other in (disc, *boxes):
        hit, like = (fc.first_contact(x, other, span) for x in (shifting, moved))
        assert hit.a is shifting and (hit.time_interval, hit.element_a, hit.element_b, hit.others) == (
            like.time_interval, like.element_a, like.element_b, like.others)  # fmt: skip
        assert hit.time_interval[0] <= 0.5 <= hit.time_interval[1] and hit.span == like.span
        back = fc.first_contact(other, shifting, span)
        assert back.b is shifting and back.time_interval == hit.time_interval
        found = fc.contact_intervals(shifting, other, span)
        assert found.a is shifting and [(x.start, x.end) for x in found] == [
            (x.start, x.end) for x in fc.contact_intervals(moved, other, span)]  # fmt: skip
