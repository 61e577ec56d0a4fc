"""Case V: line against quadric.  The line touches where its restricted form P^T Q P (2x2) is singular.

The determinant is (p^T Q d)^2 - (d^T Q d)(p^T Q p) up to sign (Choi et al. 2014, quadric/line); homogeneous
parameters cover asymptotic directions (re-derived).
"""

from __future__ import annotations

from flint import fmpz_poly

from firstcontact.exact.fields.number_field import NumberField
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.pencils.pencils import combination
from firstcontact.exact.polynomials.inertia import null_space, times
from firstcontact.exact.polynomials.polynomial_matrix import Matrix, congruent, determinant
from firstcontact.pairs.carriers.contact import (
    Contact,
    Contacts,
    Equation,
    columns,
    finite,
    vector_at,
    zero,
)


def equation(line: Matrix, quadric: Matrix) -> Equation:
    """det(P^T Q P), P the 4x2 matrix of the line."""
    form = congruent(line, quadric)
    polynomial: fmpz_poly = determinant(form)
    if polynomial != 0:
        return Equation(polynomial)
    if all(x == 0 for row in form for x in row):
        return Equation(None, "identically zero: the line slides in the surface")
    return Equation(None, "identically zero: the line stays tangent (or parallel to a ruling); its ends see the event")


def contacts(line: Matrix, quadric: Matrix, root: AlgebraicRoot) -> Contacts:
    """The null vector of the restricted form; the whole line where that form vanishes."""
    field = NumberField(root)
    basis = tuple(vector_at(field, column) for column in columns(line))
    q = field.matrix(quadric)
    null = null_space(field.matrix(congruent(line, quadric)))
    if len(null) == 2:
        return finite(basis)
    touching = finite((combination(basis, null[0]),))
    if touching.found and zero(times(q, touching.found[0].span[0])):
        return Contacts((Contact("point", touching.found[0].span, note="apex"),))
    return touching
