"""Convex bodies thrown at each other anyhow: no time is known, but wrong answers can be caught.

A point found inside both at some time proves contact by then.  At a first contact of convex bodies the normal told is
that of a plane between them: the support functions must meet there.  Landings on bodies that were drilled afterwards
keep their time, as long as the place of contact is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction as F
from random import Random
from typing import Any

import numpy as np

from . import exact as ex
from . import solid_shapes as sh
from .landing import (
    KINDS,
    Maker,
    Touch,
    calls,
    end_of,
    flipped,
    landed,
    path,
    program,
    rational_motion,
    scales,
    touch,
)
from .piercing import closed
from .scene import Question, Scene
from .solid_shapes import Body
from .verdicts import Posed, Truth, point_wrong


def crossing(rng: Random, makers: Sequence[Maker], others: Sequence[Maker]) -> Scene:
    s, sa, sb = scales(rng)
    a, b = rng.choice(makers)(rng, sa), rng.choice(others)(rng, sb)
    a, b = (x.placed(ex.bringing(ex.unit(rng), ex.unit(rng), rng)) for x in (a, b))
    a = a.placed(ex.shifting(tuple(s * F(rng.randint(-30, 30)) for _ in range(3))))
    kind = rng.choice(KINDS)
    goal = Touch(a, b, None, None, (F(0),) * 3, (F(0), F(0), F(1)))  # type: ignore[arg-type]
    xa = path(rng, kind, F(1), goal, 4 * s)
    xa = xa[0] if isinstance(xa, tuple) else xa
    aimed = F(rng.randint(1, 7), 8)
    pa, pb = Posed(a, xa), Posed(b)
    end = end_of(pa, pb)
    if rng.random() < 0.7:  # through the middle of b at some time, nearly
        at = [F(float(x)) for x in ex.apply(xa.quick(float(aimed * end)), [float(row[3]) for row in a.place[:3]])]
        step = tuple(F(round(float((y[3] + s * rng.randint(-4, 4) - x) / s * 4)), 4) * s
                     for x, y in zip(at, b.place[:3], strict=True))
        pb = Posed(b.placed(ex.shifting(ex.scale(-1, step))))
    seen = witness(rng, pa, pb, end)
    first_a, first_b, _ = flipped(rng, pa, pb, None)
    truth = Truth("CONTACT", (F(0), end), first_a, first_b)

    def judge(hit: Any) -> str | None:
        status = hit.status.name
        if status == "FREE":
            return None if seen is None else f"FREE, but {[float(x) for x in seen[1]]} is inside both at {seen[0]}"
        if status == "UNDECIDED":
            if seen is None or hit.free_until is None or F(hit.free_until) <= seen[0]:
                return None
            return f"UNDECIDED, free until {hit.free_until!r}, but a point is inside both at {seen[0]}"
        t = F(hit.time)
        if seen is not None and t > seen[0] + F(1, 10**11) * end:
            return f"{status} at {hit.time!r}, but {[float(x) for x in seen[1]]} is inside both at {seen[0]}"
        wrong = point_wrong(hit, truth, t, from_apart=status == "CONTACT")
        return wrong or (plane_wrong(hit, first_a, first_b, t, end) if status == "CONTACT" else None)

    return Scene(program(rng, first_a, first_b, None), kind, (Question("fc.first_contact(a, b, span)", judge),))


def plane_wrong(hit: Any, a: Posed, b: Posed, t: F, end: F) -> str | None:
    """Whether the plane told is between the bodies at the time told."""
    if hit.normal is None or not (a.body.support and b.body.support):
        return None
    if "face" not in (hit.element_a.kind, hit.element_b.kind) or hit.others:
        return None
    n = [float(x) for x in hit.normal]
    gaps = []
    for x, sign in ((a, -1), (b, 1)):
        pose = x.motion.pose(t)
        d = [sign * float(v) for v in ex.pull(pose, [F(v) for v in n])]
        gaps.append(x.body.reach(d) + sign * float(ex.dot([F(v) for v in n], [pose[i][3] for i in range(3)])))
    apart = -(gaps[0] + gaps[1])
    size = float(min(y for y in (a.body.size, b.body.size) if y))
    far = max(float(x) for x in (a.body.size, b.body.size)) + sum(x.way((F(0), end)) for x in (a, b)) + abs(gaps[0])
    allowed = 1e-9 * size + 4e-12 * far
    if apart > allowed:
        return f"{apart:.3g} apart at the time told, {hit.time!r}, along the normal told"
    if apart < -allowed:
        return f"the plane told cuts {-apart:.3g} into the bodies, of size {size:.3g}"
    return None


def witness(rng: Random, a: Posed, b: Posed, end: F, times: int = 24) -> tuple[F, ex.Vector] | None:
    """A time and a place that are proved inside both: places are guessed in doubles, then looked at exactly."""
    small, large = (a, b) if a.body.size <= b.body.size else (b, a)
    if small.body.flat or not small.body.support:
        small, large = large, small
    points = _samples(rng, small.body)
    if large.body.flat or not len(points):
        return None
    forms = np.array([[[float(x) for x in row] for row in q] for q in large.body.world_forms()])
    homogeneous = np.c_[points, np.ones(len(points))]
    for k in range(times + 1):
        t = end * F(k, times)
        relative = np.array(ex.product(ex.inverse(large.motion.quick(float(t))), small.motion.quick(float(t))), float)
        at = homogeneous @ relative.T
        values = np.einsum("pi,fij,pj->pf", at, forms, at)
        worst = (values / np.abs(forms).max(axis=(1, 2))).max(axis=1)
        best = int(np.argmin(worst))
        if worst[best] >= 0:
            continue
        p = ex.apply(small.motion.pose(t), tuple(F(float(x)) for x in points[best]))
        if small.body.flat:
            p = ex.apply(small.motion.pose(t), [row[3] for row in small.body.place[:3]])
        inside = [x.body.side(x.back(t, p)) > 0 for x in (small, large) if not x.body.flat]
        if all(inside):
            return t, p
    return None


def _samples(rng: Random, body: Body) -> np.ndarray:
    """Points of a convex body: between places of its boundary."""
    if body.feature is None:
        return np.zeros((0, 3))
    rim = np.array([[float(x) for x in body.there(body.feature(rng)).point] for _ in range(24)])
    pairs = np.array([[rng.randrange(24), rng.randrange(24), rng.randrange(24)] for _ in range(80)])
    return (rim[pairs[:, 0]] + rim[pairs[:, 1]] + rim[pairs[:, 2]]) / 3


def drilled_landing(rng: Random, makers: Sequence[Maker], others: Sequence[Maker]) -> Scene:
    """A landing on a convex solid with a hole whose wall passes through, or by, the place of contact."""
    while True:
        s = F(4) ** rng.choice((0, 0, 0, rng.randint(-20, 20)))
        t = touch(rng, makers, others, s, s, s)
        if t.b.corners or not t.b.forms:
            continue
        shape = rng.choice((sh.any_sphere, sh.any_cylinder, sh.any_box, sh.any_ellipsoid, sh.any_cone))
        hole = shape(rng, s * rng.choice((1, 1, F(1, 4))))
        assert hole.feature
        f = hole.feature(rng)
        m = ex.unit(rng)
        if not any(ex.cross(m, t.normal)) and ex.dot(m, t.normal) > 0:
            continue
        away = ex.scale(s * rng.choice((0, 0, 0, 1)) * F(rng.randint(1, 8), 64), m)
        place = ex.product(ex.shifting(ex.sub(t.point, away)),
                           ex.product(ex.bringing(f.normal, m, rng), ex.shifting(ex.scale(-1, f.point))))
        # m points out of the hole at the place of contact: the solid beyond it stays
        hole = hole.placed(place)
        operation = rng.choice(("-", "-", "-", "|"))
        if operation == "|":
            n = [float(x) for x in t.normal]
            if hole.reach(n) > float(ex.dot(t.normal, t.point)) - 1e-6 * float(s):
                continue
        drilled = sh.combined(operation, t.b, hole)
        if not closed(rng, drilled, t.point):
            continue
        kind = rng.choice(KINDS[:6])
        found = landed(rng, kind, t, s)
        if found is None:
            continue
        a, b, when, clear = found
        if when > end_of(a, b):
            continue
        back = ex.product(b.body.place, ex.inverse(t.b.place))
        b = Posed(replace(drilled, place=ex.IDENTITY).placed(back), b.motion)
        start = F(0) if clear == 0 else F(int((clear + (when - clear) / 16) * 4096), 4096)
        if not start < when:
            continue
        normal = t.normal if t.on_a.smooth else None
        p, q, normal = flipped(rng, a, b, normal)
        span = (start, end_of(a, b))
        truth = Truth("CONTACT", span, p, q, when, normal=normal)
        written = None if start == 0 and rng.random() < 0.5 else span
        return Scene(program(rng, p, q, written), a.motion.kind, calls(rng, truth, exactly=rational_motion(a, b)))
