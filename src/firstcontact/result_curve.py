"""What `intersection_curve` answers: small immutable records."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.result import SCHEMA, AlgebraicNumber, Answer, Stats, written

if TYPE_CHECKING:
    from pathlib import Path

    from firstcontact.result import Table
    from firstcontact.view.html import NotebookFrame

ExactParameter = Fraction | AlgebraicNumber | float
"""A parameter of a ruling: the number itself, or math.inf for the ruling at infinity."""


ExactPair = tuple[ExactParameter | None, ExactParameter | None]
"""u and v; None of a body without rulings."""


class ExactParameters:
    """The exact u and v of a point, worked out when asked for: v may take an elimination of high degree."""

    __slots__ = ("_make", "_pair")

    def __init__(self, make: Callable[[], ExactPair]) -> None:
        self._make: Any = make
        self._pair: ExactPair | None = None

    @property
    def pair(self) -> ExactPair:
        if self._pair is None:
            self._pair, self._make = self._make(), None
        return self._pair

    def __reduce__(self) -> tuple[object, ...]:
        return _known, (self.pair,)


def _known(pair: ExactPair) -> ExactParameters:
    return ExactParameters(lambda: pair)


@dataclass(frozen=True, slots=True, eq=False)
class BranchEnd:
    """Where a branch ends.

    kind         "boundary" of a piece or of the box, "node" where branches meet, "infinity" where the branch has
                 no end and was cut, "undecided" at an OpenPlace
    on           the bounds that hold there: "u=0", "s=1", "t=0", "x=3", "trim"
    point        (3,) float64
    parameters   (4,) float64: u, v, s, t; nan of a body without rulings, and s or t where a ruling is a point
    u, v         exact; None for "infinity", on the certified path and of a body without rulings; worked out when asked
                 for
    """

    kind: str
    on: tuple[str, ...]
    point: np.ndarray
    parameters: np.ndarray
    exact: ExactParameters | None = field(default=None, repr=False)

    @property
    def u(self) -> ExactParameter | None:
        return None if self.exact is None else self.exact.pair[0]

    @property
    def v(self) -> ExactParameter | None:
        return None if self.exact is None else self.exact.pair[1]

    def __str__(self) -> str:
        on = f" ({', '.join(self.on)})" if self.on else ""
        return f"{self.kind}{on} at {_triple(self.point)}, {_quadruple(self.parameters)}"

    def to_dict(self) -> Table:
        return {
            "kind": self.kind,
            "on": list(self.on),
            "point": self.point.tolist(),
            "parameters": self.parameters.tolist(),
            "u": None if self.u is None else written(self.u),
            "v": None if self.v is None else written(self.v),
        }


@dataclass(frozen=True, slots=True, eq=False)
class Branch:
    """An arc or loop of the intersection.

    points        (n, 3) float64: a polyline within the tolerance of the curve; the last point of a loop is the first
    parameters    (n, 4) float64: u, v, s, t of the points
    closed        whether it is a loop
    ends          the two ends of an arc, () for a loop
    multiplicity  of its factor in Delta: the surfaces touch along the branch where it is above 1
    """

    points: np.ndarray
    parameters: np.ndarray
    closed: bool
    ends: tuple[BranchEnd, ...]
    multiplicity: int = 1

    @property
    def length(self) -> float:
        """Of the polyline."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())

    def __str__(self) -> str:
        kind, count = ("closed", len(self.points) - 1) if self.closed else ("open", len(self.points))
        touching = ", touching along it" if self.multiplicity > 1 else ""
        head = f"{kind} branch of {count} points, length {self.length:.6g}{touching}"
        if self.closed:
            return f"{head}\n    through {_triple(self.points[0])}, {_quadruple(self.parameters[0])}"
        return f"{head}\n    from {self.ends[0]}\n    to {self.ends[1]}"

    def to_dict(self) -> Table:
        return {
            "points": self.points.tolist(),
            "parameters": self.parameters.tolist(),
            "closed": self.closed,
            "length": self.length,
            "ends": [end.to_dict() for end in self.ends],
            "multiplicity": self.multiplicity,
        }


@dataclass(frozen=True, slots=True, eq=False)
class SingularPoint:
    """A point at which the curve is not smooth: "node" (branches meet) or "cusp" (one turns back)."""

    point: np.ndarray
    kind: str

    def to_dict(self) -> Table:
        return {"point": self.point.tolist(), "kind": self.kind}


@dataclass(frozen=True, slots=True, eq=False)
class GraphNode:
    """A point of the curve: "regular", "node", "cusp", "isolated", "boundary", "infinity" or "undecided".

    u, v are exact; on the certified path they are doubles; None of a body without rulings.
    """

    point: np.ndarray | None
    kind: str
    exact: ExactParameters = field(repr=False)

    @property
    def u(self) -> ExactParameter | None:
        return self.exact.pair[0]

    @property
    def v(self) -> ExactParameter | None:
        return self.exact.pair[1]

    def to_dict(self) -> Table:
        return {
            "u": None if self.u is None else written(self.u),
            "v": None if self.v is None else written(self.v),
            "kind": self.kind,
            "point": None if self.point is None else self.point.tolist(),
        }


@dataclass(frozen=True, slots=True, eq=False)
class OpenPlace:
    """A place at which it was not decided what is there: a crossing or tangency, points, overlaps, or nothing.

    point   (3,) float64: near it
    u, v    the ranges of the parameters; all that was left open there lies in them
    ends    how many ends of branches lie at it
    """

    point: np.ndarray
    u: tuple[float, float]
    v: tuple[float, float]
    ends: int

    def __str__(self) -> str:
        return f"undecided near {_triple(self.point)}, where {self.ends} ends of branches meet"

    def to_dict(self) -> Table:
        return {"point": self.point.tolist(), "u": list(self.u), "v": list(self.v), "ends": self.ends}


@dataclass(frozen=True, slots=True, eq=False)
class CurveGraph:
    """The topology of the curve over the projective parameters.

    nodes    with their exact parameters
    edges    (start, end) indices of nodes; a loop without nodes of its own has a regular one
    """

    nodes: tuple[GraphNode, ...]
    edges: tuple[tuple[int, int], ...]

    @property
    def components(self) -> int:
        """How many connected pieces; branches are not connected through infinity."""
        parent = list(range(len(self.nodes)))

        def root(i: int) -> int:
            while parent[i] != i:
                i = parent[i]
            return i

        apart = 0
        for a, b in self.edges:
            through = [k for k in (a, b) if self.nodes[k].kind != "infinity"]
            if len(through) == 2:
                parent[root(through[0])] = root(through[1])
            elif not through:
                apart += 1
        return apart + len({root(i) for i, node in enumerate(self.nodes) if node.kind != "infinity"})

    def to_dict(self) -> Table:
        return {
            "nodes": [node.to_dict() for node in self.nodes],
            "edges": [list(edge) for edge in self.edges],
            "components": self.components,
        }


@dataclass(frozen=True, slots=True, eq=False)
class IntersectionCurve(Answer):
    """All points that two ruled surfaces share.

    branches          arcs and loops, cut where more than two of them meet
    overlap_lines     (k, 2, 3) float64: common rulings; of bounded pieces the shared segments, else two points of the
                      line (within the box)
    singular_points   nodes and cusps of the branches
    isolated_points   (k, 3) float64: points on no branch and, but for apexes on the other surface, on no overlap line
    two_dimensional   whether the surfaces share a part with an area; `branches` then holds what else they share
    graph             nodes with exact parameters, and the edges between them
    delta             Delta(u, v) = sum delta[i, j] u^i v^j: two rulings meet where it vanishes; {} if all do
    common_rulings    the pairs (u, v) of rulings that are one line, exact
    correspondence    a polynomial like `delta` along whose zeros rulings are one line; {} if none
    method            "exact", or "certified": in doubles with proved error bounds, and exactly where these leave places
                      open.  Then `delta` and `common_rulings` are not worked out
    open_places       what was not decided; everywhere else the branches are all there is, proved
    box               (2, 3) float64: what lies outside was not looked for, or is left out; None: that is everywhere
    """

    branches: tuple[Branch, ...]
    overlap_lines: np.ndarray
    singular_points: tuple[SingularPoint, ...]
    isolated_points: np.ndarray
    two_dimensional: bool
    graph: CurveGraph
    delta: Mapping[tuple[int, int], int]
    common_rulings: tuple[tuple[ExactParameter, ExactParameter], ...]
    correspondence: Mapping[tuple[int, int], int] = field(default_factory=dict)
    method: str = "exact"
    open_places: tuple[OpenPlace, ...] = ()
    box: np.ndarray | None = None
    stats: Stats = field(default_factory=Stats)
    a: Any = field(default=None, repr=False)
    b: Any = field(default=None, repr=False)
    keeps_bodies: bool = False

    @property
    def empty(self) -> bool:
        """Whether the surfaces share no point (in the box); proved.  False where that is open."""
        found = self.branches or len(self.overlap_lines) or len(self.isolated_points) or self.two_dimensional
        return not (found or self.open_places)

    @property
    def names(self) -> tuple[str, str]:
        first, second = (getattr(x, "name", None) or default for x, default in ((self.a, "a"), (self.b, "b")))
        return first, second

    def __repr__(self) -> str:
        return f"<IntersectionCurve of {str(self).splitlines()[0]}>"

    def __str__(self) -> str:
        names = " and ".join(self.names)
        if self.empty:
            return f"{names}: no common point{self._where}; proved"
        kinds = [
            (len(self.branches), "branch", "branches"),
            (len(self.overlap_lines), "overlap line", "overlap lines"),
            (len(self.isolated_points), "isolated point", "isolated points"),
            (len(self.singular_points), "singular point", "singular points"),
            (len(self.open_places), "undecided place", "undecided places"),
        ]
        counts = [f"{n} {one if n == 1 else many}" for n, one, many in kinds if n]
        if self.two_dimensional:
            counts.insert(0, "a common part with an area")
        lines = [f"{names}: {', '.join(counts)}{self._where}"]
        lines += [f"  {branch}" for branch in self.branches]
        lines += [f"  overlap line from {_triple(x)} to {_triple(y)}" for x, y in self.overlap_lines]
        lines += [f"  isolated point {_triple(x)}" for x in self.isolated_points]
        lines += [f"  {x.kind} at {_triple(x.point)}" for x in self.singular_points]
        lines += [f"  {x}" for x in self.open_places]
        return "\n".join(lines)

    @property
    def _where(self) -> str:
        return "" if self.box is None else f" in the box from {_triple(self.box[0])} to {_triple(self.box[1])}"

    def to_dict(self) -> Table:
        """Exact numbers are strings, polynomials lists of [i, j, coefficient]; parameters may be nan (None in JSON)."""
        return {
            "schema": SCHEMA,
            "a": self.names[0],
            "b": self.names[1],
            "branches": [branch.to_dict() for branch in self.branches],
            "overlap_lines": self.overlap_lines.tolist(),
            "singular_points": [x.to_dict() for x in self.singular_points],
            "isolated_points": self.isolated_points.tolist(),
            "two_dimensional": self.two_dimensional,
            "graph": self.graph.to_dict(),
            "delta": [[i, j, str(c)] for (i, j), c in self.delta.items()],
            "common_rulings": [[written(u), written(v)] for u, v in self.common_rulings],
            "correspondence": [[i, j, str(c)] for (i, j), c in self.correspondence.items()],
            "method": self.method,
            "open_places": [x.to_dict() for x in self.open_places],
            "box": None if self.box is None else self.box.tolist(),
            "stats": self.stats.to_dict(),
        }

    def show(self, path: str | None = None) -> Path | NotebookFrame:
        """Write the page of the surfaces and their curve; without a path show it in the notebook, or in the browser."""
        from firstcontact.view.html import show_page

        return show_page(path, [self])


def _triple(x: np.ndarray) -> str:
    return "({:.9g}, {:.9g}, {:.9g})".format(*x)


def _quadruple(parameters: np.ndarray) -> str:
    return ", ".join(f"{name} = {x:.9g}" for name, x in zip("uvst", parameters, strict=True) if not np.isnan(x))
