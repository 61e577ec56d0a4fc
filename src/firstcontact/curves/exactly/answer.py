"""What has been found of one intersection, in the user's parameters."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from flint import fmpq, fmpz_mpoly

from firstcontact.contact.signs.pieces import RulingPiece
from firstcontact.curves.exactly.clipping import Clip
from firstcontact.curves.exactly.spots import Box
from firstcontact.curves.lone_points import is_on_branches, is_on_lines
from firstcontact.pairs.ruled_ruled import CommonRulings, Parameter
from firstcontact.result_curve import Branch, CurveGraph, ExactParameter, ExactParameters, GraphNode, SingularPoint

if TYPE_CHECKING:
    from firstcontact.curves.fields import CurveFields, Where

# Points closer than this, relative to their size, are one: each is known to nearly full double precision.
SAME = 1e-11


class Collected:
    """Branches, points and overlaps so far."""

    def __init__(self) -> None:
        self.branches: list[Branch] = []
        self.segments: list[np.ndarray] = []
        self.singular: list[SingularPoint] = []
        self.isolated: list[np.ndarray] = []
        self.two_dimensional = False
        self.nodes: list[GraphNode] = []
        self.edges: list[tuple[int, int]] = []

    def collected(self) -> CurveFields:
        """Their fields of IntersectionCurve; no Delta and no common rulings."""
        return {
            "branches": tuple(self.branches),
            "overlap_lines": np.array(self.segments).reshape(-1, 2, 3),
            "singular_points": tuple(self.singular),
            "isolated_points": np.array(self.isolated).reshape(-1, 3),
            "two_dimensional": self.two_dimensional,
            "graph": CurveGraph(tuple(self.nodes), tuple(self.edges)),
            "delta": {},
            "common_rulings": (),
        }


class Parts(Collected):
    """Those of two bodies, one graph with nodes; tolerance: that of polylines."""

    def __init__(self, tolerance: float) -> None:
        super().__init__()
        self.tolerance = tolerance
        self._alone: list[tuple[np.ndarray, Any]] = []
        """Points with their parameters, which are isolated if they are on nothing else in the end."""

    def collected(self) -> CurveFields:
        alone = [(point, where) for point, where in self._alone if not self.is_on_more(point)]
        nodes = [GraphNode(point, "isolated", self.exact(where)) for point, where in alone]
        return super().collected() | {
            "isolated_points": np.array([point for point, _ in alone]).reshape(-1, 3),
            "graph": CurveGraph((*self.nodes, *nodes), tuple(self.edges)),
        }

    def exact(self, where: Where) -> ExactParameters:
        """Results' numbers for the user's parameters of `where`, a node or another object with u and v."""
        raise NotImplementedError

    def add_node(self, where: Where, point: np.ndarray | None, kind: str) -> int:
        self.nodes.append(GraphNode(point, kind, self.exact(where)))
        return len(self.nodes) - 1

    def add_isolated(self, point: np.ndarray, where: Where) -> None:
        if not any(same(point, other) for other, _ in self._alone):
            self._alone.append((point, where))

    def add_singular(self, point: np.ndarray, kind: str) -> None:
        """Once where several nodes of the graph are at one point: the curve passes it for several pairs (u, v)."""
        if not any(kind == other.kind and same(point, other.point) for other in self.singular):
            self.singular.append(SingularPoint(point, kind))

    def is_on_more(self, point: np.ndarray) -> bool:
        """Whether other common points are near it: here, whether it is one of the points of a branch."""
        near = SAME * max(1.0, np.abs(point).max())
        return any((np.abs(branch.points - point).max(1) <= near).any() for branch in self.branches)


class FoundCurve(Parts):
    """Those of two ruled surfaces; `p`, `q` in the parameters the search uses."""

    def __init__(
        self, p: RulingPiece, q: RulingPiece, tolerance: float, box: Box | None,
        given: tuple[RulingPiece, RulingPiece] | None = None,
    ) -> None:  # fmt: skip
        super().__init__(tolerance)
        self.p, self.q, self.box = p, q, box
        self.pieces, self.given = (p, q), given or (p, q)
        self.clip = Clip(p, q, box)

    @property
    def finite(self) -> bool:
        """Whether bounds keep all common points from infinity."""
        return self.p.bounded or self.q.bounded or self.box is not None

    @property
    def v(self) -> tuple[fmpq, fmpq] | None:
        """The range of the second parameter."""
        return self.q.u

    def is_on_more(self, point: np.ndarray) -> bool:
        p, q = self.given
        if is_on_branches(point, self.branches, [p], [q], self.tolerance):
            return True
        return is_on_lines(point, self.segments, not self.finite) and not any(same(point, x) for x in apexes(p, q))

    def exact(self, where: Where) -> ExactParameters:
        p, q = self.p, self.q
        return ExactParameters(lambda: (number(p.user_parameter(where.u)), number(q.user_parameter(where.v))))

    def parameters(self, x: np.ndarray, y: np.ndarray, chart: tuple[bool, bool], positions: np.ndarray) -> np.ndarray:
        """(n, 4) the user's u, v, s, t of points in a chart."""
        columns = []
        with np.errstate(divide="ignore"):
            for piece, value, reverse in ((self.p, x, chart[0]), (self.q, y, chart[1])):
                own = 1.0 / value if reverse else value
                columns.append(own if piece.shift is None else piece.shift + 1.0 / own)
        return np.column_stack([*columns, self.p.user_s(positions[:, 0]), self.q.user_s(positions[:, 1])])

    def fields(self, d: fmpz_mpoly, common: CommonRulings) -> CurveFields:
        """Those of IntersectionCurve; d = Delta and the common rulings in the user's parameters."""
        return self.collected() | {
            "delta": _table(d),
            "common_rulings": tuple((number(u), number(v)) for u, v in common.pairs),
            "correspondence": {} if common.correspondence.is_constant() else _table(common.correspondence),
        }


def apexes(*pieces: RulingPiece) -> list[np.ndarray]:
    """Those of cones, none at infinity."""
    found = [x.rulings.apex for x in pieces]
    return [np.array([float(fmpq(c, x[3])) for c in x[:3]]) for x in found if x is not None and x[3] != 0]


class RulingPair(NamedTuple):
    """Parameters of two rulings."""

    u: Parameter
    v: Parameter


def same(x: np.ndarray, y: np.ndarray) -> bool:
    return bool(np.abs(x - y).max() <= SAME * max(1.0, np.abs(x).max()))


def number(parameter: Parameter) -> ExactParameter:
    return math.inf if parameter is None else parameter.number()


def _table(f: fmpz_mpoly) -> dict[tuple[int, int], int]:
    return {(int(i), int(j)): int(c) for (i, j), c in f.to_dict().items()}
