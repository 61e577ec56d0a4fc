"""Two models at one rational instant: do their interiors overlap, and does one hold the other?"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product
from typing import Any

import numpy as np
from flint import arb, fmpq

from firstcontact.body.solid.carriers import ONE, ZERO, Line, Plane, Point, Rows, Vector, dot, times, upright
from firstcontact.body.solid.composite_quadric import CompositeQuadric, NoSolid, joined
from firstcontact.body.solid.csg import And, Leaf, Not, Tree, inside, pattern
from firstcontact.body.solid.features import Face
from firstcontact.body.solid.neighbourhood import patterns
from firstcontact.contact.models.moving_pair import MovingPair
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.fields.number_field import ball
from firstcontact.exact.numbers import Undecidable, dyadic, precision, sign, simplest, to_double
from firstcontact.exact.rigid import Matrix, apply, inverse_map
from firstcontact.exact.vectors import cross
from firstcontact.search.convex.relation import Relation
from firstcontact.search.convex.resting import is_one_piece, relation, relation_in_doubles

BITS, TINY, LARGEST = 384, fmpq(1, 2**300), 2**128
"""Of balls in which a coordinate is looked at, how far they may be off, and denominators that are no chance."""
MOST_PLACES = 8
"""Shared points whose surroundings are looked at."""


def placed(pair: MovingPair, u: fmpq) -> CompositeQuadric:
    """Model a where it stands at u, in the frame of b; exact."""
    return pair.a.transformed([*pose_at(pair, u), (0, 0, 0, 1)])


def pose_at(pair: MovingPair, u: fmpq) -> Matrix:
    """The rational map from the frame of a to that of b at u."""
    rows = [[x(u) for x in row] for row in pair.piece.pose]
    return tuple(tuple(x / rows[3][3] for x in row) for row in rows[:3])  # type: ignore[return-value]


def pose_in_doubles(pair: MovingPair, u: fmpq) -> tuple[np.ndarray, np.ndarray]:
    """Linear part and shift of model a at u, in the frame of b, rounded."""
    pose = np.array([[to_double(x) for x in row] for row in pose_at(pair, u)])
    return pose[:, :3], pose[:, 3]


def relation_at(pair: MovingPair, u: fmpq) -> Relation | None:
    """How the two models lie to each other at u, proved; None where algebra is to tell."""
    (lo, hi), (low, high) = _box_of_a(pair, u), pair.b.bounds()
    if np.any(lo > high) or np.any(low > hi):
        return Relation.APART
    if _is_polytope(pair.a) and _is_polytope(pair.b):
        return None if _separated(pair, u) else Relation.OVERLAPPING
    return relation(pair.a, pair.b, pose_at(pair, u))


def soon_told(pair: MovingPair, u: fmpq) -> Relation | None:
    """As `relation_at`, where doubles tell it at little cost."""
    (lo, hi), (low, high) = _box_of_a(pair, u), pair.b.bounds()
    if np.any(lo > high) or np.any(low > hi):
        return Relation.APART
    return relation_in_doubles(pair.a, pair.b, pose_at(pair, u))


def overlap(pair: MovingPair, u: fmpq) -> bool | None:
    """Whether the interiors of the two models share a point at u: by a proof, else by the Boolean intersection.

    None: they come so close that neither tells.
    """
    return overlap_given(relation_at(pair, u), pair, u, [])


def overlap_given(known: Relation | None, pair: MovingPair, u: fmpq, inner: list[Vector]) -> bool | None:
    """As `overlap`, where what `relation_at` tells is known.  A common inner point that is met goes into `inner`."""
    if known is not None:
        return None if known is Relation.NEAR else known is Relation.OVERLAPPING
    if _is_polytope(pair.a) and _is_polytope(pair.b):
        return False
    common = _solid(lambda: placed(pair, u) & pair.b)
    if common is not None and common.inner_point is not None:
        inner.append(common.inner_point)
    return common is not None


def is_inner(x: Vector, pair: MovingPair, u: fmpq) -> bool:
    """Whether the point (x, y, z), in the frame of b, is inside both models at u."""
    p, q, r = x
    return pair.b.is_strict(x, True) and pair.a.is_strict(apply(inverse_map(pose_at(pair, u)), (p, q, r)), True)


def overlap_around(pair: MovingPair, u: fmpq, shared: Sequence[Vector]) -> bool:
    """As `overlap`, for models that share the points (homogeneous, exact, in the frame of b).

    Around a point that two convex models share their interiors meet, or nowhere.
    """
    known = relation_at(pair, u)
    if known is not None:
        return known is Relation.OVERLAPPING
    a, b = placed(pair, u), pair.b
    seen = [_meet_around(a, b, p) for p in map(_rational, shared[:MOST_PLACES]) if p is not None]
    if True in seen:
        return True
    return False if False in seen and is_one_piece(a) and is_one_piece(b) else overlap_given(known, pair, u, []) is True


def _rational(x: Vector) -> Vector | None:
    """The point (x, y, z), if its coordinates seem to be rational."""
    balls = [ball(c, BITS) for c in x]
    with precision(BITS):
        balls = [c / balls[3] for c in balls[:3]]
        ends = [(dyadic(arb(c.lower())), dyadic(arb(c.upper()))) for c in balls]
    found = [simplest(lo - TINY * (1 + abs(lo)), hi + TINY * (1 + abs(hi))) for lo, hi in ends]
    return tuple(found) if all(x.q < LARGEST for x in found) else None


def _meet_around(a: CompositeQuadric, b: CompositeQuadric, p: Vector) -> bool | None:
    """Whether the interiors meet arbitrarily near p; None where p is not shared, or a tip of a cone hides it."""
    surfaces, tree = joined(a.surfaces, b.surfaces, b.tree)
    x = (*p, ONE)
    signs = [sign(surface.value(x)) for surface in surfaces]
    on = [k for k, found in enumerate(signs) if found == 0]
    if not (a.contains_exactly(p) and b.contains_exactly(p)):
        return None
    both = And(a.tree, tree)
    if any(inside(both, pattern(signs, on, negative)) for negative in patterns(x, surfaces, on)):
        return True
    return False if all(any(surfaces[k].gradient(x)) for k in on) else None


def coincide(pair: MovingPair, u: fmpq) -> bool:
    """Whether a whole closed surface is a face of both at u: no edge tells, then, that the models touch."""
    if not (whole_faces(pair.a) and whole_faces(pair.b)):
        return False
    return not _whole_surfaces(placed(pair, u)).isdisjoint(_whole_surfaces(pair.b))


def _is_polytope(model: CompositeQuadric) -> bool:
    """Whether the model is bounded and the intersection of half-spaces, with rational vertices."""
    return (
        model.bounded
        and all(isinstance(surface, Plane) for surface in model.surfaces)
        and all(isinstance(vertex.carrier, Point) for vertex in model.vertices)
        and _is_conjunction(model.tree)
    )


def _is_conjunction(tree: Tree) -> bool:
    if isinstance(tree, And):
        return _is_conjunction(tree.first) and _is_conjunction(tree.second)
    return isinstance(tree, Leaf) or (isinstance(tree, Not) and isinstance(tree.inner, Leaf))


def _separated(pair: MovingPair, u: fmpq) -> bool:
    """Whether a plane along a face of one polytope, or along an edge of each, has their interiors on two sides."""
    points_a, edges_a = _skeleton(pair.a, (*pose_at(pair, u), (ZERO, ZERO, ZERO, ONE)))
    points_b, edges_b = _skeleton(pair.b, None)
    normals = [tuple(c(u) for c in form[:3]) for form in (*pair.forms_a, *pair.forms_b)]
    normals += [cross(d, e) for d in edges_a for e in edges_b]
    for n in {upright(n) for n in normals if any(n)}:
        a, b = [dot(n, p) for p in points_a], [dot(n, p) for p in points_b]
        if max(a) <= min(b) or max(b) <= min(a):
            return True
    return False


def _skeleton(model: CompositeQuadric, pose: Rows | None) -> tuple[list[Vector], list[Vector]]:
    """Vertices (x, y, z) and directions of edges, in the pose if there is one."""
    bases: list[list[Rows]] = [[], []]
    kinds: tuple[Sequence[Any], ...] = (model.vertices, model.edges)
    for k, features in enumerate(kinds):
        for feature in features:
            assert isinstance(feature.carrier, Point | Line)
            bases[k].append(feature.carrier.basis if pose is None else times(pose, feature.carrier.basis))
    points, edges = bases
    return (
        [tuple(row[0] / basis[3][0] for row in basis[:3]) for basis in points],
        [tuple(row[0] for row in basis[:3]) for basis in edges],
    )


def _box_of_a(pair: MovingPair, u: fmpq) -> tuple[np.ndarray, np.ndarray]:
    """Corners of a box around model a at u, in the frame of b: that of the turned corners of its own box."""
    lo, hi = pair.a.bounds()
    if not np.all(np.isfinite([lo, hi])):
        return np.full(3, -np.inf), np.full(3, np.inf)
    turned, shift = pose_in_doubles(pair, u)
    corners = np.array(list(product(*zip(lo, hi, strict=True))))
    moved = corners @ turned.T + shift
    # entries, products and sums: a handful of roundings relative to the sizes of the terms
    pad = 1e-14 * (np.abs(corners) @ np.abs(turned).T + np.abs(shift)).max(axis=0)
    return moved.min(axis=0) - pad, moved.max(axis=0) + pad


def is_containment(pair: MovingPair, u: fmpq) -> bool:
    """Whether one model holds the other at u, for models whose interiors overlap and whose features touch nowhere."""
    if coincide(pair, u):
        return False
    a, b = placed(pair, u), pair.b
    return _solid(lambda: a - b) is None or _solid(lambda: b - a) is None


def whole_faces(model: CompositeQuadric) -> list[Face]:
    """The faces that nothing bounds."""
    bounded = {k for edge in (*model.edges, *model.seams) for k in edge.faces}
    return [face for face in model.faces if face.index not in bounded]


def _whole_surfaces(model: CompositeQuadric) -> set[Vector]:
    """Of the faces that nothing bounds, as forms up to a factor."""
    forms = (face.carrier.matrix() for face in whole_faces(model))
    return {upright(tuple(x for row in form for x in row)) for form in forms}


def _solid(combination: Callable[[], CompositeQuadric]) -> CompositeQuadric | None:
    """The combination; None where it has no interior points.  UnsupportedPair where its edges are too near to tell."""
    try:
        return combination()
    except NoSolid:
        return None
    except Undecidable as error:
        raise UnsupportedPair("precision: what the bodies share at rest is not told") from error
