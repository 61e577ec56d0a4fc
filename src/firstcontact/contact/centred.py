"""Small bodies far from the origin are asked about near it: there doubles tell their coordinates to more digits.

All of the world is shifted, exactly, by a vector of few binary digits; the points of the answer are shifted back.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from firstcontact.exact.numbers import exact_value, to_double
from firstcontact.exact.vectors import Vector
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.result import ContactIntervals, ContactSet, FirstContact, Subproblem
from firstcontact.work import Query

FAR = 2.0**10
"""Sizes of the smaller body from the origin beyond which the world is shifted: ten of the 53 bits are lost there."""

_Place = tuple[float, tuple[float, ...], float]
"""Size, middle, and the greatest coordinate of it; ordered by size."""
_places: WeakKeyDictionary[Any, _Place] = WeakKeyDictionary()
_copies: WeakKeyDictionary[Any, dict[Vector, Any]] = WeakKeyDictionary()
"""Shifted shapes: they keep what queries work out about them."""


def first(answer: Callable[[Query], FirstContact], query: Query) -> FirstContact:
    """What `answer` tells of the query."""
    by = _shift(query)
    if by is None:
        return answer(query)
    found, back = answer(_shifted(query, by)), np.array([-to_double(c) for c in by])
    changes: dict[str, Any] = {"a": query.a, "b": query.b}
    if found.point is not None:
        changes["point"] = found.point + back
    if isinstance(found.contact_set, ContactSet):
        changes["contact_set"] = ContactSet(str(found.contact_set), found.contact_set.points + back)
    if found.subproblems:
        changes["subproblems"] = tuple(_shifted_back(x, back) for x in found.subproblems)
    return replace(found, **changes)


def intervals(answer: Callable[[Query], ContactIntervals], query: Query) -> ContactIntervals:
    """What `answer` tells of the query."""
    by = _shift(query)
    if by is None:
        return answer(query)
    return replace(answer(_shifted(query, by)), a=query.a, b=query.b)


def _shift(query: Query) -> Vector | None:
    """What brings the smaller body to the origin; None where it is near."""
    size, middle, reach = min(_place(shape_of(query.a), query), _place(shape_of(query.b), query))
    if reach <= FAR * size:
        return None
    unit = 2.0 ** math.floor(math.log2(size))
    x, y, z = (exact_value(-unit * round(c / unit)) for c in middle)
    return x, y, z


def _place(shape: Any, query: Query) -> _Place:
    place = _places.get(shape)
    if place is None:
        lo, hi = shape.bounds(query.span)
        size = float((hi - lo).max())
        place = math.inf, (0.0, 0.0, 0.0), 0.0  # points, and what has no end, tell no size
        if 0.0 < size < math.inf:
            middle = 0.5 * (lo + hi)
            place = size, tuple(middle.tolist()), float(np.abs(middle).max())
        if not getattr(shape, "deforming", False):
            _places[shape] = place
    return place


def _shifted(query: Query, by: Vector) -> Query:
    a, b = (_shifted_body(body, by) for body in query.bodies)
    return replace(query, a=a, b=b)


def _shifted_body(body: Any, by: Vector) -> Any:
    shape = shape_of(body)
    known = _copies.setdefault(shape, {})
    if by not in known:
        known[by] = shape.translated(by)
    return Moving(known[by], body.motion.shifted(by)) if isinstance(body, Moving) else known[by]


def _shifted_back(listed: Subproblem, back: np.ndarray) -> Subproblem:
    moved = (replace(x, point=None if x.point is None else x.point + back) for x in listed.candidates)
    return replace(listed, candidates=tuple(moved))
