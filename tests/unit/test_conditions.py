"""Polynomial conditions: when they hold first, and where they begin and end."""

from __future__ import annotations

from flint import fmpq, fmpz_poly

from firstcontact.exact.fields.conditions import ParameterConditions, between, distinct
from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots

P = fmpz_poly
ZERO, ONE, TWO = fmpq(0), fmpq(1), fmpq(2)


def test_an_equation_holds_at_its_roots_where_the_inequalities_allow():
    c = ParameterConditions((P([-2, 0, 1]),), (P([-1, 1]),))  # u^2 = 2, u >= 1
    assert not c.lasting
    assert abs(float(c.earliest(fmpq(-2), TWO)) - 2**0.5) < 1e-15
    assert c.earliest(fmpq(-2), ONE) is None


def test_several_equations_hold_at_common_roots():
    c = ParameterConditions((P([2, -3, 1]), P([6, -5, 1]), P([0])))  # (u-1)(u-2), (u-2)(u-3)
    assert c.earliest(ZERO, fmpq(5)).rational == 2


def test_equations_that_always_hold_leave_the_inequalities():
    c = ParameterConditions((P([0]),), (P([-1, 2]), P([3, -2])))  # 1/2 <= u <= 3/2
    assert c.lasting and c.earliest(ZERO, TWO).rational == fmpq(1, 2)
    assert c.earliest(ONE, TWO).rational == 1
    assert c.earliest(fmpq(7, 4), TWO) is None
    assert [e.rational for e in c.events(ZERO, TWO)] == [0, fmpq(1, 2), fmpq(3, 2), 2]


def test_strict_conditions_fail_at_zero():
    assert ParameterConditions((P([-1, 1]),), (), (P([-1, 1]),)).earliest(ZERO, TWO) is None


def test_numbers_once_and_between():
    root = real_roots(P([-2, 0, 1]), ZERO, TWO)[0]
    again = real_roots(P([4, 0, -4, 0, 1]), ZERO, TWO)[0]
    assert [float(r) for r in distinct([again, AlgebraicRoot.of(ONE), root])] == [1.0, 2**0.5]
    middle = between(AlgebraicRoot.of(fmpq(1414213562, 10**9)), root)
    assert fmpq(1414213562, 10**9) < middle and middle * middle < 2
