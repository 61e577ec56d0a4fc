"""Meshes with triangles on a line or in a point, and sheets that fold back on themselves, beside curved solids."""

from __future__ import annotations

import math
import random
from fractions import Fraction as F

import pytest

import firstcontact as fc
from amount import amount

HOLLOW = fc.box((9, 9, 9)) - fc.sphere(2)
BALL = fc.sphere(1).translated((3, 0, 0))
SHELL = BALL - fc.sphere("1/4").translated((3, 0, 0))
WAYS = [{}, {"exact": True}]
RIM = [("-1", "0", "0"), ("1/2", "-1/4", "0"), ("1/2", "1/4", "0")]


def mesh(corners, *triangles):
    return fc.Polyhedron([tuple(map(F, c)) for c in corners], [list(t) for t in triangles])


def first(body, solid, way, velocity):
    return fc.first_contact(body.moving(fc.Translation(velocity)), solid, **way)


# What reaches farthest along x is (1/2, 0, 0), along y (0, 1/4, 1/4) in the first, (1/2, 0, 0) in the others.
FLAT = {
    "folded, with a sliver": (
        [(0, 0, 0), ("1/4", 0, 0), ("1/2", 0, 0), (0, "1/4", "1/4")], [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)]
    ),
    "a sliver": ([(0, 0, 0), ("1/4", 0, 0), ("1/2", 0, 0)], [(0, 1, 2)]),
    "a sliver, its middle last": ([(0, 0, 0), ("1/2", 0, 0), ("1/4", 0, 0)], [(0, 1, 2)]),
    "a sliver, its middle first": ([("1/4", 0, 0), (0, 0, 0), ("1/2", 0, 0)], [(0, 1, 2)]),
    "two corners in one place": ([(0, 0, 0), (0, 0, 0), ("1/2", 0, 0)], [(0, 1, 2)]),
    "a corner named twice": ([(0, 0, 0), ("1/2", 0, 0)], [(0, 0, 1)]),
    "a point": ([("1/2", 0, 0)] * 3, [(0, 1, 2)]),
}  # fmt: skip


@pytest.mark.share(2)
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("kind", FLAT)
def test_in_a_hole(kind, way):
    """The hole's wall is the sphere of radius 2 about the origin."""
    corners, triangles = FLAT[kind]
    body = mesh(corners, *triangles)
    hit = first(body, HOLLOW, way, (4, 0, 0))
    assert hit.time == pytest.approx(3 / 8, abs=1e-12) and hit.point == pytest.approx([2, 0, 0], abs=1e-9)
    aside = math.sqrt(4 - 1 / 16) - 1 / 4 if kind.startswith("folded") else math.sqrt(4 - 1 / 4)
    assert first(body, HOLLOW, way, (0, 4, 0)).time == pytest.approx(aside / 4, abs=1e-12)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("solid", [BALL, SHELL])
@pytest.mark.parametrize("kind", FLAT)
def test_beside_a_ball(kind, solid, way):
    corners, triangles = FLAT[kind]
    body = mesh(corners, *triangles)
    assert first(body, solid, way, (4, 0, 0)).time == pytest.approx(3 / 8, abs=1e-12)
    assert first(body, solid, way, (0, 4, 0)).status is fc.Status.FREE


@pytest.mark.parametrize("kind", [k for k in FLAT if k != "a point"])
def test_a_screw_in_a_hole(kind):
    """It keeps its way along x and turns about it, so the tip on the axis meets the wall first."""
    corners, triangles = FLAT[kind]
    hit = fc.first_contact(mesh(corners, *triangles).moving(fc.Screw((1, 0, 0), degrees=50, advance=4)), HOLLOW)
    assert hit.status is fc.Status.CONTACT and hit.time == pytest.approx(3 / 8, abs=1e-12)


@pytest.mark.parametrize("kind", ["a sliver", "two corners in one place"])
def test_across_a_ball(kind):
    """The middle of the side meets the ball as it passes sideways: at a height of 0, 1 from the middle of the ball."""
    corners, triangles = FLAT[kind]
    body = mesh(corners, *triangles)
    hit = first(body.translated(("11/4", -4, 0)), SHELL, {}, (0, 4, 0))
    assert hit.time == pytest.approx(3 / 4, abs=1e-12) and hit.point == pytest.approx([3, -1, 0], abs=1e-9)
    found = fc.contact_intervals(body.translated(("11/4", -4, 0)).moving(fc.Translation((0, 8, 0))), SHELL, exact=True)
    assert [(x.start_exact, x.end_exact) for x in found.intervals] == [(F(3, 8), F(5, 8))]


@pytest.mark.share(7)
@pytest.mark.parametrize("kind", FLAT)
def test_that_starts_in_the_solid(kind):
    corners, triangles = FLAT[kind]
    body = mesh(corners, *triangles).translated((3, 0, 0))
    hit = first(body, HOLLOW, {}, (1, 0, 0))
    assert hit.status is fc.Status.INITIAL_CONTACT and hit.initial in ("overlapping", "containment")


@pytest.mark.share(3)
@pytest.mark.filterwarnings("ignore:polyhedron. every face")
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("solid", [BALL, SHELL])
@pytest.mark.parametrize("triangles", [[(0, 1, 2)], [(0, 1, 2), (0, 2, 1)]])
def test_the_rim_of_a_sheet_that_covers_itself(triangles, solid, way):
    """Its edge at x = 1/2 meets the ball in the middle: two triangles in one plane lie on one side of it."""
    hit = first(mesh(RIM, *triangles), solid, way, (4, 0, 0))
    assert hit.time == pytest.approx(3 / 8, abs=1e-12) and hit.element_a.kind == "edge"
    assert hit.point == pytest.approx([2, 0, 0], abs=1e-9)
    found = fc.contact_intervals(mesh(RIM, *triangles).moving(fc.Translation((4, 0, 0))), solid, exact=True)
    assert [(x.start_exact, x.end_exact) for x in found.intervals] == [(F(3, 8), 1)]


def test_an_edge_inside_a_flat_face_is_none():
    """Where triangles go on flat across it the face is what touches."""
    corners = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    hit = first(mesh(corners, (0, 1, 2), (0, 2, 3)).translated((3, 0, 4)), SHELL, {"exact": True}, (0, 0, -4))
    assert hit.time_exact == F(3, 4) and hit.element_a.kind == "face"


SPIKES = [  # segments, and whether an inner point of the cube of edge 2 about the origin is on them
    ((0, 0, 0), (3, 0, 0), True),
    ((-2, -2, -2), (2, 1, 2), True),
    ((-2, 0, 1), (2, 0, 1), False),
    ((-2, 0, 0), (0, 0, 2), False),
    ((-2, 0, 1), (2, 0, 0), True),
    ((1, 1, 1), (0, 0, 0), True),
    ((1, 1, 1), (2, 0, 0), False),
    ((-1, -1, -1), (1, 1, 1), True),
]


@pytest.mark.parametrize(("p", "q", "inside"), SPIKES)
@pytest.mark.parametrize("triangle", [(0, 1, 1), (0, 0, 1), (1, 0, 1), (0, 1, 2), (0, 2, 1), (2, 0, 1)])
@pytest.mark.parametrize("beside", [False, True])
def test_a_face_that_is_a_segment_overlaps_what_its_points_are_in(p, q, inside, triangle, beside):
    """It was said to touch where such a mesh is closed, and to overlap along a face if its middle is a corner of it.

    beside: it belongs to a cube far away.
    """
    cube = fc.examples.box((2, 2, 2))
    far = cube.translated((9, 0, 0))
    if beside and 2 in triangle:
        far = fc.Polyhedron(far.vertices, far.triangles, solid=False)
    corners = [*(far.vertices.tolist() if beside else []), p, q, [(x + y) / 2 for x, y in zip(p, q, strict=True)]]
    first = len(corners) - 3
    faces = [*(far.triangles.tolist() if beside else []), [first + k for k in triangle]]
    spike = fc.Polyhedron(corners, faces).moving(fc.Translation((0, 0, 40)))
    for hit in (fc.first_contact(spike, cube), fc.first_contact(cube, spike)):
        assert (hit.status, hit.initial) == (fc.Status.INITIAL_CONTACT, "overlapping" if inside else "touching")


def reaches_inside(p, q):
    """Whether a segment has a point in the open cube |x|, |y|, |z| < 1, by the times at which it is between each pair
    of planes, in fractions."""
    lo, hi, is_open = F(0), F(1), False
    for a, b in zip(map(F, p), map(F, q), strict=True):
        if a == b:
            if not -1 < a < 1:
                return False
            continue
        enter, leave = sorted([(-1 - a) / (b - a), (1 - a) / (b - a)])
        if enter >= lo:
            lo, is_open = enter, True
        hi = min(hi, leave)
        if lo > 1 or leave <= 0:
            return False
    return lo < hi or (lo == hi and not is_open)


@pytest.mark.parametrize("seed", range(amount(60)))
def test_random_segments_that_are_faces(seed):
    rng = random.Random(seed)
    cube = fc.examples.box((2, 2, 2))
    for _ in range(10):
        p, q = ([F(rng.randint(-4, 4), 2) for _ in range(3)] for _ in range(2))
        share = F(rng.randint(0, 4), 4)
        corners = [p, q, [x + share * (y - x) for x, y in zip(p, q, strict=True)]]
        triangle = rng.choice([(0, 1, 1), (1, 0, 0), (0, 1, 2), (2, 1, 0), (1, 2, 0)])
        body = fc.Polyhedron([list(map(str, c)) for c in corners], [triangle])
        hit = fc.first_contact(body, cube) if rng.random() < 0.5 else fc.first_contact(cube, body)
        inside = reaches_inside(p, q)
        if hit.status is fc.Status.FREE:
            assert not inside, (p, q)
        else:
            within = all(-1 < x < 1 for c in (p, q) for x in c)
            kind = "containment" if within else "overlapping" if inside else "touching"
            assert hit.initial == kind, (p, q, triangle, hit.initial)


FOLDED = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]]
"""A tetrahedron pressed flat."""


@pytest.mark.parametrize("up", ["0", "1/1000000000000000000000"])
def test_a_closed_mesh_in_one_plane_holds_nothing(up):
    """What pierces it was said to overlap it; next to a plane doubles do not tell."""
    corners = [*FOLDED[0][:2], (1, 1, up), FOLDED[0][3]]
    flat = up == "0"
    body = fc.Polyhedron(corners, FOLDED[1])
    assert body.solid is not flat
    needle = fc.Polyhedron([(".5", ".5", -1), (".5", ".5", 1)], [], edges=[(0, 1)])
    for hit in (fc.first_contact(body, needle), fc.first_contact(needle, body)):
        assert hit.initial == ("touching" if flat else "overlapping")


STARTS = [  # bodies that share points at rest, and how
    (fc.Polyhedron([("-.1", ".2", 0), (".5", 0, 0)], [], edges=[(0, 1)]), fc.sphere(1), "containment"),
    (fc.Polyhedron([(-2, ".2", 0), (".5", 0, 0)], [], edges=[(0, 1)]), fc.sphere(1), "overlapping"),
    (fc.Polyhedron([(-1, 0, 0), (".5", 0, 0)], [], edges=[(0, 1)]), fc.sphere(1), "overlapping"),
    (fc.Polyhedron([(-1, 0, 0), (1, 0, 0), (0, 1, "1/3")], [[0, 1, 2]]), fc.cylinder(1, 2), "overlapping"),
    (fc.Polyhedron([("-.1", 0, 0), (".1", 0, 0), (0, ".1", "1/3")], [[0, 1, 2]]), fc.cylinder(1, 2), "containment"),
]


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(("mesh_", "model", "kind"), STARTS)
def test_edges_and_corners_on_a_surface_tell_how_bodies_start(mesh_, model, kind, way):
    for hit in (fc.first_contact(mesh_, model, **way), fc.first_contact(model, mesh_, **way)):
        assert (hit.status, hit.initial) == (fc.Status.INITIAL_CONTACT, kind)
