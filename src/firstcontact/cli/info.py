"""`firstcontact info`: what is in a mesh or scene file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from firstcontact.body.told import count


@click.command()
@click.argument("file")
def info(file: str) -> int:
    """Tell what is in a mesh or scene file.

    FILE: a scene (.toml) or a mesh.  Printed: sizes, components, closed or open, bounds; of solids of planes and
    quadrics every face, edge and vertex by name; of ruled surfaces their directrices.
    """
    lines = _scene_lines(file) if Path(file).suffix.lower() == ".toml" else _mesh_lines(file)
    for line in lines:
        click.echo(line)
    return 0


def _mesh_lines(file: str) -> list[str]:
    from firstcontact.body.polyhedron.polyhedron import Polyhedron

    return [file, *_indented(Polyhedron.load(file))]


def _scene_lines(file: str) -> list[str]:
    from firstcontact.scene.load import load_scene

    scene = load_scene(file)
    lines = [f"{file}: {count(len(scene.bodies), 'body', 'bodies')}, {count(len(scene.checks), 'check')}"]
    for key, body in scene.bodies.items():
        motion = getattr(body, "motion", None)
        lines.append(f"body {key}: {'at rest' if motion is None else repr(motion)}")
        lines += _indented(body if motion is None else body.body)
    for check in scene.checks:
        span = "" if check.span is None else f", span {check.span[0]} to {check.span[1]}"
        lines.append(f"check {check.a} / {check.b}{span}{', exact' if check.exact else ''}")
    return lines


def _indented(body: Any) -> list[str]:
    return [f"  {line}" for line in body.told()]
