"""Poses of a motion at few times, dense enough that a constant-speed screw between them is the motion.

Between two samples the page turns and shifts at constant speed about and along one axis, which is exact for
translations, rotations and screws; other motions are sampled until it is near enough to look at.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

Pose = np.ndarray

# Neighbouring samples differ by less than this, so that the short way round is the way the motion takes.
LARGEST_TURN = math.radians(100)
# Deviation of the interpolation, as a part of the body's size: far below a pixel.
TOLERANCE = 1e-5
# Enough for about a thousand turns (half a megabyte); beyond that the picture is approximate between samples.
MOST_SAMPLES = 6000


def sample_poses(
    pose: Callable[[float], Pose], times: Sequence[float], size: float
) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) ascending and poses (n, 4, 4): those asked for, exactly, and as many more as are needed.

    pose: rigid (4, 4) pose at a time.  size: radius of the body about the origin of its frame.
    """
    samples = {t: pose(t) for t in times}
    waiting = list(zip(times, times[1:], strict=False))
    # Every interval in `waiting` is unchecked; each turn accepts one or halves it, down to adjacent doubles.
    while waiting and len(samples) < MOST_SAMPLES:
        lo, hi = waiting.pop()
        mid = lo + (hi - lo) / 2
        if not lo < mid < hi or _is_close(pose, lo, hi, samples[lo], samples[hi], size):
            continue
        samples[mid] = pose(mid)
        waiting += [(mid, hi), (lo, mid)]
    ordered = sorted(samples)
    return np.array(ordered), np.array([samples[t] for t in ordered])


def _is_close(
    pose: Callable[[float], Pose], lo: float, hi: float, start: Pose, end: Pose, size: float
) -> bool:
    turn, shift = _twist(start, end)
    if np.linalg.norm(turn) > LARGEST_TURN:
        return False
    # Two checks at incommensurable places: whole turns between samples cannot hide from both.
    for part in (0.5, 0.3819660112501051):
        error = screw_between(start, turn, shift, part) - pose(lo + part * (hi - lo))
        if np.abs(error[:3, :3]).max() * size + np.abs(error[:3, 3]).max() > TOLERANCE * size:
            return False
    return True


def _twist(start: Pose, end: Pose) -> tuple[np.ndarray, np.ndarray]:
    """Rotation vector and linear part of the screw that carries `start` to `end` (turn below pi)."""
    rotation = end[:3, :3] @ start[:3, :3].T
    displacement = end[:3, 3] - rotation @ start[:3, 3]
    skew = rotation - rotation.T
    turn = 0.5 * np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
    sine = float(np.linalg.norm(turn))
    angle = math.atan2(sine, 0.5 * (np.trace(rotation) - 1))
    if sine > 0:
        turn = turn * (angle / sine)
    half = 1 / 12 if angle < 1e-4 else 1 / angle**2 - (1 + math.cos(angle)) / (2 * angle * math.sin(angle))
    once = np.cross(turn, displacement)
    return turn, displacement - 0.5 * once + half * np.cross(turn, once)


def screw_between(start: Pose, turn: np.ndarray, shift: np.ndarray, part: float) -> Pose:
    """Pose after `part` of the screw (turn, shift) from pose `start`."""
    turn, shift = part * turn, part * shift
    angle = float(np.linalg.norm(turn))
    small = angle < 1e-4
    a = 1.0 if small else math.sin(angle) / angle
    b = 0.5 if small else (1 - math.cos(angle)) / angle**2
    c = 1 / 6 if small else (angle - math.sin(angle)) / angle**3
    x, y, z = turn
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    step = np.eye(4)
    step[:3, :3] += a * cross + b * cross @ cross
    step[:3, 3] = shift + b * cross @ shift + c * cross @ cross @ shift
    return step @ start
