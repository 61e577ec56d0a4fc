"""Small bodies far from the origin are asked about near it: there doubles tell their coordinates to more digits.  Very
large and very small ones are asked about in another unit, so that sizes of no question are beyond what searches take.

All of the world is shifted, exactly, by a vector of few binary digits, and scaled by a power of two; the points of the
answer are brought back.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.compound.compound import Compound
from firstcontact.body.kept import Kept
from firstcontact.contact.carried import carried
from firstcontact.contact.ways import R
from firstcontact.errors import InputError
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

ORDINARY = 12
"""Bits of sizes, above 1 and below, of which nothing is scaled."""

World = tuple[Vector, fmpq]
"""A shift, and by how much all is made larger after it."""
NOWHERE: Vector = (fmpq(0),) * 3
_Place = tuple[float, tuple[float, ...], float]
"""Size, middle, and the greatest coordinate of it; ordered by size."""
_PLACE = Kept[_Place]()
_FAR_AWAY = np.full(3, math.inf)
_COPIES = Kept[dict[tuple[Vector, fmpq, str | None], Any]]()
"""Shapes in other worlds, by these and their name: they keep what queries work out about them."""


def first(answer: Callable[[Query], FirstContact], query: Query) -> FirstContact:
    """What `answer` tells of the query."""
    return _near(first_anew, answer, query)


def first_anew(
    answer: Callable[[Query], FirstContact], query: Query, far: float = BESIDE
) -> FirstContact | None:
    """What it tells of bodies so far from the origin, such as doubles left open; None of those that are nearer."""
    world = _world(query, far)
    if world is None:
        return None
    by, factor = world
    back = np.diag([*[1.0 / to_double(factor)] * 3, 1.0])
    back[:3, 3] = [-to_double(c) for c in by]
    return carried(answer(_seen_in(query, world)), lambda time: back, query.a, query.b)


def intervals(answer: Callable[[Query], ContactIntervals], query: Query) -> ContactIntervals:
    """What `answer` tells of the query."""
    return _near(intervals_anew, answer, query)


def intervals_anew(
    answer: Callable[[Query], ContactIntervals], query: Query, far: float = BESIDE
) -> ContactIntervals | None:
    """As `first_anew`."""
    world = _world(query, far)
    return None if world is None else replace(answer(_seen_in(query, world)), a=query.a, b=query.b)


def _near(
    anew: Callable[[Callable[[Query], R], Query, float], R | None], answer: Callable[[Query], R], query: Query
) -> R:
    """What is told anew of bodies far from the origin, or of far other sizes, else what `answer` tells."""
    found = anew(answer, query, FAR)
    return answer(query) if found is None else found


def _world(query: Query, far: float) -> World | None:
    """What brings the smaller body to the origin, and two large or small ones to ordinary sizes; None where it is
    within so many of its sizes, or there already, and of such a size."""
    places = [_place(shape_of(body), query) for body in query.bodies]
    size, middle, reach = min(places)
    by = to_origin(middle, size) if reach > far * size else NOWHERE
    bits = [math.frexp(own)[1] for own, *_ in places if own < math.inf]
    least, most = min(bits, default=0), max(bits, default=0)
    beyond = least if least > ORDINARY else most if most < -ORDINARY else 0
    factor = fmpq(2) ** -beyond
    if not beyond or not all(_may_be_scaled(body, factor) for body in query.bodies):
        return (by, fmpq(1)) if any(by) else None
    return by, factor


def _may_be_scaled(body: Any, factor: fmpq) -> bool:
    """Whether the numbers of its motion are still below the largest then.  Not compounds, of which answers tell
    lengths: how far these are from what a file has."""
    shape = shape_of(body)
    if getattr(shape, "deforming", False) or isinstance(shape, Compound):
        return False
    try:
        if isinstance(body, Moving):
            body.motion.magnified(factor)
    except InputError:
        return False
    return True


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


def _seen_in(query: Query, world: World) -> Query:
    a, b = (_body_in(body, world) for body in query.bodies)
    return replace(query, a=a, b=b)


def _body_in(body: Any, world: World) -> Any:
    by, factor = world
    shape = shape_of(body)
    known, key = _COPIES.of(shape, dict), (by, factor, shape.name)
    if key not in known:
        there = shape.translated(by) if any(by) else shape
        known[key] = there if factor == 1 else there.transformed(_magnifying(factor))
    if not isinstance(body, Moving):
        return known[key]
    motion = body.motion.shifted(by) if any(by) else body.motion
    return Moving(known[key], motion if factor == 1 else motion.magnified(factor))


def _magnifying(factor: fmpq) -> list[list[fmpq]]:
    return [[(factor if i < 3 else fmpq(1)) if i == j else fmpq(0) for j in range(4)] for i in range(4)]
