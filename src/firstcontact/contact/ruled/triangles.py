"""Polyhedra as ruled surfaces: every triangle is a planar piece, whose rulings join a corner to the opposite side.

Surfaces share a point when a piece and a triangle do.  Between such times a solid holds each piece altogether, or
nothing of it, which one of its points tells.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.kept import Kept
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.ruled.rational_curve import RationalCurve
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.contact.reduce import as_model, is_small_and_convex
from firstcontact.contact.ruled_solid.solid_conditions import SolidConditions
from firstcontact.contact.ruled_solid.solid_touches import lies
from firstcontact.contact.signs.conditions import local_trims
from firstcontact.contact.signs.times import Times
from firstcontact.contact.signs.touches import most_of
from firstcontact.contact.signs.trimmed import inner_places
from firstcontact.contact.signs.whole_rulings import cut_to
from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import rational
from firstcontact.exact.rigid import Matrix, apply, inverse_map
from firstcontact.exact.vectors import Vector
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative import projective
from firstcontact.motion.relative.polynomial import PolynomialPiece
from firstcontact.motion.relative.sweep import swept_boxes
from firstcontact.motion.span import limits
from firstcontact.search.trees.containment import contains
from firstcontact.search.trees.frame import tree_of

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, RuledBody

SLABS = 8
"""Parts of the span over each of which the boxes of pieces must meet."""
MOST_PAIRS = 400
"""Pairs of pieces and triangles that come near each other, beyond which exact arithmetic is no way."""


_TRIANGLES = Kept[tuple[RuledSurface, ...]]()


def triangles_of(body: Polyhedron) -> tuple[RuledSurface, ...]:
    """The triangles as pieces: side 0 is the first corner, side 1 the opposite side from the second to the third.

    Kept on the body.  UnsupportedPair for bare edges and points, triangles without area and irrational poses.
    """
    return _TRIANGLES.of(body, lambda: _triangles(body))


def _triangles(body: Polyhedron) -> tuple[RuledSurface, ...]:
    who = body.name or "polyhedron"
    sides = set(body.side_edge.ravel().tolist())
    if body.irrational_pose is not None:
        raise UnsupportedPair(f"{who} is in an irrational pose; ruled surfaces meet polyhedra in rational ones")
    if not set(range(len(body.segments))) <= sides or len(np.unique(body.triangles)) < len(body.vertices):
        raise UnsupportedPair(f"{who} has bare edges or points; ruled surfaces meet polyhedra of faces only")
    points = [body.exact_vertex(i) for i in range(len(body.vertices))]
    found = []
    for k, triangle in enumerate(body.triangles.tolist()):
        a, b, c = (points[i] for i in triangle)
        diagonal = body.side_edge[k] >= len(body.edges)  # of the sides from each corner to the next
        joined = {name for name, inner in zip(("u0", "s1", "u1"), diagonal, strict=True) if inner}
        try:
            piece = RuledSurface(RationalCurve.segment(a, a), RationalCurve.segment(b, c), name=body.name)
        except InputError as error:
            raise UnsupportedPair(f"{who}: triangle {k} has no area; remove it") from error
        found.append(piece._with(joined=frozenset(joined)))
    return tuple(found)


def element_of(body: Polyhedron, triangle: int, kind: str, index: int) -> tuple[str, int]:
    """Kind and number for the polyhedron of an element of one of its triangles."""
    first, second, third = body.triangles[triangle].tolist()
    if kind == "vertex":
        return "vertex", (first, second, first, third)[index]
    if kind == "directrix" and index == 0:
        return "vertex", first
    if kind == "face":
        return "face", int(body.triangle_face[triangle])
    return "edge", int(body.side_edge[triangle][1 if kind == "directrix" else 2 * index])


def parts_of(body: Body) -> list[RuledBody]:
    """The pieces of a ruled surface, or the triangles of a polyhedron, moving as it does."""
    shape: Any = shape_of(body)
    pieces: tuple[RuledSurface, ...]
    if isinstance(shape, Polyhedron):
        pieces = triangles_of(shape)
    elif hasattr(shape, "pieces"):
        pieces = shape.pieces
    else:
        raise InputError(f"{body!r} is no ruled surface")
    return [Moving(piece, body.motion) if isinstance(body, Moving) else piece for piece in pieces]


def near_pairs(
    a_parts: list[RuledBody], b_parts: list[RuledBody], first: fmpq, last: fmpq, slabs: int = SLABS
) -> list[tuple[int, int]]:
    """Numbers of the parts whose boxes meet at some time of the span; the others share no point."""
    times = [float(first + (last - first) * fmpq(k, slabs)) for k in range(slabs + 1)]
    times[0], times[-1] = np.nextafter(times[0], -np.inf), np.nextafter(times[-1], np.inf)
    met = np.zeros((len(a_parts), len(b_parts)), bool)
    for begin, end in zip(times, times[1:], strict=False):
        (lo_a, hi_a), (lo_b, hi_b) = (_boxes(parts, begin, end) for parts in (a_parts, b_parts))
        met |= ~np.any((lo_a[:, None] > hi_b[None]) | (lo_b[None] > hi_a[:, None]), axis=2)
    return [(int(i), int(j)) for i, j in zip(*np.nonzero(met), strict=True)]


def _boxes(parts: list[RuledBody], begin: float, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Corners (k, 3) of boxes that hold the parts, all of one body, at these times; infinite for whole rulings."""
    body, span = parts[0], _within(parts[0], begin, end)
    own = [shape_of(part).bounds(span) for part in parts]
    lo, hi = (np.array([box[side] for box in own]) for side in (0, 1))
    if isinstance(body, Moving):
        ends = np.isfinite(lo).all(axis=1)
        corners = np.stack([np.where(which, hi, lo)[ends] for which in product((False, True), repeat=3)], axis=1)
        if ends.any():
            lo[ends], hi[ends] = swept_boxes(body.motion, *span, corners, 0.0)
    return lo, hi


def _within(part: RuledBody, begin: float, end: float) -> tuple[float, float]:
    """The times for which the part has poses: beyond its span, too, where the motion goes on."""
    has_poses = limits(part.motion) if isinstance(part, Moving) else None
    return (begin, end) if has_poses is None else (max(begin, float(has_poses[0])), min(end, float(has_poses[1])))


class Interior:
    """Whether the solid of the two bodies, a polyhedron, holds pieces of the ruled one, between times of contact."""

    def __init__(self, a: Body, b: Body) -> None:
        shapes = [shape_of(x) for x in (a, b)]
        self.mesh_first = isinstance(shapes[0], Polyhedron)
        self.mesh: Any
        self.mesh, self.ruled = shapes if self.mesh_first else shapes[::-1]

    @classmethod
    def of(cls, a: Body, b: Body) -> Interior | None:
        """None where neither body is a solid."""
        shapes = [shape_of(x) for x in (a, b)]
        solid = any(isinstance(x, Polyhedron) and x.solid for x in shapes)
        return cls(a, b) if solid else None

    def holds(self, motion: PolynomialPiece, x: fmpq) -> bool:
        """At this parameter of the motion, at which the surfaces share no point."""
        return any(
            self._contains(self._point(piece, *place, x), motion, x) for piece in self.ruled.pieces
            for place in inner_places(piece)
        )  # fmt: skip

    @property
    def is_convex(self) -> bool:
        """Whether the solid is one of planes that `lies` takes."""
        return is_small_and_convex(self.mesh)

    def lies(self, motion: PolynomialPiece, x: fmpq) -> str:
        """How the surface, which shares points with the convex solid at this parameter, lies to it."""
        pose = self._pose(motion, x)
        to_mesh = inverse_map(pose) if self.mesh_first else pose
        solid = as_model(self.mesh)
        found = []
        for piece in self.ruled.pieces:
            if piece.s is None:
                piece = cut_to(piece, solid.transformed([*inverse_map(to_mesh), (0, 0, 0, 1)]), (0.0, 0.0))
            sides = tuple(side.at(x).mapped(to_mesh) for side in piece.sides)
            held = SolidConditions.of(piece, (sides[0], sides[1]), solid, (x, x))
            if Times(held, (x, x)).at(AlgebraicRoot.of(x)):
                found.append(lies(held, x))
        return most_of(found)

    def shares_inner_points(self, motion: PolynomialPiece, x: fmpq) -> bool:
        """True proves that a point of the ruled body lies in the interior, at a parameter of contact."""
        return any(
            self._contains(self._point(piece, *place, x), motion, x) for piece in self.ruled.pieces
            for place in _grid(piece)
        )  # fmt: skip

    def _point(self, piece: RuledSurface, u: fmpq, s: fmpq, x: fmpq) -> Vector:
        """In the body's frame; s counts from 0 to 1."""
        first, second = ([c(u) for c in side.at(x).components] for side in piece.sides)
        return tuple(p / first[3] * (1 - s) + q / second[3] * s for p, q in zip(first[:3], second[:3], strict=True))

    def _contains(self, point: Vector, motion: PolynomialPiece, x: fmpq) -> bool:
        pose = self._pose(motion, x)
        there = apply(inverse_map(pose) if self.mesh_first else pose, point)
        return contains(self.mesh, tree_of(self.mesh), there)

    def _pose(self, motion: PolynomialPiece, x: fmpq) -> Matrix:
        rows = projective.value(motion.pose, x)
        first, second, third = (tuple(c / rows[3][3] for c in row) for row in rows[:3])
        return first, second, third


def _grid(piece: RuledSurface) -> Iterator[tuple[fmpq, fmpq]]:
    """Places of the piece."""
    lo, hi = (fmpq(-1), fmpq(1)) if piece.u is None else (rational(end, "u") for end in piece.u)
    trims = local_trims(piece)
    for r, s in product([fmpq(k, 7) for k in range(8)], repeat=2):
        u = lo + (hi - lo) * r
        if all(sum((int(c) * u**i * s**j for (i, j), c in g.items()), fmpq(0)) >= 0 for g in trims):
            yield u, s
