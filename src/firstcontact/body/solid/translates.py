"""The features of a translate: those of the model it was made of, by the same numbers, carried along exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.body.solid.carriers import (
    AlgebraicPoint,
    EnclosedPoint,
    Point,
    QuarticCurve,
    Rows,
    Surface,
    Vector,
)
from firstcontact.body.solid.features import Edge, Features, rounded
from firstcontact.exact.numbers import to_double

if TYPE_CHECKING:
    from firstcontact.body.solid.features import Face, Vertex

MOST_LOST = 4.0
"""Times as large as after it may coordinates be before a translation: rounded there, they are as good here."""


def translated(features: Features, v: Vector, matrix: Rows, surfaces: Sequence[Surface]) -> Features | None:
    """The features under a translation by v, as a 4x4 matrix too; surfaces: as they are after it.

    None where doubles of curves would lose digits: to work them out anew is as good as anything then.
    """
    way = np.array([to_double(x) for x in v])
    moved = [_moved(edge, way, matrix) for edge in (*features.edges, *features.seams)]
    if any(edge is None for edge in moved):
        return None
    edges = tuple(edge for edge in moved if edge is not None)
    count = len(features.edges)
    return Features(
        tuple(_face(face, surfaces) for face in features.faces), edges[:count], edges[count:],
        tuple(_vertex(vertex, v, matrix) for vertex in features.vertices),
    )  # fmt: skip


def _face(face: Face, surfaces: Sequence[Surface]) -> Face:
    own = surfaces[face.surfaces[0]]
    return replace(face, carrier=own if face.orientation > 0 else own.negated())


def _moved(edge: Edge, way: np.ndarray, matrix: Rows) -> Edge | None:
    if isinstance(edge.carrier, QuarticCurve):
        frame = edge.frame + way
        before, after = edge.frame, frame
    else:
        frame = edge.frame.copy()
        frame[:3] += np.outer(way, frame[3])
        first = 1 if frame.shape[1] == 2 else 0  # the point of a line, after its direction
        before, after = edge.frame[:3, first:], frame[:3, first:]
    if not np.abs(before).max() <= MOST_LOST * np.abs(after).max():
        return None
    return replace(edge, carrier=edge.carrier.placed(matrix), frame=frame)


def _vertex(vertex: Vertex, v: Vector, matrix: Rows) -> Vertex:
    carrier = _point(vertex.carrier, v, matrix)
    position, error = rounded(carrier)
    return replace(vertex, carrier=carrier, position=position, error=error)


def _point(
    carrier: Point | AlgebraicPoint | EnclosedPoint, v: Vector, matrix: Rows
) -> Point | AlgebraicPoint | EnclosedPoint:
    if isinstance(carrier, Point):
        return carrier.placed(matrix)
    if isinstance(carrier, EnclosedPoint):
        return replace(carrier, centre=tuple(c + x for c, x in zip(carrier.centre, v, strict=True)))
    rows = zip(carrier.coordinates, v, strict=True)
    return replace(carrier, coordinates=tuple((row[0] + x, *row[1:]) if row else (x,) for row, x in rows))
