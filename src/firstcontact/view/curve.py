"""What is drawn of an intersection curve: branches by component, overlaps, points; each kind a layer of the page."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypedDict

import numpy as np

from firstcontact.result_curve import IntersectionCurve
from firstcontact.view.overlap import overlap_triangles

if TYPE_CHECKING:
    from firstcontact.view.drawing import Drawing

COLOURS = ("#d02f42", "#1d8348", "#8e44ad", "#117a8b", "#c71585", "#5d6d1e", "#b9770e", "#34495e")
"""Of the components, in turn."""
DARK, OVERLAP, UNDECIDED = "#15181c", "#e0457b", "#d99a1c"
# Lines are drawn as far as this many times the radius of what is looked at.
FAR = 8.0
# Points closer than this, as a part of the size of their coordinates, are one node.
SAME = 1e-9


def components(curve: IntersectionCurve) -> list[int]:
    """The number of the connected component of each branch: branches hang together at their nodes."""
    parent = list(range(len(curve.branches)))

    def root(k: int) -> int:
        while parent[k] != k:
            k = parent[k]
        return k

    nodes: list[tuple[np.ndarray, int]] = []
    for k, branch in enumerate(curve.branches):
        for end in branch.ends:
            if end.kind == "node":
                for point, other in nodes:
                    if np.abs(point - end.point).max() <= SAME * max(1.0, np.abs(point).max()):
                        parent[root(k)] = root(other)
                nodes.append((end.point, k))
    numbers: dict[int, int] = {}
    return [numbers.setdefault(root(k), len(numbers)) for k in range(len(curve.branches))]


def sight(curve: IntersectionCurve) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner of what a picture of two surfaces without end should hold.

    That is everything but branches and lines that run to infinity; where there is nothing else, or one point, the
    points of those that are nearest to the origin, and the middle part of the directrices.
    """
    ending = [branch for branch in curve.branches if all(end.kind != "infinity" for end in branch.ends)]
    found = [branch.points for branch in ending]
    found += [curve.isolated_points, *(x.point[None] for x in curve.singular_points)]
    found += [place.point[None] for place in curve.open_places]
    points = np.concatenate([np.empty((0, 3)), *found])
    if not len(points):
        lines = [branch.points for branch in curve.branches] + list(curve.overlap_lines)
        points = np.array([line[np.linalg.norm(line, axis=1).argmin()] for line in lines]).reshape(-1, 3)
        points = np.concatenate([points, _directrices(curve)])
    elif len(points) == 1:
        points = np.concatenate([points, _directrices(curve)])
    lo, hi = points.min(axis=0), points.max(axis=0)
    reach = max(0.1 * float(np.linalg.norm(hi - lo)), 1e-6 * float(np.abs(points).max()), 1e-12)
    return lo - reach, hi + reach


def _directrices(curve: IntersectionCurve) -> np.ndarray:
    """(n, 3) points of all directrices where |u| <= 1."""
    sides = [side for body in (curve.a, curve.b) for piece in getattr(body, "pieces", ()) for side in piece.sides]
    points = np.concatenate([np.zeros((1, 3)), *(side.points(np.linspace(-1, 1, 9)) for side in sides)])
    return points[np.isfinite(points).all(axis=1)]


class Layer(TypedDict):
    """What is drawn of a curve; points (n, 3)."""

    name: str
    colour: str
    kind: str
    points: np.ndarray


def layers(curve: IntersectionCurve, drawn: tuple[Drawing, Drawing]) -> list[Layer]:
    """The layers: name, colour, points (n, 3), kind ("fill", "line", "thick line", "node", "cusp", "isolated", "open").

    Points of a fill are corners of triangles, those of lines the ends of segments.
    """
    vertices = np.concatenate([drawing.vertices for drawing in drawn])
    lo, hi = vertices.min(axis=0), vertices.max(axis=0)
    centre, radius = (lo + hi) / 2, float(np.linalg.norm(hi - lo)) / 2
    found = []
    if curve.two_dimensional and all(hasattr(body, "pieces") for body in (curve.a, curve.b)):
        area = overlap_triangles(*drawn)
        found.append(("overlap", OVERLAP, "fill", area.reshape(-1, 3)))
    if len(curve.overlap_lines):
        ends = curve.overlap_lines
        if not any(getattr(body, "bounded", True) for body in (curve.a, curve.b)):
            ends = np.array([_lengthened(line, centre, FAR * radius) for line in ends])
        found.append(("common rulings", DARK, "thick line", clipped(ends, centre, FAR * radius).reshape(-1, 3)))
    numbers = components(curve)
    for number in sorted(set(numbers)):
        own = [branch for branch, k in zip(curve.branches, numbers, strict=True) if k == number]
        segments = np.concatenate([np.stack([b.points[:-1], b.points[1:]], axis=1) for b in own])
        kind = "closed" if all(b.closed for b in own) else "open" if len(own) == 1 else f"{len(own)} branches"
        name = f"component {number + 1}, {kind}"
        colour = COLOURS[number % len(COLOURS)]
        found.append((name, colour, "line", clipped(segments, centre, FAR * radius).reshape(-1, 3)))
    for kind in ("node", "cusp"):
        points = [x.point for x in curve.singular_points if x.kind == kind]
        if points:
            found.append((f"{kind}s", DARK, kind, np.array(points)))
    if len(curve.isolated_points):
        found.append(("isolated points", COLOURS[0], "isolated", curve.isolated_points))
    if curve.open_places:
        places = np.array([place.point for place in curve.open_places])
        found.append(("undecided places", UNDECIDED, "open", places))
    return [Layer(name=name, colour=colour, kind=kind, points=points) for name, colour, kind, points in found]


def _lengthened(line: np.ndarray, centre: np.ndarray, reach: float) -> np.ndarray:
    """The line through two points as a segment that reaches beyond the picture."""
    along = (line[1] - line[0]) / np.linalg.norm(line[1] - line[0])
    near = line[0] + ((centre - line[0]) @ along) * along
    return np.array([near - reach * along, near + reach * along])


def clipped(segments: np.ndarray, centre: np.ndarray, reach: float) -> np.ndarray:
    """Of segments (n, 2, 3) what lies in the cube of this half width: a page's floats cannot hold what is far out."""
    start, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = (centre - reach - start) / along, (centre + reach - start) / along
    beside = (np.abs(start - centre) > reach) & (along == 0)  # else the whole line lies between these two planes
    enters = np.where(along == 0, np.where(beside, np.inf, -np.inf), np.minimum(one, other))
    leaves = np.where(along == 0, np.where(beside, -np.inf, np.inf), np.maximum(one, other))
    first, last = np.clip(enters.max(axis=1), 0, 1), np.clip(leaves.min(axis=1), 0, 1)
    ends = np.stack([start + first[:, None] * along, start + last[:, None] * along], axis=1)
    return ends[first < last]
