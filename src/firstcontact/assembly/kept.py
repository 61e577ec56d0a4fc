"""Planes and quadrics that motions carry into themselves, decided exactly.

The poses of a translation, a rotation or a screw are those of one-parameter groups exp(s G); what every G keeps, all
poses keep, those of sequences too.
"""

from __future__ import annotations

from collections.abc import Sequence as Listing
from typing import Any

from flint import fmpq

from firstcontact.body.solid.carriers import Plane, Rows, Surface, Vector, times, transposed
from firstcontact.exact.vectors import cross
from firstcontact.motion.moving import Moving
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw
from firstcontact.motion.sequence import Sequence
from firstcontact.motion.translation import Translation

_0 = fmpq(0)
NO_ROW: Vector = (_0, _0, _0, _0)


def generators(*bodies: Any) -> list[Rows] | None:
    """The G (4, 4) of all motions of the bodies; None where a motion is of no such kind."""
    found: list[Rows] = []
    for body in bodies:
        own = _of_motion(body.motion) if isinstance(body, Moving) else []
        if own is None:
            return None
        found += own
    return found


def _of_motion(motion: Any) -> list[Rows] | None:
    if isinstance(motion, Translation):
        return [_shift(motion.vector)]
    if isinstance(motion, Rotation):
        return [_turn(motion.axis, motion.point)]
    if isinstance(motion, Screw):
        return [_turn(motion.axis, motion.point), *([_shift(motion.axis)] if motion.advance else [])]
    if not isinstance(motion, Sequence):
        return None
    parts = [_of_motion(step) for step in motion.steps]
    known = [part for part in parts if part is not None]
    return [g for part in known for g in part] if len(known) == len(parts) else None


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
