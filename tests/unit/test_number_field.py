"""The field of one root, square roots over it, and inertia over both."""

from __future__ import annotations

import random

import pytest
from flint import arb, fmpq, fmpq_mat, fmpz_poly

from firstcontact.exact.fields.number_field import NumberField, QuadraticElement, ball, is_zero, sign, square_root
from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots
from firstcontact.exact.numbers import precision
from firstcontact.exact.polynomials.inertia import inertia, null_space, rank, times, value
from firstcontact.exact.polynomials.polynomial_matrix import congruent


def field_of(coefficients, lo, hi) -> NumberField:
    (root,) = real_roots(fmpz_poly(coefficients), fmpq(lo), fmpq(hi))
    return NumberField(root)


CUBIC = field_of([-1, -1, 0, 1], 1, 2)  # x^3 = x + 1
RATIONAL = NumberField(AlgebraicRoot.of(fmpq(3, 7)))


@pytest.mark.parametrize("field", [CUBIC, RATIONAL])
def test_field_laws_and_balls(field):
    rng = random.Random(3)
    for _ in range(40):
        x, y = (field(fmpz_poly([rng.randint(-9, 9) for _ in range(5)])) for _ in range(2))
        assert x + y == y + x and (x - y) * (x + y) == x * x - y * y and 3 * x - x == x * 2
        if not y.is_zero():
            assert (x / y) * y == x and (1 / y) * y == 1 and x / fmpq(2, 3) == x * fmpq(3, 2)
        for z, b in ((x * y, x.ball(128) * y.ball(128)), (x + y, x.ball(128) + y.ball(128))):
            assert z.ball(128).overlaps(b)
        assert x.sign() == (x.ball(256) > 0) - (x.ball(256) < 0)
    with pytest.raises(ZeroDivisionError):
        1 / (x - x)


def test_zero_is_found_and_tiny_is_not_zero():
    r = CUBIC.generator()
    assert (r * r * r - r - 1).is_zero() and (r * r * r - r - 1).sign() == 0
    with precision(700):
        mantissa, exponent = CUBIC.root.enclosure(600).mid().man_exp()
    near = fmpq(mantissa) / fmpq(2) ** -int(exponent)
    assert not (r - near).is_zero() and (r - near).sign() == -(near - r).sign() != 0


def test_quadratic_extensions_by_squares_and_others():
    root2, root9 = square_root(fmpq(2)), QuadraticElement(fmpq(0), fmpq(1), fmpq(9))
    assert square_root(fmpq(9, 4)) == fmpq(3, 2) and sign(root2 - fmpq(7, 5)) == 1 and sign(root2 - fmpq(3, 2)) == -1
    assert is_zero(root2 * root2 - 2) and is_zero((1 / (root2 + 1)) - (root2 - 1))
    # 9 is a square: 3 - sqrt 9 is zero, 3 + sqrt 9 has norm zero and an inverse all the same
    assert is_zero(root9 - 3) and is_zero((root9 + 3) / 6 - 1) and is_zero(1 / (root9 + 3) - fmpq(1, 6))
    with pytest.raises(ZeroDivisionError):
        1 / (root9 - 3)
    r = CUBIC.generator()
    s = square_root(r)
    assert is_zero(s * s - r) and sign(s - 1) == 1 and sign(s - r) == -1
    with precision(128):
        assert ball(s, 128).overlaps(ball(r, 128).sqrt()) and ball(fmpq(1, 3), 64).overlaps(arb(fmpq(1, 3)))


def random_symmetric(rng, n, make, defect=0):
    p = [[make(rng.randint(-3, 3)) for _ in range(n)] for _ in range(n)]
    d = [rng.choice([-2, -1, 1, 3]) if i >= defect else 0 for i in range(n)]
    diagonal = [[make(d[i]) if i == j else make(0) for j in range(n)] for i in range(n)]
    det = fmpq_mat([[fmpq(str(x)) for x in row] for row in p]).det() if make is fmpq else None
    signs = (sum(x > 0 for x in d), sum(x < 0 for x in d), defect)
    return p, congruent(p, diagonal), signs, det


def test_inertia_of_random_congruences():
    rng = random.Random(4)
    checked = 0
    for k in range(200):
        _, m, expected, det = random_symmetric(rng, 1 + k % 5, fmpq, rng.randint(0, min(2, k % 5)))
        if det != 0:
            assert inertia(m) == expected and rank(m) == len(m) - expected[2]
            checked += 1
        for x in null_space(m):
            assert all(is_zero(y) for y in times(m, x)) and value(m, x) == 0
    assert checked > 100


@pytest.mark.parametrize(
    "rows, expected",
    [
        ([[0, 1], [1, 0]], (1, 1, 0)),
        ([[0, 0, 2], [0, 0, 0], [2, 0, 0]], (1, 1, 1)),
        ([[0, 1, 1], [1, 0, 1], [1, 1, 0]], (1, 2, 0)),
        ([[0, 0, 0, 1], [0, 0, 1, 0], [0, 1, 0, 0], [1, 0, 0, 0]], (2, 2, 0)),
        ([[0, 0], [0, 0]], (0, 0, 2)),
    ],
)
def test_inertia_without_squares_on_the_diagonal(rows, expected):
    assert inertia([[fmpq(x) for x in row] for row in rows]) == expected
    assert inertia([[CUBIC(x) for x in row] for row in rows]) == expected


def test_inertia_at_an_algebraic_number():
    r = CUBIC.generator()
    one, zero = CUBIC(1), CUBIC(0)
    # det = r^3 - r - 1 = 0: singular exactly there
    m = [[r * r - 1, one], [one, r]]
    assert inertia(m) == (1, 0, 1) and len(null_space(m)) == 1
    assert inertia([[r * r - 1, one, zero], [one, r + fmpq(1, 10**30), zero], [zero, zero, -r]]) == (2, 1, 0)


def test_fields_of_high_degree_keep_products_unreduced():
    """x^21 = 7 x + 1: the same zeros and signs with and without reduction."""
    field = field_of([-1, -7] + [0] * 19 + [1], 1, 2)
    r = field.generator()
    power = r
    for _ in range(20):
        power = power * r
    assert power.value.degree() == 21
    assert (power - 7 * r - 1).is_zero() and (power - 7 * r - 1).sign() == 0 and power == 7 * r + 1
    assert (power - 7 * r).sign() == 1 and not (power - 7 * r - fmpq(10**40 + 1, 10**40)).is_zero()
    assert (power - 7 * r - fmpq(10**40 + 1, 10**40)).sign() == -1
    assert (1 / power) * (7 * r + 1) == 1 and (power - 7 * r - 1).ball(64).is_zero()
    with pytest.raises(ZeroDivisionError):
        1 / (power - 7 * r - 1)
