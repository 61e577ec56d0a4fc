"""All times at which a solid holds places of a ruled piece, exactly, over one piece of their motion.

A place inside the solid stays there until the first surface passes it, which is the root of a polynomial in T alone;
and boxes on which certain signs rule contact out are free.  What neither covers are short stretches around the events;
each is left to elimination, with those surfaces alone that pass the piece near contacts then.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from flint import fmpq

from firstcontact.contact.ruled_solid.solid_conditions import SolidConditions
from firstcontact.contact.signs.exclusion import ParameterBox, Span, clusters, powers, signs_over, survivors
from firstcontact.contact.signs.shared_points import FieldPoint
from firstcontact.contact.signs.sheets import FARTHEST, Reach, dyadic_between
from firstcontact.contact.signs.times import Times, enclosed
from firstcontact.exact.fields.roots import AlgebraicRoot, roots_in
from firstcontact.exact.numbers import sign, to_double
from firstcontact.exact.polynomials.trivariate import at, univariate
from firstcontact.timeline.lasting import tree_height
from firstcontact.work import Work

VISITS, DEPTH = 300, 30
FEW = 2
"""Surfaces, or trimming polynomials, that elimination takes at once."""
STALE = 4
"""Halvings of the time that leave them all, after which it takes whatever there are."""
DEEPEST = 20
"""Cuts of the span, one within the other, after which it takes what is left."""
MOST_BOXES = 64
"""Grouped one by one."""
MOST = 24
"""Stretches beyond which the span is not cut."""
STEPS = 2
"""Of work, that a stretch looked at counts as."""
GRID = 25
"""Places of the piece in either direction among which one inside the solid is sought."""


@dataclass(frozen=True)
class HeldTimes:
    """A stretch of contact throughout; as `contact.signs.times.Times`."""

    conditions: SolidConditions
    span: Span
    candidates = ()

    def windows(self) -> Iterator[tuple[AlgebraicRoot, AlgebraicRoot]]:
        lo, hi = (AlgebraicRoot.of(x) for x in self.span)
        yield lo, hi

    def states(self) -> Iterator[tuple[AlgebraicRoot, bool, bool]]:
        ((lo, hi),) = self.windows()
        yield lo, True, True
        yield hi, True, False

    def contacts(self, t: AlgebraicRoot, most: int = 8) -> list[FieldPoint]:
        return self._then(t).contacts(t, most)

    def contacts_from(self, t: AlgebraicRoot, lasts: bool) -> list[FieldPoint]:
        return self.contacts(t)

    def contact_at_start(self) -> list[FieldPoint]:
        return self._then(AlgebraicRoot.of(self.span[0])).contact_at_start()

    def is_isolated(self, t: AlgebraicRoot) -> bool:
        return self._then(t).is_isolated(t)

    def _then(self, t: AlgebraicRoot) -> Times:
        assert t.rational is not None
        return Times(self.conditions, (t.rational, t.rational))


def solid_times(
    c: SolidConditions, span: Span, work: Work, reach: Reach = FARTHEST
) -> list[Times | HeldTimes]:
    """What together tells all times of contact; in order, over stretches that share their ends at most."""
    parts = _Stretches(c, span, work).found
    if parts is None:
        return [Times(c, span, work, reach)]
    return [
        HeldTimes(c, part) if active is None else Times(replace(c, active=active, known={}), part, work, reach)
        for part, active in parts
    ]


Active = frozenset[int]
"""Numbers among the polynomials of those that may vanish at contacts."""


class _Stretches:
    """found: (stretch, polynomials for elimination, or None where there is contact throughout); None for too many.

    Each stretch looked at counts as work.  Raises Spent.
    """

    def __init__(self, c: SolidConditions, span: Span, work: Work) -> None:
        self.c, self.span, self.work = c, span, work
        self.found: list[tuple[Span, Active | None]] | None = []
        self._cover(*span)
        if self.found is not None:
            self.found = _merged(self.found)

    def _cover(self, lo: fmpq, hi: fmpq, before: Active | None = None, stale: int = 0, depth: int = 0) -> None:
        """before: the polynomials of a longer stretch; stale: how often halving has left them."""
        if self.found is None:
            return
        self.work.step(STEPS)
        boxes = survivors(self.c, (lo, hi), VISITS, DEPTH)
        if not boxes:
            return
        middle = (lo + hi) / 2
        held = None if lo == hi or depth >= DEEPEST else self._held(middle, lo, hi)
        if held is not None:
            if lo < held[0]:
                self._cover(lo, held[0], depth=depth + 1)
            self._add(held, None)
            if held[1] < hi:
                self._cover(held[1], hi, depth=depth + 1)
            return
        active = self._active(boxes, (lo, hi))
        stale = stale + 1 if active == before else 0
        if len(active) <= FEW or stale >= STALE or lo == hi or depth >= DEEPEST:
            self._add((lo, hi), active)
            return
        self._cover(lo, middle, active, stale, depth + 1)
        self._cover(middle, hi, active, stale, depth + 1)

    def _add(self, span: Span, active: Active | None) -> None:
        if self.found is None:
            return
        self.found.append((span, active))
        if len(_merged(self.found)) > MOST:
            self.found = None

    def _active(self, boxes: Sequence[ParameterBox], span: Span) -> Active:
        """Polynomials that may vanish in the boxes, all in the span."""
        found: set[int] = set()
        for inverse in {box.inverse for box in boxes}:
            chart = self.c.charts[inverse]
            own = [box for box in boxes if box.inverse == inverse]
            for u, v in clusters(own) if len(own) <= MOST_BOXES else [_hull(own)]:
                above, below = signs_over(chart, (u, v, span))
                found |= set(np.flatnonzero(~(above | below))[1:].tolist())  # the first is no condition
        return frozenset(found)

    def _held(self, t: fmpq, lo: fmpq, hi: fmpq) -> Span | None:
        """Times around t, with rational ends, at which a place deep inside the solid at t stays there."""
        for chart in self.c.charts.values():
            place = _deepest(chart, t)
            if place is None:
                continue
            on_line = {id(f): univariate(at(at(f, 0, place[0]), 1, place[1]), 2) for f in chart.polynomials}
            if not chart.holds(lambda f: sign(on_line[id(f)](t))):  # noqa: B023
                continue
            ends = [enclosed(x) for p in on_line.values() if p.degree() > 0 for x in roots_in(p, (lo, hi))]
            if all(y < t or x > t for x, y in ends):
                before, after = [y for _, y in ends if y < t], [x for x, _ in ends if x > t]
                return (_inner(max(before), t) if before else lo), (_inner(min(after), t) if after else hi)
        return None


def _inner(end: fmpq, t: fmpq) -> fmpq:
    """A short number near an end, on the side of t."""
    near = end + (t - end) / 2**16
    return dyadic_between(min(end, near), max(end, near))


def _hull(boxes: Sequence[ParameterBox]) -> tuple[Span, Span]:
    parts = [(box.u, box.v) for box in boxes]
    lowest, highest = [[end(part[k][i] for part in parts) for k in (0, 1)] for i, end in ((0, min), (1, max))]
    return (lowest[0], highest[0]), (lowest[1], highest[1])


def _merged(parts: Sequence[tuple[Span, Active | None]]) -> list[tuple[Span, Active | None]]:
    """Stretches that follow each other and are alike as one."""
    found: list[tuple[Span, Active | None]] = []
    for span, active in parts:
        if found and found[-1][0][1] == span[0] and found[-1][1] == active:
            span = found.pop()[0][0], span[1]
        found.append((span, active))
    return found


def _deepest(chart: SolidConditions, t: fmpq) -> tuple[fmpq, fmpq] | None:
    """A place that seems to be inside the solid at the time, far from its surfaces; in doubles."""
    assert chart.u is not None and chart.v is not None
    places = [[lo + (hi - lo) * fmpq(2 * k + 1, 2 * GRID) for k in range(GRID)] for lo, hi in (chart.u, chart.v)]
    table, values = powers(chart)[1:], [np.array([to_double(x) for x in some]) for some in places]
    values.append(np.array([to_double(t)]))
    grids = [np.vander(x, n, increasing=True) for x, n in zip(values, table.shape[1:], strict=True)]
    found = np.einsum("kijl,ai,bj,cl->kab", table, *grids, optimize=True)
    found /= np.maximum(np.abs(found).max(axis=(1, 2), keepdims=True), 1e-300)
    n = len(chart.forms)
    heights = np.max([tree_height(chart.solid.tree, found[:n]), *(-found[n:])], axis=0)
    i, j = (int(k) for k in np.unravel_index(np.argmin(heights), heights.shape))
    return (places[0][i], places[1][j]) if heights[i, j] < 0 else None
