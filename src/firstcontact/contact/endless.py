"""Spans without end, of bodies that one finite span settles: some time after which nothing changes any more.

Under a translation bounded bodies pass each other; and each surface of an unbounded one ends up on one side of a
bounded body, or moves along itself.  A rotation repeats itself after a turn, in spans with an end too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from flint import arb, fmpq

from firstcontact.body.solid.carriers import bilinear, dot
from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.exact.numbers import above, ball_bounds, below, exact_value, precision, to_double
from firstcontact.exact.vectors import scaled
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative.pieces import MotionPiece, pieces
from firstcontact.motion.rotation import Rotation, angle_ball, turns_of
from firstcontact.result import ContactIntervals, FirstContact, Status
from firstcontact.work import Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

ENDLESS = float("inf")
Vector = tuple[fmpq, fmpq, fmpq]
Box = tuple[Vector, Vector]


def first(ask: Callable[[Query], FirstContact], query: Query) -> FirstContact:
    """What `ask` tells of spans with an end, for one without; the enclosure is tolerance max(1, |t|) wide."""
    _, last = _settling(query)
    found = ask(replace(query, last=last))
    if found.status is Status.CONTACT:
        assert found.time_interval is not None
        first = query.first
        until = first + max(fmpq(1), (exact_value(found.time_interval[1]) - first) * fmpq(5, 4))
        if until < last:  # the enclosure was relative to a longer span
            found = ask(replace(query, last=until, tolerance=0.8 * query.tolerance))
    free_until = ENDLESS if found.status is Status.FREE else found.free_until
    return replace(found, span=query.span, free_until=free_until)


def in_one_turn(ask: Callable[[Query], FirstContact], query: Query) -> FirstContact:
    """What `ask` tells; of bodies that turn more than once about one line, of the first full turn."""
    motions = [body.motion for body in query.bodies if isinstance(body, Moving)]
    length = query.end - query.first
    turns = [turns_of(x) * length for x in motions if isinstance(x, Rotation)]
    if not turns or len(turns) < len(motions) or sum(turns) <= 1:
        return ask(query)
    if any(getattr(shape_of(body), "deforming", False) for body in query.bodies):
        return ask(query)
    (piece,) = pieces(query.a, query.b, query.first, query.end)
    end = _full_turn(piece) if isinstance(piece, MotionPiece) and any(piece.rate) else query.end
    if end >= query.end:
        return ask(query)
    found = ask(replace(query, last=end))
    free_until = query.span[1] if found.status is Status.FREE else found.free_until
    return replace(found, span=query.span, free_until=free_until)


def _full_turn(piece: MotionPiece) -> fmpq:
    """A time by which a rotation has come round."""
    if piece.rate[0] == 0:
        return piece.start + 1 / abs(piece.rate[1])
    with precision(64):
        rate = angle_ball(piece.rate[0], "radians") + angle_ball(piece.rate[1], "turns")
        return piece.start + exact_value(ball_bounds(abs(2 * arb.pi() / rate))[1])


def intervals(ask: Callable[[Query], ContactIntervals], query: Query) -> ContactIntervals:
    """What `ask` tells of spans with an end, for one without; what lasts to the end of change lasts for ever."""
    (piece, last), tolerance = _settling(query), query.tolerance
    if piece.velocity is None:
        raise InputError("contact_intervals needs a bounded span for a rotation; give span=(first, last)")
    found = ask(replace(query, last=last))
    widths = [
        ((hi - lo) / max(1.0, abs(lo)) if lo < hi else 0.0)
        for interval in found for lo, hi in (interval.start_interval, interval.end_interval)
    ]  # fmt: skip
    if max(widths, default=0.0) > tolerance:  # the enclosures were relative to a longer span
        found = ask(replace(query, last=last, tolerance=0.8 * tolerance * tolerance / max(widths)))
    ends = list(found)
    if ends and ends[-1].end_interval[1] >= to_double(last):
        ends[-1] = replace(ends[-1], end=ENDLESS, end_interval=(ENDLESS, ENDLESS), end_exact=None)
    free_until = ENDLESS if found.status is Status.FREE else found.free_until
    return replace(found, intervals=tuple(ends), span=query.span, free_until=free_until)


def _settling(query: Query) -> tuple[MotionPiece, fmpq]:
    """The relative motion, and a time from which on the bodies share points always or never."""
    a, b, first = query.a, query.b, query.first
    for body in query.bodies:
        if getattr(shape_of(body), "deforming", False):
            raise InputError(f"{body!r} deforms, which needs a bounded span; give span=(first, last)")
    (piece,) = pieces(a, b, first, None)
    assert isinstance(piece, MotionPiece)  # others need an end
    if piece.velocity is None:
        return piece, _full_turn(piece)
    wait = fmpq(0)
    if any(piece.velocity):
        box_a, box_b = (_box(x, first) for x in (a, b))
        if box_a is not None and box_b is not None:
            wait = _passing(box_a, box_b, piece.velocity)
        elif box_a is not None:
            wait = _settled(b, box_a, piece.velocity, first)
        elif box_b is not None:
            wait = _settled(a, box_b, scaled(fmpq(-1), piece.velocity), first)
        else:
            raise UnsupportedPair(f"{a!r} and {b!r} are both unbounded; one of them must be bounded")
    return piece, first + 2 * wait + 1


def _box(body: Body, first: fmpq) -> Box | None:
    """Exact corners of a box that holds the body at the start; None without bounds."""
    corners = body.bounds((below(first), above(first))) if isinstance(body, Moving) else body.bounds()
    if not np.all(np.isfinite(corners)):
        return None
    lo, hi = (tuple(exact_value(x) for x in corner) for corner in corners)
    return lo, hi  # type: ignore[return-value]


def _passing(a: Box, b: Box, velocity: Vector) -> fmpq:
    """The time after which a box has passed another for ever."""
    waits = []
    for (a_lo, a_hi), (b_lo, b_hi), v in zip(zip(*a, strict=True), zip(*b, strict=True), velocity, strict=True):
        if v != 0:
            waits.append(max(fmpq(0), (b_hi - a_lo) / v if v > 0 else (b_lo - a_hi) / v))
    return min(waits)


def _settled(body: Body, box: Box, velocity: Vector, first: fmpq) -> fmpq:
    """The time after which every surface of a model keeps its side of all points of a box that moves away.

    At x = c + w + v t, c the centre of the box, a form is alpha t^2 + (beta + w.2Av) t + ..., and from the time on at
    which its first coefficient that depends on t outweighs the others it keeps its sign.
    """
    model = shape_of(body)
    if not hasattr(model, "surfaces"):
        raise UnsupportedPair(f"{body!r} is unbounded, which needs a bounded span; give span=(first, last)")
    before = scaled(first, body.motion.vector) if isinstance(body, Moving) else (fmpq(0),) * 3  # type: ignore[union-attr]  # a Translation
    lo, hi = box
    centre = (*((x + y) / 2 - z for x, y, z in zip(lo, hi, before, strict=True)), fmpq(1))
    half = [(y - x) / 2 for x, y in zip(lo, hi, strict=True)]
    along = (*velocity, fmpq(0))
    wait = fmpq(0)
    for surface in model.surfaces:
        form = surface.matrix()
        slopes, turns = ([2 * dot(row, x) for row in form[:3]] for x in (centre, along))
        square, linear = bilinear(form, along, along), 2 * bilinear(form, along, centre)
        linear_spread = _spread(turns, half)
        rest = abs(bilinear(form, centre, centre)) + _spread(slopes, half)
        rest += sum(_spread(row[:3], half) * h for row, h in zip(form[:3], half, strict=True))
        if square != 0:
            wait = max(wait, fmpq(1), (abs(linear) + linear_spread + rest) / abs(square))
        elif abs(linear) > linear_spread:
            wait = max(wait, rest / (abs(linear) - linear_spread))
        elif linear != 0 or linear_spread != 0:
            raise UnsupportedPair(
                f"{body!r} is unbounded, and one of its surfaces opens along the motion; give span=(first, last)"
            )
    return wait


def _spread(row: Sequence[fmpq], half: Sequence[fmpq]) -> fmpq:
    return sum((abs(x) * h for x, h in zip(row, half, strict=True)), fmpq(0))
