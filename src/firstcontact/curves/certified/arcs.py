"""All arcs of Delta = 0 on which rulings of two chains meet between their ends: the kernels' work, in doubles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from firstcontact.curves.certified.bernstein import product_table
from firstcontact.curves.certified.chains import Chain
from firstcontact.curves.certified.settled import Settled
from firstcontact.curves.exactly.apex_rulings import ApexRulings
from firstcontact.errors import InputError
from firstcontact.kernels.curves import bends as curve_bends
from firstcontact.kernels.curves import cells, nets
from firstcontact.kernels.curves import lanes as curve_lanes
from firstcontact.kernels.curves import points as columns
from firstcontact.kernels.curves.trace import PLAN_COLUMNS, STACK, trace
from firstcontact.kernels.curves.trim import trim
from firstcontact.work import may_grow

# Cells looked at for one pair of chains before the rest is left open; where that is decided exactly then, fewer.
BUDGET, SMALL_BUDGET = 100_000, 20_000
# Rows that arrays of nodes, places and arcs have at first, per part, and those of points, per arc, at first at most.
# They grow where that does not do.  Not many more than small curves need: where memory comes in pages of megabytes,
# clearing those takes longer than such a curve.
ROOM, POINTS, FIRST_POINTS = 64, 2**11, 2**19
# Of directrices; nets of a cell have twice as many rows.
HIGHEST_DEGREE = (cells.LAYER_ROWS - 2) // 2


class SearchedChains(NamedTuple):
    """What the kernels found of two chains, but for points between places.

    forms           as `curve_points.evaluate` takes them, coordinates about the centre
    places, arcs    as in curve_points
    opened          (k, 6) boxes left open: parts, ranges of x and of y
    apexes          rulings that pass through the other surface's apex: no arcs
    """

    p: Chain
    q: Chain
    forms: tuple[np.ndarray, np.ndarray]
    centre: np.ndarray
    places: np.ndarray
    arcs: np.ndarray
    opened: np.ndarray
    apexes: ApexRulings
    seen: int


class Solved(NamedTuple):
    """The same with points.

    lines               the arcs joined, in the order and directions in which they were traced
    points, parameters  (k, 3) and (k, 4) x, y, z and u, v, s, t; those of arc k, ends included: rows[k, 0]:rows[k, 1]
    turned              (k,) whether the points of an arc are in the order from its end to its start
    """

    p: Chain
    q: Chain
    places: np.ndarray
    arcs: np.ndarray
    lines: list[ArcLine]
    points: np.ndarray
    parameters: np.ndarray
    rows: np.ndarray
    turned: np.ndarray
    opened: np.ndarray


def searched(p: Chain, q: Chain, settled: Settled, budget: int = BUDGET) -> SearchedChains | None:
    """But for pairs of pieces decided exactly; None where the boxes of the chains share no point."""
    (low_p, high_p), (low_q, high_q) = p.box, q.box
    low, high = np.maximum(low_p, low_q), np.minimum(high_p, high_q)
    if (low > high).any():
        return None
    centre = 0.5 * (low + high)
    known = np.ascontiguousarray(settled.mask()[np.ix_(p.piece_of, q.piece_of)])
    room = ROOM * max(len(p.points), len(q.points))
    while True:
        (side_p, form_p), (side_q, form_q) = (begun(chain, centre, room) for chain in (p, q))
        joints = np.full((5, len(p.points) + 1, len(q.points) + 1), -1)
        joints[0] = 0
        places, arcs = np.empty((2 * room, columns.COLUMNS)), np.empty((room, columns.ARC_COLUMNS))
        opened, counts = np.empty((max(room, 2 * budget), cells.OPEN_COLUMNS)), np.zeros(cells.COUNTS, np.int64)
        width = max(side_p.shape[2], side_q.shape[2])
        scratch = np.empty((cells.LAYERS, cells.LAYER_ROWS, width))
        stack = np.zeros((4 * cells.DEEPEST, cells.CELL_COLUMNS), np.int64)
        cells.search(
            side_p, side_q, int(p.closed), int(q.closed), known, budget, joints, scratch, stack, places, arcs, opened,
            counts,
        )  # fmt: skip
        used, count = int(counts[cells.PLACES]), int(counts[cells.ARCS])
        if not counts[cells.SHORT] and used + 2 * count <= len(places):
            break
        if not may_grow(side_p, side_q, places, arcs, by=4):
            raise InputError(f"the curve falls into more than {room} arcs; give smaller pieces")
        room *= 4
    scratch, ends = np.empty((columns.SCRATCH_ROWS, width)), np.empty((5, columns.COLUMNS))
    used = trim(form_p, form_q, places, used, arcs, count, ends, scratch)
    arcs, places, opened = arcs[:count], places[:used], opened[: counts[cells.OPENED]]
    apex_rulings = ApexRulings(p, q)
    arcs[apex_rulings.along(arcs, places), columns.START] = -1
    return SearchedChains(p, q, (form_p, form_q), centre, places, arcs, opened, apex_rulings, int(counts[cells.SEEN]))


def traced(found: SearchedChains, tolerance: float) -> Solved:
    """Polylines of the arcs."""
    p, q, forms, arcs, places = found.p, found.q, found.forms, found.arcs, found.places
    lines = lines_of(arcs, places[:, columns.KIND].astype(int))
    order = np.array([(k, turned, i > 0) for line in lines for i, (k, turned) in enumerate(line.arcs)], np.int64)
    order, rows, turned = order.reshape(-1, 3), np.zeros((len(arcs), 2), np.int64), np.zeros(len(arcs), bool)
    turned[order[:, 0]] = order[:, 1]
    bounds = np.array([chain.s for chain in (p, q)], float)
    width = max(nets.LEAST_COLUMNS, *(2 * form.shape[2] - 1 for form in forms))
    scratch, known = np.empty((columns.SCRATCH_ROWS, width)), np.empty((5, columns.COLUMNS))
    ends, plan = np.empty((STACK, columns.COLUMNS)), np.empty((curve_lanes.LANES + 1, PLAN_COLUMNS))
    middles, lanes = np.empty((2, curve_lanes.ROWS * curve_lanes.LANES))
    bends = tuple(np.empty((len(x.points), curve_bends.BOUNDS)) for x in (p, q))
    for form, bend in zip(forms, bends, strict=True):
        curve_bends.derivative_bounds(form, bend)
    room = min(POINTS * (len(arcs) + 1), FIRST_POINTS)
    while True:
        points, parameters = np.empty((room, 3)), np.empty((room, 4))
        if trace(
            *forms, arcs, order, places, tolerance, p.ranges, q.ranges, bounds, found.centre, *bends, ends, known, plan,
            scratch, middles, lanes, points, parameters, rows,
        ):  # fmt: skip
            break
        if not may_grow(points, parameters, by=4):
            raise InputError(f"this tolerance needs more than {room} points; give a larger one")
        room *= 4
    for table in (points, parameters):  # branches are views of these
        table.resize((int(rows.max(initial=0)), table.shape[1]), refcheck=False)
    return Solved(p, q, places, arcs, lines, points, parameters, rows, turned, found.opened)


def begun(chain: Chain, centre: np.ndarray, room: int) -> tuple[np.ndarray, np.ndarray]:
    """The array of a side for the kernels, its parts filled in, and its forms; coordinates about the centre."""
    parts, _, terms = chain.points.shape
    side = np.empty((parts + room, nets.ROWS_OF_SIDE, max(2 * terms - 1, nets.LEAST_COLUMNS)))
    forms = np.empty((parts, 2, terms, nets.LINES))
    nets.begin(chain.points, centre, product_table(terms - 1, terms - 1), side, forms)
    return side, forms


class ArcLine(NamedTuple):
    """Arcs one after another, each with whether it is passed from its end to its start, and the places between."""

    arcs: list[tuple[int, bool]]
    places: list[int]
    closed: bool

    @property
    def ends(self) -> tuple[int, int]:
        return self.places[0], self.places[-1]


def lines_of(arcs: np.ndarray, kinds: np.ndarray) -> list[ArcLine]:
    """All arcs, joined where two of them meet; not at weak places."""
    pairs = {k: (a, b) for k, (a, b) in enumerate(arcs[:, [columns.START, columns.END]].astype(int).tolist()) if a >= 0}
    at: dict[int, list[int]] = {}
    for k, pair in pairs.items():
        for place in pair:
            at.setdefault(place, []).append(k)
    left = set(pairs)
    through = {place for place, own in at.items() if len(own) == 2 and kinds[place] != columns.WEAK}
    found = []
    for starts in ([x for x in at if x not in through], list(at)):  # arcs with ends, then loops
        for start in starts:
            for first in at[start]:
                if first not in left:
                    continue
                line, places, here, k = [], [start], start, first
                while True:
                    left.remove(k)
                    turned = pairs[k][0] != here
                    here = pairs[k][0 if turned else 1]
                    line.append((k, turned))
                    places.append(here)
                    further = [x for x in at[here] if x in left] if here in through else []
                    if not further:
                        break
                    k = further[0]
                found.append(ArcLine(line, places, here == start and start in through))
    return found
