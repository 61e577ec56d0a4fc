"""Intervals of contact of bodies that are aligned at the start, at the end or in between, without exact times.

The truth is the gap of two convex polyhedra along all normals of faces and all crossings of edges, at many times, in
poses written down from the definitions of the motions.
"""

from __future__ import annotations

from fractions import Fraction as F
from itertools import combinations, product

import numpy as np
import pytest

import firstcontact as fc
from poses_by_hand import shift, turn

BOX = fc.examples.box((2, 2, 2))
OCTAHEDRON = fc.Polyhedron(
    [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)],
    [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)],
)
TETRAHEDRON = fc.Polyhedron(
    [(1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)], [(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)]
)
BODIES = BOX, OCTAHEDRON, TETRAHEDRON
AXES = (0, 0, 1), (1, 0, 0), (1, 1, 0), (1, 2, 2)
SAMPLES = 400
GAP = 1e-7


def motion_of(r):
    """(motion, its pose) on a lattice: bodies are aligned at many times."""
    axis, point = AXES[r.integers(4)], r.integers(-2, 3, 3).tolist()
    v, quarter = r.integers(-2, 3, 3).tolist(), int(r.choice([1, 2, 4]))
    slide = fc.Translation(v), lambda t: shift(t * np.array(v))
    swing = fc.Rotation(axis, point, turns=f"{quarter}/4"), lambda t: turn(axis, point, t * quarter * np.pi / 2)
    kind = r.integers(5)
    if kind < 2:
        return (slide, swing)[kind]
    if kind == 2:
        advance = int(r.integers(-3, 4))
        along = advance * np.array(axis) / np.linalg.norm(axis)
        screw = fc.Screw(axis, point, turns=f"{quarter}/4", advance=advance)
        return screw, lambda t: shift(t * along) @ swing[1](t)
    (one, pose_one), (two, pose_two) = (slide, swing) if kind == 3 else (swing, slide)
    return fc.Sequence([one, two]), lambda t: pose_two(max(2 * t - 1, 0)) @ pose_one(min(2 * t, 1))


def gap(x, y):
    """How far apart two convex polyhedra (vertices, triangles) are along the best axis; negative: how deep."""
    axes = [np.cross(v[b] - v[a], v[c] - v[a]) for v, faces in (x, y) for a, b, c in faces]
    edges = [[v[j] - v[i] for f in faces for i, j in combinations(f, 2)] for v, faces in (x, y)]
    axes = np.array([*axes, *(np.cross(e, f) for e, f in product(*edges))])
    sizes = np.linalg.norm(axes, axis=1)
    axes = axes[sizes > 1e-9] / sizes[sizes > 1e-9, None]
    p, q = x[0] @ axes.T, y[0] @ axes.T
    return float(np.maximum(q.min(axis=0) - p.max(axis=0), p.min(axis=0) - q.max(axis=0)).max())


def scene(seed):
    r = np.random.default_rng(seed)
    bodies = [BODIES[r.integers(3)].translated(r.integers(-2, 3, 3).tolist()) for _ in range(2)]
    motions = [motion_of(r), motion_of(r) if r.integers(2) else (fc.Translation((0, 0, 0)), lambda t: np.eye(4))]
    moving = [body.moving(motion) for body, (motion, _) in zip(bodies, motions, strict=True)]

    def gap_at(t):
        placed = []
        for body, (_, pose) in zip(bodies, motions, strict=True):
            m = pose(t)
            placed.append((body.vertices @ m[:3, :3].T + m[:3, 3], body.triangles))
        return gap(*placed)

    return *moving, gap_at


def check(found, gap_at):
    """Bodies meet inside the intervals and nowhere else, as far as that is decided."""
    until = found.free_until if found.status is fc.Status.UNDECIDED else 1.0
    ends = [(i.start_interval, i.end_interval) for i in found]
    assert all(x[1][1] < y[0][0] for x, y in zip(ends, ends[1:], strict=False))
    assert all(0 <= lo[0] <= lo[1] and hi[0] <= hi[1] <= 1 + 1e-15 for lo, hi in ends)
    for t in np.linspace(0, until, SAMPLES):
        deep = gap_at(t)
        if abs(deep) < GAP:
            continue
        inside = any(lo[1] <= t <= hi[0] for lo, hi in ends)
        outside = all(t < lo[0] or t > hi[1] for lo, hi in ends)
        assert inside if deep < 0 else outside, (t, deep, ends)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(48))
def test_lattices(seed):
    a, b, gap_at = scene(seed)
    found = fc.contact_intervals(a, b)
    check(found, gap_at)
    first = fc.first_contact(a, b)
    if len(found) and first.status is not fc.Status.UNDECIDED:
        lo, hi = first.time_interval
        assert found[0].start_interval[0] <= hi and lo <= found[0].start_interval[1]


# Contact at the start or where steps join, of which the balls of times leave open whether it lasts for an instant.
SETTLED = {
    "tetrahedra": (
        TETRAHEDRON.translated((0, 0, -1)).moving(fc.Screw((0, 0, 1), (-2, 0, 2), turns="1/2", advance=-1)),
        TETRAHEDRON.translated((-1, -1, -1)).moving(
            fc.Sequence([fc.Translation((1, -2, 1)), fc.Rotation((0, 0, 1), (2, -2, 2), turns="1/4")])
        ),
        (0, 0.11654184459155002),
    ),
    "a box and an octahedron": (
        BOX.translated((1, 2, 0)).moving(fc.Screw((1, 2, 2), (1, -1, -2), turns=1, advance=-3)),
        OCTAHEDRON.translated((0, 2, -1)).moving(
            fc.Sequence([fc.Rotation((1, 2, 2), (-1, -2, 2), turns="1/4"), fc.Translation((-1, 1, -2))])
        ),
        (0, 0.07495432740224513),
    ),
    "for an instant": (
        OCTAHEDRON.translated((2, 0, 0)).moving(
            fc.Sequence([fc.Rotation((0, 0, 1), (-1, 0, 0), turns="1/4"), fc.Translation((-2, -1, -2))])
        ),
        TETRAHEDRON.translated((2, 0, 2)).moving(fc.Translation((-1, 1, 0))),
        (0, 0),
    ),
}  # fmt: skip


@pytest.mark.share(3)
@pytest.mark.parametrize("name", SETTLED)
@pytest.mark.parametrize("swap", [False, True])
def test_doubts_beside_certain_contact(name, swap):
    a, b, (start, end) = SETTLED[name]
    (found,) = fc.contact_intervals(*((b, a) if swap else (a, b)))
    assert found.start == start and found.end == pytest.approx(end, abs=1e-12)
    assert found.end_interval[0] <= end <= found.end_interval[1] and np.ptp(found.end_interval) < 1e-11


def test_pairs_in_doubt_are_listed():
    """An edge slides along another one, turned by a screw: no precision tells whether the two that graze it meet."""
    a = BOX.translated((-1, -1, 0)).moving(fc.Screw((0, 0, 1), (-1, 0, -2), turns=1, advance=3))
    b = TETRAHEDRON.translated((2, 1, 1))
    for pairs in (fc.contact_pairs(a, b), fc.contact_pairs(b, a)):
        assert (len(pairs), len(pairs.undecided)) == (14, 5)
        assert str(pairs) == "14 element pairs meet, 0 pierced at the start, 5 undecided"
        assert not set(pairs.undecided) & {*pairs, *pairs.piercing}


def test_containment_before_a_doubt_is_told():
    """Found by the soak: two equal points in a box from the start on, and times that stay open later."""
    low, high = np.array([-135670, -473346, -1129285]) / 2**19, np.array([912906, 1623806, -80709]) / 2**19
    places = [(0, 1, 0), (1, 1, 0), (1, 1, 1), (0, 1, 1), (0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)]
    faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    box = fc.Polyhedron(np.where(places, high, low), faces)
    way = fc.Trajectory(
        [0, 0.5, 1], [(3, 1, 1.5), (0.5, 0, 2), (1, -1, 0)], quat_wxyz=[(1, 1, 1, 1), (4, 0, 3, 0), (2, -1, 2, 4)]
    )
    points = fc.Polyhedron([(1, 1, 1), (1, 1, 1)], []).moving(fc.Rotation((0, 0, 1), (0, -1, 0), turns="3/8"))
    for a, b in ((box.moving(way), points), (points, box.moving(way))):
        # the third of a turn about (1, 1, 1) takes the point at (1, 1, 1) - (3, 1, 3/2) back to (0, -1/2, -2)
        assert fc.first_contact(a, b).initial == "containment"
        found = fc.contact_intervals(a, b)
        assert found.free_until == 0.0 or found[0].start_interval == (0.0, 0.0)


BLOCK = [[0, 3, 2], [0, 2, 1], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6],
         [3, 0, 4], [3, 4, 7]]  # fmt: skip


def test_ends_that_are_simple_numbers_are_told_as_such_where_balls_do_not_prove_them():
    """A block screwed flat onto a slab from 1/4 on; and one that stands on a sheet and leaves it at once."""
    corners = [(12, 461 / 5, -248 / 5), (-12, 489 / 5, -227 / 5), (-12, 339 / 5, -27 / 5), (12, 311 / 5, -48 / 5),
               (26, 653 / 5, -104 / 5), (2, 681 / 5, -83 / 5), (2, 531 / 5, 117 / 5),
               (26, 503 / 5, 96 / 5)]  # fmt: skip
    exact = [[F(round(5 * x), 125) for x in p] for p in corners]
    screw = fc.Screw((-20, -12, -9), (-4, F(13, 10), F(-22, 5)), turns=F(1, 2), advance=20)
    slab = [(F(108, 5), F(-71, 25), F(-1672, 25)), (-36, F(293, 5), F(-104, 5)), (-36, 1, 56),
            (F(108, 5), F(-1511, 25), F(248, 25)), (F(124, 5), F(-23, 25), F(-1636, 25)),
            (F(-164, 5), F(1513, 25), F(-484, 25)), (F(-164, 5), F(73, 25), F(1436, 25)),
            (F(124, 5), F(-1463, 25), F(284, 25))]  # fmt: skip
    sides = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    (through,) = fc.contact_intervals(fc.Polyhedron(exact, BLOCK).moving(screw), fc.Polyhedron(slab, sides))
    assert through.start == 0.25 and through.start_interval[0] <= 0.25 <= through.start_interval[1]

    corners = [(-10, 10, 10), (-6, 10, 7), (-6, 20, 7), (-10, 20, 10), (-4, 10, 18), (0, 10, 15), (0, 20, 15),
               (-4, 20, 18)]  # fmt: skip
    exact = [[F(x, 5) for x in p] for p in corners]
    screw = fc.Screw((3, 0, 4), (F(-3, 5), 0, F(11, 5)), turns=F(-1, 4), advance=F(3, 2))
    sheet = [(F(-202, 5), -46, F(154, 5)), (F(182, 5), -46, F(-134, 5)), (F(182, 5), 50, F(-134, 5)),
             (F(-202, 5), 50, F(154, 5))]  # fmt: skip
    (stood,) = fc.contact_intervals(
        fc.Polyhedron(sheet, [[0, 1, 2], [0, 2, 3]]), fc.Polyhedron(exact, BLOCK).moving(screw)
    )
    assert (stood.start, stood.end) == (0.0, 0.0) and stood.end_interval[0] <= 0.0 <= stood.end_interval[1]
