"""Turns that leave a model as it is: a pin about its own axis.  What is left of the motion has rational poses.

Where one body is round about the axis that the other one turns about, and shifts along it at most, both are looked at
from the turning one: there neither turns, as the round one is the same from all around.  It need be round no farther
than the other one comes, with its turn or without: a pin that turns about the axis of its hole in a square plate.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from flint import fmpq

from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.body.solid.revolution import is_same
from firstcontact.contact.carried import carried
from firstcontact.exact.vectors import cross
from firstcontact.motion.moving import Moving, hull_points, shape_of
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw
from firstcontact.motion.translation import Translation
from firstcontact.result import ContactIntervals, FirstContact
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Shape

ORIGIN = (fmpq(0),) * 3
R = TypeVar("R", FirstContact, ContactIntervals)
Span = tuple[float, float]


def ignoring_idle_turns(answer: Callable[[Query], R]) -> Callable[[Query], R]:
    """Decorates what answers queries: it is asked about bodies that hold the same points at all times and turn less."""

    @wraps(answer)
    def asked(query: Query) -> R:
        a, b = (without_idle_turn(body) for body in query.bodies)
        a, b, turn = without_common_turn(a, b, query.span)
        if a is query.a and b is query.b:
            return answer(query)
        found = answer(replace(query, a=a, b=b))
        if turn is None or isinstance(found, ContactIntervals):
            return replace(found, a=query.a, b=query.b)
        return carried(found, turn, query.a, query.b)

    return asked


def without_idle_turn(body: Any) -> Any:
    """The body, or one that holds the same points at all times and only shifts."""
    turn = _turn(body)
    if turn is None or not _is_round(shape_of(body), turn):
        return body
    return Moving(body.body, _ahead(body.motion))


def without_common_turn(a: Any, b: Any, span: Span) -> tuple[Any, Any, Rotation | None]:
    """Both as one sees them that turns with one of them, and that turn; or as they were, and None."""
    if (turn := _turn(b)) is not None and _keeps_near(a, turn, b, span):
        return a, Moving(b.body, _ahead(b.motion)), turn
    if (turn := _turn(a)) is not None and _keeps_near(b, turn, a, span):
        return Moving(a.body, _ahead(a.motion)), b, turn
    return a, b, None


def _turn(body: Body) -> Rotation | None:
    """How the body turns, if it turns at constant speed about one line."""
    if not isinstance(body, Moving) or not isinstance(body.motion, Rotation | Screw):
        return None
    motion = body.motion
    return Rotation(motion.axis, motion.point, **{motion.unit: motion.angle})


def _ahead(motion: Rotation | Screw) -> Translation | Screw:
    """The motion without its turn: a Screw that does not turn where the axis is of irrational length."""
    if isinstance(motion, Rotation):
        return Translation(ORIGIN)
    ahead = Screw(motion.axis, motion.point, turns=0, advance=motion.advance).reduced()
    return Translation(ORIGIN) if isinstance(ahead, Rotation) else ahead


def keeps_along(body: Body, turn: Rotation) -> bool:
    """Whether the body is round about the axis of the turn at all times: it rests, or shifts along it."""
    return _goes_along(body, turn) and _is_round(shape_of(body), turn)


def _keeps_near(body: Body, turn: Rotation, other: Body, span: Span) -> bool:
    """The same, or only as far as the other body comes that makes the turn."""
    assert isinstance(other, Moving)
    if not _goes_along(body, turn):
        return False
    return _is_round(shape_of(body), turn) or _is_round_near(body, turn, other, span)


def _goes_along(body: Body, turn: Rotation) -> bool:
    """Whether the body rests, or shifts along the axis of the turn."""
    if not isinstance(body, Moving):
        return True
    motion = body.motion
    if isinstance(motion, Screw):
        way = motion.axis if motion.angle == 0 else None
    else:
        way = motion.vector if isinstance(motion, Translation) else None
    return way is not None and not any(cross(way, turn.axis))


def _is_round(shape: Shape, turn: Rotation) -> bool:
    """Whether it is a body of revolution about the turn's axis."""
    round_about: bool = shape.is_round(turn.axis, turn.point)
    return round_about


def _is_round_near(body: Body, turn: Rotation, other: Moving, span: Span) -> bool:
    """Whether it is the same set as a model of revolution about the turn's axis where the other body comes."""
    model = shape_of(body)
    if not isinstance(model, CompositeQuadric):
        return False
    if not any(is_same(surface, turn.axis, turn.point) for surface in model.surfaces):
        return False
    if not all(_is_round_in(region(body, other, span), model, turn) for region in (_passage, _region)):
        return False  # nor is it in more of space
    assert isinstance(other.motion, Rotation | Screw)
    unturned = Moving(other.body, _ahead(other.motion))
    return _is_round_in(_region(body, other, span, unturned), model, turn)


def _is_round_in(region: np.ndarray, model: CompositeQuadric, turn: Rotation) -> bool:
    if not np.isfinite(region).all():
        return False
    return all(is_same(surface, turn.axis, turn.point) for surface in model.passing(*region))


def _passage(body: Body, other: Moving, span: Span) -> np.ndarray:
    """Corners (2, 3) of a box within that of `_region`, found sooner: from where another starts to where it ends."""
    points, _ = hull_points(other.body, span)
    poses = [(other.motion(t)[:3], _shift(body, t)) for t in span]
    ends = np.concatenate([points @ pose[:, :3].T + (pose[:, 3] - shift) for pose, shift in poses])
    return np.array([ends.min(axis=0), ends.max(axis=0)])


def _region(body: Body, other: Moving, span: Span, *more: Moving) -> np.ndarray:
    """Corners (2, 3) of one box, in the frame of a body that shifts at most, of all places of others."""
    boxes = np.array([way.bounds(span) for way in (other, *more)])
    shifts = np.array([_shift(body, t) for t in span])
    lo, hi = boxes[:, 0].min(axis=0) - shifts.max(axis=0), boxes[:, 1].max(axis=0) - shifts.min(axis=0)
    slack = 1e-12 * (np.abs(boxes).max() + np.abs(shifts).max())
    return np.array([lo - slack, hi + slack])


def _shift(body: Body, t: float) -> np.ndarray:
    return body.motion(t)[:3, 3] if isinstance(body, Moving) else np.zeros(3)
