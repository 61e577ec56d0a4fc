"""Case II: plane against quadric.  The plane N is tangent where N^T adj(Q) N = 0, at the pole X = adj(Q) N.

For a quadric of rank 3 this is a square that says only "the plane passes through the apex" (parallel to the axis,
for a cylinder): such pairs of bounded solids are exempt, since the ruling they touch in ends on an edge of one of
the faces, where cases III to VI see the same time (re-derived; Choi et al. 2014, quadric/plane).
"""

from __future__ import annotations

from itertools import combinations

from firstcontact.exact.polynomial_matrix import Matrix, adjugate, determinant
from firstcontact.exact.roots import AlgebraicRoot
from firstcontact.pairs.carrier_contact import (
    CROSSING,
    Contacts,
    Equation,
    Form,
    Vector,
    apply,
    at,
    finite,
    nothing,
    null_space,
    number_field,
    restrict,
    value,
    vector_at,
)

RANK_3 = "exempt: the plane touches a cone or cylinder in a ruling, which ends on an edge that sees the same time"


def equation(plane: Vector, quadric: Matrix) -> Equation:
    """N^T adj(Q) N for a quadric of rank 4."""
    if determinant(quadric) == 0:
        return Equation(None, RANK_3)
    polynomial = value(adjugate(quadric), plane)
    if polynomial == 0:
        return Equation(None, "identically zero: the plane stays tangent to the quadric")
    return Equation(polynomial)


def contacts(plane: Vector, quadric: Matrix, root: AlgebraicRoot) -> Contacts:
    """The pole of the plane; a crossing tangency where the plane cuts the quadric in two real lines."""
    field = number_field(root)
    q, n = at(field, quadric), vector_at(field, plane)
    pole = apply(at(field, adjugate(quadric)), n)
    section = restrict(q, points_of_plane(n))
    return nothing(CROSSING) if indefinite(section) else finite((pole,))


def points_of_plane(n: Vector) -> tuple[Vector, ...]:
    """Three points that span the plane n.X = 0 over a field."""
    return null_space(tuple(tuple(x * y for y in n) for x in n))


def indefinite(section: Form) -> bool:
    """Whether a singular 3x3 form is a pair of real lines: one principal 2x2 minor is negative."""
    return any(
        determinant([[section[i][j] for j in kept] for i in kept]).sign() < 0 for kept in combinations(range(3), 2)
    )
