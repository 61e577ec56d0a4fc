"""`firstcontact sweep`: each joint of a scene's mechanism driven over its limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from firstcontact.cli import common
from firstcontact.cli.outputs import Outputs
from firstcontact.errors import InputError

if TYPE_CHECKING:
    from fractions import Fraction


@click.command()
@click.argument("scene")
@click.option("--joint", metavar="NAME", help="The joint to drive (default: each one that has limits).")
@click.option("--at", "rest", metavar="NAME=VALUE", multiple=True, help="Where another joint rests (default: 0).")
@click.option("--json", "target", metavar="F|-", help="Write the results as JSON; - prints only them.")
@click.option("--html", "page", metavar="F", help="Write a page that shows the results, offline.")
def sweep(scene: str, joint: str | None, rest: tuple[str, ...], target: str | None, page: str | None) -> int:
    """Find all values of each joint at which two links share a point.

    SCENE is a TOML file with [joint.NAME] tables; the other joints rest.
    """
    from firstcontact.mechanism.sweep import sweep_of, swept_joints
    from firstcontact.scene.load import load_scene

    with Outputs({"--json": target, "--html": page}, [scene]) as out:
        loaded = load_scene(scene)
        out.refuse_read(loaded.files)
        if loaded.linked is None:
            raise InputError(f"{loaded.path}: no joints; add a [joint.NAME]")
        mechanism = loaded.linked.mechanism
        at = dict(_value(text) for text in rest)
        if joint is not None and joint in at:
            raise InputError(f"--at {joint}: this joint is driven; give values of others")
        results = []
        for name in swept_joints(mechanism, joint):
            results.append(sweep_of(mechanism, name, at))
            out.say(str(results[-1]))
        out.json("--json", lambda: {"sweeps": [result.to_dict() for result in results]})
        found = [pair for result in results for pair in result.found]
        if page is not None:
            from firstcontact.view.html import write_page

            out.file("--html", lambda path: write_page(path, found))
    return common.exit_code([pair.status.name for pair in found])


def _value(text: str) -> tuple[str, float | int | Fraction]:
    from firstcontact.scene.values import parse_number

    name, sign, value = text.partition("=")
    if not sign:
        raise InputError(f"--at {text}: write NAME=VALUE")
    try:
        return name, parse_number(value)
    except ValueError as error:
        raise InputError(f"--at {text}: {error}") from error
