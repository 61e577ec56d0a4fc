"""Coefficients of powers as those of the Bernstein form, against values at points."""

from math import comb

import numpy as np
import pytest
from flint import fmpq

from firstcontact.contact.signs.exclusion import _to_bernstein, to_bernstein_exactly

RANGES = [(fmpq(0), fmpq(1)), (fmpq(-1), fmpq(1)), (fmpq(1, 3), fmpq(5, 7)), (fmpq(-3, 8), fmpq(0)),
          (fmpq(12345, 2**40), fmpq(12347, 2**40))]  # fmt: skip


@pytest.mark.parametrize("n", [0, 1, 2, 9, 30])
@pytest.mark.parametrize("ends", RANGES)
def test_the_polynomial_is_the_same(n, ends):
    lo, hi = ends
    powers = [fmpq((7 * k + 3) % 11 - 5, k + 1) for k in range(n + 1)]
    net = [sum((x * c for x, c in zip(row, powers, strict=True)), fmpq(0)) for row in to_bernstein_exactly(n, lo, hi)]
    for s in (fmpq(0), fmpq(1), fmpq(1, 3), fmpq(5, 2)):
        x = lo + (hi - lo) * s
        bent = sum((c * comb(n, i) * (1 - s) ** (n - i) * s**i for i, c in enumerate(net)), fmpq(0))
        assert bent == sum((c * x**k for k, c in enumerate(powers)), fmpq(0))


@pytest.mark.parametrize("ends", [*RANGES, (fmpq(2, 7), fmpq(2, 7))])
def test_doubles_are_nearest(ends):
    exact = to_bernstein_exactly(9, *ends)
    assert np.array_equal(_to_bernstein(9, *ends), [[int(x.p) / int(x.q) for x in row] for row in exact])


def test_at_a_point_there_is_one_row_of_powers():
    assert to_bernstein_exactly(3, fmpq(2, 7), fmpq(2, 7)) == [[fmpq(2, 7) ** k for k in range(4)]]
