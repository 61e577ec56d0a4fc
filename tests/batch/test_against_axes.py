"""Batches of convex polyhedra against separating axes: an oracle that shares nothing with the library.

Two convex polyhedra share a point unless a face's normal, or the product of an edge of either, separates them.  Under a
translation each axis leaves a closed interval of times; they meet in the intersection, here in fractions.  Under
rotations poses are sampled, in doubles.
"""

import itertools
from fractions import Fraction as F
from random import Random

import numpy as np
import pytest

import firstcontact as fc

FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]


def cross(x, y):
    return x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]


def dot(x, y):
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]


def minus(x, y):
    return tuple(p - q for p, q in zip(x, y, strict=True))


def tetrahedron(rng, shift=(0, 0, 0), size=3):
    """Corners of a random one, whole numbers, turned outwards."""
    while True:
        p = [tuple(rng.randint(-size, size) for _ in range(3)) for _ in range(4)]
        volume = dot(cross(minus(p[1], p[0]), minus(p[2], p[0])), minus(p[3], p[0]))
        if volume:
            p = p if volume > 0 else [p[1], p[0], p[2], p[3]]
            return [tuple(x + d for x, d in zip(q, shift, strict=True)) for q in p]


def solid(corners):
    return fc.Polyhedron(corners, FACES, solid=True)


def axes(p, q):
    edges = [[minus(x, y) for x, y in itertools.combinations(body, 2)] for body in (p, q)]
    normals = [cross(minus(body[j], body[i]), minus(body[k], body[i])) for body in (p, q) for i, j, k in FACES]
    return [n for n in [*normals, *(cross(x, y) for x in edges[0] for y in edges[1])] if any(n)]


def times(p, q, v, last):
    """The closed interval of times in [0, last] at which p, moved by t v, shares a point with q; None."""
    lo, hi = F(0), F(last)
    for n in axes(p, q):
        a, b = [dot(n, x) for x in p], [dot(n, x) for x in q]
        speed, ahead, behind = dot(n, v), min(b) - max(a), max(b) - min(a)
        if speed == 0:
            if ahead > 0 or behind < 0:
                return None
            continue
        ends = sorted((F(ahead) / speed, F(behind) / speed))
        lo, hi = max(lo, ends[0]), min(hi, ends[1])
    return (lo, hi) if lo <= hi else None


def is_right(table, row, due):
    """Of first contacts: status, the double nearest the time, the enclosure."""
    if due is None:
        assert table.status[row] == "FREE" and np.isnan(table.time[row]), row
        return
    assert table.status[row] == ("INITIAL_CONTACT" if due[0] == 0 else "CONTACT"), row
    assert table.time[row] == float(due[0]), row
    assert F(table.lo[row]) <= due[0] <= F(table.hi[row]), row
    assert table.free_until[row] <= due[0], row


@pytest.mark.share(8)
@pytest.mark.parametrize("seed", range(24))
def test_translations_of_a_pair(seed):
    """Of small whole numbers, which land on edges and corners together, and of doubles."""
    rng = Random(seed)
    p = tetrahedron(rng)
    q = tetrahedron(rng, (rng.randint(3, 6), rng.randint(-2, 2), rng.randint(-1, 1)))
    whole = [[rng.randint(-9, 9) for _ in range(3)] for _ in range(30)]
    doubles = [[rng.uniform(2, 9), rng.uniform(-3, 3), rng.uniform(-3, 3)] for _ in range(30)]
    vectors, last = np.array(whole + doubles, float), rng.choice([1.0, 0.5, 0.3, 2.0])
    table = fc.first_contacts((solid(p).moving(fc.Translations(vectors)), solid(q), (0, last)))
    for row, v in enumerate(vectors.tolist()):
        is_right(table, row, times(p, q, [F(x) for x in v], F(last)))
    assert set(table.counts) <= {"FREE", "CONTACT", "INITIAL_CONTACT"}


def test_times_that_round_to_one_double_are_told_apart():
    """Two spikes reach the wall one after the other, by less than doubles tell at that time: the first one is named."""
    tips = [(F(1), F(0)), (1 - F(1, 2**60), F(3))]
    corners, faces = [], []
    for tip, y in tips:
        k = len(corners)
        corners += [(0, y, 0), (0, y + 1, 0), (0, y, 1), (tip, y + F(1, 4), F(1, 4))]
        faces += [[k + x for x in face] for face in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]]
    for order in (1, -1):  # whichever stands first
        spikes = fc.Polyhedron(corners[::order], [[(7 - x if order < 0 else x) for x in face] for face in faces])
        wall = fc.Polyhedron([(2, -9, -9), (2, 9, -9), (2, 9, 9), (2, -9, 9)], [[0, 1, 2, 3]])
        moving = spikes.moving(fc.Translations([np.array([3.7, 0.125, 0.25]) * (1 + k / 8) for k in range(12)]))
        table = fc.first_contacts((moving, wall))
        assert table.index_a.tolist() == [3 if order > 0 else 4] * 12 and table.multiplicity.tolist() == [1] * 12


def test_pairs_that_boxes_tell_are_apart():
    """An assembly, dense enough for contacts: what boxes tell and what is asked, against the axes."""
    rng = Random(5)
    corners = [tetrahedron(rng, tuple(rng.randint(-13, 13) for _ in range(3))) for _ in range(26)]
    moves = [tuple(rng.randint(-12, 12) for _ in range(3)) if k % 2 == 0 else (0, 0, 0) for k in range(26)]
    bodies = [
        solid(p) if not any(v) else solid(p).moving(fc.Translation(v)) for p, v in zip(corners, moves, strict=True)
    ]
    pairs = list(itertools.combinations(range(26), 2))
    table = fc.first_contacts(fc.columns(bodies, pairs))
    for row, (i, j) in enumerate(pairs):
        is_right(table, row, times(corners[i], corners[j], minus(moves[i], moves[j]), 1))
    told = int((table.work == 0).sum())
    assert told > 100 and table.counts["CONTACT"] >= 5 and table.counts["FREE"] > told


def test_points_that_lie_on_a_face_at_the_start():
    point = fc.Polyhedron([(0, 0, 0)], [])
    face = fc.Polyhedron([(0, -1, -1), (0, 1, -1), (0, 0, 2)], [[0, 1, 2]])
    vectors = np.random.default_rng(0).uniform(-3, 3, (20, 3))
    table = fc.first_contacts((point.moving(fc.Translations(vectors)), face))
    assert table.counts == {"INITIAL_CONTACT": 20} and not table.time.any()


def turned(points, axis, point, angle):
    """Rodrigues' formula."""
    k = axis / np.linalg.norm(axis)
    x = np.asarray(points, float) - point
    return point + x * np.cos(angle) + np.cross(k, x) * np.sin(angle) + np.outer(x @ k, k) * (1 - np.cos(angle))


def gap(p, q):
    """How far the best axis keeps the corners apart; not above 0 where they share a point, or are no solids."""
    best = -np.inf
    for n in axes([tuple(x) for x in p.tolist()], [tuple(x) for x in q.tolist()]):
        n = np.array(n) / np.linalg.norm(n)
        best = max(best, (q @ n).min() - (p @ n).max(), (p @ n).min() - (q @ n).max())
    return best


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(6))
def test_rotations_about_one_axis(seed):
    rng = Random(seed)
    p = q = np.zeros((4, 3))
    while gap(p, q) <= 0.0:
        p, q = (np.array(tetrahedron(rng, shift), float) for shift in ((0, 0, 0), (rng.randint(4, 6), 2, 0)))
    axis, point = np.array([rng.randint(-2, 2), rng.randint(-2, 2), 3.0]), np.array([1.0, rng.choice([-3, 3]), 0.0])
    angles = np.array([rng.uniform(-7, 7) for _ in range(20)])
    moving = solid(p).moving(fc.Rotations(axis, point, radians=angles))
    table, last = fc.first_contacts((moving, solid(q), (0, 0.75))), 0.75
    for row, angle in enumerate(angles.tolist()):
        contact = table.status[row] == "CONTACT"
        assert contact or table.status[row] == "FREE"
        end = table.time[row] if contact else last
        for t in np.linspace(0, end, 60)[: -1 if contact else None]:
            assert gap(turned(p, axis, point, angle * t), q) > -1e-9, (row, t)
        if contact:
            assert end <= last
            assert abs(gap(turned(p, axis, point, angle * end), q)) < 1e-9, row
