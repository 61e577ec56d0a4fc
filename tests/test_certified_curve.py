"""Certified intersection curves of ruled strips: against the exact path, against sampled rulings, and under changes."""

from __future__ import annotations

import json
import pickle
from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from amount import amount
from firstcontact.curves.certified.certified_curve import certified_curve
from polylines import distance, told_twice

TOLERANCE = 1e-4


def certified(p, q, tolerance=TOLERANCE) -> fc.IntersectionCurve:
    return fc.intersection_curve(p, q, tolerance=tolerance, method="certified")


def in_doubles(p, q, tolerance=TOLERANCE) -> fc.IntersectionCurve:
    """The same, but that nothing is decided exactly."""
    return fc.IntersectionCurve(**certified_curve(p, q, tolerance, settles=False), a=p, b=q)


def strip(rng: np.random.Generator, n: int, along: int, height: float = 0.5):
    """A cubic B-spline of n poles along x or y, one apart, heights at random."""
    grid = [[[0.0, 0.0, float(rng.uniform(-height, height))] for _ in range(2)] for _ in range(n)]
    for k, row in enumerate(grid):
        for point, end in zip(row, (-1.0, float(n)), strict=True):
            point[along], point[1 - along] = float(k), end
    return fc.RuledSurface.from_nurbs(grid, [0] * 4 + list(range(1, n - 3)) + [n - 3] * 4)


def random_piece(rng: np.random.Generator) -> fc.RuledSurface:
    degree = int(rng.integers(1, 4))
    below = [1] if rng.random() < 0.6 else [4, int(rng.integers(-2, 3)), 2]
    first, second = (fc.RationalCurve(rng.integers(-5, 6, (3, degree + 1)).tolist(), below) for _ in range(2))
    return fc.RuledSurface(first, second, u=(-1, 1))


def same_curve(x: fc.IntersectionCurve, y: fc.IntersectionCurve, near: float, moved=lambda points: points) -> None:
    """Equally many arcs and loops, and points of either on the other, the first moved."""
    assert sorted(b.closed for b in x.branches) == sorted(b.closed for b in y.branches)
    assert x.graph.components == y.graph.components
    for branch in x.branches:
        assert distance(moved(branch.points[::17]), y.branches) <= near
    back = [type(b)(moved(b.points), b.parameters, b.closed, b.ends) for b in x.branches]
    for branch in y.branches:
        assert distance(branch.points[::17], back) <= near


def test_exact_and_certified_path_agree_on_random_pieces():
    rng, seen = np.random.default_rng(7), 0
    for _ in range(amount(60, 5)):
        p, q = random_piece(rng), random_piece(rng)
        found = certified(p, q)
        assert found.method == "certified" and not found.open_places and not found.stats.exact_evaluations
        known = fc.intersection_curve(p, q, tolerance=TOLERANCE, method="algebraic")
        same_curve(found, known, 2.5 * TOLERANCE)
        assert not told_twice(found) and not told_twice(known)
        seen += len(found.branches)
    assert seen >= amount(60, 5) // 2


def exact_point(surface, u: float, r: float) -> np.ndarray:
    piece = next(x for x in surface.pieces if x.u is None or x.u[0] <= Fraction(u) <= x.u[1])
    ends = []
    for curve in (piece.first, piece.second):
        x, y, z, w = (sum(int(c) * Fraction(u) ** k for k, c in enumerate(f.coeffs())) for f in curve.components)
        ends.append([x / w, y / w, z / w])
    return np.array([float((1 - Fraction(r)) * a + Fraction(r) * b) for a, b in zip(*ends, strict=True)])


STRIPS = {n: (strip(np.random.default_rng(n), n, 0), strip(np.random.default_rng(n + 1), n, 1)) for n in (8, 30)}


@pytest.mark.parametrize("n", STRIPS)
def test_points_of_strips_are_on_both_surfaces(n):
    p, q = STRIPS[n]
    found = certified(p, q)
    assert found.branches and not found.open_places
    for branch in found.branches:
        assert (np.linalg.norm(np.diff(branch.points, axis=0), axis=1) < 1).all()
        step = 1 + len(branch.points) // 5
        for point, (u, v, s, t) in zip(branch.points[::step], branch.parameters[::step], strict=True):
            assert 0 <= s <= 1 and 0 <= t <= 1
            for surface, x, r in ((p, u, s), (q, v, t)):
                assert np.abs(exact_point(surface, x, r) - point).max() <= 1e-13 * n
        for end in branch.ends:
            assert end.kind == "boundary" and end.on and end.exact is None


@pytest.mark.share(2)
@pytest.mark.parametrize("n", STRIPS)
def test_no_branch_of_strips_is_missed(n):
    """Rulings of either at random meet the other where a volume changes its sign along it."""
    rng, seen = np.random.default_rng(3), 0
    p, q = STRIPS[n]
    found = certified(p, q)
    for mine, other in ((p, q), (q, p)):
        for _ in range(80 // n):
            ends = mine.pieces[rng.integers(len(mine.pieces))]
            ends = ends.points(rng.uniform(*map(float, ends.u)), [0.0, 1.0])
            for piece in other.pieces:
                v = np.linspace(*map(float, piece.u), 60)
                a, along = piece.points(v, 0.0), ends[1] - ends[0]
                across = piece.points(v, 1.0) - a
                volume = np.einsum("ij,ij->i", a - ends[0], np.cross(along, across))
                for k in np.flatnonzero(volume[:-1] * volume[1:] < 0):
                    normal = np.cross(along, across[k])
                    s, t = (np.linalg.det([a[k] - ends[0], x, normal]) / (normal @ normal) for x in (across[k], along))
                    if 0.02 < s < 0.98 and 0.02 < t < 0.98:
                        seen += 1
                        assert distance((ends[0] + s * along)[None], found.branches) < 0.1
    assert seen >= 10


def test_a_strip_has_the_branches_of_its_pieces_joined():
    p, q = STRIPS[8]
    whole = certified(p, q)
    parts = [certified(a, b) for a in p.pieces for b in q.pieces]
    lengths = [
        sum(np.linalg.norm(np.diff(b.points, axis=0), axis=1).sum() for curve in curves for b in curve.branches)
        for curves in ([whole], parts)
    ]
    assert lengths[0] == pytest.approx(lengths[1], rel=1e-3)
    joints = sum(end.point.tolist() not in [e.point.tolist() for b in whole.branches for e in b.ends]
                 for curve in parts for branch in curve.branches for end in branch.ends)  # fmt: skip
    assert joints > 0 and len(whole.branches) < sum(len(curve.branches) for curve in parts)
    for curve in parts:
        for branch in curve.branches:
            assert distance(branch.points[::23], whole.branches) <= 2 * TOLERANCE


def graze(depth: str, x: str = "-1/7", y: str = "3/20"):
    """z = 1 - y^2 / 2 and z = 1 - depth + x^2 / 2: a circle of radius sqrt(2 depth) seen from above."""
    p = [f"({end}, u + {y}, 1 - u**2/2)" for end in (-1, 1)]
    q = [f"(u + {x}, {end}, 1 - {depth} + u**2/2)" for end in (-1, 1)]
    return fc.RuledSurface(*p, u=(-1, 1)), fc.RuledSurface(*q, u=(-1, 1))


@pytest.mark.parametrize("k", [2, 4, 6, 8, 10])
def test_tiny_loops_are_found(k):
    found = certified(*graze(f"1/{10**k}"), tolerance=1e-6)
    (loop,) = found.branches
    assert loop.closed and not found.open_places
    around = loop.points[:, :2] - [-1 / 7, 3 / 20]
    # a loop of few chords, when it is smaller than the tolerance
    assert np.hypot(*around.T) == pytest.approx((2 * 10.0**-k) ** 0.5, rel=max(1e-10, 10.0 ** (k - 15)))


def test_a_touch_is_open_and_a_miss_is_proved():
    found = in_doubles(*graze("0"))
    (place,) = found.open_places
    assert not found.branches and not found.empty and place.ends == 0
    assert place.point == pytest.approx([-1 / 7, 3 / 20, 1], abs=1e-5)
    assert place.u[0] <= 0 <= place.u[1] and place.v[1] - place.v[0] < 1e-4
    assert "undecided near" in str(found) and json.loads(found.to_json())["open_places"]
    assert certified(*graze("-1/10**10")).empty


CIRCLE = "(1-u**2)/(1+u**2), 2*u/(1+u**2)"


def pipe(radius: str, axis: str, height: int = 2) -> fc.RuledSurface:
    curves = []
    for z in (-height, height):
        x, y = (f"{radius}*{c}" for c in CIRCLE.split(", "))
        curves.append(f"({x}, {y}, {z})" if axis == "z" else f"({z}, {x}, {y})")
    return fc.RuledSurface(*curves, u=None)


def test_closed_surfaces_give_loops():
    found = certified(pipe("1", "z"), pipe("3/5", "x"))
    assert [b.closed for b in found.branches] == [True, True] and not found.open_places
    for branch in found.branches:
        x, y, z = branch.points.T
        assert np.abs(np.hypot(x, y) - 1).max() < 1e-14 and np.abs(np.hypot(y, z) - 0.6).max() < 1e-14
    assert str(pickle.loads(pickle.dumps(found))) == str(found)


def test_crossings_are_left_open_and_auto_decides_them():
    p, q = pipe("1", "z"), pipe("1", "x")
    found = in_doubles(p, q)
    assert len(found.branches) == 4 and {e.kind for b in found.branches for e in b.ends} == {"undecided"}
    assert sorted(np.round(x.point[1], 5) for x in found.open_places) == [-1, 1]
    assert [x.ends for x in found.open_places] == [4, 4]
    decided = fc.intersection_curve(p, q, tolerance=TOLERANCE)
    assert decided.method == "exact" and len(decided.singular_points) == 2
    for branch in found.branches:
        assert distance(branch.points[::17], decided.branches) <= 2 * TOLERANCE


def test_a_branch_that_touches_a_bound_goes_on():
    """v = (u - 1/3)^2: doubles see it end at v = 0 and begin again, so that place is open."""
    trough = fc.RuledSurface("(u, -1, (u - 1/3)**2)", "(u, 1, (u - 1/3)**2)", u=(-1, 1))
    level = fc.RuledSurface("(-2, u/2, u)", "(2, u/2, u)")
    for pair in ((trough, level), (level, trough)):
        (branch,) = certified(*pair).branches
        assert {end.on for end in branch.ends} == {("u=1",), ("v=1",)}
        assert branch.length == pytest.approx(2.4342, abs=1e-3)
        (place,) = in_doubles(*pair).open_places
        assert place.point == pytest.approx([1 / 3, 0, 0], abs=1e-5) and place.ends == 2


def test_a_branch_seems_to_end_twice_where_it_touches_a_bound():
    """At u = 1, v = 0, where rounding puts it a little outside: nothing else tells of it."""
    cone = fc.RuledSurface("(-1, 1, 1)", "((-u**2 - 4*u - 1)/(u**2 + 1), -1, (-4*u - 4)/(u**2 + 1))",
                           u=("-1/2", "3/2"), s=(-1, 2))  # fmt: skip
    first = "((-u**2 + 2*u - 1)/(u**2 + 1), (-u**2 - 2*u + 1)/(u**2 + 1), 2*u**2/(u**2 + 1))"
    second = "(2*u/(u**2 + 1), (-2*u + 2)/(u**2 + 1), (3*u**2 + 1)/(u**2 + 1))"
    (branch,) = certified(cone, fc.RuledSurface(first, second, s=(-1, 1))).branches
    assert {end.on for end in branch.ends} == {("u=-1/2",), ("u=3/2",)}


def test_auto_takes_the_path_that_fits():
    p, q = STRIPS[8]
    assert fc.intersection_curve(p, q, tolerance=TOLERANCE).method == "certified"
    high = fc.RuledSurface("(u, u**5, 0)", "(u**2, u, 1)"), fc.RuledSurface("(u, 1/2, u**4)", "(u**3 + 1/5, u, 1/4)")
    found = fc.intersection_curve(*high, tolerance=TOLERANCE)
    assert found.method == "certified" and not found.open_places
    same_curve(found, fc.intersection_curve(*high, tolerance=TOLERANCE, method="algebraic"), 2.5 * TOLERANCE)


def test_a_point_at_a_corner_of_the_parameters_is_open():
    """The rulings u = 0 and v = 0 meet, and no others near them; at u = v = 1 a branch ends in such a point."""
    p, q = fc.RuledSurface("(u, u**5, 0)", "(u**2, u, 1)"), fc.RuledSurface("(u, 1/2, u**4)", "(u**3, u, 1/3)")
    found = in_doubles(p, q)
    (place,), (branch,) = found.open_places, found.branches
    assert place.point == pytest.approx([0, 0, 1 / 3], abs=1e-12) and place.ends == 0
    assert any(end.point == pytest.approx([1, 1, 1 / 3]) for end in branch.ends)
    assert fc.intersection_curve(p, q, method="algebraic").isolated_points == pytest.approx(np.array([[0, 0, 1 / 3]]))


CORNERS = [
    (("(-u, -1, 1 - u)", "(-u, 0, 2 - u)", (0, 1), (-1, 2)),
     ("(0, 0, -1)", "((2 - 4*u - 2*u**2)/(u**2 + 1), (3 + 4*u - u**2)/(u**2 + 1), -1)", (-1, 1), (-1, 1)),
     (-1, -2, -1)),
    (("(2*u + 1, 2*u + 1, 2 - 2*u)", "(1 - u, -2*u, -u - 1)", (0, 1), (0, 1)),
     ("(-2*u, -2, 2*u - 2)", "(u**2 + 2*u - 1, 2*u - 2*u**2 - 2, u - 2*u**2)", (0, 2), (-1, 1)),
     (0, -2, -2)),
]  # fmt: skip


@pytest.mark.parametrize(("p", "q", "point"), CORNERS)
def test_an_arc_that_only_touches_a_piece_at_a_corner_is_no_branch(p, q, point):
    """It leaves the range of s where it begins: nothing of it is kept."""
    p, q = (fc.RuledSurface(*x[:2], u=x[2], s=x[3]) for x in (p, q))
    found = in_doubles(p, q)
    assert not found.branches and len(found.open_places) == 1
    exact = fc.intersection_curve(p, q)
    assert not exact.branches and exact.isolated_points.tolist() == [list(point)]


def test_rulings_through_an_apex_are_no_branch():
    """All rulings of the cone meet u = 0 in its apex: no chord there is ever short enough to be proved."""
    saddle = fc.RuledSurface("(2*u, -u - 1, 2*u + 1)", "(u - 1, -u - 1, 1 - u)", u=("-1/2", "3/2"), s=(0, 2))
    ring = "((4*u - u**2 - 1)/(u**2 + 1), (1 - 4*u - 3*u**2)/(u**2 + 1), (4*u - u**2 - 5)/(u**2 + 1))"
    cone = fc.RuledSurface("(-1, -1, 1)", ring, u=(-2, 2), s=(-1, 1))
    found = certified(saddle, cone)
    assert len(found.branches) == 4 and not found.open_places
    assert not len(found.isolated_points) and found.stats.exact_evaluations  # one of the branches is through the apex
    assert distance(np.array([[-1.0, -1.0, 1.0]]), found.branches) < 1e-12
    same_curve(found, fc.intersection_curve(saddle, cone, tolerance=TOLERANCE, method="algebraic"), 2.5 * TOLERANCE)
    places = in_doubles(saddle, cone).open_places  # where a ruling that lies on both crosses that one, and the rest
    for u, place in zip((0.0, -0.4), places, strict=True):
        assert place.u[0] <= u <= place.u[1] and place.v[0] <= 1 <= place.v[1] and place.u[1] - place.u[0] < 1e-4


def test_cusps_are_named_where_branches_pass_an_edge_of_regression():
    """The tangents of (u, u^2, u^3) against planes and a surface of high degree; in both orders."""
    tangents = fc.RuledSurface("(u, u**2, u**3)", "(u + 1, u**2 + 2*u, u**3 + 3*u**2)", u=(-2, 2), s=(-1, 1))
    plane = fc.RuledSurface("(-9, u, 1/8)", "(9, u, 1/8)", u=(-9, 9))
    bent = fc.RuledSurface("(-9, u, u**6/999)", "(9, u, u**6/999 + 1/8)", u=(-9, 9))
    ring = "5/4 + (1-u**2)/(1+u**2), 1/8 + 2*u/(1+u**2)"  # passes the edge at its ruling u = infinity
    pipe = fc.RuledSurface(f"(-9, {ring})", f"(9, {ring})", u=None)
    for pair in ((tangents, plane), (plane, tangents), (tangents, bent), (tangents, pipe), (pipe, tangents)):
        found, exact = certified(*pair), fc.intersection_curve(*pair, tolerance=TOLERANCE, method="algebraic")
        points, expected = (sorted(x.point.tolist() for x in c.singular_points) for c in (found, exact))
        assert len(points) == (4 if pipe in pair else 1) and not found.open_places
        assert {x.kind for x in found.singular_points} == {"cusp"}
        assert np.array(points) == pytest.approx(np.array(expected), abs=1e-12)
        kinds = [sorted(node.kind for node in c.graph.nodes) for c in (found, exact)]
        assert kinds[0] == kinds[1] and len(found.graph.edges) == len(exact.graph.edges)
        assert any((branch.points == points[0]).all(1).any() for branch in found.branches)


def test_cusps_along_the_ruling_at_infinity():
    """Tangents of y = x^2 cover the points below it twice: on the lines y = 1, v = infinity, and y = 3, v = 0."""
    tangents = fc.RuledSurface("(u, u**2, 0)", "(u + 1, u**2 + 2*u, 0)", u=(-3, 3), s=(-2, 2))
    ring = "2 + (1-u**2)/(1+u**2), 2*u/(1+u**2)"
    lying = fc.RuledSurface(f"(-9, {ring})", f"(9, {ring})", u=None)
    known = [[-(3**0.5), 3, 0], [-1, 1, 0], [1, 1, 0], [3**0.5, 3, 0]]
    for pair in ((tangents, lying), (lying, tangents)):
        found = certified(*pair)
        assert sorted(x.point.tolist() for x in found.singular_points) == pytest.approx(np.array(known), abs=1e-12)
        assert {x.kind for x in found.singular_points} == {"cusp"}


def test_branches_turn_back_where_rulings_stand_still():
    """Only u^2 occurs, at 0 or in the middle of a chart or at infinity; a strip that lies twice in a plane."""
    folded = fc.RuledSurface("(u**2, u**2 - 1, -1)", "(u**2, 1 - u**2, 1)", u=(-1, 1))
    x, y = "2*u**2/(1+u**4)", "(1-u**4)/(1+u**4)"
    closed = fc.RuledSurface(f"({x}, {y}, -1)", f"({x}, {y}, 1)", u=None)
    twice = fc.RuledSurface("(2*u/(1+u**2), -1, 0)", "(2*u/(1+u**2), 1, 0)", u=None)
    level = fc.RuledSurface("(-2, 3*u - 1, 1/5 - u/3)", "(2, 3*u - 1, 1/7 + u/5)")
    sloping = fc.RuledSurface("(-2, 3*u - 1, 3*u - 7/10)", "(2, 3*u - 1, 3*u - 3/2)")
    half = fc.RuledSurface(f"({y}, {x}, -2)", f"({y}, {x}, 2)", u=None)  # half a pipe, which is cut about a crossing
    over = fc.RuledSurface("(-2, 3*u**2 - 2, 1/5 - u**2/3)", "(2, 3*u**2 - 2, 1/7 + u**2/5)", u=(-2, 2))  # for v and -v
    cases = (folded, level, 1), (closed, level, 2), (closed, over, 2), (twice, sloping, 2), (half, pipe("1", "x"), 5)
    for surface, other, count in cases:
        for pair in ((surface, other), (other, surface)):
            found, exact = certified(*pair), fc.intersection_curve(*pair, tolerance=TOLERANCE, method="algebraic")
            points, known = (sorted(x.point.tolist() for x in c.singular_points) for c in (found, exact))
            assert len(points) == count and (surface is not half or found.stats.exact_evaluations)
            assert np.array(points) == pytest.approx(np.array(known), abs=1e-12)
            assert sorted(x.kind for x in found.graph.nodes) == sorted(x.kind for x in exact.graph.nodes)


def test_a_branch_that_is_passed_to_and_fro_keeps_few_points():
    """Only v^2 occurs, so the points beside v = 0 are one."""
    wedge = fc.RuledSurface("(u, u + 1, -1)", "(-1, 1, -2)", u=(-2, 2), s=(-1, 2))
    folded = fc.RuledSurface("(u**2 + 1, 2, -2*u**2)", "(2*u**2, -2*u**2, -2*u**2 - 1)", u=(-1, 2), s=(0, 2))
    (branch,) = certified(wedge, folded).branches
    assert len(branch.points) < 1000 and abs(branch.length - 2.64671) < 1e-4


def test_metamorphic():
    """Exchanged, scaled by powers of two, and turned by a matrix of such: the same curve."""
    p, q = STRIPS[8]
    found = certified(p, q)
    same_curve(found, certified(q, p), 2.5 * TOLERANCE)
    for scale in (2.0**-20, 2.0**20):
        matrix = np.diag([scale, scale, scale, 1.0])
        other = certified(p.transformed(matrix), q.transformed(matrix), TOLERANCE * scale)
        assert [b.points.tolist() for b in other.branches] == [(b.points * scale).tolist() for b in found.branches]
    turned = np.array([[0, -2, 0, 3], [2, 0, 0, -1], [0, 0, 2, 0.5], [0, 0, 0, 1]], float)
    other = certified(p.transformed(turned), q.transformed(turned), 2 * TOLERANCE)
    same_curve(found, other, 5 * TOLERANCE, lambda x: x @ turned[:3, :3].T + turned[:3, 3])


def test_other_ranges_and_names_of_bounds():
    saddle = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)", u=(0, 2), s=("3/4", 2))
    (branch,) = certified(saddle, fc.RuledSurface("(u, 0, 1/2)", "(u, 1, 1/2)")).branches
    assert {end.on for end in branch.ends} == {("t=1",), ("s=3/4",)}
    assert sorted(branch.parameters[[0, -1], 2].tolist()) == pytest.approx([0.75, 1.0], rel=1e-15)


def test_what_the_certified_path_does_not_take():
    trimmed = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)", trim=["u <= s"])
    bow = fc.RuledSurface("(u, 0, 0)", "(1-u, 0, u-1/2)", s=None)
    flat = fc.RuledSurface("(u, 0, 1/2)", "(u, 1, 1/2)")
    fold = fc.RuledSurface.from_nurbs(
        [[(i, j, (i * j) % 3) for j in range(4)] for i in range(3)], ([0, 0, 0, 1, 1, 1], [0, 0, 1, 2, 3, 3])
    )
    for p in (trimmed, fold):
        with pytest.raises(fc.UnsupportedPair, match="surfaces without trimming, in one row"):
            certified(p, flat)
    with pytest.raises(fc.UnsupportedPair, match='meet, or go to infinity; bound s, or shorten u, or try method="alg'):
        certified(bow, flat)
    with pytest.raises(fc.UnsupportedPair, match="a box cuts the curve on the exact path only"):
        fc.intersection_curve(*STRIPS[8], box=((0, 0, 0), (1, 1, 1)))
    with pytest.raises(fc.UnsupportedPair, match="has several pieces"):
        fc.intersection_curve(*STRIPS[8], method="algebraic")
