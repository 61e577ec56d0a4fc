"""Prisms along one direction that turn about it, or shift, and advance along it at constant speed meanwhile.

They share a point exactly while their heights meet, which is a span of time, and their bases meet at once.  So the same
question of a tall prism, without the advance and about that span alone, has the same answer; and times of turns are
exact where those of screws are not.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flint import fmpq

from firstcontact.contact.polyhedra.prisms import Apart, along, base_of, heights_of
from firstcontact.exact.rigid import rational_sqrt
from firstcontact.exact.vectors import Vector, cross, dot, scaled, sub
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw
from firstcontact.motion.translation import Translation
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body


def without_advance(query: Query) -> Query | Apart | None:
    """The same question about the times, of bodies that keep their heights; None where it is not of that kind."""
    motions = [body.motion for body in query.bodies if isinstance(body, Moving)]
    normal = next((x.axis for x in motions if isinstance(x, Screw)), None)
    if normal is None or query.last is None:
        return None
    level_a, level_b = _level(query.a, normal), _level(query.b, normal)
    if level_a is None or level_b is None or level_a[1] == level_b[1]:
        return None
    (a, rise_a), (b, rise_b) = level_a, level_b
    shape_a, shape_b = shape_of(a), shape_of(b)
    of_a, of_b = heights_of(shape_a, normal), heights_of(shape_b, normal)
    if not of_a or not of_b:
        return None
    base = base_of(shape_a, normal, of_a)
    if base is None or base_of(shape_b, normal, of_b) is None:
        return None
    meet = sorted(((min(of_b) - max(of_a)) / (rise_a - rise_b), (max(of_b) - min(of_a)) / (rise_a - rise_b)))
    first, last = max(meet[0], query.first), min(meet[1], query.last)
    room = 1 + max(of_b) - min(of_b)
    tall = along(base, normal, min(of_b) - room, max(of_b) + room, a)
    return Apart() if first > last else replace(query, a=tall, b=b, first=first, last=last)


def _level(body: Body, normal: Vector) -> tuple[Body, fmpq] | None:
    """The body without its advance along the normal, and how fast its heights grow; None for other motions."""
    if not isinstance(body, Moving):
        return body, fmpq(0)
    motion = body.motion
    if isinstance(motion, Translation):
        ahead = dot(motion.vector, normal)
        across = sub(motion.vector, scaled(ahead / dot(normal, normal), normal))
        return Moving(body.body, Translation(across)), ahead
    if not isinstance(motion, Rotation | Screw) or any(cross(motion.axis, normal)):
        return None
    turn = Rotation(motion.axis, motion.point, **{motion.unit: motion.angle})
    length = rational_sqrt(dot(motion.axis, motion.axis))
    if isinstance(motion, Rotation):
        return Moving(body.body, turn), fmpq(0)
    return None if length is None else (Moving(body.body, turn), motion.advance / length * dot(motion.axis, normal))
