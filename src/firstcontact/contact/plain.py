"""Motions that are plain over the span they are asked about: one shift, or the first step alone of several.

A quaternion path between two poses of one orientation, a rational motion of the first degree that does not turn, steps
that go on in one direction: what they do is a Translation, of the body in a rational pose; a sequence is the Rotation
or Screw that it begins with up to the end of that step; and a screw that only turns is a Rotation.  More is proved of
these than of motions at large.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, TypeGuard, TypeVar

from flint import fmpq

from firstcontact.body.kept import Kept
from firstcontact.contact.later import changed
from firstcontact.exact.rigid import IDENTITY, Matrix
from firstcontact.exact.vectors import Vector, scaled
from firstcontact.motion.moving import Moving, drift_of, shape_of
from firstcontact.motion.placement import HERE, advanced
from firstcontact.motion.rational import RationalMotion
from firstcontact.motion.relative.stretches import known_steps
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw, simple
from firstcontact.motion.sequence import Sequence
from firstcontact.motion.steps import Step
from firstcontact.motion.trajectory import Trajectory
from firstcontact.motion.translation import Translation
from firstcontact.result import ContactIntervals, FirstContact, Status
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Shape
    from firstcontact.body.ruled.strip import RuledStrip
    from firstcontact.body.ruled.surface import RuledSurface
    from firstcontact.motion.kinds import AnyMotion

R = TypeVar("R", FirstContact, ContactIntervals)
_OF_STEPS = RationalMotion, Sequence, Trajectory
Course = tuple[Matrix, Vector]
"""Where a body would be at time 0, and its velocity."""


PlaceKey = tuple[int, ...]
"""A pose in whole numbers, since rationals take a microsecond to hash."""


def place_key(pose: Matrix) -> PlaceKey:
    """The same for the same poses alone."""
    return tuple(int(part) for row in pose for x in row for part in (x.p, x.q))


@dataclass(frozen=True, eq=False)
class Plain:
    """A motion of bodies that stand in the pose `before` at time 0; one of its kind is made for each motion and span.
    """

    before: Matrix
    motion: Translation | Rotation | Screw

    @cached_property
    def key(self) -> PlaceKey:
        return place_key(self.before)


def deforms(body: Body) -> TypeGuard[RuledSurface | RuledStrip]:
    """Whether it is a ruled surface that changes with the time in its own place."""
    return bool(getattr(body, "deforming", False))


_START = Kept[Any]()
_PLACED = Kept[dict[tuple[PlaceKey, str | None], Any]]()
MOST_PLACED = 32
"""Copies of a shape that are kept."""


def asked(answer: Callable[[Query], R], query: Query) -> R:
    """What `answer` tells of the query, and of bodies that move as plainly as they can be told to.

    Of these alone where their ways are straight; first of these where a screw is none; else where the query itself is
    left open.
    """
    a, b = (plainly(body, query.first, query.last) for body in query.bodies)
    if a is query.a and b is query.b:
        return answer(query)
    own = replace(query, a=a, b=b)
    if drift_of(a) is not None and drift_of(b) is not None:
        return changed(answer(own), **query.shared)
    asked = (own, query) if any(map(_is_no_screw, query.bodies)) else (query, own)
    found = answer(asked[0])
    if found.status is Status.UNDECIDED and not query.is_spent(found.reason):
        told = answer(replace(asked[1], budget=query.budget_after(found.stats)))
        stats = replace(found.stats + told.stats, seconds=query.stats().seconds)
        found = found if told.status is Status.UNDECIDED else changed(told, stats=stats)
    return changed(found, **query.shared)


def plainly(body: Body, first: fmpq, last: fmpq | None) -> Body:
    """The same over these times, moved by a Translation, Rotation or Screw; the body itself where it cannot be.

    A ruled surface that deforms by shifting alone moves by a Translation, too.
    """
    if not isinstance(body, Moving):
        way = body.velocity if deforms(body) else None
        return body if way is None else Moving(_START.of(body, lambda: body.at(0)), Translation(way))
    if _is_no_screw(body):
        return Moving(body.body, simple(body.motion))
    if not isinstance(body.motion, _OF_STEPS):
        return body
    if isinstance(body.motion, Sequence) and any(first <= t and (last is None or t <= last) for t in body.motion.jumps):
        return body  # at the end of the span too, which holds the pose after it
    end = () if last is None else (int(last.p), int(last.q))
    plain = _plain(body.motion, int(first.p), int(first.q), *end)
    return body if plain is None else Moving(placed(shape_of(body), plain.before, plain.key), plain.motion)


def _is_no_screw(body: Body) -> bool:
    """Whether it moves by a screw that only turns, or only advances."""
    return isinstance(body, Moving) and simple(body.motion) is not body.motion


@lru_cache(maxsize=128)
def _plain(motion: AnyMotion, p: int, q: int, *end: int) -> Plain | None:
    """From p / q on; whole numbers, since rationals take a microsecond to hash."""
    first, last = fmpq(p, q), fmpq(*end) if end else None
    steps = [x for x in known_steps(motion) if x.end is None or (first < x.end and (last is None or x.start < last))]
    if (course := _course(steps)) is not None:
        return Plain(course[0], Translation(course[1]))
    turn = _turn(steps[0]) if len(steps) == 1 else None
    return None if turn is None else Plain(IDENTITY, turn)


def _course(steps: list[Step]) -> Course | None:
    """That which all of the steps take; None where they do not go on in one direction."""
    found: Course | None = None
    for step in steps:
        own = _of_step(step)
        if own is None or (found is not None and own != found):
            return None
        found = own
    return found


def _of_step(step: Step) -> Course | None:
    if isinstance(step.motion, Translation):
        before, way = step.before, step.motion.vector
    elif isinstance(step.motion, RationalMotion) and (told := step.motion.velocity()) is not None:
        before, way = advanced(step.before, step.motion, fmpq(0)), told
    else:
        return None
    speed = scaled(1 / step.unit, way)
    at = before.shifted(scaled(-step.origin, speed))
    return (at.matrix(), speed) if at.is_exact else None


def _turn(step: Step) -> Rotation | Screw | None:
    """The motion of a first step, told in the time of the whole."""
    motion: Any = step.motion
    if step.end is None or step.before != HERE or step.origin != 0 or not isinstance(motion, Rotation | Screw):
        return None
    return motion.paced(1 / step.unit)


def placed(shape: Shape, before: Matrix, place: PlaceKey) -> Any:
    """The shape in a pose; kept on it, by its name too, which copies have of their own."""
    if before == IDENTITY:
        return shape
    known, key = _PLACED.of(shape, dict), (place, shape.name)
    if key not in known:
        if len(known) >= MOST_PLACED:
            known.clear()
        known[key] = HERE.then(before).place(shape)
    return known[key]
