"""First contact in doubles with proofs: `search.advance` for unions of convex models, `search.events` for all others.

What they cannot settle (grazes, contact at the start) is left to exact arithmetic.
"""

from __future__ import annotations

import math
import time as clock
from typing import Any

import numpy as np
from flint import fmpq

from firstcontact.body import primitives
from firstcontact.body.moving import Moving
from firstcontact.composite.square_subproblems import refuse_untraced
from firstcontact.composite.touched import Flat, Point, is_parallel, lowest, touched
from firstcontact.result import ContactSet, Element, FirstContact, Stats, Status
from firstcontact.search.advance import Advance, advance
from firstcontact.search.events import MOST_BOXES, first_event

LARGEST = 2.0**60
"""Coordinates up to which an unbounded model is cut."""


def settle(
    models: tuple[Any, Any],
    first: fmpq,
    last: fmpq,
    tolerance: float,
    budget: int | None,
    begin: float,
    shared: dict[str, Any],
) -> tuple[FirstContact | None, Advance]:
    """(the answer, None where it is left to exact arithmetic; what was proved).

    models: both, at rest or moving; begin: when the query began, by `time.perf_counter`.  Among features that touch at
    the same time the answer names one pair.
    """
    models = bounded(models, shared["span"])
    found = advance(*models, first, last, tolerance, 10_000 if budget is None else budget)
    if found.beyond:
        bodies: list[Any] = [x.body if isinstance(x, Moving) else x for x in models]
        for body in bodies:
            refuse_untraced(body)
        found = first_event(*models, first, last, tolerance, MOST_BOXES if budget is None else budget)
    if found.status == "free":
        stats = Stats(found.steps, found.gaps, seconds=clock.perf_counter() - begin)
        return FirstContact(Status.FREE, free_until=shared["span"][1], stats=stats, **shared), found
    if found.status != "contact" or found.normal is None:
        return None, found
    answer = contact(models, found, begin, shared)
    return (None if answer is None or answer.contact_set is None else answer), found


def bounded(models: tuple[Any, Any], span: tuple[float, float]) -> tuple[Any, Any]:
    """Both models, a resting unbounded one cut to what the other may touch."""
    a, b = models
    return _bounded(a, b, span), _bounded(b, a, span)


def _bounded(body: Any, other: Any, span: tuple[float, float]) -> Any:
    """A resting unbounded model cut to a cube around the other body's whole path: nothing is touched beyond.

    The cube comes in powers of two, so that other motions find the cut model again.
    """
    if isinstance(body, Moving) or body.bounded:
        return body
    lo, hi = other.bounds(span)
    reach = float(max(np.abs(lo).max(), np.abs(hi).max()))
    if not reach < LARGEST:
        return body
    size = math.frexp(reach)[1] + 1
    cut = body._search.setdefault("cut", {})
    if size not in cut:
        cube = primitives.box((2 ** (size + 1),) * 3) if size > 0 else primitives.box((4, 4, 4))
        cut[size] = body & cube
        cut[size].whole = body
    return cut[size]


def contact(models: tuple[Any, Any], found: Advance, begin: float, shared: dict[str, Any]) -> FirstContact | None:
    """The CONTACT result; contact_set None where the features may share more than a point."""
    if not found.features_a or not found.features_b:
        return None
    element_a, flats_a = _touched(models[0], found, 0)
    element_b, flats_b = _touched(models[1], found, 1)
    assert found.time_interval is not None and found.point is not None
    may_share_more = found.spread or any(_may_share(x, y) for x in flats_a for y in flats_b)
    return FirstContact(
        Status.CONTACT, found.time, found.time_interval,
        point=found.point, normal=found.normal, element_a=element_a, element_b=element_b, multiplicity=1,
        contact_set=None if may_share_more else ContactSet("point", found.point[None]),
        free_until=found.time_interval[0],
        stats=Stats(found.steps, found.gaps, seconds=clock.perf_counter() - begin), **shared,
    )  # fmt: skip


def _touched(body: Any, found: Advance, side: int) -> tuple[Element, list[tuple[Flat, Point | None]]]:
    """The lowest of the touched features, and what is flat around the contact, with its direction in the world."""
    model: Any = body.body if isinstance(body, Moving) else body
    pose, inverse = found.frames[side], found.frames[4 + side]
    assert found.point is not None and found.normal is not None
    (x, y, z), (p, q, r) = found.point.tolist(), found.normal.tolist()
    x, y, z = x - pose[9], y - pose[10], z - pose[11]
    where = (
        inverse[0] * x + inverse[1] * y + inverse[2] * z,
        inverse[3] * x + inverse[4] * y + inverse[5] * z,
        inverse[6] * x + inverse[7] * y + inverse[8] * z,
    )
    n = (
        pose[0] * p + pose[3] * q + pose[6] * r,
        pose[1] * p + pose[4] * q + pose[7] * r,
        pose[2] * p + pose[5] * q + pose[8] * r,
    )
    features = [touched(model, kind, index) for kind, index in (found.features_b if side else found.features_a)]
    flats = [(flat, _turned(pose, flat.direction)) for feature in features for flat in feature.flats(where, n)]
    return lowest(features, "b" if side else "a", where), flats


def _turned(pose: list[float], d: Point | None) -> Point | None:
    if d is None:
        return None
    return (
        pose[0] * d[0] + pose[1] * d[1] + pose[2] * d[2],
        pose[3] * d[0] + pose[4] * d[1] + pose[5] * d[2],
        pose[6] * d[0] + pose[7] * d[1] + pose[8] * d[2],
    )


def _may_share(x: tuple[Flat, Point | None], y: tuple[Flat, Point | None]) -> bool:
    d, e = x[1], y[1]
    return d is None or e is None or is_parallel(d, e)
