"""Case II: plane against quadric.  The plane N is tangent where N^T adj(Q) N = 0, at the pole X = adj(Q) N.

For a quadric of rank 3 this is a square that says only "the plane passes through the apex" (parallel to the axis,
for a cylinder): such pairs of bounded solids are exempt, since the ruling they touch in ends on an edge of one of
the faces, where cases III to VI see the same time (re-derived; Choi et al. 2014, quadric/plane).
"""

from __future__ import annotations

from firstcontact.exact.fields.number_field import NumberField
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.polynomials.inertia import inertia, null_space, times, value
from firstcontact.exact.polynomials.polynomial_matrix import Matrix, adjugate, congruent, determinant, transpose
from firstcontact.pairs.carriers.contact import (
    CROSSING,
    Contacts,
    Equation,
    Vector,
    finite,
    nothing,
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
    field = NumberField(root)
    q, n = field.matrix(quadric), vector_at(field, plane)
    pole = times(field.matrix(adjugate(quadric)), n)
    section = congruent(transpose(null_space([n])), q)
    positive, negative, _ = inertia(section)
    return nothing(CROSSING) if positive and negative else finite((pole,))
