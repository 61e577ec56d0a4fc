"""All pairs of features that meet at a contact which doubles have proved, by exact arithmetic.

It is asked about the enclosed time alone, before which nothing touches, and of bodies that shift about the surfaces
alone that pass through what their boxes share then: a contact equation without a root in so short a time costs little.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.contact.models.algorithm import Search
from firstcontact.contact.models.answer import contact_of
from firstcontact.contact.models.forms import forms_of, value
from firstcontact.contact.models.moving_pair import Pair
from firstcontact.exact.numbers import exact_value
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative.polynomial import relative_pieces
from firstcontact.motion.translation import Translation
from firstcontact.result import FirstContact
from firstcontact.work import Work

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.body.solid.composite_quadric import CompositeQuadric
    from firstcontact.search.convex.advance import Advance
    from firstcontact.work import Shared

ROUNDED = 1e-7
"""Of the size of its terms, and of coordinates: what doubles may be off."""

Near = tuple[frozenset[int], frozenset[int]]
"""Surfaces of either model."""
Box = tuple[np.ndarray, np.ndarray]


def contact_then(
    bodies: tuple[Body, Body], models: tuple[CompositeQuadric, CompositeQuadric], proved: Advance, near: Near | None,
    shared: Shared, work: Work,
) -> tuple[FirstContact | None, Search | None]:  # fmt: skip
    """(the answer, None where algebra tells none; the search that told it)

    proved: the contact; models: those to be searched, in the motions of the bodies; near: the surfaces that meet then,
    None for all.
    """
    assert proved.time_interval is not None
    first, last = map(exact_value, proved.time_interval)
    for piece in relative_pieces(*bodies, first, last):
        if not piece.exact:
            return None, None
        search = Search(Pair(*models, piece), work, near=near)
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
    boxes: list[Any] = [x.bounds(span) for x in bodies]
    lo = np.maximum(boxes[0][0], boxes[1][0])
    hi = np.minimum(boxes[0][1], boxes[1][1])
    off = ROUNDED * max(float(np.abs(boxes).max(initial=0.0, where=np.isfinite(boxes))), 1e-300)
    found = []
    for body in bodies:
        shift = _shift(body, span)
        if shift is None:
            return None
        least, most = lo - off - shift[1], hi + off - shift[0]
        if not np.isfinite(most - least).all():
            return None
        found.append(_passing(shape_of(body), least, most))
    return found[0], found[1]


def _shift(body: Body, span: tuple[float, float]) -> Box | None:
    """The least and the largest vector by which the body is shifted over the span."""
    if not isinstance(body, Moving):
        return np.zeros(3), np.zeros(3)
    if not isinstance(body.motion, Translation):
        return None
    ends = np.outer(span, [float(x) for x in body.motion.vector])
    return ends.min(axis=0), ends.max(axis=0)


def _passing(model: Any, lo: np.ndarray, hi: np.ndarray) -> frozenset[int]:
    """Surfaces that may have a point in the box."""
    x, y, z = (0.5 * (lo + hi)).tolist()
    p, q, r = (0.5 * (hi - lo)).tolist()
    far = [abs(x) + p, abs(y) + q, abs(z) + r]
    found = []
    for k, f in enumerate(forms_of(model)):
        a, b, c, d, e, g = f[:6]
        change = (
            abs(2.0 * a * x + d * y + e * z + f[6]) * p + abs(d * x + 2.0 * b * y + g * z + f[7]) * q
            + abs(e * x + g * y + 2.0 * c * z + f[8]) * r
            + abs(a) * p * p + abs(b) * q * q + abs(c) * r * r + abs(d) * p * q + abs(e) * p * r + abs(g) * q * r
        )  # fmt: skip
        if abs(value(f, x, y, z)[0]) <= change + ROUNDED * value(f, *far)[1]:
            found.append(k)
    return frozenset(found)
