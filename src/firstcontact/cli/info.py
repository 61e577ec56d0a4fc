"""`firstcontact info`: what is in a mesh, STEP or scene file."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from firstcontact.body.told import count, mesh_kind, point
from firstcontact.cli.given import is_step

if TYPE_CHECKING:
    from firstcontact.body.kinds import Shape
    from firstcontact.scene.load import Scene

FEW = 8
"""Bodies of a scene of which everything is told."""
MOST_LINES, MOST_NAMED = 12, 4


@click.command()
@click.argument("file")
@click.option("--all", "everything", is_flag=True, help="Tell all of every body, however many there are.")
@click.option("--triangles", is_flag=True, help="Of a STEP file: as it is with curved parts as triangles.")
def info(file: str, everything: bool, triangles: bool) -> int:
    """Tell what is in a mesh, STEP or scene file.

    FILE: a scene (.toml), a STEP file (.stp, .step) or a mesh.  Printed: sizes, components, closed or open, bounds; of
    STEP files the tree of parts, with their faces by kind and how exact each is, or why it is not; of solids of planes
    and quadrics every face, edge and vertex by name; of ruled surfaces their directrices.  Of scenes of more than 8
    bodies one line for each kind and motion.
    """
    if triangles and not is_step(file):
        raise click.UsageError("--triangles is for STEP files: a scene says it by surfaces = false.")
    if Path(file).suffix.lower() == ".toml":
        lines: Iterable[str] = _scene_lines(file, everything)
    else:
        lines = _step_lines(file, triangles) if is_step(file) else _mesh_lines(file)
    for line in lines:
        click.echo(line)
    return 0


def _step_lines(file: str, triangles: bool) -> Iterable[str]:
    from firstcontact.step.told import lines

    return lines(file, surfaces=False if triangles else None)


def _mesh_lines(file: str) -> list[str]:
    from firstcontact.body.polyhedron.polyhedron import Polyhedron

    return [file, *_indented(Polyhedron.load(file))]


def _scene_lines(file: str, everything: bool) -> list[str]:
    from firstcontact.scene.load import load_scene

    scene = load_scene(file)
    head = [count(len(scene.bodies), "body", "bodies"), count(len(scene.checks), "check")]
    head += [f"lengths in {scene.unit}"] if scene.unit else []
    head += [f"{count(scene.resting, 'pair')} at rest with each other left out"] if scene.resting else []
    lines = [f"{file}: {', '.join(head)}"]
    lines += [f"allow {rule}" for rule in scene.allow]
    if len(scene.bodies) > FEW and not everything:
        return lines + _brief(scene)
    for key, body in scene.bodies.items():
        motion = getattr(body, "motion", None)
        lines.append(f"body {key}: {'at rest' if motion is None else repr(motion)}")
        lines += _indented(body if motion is None else body.body)
    for check in scene.checks:
        span = "" if check.span is None else f", span {check.span[0]} to {check.span[1]}"
        lines.append(f"check {check.a} / {check.b}{span}{', exact' if check.exact else ''}")
    return lines


def _brief(scene: Scene) -> list[str]:
    """One line for each kind of bodies, and for what moves how; then the box of all."""
    import numpy as np

    from firstcontact.motion.moving import shape_of

    kinds: dict[str, list[str]] = {}
    motions: dict[str, list[str]] = {}
    for key, body in scene.bodies.items():
        kinds.setdefault(_sort(shape_of(body)), []).append(key)
        motion = getattr(body, "motion", None)
        motions.setdefault("at rest" if motion is None else repr(motion), []).append(key)
    lines = []
    for groups in (kinds, motions):
        lines += [f"  {len(keys):,} {what}: {_some(keys)}" for what, keys in list(groups.items())[:MOST_LINES]]
        if len(groups) > MOST_LINES:
            lines.append(f"  and {len(groups) - MOST_LINES:,} more: --all")
    boxes = [shape_of(body).bounds() for body in scene.bodies.values()]
    lo, hi = np.min([box[0] for box in boxes], axis=0), np.max([box[1] for box in boxes], axis=0)
    return [*lines, f"  from ({point(lo)}) to ({point(hi)})"]


def _sort(body: Any) -> str:
    if body.kind == "Polyhedron":
        return f"of meshes, {mesh_kind(body)}"
    words = {"CompositeQuadric": "of planes and quadrics", "RuledSurface": "of ruled surfaces"}
    return words.get(body.kind, str(body.kind))


def _some(keys: list[str]) -> str:
    return ", ".join(keys[:MOST_NAMED]) + ", ..." * (len(keys) > MOST_NAMED)


def _indented(body: Shape) -> list[str]:
    return [f"  {line}" for line in body.told()]
