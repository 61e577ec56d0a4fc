"""Case VII: two conics in space, by the common line of their planes; case VIII where the planes are one.

With n = P1^T N2 the common line has the points P1 (e x n) for any e; each such point is P2 W e, W the matrix of 4x4
minors of [P1 P2].  So the two conics cut the common line in two binary quadratic forms h, g of e, and the conics share
a point where Res(h, g) = (a0 b2 + a2 b0 - 2 a1 b1)^2 - 4 (a0 a2 - a1^2)(b0 b2 - b1^2) vanishes (Choi et al. 2014,
conics in space and Algorithm 2).  Two complex common points are roots too; the realness test is ours.
"""

from __future__ import annotations

from flint import fmpz_poly

from firstcontact.exact.polynomial_matrix import Matrix, adjugate, congruent, determinant, product
from firstcontact.exact.roots import AlgebraicRoot
from firstcontact.pairs import planar_conics
from firstcontact.pairs.carrier_contact import (
    IMAGINARY,
    ONE,
    PARALLEL,
    Contacts,
    Equation,
    Form,
    Vector,
    at,
    binary_roots,
    columns,
    combine,
    common_factor,
    cross,
    finite,
    gather,
    left_inverse,
    nothing,
    number_field,
    plane_through,
    pull_plane,
    zero,
)

Side = tuple[Matrix, Matrix]  # basis P (4x3) and conic C (3x3, rank 3)


def equation(a: Side, b: Side) -> Equation:
    """Res(h, g), with the u at which the planes are parallel or equal in `parallel`."""
    normal_a, normal_b = (plane_through(*columns(basis)) for basis, _ in (a, b))
    n = pull_plane(a[0], normal_b)
    together = common_factor(n)
    if together == 0:
        return _planar_equation(a, b)
    direction = common_factor(cross(normal_a[:3], normal_b[:3]))
    if direction == 0:
        return Equation(ONE, "planes parallel for all u: case VIII where they coincide", together)
    h, g, scale = common_line(a, b, n)
    if not any(cross(coefficients(h), coefficients(g))):
        # both common points are permanent, they become real where they meet
        polynomial = determinant(h) // (scale * together) ** 2
        return Equation(polynomial, "two common points for all u", together)
    polynomial = resultant(h, g) // (scale * together) ** 4
    if polynomial == 0:
        return Equation(None, "identically zero: a common point slides along both conics")
    # The paper writes the common line as d, |d|^2 p with d = n1 x n2: that multiplies Res(h, g) by |d|^8.
    return Equation(polynomial, parallel=together**4 * direction**8)


def coefficients(h: Form) -> Vector:
    """Of s^2, s t, t^2."""
    return h[0][0], 2 * h[0][1], h[1][1]


def resultant(h: Form, g: Form) -> fmpz_poly:
    (a0, a1), (_, a2) = h
    (b0, b1), (_, b2) = g
    mixed = a0 * b2 + a2 * b0 - 2 * a1 * b1
    return mixed * mixed - 4 * (a0 * a2 - a1 * a1) * (b0 * b2 - b1 * b1)


def common_line(a: Side, b: Side, n: Vector) -> tuple[Form, Form, fmpz_poly]:
    """h, g on the two e that are unit vectors off the index k, and n_k != 0, the scale of this choice."""
    k = min((i for i in range(3) if not is_zero(n[i])), key=lambda i: size(n[i]))
    points_a, points_b = line_points(a[0], b[0], n, k)
    return congruent(points_a, a[1]), congruent(points_b, b[1]), n[k]


def is_zero(x: object) -> bool:
    return x == 0 if isinstance(x, fmpz_poly) else x.is_zero()  # type: ignore[attr-defined]


def size(x: object) -> int:
    return x.degree() if isinstance(x, fmpz_poly) else 0


def line_points(basis_a: Matrix, basis_b: Matrix, n: Vector, k: int) -> tuple[Matrix, Matrix]:
    """Two points of the common line in the coordinates of both planes: two 3x2 matrices, columns e x n and W e."""
    a, (b0, b1, b2) = columns(basis_a), columns(basis_b)
    zero_ = n[k] * 0
    in_a, in_b = [], []
    for i in range(3):
        if i == k:
            continue
        j, m = (i + 1) % 3, (i + 2) % 3
        point = [zero_] * 3
        point[j], point[m] = -n[m], n[j]
        in_a.append(tuple(point))
        in_b.append(
            (determinant((a[j], a[m], b1, b2)), determinant((a[j], a[m], b2, b0)), determinant((a[j], a[m], b0, b1)))
        )
    return tuple(zip(*in_a, strict=True)), tuple(zip(*in_b, strict=True))


def _planar_equation(a: Side, b: Side) -> Equation:
    found = planar_conics.equation(in_plane_of(a, b), b[1])
    return Equation(found.polynomial, found.reason or "coplanar for all u: case VIII")


def in_plane_of(a: Side, b: Side) -> Matrix:
    """The conic of a as a form of the coordinates of the plane of b, given that the planes are one.

    P2 y = P1 z with z = S P2 y up to a positive factor.
    """
    inverse, _ = left_inverse(a[0])
    return congruent(product(inverse, b[0]), a[1])


def contacts(a: Side, b: Side, root: AlgebraicRoot) -> Contacts:
    """Real common points; where the planes coincide, the tangencies of case VIII."""
    field = number_field(root)
    a, b = (at(field, a[0]), at(field, a[1])), (at(field, b[0]), at(field, b[1]))
    span = columns(a[0])
    normal = plane_through(*columns(b[0]))
    n = pull_plane(a[0], normal)
    if zero(n):
        touching = planar_conics.contacts(in_plane_of(a, b), b[1], columns(b[0]))
        return touching if touching.found else nothing(f"coplanar: {touching.reason}")
    if zero(cross(n, tuple(x[3] for x in span))):
        return nothing(PARALLEL)
    k = next(i for i in range(3) if not n[i].is_zero())
    points_a, points_b = line_points(a[0], b[0], n, k)
    shared = common_points(congruent(points_a, a[1]), congruent(points_b, b[1]))
    line = columns(points_a)
    return gather([finite((combine(span, combine(line, y)),)) for y in shared], IMAGINARY)


def common_points(h: Form, g: Form) -> list[Vector]:
    """Real common points of two binary quadratic forms with Res(h, g) = 0, over a field; h is not zero."""
    v = cross(coefficients(h), coefficients(g))
    if zero(v):  # proportional: all points of h
        return binary_roots(h)
    # v is proportional to (s^2, s t, t^2)
    return [(v[0], v[1])] if not zero(v[:2]) else [(v[1], v[2])]
