"""Two bodies on their way to meet: what a generator of hard scenes returns, and how it places them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.motion.moving import Moving
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.translation import Translation

FloatArray = NDArray[np.float64]

GRID = 2.0**-20
"""Coordinates are whole multiples of it, unless a generator says otherwise."""
ABOUT = 3.0
"""Distance between the axis of a turning encounter and the middle of its bodies."""


@dataclass(frozen=True, eq=False)
class Encounter:
    """Body a moves under the motion, body b rests; time runs over (0, 1).

    first: the rod (or vertex) of a and the rod (or facet) of b that meet first, counted from 0 in the order of
    the body's edges (vertices, facets, closed rods), where the construction proves it; None where it does not.
    """

    a: Polyhedron
    b: Polyhedron
    motion: Translation | Rotation
    first: tuple[int, int] | None = None

    @property
    def moving(self) -> Moving:
        return self.a.moving(self.motion)

    @property
    def resting(self) -> Polyhedron:
        return self.b


def rounded(points: FloatArray) -> FloatArray:
    """The points on the grid, so that products of a few coordinates are short."""
    return np.round(points / GRID) * GRID


def placed(points: FloatArray, turning: bool) -> FloatArray:
    """Points of a scene that is made for a move along +z, where it is to be turned about the z axis instead.

    (x, y, z) goes to (ABOUT + x, z, y): +z becomes the direction in which a turn sets out near (ABOUT, 0, 0).
    """
    if not turning:
        return points
    return points[..., [0, 2, 1]] + np.array([ABOUT, 0.0, 0.0])


def motion_over(length: float, turning: bool) -> Translation | Rotation:
    """The move by ``length`` along +z, or the turn about the z axis by as many radians."""
    if turning:
        return Rotation((0, 0, 1), radians=float(length))
    return Translation((0.0, 0.0, float(length)))


def edge_set(segments: FloatArray, name: str) -> Polyhedron:
    """Bare edges (n, 2, 3), edge i the i-th segment."""
    return Polyhedron(segments.reshape(-1, 3), [], edges=np.arange(2 * len(segments)).reshape(-1, 2), name=name)


# A prism's corners: the ridge's first end and the two beside it, then the same at the second end.
_PRISM = np.array([(0, 1, 2), (3, 5, 4), (0, 4, 1), (0, 3, 4), (1, 5, 2), (1, 4, 5), (2, 3, 0), (2, 5, 3)])


def closed_rods(segments: FloatArray, away: FloatArray, width: float, name: str) -> Polyhedron:
    """Triangular prisms whose ridges are the segments (n, 2, 3); rod i has the triangles 8 i .. 8 i + 7.

    away: unit vectors (n, 3) or (3,), from the ridge into the rod; a rod is 2 width deep and 2 width wide.
    """
    along = segments[:, 1] - segments[:, 0]
    into = 2.0 * width * np.broadcast_to(away, along.shape)
    aside = np.cross(along, into)
    aside *= width / np.linalg.norm(aside, axis=1, keepdims=True)
    offsets = np.stack([np.zeros_like(into), into + aside, into - aside], axis=1)
    corners = segments[:, :, None, :] + offsets[:, None, :, :]
    faces = _PRISM + 6 * np.arange(len(segments))[:, None, None]
    return Polyhedron(corners.reshape(-1, 3), faces.reshape(-1, 3).astype(np.int32), name=name)
