"""`firstcontact check`: the first contact of every pair of a scene."""

from __future__ import annotations

import click

from firstcontact.cli import common


@common.scene_command
@click.option("--png", metavar="F", help="Write a picture of the first contact (needs the extra view).")
def check(scene: str, options: common.Options, png: str | None) -> int:
    """Find the first contact of each pair.

    SCENE is a TOML file; without a [[check]] table every pair of its bodies is checked.
    """
    common.check_target(png)
    results = common.answer_checks(scene, options, "first_contact")
    common.deliver(results, options)
    if png is not None:
        common.write_png(png, results)
    return common.exit_code([result.status.name for result in results])
