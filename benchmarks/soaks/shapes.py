"""Small polyhedra with exact vertices, and their text."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction as F
from itertools import product
from random import Random
from typing import Any

from .brute import Mesh, Point, cross, dot, minus

HEXAHEDRON = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


def fan(polygon: Sequence[int]) -> list[tuple[int, int, int]]:
    """The triangles of a convex polygon."""
    return [(polygon[0], polygon[i], polygon[i + 1]) for i in range(1, len(polygon) - 1)]


def _part(corners: Sequence[int]) -> tuple[tuple[int, ...], tuple[tuple[int, ...], ...]]:
    return tuple(corners), tuple(t for q in HEXAHEDRON for t in fan([corners[i] for i in q]))


def _polygons(vertices: Any, faces: Sequence[Any], convex: Sequence[Sequence[Sequence[int]]], parts: Any) -> Mesh:
    """A closed body from polygons, each given as convex polygons too."""
    pieces = [(t, n) for n, polygons in enumerate(convex) for polygon in polygons for t in fan(polygon)]
    owners = tuple(n for _, n in pieces)
    return Mesh(tuple(vertices), tuple(t for t, _ in pieces), tuple(faces), None, True, tuple(parts), owners)


def _corners(x: int, y: int, z: int, at: tuple[int, int, int] = (0, 0, 0)) -> list[Point]:
    ring = ((0, 0), (x, 0), (x, y), (0, y))
    return [(F(at[0] + p), F(at[1] + q), F(at[2] + h)) for h in (0, z) for p, q in ring]


def box(x: int, y: int, z: int, *, polygons: bool = False) -> Mesh:
    corners = _corners(x, y, z)
    if polygons:
        return _polygons(corners, HEXAHEDRON, [[q] for q in HEXAHEDRON], [_part(range(8))])
    triangles = tuple(t for q in HEXAHEDRON for t in fan(q))
    return Mesh(tuple(corners), triangles, triangles, None, True, (_part(range(8)),))


def soup(x: int, y: int, z: int) -> Mesh:
    """The surface of a box of triangles that share no vertices: not closed, so no solid."""
    solid = box(x, y, z)
    vertices = tuple(solid.vertices[i] for t in solid.pieces for i in t)
    triangles = tuple((3 * n, 3 * n + 1, 3 * n + 2) for n in range(len(solid.pieces)))
    return Mesh(vertices, triangles, triangles)


def tetrahedron(points: Sequence[Point]) -> Mesh:
    triangles = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
    return Mesh(tuple(points), triangles, triangles, None, True, (((0, 1, 2, 3), triangles),))


def random_tetrahedron(rng: Random, size: int = 4) -> Mesh:
    while True:
        points = [tuple(F(rng.randint(-size, size)) for _ in range(3)) for _ in range(4)]
        p, q, r, s = points
        if dot(minus(q, p), cross(minus(r, p), minus(s, p))):
            return tetrahedron(points)


def needle(length: int, width: F) -> Mesh:
    """A tetrahedron of which all triangles are slivers."""
    zero, one = F(0), F(1)
    return tetrahedron([(zero, zero, zero), (F(length), zero, zero), (F(length, 2), width, zero),
                        (F(length, 3), width * one / 3, width)])


def octahedron(x: int, y: int, z: int) -> Mesh:
    zero = F(0)
    vertices = ((F(x), zero, zero), (zero, F(y), zero), (F(-x), zero, zero), (zero, F(-y), zero),
                (zero, zero, F(z)), (zero, zero, F(-z)))
    ring = ((0, 1), (1, 2), (2, 3), (3, 0))
    triangles = tuple((i, j, 4) for i, j in ring) + tuple((j, i, 5) for i, j in ring)
    return Mesh(vertices, triangles, triangles, None, True, ((tuple(range(6)), triangles),))


def ridge(x: int, y: int, z: int, rise: F) -> Mesh:
    """A box with a vertex in the middle of its top, `rise` above it (below: not convex)."""
    corners = [*_corners(x, y, z), (F(x, 2), F(y, 2), z + rise)]
    triangles = tuple(t for q in HEXAHEDRON[:1] + HEXAHEDRON[2:] for t in fan(q))
    triangles += ((4, 5, 8), (5, 6, 8), (6, 7, 8), (7, 4, 8))
    parts = ((tuple(range(9)), triangles),) if rise > 0 else ()
    return Mesh(tuple(corners), triangles, triangles, None, True, parts)


def corner_prism(x: int, z: int) -> Mesh:
    """A prism over an L, its ends one polygon each."""
    ring = [(0, 0), (2 * x, 0), (2 * x, x), (x, x), (x, 2 * x), (0, 2 * x)]
    vertices = [(F(p), F(q), F(h)) for h in (0, z) for p, q in ring]
    halves = ((0, 1, 2, 3), (0, 3, 4, 5))
    faces: list[Any] = [tuple(range(5, -1, -1)), tuple(range(6, 12))]
    convex: list[Any] = [[h[::-1] for h in halves], [[i + 6 for i in h] for h in halves]]
    for i in range(6):
        side = (i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6)
        faces.append(side)
        convex.append([side])
    return _polygons(vertices, faces, convex, [_part([*h, *(i + 6 for i in h)]) for h in halves])


def frame(x: int, hole: int, z: int) -> Mesh:
    """A square plate with a square hole: its ends are polygons with a hole."""
    outer = ((-x, -x), (x, -x), (x, x), (-x, x))
    inner = tuple((hole * p // x, hole * q // x) for p, q in outer)
    vertices = [(F(p), F(q), F(h)) for h in (0, z) for p, q in (*outer, *inner)]
    bottom, top = ((3, 2, 1, 0), (4, 5, 6, 7)), ((8, 9, 10, 11), (15, 14, 13, 12))
    quads = [(i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4) for i in range(4)]
    faces: list[Any] = [bottom, top]
    convex: list[Any] = [[q[::-1] for q in quads], [[i + 8 for i in q] for q in quads]]
    for base, way in ((0, 1), (4, -1)):
        for i in range(4):
            j = (i + 1) % 4
            side = (base + i, base + j, base + j + 8, base + i + 8)[::way]
            faces.append(side)
            convex.append([side])
    return _polygons(vertices, faces, convex, [_part([*q, *(i + 8 for i in q)]) for q in quads])


def hollow(size: int, wall: int, core: int = 0) -> Mesh:
    """A cube with a cubic void, in which a solid cube lies loose where `core` is not 0."""
    shells = [(0, size), (wall, size - 2 * wall)]
    if core:
        shells.append((wall + 1, core))
    vertices = [p for at, s in shells for p in _corners(s, s, s, (at, at, at))]
    triangles = []
    for n in range(len(shells)):
        for q in HEXAHEDRON:
            triangles += fan([8 * n + i for i in (q if n != 1 else q[::-1])])
    parts = [_part([*q, *(8 + i for i in q)]) for q in HEXAHEDRON]
    if core:
        parts.append(_part(range(16, 24)))
    faces = tuple(triangles)
    return Mesh(tuple(vertices), faces, faces, None, True, tuple(parts))


def sheet(x: int, y: int, bend: int = 0) -> Mesh:
    """Two triangles, folded along their diagonal by `bend`."""
    vertices = ((F(0), F(0), F(0)), (F(x), F(0), F(bend)), (F(x), F(y), F(0)), (F(0), F(y), F(bend)))
    return Mesh(vertices, ((0, 1, 2), (0, 2, 3)), ((0, 1, 2), (0, 2, 3)))


def wires(points: Sequence[Point], edges: Sequence[tuple[int, int]]) -> Mesh:
    return Mesh(tuple(points), tuple(edges), (), tuple(edges))


def cloud(points: Sequence[Point]) -> Mesh:
    return Mesh(tuple(points), tuple((i,) for i in range(len(points))), ())


def random_points(rng: Random, count: int, size: int = 4) -> list[Point]:
    return [tuple(F(rng.randint(-size, size)) for _ in range(3)) for _ in range(count)]  # type: ignore[misc]


# ---- text ----


def number(x: Any, floats: bool = False) -> str:
    """An exact number as text; with `floats` as a double where it is one."""
    x = F(x)
    if floats and x.denominator & (x.denominator - 1) == 0:
        try:
            if F(float(x)) == x:
                return repr(float(x))
        except OverflowError:
            pass
    if x.denominator == 1:
        return str(x.numerator)
    power = (x.denominator & -x.denominator).bit_length() - 1
    rest = x.denominator >> power
    bottom = str(x.denominator) if power < 40 else f"2**{power}" if rest == 1 else f"{rest} * 2**{power}"
    return f"F({x.numerator}, {bottom})"


def vector(v: Sequence[Any], floats: bool = False) -> str:
    return "(" + ", ".join(number(x, floats) for x in v) + ")"


def text(mesh: Mesh, floats: bool = False, name: str | None = None) -> str:
    """The call that makes the body."""
    vertices = "[" + ", ".join(vector(p, floats) for p in mesh.vertices) + "]"

    def listed(face: Any) -> str:
        return "[" + ", ".join(listed(i) if isinstance(i, tuple) else str(i) for i in face) + "]"

    words = [vertices, listed(mesh.faces)]
    if mesh.edges is not None:
        words.append(f"edges={listed(mesh.edges)}")
    if name:
        words.append(f"name={name!r}")
    return f"fc.Polyhedron({', '.join(words)})"


def check(mesh: Mesh) -> None:
    """Every edge of a solid borders two triangles; parts lie in it.  For the tests of the soak."""
    if mesh.solid:
        count: dict[tuple[int, int], int] = {}
        for t in mesh.pieces:
            for i, j in ((0, 1), (1, 2), (2, 0)):
                key = (min(t[i], t[j]), max(t[i], t[j]))
                count[key] = count.get(key, 0) + 1
        assert all(n % 2 == 0 for n in count.values())


def grid(*ranges: Sequence[int]) -> list[Point]:
    return [tuple(F(x) for x in p) for p in product(*ranges)]  # type: ignore[misc]
