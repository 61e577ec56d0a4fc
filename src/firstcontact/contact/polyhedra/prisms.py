"""Parts that move in one plane, as flat links and plates on one table do, as prisms along its normal.

Where level faces of both lie in one plane they slide in one another for ever, which no enclosure of the motion tells
from a touch.  Of prisms P x [a, b] and Q x [c, d] along the normal, which the motion keeps, all of that is idle: they
are apart at all times where [a, b] and [c, d] are, and else share a point exactly when P and Q do.  So a taller prism
stands for one of them, whose level faces lie beyond the other body: the question about the times is the same.

Where the one lies on the other, so that the lowest points of the one are as high as the highest of the other, all they
can share are points of that height: prisms over these stand for both.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flint import fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.advancing import Apart, Upright
from firstcontact.contact.polyhedra.level_regions import Region, border_of, flat, region_at, turn
from firstcontact.exact.numbers import fraction
from firstcontact.exact.vectors import Vector, dot
from firstcontact.motion.linkage import Linkage
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.product import Product
from firstcontact.motion.sequence import Sequence
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.motion.kinds import AnyMotion

MOST_VERTICES = 200
"""Of a body that is looked at, exactly."""


def in_one_plane(query: Query) -> Query | Apart | None:
    """The same question about the times, without level faces in one plane; None where it is not of that kind."""
    normal = _normal(query)
    if normal is None:
        return None
    bodies = shape_of(query.a), shape_of(query.b)
    of_a, of_b = (heights_of(body, normal) for body in bodies)
    if not of_a or not of_b:
        return None
    (least, most), (low, high) = ((min(heights), max(heights)) for heights in (of_a, of_b))
    if most < low or high < least:
        return Apart()
    for level, other in ((least, high), (most, low)):
        if level == other:
            face_a, face_b = region_at(bodies[0], normal, of_a, level), region_at(bodies[1], normal, of_b, level)
            if face_a is None or face_b is None:
                return None
            tall = along(face_a, normal, level - 2, level + 2, query.a)
            return replace(query, a=tall, b=along(face_b, normal, level - 1, level + 1, query.b))
    base = base_of(bodies[0], normal, of_a)
    if base is None or base_of(bodies[1], normal, of_b) is None:
        return None
    room = 1 + high - low
    return replace(query, a=along(base, normal, low - room, high + room, query.a))


def upright(body: Body, normal: Vector) -> Upright | None:
    """Of a prism along the normal; None of others."""
    shape = shape_of(body)
    heights = heights_of(shape, normal)
    base = base_of(shape, normal, heights) if heights else None
    if base is None:
        return None
    return Upright(min(heights), max(heights), lambda least, most: along(base, normal, least, most, body))


def heights_of(body: Body, normal: Vector) -> list[fmpq]:
    """Of its vertices; none of bodies that are not looked at."""
    if not isinstance(body, Polyhedron) or body.irrational_pose is not None or len(body.vertices) > MOST_VERTICES:
        return []
    return [dot(normal, body.exact_vertex(k)) for k in range(len(body.vertices))]


def _normal(query: Query) -> Vector | None:
    """The normal of the plane in which both bodies turn and shift at all times; None where there is none."""
    motions = [x for body in query.bodies if isinstance(body, Moving) for x in _simple(body.motion)]
    normal = next((axis for x in motions for axis in x.axes or ()), None)
    return normal if normal is not None and all(x.is_across(normal) for x in motions) else None


def _simple(motion: AnyMotion) -> list[AnyMotion]:
    if isinstance(motion, Linkage):
        return [drive.motion for drive in motion.drives]
    if isinstance(motion, Product):
        return [factor.motion for factor in motion.factors]
    if isinstance(motion, Sequence):
        return [x for step in motion.steps for x in _simple(step)]
    return [motion]


def base_of(body: Polyhedron, normal: Vector, heights: list[fmpq]) -> Region | None:
    """The lower face of a body that is all that stands between its level faces, or lies in one plane and has inner
    points there; None of others.

    Walls lie along the normal and go from the one level to the other; where a side of one is slanted, another goes on
    beyond it in the same plane.  So what walls cover of a plane along the normal ends at lines along the normal alone,
    and is the same at all heights: as at the least one, where it lies on sides of level faces.  Above a point that is
    not below a wall nothing begins or ends between the levels, so a solid is there as it is at both level faces.
    """
    levels = sorted(set(heights))
    if len(levels) > 2 or len(levels) == 2 and not body.solid or len(body.bare_edges()):
        return None
    base, *top = (region_at(body, normal, heights, level) for level in levels)
    return base if None not in top and _walls_are_whole(body, normal, heights) else None


def _walls_are_whole(body: Polyhedron, normal: Vector, heights: list[fmpq]) -> bool:
    """Whether triangles that are not level lie along the normal, and go on beyond each slanted side."""
    places = [flat(body.exact_vertex(v), normal) for v in range(len(heights))]
    beyond: dict[tuple[int, int], list[fmpq]] = {}
    for triangle in body.triangles.tolist():
        if len({heights[v] for v in triangle}) == 1:
            continue
        p = [places[v] for v in triangle]
        if turn(*p) != 0 or len(set(p)) < 2:
            return False
        for k in range(3):
            i, j = sorted((triangle[k], triangle[k - 1]))
            (x, y), (u, v) = places[i], places[j]
            if heights[i] != heights[j] and (x, y) != (u, v):
                r, t = p[k - 2]
                share = ((r - x) * (u - x) + (t - y) * (v - y)) / ((u - x) ** 2 + (v - y) ** 2)
                rise = (heights[triangle[k - 2]] - heights[i]) / (heights[j] - heights[i])
                beyond.setdefault((i, j), []).append(share - rise)
    return all(len(x) == 2 and x[0] * x[1] < 0 for x in beyond.values())


def along(region: Region, normal: Vector, least: fmpq, most: fmpq, body: Body) -> Body:
    """The prism of a region from one height to another, with the name and the motion of a body."""
    n, square = len(region.points), dot(normal, normal)
    vertices = [
        [fraction(x + (height - dot(normal, p)) / square * c) for x, c in zip(p, normal, strict=True)]
        for height in (least, most) for p in region.points
    ]  # fmt: skip
    walls = [[i, j, n + j, n + i] for i, j in border_of(region.triangles)]
    lower, upper = ([[n * k + v for v in t[::1 if k else -1]] for t in region.triangles] for k in (0, 1))
    prism = Polyhedron(vertices, [*lower, *upper, *walls], solid=True, name=body.name)
    return Moving(prism, body.motion) if isinstance(body, Moving) else prism
