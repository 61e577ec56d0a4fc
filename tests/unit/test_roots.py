"""Real roots of integer polynomials: none missed, each in an interval of its own, exact signs and order."""

from __future__ import annotations

import random
from fractions import Fraction

import pytest
from flint import arb, fmpq, fmpq_poly, fmpz_poly

from firstcontact.exact.fields.roots import AlgebraicRoot, isolate, on_half_line, real_roots, variations
from firstcontact.exact.numbers import precision
from firstcontact.exact.polynomials.polynomial_matrix import (
    adjugate,
    congruent,
    constant,
    determinant,
    evaluate,
    minors,
    primitive,
    product,
    transpose,
)
from firstcontact.result import AlgebraicNumber

X = fmpz_poly([0, 1])
ONE = fmpz_poly([1])


def linear(value) -> fmpz_poly:
    value = fmpq(value)
    return fmpz_poly([-value.p, value.q])


def mignotte(degree: int, a: int) -> fmpz_poly:
    """x^n - 2 (a x - 1)^2: two roots next to 1/a, much closer than most polynomials of this height allow."""
    return X**degree - 2 * fmpz_poly([-1, a]) ** 2


def counted(p: fmpz_poly, lo: fmpq, hi: fmpq) -> int:
    """Distinct real roots in [lo, hi], counted by certified complex balls."""
    total = 0
    for factor, _ in p.factor()[1]:
        for z, _ in factor.complex_roots():
            if z.imag == 0 and not (z.real < lo or z.real > hi):
                assert z.real.is_exact() or not (z.real.overlaps(arb(lo)) or z.real.overlaps(arb(hi)))
                total += 1
    return total


def check(p: fmpz_poly, lo: fmpq, hi: fmpq) -> list[AlgebraicRoot]:
    roots = real_roots(p, lo, hi)
    assert len(roots) == counted(p, lo, hi)
    for x, y in zip(roots, roots[1:], strict=False):
        assert x.compare(y) == -1 and y.compare(x) == 1
    for root in roots:
        assert lo <= root.lo <= root.hi <= hi
        assert root.sign_of(root.polynomial) == 0 and root.sign_of(p) == 0
        for power in range(1, root.multiplicity + 1):
            assert (p % root.polynomial**power).is_zero()
        assert root.sign_of(p // root.polynomial**root.multiplicity) != 0
        ball = root.enclosure(200)
        assert ball.rel_accuracy_bits() >= 200 or root.rational is not None
        with precision(300):
            assert p(ball).contains(0)
        assert float(root) == float(root.number())
    return roots


def test_random_polynomials_lose_no_root():
    rng = random.Random(5)
    found = 0
    for k in range(120):
        degree = rng.randint(1, 24)
        bits = rng.choice((2, 8, 60))
        p = fmpz_poly([rng.randint(-(2**bits), 2**bits) for _ in range(degree)] + [1])
        if k % 3 == 0:
            p *= linear(fmpq(rng.randint(-3, 3), rng.randint(1, 4))) ** rng.randint(1, 3)
        if k % 4 == 0:
            p *= fmpz_poly([-2, 0, 1]) ** 2
        lo = fmpq(rng.randint(-8, 4), 4)
        found += len(check(p, lo, lo + fmpq(rng.randint(1, 16), 3)))
    assert found > 150


def test_many_roots_in_the_unit_interval():
    rng = random.Random(6)
    for degree in (5, 12, 30):
        terms = [
            rng.randint(-1000, 1000) * X**k * fmpz_poly([1, -1]) ** (degree - k) * int(10**k) for k in range(degree + 1)
        ]
        check(sum(terms, fmpz_poly([0])), fmpq(0), fmpq(1))
    assert len(check(fmpz_poly.chebyshev_t(40), fmpq(-1), fmpq(1))) == 40


@pytest.mark.parametrize("degree, a", [(8, 11), (17, 1001), (32, 1001), (48, 3)])
def test_two_roots_that_nearly_coincide(degree, a):
    p = mignotte(degree, a)
    roots = check(p, fmpq(0), fmpq(1))
    assert len(roots) == 2
    # they lie on the two sides of 1/a, nearer to it than a^-(degree/2)
    for root, side in zip(roots, (-1, 1), strict=True):
        assert root.compare(fmpq(1, a)) == side
        with precision(1200):
            assert abs(root.enclosure(1000) - arb(fmpq(1, a))) < arb(fmpq(1, a)) ** (degree // 2)


def test_a_cluster_of_four():
    core = fmpz_poly([-355, 1130]) ** 4 * 10**60 - 1
    assert len(check(core * fmpz_poly([1, 3, 1, 0, 0, 7]) + fmpz_poly([1]), fmpq(0), fmpq(1))) in (0, 2, 4)
    assert len(check(core, fmpq(0), fmpq(1))) == 2


def test_ends_of_the_interval_belong_to_it():
    p = linear(0) ** 2 * linear(fmpq(1, 3)) * linear(1) ** 3 * fmpz_poly([1, 0, 1])
    assert [(r.rational, r.multiplicity) for r in check(p, fmpq(0), fmpq(1))] == [
        (0, 2),
        (fmpq(1, 3), 1),
        (1, 3),
    ]
    assert [r.multiplicity for r in real_roots(p, fmpq(1), fmpq(1))] == [3]
    assert real_roots(p, fmpq(1, 2), fmpq(1, 2)) == []
    assert real_roots(fmpz_poly([7]), fmpq(0), fmpq(1)) == []
    with pytest.raises(ValueError, match="zero polynomial"):
        real_roots(fmpz_poly([0]), fmpq(0), fmpq(1))


def test_a_double_root_beside_none():
    """A graze counts twice; shaken by 2^-200 either way it is two roots or none."""
    p = fmpz_poly([-2, 0, 9]) ** 2
    (root,) = check(p, fmpq(0), fmpq(1))
    assert root.multiplicity == 2 and root.polynomial == fmpz_poly([-2, 0, 9])
    assert len(check(p * 2**200 - 1, fmpq(0), fmpq(1))) == 2
    assert real_roots(p * 2**200 + 1, fmpq(0), fmpq(1)) == []


def test_roots_of_different_polynomials_and_calls_compare():
    (x,) = real_roots(fmpz_poly([-2, 0, 1]), fmpq(1), fmpq(2))
    (same,) = real_roots(fmpz_poly([-2, 0, 1]) * fmpz_poly([5, 1]), fmpq(0), fmpq(7, 5) + fmpq(1, 10))
    (near,) = real_roots(fmpz_poly([-2, 0, 1]) * 10**60 - 1, fmpq(1), fmpq(2))
    (minus,) = real_roots(fmpz_poly([-2, 0, 1]), fmpq(-2), fmpq(0))
    assert x.compare(same) == 0 == same.compare(x) and x.compare(near) == -1 and near.compare(x) == 1
    assert minus.compare(x) == -1 and x.compare(minus) == 1
    assert x.compare(fmpq(3, 2)) == -1 and x.compare(fmpq(7, 5)) == 1
    assert AlgebraicRoot.of(fmpq(2, 3)).compare(fmpq(2, 3)) == 0
    assert x.sign_of(fmpz_poly([-2, 0, 1]) * fmpz_poly([1, 2, 3])) == 0
    assert x.sign_of(fmpq_poly([fmpq(-1414213562373095, 10**15), 1])) == 1


def test_as_results_show_them():
    (x,) = real_roots(fmpz_poly([-2, 0, 1]), fmpq(1), fmpq(2))
    number = x.number()
    assert isinstance(number, AlgebraicNumber) and number.polynomial == (-2, 0, 1) and float(number) == 2**0.5
    assert float(x) == 2**0.5 and AlgebraicRoot.of(fmpq(1, 3)).number() == Fraction(1, 3)
    assert "degree 2" in repr(x)


def test_half_line_form_bounds_the_number_of_roots():
    p = linear(fmpq(1, 4)) * linear(fmpq(1, 2)) * linear(3)
    assert variations(on_half_line(p, fmpq(0), fmpq(1))) == 2
    assert variations(on_half_line(p, fmpq(1, 3), fmpq(1))) == 1
    assert variations(on_half_line(ONE, fmpq(0), fmpq(1))) == 0
    (one,) = isolate(fmpz_poly([-2, 0, 1]), fmpq(0), fmpq(2))
    assert one[0] < fmpq(3, 2) and one[1] > fmpq(7, 5)


# ------------------------------------------------------------------------------------------ polynomial matrices


def random_matrix(rng, n, m=None, degree=2):
    return tuple(
        tuple(fmpz_poly([rng.randint(-5, 5) for _ in range(degree + 1)]) for _ in range(m or n)) for _ in range(n)
    )


def test_adjugate_and_determinant():
    rng = random.Random(7)
    for n in (2, 3, 4):
        m = random_matrix(rng, n)
        det = determinant(m)
        assert product(m, adjugate(m)) == tuple(
            tuple(det if i == j else fmpz_poly([0]) for j in range(n)) for i in range(n)
        )
    assert determinant(constant([[2]])) == fmpz_poly([1])


def test_constants_keep_their_sign():
    m = constant([[fmpq(-1, 2), fmpq(1, 3)], [0, fmpq(5, 6)]])
    assert m == ((fmpz_poly([-3]), fmpz_poly([2])), (fmpz_poly([0]), fmpz_poly([5])))
    assert constant([[0, 0]]) == ((fmpz_poly([0]), fmpz_poly([0])),)


def test_congruence_is_the_product_of_three():
    rng = random.Random(8)
    q, p = random_matrix(rng, 4), random_matrix(rng, 4, 3)
    q = tuple(tuple(q[i][j] + q[j][i] for j in range(4)) for i in range(4))
    assert congruent(p, q) == product(transpose(p), product(q, p))


def test_primitive_divides_by_what_is_positive_only():
    weight, crossing = fmpz_poly([-2, 2, -2]), fmpz_poly([-1, 2])  # negative everywhere; zero at 1/2
    m = constant([[1, 2], [2, -3]])
    big = tuple(tuple(6 * weight**3 * crossing * x for x in row) for row in m)
    reduced = primitive(big, (fmpq(0), fmpq(1)))
    assert reduced == tuple(tuple(-crossing * x for x in row) for row in m)
    at, before = evaluate(reduced, fmpq(1, 3)), evaluate(big, fmpq(1, 3))
    assert all((x > 0) == (y > 0) for r, s in zip(at, before, strict=True) for x, y in zip(r, s, strict=True))
    assert primitive(big, (fmpq(3, 4), fmpq(1))) == tuple(tuple(-x for x in row) for row in m)
    assert primitive(big) == tuple(tuple(x // fmpz_poly([48]) for x in row) for row in big)
    assert primitive(constant([[0, 0]])) == constant([[0, 0]])


def test_minors_vanish_below_the_rank():
    v = (fmpz_poly([1, 1]), fmpz_poly([2]), fmpz_poly([0, 3]))
    m = tuple(tuple(x * y for y in v) for x in v)
    assert len(minors(m, 2)) == 9 and all(x.is_zero() for x in minors(m, 2))
    assert not all(x.is_zero() for x in minors(m, 1))
