"""From curves of pairs (u, v) of rulings that meet to branches in space: topology, clipping, tracing, joining.

Nodes of the graph at which two different rulings meet have one point in space.  Where the rulings are one line, every
branch has a limit point of its own on it, and branches that cross there in u, v need not meet in space.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from flint import arb, fmpq, fmpz_mpoly

from firstcontact.contact.signs.pieces import RulingPiece
from firstcontact.curves.exactly import cusps
from firstcontact.curves.exactly.answer import FoundCurve, same
from firstcontact.curves.exactly.clipping import EQUAL_BITS
from firstcontact.curves.exactly.spots import Spot, doubles, ratio, spot
from firstcontact.curves.exactly.tracing import Points, Surfaces, TracedStrand, Tracer
from firstcontact.exact.curves.plane_curves import topology
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import dyadic, precision, to_double
from firstcontact.result_curve import Branch, BranchEnd

if TYPE_CHECKING:
    from firstcontact.curves.exactly.piece_borders import BorderCurve
    from firstcontact.curves.with_solids.solid_curve import _Sheet, _SheetParts
    from firstcontact.exact.curves.plane_curves import Graph, Node, PlaneEdge

# Where branches to infinity are cut, in units of the size of the directrices.
REACH = 100.0
# Distance from a node, in parts of its edge, at which limits along the edge are taken, and the bits for them.
NEAR, LIMIT_BITS = fmpq(1, 2**120), 640
# Half-branches leave a cusp in one direction: cosine of the angle between them at that distance, and on polylines.
CUSP, MAY_BE_CUSP = 1 - 1e-9, 0.5


@dataclass(frozen=True)
class Corner:
    """The end of an edge in space: nodes with one key are one point; `point` None at infinity."""

    key: tuple[int, int]
    point: np.ndarray | None
    positions: tuple[float, float]


Curves = Sequence[tuple[fmpz_mpoly, int]]
"""Irreducible polynomials and their multiplicities."""


def add_curves(found: FoundCurve, curves: Curves) -> None:
    """Branches and isolated points of these curves in u, v."""
    p, q, clip, factors = found.p, found.q, found.clip, [f for f, _ in curves]
    still = cusps.candidates(p.rulings, q.rulings, factors)
    extras = clip.extras(factors) + still
    if not found.finite:
        extras += [clip.points[3][k] for k in sorted({clip.columns(f)[0] for f in factors})]
    graph = topology(factors, u=p.u, v=q.u, extras=extras)
    kept = [e for e in graph.edges if clip.keeps_edge(e, graph.curves[e.curve])]
    joints = Joints(found, graph, Meetings(p, q))
    add_branches(found, joints, kept, curves, still)
    used = {k for e in kept for k in (e.start, e.end)}
    for node in graph.nodes:
        if node.index not in used and (clip.bounded or not node.edges):
            joints.isolate(node)


def add_branches(
    found: FoundCurve | _SheetParts, joints: Joints, kept: Sequence[PlaneEdge], curves: Curves,
    still: Sequence[fmpz_mpoly] = (),
) -> None:  # fmt: skip
    """The branches of these edges of a graph of these curves; found: Found, or alike for another second body.

    still: polynomials with a zero wherever the curves in space stand still but those in u, v do not.
    """
    if kept:
        _Assembly(found, joints, joints.graph, kept, curves, still).run()


def add_apex(found: FoundCurve, line: fmpz_mpoly, apex: np.ndarray, side: int, parameter: AlgebraicRoot) -> None:
    """Adds the apex of one surface as an isolated point, where it is on both pieces.

    line: the polynomial in one variable whose zero is the ruling of the other surface through the apex.
    """
    p, q, clip = found.p, found.q, found.clip
    graph = topology([line], u=p.u, v=q.u, extras=clip.extras([line]))
    joints = Joints(found, graph, Meetings(p, q))
    kept = {k for e in graph.edges if clip.keeps_edge(e, line) for k in (e.start, e.end)}
    for node in graph.nodes:
        where = joints.spot(node)
        own = (node.u, node.v)[side]
        if own is None or parameter.compare(own) != 0:
            continue
        if node.index in kept or (where.point is not None and clip.keeps_node(node, where)):
            found.add_isolated(apex, node)
            return


class InSpace(Protocol):
    """What tells where points of a chart are in space."""

    def spot(self, chart: tuple[bool, bool], x: arb, y: arb, bits: int) -> Spot: ...
    def surfaces(self) -> Surfaces | _Sheet | BorderCurve: ...


class Meetings:
    """Where a pair (u, v) of rulings is in space: the point in which they meet."""

    def __init__(self, p: RulingPiece, q: RulingPiece) -> None:
        self.p, self.q = p, q

    def spot(self, chart: tuple[bool, bool], x: arb, y: arb, bits: int) -> Spot:
        return spot(self.p, self.q, chart, x, y, bits)

    def surfaces(self) -> Surfaces:
        """The same in doubles."""
        return Surfaces(self.p, self.q)


class Joints:
    """The nodes of a graph in space; `place` tells where (u, v) is."""

    def __init__(self, found: FoundCurve | _SheetParts, graph: Graph, place: InSpace) -> None:
        self.found, self.graph, self.in_space = found, graph, place
        self._spots: dict[int, Spot] = {}
        self._limits: dict[int, list[np.ndarray]] = defaultdict(list)

    def spot(self, node: Node) -> Spot:
        """The meeting point at a node, known to full double precision; `point` None where the rulings are one line."""
        if node.index not in self._spots:
            for bits in (128, LIMIT_BITS):
                where = self.at_node(node, bits)
                if where.point is not None and not where.may_be_infinite():
                    break
            self._spots[node.index] = where
        return self._spots[node.index]

    def at_node(self, node: Node, bits: int) -> Spot:
        return self.in_space.spot(node.chart, node.x_ball(bits), node.y_ball(bits), bits)

    def is_infinite(self, node: Node) -> bool:
        """Whether the weight of the point is zero to LIMIT_BITS: the point is at infinity, or beyond all doubles."""
        return self.spot(node).may_be_infinite()

    def corner(self, edge: PlaneEdge, at_end: int) -> Corner:
        node = self.graph.nodes[edge.end if at_end else edge.start]
        where = self.spot(node)
        if where.point is None:
            return self._limit_corner(node, edge, at_end)
        if self.is_infinite(node):
            return Corner((node.index, 0), None, (np.nan, np.nan))
        return Corner((node.index, 0), doubles(where.coordinates()), (ratio(where.s), ratio(where.t)))

    def _limit_corner(self, node: Node, edge: PlaneEdge, at_end: int) -> Corner:
        where = self.beside(edge, at_end)
        size = max(float(abs(x).mid()) for x in where.point)  # type: ignore[union-attr]
        if abs(float(where.point[3].mid())) <= 1e-15 * size:  # type: ignore[index]
            return Corner((node.index, -1), None, (np.nan, np.nan))
        point, known = doubles(where.coordinates()), self._limits[node.index]
        group = next((k for k, other in enumerate(known) if same(point, other)), len(known))
        if group == len(known):
            known.append(point)
        return Corner((node.index, group), point, (ratio(where.s), ratio(where.t)))

    def beside(self, edge: Any, at_end: int) -> Spot:
        """The meeting point on an edge, next to one of its ends."""
        start, end = (self.place(edge, k, LIMIT_BITS) for k in (0, 1))
        axis = 1 if edge.vertical else 0
        with precision(LIMIT_BITS):
            lo, hi = dyadic(start[axis].mid()), dyadic(end[axis].mid())
            value = hi - (hi - lo) * NEAR if at_end else lo + (hi - lo) * NEAR
            along = arb(value)
        if edge.vertical:
            x, y = start[0], along
        else:
            x, y = along, edge.at(value).enclosure(LIMIT_BITS)
        return self.in_space.spot(edge.chart, x, y, LIMIT_BITS)

    def place(self, edge: PlaneEdge, at_end: int, bits: int) -> tuple[arb, arb]:
        """An end of an edge in the chart of the edge."""
        node = self.graph.nodes[edge.end if at_end else edge.start]
        with precision(bits):
            balls = node.x_ball(bits), node.y_ball(bits)
            x, y = (
                value if own == other else 1 / value
                for value, own, other in zip(balls, node.chart, edge.chart, strict=True)
            )
        return x, y

    def isolate(self, node: Node) -> None:
        """Adds a node on no branch, where it belongs to both pieces."""
        where = self.spot(node)
        if where.point is None or self.is_infinite(node) or not self.found.clip.keeps_node(node, where):  # type: ignore[union-attr]
            return
        self.found.add_isolated(doubles(where.coordinates()), node)

    def turns_back(self, first: tuple[PlaneEdge, int], second: tuple[PlaneEdge, int]) -> bool:
        """Whether two edges leave their common end in one direction."""
        edge, at_end = first
        node = self.graph.nodes[edge.end if at_end else edge.start]
        centre = self.at_node(node, LIMIT_BITS)
        if centre.point is None:
            return False
        start, directions = centre.coordinates(), []
        for edge, at_end in (first, second):
            beside = self.beside(edge, at_end).coordinates()
            with precision(LIMIT_BITS):
                away = [a - b for a, b in zip(beside, start, strict=True)]
                length = sum((a * a for a in away), arb(0)).sqrt()
                directions.append(doubles([a / length for a in away]))
        return float(directions[0] @ directions[1]) > CUSP


class _Assembly:
    """Polylines of the kept edges, joined to branches."""

    def __init__(
        self,
        found: FoundCurve | _SheetParts,
        joints: Joints,
        graph: Graph,
        kept: Sequence[PlaneEdge],
        curves: Curves,
        still: Sequence[fmpz_mpoly],
    ) -> None:
        self.still = still
        self.found, self.joints, self.graph, self.kept = found, joints, graph, kept
        self.multiplicities = [next(k for f, k in curves if f in (g, -g)) for g in graph.curves]
        self.corners = [[joints.corner(edge, k) for k in (0, 1)] for edge in kept]
        self.at: dict[tuple[int, int], list[tuple[int, int]]] = defaultdict(list)
        for i, pair in enumerate(self.corners):
            for k, corner in enumerate(pair):
                self.at[corner.key].append((i, k))
        self.lines: list[Points] = []
        self.numbers: dict[tuple[int, int], int] = {}
        self.cusps: set[tuple[int, int]] = set()

    def run(self) -> None:
        self.lines = self._polylines()
        left = {i for i, line in enumerate(self.lines) if len(line.tau) > 1}
        stops = [(i, k) for i in sorted(left) for k in (0, 1) if not self._passes(self.corners[i][k])]
        for start in stops:
            if start[0] in left:
                self._add(self._chain(start, left))
        while left:
            self._add(self._chain((min(left), 0), left))
        for key in self.at:
            if len(self.at[key]) > 2 or key in self.cusps:
                corner = self._corner(key)
                if corner.point is not None:
                    self.found.add_singular(corner.point, "cusp" if key in self.cusps else "node")

    def _polylines(self) -> list[Points]:
        strands = [self._strand(edge) for edge in self.kept]
        ends = np.full((len(strands), 2, 5), np.nan)
        for i, pair in enumerate(self.corners):
            for k, corner in enumerate(pair):
                if corner.point is not None:
                    ends[i, k, :3], ends[i, k, 3:] = corner.point, corner.positions
        tracer = Tracer(self.joints.in_space.surfaces(), self.graph.curves, strands)
        radius = np.inf if self.found.finite else REACH * tracer.surfaces.size()
        return tracer.trace(ends, self.found.tolerance, radius)

    def _strand(self, edge: Any) -> TracedStrand:
        (x0, y0), (x1, y1) = ([float(x.mid()) for x in self.joints.place(edge, k, 128)] for k in (0, 1))
        u, v = (x.enclosure(96) if isinstance(x, AlgebraicRoot) else arb(x) for x in edge.sample)
        with precision(96):
            inside = [float((1 / x if reverse else x).mid()) for x, reverse in zip((u, v), edge.chart, strict=True)]
        v_range = self.found.v or (fmpq(-1), fmpq(1))
        window = to_double(v_range[0]), to_double(v_range[1])
        slabs = [(k, n) for (_, k), n in zip(edge.slabs, edge.numbers, strict=True)] if hasattr(edge, "slabs") else []
        limits = [float(x.enclosure(64).mid()) for x in edge.limits] if slabs else []
        at = inside[0], inside[1]
        return TracedStrand(edge, edge.chart, edge.vertical, edge.curve, (x0, y0), (x1, y1), at, window, slabs, limits)

    def _corner(self, key: tuple[int, int]) -> Corner:
        i, k = self.at[key][0]
        return self.corners[i][k]

    def _passes(self, corner: Corner) -> bool:
        return corner.point is not None and len(self.at[corner.key]) == 2

    def _chain(self, start: tuple[int, int], left: set[int]) -> list[tuple[int, int]]:
        """Edges from a corner on, each with the end at which it is entered, until a stop or back to the start."""
        chain, here = [], start
        while here[0] in left:
            chain.append(here)
            left.remove(here[0])
            corner = self.corners[here[0]][1 - here[1]]
            if not self._passes(corner):
                break
            here = next(x for x in self.at[corner.key] if x != (here[0], 1 - here[1]))
        return chain

    def _add(self, chain: list[tuple[int, int]]) -> None:
        first, last = self.corners[chain[0][0]][chain[0][1]], self.corners[chain[-1][0]][1 - chain[-1][1]]
        closed = first.key == last.key and self._passes(first)
        points: list[np.ndarray] = []
        parameters: list[np.ndarray] = []
        for i, entered in chain:
            line = self.lines[i] if entered == 0 else self.lines[i][::-1]
            skip = 1 if points else 0
            points.append(line.space[skip:])
            chart = self.kept[i].chart
            parameters.append(self.found.parameters(line.x, line.y, chart, line.positions)[skip:])
        joints = list(zip(chain, chain[1:] + chain[:1] if closed else chain[1:], strict=False))
        stops = [0] if closed else []
        for n, (x, y) in enumerate(joints):
            if self._is_cusp(x, y):
                self.cusps.add(self.corners[y[0]][y[1]].key)
                stops.append(n + 1)
        all_points, all_parameters = np.concatenate(points), np.concatenate(parameters)
        ends = () if closed else (
            self._end(first, all_points[0], all_parameters[0]), self._end(last, all_points[-1], all_parameters[-1])
        )  # fmt: skip
        multiplicity = min(self.multiplicities[self.kept[i].curve] for i, _ in chain)
        self.found.branches.append(Branch(all_points, all_parameters, closed, ends, multiplicity))
        self._add_to_graph(chain, first, last, closed)

    def _is_cusp(self, before: tuple[int, int], after: tuple[int, int]) -> bool:
        """Whether the branch turns back between two edges: seen on the polyline or likely, then proved at the node."""
        x = self.lines[before[0]].space if before[1] == 0 else self.lines[before[0]].space[::-1]
        y = self.lines[after[0]].space if after[1] == 0 else self.lines[after[0]].space[::-1]
        node = y[0]
        out, back = y[1] - node, x[-2] - node
        if out @ back <= MAY_BE_CUSP * np.linalg.norm(out) * np.linalg.norm(back) and not self._may_stand_still(after):
            return False
        return self.joints.turns_back((self.kept[before[0]], 1 - before[1]), (self.kept[after[0]], after[1]))

    def _may_stand_still(self, half: tuple[int, int]) -> bool:
        """Whether one of the polynomials `still` may vanish at an end of an edge."""
        node = self.graph.nodes[self.corners[half[0]][half[1]].key[0]]
        with precision(96):
            balls = node.x_ball(96), node.y_ball(96)
            u, v = (1 / x if reverse else x for x, reverse in zip(balls, node.chart, strict=True))
            values = (sum((c * u**i * v**j for (i, j), c in f.to_dict().items()), arb(0)) for f in self.still)
            return any(bool(x.contains(0)) for x in values)

    def _add_to_graph(self, chain: list[tuple[int, int]], first: Corner, last: Corner, closed: bool) -> None:
        """One edge for every stretch between ends, crossings and cusps; a loop without them has one node."""
        keys = [first.key, *(self.corners[i][1 - k].key for i, k in chain)]
        cusps = [n for n in range(1, len(keys) - 1) if keys[n] in self.cusps]
        stops = [0, *cusps, len(keys) - 1]
        for a, b in zip(stops, stops[1:], strict=False):
            self.found.edges.append((self._node(keys[a]), self._node(keys[b])))

    def _node(self, key: tuple[int, int]) -> int:
        if key not in self.numbers:
            node, corner = self.graph.nodes[key[0]], self._corner(key)
            self.numbers[key] = self.found.add_node(node, corner.point, self._kind(key, corner))
        return self.numbers[key]

    def _kind(self, key: tuple[int, int], corner: Corner) -> str:
        if corner.point is None:
            return "infinity"
        if key in self.cusps:
            return "cusp"
        meet = len(self.at[key])
        return "boundary" if meet == 1 else "node" if meet > 2 else "regular"

    def _end(self, corner: Corner, point: np.ndarray, parameters: np.ndarray) -> BranchEnd:
        if corner.point is None:
            return BranchEnd("infinity", (), point, parameters)
        node = self.graph.nodes[corner.key[0]]
        kind = "boundary" if len(self.at[corner.key]) == 1 else "node"
        on = self.found.clip.bounds_at(self.joints.at_node(node, EQUAL_BITS))
        return BranchEnd(kind, on, point, parameters, self.found.exact(node))
