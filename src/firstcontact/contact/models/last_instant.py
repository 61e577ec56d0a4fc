"""Contact at one rational instant, where a turning body lands or grazes: decided although its pose may be irrational.

Where the poses are rational the bodies are looked at as they stand.  Else the one that turns is looked at in a rational
pose beside the true one, turned about the same axis by some 2^-60 more or less.
Surfaces that are round about that axis are the same in both, and what is not nearly zero keeps its sign.  So a common
point that is in nothing but such surfaces of the other body rides with its own body to a true common point.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from flint import arb, fmpq

from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.revolution import is_same
from firstcontact.contact.models.algorithm import CandidateSearch, Meeting
from firstcontact.contact.models.moving_pair import Form, MovingPair, form_at, is_plane
from firstcontact.exact.fields.number_field import ball
from firstcontact.exact.numbers import dyadic, precision
from firstcontact.exact.polynomials.inertia import dot, value
from firstcontact.exact.rigid import Matrix, compose, near_rotation, rational_sqrt, shift
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative.pieces import placement_at
from firstcontact.motion.relative.polynomial import relative_pieces
from firstcontact.motion.rotation import Rotation, angle_ball
from firstcontact.motion.screw import Screw

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Model

CLEAR = 2.0**-40
"""Part of the size of its terms beyond which a form keeps its sign while the body turns by 2^-58 radians."""
BITS = 128


def landing(a: Model, b: Model, t: fmpq) -> tuple[CandidateSearch, list[Meeting]] | None:
    """Features that share a point at time t, proved, with the search in which they were found; None where none are."""
    placed = [_placed(x, t) for x in (a, b)]
    if placed[0] is None or placed[1] is None:
        return None
    bodies, motions = (placed[0][0], placed[1][0]), [m for _, m in placed if m is not None]  # type: ignore[misc]
    if len(motions) > 1:
        return None
    motion = motions[0] if motions else None
    for piece in relative_pieces(*bodies, fmpq(0), fmpq(0)):
        search = CandidateSearch(MovingPair(shape_of(bodies[0]), shape_of(bodies[1]), piece))
        meetings = [m for m in search.at_start() or () if motion is None or is_kept(search.pair, m, motion)]
        return (search, meetings) if meetings else None
    return None


def _placed(body: Model, t: fmpq) -> tuple[CompositeQuadric, Rotation | Screw | None] | None:
    """(the body at rest where it stands at t, None), or where it nearly does, with the motion that takes it there."""
    near = near_pose(body, t)
    if near is None:
        return None
    pose, motion = near
    model: CompositeQuadric = shape_of(body)
    return model if pose is None else model.transformed([*pose, (0, 0, 0, 1)]), motion


def near_pose(body: Body, t: fmpq) -> tuple[Matrix | None, Rotation | Screw | None] | None:
    """(the rational pose in which it stands at t, None), or one nearby, with the motion that takes it there.

    The pose of a body at rest is None.  None where neither pose is rational.
    """
    if not isinstance(body, Moving):
        return None, None
    motion, there = body.motion, placement_at(body, t)
    if there.is_exact:
        return there.matrix(), None
    if not isinstance(motion, Rotation | Screw):
        return None
    turns = motion.angle * t
    if motion.unit == "radians":
        with precision(BITS):
            turns = dyadic((angle_ball(turns, "radians") / (2 * arb.pi())).mid())
    pose = near_rotation(motion.axis, motion.point, turns)
    if motion.advance == 0:
        return pose, motion
    length = rational_sqrt(dot(motion.axis, motion.axis))
    if length is None:
        return None
    x, y, z = (motion.advance * t * c / length for c in motion.axis)
    return compose(shift((x, y, z)), pose), motion


def is_kept(pair: MovingPair, meeting: Meeting, motion: Rotation | Screw) -> bool:
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
