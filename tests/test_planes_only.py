"""Models with planes only against the engine for polyhedra: two independent ways to one exact answer."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from amount import amount
from firstcontact.contact.models import first as verbs
from firstcontact.contact.reduce import as_model
from firstcontact.work import Query

MOTIONS = ("translation", "rotation")


def random_hull(rng, lattice: bool) -> fc.Polyhedron:
    """A box or tetrahedron in a rational pose; on the lattice many contacts are degenerate."""
    if lattice:
        size = [Fraction(int(x), 2) for x in rng.integers(1, 4, 3)]
        return fc.examples.box(size).translated([Fraction(int(x), 2) for x in rng.integers(-3, 4, 3)])
    if rng.random() < 0.5:
        body = fc.examples.box(rng.uniform(0.3, 1.5, 3))
        return body.rotated(rng.normal(size=3), degrees=float(rng.uniform(0, 180))).translated(rng.uniform(-2, 2, 3))
    while True:
        x = rng.uniform(-1.5, 1.5, (4, 3)) + rng.uniform(-2, 2, 3)
        if np.linalg.det(x[1:] - x[0]) > 0.3:
            return fc.Polyhedron(x, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def random_motion(rng, kind: str, lattice: bool):
    if kind == "translation":
        vector = rng.integers(-4, 5, 3).tolist() if lattice else rng.normal(0, 3, 3)
        return fc.Translation(vector)
    if lattice:
        axis = np.eye(3, dtype=int)[rng.integers(3)].tolist()
        return fc.Rotation(axis, point=rng.integers(-2, 3, 3).tolist(), degrees=int(rng.choice([90, 180, -270, 360])))
    return fc.Rotation(rng.normal(size=3), point=rng.uniform(-1, 1, 3), degrees=float(rng.uniform(-300, 300)))


@pytest.mark.thorough
@pytest.mark.parametrize("kind", MOTIONS)
@pytest.mark.parametrize("lattice", [False, True])
def test_planes_only_agree_with_polyhedra(kind, lattice):
    rng = np.random.default_rng(1995 + lattice + 10 * (kind == "rotation"))
    seen = set()
    for _ in range(amount(12 if kind == "rotation" else 40, 2)):
        a, b = random_hull(rng, lattice), random_hull(rng, lattice)
        moving = a.moving(random_motion(rng, kind, lattice))
        expected = fc.first_contact(moving, b)
        found = verbs.first(Query(moving, b, fmpq(0), fmpq(1), method="algebraic"))
        assert found.status is expected.status, (moving, b)
        seen.add(found.status)
        if found.status is fc.Status.CONTACT:
            assert abs(found.time - expected.time) <= 4.5e-16 * max(1.0, abs(expected.time))
        if found.status is fc.Status.INITIAL_CONTACT:
            assert found.initial == expected.initial
    assert len(seen) >= 2


def test_elements_keep_the_numbers_of_the_polyhedron():
    cube = fc.examples.box((2, 2, 2))
    ball = fc.sphere(1).translated(("3/10", "1/5", 5))
    hit = fc.first_contact(ball.moving(fc.Translation((0, 0, -5))), cube.named("cube"))
    corners = cube.vertices[cube.triangles[hit.element_b.index]]
    assert hit.element_b.kind == "face" and hit.element_b.label == "cube"
    assert np.all(corners[:, 2] == 1.0)
    weights = np.linalg.solve(np.vstack([corners[:, :2].T, np.ones(3)]), [0.3, 0.2, 1.0])
    assert np.all(weights >= 0)  # the triangle that holds the point, not the other half of the side


def test_what_cannot_be_a_model():
    dented = fc.Polyhedron(
        [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4], [0.5, 0.5, 0.5]],
        [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 4], [2, 3, 4], [3, 1, 4]],
        name="dented",
    )
    with pytest.raises(fc.UnsupportedPair, match="dented is not convex"):
        as_model(dented)
    with pytest.raises(fc.UnsupportedPair, match="solid"):
        as_model(fc.Polyhedron([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))


@pytest.mark.parametrize("lattice", [False, True])
def test_intervals_agree_with_polyhedra(lattice):
    rng = np.random.default_rng(2017 + lattice)
    found_some = 0
    for _ in range(amount(24 if lattice else 8)):
        a, b = random_hull(rng, lattice), random_hull(rng, lattice)
        moving = a.moving(random_motion(rng, "translation", lattice))
        expected, found = fc.contact_intervals(moving, b), verbs.intervals(Query(moving, b, fmpq(0), fmpq(1)))
        assert [t for i in found for t in (i.start, i.end)] == pytest.approx(
            [t for i in expected for t in (i.start, i.end)], abs=1e-15
        )
        found_some += len(found)
    assert found_some >= 1


def test_a_box_that_slides_along_a_shelf_touches_it_all_the_time():
    shelf, parcel = fc.box((2, 2, 2)), fc.box((1, 1, 1)).translated((-4, 0, 1.5))
    found = fc.contact_intervals(parcel.moving(fc.Translation((8, 0, 0))), shelf)
    assert [(i.start, i.end) for i in found] == [(0.3125, 0.6875)]
    hit = fc.first_contact(parcel.moving(fc.Translation((8, 0, 0))), shelf)
    assert hit.time == 0.3125


ROCK = fc.Polyhedron(
    [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)],
    [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]],
)
"""Four faces meet at each vertex; three of them tell where it is."""


@pytest.mark.parametrize("swap", [False, True], ids=["", "swapped"])
def test_a_vertex_of_four_faces_is_told_as_one(swap):
    rng = np.random.default_rng(11)
    for _ in range(20):
        x, y = (Fraction(int(k), 100) for k in rng.integers(-20, 21, 2))
        u, v = (Fraction(int(k), 40) for k in rng.integers(-10, 11, 2))
        bodies = ROCK.moving(fc.Translation((u, v, -4))), fc.sphere(1).translated((x, y, -4))
        hit = fc.first_contact(*bodies[::-1] if swap else bodies)
        rock, ball = (hit.element_b, hit.element_a) if swap else (hit.element_a, hit.element_b)
        assert (rock.kind, rock.index, ball.kind) == ("vertex", 5, "face")
        down = np.array([float(u), float(v), -4.0]) * hit.time + [0, 0, -1]
        assert hit.point == pytest.approx(down, abs=1e-14) and hit.contact_set == "point"
