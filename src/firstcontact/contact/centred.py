"""Small bodies far from the origin are asked about near it: there doubles tell their coordinates to more digits.

All of the world is shifted, exactly, by a vector of few binary digits; the points of the answer are shifted back.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.body.kept import Kept
from firstcontact.contact.carried import carried
from firstcontact.contact.ways import R
from firstcontact.exact.numbers import to_double
from firstcontact.exact.rigid import to_origin
from firstcontact.exact.vectors import Vector
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.result import ContactIntervals, FirstContact
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Shape
    from firstcontact.body.ruled.strip import RuledStrip
    from firstcontact.body.ruled.surface import RuledSurface

FAR = 2.0**10
"""Sizes of the smaller body from the origin beyond which the world is shifted: ten of the 53 bits are lost there."""
BESIDE = 2.0
"""Sizes beyond which shifting gains any digits at all."""

_Place = tuple[float, tuple[float, ...], float]
"""Size, middle, and the greatest coordinate of it; ordered by size."""
_PLACE = Kept[_Place]()
_FAR_AWAY = np.full(3, math.inf)
_COPIES = Kept[dict[tuple[Vector, str | None], Any]]()
"""Shifted shapes, by the shift and their name: they keep what queries work out about them."""


def first(answer: Callable[[Query], FirstContact], query: Query) -> FirstContact:
    """What `answer` tells of the query."""
    return _near(first_anew, answer, query)


def first_anew(
    answer: Callable[[Query], FirstContact], query: Query, far: float = BESIDE
) -> FirstContact | None:
    """What it tells of bodies so far from the origin, such as doubles left open; None of those that are nearer."""
    by = _shift(query, far)
    if by is None:
        return None
    back = np.eye(4)
    back[:3, 3] = [-to_double(c) for c in by]
    return carried(answer(_shifted(query, by)), lambda time: back, query.a, query.b)


def intervals(answer: Callable[[Query], ContactIntervals], query: Query) -> ContactIntervals:
    """What `answer` tells of the query."""
    return _near(intervals_anew, answer, query)


def intervals_anew(
    answer: Callable[[Query], ContactIntervals], query: Query, far: float = BESIDE
) -> ContactIntervals | None:
    """As `first_anew`."""
    by = _shift(query, far)
    return None if by is None else replace(answer(_shifted(query, by)), a=query.a, b=query.b)


def _near(
    anew: Callable[[Callable[[Query], R], Query, float], R | None], answer: Callable[[Query], R], query: Query
) -> R:
    """What is told anew of bodies far from the origin, else what `answer` tells."""
    found = anew(answer, query, FAR)
    return answer(query) if found is None else found


def _shift(query: Query, far: float) -> Vector | None:
    """What brings the smaller body to the origin; None where it is within so many of its sizes, or there already."""
    size, middle, reach = min(_place(shape_of(query.a), query), _place(shape_of(query.b), query))
    if reach <= far * size:
        return None
    by = to_origin(middle, size)
    return by if any(by) else None


def _place(shape: Shape, query: Query) -> _Place:
    def found() -> _Place:
        own: Any = shape
        lo, hi = shape.bounds(query.span) if deforms is None else _seen(own, query.span if deforms else (0.0, 0.0))
        size = float((hi - lo).max())
        if not 0.0 < size < math.inf:  # points, and what has no end, tell no size
            return math.inf, (0.0, 0.0, 0.0), 0.0
        middle = 0.5 * (lo + hi)
        return size, tuple(middle.tolist()), float(np.abs(middle).max())

    deforms = getattr(shape, "deforming", None)  # known of ruled surfaces
    return found() if deforms else _PLACE.of(shape, found)


def _seen(shape: RuledSurface | RuledStrip, span: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Corners of a box of some places of a surface: its place need not be known closely."""
    if not shape.bounded:
        return -_FAR_AWAY, _FAR_AWAY
    times = np.linspace(*span, 3 if span[0] < span[1] else 1)
    points: list[np.ndarray] = []
    for piece in shape.pieces:
        first, last = (-1.0, 1.0) if piece.u is None else map(float, piece.u)
        points += [side.samples(np.linspace(first, last, 5), times).reshape(-1, 3) for side in piece.sides]
    seen = np.concatenate(points)
    seen = seen[np.isfinite(seen).all(axis=1)]
    return (seen.min(axis=0), seen.max(axis=0)) if len(seen) else (-_FAR_AWAY, _FAR_AWAY)


def _shifted(query: Query, by: Vector) -> Query:
    a, b = (_shifted_body(body, by) for body in query.bodies)
    return replace(query, a=a, b=b)


def _shifted_body(body: Any, by: Vector) -> Any:
    shape = shape_of(body)
    known, key = _COPIES.of(shape, dict), (by, shape.name)
    if key not in known:
        known[key] = shape.translated(by)
    return Moving(known[key], body.motion.shifted(by)) if isinstance(body, Moving) else known[key]
