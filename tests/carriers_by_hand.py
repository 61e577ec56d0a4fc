"""Carriers built by hand for the tests of the eleven cases: matrices over fmpz_poly in the motion parameter."""

from __future__ import annotations

from fractions import Fraction

from flint import fmpq, fmpz_poly

from firstcontact.exact.fields.roots import real_roots
from firstcontact.exact.polynomials.polynomial_matrix import (
    Matrix,
    adjugate,
    congruent,
    constant,
    primitive,
    product,
    transpose,
)

SPAN = fmpq(0), fmpq(1)
DISC = constant([[1, 0, 0], [0, 1, 0], [0, 0, -1]])


def q(x) -> fmpq:
    f = Fraction(x)
    return fmpq(f.numerator, f.denominator)


def pose(*rows) -> Matrix:
    """A 4x4 motion; every entry an integer or the list of its ascending coefficients."""
    return tuple(tuple(fmpz_poly(x if isinstance(x, list) else [x]) for x in row) for row in rows)


def shift(x=0, y=0, z=0) -> Matrix:
    return pose((1, 0, 0, x), (0, 1, 0, y), (0, 0, 1, z), (0, 0, 0, 1))


def diagonal(*entries) -> Matrix:
    return constant([[q(x) if i == j else fmpq(0) for j in range(len(entries))] for i, x in enumerate(entries)])


def moved_quadric(m: Matrix, form: Matrix) -> Matrix:
    return primitive(congruent(primitive(adjugate(m), SPAN), form), SPAN)


def moved_plane(m: Matrix, normal) -> tuple:
    column = product(transpose(primitive(adjugate(m), SPAN)), tuple((fmpz_poly([x]),) for x in normal))
    return tuple(row[0] for row in primitive(column, SPAN))


def moved(m: Matrix, *columns) -> Matrix:
    """M P for the parameter matrix P with these integer columns."""
    return primitive(product(m, tuple(tuple(fmpz_poly([x]) for x in row) for row in zip(*columns, strict=True))), SPAN)


def level(m: Matrix, z: int) -> Matrix:
    """The plane z = constant of the moving frame as a basis (4x3)."""
    return moved(m, (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, z, 1))


def candidates(equation, span=SPAN) -> list[tuple[float, int]]:
    """(u, multiplicity) of the candidates in the span."""
    return [(float(r), r.multiplicity) for r in real_roots(equation.candidates, *span)]


def points(contacts) -> list[tuple[float, float, float]]:
    return [tuple(float(x) for x in contact.point()) for contact in contacts.found]
