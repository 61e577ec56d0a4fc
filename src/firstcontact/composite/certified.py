"""First contact in doubles with proofs: `search.advance` for unions of convex models, `search.events` for all others.

What they cannot settle (grazes, contact at the start) is left to exact arithmetic.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from flint import fmpq

from firstcontact.body import primitives
from firstcontact.body.composite_quadric import CompositeQuadric
from firstcontact.body.features import Face
from firstcontact.body.moving import Moving, shape_of
from firstcontact.composite.flat_contacts import Pair, Shared, keeps_directions, shared_set
from firstcontact.composite.same_point import may_touch_more, pairs_at
from firstcontact.composite.square_subproblems import refuse_untraced
from firstcontact.composite.touched import Flat, Point, is_parallel, lowest, ranked, touched, with_neighbours
from firstcontact.report import MOST_OTHERS
from firstcontact.result import ContactSet, Element, ElementPair, FirstContact, Stats, Status
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
    models = both_bounded(models, shared["span"])
    found = advance(*models, first, last, tolerance, 10_000 if budget is None else budget)
    if found.beyond:
        bodies: list[Any] = [shape_of(x) for x in models]
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


def both_bounded(models: tuple[Any, Any], span: tuple[float, float]) -> tuple[Any, Any]:
    """Both models, a resting unbounded one cut to what the other may touch."""
    a, b = models
    return bounded(a, b, span), bounded(b, a, span)


def bounded(body: Any, other: Any, span: tuple[float, float]) -> Any:
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
    assert found.time_interval is not None and found.point is not None and found.normal is not None
    place, frames = (found.point, found.normal), found.frames
    on_a = _On(models[0], found.features_a, place, (frames[0], frames[4]), "a")
    on_b = _On(models[1], found.features_b, place, (frames[1], frames[5]), "b")
    element_a, element_b = on_a.element, on_b.element
    point, multiplicity, shares = found.point, 1, None
    others: tuple[ElementPair, ...] = ()
    if not found.spread:
        flats_a = on_a.flats()
        flats_b = on_b.flats() if flats_a else []
        if not may_share_more(flats_a, flats_b):
            shares = ContactSet("point", point[None])
            if on_a.may_touch_more() or on_b.may_touch_more():
                places = (on_a.where, on_a.local_normal()), (on_b.where, on_b.local_normal())
                complete = pairs_at(models, _wholes(models), found, places, shared)
                if complete is not None:
                    stats = Stats(found.steps, found.gaps, seconds=clock.perf_counter() - begin)
                    return replace(complete, stats=stats)
        elif (flat := _flat_set(models, found, [x for x, _ in flats_a], [x for x, _ in flats_b])) is not None:
            shares = ContactSet(flat.kind, flat.points)
            (element_a, element_b, where), *rest = _named(models, found, flat.pairs)
            point, multiplicity = np.array(where), len(rest) + 1
            others = tuple(ElementPair(x, y) for x, y, _ in rest[:MOST_OTHERS])
    return FirstContact(
        Status.CONTACT, found.time, found.time_interval, None, point, found.normal, element_a, element_b,
        others, multiplicity, shares, free_until=found.time_interval[0],
        stats=Stats(found.steps, found.gaps, seconds=clock.perf_counter() - begin), **shared,
    )  # fmt: skip


def _flat_set(models: tuple[Any, Any], found: Advance, flats_a: list[Flat], flats_b: list[Flat]) -> Shared | None:
    """What flat things around the contact share, where that is told without algebra."""
    if not (keeps_directions(models[0]) and keeps_directions(models[1])):
        return None
    assert found.point is not None
    wholes = _wholes(models)
    also = None
    if found.complete and found.also is not None:
        also = [(_surfaces(wholes[0], x), _surfaces(wholes[1], y)) for x, y in found.also]
    return shared_set(wholes, _shifts(found), (flats_a, flats_b), tuple(found.point.tolist()), also)


def _surfaces(model: CompositeQuadric, features: tuple[tuple[str, int], ...]) -> set[int]:
    return {k for kind, index in features for k in touched(model, kind, index).feature.surfaces}


def _named(models: tuple[Any, Any], found: Advance, pairs: list[Pair]) -> list[tuple[Element, Element, Point]]:
    """Each pair of elements once, with where it meets, lowest first; for bodies that only shift."""
    (model_a, model_b), (shift_a, shift_b) = _wholes(models), _shifts(found)
    seen: dict[tuple[tuple[int, int], tuple[int, int]], tuple[Element, Element, Point]] = {}
    for x, y, where in pairs:
        in_a = where if model_a.source is None else tuple(np.subtract(where, shift_a).tolist())
        in_b = where if model_b.source is None else tuple(np.subtract(where, shift_b).tolist())
        rank_a, element_a = ranked(model_a, x, "a", in_a)
        rank_b, element_b = ranked(model_b, y, "b", in_b)
        seen.setdefault((rank_a, rank_b), (element_a, element_b, where))
    return [seen[ranks] for ranks in sorted(seen)]


def _wholes(models: tuple[Any, Any]) -> tuple[CompositeQuadric, CompositeQuadric]:
    a: Any
    b: Any
    a, b = (shape_of(x) for x in models)
    return a.whole or a, b.whole or b


def _shifts(found: Advance) -> tuple[Point, Point]:
    (x, y, z), (p, q, r) = found.frames[0][9:12], found.frames[1][9:12]
    return (x, y, z), (p, q, r)


Flats = Sequence[tuple[Flat | None, Point | None]]
"""What is flat around a contact, with its direction in the world, None of a plane."""


def on_model(
    body: Any,
    features: tuple[tuple[str, int], ...],
    place: tuple[np.ndarray, np.ndarray],
    frame: tuple[list[float], list[float]],
    which: str,
) -> tuple[Element, list[tuple[Flat, Point | None]]]:
    """The lowest of the touched features, and what is flat around the contact.

    place: its point and normal, world frame; frame: pose (R by rows, T) of the body then, and R^-1.
    """
    there = _On(body, features, place, frame, which)
    return there.element, there.flats()


class _On:
    """A body at a contact: arguments as for `on_model`.

    element: the lowest of the touched features.
    """

    def __init__(
        self, body: Any, features: tuple[tuple[str, int], ...], place: tuple[np.ndarray, np.ndarray],
        frame: tuple[list[float], list[float]], which: str,
    ) -> None:
        self.model: Any = shape_of(body)
        self.pose, inverse = frame
        self.normal = place[1]
        x, y, z = place[0].tolist()
        x, y, z = x - self.pose[9], y - self.pose[10], z - self.pose[11]
        self.where = (
            inverse[0] * x + inverse[1] * y + inverse[2] * z,
            inverse[3] * x + inverse[4] * y + inverse[5] * z,
            inverse[6] * x + inverse[7] * y + inverse[8] * z,
        )
        self.known = [touched(self.model, kind, index) for kind, index in features]
        self.element = lowest(self.known, which, self.where)

    def may_touch_more(self) -> bool:
        """Whether features around the touched one may touch in the same point."""
        if all(isinstance(x.feature, Face) for x in self.known):
            return False
        own = {k for x in self.known for k in x.feature.surfaces}
        return may_touch_more(self.known[0].model, list(own), (self.where, self.local_normal()))

    def local_normal(self) -> Point:
        """The contact's normal in the frame of the body."""
        pose = self.pose
        p, q, r = self.normal.tolist()
        return (
            pose[0] * p + pose[3] * q + pose[6] * r,
            pose[1] * p + pose[4] * q + pose[7] * r,
            pose[2] * p + pose[5] * q + pose[8] * r,
        )

    def flats(self) -> list[tuple[Flat, Point | None]]:
        """What is flat around the contact, with its direction in the world, None of a plane."""
        pose, n = self.pose, self.local_normal()
        around = with_neighbours(self.known, self.where)
        return [(flat, _turned(pose, flat.direction)) for feature in around for flat in feature.flats(self.where, n)]


def _turned(pose: list[float], d: Point | None) -> Point | None:
    if d is None:
        return None
    return (
        pose[0] * d[0] + pose[1] * d[1] + pose[2] * d[2],
        pose[3] * d[0] + pose[4] * d[1] + pose[5] * d[2],
        pose[6] * d[0] + pose[7] * d[1] + pose[8] * d[2],
    )


def may_share_more(a: Flats, b: Flats) -> bool:
    """Whether flat features may share more than a point."""
    return any(d is None or e is None or is_parallel(d, e) for _, d in a for _, e in b)
