"""Spans that start while a screw stands in a rational pose: half a turn about an axis of rational length."""

from __future__ import annotations

from fractions import Fraction as F

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
