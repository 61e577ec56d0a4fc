"""Turns whose span begins or ends where the bodies touch: in the first pose, half and whole turns later, across 0.

What touches at 0 does so at every whole turn: that is the oracle.
"""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc

ENGINES = ("auto", "boxes", "lifted", "composed", "sweep")
LID = fc.examples.box((4, 2, 1)).translated((5, 0, F(1, 2)))
BASE = fc.examples.box((4, 2, 1)).translated((5, 0, F(-1, 2)))
ABOUT_Y = (0, 1, 0)


SPANS = [(-1, 0), (-7, -6), (F(-1, 2), 0), (-5, 0), (F(-23, 4), 0), (F(45, 4), 12)]
ASKED = [(SPANS[0], engine) for engine in ENGINES] + list(zip(SPANS[1:], ENGINES, strict=True))


@pytest.mark.share(6)
@pytest.mark.parametrize("span, engine", ASKED)
def test_a_lid_that_closes_with_the_last_instant(span, engine):
    """By 60 degrees a unit of time; in the last of them it comes down from above."""
    first, last = span
    lid, base = LID, BASE
    turn = fc.Rotation(ABOUT_Y, degrees=60)
    hit = fc.first_contact(lid.moving(turn), base, span, engine=engine)
    intervals = fc.contact_intervals(lid.moving(turn), base, span)
    back = fc.first_contact(base.moving(fc.Rotation(ABOUT_Y, degrees=-60)), lid, span, engine=engine)
    assert hit.status is back.status is intervals.status
    assert hit.time == back.time == intervals[0].start
    if last - first <= 1:
        assert (hit.status, hit.time) == (fc.Status.CONTACT, float(last))
        assert [(w.start, w.end) for w in intervals] == [(float(last), float(last))]
        met = {(p.element_a, p.element_b) for p in fc.contact_pairs(lid.moving(turn), base, span)}
        assert {(hit.element_a, hit.element_b), *((p.element_a, p.element_b) for p in hit.others)} <= met
    assert intervals[-1].end == float(last)


def wedges(rng):
    """Two bodies on both sides of the plane z = 0 that touch there: a point, an edge or a face of each in it."""

    def body(sense):
        x = 3 + rng.integers(0, 2, 3) * 2
        low = np.array([[x[0], -1, 0], [x[1], 1, 0], [x[2] + 1, 0, 0]]) + rng.integers(-1, 2, (3, 3)) * [1, 1, 0]
        count = rng.integers(1, 4)
        low[count:, 2] = sense * rng.integers(1, 3)
        top = [float(rng.integers(3, 6)), float(rng.integers(-1, 2)), sense * 3.0]
        return fc.Polyhedron([*low.astype(float).tolist(), top], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])

    return body(1), body(-1)


@pytest.mark.thorough
def test_spans_about_the_pose_in_which_bodies_touch():
    """What touches before the first turn does so n turns later, where spans end and where they begin; first contact,
    intervals and pairs tell the same."""
    landed = 0
    for seed in range(24):
        rng = np.random.default_rng(seed)
        a, b = wedges(rng)
        touches = fc.first_contact(a.moving(fc.Translation((0, 0, 0))), b).status is not fc.Status.FREE
        degrees = int(rng.choice([40, 60, 72, 90, -60, 180]))
        period = F(360, abs(degrees))
        moved = a.moving(fc.Rotation(ABOUT_Y, degrees=degrees))
        n = int(rng.integers(-2, 3))
        end = n * period
        begin = end - F(int(rng.integers(1, 8)), 8) * period / int(rng.choice([1, 3, 7]))
        engine = ENGINES[seed % len(ENGINES)]
        hit = fc.first_contact(moved, b, (begin, end), engine=engine)
        intervals = fc.contact_intervals(moved, b, (begin, end))
        assert hit.status is intervals.status, seed
        if touches:
            landed += 1
            assert intervals[-1].end == float(end), seed
            assert hit.time == intervals[0].start, seed
            pairs = fc.contact_pairs(moved, b, (begin, end))
            assert len(pairs.pairs) + len(pairs.piercing) > 0, seed
            later = fc.first_contact(moved, b, (end, end + F(1, 7)), engine=engine)
            assert later.status is fc.Status.INITIAL_CONTACT and later.time == float(end), seed
    assert landed > 8


def test_an_octahedron_under_a_screw_lands_at_the_end_in_both_orders():
    """Its tip comes from z = 4 down to the top of the box, z = 1, at the last instant."""
    corners = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    moving = fc.Polyhedron(corners, faces).translated((0, 0, 5)).moving(fc.Screw((0, 0, 1), degrees=90, advance=-3))
    for pair in ((moving, fc.examples.box((2, 2, 2))), (fc.examples.box((2, 2, 2)), moving)):
        found = fc.first_contact(*pair)
        assert found.status is fc.Status.CONTACT and found.time == 1
        assert found.time_interval[0] <= 1 <= found.time_interval[1]
