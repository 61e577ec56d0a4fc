"""Intersection curves of strips with solids, and of ruled surfaces with polyhedra that are not convex."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from amount import amount
from firstcontact.body.ruled.strip import RuledStrip
from firstcontact.errors import UnsupportedPair

CIRCLE = "(1-u**2)/(1+u**2), 2*u/(1+u**2)"
SADDLE = fc.RuledSurface("(2*u-1, -1, 1-2*u)", "(2*u-1, 1, 2*u-1)", name="saddle")
PIPE = fc.RuledSurface(f"({CIRCLE}, -1)", f"({CIRCLE}, 1)", u=None, name="pipe")
CONE = fc.RuledSurface("(0, 0, 1)", f"({CIRCLE}, 0)", u=(-1, 1), name="cone")
SIDES = [[i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6] for i in range(6)]
CORNERS = [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))]
ELL = fc.Polyhedron(CORNERS, [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *SIDES], name="ell")
HALF = Fraction(1, 2)
MODEL = fc.box((2, 2, 1)).translated((1, 1, HALF)) - fc.box((2, 2, 3)).translated((2, 2, HALF))
WAVE = fc.RuledSurface.from_nurbs(
    [[(k, 0, (-1) ** k), (k, 6, 2 * (-1) ** k)] for k in range(7)], knots=[0, 0, 0, 0, 1, 2, 3, 4, 4, 4, 4], name="wave"
)


def split(surface, *knots):
    """The same surface as a strip."""
    ends = [surface.u[0], *knots, surface.u[1]]
    pieces = []
    for k, u in enumerate(zip(ends, ends[1:], strict=False)):
        joined = {name for name, there in (("u0", k > 0), ("u1", k < len(knots))) if there}
        piece = fc.RuledSurface(surface.first, surface.second, u=u, s=surface.s)
        pieces.append(piece._with(joined=frozenset(joined)))
    return RuledStrip(pieces, name="split")


def shape(curve):
    """What does not depend on how the curve was put together."""
    def points(rows):
        return sorted(tuple(np.round(x, 7) + 0.0) for x in rows)

    return (
        sorted((b.closed, b.multiplicity, *points(e.point for e in b.ends)) for b in curve.branches),
        sorted(sorted(e.on) for b in curve.branches for e in b.ends),
        points(x.point for x in curve.singular_points), points(curve.isolated_points), curve.open_places,
        len(curve.graph.edges), pytest.approx(sum(b.length for b in curve.branches), abs=2e-3),
    )  # fmt: skip


def random_surface(rng):
    """On a grid as coarse as that of the corners, so that it meets edges and corners."""
    degree, grid = int(rng.integers(1, 3)), int(rng.integers(1, 4))
    rows = rng.integers(-grid, 3 * grid, size=(2, 3, degree + 1))
    weights = (1, 1) if degree == 1 else (1, 2, 1)

    def side(table):
        terms = [[f"({x}*{w})*u**{i}*(1-u)**{degree - i}" for i, (x, w) in enumerate(zip(row, weights, strict=True))]
                 for row in table]  # fmt: skip
        return "(" + ", ".join(f"({'+'.join(x)})/{grid}" for x in terms) + ")"

    try:
        return fc.RuledSurface(side(rows[0]), side(rows[1]))
    except fc.InputError:  # all rulings on one line
        return random_surface(rng)


def distance_from_boundary(points):
    """From that of the ell, of (n, 3) points."""
    corners = ELL.vertices[ELL.triangles]
    a, ab, ac = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normals = np.cross(ab, ac)
    away = points[:, None] - a
    off = np.abs(np.einsum("ntk,tk->nt", away, normals)) / np.linalg.norm(normals, axis=1)
    y = np.einsum("ntk,tk->nt", np.cross(away, ac), normals) / (normals**2).sum(1)
    z = np.einsum("ntk,tk->nt", np.cross(ab, away), normals) / (normals**2).sum(1)
    return np.maximum(off, -np.minimum(np.minimum(y, z), 1 - y - z)).min(1)


def distance(point, curve):
    """From the chords."""
    least = np.inf
    for branch in curve.branches:
        a, d = branch.points[:-1], np.diff(branch.points, axis=0)
        t = np.clip(((point - a) * d).sum(1) / np.maximum((d * d).sum(1), 1e-300), 0, 1)
        least = min(least, np.linalg.norm(a + t[:, None] * d - point, axis=1).min())
    return least


def check_crossings(surface, solid, curve, us, tolerance):
    """Where rulings pass between inside and outside, found by halving, is on the curve; returns how many."""
    count = 0
    for u in us:
        s = np.linspace(0, 1, 40)
        inside = solid.contains(surface.points(u, s))
        for k in np.flatnonzero(inside[1:] != inside[:-1]):
            low, high = s[k], s[k + 1]
            for _ in range(24):
                middle = (low + high) / 2
                if solid.contains(surface.points(u, [middle]))[0] == inside[k]:
                    low = middle
                else:
                    high = middle
            assert distance(surface.points(u, low), curve) <= tolerance + 1e-7
            count += 1
    return count


@pytest.mark.share(4)
@pytest.mark.parametrize("seed", range(amount(18)))
def test_a_polyhedron_with_a_notch(seed):
    """As the model of the same solid, and as the surface cut in pieces; on both, and nothing missed."""
    surface = random_surface(np.random.default_rng(seed))
    try:
        curve = fc.intersection_curve(surface, ELL, tolerance=1e-4)
    except UnsupportedPair as error:
        assert "lies in the plane of face" in str(error)
        return
    assert shape(fc.intersection_curve(ELL, surface, tolerance=1e-4))[2:] == shape(curve)[2:]
    for other in (MODEL, ELL):
        strip = split(surface, Fraction(1, 3), HALF)
        assert shape(fc.intersection_curve(strip, other, tolerance=1e-4)) == shape(curve)
    for branch in curve.branches:
        assert distance_from_boundary(branch.points).max() < 1e-12
        assert np.abs(surface.points(*branch.parameters[:, [0, 2]].T) - branch.points).max() < 1e-12
    check_crossings(surface, MODEL, curve, np.linspace(0.013, 0.991, 8), 1e-4)


def test_strips_and_curved_solids():
    plate = (fc.box((4, 4, 1)) - fc.cylinder(1, 3)).translated((3, 3, 0))
    for solid, count, closed in ((fc.sphere(2).translated((3, 3, 0)), 1, True), (plate, 1, True),
                                 (fc.half_space((0, 0, 1), "1/10"), 6, False)):  # fmt: skip
        curve = fc.intersection_curve(WAVE, solid, tolerance=1e-4)
        assert [b.closed for b in curve.branches] == [closed] * count
        assert not (curve.open_places or len(curve.singular_points) or len(curve.isolated_points))
        crossings = 0
        for piece in WAVE.pieces:
            crossings += check_crossings(piece, solid, curve, np.linspace(*map(float, piece.u), 4)[1:-1], 1e-4)
        assert crossings > 8 or not closed
    assert {e.on for b in curve.branches for e in b.ends} == {("s=0",), ("s=1",)}
    swapped = fc.intersection_curve(solid, WAVE, tolerance=1e-4)
    assert {e.on for b in swapped.branches for e in b.ends} == {("t=0",), ("t=1",)}
    for mine, other in zip(curve.branches, swapped.branches, strict=True):
        assert np.array_equal(mine.parameters[:, [0, 2]], other.parameters[:, [1, 3]])


def test_curves_on_knots_are_told_once_and_cut_where_others_leave():
    """z = (1-x) (y-1/3) and then (x-1) (y-2/3): the plane z = 0 holds the knot, and an arc on each side of it."""
    left = fc.RuledSurface("(u, 0, (u-1)/3)", "(u, 1, 2*(1-u)/3)")._with(joined=frozenset({"u1"}))
    right = fc.RuledSurface("(u, 0, 2*(1-u)/3)", "(u, 1, (u-1)/3)", u=(1, 2))._with(joined=frozenset({"u0"}))
    strip, bar = RuledStrip([left, right]), ELL.translated((0, HALF, -1))
    curve = fc.intersection_curve(strip, fc.half_space((0, 0, 1), 0))
    assert sorted(round(b.length, 9) for b in curve.branches) == [0.333333333] * 3 + [1, 1]
    assert sorted(np.round(x.point, 9).tolist() for x in curve.singular_points) == [
        [1, 0.333333333, 0], [1, 0.666666667, 0]]  # fmt: skip
    assert curve.graph.components == 1 and not curve.open_places
    trimmed = fc.intersection_curve(strip, bar)  # from y = 1/2 on
    assert [np.round(x.point, 9).tolist() for x in trimmed.singular_points] == [[1, 0.666666667, 0]]
    assert fc.intersection_curve(RuledStrip([left]), fc.half_space((0, 0, 1), 0)).graph.components == 1


def test_a_piece_of_a_strip_in_the_surface():
    flat = fc.RuledSurface("(u, 0, 0)", "(u, 1, 0)")._with(joined=frozenset({"u1"}))
    rest = fc.RuledSurface("(u, 0, (u-1)*(3-2*u))", "(u, 1, (u-1)*(3-2*u))", u=(1, 2))._with(joined=frozenset({"u0"}))
    curve = fc.intersection_curve(RuledStrip([flat, rest]), fc.half_space((0, 0, 1), 0))
    assert curve.two_dimensional and not curve.open_places
    (branch,) = curve.branches
    assert np.allclose(branch.points[:, 0], 1.5, atol=1e-14) and np.isclose(branch.length, 1)


def test_apexes_and_all_rulings():
    for place in ((0, Fraction(-1, 3), Fraction(1, 3)), (-1, -1, 0)):
        solid, model = ELL.translated(place), MODEL.translated(place)
        pipes = [fc.intersection_curve(PIPE, x, tolerance=1e-4) for x in (solid, model)]
        assert shape(pipes[0]) == shape(pipes[1]) and pipes[0].branches
        cones = [fc.intersection_curve(x, y, tolerance=1e-4) for x in (CONE, split(CONE, 0)) for y in (solid, model)]
        assert all(shape(x) == shape(cones[0]) for x in cones) and cones[0].branches


def test_open_meshes_and_many_facets():
    sheet = fc.Polyhedron([[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    (arc,) = fc.intersection_curve(PIPE.translated((HALF, 0, 0)), sheet).branches
    assert sorted(end.on for end in arc.ends) == [("edge 2",), ("edge 3",)]
    ball = fc.sphere(1).to_mesh(0.02).translated(("1/10", 0, 0))  # a corner within rounding of the curve
    (arc,) = fc.intersection_curve(SADDLE, ball, tolerance=1e-3).branches
    assert not arc.closed and {end.on for end in arc.ends} == {("u=1",)}


@pytest.mark.parametrize(
    ("surface", "solid", "message"),
    [
        (SADDLE, fc.Polyhedron(CORNERS, [], edges=[[0, 1]], name="wire"), "wire has no faces"),
        (SADDLE, ELL.moving(fc.Translation((1, 0, 0))), "ell.*give a body at rest"),
        (fc.RuledSurface.from_nurbs([[(x, y, x * y) for y in range(3)] for x in range(3)], name="rows",
                                    knots=([0, 0, 1, 2, 2], [0, 0, 1, 2, 2])), ELL, "rows.*side by side"),
        (fc.RuledSurface("(u, 0, 1)", "(u, 1, 1)"), ELL, "ell: the ruled piece lies in the plane of face 1"),
        (fc.RuledSurface("(u, 0, 0)", "(1-u, 0, u-1/2)", s=None, name="bow"), ELL, "bow.*whose directrices"),
    ],  # fmt: skip
)
def test_refusals(surface, solid, message):
    with pytest.raises(UnsupportedPair, match=message):
        fc.intersection_curve(surface, solid)


def test_a_ruling_that_is_a_point_is_no_branch():
    """Where a ruling is one point of an edge, the branch along the floor ends there once; on models too."""
    fan = fc.RuledSurface("(u/2, 3/2, 0)", "(u, (3 - 5*u)/2, 3*u/2)")
    corners = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))]
    sides = [[i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6] for i in range(6)]
    mesh = fc.Polyhedron(corners, [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *sides])
    model = fc.box((2, 2, 1)).translated((1, 1, "1/2")) - fc.box((2, 2, 3)).translated((2, 2, "1/2"))
    for solid in (mesh, model):
        curve = fc.intersection_curve(fan, solid)
        assert sorted(round(branch.length, 12) for branch in curve.branches) == [0.2, 0.5]
        assert not curve.singular_points and not len(curve.isolated_points)
