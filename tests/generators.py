"""Scenes for tests: near-miss families, closed meshes, and small random or degenerate ones.

Coordinates of the float families are multiples of 2^-20, so that the doubles are exact.  Everything is
a function of its seed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations

import numpy as np

from vectors import Body

Y = 1.25  # half length of the long lines of a layered family


@dataclass(frozen=True)
class Scene:
    """Body a moves by one motion until `until` (None: 1 for a rotation, else for ever), body b rests."""

    a: Body
    b: Body
    translation: tuple | None = None
    rotation: dict | None = None  # axis, point, turns or radians
    until: float | Fraction | int | None = None
    solid: bool = False  # True: closed bodies own their interior


def on_grid(x) -> np.ndarray:
    return np.round(np.asarray(x, float) * 2**20) / 2**20


def _lines(first, last) -> Body:
    """Edges from first[i] to last[i]; both (n, 3)."""
    n = len(first)
    points = on_grid(np.stack([first, last], axis=1).reshape(2 * n, 3))
    return Body(points.tolist(), [[2 * i, 2 * i + 1] for i in range(n)], [])


# ----------------------------------------------------------------------- near-miss families, translation +z


def layered(n: int, delta: float, seed: int, *, tilt: float = 0.0, lower: float = 0.0, planted: bool = False):
    """Two layers of rulings of z = xy, all n * n gaps of the order of delta.  (moving, resting) edge sets.

    tilt: the rulings are turned by up to tilt.  lower: the moving layer starts that much deeper.
    planted: one ruling of each layer sticks out, so that the first contact is at one of these two.
    """
    rng = np.random.default_rng(seed)
    grid = (2 * np.arange(n) + 1) / n - 1
    x0, y0 = (grid + rng.uniform(-0.2, 0.2, n) / n for _ in range(2))
    slope_a, slope_b = delta * rng.uniform(-1, 1, (2, n))
    h, s = delta * rng.uniform(0, 1, (2, n))
    z0 = 2.5 * delta
    if planted:
        h[n // 2] = s[n // 3] = -2 * delta
        z0 = 8 * delta
    turn_a, turn_b = tilt * rng.uniform(-1, 1, (2, n))

    def moving(y):
        return np.stack([x0 + turn_a * y, np.full(n, y), (x0 + slope_a) * y - h - lower], axis=1)

    def resting(x):
        return np.stack([np.full(n, x), y0 + turn_b * x, (y0 + slope_b) * x + s + z0], axis=1)

    return _lines(moving(-Y), moving(Y)), _lines(resting(-Y), resting(Y))


def reguli(n: int, delta: float, seed: int, planted: bool = False):
    """Family L."""
    return layered(n, delta, seed, planted=planted)


def tilted_reguli(n: int, delta: float, seed: int):
    """Family Lt."""
    return layered(n, delta, seed, tilt=delta, lower=12 * delta)


def weaving_reguli(n: int, delta: float, seed: int):
    """Family W: gaps of both signs."""
    return layered(n, delta, seed, tilt=delta)


def woven(n: int, seed: int):
    """Family G: long generic lines, all n * n pairs cross in projection."""
    rng = np.random.default_rng(seed)

    def family():
        p, z, k = rng.uniform(-1, 1, (3, n))
        m = rng.uniform(-0.3, 0.3, n)
        return lambda y: np.stack([p + m * y, np.full(n, y), z + k * y], axis=1)

    a, b = family(), family()
    flip = [1, 0, 2]
    return _lines(a(-2.25), a(2.25)), _lines(b(-2.25)[:, flip], b(2.25)[:, flip])


def to_tangent(body: Body) -> Body:
    """(x, y, z) -> (3 + x, z, y): moving along +z becomes turning counterclockwise about the z axis."""
    return Body([[3 + x, z, y] for x, y, z in body.v], body.e, body.f)


FAMILIES: dict[str, Callable[[int, int], tuple[Body, Body]]] = {
    "L": lambda n, seed: reguli(n, 2.0**-10, seed),
    "L planted": lambda n, seed: reguli(n, 2.0**-10, seed, planted=True),
    "Lt": lambda n, seed: tilted_reguli(n, 2.0**-10, seed),
    "W": lambda n, seed: weaving_reguli(n, 2.0**-10, seed),
    "G": lambda n, seed: woven(n, seed),
}


# -------------------------------------------------------------------------------------------- closed meshes


def rods(lines: Body, width: float, up: bool) -> Body:
    """A thin prism on every edge of `lines`, its ridge the edge, its body above (up) or below."""
    corners, faces = [], []
    pattern = [(0, 1, 2), (3, 5, 4), (0, 3, 4), (0, 4, 1), (1, 4, 5), (1, 5, 2), (2, 5, 3), (2, 3, 0)]
    for i, j in lines.e:
        p, q = np.array(lines.v[i]), np.array(lines.v[j])
        along = q - p
        side = width * np.array([-along[1], along[0], 0.0]) / np.hypot(along[0], along[1])
        depth = np.array([0.0, 0.0, 2 * width if up else -2 * width])
        first = len(corners)
        corners += [on_grid(x + d) for x in (p, q) for d in (0 * side, side + depth, depth - side)]
        faces += [[first + k for k in face] for face in pattern]
    return outward(Body([list(map(float, p)) for p in corners], [], faces))


def outward(body: Body) -> Body:
    """Faces turned so that every component has positive volume; components are disjoint in their vertices."""
    points = np.array(body.v, float)
    label = list(range(len(points)))
    for face in body.f:
        merged = {label[i] for i in face}
        label = [min(merged) if k in merged else k for k in label]
    volume = dict.fromkeys(label, 0.0)
    for face in body.f:
        volume[label[face[0]]] += float(np.linalg.det(points[list(face)]))
    return Body(body.v, body.e, [list(f) if volume[label[f[0]]] > 0 else list(f)[::-1] for f in body.f])


CORNERS = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
SQUARES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def box(size=(1, 1, 1), at=(0, 0, 0)) -> Body:
    """12 triangles, outward; `at` is the lowest corner; coordinates stay ints, fractions or floats."""
    points = [[o + s * u for o, s, u in zip(at, size, corner, strict=True)] for corner in CORNERS]
    return Body(points, [], [list(t) for a, b, c, d in SQUARES for t in ((a, b, c), (a, c, d))])


def icosphere(subdivisions: int, radius: float, noise: float, seed: int, at=(0.0, 0.0, 0.0)) -> Body:
    """20 * 4^subdivisions triangles on a sphere whose radius varies by noise * U(-1, 1)."""
    g = (1 + 5**0.5) / 2
    points = [p for s in (-1, 1) for t in (-g, g) for p in ((0, s, t), (s, t, 0), (t, 0, s))]
    points = [np.array(p) / np.linalg.norm(p) for p in points]
    shortest = min(np.linalg.norm(p - q) for p, q in combinations(points, 2)) * 1.01
    near = [[np.linalg.norm(p - q) < shortest for q in points] for p in points]
    faces = [t for t in combinations(range(12), 3) if all(near[i][j] for i, j in combinations(t, 2))]
    for _ in range(subdivisions):
        faces = _split_in_four(points, faces)
    rng = np.random.default_rng(seed)
    radii = radius * (1 + noise * rng.uniform(-1, 1, len(points)))
    placed = on_grid(np.array(points) * radii[:, None] + np.array(at))
    faces = [f if np.linalg.det(np.array([points[i] for i in f])) > 0 else f[::-1] for f in faces]
    return Body(placed.tolist(), [], [list(f) for f in faces])


def _split_in_four(points, faces):
    middle: dict[tuple, int] = {}

    def between(i, j):
        key = (min(i, j), max(i, j))
        if key not in middle:
            p = points[i] + points[j]
            middle[key] = len(points)
            points.append(p / np.linalg.norm(p))
        return middle[key]

    split = []
    for i, j, k in faces:
        ij, jk, ki = between(i, j), between(j, k), between(k, i)
        split += [(i, ij, ki), (j, jk, ij), (k, ki, jk), (ij, jk, ki)]
    return split


def torus(nu: int, nv: int, noise: float, seed: int, at=(0.0, 0.0, 0.0), *, tube=0.4, upright=False) -> Body:
    """2 * nu * nv triangles, radii 1 and tube (which is noisy), about z, or about x when upright."""
    rng = np.random.default_rng(seed)
    u, v = np.meshgrid(np.arange(nu) * 2 * np.pi / nu, np.arange(nv) * 2 * np.pi / nv, indexing="ij")
    r = tube * (1 + noise * rng.uniform(-1, 1, (nu, nv)))
    points = np.stack(
        [(1 + r * np.cos(v)) * np.cos(u), (1 + r * np.cos(v)) * np.sin(u), r * np.sin(v)], axis=-1
    )
    points = points.reshape(-1, 3)
    if upright:
        points = points[:, [2, 0, 1]]

    def index(i, j):
        return (i % nu) * nv + j % nv

    faces = []
    for i in range(nu):
        for j in range(nv):
            a, b, c, d = index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)
            faces += [[a, b, c], [a, c, d]]
    return Body(on_grid(points + np.array(at)).tolist(), [], faces)


def is_closed(body: Body) -> bool:
    """Every directed edge once, and its reverse too."""
    directed = [(f[k], f[(k + 1) % 3]) for f in body.f for k in range(3)]
    return len(set(directed)) == len(directed) and {(j, i) for i, j in directed} == set(directed)


# ----------------------------------------------------------------------- small random and degenerate scenes


KINDS = ["tetrahedron", "triangle", "two triangles", "fan", "edges", "points", "box", "needle", "duplicates"]
_TETRAHEDRON = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]


def lattice_body(kind: str, p: list) -> Body:
    """A small body on six lattice points: coplanar, parallel, coincident and touching parts abound."""
    if kind == "tetrahedron":
        return outward(Body(p[:4], [], _TETRAHEDRON))
    if kind == "triangle":
        return Body(p[:3], [], [[0, 1, 2]])
    if kind == "two triangles":
        return Body(p, [], [[0, 1, 2], [3, 4, 5]])
    if kind == "fan":
        return Body(p[:5], [], [[0, 1, 2], [0, 2, 3], [0, 3, 4]])
    if kind == "edges":
        return Body(p, [[0, 1], [1, 2], [3, 4], [4, 5]], [])
    if kind == "points":
        return Body(p[:3], [], [])
    if kind == "box":
        return box([1 + abs(x) % 2 for x in p[0]], p[1])
    if kind == "needle":
        thin = [
            [x + 2.0**-20 * d for x, d in zip(end, off, strict=True)]
            for end, off in ((p[0], p[2]), (p[1], p[3]))
        ]
        return Body([p[0], thin[0], p[1], thin[1]], [], _TETRAHEDRON)
    assert kind == "duplicates"
    return Body(p[:3] + p[:3], [], [[0, 1, 2], [3, 5, 4]])


def lattice_scene(seed: int, rotating: bool, reach: int = 2) -> Scene:
    """Two small bodies within a few units of each other and a motion with small integer entries."""
    rng = np.random.default_rng(seed)

    def small(shape, most=reach):
        return rng.integers(-most, most + 1, shape).tolist()

    a, b = (lattice_body(str(rng.choice(KINDS)), small((6, 3))) for _ in range(2))
    apart = [3 * int(k) for k in small(3, 1)] if rng.integers(4) else [0, 0, 0]
    b = moved(b, apart)
    if not rotating:
        until = [None, 1, Fraction(1, 3), 5][rng.integers(4)]
        towards = [x / 2 + d for x, d in zip(apart, small(3, 1), strict=True)]
        return Scene(a, b, translation=tuple(towards if rng.integers(4) else small(3)), until=until)
    axis = small(3, 1)
    if not any(axis):
        axis = [0, 0, 1]
    totals = [{"turns": Fraction(k, 4)} for k in (1, 2, 3, 4, -4)] + [{"radians": k} for k in (1, -3, 7)]
    return Scene(a, b, rotation={"axis": axis, "point": small(3), **totals[rng.integers(len(totals))]})


def moved(body: Body, by) -> Body:
    return Body([[x + d for x, d in zip(p, by, strict=True)] for p in body.v], body.e, body.f)
