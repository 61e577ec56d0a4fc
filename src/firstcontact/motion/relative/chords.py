"""How far points pass from where they are between two poses, of a motion through many of them.

An arc of at most half a turn lies in the ball that has its chord as a diameter.  Under "linear-quaternion" the frame's
origin goes straight, and R(t) c stays on such an arc about the axis of the turn: c(t) stays within half of both chords
of the middle of its own.  Under "screw" it goes round such an arc and along the axis, at right angles: within half of
its one chord.  NumPy takes all stretches at once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from firstcontact.exact.numbers import to_double

if TYPE_CHECKING:
    from firstcontact.motion.trajectory import Trajectory

_SLACK = 1e-13
"""Beside the sizes met: far more than the roundings here, and than what screws end beside the next pose."""


def places(motion: Trajectory, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where points (k, 3) are in the middle of each stretch, (stretches, k, 3), and how far from there they pass at
    most, (stretches, k): nan where doubles do not tell."""
    shifts, turns = _doubles(motion)
    turned: np.ndarray = points @ turns.transpose(0, 2, 1)
    x = shifts[:, None] + turned
    middles = 0.5 * (x[1:] + x[:-1])
    if motion.interpolation == "screw":
        far = _half_chords(x)
    else:
        far = _half_chords(shifts[:, None]) + _half_chords(turned)
    sizes = np.abs(shifts).max(axis=1) + 2.0 * np.linalg.norm(points, axis=1).max(initial=0.0)
    return middles, far * (1.0 + _SLACK) + _SLACK * np.maximum(sizes[1:], sizes[:-1])[:, None]


def _half_chords(x: np.ndarray) -> np.ndarray:
    steps: np.ndarray = x[1:] - x[:-1]
    half: np.ndarray = 0.5 * np.sqrt(np.einsum("nki,nki->nk", steps, steps))
    return half


def _doubles(motion: Trajectory) -> tuple[np.ndarray, np.ndarray]:
    """Vectors (n, 3) and rotations (n, 3, 3) of the poses."""
    shifts = np.array([[to_double(x) for x in pose.vector] for pose in motion.poses])
    with np.errstate(invalid="ignore", over="ignore"):  # numbers beyond the doubles tell nothing
        q = np.array([[to_double(x) for x in pose.quaternion] for pose in motion.poses])
        q /= np.abs(q).max(axis=1, keepdims=True)
        w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return shifts, np.array(rows).transpose(2, 0, 1)
