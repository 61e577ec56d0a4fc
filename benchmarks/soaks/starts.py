"""How two bodies share points at the start: shallow overlaps and gaps along a common normal, one body inside the other,
tangency from inside, along lines and circles; and grazes, in which they only touch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction as F
from random import Random
from typing import Any

from . import exact as ex
from . import solid_shapes as sh
from .landing import (
    KINDS,
    Maker,
    Touch,
    calls,
    flipped,
    gap,
    path,
    program,
    rational_motion,
    scales,
    speed,
    touch,
)
from .paths import Shift, Steps, Turn
from .scene import Scene
from .solid_shapes import Body
from .verdicts import Posed, Truth

DEPTHS = tuple(F(1, 10**k) for k in (1, 3, 5, 7, 9, 11, 13, 15, 18)) + (F(1, 2**30), F(1, 2**52))


def shallow(rng: Random, makers: Sequence[Maker], others: Sequence[Maker]) -> Scene:
    """Overlapping, touching or apart by a tiny depth along the normal, then parting, deepening or sliding."""
    while True:
        s, sa, sb = scales(rng)
        t = touch(rng, makers, others, s, sa, sb)
        if rng.random() < 0.5:
            t = Touch(t.b, t.a, t.on_b, t.on_a, t.point, ex.scale(-1, t.normal))
        size = min(x.size for x in (t.a, t.b) if x.size)
        unit = ex.scale(1 / F(max(map(abs, t.normal))), t.normal)
        depth = rng.choice((0, 0, 1, 1, 1, -1)) * rng.choice(DEPTHS) * size / 16
        a, b = t.a.placed(ex.shifting(ex.scale(-depth, unit))), t.b
        initial = "touching" if not depth else None
        if depth > 0:
            initial = _shallow_initial(t, a, b, ex.scale(depth, unit))
            if initial is None:
                continue
        course = rng.choice(("parting", "deepening", "sliding", "turning", "still"))
        k = s * rng.choice((1, 4, F(1, 2)))
        motion: Any = Shift(ex.scale(k * {"parting": 1, "deepening": -1}.get(course, 0), unit))
        if course == "sliding":
            motion = Shift(_across(rng, t.normal, k))
        if course == "turning":
            if depth < 0:
                continue
            kind = rng.choice(KINDS[1:4])
            motion = path(rng, kind, F(1), t, s)
        if isinstance(motion, Steps):
            continue
        moving = Posed(a, motion), Posed(b)
        if rng.random() < 0.2 and course in ("parting", "deepening", "sliding"):
            common = speed(rng, s)
            moving = Posed(a, Shift(ex.add(motion.vector, common))), Posed(b, Shift(common))  # type: ignore[attr-defined]
        status, time = "INITIAL_CONTACT", None
        if depth < 0:
            status = "FREE"
            if course == "deepening":
                status, time = "CONTACT", -depth / k
                if time > 1:
                    continue
        p, q, normal = flipped(rng, *moving, t.one_normal if status == "CONTACT" else None)
        truth = Truth(status, (F(0), F(1)), p, q, time, initial=initial, normal=normal)
        expected = None
        if course == "parting" and depth >= 0 and t.on_a.kind == t.on_b.kind == "point":
            expected = [(F(0), depth / k)] if depth / k < 1 else None
        elif course == "parting" and depth < 0 or course == "sliding" and depth < 0:
            expected = []
        written = rng.choice((None, (F(0), F(1))))
        if p.motion.kind == q.motion.kind == "rest":
            continue
        return Scene(program(rng, p, q, written), motion.kind, calls(rng, truth, expected, rational_motion(p, q)))


def _across(rng: Random, normal: ex.Vector, k: F) -> ex.Vector:
    v = ex.cross(normal, ex.unit(rng))
    if not any(v):
        return _across(rng, normal, k)
    return ex.scale(k / F(max(map(abs, v))), v)


def _shallow_initial(t: Touch, a: Body, b: Body, by: ex.Vector) -> str | None:
    """Of a, shifted by -by from where it touches b; None where that is not certain."""
    for flat, other in ((a, b), (b, a)):
        if flat.flat:
            corners = [ex.apply(flat.place, c) for c in flat.corners]
            sides = [other.side(c) for c in corners]
            if all(x > 0 for x in sides):
                return "containment"
            return "overlapping" if any(x > 0 for x in sides) else None
    if not a.support or not b.support:
        return None
    for share in (F(1, 2), F(1, 3), F(3, 4), F(1, 16)):
        inside = ex.sub(t.point, ex.scale(share, by))
        if a.side(inside) > 0 and b.side(inside) > 0:
            break
    else:
        return None
    n = [float(x) for x in t.normal]
    deep = float(ex.dot(t.normal, by))
    if min(x.reach(n) + x.reach([-v for v in n]) for x in (a, b)) < 4 * deep:
        return None
    return "overlapping"


def graze(rng: Random, makers: Sequence[Maker], others: Sequence[Maker]) -> Scene:
    """Bodies that touch at one instant and do not press: the way is along the plane between them at that time."""
    while True:
        s, sa, sb = scales(rng)
        t = touch(rng, makers, others, s, sa, sb)
        if rng.random() < 0.5:
            t = Touch(t.b, t.a, t.on_b, t.on_a, t.point, ex.scale(-1, t.normal))
        if "point" not in (t.on_a.kind, t.on_b.kind) or "face" in (t.on_a.kind, t.on_b.kind):
            continue
        when = rng.choice((F(1, 2), F(1, 4), F(3, 4), F(1, 3), F(3, 5), F(1)))
        kind = rng.choice(("translation", "translation", "turning", "spinning"))
        along = t.on_a.along if t.on_a.kind == "line" else t.on_b.along if t.on_b.kind == "line" else None
        if kind == "translation":
            if along is not None:  # placed features are not kept; along lines the place is asked from the bodies
                body, feature = (t.a, t.on_a) if t.on_a.kind == "line" else (t.b, t.on_b)
                along = ex.turn(body.place, feature.along) if not body.corners else None
                if along is None:
                    continue
            v = _across(rng, t.normal, s * rng.choice((2, 5, 20)))
            if along is not None and not any(ex.cross(v, along)):
                continue
            motion: Any = Shift(v)
        elif along is not None:
            continue
        elif kind == "spinning":  # about a line along the normal
            unit = _unit_along(t.normal)
            if unit is None:
                continue
            near = tuple(t.point[i] + s * F(rng.randint(-8, 8), 2) for i in range(3))
            motion = Turn(unit, near, F(rng.choice((1, 2, 3, -1, -2, -3)), 4) / when)
            if not any(ex.cross(ex.sub(near, t.point), t.normal)) or abs(motion.turns) >= 1:
                continue
        else:  # about a line that meets the common normal: the point of contact moves along the plane
            axis = ex.unit(rng)
            near = ex.add(t.point, ex.scale(s * rng.choice((-4, -2, 2, 3)) / F(max(map(abs, t.normal))), t.normal))
            motion = Turn(axis, near, F(rng.choice((1, 2, 3, -1, -2, -3)), 4) / when)
        a, b = Posed(t.a.placed(ex.inverse(motion.pose(when))), motion), Posed(t.b)
        level = ex.dot(t.normal, t.point)
        start, end = F(0), F(1)
        if kind == "turning":
            window = _grazes(a, b, t.normal, level, when)
            if window is None:
                continue
            start, end = window
        truth_a, truth_b, _ = flipped(rng, a, b, None)
        truth = Truth("CONTACT", (start, end), truth_a, truth_b, when, graze=True)
        exactly = kind != "turning" or rng.random() < 0.5
        written = (start, end) if kind == "turning" or rng.random() < 0.3 else None
        return Scene(program(rng, truth_a, truth_b, written), a.motion.kind,
                     calls(rng, truth, [(when, when)], exactly))


def _unit_along(n: ex.Vector) -> ex.Vector | None:
    square = ex.dot(n, n)
    r = ex.root(square)
    rounded = r.limit_denominator(10**9)
    return ex.scale(1 / rounded, n) if rounded and rounded * rounded == square else None


def _grazes(a: Posed, b: Posed, normal: ex.Vector, level: F, when: F) -> tuple[F, F] | None:
    """A span around `when`, less than a turn to each side, in which the plane is clear of a at all other times, by a
    parabola's room."""
    size = ex.length(normal) * float(min(x.body.size for x in (a, b) if x.body.size))
    for wide in (F(1), F(1, 2), F(1, 8), F(1, 32)):
        if wide * abs(a.motion.turns) < 1 and all(
            gap(a, b, normal, level, float(when + sign * wide * F(k, 40))) > 0.02 * size * (wide * k / 40) ** 2
            for k in range(1, 41) for sign in (1, -1)
        ):
            start, end = F(int((when - wide) * 64), 64), F(int((when + wide) * 64), 64)
            return (start, end) if start < when < end else None
    return None


# ---- one inside the other, tangent, equal


def nested(rng: Random, makers: Sequence[Maker], others: Sequence[Maker]) -> Scene:
    """A small body strictly inside a convex one."""
    while True:
        s = F(4) ** rng.choice((0, 0, 0, rng.randint(-20, 20)))
        b = rng.choice(others)(rng, s)
        a = rng.choice(makers)(rng, s * F(1, 4) ** rng.randint(1, 4))
        if b.flat:
            continue
        turn = ex.bringing(ex.unit(rng), ex.unit(rng), rng)
        low, high = _bounds(b)
        centre = tuple((low[i] + high[i]) / 2 + (high[i] - low[i]) * F(rng.randint(-3, 3), 10) for i in range(3))
        al, ah = _bounds(a)
        a = a.placed(ex.product(ex.shifting(centre), ex.product(turn, ex.shifting(ex.scale(F(-1, 2), ex.add(al, ah))))))
        corners = [ex.apply(a.place, (x, y, z)) for x in (al[0], ah[0]) for y in (al[1], ah[1]) for z in (al[2], ah[2])]
        if not all(b.side(c) > 0 for c in corners):
            continue
        outer = ex.bringing(ex.unit(rng), ex.unit(rng), rng) if rng.random() < 0.5 else ex.IDENTITY
        a, b = a.placed(outer), b.placed(outer)
        return _start(rng, a, b, "containment", s)


def _bounds(body: Body) -> tuple[ex.Vector, ex.Vector]:
    """Of the shape in its place, a little wider, rational."""
    axes = [[float(i == k) for i in range(3)] for k in range(3)]
    room = body.size / 2**20
    high = tuple(F(body.reach(e)) + room for e in axes)
    low = tuple(-F(body.reach([-x for x in e])) - room for e in axes)
    return low, high  # type: ignore[return-value]


def _start(rng: Random, a: Body, b: Body, initial: str, s: F, expected: object = None) -> Scene:
    near = Touch(a, b, None, None, (F(0),) * 3, (F(0), F(0), F(1)))  # type: ignore[arg-type]
    kind = rng.choice(("translation", "translation", "rotation", "screw", "rational"))
    motion = path(rng, kind, F(1), near, s)
    pa, pb = (Posed(a, motion), Posed(b)) if rng.random() < 0.6 else (Posed(a), Posed(b, motion))
    if rng.random() < 0.15:
        pa, pb = Posed(a, motion), Posed(b, motion)
    p, q, _ = flipped(rng, pa, pb, None)
    truth = Truth("INITIAL_CONTACT", (F(0), F(1)), p, q, initial=initial)
    common = p.motion == q.motion
    return Scene(program(rng, p, q, None), "in common" if common else kind,
                 calls(rng, truth, [(F(0), F(1))] if common else None, kind != "screw"))


def _placed_both(rng: Random, a: Body, b: Body, s: F) -> tuple[Body, Body]:
    move = ex.bringing(ex.unit(rng), ex.unit(rng), rng) if rng.random() < 0.5 else ex.IDENTITY
    if rng.random() < 0.4:
        move = ex.product(ex.shifting(speed(rng, s)), move)
    return a.placed(move), b.placed(move)


def _at(*v: F) -> ex.Matrix:
    return ex.shifting(v)


def known_start(rng: Random, meshes: bool = False) -> Scene:
    """Tangency along lines and circles, from inside and outside; equal bodies; parts that fit."""
    s = F(4) ** rng.choice((0, 0, 0, rng.randint(-20, 20)))
    r, q, h = (s * sh.number(rng) for _ in range(3))
    big = r + q
    c, n = rng.choice(sh.ANGLES)
    u = ex.unit(rng)
    up = (F(0), F(0), F(1))
    box, mesh = sh.box, sh.box_mesh

    def lifted(body: Body, x: F, y: F, z: F) -> Body:
        return body.placed(_at(x, y, z))

    zero = F(0)
    ring = sh.combined("-", sh.cylinder(big, big, h), sh.cylinder(r, r, 2 * h))
    plate = sh.combined("-", box(4 * big, 4 * big, h), sh.cylinder(r, r, 2 * h))
    cup = sh.combined("-", box(4 * big, 4 * big, 4 * big), sh.sphere(r))
    a_box = rng.choice((box, mesh)) if meshes else box
    choices: list[Callable[[], tuple[Body, Body, str]]] = [
        lambda: (sh.sphere(r), sh.sphere(r), "overlapping"),
        lambda: (sh.sphere(r), sh.ellipsoid(r, r, r), "overlapping"),
        lambda: (sh.cylinder(r, r, h), sh.cylinder(r, r, h), "overlapping"),
        lambda: (sh.frustum(r, zero, h), sh.frustum(r, zero, h), "overlapping"),
        lambda: (sh.sphere(q).placed(_at(*ex.scale(big - q, u))), sh.sphere(big), "overlapping"),
        lambda: (sh.sphere(q).placed(_at(*ex.scale(big + q, u))), sh.sphere(big), "touching"),
        lambda: (sh.sphere(r), sh.cylinder(r, r, 4 * r), "overlapping"),  # along a circle
        lambda: (lifted(sh.sphere(q), r, zero, h / 4), sh.cylinder(big, big, h + 4 * big), "overlapping"),
        lambda: (lifted(sh.sphere(q), big + q, zero, h / 4), sh.cylinder(big, big, h), "touching"),
        lambda: (lifted(sh.cylinder(q, q, h), c * (r + q), n * (r + q), h / 3), sh.cylinder(r, r, h), "touching"),
        lambda: (lifted(sh.cylinder(q, q, h), c * r, n * r, zero), sh.cylinder(big, big, h), "overlapping"),
        lambda: (sh.cylinder(r, r, h), sh.cylinder(r, r, 2 * h), "overlapping"),
        lambda: (lifted(sh.cylinder(r, r, h), zero, zero, h), sh.cylinder(r, r, h), "touching"),
        lambda: (lifted(sh.cylinder(q, q, h), zero, zero, h), sh.cylinder(big, big, h), "touching"),
        lambda: (sh.cylinder(r * c, r * c, 2 * r * n), sh.sphere(r), "overlapping"),  # rims on the sphere
        lambda: (a_box(r * F(2, 3), r * F(4, 3), r * F(4, 3)), sh.sphere(r), "overlapping"),  # corners on the sphere
        lambda: (a_box(2 * r * c, 2 * r * n, h), sh.cylinder(r, r, 2 * h), "overlapping"),  # edges on the side
        lambda: (a_box(2 * r, 2 * r, h), sh.cylinder(r, r, h), "overlapping"),
        lambda: (lifted(a_box(2 * r, 2 * r, h), 2 * r, zero, zero), sh.cylinder(r, r, h), "touching"),  # along a line
        lambda: (lifted(a_box(2 * r, 2 * r, h), r + big, zero, zero), sh.sphere(big), "touching"),
        lambda: (lifted(a_box(r, r, h), r / 2, r / 2, -h / 2), sh.frustum(r, q, h), "touching"),
        lambda: (sh.cylinder(r, r, h), plate, "touching"),  # the pin fits
        lambda: (sh.cylinder(r, r, 4 * h), ring, "touching"),
        lambda: (sh.sphere(r), ring, "touching"),
        lambda: (sh.sphere(r), cup, "touching"),
        lambda: (lifted(sh.sphere(r / 3), *ex.scale(r * F(2, 3), u)), cup, "touching"),
        lambda: (lifted(sh.sphere(r / c), zero, zero, h / 2 + r * n / c), plate, "touching"),  # rests on the rim
        lambda: (a_box(2 * r * c, 2 * r * n, h), plate, "touching"),  # edges on the bore
        lambda: (lifted(sh.frustum(r, zero, r), zero, zero, -r - h / 2), sh.cylinder(q, q, h), "touching"),  # tip
        lambda: (sh.frustum(zero, r, r), lifted(sh.frustum(q, zero, q), zero, zero, -q), "touching"),
        lambda: (lifted(sh.sphere(q), zero, zero, q), sh.half_space(up, 0), "touching"),
        lambda: (lifted(sh.sphere(q), zero, zero, -q), sh.half_space(up, 0), "overlapping"),
        lambda: (sh.cylinder(q, q, h).placed(_at(zero, zero, -h)), sh.half_space(up, 0), "containment"),
    ]
    if meshes:
        point = sh.polytope([(zero, zero, zero)])
        rod = sh.polytope([(r * c, r * n, -h / 4), (r * c, r * n, h / 4)])
        chord = sh.polytope([ex.scale(r, u), ex.scale(r, ex.scale(-1, (u[1], u[2], u[0])))])
        sheet = sh.polytope([(-r, -r, zero), (r, -r, zero), (zero, r, zero)], "[[0, 1, 2]]")
        choices += 2 * [
            lambda: (point.placed(_at(*ex.scale(r, u))), sh.sphere(r), "touching"),
            lambda: (point, sh.sphere(r), "containment"),
            lambda: (point.placed(_at(zero, zero, h)), sh.frustum(r, zero, h), "touching"),
            lambda: (point.placed(_at(r, zero, h / 2)), sh.cylinder(r, r, h), "touching"),
            lambda: (point.placed(_at(r * c, r * n, zero)), plate, "touching"),
            lambda: (rod, sh.cylinder(r, r, h), "touching"),
            lambda: (rod, plate, "touching"),
            lambda: (chord, sh.sphere(r), "overlapping"),
            lambda: (mesh(r, q, h), box(r, q, h), "overlapping"),
            lambda: (mesh(r, q, h).placed(_at(r, zero, zero)), box(r, q, h), "touching"),
            lambda: (mesh(r, q, h).placed(_at(r, q, h)), box(r, q, h), "touching"),
            lambda: (mesh(r / 2, q / 2, h / 2), box(r, q, h), "containment"),
            lambda: (box(r / 2, q / 2, h / 2), mesh(r, q, h), "containment"),
            lambda: (sh.sphere(r), mesh(2 * r, 4 * r, 4 * r), "overlapping"),
            lambda: (sh.sphere(r), mesh(3 * r, 4 * r, 4 * r), "containment"),
            lambda: (sh.cylinder(r, r, h), mesh(2 * r, 3 * r, 2 * h), "overlapping"),
            lambda: (lifted(sheet, zero, zero, h / 2), sh.cylinder(q, q, h), "touching"),
        ]
    while True:
        a, b, initial = rng.choice(choices)()
        if not meshes or a.corners or b.corners:
            break
    if b.bounded:
        a, b = _placed_both(rng, a, b, s)
    return _start(rng, a, b, initial, s)
