"""Solids upright along one direction that turn about it, or shift, and advance along it at constant speed meanwhile.

As for polyhedra, a tall one that does not advance has the same times of contact while the heights meet; and a turn has
rational poses where a screw has none, so that sides that come flush are decided.  The tall one is the solid itself,
stretched along the direction.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING

from flint import fmpq

from firstcontact.body.solid.carriers import Plane
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.contact.advancing import Apart, Upright, in_longer_span, without_advance
from firstcontact.contact.ways import Passed, decided
from firstcontact.exact.numbers import fraction
from firstcontact.exact.vectors import Vector, cross, dot
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.result import ContactIntervals
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

Heights = tuple[fmpq, fmpq]


def ignoring_advance(answer: Callable[[Query], ContactIntervals]) -> Callable[[Query], ContactIntervals]:
    """Decorates what tells times of contact: it is asked about such solids without their advance first."""

    @wraps(answer)
    def asked(query: Query) -> ContactIntervals:
        other = without_advance(query, upright)
        if other is None:
            return answer(query)
        if isinstance(other, Apart):
            return ContactIntervals.free(query.stats(), **query.shared)
        found = decided(in_longer_span(answer(other), other, query), query)
        return answer(query) if isinstance(found, Passed) else found

    return asked


def upright(body: Body, normal: Vector) -> Upright | None:
    heights = _heights(shape_of(body), normal)
    return heights and Upright(*heights, lambda least, most: _stretched(body, normal, heights, (least, most)))


def _heights(body: object, normal: Vector) -> Heights | None:
    """The levels between which a solid is the same at all heights; None of others.

    All of its surfaces that are not level hold the direction, so that what is inside changes at level faces alone; and
    it is bounded, so that nothing is beyond two of them.
    """
    if not isinstance(body, CompositeQuadric) or not body.bounded or body.whole is not None:
        return None
    for surface in body.surfaces:
        across = [surface.normal] if isinstance(surface, Plane) else surface.form
        lies = isinstance(surface, Plane) and not any(cross(surface.normal[:3], normal))
        if not lies and any(dot(row[:3], normal) for row in across):
            return None
    carriers = {face.carrier for face in body.faces}
    levels = {height_of(x, normal) for x in carriers if isinstance(x, Plane) and not any(cross(x.normal[:3], normal))}
    return (min(levels), max(levels)) if len(levels) == 2 else None


def height_of(plane: Plane, normal: Vector) -> fmpq:
    """normal . x at all points of a plane across it."""
    height: fmpq = -plane.normal[3] * dot(normal, normal) / dot(plane.normal[:3], normal)
    return height


def _stretched(body: Body, normal: Vector, heights: Heights, wanted: Heights) -> Body:
    """The solid with other heights."""
    square, factor = dot(normal, normal), (wanted[1] - wanted[0]) / (heights[1] - heights[0])
    shift = wanted[0] - factor * heights[0]
    rows = [
        [fraction(int(i == j) + (factor - 1) * normal[i] * c / square) for j, c in enumerate(normal)]
        + [fraction(shift * normal[i] / square)] for i in range(3)
    ]  # fmt: skip
    tall = shape_of(body).transformed([*rows, [0, 0, 0, 1]])
    return Moving(tall, body.motion) if isinstance(body, Moving) else tall
