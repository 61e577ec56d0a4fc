"""Two pieces at one pair of parameters, in balls: the meeting point of the two rulings and where it lies on them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import arb

from firstcontact.contact.signs.pieces import RulingPiece
from firstcontact.errors import InputError
from firstcontact.exact.numbers import precision, rational
from firstcontact.exact.polynomials.inertia import dot
from firstcontact.motion.translation import LARGEST
from firstcontact.pairs.ruled_ruled import planes_through, points_on

if TYPE_CHECKING:
    from firstcontact.exact.numbers import Given
    from firstcontact.exact.ring import Rational

Box = tuple[tuple[Any, Any, Any], tuple[Any, Any, Any]]
Chart = tuple[bool, bool]
"""Whether u and v are given as 1/u and 1/v."""


def box_of(box: Iterable[Iterable[Given]] | None) -> Box | None:
    """What the user gives for `box`, checked; exact."""
    if box is None:
        return None
    try:
        low, high = (tuple(rational(x, "box") for x in corner) for corner in box)
    except (TypeError, ValueError) as error:
        raise InputError(f"box is {box!r}; give two corners ((x0, y0, z0), (x1, y1, z1))") from error
    if len(low) != 3 or len(high) != 3 or not all(x < y for x, y in zip(low, high, strict=True)):
        shown = ", ".join(f"({', '.join(map(str, corner))})" for corner in (low, high))
        raise InputError(f"box is ({shown}); give two corners ((x0, y0, z0), (x1, y1, z1)), the first below the second")
    if any(abs(x) >= LARGEST for x in (*low, *high)):
        raise InputError("box reaches beyond 2^150; give corners below that, or none")
    return low, high


def corners(box: Box | None) -> np.ndarray | None:
    """(2, 3) float64 of a box, as results tell it."""
    return None if box is None else np.array([[float(x) for x in corner] for corner in box])


@dataclass(frozen=True)
class Spot:
    """The rulings l(x), m(y), given that they meet.

    point     (X, Y, Z, W) of the meeting point, the column of L M* that is farthest from zero; None where all contain
              zero: the rulings may be one line
    s, t      the fractions (numerator, denominator) of its position on the rulings
    plane     the index of that column
    """

    x: arb
    y: arb
    chart: Chart
    point: tuple[arb, ...] | None
    s: tuple[arb, arb]
    t: tuple[arb, arb]
    column: int
    bits: int

    def coordinates(self) -> list[arb]:
        """Affine coordinates; not finite where the point may be at infinity."""
        assert self.point is not None
        with precision(self.bits):
            return [c / self.point[3] for c in self.point[:3]]

    def may_be_infinite(self) -> bool:
        return self.point is not None and self.point[3].contains(0)


def spot(p: RulingPiece, q: RulingPiece, chart: Chart, x: arb, y: arb, bits: int) -> Spot:
    a, b = p.reversed_rulings(chart[0]), q.reversed_rulings(chart[1])
    with precision(bits):
        line, other = [c(x) for c in a.line], [c(y) for c in b.line]
        matrix, planes = points_on(line), planes_through(other)
        columns = [[dot(row, plane) for row in matrix] for plane in zip(*planes, strict=True)]
        sizes = [max(_lower(c) for c in column) for column in columns]
        k = max(range(4), key=sizes.__getitem__)
        point = tuple(columns[k]) if sizes[k] > 0 else None
        p1, p2 = ([c(x) for c in end] for end in (a.first, a.second))
        q1, q2 = ([c(y) for c in end] for end in (b.first, b.second))
        of_q, of_p = [row[k] for row in planes], [row[k] for row in planes_through(line)]
        s = _position(dot(p1, of_q), dot(p2, of_q), p1[3], p2[3])
        t = _position(dot(q1, of_p), dot(q2, of_p), q1[3], q2[3])
    return Spot(x, y, chart, point, s, t, k, bits)


def _position(d1: arb, d2: arb, w1: arb, w2: arb) -> tuple[arb, arb]:
    """d2 X1 - d1 X2 as X1 + (X2 - X1) s of the affine points."""
    return -d1 * w2, d2 * w1 - d1 * w2


def _lower(x: arb) -> float:
    return float(abs(x).lower()) if not x.contains(0) else 0.0


def sides(where: Spot, p: RulingPiece, q: RulingPiece, box: Box | None) -> int:
    """-1: the point is off a piece or the box; 1: inside both; 0: the balls cannot tell."""
    if where.point is None:
        return 0
    values = [value for _, value in margins(where, p, q, box)]
    if any(value < 0 for value in values):
        return -1
    return 1 if all(value > 0 for value in values) else 0


def equalities(where: Spot, p: RulingPiece, q: RulingPiece, box: Box | None) -> tuple[str, ...]:
    """The names of the bounds whose margin the balls cannot tell from zero."""
    return tuple(dict.fromkeys(name for name, value in margins(where, p, q, box) if value.contains(0)))


def margins(where: Spot, p: RulingPiece, q: RulingPiece, box: Box | None) -> list[tuple[str, arb]]:
    """The bounds of the pieces and of the box, as numbers that are not negative inside."""
    found: list[tuple[str, arb]] = []
    with precision(where.bits):
        for names, piece, fraction, x, reverse in (
            ("us", p, where.s, where.x, where.chart[0]), ("vt", q, where.t, where.y, where.chart[1])
        ):  # fmt: skip
            position = fraction[0] / fraction[1]
            if piece.bounded:
                low, high = (f"{names[1]}={end}" for end in piece.s_range)
                found += [(low, position), (high, 1 - position)]
            found += [("trim", _value(g, 1 / x if reverse else x, position)) for g in piece.trim]
        if box is not None:
            for axis, c, low_end, high_end in zip("xyz", where.coordinates(), *box, strict=True):
                found += [(f"{axis}={low_end}", c - arb(low_end)), (f"{axis}={high_end}", arb(high_end) - c)]
    return found


def _value(g: Mapping[tuple[int, int], Rational], u: arb, s: arb) -> arb:
    total = arb(0)
    for (i, j), c in g.items():
        total += c * u**i * s**j
    return total


def doubles(values: Sequence[arb]) -> np.ndarray:
    """Their middles; 0 of those that cannot be told from it."""
    return np.array([_double(x) for x in values])


def ratio(fraction: tuple[arb, arb]) -> float:
    """A position as a double; nan where the directrices leave it open (a degenerate ruling, a pole)."""
    x = fraction[0] / fraction[1]
    return _double(x) if x.is_finite() else float("nan")


def _double(x: arb) -> float:
    return 0.0 if x.contains(0) else float(x.mid())
