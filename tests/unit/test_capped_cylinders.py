"""Example 7 of Choi et al. 2014: two moving capped elliptic cylinders, every kind of contact equation in turn."""

from __future__ import annotations

import math
from itertools import product as pairs_of

from flint import fmpq, fmpz_poly

from firstcontact.exact.fields.number_field import NumberField, sign
from firstcontact.exact.fields.roots import real_roots
from firstcontact.exact.pencils.conic_pencils import ConicMeeting, conic_contacts, line_resultant, point_pairs
from firstcontact.exact.pencils.pencils import (
    PencilMeeting,
    characteristic,
    contact_equation,
    discriminant,
    pencil_contacts,
)
from firstcontact.exact.polynomials.polynomial_matrix import (
    adjugate,
    congruent,
    constant,
    content,
    evaluate,
    primitive,
    product,
    transpose,
)

T, ONE, NONE = fmpz_poly([0, 1]), fmpz_poly([1]), fmpz_poly([0])
SPAN = (fmpq(0), fmpq(1))
WEIGHT = 2 * T * T - 2 * T + 1
# pose of A: translation (30 - 60 t, 20, 0); of B: a turn about y by 180 degrees and (30 - 60 t, 80 t - 50, 0)
POSE_A = (
    (ONE, NONE, NONE, 30 - 60 * T),
    (NONE, ONE, NONE, 20 * ONE),
    (NONE, NONE, ONE, NONE),
    (NONE, NONE, NONE, ONE),
)
COS, SIN = 2 * T * (1 - T), 1 - 2 * T
POSE_B = (
    (COS, NONE, SIN, WEIGHT * (30 - 60 * T)),
    (NONE, WEIGHT, NONE, WEIGHT * (80 * T - 50)),
    (-SIN, NONE, COS, NONE),
    (NONE, NONE, NONE, WEIGHT),
)
CYLINDER = constant([[fmpq(1, 25), 0, 0, 0], [0, fmpq(1, 100), 0, 0], [0, 0, 0, 0], [0, 0, 0, -1]])
ELLIPSE = constant([[fmpq(1, 25), 0, 0], [0, fmpq(1, 100), 0], [0, 0, -1]])


def cap(z):
    """Points (x, y, z) of the plane of a rim: basis 4x3."""
    return constant([[1, 0, 0], [0, 1, 0], [0, 0, z], [0, 0, 1]])


def placed_quadric(pose):
    return primitive(congruent(adjugate(pose), CYLINDER), SPAN)


def placed_cap(pose, z):
    return primitive(product(pose, cap(z)), SPAN)


A, B = placed_quadric(POSE_A), placed_quadric(POSE_B)


def rationals(polynomial):
    return [(r.rational, r.multiplicity) for r in real_roots(polynomial, *SPAN)]


def test_content_of_the_pose_is_divided_out():
    assert content(B).is_one() and max(x.degree() for row in B for x in row) == 4 + 2


def test_face_against_face():
    """(2t-1)^4 (8t-9)(8t-7)^2 (8t-5)(2t^2-2t+1)^4: the first contact is 5/8, at (-7.5, 10, 0)."""
    (equation,) = contact_equation(characteristic(A, B)).factors
    expected = (2 * T - 1) ** 4 * (8 * T - 9) * (8 * T - 7) ** 2 * (8 * T - 5) * WEIGHT**4
    assert equation * expected[0] == expected * equation[0] and equation.degree() == 16
    assert rationals(equation) == [(fmpq(1, 2), 4), (fmpq(5, 8), 1), (fmpq(7, 8), 2)]

    (t,) = (t for t in pencil_contacts(evaluate(A, fmpq(5, 8)), evaluate(B, fmpq(5, 8))).tangencies if t.side)
    (x,) = t.points
    assert t.meeting is PencilMeeting.POINT and t.side == -1
    assert [y / x[3] for y in x] == [fmpq(-15, 2), 10, 0, 1]
    (t,) = (t for t in pencil_contacts(evaluate(A, fmpq(7, 8)), evaluate(B, fmpq(7, 8))).tangencies if t.side)
    assert t.meeting is PencilMeeting.PLANES and t.rank == 2 and t.side == 1
    assert pencil_contacts(evaluate(A, fmpq(1, 2)), evaluate(B, fmpq(1, 2))).reason is not None


def test_face_against_rim():
    """Conic and quadric in the plane of the rim: 0 twice, 0.634116870343..., 1 four times."""
    rim = placed_cap(POSE_B, -5)
    section = primitive(congruent(rim, A), SPAN)
    equation = discriminant(characteristic(section, ELLIPSE))
    roots = real_roots(equation, *SPAN)
    assert [(float(r), r.multiplicity) for r in roots] == [(0, 2), (0.63411687034328004228, 1), (1, 4)]
    field = NumberField(roots[1])
    (t,) = conic_contacts(field.matrix(section), field.matrix(ELLIPSE)).contacts
    assert t.meeting is ConicMeeting.TANGENT
    (x,) = t.points
    # the angle on the rim, from an independent interval Newton solution of the two equations in (angle, t)
    angle = 1.82255347545423403
    assert abs(float((x[0] / x[2]).ball(64).mid()) - 5 * math.cos(angle)) < 1e-14
    assert abs(float((x[1] / x[2]).ball(64).mid()) - 10 * math.sin(angle)) < 1e-14
    assert sign(t.alpha) * sign(t.beta) < 0


def rim_equation(z_a, z_b):
    """Two rims on the common line y of their planes: points (-, y, -) of both, from the planes of the caps."""
    # the planes z = z_a and (in B) z = z_b meet in a line parallel to y: a point with y = 0 and the direction y
    normal_a = tuple(x for (x,) in product(transpose(adjugate(POSE_A)), constant([[0], [0], [1], [-z_a]])))
    normal_b = tuple(x for (x,) in product(transpose(adjugate(POSE_B)), constant([[0], [0], [1], [-z_b]])))
    x = normal_a[2] * normal_b[3] - normal_a[3] * normal_b[2]
    z = normal_a[3] * normal_b[0] - normal_a[0] * normal_b[3]
    w = normal_a[0] * normal_b[2] - normal_a[2] * normal_b[0]
    line = primitive(((x, NONE), (NONE, ONE), (z, NONE), (w, NONE)))
    return primitive(congruent(line, A), SPAN), primitive(congruent(line, B), SPAN)


def test_rim_against_rim():
    """EA1-EB1: 4/5 -+ sqrt(11)/20 and crossings; EA1-EB2: no real contact."""
    parallel, shared = set(), {}
    for z_a, z_b in pairs_of((-5, 5), repeat=2):
        a, b = rim_equation(z_a, z_b)
        for r in real_roots(line_resultant(a, b), *SPAN):
            if r.rational == fmpq(1, 2):
                parallel.add((z_a, z_b))
                continue
            field = NumberField(r)
            if point_pairs(field.matrix(a), field.matrix(b)).is_contact:
                shared.setdefault((z_a, z_b), []).append(float(r))
    assert len(parallel) == 4
    expected = [0.634168760482230080, 0.965831239517769920]
    assert len(shared) == 2
    for found in shared.values():
        assert [t for t in found if t != 0.875] == expected
