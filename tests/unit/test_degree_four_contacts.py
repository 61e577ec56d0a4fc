"""Contacts of edges of degree 4 and of vertices where three quadrics meet: proved enclosures, and what stays open."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from flint import arb, fmpq, fmpz_poly

import firstcontact as fc
from firstcontact.body.solid.carriers import EnclosedPoint, QuarticCurve
from firstcontact.contact.models.algorithm import CandidateSearch
from firstcontact.contact.models.at_rest import overlap
from firstcontact.contact.models.moving_pair import MovingPair
from firstcontact.contact.models.square_subproblems import SquareSubproblem
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import precision
from firstcontact.exact.polynomials.polynomial_matrix import constant, determinant
from firstcontact.exact.systems.square_systems import EnclosedRoot, OpenRoot, SquareSystem, certified
from firstcontact.motion.relative.polynomial import relative_pieces


def search(a, b) -> CandidateSearch:
    """Over [0, 1]; the motions have one piece."""
    bodies = [getattr(x, "body", x) for x in (a, b)]
    (piece,) = relative_pieces(a, b, fmpq(0), fmpq(1))
    return CandidateSearch(MovingPair(*bodies, piece))


def diagonal(*values):
    return [[values[i] if i == j else 0 for j in range(4)] for i in range(4)]


def square_roots_of(found: CandidateSearch) -> list:
    """Of the only pair with a square system."""
    (task,) = [t for t in found.tasks if isinstance(t, SquareSubproblem)]
    return task.roots()


def crossed(first, second):
    """Cylinders of these radii along z and along y, without caps."""
    along_z = fc.quadric(diagonal(1, 1, 0, -(first**2)))
    return along_z & fc.quadric(diagonal(1, 0, 1, -(second**2)))


def assert_first(found: CandidateSearch) -> None:
    """No overlap just before the first contact, overlap just after."""
    u = fmpq(*float(found.first()[0].candidate.root).as_integer_ratio())
    assert not overlap(found.pair, u - fmpq(1, 10**6)) and overlap(found.pair, u + fmpq(1, 500))


# -- the worked contact ---------------------------------------------------------------------------------------

T = "0.816201116920908689159587"
X = ("0.955453852116533384060002", "0.295140536822168083914117", "0.743567121061927028362510")


@pytest.fixture(scope="module")
def worked() -> CandidateSearch:
    edge = fc.quadric(diagonal(1, 1, 0, -1)) & fc.quadric(diagonal(0, 1, 1, Fraction(-16, 25)))
    ball = fc.sphere(Fraction(1, 2)).translated((3, Fraction(1, 2), 2))
    return search(edge, ball.moving(fc.Translation((-2, 0, Fraction(-13, 10)))))


def test_edge_meets_sphere_at_the_worked_time(worked):
    (meeting,) = worked.first()
    root = meeting.candidate.root
    assert isinstance(root, EnclosedRoot) and worked.stop() is None
    assert isinstance(meeting.candidate.subproblem.a.carrier, QuarticCurve)
    assert float(root) == float(T)
    with precision(300):
        u = root.enclosure(256)
        assert float(u.rad()) < 2.0**-250 and abs(u - arb(T)) < arb("1e-24")
        zero = square_roots_of(worked)[0].zero
        shift = [arb(2) * u, arb(0), arb("1.3") * u]
        for found, step, expected in zip(zero.balls(256), shift, X, strict=False):
            # the edge rests in the world: its frame is that of the vector
            assert abs(found - arb(expected)) < arb("1e-23"), step
    assert_first(worked)


def test_the_net_of_the_three_quadrics_is_singular_at_the_contact(worked):
    """grad det(alpha A + beta B + gamma C) = 0 at the multipliers of the contact, and not beside them."""
    (task,) = [t for t in worked.tasks if isinstance(t, SquareSubproblem)]
    zero = task.roots()[0].zero
    forms = task.system.forms
    with precision(256):
        *x, u = zero.balls(200)
        at = [[[p(u) for p in row] for row in form] for form in forms]
        point = [*x, arb(1)]
        images = [[sum((c * v for c, v in zip(row, point, strict=True)), arb(0)) for row in form] for form in at]
        a, b, c = images
        # l with l_0 a + l_1 b + l_2 c = 0 in the first two coordinates: then in all four
        weights = [b[0] * c[1] - b[1] * c[0], c[0] * a[1] - c[1] * a[0], a[0] * b[1] - a[1] * b[0]]
        for k in range(4):
            assert float(abs(sum((w * i[k] for w, i in zip(weights, images, strict=True)), arb(0))).upper()) < 1e-50
        assert max(float(abs(g).upper()) for g in net_gradient(at, weights)) < 1e-50
        beside = [weights[0] * arb("1.01"), *weights[1:]]
        assert max(float(abs(g).lower()) for g in net_gradient(at, beside)) > 1e-9


def net_gradient(forms, weights):
    """Derivatives of det(sum w_i F_i) by the weights: trace of adj times F_i, by cofactors of rank-one changes."""
    weighted = list(zip(weights, forms, strict=True))
    net = [[sum((w * f[i][j] for w, f in weighted), arb(0)) for j in range(4)] for i in range(4)]
    found = []
    for form in forms:
        total = arb(0)
        for k in range(4):  # det is linear in each row
            total += determinant([form[k] if i == k else net[i] for i in range(4)])
        found.append(total)
    return found


# -- all candidates -------------------------------------------------------------------------------------------


def test_a_plane_touches_the_edge_at_every_extremum_of_its_normal():
    body = crossed(1, Fraction(3, 4))
    normal = np.array([1.0, 0.25, 0.5])
    wall = fc.half_space((-1, Fraction(-1, 4), Fraction(-1, 2)), -2)  # normal . x >= 2
    found = search(body, wall.moving(fc.Translation((-4, 0, 0))))
    roots = square_roots_of(found)
    theta = np.linspace(0, 2 * math.pi, 100_001)[:-1]
    extrema = []
    for side in (1, -1):
        x, z = 0.75 * np.cos(theta), 0.75 * np.sin(theta)
        height = np.stack([x, side * np.sqrt(1 - x * x), z]).T @ normal
        before, after = np.roll(height, 1), np.roll(height, -1)
        extrema += [*height[(height >= before) & (height > after)], *height[(height <= before) & (height < after)]]
    assert len(extrema) == 4
    assert sorted(float(r) for r in roots) == pytest.approx(sorted((2 - h) / 4 for h in extrema), abs=1e-8)


def test_two_points_of_an_edge_meet_a_wall_at_once():
    wall = fc.box((1, 9, 9)).translated((4, 0, 0))
    found = search(crossed(1, Fraction(3, 4)), wall.moving(fc.Translation((-4, 0, 0))))
    meetings = [m for m in found.first() if isinstance(m.candidate.root, EnclosedRoot)]
    assert [float(m.candidate.root) for m in meetings] == [0.6875, 0.6875]
    y = math.sqrt(7) / 4
    assert sorted(m.shared.points[0][1] for m in meetings) == pytest.approx([-y, y], abs=1e-14)


# -- other partners -------------------------------------------------------------------------------------------


def three():
    return (
        fc.cylinder(1, 6)
        & fc.cylinder("3/4", 6).rotated((1, 0, 0), degrees=90)
        & fc.cylinder("4/5", 6).rotated((0, 1, 0), degrees=90).translated((0, "1/10", 0))
    ).named("three")


def test_a_vertex_of_three_quadrics_meets_a_wall():
    body = three()
    p = np.array(body.vertices[0].position)
    n = [Fraction(round(64 * c), 64) for c in p]
    wall = fc.half_space([-c for c in n], -3)
    found = search(body, wall.moving(fc.Translation([-3 * c for c in n])))
    (meeting,) = found.first()
    vertex = meeting.candidate.subproblem.a
    assert vertex.index == 0 and isinstance(vertex.carrier, EnclosedPoint)
    normal = np.array([float(c) for c in n])
    t = (3 - normal @ p) / (3 * normal @ normal)
    assert float(meeting.candidate.root) == pytest.approx(t, abs=1e-14)


def test_an_edge_meets_a_straight_edge():
    block = fc.box((1, 1, 1)).rotated((1, 0, 1), degrees=45).translated((3, 0, 1))
    found = search(crossed(1, Fraction(3, 4)).rotated((0, 0, 1), degrees=45), block.moving(fc.Translation((-3, 0, 0))))
    (meeting,) = found.first()
    task = meeting.candidate.subproblem
    assert isinstance(task.a.carrier, QuarticCurve) and task.b.frame.shape == (4, 2)
    assert_first(found)


@pytest.mark.thorough
def test_edges_of_degree_4_meet_each_other():
    a = crossed(1, Fraction(3, 4)).rotated((0, 0, 1), degrees=80)
    b = crossed(1, Fraction(3, 4)).rotated((1, -3, 1), degrees=70).translated((2, Fraction(4, 3), 1))
    found = search(a, b.moving(fc.Translation((-2, 0, 0))))
    (meeting,) = found.first()
    task = meeting.candidate.subproblem
    assert isinstance(task.a.carrier, QuarticCurve) and isinstance(task.b.carrier, QuarticCurve)
    assert_first(found)


def test_under_a_rotation_the_moving_edge_is_searched_in_its_own_frame():
    a = crossed(1, Fraction(3, 4)).translated((3, 0, 0))
    floor = fc.half_space((0, 0, 1), Fraction(-3, 2))
    found = search(a.moving(fc.Rotation((0, 1, 0), degrees=60)), floor)
    (first, second) = found.first()
    assert {type(m.candidate.root) for m in (first, second)} == {EnclosedRoot}
    assert_first(found)
    # by symmetry y -> -y both points have one time and one x, z
    assert float(first.candidate.root) == pytest.approx(float(second.candidate.root), abs=1e-16)
    assert first.shared.points[0] * [1, -1, 1] == pytest.approx(second.shared.points[0], abs=1e-14)
    assert first.shared.points[0][2] == pytest.approx(-1.5, abs=1e-14)


# -- what needs no search, and what stays open ----------------------------------------------------------------


def test_a_plug_of_the_radius_of_its_hole_meets_the_edge():
    hole = fc.cylinder(Fraction(1, 2), 6).rotated((1, 0, 0), degrees=90)
    plug = fc.cylinder(Fraction(1, 2), 2).rotated((1, 0, 0), degrees=90).translated((0, -5, 0))
    found = search(fc.cylinder(1, 6) - hole, plug.moving(fc.Translation((0, 4, 0))))
    side = [t for t in found.tasks if isinstance(t, SquareSubproblem) and t.b.name == "side"]
    assert side and all(t.slides and not t.roots() and "dependent" in t.equation.reason for t in side)
    times = {float(m.candidate.root) for m in found.first()}
    assert times == {0.75} and found.stop() is None


def test_a_plug_longer_than_its_hole_touches_it_along_the_edges():
    """Its rims are outside: only the edges of degree 4 that slide on its side tell."""
    hole = fc.cylinder(Fraction(1, 2), 6).rotated((1, 0, 0), degrees=90)
    plug = fc.cylinder(Fraction(1, 2), 8).rotated((1, 0, 0), degrees=90).named("plug")
    found = fc.first_contact(fc.cylinder(1, 6) - hole, plug.moving(fc.Translation((0, Fraction(1, 2), 0))))
    assert found.status is fc.Status.INITIAL_CONTACT and found.initial == "touching"
    x, y, z = found.point
    assert x * x + y * y == pytest.approx(1) and x * x + z * z == pytest.approx(0.25)


def test_a_graze_stays_open_and_says_which_system():
    ball = fc.sphere(Fraction(1, 2)).translated((-1, Fraction(13, 10), Fraction(23, 20)))
    found = search(crossed(1, Fraction(3, 4)), ball.moving(fc.Translation((2, 0, 0))))  # 3-4-5 from (0, 1, 3/4)
    candidate, reason = found.stop()
    assert not found.first() and "precision" in reason and "det(grad A, grad B, grad C)" in reason
    root = candidate.root
    assert isinstance(root, OpenRoot) and root.lo < fmpq(1, 2) < root.hi and root.hi - root.lo < fmpq(1, 10**5)


def test_a_near_miss_and_a_near_graze_are_decided():
    for gap, count in ((Fraction(-1, 10**5), 2), (Fraction(1, 10**5), 0)):
        ball = fc.sphere(Fraction(1, 2)).translated((-1, Fraction(13, 10) + gap, Fraction(23, 20)))
        found = search(crossed(1, Fraction(3, 4)), ball.moving(fc.Translation((2, 0, 0))))
        near = [r for r in square_roots_of(found) if abs(float(r) - 0.5) < 0.1]
        assert len(near) == count and not any(isinstance(r, OpenRoot) for r in near)


@pytest.mark.thorough
def test_a_node_of_the_edge_leaves_an_open_stretch_around_a_known_contact():
    body = fc.sphere(2) & fc.cylinder(1, 8).translated((1, 0, 0))  # tangent inside at (2, 0, 0)
    found = search(body, fc.box((1, 9, 9)).translated((4, 0, 0)).moving(fc.Translation((-4, 0, 0))))
    assert {float(m.candidate.root) for m in found.first()} == {0.375} and found.stop() is None
    assert fmpq(0) < fmpq(3, 8) - found.open_from() < fmpq(1, 10**12)


# -- roots and systems ----------------------------------------------------------------------------------------


def spheres_and_planes() -> SquareSystem:
    """x^2 + y^2 + z^2 = 1, x = 0, y = u, z = 1/2: u = +-sqrt(3) / 2."""
    ball = constant(diagonal(fmpq(1), fmpq(1), fmpq(1), fmpq(-1)))

    def plane(k: int, level: fmpz_poly):
        nil, one = fmpz_poly([0]), fmpz_poly([2])
        rows = [[nil] * 4 for _ in range(4)]
        rows[k][3] = rows[3][k] = one
        rows[3][3] = level
        return tuple(map(tuple, rows))

    return SquareSystem([ball, plane(0, fmpz_poly([0])), plane(1, fmpz_poly([0, -4])), plane(2, fmpz_poly([-2]))])


@pytest.fixture(scope="module")
def half_root_three() -> EnclosedRoot:
    centre = [fmpq(0), fmpq(866, 1000), fmpq(1, 2), fmpq(866, 1000)]
    return EnclosedRoot(certified(spheres_and_planes(), centre, [fmpq(1, 1000)] * 4))


def test_roots_of_all_kinds_are_ordered(half_root_three):
    equal = AlgebraicRoot(fmpz_poly([-3, 0, 4]), fmpq(0), fmpq(1))
    below, above = fmpq(866, 1000), fmpq(867, 1000)
    root = half_root_three
    assert root.compare(equal) == 0 == equal.compare(root)
    assert root.compare(below) == 1 and root.compare(above) == -1
    assert AlgebraicRoot.of(below).compare(root) == -1 and AlgebraicRoot.of(above).compare(root) == 1
    assert root.sign_of(fmpz_poly([-3, 0, 4])) == 0 and root.sign_of(fmpz_poly([-1, 1])) == -1
    assert float(root) == math.sqrt(3) / 2 and root.number() is None
    stretch = OpenRoot(below, above, "precision")
    assert stretch.compare(root) == -1 and root.compare(stretch) == 1 and equal.compare(stretch) == 1
    assert stretch.compare(OpenRoot(below, above, "")) == 0 and stretch.compare(AlgebraicRoot.of(below)) == -1
    assert [stretch.compare(q) for q in (below - 1, below, above)] == [1, -1, -1]  # before what may be simultaneous


def test_no_zero_is_proved_where_there_is_none_or_two(half_root_three):
    system = spheres_and_planes()
    assert certified(system, [fmpq(0)] * 4, [fmpq(1, 100)] * 4) is None
    assert certified(system, [fmpq(0)] * 4, [fmpq(1)] * 4) is None
    again = certified(system, [fmpq(0), fmpq(43, 50), fmpq(1, 2), fmpq(43, 50)], [fmpq(1, 50)] * 4)
    assert again.is_same(half_root_three.zero)
    assert not half_root_three.zero.owns([fmpq(0), fmpq(-866, 1000), fmpq(1, 2), fmpq(-866, 1000)], [fmpq(0)] * 4)
