"""`intersection_curve` of two ruled surfaces at rest."""

from __future__ import annotations

import time as clock
from typing import Any

from firstcontact.body.ruled_strip import RuledStrip
from firstcontact.body.ruled_surface import RuledSurface
from firstcontact.curve import IntersectionCurve
from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.exact.numbers import rational
from firstcontact.result import Stats
from firstcontact.ruled.intersection import intersection
from firstcontact.ruled.pieces import Piece
from firstcontact.ruled.spots import Box

METHODS = ("auto", "algebraic")


def intersection_curve(p: Any, q: Any, tolerance: float, method: str, box: Any) -> IntersectionCurve:
    """All points that the two surfaces share."""
    begin = clock.perf_counter()
    for surface in (p, q):
        _check(surface)
    if method not in METHODS:
        raise UnsupportedPair(f"method {method!r} is unknown to intersection_curve; choose one of {', '.join(METHODS)}")
    if not tolerance > 0:
        raise InputError(f"tolerance is {tolerance}; give a positive length")
    fields = intersection(Piece.of(p), Piece.of(q), tolerance, _box(box))
    return IntersectionCurve(**fields, stats=Stats(seconds=clock.perf_counter() - begin), a=p, b=q)


def _check(surface: Any) -> None:
    if isinstance(surface, RuledStrip):
        raise UnsupportedPair(f"{surface!r} has several pieces; give two of its pieces at a time")
    if not isinstance(surface, RuledSurface):
        at = "; give body.at(t)" if hasattr(surface, "motion") else ""
        raise UnsupportedPair(f"intersection_curve is for two ruled surfaces at rest, not {surface!r}{at}")
    if surface.deforming:
        raise InputError(f"{surface!r} deforms with the time; give surface.at(t)")


def _box(box: Any) -> Box | None:
    if box is None:
        return None
    try:
        low, high = (tuple(rational(x, "box") for x in corner) for corner in box)
    except (TypeError, ValueError) as error:
        raise InputError(f"box is {box!r}; give two corners ((x0, y0, z0), (x1, y1, z1))") from error
    if len(low) != 3 or len(high) != 3 or not all(x < y for x, y in zip(low, high, strict=True)):
        raise InputError(f"box is {box!r}; give two corners ((x0, y0, z0), (x1, y1, z1)), the first below the second")
    return low, high
