"""Case I: quadric against quadric, by the pencil l A - B.

The surfaces touch at X where (l0 A - B) X = 0 for a multiple root l0 of det(l A - B), or at an apex of one of them
(Choi et al. 2014, theorem on the pencil; Tu et al. 2009).  Roots l = 0 and l = inf that are there for all u belong to
surfaces of rank 3 and mean their apex: case VI, so they are divided out.  Other permanent multiple roots (spheres,
homothetic quadrics, surfaces of revolution about one axis) are left out as `multiple_roots` says (re-derived).
Pencils that are degenerate for all u: two cylinders with parallel axes are cut by a coordinate plane, which leaves
case VIII and contact along rulings; apexes (case VI) and rims (case III) see the events of all others (re-derived).
"""

from __future__ import annotations

from itertools import combinations
from typing import Any

from firstcontact.exact.polynomial_matrix import Matrix, adjugate, determinant, minors
from firstcontact.exact.roots import AlgebraicRoot
from firstcontact.pairs import planar_conics
from firstcontact.pairs.carrier_contact import (
    CROSSING,
    IMAGINARY,
    Contacts,
    Equation,
    Form,
    Vector,
    apply,
    at,
    binary_roots,
    combine,
    dot,
    finite,
    gather,
    nothing,
    null_space,
    number_field,
    restrict,
    sign,
    zero,
)
from firstcontact.pairs.plane_quadric import points_of_plane
from firstcontact.pairs.multiple_roots import multiple_root_equation, multiple_roots

DEGENERATE = "identically degenerate pencil: an apex (case VI) or a rim (case III) sees the event"
APEX = "apex: case VI"


def equation(a: Matrix, b: Matrix) -> Equation:
    """The u at which the quadrics may touch away from their apexes; A, B symmetric 4x4."""
    coefficients = characteristic(a, b)
    kept = [k for k, c in enumerate(coefficients) if c != 0]
    if kept:
        return multiple_root_equation(coefficients[kept[0] : kept[-1] + 1])
    axis = next(v for v in adjugate(a) if any(v)) if any(minors(a, 3)) else ()
    if not axis or any(apply(b, axis)):
        return Equation(None, DEGENERATE)
    k = next(i for i in range(4) if axis[i] != 0)
    return Equation(
        planar_conics.equation(without_coordinate(a, k), without_coordinate(b, k)).polynomial,
        "parallel axes for all u: case VIII of the cross-sections",
    )


def characteristic(a: Any, b: Any) -> list[Any]:
    """Coefficients of det(l A - B), ascending in l; any commutative ring."""
    adj_a, adj_b = adjugate(a), adjugate(b)
    flat_a, flat_b, of_a, of_b = (tuple(x for row in m for x in row) for m in (a, b, adj_a, adj_b))
    middle = None
    pairs = list(combinations(range(4), 2))
    for rows in pairs:
        others = [i for i in range(4) if i not in rows]
        for cols in pairs:
            rest = [j for j in range(4) if j not in cols]
            term = determinant([[a[i][j] for j in cols] for i in rows]) * determinant(
                [[b[i][j] for j in rest] for i in others]
            )
            term = term if (sum(rows) + sum(cols)) % 2 == 0 else -term
            middle = term if middle is None else middle + term
    return [dot(b[0], of_b[::4]), -dot(flat_a, of_b), middle, -dot(of_a, flat_b), dot(a[0], of_a[::4])]


def contacts(a: Matrix, b: Matrix, root: AlgebraicRoot) -> Contacts:
    """Isolated points, lines and conics in which the surfaces touch without crossing; multiplier: sign of l0."""
    field = number_field(root)
    coefficients = characteristic(a, b)
    kept = [k for k, c in enumerate(coefficients) if c != 0]
    form_a, form_b = at(field, a), at(field, b)
    f = [field(c) for c in coefficients[kept[0] : kept[-1] + 1]] if kept else []
    if zero(f):
        return degenerate_contacts(form_a, form_b)
    roots, complex_pair = multiple_roots(f)
    sets = [local_contacts(p, q, form_a, form_b) for p, q, _ in roots]
    return gather(sets, IMAGINARY if complex_pair else APEX)


def local_contacts(p: Any, q: Any, a: Form, b: Form) -> Contacts:
    """Contact sets at the multiple root l0 = p/q: the local criterion (re-derived), on G = p A - q B.

    Rank 3: G restricted to the common tangent plane is definite, or the surfaces cross.  Rank 2: definite, and the
    real points of A on its singular line; or that line lies in A.  Rank 1: the section of A by the plane of G.
    """
    multiplier = sign(p) * sign(q)
    g = tuple(tuple(p * x - q * y for x, y in zip(*rows, strict=True)) for rows in zip(a, b, strict=True))
    null = null_space(g)
    if len(null) == 4:
        return nothing("the surfaces coincide")
    if len(null) == 3:
        return section_contacts(restrict(a, null), null, multiplier)
    if len(null) == 2:
        on_line = restrict(a, null)
        if zero(sum(on_line, ())):
            return finite(null, multiplier=multiplier)
        if not semidefinite(g):
            return nothing(CROSSING)
        points = [combine(null, y) for y in binary_roots(on_line)]
        return gather([finite((x,), multiplier=multiplier) for x in points], IMAGINARY)
    (x,) = null
    tangent_plane = apply(a, x)
    if zero(tangent_plane) or zero(apply(b, x)):
        return nothing(APEX)
    if not semidefinite(restrict(g, points_of_plane(tangent_plane)), rank=2):
        return nothing(CROSSING)
    return finite((x,), multiplier=multiplier)


def semidefinite(form: Form, rank: int = 1) -> bool:
    """Whether a form of rank at most 2 is semidefinite, and of that rank at least: by its principal 2x2 minors."""
    signs = {
        determinant([[form[i][j] for j in kept] for i in kept]).sign() for kept in combinations(range(len(form)), 2)
    }
    return -1 not in signs and (rank < 2 or 1 in signs)


def section_contacts(section: Form, span: tuple[Vector, ...], multiplier: int) -> Contacts:
    """The real points of the 3x3 form in the plane of `span`: a conic, one or two lines, a point, or none."""
    null = null_space(section)
    if not null:
        empty = definite(section)
        return nothing(IMAGINARY) if empty else finite(span, form=section, multiplier=multiplier)
    if len(null) == 2:
        return finite(tuple(combine(span, y) for y in null), multiplier=multiplier)
    (node,) = null
    apex = combine(span, node)
    across = points_off(node)
    directions = binary_roots(restrict(section, across))
    if not directions:
        return finite((apex,), multiplier=multiplier)
    lines = [(apex, combine(span, combine(across, y))) for y in directions]
    return gather([finite(line, multiplier=multiplier) for line in lines], IMAGINARY)


def definite(form: Form) -> bool:
    """Whether a nonsingular 3x3 form is definite: leading minors +++ or -+-."""
    first, second, third = (determinant([row[:n] for row in form[:n]]).sign() for n in (1, 2, 3))
    return second > 0 and first == third


def points_off(node: Vector) -> tuple[Vector, ...]:
    """Two unit vectors that span the plane's coordinates together with `node`."""
    k = next(i for i in range(3) if not node[i].is_zero())
    zero_ = node[k] * 0
    return tuple(tuple(zero_ + 1 if i == j else zero_ for i in range(3)) for j in range(3) if j != k)


def degenerate_contacts(a: Form, b: Form) -> Contacts:
    """Where det(l A - B) = 0 for every l at this u: parallel axes touch along rulings, by case VIII of the sections."""
    null = null_space(a)
    if len(null) != 1 or not zero(apply(b, null[0])):
        return nothing("the pencil is degenerate at this time: case III or VI")
    (axis,) = null
    k = next(i for i in range(4) if not axis[i].is_zero())
    zero_ = axis[k] * 0
    plane = tuple(tuple(zero_ + 1 if i == j else zero_ for i in range(4)) for j in range(4) if j != k)
    touching = planar_conics.contacts(without_coordinate(a, k), without_coordinate(b, k), plane)
    if any(contact.kind != "point" for contact in touching.found):
        return nothing("the surfaces coincide")
    sets = [finite((contact.span[0], axis), multiplier=contact.multiplier) for contact in touching.found]
    return gather(sets, f"parallel axes: {touching.reason}")


def without_coordinate(form: Any, k: int) -> Any:
    """The form on the coordinate plane X_k = 0."""
    return tuple(tuple(x for j, x in enumerate(row) if j != k) for i, row in enumerate(form) if i != k)
