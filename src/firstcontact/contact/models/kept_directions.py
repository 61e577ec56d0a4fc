"""Directions that bodies keep at all times: all of those that only shift, that of the axis about which others turn.

What is parallel to such a direction, or across it, stays so, in poses that no rational number describes too.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.body.solid.carriers import dot
from firstcontact.contact.models.shared.touched import Flat, coprime
from firstcontact.motion.moving import Moving

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body
    from firstcontact.exact.vectors import Vector
    from firstcontact.motion.kinds import AnyMotion

Axis = tuple[int, ...]
"""A direction by coprime integers, as `Flat.exact` has them."""
SHIFTS: frozenset[Axis] = frozenset()


def turning_axes(a: Body, b: Body) -> frozenset[Axis] | None:
    """The directions of all axes about which the bodies turn, none where they only shift; None where that is not known.

    With more than one of them no direction is kept.
    """
    first = _axes(a.motion) if isinstance(a, Moving) else SHIFTS
    second = _axes(b.motion) if isinstance(b, Moving) else SHIFTS
    return None if first is None or second is None else first | second


def _axes(motion: AnyMotion) -> frozenset[Axis] | None:
    axes: tuple[Vector, ...] | None = getattr(motion, "axes", None)  # which those that are none of ours lack
    return None if axes is None else frozenset(map(coprime, axes))


def stay_parallel(x: Flat, y: Flat, axis: Axis) -> bool:
    """Whether flat things, each told in the frame of its own body, are parallel however these turn about the axis."""
    if x.exact is None or y.exact is None:
        return False
    if (x.direction is None) == (y.direction is None):
        return x.exact == y.exact == axis
    return axis in (x.exact, y.exact) and dot(x.exact, y.exact) == 0
