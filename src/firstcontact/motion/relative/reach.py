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
        axis, point, angle, ahead = _line(drive.motion)
        size = size + np.abs(point).max() + np.linalg.norm(ahead) * np.abs(middle)[:, None]
        if angle:
            arm = x - point
            along = (arm @ axis)[..., None] * axis
            across, turned = arm - along, np.cross(axis, arm)
            turn = (angle * middle)[:, None, None]
            x = point + along + np.cos(turn) * across + np.sin(turn) * turned
            far = far + abs(angle) * (swing + blur)[:, None] * np.linalg.norm(turned, axis=-1)
        if ahead.any():
            x = x + middle[:, None, None] * ahead
            far = far + np.linalg.norm(ahead) * (swing + blur)[:, None]
    return x, far * (1.0 + _SLACK) + _SLACK * size


@lru_cache(maxsize=1024)
def _line(motion: Rotation | Screw) -> tuple[np.ndarray, np.ndarray, float, np.ndarray]:
    """Unit axis (3,), point (3,), radians and way (3,) of one unit of a joint's value."""
    if isinstance(motion, Translation):
        return np.zeros(3), np.zeros(3), 0.0, np.array([to_double(x) for x in motion.vector])
    length = math.sqrt(to_double(dot(motion.axis, motion.axis)))
    axis = np.array([to_double(x) for x in motion.axis]) / length
    point = np.array([to_double(x) for x in motion.point])
    ahead = to_double(motion.advance) * axis if isinstance(motion, Screw) else np.zeros(3)
    return axis, point, motion.radians, ahead
