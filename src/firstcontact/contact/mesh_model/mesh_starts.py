"""Does a triangle, edge or point of a polyhedron hold a point inside a model at one instant, be it ever so little?

A prism stands on either side of the triangle.  Where a convex piece of the model shares inner points with both, a
segment from one to the other passes the triangle inside that piece; a piece apart from either is apart from it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq, fmpq_poly, fmpz_poly

from firstcontact.body.solid.carriers import ONE, ZERO, dot
from firstcontact.body.solid.composite_quadric import CompositeQuadric, NoSolid
from firstcontact.contact.mesh_model.patches import bare_primitive, prisms, spanning
from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots
from firstcontact.exact.numbers import dyadic, precision, to_double
from firstcontact.exact.rigid import Matrix, apply, compose, inverse_map
from firstcontact.exact.vectors import Vector, cross, sub
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative.pieces import placement_at
from firstcontact.search.convex.convex import NotConvex, is_of_pieces
from firstcontact.search.convex.relation import Relation
from firstcontact.search.convex.resting import Place, places

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.body.polyhedron.polyhedron import Polyhedron

START = fmpq(0)


class Standing:
    """A Polyhedron and a CompositeQuadric, at rest or moving, where they are at a time t of their motions."""

    def __init__(self, mesh: Polyhedron, model: CompositeQuadric, t: fmpq) -> None:
        self.mesh, self.model, self.t = mesh, model, t
        poses = [placement_at(x, t) for x in (mesh, model)]
        self.relative: Matrix | None = None
        """The rational map from the frame of the polyhedron to that of the model."""
        if all(pose.is_exact for pose in poses):
            own, other = (pose.matrix() for pose in poses)
            self.relative = compose(inverse_map(other), own)

    @classmethod
    def posed(cls, mesh: Polyhedron, model: CompositeQuadric, relative: Matrix) -> Standing:
        """Of bodies at rest, the polyhedron in a rational pose in the frame of the model."""
        standing = cls(mesh, model, START)
        standing.relative = relative
        return standing

    def primitive(self, k: int) -> Place:
        """How a triangle, a bare edge or a bare point lies to the model, by a proof; NEAR and None: not told, but that
        they share the point, if there is one.  A point is in the model's frame."""
        mesh = shape_of(self.mesh)
        bare = k >= len(mesh.triangles)
        points = [mesh.exact_vertex(i) for i in (bare_primitive(mesh, k)[1] if bare else mesh.triangles[k].tolist())]
        if not all(isinstance(c, fmpq) for p in points for c in p):
            return Place(None)
        if not bare:
            points = [points[i] for i in spanning(points)]
        if len(points) < 3 and self.relative is None:
            return Place(None)
        if self.relative is not None:
            points = [apply(self.relative, p) for p in points]
        return self._triangle(points) if len(points) == 3 else _on_segment(points[0], points[-1], shape_of(self.model))

    def _triangle(self, points: list[Vector]) -> Place:
        if self.relative is None:
            return self._within(points)
        shared = None
        for k in range(3):
            side = _on_segment(points[k - 1], points[k], shape_of(self.model))
            if side.relation is Relation.OVERLAPPING:
                return side
            if side.point is not None:
                shared = shared or Place(side.relation, side.point)  # what is proved of a side alone stays there
        found = self._within(points)
        return found if shared is None or found.point is not None else shared

    def _within(self, points: list[Vector]) -> Place:
        """Of the inside of a triangle."""
        model = shape_of(self.model)
        sides = prisms(points)
        try:
            seen = [self._places(side) for side in sides]
        except NotConvex:
            return self._by_intersection(points, sides)
        told = bool(sides)
        for one, other in zip(*seen, strict=True):
            if Relation.APART in (one.relation, other.relation):
                continue
            told = False
            if one.relation is other.relation is Relation.OVERLAPPING:
                x = one.point if self.relative is None else _between(points, one.point, other.point)
                if is_of_pieces(model) or (self.relative is not None and model.holds_inside(x)):
                    return Place(Relation.OVERLAPPING, x)
        return Place(Relation.APART) if told else self._by_intersection(points, sides)

    def _places(self, side: CompositeQuadric) -> list[Place]:
        if self.relative is not None:
            return places(side, shape_of(self.model), START)
        return places(_following(side, self.mesh), self.model, self.t)

    def _by_intersection(self, points: list[Vector], sides: list[CompositeQuadric]) -> Place:
        """By what prisms share with the model, and the points beneath that."""
        model = shape_of(self.model)
        if self.relative is None:
            return Place(None)
        for side in sides:
            try:
                inner = (side & model).inner_point
            except NoSolid:
                return Place(Relation.APART)
            if inner is not None and model.holds_inside(x := _foot(points, inner)):
                return Place(Relation.OVERLAPPING, x)
        return Place(None)

    def world(self, x: Sequence[fmpq]) -> np.ndarray:
        """(3,) a point of the model's frame, where it is at t."""
        place = np.array([to_double(c) for c in x])
        if not isinstance(self.model, Moving):
            return place
        pose = self.model.motion(to_double(self.t))
        moved: np.ndarray = pose[:3, :3] @ place + pose[:3, 3]
        return moved


def _on_segment(p: Vector, q: Vector, model: CompositeQuadric) -> Place:
    """Of the segment from p to q: between two surfaces that it passes it is in, out, or on one of them."""
    way = sub(q, p)
    passes = fmpz_poly([1])
    for surface in model.surfaces:
        form, x, v = surface.matrix(), (*p, ONE), (*way, ZERO)
        image = [dot(row, v) for row in form]
        along = fmpq_poly([dot(x, [dot(row, x) for row in form]), 2 * dot(image, x), dot(image, v)])
        if along.degree() > 0:
            passes *= along.numer()
    shared, outside = None, True
    for s in (START, START + 1, *_between_roots(real_roots(passes, START, START + 1))):
        at = tuple(c + s * d for c, d in zip(p, way, strict=True))
        if not model.contains_exactly(at):
            continue
        if model.holds_inside(at):
            return Place(Relation.OVERLAPPING, at)
        shared, outside = shared or at, outside and not model.is_tip(at)
    # inner points are no lone ones: the places between those on surfaces tell of all
    return Place(Relation.APART if shared is None else Relation.NEAR, shared, outside)


def _between_roots(roots: list[AlgebraicRoot]) -> list[fmpq]:
    """Numbers of [0, 1] before, between and behind the roots."""
    bits = 64
    while True:
        with precision(bits):
            balls = [root.enclosure(bits) for root in roots]
            ends = [START, *(dyadic(end) for x in balls for end in (x.lower(), x.upper())), START + 1]
        gaps = list(zip(ends[::2], ends[1::2], strict=True))
        if all(lo <= hi for lo, hi in gaps[1:-1]):
            return [(lo + hi) / 2 for lo, hi in gaps if lo < hi]
        bits *= 2


def _following(solid: CompositeQuadric, body: Body) -> Body:
    return Moving(solid, body.motion) if isinstance(body, Moving) else solid


def _between(points: list[Vector], x: Vector | None, y: Vector | None) -> Vector:
    """Where the segment from x to y, on the two sides of the triangle, passes it."""
    assert x is not None and y is not None
    n = cross(sub(points[1], points[0]), sub(points[2], points[0]))
    p, q = dot(n, sub(x, points[0])), dot(n, sub(y, points[0]))
    s = p / (p - q)
    return tuple(a + s * (b - a) for a, b in zip(x, y, strict=True))


def _foot(points: list[Vector], x: Vector) -> Vector:
    """Of the perpendicular from x on the triangle's plane."""
    n = cross(sub(points[1], points[0]), sub(points[2], points[0]))
    s = dot(n, sub(points[0], x)) / dot(n, n)
    return tuple(a + s * b for a, b in zip(x, n, strict=True))
