"""Case III: conic against quadric.  The quadric cuts the plane of the conic in P^T Q P; the rest is case VIII.

(Choi et al. 2014, quadric/conic.)  A section that degenerates at a root to lines, to a double line or to a point
needs no case of its own.
"""

from __future__ import annotations

from firstcontact.exact.fields.number_field import NumberField
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.polynomials.polynomial_matrix import Matrix, congruent, minors
from firstcontact.pairs.carriers import planar_conics
from firstcontact.pairs.carriers.contact import Contacts, Equation, columns, vector_at


def equation(basis: Matrix, conic: Matrix, quadric: Matrix) -> Equation:
    """`basis` P (4x3) and `conic` C (3x3, rank 3), negative inside; `quadric` Q (4x4)."""
    section = congruent(basis, quadric)
    if not any(minors((sum(conic, ()), sum(section, ())), 2)):
        return Equation(None, "identically zero: the conic slides in the surface")
    return planar_conics.equation(conic, section)


def contacts(basis: Matrix, conic: Matrix, quadric: Matrix, root: AlgebraicRoot) -> Contacts:
    """Points of tangency, or the conic where the surface contains it; multiplier -1: the conic is outside."""
    field = NumberField(root)
    span = tuple(vector_at(field, column) for column in columns(basis))
    return planar_conics.contacts(field.matrix(conic), field.matrix(congruent(basis, quadric)), span)
