"""Curves through corners of pieces, apexes, points that a piece passes twice, and cusps: by both paths.

The pieces are laid through chosen points; how many ways lead from there along the curve inside both of them, and
whether it turns back, tell power series in exact arithmetic.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from amount import THOROUGH, amount
from firstcontact.curves.certified.certified_curve import certified_curve
from local_curve import Directrix, Scene, evaluated, slopes
from polylines import told_twice

METHODS = ("certified", "algebraic")
PIECE = (-1, 1), (-1, 1)


def near(point: np.ndarray, points) -> int:
    """How many of the points are this one."""
    return sum(bool(np.abs(x - point).max() <= 1e-7 * max(1.0, np.abs(point).max())) for x in points)


def numbers(rng: np.random.Generator, degree: int) -> Directrix:
    return [[Fraction(int(x)) for x in rng.integers(-3, 4, degree + 1)] for _ in range(3)]


def through(first, second, places, ranges) -> Scene:
    """The second pair of directrices moved so that both pieces share the point at the places."""
    gap = [a - b for a, b in zip(evaluated(first, *places[0]), evaluated(second, *places[1]), strict=True)]
    moved = tuple([[c[0] + x, *c[1:]] for c, x in zip(end, gap, strict=True)] for end in second)
    return Scene(first, moved, places, ranges)


def kinds(curve: fc.IntersectionCurve, kind: str) -> list[np.ndarray]:
    return [x.point for x in curve.singular_points if x.kind == kind]


def same_answer(curves: list[fc.IntersectionCurve]) -> None:
    one, other = curves
    assert len(one.branches) == len(other.branches) and one.two_dimensional == other.two_dimensional
    assert len(one.overlap_lines) == len(other.overlap_lines)
    points = [(c.isolated_points, kinds(c, "node"), kinds(c, "cusp")) for c in curves]
    for own, others in zip(*points, strict=True):
        assert len(own) == len(others) and all(near(x, others) == 1 for x in own)


def both(p: fc.RuledSurface, q: fc.RuledSurface, tolerance: float = 1e-2) -> list[fc.IntersectionCurve]:
    curves = [fc.intersection_curve(p, q, tolerance=tolerance, method=method) for method in METHODS]
    assert not any(curve.open_places or told_twice(curve) for curve in curves)
    same_answer(curves)
    return curves


# -- corners ------------------------------------------------------------------------------------------------


CORNER = (
    fc.RuledSurface("(0, 2*u**3 + u**2 + u, -u**2 + 2*u + 1)", "(-u**3 - 2*u - 1, 2*u**3 + u - 1, u**2 - u + 2)",
                    s=(-1, 1)),
    fc.RuledSurface("(-3*u**2 + 2*u + 1, (-3*u**2 - 2*u + 4)/2, -4*u**2 + 2*u + 2)",
                    "(-5*u**3 + 2*u**2 + u + 2, 3*u**3 - 2*u**2 - 2*u + 1, u**2 - 2*u + 2)", s=(0, 2)),
)  # fmt: skip


@pytest.mark.parametrize("method", ["auto", *METHODS])
def test_a_curve_that_touches_a_corner_of_the_parameters_is_a_point(method):
    """Along the ruling v = 1 Delta has a double root at u = 0: rounding moves it 1e-8 into the piece."""
    for pair in (CORNER, CORNER[::-1]):
        found = fc.intersection_curve(*pair, tolerance=1e-4, method=method)
        assert not found.branches and not found.open_places
        assert found.isolated_points == pytest.approx(np.array([[0, 0, 1]]), abs=1e-15)


def test_a_corner_that_doubles_leave_open_is_no_branch():
    found = fc.IntersectionCurve(**certified_curve(*CORNER, 1e-4, settles=False), a=CORNER[0], b=CORNER[1])
    (place,) = found.open_places
    assert not found.branches and place.point == pytest.approx([0, 0, 1], abs=1e-6)


def test_a_point_on_a_bound_of_t_where_a_border_is_touched():
    """v = -1 is tangent to the first piece at u = -1/3, so doubles tell t there to 1e-7 only: it is 1."""
    p = fc.RuledSurface("(2 - 2*u, 1, 2 - 2*u)", "(2*u + 1, 3 - 2*u, -3*u)", u=(-1, 1), s=(0, 2))
    q = fc.RuledSurface("(-3*u - 7, 19/3 - 2*u, 1/3 - 2*u)", "(1/3, 11/3, 3*u + 4)", u=(-1, 0), s=(-1, 1))
    for curve in both(p, q):
        assert near(np.array([1 / 3, 11 / 3, 1]), curve.isolated_points) == 1


def corner_scene(rng: np.random.Generator) -> Scene:
    degree = int(rng.integers(1, 4))
    first, second = ((numbers(rng, degree), numbers(rng, degree)) for _ in range(2))
    ranges, places = [], []
    for _ in range(2):
        lows = [int(x) for x in rng.integers(-1, 1, 2)]
        own = tuple((low, low + int(rng.integers(1, 3))) for low in lows)
        ranges.append(own)
        places.append(tuple(Fraction(int(rng.choice(x))) if rng.random() < 0.6 else Fraction(2 * x[0] + x[1], 3)
                            for x in own))  # fmt: skip
    along_u, along_s = slopes(first, *places[0])
    (v, _), a, b = places[1], int(rng.integers(1, 3)), int(rng.integers(-2, 3))
    if rng.random() < 0.75:  # the ruling of the second piece is tangent to the first one
        way = [y - x for x, y in zip(*(evaluated((end, end), v, Fraction(0)) for end in second), strict=True)]
        for c, x, y, z in zip(second[1], along_u, along_s, way, strict=True):
            c[0] += a * x + b * y - z
    return through(first, second, tuple(places), tuple(ranges))


@pytest.mark.thorough
def test_curves_at_corners():
    rng, seen = np.random.default_rng(1), [0, 0, 0]
    for _ in range(amount(200, 8)):
        scene = corner_scene(rng)
        rays = scene.rays()
        if rays is None or scene.has_points_as_rulings():
            continue
        point = np.array([float(x) for x in scene.point])
        for curve in both(*scene.surfaces()):
            ends = [end.point for branch in curve.branches for end in branch.ends]
            passing = sum(near(point, branch.points) > 0 for branch in curve.branches)
            if rays == 0:
                assert near(point, curve.isolated_points) == 1 and not passing
            else:
                assert not near(point, curve.isolated_points) and near(point, ends) in ((1,) if rays == 1 else (0, 2))
        seen[rays] += 1
    assert seen[0] > 5 and seen[1] > 1


# -- apexes -------------------------------------------------------------------------------------------------


STAR = "(1/(u**2 + 1), (1 - u)/(u**2 + 1), -u/(u**2 + 1))"
CONE = fc.RuledSurface("(1, 1, 0)", "(-1/(u**2 + 1), u/(u**2 + 1), 1/(u**2 + 1))", u=(-1, 1), s=(-1, 1))


@pytest.mark.parametrize("reach", [3, 30, 1000, 10**6])
def test_an_apex_in_the_middle_of_the_common_box(reach):
    """All arcs found are at the origin of the kernels' coordinates, so the size of points tells nothing."""
    p = fc.RuledSurface("(-1, 0, 2)", STAR, u=(-1, 1), s=(-reach, reach))
    for pair in ((p, CONE), (CONE, p)):
        for tolerance in (1e-2, 1e-6):
            for curve in both(*pair, tolerance):
                found = np.array(sorted(curve.isolated_points.tolist()))
                assert not curve.branches
                assert found == pytest.approx(np.array([[0, 0, 1 / 3], [1, 1, 0]]), abs=1e-12)


def test_long_rulings_need_no_more_points():
    """A saddle against a strip: the ruling's far ends are not on the curve."""
    level = fc.RuledSurface("(-2, u, u/3)", "(2, u, u/3 + 1/7)", u=(-1, 1))
    counts = [sum(len(x.points) for x in fc.intersection_curve(
                  fc.RuledSurface("(u, -1, -u)", "(u, 1, u**3)", u=(-1, 1), s=(-far, far)), level, tolerance=1e-4,
                  method="certified").branches) for far in (8, 10**5)]  # fmt: skip
    assert 0 < counts[1] <= 4 * counts[0]


def apex_scene(rng: np.random.Generator) -> tuple[Scene, list[Fraction], Directrix, list[Fraction]]:
    """A piece through the apex of a cone with rulings along D(v); the apex is at t = tau(v)."""
    first = numbers(rng, int(rng.integers(1, 4))), numbers(rng, int(rng.integers(1, 4)))
    s_range = [(-3, 3), (0, 1), (-1000, 1000), (-1, 2)][int(rng.integers(0, 4))]
    u = Fraction(int(rng.integers(-1, 2))) if rng.random() < 0.6 else Fraction(int(rng.integers(-2, 3)), 3)
    s = Fraction(int(rng.choice(s_range))) if rng.random() < 0.3 else Fraction(1, 3)
    if rng.random() < 0.3:  # a cone too
        first = [[Fraction(int(x))] for x in rng.integers(-3, 4, 3)], first[1]
    apex, ways = evaluated(first, u, s), numbers(rng, int(rng.integers(1, 4)))
    tau = [Fraction(int(rng.integers(-2, 5)), 2), Fraction(int(rng.integers(-1, 2)), 2)]
    ends = tuple([[x - tau[0] * d[0] + k * d[0],
                   *(k * d[i] - tau[0] * d[i] - tau[1] * d[i - 1] for i in range(1, len(d))), -tau[1] * d[-1]]
                  for x, d in zip(apex, ways, strict=True)] for k in (0, 1))  # fmt: skip
    t_range = [(0, 1), (-1, 1), (-1000, 1000), (0, 2)][int(rng.integers(0, 4))]
    ranges = ((-1, 1), s_range), ((-1, 1), t_range)
    return Scene(first, ends, ((u, s), (Fraction(0), tau[0])), ranges), apex, ways, tau


@pytest.mark.thorough
def test_apexes_on_other_surfaces():
    """The curve passes through the apex along the rulings in the tangent plane of the other surface."""
    rng, seen = np.random.default_rng(2), {"off": 0, "alone": 0, "through": 0}
    for _ in range(amount(150, 8)):
        scene, apex, ways, tau = apex_scene(rng)
        (u, s), ((_, s_range), (_, t_range)) = scene.places[0], scene.ranges
        normal = np.cross(*np.array([[float(x) for x in way] for way in slopes(scene.first, u, s)]))
        tangent = np.roots((normal @ np.array([[float(c) for c in d] for d in ways]))[::-1])
        tangent = tangent[np.abs(tangent.imag) < 1e-4].real
        if not normal.any() or (np.abs(np.abs(tangent) - 1.0) < 1e-4).any():
            continue
        tangent = tangent[np.abs(tangent) < 1.0]
        if len(tangent) > 1 and np.diff(np.sort(tangent)).min() < 1e-4:
            continue
        curves = both(*scene.surfaces())
        on_cone = max(t_range[0], tau[0] - abs(tau[1])) <= min(t_range[1], tau[0] + abs(tau[1]))
        inner = [t for t in float(tau[0]) + float(tau[1]) * tangent if t_range[0] < t < t_range[1]]
        case = "alone" if not len(tangent) else "through" if inner and abs(u) < 1 and s not in s_range else None
        case = case if on_cone else "off"
        point = np.array([float(x) for x in apex])
        for curve in curves if not len(curves[0].overlap_lines) else ():
            passing = any(near(point, branch.points) for branch in curve.branches)
            assert case is None or near(point, curve.isolated_points) == (case == "alone")
            assert case in (None, "off") or passing == (case == "through")
        if case is not None:
            seen[case] += 1
    assert seen["alone"] >= 3 and seen["through"] >= 2


# -- points that a piece passes twice -----------------------------------------------------------------------


def twice_scene(rng: np.random.Generator) -> tuple[Scene, Scene]:
    """The first piece passes twice through a point of the second."""
    first, second = (tuple(numbers(rng, int(rng.integers(2, n))) for _ in range(2)) for n in (4, 3))
    s_range = [(0, 1), (-1, 2), (-1, 1)][int(rng.integers(0, 3))]

    def place(ends: tuple[int, int], at_end: float) -> Fraction:
        if rng.random() < at_end:
            return Fraction(int(rng.choice(ends)))
        return ends[0] + Fraction(int(rng.integers(1, 5)) * (ends[1] - ends[0]), 5)

    u, v, t = [place((-1, 1), 0.5), place((-1, 1), 0.5)], place((-1, 1), 0.3), place((-1, 1), 0.3)
    u[1] = Fraction(1, 7) if u[0] == u[1] else u[1]
    s = [x if x != 1 else Fraction(1, 2) for x in (place(s_range, 0.4), place(s_range, 0.4))]
    point = evaluated(second, v, t)
    gaps = [[(x - y) / (1 - b) for x, y in zip(point, evaluated(first, a, b), strict=True)]
            for a, b in zip(u, s, strict=True)]  # fmt: skip
    for c, x, y in zip(first[0], *gaps, strict=True):
        slope = (y - x) / (u[1] - u[0])
        c[0], c[1] = c[0] + x - slope * u[0], c[1] + slope
    one = Scene(first, second, ((u[0], s[0]), (v, t)), (((-1, 1), s_range), ((-1, 1), (-1, 1))))
    return one, replace(one, places=((u[1], s[1]), (v, t)))


@pytest.mark.thorough
def test_points_that_a_piece_passes_twice():
    """Where a branch ends or passes by one of the two sheets, the other one's touch is no isolated point."""
    rng, seen = np.random.default_rng(3), {}
    for _ in range(amount(150, 12)):
        one, other = twice_scene(rng)
        rays = one.rays(), other.rays()
        if None in rays or one.has_points_as_rulings():
            continue
        point = np.array([float(x) for x in one.point])
        p, q = one.surfaces()
        curves = both(p, q) if rng.random() < 0.5 else both(q, p)
        for curve in curves if not len(curves[0].overlap_lines) else ():
            assert near(point, curve.isolated_points) == (0 if any(rays) else 1)
        key = tuple(sorted(rays))
        seen[key] = seen.get(key, 0) + 1
    assert seen[0, 1] > 1 and sum(seen.values()) > 8


def test_a_sheet_that_touches_a_branch_between_its_points():
    """A wall over a nodal cubic: at u = -1 the curve passes the node, at u = 1 the wall only just reaches it."""
    sides = (f"(u**2 - 1, u**3 - u, (1 - u)*(3 + 5*u)/8 + {s})" for s in (0, 1))
    floor = fc.RuledSurface("(-3, u, 0)", "(3, u, 0)", u=(-2, 2))
    wall = fc.RuledSurface(*sides, u=(-2, 1))
    for pair in ((wall, floor), (floor, wall)):
        for tolerance in (1e-1, 1e-5):
            for curve in both(*pair, tolerance):
                assert len(curve.branches) == 1 and not len(curve.isolated_points)
                assert not near(np.zeros(3), curve.branches[0].points)
                assert not any(node.kind == "isolated" for node in curve.graph.nodes)


# -- cusps --------------------------------------------------------------------------------------------------


def cusp_scene(rng: np.random.Generator) -> Scene:
    """Through a point of the edge of regression, a pinch point, or a ruling at which the family stands still."""
    u, s, v, t = (Fraction(int(x), 4) for x in rng.integers(-2, 3, 4))
    kind = rng.integers(0, 3)
    if kind == 0:
        edge, s = numbers(rng, 3), Fraction(0)
        first = edge, [[a + b for a, b in zip(c, [c[1], 2 * c[2], 3 * c[3], Fraction(0)], strict=True)] for c in edge]
    elif kind == 1:
        one, way = numbers(rng, 2), numbers(rng, 2)
        k = int(rng.integers(-2, 3))
        for a, d in zip(one, way, strict=True):  # P1' + s d' = k d
            a[1] += k * (d[0] + d[1] * u + d[2] * u**2) - a[1] - 2 * a[2] * u - s * (d[1] + 2 * d[2] * u)
        first = one, [[x + y for x, y in zip(a, d, strict=True)] for a, d in zip(one, way, strict=True)]
    else:  # powers of u less its place, but for the first
        first = tuple([[a + b * u**2 - c * u**3, 3 * c * u**2 - 2 * b * u, b - 3 * c * u, c]
                       for a, b, c, _ in numbers(rng, 3)] for _ in range(2))  # fmt: skip
    degree = int(rng.integers(1, 3))
    return through(first, (numbers(rng, degree), numbers(rng, degree)), ((u, s), (v, t)), (PIECE, PIECE))


def test_cusps_do_not_depend_on_the_tolerance():
    rng, seen = np.random.default_rng(4), 0
    for _ in range(amount(60, 12)):
        scene = cusp_scene(rng)
        turns = scene.turns_back()
        if turns is None or scene.has_points_as_rulings():
            continue
        point = np.array([float(x) for x in scene.point])
        p, q = scene.surfaces()
        for tolerance in (1, 1e-2, 1e-3):
            for curve in both(p, q, tolerance) if tolerance != 1 else both(q, p, tolerance):
                assert near(point, kinds(curve, "cusp")) == int(turns)
        seen += turns
    assert seen > (2 if THOROUGH else 1)
