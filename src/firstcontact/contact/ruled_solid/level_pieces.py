"""Flat ruled pieces that stay level on a screw, as a coin on a board: they meet what is upright while heights do.

A piece across the axis is at one height, which grows at constant speed.  So it is asked about in a turn alone, over the
times of `contact.advancing`; what it shares then at once it meets with its whole face, at an exactly known time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from typing import TYPE_CHECKING, Any

from flint import fmpq

from firstcontact.contact.advancing import Apart, Upright, axis_of_screw, in_longer_span, without_advance
from firstcontact.contact.heights.landing import landed
from firstcontact.contact.heights.meeting import ascents_of
from firstcontact.contact.swapped import swapped
from firstcontact.contact.upright_parts import upright
from firstcontact.contact.ways import Passed, decided, tried
from firstcontact.exact.numbers import exact_value
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
        normal = axis_of_screw(query)
        assert normal is not None
        told = landed(query, normal, other.first, answer)
        return replace(told, stats=found.stats + told.stats)

    return asked


def _raised(found: FirstContact, query: Query) -> FirstContact:
    """The first contact that is told of the level piece first, its point at the height at which that is then."""
    ascents, place = ascents_of(query), None
    if found.point is not None and found.time is not None and ascents is not None:
        place = ascents.raised(found.point, exact_value(found.time))
    ordered = _level_first(query)
    told = replace(found, point=place, contact_set=None, a=ordered.a, b=ordered.b)
    return replace(told if ordered is query else swapped(told), **query.shared)


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
    if not hasattr(shape, "pieces"):
        return upright(body, normal)
    levels = {side.height(normal) for piece in shape.pieces for side in piece.sides if not piece.deforming}
    level = levels.pop() if len(levels) == 1 and not any(piece.deforming for piece in shape.pieces) else None
    if level is None:
        return None

    def between(least: fmpq, most: fmpq) -> Body:
        way = scaled(((least + most) / 2 - level) / dot(normal, normal), normal)
        raised = shape.translated(way)
        return Moving(raised, body.motion) if isinstance(body, Moving) else raised

    return Upright(level, level, between)
