"""Certified topology of a plane curve f(u, v) = 0: a graph of nodes and u-monotone edges, in a box or on P1 x P1.

    graph = topology(f, u=(a, b), v=(c, d), extras=[clip, ...])      # u=None, v=None: the projective line
    graph.nodes, graph.edges, graph.components, graph.curves

Everything told is proved: which nodes there are, which edges join them, closed loops, isolated points.  A projective
line is covered by two charts, [-1, 1] for the coordinate and [-1, 1] for its reciprocal; nodes and edges say in which
chart they are given (`chart` = whether u, whether v is reversed there), x and y are the coordinates of the chart.

An extra polynomial c cuts the curve at its zeros, so its sign is constant on every open edge: edge.sign(c).  (On an
edge through infinity, one of odd degree changes its sign there nevertheless; conditions that mean something on the
projective line, such as the sign of a product of even degree, do not.)  Where c is nearly zero on the fibre of a
common zero a harmless regular node may be added.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from flint import arb, fmpq, fmpz_mpoly, fmpz_poly

from firstcontact.exact.curves.curve_sweep import Column, GraphPoint, PlaneSweep, Range, bounds
from firstcontact.exact.curves.fibres import FIRST, LAST, PrecisionExhausted, simple_between
from firstcontact.exact.fields.roots import AlgebraicRoot, isolate, reversed_polynomial
from firstcontact.exact.numbers import precision, sign
from firstcontact.exact.polynomials.bivariate import (
    Rows,
    evaluate,
    from_rows,
    in_u,
    in_v,
    level,
    over,
    restrict,
    resultant,
    rows,
)

if TYPE_CHECKING:
    from firstcontact.exact.curves.curve_sweep import Fibre

Chart = tuple[bool, bool]


class Node:
    """A point of the curve where branches meet, turn back, end or are cut; or an isolated point of it.

    edges: indices of the edges that end here.  curves: indices, in the graph, of those through it.
    left, right: how many of the edges (no line u = const) come from smaller and from larger u, of the chart at the
    fibres inside one and of u itself at u = 1, -1.
    kind: "isolated" (no edge), "boundary" (on the border of the box), "extreme" (smooth, u is extreme), "cusp" (two
    branches at a singular point), "regular" (nothing special: a cut), "node" (all others: crossings, contacts).
    """

    def __init__(self, point: GraphPoint, index: int, border: bool, curves: tuple[int, ...]) -> None:
        self._point, self.index, self._border, self.curves = point, index, border, curves
        self.edges: tuple[int, ...] = ()
        self._kind: str | None = None

    @property
    def chart(self) -> Chart:
        column = self._point.fibre.column
        return column.reversed, self._point.cell is not None and column.cells[self._point.cell].reversed

    @property
    def left(self) -> int:
        return self._point.left

    @property
    def right(self) -> int:
        return self._point.right

    @property
    def x(self) -> AlgebraicRoot:
        """u or 1/u, as the chart has it."""
        return self._point.fibre.alpha

    @property
    def y(self) -> AlgebraicRoot:
        """v or 1/v, as the chart has it: computed on first use, where u is irrational by an elimination."""
        if self._point.side is not None:
            return AlgebraicRoot.of(self._point.fibre.column.cells[0].end(self._point.side))
        return next(iter(self._point.zeros.values())).exact()

    @property
    def u(self) -> AlgebraicRoot | None:
        """Exactly; None for infinity."""
        return reciprocal(self.x) if self.chart[0] else self.x

    @property
    def v(self) -> AlgebraicRoot | None:
        """Exactly; None for infinity."""
        return reciprocal(self.y) if self.chart[1] else self.y

    def x_ball(self, bits: int) -> arb:
        return self.x.enclosure(bits)

    def y_ball(self, bits: int) -> arb:
        """To 2^-bits, relative to the larger of 1 and the size: quick, no elimination."""
        return self._point.ball(bits)

    @property
    def kind(self) -> str:
        if self._kind is None:
            self._kind = self._classified()
        return self._kind

    def _classified(self) -> str:
        if not self.edges:
            return "isolated"
        if self._border:
            return "boundary"
        if len(self.edges) != 2 or len(self.curves) > 1:
            return "node"
        for zero in self._point.zeros.values():
            curve = zero.fibre
            if zero.multiplicity > 1 and curve.order != 1 and self._sign_of([p.derivative() for p in curve.rows]) == 0:
                return "cusp"
        return "regular" if self.left == self.right else "extreme"  # also on a line u = const: 0 and 0

    def sign(self, c: fmpz_mpoly) -> int:
        """The sign of c here, exactly; where u or v is infinite, that of c in the chart: of c u^-k, c v^-l."""
        if c.is_zero():
            return 0
        degree_u, degree_v = map(int, c.degrees())
        found = self._sign_of([reversed_polynomial(p, degree_u) if self.chart[0] else p for p in rows(c)])
        if found and self.chart[0] and degree_u % 2:
            found *= self.x.sign_of(fmpz_poly([0, 1])) or 1
        if found and self.chart[1] and degree_v % 2 and self._point.ball(FIRST) < 0:
            found = -found  # a ball that holds 0 is 0: see Zero.value
        return found

    def _sign_of(self, affine: Rows) -> int:
        """The sign of a polynomial of the chart of u; for v, its rows are reversed here."""
        point, x, a = self._point, self.x, affine[::-1] if self.chart[1] else affine
        if x.rational is not None:
            return self.y.sign_of(over(a, x.rational))
        if point.side is not None:
            return x.sign_of(level(a, point.fibre.column.cells[0].end(point.side)))
        bits, decided = 2 * FIRST, False
        while bits <= LAST:
            x_ball, y_ball = x.enclosure(bits), self.y_ball(bits)
            with precision(bits + 32):
                value = evaluate(a, x_ball, y_ball)
            if not value.contains(0):
                return 1 if value > 0 else -1
            if not decided and self._vanishes(affine):
                return 0
            decided, bits = True, 2 * bits
        raise PrecisionExhausted(f"a sign at {self}")

    def _vanishes(self, affine: Rows) -> bool:
        """Whether the polynomial is zero here, u irrational: by its zeros common with a curve through this point."""
        while affine and affine[-1].is_zero():
            affine = affine[:-1]
        zero = next(iter(self._point.zeros.values()))
        norm, order = resultant(from_rows(zero.fibre.rows), from_rows(affine)) if affine else fmpz_poly([]), 0
        if norm.is_zero():
            return True  # the curve is irreducible: it divides the polynomial
        while order < 2 and self.x.sign_of(norm) == 0:
            norm, order = norm // self.x.polynomial, order + 1
        return zero in zero.fibre.shared(affine, order)

    def __repr__(self) -> str:
        names = [f"1/{n}" if r else n for n, r in zip("uv", self.chart, strict=True)]
        place = f"{names[0]}={float(self.x):.9g}, {names[1]}={float(self.y_ball(FIRST).mid()):.9g}"
        return f"Node({self.index}, {place}, {self.kind}, edges {list(self.edges)})"


class PlaneEdge:
    """An open arc of one curve, monotone in x of its chart from node `start` to node `end`, and in one cell of y.

    curve: index in graph.curves.  vertical: a piece of a line u = const instead, y ascending from start to end.
    """

    def __init__(self, index: int, curve: int, column: Column, cell: int, start: GraphPoint, end: GraphPoint) -> None:
        self.index, self.curve, self._column, self._cell = index, curve, column, cell
        self._start, self._end = start, end

    vertical = False

    @property
    def start(self) -> int:
        return self._start.index

    @property
    def end(self) -> int:
        return self._end.index

    @property
    def chart(self) -> Chart:
        return self._column.reversed, self._column.cells[self._cell].reversed

    @property
    def sample(self) -> tuple[Any, Any]:
        """(u, v) of a point of the open edge, both finite: fmpq and AlgebraicRoot (on a vertical edge: root, fmpq)."""
        raise NotImplementedError

    def sign(self, c: fmpz_mpoly) -> int:
        """Exact sign of c at the sample; on the whole edge if c was among the extras."""
        u, v = self.sample
        if isinstance(u, fmpq):
            return int(v.sign_of(restrict(c, "u", u)))
        return int(u.sign_of(restrict(c, "v", v)))

    def __repr__(self) -> str:
        ends = f"{self.start} -> {self.end}"
        return f"{type(self).__name__}({self.index}, curve {self.curve}, {ends}, chart {self.chart})"


class RootEdge(PlaneEdge):
    """An edge that is a graph over an open interval of x: pieces over slabs, each the k-th root there."""

    def __init__(
        self,
        *place: *tuple[int, int, Column, int, GraphPoint, GraphPoint],
        pieces: list[tuple[int, int]],
        passed: list[int],
    ) -> None:
        super().__init__(*place)
        self._pieces, self._passed = pieces, passed
        self._sample: tuple[fmpq, AlgebraicRoot] | None = None

    @property
    def slabs(self) -> list[tuple[fmpq, int]]:
        """For each slab the edge crosses, ascending: a rational x inside, and the index of the root y there.

        The roots are those of the curve over x in the open cell, ascending; the index is the same over all the slab.
        """
        return [(self._column.samples[s], k) for s, k in self._pieces]

    @property
    def numbers(self) -> list[int]:
        """How many roots the curve has in the open cell over every slab the edge crosses."""
        return [len(self._column.branches[s][self._cell][self.curve][1]) for s, _ in self._pieces]

    @property
    def slope_sign(self) -> int:
        """The sign of f_y, f the curve in the chart, all along the edge."""
        s, k = self._pieces[0]
        f, roots = self._column.branches[s][self._cell][self.curve]
        return _irreducible(f, *roots[k]).sign_of(f.derivative())

    @property
    def limits(self) -> list[AlgebraicRoot]:
        """The ends of the slabs, ascending in x: one more than `slabs`."""
        first = self._pieces[0][0]
        return self._column.alphas[first : first + len(self._pieces) + 1]

    def between(self, share: fmpq) -> fmpq:
        """A rational x inside, at about this share of the way from start to end."""
        bits = FIRST
        while bits <= LAST:
            (start, lo), (hi, end) = (bounds(self.limits[k].enclosure(bits)) for k in (0, -1))
            if end - start < (1 + fmpq(1, 2**FIRST)) * (hi - lo):
                return lo + (hi - lo) * share
            bits *= 2
        raise PrecisionExhausted(f"the ends of {self}")

    def at(self, x: fmpq) -> AlgebraicRoot:
        """y over x, a rational number strictly between the ends of the edge."""
        if not self.limits[0].compare(x) < 0 < self.limits[-1].compare(x):
            raise ValueError(f"{x} is not inside the x-range of {self}")
        s, on_limit = self._column.slab(x)
        first = self._pieces[0][0]
        a, cell = self._column.rows[self.curve][self._cell], self._column.cells[self._cell]
        f = over(a, x)
        k = self._passed[s - first - 1] if on_limit else self._pieces[s - first][1]
        if on_limit:
            f = f // f.gcd(f.derivative())
        return _irreducible(f, *isolate(f, cell.lo, cell.hi)[k])

    @property
    def sample(self) -> tuple[fmpq, AlgebraicRoot]:
        if self._sample is None:
            self._sample = self._finite_sample()
        return self._sample

    def _finite_sample(self) -> tuple[fmpq, AlgebraicRoot]:
        s, k = self._pieces[len(self._pieces) // 2]
        x, (f, roots) = self._column.samples[s], self._column.branches[s][self._cell][self.curve]
        y = _irreducible(f, *roots[k])
        while (x == 0 and self.chart[0]) or (y.rational == 0 and self.chart[1]):
            # at infinity: step aside, inside the slab
            x = simple_between(x, _below(self._column.alphas[s + 1], x))
            y = self.at(x)
        v = reciprocal(y) if self.chart[1] else y
        assert v is not None
        return 1 / x if self.chart[0] else x, v


class Level(PlaneEdge):
    """A piece of the border line v = const of the cells that belongs to the curve."""

    def __init__(self, *place: *tuple[int, int, Column, int, GraphPoint, GraphPoint], slab: int, y: fmpq) -> None:
        super().__init__(*place)
        self._slab, self._y = slab, y

    def at(self, x: fmpq) -> AlgebraicRoot:
        return AlgebraicRoot.of(self._y)

    @property
    def sample(self) -> tuple[fmpq, AlgebraicRoot]:
        x = self._column.samples[self._slab]
        if self.chart[0]:
            x = 1 / (x if x else simple_between(x, _below(self._column.alphas[self._slab + 1], x)))
        return x, AlgebraicRoot.of(self._y)


class Vertical(PlaneEdge):
    """A piece of a line u = const."""

    vertical = True

    @property
    def sample(self) -> tuple[AlgebraicRoot, fmpq]:
        cell, bits = self._column.cells[self._cell], FIRST
        while bits <= LAST:
            lo = cell.lo if self._start.side is not None else bounds(self._start.ball(bits))[1]
            hi = cell.hi if self._end.side is not None else bounds(self._end.ball(bits))[0]
            if lo < hi:
                y = simple_between(lo, hi)
                if y == 0 and cell.reversed:
                    y = simple_between(y, hi)
                x = self._start.fibre.alpha
                u = reciprocal(x) if self._start.fibre.column.reversed else x
                assert u is not None  # lines are affine
                return u, 1 / y if cell.reversed else y
            bits *= 2
        raise PrecisionExhausted(f"a point of {self}")


class Component(NamedTuple):
    """A connected piece of the curve: indices of its nodes and edges.

    kind: "point"; "loop", one simple closed curve; "arc", simple with two ends; "branched", anything else.
    """

    nodes: tuple[int, ...]
    edges: tuple[int, ...]
    kind: str


class Graph(NamedTuple):
    """The curve: see `topology`.  curves: the irreducible factors that edges point to."""

    curves: tuple[fmpz_mpoly, ...]
    nodes: tuple[Node, ...]
    edges: tuple[PlaneEdge, ...]
    components: tuple[Component, ...]


def topology(
    f: fmpz_mpoly | Sequence[fmpz_mpoly],
    u: Range = None,
    v: Range = None,
    extras: Sequence[fmpz_mpoly | fmpz_poly] = (),
) -> Graph:
    """The graph of all real zeros of f, or of several polynomials together, in a closed box or on projective lines.

    f is not zero; only its irreducible factors count, not their multiplicities.  u, v: rational ends, or None for the
    whole projective line.  extras: polynomials in u and v, or in u alone as fmpz_poly, at whose zeros to cut.
    """
    for bounds_ in (u, v):
        if bounds_ is not None and not bounds_[0] < bounds_[1]:
            raise ValueError(f"the range {bounds_} is empty or a point")
    sweep = PlaneSweep([f] if isinstance(f, fmpz_mpoly) else list(f), u, v, extras)
    edges: list[PlaneEdge] = []
    for column in sweep.columns:
        for cell in range(len(column.cells)):
            for i in range(column.number):
                _add_branches(edges, column, cell, i)
        for side in sweep.on_side:
            _add_levels(edges, sweep, column, side)
    for fibre in sweep.fibres():
        _add_verticals(edges, sweep, fibre)
    return _assembled(sweep, edges)


def _add_branches(edges: list[PlaneEdge], column: Column, cell: int, i: int) -> None:
    """Chains of branches of one curve through the slabs, from node to node."""
    last = len(column.samples) - 1
    starts = [column.fibres[s].attach(column, s, cell, i) for s in range(last + 1)]
    ends = [column.fibres[s + 1].attach(column, s, cell, i) for s in range(last + 1)]
    for s, targets in enumerate(starts):
        for k, start in enumerate(targets):
            if isinstance(start, int):
                continue
            pieces, passed, at = [(s, k)], [], s
            while isinstance(end := ends[at][pieces[-1][1]], int):
                passed.append(end)
                at += 1
                pieces.append((at, starts[at].index(end)))
            edges.append(RootEdge(len(edges), i, column, cell, start, end, pieces=pieces, passed=passed))
            mirrored = column.reversed and not start.fibre.column.reversed
            start.left, start.right = start.left + mirrored, start.right + (not mirrored)
            mirrored = column.reversed and not end.fibre.column.reversed
            end.left, end.right = end.left + (not mirrored), end.right + mirrored
    for s in range(last):
        if [p for p in ends[s] if isinstance(p, int)] != [p for p in starts[s + 1] if isinstance(p, int)]:
            raise AssertionError(f"branches change over {column.alphas[s + 1]}")


def _add_levels(edges: list[PlaneEdge], sweep: PlaneSweep, column: Column, side: int) -> None:
    index = len(sweep.curves) + len(sweep.vertical) + list(sweep.on_side).index(side)
    start, first = column.fibres[0].mark(side), 0
    for t in range(1, len(column.fibres)):
        end = column.fibres[t].sides[side]
        if end is not None:
            y = column.cells[0].end(side)
            edges.append(Level(len(edges), index, column, 0, start, end, slab=first, y=y))
            start.right, end.left = start.right + 1, end.left + 1
            start, first = end, t


def _add_verticals(edges: list[PlaneEdge], sweep: PlaneSweep, fibre: Fibre) -> None:
    for line in fibre.lines[:1]:
        index = len(sweep.curves) + line
        for cell in range(len(fibre.column.cells)):
            points = [fibre.mark(0), *fibre.above(cell), fibre.mark(1)]
            for start, end in zip(points, points[1:], strict=False):
                edges.append(Vertical(len(edges), index, fibre.column, cell, start, end))


def _assembled(sweep: PlaneSweep, edges: list[PlaneEdge]) -> Graph:
    """Number the nodes, hang the edges on them and collect the components."""
    nodes: list[Node] = []
    for fibre in sweep.fibres():
        column = fibre.column
        ends = sweep.u is not None and fibre.alpha.rational in (column.lo, column.hi)
        cells = [fibre.above(cell) for cell in range(len(column.cells))]
        for point in [*fibre.sides, *(p for points in cells for p in points)]:
            if point is not None:
                point.index = len(nodes)
                border = ends or (sweep.v is not None and point.side is not None)
                nodes.append(Node(point, point.index, border, sweep.through(point)))
    at: list[list[int]] = [[] for _ in nodes]
    for edge in edges:
        at[edge.start].append(edge.index)
        at[edge.end].append(edge.index)
    for node, incident in zip(nodes, at, strict=True):
        node.edges = tuple(incident)
    curves = [*sweep.curves, *(in_u(p) for p in sweep.vertical), *(in_v(q) for q in sweep.on_side.values())]
    return Graph(tuple(curves), tuple(nodes), tuple(edges), tuple(_components(nodes, edges)))


def _components(nodes: list[Node], edges: list[PlaneEdge]) -> list[Component]:
    seen = [False] * len(nodes)
    found = []
    for first in range(len(nodes)):
        if seen[first]:
            continue
        seen[first], waiting, members = True, [first], [first]
        while waiting:
            for e in nodes[waiting.pop()].edges:
                for other in (edges[e].start, edges[e].end):
                    if not seen[other]:
                        seen[other] = True
                        waiting.append(other)
                        members.append(other)
        own = sorted({e for n in members for e in nodes[n].edges})
        valences = sorted(len(nodes[n].edges) for n in members)
        if not own:
            kind = "point"
        elif valences[-1] > 2:
            kind = "branched"
        else:
            kind = "loop" if valences[0] == 2 else "arc"
        found.append(Component(tuple(sorted(members)), tuple(own), kind))
    return found


def reciprocal(x: AlgebraicRoot) -> AlgebraicRoot | None:
    """1/x; None for 1/0."""
    if x.rational is not None:
        return AlgebraicRoot.of(1 / x.rational) if x.rational != 0 else None
    lo, hi, bits = x.lo, x.hi, FIRST
    while lo <= 0 <= hi:
        near = bounds(x.enclosure(bits))
        lo, hi, bits = max(lo, near[0]), min(hi, near[1]), 2 * bits
    p = reversed_polynomial(x.polynomial, x.polynomial.degree())
    return AlgebraicRoot(p if p.leading_coefficient() > 0 else -p, 1 / hi, 1 / lo)


def _irreducible(f: fmpz_poly, lo: fmpq, hi: fmpq) -> AlgebraicRoot:
    """The one root of the squarefree f in the open interval, or lo == hi."""
    if lo == hi:
        return AlgebraicRoot.of(lo)
    for factor, _ in f.factor()[1]:
        if factor.degree() == 1:
            value = fmpq(-factor[0], factor[1])
            if lo < value < hi:
                return AlgebraicRoot.of(value)
        elif sign(factor(lo)) != sign(factor(hi)):
            return AlgebraicRoot(factor, lo, hi)
    raise AssertionError(f"no root of {f} in ({lo}, {hi})")


def _below(x: AlgebraicRoot, than: fmpq) -> fmpq:
    """A rational number at most x, above `than` < x."""
    bits = FIRST
    while (found := bounds(x.enclosure(bits))[0]) <= than:
        bits *= 2
    return found
