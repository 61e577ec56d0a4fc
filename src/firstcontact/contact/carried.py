"""Answers carried to where the question was put: what was asked about in another place lies elsewhere, at its time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.contact.later import waiting
from firstcontact.result import CandidateTime, ContactSet, FirstContact, Subproblem

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body

Carry = Callable[[float], np.ndarray]
"""The (4, 4) pose at a time of the world that was asked about, in the one of the question: rigid, but for a power of
two by which lengths may differ."""


def carried(found: FirstContact, carry: Carry, a: Body, b: Body) -> FirstContact:
    """The first contact of a and b, all that it tells of places carried when it is read."""
    return waiting(found, partial(_places, found, carry), a=a, b=b)


def _places(found: FirstContact, carry: Carry) -> dict[str, object]:
    if found.time is None:
        return {}
    pose = carry(found.time)
    there: dict[str, object] = {"subproblems": tuple(_listed(x, carry) for x in found.subproblems)}
    if found.point is not None:
        there["point"] = _placed(pose, found.point)
    if found.normal is not None:
        there["normal"] = pose[:3, :3] @ found.normal / _larger(pose)
    if isinstance(found.contact_set, ContactSet):
        there["contact_set"] = ContactSet(str(found.contact_set), _placed(pose, found.contact_set.points))
    return there


def _larger(pose: np.ndarray) -> float:
    """How many times as long lengths are there; 1 where the pose is rigid."""
    return float(2.0 ** round(math.log2(float(np.linalg.norm(pose[:3, 0])))))


def _listed(listed: Subproblem, carry: Carry) -> Subproblem:
    return replace(listed, candidates=tuple(_candidate(x, carry) for x in listed.candidates))


def _candidate(x: CandidateTime, carry: Carry) -> CandidateTime:
    return x if x.point is None else replace(x, point=_placed(carry(x.time), x.point))


def _placed(pose: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (..., 3) in the pose."""
    placed: np.ndarray = points @ pose[:3, :3].T + pose[:3, 3]
    return placed
