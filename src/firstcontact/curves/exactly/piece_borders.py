"""Borders of a piece across its rulings: ends, and inequalities that are linear in s, as rational curves in space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from flint import arb, fmpz_poly

from firstcontact.contact.signs.pieces import RulingPiece
from firstcontact.curves.exactly import tracing
from firstcontact.curves.exactly.spots import Chart, Spot
from firstcontact.curves.exactly.tracing import Powers
from firstcontact.exact.fields.roots import reversed_polynomial
from firstcontact.exact.numbers import precision
from firstcontact.exact.polynomials.bivariate import irreducible, polynomial, rows
from firstcontact.pairs.ruled_ruled import Rulings


@dataclass(frozen=True)
class Border:
    """The points at s = s[0](u) / s[1](u) of the rulings of the piece number `side`, by coefficients."""

    side: int
    s: tuple[tuple[int, ...], tuple[int, ...]]

    def curve(self, rulings: Rulings) -> tuple[fmpz_poly, ...]:
        """(X, Y, Z, W, n, d), s = n / d."""
        (a, b), (n, d) = (rulings.first, rulings.second), (fmpz_poly(list(x)) for x in self.s)
        point = [(d - n) * a[i] * b[3] + n * b[i] * a[3] for i in range(3)]
        return (*point, d * a[3] * b[3], n, d)

    def is_point(self, rulings: Rulings) -> bool:
        """Whether it is one point for all rulings."""
        *point, weight = self.curve(rulings)[:4]
        return all(x.derivative() * weight == x * weight.derivative() for x in point)


def borders(piece: RulingPiece, side: int) -> list[Border]:
    found = [Border(side, ((end,), (1,))) for end in (0, 1)] if piece.bounded else []
    for g in irreducible(polynomial(g) for g in piece.trim):
        in_s = rows(g)
        if len(in_s) == 2:
            found.append(Border(side, (_coefficients(-in_s[0]), _coefficients(in_s[1]))))
    return found


def _coefficients(p: fmpz_poly) -> tuple[int, ...]:
    return tuple(int(c) for c in p.coeffs())


class BorderCurve:
    """Where a pair (u, v) of rulings that are one line is in space, when both meet there in a point of a border.

    As `branches.Joints` and `tracing.Tracer` ask for it.
    """

    def __init__(self, p: RulingPiece, q: RulingPiece, border: Border) -> None:
        self.pieces, self.side = (p, q), border.side
        self.curve = border.curve(self.pieces[self.side].rulings)
        self.degrees = [max(x.degree() for x in part) for part in (self.curve[:4], self.curve[4:])]

    def spot(self, chart: Chart, x: arb, y: arb, bits: int) -> Spot:
        at, other = (x, y) if self.side == 0 else (y, x)
        degrees = [self.degrees[0]] * 4 + [self.degrees[1]] * 2
        curve = [reversed_polynomial(c, n) for c, n in zip(self.curve, degrees, strict=True)]
        with precision(bits):
            values = [c(at) for c in (curve if chart[self.side] else self.curve)]
            point, own = tuple(values[:4]), (values[4], values[5])
            place = _position(self.pieces[1 - self.side].reversed_rulings(chart[1 - self.side]), other, point)
        s, t = (own, place) if self.side == 0 else (place, own)
        return Spot(x, y, chart, point, s, t, 0, bits)

    def surfaces(self) -> BorderCurve:
        """With coefficients in doubles."""
        self.rows = [tracing.rows(part) for part in (self.curve[:4], self.curve[4:])]
        rulings = self.pieces[1 - self.side].rulings
        self.others = tuple(tracing.rows(c) for c in (rulings.first, rulings.second))
        return self

    def points(self, u: Powers, v: Powers) -> tuple[np.ndarray, np.ndarray]:
        """As those of tracing.Surfaces."""
        own, other = (u, v) if self.side == 0 else (v, u)
        point, place = (c @ own.table(c.shape[1] - 1) for c in self.rows)
        with np.errstate(all="ignore"):
            point = point[:3] / point[3]
            positions = [place[0] / place[1], tracing.position(self.others, other, point)]
        return point.T, np.stack(positions if self.side == 0 else positions[::-1], axis=1)

    def size(self) -> float:
        return float(np.abs(self.rows[0]).max())


def _position(rulings: Rulings, at: arb, point: tuple[arb, ...]) -> tuple[arb, arb]:
    """Numerator and denominator of the place of a point on its ruling, by the coordinate that tells it best."""
    (*a, w), (*b, y) = ([c(at) for c in end] for end in (rulings.first, rulings.second))
    ways = [b[j] * w - a[j] * y for j in range(3)]
    j = max(range(3), key=lambda k: abs(float(ways[k].mid())))
    return (point[j] * w - a[j] * point[3]) * y, ways[j] * point[3]
