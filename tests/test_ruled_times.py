"""Exact times of contact of ruled surfaces: known vectors, rulings that coincide, Delta = 0, and weak contacts."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.contact.ruled import first as moving
from firstcontact.contact.signs.conditions import conditions
from firstcontact.contact.signs.times import Times
from firstcontact.contact.signs.touches import touch
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.fields.number_field import is_zero
from firstcontact.search.rulings.directrices import directrix_pieces
from ruled_vectors import numbers, value, vectors

MOVING = {v.name[:3]: v for v in vectors("moving")}
LARGE = ("m13", "m14")
"""Elimination leads too far."""


@pytest.mark.share(2)
@pytest.mark.parametrize("name", [n for n in MOVING if n not in LARGE])
def test_known_intervals(name):
    vector = MOVING[name]
    found = fc.contact_intervals(vector.p, vector.q, vector.span, exact=True)
    expected = vector.expected["exact"] or vector.expected["collision_T"]
    for interval, ends in zip(found, expected, strict=True):
        for exact, enclosure, text in (
            (interval.start_exact, interval.start_interval, ends[0]),
            (interval.end_exact, interval.end_interval, ends[1]),
        ):
            assert float(exact) == pytest.approx(float(value(text)), abs=1e-15)
            assert enclosure[0] <= float(value(text)) <= enclosure[1]
    free = [t for t, d in vector.expected["distance_samples"] if d > 1e-6]
    assert not any(i.start <= t <= i.end for t in free for i in found)


@pytest.mark.parametrize("name", ["m01", "m02", "m05", "m07", "m12", "m15"])
def test_known_first_contact(name):
    vector = MOVING[name]
    hit = fc.first_contact(vector.p, vector.q, vector.span, exact=True)
    event = vector.expected["events"][0]
    assert hit.status is fc.Status.CONTACT
    assert hit.time == pytest.approx(float(event["T"]), abs=1e-15)
    assert np.allclose(hit.point, numbers(event["point"]), atol=1e-12)
    kind = {(): "face", ("s",): "directrix", ("u",): "end_ruling", ("s", "u"): "vertex"}
    kind |= {("t",): "directrix", ("v",): "end_ruling", ("t", "v"): "vertex"}
    active = event["active"]
    assert hit.element_a.kind == kind[tuple(sorted(set(active) & {"u", "s"}))]
    assert hit.element_b.kind == kind[tuple(sorted(set(active) & {"v", "t"}))]


def test_the_minimal_polynomials_of_example_4():
    p, q = (fc.RuledSurface(x.first, x.second, u=None) for x in (MOVING["m01"].p, MOVING["m01"].q))
    (interval,) = fc.contact_intervals(p, q, (-2, 2), exact=True)
    assert interval.start_exact.polynomial == interval.end_exact.polynomial == (-1, 0, 2)
    assert str(interval).startswith("[-sqrt(2)/2, sqrt(2)/2]\n")
    hit = fc.first_contact(p, q, (-2, 2), exact=True)
    assert hit.time_exact == interval.start_exact
    assert np.allclose(hit.point, [2**0.5 / 2 - 1, 2**0.5 / 2, 0.5])


def test_a_contact_on_the_seam_of_charts_is_found_once():
    """u = 1 at the first contact of that example: an end of the chart of u, and of that of 1/u."""
    p, q = (fc.RuledSurface(x.first, x.second, u=None) for x in (MOVING["m01"].p, MOVING["m01"].q))
    span = fmpq(-2), fmpq(2)
    (piece,) = directrix_pieces(p, q, *span)
    times = Times(conditions(p, q, piece, span), span)
    start, _ = next(times.windows())
    (contact,) = times.contacts(start)
    assert contact.inverse == (False, False) and is_zero(contact.u - 1)


def test_what_is_too_large_for_elimination_is_said():
    vector = MOVING["m14"]
    with pytest.raises(UnsupportedPair, match="too large for elimination"):
        fc.contact_intervals(vector.p, vector.q, vector.span, exact=True)


@pytest.mark.parametrize(("name", "kinds"), [("m13", ("directrix", "face")), ("m14", ("face", "vertex"))])
def test_large_eliminations_are_left_to_doubles(name, kinds):
    vector = MOVING[name]
    hit = fc.first_contact(vector.p, vector.q, vector.span)
    assert hit.time_interval[0] <= float(vector.expected["first_contact_T"]) <= hit.time_interval[1]
    assert (hit.element_a.kind, hit.element_b.kind) == kinds


def ruled(first, second, u=(0, 1), s=(0, 1)):
    return fc.RuledSurface(first, second, u=u, s=s)


UNIT = (-1, 1)
CONE = "((1-u**2)/(1+u**2), 2*u/(1+u**2), 1)", "(2*(1-u**2)/(1+u**2), 4*u/(1+u**2), 2)"
PIPE = "((1-u**2)/(1+u**2), 2*u/(1+u**2), 0)", "((1-u**2)/(1+u**2), 2*u/(1+u**2), 1)"
FAR_PIPE = ("((1-u**2)/(1+u**2) + T, 2*u/(1+u**2), 1/2)", "((1-u**2)/(1+u**2) + T, 2*u/(1+u**2), 3/2)")
SADDLE = "(u, 0, 0)", "(u, 1, u)"
# On z = y (x - T) and y = z (x - 3) the rulings u = 0 and v = 0 are parts of the x axis; (x - T)(x - 3) = 1 elsewhere.
TWISTED = "(3, 0, u)", "(4, u, u)"
# name: two surfaces, span, intervals derived by hand
CASES = {
    "crossing planes, all rulings parallel": (
        ruled("(T, u, 0)", "(T + 1, u, 0)", UNIT), ruled("(3, 0, u)", "(4, 0, u)", UNIT), (0, 5), [(2, 4)]),
    "one common ruling at all times": (
        ruled("(T, u, 0)", "(T + 1, u, u)", UNIT), ruled(*TWISTED, UNIT), (0, 5), [(2, 4)]),
    "the common ruling runs through the piece": (
        ruled("(0, u + T, 0)", "(1, u + T, u + T)"), ruled("(1/2, 0, u)", "(3/2, u, u)", UNIT), (-3, 2), [(-1, 0)]),
    "common rulings touch end to end for an instant": (
        ruled("(T**2 + 1, u, 0)", "(T**2 + 2, u, u)", UNIT), ruled("(0, 0, u)", "(1, u, u)", UNIT), UNIT, [(0, 0)]),
    "common rulings with a gap": (
        ruled("(T**2 + 5/4, u, 0)", "(T**2 + 2, u, u)", UNIT), ruled("(0, 0, u)", "(1, u, u)", UNIT), UNIT, []),
    "fans with one apex, outside both": (
        ruled("(u, 0, 1)", "(2*u, 0, 2)", UNIT), ruled("(T/2, u/2, 1/2)", "(3*T, 3*u, 3)", UNIT), (-2, 2), [(-1, 1)]),
    "rulings of one cone, end to end": (
        ruled(*CONE, None), ruled("(0, (3-T)*u, 3-T)", "(0, (4-T)*u, 4-T)", (-2, 2)), (0, 2), [(1, 2)]),
    "cones with one apex, inside one": (
        ruled("(0, 0, 0)", CONE[0], None), ruled("(0, u, 3 - T)", "(0, 2*u, 6 - 2*T)", UNIT), (0, "5/2"), [(2, 2.5)]),
    "parallel pipes": (ruled(*PIPE, None), ruled(*FAR_PIPE, None), (-3, 3), [(-2, 2)]),
    "the two reguli of a saddle": (
        ruled(*SADDLE), ruled("(T, u, T*u)", "(T + 1, u, (T + 1)*u)"), (-3, 3), [(-1, 1)]),
    "a saddle along itself, across the rulings": (
        ruled(*SADDLE), ruled("(u + T, 0, 0)", "(u + T, 1, u + T)"), (-3, 3), [(-1, 1)]),
    "a saddle along itself, along the rulings": (
        ruled(*SADDLE), ruled("(u, T, T*u)", "(u, T + 1, (T + 1)*u)"), (-3, 3), [(-1, 1)]),
    "a corner slides over a plane": (
        ruled("(T + u, 0, u)", "(T + u, 1, 1 + u)"), ruled("(u, -1, 0)", "(u, 1, 0)", UNIT), (-3, 3), [(-1, 1)]),
    "a corner slides along an edge, irrational ends": (
        ruled("(T**3 + u, 0, u)", "(T**3 + u, 1, 1 + u)"), ruled("(u, -1, 0)", "(u, 0, 0)", (-1, 2)), (-3, 3),
        [(-1, 2 ** (1 / 3))]),
    "an edge slides on a plane": (
        ruled("(u, T, 0)", "(u, T, 1)", UNIT), ruled("(u, -1, 0)", "(u, 1, 0)", UNIT), (-3, 3), [(-1, 1)]),
    "coplanar discs of rulings touch at irrational times": (
        ruled("(u, 0, 0)", "(u, 1 - u**2, 0)", UNIT), ruled("(u, T**2, 0)", "(u, T**2 + 1, 0)"), (0, 3),
        [(0, 1)]),
    "a pipe slides along a plane that touches it": (
        ruled(*PIPE, (0, 1)), ruled("(1, u, T)", "(1, u, T + 1)", UNIT), (-3, 3), [(-1, 1)]),
}  # fmt: skip


@pytest.mark.share(12)
@pytest.mark.parametrize("name", CASES)
def test_degenerate_pairs(name):
    a, b, span, expected = CASES[name]
    for p, q in ((a, b), (b, a)):
        found = fc.contact_intervals(p, q, span)
        assert [(i.start, i.end) for i in found] == expected
        hit = fc.first_contact(p, q, span)
        if not expected:
            assert hit.status is fc.Status.FREE
            continue
        assert hit.time == expected[0][0]
        assert hit.point is not None


def test_rulings_that_miss_by_a_millionth():
    """A corner leaves a surface shortly before the span ends: T^3/3 + T^2/6 - T + 1/2 + 2^-20 = 0."""
    surface = fc.RuledSurface("(u, u*u, 0)", "(u, 1 + u, u)", u=(0, 1))
    low, high = "(u + T - 1/2, 1 + u + 1/2**20, -1)", "(u + T - 1/2, 1 + u + 1/2**20 + T*T, 2)"
    (interval,) = fc.contact_intervals(surface, fc.RuledSurface(low, high, u=(0, 1)), (0, 1), exact=True)
    assert interval.end_exact.polynomial == (3 * 2**19 + 3, -6 * 2**19, 2**19, 2**20)


def test_overlapping_rulings_share_a_segment():
    a, b, _, _ = CASES["one common ruling at all times"]
    end_to_end = fc.first_contact(a, b, (0, 5), exact=True)
    assert end_to_end.time_exact == Fraction(2) and end_to_end.point.tolist() == [3, 0, 0]
    assert str(end_to_end.contact_set) == "point"
    overlap = fc.first_contact(a, b, ("5/2", 5), exact=True)
    assert overlap.initial == "touching" and str(overlap.contact_set) == "segment"
    assert sorted(overlap.contact_set.points[:, 0].tolist()) == [3, 3.5]


def test_numbers_of_contacts_are_short(monkeypatch):
    """An apex lands on a fan run through twice.  One contact is in a field of degree 16, where unreduced polynomials of
    degree 868 took 20 s."""
    fan = ruled("(1 - u**2, 1 + u**2, 2*u**2)", "(-2 - u**2, -2 + 2*u**2, 2)", UNIT).translated((-4, 2, 3))
    cone = ruled("(2, 0, -2)", "(1 + 2*u**2, 2 + u, 2 + u**2)", UNIT)
    seen = []

    def spy(contact, joined):
        seen.append(contact)
        return touch(contact, joined)

    monkeypatch.setattr(moving, "touch", spy)
    hit = fc.first_contact(cone.moving(fc.Translation((-7, 4, 7))), fan, exact=True)
    assert hit.time_exact.polynomial == (829, -1826, 949)
    assert (hit.element_a.kind, hit.element_b.kind) == ("vertex", "face")
    degrees = [x.field.modulus.degree() for c in seen for x in (c.u, c.v, c.t)]
    assert max(degrees) == 16
    assert all(x.value.degree() < x.field.modulus.degree() for c in seen for x in (c.u, c.v, c.t))


def test_moving_bodies_and_strips():
    pipe = ruled(*PIPE, None)
    moving = pipe.moving(fc.Translation((6, 0, 0)))
    (interval,) = fc.contact_intervals(moving, pipe.translated((4, 0, "1/2")), exact=True)
    assert (interval.start_exact, interval.end_exact) == (Fraction(1, 3), Fraction(1))
    hit = fc.first_contact(moving, pipe.translated((4, 0, "1/2")))
    assert np.allclose(hit.point[:2], [3, 0]) and 0.5 <= hit.point[2] <= 1


def test_the_condition_of_example_4():
    p, q = (fc.RuledSurface(x.first, x.second, u=None) for x in (MOVING["m01"].p, MOVING["m01"].q))
    condition = fc.contact_condition(p, q)
    lines = str(condition).splitlines()
    assert lines == [
        "R1 <= 0 and R2 >= 0 and R3 <= 0",
        "  R1 = u^2*T + T - 2",
        "  R2 = u^2*T + 2*u^2 + T",
        "  R3 = 2*u^2*T^2 + u^2 - 4*u + 2*T^2 + 1",
        "for some u: 2*T^2 - 1 <= 0",
    ]
    assert condition.holds("1/2", 0) and not condition.holds("1/2", 1)


@pytest.mark.share(2)
@pytest.mark.parametrize(("ends", "count", "number"), [((-1, 0), None, 1), ((-3, 1), (2, 2), 2), ((-3, 1), (1, 1), 1)])
def test_conditions_agree_with_geometry(ends, count, number):
    """Random exact u and T: the ruling y = y0, z = z0 against the pipe (x + 1)^2 + y^2 = 1, 1/2 <= z <= 3/2."""
    own = "({}, (1 - T - (1 + T)*u**2)/(1 + u**2), 2*u/(1 + u**2) - T**2)"
    roller = ruled(own.format(ends[0]), own.format(ends[1]), None)
    pipe = ruled("(-2*u**2/(1 + u**2), 2*u/(1 + u**2), 1/2)", "(-2*u**2/(1 + u**2), 2*u/(1 + u**2), 3/2)", None)
    condition = fc.contact_condition(roller, pipe, count=count)
    random = np.random.default_rng(3)
    seen = []
    places = [(Fraction(int(x), 8), Fraction(int(y), 8)) for x, y in random.integers(-24, 25, (150, 2))]
    for u, t in [*places, (Fraction(1), Fraction(0)), (Fraction(0), Fraction(0)), (Fraction(1, 2), Fraction(2, 5))]:
        y = (1 - t - (1 + t) * u**2) / (1 + u**2)
        z = 2 * u / (1 + u**2) - t**2
        inside = abs(y) <= 1 and Fraction(1, 2) <= z <= Fraction(3, 2)
        meetings = 0 if not inside else 1 if number == 1 and count is None or abs(y) == 1 else 2
        truth = meetings > 0 if count is None else meetings == number
        assert condition.holds(u, t) is truth
        seen.append(truth)
    assert len(set(seen)) == 2 or count == (1, 1)


def test_segments_agree_with_the_condition():
    """The same by brackets: rulings of both lie in planes x = constant, so that only v = u can meet."""
    random = np.random.default_rng(3)
    p, q = ruled("(u, -1, u*T)", "(u, 1, T)", UNIT), ruled("(u, -1/2, u**2 - 1/2)", "(u, 1/2, u**2 - 1/4)", UNIT)
    condition = fc.contact_condition(p, q)
    seen = set()
    for _ in range(60):
        u, t = (Fraction(int(x), 16) for x in random.integers(-16, 17, 2))
        truth = fc.brackets.segments_relation(*_ends(p.at(t), u), *_ends(q, u)).kind != "separate"
        assert condition.holds(u, t) is truth
        seen.add(truth)
    assert len(seen) == 2


def _ends(surface, u):
    return [_at(curve, u) for curve in (surface.first, surface.second)]


def _at(curve, u):
    x = [sum(Fraction(int(c)) * u**i for i, c in enumerate(row)) for row in
         ([entry[0] for entry in component] for component in curve.coefficients)]
    return [c / x[3] for c in x[:3]]


def test_a_blade_turns_through_a_wall():
    blade, wall = ruled("(u, 0, -1)", "(u, 0, 1)", (0, 2)), ruled("(1, u, -2)", "(1, u, 2)", ("1/2", 3))
    (interval,) = fc.contact_intervals(blade.moving(fc.Rotation(axis=(0, 0, 1), turns=1)), wall, exact=True)
    assert interval.start == pytest.approx(np.arctan(0.5) / (2 * np.pi), abs=1e-15) and interval.end == 1 / 6
    assert interval.end_exact.cosine == Fraction(1, 2)
