"""Case VIII: two conics of one plane; the same algebra serves case III in the plane of the conic.

Both are given by symmetric 3x3 matrices A (rank 3) and B in one basis of the plane.  They touch where the cubic
f(l) = det(l A - B) has a multiple root l0: at the null vector of l0 A - B, at the real points of A on the double line
if that has rank 1, and all along A if it vanishes (Choi et al. 2014, conics in a plane; permanent multiple roots, as
those of concentric circles, re-derived: see `multiple_roots`).
"""

from __future__ import annotations

from typing import Any

from firstcontact.exact.polynomial_matrix import Matrix, adjugate
from firstcontact.pairs.carrier_contact import (
    CROSSING,
    IMAGINARY,
    Contacts,
    Equation,
    Form,
    Vector,
    binary_roots,
    combine,
    dot,
    finite,
    gather,
    nothing,
    null_space,
    restrict,
    sign,
)
from firstcontact.pairs.multiple_roots import multiple_root_equation, multiple_roots


def equation(a: Matrix, b: Matrix) -> Equation:
    """The u at which det(l A - B) has a multiple root that it does not have for all u."""
    return multiple_root_equation(characteristic(a, b))


def characteristic(a: Any, b: Any) -> list[Any]:
    """det(l A - B), ascending in l; any commutative ring."""
    adj_a, adj_b = adjugate(a), adjugate(b)
    flat_a, flat_b, of_a, of_b = (tuple(x for row in m for x in row) for m in (a, b, adj_a, adj_b))
    return [-dot(b[0], of_b[::3]), dot(flat_a, of_b), -dot(of_a, flat_b), dot(a[0], of_a[::3])]


def contacts(a: Form, b: Form, span: tuple[Vector, ...]) -> Contacts:
    """Contact sets of the conics A (rank 3) and B over a field; `span`: the basis of their plane in space."""
    roots, _ = multiple_roots(characteristic(a, b))
    if not roots:
        return nothing("no common tangency")
    ((p, q, multiplicity),) = roots  # a cubic has one
    multiplier = sign(p) * sign(q)
    g = tuple(tuple(p * x - q * y for x, y in zip(*rows, strict=True)) for rows in zip(a, b, strict=True))
    null = null_space(g)
    if len(null) == 1:
        if multiplicity == 3:  # they osculate: three common points in one, so each changes sides
            return nothing(CROSSING)
        return finite((combine(span, null[0]),), multiplier=multiplier)
    if len(null) == 3:
        return finite(span, form=a, multiplier=multiplier)
    line = tuple(combine(span, y) for y in null)
    points = [combine(line, y) for y in binary_roots(restrict(a, null))]
    return gather([finite((x,), multiplier=multiplier) for x in points], IMAGINARY)
