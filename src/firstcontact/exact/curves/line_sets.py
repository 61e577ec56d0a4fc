"""Where on a line none of several polynomials over Q(r) is negative: closed intervals, half-lines and points."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from flint import arb, fmpq

from firstcontact.exact.curves.fibres import PrecisionExhausted, simple_between, simple_zeros
from firstcontact.exact.fields.common_field import Polynomial, horner, refined
from firstcontact.exact.fields.field_towers import division, trimmed
from firstcontact.exact.fields.number_field import NumberField, ball, is_zero, sign
from firstcontact.exact.numbers import PRECISIONS, dyadic, precision

Part = tuple[arb | None, arb | None]
"""Enclosures of both ends, which are one object for a point; None: no end."""


def not_negative(field: NumberField, polynomials: Sequence[Polynomial], bits: int) -> list[Part]:
    """The parts of the line, ascending, their ends to 2^-bits."""
    given = [f for f in map(trimmed, map(list, polynomials)) if f]
    basis = refined(given)
    zeros = _zeros(basis, bits)
    vanishes = [[not any(not is_zero(c) for c in division(f, g)[1]) for f in given] for g in basis]
    parts: list[Part] = []
    open_since: arb | None = None
    was_inside = False
    # one step for every open interval and the zero before it
    for k, x in enumerate(_samples([zero for zero, _ in zeros])):
        positive = [sign(horner(f, field(x), field(0))) > 0 for f in given]
        inside = all(positive)
        if k:
            zero, own = zeros[k - 1]
            # a polynomial that does not vanish here has the sign that it has beside it
            on = all(a or b for a, b in zip(vanishes[own], positive, strict=True))
            if was_inside and not inside:
                parts.append((open_since, zero))
            elif inside and not was_inside:
                open_since = zero
            elif on and not inside:
                parts.append((zero, zero))
        was_inside = inside
    return [*parts, (open_since, None)] if was_inside else parts


def _zeros(basis: Sequence[Polynomial], bits: int) -> list[tuple[arb, int]]:
    """All real zeros of coprime polynomials, ascending, and whose they are."""
    for work in PRECISIONS:
        if work < bits + 64:
            continue
        with precision(work):
            each = [simple_zeros([ball(c, work) for c in f], bits + 4) for f in basis]
            found = [(x, k) for k, own in enumerate(each) if own is not None for x in own]
            found.sort(key=lambda zero: float(zero[0].mid()))
            if None not in each and all(x < y for (x, _), (y, _) in pairwise(found)):
                return found
    raise PrecisionExhausted(f"zeros over {basis[0][0].field.root}")


def _samples(zeros: Sequence[arb]) -> list[fmpq]:
    """A number in every open interval between neighbours, before and after all."""
    if not zeros:
        return [fmpq(0)]
    with precision(PRECISIONS[-1]):
        ends = [(dyadic(x.lower()), dyadic(x.upper())) for x in zeros]
    between = [simple_between(x[1], y[0]) for x, y in pairwise(ends)]
    return [ends[0][0] - 1, *between, ends[-1][1] + 1]
