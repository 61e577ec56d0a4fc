"""Motions for tests of curved motions: constant-speed ones written as rational ones, and random poses."""

from __future__ import annotations

import math

import numpy as np

import firstcontact as fc
from contact_places import assert_place

ONE = np.eye(4)
REST = fc.Translation((0, 0, 0))


def rational_translation(v) -> fc.RationalMotion:
    """fc.Translation(v), as a rational motion."""
    step = np.zeros((4, 4))
    step[:3, 3] = v
    return fc.RationalMotion([ONE, step])


def rational_turn(axis, point=(0, 0, 0)) -> fc.RationalMotion:
    """Turn about an integer axis h by the angle 2 atan(|h| t)."""
    h, p = np.array(axis, float), np.array(point, float)
    square = h @ h
    across = np.array([[0, -h[2], h[1]], [h[2], 0, -h[0]], [-h[1], h[0], 0]])
    first, second = np.zeros((4, 4)), np.zeros((4, 4))
    first[:3, :3] = 2 * across
    second[:3, :3] = square * np.eye(3) + 2 * across @ across
    second[3, 3] = square
    powers = [ONE.copy(), first, second]
    for m in powers:
        m[:3, 3] = m[3, 3] * p - m[:3, :3] @ p
    return fc.RationalMotion(powers)


def turned_by(axis, t: float) -> float:
    """The angle of `rational_turn` at time t, in radians."""
    return 2 * math.atan(math.sqrt(sum(x * x for x in axis)) * t)


def pose(rotation_vector=(0, 0, 0), shift=(0, 0, 0)) -> np.ndarray:
    """A 4x4 pose: turn by the vector's length about it, then shift."""
    v = np.array(rotation_vector, float)
    angle = float(np.linalg.norm(v))
    m = fc.Rotation(v, radians=angle)(1.0) if angle else np.eye(4)
    m[:3, 3] = shift
    return m


def random_body(rng, generic: bool) -> fc.Polyhedron:
    """A small body at a random place: solids, surfaces, edge sets, points; `generic`: floats, else half integers."""
    kind = int(rng.integers(5))
    if generic:
        offset = rng.normal(size=3) * 1.4
        if kind < 2:
            return fc.Polyhedron(rng.normal(size=(6, 3)) + offset, [[0, 1, 2], [3, 4, 5]])
        if kind == 2:
            return fc.Polyhedron(rng.normal(size=(4, 3)) + offset, [], edges=[[0, 1], [2, 3]])
        return fc.examples.noisy_sphere(80, seed=int(rng.integers(99))).translated(offset.tolist())
    offset = (rng.integers(-4, 5, 3) / 2).tolist()
    points = (rng.integers(-3, 4, (6, 3)) / 2).tolist()
    if kind == 0:
        return fc.examples.box((1, 1, 1)).translated(offset)
    if kind == 1:
        tetrahedron = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
        return fc.Polyhedron(tetrahedron, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]).translated(offset)
    if kind == 2:
        return fc.Polyhedron(points, [[0, 1, 2], [3, 4, 5]]).translated(offset)
    if kind == 3:
        return fc.Polyhedron(points[:4], [], edges=[[0, 1], [2, 3]]).translated(offset)
    return fc.Polyhedron(points[:3], []).translated(offset)


def share_points(a, b, t: float) -> bool:
    """Whether the bodies share a point at that time, by a query of their poses at rest."""
    hit = fc.first_contact(a.at(t).moving(REST), b.at(t), (0, 0))
    assert hit.status in (fc.Status.FREE, fc.Status.INITIAL_CONTACT)
    return hit.status is fc.Status.INITIAL_CONTACT


def assert_first_by_sampling(a, b, hit, samples: int = 40) -> None:
    """Free at sampled times before the contact, in contact right after it or at it (a graze)."""
    assert_place(hit, a, b)
    first, last = hit.span
    until = last if hit.time is None else hit.time - 1e-6
    for t in np.linspace(first, max(until, first), samples):
        if hit.status is not fc.Status.INITIAL_CONTACT:
            assert not share_points(a, b, float(t)), (t, hit)
    if hit.status is fc.Status.CONTACT and hit.normal is not None and hit.time + 1e-5 <= last:
        assert share_points(a, b, hit.time + 1e-5), hit
