"""Balls: contact is a distance of the centre, so times are in closed form (or roots of one convex function).

Along straight ways against balls, half-spaces, boxes, cylinders; on circles and helices against balls, half-spaces and
cylinders along the axis, where the distance is a constant and one cosine; through waists and holes.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction as F
from functools import partial
from random import Random
from typing import Any

from flint import arb, ctx, fmpq

from . import exact as ex
from . import solid_shapes as sh
from .landing import calls, flipped, program
from .paths import Shift, Steps, Turn
from .scene import Scene
from .verdicts import Posed, Truth

CLOSE = F(1, 2**150)


def _scale(rng: Random) -> F:
    return F(4) ** rng.choice((0, 0, 0, 0, rng.randint(-3, 3), rng.randint(-20, 20)))


# ---- straight ways


def square_gap(kind: str, sizes: tuple[F, ...], p: ex.Vector) -> F:
    """Square of the distance from p to a body about the origin, from outside; 0 within.  For cylinders to 180 bits."""
    if kind == "box":
        over = [max(F(0), abs(p[i]) - sizes[i] / 2) for i in range(3)]
    else:
        over = [max(F(0), ex.root(p[0] ** 2 + p[1] ** 2, 180) - sizes[0]), max(F(0), abs(p[2]) - sizes[1] / 2), F(0)]
    return ex.dot(over, over)


def entry(excess: Callable[[F], F]) -> tuple[F, F] | None | str:
    """First and last time in [0, 1] at which a convex function is <= 0; None if never, "near" too near a graze."""
    lo, hi = 0.0, 1.0
    for _ in range(60):
        x, y = lo + (hi - lo) / 3, hi - (hi - lo) / 3
        lo, hi = (lo, y) if excess(F(x)) < excess(F(y)) else (x, hi)
    low = min((F(0), F(1), F(lo)), key=excess)
    least, top = excess(low), max(excess(F(0)), excess(F(1)))
    if least > 0:
        return "near" if least < top / 10**6 else None
    if -least < top / 10**6:
        return "near"
    ends = []
    for out in (F(0), F(1)):
        if excess(out) <= 0:
            ends.append(out)
            continue
        a, b = out, low
        for _ in range(80):
            m = (a + b) / 2
            a, b = (a, m) if excess(m) <= 0 else (m, b)
        ends.append(b)
    return ends[0], ends[1]


def _excess(kind: str, sizes: tuple[F, ...], p: ex.Vector, v: ex.Vector, r: F, t: F) -> F:
    return square_gap(kind, sizes, ex.add(p, ex.scale(t, v))) - r * r


def straight(rng: Random, meshes: bool = False) -> Scene:
    """A ball on a straight way past a box or cylinder: over faces, sides, edges, corners and rims."""
    while True:
        s = _scale(rng)
        r = s * sh.number(rng) * rng.choice((1, 1, F(1, 16), F(1, 1024), 64))
        kind = "box" if meshes else rng.choice(("box", "cylinder"))
        sizes = tuple(s * sh.number(rng) for _ in range(3 if kind == "box" else 2))
        body = (sh.box_mesh if meshes else sh.box)(*sizes) if kind == "box" else sh.cylinder(sizes[0], *sizes)
        aim = tuple(F(rng.randint(-4, 4), 4) * x for x in (sizes if kind == "box" else (sizes[0], sizes[0], sizes[1])))
        v = tuple((r + s) * F(rng.randint(-16, 16)) for _ in range(3))
        if not any(v):
            continue
        p = ex.sub(aim, ex.scale(F(rng.randint(1, 9), 10), v))
        if rng.random() < 0.3:
            p = ex.add(p, ex.scale(r, ex.unit(rng)))

        excess = partial(_excess, kind, sizes, p, v, r)
        when = entry(excess)
        if when == "near" or excess(F(0)) == 0 or excess(F(1)) == 0:
            continue
        place = ex.bringing(ex.unit(rng), ex.unit(rng), rng) if rng.random() < 0.5 else ex.IDENTITY
        if rng.random() < 0.4:
            place = ex.product(ex.shifting(tuple(s * F(rng.randint(-9, 9), 2) for _ in range(3))), place)
        motion = Shift(ex.turn(place, v))
        ball, other = Posed(sh.sphere(r).placed(ex.shifting(ex.apply(place, p))), motion), Posed(body.placed(place))
        if other.body.corners and rng.random() < 0.5:
            other = Posed(other.body.baked())
        if rng.random() < 0.2:
            common = tuple(s * F(rng.randint(-9, 9)) for _ in range(3))
            ball = Posed(ball.body, Shift(ex.add(motion.vector, common)))
            other = Posed(other.body, Shift(common))  # type: ignore[arg-type]
        return _asked(rng, ball, other, [when] if isinstance(when, tuple) else [], F(1, 2**70))


def _asked(rng: Random, a: Posed, b: Posed, found: list[tuple[F, F]], slack: F, exactly: bool = True,
           initial: str | None = None, span: tuple[F, F] = (F(0), F(1)), written: bool | None = None) -> Scene:
    status, time = "FREE", None
    if found:
        status, time = ("INITIAL_CONTACT", None) if found[0][0] <= span[0] else ("CONTACT", found[0][0])
    a, b, _ = flipped(rng, a, b, None)
    truth = Truth(status, span, a, b, time, slack, initial if status == "INITIAL_CONTACT" else None)
    kind = a.motion.kind if b.motion.kind == "rest" else b.motion.kind
    say = rng.random() < 0.5 if written is None else written
    return Scene(program(rng, a, b, span if say else None), kind, calls(rng, truth, found, exactly, slack))


def straight_balls(rng: Random) -> Scene:
    """Ball and ball, ball and half-space, at times at a graze that is exact."""
    s = _scale(rng)
    r, q = s * sh.number(rng), s * sh.number(rng) * rng.choice((1, 1, F(1, 64), F(1, 65536)))
    big = r + q
    u = ex.unit(rng)
    across = ex.cross(u, (1, 0, 0)) if any(ex.cross(u, (1, 0, 0))) else ex.cross(u, (0, 1, 0))
    v = ex.scale(s * rng.choice((1, 3, 8)) * 4, across)
    when = F(rng.randint(1, 15), 16)
    if rng.random() < 0.5:  # a half-space
        d = s * rng.randint(-3, 3)
        body = sh.half_space(u, d, s)
        k = s * rng.randint(1, 9) * rng.choice((1, 1, -1))
        motion = ex.add(v, ex.scale(-k, u)) if rng.random() < 0.8 else v
        sinks = -ex.dot(motion, u)
        p = ex.sub(ex.scale(d + q, u), ex.scale(when, motion))
        if not sinks:
            found = [(F(0), F(1))]
        else:
            found = [(when, F(1))] if sinks > 0 else [(F(0), when)]
        initial = "touching" if not sinks else "overlapping" if ex.dot(p, u) - d > -q else None
        return _asked(rng, Posed(sh.sphere(q).placed(ex.shifting(p)), Shift(motion)), Posed(body), found, F(0),
                      initial=initial)
    w = ex.sub(v, ex.scale(rng.choice((0, 1, 1, 3)) * s, u))  # v is across u
    p = ex.sub(ex.scale(big, u), ex.scale(when, w))  # they touch at `when`, from outside, or leave one another
    a, b, c = ex.dot(w, w), ex.dot(w, ex.scale(big, u)), F(0)  # |big u + t w|^2 <= big^2
    other = -2 * b / F(a) + c
    ends = sorted((when, when + other))
    found = [(max(F(0), ends[0]), min(F(1), ends[1]))] if ends[1] >= 0 and ends[0] <= 1 else []
    return _asked(rng, Posed(sh.sphere(q).placed(ex.shifting(p)), Shift(w)), Posed(sh.sphere(r)), found, F(0))


# ---- circles and helices


def waves(a: F, b: F, c: F, turns: F, span: tuple[F, F]) -> list[tuple[F, F]] | None:
    """Times of the span at which a cos(x) + b sin(x) <= c, x = 2 pi turns t; to 150 bits.  None near a graze, and
    where one may end or begin at the span's own ends."""
    top = ex.root(a * a + b * b, 200)
    if not top or abs(abs(c) - top) < top / 10**4:
        return None
    if c > top:
        return [span]
    if c < -top:
        return []
    before, ctx.prec = ctx.prec, 260
    try:
        full = 2 * arb.pi()
        phase = arb.atan2(_arb(b), _arb(a)) / full
        half = (_arb(c) / _arb(top)).acos() / full
        low, high = ex.fraction(phase + half), ex.fraction(phase - half) + 1  # within a turn: low <= x <= high
    finally:
        ctx.prec = before
    lo, hi = (turns * t for t in span)
    flip = turns < 0
    if flip:
        lo, hi = hi, lo
    found = []
    for k in range(int(lo) - 3, int(hi) + 4):
        p, q = max(lo, low + k), min(hi, high + k)
        if min(abs(hi - low - k), abs(high + k - lo)) < F(1, 2**150):
            return None
        if p <= q:
            found.append((p / turns, q / turns) if not flip else (q / turns, p / turns))
    return sorted(found)


def _arb(x: F) -> arb:
    return arb(fmpq(x.numerator, x.denominator))


def circling(rng: Random, meshes: bool = False) -> Scene:
    """A ball (or point) that turns about an axis, or on a helix, against a ball, a half-space, a parallel cylinder."""
    while True:
        s = _scale(rng)
        u, o = ex.unit(rng), tuple(s * F(rng.randint(-4, 4), 2) for _ in range(3))
        turns = rng.choice((F(1), F(1, 2), F(2, 3), F(-1), F(-3, 4), F(5, 2), F(1, 7), F(-1, 12), F(9, 10)))
        r = F(0) if meshes else s * sh.number(rng, 1, 6) * rng.choice((1, 1, F(1, 64)))
        w = tuple(s * F(rng.randint(-12, 12)) for _ in range(3))
        p = ex.add(o, w)
        axial = ex.dot(w, u)
        flat = ex.sub(w, ex.scale(axial, u))
        side = ex.cross(u, w)
        if not any(flat):
            continue
        what = rng.choice(("ball", "half-space", "half-space", "cylinder", "cylinder", "bore"))
        advance = None
        if what == "half-space":
            n, d = ex.unit(rng), s * F(rng.randint(-12, 12), 2)
            if not any(ex.cross(n, u)):
                continue
            a, b = ex.dot(n, flat), ex.dot(n, side)
            c = d + r - ex.dot(n, ex.add(o, ex.scale(axial, u)))
            other = sh.half_space(n, d, s)
        else:
            q = s * sh.number(rng)
            x = tuple(s * F(rng.randint(-12, 12)) for _ in range(3))  # the centre, from o
            height, level = s * 400, ex.dot(x, u)
            x_flat = ex.sub(x, ex.scale(level, u))
            if what == "bore":
                q += r
            if what in ("cylinder", "bore"):
                advance = s * F(rng.randint(-40, 40)) if rng.random() < 0.5 else None
                x = x_flat
                gap = F(0)
                z = ex.bringing((F(0), F(0), F(1)), u, rng)
                other = sh.cylinder(q, q, height)
                if what == "bore":
                    other = sh.combined("-", sh.cylinder(q + 60 * s, q + 60 * s, height), sh.cylinder(q, q, 2 * height))
                other = other.placed(ex.product(ex.shifting(ex.add(o, x)), z))
            else:
                gap = level - axial
                other = sh.sphere(q).placed(ex.shifting(ex.add(o, x)))
            # |flat cos + side sin - x_flat|^2 + gap^2 <= (q + r)^2
            a, b = -2 * ex.dot(flat, x_flat), -2 * ex.dot(side, x_flat)
            near = q - r if what == "bore" else q + r
            c = near**2 - gap * gap - ex.dot(flat, flat) - ex.dot(x_flat, x_flat)
            if what == "bore":  # the other way round: in contact where the centre is no nearer
                a, b, c = -a, -b, -c
        span = (F(0), F(1))
        if rng.random() < 0.3:
            span = (F(rng.randint(0, 6), 8), F(rng.randint(7, 12), 8))
        found = waves(a, b, c, turns, span)
        if found is None or any(span[1] - x[0] < F(1, 10**6) for x in found) or any(
                0 < abs(x[0] - span[0]) < F(1, 10**6) or x[1] - x[0] < F(1, 10**6) for x in found):
            continue
        if any(y[0] - x[1] < F(1, 10**6) for x, y in zip(found, found[1:], strict=False)):
            continue
        body = sh.polytope([p]) if meshes else sh.sphere(r).placed(ex.shifting(p))
        motion = Turn(u, o, turns, advance, rng.choice((1, 3)), rng.random() < 0.5)
        still = other
        if rng.random() < 0.2:
            a_posed, b_posed = Posed(body), Posed(still, Turn(u, o, -turns, None if advance is None else -advance))
        elif rng.random() < 0.15:
            k = F(rng.randint(-3, 3), 4)
            a_posed = Posed(body, Turn(u, o, turns + k, advance))
            b_posed = Posed(still, Turn(u, o, k)) if k else Posed(still)
            if what == "half-space" and k:
                continue
        else:
            a_posed, b_posed = Posed(body, motion), Posed(still)
        return _asked(rng, a_posed, b_posed, found, F(1, 2**100) * 4, advance is None, span=span,
                      written=True if span != (0, 1) else None)


# ---- holes and waists


def seated(rng: Random) -> Scene:
    """A ball that comes down on the rim of a hole, into a cone's seat or a bowl, along the waist of a hyperboloid."""
    s = _scale(rng)
    c, n = rng.choice(sh.ANGLES)
    r, h = s * sh.number(rng), s * sh.number(rng)
    what = rng.choice(("rim", "rim", "seat", "bowl", "waist", "waist", "tube"))
    wide = 8 * r
    axis = (F(0), F(0), F(1))
    v_drop = s * rng.choice((1, 4, 16)) * F(-1)
    when = F(rng.randint(1, 15), 16)
    normal = None
    move: ex.Vector = ex.scale(v_drop, axis)
    if what == "rim":  # ball of radius r / c over a hole of radius r
        q = r / c
        body = sh.combined("-", sh.box(wide, wide, h), sh.cylinder(r, r, 3 * h))
        rest = (F(0), F(0), h / 2 + r * n / c)
    elif what == "seat":  # in a conical hole, widening upwards: tangent along a circle
        funnel = sh.frustum(r, r + 8 * n * s, 8 * c * s, (c, -n)).placed(ex.shifting((F(0), F(0), -4 * c * s)))
        body = sh.combined("-", sh.box(wide + 40 * s, wide + 40 * s, 8 * c * s), funnel)
        middle = r + 4 * n * s  # radius at z = 0; the ball touches there
        q = middle / c
        rest = (F(0), F(0), q * n)
    elif what == "bowl":  # sideways within a spherical hollow
        q = r / rng.choice((2, 3, F(11, 10), F(1001, 1000), 1 + F(1, 10**9)))
        body = sh.combined("-", sh.box(wide, wide, wide), sh.sphere(r))
        u = ex.unit(rng)
        rest = ex.scale(r - q, u)
        move = ex.scale((r - q) / when, u)  # from the middle
        normal = ex.scale(-1, u)
    elif what == "tube":
        q = r / rng.choice((2, 3, F(11, 10), F(1001, 1000), 1 + F(1, 10**9)))
        body = sh.combined("-", sh.box(wide, wide, 8 * h), sh.cylinder(r, r, 20 * h))
        rest = ((r - q) * c, (r - q) * n, h)
        move = ((r - q) * c / when, (r - q) * n / when, h * rng.choice((0, 1, -1)))
        normal = (-c, -n, F(0))
    else:  # sideways at the waist of x^2/a^2 + y^2/a^2 - z^2/c^2 <= 1, with a radius below c^2/a
        depth = s * sh.number(rng)
        body = sh.hyperboloid(r, r, depth, 4 * depth)
        q = depth * depth / r * rng.choice((F(1, 2), F(9, 10), F(1, 100), F(1)))
        rest = ((r + q) * c, (r + q) * n, F(0))
        move = ex.scale(-s * rng.choice((1, 4, 16)), (c, n, F(rng.choice((0, 0, 1)), 3)))
        if move[2]:
            move = (move[0], move[1], F(0))
        normal = (c, n, F(0))
    start = ex.sub(rest, ex.scale(when, move))
    ball = sh.sphere(q).placed(ex.shifting(start))
    place = ex.bringing(ex.unit(rng), ex.unit(rng), rng) if rng.random() < 0.5 else ex.IDENTITY
    ball, body = ball.placed(place), body.placed(place)
    motion = Shift(ex.turn(place, move))
    if normal is not None:
        normal = ex.turn(place, normal)
    a, b, normal = flipped(rng, Posed(ball, motion), Posed(body), normal)
    truth = Truth("CONTACT", (F(0), F(1)), a, b, when, normal=normal)
    return Scene(program(rng, a, b, None), "translation", calls(rng, truth))


def pinned(rng: Random, meshes: bool = False) -> Scene:
    """A pin in a bore with a clearance of 1e-3 to 1e-12, none, or less; it goes along, turns, shifts sideways."""
    while True:
        s = _scale(rng)
        r, h = s * sh.number(rng), s * sh.number(rng)
        clear = r * rng.choice((*(F(1, 10**k) for k in (3, 6, 9, 12)), F(1, 2**30), F(0), F(-1, 10**3), F(-1, 10**9)))
        c, n = rng.choice(sh.ANGLES)
        q = r - clear
        pin = sh.box_mesh(2 * q * c, 2 * q * n, 4 * h) if meshes else sh.cylinder(q, q, 4 * h)
        if rng.random() < 0.6:
            plate = sh.combined("-", sh.box(8 * r, 8 * r, h), sh.cylinder(r, r, 2 * h))
        else:
            plate = sh.combined("-", sh.cylinder(3 * r, 3 * r, h), sh.cylinder(r, r, 3 * h))
        what = rng.choice(("enters", "enters", "along", "turns", "screws", "sideways", "screws in", "in steps"))
        above = (F(0), F(0), h * F(rng.randint(11, 16), 4))  # lower end at this less 2 h: above the plate's h / 2
        down = -h * 8
        length = above[2] - 2 * h - h / 2  # till the pin's lower end is in the plate's upper face
        status, time, initial, expected, normal = "FREE", None, None, [], None
        motion: Any
        start = (F(0), F(0), F(0))
        if what in ("enters", "screws in", "in steps"):
            start = above
            when = -length / down
            if what == "enters":
                motion = Shift((F(0), F(0), down))
            elif what == "screws in":
                motion = Turn((F(0), F(0), F(1)), (F(0), F(0), F(0)), F(rng.choice((1, 3, -5)), 4), down)
            else:
                first = Turn((F(0), F(0), F(1)), (F(0), F(0), F(0)), F(rng.choice((1, -3)), 4))
                motion = Steps((first, Shift((F(0), F(0), down))), (F(1), F(1)))
                when += 1
            if clear <= 0:
                status, time = "CONTACT", when
            expected = None
        elif what == "sideways":
            if clear <= 0:
                continue
            k = rng.choice((2, 16, 10**6))
            motion = Shift((clear * c * k, clear * n * k, h * rng.choice((0, 0, 1)) / 2))
            status, time, expected = "CONTACT", F(1, k), None
            if meshes:
                time = None  # all four edges are on one circle: the first that leaves it
                m = (motion.vector[0], motion.vector[1])  # type: ignore[attr-defined]
                time = min(_leaves(r, (i * q * c, j * q * n), m) for i in (1, -1) for j in (1, -1))
                if time > 1 or time.denominator > 2**64:
                    continue
            normal = None if meshes else (-c, -n, F(0))
        else:
            if clear < 0:
                status, initial = "INITIAL_CONTACT", "overlapping"
            elif not clear:
                status, initial = "INITIAL_CONTACT", "touching"
            if what == "along":
                motion = Shift((F(0), F(0), h))
            elif what == "turns":
                motion = Turn((F(0), F(0), F(1)), (F(0), F(0), F(0)), F(rng.choice((1, -1, 7)), rng.choice((1, 3))))
            else:
                motion = Turn((F(0), F(0), F(1)), (F(0), F(0), F(0)), F(rng.choice((1, -1, 7)), rng.choice((1, 3))), h)
            expected = [(F(0), F(1))] if clear <= 0 else []
        pin = pin.placed(ex.shifting(start))
        place = ex.bringing(ex.unit(rng), ex.unit(rng), rng) if rng.random() < 0.4 else ex.IDENTITY
        if rng.random() < 0.5:
            place = ex.product(ex.shifting(tuple(s * F(rng.randint(-9, 9), 2) for _ in range(3))), place)
        motion = carried(motion, place)
        a, b, normal = flipped(rng, Posed(pin.placed(place), motion), Posed(plate.placed(place)),
                               None if normal is None else ex.turn(place, normal))
        span = (F(0), F(2)) if what == "in steps" else (F(0), F(1))
        truth = Truth(status, span, a, b, time, initial=initial, normal=normal)
        exactly = "screw" not in what
        return Scene(program(rng, a, b, None), motion.kind, calls(rng, truth, expected, exactly))


def _leaves(r: F, p: tuple[F, F], v: tuple[F, F]) -> F:
    """When p + t v, inside the circle of radius r, reaches it; 2 where that is not rational."""
    a, b, c = v[0] ** 2 + v[1] ** 2, p[0] * v[0] + p[1] * v[1], p[0] ** 2 + p[1] ** 2 - r * r
    disc = b * b - a * c
    root = ex.root(disc, 200)
    return (-b + root) / a


def carried(motion: object, m: ex.Matrix) -> object:
    """The motion as seen after the rigid placement m."""
    if isinstance(motion, Shift):
        return Shift(ex.turn(m, motion.vector))
    if isinstance(motion, Turn):
        return Turn(ex.turn(m, motion.unit), ex.apply(m, motion.point), motion.turns, motion.advance)
    assert isinstance(motion, Steps)
    return Steps(tuple(carried(x, m) for x in motion.steps), motion.durations)
