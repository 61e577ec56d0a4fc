"""Touching or overlapping, told of solids that are made of cells of one grid: then it is a matter of counting.

Freudenthal's grid cuts every unit cube into six tetrahedra, one for each order of the axes; the grid of half the size
refines it.  Two sets of small cells share inner points iff they share a cell, and touch iff they share a corner of the
grid, since every face that they share has corners.  The surface of a set is the faces that an odd number of its cells
have: edges with four faces, corners that touch corners, cells that hang together by nothing else all occur.
"""

from __future__ import annotations

from collections import Counter
from fractions import Fraction as F
from itertools import combinations, permutations, product
from random import Random

import numpy as np
import pytest

import firstcontact as fc

INITIAL, FREE = fc.Status.INITIAL_CONTACT, fc.Status.FREE
UNIT = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
SHEARED = [(2, 1, -1), (0, 1, 3), (1, -2, 1)]


def cell(corner, order):
    """The corners of a tetrahedron: from one corner of its cube along the axes in this order."""
    corners = [tuple(corner)]
    for k in order:
        corners.append(tuple(c + (i == k) for i, c in enumerate(corners[-1])))
    return frozenset(corners)


def cells(low, high):
    cubes = product(*(range(a, b) for a, b in zip(low, high, strict=True)))
    return [cell(corner, order) for corner in cubes for order in permutations(range(3))]


def refined(large, everything):
    """The cells of half the size inside a cell of the grid, whose coordinates count halves now."""
    corners = [np.array(c) * 2 for c in large]
    m = np.array([*(np.append(c, 1) for c in corners)], float).T
    inside = []
    for small in everything:
        weights = np.linalg.solve(m, np.append(np.mean([*small], axis=0), 1))
        if weights.min() > 1e-9:
            inside.append(small)
    return inside


def surface(chosen):
    count = Counter(face for c in chosen for face in combinations(sorted(c), 3))
    return [face for face, n in count.items() if n % 2]


def mesh(faces, place, solid=None):
    corners = sorted({c for face in faces for c in face})
    number = {c: i for i, c in enumerate(corners)}
    return fc.Polyhedron([place(c) for c in corners], [[number[c] for c in face] for face in faces], solid=solid)


def placing(matrix, shift):
    rows = list(zip(matrix, shift, strict=True))
    return lambda c: tuple(sum(m * x for m, x in zip(row, c, strict=True)) + t for row, t in rows)


PLACES = {
    "as it is": placing(UNIT, (0, 0, 0)),
    "oblique": placing(SHEARED, (0, 0, 0)),
    "odd doubles": placing([[x * 0.1 for x in row] for row in UNIT], (0.7, 0.3, -0.1)),
    "two doubles": placing([[F(x) * (1 + F(1, 2**60)) for x in row] for row in SHEARED], (1, 2, 3)),
    "thirds": placing([[F(x, 3) for x in row] for row in SHEARED], (F(1, 7), 0, 5)),
}
SMALL = cells((0, 0, 0), (4, 2, 2))
LARGE = [refined(c, SMALL) for c in cells((0, 0, 0), (2, 1, 1))]


def told(a, b, moved=(1, 1, 2)):
    for x, y in ((a, b), (b, a)):
        yield fc.first_contact(x.moving(fc.Translation(moved)), y)


def exact_doubles(name):
    """0.1 times whole numbers, rounded: a grid no more, but cells share their corners as before."""
    return name != "odd doubles"


@pytest.mark.share(12)
@pytest.mark.parametrize("name", PLACES)
@pytest.mark.parametrize("seed", range(6))
def test_solids(name, seed):
    r = Random(seed)
    for trial in range(6):
        pick = r.sample(SMALL, r.randint(1, 12))
        if exact_doubles(name) and trial % 2:
            other = [c for block in r.sample(LARGE, r.randint(1, 4)) for c in block]
        else:
            other = r.sample(SMALL, r.randint(1, 40))
        if trial % 3:
            other = [c for c in other if c not in pick]
        if not other:
            continue
        a, b = mesh(surface(pick), PLACES[name]), mesh(surface(other), PLACES[name])
        corners = {c for x in pick for c in x} & {c for x in other for c in x}
        expected = "overlapping" if set(pick) & set(other) else "touching" if corners else None
        for hit in told(a, b):
            if expected is None:
                assert hit.status is not INITIAL
            else:
                # a body inside the other whose surfaces share no point is told as such
                inside = expected == "overlapping" and not on_surface(pick, other)
                assert (hit.status, hit.initial) == (INITIAL, "containment" if inside else expected), (seed, trial)


def of_cubes(cubes):
    """The surface of a set of cubes, its squares cut along the other diagonal: edges cross there."""
    squares = Counter()
    for cube in cubes:
        for axis, side in product(range(3), range(2)):
            low = tuple(c + side * (i == axis) for i, c in enumerate(cube))
            squares[axis, low] += 1
    faces = []
    for (axis, low), n in squares.items():
        if n % 2:
            x, y = (tuple(c + (i == (axis + k) % 3) for i, c in enumerate(low)) for k in (1, 2))
            far = tuple(c + (i != axis) for i, c in enumerate(low))
            faces += [(x, y, low), (x, y, far)]
    return faces


@pytest.mark.share(6)
@pytest.mark.parametrize("name", [name for name in PLACES if exact_doubles(name)])
@pytest.mark.parametrize("seed", range(4))
def test_edges_that_cross(name, seed):
    r = Random(200 + seed)
    everywhere = list(product(range(4), range(2), range(2)))
    for trial in range(6):
        cubes = r.sample(everywhere, r.randint(1, 6))
        within = {frozenset(c) for cube in cubes for c in cells(cube, [x + 1 for x in cube])}
        pick = r.sample(SMALL, r.randint(1, 12))
        if trial % 3:
            pick = [c for c in pick if c not in within]
        if not pick:
            continue
        a, b = mesh(surface(pick), PLACES[name]), mesh(of_cubes(cubes), PLACES[name])
        if not {c for x in pick for c in x} & {c for face in of_cubes(cubes) for c in face}:
            continue
        expected = "overlapping" if set(pick) & within else "touching"
        for hit in told(a, b):
            assert (hit.status, hit.initial) == (INITIAL, expected), (seed, trial)


@pytest.mark.parametrize("name", PLACES)
@pytest.mark.parametrize("seed", range(3))
def test_cells_with_all_their_faces(name, seed):
    """Faces between two cells are there twice: arcs that cover each other."""
    r = Random(300 + seed)
    for trial in range(3):
        pick = r.sample(SMALL, r.randint(1, 8))
        other = r.sample(SMALL, r.randint(1, 8))
        if trial:
            other = [c for c in other if c not in pick]
        if not other or not {c for x in pick for c in x} & {c for x in other for c in x}:
            continue
        a = mesh([face for c in pick for face in combinations(sorted(c), 3)], PLACES[name])
        b = mesh(surface(other), PLACES[name])
        expected = "overlapping" if set(pick) & set(other) else "touching"
        for hit in told(a, b):
            assert (hit.status, hit.initial) == (INITIAL, expected), (seed, trial)


def on_surface(pick, other):
    """Whether the surfaces share a point: they do iff they share a corner of the grid."""
    x, y = ({c for face in surface(cells) for c in face} for cells in (pick, other))
    return bool(x & y) or bool(set(surface(pick)) & set(surface(other)))


@pytest.mark.share(5)
@pytest.mark.parametrize("name", PLACES)
@pytest.mark.parametrize("seed", range(4))
def test_surfaces_and_solids(name, seed):
    """A face goes into the solid iff the cells on both sides of it belong to it."""
    r = Random(100 + seed)
    beside = Counter(face for c in SMALL for face in combinations(sorted(c), 3))
    for trial in range(6):
        pick = r.sample(SMALL, r.randint(8, 60))
        faces = r.sample(sorted(beside), r.randint(1, 5))
        count = Counter(face for c in pick for face in combinations(sorted(c), 3))
        if trial % 3:
            faces = [face for face in faces if count[face] < 2]
        if not faces:
            continue
        a, b = mesh(faces, PLACES[name], solid=False), mesh(surface(pick), PLACES[name])
        touched = {c for face in surface(pick) for c in face} & {c for face in faces for c in face}
        if not touched:
            continue
        expected = "overlapping" if any(count[face] == 2 for face in faces) else "touching"
        for hit in told(a, b):
            assert (hit.status, hit.initial) == (INITIAL, expected), (seed, trial)
