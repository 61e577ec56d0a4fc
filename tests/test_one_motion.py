"""Bodies that one motion carries are told as they are told at rest, wherever the motion takes them."""

from __future__ import annotations

import numpy as np
import pytest

import firstcontact as fc
from firstcontact import Status
from firstcontact.contact import one_motion
from firstcontact.work import Query

CUBE = fc.examples.box((1, 1, 1))
PAIRS = {
    "meshes apart": (CUBE, CUBE.translated((2, 0, 0)), None),
    "meshes that touch": (CUBE, CUBE.translated((1, "1/2", 0)), "touching"),
    "boxes that touch": (fc.box((1, 1, 1)), fc.box((1, 1, 1)).translated((1, 0, 0)), "touching"),
    "balls that overlap": (fc.sphere(1), fc.sphere(1).translated(("3/2", 0, 0)), "overlapping"),
    "a ring and a ball in it": (fc.torus(3, 1), fc.sphere(1).translated((0, 0, 3)), None),
    "a pin in a wider hole": (fc.box((3, 3, 3)) - fc.cylinder(1, 5), fc.cylinder("9/10", 6), None),
    "a saddle and a ball": (fc.RuledSurface("(u, 0, 0)", "(u, 1, u)"), fc.sphere("1/4").translated((0, 0, -1)), None),
}
QUATERNIONS = (1, 0, 0, 0), (1, 0, 0, 1)
MOTIONS = {
    "shift": lambda far: fc.Translation((far, 1, 2)),
    "turn": lambda far: fc.Rotation((0, 0, 1), (far, 0, 0), degrees=90),
    "screw": lambda far: fc.Screw((1, 2, 2), (far, 0, 0), degrees=200, advance=1),
    "between": lambda far: fc.RationalMotion.between((0, 0, 0), (far, 0, 9), quat_wxyz=QUATERNIONS),
    "sequence": lambda far: fc.Sequence([fc.Rotation((0, 0, 1), (far, 0, 0), degrees=7), fc.Translation((0, 3, 0))]),
    "trajectory": lambda far: fc.Trajectory([0, 1], [(0, 0, 0), (far, 0, 9)], quat_wxyz=QUATERNIONS),
}


@pytest.mark.share(12)
@pytest.mark.parametrize("far", [10, 10**6])
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("pair", PAIRS)
def test_they_rest_with_each_other(pair, motion, far):
    (a, b, kind), m, equal = PAIRS[pair], MOTIONS[motion](far), MOTIONS[motion](far)
    moving = a.moving(m), b.moving(equal)
    for x, y in (moving, moving[::-1]):
        hit, found = fc.first_contact(x, y), fc.contact_intervals(x, y)
        assert (hit.a, hit.b, found.a, found.b) == (x, y, x, y)
        if kind is None:
            assert hit.status is found.status is Status.FREE and len(found) == 0
            continue
        assert hit.status is found.status is Status.INITIAL_CONTACT and hit.initial == kind
        assert [(z.start, z.end) for z in found] == [tuple(m.span)]


def test_places_are_those_of_the_start():
    """A second half is asked about: the bodies stand a quarter turn on."""
    turn = fc.Rotation((0, 0, 1), (10, 0, 0), degrees=180)
    hit = fc.first_contact(CUBE.moving(turn), CUBE.translated((1, 0, 0)).moving(turn), ("1/2", 1))
    assert hit.status is Status.INITIAL_CONTACT and hit.time == 0.5
    assert hit.point[1] == pytest.approx(0.5 - 10, abs=1e-9) and abs(hit.point[0] - 10) <= 0.5 + 1e-9
    ball = fc.sphere(1)
    hit = fc.first_contact(ball.moving(turn), ball.translated((2, 0, 0)).moving(turn), ("1/2", 1))
    assert hit.initial == "touching" and np.abs(hit.point - [10, -9, 0]).max() < 1e-9


def test_a_shift_that_never_ends():
    on = fc.Translation((1, 0, 0))
    pair = CUBE.moving(on), CUBE.translated((2, 0, 0)).moving(on)
    assert fc.first_contact(*pair, (0, float("inf"))).status is Status.FREE


@pytest.mark.parametrize("other", [
    fc.Rotation((0, 0, 1), degrees=91), fc.RationalMotion([np.eye(4), np.diag([1.0, 0, 0, 0])]),
])  # fmt: skip
def test_other_motions_are_asked_about_as_they_are(other):
    """Another angle; and a motion that stretches bodies."""
    own = other if isinstance(other, fc.RationalMotion) else fc.Rotation((0, 0, 1), degrees=90)
    query = Query(CUBE.moving(own), CUBE.translated((2, 0, 0)).moving(other), 0, 1)
    asked = []
    one_motion.asked(lambda x: asked.append(x) or fc.first_contact(CUBE, CUBE), query)
    assert asked == [query]
