"""Case XI: line against line.  They share a point where det[P1 P2] = 0, P1 and P2 their 4x2 matrices.

Where the lines are parallel at a root they meet at infinity only; lines that coincide touch along themselves.
(Choi et al. 2014, line/line; `line_line` is the same case for edges under a translation, with its float filter.)
"""

from __future__ import annotations

from firstcontact.exact.fields.number_field import NumberField
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.pencils.pencils import combination
from firstcontact.exact.polynomials.polynomial_matrix import Matrix, adjugate, determinant
from firstcontact.pairs.carriers.contact import (
    AT_INFINITY,
    Contacts,
    Equation,
    columns,
    finite,
    nothing,
    vector_at,
    zero,
)


def equation(line_a: Matrix, line_b: Matrix) -> Equation:
    """det[P1 P2]."""
    polynomial = determinant(beside(line_a, line_b))
    if polynomial == 0:
        return Equation(None, "identically zero: the lines stay in one plane; their ends see the event")
    return Equation(polynomial)


def contacts(line_a: Matrix, line_b: Matrix, root: AlgebraicRoot) -> Contacts:
    """The common point, or the line itself when they coincide."""
    field = NumberField(root)
    basis = tuple(vector_at(field, column) for column in columns(line_a))
    # P1 y = -P2 z: (y, z) spans the null space, and so does every nonzero column of the adjugate.
    for null in columns(adjugate(field.matrix(beside(line_a, line_b)))):
        if not zero(null):
            touching = finite((combination(basis, null[:2]),))
            return nothing("parallel") if touching.reason == AT_INFINITY else touching
    return finite(basis)


def beside(left: Matrix, right: Matrix) -> Matrix:
    """[left right], the columns of both."""
    return tuple(x + y for x, y in zip(left, right, strict=True))
