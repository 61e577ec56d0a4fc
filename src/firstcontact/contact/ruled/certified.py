"""Answers of the certified search in doubles, for moving ruled pieces that elimination does not master."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from firstcontact.contact.named import element
from firstcontact.contact.ruled.intervals import certified_intervals
from firstcontact.contact.ways import Passed, tried
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.clocks import StraightClock
from firstcontact.result import ContactIntervals, ContactSet, FirstContact, Status
from firstcontact.search.rulings.directrices import DirectrixPiece, directrix_pieces
from firstcontact.search.rulings.ruled_events import RuledEvent, RulingSearch, outermost, told_event_of
from firstcontact.search.rulings.ruled_pieces import RuledPiece
from firstcontact.search.trees.touch import carried_normal
from firstcontact.timeline.answers import proved_intervals
from firstcontact.work import Query, Work

if TYPE_CHECKING:
    from firstcontact.motion.moving import Moving

BUDGET = 200_000


class Pieces(NamedTuple):
    """Both surfaces in the frame of b, and the motion."""

    step: DirectrixPiece
    p: RuledPiece
    q: RuledPiece


def first(pieces: Pieces, query: Query) -> FirstContact:
    """The first contact with an enclosure of its time; UNDECIDED where doubles do not tell."""
    (step, p, q), shared = pieces, query.shared
    search = RulingSearch(p, q, inf if query.budget is None else query.budget)
    budget = BUDGET if query.budget is None else query.budget
    found = told_event_of(search, query.first, query.end, query.tolerance, budget)
    stats = query.stats(found.boxes)
    if found.status == "free":
        return FirstContact.free(stats, **shared)
    if found.status == "open":
        until = max(found.free_until, query.span[0])
        return FirstContact(Status.UNDECIDED, free_until=until, reason=found.reason, stats=stats, **shared)
    status = Status.INITIAL_CONTACT if found.status == "initial" else Status.CONTACT
    answer: dict[str, Any] = {"free_until": found.free_until, "stats": stats, **shared}
    if status is Status.INITIAL_CONTACT:
        answer["initial"] = "touching"
    if found.event is not None:
        assert found.time is not None
        pose = _pose_of_b(step, query.b, found.time)
        answer |= described(found.event, pose, status is Status.CONTACT, shared, alone=found.isolated)
    return FirstContact(status, found.time, found.time_interval, **answer)


def intervals(pieces: Pieces, query: Query, work: Work) -> ContactIntervals:
    """All contacts with enclosures of their ends; UNDECIDED from the first time on at which nothing is proved."""
    found = certified_intervals(pieces.p, pieces.q, query.first, query.end, query.tolerance, work)
    return proved_intervals(found, work, query)


def pieces_of(query: Query) -> Pieces | None:
    """None unless both are one piece, bounded in s and not trimmed, under one motion rational in the time."""
    for body in query.bodies:
        pieces: list[Any] = list(getattr(shape_of(body), "pieces", ()))
        if len(pieces) != 1 or pieces[0].s is None or pieces[0].trim:
            return None
    steps = tried(lambda: list(directrix_pieces(query.a, query.b, query.first, query.end)))
    if isinstance(steps, Passed):
        return None
    if len(steps) > 1 or not isinstance(steps[0].motion.clock, StraightClock) or not steps[0].motion.exact:
        return None
    p, q = (RuledPiece.of(sides, shape_of(body).u) for sides, body in ((steps[0].p, query.a), (steps[0].q, query.b)))
    return Pieces(steps[0], p, q)


def _pose_of_b(step: DirectrixPiece, b: Moving, time: float) -> np.ndarray:
    frame = step.motion.frame
    if frame is None:
        return np.asarray(b.motion(time), float)
    rows = np.array([[sum(int(c) * time**k for k, c in enumerate(x.coeffs())) for x in row] for row in frame], float)
    pose: np.ndarray = rows / rows[3, 3]
    return pose


def described(
    event: RuledEvent,
    pose: np.ndarray,
    with_normal: bool,
    shared: Mapping[str, Any],
    numbers: tuple[int, int] = (0, 0),
    joined: tuple[Collection[str], Collection[str]] = ((), ()),
    alone: bool = False,
) -> dict[str, object]:
    """What meets, in the world; pose: of b; numbers: of the pieces, joined: their borders that belong to the face.

    alone: whether the point is all that the bodies share.
    """
    normal = None
    if with_normal and event.normal is not None:
        normal = carried_normal(pose, event.normal)
    elements = [
        element(shared[which], *outermost(*sides, inner), number, which)
        for sides, number, inner, which in zip(
            (event.sides[:2], event.sides[2:]), numbers, joined, "ab", strict=True
        )
    ]
    point = pose[:3, :3] @ event.point + pose[:3, 3]
    return {
        "point": point, "normal": normal, "element_a": elements[0], "element_b": elements[1], "multiplicity": 1,
        "contact_set": ContactSet("point", point[None]) if alone else None,
    }  # fmt: skip
