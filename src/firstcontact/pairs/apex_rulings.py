"""Rulings through one apex that are one line, paired by Krawczyk's test instead of algebra in towers of fields.

The lines through a point are a space of three dimensions, in which two of them are one where three independent
components are proportional: two equations in the two parameters.  A box that is proved to hold a zero of these holds a
pair, and the only candidates for either parameter that the box admits are it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import TYPE_CHECKING

from flint import arb, fmpq, fmpz, fmpz_mat, fmpz_poly

from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import dyadic, precision
from firstcontact.exact.systems.square_systems import Equations, certified

if TYPE_CHECKING:
    from firstcontact.pairs.ruled_ruled import Rulings

BITS = 128, 256, 512
"""Of the enclosures with which a pair is proved, one after the other."""


def partners(
    p: Rulings, q: Rulings, u: AlgebraicRoot, u_values: Sequence[AlgebraicRoot], v_values: Sequence[AlgebraicRoot]
) -> list[AlgebraicRoot] | None:
    """The v, among all candidates, whose rulings are that of u; None where it is not proved of all.

    u_values, v_values: all real values of either parameter at which rulings may be one line.
    """
    found = []
    for v in v_values:
        told = (_are_one(p, q, (u, v), (u_values, v_values), bits) for bits in BITS)
        is_one = next((x for x in told if x is not None), None)
        if is_one is None:
            return None
        if is_one:
            found.append(v)
    return found


def _are_one(
    p: Rulings, q: Rulings, pair: tuple[AlgebraicRoot, AlgebraicRoot],
    candidates: tuple[Sequence[AlgebraicRoot], Sequence[AlgebraicRoot]], bits: int,
) -> bool | None:  # fmt: skip
    """Whether both rulings are one line; None where balls of that many bits do not tell."""
    balls = [x.enclosure(bits) for x in pair]
    with precision(2 * bits):
        x, y = ([c(at) for c in side.line] for side, at in zip((p, q), balls, strict=True))
        if not all((x[i] * y[j]).overlaps(x[j] * y[i]) for i, j in combinations(range(6), 2)):
            return False
    for components in _components(p, x):
        box = [dyadic(arb(c.mid())) for c in balls], [dyadic(arb(c.rad())) + fmpq(1, 2**bits) for c in balls]
        zero = certified(Proportional(p, q, components), *box, 2 * bits)
        if zero is not None:
            place = zero.balls(bits)
            told = zip(pair, candidates, place, strict=True)
            is_only = all([c for c in some if c.enclosure(bits).overlaps(at)] == [own] for own, some, at in told)
            return True if is_only and not p.line[components[0]](place[0]).contains(0) else None
    return None


def _components(p: Rulings, line: Sequence[arb]) -> Iterator[tuple[int, int, int]]:
    """Three that tell the lines through the apex apart, the first not zero at the ruling; steep ones first."""
    order = sorted(range(6), key=lambda k: -float(abs(line[k]).mid()))
    through = _through(p.apex)  # type: ignore[arg-type]
    for first in order:
        if line[first].contains(0):
            return
        for others in combinations([k for k in order if k != first], 2):
            chosen = first, *others
            if fmpz_mat([[row[k] for k in chosen] for row in through]).rank() == 3:
                yield chosen


def _through(point: Sequence[fmpz]) -> list[list[fmpz]]:
    """Pluecker vectors that span the lines through a point."""
    pairs = list(combinations(range(4), 2))
    return [[point[i] * (j == k) - point[j] * (i == k) for i, j in pairs] for k in range(4)]


class Proportional(Equations):
    """Three components of two lines are proportional; unknowns: their parameters."""

    def __init__(self, p: Rulings, q: Rulings, components: tuple[int, int, int]) -> None:
        self.lines = [[side.line[k] for k in components] for side in (p, q)]
        self.slopes = [[c.derivative() for c in line] for line in self.lines]

    def values(self, x: Sequence[arb]) -> list[arb]:
        return _minors(*(_at(line, c) for line, c in zip(self.lines, x, strict=True)))

    def jacobian(self, x: Sequence[arb]) -> list[list[arb]]:
        (p, q), (by_u, by_v) = (
            [_at(line, c) for line, c in zip(rows, x, strict=True)] for rows in (self.lines, self.slopes)
        )
        return [list(row) for row in zip(_minors(by_u, q), _minors(p, by_v), strict=True)]


def _at(line: Sequence[fmpz_poly], x: arb) -> list[arb]:
    return [c(x) for c in line]


def _minors(p: Sequence[arb], q: Sequence[arb]) -> list[arb]:
    return [p[0] * q[k] - p[k] * q[0] for k in (1, 2)]
