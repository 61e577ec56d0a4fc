"""Ranges of nodes about an axis hold every point of the parts below, whatever lies around the axis."""

from __future__ import annotations

import math

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.kernels.angle import TWO_PI
from firstcontact.search.trees.cylinder import COLUMNS, KNOWN, PHI, R_HI, R_LO, WIDTH, Z_HI, Z_LO, learn
from firstcontact.search.trees.frame import frame_of, view_in
from firstcontact.search.trees.tree import SPLIT
from unit.test_tree import BODIES, samples

PAD = 1e-12  # the sampled points are rounded


def ranges(tree, centre, order) -> np.ndarray:
    """The motion array with the rows of all nodes learnt in that order (see `search.trees.rotate`)."""
    motion = np.zeros((len(tree.boxes) + 1, COLUMNS))
    motion[-1, :3] = (*centre, 0)
    for node in order:
        learn(motion, 0, tree.boxes, tree.links, tree.xyz, tree.ids, node, PAD)
    return motion


def outside(row, point, centre) -> str:
    """What of the point leaves the range; empty when nothing does."""
    x, y = point[0] - centre[0], point[1] - centre[1]
    radius = x * x + y * y
    wrong = "radius " * (not row[R_LO] <= radius <= row[R_HI])
    wrong += "height " * (not row[Z_LO] - PAD <= point[2] <= row[Z_HI] + PAD)
    if row[WIDTH] < TWO_PI and radius > 0:
        ahead = (math.atan2(y, x) - row[PHI]) % TWO_PI
        wrong += "angle" * (not (ahead <= row[WIDTH] + 1e-14 or ahead >= TWO_PI - 1e-14))
    return wrong


def descend(tree):
    """(part, all nodes above its leaf and the leaf) for every part."""
    stack = [(0, (0,))]
    while stack:
        node, path = stack.pop()
        left, right = tree.links[node]
        if right < 0:
            yield int(left), path
        else:
            stack += [(int(left), (*path, int(left))), (int(right), (*path, int(right)))]


@pytest.mark.share(20)
@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (1.0, 2.0, 3.0)])
@pytest.mark.parametrize("where", ["far", "through", "corner", "surface"])
def test_ranges_hold_the_parts(name, axis, where):
    tree = view_in(BODIES[name](), frame_of(axis))
    rng = np.random.default_rng(95)
    some = tree.xyz[len(tree.xyz) // 2]
    centre = {
        "far": tree.boxes[0, :2] - 3.0,
        "through": 0.5 * (tree.boxes[0, :2] + tree.boxes[0, 3:5]),
        "corner": some[:2],
        "surface": 0.25 * some[:2] + 0.25 * some[3:5] + 0.5 * some[6:8],
    }[where]
    nodes = range(len(tree.links))
    motion = ranges(tree, centre, nodes)
    assert np.all(motion[:-1, KNOWN] == 1.0)
    assert np.array_equal(motion, ranges(tree, centre, nodes[::-1]))  # whatever was visited before
    parts: dict[int, list[tuple[int, ...]]] = {}
    for part, path in descend(tree):
        parts.setdefault(int(tree.ids[part, 0]), []).append(path)
    for primitive in list(parts)[:: max(1, len(parts) // 40)]:
        corners = tree.xyz[next(p for p, ids in enumerate(tree.ids) if ids[0] == primitive)]
        for exact in samples(corners, rng, 12):
            point = [float(x) for x in exact]
            paths = parts[primitive]
            faults = [[outside(motion[node], point, centre) for node in path] for path in paths]
            assert any(not any(fault) for fault in faults), (name, point, faults)


def test_ranges_of_oblique_triangles_are_tight():
    """A sliver that runs radially has the angle and the radii of its corners, unlike its box."""
    sliver = fc.Polyhedron([[1, 1, 0], [9, 9, 0], [9, 9.1, 0.1]], [[0, 1, 2]])
    row = ranges(view_in(sliver, frame_of((0.0, 0.0, 1.0))), (0.0, 0.0), [0])[0]
    assert row[WIDTH] < 0.01 and abs(row[PHI] - math.pi / 4) < 0.01
    assert abs(math.sqrt(row[R_LO]) - math.sqrt(2)) < 1e-9


def test_a_triangle_around_the_axis_has_the_full_circle():
    around = fc.Polyhedron([[1, 0, 0], [-1, 1, 0], [-1, -1, 0]], [[0, 1, 2]])
    row = ranges(view_in(around, frame_of((0.0, 0.0, 1.0))), (0.0, 0.0), [0])[0]
    assert row[WIDTH] >= TWO_PI and row[R_LO] == 0.0


def test_some_of_the_bodies_are_split():
    assert any(np.any(view_in(make(), frame_of((0.0, 0.0, 1.0))).ids[:, 1] & SPLIT) for make in BODIES.values())
