"""The generated encounters: well-formed bodies, the first contact their construction proves, and the reference's."""

import numpy as np
import pytest

import firstcontact as fc
import naive
from firstcontact import examples
from test_examples import directed_edges

TURNING = pytest.mark.parametrize("turning", [False, True], ids=["translation", "rotation"])
RODS = {
    "layered reguli": lambda n, **how: examples.layered_reguli(n, **how),
    "tilted reguli": lambda n, **how: examples.layered_reguli(n, tilted=True, **how),
    "combs": lambda n, **how: examples.near_miss_combs(n, **how),
    "woven reguli": lambda n, **how: examples.woven_reguli(n, **how),
    "woven rods": lambda n, **how: examples.woven_rods(n, **how),
}
FACETS = {
    "slats": lambda n, **how: examples.slats_over_points(n, **how),
    "plates": lambda n, **how: examples.tangent_plates(n, **how),
}
PLANTED = {
    "layered reguli": lambda n, **how: examples.layered_reguli(n, planted=True, **how),
    "tilted reguli": lambda n, **how: examples.layered_reguli(n, tilted=True, planted=True, **how),
    "combs": lambda n, **how: examples.near_miss_combs(n, planted=True, **how),
    "plates": lambda n, **how: examples.tangent_plates(n, planted=True, **how),
}
EVERY = [(name, turning) for name in RODS | FACETS for turning in (False, True)] + [
    ("hyperboloids", True),
    ("shells", True),
    ("convex", True),
]


def made(name, n, turning, **how):
    if name == "hyperboloids":
        return examples.nested_hyperboloids(n, **how)
    if name == "shells":
        return examples.nested_shells(n, **how)
    if name == "convex":
        return examples.convex_pair(n, **how)
    return (RODS | FACETS)[name](n, turning=turning, **how)


def answer(encounter, **how):
    return fc.first_contact(encounter.moving, encounter.resting, **how)


@pytest.mark.share(4)
@pytest.mark.parametrize("name, turning", EVERY, ids=str)
def test_the_library_finds_what_the_reference_finds(name, turning):
    """All pairs in exact arithmetic, on few rods, points and facets."""
    scene = made(name, 20 if name == "convex" else 12, turning, seed=5)
    if turning:
        motion, until = naive.Turn(axis=(0, 0, 1), point=(0, 0, 0), radians=1), float(scene.motion.angle)
        if name == "hyperboloids":
            motion, until = naive.Turn(axis=(0, 0, 1), point=(0, 0, 0), turns=1), 1
    else:
        motion, until = naive.Shift(tuple(scene.motion.vector)), 1
    bodies = [part for body in (scene.a, scene.b) for part in (body.vertices, body.edges, body.triangles)]
    status, time, nearest = naive.first_contact(*bodies, motion, until, scene.a.solid, scene.b.solid)
    hit = answer(scene)
    assert hit.status.name == status == "CONTACT"
    unit = until if turning else 1.0
    assert hit.time == pytest.approx(nearest / unit, rel=1e-13)


@TURNING
@pytest.mark.parametrize("closed", [False, True], ids=["open", "closed"])
@pytest.mark.parametrize("name", PLANTED)
def test_planted_pairs_meet_first(name, turning, closed):
    """Also where the reference would take too long; closed rods meet with their ridges, spikes with their tips."""
    scene = PLANTED[name](40, turning=turning, closed=closed, seed=1)
    open_one = PLANTED[name](40, turning=turning, seed=1)
    hit, i, j = answer(scene), *scene.first
    alone = [_only(open_one.a, i, name), _only(open_one.b, j, name)]
    assert hit.time == fc.first_contact(alone[0].moving(scene.motion), alone[1]).time
    if not closed:
        assert (hit.element_a.index, hit.element_b.index) == (i, j)


def _only(body, i, name):
    """The i-th rod, point or facet of a body."""
    if name != "plates":
        return fc.Polyhedron(body.vertices[body.edges[i]], [], edges=[(0, 1)])
    if len(body.triangles) == 0:
        return fc.Polyhedron(body.vertices[[i]], [])
    return fc.Polyhedron(body.vertices[body.triangles[i]], [(0, 1, 2)])


@pytest.mark.parametrize("closed", [False, True], ids=["open", "closed"])
def test_hyperboloids_touch_at_the_planted_rods_alone(closed):
    scene = examples.nested_hyperboloids(40, closed=closed)
    hit = answer(scene)
    edges = 12 if closed else 1
    assert (hit.element_a.index // edges, hit.element_b.index // edges) == scene.first
    assert answer(examples.nested_hyperboloids(40, planted=False, closed=closed)).status is fc.Status.FREE


@pytest.mark.parametrize("name", [*RODS, *FACETS, "hyperboloids"])
def test_closed_ones_are_solids_that_start_apart(name):
    turning = name == "hyperboloids"
    scene = made(name, 30, turning, closed=True)
    for body in (scene.a, scene.b):
        faces, corners = body.triangles, body.vertices
        assert body.solid and body.closed
        edges = directed_edges(faces)
        key, reverse = edges @ [len(corners), 1], edges @ [1, len(corners)]
        assert len(np.unique(key)) == len(key) and np.array_equal(np.sort(key), np.sort(reverse))
        a, b, c = (corners[faces[:, k]] for k in range(3))
        middle = corners.reshape(30, -1, 3).mean(axis=1).repeat(len(faces) // 30, axis=0)
        assert (np.einsum("ij,ij->i", a - middle, np.cross(b - a, c - a)) > 0.0).all(), "every triangle looks outward"
    assert answer(scene).status is fc.Status.CONTACT


def test_a_seed_names_one_encounter():
    first, again, other = (examples.woven_rods(50, seed=s) for s in (3, 3, 4))
    assert np.array_equal(first.a.vertices, again.a.vertices) and np.array_equal(first.b.vertices, again.b.vertices)
    assert not np.array_equal(first.a.vertices, other.a.vertices)


@TURNING
@pytest.mark.parametrize("name", [*RODS, "plates"])
def test_boxes_test_nearly_all_pairs(name, turning):
    """That is what they are for."""
    scene = made(name, 100, turning)
    assert fc.first_contact(scene.moving, scene.resting, engine="boxes").stats.pair_tests > 0.9 * 100**2
