"""How two polynomial ruled pieces meet near a point in which they cross: a power series in exact arithmetic."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import firstcontact as fc

# Of the series: what is zero up to here counts as zero.
ORDER = 5

Series = list[Fraction]
Directrix = list[list[Fraction]]
"""Coefficients of X, Y, Z."""


@dataclass(frozen=True)
class Scene:
    """Two pieces through one point, each known by both directrices and its place (u, s), and the bounds."""

    first: tuple[Directrix, Directrix]
    second: tuple[Directrix, Directrix]
    places: tuple[tuple[Fraction, Fraction], tuple[Fraction, Fraction]]
    ranges: tuple[tuple[tuple[int, int], tuple[int, int]], tuple[tuple[int, int], tuple[int, int]]]
    """(u, s) of both."""

    @property
    def point(self) -> list[Fraction]:
        return evaluated(self.first, *self.places[0])

    def surfaces(self) -> tuple[fc.RuledSurface, fc.RuledSurface]:
        found = [fc.RuledSurface(*(fc.RationalCurve(x) for x in ends), u=u, s=s)
                 for ends, (u, s) in zip((self.first, self.second), self.ranges, strict=True)]  # fmt: skip
        return found[0], found[1]

    def rays(self) -> int | None:
        """How many ways lead from the point along the common curve inside both pieces; None: that is not told."""
        steps = curve_at(self.first, self.second, self.places)
        if steps is None:
            return None
        bounds = [x for pair in self.ranges for x in pair]
        at = [x for pair in self.places for x in pair]
        ways = {1, -1}
        for x, (low, high), series in zip(at, bounds, steps, strict=True):
            k = next((k for k, c in enumerate(series) if c), None)
            for end, inward in ((low, 1), (high, -1)):
                if x == end:
                    if k is None:
                        return None
                    ways = {way for way in ways if inward * series[k] * way**k > 0}
        return len(ways)


    def turns_back(self) -> bool | None:
        """Whether the common curve has a cusp at the point; None: that is not told."""
        steps = curve_at(self.first, self.second, self.places)
        if steps is None:
            return None
        u, s = ([x + c[0], *c[1:]] for x, c in zip(self.places[0], steps, strict=False))
        moves = zip(*_point(self.first, u, s), strict=True)
        k = next((k for k, move in enumerate(moves) if k and any(move)), None)
        return None if k is None else k % 2 == 0

    def has_points_as_rulings(self) -> bool:
        """Whether one of the two rulings through the point is a point."""
        return any(not any(slopes(ends, *place)[1])
                   for ends, place in zip((self.first, self.second), self.places, strict=True))  # fmt: skip


def evaluated(ends: Sequence[Directrix], u: Fraction, s: Fraction) -> list[Fraction]:
    """A point of a piece."""
    return [x[0] for x in _point(ends, [u, Fraction(0)], [s, Fraction(0)])]


def slopes(ends: Sequence[Directrix], u: Fraction, s: Fraction) -> tuple[list[Fraction], list[Fraction]]:
    """P_u and P_s."""
    zero, one = Fraction(0), Fraction(1)
    along_u, along_s = (_point(ends, [u, x], [s, y]) for x, y in ((one, zero), (zero, one)))
    return [x[1] for x in along_u], [x[1] for x in along_s]


def curve_at(
    p: Sequence[Directrix], q: Sequence[Directrix], places: tuple[tuple[Fraction, Fraction], ...]
) -> list[Series] | None:
    """u, s, v, t along the common curve less their values at the place; None where the surfaces do not cross there."""
    steps = [[Fraction(0)] * (ORDER + 1) for _ in range(4)]
    start = [x for pair in places for x in pair]

    def gap() -> list[Series]:
        u, s, v, t = ([x + c[0], *c[1:]] for x, c in zip(start, steps, strict=True))
        return [[a - b for a, b in zip(x, y, strict=True)]
                for x, y in zip(_point(p, u, s), _point(q, v, t), strict=True)]  # fmt: skip

    columns = []
    for step in steps:
        step[1] = Fraction(1)
        columns.append([x[1] for x in gap()])
        step[1] = Fraction(0)
    free = next((k for k in range(4) if _solved([c for i, c in enumerate(columns) if i != k], [0, 0, 0])), None)
    if free is None:
        return None
    others = [i for i in range(4) if i != free]
    steps[free][1] = Fraction(1)
    for k in range(1, ORDER + 1):
        found = _solved([columns[i] for i in others], [-x[k] for x in gap()])
        assert found is not None
        for i, x in zip(others, found, strict=True):
            steps[i][k] += x
    return steps


def _point(ends: Sequence[Directrix], u: Series, s: Series) -> list[Series]:
    first, second = ([_composed(c, u) for c in end] for end in ends)
    return [[a + x for a, x in zip(f, _times(s, [b - a for a, b in zip(f, g, strict=True)]), strict=True)]
            for f, g in zip(first, second, strict=True)]  # fmt: skip


def _composed(coefficients: Sequence[Fraction], x: Series) -> Series:
    total = [Fraction(0)] * len(x)
    for c in reversed(coefficients):
        total = _times(total, x)
        total[0] += c
    return total


def _times(a: Series, b: Series) -> Series:
    return [sum((a[i] * b[k - i] for i in range(k + 1)), Fraction(0)) for k in range(len(a))]


def _solved(columns: Sequence[Sequence[Fraction]], right: Sequence[Fraction]) -> list[Fraction] | None:
    """Cramer's rule; None for a singular matrix."""
    def det(a: Sequence[Fraction], b: Sequence[Fraction], c: Sequence[Fraction]) -> Fraction:
        return (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                + a[2] * (b[0] * c[1] - b[1] * c[0]))  # fmt: skip

    whole = det(*columns)
    if whole == 0:
        return None
    return [det(*(right if i == k else c for i, c in enumerate(columns))) / whole for k in range(3)]
