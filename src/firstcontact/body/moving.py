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

        Pieces of the motion are enclosed by the poses at 65 times, padded by the largest arc between them.
        """
        lo, hi = self.motion.span if span is None else span
        times = np.linspace(lo, hi, 65)
        corners = np.array([self.motion(float(t)) for t in times])
        points = self.body.vertices @ corners[:, :3, :3].transpose(0, 2, 1) + corners[:, None, :3, 3]
        step = np.abs(np.diff(points, axis=0)).max(initial=0.0)
        return points.min(axis=(0, 1)) - step, points.max(axis=(0, 1)) + step

    def __repr__(self) -> str:
        return f"{self.body!r} moving by {self.motion!r}"

    def __reduce__(self) -> Any:
        return Moving, (self.body, self.motion)
