"""The paper's structure of levels: its plan, what its levels hold, threads, and growth."""

from __future__ import annotations

import numpy as np
import pytest

import firstcontact as fc
from agreement import same_answer
from amount import amount
from firstcontact.contact.polyhedra.problems.composed_problem import Frame, plan_of, rotation_groups, translation_groups
from firstcontact.search.levels.composed import FORM, NEXT, WAY
from firstcontact.search.lifted.lifted_elements import edges_of
from firstcontact.search.trees.frame import tree_of

ENCOUNTERS = [fc.examples.woven_rods, fc.examples.layered_reguli]


def group_of(encounter, tangent=0.2):
    a, b = tree_of(encounter.a), tree_of(encounter.b)
    frame = Frame(b.xyz.reshape(-1, 3).mean(axis=0), 4.0, a.error, b.error)
    if isinstance(encounter.motion, fc.Translation):
        v = np.array(encounter.motion.vector, float)
        return translation_groups(edges_of(a), edges_of(b), frame, v, lambda: 1.0)[0]
    (group,) = rotation_groups(edges_of(a), edges_of(b), frame, lambda arc: tangent)
    return group


@pytest.mark.parametrize(("turning", "conjunctions"), [(False, 2), (True, 72)])
def test_a_plan_holds_every_conjunction_once(turning, conjunctions):
    group = group_of(fc.examples.woven_rods(4, turning=turning))
    found = group.conjunctions(slice(0, 4), 0)
    plan = plan_of(found, group.resting.names)
    paths = []

    def follow(step, before):
        here = [*before, (plan.steps[step, FORM], plan.steps[step, WAY])]
        after = range(*plan.steps[step, NEXT : NEXT + 2])
        if not after:
            paths.append(tuple(here))
        for s in after:
            follow(s, here)

    for step in range(plan.roots):
        follow(step, [])
    assert len(found) == conjunctions and len(paths) == len(set(paths))
    # strict and closed conjuncts are one step: some conjunctions of a rotation become the same
    assert {len(p) for p in paths} == {len(x) for x in found} and len(paths) <= conjunctions


@pytest.mark.parametrize("turning", [False, True], ids=["translation", "rotation"])
def test_levels_hold_their_edges(turning):
    """Every tree below a node holds the edges of that node and no others."""
    encounter = fc.examples.woven_rods(100, turning=turning, seed=2)
    group = group_of(encounter)
    resting = group.resting
    resting.begin(group.conjunctions(slice(0, 1), 0))
    first = int(resting.tops[resting.tops >= 0][0])
    node = int(resting.levels.nodes[first, 2])
    for feature in range(len(resting.names)):
        resting.add_below(node, feature)
        before = resting.levels.counts.copy()
        resting.add_below(node, feature)
        assert np.array_equal(before, resting.levels.counts)
    levels = resting.levels

    def edges(k):
        return sorted(levels.ids[levels.nodes[k, 0] : levels.nodes[k, 1]].tolist())

    assert edges(first) == list(range(100))
    for root in levels.below[node]:
        assert edges(int(root)) == edges(node)
        left, right = levels.nodes[root, 2:]
        assert sorted(edges(left) + edges(right)) == edges(node)


@pytest.mark.share(2)
@pytest.mark.parametrize("make", ENCOUNTERS)
@pytest.mark.parametrize("turning", [False, True], ids=["translation", "rotation"])
def test_as_many_threads_as_one_likes(make, turning):
    """Answers and work are the same, bit for bit."""
    scene = make(150, turning=turning, seed=4)
    boxes = fc.first_contact(scene.moving, scene.resting, engine="boxes")
    hits = [fc.first_contact(scene.moving, scene.resting, engine="composed", threads=k) for k in (1, 2, 3, 7)]
    assert all(same_answer(hit, boxes) for hit in hits)
    assert len({(h.stats.node_visits, h.stats.pair_tests, h.point.tobytes(), h.normal.tobytes()) for h in hits}) == 1


def test_threads_are_a_positive_number():
    scene = fc.examples.woven_rods(3)
    with pytest.raises(fc.InputError, match="threads"):
        fc.first_contact(scene.moving, scene.resting, threads=0)


@pytest.mark.parametrize("turning", [False, True], ids=["translation", "rotation"])
def test_layers_are_less_work_than_all_pairs(turning):
    n = amount(1200)
    scene = fc.examples.layered_reguli(n, turning=turning)
    hit = fc.first_contact(scene.moving, scene.resting, engine="composed")
    assert hit.stats.engine == "composed" and 5 * hit.stats.pair_tests < n * n
    assert same_answer(hit, fc.first_contact(scene.moving, scene.resting, engine="lifted"))


def test_other_motions_are_refused():
    scene = fc.examples.woven_rods(3)
    with pytest.raises(fc.UnsupportedPair, match="composed"):
        fc.first_contact(scene.a.moving(fc.Screw((0, 0, 1), degrees=9, advance=1)), scene.b, engine="composed")
