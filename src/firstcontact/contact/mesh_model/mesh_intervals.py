"""All times of contact of a polyhedron of any shape and a curved model, under any motion.

Free time is passed by the triangles and parity, contact by a point of the polyhedron: one of its surface, or inside it
by parity, which does not change with time; so only the model has to hold it over a stretch.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.contact.centred import intervals_anew
from firstcontact.contact.mesh_model import exactly
from firstcontact.contact.mesh_model.by_triangles import first, first_in_doubles, holds_model, lands, windows_of
from firstcontact.contact.mesh_model.lasting_mesh import LastingOfMesh
from firstcontact.contact.mesh_model.mesh_holes import search_of
from firstcontact.contact.mesh_model.sole_pair import outward_normal, sole_pair
from firstcontact.contact.mesh_model.tip_ways import TipWays, ways_of
from firstcontact.contact.models.certified import bounded
from firstcontact.contact.models.idle_turns import ignoring_idle_turns
from firstcontact.contact.ways import Passed, Way, answered, decided, tried
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import above, below, exact_value
from firstcontact.motion.moving import pose_of, shape_of
from firstcontact.motion.relative.pieces import curved_pieces
from firstcontact.motion.relative.stretches import Window
from firstcontact.result import ContactIntervals, FirstContact, Status
from firstcontact.search.convex.mesh_advance import BACK, Swept
from firstcontact.timeline.answers import likely_time, proved_intervals
from firstcontact.timeline.lasting import LastingSolid
from firstcontact.timeline.sweep import Certified, FirstTouch, Found, TimeSweep, Unproved
from firstcontact.work import Query, Spent, Work

ROUGHLY = 64
"""How many times the tolerance the time of a contact may be off when doubles are asked what touches."""
QUICK_STEPS = 3000
"""Candidates and looks between them that are made before doubles are asked: some tenths of a second."""


@ignoring_idle_turns
def intervals(query: Query) -> ContactIntervals:
    """All closed times of contact of a Polyhedron and a CompositeQuadric, in either order: soon exactly, or certified,
    else exactly.

    Raises UnsupportedPair.
    """
    ways = [
        Way("in doubles, if free", _if_free, lambda query, _: query.is_auto and query.budget is None),
        Way("soon exactly", _soon_exactly, lambda query, _: query.is_auto and query.budget is None),
        Way("by triangles", lambda query, _: decided(_by_triangles(query, False), query), _is_in_doubles),
        Way("by triangles near the origin", partial(_anew, with_exact=False), _may_be_asked_again),
        Way("with exact first contacts", partial(_anew, with_exact=True), _may_be_asked_again),
        Way("exactly", lambda query, _: decided(exactly.intervals(query), query), _may_be_exact),
    ]
    return answered(ways, query)


def _is_in_doubles(query: Query, _: ContactIntervals | None) -> bool:
    return not query.is_algebraic


def _may_be_exact(query: Query, _: ContactIntervals | None) -> bool:
    return not query.is_certified


def _if_free(query: Query, _: None) -> ContactIntervals | Passed:
    found = first_in_doubles(query)
    if found.status is not Status.FREE:
        return Passed("not free")
    return ContactIntervals.free(found.stats, **query.shared)


def _soon_exactly(query: Query, _: ContactIntervals | None) -> ContactIntervals | Passed:
    """What few candidates tell, which takes them a tenth of what doubles take."""
    found = exactly.intervals(query.limited(QUICK_STEPS))
    return Passed(str(found.reason)) if found.status is Status.UNDECIDED else found


def _by_triangles(query: Query, with_exact: bool) -> ContactIntervals:
    work = query.work()
    found = _sweep_of(query, work, with_exact).run()
    return proved_intervals(_with_landing(found, query) if with_exact else found, work, query)


def _with_landing(found: Found, query: Query) -> Found:
    """With the contact of the last instant, where all before it is decided and the bodies are proved to touch then."""
    until, last = max(exact_value(found.until), query.first), query.end
    follows, width = found.intervals and found.intervals[-1].open, exact_value(query.tolerance) * (last - query.first)
    if found.reason != "precision" or follows or not 0 < last - until <= width:
        return found
    tolerance = query.tolerance_within(until, last)
    if not lands(replace(query, first=until, tolerance=tolerance, budget=None, progress=None)):
        return found
    touch = Certified((found.until, above(last)), (below(last), above(last)))
    return Found((*found.intervals, touch), above(last), None)


def _may_be_asked_again(query: Query, proved: ContactIntervals | None) -> bool:
    """Whether doubles left anything open, with no budget of the caller's to keep."""
    return proved is not None and query.budget is None


def _anew(query: Query, proved: ContactIntervals, with_exact: bool) -> ContactIntervals | Passed:
    """What doubles left open, told from more digits, of bodies away from the origin; or by exact arithmetic too."""
    found = intervals_anew(lambda near: _by_triangles(near, with_exact), query)
    if found is None and not with_exact:
        return Passed("they are at the origin")
    found = _by_triangles(query, with_exact) if found is None else found
    if found.status is Status.UNDECIDED and _reach(found) < _reach(proved):
        return Passed(str(found.reason), proved)
    return decided(found, query)


def _reach(found: ContactIntervals) -> float:
    assert found.free_until is not None
    return found.free_until


@ignoring_idle_turns
def first_by_points(query: Query) -> FirstContact:
    """The first contact as intervals tell it: with a point proved to be common at once after it.

    Elements are those of a bare point where no others are possible, else what is told of the time less closely.
    """
    try:
        found = _sweep_of(query, query.work(), False).first()
    except Unproved as stopped:
        raise UnsupportedPair(f"no common point is proved at {stopped.time}") from stopped
    if found is None:
        return FirstContact.free(query.stats(), **query.shared)
    times = found.lo, found.hi
    mesh_is_a = isinstance(shape_of(query.a), Polyhedron)
    bodies = query.bodies if mesh_is_a else query.bodies[::-1]
    named = sole_pair(bodies[0], bodies[1], mesh_is_a, times, found.point)
    hit = FirstContact(
        Status.CONTACT, time=likely_time(times), time_interval=times, point=found.point, free_until=found.lo,
        stats=query.stats(), **query.shared,
    )  # fmt: skip
    return replace(hit, **named) if named else _named_roughly(hit, query, mesh_is_a)


def _named_roughly(hit: FirstContact, query: Query, mesh_is_a: bool) -> FirstContact:
    """With what doubles say touches, if they tell the time to within some times the tolerance: they lack few digits."""
    rough = tried(lambda: first_in_doubles(replace(query, tolerance=ROUGHLY * query.tolerance)))
    if isinstance(rough, Passed) or rough.status is not Status.CONTACT:
        return hit
    normal = _of_face(rough, hit, mesh_is_a)
    return replace(
        hit, normal=rough.normal if normal is None else normal, element_a=rough.element_a, element_b=rough.element_b,
        multiplicity=rough.multiplicity, contact_set=rough.contact_set, stats=hit.stats + rough.stats,
    )  # fmt: skip


def _of_face(rough: FirstContact, hit: FirstContact, mesh_is_a: bool) -> np.ndarray | None:
    """The normal of the model's face that is told roughly, where the contact is; None of other elements."""
    moving_model, known = (hit.b, rough.element_b) if mesh_is_a else (hit.a, rough.element_a)
    model: CompositeQuadric = shape_of(moving_model)
    if known is None or known.kind != "face" or model.source is not None or hit.time is None or hit.point is None:
        return None
    pose, face = pose_of(moving_model, hit.time), model.faces[known.index]
    gradient = face.orientation * model.gradient(face.surfaces[0], np.linalg.solve(pose, np.append(hit.point, 1.0))[:3])
    if not gradient.any():
        return None
    return outward_normal(pose, gradient if mesh_is_a else -gradient)


def _sweep_of(query: Query, work: Work, with_exact: bool) -> _MeshSweep:
    a, b = query.bodies
    mesh_is_a = isinstance(shape_of(a), Polyhedron)
    moving_mesh, moving_model = (a, b) if mesh_is_a else (b, a)
    moving_model = bounded(moving_model, moving_mesh, query.span)
    mesh, model = shape_of(moving_mesh), shape_of(moving_model)
    parts = windows_of(a, b, query.first, query.end)
    width = query.tolerance * (parts[-1].last - parts[0].first)
    tips = None
    if ways := ways_of(model):
        tips = TipWays(mesh, ways, curved_pieces(moving_mesh, moving_model, query.first, query.end), parts)
    free = _FreeOfMesh(mesh, model, mesh_is_a, width, work)
    lasting = LastingOfMesh(mesh, LastingSolid(model), mesh_is_a, tips)

    def touches_at_start() -> np.ndarray | None:
        return first(query.at_start).point

    def between(t: float, end: float) -> FirstContact:
        span = max(exact_value(t), query.first), min(exact_value(end), query.end)
        return first(replace(query, first=span[0], last=span[1], progress=None))

    sweep = _MeshSweep(free, lasting, parts, width, work, touches_at_start)
    sweep.exactly = between if with_exact else None
    return sweep


class _MeshSweep(TimeSweep[Window]):
    """Where doubles do not tell when contact begins, exact arithmetic may be asked for the first one between two times.
    """

    exactly: Callable[[float, float], FirstContact] | None

    def first(self) -> FirstTouch | None:
        """The first contact after a start that is free; None where there is none.  Raises Open."""
        for window in self.windows:
            if not self.free.at(window, window.first):
                raise Unproved(window.first)
            found = self.touch(window, window.first, window.last)
            if found is not None and not found.sure:
                raise Unproved(found.lo)
            if found is not None:
                return found
        return None

    def touch(self, window: Window, t: float, end: float) -> FirstTouch | None:
        found = super().touch(window, t, end)
        is_forward = any(window is x for x in self.windows)  # no mirror
        if self.exactly is None or found is None or found.sure or not is_forward:
            return found
        hit = self.exactly(found.lo, end)
        if hit.status is Status.FREE:
            return None
        assert hit.free_until is not None
        lo = min(max(found.lo, hit.free_until), math.nextafter(end, t))
        hi, point = self._soon(window, lo, min(window.inner, end), [] if hit.point is None else [hit.point])
        return FirstTouch(lo, hi, point is not None, hi, point)


class _FreeOfMesh:
    """Times in which surfaces are apart.  Raises Spent: what one search may do is the budget of all."""

    def __init__(self, mesh: Polyhedron, model: CompositeQuadric, mesh_is_a: bool, width: float, work: Work) -> None:
        self.mesh, self.width, self.work = mesh, width, work
        self.search = search_of(mesh, model, mesh_is_a, work.budget)

    def at(self, window: Window, t: float) -> bool:
        here = window._replace(first=t, last=t, inner=t)
        start = self._paid(self.search.at_start(here))
        return start.status == "free" and holds_model(self.search, self.mesh, here) is False

    def _paid(self, found: Swept) -> Swept:
        if found.reason == "budget" and self.work.budget is not None:
            raise Spent
        return found

    def until(self, window: Window, t: float, end: float) -> tuple[float, list[np.ndarray]]:
        part = window._replace(first=t, last=end, inner=min(end, window.inner))
        found = self._paid(self.search.run(part, self.width, BACK * (window.last - window.first)))
        if found.status == "free":
            return end, []
        until = min(max(t, found.free_until), math.nextafter(end, t))
        if found.touch is not None:
            return until, [found.touch.point]
        first_open = min(found.open, key=lambda x: x.free_until, default=None)
        return until, [] if first_open is None else [self.search.nearest(first_open, window)]

    def near_start(self, window: Window) -> list[np.ndarray]:
        found = self._paid(self.search.at_start(window))
        return [] if found.touch is None else [found.touch.point]

    def passage(self, window: Window, t: float) -> None:
        return None
