"""The engine that cuts space and time: same answers, n^1.5 on generic rods, and boxes that lose no triangle."""

from __future__ import annotations

from collections import Counter
from functools import partial

import numpy as np
import pytest

import firstcontact as fc
import naive
from agreement import assert_same_first_contact, question, same_answer, small_scenes
from amount import amount
from firstcontact import examples
from firstcontact.kernels.boxes import clip_to_box, triangle_meets_box
from firstcontact.search import cell_problem
from firstcontact.search.frame import tree_of
from generators import FAMILIES, Scene, lattice_scene, to_tangent
from test_vectors import ask, expected_time
from vectors import VECTORS

MOTIONS = pytest.mark.parametrize("rotating", [False, True], ids=["translation", "rotation"])


@pytest.fixture
def eager(monkeypatch):
    """Cells are halved down to single parts, however few there are, and begin with little room."""
    monkeypatch.setattr(cell_problem, "Cells", partial(cell_problem.Cells, pays=1))


@MOTIONS
def test_small_scenes_by_cells(rotating, eager):
    scenes = small_scenes(80_000, amount(120), rotating)
    seen = Counter(assert_same_first_contact(scene, engine="cells") for scene in scenes)
    assert len(seen) == 3, seen


def test_a_triangle_in_many_parts_is_tested_once():
    """A tree cuts these four triangles into 256 parts; 9 pairs of edges, 6 of vertices and 6 at the start for each."""
    scene = lattice_scene(80_015, False)
    moving, resting, span = question(scene)
    assert len(tree_of(resting).ids) > 50 * len(resting.triangles)
    hit = fc.first_contact(moving, resting, span, engine="cells")
    assert hit.stats.pair_tests <= 21 * len(scene.a.f) * len(scene.b.f)
    assert same_answer(hit, fc.first_contact(moving, resting, span, engine="boxes"))


def test_cells_refuse_other_motions():
    rod = fc.Polyhedron([[0, 0, 0], [1, 0, 0]], [], edges=[[0, 1]])
    with pytest.raises(fc.UnsupportedPair, match="cells"):
        fc.first_contact(rod.moving(fc.Screw((0, 0, 1), degrees=90, advance=1)), rod, engine="cells")


@pytest.mark.parametrize("family", FAMILIES)
def test_near_miss_families_by_cells(family, eager):
    a, b = FAMILIES[family](12, 6)
    assert assert_same_first_contact(Scene(a, b, translation=(0, 0, 1)), engine="cells") == naive.CONTACT
    scene = Scene(to_tangent(a), to_tangent(b), rotation={"axis": (0, 0, 1), "turns": 1})
    assert assert_same_first_contact(scene, engine="cells") == naive.CONTACT


def test_known_first_contacts_by_cells(eager):
    for case in VECTORS:
        hit = ask(case, False, "cells")
        assert (hit.time is not None) == case.expected["hit"], case.id
        assert hit.time is None or hit.time == pytest.approx(expected_time(case), rel=1e-14, abs=1e-300), case.id


@pytest.mark.parametrize("turning", [False, True], ids=["translation", "rotation"])
@pytest.mark.parametrize("make", [examples.woven_rods, examples.slats_over_points], ids=["rods", "slats"])
def test_pair_tests_grow_slower_than_all_pairs(make, turning):
    tests = []
    for n in (250, 1000):
        scene = make(n, turning=turning)
        hit = fc.first_contact(scene.moving, scene.resting, engine="cells")
        tests.append(hit.stats.pair_tests)
        if n == 250:
            assert same_answer(hit, fc.first_contact(scene.moving, scene.resting, engine="boxes"))
    assert tests[1] < 4**1.65 * tests[0]


def test_solids_and_a_whole_turn_by_cells():
    for scene in (
        examples.layered_reguli(30, closed=True),
        examples.slats_over_points(60, closed=True, turning=True),
        examples.nested_hyperboloids(60),
        examples.nested_shells(300),
        examples.convex_pair(500),
    ):
        by_cells, by_boxes = (fc.first_contact(scene.moving, scene.resting, engine=e) for e in ("cells", "boxes"))
        assert same_answer(by_cells, by_boxes) and by_cells.stats.engine == "cells"


def test_a_budget_ends_cells_too():
    scene = examples.woven_rods(200)
    short = fc.first_contact(scene.moving, scene.resting, engine="cells", budget=500)
    full = fc.first_contact(scene.moving, scene.resting, engine="cells")
    assert (short.status, short.reason) == (fc.Status.UNDECIDED, "budget") and short.free_until <= full.time


def test_no_triangle_that_enters_a_box_is_lost():
    """Clipping finds what is in the box; thin triangles and touching boxes included."""
    random = np.random.default_rng(0)
    polygon, scratch = np.empty((12, 3)), np.empty((12, 3))
    inside = outside = 0
    for k in range(amount(6000)):
        xyz = random.integers(-4, 5, 9) / 4.0 if k % 2 else random.uniform(-1, 1, 9)
        if k % 3 == 0:
            xyz[6:] = xyz[3:6] + 1e-9 * random.uniform(-1, 1, 3)
        corner = random.integers(-4, 4, 3) / 4.0
        box = np.concatenate([corner, corner + random.integers(0, 4, 3) / 4.0])
        meets = triangle_meets_box(xyz, box, 0.0)
        if clip_to_box(xyz, box, polygon, scratch) > 0:
            inside += 1
            assert meets, (xyz, box)
        outside += not meets
    assert inside > 100 and outside > 100
