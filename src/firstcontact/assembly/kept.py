"""Planes and quadrics that motions carry into themselves, decided exactly.

The poses of a translation, a rotation or a screw are those of one-parameter groups exp(s G); what every G keeps, all
poses keep, those of sequences too.
"""

from __future__ import annotations

from collections.abc import Sequence as Listing
from typing import TYPE_CHECKING

from flint import fmpq

from firstcontact.body.solid.carriers import Plane, Rows, Surface, Vector, times, transposed
from firstcontact.exact.vectors import cross
from firstcontact.motion.moving import Moving
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw
from firstcontact.motion.steps import steps_of
from firstcontact.motion.translation import Translation

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Shape
    from firstcontact.motion.kinds import Single

_0 = fmpq(0)
NO_ROW: Vector = (_0, _0, _0, _0)


def generators(bodies: Listing[Body], first: fmpq, last: fmpq | None) -> list[Rows] | None:
    """The G (4, 4) of all motions of the bodies from first to last; None where a motion is of no such kind."""
    found: list[Rows] = []
    for body in bodies:
        for step in steps_of(body.motion) if isinstance(body, Moving) else ():
            if step.end is not None and step.end <= first or last is not None and step.start >= last:
                continue
            own = _of_motion(step.motion)
            if own is None:
                return None
            found += own
    return found


def step_ends(bodies: Listing[Body], first: fmpq, last: fmpq | None) -> list[fmpq]:
    """The times between first and last at which a step of a motion ends, ascending."""
    ends = {step.end for body in bodies if isinstance(body, Moving) for step in steps_of(body.motion)}
    return sorted(t for t in ends if t is not None and first < t and (last is None or t < last))


def standing(body: Body, time: fmpq) -> Shape | None:
    """The shape of the body where it stands at that time; None where no rational numbers tell."""
    if not isinstance(body, Moving):
        return body
    steps = list(steps_of(body.motion))
    step = next((x for x in steps if x.end is None or time < x.end), steps[-1])
    pose = step.pose(time)
    if not pose.is_exact:
        return None
    placed: Shape = body.body._mapped(pose.matrix()) if pose.factors else body.body
    return placed


def _of_motion(motion: Single) -> list[Rows] | None:
    if isinstance(motion, Translation):
        return [_shift(motion.vector)]
    if isinstance(motion, Rotation):
        return [_turn(motion.axis, motion.point)]
    if isinstance(motion, Screw):
        return [_turn(motion.axis, motion.point), *([_shift(motion.axis)] if motion.advance else [])]
    return None


def _shift(v: Listing[fmpq]) -> Rows:
    return (_0, _0, _0, v[0]), (_0, _0, _0, v[1]), (_0, _0, _0, v[2]), NO_ROW


def _turn(axis: Vector, point: Vector) -> Rows:
    x, y, z = axis
    k, m, n = cross(point, axis)
    return (_0, -z, y, k), (z, _0, -x, m), (-y, x, _0, n), NO_ROW


def is_kept(surface: Surface, by: Listing[Rows]) -> bool:
    """Whether all poses carry the surface into itself."""
    return all(_vanishes(surface, g) for g in by)


def _vanishes(surface: Surface, g: Rows) -> bool:
    """Whether the derivative of the surface's form along the motion is zero."""
    if isinstance(surface, Plane):
        return not any(any(row) for row in times((surface.normal,), g))
    product = times(surface.form, g)
    return not any(x + y for row, other in zip(product, transposed(product), strict=True)
                   for x, y in zip(row, other, strict=True))  # fmt: skip
