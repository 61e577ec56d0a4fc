"""What is told of bodies, line by line, by `firstcontact info`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from firstcontact.body.polyhedron.polyhedron import Polyhedron
    from firstcontact.body.ruled.surface import RuledSurface
    from firstcontact.body.solid.composite_quadric import CompositeQuadric


def polyhedron(body: Polyhedron) -> list[str]:
    """Counts, what kind it is, and bounds."""
    lo, hi = body.bounds()
    return [
        f"{count(len(body.vertices), 'vertex', 'vertices')}, {count(len(body.edges), 'edge')}, "
        f"{count(body.n_faces, 'face')}, {count(_components(body), 'component')}",
        mesh_kind(body),
        f"from ({point(lo)}) to ({point(hi)})",
    ]


def solid(body: CompositeQuadric) -> list[str]:
    """Counts and bounds of a solid of planes and quadrics, then every face, edge and vertex by name."""
    lo, hi = body.bounds()
    counts = (
        count(len(body.faces), "face"),
        count(len(body.edges), "edge"),
        count(len(body.vertices), "vertex", "vertices"),
    )
    lines = [
        ", ".join(counts),
        "a solid of planes and quadrics",
        f"from ({point(lo)}) to ({point(hi)})" if body.bounded else "unbounded",
    ]
    lines += [f"face {face.index}: {face.name}, {_carrier(face)}" for face in body.faces]
    lines += [f"edge {edge.index}: {edge.name}, {_carrier(edge)}, {edge.convexity}" for edge in body.edges]
    lines += [f"vertex {v.index}: {v.name}, at ({point(v.position)})" for v in body.vertices]
    return lines


def ruled(piece: RuledSurface) -> list[str]:
    """Directrices, ranges and bounds of a piece of a ruled surface."""
    u = "all u" if piece.u is None else f"u from {piece.u[0]} to {piece.u[1]}"
    s = "whole rulings" if piece.s is None else f"s from {piece.s[0]} to {piece.s[1]}"
    lo, hi = piece.bounds()
    lines = [
        f"a ruled surface, {u}, {s}",
        f"first: {piece.first}",
        f"second: {piece.second}",
        *(f"trimmed by {trim}" for trim in piece.trim),
    ]
    if piece.deforming:
        lines.append("deforms with the time T")
    elif not piece.is_proper:
        lines.append(f"every ruling belongs to {piece.tracing_index} values of u")
    span = " in the time from 0 to 1" if piece.deforming else ""
    lines.append(f"from ({point(lo)}) to ({point(hi)}){span}" if piece.bounded else "unbounded")
    return lines


def _carrier(feature: Any) -> str:
    """What kind of surface or curve a face or edge lies on."""
    kind = type(feature.carrier).__name__
    if kind == "Conic" and feature.frame.shape[1] == 2:  # a pair of lines whose numbers are irrational
        return "line"
    return {"QuarticCurve": "curve of degree 4"}.get(kind, kind.lower())


def mesh_kind(body: Polyhedron) -> str:
    if not body.n_faces:
        return "bare edges" if len(body.edges) else "bare points"
    if body.closed:
        return "closed, a solid" if body.solid else "closed, taken as a surface"
    return "open, a surface (no interior)"


def _components(body: Polyhedron) -> int:
    """Connected pieces of vertices and edges; vertices that nothing uses are not counted beside edges."""
    import numpy as np

    from firstcontact.body.polyhedron.topology import component_of_vertices

    piece = component_of_vertices(body.edges, len(body.vertices))
    used = np.unique(body.edges) if len(body.edges) else np.arange(len(body.vertices))
    return len(np.unique(piece[used]))


def point(corner: Iterable[float]) -> str:
    return ", ".join(f"{x:.9g}" for x in corner)


def count(n: int, one: str, many: str | None = None) -> str:
    return f"{n:,} {one if n == 1 else many or one + 's'}"
