"""A bare point on a straight way against any solid: all times of contact by quadratic equations.

Along x(t) = p + t v every form of a solid is a quadratic in t, so signs between its roots tell exactly when the point
is in the solid.  Roots that are not rational are known to 60 digits; two that agree so far count as one.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction as F
from math import isqrt
from random import Random

from . import exact as ex
from . import solid_shapes as sh
from .landing import calls, flipped, program
from .paths import Shift
from .scene import Scene
from .solid_shapes import Body
from .verdicts import Posed, Truth

TINY = F(1, 2**190)


@dataclass(frozen=True)
class Root:
    t: F
    exact: bool


def roots(form: ex.Matrix, p: ex.Vector, v: ex.Vector) -> list[Root]:
    """Of the form along p + t v."""
    x, y = (*p, F(1)), (*v, F(0))
    a = sum(form[i][j] * y[i] * y[j] for i in range(4) for j in range(4))
    b = sum(form[i][j] * x[i] * y[j] for i in range(4) for j in range(4))  # half of the coefficient of t
    c = sum(form[i][j] * x[i] * x[j] for i in range(4) for j in range(4))
    if not a:
        return [Root(-c / (2 * b), True)] if b else []
    disc = F(b * b - a * c)
    if disc < 0:
        return []
    n, d = isqrt(disc.numerator), isqrt(disc.denominator)
    if n * n == disc.numerator and d * d == disc.denominator:
        r = F(n, d)
        return [Root((-b - r) / a, True), Root((-b + r) / a, True)]
    r = ex.root(disc, 260)
    return [Root((-b - r) / a, False), Root((-b + r) / a, False)]


def shared(rng: Random, body: Body, p: ex.Vector, v: ex.Vector, start: F, end: F) -> list[tuple[F, F]] | None:
    """The intervals of [start, end] in which p + t v is in the body; None where that cannot be told."""
    forms = body.world_forms()
    found = sorted((r for form in forms for r in roots(form, p, v) if start < r.t < end), key=lambda r: r.t)
    merged: list[Root] = [Root(start, True)]
    for r in [*found, Root(end, True)]:
        if r.t - merged[-1].t < TINY * max(1, abs(r.t)):
            if r.exact != merged[-1].exact:
                return None
            if not r.exact:  # a double root of two forms, or of one with itself
                return None
            continue
        merged.append(r)

    def at(t: F) -> ex.Vector:
        return ex.add(p, ex.scale(t, v))

    within = [body.side(at((x.t + y.t) / 2)) for x, y in zip(merged, merged[1:], strict=False)]
    if 0 in within:
        return None  # runs along a face
    intervals: list[tuple[F, F]] = []
    for k, r in enumerate(merged):
        before = k > 0 and within[k - 1] > 0
        after = k < len(within) and within[k] > 0
        if before:
            intervals[-1] = (intervals[-1][0], r.t)
        elif not after:
            if not r.exact:
                continue  # simple roots of one form: it changes sign there, and nothing else does
            here = body.side(at(r.t))
            if here > 0:
                return None
            if here == 0:
                if not closed(rng, body, at(r.t)):
                    return None
                intervals.append((r.t, r.t))
            continue
        if after and not before:
            intervals.append((r.t, r.t))
    for k, r in enumerate(merged[1:-1], 1):
        if not r.exact and within[k - 1] < 0 > within[k]:
            sides = body.signs_at(at(r.t))
            if body.forms and len(sides) > 1 and body.kind == "csg":
                return None  # a wall between two parts may be there
    return intervals


def closed(rng: Random, body: Body, p: ex.Vector) -> bool:
    """Whether a point inside the body was found next to p: p is no place of a dangling wall."""
    reach = body.size / 2**40
    for _ in range(60):
        step = tuple(reach * F(rng.randint(-64, 64), 64) for _ in range(3))
        if body.side(ex.add(p, step)) > 0:
            return True
    return False


def special(rng: Random, body: Body) -> ex.Vector | None:
    """A rational point on the boundary, on rims, edges and tips more often than not."""
    if body.feature is None:
        return None
    return body.there(body.feature(rng)).point


def drilled(rng: Random, s: F) -> tuple[Body, list[ex.Vector]]:
    """Cylinders that cross: differences and unions with edges of degree 4, and rational points of these edges."""
    (c, n), (d, m) = rng.choice(sh.ANGLES), rng.choice(sh.ANGLES)
    r = s * sh.number(rng)
    y = r * n
    q = y / m  # (r c, y, q d) is on both
    if q > r and rng.random() < 0.7:
        r, q, c, n, d, m = q, r, d, m, c, n
    big = 2 * max(r, q)
    up = sh.cylinder(r, r, 3 * big)
    axes = [[F(0), F(0), F(1), F(0)], [F(0), F(1), F(0), F(0)], [F(-1), F(0), F(0), F(0)], ex.IDENTITY[3]]
    along = sh.cylinder(q, q, 3 * big).placed(axes)
    body = sh.combined(rng.choice(("-", "-", "|", "&")), up, along)
    points = [(i * r * c, j * r * n, k * q * d) for i in (1, -1) for j in (1, -1) for k in (1, -1)]
    return body, points


def any_csg(rng: Random, s: F) -> tuple[Body, list[ex.Vector]]:
    if rng.random() < 0.35:
        return drilled(rng, s)
    a = rng.choice(sh.SOLIDS)(rng, s)
    b = rng.choice(sh.SOLIDS)(rng, s)
    point = special(rng, a)
    assert point
    place = ex.shifting(tuple(point[i] + s * F(rng.randint(-4, 4), 4) for i in range(3)))
    if rng.random() < 0.5:
        place = ex.product(place, ex.bringing(ex.unit(rng), ex.unit(rng), rng))
    b = b.placed(place)
    points = [x for x in (point, special(rng, a), special(rng, b)) if x]
    body = sh.combined(rng.choice(("-", "-", "|", "&")), a, b)
    return (body, points) if any(closed(rng, body, x) for x in points) else any_csg(rng, s)  # else perhaps empty


def pierced(rng: Random, mesh: bool = True) -> Scene:
    while True:
        s = F(4) ** rng.choice((0, 0, 0, rng.randint(-3, 3), rng.randint(-20, 20)))
        points: list[ex.Vector] = []
        what = rng.random()
        if what < 0.5:
            body = rng.choice(sh.SOLIDS)(rng, s)
            place = special(rng, body)
            points = [place] if place else []
        elif what < 0.7:
            body = sh.any_quadric(rng, s)
        else:
            body, points = any_csg(rng, s)
        if rng.random() < 0.5:
            m = ex.bringing(ex.unit(rng), ex.unit(rng), rng)
            if rng.random() < 0.5:
                m = ex.product(ex.shifting(tuple(s * F(rng.randint(-9, 9), 2) for _ in range(3))), m)
            body, points = body.placed(m), [ex.apply(m, p) for p in points]
        # the way: through a special place at times, along an axis at times, tangent to a surface at times
        aim: ex.Vector = tuple(s * F(rng.randint(-8, 8), 2) for _ in range(3))  # type: ignore[assignment]
        if points and rng.random() < 0.8:
            aim = rng.choice(points)
        v: ex.Vector = tuple(s * F(rng.randint(-12, 12)) for _ in range(3))  # type: ignore[assignment]
        dice = rng.random()
        if dice < 0.25:
            k = rng.randrange(3)
            v = tuple(s * (rng.choice((-20, 20, 8)) if i == k else 0) for i in range(3))  # type: ignore[assignment]
        elif dice < 0.5 and points:
            normal = _normal(rng, body, aim)
            if normal is not None:
                v = ex.cross(normal, ex.unit(rng))
                top = max(map(abs, v))
                v = ex.scale(s * rng.choice((4, 16, 40)) / F(top), v) if top else v
        if not any(v):
            continue
        when = rng.choice((F(1, 2), F(1, 4), F(3, 4), F(1, 3), F(1), F(0), F(3, 5)))
        p = ex.sub(aim, ex.scale(when, v))
        found = shared(rng, body, p, v, F(0), F(1))
        if found is None:
            continue
        zero = (F(0), F(0), F(0))
        bare = sh.polytope([p]) if rng.random() < 0.7 else sh.polytope([zero]).placed(ex.shifting(p))
        point = Posed(bare, Shift(v))
        solid = Posed(body)
        if rng.random() < 0.2:
            point, solid = Posed(point.body), Posed(body, Shift(ex.scale(-1, v)))
        status, time, initial = "FREE", None, None
        if found and found[0][0] == 0:
            status = "INITIAL_CONTACT"
            initial = "containment" if body.side(p) > 0 else "touching"
        elif found:
            status, time = "CONTACT", found[0][0]
        a, b, _ = flipped(rng, point, solid, None)
        truth = Truth(status, (F(0), F(1)), a, b, time, F(1, 2**170), initial)
        span = rng.choice((None, (F(0), F(1))))
        return Scene(program(rng, a, b, span), "translation", calls(rng, truth, found, True, truth.slack))


def _normal(rng: Random, body: Body, p: ex.Vector) -> ex.Vector | None:
    """The gradient of a form that vanishes at p."""
    at = [q for q in body.world_forms() if not sh.value(q, p)]
    if not at:
        return None
    q = rng.choice(at)
    n = tuple(ex.dot(q[i][:3], p) + q[i][3] for i in range(3))
    return n if any(n) else None  # type: ignore[return-value]
