"""Case VI: vertex against plane or quadric.  The equation is the value of the form at the vertex.

Point by its matrix P (4x1), plane N (4), quadric Q (4x4), all over fmpz_poly in one frame (Choi et al. 2014,
section on vertices).  A cone apex is a vertex too; the note says when the surface itself has its apex there.
A vertex that slides in a cone for all u still meets its apex: then the equation is Q X = 0 (re-derived).
"""

from __future__ import annotations

from firstcontact.exact.fields.number_field import NumberField
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.polynomials.inertia import dot, times, value
from firstcontact.exact.polynomials.polynomial_matrix import Matrix
from firstcontact.pairs.carriers.contact import (
    Contacts,
    Equation,
    Vector,
    columns,
    common_factor,
    finite,
    vector_at,
    zero,
)

APEXES = "the vertex slides in the cone: where it meets the apex"


def plane_equation(point: Matrix, plane: Vector) -> Equation:
    """N.X."""
    form = dot(columns(point)[0], plane)
    return sliding("plane") if form == 0 else Equation(form)


def quadric_equation(point: Matrix, quadric: Matrix) -> Equation:
    """X^T Q X; where that vanishes for all u, the common divisor of the entries of Q X."""
    (x,) = columns(point)
    form = value(quadric, x)
    if form != 0:
        return Equation(form)
    apex = common_factor(times(quadric, x))
    return Equation(apex, APEXES, permanent=True) if apex.degree() > 0 else sliding("quadric")


def sliding(surface: str) -> Equation:
    return Equation(None, f"identically zero: the vertex slides in the {surface}")


def plane_contacts(point: Matrix, plane: Vector, root: AlgebraicRoot) -> Contacts:
    """The vertex itself."""
    return finite((vector_at(NumberField(root), columns(point)[0]),))


def quadric_contacts(point: Matrix, quadric: Matrix, root: AlgebraicRoot) -> Contacts:
    """The vertex itself, with the note "apex" where the quadric has no tangent plane."""
    field = NumberField(root)
    x = vector_at(field, columns(point)[0])
    return finite((x,), note="apex" if zero(times(field.matrix(quadric), x)) else "")
