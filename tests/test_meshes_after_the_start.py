"""Polyhedra that touch flush at the start and screw apart, or into each other: all times of contact, soon told.

The truths are by formula: the heights of corners over the plane of the faces, and first contacts of what is left.
"""

from __future__ import annotations

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.contact.polyhedra.after_start import intervals
from firstcontact.contact.ways import Passed
from firstcontact.work import Query

RING = (0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)
SIDES = [[k, (k + 1) % 6, 6 + (k + 1) % 6, 6 + k] for k in range(6)]
ANGLE = fc.Polyhedron([(*p, z) for z in (0, 1) for p in RING], [[5, 4, 3, 2, 1, 0], [*range(6, 12)], *SIDES])
BEHIND = fc.Polyhedron(
    [(-x, y, z) for z in (0, 1) for x, y in RING], [[*range(6)], [*range(11, 5, -1)], *(s[::-1] for s in SIDES)]
)
BOX = fc.examples.box((1, 1, 1)).translated(("1/2", "1/2", "1/2"))
BODIES = {"angle": ANGLE, "box": BOX}
"""All of x >= 0, a face of each in the plane x = 0, and over the face of BEHIND there."""


def heights(body, motion, times):
    """The lowest x of the corners at each time."""
    poses = [np.array(motion(t)) for t in times]
    return [float((body.vertices @ pose[0, :3] + pose[0, 3]).min()) for pose in poses]


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("axis", [(1, 0, 0), (1, 1, 0)])
@pytest.mark.parametrize("swapped", [False, True])
def test_what_screws_away_touches_at_the_start_alone(body, axis, swapped):
    """It took 10 to 20 s, and about a slanted axis it was UNDECIDED."""
    motion = fc.Screw(axis, degrees=30, advance=1)
    assert min(heights(BODIES[body], motion, np.linspace(0.001, 1, 400))) > 0
    a, b = BODIES[body].moving(motion), BEHIND
    told = fc.contact_intervals(*((b, a) if swapped else (a, b)))
    (window,) = told
    assert told.status is fc.Status.INITIAL_CONTACT
    assert (window.start, window.end) == (0, 0) and window.end_interval[1] <= 1e-12
    assert [x.way for x in told.stats.ways][:2] == ["in the plane", "after the start"]


@pytest.mark.parametrize("swapped", [False, True])
def test_what_screws_on_is_in_contact_from_the_start(swapped):
    """It took 25 to 60 s."""
    motion = fc.Screw((1, 1, 0), degrees=50, advance=-1)
    assert max(heights(ANGLE, motion, np.linspace(0.001, 1, 400))) < 0
    a, b = ANGLE.moving(motion), BEHIND
    (window,) = fc.contact_intervals(*((b, a) if swapped else (a, b)))
    assert window.start == 0 and window.end > 0.5


def test_what_slides_on_is_left_to_the_other_ways():
    """About an axis across the face it stays in its plane: there is contact at all times."""
    told = fc.contact_intervals(ANGLE.moving(fc.Screw((1, 0, 0), (0, 1, 1), degrees=20, advance=0)), BEHIND)
    assert [(x.start, x.end) for x in told] == [(0, 1)]


@pytest.mark.parametrize("later", ["touching", None, "undecided"])
def test_what_still_touches_a_moment_later_is_not_told_from_there(later):
    """In poses that are not rational no flush contact is decided: the ways that begin at the start tell more."""
    body = ANGLE.moving(fc.Screw((1, 1, 0), degrees=50, advance=1))
    query = Query(body, BEHIND, fmpq(0), fmpq(1))

    def first(own):
        if own.first > 0 and later == "undecided":
            return fc.FirstContact(fc.Status.UNDECIDED, free_until=0.0, reason="precision", **own.shared)
        kind = "touching" if own.first == 0 else later
        return fc.FirstContact(fc.Status.INITIAL_CONTACT, 0.0, (0.0, 0.0), initial=kind, **own.shared)

    def rest(own):
        raise AssertionError("it is not asked")

    told = intervals(query, first, rest)
    assert isinstance(told, Passed) and told.proved is None
