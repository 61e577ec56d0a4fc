"""Ruled surfaces against polyhedra, in exact arithmetic: planar pieces as meshes, solids with pieces inside, laws."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from amount import amount
from contact_places import assert_place
from firstcontact.errors import UnsupportedPair

SADDLE = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)", name="saddle")
BOX = fc.examples.box((2, 2, 2)).translated((3, "1/4", "1/8"))
TURN = fc.Rotation((0, 1, 0), point=(2, 0, 0), degrees=200)


def tetrahedron(rng):
    points = rng.integers(-8, 9, (4, 3)) / 8
    if abs(np.linalg.det(points[1:] - points[0])) < 0.1:
        return tetrahedron(rng)
    return fc.Polyhedron(points, [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])


@pytest.mark.share(2)
@pytest.mark.parametrize("seed", range(amount(12)))
def test_a_planar_piece_is_the_mesh_of_two_triangles(seed):
    rng = np.random.default_rng(seed)
    solid = tetrahedron(rng)
    piece = fc.RuledSurface("(u, 0, 0)", "(u, 1, 0)")
    mesh = fc.Polyhedron([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [[0, 1, 2, 3]])
    if seed % 2:
        motion = fc.Rotation(rng.integers(1, 5, 3), point=rng.integers(-3, 4, 3), degrees=300)
    else:
        motion = fc.Translation(2 * rng.integers(-3, 4, 3) + 1)
    expected = fc.contact_intervals(mesh.moving(motion), solid, exact=True)
    found = fc.contact_intervals(piece.moving(motion), solid, exact=True)
    assert found.status is expected.status
    for x, y in itertools.zip_longest(found, expected):
        assert x.start == pytest.approx(y.start, abs=1e-15) and x.end == pytest.approx(y.end, abs=1e-15)
    hit, known = (fc.first_contact(solid, b.moving(motion)) for b in (piece, mesh))
    assert (hit.status, hit.time) == (known.status, known.time)
    for x in (hit, known):
        assert_place(x, x.a, x.b)


def test_a_solid_owns_its_interior():
    hall = fc.examples.box((4, 4, 4))
    way = fc.Translation((20, 0, 0))
    (interval,) = fc.contact_intervals(SADDLE.translated((-10, 0, 0)).moving(way), hall, exact=True)
    assert (interval.start_exact, interval.end_exact) == (Fraction(7, 20), Fraction(3, 5))
    inside = fc.first_contact(SADDLE, hall.moving(way))
    assert inside.status is fc.Status.INITIAL_CONTACT and inside.initial == "containment"
    assert fc.first_contact(SADDLE.translated((-2.5, 0, 0)), hall.moving(way)).initial == "overlapping"
    shell = fc.Polyhedron(hall.vertices, [t for t in hall.triangles.tolist()], solid=False)
    leaving = fc.first_contact(SADDLE.moving(way), shell)
    assert (leaving.status, leaving.time) == (fc.Status.CONTACT, 0.05)


def test_the_elements_of_the_polyhedron_are_named():
    hit = fc.first_contact(SADDLE.moving(TURN), BOX)
    assert (hit.element_a.kind, hit.element_a.index) == ("end_ruling", 1)
    assert (hit.element_b.kind, hit.element_b.index) == ("edge", 6)
    assert np.allclose(hit.point[[0, 2]], (2, 1.125))
    swapped = fc.first_contact(BOX, SADDLE.moving(TURN))
    assert (swapped.time, swapped.element_a, swapped.element_b.kind) == (
        hit.time, fc.Element("edge", "box", 6, "box"), "end_ruling")  # fmt: skip
    assert np.allclose(swapped.normal, -hit.normal)


def test_no_sampled_point_is_inside_while_free():
    hit = fc.first_contact(SADDLE.moving(TURN), BOX)
    u, s = np.meshgrid(np.linspace(0, 1, 60), np.linspace(0, 1, 60))
    points = SADDLE.points(u, s).reshape(-1, 3)

    def deepest(t):
        pose = TURN(t)
        moved = np.abs(points @ pose[:3, :3].T + pose[:3, 3] - (3, 0.25, 0.125)).max(1)
        return moved.min() - 1

    assert all(deepest(t) > 0 for t in np.linspace(0, hit.time - 1e-3, 50))
    assert deepest(hit.time + 0.02) < 0


def test_time_may_run_backwards():
    way = fc.Translation((5, "1/2", "1/3"))
    there = SADDLE.translated((5, "1/2", "1/3"))
    (first,) = fc.contact_intervals(SADDLE.moving(way), BOX, exact=True)
    (last,) = fc.contact_intervals(there.moving(fc.Translation((-5, "-1/2", "-1/3"))), BOX, exact=True)
    assert (1 - last.end_exact, 1 - last.start_exact) == (first.start_exact, first.end_exact)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (fc.Polyhedron([(0, 0, 0), (1, 0, 0)], [], edges=[(0, 1)], name="rod"), "rod has bare edges or points"),
        (fc.Polyhedron([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [[0, 1, 2]], name="sliver"), "triangle 0 has no area"),
    ],
)
def test_refusals(body, message):
    with pytest.raises(UnsupportedPair, match=message):
        fc.first_contact(body, SADDLE.moving(TURN))


@pytest.mark.share(8)
@pytest.mark.parametrize("middle, span", [(-1, (-1, 1)), ("-19/20", (-1, 0)), (3, (1, 3)), ("5/2", (-1, "51/20"))])
@pytest.mark.parametrize("both", [False, True])
def test_times_outside_a_motion_s_own_span(both, middle, span):
    """Found by the soak: what moves on beyond its span was taken to rest there, and told FREE."""
    middle, span = Fraction(middle), [Fraction(t) for t in span]
    speed = 20 if both else 10
    sheet = fc.RuledSurface("(u, 0, 0)", "(u, 1, 0)")
    box = fc.examples.box((2, 2, 2)).translated((0, 0, speed * middle)).moving(fc.Translation((0, 0, -10)))
    sheet = sheet.moving(fc.Translation((0, 0, 10))) if both else sheet
    start, end = max(middle - Fraction(1, speed), span[0]), min(middle + Fraction(1, speed), span[1])
    for x, y in ((box, sheet), (sheet, box)):
        (found,) = fc.contact_intervals(x, y, span, exact=True)
        assert (found.start_exact, found.end_exact) == (start, end)
        assert fc.first_contact(x, y, span, method="algebraic").time == float(start)
