"""`firstcontact robot`: a robot along a trajectory, against itself and its cell."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from firstcontact.cli import common
from firstcontact.errors import InputError

if TYPE_CHECKING:
    from firstcontact.mechanism.course import Course
    from firstcontact.result import FirstContact, Json


@click.command()
@click.argument("description")
@click.option("--trajectory", required=True, metavar="F", help="Joint values: CSV, NPZ or JSON of a JointTrajectory.")
@click.option("--scene", metavar="F", help="A scene whose bodies stand, or move, about the robot.")
@click.option("--srdf", metavar="F", help="Pairs of links that are switched off.")
@click.option("--package", "packages", metavar="NAME=DIR", multiple=True, help="Where package://NAME/ is.")
@click.option("--cubic", is_flag=True, help="Cubic values between waypoints (default: linear).")
@click.option("--json", "target", metavar="F|-", help="Write the results as JSON; - prints only them.")
def robot(
    description: str, trajectory: str, scene: str | None, srdf: str | None, packages: tuple[str, ...], cubic: bool,
    target: str | None,
) -> int:  # fmt: skip
    """Find what a robot meets first along its trajectory.

    DESCRIPTION is a URDF file.  Links that a joint connects are not asked about with each other.
    """
    from firstcontact.robot.robot import Robot
    from firstcontact.scene.load import load_scene

    common.check_target(target)
    places = dict(_pair(text) for text in packages)
    arm = Robot.load(description, srdf=srdf, packages=places)
    cell = [] if scene is None else list(load_scene(scene).bodies.values())
    course = arm.read_course(trajectory, interpolation="cubic" if cubic else "linear")
    results = sorted(course.first_contacts(cell), key=lambda hit: (hit.time is None, hit.time))
    if target != "-":
        click.echo(_told(course, results))
    if target is not None:
        rows = [{**hit.to_dict(), **_segment(course, hit)} for hit in results]
        text = json.dumps({"robot": arm.name, "checks": rows}, indent=1)
        if target == "-":
            click.echo(text)
        else:
            common.write(target, lambda path: path.write_text(text + "\n", encoding="utf-8"))
    return common.exit_code([hit.status.name for hit in results])


def _pair(text: str) -> tuple[str, str]:
    name, sign, value = text.partition("=")
    if not sign:
        raise InputError(f"--package {text}: write NAME=DIR")
    return name, value


def _segment(course: Course, hit: FirstContact) -> dict[str, Json]:
    """Between which waypoints, counted from 0, the contact is."""
    if hit.time is None:
        return {}
    k = course.stretch(hit.time)
    return {"waypoints": [k, k + 1]}


def _told(course: Course, results: Sequence[FirstContact]) -> str:
    """What meets, first things first, and how many pairs do not."""
    lines = []
    for hit in results:
        if hit.status.name == "FREE":
            continue
        lines.append(str(hit))
        if hit.time is not None:
            k = course.stretch(hit.time)
            normal = "" if hit.normal is None else "; normal ({:.6g}, {:.6g}, {:.6g})".format(*hit.normal)
            lines.append(f"  between waypoints {k} and {k + 1}{normal}")
    free = sum(hit.status.name == "FREE" for hit in results)
    return "\n".join([*lines, f"{len(results)} pairs, {free} of them FREE from waypoint 0 to {len(course.times) - 1}"])
