"""The curve of one ruled piece with the boundary of a solid of planes and quadrics, exactly.

In the parameters (u, r) of the piece every surface of the solid is a curve f(u, r) = X^T Q X = 0 (of planes N.X = 0),
of degree at most 2 in r.  All of them together have one certified graph; on an open edge of it the signs of all f are
known, and tell whether the edge is on the boundary.  A side r = 0 or r = 1, or a ruling, that is a point counts as one
node.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, reduce
from itertools import count
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np
from flint import arb, fmpq, fmpz, fmpz_mpoly

from firstcontact.body.ruled.rational_curve import is_point
from firstcontact.body.solid.carriers import Plane
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.csg import outcomes
from firstcontact.contact.signs.pieces import RulingPiece
from firstcontact.curves.exactly.answer import Parts, number
from firstcontact.curves.exactly.branches import Corner, Joints, add_branches
from firstcontact.curves.exactly.spots import Spot, doubles
from firstcontact.curves.exactly.tracing import Powers, rows
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.curves.plane_curves import topology
from firstcontact.exact.fields.roots import reversed_polynomial, roots_in
from firstcontact.exact.numbers import precision
from firstcontact.exact.polynomials import bivariate
from firstcontact.exact.polynomials.bivariate import V, from_rows, in_u, in_v
from firstcontact.result_curve import ExactParameters, SingularPoint

if TYPE_CHECKING:
    from fractions import Fraction
    from typing import Unpack

    from firstcontact.body.solid.carriers import Quadric
    from firstcontact.curves.exactly.spots import Box
    from firstcontact.curves.fields import CurveFields, Where
    from firstcontact.exact.curves.plane_curves import Graph, Node, PlaneEdge
    from firstcontact.result_curve import ExactPair

UNIT = fmpq(0), fmpq(1)
FLAT = 1e-9
"""Least singular value of unit normals below which surfaces of the solid count as touching each other."""


class _Sheet:
    """The piece as X(u, r) = first + r (second - first), W > 0, of one degree n in u; as `Joints` asks for places."""

    def __init__(self, piece: RulingPiece) -> None:
        p, q = piece.rulings.first, piece.rulings.second
        degrees = [max(c.degree() for c in side) for side in (p, q)]
        common = p[3].gcd(q[3])
        self.first, self.second = [c * (q[3] // common) for c in p], [c * (p[3] // common) for c in q]
        self.degree = sum(degrees) - common.degree()
        inner = fmpq(0) if piece.u is None else (piece.u[0] + piece.u[1]) / 2
        if self.first[3](inner) < 0:
            self.first, self.second = ([-c for c in side] for side in (self.first, self.second))
        turned = [[reversed_polynomial(c, self.degree) for c in side] for side in (self.first, self.second)]
        self.charts = {False: (self.first, self.second), True: (turned[0], turned[1])}
        self.tables: list[np.ndarray] = []
        self.tips = [k for k, side in enumerate((self.first, self.second)) if is_point(side)]
        """Sides that are points."""
        gap = reduce(lambda x, y: x.gcd(y), (b - a for a, b in zip(self.first[:3], self.second[:3], strict=True)))
        self.pinched = gap
        """Zero at the u of rulings that are points."""
        self.pinches = roots_in(gap, piece.u) if gap.degree() > 0 else []

    def tip(self, where: Any) -> int | None:
        """The number of what is one point and holds an edge or a node: a side, or from 2 on a ruling."""
        for k in self.tips:
            if where.sign(V - k) == 0:
                return k
        if not self.pinches or where.sign(in_u(self.pinched)) != 0:
            return None
        u = where.u if hasattr(where, "u") else where.sample[0]
        return next(2 + k for k, x in enumerate(self.pinches) if x.compare(u) == 0)

    def is_pinched(self, u: float) -> bool:
        """Whether a ruling is a point, to doubles."""
        return any(abs(float(x) - u) <= FLAT * (1.0 + abs(u)) for x in self.pinches)

    @property
    def point(self) -> list[fmpz_mpoly]:
        return [from_rows([a, b - a]) for a, b in zip(self.first, self.second, strict=True)]

    def form(self, surface: Plane | Quadric) -> fmpz_mpoly:
        """The form of a surface of the solid over the piece, negative where that is."""
        x = self.point
        if isinstance(surface, Plane):
            return _combined(surface.normal, x)
        products = [(surface.form[i][j], x[i] * x[j]) for i in range(4) for j in range(4)]
        return _combined([c for c, _ in products], [y for _, y in products])

    def full_degree(self, surface: Plane | Quadric) -> int:
        return self.degree if isinstance(surface, Plane) else 2 * self.degree

    def spot(self, chart: tuple[bool, bool], x: arb, y: arb, bits: int) -> Spot:
        first, second = self.charts[chart[0]]
        with precision(bits):
            point = tuple(a(x) * (1 - y) + b(x) * y for a, b in zip(first, second, strict=True))
            nowhere = arb(0), arb(0)
            return Spot(x, y, chart, point, (y, arb(1)), nowhere, 0, bits)

    def surfaces(self) -> _Sheet:
        self.tables = [rows([*self.first, *self.second])[k : k + 4] for k in (0, 4)]
        return self

    def points(self, u: Powers, v: Powers) -> tuple[np.ndarray, np.ndarray]:
        """As those of tracing.Surfaces."""
        powers = u.table(self.degree)
        a, b = (table @ powers[: table.shape[1]] for table in self.tables)
        point = a * (1 - v.x) + b * v.x
        return (point[:3] / point[3]).T, np.column_stack([v.x, np.full(len(v.x), np.nan)])

    def size(self) -> float:
        return float(max(np.abs(table).max() for table in self.tables))


class _Joints(Joints):
    """All nodes on a side that is a point are one; at nodes that `is_stop` names, every edge ends for itself."""

    def __init__(self, found: _SheetParts, graph: Graph, sheet: _Sheet, is_stop: Callable[[Node], bool]) -> None:
        super().__init__(found, graph, sheet)
        self.sheet, self.is_stop = sheet, cache(lambda index: is_stop(graph.nodes[index]))
        self.first: dict[int, int] = {}

    def corner(self, edge: PlaneEdge, at_end: int) -> Corner:
        known = super().corner(edge, at_end)
        index = known.key[0]
        tip = self.sheet.tip(self.graph.nodes[index])
        if tip is not None:
            known = replace(known, key=(self.first.setdefault(tip, index), 0))
        if self.is_stop(index):
            return replace(known, key=(index, 1 + 2 * edge.index + at_end))
        return known


def _combined(weights: Sequence[fmpq], values: Sequence[fmpz_mpoly]) -> fmpz_mpoly:
    """The sum of weighted values, times a positive number that makes it whole."""
    below = reduce(fmpz.lcm, (c.q for c in weights), fmpz(1))
    return sum(((c * below).p * x for c, x in zip(weights, values, strict=True)), values[0] - values[0])


class _SheetParts(Parts):
    """v: the range of the second parameter, which is the place r on the ruling; rulings are bounded, points finite."""

    v, finite = UNIT, True

    def __init__(self, piece: RulingPiece, clip: _Clip, tolerance: float, first: bool) -> None:
        super().__init__(tolerance)
        self.piece, self.clip, self.first = piece, clip, first

    def exact(self, where: Where) -> ExactParameters:
        def pair() -> ExactPair:
            u = self.piece.user_parameter(where.u)
            known = math.inf if u is None else number(u)
            return (known, None) if self.first else (None, known)

        return ExactParameters(pair)

    def parameters(self, x: np.ndarray, y: np.ndarray, chart: tuple[bool, bool], positions: np.ndarray) -> np.ndarray:
        """(n, 4): u, nan, s, nan, or the other way round where the solid comes first."""
        with np.errstate(divide="ignore"):
            u = 1.0 / x if chart[0] else x
            if self.piece.shift is not None:
                u = self.piece.shift + 1.0 / u
        columns = np.full((len(x), 4), np.nan)
        columns[:, 0 if self.first else 1] = u
        columns[:, 2 if self.first else 3] = self.piece.user_s(positions[:, 0])
        return columns


class _Clip:
    """Polynomials in u and r that are not negative on the piece and in the box, with their names.

    marks: polynomials whose zeros name an end besides.
    """

    def __init__(self, piece: RulingPiece, sheet: _Sheet, box: Box | None, names: str) -> None:
        self.piece, self.sheet, self.box, self.names = piece, sheet, box, names
        self.marks: list[tuple[str, fmpz_mpoly, int]] = []
        self.conditions: list[tuple[str, fmpz_mpoly, int]] = []
        for g in piece.trim:
            even = max(i for i, _ in g)
            f = bivariate.polynomial({(i, j): c for (i, j), c in g.items()})
            self.conditions.append(("trim", f, even + even % 2))
        if box is not None:
            x = sheet.point
            for axis, own, low, high in zip("xyz", x[:3], *box, strict=True):
                self.conditions.append((f"{axis}={low}", own * low.q - x[3] * low.p, sheet.degree))
                self.conditions.append((f"{axis}={high}", x[3] * high.p - own * high.q, sheet.degree))

    def keeps(self, where: Node | PlaneEdge) -> bool:
        """Of an edge or a node."""
        return all(sign_at(f, where) >= 0 for _, f, _ in self.conditions)

    def bounds_at(self, where: Spot) -> tuple[str, ...]:
        """The names of the bounds that hold with equality, as far as the bits of `where` show."""
        found = []
        with precision(where.bits):
            u = 1 / where.x if where.chart[0] else where.x
            if self.piece.shift is not None:
                u = self.piece.shift + 1 / u
            found += [f"{self.names[0]}={end}" for end in self.piece.u or () if (u - arb(end)).contains(0)]
            for end, bound in zip(UNIT, self.piece.s_range, strict=True):
                found += [f"{self.names[1]}={bound}"] if (where.y - arb(end)).contains(0) else []
            for name, f, degree in [*self.conditions, *self.marks]:
                a = [reversed_polynomial(c, degree) for c in bivariate.rows(f)] if where.chart[0] else bivariate.rows(f)
                if bivariate.evaluate(a, where.x, where.y).contains(0):
                    found.append(name)
        return tuple(found)


class Joining(TypedDict, total=False):
    """How a SheetCurve goes on beyond its piece."""

    knots: Sequence[fmpq | Fraction]
    joins: bool


class SheetCurve:
    """The part of the curves f(u, r) = 0 of some surfaces over a piece that `is_part` tells.

    drawn   how many of the surfaces, from the first on, have their curves drawn; the others only cut them
    knots   the ends of the range of u at which a neighbour of the piece goes on
    joins   whether branches go on outside this piece and these surfaces: they end for themselves at all places where
            they may, on knots and where a side is a point
    """

    def __init__(
        self,
        piece: RulingPiece,
        surfaces: Sequence[Plane | Quadric],
        drawn: int,
        tolerance: float,
        box: Box | None,
        first: bool,
        knots: Sequence[fmpq | Fraction] = (), joins: bool = False,
    ) -> None:  # fmt: skip
        self.knots, self.joins = [fmpq(x.numerator, x.denominator) for x in knots], joins
        for shift in count():
            self.piece = piece if shift == 0 or piece.u is not None else piece.away_from_infinity(shift - 1)
            self.sheet = _Sheet(self.piece)
            self.forms = [self.sheet.form(s) for s in surfaces]
            self.clip = _Clip(self.piece, self.sheet, box, "us" if first else "vt")
            if piece.u is not None or not self._special_at_infinity(surfaces):
                break
        self.drawn, self.cutting = self.forms[:drawn], self.forms[drawn:]
        self.found = _SheetParts(self.piece, self.clip, tolerance, first)

    def is_part(self, where: Node | PlaneEdge, joints: Joints) -> bool:
        """Of an open edge or a node."""
        raise NotImplementedError

    def is_stop(self, node: Node) -> bool:
        if not self.joins:
            return False
        u = node.u
        return self.sheet.tip(node) is not None or any(u is not None and u.compare(x) == 0 for x in self.knots)

    def run(self) -> CurveFields:
        """The fields of IntersectionCurve."""
        if any(f.is_zero() for f in self.drawn):
            self.lies_in_surface()
        else:
            self._curves()
        return self.found.collected()

    def lies_in_surface(self) -> None:
        """What to do where the piece lies in a surface that is drawn."""
        raise NotImplementedError

    def _special_at_infinity(self, surfaces: Sequence[Plane | Quadric]) -> bool:
        """Whether anything vanishes on the ruling u = infinity, where the graph does not look."""
        tested = [(f, self.sheet.full_degree(s)) for f, s in zip(self.forms, surfaces, strict=True)]
        tested += [(f, degree) for _, f, degree in self.clip.conditions]
        return any(not f.is_zero() and f.degrees()[0] < degree for f, degree in tested)

    def _curves(self) -> None:
        curves: dict[str, tuple[fmpz_mpoly, int]] = {}
        for f in self.drawn:
            for g, k in _factors(f):
                if str(g) not in curves or curves[str(g)][1] < k:
                    curves[str(g)] = g, k
        if not curves:
            return
        extras = [f for _, f, _ in self.clip.conditions if not f.is_constant()]
        cuts = {str(g): g for f in self.cutting for g, _ in _factors(f)}
        extras += [g for name, g in cuts.items() if name not in curves]
        graph = topology([g for g, _ in curves.values()], u=self.piece.u, v=UNIT, extras=extras)
        joints = _Joints(self.found, graph, self.sheet, self.is_stop)
        kept = [
            e for e in graph.edges
            if self.sheet.tip(e) is None and self.clip.keeps(e) and self.is_part(e, joints)
        ]  # fmt: skip
        add_branches(self.found, joints, kept, list(curves.values()))
        if self.joins:
            self._add_cusps(joints, kept)
        used = {k for e in kept for k in (e.start, e.end)}
        for node in graph.nodes:
            if node.index in used or self.sheet.tip(node) in joints.first:
                continue
            if self.clip.keeps(node) and self.is_part(node, joints):
                self.found.add_isolated(doubles(joints.spot(node).coordinates()), node)

    def _add_cusps(self, joints: _Joints, kept: Sequence[PlaneEdge]) -> None:
        """Those at which both branches end for themselves."""
        at: dict[int, list[tuple[Any, int]]] = defaultdict(list)
        for edge in kept:
            at[edge.start].append((edge, 0))
            at[edge.end].append((edge, 1))
        for index, ends in at.items():
            node = joints.graph.nodes[index]
            if len(ends) == 2 and joints.is_stop(index) and self.sheet.tip(node) is None and joints.turns_back(*ends):
                self.found.singular.append(SingularPoint(doubles(joints.spot(node).coordinates()), "cusp"))


class ModelCurve(SheetCurve):
    """With the boundary of a solid of planes and quadrics; joining: as `knots` and `joins` of SheetCurve."""

    def __init__(self, piece: RulingPiece, model: CompositeQuadric, tolerance: float, box: Box | None, first: bool,
                 **joining: Unpack[Joining]) -> None:  # fmt: skip
        super().__init__(piece, model.surfaces, len(model.surfaces), tolerance, box, first, **joining)
        self.model = model

    def lies_in_surface(self) -> None:
        who = self.model.name or "the solid"
        if len(self.forms) > 1:
            raise UnsupportedPair(f"{who}: the piece lies in one surface of several; give that one as a solid")
        if self.clip.conditions:
            raise UnsupportedPair(f"{who}: the piece lies in the surface, and is trimmed; give an untrimmed piece")
        self.found.two_dimensional = True

    def is_part(self, where: Node | PlaneEdge, joints: Joints) -> bool:
        signs = [sign_at(f, where) for f in self.forms]
        if len(outcomes(self.model.tree, signs)) < 2:
            return False
        on = [k for k, sign in enumerate(signs) if sign == 0]
        if len(on) > 1:
            spot = joints.beside(where, 0) if hasattr(where, "start") else joints.spot(where)
            self._check_crossing(on, doubles(spot.coordinates()))
        return True

    def _check_crossing(self, on: list[int], point: np.ndarray) -> None:
        """UnsupportedPair where signs alone do not tell the boundary: the solid's surfaces do not cross there."""
        gradients = np.array([(self.model.forms[k] @ np.append(point, 1.0))[:3] for k in on])
        lengths = np.linalg.norm(gradients, axis=1, keepdims=True)
        size = np.abs(self.model.forms[on]).max(axis=(1, 2))[:, None] * (1.0 + np.abs(point).max())
        clear = len(on) <= 3 and np.all(lengths > FLAT * size)
        if not clear or np.linalg.svd(gradients / lengths)[1][-1] < FLAT:
            names = "({:.9g}, {:.9g}, {:.9g})".format(*point)
            who = self.model.name or "the solid"
            raise UnsupportedPair(f"{who}: met at {names}, where surfaces of the solid do not just cross")


def _factors(f: fmpz_mpoly) -> list[tuple[fmpz_mpoly, int]]:
    """Irreducible polynomials and their multiplicities; none of a constant."""
    if f.is_constant():
        return []
    parts = bivariate.factors(f)
    return [*parts.curves, *((in_u(g), k) for g, k in parts.in_u), *((in_v(g), k) for g, k in parts.in_v)]


def sign_at(f: fmpz_mpoly, where: Node | PlaneEdge) -> int:
    """Of a polynomial on an edge or at a node."""
    if not f.is_constant():
        return int(where.sign(f))
    value = sum(f.coeffs(), 0)
    return int(value > 0) - int(value < 0)
