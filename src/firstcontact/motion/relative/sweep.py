"""Boxes that hold points under a motion at all times of a span; floats, rounded outward."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq

from firstcontact.errors import InputError
from firstcontact.exact.numbers import to_double
from firstcontact.motion.linkage import Linkage
from firstcontact.motion.rational import RationalMotion
from firstcontact.motion.relative.reach import places
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw
from firstcontact.motion.steps import steps_of
from firstcontact.motion.translation import Translation

if TYPE_CHECKING:
    from firstcontact.motion.kinds import AnyMotion, Single

Box = tuple[np.ndarray, np.ndarray]

# Poses per full turn that stand for an arc.  Between two of them, an angle x apart, a point is at most r x^2 / 8 off
# its chord c = 2 r sin(x / 2), in any direction across the axis, and level with it along the axis: BULGE x c.
PER_TURN = 64
BULGE = 0.1252  # > (x / 2) / sin(x / 2) / 8 for x <= 2 pi / 64
# Far more than the rounding of a few products of poses, relative to the largest number in them.
ROUNDING = 1e-13
# Of the size of a body: what poses in doubles may misplace its points by, else they are rounded once.
FINE = 1e-12
# Points times poses whose places are worked out together.
AT_ONCE = 20_000
# Equal parts of a rational motion whose control points are taken.
PARTS = 8


def swept_box(motion: AnyMotion, first: float, last: float, points: np.ndarray, error: float) -> Box:
    """(lower, upper) corner (3,) of a box with all that lies within `error` of the points (n, 3), while they move.

    last may be infinite; so is the box then where a translation or a screw goes on for ever.
    """
    lo, hi = swept_boxes(motion, first, last, points[None], error)
    return lo[0], hi[0]


def swept_boxes(motion: AnyMotion, first: float, last: float, groups: np.ndarray, error: float) -> Box:
    """(lower, upper) corners (k, 3) of such a box for each group (k, n, 3) of points."""
    if isinstance(motion, Linkage):
        return _boxes_of_link(motion, first, last, groups, error)
    lo, hi = np.full((len(groups), 3), np.inf), np.full((len(groups), 3), -np.inf)
    for step, t0, t1, before in _steps(motion, first, last):
        linear, shift = before[:, :3], before[:, 3]
        placed = groups @ linear.T + shift
        size = max(np.abs(groups).max() * np.abs(linear).sum(axis=1).max(), np.abs(shift).max())
        blur = error * _stretch(linear) + ROUNDING * size
        step_lo, step_hi = _step_boxes(step, t0, t1, placed, blur)
        lo, hi = np.minimum(lo, step_lo), np.maximum(hi, step_hi)
    return lo, hi


def _boxes_of_link(motion: Linkage, first: float, last: float, groups: np.ndarray, error: float) -> Box:
    """The same by how far the corners of a box around each group pass in each stretch of time."""
    own = motion.during(fmpq(*first.as_integer_ratio()), fmpq(*last.as_integer_ratio()))
    ends = np.stack([groups.min(axis=1), groups.max(axis=1)], axis=1)
    corners = np.stack([ends[:, which, range(3)] for which in itertools.product((0, 1), repeat=3)], axis=1)
    lo, hi = np.empty((len(groups), 3)), np.empty((len(groups), 3))
    count = max(1, AT_ONCE // (8 * len(own.times)))
    for k in range(0, len(groups), count):
        some = slice(k, k + count)
        middles, far = places(own, corners[some].reshape(-1, 3))
        pad = far[..., None]
        low, high = ((middles + side * pad).reshape(len(middles), -1, 8, 3) for side in (-1, 1))
        lo[some], hi[some] = low.min(axis=(0, 2)), high.max(axis=(0, 2))
    return _grown(lo, hi, error * _stretch(np.eye(3)), groups)


def _steps(motion: AnyMotion, first: float, last: float) -> Iterator[tuple[Single, float, float, np.ndarray]]:
    """(step, t0, t1, pose (3, 4) before it), t0 and t1 in the step's own clock, rounded outward."""
    for step in steps_of(motion):
        if step.end is None:
            yield step.motion, first, last, np.eye(4)[:3]
            return
        start, length = to_double(step.origin), to_double(step.unit)
        slack = 4e-16 * (abs(start) + length) / length
        t0, t1 = (first - start) / length - slack, (last - start) / length + slack
        if t0 <= 1 and t1 >= 0:
            yield step.motion, max(t0, 0.0), min(t1, 1.0), step.before.doubles()[:3]


def _step_boxes(step: Single, t0: float, t1: float, points: np.ndarray, blur: float) -> Box:
    """The boxes of groups (k, n, 3) of points, each within `blur`, under one step."""
    if isinstance(step, Translation):
        lo, hi = _ahead(np.array([to_double(x) for x in step.vector]), t0, t1)
        return _grown(points.min(axis=1) + lo, points.max(axis=1) + hi, blur, points)
    if isinstance(step, RationalMotion):
        controls, stretch = _controls(step, t0, t1)
        lo, hi, _, size = _hull(controls, points)
        return _grown(lo, hi, blur * stretch, size)
    step = _precise(step)
    if not isinstance(step, Screw):
        raise InputError(f"the bounds of a body under {step!r} are not known; give one of the motions of firstcontact")
    turns = abs(step.radians) * (t1 - t0) / (2 * math.pi) if step.radians else 0.0
    advance, ahead = _advance(step), (np.zeros(3), np.zeros(3))
    if turns > 1 or math.isinf(t1):  # the circle, or the point where nothing turns, with all of the advance added
        step, ahead = Screw(step.axis, step.point, **{step.unit: step.angle}), _ahead(advance, t0, t1)
        t0, t1 = (0.0, 2 * math.pi / abs(step.radians)) if turns else (0.0, 0.0)
        turns = min(turns, 1.0)
    parts = max(1, math.ceil(PER_TURN * turns))
    times = np.linspace(t0, t1, parts + 1)
    poses, off = _poses(step, times, float(np.abs(points).max()))
    lo, hi, chord, size = _hull(poses, points)
    bulge = BULGE * (2 * math.pi * turns / parts) * chord
    return _grown(lo + ahead[0], hi + ahead[1], blur + bulge + off, size)


@lru_cache(maxsize=64)
def _controls(step: RationalMotion, t0: float, t1: float) -> tuple[np.ndarray, float]:
    """Poses in whose hull points stay, and how much they stretch: once for all bodies that the motion moves."""
    controls = step.controls(fmpq(*t0.as_integer_ratio()), fmpq(*t1.as_integer_ratio()), PARTS)
    return controls, max(map(_stretch, controls[:, :3, :3]))


def _poses(step: Screw, times: np.ndarray, size: float) -> tuple[np.ndarray, float]:
    """Poses (n, 4, 4), and by how much they misplace points so far from the origin: in doubles where that is little."""
    point, angle = np.array([to_double(x) for x in step.point]), step.radians
    across = size + float(np.abs(point).max())
    off = 1e-14 * (1.0 + abs(angle) * float(np.abs(times).max())) * across
    if not off <= FINE * size:
        return np.array([step(float(t)) for t in times]), 0.0
    axis = np.array([to_double(x) for x in step.axis])
    (x, y, z) = axis / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned = angle * times[:, None, None]
    poses = np.tile(np.eye(4), (len(times), 1, 1))
    poses[:, :3, :3] += np.sin(turned) * cross + (1.0 - np.cos(turned)) * (cross @ cross)
    poses[:, :3, 3] = point - poses[:, :3, :3] @ point + times[:, None] * _advance(step)
    return poses, off


def _precise(step: Single) -> Single:
    """A Rotation as a Screw, whose poses are rounded once, however far the axis or large the angle."""
    return Screw(step.axis, step.point, **{step.unit: step.angle}) if isinstance(step, Rotation) else step


def _hull(poses: np.ndarray, groups: np.ndarray) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Boxes of the groups (k, n, 3) in all poses, longest way of a point between neighbouring poses, largest number
    met."""
    points = groups.reshape(-1, 3)
    if len(points) * len(poses) <= AT_ONCE:
        moved = points @ poses[:, :3, :3].transpose(0, 2, 1) + poses[:, None, :3, 3]
        steps = moved[1:] - moved[:-1]
        chord = float(np.sqrt((steps * steps).sum(axis=2).max(initial=0.0)))
        sizes = np.abs(points).max() * np.abs(poses[:, :3, :3]).sum(axis=2).max(), np.abs(poses[:, :3, 3]).max()
        moved = moved.reshape(len(poses), *groups.shape)
        return moved.min(axis=(0, 2)), moved.max(axis=(0, 2)), chord, float(max(sizes))
    lo, hi = np.full((len(groups), 3), np.inf), np.full((len(groups), 3), -np.inf)
    chord, size, last = 0.0, 0.0, None
    for pose in poses:
        linear, shift = pose[:3, :3], pose[:3, 3]
        moved = groups @ linear.T + shift
        lo, hi = np.minimum(lo, moved.min(axis=1)), np.maximum(hi, moved.max(axis=1))
        if last is not None:
            chord = max(chord, float(np.linalg.norm(moved - last, axis=2).max()))
        size = max(size, np.abs(points).max() * np.abs(linear).sum(axis=1).max(), np.abs(shift).max())
        last = moved
    return lo, hi, chord, size


def _advance(step: Screw) -> np.ndarray:
    """Velocity (3,) along the axis."""
    axis = np.array([to_double(x) for x in step.axis])
    return to_double(step.advance) * axis / np.linalg.norm(axis)


def _ahead(velocity: np.ndarray, t0: float, t1: float) -> Box:
    """Least and largest shift (3,) from t0 to t1; zero velocity stays zero for ever."""
    ways = [np.where(velocity == 0, 0.0, velocity) * t if math.isfinite(t) else
            np.where(velocity == 0, 0.0, np.copysign(np.inf, velocity)) for t in (t0, t1)]  # fmt: skip
    return np.minimum(*ways), np.maximum(*ways)


def _stretch(linear: np.ndarray) -> float:
    """Bound of how much a linear map (3, 3) lengthens a vector."""
    return float(np.linalg.norm(linear)) * (1 + 1e-12)


def _grown(lo: np.ndarray, hi: np.ndarray, blur: float, *sizes: float | np.ndarray) -> Box:
    size = max(float(np.abs(x).max()) for x in (*sizes, *(np.where(np.isfinite(x), x, 0.0) for x in (lo, hi))))
    pad = blur + ROUNDING * size
    return lo - pad, hi + pad
