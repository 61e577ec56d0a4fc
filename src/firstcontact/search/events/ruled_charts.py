"""Ruled surfaces as charts for the search for events, and its tables against a composite quadric model.

Only the ruled surface has charts here: its faces, directrices, end rulings and vertices.  What begins to touch is told
by the surfaces of the model alone, since those of every feature of it vanish there:
    face      f = 0, and f_u = f_s = 0 on a face, f_u = 0 on a border
    edge      f = g = 0, and on a face f_u g_s = f_s g_u
    vertex    f = g = h = 0 on a face
At reentrant edges both f and g are least, so that the faces tell; borders and corners meet edges and vertices where
they meet faces and edges beside them.  A tip without edges counts as the common point of three planes.
Where inequalities g >= 0 cut the surface, g = 0 is a border too:
    face      f = g = 0 and f_u g_s = f_s g_u; at its corners f = g = h = 0, on a border f = g = 0
    edge      f = e = g = 0
The search has g as a form over a chart of its own: with g = a + b s + c s^2 it is -y^T Q y = a + (b + c s) s on the
points y = (b + c s, s, a, 1).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import arb, fmpq, fmpq_poly, fmpz, fmpz_poly

from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.body.solid.carriers import EnclosedPoint
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.features import Edge, Face, Vertex, enclosure
from firstcontact.exact.numbers import exact_value, precision, to_double
from firstcontact.kernels.events.event_search import ALL_PAIRS, KNOWN, OWN, SECOND_CUT, STILL
from firstcontact.kernels.events.feature_boxes import (
    ABOUT,
    AND,
    BEND,
    BEND_U,
    BEND_V,
    CURVED,
    DEGREE,
    GIVEN,
    LEAF,
    MIDDLE_TIME,
    MOST_DEGREE,
    OFF,
    OFF_U,
    OFF_V,
    PER_HALF,
    POWERS,
    TIMES,
    WIDE,
)
from firstcontact.search.events.charts import BITS, Charts, NotCharted, forms_of, resting
from firstcontact.search.events.event_tables import Tables, crossing_surfaces, programs_of
from firstcontact.search.rulings.ruled_pieces import RangePart, RuledPiece

if TYPE_CHECKING:
    from firstcontact.body.kinds import Ruled
    from firstcontact.exact.ring import E

MOST_FORMS = 62
"""Of a model; the search keeps them as bits."""
FLAT = 1e-6
"""Determinant of unit normals below which three surfaces do not fix a vertex well."""


@dataclass(frozen=True, eq=False)
class ChartSheet:
    """A part of a piece: X = first + s (second - first) over its x in [-1, 1]; homogeneous, in the body's frame.

    later: of a part that deforms what T, T^2, ... are multiplied with to be added to X; `at` a time it is all of X.
    cuts: what cuts the part.
    """

    number: int
    part: RangePart
    first: list[fmpz_poly]
    second: list[fmpz_poly]
    later: tuple[ChartSheet, ...] = ()
    cuts: tuple[TrimCut, ...] = ()

    @property
    def degree(self) -> int:
        return max(c.degree() for sheet in (self, *self.later) for c in (*sheet.first, *sheet.second))

    def keeps(self, x: fmpq, s: fmpq) -> bool:
        """Whether all inequalities that cut the part hold there."""
        return all(cut.value(x, s) >= 0 for cut in self.cuts)

    def at(self, t: fmpq | arb) -> ChartSheet | Mixed:
        return Mixed((self, *self.later), [t**k for k in range(len(self.later) + 1)]) if self.later else self

    def rate(self, t: fmpq | arb) -> Mixed | None:
        """The derivative by the time; None where there is none."""
        return Mixed(self.later, [k * t ** (k - 1) for k in range(1, len(self.later) + 1)]) if self.later else None

    def point(self, x: E, s: E) -> list[E]:
        """Homogeneous, in the numbers of x and s."""
        return _blended((self.first, self.second), x, s)

    @cached_property
    def slopes(self) -> tuple[list[fmpz_poly], list[fmpz_poly]]:
        first, second = ([c.derivative() for c in side] for side in (self.first, self.second))
        return first, second

    @cached_property
    def bends(self) -> tuple[list[fmpz_poly], list[fmpz_poly]]:
        first, second = ([c.derivative() for c in side] for side in self.slopes)
        return first, second

    def by_x(self, x: arb, s: arb) -> list[arb]:
        return _blended(self.slopes, x, s)

    def by_s(self, x: arb) -> list[arb]:
        return [q(x) - p(x) for p, q in zip(self.first, self.second, strict=True)]

    def by_xx(self, x: arb, s: arb) -> list[arb]:
        return _blended(self.bends, x, s)

    def by_xs(self, x: arb) -> list[arb]:
        return [q(x) - p(x) for p, q in zip(*self.slopes, strict=True)]


def _blended(sides: tuple[list[fmpz_poly], list[fmpz_poly]], x: E, s: E) -> list[E]:
    return [p(x) * (1 - s) + q(x) * s for p, q in zip(*sides, strict=True)]


@dataclass(frozen=True, eq=False)
class Mixed:
    """A sum of multiples of sheets, to be asked like one."""

    sheets: tuple[ChartSheet, ...]
    weights: list[Any]

    def point(self, x: E, s: E) -> list[E]:
        return self._sum(sheet.point(x, s) for sheet in self.sheets)

    def by_x(self, x: arb, s: arb) -> list[arb]:
        return self._sum(sheet.by_x(x, s) for sheet in self.sheets)

    def by_s(self, x: arb) -> list[arb]:
        return self._sum(sheet.by_s(x) for sheet in self.sheets)

    def by_xx(self, x: arb, s: arb) -> list[arb]:
        return self._sum(sheet.by_xx(x, s) for sheet in self.sheets)

    def by_xs(self, x: arb) -> list[arb]:
        return self._sum(sheet.by_xs(x) for sheet in self.sheets)

    def _sum(self, rows: Iterator[list[E]]) -> list[E]:
        scaled = [[w * c for c in row] for w, row in zip(self.weights, rows, strict=True)]
        return [sum(column[1:], column[0]) for column in zip(*scaled, strict=True)]


@dataclass(frozen=True, eq=False)
class TrimCut:
    """The inequality sum of s^k powers[k](x) >= 0."""

    powers: tuple[fmpz_poly, ...]

    def value(self, x: Any, s: Any) -> Any:
        return _in_s(self.powers, x, s)

    def slopes(self, x: arb, s: arb) -> tuple[arb, arb]:
        """Derivatives by x and by s."""
        by_x, by_s = self._slopes
        return _in_s(by_x, x, s), _in_s(by_s, x, s)

    def bends(self, x: arb, s: arb) -> dict[tuple[int, int], arb]:
        """Second derivatives."""
        by_x, by_s = self._slopes
        mixed = _in_s([p.derivative() for p in by_s], x, s)
        return {
            (0, 0): _in_s([p.derivative() for p in by_x], x, s), (0, 1): mixed, (1, 0): mixed,
            (1, 1): _in_s(_by_s(by_s), x, s),
        }  # fmt: skip

    @cached_property
    def _slopes(self) -> tuple[list[fmpz_poly], list[fmpz_poly]]:
        return [p.derivative() for p in self.powers], _by_s(self.powers)

    @property
    def degrees(self) -> tuple[int, int]:
        """In x and in s."""
        return max(p.degree() for p in self.powers), len(self.powers) - 1

    @cached_property
    def size(self) -> int:
        """The largest coefficient."""
        return max((abs(int(c)) for p in self.powers for c in p.coeffs()), default=1)


def _by_s(powers: Sequence[fmpz_poly]) -> list[fmpz_poly]:
    return [k * p for k, p in enumerate(powers)][1:] or [fmpz_poly([0])]


def _in_s(powers: Sequence[fmpz_poly], x: Any, s: Any) -> Any:
    total = powers[-1](x)
    for p in reversed(powers[:-1]):
        total = total * s + p(x)
    return total


@dataclass(frozen=True, eq=False)
class RuledFeature:
    """kind: "face", "directrix", "end_ruling" or "vertex"; x, s: the parameters that are fixed, else None.

    inner: whether the border is one of pieces of a strip only.
    """

    sheet: ChartSheet
    kind: str
    index: int
    x: int | None
    s: int | None
    inner: bool = False

    def place(self, u: float, v: float) -> tuple[float, float]:
        """x and s at the parameters of the feature's chart."""
        if self.kind == "end_ruling":
            return float(self.x), u  # type: ignore[arg-type]
        return (u if self.x is None else float(self.x)), (v if self.s is None else float(self.s))

    def is_near(self, place: tuple[float, float], distance: float) -> bool:
        """Whether a place of the sheet is that near the feature, in its parameters."""
        fixed = (self.x, self.s)
        return all(own is None or abs(own - c) < distance for own, c in zip(fixed, place, strict=True))


Terms = dict[tuple[int, int], int]
"""c of u^i s^j by (i, j)."""


def sheets_of(body: Ruled, trims: Sequence[tuple[Sequence[Terms], Sequence[Terms]]]) -> list[ChartSheet]:
    """All parts of all pieces of a ruled surface or strip.  Raises NotCharted.

    trims: for every piece its inequalities g >= 0, with s from 0 to 1, and the same in 1/u.
    """
    found = []
    for number, piece in enumerate(body.pieces):
        who = piece.name or "the ruled surface"
        if piece.s is None:
            raise NotCharted(f"{who} has whole rulings")
        local = RuledPiece.of(piece.sides, piece.u)
        for k, part in enumerate(local.parts):
            sides = _with_one_weight(*([_powers_of_time(c) for c in local.components(k, i)] for i in range(2)))
            rows = _by_time(*sides)
            sheet, *later = (ChartSheet(number, part, *row) for row in rows)
            cuts = tuple(_cut(g, part) for g in trims[number][1 if part.inverted else 0])
            sheet = replace(sheet, later=tuple(later), cuts=cuts)
            if max([sheet.degree, *(cut.degrees[0] for cut in cuts)]) > MOST_DEGREE:
                raise NotCharted(f"{who} is of degree {sheet.degree}")
            if any(cut.degrees[1] > 2 for cut in cuts):
                raise NotCharted(f"{who} has an inequality of a degree in s above 2")
            found.append(sheet)
    return found


def _cut(g: Terms, part: RangePart) -> TrimCut:
    powers = []
    for k in range(1 + max((j for _, j in g), default=0)):
        coefficients = [0] * (1 + max((i for i, j in g if j == k), default=0))
        for (i, j), c in g.items():
            if j == k:
                coefficients[i] = c
        powers.append(fmpq_poly(coefficients)(fmpq_poly([part.middle, part.half])))
    below = reduce(lambda n, p: n.lcm(p.denom()), powers, fmpz(1))
    return TrimCut(tuple((p * below).numer() for p in powers))


InTime = list[fmpq_poly]
"""The coefficients of the powers of T, polynomials in x."""


def _powers_of_time(component: list[fmpz_poly]) -> InTime:
    """From the coefficients of the powers of x, polynomials in T."""
    count = 1 + max([0, *(c.degree() for c in component)])
    return [fmpq_poly([c[k] for c in component]) for k in range(count)]


def _with_one_weight(p: list[InTime], q: list[InTime]) -> tuple[list[InTime], list[InTime]]:
    """Both sides times what makes their weights one."""
    if p[3] == q[3]:
        return p, q
    if max(len(p[3]), len(q[3])) > 1:
        return [_product(c, q[3]) for c in p], [_product(c, p[3]) for c in q]
    (a,), (b,) = p[3], q[3]
    common = a.gcd(b)
    return [_product(c, [b // common]) for c in p], [_product(c, [a // common]) for c in q]


def _product(p: InTime, q: InTime) -> InTime:
    found = [fmpq_poly([0])] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            found[i + j] = found[i + j] + a * b
    return found


def _by_time(p: list[InTime], q: list[InTime]) -> list[tuple[list[fmpz_poly], list[fmpz_poly]]]:
    """Both sides times one number, for each power of T."""
    below = reduce(lambda n, c: n.lcm(c.denom()), (c for side in (p, q) for x in side for c in x), fmpz(1))
    count = max((k + 1 for side in (p, q) for x in side for k, c in enumerate(x) if c != 0), default=1)
    rows = []
    for k in range(count):
        a, b = ([(x[k] * below).numer() if k < len(x) else fmpz_poly([0]) for x in side] for side in (p, q))
        rows.append((a, b))
    return rows


def features_of(sheet: ChartSheet, piece: RuledSurface) -> Iterator[RuledFeature]:
    """The face, the borders and the corners of a part; sides that are a point are corners."""
    part = sheet.part
    ends = [k for k in range(2) if part.ends[k]]
    for k in range(2):
        inner = f"s{k}" in piece.joined
        if _is_point(sheet, k):
            yield RuledFeature(sheet, "vertex", k, 0, k, inner)
        else:
            yield RuledFeature(sheet, "directrix", k, None, k, inner)
            for end in ends:
                i = 1 - end if part.inverted else end
                yield RuledFeature(sheet, "vertex", 2 * i + k, 2 * end - 1, k, inner or f"u{i}" in piece.joined)
    for end in ends:
        i = 1 - end if part.inverted else end
        yield RuledFeature(sheet, "end_ruling", i, 2 * end - 1, None, f"u{i}" in piece.joined)
    yield RuledFeature(sheet, "face", 0, None, None)


def _is_point(sheet: ChartSheet, which: int) -> bool:
    """Whether a side is a point, which may move."""
    side = [[fmpq_poly((x.first, x.second)[which][i]) for x in (sheet, *sheet.later)] for i in range(4)]
    slopes = [[c.derivative() for c in x] for x in side]
    return all(_product(x, slopes[3]) == _product(side[3], y) for x, y in zip(side[:3], slopes, strict=False))


def ruled_tables(
    ruled: RuledSurface, sheets: list[ChartSheet], model: CompositeQuadric, side: int, span: tuple[float, float]
) -> Tables:
    """The tables of a ruled surface, body `side`, with its sheets, and a model, over a span.  Raises NotCharted."""
    units = _units(ruled, span)
    forms, planes = _model_forms(model)
    cuts = max(len(sheet.cuts) for sheet in sheets)
    own = _own_forms(units, cuts)
    sides = (own, forms) if side == 0 else (forms, own)
    n, steps = [len(x.forms) for x in sides], [len(x.program) for x in sides]
    program, layout = programs_of(sides, n, steps)
    kinds = np.concatenate([x.kinds for x in sides])
    total = sum(n)
    table = np.zeros((2 * total, 4, 16))
    table[: n[0]], table[total : total + n[1]] = (resting(x.forms, x.kinds) for x in sides)
    table[n[0] : total, ABOUT, CURVED], table[total + n[1] :, ABOUT, CURVED] = sides[1].kinds, sides[0].kinds
    table[layout[side, OWN] : layout[side, OWN] + cuts, ABOUT, GIVEN] = 1.0
    degrees = [max([1, sheet.degree, *(n for cut in sheet.cuts for n in cut.degrees)]) for sheet in sheets]
    wide = 8 * (max(degrees) + 1)
    width = POWERS + wide * max(len(sheet.later) + 1 for sheet in sheets)
    charts, info, pairs, features, others, boxes, still = [], [], [], [], [], [], []  # type: ignore[var-annotated]
    known = [_other_pairs(model, params, planes, n[side]) for params in range(3)]
    for sheet in sheets:
        for feature in features_of(sheet, ruled.pieces[sheet.number]):
            params = (feature.x is None) + (feature.s is None)
            number, first = len(charts), len(pairs)
            for other, row in (*known[params], *_cut_pairs(model, params, planes, len(sheet.cuts))):
                pairs.append(row)
                others.append(other)
            if sheet.later:
                charts.append(_deforming_row(feature, units, width, wide, span))
            else:
                charts.append(_row(feature, units, width))
            info.append([side, params, 0, first, len(pairs), cuts])
            features.append(feature)
            for cut in (*sheet.cuts, *[ALWAYS] * (cuts - len(sheet.cuts))):
                charts.append(_cut_row(feature, cut, width))
                info.append([side, params, 0, len(pairs), len(pairs), 0])
                features.append(feature)
            half = 1.0 + 2.0**-52
            at = (0.0, half) if feature.x is None else (0.5, 0.5) if feature.s is None else (0.0, 0.0)
            across = (0.5, 0.5) if params == 2 else (0.0, 0.0)
            boxes.append([number, ALL_PAIRS, *at, *across, 0.0, 0.0])
            if params == 2:
                still.append([number, STILL, *at, *across, 0.0, 0.0])
    return Tables(
        np.array(charts), np.array(info, np.int64), np.array(pairs, np.int64).reshape(-1, 5), layout, program,
        np.concatenate([x.forms for x in sides]), kinds,
        np.array([x.units for x in sides]), table, features, others, np.array(boxes, float), np.array(still, float),  # type: ignore[arg-type]
        np.zeros((len(boxes), KNOWN), np.int64), np.zeros((len(still), KNOWN), np.int64),
    )  # fmt: skip


ALWAYS = TrimCut((fmpz_poly([1]),))


def _own_forms(units: np.ndarray, cuts: int) -> Charts:
    """Of inequalities, negative where they hold; where there are none one that is negative everywhere."""
    if cuts > MOST_FORMS:
        raise NotCharted("too many inequalities")
    form, program = np.diag([1.0, 1.0, 1.0, -3.1]), [[LEAF, 0]]
    if cuts:
        form = np.zeros((4, 4))
        form[[0, 1, 2, 3], [1, 0, 3, 2]] = -0.5
        program += [step for k in range(1, cuts) for step in ([LEAF, k], [AND, 0])]
    count = max(1, cuts)
    return Charts(
        units, np.tile(form.ravel(), (count, 1)), np.ones(count, np.int64), np.array(program, np.int64), []
    )


def _cut_row(feature: RuledFeature, cut: TrimCut, width: int) -> np.ndarray:
    """The row of the chart of an inequality, in the parameters of a feature."""
    row = np.zeros(width)
    row[POWERS + 3] = 1.0
    if feature.x is None and feature.s is None:
        row[POWERS + 5] = 1.0
        for k, p in enumerate(cut.powers):
            for j, c in enumerate(p.coeffs()):
                row[POWERS + 8 * j + (2, 0, 4)[k]] = to_double(fmpq(c, cut.size))
        row[DEGREE] = max(1, cut.degrees[0])
        return row
    if feature.x is None:
        along = _in_s(cut.powers, fmpz_poly([0, 1]), feature.s).coeffs()
    elif feature.s is None:
        along = [p(feature.x) for p in cut.powers]
    else:
        along = [cut.value(feature.x, feature.s)]
    for j, c in enumerate(along):
        row[POWERS + 8 * j + 2] = to_double(fmpq(c) / cut.size)
    row[DEGREE] = max(1, len(along) - 1)
    return row


def _units(ruled: RuledSurface, span: tuple[float, float]) -> np.ndarray:
    lo, hi = ruled.bounds(span)
    size = 2.0 ** math.frexp(float(np.max(hi - lo)) / 2 * (1 + 1e-9))[1]
    middle = np.round((lo + hi) / 2 / size * 1024) / 1024 * size
    if np.any(np.maximum(hi - middle, middle - lo) > size):
        size *= 2
    return np.array([*middle, size])


def _row(feature: RuledFeature, units: np.ndarray, width: int) -> np.ndarray:
    """A chart's row; of end rulings and corners a chart of degree 1 or 0 in s."""
    row = np.zeros(width)
    first, second = (_scaled(side, units) for side in (feature.sheet.first, feature.sheet.second))
    if feature.x is not None:
        a, b = ([c(fmpq(feature.x)) for c in side] for side in (first, second))
        if feature.s is not None:
            a = b = b if feature.s else a
        largest = max(abs(c) for c in (*a, *b))
        row[:4] = [to_double(c / largest) for c in a]
        row[4:8] = [to_double((d - c) / largest) for c, d in zip(a, b, strict=True)]
        return row
    if feature.s is not None:
        first = second = second if feature.s else first
    largest = max(abs(c) for side in (first, second) for p in side for c in p.coeffs())
    for i, (p, q) in enumerate(zip(first, second, strict=True)):
        for j in range(max(p.degree(), q.degree()) + 1):
            row[POWERS + 8 * j + i] = to_double(p[j] / largest)
            row[POWERS + 8 * j + 4 + i] = to_double((q[j] - p[j]) / largest)
    row[DEGREE] = max(c.degree() for side in (first, second) for c in side)
    return row


def _deforming_row(
    feature: RuledFeature, units: np.ndarray, width: int, wide: int, span: tuple[float, float]
) -> np.ndarray:
    """A chart's row; its own measure of time is -1 to 1 over the span."""
    first, last = (exact_value(t) for t in span)
    middle = exact_value(to_double((first + last) / 2))
    half = max((last - first) / 2, abs(first) / 2**40, fmpq(1, 2**99))
    per = exact_value(to_double(1 / half))
    table = _shifted(_coefficients(feature, units), middle, 1 / per)  # [m][n][8]
    largest = max(abs(c) for block in table for line in block for c in line)
    doubles = np.array([[[to_double(c / largest) for c in line] for line in block] for block in table])
    row = np.zeros(width)
    row[[DEGREE, TIMES, WIDE]] = len(table[0]) - 1, len(table) - 1, wide
    row[MIDDLE_TIME], row[PER_HALF] = to_double(middle), to_double(per)
    for q, block in enumerate(doubles):
        row[POWERS + q * wide : POWERS + q * wide + block.size] = block.ravel()
    # all of |x| <= 1, 0 <= s <= 1 and |time| <= 1, with room
    sizes = np.abs(doubles) * (1.0 + 1e-6)
    powers, degrees = np.arange(len(doubles)), np.arange(doubles.shape[1])
    roundings = (4.0 * len(powers) + 8.0 * len(degrees) + 32.0) * 2.0**-53
    for weights, column in (
        (powers * (powers - 1.0), (BEND, BEND_U, BEND_V)),
        (roundings * (powers + 1.0), (OFF, OFF_U, OFF_V)),
    ):
        by_power = np.einsum("q,qjc->jc", weights, sizes)
        both = by_power[:, :4] + by_power[:, 4:]
        for to, values in zip(column, (both.sum(axis=0), degrees @ both, by_power[:, 4:].sum(axis=0)), strict=True):
            if to in (OFF, OFF_U, OFF_V):
                row[to] = values.max()
            else:
                row[to : to + 4] = values
    return row


def backwards(tables: Tables) -> Tables:
    """The tables for times -t, with which motions run backwards."""
    if not any(feature.sheet.later for feature in tables.features):  # type: ignore[union-attr]
        return tables
    charts = tables.charts.copy()
    charts[:, [MIDDLE_TIME, PER_HALF]] *= -1.0
    return replace(tables, charts=charts)


def _coefficients(feature: RuledFeature, units: np.ndarray) -> list[list[list[fmpq]]]:
    """c[m][n][8]: of T^m p^n the coefficients of 1 and r, for the chart's parameters p and r, in units of the body."""
    table = []
    for sheet in (feature.sheet, *feature.sheet.later):
        first, second = (_scaled(side, units) for side in (sheet.first, sheet.second))
        if feature.s is not None:
            first = second = second if feature.s else first
        if feature.x is None:
            count = max(2, feature.sheet.degree + 1)
            block = [[*(p[n] for p in first), *(q[n] - p[n] for p, q in zip(first, second, strict=True))]
                     for n in range(count)]  # fmt: skip
        else:
            a, b = ([c(fmpq(feature.x)) for c in side] for side in (first, second))
            none = [fmpq(0)] * 4
            block = [[*a, *none], [*(y - x for x, y in zip(a, b, strict=True)), *none]]
        table.append(block)
    return table


def _shifted(table: list[list[list[fmpq]]], middle: fmpq, half: fmpq) -> list[list[list[fmpq]]]:
    """The same in powers of (T - middle) / half."""
    argument = fmpq_poly([middle, half])
    found = [[[fmpq(0)] * 8 for _ in block] for block in table]
    for n in range(len(table[0])):
        for c in range(8):
            moved = fmpq_poly([block[n][c] for block in table])(argument)
            for q in range(len(table)):
                found[q][n][c] = moved[q]
    return found


def _scaled(side: Sequence[fmpz_poly], units: np.ndarray) -> list[fmpq_poly]:
    """In units of the body."""
    c, h = [exact_value(x) for x in units[:3]], exact_value(units[3])
    *xyz, w = (fmpq_poly(c) for c in side)
    return [*((x - m * w) / h for x, m in zip(xyz, c, strict=True)), w]


# -- what the model's features are to charts ----------------------------------------------------------------------


def _model_forms(model: CompositeQuadric) -> tuple[Charts, dict[int, int]]:
    """The forms of the model, with three planes through every vertex that its surfaces do not fix; their first rows."""
    known = forms_of(model)
    rows: list[np.ndarray] = []
    first: dict[int, int] = {}
    with precision(BITS):
        for vertex in model.vertices:
            if isinstance(vertex.carrier, EnclosedPoint) and not vertex.carrier.proved:
                raise NotCharted(f"{vertex.name}: its place is not proved")
            if crossing_at(model, vertex) is None:
                first[vertex.index] = len(known.forms) + len(rows)
                for k, c in enumerate(enclosure(vertex.carrier)):
                    row = np.zeros(16)
                    row[k], row[3] = 1.0, -float(((c - arb(known.units[k])) / arb(known.units[3])).mid())
                    rows.append(row)
    forms = np.concatenate([known.forms, np.array(rows).reshape(-1, 16)])
    if len(forms) > MOST_FORMS:
        raise NotCharted("too many surfaces")
    kinds = np.concatenate([known.kinds, np.zeros(len(rows), np.int64)])
    return Charts(known.units, forms, kinds, known.program, []), first


def crossing_at(model: CompositeQuadric, vertex: Vertex) -> tuple[int, int, int] | None:
    """Three surfaces that cross at the vertex."""
    point = np.array([*vertex.position, 1.0])
    normals = {k: (model.forms[k] @ point)[:3] for k in vertex.surfaces}
    chosen: list[int] = []
    units: list[np.ndarray] = []
    for k, n in normals.items():
        length = float(np.linalg.norm(n))
        bend = float(np.abs(model.forms[k][:3, :3]).max())
        if length <= bend * (1e-9 * float(np.abs(point[:3]).max()) + 16.0 * vertex.error):  # a tip
            continue
        if len(units) == 0 or np.linalg.svd(np.array([*units, n / length]))[1][-1] > FLAT:
            chosen.append(k)
            units.append(n / length)
        if len(chosen) == 3:
            return chosen[0], chosen[1], chosen[2]
    return None


def _other_pairs(
    model: CompositeQuadric, params: int, planes: dict[int, int], own: int
) -> list[tuple[Face | Edge | Vertex, list[int]]]:
    """(feature of the model, row of the search's pairs) for charts with so many parameters.

    The row: number of equations, derivatives, forms f and g of the model or -1, and one that counts after the `own`
    forms of the chart's body.
    """
    found: list[tuple[Face | Edge | Vertex, list[int]]] = []
    seen: set[Any] = set()
    for face in model.faces:
        if face.surfaces[0] not in seen:
            seen.add(face.surfaces[0])
            found.append((face, [params + 1, params, face.surfaces[0], -1, -1]))
    if params == 0:
        return found
    for edge in model.edges:
        crossing = crossing_surfaces(model, edge)
        if len(crossing) < 2:  # two planes in one form
            raise NotCharted(f"{edge.name}: one surface crosses itself there")
        f, g = crossing
        if edge.convexity == "reentrant" or (f, g) in seen:
            continue
        seen.add((f, g))
        found.append((edge, [2, 0, f, g, -1] if params == 1 else [3, 2, f, -1, own + g]))
    for vertex in model.vertices:
        tip = planes.get(vertex.index)
        if params == 1:
            if tip is not None:
                found.append((vertex, [2, 0, tip, tip + 1, -1]))
            continue
        h, f, g = (tip, tip + 1, tip + 2) if tip is not None else crossing_at(model, vertex)  # type: ignore[misc]
        found.append((vertex, [3, 0, f, g, own + h]))
    return found


def _cut_pairs(
    model: CompositeQuadric, params: int, planes: dict[int, int], cuts: int
) -> list[tuple[Face | Edge | Vertex, list[int]]]:
    """As `_other_pairs`, for the borders and corners that inequalities make."""
    if params == 0 or not cuts:
        return []
    found: list[tuple[Face | Edge | Vertex, list[int]]] = []
    faces = {face.surfaces[0]: face for face in reversed(model.faces)}
    for (f, face), k in product(sorted(faces.items()), range(cuts)):
        if params == 1:
            found.append((face, [2, 0, f, -1, k]))
            continue
        found.append((face, [3, 2, f, -1, k]))
        found += [(face, [3, 0, f, SECOND_CUT + other, k]) for other in range(k + 1, cuts)]
    if params == 2:
        for other, row in _other_pairs(model, 1, planes, 0):
            if not isinstance(other, Face):  # two equations, without derivatives
                found += [(other, [3, 0, *row[2:4], k]) for k in range(cuts)]
    return found
