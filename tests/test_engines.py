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
from firstcontact.kernels.lifted_query import FORMS, ROWS, line_slack, may_meet, plane_slack, write_form
from firstcontact.kernels.principal import box_columns, fit_box, form_range
from firstcontact.search.frame import tree_of
from firstcontact.search.lifted_tree import edges_of, facets_of, lift, lifted_tree
from generators import FAMILIES, Scene, to_tangent

MOTIONS = pytest.mark.parametrize("rotating", [False, True], ids=["translation", "rotation"])


@MOTIONS
@pytest.mark.parametrize(("engine", "count"), [("lifted", 240), ("composed", 60)])
def test_small_scenes_by_engine(engine, count, rotating):
    scenes = small_scenes(70_000, amount(count), rotating)
    seen = Counter(assert_same_first_contact(scene, engine=engine) for scene in scenes)
    assert len(seen) == 3, seen


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
        lines, _, _, sizes, _ = lift(np.concatenate([c, d, d])[None], False, origin, 4.0, np.ones(3))
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
        _, _, _, sizes, planes = lift(corners.reshape(1, 9), True, origin, 4.0, np.array([1.0, 0.6, 0.4]))
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
    lifted = lifted_tree(tree, facets_of(tree))
    leaves = [(i, -j) for i, j in lifted.links.tolist() if j < 0]
    assert sorted(k for i, j in leaves for k in range(i, j)) == list(range(len(body.triangles)))
    nowhere = np.zeros((ROWS, 6))
    nowhere[5] = [9, 9, 9, 9.5, 9.5, 9.5]
    assert not may_meet(lifted.nodes[0], nowhere, True, lifted.scale, lifted.origin, 0.0)
