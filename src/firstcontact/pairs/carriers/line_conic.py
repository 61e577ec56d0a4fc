"""Cases IX and X: line against conic.

In space (IX) the line P1 y meets the conic's plane P2 z where P1 y = P2 z; by Cramer's rule z consists of the 4x4
minors of [P1 P2], and the line meets the conic C where z^T C z = 0.  No division by N.d is made, so the false double
roots of the cleared form do not arise (re-derived; Choi et al. 2014, conic/line).  In the conic's plane (X), for all u
or at one, the line is Z = S P1 with S P2 = s I; it is tangent where det(Z^T C Z) = 0 (Algorithm 2, coplanar branch).
"""

from __future__ import annotations

from flint import fmpz_poly

from firstcontact.exact.fields.number_field import NumberField
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.pencils.pencils import binary_zeros, combination
from firstcontact.exact.polynomials.inertia import null_space, value
from firstcontact.exact.polynomials.polynomial_matrix import Matrix, congruent, determinant, product
from firstcontact.pairs.carriers.contact import (
    IMAGINARY,
    ONE,
    Contacts,
    Equation,
    Form,
    Vector,
    columns,
    common_factor,
    finite,
    gather,
    left_inverse,
    nothing,
    zero,
)


def equation(line: Matrix, basis: Matrix, conic: Matrix) -> Equation:
    """z^T C z, with the u at which the line lies in the conic's plane in `parallel`; `basis` P2, `conic` C."""
    z = crossing(line, basis)
    together: fmpz_poly = common_factor(z)
    if together == 0:
        return _planar_equation(in_plane(line, basis), conic)
    polynomial = value(conic, tuple(x // together for x in z))
    if polynomial == 0:
        if combination(columns(basis), z)[3] == 0:
            return Equation(ONE, "parallel for all u to an asymptote", together)
        return Equation(None, "identically zero: the line slides along the conic")
    return Equation(polynomial, parallel=together * together)


def _planar_equation(line: Form, conic: Matrix) -> Equation:
    polynomial = determinant(congruent(line, conic))
    if polynomial == 0:
        return Equation(None, "identically zero: the line stays tangent to the conic in its plane")
    return Equation(polynomial, "coplanar for all u: case X", permanent=True)  # crossings, between tangencies


def crossing(line: Form, basis: Form) -> Vector:
    """z: the line meets the plane of `basis` at `basis` z; all zero where it lies in that plane."""
    p, q = columns(line)
    a, b, c = columns(basis)
    return determinant((p, q, b, c)), -determinant((p, q, a, c)), determinant((p, q, a, b))


def in_plane(line: Form, basis: Form) -> Form:
    """The line (4x2) in the plane's coordinates (3x2), given that it lies in the plane; positive factor."""
    inverse, _ = left_inverse(basis)
    return product(inverse, line)


def contacts(line: Matrix, basis: Matrix, conic: Matrix, root: AlgebraicRoot) -> Contacts:
    """The common point; where the line lies in the plane, its point of tangency or both points it cuts out."""
    field = NumberField(root)
    p, span, form = field.matrix(line), field.matrix(basis), field.matrix(conic)
    z = crossing(p, span)
    if zero(z):
        return _planar_contacts(in_plane(p, span), form, columns(span))
    touching = finite((combination(columns(span), z),))
    return touching if touching.found else nothing("parallel")


def _planar_contacts(line: Form, conic: Form, span: tuple[Vector, ...]) -> Contacts:
    """Real common points of a line and a conic of one plane, over a field."""
    ends = columns(line)
    restricted = congruent(line, conic)
    if all(zero(row) for row in restricted):  # one of a pair of straight edges
        return finite(tuple(combination(span, x) for x in ends), note="coplanar")
    points = [combination(ends, y) for y in binary_zeros(restricted)]
    note = "coplanar" if len(null_space(restricted)) == 1 else "coplanar: crossing"
    return gather([finite((combination(span, x),), note=note) for x in points], IMAGINARY)
