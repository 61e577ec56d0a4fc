"""The eleven cases one by one: a contact worked by hand for each file, then its degenerate configurations."""

from __future__ import annotations

from fractions import Fraction
from importlib import import_module
from math import sqrt

import pytest
from flint import fmpq, fmpz_poly

from carriers_by_hand import (
    DISC,
    SPAN,
    candidates,
    diagonal,
    level,
    moved,
    moved_plane,
    moved_quadric,
    points,
    pose,
    shift,
)
from firstcontact.exact.fields.roots import real_roots
from firstcontact.exact.polynomials.polynomial_matrix import constant
from firstcontact.pairs.carriers import cases as carrier_cases
from firstcontact.pairs.carriers import (
    conic_conic,
    conic_plane,
    conic_quadric,
    line_conic,
    line_line_carriers,
    line_quadric,
    plane_quadric,
    point_carriers,
    quadric_quadric,
)

SPHERE = diagonal(1, 1, 1, -1)
CYLINDER = diagonal(1, 1, 0, -1)
CONE = diagonal(1, 1, -1, 0)
SADDLE = diagonal(1, 1, -1, -1)  # one-sheet hyperboloid
REST = shift()
WIDE = fmpq(-10), fmpq(10)


def roots(equation, span=WIDE):
    return real_roots(equation.candidates, *span)


def solve(file, *carriers, span=WIDE):
    """[(u, Contacts)] at every candidate."""
    return [(float(r), file.contacts(*carriers, r)) for r in roots(file.equation(*carriers), span)]


def spheres_of(radius):
    return diagonal(1, 1, 1, -radius * radius)


# --- VI ----------------------------------------------------------------------------------------------------------


def test_vertex_on_plane():
    point, plane = moved(shift(z=[3, -2]), (1, 2, 0, 1)), moved_plane(REST, (0, 0, 1, -1))
    (root,) = roots(point_carriers.plane_equation(point, plane))
    assert root.rational == 1
    assert points(point_carriers.plane_contacts(point, plane, root)) == [(1, 2, 1)]
    sliding = point_carriers.plane_equation(moved(shift(x=[0, 1]), (0, 0, 1, 1)), plane)
    assert sliding.polynomial is None and "slides in the plane" in sliding.reason


def test_vertex_on_quadric():
    point = moved(shift(x=[3, -2]), (0, 0, 0, 1))
    first, second = roots(point_carriers.quadric_equation(point, SPHERE))
    assert (float(first), float(second)) == (1, 2)
    assert points(point_carriers.quadric_contacts(point, SPHERE, first)) == [(1, 0, 0)]
    (apex,) = roots(point_carriers.quadric_equation(point, CONE))
    assert apex.multiplicity == 2
    assert [c.note for c in point_carriers.quadric_contacts(point, CONE, apex).found] == ["apex"]
    along = point_carriers.quadric_equation(moved(shift(z=[0, 1]), (1, 0, 0, 1)), CYLINDER)
    assert along.polynomial is None and "slides in the quadric" in along.reason


# --- V -----------------------------------------------------------------------------------------------------------


def test_line_touches_sphere_at_an_irrational_time():
    """The line x = 1/2, y = 0 (along z) rises by y = 2u: it is tangent where 1/4 + 4 u^2 = 1."""
    line = moved(shift(y=[0, 2]), (0, 0, 1, 0), (1, 0, 0, 2))
    (before, _), (after, found) = solve(line_quadric, line, SPHERE)
    assert (before, after) == pytest.approx((-sqrt(3) / 4, sqrt(3) / 4), abs=1e-15)
    assert points(found)[0] == pytest.approx((0.5, sqrt(3) / 2, 0), abs=1e-12)


def test_line_and_ruled_surfaces():
    ruling = moved(shift(x=[3, -2]), (0, 0, 1, 0), (0, 0, 0, 1))  # parallel to the cylinder for all u
    none = line_quadric.equation(ruling, CYLINDER)
    assert none.polynomial is None and "tangent" in none.reason
    # x^2 + y^2 - z^2 = 1 contains the line (1, s, s); lifted by 1 - u it is there at u = 1
    line = moved(shift(z=[1, -1]), (0, 1, 1, 0), (1, 0, 0, 1))
    ((u, found),) = solve(line_quadric, line, SADDLE)
    assert (u, [c.kind for c in found.found]) == (1, ["line"])
    inside = line_quadric.equation(moved(REST, (0, 1, 1, 0), (1, 0, 0, 1)), SADDLE)
    assert inside.polynomial is None and "slides in the surface" in inside.reason


# --- IV ----------------------------------------------------------------------------------------------------------


def test_tilted_rim_on_plane():
    """A unit circle in the plane spanned by (4/5, 0, 3/5), (0, 1, 0), centre at height 2 - u: lowest 3/5 below."""
    rim = moved(shift(z=[2, -1]), (4, 0, 3, 0), (0, 5, 0, 0), (0, 0, 0, 5))
    (first, found), (second, _) = solve(conic_plane, rim, DISC, moved_plane(REST, (0, 0, -1, 0)))
    assert (first, second) == (1.4, 2.6)
    assert points(found) == [pytest.approx((-0.8, 0, 0))]


def test_level_rim_and_plane():
    plane = moved_plane(REST, (0, 0, -1, 0))
    ((u, found),) = solve(conic_plane, level(shift(z=[2, -1]), 0), DISC, plane)
    (contact,) = found.found
    assert (u, contact.kind, contact.note) == (2, "conic", "coplanar")
    sliding = conic_plane.equation(level(shift(x=[0, 1]), 0), DISC, plane)
    assert sliding.polynomial is None and "slides" in sliding.reason


def test_plane_parallel_to_the_plane_of_a_parabola():
    """A parabola touches the line at infinity of its plane: a root at which the planes are merely parallel."""
    parabola = (
        (fmpz_poly([1]), fmpz_poly([0]), fmpz_poly([0])),
        (fmpz_poly([0]), fmpz_poly([0]), fmpz_poly([-1])),
        (fmpz_poly([0]), fmpz_poly([-1]), fmpz_poly([0])),
    )
    # z = 1 + u y: parallel to z = 0 at u = 0, and its trace there is the line at infinity, which the parabola touches
    rows = ([1], [0], [0]), ([0], [1], [0]), ([0], [0, 1], [1]), ([0], [0], [1])
    basis = tuple(tuple(fmpz_poly(x) for x in row) for row in rows)
    (u, found), *_ = solve(conic_plane, basis, parabola, moved_plane(REST, (0, 0, 1, 0)))
    assert (u, found.found, found.reason) == (0, (), "planes parallel")


def test_parabola_in_a_plane_parallel_to_its_own():
    """It touches the line at infinity for all u: left are the u at which it lies in the plane."""
    parabola = constant([[1, 0, 0], [0, 0, -1], [0, -1, 0]])
    ((u, found),) = solve(conic_plane, level(shift(z=[2, -1]), 0), parabola, moved_plane(REST, (0, 0, -1, 0)))
    assert u == 2 and [c.note for c in found.found] == ["coplanar"]


# --- II ----------------------------------------------------------------------------------------------------------


def test_ball_on_plane():
    ball = moved_quadric(shift(z=[4, -2]), SPHERE)
    (first, found), (second, _) = solve(plane_quadric, moved_plane(REST, (0, 0, 1, 0)), ball)
    assert (first, second) == (1.5, 2.5)
    assert points(found) == [(0, 0, 0)]


def test_plane_cuts_a_saddle_in_two_lines():
    (_, found), (_, other) = solve(plane_quadric, moved_plane(shift(x=[0, 1]), (1, 0, 0, 0)), SADDLE)
    assert found.reason == other.reason == "crossing tangency"
    assert not found.found


@pytest.mark.parametrize("quadric", [CYLINDER, CONE])
def test_plane_against_rank_3_is_exempt(quadric):
    none = plane_quadric.equation(moved_plane(shift(x=[0, 1]), (1, 0, 0, 0)), quadric)
    assert none.polynomial is None and none.reason.startswith("exempt")


# --- XI ----------------------------------------------------------------------------------------------------------


def test_crossing_lines():
    falling = moved(shift(z=[3, -1]), (1, 0, 0, 0), (0, 2, 0, 1))
    ((u, found),) = solve(line_line_carriers, falling, moved(REST, (0, 1, 0, 0), (5, 0, 0, 1)))
    assert (u, points(found)) == (3, [(5, 2, 0)])


def test_lines_that_become_parallel_or_equal():
    turning = moved(pose((1, 0, 0, 0), (0, 1, 0, 1), (0, 0, 1, 1), (0, 0, 0, 1)), (1, 0, 0, 0), (0, 0, 0, 1))
    turning = tuple((row[0] + (fmpz_poly([0, 1]) if i == 1 else 0), row[1]) for i, row in enumerate(turning))
    resting = moved(REST, (1, 0, 0, 0), (0, 0, 0, 1))
    ((u, found),) = solve(line_line_carriers, turning, resting)  # direction (1, u, 0) through (0, 1, 1)
    assert (u, found.reason) == (0, "parallel")
    in_plane = tuple((row[0], row[1] * 0 if i == 2 else row[1]) for i, row in enumerate(turning))
    assert line_line_carriers.equation(in_plane, resting).polynomial is None
    # direction (1, u, u), through (0, 0, u): one line at u = 0
    meeting = tuple((fmpz_poly(d), fmpz_poly(p)) for d, p in (([1], [0]), ([0, 1], [0]), ([0, 1], [0, 1]), ([0], [1])))
    ((u, found),) = solve(line_line_carriers, meeting, resting)
    assert (u, [c.kind for c in found.found]) == (0, ["line"])


# --- IX, X -------------------------------------------------------------------------------------------------------


def test_line_through_rim():
    line = moved(shift(x=[0, 1]), (0, 0, 1, 0), (0, 0, 0, 1))
    (first, found), (second, _) = solve(line_conic, line, level(REST, 2), DISC)
    assert (first, second) == (-1, 1)
    assert points(found) == [(-1, 0, 2)]


def test_line_tangent_to_rim_in_its_plane():
    """Case X: the line y = 3 - u, z = 2 in the plane of the unit circle z = 2 for all u."""
    line = moved(shift(y=[3, -1]), (1, 0, 0, 0), (0, 0, 2, 1))
    (first, found), (second, _) = solve(line_conic, line, level(REST, 2), DISC)
    assert (first, second) == (2, 4)
    assert points(found) == [(0, 1, 2)]
    assert found.found[0].note == "coplanar"


def test_case_x_with_an_ellipse_and_a_slanted_line():
    """x + y = 6 - u against x^2/9 + y^2/16 = 1: tangent where (6 - u)^2 = 25, first at (9/5, 16/5)."""
    line = moved(shift(x=[6, -1]), (1, -1, 0, 0), (0, 0, 0, 1))
    (first, found), (second, _) = solve(
        line_conic, line, level(REST, 0), diagonal("1/9", "1/16", -1), span=(fmpq(0), fmpq(12))
    )
    assert (first, second) == (1, 11)
    assert points(found) == [pytest.approx((1.8, 3.2, 0))]


def test_line_in_the_plane_of_a_rim_at_one_time():
    line = moved(shift(z=[1, -1]), (1, 0, 0, 0), (0, 0, 0, 1))
    ((u, found),) = solve(line_conic, line, level(REST, 0), DISC)
    assert (u, sorted(points(found))) == (1, [(-1, 0, 0), (1, 0, 0)])
    far = moved(shift(z=[1, -1]), (1, 0, 0, 0), (0, 2, 0, 1))
    ((u, found),) = solve(line_conic, far, level(REST, 0), DISC)
    assert (u, found.found, found.reason) == (1, (), "imaginary")


# --- VII, VIII ---------------------------------------------------------------------------------------------------


def test_rims_in_perpendicular_planes():
    """Unit circles: z = 0 about the origin, and y = 0 about (4 - u, 0, 0)."""
    a = level(REST, 0), DISC
    b = moved(shift(x=[4, -1]), (1, 0, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)), DISC
    found = solve(conic_conic, a, b)
    assert [u for u, _ in found] == [2, 4, 6]
    assert points(found[0][1]) == [(1, 0, 0)]
    assert sorted(points(found[1][1])) == [(-1, 0, 0), (1, 0, 0)]


def test_rims_that_share_complex_points_only():
    """Both circles leave the common line x = 0 of the planes y = 2, z = 2 out."""
    a = moved(REST, (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 2, 1)), DISC
    b = moved(shift(x=[0, 1]), (1, 0, 0, 0), (0, 0, 1, 0), (0, 2, 0, 1)), DISC
    ((u, found),) = solve(conic_conic, a, b)
    assert (u, found.found, found.reason) == (0, (), "imaginary")


def test_rims_in_one_plane():
    """Case VIII: circles of radius 1 and 2, centres 6 - 2 u apart: they touch outside at 3, inside at 1."""
    a = level(REST, 1), DISC
    b = level(shift(x=[6, -2]), 1), diagonal(1, 1, -4)
    found = solve(conic_conic, a, b, span=(fmpq(0), fmpq(3)))
    assert [(u, points(f), [c.multiplier for c in f.found]) for u, f in found[:2]] == [
        (1.5, [(1, 0, 1)], [-1]),
        (2.5, [(-1, 0, 1)], [1]),
    ]
    assert [(u, f.found) for u, f in found[2:]] == [(3, ())]  # concentric: they share the circular points


def test_case_viii_with_ellipses_that_touch_in_two_points():
    """x^2/4 + y^2 = 1 inside x^2/4 + y^2/u^2 = 1 for u > 1: permanent double contact at (+-2, 0); the same at u = 1."""
    a = level(REST, 0), diagonal("1/4", 1, -1)
    b = level(pose((1, 0, 0, 0), (0, [0, 1], 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)), 0), diagonal("1/4", 1, -1)
    equation = conic_conic.equation(a, b)
    assert "divided out" in equation.reason
    (root,) = real_roots(equation.candidates, fmpq(1, 2), fmpq(2))
    assert float(root) == 1
    assert [c.kind for c in conic_conic.contacts(a, b, root).found] == ["conic"]


def test_concentric_circles_that_grow():
    a = level(REST, 0), DISC
    b = level(pose(([0, 1], 0, 0, 0), (0, [0, 1], 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)), 0), diagonal(1, 1, -4)
    equation = conic_conic.equation(a, b)
    (root,) = real_roots(equation.candidates, fmpq(1, 10), fmpq(1))
    assert root.rational == fmpq(1, 2)
    assert [c.kind for c in conic_conic.contacts(a, b, root).found] == ["conic"]


def test_parallel_rims():
    a, b = (level(REST, 0), DISC), (level(shift(x=3, z=[1, -1]), 0), DISC)
    ((u, found),) = solve(conic_conic, a, b)
    assert (u, found.found, found.reason) == (1, (), "coplanar: no common point")
    touching = level(shift(x=2, z=[1, -1]), 0), DISC
    ((u, found),) = solve(conic_conic, a, touching)
    assert (u, points(found)) == (1, [(1, 0, 0)])
    crossing = level(shift(x=1, z=[1, -1]), 0), DISC
    ((u, found),) = solve(conic_conic, a, crossing)
    assert (u, found.found, found.reason) == (1, (), "coplanar: the conics cross")
    flat = level(shift(z=[1, -1]), 0), diagonal("1/4", 4, -1)  # x^2/4 + 4 y^2 = 1: four common points
    assert [f.reason for _, f in solve(conic_conic, a, flat)] == ["coplanar: the conics cross"]
    never = conic_conic.equation(a, (level(shift(x=[0, 1], z=1), 0), DISC))
    assert never.candidates.degree() == 0


# --- III ---------------------------------------------------------------------------------------------------------


def test_rim_on_sphere():
    """The circle x^2 + y^2 = 1, z = 0, moved by (4 - u, 0, 3/5), meets the unit sphere's section of radius 4/5."""
    rim = level(pose((5, 0, 0, [20, -5]), (0, 5, 0, 0), (0, 0, 5, 3), (0, 0, 0, 5)), 0)
    found = [x for x in solve(conic_quadric, rim, DISC, SPHERE) if x[1].found]
    assert [u for u, _ in found] == pytest.approx([2.2, 3.8, 4.2, 5.8])
    assert [points(f) for _, f in found[:2]] == [[pytest.approx((0.8, 0, 0.6))], [pytest.approx((-0.8, 0, 0.6))]]
    assert [f.found[0].multiplier for _, f in found[:2]] == [-1, 1]


def test_rim_coaxial_with_sphere():
    """Permanent double contact at the circular points: the rim lies in the sphere where (2 - u)^2 = 1 - 16/25."""
    rim = level(shift(z=[2, -1]), 0), diagonal(1, 1, "-16/25")
    equation = conic_quadric.equation(*rim, SPHERE)
    assert "divided out" in equation.reason
    first, second = roots(equation)
    assert (float(first), float(second)) == (1.4, 2.6)
    assert [c.kind for c in conic_quadric.contacts(*rim, SPHERE, first).found] == ["conic"]


def test_rim_of_a_parallel_cylinder():
    """Cylinders with parallel axes: the rim touches where the axes are 2 apart."""
    rim = level(shift(x=[4, -1]), 3), DISC
    found = [(u, points(f)) for u, f in solve(conic_quadric, *rim, CYLINDER) if f.found and f.found[0].kind == "point"]
    assert found == [(2, [(1, 0, 3)]), (6, [(-1, 0, 3)])]
    sliding = conic_quadric.equation(level(shift(z=[0, 1]), 0), DISC, CYLINDER)
    assert sliding.polynomial is None and "slides in the surface" in sliding.reason


def test_rim_under_a_cylinder_whose_ruling_comes_to_lie_across_it():
    """The section is two parallel lines for all u, and the permanent root l = 0 hides that they become one."""
    rim = level(pose((2, 0, 0, 1), (0, 2, 0, 0), (0, 0, 2, [8, -2]), (0, 0, 0, 2)), 0)
    lying = diagonal(1, 0, 1, -1)
    touching = [(u, f) for u, f in solve(conic_quadric, rim, DISC, lying) if len(f.found) == 2]
    assert [u for u, _ in touching] == [3, 5]
    assert sorted(points(touching[0][1])) == [pytest.approx((0, y, 1)) for y in (-sqrt(3) / 2, sqrt(3) / 2)]


def test_rim_that_a_ruling_sweeps_over():
    """The plane of the rim touches the cylinder for all u: its double line meets the rim from u = 1 on."""
    rim, lying = level(shift(x=[2, -1], z=1), 0), diagonal(1, 0, 1, -1)
    equation = conic_quadric.equation(rim, DISC, lying)
    assert equation.may_hold_always
    first, second = (conic_quadric.contacts(rim, DISC, lying, root) for root in roots(equation))
    assert (points(first), points(second)) == ([(0, 0, 1)], [(0, 0, 1)])
    assert [float(root) for root in roots(equation)] == [1, 3]


# --- I -----------------------------------------------------------------------------------------------------------


def test_ellipsoids():
    """x^2/4 + y^2 + z^2 = 1 and its copy turned by 90 degrees about z, centre (6 - u, 0, 0): 2 + 1 apart."""
    a, b = diagonal("1/4", 1, 1, -1), moved_quadric(shift(x=[6, -1]), diagonal(1, "1/4", 1, -1))
    found = [(u, f) for u, f in solve(quadric_quadric, a, b, span=(fmpq(0), fmpq(6))) if f.found]
    assert found[0][0] == 3
    assert points(found[0][1]) == [(2, 0, 0)]
    assert found[0][1].found[0].multiplier == -1


def test_spheres_whose_discriminant_vanishes():
    """Radii 1 and 2, centres 6 - 2 u apart."""
    a, b = SPHERE, moved_quadric(shift(x=[6, -2]), spheres_of(2))
    assert "divided out" in quadric_quadric.equation(a, b).reason
    found = [
        (u, points(f), f.found[0].multiplier)
        for u, f in solve(quadric_quadric, a, b, span=(fmpq(0), fmpq(3)))
        if f.found
    ]
    assert found == [(1.5, [(1, 0, 0)], -1), (2.5, [(-1, 0, 0)], 1)]


def test_spheres_at_an_irrational_time():
    """Centres (u, 1, 0) and the origin, radii 1: the distance is 2 at u = sqrt 3; the point is (sqrt 3, 1, 0)/2."""
    found = [x for x in solve(quadric_quadric, SPHERE, moved_quadric(shift(x=[0, 1], y=1), SPHERE)) if x[1].found]
    assert [u for u, _ in found] == [-sqrt(3), sqrt(3)]
    assert points(found[1][1]) == [pytest.approx((sqrt(3) / 2, 0.5, 0), abs=1e-15)]


def test_parallel_cylinders():
    """Identically degenerate: contact along the ruling x = 1."""
    a, b = CYLINDER, moved_quadric(shift(x=[6, -1]), diagonal(1, 1, 0, -4))
    assert "case VIII" in quadric_quadric.equation(a, b).reason
    found = [x for x in solve(quadric_quadric, a, b, span=(fmpq(0), fmpq(6))) if x[1].found]
    assert [u for u, _ in found] == [3, 5]
    (line,) = found[0][1].found
    assert line.kind == "line" and line.multiplier == -1
    p, q = ([float(x.ball(64)) for x in v] for v in line.span)
    assert (p[0] / p[3], p[1] / p[3]) == (1, 0)
    assert q[0] == q[1] == q[3] == 0 != q[2]


def test_crossed_cylinders():
    """Axes z and x, the second lifted to y = 3 - u: they touch at (0, 1, 0) when 2 apart."""
    other = moved_quadric(shift(y=[3, -1]), diagonal(0, 1, 1, -1))
    found = [x for x in solve(quadric_quadric, CYLINDER, other, span=(fmpq(0), fmpq(5, 2))) if x[1].found]
    assert [(u, points(f)) for u, f in found] == [(1, [(0, 1, 0)])]


def test_ball_in_tube_touches_along_a_circle():
    """A sphere whose radius grows inside the coaxial cylinder."""
    growing = pose((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, [2, -1]))
    found = [
        x
        for x in solve(quadric_quadric, CYLINDER, moved_quadric(growing, SPHERE), span=(fmpq(1, 2), fmpq(3, 2)))
        if x[1].found
    ]
    ((u, f),) = found
    assert (u, [c.kind for c in f.found], [c.multiplier for c in f.found]) == (1, ["conic"], [1])


def test_apex_is_left_to_case_vi():
    """The apex of a coaxial cone meets the sphere at u = 1; its flank does in a circle, the apex sqrt 2 away."""
    cone = moved_quadric(shift(z=[2, -1]), CONE)
    found = solve(quadric_quadric, cone, SPHERE, span=(fmpq(0), fmpq(3, 2)))
    assert [(u, [c.kind for c in f.found]) for u, f in found if f.found] == [(pytest.approx(2 - sqrt(2)), ["conic"])]
    tip = moved(shift(z=[2, -1]), (0, 0, 0, 1))
    assert candidates(point_carriers.quadric_equation(tip, SPHERE), (fmpq(0), fmpq(2))) == [(1, 1)]


def test_cones_that_slide_on_a_shared_ruling():
    cone = moved_quadric(shift(x=[0, 1], z=[0, 1]), CONE)
    none = quadric_quadric.equation(CONE, cone)
    assert none.polynomial is None and none.reason == quadric_quadric.DEGENERATE


# --- Example 8 ---------------------------------------------------------------------------------------------------


EXAMPLE_8 = (
    (
        (
            "-0.707106781186547524400844362104849039284835938",
            "1.95540966251929203320141192957608749863074394",
            "-0.248302881332744508800567567471238459345908001",
        ),
        (
            "0.707106781186547524400844362104849039284835938",
            "-0.107650597496718520945045550782510924985910687",
            "-0.599456183689829003455798811322338114298925251",
        ),
        (
            "0",
            "1.30656296487637652785664317342718715358376119",
            "-1.30656296487637652785664317342718715358376119",
        ),
        (
            "-30",
            "103.764116995614090468008303839008317398167838",
            "-131.292350986842271404024911517024952194503514",
            "87.5282339912281809360166076780166347963356762",
        ),
    ),
    (
        (
            "-0.707106781186547524400844362104849039284835938",
            "0.107650597496718520945045550782510924985910687",
            "0.599456183689829003455798811322338114298925251",
        ),
        (
            "-0.707106781186547524400844362104849039284835938",
            "1.95540966251929203320141192957608749863074394",
            "-1.248302881332744508800567567471238459345908",
        ),
        (
            "0",
            "0.541196100146196984399723205366389420061072063",
            "0.458803899853803015600276794633610579938927937",
        ),
        (
            "-1",
            "-7.54119610014619698439972320536638942006107206",
            "11.6704311988304241248022143570688846395114235",
            "-13.1292350986842271404024911517024952194503514",
        ),
    ),
    (
        (
            "0",
            "1.30656296487637652785664317342718715358376119",
            "-1.30656296487637652785664317342718715358376119",
        ),
        (
            "0",
            "-0.541196100146196984399723205366389420061072063",
            "-0.458803899853803015600276794633610579938927937",
        ),
        (
            "1",
            "-1.45880389985380301560027679463361057993892794",
            "0.458803899853803015600276794633610579938927937",
        ),
        (
            "10",
            "-34.5880389985380301560027679463361057993892794",
            "43.7641169956140904680083038390083173981678381",
            "-29.1760779970760603120055358926722115987785587",
        ),
    ),
    (
        ("0",),
        ("0",),
        ("0",),
        (
            "1",
            "-1.45880389985380301560027679463361057993892794",
            "1.45880389985380301560027679463361057993892794",
        ),
    ),
)


def test_example_8_rim_and_cone():
    """Choi et al. 2014, Example 8: a rim of A (radius 2 about (-6, -10, 0), plane x = -6) against a cone of B.

    The motion's irrational coefficients are rounded to 45 decimals, so the time is good to 1e-40.
    """
    scale = 10**48
    m_b = tuple(tuple(fmpz_poly([int(Fraction(x) * scale) for x in entry]) for entry in row) for row in EXAMPLE_8)
    m_a = pose((1, 0, 0, [15, -45]), (0, 1, 0, [15, -25]), (0, 0, 1, 0), (0, 0, 0, 1))
    rim = moved(m_a, (0, 1, 0, 0), (0, 0, 1, 0), (-6, -10, 0, 1))
    cone = constant([[fmpq(x) for x in row] for row in ((1, 0, 0, 0), (0, -1, 0, 8), (0, 0, 1, 0), (0, 8, 0, -64))])
    carriers = rim, diagonal(1, 1, -4), moved_quadric(m_b, cone)
    hits = [
        r for r in real_roots(conic_quadric.equation(*carriers).candidates, *SPAN) if abs(float(r) - 0.313244603) < 1e-6
    ]
    (root,) = hits
    assert float(root) == pytest.approx(0.31324460346078811229, abs=1e-16)
    (contact,) = conic_quadric.contacts(*carriers, root).found
    expected = (-5.096007155735465052885, -4.316322481050139353934, 1.339462203734062889994)
    assert [float(x) for x in contact.point()] == pytest.approx(expected, abs=1e-12)
    assert contact.multiplier == -1


# --- the table ---------------------------------------------------------------------------------------------------


def test_every_pair_of_kinds_has_a_case_or_a_reason():
    kinds = carrier_cases.KINDS
    for i, a in enumerate(kinds):
        for b in kinds[i:]:
            entry = carrier_cases.PAIRS[a, b]
            assert carrier_cases.case_of(b, a) is entry
            if isinstance(entry, carrier_cases.Exempt):
                assert entry.reason
            else:
                assert import_module(f"firstcontact.pairs.carriers.{entry.file}")
    cases = [e for e in carrier_cases.PAIRS.values() if isinstance(e, carrier_cases.Case)]
    numbers = {e.number for e in cases} | {e.planar for e in cases if e.planar}
    assert numbers == {"I", "II", "III", "IV", "V", "VI", "VII", "VIII", "IX", "X", "XI"}
