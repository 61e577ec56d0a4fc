"""Case VI: vertex against plane or quadric.  The equation is the value of the form at the vertex.

Point by its matrix P (4x1), plane N (4), quadric Q (4x4), all over fmpz_poly in one frame (Choi et al. 2014,
section on vertices).  A cone apex is a vertex too; the note says when the surface itself has its apex there.
"""

from __future__ import annotations

from typing import Any

from firstcontact.exact.inertia import dot, times, value
from firstcontact.exact.number_field import NumberField
from firstcontact.exact.polynomial_matrix import Matrix
from firstcontact.exact.roots import AlgebraicRoot
from firstcontact.pairs.carrier_contact import (
    Contacts,
    Equation,
    Vector,
    columns,
    finite,
    vector_at,
    zero,
)


def plane_equation(point: Matrix, plane: Vector) -> Equation:
    """N.X."""
    return _equation(dot(columns(point)[0], plane), "plane")


def quadric_equation(point: Matrix, quadric: Matrix) -> Equation:
    """X^T Q X."""
    (x,) = columns(point)
    return _equation(value(quadric, x), "quadric")


def _equation(polynomial: Any, surface: str) -> Equation:
    if polynomial == 0:
        return Equation(None, f"identically zero: the vertex slides in the {surface}")
    return Equation(polynomial)


def plane_contacts(point: Matrix, plane: Vector, root: AlgebraicRoot) -> Contacts:
    """The vertex itself."""
    return finite((vector_at(NumberField(root), columns(point)[0]),))


def quadric_contacts(point: Matrix, quadric: Matrix, root: AlgebraicRoot) -> Contacts:
    """The vertex itself, with the note "apex" where the quadric has no tangent plane."""
    field = NumberField(root)
    x = vector_at(field, columns(point)[0])
    return finite((x,), note="apex" if zero(times(field.matrix(quadric), x)) else "")
