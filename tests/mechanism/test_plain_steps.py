"""Links whose joints, for a while, make no more than a shift or a turn: they move as bodies of their own do."""

from __future__ import annotations

from fractions import Fraction as F

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact.motion.product import Product
from firstcontact.motion.steps import steps_of
from firstcontact.result import Status

SHAPES = {"solid": fc.box, "mesh": fc.examples.box}


def gantry(block, times, values, **course):
    """A unit block that is carried along x, and from there along y."""
    far = [block((1, 1, 1)).translated((0, 0, -20 - k)) for k in range(2)]
    links = {"base": far[0], "bridge": far[1], "head": block((1, 1, 1)).named("head")}
    joints = [fc.Joint("x", "prismatic", "base", "bridge", axis=(1, 0, 0)),
              fc.Joint("y", "prismatic", "bridge", "head", axis=(0, 1, 0))]  # fmt: skip
    return fc.Mechanism(links, joints).course(times, values, **course).bodies["head"][0]


@pytest.mark.share(8)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("place, contact", [
    ((4, 1, 0), (1, F(5, 3))), ((4, -1, 0), (1, 1)), ((2, 2, 1), (F(4, 3), 2)), ((2, -1, 1), (F(1, 3), 1)),
])  # fmt: skip
def test_flush_blocks_of_a_gantry(shape, place, contact):
    """Along (3 t, 0), then (3, 3 (t - 1)): |x - px|, |y - py|, |z - pz| <= 1.  All were UNDECIDED, after 10 s."""
    block = SHAPES[shape]
    head, other = gantry(block, [0, 1, 2], {"x": [0, 3, 3], "y": [0, 0, 3]}), block((1, 1, 1)).translated(place)
    assert fc.contact_intervals(head, other).status is Status.CONTACT
    found = fc.contact_intervals(head, other, exact=True)
    assert [(x.start_exact, x.end_exact) for x in found] == [contact]
    assert fc.first_contact(head, other, exact=True).time_exact == contact[0]


def test_diagonal_and_smooth_ways():
    """x = 9 t^2 - 6 t^3 is 1 where 6 t^3 - 9 t^2 + 1 = 0; y, a third of it, is 1/2 at t = 1/2, as if even."""
    cube, still = fc.examples.box((1, 1, 1)), {"x": [0, 0], "y": [0, 0]}
    smooth = gantry(fc.examples.box, [0, 1], {"x": [0, 3], "y": [0, 1]}, interpolation="cubic", velocities=still)
    wall, over = cube.translated((2, 0, 0)), fc.examples.box((10, 1, 1)).translated((0, "3/2", 0))
    hit = fc.first_contact(smooth, wall, exact=True)
    assert [int(c) for c in hit.time_exact.polynomial] in ([1, 0, -9, 6], [-1, 0, 9, -6])
    assert fc.first_contact(smooth, over, exact=True).time_exact == F(1, 2)
    even = gantry(fc.examples.box, [0, 1], {"x": [0, 3], "y": [0, 1]})
    assert fc.first_contact(even, over, exact=True).time_exact == F(1, 2)


def test_a_turn_beyond_a_standing_quarter_turn_is_exact():
    """A rod from (0, 2) to (0, 4) turns about the first point: its tip is at y = 2 + 2 cos(pi t), 1/2 on the plate."""
    block = fc.examples.box
    far = [block((1, 1, 1)).translated((0, 0, -20 - k)) for k in range(2)]
    rod = fc.Polyhedron([(2, 0, 0), (4, 0, 0)], [], edges=[(0, 1)]).named("rod")
    joints = [fc.Joint("a", "revolute", "base", "arm", axis=(0, 0, 1)),
              fc.Joint("b", "revolute", "arm", "rod", axis=(0, 0, 1), point=(2, 0, 0))]  # fmt: skip
    arm = fc.Mechanism({"base": far[0], "arm": far[1], "rod": rod}, joints)
    moving = arm.course([0, 1], {"a": 90, "b": [0, 180]}).bodies["rod"][0]
    hit = fc.first_contact(moving, block((8, 2, 1)).translated((0, "-1/2", 0)), exact=True)
    assert hit.status is Status.CONTACT and hit.time_exact.time == pytest.approx(F(1, 2) + np.arcsin(0.75) / np.pi)


def test_steps_are_the_products_of_their_joints():
    """At random values, cubic and linear, standing and moving, with quarter turns: against the poses of all joints."""
    rng, plain = np.random.default_rng(5), 0
    for _ in range(40):
        links, joints = {"0": fc.box((1, 1, 1))}, []
        for k in range(4):
            axis = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (2, -1, 2)][rng.integers(4)]
            kind = ["revolute", "prismatic", "prismatic", "screw"][rng.integers(4)]
            lead = {"lead": 3} if kind == "screw" else {}
            links[str(k + 1)] = fc.box((1, 1, 1))
            point = {} if kind == "prismatic" else {"point": rng.integers(-2, 3, 3).tolist()}
            joints.append(fc.Joint(f"q{k}", kind, str(k), str(k + 1), axis=axis, **point, **lead))
        values = {}
        for joint in joints:
            stands = rng.random() < 0.6 or (joint.kind != "prismatic" and rng.random() < 0.5)
            unit = 1 if joint.kind == "prismatic" else 90
            values[joint.name] = [int(rng.integers(-2, 3)) * unit] * 3 if stands else rng.integers(-90, 90, 3).tolist()
        interpolation = ["linear", "cubic"][rng.integers(2)]
        motion = fc.Mechanism(links, joints).course([0, 2, 3], values, interpolation=interpolation).motion("4")
        for step in steps_of(motion):
            plain += not isinstance(step.motion, Product)
            for t in rng.integers(0, 65, 3).tolist():
                time = step.start + (step.end - step.start) * fmpq(t, 64)
                assert np.abs(step.pose(time).doubles() - motion.pose(time).doubles()).max() < 1e-12
    assert plain > 30
