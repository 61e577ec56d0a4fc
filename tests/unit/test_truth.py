"""What trees are for either sign of a few surfaces, all patterns at once, against one pattern after the other."""

import random
from itertools import product

import numpy as np
import pytest

from firstcontact.body.solid import truth
from firstcontact.body.solid.csg import And, Leaf, Not, Or, Tree, inside


def tree(rng: random.Random, depth: int, count: int) -> Tree:
    if depth == 0 or rng.random() < 0.1:
        return Leaf(rng.randrange(count))
    if rng.random() < 0.2:
        return Not(tree(rng, depth - 1, count))
    return rng.choice([And, Or])(tree(rng, depth - 1, count), tree(rng, depth - 1, count))


def outcomes(made: Tree, signs: list[int], fixed: dict[int, bool]) -> list[bool]:
    """Of all patterns that agree with the signs, but for the fixed ones."""
    sides = [[fixed[k]] if k in fixed else [True, False] if s == 0 else [s < 0] for k, s in enumerate(signs)]
    return [inside(made, negative) for negative in product(*sides)]


@pytest.mark.parametrize("seed", range(20))
def test_all_patterns_at_once(seed: int) -> None:
    rng = random.Random(seed)
    count = rng.randrange(1, 10)
    made = tree(rng, 4, count)
    signs = np.array([[rng.choice((-1, 0, 1)) for _ in range(count)] for _ in range(20)], np.int8)
    signs = signs[(signs == 0).sum(axis=1) <= truth.MOST]
    told = truth.deciding(made, signs)
    for row, opened, own in zip(signs.tolist(), truth.is_open(made, signs).tolist(), told.tolist(), strict=True):
        assert opened == (len(set(outcomes(made, row, {}))) == 2)
        for k, sign in enumerate(row):
            differs = outcomes(made, row, {k: True}) != outcomes(made, row, {k: False})
            assert own[k] == (sign == 0 and differs)
