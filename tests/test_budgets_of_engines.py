"""Budgets of meshes are kept by every engine, to the size of one step."""

import numpy as np
import pytest
import trimesh

import firstcontact as fc

STEP = 64
"""Pair tests that an engine makes without looking up."""
SHIFT, TURN = fc.Translation(("1/10", "1/7", -9)), fc.Rotation((1, 0, 0), (0, 4, 2), degrees=90)


def ball(level: int) -> fc.Polyhedron:
    return fc.Polyhedron.from_trimesh(trimesh.creation.icosphere(level))


def rods(count: int) -> fc.Polyhedron:
    rng = np.random.default_rng(count)
    middles, ways = rng.uniform(-1, 1, (count, 3)), rng.normal(size=(count, 3))
    ends = np.stack([middles - ways, middles + ways], axis=1).reshape(-1, 3)
    return fc.Polyhedron(ends, [], edges=[[2 * k, 2 * k + 1] for k in range(count)])


def cloud(count: int) -> fc.Polyhedron:
    return fc.Polyhedron(np.random.default_rng(count).uniform(-1, 1, (count, 3)), [])


PAIRS = {"balls": (ball(2), ball(3)), "rods": (rods(500), rods(800)), "cloud": (ball(3), cloud(600))}


@pytest.mark.parametrize("motion", [SHIFT, TURN], ids=["shift", "turn"])
@pytest.mark.parametrize("engine", ["auto", "boxes", "lifted", "composed", "sweep"])
@pytest.mark.parametrize("pair", PAIRS)
def test_no_engine_does_much_more_than_it_may(pair, engine, motion):
    a, b = PAIRS[pair]
    moving = a.translated((0.3, 0.2, 5)).moving(motion)
    whole = fc.first_contact(moving, b, engine=engine)
    for budget in (0, 30, 100, 1000, 10_000):
        hit = fc.first_contact(moving, b, engine=engine, budget=budget)
        assert hit.stats.node_visits + hit.stats.pair_tests <= 1.2 * budget + STEP, budget
        if hit.status is fc.Status.UNDECIDED:
            assert hit.reason == "budget" and hit.free_until <= (whole.time or 1.0)
        else:
            assert (hit.status, hit.time) == (whole.status, whole.time)
