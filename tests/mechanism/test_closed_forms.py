"""Mechanisms whose angles of contact have closed forms, right to 1e-12 of the angle."""

from __future__ import annotations

import math
import sys
from fractions import Fraction
from pathlib import Path

import pytest

import firstcontact as fc

sys.path.append(str(Path(__file__).resolve().parents[2] / "benchmarks"))

from mechanism_forms import FORMS, error, four_bar, met, slider_crank  # noqa: E402
from mechanism_forms import block as BOX  # noqa: E402, N812 - as a class of bodies


def only(answers, *names):
    """The answer about the bodies with these names."""
    (found,) = [x for x in answers if {x.a.name, x.b.name} == set(names)]
    return found


@pytest.mark.parametrize("make", FORMS)
def test_classical_mechanisms_meet_where_the_closed_forms_say(make):
    assert error(make()) <= 1e-12


def test_the_coupler_of_a_parallelogram_stays_below_a_ceiling_it_does_not_reach():
    """Its top rises to 1/8 + 2 sin, never to 5/2; both joints of the coupler are told where it meets a lower one."""
    form = four_bar()
    assert {x.name for x in met(form).joints} == {"A", "B"}
    mechanism = form.course.mechanism
    ceiling = mechanism.links["ground"][0].translated((0, 0, 1))
    higher = fc.Mechanism({**mechanism.links, "ground": ceiling}, mechanism.joints.values())
    course = higher.course([0, 1], {"A": [0, 90]})
    assert only(course.first_contacts(), "coupler", "ceiling").status is fc.Status.FREE


def test_a_slider_crank_tells_all_its_joints_and_the_face_of_the_stop():
    form = slider_crank()
    found = met(form)
    assert found.point[0] == pytest.approx(-1.5, abs=1e-12) and abs(found.normal[0]) == pytest.approx(1, abs=1e-9)
    assert {x.name: pytest.approx(x.value, rel=1e-12) for x in found.joints} == {
        "crank pin": form.degrees, "rod pin": -2 * form.degrees, "slider pin": form.degrees
    }  # fmt: skip


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


@pytest.mark.share(8)
@pytest.mark.parametrize("size", [1, 1e-100, 1e-170, 1e-300, 5e-324, "1e-400", 1e44, 1e-5])
@pytest.mark.parametrize("is_moved_on", [False, True])
def test_axes_of_any_length(size, is_moved_on):
    """Their squares are no doubles: nothing was known of where the link is, and that was taken for far away."""
    links = {"wall": fc.box((1, 1, 1)).translated((0, 4, 0)), "arm": fc.box((1, 1, 1)).translated((3, 0, 0))}
    joints = [fc.Joint("hinge", "revolute", "wall", "arm", axis=(0, 0, size))]
    if is_moved_on:
        links["rail"] = fc.box((0.1, 0.1, 0.1)).translated((0, 0, 7))
        joints = [fc.Joint("hinge", "revolute", "wall", "rail", axis=(0, 0, size)),
                  fc.Joint("slide", "prismatic", "rail", "arm", axis=(size, 0, 0))]  # fmt: skip
    skip = [("wall", "rail"), ("rail", "arm")] if is_moved_on else []
    (hit,) = fc.Mechanism(links, joints, skip=skip).course([0, 1], {"hinge": [0, 180]}).first_contacts()
    # the corner at (3.5, 0.5) comes to the side y = 3.5
    due = (math.asin(3.5 / math.hypot(3.5, 0.5)) - math.atan2(0.5, 3.5)) / math.pi
    assert hit.status is fc.Status.CONTACT and hit.time == pytest.approx(due, abs=1e-12)
    assert fc.Rotation((0, 0, size), degrees=30)(1.0) == pytest.approx(fc.Rotation((0, 0, 1), degrees=30)(1.0))


def cubic(mechanism, velocities):
    return mechanism.course([0, 1], {"hinge": [0, 1]}, interpolation="cubic", velocities=velocities)


@pytest.mark.parametrize(
    ("ask", "fault"),
    [
        (lambda m: m.course([0, 1], {"hinge": [0, "1e400"]}), r"values\[1\] of joint 'hinge' is '1e400'; give"),
        (lambda m: m.course([0, 1], {"hinge": "1e400"}), "the value of joint 'hinge' is '1e400'"),
        (lambda m: cubic(m, {"hinge": [0, "1e400"]}), r"velocities\[1\] of joint 'hinge' is '1e400'"),
        (lambda m: m.course([0, 1], None), "values: None is no dict"),
        (lambda m: m.course([0, 1e160], {}), r"times\[1\] is 1e\+160; give a number below 2\^150"),
        (lambda m: m.course([0, 1e-160], {}), r"times\[1\] lies less than 2\^-150 after times\[0\]"),
        (lambda m: cubic(m, [1]), r"velocities: \[1\] is no dict"),
        (lambda m: m.sweep("hinge", at="k"), "at: 'k' is no dict"),
        (lambda m: m.sweep(at={"neck": 1}), "at: no joint 'neck' takes a value"),
        (lambda m: fc.Joint("x", "revolute", "a", "b", mimic=("hinge", "1e400")), "mimic ratio is '1e400'"),
    ],
)  # fmt: skip
def test_values_that_are_none(ask, fault):
    links = {"wall": fc.box((1, 1, 1)), "arm": fc.box((1, 1, 1)).translated((3, 0, 0))}
    hinge = fc.Joint("hinge", "revolute", "wall", "arm", axis=(0, 0, 1), limits=(0, 90))
    with pytest.raises(fc.InputError, match=fault):
        ask(fc.Mechanism(links, [hinge]))


@pytest.mark.parametrize("pair", [("wall", "arm", "wall"), ("wall",), (), "wall", ("arm", "arm")])
def test_what_names_no_two_links_is_not_skipped_silently(pair):
    links = {"wall": fc.box((1, 1, 1)), "arm": fc.box((1, 1, 1)).translated((3, 0, 0))}
    hinge = fc.Joint("hinge", "revolute", "wall", "arm", axis=(0, 0, 1))
    with pytest.raises(fc.InputError, match=r"skip\[1\] is .*; give the names of two links"):
        fc.Mechanism(links, [hinge], skip=[("arm", "wall"), pair])


def test_joints_that_are_none_are_named():
    links = {"wall": fc.box((1, 1, 1))}
    with pytest.raises(fc.InputError, match="joints are None; give a list"):
        fc.Mechanism(links, None)
    with pytest.raises(fc.InputError, match=r"joint 'a': mimic is \(\); give \(joint, ratio, offset\)"):
        fc.Joint("a", "revolute", "wall", "arm", mimic=())
