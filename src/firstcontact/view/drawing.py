"""What is drawn of a body: triangles, lines, and where its elements are; meshes as they are, solids tessellated."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.body.compound.compound import Compound
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.ruled.strip import RuledStrip
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.body.solid.carriers import QuarticCurve
from firstcontact.body.solid.features import Edge
from firstcontact.errors import InputError
from firstcontact.result import Element
from firstcontact.view import compound, ruled
from firstcontact.view.curve import sight
from firstcontact.view.geometry import element_vertices, face_outline, sharp_edges
from firstcontact.view.pair import PairView, at_rest, pose

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Shape
    from firstcontact.body.solid.composite_quadric import CompositeQuadric
    from firstcontact.body.torus.torus import Torus

# Distance between a solid and its triangles, as a part of its size: half a pixel of a picture that it fills.
TOLERANCE = 1 / 800
# Small holes get round as well: the distance as a part of the smallest radius of an edge, down to a tenth of the above.
ROUNDNESS = 1 / 100
# Chords of a full ellipse of an edge.
CHORDS = 128
# Times at which a body that deforms is worked out; the page blends between them.
FRAMES = 65


@dataclass(frozen=True)
class Drawing:
    """A body in its own frame.

    vertices (n, 3), triangles (m, 3) and lines (k, 2) of their numbers; normals: (n, 3) unit, outward, or None where
    triangles are flat.  Ends of lines that belong to no triangle have the normal 0.
    """

    body: Any
    vertices: np.ndarray
    triangles: np.ndarray
    lines: np.ndarray
    normals: np.ndarray | None = None
    triangle_face: np.ndarray = field(default_factory=lambda: np.empty(0, int))
    curves: tuple[np.ndarray, ...] = ()
    """(2 k, 3) ends of segments along each edge of a solid."""
    frames: tuple[np.ndarray, np.ndarray] | None = None
    """Of a body that deforms: times (k,) and its vertices (k, n, 3) at them; `vertices` are those at the contact."""

    @property
    def frame(self) -> tuple[np.ndarray, float]:
        """Centre (3,) of the body's box, and the power of two just above the body's radius about it."""
        centre = 0.5 * (self.vertices.min(axis=0) + self.vertices.max(axis=0))
        radius = float(np.linalg.norm(self.vertices - centre, axis=1).max())
        return centre, 2.0 ** math.frexp(radius)[1] if radius > 0 else 1.0

    def corners(self, element: Element) -> np.ndarray:
        """(1, 3) vertex, (2 k, 3) ends of segments along an edge, (3 k, 3) triangles of a face.

        Of bodies without end no face is given: it would cover the picture.
        """
        if isinstance(self.body, Polyhedron):
            return element_vertices(self.body, element)
        if isinstance(self.body, Compound):
            return compound.element_corners(self.body, element)
        if isinstance(self.body, RuledSurface | RuledStrip):
            parts = self.vertices, self.triangles, self.triangle_face, self.lines
            return ruled.element_corners(self.body, parts, element)
        if element.kind in ("vertex", "apex"):
            return np.array([self.body.vertices[element.index].position])
        if element.kind == "edge":
            return self.curves[element.index]
        if element.kind == "face" and not self.body.bounded:
            return np.empty((0, 3))
        if element.kind == "face":
            return self.vertices[self.triangles[self.triangle_face == element.index].ravel()]
        raise ValueError(f"no picture for an element of kind {element.kind!r}")

    def outline(self, index: int) -> np.ndarray:
        """(2 k, 3) ends of segments along the border of a face."""
        if isinstance(self.body, Polyhedron):
            return face_outline(self.body, index)
        if isinstance(self.body, RuledSurface | RuledStrip | Compound):
            return self.vertices[self.lines.ravel()]
        seams = [_segments(edge, *self.frame) for edge in self.body.seams if index in edge.faces]
        own = [self.curves[edge.index] for edge in self.body.edges if index in edge.faces]
        return np.concatenate([np.empty((0, 3)), *own, *seams])


def drawings(pair: PairView, known: dict[int, Drawing] | None = None) -> tuple[Drawing, Drawing]:
    """The two bodies of a pair as they are drawn; `known`: drawings already made, by the id of the body."""
    known = {} if known is None else known
    first, second = (_drawing(pair, body, other, known) for body, other in ((pair.a, pair.b), (pair.b, pair.a)))
    return first, second


def _drawing(pair: PairView, body: Body, other: Body, known: dict[int, Drawing]) -> Drawing:
    rest = at_rest(body)
    drawing = drawing_alone(rest, known)
    if drawing is not None:
        return drawing
    if isinstance(rest, RuledSurface | RuledStrip):
        if rest.deforming:  # another pair shows other times
            return _deforming(pair, rest)
        return _ruled(rest, *_box_near(pair, body, other))  # another pair shows another part of it
    if not hasattr(rest, "skin"):
        raise InputError(f"cannot draw {rest!r}; give a body of firstcontact")
    return _solid(rest, *_box_near(pair, body, other))


def drawing_alone(rest: Shape, known: dict[int, Drawing]) -> Drawing | None:
    """A body at rest, as it is drawn whatever it is beside; None of bodies without end, and of those that deform."""
    if id(rest) in known:
        return known[id(rest)]
    if isinstance(rest, Polyhedron):
        drawing = Drawing(rest, rest.vertices, rest.triangles, sharp_edges(rest))
    elif isinstance(rest, Compound):
        drawing = Drawing(rest, *compound.parts(rest))
    elif isinstance(rest, RuledSurface | RuledStrip):
        if rest.deforming or not rest.bounded:
            return None
        drawing = _ruled(rest, *rest.bounds())
    elif hasattr(rest, "skin") and rest.bounded:
        drawing = _solid(rest, *rest.bounds())
    else:
        return None
    known[id(rest)] = drawing
    return drawing


def _box_near(pair: PairView, body: Body, other: Body) -> tuple[np.ndarray, np.ndarray]:
    """The part of an unbounded body that is drawn: near where the other one passes, in the body's frame."""
    lo, hi = other.bounds(pair.window)
    if not np.all(np.isfinite([lo, hi])) and pair.curve is not None:
        lo, hi = sight(pair.curve)
    if not np.all(np.isfinite([lo, hi])):
        raise InputError(f"cannot draw {body.name or 'a body'}: both bodies are unbounded")
    m = pose(body, pair.window[0] if pair.contact_time is None else pair.contact_time)
    centre = np.linalg.solve(m[:3, :3], (lo + hi) / 2 - m[:3, 3])
    half = np.linalg.norm(hi - lo) / 4  # the faces are drawn as far as this box's diagonal
    return centre - half, centre + half


def _ruled(body: RuledSurface | RuledStrip, lo: np.ndarray, hi: np.ndarray) -> Drawing:
    size = float(np.linalg.norm(hi - lo))
    if body.bounded:
        vertices, triangles, owner, lines = ruled.bounded_parts(body, TOLERANCE * size)
    else:
        vertices, triangles, owner, lines = ruled.parts_in_sight(body, (lo + hi) / 2, size)
    return Drawing(body, vertices, triangles, lines, None, owner)


def _deforming(pair: PairView, body: RuledSurface | RuledStrip) -> Drawing:
    lo, hi = pair.window
    moments = [t for t in pair.moments if lo <= t <= hi]
    times = np.unique([*np.linspace(lo, hi, FRAMES), *moments])
    times, (frames, triangles, owner, lines) = ruled.deforming_parts(body, times)
    shown = lo if pair.contact_time is None else pair.contact_time
    vertices = frames[np.abs(times - shown).argmin()]
    resting = body.at(shown) if pair.elements[0] else body
    return Drawing(resting, vertices, triangles, lines, None, owner, frames=(times, frames))


def _solid(body: Any, lo: np.ndarray, hi: np.ndarray) -> Drawing:
    size = float(np.linalg.norm(hi - lo))
    corners, owner, normals = body.skin(_tolerance(body, size), lo, hi)
    proper = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).min(axis=1) > 1e-9 * size
    corners, owner, normals = corners[proper], owner[proper], normals[proper]
    vertices, normals, triangles = _welded(corners, normals, owner, size)
    curves = tuple(_segments(edge, (lo + hi) / 2, size) for edge in body.edges)
    ends = np.concatenate([np.empty((0, 3)), *curves])
    return Drawing(
        body,
        np.concatenate([vertices, ends]),
        triangles,
        len(vertices) + np.arange(len(ends)).reshape(-1, 2),
        np.concatenate([normals, np.zeros_like(ends)]),
        owner,
        curves,
    )


def _tolerance(body: CompositeQuadric | Torus, size: float) -> float:
    conics = [edge.frame for edge in body.edges if edge.frame.shape == (4, 3)]
    radius = min((float(np.linalg.norm(frame[:3, 1:], axis=0).min()) for frame in conics), default=math.inf)
    return TOLERANCE * size * min(1.0, max(ROUNDNESS * radius / (TOLERANCE * size), 0.1))


def _welded(
    corners: np.ndarray, normals: np.ndarray, owner: np.ndarray, size: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices, their normals, and triangles: equal corners of one face with equal normals are one vertex."""
    keys = np.concatenate([corners / (1e-9 * size), normals * 1e4, np.repeat(owner, 3).reshape(-1, 3, 1)], axis=2)
    _, first, number = np.unique(np.round(keys).reshape(-1, 7), axis=0, return_index=True, return_inverse=True)
    return corners.reshape(-1, 3)[first], normals.reshape(-1, 3)[first], number.reshape(-1, 3)


def _segments(edge: Edge, centre: np.ndarray, reach: float) -> np.ndarray:
    """(2 k, 3) ends of segments along the edge, within `reach` of the centre where it goes on for ever."""
    found = [np.empty((0, 3))]
    for piece in edge.pieces:
        with np.errstate(all="ignore"):  # branches that run to infinity
            points = edge.points(_parameters(edge, piece.lo, piece.hi, centre, reach))
        points = points[np.linalg.norm(points - centre, axis=1) <= 2 * reach]
        found.append(np.repeat(points, 2, axis=0)[1:-1])
    return np.concatenate(found)


def _parameters(edge: Edge, lo: float, hi: float, centre: np.ndarray, reach: float) -> Sequence[float] | np.ndarray:
    if isinstance(edge.carrier, QuarticCurve):
        return np.linspace(lo, hi, min(int(hi - lo), 4 * CHORDS) + 1)
    if edge.frame.shape[1] == 2:
        middle = float(edge.frame[:3, 0] @ (centre - edge.frame[:3, 1]))
        return [max(lo, middle - reach), min(hi, middle + reach)]
    return np.linspace(lo, hi, max(8, math.ceil(CHORDS * (hi - lo) / (2 * math.pi))) + 1)


def contact_curve(pair: PairView) -> np.ndarray:
    """(n, 3) float64 points, world frame at the contact, of the shared set where it is more than a point."""
    shared = None if pair.first is None else pair.first.contact_set
    points = np.asarray(getattr(shared, "points", np.empty((0, 3))), float).reshape(-1, 3)
    if str(shared) == "patch" and len(points) > 2:
        points = np.concatenate([points, points[:1]])
    return points if len(points) > 1 else np.empty((0, 3))


