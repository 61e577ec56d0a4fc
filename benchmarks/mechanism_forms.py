"""Mechanisms whose joint values at contact have closed forms."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, NamedTuple

import firstcontact as fc


class Form(NamedTuple):
    """A mechanism at work; which two bodies meet, and at how many degrees of which joint."""

    name: str
    course: Any
    meeting: tuple[str, str]
    joint: str
    degrees: float


def block(size: tuple[Any, Any, Any]) -> fc.Polyhedron:
    """A box of polygons about the origin."""
    return fc.examples.box([float(Fraction(x)) for x in size])


def four_bar() -> Form:
    """A parallelogram: the coupler keeps level and rises with the sine of the crank's angle, to the ceiling at 3/2."""
    links = {
        "ground": block((6, 1, 1)).translated((0, 0, 2)).named("ceiling"),
        "crank": block((2, "1/8", "1/8")).translated((1, 2, 0)).named("crank"),
        "rocker": block((2, "1/8", "1/8")).translated((4, 2, 0)).named("rocker"),
        "coupler": block((3, "1/4", "1/4")).translated((3.5, 0, 0)).named("coupler"),
    }
    joints = [
        fc.Joint("A", "revolute", "ground", "crank", axis=(0, -1, 0), limits=(0, 90)),
        fc.Joint("D", "revolute", "ground", "rocker", axis=(0, -1, 0), point=(3, 0, 0), mimic="A"),
        fc.Joint("B", "revolute", "crank", "coupler", axis=(0, -1, 0), point=(2, 0, 0), mimic=("A", -1)),
    ]
    course = fc.Mechanism(links, joints).course([0, 1], {"A": [0, 90]})
    return Form("four-bar", course, ("coupler", "ceiling"), "A", math.degrees(math.asin(11 / 16)))


def slider_crank() -> Form:
    """Equal arms: the rod turns back twice as fast as the crank, and its end runs along a line, at 2 cos of its angle.

    The slider's left face is at 2 cos - 1/4, the stop's right one at -3/2.
    """
    links = {
        "ground": block((1, 2, 1)).translated((-2, 0, 0)).named("stop"),
        "crank": block((1, "1/8", "1/8")).translated((0.5, 0, 3)).named("crank"),
        "rod": block((1, "1/8", "1/8")).translated((1.5, 0, 2)).named("rod"),
        "slider": block(("1/2", "1/2", "1/2")).translated((2, 0, 0)).named("slider"),
    }
    joints = [
        fc.Joint("crank pin", "revolute", "ground", "crank", axis=(0, 0, 1)),
        fc.Joint("rod pin", "revolute", "crank", "rod", axis=(0, 0, 1), point=(1, 0, 0), mimic=("crank pin", -2)),
        fc.Joint("slider pin", "revolute", "rod", "slider", axis=(0, 0, 1), point=(2, 0, 0), mimic=("crank pin", 1)),
    ]
    course = fc.Mechanism(links, joints).course([0, 2], {"crank pin": [0, 180]})
    return Form("slider-crank", course, ("slider", "stop"), "crank pin", math.degrees(math.acos(-5 / 8)))


def gear_pair() -> Form:
    """Equal gears turn against each other, and what they carry meets in the plane of symmetry, x = 3/2.

    The corner (2, 1/8) of the left arm is the first to be there.
    """
    arm = block((2, "1/4", "1/4")).translated((1, 0, 0))
    links = {
        "ground": block((1, 1, 1)).translated((0, 0, -9)).named("ground"),
        "left": arm.named("left"),
        "right": arm.rotated((0, 0, 1), degrees=180).translated((3, 0, 0)).named("right"),
    }
    joints = [
        fc.Joint("pinion", "revolute", "ground", "left", axis=(0, 0, 1)),
        fc.Joint("wheel", "revolute", "ground", "right", axis=(0, 0, 1), point=(3, 0, 0), mimic=("pinion", -1)),
    ]
    course = fc.Mechanism(links, joints).course([0, 1], {"pinion": [-120, 0]})
    angle = -math.degrees(math.acos(1.5 / math.hypot(2, 0.125)) + math.atan2(0.125, 2))
    return Form("gear pair", course, ("left", "right"), "pinion", angle)


def met(form: Form) -> fc.FirstContact:
    """What the library tells of it."""
    (hit,) = [x for x in form.course.first_contacts() if {x.a.name, x.b.name} == set(form.meeting)]
    return hit


def error(form: Form) -> float:
    """How far the joint's value, and any end of its enclosure, is from the closed form, relative to that."""
    hit = met(form)
    assert hit.status is fc.Status.CONTACT, hit
    (value,) = [x for x in hit.joints if x.name == form.joint]
    assert value.interval[0] <= value.value <= value.interval[1]
    return max(abs(x - form.degrees) for x in (value.value, *value.interval)) / abs(form.degrees)


FORMS = (four_bar, slider_crank, gear_pair)
