"""Every engine gives the same answer; `auto` takes the one that does less; boxes of lines hold what they say."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
import generators as g
import naive
from agreement import assert_same_first_contact, question, same_answer, small_scenes
from amount import amount
from firstcontact.kernels.lifted.meridians import may_meet_turning
from firstcontact.kernels.lifted.principal import box_columns, fit_box, form_range
from firstcontact.kernels.lifted.query import FORMS, ROWS, line_slack, plane_slack, write_form
from firstcontact.kernels.lifted.swept_cell import (
    PATH_ROWS,
    begin_cell,
    edge_distances,
    edge_keeps_off,
    facet_may_meet,
    put_path,
)
from firstcontact.search.lifted.lifted_elements import edges_of, facets_of, lift
from firstcontact.search.trees.frame import tree_of
from generators import FAMILIES, Scene, to_tangent

MOTIONS = pytest.mark.parametrize("rotating", [False, True], ids=["translation", "rotation"])


@pytest.mark.share(4)
@MOTIONS
@pytest.mark.parametrize(("engine", "count"), [("lifted", 240), ("composed", 60)])
def test_small_scenes_by_engine(engine, count, rotating):
    scenes = small_scenes(70_000, amount(count, 3), rotating)
    seen = Counter(assert_same_first_contact(scene, engine=engine) for scene in scenes)
    assert len(seen) == 3, seen


@pytest.mark.share(6)
@pytest.mark.parametrize("engine", ["lifted", "composed"])
@pytest.mark.parametrize("family", FAMILIES)
def test_near_miss_families_by_engine(family, engine):
    a, b = FAMILIES[family](16, 5)
    assert assert_same_first_contact(Scene(a, b, translation=(0, 0, 1)), engine=engine) == naive.CONTACT
    turn = {"axis": (0, 0, 1), "turns": 1}
    scene = Scene(to_tangent(a), to_tangent(b), rotation=turn)
    assert assert_same_first_contact(scene, engine=engine) == naive.CONTACT


@MOTIONS
def test_rods_on_reguli_by_every_engine(rotating):
    """Closed prisms whose ridges pass at a hair's breadth: also edges against facets at the start."""
    n = 24
    a, b = (g.rods(lines, 0.2 / n, up) for lines, up in zip(g.reguli(n, 2.0**-10, 3), (False, True), strict=True))
    scene = Scene(a, b, translation=(0, 0, 1), solid=True)
    if rotating:
        turn = {"axis": (0, 0, 1), "turns": 1}
        scene = Scene(to_tangent(a), to_tangent(b), rotation=turn, solid=True)
    boxes, lifted, *others = (
        fc.first_contact(*question(scene), engine=e) for e in ("boxes", "lifted", "auto", "composed")
    )
    assert boxes.status is fc.Status.CONTACT
    assert all(same_answer(x, boxes) for x in (lifted, *others))
    assert 3 * lifted.stats.pair_tests < boxes.stats.pair_tests


@pytest.mark.auto
@MOTIONS
def test_auto_changes_over_where_all_pass_all(rotating):
    a, b = g.reguli(400, 2.0**-10, 4, planted=True)
    scene = Scene(a, b, translation=(0, 0, 1))
    if rotating:
        scene = Scene(to_tangent(a), to_tangent(b), rotation={"axis": (0, 0, 1), "turns": 1})
    boxes, auto = (fc.first_contact(*question(scene), engine=e) for e in ("boxes", "auto"))
    assert (boxes.stats.engine, auto.stats.engine) == ("boxes", "lifted")
    assert same_answer(auto, boxes)
    assert 10 * auto.stats.pair_tests < boxes.stats.pair_tests


@pytest.mark.share(2)
@pytest.mark.auto
@pytest.mark.parametrize("turning", [False, True], ids=["translation", "rotation"])
@pytest.mark.parametrize("make", ["layered_reguli", "woven_rods", "tangent_plates", "near_miss_combs"])
def test_auto_does_little_more_than_the_better_engine(make, turning):
    scene = getattr(fc.examples, make)(400, turning=turning)
    boxes, lifted, auto = (
        fc.first_contact(scene.moving, scene.resting, engine=e) for e in ("boxes", "lifted", "auto")
    )
    assert same_answer(auto, boxes) and same_answer(lifted, boxes)
    assert auto.stats.pair_tests <= 1.2 * min(boxes.stats.pair_tests, lifted.stats.pair_tests)


@MOTIONS
def test_pair_tests_of_vertices_and_facets_grow_slowly(rotating):
    """With n^1.34 under translation and n^1.6 under rotation at most; boxes test n^2."""
    for make in ("slats_over_points", "tangent_plates"):
        tests = []
        for n in (250, 1000):
            scene = getattr(fc.examples, make)(n, turning=rotating)
            tests.append(fc.first_contact(scene.moving, scene.resting, engine="lifted").stats.pair_tests)
        assert tests[1] < 4 ** (1.6 if rotating else 1.34) * tests[0], (make, tests)


@MOTIONS
@pytest.mark.parametrize("make", ["slats_over_points", "tangent_plates", "nested_shells", "convex_pair"])
def test_vertices_and_facets_by_halving(make, rotating):
    """Points or closed solids; the same contact as by boxes."""
    for seed in range(amount(6)):
        if make in ("nested_shells", "convex_pair"):
            scene = getattr(fc.examples, make)(150, seed=seed)
        else:
            scene = getattr(fc.examples, make)(60, turning=rotating, closed=seed % 2 == 1, seed=seed)
        by_lines, by_boxes = (
            fc.first_contact(scene.moving, scene.resting, engine=e) for e in ("lifted", "boxes")
        )
        assert same_answer(by_lines, by_boxes), seed


@pytest.mark.parametrize("closed", [False, True], ids=["rods", "prisms"])
def test_what_turns_at_a_constant_gap_is_told_by_heights_and_distances(closed):
    for seed in range(amount(9)):
        n, gap = (200, 1e-3) if seed == 0 else (20, 10.0**-seed)
        scene = fc.examples.nested_hyperboloids(n, gap=gap, planted=seed % 3 != 1, closed=closed, seed=seed)
        lifted, boxes = (
            fc.first_contact(scene.moving, scene.resting, engine=e) for e in ("lifted", "boxes")
        )
        assert same_answer(lifted, boxes), seed
        assert n < 200 or lifted.stats.pair_tests < 4 * n < boxes.stats.pair_tests


@pytest.mark.auto
def test_auto_stays_with_boxes_on_ordinary_meshes():
    ball = fc.examples.noisy_sphere(2000)
    ask = (ball.moving(fc.Translation((0, 0, 3))), ball.translated((0.25, 0, 3)))
    boxes, auto = fc.first_contact(*ask, engine="boxes"), fc.first_contact(*ask)
    assert auto.stats.engine == "boxes" and same_answer(auto, boxes)
    assert (auto.stats.pair_tests, auto.stats.node_visits) == (boxes.stats.pair_tests, boxes.stats.node_visits)


@pytest.mark.parametrize("engine", ["lifted", "composed"])
def test_a_budget_ends_every_engine(engine):
    a, b = g.reguli(60, 2.0**-10, 4)
    ask = question(Scene(a, b, translation=(0, 0, 1)))
    full, short = fc.first_contact(*ask, engine=engine), fc.first_contact(*ask, engine=engine, budget=20)
    assert short.status is fc.Status.UNDECIDED and short.reason == "budget"
    assert short.free_until <= full.time


def test_lifted_trees_refuse_other_motions():
    rod = fc.Polyhedron([[0, 0, 0], [1, 0, 0]], [], edges=[[0, 1]])
    screw = fc.Screw((0, 0, 1), degrees=90, advance=1)
    with pytest.raises(fc.UnsupportedPair, match="lifted"):
        fc.first_contact(rod.moving(screw), rod, engine="lifted")


# ------------------------------------------------------------------------------------------------ bounds


def rationals(x) -> list[Fraction]:
    return [Fraction(float(v)) for v in x]


@pytest.mark.thorough
@pytest.mark.parametrize("d", [4, 6])
@pytest.mark.parametrize("spread", [1.0, 2.0**-30, 0.0])
def test_boxes_along_principal_axes_hold_their_vectors(d, spread):
    """Whatever the axes: the form's value on each vector, exactly, against the range over the box."""
    rng = np.random.default_rng(d)
    for _ in range(5):
        plane = rng.normal(size=(2, d))
        vectors = rng.normal(size=(30, 2)) @ plane + spread * rng.normal(size=(30, d))
        row, order = np.zeros(3 + box_columns(d)), np.arange(30)
        fit_box(vectors, order, 0, 30, 1, row, 3, np.empty((d, d)), np.empty((d, d)), np.empty((3, d)))
        for form in (*rng.normal(size=(5, d)), np.linalg.svd(plane)[2][-1]):
            value, reach = form_range(row, 3, form, d)
            rounding = 2.0**-46 * np.abs(form).sum() * np.abs(vectors).max()
            for y in vectors:
                exact = sum(p * q for p, q in zip(rationals(y), rationals(form), strict=True))
                assert abs(exact - Fraction(value)) <= Fraction(reach) + Fraction(rounding)


def test_rounded_products_of_lines_stay_within_their_slack():
    """Lines near the origin or far from it, of short and long edges; products in Fractions."""
    rng = np.random.default_rng(3)
    worst = 0.0
    for k in range(300):
        origin, far, size = rng.normal(size=3), 10.0 ** rng.integers(-2, 4), 10.0 ** rng.integers(-3, 1)
        a, c = origin + far * rng.normal(size=(2, 3))
        b, d = a + size * rng.normal(size=3), c + size * rng.normal(size=3)
        if k % 2:
            d = c + (b - a) + 1e-9 * rng.normal(size=3)
        lines, _, sizes, _ = lift(np.concatenate([c, d, d])[None], False, origin, 4.0, np.ones(3))
        query, x = np.zeros((ROWS, 6)), a - origin
        write_form(query, FORMS, *x, *(b - a), 4.0)
        value = sum(p * q for p, q in zip(rationals(lines[0]), rationals(query[FORMS]), strict=True))
        p, q, r, s = (np.array(rationals(v)) for v in (a, b, c, d))
        exact = -np.dot(r - p, np.cross(q - p, s - r)) / 4
        if lines[0, :3] @ (d - c) < 0:  # the line's own way
            exact = -exact
        slack = line_slack(max(sizes[0, 1], np.abs(x).max()), sizes[0, 0], np.abs(b - a).sum(), 4.0, 0.0)
        worst = max(worst, abs(float(exact - value)) / slack)
    assert 1e-5 < worst < 0.5


def test_rounded_heights_over_planes_stay_within_their_slack():
    """Needles and fat triangles; n.p - n.a in Fractions, of the true normal divided as the float one is."""
    rng = np.random.default_rng(4)
    worst = 0.0
    for _ in range(300):
        origin, size, needle = rng.normal(size=3), 10.0 ** rng.integers(-3, 1), 10.0 ** rng.integers(-9, 1)
        a = origin + rng.normal(size=3)
        e = size * rng.normal(size=3)
        corners = np.stack([a, a + e, a + 0.5 * e + needle * size * rng.normal(size=3)])
        _, _, sizes, planes = lift(corners.reshape(1, 9), True, origin, 4.0, np.array([1.0, 0.6, 0.4]))
        p = origin + rng.normal(size=3)
        form = [*(Fraction(float(v)) / 4 for v in p - origin), Fraction(1)]
        value = sum(x * y for x, y in zip(rationals(planes[0]), form, strict=True))
        x, y, z, w = (np.array(rationals(v)) for v in (*corners, p))
        normal = np.cross(y - x, z - x)
        exact = np.dot(normal, w - x) / max(abs(n) for n in normal) / 4
        if np.dot(rationals(planes[0, :3]), normal) < 0:
            exact = -exact
        slack = plane_slack(max(sizes[0, 1], np.abs(p - origin).max()), sizes[0, 2], 4.0, 0.0)
        worst = max(worst, abs(float(exact - value)) / slack)
    assert 1e-6 < worst < 0.5


def test_elements_are_told_apart_once_each():
    body = fc.examples.noisy_sphere(300)
    tree = tree_of(body)
    assert len(edges_of(tree).parts) == len(body.edges)
    assert len(facets_of(tree).parts) == len(body.triangles)


# -------------------------------------------------------------------------------------- cells of paths


@pytest.mark.share(2)
@MOTIONS
def test_cells_of_paths_lose_no_meeting(rotating):
    """Triangles through a point of one of the paths, in doubles but for their rounding; thin and touching ones too."""
    rng = np.random.default_rng(11)
    motion = np.zeros((3, 3) if rotating else (1, 9))
    if rotating:
        motion[2, :2] = 0.25, -0.5
    left_out = 0
    for k in range(amount(600)):
        size, far = 10.0 ** rng.integers(-3, 1), 10.0 ** rng.integers(-1, 3)
        middle, cell = far * rng.normal(size=3), np.zeros((PATH_ROWS, 6))
        begin_cell(cell, False, motion)
        start = middle + size * rng.normal(size=(4, 3))
        tangent, shift = 0.2 * rng.uniform(), size * rng.normal(size=3)
        for p in start:
            hull, at = path(p, tangent, rng.uniform(), motion) if rotating else shifted(p, shift, rng.uniform())
            put_path(cell, hull, len(hull))
        sides = size * rng.normal(size=(2, 3)) * 10.0 ** rng.integers(-6, 2, (2, 1))
        weights = rng.uniform(size=2) * (0.0 if k % 5 == 0 else 0.5)
        first = at - weights @ sides
        triangle = np.concatenate([first, first + sides[0], first + sides[1]])
        assert facet_may_meet(cell, triangle, 0.0), (cell, triangle)
        left_out += not facet_may_meet(cell, triangle + np.tile(3 * size * rng.normal(size=3), 3), 0.0)
    assert left_out > amount(600) // 4


def test_edges_that_come_together_somewhere_do_not_keep_off():
    """A point of either edge at one height and one distance from the axis; and edges that share no distance do."""
    rng = np.random.default_rng(12)
    motion, apart = np.zeros((3, 3)), 0
    motion[2, :2] = 0.25, -0.5
    for _ in range(amount(900)):
        at, angle, size = rng.normal(size=3), rng.uniform(0, 2 * np.pi), 10.0 ** rng.integers(-6, 1)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        met = np.array([*(motion[2, :2] + turn @ (at - motion[2])[:2]), at[2]])
        along = size * rng.normal(size=(2, 3)) * rng.choice([0.0, 1.0], (2, 3), p=[0.2, 0.8])
        share = rng.choice([0.0, 0.3, 1.0], 2)
        x, y = (np.concatenate([p - s * d, p + (1 - s) * d, p + (1 - s) * d])
                for p, d, s in zip((at, met), along, share, strict=True))  # fmt: skip
        nearest, farthest = edge_distances(y[None], motion)[0]
        heights = sorted((y[2], y[5]))
        assert not edge_keeps_off(x, *heights, nearest, farthest, 0.25, -0.5, 0.0), (x, y)
        wide = farthest - nearest + 20 * size + 1e-9
        apart += edge_keeps_off(x, *heights, nearest + wide, farthest + wide, 0.25, -0.5, 0.0)
    assert apart == amount(900)


def part(at, size, rng):
    """A triangle, an edge or a point (9,) that `at` (on the grid of 2^-20) belongs to, in exact arithmetic."""
    sides = np.round(size * rng.normal(size=(2, 3)) * rng.choice([0.0, 1.0], (2, 3), p=[0.2, 0.8]) * 2**18) / 2**18
    if rng.uniform() < 0.4:
        sides[1] = sides[0] * rng.choice([0.0, 1.0])
    sides *= rng.choice([0.0, 1.0], p=[0.1, 0.9])
    first = at - rng.choice([0.0, 0.25, 0.5]) * sides[0] - rng.choice([0.0, 0.25, 0.5]) * sides[1]
    if np.array_equal(sides[0], sides[1]):
        first = at - rng.choice([0.0, 0.25, 1.0]) * sides[0]
    return np.concatenate([first, first + sides[0], first + sides[1]])


def test_parts_that_share_a_height_and_a_distance_are_never_left_out():
    """Among parts of two surfaces of revolution at a small gap; those are left out, also where others do meet."""
    rng, quarter = np.random.default_rng(13), np.array([[0.0, -1.0], [1.0, 0.0]])
    left_out = 0
    for k in range(amount(300)):
        scene = fc.examples.nested_hyperboloids(30, gap=0.01, planted=False, closed=k % 2 == 1, seed=k % 5)
        a, b = (tree_of(x).xyz for x in (scene.a, scene.b))
        at = np.round(rng.normal(size=3) * 2**18) / 2**18
        met = np.array([*(np.linalg.matrix_power(quarter, k % 4) @ at[:2]), at[2]])
        size = 2.0 ** rng.integers(-8, 2)
        both = np.concatenate([part(at, size, rng)[None], a, part(met, size, rng)[None], b])
        moved = np.tile([0.25, -0.5, 0.0], 3)
        meets = may_meet_turning(both + moved if k % 3 else both, 1 + len(a), *(moved[:2] * (k % 3 > 0)), 0.0)
        assert meets[0] and meets[1 + len(a)], (both[0], both[1 + len(a)])
        left_out += not meets.all()
        assert not may_meet_turning(np.concatenate([a, b]), len(a), 0.0, 0.0, 0.0).any()
        assert may_meet_turning(np.concatenate([a, b]), len(a), 0.0, 0.0, 0.01).any()
    assert left_out > amount(300) // 2


def shifted(p, shift, s):
    return np.array([p, p + shift]), p + s * shift


def path(p, tangent, s, motion):
    """Corners of the hull of an arc about the axis, and the point at the share s of its angle."""
    def turned(angle):
        c, r = motion[2], np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        return np.array([*(c[:2] + r @ (p - c)[:2]), p[2]])

    end = 2.0 * np.arctan(tangent)
    corner = p + tangent * np.array([-(p - motion[2])[1], (p - motion[2])[0], 0.0])
    return np.array([p, corner, turned(end)]), turned(s * end)
