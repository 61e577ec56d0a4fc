"""Turns that leave a model as it is: a pin about its own axis.  What is left of the motion has rational poses.

A surface is the same after every turn about a line if its form does not change at first order: K^T Q + Q K = 0 for the
generator K of the turns.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from typing import Any, TypeVar

from flint import fmpq, fmpq_mat

from firstcontact.body.kept import Kept
from firstcontact.body.solid.carriers import Plane, Surface
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.exact.vectors import cross
from firstcontact.motion.moving import Moving
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw
from firstcontact.motion.translation import Translation
from firstcontact.result import ContactIntervals, FirstContact
from firstcontact.work import Query

ORIGIN = (fmpq(0),) * 3
R = TypeVar("R", FirstContact, ContactIntervals)
_ROUND = Kept[dict[tuple[tuple[int, int], ...], bool]]()
"""By axis and point, whether the model is one of revolution about that line."""


def ignoring_idle_turns(answer: Callable[[Query], R]) -> Callable[[Query], R]:
    """Decorates what answers queries: it is asked about bodies that hold the same points at all times and turn less."""

    @wraps(answer)
    def asked(query: Query) -> R:
        a, b = (without_idle_turn(body) for body in query.bodies)
        if a is query.a and b is query.b:
            return answer(query)
        return replace(answer(replace(query, a=a, b=b)), a=query.a, b=query.b)

    return asked


def without_idle_turn(body: Any) -> Any:
    """The body, or one that holds the same points at all times and only shifts."""
    if not isinstance(body, Moving) or isinstance(body.motion, Translation):
        return body
    motion, model = body.motion, body.body
    if not isinstance(model, CompositeQuadric) or not isinstance(motion, Rotation | Screw):
        return body
    if not _is_round(model, motion):
        return body
    if isinstance(motion, Rotation):
        return Moving(model, Translation(ORIGIN))
    ahead = Screw(motion.axis, motion.point, turns=0, advance=motion.advance).reduced()
    return Moving(model, Translation(ORIGIN) if isinstance(ahead, Rotation) else ahead)


def _is_round(model: CompositeQuadric, motion: Rotation | Screw) -> bool:
    known = _ROUND.of(model, dict)
    line = tuple((int(x.p), int(x.q)) for x in (*motion.axis, *motion.point))
    if line not in known:
        known[line] = all(is_same(surface, motion.axis, motion.point) for surface in model.surfaces)
    return known[line]


def is_same(surface: Surface, axis: tuple[fmpq, ...], point: tuple[fmpq, ...]) -> bool:
    """Whether the surface is one of revolution about the line."""
    if isinstance(surface, Plane):
        return not any(cross(surface.normal[:3], axis))
    x, y, z = axis
    nil = fmpq(0)
    p, q, r = cross(point, axis)
    generator = fmpq_mat([[nil, -z, y, p], [z, nil, -x, q], [-y, x, nil, r], [nil] * 4])
    form = fmpq_mat([list(row) for row in surface.form])
    change = generator.transpose() * form + form * generator
    return not any(change.entries())
