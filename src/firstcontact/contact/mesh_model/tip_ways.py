"""Triangles that the tip of a cone has passed through, in balls: behind the tip a form falls with the square of the
depth, and doubles tell inside from outside only far from it.

A segment from the tip into its convex part lies in the model.  While its ends are on two sides of a triangle's plane,
and its line passes all three sides on one hand, the triangle holds a point of it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from flint import arb, arb_series

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.exact.numbers import exact_value, to_double
from firstcontact.exact.vectors import Vector, cross, det, dot, sub
from firstcontact.motion.relative.curved import CurvedPiece, step_at, terms
from firstcontact.motion.relative.stretches import Window
from firstcontact.search.convex.convex import NotConvex, convex_pieces
from firstcontact.search.convex.tips import tips_of

if TYPE_CHECKING:
    from firstcontact.exact.ring import N, VectorOf

BITS = 192
MOST = 4
"""Triangles that one segment is tried with, those farthest behind the tip first."""


Segment = tuple[Vector, Vector]


class Pierced(NamedTuple):
    """A triangle, and a segment of the model, in its frame, that passes it."""

    triangle: int
    tip: Vector
    end: Vector


def ways_of(model: CompositeQuadric) -> list[Segment]:
    """From each tip to a point inside its convex part; none of models that are no unions of such parts."""
    try:
        solids = convex_pieces(model).solids
    except NotConvex:
        return []
    return [(_point(tip.point), _point(tip.witness)) for solid in solids for tip in tips_of(solid)]


class TipWays:
    """Of a polyhedron and a model, whose segments are `ways`.

    motions: of the polyhedron seen from the model, in order of time; forward: the windows in which time runs as in
    these, not backwards.
    """

    def __init__(
        self, mesh: Polyhedron, ways: list[Segment], motions: list[CurvedPiece], forward: list[Window]
    ) -> None:
        self.mesh, self.ways, self.motions, self.forward = mesh, ways, motions, forward
        self.corners = mesh.vertices[mesh.triangles]

    def found(self, window: Window, t: float, pose: np.ndarray) -> Iterator[Pierced]:
        """Triangles that are proved to be pierced at t; pose (3, 4): of the polyhedron seen from the model, about."""
        x = self.corners @ pose[:, :3].T + pose[:, 3]
        for way in self.ways:
            yield from (at for k in _passed(x, *way) if self.stays(window, t, t, at := Pierced(k, *way)))

    def stays(self, window: Window, t: float, end: float, pierced: Pierced) -> bool:
        """Whether the triangle is proved to be pierced over [t, end]: by the mean values of what changes its sign."""
        motion, sign = self._motion(window)
        start, length = exact_value(t), exact_value(end) - exact_value(t)
        with terms(2, BITS):
            passed = sign * (arb(length) / 2 + arb(0, 1) * arb(length) / 2)
            here = self._heights(motion.series(arb(sign * start)), pierced)
            rates = self._heights(motion.series(sign * arb(start) + passed), pierced)
            tip, inner, *sides = [x[0] + passed * y[1] for x, y in zip(here, rates, strict=True)]
            apart = (tip > 0 and inner < 0) or (tip < 0 and inner > 0)
            return apart and (all(x > 0 for x in sides) or all(x < 0 for x in sides))

    def place(self, pierced: Pierced, pose: np.ndarray) -> np.ndarray:
        """(3,) where the segment passes the triangle, in the model's frame, about; pose: as for `found`."""
        x = self.corners[pierced.triangle] @ pose[:, :3].T + pose[:, 3]
        tip, end = (np.array([to_double(c) for c in point]) for point in (pierced.tip, pierced.end))
        n = np.cross(x[1] - x[0], x[2] - x[0])
        place: np.ndarray = tip + n @ (x[0] - tip) / (n @ (end - tip)) * (end - tip)
        return place

    def _motion(self, window: Window) -> tuple[CurvedPiece, int]:
        """The step of the motion that a window is of, and the sense of time in it."""
        sign = 1 if any(window.a is x.a and window.b is x.b for x in self.forward) else -1
        middle = sign * (exact_value(window.first) + exact_value(window.last)) / 2
        return step_at(self.motions, middle), sign

    def _heights(self, pose: list[list[arb_series]], pierced: Pierced) -> list[arb_series]:
        """Of tip and end over the triangle's plane, and of its sides about the segment, as series; up to factors."""
        corners = [self.mesh.exact_vertex(i) for i in self.mesh.triangles[pierced.triangle].tolist()]
        p, q, r = ([dot(row, [arb(c) for c in x]) + row[3] for row in pose] for x in corners)
        n, way = cross(_less(q, p), _less(r, p)), [arb(c) for c in sub(pierced.end, pierced.tip)]
        tip, end = ([arb(c) for c in x] for x in (pierced.tip, pierced.end))
        x, y, z = (_less(corner, tip) for corner in (p, q, r))
        return [-dot(x, n), dot(_less(end, p), n), det(x, y, way), det(y, z, way), det(z, x, way)]


def _less(x: Iterable[N], y: Iterable[N]) -> VectorOf[N]:
    """x - y, of series or balls."""
    a, b, c = (s - t for s, t in zip(x, y, strict=True))
    return a, b, c


def _point(x: Iterable[N]) -> VectorOf[N]:
    p, q, r = x
    return p, q, r


def _passed(x: np.ndarray, tip: Vector, end: Vector) -> list[int]:
    """Of triangles (n, 3, 3) those that the segment seems to pass."""
    start, stop = (np.array([to_double(c) for c in point]) for point in (tip, end))
    way, (p, q, r) = stop - start, np.moveaxis(x - start, 1, 0)
    n = np.cross(q - p, r - p)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.einsum("nd,nd->n", n, p) / (n @ way)
    sides = np.array([np.cross(u, v) @ way for u, v in ((p, q), (q, r), (r, p))])
    room = 1e-9 * np.abs(sides).max(axis=0)
    on_one_hand = np.all(sides > -room, axis=0) | np.all(sides < room, axis=0)
    passed = np.flatnonzero(on_one_hand & (share > -1e-9) & (share < 1.0))
    return [int(k) for k in passed[np.argsort(-share[passed])][:MOST]]
