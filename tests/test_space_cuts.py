"""Edges cut by the space they pass through: same answers however eagerly, and n^1.5 on generic rods."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

import firstcontact as fc
import naive
from agreement import assert_same_first_contact, same_answer, small_scenes
from amount import amount
from firstcontact import examples
from firstcontact.contact.polyhedra.problems import lifted_problem
from firstcontact.search.lifted.halving import room_for
from generators import FAMILIES, Scene, to_tangent
from test_vectors import ask, expected_time
from vectors import VECTORS

MOTIONS = pytest.mark.parametrize("turning", [False, True], ids=["translation", "rotation"])


@pytest.fixture
def eager(monkeypatch):
    """Space is cut down to single edges, however few there are, and lists begin with little room."""

    def room(m, n):
        full = room_for(m, n)
        size = 2 * (m + n)
        return full._replace(arena=full.arena[:size].copy(), ends=full.ends[:size].copy(), pays=0, worth=1)

    monkeypatch.setattr(lifted_problem, "room_for", room)


@pytest.mark.share(2)
@MOTIONS
def test_small_scenes_by_space(turning, eager):
    scenes = small_scenes(80_000, amount(120), turning)
    seen = Counter(assert_same_first_contact(scene, engine="lifted") for scene in scenes)
    assert len(seen) == 3, seen


@pytest.mark.share(2)
@pytest.mark.parametrize("family", FAMILIES)
def test_near_miss_families_by_space(family, eager):
    a, b = FAMILIES[family](12, 6)
    assert assert_same_first_contact(Scene(a, b, translation=(0, 0, 1)), engine="lifted") == naive.CONTACT
    scene = Scene(to_tangent(a), to_tangent(b), rotation={"axis": (0, 0, 1), "turns": 1})
    assert assert_same_first_contact(scene, engine="lifted") == naive.CONTACT


def test_known_first_contacts_by_space(eager):
    for case in VECTORS:
        hit = ask(case, False, "lifted")
        assert (hit.time is not None) == case.expected["hit"], case.id
        assert hit.time is None or hit.time == pytest.approx(expected_time(case), rel=1e-14, abs=1e-300), case.id


@MOTIONS
def test_rods_that_meet_late_where_space_is_cut(turning, monkeypatch):
    """Space is halved at x = 0, which that of a has to pass, and at z = 0, where that of b lies."""
    monkeypatch.setattr(lifted_problem, "room_for", lambda m, n: room_for(m, n)._replace(pays=0, worth=500))
    motion = fc.Rotation((0, 0, 1), (0, 1, 0), radians="1/6") if turning else fc.Translation((0.3, 0.1, 0))
    pose, place = motion(0.9), np.array((0.07, 0.1, 0.0))
    for seed in range(amount(60)):
        rng = np.random.default_rng(seed)
        x, y = rng.uniform(-0.85, 0.85, (2, 32, 3))
        d, e = rng.normal(size=(2, 32, 3))
        x[rng.integers(32)], y[0], e[0, 2] = (place - pose[:3, 3]) @ pose[:3, :3], place, 0.0
        y[1], e[1], y[2], e[2] = -0.96, 1.0, 0.96, 1.0
        a, b = (rods(middles, ways) for middles, ways in ((x, d), (y, e)))
        hit = fc.first_contact(a.moving(motion), b, (0, 1), engine="lifted")
        assert same_answer(hit, fc.first_contact(a.moving(motion), b, (0, 1), engine="boxes")), seed


@MOTIONS
def test_generic_rods_are_cut_by_space(turning):
    """Work grows with n^1.5, where boxes look at n^2 pairs; at 1000 rods also boxes cut in 64 pieces do more."""
    work = []
    for n in (250, 1000):
        scene = examples.woven_rods(n, turning=turning)
        hit = fc.first_contact(scene.moving, scene.resting, engine="lifted")
        work.append(hit.stats.node_visits + hit.stats.pair_tests)
        if n == 250:
            assert same_answer(hit, fc.first_contact(scene.moving, scene.resting, engine="boxes"))
    assert work[1] < 4**1.65 * work[0] and work[1] < 300_000


@MOTIONS
def test_bundles_that_lie_apart(turning):
    """Space tells eight bundles apart; within each, where all pairs are near, lines do."""
    bundles = [examples.layered_reguli(100, turning=turning, seed=seed) for seed in range(8)]
    shifts = [(0.0, 0.0, 8.0 * k) if turning else (8.0 * k, 0.0, 0.0) for k in range(8)]
    a, b = (joined([getattr(scene, name) for scene in bundles], shifts) for name in "ab")
    lifted, boxes = (
        fc.first_contact(a.moving(bundles[0].motion), b, engine=engine) for engine in ("lifted", "boxes")
    )
    assert same_answer(lifted, boxes)
    assert 2 * lifted.stats.node_visits < boxes.stats.node_visits
    assert 3 * lifted.stats.pair_tests < boxes.stats.pair_tests


def joined(bodies, shifts):
    """Edge sets as one."""
    first = np.cumsum([0] + [len(body.vertices) for body in bodies])
    edges = np.concatenate([body.edges + k for body, k in zip(bodies, first, strict=False)])
    vertices = np.concatenate([body.vertices + shift for body, shift in zip(bodies, shifts, strict=True)])
    return fc.Polyhedron(vertices, [], edges=edges)


def rods(middles, ways):
    d = 0.05 * ways / np.linalg.norm(ways, axis=1)[:, None]
    ends = np.stack([middles - d, middles + d], axis=1)
    return fc.Polyhedron(ends.reshape(-1, 3), [], edges=np.arange(2 * len(d)).reshape(-1, 2))
