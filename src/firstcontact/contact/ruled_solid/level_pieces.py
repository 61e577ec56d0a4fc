"""Flat ruled pieces that stay level on a screw, as a coin on a board: they meet what is upright while heights do.

A piece across the axis is at one height, which grows at constant speed.  So it is asked about in a turn alone, over the
times of `contact.advancing`; what it shares then at once it meets with its whole face, at an exactly known time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import wraps
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq, fmpq_poly, fmpz_poly

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.advancing import Apart, Upright, axis_of_screw, in_longer_span, without_advance, without_turn
from firstcontact.contact.models.advancing import upright as upright_solid
from firstcontact.contact.polyhedra.prisms import upright as upright_prism
from firstcontact.contact.swapped import swapped
from firstcontact.contact.ways import Passed, decided, tried
from firstcontact.exact.numbers import above, below, to_double
from firstcontact.exact.vectors import Vector, dot, scaled
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.result import ContactIntervals, FirstContact, Status
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

First = Callable[[Query], FirstContact]
Intervals = Callable[[Query], ContactIntervals]


def first_of_level(answer: First) -> First:
    """Decorates what tells first contacts: of level pieces it is asked without their advance."""

    @wraps(answer)
    def asked(query: Query) -> FirstContact:
        other = _without_advance(query)
        if isinstance(other, Apart):
            return FirstContact.free(query.stats(), **query.shared)
        found = None if other is None else tried(lambda: answer(other))
        if other is None or found is None or isinstance(found, Passed):
            return answer(query)
        if found.status is Status.FREE:
            return FirstContact.free(found.stats, **query.shared)
        if found.status is Status.CONTACT:
            return _raised(found, query)
        if found.status is Status.UNDECIDED or other.first == query.first:
            return answer(query)
        return _landed(answer, query, other.first, found)

    return asked


def _landed(answer: First, query: Query, time: fmpq, found: FirstContact) -> FirstContact:
    """The first contact of bodies that share points as soon as their heights meet, at the time.

    found: what was told of the bodies without their advance.  What meets is told of them without their turn, which
    come together at the same time, in nearly the same place.
    """
    times = below(time), above(time)
    told = FirstContact(
        Status.CONTACT, to_double(time), times, multiplicity=1, free_until=times[0], stats=found.stats, **query.shared
    )
    straight = tried(lambda: answer(without_turn(query, time)))
    if isinstance(straight, Passed) or straight.status is not Status.CONTACT:
        return told
    lands = straight.time_interval is not None and straight.time_interval[0] <= times[1]
    return replace(
        told, point=straight.point, normal=straight.normal, element_a=straight.element_a,
        element_b=straight.element_b, contact_set=straight.contact_set, others=straight.others,
        multiplicity=straight.multiplicity, stats=found.stats + straight.stats,
    ) if lands else told  # fmt: skip


def _raised(found: FirstContact, query: Query) -> FirstContact:
    """The first contact that is told of the level piece first, its point at the height at which that is then."""
    normal, place = axis_of_screw(query), None
    if found.point is not None and found.time is not None and normal is not None:
        level = next(x for x in (_level_body(body, normal) for body in query.bodies) if x is not None)
        n = np.array([to_double(c) for c in normal])
        place = found.point + n * (level(found.time) - float(n @ found.point) / float(n @ n))
    ordered = _level_first(query)
    told = replace(found, point=place, contact_set=None, a=ordered.a, b=ordered.b)
    return replace(told if ordered is query else swapped(told), **query.shared)


def _level_body(body: Body, normal: Vector) -> Callable[[float], float] | None:
    """The height of a level piece at a time, in lengths of the normal; None of other bodies."""
    height = _upright(body, normal) if hasattr(shape_of(body), "pieces") else None
    if height is None:
        return None
    n = np.array([to_double(c) for c in normal])
    start = to_double(height.low) / float(n @ n)

    def at(time: float) -> float:
        pose = np.asarray(body.motion(time), float) if isinstance(body, Moving) else np.eye(4)
        return float(n @ (pose[:3, :3] @ (start * n) + pose[:3, 3])) / float(n @ n)

    return at


def intervals_of_level(answer: Intervals) -> Intervals:
    """The same for all contacts."""

    @wraps(answer)
    def asked(query: Query) -> ContactIntervals:
        other = _without_advance(query)
        if isinstance(other, Apart):
            return ContactIntervals.free(query.stats(), **query.shared)
        found = None if other is None else tried(lambda: decided(in_longer_span(answer(other), other, query), query))
        return answer(query) if found is None or isinstance(found, Passed) else found

    return asked


def _without_advance(query: Query) -> Query | Apart | None:
    """Of the level piece and the other body; None too where exact times are asked for, which screws do not have."""
    return None if query.is_algebraic else without_advance(_level_first(query), _upright)


def _level_first(query: Query) -> Query:
    """With a ruled surface as a, which is then shifted to the other one's height, so that elements keep their names."""
    return query if hasattr(shape_of(query.a), "pieces") else replace(query, a=query.b, b=query.a)


def _upright(body: Body, normal: Vector) -> Upright | None:
    shape: Any = shape_of(body)
    if isinstance(shape, Polyhedron):
        return upright_prism(body, normal)
    if not hasattr(shape, "pieces"):
        return upright_solid(body, normal)
    levels = {_level(side.components, normal) for piece in shape.pieces for side in piece.sides if not piece.deforming}
    level = levels.pop() if len(levels) == 1 and not any(piece.deforming for piece in shape.pieces) else None
    if level is None:
        return None

    def between(least: fmpq, most: fmpq) -> Body:
        way = scaled(((least + most) / 2 - level) / dot(normal, normal), normal)
        raised = shape.translated(way)
        return Moving(raised, body.motion) if isinstance(body, Moving) else raised

    return Upright(level, level, between)


def _level(components: Sequence[fmpz_poly], normal: Vector) -> fmpq | None:
    """The height of all points of a curve (X, Y, Z, W); None where it is not the same."""
    height = sum((fmpq_poly(p) * c for p, c in zip(components[:3], normal, strict=True)), fmpq_poly())
    weight = fmpq_poly(components[3])
    level: fmpq = height[weight.degree()] / weight[weight.degree()]
    return level if height == level * weight else None
