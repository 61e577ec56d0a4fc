"""Bare edges and points that meet solids under a screw: what touches is a crossing of edges, or an edge on a face.

The truth is a search of its own: the least height of sampled points of the edge over the solid, by time.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import firstcontact as fc
from firstcontact import Status

SEED = 77
SOLIDS = {
    "box": (fc.box((4, 4, 4)), lambda x: np.abs(x).max(axis=-1) - 2),
    "cylinder": (fc.cylinder(2, 4), lambda x: _tube(x)),
    "ring": (
        fc.cylinder(2, 4) - fc.cylinder(1, 6),
        lambda x: np.maximum(_tube(x), 1 - np.hypot(x[..., 0], x[..., 1])),
    ),
}
BODIES = ["edge", "point"]


def _tube(x):
    return np.maximum(np.hypot(x[..., 0], x[..., 1]) - 2, np.abs(x[..., 2]) - 2)


def screwed(points, axis, point, degrees, advance, t):
    """Points (n, 3) at times (m,): (m, n, 3)."""
    n = np.array(axis, float) / math.hypot(*axis)
    angle = np.radians(degrees) * t[:, None, None]
    arm = points - np.array(point, float)
    along = (arm @ n)[:, None] * n
    swing = arm - along
    turned = np.cos(angle) * swing + np.sin(angle) * np.cross(n, swing)
    return point + along + turned + advance * t[:, None, None] * n


def first_sampled(height, points, motion):
    """The first of many times at which a sampled point is inside, or None."""
    t = np.linspace(0, 1, 4001)
    low = np.array([height(screwed(points, *motion, part)).min(axis=1) for part in np.array_split(t, 20)], object)
    low = np.concatenate(list(low)).astype(float)
    inside = np.flatnonzero(low < 0)
    return None if not len(inside) else float(t[inside[0]])


def scenes():
    rng = np.random.default_rng(SEED)
    while True:
        p, q = rng.integers(-6, 7, (2, 3)).tolist()
        motion = (
            [*rng.integers(-4, 5, 2).tolist(), int(rng.integers(1, 5))], rng.integers(-3, 4, 3).tolist(),
            int(rng.choice([100, 170, 360])), int(rng.choice([-6, 3, 5])),
        )  # fmt: skip
        if p != q:
            yield p, q, motion


@pytest.mark.parametrize("solid", SOLIDS)
@pytest.mark.parametrize("kind", BODIES)
def test_first_contacts_are_where_sampled_points_enter(kind, solid):
    """Samples are never earlier than what is told, and hardly later."""
    body, height = SOLIDS[solid]
    told = {Status.CONTACT: 0, Status.FREE: 0, Status.INITIAL_CONTACT: 0}
    for (p, q, motion), _ in zip(scenes(), range(40), strict=False):
        ends = [p, q] if kind == "edge" else [p]
        shape = fc.Polyhedron(ends, [], edges=[(0, 1)]) if kind == "edge" else fc.Polyhedron(ends, [])
        axis, point, degrees, advance = motion
        moving = shape.moving(fc.Screw(axis, point, degrees=degrees, advance=advance))
        found = fc.first_contact(moving, body)
        assert found.status in told, (p, q, motion)
        told[found.status] += 1
        s = np.linspace(0, 1, 200)[:, None]
        points = np.array(p) + s * (np.array(q) - p) if kind == "edge" else np.array([p], float)
        sampled = first_sampled(height, points, motion)
        if found.status is Status.FREE:
            assert sampled is None, (p, q, motion)
        elif found.status is Status.CONTACT:
            assert sampled is None or sampled > found.time - 1e-9, (p, q, motion)
            assert fc.first_contact(body, moving).time == pytest.approx(found.time, abs=1e-11)
            at = screwed(np.array(ends, float), *motion, np.array([found.time]))[0]
            assert abs(float(height(found.point))) < 1e-8
            assert _distance(at, found.point) < 1e-8
            assert found.element_a is not None
    assert min(told[Status.CONTACT], told[Status.FREE]) >= 2, told


def _distance(ends, x):
    """Of a point from the segment between the first and the last of some points."""
    d = ends[-1] - ends[0]
    s = 0.0 if not d.any() else min(max(float((x - ends[0]) @ d / (d @ d)), 0.0), 1.0)
    return float(np.linalg.norm(ends[0] + s * d - x))


def test_a_turn_beside_a_shift():
    edge = fc.Polyhedron([(-3, 4, 0), (-2, -2, -5)], [], edges=[(0, 1)])
    turning = edge.moving(fc.Rotation((-1, 0, 3), point=(3, 2, 2), degrees=360))
    for box in (fc.box((4, 4, 4)), fc.examples.box((4, 4, 4))):
        hit = fc.first_contact(turning, box.moving(fc.Translation((1, 2, 3))))
        assert hit.status is Status.CONTACT
        assert hit.time == pytest.approx(0.0639811157936, abs=1e-11)


def test_points_pass_a_hole_whose_mouth_is_no_contact():
    """What covers the ring fills its hole."""
    ring = SOLIDS["ring"][0]
    for x, y in ((0.1, 0), (0.5, 0.2), (1.5, 0)):
        moving = fc.Polyhedron([(x, y, -5)], []).moving(fc.Screw((0, 0, 1), degrees=90, advance=10))
        for pair in ((moving, ring), (ring, moving)):
            found = fc.first_contact(*pair)
            assert found.time == (None if x < 1 else 0.3)
            assert found.status is (Status.FREE if x < 1 else Status.CONTACT)


def test_an_edge_into_a_hole_is_not_told_to_touch_its_mouth():
    edge = fc.Polyhedron([(0.1, 0, -5), (0.2, 0.3, -6)], [], edges=[(0, 1)])
    found = fc.first_contact(edge.moving(fc.Screw((1, 0, 8), degrees=90, advance=10)), SOLIDS["ring"][0])
    t = np.linspace(0, 1, 2001)
    ends = screwed(np.array([[0.1, 0, -5], [0.2, 0.3, -6]]), (1, 0, 8), (0, 0, 0), 90, 10, t)
    low = [SOLIDS["ring"][1](a + np.linspace(0, 1, 50)[:, None] * (b - a)).min() for a, b in ends]
    touched = [time for time, height in zip(t, low, strict=True) if height < 0]
    assert found.status is not Status.CONTACT or found.time == pytest.approx(touched[0], abs=1e-3)
    assert not touched or found.status is not Status.FREE
