"""Convex bodies that stand on one another, and only turn and shift along the plane between them.

They share a point just when their faces in that plane do, and so do the prisms over these faces.  Where the bodies only
touch the prisms overlap, which doubles prove.
"""

from __future__ import annotations

import math
from collections.abc import Sequence as Listing
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.body.solid.carriers import Plane, Rows, Surface, dot, primitive, upright
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.csg import Leaf, conjunction
from firstcontact.contact.models.kept_directions import Axis, turning_axes
from firstcontact.contact.models.shared.touched import coprime
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.search.convex.convex import NotConvex, convex_pieces, half_spaces

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Model


def prisms_on_common_plane(a: Body, b: Body) -> tuple[Model, Model] | None:
    """Bodies that share points just when these do, as they move; None where they do not stand on one another."""
    axes = turning_axes(a, b)
    if axes is None or len(axes) != 1:
        return None
    (axis,) = axes
    normal = axis[0], axis[1], axis[2]
    if not all(x.motion.is_across(normal) for x in (a, b) if isinstance(x, Moving)):
        return None
    body_a: Any = shape_of(a)
    body_b: Any = shape_of(b)
    try:
        sides_a, sides_b = half_spaces(body_a), half_spaces(body_b)
        for x, y in product(_levels(sides_a, axis), _levels(sides_b, axis)):
            if upright(x.normal) == upright(y.normal) and dot(x.normal[:3], y.normal[:3]) < 0:
                if not all(_has_face_in(body, x) for body in (body_a, body_b)):
                    return None
                high = _height(body_a, body_b, x)
                prisms = _prism(body_a, sides_a, x, high), _prism(body_b, sides_b, x, 2 * high)
                for prism in prisms:
                    convex_pieces(prism)
                return _moving(prisms[0], a), _moving(prisms[1], b)
    except NotConvex:
        return None
    return None


def _moving(prism: CompositeQuadric, body: Body) -> Model:
    return Moving(prism, body.motion) if isinstance(body, Moving) else prism


def _levels(sides: Listing[Surface], axis: Axis) -> list[Plane]:
    return [x for x in sides if isinstance(x, Plane) and coprime(x.normal[:3]) == axis]


def _has_face_in(body: CompositeQuadric, plane: Plane) -> bool:
    same = upright(plane.normal)
    return any(isinstance(f.carrier, Plane) and upright(f.carrier.normal) == same for f in body.faces)


def _height(a: CompositeQuadric, b: CompositeQuadric, plane: Plane) -> fmpq:
    """In units of the plane's form: about the size of the smaller body."""
    size = min(float(np.ptp(np.array(body.bounds()), axis=0).max()) for body in (a, b))
    length = math.sqrt(sum(float(c) ** 2 for c in plane.normal[:3]))
    return fmpq(2) ** math.frexp(size * length)[1]


def _prism(body: CompositeQuadric, sides: Listing[Surface], plane: Plane, high: fmpq) -> CompositeQuadric:
    """Over the face in the plane, as high to either side."""
    *n, d = plane.normal
    square = dot(n, n)
    onto = [[fmpq(int(i == j)) - n[i] * c / square for j, c in enumerate((*n, d))] for i in range(3)]
    rows: Rows = (*map(tuple, onto), (fmpq(0), fmpq(0), fmpq(0), fmpq(1)))
    walls: dict[Any, Surface] = {}
    for side in sides:
        wall = side.placed(rows)
        across = wall.normal[:3] if isinstance(wall, Plane) else [x for row in wall.form[:3] for x in row[:3]]
        if any(across):  # else all of the plane is on the inner side, since a face is
            walls[wall] = wall
    surfaces = [*walls.values(), Plane(primitive((*n, d - high))), Plane(primitive((*(-c for c in n), -d - high)))]
    return CompositeQuadric(surfaces, conjunction([Leaf(k) for k in range(len(surfaces))]), name=body.name)
