"""Case I: quadric against quadric, by the pencil l A - B.

The surfaces touch at X where (l0 A - B) X = 0 for a multiple root l0 of det(l A - B), or at an apex of one of them
(Choi et al. 2014, theorem on the pencil; Tu et al. 2009).  Roots l = 0 and l = inf that are there for all u belong to
surfaces of rank 3 and mean their apex: case VI, so they are divided out.  Other permanent multiple roots (spheres,
homothetic quadrics, surfaces of revolution about one axis) are left out as `exact.pencils.pencils` says (re-derived).
Pencils that are degenerate for all u: two cylinders with parallel axes are cut by a coordinate plane, which leaves
case VIII and contact along rulings; apexes (case VI) and rims (case III) see the events of all others (re-derived).
Where the surfaces become one, what bounds either face sees the event (case III), but for faces that nothing bounds: of
these the sections through the centre tell (re-derived).
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING

from firstcontact.exact.fields.number_field import NumberField, is_zero
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.pencils.pencils import PencilMeeting, Tangency, characteristic, pencil_contacts
from firstcontact.exact.polynomials.inertia import null_space, times
from firstcontact.exact.polynomials.polynomial_matrix import Matrix, adjugate, congruent, determinant, minors, transpose
from firstcontact.pairs.carriers import planar_conics
from firstcontact.pairs.carriers.contact import (
    CROSSING,
    IMAGINARY,
    Contacts,
    Equation,
    Form,
    Vector,
    finite,
    gather,
    nothing,
    zero,
)

if TYPE_CHECKING:
    from firstcontact.exact.ring import MatrixOf, N

DEGENERATE = "identically degenerate pencil: an apex (case VI) or a rim (case III) sees the event"
APEX = "apex: case VI"
COINCIDE = "the surfaces coincide"


def equation(a: Matrix, b: Matrix) -> Equation:
    """The u at which the quadrics may touch away from their apexes; A, B symmetric 4x4."""
    coefficients = characteristic(a, b)
    if any(coefficients):
        return planar_conics.pencil_equation(coefficients, a, b)
    axis = next(v for v in adjugate(a) if any(v)) if any(minors(a, 3)) else ()
    if not axis or any(times(b, axis)):
        return Equation(None, DEGENERATE)
    k = next(i for i in range(4) if axis[i] != 0)
    return replace(
        planar_conics.equation(without_coordinate(a, k), without_coordinate(b, k)),
        reason="common apex or parallel axes for all u: case VIII of a section",
    )


def contacts(a: Matrix, b: Matrix, root: AlgebraicRoot) -> Contacts:
    """Isolated points, lines and conics in which the surfaces touch without crossing; multiplier: sign of l0."""
    field = NumberField(root)
    form_a, form_b = field.matrix(a), field.matrix(b)
    coefficients = [field(c) for c in characteristic(a, b)]
    if zero(coefficients):
        return degenerate_contacts(form_a, form_b)
    tangencies = pencil_contacts(form_a, form_b, coefficients).tangencies
    return gather([contact_sets(tangency, form_a) for tangency in tangencies], IMAGINARY)


NO_CONTACT = {
    PencilMeeting.CROSSING: CROSSING,
    PencilMeeting.CUSP: CROSSING,
    PencilMeeting.PLANES: CROSSING,
    PencilMeeting.IMAGINARY: IMAGINARY,
    PencilMeeting.SINGULAR: APEX,
}


def contact_sets(tangency: Tangency, a: Form) -> Contacts:
    """The contact sets of one multiple root, finite and away from apexes, of the surface A and another one."""
    if tangency.side == 0:
        return nothing(APEX)
    if tangency.meeting is PencilMeeting.SURFACE:
        return replace(gather(central_sections(a, tangency.side), COINCIDE), same=True)
    if tangency.meeting in NO_CONTACT:
        return nothing(NO_CONTACT[tangency.meeting])
    spans: list[tuple[Vector, ...]] = [(x,) for x in tangency.points]
    spans += tangency.lines
    sets = [finite(span, multiplier=tangency.side) for span in spans]
    if tangency.plane:
        sets.append(finite(tangency.plane, form=tangency.form, multiplier=tangency.side))
    return gather(sets, IMAGINARY)


def central_sections(a: Form, side: int) -> list[Contacts]:
    """The conics in which planes along the coordinate planes through the centre cut A; none where it has no centre."""
    linear = tuple(row[:3] for row in a[:3])
    scale = determinant(linear)
    if is_zero(scale):
        return []
    centre = (*(-sum(x * row[3] for x, row in zip(rows, a, strict=False)) for rows in adjugate(linear)), scale)
    units = [tuple(scale * 0 + (1 if k == i else 0) for k in range(4)) for i in range(3)]
    spans = [(*pair, centre) for pair in combinations(units, 2)]
    return [finite(span, form=congruent(transpose(span), a), multiplier=side) for span in spans]


def degenerate_contacts(a: Form, b: Form) -> Contacts:
    """Where det(l A - B) = 0 for every l at this u: parallel axes touch along rulings, by case VIII of the sections."""
    null = null_space(a)
    if len(null) != 1 or not zero(times(b, null[0])):
        return nothing("the pencil is degenerate at this time: case III or VI")
    (axis,) = null
    k = next(i for i in range(4) if not is_zero(axis[i]))
    zero_ = axis[k] * 0
    plane = tuple(tuple(zero_ + 1 if i == j else zero_ for i in range(4)) for j in range(4) if j != k)
    touching = planar_conics.contacts(without_coordinate(a, k), without_coordinate(b, k), plane)
    if any(contact.kind != "point" for contact in touching.found):
        return Contacts((), COINCIDE, same=True)
    sets = [finite((contact.span[0], axis), multiplier=contact.multiplier) for contact in touching.found]
    return gather(sets, f"parallel axes: {touching.reason}")


def without_coordinate(form: MatrixOf[N], k: int) -> tuple[tuple[N, ...], ...]:
    """The form on the coordinate plane X_k = 0."""
    return tuple(tuple(x for j, x in enumerate(row) if j != k) for i, row in enumerate(form) if i != k)
