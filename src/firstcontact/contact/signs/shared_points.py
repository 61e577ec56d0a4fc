"""Points that two ruled pieces share at one instant, rational or algebraic, exactly.

On a sheet the first parameter of an isolated contact is a zero of a border, or an end of its range; the other one is
then a zero of f.  Both are found in the field of the instant: where borders touch or cross, their common divisors over
that field mostly are linear.  Boxes that survived exclusion tell where to look.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from flint import arb, fmpq, fmpz_mpoly

from firstcontact.contact.signs.closer import closer
from firstcontact.contact.signs.conditions import Range, SignConditions
from firstcontact.contact.signs.exclusion import ParameterBox, Span, clusters
from firstcontact.contact.signs.sheets import Sheet, sheets
from firstcontact.exact.fields.common_field import Polynomial, adjoined, gcd, refined, squarefree
from firstcontact.exact.fields.field_towers import trimmed
from firstcontact.exact.fields.number_field import FieldElement, NumberField, is_zero, sign
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import precision
from firstcontact.exact.polynomials.trivariate import coefficients, degree, terms, univariate

WIDE = fmpq(1, 256)
"""Groups of boxes of this width may hold a curve of contacts: then rational parameters are tried too."""
BITS = 192


@dataclass(frozen=True)
class FieldPoint:
    """A shared point: the parameters in one field, in a chart of the pieces.

    conditions   of the chart; u and v are its parameters, inverse ones where `inverse` says so
    ranges       of the pieces' parameters
    """

    conditions: SignConditions
    inverse: tuple[bool, bool]
    ranges: tuple[Range, Range]
    u: FieldElement
    v: FieldElement
    t: FieldElement

    def value(self, f: fmpz_mpoly) -> FieldElement:
        return _value(f, (self.u, self.v, self.t))


@dataclass(frozen=True)
class NearContact(FieldPoint):
    """A place in contact shortly after the instant in question; what is SMALL there vanishes then."""


SMALL = 1e-7


def vanishes(contact: FieldPoint, x: FieldElement, size: int = 1) -> bool:
    """Whether a number of the contact is zero; size: of its terms."""
    if is_zero(x):
        return True
    return isinstance(contact, NearContact) and bool(abs(x.ball(BITS).mid()) <= arb(SMALL) * size)


def shared_points(c: SignConditions, t: AlgebraicRoot, boxes: Iterable[ParameterBox]) -> Iterator[FieldPoint]:
    """Contacts at the instant t near the boxes; none proves that there is none near them.

    c holds the conditions of the motion, or of the instant alone where t is rational.  UnsupportedPair beyond the
    degrees that elimination masters.
    """
    field = NumberField(t)
    by_chart: dict[tuple[bool, bool], list[ParameterBox]] = {}
    for box in closer(c, t, list(boxes)):
        by_chart.setdefault(box.inverse, []).append(box)
    for inverse, group in by_chart.items():
        chart = c.charts[inverse]
        own = sheets(chart)
        for u, v in clusters(group):
            for sheet in own:
                for point in _on_sheet(chart, sheet, field, u, v, inverse):
                    yield FieldPoint(chart, inverse, (c.u, c.v), *point)


Point = tuple[FieldElement, FieldElement, FieldElement]


def _on_sheet(
    c: SignConditions, sheet: Sheet, field: NumberField, u: Span, v: Span, inverse: tuple[bool, bool]
) -> Iterator[Point]:
    """(u, v, T) of contacts; at the ends of the ranges of `inverse` parameters another chart has them."""
    first, second = (v, u) if sheet.exchanged else (u, v)
    around, across = inverse[::-1] if sheet.exchanged else inverse
    t = field.generator()
    firsts: list[tuple[NumberField, FieldElement, FieldElement]] = []
    assert sheet.first is not None and sheet.second is not None
    middle = {(first[0] + first[1]) / 2} if first[1] - first[0] > WIDE else set()
    for place in middle if around else {*sheet.first} | middle:
        if first[0] <= place <= first[1]:
            firsts.append((field, field(place), t))
    borders = [_in_u(b, field) for b in sheet.borders if degree(b, 0) and _near_zero(b, first, None, field.root)]
    for g in refined([trimmed(b) for b in borders]):
        for zero in adjoined(field, g, *first):
            if not any(is_zero(zero.zero - end) for end in sheet.first):
                firsts.append((zero.field, zero.zero, zero.carry(t)))
    instant = field.root
    for own, x, time in firsts:
        for when, x1, y1 in _seconds(sheet, own, instant, x, time, first, second):
            if across and any(is_zero(y1 - end) for end in sheet.second):
                continue
            point = (y1, x1, when) if sheet.exchanged else (x1, y1, when)
            if c.holds(_Signs(point), sheet.f is not None):
                yield point


class _Signs:
    """Signs of polynomials at a point: by balls, and exactly where these hold 0."""

    def __init__(self, point: Point) -> None:
        self.point, self.balls = point, [x.ball(BITS) for x in point]
        self.known: dict[int, tuple[fmpz_mpoly, int]] = {}
        """By identity; the polynomial is kept lest another one takes its place in memory."""

    def __call__(self, f: fmpz_mpoly) -> int:
        if id(f) not in self.known:
            self.known[id(f)] = f, self._sign(f)
        return self.known[id(f)][1]

    def _sign(self, f: fmpz_mpoly) -> int:
        with precision(BITS):
            u, v, t = self.balls
            near = sum((c * u**i * v**j * t**k for (i, j, k), c in terms(f)), arb(0))
        if near > 0 or near < 0:
            return 1 if near > 0 else -1
        return sign(_value(f, self.point))


def _seconds(
    sheet: Sheet, field: NumberField, instant: AlgebraicRoot, x: FieldElement, t: FieldElement, first: Span,
    second: Span,
) -> Iterator[Point]:
    """(t, first, second parameter) of the points to test over the first one."""
    f = [] if sheet.f is None else trimmed(_in_v(sheet.f, x, t))
    others = [_in_v(g, x, t) for g in sheet.clips if degree(g, 1) and _near_zero(g, first, second, instant)]
    if f:
        f = squarefree(f)
        lines: list[Polynomial] = [g for g in refined([f, *map(trimmed, others)]) if len(gcd(g, f)) > 1]
    else:
        lines = refined([trimmed(g) for g in others])
        assert sheet.second is not None
        for y in {sheet.second[0], sheet.second[1], (second[0] + second[1]) / 2}:
            if second[0] <= y <= second[1]:
                yield t, x, field(y)
    for g in lines:
        for zero in adjoined(field, g, *second):
            yield zero.carry(t), zero.carry(x), zero.zero


def _in_u(b: fmpz_mpoly, field: NumberField) -> Polynomial:
    return [field(univariate(c, 2)) for c in coefficients(b, 0)]


def _in_v(f: fmpz_mpoly, x: FieldElement, t: FieldElement) -> Polynomial:
    return [_value(c, (x, x, t)) for c in coefficients(f, 1)]


def _near_zero(f: fmpz_mpoly, u: Span, v: Span | None, instant: AlgebraicRoot) -> bool:
    """False proves that f has no zero in the ranges at the instant."""
    t = instant.enclosure(BITS)
    with precision(BITS):
        x, y = (arb(0) if r is None else arb(r[0]).union(arb(r[1])) for r in (u, v))
        return bool(sum((c * x**i * y**j * t**k for (i, j, k), c in terms(f)), arb(0)).contains(0))


def _value(f: fmpz_mpoly, point: Point) -> FieldElement:
    field = point[2].field
    total = field(0)
    powers: list[list[FieldElement]] = [[field(1)] for _ in range(3)]
    for key, c in terms(f):
        term = field(fmpq(c))
        for n, known, x in zip(key, powers, point, strict=True):
            while len(known) <= n:
                known.append(known[-1] * x)
            if n:
                term = term * known[n]
        total = total + term
    return total

