"""All pairs of features that meet at a contact which doubles have proved, by exact arithmetic.

It is asked about the enclosed time alone, before which nothing touches, and of bodies that shift about the surfaces
alone that pass through what their boxes share then: a contact equation without a root in so short a time costs little.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.contact.models.algorithm import CandidateSearch
from firstcontact.contact.models.answer import contact_of
from firstcontact.contact.models.forms import forms_of, gradient, value
from firstcontact.contact.models.moving_pair import MovingPair
from firstcontact.exact.numbers import exact_value, to_double
from firstcontact.motion.moving import drift_of, shape_of
from firstcontact.motion.relative.polynomial import relative_pieces
from firstcontact.result import FirstContact
from firstcontact.work import Work

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.body.solid.composite_quadric import CompositeQuadric
    from firstcontact.search.convex.advance import Advance
    from firstcontact.work import QuestionFields

ROUNDED = 1e-7
"""Of the size of its terms, and of coordinates: what doubles may be off."""

Near = tuple[frozenset[int], frozenset[int]]
"""Surfaces of either model."""


def contact_then(
    bodies: tuple[Body, Body], models: tuple[CompositeQuadric, CompositeQuadric], proved: Advance, near: Near | None,
    shared: QuestionFields, work: Work,
) -> tuple[FirstContact | None, CandidateSearch | None]:  # fmt: skip
    """(the answer, None where algebra tells none; the search that told it)

    proved: the contact; models: those to be searched, in the motions of the bodies; near: the surfaces that meet then,
    None for all.
    """
    assert proved.time_interval is not None
    first, last = map(exact_value, proved.time_interval)
    for piece in relative_pieces(*bodies, first, last):
        if not piece.exact:
            return None, None
        search = CandidateSearch(MovingPair(*models, piece), work, near=near)
        meetings = search.first()
        if meetings:
            return contact_of(search, meetings, False, shared), search
        if search.stop() is not None:
            return None, search
    return None, None


def surfaces_there(bodies: tuple[Body, Body], span: tuple[float, float]) -> Near | None:
    """The surfaces of either model that pass through the box that holds all that both may share over the span.

    None where the bodies do more than shift.
    """
    drifts = [drift for x in bodies if (drift := drift_of(x)) is not None]
    if len(drifts) < len(bodies):
        return None
    boxes: list[Any] = [x.bounds(span) for x in bodies]
    lo = np.maximum(boxes[0][0], boxes[1][0])
    hi = np.minimum(boxes[0][1], boxes[1][1])
    off = ROUNDED * max(float(np.abs(boxes).max(initial=0.0, where=np.isfinite(boxes))), 1e-300)
    found = []
    for body, drift in zip(bodies, drifts, strict=True):
        ends = np.outer(span, [to_double(x) for x in drift])
        least, most = lo - off - ends.max(axis=0), hi + off - ends.min(axis=0)
        if not np.isfinite(most - least).all():
            return None
        found.append(_passing(shape_of(body), least, most))
    return found[0], found[1]


def _passing(model: CompositeQuadric, lo: np.ndarray, hi: np.ndarray) -> frozenset[int]:
    """Surfaces that may have a point in the box."""
    x, y, z = (0.5 * (lo + hi)).tolist()
    p, q, r = (0.5 * (hi - lo)).tolist()
    far = [abs(x) + p, abs(y) + q, abs(z) + r]
    found = []
    for k, f in enumerate(forms_of(model)):
        a, b, c, d, e, g = map(abs, f[:6])
        slope = gradient(f, x, y, z)
        change = abs(slope[0]) * p + abs(slope[1]) * q + abs(slope[2]) * r
        change += a * p * p + b * q * q + c * r * r + d * p * q + e * p * r + g * q * r
        if abs(value(f, x, y, z)[0]) <= change + ROUNDED * value(f, *far)[1]:
            found.append(k)
    return frozenset(found)
