"""Pairs of points on a line, and conics of one plane: every configuration, with and without contact."""

from __future__ import annotations

import itertools
import random
from fractions import Fraction

import pytest
from flint import fmpq, fmpz_poly

from firstcontact.exact.fields.number_field import NumberField, is_zero
from firstcontact.exact.fields.roots import real_roots
from firstcontact.exact.pencils.conic_pencils import (
    ConicMeeting,
    PointPairs,
    conic_contacts,
    line_resultant,
    point_pairs,
    proportional,
    shared_points,
)
from firstcontact.exact.pencils.pencils import IDENTICALLY_DEGENERATE, characteristic, discriminant
from firstcontact.exact.polynomials.inertia import null_space, value
from firstcontact.exact.polynomials.polynomial_matrix import congruent


def binary(p, q, r):
    """p s^2 + q s t + r t^2."""
    return [[fmpq(p), fmpq(q) / 2], [fmpq(q) / 2, fmpq(r)]]


CANONICAL = {
    PointPairs.ONE_SHARED: (binary(0, 1, 0), binary(1, -1, 0)),
    PointPairs.SAME_PAIR: (binary(1, 0, -2), binary(-3, 0, 6)),
    PointPairs.POINT_OF_PAIR: (binary(0, 1, 0), binary(1, 0, 0)),
    PointPairs.SAME_POINT: (binary(1, 2, 1), binary(-2, -4, -2)),
    PointPairs.SAME_IMAGINARY: (binary(1, 0, 1), binary(-2, 0, -2)),
    PointPairs.SEPARATING: (binary(0, 1, 0), binary(1, 0, -1)),
    PointPairs.DISJOINT: (binary(0, 1, 0), binary(1, -3, 2)),
    PointPairs.POINT_AND_PAIR: (binary(0, 1, 0), binary(1, -2, 1)),
    PointPairs.TWO_POINTS: (binary(1, 0, 0), binary(0, 0, 1)),
    PointPairs.REAL_AND_IMAGINARY: (binary(0, 1, 0), binary(1, 1, 1)),
    PointPairs.POINT_AND_IMAGINARY: (binary(1, 0, 0), binary(1, 1, 1)),
    PointPairs.TWO_IMAGINARY: (binary(1, 0, 1), binary(1, 0, 2)),
}


def roots_of(form):
    """The zeros as exact labels: real ones (value, in order on the line), infinity as None; or the imaginary form."""
    (p, q), (_, r) = form
    p, q, r = (Fraction(int(x.p), int(x.q)) for x in (p, 2 * q, r))
    if p == 0:
        return {None} if q == 0 else {None, -r / q}
    d = q * q - 4 * p * r
    root = Fraction(float(d) ** 0.5).limit_denominator(1000) if d >= 0 else None
    if root is not None and root * root != d:
        return "irrational"
    return None if root is None else {(-q - root) / (2 * p), (-q + root) / (2 * p)}


def configuration_by_hand(a, b):
    """The configuration read off the zeros themselves; None where they are irrational."""
    x, y = roots_of(a), roots_of(b)
    if x == "irrational" or y == "irrational":
        return None
    kinds = tuple(sorted(0 if z is None else len(z) for z in (x, y)))
    if kinds == (0, 0):
        return PointPairs.SAME_IMAGINARY if proportional(a, b) else PointPairs.TWO_IMAGINARY
    if kinds[0] == 0:
        return PointPairs.POINT_AND_IMAGINARY if kinds[1] == 1 else PointPairs.REAL_AND_IMAGINARY
    shared = len(x & y)
    if kinds == (1, 1):
        return PointPairs.SAME_POINT if shared else PointPairs.TWO_POINTS
    if kinds == (1, 2):
        return PointPairs.POINT_OF_PAIR if shared else PointPairs.POINT_AND_PAIR
    if shared:
        return PointPairs.SAME_PAIR if shared == 2 else PointPairs.ONE_SHARED
    ends = sorted([*((z is None, z or 0, 0) for z in x), *((z is None, z or 0, 1) for z in y)])
    owners = [owner for *_, owner in ends]
    return PointPairs.SEPARATING if owners[0] == owners[2] else PointPairs.DISJOINT


def test_every_small_pair_of_forms_is_classified_as_its_zeros_lie():
    """Enumeration: all twelve configurations occur, no other; exactly four are contacts."""
    seen = {}
    small = [binary(*c) for c in itertools.product(range(-2, 3), repeat=3) if any(c)]
    for a in small[::2]:
        for b in small:
            expected = configuration_by_hand(a, b)
            if expected is not None:
                found = point_pairs(a, b)
                assert found is expected, (a, b)
                seen[found] = seen.get(found, 0) + 1
                assert found is point_pairs(b, a)
                assert bool(shared_points(a, b)) == found.is_contact
    assert set(seen) == set(PointPairs) and len(PointPairs) == 12
    assert sum(c.is_contact for c in PointPairs) == 4


@pytest.mark.parametrize("expected", list(PointPairs))
def test_configurations_are_projective(expected):
    a, b = CANONICAL[expected]
    rng = random.Random(2)
    for _ in range(20):
        p = [[fmpq(rng.randint(-4, 4)) for _ in range(2)] for _ in range(2)]
        if p[0][0] * p[1][1] == p[0][1] * p[1][0]:
            continue
        c, d = congruent(p, a), [[-3 * x for x in row] for row in congruent(p, b)]
        assert point_pairs(c, d) is expected
        double = {PointPairs.SAME_IMAGINARY} | {x for x in PointPairs if x.is_contact}
        assert (line_resultant(c, d) == 0) == (expected in double)
        for x in shared_points(c, d):
            assert is_zero(value(c, x)) and is_zero(value(d, x)) and not all(is_zero(y) for y in x)
        count = {PointPairs.SAME_PAIR: 2}.get(expected, int(expected.is_contact))
        assert len(shared_points(c, d)) == count


def test_equal_imaginary_pairs_have_a_double_root_and_no_contact():
    a = binary(1, 0, 1)
    assert characteristic(a, a) == [1, -2, 1] and not point_pairs(a, a).is_contact and shared_points(a, a) == []


# ------------------------------------------------------------------------------------------ conics of a plane


def conic(xx, yy, ww, xy=0, xw=0, yw=0):
    h = fmpq(1, 2)
    return [[fmpq(xx), h * xy, h * xw], [h * xy, fmpq(yy), h * yw], [h * xw, h * yw, fmpq(ww)]]


CIRCLE = conic(1, 1, -1)
PAIRS = [
    # unit circle and: a circle outside, one inside, the osculating circle of the parabola y = x^2, ...
    ("outside", CIRCLE, conic(1, 1, 3, xw=-4), ConicMeeting.TANGENT, 1),
    ("inside", CIRCLE, conic(1, 1, 0, xw=-1), ConicMeeting.TANGENT, 1),
    ("vertex circle", conic(1, 0, 0, yw=-1), conic(1, 1, 0, yw=-1), ConicMeeting.HYPEROSCULATING, 1),
    # through (0, 0) with the tangent, curvature and no more of y = x^2: x^2 - y w + x y
    ("osculating", conic(1, 0, 0, yw=-1), conic(1, 0, 0, xy=1, yw=-1), ConicMeeting.OSCULATING, 1),
    ("double contact", CIRCLE, conic(1, 4, -1), ConicMeeting.TWO_TANGENT, 2),
    ("concentric", CIRCLE, conic(1, 1, -4), ConicMeeting.IMAGINARY, 0),
    ("same", CIRCLE, conic(-2, -2, 2), ConicMeeting.SAME, 0),
    ("crossing lines at a point of the circle", CIRCLE, conic(1, -1, 1, xw=-2), ConicMeeting.VERTEX, 1),
    ("tangent line, doubled", CIRCLE, conic(1, 0, 1, xw=-2), ConicMeeting.HYPEROSCULATING, 1),
    ("secant, doubled", CIRCLE, conic(1, 0, 0), ConicMeeting.TWO_TANGENT, 2),
    ("a line of a pair touches", CIRCLE, conic(1, 0, 0, xy=1, xw=-1, yw=-1), ConicMeeting.TANGENT, 1),
]


@pytest.mark.parametrize("name, a, b, meeting, count", PAIRS)
def test_conics_that_touch(name, a, b, meeting, count):
    rng = random.Random(len(name))
    for k in range(5):
        p = [[fmpq(rng.randint(-3, 3)) for _ in range(3)] for _ in range(3)] if k else conic(1, 1, 1)
        if null_space(p):
            continue
        c, d = congruent(p, a), congruent(p, b)
        for first, second in ((c, d), (d, c)):
            assert discriminant(characteristic(first, second)) == 0
            (t,) = conic_contacts(first, second).tangencies
            assert t.meeting is meeting and len(t.points) == count
            assert t.meeting.is_contact == (meeting is not ConicMeeting.IMAGINARY)
            for x in t.points:
                assert is_zero(value(c, x)) and is_zero(value(d, x)) and not all(is_zero(y) for y in x)


def test_conics_that_do_not_touch():
    for b in (conic(1, 1, 8, xw=-6), conic(1, 4, -2), conic(1, 1, 20, xw=-10)):
        assert conic_contacts(CIRCLE, b).tangencies == () and discriminant(characteristic(CIRCLE, b)) != 0
    # two line pairs with one vertex
    assert conic_contacts(conic(1, -1, 0), conic(1, -4, 0, xy=1)).reason == IDENTICALLY_DEGENERATE


def test_parallel_elliptic_cylinders_in_section():
    """Example 7 of Choi et al. 2014 at t = 1/2: cubic -(16 l - 1)(256 l^2 + 112 l + 1), no contact."""
    a = conic(fmpq(1, 25), fmpq(1, 100), 3, yw=fmpq(-2, 5))
    b = [[x / 16 for x in row] for row in conic(fmpq(1, 25), fmpq(1, 100), 0, yw=fmpq(1, 5))]
    cubic = fmpz_poly([-1, 16]) * fmpz_poly([1, 112, 256])
    c = characteristic(a, b)
    assert len({x / y for x, y in zip(c, (fmpq(z) for z in cubic.coeffs()), strict=True)}) == 1
    assert conic_contacts(a, b).tangencies == ()


def test_a_moving_circle_at_an_irrational_time():
    """A unit circle on its way (2 u, u): outer contacts with a unit circle where 5 u^2 = 4, concentric at u = 0."""
    u, one, none = fmpz_poly([0, 1]), fmpz_poly([1]), fmpz_poly([0])
    a = ((one, none, -2 * u), (none, one, -u), (-2 * u, -u, 5 * u * u - 1))
    b = ((one, none, none), (none, one, none), (none, none, -one))
    equation = discriminant(characteristic(a, b))
    roots = real_roots(equation, fmpq(0), fmpq(1))
    assert [r.rational for r in roots] == [0, None] and roots[1].polynomial == fmpz_poly([-4, 0, 5])
    field = NumberField(roots[1])
    (t,) = conic_contacts(field.matrix(a), field.matrix(b)).contacts
    (x,) = t.points
    assert t.meeting is ConicMeeting.TANGENT and is_zero(x[0] / x[2] - field.generator())
    assert conic_contacts(NumberField(roots[0]).matrix(a), NumberField(roots[0]).matrix(b)).contacts[0].points == ()
