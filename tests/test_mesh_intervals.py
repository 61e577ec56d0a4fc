"""Contact intervals of polyhedra of any shape with curved models: against exact arithmetic, by hand, and sampled."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import trimesh
from flint import fmpq

import firstcontact as fc
from firstcontact.body.solid import primitives
from firstcontact.contact.mesh_model.mesh_intervals import intervals
from firstcontact.contact.mesh_model.mesh_starts import Standing
from firstcontact.search.convex.mesh_advance import MeshSearch, Open, Swept
from firstcontact.search.convex.resting import Place
from firstcontact.work import Query

BALL, SMALL, PIN = primitives.sphere(1), primitives.sphere("1/4"), primitives.cylinder("1/2", 2)
OUTLINE = np.array([(-3, -2), (3, -2), (3, 2), (2, 2), (2, -1), (-2, -1), (-2, 2), (-3, 2)], float)
ARMS = [
    primitives.box((6, 1, 2)).translated((0, "-3/2", 0)),
    primitives.box((1, 4, 2)).translated(("-5/2", 0, 0)),
    primitives.box((1, 4, 2)).translated(("5/2", 0, 0)),
]


def clip():
    """A prism over a U, whose parts are ARMS."""
    n = len(OUTLINE)
    vertices = np.array([(*p, z) for z in (-1.0, 1.0) for p in OUTLINE])
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    return fc.Polyhedron(vertices, [list(range(n))[::-1], list(range(n, 2 * n)), *sides], name="clip")


def joined(parts):
    """The union of the intervals of several pairs, of exact arithmetic or of certified times."""
    found = sorted((x.start, x.end) for pair in parts for x in fc.contact_intervals(*pair))
    union = found[:1]
    for start, end in found[1:]:
        if start <= union[-1][1]:
            union[-1] = union[-1][0], max(end, union[-1][1])
        else:
            union.append((start, end))
    return union


CLIP_SCENES = {
    "small ball across": SMALL.translated((-5, "1/2", "1/10")).moving(fc.Translation((10, "1/7", 0))),  # wholly inside
    "large ball across": BALL.translated((-5, "1/2", "1/10")).moving(fc.Translation((10, "1/7", 0))),
    "pin falls in": PIN.translated((0, "1/9", 4)).moving(fc.Translation((0, -3, -8))),
    "ball on a screw": SMALL.translated((2, "1/2", -1)).moving(fc.Screw((0, 0, 1), degrees=360, advance=2)),
    "cone turns": primitives.cone(1, 2).translated((2, 1, -1)).moving(fc.Rotation((1, 0, 0), degrees=360)),
}


def assert_near(found, known):
    ends = np.array([(x.start, x.end) for x in found])
    assert ends.shape == np.shape(known) and np.abs(ends - known).max() <= 1e-11


@pytest.mark.thorough
@pytest.mark.parametrize("name", CLIP_SCENES)
def test_as_the_union_of_its_parts(name):
    body = CLIP_SCENES[name]
    known = joined((body, arm) for arm in ARMS)
    found = fc.contact_intervals(body, clip())
    assert found.reason is None and known
    assert_near(found, known)
    for x in found:
        assert max(x.start_interval[1] - x.start_interval[0], x.end_interval[1] - x.end_interval[0]) <= 1e-12
    swapped = fc.contact_intervals(clip(), body)
    assert_near(swapped, known)


def test_a_convex_polyhedron_as_exact_arithmetic_tells():
    cube = fc.examples.box((2, 2, 2))
    egg = primitives.ellipsoid((1, 2, "1/2")).translated((-4, "1/3", "1/5")).moving(fc.Translation((8, 1, 0)))
    (known,) = fc.contact_intervals(egg, cube, exact=True)
    (x,) = intervals(Query(egg, cube, fmpq(0), fmpq(1)))
    assert x.start_interval[0] <= known.start <= x.start_interval[1]
    assert x.end_interval[0] <= known.end <= x.end_interval[1]


def test_a_surface_and_an_edge_by_hand():
    sheet = fc.Polyhedron([(-9, -9, 0), (9, -9, 0), (0, 9, 0)], [(0, 1, 2)])
    rod = fc.Polyhedron([(-9, 0, 0), (9, "1/3", 0)], [], edges=[(0, 1)])
    ball = BALL.translated((0, 0, 3)).moving(fc.Translation((0, 0, -8)))
    (x,) = fc.contact_intervals(ball, sheet)
    assert (x.start, x.end) == pytest.approx((2 / 8, 4 / 8), abs=1e-12)
    (y,) = fc.contact_intervals(rod, ball)
    away = np.linalg.norm(np.cross((18, 1 / 3, 0), (-9, 0, 0))) / np.hypot(18, 1 / 3)
    half = np.sqrt(1 - away**2)
    assert (y.start, y.end) == pytest.approx(((3 - half) / 8, (3 + half) / 8), abs=1e-12)


@pytest.mark.thorough
def test_what_only_grazes_is_exact():
    ball = BALL.translated((-5, 0, 2)).moving(fc.Translation((10, 0, 0)))  # its lowest point slides along both arms
    certified = fc.contact_intervals(ball, clip(), method="certified")
    assert certified.status is fc.Status.UNDECIDED and certified.reason == "precision"
    assert 0.199 < certified.free_until <= 0.2
    for found in (fc.contact_intervals(ball, clip()), fc.contact_intervals(clip(), ball, exact=True)):
        assert [(x.start, x.end) for x in found] == [(0.2, 0.3), (0.7, 0.8)]


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["small ball across", "pin falls in", "cone turns"])
def test_exact_ends_are_those_of_its_parts(name):
    body = CLIP_SCENES[name]
    if name == "cone turns":
        body = body.body.moving(fc.Rotation((1, 0, 0), degrees=180))
    parts = [x for arm in ARMS for x in fc.contact_intervals(body, arm, exact=True)]
    starts, ends = {x.start_exact for x in parts}, {x.end_exact for x in parts}
    found = fc.contact_intervals(body, clip(), exact=True)
    assert found.reason is None and len(found) >= 1
    assert_near(found, joined((body, arm) for arm in ARMS))
    for x in found:
        assert x.start_exact in starts and x.end_exact in ends


@pytest.mark.thorough
def test_a_box_within_a_hollow_ball_is_free_between_two_exact_contacts():
    plate = fc.examples.box((2, 2, 2))
    block = fc.Polyhedron(plate.vertices, plate.triangles[:-1])  # without one triangle: a surface, no solid
    for mesh in (plate, block):
        shell = (fc.sphere(4) - fc.sphere(3)).translated((-10, 0, 0)).moving(fc.Translation((20, 0, 0)))
        found = fc.contact_intervals(mesh, shell, exact=True)
        leaves = (10 - (np.sqrt(7) - 1)) / 20  # all corners are within 3 of its middle when (1 + |x|)^2 + 2 <= 9
        assert_near(found, [(0.25, leaves), (1 - leaves, 0.75)])
        assert found.intervals[0].start_exact == Fraction(1, 4)


def test_a_solid_that_is_held_is_in_contact():
    cage = clip()
    grain = primitives.sphere("1/8").translated((0, "-3/2", 0)).moving(fc.Translation((0, 0, 4)))
    (x,) = fc.contact_intervals(cage, grain, exact=True)  # from inside, out through the top
    assert (x.start, x.end) == (0.0, 9 / 32)


def test_intervals_of_one_instant_under_turns_and_in_the_last_one():
    """Found by random scenes: doubles tell neither."""
    third = fc.Polyhedron([(0, 0, 0), (12, 0, 0)], [], edges=[(0, 1)]).translated((0, 0, 3))
    wheel = primitives.sphere(1).translated((6, 0, 0)).moving(fc.Rotation((0, 1, 0), (6, 0, 2), degrees=360))
    assert [(x.start, x.end) for x in fc.contact_intervals(wheel, third)] == [(0.25, 0.75)]
    point = fc.Polyhedron([(0, 0, 3)], []).moving(fc.Translation((0, 0, -2)))
    cup = primitives.sphere(1) - primitives.sphere("1/2").translated((0, 0, "-3/4"))
    assert [(x.start, x.end) for x in fc.contact_intervals(point, cup)] == [(1.0, 1.0)]


def test_too_many_triangles_near():
    x = np.linspace(-1, 1, 9)
    vertices = [(p, q, 0.01 * p * q) for p in x for q in x]
    quads = [(9 * i + j, 9 * i + j + 9, 9 * i + j + 10) for i in range(8) for j in range(8)]
    quads += [(9 * i + j, 9 * i + j + 10, 9 * i + j + 1) for i in range(8) for j in range(8)]
    sheet = fc.Polyhedron(vertices, quads)
    ball = primitives.sphere(9).translated((0, 0, 11)).moving(fc.Translation((0, 0, -4)))
    with pytest.raises(fc.UnsupportedPair, match="128 triangles come near"):
        fc.contact_intervals(sheet, ball, exact=True)
    assert fc.contact_intervals(sheet, ball).status is fc.Status.CONTACT


@pytest.mark.share(4)
@pytest.mark.parametrize("other", [fc.Polyhedron([(0, 0, 0)], []), fc.examples.box((2, 2, 2)), BALL, clip()])
def test_an_endless_solid_far_from_the_other_body(other):
    """Found by random scenes: the part of it near the other body is empty, and raised "solid is empty"."""
    sheets = fc.quadric([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 144]])  # x^2 + y^2 + 144 <= z^2
    for shift, status in (((1, 0, 0), fc.Status.FREE), ((0, 0, 40), fc.Status.CONTACT)):
        moving = other.moving(fc.Translation(shift))
        assert fc.first_contact(moving, sheets).status is status
        assert fc.contact_intervals(moving, sheets).status is status


def test_status_and_refusals():
    deep = SMALL.translated((0, "-3/2", 0)).moving(fc.Translation((0, 9, 0)))  # starts inside the clip
    found = fc.contact_intervals(deep, clip())
    (x,) = found
    assert found.status is fc.Status.INITIAL_CONTACT and x.start == 0.0 and x.end == pytest.approx(0.75 / 9, abs=1e-12)
    high = SMALL.translated((0, 0, 5)).moving(fc.Translation((9, 0, 0)))
    assert fc.contact_intervals(high, clip()).status is fc.Status.FREE
    assert fc.contact_intervals(high, clip(), exact=True).status is fc.Status.FREE
    with pytest.raises(fc.UnsupportedPair, match="no exact contact equations"):
        fc.contact_intervals(high.body.moving(fc.Screw((1, 0, 0), degrees=90, advance=1)), clip(), exact=True)
    few = fc.contact_intervals(deep, clip(), budget=2)
    assert few.status is fc.Status.UNDECIDED and few.reason == "budget"
    for budget in (0, 1, 5):  # triangles that come near are not all known
        few = fc.contact_intervals(deep, clip(), budget=budget, exact=True)
        assert few.status is fc.Status.UNDECIDED and few.reason == "budget" and few.free_until == 0.0


def test_what_is_not_told_of_a_triangle_is_not_taken_for_apart(monkeypatch):
    ball = BALL.translated((-5, 0, 2.5)).moving(fc.Translation((10, 0, 0)))
    assert fc.contact_intervals(ball, clip(), exact=True).status is fc.Status.FREE
    monkeypatch.setattr(Standing, "primitive", lambda self, k: Place(None))
    assert fc.contact_intervals(ball, clip(), exact=True).status is fc.Status.FREE  # doubles tell of all at once
    left = [Open(k, 0, 0.0) for k in range(len(clip().triangles))]
    monkeypatch.setattr(MeshSearch, "at_start", lambda self, window: Swept("open", window.first))
    monkeypatch.setattr(MeshSearch, "near", lambda self, window: Swept("open", window.first, open=left))
    with pytest.raises(fc.UnsupportedPair, match="not proved whether they touch"):
        fc.contact_intervals(ball, clip(), exact=True)


def test_a_cylinder_in_two_halves_along_a_wall_of_many_triangles():
    """It touches the wall along a line until that passes the wall's end at 1/2; planes and curves of 300 triangles
    were looked at one by one, for a minute."""
    halves = [fc.cylinder(Fraction(3, 2), 2).translated((0, 0, z)) for z in (-1, 1)]
    rod = (halves[0] | halves[1]).translated((Fraction(-1, 2), Fraction(-7, 2), Fraction(-1, 2)))
    plain = fc.cylinder(Fraction(3, 2), 4).translated((Fraction(-1, 2), Fraction(-7, 2), Fraction(-1, 2)))
    wall = fc.Polyhedron.from_trimesh(trimesh.creation.box((2, 4, 3)).subdivide().subdivide())
    assert len(wall.triangles) == 192
    away = fc.Translation((-1, 0, 0))
    for body in (rod, plain):
        found = fc.contact_intervals(body.moving(away), wall)
        assert [(x.start, x.end) for x in found] == [(0.0, 0.5)]
        assert found.stats.ways[-1].way == "soon exactly"


@pytest.mark.thorough
def test_what_is_soon_told_exactly_is_asked_first():
    """Doubles took a third of a second for an edge that turns away from a cylinder on which it lay, and told none."""
    edge = fc.Polyhedron([(1, 0, -1), (1, 0, 1)], [], edges=[[0, 1]])
    away = edge.moving(fc.Rotation((0, 0, 1), (-5, 0, 0), turns="1/4"))
    found = fc.contact_intervals(primitives.cylinder(1, 4), away)
    assert found.stats.ways[-1].way == "soon exactly"
    assert [(x.start, x.end) for x in found] == [(0.0, 0.0)]
    many = fc.contact_intervals(clip().moving(fc.Screw((0, 0, 1), degrees=360, advance=2)), SMALL.translated((2, 1, 0)))
    assert [asked.way for asked in many.stats.ways] == ["soon exactly", "by triangles"]
