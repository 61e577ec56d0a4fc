"""The pairs of features that meet at one point and instant, where floats cannot tell them from such that pass nearby.

A ball that lands on an edge from straight above touches the face beside it too.  Which do is decided by exact
arithmetic for the features whose surfaces all pass near the point.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations
from typing import Any

import numpy as np

from firstcontact.body.composite_quadric import CompositeQuadric
from firstcontact.body.moving import Moving
from firstcontact.composite.algorithm import Search
from firstcontact.composite.answer import contact_of
from firstcontact.composite.moving_pair import Pair
from firstcontact.composite.touched import ACROSS, Point
from firstcontact.composite.work import Work
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import exact_value
from firstcontact.motion.polynomial import relative_pieces
from firstcontact.result import FirstContact
from firstcontact.search.advance import Advance

NEAR = 1e-7
"""Of the size of its terms: where a form is smaller than that, its surface may pass through the point."""

Place = tuple[Point, Point]
"""A point of a model and the normal of the contact, in the model's frame."""


def near_surfaces(model: CompositeQuadric, x: Point) -> list[int]:
    """The surfaces that pass through x, or nearly."""
    known = model._search.get("near")
    if known is None:
        forms = model._forms_f.reshape(-1, 16)
        far = np.append(np.abs(model.bounds()).max(axis=0) if model.bounded else np.abs(x), 1.0)
        known = forms, NEAR * (np.abs(forms) @ np.outer(far, far).ravel())
        if model.bounded:
            model._search["near"] = known
    forms, least = known
    point = np.array([*x, 1.0])
    return np.flatnonzero(np.abs(forms @ np.outer(point, point).ravel()) <= least).tolist()


def may_touch_more(model: CompositeQuadric, own: Sequence[int], place: Place) -> bool:
    """Whether faces or edges around an edge or vertex on the surfaces `own` may touch in the same point.

    Where more surfaces pass, or the normal is across one of its faces, or an edge at the vertex across the normal.
    """
    x, (p, q, r) = place
    near = near_surfaces(model, x)
    if len(near) > len(own):
        return True
    gradients = [g for g in (model._forms_f[near] @ np.array([*x, 1.0]))[:, :3].tolist() if any(g)]  # none at an apex
    square = p * p + q * q + r * r
    for a, b, c in gradients:
        u, v, w = b * r - c * q, c * p - a * r, a * q - b * p
        if u * u + v * v + w * w <= ACROSS * ACROSS * square * (a * a + b * b + c * c):
            return True
    if len(gradients) < 3:
        return False
    for (a, b, c), (d, e, f) in combinations(gradients, 2):
        u, v, w = b * f - c * e, c * d - a * f, a * e - b * d
        if abs(u * p + v * q + w * r) <= ACROSS * math.sqrt(square * (u * u + v * v + w * w)):
            return True
    return False


def pairs_at(
    bodies: tuple[Any, Any], models: tuple[CompositeQuadric, CompositeQuadric], found: Advance,
    places: tuple[Place, Place], shared: dict[str, Any],
) -> FirstContact | None:  # fmt: skip
    """The proved contact with all pairs that meet in its point; None where algebra does not take the motions."""
    assert found.time is not None and found.time_interval is not None
    lo, hi = found.time_interval
    near = tuple(frozenset(near_surfaces(model, place[0])) for model, place in zip(models, places, strict=True))
    a, b = (Moving(m, x.motion) if isinstance(x, Moving) else m for x, m in zip(bodies, models, strict=True))
    first, last = (exact_value(t) for t in shared["span"])
    try:
        for piece in relative_pieces(a, b, first, last):
            within = piece.end is not None and piece.start <= exact_value(lo) and exact_value(hi) <= piece.end
            if piece.exact and within:
                search = Search(Pair(*models, piece), Work(), near=near)  # type: ignore[arg-type]
                meetings = search.first()
                answer = contact_of(search, meetings, False, shared) if meetings else None
                if answer is not None and answer.time_interval is not None:
                    start, end = answer.time_interval
                    return answer if start <= hi and lo <= end else None
    except UnsupportedPair:
        return None
    return None
