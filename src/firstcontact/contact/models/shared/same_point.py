"""The pairs of features that meet at one point and instant, where floats cannot tell them from such that pass nearby.

A ball that lands on an edge from straight above touches the face beside it too.  Which do is decided by exact
arithmetic for the features whose surfaces all pass near the point.
"""

from __future__ import annotations

import math
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.body.kept import Kept
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.contact.models.at_contact import contact_then
from firstcontact.contact.models.forms import Form, forms_of, gradient, value
from firstcontact.contact.models.shared.touched import ACROSS, Point, TouchingGroup, is_parallel
from firstcontact.contact.ways import Passed, tried
from firstcontact.result import FirstContact
from firstcontact.search.convex.advance import Advance
from firstcontact.work import Work

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.work import QuestionFields

NEAR = 1e-7
"""Of the size of its terms: where a form is smaller than that, its surface may pass through the point."""

_LIMITS = Kept[list[tuple[Form, Form | None, float]]]()
Place = tuple[Point, Point]
"""A point of a model and the normal of the contact, in the model's frame."""


def near_surfaces(model: CompositeQuadric, where: Point) -> list[int]:
    """The surfaces that pass through the point, or nearly."""
    x, y, z = where
    near = []
    for k, (linear, squares, least) in enumerate(_limits(model, where)):
        p, q, r, s = linear
        height = p * x + q * y + r * z + s
        if squares is not None:
            a, b, c, d, e, f = squares
            height += (a * x + d * y + e * z) * x + (b * y + f * z) * y + c * z * z
        if abs(height) <= least:
            near.append(k)
    return near


def _limits(model: CompositeQuadric, where: Point) -> list[tuple[Form, Form | None, float]]:
    """Of every surface the linear and square terms of its form (None of planes), and below which it nearly vanishes."""
    def limits(far: Point) -> list[tuple[Form, Form | None, float]]:
        return [(f[6:], f[:6] if any(f[:6]) else None, NEAR * value(f, *far)[1]) for f in forms_of(model)]

    if not model.bounded:
        return limits(where)
    return _LIMITS.of(model, lambda: limits(tuple(np.abs(model.bounds()).max(axis=0).tolist())))


def may_touch_more(known: TouchingGroup, place: Place, one_event: bool) -> bool:
    """Whether faces or edges around the touched feature may touch in the same point.

    Where more surfaces pass, or the normal is across one of its faces, or an edge at the vertex across the normal.
    one_event: whether other events may be at the same place, as of a face beside whose border it is.
    """
    if known.smooth and not one_event:
        return False
    (x, y, z), n = place
    near = near_surfaces(known.model, place[0])
    if len(near) > len(known.surfaces):
        return True
    if known.smooth:
        return False
    forms, gradients = forms_of(known.model), []
    for k in near:
        g = gradient(forms[k], x, y, z)
        if any(g):  # none at an apex
            if is_parallel(g, n):
                return True
            gradients.append(g)
    if len(gradients) < 3:
        return False
    p, q, r = n
    square = p * p + q * q + r * r
    for (a, b, c), (d, e, f) in combinations(gradients, 2):
        u, v, w = b * f - c * e, c * d - a * f, a * e - b * d
        if abs(u * p + v * q + w * r) <= ACROSS * math.sqrt(square * (u * u + v * v + w * w)):
            return True
    return False


def pairs_at(
    bodies: tuple[Body, Body], models: tuple[CompositeQuadric, CompositeQuadric], found: Advance,
    places: tuple[Place, Place], shared: QuestionFields,
) -> FirstContact | None:  # fmt: skip
    """The proved contact with all pairs that meet in its point; None where algebra does not take the motions."""
    on_a, on_b = (frozenset(near_surfaces(model, place[0])) for model, place in zip(models, places, strict=True))
    there = tried(lambda: contact_then(bodies, models, found, (on_a, on_b), shared, Work())[0])
    return None if isinstance(there, Passed) else there
