"""What pieces share of a line that is a ruling of both: bounds, trimming and a box are polynomials along the line.

A point of the line is told by one of its coordinates, x.  The place s of a ruling is linear in x, so every inequality
g(u, s) >= 0 is a polynomial in x over the field of both parameters.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import accumulate
from operator import mul
from typing import TYPE_CHECKING

import numpy as np
from flint import arb, fmpq, fmpz, fmpz_poly

from firstcontact.contact.signs.pieces import Inequality, RulingPiece
from firstcontact.curves.exactly.answer import FoundCurve
from firstcontact.curves.exactly.branches import REACH
from firstcontact.curves.exactly.clipping import in_range, overlap
from firstcontact.curves.exactly.piece_borders import Border, borders
from firstcontact.curves.exactly.spots import Box
from firstcontact.curves.exactly.tracing import Surfaces
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.curves.line_sets import Part, not_negative
from firstcontact.exact.fields.common_field import MOST_DEGREE, Polynomial, adjoined, composed, horner
from firstcontact.exact.fields.number_field import FieldElement, NumberField, is_zero, sign
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import precision, rational
from firstcontact.pairs.ruled_ruled import Parameter, Rulings, at_infinity

if TYPE_CHECKING:
    from firstcontact.curves.fields import Where

BITS = 128
"""Of the points."""


def add_shared(found: FoundCurve, where: Where) -> None:
    """Put in what the pieces share of the ruling at the parameters `where.u` and `where.v`."""
    for part in shared(found.p, found.q, where.u, where.v, found.box):
        if (part[0] != part[1]).any():
            found.segments.append(part)
        else:
            found.add_isolated(part[0], where)


def shared(p: RulingPiece, q: RulingPiece, u: Parameter, v: Parameter, box: Box | None) -> np.ndarray:
    """(n, 2, 3) ends of what the pieces share of the ruling l(u) = m(v), equal for a point.

    Two points of the line where all of it is shared; half-lines end where branches do.
    """
    if not (p.trim or q.trim or box is not None):
        part = overlap(p, q, u, v)
        return np.empty((0, 2, 3)) if part is None else part[None]
    if not (in_range(p, u) and in_range(q, v)) or at_infinity(p.rulings, u):
        return np.empty((0, 2, 3))
    line, parts = _parts(p, q, u, v, box)
    return np.array([line.segment(part, REACH * Surfaces(p, q).size()) for part in parts]).reshape(-1, 2, 3)


def share_a_segment(p: RulingPiece, q: RulingPiece, u: Parameter, v: Parameter, box: Box | None) -> bool | None:
    """Whether they share more than points of the ruling l(u) = m(v); None: nothing at all."""
    if not (p.trim or q.trim or box is not None):
        part = overlap(p, q, u, v)
        return None if part is None else bool((part[0] != part[1]).any())
    parts = _parts(p, q, u, v, box)[1]
    return any(start is not end or start is None for start, end in parts) if parts else None


def touching_borders(
    p: RulingPiece, q: RulingPiece, u: AlgebraicRoot, v: AlgebraicRoot, box: Box | None
) -> list[Border]:
    """Borders on which the points lie that are all they share of the ruling l(u) = m(v), one for each."""
    line, parts = _parts(p, q, u, v, box)
    given = [(b, b.curve(piece.rulings), x) for k, (piece, x) in enumerate(((p, u), (q, v))) for b in borders(piece, k)]
    found = []
    for x, _ in parts:
        # the places of borders are among the zeros that `parts` tells apart
        assert x is not None
        on = (b for b, curve, at in given if x.overlaps(_ratio(curve[line.j], curve[3], at)))
        border = next(on, None)
        if border is None:
            raise UnsupportedPair(
                "surfaces share rulings along a curve and touch in one point of each, on an inequality that is not "
                "linear in s; give untrimmed pieces"
            )
        found.append(border)
    return found


def _ratio(above: fmpz_poly, under: fmpz_poly, at: AlgebraicRoot) -> arb:
    x = at.enclosure(2 * BITS)
    with precision(2 * BITS):
        return above(x) / under(x)


def holds(piece: RulingPiece, u: AlgebraicRoot, point: Sequence[fmpz]) -> bool:
    """Whether a finite point (X, Y, Z, W) of the line l(u) belongs to the piece."""
    at = NumberField(u).generator()
    bounds = _inequalities(piece, u, at)
    if not bounds:
        return True
    zero = at.field(0)
    for j in range(3):
        start, way = _linear(piece.rulings, at, j)
        if not is_zero(way):
            s = (at.field(fmpq(point[j], point[3])) - start) / way
            return all(sign(horner(f, s, zero)) >= 0 for f in bounds)
    return bool(not_negative(at.field, bounds, BITS))


def _parts(p: RulingPiece, q: RulingPiece, u: Parameter, v: Parameter, box: Box | None) -> tuple[_Line, list[Part]]:
    (own_p, x), (own_q, y) = p.rulings.chart(u), q.rulings.chart(v)
    field, at_p, at_q = _common_field(x, y)
    line = _Line([_value(c, at_p) for c in own_p.line])
    bounds = list(line.inside(box)) if box is not None else []
    for piece, rulings, parameter, at in ((p, own_p, u, at_p), (q, own_q, v, at_q)):
        if piece.bounded or piece.trim:
            bounds += _along(line.j, rulings, at, _inequalities(piece, parameter, at))
    return line, not_negative(field, bounds, BITS)


def _common_field(x: AlgebraicRoot, y: AlgebraicRoot) -> tuple[NumberField, FieldElement, FieldElement]:
    """A field that holds both numbers, and the numbers."""
    field = NumberField(x)
    modulus = [field(c) for c in y.polynomial.coeffs()]
    if x.polynomial.degree() * y.polynomial.degree() > MOST_DEGREE:
        raise UnsupportedPair(
            f"a common ruling at parameters of degrees {x.polynomial.degree()} and {y.polynomial.degree()} where a "
            "piece is trimmed or a box is given: too large; give untrimmed pieces without a box"
        )
    (both,) = adjoined(field, modulus, y.lo, y.hi)
    return both.field, both.carry(field.generator()), both.zero


class _Line:
    """A line by its Pluecker vector 01, 02, 03, 12, 13, 23, as a function of the coordinate j of its points."""

    def __init__(self, vector: Sequence[FieldElement]) -> None:
        l01, l02, l03, l12, l13, l23 = vector
        zero = l01 * 0
        m = [[zero, l01, l02], [-l01, zero, l12], [-l02, -l12, zero]]
        ends = (l03, l13, l23)
        self.j = j = next(k for k in range(3) if not is_zero(ends[k]))
        # the common point of the line and the plane x_j = x
        self.coordinates: list[Polynomial] = [[-m[i][j] / ends[j], ends[i] / ends[j]] for i in range(3)]

    def inside(self, box: Box) -> Iterator[Polynomial]:
        """What is not negative in the box."""
        for (constant, slope), low, high in zip(self.coordinates, *box, strict=True):
            yield [constant - rational(low, "box"), slope]
            yield [rational(high, "box") - constant, -slope]

    def segment(self, part: Part, far: float) -> list[np.ndarray]:
        """Both ends; without any, two points of the line, without one, a point `far` away."""
        way = np.array([float(slope.ball(BITS).mid()) for _, slope in self.coordinates])
        way /= np.linalg.norm(way)
        first, last = (None if x is None else self.point(x) for x in part)
        if first is None and last is None:
            first = self.point(arb(0))
            return [first, first + way]
        if first is None:
            first = last - far * way  # type: ignore[operator]
        return [first, first + far * way if last is None else last]

    def point(self, x: arb) -> np.ndarray:
        with precision(BITS):
            return np.array([float((c.ball(BITS) + x * slope.ball(BITS)).mid()) for c, slope in self.coordinates])


def _value(f: fmpz_poly, at: FieldElement) -> FieldElement:
    return horner([at.field(c) for c in f.coeffs()], at, at.field(0))


def _inequalities(piece: RulingPiece, parameter: Parameter, at: FieldElement) -> list[Polynomial]:
    """The polynomials in s that are not negative on the ruling's part."""
    field = at.field
    bounds: list[Polynomial] = [[field(0), field(1)], [field(1), field(-1)]] if piece.bounded else []
    return bounds + [_on_ruling(g, parameter is None, at) for g in piece.trim]


def _on_ruling(g: Inequality, at_infinity: bool, at: FieldElement) -> Polynomial:
    """g(u, s) as a polynomial in s; at infinity divided by the least even power of u that keeps it finite."""
    top = max(i for i, _ in g)
    powers = list(accumulate([at] * top, mul, initial=at.field(1)))
    found = [at.field(0)] * (max(j for _, j in g) + 1)
    for (i, j), c in g.items():
        if not at_infinity:
            found[j] = found[j] + powers[i] * c
        elif i == top + top % 2:
            found[j] = found[j] + c
    return found


def _along(j: int, rulings: Rulings, at: FieldElement, bounds: list[Polynomial]) -> list[Polynomial]:
    """Polynomials in s as such in the coordinate j."""
    start, way = _linear(rulings, at, j)
    if is_zero(way):  # the ruling is a point
        nowhere = [] if not_negative(at.field, bounds, BITS) else [[at.field(-1)]]
        return [[-start, at.field(1)], [start, at.field(-1)], *nowhere]
    return [composed([[c] for c in f], -start / way, 1 / way) for f in bounds]


def _linear(rulings: Rulings, at: FieldElement, j: int) -> tuple[FieldElement, FieldElement]:
    """Start and way of the coordinate j of the ruling as s goes from 0 to 1."""
    (a, weight_a), (b, weight_b) = ((_value(c[j], at), _value(c[3], at)) for c in (rulings.first, rulings.second))
    if is_zero(weight_a) or is_zero(weight_b):
        raise UnsupportedPair("a common ruling on which a directrix of a trimmed piece is infinite; bound u")
    return a / weight_a, b / weight_b - a / weight_a
