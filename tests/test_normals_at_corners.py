"""Tips that land on corners: of all planes there the normal is of one that parts the bodies."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import firstcontact as fc
from amount import amount

TIPS = np.vstack([np.eye(3), -np.eye(3)])
MOTIONS = {
    "translation": lambda axis, place: fc.Translation(axis),
    "rational": lambda axis, place: fc.RationalMotion.between((0, 0, 0), axis, quat_wxyz=((1, 0, 0, 0),) * 2),
    "rotation": lambda axis, place: fc.Rotation(axis, place, turns=1),
    "screw": lambda axis, place: fc.Screw(axis, place, turns=1, advance=4),
}


def octahedron(rng) -> fc.Polyhedron:
    """Convex, with corners in the lattice."""
    while True:
        m = rng.integers(-2, 3, (3, 3))
        if np.linalg.det(m) > 0.5:
            break
    faces = []
    for signs in itertools.product((0, 3), repeat=3):
        face = [k + s for k, s in enumerate(signs)]
        faces.append(face if sum(signs) % 2 == 0 else face[::-1])
    return fc.Polyhedron(TIPS @ m.T, faces)


def assert_parted(a, motion, b, hit):
    pose = motion(hit.time)
    moved = a.vertices @ pose[:3, :3].T + pose[:3, 3]
    assert ((moved - hit.point) @ hit.normal).min() > -1e-6
    assert ((b.vertices - hit.point) @ hit.normal).max() < 1e-6


@pytest.mark.share(4)
@pytest.mark.parametrize("kind", MOTIONS)
@pytest.mark.parametrize("block", range(amount(6)))
def test_the_normal_parts_convex_bodies(kind, block):
    rng, met = np.random.default_rng([block, 17]), 0
    for _ in range(30):
        a, b, v = octahedron(rng), octahedron(rng), 2 * rng.integers(-6, 7, 3)
        axis, place = [int(x) for x in v], [int(x) for x in rng.integers(-3, 4, 3)]
        if not v.any():
            continue
        motion = MOTIONS[kind](axis, place)
        meeting = b.vertices[rng.integers(6)] - a.vertices[rng.integers(6)] - v / 2
        a = a.translated(meeting.tolist() if kind in ("translation", "rational") else [2.0 * x for x in place])
        hit = fc.first_contact(a.moving(motion), b)
        swapped = fc.first_contact(b, a.moving(motion))
        if hit.status is fc.Status.CONTACT and hit.normal is not None:
            met += hit.multiplicity > 1
            assert_parted(a, motion, b, hit)
            assert swapped.normal == pytest.approx(-hit.normal, abs=1e-9)
    assert met or kind in ("rotation", "screw")


def test_corners_that_pass_each_other_are_parted_by_a_face():
    """Both turn about one line, one 15 times as fast; a corner of the lid meets one of the sheet at 3/14 of the way, as
    it slides in the plane of its own face: the normal pointed into the lid, across a diagonal.  From a soak."""
    lid = fc.Polyhedron(
        [("66/25", "-29/5", "-62/25"), ("84/25", "-21/5", "-38/25"), ("108/25", "-27/5", "-6/25"),
         ("18/5", -7, "-6/5"), ("126/25", "-29/5", "-107/25"), ("144/25", "-21/5", "-83/25"),
         ("168/25", "-27/5", "-51/25"), (6, -7, -3)],
        [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
    ).moving(fc.Rotation((3, 0, 4), (3, 0, -2), turns="15/4"))  # fmt: skip
    sheet = fc.Polyhedron([(0, 0, 3), (3, 0, 4), (3, 2, 3), (0, 2, 4)], [[0, 1, 2], [0, 2, 3]])
    sheet = sheet.moving(fc.Rotation(("3/2", 0, 2), (3, 0, -2), turns="1/4"))
    hit = fc.first_contact(lid, sheet)
    assert hit.status is fc.Status.CONTACT and abs(hit.time - 3 / 14) < 1e-12
    there = [np.array(x.motion(hit.time)) for x in (lid, sheet)]
    corners = [np.array(x.body.vertices, float) @ p[:3, :3].T + p[:3, 3]
               for x, p in zip((lid, sheet), there, strict=True)]  # fmt: skip
    heights = [(c - hit.point) @ hit.normal for c in corners]  # the normal is from the sheet towards the lid
    assert heights[0].min() > -1e-9 and heights[1].max() < 1e-9


def test_a_ridge_that_comes_down_on_a_point_from_inside_is_not_turned():
    """The point meets the roof's ridge from below: no plane parts them, and the way tells the side.  From a soak."""
    roof = fc.Polyhedron([(0, 0, 0), (2, 0, -1), (2, 2, 0), (0, 2, -1)], [[0, 1, 2], [0, 2, 3]])
    way = np.array([-10, -2, -8])
    for dots in ([(1, 1, 0)], [(1, 1, 0), (-2, 1, -4), (1, 2, 0)]):
        points = fc.Polyhedron(np.array(dots) + 4 * way, [])
        hit = fc.first_contact(roof.moving(fc.Translation(way.tolist())), points, (0, 8))
        assert hit.time == 4 and hit.multiplicity == 2
        assert hit.normal @ way < 0
        swapped = fc.first_contact(points, roof.moving(fc.Translation(way.tolist())), (0, 8))
        assert swapped.normal == pytest.approx(-hit.normal)


def test_the_normal_parts_a_solid_box_and_an_octahedron():
    """Corner to corner, asked as curved models: of a face that looks away it pointed along the way, in a quarter."""
    rng, met = np.random.default_rng(281128), 0
    for _ in range(amount(400, 20)):
        size, b, v = rng.integers(1, 4, 3) * 2, octahedron(rng), 2 * rng.integers(-6, 7, 3)
        corners = np.array(list(itertools.product((-1, 1), repeat=3))) * size / 2
        if not v.any():
            continue
        shift = b.vertices[rng.integers(6)] - corners[rng.integers(8)] - v / 2
        motion = fc.Translation(v.tolist())
        a = fc.box(size.tolist()).translated(shift.tolist()).moving(motion)
        hit = fc.first_contact(a, b)
        if hit.status is fc.Status.CONTACT and hit.normal is not None:
            met += hit.multiplicity > 1
            heights = (corners + shift + v * hit.time - hit.point) @ hit.normal
            assert heights.min() > -1e-6 and ((b.vertices - hit.point) @ hit.normal).max() < 1e-6
            assert hit.normal @ v <= 1e-9
            assert fc.first_contact(b, a).normal == pytest.approx(-hit.normal, abs=1e-9)
    assert met > 5
