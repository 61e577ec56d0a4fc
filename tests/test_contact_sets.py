"""Areas that solids share are patches, whatever bounds them; contacts at two places are both named."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc

DOWN = fc.Translation((0, 0, -3))
FLIP = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]
DISC, PLATE, HIGH = fc.cylinder(1, 2), fc.box((5, 5, 2)), (0, 0, 4)
RING = DISC - fc.cylinder("1/2", 5)
CONE = fc.cone(1, 1).transformed(FLIP)
BALL, BLOCK = fc.sphere(1), fc.box((4, 4, 4))
SCENES = {
    "disc on plate": (DISC.translated(HIGH), PLATE, "patch", 1),
    "disc over an edge": (DISC.translated(("5/2", 0, 4)), PLATE, "patch", 2),
    "disc on a larger one": (DISC.translated(HIGH), fc.cylinder(2, 2), "patch", 1),
    "disc across another": (DISC.translated(("3/2", 0, 4)), fc.cylinder(2, 2), "patch", 2),
    "equal discs": (DISC.translated(HIGH), DISC, "patch", 3),
    "ring on plate": (RING.translated(HIGH), PLATE, "patch", 2),
    "rings": (RING.translated(HIGH), fc.cylinder(2, 2) - fc.cylinder("3/4", 5), "patch", 2),
    "disc in a smaller hole": (DISC.translated(HIGH), PLATE - fc.cylinder("3/4", 5), "patch", 2),
    "ball on the rim of a hole": (BALL.translated((0, 0, 5)), BLOCK - fc.cylinder("3/5", 9), "conic arc", 1),
    "cone in its seat": (CONE.translated((0, 0, 5)), BLOCK - CONE.translated((0, 0, 2)), "patch", 7),
    "ball in its seat": (BALL.translated((0, 0, 5)), BLOCK - BALL.translated((0, 0, "5/2")), "patch", 1),
    "lying cylinder": (DISC.rotated((1, 0, 0), degrees=90).translated(HIGH), PLATE, "segment", 2),
}


@pytest.mark.share(4)
@pytest.mark.parametrize("name", SCENES)
def test_kinds_and_numbers(name):
    a, b, kind, count = SCENES[name]
    moving = a.moving(DOWN)
    hits = fc.first_contact(moving, b), fc.first_contact(b, moving), fc.first_contact(moving, b, exact=True)
    assert [hit.contact_set for hit in hits] == [kind] * 3
    assert [hit.multiplicity for hit in hits] == [count] * 3


@pytest.mark.share(5)
@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("width", [F(1, 100), F(1, 10**6), F(1, 10**9), F(1, 10**12)])
def test_patches_may_be_thin(width, exact):
    """Pegs on the rims of holes that are too narrow for them by so much, one all round, one on a side alone."""
    hole, square = BLOCK - fc.cylinder(1 - width, 9), BLOCK - fc.box((2 - 2 * width, 2 - 2 * width, 9))
    aside = fc.box((2, 2, 2)).translated((width, 0, 5))
    for peg, block in ((DISC, hole), (fc.box((2, 2, 2)), square), (aside, BLOCK - fc.box((2, 2, 9)))):
        above = peg if peg is aside else peg.translated((0, 0, 5))
        assert fc.first_contact(above.moving(DOWN), block, exact=exact).contact_set == "patch"


@pytest.mark.share(5)
@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("width", [F(1, 10**8), F(1, 100), F(1, 10**6), F(1, 10**10)])
def test_lenses_may_be_thin(width, exact):
    """A disc that lands by so much on the rim of another one, on an edge, and on the sides of a square hole."""
    aside = DISC.translated((2 - width, 0, 4))
    assert fc.first_contact(aside.moving(DOWN), DISC, exact=exact).contact_set == "patch"
    assert fc.first_contact(aside.moving(DOWN), PLATE.translated((F(7, 2), 0, 0)), exact=exact).contact_set == "patch"
    square = BLOCK - fc.box((2 - 2 * width, 2 - 2 * width, 9))
    assert fc.first_contact(DISC.translated((0, 0, 5)).moving(DOWN), square, exact=exact).contact_set == "patch"


@pytest.mark.parametrize("exact", [False, True])
def test_a_peg_as_wide_as_its_hole_meets_its_rim(exact):
    hit = fc.first_contact(DISC.translated((0, 0, 5)).moving(DOWN), BLOCK - fc.cylinder(1, 9), exact=exact)
    assert hit.contact_set == "conic arc"


def test_points_of_a_round_patch_go_around_it():
    hit = fc.first_contact(DISC.translated(HIGH).moving(DOWN), PLATE)
    points = hit.contact_set.points
    assert np.allclose(np.linalg.norm(points[:, :2], axis=1), 1) and np.allclose(points[:, 2], 1)
    turns = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
    assert np.all(np.diff(turns) > 0) or np.all(np.diff(turns) < 0)


@pytest.mark.share(2)
@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("swap", [False, True])
def test_a_ball_in_a_groove_touches_both_sides(exact, swap):
    groove = BLOCK - (fc.half_space((3, 0, -4), 0) & fc.half_space((-3, 0, -4), 0))
    ball = fc.sphere(F(1, 2)).translated((0, 0, 6)).moving(fc.Translation((0, 0, -6)))
    hit = fc.first_contact(*((groove, ball) if swap else (ball, groove)), exact=exact)
    assert hit.multiplicity == 2 and len(hit.others) == 1 and hit.time == pytest.approx(43 / 48, abs=1e-15)
