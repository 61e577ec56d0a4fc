"""Scenes with joints, and `firstcontact sweep`, as users have them."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.cli import run
from firstcontact.scene.load import load_scene

DOOR = "examples/door.toml"
ARM = """
[body.base]
shape = "box"
size = [1, 1, 1]
at = [0, 0, -2]
[body.arm]
shape = "box"
size = [2, 0.25, 0.25]
at = [1, 0, 0]
[body.wall]
shape = "box"
size = [4, 1, 4]
at = [0, 2, 0]
[joint.turn]
type = "revolute"
parent = "base"
child = "arm"
limits = [-30, 150]
"""


def test_the_door_opens_until_its_handle_meets_the_drawer(capsys):
    assert run(["sweep", DOOR]) == 1
    told = capsys.readouterr().out
    # the corner (-3, 15/2) of the drawer is at the handle's end face, 13/4 from the hinge's plane through the panel
    angle = math.degrees(math.atan2(7.5, -3) - math.asin(3.25 / math.hypot(3, 7.5)))
    assert f"[{angle:.9f}"[:-1] in told
    assert "hinge over [0, 170] deg" in told and "slide over [0, 6]" in told


def test_a_sweep_with_another_joint_elsewhere(capsys):
    assert run(["sweep", DOOR, "--joint", "hinge", "--at", "slide=5", "--json", "-"]) == 1
    (found,) = json.loads(capsys.readouterr().out)["sweeps"]
    assert found["joint"] == "hinge" and found["limits"] == [0.0, 170.0]
    touched = {(x["a"], x["b"]): x["intervals"] for x in found["pairs"]}
    assert touched["panel", "drawer"]


def test_check_names_the_joints(capsys):
    assert run(["check", DOOR]) == 1
    told = capsys.readouterr().out
    assert "hinge = 110.223093929 deg, slide = 2.69641252387" in told
    assert "panel and handle" not in told  # parts of one link


def test_bodies_of_links_are_written_and_read_again():
    scene = load_scene(DOOR)
    panel, drawer = scene.bodies["panel"], scene.bodies["drawer"]
    again = fc.from_dict(json.loads(panel.to_json()))
    assert again.motion == panel.motion
    hit = fc.first_contact(panel, drawer)
    assert fc.FirstContact.from_json(hit.to_json()).joints == hit.joints
    assert fc.first_contact(again, drawer).time == hit.time


def test_a_course_from_a_table(scene, tmp_path, capsys):
    (tmp_path / "q.csv").write_text("time, turn\n0, 0\n1, 45\n3, 1e2\n")
    path = scene(ARM + '[course]\nfile = "q.csv"\n')
    motion = load_scene(path).bodies["arm"].motion
    assert motion.span == (0, 3)
    assert math.degrees(math.atan2(motion(2)[1, 0], motion(2)[0, 0])) == pytest.approx(72.5)
    assert run(["check", str(path)]) == 1
    assert "turn = " in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (ARM.replace('"arm"', '"hand"', 1), "joint.turn.child: no body 'hand'"),
        (ARM + "[course]\ntimes = [0, 1]\nvalues = { bend = [0, 1] }\n", "course: values: no joint 'bend'"),
        (ARM + "[course]\ntimes = [0, 1]\nvalues = { turn = [0, 1, 2] }\n", "has 3 values but 2 times"),
        (ARM + "[course]\ntimes = [1, 0]\nvalues = { turn = [0, 1] }\n", "times[1] does not lie after times[0]"),
        (ARM + '[course]\nfile = "no.csv"\n', "no.csv: no such file"),
        (ARM.replace('"revolute"', '"screw"'), "lead is for screws"),
        (ARM + '[joint.back]\ntype = "fixed"\nparent = "arm"\nchild = "base"\n', "ring"),
        (ARM + '[joint.more]\ntype = "fixed"\nparent = "wall"\nchild = "arm"\n', "hangs on two joints"),
        (ARM + '[link.both]\nbodies = ["arm", "elbow"]\n', "link.both.bodies: no body 'elbow'"),
        ("\n".join(ARM.split("\n")[:13]) + "\n[course]\ntimes = [0, 1]\n", "course: goes with joints"),
    ],
)  # fmt: skip
def test_faults_name_their_place(scene, text, fault, capsys):
    if fault.startswith("joint.turn"):
        text = ARM.replace('child = "arm"', 'child = "hand"')
    assert run(["check", str(scene(text))]) == 3
    told = capsys.readouterr().err
    assert fault in told and len(told.strip().splitlines()) == 1


def test_sweeps_refuse_what_they_cannot_do(scene, capsys):
    assert run(["sweep", "examples/cubes.toml"]) == 3
    assert "no joints" in capsys.readouterr().err
    assert run(["sweep", str(scene(ARM.replace("limits = [-30, 150]", "")))]) == 3
    assert "has limits" in capsys.readouterr().err
    assert run(["sweep", DOOR, "--at", "hinge"]) == 3
    assert run(["sweep", DOOR, "--at", "hinge=far"]) == 3
    assert run(["sweep", DOOR, "--joint", "hinge", "--at", "hinge=1"]) == 3
    told = capsys.readouterr().err
    assert "--at hinge=far: 'far' is not a number" in told and "--at hinge: this joint is driven" in told
    assert run(["sweep", DOOR, "--joint", "lid"]) == 3


def test_arrays_and_texts_are_values():
    mechanism = load_scene(DOOR).linked.mechanism
    one = mechanism.course(np.array([0.0, 1.0]), {"hinge": np.array([0.0, 30.0]), "slide": "1/3"})
    assert one.motion("drawer")(0.5)[:3, 3] == pytest.approx((0, -1 / 3, 0))
    with pytest.raises(fc.InputError, match="values\\[1\\] of joint 'hinge' is nan"):
        mechanism.course([0, 1], {"hinge": [0, math.nan]})


def test_how_far_a_link_has_come_is_told_by_waypoints(capsys):
    """It was told as a share of the time 1, whatever the course's times are."""
    assert run(["check", DOOR]) == 1
    told = capsys.readouterr().out
    assert "panel is between waypoints 1 and 2, counted from 0" in told and "time is that of the joints' course" in told
    assert "% of its motion" not in told


def test_a_sweep_has_a_page(tmp_path, capsys):
    page = tmp_path / "door.html"
    assert run(["sweep", DOOR, "--joint", "hinge", "--html", str(page)]) == 1
    assert '"name": "hinge", "unit": "deg"' in page.read_text()
