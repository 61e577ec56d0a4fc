"""First new contacts of heaps of cubes, and of turning boxes, against arithmetic that knows nothing of triangles."""

import itertools

import numpy as np
import pytest

import firstcontact as fc
from firstcontact import Status

from .test_new_contact import _overlap_time, _strikes


def heap(rng, n):
    """n unit cubes that hang together, by their lower corners."""
    cells = [(0, 0, 0)]
    while len(cells) < n:
        cell = list(cells[rng.integers(len(cells))])
        cell[rng.integers(3)] += int(rng.choice([-1, 1]))
        if tuple(cell) not in cells:
            cells.append(tuple(cell))
    return cells


def skin(cells, triangles):
    """Its surface, of squares or of triangles; edges and vertices may belong to more than two faces or fans."""
    squares = []
    for cell, k, up in itertools.product(cells, range(3), (0, 1)):
        beside = list(cell)
        beside[k] += 2 * up - 1
        if tuple(beside) in cells:
            continue
        corners = []
        for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)):
            p = list(cell)
            p[k], p[(k + 1) % 3], p[(k + 2) % 3] = p[k] + up, p[(k + 1) % 3] + i, p[(k + 2) % 3] + j
            corners.append(tuple(p))
        squares.append(corners if up else corners[::-1])
    places = sorted({p for square in squares for p in square})
    faces = [[places.index(p) for p in square] for square in squares]
    if triangles:
        faces = [f for a, b, c, d in faces for f in ([a, b, c], [a, c, d])]
    return fc.Polyhedron([[float(x) for x in p] for p in places], faces)


def as_boxes(cells):
    return [(list(cell), [x + 1 for x in cell]) for cell in cells]


def test_heaps_of_cubes():
    """They never overlap before a new contact; under a motion along an axis the new one is across it."""
    rng, told = np.random.default_rng(3), []
    while len(told) < 12:
        first, second = heap(rng, rng.integers(1, 6)), heap(rng, rng.integers(1, 9))
        shift, vector = rng.integers(-2, 3, 3), rng.integers(-6, 7, 3) * rng.integers(0, 2, 3)
        first = [tuple((np.array(cell) + shift).tolist()) for cell in first]
        if set(first) & set(second) or not vector.any():
            continue
        a, b = (skin(cells, rng.random() < 0.5) for cells in (first, second))
        hit = fc.first_new_contact(a.moving(fc.Translation(vector.tolist())), b)
        if hit.allowed is None:
            continue
        overlap = _overlap_time(as_boxes(first), as_boxes(second), vector.tolist())
        told.append(hit.status)
        assert overlap >= (hit.free_until if hit.status is not Status.CONTACT else hit.time) - 1e-12
        if hit.status is Status.CONTACT and np.count_nonzero(vector) == 1 and (60 * hit.time) % 1 == 0:
            assert _strikes(as_boxes(first), as_boxes(second), vector.tolist(), hit.time)
    assert told.count(Status.UNDECIDED) <= 1 and {Status.FREE, Status.CONTACT} <= set(told)


def depth(p, q, turned):
    """How deep two boxes, by their corners, are in each other; negative where an axis separates them."""
    axes = [*np.eye(3), *turned.T]
    axes += [c / np.linalg.norm(c) for u in np.eye(3) for v in turned.T if np.linalg.norm(c := np.cross(u, v)) > 1e-9]
    heights = [(p @ n, q @ n) for n in axes]
    return min(min(x.max(), y.max()) - max(x.min(), y.min()) for x, y in heights)


@pytest.mark.thorough
def test_turning_boxes():
    """A box turns about an axis through corners of either, so that hinges, seats and pivots are common."""
    rng = np.random.default_rng(0)
    for _ in range(10):
        p, r = rng.integers(-2, 2, 3), rng.integers(-3, 3, 3)
        q, s = p + rng.integers(1, 4, 3), r + rng.integers(1, 5, 3)
        k = rng.integers(3)
        p[k], q[k] = s[k], q[k] - p[k] + s[k]  # on top of it, in one direction
        axis, point = [0, 0, 0], [int(rng.choice(x)) for x in zip(p, q, r, s, strict=True)]
        axis[rng.integers(3)] = int(rng.choice([-1, 1]))
        motion = fc.Rotation(axis, point, degrees=int(rng.choice([30, 90, 135, 180, 270, 360])))
        a, b = (skin_of(lo, hi) for lo, hi in ((p, q), (r, s)))
        hit = fc.first_new_contact(a.moving(motion), b)
        assert hit.status is not Status.UNDECIDED
        ends = [np.array(list(itertools.product(*zip(lo, hi, strict=True))), float) for lo, hi in ((p, q), (r, s))]

        def deep(t, motion=motion, ends=ends):
            pose = motion(t)
            return depth(ends[0] @ pose[:3, :3].T + pose[:3, 3], ends[1], pose[:3, :3])

        until = 1.0 if hit.time is None else hit.time
        assert max(deep(t) for t in np.linspace(0, until, 97)) <= 1e-9
        assert hit.time is None or abs(deep(hit.time)) <= 1e-7


def skin_of(lo, hi):
    box = fc.examples.box([float(x) for x in hi - lo])
    return fc.Polyhedron(box.vertices, box.triangles).translated(((lo + hi) / 2).tolist())
