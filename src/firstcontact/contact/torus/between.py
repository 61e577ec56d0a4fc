"""The pose of one body as seen from another one over a stretch of time: its middle, its rate, and proved bounds.

With A and B the poses of both, y = B^-1 A x is where a point x of the one is in the other's frame, and
y'' = B^-1 (A'' x - 2 B' y' - B'' y).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from firstcontact.kernels.poses import accelerations, pose_at
from firstcontact.kernels.workspace import HERE_A, MIDDLE, RADIUS, SPEED, SPREAD, workspace

U = 2.0**-53


class PosedBody(NamedTuple):
    """table: its motion, see `kernels.poses`; pose: (4, 4), what stands before it; off: error of its points."""

    table: np.ndarray
    pose: np.ndarray
    off: float


class Norms(NamedTuple):
    """Bounds of the lengths that a map's linear part and its shift give to unit vectors."""

    linear: float
    shift: float


class Here(NamedTuple):
    """One body at a time and about it: pose (3, 4) and rate, errors of the pose's parts, bounds of both derivatives."""

    pose: np.ndarray
    rate: np.ndarray
    off: Norms
    size: Norms
    first: Norms
    second: Norms


class Places(NamedTuple):
    """Points (n, k, 3) of cells at the middle of a stretch, and how they go on in time s, |s| <= half.

    rates: (n, k, 3); off: (n,) error of places; bend: (n,) bound of second derivatives.
    """

    points: np.ndarray
    rates: np.ndarray
    half: float
    off: np.ndarray
    bend: np.ndarray

    @property
    def blur(self) -> np.ndarray:
        """(n,) how far points may be from places that go on at their rates."""
        blur: np.ndarray = self.off + 0.5 * self.bend * self.half**2
        return blur


class Between:
    def __init__(self, own: PosedBody, other: PosedBody) -> None:
        self.own, self.other = own, other
        self.scratch = workspace()[0]

    def places(self, lo: float, hi: float, x: np.ndarray) -> Places:
        """Where points (n, k, 3) of cells of the one body are in the other's frame over [lo, hi]."""
        middle = lo + 0.5 * (hi - lo)
        half = max(hi - middle, middle - lo)
        a, b = (self._here(body, lo, hi, middle) for body in (self.own, self.other))
        back = np.linalg.inv(b.pose[:, :3])
        linear, shift = back @ a.pose[:, :3], back @ (a.pose[:, 3] - b.pose[:, 3])
        y = x @ linear.T + shift
        rate = a.rate - b.rate @ np.vstack([np.column_stack([linear, shift]), [0.0, 0.0, 0.0, 1.0]])
        rate = back @ rate
        v = x @ rate[:, :3].T + rate[:, 3]
        far, here, speed = (np.sqrt((p * p).sum(axis=2)).max(axis=1) for p in (x, y, v))
        stretch = float(np.linalg.norm(back, 2)) * (1 + 1e-9)
        off = stretch * (a.off.linear * far + a.off.shift + b.off.linear * here + b.off.shift)
        size = a.size.linear * far + a.size.shift + b.size.linear * here + b.size.shift
        off = off + 16 * U * (stretch * size + here)
        off = off + 1e-12 * half * (speed + stretch * (a.first.linear * far + a.first.shift + b.first.shift))
        narrow = 1.0 - stretch * (b.first.linear * half) - 1e-9  # the inverse of B is bounded by stretch / narrow
        if narrow <= 0.0:
            return Places(y, v, half, off, np.full(len(x), np.inf))
        stretch = stretch / narrow
        share = 1.0 - stretch * half * (2.0 * b.first.linear + b.second.linear * half)
        if share <= 0.0:
            return Places(y, v, half, off, np.full(len(x), np.inf))
        bend = a.second.linear * far + a.second.shift + b.second.shift
        bend = bend + 2.0 * b.first.linear * speed + b.second.linear * (here + half * speed)
        return Places(y, v, half, off, stretch * bend / share * (1 + 1e-9))

    def _here(self, body: PosedBody, lo: float, hi: float, middle: float) -> Here:
        w, pose = self.scratch, body.pose
        pose_at(body.table, middle, w, HERE_A)
        here = w[HERE_A].copy()
        accelerations(body.table, lo, hi, w)
        size = _norms(np.abs(_rows(here)) @ np.abs(pose))
        turn, shift = (3.0 * here[12] * float(np.linalg.norm(x)) for x in (pose[:3, :3], pose[:3, 3]))
        off = Norms(turn, 2.0 * here[13] + shift + body.off * size.linear)
        return Here(
            _rows(here) @ pose, _rows(w[SPEED]) @ pose, off, size,
            _enclosed(w[SPEED], w[SPREAD], pose), _enclosed(w[MIDDLE], w[RADIUS], pose),
        )  # fmt: skip


def pose_of(table: np.ndarray, t: float) -> np.ndarray:
    """(4, 4) the pose of a motion at a time, rounded."""
    scratch = workspace()[0]
    pose_at(table, t, scratch, HERE_A)
    rows = scratch[HERE_A]
    return np.vstack([_rows(rows), [0.0, 0.0, 0.0, 1.0]])


def _rows(entries: np.ndarray) -> np.ndarray:
    """(3, 4) of the entries of a pose."""
    return np.column_stack([entries[:9].reshape(3, 3), entries[9:12]])


def _norms(rows: np.ndarray) -> Norms:
    return Norms(float(np.linalg.norm(rows[:, :3])) * (1 + 1e-9), float(np.linalg.norm(rows[:, 3])) * (1 + 1e-9))


def _enclosed(middle: np.ndarray, radius: np.ndarray, pose: np.ndarray) -> Norms:
    near, away = _norms(_rows(middle) @ pose), _norms(_rows(radius) @ np.abs(pose))
    return Norms(near.linear + away.linear, near.shift + away.shift)
