"""Parts that move in one plane, as flat links and plates on one table do, as prisms along its normal.

Where level faces of both lie in one plane they slide in one another for ever, which no enclosure of the motion tells
from a touch.  Of convex prisms P x [a, b] and Q x [c, d] along the normal, which the motion keeps, all of that is idle:
they are apart at all times where [a, b] and [c, d] are, and else share a point exactly when P and Q do.  So a taller
prism stands for one of them, whose level faces lie beyond the other body: the question about the times is the same.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from flint import fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.planar import is_across
from firstcontact.contact.reduce import as_model
from firstcontact.contact.ways import Passed, tried
from firstcontact.exact.numbers import fraction
from firstcontact.exact.vectors import Vector, cross, dot
from firstcontact.motion.linkage import Linkage
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.product import Product
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw
from firstcontact.motion.sequence import Sequence
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

MOST_VERTICES = 200
"""Of a prism that is looked at: each is put to each side of the outline."""


class Prism(NamedTuple):
    """A convex prism along a direction: its outline, points in order around it, and its least and greatest height.

    Heights are products with the direction, which need not be a unit vector.
    """

    outline: list[Vector]
    least: fmpq
    most: fmpq


class Apart(NamedTuple):
    """That the heights of two prisms do not meet."""


def in_one_plane(query: Query) -> Query | Apart | None:
    """The same question about the times, without level faces in one plane; None where it is not of that kind."""
    normal = _normal(query)
    if normal is None:
        return None
    a, b = (_prism(shape_of(body), normal) for body in query.bodies)
    if a is None or b is None:
        return None
    if a.most < b.least or b.most < a.least:
        return Apart()
    room = 1 + b.most - b.least
    tall = _tall(a.outline, normal, b.least - room, b.most + room, query.a.name)
    return replace(query, a=Moving(tall, query.a.motion) if isinstance(query.a, Moving) else tall)


def _normal(query: Query) -> Vector | None:
    """The normal of the plane in which both bodies turn and shift at all times; None where there is none."""
    motions = [x for body in query.bodies if isinstance(body, Moving) for x in _simple(body.motion)]
    normal = next((x.axis for x in motions if isinstance(x, Rotation | Screw)), None)
    return normal if normal is not None and all(is_across(x, normal) for x in motions) else None


def _simple(motion: Any) -> list[Any]:
    if isinstance(motion, Linkage):
        return [drive.motion for drive in motion.drives]
    if isinstance(motion, Product):
        return [factor.motion for factor in motion.factors]
    if isinstance(motion, Sequence):
        return [x for step in motion.steps for x in _simple(step)]
    return [motion]


def _prism(body: Body, normal: Vector) -> Prism | None:
    """The body as a prism, which may be flat; None where it is none."""
    if not isinstance(body, Polyhedron) or body._pose is not None or not 0 < len(body.vertices) <= MOST_VERTICES:
        return None
    used = sorted(set(body.triangles.ravel().tolist()))
    if not used or len(used) < len(body.vertices):
        return None
    points: list[Vector] = [body.exact_vertex(k) for k in used]
    heights = [dot(normal, p) for p in points]
    levels = sorted(set(heights))
    outlines = [_outline([p for p, h in zip(points, heights, strict=True) if h == level], normal) for level in levels]
    if len(levels) == 1:
        return Prism(outlines[0], levels[0], levels[0]) if _is_filled(body, points, outlines[0], normal) else None
    if len(levels) != 2 or not body.solid or isinstance(tried(lambda: as_model(body)), Passed):
        return None  # as_model takes closed convex solids alone: they are the hulls of their vertices
    low, high = ([_flat(p, normal) for p in outline] for outline in outlines)
    return Prism(outlines[0], levels[0], levels[1]) if low == high else None


def _flat(point: Vector, normal: Vector) -> tuple[fmpq, fmpq]:
    """Coordinates of a point in the plane, along two directions across the normal."""
    k = min(range(3), key=lambda i: abs(normal[i]))
    first = cross(normal, [fmpq(int(k == i)) for i in range(3)])
    return dot(first, point), dot(cross(normal, first), point)


def _outline(points: list[Vector], normal: Vector) -> list[Vector]:
    """The corners of the points' convex hull in the plane, counterclockwise from the least one (monotone chain)."""
    ordered = sorted((_flat(p, normal), p) for p in points)

    def half(chain: list[tuple[tuple[fmpq, fmpq], Vector]]) -> list[tuple[tuple[fmpq, fmpq], Vector]]:
        kept: list[tuple[tuple[fmpq, fmpq], Vector]] = []
        for corner in chain:
            while len(kept) > 1 and _turn(kept[-2][0], kept[-1][0], corner[0]) <= 0:
                kept.pop()
            kept.append(corner)
        return kept[:-1]

    return [p for _, p in half(ordered) + half(ordered[::-1])]


def _turn(p: tuple[fmpq, fmpq], q: tuple[fmpq, fmpq], r: tuple[fmpq, fmpq]) -> fmpq:
    """Twice the area of a triangle, positive where it is counterclockwise."""
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])


def _is_filled(body: Polyhedron, points: list[Vector], outline: list[Vector], normal: Vector) -> bool:
    """Whether the triangles of a flat surface cover the hull of its vertices.

    All of them turned counterclockwise, a side that no other one has in the other direction is on the hull: then their
    border goes once around it, and each point within is covered once.
    """
    flat = [_flat(p, normal) for p in points]
    sides: set[tuple[int, int]] = set()
    area = fmpq(0)
    for i, j, k in body.triangles.tolist():
        twice = _turn(flat[i], flat[j], flat[k])
        if twice < 0:
            j, k = k, j
        area += abs(twice)
        for side in ((i, j), (j, k), (k, i)):
            if side in sides:
                return False
            sides.add(side)
    corners = [_flat(p, normal) for p in outline]
    whole = sum((_turn(corners[0], p, q) for p, q in zip(corners[1:], corners[2:], strict=False)), fmpq(0))
    border = [(i, j) for i, j in sides if (j, i) not in sides]
    return area == whole > 0 and all(_on_hull(flat[i], flat[j], corners) for i, j in border)


def _on_hull(p: tuple[fmpq, fmpq], q: tuple[fmpq, fmpq], corners: list[tuple[fmpq, fmpq]]) -> bool:
    return all(_turn(p, q, r) >= 0 for r in corners)


def _tall(outline: list[Vector], normal: Vector, least: fmpq, most: fmpq, name: str | None) -> Polyhedron:
    """The prism of an outline from one height to another."""
    n, square = len(outline), dot(normal, normal)
    vertices = [
        [fraction(x + (height - dot(normal, p)) / square * c) for x, c in zip(p, normal, strict=True)]
        for height in (least, most) for p in outline
    ]  # fmt: skip
    sides = [[k, (k + 1) % n, n + (k + 1) % n, n + k] for k in range(n)]
    return Polyhedron(vertices, [list(range(n))[::-1], list(range(n, 2 * n)), *sides], solid=True, name=name)
