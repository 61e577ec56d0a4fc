"""Encounters of n moving points with n long facets in many layers, and of two convex bodies.

A box around a long oblique facet is mostly empty; here most of the n points lie in most of the n boxes.  Points
without edges leave vertex/facet pairs alone to be tested; ``closed`` makes thin solids of points and facets.

>>> tangent_plates(100).resting
<Polyhedron 'plates': surface, 300 vertices, 300 edges, 100 faces>
"""

from __future__ import annotations

from math import cos, pi, sin, tan

import numpy as np

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.examples.encounter import GRID, Encounter, FloatArray, motion_over, placed, rounded
from firstcontact.examples.solids import noisy_sphere
from firstcontact.motion.rotation import Rotation

STANDS_OUT = 8.0
"""How far a planted point and its plate stand out, in deltas."""


def slats_over_points(n: int, *, turning: bool = False, closed: bool = False, seed: int = 0) -> Encounter:
    """Points in a cube and a thicket of long slats (thin triangles) of all directions through it.

    Seen along z a slat covers about 2 / n of the square, so that about every second point has a slat above it.
    """
    random = np.random.default_rng(seed)
    points = random.uniform(-1.0, 1.0, (n, 3))
    middle = random.uniform(-1.0, 1.0, (n, 3))
    angle, rise = random.uniform(0.0, 2.0 * pi, n), random.uniform(-0.5, 0.5, n)
    along = 2.0 * np.stack([np.cos(angle), np.sin(angle), rise], axis=-1)
    aside = (2.0 / n) * np.stack([-np.sin(angle), np.cos(angle), np.zeros(n)], axis=-1)
    slats = np.stack([middle - along, middle + along - aside, middle + along + aside], axis=1)
    return _encounter(points, slats, "slats", 1.0, turning, closed, 0.1 / n**2, None)


def tangent_plates(
    n: int,
    *,
    delta: float = 2.0**-10,
    planted: bool = False,
    turning: bool = False,
    closed: bool = False,
    seed: int = 0,
) -> Encounter:
    """Points just below a shallow dome, each plate a wide triangle that touches it: any plate is above any point.

    The gap of point p and the plate that touches at q is |p - q|^2 / 8 and a few ``delta``.  planted: one point
    stands out and so does the plate over it; the two meet first.
    """
    random = np.random.default_rng(seed)
    below, touching = random.uniform(-1.0, 1.0, (2, n, 2))
    sunk, lifted = delta * random.uniform(0.0, 1.0, (2, n))
    above, first = delta, None
    if planted:
        # Gap of the two: 1 to 3 deltas; of any other pair at least STANDS_OUT + 1 less rounding.  A turn meets a gap
        # g at an angle between g / 4.5 and g / 1.7, which keeps the order.
        first = int(random.integers(n)), int(random.integers(n))
        touching[first[1]] = below[first[0]]
        sunk[first[0]] = lifted[first[1]] = -STANDS_OUT * delta
        above = (2.0 * STANDS_OUT + 1.0) * delta
    points = np.column_stack([below, -np.sum(below**2, axis=1) / 8.0 - sunk])
    corners = np.broadcast_to([(-4.0, -2.0), (4.0, -2.0), (0.0, 6.0)], (n, 3, 2))
    z = np.einsum("ijk,ik->ij", corners - touching[:, None] / 2.0, touching) / -4.0
    plates = np.concatenate([corners, (z + (above + lifted)[:, None])[..., None]], axis=-1)
    return _encounter(points, plates, "plates", 32.0 * delta, turning, closed, delta / 64.0, first)


def nested_shells(n: int, *, seed: int = 0) -> Encounter:
    """Points between nested six-sided tubes with slits along their corners, which turn about the tubes' axis.

    About n / 12 tubes of 12 triangles, one inside the next, and n points, each between two neighbouring tubes.
    Nothing is on a grid.
    """
    random = np.random.default_rng(seed)
    tubes = max(2, round(n / 12))
    radius = 1.0 + np.arange(tubes) / tubes
    faces = np.array([(0, 1, 2), (0, 2, 3)]) + 4 * np.arange(6 * tubes)[:, None, None]
    half = 0.9 * tan(pi / 6)
    shells = []
    for side in range(6):
        out, aside = _side(side)
        rims = [radius[:, None] * (out + way * half * aside) for way in (-1.0, 1.0, 1.0, -1.0)]
        shells.append(np.stack([rim + [0.0, 0.0, z] for rim, z in zip(rims, (0, 0, 1, 1), strict=True)], axis=1))
    corners = np.stack(shells, axis=1).reshape(-1, 3)
    points = np.empty((n, 3))
    within = random.integers(tubes, size=n) + random.uniform(0.1, 0.9, n)
    sides, way = random.integers(6, size=n), random.uniform(-0.8, 0.8, n)
    for i in range(n):
        out, aside = _side(int(sides[i]))
        points[i] = (1.0 + within[i] / tubes) * (out + way[i] * half * aside)
    points[:, 2] = random.uniform(0.1, 0.9, n)
    a = Polyhedron(points, [], name="points")
    b = Polyhedron(corners, faces.reshape(-1, 3).astype(np.int32), name="shells")
    return Encounter(a, b, Rotation((0, 0, 1), radians=0.5))


def convex_pair(triangles: int = 1000, *, seed: int = 0) -> Encounter:
    """Two convex bodies, geodesic ellipsoids of about as many triangles; one turns about the z axis into the other."""
    random = np.random.default_rng(seed)
    a = noisy_sphere(triangles, noise=0.0).rotated(random.uniform(-1, 1, 3), degrees=70)
    b = noisy_sphere(triangles, noise=0.0).rotated(random.uniform(-1, 1, 3), degrees=110)
    stretched = a.vertices * (1.0, 0.8, 0.5) + (3.0, 0.0, 0.0)
    squeezed = b.vertices * (0.7, 0.6, 0.9) + (3.4 * cos(0.9), 3.4 * sin(0.9), 0.35)
    return Encounter(
        Polyhedron(stretched, a.triangles, name="turning body"),
        Polyhedron(squeezed, b.triangles, name="resting body"),
        Rotation((0, 0, 1), radians=1.0),
    )


def _side(side: int) -> tuple[FloatArray, FloatArray]:
    """Unit vectors out of one of six sides about the z axis, and along it."""
    angle = side * pi / 3
    return np.array([cos(angle), sin(angle), 0.0]), np.array([-sin(angle), cos(angle), 0.0])


def _encounter(
    points: FloatArray,
    facets: FloatArray,
    name: str,
    length: float,
    turning: bool,
    closed: bool,
    thickness: float,
    first: tuple[int, int] | None,
) -> Encounter:
    """The bodies of points (n, 3) that move along +z and facets (m, 3, 3), made so and then placed."""
    points, facets = placed(rounded(points), turning), placed(rounded(facets), turning)
    motion = motion_over(length, turning)
    if closed:
        up = np.array([0.0, 1.0, 0.0] if turning else [0.0, 0.0, 1.0])
        a, b = _spikes(points, -up, max(thickness, GRID)), _wedges(facets, up * max(thickness, GRID), name)
        return Encounter(a, b, motion, first)
    triangles = np.arange(facets.size // 3, dtype=np.int32).reshape(-1, 3)
    return Encounter(
        Polyhedron(points, [], name="points"), Polyhedron(facets.reshape(-1, 3), triangles, name=name), motion, first
    )


# Corners of a tetrahedron: its tip or first corner, then the other three.
_TETRAHEDRON = np.array([(1, 2, 3), (0, 2, 1), (0, 3, 2), (0, 1, 3)])


def _solids(corners: FloatArray, name: str) -> Polyhedron:
    """Tetrahedra (n, 4, 3), each turned so that it looks outward; the i-th has the triangles 4 i .. 4 i + 3."""
    side = corners[:, 1:] - corners[:, :1]
    inside_out = np.linalg.det(side) > 0.0
    corners = np.where(inside_out[:, None, None], corners[:, [0, 2, 1, 3]], corners)
    faces = _TETRAHEDRON[:, ::-1] + 4 * np.arange(len(corners))[:, None, None]
    return Polyhedron(corners.reshape(-1, 3), faces.reshape(-1, 3).astype(np.int32), name=name)


def _spikes(tips: FloatArray, into: FloatArray, width: float) -> Polyhedron:
    """A slender tetrahedron behind every point (n, 3), 4 width long; ``into``: unit vector along it."""
    aside = np.roll(into, 1)
    across = np.cross(into, aside)
    ring = [4.0 * into + cos(k) * aside + sin(k) * across for k in (0.0, 2.0 * pi / 3, 4.0 * pi / 3)]
    corners = tips[:, None, :] + width * np.array([np.zeros(3), *ring])
    return _solids(corners, "spikes")


def _wedges(facets: FloatArray, into: FloatArray, name: str) -> Polyhedron:
    """A flat tetrahedron over every triangle (n, 3, 3): its apex lies ``into`` beyond the middle."""
    apex = facets.mean(axis=1, keepdims=True) + into
    return _solids(np.concatenate([apex, facets], axis=1), name)
