"""Case VII: two conics in space, by the common line of their planes; case VIII where the planes are one.

With n = P1^T N2 the common line has the points P1 (e x n) for any e; each such point is P2 W e, W the matrix of 4x4
minors of [P1 P2].  So the two conics cut the common line in two binary quadratic forms h, g of e, and the conics share
a point where Res(h, g) = (a0 b2 + a2 b0 - 2 a1 b1)^2 - 4 (a0 a2 - a1^2)(b0 b2 - b1^2) vanishes (Choi et al. 2014,
conics in space and Algorithm 2).  Two complex common points are roots too; the realness test is ours.
"""

from __future__ import annotations

from dataclasses import replace

from flint import fmpz_poly

from firstcontact.exact.fields.number_field import NumberField
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.pencils.conic_pencils import line_resultant, proportional, shared_points
from firstcontact.exact.pencils.pencils import combination
from firstcontact.exact.polynomials.polynomial_matrix import congruent, determinant, product, transpose
from firstcontact.exact.vectors import cross
from firstcontact.pairs.carriers import planar_conics
from firstcontact.pairs.carriers.contact import (
    IMAGINARY,
    ONE,
    PARALLEL,
    Contacts,
    Equation,
    Form,
    Vector,
    columns,
    common_factor,
    finite,
    gather,
    left_inverse,
    nothing,
    plane_through,
    pull_plane,
    zero,
)

Side = tuple[Form, Form]
"""Basis P (4x3) and conic C (3x3): of rank 3, or 2 where it is a pair of straight edges at irrational places."""


def equation(a: Side, b: Side) -> Equation:
    """Res(h, g), with the u at which the planes are parallel or equal in `parallel`."""
    normal_a, normal_b = (normal_of(basis) for basis, _ in (a, b))
    n = pull_plane(a[0], normal_b)
    together = common_factor(n)
    if together == 0:
        return _planar_equation(a, b)
    direction = common_factor(cross(normal_a[:3], normal_b[:3]))
    if direction == 0:
        return Equation(ONE, "planes parallel for all u: case VIII where they coincide", together)
    h, g, scale = common_line(a, b, tuple(x // together for x in n))
    if proportional(h, g):
        # both common points are permanent, they become real where they meet
        polynomial = determinant(h) // scale**2
        if polynomial == 0:
            return Equation(None, "identically zero: straight edges that stay parallel")
        return Equation(polynomial, "two common points for all u", together, permanent=True)
    polynomial = line_resultant(h, g) // scale**4
    if polynomial == 0:
        return Equation(None, "identically zero: a common point slides along both conics")
    # The paper writes the common line as d, |d|^2 p with d = n1 x n2: that multiplies Res(h, g) by |d|^8.
    return Equation(polynomial, parallel=together**4 * direction**8)


def normal_of(basis: Form) -> Vector:
    """The plane of a basis without its common factor."""
    plane = plane_through(*columns(basis))
    divisor = common_factor(plane)
    return tuple(x // divisor for x in plane)


def common_line(a: Side, b: Side, n: Vector) -> tuple[Form, Form, fmpz_poly]:
    """h, g on the two e that are unit vectors off the index k, and n_k != 0, the scale of this choice.

    The forms on all e have no common factor with n left, so n_k^2 divides det(h) and n_k^4 divides Res(h, g).
    """
    k = min((i for i in range(3) if n[i] != 0), key=lambda i: int(n[i].degree()))
    points_a, points_b = line_points(a[0], b[0], n)
    divisor = common_factor(x for row in points_b for x in row)
    points_b = tuple(tuple(x // divisor for x in row) for row in points_b)
    return congruent(off(points_a, k), a[1]), congruent(off(points_b, k), b[1]), n[k]


def off(points: Form, k: int) -> Form:
    """The two other columns."""
    return tuple(tuple(x for i, x in enumerate(row) if i != k) for row in points)


def line_points(basis_a: Form, basis_b: Form, n: Vector) -> tuple[Form, Form]:
    """Three points of the common line in the coordinates of both planes: e x n and W e for the unit vectors e."""
    a, (b0, b1, b2) = columns(basis_a), columns(basis_b)
    zero_ = n[0] * 0
    in_a = ((zero_, n[2], -n[1]), (-n[2], zero_, n[0]), (n[1], -n[0], zero_))
    in_b = []
    for j, m in ((1, 2), (2, 0), (0, 1)):
        p, q = a[j], a[m]
        in_b.append(tuple(determinant((p, q, r, s)) for r, s in ((b1, b2), (b2, b0), (b0, b1))))
    return in_a, transpose(in_b)


def _planar_equation(a: Side, b: Side) -> Equation:
    inverse, positive = left_inverse(a[0])
    conic = without_factors(in_plane_of(a, b, inverse), positive)
    found = planar_conics.equation(conic, b[1])
    return replace(found, reason=found.reason or "coplanar for all u: case VIII")


def in_plane_of(a: Side, b: Side, inverse: Form) -> Form:
    """The conic of a as a form of the coordinates of the plane of b, given that the planes are one.

    P2 y = P1 z with z = S P2 y up to a positive factor.
    """
    return congruent(product(inverse, b[0]), a[1])


def without_factors(form: Form, positive: fmpz_poly) -> Form:
    """The form without the factors it shares with a polynomial that is positive everywhere: they are too."""
    while (common := common_factor([positive, *sum(form, ())])).degree() > 0:
        form = tuple(tuple(x // common for x in row) for row in form)
    return form


def contacts(a: Side, b: Side, root: AlgebraicRoot) -> Contacts:
    """Real common points; where the planes coincide, the tangencies of case VIII."""
    field = NumberField(root)
    a, b = ((field.matrix(basis), field.matrix(conic)) for basis, conic in (a, b))
    span = columns(a[0])
    normal = plane_through(*columns(b[0]))
    n = pull_plane(a[0], normal)
    if zero(n):
        inverse, _ = left_inverse(a[0])
        return coplanar_contacts(in_plane_of(a, b, inverse), b[1], columns(b[0]))
    if zero(cross(n, tuple(x[3] for x in span))):
        return nothing(PARALLEL)
    k = next(i for i in range(3) if not n[i].is_zero())
    points_a, points_b = (off(points, k) for points in line_points(a[0], b[0], n))
    h, g = congruent(points_a, a[1]), congruent(points_b, b[1])
    line = columns(points_a)
    if all(zero(row) for row in (*h, *g)):  # two pairs of straight edges have one of them in common
        return finite(tuple(combination(span, x) for x in line))
    shared = shared_points(h, g)
    return gather([finite((combination(span, combination(line, y)),)) for y in shared], IMAGINARY)


def coplanar_contacts(a: Form, b: Form, span: tuple[Vector, ...]) -> Contacts:
    """Tangencies of two conics of one plane, or whether they cross there without one.

    Where they cross, the faces in that plane see the event (case IV), if the conics bound such faces.
    """
    touching = planar_conics.contacts(a, b, span)
    if touching.found or touching.reason != planar_conics.NO_TANGENCY:
        return touching
    return nothing("coplanar: the conics cross" if planar_conics.cross(a, b) else "coplanar: no common point")
