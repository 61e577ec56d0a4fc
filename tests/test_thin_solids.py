"""Solids far thinner than wide, whose interior no random point meets; and one with three surfaces through a vertex."""

from __future__ import annotations

import warnings
from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc

H = fc.half_space
UP, DOWN = (0, 0, 2), (0, 0, -2)


def thin(thickness):
    """By name: solids whose highest point is the origin and that go down as far as the thickness, and no farther."""
    e = thickness
    return {
        "cap of a ball": (fc.sphere(1) & H((0, 0, -1), e - 1)).translated((0, 0, -1)),
        "cap of an ellipsoid": (fc.ellipsoid((1, 2, "1/2")) & H((0, 0, -1), e - Fraction(1, 2))).translated(
            (0, 0, "-1/2")
        ),
        "lens": fc.sphere(1).translated((0, 0, -1)) & fc.sphere(1).translated((0, 0, 1 - e)),
        "shallow paraboloid": fc.paraboloid((1, 2), e).translated((0, 0, -e)),
        "shallow cone": fc.cone(1, e).translated((0, 0, -e)),
        "cap of a hyperboloid": fc.hyperboloid((1, 1, 1), 1 + e, sheets=2).translated((0, 0, -1 - e)),
        "strip of a tube": ((fc.cylinder(1, 2) - fc.cylinder(1 - e, 3)) & H((-1, 0, 0), e - 1))
        .rotated((0, 1, 0), degrees=-90)
        .translated((0, 0, -1)),
    }


@pytest.mark.share(16)
@pytest.mark.parametrize("name", thin(Fraction(1, 100)))
@pytest.mark.parametrize("thickness", [Fraction(1, 100), Fraction(1, 10**6), Fraction(1, 10**9)], ids=str)
def test_a_ball_meets_thin_solids_from_above_and_below(name, thickness):
    solid, ball = thin(thickness)[name], fc.sphere("1/4")
    above = fc.first_contact(ball.translated((0, 0, "5/4")).moving(fc.Translation(DOWN)), solid)
    assert above.status is fc.Status.CONTACT and above.time == pytest.approx(0.5, abs=1e-11)
    if name != "strip of a tube":  # that is hollow from below
        start = ball.translated((0, 0, -Fraction(5, 4) - thickness))
        below = fc.first_contact(start.moving(fc.Translation(UP)), solid)
        assert below.status is fc.Status.CONTACT and below.time == pytest.approx(0.5, abs=1e-11)
    inside = fc.first_contact(fc.box((3, 5, 3)).moving(fc.Translation(UP)), solid)
    assert inside.status is fc.Status.INITIAL_CONTACT and inside.initial in ("overlapping", "containment")


def test_the_cap_of_a_large_ball():
    cap = fc.sphere(100) & H((0, 0, -1), -99)
    drop = fc.sphere(1).translated((0, 0, 111)).moving(fc.Translation((0, 0, -20)))
    assert fc.first_contact(drop, cap, exact=True).time_exact == Fraction(1, 2)
    (during,) = fc.contact_intervals(drop, cap)
    assert (during.start, during.end) == (0.5, 0.65)


# -- a quadric that changes nothing, through a vertex -----------------------------------------------------------

Q = fc.quadric
BALL = Q([[4, 0, 0, 0], [0, 4, 0, 0], [0, 0, 4, 0], [0, 0, 0, -9]])
CUT = Q([[4, 0, 0, 4], [0, 4, 0, 4], [0, 0, -4, 6], [4, 4, 6, -1]]) & H((0, 0, 2), 3) & H((0, 0, -2), 1)
WAIST = (
    Q([[100, 0, 0, 100], [0, -4, 0, -6], [0, 0, 100, 100], [100, -6, 100, 191]]) & H((0, -2, 0), 3) & H((0, 1, 0), 1)
)
ORDERS = {"ball first": (BALL - CUT) & WAIST, "waist first": WAIST & (BALL - CUT), "cut last": (BALL & WAIST) - CUT}


@pytest.mark.share(3)
@pytest.mark.parametrize("order", ORDERS)
def test_a_redundant_quadric_passes_through_the_end_of_an_edge_of_degree_4(order):
    solid = ORDERS[order]
    assert (len(solid.faces), len(solid.edges)) == (3, 3)
    ends = sorted(v.position for v in solid.vertices)
    assert np.allclose(ends, [(-1, 1, -0.5), (-0.5, 1, -1)])


@pytest.mark.share(3)
@pytest.mark.parametrize("start, way, time", [
    ((-0.75, 3, -0.75), (0, -4, 0), 1.9 / 4),  # onto the flat face, y = 1
    ((-1, 3, -0.5), (0, -4, 0), 1.9 / 4),  # onto the vertex
    ((-2, 1, -2), (2, -1, 2), 1.4 / 3),  # onto the ball's skin, where the middle of the face is
])  # fmt: skip
def test_a_ball_meets_what_the_redundant_quadric_leaves(start, way, time):
    ball = fc.sphere("1/10").translated(start).moving(fc.Translation(way))
    hit = fc.first_contact(ball, ORDERS["ball first"])
    assert hit.status is fc.Status.CONTACT and hit.time == pytest.approx(time, abs=1e-11)
    assert fc.first_contact(ORDERS["ball first"], ball).time == pytest.approx(time, abs=1e-11)


# -- far away -----------------------------------------------------------------------------------------------------

FAR = 10**16
SHAPES = {
    "ball": fc.sphere(1),
    "plate": fc.box((8, 8, 2)) - fc.cylinder(2, 4),
    "cone": fc.cone(1, 2),
    "pierced ball": fc.sphere(1) - fc.cylinder(("1/2", "1/4"), 4),
}


@pytest.mark.share(2)
@pytest.mark.parametrize("shape", SHAPES)
def test_nothing_is_warned_of_far_away(shape):
    """Where doubles are 2 apart, meshes are those of the origin; contacts too."""
    body = SHAPES[shape]
    there = body.translated((FAR, -FAR, FAR))
    ball = fc.sphere(1).translated((0, 5, 0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        far, near = there.to_mesh(0.1), body.to_mesh(0.1)
        hit = fc.first_contact(ball.translated((FAR, -FAR, FAR)).moving(fc.Translation((0, -10, 0))), there)
        assert hit.point is not None
    assert hit.time == pytest.approx(fc.first_contact(ball.moving(fc.Translation((0, -10, 0))), body).time, abs=1e-11)
    assert far.solid and np.allclose(far.translated((-FAR, FAR, -FAR)).vertices, near.vertices, atol=1e-12)


@pytest.mark.filterwarnings("error")
def test_edges_of_cylinders_that_are_turned_by_next_to_nothing_have_parameters():
    tube = fc.cylinder(1, 2)
    both = tube | tube.rotated((1, 2, 3), degrees=1e-14)
    parameters = [x for edge in both.edges for piece in edge.pieces for x in (piece.lo, piece.hi)]
    assert len(parameters) > 0 and not np.isnan(parameters).any()
    box = fc.examples.box((1, 1, 1)).translated((5, 0, 0)).moving(fc.Translation((-8, 0, 0)))
    assert fc.first_contact(box, both).time == pytest.approx(3.5 / 8, abs=1e-12)
