"""Zeros of polynomials over a number field, built from zeros that are known; those at the ends of the range count."""

from __future__ import annotations

from random import Random

import pytest
from flint import fmpq, fmpz_poly

from firstcontact.exact.fields.common_field import adjoined
from firstcontact.exact.fields.number_field import FieldElement, NumberField, sign
from firstcontact.exact.fields.roots import real_roots

FIELD = NumberField(real_roots(fmpz_poly([-2, 0, 0, 1]), fmpq(1), fmpq(2))[0])


def with_zeros(zeros: list[FieldElement]) -> list[FieldElement]:
    f = [FIELD(1)]
    for x in zeros:
        f = [below - x * here for below, here in zip([FIELD(0), *f], [*f, FIELD(0)], strict=True)]
    return f


@pytest.mark.parametrize("seed", range(8))
def test_all_zeros_in_the_range_and_no_others(seed: int) -> None:
    rng = Random(seed)
    r, lo, hi = FIELD.generator(), fmpq(-1), fmpq(2, 3)
    zeros = [FIELD(lo), FIELD(hi)][: rng.randint(0, 2)]
    zeros += [r * fmpq(rng.randint(-9, 9), 4) + fmpq(2 * rng.randint(-9, 9) + 1, 8) for _ in range(2)]
    wanted = [x for x in zeros if sign(x - lo) >= 0 and sign(x - hi) <= 0]
    found = adjoined(FIELD, with_zeros(zeros), lo, hi)
    assert len(found) == len({x.ball(64).str(10) for x in wanted})
    assert all(any((z.zero - z.carry(x)).is_zero() for x in wanted) for z in found)


def test_nothing_is_too_large_where_there_are_no_zeros() -> None:
    """x^40 + r: beyond the degree that elimination takes; balls tell that there is no zero."""
    assert adjoined(FIELD, [FIELD.generator(), *[FIELD(0)] * 39, FIELD(1)], fmpq(-1), fmpq(1)) == []
