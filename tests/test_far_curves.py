"""Intersection curves far from the origin are those near it: what is one point is told by the size of the scene."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc
from polylines import distance

AWAY = (-3145728, 7, -2097152)
CONE = fc.RuledSurface(
    "(0, 0, 0)",
    "((1 - 16/9*u - 5/3*u**2)/(1+u**2), (4 + 2/9*u + 4/3*u**2)/(1+u**2), (-1 - 8/9*u + 11/3*u**2)/(1+u**2))",
    u=None,
)  # fmt: skip
WEDGE = fc.RuledSurface(  # begins in the cone's apex
    "((-11/18*u - 7/18*u**2)/(4-u+u**2), (95/36*u + 13/36*u**2)/(4-u+u**2), (169/36*u + 11/36*u**2)/(4-u+u**2))",
    "((10/9 - 101/18*u + 11/6*u**2)/(4-u+u**2), (19/9 + 203/36*u - 89/12*u**2)/(4-u+u**2), "
    "(5/9 - 11/36*u - 19/12*u**2)/(4-u+u**2))",
)
SADDLE = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)")
PLANE = fc.RuledSurface("(u, 0, 1/2)", "(u, 1, 1/2)")
CORNERS = [(-1, -1, -1), (2, 0, 0), (0, 2, 0), (0, 0, 2)]
TETRAHEDRON = fc.Polyhedron(CORNERS, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
PAIRS = {
    "an apex in a corner": (CONE, WEDGE),
    "a saddle and a plane": (SADDLE, PLANE),
    "a saddle and a ball": (SADDLE, fc.sphere("3/4")),
    "a can and a cone": (fc.cylinder("1/2", 1), CONE),
    "a saddle and a mesh": (SADDLE, TETRAHEDRON),
}
BOX = ((F(-1, 8), F(-1, 2), F(-3, 4)), (F(7, 8), F(7, 8), F(7, 8)))


@pytest.mark.share(4)
@pytest.mark.parametrize("size", [F(1), F(1, 2**40), F(2**30)], ids=["1", "2^-40", "2^30"])
@pytest.mark.parametrize("boxed", [False, True], ids=["", "boxed"])
@pytest.mark.parametrize("pair", list(PAIRS))
def test_the_curve_is_that_near_the_origin(pair, boxed, size):
    by = [x * size for x in AWAY]
    k = [[size if i == j else 0 for j in range(3)] + [0] for i in range(3)] + [[0, 0, 0, 1]]
    there = [x.transformed(k).translated(by) for x in PAIRS[pair]]
    box = tuple(tuple(size * x + d for x, d in zip(c, by, strict=True)) for c in BOX) if boxed else None
    near = fc.intersection_curve(*PAIRS[pair], tolerance=1e-4, box=BOX if boxed else None)
    far = fc.intersection_curve(*there, tolerance=1e-4 * float(size), box=box)
    shift, ulp = np.array(by, float), 4e-16 * float(3145728 * size)
    assert not near.empty and len(far.branches) == len(near.branches)
    assert [len(x.points) for x in far.branches] == [len(x.points) for x in near.branches]
    for one, other in zip(far.branches, near.branches, strict=True):
        assert np.abs(one.points - shift - float(size) * other.points).max() <= ulp + 1e-9 * float(size)
        assert [end.kind for end in one.ends] == [end.kind for end in other.ends]
        assert one.parameters == pytest.approx(other.parameters, abs=1e-9, nan_ok=True)
    assert len(far.isolated_points) == len(near.isolated_points) == (pair == "an apex in a corner")
    assert np.abs(far.isolated_points - shift - float(size) * near.isolated_points).max(initial=0.0) <= ulp
    if boxed:
        assert far.box == pytest.approx(np.array(box, float))


@pytest.mark.share(2)
@pytest.mark.parametrize("size", [F(1), F(1, 2**20), F(2**30)], ids=["1", "2^-20", "2^30"])
@pytest.mark.parametrize("other", ["surface", "half-space", "sheet"])
def test_a_saddle_is_cut_in_a_hyperbola(other, size):
    """z = x y over the unit square at height 1/2: by school, from (1/2, 1) to (1, 1/2)."""
    x, y, z = (c * size for c in AWAY)
    level = z + size / 2
    saddle = fc.RuledSurface(f"({x} + {size}*u, {y}, {z})", f"({x} + {size}*u, {y + size}, {z} + {size}*u)")
    corners = [(x, y, level), (x + size, y, level), (x + size, y + size, level), (x, y + size, level)]
    cut = {
        "surface": fc.RuledSurface(f"({x} + {size}*u, {y}, {level})", f"({x} + {size}*u, {y + size}, {level})"),
        "half-space": fc.half_space((0, 0, 1), level),
        "sheet": fc.Polyhedron(corners, [[0, 1, 2, 3]]),
    }[other]
    (branch,) = fc.intersection_curve(saddle, cut, tolerance=1e-4 * float(size)).branches
    p, q, h = ((branch.points - np.array([x, y, z], float)) / float(size)).T
    assert np.abs(h - 0.5).max() < 4e-9 and np.abs(p * q - 0.5).max() < 4e-9
    assert sorted([p[0], p[-1]]) == pytest.approx([0.5, 1.0], abs=4e-9)
    t = np.linspace(0.5, 1.0, 300)
    truth = np.stack((t, 0.5 / t, np.full(300, 0.5)), axis=1) * float(size) + np.array([x, y, z], float)
    assert distance(truth, [branch]) <= 1.001e-4 * float(size)
