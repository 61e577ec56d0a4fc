"""All points of a polyhedron at its least or greatest height along a direction, exactly: triangles of a plane."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from flint import fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.exact.vectors import Vector, cross, dot

Flat = tuple[fmpq, fmpq]
Corners = tuple[Flat, Flat, Flat]


class Region(NamedTuple):
    """A part of a plane: points, and triangles of them, counterclockwise, of which no two share inner points."""

    points: list[Vector]
    triangles: list[list[int]]


def region_at(body: Polyhedron, normal: Vector, heights: Sequence[fmpq], level: fmpq) -> Region | None:
    """The body's points of that height, the least or the greatest of its vertices'.

    None where edges or corners lie there beside the triangles, where these overlap or have no area, and where their
    border passes a point twice.
    """
    number = {v: k for k, v in enumerate(v for v, height in enumerate(heights) if height == level)}
    points = [body.exact_vertex(v) for v in number]
    places = [flat(p, normal) for p in points]
    inside = [[number[v] for v in t] for t in body.triangles.tolist() if all(v in number for v in t)]
    triangles = [t if turn(*(places[v] for v in t)) > 0 else t[::-1] for t in inside]
    if not triangles or len({v for t in triangles for v in t}) < len(points):
        return None
    sides = _sides(triangles)
    if len(set(sides)) < len(sides) or not _holds_all_edges(body, number, set(sides)):
        return None
    starts = [i for i, _ in border_of(triangles)]
    corners = [(places[i], places[j], places[k]) for i, j, k in triangles]
    if len(set(starts)) < len(starts) or any(turn(*c) == 0 for c in corners) or _some_overlap(corners):
        return None
    return Region(points, triangles)


def border_of(triangles: list[list[int]]) -> list[tuple[int, int]]:
    """The sides with a triangle on their left alone."""
    sides = _sides(triangles)
    known = set(sides)
    return [(i, j) for i, j in sides if (j, i) not in known]


def flat(point: Vector, normal: Vector) -> Flat:
    """Coordinates of a point in the plane, along two directions across the normal."""
    k = min(range(3), key=lambda i: abs(normal[i]))
    first = cross(normal, [fmpq(int(k == i)) for i in range(3)])
    return dot(first, point), dot(cross(normal, first), point)


def turn(p: Flat, q: Flat, r: Flat) -> fmpq:
    """Twice the area of a triangle, positive where it is counterclockwise."""
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])


def _sides(triangles: list[list[int]]) -> list[tuple[int, int]]:
    return [side for t in triangles for side in pairwise([*t, t[0]])]


def _holds_all_edges(body: Polyhedron, number: dict[int, int], sides: set[tuple[int, int]]) -> bool:
    """Whether all edges, and sides of triangles, between these vertices are sides of the triangles there."""
    for i, j in [*body.segments.tolist(), *_sides(body.triangles.tolist())]:
        if i in number and j in number and not {(number[i], number[j]), (number[j], number[i])} & sides:
            return False
    return True


def _some_overlap(triangles: list[Corners]) -> bool:
    """Whether two of the triangles, counterclockwise ones, share inner points."""
    boxes = sorted((min(x for x, _ in t), max(x for x, _ in t), t) for t in triangles)
    for k, (_, most, t) in enumerate(boxes):
        for first, _, other in boxes[k + 1 :]:
            if first >= most:
                break
            if not (_lies_beside(t, other) or _lies_beside(other, t)):
                return True
    return False


def _lies_beside(one: Corners, other: Corners) -> bool:
    """Whether a side of the one has the other one on its right: so it is where convex polygons share no inner point."""
    return any(all(turn(p, q, r) <= 0 for r in other) for p, q in pairwise([*one, one[0]]))
