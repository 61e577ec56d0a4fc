"""Mechanisms by hand: poses as products of rotations of SciPy, distances by coal."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation


def turn(axis, point, degrees):
    """(4, 4) of a turn about a line."""
    axis, point = np.asarray(axis, float), np.asarray(point, float)
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec(axis / np.linalg.norm(axis) * np.radians(degrees)).as_matrix()
    pose[:3, 3] = point - pose[:3, :3] @ point
    return pose


def shift(axis, length):
    """(4, 4) of a shift along a direction."""
    pose = np.eye(4)
    pose[:3, 3] = np.asarray(axis, float) / np.linalg.norm(axis) * length
    return pose


def coal_mesh(body):
    """A convex polyhedron as coal has it."""
    import coal

    points = coal.StdVec_Vec3s()
    for x in body.vertices:
        points.append(np.asarray(x, float))
    return coal.Convex.convexHull(points, False, "Qt")


def distance(a, pose_a, b, pose_b):
    """Of two shapes of coal in their poses; negative where they overlap."""
    import coal

    places = [coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in (pose_a, pose_b)]
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    return coal.distance(a, places[0], b, places[1], request, result)
