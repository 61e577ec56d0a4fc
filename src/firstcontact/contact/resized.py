"""Small bodies far from the origin, and scenes far from size 1, are asked about near it and at that size.

There doubles tell their coordinates to more digits.  All of the world is scaled by a power of two and shifted by a
vector of few binary digits, both exactly; the points of the answer are carried back.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from flint import fmpq

from firstcontact.exact.numbers import exact_value, to_double
from firstcontact.exact.vectors import Vector
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.result import ContactIntervals, ContactSet, FirstContact, Subproblem
from firstcontact.work import Query

FAR = 2.0**10
"""Sizes of the smaller body from the origin beyond which the world is shifted: ten of the 53 bits are lost there."""
SMALL, LARGE = 2.0**-24, 2.0**24
"""Sizes of the smaller body beyond which the world is scaled."""


@dataclass(frozen=True)
class _Map:
    """x -> scale x + by."""

    scale: fmpq
    by: Vector

    def back(self, points: np.ndarray) -> np.ndarray:
        return (points - [to_double(c) for c in self.by]) / to_double(self.scale)


_Place = tuple[float, tuple[float, ...], float]
"""Size, middle, and the greatest coordinate of it; ordered by size."""
_places: WeakKeyDictionary[Any, _Place] = WeakKeyDictionary()
_copies: WeakKeyDictionary[Any, dict[_Map, Any]] = WeakKeyDictionary()
"""Shapes carried along: they keep what queries work out about them."""


def first_contact(answer: Callable[[Query], FirstContact], query: Query) -> FirstContact:
    """What `answer` tells of the query."""
    world = _better_world(query)
    if world is None:
        return answer(query)
    found = answer(_carried(query, world))
    changes: dict[str, Any] = {"a": query.a, "b": query.b}
    if found.point is not None:
        changes["point"] = world.back(found.point)
    if isinstance(found.contact_set, ContactSet):
        changes["contact_set"] = ContactSet(str(found.contact_set), world.back(found.contact_set.points))
    if found.subproblems:
        changes["subproblems"] = tuple(_carried_back(x, world) for x in found.subproblems)
    return replace(found, **changes)


def contact_intervals(answer: Callable[[Query], ContactIntervals], query: Query) -> ContactIntervals:
    """What `answer` tells of the query."""
    world = _better_world(query)
    if world is None:
        return answer(query)
    return replace(answer(_carried(query, world)), a=query.a, b=query.b)


def _better_world(query: Query) -> _Map | None:
    """One with the smaller body near the origin and of size 1; None where it nearly is so."""
    size, middle, reach = min(_place(shape_of(query.a), query), _place(shape_of(query.b), query))
    if size == math.inf or (SMALL <= size <= LARGE and reach <= FAR * size):
        return None
    unit = 2.0 ** math.floor(math.log2(size))
    x, y, z = (fmpq(-round(c / unit)) for c in middle)
    return _Map(1 / exact_value(unit), (x, y, z))


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


def _carried(query: Query, world: _Map) -> Query:
    a, b = (_carried_body(body, world) for body in query.bodies)
    return replace(query, a=a, b=b)


def _carried_body(body: Any, world: _Map) -> Any:
    shape: Any = shape_of(body)
    known = _copies.setdefault(shape, {})
    if world not in known:
        s, nil = world.scale, fmpq(0)
        rows = [[s if i == j else nil for j in range(3)] + [world.by[i]] for i in range(3)]
        known[world] = shape.transformed([*rows, [nil, nil, nil, fmpq(1)]])
    if not isinstance(body, Moving):
        return known[world]
    return Moving(known[world], body.motion.carried(world.scale, world.by))


def _carried_back(listed: Subproblem, world: _Map) -> Subproblem:
    places = (None if x.point is None else world.back(x.point) for x in listed.candidates)
    return replace(
        listed, candidates=tuple(replace(x, point=p) for x, p in zip(listed.candidates, places, strict=True))
    )
