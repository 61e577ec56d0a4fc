"""Case VIII: two conics of one plane; the same algebra serves case III in the plane of the conic.

Both are given by symmetric 3x3 matrices A (rank 3) and B in one basis of the plane.  They touch where the cubic
f(l) = det(l A - B) has a multiple root l0: at the null vector of l0 A - B, at the real points of A on the double line
if that has rank 1, and all along A if it vanishes (Choi et al. 2014, conics in a plane; permanent multiple roots, as
those of concentric circles, re-derived: see `exact.pencils.pencils`).
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

from flint import acb_poly, fmpq, fmpz_poly

from firstcontact.exact.fields.number_field import ball, sign
from firstcontact.exact.numbers import PRECISIONS, Undecidable, dyadic, precision
from firstcontact.exact.pencils.conic_pencils import ConicMeeting, conic_contacts
from firstcontact.exact.pencils.pencils import (
    characteristic,
    combination,
    contact_equation,
    discriminant,
    member,
    permanent_roots,
)
from firstcontact.exact.polynomials.inertia import inertia
from firstcontact.exact.polynomials.polynomial_matrix import Matrix, minors
from firstcontact.pairs.carriers.contact import (
    CROSSING,
    IMAGINARY,
    ONE,
    Contacts,
    Equation,
    Form,
    Vector,
    common_factor,
    finite,
    gather,
    nothing,
)

if TYPE_CHECKING:
    from firstcontact.exact.fields.number_field import FieldElement

NO_TANGENCY = "no common tangency"
PERMANENT = "a multiple root for all u is divided out"


def equation(a: Matrix, b: Matrix) -> Equation:
    """The u at which det(l A - B) has a multiple root that it does not have for all u.

    Where B is degenerate for all u, as a cylinder's section by planes along its axis, or any quadric's by a plane that
    stays tangent to it, the permanent root l = 0 tells nothing: B touches A where its two lines become one, where the
    point in which they meet comes to lie on A, and where one line for all u touches A (re-derived).
    """
    coefficients = characteristic(a, b)
    found = pencil_equation(coefficients, a, b)
    if found.polynomial is None or coefficients[0] != 0:
        return found
    doubled = next(c for c in coefficients if c != 0)  # 0 where l = 0 is a multiple root
    one_line = common_factor(minors(b, 2))
    if one_line != 0:
        return replace(found, polynomial=found.polynomial * doubled * one_line)
    return replace(found, polynomial=found.polynomial * doubled, reason=PERMANENT, permanent=True)


def pencil_equation(coefficients: list[fmpz_poly], a: Matrix, b: Matrix) -> Equation:
    """One polynomial for a pencil; it also vanishes where the pencil is degenerate at one u only.

    Where a root is multiple for all u, as with parabolas and paraboloids that always touch at infinity, what else
    touches with the same root shows where its member's rank is smaller than it is for all u (re-derived).
    """
    found = contact_equation(coefficients)
    if found.reason is not None:
        return Equation(None, f"identically zero: {found.reason}")
    polynomial = ONE
    for factor in found.factors:
        polynomial *= factor
    if found.deflated or not found.factors:
        polynomial *= common_factor(coefficients)
    for alpha, beta in permanent_roots(coefficients) if found.deflated else ():
        member = [[alpha * x - beta * y for x, y in zip(*rows, strict=True)] for rows in zip(a, b, strict=True)]
        ranks = (minors(member, k) for k in range(len(member), 0, -1))
        polynomial *= common_factor(next((found for found in ranks if any(x != 0 for x in found)), [ONE]))
    return Equation(polynomial, PERMANENT if found.deflated else "", permanent=found.deflated)


def contacts(a: Form, b: Form, span: tuple[Vector, ...]) -> Contacts:
    """Contact sets of the conics A (rank 3) and B over a field; `span`: the basis of their plane in space."""
    sets, pencil = [], conic_contacts(a, b)
    for found in pencil.tangencies:  # a cubic has one multiple root at most
        side = sign(found.alpha) * sign(found.beta)
        if found.meeting is ConicMeeting.SAME:
            sets.append(finite(span, form=a, multiplier=side))
        elif found.meeting is ConicMeeting.OSCULATING:
            sets.append(nothing(CROSSING))
        elif found.meeting is ConicMeeting.IMAGINARY:
            sets.append(nothing(IMAGINARY))
        else:
            sets += [finite((combination(span, y),), multiplier=side) for y in found.points]
    return gather(sets, pencil.reason or NO_TANGENCY)


def cross(a: Form, b: Form) -> bool:
    """Whether two conics have a real point in common, for a pencil without multiple roots: no member is definite.

    (Finsler's theorem: forms in three variables without a common real zero have a definite combination.)  Inertia
    changes at the roots of det(l A - B) only, so one rational l of each interval between them is enough.
    """
    f = characteristic(a, b)
    if sign(discriminant(f)) < 0:
        return True  # two real and two complex points
    return not any(0 in inertia(member(a, b, sample, 1))[:2] for sample in _between_roots(f))


def _between_roots(f: list[FieldElement]) -> list[fmpq]:
    """Rationals that separate the simple real roots of a cubic, and one beyond each end.

    Where a form is a pair of straight edges one root may be infinite, and one zero.
    """
    for bits in PRECISIONS:
        with precision(bits):
            try:
                roots = acb_poly([ball(c, bits) for c in f]).roots()
            except ValueError:  # not isolated at this precision
                continue
            x = sorted((root.real for root in roots), key=lambda r: r.mid())
            if all(p < q for p, q in pairwise(x)):
                ends = [x[0].lower() - 1, x[-1].upper() + 1]
                return [dyadic(r.mid()) for r in (*ends, *((p + q) / 2 for p, q in pairwise(x)))]
    raise Undecidable
