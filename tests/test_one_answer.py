"""One answer: the same elements, pairs and point from every engine, from either order of the bodies, in any unit."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction as F

import numpy as np
import pytest

import firstcontact as fc
import naive
from agreement import question, reference
from amount import amount
from generators import lattice_scene

MOTIONS = pytest.mark.parametrize("rotating", [False, True], ids=["translation", "rotation"])
ENGINES = ("boxes", "lifted", "composed", "sweep", "auto")


def element(x):
    return None if x is None else (x.kind, x.index)


def told(hit, swapped: bool = False):
    """What a result says of the contact, as of bodies in the order (a, b)."""
    pairs = [(hit.element_a, hit.element_b), *((p.element_a, p.element_b) for p in hit.others)]
    pairs = [(element(y), element(x)) if swapped else (element(x), element(y)) for x, y in pairs]
    return hit.status, hit.time, hit.initial, hit.multiplicity, pairs


@pytest.mark.share(2)
@MOTIONS
def test_engines_and_orders(rotating):
    seen = Counter()
    for seed in range(80_000, 80_000 + amount(150, 3)):
        a, b, span = question(lattice_scene(seed, rotating))
        hit = fc.first_contact(a, b, span, engine="boxes")
        seen[hit.status] += 1
        other = fc.first_contact(a, b, span, engine=ENGINES[1 + seed % 4])
        assert told(other) == told(hit), seed
        swapped = fc.first_contact(b, a, span, engine=ENGINES[seed % 5])
        assert told(swapped, True) == told(hit), seed
        if hit.point is not None:
            assert np.array_equal(other.point, hit.point), seed
            assert np.allclose(swapped.point, hit.point, atol=1e-12), seed
        assert (hit.normal is None) is (other.normal is None) is (swapped.normal is None), seed
    assert len(seen) == 3


def test_a_start_counts_all_pairs():
    """One box stuck through the other, and two that are the same: all edges through faces, by every engine."""
    box = fc.examples.box((2, 2, 2))
    for other in (fc.examples.box((1, 1, 6)), box.named("copy"), box.translated((1, 1, 1))):
        motion = fc.Translation((1, 2, 3))
        hits = [fc.first_contact(box.moving(motion), other, engine=engine) for engine in ENGINES]
        back = fc.first_contact(other, box.moving(motion))
        assert all(told(hit) == told(hits[0]) for hit in hits) and told(back, True) == told(hits[0])
        listed = fc.contact_pairs(box.moving(motion), other, (0, 0)).piercing
        found = {(p.element_a, p.element_b) for p in listed}
        assert hits[0].multiplicity <= len(found) and (hits[0].element_a, hits[0].element_b) in found


@pytest.mark.parametrize("k", [-1000, -520, -490, -300, 0, 140])
def test_diagonals_of_flat_faces_are_told_in_any_unit(k):
    u = F(2) ** k
    lid = fc.examples.box((2, 2, 2)).translated((F(1, 2), F(1, 4), 4))
    base = fc.examples.box((2, 2, 2))
    unit = [[u if i == j < 3 else int(i == j) for j in range(4)] for i in range(4)]
    hit = fc.first_contact(lid.moving(fc.Translation((0, 0, -4))), base)
    same = fc.first_contact(lid.transformed(unit).moving(fc.Translation((0, 0, -4 * u))), base.transformed(unit))
    assert told(same) == told(hit)


@pytest.mark.share(2)
@MOTIONS
def test_what_a_budget_proves_free_is_free(rotating):
    """No contact is before `free_until`, at whatever step the work ends."""
    left = 0
    for seed in range(81_000, 81_000 + amount(90, 3)):
        scene = lattice_scene(seed, rotating)
        status, _, nearest = reference(naive.first_contact, scene)
        if status == naive.FREE:
            continue
        a, b, span = question(scene)
        for budget in (0, 1, 2, 3, 5, 8, 13, 21, 34, 55):
            hit = fc.first_contact(a, b, span, engine=ENGINES[(seed + budget) % 5], budget=budget)
            assert hit.status is fc.Status.UNDECIDED or hit.time == nearest, (seed, budget)
            assert hit.free_until <= nearest, (seed, budget)
            left += hit.status is fc.Status.UNDECIDED
    assert left > 20


def test_equal_boxes_on_different_trajectories_are_named_alike_in_either_order():
    """Their shapes and the texts of their motions are the same: all numbers of the motions tell which one leads."""
    box, upright = fc.examples.box((1, 1, 1)), [(1, 0, 0, 0)] * 2

    def way(start, end):
        return fc.Trajectory([0, 1], [(start, 0, 0), (end, "1/4", "1/8")], quat_wxyz=upright)

    a, b = box.moving(way(0, 2)), box.moving(way(5, 1))
    one, other = fc.first_contact(a, b), fc.first_contact(b, a)
    assert one.multiplicity > 1 and told(one) == told(other, swapped=True)
