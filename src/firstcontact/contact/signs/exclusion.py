"""Proofs that rulings share no point: Bernstein forms of the conditions on boxes of u, v and T, in doubles.

A box is dropped where the signs that are certain on it contradict the conditions.  The hull property holds for
computed coefficients up to their rounding errors, which the margin covers: a coefficient is a sum of the exact ones
with weights of at most 1, and each halving averages them `degree` times.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from math import comb
from typing import NamedTuple

import numpy as np
from flint import fmpq, fmpz, fmpz_poly

from firstcontact.contact.signs.conditions import SignConditions
from firstcontact.exact.polynomials.trivariate import degree, terms

# Relative to the largest coefficient with absolute values in place of all numbers.
# Rounding: (terms + degree x halvings) 2^-53 at most, with
# at most 2^12 terms and degree 64 halved 60 times in each of three variables.
# It covers a T that is off by INSTANT, too: powers of degree 64 at most are then off by less than 2^-43 of themselves.
MARGIN = 2.0**-38
INSTANT = fmpq(1, 2**50)
"""Part of a T by which it may be off as if it were known."""

Span = tuple[fmpq, fmpq]


class ParameterBox(NamedTuple):
    """Ranges of the parameters, inverse ones where the chart says so, and of T."""

    inverse: tuple[bool, bool]
    u: Span
    v: Span
    t: Span


def survivors(c: SignConditions, span: Span, visits: int = 600, depth: int = 45) -> list[ParameterBox]:
    """Boxes that may hold contacts, T in the span; none proves that there is none.

    depth: halvings at most, below 63.  visits: boxes after which no more are halved.
    """
    inverse, charts = list(c.charts), list(c.charts.values())
    assert charts[0].u is not None and charts[0].v is not None  # ranges that all charts have
    lo, hi = span
    ranges = charts[0].u, charts[0].v, (lo, lo) if hi - lo <= INSTANT * abs(lo) else span
    index, halved = search(_nets(_together([powers(chart) for chart in charts]), ranges), c.excludes, visits, depth)
    return boxes_of(index, halved, inverse, (ranges[0], ranges[1], span))


def boxes_of(
    index: np.ndarray, halved: Sequence[int], inverse: Sequence[tuple[bool, bool]], ranges: tuple[Span, Span, Span]
) -> list[ParameterBox]:
    """Those that `search` found in the ranges; inverse: by chart."""
    sides: dict[tuple[int, int], Span] = {}
    found: list[ParameterBox] = []
    for chart, *path in index.tolist():
        for k, i in enumerate(path):
            if (k, i) not in sides:
                lo, hi = ranges[k]
                step = (hi - lo) / 2 ** halved[k]
                sides[k, i] = lo + i * step, lo + (i + 1) * step
        found.append(ParameterBox(inverse[chart], *(sides[k, i] for k, i in enumerate(path))))
    return found


def clusters(boxes: Sequence[ParameterBox]) -> list[tuple[Span, Span]]:
    """Hulls of boxes that touch each other."""
    groups: list[tuple[Span, Span]] = []
    for box in boxes:
        u, v = box.u, box.v
        apart = []
        for x, y in groups:
            if x[0] <= u[1] and u[0] <= x[1] and y[0] <= v[1] and v[0] <= y[1]:
                u, v = (min(x[0], u[0]), max(x[1], u[1])), (min(y[0], v[0]), max(y[1], v[1]))
            else:
                apart.append((x, y))
        groups = [*apart, (u, v)]
    return groups


def signs_over(c: SignConditions, ranges: tuple[Span, Span, Span]) -> tuple[np.ndarray, np.ndarray]:
    """(k,) bools each: which polynomials are proved positive, which negative over ranges of u, v and T."""
    flat = _nets(powers(c)[None], ranges).reshape(len(c.polynomials), -1)
    return flat.min(axis=1) > MARGIN, flat.max(axis=1) < -MARGIN


Excludes = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""As `Conditions.excludes`."""


def search(live: np.ndarray, excludes: Excludes, visits: int, depth: int) -> tuple[np.ndarray, list[int]]:
    """(n, 4) chart and index among the parts of each variable's range of the boxes left; how often they were halved.

    live: (charts, polynomials, l, m, n) nets, Delta first.
    """
    index = np.zeros((len(live), 4), np.int64)
    index[:, 0] = range(len(live))
    halved = [0, 0, 0]
    free = [k for k in range(3) if live.shape[2 + k] > 1]
    shown = 1 if live[:, 0].any() else live.shape[1]
    count = 0
    while True:
        flat = live.reshape(*live.shape[:2], -1)
        keep = ~excludes(flat.min(axis=2) > MARGIN, flat.max(axis=2) < -MARGIN)
        live, index = live[keep], index[keep]
        count += len(keep)
        if not len(live) or not free or count > visits or sum(halved) >= depth:
            break
        # the variable along which the nets vary most
        seen = live[:, :shown]
        k = free[int(np.argmax([np.abs(np.diff(seen, axis=2 + k)).sum() / (seen.shape[2 + k] - 1) for k in free]))]
        live = halves(live, 2 + k)
        low, high = index.copy(), index.copy()
        low[:, 1 + k], high[:, 1 + k] = 2 * index[:, 1 + k], 2 * index[:, 1 + k] + 1
        index = np.concatenate([low, high])
        halved[k] += 1
    return index, halved


def halves(nets: np.ndarray, axis: int) -> np.ndarray:
    """The nets of the lower halves, then those of the upper ones, along one axis (de Casteljau)."""
    work = np.moveaxis(nets, axis, 0)
    n = len(work)
    lower, upper = np.empty_like(work), np.empty_like(work)
    for i in range(n):
        lower[i], upper[n - 1 - i] = work[0], work[-1]
        work = 0.5 * (work[:-1] + work[1:])
    return np.moveaxis(np.concatenate([lower, upper], axis=1), 0, axis)


def _together(tables: list[np.ndarray]) -> np.ndarray:
    """Tables of coefficients of powers as one, with zeros where some have none."""
    size = [max(n) for n in zip(*(table.shape for table in tables), strict=True)]
    found = np.zeros((len(tables), *size))
    for own, table in zip(found, tables, strict=True):
        own[tuple(slice(n) for n in table.shape)] = table
    return found


def _nets(tables: np.ndarray, ranges: tuple[Span, Span, Span]) -> np.ndarray:
    """(charts, k, l, m, n) Bernstein coefficients on the ranges of polynomials with these coefficients of powers.

    Each polynomial is scaled: with absolute values in place of all numbers no coefficient would be above 1.
    """
    nets, bound = tables, np.abs(tables)
    for axis, ends in enumerate(ranges, 2):
        change = _to_bernstein(nets.shape[axis] - 1, *ends)
        nets = np.moveaxis(np.tensordot(change, nets, axes=(1, axis)), 0, axis)
        bound = np.moveaxis(np.tensordot(np.abs(change), bound, axes=(1, axis)), 0, axis)
    scale = bound.max(axis=(2, 3, 4), keepdims=True)
    return nets / np.where(scale > 0, scale, 1.0)


def powers(c: SignConditions) -> np.ndarray:
    """(k, l, m, n) coefficients of u^i v^j T^k, scaled to a sum of magnitudes of 1."""
    if "powers" not in c.known:
        polynomials = c.polynomials
        size = [max(degree(f, k) for f in polynomials) + 1 for k in range(3)]
        table = np.zeros((len(polynomials), *size))
        for row, f in zip(table, polynomials, strict=True):
            total = sum(abs(int(x)) for x in f.coeffs())
            for key, x in terms(f):
                row[key] = int(x) / total
        c.known["powers"] = table
    known: np.ndarray = c.known["powers"]
    return known


@lru_cache(maxsize=256)
def _to_bernstein(n: int, lo: fmpq, hi: fmpq) -> np.ndarray:
    """(n + 1, n + 1) from coefficients of powers to those of the Bernstein form on [lo, hi]; one row where lo = hi."""
    numbers, below = _bernstein_in_integers(n, lo, hi)
    return np.array([[int(x) / b for x, b in zip(row, below, strict=True)] for row in numbers])


def to_bernstein_exactly(n: int, lo: fmpq, hi: fmpq) -> list[list[fmpq]]:
    """The same in rational numbers."""
    numbers, below = _bernstein_in_integers(n, lo, hi)
    return [[fmpq(x, b) for x, b in zip(row, below, strict=True)] for row in numbers]


def _bernstein_in_integers(n: int, lo: fmpq, hi: fmpq) -> tuple[list[list[fmpz]], list[int]]:
    """The same as numerators, and a denominator for each column."""
    q = lo.q.lcm(hi.q)
    if lo == hi:
        return [[lo.p**j * lo.q ** (n - j) for j in range(n + 1)]], [int(q) ** n] * (n + 1)
    of_lo, of_hi = (fmpz_poly([q, x.p * (q // x.q)]) for x in (lo, hi))
    # the blossom of x^j with i arguments hi and n - i arguments lo: their elementary symmetric functions
    sums = [of_lo**n]
    for _ in range(n):
        sums.append(sums[-1] // of_lo * of_hi)
    return [[row[j] for j in range(n + 1)] for row in sums], [int(q) ** n * comb(n, j) for j in range(n + 1)]
