"""Pencils of two quadrics: characteristic polynomial, discriminants, local contact, the twelve contact classes."""

from __future__ import annotations

import random
import re

import pytest
from flint import fmpq, fmpq_mat, fmpq_poly, fmpz_poly

from firstcontact.exact.fields.number_field import NumberField, is_zero
from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots
from firstcontact.exact.pencils.contact_classes import (
    CLASSES,
    canonical,
    contact_class,
    notation,
    parse,
    regular,
    segre_symbol,
    signature_sequence,
)
from firstcontact.exact.pencils.pencils import (
    IDENTICALLY_DEGENERATE,
    PencilMeeting,
    characteristic,
    contact_equation,
    discriminant,
    member,
    pencil_contacts,
    resultant,
)
from firstcontact.exact.polynomials.inertia import times, value
from firstcontact.exact.polynomials.polynomial_matrix import (
    adjugate,
    congruent,
    constant,
    determinant,
    evaluate,
    primitive,
)


def form(text: str):
    """The symmetric matrix of a quadratic form such as "-3x2+2yw"."""
    m = [[fmpq(0)] * 4 for _ in range(4)]
    for sign, number, first, second in re.findall(r"([+-]?)(\d*)([xyzw])([2xyzw])", text):
        c = fmpq(int(number or 1) * (-1 if sign == "-" else 1))
        i = "xyzw".index(first)
        j = i if second == "2" else "xyzw".index(second)
        m[i][j] += c / 2
        m[j][i] += c / 2
    return m


# number, the pair, what the local criterion must say of the real contact
REPRESENTATIVES = [
    (6, "-x2-z2+2yw", "-3x2+y2-z2", PencilMeeting.POINT),
    (7, "x2+z2+2yw", "3x2+y2+z2", PencilMeeting.POINT),
    (15, "x2+y2+z2-w2", "x2+2y2", PencilMeeting.TWO_POINTS),
    (19, "y2+z2-w2", "x2", PencilMeeting.CONIC),
    (22, "y2-z2+2zw", "x2+z2", PencilMeeting.POINT),
    (24, "2xy-y2", "y2-z2-w2", PencilMeeting.POINT),
    (25, "2xy-y2", "y2+z2+w2", PencilMeeting.POINT),
    (30, "x2+y2", "z2-w2", PencilMeeting.TWO_POINTS),
    (32, "x2-y2+2zw", "z2", PencilMeeting.LINE_PAIR),
    (33, "x2+y2+2zw", "z2", PencilMeeting.POINT),
    (34, "xy+zw", "y2+w2", PencilMeeting.LINE),
    (35, "xy-zw", "y2-w2", PencilMeeting.LINE),
]


def invertible(rng, n=4):
    while True:
        p = [[fmpq(rng.randint(-3, 3)) for _ in range(n)] for _ in range(n)]
        if fmpq_mat(p).det() != 0:
            return p


def mixed(rng, a, b):
    """Two other members of the pencil of a and b."""
    while True:
        (p, q), (r, s) = ((fmpq(rng.randint(-3, 3)), fmpq(rng.randint(-3, 3))) for _ in range(2))
        if p * s != q * r:
            return member(a, b, p, q), member(a, b, r, s)


def assert_contacts(a, b, meeting, found):
    assert [t.meeting for t in found.contacts] == [meeting]
    for t in found.tangencies:
        g = member(a, b, t.alpha, t.beta)
        points = [*t.points, *(p for line in t.lines for p in line)]
        for x in points:
            assert all(is_zero(y) for y in times(g, x))
            if t.meeting is not PencilMeeting.PLANES:  # shared points: on both surfaces
                assert is_zero(value(a, x)) and is_zero(value(b, x))
        if t.meeting is PencilMeeting.LINE or t.meeting is PencilMeeting.LINE_PAIR:
            for p, q in t.lines:
                assert all(is_zero(value(m, [x + y for x, y in zip(p, q, strict=True)])) for m in (a, b))


@pytest.mark.parametrize("number, a, b, meeting", REPRESENTATIVES)
def test_the_twelve_classes(number, a, b, meeting):
    a, b = form(a), form(b)
    found = contact_class(a, b)
    assert found is not None and found.number == number
    assert_contacts(a, b, meeting, pencil_contacts(a, b))


@pytest.mark.parametrize("number, a, b, meeting", REPRESENTATIVES)
def test_the_twelve_classes_moved_and_mixed(number, a, b, meeting):
    """Neither a projective map, nor other members of the same pencil, nor signs change the class."""
    rng = random.Random(number)
    for k in range(4):
        p = invertible(rng)
        c, d = congruent(p, form(a)), congruent(p, form(b))
        if k % 2:
            c, d = mixed(rng, c, d)
        found = contact_class(c, d)
        assert found is not None and found.number == number
        assert_contacts(c, d, meeting, pencil_contacts(c, d))


def test_the_table_has_twelve_classes_no_two_equivalent():
    assert [c.number for c in CLASSES] == [r[0] for r in REPRESENTATIVES]
    assert len({(c.segre, canonical(parse(c.sequence))) for c in CLASSES}) == 12
    assert all(notation(parse(c.sequence)) == c.sequence for c in CLASSES)


def structure(a, b):
    p = regular(a, b)
    return segre_symbol(p), notation(canonical(signature_sequence(p)))


def same(sequence):
    return notation(canonical(parse(sequence)))


# Segre blocks [m] at l0 with sign e: A has e on the antidiagonal, B = A J (l0)
def block(m, e, at):
    a = [[fmpq(e) if i + j == m - 1 else fmpq(0) for j in range(m)] for i in range(m)]
    b = [[fmpq(e) * (at * (i + j == m - 1) + (i + j == m)) for j in range(m)] for i in range(m)]
    return a, b


def canonical_pair(*blocks):
    a = [[fmpq(0)] * 4 for _ in range(4)]
    b = [[fmpq(0)] * 4 for _ in range(4)]
    k = 0
    for m, e, at in blocks:
        sa, sb = block(m, e, at)
        for i in range(m):
            for j in range(m):
                a[k + i][k + j], b[k + i][k + j] = sa[i][j], sb[i][j]
        k += m
    assert k == 4
    return a, b


NEIGHBOURS = [
    # crossing tangency: (2,((1,2)),2,...)
    ("[211]", canonical_pair((2, 1, 0), (1, 1, 1), (1, -1, 2)), PencilMeeting.CROSSING),
    ("[(11)11]", canonical_pair((1, 1, 0), (1, -1, 0), (1, 1, 1), (1, -1, 2)), PencilMeeting.PLANES),
    ("[31]", canonical_pair((3, 1, 0), (1, 1, 1)), PencilMeeting.CUSP),
    ("[4]", canonical_pair((4, 1, 0)), PencilMeeting.CUSP),
    ("[(21)1]", canonical_pair((2, 1, 0), (1, 1, 0), (1, -1, 2)), PencilMeeting.PLANES),
]


@pytest.mark.parametrize("symbol, pair, meeting", NEIGHBOURS)
def test_neighbours_that_are_no_contacts(symbol, pair, meeting):
    a, b = pair
    rng = random.Random(1)
    for p in (None, invertible(rng), invertible(rng)):
        c, d = (a, b) if p is None else (congruent(p, a), congruent(p, b))
        assert segre_symbol(regular(c, d)) == symbol and contact_class(c, d) is None
        found = pencil_contacts(c, d)
        assert [t.meeting for t in found.tangencies] == [meeting] and not found.contacts


def test_enumeration_of_canonical_pencils_finds_exactly_the_classes():
    """Over all real canonical pencils with a real multiple root: class in the table <=> local contact."""
    shapes = [
        [(2, 0), (1, 1), (1, 2)], [(1, 0), (1, 0), (1, 1), (1, 2)], [(3, 0), (1, 1)], [(2, 0), (1, 0), (1, 1)],
        [(1, 0), (1, 0), (1, 0), (1, 1)], [(4, 0)], [(3, 0), (1, 0)], [(2, 0), (2, 0)], [(2, 0), (1, 0), (1, 0)],
        [(2, 0), (2, 1)], [(2, 0), (1, 1), (1, 1)], [(1, 0), (1, 0), (1, 1), (1, 1)],
    ]  # fmt: skip
    seen = set()
    for shape in shapes:
        for signs in range(2 ** len(shape)):
            a, b = canonical_pair(*((m, 1 if signs >> k & 1 else -1, at) for k, (m, at) in enumerate(shape)))
            if all(x.meeting in (PencilMeeting.IMAGINARY,) for x in pencil_contacts(a, b).tangencies):
                assert contact_class(a, b) is None
                continue
            found = contact_class(a, b)
            assert (found is not None) == bool(pencil_contacts(a, b).contacts), (shape, signs)
            if found:
                seen.add(found.number)
    # the complex pairs of simple roots give no new class of contact
    assert seen == {c.number for c in CLASSES}


def test_example_3_two_planes_are_a_crossing():
    """f = l (l-1)^2 up to sign: rank 2, indefinite member, no contact (Choi et al. 2014, example 3)."""
    a, b = canonical_pair((1, 1, 1), (1, -1, 1), (1, 1, 0), (1, 1, 3))
    rng = random.Random(3)
    a, b = mixed(rng, a, b)
    assert structure(a, b) == ("[(11)11]", same("(2,((1,1)),2,(1,2),1,(1,2),2)"))
    assert not pencil_contacts(a, b).contacts


def test_example_5_sphere_in_a_cylinder():
    """Unit sphere and unit cylinder share the circle x^2 + y^2 = 1, z = 0."""
    a, b = form("x2+y2+z2-w2"), form("x2+y2-w2")
    f = characteristic(a, b)
    assert fmpq_poly(f) == -fmpq_poly([0, 1]) * fmpq_poly([-1, 1]) ** 3
    (contact,) = pencil_contacts(a, b).contacts
    assert contact.meeting is PencilMeeting.CONIC and contact.rank == 1 and contact.side == 1
    assert all(point[2] == 0 for point in contact.plane) and contact.alpha == contact.beta
    found = contact_class(a, b)
    assert found is not None and found.number == 19


def moved(q, t):
    """The quadric q translated by t = (x, y, z): entries polynomial in u."""
    p = [[fmpz_poly([int(i == j)]) for j in range(4)] for i in range(4)]
    for i in range(3):
        p[i][3] = -t[i]
    return congruent(p, constant(q))


U = fmpz_poly([0, 1])
NONE = fmpz_poly([0])


def test_spheres_have_a_permanent_double_root():
    """Radius 1 and 2, centres 4 - u apart: contacts at u = 1 (outer), 3 (inner); concentric at 4: no real contact."""
    a, b = moved(form("x2+y2+z2-w2"), (U - 4, NONE, NONE)), constant(form("x2+y2+z2-4w2"))
    f = characteristic(a, b)
    assert discriminant(f).is_zero()
    equation = contact_equation(f)
    assert equation.deflated and equation.reason is None
    times_ = sorted({r.rational for p in equation.factors for r in real_roots(p, fmpq(0), fmpq(4))})
    assert times_ == [1, 3, 4]
    assert not pencil_contacts(evaluate(a, fmpq(4)), evaluate(b, fmpq(4))).contacts
    for u, side in ((1, -1), (3, 1)):
        (contact,) = pencil_contacts(evaluate(a, fmpq(u)), evaluate(b, fmpq(u))).contacts
        assert contact.meeting is PencilMeeting.POINT and contact.side == side
        (x,) = contact.points
        assert x[0] / x[3] == -2 and x[1] == x[2] == 0


def test_contact_at_an_algebraic_time():
    """Two ellipsoids whose contact equation has an irrational root: classified over its field."""
    a = moved(form("x2+2y2+3z2-w2"), (U - 4, fmpz_poly([1]), 2 * U - 7))
    b = constant(form("2x2+y2+z2-4w2"))
    (equation,) = contact_equation(characteristic(a, b)).factors
    touching = 0
    for root in real_roots(equation, fmpq(-10), fmpq(10)):
        field = NumberField(root)
        c, d = field.matrix(a), field.matrix(b)
        found = pencil_contacts(c, d)
        for t in found.contacts:
            assert root.rational is None and t.meeting is PencilMeeting.POINT and contact_class(c, d).number in (6, 7)
            assert is_zero(value(c, t.points[0])) and is_zero(value(d, t.points[0]))
            touching += t.side == -1
    assert touching == 2  # the first and the last contact from outside


def test_apex_on_a_surface_and_shared_apex():
    cone = form("x2+y2-z2")
    # the apex touches the plane-like bottom of a sphere from outside: cone and ball share the origin only
    sphere = form("x2+y2+z2-2xw")
    (t,) = pencil_contacts(cone, sphere).tangencies
    assert t.side == 0 and t.meeting is PencilMeeting.CROSSING and t.points[0][:3] == (0, 0, 0)
    (t,) = pencil_contacts(cone, form("x2+y2+z2-2zw")).contacts
    assert t.side == 0 and t.meeting is PencilMeeting.POINT
    assert pencil_contacts(cone, form("x2+2y2-3z2")).reason == IDENTICALLY_DEGENERATE
    assert contact_class(cone, form("x2+2y2-3z2")) is None
    assert contact_equation([fmpz_poly([0])] * 5).reason == IDENTICALLY_DEGENERATE


def test_the_same_surface():
    a = form("x2+y2+z2-w2")
    (t,) = pencil_contacts(a, member(a, a, -2, 1)).contacts
    assert t.meeting is PencilMeeting.SURFACE and t.side == -1


def test_contact_points_in_a_quadratic_extension():
    """x^2 + y^2 + 2 z^2 = 5 w^2 against 2 x^2 + 3 y^2: two contacts at z = +-sqrt(5/2)."""
    a, b = form("x2+y2+2z2-5w2"), form("2x2+3y2")
    (t,) = pencil_contacts(a, b).contacts
    assert t.meeting is PencilMeeting.TWO_POINTS
    for x in t.points:
        assert is_zero(x[0]) and is_zero(x[1]) and is_zero(2 * x[2] * x[2] - 5 * x[3] * x[3])


# ------------------------------------------------------------------------------------- algebra of coefficients


@pytest.mark.parametrize("n", [2, 3, 4])
def test_characteristic_polynomial(n):
    rng = random.Random(n)
    for _ in range(10):
        a, b = (
            [[fmpz_poly([rng.randint(-4, 4) for _ in range(3)]) for _ in range(n)] for _ in range(n)] for _ in range(2)
        )
        c = characteristic(a, b)
        assert len(c) == n + 1
        for l0 in (-2, 0, 1, 3):
            assert sum((x * l0**k for k, x in enumerate(c)), fmpz_poly([0])) == determinant(member(a, b, l0, 1))
        if n > 2:
            trace = sum((adjugate(a)[i][j] * b[j][i] for i in range(n) for j in range(n)), fmpz_poly([0]))
            assert c[n - 1] == -trace


@pytest.mark.parametrize("degree", [2, 3, 4])
def test_discriminants(degree):
    rng = random.Random(degree)
    for _ in range(20):
        c = [rng.randint(-9, 9) for _ in range(degree)] + [rng.randint(1, 9)]
        assert discriminant([fmpz_poly([x]) for x in c]) == fmpz_poly([int(fmpz_poly(c).discriminant())])
        assert discriminant([fmpq(x) for x in c]) == fmpz_poly(c).discriminant()
    assert discriminant([fmpq(1)] * (degree - 1) + [fmpq(0)] * 2) == 0  # a double root at infinity


def test_resultants():
    rng = random.Random(9)
    for m, n in ((1, 1), (1, 2), (1, 3), (3, 1), (2, 2)):
        for _ in range(10):
            f, g = ([rng.randint(-9, 9) for _ in range(d)] + [rng.randint(1, 9)] for d in (m, n))
            assert abs(resultant(f, g)) == abs(int(fmpz_poly(f).resultant(fmpz_poly(g))))


def test_rational_time_gives_the_same_as_its_field():
    a, b = moved(form("x2+2y2+z2-w2"), (U - 3, NONE, NONE)), constant(form("x2+y2+z2-w2"))
    field = NumberField(AlgebraicRoot.of(fmpq(1)))
    over_field = pencil_contacts(field.matrix(a), field.matrix(b)).contacts
    rational = pencil_contacts(evaluate(a, fmpq(1)), evaluate(b, fmpq(1))).contacts
    assert [t.meeting for t in over_field] == [t.meeting for t in rational] == [PencilMeeting.POINT]
    assert all(is_zero(x - y) for x, y in zip(over_field[0].points[0], rational[0].points[0], strict=True))


def rotating(q, t):
    """Pose with the quaternion polynomial q and translation t."""
    a, b, c, d = q
    w = a * a + b * b + c * c + d * d
    rows = (
        (a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)),
        (2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)),
        (2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d),
    )
    return (*((*row, w * x) for row, x in zip(rows, t, strict=True)), (NONE, NONE, NONE, w))


def test_two_rotating_ellipsoids():
    """Coefficients of degree 16, 18, 18, 18, 16, discriminant (60)(2)^12(2)^12: contacts over a field of degree 60."""
    one, span = fmpz_poly([1]), (fmpq(0), fmpq(1))
    pose_a = rotating((1 + 2 * U, 3 - U, U, 2 * one), (5 - 9 * U, U, 2 * U - 1))
    pose_b = rotating((3 - U, one, 2 * U, 1 - U), (NONE, U - 1, 1 - 3 * U))
    a = primitive(congruent(adjugate(pose_a), constant(form("6x2+3y2+2z2-6w2"))), span)
    b = primitive(congruent(adjugate(pose_b), constant(form("3x2+12y2+8z2-12w2"))), span)
    f = characteristic(a, b)
    assert [c.degree() for c in f] == [16, 18, 18, 18, 16]
    (equation,) = contact_equation(f).factors
    assert sorted((p.degree(), k) for p, k in equation.factor()[1]) == [(2, 12), (2, 12), (60, 1)]
    first, last = real_roots(equation, *span)
    for root in (first, last):
        field = NumberField(root)
        c, d = field.matrix(a), field.matrix(b)
        (t,) = pencil_contacts(c, d, [field(x) for x in f]).tangencies
        (x,) = t.points
        assert t.meeting is PencilMeeting.POINT and t.side == -1
        assert is_zero(value(c, x)) and is_zero(value(d, x))
