"""Solids of planes beside meshes: taken as polyhedra they answer as by their surfaces, with their own elements."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from amount import amount
from firstcontact.contact.mesh_model import by_triangles, mesh_intervals
from firstcontact.contact.mesh_model.planar_solid import planar
from firstcontact.exact.numbers import exact_value
from firstcontact.work import Query


def heap(rng, n):
    """Boxes with corners on a grid, joined or cut away in turn."""
    solid = None
    while solid is None or n > 0:
        size, at = rng.integers(1, 4, 3).tolist(), rng.integers(-2, 3, 3).tolist()
        more = fc.box(size).translated([Fraction(2 * p + s, 2) for p, s in zip(at, size, strict=True)])
        try:
            solid = more if solid is None else solid | more if rng.random() < 0.5 else solid - more
        except fc.InputError:  # nothing is left
            continue
        n -= 1
    return solid


def wedge(rng):
    """A box without what is beyond a few planes."""
    solid = fc.box((4, 4, 4))
    for _ in range(rng.integers(1, 4)):
        normal = rng.integers(-3, 4, 3).tolist()
        if any(normal):
            solid &= fc.half_space(normal, Fraction(int(rng.integers(1, 9)), 3))
    return solid


def mesh(rng):
    ball = fc.examples.noisy_sphere(320)
    size = float(np.abs(ball.vertices).max())
    return fc.Polyhedron(ball.vertices * (rng.uniform(0.2, 1) / size), ball.triangles)


@pytest.mark.share(2)
@pytest.mark.parametrize("make", [lambda rng: heap(rng, 4), wedge], ids=["boxes", "wedges"])
def test_the_polyhedron_is_the_solid(make):
    """Its winding numbers at random points, by solid angles, are what the solid's own conditions say there."""
    rng, taken = np.random.default_rng(16), 0
    for _ in range(amount(40, 10)):
        solid = make(rng)
        known = planar(solid)
        if known is None:
            continue
        taken += 1
        points = rng.uniform(-4, 4, (200, 3))
        corners = known.polyhedron.vertices[known.polyhedron.triangles][None] - points[:, None, None]
        p, q, r = np.moveaxis(corners, 2, 0)
        lengths = np.linalg.norm(corners, axis=-1)
        volume = np.einsum("nki,nki->nk", p, np.cross(q, r))
        beside = lengths.prod(axis=-1) + sum(
            np.einsum("nki,nki->nk", x, y) * lengths[..., k] for x, y, k in ((p, q, 2), (q, r, 0), (r, p, 1))
        )
        winding = (2.0 * np.arctan2(volume, beside)).sum(axis=1) / (4.0 * np.pi)
        assert np.array_equal(winding > 0.5, solid.contains(points))
        assert len(known.polyhedron.vertices) == len(solid.vertices)
        assert set(known.face_of) == {face.index for face in solid.faces}
        assert set(known.edge_of.values()) == {edge.index for edge in solid.edges}
    assert taken >= amount(40, 10) // 2


MOTIONS = {
    "translation": lambda rng: fc.Translation(rng.integers(-9, 10, 3).tolist()),
    "rotation": lambda rng: fc.Rotation((0, 1, 2), rng.integers(-3, 4, 3).tolist(), degrees=int(rng.integers(20, 300))),
    "screw": lambda rng: fc.Screw((1, 0, 2), (1, 0, 1), degrees=300, advance=int(rng.integers(9))),
}


@pytest.mark.thorough
@pytest.mark.parametrize("kind", MOTIONS)
def test_answers_are_those_by_triangles(kind):
    rng, seen, k = np.random.default_rng(61), [], 0
    while seen.count(fc.Status.CONTACT) < amount(12, 6):
        k += 1
        solid, ball, motion = heap(rng, 3).named("solid"), mesh(rng).named("ball"), MOTIONS[kind](rng)
        ball = ball.translated(rng.integers(-5, 6, 3).tolist())
        a, b = (ball.moving(motion), solid) if k % 2 else (solid.moving(motion), ball)
        hit = fc.first_contact(a, b)
        other = by_triangles.first(Query(a, b, exact_value(0.0), exact_value(1.0)))
        assert hit.status is other.status or fc.Status.UNDECIDED in (hit.status, other.status)
        if hit.status is fc.Status.INITIAL_CONTACT:
            continue
        seen.append(hit.status)
        if hit.status is fc.Status.CONTACT and other.time is not None:
            assert other.time_interval[0] - 1e-11 <= hit.time <= other.time_interval[1] + 1e-11
            own = hit.element_a if a is not ball and not k % 2 else hit.element_b
            assert own.body == "solid"
            names = {"face": solid.faces, "edge": solid.edges, "vertex": solid.vertices}[own.kind]
            assert own.label == names[own.index].name
        if hit.status is fc.Status.CONTACT and seen.count(hit.status) < 3:
            every = fc.contact_intervals(a, b)
            slow = mesh_intervals.intervals(Query(a, b, exact_value(0.0), exact_value(1.0)))
            if fc.Status.UNDECIDED not in (every.status, slow.status):
                times = [[(x.start, x.end) for x in found] for found in (every, slow)]
                assert np.allclose(*times, rtol=0, atol=1e-9)
    assert fc.Status.FREE in seen


def test_a_plate_with_windows_names_its_own_faces_and_edges():
    plate = fc.box((6, 6, 1))
    for x, y in itertools.product((-2, 0, 2), repeat=2):
        plate -= fc.box((1, 1, 2)).translated((x, y, 0))
    plate = plate.named("plate")
    assert planar(plate) is not None
    pin = fc.examples.noisy_sphere(320)
    size = float(np.abs(pin.vertices).max())
    ball = fc.Polyhedron(pin.vertices / (4 * size), pin.triangles, name="pin")
    pin = ball.translated((0, 0, 2))
    through = fc.first_contact(pin.moving(fc.Translation((0, 0, -4))), plate)
    assert through.status is fc.Status.FREE and through.stats.ways[0].way == "as polyhedra"
    beside = fc.first_contact(pin.translated((1, 1, 0)).moving(fc.Translation((0, 0, -4))), plate, exact=True)
    lowest = 2 + Fraction(float(ball.vertices[:, 2].min()))
    assert beside.time_exact == (lowest - Fraction(1, 2)) / 4
    assert beside.element_b.kind == "face" and plate.faces[beside.element_b.index].carrier.normal[2] > 0


def deepest(box, triangles):
    """How deep any of the triangles (n, 3, 3) is in a box (lo, hi); negative where axes separate all of them."""
    lo, hi = np.array(box, float)
    corners = np.array(list(itertools.product(*zip(lo, hi, strict=True))))
    sides = np.roll(triangles, -1, axis=1) - triangles
    axes = [np.broadcast_to(axis, (len(triangles), 3)) for axis in np.eye(3)]
    axes += [np.cross(sides[:, 0], sides[:, 1]), *(np.cross(axis, sides[:, k]) for axis in np.eye(3) for k in range(3))]
    depths = []
    for axis in axes:
        length = np.linalg.norm(axis, axis=1)
        unit = axis / np.where(length > 1e-9, length, 1.0)[:, None]
        p, q = unit @ corners.T, np.einsum("nki,ni->nk", triangles, unit)
        depth = np.minimum(p.max(axis=1) - q.min(axis=1), q.max(axis=1) - p.min(axis=1))
        depths.append(np.where(length > 1e-9, depth, np.inf))
    return np.min(depths, axis=0).max()


@pytest.mark.thorough
def test_separating_axes_part_boxes_from_the_mesh_until_they_meet():
    """A truth that shares nothing with the library: boxes by their corners, triangles, and where a shift takes them."""
    rng, seen, taken = np.random.default_rng(2011), [], 0
    while seen.count(fc.Status.CONTACT) < amount(30, 30):
        lows = rng.integers(-3, 3, (3, 3))
        boxes = [(lo, lo + rng.integers(1, 4, 3)) for lo in lows]
        parts = [fc.box((hi - lo).tolist()).translated([Fraction(int(x), 2) for x in lo + hi]) for lo, hi in boxes]
        ball = mesh(rng).translated(rng.integers(-7, 8, 3).tolist())
        vector = rng.integers(-9, 10, 3)
        hit = fc.first_contact(ball.moving(fc.Translation(vector.tolist())), parts[0] | parts[1] | parts[2])

        def depth(t, boxes=boxes, ball=ball, vector=vector):
            return max(deepest(box, (ball.vertices + t * vector)[ball.triangles]) for box in boxes)

        if hit.status is fc.Status.INITIAL_CONTACT:
            continue
        taken += "as polyhedra" in [way.way for way in hit.stats.ways]  # not where four faces have one edge
        seen.append(hit.status)
        until = 1.0 if hit.status is fc.Status.FREE else hit.time - 1e-9
        assert max(map(depth, np.linspace(0.0, until, 30))) <= 1e-12
        if hit.status is fc.Status.CONTACT:
            assert depth(hit.time) >= -1e-9
    assert fc.Status.FREE in seen and 4 * taken > len(seen)
