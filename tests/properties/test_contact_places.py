"""Points and normals of contacts of all families, under motions and placements that stretch, shear and mirror."""

from __future__ import annotations

import numpy as np
import pytest

import firstcontact as fc
from amount import amount
from contact_places import assert_parted, assert_place, pose_of
from firstcontact.errors import UnsupportedPair

T = np.linspace(0, 2 * np.pi, 720, endpoint=False)
RING = np.column_stack([np.cos(T), np.sin(T), 0 * T])
BALL = np.concatenate([np.sqrt(1 - z * z) * RING + [0, 0, z] for z in np.cos(np.linspace(0, np.pi, 361))])
QUAD = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0.0)])


def box_points(size):
    return np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * np.array(size) / 2


# Convex bodies by name, with points whose hull is the body, or nearly is.
CONVEX = {
    "point": (fc.Polyhedron([(0, 0, 0)], []), np.zeros((1, 3))),
    "edge": (fc.Polyhedron([(0, 0, 0), (1, 2, 1)], [], edges=[(0, 1)]), np.array([(0, 0, 0), (1, 2, 1.0)])),
    "triangle": (fc.Polyhedron(QUAD[:3] + [0, 0, 1], [(0, 1, 2)]), QUAD[:3] + [0, 0, 1]),
    "mesh": (fc.examples.box((1, 2, 3)), None),
    "box": (fc.box((1, 2, 1)), box_points((1, 2, 1))),
    "sphere": (fc.sphere(1), BALL),
    "ellipsoid": (fc.ellipsoid((1, 2, "1/2")), BALL * [1, 2, 0.5]),
    "cylinder": (fc.cylinder(1, 2), np.concatenate([RING + [0, 0, z] for z in (-1, 1)])),
    "cone": (fc.cone(1, 2), np.concatenate([RING, [(0, 0, 2)]])),
    "sheet": (fc.RuledSurface("(u, 0, 0)", "(u, 1, 0)"), QUAD),
}
CONVEX["mesh"] = CONVEX["mesh"][0], CONVEX["mesh"][0].vertices
PAIRS = [
    ("point", "triangle"), ("edge", "edge"), ("mesh", "mesh"), ("triangle", "mesh"), ("sphere", "ellipsoid"),
    ("cylinder", "box"), ("cone", "sphere"), ("mesh", "sphere"), ("cone", "triangle"), ("point", "cylinder"),
    ("edge", "ellipsoid"), ("cylinder", "edge"), ("sheet", "sphere"), ("sheet", "sheet"), ("cylinder", "sheet"),
    ("sheet", "mesh"), ("triangle", "sheet"), ("box", "cone"),
]  # fmt: skip
NONE_OF_THESE = "no exact scene"


def affine(rng, rigid=False):
    """A map that stretches, shears and may mirror; eighths."""
    m = np.eye(4)
    if rigid:
        return m
    m[:3, :3] *= rng.choice([-2, -1, 0.5, 1, 1, 3], 3)
    m[:3, :3] += np.triu(rng.integers(-8, 9, (3, 3)) / 8, 1)
    return m


def moving(rng, body, kind, where, way):
    """Placed and moved from `where` along `way`, and stretched meanwhile where that is the kind."""
    if kind == "rest":
        return body
    start = affine(rng, rigid=kind == "shift")
    start[:3, 3] = where
    change = np.zeros((4, 4))
    if kind == "affine":
        change[:3, :3] = np.diag(np.diag(start[:3, :3])) * rng.choice([0, 0.5, 2], 3)
        change[:3, :3] += np.triu(rng.integers(-8, 9, (3, 3)) / 8, 1)
    change[:3, 3] = way
    return body.moving(fc.RationalMotion([start, change]))


@pytest.mark.share(21)
@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("seed", range(amount(24, 8)))
def test_affine_poses(pair, seed):
    rng = np.random.default_rng([seed, PAIRS.index(pair)])
    (a, of_a), (b, of_b) = (CONVEX[k] for k in pair)
    kinds = [("affine", "rest"), ("shift", "affine"), ("affine", "affine"), ("rest", "affine"), ("shift", "rest")]
    if "sheet" in pair:  # equations of stretched ones take minutes
        kinds = [("shift", "rest"), ("rest", "shift")]
    kind = kinds[rng.integers(len(kinds))]
    place = affine(rng, rigid=rng.integers(2) == 0)
    b, of_b = b.transformed(place.tolist()), of_b @ place[:3, :3].T
    way = np.array([*rng.integers(-2, 3, 2), rng.choice([-12, 12])]) + rng.integers(-4, 5, 3) / 8
    a = moving(rng, a, kind[0], -way / 2 + rng.integers(-4, 5, 3) / 8, way)
    far = np.zeros(3) if kind[0] != "rest" else -way / 2
    b = moving(rng, b, kind[1], far, np.zeros(3) if kind[0] != "rest" else way)
    try:
        hit = fc.first_contact(a, b)
    except UnsupportedPair:
        pytest.skip(NONE_OF_THESE)
    if hit.status is not fc.Status.CONTACT:
        return
    assert_place(hit, a, b)
    if hit.normal is not None:
        pose_a, pose_b = pose_of(a, hit.time), pose_of(b, hit.time)
        close = 2e-3 if {"sphere", "ellipsoid", "cone", "cylinder"} & set(pair) else 1e-7
        assert_parted(
            hit, of_a @ pose_a[:3, :3].T + pose_a[:3, 3], of_b @ pose_b[:3, :3].T + pose_b[:3, 3], close=close
        )


def test_the_normal_of_a_stretched_triangle():
    tri = fc.Polyhedron([(0, 0, 0), (1, 0, 0), (0, 1, 1)], [(0, 1, 2)])
    grow = fc.RationalMotion([np.eye(4), np.diag([0, 0, 19, 0])])
    point = fc.Polyhedron([("1/4", "1/4", 3)], [])
    true = np.array([0, -12, 1]) / np.sqrt(145)
    assert np.allclose(fc.first_contact(point, tri.moving(grow)).normal, true, atol=1e-12)
    assert np.allclose(fc.first_contact(tri.moving(grow), point).normal, -true, atol=1e-12)


@pytest.mark.parametrize("kind", ["point", "edge"])
def test_bare_points_and_edges_against_the_lowest_ruling_of_a_lying_cylinder(kind):
    """There the forms of a triangle without area leave the place along the ruling open."""
    cylinder = fc.cylinder(2, 8).rotated((1, 0, 0), degrees=90)
    for y in (-3.75, -3, -1, 0, 0.75, 2, 3.75):
        for x in (0, 1.25):
            corners = [(x, y, -6)] if kind == "point" else [(x, y, -6), (x, y + 0.125, -6.5)]
            body = fc.Polyhedron(corners, [], edges=[(0, 1)][: len(corners) - 1])
            hit = fc.first_contact(body.moving(fc.Translation((0, 0, 12))), cylinder)
            assert np.allclose(hit.point, (x, y, -np.sqrt(4 - x * x)), atol=1e-9)


@pytest.mark.parametrize("kind", ["point", "edge"])
@pytest.mark.parametrize("shift", [(1, -0.5), (0, 0), (-0.75, 0.125)])
def test_bare_points_and_edges_land_on_flat_faces_where_they_are_then(kind, shift):
    """A plane alone leaves the place in it open."""
    solids = fc.box((4, 4, 3)), fc.cylinder(2, 3), fc.frustum(2, 1, 3), fc.paraboloid(1, 3), fc.cone(3, 2).rotated(
        (1, 0, 0), degrees=180
    )
    p, v = np.array((0.25, 0.125, 5)), np.array((*shift, -8))
    corners = [p] if kind == "point" else [p, p + (0.125, 0.25, 0.5)]
    body = fc.Polyhedron([tuple(x) for x in corners], [], edges=[(0, 1)][: len(corners) - 1])
    for solid in solids:
        hit = fc.first_contact(body.moving(fc.Translation(tuple(v))), solid)
        assert hit.status is fc.Status.CONTACT and np.allclose(hit.point, p + hit.time * v, atol=1e-9)
        assert abs(hit.point[2] - solid.bounds()[1][2]) < 1e-9
