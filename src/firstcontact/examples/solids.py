"""Solids to try things on: boxes, noisy spheres, tori, gears, a lid with its box, an arm with its post.

Every function returns a closed Polyhedron of triangles oriented outward: every directed edge once with its
reverse.  ``triangles`` is the wanted number, met within a few per cent.  Noise comes from
``numpy.random.default_rng(seed)``, so a seed names one mesh.

>>> noisy_sphere(1000)
<Polyhedron 'noisy_sphere': solid, 492 vertices, 1470 edges, 980 faces>
"""

from collections.abc import Callable
from functools import wraps
from itertools import combinations
from math import cos, pi, radians, sqrt, tan
from typing import ParamSpec

import numpy as np
from numpy.typing import NDArray

from firstcontact.body.polyhedron.polyhedron import Polyhedron

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]
Mesh = tuple[FloatArray, IntArray]
"""Vertices (n, 3) float64 and triangles (m, 3) int32."""

__all__ = ["arm", "box", "box_with_knob", "lid", "noisy_sphere", "post", "spur_gear", "torus"]

P = ParamSpec("P")


def _solid(make: Callable[P, Mesh]) -> Callable[P, Polyhedron]:
    """The same function, its mesh as a Polyhedron of the function's name."""

    @wraps(make)
    def body(*args: P.args, **kwargs: P.kwargs) -> Polyhedron:
        return Polyhedron(*make(*args, **kwargs), name=make.__name__)

    return body


@_solid
def box(
    size: tuple[float, float, float] = (1.0, 1.0, 1.0), divisions: tuple[int, int, int] = (1, 1, 1)
) -> Mesh:
    """A box centred on the origin, edges ``size`` long; each side is a grid of halved rectangles."""
    vertices, faces = _grid_box(size, divisions)
    return vertices - np.asarray(size) / 2.0, faces


@_solid
def noisy_sphere(triangles: int = 1000, radius: float = 1.0, noise: float = 0.02, seed: int = 0) -> Mesh:
    """A geodesic sphere about the origin, each vertex at the distance radius * (1 + noise * U(-1, 1))."""
    frequency = max(1, round(sqrt(triangles / 20)))
    directions, faces = _geodesic(frequency)
    heights = radius * (1.0 + noise * np.random.default_rng(seed).uniform(-1.0, 1.0, len(directions)))
    return directions * heights[:, None], faces


@_solid
def torus(
    triangles: int = 1000, major: float = 1.0, minor: float = 0.3, noise: float = 0.02, seed: int = 0
) -> Mesh:
    """A ring about the z axis: a tube of radius minor * (1 + noise * U(-1, 1)) along a circle."""
    across = max(3, round(sqrt(triangles * minor / (2.0 * major)) * 1.2))
    along = max(3, round(triangles / (2 * across)))
    u = np.arange(along)[:, None] * (2.0 * pi / along)
    v = np.arange(across)[None, :] * (2.0 * pi / across)
    thickness = minor * (1.0 + noise * np.random.default_rng(seed).uniform(-1.0, 1.0, (along, across)))
    ring = major + thickness * np.cos(v)
    points = np.stack([ring * np.cos(u), ring * np.sin(u), thickness * np.sin(v)], axis=-1)
    return points.reshape(-1, 3), _ring_faces(along, across)


@_solid
def spur_gear(
    triangles: int = 1000,
    teeth: int = 20,
    pitch_radius: float = 1.0,
    width: float = 0.4,
    bore: float = 0.4,
    backlash: float = 0.0,
    layers: int = 1,
) -> Mesh:
    """An involute spur gear about the z axis, |z| <= width / 2, with a round bore and a tooth on the x axis.

    ``backlash``: the part of a tooth's thickness at the pitch circle that is taken away.  With ``layers=1``
    every triangle spans the whole width or the whole web: fine gears then consist of long thin triangles, as
    CAD exports do.
    """
    per_tooth = max(6, round(triangles / (4 * (layers + 1) * teeth)))
    radius, angle = _gear_outline(teeth, per_tooth, pitch_radius, backlash)
    rim = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    hole = np.stack([bore * np.cos(angle), bore * np.sin(angle)], axis=-1)
    levels = np.linspace(-width / 2, width / 2, layers + 1)
    outside = [(rim, z) for z in levels]
    inside = [(hole, z) for z in levels[::-1]]
    loops = [np.column_stack([outline, np.full(len(outline), z)]) for outline, z in outside + inside]
    points = np.stack(loops, axis=1)
    return points.reshape(-1, 3), _ring_faces(len(angle), len(loops))


def _grid_box(size: tuple[float, float, float], divisions: tuple[int, int, int]) -> Mesh:
    """A box with one corner at the origin; each side is a grid of rectangles, each cut in two."""
    corners: list[NDArray[np.int64]] = []
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        for far in (False, True):
            corners.append(_box_side(axis, i, j, divisions, far))
    keys, faces = _welded(np.concatenate(corners).reshape(-1, 3))
    return keys * (np.asarray(size) / np.asarray(divisions)), faces


@_solid
def box_with_knob(triangles: int = 1000, size: tuple[float, float, float] = (1.0, 0.8, 0.4)) -> Mesh:
    """A box on the xy plane, one corner at the origin, with a raised rim and a knob far from x = 0."""

    def relief(x: FloatArray, y: FloatArray) -> FloatArray:
        border = np.minimum(np.minimum(x, size[0] - x), np.minimum(y, size[1] - y))
        rim = 0.04 * np.clip(1.0 - border / 0.08, 0.0, 1.0)
        knob = 0.25 * np.exp(-((x - 0.73 * size[0]) ** 2 + (y - 0.42 * size[1]) ** 2) / 0.09**2)
        return rim + knob

    return _with_relief(size, _divisions(triangles, size), relief)


@_solid
def lid(triangles: int = 1000, size: tuple[float, float, float] = (1.0, 0.8, 0.06)) -> Mesh:
    """A closed lid: a slab on the xy plane, one corner at the origin, with shallow ribs on its lower side."""

    def ribs(x: FloatArray, y: FloatArray) -> FloatArray:
        return 0.012 * (np.cos(23.0 * x + 1.0) * np.cos(17.0 * y + 0.4) - 1.0)

    vertices, faces = _with_relief(size, _divisions(triangles, size), ribs)
    # The relief is made on the upper side; half a turn about the middle line parallel to y brings it below.
    turned = np.array([size[0], 0.0, size[2]]) + vertices * np.array([-1.0, 1.0, -1.0])
    return turned, faces


def _tube(
    path: FloatArray, radius: FloatArray, around: int, up: tuple[float, float, float] = (0.0, 0.0, 1.0)
) -> Mesh:
    """A round tube with flat ends.

    path: (k, 3) centre line, never parallel to ``up``.  radius: (k, around), measured from the centre line.
    """
    forward = np.gradient(path, axis=0)
    side = np.cross(forward, np.asarray(up))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    top = np.cross(side, forward)
    top /= np.linalg.norm(top, axis=1, keepdims=True)
    angle = np.arange(around) * (2.0 * pi / around)
    spokes = side[:, None, :] * np.cos(angle)[:, None] + top[:, None, :] * np.sin(angle)[:, None]
    skin = path[:, None, :] + radius[:, :, None] * spokes
    vertices = np.concatenate([skin.reshape(-1, 3), path[:1], path[-1:]])
    return vertices, _tube_faces(len(path), around)


@_solid
def arm(triangles: int = 1000, noise: float = 0.01, seed: int = 0) -> Mesh:
    """A bent arm that reaches from its shoulder on the z axis to a hand at (1.0, 0.0, -0.35)."""
    around, along = _tube_divisions(triangles, slenderness=2.0)
    s = np.linspace(0.0, 1.0, along)
    path = np.column_stack([1.0 * s, 0.12 * np.sin(pi * s), 0.5 - 0.85 * s**3])
    shape = 0.11 - 0.05 * s + 0.03 * np.exp(-(((s - 0.95) / 0.05) ** 2))
    rough = 1.0 + noise * np.random.default_rng(seed).uniform(-1.0, 1.0, (along, around))
    return _tube(path, shape[:, None] * rough, around, up=(0.0, 1.0, 0.0))


@_solid
def post(triangles: int = 1000, height: float = 1.2, noise: float = 0.01, seed: int = 0) -> Mesh:
    """A turned post about the z axis, |z| <= height / 2, with beads along it."""
    around, along = _tube_divisions(triangles, slenderness=1.5)
    s = np.linspace(0.0, 1.0, along)
    path = np.column_stack([np.zeros(along), np.zeros(along), height * (s - 0.5)])
    shape = 0.09 + 0.02 * np.cos(9.0 * pi * s)
    rough = 1.0 + noise * np.random.default_rng(seed).uniform(-1.0, 1.0, (along, around))
    return _tube(path, shape[:, None] * rough, around, up=(1.0, 0.0, 0.0))


def _welded(keys: NDArray[np.int64]) -> tuple[NDArray[np.int64], IntArray]:
    """Unique rows of keys (3 m, k), and the (m, 3) triangles over them; integers, so equal means equal."""
    unique, index = np.unique(keys, axis=0, return_inverse=True)
    return unique, index.reshape(-1, 3).astype(np.int32)


def _geodesic(frequency: int) -> Mesh:
    """Unit vectors and faces of the icosahedron with every edge cut into ``frequency`` parts.

    A coordinate is held as integers (p, q), meaning p + q phi, so that shared vertices weld exactly.
    """
    corners = np.array(
        [np.roll([0, 0, one, 0, 0, golden], 2 * k) for k in range(3) for one in (1, -1) for golden in (1, -1)]
    )
    phi = (1.0 + sqrt(5.0)) / 2.0

    def position(keys: NDArray[np.int64]) -> FloatArray:
        return keys[..., 0::2] + phi * keys[..., 1::2]

    xyz = position(corners)
    triples = [
        (a, b, c)
        for a, b, c in combinations(range(12), 3)
        if all(abs(np.linalg.norm(xyz[p] - xyz[q]) - 2.0) < 0.1 for p, q in ((a, b), (b, c), (a, c)))
    ]
    outward = [(a, b, c) if np.linalg.det(xyz[[a, b, c]]) > 0 else (a, c, b) for a, b, c in triples]
    weights = _triangle_grid(frequency)
    keys = np.concatenate([weights @ corners[list(triple)] for triple in outward])
    unique, faces = _welded(keys.reshape(-1, 6))
    points = position(unique)
    return points / np.linalg.norm(points, axis=1, keepdims=True), faces


def _triangle_grid(frequency: int) -> NDArray[np.int64]:
    """(frequency**2, 3, 3) integers: triangle, its corner, the weights of the corner (sum: frequency)."""
    cells = []
    for i in range(frequency):
        for j in range(frequency - i):
            cells.append([(i, j), (i + 1, j), (i, j + 1)])
            if i + j + 1 < frequency:
                cells.append([(i + 1, j), (i + 1, j + 1), (i, j + 1)])
    ij = np.array(cells)
    first = frequency - ij.sum(axis=-1, keepdims=True)
    return np.concatenate([first, ij], axis=-1)


def _ring_faces(rows: int, columns: int) -> IntArray:
    """Faces of a grid of rows x columns points that closes on itself in both directions."""
    i, j = (grid.ravel() for grid in np.indices((rows, columns)))
    i1, j1 = (i + 1) % rows, (j + 1) % columns
    return _quads(i * columns + j, i1 * columns + j, i1 * columns + j1, i * columns + j1)


def _quads(a: NDArray, b: NDArray, c: NDArray, d: NDArray) -> IntArray:
    """Two triangles for each quadrilateral a b c d."""
    return np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3).astype(np.int32)


def _tube_faces(along: int, around: int) -> IntArray:
    """Skin of a tube of ``along`` rings, then the fans about its two end points."""
    i, j = (grid.ravel() for grid in np.indices((along - 1, around)))
    j1 = (j + 1) % around
    skin = _quads(i * around + j, (i + 1) * around + j, (i + 1) * around + j1, i * around + j1)
    ring = np.arange(around)
    following = (ring + 1) % around
    last = (along - 1) * around
    start = np.full(around, along * around)
    first_fan = np.stack([start, ring, following], axis=-1)
    last_fan = np.stack([start + 1, last + following, last + ring], axis=-1)
    return np.concatenate([skin, first_fan, last_fan]).astype(np.int32)


def _tube_divisions(triangles: int, slenderness: float) -> tuple[int, int]:
    """Points around and rings along a tube: 2 around along triangles; ``slenderness`` = along / around."""
    around = max(3, round(sqrt(triangles / 2.0 / slenderness)))
    return around, max(3, round(triangles / (2.0 * around)))


def _box_side(axis: int, i: int, j: int, divisions: tuple[int, int, int], far: bool) -> NDArray[np.int64]:
    """(m, 3, 3) integer corners of the triangles on one side of a box; (axis, i, j) is right-handed."""
    u, v = (grid.ravel() for grid in np.indices((divisions[i], divisions[j])))
    corners = np.zeros((len(u), 4, 3), dtype=np.int64)
    corners[:, :, axis] = divisions[axis] if far else 0
    for corner, (du, dv) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
        corners[:, corner, i] = u + du
        corners[:, corner, j] = v + dv
    halves = [(0, 1, 2), (0, 2, 3)] if far else [(0, 2, 1), (0, 3, 2)]
    return np.concatenate([corners[:, half] for half in halves])


def _divisions(triangles: int, size: tuple[float, float, float]) -> tuple[int, int, int]:
    """Divisions of a flat box for about ``triangles`` triangles: near to square above, four up its height."""
    x, y, rows = size[0], size[1], 4
    # 4 (nx ny + rows (nx + ny)) = triangles with nx = x k, ny = y k.
    half = rows * (x + y) / 2.0
    k = (sqrt(half * half + x * y * triangles / 4.0) - half) / (x * y)
    return max(1, round(x * k)), max(1, round(y * k)), rows


def _with_relief(
    size: tuple[float, float, float],
    divisions: tuple[int, int, int],
    relief: Callable[[FloatArray, FloatArray], FloatArray],
) -> Mesh:
    """A box whose upper side is lifted by relief(x, y) > -size[2]; its walls stretch along."""
    vertices, faces = _grid_box(size, divisions)
    x, y, z = vertices.T
    return np.column_stack([x, y, z + relief(x, y) * (z / size[2])]), faces


def _gear_outline(
    teeth: int, per_tooth: int, pitch_radius: float, backlash: float
) -> tuple[FloatArray, FloatArray]:
    """Radius and strictly increasing angle of teeth * per_tooth points; the pressure angle is 20 degrees."""
    module = 2.0 * pitch_radius / teeth
    root, tip = pitch_radius - 1.25 * module, pitch_radius + module
    base = pitch_radius * cos(radians(20.0))
    # The flank leans this much more than the involute, in radians per module of height, so that no part of it
    # is radial and the web's triangles between flank and bore keep an area.
    lean = 0.02 * (2.0 * pi / teeth)

    def half_angle(r: FloatArray) -> FloatArray:
        pressure = np.arccos(np.minimum(1.0, base / r))
        involute = tan(radians(20.0)) - radians(20.0) - (np.tan(pressure) - pressure)
        return pi / (2 * teeth) * (1.0 - backlash) + involute + lean * (pitch_radius - r) / module

    land, flank = max(1, per_tooth // 8), (per_tooth - 2 * max(1, per_tooth // 8)) // 2
    valley = per_tooth - land - 2 * flank
    rising = np.linspace(root, tip, flank + 1)
    flank_angle = half_angle(rising)
    tip_angle = np.linspace(-flank_angle[-1], flank_angle[-1], land + 1)[1:-1]
    pitch = 2.0 * pi / teeth
    root_angle = np.linspace(flank_angle[0], pitch - flank_angle[0], valley + 1)[1:-1]
    radius = np.concatenate([rising, np.full(land - 1, tip), rising[::-1], np.full(valley - 1, root)])
    angle = np.concatenate([-flank_angle, tip_angle, flank_angle[::-1], root_angle])
    turns = np.arange(teeth)[:, None] * pitch
    return np.tile(radius, teeth), (angle[None, :] + turns).ravel()
