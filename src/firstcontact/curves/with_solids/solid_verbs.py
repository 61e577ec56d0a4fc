"""`intersection_curve` of a ruled surface with a solid of planes and quadrics or with a polyhedron.

Every piece has its exact curve with the solid, or with every facet near it.  Those of several are joined at knots, at
edges of the polyhedron and where a side is a point; at all these places their branches end for themselves.
"""

from __future__ import annotations

import time as clock
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.contact.reduce import as_model, is_small_and_convex
from firstcontact.contact.signs.pieces import RulingPiece
from firstcontact.contact.signs.whole_rulings import cut_to
from firstcontact.curves.certified.chains import Chain, chains
from firstcontact.curves.certified.cover import Cover
from firstcontact.curves.certified.joined import ONE_PLACE, FoundChains, JoinedStrand, Near, Stop
from firstcontact.curves.exactly.spots import Box, box_of, corners
from firstcontact.curves.placed import searched
from firstcontact.curves.with_solids.facet_curve import FacetCurve, Facets, facets
from firstcontact.curves.with_solids.solid_curve import ModelCurve, SheetCurve
from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.result import Stats
from firstcontact.result_curve import Branch, IntersectionCurve

if TYPE_CHECKING:
    from typing import Unpack

    from firstcontact.body.kinds import Ruled, Shape
    from firstcontact.curves.fields import CurveFields
    from firstcontact.curves.with_solids.solid_curve import Joining
    from firstcontact.exact.numbers import Given

MOST_FACETS = 2000
"""Pairs of a piece and a facet near it; some 10 ms each."""


def curve(
    p: Shape, q: Shape, tolerance: float, method: str, box: Iterable[Iterable[Given]] | None
) -> IntersectionCurve:
    """All points that a ruled surface shares with the boundary of a solid or a polyhedron; either may come first."""
    begin = clock.perf_counter()
    ruled, solid = (p, q) if hasattr(p, "pieces") else (q, p)
    _check(ruled)
    if not isinstance(solid, Polyhedron | CompositeQuadric):
        raise UnsupportedPair(f"{solid!r}: give a body at rest (body.at(t))")
    if method not in ("auto", "algebraic"):
        raise UnsupportedPair(f"method {method!r}: intersection curves with solids are exact; choose 'auto'")
    limits = box_of(box)
    fields = searched(_fields, p, q, tolerance, limits)
    fields |= {"stats": Stats(seconds=clock.perf_counter() - begin), "box": corners(limits)}
    return IntersectionCurve(**fields, a=p, b=q)


def _fields(p: Any, q: Any, tolerance: float, limits: Box | None) -> CurveFields:
    """Those of IntersectionCurve."""
    ruled, solid = (p, q) if hasattr(p, "pieces") else (q, p)
    sheets = _Sheets(cut_to(ruled, solid, (0.0, 1.0)), _boundary(solid), tolerance, limits, ruled is p)
    if len(ruled.pieces) == 1 and isinstance(sheets.solid, CompositeQuadric):
        return sheets.of_model(RulingPiece.of(sheets.ruled.pieces[0])).run()
    return _joined(sheets)


def _check(ruled: Any) -> None:
    if not hasattr(ruled, "pieces"):
        raise UnsupportedPair(f"{ruled!r}: give a ruled surface at rest (body.at(t))")
    if ruled.deforming:
        raise InputError(f"{ruled!r} deforms with the time; give surface.at(t)")
    for piece in ruled.pieces:
        if piece.joined & {"s0", "s1"}:
            raise UnsupportedPair(f"{ruled!r} has rows of strips side by side; give them one by one")


def _boundary(solid: Polyhedron | CompositeQuadric) -> CompositeQuadric | Facets:
    """A model, or the facets of a polyhedron."""
    if isinstance(solid, Polyhedron):
        return as_model(solid) if is_small_and_convex(solid) else facets(solid)
    return solid


class _Sheets:
    """What makes the curves of pieces."""

    def __init__(
        self, ruled: Ruled, solid: Any, tolerance: float, box: Box | None, first: bool
    ) -> None:
        self.ruled, self.solid, self.tolerance, self.box, self.first = ruled, solid, tolerance, box, first

    def of_model(self, piece: RulingPiece, **joining: Unpack[Joining]) -> SheetCurve:
        return ModelCurve(piece, self.solid, self.tolerance, self.box, self.first, **joining)

    def of_chain(self, chain: Chain) -> Iterator[tuple[int, SheetCurve]]:
        """With the number of their piece."""
        asked = 0
        for k, surface in enumerate(chain.pieces):
            piece = RulingPiece.of(surface)
            joining: Joining = {"knots": chain.knots(k), "joins": True}
            if isinstance(self.solid, CompositeQuadric):
                yield k, self.of_model(piece, **joining)
                continue
            for facet in self.solid.near(Cover(chain, k)):
                asked += 1
                if asked > MOST_FACETS:
                    raise UnsupportedPair(f"{facet.who} has more than {MOST_FACETS} facets near {self.ruled!r}")
                yield k, FacetCurve(piece, facet, self.tolerance, self.box, self.first, **joining)


def _joined(sheets: _Sheets) -> CurveFields:
    """The fields of IntersectionCurve."""
    found, everything = FoundChains(), []
    for chain in chains(sheets.ruled):
        strands, own = [], []
        areas: set[float] = set()
        for k, curve in sheets.of_chain(chain):
            fields = curve.run()
            own.append(fields)
            if fields["two_dimensional"]:
                areas |= {float(x) % len(chain.pieces) for x in (k, k + 1)}
            strands += [_strand(chain, k, curve, branch, sheets.first) for branch in fields["branches"]]
        if areas:
            strands = [_beside_areas(x, areas, len(chain.pieces)) for x in strands if not _borders(x, areas, chain)]
        near = Near((chain,))
        found.add(_told_once(_cut_straight(_without_points(strands, near)), near), [], (chain,), own)
        everything += own
    found.add_isolated(everything)
    return {**found.fields(), "method": "exact"}


def _strand(chain: Chain, k: int, curve: SheetCurve, branch: Branch, first: bool) -> JoinedStrand:
    inner = {f"{'u' if first else 'v'}={x}" for x in chain.knots(k)}
    stops = []
    for end in branch.ends:
        u, r = (float(x) for x in end.parameters[[0, 2] if first else [1, 3]])
        tip = next((i for i in curve.sheet.tips if f"{'s' if first else 't'}={curve.piece.s_range[i]}" in end.on), None)
        if curve.sheet.is_pinched(u):
            r = 0.0
        # all rulings are at a tip
        place = np.array([float(chain.position(k, np.array([u]))[0]), r] if tip is None else [-1.0 - tip, r])
        on = tuple(x for x in end.on if x not in inner)
        stops.append(Stop(replace(end, kind="boundary", on=on), place, at_knot=branch.multiplicity % 2 == 1))
    return JoinedStrand(branch.points, branch.parameters, tuple(stops), branch.multiplicity)


def _without_points(strands: list[JoinedStrand], near: Near) -> list[JoinedStrand]:
    """Without strands that are one place to doubles, as beside a vertex, where others go on from there."""
    points = {id(x) for x in strands if x.stops and near(*x.stops) and _size(x) <= ONE_PLACE}
    others = [stop for x in strands if id(x) not in points for stop in x.stops]
    return [x for x in strands if id(x) not in points or not any(near(x.stops[0], stop) for stop in others)]


def _size(strand: JoinedStrand) -> float:
    """Greatest extent, in parts of the coordinates' size."""
    return float(np.ptp(strand.points, axis=0).max() / max(1.0, np.abs(strand.points).max()))


# -- straight strands: on knots and edges of the polyhedron, found from both sides -----------------------------


def _is_straight(strand: JoinedStrand) -> bool:
    if not strand.stops:
        return False
    start, along = strand.points[0], strand.points[-1] - strand.points[0]
    length = np.linalg.norm(along)
    if length == 0:
        return False
    off = np.linalg.norm(np.cross(strand.points - start, along / length), axis=1)
    return bool(off.max() <= ONE_PLACE * max(1.0, np.abs(strand.points).max()))


def _cut_straight(strands: list[JoinedStrand]) -> list[JoinedStrand]:
    """Straight strands in parts, where strands of the other side end on them."""
    stops = [stop for strand in strands for stop in strand.stops]
    if not stops:
        return strands
    points = np.array([stop.end.point for stop in stops])
    found: list[JoinedStrand] = []
    for strand in strands:
        found += _parts(strand, stops, points) if _is_straight(strand) else [strand]
    return found


def _parts(strand: JoinedStrand, stops: list[Stop], points: np.ndarray) -> list[JoinedStrand]:
    start, along = strand.points[0], strand.points[-1] - strand.points[0]
    length = float(np.linalg.norm(along))
    along = along / length
    near = ONE_PLACE * max(1.0, float(np.abs(strand.points).max()))
    at = (points - start) @ along
    on = (at > near) & (at < length - near) & (np.linalg.norm(np.cross(points - start, along), axis=1) <= near)
    cuts: list[tuple[float, Stop]] = []
    for k in np.flatnonzero(on)[np.argsort(at[on])].tolist():
        if _has_place(strand, stops[k]) and not (cuts and at[k] - cuts[-1][0] <= near):
            cuts.append((float(at[k]), stops[k]))
    found, own = [], (strand.points - start) @ along
    limits = [(0.0, strand.stops[0]), *cuts, (length, strand.stops[1])]
    for (a, first), (b, last) in pairwise(limits):
        inner = (own > a + near) & (own < b - near)
        rows = [np.vstack([getattr(first.end, one), getattr(strand, many)[inner], getattr(last.end, one)])
                for one, many in (("point", "points"), ("parameters", "parameters"))]  # fmt: skip
        found.append(replace(strand, points=rows[0], parameters=rows[1], stops=(replace(first), replace(last))))
    return found if cuts else [strand]


def _has_place(strand: JoinedStrand, stop: Stop) -> bool:
    """Whether a place with a point of the strand may be on the strand: the surface may pass there twice."""
    a, b, x = (float(y.place[0]) for y in (*strand.stops, stop) if y.place is not None)
    return min(a, b, x) < 0 or min(a, b) - ONE_PLACE <= x <= max(a, b) + ONE_PLACE


def _told_once(strands: list[JoinedStrand], near: Near) -> list[JoinedStrand]:
    """Without the straight strands that are there already."""
    found: list[JoinedStrand] = []
    straight: list[JoinedStrand] = []
    for strand in strands:
        if _is_straight(strand):
            if any(near.same_ends(strand, other) for other in straight):
                continue
            straight.append(strand)
        found.append(strand)
    return found


# -- pieces that lie in the surface --------------------------------------------------------------------------


def _is_at(stop: Stop, areas: set[float], count: int) -> bool:
    assert stop.place is not None
    return any(abs(stop.place[0] % count - x) <= ONE_PLACE for x in areas)


def _borders(strand: JoinedStrand, areas: set[float], chain: Chain) -> bool:
    """Whether it lies on a ruling at which such a piece ends: its points are on that piece."""
    count = len(chain.pieces)
    if not (_is_straight(strand) and all(_is_at(stop, areas, count) for stop in strand.stops)):
        return False
    assert strand.stops[0].place is not None and strand.stops[1].place is not None
    return bool(abs(strand.stops[0].place[0] - strand.stops[1].place[0]) <= ONE_PLACE)


def _beside_areas(strand: JoinedStrand, areas: set[float], count: int) -> JoinedStrand:
    """The strand, which may end where such a piece begins."""
    stops = tuple(replace(stop, at_knot=stop.at_knot and not _is_at(stop, areas, count)) for stop in strand.stops)
    return replace(strand, stops=stops)
