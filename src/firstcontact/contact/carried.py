"""Answers carried to where the question was put: what was asked about in another place lies elsewhere, at its time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.result import CandidateTime, ContactSet, FirstContact, Subproblem

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

Carry = Callable[[float], np.ndarray]
"""The rigid (4, 4) pose at a time of the world that was asked about, in the one of the question."""


def carried(found: FirstContact, carry: Carry, a: Body, b: Body) -> FirstContact:
    """The first contact of a and b, all that it tells of places carried."""
    changes: dict[str, Any] = {"a": a, "b": b}
    if found.time is not None:
        pose = carry(found.time)
        if found.point is not None:
            changes["point"] = _placed(pose, found.point)
        if found.normal is not None:
            changes["normal"] = pose[:3, :3] @ found.normal
        if isinstance(found.contact_set, ContactSet):
            changes["contact_set"] = ContactSet(str(found.contact_set), _placed(pose, found.contact_set.points))
    if found.subproblems:
        changes["subproblems"] = tuple(_listed(x, carry) for x in found.subproblems)
    return replace(found, **changes)


def _listed(listed: Subproblem, carry: Carry) -> Subproblem:
    return replace(listed, candidates=tuple(_candidate(x, carry) for x in listed.candidates))


def _candidate(x: CandidateTime, carry: Carry) -> CandidateTime:
    return x if x.point is None else replace(x, point=_placed(carry(x.time), x.point))


def _placed(pose: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (..., 3) in the pose."""
    placed: np.ndarray = points @ pose[:3, :3].T + pose[:3, 3]
    return placed
