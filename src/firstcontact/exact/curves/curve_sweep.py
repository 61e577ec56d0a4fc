"""The sweep over u that finds the topology of plane curves: critical values, slabs between them, fibres over them.

Critical are the u where branches meet, turn back or cross v = c, v = d, and those of common points with the clip
polynomials: roots of discriminants, resultants and of f(u, c), f(u, d).  Between two neighbours the branches are the
simple roots of f(m, v), m rational.  Over a critical u the real zeros of f(u, v) are known with multiplicities
(`fibres`): a simple zero takes one branch from either side, in order, and a multiple one takes what is left; where two
multiple ones compete, a line v = j between them that no branch meets near the fibre decides.  Nothing else is needed:
no shear to generic position, no neighbourhood of a singular point, no projection to v.

Where u is projective the fibre u = 1 is one object with branches from both charts, and points of v = 1 belong to both
cells above u, so charts come glued.  A component that is a line v = const is a branch like others, unless it is on
the border of the cells; there, and along lines u = const, edges run between the nodes.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from functools import cmp_to_key
from typing import Any

from flint import arb, fmpq, fmpz_mpoly, fmpz_poly

from firstcontact.exact.curves.fibres import (
    FIRST,
    LAST,
    CurveFibre,
    FibreZero,
    PrecisionExhausted,
    ZeroCell,
    simple_between,
)
from firstcontact.exact.fields.roots import AlgebraicRoot, isolate, reversed_polynomial, root_free
from firstcontact.exact.numbers import dyadic, precision
from firstcontact.exact.polynomials.bivariate import (
    Rows,
    chart,
    discriminant,
    factors,
    in_v,
    level,
    over,
    restrict,
    resultant,
    rows,
    slope,
)

Range = tuple[fmpq, fmpq] | None
# Why a value of u is critical; Events tell the order to which the polynomial in question vanishes there:
#   ("fold", i) disc_v of curve i        ("cross", i, j), i < j: Res_v of two curves    ("side", s, i) curve i on line s
#   ("extra", i, e) Res_v of curve i and extra e        ("mark", s) an extra on line s, which belongs to the curve
#   ("line", k) vertical line k         ("all",) every zero becomes a node: ends of the chart, extras in u alone
Event = tuple[Any, ...]
Events = dict[Event, int]
# Who takes branches over a fibre: a node, or the k-th zero of the curve in the open cell, which passes them on (-1:
# all zeros, in order); and how many, None where it is not known yet.
Slot = tuple[Any, int | None]

_X = fmpz_poly([0, 1])


class GraphPoint:
    """A node while the graph is built: over a fibre, on a line or inside a cell; the zeros of the curves there."""

    __slots__ = ("cell", "fibre", "index", "left", "right", "side", "zeros")

    def __init__(self, fibre: Fibre, cell: int | None, side: int | None) -> None:
        self.fibre, self.cell, self.side = fibre, cell, side
        self.zeros: dict[int, FibreZero] = {}
        self.index, self.left, self.right = -1, 0, 0

    def curves(self) -> list[int]:
        """The curves of the column through this point."""
        found = set(self.zeros)
        if self.side is not None:
            found |= {e[2] for e in self.fibre.events if e[:2] == ("side", self.side)}
        return sorted(found)

    def ball(self, bits: int) -> arb:
        if self.side is not None:
            with precision(bits):
                return arb(self.fibre.column.cells[0].end(self.side))
        return next(iter(self.zeros.values())).ball(bits)


class Column:
    """A chart of u, [lo, hi] of u or of 1/u: its curves, critical values, fibres and the slabs between them."""

    def __init__(self, sweep: PlaneSweep, reversed_u: bool, lo: fmpq, hi: fmpq) -> None:
        self.reversed, self.lo, self.hi, self.cells = reversed_u, lo, hi, sweep.cells
        self.rows: list[list[Rows]] = []  # [curve][cell]
        self.affine: list[Rows] = []
        for curve in sweep.curves:
            self.add(curve)
        self.number = len(self.affine)
        criticals = sweep.criticals(reversed_u, lo, hi)
        self.samples = [_sample(x, y) for (x, _), (y, _) in zip(criticals, criticals[1:], strict=False)]
        self.alphas = [alpha for alpha, _ in criticals]
        self.fibres = [sweep.fibre(self, alpha, events) for alpha, events in criticals]
        self.branches = [
            [[_branches(self.rows[i][k], m, cell) for i in range(self.number)] for k, cell in enumerate(self.cells)]
            for m in self.samples
        ]

    def add(self, curve: fmpz_mpoly) -> None:
        """Another curve: one of the sweep, or a clip polynomial for a line u = const."""
        affine, degree = rows(curve), int(curve.degrees()[0])
        self.affine.append(chart(affine, self.reversed, False, degree))
        self.rows.append([chart(affine, self.reversed, cell.reversed, degree) for cell in self.cells])

    def slab(self, x: fmpq) -> tuple[int, bool]:
        """Index of the slab that holds x, and whether x is its left end instead."""
        low, high = 0, len(self.alphas) - 1
        while high - low > 1:
            middle = (low + high) // 2
            if self.alphas[middle].compare(x) <= 0:
                low = middle
            else:
                high = middle
        return low, self.alphas[low].compare(x) == 0


def _branches(a: Rows, m: fmpq, cell: ZeroCell) -> tuple[fmpz_poly, list[tuple[fmpq, fmpq]]]:
    f = over(a, m)
    return f, isolate(f, cell.lo, cell.hi) if f.degree() > 0 else []


class Fibre:
    """All that happens over one critical value."""

    def __init__(self, sweep: PlaneSweep, column: Column, alpha: AlgebraicRoot, events: Events) -> None:
        self.column, self.alpha, self.events = column, alpha, events
        self.lines = [e[1] for e in events if e[0] == "line"]
        self.complete = bool(self.lines) or ("all",) in events
        self.sides: list[GraphPoint | None] = [None, None]
        self.inside: list[list[GraphPoint]] = [[] for _ in column.cells]
        self.of_zero: dict[FibreZero, GraphPoint] = {}
        self.curves: dict[int, CurveFibre] = {}
        if self.lines and sweep.clips:
            self._with_clips(sweep)
        events = self.events
        for event in events:
            if event[0] == "side" or event[0] == "mark":
                self.mark(event[1])
        involved = {e[1] for e in events if e[0] in ("fold", "cross", "extra")}
        involved |= {e[2] for e in events if e[0] == "cross"}
        everything = range(len(column.affine) if self.lines else column.number)
        for i in sorted(everything if self.complete else involved):
            sides = (("side", 0, i) in events, ("side", 1, i) in events)
            order = events.get(("fold", i), 0)
            self.curves[i] = CurveFibre(column.affine[i], alpha, order, column.cells, sides)
            for zero in self.curves[i].zeros:
                if zero.side is not None or (zero.cell is not None and (self.complete or zero.multiplicity > 1)):
                    self._node(i, zero)
        for event, order in events.items():
            if event[0] == "cross":
                self._cross(event[1], event[2], order)
            elif event[0] == "extra":
                self._meet(event[1], sweep.extra_rows(event[2], column.reversed))
        if self.lines:
            self.mark(0)
            self.mark(1)

    def mark(self, side: int) -> GraphPoint:
        """The node on the line, made on first use."""
        point = self.sides[side]
        if point is None:
            point = self.sides[side] = GraphPoint(self, None, side)
        return point

    def _node(self, i: int, zero: FibreZero) -> None:
        if zero in self.of_zero:
            return
        if zero.side is not None:
            point = self.mark(zero.side)
        else:
            assert zero.cell is not None
            point = GraphPoint(self, zero.cell, None)
            self.inside[zero.cell].append(point)
        point.zeros[i] = zero
        self.of_zero[zero] = point

    def _cross(self, i: int, j: int, order: int) -> None:
        """Join the nodes of common zeros of two curves."""
        first = self.curves[i].shared(self.column.affine[j], order)
        second = self.curves[j].shared(self.column.affine[i], order)
        for x, y in zip(first, second, strict=True):
            if x.side is None and x.cell is None:
                continue
            self._node(i, x)
            self._node(j, y)
            kept, other = self.of_zero[x], self.of_zero[y]
            if kept is not other:
                for k, zero in other.zeros.items():
                    kept.zeros[k] = zero
                    self.of_zero[zero] = kept
                assert other.cell is not None
                self.inside[other.cell].remove(other)

    def _meet(self, i: int, clip: Rows) -> None:
        """Nodes wherever balls do not exclude that the clip polynomial vanishes: at every common zero."""
        with precision(2 * FIRST):
            for zero in self.curves[i].zeros:
                if zero.cell is None:
                    continue
                a = clip[::-1] if self.column.cells[zero.cell].reversed else clip
                y, x = zero.ball(2 * FIRST), self.alpha.enclosure(2 * FIRST)
                total = arb(0)
                for c in reversed(a):
                    total = total * y + c(x)
                if total.contains(0):
                    self._node(i, zero)

    def _with_clips(self, sweep: PlaneSweep) -> None:
        """On a line u = const the clip polynomials are curves like the others: add them with their events."""
        column, n, minimal = self.column, self.column.number, self.alpha.polynomial
        if len(column.affine) == n:
            for clip in sweep.clips:
                column.add(clip)
        curves = [*sweep.curves, *sweep.clips]
        self.events = dict(self.events)
        for i in range(n, len(curves)):
            degrees = [tuple(map(int, c.degrees())) for c in curves]
            formal = degrees[i][0] * max(0, 2 * degrees[i][1] - 2)
            found: list[tuple[Event, fmpz_poly, int]] = [(("fold", i), discriminant(curves[i]), formal)]
            for j in range(i):
                formal = degrees[i][0] * degrees[j][1] + degrees[j][0] * degrees[i][1]
                found.append((("cross", j, i), resultant(curves[j], curves[i]), formal))
            for side in (0, 1):
                side_polynomial = level(rows(curves[i]), column.cells[0].end(side))
                found.append((("side", side, i), side_polynomial, degrees[i][0]))
            for event, p, formal in found:
                if p.is_zero():
                    self.events[event] = 1  # the clip polynomial is the line v = const of this side
                    continue
                q, order = reversed_polynomial(p, formal) if column.reversed else p, 0
                while self.alpha.sign_of(q) == 0:
                    q, order = q // minimal, order + 1
                if order:
                    self.events[event] = order

    def above(self, cell: int) -> list[GraphPoint]:
        """The nodes in the open cell, ascending."""
        points, bits = self.inside[cell], FIRST
        while bits <= LAST:
            pairs = sorted(((p.ball(bits), p) for p in points), key=lambda pair: float(pair[0].mid()))
            if all(x < y for (x, _), (y, _) in zip(pairs, pairs[1:], strict=False)):
                return [p for _, p in pairs]
            bits *= 2
        raise PrecisionExhausted(f"nodes over {self.alpha}")

    def attach(self, column: Column, slab: int, cell: int, i: int) -> list[GraphPoint | int]:
        """Where the branches of curve i in the cell, ascending, end over this fibre, an end of the slab.

        `column` need not be that of the fibre: they share the fibres u = 1 and u = -1.
        """
        number = len(column.branches[slab][cell][i][1])
        slots: list[Slot] = []
        curve = self.curves.get(i)
        for side in (0, 1):
            if side and curve is not None:
                for k, zero in enumerate(curve.inside(cell)):
                    slots.append((self.of_zero.get(zero, k), 1 if zero.multiplicity == 1 else None))
            elif side:
                slots.append((-1, None))
            point = self.sides[side]
            if point is not None and ("side", side, i) in self.events:
                meets = curve.on_side(side) if curve is not None else None
                simple = meets is None or meets.multiplicity == 1
                slots.append((point, self._enters(column, slab, cell, i, side) if simple else None))
        unknown = [k for k, (_, count) in enumerate(slots) if count is None]
        rest = number - sum(count for _, count in slots if count is not None)
        counts = [rest]
        if len(unknown) > 1:
            counts = self._separated(column, slab, cell, i, slots, unknown)
        if min(counts) < 0 or (unknown and sum(counts) != rest) or (not unknown and rest):
            raise AssertionError(f"branches do not add up over {self.alpha}")
        found: list[GraphPoint | int] = []
        for k, (target, count) in enumerate(slots):
            taken = counts[unknown.index(k)] if count is None else count
            found += range(taken) if target == -1 else [target] * taken
        return found

    def _enters(self, column: Column, slab: int, cell: int, i: int, side: int) -> int:
        """1 if the branch through the simple zero on the line lies inside the cell beside the fibre, else 0.

        There f(m, c) has the sign of f_v (c - v), for the branch v; f(u, c) has no root between m and the fibre.
        """
        a, line = column.rows[i][cell], column.cells[cell].end(side)
        before = level(a, line)(column.samples[slab])
        rising = self.alpha.sign_of(level(slope(a), line))
        above = rising * (1 if before > 0 else -1) < 0
        return int(above != bool(side))

    def _separated(
        self, column: Column, slab: int, cell: int, i: int, slots: list[Slot], unknown: list[int]
    ) -> list[int]:
        """How many branches each multiple zero takes: lines between them that meet no branch near the fibre tell."""
        a, ends = column.rows[i][cell], column.cells[cell]
        lines = self._between(i, cell, slots, unknown)
        near, alpha = column.samples[slab], self.alpha
        crossings = [level(a, j) for j in lines]
        bits = FIRST
        while True:
            lo, hi = bounds(alpha.enclosure(bits))
            left, right = (near, hi) if near < lo else (lo, near)
            if all(root_free(p, left, right) for p in crossings):
                break
            # halfway to the fibre, and its enclosure shrinks faster
            far, close = (3 * near + lo) / 4, (near + lo) / 2
            near, bits = simple_between(min(far, close), max(far, close)), bits + 2
            if bits > LAST:
                raise PrecisionExhausted(f"branches over {alpha}")
        f = over(a, near)
        below = [len(isolate(f, ends.lo, j)) for j in [*lines, ends.hi]]
        counts: list[int] = []
        for total, last in zip(below, [*unknown[1:], len(slots)], strict=True):
            known = sum(count for _, count in slots[:last] if count is not None)
            counts.append(total - known - sum(counts))
        return counts

    def _between(self, i: int, cell: int, slots: list[Slot], unknown: list[int]) -> list[fmpq]:
        """Rational v just below the second, third ... multiple zero, no zero of the curve in between."""
        zeros, ends = self.curves[i].inside(cell), self.column.cells[cell]
        bits = FIRST
        while bits <= LAST:
            balls = [bounds(z.ball(bits)) for z in zeros]
            if slots[0][0] is self.sides[0]:
                balls.insert(0, (ends.lo, ends.lo))
            if slots[-1][0] is self.sides[1]:
                balls.append((ends.hi, ends.hi))
            if all(x[1] < y[0] for x, y in zip(balls, balls[1:], strict=False)):
                return [simple_between(balls[k - 1][1], balls[k][0]) for k in unknown[1:]]
            bits *= 2
        raise PrecisionExhausted(f"zeros over {self.alpha}")


def bounds(x: arb) -> tuple[fmpq, fmpq]:
    """Rational ends of an interval around the ball."""
    with precision(x.bits() + 64):
        return dyadic(x.lower()), dyadic(x.upper())


def _sample(x: AlgebraicRoot, y: AlgebraicRoot) -> fmpq:
    """A rational number strictly between, with few bits and away from both."""
    bits = 16
    while bits <= LAST:
        lo, hi = bounds(x.enclosure(bits))[1], bounds(y.enclosure(bits))[0]
        if lo < hi:
            return simple_between((3 * lo + hi) / 4, (lo + 3 * hi) / 4)
        bits *= 2
    raise PrecisionExhausted(f"critical values {x} and {y}")


def _compared(x: tuple[AlgebraicRoot, Events], y: tuple[AlgebraicRoot, Events]) -> int:
    return x[0].compare(y[0])


class PlaneSweep:
    """The input: curves without factors in u alone, lines, clip polynomials, charts; and the critical values of u."""

    def __init__(
        self, curves: Sequence[fmpz_mpoly], u: Range, v: Range, extras: Sequence[fmpz_mpoly | fmpz_poly]
    ) -> None:
        self.u, self.v = u, v
        whole = (fmpq(-1), fmpq(1))
        self.cells = [ZeroCell(False, *v)] if v else [ZeroCell(False, *whole), ZeroCell(True, *whole)]
        self.curves: list[fmpz_mpoly] = []
        self.vertical: list[fmpz_poly] = []
        self.on_side: dict[int, fmpz_poly] = {}
        for f in curves:
            self._take(f)
        self.extras = [c for c in extras if not isinstance(c, fmpz_poly)]
        self.clips = self._clips() if self.vertical else []
        self._extra_rows = [rows(c) for c in self.extras]
        self._pool: dict[tuple[Any, ...], tuple[fmpz_poly, Events]] = {}
        self._infinite: Events = {}
        self._collect([c for c in extras if isinstance(c, fmpz_poly)])
        self._shared_fibres: dict[tuple[Any, Any], Fibre] = {}
        ends = [(False, *(u or whole))] + ([] if u else [(True, *whole)])
        self.columns = [Column(self, *end) for end in ends]

    def _take(self, f: fmpz_mpoly) -> None:
        """Sort the irreducible factors of f by kind; each is taken once."""
        found = factors(f)
        self.vertical += [p for p, _ in found.in_u if p not in self.vertical]
        for q, _ in found.in_v:
            ends = [side for side in (0, 1) if q.degree() == 1 and q(self.cells[0].end(side)) == 0]
            if ends:
                self.on_side[ends[0]] = q
            elif in_v(q) not in self.curves:
                self.curves.append(in_v(q))
        self.curves += [g for g, _ in found.curves if g not in self.curves and -g not in self.curves]

    def _clips(self) -> list[fmpz_mpoly]:
        found: list[fmpz_mpoly] = []
        for c in self.extras:
            parts = factors(c)
            for g in [in_v(q) for q, _ in parts.in_v] + [g for g, _ in parts.curves]:
                if all(g != f and -g != f for f in [*self.curves, *found]):
                    found.append(g)
        return found

    def _collect(self, marked: list[fmpz_poly]) -> None:
        """All polynomials in u whose roots are critical, by irreducible factors."""
        degrees = [tuple(map(int, f.degrees())) for f in self.curves]
        for i, (f, (n, m)) in enumerate(zip(self.curves, degrees, strict=True)):
            self._add(discriminant(f), n * max(0, 2 * m - 2), ("fold", i))
            for j in range(i):
                other_n, other_m = degrees[j]
                self._add(resultant(self.curves[j], f), n * other_m + other_n * m, ("cross", j, i))
            for e, c in enumerate(self.extras):
                other_n, other_m = map(int, c.degrees())
                if other_m == 0:
                    continue
                common = resultant(f, c)
                if not common.is_zero():  # otherwise f divides c
                    self._add(common, n * other_m + other_n * m, ("extra", i, e))
            for side in (0, 1):
                self._add(restrict(f, "v", self.cells[0].end(side)), n, ("side", side, i))
        for c in self.extras:
            if c.degrees()[1] == 0:
                marked.append(fmpz_poly(rows(c)[0].coeffs()))
        for p in marked:
            self._add(p, p.degree(), ("all",))
        for index, p in enumerate(self.vertical):
            self._add(p, p.degree(), ("line", index))
        for side in self.on_side:
            for c in self.extras:
                p = restrict(c, "v", self.cells[0].end(side))
                if not p.is_zero():
                    self._add(p, int(c.degrees()[0]), ("mark", side))

    def _add(self, p: fmpz_poly, degree: int, event: Event) -> None:
        """degree: that of p as a form; what p lacks of it are roots at infinity."""
        if p.degree() < degree:
            self._infinite[event] = degree - p.degree()
        if p.degree() < 1:
            return
        for factor, order in p.factor()[1]:
            _, events = self._pool.setdefault(tuple(factor.coeffs()), (factor, {}))
            events[event] = max(order, events.get(event, 0))

    def criticals(self, reversed_u: bool, lo: fmpq, hi: fmpq) -> list[tuple[AlgebraicRoot, Events]]:
        """The critical values of the chart in [lo, hi], ascending, both ends included."""
        rational: dict[tuple[Any, Any], Events] = defaultdict(dict)
        rational[lo.p, lo.q], rational[hi.p, hi.q] = {("all",): 1}, {("all",): 1}
        found: list[tuple[AlgebraicRoot, Events]] = []
        if reversed_u and self._infinite:
            rational[fmpq(0).p, fmpq(0).q].update(self._infinite)
        for p, events in self._pool.values():
            if reversed_u:
                if p == _X:
                    continue
                p = reversed_polynomial(p, p.degree())
                p = p if p.leading_coefficient() > 0 else -p
            if p.degree() == 1:
                value = fmpq(-p[0], p[1])
                if lo <= value <= hi:
                    rational[value.p, value.q].update(events)
            else:
                found += [(AlgebraicRoot(p, *ends), events) for ends in isolate(p, lo, hi)]
        found += [(AlgebraicRoot.of(fmpq(p, q)), events) for (p, q), events in rational.items()]
        return sorted(found, key=cmp_to_key(_compared))

    def fibre(self, column: Column, alpha: AlgebraicRoot, events: Events) -> Fibre:
        """The fibre; that of u = 1, u = -1 is one for both charts."""
        value = alpha.rational
        ends = value is not None and (value == column.lo or value == column.hi)
        key = (value.p, value.q) if value is not None else None
        if ends and self.u is None and key in self._shared_fibres:
            return self._shared_fibres[key]
        fibre = Fibre(self, column, alpha, events)
        if ends or fibre.lines:
            for side in self.on_side:
                fibre.mark(side)
        if ends and key is not None:
            self._shared_fibres[key] = fibre
        return fibre

    def extra_rows(self, e: int, reversed_u: bool) -> Rows:
        return chart(self._extra_rows[e], reversed_u, False, int(self.extras[e].degrees()[0]))

    def through(self, point: GraphPoint) -> tuple[int, ...]:
        """The curves and lines through a point: first the swept curves, then the lines u = const, then the border."""
        found = [i for i in point.curves() if i < len(self.curves)]
        found += [len(self.curves) + line for line in point.fibre.lines]
        if point.side in self.on_side:
            found.append(len(self.curves) + len(self.vertical) + list(self.on_side).index(point.side))
        return tuple(found)

    def fibres(self) -> Iterator[Fibre]:
        """Every fibre once, by charts."""
        seen: set[int] = set()
        for column in self.columns:
            for fibre in column.fibres:
                if id(fibre) not in seen:
                    seen.add(id(fibre))
                    yield fibre
