"""Intervals of small solids cost little more than their first contacts: what holds between candidates is soon told."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.contact.models import algorithm, at_rest
from firstcontact.contact.models.algorithm import CandidateSearch
from firstcontact.contact.models.first import intervals
from firstcontact.exact.numbers import Undecidable
from firstcontact.work import Query


def capped():
    """A slab with a pin goes three quarters round, past a cut cone in which it ends."""
    slab = fc.cylinder("1/2", 1) | fc.box((3, 3, 1)).translated(("1/2", "-3/4", 0))
    turned = fc.box((2, 3, 1)).rotated((1, 1, 0), degrees=45).translated((-1, "3/4", "-1/4"))
    way = fc.Rotation((1, -1, 0), point=(-0.25, -0.75, -0.5), turns=0.75)
    return slab.translated((-1, -1, 0)).moving(way), fc.frustum(1, 0, 1) & turned


def through():
    """A lens with a cone passes a cone with a pin."""
    lens = fc.box((2, 3, 2)) & fc.sphere("3/2").rotated((1, 1, 0), degrees=90).translated(("-1/2", -1, 0))
    cone = fc.frustum(2, 0, 1).rotated((1, 0, 0), degrees=45).translated(("-1/4", "-1/2", "1/2"))
    other = fc.frustum(2, 0, 2).rotated((1, 1, 0), degrees=45).translated(("1/2", "3/4", 0))
    a = (lens | cone).translated((0, -1, -3)).moving(fc.Translation((1, 3, 6)))
    return a, fc.cylinder("1/2", 2) | other


def hollow():
    """A block with two hollows goes round, past a ball with one."""
    block = fc.box((1, 1, 3)) - fc.sphere(1).rotated((1, 0, 0), degrees=45).translated(("1/2", 1, 1))
    block -= fc.sphere("1/2").translated(("-3/4", "1/2", "1/4"))
    way = fc.Rotation((0, 0, 1), point=(-1.25, 1, -0.25), turns=1)
    return block.translated((-3, 3, 0)).moving(way), fc.sphere(1) - fc.sphere("3/2").translated(("-1/4", 1, 1))


@pytest.mark.thorough
@pytest.mark.parametrize(("scene", "end"), [(capped, 1.0), (through, None), (hollow, None)])
def test_between_candidates_no_intersection_is_built(scene, end, monkeypatch):
    """The start is that of the first contact, the end that of doubles alone; solids are intersected once or twice."""
    built = []
    solid = at_rest._solid

    def counted(combination):
        built.append(1)
        return solid(combination)

    monkeypatch.setattr(at_rest, "_solid", counted)
    (only,) = fc.contact_intervals(*scene())
    assert len(built) <= 2
    hit = fc.first_contact(*scene())
    assert abs(only.start - hit.time) < 1e-11
    if end is None:
        (alone,) = fc.contact_intervals(*scene(), method="certified")
        assert abs(only.start - alone.start) < 1e-11 and abs(only.end - alone.end) < 1e-11
    else:
        assert only.end == end


def test_gaps_between_contacts():
    """A disc passes along a bar that three holes, wider than bar and disc, cut into four."""
    bar = fc.box((12, 2, 2))
    for x in (-4, 0, 4):
        bar -= fc.cylinder("3/2", 4).translated((x, 0, 0))
    disc = fc.cylinder(1, 1).translated((-10, 0, 0)).moving(fc.Translation((20, 0, 0)))
    found = fc.contact_intervals(disc, bar)
    parts = [(-6, -5.5), (-2.5, -1.5), (1.5, 2.5), (5.5, 6)]
    due = [((lo - 1 + 10) / 20, (hi + 1 + 10) / 20) for lo, hi in parts]
    assert np.allclose([(x.start, x.end) for x in found], due, rtol=0, atol=1e-12)


def test_what_candidates_leave_open_is_asked_between_them(monkeypatch):
    """As if nothing were told of any candidate: models that were apart are not taken to stay so."""
    monkeypatch.setattr(CandidateSearch, "meetings", lambda search, group: [])
    monkeypatch.setattr(CandidateSearch, "doubt", lambda search, group: "left open")
    ball = fc.sphere(1).translated((-5, 0, 0)).moving(fc.Translation((10, 0, 0)))
    (only,) = fc.contact_intervals(ball, fc.box((2, 2, 2)), exact=True)
    assert (only.start, only.end) == (0.3, 0.7)


def test_a_candidate_that_stays_open_between_free_times_leaves_the_answer_open(monkeypatch):
    """Balls that graze at 1/2 alone, as if that were not told: FREE would be wrong."""
    ball, other = fc.sphere(1).translated((-5, 0, 0)), fc.sphere(1).translated((0, 2, 0))
    passing = ball.moving(fc.Translation((10, 0, 0)))
    (graze,) = fc.contact_intervals(passing, other, method="algebraic")
    assert (graze.start, graze.end) == (0.5, 0.5)
    monkeypatch.setattr(CandidateSearch, "meetings", lambda search, group: [])
    monkeypatch.setattr(CandidateSearch, "doubt", lambda search, group: "left open")
    with pytest.raises(fc.UnsupportedPair, match="left open"):
        fc.contact_intervals(passing, other, method="algebraic")


def test_an_open_candidate_at_the_only_instant_leaves_the_answer_open(monkeypatch):
    """The same balls at 1/2, as if nothing were told of any candidate, and no common inner point were found."""
    passing = fc.sphere(1).translated((-5, 0, 0)).moving(fc.Translation((10, 0, 0)))
    other, instant = fc.sphere(1).translated((0, 2, 0)), (F(1, 2), F(1, 2))
    assert len(fc.contact_intervals(passing, other, instant, method="algebraic")) == 1
    query = Query(passing, other, fmpq(1, 2), fmpq(1, 2), method="algebraic")  # as parts of longer spans are asked
    assert len(intervals(query)) == 1

    def open_(candidate):
        raise Undecidable("left open")

    monkeypatch.setattr(algorithm, "_validated", open_)
    monkeypatch.setattr(CandidateSearch, "share_a_point", lambda search, u, passed=None: False)
    assert fc.contact_intervals(passing, other, instant, method="algebraic").status is fc.Status.UNDECIDED
    with pytest.raises(fc.UnsupportedPair, match="not told"):
        intervals(query)


def test_solids_whose_common_part_is_too_thin_to_be_traced_are_left_undecided():
    """A ball a billionth smaller than the hole that it comes through, against its wall: it ended in an error."""
    plate = fc.box((192, 192, 384)) - fc.cylinder(24, 960)
    way = fc.Translation((F(1152, 13000000013), F(480, 13000000013), -48))
    ball = fc.sphere(F(24000000000, 1000000001)).translated((0, 0, 60)).moving(way)
    found = fc.contact_intervals(plate, ball)
    assert found.status is fc.Status.UNDECIDED or found.intervals[0].start_interval[0] <= 0.25
    assert fc.first_contact(plate, ball).time == 0.25


def test_what_may_last_and_is_left_open_is_not_taken_for_apart(monkeypatch):
    """A pin that turns in a bore of its own radius: one surface slides in the other, which no root tells."""
    pin, plate = fc.cylinder(1, 2), fc.box((6, 6, 2)) - fc.cylinder(1, 4)
    turning = pin.moving(fc.Rotation((0, 0, 1), turns=1))
    assert fc.contact_intervals(turning, plate, method="algebraic").status is fc.Status.INITIAL_CONTACT
    whole = algorithm._validated

    def validated(candidate):
        if candidate.subproblem.equation.may_hold_always:
            raise Undecidable
        return whole(candidate)

    monkeypatch.setattr(algorithm, "_validated", validated)
    assert fc.contact_intervals(turning, plate).status is fc.Status.UNDECIDED
    with pytest.raises(fc.UnsupportedPair, match="not proved whether they touch"):
        fc.contact_intervals(turning, plate, method="algebraic")
