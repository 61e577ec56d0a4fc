"""Planes and quadrics that motions carry into themselves, or off which bodies part, decided exactly.

The poses of a translation, a rotation or a screw are those of one-parameter groups exp(s G), with s that grows; what
every G keeps, all poses keep, those of sequences too.  A plane that every G keeps or shifts along its normal stays
parallel to itself, and so one height tells how far a body has gone from it.
"""

from __future__ import annotations

from collections.abc import Sequence as Listing
from typing import TYPE_CHECKING

from flint import fmpq

from firstcontact.body.solid.carriers import Plane, Quadric, Rows, Surface, Vector, times, transposed
from firstcontact.exact.numbers import sign
from firstcontact.exact.vectors import scaled, sub
from firstcontact.motion.moving import Moving
from firstcontact.motion.rotation import Rotation, sense_about
from firstcontact.motion.steps import steps_of
from firstcontact.motion.translation import NOWHERE, Translation

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Shape

_0 = fmpq(0)
NO_ROW: Vector = (_0, _0, _0, _0)


def generators(a: Body, b: Body, first: fmpq, last: fmpq | None) -> list[Rows] | None:
    """The G (4, 4) of all motions from first to last; shifts are those of a against b.  None of other kinds of motion.

    Of two motions that are one, seen from b, it is that one's.
    """
    together = _relative(a, b)
    if together is not None:
        return [together]
    found: list[Rows] = []
    for body, way in ((a, 1), (b, -1)):
        for step in steps_of(body.motion) if isinstance(body, Moving) else ():
            if step.end is not None and step.end <= first or last is not None and step.start >= last:
                continue
            own = step.motion.generators
            if own is None:
                return None
            found += [_rows(scaled(way, turn), scaled(way, shift)) for turn, shift in own]
    return found


def _relative(a: Body, b: Body) -> Rows | None:
    """Of bodies that both shift all the time, or turn about one line."""
    x, y = (body.motion if isinstance(body, Moving) else None for body in (a, b))
    if isinstance(x, Translation) and isinstance(y, Translation):
        return _rows(NOWHERE, sub(x.vector, y.vector))
    if isinstance(x, Rotation) and isinstance(y, Rotation) and sense_about(x, y):
        return _rows(*x.generators[0])
    return None


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


def _rows(turn: Vector, shift: Vector) -> Rows:
    x, y, z = turn
    k, m, n = shift
    return (_0, -z, y, k), (z, _0, -x, m), (-y, x, _0, n), NO_ROW


def parting(surface: Surface, by: Listing[Rows]) -> int | None:
    """0 where all poses of both bodies carry the surface into itself.  Else the side of a plane, as the sign of its
    form, to which a goes off from b: neither ever comes back any of the way, nor do they turn against the plane.

    None where it is neither.
    """
    if not isinstance(surface, Plane):
        return 0 if all(_vanishes(surface, g) for g in by) else None
    rates = [times((surface.normal,), g)[0] for g in by]
    if any(any(turned) for *turned, _ in rates):
        return None
    ways = {sign(shift) for *_, shift in rates} - {0}
    return None if len(ways) > 1 else next(iter(ways), 0)


def _vanishes(surface: Quadric, g: Rows) -> bool:
    """Whether the derivative of the surface's form along the motion is zero."""
    product = times(surface.form, g)
    return not any(x + y for row, other in zip(product, transposed(product), strict=True)
                   for x, y in zip(row, other, strict=True))  # fmt: skip
