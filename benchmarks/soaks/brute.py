"""Exact brute force for polyhedra: every pair of pieces, no filter that decides, no tree.

A piece is the hull of one, two or three points.  Two pieces share a point when the origin lies in the hull of the
differences of their points, and everything here comes down to one question: between which heights does a line
through the origin run inside that hull?  Degenerate cases need no cases of their own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction as F
from itertools import combinations, product
from typing import Any

Point = tuple[Any, Any, Any]


@dataclass(frozen=True)
class Mesh:
    """A polyhedral body: exact vertices and its pieces as index tuples.

    pieces   triangles, bare edges and lone points, which together are its surface.
    faces    what the library is told: polygons by indices, or lists of rings; edges likewise (None: by itself).
    parts    convex solids (indices of their vertices and of their triangles) whose union is a solid body.
    owners   the face that each piece belongs to; None: faces and pieces are the same.
    """

    vertices: tuple[Point, ...]
    pieces: tuple[tuple[int, ...], ...]
    faces: tuple[Any, ...]
    edges: tuple[tuple[int, int], ...] | None = None
    solid: bool = False
    parts: tuple[tuple[tuple[int, ...], tuple[tuple[int, ...], ...]], ...] = ()
    owners: tuple[int, ...] | None = None
    components: tuple[int, ...] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "components", tuple(_components(self.pieces)))

    def mapped(self, change: Any) -> Mesh:
        """The body with every vertex changed."""
        vertices = tuple(change(p) for p in self.vertices)
        return Mesh(vertices, self.pieces, self.faces, self.edges, self.solid, self.parts, self.owners)

    def element(self, kind: str, index: int) -> list[tuple[int, ...]]:
        """The pieces of a vertex, an edge or a face by the numbers that the contract gives them."""
        if kind == "vertex":
            return [(index,)]
        if kind == "edge":
            return [self.numbered_edges()[index]]
        owners = range(len(self.pieces)) if self.owners is None else self.owners
        return [piece for piece, owner in zip(self.pieces, owners, strict=True) if owner == index]

    def numbered_edges(self) -> list[tuple[int, int]]:
        """`edges` as given, then the missing sides of faces, sorted."""
        given = list(self.edges or ())
        known = {(min(e), max(e)) for e in given}
        rings = [ring for face in self.faces for ring in (face if isinstance(face[0], tuple) else (face,))]
        sides = {(min(i, j), max(i, j)) for ring in rings for i, j in zip(ring, (*ring[1:], ring[0]), strict=True)}
        return given + sorted(sides - known)


def _components(pieces: Sequence[tuple[int, ...]]) -> Iterator[int]:
    """A vertex of every connected component of the surface."""
    parent: dict[int, int] = {}

    def root(i: int) -> int:
        parent.setdefault(i, i)
        while parent[i] != i:
            i = parent[i]
        return i

    for piece in pieces:
        for i in piece[1:]:
            parent[root(i)] = root(piece[0])
        root(piece[0])
    yield from sorted({root(i) for i in list(parent)})


# ---- vectors over any ring ----


def minus(p: Point, q: Point) -> Point:
    return p[0] - q[0], p[1] - q[1], p[2] - q[2]


def plus(p: Point, q: Point) -> Point:
    return p[0] + q[0], p[1] + q[1], p[2] + q[2]


def times(k: Any, p: Point) -> Point:
    return k * p[0], k * p[1], k * p[2]


def dot(p: Point, q: Point) -> Any:
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


def cross(p: Point, q: Point) -> Point:
    return p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]


# ---- a line through the hull of differences ----

Flat = tuple[Any, Any, Any]
"""A point as (x, y, height): the line to look along is x = y = 0."""


def _cells(n: int, m: int) -> tuple[tuple[tuple[int, int], ...], tuple[tuple[int, int, int], ...]]:
    """Segments and triangles that cover the boundary of the difference of an n-piece and an m-piece.

    Point (i, j) of the difference has the number i * m + j.
    """
    segments = [(i * m + j, i * m + k) for i in range(n) for j, k in combinations(range(m), 2)]
    segments += [(i * m + j, k * m + j) for j in range(m) for i, k in combinations(range(n), 2)]
    triangles = [tuple(i * m + j for j in t) for i in range(n) for t in combinations(range(m), 3)]
    triangles += [tuple(i * m + j for i in t) for j in range(m) for t in combinations(range(n), 3)]
    for (i, k), (j, h) in product(combinations(range(n), 2), combinations(range(m), 2)):
        triangles += [(i * m + j, k * m + j, k * m + h), (i * m + j, i * m + h, k * m + h)]
        segments += [(i * m + j, k * m + h)]
    return tuple(segments), tuple(triangles)


CELLS = {(n, m): _cells(n, m) for n in (1, 2, 3) for m in (1, 2, 3)}


def heights(a: Sequence[Flat], b: Sequence[Flat]) -> Iterator[tuple[Any, Any]]:
    """Heights (numerator, positive denominator) at which the line x = y = 0 meets the boundary of b - a.

    The least and the greatest of them are the ends of the line within the hull; there are none where it misses.
    """
    points = [(q[0] - p[0], q[1] - p[1], q[2] - p[2]) for p in a for q in b]
    xs, ys = [p[0] for p in points], [p[1] for p in points]
    if not (min(xs) <= 0 <= max(xs) and min(ys) <= 0 <= max(ys)):
        return
    segments, triangles = CELLS[len(a), len(b)]
    for x, y, h in points:
        if x == 0 and y == 0:
            yield h, 1
    turned: dict[tuple[int, int], Any] = {}

    def side(i: int, j: int) -> Any:
        if (i, j) not in turned:
            p, q = points[i], points[j]
            turned[i, j] = p[0] * q[1] - p[1] * q[0]
            turned[j, i] = -turned[i, j]
        return turned[i, j]

    for i, j in segments:
        p, q = points[i], points[j]
        if side(i, j) == 0 and p[0] * q[0] + p[1] * q[1] <= 0:
            k = 0 if p[0] != q[0] else 1
            bottom = q[k] - p[k]
            if bottom == 0:
                continue
            top = q[k] * p[2] - p[k] * q[2]
            yield (top, bottom) if bottom > 0 else (-top, -bottom)
    for i, j, k in triangles:
        u, v, w = side(i, j), side(j, k), side(k, i)
        if (u >= 0 and v >= 0 and w >= 0) or (u <= 0 and v <= 0 and w <= 0):
            bottom = u + v + w
            if bottom == 0:
                continue
            top = v * points[i][2] + w * points[j][2] + u * points[k][2]
            yield (top, bottom) if bottom > 0 else (-top, -bottom)


def share(a: Sequence[Point], b: Sequence[Point]) -> bool:
    """Whether two pieces at rest share a point."""
    below = above = False
    for top, _ in heights(a, b):
        below = below or top <= 0
        above = above or top >= 0
        if below and above:
            return True
    return False


def whole(*points: Point) -> tuple[int, list[tuple[int, int, int]]]:
    """(L, the points times L as integers); points over another ring as they are."""
    if not all(isinstance(x, (int, F)) for p in points for x in p):
        return 1, list(points)
    common = 1
    for p in points:
        for x in p:
            common = math.lcm(common, F(x).denominator)
    return common, [tuple(int(F(x) * common) for x in p) for p in points]  # type: ignore[misc]


def inside(q: Point, vertices: Sequence[Point], pieces: Sequence[tuple[int, ...]]) -> bool:
    """Parity of a ray from q, which lies on none of the triangles."""
    _, (origin, *places) = whole(q, *vertices)
    for n in range(100):
        ray = (1009 + 31 * n, 503 - 57 * n, 207 + 13 * n * n)
        crossings = 0
        for piece in pieces:
            if len(piece) < 3:
                continue
            p, r, s = (minus(places[i], origin) for i in piece)
            u, v, w = dot(ray, cross(p, r)), dot(ray, cross(r, s)), dot(ray, cross(s, p))
            if (u > 0 and v > 0 and w > 0) or (u < 0 and v < 0 and w < 0):
                height = dot(p, cross(r, s))
                crossings += (height > 0) == (u + v + w > 0)
            elif min(u, v, w) < 0 < max(u, v, w):
                continue
            else:
                break  # through an edge, a vertex or along a face
        else:
            return crossings % 2 == 1
    raise AssertionError("every ray is degenerate")


# ---- bodies at rest ----


def touch(a: Mesh, b: Mesh) -> bool:
    """Whether the surfaces share a point."""
    _, places = whole(*a.vertices, *b.vertices)
    first, second = places[: len(a.vertices)], places[len(a.vertices) :]
    return any(share([first[i] for i in p], [second[j] for j in q]) for p in a.pieces for q in b.pieces)


def contained(a: Mesh, b: Mesh) -> bool:
    """Whether a component of one lies inside the other; their surfaces share no point."""
    if b.solid and any(inside(a.vertices[i], b.vertices, b.pieces) for i in a.components):
        return True
    return a.solid and any(inside(b.vertices[j], a.vertices, a.pieces) for j in b.components)


def _convex_overlap(a: Sequence[Point], a_faces: Any, b: Sequence[Point], b_faces: Any, b_edges: Any) -> bool:
    """Whether the interior of a convex solid a meets the hull b (a solid, a triangle, a segment or a point)."""
    normals = [cross(minus(q, p), minus(r, p)) for p, q, r in (*a_faces, *b_faces)]
    directions = {minus(q, p) for p, q, r in a_faces} | {minus(r, q) for p, q, r in a_faces}
    directions |= {minus(p, r) for p, q, r in a_faces}
    normals += [cross(d, minus(q, p)) for d in directions for p, q in b_edges]
    for n in normals:
        if n == (0, 0, 0):
            continue
        first, second = [dot(n, p) for p in a], [dot(n, p) for p in b]
        if max(first) <= min(second) or max(second) <= min(first):
            return False
    return True


def overlapping(a: Mesh, b: Mesh) -> bool | None:
    """Whether an interior point of a solid is shared; None where a solid came without its convex parts, or what is no
    solid may lie between two of them."""
    if (a.solid and not a.parts) or (b.solid and not b.parts):
        return None
    _, places = whole(*a.vertices, *b.vertices)
    sides = ((a, places[: len(a.vertices)]), (b, places[len(a.vertices) :]))

    def hulls(body: Mesh, at: Any) -> Iterator[tuple[Any, Any, Any]]:
        if body.solid:
            for corners, faces in body.parts:
                triangles = [tuple(at[i] for i in f) for f in faces]
                edges = {(at[i], at[j]) for f in faces for i, j in zip(f, (*f[1:], f[0]), strict=True) if i < j}
                yield [at[i] for i in corners], triangles, edges
        else:
            for piece in body.pieces:
                corners = [at[i] for i in piece]
                yield corners, [tuple(corners)] if len(piece) == 3 else [], list(combinations(corners, 2))

    for (one, at), (other, there) in (sides, sides[::-1]):
        if not one.solid:
            continue
        for corners, triangles, _ in hulls(one, at):
            for others, faces, edges in hulls(other, there):
                if _convex_overlap(corners, triangles, others, faces, edges):
                    return True
    between = any(one.solid and len(one.parts) > 1 and not other.solid for one, other in ((a, b), (b, a)))
    return None if between else False


def start_of(a: Mesh, b: Mesh) -> str | None:
    """None for bodies apart, else "touching", "overlapping", "containment", or "any" where it is not known which."""
    if touch(a, b):
        over = overlapping(a, b)
        return "any" if over is None else "overlapping" if over else "touching"
    return "containment" if contained(a, b) else None


# ---- translations ----


def piece_times(a: Mesh, b: Mesh, v: Point) -> dict[tuple[int, int], tuple[F, F]]:
    """For the pieces (i, j) of a + t v and b that ever share a point: the closed interval of t, v not zero."""
    scale, places = whole(*a.vertices, *b.vertices)
    speed, (way,) = whole(v)
    k = next(i for i in (2, 1, 0) if way[i])
    i, j = [x for x in (0, 1, 2) if x != k]

    # along v a point keeps way[k] * p[i] - way[i] * p[k], and its height is p[k] / way[k]
    def flat(p: Point) -> Flat:
        return way[k] * p[i] - way[i] * p[k], way[k] * p[j] - way[j] * p[k], p[k]

    flats = [flat(p) for p in places]
    first, second = flats[: len(a.vertices)], flats[len(a.vertices) :]

    def boxed(points: Sequence[Flat]) -> tuple[Any, Any, Any, Any]:
        x, y = [p[0] for p in points], [p[1] for p in points]
        return min(x), max(x), min(y), max(y)

    ours = [[first[n] for n in piece] for piece in a.pieces]
    theirs = [[second[n] for n in piece] for piece in b.pieces]
    boxes, others = [boxed(p) for p in ours], [boxed(p) for p in theirs]
    found = {}
    for m, (p, s) in enumerate(zip(ours, boxes, strict=True)):
        for n, (q, t) in enumerate(zip(theirs, others, strict=True)):
            if s[0] > t[1] or t[0] > s[1] or s[2] > t[3] or t[2] > s[3]:
                continue
            at = [F(top * speed, bottom * way[k] * scale) for top, bottom in heights(p, q)]
            if at:
                found[m, n] = min(at), max(at)
    return found


def moved(a: Mesh, v: Point, t: Any) -> Mesh:
    return a.mapped(lambda p: plus(p, times(t, v)))


def contact_times(a: Mesh, b: Mesh, v: Point, first: F, last: F | None) -> list[tuple[F, F | None]]:
    """All t in [first, last] (None: for ever) at which a + t v and b share a point, as disjoint closed intervals."""
    if not any(v):
        resting = moved(a, v, 0)
        return [(first, last)] if touch(resting, b) or contained(resting, b) else []
    spans = sorted(piece_times(a, b, v).values())
    merged: list[list[Any]] = []
    for lo, hi in spans:
        lo, hi = max(lo, first), hi if last is None else min(hi, last)
        if lo > hi:
            continue
        if merged and lo <= merged[-1][1]:
            merged[-1][1] = max(merged[-1][1], hi)
        else:
            merged.append([lo, hi])
    if not (a.solid or b.solid):
        return [(lo, hi) for lo, hi in merged]
    # between these the surfaces are apart, and one body inside the other at one time is so at all
    gaps: list[tuple[F, F | None]] = []
    at = first
    for lo, hi in merged:
        if at < lo:
            gaps.append((at, lo))
        at = hi
    if last is None:
        gaps.append((at, None))
    elif at < last or not merged:
        gaps.append((at, last))
    for lo, hi in gaps:
        middle = lo + 1 if hi is None else (lo + hi) / 2
        if contained(moved(a, v, middle), b):
            merged.append([lo, hi])
    merged.sort(key=lambda pair: (pair[0], pair[1] is None, pair[1] or 0))
    joined: list[list[Any]] = []
    for lo, hi in merged:
        if joined and (joined[-1][1] is None or lo <= joined[-1][1]):
            if joined[-1][1] is not None:
                joined[-1][1] = None if hi is None else max(joined[-1][1], hi)
        else:
            joined.append([lo, hi])
    return [(lo, hi) for lo, hi in joined]


# ---- how far a point of doubles is from a body ----


def distance(point: Sequence[float], body: Mesh) -> float:
    """Distance of a point from the surface, to some 1e-12 of it."""
    here = tuple(F(float(x)) for x in point)
    apart = [tuple(float(x) for x in minus(p, here)) for p in body.vertices]
    return min(_from_origin([apart[i] for i in piece]) for piece in body.pieces)


def _from_origin(points: Sequence[tuple[float, float, float]]) -> float:
    best = min(math.sqrt(dot(p, p)) for p in points)
    for p, q in combinations(points, 2):
        d = minus(q, p)
        length = dot(d, d)
        if length > 0 and 0 < -dot(p, d) < length:
            c = cross(p, d)
            best = min(best, math.sqrt(dot(c, c) / length))
    if len(points) == 3:
        p, q, r = points
        n = cross(minus(q, p), minus(r, p))
        size = math.sqrt(dot(n, n))
        if size > 0:
            sides = [dot(n, cross(x, y)) for x, y in ((p, q), (q, r), (r, p))]
            if min(sides) >= 0 or max(sides) <= 0:
                best = min(best, abs(dot(n, p)) / size)
    return best
