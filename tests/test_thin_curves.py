"""Intersection curves with parts nearer each other than the square root of rounding: both methods, both surfaces."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc

METHODS = ["algebraic", "certified"]
X0, Y0 = F(1, 3), F(-1, 7)
TOLERANCE = 1e-3


def graphs(f, g, x=(F(-2), F(2)), y=(F(-2), F(2))):
    """z = f(x - X0), ruled along y, and z = -g(y - Y0), ruled along x: they meet where f + g = 0."""

    def moved(c, at):
        """Coefficients of the polynomial in the variable less `at`."""
        found = [F(0)]
        for a in reversed(c):
            found = [p - at * q for p, q in zip([F(0), *found], [*found, F(0)], strict=True)]
            found[0] += a
        return found

    heights = moved(f, X0), [-c for c in moved(g, Y0)]
    p = [fc.RationalCurve([[0, 1], [end], heights[0]], [1]) for end in y]
    q = [fc.RationalCurve([[end], [0, 1], heights[1]], [1]) for end in x]
    return fc.RuledSurface(*p, u=x), fc.RuledSurface(*q, u=y)


def curve(p, q, method):
    """The curve, its points checked to be on both surfaces at their own parameters."""
    found = fc.intersection_curve(p, q, tolerance=TOLERANCE, method=method)
    assert not found.open_places and not found.two_dimensional
    for branch in found.branches:
        for surface, u, s in ((p, 0, 2), (q, 1, 3)):
            own = [surface.points(float(x[u]), [float(x[s])])[0] for x in branch.parameters]
            assert branch.points == pytest.approx(np.array(own), abs=1e-12)
    return found


def spans(branch) -> np.ndarray:
    """How far a branch goes along x and along y."""
    return np.ptp(branch.points, axis=0)[:2]


@pytest.mark.share(3)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("digits", [6, 8, 9, 11, 14])
def test_small_loops_are_as_small_as_they_are(digits, method):
    r = F(1, 10**digits)
    found = curve(*graphs([-r * r, 0, 1], [0, 0, 1]), method)
    (loop,) = found.branches
    assert loop.closed and not len(found.isolated_points)
    away = np.hypot(loop.points[:, 0] - float(X0), loop.points[:, 1] - float(Y0))
    assert away == pytest.approx(float(r), rel=1e-6, abs=2e-16)
    assert spans(loop) == pytest.approx(2 * float(r), rel=1e-2, abs=2e-16)


@pytest.mark.share(3)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("digits", [7, 10, 17])
@pytest.mark.parametrize("axis", [0, 1], ids=["along y", "along x"])
def test_slivers_are_as_thin_as_they_are(axis, digits, method):
    e = F(1, 10**digits)
    thin, long = [F(0), F(0), F(1)], [-e * e, F(0), e * e]
    found = curve(*graphs(*((thin, long) if axis == 0 else (long, thin))), method)
    (loop,) = found.branches
    width, length = spans(loop) if axis == 0 else spans(loop)[::-1]
    assert loop.closed and length == pytest.approx(2, abs=2 * TOLERANCE)
    assert width == pytest.approx(2 * float(e), rel=1e-2, abs=2e-16)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("digits", [7, 10, 15])
def test_branches_side_by_side_stay_two(digits, method):
    e = F(1, 10**digits)
    found = curve(*graphs([-e * e], [0, 0, 1]), method)
    assert [branch.closed for branch in found.branches] == [False, False]
    sides = sorted(float(branch.points[0, 1] - float(Y0)) for branch in found.branches)
    assert sides == pytest.approx([-float(e), float(e)], rel=1e-6, abs=1e-16)
    assert all(spans(branch) == pytest.approx([4, 0], abs=1e-15) for branch in found.branches)


@pytest.mark.share(3)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("digits", [8, 13])
def test_small_loops_are_cut_by_borders(digits, method):
    r = F(1, 10**digits)
    f, g = [-r * r, 0, 1], [0, 0, 1]
    (arc,) = curve(*graphs(f, g, (X0 - r / 2, F(2))), method).branches
    assert not arc.closed and [end.on for end in arc.ends] == [(f"u={X0 - r / 2}", "t=0")] * 2
    assert spans(arc) == pytest.approx([1.5 * float(r), 2 * float(r)], rel=1e-2, abs=2e-16)
    (arc,) = curve(*graphs(f, g, (X0, F(2)), (Y0, F(2))), method).branches
    assert not arc.closed and {end.on for end in arc.ends} == {(f"u={X0}", "t=0"), (f"v={Y0}", "s=0")}
    assert spans(arc) == pytest.approx(float(r), rel=1e-2, abs=2e-16)
    first, second = curve(*graphs(f, g, (X0 - r / 2, X0 + r / 3)), method).branches
    assert not first.closed and not second.closed
    assert abs(first.points[0, 1] - second.points[0, 1]) == pytest.approx(3**0.5 * float(r), rel=1e-6, abs=2e-16)


@pytest.mark.share(3)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("sign", [1, -1])
def test_necks_open_one_way_or_the_other(sign, method):
    """y^2 = x^2 (x + 1) with a little added: a loop beside an arc, or one arc."""
    e = F(sign, 10**14)
    found = curve(*graphs([e, 0, -1, -1], [0, 0, 1], (X0 - 2, X0 + 1)), method)
    assert sorted(branch.closed for branch in found.branches) == ([False, True] if sign > 0 else [False])
    assert not found.singular_points
    if sign > 0:
        gap = [np.abs(branch.points[:, 0] - float(X0)).min() for branch in found.branches]
        assert gap == pytest.approx([1e-7] * 2, rel=1e-4)


@pytest.mark.parametrize("method", METHODS)
def test_a_small_loop_beside_another_branch(method):
    """Over the loop there is a third root, on a strand with the same sign of the slope as one side of the loop."""
    e = F(1, 10**13)
    found = curve(*graphs([0, 0, -e], [e * e / 4, -e * e, F(-1, 4), 1]), method)
    loop, other = sorted(found.branches, key=lambda branch: not branch.closed)
    assert loop.closed and not other.closed
    assert spans(loop) == pytest.approx([1e-13 / e**0.5, 2e-13], rel=1e-2)
    assert other.points[:, 1].min() - float(Y0) > 0.2


def test_a_finding_of_the_soak():
    """A loop of 1e-9 beside parameters that are rational functions of u."""
    height = [F(24499999999999999999, 10**18), 28, 8]
    p = fc.RuledSurface(*(fc.RationalCurve([[4, 2], [y], height], [1]) for y in (-2, 3)), u=(-3, -1))
    rim = [-18, 36, -16], [-25, F(220, 3), F(-484, 9)]
    q = fc.RuledSurface(
        fc.RationalCurve([[0, 0, 0], *rim], [9, -12, 4]), fc.RationalCurve([[6, -8, F(8, 3)], *rim], [9, -12, 4]),
        s=(-3, 3),
    )  # fmt: skip
    for method in METHODS:
        (loop,) = curve(p, q, method).branches
        assert loop.closed and 0 < loop.length < 1e-8


@pytest.mark.parametrize("method", METHODS)
def test_surfaces_far_smaller_than_their_coordinates_keep_the_range_of_s(method):
    """Rulings of some 1e-6 next to (1, 1, 2), told by doubles: their places on rulings are known to 1e-10."""
    k = F(1, 2**20)
    sides = [
        [[-k, 4 * k], [k - 1, -4 * k], [-2 - k, k]], [[-k, -k], [2 * k - 1, -2 * k], [2 * k - 2, -3 * k]],
        [[-F(11, 3) * k, 4 * k], [F(11, 3) * k - 1, -4 * k], [-2 - F(5, 3) * k, k]],
        [[-F(7, 3) * k, k], [-1 - F(2, 3) * k, 2 * k], [2 * k - 2, -2 * k, k]],
    ]  # fmt: skip
    a, b, c, d = (fc.RationalCurve(x, [1]) for x in sides)
    p, q = fc.RuledSurface(a, b), fc.RuledSurface(c, d)
    for x in ((p, q), (q, p)):
        found = fc.intersection_curve(*x, tolerance=1e-9, method=method)
        assert found.branches
        for branch in found.branches:
            assert 0.0 <= branch.parameters[:, 2:].min() and branch.parameters[:, 2:].max() <= 1.0


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "u",
    [(F(1, 2), F(1, 2) + F(1, 2**60)), (F(-280000000000000001, 2 * 10**17), F(-419999999999999999, 3 * 10**17))],
    ids=["from a double", "about a double"],
)
def test_ranges_of_u_that_are_one_double(u, method):
    """Surfaces that touch along a ruling inside of the range: doubles leave that open."""
    middle = (u[0] + u[1]) / 2
    height = [middle**2, -2 * middle, 1]
    p = fc.RuledSurface(*(fc.RationalCurve([[0, 1], [y], height], [1]) for y in (0, 1)), u=u)
    q = fc.RuledSurface("(-3, u, 0)", "(2, u, 0)", u=(F(1, 3), F(2, 3)))
    for x in ((p, q), (q, p)):
        found = fc.intersection_curve(*x, tolerance=TOLERANCE, method=method)
        (branch,) = found.branches
        assert branch.multiplicity == 2 and branch.length == pytest.approx(1 / 3)
        assert not found.open_places


@pytest.mark.parametrize("k", [F(1), F(1, 2**40), F(1, 3**60), F(2**60)], ids=["as it is", "small", "smaller", "large"])
def test_scenes_of_all_sizes_have_the_same_curves(k):
    """Two cones with one apex share four rulings; a plane cuts a saddle in a box."""

    def sized(*sides, **ranges):
        ways = [[k if i == j < 3 else int(i == j) for j in range(4)] for i in range(4)]
        return fc.RuledSurface(*sides, **ranges).transformed(ways)

    cones = [sized("(1, 1, -2)", f"(1 + (1-u**2)/(1+u**2)*{a}, 1 + 2*u/(1+u**2)*{b}, -1)", u=None, s=(-1, 1))
             for a, b in ((2, 1), (1, 2))]  # fmt: skip
    for method in METHODS:
        found = fc.intersection_curve(*cones, tolerance=1e-3 * float(k), method=method)
        assert len(found.overlap_lines) == 4 and not found.branches
        assert found.isolated_points / float(k) == pytest.approx(np.array([[1, 1, -2]]))
        assert np.ptp(found.overlap_lines / float(k), axis=1)[:, 2] == pytest.approx(np.array([2, 2, 2, 2]))
    saddle, level = sized("(u, 0, 0)", "(u, 1, u)"), sized("(0, u, 1/3)", "(1, u, 1/3)")
    found = fc.intersection_curve(saddle, level, tolerance=1e-3 * float(k), box=((0, 0, 0), (k / 2, k, k)))
    (branch,) = found.branches
    assert {name for end in branch.ends for name in end.on} == {"v=1", "s=1", f"y={k}", f"x={k / 2}"}
    assert branch.length / float(k) == pytest.approx(0.374302, rel=1e-3)
    assert sorted(end.point[1] / float(k) for end in branch.ends) == pytest.approx([2 / 3, 1.0])
    assert found.box[1] / float(k) == pytest.approx(np.array([0.5, 1, 1]))
