"""How far points of links pass from where they are in the middle of a stretch of time, by the speeds of the joints.

A point p is at F(s) G(s) p, G the pose by the joints beyond one joint, F that by it.  If G(s) p stays within m of its
place y in the middle, then F(s) G(s) p stays within m of F(s) y, as F(s) keeps distances, and so within m + w d + v of
its own place in the middle: w and v bound how far the joint turns and advances from the middle on, d is the distance of
y from the axis.  So one walk along the joints bounds all of a stretch, and NumPy takes all stretches at once.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.exact.numbers import to_double
from firstcontact.exact.vectors import dot
from firstcontact.motion.linkage import Linkage
from firstcontact.motion.screw import Screw
from firstcontact.motion.translation import Translation

if TYPE_CHECKING:
    from firstcontact.motion.rotation import Rotation

# Beside the sizes met: far more than the roundings of a walk along all joints.
_SLACK = 1e-13
_POWERS = np.arange(4)


def places(motion: Linkage, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where points (k, 3) are in the middle of each stretch, (stretches, k, 3), and how far from there they pass at
    most, (stretches, k)."""
    count = len(motion.times) - 1
    x = np.broadcast_to(points, (count, *points.shape))
    far = np.zeros((count, len(points)))
    size = np.full((count, 1), float(np.abs(points).max(initial=0.0)))
    for drive in reversed(motion.drives):
        value = drive.doubles
        middle, swing = value @ 0.5**_POWERS, 0.5 * np.abs(value) @ _POWERS
        blur = _SLACK * np.abs(value).sum(axis=1)
        axis, point, angle, ahead = line_of(drive.motion)
        size = size + np.abs(point).max() + np.linalg.norm(ahead) * np.abs(middle)[:, None]
        if angle:
            arm = x - point
            x = point + arm @ _turned(axis, angle * middle).transpose(0, 2, 1)
            turned = arm @ _cross(axis).T
            far = far + abs(angle) * (swing + blur)[:, None] * np.sqrt(np.einsum("nki,nki->nk", turned, turned))
        if ahead.any():
            x = x + middle[:, None, None] * ahead
            far = far + np.linalg.norm(ahead) * (swing + blur)[:, None]
    return x, far * (1.0 + _SLACK) + _SLACK * size


def _cross(axis: np.ndarray) -> np.ndarray:
    """(3, 3) that takes a vector to axis x vector."""
    x, y, z = axis
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _turned(axis: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """(n, 3, 3) of turns about a unit axis (Rodrigues)."""
    cosine, sine = np.cos(angles)[:, None, None], np.sin(angles)[:, None, None]
    turns: np.ndarray = cosine * np.eye(3) + sine * _cross(axis) + (1.0 - cosine) * np.outer(axis, axis)
    return turns


@lru_cache(maxsize=1024)
def line_of(motion: Rotation | Screw) -> tuple[np.ndarray, np.ndarray, float, np.ndarray]:
    """Unit axis (3,), point (3,), radians and way (3,) of one unit of a joint's value."""
    if isinstance(motion, Translation):
        return np.zeros(3), np.zeros(3), 0.0, np.array([to_double(x) for x in motion.vector])
    length = math.sqrt(to_double(dot(motion.axis, motion.axis)))
    axis = np.array([to_double(x) for x in motion.axis]) / length
    point = np.array([to_double(x) for x in motion.point])
    return axis, point, motion.radians, to_double(motion.advance) * axis
