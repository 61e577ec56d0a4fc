"""Hyperboloids of one sheet cut by other solids: what convex pieces cover them reaches beyond their boxes."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc
from firstcontact import Status
from firstcontact.body.solid import composite_quadric
from firstcontact.exact.numbers import Undecidable
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


@pytest.mark.share(5)
@pytest.mark.parametrize("make", BODIES)
def test_a_cover_holds_the_body(make):
    body = make().rotated((1, 2, 3), degrees=40)
    pieces, points = covering_pieces(body), inner_points(body)
    assert len(points) > 100
    for n in np.random.default_rng(7).normal(size=(60, 3)):
        reach = max(support(pieces.array, i, *n)[0] for i in range(pieces.count))
        assert reach >= (points @ n).max() - 1e-9


@pytest.mark.share(4)
@pytest.mark.parametrize("far", AWAYS)
@pytest.mark.parametrize("make", BODIES)
def test_apart_by_far(make, far):
    body, far = make().moving(fc.Translation((0, 0, 5))), far.translated((30, 0, 0))
    assert fc.first_contact(body, far).status is fc.Status.FREE
    assert fc.first_contact(body, far, method="certified").status is fc.Status.FREE
    assert fc.contact_intervals(body, far).status is fc.Status.FREE


@pytest.mark.share(5)
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


def test_ends_that_all_but_meet_are_told_apart():
    """Beside one plane two roots are so close that the iteration for all roots at once never converges."""
    turn = [["-9/11", "-6/11", "2/11"], ["-6/11", "7/11", "-6/11"], ["2/11", "-6/11", "-9/11"]]
    away = ["-1/4", "-1/4", "1/2"]
    placed = [[*map(F, row), F(x)] for row, x in zip(turn, away, strict=True)] + [[0, 0, 0, 1]]
    waist = fc.quadric([["4/9", 0, 0, 0], [0, 4, 0, 0], [0, 0, -1, 0], [0, 0, 0, -1]])
    body = waist & fc.ellipsoid(("5/2", "3/2", "3/2")).transformed(placed)

    axes, centre = np.split(np.array(placed[:3], float), [3], axis=1)

    def forms(points):
        """Of the waist and of the ellipsoid: at most 0 in the body."""
        x, y, z = points.T
        local = (points - centre[:, 0]) @ axes / [2.5, 1.5, 1.5]
        return np.array([4 / 9 * x * x + 4 * y * y - z * z - 1, (local**2).sum(1) - 1])

    hit = fc.first_contact(fc.sphere("1/2").translated((0, 0, 5)).moving(fc.Translation((0, 0, -9))), body)
    assert hit.status is Status.CONTACT
    height = 5 - 9 * hit.time
    assert np.linalg.norm(np.subtract(hit.point, (0, 0, height))) == pytest.approx(0.5, abs=1e-9)
    assert (forms(np.array([hit.point])) < 1e-9).all()
    points = np.random.default_rng(3).uniform((-0.5, -0.5, -1), (0.5, 0.5, 2), (200_000, 3))
    points = points[(forms(points) <= 0).all(0)]
    under = points[np.hypot(points[:, 0], points[:, 1]) < 0.5]
    reached = (under[:, 2] + np.sqrt(0.25 - under[:, 0] ** 2 - under[:, 1] ** 2)).max()
    assert reached - 1e-9 < height < reached + 0.05


def test_solids_whose_edges_are_not_told_say_so(monkeypatch):
    """By an error that names the solid; they can be shown all the same."""
    other = fc.quadric([[2, 1, 0, 0], [1, -3, 0, 1], [0, 0, 1, 0], [0, 1, 0, -2]])
    endless = fc.quadric(np.diag([1, 2, -1, -1])) & other
    with pytest.raises(fc.UnsupportedPair, match="intersect it with a box"):
        _ = endless.edges
    assert repr(endless) == "<CompositeQuadric: 2 surfaces>"

    def fails(*_):
        raise Undecidable

    monkeypatch.setattr(composite_quadric, "derive", fails)
    with pytest.raises(fc.UnsupportedPair, match="solid: its edges come too close"):
        _ = (fc.sphere(2) & fc.sphere(2).translated((1, 0, 0))).edges
