"""Rational curves and ruled surfaces: construction, exactness, validation, placement, bounds, and the known vectors."""

from __future__ import annotations

import doctest
import pickle
from fractions import Fraction as F
from pathlib import Path

import numpy as np
import pytest
from flint import fmpq, fmpz_poly

import firstcontact as fc
from firstcontact.body.ruled.rational_curve import RationalCurve
from firstcontact.body.ruled.surface import RuledSurface
from ruled_vectors import numbers, value, vectors

CIRCLE = "((1-u**2)/(1+u**2), 2*u/(1+u**2), {})"
VECTORS = vectors()


def cylinder(**changes) -> RuledSurface:
    return RuledSurface(CIRCLE.format(0), CIRCLE.format(1), **{"u": None, **changes})


# -- vectors ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("vector", [v for v in VECTORS if v.kind == "moving"], ids=repr)
def test_events_of_the_moving_vectors_lie_on_both_surfaces(vector):
    for event in vector.expected["events"]:
        if "point" not in event:
            continue
        x = event["params"]
        p, q = vector.p.at(event["T"]), vector.q.at(event["T"])
        on_p = p.points(float(x["u"]), float(x["s"]))
        on_q = q.points(float(x["v"]), float(x["t"]))
        assert np.abs(on_p - numbers(event["point"])).max() < 1e-9
        assert np.abs(on_q - numbers(event["point"])).max() < 1e-9


@pytest.mark.parametrize("vector", [v for v in VECTORS if v.kind == "static_box"], ids=repr)
def test_boundary_points_of_the_bounded_vectors_lie_on_both_surfaces(vector):
    known = vector.expected.get("boundary_points", [])
    for found in known:
        x = found["params"]
        point = numbers(found["point"])
        for body, u, s in ((vector.p, x["u"], x["s"]), (vector.q, x["v"], x["t"])):
            assert np.abs(body.points(float(u), float(s)) - point).max() < 1e-12
            lo, hi = body.bounds()
            assert np.all(lo <= np.add(point, 1e-15)) and np.all(np.subtract(point, 1e-15) <= hi)


@pytest.mark.parametrize("vector", [v for v in VECTORS if any(v.implicit)], ids=repr)
def test_surfaces_of_the_vectors_satisfy_their_implicit_equations(vector):
    points = [curve.points([-0.7, 0.2, 0.9]) for body in (vector.p, vector.q) for curve in (body.first, body.second)]
    for equation, first, second in zip(vector.implicit, points[::2], points[1::2], strict=True):
        for s in (0.0, 0.3, 1.0) if equation else ():
            for x, y, z in ((1 - s) * first + s * second):
                assert abs(float(value(equation, x=x, y=y, z=z))) < 1e-9 * max(1, x * x, y * y, z * z)


def test_closed_forms_of_the_vectors_have_values():
    ends = [end for v in VECTORS if v.expected.get("exact") for pair in v.expected["exact"] for end in pair]
    decimals = [end for v in VECTORS if v.expected.get("exact") for pair in v.expected["collision_T"] for end in pair]
    assert len(ends) == len(decimals) > 20
    for exact, decimal in zip(ends, decimals, strict=True):
        assert abs(float(value(exact)) - float(decimal)) < 1e-15 * max(1, abs(float(decimal)))


# -- curves -------------------------------------------------------------------------------------------------


def test_coefficients_and_strings_give_the_same_curve():
    one = RationalCurve([[1, 0, "-1/3"], [0.5], [0, F(2, 7)]], ["3", 0, 1])
    other = RationalCurve.parse("((1 - u**2/3)/(3 + u**2), 0.5/(u**2 + 3), 2*u/(7*(3 + u*u)))")
    assert one == other and one.components == other.components
    assert all(isinstance(x, fmpz_poly) for x in one.components)
    assert RationalCurve.parse("(0.1, 1e-1*u, 1/10)").components == RationalCurve.parse("(1/10, u/10, 0.1)").components
    assert RationalCurve([[0.1], [0], [0]]) != RationalCurve([["0.1"], [0], [0]])  # a double is the double it is


@pytest.mark.parametrize(
    "text", ["(u, u**2, u**3)", "((u**2 - 1)/(u**2 + 1), u/(u + 2), T*u/(T**2 + 3))", "(0, 0, 0)", "(T, 1/3, -u/2)"]
)
def test_the_text_of_a_curve_reads_back(text):
    curve = RationalCurve.parse(text)
    assert RationalCurve.parse(str(curve)) == curve
    assert pickle.loads(pickle.dumps(curve)).components == curve.components


def test_common_factors_cancel_and_infinity_is_a_parameter():
    curve = RationalCurve.parse("((u**2 - 1)/(u - 1), (u**2 + u)/u, 2*(u + 1))")
    assert curve.degree == 1 and curve == RationalCurve.parse("(u + 1, u + 1, 2*u + 2)")
    circle = RationalCurve.parse(CIRCLE.format("1/2"))
    assert circle.points([np.inf, -np.inf, 0.0]).tolist() == [[-1, 0, 0.5], [-1, 0, 0.5], [1, 0, 0.5]]
    far = circle.points(1e200)
    assert np.allclose(far, [-1, 2e-200, 0.5], rtol=1e-15, atol=0)
    assert circle.reversed().points(0.0).tolist() == [-1, 0, 0.5]
    assert circle.reversed() == RationalCurve.parse("((u**2-1)/(1+u**2), 2*u/(1+u**2), 1/2)")


def test_a_deforming_curve_at_exact_times():
    curve = RationalCurve([[[1, 0, -1], [0, 1]], [["0", "1/3"]], [0]], [[1, 0, 1]])
    assert curve == RationalCurve.parse("((1 - T**2 + u*T)/(1 + T**2), T/(3*(1 + T**2)), 0)")
    assert curve.deforming and not curve.at("1/3").deforming
    assert curve.at("1/3") == RationalCurve.parse("((8/9 + u/3)*9/10, 1/10, 0)")
    assert curve.at(0.1) != curve.at("0.1")
    assert not RationalCurve.parse("(u + T - T, u, 0)").deforming
    assert RationalCurve.parse("(T, T**2, 1)").is_constant and not RationalCurve.parse("(u, T, 1)").is_constant
    with pytest.raises(fc.InputError, match="denominator 0 at T = 1"):
        RationalCurve.parse("(u/(T-1), 0, 0)").at(1)
    with pytest.raises(fc.InputError, match="deforms"):
        curve.points(0)


# -- surfaces -----------------------------------------------------------------------------------------------


def test_points_bounds_and_repr():
    body = cylinder(name="pipe").translated((0, 0, "1/3"))
    assert repr(body) == "<RuledSurface 'pipe': degrees 2 and 2, all u, s in [0, 1]>"
    u, s = np.tan(np.linspace(-1.5, 1.5, 41))[:, None], np.linspace(0, 1, 5)
    points = body.points(u, s)
    assert points.shape == (41, 5, 3)
    assert np.allclose(np.hypot(points[..., 0], points[..., 1]), 1, rtol=1e-15)
    lo, hi = body.bounds()
    assert np.all(lo[:2] <= -1) and np.all(hi[:2] >= 1) and np.all(np.abs([*lo[:2], *hi[:2]]) < 1.1)
    assert lo[2] <= F(1, 3) <= lo[2] + 1e-15 and hi[2] - 1e-15 <= F(4, 3) <= hi[2]
    assert not cylinder(s=None).bounded and np.all(np.isinf(cylinder(s=None).bounds()))


@pytest.mark.parametrize("vector", VECTORS, ids=repr)
def test_boxes_hold_their_surfaces(vector):
    rng = np.random.default_rng(3)
    for body in (vector.p, vector.q):
        if body.s is None:
            continue
        first, last = (0, 1) if vector.span is None else map(float, vector.span)
        lo, hi = body.bounds((first, last))
        u = np.tan(rng.uniform(-1.57, 1.57, 40)) if body.u is None else rng.uniform(*map(float, body.u), 40)
        for t in rng.uniform(first, last, 5 if body.deforming else 1).tolist():
            points = body.at(t).points(u, rng.uniform(0, 1, 40))
            slack = 1e-13 * max(1, np.abs(points).max())
            assert np.all(lo - slack <= points) and np.all(points <= hi + slack)
        assert np.all(hi - lo < 3 * np.ptp(body.at((first + last) / 2).points(np.tan(u), 0.5), axis=0) + 30)


def test_sides_are_the_curves_at_the_ends_of_s():
    whole = RuledSurface("(u/(u + 2), 0, 0)", "(0, u, 1/(u - 3))", s=None)
    part = RuledSurface(whole.first, whole.second, s=("-1/2", 3))
    u = np.linspace(0, 1, 7)
    for side, s in zip(part.sides, (-0.5, 3.0), strict=True):
        assert np.allclose(side.points(u), whole.points(u, s), rtol=1e-14, atol=1e-14)
        assert all(x > 0 for x in (side.components[3](0), side.components[3](1)))
    assert whole.sides == (whole.first, whole.second)
    moving = RuledSurface("(u, T, 0)", "(u, T, 1)", s=(0, 2))
    assert moving.sides[1].at(3) == RationalCurve.parse("(u, 3, 2)")


def test_weights_are_positive_on_the_range():
    body = RuledSurface("(1/(u - 2), 0, 0)", "(0, u/(1 - 5*u + 6*u**2), 1)", u=("2/3", 1))
    assert all(curve.components[3](x) > 0 for curve in (body.first, body.second) for x in (fmpq(2, 3), fmpq(1)))
    assert body.points(1, 0).tolist() == [-1, 0, 0]


def test_placements_are_exact():
    body = RuledSurface("(u, 0, T)", "(u, 1/3, u*T)", name="strip", trim="u*s <= 1/2")
    turned = body.rotated((0, 0, 1), degrees=90).translated(("1/3", 0, 0))
    assert turned.first == RationalCurve.parse("(1/3, u, T)") and turned.second == RationalCurve.parse("(0, u, u*T)")
    assert turned.name == "strip" and turned.trim == body.trim
    mirrored = body.transformed([[1, 0, 0, 0], [0, -2, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    assert mirrored.second == RationalCurve.parse("(u, -2/3, u*T)")
    assert body.named("other").name == "other" and body.name == "strip"
    copy = pickle.loads(pickle.dumps(turned))
    assert (copy.first, copy.second, copy.u, copy.s, copy.name) == (
        turned.first, turned.second, turned.u, turned.s, turned.name,
    )  # fmt: skip
    assert str(copy.trim[0]) == "-2*u*s + 1 >= 0"


def test_moving_and_deforming_at_once():
    body = RuledSurface("(u, 0, T)", "(u, 1, T)", name="strip")
    moving = body.moving(fc.Translation((0, 0, 10)))
    assert moving.at(0.5).first == RationalCurve.parse("(u, 0, 11/2)")
    lo, hi = moving.bounds((0, 2))
    assert lo[2] <= 0 and 22 <= hi[2] < 22.1
    assert body.bounds((0, 2))[1][2] == 2 and body.bounds()[1][2] == 1
    assert pickle.loads(pickle.dumps(moving)).at(0.25).first == moving.at(0.25).first
    turning = cylinder(name="pipe").moving(fc.Rotation((0, 0, 1), turns=1))
    assert np.allclose(turning.bounds()[1], [2**0.5, 2**0.5, 1], atol=0.3)
    assert np.all(np.isinf(cylinder(s=None).moving(fc.Translation((1, 0, 0))).bounds()))


def test_proper_and_improper_parameters():
    assert cylinder().is_proper and RuledSurface("(u, 0, 0)", "(u, 1, u)").is_proper
    twice = RuledSurface("(u**2, 0, 0)", "(u**2, 1, u**2)", u=(-1, 1))
    assert twice.tracing_index == 2 and not twice.is_proper
    assert RuledSurface("(u**3, 0, 0)", "(u**3, 1 + u**3, u**6)").tracing_index == 3
    assert RuledSurface("(u**2, 0, 0)", "(u**2, 1, u)").is_proper  # one directrix alone is traced twice
    assert RuledSurface("(0, 0, 0)", "(u**3, 1, u)").is_proper


def test_the_verbs_do_not_guess():
    with pytest.raises(fc.UnsupportedPair):
        fc.contact_pairs(cylinder(), cylinder())


@pytest.mark.thorough
def test_the_examples_of_the_documentation_hold():
    found = doctest.testfile(str(Path(__file__).parents[1] / "docs" / "ruled-surfaces.md"), module_relative=False)
    assert found.attempted >= 8 and found.failed == 0


# -- bad input ----------------------------------------------------------------------------------------------

LINE, OTHER = "(u, 0, 0)", "(u, 1, 0)"


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: RuledSurface(LINE, "(2*u/2, 0, 0)", name="roof"), "roof: first and second are one curve"),
        (lambda: RuledSurface(LINE, "(u**2 + 1, 0, 0)"), "all rulings lie on one line"),
        (lambda: RuledSurface("(0, 0, 0)", "(1, 2, 3)"), "all rulings lie on one line"),
        (lambda: RuledSurface(LINE, "(u, 1/(2*u - 1), 0)"), "second has a pole at u = 0.5;"),
        (lambda: RuledSurface(LINE, "(u, 1/(2*u - 1), 0)", u=("1/2", 1)), "second has a pole at u = 0.5;"),
        (lambda: RuledSurface(LINE, "(u, 1/(u**2 - 2), 0)", u=(1, 2)), "pole at u = 1.41421356;"),
        (lambda: RuledSurface(LINE, OTHER, u=None), "first has a pole at u = infinity"),
        (lambda: RuledSurface(CIRCLE.format(0), "(1/(u**2-4), 0, 1)", u=None), "second has a pole at u = -2;"),
        (lambda: RuledSurface(LINE, OTHER, u=(1, 1)), "u is the empty range (1, 1)"),
        (lambda: RuledSurface(LINE, OTHER, s=(2, "1/2")), "s is the empty range (2, 1/2)"),
        (lambda: RuledSurface(LINE, OTHER, s=(0, float("nan"))), "s[1] is nan"),
        (lambda: RuledSurface(LINE, OTHER, u=(0, float("inf"))), "u[1] is inf"),
        (lambda: RuledSurface(LINE, OTHER, u=3), "u is 3; give a range"),
        (lambda: RuledSurface(LINE, OTHER, u=(0, 2**160)), "give numbers below 2^150"),
        (lambda: RuledSurface(LINE, OTHER, u="01"), "u is '01'; give a range"),
        (lambda: RuledSurface(LINE, OTHER, s={0, 1}), "s is {0, 1}; give a range"),
        (lambda: RuledSurface(LINE, OTHER, u=("1e999999999", 1)), "exponent below 10000"),
        (lambda: RuledSurface(LINE, "(1/(u - 1), T, 0)"), "second has a pole at u = 1;"),
        (lambda: RuledSurface(LINE, "(u, 1, 1e400)"), "'(u, 1, 1e400)' has coefficients of sizes too far apart"),
        (lambda: RuledSurface(LINE, "(u, 1, 1e-400*u)"), "coefficients of sizes too far apart"),
        (lambda: RuledSurface(LINE, OTHER, trim=5), "trim is 5; give inequalities"),
        (lambda: RuledSurface(LINE, "(u, 1, 1/(T - 2))", name="lid").at(2), "lid: a directrix has denominator 0 at T"),
        (lambda: RuledSurface(LINE, "(u, 1/(u - T), 0)", name="lid").bounds(), "lid: a directrix has a pole near"),
        (lambda: RuledSurface(LINE, "(u, 1, T)", name="lid").to_mesh(1), "lid deforms"),
        (lambda: RuledSurface(LINE, OTHER).moving(fc.Translation), "is no motion"),
        (lambda: RuledSurface(LINE, OTHER).moving(np.eye(4)), "is no motion"),
        (lambda: fc.first_contact(*[RuledSurface(LINE, OTHER)] * 2, tolerance="a"), "tolerance is 'a'"),
        (lambda: fc.first_contact(*[RuledSurface(LINE, OTHER)] * 2, span="01"), "span is '01'"),
        (lambda: fc.intersection_curve(*[RuledSurface(LINE, OTHER)] * 2, tolerance=None), "tolerance is None"),
        (lambda: RationalCurve.parse(5), "is 5; give a text"),
        (lambda: RuledSurface(LINE, 3), "second is 3"),
        (lambda: RuledSurface("(u, v, 0)", OTHER), "first '(u, v, 0)': unknown name 'v'; the variables are u and T"),
        (lambda: RuledSurface("(u, 0)", OTHER), "has 2 coordinates"),
        (lambda: RuledSurface("(u^2, 0, 0)", OTHER), "write powers as **"),
        (lambda: RuledSurface("(u, 1/0, 0)", OTHER), "nothing can be divided by it"),
        (lambda: RuledSurface("(sin(u), 0, 0)", OTHER), "cannot take 'sin(u)'"),
        (lambda: RuledSurface(LINE, OTHER, trim="u*s < 1"), "pieces are closed"),
        (lambda: RuledSurface(LINE, OTHER, trim=["u*s"]), "trim[0] 'u*s' is no inequality"),
        (lambda: RuledSurface(LINE, OTHER, trim=["s <= 1", "s >= T"]), "trim[1] 's >= T': unknown name 'T'"),
        (lambda: RuledSurface(LINE, OTHER, trim=["1/u >= s"]), "multiply the denominator out"),
        (lambda: RuledSurface(LINE, OTHER, trim=[3]), "trim[0] is 3"),
        (lambda: RuledSurface(LINE, OTHER, trim="u >= 2"), "trim 'u - 2 >= 0' leaves nothing"),
        (lambda: RuledSurface("(u, T, 0)", "(u, 1, 0)").at(1), "one curve; give two different ones (at T = 1)"),
        (lambda: RuledSurface("(u, 0, 0)", "(u/(u - T), 1, 0)").at("1/2"), "pole at u = 0.5"),
        (lambda: RuledSurface("(u, 0, 0)", "(u/(u - T), 1, 0)").bounds((0, 1)), "has a pole near u = "),
        (lambda: RuledSurface(LINE, "(u, T, 0)").is_proper, "deforms with the time T; take .at(t)"),
        (lambda: RuledSurface(LINE, OTHER).points(0, float("nan")), "s holds NaN"),
        (lambda: RuledSurface(LINE, OTHER).points(float("nan"), 0), "u holds NaN"),
        (lambda: RationalCurve([[0, 1], [0]]), "give three lists"),
        (lambda: RationalCurve([[0, 1], [0], 3]), "numerators[2] is 3"),
        (lambda: RationalCurve([[0, 1], [0], ["x"]]), "numerators[2][0] is 'x'"),
        (lambda: RationalCurve([[0, 1], [0], [float("nan")]]), "numerators[2][0] is nan"),
        (lambda: RationalCurve([[0, 1], [0], [1]], [0, 0]), "denominator is 0"),
        (lambda: RationalCurve([[0, 1], [0], [2**151]]), "below 2^150"),
    ],
)
def test_bad_input_stops_with_one_line(make, text):
    with pytest.raises(fc.InputError) as error:
        make()
    assert text in str(error.value) and "\n" not in str(error.value)


def test_coefficients_are_read_from_iterators_once():
    assert RationalCurve([iter([1, 2]), [2], [3]]) == RationalCurve([[1, 2], [2], [3]])


def test_a_curve_that_asks_for_too_many_digits_is_refused():
    """Of a sliver 1e-290 wide: one line of ours, no error of the sweep."""
    sliver = RuledSurface("(u, 0, 0)", "(u*1e-290, 1e-290, u*1e-290)")
    with pytest.raises(fc.UnsupportedPair, match="asks for too many digits"):
        fc.intersection_curve(sliver, RuledSurface("(0, u, -1)", "(0, u, 1)"))


def test_a_deforming_surface_may_have_poles_at_other_times():
    body = RuledSurface("(u, 0, 0)", "(u/(u - T), 1, 0)")
    assert body.at(2).bounds()[0].tolist() == [-1, 0, 0]
    lo, hi = body.bounds((2, 3))
    assert lo[0] <= -1 and hi[0] >= 1
