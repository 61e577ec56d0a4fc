"""Unions of solids that are upright along the axis of a screw, and polyhedra that are prisms along it.

A union is not the same at all heights though its parts are.  It shares a point with another body exactly when a part
does, for all are closed; and each part is asked about without the advance, while its heights meet the other's: a turn
has rational poses where a screw has none, so that edges that come flush, or leave each other, are decided.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.composite_quadric import CompositeQuadric, NoSolid
from firstcontact.contact.advancing import Apart, Upright, in_longer_span, without_advance
from firstcontact.contact.compound.answer import joined
from firstcontact.contact.models.advancing import upright as upright_solid
from firstcontact.contact.polyhedra.prisms import upright as upright_prism
from firstcontact.contact.ways import Passed, decided
from firstcontact.exact.vectors import Vector
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.result import ContactIntervals
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body


def intervals(
    query: Query, proved: ContactIntervals | None, ask: Callable[[Query], ContactIntervals]
) -> ContactIntervals | Passed:
    """All closed times of contact, of parts that are asked about one by one; what was proved before stands else."""
    asked = _questions(query)
    if asked is None:
        return Passed("they are no upright parts that advance along one axis")
    told = [
        ContactIntervals.free(query.stats(), **query.shared)
        if isinstance(other, Apart) else in_longer_span(ask(other), other, query)
        for other in asked
    ]  # fmt: skip
    found = told[0] if len(told) == 1 else replace(joined(query, told), **query.shared)
    return decided(found, query) if proved is None or found.reason is None else Passed(found.reason)


def may_be_asked(query: Query, _: object) -> bool:
    """Whether parts are asked one by one: a budget is that of one question, and exact times are told of the whole."""
    return query.budget is None and not query.is_algebraic


def _questions(query: Query) -> list[Query | Apart] | None:
    """One for each pair of parts, without the advance; None where these are not all upright."""
    found = []
    try:
        for a, b in product(parts_of(query.a), parts_of(query.b)):
            other = without_advance(replace(query, a=a, b=b), upright)
            if other is None:
                return None
            found.append(other)
    except NoSolid:
        return None
    return found


def parts_of(body: Body) -> list[Body]:
    """The solids of which a solid is the union, as it tells them; others whole."""
    shape = shape_of(body)
    if not isinstance(shape, CompositeQuadric):
        return [body]
    return [Moving(x, body.motion) if isinstance(body, Moving) else x for x in shape.united()]


def upright(body: Body, normal: Vector) -> Upright | None:
    """A prism or solid that is the same at all heights; None of others."""
    return (upright_prism if isinstance(shape_of(body), Polyhedron) else upright_solid)(body, normal)
