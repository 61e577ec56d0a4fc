"""`firstcontact info`: what is in a mesh, STEP or scene file."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import click

STEP = (".stp", ".step", ".p21")

@click.command()
@click.argument("file")
def info(file: str) -> int:
    """Tell what is in a mesh, STEP or scene file.

    FILE: a scene (.toml), a STEP file (.stp, .step) or a mesh.  Printed: sizes, components, closed or open, bounds; of
    STEP files the tree of parts, with their faces by kind and how exact each is; of solids of planes and quadrics every
    face, edge and vertex by name; of ruled surfaces their directrices.
    """
    suffix = Path(file).suffix.lower()
    of_kind = {".toml": _scene_lines, **dict.fromkeys(STEP, _step_lines)}
    for line in of_kind.get(suffix, _mesh_lines)(file):
        click.echo(line)
    return 0


def _step_lines(file: str) -> Iterable[str]:
    from firstcontact.step.told import lines

    return lines(file)


def _mesh_lines(file: str) -> list[str]:
    from firstcontact.body.polyhedron.polyhedron import Polyhedron

    return [file, *_body_lines(Polyhedron.load(file))]


def _scene_lines(file: str) -> list[str]:
    from firstcontact.scene.load import load_scene

    scene = load_scene(file)
    lines = [f"{file}: {_count(len(scene.bodies), 'body', 'bodies')}, {_count(len(scene.checks), 'check')}"]
    for key, body in scene.bodies.items():
        motion = getattr(body, "motion", None)
        lines.append(f"body {key}: {'at rest' if motion is None else repr(motion)}")
        lines += _body_lines(body if motion is None else body.body)
    for check in scene.checks:
        span = "" if check.span is None else f", span {check.span[0]} to {check.span[1]}"
        lines.append(f"check {check.a} / {check.b}{span}{', exact' if check.exact else ''}")
    return lines


def _body_lines(body: Any) -> list[str]:
    from firstcontact.body.compound.compound import Compound
    from firstcontact.body.solid.composite_quadric import CompositeQuadric

    if isinstance(body, Compound):
        return _compound_lines(body)
    if isinstance(body, CompositeQuadric):
        return _solid_lines(body)
    if hasattr(body, "pieces"):
        return [line for piece in body.pieces for line in _ruled_lines(piece)]
    lo, hi = body.bounds()
    return [
        f"  {_count(len(body.vertices), 'vertex', 'vertices')}, {_count(len(body.edges), 'edge')}, "
        f"{_count(body.n_faces, 'face')}, {_count(_components(body), 'component')}",
        f"  {_kind(body)}",
        f"  from ({_point(lo)}) to ({_point(hi)})",
    ]


def _compound_lines(body: Any) -> list[str]:
    """Pieces, deviation and bounds of parts and assemblies."""
    lo, hi = body.bounds()
    unit = "" if body.unit is None else f" {body.unit}"
    of = "with the file's own surfaces" if body.deviation == 0.0 else f"within {body.deviation:.2g}{unit} of the file's"
    return [
        f"  {_count(len(body.pieces), 'piece')} of a STEP file, {of}",
        f"  from ({_point(lo)}) to ({_point(hi)}){unit}",
    ]


def _solid_lines(body: Any) -> list[str]:
    """Counts and bounds of a solid of planes and quadrics, then every face, edge and vertex by name."""
    lo, hi = body.bounds()
    counts = (
        _count(len(body.faces), "face"),
        _count(len(body.edges), "edge"),
        _count(len(body.vertices), "vertex", "vertices"),
    )
    lines = [
        f"  {', '.join(counts)}",
        "  a solid of planes and quadrics",
        f"  from ({_point(lo)}) to ({_point(hi)})" if body.bounded else "  unbounded",
    ]
    lines += [f"  face {face.index}: {face.name}, {_carrier(face)}" for face in body.faces]
    lines += [f"  edge {edge.index}: {edge.name}, {_carrier(edge)}, {edge.convexity}" for edge in body.edges]
    lines += [f"  vertex {v.index}: {v.name}, at ({_point(v.position)})" for v in body.vertices]
    return lines


def _ruled_lines(piece: Any) -> list[str]:
    """Directrices, ranges and bounds of a piece of a ruled surface."""
    u = "all u" if piece.u is None else f"u from {piece.u[0]} to {piece.u[1]}"
    s = "whole rulings" if piece.s is None else f"s from {piece.s[0]} to {piece.s[1]}"
    lo, hi = piece.bounds()
    lines = [
        f"  a ruled surface, {u}, {s}",
        f"  first: {piece.first}",
        f"  second: {piece.second}",
        *(f"  trimmed by {trim}" for trim in piece.trim),
    ]
    if piece.deforming:
        lines.append("  deforms with the time T")
    elif not piece.is_proper:
        lines.append(f"  every ruling belongs to {piece.tracing_index} values of u")
    span = " in the time from 0 to 1" if piece.deforming else ""
    lines.append(f"  from ({_point(lo)}) to ({_point(hi)}){span}" if piece.bounded else "  unbounded")
    return lines


def _carrier(feature: Any) -> str:
    """What kind of surface or curve a face or edge lies on."""
    kind = type(feature.carrier).__name__
    if kind == "Conic" and feature.frame.shape[1] == 2:  # a pair of lines whose numbers are irrational
        return "line"
    return {"QuarticCurve": "curve of degree 4"}.get(kind, kind.lower())


def _kind(body: Any) -> str:
    if not body.n_faces:
        return "bare edges" if len(body.edges) else "bare points"
    if body.closed:
        return "closed, a solid" if body.solid else "closed, taken as a surface"
    return "open, a surface (no interior)"


def _components(body: Any) -> int:
    """Connected pieces of vertices and edges; vertices that nothing uses are not counted beside edges."""
    import numpy as np

    from firstcontact.body.polyhedron.topology import component_of_vertices

    piece = component_of_vertices(body.edges, len(body.vertices))
    used = np.unique(body.edges) if len(body.edges) else np.arange(len(body.vertices))
    return len(np.unique(piece[used]))


def _point(corner: Any) -> str:
    return ", ".join(f"{x:.9g}" for x in corner)


def _count(n: int, one: str, many: str | None = None) -> str:
    return f"{n:,} {one if n == 1 else many or one + 's'}"
