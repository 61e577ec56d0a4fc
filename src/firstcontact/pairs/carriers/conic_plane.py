"""Case IV: conic against plane.  With n = P^T N, the trace in the conic's plane, it touches where n^T adj(C) n = 0.

The point is the pole X = P adj(C) n (Choi et al. 2014, plane/conic).  Where n = 0 the whole conic lies in the plane;
n is left with that common factor, because those times are contacts too.
"""

from __future__ import annotations

from firstcontact.exact.fields.number_field import NumberField
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.pencils.pencils import combination
from firstcontact.exact.polynomials.inertia import times, value
from firstcontact.exact.polynomials.polynomial_matrix import Matrix, adjugate
from firstcontact.exact.vectors import cross
from firstcontact.pairs.carriers.contact import (
    PARALLEL,
    Contacts,
    Equation,
    Vector,
    columns,
    common_factor,
    finite,
    nothing,
    pull_plane,
    vector_at,
    zero,
)


def equation(basis: Matrix, conic: Matrix, plane: Vector) -> Equation:
    """n^T adj(C) n; `basis` P (4x3), `conic` C (3x3, rank 3), `plane` N."""
    n = pull_plane(basis, plane)
    if all(x == 0 for x in n):
        return Equation(None, "identically zero: the conic slides in the plane")
    polynomial = value(adjugate(conic), n)
    if polynomial == 0:  # at infinity too, as a parabola is in all planes parallel to its own
        together = common_factor(n)
        if together.degree() > 0:
            return Equation(together, "the conic stays tangent: where it lies in the plane", permanent=True)
        return Equation(None, "identically zero: the conic stays tangent to the plane")
    return Equation(polynomial)


def contacts(basis: Matrix, conic: Matrix, plane: Vector, root: AlgebraicRoot) -> Contacts:
    """The point of tangency, or the conic itself where its plane is the given one."""
    field = NumberField(root)
    span = tuple(vector_at(field, column) for column in columns(basis))
    n = vector_at(field, pull_plane(basis, plane))
    form = field.matrix(conic)
    if zero(n):
        return finite(span, form=form, note="coplanar")
    if zero(cross(n, tuple(x[3] for x in span))):
        return nothing(PARALLEL)
    return finite((combination(span, times(field.matrix(adjugate(conic)), n)),))
