"""`firstcontact toolpath`: a tool along a program, against fixtures and stock."""

from __future__ import annotations

from typing import Any

import click

from firstcontact.cli import common
from firstcontact.errors import InputError


@click.command()
@click.argument("program")
@click.option("--scene", required=True, metavar="F", help="A scene with the tool, fixtures and stock.")
@click.option("--all", "every", is_flag=True, help="Tell of blocks that are free, too.")
@click.option("--from", "start", metavar='"X Y Z"', help="Where the tip is before the program begins.")
@click.option("--workers", type=click.IntRange(1, 1024), metavar="N", help="Cores that take part (default: all).")
def toolpath(program: str, scene: str, every: bool, start: str | None, workers: int | None) -> int:
    """Find what a tool meets along a program of G-code or APT / CL.

    PROGRAM is a file of G-code (.nc, .ngc, .tap ...) or APT (.apt, .cl ...); the tool is a [tool.NAME] of the scene.
    """
    from firstcontact.scene.load import load_scene
    from firstcontact.toolpath.program import ToolPath

    loaded = load_scene(scene)
    if not loaded.tools:
        raise InputError(f"{loaded.path}: no tool; add a [tool.NAME] with segments")
    path = ToolPath(program, start=start.split() if start is not None else None, unit=loaded.unit)
    statuses = []
    for verdict in path.verdicts(loaded.tools.values(), loaded.bodies, workers=workers):
        statuses.append(verdict.status)
        if every or verdict.status != "FREE":
            click.echo(_told(verdict))
    return common.exit_code("UNDECIDED" if x == "UNKNOWN" else x for x in statuses)


def _told(verdict: Any) -> str:
    block = verdict.block
    return "\n".join([f"line {block.line}: {block.text}: {verdict.status}", *map(str, verdict.findings)])
