"""Equations that conditions x y <= 0 force: against the signs of x y at many places."""

from itertools import product

import pytest
from flint import fmpq

from firstcontact.contact.signs.forced import forced_equation
from firstcontact.exact.polynomials.trivariate import RING

U, V, T = RING.gens()
HERE = fmpq(-8), fmpq(8)
PLACES = list(product(range(-8, 9), repeat=3))
PAIRS = {
    "equal": (U - V, U - V, HERE),
    "equal up to what is positive": (U - V * T, (U * U + 1) * (U - V * T), HERE),
    "up to what is positive in the range": ((U + 9) * (U - T), U - T, HERE),
    "up to what changes its sign": ((U + 1) * (U - T), U - T, HERE),
    "opposite": (U - V, V - U, HERE),
    "of two signs": (U - V, U + V, HERE),
    "one alone": (U - T, RING.constant(1), HERE),
}


@pytest.mark.parametrize("name", PAIRS)
def test_zeros_are_the_places_where_the_condition_holds(name):
    x, y, ends = PAIRS[name]
    found = forced_equation([(x, y)], ends, ends)
    held = [p for p in PLACES if x(*p) * y(*p) <= 0]
    nowhere_negative = all(x(*p) * y(*p) >= 0 for p in PLACES)
    assert found.is_zero() is not nowhere_negative
    if nowhere_negative:
        assert held == [p for p in PLACES if found(*p) == 0]
