"""Case VI for vertices with algebraic coordinates: X(s), polynomials in one algebraic number s, against a surface.

The form at the vertex is f(s, u), and the equation is its norm, the product over all conjugates of s, an integer
polynomial in u: the resultant of f with the minimal polynomial of s.  Roots at which only another conjugate of the
vertex meets the surface carry no contact (re-derived; Choi et al. 2014 has rational vertices).
"""

from __future__ import annotations

from typing import Any

from flint import Ordering, fmpz_mpoly_ctx, fmpz_poly

from firstcontact.exact.fields.field_towers import TowerElement
from firstcontact.exact.fields.number_field import NumberField
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.polynomials import by_values
from firstcontact.exact.polynomials.inertia import dot, times, value
from firstcontact.exact.polynomials.polynomial_matrix import Matrix
from firstcontact.pairs.carriers.contact import (
    ZERO,
    Contacts,
    Equation,
    Vector,
    columns,
    common_factor,
    finite,
    nothing,
    zero,
)
from firstcontact.pairs.carriers.point_carriers import APEXES, sliding

CONJUGATE = "another conjugate of the vertex"
_PLANE = fmpz_mpoly_ctx.get(("s", "u"), Ordering.lex)


def plane_equation(point: Matrix, vertex: AlgebraicRoot, plane: Vector) -> Equation:
    """`point` P (4xn): the vertex is P (1, s, ..., s^(n-1))^T for the root s = `vertex`; the norm of N.X."""
    form = [dot(column, plane) for column in columns(point)]
    norm = _norm(vertex.polynomial, form)
    return sliding("plane") if norm == 0 else Equation(norm)


def quadric_equation(point: Matrix, vertex: AlgebraicRoot, quadric: Matrix) -> Equation:
    """The norm of X^T Q X; the norms of Q X where that vanishes for all u: the apex of Q may come to the vertex."""
    parts = columns(point)
    images = [times(quadric, x) for x in parts]
    form = [ZERO] * (2 * len(parts) - 1)
    for i, x in enumerate(parts):
        for j, y in enumerate(images):
            form[i + j] = form[i + j] + dot(x, y)
    norm = _norm(vertex.polynomial, form)
    if norm != 0:
        return Equation(norm)
    apex = common_factor(_norm(vertex.polynomial, list(entries)) for entries in zip(*images, strict=True))
    return Equation(apex, APEXES, permanent=True) if apex.degree() > 0 else sliding("quadric")


def plane_contacts(point: Matrix, vertex: AlgebraicRoot, plane: Vector, root: AlgebraicRoot) -> Contacts:
    """The vertex itself, where it is this conjugate that meets the plane."""
    field, x = _at(point, vertex, root)
    form = dot([field(c) for c in plane], x)
    return finite((x,)) if _is_zero(form) else nothing(CONJUGATE)


def quadric_contacts(point: Matrix, vertex: AlgebraicRoot, quadric: Matrix, root: AlgebraicRoot) -> Contacts:
    """The vertex itself, with the note "apex" where the quadric has no tangent plane."""
    field, x = _at(point, vertex, root)
    form = field.matrix(quadric)
    if not _is_zero(value(form, x)):
        return nothing(CONJUGATE)
    return finite((x,), note="apex" if zero(times(form, x)) else "")


def _at(point: Matrix, vertex: AlgebraicRoot, root: AlgebraicRoot) -> tuple[NumberField, Vector]:
    field = NumberField(root)
    return field, tuple(TowerElement(field, vertex, [field(c) for c in row]) for row in point)


def _is_zero(form: TowerElement) -> bool:
    """Zero test of a form whose norm vanishes."""
    x = form.enclosed(96)
    if x > 0 or x < 0:
        return False
    return form.only_conjugates_differ() or form.is_zero()


def _norm(minimal: fmpz_poly, form: list[fmpz_poly]) -> fmpz_poly:
    """Resultant in s of the minimal polynomial of s and sum form[k] s^k, form[k] polynomials in u."""
    s: dict[tuple[int, ...], Any] = {(k, 0): c for k, c in enumerate(minimal.coeffs()) if c}
    f: dict[tuple[int, ...], Any] = {(k, j): c for k, p in enumerate(form) for j, c in enumerate(p.coeffs()) if c}
    if not f:
        return ZERO
    if by_values.is_quicker(int(minimal.degree()), len(form) - 1) and not form[-1].is_zero():
        return by_values.resultant([fmpz_poly([c]) for c in minimal.coeffs()], form)
    norm = _PLANE.from_dict(s).resultant(_PLANE.from_dict(f), "s").to_dict()
    found = [0] * (1 + max((j for _, j in norm), default=0))
    for (_, j), c in norm.items():
        found[j] = int(c)
    return fmpz_poly(found)
