"""The plane sweep for vertices against facets: answers, the order of facets, work, and what it refuses."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

import firstcontact as fc
import generators as g
from agreement import assert_same_first_contact, question, same_answer, small_scenes
from amount import amount
from firstcontact.search.sweep.sheets import sheets_of
from firstcontact.search.sweep.sweep import (
    MARGIN,
    NONE,
    GroupCells,
    Order,
    Trees,
    cells_of,
    order_of,
    with_cell,
    without_cell,
)
from generators import Scene


def stack(n: int, seed: int = 0, crossing: bool = False):
    """Points below n wide parallel triangles, oblique, so that every box of one holds most points.

    crossing: they lean all ways instead.
    """
    rng = np.random.default_rng(seed)
    points = np.column_stack([rng.uniform(-1, 1, (n, 2)), rng.uniform(-2, -1, n)])
    ring = 6.0 * np.array([[1.0, 0.0], [-0.5, 0.75], [-0.5, -0.75]])
    shift = rng.uniform(-0.5, 0.5, (n, 1, 2))
    way = rng.uniform(0, 2 * np.pi, (n, 1)) if crossing else np.full((n, 1), 0.25)
    xy = ring[None] + shift
    z = np.cos(way) * xy[..., 0] + np.sin(way) * xy[..., 1] + (2.0 + np.arange(n) / n)[:, None]
    facets = g.on_grid(np.concatenate([xy, z[..., None]], axis=-1).reshape(-1, 3))
    faces = np.arange(3 * n, dtype=np.int32).reshape(-1, 3)
    return fc.Polyhedron(g.on_grid(points), []), fc.Polyhedron(facets, faces)


@pytest.mark.share(2)
@pytest.mark.parametrize("rotating", [False, True], ids=["translation", "rotation"])
def test_small_scenes(rotating):
    scenes = small_scenes(71_000, amount(150), rotating)
    seen = Counter(assert_same_first_contact(scene, engine="sweep") for scene in scenes)
    assert len(seen) == 3, seen


@pytest.mark.parametrize("crossing", [False, True], ids=["apart", "crossing"])
@pytest.mark.parametrize("back", [False, True], ids=["points move", "facets move"])
def test_stacks_of_facets(crossing, back):
    """Facets that cross have no order: the answer is the same, the work is not."""
    n = 200
    points, facets = stack(n, 3, crossing)
    moving, resting = (facets, points) if back else (points, facets)
    ask = moving.moving(fc.Translation((0.1, -0.05, -9 if back else 9))), resting
    boxes, lifted, *sweeps = (fc.first_contact(*ask, engine=e) for e in ("boxes", "lifted", "sweep"))
    sweeps += [fc.first_contact(*ask, engine="sweep", threads=k) for k in (2, 5)]
    assert boxes.status is fc.Status.CONTACT and same_answer(lifted, boxes)
    assert all(same_answer(x, boxes) and x.stats.engine == "sweep" for x in sweeps)
    assert len({(x.stats.node_visits, x.stats.pair_tests) for x in sweeps}) == 1


def test_work_grows_as_the_bound_says():
    """Few tests, some n^(3/2) log n visits; facets that cross are tested with all points below them."""
    n = 900
    points, facets = stack(n, 5)
    hit = fc.first_contact(points.moving(fc.Translation((0, 0, 9))), facets, engine="sweep")
    crossed = stack(n, 5, crossing=True)
    slow = fc.first_contact(crossed[0].moving(fc.Translation((0, 0, 9))), crossed[1], engine="sweep")
    assert hit.stats.pair_tests < n and hit.stats.node_visits < 5 * n**1.5 * np.log2(n)
    assert slow.stats.pair_tests > n * n / 2


@pytest.mark.parametrize("back", [False, True], ids=["points turn", "facets turn"])
@pytest.mark.parametrize("make", ["slats_over_points", "nested_shells", "tangent_plates"])
def test_turning_facets(make, back):
    """Through all angles; of tangent plates, which all cross, every one is tested."""
    n = 120
    scene = getattr(fc.examples, make)(n, **({} if make == "nested_shells" else {"turning": True}))
    motion = scene.motion
    ask = scene.moving, scene.resting
    if back:
        ask = scene.b.moving(fc.Rotation(motion.axis, motion.point, radians=-motion.radians)), scene.a
    boxes, *sweeps = (fc.first_contact(*ask, engine=e) for e in ("boxes", "sweep"))
    sweeps += [fc.first_contact(*ask, engine="sweep", threads=k) for k in (2, 5)]
    assert boxes.status is fc.Status.CONTACT
    assert all(same_answer(x, boxes) and x.stats.engine == "sweep" for x in sweeps)
    assert len({(x.stats.node_visits, x.stats.pair_tests) for x in sweeps}) == 1
    assert (sweeps[0].stats.pair_tests > n * n / 4) == (make == "tangent_plates")


def test_meshes_and_closed_solids():
    ball = fc.examples.noisy_sphere(2000)
    ask = (ball.moving(fc.Translation((0, 0, 3))), ball.translated((0.25, 0, 3)))
    assert same_answer(fc.first_contact(*ask, engine="sweep"), fc.first_contact(*ask, engine="boxes"))
    a, b = (g.rods(lines, 0.01, up) for lines, up in zip(g.reguli(20, 2.0**-10, 3), (False, True), strict=True))
    ask = question(Scene(a, b, translation=(0, 0, 1), solid=True))
    assert same_answer(fc.first_contact(*ask, engine="sweep"), fc.first_contact(*ask, engine="boxes"))


@pytest.mark.share(4)
@pytest.mark.parametrize("seed", range(4))
def test_trees_keep_their_order_and_older_trees_stay(seed):
    """Cells put in and taken out at random, in facets one above the other, against a sorted list."""
    rng = np.random.default_rng(seed)
    f = 40
    height = rng.permutation(f).astype(float)
    corners = np.array([[-1.0, -1.0, 0.0], [1.0, -0.5, 0.0], [0.0, 1.0, 0.0]])[None] + height[:, None, None] * [0, 0, 1]
    facets, x, arcs, planes, tolerances = cells_of(corners, 0.0)
    cells = GroupCells(facets, x, arcs)
    order = Order(planes, *order_of(cells, planes, tolerances))
    assert not order.loose.any()
    trees = Trees(*(np.empty(100_000, np.int32) for _ in range(3)), np.zeros(1, np.int64))
    waiting = np.empty(200, np.int32)

    def listed(root):
        if root == NONE:
            return []
        return [*listed(trees.left[root]), int(trees.cell[root]), *listed(trees.right[root])]

    root, held, older = NONE, set(), []
    for _ in range(300):
        cell = int(rng.integers(2 * f))
        if cell in held:
            root = without_cell(trees, order, facets, root, cell, waiting)
        else:
            root = with_cell(trees, order, facets, root, cell)
        held ^= {cell}
        older.append((root, sorted(held, key=lambda c: (height[facets[c]], c))))
    assert all(listed(tree) == cells_then for tree, cells_then in older)


def test_cells_reach_over_their_facets_and_order_knows_crossings():
    rng = np.random.default_rng(1)
    corners = rng.normal(size=(30, 3, 3))
    facets, x, arcs, planes, tolerances = cells_of(corners, 0.0)
    loose, precedes = order_of(GroupCells(facets, x, arcs), planes, tolerances)
    for weights in rng.dirichlet(np.ones(3) / 4, 40):
        for i, p in enumerate(weights @ corners):
            over = [
                lo <= p[0] <= hi
                and all(
                    way * (p[1] - (y + k * (p[0] - m))) > 0.0 and bend == 0.0
                    for way, (m, y, k, bend) in zip((1, -1), arcs[2 * c : 2 * c + 2], strict=True)
                )
                for c, (lo, hi) in enumerate(x)
                if facets[c] == i
            ]
            assert any(over)
            if tolerances[i] < 1.0:
                assert abs(planes[i] @ [1.0, p[0], p[1], 0.0] - p[2]) < 1e-9
    both = precedes & precedes.T
    assert loose.any() and not both.all() and (precedes | precedes.T | loose[:, None] | loose[None, :]).all()


def slats(count: int, seed: int) -> np.ndarray:
    """Facets of all shapes and slopes in the unit cylinder, some with points on the axis, some level or upright."""
    rng = np.random.default_rng(seed)
    size = 2.0 ** rng.integers(-6, 0, (count, 1, 1))
    corners = rng.uniform(-0.7, 0.7, (count, 1, 3)) + size * rng.normal(size=(count, 3, 3))
    corners[::7, :, 2] = corners[::7, :1, 2]
    corners[::11, 1, :2] = corners[::11, 0, :2]
    corners[::13, 0, :2] = 0.0
    corners[5::13, :, 1] = 0.0
    return corners / max(1.0, np.hypot(corners[..., 0], corners[..., 1]).max())


def angle_at(height: np.ndarray, x: float, y: float) -> float:
    d = height[0] + height[1] * x
    return height[2] + height[3] * np.arctan2(np.sqrt(max(y - d * d, 0.0)), d)


def test_sheets_reach_over_their_facets():
    """Every point of a facet is well inside one of its cells, which is loose or has its angle there."""
    rng = np.random.default_rng(2)
    corners = slats(60, 2)
    owners, x, arcs, heights, tolerances, _ = sheets_of(corners, 0.0)
    tame = np.isfinite(tolerances)
    assert tame.any() and not tame.all() and set(owners) == set(range(60))
    arcs = arcs.reshape(-1, 2, 4)
    told = 0
    for weights in rng.dirichlet(np.ones(3) / 4, 40):
        for i, (u, v, z) in enumerate(weights @ corners):
            y, (low, high) = u * u + v * v, np.moveaxis(arcs[owners == i], 1, 0)
            reach = x[owners == i]
            below, above = (a[:, 1] + (z - a[:, 0]) * (a[:, 2] + (z - a[:, 0]) * a[:, 3]) for a in (low, high))
            inside = (reach[:, 0] < z) & (z < reach[:, 1]) & (below + MARGIN / 4 < y) & (y < above - MARGIN / 4)
            assert inside.any()
            if tame[owners == i][inside].all():
                angles = np.array([angle_at(h, z, y) for h in heights[owners == i][inside]])
                assert np.abs(np.exp(1j * angles) - complex(u, v) / np.hypot(u, v)).min() < 1e-9
                assert (-1e-6 < angles).all() and (angles < 2.0 * np.pi + 1e-6).all()
                told += 1
    assert told > 500


@pytest.mark.share(3)
@pytest.mark.parametrize("seed", range(3))
def test_sheets_that_may_precede_do_so_wherever_they_share_a_point(seed):
    rng = np.random.default_rng(seed)
    owners, x, arcs, heights, tolerances, slacks = sheets_of(slats(50, 10 + seed), 2.0**-47)
    loose, precedes = order_of(GroupCells(np.arange(len(owners), dtype=np.int32), x, arcs), heights, tolerances)
    arcs = arcs.reshape(-1, 2, 4)
    compared = 0
    for _ in range(4000):
        c = rng.choice(np.flatnonzero(~loose))
        z = rng.uniform(*x[c])
        below, above = (a[:, 1] + (z - a[:, 0]) * (a[:, 2] + (z - a[:, 0]) * a[:, 3]) for a in np.moveaxis(arcs, 1, 0))
        y = rng.choice([rng.uniform(below[c], above[c]), below[c], above[c]])
        here = np.flatnonzero(~loose & (x[:, 0] <= z) & (z <= x[:, 1]) & (below <= y) & (y <= above))
        for d in here:
            behind = angle_at(heights[c], z, y) - angle_at(heights[d], z, y)
            assert precedes[c, d] or precedes[d, c]
            assert not precedes[c, d] or behind <= 0.5 * (slacks[c] + slacks[d])
            compared += c != d
    assert compared > 400


@pytest.mark.parametrize("back", [False, True], ids=["a, b", "b, a"])
def test_arcs_that_touch_end(back):
    """Both crossings of two arcs round to one place: the sweep once went from one to the other for ever."""
    a = fc.Polyhedron([(-3, 3, -4), (-1, 1, -4), (-1, 3, -6)], [[0, 1, 2]])
    corners = [(x, y, z) for z in (1, -1) for r in (3, 1) for x, y in ((r, -r), (-r, -r), (-r, r), (r, r))]
    faces = [
        (9, 10, 14), (9, 14, 13), (2, 3, 11), (2, 11, 10), (6, 15, 7), (6, 14, 15), (2, 3, 7), (2, 7, 6),
    ]  # fmt: skip
    b = fc.Polyhedron(corners, faces)
    moving = a.moving(fc.Rotation((1, 1, 1), radians=1))
    bodies = (b, moving) if back else (moving, b)
    # the mesh lies in |z| <= 1, max(|x|, |y|) <= 3; all of the triangle stays outside, as samples along it say
    rng = np.random.default_rng(5)
    places = rng.dirichlet((1, 1, 1), 400) @ np.array(a.vertices)
    axis = np.ones(3) / np.sqrt(3)
    for angle in np.linspace(0, 1, 101):
        along = np.outer(places @ axis, axis)
        turned = along + np.cos(angle) * (places - along) + np.sin(angle) * np.cross(axis, places)
        assert np.all((np.abs(turned[:, 2]) > 1) | (np.abs(turned[:, :2]).max(axis=1) > 3))
    for engine in ("sweep", "boxes"):
        assert fc.first_contact(*bodies, engine=engine).status is fc.Status.FREE
