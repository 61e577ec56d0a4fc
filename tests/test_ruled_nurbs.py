"""Ruled B-splines and NURBS as pieces, and meshes of ruled surfaces."""

from __future__ import annotations

import pickle
from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.body.ruled.strip import RuledStrip
from firstcontact.body.ruled.surface import RuledSurface

CIRCLE = "((1-u**2)/(1+u**2), 2*u/(1+u**2), {})"


def spline(knots, controls, n, u):
    """The B-spline at u by the definition of its basis functions (Cox and de Boor), in Fractions."""

    def basis(i, d):
        if d == 0:
            last = u == knots[-1] and knots[i] < knots[i + 1] == u
            return F(int(knots[i] <= u < knots[i + 1] or last))
        total = F(0)
        if knots[i + d] > knots[i]:
            total += (u - knots[i]) / (knots[i + d] - knots[i]) * basis(i, d - 1)
        if knots[i + d + 1] > knots[i + 1]:
            total += (knots[i + d + 1] - u) / (knots[i + d + 1] - knots[i + 1]) * basis(i + 1, d - 1)
        return total

    values = [basis(i, n) for i in range(len(controls))]
    return [sum(b * c[k] for b, c in zip(values, controls, strict=True)) for k in range(len(controls[0]))]


def exact_point(curve, u):
    from flint import fmpq

    x = fmpq(u.numerator, u.denominator)
    values = [p(x) for p in curve.components]
    return [F(int((v / values[3]).p), int((v / values[3]).q)) for v in values[:3]]


KNOTS = {
    "clamped": (3, [0, 0, 0, 0, 1, 2, 2, 5, 5, 5, 5]),
    "open": (2, [-3, -1, 0, "1/3", 1, 2, 4, 7]),
    "polygon": (1, [0, 0, 1, 2, 3, 3]),
    "bezier": (4, [0] * 5 + [1] * 5),
}


@pytest.mark.parametrize("weighted", [False, True], ids=["plain", "weighted"])
@pytest.mark.parametrize("across", [False, True], ids=["(n, 1)", "(1, n)"])
@pytest.mark.parametrize("name", KNOTS)
def test_pieces_are_the_spline(name, across, weighted):
    n, knots = KNOTS[name]
    knots = [F(k) for k in knots]
    count = len(knots) - n - 1
    rng = np.random.default_rng(7)
    grid = rng.integers(-9, 10, (count, 2, 3)) + np.array([[[0, 0, 0], [0, 40, 0]]])
    weights = rng.integers(1, 5, (count, 2)) if weighted else np.ones((count, 2), int)
    points, loads = (grid.swapaxes(0, 1), weights.T) if across else (grid, weights)
    degree = (1, n) if across else (n, 1)
    body = RuledSurface.from_nurbs(points, knots, loads if weighted else None, degree=degree, name="fan")
    spans = [(a, b) for a, b in zip(knots[n:], knots[n + 1 : count + 1], strict=False) if a < b]
    assert [piece.u for piece in body.pieces] == spans and isinstance(body, RuledStrip) == (len(spans) > 1)
    for (a, b), piece in zip(spans, body.pieces, strict=True):
        for u in (a, a + (b - a) / 3, b - F(1, 7) * (b - a)):
            for row, curve in enumerate((piece.first, piece.second)):
                controls = [[F(int(w)) * int(x) for x in (*p, 1)] for p, w in
                            zip(grid[:, row], weights[:, row], strict=True)]  # fmt: skip
                x, y, z, w = spline(knots, controls, n, u)
                assert exact_point(curve, u) == [x / w, y / w, z / w]
    for piece, following in zip(body.pieces, body.pieces[1:], strict=False):
        assert exact_point(piece.first, piece.u[1]) == exact_point(following.first, following.u[0])
        assert "u1" in piece.joined and "u0" in following.joined
    assert "u0" not in body.pieces[0].joined and "u1" not in body.pieces[-1].joined


def test_a_full_circle_of_nine_points_closes():
    r = 2**0.5 / 2
    ring = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)]
    points = [[(x, y, 0), (x, y, 3)] for x, y in ring]
    weights = [[1, 1] if k % 2 == 0 else [r, r] for k in range(9)]
    pipe = RuledSurface.from_nurbs(points, [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4], weights, name="pipe")
    assert len(pipe.pieces) == 4 and all(piece.joined == {"u0", "u1"} for piece in pipe.pieces)
    for piece in pipe.pieces:
        p = piece.points(np.linspace(*map(float, piece.u), 9)[:, None], [0, 0.5, 1])
        assert np.allclose(np.hypot(p[..., 0], p[..., 1]), 1, rtol=1e-15)
    lo, hi = pipe.bounds()
    assert np.allclose(lo, [-1, -1, 0], atol=0.02) and np.allclose(hi, [1, 1, 3], atol=0.02)


def test_rows_across_make_strips_side_by_side():
    points = [[(i, j, (i * j) % 3) for j in range(4)] for i in range(3)]
    body = RuledSurface.from_nurbs(points, ([0, 0, 0, 1, 1, 1], [0, 0, 1, 2, 3, 3]), name="fold")
    assert len(body.pieces) == 3
    assert [sorted(piece.joined) for piece in body.pieces] == [["s1"], ["s0", "s1"], ["s0"]]
    assert body.pieces[0].second == body.pieces[1].first


def test_a_strip_is_a_body():
    grid = [[(k, 0, k * k), (k, 2, 0)] for k in range(6)]
    strip = RuledSurface.from_nurbs(grid, [0, 0, 0, 0, 1, 2, 3, 3, 3, 3], name="wing")
    assert repr(strip) == "<RuledStrip 'wing': 3 pieces of degree 3>"
    moved = strip.translated((0, 0, 1)).rotated((0, 0, 1), degrees=90).named("tail")
    assert {piece.name for piece in moved.pieces} == {"tail"} and strip.name == "wing"
    assert moved.pieces[2].joined == strip.pieces[2].joined
    assert np.allclose(moved.bounds()[1], [0, 5, 26], atol=1)
    again = pickle.loads(pickle.dumps(strip))
    assert [piece.first for piece in again.pieces] == [piece.first for piece in strip.pieces]
    assert strip.at(3) is strip and strip.bounded and not strip.deforming
    sliding = strip.moving(fc.Translation((0, 0, 10)))
    assert sliding.at(0.5).pieces[0].first.points(0.0)[2] == 5.0 and sliding.bounds()[1][2] >= 35
    deforming = RuledStrip([RuledSurface("(u, T, 0)", "(u, 1 + T, 0)")], name="sheet")
    assert deforming.deforming and deforming.at(1).bounds()[0][1] == 1
    assert RuledSurface("(u, 0, 0)", "(u, 1, 0)").pieces[0].u == (0, 1)


GRID = [[(k, 0, 0), (k, 1, 0)] for k in range(4)]


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: RuledSurface.from_nurbs([(0, 0, 0), (1, 1, 1)]), "points[0][0] is 0"),
        (lambda: RuledSurface.from_nurbs([[(0, 0, 0)]]), "points have rows of [1]; give an (n, 2, 3)"),
        (lambda: RuledSurface.from_nurbs("x"), "points are 'x'"),
        (lambda: RuledSurface.from_nurbs([*GRID[:3], GRID[3][:1]]), "rows of [2, 2, 2, 1]"),
        (lambda: RuledSurface.from_nurbs([[(0, 0), (1, 1)]] * 3), "points[0][0] is (0, 0); give three numbers"),
        (lambda: RuledSurface.from_nurbs([[(0, 0, 0), (0, 0, float("nan"))]] * 3), "points[0][1][2] is nan"),
        (lambda: RuledSurface.from_nurbs([[(k, j, 0) for j in range(3)] for k in range(3)]), "3 x 3 points"),
        (lambda: RuledSurface.from_nurbs([[(k, j, 0) for j in range(3)] for k in range(3)], ([0, 0, 0, 1, 1, 1],) * 2),
         "degree (2, 2) is not ruled"),
        (lambda: RuledSurface.from_nurbs(GRID, [0, 0, 0, 2, 1, 1, 1]), "knot 1 comes after 2"),
        (lambda: RuledSurface.from_nurbs(GRID, [0, 0, 0, 0]), "4 knots for 4 points"),
        (lambda: RuledSurface.from_nurbs(GRID, [0] * 8), "all knots of the curves are 0"),
        (lambda: RuledSurface.from_nurbs(GRID, [0, 0, 1, 1, 2, 2]), "knot 1 stands 2 times"),
        (lambda: RuledSurface.from_nurbs(GRID, [0, 0, 0, 1, 2, 2, "x"]), "knots[6] is 'x'"),
        (lambda: RuledSurface.from_nurbs(GRID, ([0] * 4 + [1] * 4, [0, 1, 2, 3])), "repeat the first and the last"),
        (lambda: RuledSurface.from_nurbs(GRID, degree=2), "degree is 2, but knots and points make it 3"),
        (lambda: RuledSurface.from_nurbs(GRID, degree=(2, 1)), "degree is (2, 1), but"),
        (lambda: RuledSurface.from_nurbs(GRID, weights=[[1, 1]] * 3), "weights have rows of [2, 2, 2]"),
        (lambda: RuledSurface.from_nurbs(GRID, weights=[[1, 0]] * 4), "weights[0][1] is 0; give positive weights"),
        (lambda: RuledSurface.from_nurbs(GRID, weights=[["1e-300", 1]] * 4), "differ by more than a factor of 2^100"),
        (lambda: RuledSurface.from_nurbs(GRID, degree="3"), "degree is '3'; give the one along the curves"),
        (lambda: RuledSurface.from_nurbs(GRID, degree=3.0), "degree is 3.0; give"),
        (lambda: RuledSurface.from_nurbs(GRID, degree=(3,)), "degree is (3,); give"),
        (
            lambda: RuledSurface.from_nurbs(
                [[(0, 0, 0)] * 2, [(1, 1, 1)] * 2, [(2, 0, 0), (2, 1, 0)]], [0, 0, 1, 2, 2], name="w"
            ),
            "w: first and second are one curve; give two different ones (piece 0, u from 0 to 1)",
        ),
        (lambda: RuledSurface.from_nurbs(GRID, weights=[1] * 4), "weights are [1, 1, 1, 1]"),
        (lambda: RuledSurface.from_nurbs([[(k, 0, 0), (k, 0, 0)] for k in range(3)], name="roof"), "roof: first and"),
        (lambda: RuledStrip([]), "no pieces"),
    ],
)  # fmt: skip
def test_bad_grids_stop_with_one_line(make, text):
    with pytest.raises(fc.InputError) as error:
        make()
    assert text in str(error.value) and "\n" not in str(error.value)


# -- meshes -------------------------------------------------------------------------------------------------


def furthest(mesh, distance, n=4):
    """The largest value of `distance` over points of all triangles."""
    corners = mesh.vertices[mesh.triangles]
    share = np.array([(i / n, j / n, 1 - (i + j) / n) for i in range(n + 1) for j in range(n + 1 - i)])
    return distance(np.einsum("kc,mcx->mkx", share, corners).reshape(-1, 3)).max()


@pytest.mark.parametrize("tolerance", [0.1, 1e-3])
def test_meshes_stay_within_their_tolerance(tolerance):
    pipe = RuledSurface(CIRCLE.format(0), CIRCLE.format(1), u=None, name="pipe")
    mesh = pipe.to_mesh(tolerance)
    assert mesh.name == "pipe" and not mesh.solid
    off = furthest(mesh, lambda p: np.abs(np.hypot(p[:, 0], p[:, 1]) - 1))
    assert tolerance / 40 < off <= tolerance
    sides, count = np.unique(np.sort(mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0, return_counts=True)
    borders = sides[count == 1]
    assert set(mesh.vertices[borders][..., 2].ravel()) == {0.0, 1.0}  # it closes round
    saddle = RuledSurface("(u, 0, 0)", "(u, 1, u)", u=(-2, 2)).to_mesh(tolerance)
    assert tolerance / 40 < furthest(saddle, lambda p: np.abs(p[:, 2] - p[:, 0] * p[:, 1])) <= tolerance


def test_a_flat_piece_and_a_cone_take_few_triangles():
    assert len(RuledSurface("(u, 0, 0)", "(u, 1, 0)").to_mesh(1e-9).triangles) == 8
    cone = RuledSurface("(0, 0, 0)", CIRCLE.format(1), u=None).to_mesh(1e-2)
    # one triangle per ruling at the apex, closed round it
    assert len(cone.vertices) == len(np.unique(cone.vertices, axis=0))
    assert np.sum(np.any(np.all(cone.vertices[cone.triangles] == 0, axis=2), axis=1)) > 20


def test_trimming_cuts_the_mesh():
    body = RuledSurface("(u, 0, 0)", "(u, 1, 0)", trim=["u**2 + s**2 <= 1", "u >= s"])
    mesh = body.to_mesh(1e-3)
    assert np.all(mesh.vertices[:, 0] >= mesh.vertices[:, 1])
    assert np.all(np.hypot(mesh.vertices[:, 0], mesh.vertices[:, 1]) <= 1 + 1e-12)
    corners = mesh.vertices[mesh.triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    assert abs(area - np.pi / 8) < 1e-3
    round_ = RuledSurface(CIRCLE.format(0), CIRCLE.format(1), u=None, trim="u >= 0").to_mesh(1e-3)
    assert round_.vertices[:, 1].min() > -1e-9 and round_.vertices[:, 1].max() > 0.999


def test_what_cannot_be_meshed():
    body = RuledSurface("(u, 0, 0)", "(u, 1, u)", s=None)
    with pytest.raises(fc.InputError, match="whole rulings have no end"):
        body.to_mesh(0.1)
    part = RuledSurface("(u, 0, 0)", "(u, 1, u)")
    with pytest.raises(fc.InputError, match="trimming leaves nothing"):
        RuledSurface(part.first, part.second, trim=["(u - 0.51)**2 + (s - 0.52)**2 <= 1/100000"]).to_mesh(0.1)
    with pytest.raises(fc.InputError, match="give a positive length"):
        part.to_mesh(0)
    with pytest.raises(fc.InputError, match="larger tolerance"):
        RuledSurface("(u**3, 0, 0)", "(u, 1, u**2)", u=(0, 1000)).to_mesh(1e-12)
    with pytest.raises(fc.InputError, match="deforms"):
        RuledSurface("(u, T, 0)", "(u, 1, u)").to_mesh(0.1)
