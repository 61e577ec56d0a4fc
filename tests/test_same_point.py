"""All pairs of features that meet at one point: the certified path names those that algebra does."""

from __future__ import annotations

import numpy as np
import pytest

import firstcontact as fc
from amount import amount

BALL, BOX, DRUM = fc.sphere(1), fc.box((2, 2, 2)), fc.cylinder(1, 2)
ON_ITS_CORNER = [["2/3", "-1/3", "2/3", 0], ["2/3", "2/3", "-1/3", 0], ["-1/3", "2/3", "2/3", 0], [0, 0, 0, 1]]
CORNER = fc.box((4, 4, 2)) - fc.box((4, 4, 4)).translated((2, 2, 0))
SHAPES = [BALL, BOX, DRUM, DRUM.rotated((0, 1, 0), degrees=90), CORNER, BOX.transformed(ON_ITS_CORNER)]
DOWN = fc.Translation((0, 0, -4))


def pairs(hit) -> set[tuple[str, str]]:
    rest = [(str(p.element_a), str(p.element_b)) for p in hit.others]
    return {*rest, (str(hit.element_a), str(hit.element_b))}


@pytest.mark.parametrize(("where", "other", "count"), [
    ((1, 1, 4), BOX, 4), ((1, 0, 4), BOX, 2), ((0, 0, 4), BOX, 1), ((1.5, 0.3, 4), BOX, 1),
    ((0, 0, 4), CORNER, 4), ((0, 1, 4), CORNER, 2), ((0, -1, 4), CORNER, 1), ((0, 1, 4), DRUM, 2),
])  # fmt: skip
def test_a_ball_that_lands_beside_or_on_an_edge(where, other, count):
    moving = BALL.translated(where).moving(DOWN)
    told, exact = fc.first_contact(moving, other), fc.first_contact(moving, other, exact=True)
    assert pairs(told) == pairs(exact) and told.multiplicity == exact.multiplicity == count
    assert told.element_b == exact.element_b and told.contact_set == exact.contact_set == "point"
    assert told.time == pytest.approx(exact.time, abs=1e-12)
    assert told.stats.exact_evaluations == 0  # of a search of all features


@pytest.mark.share(3)
@pytest.mark.parametrize("seed", range(amount(30)))
def test_both_paths_name_the_same_on_a_lattice(seed):
    rng = np.random.default_rng(seed)
    a, b = (SHAPES[k] for k in rng.integers(0, len(SHAPES), 2))
    way = np.append(rng.integers(-1, 2, 2), -6)
    start = np.append(rng.integers(-1, 3, 2), 6) - 0.5 * np.append(way[:2], 0)
    moving = a.translated(start.tolist()).moving(fc.Translation(way.tolist()))
    told, exact = fc.first_contact(moving, b), fc.first_contact(moving, b, exact=True)
    assert told.status is exact.status
    if told.status is fc.Status.CONTACT:
        assert pairs(told) == pairs(exact) and told.contact_set == exact.contact_set


def test_where_algebra_does_not_go_one_pair_is_named():
    moving = BALL.translated((1, 2, 4)).moving(fc.Screw((0, 0, 1), (0, 2, 0), degrees=30, advance=-4))
    hit = fc.first_contact(moving, fc.box((2, 6, 2)))
    assert hit.status is fc.Status.CONTACT and hit.multiplicity == 1


@pytest.mark.share(2)
@pytest.mark.parametrize("swap", [False, True], ids=["", "swapped"])
def test_that_one_pair_meets_is_not_told_where_that_is_not_known(swap):
    """A vertex lands on a vertex under a screw: which of the events there is named depends on rounding."""
    cut = fc.box((5, "5/2", "5/2")).transformed([
        ["-33/65", 0, "56/65", "-17/13"], [0, -1, 0, "-15/4"], ["56/65", 0, "33/65", "-171/52"], [0, 0, 0, 1],
    ])  # fmt: skip
    stub = fc.frustum("1/2", "23/26", "12/13").transformed([
        ["-6/7", "-3/7", "2/7", "-151/91"], ["-3/7", "2/7", "-6/7", "-107/42"],
        ["2/7", "-6/7", "-3/7", "-93/182"], [0, 0, 0, 1],
    ]) - cut  # fmt: skip
    tip = fc.Polyhedron(
        [("-219/98", "349/98", "-697/98"), ("-411/98", "365/98", "-661/98"), ("-3/2", "-5/2", "-1/2"),
         ("-134/49", "1041/196", "-501/98")], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)],
    ).transformed([
        ["16/81", "79/81", "8/81", "100/81"], ["-47/81", "16/81", "-64/81", "253/81"],
        ["-64/81", "8/81", "49/81", "911/324"], [0, 0, 0, 1],
    ])  # fmt: skip
    a, b = stub, tip.moving(fc.Screw(("-4/9", "-4/9", "7/9"), ("7/2", "3/2", 0), degrees=360, advance=-1))
    hit = fc.first_contact(*((b, a) if swap else (a, b)))
    assert hit.status is fc.Status.CONTACT and hit.point == pytest.approx([-1.5, -2.5, -0.5], abs=1e-9)
    assert hit.multiplicity > 1 or hit.contact_set is None


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize(("s", "alone"), [((-3, 3), False), ((-3, 4), True)], ids=["its vertex", "its end ruling"])
def test_a_ruled_surface_that_lands_on_a_ball(s, alone, swapped):
    """By its vertex, whose two borders touch as well: doubles named one of them and said that it was alone."""
    sheet = fc.RuledSurface(
        "(((-1) + (-5/2)*u)/((2) + (-1)*u), ((4) + (-1/2)*u)/((2) + (-1)*u), ((7) + (-7/2)*u)/((2) + (-1)*u))",
        "(((-5/3) + (-13/6)*u)/((2) + (-1)*u), ((8/3) + (1/6)*u)/((2) + (-1)*u), ((7) + (-7/2)*u)/((2) + (-1)*u))",
        u=(-1, 1), s=s,
    ).moving(fc.Translation((1, 1, -1)))  # fmt: skip
    bodies = (fc.sphere(3), sheet) if swapped else (sheet, fc.sphere(3))
    hit, exact = fc.first_contact(*bodies), fc.first_contact(*bodies, exact=True)
    assert hit.time == exact.time == 0.5 and exact.contact_set == "point"
    assert hit.contact_set == ("point" if alone else None)
    if alone:
        assert pairs(hit) == pairs(exact)
