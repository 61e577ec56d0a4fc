"""Flat links: prisms that move in one plane by several joints, against separating axes of their outlines."""

from __future__ import annotations

import numpy as np
import pytest
from flint import fmpq
from scipy.optimize import brentq

import firstcontact as fc
from firstcontact.contact.advancing import Apart
from firstcontact.contact.polyhedra.prisms import in_one_plane
from firstcontact.work import Query
from mechanism import oracle

TILT = np.array([[2, -1, 2], [2, 2, -1], [-1, 2, 2]])
"""A turn, three times as large."""
TILTED = [*([*row, 0] for row in TILT.tolist()), [0, 0, 0, 1]]
SAMPLES = 600


def ring(rng):
    """A convex polygon of 3 to 6 corners about the origin, counterclockwise: chords of an ellipse."""
    angles = np.sort(rng.uniform(0, 2 * np.pi, int(rng.integers(3, 7))))
    while np.diff(angles, append=angles[0] + 2 * np.pi).max() > 3:
        angles = np.sort(rng.uniform(0, 2 * np.pi, len(angles)))
    return np.column_stack([np.cos(angles), 0.5 * np.sin(angles)]).round(3)


def link(corners, place, low, high):
    """A prism over a polygon, or a sheet, at a place of the plane."""
    at = corners + place
    n, k = len(at), np.arange(len(at))
    if low == high:
        return fc.Polyhedron(np.column_stack([at, np.full(n, low)]), [k.tolist()])
    points = np.concatenate([np.column_stack([at, np.full(n, z)]) for z in (low, high)])
    walls = np.column_stack([k, (k + 1) % n, (k + 1) % n + n, k + n]).tolist()
    return fc.Polyhedron(points, [k[::-1].tolist(), (k + n).tolist(), *walls])


def gap(p, q):
    """How far convex polygons are apart along the best of their sides' normals; negative where they overlap."""
    found = []
    for one, other in ((p, q), (q, p)):
        side = np.roll(one, -1, axis=0) - one
        normal = np.column_stack([side[:, 1], -side[:, 0]]) / np.linalg.norm(side, axis=1)[:, None]
        found.append((normal @ other.T).min(axis=1) - np.einsum("ni,ni->n", normal, one))
    return np.concatenate(found).max()


def planar(angle, point):
    """(3, 3) of a turn of the plane, in degrees."""
    return oracle.turn((0, 0, 1), (*point, 0), angle)[np.ix_([0, 1, 3], [0, 1, 3])]


class Scene:
    """Two links: one on two joints, the other on one; joints' values are linear over (0, 1)."""

    def __init__(self, rng, heights, tilted=False):
        self.rings = ring(rng) + (0.75, 0), ring(rng) + (1.5, 1.25)
        self.points = (0.0, 0.0), (0.5, 0.0), (1.75, 1.0)
        self.ends = rng.uniform(-150, 150, 3).round(1)
        one, two = (link(r, 0, *h) for r, h in zip(self.rings, heights, strict=True))
        axis, points = (0, 0, 1), [(*p, 0) for p in self.points]
        if tilted:
            one, two = (x.transformed(TILTED) for x in (one, two))
            axis, points = tuple(TILT[:, 2]), [tuple(TILT @ p) for p in points]
        far = fc.examples.box((0.1, 0.1, 0.1)).translated((0, 0, -9))
        links = {"ground": far, "crank": far.translated((0, 0, -9)), "one": one, "two": two}
        joints = [
            fc.Joint("a", "revolute", "ground", "crank", axis=axis, point=points[0]),
            fc.Joint("b", "revolute", "crank", "one", axis=axis, point=points[1]),
            fc.Joint("c", "revolute", "ground", "two", axis=axis, point=points[2]),
        ]
        values = {name: [0, end] for name, end in zip("abc", self.ends, strict=True)}
        course = fc.Mechanism(links, joints).course([0, 1], values)
        self.one, self.two = course.bodies["one"][0], course.bodies["two"][0]

    def gap(self, t):
        a, b, c = self.ends * t
        first = planar(a, self.points[0]) @ planar(b, self.points[1])
        second = planar(c, self.points[2])
        return gap(*(r @ m[:2, :2].T + m[:2, 2] for r, m in zip(self.rings, (first, second), strict=True)))

    def truth(self):
        """Times of contact by samples and bisection."""
        times = np.linspace(0, 1, SAMPLES)
        gaps = np.array([self.gap(t) for t in times])
        ends = [brentq(self.gap, *times[k : k + 2], xtol=1e-14) for k in np.flatnonzero(np.diff(np.sign(gaps)))]
        if gaps[0] <= 0:
            ends.insert(0, 0.0)
        if gaps[-1] <= 0:
            ends.append(1.0)
        return np.reshape(ends, (-1, 2)), np.abs(gaps).min()


HEIGHTS = {
    "the same": ((0, 0.25), (0, 0.25)),
    "one on the other": ((0, 0.25), (0.25, 0.5)),
    "a common floor": ((0, 0.25), (0, 0.5)),
    "sheets": ((0.125, 0.125), (0.125, 0.125)),
    "a sheet on a prism": ((0.25, 0.25), (0, 0.25)),
}


@pytest.mark.share(9)
@pytest.mark.parametrize("heights", HEIGHTS.values(), ids=HEIGHTS)
@pytest.mark.parametrize("seed", range(4))
def test_flat_links_touch_where_their_outlines_do(heights, seed):
    scene = Scene(np.random.default_rng(seed), heights, tilted=seed == 3)
    expected, least = scene.truth()
    assert least > 1e-6  # else the samples may miss a graze
    found = fc.contact_intervals(scene.one, scene.two)
    assert found.status is not fc.Status.UNDECIDED, found
    assert [(x.start, x.end) for x in found] == [pytest.approx(x, abs=1e-11) for x in expected]
    for interval in found:
        for (lo, hi), t in ((interval.start_interval, interval.start), (interval.end_interval, interval.end)):
            assert lo <= t <= hi <= lo + 1e-9
            assert scene.gap(t) == pytest.approx(min(scene.gap(t), 0.0), abs=1e-11)
    assert (found.status is fc.Status.FREE) == (len(expected) == 0)


def test_both_answers_are_met():
    """So that the test above judges misses, contacts and more than one of them."""
    counts = {len(Scene(np.random.default_rng(seed), HEIGHTS["the same"]).truth()[0]) for seed in range(4)}
    assert len(counts) > 1 and max(counts) >= 1


def test_links_in_two_planes_never_meet():
    scene = Scene(np.random.default_rng(0), ((0, 0.25), (0.25 + 2**-52, 0.5)))
    assert len(scene.truth()[0])
    assert fc.contact_intervals(scene.one, scene.two).status is fc.Status.FREE


def asked(a, b):
    """The question of `in_one_plane`, while both turn about two axes along z."""
    turns = [fc.Rotation((0, 0, 1), (x, 0, 0), degrees=40) for x in (0, 5)]
    return question(a.moving(turns[0]), b.moving(turns[1]))


def question(a, b):
    return in_one_plane(Query(a, b, fmpq(0), fmpq(1)))


SQUARE = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])


def test_what_is_a_prism_and_what_is_not():
    box = link(SQUARE, 0, 0, 1)
    two = fc.Polyhedron([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 3, 2]])  # one turned over
    corner = fc.Polyhedron([[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2, 0], [0, 2, 0]], [[0, 1, 2, 3, 4, 5]])
    for body in (box, two, corner, link(SQUARE, 0, 1, 1), fc.examples.box((1, 2, 1)).rotated((0, 0, 1), degrees=90)):
        assert isinstance(asked(body, box), Query)
    assert isinstance(asked(link(SQUARE, 0, 2, 3), box), Apart)
    doubled = fc.Polyhedron([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 1, 3]], solid=False)
    half = fc.Polyhedron([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2]], solid=False)
    tapered = link(SQUARE, 0, 0, 1).transformed([[1, 0, 0, 0], [0, 1, 0, 0], [0.5, 0, 1, 0], [0, 0, 0, 1]])
    shell = fc.Polyhedron(box.vertices, box.triangles, solid=False)
    for body in (doubled, half, tapered, shell, fc.examples.noisy_sphere(80)):
        assert asked(body, box) is None and asked(box, body) is None


def test_an_edge_across_a_notch_makes_no_prism():
    """From a lower corner to an upper one, outside of the walls."""
    outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    corners = [(x, y, z) for z in (0, 1) for x, y in outline]
    faces = [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *([k, (k + 1) % 6, (k + 1) % 6 + 6, k + 6] for k in range(6))]
    box = link(SQUARE, 0, 0, 1)
    assert isinstance(asked(fc.Polyhedron(corners, faces), box), Query)
    with_edge = fc.Polyhedron(corners, faces, edges=[[2, 10]])
    assert asked(with_edge, box) is None and asked(box, with_edge) is None


def test_only_motions_in_the_plane_are_taken():
    a, b = link(SQUARE, 0, 0, 1), link(SQUARE, 3, 0, 1)
    turn = fc.Rotation((0, 0, 2), degrees=40)
    screw = fc.Screw((0, 0, 1), degrees=5, advance=1)
    for motion in (fc.Translation((1, 0, 1)), fc.Rotation((0, 1, 8), degrees=10), screw):
        assert question(a.moving(turn), b.moving(motion)) is None
    assert question(a.moving(turn), b.moving(fc.Translation((1, 2, 0)))) is not None
    assert question(a.moving(fc.Translation((1, 0, 0))), b) is None  # no turn tells the normal


def test_a_plain_turn_keeps_its_exact_ends():
    a, b = link(SQUARE, 0, 0, 1), link(SQUARE, (0.5, 1.25), 0, 1)
    found = fc.contact_intervals(a.moving(fc.Rotation((0, 0, 1), degrees=90)), b, exact=True)
    assert found[0].start_exact is not None and found.stats.ways[0].told.startswith("passed: shifts and turns")
