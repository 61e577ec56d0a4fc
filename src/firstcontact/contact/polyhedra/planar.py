"""Motions in a plane, as of parts on one table: turns about its normal, shifts along it.  What slides at all times.

A condition is a polynomial in the pose.  It holds for all such motions if it vanishes at the generic one, whose turn
and shift are powers of one variable u that no term of the polynomial confuses.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq, fmpq_poly

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.generic_turns import Rows, generic_turn
from firstcontact.exact.numbers import to_double
from firstcontact.exact.vectors import Vector, cross
from firstcontact.motion.product import Product
from firstcontact.motion.relative.curved import CurvedPiece, Leg

if TYPE_CHECKING:
    from firstcontact.motion.kinds import Single

# Powers of u for the two components of the shift: conditions have degree 6 at most in the turn's parameter u.
SHIFT_1, SHIFT_2 = 16, 32
# Sine of the angle below which a triangle may be level, and part of lengths below which a corner may be on an edge.
LEVEL = 1e-9


class BeginsNothing(Exception):
    """Two elements that slide in one another at all times: others meet no later than they do."""


def normal_of_motion(piece: CurvedPiece) -> Vector | None:
    """The normal of the plane in which both bodies turn and shift; None where there is none."""
    legs = piece.leg_a, piece.leg_b
    motions = [motion for leg in legs for motion in _simple_motions(leg)]
    normal = next((axis for motion in motions for axis in motion.axes or ()), None)
    if normal is None or any(leg.before.factors for leg in legs):
        return None
    return normal if all(motion.is_across(normal) for motion in motions) else None


def _simple_motions(leg: Leg) -> list[Single]:
    return [f.motion for f in leg.motion.factors] if isinstance(leg.motion, Product) else [leg.motion]


def generic_poses(normal: Vector) -> tuple[Rows, Rows]:
    """The generic pose in the plane and its inverse, each up to a positive factor: (4, 4) polynomials in u."""
    u = fmpq_poly([0, 1])
    turn, weight = generic_turn(normal, u)
    k = min(range(3), key=lambda i: abs(normal[i]))
    unit = fmpq(int(k == 0)), fmpq(int(k == 1)), fmpq(int(k == 2))
    first = cross(normal, unit)
    second = cross(normal, first)
    shift = [u**SHIFT_1 * p + u**SHIFT_2 * q for p, q in zip(first, second, strict=True)]
    nil = fmpq_poly([0])
    pose = [[*row, s * weight] for row, s in zip(turn, shift, strict=True)]
    columns = [[turn[j][i] for j in range(3)] for i in range(3)]
    back = [[*row, -(row[0] * shift[0] + row[1] * shift[1] + row[2] * shift[2])] for row in columns]
    last = [nil, nil, nil, weight]
    return [*pose, last], [*back, last]


def has_walls(body: Polyhedron, normal: Vector) -> bool:
    """Whether every edge of the solid lies in a triangle that is not level, or within a level face.

    Then bodies that move in the plane, apart so far, begin to touch where a vertex or an edge of one meets such a
    triangle of the other, or one of its sides: the sections along the plane are polygons, whose sides lie in those.
    """
    if not body.solid or len(np.unique(body.triangles)) < len(body.vertices):
        return False
    if len(np.unique(body.side_edge)) < len(body.segments) or np.any(body.side_edge < 0):
        return False
    d = np.array([to_double(c) for c in normal])
    d /= np.linalg.norm(d)
    x = body.vertices[body.triangles]
    n = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    level = np.linalg.norm(np.cross(n, d), axis=1) <= LEVEL * np.linalg.norm(n, axis=1)
    sides = body.side_edge
    count = np.bincount(sides.ravel(), minlength=len(body.segments))
    within = np.bincount(sides[level].ravel(), minlength=len(body.segments)) == count
    sums = np.zeros(len(count))
    for s in range(3):
        rows = level & within[sides[:, s]]
        e = x[rows, (s + 1) % 3] - x[rows, s]
        ends = body.segments[sides[rows, s]]
        e *= np.where(body.triangles[rows, s] == ends[:, 0], 1.0, -1.0)[:, None]
        across = np.cross(e, x[rows, (s + 2) % 3] - x[rows, s]) @ d
        clear = np.abs(across) > LEVEL * np.linalg.norm(e, axis=1) * np.linalg.norm(n[rows], axis=1) ** 0.5
        np.add.at(sums, sides[rows, s], np.where(clear, np.sign(across), 9.0))
    return bool(np.all((count[within] == 2) & (sums[within] == 0.0)))
