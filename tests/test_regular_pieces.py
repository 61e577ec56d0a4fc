"""Pieces of ruled surfaces that doubles tell to be regular, against normals from differences of exact points."""

from __future__ import annotations

from fractions import Fraction as F
from itertools import pairwise

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.curves.certified.chains import chains

SEED = 20261127
STEP = F(1, 2**30)


def blend(a: list[F], b: list[F], u: F) -> list[F]:
    return [(1 - u) * x + u * y for x, y in zip(a, b, strict=True)]


def point(rows: list[list[F]], weights: list[F], u: F) -> list[F]:
    """De Casteljau on weighted points, exactly."""
    curve = [[*(w * x for x in p), w] for p, w in zip(rows, weights, strict=True)]
    while len(curve) > 1:
        curve = [blend(a, b, u) for a, b in pairwise(curve)]
    return [x / curve[0][3] for x in curve[0][:3]]


def normals(grid: list, weights: list) -> np.ndarray:
    """(m, 3) of directions across the surface at many places, each from exact points a step apart."""
    sides = [([row[k] for row in grid], [row[k] for row in weights]) for k in (0, 1)]
    found = []
    for i in range(1, 32):
        at = [[point(*side, F(i, 32) + d) for side in sides] for d in (F(0), STEP)]
        along = [b - a for a, b in zip(*at[0], strict=True)]
        for s in (F(0), F(1, 3), F(1)):
            here, there = (blend(*ends, s) for ends in at)
            ahead = [(y - x) / STEP for x, y in zip(here, there, strict=True)]
            found.append(np.cross([float(x) for x in ahead], [float(x) for x in along]))
    return np.array(found)


def are_on_one_side(vectors: np.ndarray) -> bool:
    """Whether a plane has them all on one side: a perceptron finds one where there is room."""
    unit = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    way = unit.mean(axis=0)
    for _ in range(10_000):
        worst = unit[(unit @ way).argmin()]
        if worst @ way > 0.0:
            return True
        way = way + worst
    return False


def test_regular_pieces_have_normals_on_one_side():
    print("seed", SEED)
    rng, regular = np.random.default_rng(SEED), 0
    for _ in range(200):
        n = int(rng.integers(2, 6))
        grid = [[[F(int(x)) for x in p] for p in row] for row in rng.integers(-9, 10, (n, 2, 3))]
        weights = [[F(int(x)) for x in row] for row in rng.integers(1, 5, (n, 2))]
        if n > 2:  # most of such are singular somewhere: calmer ones, too
            grid = [[[x + 8 * i * (k == 0) for k, x in enumerate(p)] for p in row] for i, row in enumerate(grid)]
        (chain,) = chains(fc.RuledSurface.from_nurbs(grid, weights=weights))
        if len(chain.irregular):
            assert not chain.is_regular(0)
            continue
        regular += 1
        found = normals(grid, weights)
        assert are_on_one_side(found)
    assert regular >= 20


@pytest.mark.parametrize("surface", (
    fc.RuledSurface("(0, 0, 0)", "(1, u, u**2)"),  # a cone with its apex
    fc.RuledSurface("(u, u**2, u**3)", "(u + 1, u**2 + 2*u, u**3 + 3*u**2)"),  # tangents of a curve
    fc.RuledSurface("(u**2, 0, 0)", "(u**2, 1, u**2)", u=(-1, 1)),  # it turns back at u = 0
    fc.RuledSurface("(u, u**2, 0)", "(-u, u**2, 1)", u=(-1, 1)),  # a pinch point
), ids=("apex", "edge of regression", "turn", "pinch point"))  # fmt: skip
def test_pieces_with_singular_points_are_not_regular(surface):
    (chain,) = chains(surface)
    assert not chain.is_regular(0)
