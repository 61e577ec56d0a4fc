"""`first_contact` and `contact_intervals` of a ruled surface and a solid of planes and quadrics, certified in doubles.

Contact of a surface that lies inside the solid counts: the solid owns its interior.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.features import Edge, Face, Vertex
from firstcontact.contact.models.answer import element as element_of_solid
from firstcontact.contact.models.certified import bounded
from firstcontact.contact.named import element
from firstcontact.contact.reduce import as_model
from firstcontact.contact.ruled_solid.lasting import RuledFree, RuledLasting
from firstcontact.contact.signs.conditions import local_trims, reversed_trims
from firstcontact.contact.signs.whole_rulings import cut_to
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import exact_value
from firstcontact.motion.moving import Moving, pose_of, shape_of
from firstcontact.motion.relative.stretches import Untold, Window, windows
from firstcontact.result import ContactIntervals, ContactSet, Element, FirstContact, Status
from firstcontact.search.convex.advance import Advance
from firstcontact.search.events.charts import NotCharted
from firstcontact.search.events.event_tables import Tables
from firstcontact.search.events.events import MOST_BOXES
from firstcontact.search.events.ruled_charts import ChartSheet, RuledFeature, ruled_tables, sheets_of
from firstcontact.search.events.ruled_solids import RuledSearch, RuledSolidContact
from firstcontact.timeline.answers import proved_intervals
from firstcontact.timeline.lasting import LastingSolid
from firstcontact.timeline.sweep import TimeSweep
from firstcontact.work import Query, Work

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Model


class RuledAndSolid:
    """Both bodies over [first, last], with what the searches read of them.  Raises UnsupportedPair."""

    def __init__(self, query: Query) -> None:
        self.given = a, b = query.bodies
        self.first, self.last, self.span = query.first, query.end, query.span
        shapes = [shape_of(x) for x in (a, b)]
        self.side = 0 if hasattr(shapes[0], "pieces") else 1
        solid: Any = _as_model((a, b)[1 - self.side])
        ruled = cut_to((a, b)[self.side], solid, self.span)
        solid = bounded(solid, ruled, self.span)
        self.bodies: tuple[Body, Body] = (ruled, solid) if self.side == 0 else (solid, ruled)
        shapes[self.side] = shape_of(ruled)
        self.model: CompositeQuadric = shape_of(solid)
        try:
            trims = [(given, reversed_trims(given)) for given in map(local_trims, shapes[self.side].pieces)]
            self.sheets: list[ChartSheet] = sheets_of(shapes[self.side], trims)
            self.tables: Tables = ruled_tables(
                shapes[self.side], self.sheets, self.model, self.side, self.span
            )
            self.windows: list[Window] = windows(*self.bodies, self.first, self.last)
        except (NotCharted, Untold) as reason:
            raise UnsupportedPair(f"{a!r} and {b!r}: {reason}, which doubles do not take against solids") from reason

    def free(self, width: float, work: Work) -> RuledFree:
        return RuledFree(self.bodies, self.side, self.tables, self.sheets, self.windows, width, work)

    def lasting(self) -> RuledLasting:
        return RuledLasting(self.sheets, LastingSolid(self.model), self.side, self.windows)


def _as_model(body: Body) -> Model:
    """The solid as a model, moving if it was."""
    shape = shape_of(body)
    model = as_model(shape) if isinstance(shape, Polyhedron) else shape
    return Moving(model, body.motion) if isinstance(body, Moving) else model


def first(query: Query) -> FirstContact:
    """The first shared point with an enclosure of its time; UNDECIDED where doubles do not tell."""
    pair = RuledAndSolid(query)
    budget = MOST_BOXES if query.budget is None else query.budget
    search = RuledSearch(*pair.bodies, pair.tables, pair.windows, query.tolerance, budget, pair.side)
    contact = search.contact(query.first, query.end)
    found = contact.found
    if found.status == "open" and found.free_until <= pair.windows[0].first and found.reason == "precision":
        found = _common_at_start(pair) or found
    shared: dict[str, Any] = {**query.shared, "stats": query.stats(found.steps, found.gaps)}
    start = pair.span[0]
    if found.status == "free":
        return FirstContact.free(**shared)
    if found.status == "initial":
        return FirstContact(
            Status.INITIAL_CONTACT, start, (start, start), initial=_initial(pair, search), free_until=start, **shared
        )  # what doubles know of the place is near both bodies, not on them
    if found.status == "contact":
        return _contact(pair, contact, shared)
    soon = _soon(pair, contact, search.width)
    if soon is not None:
        lo, at, point = soon
        return FirstContact(
            Status.CONTACT, lo + 0.5 * (at - lo), (lo, at), point=point, multiplicity=1, free_until=lo, **shared
        )
    until = max(found.free_until, start)
    return FirstContact(Status.UNDECIDED, free_until=until, reason=found.reason or "precision", **shared)


def _common_at_start(pair: RuledAndSolid) -> Advance | None:
    """A point proved common at the start, where samples do not show one."""
    window, lasting = pair.windows[0], pair.lasting()
    start = window.first
    if exact_value(start) != pair.first:
        return None
    point = lasting.anywhere(window, start)
    return None if point is None else Advance("initial", start, point=lasting.in_world(window, start, point))


def _initial(pair: RuledAndSolid, search: RuledSearch) -> str | None:
    """How a surface with points inside the solid lies at the start; None where neither is proved."""
    if search.is_away_from_boundary():
        return "containment"
    return "overlapping" if search.has_points_outside(pair.first) else None


def _soon(pair: RuledAndSolid, contact: RuledSolidContact, width: float) -> tuple[float, float, np.ndarray] | None:
    """(lo, a time within the width after it, a point proved common then), where the event itself is no help."""
    if contact.boxes is None:
        return None
    lo = contact.found.free_until
    window = next((w for w in pair.windows if w.first <= lo <= w.last), None)
    lasting = pair.lasting()
    seeds = pair.free(width, Work()).places(contact.boxes[:4])
    for share in (0.25, 0.9):
        if window is None or lo + share * width > window.inner:
            return None
        at = lo + share * width
        found = lasting.deepest(window, at, seeds)
        if found is not None:
            return lo, at, lasting.in_world(window, at, found)
    return None


def _contact(pair: RuledAndSolid, contact: RuledSolidContact, shared: dict[str, Any]) -> FirstContact:
    found = contact.found
    assert found.time_interval is not None and found.point is not None
    assert contact.feature is not None and contact.other is not None
    elements: list[Element] = [
        ruled_element(pair.given[pair.side], contact.feature, contact.cut, "ab"[pair.side]),
        _solid_element(pair, contact.other, found.point, found.time or 0.0),
    ]
    first, second = elements if pair.side == 0 else elements[::-1]
    return FirstContact(
        Status.CONTACT, found.time, found.time_interval, None, found.point, found.normal, first, second,
        multiplicity=1, contact_set=ContactSet("point", found.point[None]) if contact.isolated else None,
        free_until=found.time_interval[0], **shared,
    )  # fmt: skip


def ruled_element(body: Body, feature: RuledFeature, cut: int | None, which: str) -> Element:
    """The element of a ruled surface; borders between pieces of a strip belong to its face.  cut: its inequality."""
    kind, index = ("face", 0) if feature.inner and feature.kind != "vertex" else (feature.kind, feature.index)
    if cut is not None and feature.kind == "face":
        kind, index = "edge", cut
    return element(body, kind, index, feature.sheet.number, which)


def _solid_element(pair: RuledAndSolid, feature: Face | Edge | Vertex, point: np.ndarray, time: float) -> Element:
    body = pair.given[1 - pair.side]
    pose = pose_of(body, time)
    where = np.linalg.solve(pose[:3, :3], point - pose[:3, 3])
    model = pair.model
    return element_of_solid(model, feature, "ab"[1 - pair.side], where)


def intervals(query: Query, work: Work, at_start: Callable[[], FirstContact]) -> ContactIntervals:
    """All closed times of contact, with enclosures of their ends, as far as doubles prove them.

    at_start: how the bodies lie at the start, asked where doubles do not tell.
    """
    pair = RuledAndSolid(query)
    width = query.tolerance * (pair.windows[-1].last - pair.windows[0].first)
    lasting, window = pair.lasting(), pair.windows[0]

    def touches_at_start() -> np.ndarray | None:
        told = at_start()
        if told.status is not Status.INITIAL_CONTACT or told.point is None:
            return None
        return lasting.near(window, window.first, told.point)

    found = TimeSweep(pair.free(width, work), lasting, pair.windows, width, work, touches_at_start).run()
    return proved_intervals(found, work, query)
