"""Intersection curves of ruled surfaces against known answers, closed forms, sampled rulings, and under changes."""

from __future__ import annotations

import json
import math
import pickle
from fractions import Fraction

import numpy as np
import pytest
from flint import fmpz_poly

import firstcontact as fc
import ruled_vectors
from firstcontact.exact.polynomials.bivariate import U, V, polynomial
from firstcontact.pairs import ruled_ruled
from firstcontact.pairs.ruled_ruled import FactorKind, Rulings
from ruled_vectors import value

TOLERANCE = 1e-6
VECTORS = ruled_vectors.vectors("static_full", "static_box")
_CURVES: dict[str, fc.IntersectionCurve] = {}


def curve_of(vector) -> fc.IntersectionCurve:
    """Computed once for all tests."""
    if vector.name not in _CURVES:
        _CURVES[vector.name] = fc.intersection_curve(vector.p, vector.q, tolerance=TOLERANCE)
    return _CURVES[vector.name]


def named(prefix: str):
    return next(v for v in VECTORS if v.name.startswith(prefix))


def with_field(*keys: str):
    chosen = [v for v in VECTORS if any(key in v.expected for key in keys)]
    return pytest.mark.parametrize("vector", chosen, ids=repr)


def number(text: str, **variables) -> float:
    return math.inf if text == "oo" else float(value(text, **variables).mid())


def triple(texts) -> np.ndarray:
    return np.array([number(x) for x in texts])


def distance(point: np.ndarray, curve: fc.IntersectionCurve) -> float:
    """From a point to the nearest branch or overlap line."""
    lines = [branch.points for branch in curve.branches]
    found = [_to_polyline(point, line) for line in lines]
    found += [_to_line(point, line, curve.a.s is None and curve.b.s is None) for line in curve.overlap_lines]
    return min(found, default=math.inf)


def _to_polyline(point: np.ndarray, line: np.ndarray) -> float:
    start, along = line[:-1], np.diff(line, axis=0)
    length = np.maximum((along * along).sum(1), 1e-300)
    t = np.clip(((point - start) * along).sum(1) / length, 0, 1)
    return float(np.linalg.norm(start + t[:, None] * along - point, axis=1).min())


def _to_line(point: np.ndarray, ends: np.ndarray, whole: bool) -> float:
    along = ends[1] - ends[0]
    t = (point - ends[0]) @ along / (along @ along)
    return float(np.linalg.norm(ends[0] + (t if whole else np.clip(t, 0, 1)) * along - point))


# -- the known answers --------------------------------------------------------------------------------------


@with_field("Delta")
def test_delta(vector):
    """Up to a constant and the sign; factors without real zeros may be missing in the known answer."""
    found = fc.intersection_curve(vector.p, vector.q).delta
    text = vector.expected["Delta"]
    if text == "0":
        assert found == {}
        return
    expected = eval(text, {"u": U, "v": V})  # noqa: S307 - our own data
    f = polynomial(found)
    assert f % expected == 0
    assert all(root.imag != 0 for factor in (f // expected).factor()[1] for root, _ in _roots(factor[0]))


def _roots(factor):
    degrees = factor.degrees()
    assert min(degrees) == 0  # what is left has one variable
    return ruled_ruled.bivariate.univariate(factor, "u" if degrees[0] else "v").complex_roots()


@with_field("S1")
def test_common_rulings(vector):
    found, expected = curve_of(vector), vector.expected["S1"]
    if isinstance(expected, str):
        assert polynomial(found.correspondence) in (U - V, V - U)
        assert found.two_dimensional
        return
    pairs = sorted((number(u), number(v)) for u, v in expected)
    assert len(found.common_rulings) == len(pairs)
    for (u, v), (x, y) in zip(sorted((float(u), float(v)) for u, v in found.common_rulings), pairs, strict=True):
        assert u == pytest.approx(x, rel=1e-15) and v == pytest.approx(y, rel=1e-15)


@pytest.mark.share(4)
@pytest.mark.parametrize("vector", VECTORS, ids=repr)
def test_kinds(vector):
    found, expected = curve_of(vector), vector.expected
    assert found.two_dimensional == expected.get("two_dimensional", False)
    assert found.empty == expected.get("empty", False)
    if "arcs" in expected:
        assert len(found.branches) == expected["arcs"] and not any(branch.closed for branch in found.branches)
    if "components" in expected:
        assert found.graph.components == expected["components"]
    if expected.get("only_points"):
        assert not found.branches and not len(found.overlap_lines)
    json.loads(found.to_json())
    assert str(pickle.loads(pickle.dumps(found))) == str(found)


@with_field("points", "touch_points")
def test_isolated_points(vector):
    points = vector.expected.get("points", []) + [p["xyz"] for p in vector.expected.get("touch_points", [])]
    _same_points(curve_of(vector).isolated_points, [triple(p) for p in points])


@with_field("singular_points", "cusps")
def test_singular_points(vector):
    for kind, points in (
        ("node", vector.expected.get("singular_points", [])),
        ("cusp", [cusp["xyz"] for cusp in vector.expected.get("cusps", [])]),
    ):
        found = [x.point for x in curve_of(vector).singular_points if x.kind == kind]
        _same_points(np.array(found), [triple(p) for p in points])


def _same_points(found: np.ndarray, expected: list[np.ndarray]) -> None:
    assert len(found) == len(expected)
    for point in expected:
        assert np.abs(found - point).max(1).min() < 1e-14


@with_field("curves", "interior_points", "lines")
def test_known_points_are_on_the_curve(vector):
    found = curve_of(vector)
    points = [triple(sample) for curve in vector.expected.get("curves", []) for sample in curve["samples"]]
    points += [triple(x["point"]) for x in vector.expected.get("interior_points", [])]
    points += [triple(x["point"]) for x in vector.expected.get("lines", [])]
    assert all(distance(point, found) <= 2 * TOLERANCE for point in points)


@with_field("arc_ends", "boundary_points")
def test_ends_of_arcs(vector):
    """Exact parameters where the answer is a closed form; the list of generic boundary points is complete."""
    ends = [end for branch in curve_of(vector).branches for end in branch.ends]
    expected = vector.expected.get("arc_ends", []) + [
        {**x["params"], "xyz": x["point"]} for x in vector.expected.get("boundary_points", [])
    ]
    assert len(ends) == len(expected)
    for known in expected:
        near = min(ends, key=lambda end: np.abs(end.point - triple(known["xyz"])).max())
        assert near.kind == "boundary" and near.on
        assert near.point == pytest.approx(triple(known["xyz"]), abs=1e-14)
        assert float(near.u) == pytest.approx(number(known["u"]), rel=1e-15)
        assert float(near.v) == pytest.approx(number(known["v"]), rel=1e-15)
        assert near.parameters[2:] == pytest.approx([number(known["s"]), number(known["t"])], abs=1e-14)


@with_field("overlap_segments")
def test_overlap_segments(vector):
    found = sorted(sorted(map(tuple, line.tolist())) for line in curve_of(vector).overlap_lines)
    expected = sorted(sorted(tuple(triple(p)) for p in line) for line in vector.expected["overlap_segments"])
    assert np.array(found).shape == np.array(expected).shape
    assert np.allclose(found, expected, atol=1e-14)


@with_field("overlap_lines")
def test_overlap_lines(vector):
    lines = curve_of(vector).overlap_lines
    assert len(lines) == len(vector.expected["overlap_lines"])
    for line in vector.expected["overlap_lines"]:
        for s in ("-1", "3"):
            point = np.array([number(x, s=value(s)) for x in line])
            assert min(_to_line(point, ends, whole=True) for ends in lines) < 1e-13


@with_field("curves", "arcs", "boundary_points")
def test_points_are_on_both_surfaces(vector):
    """P(u, s) = Q(v, t) = the point, relative to its size; at infinite parameters by continuity of the neighbours."""
    for branch in curve_of(vector).branches:
        u, v, s, t = branch.parameters.T
        known = np.isfinite(branch.parameters).all(1)
        size = np.maximum(1.0, np.abs(branch.points[known]).max(1))
        for surface, x, r in ((vector.p, u, s), (vector.q, v, t)):
            gap = np.abs(surface.points(x[known], r[known]) - branch.points[known]).max(1)
            leverage = 1 + np.abs(r[known])
            assert (gap <= 1e-12 * size * leverage).all()
        assert known.mean() > 0.9


def test_points_satisfy_the_implicit_equations():
    """Cones and cylinders of examples 1 and 5, and example 3's cone."""
    for name, equations in (
        ("s01", (lambda x, y, z: x**2 + y**2 - z**2, lambda x, y, z: x**2 + (y - (z - 1)) ** 2 - 1)),
        ("b01", (lambda x, y, z: y**2 + z**2 - 1, lambda x, y, z: (x + 1) ** 2 + y**2 - 1)),
        ("s03", (lambda x, y, z: y**2 + z**2 - ((x + 59) / 60) ** 2,)),
        ("s12", (lambda x, y, z: (y - 0.5) ** 2 + z**2 - 0.25, lambda x, y, z: x**2 + y**2 - 1)),
    ):
        for branch in curve_of(named(name)).branches:
            size = np.maximum(1.0, np.abs(branch.points).max(1)) ** 2
            for equation in equations:
                assert (np.abs(equation(*branch.points.T)) <= 1e-12 * size).all()


# -- the examples of the paper ------------------------------------------------------------------------------


def test_example_1_has_bidegree_2_2():
    found = curve_of(named("s01"))
    assert max(i for i, _ in found.delta) == max(j for _, j in found.delta) == 2
    assert found.common_rulings == ((Fraction(1), Fraction(1)),)


def test_example_2_is_two_lines():
    found = curve_of(named("s02"))
    (u, v), (x, y) = found.common_rulings
    assert u.polynomial == x.polynomial == (-3, 0, 1) and v.polynomial == y.polynomial == (-1, 0, 3)


def test_example_3_is_one_loop_near_the_origin_and_two_branches_far_out():
    """The far ones are seen at v = 600 in the parametrisation: x = -v^4 / 10 there."""
    found = curve_of(named("s03"))
    assert [branch.closed for branch in found.branches] == [False, False, True]
    assert found.graph.components == 3
    turning = sorted(float(node.u) for node in _graph(named("s03")).nodes if node.kind == "extreme")
    known = sorted(number(u) for u, _ in named("s03").expected["critical_points_fv"])
    assert turning == pytest.approx(known, rel=1e-14)


def _graph(vector):
    from firstcontact.exact.curves.plane_curves import topology

    p, q = rulings(vector.p), rulings(vector.q)
    return topology(ruled_ruled.delta(p, q))


def rulings(surface: fc.RuledSurface) -> Rulings:
    return Rulings.of(surface.first.components, surface.second.components)


# -- no branch is missed ------------------------------------------------------------------------------------


@pytest.mark.share(6)
@pytest.mark.parametrize("name", ["s01", "s03", "s10", "s11", "s12", "b01", "b02", "b09", "b10", "b11"])
def test_no_branch_is_missed(name):
    """Rulings of P at random u meet Q in points that are roots of one polynomial: each is on the curve."""
    vector, rng = named(name), np.random.default_rng(3)
    found, seen = curve_of(vector), 0
    lo, hi = (-8, 8) if vector.p.u is None else map(float, vector.p.u)
    for u in rng.uniform(lo, hi, 40):
        for point, v, s, t in _meetings(vector.p, vector.q, u):
            inside = (vector.p.s is None or 0 <= s <= 1) and (vector.q.s is None or 0 <= t <= 1)
            inside &= vector.q.u is None or float(vector.q.u[0]) <= v <= float(vector.q.u[1])
            if inside and np.abs(point).max() < 50:
                seen += 1
                assert distance(point, found) <= 2 * TOLERANCE
    assert seen >= 5


def _meetings(p: fc.RuledSurface, q: fc.RuledSurface, u: float):
    """Points, v, s, t where the ruling at u meets Q: the roots of det(P1, P2, Q1(v), Q2(v)) by Laplace's expansion."""
    p1, p2 = p.points(u, 0.0), p.points(u, 1.0)
    a, b = [*p1, 1.0], [*p2, 1.0]
    c, d = (
        [[float(x) for x in component.coeffs()[::-1]] or [0.0] for component in side.components]
        for side in (q.first, q.second)
    )
    f = np.zeros(1)
    for order, sign in (("0123", 1), ("0213", -1), ("0312", 1), ("1203", 1), ("1302", -1), ("2301", 1)):
        i, j, k, m = map(int, order)
        minor = np.polysub(np.polymul(c[k], d[m]), np.polymul(c[m], d[k]))
        f = np.polyadd(f, sign * (a[i] * b[j] - a[j] * b[i]) * minor)
    for v in np.roots(np.where(np.abs(f) < 1e-13 * np.abs(f).max(), 0.0, f)):
        if abs(v.imag) < 1e-9:
            q1, q2 = q.points(v.real, 0.0), q.points(v.real, 1.0)
            (s, t), *_ = np.linalg.lstsq(np.column_stack((p2 - p1, q1 - q2)), q1 - p1, rcond=None)
            point = p1 + s * (p2 - p1)
            if np.abs(point - q1 - t * (q2 - q1)).max() < 1e-6:  # else a degenerate ruling of Q
                yield point, v.real, s, t


# -- the same question asked differently --------------------------------------------------------------------

SAMPLED = [named(x) for x in ("s01", "s07", "s09", "s11", "s15", "b01", "b06", "b11")]


def same_curve(x: fc.IntersectionCurve, y: fc.IntersectionCurve, moved=lambda points: points) -> None:
    """y is the image of x: the same parts, and the points of either lie on the other."""
    assert len(x.branches) == len(y.branches) and x.graph.components == y.graph.components
    assert [len(getattr(x, k)) for k in ("overlap_lines", "isolated_points", "singular_points")] == [
        len(getattr(y, k)) for k in ("overlap_lines", "isolated_points", "singular_points")
    ]
    assert x.two_dimensional == y.two_dimensional
    near = 3.0  # unbounded branches are cut at different places
    for branch in x.branches:
        points = branch.points[np.abs(branch.points).max(1) < near][::37]
        assert all(distance(point, y) <= 10 * TOLERANCE for point in moved(points))
    for point in x.isolated_points:
        assert np.abs(y.isolated_points - moved(point[None])[0]).max(1).min() < 1e-12


@pytest.mark.parametrize("vector", SAMPLED, ids=repr)
def test_swapped(vector):
    swapped = fc.intersection_curve(vector.q, vector.p, tolerance=TOLERANCE)
    same_curve(curve_of(vector), swapped)
    pairs = {(str(v), str(u)) for u, v in swapped.common_rulings}
    assert pairs == {(str(u), str(v)) for u, v in curve_of(vector).common_rulings}


@pytest.mark.parametrize("vector", SAMPLED, ids=repr)
def test_moved_together(vector):
    """An affine map with rational entries, also a reflection."""
    rows = [["2/3", "-1/3", 0, 5], ["1/3", "2/3", 1, -2], [0, 1, -1, "1/7"], [0, 0, 0, 1]]
    matrix = [[Fraction(x) for x in row] for row in rows]
    p, q = (x.transformed(matrix) for x in (vector.p, vector.q))
    a = np.array(matrix, float)
    same_curve(curve_of(vector), fc.intersection_curve(p, q, tolerance=TOLERANCE), lambda x: x @ a[:3, :3].T + a[:3, 3])


@pytest.mark.parametrize("vector", [v for v in SAMPLED if v.p.u is None], ids=repr)
def test_other_parameter(vector):
    """u -> (2 u + 1) / (u - 3): other rulings are at infinity."""
    first, second = (fc.RationalCurve.of(_moebius(c.components)) for c in (vector.p.first, vector.p.second))
    p = fc.RuledSurface(first, second, u=None, s=None if vector.p.s is None else (0, 1))
    found = fc.intersection_curve(p, vector.q, tolerance=TOLERANCE)
    same_curve(curve_of(vector), found)
    pairs, known = (sorted(c.common_rulings, key=_second) for c in (found, curve_of(vector)))
    for (u, v), (x, y) in zip(pairs, known, strict=True):
        assert float(v) == float(y)
        assert (2 * float(u) + 1) / (float(u) - 3) == pytest.approx(float(x), rel=1e-12)


def _second(pair) -> float:
    return float(pair[1])


def _moebius(components) -> list[fmpz_poly]:
    degree = max(c.degree() for c in components)
    above, below = fmpz_poly([1, 2]), fmpz_poly([-3, 1])
    powers = [above**i * below ** (degree - i) for i in range(degree + 1)]
    return [sum((c[i] * x for i, x in enumerate(powers)), fmpz_poly([0])) for c in components]


def test_improper_parameter_covers_the_same_points():
    """u -> u^2 reaches the half y >= 0 of the cylinder, and turns back at its two borders."""
    half = fc.RuledSurface(*(f"((1-u**4)/(1+u**4), 2*u**2/(1+u**4), {z})" for z in (0, 1)), u=None, s=None)
    found = fc.intersection_curve(half, named("s04").q)
    assert {x.kind for x in found.singular_points} == {"cusp"} and len(found.singular_points) == 2
    points = found.branches[0].points
    assert np.abs(np.hypot(points[:, 0], points[:, 1]) - 1).max() < 1e-12 and points[:, 1].min() >= 0
    assert points[:, 0].max() == 1


# -- bounds -------------------------------------------------------------------------------------------------

SADDLE = ("(u, 0, 0)", "(u, 1, u)")
LEVEL = ("(u, 0, 1/2)", "(u, 1, 1/2)")


def test_a_common_apex_counts_in_the_box_and_on_both_cones():
    rims = [f"((1-u**2)/(1+u**2), 2*u/(1+u**2), {height})" for height in (1, 3)]
    p, q = (fc.RuledSurface("(0, 0, 0)", rim) for rim in rims)
    assert fc.intersection_curve(p, q).isolated_points.tolist() == [[0, 0, 0]]
    assert len(fc.intersection_curve(p, q, box=((1, 1, 1), (2, 2, 2))).isolated_points) == 0
    cut = fc.RuledSurface("(0, 0, 0)", rims[1], s=("1/4", 1))
    assert fc.intersection_curve(p, cut).empty and fc.intersection_curve(cut, p).empty


def test_a_box_cuts_exactly():
    """z = x y at z = 1/2: y = 1 / (2 x), which leaves the box |x|, |y| <= 4 at x, y = 4 and 1/8."""
    p, q = (fc.RuledSurface(*x, u=None, s=None) for x in (SADDLE, LEVEL))
    found = fc.intersection_curve(p, q, box=((-4, -4, -4), (4, 4, 4)))
    ends = sorted((end.on, tuple(end.point)) for branch in found.branches for end in branch.ends)
    assert ends == [
        (("x=-4",), (-4.0, -0.125, 0.5)), (("x=4",), (4.0, 0.125, 0.5)),
        (("y=-4",), (-0.125, -4.0, 0.5)), (("y=4",), (0.125, 4.0, 0.5)),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("trim", "ends"),
    [
        (["u + s <= 3/2"], [(0.5, 1.0), (1.0, 0.5)]),
        (["u <= 3/4"], [(0.5, 1.0), (0.75, 2 / 3)]),
        (["u*u + s*s <= 17/16"], [(math.sqrt((17 + math.sqrt(33)) / 32), math.sqrt((17 - math.sqrt(33)) / 32)),
                                  (math.sqrt((17 - math.sqrt(33)) / 32), math.sqrt((17 + math.sqrt(33)) / 32))]),
    ],
)  # fmt: skip
def test_trimmed(trim, ends):
    found = fc.intersection_curve(fc.RuledSurface(*SADDLE, trim=trim), fc.RuledSurface(*LEVEL))
    (branch,) = found.branches
    points = sorted(tuple(end.point[:2]) for end in branch.ends)
    assert np.array(points) == pytest.approx(np.array(sorted(ends)), rel=1e-15)


def test_trimming_may_leave_points():
    """y = 1 / (2 x) touches x + y <= sqrt 2 only for irrational bounds; x + y >= 3/2 keeps its two ends."""
    found = fc.intersection_curve(fc.RuledSurface(*SADDLE, trim=["u + s >= 3/2"]), fc.RuledSurface(*LEVEL))
    assert not found.branches
    assert sorted(map(tuple, found.isolated_points)) == [(0.5, 1.0, 0.5), (1.0, 0.5, 0.5)]


TRIMMED_PLANES = [
    # the first one is a disc about (1/2, 0), of radius 1/3; common is y = 0
    ("s <= 1/2", [(Fraction(1, 6), Fraction(1, 2))], []),
    ("(s - 1/4)*(s - 3/4) >= 0", [(Fraction(1, 6), Fraction(1, 4)), (Fraction(3, 4), Fraction(5, 6))], []),
    ("s >= 5/6", [], [Fraction(5, 6)]),
    ("s >= 6/7", [], []),
    ("s**2 <= 1/2", [(Fraction(1, 6), math.sqrt(0.5))], []),
]


@pytest.mark.parametrize(("trim", "segments", "points"), TRIMMED_PLANES)
def test_trimming_cuts_common_rulings(trim, segments, points):
    disc = fc.RuledSurface("(0, u, 0)", "(1, u, 0)", u=(-1, 1), trim=["(s - 1/2)**2 + u**2 <= 1/9"])
    bent = fc.RuledSurface("(0, u, u**2)", "(1, u, u**2)", u=(-1, 1), trim=[trim])
    found = fc.intersection_curve(disc, bent)
    assert found.overlap_lines.tolist() == [[[float(x), 0, 0] for x in ends] for ends in segments]
    assert found.isolated_points.tolist() == [[float(x), 0, 0] for x in points]


def tube(**bounds) -> fc.RuledSurface:
    ring = "(1-u**2)/(1+u**2), 2*u/(1+u**2)"
    return fc.RuledSurface(f"({ring}, 0)", f"({ring}, 1)", u=None, **bounds)


def test_trimming_cuts_common_areas():
    low, high = tube(trim=["s <= 1/4"]), tube(trim=["s >= 1/3"])
    assert fc.intersection_curve(low, tube()).two_dimensional
    assert fc.intersection_curve(low, high).empty
    # s <= u^2 leaves (0, 0) of the half disc; elsewhere it leaves an area
    assert fc.intersection_curve(tube(trim=["s <= u**2"]), tube(trim=["u**2 + s**2 <= 1/4"])).two_dimensional
    corner = fc.intersection_curve(tube(trim=["s <= -u**2"]), tube(trim=["u <= 1/2"]))
    assert corner.isolated_points.tolist() == [[1, 0, 0]] and not corner.two_dimensional
    assert fc.intersection_curve(tube(), tube(), box=((0, 0, "1/2"), (2, 2, 2))).two_dimensional
    assert fc.intersection_curve(tube(), tube(), box=((0, 0, 2), (2, 2, 3))).empty
    (border,) = fc.intersection_curve(low, tube(trim=["s >= 1/4"])).branches
    assert border.closed and abs(border.points[:, 2] - 0.25).max() < 1e-15


APEX_KEPT = [("s <= 1/4", 1), ("s >= 1/4", 0), ("s + u**2 <= 2", 1), ("u >= s + 1", 1)]


@pytest.mark.parametrize("swapped", [False, True])
def test_a_plane_trimmed_in_one_parameter_keeps_its_area(swapped):
    pair = [plane(("1 - u", "-u - 1"), ("u**2 - 2*u + 2", "-u**2 - 2*u - 2"), trim="u >= 0"),
            plane(("u - 1", "u + 1"), ("2*u - u**2 - 2", "u**2 + 2*u + 2"))]  # fmt: skip
    assert fc.intersection_curve(*(pair[::-1] if swapped else pair)).two_dimensional


def plane(first, second, **bounds) -> fc.RuledSurface:
    first, second = (f"({x}, {y}, 0)" for x, y in (first, second))
    return fc.RuledSurface(first, second, u=None, s=None, **bounds)


def test_a_box_beside_a_common_plane():
    """Where its rulings meet at infinity no bound of the box holds."""
    pair = plane(("u", "u**2"), ("u + 1", "u**2 + 2*u")), plane(("2*u", "1 - u"), ("u", "u**2 - 3"))
    assert fc.intersection_curve(*pair).two_dimensional
    assert fc.intersection_curve(*pair, box=((-1, -1, 1), (1, 1, 2))).empty


@pytest.mark.parametrize(("trim", "points"), APEX_KEPT)
def test_trimming_may_keep_a_common_apex(trim, points):
    ring = "(1-u**2)/(1+u**2), 2*u/(1+u**2)"
    cone = fc.RuledSurface("(0, 0, 0)", f"({ring}, 1)", u=None, trim=[trim])
    other = fc.RuledSurface("(0, 0, 0)", f"(2, {ring})", u=None)
    assert fc.intersection_curve(cone, other).isolated_points.tolist() == [[0, 0, 0]] * points


def test_other_ranges_of_s():
    found = fc.intersection_curve(fc.RuledSurface(*SADDLE, s=("3/4", 2), u=(0, 2)), fc.RuledSurface(*LEVEL))
    (branch,) = found.branches
    assert branch.parameters[[0, -1], 2].tolist() == [1.0, 0.75]
    assert {end.on for end in branch.ends} == {("t=1",), ("s=3/4",)}


@pytest.mark.parametrize(
    ("x", "y", "area", "points", "arcs"),
    [("0", "0", True, 0, 0), ("1", "0", True, 0, 0), ("1", "1/2", True, 0, 0),
     ("5", "5", False, 0, 0), ("0", "1", False, 1, 0), ("4/3", "0", False, 1, 0)],
)  # fmt: skip
def test_coplanar_pieces(x, y, area, points, arcs):
    """The unit square and a parallelogram: they overlap, touch in a corner, or are apart."""
    other = fc.RuledSurface(f"(u+{x}, u+{y}, 0)", f"(u+{x}-1/3, 1+{y}+u, 0)")
    found = fc.intersection_curve(fc.RuledSurface("(u, 0, 0)", "(u, 1, 0)"), other)
    assert found.two_dimensional is area
    assert (len(found.isolated_points), len(found.branches)) == (points, arcs)


def test_coplanar_pieces_that_share_an_edge():
    other = fc.RuledSurface("(1, u+1/3, 0)", "(2, u/2, 0)")
    found = fc.intersection_curve(fc.RuledSurface("(u, 0, 0)", "(u, 1, 0)"), other)
    assert not found.two_dimensional
    (branch,) = found.branches
    assert sorted(end.point.tolist() for end in branch.ends) == [[1.0, pytest.approx(1 / 3), 0.0], [1.0, 1.0, 0.0]]


def test_pieces_of_one_cylinder():
    def piece(s):
        return fc.RuledSurface(*(f"((1-u**2)/(1+u**2), 2*u/(1+u**2), {z})" for z in (0, 1)), u=None, s=s)

    assert fc.intersection_curve(piece((0, 1)), piece(("1/2", 3))).two_dimensional
    assert fc.intersection_curve(piece((0, 1)), piece((2, 3))).empty
    assert fc.intersection_curve(piece(None), piece((2, 3))).two_dimensional
    (circle,) = fc.intersection_curve(piece((0, 1)), piece((1, 3))).branches
    assert circle.closed
    assert np.abs(np.hypot(*circle.points[:, :2].T) - 1).max() < 1e-15 and (circle.points[:, 2] == 1).all()
    assert (circle.parameters[:, 2:] == [1, 1]).all() and len(circle.points) > 1000


def test_pieces_of_one_saddle_share_an_edge_or_a_corner():
    piece = fc.RuledSurface(*SADDLE)
    (edge,) = fc.intersection_curve(piece, fc.RuledSurface(*SADDLE, s=(1, 2), u=("1/3", 2))).branches
    third = pytest.approx(1 / 3)
    assert sorted(end.point.tolist() for end in edge.ends) == [[third, 1, third], [1, 1, 1]]
    found = fc.intersection_curve(piece, fc.RuledSurface(*SADDLE, s=(1, 2), u=(1, 2)))
    assert not found.branches and found.isolated_points.tolist() == [[1, 1, 1]]
    found = fc.intersection_curve(piece, fc.RuledSurface(*SADDLE, u=(1, 2)))
    assert found.overlap_lines.tolist() == [[[1, 0, 0], [1, 1, 1]]] and not found.two_dimensional


def test_tangents_of_plane_curves_in_two_planes():
    """No point of either edge of regression is on the other surface: equations for cusps vanish altogether."""
    p = fc.RuledSurface("(-u, u - 1, u + 1)", "(-2*u, -u**2 + 2*u - 2, u**2 + 2*u + 2)", u=(0, 2), s=(-1, 1))
    second = "(u + 1, (-u**2 - 6*u - 13)/4, (u**2 - 2*u + 5)/4)"
    q = fc.RuledSurface("((u + 1)/2, (-u - 3)/2, (1 - u)/2)", second, u=(0, 2))
    assert fc.intersection_curve(p, q).empty and fc.intersection_curve(q, p).empty


@pytest.mark.parametrize(("z", "s", "points"), [(0, (0, 1), 1), (0, ("1/2", 1), 0), (0, (-1, 0), 1), (0, None, 1)])
def test_an_apex_touches_a_strip(z, s, points):
    """z^2 = x^2 + y^2 and a strip of the plane z = 0; only the tip is common."""
    cone = fc.RuledSurface("(0, 0, 0)", "((1-u**2)/(1+u**2), 2*u/(1+u**2), 1)", u=None, s=s)
    strip = fc.RuledSurface("(u - 1/3, -1, 0)", "(u - 1/3, 1, 0)")
    for found in (fc.intersection_curve(cone, strip), fc.intersection_curve(strip, cone)):
        assert not found.branches and len(found.isolated_points) == points
        assert (found.isolated_points == 0).all()


@pytest.mark.parametrize("method", ["algebraic", "certified"])
@pytest.mark.parametrize(
    ("sides", "u"),
    [
        (("(u, -1, 0)", "(u, 1, 0)"), (0, 1)),
        (("(u, -u, 0)", "(u, u, 0)"), (0, 1)),
        (("(u**2, u, 0)", "(u**2 + 1, u, 0)"), (-1, 1)),
        (("((u**2 - 1/2)**2, u**2 - 1/2, 0)", "((u**2 - 1/2)**2 + 1, u**2 - 1/2, 0)"), (-1, 1)),
        (("(u, 1, 0)", "(u, 2, 0)"), (0, 1)),
    ],
    ids=["its end ruling", "a ruling that is a point", "its directrix", "its directrix at irrational u", "beside it"],
)
def test_an_apex_touches_a_piece_of_its_plane(sides, u, method):
    """A triangle to the left of its corner, and a piece of the plane to the right: no curve, for all that is in u, v.

    Along the ruling through the corner every pair (u, v) meets in the corner.
    """
    triangle = fc.RuledSurface("(-1, u, 0)", "(0, 0, 0)", u=(-1, 1))
    piece = fc.RuledSurface(*sides, u=u)
    for pair in ((triangle, piece), (piece, triangle)):
        found = fc.intersection_curve(*pair, method=method)
        assert not found.branches and not found.two_dimensional and not found.open_places
        assert found.isolated_points.tolist() == ([] if sides[0] == "(u, 1, 0)" else [[0, 0, 0]])


@pytest.mark.parametrize(
    ("trim", "points", "method"),
    [([], 1, "algebraic"), ([], 1, "certified"), (["s <= 1"], 1, "algebraic"), (["s <= 2/3"], 0, "algebraic")],
)
def test_triangles_of_one_plane_touch_in_their_corners(trim, points, method):
    """To the left and to the right of a common apex: rulings that are one line meet there alone."""
    left = fc.RuledSurface("(-1/2, u + 1, 2)", "(1/2, 1, 2)", u=(-1, 1), trim=trim)
    right = fc.RuledSurface("(1/2, 1, 2)", "(3/2, u**2 + u/2 + 1, 2)", u=(-1, 1), s=(0, 2))
    for pair in ((left, right), (right, left)):
        found = fc.intersection_curve(*pair, method=method)
        assert not found.branches and not found.two_dimensional and not found.open_places
        assert found.isolated_points.tolist() == [[0.5, 1, 2]] * points


def test_a_strip_through_the_apex_keeps_the_curve_that_ends_there():
    """The plane x = z / 2 through the tip meets the cone in two lines, of the strip's y in [0, 1] one half."""
    cone = fc.RuledSurface("(0, 0, 0)", "((1-u**2)/(1+u**2), 2*u/(1+u**2), 1)", u=None, s=None)
    strip = fc.RuledSurface("(u/2 - 1/2, 0, u - 1)", "(u/2 - 1/2, 1, u - 1)", u=(0, 2))
    found = fc.intersection_curve(cone, strip)
    assert len(found.branches) == 2 and not len(found.isolated_points)
    for branch in found.branches:
        assert (branch.points == 0).all(1).any()
        x, y, z = branch.points.T
        assert np.abs(x - z / 2).max() < 1e-15 and np.abs(y - math.sqrt(0.75) * np.abs(z)).max() < 1e-12


# -- the pair of families -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "plane", "apex"),
    [("s02", False, True), ("s05", False, False), ("s09", False, True), ("b08", True, False)],
)
def test_what_families_share_whose_rulings_all_meet(name, plane, apex):
    """A plane, a point, or neither: then they are the two reguli of one quadric."""
    vector = named(name)
    p, q = rulings(vector.p), rulings(vector.q)
    assert (p.plane is not None and p.plane == q.plane) is plane
    assert plane or (p.apex is not None and p.apex == q.apex) is apex


@with_field("infinite_factors")
def test_infinite_factors(vector):
    p, q = rulings(vector.p), rulings(vector.q)
    d = ruled_ruled.delta(p, q)
    correspondence = ruled_ruled.common_rulings(p, q).correspondence
    curves, special = ruled_ruled.factors(p, q, d, ruled_ruled.meeting(p, q), correspondence)
    found = {str(f.polynomial) for f in curves if f.kind is FactorKind.INFINITE}
    found |= {"uv"[s.side] for s in special if s.kind is FactorKind.INFINITE and s.parameter is not None}
    assert found == {x.replace("u*v+1", "u*v + 1") for x in vector.expected["infinite_factors"]}


# -- degenerate pairs ---------------------------------------------------------------------------------------


def test_equal_surfaces_with_a_ruling_at_infinity():
    """Where one parameter is moved, the ruling at infinity of one is at a finite parameter of the search."""
    saddle = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)", u=None, s=None)
    moved = fc.RuledSurface("(u + 1, 0, 0)", "(u + 1, 1, u + 1)", u=None, s=None)
    for other, expected in ((saddle, U - V), (moved, U - V - 1)):
        found = fc.intersection_curve(saddle, other)
        assert found.two_dimensional and polynomial(found.correspondence) in (expected, -expected)


def test_equal_cones_whose_minors_cancel():
    """A sum of the minors that is zero tells nothing."""
    ring = "((2 - 2*u)/(1 + u**2), (1 + 2*u - u**2)/(1 + u**2), (u**2 - 2*u - 1)/(1 + u**2))"
    double = "((u**2 - 4*u + 5)/(1 + u**2), (2 + 4*u - 2*u**2)/(1 + u**2), (2*u**2 - 4*u - 2)/(1 + u**2))"
    cone, other = (fc.RuledSurface("(-1, 0, 0)", x, u=(0, 2), s=None) for x in (ring, double))
    assert fc.intersection_curve(cone, other).two_dimensional


def test_equal_families_of_tangents_in_a_plane():
    """Rulings u = v are one line: no border of the area of crossings."""
    x, y = "(-u - 1, u - 1, -u)", "(-u**2 - 2*u - 2, 2*u - 1, -2*u)"
    p, q = (fc.RuledSurface(x, y, u=u, s=s) for u, s in (((-2, 2), (-1, 2)), ((-1, 2), (0, 1))))
    assert fc.intersection_curve(p, q).two_dimensional


def tangents(curve: str, derivative: str) -> fc.RuledSurface:
    parts = zip(curve.strip("()").split(","), derivative.strip("()").split(","), strict=True)
    return fc.RuledSurface(curve, "(" + ", ".join(f"{x} + {y}" for x, y in parts) + ")", u=None, s=None)


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize(
    ("edge", "plane", "cusps"),
    [
        # a curve and its tangents, cut by the plane x = z at u = -1, 0, 1; 0 is where parameters may be moved to
        (("(u, u**2, u**3)", "(1, 2*u, 3*u**2)"), ("(0, u, 0)", "(1, u, 1)"), [(-1, 1, -1), (0, 0, 0), (1, 1, 1)]),
        # tangents of a parabola in the plane x = y + z, cut by y = 1, which holds (1, 3, -2, 5) too
        (("(u**2 + 3*u, 3*u, u**2)", "(2*u + 3, 3, 2*u)"), ("(u, 1, 0)", "(u, 1, 1)"), [("10/9", 1, "1/9")]),
    ],
)
def test_cusps_on_edges_of_regression(edge, plane, cusps, swapped):
    pair = tangents(*edge), fc.RuledSurface(*plane, u=None, s=None)
    found = fc.intersection_curve(*(pair[::-1] if swapped else pair), tolerance=1e-2)
    points = [x.point for x in found.singular_points if x.kind == "cusp"]
    _same_points(np.array(points), [triple(map(str, x)) for x in cusps])


def test_a_point_that_several_nodes_share_is_listed_once():
    """Every ruling of the second surface has two parameters."""
    eight = named("s12")
    twice = fc.RuledSurface(*(_squared(x) for x in (eight.q.first, eight.q.second)), u=None, s=None)
    found = fc.intersection_curve(eight.p, twice, tolerance=1e-2)
    points = [tuple(x.point) for x in found.singular_points]
    assert points and len(set(points)) == len(points)


def _squared(curve: fc.RationalCurve) -> fc.RationalCurve:
    return fc.RationalCurve.of([x(fmpz_poly([0, 0, 1])) for x in curve.components])


def test_a_branch_that_winds_between_two_nodes_is_followed():
    """The middle circle of a Moebius strip, twice: v runs to and fro over one edge of the graph."""
    c, s = "((1-u**2)/(1+u**2))", "(2*u/(1+u**2))"
    sides = (f"((2 {sign} {c}/2)*({c}**2 - {s}**2), (2 {sign} {c}/2)*2*{c}*{s}, {sign}{s}/2)" for sign in "-+")
    strip, level = fc.RuledSurface(*sides, u=None), fc.RuledSurface("(-4, u, 0)", "(4, u, 0)", u=(-4, 4))
    for tolerance in (1e-1, 1e-3):
        (branch,) = fc.intersection_curve(strip, level, tolerance=tolerance).branches
        assert branch.closed and np.abs(np.linalg.norm(branch.points, axis=1) - 2).max() < 1e-10
        middles = 0.5 * (branch.points[1:] + branch.points[:-1])
        assert np.linalg.norm(middles, axis=1).min() >= 2 - 1.01 * tolerance
        assert abs(branch.length - 8 * np.pi) < 8 * np.pi * tolerance


def test_chords_that_bend_unevenly_keep_the_tolerance():
    p = fc.RuledSurface(
        "((2*u**2 - 2*u - 2)/(u + 2), (-2*u**2 - 2*u + 2)/(u + 2), (u**2 + u + 1)/(u + 2))",
        "((2*u**2 + 2*u)/(u + 3), (u + 2)/(u + 3), (-2*u + 1)/(u + 3))", u=("-1/2", "3/2"), s=None,
    )  # fmt: skip
    ring = "((3*u**2 + 4*u - 1)/(u**2 + 1), (-u**2 + 4*u + 3)/(u**2 + 1), (u**2 + 4*u + 1)/(u**2 + 1))"
    q = fc.RuledSurface("(1, 0, 1)", ring, u=("-1/2", "3/2"), s=None)
    coarse, fine = (fc.intersection_curve(p, q, tolerance=x) for x in (1e-4, 1e-6))
    for x, y in zip(coarse.branches, fine.branches, strict=True):
        near = y.points[np.abs(y.points).max(1) < 3]
        assert max(_to_polyline(point, x.points) for point in near[::2]) <= 1.01e-4


def test_bounded_pieces_keep_the_tolerance_far_out():
    """They have no end at infinity on the way to which it may grow."""
    bowl = fc.RuledSurface("(u, u**2/1000, 0)", "(u, u**2/1000, 1)", u=(0, 2000))
    level = fc.RuledSurface("(0, u, 1/2)", "(2000, u, 1/2)", u=(0, 4000))
    (branch,) = fc.intersection_curve(bowl, level, tolerance=1e-2).branches
    x = 0.5 * (branch.points[:-1, 0] + branch.points[1:, 0])
    y = 0.5 * (branch.points[:-1, 1] + branch.points[1:, 1])
    assert np.abs(x**2 / 1000 - y).max() / np.sqrt(1 + (x.max() / 500) ** 2) <= 1e-2


# -- bad input ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "error", "text"),
    [
        ({"tolerance": 0.0}, fc.InputError, "tolerance"),
        ({"method": "guess"}, fc.UnsupportedPair, "guess"),
        ({"box": (1, 2)}, fc.InputError, "two corners"),
        ({"box": ((0, 0, 0), (1, 1, -1))}, fc.InputError, "below"),
        ({"tolerance": 1e-30}, fc.InputError, "larger"),
        ({"tolerance": "fine"}, fc.InputError, "positive length"),
    ],
)
def test_bad_arguments(arguments, error, text):
    with pytest.raises(error, match=text):
        fc.intersection_curve(fc.RuledSurface(*SADDLE), fc.RuledSurface(*LEVEL), **arguments)


def test_other_bodies():
    with pytest.raises(fc.UnsupportedPair, match="is for Polyhedron with RuledSurface, .*not for .*; the bound"):
        fc.intersection_curve(fc.sphere(2), fc.sphere(1))
    with pytest.raises(fc.InputError, match=r"at\(t\)"):
        fc.intersection_curve(fc.RuledSurface("(u, 0, T)", "(u, 1, u)"), fc.RuledSurface(*LEVEL))
