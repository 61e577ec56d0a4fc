"""Polynomials in u and v: views, factors with python-flint's traps, exact signs at algebraic points."""

from __future__ import annotations

import signal

import pytest
from flint import fmpq, fmpz_poly

from firstcontact.exact.fields.roots import AlgebraicRoot, isolate, real_roots
from firstcontact.exact.polynomials.bivariate import (
    U,
    V,
    chart,
    discriminant,
    evaluate,
    factored,
    factors,
    from_rows,
    in_u,
    in_v,
    level,
    over,
    restrict,
    resultant,
    rows,
    sign_at,
    slope,
    squarefree_factors,
)

F = U**2 * V**3 - 5 * U * V + 7 * V**2 - 2


def sqrt(n: int) -> AlgebraicRoot:
    return real_roots(fmpz_poly([-n, 0, 1]), fmpq(0), fmpq(n))[0]


def test_rows_rebuild_the_polynomial_in_both_variables():
    assert rows(F) == [fmpz_poly([-2]), fmpz_poly([0, -5]), fmpz_poly([7]), fmpz_poly([0, 0, 1])]
    assert from_rows(rows(F)) == F
    assert sum((in_v(c) * U**i for i, c in enumerate(rows(F, "u"))), U * 0) == F


def test_restrictions_are_positive_multiples():
    x, y = fmpq(-2, 3), fmpq(5, 7)
    value = evaluate(rows(F), x, y)
    for p, at in ((restrict(F, "u", x), y), (over(rows(F), x), y), (restrict(F, "v", y), x), (level(rows(F), y), x)):
        assert p(at) / value > 0


def test_charts_reverse_each_variable():
    x, y = fmpq(3, 2), fmpq(-4, 5)
    n, m = 2, 3
    assert evaluate(chart(rows(F), True, False, n), 1 / x, y) * x**n == evaluate(rows(F), x, y)
    assert evaluate(chart(rows(F), False, True, n), x, 1 / y) * y**m == evaluate(rows(F), x, y)
    assert evaluate(chart(rows(F), True, True, n), 1 / x, 1 / y) * x**n * y**m == evaluate(rows(F), x, y)


def test_zero_shares_all_zeros():
    for f in (V - U, U, V):
        assert resultant(f, f - f, "v") == resultant(f - f, f, "u") == 0


def test_slope_resultant_and_discriminant():
    assert from_rows(slope(rows(F))) == F.derivative("v")
    assert resultant(V - U**2, V - 2, "v") in (fmpz_poly([-2, 0, 1]), fmpz_poly([2, 0, -1]))
    assert discriminant(V**2 - U, "v") == fmpz_poly([0, 4])
    assert discriminant(U * V - 1, "v") == 1
    assert resultant(in_u(fmpz_poly([-2, 1])), V**2 - U, "v") == fmpz_poly([-2, 1]) ** 2


def test_factors_keep_single_variables_apart():
    found = factors(6 * (U**2 - 2) ** 3 * (V - 1) * (U * V + 1) ** 2)
    assert found.in_u == [(fmpz_poly([-2, 0, 1]), 3)]
    assert found.in_v == [(fmpz_poly([-1, 1]), 1)]
    assert found.curves == [(U * V + 1, 2)]


def test_factors_with_huge_coefficients():
    """fmpz_mpoly.factor raises OverflowError here."""
    parts = [U * V - 2**40, U + V * 3**40 + 1, U - V + 5**40]
    found = factors(parts[0] * parts[1] * parts[2])
    assert not found.in_u and not found.in_v
    assert sorted(str(g) for g, _ in found.curves) == sorted(str(g) for g in parts)
    assert all(e == 1 for _, e in found.curves)


def test_signs_at_algebraic_points():
    a, b = sqrt(2), sqrt(3)
    assert sign_at(U * V - 2, a, b) == 1
    assert sign_at(U * V - 2, a, a) == 0
    assert sign_at(U * V + 2, a, a) == 1  # zero at a conjugate
    assert sign_at(U**2 * V**2 - 6, a, b) == 0
    assert sign_at(10**60 * (U**2 * V**2 - 6) - 1, a, b) == -1
    assert sign_at(U * V - 3, fmpq(3, 2), fmpq(2)) == 0
    assert sign_at(U - V, fmpq(3, 2), a) == 1
    assert sign_at(U - V, a, fmpq(3, 2)) == -1


def test_isolation_of_squarefree_polynomials_with_rational_roots():
    """Halving hits 0 and 1/2, which are roots: each is found once, between its neighbours."""
    f = fmpz_poly([0, 1]) * fmpz_poly([-1, 2]) * fmpz_poly([-1, 3]) * fmpz_poly([-2, 0, 9]) * fmpz_poly([1, 2])
    found = isolate(f, fmpq(-1), fmpq(1))
    inside = [fmpq(-1, 2), None, fmpq(0), fmpq(1, 3), None, fmpq(1, 2)]
    assert len(found) == 6
    for (lo, hi), value in zip(found, inside, strict=True):
        if value is None:
            assert lo < hi and (9 * lo * lo - 2) * (9 * hi * hi - 2) < 0
        else:
            assert lo == value == hi or lo < value < hi
    assert all(x[1] <= y[0] for x, y in zip(found, found[1:], strict=False))


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="signals cannot be held back there")
@pytest.mark.parametrize("sought", [factored, squarefree_factors])
def test_an_interrupt_waits_while_factors_are_sought(sought):
    """One in a hundred was lost: python-flint drops what a handler raises while it compares factors to sort them."""

    class Interrupted:
        def context(self):
            return None

        def factor(self):
            signal.raise_signal(signal.SIGALRM)
            return 1, [(self, 2)]

        factor_squarefree = factor

    seen = []
    before = signal.signal(signal.SIGALRM, lambda *_: seen.append("raised"))
    try:
        f = Interrupted()
        assert sought(f) == [(f, 2)] and seen == ["raised"]
        seen.clear()
        f.factor = lambda: (signal.raise_signal(signal.SIGALRM), [(f, len(seen))])
        f.factor_squarefree = f.factor
        assert sought(f) == [(f, 0)] and seen == ["raised"]
    finally:
        signal.signal(signal.SIGALRM, before)
