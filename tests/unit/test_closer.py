"""A closer look at one instant: it keeps what touches exactly, and tells what passes by a hair free."""

from __future__ import annotations

from fractions import Fraction as F
from random import Random

import pytest
from flint import fmpq, fmpz_poly

import firstcontact as fc
from firstcontact.contact.signs.closer import closer
from firstcontact.contact.signs.conditions import Conditions, conditions
from firstcontact.contact.signs.exclusion import survivors
from firstcontact.contact.signs.times import enclosed
from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots
from firstcontact.exact.numbers import rational
from firstcontact.search.rulings.directrices import directrix_pieces


def conditions_of(a: fc.RuledSurface, b: fc.RuledSurface) -> Conditions:
    (piece,) = directrix_pieces(a, b, fmpq(0), fmpq(2))
    return conditions(a, b, piece, (fmpq(0), fmpq(2)))


def kept(a: fc.RuledSurface, b: fc.RuledSurface, t: AlgebraicRoot) -> list:
    c = conditions_of(a, b)
    boxes = survivors(c, enclosed(t))
    assert boxes  # doubles over all ranges do not tell
    return closer(c, t, boxes)


ROOT = real_roots(fmpz_poly([-2, 0, 0, 1]), fmpq(1), fmpq(2))[0]
"""The cube root of 2."""


@pytest.mark.share(3)
@pytest.mark.parametrize("seed", range(3))
def test_a_bowl_on_a_table(seed: int) -> None:
    """z = (u - k)^2 + gap + (T^3 - 2) above z = 0: at T = 2^(1/3) the gap is what is between them, at u = k."""
    rng = Random(seed)
    k = F(rng.randint(-5, 5), 7)
    table = fc.RuledSurface("(-2, u, 0)", "(2, u, 0)", u=(-2, 2))
    for gap in (F(0), F(1, 2 ** rng.randint(40, 90))):
        height = f"(u-({k}))**2+({gap})+T**3-2"
        bowl = fc.RuledSurface(f"(u,-1,{height})", f"(u,1/2,{height})", u=(-1, 1))
        boxes = kept(bowl, table, ROOT)
        assert bool(boxes) is (gap == 0)
        assert gap or any(box.u[0] <= rational(k, "k") <= box.u[1] for box in boxes)


@pytest.mark.parametrize("far", [False, True])
def test_two_tips(far: bool) -> None:
    """Two whole cones with apexes 2^-44 apart, or one: in floating point, one."""
    gap = F(1, 2**44) if far else F(0)
    up = fc.RuledSurface("(0,0,0)", "((1-u**2)/(1+u**2), 2*u/(1+u**2), 3)", u=None)
    down = fc.RuledSurface(f"(0,0,T**3-2-({gap}))", f"((1-u**2)/(1+u**2), 2*u/(1+u**2), T**3-5-({gap}))", u=None)
    assert bool(kept(up, down, ROOT)) is not far


@pytest.mark.thorough
def test_the_apex_of_a_turning_cone_beside_another() -> None:
    """Rotations about one axis and an apex 1e-12 beside it: no instant took elimination in a field of degree 48."""
    axis, middle = (F(6, 19), F(-18, 19), F(1, 19)), (-1, 3, 3)
    a = fc.RuledSurface(
        "((7500000000003/9500000000000) + (6/19)*u + (18/19)*u**2, (34499999999991/9500000000000) + (1/19)*u"
        " + (-54/19)*u**2, (69000000000001/19000000000000) + (-18/19)*u + (3/19)*u**2)",
        "((-26499999999997/9500000000000) + (6/19)*u + (18/19)*u**2, (22499999999991/9500000000000) + (1/19)*u"
        " + (-54/19)*u**2, (45000000000001/19000000000000) + (-18/19)*u + (3/19)*u**2)",
        u=(-3, 1),
    ).moving(fc.Rotation(axis, middle, degrees=217))
    b = fc.RuledSurface(
        "(((-25/19) + (-102/19)*u + (-37/19)*u**2)/(1 + u**2), ((94/19) + (-36/19)*u + (92/19)*u**2)/(1 + u**2),"
        " ((37/19) + (-36/19)*u + (73/19)*u**2)/(1 + u**2))",
        "(-1, 3, 3)", u=None,
    ).moving(fc.Rotation(axis, middle, degrees=17))  # fmt: skip
    assert fc.first_contact(a, b, exact=True).status is fc.Status.FREE
