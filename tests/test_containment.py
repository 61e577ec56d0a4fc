"""How two bodies meet at the start: touching, overlapping, containment, or not at all."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest

import firstcontact as fc
import generators as g
import naive
from agreement import polyhedron
from amount import amount
from firstcontact.search.trees.containment import _fit_into, component_boxes, component_labels, component_vertices
from generators import box, moved
from vectors import Body

UP = fc.Translation((0, 0, 1))


def start(
    a: Body, b: Body, solid_a: bool = True, solid_b: bool = True, exact: bool = False
) -> fc.FirstContact:
    """The answer of a body that hardly moves: what it says about time 0."""
    return fc.first_contact(
        polyhedron(a, solid_a).moving(UP), polyhedron(b, solid_b), (0, 2.0**-30), exact=exact
    )


def assert_initial(a: Body, b: Body, *expected: str) -> None:
    """One of the expected words, in both orders of the bodies, with time 0 and no normal."""
    for hit in (start(a, b), start(b, a), start(a, b, exact=True)):
        assert hit.status is fc.Status.INITIAL_CONTACT
        assert hit.initial in expected, f"{hit.initial}, expected {expected}: {a} {b}"
        assert hit.time == 0 and hit.normal is None
        assert hit.time_interval[0] <= 0 <= hit.time_interval[1]


CUBE = box((2, 2, 2))


@pytest.mark.parametrize(
    "at",
    [(2, 0, 0), (2, 1, 0), (0, -2, 0), (2, 2, 0), (2, -2, 1), (2, 2, 2), (-2, 2, -2)],
    ids=["face", "face shifted", "face below", "edge", "edge shifted", "vertex", "other vertex"],
)
def test_cubes_that_share_only_boundary_touch(at):
    assert_initial(CUBE, box((2, 2, 2), at), "touching")


@pytest.mark.parametrize("at", [(1, 0, 0), (1, 1, 0), (1, 1, 1), (1.5, -0.5, 0.25), (2 - 2.0**-50, 0, 0)])
def test_cubes_that_share_interior_overlap(at):
    assert_initial(CUBE, box((2, 2, 2), at), "overlapping")


def test_crossed_bars_with_coplanar_faces_overlap():
    assert_initial(box((6, 2, 2), (-2, 0, 0)), box((2, 6, 2), (0, -2, 0)), "overlapping")


def test_crossed_bars_without_coplanar_faces_overlap():
    assert_initial(box((6, 2, 2), (-2, 0, 0)), box((2, 6, 1), (0, -2, 0.5)), "overlapping")


def test_bar_lying_on_a_bar_touches():
    assert_initial(box((6, 2, 2), (-2, 0, 0)), box((2, 6, 2), (0, -2, 2)), "touching")


def test_cube_strictly_inside_is_contained():
    assert_initial(box((1, 1, 1), (0.5, 0.5, 0.5)), CUBE, "containment")


def test_the_same_cube_twice_shares_interior():
    assert_initial(CUBE, CUBE, "overlapping", "containment")


@pytest.mark.parametrize("at", [(0, 0.5, 0.5), (0, 0, 0.5), (0, 0, 0)], ids=["face", "edge", "corner"])
def test_cube_in_cube_touching_from_inside_shares_interior(at):
    assert_initial(box((1, 1, 1), at), CUBE, "overlapping", "containment")


def hollow_cube() -> Body:
    """[0, 10]^3 without the open cube (3, 7)^3."""
    outer, inner = box((10, 10, 10)), box((4, 4, 4), (3, 3, 3))
    return Body(outer.v + inner.v, [], outer.f + [[i + 8 for i in reversed(f)] for f in inner.f])


def test_a_body_in_the_hollow_of_a_shell_is_free():
    for hit in (
        start(box((2, 2, 2), (4, 4, 4)), hollow_cube()),
        start(hollow_cube(), box((2, 2, 2), (4, 4, 4))),
    ):
        assert hit.status is fc.Status.FREE


def test_a_body_filling_the_hollow_touches():
    assert_initial(box((4, 4, 4), (3, 3, 3)), hollow_cube(), "touching")


def test_a_body_in_the_wall_of_a_shell_is_contained():
    assert_initial(box((1, 1, 1), (1, 1, 1)), hollow_cube(), "containment")


def test_a_body_larger_than_the_hollow_overlaps():
    assert_initial(box((5, 2, 2), (3, 4, 4)), hollow_cube(), "overlapping")


def test_one_component_of_many_inside_is_enough():
    far, near = box((1, 1, 1), (30, 0, 0)), box((1, 1, 1), (0.5, 0.5, 0.5))
    pair = Body(far.v + near.v, [], far.f + [[i + 8 for i in f] for f in near.f])
    assert_initial(pair, CUBE, "containment")


def test_surfaces_do_not_own_their_interior():
    small = box((1, 1, 1), (0.5, 0.5, 0.5))
    assert start(small, CUBE, solid_a=True, solid_b=False).status is fc.Status.FREE
    assert start(CUBE, small, solid_a=False, solid_b=True).status is fc.Status.FREE
    assert start(small, CUBE, solid_a=False, solid_b=True).initial == "containment"


@pytest.mark.parametrize("inside_out", [False, True])
def test_orientation_does_not_matter(inside_out):
    small = box((1, 1, 1), (0.5, 0.5, 0.5))
    flipped = Body(CUBE.v, [], [f[::-1] for f in CUBE.f] if inside_out else CUBE.f)
    hit = fc.first_contact(fc.Polyhedron(small.v, small.f).moving(UP), fc.Polyhedron(flipped.v, flipped.f))
    assert hit.initial == "containment"  # both are closed, hence solid without being told


def test_points_and_edges_inside_a_solid():
    assert start(Body([[1, 1, 1]], [], []), CUBE, solid_a=False).initial == "containment"
    assert start(Body([[1, 1, 0.5], [1, 0.5, 1]], [[0, 1]], []), CUBE, solid_a=False).initial == "containment"
    assert start(Body([[1, 1, 2]], [], []), CUBE, solid_a=False).initial == "touching"
    assert start(Body([[1, 1, 1], [1, 1, 5]], [[0, 1]], []), CUBE, solid_a=False).initial == "overlapping"
    assert start(Body([[1, 1, 3]], [], []), CUBE, solid_a=False).status is fc.Status.FREE


# --------------------------------------------------------------------------------------- random, with truth


def polycube(cells) -> Body:
    """The union of unit cells: two triangles for every square that borders exactly one cell."""
    index: dict[tuple, int] = {}
    faces = []
    for cell, axis_, side in product(cells, range(3), (0, 1)):
        beyond = tuple(x + (2 * side - 1) * (k == axis_) for k, x in enumerate(cell))
        if beyond in cells:
            continue
        u, v = ((axis_ + 1) % 3, (axis_ + 2) % 3) if side else ((axis_ + 2) % 3, (axis_ + 1) % 3)
        corners = []
        for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
            p = list(cell)
            p[axis_] += side
            p[u] += du
            p[v] += dv
            corners.append(index.setdefault(tuple(p), len(index)))
        faces += [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
    return Body([list(p) for p in index], [], faces)


def polycube_truth(cells_a, cells_b, a: Body, b: Body) -> tuple[str, ...]:
    if cells_a & cells_b:
        apart = not naive.surfaces_meet(naive.shape(a.v, (), a.f), naive.shape(b.v, (), b.f))
        if apart:
            return ("containment",)
        within = cells_a <= cells_b or cells_b <= cells_a
        return ("overlapping", "containment") if within else ("overlapping",)
    close = any(max(abs(x - y) for x, y in zip(c, d, strict=True)) <= 1 for c, d in product(cells_a, cells_b))
    return ("touching",) if close else ()


@pytest.mark.share(2)
@pytest.mark.parametrize("first", range(0, amount(120), 10))
def test_random_polycubes(first):
    for seed in range(first, first + 10):
        rng = np.random.default_rng(seed)
        cells_a, cells_b = (
            {tuple(c) for c in (rng.integers(0, 3, (rng.integers(1, 6), 3)) + off).tolist()}
            for off in (0, rng.integers(0, 3, 3))
        )
        a, b = polycube(cells_a), polycube(cells_b)
        expected = polycube_truth(cells_a, cells_b, a, b)
        if expected:
            assert_initial(a, b, *expected)
        else:
            assert start(a, b).status is fc.Status.FREE, f"seed {seed}"


@pytest.mark.share(2)
@pytest.mark.parametrize("first", range(0, amount(300), 25))
def test_random_tetrahedra_and_boxes(first):
    """Convex solids share interior exactly when no face normal and no edge cross product separates them."""
    seen = set()
    for seed in range(first, first + 25):
        rng = np.random.default_rng(seed)
        a, b = convex(rng), moved(convex(rng), rng.integers(-2, 3, 3).tolist())
        shape_a, shape_b = naive.shape(a.v, (), a.f, True), naive.shape(b.v, (), b.f, True)
        if not naive.bodies_meet(shape_a, shape_b):
            assert start(a, b).status is fc.Status.FREE, f"seed {seed}"
        elif not naive.convex_interiors_overlap(a.v, a.f, b.v, b.f):
            assert_initial(a, b, "touching")
            seen.add("touching")
        elif naive.surfaces_meet(shape_a, shape_b):
            assert_initial(a, b, "overlapping", *(["containment"] if nested(shape_a, shape_b) else []))
            seen.add("overlapping")
        else:
            assert_initial(a, b, "containment")
    assert {"touching", "overlapping"} <= seen


def convex(rng) -> Body:
    if rng.integers(2):
        return box(rng.integers(1, 4, 3).tolist())
    while True:
        tetrahedron = g.lattice_body("tetrahedron", rng.integers(-2, 3, (6, 3)).tolist())
        p = np.array(tetrahedron.v)
        if round(np.linalg.det(p[1:] - p[0])) != 0:
            return tetrahedron


def nested(a: naive.Shape, b: naive.Shape) -> bool:
    return all(naive.inside(p, b) for p in a.points) or all(naive.inside(p, a) for p in b.points)


def test_components_that_fit_into_no_other_by_brute_force():
    rng = np.random.default_rng(5)
    for n in (1, 4, 5, 40, 133):
        low = rng.integers(0, 6, (2, n, 3))
        size = rng.integers(0, 4, (2, n, 3))
        inner, outer = np.concatenate([low, low + size], axis=2).astype(float)
        x, y = inner[:, None], outer[None]
        inside = np.all(y[..., :3] <= x[..., :3], axis=2) & np.all(y[..., 3:] >= x[..., 3:], axis=2)
        assert np.array_equal(_fit_into(inner, outer, 0.0), inside.any(1))
        assert _fit_into(inner, outer, 10.0).all()


def test_boxes_of_components():
    places = np.random.default_rng(6).normal(size=(9, 3))
    for body in (
        fc.examples.nested_hyperboloids(6, closed=True).a,
        fc.Polyhedron(places, [[1, 2, 3], [1, 3, 2]], edges=[[5, 6]]),
        fc.Polyhedron(places, [[6, 7, 8]]),
        fc.Polyhedron(places, []),
    ):
        labels = component_labels(body)
        for v, limits in zip(component_vertices(body), component_boxes(body), strict=True):
            of = body.vertices[labels == v]
            assert np.array_equal(limits, np.concatenate([of.min(axis=0), of.max(axis=0)]))


def test_contact_for_ever_from_the_start_on():
    """A touch that never ends has no end to compare: it was dropped, and the answer FREE."""
    sides = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
    a = fc.Polyhedron([(0, 2, -3), (3, 2, -3), (0, 4, -3), (0, 2, 0)], sides).moving(fc.Translation((2, 0, -1)))
    b = fc.Polyhedron([(0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 0, 3)], sides).moving(fc.Translation((2, 0, -1)))
    (found,) = fc.contact_intervals(a, b, (0, math.inf))
    assert (found.start, found.end) == (0, math.inf)
    (found,) = fc.contact_intervals(a.body, b.body, (0, math.inf))
    assert (found.start, found.end) == (0, math.inf)


def test_points_that_are_one_all_the_time():
    """Two coinciding points of one body and a third of another have no line between them."""
    turn = fc.Rotation((2, 1, 2), (-1, -2, -2), radians=3)
    way = fc.Sequence([fc.Screw((1, 2, 2), (2, 2, 1), turns=1, advance=5), turn])
    a, b = fc.Polyhedron([(0, 0, -4), (0, 0, -4)], []).moving(way), fc.Polyhedron([(0, 0, -4)], []).moving(way)
    assert fc.first_contact(a, b, (0.75, 1)).status in (fc.Status.INITIAL_CONTACT, fc.Status.UNDECIDED)
