"""`first_contact` and `contact_intervals` of a torus and another body, certified."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.body.torus.torus import Torus
from firstcontact.contact.mesh_model.lasting_mesh import LastingOfMesh
from firstcontact.contact.models.idle_turns import ignoring_idle_turns
from firstcontact.contact.ruled_solid.lasting import RuledLasting
from firstcontact.contact.torus import touching
from firstcontact.contact.torus.between import pose_of
from firstcontact.contact.torus.free import MESH, RULED, TorusFree
from firstcontact.contact.torus.lasting import SolidTorus
from firstcontact.contact.torus.nets import sheets_at_rest
from firstcontact.contact.ways import Way, answered
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.numbers import above, below
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.stretches import Untold, Window, windows
from firstcontact.result import ContactIntervals, FirstContact, Status
from firstcontact.timeline.answers import likely_time, proved_intervals
from firstcontact.timeline.lasting import Lasting, LastingOfModels, LastingSolid
from firstcontact.timeline.sweep import TimeSweep
from firstcontact.work import Query, Spent, Work

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.result import Element

MOST = 500_000
"""Cells that are looked at for all times of contact where the caller set no budget: some 15 seconds."""


@ignoring_idle_turns
def first(query: Query) -> FirstContact:
    """The first shared point.  Raises UnsupportedPair."""
    _refuse_exact(query)
    return answered([Way("by cells", lambda query, _: _TorusSearch(query, query.work()).first())], query)


@ignoring_idle_turns
def intervals(query: Query) -> ContactIntervals:
    """All closed times of contact.  Raises UnsupportedPair."""
    _refuse_exact(query)
    work = query.limited(MOST).work()
    return answered([Way("by cells", lambda query, _: _TorusSearch(query, work).intervals())], query)


def _refuse_exact(query: Query) -> None:
    if query.is_algebraic:
        part = any(isinstance(x, Torus) and not x.is_whole for x in map(shape_of, query.bodies))
        other = ", or load the part with surfaces=False" if part else ""
        do = f"drop exact=True and method='algebraic'{other}"
        raise UnsupportedPair(f"times of contact with tori are not exact; {do}")


class _TorusSearch:
    def __init__(self, query: Query, work: Work) -> None:
        self.query, self.work, self.shapes = query, work, [shape_of(x) for x in query.bodies]
        try:
            self.windows = windows(query.a, query.b, query.first, query.end)
        except Untold as reason:
            raise UnsupportedPair(f"this motion is not followed: {reason}") from reason
        width = query.tolerance * (self.windows[-1].last - self.windows[0].first)
        self.lasting = _lasting(query.bodies, self.windows)
        self.free = TorusFree(query.bodies, width, work, (query.first, query.end))
        self.sweep = TimeSweep(self.free, self.lasting, self.windows, width, work, self._touched)

    def _touched(self) -> np.ndarray | None:
        found = self.free.touched_at_start(self.windows[0])
        return None if found is None else found[0]

    def intervals(self) -> ContactIntervals:
        return proved_intervals(self.sweep.run(), self.work, self.query)

    def first(self) -> FirstContact:
        self.reached = self.query.span[0]
        try:
            for k, window in enumerate(self.windows):
                found = self._in_window(window, k == 0)
                if found is not None:
                    return found
                self.reached = window.last
        except Spent:
            return self._result(Status.UNDECIDED, free_until=self.reached, reason="budget")
        return self._result(Status.FREE, free_until=self.query.span[1])

    def _in_window(self, window: Window, at_start: bool) -> FirstContact | None:
        """The answer if there is one in this window; None proves it free."""
        t = window.first
        if not self.free.at(window, t):
            point = self.lasting.anywhere(window, t)
            touched = self.free.touched_at_start(window) if point is None and at_start else None
            if touched is not None:
                kind = "touching" if touched[1] else None
                return self._result(
                    Status.INITIAL_CONTACT, initial=kind, time=t, time_interval=(t, t), point=touched[0], free_until=t
                )
            if point is None:
                return self._result(Status.UNDECIDED, free_until=self.reached, reason="precision")
            shared = {"time": t, "point": self.lasting.in_world(window, t, point), "free_until": t}
            if not at_start:  # the pose jumps; `reached` is the same time, rounded up
                return self._result(Status.CONTACT, time_interval=(t, self.reached), **shared)
            kind = self.free.lies(window, t)
            return self._result(Status.INITIAL_CONTACT, initial=kind, time_interval=(t, t), **shared)
        while True:
            touch = self.sweep.touch(window, t, window.last)
            if touch is None:
                return None
            self.reached = max(touch.lo, self.reached)
            if touch.sure:
                assert touch.point is not None
                return self._contact(window, (touch.lo, touch.hi), touch.point)
            self.work.step()
            found = self.free.passage(window, touch.lo)
            if found is None or found.passage.stretches[0].contact or below(found.passage.until) <= touch.lo:
                return self._result(Status.UNDECIDED, free_until=self.reached, reason="precision")
            passage, t = found.passage, below(found.passage.until)
            event = passage.graze or tuple(x.lo for x in passage.stretches if x.contact)
            if event:
                times = below(min(passage.stretches[0].hi, event[0])), above(event[-1])
                return self._contact(window, times, self.free.touching_at(window, times[1]))
            if t >= window.last:
                return None

    def _contact(self, window: Window, event: tuple[float, float], point: np.ndarray) -> FirstContact:
        time = likely_time(event)
        return self._result(
            Status.CONTACT, time=time, time_interval=event, free_until=event[0], multiplicity=1,
            **self._touching(window, time, point),
        )  # fmt: skip

    def _touching(self, window: Window, time: float, place: np.ndarray) -> dict[str, np.ndarray | Element | None]:
        """Point, normal and elements at a contact, near a place that the bodies share."""
        poses = [pose_of(table, time) for table in (window.a, window.b)]
        theirs = None
        if isinstance(self.lasting, RuledLasting):
            side = self.lasting.side
            theirs = touching.of_ruled(self.shapes[side], self.lasting.sheets, place, "ab"[side])
        found = touching.contact_near(self.shapes, poses, self.lasting.in_world(window, time, place), theirs)
        return {
            "point": found.point, "normal": found.normal, "element_a": found.elements[0],
            "element_b": found.elements[1],
        }  # fmt: skip

    def _result(self, status: Status, **fields: Any) -> FirstContact:
        return FirstContact(status, stats=self.query.stats(self.work.done), **fields, **self.query.shared)


def _lasting(bodies: tuple[Body, Body], parts: list[Window]) -> Lasting[Any]:
    shapes = [shape_of(x) for x in bodies]
    for k, shape in enumerate(shapes):
        if shape.kind == MESH:
            return LastingOfMesh(shape, SolidTorus(shapes[1 - k]), k == 0)
        if shape.kind == RULED:
            return RuledLasting(sheets_at_rest(shape), SolidTorus(shapes[1 - k]), k, parts)
    first, second = (SolidTorus(shape) if isinstance(shape, Torus) else LastingSolid(shape) for shape in shapes)
    return LastingOfModels(first, second)
