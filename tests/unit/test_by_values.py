"""Resultants and discriminants from values, against FLINT's elimination and against known zeros."""

from math import prod
from random import Random

import pytest
from flint import fmpz_poly

from firstcontact.exact.polynomials import bivariate, by_values, trivariate
from firstcontact.exact.polynomials.by_values import is_quicker


def rows(rng: Random, degree: int, other: int, bits: int = 12) -> list[fmpz_poly]:
    while True:
        found = [fmpz_poly([rng.randint(-(2**bits), 2**bits) for _ in range(other + 1)]) for _ in range(degree + 1)]
        if found[-1].degree() > 0:
            return found


@pytest.mark.parametrize("seed", range(12))
def test_as_by_subresultants(seed: int) -> None:
    rng = Random(seed)
    f, g = rows(rng, rng.randint(1, 7), 3), rows(rng, rng.randint(1, 5), 2)
    f[-1] = fmpz_poly([0, -2, 1]) * fmpz_poly([1, 1])  # vanishes at the first places
    a, b = bivariate.from_rows(f), bivariate.from_rows(g)
    assert by_values.resultant(f, g) == bivariate.univariate(a.resultant(b, "v"), "u")
    if len(f) > 2:
        assert by_values.discriminant(f) == bivariate.univariate(a.discriminant("v"), "u")


def test_shared_factor_leaves_nothing() -> None:
    rng = Random(5)
    common, f, g = (bivariate.from_rows(rows(rng, 3, 2)) for _ in range(3))
    assert by_values.resultant(bivariate.rows(common * f), bivariate.rows(common * g)).is_zero()
    assert by_values.discriminant(bivariate.rows(common * common * f)).is_zero()


@pytest.mark.parametrize("seed", range(4))
def test_zeros_are_where_linear_factors_meet(seed: int) -> None:
    """Of f = prod (u - x_i(T)) and g = prod (u - y_j(T)) the resultant is prod (x_i - y_j)."""
    rng = Random(seed)
    u, t = trivariate.RING.gen(0), trivariate.RING.gen(2)
    xs, ys = ([rng.randint(-9, 9) * t + rng.randint(-9, 9) for _ in range(n)] for n in (7, 6))
    assert is_quicker(7, 6)
    f, g = (prod((u - x for x in some), start=trivariate.RING.constant(1)) for some in (xs, ys))
    expected = prod((x - y for x in xs for y in ys), start=trivariate.RING.constant(1))
    assert trivariate.resultant(f, g, 0) == expected
    gaps = prod(((x - y) ** 2 for i, x in enumerate(xs) for y in xs[:i]), start=trivariate.RING.constant(1))
    assert trivariate.discriminant(f, 0) == gaps
