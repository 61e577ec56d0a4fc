"""What Boolean combinations make of signs that are open, against all patterns, and where there are too many of them."""

from __future__ import annotations

import random
from fractions import Fraction as F
from itertools import product

import firstcontact as fc
from firstcontact.body.solid.csg import And, Leaf, Not, Or, Tree, borders, conjunction, inside, outcomes


def tree_of(rng: random.Random, surfaces: int, depth: int) -> Tree:
    if depth == 0 or rng.random() < 0.15:
        return Leaf(rng.randrange(surfaces))
    if rng.random() < 0.2:
        return Not(tree_of(rng, surfaces, depth - 1))
    kind = And if rng.random() < 0.5 else Or
    return kind(tree_of(rng, surfaces, depth - 1), tree_of(rng, surfaces, depth - 1))


def test_against_all_patterns():
    rng = random.Random(1)
    told = set()
    for _ in range(1500):
        n = rng.randint(1, 6)
        tree, signs = tree_of(rng, n, rng.randint(0, 5)), [rng.choice((-1, 0, 0, 0, 1)) for _ in range(n)]
        patterns = list(product(*([True, False] if sign == 0 else [sign < 0] for sign in signs)))
        assert outcomes(tree, signs) == {inside(tree, list(x)) for x in patterns}
        k, negative = rng.randrange(n), rng.random() < 0.5
        one, other = ([[*x[:k], side, *x[k + 1 :]] for x in patterns] for side in (negative, not negative))
        expected = any(inside(tree, x) and not inside(tree, y) for x, y in zip(one, other, strict=True))
        assert borders(tree, signs, k, 1 if negative else -1) == expected
        told.add((len(outcomes(tree, signs)), expected))
    assert told == {(1, True), (1, False), (2, True), (2, False)}


def test_many_open_signs():
    """Two to the power of sixty patterns."""
    tree = conjunction([Leaf(i) for i in range(60)])
    assert outcomes(tree, [0] * 60) == {True, False} and borders(tree, [0] * 60, 7, 1)
    assert outcomes(tree, [0] * 59 + [1]) == {False} and not borders(tree, [0] * 60, 7, -1)


def test_a_tiny_ellipsoid_in_a_corner_of_many_triangles():
    """Their sides passed the point that was asked: all patterns of the signs took minutes, exactly."""
    grain = fc.ellipsoid((F(5, 589824), F(1, 65536), F(5, 589824))).transformed([
        [F(-808, 1989), F(1, 9), F(-1804, 1989), F(-1, 589824)], [F(-43, 117), F(8, 9), F(32, 117), F(-1, 73728)],
        [F(128, 153), F(4, 9), F(-49, 153), F(-1, 147456)], [0, 0, 0, 1],
    ])  # fmt: skip
    ring = [(0, 0), (12, 0), (12, 0.75), (4, 0.75), (4, 1.25), (0, 1.25)]
    walls = [[k, (k + 1) % 6, 6 + (k + 1) % 6, 6 + k] for k in range(6)]
    angle = fc.Polyhedron([(*p, z) for z in (0, 3) for p in ring], [[5, 4, 3, 2, 1, 0], [*range(6, 12)], *walls])
    angle = angle.transformed([
        [F(-334, 459), F(-89, 459), F(302, 459), F(-734, 153)], [F(-314, 459), F(62, 459), F(-329, 459), F(599, 153)],
        [F(23, 459), F(-446, 459), F(-106, 459), F(-326, 153)], [0, 0, 0, 1],
    ])  # fmt: skip
    way = fc.RationalMotion([
        [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
        [[0, 2, 0, 2], [-2, 0, -2, -8], [0, 2, 0, 2], [0, 0, 0, 0]],
        [[0, 0, -2, -8], [0, -2, 0, -4], [-2, 0, 0, -8], [0, 0, 0, 2]],
    ])  # fmt: skip
    hit = fc.first_contact(grain, angle.moving(way), (F(3894, 8192), 1), exact=True)
    assert hit.time_exact == F(3, 4) and (hit.element_a.kind, hit.element_b.kind) == ("face", "vertex")
