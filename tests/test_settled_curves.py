"""Strips of which the exact path decides some pairs of pieces: parallel rulings, crossings and touches at knots."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc
from amount import amount
from firstcontact.curves.certified import certified_curve
from firstcontact.curves.certified.open_places import without
from firstcontact.curves.certified.settled import Settled

TOLERANCE = 1e-3
strip = fc.RuledSurface.from_nurbs


def uniform(grid, degree: int):
    n = len(grid) - degree
    return strip(grid, [0] * (degree + 1) + list(range(1, n)) + [n] * (degree + 1))


def extruded(heights, degree: int = 3, end: int = 3):
    """Over x = 0, 1, 2, ..., along y."""
    return uniform([[(k, y, F(h, 8)) for y in (-1, end)] for k, h in enumerate(heights)], degree)


def sections_cross(p, q) -> np.ndarray:
    """The x at which the cross-sections of two surfaces along y cross, by signs on a grid."""

    def heights(surface, x):
        points = np.concatenate([a.points(np.linspace(*map(float, a.u), 400), 0.0) for a in surface.pieces])
        return np.interp(x, points[:, 0], points[:, 2], np.nan, np.nan)

    x = np.linspace(-2, 12, 7001)
    gap = heights(p, x) - heights(q, x)
    return x[:-1][gap[:-1] * gap[1:] < 0]


SHEET = strip(
    [[(x, y, z - F(14, 5)) for y in (-2, 2)] for x, z in ((-3, 3), (-2, 4), (-1, 2), (1, 4), (2, 2), (3, 3))],
    [0, 0, 0, 1, 2, 3, 4, 4, 4],
)
VAULT = strip([[(x, y, z) for y in (-4, 4)] for x, z in ((-1, 0), (0, F(4, 3)), (1, 0))], None,
              [[1, 1], [F(4, 5), F(4, 5)], [1, 1]])  # fmt: skip


@pytest.mark.parametrize(
    "p, q",
    [(SHEET, VAULT), (extruded([1, 5, -3, 4, 0, -2, 6]), extruded([2, -4, 3, 1, -1, 4, -5], 2, 4))],
    ids=["sheet and vault", "splines"],
)
def test_strips_of_parallel_rulings_share_rulings(p, q):
    found = fc.intersection_curve(p, q)
    crossings = sections_cross(p, q)
    assert len(crossings) and not found.branches and not found.open_places and not found.two_dimensional
    lines = found.overlap_lines[np.argsort(found.overlap_lines[:, 0, 0])]
    assert lines[:, 0, 0] == pytest.approx(crossings, abs=3e-3) and (lines[:, 0, [0, 2]] == lines[:, 1, [0, 2]]).all()
    low, high = max(x.bounds()[0][1] for x in (p, q)), min(x.bounds()[1][1] for x in (p, q))
    assert np.sort(lines[:, :, 1], axis=1) == pytest.approx(np.tile([low, high], (len(lines), 1)))
    assert found.stats.node_visits < 100  # nothing is looked for where delta vanishes all over
    assert certified_curve.certified_curve(p, q, 1e-6, settles=False)["open_places"]


def test_pieces_of_parallel_rulings_beside_others():
    """One strip is extruded, the other only as far as its middle."""
    heights, other = [1, 5, -3, 4, 0, -2, 6, 1], [1, 5, -3, 4, 0, 5, -6, 3]
    grid = [[(k, -1, F(a, 8)), (k, 3, F(b, 8))] for k, (a, b) in enumerate(zip(heights, other, strict=True))]
    p, q = uniform(grid, 3), extruded([2, -4, 3, 1, -1, 4, -5, 3])
    found = fc.intersection_curve(p, q, tolerance=TOLERANCE)
    assert not found.open_places
    parts = [fc.intersection_curve(a, b, tolerance=TOLERANCE, method="algebraic") for a in p.pieces for b in q.pieces]
    lines = [line for part in parts for line in part.overlap_lines.tolist()]
    assert len(lines) == 3 and sorted(found.overlap_lines.tolist()) == sorted(lines)
    length = sum(branch.length for part in parts for branch in part.branches)
    assert sum(branch.length for branch in found.branches) == pytest.approx(length, rel=1e-4)


def test_other_surfaces_whose_rulings_all_meet():
    cones = [uniform([[(0, 0, -5), (k - 3, F(h, 4), 2)] for k, h in enumerate(x)], 2)
             for x in ([1, -6, 4, 0, 5, -3, 1], [3, 2, -5, 4, 0, 3, 4])]  # fmt: skip
    found = fc.intersection_curve(*cones)
    assert found.isolated_points.tolist() == [[0, 0, -5]] and len(found.overlap_lines) and not found.open_places
    assert (found.overlap_lines == [0, 0, -5]).all(2).any(1).all()
    flat = extruded([0] * 6, 2)
    moved = fc.intersection_curve(flat, flat.translated((1, F(1, 2), 0)))
    assert moved.two_dimensional and not len(moved.overlap_lines) and not moved.open_places
    wave = extruded([1, 5, -3, 4, 0], 2)
    finer = strip([[(x, y, z) for y in (-1, 3)] for x, z in ((0, F(1, 8)), (F(1, 2), F(3, 8)), (F(5, 4), F(3, 8)),
                   (2, F(-3, 8)), (3, F(1, 2)), (4, 0))], [0, 0, 0, F(1, 2), 1, 2, 3, 3, 3])  # fmt: skip
    same = fc.intersection_curve(wave, finer)  # one knot more
    assert same.two_dimensional and not len(same.overlap_lines) and not same.open_places and not same.branches


SQUARE = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)]


def pipe(radius, axis: int, at=(0, 0), turn=(1, 0)):
    """A full cylinder of four pieces; turn: cosine and sine of the place of its first knot."""
    (c, s), (x0, y0) = turn, at
    section = [(radius * (c * x - s * y) + x0, radius * (s * x + c * y) + y0) for x, y in SQUARE]
    grid = [[(x, y, z) if axis == 2 else (z, x, y) for z in (-2, 2)] for x, y in section]
    return strip(grid, [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4], [[2 ** (k // 2)] * 2 for k in range(9)])


@pytest.mark.share(2)
@pytest.mark.parametrize("turn", [(1, 0), (F(3, 5), F(4, 5))], ids=["at knots", "between knots"])
@pytest.mark.parametrize("other", [(1, 0), (F(5, 13), F(12, 13))], ids=["at knots", "between knots"])
def test_crossings_and_touches_are_decided(turn, other):
    found = fc.intersection_curve(pipe(1, 2, turn=turn), pipe(1, 0, turn=other), tolerance=TOLERANCE)
    assert not found.open_places and found.graph.components == 1
    assert {end.kind for branch in found.branches for end in branch.ends} == {"node"}
    assert [branch.length for branch in found.branches] == pytest.approx([3.82] * 4, abs=1e-2)
    assert sorted(np.round(x.point, 12).tolist() for x in found.singular_points) == [[0, -1, 0], [0, 1, 0]]
    assert sorted(node.kind for node in found.graph.nodes) == ["node", "node"] and len(found.graph.edges) == 4
    found = fc.intersection_curve(pipe(1, 2, turn=turn), pipe(F(1, 2), 0, (F(1, 2), 0), other), tolerance=TOLERANCE)
    assert len(found.branches) == 2 and not found.open_places
    assert [x.point.tolist() for x in found.singular_points] == [pytest.approx([0, 1, 0], abs=1e-12)]
    found = fc.intersection_curve(pipe(1, 2, turn=turn), pipe(1, 0, (2, 0), other))
    assert not found.branches and not found.open_places
    assert found.isolated_points == pytest.approx(np.array([[0, 1, 0]]), abs=1e-12)


def test_a_knots_ruling_on_the_other_surface_is_one_branch():
    tent = strip([[(0, y, 0) for y in (-1, 1)], [(1, y, 1 + y) for y in (-1, 1)], [(2, y, 0) for y in (-1, 1)]],
                 [0, 0, 1, 2, 2])  # fmt: skip
    leaning = fc.RuledSurface("(0, 4*u - 2, 4*u - 1)", "(2, 4*u - 2, 4*u - 1)")
    found = fc.intersection_curve(tent, leaning, tolerance=TOLERANCE)
    assert not found.open_places
    ridge = [x for x in found.branches if (np.abs(x.points[:, 0] - 1) < 1e-12).all()]
    assert len(ridge) == 1 and ridge[0].length == pytest.approx(8**0.5)


def test_two_crossings_next_to_each_other_at_a_border():
    """Delta vanishes at u = 7/5 and u = 3/2 on the border v = 0: the latter is where a line is halved."""
    found = fc.intersection_curve(*waves(np.random.default_rng(39)), method="certified", tolerance=1e-4)
    (branch,) = (x for x in found.branches if x.ends[0].on == x.ends[1].on == ("v=0",))
    assert sorted(end.parameters[0] for end in branch.ends) == pytest.approx([1.4, 1.5])


def waves(rng):
    """Two quadratic strips of three pieces that cross."""
    surfaces = []
    for along in (0, 1):
        grid = [[[0, 0, F(int(rng.integers(-8, 9)), 8)] for _ in range(2)] for _ in range(5)]
        for k, row in enumerate(grid):
            for point, end in zip(row, (-1, 5), strict=True):
                point[along], point[1 - along] = k, end
        surfaces.append(uniform(grid, 2))
    return surfaces


@pytest.mark.thorough
def test_exact_and_certified_pieces_join(monkeypatch):
    """Some pairs of pieces, at random, are taken from the exact path though nothing is open there."""
    rng, made, strands = np.random.default_rng(5), Settled.__init__, certified_curve._strands

    def settle_some(self, *args):
        made(self, *args)
        self.settle([(i, j) for i in range(3) for j in range(3) if rng.random() < 0.5])

    def without_them(solved, settled, settles):
        return strands(without(solved, settled), settled, settles)

    seen = 0
    for _ in range(amount(100, 6)):
        p, q = waves(rng)
        plain = fc.IntersectionCurve(**certified_curve.certified_curve(p, q, TOLERANCE, settles=False))
        with monkeypatch.context() as patch:
            patch.setattr(Settled, "__init__", settle_some)
            patch.setattr(certified_curve, "_strands", without_them)
            mixed = fc.intersection_curve(p, q, tolerance=TOLERANCE)
        assert not mixed.open_places
        if plain.open_places:
            continue
        seen += len(plain.branches)
        assert sorted(x.closed for x in plain.branches) == sorted(x.closed for x in mixed.branches)
        assert plain.graph.components == mixed.graph.components
        lengths = [sorted(x.length for x in curve.branches) for curve in (plain, mixed)]
        assert lengths[0] == pytest.approx(lengths[1], rel=1e-3)
    assert seen > amount(100, 6)
