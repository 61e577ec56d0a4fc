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
