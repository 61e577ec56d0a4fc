"""Random choices that the scenes of polyhedra are made of: bodies, directions, places, times."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction as F
from random import Random

from . import shapes
from .brute import Mesh, Point, plus, times
from .laws import QUATERNIONS, rotation

Maker = Callable[[Random], Mesh]


def solid(rng: Random) -> Mesh:
    n = rng.randint(1, 4)
    return rng.choice([
        lambda: shapes.box(n, rng.randint(1, 4), 2),
        lambda: shapes.box(2, 2, n, polygons=True),
        lambda: shapes.random_tetrahedron(rng),
        lambda: shapes.tetrahedron([(F(0), F(0), F(0)), (F(n), F(0), F(0)), (F(0), F(2), F(0)), (F(0), F(0), F(3))]),
        lambda: shapes.octahedron(n, 2, rng.randint(1, 3)),
    ])()


def notched(rng: Random) -> Mesh:
    return rng.choice([
        lambda: shapes.corner_prism(rng.randint(1, 2), rng.randint(1, 3)),
        lambda: shapes.frame(4, rng.choice((1, 2, 3)), rng.randint(1, 3)),
    ])()


def hollow(rng: Random) -> Mesh:
    core = rng.choice((0, 2))
    return shapes.hollow(rng.choice((8, 10)), rng.choice((1, 2)), core)


def open_mesh(rng: Random) -> Mesh:
    return rng.choice([
        lambda: shapes.sheet(rng.randint(1, 4), rng.randint(1, 4), rng.choice((0, 0, 1, -1))),
        lambda: shapes.soup(2, rng.randint(1, 3), 2),
        lambda: shapes.wires(shapes.random_points(rng, 4), [(0, 1), (1, 2), (3, 0)]),
        lambda: shapes.wires([(F(0), F(0), F(0)), (F(4), F(0), F(0)), (F(4), F(2), F(0))], [(0, 1), (1, 2)]),
        lambda: shapes.cloud(shapes.random_points(rng, rng.randint(1, 5))),
        lambda: shapes.cloud([(F(1), F(1), F(1))] * 2),
        lambda: shapes.sheet(2, 2),
    ])()


def thin(rng: Random) -> Mesh:
    small = F(1, 2 ** rng.choice((10, 20, 40, 60)))
    return rng.choice([
        lambda: shapes.needle(rng.choice((10, 1000)), small),
        lambda: shapes.ridge(2, 2, 1, small),
        lambda: shapes.ridge(4, 2, 1, F(0)),
        lambda: shapes.ridge(2, 4, 1, -small),
        lambda: shapes.ridge(2, 2, 2, F(1, 3 * 2**60)),
    ])()


def small(rng: Random) -> Mesh:
    """Something of few pieces, for the dearer oracles."""
    return rng.choice([
        lambda: shapes.random_tetrahedron(rng), lambda: shapes.box(1, 2, 2), lambda: shapes.sheet(3, 2, 1),
    ])()


def direction(rng: Random, most: int = 4) -> Point:
    """Along an axis, in a plane of axes or anyhow; not zero."""
    while True:
        v = [F(rng.choice((-1, 1)) * rng.randint(1, most)) for _ in range(3)]
        for k in rng.sample(range(3), rng.choice((2, 2, 1, 0))):
            v[k] = F(0)
        if any(v):
            return tuple(v)  # type: ignore[return-value]


def off(rng: Random) -> F:
    """How far features miss one another: mostly not at all."""
    kind = rng.random()
    if kind < 0.6:
        return F(0)
    if kind < 0.85:
        return F(rng.choice((-1, 1)), 2 ** rng.choice((10, 20, 30, 40, 50)))
    return F(rng.choice((-2, -1, 1, 2)), rng.choice((1, 2, 4)))


def spot(rng: Random, mesh: Mesh) -> Point:
    """A point of the surface: a vertex, the middle of an edge, or a point within a piece."""
    piece = rng.choice(mesh.pieces)
    corners = [mesh.vertices[i] for i in rng.sample(piece, len(piece))]
    weights = rng.choice(((1, 0, 0), (1, 0, 0), (F(1, 2), F(1, 2), 0), (F(1, 4), F(1, 4), F(1, 2))))[: len(corners)]
    total = sum(weights) or 1
    if not any(weights):
        weights = (1, *weights[1:])
    spot: Point = (F(0), F(0), F(0))
    for w, p in zip(weights, corners, strict=True):
        spot = plus(spot, times(F(w) / total, p))
    return spot


def random_turn(rng: Random, share: float) -> Callable[[Point], Point]:
    """A rational rotation for a share of the scenes, else none or a swap of axes."""
    if rng.random() < share:
        m = rotation(rng.choice(QUATERNIONS[:6]))
    elif rng.random() < 0.3:
        m = rotation(rng.choice(((1, 1, 0, 0), (1, 0, 0, 1), (1, 1, 1, 1), (0, 1, 0, 0))))
    else:
        return lambda p: p
    return lambda p: tuple(sum(m[i][j] * p[j] for j in range(3)) for i in range(3))  # type: ignore[return-value]


SPANS: tuple[tuple[F, F], ...] = (
    (F(0), F(1)), (F(0), F(1)), (F(0), F(1)), (F(0), F(1, 2)), (F(1, 4), F(1)), (F(-1), F(1)), (F(0), F(3)),
    (F(1, 2), F(5, 8)), (F(-4), F(-2)),
)


def when(rng: Random, span: tuple[F, F]) -> F:
    """A time for the features to meet: within, at an end, or outside of the span."""
    first, last = span
    part = rng.choice(("0", "1", "1", "1/2", "1/2", "1/4", "3/8", "1/3", "2/3", "5/7", "9/8", "-1/8"))
    return first + F(part) * (last - first)


def span_text(rng: Random, first: F, last: F | None) -> str:
    if (first, last) == (0, 1) and rng.random() < 0.5:
        return "None"
    end = "float('inf')" if last is None else repr(float(last))
    return f"({float(first)!r}, {end})"
