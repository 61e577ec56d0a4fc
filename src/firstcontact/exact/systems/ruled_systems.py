"""The event systems of two moving ruled pieces in ball arithmetic: where and when their contact may begin or end.

Unknowns are the free ones of u, s, v, t, in this order, and the time T; equations P(u, s, T) = Q(v, t, T) and, with
three or four free parameters, one or two determinants of derivatives, which vanish where the contact set of the stratum
has an extremum in time.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from flint import arb, fmpq, fmpz_poly

from firstcontact.exact.systems.square_systems import Equations
from firstcontact.exact.vectors import det

Vector = list[arb]
Columns = tuple[int, int, int]
"""Parameters (0 to 3: u, s, v, t) by which the columns of a determinant are derivatives."""


class Curve:
    """x = (X, Y, Z) / W, each a sum of c_i(T) x^i with c_i in fmpz_poly."""

    def __init__(self, components: Sequence[Sequence[fmpz_poly]]) -> None:
        self.components = [list(c) for c in components]
        moved = ([p.derivative() for p in c] for c in self.components)
        self.moved = [c if any(c) else None for c in moved]
        """Their derivatives by the time; None where all are zero."""

    def jet(self, x: arb, time: arb, order: int) -> Jet:
        """The point and its derivatives up to this order, at most 2."""
        jets = []
        for c, m in zip(self.components, self.moved, strict=True):
            still, moved = _taylor([p(time) for p in c], x, order), _NOTHING
            if m is not None and order:
                moved = _taylor([p(time) for p in m], x, order - 1)
            jets.append((*still, *moved))
        w, w_x, w_xx, w_t, w_xt, _ = jets[3]
        scale = 1 / w
        found = Jet([], [], [], [], [])
        for value, by_x, by_xx, by_t, by_xt, _ in jets[:3]:
            y = value * scale
            found.point.append(y)
            if order:
                y_x, y_t = (by_x - y * w_x) * scale, (by_t - y * w_t) * scale
                found.x.append(y_x)
                found.t.append(y_t)
            if order > 1:
                found.xx.append((by_xx - 2 * y_x * w_x - y * w_xx) * scale)
                found.xt.append((by_xt - y_x * w_t - y_t * w_x - y * w_xt) * scale)
        return found


_NOTHING = arb(0), arb(0), arb(0)


def _taylor(c: Sequence[arb], x: arb, order: int) -> tuple[arb, arb, arb]:
    """The polynomial and its derivatives up to this order."""
    value, first, second = c[-1], *_NOTHING[:2]
    for a in reversed(c[:-1]):
        if order > 1:
            second = second * x + 2 * first
        if order:
            first = first * x + value
        value = value * x + a
    return value, first, second


class Jet(NamedTuple):
    """A point of a curve and its derivatives by the parameter x and the time t; empty beyond the order asked for."""

    point: Vector
    x: Vector
    t: Vector
    xx: Vector
    xt: Vector


class RuledJet(NamedTuple):
    """A point of a ruled surface and its derivatives: by x, s, time; then of these (by s and s: zero)."""

    point: Vector
    x: Vector
    s: Vector
    t: Vector
    xx: Vector
    xs: Vector
    xt: Vector
    st: Vector


def ruled_jet(first: Curve, second: Curve, x: arb, s: arb, time: arb, order: int) -> RuledJet:
    """Up to this order, as `Curve.jet`."""
    a, b = first.jet(x, time, order), second.jet(x, time, order)
    across = Jet(*([n - m for m, n in zip(p, q, strict=True)] for p, q in zip(a, b, strict=True)))
    along = Jet(*([m + s * d for m, d in zip(p, q, strict=True)] for p, q in zip(a, across, strict=True)))
    return RuledJet(along.point, along.x, across.point, along.t, along.xx, across.x, along.xt, across.t)


class ContactSystem(Equations):
    """P = Q with some parameters free, the others fixed, and with determinants of these columns.

    curves: both directrices of P, then of Q; parameters: the value of each fixed one of u, s, v, t, None for the free.
    """

    def __init__(
        self,
        curves: tuple[Curve, Curve, Curve, Curve],
        parameters: Sequence[fmpq | None],
        minors: Sequence[Columns],
    ) -> None:
        self.curves, self.parameters, self.minors = curves, tuple(parameters), tuple(minors)
        self.free = tuple(k for k, value in enumerate(parameters) if value is None)

    def everywhere(self, x: Sequence[arb]) -> tuple[list[arb], arb]:
        """u, s, v, t and the time."""
        free = iter(x)
        return [next(free) if value is None else arb(value) for value in self.parameters], x[len(self.free)]

    def jets(self, x: Sequence[arb], order: int) -> tuple[RuledJet, RuledJet]:
        (u, s, v, t), time = self.everywhere(x)
        first_p, second_p, first_q, second_q = self.curves
        return ruled_jet(first_p, second_p, u, s, time, order), ruled_jet(first_q, second_q, v, t, time, order)

    def values(self, x: Sequence[arb]) -> list[arb]:
        p, q = self.jets(x, 1 if self.minors else 0)
        columns = p.x, p.s, q.x, q.s
        gap = [a - b for a, b in zip(p.point, q.point, strict=True)]
        return gap + [det(*(columns[k] for k in minor)) for minor in self.minors]

    def jacobian(self, x: Sequence[arb]) -> list[list[arb]]:
        p, q = self.jets(x, 2 if self.minors else 1)
        columns = p.x, p.s, q.x, q.s
        zero = [arb(0)] * 3
        # derivatives of the columns by u, s, v, t, time; the columns of Q stand with the sign of Q itself
        twice = (
            (p.xx, p.xs, zero, zero, p.xt), (p.xs, zero, zero, zero, p.st),
            (zero, zero, q.xx, q.xs, q.xt), (zero, zero, q.xs, zero, q.st),
        )  # fmt: skip
        unknowns = (*self.free, 4)
        rows = []
        for i in range(3):
            by = [p.x[i], p.s[i], -q.x[i], -q.s[i], p.t[i] - q.t[i]]
            rows.append([by[k] for k in unknowns])
        for minor in self.minors:
            row = []
            for k in unknowns:
                total = arb(0)
                for place, column in enumerate(minor):
                    changed = twice[column][k]
                    if changed is not zero:
                        total += det(*(changed if i == place else columns[c] for i, c in enumerate(minor)))
                row.append(total)
            rows.append(row)
        return rows
