"""Results: no truth value, exact numbers that become the nearest double, pickling."""

from __future__ import annotations

import copy
import functools
import json
import math
import pickle
from fractions import Fraction

import pytest

import firstcontact as fc
from firstcontact.contact.later import LAST, LATER, changed

CUBE = fc.examples.box((1, 1, 1))
TARGET = CUBE.translated((3, 0.25, 0.125))


@functools.cache
def hits() -> dict[str, fc.FirstContact]:
    slide, swing = fc.Translation((7, 0, 0)), fc.Rotation((0, 0, 1), point=(0, 4, 0), turns="1/3")
    return {
        "contact": fc.first_contact(CUBE.moving(slide), TARGET, exact=True),
        "turn": fc.first_contact(CUBE.moving(swing), TARGET, exact=True),
        "free": fc.first_contact(CUBE.moving(fc.Translation((1, 0, 0))), TARGET),
        "start": fc.first_contact(CUBE.moving(slide), CUBE.translated((0.5, 0, 0))),
        "budget": fc.first_contact(CUBE.moving(slide), TARGET, budget=0),
    }


STATUS = {
    "contact": "CONTACT",
    "turn": "CONTACT",
    "free": "FREE",
    "start": "INITIAL_CONTACT",
    "budget": "UNDECIDED",
}


@pytest.mark.parametrize("name", STATUS)
def test_results_have_no_truth_value(name):
    hit = hits()[name]
    assert hit.status is fc.Status[STATUS[name]]
    for thing in (hit, hit.status):
        with pytest.raises(TypeError, match="no truth value"):
            bool(thing)
        with pytest.raises(TypeError, match="no truth value"):
            if thing:
                pass


def test_intervals_and_pairs_have_no_truth_value():
    moving = CUBE.moving(fc.Translation((7, 0, 0)))
    intervals, pairs = fc.contact_intervals(moving, TARGET), fc.contact_pairs(moving, TARGET)
    assert len(intervals) == 1 and len(pairs) > 0
    for thing in (intervals, intervals[0], pairs):
        with pytest.raises(TypeError, match="no truth value"):
            bool(thing)


@pytest.mark.parametrize("name", STATUS)
def test_results_survive_pickling(name):
    hit = hits()[name]
    again = pickle.loads(pickle.dumps(hit))
    assert again.to_dict() == hit.to_dict() and again.span == hit.span and str(again) == str(hit)
    assert again.time_exact == hit.time_exact
    assert again.status is hit.status


@pytest.mark.parametrize("name", STATUS)
def test_results_are_json(name):
    data = json.loads(hits()[name].to_json())
    assert data["status"] == STATUS[name]
    assert data["time"] == hits()[name].time


def unread(exact: bool = False) -> fc.FirstContact:
    return fc.first_contact(CUBE.moving(fc.Rotation((0, 0, 1), point=(0, 4, 0), turns="1/3")), TARGET, exact=exact)


@pytest.mark.parametrize("name", ["point", "normal", "element_a", "element_b", "others", "multiplicity", "contact_set"])
def test_what_is_worked_out_late_is_the_same_whatever_is_read_first(name):
    hit, other = unread(), hits()["turn"]
    first = getattr(hit, name)
    assert first is getattr(hit, name)  # once
    assert repr(first) == repr(getattr(other, name))
    shown = {**hit.to_dict(), "stats": None, "time_exact": None}
    assert shown == {**other.to_dict(), "stats": None, "time_exact": None}


@pytest.mark.parametrize("through", [copy.copy, copy.deepcopy, lambda hit: pickle.loads(pickle.dumps(hit))])
def test_results_that_nobody_read_survive_copying(through):
    again = through(unread())
    assert again.point.tolist() == hits()["turn"].point.tolist() and again.multiplicity == hits()["turn"].multiplicity


BLOCK = fc.box((1, 2, "3/2"))


def landed(exact: bool = False) -> fc.FirstContact:
    """A solid block on another one; its motion is changed when the answer is there."""
    moving = BLOCK.moving(fc.Translation((0.25, 0.5, 6)))
    hit = fc.first_contact(moving, BLOCK.translated((0.5, 0.125, 4)), exact=exact)
    moving.motion = fc.Translation((0, 0, 0))
    return hit


@pytest.mark.share(2)
@pytest.mark.parametrize("name", ["point", "normal", "others", "multiplicity", "contact_set"])
def test_what_curved_solids_share_is_told_late_and_the_same_whatever_is_read_first(name):
    hit, other, exact = landed(), landed(), landed(exact=True)
    before = {x: object.__getattribute__(hit, x) for x in ("status", "time", "time_interval", "element_a", "element_b")}
    with pytest.raises(AttributeError):  # nobody has asked
        object.__getattribute__(hit, name)
    first = getattr(hit, name)
    assert first is getattr(hit, name) and repr(first) == repr(getattr(other, name))
    assert all(getattr(hit, x) is value for x, value in before.items())
    assert hit.multiplicity == exact.multiplicity > 1 and set(hit.others) == set(exact.others)
    assert (hit.element_a, hit.element_b) == (exact.element_a, exact.element_b)
    assert hit.contact_set == exact.contact_set == "patch" and hit.point == pytest.approx(exact.point, abs=1e-12)


@pytest.mark.parametrize("through", [copy.copy, copy.deepcopy, lambda hit: pickle.loads(pickle.dumps(hit))])
def test_unread_results_of_curved_solids_survive_copying(through):
    again, other = through(landed()), landed()
    assert again.contact_set.points.tolist() == other.contact_set.points.tolist()
    for shown in (again.to_dict(), json.loads(again.to_json())):
        assert {**shown, "stats": None} == json.loads(json.dumps({**other.to_dict(), "stats": None}))
    assert repr(again.others) == repr(other.others) and "(and 3 more pairs)" in str(landed())


def test_an_attribute_that_results_do_not_have():
    hit = unread()
    with pytest.raises(AttributeError, match="'FirstContact' object has no attribute 'pont'"):
        hit.pont  # noqa: B018
    assert not hasattr(hit, "__array__")
    with pytest.raises(AttributeError):
        hit.point = None


def test_results_do_not_change():
    with pytest.raises(AttributeError):
        hits()["contact"].time = 3
    with pytest.raises(AttributeError):
        hits()["contact"].element_a.index = 3


def test_exact_time_of_a_translation_is_a_fraction():
    hit = hits()["contact"]
    assert hit.time_exact == Fraction(2, 7) and hit.time == 2 / 7
    lo, hi = hit.time_interval
    assert Fraction(lo) <= Fraction(2, 7) <= Fraction(hi)


def test_exact_time_of_a_turn_is_an_angle():
    hit = hits()["turn"]
    exact = hit.time_exact
    assert isinstance(exact, fc.ExactAngle)
    cosine, sine = float(exact.cosine), float(exact.sine)
    assert cosine**2 + sine**2 == pytest.approx(1, abs=1e-15)
    assert math.atan2(sine, cosine) / (2 * math.pi / 3) == pytest.approx(hit.time, rel=1e-15)
    assert float(exact) == hit.time


@pytest.mark.parametrize("kind", ["turns", "degrees"])
def test_quarter_turns_have_rational_times(kind):
    post = fc.Polyhedron([[1, 0, 0.5]], [])
    wall = fc.Polyhedron([[0, 0, 0], [0, 3, 0], [0, 0, 3]], [[0, 1, 2]])
    turn = fc.Rotation((0, 0, 1), **({"turns": "1/3"} if kind == "turns" else {"degrees": 120}))
    assert fc.first_contact(post.moving(turn), wall, exact=True).time_exact == Fraction(3, 4)


# ---------------------------------------------------------------------------------------- algebraic numbers


def root_of(polynomial, lo, hi) -> fc.AlgebraicNumber:
    return fc.AlgebraicNumber(tuple(polynomial), Fraction(lo), Fraction(hi))


@pytest.mark.parametrize(
    ("number", "square"),
    [
        (root_of((-2, 0, 1), 1, 2), 2),
        (root_of((-3, 0, 1), 0, 9), 3),
        (root_of((-1, 0, 10**40), 0, 1), Fraction(1, 10**40)),
    ],
)
def test_algebraic_numbers_become_the_nearest_double(number, square):
    x = float(number)
    below, above = (Fraction(math.nextafter(x, way)) for way in (-math.inf, math.inf))
    halfway = ((below + Fraction(x)) / 2) ** 2, ((above + Fraction(x)) / 2) ** 2
    assert halfway[0] <= square <= halfway[1]


def test_algebraic_numbers_at_the_ends_of_their_interval():
    assert float(root_of((-2, 1), 2, 3)) == 2.0
    assert float(root_of((-3, 1), 2, 3)) == 3.0
    assert float(root_of((-1, 3), 0, 1)) == 1 / 3
    assert float(root_of((2, 0, -1), -2, -1)) == -math.sqrt(2)
    assert float(root_of((0, 1), -1, 1)) == 0.0


def test_algebraic_numbers_print_their_polynomial():
    assert str(root_of((-2, 0, 1), 1, 2)) == "root of x^2 - 2 in [1, 2]"


def test_stats_read_both_ways():
    stats = hits()["contact"].stats
    assert stats.node_visits == stats["node_visits"] > 0
    assert set(stats) == {"node_visits", "pair_tests", "undecided", "exact_evaluations", "seconds", "engine", "ways"}
    with pytest.raises(KeyError):
        stats["nonsense"]


@pytest.mark.parametrize("keyword", [{"method": "magic"}, {"engine": "warp"}])
def test_unknown_methods_are_unsupported(keyword):
    with pytest.raises(fc.UnsupportedPair, match="unknown"):
        fc.first_contact(CUBE.moving(fc.Translation((1, 0, 0))), TARGET, **keyword)


@pytest.mark.parametrize("keyword", [{"tolerance": 0}, {"tolerance": -1}, {"budget": -1}, {"budget": 1.5}])
def test_bad_settings_are_named(keyword):
    with pytest.raises(fc.InputError, match=next(iter(keyword))):
        fc.first_contact(CUBE.moving(fc.Translation((1, 0, 0))), TARGET, **keyword)


def test_a_name_is_no_body():
    with pytest.raises(fc.UnsupportedPair, match="'lid' is no body"):
        fc.first_contact("lid", CUBE)


def test_a_contact_of_elements_that_are_not_told_says_so():
    hit = fc.FirstContact(fc.Status.CONTACT, time=0.5, time_interval=(0.5, 0.5), free_until=0.5)
    assert "which elements meet is not told" in str(hit) and "None" not in str(hit)


def test_what_costs_another_question_goes_on_waiting():
    """Answers with other fields are made of others in many places, of parts as well."""
    asked = []

    def places():
        asked.append("places")
        return {name: None for name in LATER} | {"_rest": last}

    def last():
        asked.append("last")
        return {LAST: True}

    known = {name: None for name in fc.FirstContact.__dataclass_fields__ if name not in (*LATER, LAST)}
    known |= {"status": fc.Status.INITIAL_CONTACT, "keeps_bodies": False}
    found = changed(changed(fc.FirstContact.deferring(known, places, LAST), time=1.0), joints=())
    assert (found.time, found.status, asked) == (1.0, fc.Status.INITIAL_CONTACT, [])
    assert found.point is None and asked == ["places"]
    assert found.within_deviation and asked == ["places", "last"]
