"""A body under a motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.errors import InputError

if TYPE_CHECKING:
    from firstcontact.body.polyhedron import Polyhedron


class Moving:
    """A body and its motion; `.at(t)` is the body at rest in its pose at time t."""

    __slots__ = ("body", "motion")

    def __init__(self, body: Polyhedron, motion: Any) -> None:
        if not callable(motion) or not hasattr(motion, "span"):
            raise InputError(f"{motion!r} is no motion; give Translation, Rotation or Sequence")
        self.body = body
        self.motion = motion

    @property
    def name(self) -> str | None:
        return self.body.name

    def named(self, name: str) -> Moving:
        return Moving(self.body.named(name), self.motion)

    def at(self, t: float) -> Polyhedron:
        """The body at rest in its pose at time t; the pose's entries are the doubles of motion(t)."""
        return self.body.transformed(self.motion(t))

    def bounds(self, span: tuple[float, float] | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner, (3,) float64 each, of a box that holds the body at all times of the span.

        Infinite where a translation goes on for ever.
        """
        first, last = self.motion.span if span is None else span
        lo, hi = np.full(3, np.inf), np.full(3, -np.inf)
        for t0, t1 in _step_ends(self.motion, float(first), float(last)):
            step_lo, step_hi = self._step_bounds(t0, t1)
            lo, hi = np.minimum(lo, step_lo), np.maximum(hi, step_hi)
        return lo, hi

    def _step_bounds(self, t0: float, t1: float) -> tuple[np.ndarray, np.ndarray]:
        """The box of one straight or turning step: the boxes of some poses, grown by what lies between them.

        Between two poses of a turn by at most 2 pi / 64 a point leaves its chord by at most the sagitta,
        chord / 2 * tan(pi / 128); a straight step stays between its ends; after a full turn nothing new is reached.
        """
        if np.isinf(t1):
            (lo, hi), ahead = self._step_bounds(t0, t0 + 1.0), self.motion(t0 + 1.0)[:3, 3] - self.motion(t0)[:3, 3]
            return np.where(ahead < 0, -np.inf, lo), np.where(ahead > 0, np.inf, hi)
        middle = 0.5 * (t0 + t1)
        turn = _turned_by(self.motion, middle) * (t1 - t0)
        if turn > 2 * np.pi:
            t1, turn = t0 + (t1 - t0) * (2 * np.pi / turn), 2 * np.pi
        count = max(2, int(np.ceil(turn * 64 / (2 * np.pi))) + 1)
        poses = np.array([self.motion(float(t)) for t in np.linspace(t0, t1, count)])
        points = self.body.vertices @ poses[:, :3, :3].transpose(0, 2, 1) + poses[:, None, :3, 3]
        reach = np.linalg.norm(points.max(axis=(0, 1)) - points.min(axis=(0, 1)))
        size = np.abs(points).max() + reach
        pad = (0.5 * np.tan(np.pi / 128) * reach if turn > 0 else 0.0) + self.body.error + 1e-13 * size
        return points.min(axis=(0, 1)) - pad, points.max(axis=(0, 1)) + pad

    def __repr__(self) -> str:
        return f"{self.body!r} moving by {self.motion!r}"

    def __reduce__(self) -> Any:
        return Moving, (self.body, self.motion)


def _step_ends(motion: Any, first: float, last: float) -> list[tuple[float, float]]:
    """The span cut where the steps of the motion end."""
    cuts = [float(e.p) / float(e.q) for e in getattr(motion, "ends", ())]
    times = [first, *(t for t in cuts if first < t < last), last]
    return list(zip(times, times[1:], strict=False))


def _turned_by(motion: Any, time: float) -> float:
    """The angular speed (radians per unit of time) of the step at that time."""
    start = 0.0
    for step, end in zip(getattr(motion, "steps", ()), getattr(motion, "ends", ()), strict=True):
        stop = float(end.p) / float(end.q)
        if time <= stop:
            return abs(getattr(step, "radians", 0.0)) / (stop - start)
        start = stop
    return abs(getattr(motion, "radians", 0.0))
