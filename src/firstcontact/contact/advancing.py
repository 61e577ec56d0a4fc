"""Bodies that turn about one direction, or shift, and advance along it at constant speed meanwhile.

Bodies that are the same at all heights share points exactly while these meet, which is a span of time, and the bodies
do as they would without the advance.  So the same question of a tall one, without the advance and about that span
alone, has the same answer; and times of turns are exact where those of screws are not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from flint import fmpq

from firstcontact.exact.numbers import above, below
from firstcontact.exact.rigid import rational_sqrt
from firstcontact.exact.vectors import Vector, cross, dot, scaled, sub
from firstcontact.motion.moving import Moving
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw
from firstcontact.motion.translation import Translation
from firstcontact.result import ContactInterval, ContactIntervals, Status
from firstcontact.timeline.answers import enclosing
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.motion.kinds import AnyMotion


class Apart(NamedTuple):
    """That the heights of two bodies do not meet."""


class Upright(NamedTuple):
    """Of a body that is the same at all heights from low to high; between: what it is from one height to another."""

    low: fmpq
    high: fmpq
    between: Callable[[fmpq, fmpq], Body]


def axis_of_screw(query: Query) -> Vector | None:
    """Of the first body that is on one; None where none is, or the span has no end."""
    motions = [body.motion for body in query.bodies if isinstance(body, Moving)]
    return next((x.axis for x in motions if isinstance(x, Screw)), None) if query.last is not None else None


def without_advance(query: Query, upright: Callable[[Body, Vector], Upright | None]) -> Query | Apart | None:
    """The same question about the times, of bodies that keep their heights; None where it is not of that kind."""
    normal = axis_of_screw(query)
    if normal is None:
        return None
    level_a, level_b = level(query.a, normal), level(query.b, normal)
    if level_a is None or level_b is None or level_a[1] == level_b[1]:
        return None
    (a, rise_a), (b, rise_b) = level_a, level_b
    tall, other = upright(a, normal), upright(b, normal)
    if tall is None or other is None:
        return None
    rise = rise_a - rise_b
    meet = sorted(((other.low - tall.high) / rise, (other.high - tall.low) / rise))
    first, last = max(meet[0], query.first), min(meet[1], query.end)
    if first > last:
        return Apart()
    room = 1 + other.high - other.low
    return replace(query, a=tall.between(other.low - room, other.high + room), b=b, first=first, last=last)


def level(body: Body, normal: Vector) -> tuple[Body, fmpq] | None:
    """The body without its advance along the normal, and how fast its heights grow; None for other motions."""
    if not isinstance(body, Moving):
        return body, fmpq(0)
    motion: Any = body.motion
    ahead = rise_of(motion, normal)
    if ahead is None:
        return None
    if isinstance(motion, Translation):
        across = sub(motion.vector, scaled(ahead / dot(normal, normal), normal))
        return Moving(body.body, Translation(across)), ahead
    turn = Rotation(motion.axis, motion.point, **{motion.unit: motion.angle})
    return Moving(body.body, turn), ahead


def rise_of(motion: AnyMotion, normal: Vector) -> fmpq | None:
    """By how much normal . x of every point grows in a unit of the motion's time; None where not alike, or irrational.
    """
    if isinstance(motion, Translation):
        return fmpq(dot(motion.vector, normal))
    if not isinstance(motion, Rotation | Screw) or any(cross(motion.axis, normal)):
        return None
    if isinstance(motion, Rotation):
        return fmpq(0)
    length = rational_sqrt(dot(motion.axis, motion.axis))
    return None if length is None else fmpq(motion.advance / length * dot(motion.axis, normal))


def in_longer_span(found: ContactIntervals, asked: Query, query: Query) -> ContactIntervals:
    """The answer to a query whose bodies are apart at all times before and after those that were asked about."""
    later, found = found.status is Status.INITIAL_CONTACT and asked.first > query.first, enclosing(found, asked)
    return replace(
        found, intervals=tuple(_between(x, below(asked.first), above(asked.end)) for x in found.intervals),
        status=Status.CONTACT if later else found.status,
        free_until=query.span[1] if found.status is Status.FREE else found.free_until, **query.shared,
    )  # fmt: skip


def _between(x: ContactInterval, first: float, last: float) -> ContactInterval:
    """Without times before and after in the enclosures of its ends."""
    start, end = ((max(lo, first), min(hi, last)) for lo, hi in (x.start_interval, x.end_interval))
    return replace(x, start_interval=start, end_interval=end)
