"""Proofs that rulings share no point: Bernstein forms of the conditions on boxes of u, v and T, in doubles.

A box is dropped where Delta has one sign, where both brackets of a pair have the same one, or where all of Q's ends lie
on one side of P's on an axis.  The hull property holds for computed coefficients up to their rounding errors, which the
margin covers: a coefficient is a sum of the exact ones with weights of at most 1, and each halving averages them
`degree` times.
"""

from __future__ import annotations

from math import comb
from typing import NamedTuple

import numpy as np
from flint import fmpq, fmpq_mpoly_ctx, fmpz_mpoly

from firstcontact.exact.numbers import to_double
from firstcontact.exact.trivariate import NAMES, degree
from firstcontact.ruled.conditions import Conditions

_RATIONAL = fmpq_mpoly_ctx.get(NAMES, "lex")
# Relative to the sum of the magnitudes of the coefficients.  Rounding: (terms + degree x halvings) 2^-53 at most, with
# at most 2^12 terms and degree 64 halved 60 times in each of three variables.
MARGIN = 2.0**-38
UNIT = fmpq(-1), fmpq(1)

Span = tuple[fmpq, fmpq]


class Box(NamedTuple):
    """Ranges of the parameters, inverse ones where the chart says so, and of T."""

    inverse: tuple[bool, bool]
    u: Span
    v: Span
    t: Span


def charts(c: Conditions) -> list[tuple[tuple[bool, bool], Conditions]]:
    """Charts that cover the ranges of the parameters."""
    in_u, in_v = ((False, True) if r is None else (False,) for r in (c.u, c.v))
    return [((x, y), c.chart(x, y) if None in (c.u, c.v) else c) for x in in_u for y in in_v]


def survivors(c: Conditions, span: Span, visits: int = 600, depth: int = 45) -> list[Box]:
    """Boxes that may hold contacts, T in the span; none proves that there is none.

    depth: halvings at most.  visits: boxes per chart after which no more are halved.
    """
    found: list[Box] = []
    for inverse, chart in charts(c):
        assert chart.u is not None and chart.v is not None
        found += [Box(inverse, *_cell((chart.u, chart.v, span), path)) for path in _search(chart, span, visits, depth)]
    return found


Path = tuple[tuple[int, int], ...]
"""For each variable how often it was halved, and the index of the part."""


def _search(c: Conditions, span: Span, visits: int, depth: int) -> list[Path]:
    assert c.u is not None and c.v is not None
    pairs = [x for pair in c.pairs for x in pair]
    axes = [x for axis in c.axes for x in axis] if all(c.bounded) else []
    nets = bernstein([c.delta, *pairs, *axes], (c.u, c.v, span))
    live = nets[None]
    index = np.zeros((1, 3), dtype=object)
    halved = [0, 0, 0]
    size = [n - 1 for n in nets.shape[1:]]
    free = [k for k in range(3) if size[k] > 0]
    count = 0
    while True:
        keep = ~_excluded(live, len(pairs), len(axes))
        live, index = live[keep], index[keep]
        count += len(keep)
        if not len(live) or not free or count > visits or sum(halved) >= depth:
            break
        # the variable along which the nets vary most
        spread = [np.abs(np.diff(live, axis=2 + k)).sum(axis=2 + k).max(axis=(1, 2, 3)).sum() for k in free]
        k = free[int(np.argmax(spread))]
        live = _halves(live, 2 + k)
        low, high = index.copy(), index.copy()
        low[:, k], high[:, k] = 2 * index[:, k], 2 * index[:, k] + 1
        index = np.concatenate([low, high])
        halved[k] += 1
    return [tuple((halved[k], int(row[k])) for k in range(3)) for row in index]


def _cell(ranges: tuple[Span, Span, Span], path: Path) -> tuple[Span, Span, Span]:
    cells = []
    for (lo, hi), (times, index) in zip(ranges, path, strict=True):
        step = (hi - lo) / fmpq(2) ** times
        cells.append((lo + index * step, lo + (index + 1) * step))
    return cells[0], cells[1], cells[2]


def _excluded(live: np.ndarray, pairs: int, axes: int) -> np.ndarray:
    """(n,) bools."""
    flat = live.reshape(*live.shape[:2], -1)
    above, below = flat.min(axis=2) > MARGIN, flat.max(axis=2) < -MARGIN
    out = above[:, 0] | below[:, 0]
    for signs in (above, below):
        both = signs[:, 1 : 1 + pairs].reshape(len(live), -1, 2).all(axis=2).any(axis=1)
        out |= both
        if axes:
            out |= signs[:, 1 + pairs :].reshape(len(live), 3, 4).all(axis=2).any(axis=1)
    return out


def _halves(nets: np.ndarray, axis: int) -> np.ndarray:
    """The nets of the lower halves, then those of the upper ones, along one axis (de Casteljau)."""
    work = np.moveaxis(nets, axis, 0)
    n = len(work)
    lower, upper = np.empty_like(work), np.empty_like(work)
    for i in range(n):
        lower[i], upper[n - 1 - i] = work[0], work[-1]
        work = 0.5 * (work[:-1] + work[1:])
    return np.moveaxis(np.concatenate([lower, upper], axis=1), 0, axis)


def bernstein(polynomials: list[fmpz_mpoly], ranges: tuple[Span, Span, Span]) -> np.ndarray:
    """(k, l, m, n) Bernstein coefficients on a box, each polynomial scaled so that its magnitudes add up to 1."""
    size = [max(degree(f, k) for f in polynomials) for k in range(3)]
    power = np.zeros((len(polynomials), *(n + 1 for n in size)))
    arguments = []
    for (lo, hi), x in zip(ranges, _RATIONAL.gens(), strict=True):
        arguments.append(lo + (hi - lo) * x)
    for row, f in zip(power, polynomials, strict=True):
        if f.is_zero():
            continue
        g = _RATIONAL.from_dict(f.to_dict()).compose(*arguments, ctx=_RATIONAL)
        total = sum((abs(x) for x in g.coeffs()), fmpq(0))
        if total == 0:
            continue
        for key, x in zip(g.monoms(), g.coeffs(), strict=True):
            row[tuple(map(int, key))] = to_double(x / total)
    for axis, n in enumerate(size):
        to_bernstein = np.array([[comb(i, j) / comb(n, j) if j <= i else 0.0 for j in range(n + 1)] for i in range(n + 1)])
        power = np.moveaxis(np.tensordot(to_bernstein, power, axes=(1, axis + 1)), 0, axis + 1)
    return power
