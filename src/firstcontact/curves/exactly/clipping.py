"""Which parts of Delta = 0 belong to both pieces, and what common rulings share; all decided exactly.

With D3, D4 the brackets of the ends of a ruling of P (pairs/ruled_ruled.py), one auxiliary point for all, the meeting
point is D4 P1 - D3 P2: for positive weights it lies between the ends where D3 D4 <= 0.  Every other bound is a product
of polynomials in u, v with a sign too.  Their common zeros with Delta become nodes, so signs are constant on edges.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cmp_to_key, lru_cache
from typing import TYPE_CHECKING

import numpy as np
from flint import arb, fmpq, fmpz_mpoly, fmpz_poly

from firstcontact.contact.signs.pieces import Inequality, RulingPiece, at_place
from firstcontact.curves.exactly import cusps
from firstcontact.curves.exactly.spots import Box, Spot, equalities, sides, spot
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import precision, rational
from firstcontact.exact.polynomials.bivariate import CONTEXT, in_u, in_v
from firstcontact.pairs.ruled_ruled import (
    Parameter,
    Rulings,
    at_infinity,
    brackets,
    delta,
    divides,
    meeting,
    sign_at,
)  # fmt: skip

if TYPE_CHECKING:
    from firstcontact.exact.curves.plane_curves import Node, PlaneEdge

Degrees = tuple[int, int]
Along = Callable[[fmpz_poly], fmpz_mpoly]
"""A polynomial of one parameter as one in u and v: `in_u` or `in_v`."""
# Precision at which a bound that cannot be told from equality is named at an end: agreement to 1e-90.
EQUAL_BITS = 320
# Of points on common rulings.
LINE_BITS = 128


@dataclass(frozen=True)
class Condition:
    """sign * product of the polynomials >= 0; each with the bidegree it is homogenised with, and its zeros' name."""

    polynomials: tuple[tuple[fmpz_mpoly, Degrees, str], ...]
    sign: int


class Clip:
    """The bounds of two pieces and of the box on the pairs (u, v) of rulings that meet."""

    def __init__(self, p: RulingPiece, q: RulingPiece, box: Box | None) -> None:
        self.p, self.q, self.box = p, q, box
        self.points = meeting(p.rulings, q.rulings)
        self.bounded = p.bounded or q.bounded or bool(p.trim or q.trim) or box is not None
        self.conditions = lru_cache(maxsize=4)(self._conditions)
        self._brackets = lru_cache(maxsize=1)(lambda: brackets(p.rulings, q.rulings))

    def columns(self, factor: fmpz_mpoly) -> list[int]:
        """The auxiliary points off the common plane of the rulings, but for isolated zeros of the factor."""
        return [k for k in range(4) if not all(divides(factor, row[k]) for row in self.points)]

    def _conditions(self, k: int) -> list[Condition]:
        p, q = self.p.rulings, self.q.rulings
        found: list[Condition] = []
        if not (self.p.bounded or self.q.bounded or self.p.trim or self.q.trim or self.box):
            return found
        t0, t1, s0, s1 = (x[k] for x in self._brackets())
        of_s = [(x, (_degree(end), q.degree)) for x, end in ((s0, p.first), (s1, p.second))]
        of_t = [(x, (p.degree, _degree(end))) for x, end in ((t0, q.first), (t1, q.second))]
        for piece, pair, name in ((self.p, of_s, "s"), (self.q, of_t, "t")):
            if piece.bounded:
                named = tuple((*x, f"{name}={end}") for x, end in zip(pair, piece.s_range, strict=True))
                found.append(Condition(named, -1))
        for piece, pair, along, own in ((self.p, of_s, in_u, 0), (self.q, of_t, in_v, 1)):
            found += [_trim(piece, g, pair, along, own) for g in piece.trim]
        if self.box is not None:
            weight, degrees = self.points[3][k], (p.degree, q.degree)
            for i, (low, high) in enumerate(zip(*self.box, strict=True)):
                for end, sign in ((low, 1), (high, -1)):
                    x = rational(end, "box")
                    plane = self.points[i][k] * x.q - weight * x.p
                    found.append(Condition(((plane, degrees, f"{'xyz'[i]}={end}"), (weight, degrees, "")), sign))
        return found

    def special_at_infinity(self, bounds: tuple[fmpq, fmpq] | None, side: int) -> bool:
        """Whether Delta or a polynomial whose zeros must be nodes vanishes for the parameter infinity of one side."""
        if bounds is not None:
            return False
        p, q = self.p.rulings, self.q.rulings
        if cusps.special_at_infinity(*((p, q) if side == 0 else (q, p))):
            return True
        whole = (p.degree, q.degree)
        tested = [(delta(p, q), whole)]
        for k in range(4):
            tested += [(x, degrees) for c in self.conditions(k) for x, degrees, _ in c.polynomials]
        if not (self.p.bounded or self.q.bounded or self.box):
            tested += [(x, whole) for x in self.points[3]]
        return any(not x.is_zero() and x.degrees()[side] < degrees[side] for x, degrees in tested)

    def extras(self, factors: list[fmpz_mpoly]) -> list[fmpz_mpoly]:
        """The polynomials whose zeros on these factors must be nodes."""
        columns = sorted({self.columns(f)[0] for f in factors})
        found = [x for k in columns for c in self.conditions(k) for x, _, _ in c.polynomials]
        return [x for i, x in enumerate(found) if not x.is_constant() and x not in found[:i]]

    def keeps_edge(self, edge: PlaneEdge, factor: fmpz_mpoly) -> bool:
        """Whether the open edge belongs to both pieces."""
        if not self.bounded:
            return True
        u, v = (x if isinstance(x, AlgebraicRoot) else AlgebraicRoot.of(x) for x in edge.sample)
        where = spot(self.p, self.q, (False, False), u.enclosure(96), v.enclosure(96), 96)
        seen = sides(where, self.p, self.q, self.box)
        if seen:
            return seen > 0
        k = self.columns(factor)[0]
        return all(c.sign * _signs(c, u, v) >= 0 for c in self.conditions(k))

    def keeps_node(self, node: Node, where: Spot) -> bool:
        """Whether a meeting point of two different rulings belongs to both pieces; `where` in balls."""
        seen = sides(where, self.p, self.q, self.box) if self.bounded else 1
        if seen:
            return seen > 0
        return all(c.sign * _signs(c, node.u, node.v) >= 0 for c in self.conditions(where.column))

    def bounds_at(self, where: Spot) -> tuple[str, ...]:
        """The names of the bounds that hold with equality, as far as the bits of `where` show."""
        found = []
        for piece, x, reverse, name in zip((self.p, self.q), (where.x, where.y), where.chart, "uv", strict=True):
            with precision(where.bits):
                own = 1 / x if reverse else x
                found += [f"{name}={end}" for end in piece.u or () if (own - arb(end)).contains(0)]
        return (*found, *equalities(where, self.p, self.q, self.box)) if where.point is not None else tuple(found)


def _signs(c: Condition, u: Parameter, v: Parameter) -> int:
    found = 1
    for x, degrees, _ in c.polynomials:
        found *= sign_at(x, u, v, degrees)
    return found


def _trim(
    piece: RulingPiece, g: Inequality, pair: Sequence[tuple[fmpz_mpoly, Degrees]], along: Along, own: int
) -> Condition:
    """g(u, s) >= 0 with s = -D3 W2 / (D4 W1 - D3 W2), times an even power of the denominator."""
    (d1, degrees), (d2, other) = pair
    w1, w2 = along(piece.rulings.first[3]), along(piece.rulings.second[3])
    numerator, denominator = -d1 * w2, d2 * w1 - d1 * w2
    top = max(j for _, j in g)
    even = top + top % 2
    total = at_place(g, CONTEXT.gens()[own], numerator, denominator, even)
    in_u = max(i for i, _ in g)
    in_u += in_u % 2
    ends = _degree(piece.rulings.first) + _degree(piece.rulings.second)
    whole = [even * degrees[0], even * degrees[1]]
    whole[own] = even * ends + in_u
    return Condition(((total, (whole[0], whole[1]), "trim"),), 1)


def _degree(curve: Sequence[fmpz_poly]) -> int:
    return max(x.degree() for x in curve)


def in_range(piece: RulingPiece, parameter: Parameter) -> bool:
    if piece.u is None:
        return True
    low, high = piece.u
    return parameter is not None and parameter.compare(low) >= 0 and parameter.compare(high) <= 0


def overlap(p: RulingPiece, q: RulingPiece, u: Parameter, v: Parameter) -> np.ndarray | None:
    """(2, 3) ends of what the pieces share of their common ruling l(u) = m(v), equal for a point; None for nothing.

    Two points of the line where both rulings are unbounded.
    """
    if not (in_range(p, u) and in_range(q, v)) or at_infinity(p.rulings, u):
        return None
    (a, x), (b, y) = p.rulings.chart(u), q.rulings.chart(v)
    j = next(i for i, k in enumerate((2, 4, 5)) if x.sign_of(a.line[k]) != 0)
    ends_p = [_RulingEnd(c, j, in_u, x, y) for c in (a.first, a.second)] if p.bounded else []
    ends_q = [_RulingEnd(c, j, in_v, x, y) for c in (b.first, b.second)] if q.bounded else []
    if not ends_p and not ends_q:
        return _two_points(a, x)
    lows, highs = [], []
    for ends in (ends_p, ends_q):
        if ends:
            ends.sort(key=cmp_to_key(_RulingEnd.compare))
            lows.append(ends[0])
            highs.append(ends[1])
    low, high = max(lows, key=cmp_to_key(_RulingEnd.compare)), min(highs, key=cmp_to_key(_RulingEnd.compare))
    order = low.compare(high)
    if order > 0:
        return None
    return np.array([low.point(), (high if order else low).point()])


class _RulingEnd:
    """An end of a ruling on a line, ordered by its coordinate j."""

    def __init__(self, curve: Sequence[fmpz_poly], j: int, along: Along, u: AlgebraicRoot, v: AlgebraicRoot) -> None:
        self.curve, self.root, self.at = curve, u if along is in_u else v, (u, v)
        self.x, self.w = along(curve[j]), along(curve[3])

    def compare(self, other: _RulingEnd) -> int:
        """Weights are positive on bounded pieces."""
        return sign_at(self.x * other.w - other.x * self.w, *self.at, (0, 0))

    def point(self) -> list[float]:
        r = self.root.enclosure(LINE_BITS)
        with precision(LINE_BITS):
            return [float((c(r) / self.curve[3](r)).mid()) for c in self.curve[:3]]


def _two_points(lines: Rulings, root: AlgebraicRoot) -> np.ndarray:
    """The point of a line next to the origin, and another at distance 1."""
    r = root.enclosure(LINE_BITS)
    with precision(LINE_BITS):
        l01, l02, l03, l12, l13, l23 = (float(c(r).mid()) for c in lines.line)
    direction, moment = -np.array([l03, l13, l23]), np.array([l12, -l02, l01])  # X2 - X1 and X1 x X2
    foot = np.cross(direction, moment) / (direction @ direction)
    return np.array([foot, foot + direction / np.linalg.norm(direction)])
