"""Polygons whose corners lie on a line, to within roundings: their triangles are not flat."""

from __future__ import annotations

import math

import numpy as np
import pytest

import firstcontact as fc
from amount import amount


def ring(x, y, radius, n, phase=0.0):
    angles = [2 * math.pi * k / n + phase for k in range(n)]
    return [(x + radius * math.cos(t), y + radius * math.sin(t)) for t in angles]


def flattest(rings) -> float:
    """The least height of a triangle of the polygon, as a share of its longest side; the triangles fill it."""
    corners = np.array([(x, y, 0.0) for r in rings for x, y in r])
    ends = np.cumsum([0, *map(len, rings)])
    body = fc.Polyhedron(corners, [[list(range(i, j)) for i, j in zip(ends, ends[1:], strict=False)]])
    a, b, c = np.array(body.vertices)[np.array(body.triangles)].transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    shoelace = [abs(sum(p[0] * q[1] - q[0] * p[1] for p, q in zip(r, r[1:] + r[:1], strict=True))) for r in rings]
    assert areas.sum() == pytest.approx(shoelace[0] - sum(shoelace[1:]))
    longest = np.max([np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    return float((areas / longest**2).min())


def test_corners_of_two_holes_on_a_line():
    quarter = math.pi / 4
    holes = [ring(5, 5, 1, 4), ring(15, 5, 3, 4, quarter), ring(25, 5, 3, 4, quarter)]
    assert flattest([ring(15, 5, 60, 4), *holes]) > 1e-4


@pytest.mark.parametrize("block", range(amount(6)))
def test_rows_of_holes(block):
    rng = np.random.default_rng(block)
    for _ in range(60):
        n, count = int(rng.choice([4, 6, 8, 12])), int(rng.integers(1, 5))
        phases = [float(rng.choice([0, math.pi / n])) for _ in range(count)]
        holes = [ring(10 * k + 5, 5, float(rng.choice([1, 2, 3])), n, phases[k]) for k in range(count)]
        outer = [(0, 0), (10 * count, 0), (10 * count, 10), (0, 10)]
        assert flattest([outer if rng.random() < 0.5 else ring(5 * count, 5, 20 * count, n), *holes]) > 1e-9


def test_rings_that_cross_are_refused_as_before():
    corners = [(0, 0, 0), (2, 0, 0), (1, 0, 0), (2, 2, 0), (0, 2, 0)]
    for ring_ in ([0, 1, 2, 3, 1, 4], [0, 1, 0, 3, 4], [0, 3, 1, 4, 2]):
        with pytest.raises(fc.InputError):
            fc.Polyhedron(corners, [ring_])


def test_a_closed_surface_without_inner_points_is_no_convex_solid():
    """All times of contact of small convex parts are asked as solids: this one raised "solid is empty"."""
    corners, sides = [(0, 0, 3), (1, 0, 3), (0, 1, 3), (1, 1, 3)], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
    flat = fc.Polyhedron(corners, sides, solid=True).moving(fc.Screw((0, 0, 1), degrees=50, advance=-4))
    found = fc.contact_intervals(flat, fc.examples.box((2, 2, 2)))
    assert [(x.start, x.end) for x in found] == [(0.5, 1.0)]
