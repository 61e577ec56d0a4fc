"""Mechanisms whose angles of contact have closed forms, right to 1e-12 of the angle."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest

import firstcontact as fc


def BOX(size):  # noqa: N802 - as a class of bodies
    """A box of polygons about the origin."""
    return fc.examples.box([float(Fraction(x)) for x in size])


def only(answers, *names):
    """The answer about the bodies with these names."""
    (found,) = [x for x in answers if {x.a.name, x.b.name} == set(names)]
    return found


def check(answers, names, joint, degrees):
    found = only(answers, *names)
    assert found.status is fc.Status.CONTACT
    (value,) = [x for x in found.joints if x.name == joint]
    assert value.interval[0] <= value.value <= value.interval[1]
    assert abs(value.value - degrees) <= 1e-12 * abs(degrees)
    assert value.interval[1] - value.interval[0] <= 1e-12 * abs(degrees)
    return found


def test_a_parallelogram_lifts_its_coupler_to_the_ceiling():
    """Four bars: the coupler keeps level and rises with the sine of the crank's angle."""
    links = {
        "ground": BOX((6, 1, 1)).translated((0, 0, 3)).named("ceiling"),
        "crank": BOX((2, "1/8", "1/8")).translated((1, 2, 0)).named("crank"),
        "rocker": BOX((2, "1/8", "1/8")).translated((4, 2, 0)).named("rocker"),
        "coupler": BOX((3, "1/4", "1/4")).translated((3.5, 0, 0)).named("coupler"),
    }
    joints = [
        fc.Joint("A", "revolute", "ground", "crank", axis=(0, -1, 0), limits=(0, 90)),
        fc.Joint("D", "revolute", "ground", "rocker", axis=(0, -1, 0), point=(3, 0, 0), mimic="A"),
        fc.Joint("B", "revolute", "crank", "coupler", axis=(0, -1, 0), point=(2, 0, 0), mimic=("A", -1)),
    ]
    course = fc.Mechanism(links, joints).course([0, 1], {"A": [0, 90]})
    # the coupler's top rises to 1/8 + 2 sin(A), never to the ceiling at 5/2
    assert only(course.first_contacts(), "coupler", "ceiling").status is fc.Status.FREE
    lower = fc.Mechanism({**links, "ground": links["ground"].translated((0, 0, -1))}, joints)
    found = check(lower.course([0, 1], {"A": [0, 90]}).first_contacts(), ("coupler", "ceiling"), "A",
                  math.degrees(math.asin(11 / 16)))  # fmt: skip
    assert {x.name for x in found.joints} == {"A", "B"}


def test_a_slider_crank_of_equal_arms_pushes_its_slider_to_the_stop():
    """The rod turns back twice as fast as the crank: its end runs along a line, at 2 cos of the crank's angle."""
    links = {
        "ground": BOX((1, 2, 1)).translated((-2, 0, 0)).named("stop"),
        "crank": BOX((1, "1/8", "1/8")).translated((0.5, 0, 3)).named("crank"),
        "rod": BOX((1, "1/8", "1/8")).translated((1.5, 0, 2)).named("rod"),
        "slider": BOX(("1/2", "1/2", "1/2")).translated((2, 0, 0)).named("slider"),
    }
    joints = [
        fc.Joint("crank pin", "revolute", "ground", "crank", axis=(0, 0, 1)),
        fc.Joint("rod pin", "revolute", "crank", "rod", axis=(0, 0, 1), point=(1, 0, 0), mimic=("crank pin", -2)),
        fc.Joint("slider pin", "revolute", "rod", "slider", axis=(0, 0, 1), point=(2, 0, 0), mimic=("crank pin", 1)),
    ]
    course = fc.Mechanism(links, joints).course([0, 2], {"crank pin": [0, 180]})
    # the slider's left face is at 2 cos - 1/4, the stop's right one at -3/2
    angle = math.degrees(math.acos(-5 / 8))
    found = check(course.first_contacts(), ("slider", "stop"), "crank pin", angle)
    assert found.point[0] == pytest.approx(-1.5, abs=1e-12) and abs(found.normal[0]) == pytest.approx(1, abs=1e-9)
    assert {x.name: pytest.approx(x.value, rel=1e-12) for x in found.joints} == {
        "crank pin": angle, "rod pin": -2 * angle, "slider pin": angle
    }  # fmt: skip


def test_arms_on_two_gears_meet_between_them():
    """Equal gears turn against each other: what they carry meets in the plane of symmetry."""
    arm = BOX((2, "1/4", "1/4")).translated((1, 0, 0))
    links = {
        "ground": BOX((1, 1, 1)).translated((0, 0, -9)).named("ground"),
        "left": arm.translated((0, 0, 0)).named("left"),
        "right": arm.rotated((0, 0, 1), degrees=180).translated((3, 0, 0)).named("right"),
    }
    joints = [
        fc.Joint("pinion", "revolute", "ground", "left", axis=(0, 0, 1)),
        fc.Joint("wheel", "revolute", "ground", "right", axis=(0, 0, 1), point=(3, 0, 0), mimic=("pinion", -1)),
    ]
    course = fc.Mechanism(links, joints).course([0, 1], {"pinion": [-120, 0]})
    # the corner (2, 1/8) of the left arm reaches x = 3/2
    angle = -math.degrees(math.acos(1.5 / math.hypot(2, 0.125)) + math.atan2(0.125, 2))
    check(course.first_contacts(), ("left", "right"), "pinion", angle)


def test_a_rack_runs_into_its_stop():
    links = {
        "ground": BOX((1, 1, 1)).translated((4, 0, 0)).named("stop"),
        "pinion": BOX((1, 1, "1/8")).translated((0, 5, 0)).named("pinion"),
        "rack": BOX((2, 1, 1)).named("rack"),
    }
    joints = [
        fc.Joint("pinion", "revolute", "ground", "pinion", axis=(0, 0, 1), point=(0, 5, 0), unit="turn"),
        fc.Joint("rack", "prismatic", "ground", "rack", axis=(2, 0, 0), mimic=("pinion", "1/3", "1/2")),
    ]
    course = fc.Mechanism(links, joints).course([0, 1], {"pinion": [0, 10]})
    found = fc.first_contact(course.bodies["rack"][0], course.bodies["ground"][0], exact=True)
    assert found.time_exact == Fraction(3, 5)
    values = {x.name: x.value for x in found.joints}
    assert values == {"rack": pytest.approx(2.5, rel=1e-15)} and found.time == pytest.approx(0.6, rel=1e-15)


def test_a_screw_drives_its_nut_to_the_end():
    links = {
        "ground": BOX((4, 4, 1)).translated((0, 0, 5)).named("plate"),
        "nut": BOX((1, 1, 1)).named("nut"),
    }
    joints = [fc.Joint("thread", "screw", "ground", "nut", axis=(0, 0, 1), lead="1/4", limits=(0, 7200))]
    mechanism = fc.Mechanism(links, joints)
    found = only(mechanism.course([0, 1], {"thread": [0, 7200]}).first_contacts(), "nut", "plate")
    assert found.joints[0].value == pytest.approx(16 * 360, rel=1e-12)  # up by 4 to the plate at 9/2


def test_a_crank_that_goes_round_many_times_in_one_stretch():
    """Two turns between two times, more than one walk takes: once a turn the slider of equal arms passes the stop."""
    links = {
        "ground": BOX((1, 2, 1)).translated((-2, 0, 0)).rotated((1, 2, 3), degrees=10).named("stop"),
        "crank": BOX((1, "1/8", "1/8")).translated((0.5, 0, 3)).named("crank"),
        "slider": BOX(("1/2", "1/2", "1/2")).translated((2, 0, 0)).named("slider"),
    }
    joints = [
        fc.Joint("pin", "revolute", "ground", "crank", axis=(0, 0, 1)),
        fc.Joint("rod", "revolute", "crank", "slider", axis=(0, 0, 1), point=(1, 0, 0), mimic=("pin", -2)),
    ]
    course = fc.Mechanism(links, joints).course([0, 2], {"pin": [0, 720]})
    found = fc.contact_intervals(course.bodies["slider"][0], course.bodies["ground"][0])
    assert found.status is fc.Status.CONTACT and len(found) == 2
    assert all(x.start == pytest.approx(found[0].start + k, rel=1e-12) for k, x in enumerate(found))
    hit = only(course.first_contacts(), "slider", "stop")
    assert hit.time == pytest.approx(found[0].start, rel=1e-12)


@pytest.mark.parametrize("kind", ["solid", "mesh"])
def test_far_from_the_origin_it_is_the_same(kind):
    make = fc.box if kind == "solid" else BOX
    found = []
    for place in ((0, 0, 0), (1e6, -2e6, 3e6)):
        x, y, z = place
        links = {
            "ground": make((4, 4, 1)).translated((x, y, z - 2)).named("floor"),
            "upper": make((1, "1/8", "1/8")).translated((x + 0.5, y + 9, z)).named("upper"),
            "fore": make((1, "1/4", "1/4")).translated((x + 1.5, y, z)).named("fore"),
        }
        joints = [
            fc.Joint("a", "revolute", "ground", "upper", axis=(0, 1, 0), point=place),
            fc.Joint("b", "revolute", "upper", "fore", axis=(1, 4, 0), point=(x + 1, y, z)),
        ]
        course = fc.Mechanism(links, joints).course([0, 1, 2], {"a": [0, 40, 50], "b": [0, 20, 60]})
        hit = only(course.first_contacts(), "fore", "floor")
        found.append((hit.time, *(hit.point - place)))
    assert found[0] == pytest.approx(found[1], abs=1e-8) and found[0][0] > 0.1
