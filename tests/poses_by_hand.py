"""Random motions of every class, each with its pose written down from the definition, in plain numpy and scipy."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.linalg import expm, logm
from scipy.spatial.transform import Rotation as Turn

import firstcontact as fc


def shift(v):
    pose = np.eye(4)
    pose[:3, 3] = v
    return pose


def turn(axis, point, radians):
    """About the line through the point along the axis, right-hand rule."""
    pose = np.eye(4)
    axis = np.array(axis, float)
    pose[:3, :3] = Turn.from_rotvec(radians * axis / np.linalg.norm(axis)).as_matrix()
    return shift(point) @ pose @ shift(-np.array(point, float))


def vector(rng, most=3):
    return rng.integers(-most, most + 1, 3).tolist()


def axis_of(rng):
    """Of rational length or not."""
    choices = [(0, 0, 1), (1, 0, 0), (2, -1, 2), (1, 1, 0), (0, -3, 4), (1, 2, 3), (-1, 0, 0)]
    return choices[rng.integers(len(choices))]


def angle_of(rng):
    """(keyword, its value, radians): quarter turns, other parts of turns, whole turns, radians."""
    kind = rng.integers(4)
    if kind == 0:
        k = int(rng.integers(-3, 6))
        return "turns", f"{k}/4", k * np.pi / 2
    if kind == 1:
        k = int(rng.integers(-170, 400))
        return "degrees", k, np.radians(k)
    if kind == 2:
        k = float(rng.uniform(-2, 2))
        return "turns", k, 2 * np.pi * k
    k = float(rng.uniform(-4, 4))
    return "radians", k, k


def translation(rng):
    v = vector(rng)
    return fc.Translation(v), lambda t: shift(t * np.array(v))


def rotation(rng):
    axis, point, (key, value, radians) = axis_of(rng), vector(rng), angle_of(rng)
    return fc.Rotation(axis, point, **{key: value}), lambda t: turn(axis, point, t * radians)


def screw(rng):
    axis, point, (key, value, radians) = axis_of(rng), vector(rng), angle_of(rng)
    advance = int(rng.integers(-6, 7))
    along = advance * np.array(axis) / np.linalg.norm(axis)
    motion = fc.Screw(axis, point, **{key: value}, advance=advance)
    return motion, lambda t: shift(t * along) @ turn(axis, point, t * radians)


def rational(rng):
    """Affine: it stretches, shears and may mirror."""
    start = np.eye(4) * [rng.choice([1, 1, -1]), 1, 1, 1]
    start[:3] += np.triu(rng.integers(-2, 3, (3, 4)), 1)
    change = np.zeros((4, 4))
    change[0, 1:], change[1, 2:], change[2, 3] = rng.integers(-3, 4, 3), rng.integers(-3, 4, 2), rng.integers(-3, 4)
    change[2, 2] = rng.integers(0, 4)
    slower = np.zeros((4, 4))
    slower[3, 3] = rng.integers(0, 3)

    def pose(t):
        m = start + t * change + t * t * slower
        return m / m[3, 3]

    return fc.RationalMotion([start, change, slower]), pose


def placed(rng):
    """A rigid pose: (quaternion xyzw, vector)."""
    return Turn.random(rng=rng).as_quat(), rng.uniform(-3, 3, 3)


def on_line(p, q, t):
    """Between two poses, by the line of unit quaternions, the short way, and the line of vectors."""
    (a, v), (b, w) = p, q
    b = b if a @ b > 0 else -b
    pose = shift((1 - t) * v + t * w)
    pose[:3, :3] = Turn.from_quat((1 - t) * a + t * b).as_matrix()
    return pose


def by_screw(p, q):
    """From a pose to the next at constant speed about and along one axis."""
    start, end = on_line(p, q, 0), on_line(p, q, 1)
    twist = np.real(logm(end @ np.linalg.inv(start)))
    return lambda t: expm(t * twist) @ start


def by_line(p, q):
    return lambda t: on_line(p, q, t)


def between(rng):
    p, q = placed(rng), placed(rng)
    return (
        fc.RationalMotion.between(p[1], q[1], quat_xyzw=[p[0], q[0]]),
        lambda t: on_line(p, q, t),
    )


def trajectory(rng, interpolation, way):
    poses = [placed(rng) for _ in range(4)]
    times = np.array([0, 0.25, 0.625, 1])
    ways = [way(p, q) for p, q in pairwise(poses)]
    motion = fc.Trajectory(times, [v for _, v in poses], interpolation, quat_xyzw=[q for q, _ in poses])

    def pose(t):
        k = min(int(np.searchsorted(times, t, "right")), 3) - 1
        return ways[k]((t - times[k]) / (times[k + 1] - times[k]))

    return motion, pose


def sequence(rng, steps=None, durations=None):
    """Of the steps, each after the end of those before it."""
    parts = [kind(rng) for kind in steps or rng.choice([translation, rotation, screw, rational, between], 3)]
    durations = durations or rng.choice([[1 / 3] * 3, [0.25, 0.5, 0.25], [0.125, 0.375, 0.5]])
    times = np.concatenate([[0.0], np.cumsum(durations)])

    def pose(t):
        total = np.eye(4)
        for (_, own), start, end in zip(parts, times, times[1:], strict=False):
            total = own(min(max((t - start) / (end - start), 0.0), 1.0)) @ total
            if t <= end:
                break
        return total

    return fc.Sequence([m for m, _ in parts], None if durations[0] == 1 / 3 else list(durations)), pose


KINDS = {
    "rest": lambda rng: (None, lambda t: np.eye(4)),
    "translation": translation,
    "rotation": rotation,
    "screw": screw,
    "rational": rational,
    "between": between,
    "quaternions": lambda rng: trajectory(rng, "linear-quaternion", by_line),
    "screws": lambda rng: trajectory(rng, "screw", by_screw),
    "sequence": sequence,
    "screw first": lambda rng: sequence(rng, [screw, translation, rotation]),
    "screw between": lambda rng: sequence(rng, [rational, screw, between], [0.5, 0.25, 0.25]),
    "screws only": lambda rng: sequence(rng, [screw, screw, screw]),
}
