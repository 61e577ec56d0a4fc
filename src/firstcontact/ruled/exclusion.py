"""Proofs that rulings share no point: Bernstein forms of the conditions on boxes of u, v and T, in doubles.

A box is dropped where the signs that are certain on it contradict the conditions.  The hull property holds for
computed coefficients up to their rounding errors, which the margin covers: a coefficient is a sum of the exact ones
with weights of at most 1, and each halving averages them `degree` times.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import comb
from typing import NamedTuple

import numpy as np
from flint import fmpq

from firstcontact.exact.numbers import to_double
from firstcontact.exact.trivariate import degree, terms
from firstcontact.ruled.conditions import SignConditions

# Relative to the largest coefficient with absolute values in place of all numbers.
# Rounding: (terms + degree x halvings) 2^-53 at most, with
# at most 2^12 terms and degree 64 halved 60 times in each of three variables.
MARGIN = 2.0**-38

Span = tuple[fmpq, fmpq]


class Box(NamedTuple):
    """Ranges of the parameters, inverse ones where the chart says so, and of T."""

    inverse: tuple[bool, bool]
    u: Span
    v: Span
    t: Span


def survivors(c: SignConditions, span: Span, visits: int = 600, depth: int = 45) -> list[Box]:
    """Boxes that may hold contacts, T in the span; none proves that there is none.

    depth: halvings at most.  visits: boxes after which no more are halved.
    """
    parts = list(c.charts.items())
    nets = [_nets(chart, (*_ranges(chart), span)) for _, chart in parts]
    size = [max(n.shape[k] for n in nets) for k in range(2, 5)]
    live = np.concatenate([_elevated(n, size) for n in nets])
    found: list[Box] = []
    for chart, path in _search(live, c.excludes, visits, depth):
        inverse, own = parts[chart]
        found.append(Box(inverse, *_cell((*_ranges(own), span), path)))
    return found


def signs_over(c: SignConditions, ranges: tuple[Span, Span, Span]) -> tuple[np.ndarray, np.ndarray]:
    """(k,) bools each: which polynomials are proved positive, which negative over ranges of u, v and T."""
    flat = _nets(c, ranges).reshape(len(c.polynomials), -1)
    return flat.min(axis=1) > MARGIN, flat.max(axis=1) < -MARGIN


def _ranges(c: SignConditions) -> tuple[Span, Span]:
    assert c.u is not None and c.v is not None
    return c.u, c.v


Excludes = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""As `Conditions.excludes`."""
Path = tuple[tuple[int, int], ...]
"""For each variable how often it was halved, and the index of the part."""


def _search(live: np.ndarray, excludes: Excludes, visits: int, depth: int) -> list[tuple[int, Path]]:
    """(chart, path) of the boxes left; live: (charts, polynomials, l, m, n) nets, Delta first."""
    index = np.zeros((len(live), 4), dtype=object)
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
        live = _halves(live, 2 + k)
        low, high = index.copy(), index.copy()
        low[:, 1 + k], high[:, 1 + k] = 2 * index[:, 1 + k], 2 * index[:, 1 + k] + 1
        index = np.concatenate([low, high])
        halved[k] += 1
    return [(int(row[0]), tuple((halved[k], int(row[1 + k])) for k in range(3))) for row in index]


def _cell(ranges: tuple[Span, Span, Span], path: Path) -> tuple[Span, Span, Span]:
    cells = []
    for (lo, hi), (times, index) in zip(ranges, path, strict=True):
        step = (hi - lo) / fmpq(2) ** times
        cells.append((lo + index * step, lo + (index + 1) * step))
    return cells[0], cells[1], cells[2]


def _halves(nets: np.ndarray, axis: int) -> np.ndarray:
    """The nets of the lower halves, then those of the upper ones, along one axis (de Casteljau)."""
    work = np.moveaxis(nets, axis, 0)
    n = len(work)
    lower, upper = np.empty_like(work), np.empty_like(work)
    for i in range(n):
        lower[i], upper[n - 1 - i] = work[0], work[-1]
        work = 0.5 * (work[:-1] + work[1:])
    return np.moveaxis(np.concatenate([lower, upper], axis=1), 0, axis)


def _nets(c: SignConditions, ranges: tuple[Span, Span, Span]) -> np.ndarray:
    """(1, k, l, m, n) Bernstein coefficients of the polynomials on the ranges.

    Each polynomial is scaled: with absolute values in place of all numbers no coefficient would be above 1.
    """
    nets = powers(c)
    bound = np.abs(nets)
    for axis, ends in enumerate(ranges):
        change = _to_bernstein(nets.shape[axis + 1] - 1, *ends)
        nets = np.moveaxis(np.tensordot(change, nets, axes=(1, axis + 1)), 0, axis + 1)
        bound = np.moveaxis(np.tensordot(np.abs(change), bound, axes=(1, axis + 1)), 0, axis + 1)
    scale = bound.max(axis=(1, 2, 3), keepdims=True)
    return (nets / np.where(scale > 0, scale, 1.0))[None]


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
    return c.known["powers"]  # type: ignore[no-any-return]


@lru_cache(maxsize=256)
def _to_bernstein(n: int, lo: fmpq, hi: fmpq) -> np.ndarray:
    """(n + 1, n + 1) from coefficients of powers to those of the Bernstein form on [lo, hi]; one row where lo = hi."""
    if lo == hi:
        return np.array([[to_double(lo**j) for j in range(n + 1)]])
    rows = []
    for i in range(n + 1):
        # the blossom of x^j with i arguments hi and n - i arguments lo
        row = []
        for j in range(n + 1):
            parts = range(max(0, i + j - n), min(i, j) + 1)
            total = sum((comb(i, m) * comb(n - i, j - m) * hi**m * lo ** (j - m) for m in parts), fmpq(0))
            row.append(to_double(total / comb(n, j)))
        rows.append(row)
    return np.array(rows)


def _elevated(nets: np.ndarray, size: list[int]) -> np.ndarray:
    """The same polynomials with nets of a higher degree."""
    for axis, n in enumerate(size):
        while nets.shape[axis + 2] < n:
            work = np.moveaxis(nets, axis + 2, 0)
            m = len(work)
            weight = (np.arange(m + 1) / m).reshape(-1, *[1] * (work.ndim - 1))
            zero = np.zeros_like(work[:1])
            work = weight * np.concatenate([zero, work]) + (1 - weight) * np.concatenate([work, zero])
            nets = np.moveaxis(work, 0, axis + 2)
    return nets
