"""Which pairs of bodies move to each other."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from firstcontact.motion.moving import Moving, shape_of

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body


def moves(body: Body) -> bool:
    """Whether it moves, or its shape does: ruled surfaces may deform with the time."""
    return isinstance(body, Moving) or bool(getattr(body, "deforming", False))


def pairs_that_move(bodies: Mapping[str, Body]) -> list[tuple[str, str]]:
    """The pairs of bodies that are not at rest with each other: at rest, or by equal motions; all, if nothing moves."""
    motions: list[Any] = []
    groups = {}
    for key, body in bodies.items():
        motion: Any = body.motion if isinstance(body, Moving) else None
        if getattr(shape_of(body), "deforming", False):
            motion = body  # like no other
        known = [k for k, other in enumerate(motions) if other is motion or other == motion]
        groups[key] = known[0] if known else len(motions)
        if not known:
            motions.append(motion)
    pairs = itertools.combinations(bodies, 2)
    return [(a, b) for a, b in pairs if len(motions) == 1 or groups[a] != groups[b]]
