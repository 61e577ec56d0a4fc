"""Whether two bodies share a point at an instant at which the one is on the level top, or below the bottom, of another.

The other one is the same at all heights, so that a point at the height they have in common is in it exactly when it is
within its outline.  A point of the first body is taken at its lowest (or highest), exactly, and followed to the pose of
the instant in balls; its height needs none.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.kept import Kept
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.heights.meeting import Ascents, Span, speed_of, steps_in
from firstcontact.contact.heights.ranges import points_at
from firstcontact.contact.polyhedra.level_regions import Region
from firstcontact.contact.polyhedra.prisms import along, base_of, heights_of
from firstcontact.contact.reduce import as_model, is_small_and_convex
from firstcontact.contact.upright_parts import upright
from firstcontact.contact.ways import Passed, tried
from firstcontact.exact.numbers import above, ball, below, precision, to_double
from firstcontact.exact.rigid import Matrix, apply, compose, inverse_map
from firstcontact.exact.vectors import Vector, dot, scaled
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative.curved import terms
from firstcontact.motion.relative.pieces import curved_pieces, placement_at
from firstcontact.motion.translation import Translation
from firstcontact.result import FirstContact, Status
from firstcontact.timeline.lasting import LastingSolid
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.body.solid.composite_quadric import CompositeQuadric

BITS = 128
MOST_POINTS = 40
"""That are looked at in balls."""
MOST_TRIANGLES = 32
"""Of a level face whose points are looked at by triangles."""


def common_point(query: Query, ascents: Ascents, time: fmpq, span: Span | None = None) -> np.ndarray | None:
    """(3,) one that is proved at an instant at which the one body is on the other; None where none is.

    span: times about the instant in which a point of one of the bodies is to stay in the other one.
    """
    first, last = span or (time, time)
    for k, gap in enumerate(ascents.gaps_at(time)):
        if gap == 0:
            for which in (k, 1 - k):  # a point of the one above at its lowest, or of the one below at its highest
                height = ascents.ranges[which][0 if which == k else 1]
                if ascents.has_from(which, height, first, last):
                    found = _point_of(query, which, ascents.normal, height, (first, last))
                    if found is not None:
                        return found
    return None


def _point_of(query: Query, which: int, normal: Vector, height: fmpq, span: Span) -> np.ndarray | None:
    """A point of the body, at that height in its own frame, that the outline of the other one holds all the time."""
    body, other = query.bodies[which], query.bodies[1 - which]
    parts = _tall(shape_of(other), normal)
    if not parts:
        return None
    with precision(BITS):
        own, poses = _pose(body, span[0]), list(_relative(body, other, span))
        seen_from = _doubles(inverse_map(poses[0]))
        for tall in parts:
            point = _point_in(tall, shape_of(body), normal, height, poses, seen_from)
            if point is not None:
                return np.array([float(ball(c).mid()) for c in apply(own, point)])
    return None


def _point_in(
    tall: CompositeQuadric, shape: Any, normal: Vector, height: fmpq, poses: list[Matrix], seen_from: np.ndarray
) -> Vector | None:
    """The same of a convex part of the other body, in the frame of the first one."""
    near = _seen_in(seen_from, tall.bounds())
    if not np.isfinite(near).all():
        return None  # the times are too long for an enclosure
    solid, seen = LastingSolid(tall), 0
    for point in points_at(shape, normal, height, near):
        places = [apply(pose, tuple(ball(c) for c in point)) for pose in poses]  # type: ignore[arg-type]
        if not tall.contains(np.array([float(c.mid()) for c in places[0]])):
            continue
        if all(map(solid.holds, places)):
            return point
        seen += 1
        if seen == MOST_POINTS:
            return None
    return None


def _relative(body: Body, other: Body, span: Span) -> Iterator[Matrix]:
    """Enclosures of the pose of a body in the frame of the other one, of all times."""
    if span[0] == span[1]:
        yield compose(inverse_map(_pose(other, span[0])), _pose(body, span[0]))
        return
    for piece in curved_pieces(body, other, *span):
        with terms(1, BITS):
            rows = [[x[0] for x in row] for row in piece.series(ball(piece.start).union(ball(piece.end)))]
        yield tuple(tuple(row[:4]) for row in rows[:3])  # type: ignore[misc]


def _tall(shape: Any, normal: Vector) -> list[CompositeQuadric]:
    """A body that is the same at all heights, higher and lower than it is: parts that cover it; none of others."""
    known = _TALL.get(shape)
    if known is None or known[0] != normal:
        known = _TALL.put(shape, (normal, _parts_of(shape, normal)))
    return known[1]


_TALL = Kept[tuple[Vector, list["CompositeQuadric"]]]()


def _parts_of(shape: Any, normal: Vector) -> list[CompositeQuadric]:
    is_mesh = shape.kind == Polyhedron.kind
    if is_mesh and not shape.solid:
        return []
    if is_mesh and not is_small_and_convex(shape):
        return _of_triangles(shape, normal)
    found = upright(shape, normal)
    if found is None:
        return []
    room = found.high - found.low
    tall: Any = found.between(found.low - room, found.high + room)
    return [as_model(tall) if is_mesh else tall]


def _of_triangles(shape: Polyhedron, normal: Vector) -> list[CompositeQuadric]:
    """Of a prism of any outline: over the triangles of its lower face."""
    heights = heights_of(shape, normal)
    base = base_of(shape, normal, heights) if heights else None
    if base is None or len(base.triangles) > MOST_TRIANGLES:
        return []
    room = max(heights) - min(heights)
    regions = [Region([base.points[v] for v in corners], [[0, 1, 2]]) for corners in base.triangles]
    parts: list[Any] = [along(x, normal, min(heights) - room, max(heights) + room, shape) for x in regions]
    return [as_model(x) for x in parts]


def _pose(body: Body, time: fmpq) -> Matrix:
    rows = placement_at(body, time).matrix()
    return tuple(tuple(ball(c) for c in row) for row in rows)  # type: ignore[return-value]


def _doubles(m: Matrix) -> np.ndarray:
    return np.array([*([float(ball(c).mid()) for c in row] for row in m), [0.0, 0.0, 0.0, 1.0]])


def _seen_in(m: np.ndarray, corners: Any) -> np.ndarray:
    """(2, 3): a box around a box that is mapped by m."""
    points = np.array(list(product(*np.transpose(corners)))) @ m[:3, :3].T + m[:3, 3]
    return np.array([points.min(axis=0), points.max(axis=0)])


def landed(
    query: Query, normal: Vector, time: fmpq, ask: Callable[[Query], FirstContact], point: np.ndarray | None = None
) -> FirstContact:
    """Contact at an exact time, before which there is none.

    What meets is told of bodies that come to the instant without turning, in nearly the pose that they have then.
    point: one that they share, where that is not told.
    """
    times = below(time), above(time)
    told = FirstContact(Status.CONTACT, to_double(time), times, point=point, free_until=times[0], **query.shared)
    a, b = (_standing(body, normal, query.first, time) for body in query.bodies)
    straight = tried(lambda: ask(replace(query, a=a, b=b, last=time)))
    if isinstance(straight, Passed) or straight.status is not Status.CONTACT:
        return told
    return replace(
        told, point=straight.point, normal=straight.normal, element_a=straight.element_a, element_b=straight.element_b,
        contact_set=straight.contact_set, others=straight.others, multiplicity=straight.multiplicity,
        stats=straight.stats,
    )  # fmt: skip


def _standing(body: Body, normal: Vector, first: fmpq, time: fmpq) -> Body:
    """With the speed of the last step before the time; the pose is rational, and heights are what they are."""
    steps = steps_in(body, first, time)
    if not isinstance(body, Moving) or not steps:
        return body
    speed = speed_of(steps[-1], normal)
    assert speed is not None
    way = scaled(speed / dot(normal, normal), normal)
    there = body.body.transformed([*placement_at(body, time).near(), (0, 0, 0, 1)])
    return Moving(there.translated(scaled(-time, way)), Translation(way))
