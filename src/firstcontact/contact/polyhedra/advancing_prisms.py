"""Prisms along one direction that turn about it, or shift, and advance along it at constant speed meanwhile.

They share a point exactly while their heights meet, which is a span of time, and their bases meet at once.  So the same
question of a tall prism, without the advance and about that span alone, has the same answer; and times of turns are
exact where those of screws are not.
"""

from __future__ import annotations

from dataclasses import replace

from firstcontact.contact.advancing import Apart, axis_of_screw, level, while_heights_meet
from firstcontact.contact.polyhedra.prisms import along, base_of, heights_of
from firstcontact.motion.moving import shape_of
from firstcontact.work import Query


def without_advance(query: Query) -> Query | Apart | None:
    """The same question about the times, of bodies that keep their heights; None where it is not of that kind."""
    normal = axis_of_screw(query)
    if normal is None:
        return None
    level_a, level_b = level(query.a, normal), level(query.b, normal)
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
    low, high = min(of_b), max(of_b)
    times = while_heights_meet(query, (min(of_a), max(of_a)), (low, high), rise_a - rise_b)
    if isinstance(times, Apart):
        return times
    room = 1 + high - low
    tall = along(base, normal, low - room, high + room, a)
    return replace(query, a=tall, b=b, first=times[0], last=times[1])
