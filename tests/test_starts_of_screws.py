"""Spans that start while a screw stands in a rational pose: half a turn about an axis of rational length."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc

AXES = [((0, 0, 1), 1), ((2, 2, 1), 3), ((0, "-3/5", "4/5"), 1)]
SHAPES = [fc.sphere(1), fc.sphere(1) - fc.sphere("1/4")]


def before_half_a_turn(point, axis, length, advance):
    """Where the screw takes the point from, by n (n . p) twice less p."""
    n = [F(c) / length for c in axis]
    p = [F(x) - advance * c for x, c in zip(point, n, strict=True)]
    along = sum(x * c for x, c in zip(p, n, strict=True))
    return tuple(2 * along * c - x for x, c in zip(p, n, strict=True))


def tip(x):
    """A triangle that looks away from the ball about (-3, 0, 1), its nearest corner at (x, 0, 1)."""
    return fc.Polyhedron([(F(x), 0, 1), (5, 1, 1), (5, -1, 1)], [[0, 1, 2]])


@pytest.mark.share(4)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("axis", "length"), AXES)
@pytest.mark.parametrize(("x", "initial"), [("-2", "touching"), ("-17/8", "overlapping")])
def test_a_ball_at_a_corner(axis, length, shape, x, initial):
    ball = shape.translated(before_half_a_turn((-3, 0, 1), axis, length, 2))
    moving = ball.moving(fc.Screw(axis, turns="1/2", advance=2))
    for a, b in ((moving, tip(x)), (tip(x), moving)):
        hit = fc.first_contact(a, b, (1, 2))
        assert hit.status is fc.Status.INITIAL_CONTACT and hit.time == 1 and hit.initial == initial
        if initial == "touching":
            mesh_side = hit.element_b if a is moving else hit.element_a
            assert hit.point == pytest.approx([-2, 0, 1], abs=1e-12) and mesh_side.kind == "vertex"


@pytest.mark.parametrize(("axis", "length"), AXES)
def test_a_corner_that_the_screw_takes_to_the_ball(axis, length):
    corners = [before_half_a_turn(p, axis, length, 2) for p in ((-2, 0, 1), (5, 1, 1), (5, -1, 1))]
    mesh = fc.Polyhedron(corners, [[0, 1, 2]]).moving(fc.Screw(axis, turns="1/2", advance=2))
    hit = fc.first_contact(mesh, fc.sphere(1).translated((-3, 0, 1)), (1, 2))
    assert hit.status is fc.Status.INITIAL_CONTACT and hit.initial == "touching"
    assert hit.point == pytest.approx([-2, 0, 1], abs=1e-12)


ANGLE = fc.Polyhedron(
    [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))],
    [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *[[k, (k + 1) % 6, (k + 1) % 6 + 6, k + 6] for k in range(6)]],
)
"""Its face in the plane x = 0 touches what is on the other side there."""


@pytest.mark.parametrize("beside", ["ball", "can"])
@pytest.mark.parametrize("motion", ["sequence", "trajectory"])
def test_steps_whose_equations_are_not_rational_start_in_a_pose_that_is(beside, motion):
    """Of a lone Screw the start was asked about at rest; of steps of screws it was UNDECIDED."""
    other = {"ball": fc.sphere("1/2"), "can": fc.cylinder("1/2", 1)}[beside].translated(("-1/2", "1/2", "1/2"))
    away = fc.Screw((1, 0, 0), degrees=20, advance=1)
    steps = fc.Sequence([away, fc.Screw((1, 1, 0), degrees=10, advance=1)])
    if motion == "trajectory":
        steps = fc.Trajectory([0, 1, 2], [np.array(steps(t)) for t in (0, 0.5, 1)], interpolation="screw")
    for a, b in ((ANGLE.moving(steps), other), (other, ANGLE.moving(steps))):
        hit = fc.first_contact(a, b)
        assert (hit.status, hit.initial) == (fc.Status.INITIAL_CONTACT, "touching")
        assert abs(hit.point[0]) < 1e-9
