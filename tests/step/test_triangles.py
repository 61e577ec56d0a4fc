"""Solids as triangles: closed, with the volume they should have, and no farther from the file's faces than is said."""

import numpy as np
import pytest

pytest.importorskip("OCP")

from OCP.BRep import BRep_Tool  # noqa: E402
from OCP.BRepPrimAPI import BRepPrimAPI_MakeTorus  # noqa: E402
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt, gp_Pnt2d  # noqa: E402
from OCP.IntTools import IntTools_FClass2d  # noqa: E402
from OCP.TopAbs import TopAbs_State  # noqa: E402

import firstcontact as fc  # noqa: E402
import step_shapes as shapes  # noqa: E402
from firstcontact.step.bounds import _derivative_bounds, _less, _times  # noqa: E402
from firstcontact.step.reader import Shape  # noqa: E402
from firstcontact.step.solids import StepSolid  # noqa: E402
from firstcontact.step.triangles import _areas, _Builder, cut_by, triangulated, unfolded  # noqa: E402


def torus_and_half_a_torus():
    """Middles of the borders' sides come to lie beyond the corners opposite to these."""
    near = gp_Ax2(gp_Pnt(-1.75, -0.0625, 0.25), gp_Dir(-0.65, -0.755, 0.09), gp_Dir(-0.27, 0.12, -0.955))
    half = BRepPrimAPI_MakeTorus(near, 2.0, 0.125, np.pi).Shape()
    whole = BRepPrimAPI_MakeTorus(gp_Ax2(gp_Pnt(-1.625, -0.625, 0.5), gp_Dir(0, -1, 0)), 1.8125, 0.6875).Shape()
    return shapes.fuse(half, whole)


SHAPES = {
    "cylinder": lambda: shapes.cylinder(2, 5),
    "cone": lambda: shapes.cone(2, 0, 3),
    "sphere": lambda: shapes.sphere(3, (1, 2, 3)),
    "torus": lambda: shapes.torus(3, 1),
    "crossing pipes": lambda: shapes.fuse(
        shapes.cylinder(1, 6, (0, 0, -3)), shapes.cylinder(0.8, 6, (-3, 0, 0.2), (1, 0, 0))
    ),
    "filleted box": lambda: shapes.filleted(shapes.box((4, 3, 2)), 0.4),
    "wave": shapes.wave,
    "vase": shapes.vase,
    "torus and half a torus": torus_and_half_a_torus,
    "bored ball": lambda: shapes.cut(shapes.sphere(2), shapes.cylinder(0.7, 6, (0.3, 0, -3))),
}


def distances(points, corners):
    """(n,) from points (n, 3) to the nearest of triangles (m, 3, 3), by projection and clamping."""
    a, ab, ac = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    found = np.full(len(points), np.inf)
    for k, p in enumerate(points):
        ap = p - a
        d1, d2 = (ab * ap).sum(1), (ac * ap).sum(1)
        aa, bb, cc = (ab * ab).sum(1), (ab * ac).sum(1), (ac * ac).sum(1)
        det = np.maximum(aa * cc - bb * bb, 1e-30)
        v, w = (cc * d1 - bb * d2) / det, (aa * d2 - bb * d1) / det
        inside = (v >= 0) & (w >= 0) & (v + w <= 1)
        best = np.where(inside, np.linalg.norm(ap - v[:, None] * ab - w[:, None] * ac, axis=1), np.inf)
        for p0, p1 in ((0, 1), (1, 2), (2, 0)):
            q, d = corners[:, p0], corners[:, p1] - corners[:, p0]
            t = np.clip(((p - q) * d).sum(1) / np.maximum((d * d).sum(1), 1e-30), 0, 1)
            best = np.minimum(best, np.linalg.norm(p - q - t[:, None] * d, axis=1))
        found[k] = best.min()
    return found


def on_faces(solid, count, rng):
    """Points of the solid's faces."""
    points = []
    for face in solid.faces:
        surface, classify = BRep_Tool.Surface_s(face), IntTools_FClass2d(face, 1e-9)
        from OCP.BRepTools import BRepTools

        u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
        for u, v in rng.uniform((u0, v0), (u1, v1), (count, 2)).tolist():
            if classify.Perform(gp_Pnt2d(u, v)) == TopAbs_State.TopAbs_IN:
                p = surface.Value(u, v)
                points.append((p.X(), p.Y(), p.Z()))
    return np.array(points)


@pytest.mark.share(11)
@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("share", [0.02, 0.002])
def test_triangles_and_faces_are_as_near_each_other_as_is_said(name, share):
    rng = np.random.default_rng(5)
    solid = StepSolid(SHAPES[name](), Shape(SHAPES[name](), name))
    solid.check()
    wanted = share * solid.size
    net = triangulated(solid, wanted)
    assert 0 < net.deviation <= wanted
    corners = net.points[net.triangles]
    there = on_faces(solid, 25, rng)
    assert len(there) > 20
    assert distances(there, corners).max() <= net.deviation
    weights = rng.dirichlet((1, 1, 1), 40)
    back = np.einsum("nk,nkj->nj", weights, corners[rng.integers(0, len(corners), 40)])
    assert max(shapes.distance(solid.shape, p) for p in back) <= net.deviation


@pytest.mark.parametrize("height", [1e-9, 0.1, 0.9])
def test_a_corner_beyond_the_side_opposite_to_it(height):
    """The middle of the lower border is above the side 0 1: it belongs to the triangle there, with no area but that."""
    uv = np.array([(0.0, 0.0), (2.0, 0.0), (1.0, 1.0), (1.0, height), (1.0, 3.0)])
    triangles, known = [(0, 3, 1), (0, 1, 2), (1, 4, 2), (2, 4, 0)], [0.5, 0.25, 0.125, 0.75]
    found, told = unfolded(uv, triangles, known)
    assert sorted(map(sorted, found)) == [[0, 2, 3], [0, 2, 4], [1, 2, 3], [1, 2, 4]]
    assert (_areas(uv, np.array(found)) > 0).all()
    assert _areas(uv, np.array(found)).sum() == pytest.approx(_areas(uv, np.array(triangles)).sum())
    assert [x for x in told if x is not None] == [0.125, 0.75]
    assert unfolded(uv, found, told) == (found, told)


def test_a_corner_beyond_two_sides():
    uv = np.array([(0.0, 0.0), (2.0, 0.0), (0.2, 0.5), (1.0, 3.0), (1.2, 0.4)])
    found, _ = unfolded(uv, [(0, 4, 1), (0, 1, 2), (1, 3, 2), (2, 3, 0)], [None] * 4)
    assert sorted(map(sorted, found)) == [[0, 2, 3], [0, 2, 4], [1, 3, 4], [2, 3, 4]]
    assert (_areas(uv, np.array(found)) > 0).all()


def test_a_corner_that_leaves_another_one_outside_is_left_to_finer_triangles():
    uv = np.array([(0.0, 0.0), (2.0, 0.0), (1.0, 1.0), (1.0, 1.5)])
    found, _ = unfolded(uv, [(0, 3, 1), (0, 1, 2)], [None, None])
    assert (_areas(uv, np.array(found)) < 0).any()


@pytest.mark.thorough
def test_a_face_that_folded_took_minutes():
    """It was cut anew, ever finer, and folded every time; the first triangles do."""
    shape, times = torus_and_half_a_torus(), []
    solid = StepSolid(shape, Shape(shape, "tori"))
    solid.check()
    wanted = 0.0006 * solid.size
    net = cut_by(solid, wanted, lambda: times.append(1) or _Builder(solid, wanted).net())
    assert net.deviation <= wanted and len(times) == 1


def test_a_deviation_below_what_open_cascade_takes():
    """It raised an error of its own."""
    shape = shapes.cylinder(1e-4, 1e-4)
    with pytest.raises(fc.InputError, match="edges and corners are off by more than deviation= 1e-08"):
        triangulated(StepSolid(shape, Shape(shape, "pin")), 1e-8)


TIPS = {
    "cone": lambda: shapes.cone(0, 2, 3),
    "upside down": lambda: shapes.cone(2, 0, 3),
    "needle": lambda: shapes.cone(0, 0.2, 5),
    "ball": lambda: shapes.sphere(2),
    "sector of a cone": lambda: shapes.sector(2.0, 0.0, 2.5, 2.5),
    "half a cone": lambda: shapes.cut(shapes.cone(0, 2, 3), shapes.box((5, 5, 5), (0, -2.5, -1))),
}


@pytest.mark.share(6)
@pytest.mark.parametrize("name", TIPS)
def test_triangles_around_poles_are_fine_from_the_start(name):
    """A cone took minutes and was refused at the default deviation: its triangles had one corner at the tip, and lay
    across it in parameters."""
    rng = np.random.default_rng(6)
    solid = StepSolid(TIPS[name](), Shape(TIPS[name](), name))
    solid.check()
    net = triangulated(solid, 1e-4 * solid.size)
    assert 0 < net.deviation <= 1e-4 * solid.size and len(net.triangles) < 70_000
    corners = net.points[net.triangles]
    assert distances(on_faces(solid, 8, rng), corners).max() <= net.deviation
    back = np.einsum("nk,nkj->nj", rng.dirichlet((1, 1, 1), 25), corners[rng.integers(0, len(corners), 25)])
    assert max(shapes.distance(solid.shape, p) for p in back) <= net.deviation


def test_bounds_of_derivatives_hold_of_sampled_ones():
    rng = np.random.default_rng(3)

    def at(net, u, v):
        from math import comb

        rows = [np.array([comb(n - 1, i) * t**i * (1 - t) ** (n - 1 - i) for i in range(n)])
                for n, t in zip(net.shape[:2], (u, v), strict=True)]  # fmt: skip
        x = np.einsum("i,j,ijk->k", *rows, net)
        return x[:-1] / x[-1]

    h, du, dv = 1e-4, 2.0, 0.5
    for _ in range(12):
        net = rng.normal(0, 1, (*rng.integers(2, 5, 2), 4))
        net[..., 3] = rng.uniform(0.8, 1.3, net.shape[:2])
        net[..., :3] *= net[..., 3:]
        bounds, _ = _derivative_bounds(net, du, dv)
        for u, v in rng.uniform(0.01, 0.99, (10, 2)):
            p = {(i, j): at(net, u + i * h, v + j * h) for i in (-1, 0, 1) for j in (-1, 0, 1)}
            seen = [
                (p[1, 0] - p[-1, 0]) / (2 * h * du), (p[0, 1] - p[0, -1]) / (2 * h * dv),
                (p[1, 0] - 2 * p[0, 0] + p[-1, 0]) / (h * du) ** 2,
                (p[1, 1] - p[1, -1] - p[-1, 1] + p[-1, -1]) / (4 * h * h * du * dv),
                (p[0, 1] - 2 * p[0, 0] + p[0, -1]) / (h * dv) ** 2,
            ]  # fmt: skip
            assert (np.linalg.norm(seen, axis=1) <= bounds * (1 + 1e-4) + 1e-4).all()


def test_products_of_nets_are_those_of_polynomials():
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(3, 2, 3)), rng.normal(size=(2, 4, 1))
    product = _times(a, b)
    assert product.shape == (4, 5, 3)
    assert np.allclose(product[0, 0], a[0, 0] * b[0, 0]) and np.allclose(product[-1, -1], a[-1, -1] * b[-1, -1])
    assert np.allclose(_less(product, product), 0)


def test_a_face_without_bounds_is_refused_by_name():
    with pytest.raises(fc.InputError, match=r"lump: face 4 is of kind OffsetSurface, whose triangles have no proved"):
        fc.from_shape(shapes.offset_prism(), name="lump")


def test_spheres_take_few_triangles():
    """Drift along the surface was counted: 294,000 at a ten-thousandth of the size, in 25 s."""
    solid = StepSolid(shape := shapes.sphere(2), Shape(shape, "ball"))
    net = triangulated(solid, 1e-3 * solid.size)
    assert net.deviation <= 1e-3 * solid.size and len(net.triangles) < 10_000


def test_distances_from_round_surfaces_are_within_their_bounds():
    from OCP.BRep import BRep_Tool

    from firstcontact.step.charts import Elementary
    from firstcontact.step.sagitta import sagitta

    rng = np.random.default_rng(8)
    made = {"cylinder": shapes.cylinder(2, 5), "cone": shapes.cone(2, 0.3, 3), "sphere": shapes.sphere(2)}
    for shape in (*made.values(), shapes.torus(3, 1)):
        face = StepSolid(shape, Shape(shape, "part")).faces[0]
        chart = Elementary(BRep_Tool.Surface_s(face))
        middle, size = rng.uniform((0, -1), (6, 1), (60, 1, 2)), 10.0 ** rng.uniform(-2, -0.4, (60, 1, 1))
        uv = middle + size * rng.uniform(-1, 1, (60, 3, 2))
        found = sagitta(chart, uv, np.zeros(60))
        weights = rng.dirichlet((0.7, 0.7, 0.7), 50)
        points = np.einsum("kc,ncj->nkj", weights, chart.at(uv.reshape(-1, 2)).reshape(-1, 3, 3))
        x = (points - chart.origin) @ chart.axes.T
        radius, surface = np.hypot(x[..., 0], x[..., 1]), chart.surface
        off = {
            "Cylindrical": lambda r, z, s: s.Radius() - r,
            "Conical": lambda r, z, s: (s.RefRadius() + z * np.tan(s.SemiAngle()) - r) * np.cos(s.SemiAngle()),
            "Spherical": lambda r, z, s: s.Radius() - np.hypot(r, z),
            "Toroidal": lambda r, z, s: s.MinorRadius() - np.hypot(r - s.MajorRadius(), z),
        }[chart.kind](radius, x[..., 2], surface)  # fmt: skip
        most = np.abs(off).max(axis=1)
        assert (most <= found.away + 1e-12).all() and (most > 0.2 * found.away).mean() > 0.5
