"""First contact in doubles with proofs.

`search.convex.advance` is for unions of convex models, `search.events.events` for all others.
What they cannot settle (grazes, contact at the start) is left to exact arithmetic.
"""

from __future__ import annotations

import math
from collections.abc import Sequence as Listing
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.kept import Kept
from firstcontact.body.solid import primitives
from firstcontact.body.solid.composite_quadric import CompositeQuadric, NoSolid
from firstcontact.contact.leading import leads
from firstcontact.contact.models.kept_directions import turning_axes
from firstcontact.contact.models.shared.flat_contacts import FlatShared, Pair, shared_set
from firstcontact.contact.models.shared.same_point import may_touch_more, near_surfaces, pairs_at
from firstcontact.contact.models.shared.touched import (
    Flat,
    Flats,
    Point,
    group,
    is_parallel,
    lowest,
    ranked,
    with_neighbours,
)
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.product import Simple
from firstcontact.result import MOST_OTHERS, ContactSet, Element, ElementPair, FirstContact, Status
from firstcontact.search.convex.advance import Advance, advance
from firstcontact.search.events.events import MOST_BOXES, first_event
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Model
    from firstcontact.motion.kinds import AnyMotion

LARGEST = 2.0**60
"""Coordinates up to which an unbounded model is cut."""
MANY = 32
"""Surfaces of which a model is searched whole."""
_CUT = Kept[dict[Any, Any]]()


def settle(
    models: tuple[Model, Model], query: Query, apart: bool = False, close_up: bool = True
) -> tuple[FirstContact | None, bool, Advance]:
    """(the answer, None where there is none; whether it tells all that is shared; what was proved).

    models: both bodies of the query as models; apart: they are known to be that at the start; close_up: as `advance`
    has it.  Among features that touch at the same time the answer names one pair.
    """
    models, budget = both_bounded(models, query.span), query.budget
    most, enough = 10_000 if budget is None else budget, query.enough
    found = advance(*models, query.first, query.end, query.tolerance, most, enough=enough, close_up=close_up)
    if found.beyond:
        most = MOST_BOXES if budget is None else budget
        found = first_event(*models, query.first, query.end, query.tolerance, most, apart, enough)
    if found.status == "free":
        return FirstContact.free(query.stats(found.steps, found.gaps), **query.shared), True, found
    if found.status != "contact" or found.normal is None:
        return None, False, found
    return *contact(models, found, query), found


def both_bounded(models: tuple[Model, Model], span: tuple[float, float]) -> tuple[Model, Model]:
    """Both models, an unbounded one cut to what the other may touch."""
    a, b = models
    return bounded(a, b, span), bounded(b, a, span)


def near_models(models: tuple[Model, Model], span: tuple[float, float]) -> tuple[Model, Model]:
    """Both models, a bounded resting one of many surfaces cut to what the other may touch."""
    a, b = models
    near = [bounded(x, y, span) if shape_of(x).bounded else x for x, y in ((a, b), (b, a))]
    return near[0], near[1]


def bounded(body: Any, other: Any, span: tuple[float, float]) -> Any:
    """A model, unbounded or of many surfaces, cut to what the other may touch; one that moves, where that rests.

    That is a box around the other body's whole path.  Boxes come in powers of two, so that other motions find the cut
    model again.
    """
    model = shape_of(body)
    if model.bounded and len(model.surfaces) <= MANY:
        return body
    if isinstance(body, Moving):
        back = _turned_back(body.motion)
        if back is None or isinstance(other, Moving):
            return body
        part = bounded(model, Moving(other, back), span)
        return body if part is model else Moving(part, body.motion)
    lo, hi = other.bounds(span)
    reach = float(max(np.abs(lo).max(), np.abs(hi).max()))
    if not reach < LARGEST:
        return body
    cut = _CUT.of(body, dict)
    if body.bounded:
        cells = _cells_around(lo, hi)
        if cells not in cut:
            cut[cells] = _part_in(body, cells)
        return cut[cells]
    size = math.frexp(reach)[1] + 1
    if size not in cut:
        cut[size] = _part_around_origin(body, max(size, 1))
        cut[size].whole = body
    return cut[size]


def _part_around_origin(body: CompositeQuadric, size: int) -> CompositeQuadric:
    """What it has in the cube |x|, |y|, |z| <= 2^size, or in the next one that holds some of it."""
    while True:
        try:
            return body & primitives.box((2 ** (size + 1),) * 3)
        except NoSolid:
            size += 1


def _turned_back(motion: AnyMotion) -> AnyMotion | None:
    """The motion of the world as the body sees it; None where no motion is that."""
    return motion.paced(fmpq(-1)) if isinstance(motion, Simple) else None


Cells = tuple[tuple[int, int, int], ...]
"""Of each axis (exponent, first, last): the stretch between whole numbers of cells 2^exponent wide."""


def _cells_around(lo: np.ndarray, hi: np.ndarray) -> Cells:
    """A box that holds the one given in its interior, at most three times as long in each axis."""
    found = []
    for low, high in zip(lo.tolist(), hi.tolist(), strict=True):
        exponent = math.frexp(high - low)[1] - 1
        width = 2.0**exponent
        found.append((exponent, math.ceil(low / width) - 1, math.floor(high / width) + 1))
    return tuple(found)


def _part_in(body: CompositeQuadric, cells: Cells) -> CompositeQuadric:
    """The part of a model in the box, of the surfaces alone that pass there; all of it where these are none or most."""
    widths = [fmpq(2) ** n if n >= 0 else 1 / fmpq(2) ** -n for n, _, _ in cells]
    lo, hi = (tuple(cell[k] * width for cell, width in zip(cells, widths, strict=True)) for k in (1, 2))
    near = body.near((lo, hi))
    if near is None or 2 * len(near.surfaces) > len(body.surfaces):
        return body
    middle = [(x + y) / 2 for x, y in zip(lo, hi, strict=True)]
    block = primitives.box([y - x for x, y in zip(lo, hi, strict=True)]).translated(middle)
    try:
        part = near & block
    except NoSolid:
        return body
    part.whole = body
    return part


def contact(models: tuple[Model, Model], found: Advance, query: Query) -> tuple[FirstContact | None, bool]:
    """(the CONTACT result, None where no features are known; whether it tells all that the features share).

    Its time and elements are known at once; what else meets there is put into the terms of users when asked for.
    """
    if not found.features_a or not found.features_b:
        return None, False
    assert found.time_interval is not None and found.point is not None and found.normal is not None
    (x, y, z), n, frames = found.point.tolist(), found.normal.tolist(), found.frames
    point = x, y, z
    on_a = _On(models[0], found.features_a, point, n, (frames[0], frames[4]), "a")
    on_b = _On(models[1], found.features_b, point, n, (frames[1], frames[5]), "b")
    named: Named = [(on_a.element, on_b.element, point)]
    shares: Shares | None = None
    if not found.spread:
        flats_a = on_a.flats()
        flats_b = on_b.flats() if flats_a else []
        if not may_share_more(flats_a, flats_b):
            shares = "point", [point]
            place_a, place_b = (on_a.where, on_a.normal), (on_b.where, on_b.normal)
            sides = (on_a.known, place_a), (on_b.known, place_b)
            if any(may_touch_more(known, place, found.one_event) for known, place in sides):
                wholes = on_a.known.model, on_b.known.model
                complete = pairs_at(models, wholes, found, (place_a, place_b), query.shared)
                if complete is not None:
                    return replace(complete, stats=query.stats(found.steps, found.gaps)), True
                shares = None  # a point, but which further pairs meet there is not known
        elif (flat := _flat_set(models, (on_a, on_b), (flats_a, flats_b), found, point)) is not None:
            shares = flat.kind, flat.points
            named = _named((on_a, on_b), flat.pairs, query.bodies)
    known = {
        "status": Status.CONTACT, "time": found.time, "time_interval": found.time_interval, "time_exact": None,
        "element_a": named[0][0], "element_b": named[0][1], "initial": None, "free_until": found.time_interval[0],
        "reason": None, "stats": query.stats(found.steps, found.gaps), "subproblems": (), **query.shared,
    }  # fmt: skip
    answer = FirstContact.deferring(known, lambda: _where(named, found.normal, shares))
    return answer, shares is not None and not (len(named) == 1 and found.elsewhere)


def _where(named: Named, normal: np.ndarray | None, shares: Shares | None) -> dict[str, object]:
    """What a CONTACT result says of the place and of further pairs."""
    return {
        "point": np.array(named[0][2]),
        "normal": normal,
        "others": tuple(ElementPair(a, b) for a, b, _ in named[1 : 1 + MOST_OTHERS]),
        "multiplicity": len(named),
        "contact_set": None if shares is None else ContactSet(*shares),
    }


def _flat_set(
    models: tuple[Model, Model], on: tuple[_On, _On], flats: tuple[Flats, Flats], found: Advance, point: Point
) -> FlatShared | None:
    """What flat things around the contact share, where that is told without algebra."""
    axes = turning_axes(*models)
    if axes is None or len(axes) > 1:
        return None
    a, b = on
    also = None
    if found.also is not None and (found.complete or all(map(_is_complete, on))):
        also = [(group(a.body, x).surfaces, group(b.body, y).surfaces) for x, y in found.also]
    return shared_set((a.known.model, b.known.model), (a.pose, b.pose), flats, point, axes, also)


def _is_complete(on: _On) -> bool:
    """Whether no surface passes through the point but those of the features."""
    return on.known.surfaces.issuperset(near_surfaces(on.known.model, on.where))


def _named(on: tuple[_On, _On], pairs: list[Pair], bodies: tuple[Body, Body]) -> Named:
    """Each pair of elements once, with where it meets, lowest first, by those of the one of the bodies that leads."""
    a, b = on
    model_a, model_b = a.known.model, b.known.model
    seen: dict[tuple[tuple[int, int], tuple[int, int]], tuple[Element, Element, Point]] = {}
    for x, y, where in pairs:
        # only coplanar faces of polyhedra are told apart by where it is
        rank_a, element_a = ranked(model_a, x, "a", where if model_a.source is None else a.local(where))
        rank_b, element_b = ranked(model_b, y, "b", where if model_b.source is None else b.local(where))
        seen.setdefault((rank_a, rank_b), (element_a, element_b, where))
    a_leads = len(seen) < 2 or leads(*bodies)
    return [seen[ranks] for ranks in sorted(seen, key=lambda ranks: ranks if a_leads else ranks[::-1])]


Directions = Listing[tuple[Any, Point | None]]
"""Of flat things around a contact, in the world, None of a plane."""
Named = list[tuple[Element, Element, Point]]
"""Pairs of elements as users call them, lowest first, each with a point at which it meets, world."""
Shares = tuple[str, Listing[Point] | np.ndarray]
"""Kind and points of a `ContactSet`."""


def on_model(
    body: Model,
    features: tuple[tuple[str, int], ...],
    place: tuple[np.ndarray, np.ndarray],
    frame: tuple[list[float], list[float]],
    which: str,
) -> tuple[Element, list[tuple[Flat, Point | None]]]:
    """The lowest of the touched features, and what is flat around the contact.

    place: its point and normal, world frame; frame: pose (R by rows, T) of the body then, and R^-1.
    """
    there = _On(body, features, place[0].tolist(), place[1].tolist(), frame, which)
    return there.element, there.flats()


class _On:
    """A body at a contact: the place as plain numbers, all else as for `on_model`.

    known: the features, of the whole model where the body is a cut one; element: the lowest of them; where, normal: the
    place in the frame of the body.
    """

    __slots__ = ("body", "element", "inverse", "known", "normal", "pose", "where")

    def __init__(
        self, body: Model, features: tuple[tuple[str, int], ...], point: Point, normal: Point,
        frame: tuple[list[float], list[float]], which: str,
    ) -> None:
        self.pose, self.inverse = frame
        pose = self.pose
        self.where = self.local(point)
        p, q, r = normal
        self.normal = (
            pose[0] * p + pose[3] * q + pose[6] * r,
            pose[1] * p + pose[4] * q + pose[7] * r,
            pose[2] * p + pose[5] * q + pose[8] * r,
        )
        self.body: Any = shape_of(body)
        self.known = group(self.body, features)
        self.element = lowest(self.known, which, self.where)

    def local(self, p: Point) -> Point:
        """A world point in the frame of the body."""
        pose, inverse = self.pose, self.inverse
        x, y, z = p[0] - pose[9], p[1] - pose[10], p[2] - pose[11]
        return (
            inverse[0] * x + inverse[1] * y + inverse[2] * z,
            inverse[3] * x + inverse[4] * y + inverse[5] * z,
            inverse[6] * x + inverse[7] * y + inverse[8] * z,
        )

    def flats(self) -> list[tuple[Flat, Point | None]]:
        """What is flat around the contact, with its direction in the world, None of a plane."""
        pose, n = self.pose, self.normal
        return [
            (flat, _turned(pose, flat.direction))
            for feature in with_neighbours(self.known, self.where) for flat in feature.flats(self.where, n)
        ]  # fmt: skip


def _turned(pose: list[float], d: Point | None) -> Point | None:
    if d is None:
        return None
    return (
        pose[0] * d[0] + pose[1] * d[1] + pose[2] * d[2],
        pose[3] * d[0] + pose[4] * d[1] + pose[5] * d[2],
        pose[6] * d[0] + pose[7] * d[1] + pose[8] * d[2],
    )


def may_share_more(a: Directions, b: Directions) -> bool:
    """Whether flat features may share more than a point."""
    for _, d in a:
        for _, e in b:
            if d is None or e is None or is_parallel(d, e):
                return True
    return False
