"""`intersection_curve` of pieces and strips of any degree, certified in doubles.

The kernels find and trace all arcs of Delta = 0 on which rulings meet between their ends; here the arcs are joined to
branches.  What the kernels could not decide is asked from the exact path (`settled`), of single surfaces only close by
(`cut_out`), or reported by its place.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.contact.signs.pieces import RulingPiece
from firstcontact.curves.certified.arcs import BUDGET, HIGHEST_DEGREE, SMALL_BUDGET, ArcLine, Solved, searched, traced
from firstcontact.curves.certified.chains import Chain, chains
from firstcontact.curves.certified.cut_out import cut_about
from firstcontact.curves.certified.edge_cusps import passed, with_edges
from firstcontact.curves.certified.joined import FoundChains, JoinedStrand, Stop, knot
from firstcontact.curves.certified.open_places import (
    SAME_PLACE,
    SAME_POINT,
    open_boxes,
    open_place,
    open_places,
    touched,
    touching,
    without,
)
from firstcontact.curves.certified.reach import Reached, reached
from firstcontact.curves.certified.settled import Settled
from firstcontact.curves.certified.standstill_cusps import turned_back
from firstcontact.curves.exactly.answer import apexes, same
from firstcontact.curves.lone_points import is_on_branches, is_on_lines
from firstcontact.errors import UnsupportedPair
from firstcontact.kernels.curves import points as columns
from firstcontact.result_curve import BranchEnd, OpenPlace

if TYPE_CHECKING:
    from firstcontact.body.kinds import Ruled
    from firstcontact.curves.fields import CurveFields

# Branches that are shorter, in parts of their coordinates, may be points.
IN_SPACE = 1e-12
# Polylines of so many points are no points: chords are not cut below it.
LONG = 100


def is_supported(surface: Ruled) -> bool:
    """Whether the certified path takes this ruled surface at rest: no trimming, one row, no huge degree."""
    return all(
        not piece.trim
        and not piece.joined & {"s0", "s1"}
        and max(c.degree() for side in piece.sides for c in side.components) <= HIGHEST_DEGREE
        for piece in surface.pieces
    )


def certified_curve(p: Ruled, q: Ruled, tolerance: float, settles: bool) -> CurveFields:
    """The fields of IntersectionCurve; settles: whether places that doubles leave open are decided exactly."""
    for surface in (p, q):
        if not is_supported(surface):
            raise UnsupportedPair(
                f"{surface!r}: the certified curve takes surfaces without trimming, in one row, of degree "
                f'{HIGHEST_DEGREE} at most; try method="algebraic"'
            )
    near = reached(p, q)
    if not settles or len(near.p.pieces) > 1 or len(near.q.pieces) > 1:
        return near.beyond(_found(near, near.p, near.q, tolerance, settles).fields())
    found = before = _found(near, near.p, near.q, tolerance, False, traces=False)
    if places := found.open_places:
        cut = near.p, near.q
        if found.seen < SMALL_BUDGET:  # else places stand for all that was not looked at
            cut = cut_about(near.p, [x.u for x in places]), cut_about(near.q, [x.v for x in places])
        found = _found(near, *cut, tolerance, True, before)
        if found.open_places and cut != (near.p, near.q):  # they were not as small as that, or too close to infinity
            found = _found(near, near.p, near.q, tolerance, True, before)
    return near.beyond(found.fields())


def _found(
    near: Reached, p: Ruled, q: Ruled, tolerance: float, settles: bool,
    before: FoundChains | None = None, traces: bool = True,
) -> FoundChains:  # fmt: skip
    """What two surfaces with bounded rulings share: those of `near`, or pieces of them.

    before: what was found of them as single pieces: pairs of pieces that hold its open places are decided exactly.
    traces: False: where cells are left open, these places are told and nothing is traced.
    """
    found = FoundChains()
    if before is not None:
        found.seen, found.apexes = before.seen, before.apexes
    exact = []
    for a in chains(p):
        for b in chains(q):
            settled = Settled(a, b, tolerance)
            if before is not None:
                settled.settle({x for o in before.open_places for x in product(a.pieces_at(o.u), b.pieces_at(o.v))})
            arcs = searched(a, b, settled, BUDGET if traces else SMALL_BUDGET)
            if arcs is None:
                continue
            if before is None:
                found.apexes += arcs.apexes.points(tolerance)
            found.seen += arcs.seen
            if not traces and (left := open_places(arcs)):
                found.open_places += left
                continue
            solved = traced(arcs, tolerance)
            near.sharpen(solved.points, solved.parameters)
            strands, places = _strands(solved, settled, settles)
            own = settled.found()
            found.settled += len(own)
            # pieces that were cut may pass infinity
            sides = (a, b) if before is None else (chains(near.p)[0], chains(near.q)[0])
            strands, cusps = _with_cusps(*sides, strands, tolerance)
            found.add_cusps(cusps)
            found.add(strands + settled.strands(), places, (a, b) if own else None, own)
            exact += own

    @cache
    def pieces() -> tuple[list[RulingPiece], list[RulingPiece]]:
        own, other = ([RulingPiece.of(x) for x in surface.pieces] for surface in (near.p, near.q))
        return own, other

    def is_on_more(point: np.ndarray) -> bool:
        own, other = pieces()
        if is_on_branches(point, found.branches, own, other, tolerance):
            return True
        return is_on_lines(point, found.segments) and not any(same(point, x) for x in apexes(*own, *other))

    found.add_isolated(exact + found.apexes, is_on_more)
    return found


# -- branches -----------------------------------------------------------------------------------------------


def _strands(solved: Solved, settled: Settled, settles: bool) -> tuple[list[JoinedStrand], list[OpenPlace]]:
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
        at_bounds = [k for line in lines if not line.closed for k in line.ends if ends[k] != "undecided"]
        stray += [k for line in lines if not line.closed for k in line.ends if ends[k] == "undecided"]
        parts, ranges = open_boxes(solved, stray, at_bounds)
        groups = touching(parts, ranges)
        pairs = [touched(solved, parts[group], ranges[group]) for group in groups] if settles else []
        if not any([settled.settle(x) for x in pairs if not x <= settled.known.keys()]):
            break
        solved = without(solved, settled)
    places = [open_place(solved, parts[group], ranges[group]) for group in groups]
    strands = []
    for line, (points, parameters) in zip(lines, polylines, strict=True):
        if line.closed:
            strands.append(JoinedStrand(points, parameters, ()))
            continue
        kinds_of = [ends[k] for k in line.ends]
        if "undecided" in kinds_of and any(_within(parameters, place) for place in places):
            continue  # how the curve runs inside an open place is open
        stops = []
        for at, k, kind in zip((0, -1), line.ends, kinds_of, strict=True):
            if kind == "knot":
                stops.append(knot(solved.p, solved.q, _position(solved, k), points[at], parameters[at]))
            else:
                on = (_bound(solved, kinds[k]),) if kinds[k] > 0 else ()
                stops.append(Stop(BranchEnd(kind, on, points[at], parameters[at])))
        strands.append(JoinedStrand(points, parameters, tuple(stops)))
    return strands, places


def _with_cusps(
    p: Chain, q: Chain, strands: list[JoinedStrand], tolerance: float
) -> tuple[list[JoinedStrand], list[np.ndarray]]:
    """The strands with rows at their cusps, and these points; exact strands know theirs."""
    cusps: list[np.ndarray] = []
    for own, other, order in ((p, q, [0, 1, 2, 3]), (q, p, [1, 0, 3, 2])) if strands else ():
        edged = with_edges(own)
        for n, strand in enumerate(strands):
            parameters = strand.parameters[:, order]
            found = {x[0]: x for x in turned_back(own, other, strand.points, parameters, tolerance)}
            found |= {x[0]: x for x in (passed(edged, other.pieces, parameters) if edged else [])}
            for before, after, point, known in sorted(found.values(), key=lambda x: -x[0]):
                strand = replace(strand, points=_with_row(strand.points, before, after, point),
                                 parameters=_with_row(strand.parameters, before, after, known[order]))  # fmt: skip
                cusps.append(point)
            strands[n] = strand
    return strands, cusps


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
    return "knot" if touched(solved, *at) & settled.known.keys() else "undecided"


def _polyline(solved: Solved, line: ArcLine) -> tuple[np.ndarray, np.ndarray]:
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
    with np.errstate(invalid="ignore"):  # along the ruling at infinity
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
