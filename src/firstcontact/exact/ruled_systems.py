"""The event systems of two moving ruled pieces in ball arithmetic: where and when their contact may begin or end.

Unknowns are the free ones of u, s, v, t, in this order, and the time T; equations P(u, s, T) = Q(v, t, T) and, with
three or four free parameters, one or two determinants of derivatives, which vanish where the contact set of the stratum
has an extremum in time.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from flint import arb, ctx, fmpq, fmpz_poly

from firstcontact.exact.square_systems import Equations

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

    def jet(self, x: arb, time: arb) -> Jet:
        """The point and its derivatives."""
        jets, zero = [], arb(0)
        for c, m in zip(self.components, self.moved, strict=True):
            value, first, second = _taylor([p(time) for p in c], x)
            by_time, mixed, _ = (zero, zero, zero) if m is None else _taylor([p(time) for p in m], x)
            jets.append((value, first, by_time, second, mixed))
        w, w_x, w_t, w_xx, w_xt = jets[3]
        rows = []
        for value, by_x, by_t, by_xx, by_xt in jets[:3]:
            y = value / w
            y_x, y_t = (by_x - y * w_x) / w, (by_t - y * w_t) / w
            y_xx = (by_xx - 2 * y_x * w_x - y * w_xx) / w
            y_xt = (by_xt - y_x * w_t - y_t * w_x - y * w_xt) / w
            rows.append((y, y_x, y_t, y_xx, y_xt))
        return Jet(*([row[k] for row in rows] for k in range(5)))


def _taylor(c: Sequence[arb], x: arb) -> tuple[arb, arb, arb]:
    value, first, second = c[-1], arb(0), arb(0)
    for a in reversed(c[:-1]):
        second = second * x + 2 * first
        first = first * x + value
        value = value * x + a
    return value, first, second


class Jet(NamedTuple):
    """A point of a curve and its derivatives by the parameter x and the time t."""

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


def ruled_jet(first: Curve, second: Curve, x: arb, s: arb, time: arb) -> RuledJet:
    a, b = first.jet(x, time), second.jet(x, time)
    across = [[q - p for p, q in zip(a[k], b[k], strict=True)] for k in (0, 1, 2)]

    def blend(p: Vector, q: Vector) -> Vector:
        return [(1 - s) * m + s * n for m, n in zip(p, q, strict=True)]

    return RuledJet(
        blend(a.point, b.point), blend(a.x, b.x), across[0], blend(a.t, b.t), blend(a.xx, b.xx), across[1],
        blend(a.xt, b.xt), across[2],
    )  # fmt: skip


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
        self._known: tuple[Sequence[arb], int, tuple[RuledJet, RuledJet]] | None = None
        """Where jets were asked for last, at which precision, and they: values and derivatives are asked in turn."""

    def everywhere(self, x: Sequence[arb]) -> tuple[list[arb], arb]:
        """u, s, v, t and the time."""
        free = iter(x)
        return [next(free) if value is None else arb(value) for value in self.parameters], x[len(self.free)]

    def jets(self, x: Sequence[arb]) -> tuple[RuledJet, RuledJet]:
        if self._known is None or self._known[0] is not x or self._known[1] != ctx.prec:
            (u, s, v, t), time = self.everywhere(x)
            first_p, second_p, first_q, second_q = self.curves
            found = ruled_jet(first_p, second_p, u, s, time), ruled_jet(first_q, second_q, v, t, time)
            self._known = x, ctx.prec, found
        return self._known[2]

    def values(self, x: Sequence[arb]) -> list[arb]:
        p, q = self.jets(x)
        columns = p.x, p.s, q.x, q.s
        gap = [a - b for a, b in zip(p.point, q.point, strict=True)]
        return gap + [_det(*(columns[k] for k in minor)) for minor in self.minors]

    def jacobian(self, x: Sequence[arb]) -> list[list[arb]]:
        p, q = self.jets(x)
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
                        total += _det(*(changed if i == place else columns[c] for i, c in enumerate(minor)))
                row.append(total)
            rows.append(row)
        return rows


def _det(a: Vector, b: Vector, c: Vector) -> arb:
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    )
