"""Every edge of degree 4 is found, however short: lenses, rings and arcs of a known depth, against closed forms."""

from __future__ import annotations

from fractions import Fraction as F
from random import Random

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.body.solid.carriers import QuarticCurve
from firstcontact.body.solid.composite_quadric import NoSolid
from firstcontact.exact.curves.quadric_curve import swept
from lenses import PAIRS, pushed

TURN = ((F(3, 5), F(-4, 5), 0, 0), (F(4, 5), F(3, 5), 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))
DEPTHS = [F(1, 10**k) for k in (3, 6, 7, 9, 11, 12, 15, 18, 25)]


SCENES = [(20, 5, "1e-7"), (20, 5, "1e-12"), (100, 1, "1e-6"), (20, 5, "1e-60")]


def quartic_pieces(body) -> int:
    return sum(len(e.pieces) for e in body.edges if isinstance(e.carrier, QuarticCurve))


@pytest.mark.share(40)
@pytest.mark.parametrize("kinds", PAIRS, ids=["-".join(k.__name__ for k in p) for p in PAIRS])
def test_solids_pushed_into_each_other_share_a_lens_and_no_others_do(kinds):
    number = PAIRS.index(kinds)
    depth = DEPTHS[number % len(DEPTHS)]
    pair = pushed(kinds, depth, Random(number))
    assert max(pair.inside) < 0  # the middle of the lens is inside both, by their equations
    lens = pair.a & pair.b
    assert lens.contains(pair.middle) and lens.edges and len(lens.faces) == 2
    for apart in (F(0), -depth):
        pair = pushed(kinds, apart, Random(number))
        with pytest.raises(NoSolid):
            _ = pair.a & pair.b


@pytest.mark.share(8)
@pytest.mark.parametrize("turned", ["no", "rationally", "by 40 degrees", "about y"])
@pytest.mark.parametrize(("ball", "tube", "depth"), SCENES)
def test_a_ball_dips_into_a_cylinder(ball, tube, depth, turned):
    a, b = fc.sphere(ball), fc.cylinder(tube, 10).translated((ball + tube - F(depth), 0, 0))
    turn = {
        "no": lambda x: x,
        "rationally": lambda x: x.transformed(TURN),
        "by 40 degrees": lambda x: x.rotated((1, 2, 3), degrees=40),
        "about y": lambda x: x.rotated((0, 1, 0), degrees=77),
    }[turned]
    a, b = turn(a), turn(b)
    assert repr(a & b) == "<CompositeQuadric: 2 faces, 1 edge, 0 vertices>"
    assert repr(a - b) == "<CompositeQuadric: 2 faces, 1 edge, 0 vertices>"
    union = a | b
    assert len(union.faces) == 4 and [e.convexity for e in union.edges].count("reentrant") == 1
    assert quartic_pieces(union) == 1


@pytest.mark.share(2)
@pytest.mark.parametrize("depth", ["1e-3", "1e-9", "1e-22"])
def test_a_ball_stays_outside_or_only_touches(depth):
    a, b = fc.sphere(20).transformed(TURN), fc.cylinder(5, 10)
    for gap in (F(0), F(depth)):
        with pytest.raises(NoSolid):
            _ = a & b.translated((25 + gap, 0, 0)).transformed(TURN)


@pytest.mark.share(4)
@pytest.mark.parametrize("thin", [F(1, 10**k) for k in (2, 9, 14, 30)])
def test_both_loops_of_a_thin_ring(thin):
    """E2 = E1 + z^2 - thin (1 + x/10 + y/7) < 0 beyond E1 is a ring around z = 0, of that height squared."""
    first = [[F(1, 4), 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, -1]]
    second = [row[:] for row in first]
    second[2][2] += 1
    second[3][3] -= thin
    for k, c in ((0, F(1, 10)), (1, F(1, 7))):
        second[k][3] = second[3][k] = -thin * c / 2
    a, b = fc.quadric(first), fc.quadric(second)
    ring = (b - a).transformed(TURN)
    assert len(ring.faces) == 2 and quartic_pieces(ring) == 2
    outer, at = 1 + thin / 8, np.array([6, 4]) / 5  # a point (6/5, 4/5, 0) of the first ellipsoid, moved outwards
    x, y = F(int(5 * at[0]), 5) * outer, F(int(5 * at[1]), 5) * outer
    inner = x * x / 4 + y * y - 1
    assert 0 < inner < thin * (1 + x / 10 + y / 7)
    assert (b - a).contains((x, y, 0))


@pytest.mark.share(4)
@pytest.mark.parametrize("off", [F(1, 10**k) for k in (1, 6, 9, 20)])
def test_loops_that_nearly_touch_are_told_apart(off):
    """Crossing cylinders with radii 1 and 1 +- off: two loops around the thinner one, closer than any step."""
    wide = fc.cylinder(1 + off, 6).rotated((1, 0, 0), degrees=90)
    thin = fc.cylinder(1 - off, 6).rotated((1, 0, 0), degrees=90)
    for other in (wide, thin):
        body = (fc.cylinder(1, 6) | other).transformed(TURN)
        loops = [e for e in body.edges if isinstance(e.carrier, QuarticCurve)]
        assert sum(len(e.pieces) for e in loops) == 2
        across = np.array([3, 4, 0]) / 5 if other is thin else np.array([0, 0, 1])
        along = np.array([-4, 3, 0]) / 5 if other is thin else across
        for e in loops:
            for piece in e.pieces:
                signs = np.sign(e.frame[int(piece.lo) : int(piece.hi) + 1] @ along)
                assert abs(signs.sum()) == len(signs)


@pytest.mark.parametrize("thin", [F(1, 10**k) for k in (1, 8, 19)])
def test_both_ends_of_the_shortest_arcs(thin):
    """The plane z = 1/2 - thin cuts a drilled hole's two edges just below their highest points (+-1, 0, 1/2)."""
    hole = fc.cylinder("1/2", 6).rotated((0, 1, 0), degrees=90)
    upper = fc.half_space((0, 0, -1), thin - F(1, 2))
    body = ((fc.cylinder(1, 6) - hole) & upper).transformed(TURN)
    assert quartic_pieces(body) == 2 and len(body.vertices) == 4
    z = F(1, 2) - thin
    half = float(F(1, 4) - z * z) ** 0.5
    for x, y in ((s * (1 - half**2) ** 0.5, t * half) for s in (1, -1) for t in (1, -1)):
        p = np.array([0.6 * x - 0.8 * y, 0.8 * x + 0.6 * y, float(z)])
        assert min(np.abs(np.array(v.position) - p).max() for v in body.vertices) < 1e-12


def test_a_sweep_meets_all_points_of_planes():
    """As many branches as sampled planes show: real roots of the quartic by NumPy, far from events."""
    r = np.random.default_rng(5)
    for _ in range(12):
        forms = []
        for _ in range(2):
            m = r.integers(-6, 7, (4, 4))
            forms.append([[fmpq(int(x)) for x in row] for row in m + m.T])
        sweep = swept(*forms, [], ([fmpq(-2)] * 3, [fmpq(2)] * 3))
        for cell, level in zip(sweep.cells, sweep.levels, strict=True):
            quartic = [float(fmpq(p(level)) / sweep.curve.fibre[4](level)) for p in sweep.curve.fibre]
            roots = np.roots(quartic[::-1])
            clear = np.abs(roots.imag)
            if np.any((clear > 1e-9) & (clear < 1e-4)):
                continue
            assert len(cell) == np.sum(clear < 1e-9)
            for branch in cell:
                x = [float(c) for c in sweep.point(branch, 128)]
                for form in forms:
                    terms = [float(form[i][j]) * x[i] * x[j] for i in range(4) for j in range(4)]
                    assert abs(sum(terms)) < 1e-12 * sum(map(abs, terms))


@pytest.mark.parametrize("narrow", [F(1, 10), F(1, 10**3), F(1, 10**9)])
def test_narrow_surfaces_without_edges_are_seen(narrow):
    steep = 1 / narrow**2
    for last, faces, tips in ((1, 1, 0), (0, 1, 1)):
        body = fc.quadric([[steep, 0, 0, 0], [0, steep, 0, 0], [0, 0, -1, 0], [0, 0, 0, last]])
        assert (len(body.faces), len(body.vertices)) == (faces, tips)


@pytest.mark.parametrize("thin", [F(1, 10), F(1, 10**6), F(1, 10**20)])
def test_a_thin_sector_of_a_cone_has_its_apex(thin):
    cone = fc.quadric([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 0]]) & fc.half_space((0, 0, -1), 0)
    sector = cone - fc.half_space((1 + thin, 0, -1), 0)
    assert sector.contains((0, 0, 0)) and len(sector.vertices) == 1


def test_a_curve_through_an_apex():
    """The ball touches the cone in its tip only; the cylinder leaves the cone along a curve that ends in the tip."""
    ball = fc.sphere(1).translated((F(3, 5), 0, F(14, 5)))
    assert repr(fc.cone(1, 2) - ball) == "<CompositeQuadric: 2 faces, 1 edge, 1 vertex>"
    union = fc.cone(2, 4) | fc.cylinder("1/2", 9).translated(("1/2", 0, 3))
    assert quartic_pieces(union) == 1 and [e.convexity for e in union.edges].count("reentrant") == 2
