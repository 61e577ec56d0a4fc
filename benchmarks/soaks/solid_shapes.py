"""What the oracles know of curved and flat bodies: forms, membership, distances from below, supports, places to touch.

Written from the definitions of the builders alone.  All placements are rational, so that membership of rational points
is exact.  `Body.off` never exceeds the distance of a point, so a point that is told to be off is off.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction as F
from math import isqrt, sqrt
from random import Random
from typing import Any

from . import exact as ex
from .exact import ANGLES, IDENTITY, Matrix, Vector

Tree = tuple[Any, ...]
"""("form", k), ("and", tree, ...), ("or", tree, ...), ("not", tree)."""


@dataclass(frozen=True)
class Feature:
    """A place to touch: a point of the boundary, a unit normal with which the body's plane supports it.

    kind    what the plane shares with the body: "point", "line" (along `along`), "face".
    smooth  whether the normal is the only one there.
    """

    point: Vector
    normal: Vector
    kind: str
    smooth: bool
    along: Vector | None = None


@dataclass(frozen=True)
class Body:
    """A body at rest.

    source    text of an expression; place: the affine map from the frame of the shape to the world.
    forms     symmetric 4x4 matrices Q of the shape's frame, inside where X^T Q X <= 0; tree: how they make the solid.
    support   greatest d . x over the shape, in its frame; None where it is not convex or unbounded.
    corners   of polyhedra, in the frame of the shape; with `flat`, where they span no solid.
    features  places to touch, chosen at random; None where there are none.
    """

    source: str
    size: F
    forms: tuple[Matrix, ...] = ()
    tree: Tree = ()
    support: Callable[[Sequence[float]], float] | None = None
    corners: tuple[Vector, ...] = ()
    flat: bool = False
    feature: Callable[[Random], Feature] | None = None
    place: Matrix = field(default_factory=lambda: IDENTITY)
    faces: str = ""
    kind: str = ""
    bounded: bool = True
    convex: bool = True

    def placed(self, m: Matrix) -> Body:
        return replace(self, place=ex.product(m, self.place))

    def text(self) -> str:
        """The body in its place as source text."""
        if self.place == IDENTITY:
            return self.source
        shift = [row[3] for row in self.place[:3]]
        if ex.shifting(shift) == self.place:
            return f"{self.source}.translated({ex.texts(tuple(shift))})"
        return f"{self.source}.transformed({ex.texts(self.place)})"

    def baked(self) -> Body:
        """A polyhedron with its place in its vertices."""
        corners = tuple(ex.apply(self.place, p) for p in self.corners)
        if not corners:
            return self
        made = polytope(corners, self.faces, self.flat, self.world_forms())
        return replace(made, kind=self.kind, tree=self.tree, convex=self.convex)

    def world_forms(self) -> list[Matrix]:
        back = ex.inverse(self.place)
        return [pulled(q, back) for q in self.forms]

    def signs_at(self, p: Sequence[Any]) -> list[int]:
        q = ex.apply(ex.inverse(self.place), p)
        return [_sign(value(form, q)) for form in self.forms]

    def side(self, p: Sequence[Any]) -> int:
        """1 inside, 0 on the boundary of some part, -1 outside; exact.  Of solids only."""
        return _sides(self.tree, self.signs_at(p))

    def off(self, p: Sequence[Any]) -> float:
        """At most the distance from the rational point p to the body."""
        if self.flat:
            return _off_hull([ex.apply(self.place, c) for c in self.corners], p)
        return max(0.0, _lower(self.tree, self._gaps(p)))

    def depth(self, p: Sequence[Any]) -> float:
        """At most the distance from p to the outside; 0 outside."""
        return 0.0 if self.flat else max(0.0, -_lower(self.tree, self._gaps(p)))

    def _gaps(self, p: Sequence[Any]) -> list[float]:
        return [_gap(form, p) for form in self.world_forms()]

    def reach(self, d: Sequence[float]) -> float:
        """Greatest d . x over the body in its place, in doubles."""
        assert self.support is not None
        shift = [row[3] for row in self.place[:3]]
        return self.support([float(x) for x in ex.pull(self.place, d)]) + float(ex.dot(d, shift))

    def there(self, feature: Feature) -> Feature:
        """A feature of the shape's frame in the body's place; its normal is no longer of unit length."""
        normal = ex.pull(ex.inverse(self.place), feature.normal)
        along = None if feature.along is None else ex.turn(self.place, feature.along)
        return replace(feature, point=ex.apply(self.place, feature.point), normal=normal, along=along)


def _sign(x: Any) -> int:
    return (x > 0) - (x < 0)


def value(q: Matrix, p: Sequence[Any]) -> Any:
    x = (*p, 1)
    return sum(q[i][j] * x[i] * x[j] for i in range(4) for j in range(4) if q[i][j])


def _gap(q: Matrix, p: Sequence[Any]) -> float:
    """Signed: at most the distance from p to the surface of q; positive outside.

    |q(p + d) - q(p)| <= |gradient| |d| + |A| |d|^2, so the surface is no nearer than the root of that.
    """
    level = value(q, p)
    if not level:
        return 0.0
    grad = [2 * (ex.dot(q[i][:3], p) + q[i][3]) for i in range(3)]
    top = max(abs(x) for x in (*grad, level))
    level, grad = float(level / top), [float(x / top) for x in grad]
    slope = sqrt(sum(x * x for x in grad))
    bend = sqrt(sum(float(q[i][j] / top) ** 2 for i in range(3) for j in range(3)))
    size = 2 * abs(level) / (slope + sqrt(slope * slope + 4 * bend * abs(level)))
    return size if level > 0 else -size


def _lower(tree: Tree, gaps: list[float]) -> float:
    """Signed distance from the solid, from below in size on either side."""
    match tree:
        case ("form", k):
            return gaps[k]
        case ("and", *parts):
            return max(_lower(t, gaps) for t in parts)
        case ("or", *parts):
            return min(_lower(t, gaps) for t in parts)
        case ("not", part):
            return -_lower(part, gaps)
    raise ValueError(tree)


def _sides(tree: Tree, signs: list[int]) -> int:
    match tree:
        case ("form", k):
            return -signs[k]
        case ("and", *parts):
            return min(_sides(t, signs) for t in parts)
        case ("or", *parts):
            return max(_sides(t, signs) for t in parts)
        case ("not", part):
            return -_sides(part, signs)
    raise ValueError(tree)


def pulled(q: Matrix, m: Matrix) -> Matrix:
    """m^T q m."""
    half = [[sum(q[i][k] * m[k][j] for k in range(4) if m[k][j]) for j in range(4)] for i in range(4)]
    return [[sum(m[k][i] * half[k][j] for k in range(4) if m[k][i]) for j in range(4)] for i in range(4)]


def _off_hull(corners: list[Vector], p: Sequence[Any]) -> float:
    """Distance from p to a point, segment or triangle."""
    if len(corners) == 1:
        return ex.length(ex.sub(p, corners[0]))
    if len(corners) == 2:
        a, b = corners
        e = ex.sub(b, a)
        k = min(1, max(0, ex.dot(ex.sub(p, a), e) / F(ex.dot(e, e))))
        return ex.length(ex.sub(p, ex.add(a, ex.scale(k, e))))
    a, b, c = corners
    n = ex.cross(ex.sub(b, a), ex.sub(c, a))
    foot = ex.sub(p, ex.scale(ex.dot(ex.sub(p, a), n) / F(ex.dot(n, n)), n))
    if all(ex.dot(ex.cross(ex.sub(v, u), ex.sub(foot, u)), n) >= 0 for u, v in ((a, b), (b, c), (c, a))):
        return ex.length(ex.sub(p, foot))
    return min(_off_hull([u, v], p) for u, v in ((a, b), (b, c), (c, a)))


# ---- forms and trees of the builders


def plane(n: Sequence[Any], d: Any) -> Matrix:
    """n . x - d."""
    h = [F(x) / 2 for x in n]
    return [[F(0), F(0), F(0), h[0]], [F(0), F(0), F(0), h[1]], [F(0), F(0), F(0), h[2]], [*h, -F(d)]]


def diagonal(x: Any, y: Any, z: Any, w: Any) -> Matrix:
    return [[F(v) if i == j else F(0) for j in range(4)] for i, v in enumerate((x, y, z, w))]


def slab(low: Any, high: Any) -> tuple[Matrix, Matrix]:
    return plane((0, 0, 1), high), plane((0, 0, -1), -low)


def _all(forms: Sequence[Matrix]) -> dict[str, Any]:
    return {"forms": tuple(forms), "tree": ("and", *(("form", k) for k in range(len(forms))))}


def combined(op: str, a: Body, b: Body, support: Any = None) -> Body:
    """a | b, a & b, a - b, of bodies in their places."""
    shift = len(a.forms)

    def moved(tree: Tree) -> Tree:
        return ("form", tree[1] + shift) if tree[0] == "form" else (tree[0], *(moved(t) for t in tree[1:]))

    other = moved(b.tree)
    tree = {"|": ("or", a.tree, other), "&": ("and", a.tree, other), "-": ("and", a.tree, ("not", other))}[op]
    forms = (*a.world_forms(), *b.world_forms())
    size = max(a.size, b.size) if op == "|" else a.size
    return Body(f"({a.text()} {op} {b.text()})", size, forms, tree, support, kind="csg")


def sphere(r: F) -> Body:
    def feature(rng: Random) -> Feature:
        u = ex.unit(rng)
        return Feature(ex.scale(r, u), u, "point", True)

    return Body(f"fc.sphere({ex.text(r)})", 2 * r, **_all([diagonal(1, 1, 1, -r * r)]), kind="sphere", feature=feature,
                support=lambda d: float(r) * ex.length(d))


def ellipsoid(a: F, b: F, c: F, feature: Any = None) -> Body:
    forms = [diagonal(1 / a**2, 1 / b**2, 1 / c**2, -1)]
    return Body(f"fc.ellipsoid({ex.texts((a, b, c))})", 2 * max(a, b, c), **_all(forms), kind="ellipsoid",
                feature=feature, support=lambda d: ex.length((float(a) * d[0], float(b) * d[1], float(c) * d[2])))


def _rim(rng: Random) -> tuple[F, F]:
    c, s = rng.choice((*ANGLES, (F(1), F(0)), (F(0), F(1))))
    return rng.choice((1, -1)) * c, rng.choice((1, -1)) * s


def cylinder(a: F, b: F, h: F) -> Body:
    """With the side's normals rational where a = b."""

    def feature(rng: Random) -> Feature:
        c, s = _rim(rng) if a == b else rng.choice(((F(1), F(0)), (F(0), F(1)), (F(-1), F(0)), (F(0), F(-1))))
        up = rng.choice((1, -1))
        what = rng.choice(("side", "side", "rim", "top"))
        if what == "side":
            z = h * F(rng.randint(-3, 3), 8)
            return Feature((a * c, b * s, z), (c, s, F(0)), "line", True, (F(0), F(0), F(1)))
        if what == "top":
            return Feature((a * c / 3, b * s / 3, up * h / 2), (F(0), F(0), F(up)), "face", True)
        lean, rise = rng.choice(ANGLES)
        return Feature((a * c, b * s, up * h / 2), (lean * c, lean * s, up * rise), "point", False)

    sizes = f"{ex.text(a)}" if a == b else f"radii={ex.texts((a, b))}"
    sizes += f", {ex.text(h)}" if a == b else f", height={ex.text(h)}"

    def support(d: Sequence[float]) -> float:
        return ex.length((float(a) * d[0], float(b) * d[1], 0)) + float(h) / 2 * abs(d[2])

    forms = [diagonal(1 / a**2, 1 / b**2, 0, -1), *slab(-h / 2, h / 2)]
    return Body(f"fc.cylinder({sizes})", max(2 * a, 2 * b, h), **_all(forms), kind="cylinder", feature=feature,
                support=support)


def frustum(bottom: F, top: F, h: F, lean: tuple[F, F] | None = None) -> Body:
    """lean: the side's unit normal (outwards, upwards) where it is rational; a cone where top = 0."""
    slope = (top - bottom) / h
    side = diagonal(1, 1, -(slope**2), -(bottom**2))
    side[2][3] = side[3][2] = -bottom * slope

    def feature(rng: Random) -> Feature:
        c, s = _rim(rng)
        what = rng.choice(("side", "rim", "top", "bottom") if lean else ("rim", "top", "bottom"))
        if what == "side" and lean:
            z = h * F(rng.randint(1, 7), 8)
            r = bottom + slope * z
            along = (slope * c, slope * s, F(1))
            return Feature((r * c, r * s, z), (lean[0] * c, lean[0] * s, lean[1]), "line", True, along)
        if what == "bottom":
            return Feature((bottom * c / 3, bottom * s / 3, F(0)), (F(0), F(0), F(-1)), "face", bool(bottom))
        if what == "top":
            return Feature((top * c / 3, top * s / 3, h), (F(0), F(0), F(1)), "face" if top else "point", bool(top))
        if bottom >= top:
            return Feature((bottom * c, bottom * s, F(0)), (c * F(4, 5), s * F(4, 5), F(-3, 5)), "point", False)
        return Feature((top * c, top * s, h), (c * F(4, 5), s * F(4, 5), F(3, 5)), "point", False)

    def support(d: Sequence[float]) -> float:
        across = ex.length((d[0], d[1], 0))
        return max(float(bottom) * across, float(top) * across + float(h) * d[2])

    name = f"fc.cone({ex.text(bottom)}, {ex.text(h)})" if not top else f"fc.frustum({ex.texts((bottom, top, h))[1:-1]})"
    return Body(name, max(2 * bottom, 2 * top, h), **_all([side, *slab(0, h)]), kind="frustum" if top else "cone",
                feature=feature, support=support)


def box(x: F, y: F, z: F) -> Body:
    half = (x / 2, y / 2, z / 2)
    forms = [plane([s * (i == k) for i in range(3)], half[k]) for k in range(3) for s in (1, -1)]

    def support(d: Sequence[float]) -> float:
        return sum(abs(d[i]) * float(half[i]) for i in range(3))

    return Body(f"fc.box({ex.texts((x, y, z))})", max(x, y, z), **_all(forms), kind="box",
                feature=lambda rng: box_feature(rng, half), support=support)


def box_feature(rng: Random, half: Sequence[F]) -> Feature:
    n = ex.unit(rng)
    point = tuple(h * (1 if n[i] > 0 else -1) if n[i] else h * F(rng.randint(-3, 3), 4) for i, h in enumerate(half))
    free = [i for i in range(3) if not n[i]]
    along = tuple(F(int(i == free[0])) for i in range(3)) if len(free) == 1 else None
    return Feature(point, n, ("point", "line", "face")[len(free)], len(free) == 2, along)  # type: ignore[arg-type]


def paraboloid(a: F, b: F, h: F) -> Body:
    form = diagonal(1 / a**2, 1 / b**2, 0, 0)
    form[2][3] = form[3][2] = F(-1, 2)

    def feature(rng: Random) -> Feature:
        if a == b and rng.random() < 0.6:
            c, s = _rim(rng)
            x, y = rng.choice(((3, 4), (5, 12), (8, 15), (0, 1)))  # the slope 2 r / a^2 of the side is x / y
            r = a * a * F(x, y) / 2
            if r * r < a * a * h:
                d = isqrt(x * x + y * y)
                return Feature((r * c, r * s, r * r / a**2), (F(x, d) * c, F(x, d) * s, F(-y, d)), "point", True)
        if rng.random() < 0.5:
            return Feature((F(0), F(0), F(0)), (F(0), F(0), F(-1)), "point", True)
        return Feature((F(0), F(0), h), (F(0), F(0), F(1)), "face", True)

    def support(d: Sequence[float]) -> float:
        q, top = ex.length((float(a) * d[0], float(b) * d[1], 0)), sqrt(float(h))
        rim = top if d[2] >= 0 else min(top, q / (2 * abs(d[2])))
        return q * rim + d[2] * (float(h) if d[2] >= 0 else rim * rim)

    name = f"fc.paraboloid({ex.text(a) if a == b else ex.texts((a, b))}, {ex.text(h)})"
    wide = root_up(h) * max(a, b) * 2
    return Body(name, max(wide, h), **_all([form, plane((0, 0, 1), h)]), kind="paraboloid", feature=feature,
                support=support)


def root_up(x: F) -> F:
    return ex.root(x, 20) * F(1001, 1000)


def hyperboloid(a: F, b: F, c: F, h: F, sheets: int = 1, feature: Any = None) -> Body:
    name = f"fc.hyperboloid({ex.texts((a, b, c))}, {ex.text(h)}{', sheets=2' if sheets == 2 else ''})"
    if sheets == 1:
        forms = [diagonal(1 / a**2, 1 / b**2, -1 / c**2, -1), *slab(-h / 2, h / 2)]
        wide = 2 * max(a, b) * root_up(1 + (h / 2 / c) ** 2)
        return Body(name, max(wide, h), **_all(forms), kind="hyperboloid", feature=feature)

    def support(d: Sequence[float]) -> float:
        q, top = ex.length((float(a) * d[0], float(b) * d[1], 0)), float(h / c)
        down = -d[2] * float(c)
        w = min(top, down / sqrt(down * down - q * q)) if down > q else top
        return q * sqrt(max(0.0, w * w - 1)) - down * w

    forms = [diagonal(1 / a**2, 1 / b**2, -1 / c**2, 1), *slab(0, h)]
    wide = 2 * max(a, b) * root_up((h / c) ** 2)
    return Body(name, max(wide, h), **_all(forms), kind="cap", feature=feature, support=support)


def half_space(n: Sequence[Any], d: Any, size: F = F(0)) -> Body:
    """n of unit length where it is to be touched; `size` for tolerances."""

    def feature(rng: Random) -> Feature:
        return Feature(ex.scale(d, n), tuple(n), "face", True)  # type: ignore[arg-type]

    return Body(f"fc.half_space({ex.texts(tuple(n))}, {ex.text(d)})", size, **_all([plane(n, d)]), kind="half-space",
                bounded=False, feature=feature)


# ---- polyhedra


def polytope(corners: Sequence[Vector], faces: str = "[]", flat: bool = True, forms: Sequence[Matrix] = ()) -> Body:
    """A convex polyhedron, or (flat) a point, segment or triangle."""
    corners = tuple(corners)
    extra = ", edges=[[0, 1]]" if len(corners) == 2 else ""
    if not flat and not forms:
        forms = hull_forms(corners)

    def support(d: Sequence[float]) -> float:
        return max(sum(float(p[i]) * d[i] for i in range(3)) for p in corners)

    def feature(rng: Random) -> Feature:
        n = ex.unit(rng)
        if len(corners) == 2 and rng.random() < 0.5:
            n = (F(0), *rng.choice(((F(1), F(0)), (F(0), F(-1)), (F(3, 5), F(4, 5)), (F(-5, 13), F(12, 13)))))
        if len(corners) == 3 and rng.random() < 0.5:
            n = (F(0), F(0), F(rng.choice((1, -1))))
        best = max(ex.dot(n, p) for p in corners)
        top = [p for p in corners if ex.dot(n, p) == best]
        weights = [F(rng.randint(1, 4)) for _ in top]
        point = tuple(sum(w * p[i] for w, p in zip(weights, top, strict=True)) / sum(weights) for i in range(3))
        along = ex.sub(top[1], top[0]) if len(top) == 2 else None
        kind = "point" if len(top) == 1 else "line" if len(top) == 2 else "face"
        return Feature(point, n, kind, len(top) > 2, along)  # type: ignore[arg-type]

    spread = max(max(p[i] for p in corners) - min(p[i] for p in corners) for i in range(3))
    made = _all(forms) if not flat else {}
    name = ("point", "edge", "triangle")[len(corners) - 1] if flat else "mesh"
    return Body(f"fc.Polyhedron({ex.texts(list(corners))}, {faces}{extra})", spread, support=support, corners=corners,
                flat=flat, feature=feature, faces=faces, kind=name, **made)


def hull_forms(corners: Sequence[Vector]) -> list[Matrix]:
    """The planes of the hull of few points."""
    planes: dict[tuple[Any, ...], Matrix] = {}
    n = len(corners)
    for i in range(n):
        for j in range(i + 1, n):
            for k in range(j + 1, n):
                normal = ex.cross(ex.sub(corners[j], corners[i]), ex.sub(corners[k], corners[i]))
                if not any(normal):
                    continue
                d = ex.dot(normal, corners[i])
                sides = [ex.dot(normal, p) - d for p in corners]
                for s in (1, -1):
                    if all(s * x <= 0 for x in sides):
                        top = max(abs(x) for x in normal)
                        key = (*(s * x / top for x in normal), s * d / top)
                        planes[key] = plane(key[:3], key[3])
    return list(planes.values())


BOX_FACES = "[[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]"


def box_mesh(x: F, y: F, z: F) -> Body:
    corners = tuple((sx * x / 2, sy * y / 2, sz * z / 2) for sx in (-1, 1) for sy in (-1, 1) for sz in (-1, 1))
    made = polytope(corners, BOX_FACES, False, box(x, y, z).forms)
    return replace(made, feature=lambda rng: box_feature(rng, (x / 2, y / 2, z / 2)))


# ---- random shapes, about `s` large


def number(rng: Random, low: int = 2, high: int = 12, parts: int = 4) -> F:
    return F(rng.randint(low, high), rng.choice((1, 1, 2, parts)))


def any_sphere(rng: Random, s: F) -> Body:
    return sphere(s * number(rng))


def any_ellipsoid(rng: Random, s: F) -> Body:
    """Two places to touch in every plane of two axes have rational unit normals: the radii are chosen to that end."""
    (c0, s0), (c1, s1) = rng.choice(ANGLES), rng.choice(ANGLES)  # of the place, of the normal
    a = s * number(rng)
    c = a * (s0 / c0) * (c1 / s1)  # normal (c0 / a, s0 / c) along (c1, s1)
    b = rng.choice((a, c, s * number(rng)))
    slots = rng.sample(range(3), 3)

    def feature(rng: Random) -> Feature:
        u, v = [F(0)] * 3, [F(0)] * 3
        if rng.random() < 0.3:
            k, sign = rng.randrange(3), rng.choice((1, -1))
            u[k], v[k] = sign * radii[k], F(sign)
        else:
            p, q = rng.choice((1, -1)), rng.choice((1, -1))
            u[slots[0]], u[slots[1]] = p * a * c0, q * c * s0
            v[slots[0]], v[slots[1]] = p * c1, q * s1
        return Feature(tuple(u), tuple(v), "point", True)  # type: ignore[arg-type]

    radii = [F(0)] * 3
    radii[slots[0]], radii[slots[1]], radii[slots[2]] = a, c, b
    return ellipsoid(*radii, feature=feature)


def any_cylinder(rng: Random, s: F) -> Body:
    a = s * number(rng)
    return cylinder(a, a if rng.random() < 0.7 else s * number(rng), s * number(rng))


def any_cone(rng: Random, s: F) -> Body:
    c, n = rng.choice(ANGLES)
    k = s * number(rng)
    return frustum(k * n, F(0), k * c, (c, n))


def any_frustum(rng: Random, s: F) -> Body:
    c, n = rng.choice(ANGLES)
    k, top = s * number(rng), s * number(rng, 1, 6)
    return frustum(top + k * n, top, k * c, (c, n)) if rng.random() < 0.6 else frustum(top, top + k * n, k * c, (c, -n))


def any_paraboloid(rng: Random, s: F) -> Body:
    a = number(rng, 1, 4)
    k = root_exact(s)
    b = a if rng.random() < 0.7 else number(rng, 1, 4)
    return paraboloid(k * a, k * b, s * number(rng))


def root_exact(s: F) -> F:
    """Of the largest power of four that is no more than s."""
    k = 0
    while F(4) ** (k + 1) <= s:
        k += 1
    while F(4) ** k > s:
        k -= 1
    return F(2) ** k


def any_cap(rng: Random, s: F) -> Body:
    """A cap of a hyperboloid of two sheets with a rational unit normal on its side."""
    (cosine, sine), (up, out) = rng.choice(ANGLES), rng.choice(ANGLES)
    c = s * number(rng)
    a = c * sine * up / out  # (c / a) sine = out / up
    z = c / cosine
    h = z * (1 + F(rng.randint(1, 4), 4))

    def feature(rng: Random) -> Feature:
        what = rng.choice(("tip", "side", "side", "top"))
        if what == "tip":
            return Feature((F(0), F(0), c), (F(0), F(0), F(-1)), "point", True)
        if what == "top":
            return Feature((F(0), F(0), h), (F(0), F(0), F(1)), "face", True)
        x, y = _rim(rng)
        r = a * sine / cosine
        return Feature((r * x, r * y, z), (out * x, out * y, -up), "point", True)

    return hyperboloid(a, a, c, h, 2, feature)


def any_box(rng: Random, s: F) -> Body:
    return box(s * number(rng), s * number(rng), s * number(rng))


def any_point(rng: Random, s: F) -> Body:
    return polytope([(F(0), F(0), F(0))])


def any_edge(rng: Random, s: F) -> Body:
    return polytope([(F(0), F(0), F(0)), (s * number(rng), F(0), F(0))])


def any_triangle(rng: Random, s: F) -> Body:
    a, b, c = s * number(rng), s * number(rng), s * F(rng.randint(-6, 6), 2)
    return polytope([(F(0), F(0), F(0)), (a, F(0), F(0)), (c, b, F(0))], "[[0, 1, 2]]")


def any_box_mesh(rng: Random, s: F) -> Body:
    return box_mesh(s * number(rng), s * number(rng), s * number(rng))


def any_tetrahedron(rng: Random, s: F) -> Body:
    a, b, c = s * number(rng), s * number(rng), s * number(rng)
    x, y = s * F(rng.randint(-4, 8), 4), s * F(rng.randint(-4, 8), 4)
    corners = [(F(0), F(0), F(0)), (a, F(0), F(0)), (F(0), b, F(0)), (x, y, c)]
    return polytope(corners, "[[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]", False)


def any_octahedron(rng: Random, s: F) -> Body:
    a, b, c = s * number(rng), s * number(rng), s * number(rng)
    zero = F(0)
    corners = [(a, zero, zero), (-a, zero, zero), (zero, b, zero), (zero, -b, zero), (zero, zero, c), (zero, zero, -c)]
    faces = "[[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]"
    return polytope(corners, faces, False)


def any_half_space(rng: Random, s: F) -> Body:
    return half_space(ex.unit(rng), s * rng.randint(-3, 3), s)


def any_quadric(rng: Random, s: F) -> Body:
    """Unbounded: double cones, cylinders, slabs, wedges, saddles, hyperboloids, at times without a centre."""
    signs = rng.choice(((1, 1, -1, 0), (1, 1, 0, -1), (1, 0, 0, -1), (1, -1, 0, 0), (1, 1, -1, -1), (1, 1, -1, 1),
                        (-1, -1, -1, 1), (1, -1, 0, 1), (1, -1, 0, 0)))
    weights = [F(x) * F(rng.randint(1, 5), rng.choice((1, 2, 4))) ** 2 for x in signs[:3]]
    rng.shuffle(weights)
    q = diagonal(*weights, signs[3] * (s * number(rng)) ** 2)  # squares: of rank 2 the planes are rational
    if 0 in weights and rng.random() < 0.4:
        k = weights.index(0)
        q[k][3] = q[3][k] = s * rng.choice((1, -1)) * number(rng)
    if rng.random() < 0.5:
        q = pulled(q, ex.inverse(ex.bringing(ex.unit(rng), ex.unit(rng), rng)))
    name = f"fc.quadric({ex.texts(q)})"
    return Body(name, 8 * s, (q,), ("form", 0), kind="quadric", bounded=False)


def any_notch(rng: Random, s: F) -> Body:
    """A prism over an L: the block [0, x] x [0, y] less [u, x] x [v, y]; touched at corners and faces of its hull."""
    u, v, z = s * number(rng), s * number(rng), s * number(rng)
    x, y = u + s * number(rng), v + s * number(rng)
    outline = ((F(0), F(0)), (x, F(0)), (x, v), (u, v), (u, y), (F(0), y))
    corners = tuple((p, q, h) for h in (F(0), z) for p, q in outline)
    sides = ", ".join(f"[{i}, {(i + 1) % 6}, {(i + 1) % 6 + 6}, {i + 6}]" for i in range(6))
    faces = f"[[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], {sides}]"
    forms = [plane((-1, 0, 0), 0), plane((0, -1, 0), 0), *slab(F(0), z)]
    forms += [plane((1, 0, 0), x), plane((0, 1, 0), v), plane((1, 0, 0), u), plane((0, 1, 0), y)]
    both = [("and", ("form", 4), ("form", 5)), ("and", ("form", 6), ("form", 7))]
    tree = ("and", *(("form", k) for k in range(4)), ("or", *both))
    return _hulled(corners, faces, tuple(forms), tree)


def any_open_box(rng: Random, s: F) -> Body:
    """A box without its top: a surface; touched at corners."""
    made = any_box_mesh(rng, s)
    return _hulled(made.corners, BOX_FACES.replace(", [1, 5, 7, 3]", ""), made.forms, made.tree)


def _hulled(corners: tuple[Vector, ...], faces: str, forms: tuple[Matrix, ...], tree: Tree) -> Body:
    """A mesh that is not convex: its places to touch are corners of its hull."""
    hull = polytope(corners, faces, False, forms)

    def feature(rng: Random) -> Feature:
        n = ex.unit(rng)
        best = max(ex.dot(n, p) for p in corners)
        top = [p for p in corners if ex.dot(n, p) == best]
        kind = ("point", "line", "face")[min(3, len(top)) - 1]
        return Feature(rng.choice(top), n, kind, False, ex.sub(top[1], top[0]) if kind == "line" else None)

    return replace(hull, tree=tree, feature=feature, convex=False)


SOLIDS: tuple[Callable[[Random, F], Body], ...] = (
    any_sphere, any_ellipsoid, any_cylinder, any_cone, any_frustum, any_paraboloid, any_cap, any_box)
FLATS: tuple[Callable[[Random, F], Body], ...] = (any_point, any_edge, any_triangle)
MESHES: tuple[Callable[[Random, F], Body], ...] = (*FLATS, any_box_mesh, any_tetrahedron, any_octahedron)
CREASED: tuple[Callable[[Random, F], Body], ...] = (any_notch, any_open_box)
"""Not convex; to land with only."""
