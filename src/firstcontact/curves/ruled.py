"""`intersection_curve` of two ruled surfaces at rest."""

from __future__ import annotations

import time as clock
from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from firstcontact.body.ruled.strip import RuledStrip
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.contact.signs.pieces import RulingPiece
from firstcontact.curves.certified.certified_curve import certified_curve, is_supported
from firstcontact.curves.certified.chains import chain_corners
from firstcontact.curves.certified.settled import BEARABLE
from firstcontact.curves.exactly.intersection import intersection
from firstcontact.curves.exactly.spots import Box, box_of, corners
from firstcontact.curves.placed import searched
from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.result import Stats
from firstcontact.result_curve import IntersectionCurve

if TYPE_CHECKING:
    from firstcontact.body.kinds import Ruled, Shape
    from firstcontact.curves.fields import CurveFields
    from firstcontact.exact.numbers import Given

METHODS = ("auto", "algebraic", "certified")
# Largest product of the degrees of Delta that "auto" decides exactly at once (some 40 ms).
SMALL = 20


def curve(
    p: Ruled, q: Ruled, tolerance: float, method: str, box: Iterable[Iterable[Given]] | None
) -> IntersectionCurve:
    """All points that the two surfaces share."""
    begin = clock.perf_counter()
    for surface in (p, q):
        _check(surface)
    if method not in METHODS:
        raise UnsupportedPair(f"method {method!r} is unknown to intersection_curve; choose one of {', '.join(METHODS)}")
    limits = box_of(box)
    chained = takes_kernels(p, q, method, limits) and all(x.bounded and is_supported(x) for x in (p, q))
    corners_of = chain_corners if chained else None
    fields = searched(partial(_fields, method=method), p, q, tolerance, limits, corners_of)
    fields = {"box": corners(limits)} | fields
    stats = fields.pop("stats", Stats())
    return IntersectionCurve(**fields, stats=replace(stats, seconds=clock.perf_counter() - begin), a=p, b=q)


def takes_kernels(p: Any, q: Any, method: str, box: Iterable[Iterable[Given]] | Box | None) -> bool:
    """Whether these bodies' curve is looked for in doubles, by compiled code."""
    if not all(isinstance(x, RuledSurface | RuledStrip) for x in (p, q)) or method == "algebraic" or box is not None:
        return False
    if method == "certified" or any(len(x.pieces) > 1 for x in (p, q)):
        return True
    first, second = p.pieces[0], q.pieces[0]
    sizes = [RulingPiece.of(x).rulings.degree for x in (first, second)]
    return sizes[0] * sizes[1] > SMALL and all(x.bounded and is_supported(x) for x in (first, second))


def _fields(p: Ruled, q: Ruled, tolerance: float, box: Box | None, method: str) -> CurveFields:
    """Those of IntersectionCurve, by the path that the method names."""
    strips = [x for x in (p, q) if isinstance(x, RuledStrip) and len(x.pieces) > 1]
    if method == "algebraic" and strips:
        raise UnsupportedPair(f"{strips[0]!r} has several pieces; give two of its pieces at a time, or another method")
    if box is not None and (method == "certified" or strips):
        instead = "give two of its pieces at a time" if strips else 'use method="auto"'
        raise UnsupportedPair(f"a box cuts the curve on the exact path only; leave it out, or {instead}")
    if takes_kernels(p, q, method, box):
        fields = certified_curve(p, q, tolerance, settles=bool(strips) or method == "certified")
        if method == "certified" or strips or not fields["open_places"]:
            return fields
        sizes = [RulingPiece.of(x.pieces[0]).rulings.degree for x in (p, q)]
        if sizes[0] * sizes[1] > BEARABLE:
            return fields
    return intersection(RulingPiece.of(p.pieces[0]), RulingPiece.of(q.pieces[0]), tolerance, box)


def _check(surface: Shape) -> None:
    if not isinstance(surface, RuledSurface | RuledStrip):
        at = "; give body.at(t)" if hasattr(surface, "motion") else ""
        raise UnsupportedPair(f"intersection_curve is for two ruled surfaces at rest, not {surface!r}{at}")
    if surface.deforming:
        raise InputError(f"{surface!r} deforms with the time; give surface.at(t)")
