"""Shapes of which scenes of ruled surfaces are made: flat pieces, graphs over rectangles, tips, nets, solids."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction as F
from math import comb
from random import Random

import numpy as np

from .exact_numbers import (
    Polynomial,
    Vector,
    add,
    cross,
    dot,
    polynomial_sum,
    scaled,
    sub,
    times,
    vector,
)
from .ruled_bodies import Curve, Frame, Mesh, Piece, Solid, passage, straight

RANGES_U = ((F(0), F(1)), (F(0), F(1)), (F(-1), F(1)), (F(2), F(5)), (F(-3), F(-1)), (F(0), F(1, 3)))
RANGES_S = ((F(0), F(1)), (F(0), F(1)), (F(0), F(1)), (F(-3), F(3)), (F(1), F(2)), (F(-1000), F(1000)))


def blended(p: Vector, q: Vector, k: F) -> Vector:
    return add(scaled(p, 1 - k), scaled(q, k))


def four_corners(rng: Random, p00: Vector, p10: Vector, p01: Vector, p11: Vector, most: int = 3) -> Piece:
    """The bilinear piece of four corners, p_ij at end i of u and end j of s, in random parameters.

    All of a flat one is its convex quadrangle p00 p10 p11 p01, which may be a triangle.
    """
    u, s = rng.choice(RANGES_U), rng.choice(RANGES_S)
    at0, at1 = -s[0] / (s[1] - s[0]), (1 - s[0]) / (s[1] - s[0])
    first, second = (straight(blended(p00, p01, k), blended(p10, p11, k)) for k in (at0, at1))
    through = passage(rng, u, most)
    other = passage(rng, u, most) if s == (0, 1) and rng.random() < 0.3 and _flat(p00, p10, p01, p11) else through
    return Piece(first.along(*through), second.along(*other), u, s, as_lists=rng.random() < 0.4)


def _flat(p00: Vector, p10: Vector, p01: Vector, p11: Vector) -> bool:
    return dot(cross(sub(p10, p00), sub(p01, p00)), sub(p11, p00)) == 0


def flat_corners(rng: Random, size: int = 3) -> tuple[Vector, Vector, Vector, Vector]:
    """p00, p10, p01, p11 of a convex quadrangle or triangle in one plane, on a small lattice."""
    def lattice() -> Vector:
        return vector([rng.randint(-size, size) for _ in range(3)])
    while True:
        o, e, f = lattice(), lattice(), lattice()
        if any(cross(e, f)):
            break
    shape = rng.random()
    if shape < 0.15:
        return o, o, add(o, e), add(o, f)
    if shape < 0.3:
        return add(o, e), o, add(o, f), o
    if shape < 0.4:
        return o, add(o, e), add(o, f), add(o, f)
    k, m = rng.choice(((F(1), F(1)), (F(1), F(1)), (F(2), F(1)), (F(1, 2), F(1)), (F(1), F(1, 3)), (F(2), F(2))))
    return o, add(o, e), add(o, f), add(o, add(scaled(e, k), scaled(f, m)))


@dataclass(frozen=True)
class Convex:
    """A convex set for separating axes: corners, directions of its edges, normals of its faces."""

    corners: tuple[Vector, ...]
    edges: tuple[Vector, ...]
    normals: tuple[Vector, ...]
    flat: bool

    def extent(self, n: Vector) -> tuple[F, F]:
        values = [dot(n, c) for c in self.corners]
        return min(values), max(values)


def flat_convex(corners: tuple[Vector, Vector, Vector, Vector]) -> Convex:
    p00, p10, p01, p11 = corners
    ring = [p00, p10, p11, p01]
    around = [p for i, p in enumerate(ring) if p != ring[i - 1]]
    edges = tuple(sub(p, around[i - 1]) for i, p in enumerate(around))
    normal = next(n for i, e in enumerate(edges) if any(n := cross(e, edges[i - 1])))
    return Convex(tuple(around), edges, (normal,), True)


def axes(p: Convex, q: Convex) -> list[Vector]:
    """Directions that separate two convex sets, if any does; complete, flat sets in one plane included."""
    out = [*p.normals, *q.normals]
    out += [cross(e, f) for e in p.edges for f in q.edges]
    for body in (p, q):
        if body.flat:
            out += [cross(e, body.normals[0]) for e in body.edges]
    return [n for n in out if any(n)]


def meeting(p: Convex, q: Convex, velocity: Vector, domain: tuple[F, F]) -> tuple[F, F] | None:
    """The times in the domain at which p + t velocity meets q."""
    lo, hi = domain
    for n in axes(p, q):
        (a0, a1), (b0, b1), speed = p.extent(n), q.extent(n), dot(n, velocity)
        if speed == 0:
            if a1 < b0 or a0 > b1:
                return None
            continue
        ends = sorted(((b0 - a1) / speed, (b1 - a0) / speed))
        lo, hi = max(lo, ends[0]), min(hi, ends[1])
    return (lo, hi) if lo <= hi else None


def initial_of_convex(p: Convex, q: Convex, at: Vector) -> str:
    """What p + at, flat, shares with the convex solid q that it meets."""
    strict = all(p.extent(n)[1] + dot(n, at) > q.extent(n)[0] and p.extent(n)[0] + dot(n, at) < q.extent(n)[1]
                 for n in axes(p, q))
    if not strict:
        return "touching"
    within = all(p.extent(n)[1] + dot(n, at) < q.extent(n)[1] and p.extent(n)[0] + dot(n, at) > q.extent(n)[0]
                 for n in q.normals)
    return "containment" if within else "overlapping"


def convex_solid(rng: Random) -> tuple[Convex, Mesh | Solid]:
    """A box, tetrahedron or octahedron: as a mesh or, boxes, as a solid of planes."""
    what = rng.randrange(4)
    if what < 2:
        size = [F(rng.randint(1, 4)) for _ in range(3)]
        half = [c / 2 for c in size]
        corners = tuple(vector([half[0] * i, half[1] * j, half[2] * k])
                        for i in (-1, 1) for j in (-1, 1) for k in (-1, 1))
        units = vector([1, 0, 0]), vector([0, 1, 0]), vector([0, 0, 1])
        convex = Convex(corners, units, units, False)
        if what == 0:
            h = np.array([float(c) for c in half])
            return convex, Solid(f"fc.box(({', '.join(str(c) for c in size)}))",
                                 lambda x: float(np.max(np.abs(x) - h)), float(max(size)))
        faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
        return convex, Mesh(corners, faces, True)
    if what == 2:
        while True:
            corners = tuple(vector([rng.randint(-3, 3) for _ in range(3)]) for _ in range(4))
            volume = dot(cross(sub(corners[1], corners[0]), sub(corners[2], corners[0])), sub(corners[3], corners[0]))
            if volume:
                break
        faces = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
    else:
        r = rng.randint(1, 3)
        corners = tuple(vector(x) for x in ((r, 0, 0), (-r, 0, 0), (0, r, 0), (0, -r, 0), (0, 0, r), (0, 0, -r)))
        faces = ((0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5))
    edges, normals = [], []
    for a, b, c in faces:
        edges += [sub(corners[b], corners[a]), sub(corners[c], corners[b]), sub(corners[a], corners[c])]
        normals.append(cross(edges[-3], edges[-2]))
    distinct = [e for i, e in enumerate(edges) if not any(not any(cross(e, f)) for f in edges[:i])]
    if what == 2 and volume < 0:
        faces = tuple(f[::-1] for f in faces)
    return Convex(corners, tuple(distinct), tuple(normals), False), Mesh(corners, faces, True)


# --------------------------------------------------------------------------------------------------------- graphs


def graph(
    rng: Random, rulings: str, x: tuple[F, F], y: tuple[F, F], base: Sequence[F],
    bump: tuple[Polynomial, Polynomial], whole: bool = False,
) -> Piece:
    """z = b0 + b1 x + b2 y + b3 x y + top/bottom, a function of y or x, over a rectangle; rulings along x or y.

    bump: top and bottom of the function, of x where rulings run along y.  whole: rulings without end.
    """
    if rulings == "x":
        turned = graph(rng, "y", y, x, (base[0], base[2], base[1], base[3]), bump, whole)
        swap = Frame(((F(0), F(1), F(0)), (F(1), F(0), F(0)), (F(0), F(0), F(1))))
        return Piece(turned.first.mapped(swap), turned.second.mapped(swap), turned.u, turned.s,
                     as_lists=turned.as_lists)
    s = rng.choice(RANGES_S) if y[0] < y[1] else (F(0), F(1))
    top, bottom = bump
    curves = []
    for k in (F(0), F(1)):
        at = y[0] + (k - s[0]) / (s[1] - s[0]) * (y[1] - y[0])
        z = polynomial_sum(times([base[0] + base[2] * at, base[1] + base[3] * at], bottom), top)
        curves.append(Curve((times([F(0), F(1)], bottom), times([at], bottom), z), bottom))
    through = ([F(0), F(1)], [F(1)])
    u = x
    if rng.random() < 0.4:
        u = rng.choice(RANGES_U)
        t, b = passage(rng, u, 1 if len(top) + len(bottom) > 4 else 2)
        through = (polynomial_sum([x[0] * c for c in b], [(x[1] - x[0]) * c for c in t]), b)
    first, second = (c.along(*through) for c in curves)
    return Piece(first, second, u, None if whole else s, as_lists=rng.random() < 0.3)


def bump(rng: Random, at: F, over: tuple[F, F], wide: bool = True) -> tuple[Polynomial, Polynomial, F]:
    """A function on a range, 0 at `at` and nowhere less, as top and bottom; and its greatest value there."""
    k = rng.choice((F(1), F(1), F(1, 2), F(3), F(1, 1000)))
    square = [at * at, -2 * at, F(1)]
    choices = ["square", "square", "fourth", "ratio", "none"]
    if at == over[0] or at == over[1]:
        choices += ["line", "line", "cube"]
    what = rng.choice(choices if wide else ["none"] + [c for c in choices if c == "line"])
    far = max(over[1] - at, at - over[0])
    if what == "none":
        return [F(0)], [F(1)], F(0)
    if what == "line":
        sign = 1 if at == over[0] else -1
        return [-at * sign * k, sign * k], [F(1)], k * far
    if what == "cube":
        sign = 1 if at == over[0] else -1
        return [sign * k * c for c in times(square, [-at, F(1)])], [F(1)], k * far**3
    if what == "square":
        return [k * c for c in square], [F(1)], k * far**2
    if what == "fourth":
        return [k * c for c in times(square, square)], [F(1)], k * far**4
    return [k * c for c in square], polynomial_sum([F(1)], square), k * far**2 / (1 + far**2)


# ----------------------------------------------------------------------------------------------------------- tips

RING = ([F(1), F(0), F(-1)], [F(0), F(2)], [F(1), F(0), F(1)])  # cosine, sine, and their denominator


def circle(centre: Vector, e: Vector, f: Vector) -> Curve:
    """centre + e cosine + f sine."""
    rows = []
    for i in range(3):
        row = polynomial_sum([e[i] * c for c in RING[0]], [f[i] * c for c in RING[1]])
        rows.append(polynomial_sum(row, [centre[i] * c for c in RING[2]]))
    return Curve((rows[0], rows[1], rows[2]), RING[2])


def pointing_down(rng: Random, sharp: bool = False) -> Piece:
    """A piece in z >= 0 that holds the origin."""
    n = [F(rng.randint(1, 3)) for _ in range(6)]
    o = vector([0, 0, 0])
    lists = rng.random() < 0.3
    what = rng.choice(("cone", "half cone", "corner", "saddle", "fan") if sharp
                      else ("cone", "half cone", "corner", "saddle", "fan", "ridge", "pipe", "edge", "plate", "rim"))
    if what in ("cone", "half cone"):
        rim = circle(vector([0, 0, n[0]]), vector([n[1], 0, 0]), vector([0, n[2], 0]))
        tip = straight(o, o)
        u = None if what == "cone" else (F(-1), F(1))
        if rng.random() < 0.5:
            return Piece(tip, rim, u, as_lists=lists)
        return Piece(rim, tip, u, as_lists=lists)
    if what == "corner":
        e, f = vector([n[0], -n[1], n[2]]), vector([-n[3], n[4], n[5]])
        if not any(cross(e, f)):
            f = add(f, vector([0, 1, 0]))
        return four_corners(rng, *rng.choice(((o, e, f, add(e, f)), (o, o, e, f), (e, o, f, f))))
    if what == "saddle":
        return four_corners(rng, o, vector([n[0], 0, n[1]]), vector([0, n[2], n[3]]),
                            vector([n[0], n[2], n[1] + n[3] + n[4]]))
    if what == "fan":
        first = Curve(([F(0), F(0), n[0]], [F(0), n[1]], [F(0), F(0), n[2]]))  # its own least point at u = 0
        return Piece(first, straight(vector([n[3], 0, n[4]]), vector([n[3], n[5], n[4]])), (F(-1), F(1)),
                     as_lists=lists)
    if what == "ridge":
        return graph(rng, rng.choice("xy"), (-n[0], n[1]), (-n[2], n[3]), [F(0)] * 4,
                     ([F(0), F(0), n[4]], [F(1)]))
    if what == "pipe":
        centre = vector([0, 0, n[0]])
        ring = circle(vector([0, -n[1], n[0]]), vector([n[0], 0, 0]), vector([0, 0, n[0]]))
        other = circle(add(centre, vector([0, n[2], 0])), vector([n[0], 0, 0]), vector([0, 0, n[0]]))
        return Piece(ring, other, None, as_lists=lists)
    if what == "edge":
        return four_corners(rng, vector([-n[0], 0, 0]), vector([n[1], 0, 0]), vector([-n[0], n[2], n[3]]),
                            vector([n[1], n[2], n[3]]))
    if what == "plate":
        x = (-n[0], F(0)) if rng.random() < 0.3 else (-n[0], n[1])
        y = (F(0), n[2]) if rng.random() < 0.3 else (-n[3], n[2])
        return four_corners(rng, *(vector([a, b, 0]) for b in y for a in x))
    rim = circle(vector([0, n[0], 0]), vector([n[0], 0, 0]), vector([0, n[0], 0]))
    return Piece(rim, straight(vector([0, n[0], n[1]]), vector([0, n[0], n[1]])), None, as_lists=lists)


MIRRORED = Frame(((F(0), F(1), F(0)), (F(1), F(0), F(0)), (F(0), F(0), F(-1))))
QUARTER = Frame(((F(0), F(-1), F(0)), (F(1), F(0), F(0)), (F(0), F(0), F(1))))


def top_solid(rng: Random) -> Solid | Mesh:
    """A solid in z <= 0 that holds the origin."""
    n = [F(rng.randint(1, 3)) for _ in range(4)]
    what = rng.choice(("half-space", "box", "corner of box", "sphere", "ellipsoid", "upright", "lying", "cone",
                       "octahedron", "slab", "triangle", "ring"))

    def shifted(text: str, outside: object, extent: F, down: Vector) -> Solid:
        return Solid(text, outside, float(extent), Frame(offset=down))  # type: ignore[arg-type]

    if what == "half-space":
        return Solid("fc.half_space((0, 0, 1), 0)", lambda x: float(x[2]), 1.0)
    if what in ("box", "corner of box"):
        h = np.array([float(c) / 2 for c in n[:3]])
        down = [F(0), F(0), -n[2] / 2]
        if what == "corner of box":
            down[0] = n[0] / 2
            down[1] = rng.choice((n[1] / 2, F(0)))
        return shifted(f"fc.box(({n[0]}, {n[1]}, {n[2]}))", lambda x: float(np.max(np.abs(x) - h)), max(n),
                       vector(down))
    if what == "sphere":
        r = float(n[0])
        return shifted(f"fc.sphere({n[0]})", lambda x: float(np.linalg.norm(x)) - r, n[0], vector([0, 0, -n[0]]))
    if what == "ellipsoid":
        r3 = np.array([float(c) for c in n[:3]])
        return shifted(f"fc.ellipsoid(({n[0]}, {n[1]}, {n[2]}))",
                       lambda x: (float(np.linalg.norm(x / r3)) - 1) * float(r3.min()), max(n), vector([0, 0, -n[2]]))
    if what == "upright":
        r, h1 = float(n[0]), float(n[1]) / 2
        side = rng.choice((F(0), F(0), n[0], -n[0] / 2))
        return shifted(f"fc.cylinder({n[0]}, {n[1]})",
                       lambda x: max(float(np.hypot(x[0], x[1])) - r, abs(float(x[2])) - h1), max(n),
                       vector([side, 0, -n[1] / 2]))
    if what == "lying":
        r, h1 = float(n[0]), float(n[1]) / 2
        lie = Frame(((F(1), F(0), F(0)), (F(0), F(0), F(-1)), (F(0), F(1), F(0))),
                    vector([0, rng.choice((F(0), n[1] / 2)), -n[0]]))
        return Solid(f"fc.cylinder({n[0]}, {n[1]})",
                     lambda x: max(float(np.hypot(x[0], x[1])) - r, abs(float(x[2])) - h1), float(max(n)), lie)
    if what == "cone":
        r, h1 = float(n[0]), float(n[1])
        return shifted(f"fc.cone({n[0]}, {n[1]})",
                       lambda x: max(float(np.hypot(x[0], x[1])) - r * (1 - float(x[2]) / h1), -float(x[2])),
                       max(n), vector([0, 0, -n[1]]))
    if what == "ring":  # a tube that stands, the origin on its upper face
        r, h1 = float(n[0]), float(n[1]) / 2
        return shifted(f"(fc.cylinder({2 * n[0]}, {n[1]}) - fc.cylinder({n[0]}, {2 * n[1]}))",
                       lambda x: max(float(np.hypot(x[0], x[1])) - 2 * r, r - float(np.hypot(x[0], x[1])),
                                     abs(float(x[2])) - h1),
                       2 * max(n), vector([rng.choice((n[0] * 3 / 2, n[0], 2 * n[0])), 0, -n[1] / 2]))
    if what == "octahedron":
        r = n[0]
        corners = tuple(vector(x) for x in (
            (r, 0, -r), (-r, 0, -r), (0, r, -r), (0, -r, -r), (0, 0, 0), (0, 0, -2 * r)))
        faces = ((0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5))
        return Mesh(corners, faces, True)
    if what == "slab":
        x, y = (-n[0], n[1]), rng.choice(((-n[2], n[3]), (F(0), n[3])))
        corners = tuple(vector([a, b, c]) for a in x for b in y for c in (-n[2], F(0)))
        faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
        return Mesh(corners, faces, True)
    corners = rng.choice((
        (vector([0, 0, 0]), vector([n[0], 0, -n[1]]), vector([0, n[2], -n[3]])),
        (vector([-n[0], 0, 0]), vector([n[1], 0, 0]), vector([0, n[2], -n[3]])),
        (vector([-n[0], -n[1], 0]), vector([n[0], -n[1], 0]), vector([0, n[2], 0])),
        (vector([-n[0], -n[1], 0]), vector([n[0], n[1], 0]), vector([n[2], -n[3], 0])),
    ))
    while not any(cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]))):
        corners = (*corners[:2], add(corners[2], vector([0, 0, -1])))
    return Mesh(corners, ((0, 1, 2),))


# ----------------------------------------------------------------------------------------------------------- nets


def bezier(points: Sequence[Vector]) -> Curve:
    n = len(points) - 1
    rows = []
    for i in range(3):
        row = [F(0)] * (n + 1)
        for k in range(n + 1):
            for j in range(k + 1):
                row[k] += (-1) ** (k - j) * comb(n, k) * comb(k, j) * points[j][i]
        rows.append(row)
    return Curve((rows[0], rows[1], rows[2]))
