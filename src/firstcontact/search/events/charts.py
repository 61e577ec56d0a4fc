"""Features of a composite quadric model as charts: quadratic maps of up to two parameters to homogeneous points.

Every quadric with points is a projective image of a sphere, a ruled torus-like quadric or a cone, and those have
quadratic charts (stereographic projection, two pencils of lines, lines through the tip); a conic is the image of a
circle.  Coordinates are in units of the body: its box is within [-1, 1]^3.  Boxes of parameters that hold no point of
the body are left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from flint import arb, fmpq

from firstcontact.body.kept import Kept
from firstcontact.body.solid.carriers import (
    ONE,
    ZERO,
    Conic,
    EnclosedPoint,
    Line,
    Plane,
    Quadric,
    QuarticCurve,
    Rows,
    diagonalised,
    doubles,
    inverse,
    restricted,
    times,
    transposed,
)
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.csg import And, Leaf, Not, Tree
from firstcontact.body.solid.features import EDGE_KINDS, Edge, Face, Vertex, enclosure
from firstcontact.body.solid.intersections import common_curves
from firstcontact.exact.numbers import exact_value, precision, to_double
from firstcontact.kernels.events.event_search import trim
from firstcontact.kernels.events.feature_boxes import (
    ABOUT,
    AND,
    CURVED,
    LEAF,
    NOT,
    OR,
    ROWS,
    STACK,
    SUM_OF_SIZES,
    UNLESS_IN,
    UNLESS_OUT,
    WIDTH,
)

BITS = 192
ARC = fmpq(4142136, 10**7)
"""Beyond tan(45 / 2 deg): four such arcs are a whole circle."""
OCTAVES = 50
"""Of the distance from a cone's tip that its charts reach; nearer points belong to the tip, within its error."""
MOST_SURFACES = 60
MOST_DEPTH = 60
MOST_BOXES = 4000
FEWEST_BOXES = 12
"""Boxes of a curved face are cut until there are as many, so that most of them are left out where others are near."""

Coefficients = list[list[Any]]
"""Six columns of four: of 1, u, v, u^2, u v, v^2."""


class NotCharted(Exception):
    """The model has a feature without a chart; the text says which."""


class TooFine(NotCharted):
    """The numbers of this body want more boxes than are made, not its kind: that is a want of precision."""


@dataclass(frozen=True, eq=False)
class Chart:
    """feature: a Face, Edge or Vertex; boxes: (n, 4) u, half, v, half that may hold its points; whole: (n,) whether
    all points of a box are the feature's; error: of points.

    surfaces: those that hold the points.  An edge of degree 4 is where surface `form` meets a chart of another one.
    """

    feature: Face | Edge | Vertex
    surfaces: tuple[int, ...]
    params: int
    coefficients: np.ndarray
    boxes: np.ndarray
    whole: np.ndarray
    error: float = 0.0
    form: int = -1


@dataclass(frozen=True, eq=False)
class Charts:
    """units: centre and half-size of the body; forms: (n + 1, 16), kinds: 0 for planes, 1 for quadrics; the last one
    is an ellipsoid around the body's box; program: the compiled tree."""

    units: np.ndarray
    forms: np.ndarray
    kinds: np.ndarray
    program: np.ndarray
    charts: list[Chart]


_CHARTS = Kept[Charts]()


def charts_of(body: CompositeQuadric) -> Charts:
    """The charts of a body, kept on it.  Raises NotCharted."""
    return _CHARTS.of_or_refusal(body, lambda: _ChartBuilder(body).build(), NotCharted)


def resting(forms: np.ndarray, kinds: np.ndarray) -> np.ndarray:
    """(n, 4, 16): rows of the table of forms for forms (n, 16) of the body itself."""
    table = np.zeros((len(forms), 4, 16))
    table[:, 0], table[:, ABOUT, CURVED] = forms, kinds
    table[:, ABOUT, SUM_OF_SIZES] = np.abs(forms).sum(axis=1)
    return table


def forms_of(body: CompositeQuadric) -> Charts:
    """As `charts_of`, without any chart: for bodies that only the other one's charts meet.  Raises NotCharted."""
    known = _ChartBuilder(body)
    return Charts(known.units, known.forms, known.kinds, known.program, [])


def compiled(tree: Tree) -> list[tuple[int, int]]:
    """Steps for `kernels.events.feature_boxes.membership`; jumps count from the first."""
    steps: list[tuple[int, int]] = []

    def add(node: Tree, depth: int) -> None:
        if depth > MOST_DEPTH:
            raise NotCharted("too deep a tree")
        if isinstance(node, Leaf):
            steps.append((int(LEAF), node.surface))
        elif isinstance(node, Not):
            add(node.inner, depth)
            steps.append((int(NOT), 0))
        else:
            is_and = isinstance(node, And)
            add(node.first, depth)
            jump = len(steps)
            steps.append((int(UNLESS_IN if is_and else UNLESS_OUT), 0))
            add(node.second, depth + 1)
            steps.append((int(AND if is_and else OR), 0))
            steps[jump] = steps[jump][0], len(steps)

    add(tree, 0)
    return steps


class _ChartBuilder:
    def __init__(self, body: CompositeQuadric) -> None:
        self.body = body
        if len(body.surfaces) > MOST_SURFACES:
            raise NotCharted("too many surfaces")
        lo, hi = body.bounds()
        if not np.all(np.isfinite([lo, hi])):
            raise NotCharted("not bounded")
        size = 2.0 ** math.frexp(float(np.max(hi - lo)) / 2 * (1 + 1e-9))[1]
        middle = np.round((lo + hi) / 2 / size * 1024) / 1024 * size
        if np.any(np.maximum(hi - middle, middle - lo) > size):
            size *= 2
        self.units = np.array([*middle, size])
        c, h = [exact_value(x) for x in middle], exact_value(size)
        self.scale: Rows = tuple(
            (*(h if i == j else ZERO for j in range(3)), c[i]) for i in range(3)
        ) + ((ZERO, ZERO, ZERO, ONE),)
        self.back = inverse(self.scale)
        self.forms = np.zeros((len(body.surfaces) + 1, 16))
        self.kinds = np.ones(len(body.surfaces) + 1, np.int64)
        self.scaled = [self._scaled(s) for s in body.surfaces]
        for k, surface in enumerate(self.scaled):
            if isinstance(surface, Plane):
                self.kinds[k] = 0
                self.forms[k, :4] = doubles((surface.normal,))[0]
            else:
                self.forms[k] = np.ravel(doubles(surface.form))
        squares = (np.maximum(hi - middle, middle - lo) / size) ** 2
        self.forms[-1] = np.ravel(np.diag([*squares.min() / squares, -3.1 * squares.min()]))
        self.program = np.array(compiled(And(Leaf(len(body.surfaces)), body.tree)), np.int64)
        self.table = resting(self.forms, self.kinds)
        self.scratch = np.zeros((ROWS, WIDTH)), np.zeros(STACK, np.int64)

    def _scaled(self, surface: Plane | Quadric) -> Plane | Quadric:
        if isinstance(surface, Plane):
            return Plane(times((surface.normal,), self.scale)[0])
        return Quadric(restricted(surface.form, self.scale))

    def build(self) -> Charts:
        with precision(BITS):
            return Charts(self.units, self.forms, self.kinds, self.program, list(self._all()))

    def _all(self) -> Iterator[Chart]:
        self.reach_of_tips: dict[int, float] = {}
        faces = [chart for face in self.body.faces for chart in self._of_face(face)]
        for vertex in self.body.vertices:
            yield self._of_vertex(vertex)
        for edge in self.body.edges:
            if edge.convexity != "reentrant" and not isinstance(edge.carrier, QuarticCurve):
                yield from self._of_edge(edge)
        yield from self._quartic_edges()
        yield from faces

    # -- one feature -----------------------------------------------------------------------------------------

    def _of_vertex(self, vertex: Vertex) -> Chart:
        if isinstance(vertex.carrier, EnclosedPoint) and not vertex.carrier.proved:
            raise NotCharted(f"{vertex.name}: its place is not proved")
        balls = [(x - c) / h for x, c, h in zip(enclosure(vertex.carrier), *self._units(), strict=True)]
        coefficients = np.zeros((6, 4))
        coefficients[0] = [*(float(x.mid()) for x in balls), 1.0]
        error = max(float(x.rad()) for x in balls) * 1.01 + max(
            (self.reach_of_tips.get(k, 0.0) for k in vertex.surfaces), default=0.0
        )
        return Chart(vertex, vertex.surfaces, 0, coefficients, np.zeros((1, 4)), np.ones(1, bool), error)

    def _units(self) -> tuple[list[arb], list[arb]]:
        return [arb(x) for x in self.units[:3]], [arb(self.units[3])] * 3

    def _of_edge(self, edge: Edge) -> Iterator[Chart]:
        assert not isinstance(edge.carrier, QuarticCurve)
        basis = times(self.back, edge.carrier.basis)
        if isinstance(edge.carrier, Line):
            direction, point = transposed(basis)
            longest = max(abs(x) for x in direction)
            d, p = [x / longest for x in direction], [x / point[3] for x in point]
            reach = self._between_ends(edge, p, d) or _clipped([to_double(x) for x in p], [to_double(x) for x in d])
            table = _table([p, d])
            yield from self._trimmed(edge, 1, table, np.array([[*reach, 0.0, 0.0]]))
            return
        assert isinstance(edge.carrier, Conic)
        more, fewer, null = ([_image(basis, v) for v in side] for side in _signed(edge.carrier.form))
        if null:  # two lines that no rational matrix describes, through one point
            for sign in (1, -1):
                first, tip = _unit(_sum(more[0], fewer[0], sign)), _unit(null[0])
                for table in (_table([first, tip]), _table([tip, first])):
                    yield from self._trimmed(edge, 1, table, np.array([[0.0, 1.0, 0.0, 0.0]]))
            return
        (v1, v2), (v3,) = more, fewer
        for table in _arcs(v1, v2, v3, None):
            half = to_double(ARC)
            yield from self._trimmed(edge, 1, table, np.array([[0.0, half, 0.0, 0.0]]))

    def _quartic_edges(self) -> Iterator[Chart]:
        """All boundary points common to two surfaces whose curve is of degree 4; named by the edge that was traced."""
        surfaces = self.body.surfaces
        quadrics = [k for k, surface in enumerate(surfaces) if isinstance(surface, Quadric)]
        for i, j in combinations(quadrics, 2):
            if not any(isinstance(c, QuarticCurve) for c in common_curves(surfaces[i], surfaces[j])):
                continue
            edges = [e for e in self.body.edges if {i, j} <= set(e.surfaces)]
            edges.sort(key=lambda e: EDGE_KINDS.index(e.convexity))
            if edges and edges[0].convexity == "convex":
                yield from self._of_surface(edges[0], i, j)

    def _of_face(self, face: Face) -> Iterator[Chart]:
        yield from self._of_surface(face, face.surfaces[0], -1)

    def _of_surface(self, face: Face | Edge, number: int, form: int) -> Iterator[Chart]:
        """The charts of a surface, cut to what belongs to the feature."""
        surface = self.scaled[number]
        if isinstance(surface, Plane):
            first, second, foot = transposed(surface.basis)
            units = [[arb(x) / arb(sum(c * c for c in d)).sqrt() for x in d] for d in (first, second)]
            box = self._around_corners(face, foot, units) or (0.0, 2.0, 0.0, 2.0)
            yield from self._trimmed(face, 2, _table([list(foot), *units]), np.array([box]))
            return
        more, fewer, null = _signed(surface.form)
        whole = np.array([[0.0, 1.0, 0.0, 1.0]])
        if (len(more), len(fewer)) == (3, 1):
            v1, v2, v3 = more
            for sign in (1, -1):
                low, high = _sum(fewer[0], v3, sign), _sum(fewer[0], v3, -sign)
                table = _table([low, _times(v1, 2), _times(v2, 2), high, None, high])
                yield from self._trimmed(face, 2, table, whole, form)
        elif (len(more), len(fewer)) == (2, 2):
            for table in _rulings(more, fewer):
                yield from self._trimmed(face, 2, table, whole, form)
        elif (len(more), len(fewer), len(null)) == (2, 1, 1):
            tip = _unit(null[0])
            half = to_double(ARC)
            octaves = [(0.0, 0.125)] + [
                (side * 1.5 * 2.0**k, 0.5 * 2.0**k) for k in range(-3, OCTAVES) for side in (1, -1)
            ]
            boxes = np.array([[0.0, half, v, h] for v, h in octaves])
            for table in _arcs(more[0], more[1], fewer[0], tip):
                self._note_tip(face, number, table)
                yield from self._trimmed(face, 2, table, boxes, form)
        else:
            raise NotCharted(f"{face.name}: a surface without regular points")

    def _note_tip(self, face: Face | Edge, number: int, table: np.ndarray) -> None:
        """How far from the tip are points that no box holds; only where the tip is a vertex may there be any."""
        cap = self.body.surfaces[number].apex  # type: ignore[union-attr]
        if cap is None:  # at infinity: the boxes reach beyond the body
            return
        reach = 4.0 * float(np.abs(table[[0, 1, 3]]).sum(axis=0).max()) * 2.0**-OCTAVES / abs(float(table[2, 3]))
        self.reach_of_tips[number] = max(self.reach_of_tips.get(number, 0.0), reach)
        is_vertex = any(number in v.surfaces and v.is_apex for v in self.body.vertices)
        if not is_vertex and self._matters_near(number, cap, reach):
            raise NotCharted(f"{face.name}: the tip of its cone is no vertex of the body")

    def _matters_near(self, number: int, tip: Sequence[fmpq], reach: float) -> bool:
        """Whether it may matter to the body within reach of the tip on which side of the cone a point is."""
        room = exact_value(self.units[3]) * exact_value(reach)
        near = self.body.near((tuple(x - room for x in tip[:3]), tuple(x + room for x in tip[:3])))
        return near is not None and self.body.surfaces[number] in near.surfaces

    # -- boxes -----------------------------------------------------------------------------------------------

    def _corners(self, feature: Face | Edge) -> list[list[fmpq]]:
        """The corners of a feature of triangles, in the units of the body; none of one that is not known by corners."""
        known = getattr(self.body, "hulls", {}).get(feature, ())
        c, h = [exact_value(x) for x in self.units[:3]], exact_value(self.units[3])
        return [[(x - m) / h for x, m in zip(point, c, strict=True)] for point in known]

    def _between_ends(self, edge: Edge, p: list[fmpq], d: list[fmpq]) -> tuple[float, float] | None:
        """Middle and half-width of the s for which p + s d is on the edge."""
        corners = self._corners(edge)
        if not corners:
            return None
        k = next(k for k in range(3) if abs(d[k]) == 1)
        return _middle_half([to_double((x[k] - p[k]) / d[k]) for x in corners])

    def _around_corners(
        self, face: Face | Edge, foot: Sequence[fmpq], units: list[list[arb]]
    ) -> tuple[float, float, float, float] | None:
        """Middles and half-widths of the u and v for which (foot + u first + v second) is on the face."""
        first, second = (np.array([float(x.mid()) for x in unit[:3]]) for unit in units)
        skew = float(first @ second)
        if abs(skew) > 0.99:
            return None
        u, v = [], []
        for x in self._corners(face):
            y = np.array([to_double(x[k] * foot[3] - foot[k]) for k in range(3)])
            along, across = float(y @ first), float(y @ second)
            u.append((along - skew * across) / (1.0 - skew * skew))
            v.append((across - skew * along) / (1.0 - skew * skew))
        return (*_middle_half(u), *_middle_half(v)) if u else None

    def _trimmed(
        self, feature: Face | Edge, params: int, table: np.ndarray, boxes: np.ndarray, form: int = -1
    ) -> Iterator[Chart]:
        """The chart with the boxes that may hold points of the body, cut to some fineness; none without any."""
        surfaces = feature.surfaces
        chart = np.append(table.ravel(), 0.0)[None]
        fewest = FEWEST_BOXES if params == 2 and self.kinds[feature.surfaces[0]] else 4
        if form >= 0:
            fewest *= 3
        for turn in range(60):
            fates = self._fates(chart, surfaces, form, boxes)
            boxes, fates = boxes[fates > 0], fates[fates > 0]
            cut = fates == 2 if len(boxes) >= fewest or turn > 8 else np.ones(len(boxes), bool)
            if not cut.any():
                break
            if len(boxes) > MOST_BOXES:
                raise TooFine(f"{feature.name}: it wants too many boxes")
            boxes = np.concatenate([boxes[~cut], _halves(boxes[cut])])
        else:
            raise TooFine(f"{feature.name}: it wants too many boxes")
        if len(boxes):
            yield Chart(feature, surfaces, params, table, boxes, fates == 3, form=form)

    def _fates(self, chart: np.ndarray, surfaces: tuple[int, ...], form: int, boxes: np.ndarray) -> np.ndarray:
        fates = np.zeros(len(boxes), np.int64)
        trim(chart, sum(1 << k for k in surfaces), form, self.program, self.table, boxes, *self.scratch, fates)
        return fates


def _halves(boxes: np.ndarray) -> np.ndarray:
    """Both halves of every box across its wider side, v as parts of its own size where that is large."""
    wide = boxes[:, 1] >= boxes[:, 3] / np.maximum(1.0, np.abs(boxes[:, 2]))
    at = np.where(wide, 0, 2)
    rows = np.arange(len(boxes))
    half = boxes[rows, at + 1] / 2
    low, high = boxes.copy(), boxes.copy()
    low[rows, at] -= half
    high[rows, at] += half
    low[rows, at + 1] = high[rows, at + 1] = half * (1 + 1e-15) + 2.0**-51 * np.abs(boxes[rows, at])
    return np.concatenate([low, high])


def _middle_half(numbers: list[float]) -> tuple[float, float]:
    """Of the range of the numbers, with more room than their rounding errors."""
    lo, hi = min(numbers), max(numbers)
    return (lo + hi) / 2, (hi - lo) / 2 * (1 + 1e-9) + 1e-9 * (1 + max(abs(lo), abs(hi)))


def _clipped(p: list[float], d: list[float]) -> tuple[float, float]:
    """Middle and half-width of the range of s in which p + s d lies within [-1.1, 1.1]^3 (largest |d_k| = 1)."""
    lo, hi = -4.0 * (1 + max(map(abs, p))), 4.0 * (1 + max(map(abs, p)))
    for x, r in zip(p[:3], d[:3], strict=True):
        if abs(r) > 1e-9:
            ends = sorted([(-1.1 - x) / r, (1.1 - x) / r])
            lo, hi = max(lo, ends[0]), min(hi, ends[1])
    return (lo + hi) / 2, max(hi - lo, 0.0) / 2 * (1 + 1e-9)


def _signed(form: Rows) -> tuple[list[Any], list[Any], list[Any]]:
    """Conjugate vectors v with v^T form v = 1, -1 (the more frequent sign first) and 0."""
    found: dict[int, list[Any]] = {1: [], -1: [], 0: []}
    largest = max(abs(x) for row in form for x in row)  # forms of turned bodies are integers beyond all doubles
    for value, vector in diagonalised(form):
        sign = (value > 0) - (value < 0)
        length = arb(abs(value) / largest).sqrt() if sign else arb(1)
        found[sign].append([arb(x) / length for x in vector] if sign else vector)
    more, fewer = sorted((found[1], found[-1]), key=len, reverse=True)
    return more, fewer, found[0]


def _image(basis: Rows, y: list[arb]) -> list[arb]:
    return [sum((arb(b) * c for b, c in zip(row, y, strict=True)), arb(0)) for row in basis]


def _sum(x: list[arb], y: list[arb], sign: int) -> list[arb]:
    return [a + sign * b for a, b in zip(x, y, strict=True)]


def _times(x: list[arb], factor: int) -> list[arb]:
    return [factor * a for a in x]


def _arcs(v1: list[arb], v2: list[arb], v3: list[arb], tip: list[arb] | None) -> Iterator[np.ndarray]:
    """(1 - u^2) v1 + 2 u v2 + (1 + u^2) v3 + v tip, and the same turned by quarters."""
    back1, back2 = _times(v1, -1), _times(v2, -1)
    for x, y in ((v1, v2), (v2, back1), (back1, back2), (back2, v1)):
        yield _table([_sum(v3, x, 1), _times(y, 2), tip, _sum(v3, x, -1)])


def _rulings(more: list[list[arb]], fewer: list[list[arb]]) -> Iterator[np.ndarray]:
    """Four charts of y1^2 + y2^2 = y3^2 + y4^2 by its two families of lines: x y = z w in sums and differences."""
    (v1, v2), (v3, v4) = more, fewer
    # the vectors of x = y1 - y3, y = y1 + y3, z = y4 - y2, w = y4 + y2, with y1 = (x + y) / 2 and so on
    vx, vy, vz, vw = _sum(v1, v3, -1), _sum(v1, v3, 1), _sum(v4, v2, -1), _sum(v4, v2, 1)
    # x = a b, y = a' b', z = a b', w = a' b with (a, a') = (u, 1) or (1, u), (b, b') = (v, 1) or (1, v)
    for first, u, v, uv in ((vy, vz, vw, vx), (vw, vx, vy, vz), (vz, vy, vx, vw), (vx, vw, vz, vy)):
        yield _table([first, u, v, None, uv])


def _table(vectors: list[Sequence[arb | fmpq] | None]) -> np.ndarray:
    """(6, 4) doubles nearest the coefficients of 1, u, v, u^2, u v, v^2, all times the same positive number."""
    balls = _unit([x for vector in vectors if vector is not None for x in vector])
    found = np.zeros((6, 4))
    for k, vector in enumerate(vectors):
        if vector is not None:
            found[k] = [float(x.mid()) for x in balls[:4]]
            balls = balls[4:]
    return found


def _unit(vector: Sequence[arb | fmpq]) -> list[arb]:
    """The multiple with largest entry 1: numbers of exact rotations exceed all doubles."""
    largest = arb(0)
    for x in vector:
        largest = max(largest, arb(abs(arb(x)).upper()))
    return [arb(x) / largest for x in vector]
