"""Hyperboloids of one sheet cut by other solids: what convex pieces cover them reaches beyond their boxes."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.kernels.convex.support import support
from firstcontact.search.convex.convex import covering_pieces

WAIST = fc.hyperboloid((1, 1, "3/2"), 2)


def bowl():
    """Edges of degree 4; the flat bottom is z = -1."""
    return WAIST & fc.paraboloid((1, 1), 2).rotated((1, 0, 0), degrees=90).translated((-1, 0, -1))


def egg():
    """The flat top is z = 3/2."""
    return WAIST.translated((-1, 0, "1/2")) & fc.ellipsoid((1, 1, 2)).translated((0, -1, 1))


def plate():
    return WAIST & fc.box(("1/4", 4, 4))


def disc():
    return WAIST & fc.box((8, 4, 1))


def cored():
    """Its half-spaces that are convex leave a slab without end."""
    return WAIST - fc.sphere("1/2")


BODIES = [bowl, egg, plate, disc, cored]
SPEEDS = [(0, 0, -1), (1, -1, -1), (0, -1, "-1/2")]
AWAYS = [fc.sphere(1), fc.box((1, 1, 1)) - fc.sphere("1/3")]


def inner_points(body, count=4000):
    lo, hi = body.bounds()
    points = np.random.default_rng(1).uniform(lo, hi, (count, 3))
    return points[body.contains(points)]


@pytest.mark.parametrize("make", BODIES)
def test_a_cover_holds_the_body(make):
    body = make().rotated((1, 2, 3), degrees=40)
    pieces, points = covering_pieces(body), inner_points(body)
    assert len(points) > 100
    for n in np.random.default_rng(7).normal(size=(60, 3)):
        reach = max(support(pieces.array, i, *n)[0] for i in range(pieces.count))
        assert reach >= (points @ n).max() - 1e-9


@pytest.mark.parametrize("far", AWAYS)
@pytest.mark.parametrize("make", BODIES)
def test_apart_by_far(make, far):
    body, far = make().moving(fc.Translation((0, 0, 5))), far.translated((30, 0, 0))
    assert fc.first_contact(body, far).status is fc.Status.FREE
    assert fc.first_contact(body, far, method="certified").status is fc.Status.FREE
    assert fc.contact_intervals(body, far).status is fc.Status.FREE


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("place", [("-1/2", "-1/2"), ("-1/4", "-1/2"), (0, "-1/2")])
def test_a_ball_lands_on_the_flat_top(place, speed):
    """It comes along a line through the place of contact, so it touches when its middle is a radius above the top."""
    radius, top, back = F(1, 4), F(3, 2), 2
    v = [F(x) for x in speed]
    middle = [F(place[0]), F(place[1]), top + radius]
    ball = fc.sphere(radius).translated([m - back * x for m, x in zip(middle, v, strict=True)])
    hit = fc.first_contact(ball.moving(fc.Translation([(back + 1) * x for x in v])), egg())
    assert hit.status is fc.Status.CONTACT
    assert hit.time_interval[0] <= F(back, back + 1) <= hit.time_interval[1]
    assert hit.point == pytest.approx([float(F(place[0])), float(F(place[1])), 1.5], abs=1e-9)


def test_a_ball_meets_the_flat_bottom():
    ball = fc.sphere(1).translated(("-1/2", "-1/2", -5)).moving(fc.Translation((0, 0, 5)))
    hit = fc.first_contact(ball, bowl())
    assert hit.time == pytest.approx(3 / 5, abs=1e-12) and hit.element_b.kind == "face"
    assert hit.point == pytest.approx([-0.5, -0.5, -1], abs=1e-9)


def test_a_ball_meets_the_waist():
    """Along the axis x, where the waist is of radius 1."""
    ball = fc.sphere("1/2").translated((-4, 0, 0)).moving(fc.Translation((4, 0, 0)))
    hit = fc.first_contact(ball, disc())
    assert hit.status is fc.Status.CONTACT and hit.time == pytest.approx(5 / 8, abs=1e-12)


def test_a_triangle_lands_on_the_flat_top():
    """Tip first; a mesh is kept from covers by the same pieces."""
    tip = [(0, 0, 2), (1, 0, 3), (-1, 1, 3)]
    mesh = fc.Polyhedron(np.add(tip, (-0.5, -0.5, 0)), [[0, 1, 2]]).moving(fc.Translation((0, 0, -1)))
    hit = fc.first_contact(mesh, egg())
    assert hit.time == pytest.approx(1 / 2, abs=1e-12) and hit.element_a.kind == "vertex"
