"""Contact at the last instant of a span, where a turning body lands: decided although its pose is irrational.

The body is looked at in a rational pose beside the true one, turned about the same axis by some 2^-60 more or less.
Surfaces that are round about that axis are the same in both, and what is not nearly zero keeps its sign.  So a common
point that is in nothing but such surfaces of the other body rides with its own body to a true common point.
"""

from __future__ import annotations

from typing import Any

from flint import arb, fmpq

from firstcontact.body.composite_quadric import CompositeQuadric
from firstcontact.body.moving import Moving, shape_of
from firstcontact.composite.algorithm import Meeting, Search
from firstcontact.composite.idle_turns import is_same
from firstcontact.composite.membership import form_at, is_plane
from firstcontact.composite.moving_pair import Form, Pair
from firstcontact.exact.inertia import dot, value
from firstcontact.exact.number_field import ball
from firstcontact.exact.numbers import dyadic, precision
from firstcontact.exact.rigid import rational_sqrt
from firstcontact.motion.polynomial import relative_pieces
from firstcontact.motion.rotation import Rotation, angle_ball
from firstcontact.motion.screw import Screw
from firstcontact.motion.translation import Translation

CLEAR = 2.0**-40
"""Part of the size of its terms beyond which a form keeps its sign while the body turns by 2^-58 radians."""
BITS = 128


def landing(a: Any, b: Any, t: fmpq) -> tuple[Search, list[Meeting]] | None:
    """Features that share a point at time t, proved, with the search in which they were found; None where none are."""
    bodies = _placed(a, t), _placed(b, t)
    turning = [_turns(x) for x in (a, b)]
    if None in bodies or all(turning):
        return None
    motion = next((x.motion for x, turns in zip((a, b), turning, strict=True) if turns), None)
    if motion is not None and _is_rational(motion, t):
        motion = None
    for piece in relative_pieces(*bodies, fmpq(0), fmpq(0)):
        search = Search(Pair(shape_of(bodies[0]), shape_of(bodies[1]), piece))
        meetings = [m for m in search.at_start() if motion is None or _is_kept(search.pair, m, motion)]
        return (search, meetings) if meetings else None
    return None


def _turns(body: Any) -> bool:
    return isinstance(body, Moving) and isinstance(body.motion, Rotation | Screw)


def _is_rational(motion: Rotation | Screw, t: fmpq) -> bool:
    """Whether the rational turn is the true one: half and quarter turns are (`near_rotation`)."""
    halves = 2 * motion.angle * t
    if motion.unit == "radians":
        return halves == 0
    length = rational_sqrt(dot(motion.axis, motion.axis))
    return halves.q == 1 or (halves.q == 2 and length is not None)


def _placed(body: Any, t: fmpq) -> CompositeQuadric | None:
    """The body at rest where it stands at t, or nearly; None for other motions, and where it has advanced by no
    rational vector."""
    if not isinstance(body, Moving):
        return body
    model, motion = body.body, body.motion
    if isinstance(motion, Translation):
        return model.translated([t * x for x in motion.vector])
    if not isinstance(motion, Rotation | Screw):
        return None
    turns = motion.angle * t
    if motion.unit == "radians":
        with precision(BITS):
            turns = dyadic((angle_ball(turns, "radians") / (2 * arb.pi())).mid())
    placed = model.rotated(motion.axis, degrees=360 * turns, point=motion.point)
    if isinstance(motion, Rotation) or motion.advance == 0:
        return placed
    length = rational_sqrt(dot(motion.axis, motion.axis))
    return None if length is None else placed.translated([motion.advance * t * x / length for x in motion.axis])


def _is_kept(pair: Pair, meeting: Meeting, motion: Rotation | Screw) -> bool:
    """Whether the point, fixed in one of the bodies, stays in the other while the true turn is made up for."""
    u = meeting.candidate.root.enclosure(BITS)
    with precision(BITS):
        point = [ball(c, BITS) for c in meeting.shared.at]
        x = [c / point[3] for c in point]
        return any(
            all(
                is_same(surface, motion.axis, motion.point) or _is_clear(form, u, x, motion)
                for surface, form in zip(body.surfaces, forms, strict=True)
            )
            for body, forms in ((pair.a, pair.forms_a), (pair.b, pair.forms_b))
        )


def _is_clear(moved: Form, u: arb, x: list[arb], motion: Rotation | Screw) -> bool:
    """Whether a form of one body is so far from 0 at x that it is so at all points to which x may turn."""
    form, plane = form_at(moved, u), is_plane(moved)
    reach = [max(abs(c) + 2 * abs(arb(p)) for c, p in zip(x, motion.point, strict=False))] * 3 + [arb(1)]
    if plane:
        there, size = dot(form, x), dot([abs(c) for c in form], reach)
    else:
        there, size = value(form, x), value([[abs(c) for c in row] for row in form], reach)
    return bool(abs(there) > CLEAR * size)
