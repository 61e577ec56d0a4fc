"""`firstcontact check`: the first contact of every pair of a scene."""

from __future__ import annotations

import click

from firstcontact.cli import common


@common.scene_command
@click.option("--png", metavar="F", help="Write a picture of the first contact (needs the extra view).")
def check(files: tuple[str, ...], options: common.Options, png: str | None) -> int:
    """Find the first contact of each pair.

    SCENE is a TOML file; without a [[check]] table every pair of its bodies is checked, but for those at rest with each
    other.  Of two or more mesh or STEP FILEs the first one moves, by --move or --turn, and is checked against the
    others.

    Where it is [[allow]]ed that bodies touch at the start, it is the first new contact.
    """
    with options.outputs(files, png=png) as out:
        results = common.answer_checks(files, options, out, "first_contact")
        if png is not None:
            common.write_png(out, results)
    return common.exit_code_of(results)
