"""Planar polygons, also non-convex and with holes, cut into triangles by ear clipping (Meisters 1975).

All turns are decided exactly: floats behind an error bound first, rationals behind them.
"""

from __future__ import annotations

import numpy as np
from flint import fmpq

from firstcontact.errors import InputError

# A polygon counts as planar when no corner is farther from its plane than this fraction of its size.
PLANARITY = 1e-9

Point = tuple[float, float]
_Triangle = tuple[int, int, int]


def triangulate(
    vertices: np.ndarray, rings: list[list[int]], who: str, warped: bool = False
) -> list[tuple[int, int, int]]:
    """Triangles (vertex indices, orientation of the outer ring) that fill the polygon.

    rings: the outer ring and then the holes, vertex indices, any orientation.  warped: cut polygons that are not
    planar too, as seen across the plane they are nearest to.
    Raises InputError when the polygon is not planar or its rings cross.
    """
    if len(rings) == 1 and len(rings[0]) == 3:
        a, b, c = rings[0]
        return [(a, b, c)]
    plane = _project(vertices, rings, who, warped)
    turn = _Turn(plane)
    outer, *holes = rings
    flipped = _signed_area(plane, outer) < 0
    outer = outer[::-1] if flipped else outer
    holes = [hole if _signed_area(plane, hole) < 0 else hole[::-1] for hole in holes]
    loop = list(outer)
    for hole in sorted(holes, key=lambda h: -max(plane[i] for i in h)[0]):
        loop = _bridge(plane, turn, loop, hole, who)
    triangles = _without_flat(plane, turn, _clip_ears(plane, turn, loop, who))
    area = sum((abs(_twice_area(plane, *t)) for t in triangles), fmpq(0))
    if area != abs(sum((_twice_area(plane, loop[0], *side) for side in zip(loop, loop[1:], strict=False)), fmpq(0))):
        raise InputError(f"{who}: the rings of the polygon cross; split it into simple polygons")
    return [(c, b, a) for a, b, c in triangles] if flipped else triangles


def shapes(vertices: np.ndarray, polygons: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(planar, fan) of (m, k) polygons without holes, (m,) bools each.

    fan: planar, and proved strictly convex, so that the triangles from the first corner fill it.  All corners see
    the side from corner 0 to 1 on one side, so the fan turns less than half a turn about corner 0; each of its
    triangles turns the same way, so the sides do not cross; and so do all corners.
    """
    corners = vertices[polygons]
    spokes = corners - corners.mean(axis=1, keepdims=True)
    normal = np.cross(spokes, np.roll(spokes, -1, axis=1)).sum(axis=1)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    off = np.abs(np.einsum("nki,ni->nk", spokes, normal / np.where(length > 0, length, 1.0))).max(axis=1)
    planar = (length[:, 0] > 0) & (off <= PLANARITY * np.abs(spokes).max(axis=(1, 2)))
    axis = np.argmax(np.abs(normal), axis=1)
    rows = np.arange(len(polygons))[:, None]
    columns = np.arange(polygons.shape[1])[None, :]
    x, y = (corners[rows, columns, ((axis + k) % 3)[:, None]] for k in (1, 2))

    def turns(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
        left, right = (x[:, b] - x[:, a]) * (y[:, c] - y[:, a]), (y[:, b] - y[:, a]) * (x[:, c] - x[:, a])
        certain = np.abs(left - right) > 1e-15 * (np.abs(left) + np.abs(right)) + 1e-300  # as in _Turn
        return np.where(certain, np.sign(left - right), 0.0)

    k = np.arange(polygons.shape[1])
    first = np.zeros_like(k[2:])
    seen = np.hstack([
        turns(k, np.roll(k, -1), np.roll(k, -2)), turns(first, first + 1, k[2:]), turns(first, k[1:-1], k[2:]),
    ])  # fmt: skip
    return planar, planar & (np.abs(seen.sum(axis=1)) == seen.shape[1])


def _project(vertices: np.ndarray, rings: list[list[int]], who: str, warped: bool) -> dict[int, Point]:
    """Corners in the plane of the two coordinates in which the polygon is widest."""
    corners = vertices[rings[0]]
    centre = corners.mean(axis=0)
    spokes = corners - centre
    following = spokes[np.arange(1, len(spokes) + 1) % len(spokes)]
    turned = spokes[:, [1, 2, 0]] * following[:, [2, 0, 1]] - spokes[:, [2, 0, 1]] * following[:, [1, 2, 0]]
    normal = turned.sum(axis=0)
    length = np.linalg.norm(normal)
    every = vertices[[i for ring in rings for i in ring]]
    size = np.abs(every - centre).max()
    if length == 0 or not (warped or np.abs((every - centre) @ (normal / length)).max() <= PLANARITY * size):
        raise InputError(f"{who} is not a planar polygon; split it into triangles")
    k = int(np.argmax(np.abs(normal)))
    i, j = (k + 1) % 3, (k + 2) % 3
    return {v: (float(vertices[v, i]), float(vertices[v, j])) for ring in rings for v in ring}


class _Turn:
    """Sign of the turn a, b, c: 1 left, -1 right, 0 straight; exact."""

    def __init__(self, plane: dict[int, Point]) -> None:
        self.plane = plane

    def __call__(self, a: int, b: int, c: int) -> int:
        (ax, ay), (bx, by), (cx, cy) = self.plane[a], self.plane[b], self.plane[c]
        left, right = (bx - ax) * (cy - ay), (by - ay) * (cx - ax)
        det = left - right
        # each side carries 3 roundings, the difference one more: 4 * 2^-53 of the sum is a bound
        if abs(det) > 1e-15 * (abs(left) + abs(right)) + 1e-300:
            return 1 if det > 0 else -1
        axq, ayq, bxq, byq, cxq, cyq = (fmpq(*x.as_integer_ratio()) for x in (ax, ay, bx, by, cx, cy))
        exact = (bxq - axq) * (cyq - ayq) - (byq - ayq) * (cxq - axq)
        return (exact > 0) - (exact < 0)


def _twice_area(plane: dict[int, Point], a: int, b: int, c: int) -> fmpq:
    """Twice the signed area of a triangle, exact."""
    (ax, ay), (bx, by), (cx, cy) = ([fmpq(*x.as_integer_ratio()) for x in plane[v]] for v in (a, b, c))
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)


def _signed_area(plane: dict[int, Point], ring: list[int]) -> float:
    points = np.array([plane[i] for i in ring])
    points = points - points.mean(axis=0)
    x, y = points.T
    next_x, next_y = points[np.arange(1, len(points) + 1) % len(points)].T
    return float(np.sum(x * next_y - next_x * y))


def _inside(turn: _Turn, a: int, b: int, c: int, p: int) -> bool:
    return turn(a, b, p) >= 0 and turn(b, c, p) >= 0 and turn(c, a, p) >= 0


def _clip_ears(plane: dict[int, Point], turn: _Turn, loop: list[int], who: str) -> list[tuple[int, int, int]]:
    """Each turn of the loop removes one corner, so this ends after len(loop) - 2 turns."""
    loop = list(loop)
    triangles = []
    while len(loop) > 3:
        for k in range(len(loop)):
            a, b, c = loop[k - 1], loop[k], loop[(k + 1) % len(loop)]
            corners = {plane[a], plane[b], plane[c]}
            if turn(a, b, c) <= 0 or any(
                plane[p] not in corners and _inside(turn, a, b, c, p) for p in loop
            ):
                continue
            triangles.append((a, b, c))
            del loop[k]
            break
        else:
            if all(turn(loop[k - 1], loop[k], loop[(k + 1) % len(loop)]) == 0 for k in range(len(loop))):
                break  # what is left has no area: fans of flat triangles keep its corners on the face
            raise InputError(f"{who}: the rings of the polygon cross; split it into simple polygons")
    triangles += [(loop[0], loop[k], loop[k + 1]) for k in range(1, len(loop) - 1)]
    return triangles


def _without_flat(plane: dict[int, Point], turn: _Turn, triangles: list[_Triangle]) -> list[_Triangle]:
    """Triangles of the same area, none of which is flat to within roundings where that can be.

    The middle corner of a flat one is joined to the far corner of the triangle at its longest side instead.
    """
    flat = [t for t in triangles if _is_flat(plane, t)]
    if not flat:
        return triangles
    behind = {side: t for t in triangles for side in _sides(t)}
    while gone := next((pair for t in flat if (pair := _flipped(plane, turn, behind, t))), None):
        flat = [t for t in flat if t not in gone]
    return list(dict.fromkeys(behind.values()))


def _flipped(
    plane: dict[int, Point], turn: _Turn, behind: dict[tuple[int, int], _Triangle], t: _Triangle
) -> tuple[_Triangle, _Triangle] | None:
    """The two triangles whose diagonal was changed in `behind`, where that leaves no flat one.

    behind: the triangles by their sides in order.
    """
    a, b, c = _with_the_longest_side_last(plane, t)
    other = behind.get((a, c))
    if other is None or len({*other, *t}) < 4:  # of rings that cross
        return None
    x = next(v for v in other if v not in (a, c))
    made = (a, b, x), (b, c, x)
    if any(turn(*u) <= 0 or _is_flat(plane, u) for u in made):
        return None
    del behind[a, c], behind[c, a]
    for u in made:
        behind.update(dict.fromkeys(_sides(u), u))
    return t, other


def _is_flat(plane: dict[int, Point], t: _Triangle) -> bool:
    (ax, ay), (bx, by), (cx, cy) = (plane[v] for v in t)
    size = max((bx - ax) ** 2 + (by - ay) ** 2, (cx - bx) ** 2 + (cy - by) ** 2, (ax - cx) ** 2 + (ay - cy) ** 2)
    return abs((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)) <= PLANARITY * size


def _sides(t: _Triangle) -> tuple[tuple[int, int], ...]:
    a, b, c = t
    return (a, b), (b, c), (c, a)


def _with_the_longest_side_last(plane: dict[int, Point], t: _Triangle) -> _Triangle:
    a, b, c = t
    return max(((a, b, c), (b, c, a), (c, a, b)), key=lambda u: _distance2(plane[u[2]], plane[u[0]]))


def _bridge(
    plane: dict[int, Point], turn: _Turn, loop: list[int], hole: list[int], who: str
) -> list[int]:
    """The loop with the hole joined by a bridge from the hole's rightmost corner to a corner it sees."""
    start = max(range(len(hole)), key=lambda k: plane[hole[k]])
    h = hole[start]
    order = sorted(range(len(loop)), key=lambda k: _distance2(plane[loop[k]], plane[h]))
    for k in order:
        if plane[loop[k]] != plane[h] and _sees(plane, turn, loop, hole, h, k):
            ring = hole[start:] + hole[:start]
            return loop[: k + 1] + ring + [h] + loop[k:]
    raise InputError(f"{who}: a hole lies outside the outer ring or crosses it")


def _distance2(p: Point, q: Point) -> float:
    return (p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2


def _sees(plane: dict[int, Point], turn: _Turn, loop: list[int], hole: list[int], h: int, k: int) -> bool:
    """Whether the segment from hole corner h to loop[k] lies inside the loop and crosses no side."""
    v, before, after = loop[k], loop[k - 1], loop[(k + 1) % len(loop)]
    convex = turn(before, v, after) >= 0
    left, right = turn(before, v, h) > 0, turn(v, after, h) > 0
    if not (left and right if convex else left or right):
        return False
    sides = [side for ring in (loop, hole) for side in zip(ring, ring[1:] + ring[:1], strict=True)]
    return not any(
        plane[p] not in (plane[h], plane[v])
        and plane[q] not in (plane[h], plane[v])
        and turn(h, v, p) * turn(h, v, q) <= 0
        and turn(p, q, h) * turn(p, q, v) <= 0
        for p, q in sides
    )
