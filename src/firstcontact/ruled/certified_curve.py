"""`intersection_curve` of bounded pieces and strips of any degree, certified in doubles.

The kernels find and trace all arcs of Delta = 0 on which rulings meet between their ends; here the arcs are joined to
branches.  What the kernels could not decide is asked from the exact path (`settled`), or reported by its place.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from firstcontact.curve import BranchEnd, OpenPlace
from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.kernels import curve_bends, curve_lanes
from firstcontact.kernels import curve_cells as cells
from firstcontact.kernels import curve_nets as nets
from firstcontact.kernels import curve_points as columns
from firstcontact.kernels.curve_trace import PLAN_COLUMNS, STACK, trace
from firstcontact.kernels.curve_trim import trim
from firstcontact.ruled.chains import Chain, chains, product_table
from firstcontact.ruled.edge_cusps import passed, turns_sharply, with_edges
from firstcontact.ruled.joined import Found, Stop, Strand, knot
from firstcontact.ruled.settled import PiecePair, Settled

# Cells looked at for one pair of chains before the rest is left open.
BUDGET = 100_000
# Rows that arrays of nodes, places and arcs have at first, per part, and those of points, per arc, at first at most;
# the most of all.  They grow where that does not do.  Not many more than small curves need: where memory comes in pages
# of megabytes, clearing those takes longer than such a curve.
ROOM, POINTS, FIRST_POINTS, MOST_ROOM = 64, 2**11, 2**19, 2**23
# Of directrices; nets of a cell have twice as many rows.
HIGHEST_DEGREE = (cells.LAYER_ROWS - 2) // 2
# Open boxes are one place where they are this near each other, in parameters of parts; of more boxes than this all are.
SAME_PLACE, MOST_PLACES = 1e-5, 4000
# Branches that are shorter in their parameters, or in parts of their coordinates, may be points; ends this near to one
# are there.
SAME_POINT, IN_SPACE = 1e-9, 1e-12
# Of the square of a length that is divided by: rulings may be points.
LEAST = 1e-300
# Polylines with fewer points than this are looked through for cusps more quickly than surfaces for edges of regression.
FEW_POINTS = 4096
# Polylines of so many points are longer than that: chords are not cut below it.
LONG = 100


def is_supported(surface: Any) -> bool:
    """Whether the certified path takes this ruled surface at rest: bounded rulings, no trimming, no huge degree."""
    return all(
        piece.s is not None
        and not piece.trim
        and not piece.joined & {"s0", "s1"}
        and max(c.degree() for side in piece.sides for c in side.components) <= HIGHEST_DEGREE
        for piece in surface.pieces
    )


def certified_curve(p: Any, q: Any, tolerance: float, settles: bool) -> dict[str, Any]:
    """The fields of IntersectionCurve; settles: whether places that doubles leave open are decided exactly."""
    for surface in (p, q):
        if not is_supported(surface):
            raise UnsupportedPair(
                f"{surface!r}: the certified curve takes bounded rulings without trimming, in one row, of degree "
                f'{HIGHEST_DEGREE} at most; try method="algebraic"'
            )
    found = Found()
    exact = []
    for a in chains(p):
        for b in chains(q):
            if (solved := _solved(a, b, tolerance)) is not None:
                settled = Settled(a, b, tolerance)
                strands, places = _strands(solved, settled, settles)
                found.seen += solved.seen
                own = settled.found()
                strands, cusps = _with_cusps(a, b, strands)
                found.add_cusps(cusps)
                found.add(strands + settled.strands(), places, (a, b) if own else None, own)
                exact += own
    found.add_isolated(exact)
    return found.fields()


# -- two chains ---------------------------------------------------------------------------------------------


class Solved(NamedTuple):
    """What the kernels found of two chains.

    places, arcs        as in curve_points, coordinates about a centre
    lines               the arcs joined, in the order and directions in which they were traced
    points, parameters  (k, 3) and (k, 4) x, y, z and u, v, s, t; those of arc k, ends included: rows[k, 0]:rows[k, 1]
    turned              (k,) whether the points of an arc are in the order from its end to its start
    opened              (k, 6) boxes left open: parts, ranges of x and of y
    """

    p: Chain
    q: Chain
    places: np.ndarray
    arcs: np.ndarray
    lines: list[_Line]
    points: np.ndarray
    parameters: np.ndarray
    rows: np.ndarray
    turned: np.ndarray
    opened: np.ndarray
    seen: int


def _solved(p: Chain, q: Chain, tolerance: float) -> Solved | None:
    """None where the boxes of the chains share no point."""
    (low_p, high_p), (low_q, high_q) = p.box, q.box
    low, high = np.maximum(low_p, low_q), np.minimum(high_p, high_q)
    if (low > high).any():
        return None
    centre = 0.5 * (low + high)
    room = ROOM * max(len(p.points), len(q.points))
    while True:
        sides, forms = zip(*(_side(chain, centre, room) for chain in (p, q)), strict=True)
        joints = np.full((5, len(p.points) + 1, len(q.points) + 1), -1)
        joints[0] = 0
        places, arcs = np.empty((2 * room, columns.COLUMNS)), np.empty((room, columns.ARC_COLUMNS))
        opened, counts = np.empty((max(room, 2 * BUDGET), cells.OPEN_COLUMNS)), np.zeros(cells.COUNTS, np.int64)
        width = max(side.shape[2] for side in sides)
        scratch = np.empty((cells.LAYERS, cells.LAYER_ROWS, width))
        stack = np.zeros((4 * cells.DEEPEST, cells.CELL_COLUMNS), np.int64)
        cells.search(
            *sides, int(p.closed), int(q.closed), BUDGET, joints, scratch, stack, places, arcs, opened, counts
        )
        used, count = int(counts[cells.PLACES]), int(counts[cells.ARCS])
        if not counts[cells.SHORT] and used + 2 * count <= len(places):
            break
        room *= 4
        if room > MOST_ROOM:
            raise InputError(f"the curve falls into more than {MOST_ROOM} arcs; give smaller pieces")
    scratch, known = np.empty((columns.SCRATCH_ROWS, width)), np.empty((5, columns.COLUMNS))
    used = trim(*forms, places, used, arcs, count, known, scratch)
    arcs, places = arcs[:count], places[:used]
    lines = _lines(arcs, places[:, columns.KIND].astype(int))
    order = np.array([(k, turned, i > 0) for line in lines for i, (k, turned) in enumerate(line.arcs)], np.int64)
    order, rows, turned = order.reshape(-1, 3), np.zeros((count, 2), np.int64), np.zeros(count, bool)
    turned[order[:, 0]] = order[:, 1]
    bounds = np.array([chain.s for chain in (p, q)], float)
    ends, plan = np.empty((STACK, columns.COLUMNS)), np.empty((curve_lanes.LANES + 1, PLAN_COLUMNS))
    middles, lanes = np.empty((2, curve_lanes.ROWS * curve_lanes.LANES))
    bends = tuple(np.empty((len(x.points), curve_bends.BOUNDS)) for x in (p, q))
    for form, bend in zip(forms, bends, strict=True):
        curve_bends.derivative_bounds(form, bend)
    room = min(POINTS * (count + 1), FIRST_POINTS)
    while True:
        points, parameters = np.empty((room, 3)), np.empty((room, 4))
        if trace(
            *forms, arcs, order, places, tolerance, p.ranges, q.ranges, bounds, centre, *bends, ends, known, plan,
            scratch, middles, lanes, points, parameters, rows,
        ):  # fmt: skip
            break
        room *= 4
        if room > MOST_ROOM:
            raise InputError(f"tolerance {tolerance:g} needs more than {MOST_ROOM // 4} points; give a larger one")
    for table in (points, parameters):  # branches are views of these
        table.resize((int(rows.max(initial=0)), table.shape[1]), refcheck=False)
    boxes = opened[: counts[cells.OPENED]]
    return Solved(p, q, places, arcs, lines, points, parameters, rows, turned, boxes, int(counts[cells.SEEN]))


def _side(chain: Chain, centre: np.ndarray, room: int) -> tuple[np.ndarray, np.ndarray]:
    """The array of a side for the kernels, its parts filled in, and its forms; coordinates about the centre."""
    parts, _, terms = chain.points.shape
    side = np.empty((parts + room, nets.ROWS_OF_SIDE, max(2 * terms - 1, nets.LEAST_COLUMNS)))
    forms = np.empty((parts, 2, terms, nets.LINES))
    nets.begin(chain.points, centre, product_table(terms - 1), side, forms)
    return side, forms


# -- branches -----------------------------------------------------------------------------------------------


def _strands(solved: Solved, settled: Settled, settles: bool) -> tuple[list[Strand], list[OpenPlace]]:
    """Polylines of the pairs of pieces that are not decided exactly in the end, and the places left open there."""
    while True:
        kinds = solved.places[:, columns.KIND].astype(int)
        lines = solved.lines
        polylines = [_polyline(solved, line) for line in lines]
        tiny = [not line.closed and len(parameters) < LONG and _is_point(points, parameters)
                  for line, (points, parameters) in zip(lines, polylines, strict=True)]  # fmt: skip
        ends = {k: _end(solved, kinds[k], k, settled) for line in lines if not line.closed for k in line.ends}
        stray = [line.ends[0] for line, x in zip(lines, tiny, strict=True) if x]
        polylines = [polyline for polyline, x in zip(polylines, tiny, strict=True) if not x]
        lines = [line for line, x in zip(lines, tiny, strict=True) if not x]
        reached = [k for line in lines if not line.closed for k in line.ends if ends[k] != "undecided"]
        stray += [k for line in lines if not line.closed for k in line.ends if ends[k] == "undecided"]
        parts, ranges = _open_boxes(solved, stray, reached)
        groups = _touching(parts, ranges)
        pairs = [_touched(solved, parts[group], ranges[group]) for group in groups] if settles else []
        if not any([settled.settle(x) for x in pairs if not x <= settled.known.keys()]):
            break
        solved = _without(solved, settled)
    places = [_open_place(solved, parts[group], ranges[group]) for group in groups]
    strands = []
    for line, (points, parameters) in zip(lines, polylines, strict=True):
        if line.closed:
            strands.append(Strand(points, parameters, ()))
            continue
        kinds_of = [ends[k] for k in line.ends]
        if kinds_of == ["undecided", "undecided"] and any(_within(parameters, place) for place in places):
            continue  # how the curve runs inside an open place is open
        stops = []
        for at, k, kind in zip((0, -1), line.ends, kinds_of, strict=True):
            if kind == "knot":
                stops.append(knot(solved.p, solved.q, _position(solved, k), points[at], parameters[at]))
            else:
                on = (_bound(solved, kinds[k]),) if kinds[k] > 0 else ()
                stops.append(Stop(BranchEnd(kind, on, points[at], parameters[at])))
        strands.append(Strand(points, parameters, tuple(stops)))
    return strands, places


def _with_cusps(p: Chain, q: Chain, strands: list[Strand]) -> tuple[list[Strand], list[np.ndarray]]:
    """The strands with rows at their cusps, and these points; exact strands know theirs."""
    points: list[np.ndarray] = []
    if sum(len(x.points) for x in strands) < FEW_POINTS and not any(turns_sharply(x.points) for x in strands):
        return strands, points
    for own, other, order in ((p, q, [0, 1, 2, 3]), (q, p, [1, 0, 3, 2])):
        edged = with_edges(own)
        for n, strand in enumerate(strands if edged else []):
            for before, after, point, known in reversed(passed(edged, other.pieces, strand.parameters[:, order])):
                strand = replace(strand, points=_with_row(strand.points, before, after, point),
                                 parameters=_with_row(strand.parameters, before, after, known[order]))  # fmt: skip
                points.append(point)
            strands[n] = strand
    return strands, points


def _with_row(table: np.ndarray, before: int, after: int, row: np.ndarray) -> np.ndarray:
    """A table with this row alone between two others."""
    return np.concatenate([table[: before + 1], row[None], table[after:]])


def _position(solved: Solved, k: int) -> np.ndarray:
    """(2,) of a place along both chains."""
    row = solved.places[k]
    u = solved.p.along(int(row[columns.PART_U]), row[columns.X])
    return np.array([u, solved.q.along(int(row[columns.PART_V]), row[columns.Y])])


def _end(solved: Solved, kind: int, k: int, settled: Settled) -> str:
    """"boundary", "knot" where a pair decided exactly goes on, or "undecided"."""
    if kind > 0:
        return "boundary"
    row = solved.places[k]
    if kind == columns.WEAK or not settled.known:
        return "undecided"
    at = np.array([[row[columns.PART_U], row[columns.PART_V]]]), np.array([[row[columns.X]] * 2 + [row[columns.Y]] * 2])
    return "knot" if _touched(solved, *at) & settled.known.keys() else "undecided"


def _touched(solved: Solved, parts: np.ndarray, ranges: np.ndarray) -> set[PiecePair]:
    """The pairs of pieces that boxes touch, also by a side."""
    found: set[PiecePair] = set()
    for side in np.unique(_sides_touched(parts, ranges)).tolist():
        found |= _pairs(solved, side)
    return found


def _sides_touched(parts: np.ndarray, ranges: np.ndarray) -> np.ndarray:
    """(n,): numbers that tell the parts of boxes, and by four bits whether they reach the start and end of x, of y."""
    i, j = parts.astype(int).T
    bits = ((ranges <= 0.0) & [True, False, True, False]) | ((ranges >= 1.0) & [False, True, False, True])
    return (i << 34) + (j << 4) + bits @ np.array([1, 2, 4, 8])


def _pairs(solved: Solved, side: int) -> set[PiecePair]:
    """Those touched by boxes with such a number of _sides_touched."""
    i, j = side >> 34, (side >> 4) & (2**30 - 1)
    low_u, high_u, low_v, high_v = (bool(side & bit) for bit in (1, 2, 4, 8))
    return set(product(solved.p.neighbours(i, low_u, high_u), solved.q.neighbours(j, low_v, high_v)))


def _without(solved: Solved, settled: Settled) -> Solved:
    """What is not in pairs of pieces that are decided exactly."""
    known = np.zeros((len(solved.p.pieces), len(solved.q.pieces)), bool)
    known[tuple(np.array(list(settled.known)).T)] = True
    arcs, opened = solved.arcs.copy(), solved.opened
    i, j = arcs[:, columns.ARC_U].astype(int), arcs[:, columns.ARC_V].astype(int)
    arcs[known[solved.p.piece_of[i], solved.q.piece_of[j]], columns.START] = -1
    sides, row_of = np.unique(_sides_touched(opened[:, :2], opened[:, 2:]), return_inverse=True)
    kept = np.array([not _pairs(solved, side) <= settled.known.keys() for side in sides.tolist()], bool)
    lines = _lines(arcs, solved.places[:, columns.KIND].astype(int))
    return solved._replace(arcs=arcs, lines=lines, opened=opened[kept[row_of]])


class _Line(NamedTuple):
    """Arcs one after another, each with whether it is passed from its end to its start, and the places between."""

    arcs: list[tuple[int, bool]]
    places: list[int]
    closed: bool

    @property
    def ends(self) -> tuple[int, int]:
        return self.places[0], self.places[-1]


def _lines(arcs: np.ndarray, kinds: np.ndarray) -> list[_Line]:
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
                found.append(_Line(line, places, here == start and start in through))
    return found


def _polyline(solved: Solved, line: _Line) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) points and (n, 4) parameters along the arcs; places between arcs stand once."""
    arcs, turns = np.array(line.arcs).T
    rows = solved.rows[arcs]
    if not (turns ^ solved.turned[arcs]).any() and (rows[1:, 0] == rows[:-1, 1] - 1).all():
        whole = slice(rows[0, 0], rows[-1, 1])
        return solved.points[whole], solved.parameters[whole]
    found: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])
    for i, (k, turned) in enumerate(line.arcs):
        for table, parts in zip((solved.points, solved.parameters), found, strict=True):
            own = table[slice(*solved.rows[k])]
            own = own[::-1] if turned != solved.turned[k] else own
            parts.append(own[1:] if i else own)
    return np.concatenate(found[0]), np.concatenate(found[1])


def _is_point(points: np.ndarray, parameters: np.ndarray) -> bool:
    """Whether a branch may be one point: by u and v, or in space, where a ruling passes through an apex."""
    if np.ptp(parameters[:, :2], axis=0).max() <= SAME_POINT:
        return True
    return bool(np.ptp(points, axis=0).max() <= IN_SPACE * max(1.0, np.abs(points).max()))


def _within(parameters: np.ndarray, place: OpenPlace) -> bool:
    u, v = parameters[:, 0], parameters[:, 1]
    (a, b), (c, d), slack = place.u, place.v, SAME_PLACE
    return bool(u.min() >= a - slack and u.max() <= b + slack and v.min() >= c - slack and v.max() <= d + slack)


def _bound(solved: Solved, kind: int) -> str:
    """The name of the bound on which places of this kind are."""
    chain = (solved.p, solved.q)[(kind - 1) // 2 % 2]
    if kind < columns.CUT:
        assert chain.u is not None
        return f"{'uv'[(kind - 1) // 2]}={chain.u[(kind - 1) % 2]}"
    return f"{'st'[(kind - columns.CUT) // 2]}={chain.s[(kind - columns.CUT) % 2]}"


# -- open places --------------------------------------------------------------------------------------------


def _open_boxes(solved: Solved, stray: list[int], reached: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Parts (n, 2) and ranges (n, 4) of boxes left open.

    stray: places of branches that are points, or at which branches end without reason.  reached: ends at bounds; a
    point that is left open there is on the branch.
    """
    points = [int(arc[columns.END]) for arc in solved.arcs[solved.arcs[:, columns.START] == -2]]
    if len(solved.opened) > MOST_PLACES or not (len(solved.opened) or points or stray):
        return solved.opened[:, :2], solved.opened[:, 2:]
    spots = solved.places[np.array([*points, *stray], int)]
    parts = np.concatenate((solved.opened[:, :2], spots[:, [columns.PART_U, columns.PART_V]]))
    x, y = spots[:, columns.X], spots[:, columns.Y]
    ranges = np.concatenate((solved.opened[:, 2:], np.column_stack((x, x, y, y))))
    known = solved.places[np.array(reached, int)]
    known = known[:, [columns.PART_U, columns.PART_V]] + known[:, [columns.X, columns.Y]]
    at = parts + ranges[:, [0, 2]]
    here = (ranges[:, [0, 2]] == ranges[:, [1, 3]]).all(1)
    here[here] = [bool((np.abs(known - x).max(1) <= SAME_POINT).any()) for x in at[here]]
    thin = ((ranges[:, 0] == ranges[:, 1]) | (ranges[:, 2] == ranges[:, 3])) & ~here
    here[thin] = [_clearly_beyond(solved, *x) for x in zip(parts[thin], ranges[thin], strict=True)]
    return parts[~here], ranges[~here]


def _clearly_beyond(solved: Solved, parts: np.ndarray, ranges: np.ndarray) -> bool:
    """Whether rulings of a short part of a line cross well beyond an end of one; the cells beside it are decided."""
    length = max(ranges[1] - ranges[0], ranges[3] - ranges[2])
    if length > SAME_PLACE:
        return False
    p, q = solved.p.ruling(int(parts[0]), ranges[:2].mean()), solved.q.ruling(int(parts[1]), ranges[2:].mean())
    along, other = p[1] - p[0], q[1] - q[0]
    normal = np.cross(along, other)
    size = normal @ normal
    if size <= 1e-6 * (along @ along) * (other @ other):
        return False
    s, t = (float(np.cross(q[0] - p[0], x) @ normal / size) for x in (other, along))
    return max(-s, s - 1, -t, t - 1) > (1e-2 if length else 1e-6)


def _touching(parts: np.ndarray, ranges: np.ndarray) -> list[np.ndarray]:
    """Indices of boxes, in groups of those that touch one another."""
    if len(parts) > MOST_PLACES:
        return [np.arange(len(parts))]
    low = parts + ranges[:, [0, 2]] - SAME_PLACE
    high = parts + ranges[:, [1, 3]] + SAME_PLACE
    left = np.ones(len(parts), bool)
    groups = []
    while left.any():
        waiting, group = [int(np.argmax(left))], []
        left[waiting] = False
        while waiting:
            k = waiting.pop()
            group.append(k)
            near = np.flatnonzero(left & (low <= high[k]).all(1) & (high >= low[k]).all(1))
            left[near] = False
            waiting += near.tolist()
        groups.append(np.array(group))
    return groups


def _open_place(solved: Solved, parts: np.ndarray, ranges: np.ndarray) -> OpenPlace:
    own = []
    for side, chain in enumerate((solved.p, solved.q)):
        which = parts[:, side].astype(int)
        u = np.concatenate([chain.parameter(which, ranges[:, 2 * side + end]) for end in (0, 1)])
        own.append((float(u.min()), float(u.max())))
    k = len(parts) // 2
    ends = [chain.ruling(int(parts[k, side]), ranges[k, 2 * side : 2 * side + 2].mean())
            for side, chain in enumerate((solved.p, solved.q))]  # fmt: skip
    return OpenPlace(_nearest_point(*ends), own[0], own[1], 0)


def _nearest_point(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """The middle of the shortest way between two segments, (2, 3) each."""
    along, other = p[1] - p[0], q[1] - q[0]
    s = 0.5
    for _ in range(8):  # a point near it will do
        t = float(np.clip((p[0] + s * along - q[0]) @ other / max(other @ other, LEAST), 0, 1))
        s = float(np.clip((q[0] + t * other - p[0]) @ along / max(along @ along, LEAST), 0, 1))
    return 0.5 * (p[0] + s * along + q[0] + t * other)
