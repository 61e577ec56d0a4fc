"""What the search for events reads of two models: charts, pairs of features that are not exempt, surfaces, trees."""

from __future__ import annotations

import weakref
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.body.kept import Kept
from firstcontact.body.solid.carriers import Line, Plane, QuarticCurve
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.features import Edge, Face, Vertex
from firstcontact.exact.polynomials.inertia import rank
from firstcontact.exact.vectors import cross
from firstcontact.kernels.events.event_search import ALL_PAIRS, IN_OWN, KNOWN, STILL
from firstcontact.kernels.events.feature_boxes import ABOUT, CURVED, UNLESS_IN, UNLESS_OUT
from firstcontact.search.events.charts import Chart, charts_of, resting

if TYPE_CHECKING:
    from firstcontact.search.events.charts import Charts

JUMPS = (UNLESS_IN, UNLESS_OUT)


@dataclass(frozen=True, eq=False)
class Tables:
    """charts: (n, 25), info: (n, 6), pairs: (m, 5), layout: (2, 8), as `kernels.events.event_search` reads them.

    features: those of the charts, others: those of the pairs.  boxes: (n, 8) to start with; still: (n, 8), all faces;
    known, known_still: what is known of these, (n, 3).
    """

    charts: np.ndarray
    info: np.ndarray
    pairs: np.ndarray
    layout: np.ndarray
    program: np.ndarray
    raw: np.ndarray
    kinds: np.ndarray
    units: np.ndarray
    table: np.ndarray
    features: list[Face | Edge | Vertex]
    others: list[Face | Edge | Vertex]
    boxes: np.ndarray
    still: np.ndarray
    known: np.ndarray
    known_still: np.ndarray


MOST_TABLES = 64
"""Kept of a body: parts are made of many pieces, each of which may be asked about in every query."""
_TABLES = Kept[dict[int, tuple[weakref.ref[CompositeQuadric], Tables]]]()


def tables_of(a: CompositeQuadric, b: CompositeQuadric) -> Tables:
    """The tables of two bodies, kept for those second ones they were asked with last.  Raises NotCharted."""
    every = _TABLES.of(a, dict)
    known = every.get(id(b))
    if known is None or known[0]() is not b:
        if len(every) >= MOST_TABLES:
            del every[next(iter(every))]
        known = every[id(b)] = weakref.ref(b), _tables(a, b)
    return known[1]


def _tables(a: CompositeQuadric, b: CompositeQuadric) -> Tables:
    sides = charts_of(a), charts_of(b)
    n = [len(side.forms) for side in sides]
    steps = [len(side.program) for side in sides]
    program, layout = programs_of(sides, n, steps)
    total = sum(n)
    table = np.zeros((2 * total, 4, 16))
    table[: n[0]], table[total : total + n[1]] = (resting(side.forms, side.kinds) for side in sides)
    kinds = np.concatenate([side.kinds for side in sides])
    table[n[0] : total, ABOUT, CURVED], table[total + n[1] :, ABOUT, CURVED] = sides[1].kinds, sides[0].kinds
    charts: list[np.ndarray] = []
    info: list[list[int]] = []
    pairs: list[list[int]] = []
    features: list[Face | Edge | Vertex] = []
    others: list[Face | Edge | Vertex] = []
    boxes: list[np.ndarray] = []
    still: list[np.ndarray] = []
    known: list[np.ndarray] = [np.zeros((0, KNOWN), np.int64)]
    known_still: list[np.ndarray] = []
    for side, own, other in ((0, a, b), (1, b, a)):
        for chart in sides[side].charts:
            number, first = len(charts), len(pairs)
            for feature, row in _pairs(own, chart, other, side):
                pairs.append(row)
                others.append(feature)
            on = sum(1 << k for k in chart.surfaces)
            charts.append(np.append(chart.coefficients.ravel(), chart.error))
            info.append([side, chart.params, on, first, len(pairs), 0])
            features.append(chart.feature)
            if len(pairs) > first:
                boxes.append(_rows(number, ALL_PAIRS, chart))
                known.append(_known(chart))
            if isinstance(chart.feature, Face):
                still.append(_rows(number, STILL, chart))
                known_still.append(_known(chart))
    return Tables(
        np.array(charts), np.array(info, np.int64), np.array(pairs, np.int64).reshape(-1, 5), layout, program,
        np.concatenate([side.forms for side in sides]), kinds,
        np.array([side.units for side in sides]), table, features, others,
        np.concatenate(boxes) if boxes else np.zeros((0, 8)), np.concatenate(still),
        np.concatenate(known), np.concatenate(known_still),
    )  # fmt: skip


def programs_of(sides: tuple[Charts, Charts], n: list[int], steps: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Both trees one after the other, and the layout of either body."""
    shifted = sides[1].program.copy()
    shifted[np.isin(shifted[:, 0], JUMPS), 1] += steps[0]
    program = np.concatenate([sides[0].program, shifted])
    total = sum(n)
    trees = (0, steps[0]), (steps[0], steps[0] + steps[1])
    layout = [
        [0, n[0], *trees[0], *trees[1], 0, n[0]],
        [total, total + n[1], *trees[1], *trees[0], n[0], n[1]],
    ]
    return program, np.array(layout, np.int64)


def _rows(number: int, pair: int, chart: Chart) -> np.ndarray:
    count = len(chart.boxes)
    return np.column_stack([
        np.full(count, float(number)), np.full(count, float(pair)), chart.boxes, np.zeros(count), np.zeros(count),
    ])  # fmt: skip


def _known(chart: Chart) -> np.ndarray:
    found = np.zeros((len(chart.boxes), KNOWN), np.int64)
    found[:, IN_OWN] = chart.whole
    return found


def _pairs(
    own: CompositeQuadric, chart: Chart, other: CompositeQuadric, side: int
) -> Iterator[tuple[Face | Edge | Vertex, list[int]]]:
    """(feature of the other body, row) of the pairs of the chart's feature that are not exempt.

    As in `contact.models.subproblems`: planes touch planes and lines, cones and cylinders only where a boundary sees it
    too.
    """
    feature, form = chart.feature, chart.form
    if isinstance(feature, Vertex):
        for face in other.faces:
            yield face, [1, 0, face.surfaces[0], -1, -1]
    elif isinstance(feature, Edge):
        n = 2 if form < 0 else 3
        for face in other.faces:
            if not (isinstance(feature.carrier, Line) and isinstance(face.carrier, Plane)):
                yield face, [n, n - 1, face.surfaces[0], -1, form]
        if side == 0:
            for edge in other.edges:
                if edge.convexity != "reentrant":
                    yield edge, [n, 0, *crossing_surfaces(other, edge), form]
    elif not isinstance(feature.carrier, Plane):
        conical = _is_conical(feature)
        for face in other.faces:
            if isinstance(face.carrier, Plane):
                exempt = conical
            else:
                exempt = side == 1
            if not exempt:
                yield face, [3, 2, face.surfaces[0], -1, -1]


def _is_conical(face: Face) -> bool:
    return rank(face.carrier.matrix()) == 3


def crossing_surfaces(body: CompositeQuadric, edge: Edge) -> list[int]:
    """Of the surfaces that hold the edge, two that cross there: those of its faces, planes first."""
    if isinstance(edge.carrier, QuarticCurve):
        return list(edge.surfaces[:2])
    numbers = dict.fromkeys(body.faces[k].surfaces[0] for k in edge.faces)
    if len(numbers) < 2:  # the rim of a surface without inside: its plane, and one across
        (flat,) = numbers
        n = body.surfaces[flat].normal[:3]  # type: ignore[union-attr]
        numbers |= {k: None for k in edge.surfaces if any(cross(n, body.surfaces[k].normal[:3]))}  # type: ignore[union-attr]
    return sorted(numbers, key=lambda k: not isinstance(body.surfaces[k], Plane))[:2]
