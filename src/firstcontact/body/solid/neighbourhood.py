"""What a solid looks like around a point of its surfaces: which faces meet there, and at which angle.

`around_curve` looks at a point inside an arc, where everything is decided in the plane across the arc; `patterns`
lists the sign patterns around a rational point.  Tangent surfaces (seams, cusps, apexes) are told apart by second
order terms; this part is re-derived.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from flint import arb, ctx, fmpq

from firstcontact.body.solid.carriers import (
    ONE,
    ZERO,
    Quadric,
    Rows,
    Surface,
    Vector,
    bilinear,
    columns,
    diagonalised,
    dot,
    inverse,
    null_space,
    restricted,
    rough_root,
    scaled_axes,
)
from firstcontact.body.solid.csg import Tree, inside, pattern
from firstcontact.exact.numbers import to_double
from firstcontact.exact.vectors import cross

Half = tuple[arb, int]
"""A half-branch: the direction (angle) in which a surface (number) leaves the point, in the plane across the curve."""

# Radius of the circle on which tangent surfaces are told apart, in units of their radius of curvature and of the angle
# between them if they cross.  Surfaces that osculate to second order are 2^-180 apart there; enclosures have 400 bits.
CIRCLE = 2.0**-60


@dataclass(frozen=True)
class Profile:
    """kind: "inside", "outside", "face" (the curve is no edge), "smooth", "convex" or "reentrant".

    faces: (surface, orientation) of the faces that meet in the curve; orientation +1 where the body lies on the
    negative side of the surface's form.
    """

    kind: str
    faces: frozenset[tuple[int, int]]


def around_curve(
    tree: Tree, surfaces: Sequence[Surface], signs: Sequence[int], x: Sequence[arb], dx: Sequence[arb]
) -> Profile:
    """The profile at the curve's point x with derivative dx (homogeneous enclosures); `signs` has a 0 for every
    surface that contains the curve."""
    on = [i for i, sign in enumerate(signs) if sign == 0]
    p = [c / x[3] for c in x[:3]]
    tangent = _unit([d * x[3] - c * dx[3] for c, d in zip(x[:3], dx[:3], strict=True)])
    full = {i: [arb(c) for c in surfaces[i].gradient([*p, arb(1)])] for i in on}
    gradients = {i: _unit(g) for i, g in full.items()}
    across = _frame(tangent, gradients)
    angles = sorted(_half_branches(across, gradients), key=lambda half: float(half[0]))
    gaps = [float(b[0] - a[0]) for a, b in zip(angles, angles[1:], strict=False)]
    if min(gaps) > 1e-6:
        probe = _first_order(across, gradients)
        halves = [(angle, i, angle) for angle, i in angles]
    else:
        radius = _radius(surfaces, full) * _least_angle(angles)
        probe = _on_circle(p, across, radius, surfaces)
        moved = [(_settled(angle, i, p, across, radius, surfaces), i, angle) for angle, i in angles]
        halves = sorted(moved, key=lambda half: _Exact(half[0]))
    return _profile(tree, signs, on, halves, probe)


@dataclass(frozen=True)
class _Exact:
    """Sort key: enclosures by their midpoints, at full precision."""

    value: arb

    def __lt__(self, other: _Exact) -> bool:
        return bool(arb(self.value.mid()) < arb(other.value.mid()))


def _unit(v: Sequence[arb]) -> list[arb]:
    length = dot(v, v).sqrt()
    return [c / length for c in v]


def _frame(tangent: list[arb], gradients: dict[int, list[arb]]) -> tuple[list[arb], list[arb]]:
    """Two unit vectors across the tangent, such that no half-branch is near the cut at angle pi."""
    k = min(range(3), key=lambda i: abs(float(tangent[i])))
    first = _unit(cross(tangent, [arb(i == k) for i in range(3)]))
    second = list(cross(tangent, first))
    taken = sorted(
        (math.atan2(float(dot(g, second)), float(dot(g, first))) + math.pi / 2 * s) % (2 * math.pi)
        for g in gradients.values()
        for s in (1, 3)
    )
    ends = [*taken[1:], taken[0] + 2 * math.pi]
    gap, at = max((end - start, (start + end) / 2) for start, end in zip(taken, ends, strict=True))
    c, s = arb(at - math.pi).cos(), arb(at - math.pi).sin()
    return (
        [c * a + s * b for a, b in zip(first, second, strict=True)],
        [c * b - s * a for a, b in zip(first, second, strict=True)],
    )


def _half_branches(across: tuple[list[arb], list[arb]], gradients: dict[int, list[arb]]) -> list[Half]:
    """First-order directions: across each gradient."""
    first, second = across
    halves = []
    for i, g in gradients.items():
        a, b = dot(g, first), dot(g, second)
        halves += [(arb.atan2(a, -b), i), (arb.atan2(-a, b), i)]
    return halves


def _first_order(across: tuple[list[arb], list[arb]], gradients: dict[int, list[arb]]) -> Callable[..., int]:
    first, second = across

    def sign(i: int, angle: float) -> int:
        g = gradients[i]
        value = float(dot(g, first)) * math.cos(angle) + float(dot(g, second)) * math.sin(angle)
        return 1 if value > 0 else -1

    return sign


def least_angle() -> float:
    """At the present precision half-branches that are nearer count as tangent."""
    return float(2.0 ** (-ctx.prec // 4))


def nearly_tangent(surfaces: Sequence[Surface], on: Sequence[int], x: Sequence[arb]) -> bool:
    """Whether two of the surfaces may be tangent at x as far as the present precision tells."""
    gradients = [[arb(c) for c in surfaces[i].gradient([c / x[3] for c in x])] for i in on]
    least = arb((16 * least_angle()) ** 2)
    pairs = ((g, h, cross(g, h)) for g, h in combinations(gradients, 2))
    return any(not dot(n, n) > least * dot(g, g) * dot(h, h) for g, h, n in pairs)


def _least_angle(angles: list[Half]) -> arb:
    """The least of those that are not zero: farther out than in this measure, surfaces that cross may cross again."""
    sizes = [float(abs(b - a).mid()) for (a, _), (b, _) in combinations(angles, 2)]
    return arb(min(size for size in sizes if size > least_angle()))


def _radius(surfaces: Sequence[Surface], gradients: dict[int, list[arb]]) -> arb:
    """CIRCLE times the smallest radius of curvature."""
    radii = [1.0]
    for i, g in gradients.items():
        surface = surfaces[i]
        if isinstance(surface, Quadric):
            bend = max(abs(x) for row in surface.form[:3] for x in row[:3])
            radii.append(float(dot(g, g).sqrt() / bend))
    return arb(CIRCLE * min(radii))


def _probe(p: list[arb], across: tuple[list[arb], list[arb]], radius: arb, angle: arb) -> tuple[list[arb], list[arb]]:
    """The point of the circle at that angle, and the direction in which it moves with the angle."""
    c, s = angle.cos(), angle.sin()
    point = [x + radius * (c * a + s * b) for x, a, b in zip(p, *across, strict=True)]
    return [*point, arb(1)], [radius * (c * b - s * a) for a, b in zip(*across, strict=True)]


def _on_circle(
    p: list[arb], across: tuple[list[arb], list[arb]], radius: arb, surfaces: Sequence[Surface]
) -> Callable[..., int]:
    def sign(i: int, angle: float | arb) -> int:
        point, _ = _probe(p, across, radius, arb(angle))
        return 1 if surfaces[i].value(point).mid() > 0 else -1

    return sign


def _settled(
    angle: arb, i: int, p: list[arb], across: tuple[list[arb], list[arb]], radius: arb, surfaces: Sequence[Surface]
) -> arb:
    """Where the surface's half-branch crosses the circle, by Newton's method from its first-order direction."""
    angle = arb(angle.mid())
    least = arb(2) ** (-3 * ctx.prec // 4)  # a step beyond one so short is far below the precision
    for _ in range(8):
        point, ahead = _probe(p, across, radius, angle)
        step = arb((surfaces[i].value(point) / dot(surfaces[i].gradient(point), ahead)).mid())
        angle = arb((angle - step).mid())
        if abs(step) < least:
            break
    return angle


def _profile(
    tree: Tree, signs: Sequence[int], on: list[int], halves: list[tuple[arb, int, arb]], probe: Callable[..., int]
) -> Profile:
    """Sector by sector around the curve; halves: (angle, surface, first-order angle), ascending."""
    turn = 2 * arb.pi()
    starts = [angle for angle, _, _ in halves]
    ends = [*starts[1:], starts[0] + turn]
    patterns = []
    for start, end in zip(starts, ends, strict=True):
        middle = (start + end) / 2
        at = float(middle) if float(end - start) > 1e-6 else arb(middle.mid())
        patterns.append({i: probe(i, at) for i in on})
    flags, values = [], pattern(signs, (), ())
    for s in patterns:
        for i in on:
            values[i] = s[i] < 0
        flags.append(inside(tree, values))
    if len(set(flags)) == 1:
        return Profile("inside" if flags[0] else "outside", frozenset())
    n = len(halves)
    faces = set()
    for k, (_, i, _) in enumerate(halves):  # half k lies between sector k - 1 and sector k
        if flags[k] != flags[k - 1]:
            owner = patterns[k] if flags[k] else patterns[k - 1]
            faces.add((i, 1 if owner[i] < 0 else -1))
    kinds = set()
    for k in range(n):
        if flags[k] and not flags[k - 1]:
            length = next(j for j in range(1, n + 1) if not flags[(k + j) % n])
            last = k + length
            width = halves[last % n][2] + (turn if last >= n else 0) - halves[k][2]
            kinds.add(_kind(width, halves[k][1] == halves[last % n][1]))
    return Profile(next(kind for kind in ("convex", "reentrant", "smooth", "face") if kind in kinds), frozenset(faces))


def _kind(width: arb, same_surface: bool) -> str:
    excess = width - arb.pi()
    if excess < 0:
        return "convex"
    if excess > 0:
        return "reentrant"
    return "face" if same_surface else "smooth"


# -- around a rational point --------------------------------------------------------------------------------


def patterns(point: Vector, surfaces: Sequence[Surface], on: Sequence[int]) -> set[tuple[bool, ...]]:
    """Which of the forms `on`, all zero at the point (x, y, z, 1), are negative together nearby.

    Every pattern listed occurs arbitrarily near.  All that occur are listed where gradients are not zero and tangent
    surfaces differ in second order.  Around the apex of a cone, those of the cone and one plane are; others sampled.
    """
    gradients = {i: surfaces[i].gradient(point) for i in on}
    found: set[tuple[bool, ...]] = set()
    cones = [s for i in on if not any(gradients[i]) and isinstance(s := surfaces[i], Quadric)]
    directions = _directions(gradients)
    for cone in cones:
        directions += _around_cone(cone, [g for g in gradients.values() if any(g)])
    for d in directions:
        found |= _patterns_along(d, surfaces, on, gradients)
    return found


def _patterns_along(
    d: Vector, surfaces: Sequence[Surface], on: Sequence[int], gradients: dict[int, Vector]
) -> set[tuple[bool, ...]]:
    """Patterns at point + s d + s^2 e for small s > 0 and every e that makes a difference."""
    first = {i: dot(gradients[i], d) for i in on}
    second = {i: surfaces[i].polar((*d, ZERO), (*d, ZERO)) for i in on}
    flat = [i for i in on if first[i] == 0 and any(gradients[i])]
    if any(first[i] == 0 and i not in flat and second[i] == 0 for i in on):
        return set()
    if not flat:
        return {tuple((first[i] or second[i]) < 0 for i in on)}
    normal = gradients[flat[0]]
    if any(any(cross(gradients[i], normal)) for i in flat):
        return set()
    slope = {i: dot(gradients[i], normal) for i in flat}
    steps = sorted({-second[i] / slope[i] for i in flat})
    chosen = [steps[0] - 1, *((a + b) / 2 for a, b in zip(steps, steps[1:], strict=False)), steps[-1] + 1]
    return {
        tuple((second[i] + slope[i] * step if i in slope else first[i] or second[i]) < 0 for i in on)
        for step in chosen
    }


def _directions(gradients: dict[int, Vector]) -> list[Vector]:
    """One direction in every cell into which the tangent planes cut space, some in the planes, some everywhere."""
    normals: list[Vector] = []
    for g in gradients.values():
        if any(g) and not any(not any(cross(g, n)) for n in normals):
            normals.append(g)
    found = [tuple(s * x for x in n) for n in normals for s in (1, -1)]
    rays = [cross(m, n) for k, m in enumerate(normals) for n in normals[:k]]
    for ray in rays:
        through = [n for n in normals if dot(n, ray) == 0]
        for v in _between_planes(ray, through):
            found += [tuple(s * r + x for r, x in zip(_short(ray), v, strict=True)) for s in (1, -1)]
    for n in normals:
        if sum(1 for g in gradients.values() if any(g) and not any(cross(g, n))) > 1:
            found += _within_plane(n)
    if any(not any(g) for g in gradients.values()):
        for n in normals:
            found += _within_plane(n)
    return found


def _around_cone(cone: Quadric, normals: list[Vector]) -> list[Vector]:
    """Directions spread evenly as the cone measures them; and in all four sectors between it and each plane."""
    block = tuple(row[:3] for row in cone.form[:3])
    frame = scaled_axes(block)
    found = [tuple(dot(row, d) for row in frame) for d in _everywhere(200)]
    for n in normals:
        plane, pole = columns(*null_space((n,))), _pole(block, n)
        beyond = bilinear(block, pole, pole)
        for value, y in diagonalised(restricted(block, plane)):
            if value * beyond >= 0:
                continue
            c = tuple(dot(row, y) for row in plane)  # Q(c + t pole) = Q(c) + t^2 Q(pole)
            t = rough_root(-value / beyond)
            found += [tuple(s * a + k * t * b for a, b in zip(c, pole, strict=True)) for s in (1, -1) for k in _SHARES]
    return found


# Beside a plane through the apex, inside and outside of the cone.
_SHARES = (fmpq(1, 4), fmpq(-1, 4), fmpq(4), fmpq(-4))


def _pole(block: Rows, normal: Vector) -> Vector:
    """The direction conjugate to all of the plane."""
    return tuple(dot(row, normal) for row in inverse(block))


def _short(v: Sequence[Any]) -> Vector:
    """A rational vector along v (fmpq or floats), exact for fmpq, of length about one."""
    size = max(abs(x) for x in v)
    if isinstance(size, float):
        return tuple(fmpq(round(x / size * 2**30), 2**30) for x in v)
    return tuple(x / size for x in v)


def _between_planes(ray: Vector, normals: list[Vector]) -> list[Vector]:
    """Small steps off the ray, one into every sector between the planes through it."""
    u = _floats(ray)
    first = _unit_f(_cross_f(u, _floats(normals[0])))
    second = _unit_f(_cross_f(u, first))
    angles = []
    for n in normals:
        t = _cross_f(u, _floats(n))
        angle = math.atan2(sum(map(_times, t, second)), sum(map(_times, t, first)))
        angles += [angle % (2 * math.pi), (angle + math.pi) % (2 * math.pi)]
    angles.sort()
    steps = []
    for start, end in zip(angles, [*angles[1:], angles[0] + 2 * math.pi], strict=True):
        c, s = math.cos((start + end) / 2), math.sin((start + end) / 2)
        v = _short([c * a + s * b for a, b in zip(first, second, strict=True)])
        steps.append(tuple(x / 2**20 for x in v))
    return steps


def _within_plane(normal: Vector) -> list[Vector]:
    """Sixteen directions exactly across the normal."""
    k = min(range(3), key=lambda i: abs(normal[i]))
    first = _short(cross(normal, tuple(ONE if i == k else ZERO for i in range(3))))
    second = _short(cross(normal, first))
    weights = [(fmpq(round(64 * math.cos(a)), 64), fmpq(round(64 * math.sin(a)), 64)) for a in _turn(16)]
    return [tuple(p * a + q * b for a, b in zip(first, second, strict=True)) for p, q in weights]


def _turn(n: int) -> list[float]:
    return [2 * math.pi * (k + 0.37) / n for k in range(n)]


def _everywhere(n: int) -> list[Vector]:
    """Directions spread evenly over the sphere (golden spiral)."""
    found = []
    for k in range(n):
        z = 1 - (2 * k + 1) / n
        r, angle = math.sqrt(1 - z * z), math.pi * (3 - math.sqrt(5)) * k
        found.append(_short([r * math.cos(angle), r * math.sin(angle), z]))
    return found


def _floats(v: Vector) -> list[float]:
    return [to_double(x) for x in _short(v)]


def _cross_f(x: Sequence[float], y: Sequence[float]) -> list[float]:
    return list(cross(x, y))


def _unit_f(v: Sequence[float]) -> list[float]:
    length = math.sqrt(sum(x * x for x in v))
    return [x / length for x in v]


def _times(x: float, y: float) -> float:
    return x * y
