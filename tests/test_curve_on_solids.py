"""Intersection curves of ruled surfaces with boundaries of solids: known curves, samples, the same shapes as ruled."""

from __future__ import annotations

import json
from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from amount import amount
from firstcontact.errors import UnsupportedPair

SADDLE = fc.RuledSurface("(2*u-1, -1, 1-2*u)", "(2*u-1, 1, 2*u-1)", name="saddle")
CIRCLE = "(1-u**2)/(1+u**2), 2*u/(1+u**2)"
PIPE = fc.RuledSurface(f"({CIRCLE}, -1)", f"({CIRCLE}, 1)", u=None, name="pipe")
CONE = fc.RuledSurface("(0, 0, 1)", f"({CIRCLE}, 0)", u=None, name="cone")
PLATE = fc.box((1, 1, 1)) - fc.cylinder("1/3", 3)
SOLIDS = {
    "plane": fc.half_space((1, 2, 3), "1/2"),
    "ball": fc.sphere("4/5").translated(("1/2", "1/7", 0)),
    "bar": fc.cylinder("1/2", 4).rotated((0, 1, 0), degrees=90),
    "plate": PLATE.translated(("1/4", "1/9", "1/5")),
}


def values(solid, points):
    """(surfaces, n) distances from the surfaces, about."""
    x = np.column_stack([points, np.ones(len(points))])
    gradients = 2 * np.einsum("fij,nj->fni", solid.forms, x)[:, :, :3]
    return np.einsum("ni,fij,nj->fn", x, solid.forms, x) / np.linalg.norm(gradients, axis=2)


@pytest.mark.parametrize("surface", [SADDLE, PIPE, CONE])
@pytest.mark.parametrize("name", SOLIDS)
def test_points_are_on_both_and_no_crossing_is_missed(surface, name):
    solid = SOLIDS[name]
    curve = fc.intersection_curve(surface, solid, tolerance=1e-3)
    points = np.concatenate([np.zeros((0, 3)), *(b.points for b in curve.branches), curve.isolated_points])
    assert len(points) == 0 or np.abs(values(solid, points)).min(axis=0).max() < 1e-12
    for branch in curve.branches:
        u, v, s, t = branch.parameters.T
        assert np.isnan(v).all() and np.isnan(t).all()
        assert np.abs(surface.points(u, s) - branch.points).max() < 1e-12
    lines = [x[:-1] + k / 16 * np.diff(x, axis=0) for x in (b.points for b in curve.branches) for k in range(17)]
    passed = np.concatenate([points, *lines])
    # where neighbours on a grid are on different sides of the boundary, the curve passes between
    u, s = np.meshgrid(np.tan(np.linspace(-1.5, 1.5, 61)) if surface.u is None else np.linspace(0, 1, 41),
                       np.linspace(0, 1, 31))  # fmt: skip
    grid = surface.points(u, s)
    inside = solid.contains(grid.reshape(-1, 3)).reshape(u.shape)
    seen = 0
    for axis in (0, 1):
        one, other = (np.take(grid, range(k, grid.shape[axis] - 1 + k), axis) for k in (0, 1))
        change = np.diff(inside.astype(int), axis=axis) != 0
        for x, y in zip(one[change], other[change], strict=True):
            gap = np.linalg.norm(passed - 0.5 * (x + y), axis=1).min()
            assert gap < 1.5 * np.linalg.norm(x - y) + 0.02
            seen += 1
    assert bool(seen) == bool(curve.branches)


@pytest.mark.parametrize("shift", range(amount(3)))
def test_a_cylinder_is_a_solid_and_a_ruled_surface(shift):
    pipe = fc.RuledSurface(f"({CIRCLE}, -3)", f"({CIRCLE}, 3)", u=None).rotated((1, 0, 0), degrees=90)
    other = pipe.translated((Fraction(shift, 5), 0, Fraction(1, 3)))
    solid = fc.cylinder(1, 6).rotated((1, 0, 0), degrees=90).translated((Fraction(shift, 5), 0, Fraction(1, 3)))
    by_rulings = fc.intersection_curve(PIPE, other, tolerance=1e-3)
    by_form = fc.intersection_curve(PIPE, solid, tolerance=1e-3)
    assert len(by_form.branches) == len(by_rulings.branches)
    ends = [sorted(tuple(np.round(e.point, 9)) for b in c.branches for e in b.ends) for c in (by_form, by_rulings)]
    assert np.allclose(ends[0], ends[1], atol=1e-8)


def test_a_saddle_and_a_plane():
    """On z = x y the plane z = 1/2 - x is x = 1 / (2 (1 + y)), from (1, -1/2) to (1/4, 1)."""
    curve = fc.intersection_curve(SADDLE, fc.half_space((1, 0, 1), "1/2"))
    (branch,) = curve.branches
    ends = {end.on: (end.u, end.point.tolist()) for end in branch.ends}
    assert ends == {("u=1",): (1, [1.0, -0.5, -0.5]), ("s=1",): (Fraction(5, 8), [0.25, 1.0, 0.25])}
    x, y, _ = branch.points.T
    assert np.allclose(2 * x * (1 + y), 1, atol=1e-14)
    first = branch.to_dict()["ends"][0]
    assert first["v"] is None and "nan" not in str(curve)
    swapped = fc.intersection_curve(fc.half_space((1, 0, 1), "1/2"), SADDLE)
    text = swapped.to_json()
    assert "NaN" not in text and "nan" not in text and "nan" not in str(swapped)
    assert [x is None for x in json.loads(text)["branches"][0]["parameters"][0]] == [True, False, True, False]
    assert {node.u for node in swapped.graph.nodes} == {None}
    swapped = swapped.branches[0]
    assert np.array_equal(swapped.parameters[:, [1, 3]], branch.parameters[:, [0, 2]])


def test_degenerate_contacts():
    ring = fc.intersection_curve(PIPE, fc.sphere(1))
    assert (len(ring.branches), ring.branches[0].closed, ring.branches[0].multiplicity) == (1, True, 2)
    tip = fc.intersection_curve(CONE, fc.sphere(1))
    assert tip.isolated_points.tolist() == [[0.0, 0.0, 1.0]] and len(tip.branches) == 1
    through = fc.intersection_curve(CONE, fc.half_space((1, 0, 0), 0))
    (rulings,) = through.branches
    assert [0.0, 0.0, 1.0] in rulings.points.tolist() and not len(through.singular_points)
    tangent = fc.intersection_curve(CONE, fc.box((1, 1, 1)))  # the circle z = 1/2 touches four sides of the box
    assert len(tangent.branches) == 8
    assert sorted(p.point.tolist() for p in tangent.singular_points) == [
        [-0.5, 0.0, 0.5], [0.0, -0.5, 0.5], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]]  # fmt: skip
    same = fc.intersection_curve(PIPE, fc.quadric(np.diag([1.0, 1.0, 0.0, -1.0])))
    assert same.two_dimensional and not same.branches
    assert fc.intersection_curve(PIPE, fc.sphere("9/10")).empty


def test_bounds_cut_the_curve():
    floor = fc.half_space((0, 0, 1), "1/2")
    half = fc.RuledSurface(PIPE.first, PIPE.second, u=None, trim=["u >= 0"])
    (arc,) = fc.intersection_curve(half, floor).branches
    assert {end.on for end in arc.ends} == {("trim",)}
    assert sorted(end.point.tolist() for end in arc.ends) == [[-1.0, 0.0, 0.5], [1.0, 0.0, 0.5]]
    (arc,) = fc.intersection_curve(PIPE, floor, box=((0, -2, -2), (2, 2, 2))).branches
    assert {end.on for end in arc.ends} == {("x=0",)}
    cube = fc.Polyhedron(fc.examples.box((1, 1, 1)).vertices, fc.examples.box((1, 1, 1)).triangles)
    curves = [fc.intersection_curve(SADDLE, body).branches for body in (cube, fc.box((1, 1, 1)))]
    assert np.array_equal(curves[0][0].points[0], curves[1][0].points[0]) and len(curves[0]) == len(curves[1]) == 1


def test_whole_rulings_and_bounded_solids():
    """The same curve as with long rulings: of a double cone with a ball and with triangles, and of a plane."""
    cone = "(0, 0, 0)", "((1-u**2)/(1+u**2), 2*u/(1+u**2), 1)"
    cube = fc.Polyhedron(fc.examples.box((1, 2, 1)).vertices, fc.examples.box((1, 2, 1)).triangles)
    plane = "(u, 0, 1/3)", "(u, u + 1, u/9 + 1/3)"
    for ends, u, solid in ((cone, None, fc.sphere(2).translated((0, 1, 0))), (cone, None, cube), (plane, (0, 1), cube)):
        whole, cut = (fc.RuledSurface(*ends, u=u, s=s) for s in (None, (-9, 9)))
        found, same = (fc.intersection_curve(x, solid, tolerance=1e-3) for x in (whole, cut))
        assert len(found.branches) == len(same.branches) > 0 and found.box is None
        assert sum(b.length for b in found.branches) == pytest.approx(sum(b.length for b in same.branches), rel=1e-4)
        assert (found.a, found.b) == (whole, solid)
    assert fc.intersection_curve(whole, cube, box=((-1, -1, -1), (1, 1, 1))).box.tolist() == [[-1] * 3, [1] * 3]


@pytest.mark.parametrize(
    ("surface", "solid", "message"),
    [
        (fc.RuledSurface("(u, 0, 0)", "(u, 1, u)", s=None), fc.half_space((0, 0, 1), 1), "the solid is unbounded"),
        (SADDLE, fc.sphere(1).moving(fc.Translation((1, 0, 0))), "give a body at rest"),
        (PIPE, fc.cylinder(1, 1), "lies in one surface"),
    ],
)
def test_refusals(surface, solid, message):
    with pytest.raises(UnsupportedPair, match=message):
        fc.intersection_curve(surface, solid)
