"""Contact that begins or ends where two windows of a motion meet: one event, which each of them tells from its side.

Windows end at 1/3 and 5/6, between doubles: the one before ends a little after, the next one begins a little before.
"""

from __future__ import annotations

import math
from fractions import Fraction as F

import pytest

import firstcontact as fc


def links(**moving: fc.CompositeQuadric) -> dict[str, fc.CompositeQuadric]:
    far = {name: fc.box((1, 1, 1)).translated((0, 0, z)) for name, z in (("base", -90), ("arm", -60))}
    return far | moving


def told(course, one: str, other: str) -> list[fc.ContactInterval]:
    found = fc.contact_intervals(course.bodies[one][0], course.bodies[other][0])
    assert found.status is fc.Status.CONTACT
    return list(found)


def assert_is(interval: fc.ContactInterval, start: float, end: float) -> None:
    for truth, (lo, hi) in ((start, interval.start_interval), (end, interval.end_interval)):
        assert lo <= truth <= hi and hi - lo <= 1e-12


@pytest.mark.thorough
def test_a_nut_flat_on_a_plate_is_one_contact():
    """Two screws, 10 up and 4 down a turn: it rises by 6, through a plate that is 1 thick, 2 above it."""
    bodies = links(nut=fc.box((2, 2, 2)), wall=fc.box((4, 4, 1)).translated((0, 0, F(7, 2))))
    joints = [
        fc.Joint("s", "screw", "base", "arm", axis=(0, 0, 1), lead=10),
        fc.Joint("r", "screw", "arm", "nut", axis=(0, 0, 1), lead=-4),
    ]
    course = fc.Mechanism(bodies, joints).course([0, 1], {"s": [0, 360], "r": [0, 360]})
    (interval,) = told(course, "nut", "wall")
    assert_is(interval, 1 / 3, 5 / 6)


@pytest.mark.share(2)
@pytest.mark.parametrize("back", (False, True))
def test_a_ball_on_a_parallelogram_arm_is_one_contact(back):
    """Its centre goes round on a circle of radius 4, and touches the wall at a sixth of a turn; or there and back."""
    bodies = links(ball=fc.sphere(1).translated((4, 0, 0)), wall=fc.box((1, 20, 3)).translated((F(1, 2), 0, 0)))
    joints = [
        fc.Joint("s", "revolute", "base", "arm", axis=(0, 0, 1)),
        fc.Joint("e", "revolute", "arm", "ball", axis=(0, 0, 1), point=(4, 0, 0)),
    ]
    ends = [180, 0] if back else [0, 180]
    course = fc.Mechanism(bodies, joints).course([0, 1], {"s": ends, "e": [-x for x in ends]})
    (interval,) = told(course, "ball", "wall")
    gone = math.acos(-1 / 4) / math.pi  # 4 cos t = -1
    assert_is(interval, *((1 - gone, 2 / 3) if back else (1 / 3, gone)))
