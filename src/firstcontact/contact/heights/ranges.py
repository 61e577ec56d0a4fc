"""Between which heights along a direction a body lies, exactly; and points of it that are as low, or high, as any."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import combinations_with_replacement, pairwise, product
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.body.solid.carriers import Plane
from firstcontact.body.solid.composite_quadric import CompositeQuadric, NoSolid
from firstcontact.body.solid.primitives import half_space
from firstcontact.contact.models.advancing import height_of
from firstcontact.contact.polyhedra.prisms import heights_of
from firstcontact.contact.reduce import as_model, is_small_and_convex
from firstcontact.errors import InputError
from firstcontact.exact.numbers import exact_value, rational, simplest, to_double
from firstcontact.exact.vectors import Vector, add, cross, dot, scaled

if TYPE_CHECKING:
    from firstcontact.body.ruled.rational_curve import RationalCurve

Heights = tuple[fmpq, fmpq]

ACROSS = 13
"""Points each way of the grid in which points of level faces are sought."""
WITHIN = 6
"""Parts of the sides of a triangle, in which its points are looked at."""
ALONG = 24
"""Points of a level curve that are looked at."""
INWARD = 1e-6
"""Of a solid's size: how far within it next to a level face its points are looked at in doubles."""


def heights(shape: Any, normal: Vector) -> Heights | None:
    """(lowest, highest) of normal . x; None where it is not told, as of round bodies."""
    told = _HEIGHTS.get(shape.kind)
    found = [] if told is None else told(shape, normal)
    return (min(found), max(found)) if found else None


def _of_solid(solid: CompositeQuadric, normal: Vector) -> list[fmpq]:
    """Of its level faces, where nothing lies beyond them."""
    if not solid.bounded or solid.whole is not None:
        return []
    planes = (face.carrier for face in solid.faces)
    level = [x for x in planes if isinstance(x, Plane) and not any(cross(x.normal[:3], normal))]
    found = [height_of(x, normal) for x in level]
    if not found:
        return []
    beyond = (normal, min(found)), (scaled(fmpq(-1), normal), -max(found))
    return found if all(_is_nothing_below(solid, *x) for x in beyond) else []


def _is_nothing_below(solid: CompositeQuadric, normal: Vector, height: fmpq) -> bool:
    """Whether that is proved; not of what is too large or too small to be cut."""
    try:
        solid & half_space(normal, height)
    except NoSolid:
        return True
    except InputError:
        return False
    return False


def _of_ruled(shape: Any, normal: Vector) -> list[fmpq]:
    parts = [] if shape.deforming else [_of_piece(piece, normal) for piece in shape.pieces]
    return [h for part in parts for h in part] if all(parts) else []


def _of_piece(piece: RuledSurface, normal: Vector) -> list[fmpq]:
    """Of the ends of its sides; none where a side may go beyond its ends."""
    if piece.s is None:
        return []
    found = []
    for side in piece.sides:
        own = _of_curve(side, piece, normal)
        if not own:
            return []
        found += own
    return found


def _of_curve(curve: RationalCurve, piece: RuledSurface, normal: Vector) -> list[fmpq]:
    """Of a level curve, or the ends of a line."""
    level = curve.height(normal)
    if level is not None:
        return [level]
    if piece.u is None or curve.degree > 1 or curve.components[3].degree() > 0:
        return []
    return [dot(normal, curve.place(rational(u, "u"))) for u in piece.u]


_HEIGHTS: dict[str, Callable[[Any, Vector], list[fmpq]]] = {
    Polyhedron.kind: heights_of, CompositeQuadric.kind: _of_solid, RuledSurface.kind: _of_ruled
}


# -- points at a height ---------------------------------------------------------------------------------------


def points_at(shape: Any, normal: Vector, level: fmpq, near: np.ndarray) -> Iterator[Vector]:
    """Exact points of the body at its least or greatest height; near (2, 3): corners of a box in which they are sought.
    """
    if shape.kind == Polyhedron.kind:
        yield from (p for p, h in _vertices(shape, normal) if h == level)
        if is_small_and_convex(shape):
            yield from _of_faces(as_model(shape), normal, level, near)
        else:
            yield from _of_triangles(shape, normal, level)
    elif shape.kind == CompositeQuadric.kind:
        yield from _of_faces(shape, normal, level, near)
    else:
        for piece in shape.pieces:
            yield from _of_sides(piece, normal, level)


def _vertices(shape: Polyhedron, normal: Vector) -> Iterator[tuple[Vector, fmpq]]:
    """The vertices of its triangles and edges, or its bare points: others belong to nothing."""
    used = np.unique(np.concatenate([shape.triangles.ravel(), shape.segments.ravel()]))
    for k in used.tolist() or range(len(shape.vertices)):
        p = shape.exact_vertex(k)
        yield p, dot(normal, p)


def _of_triangles(shape: Polyhedron, normal: Vector, level: fmpq) -> Iterator[Vector]:
    """Within triangles of that height, as fractions of their corners."""
    heights = {k: dot(normal, shape.exact_vertex(k)) for k in np.unique(shape.triangles).tolist()}
    for corners in shape.triangles.tolist():
        if all(heights[k] == level for k in corners):
            p, q, r = (shape.exact_vertex(k) for k in corners)
            for i, j in combinations_with_replacement(range(1, WITHIN), 2):
                shares = fmpq(i, WITHIN), fmpq(j - i, WITHIN), fmpq(WITHIN - j, WITHIN)
                yield add(scaled(shares[0], p), add(scaled(shares[1], q), scaled(shares[2], r)))


def _of_faces(solid: CompositeQuadric, normal: Vector, level: fmpq, near: np.ndarray) -> Iterator[Vector]:
    """In the plane of that height, of a grid."""
    first = max((cross(normal, e) for e in _UNITS), key=lambda v: dot(v, v))
    second, square = cross(normal, first), dot(normal, normal)
    ways = [np.array([to_double(c) for c in v]) for v in (first, second)]
    own = np.array(solid.bounds())
    near = np.array([np.maximum(near[0], own[0]), np.minimum(near[1], own[1])])
    if (near[0] > near[1]).any():
        return
    corners = np.array(list(product(*near.T)))
    sides = [np.sort([(corners @ w / (w @ w)).min(), (corners @ w / (w @ w)).max()]) for w in ways]
    grid = [[simplest(exact_value(lo), exact_value(hi)) for lo, hi in _parts(side)] for side in sides]
    foot = scaled(level / square, normal)
    n = np.array([to_double(c) for c in normal])
    size = float(np.abs(np.subtract(*solid.bounds())).max())
    inward = INWARD * size / float(np.linalg.norm(n)) * n
    for x, y in product(*grid):
        p = add(foot, add(scaled(x, first), scaled(y, second)))
        rough = np.array([to_double(c) for c in p])
        if solid.contains(np.array([rough - inward, rough + inward])).any() and solid.contains_exactly(p):
            yield p


_UNITS = [tuple(fmpq(int(i == k)) for i in range(3)) for k in range(3)]


def _parts(side: np.ndarray) -> Iterator[tuple[float, float]]:
    lo, hi = side.tolist()
    yield from pairwise(np.linspace(lo, hi, ACROSS + 1).tolist())


def _of_sides(piece: RuledSurface, normal: Vector, level: fmpq) -> Iterator[Vector]:
    """On those of its sides that are level; of a level piece between them."""
    sides = [_of_curve(side, piece, normal) == [level] for side in piece.sides]
    if not any(sides):
        return
    s = [fmpq(k, 8) for k in range(9)] if all(sides) else [fmpq(sides.index(True))]
    for u in _parameters(piece):
        ends = [side.place(u) for side in piece.sides]
        for r in s:
            p = add(scaled(1 - r, ends[0]), scaled(r, ends[1]))
            if not piece.trim or _is_kept(piece, u, r):
                yield p


def _parameters(piece: RuledSurface) -> Iterator[fmpq]:
    if piece.u is None:  # the whole line: both halves, as by tan of half an angle
        ends = np.tan(np.linspace(-1.5, 1.5, ALONG)).tolist()
        yield from (simplest(exact_value(x), exact_value(y)) for x, y in pairwise(ends))
    else:
        lo, hi = (rational(u, "u") for u in piece.u)
        yield from (lo + (hi - lo) * fmpq(k, ALONG) for k in range(ALONG + 1))


def _is_kept(piece: RuledSurface, u: fmpq, r: fmpq) -> bool:
    """Whether the point at u, that part of the ruling, satisfies the inequalities that trim it."""
    assert piece.s is not None
    lo, hi = (rational(s, "s") for s in piece.s)
    s = lo + (hi - lo) * r
    for trim in piece.trim:
        value = sum((fmpq(c) * u**i * s**j for (i, j), c in trim.polynomial.to_dict().items()), fmpq(0))
        if value < 0:
            return False
    return True
