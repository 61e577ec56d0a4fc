"""What is proved of a torus and a point that meets it, see `points`, from a time on at which doubles end."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.torus.between import Between, PosedBody, pose_of
from firstcontact.contact.torus.cells import square
from firstcontact.contact.torus.heights import Beyond, FormHeights, Ring
from firstcontact.contact.torus.points import Event, PointCourse, TrackedPoint, points_of, reach_of, vertex_of
from firstcontact.exact.numbers import above, below, exact_value
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.stretches import Window
from firstcontact.search.convex.close_up import Passage, Stretch
from firstcontact.search.trees.frame import tree_of
from firstcontact.timeline.sweep import Pass

if TYPE_CHECKING:
    from firstcontact.body import kinds
    from firstcontact.contact.torus.free import TorusFree

NEAR = fmpq(1, 1000)
"""Of the span: how far off an event may be."""
AHEAD = fmpq(1, 10**6)
"""Of the span: how far the next look reaches where there is none."""


class Passages:
    """side: the body that is no torus."""

    def __init__(
        self, free: TorusFree, bodies: tuple[kinds.Body, kinds.Body], side: int, span: tuple[fmpq, fmpq]
    ) -> None:
        self.free, self.span, self.side = free, span, side
        self.bodies = bodies[side], bodies[1 - side]
        self.torus: Any = shape_of(bodies[1 - side])
        self.shape: Any = shape_of(bodies[side])
        self.courses: dict[tuple[int, float], PointCourse | None] = {}

    @cached_property
    def points(self) -> list[TrackedPoint]:
        """Of a model; those of a polyhedron are made when they are asked for."""
        return points_of(self.shape)

    @cached_property
    def corners(self) -> np.ndarray | None:
        """(n, 3) of a polyhedron."""
        return tree_of(self.shape).corners if isinstance(self.shape, Polyhedron) else None

    @cached_property
    def places(self) -> np.ndarray:
        """(n, 3) points in doubles, in their body's frame."""
        if self.corners is not None:
            owned = np.zeros(len(self.shape.vertices), bool)
            owned[self.corners] = True
            return np.where(owned[:, None], self.shape.vertices, np.nan)
        return np.array([point.in_doubles for point in self.points]).reshape(-1, 3)

    def passage(self, window: Window, t: float) -> Pass | None:
        """From t on; None where nothing is proved."""
        course = self._course(window, t)
        if course is None:
            return None
        later = [x for x in course.events if x.hi >= exact_value(t)]
        stretches, graze, instant = self._stretches(course, later, max(exact_value(t), course.span[0]))
        if not stretches or not self._is_proved(window, course.point, stretches):
            return None
        point = self._place(window, course.point, above(stretches[-1].hi)) if stretches[-1].contact else None
        return Pass(Passage(stretches, graze), point, instant)

    def touched_at_start(self, window: Window) -> tuple[np.ndarray, bool] | None:
        """(a point that is on the torus just at the start, whether that is proved to be the only common one)."""
        course = self._course(window, window.first)
        if course is None or not any(x.exact == self.span[0] for x in course.events):
            return None
        alone = self._is_proved(window, course.point, [Stretch(False, self.span[0], self.span[0])])
        return self._place(window, course.point, window.first), alone

    def nearest_place(self, window: Window, t: float) -> np.ndarray:
        """Where the point is that is nearest to the surface of the torus."""
        course = self._course(window, t)
        assert course is not None
        return self._place(window, course.point, t)

    def _place(self, window: Window, point: TrackedPoint, t: float) -> np.ndarray:
        """In the world."""
        pose = pose_of(self._tables(window)[0], t)
        place: np.ndarray = pose[:3, :3] @ point.in_doubles + pose[:3, 3]
        return place

    def _course(self, window: Window, t: float) -> PointCourse | None:
        """Of the point that is nearest to the torus' surface, inside the window, within which poses do not jump."""
        k = self._nearest(window, t)
        if k is None:
            return None
        known = k, window.first
        if known not in self.courses:
            first = exact_value(window.first)
            first = self.span[0] if first <= self.span[0] else exact_value(math.nextafter(window.first, math.inf))
            last = self.span[1] if exact_value(window.last) >= self.span[1] else exact_value(window.inner)
            point = self.points[k] if self.corners is None else vertex_of(self.shape, self.corners, k)
            self.courses[known] = None
            if point is not None and first <= last:
                self.courses[known] = PointCourse(point, self.bodies, self.torus, (first, last))
        return self.courses[known]

    def _stretches(
        self, course: PointCourse, later: list[Event], start: fmpq
    ) -> tuple[list[Stretch], tuple[fmpq, fmpq] | None, fmpq | None]:
        """Until the next event and beyond, with the time of a graze; none where nothing is known."""
        span, width, limit = self.span[1] - self.span[0], exact_value(self.free.width), course.span[1]
        if not later or later[0].lo - start > NEAR * span:
            state, end = course.state_at(start), min(limit, start + AHEAD * span)
            return ([] if state is None or end <= start else [Stretch(state, start, end)]), None, None
        event = later[0]
        end = min(limit, event.hi + 4 * abs(event.lo - start) + 64 * width)
        if len(later) > 1:
            end = min(end, (event.hi + later[1].lo) / 2)
        if event.lo <= start:  # it is on the torus there
            first = Stretch(True, start, start)
            return ([first] if event.after is None else [first, Stretch(event.after, event.hi, end)]), None, None
        if event.before is None:
            return [], None, None
        if event.after is None or end <= event.hi:  # at the last instant
            return [Stretch(event.before, start, event.lo), Stretch(True, event.hi, event.hi)], None, None
        before, after = Stretch(event.before, start, event.lo), Stretch(event.after, event.hi, end)
        if event.before and event.after:
            return [Stretch(True, start, end)], None, None
        is_graze = not event.before and not event.after
        instant = (event.lo + event.hi) / 2 if is_graze else None
        return [before, after], (event.lo, event.hi) if is_graze else None, instant

    def _is_proved(self, window: Window, point: TrackedPoint, stretches: list[Stretch]) -> bool:
        """Whether the rest of the body is out of the torus all the time, where the point is not in it all the time."""
        if all(x.contact for x in stretches):
            return True
        lo, hi = below(stretches[0].lo), above(stretches[-1].hi)
        own, other = self._tables(window)
        frame = point.in_doubles + np.vstack([np.zeros(3), np.eye(3)])
        off = 2.0**-52 * float(np.abs(frame).max())
        between = Between(PosedBody(own, np.eye(4), off), PosedBody(other, square(self.torus.pose), 0.0))
        places = between.places(lo, hi, frame[None])
        reach = reach_of(point, places, self.torus)
        if reach is None:
            return False
        heights = self.free.roles.heights
        if isinstance(heights, FormHeights):
            beyond = Beyond(heights, point.in_doubles - heights.pose[:3, 3], reach[0] - 4.0 * off)
        else:
            assert isinstance(heights, Ring)
            beyond = Beyond(heights, places.points[0, 0], reach[1])
        if self.free.meet_over(window, (lo, hi), beyond):
            return False
        return stretches[-1].contact or not self.free.holds_torus(window, hi)

    def _nearest(self, window: Window, t: float) -> int | None:
        if not len(self.places):
            return None
        own, other = (pose_of(table, t) for table in self._tables(window))
        way = np.linalg.solve(other @ square(self.torus.pose), own)
        x, (major, minor) = self.places @ way[:3, :3].T + way[:3, 3], self.torus.radii
        return int(np.nanargmin(np.abs(np.hypot(np.hypot(x[:, 0], x[:, 1]) - major, x[:, 2]) - minor)))

    def _tables(self, window: Window) -> tuple[np.ndarray, np.ndarray]:
        return (window.a, window.b) if self.side == 0 else (window.b, window.a)
