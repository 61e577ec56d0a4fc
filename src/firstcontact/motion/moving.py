"""A body under a motion."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from firstcontact.errors import InputError, shown
from firstcontact.motion.translation import Translation
from firstcontact.result import Written

if TYPE_CHECKING:
    from firstcontact.body.kinds import AnyBody
    from firstcontact.body.placing import Placing
    from firstcontact.exact.vectors import Vector
    from firstcontact.motion.kinds import AnyMotion
    from firstcontact.result import Table


class Moving(Written):
    """A body and its motion; `.at(t)` is the body at rest in its pose at time t."""

    __slots__ = ("body", "motion")
    body: Any

    def __init__(self, body: AnyBody | Placing, motion: AnyMotion) -> None:
        if hasattr(body, "as_body"):  # a part or an assembly of a STEP file
            body = body.as_body()
        if not hasattr(body, "moving") and hasattr(body, "wrapped"):  # a shape of build123d or CadQuery
            from firstcontact import from_shape

            body = from_shape(body)
        if not hasattr(body, "moving") and hasattr(body, "faces"):  # a mesh of trimesh
            from firstcontact import Polyhedron

            body = Polyhedron.from_trimesh(body)
        if isinstance(body, Moving):
            raise InputError(f"{body!r} moves already; give one motion, a Sequence for several in turn")
        if isinstance(motion, type) or not callable(motion) or not hasattr(motion, "span"):
            kinds = "Translation, Rotation, Screw, RationalMotion, Sequence or Trajectory"
            raise InputError(f"{motion!r} is no motion; give a {kinds}")
        self.body = body
        self.motion = motion

    @property
    def name(self) -> str | None:
        name: str | None = self.body.name
        return name

    def named(self, name: str | None) -> Moving:
        return Moving(self.body.named(name), self.motion)

    def moving(self, motion: AnyMotion) -> Moving:
        """Refused: it moves already."""
        return Moving(self, motion)

    def at(self, t: float) -> Any:
        """The body at rest in its shape and pose at time t; the pose's entries are the doubles of motion(t)."""
        return self.body.at(t).transformed(self.motion(t))

    def bounds(self, span: tuple[float, float] | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner, (3,) float64 each, of a box that holds the body at all times of the span.

        Infinite where a translation or a screw goes on for ever, and where the body has no end.
        """
        from firstcontact.motion.relative.sweep import swept_box

        try:
            first, last = map(float, self.motion.span if span is None else span)
        except (TypeError, ValueError, OverflowError) as reason:
            raise InputError(f"span is {shown(span)}; give two times (first, last)") from reason
        if not first <= last:
            raise InputError(f"span is {shown(span)}; its end does not lie after its start")
        points, error = hull_points(self.body, (first, last))
        if not np.all(np.isfinite(points)):
            return np.full(3, -np.inf), np.full(3, np.inf)
        return swept_box(self.motion, first, last, points, error)

    def to_dict(self) -> Table:
        """The body's table in a scene file, with that of its motion."""
        return {**self.body.to_dict(), "motion": self.motion._table()}

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Moving):
            return NotImplemented
        return self.motion == other.motion and bool(self.body == other.body)

    def __hash__(self) -> int:
        return hash((self.body, self.motion))

    def __repr__(self) -> str:
        return f"{self.body!r} moving by {self.motion!r}"

    def __reduce__(self) -> tuple[object, ...]:
        return Moving, (self.body, self.motion)


def shape_of(body: AnyBody) -> Any:
    """The body itself, of one that moves or rests."""
    return body.body if isinstance(body, Moving) else body


def pose_of(body: AnyBody, t: float) -> np.ndarray:
    """The (4, 4) float64 pose of a body at time t, the identity of one that rests."""
    return np.asarray(body.motion(t), float) if isinstance(body, Moving) else np.eye(4)


def drift_of(body: AnyBody | Moving) -> Vector | None:
    """The vector by which a body shifts in a unit of time, zero at rest; None of one that does more."""
    if not isinstance(body, Moving):
        return fmpq(0), fmpq(0), fmpq(0)
    return body.motion.vector if isinstance(body.motion, Translation) else None


def hull_points(body: Any, span: tuple[float, float]) -> tuple[np.ndarray, float]:
    """Points (n, 3) whose convex hull, grown by the returned length, holds the body at all times of the span."""
    if isinstance(getattr(body, "vertices", None), np.ndarray):
        return body.vertices, body.error
    return np.array(list(itertools.product(*zip(*body.bounds(span), strict=True)))), 0.0
