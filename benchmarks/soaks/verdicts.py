"""What is wrong with an answer about curved bodies, given the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction as F
from typing import Any

from . import exact as ex
from .paths import Rest
from .scene import Judge
from .solid_shapes import Body

WIDTH = F(101, 100) / 10**12
"""Of an enclosure, relative to the span."""


@dataclass(frozen=True)
class Posed:
    """A body with the motion that it makes."""

    body: Body
    motion: Any = Rest()

    def back(self, t: F, p: Sequence[Any]) -> ex.Vector:
        """Where the body at rest has the point that is at p at time t."""
        return ex.apply(ex.inverse(self.motion.pose(t)), p)

    def way(self, span: tuple[F, F]) -> float:
        """About how far it moves."""
        poses = [self.motion.quick(float(span[0] + (span[1] - span[0]) * F(k, 4))) for k in range(5)]
        middle = [float(row[3]) for row in self.body.place[:3]]
        arm = float(self.body.size)
        steps = zip(poses, poses[1:], strict=False)
        lin = max(abs(float(x) - float(y)) for m, n in zip(poses, poses[1:], strict=False)
                  for r, q in zip(m[:3], n[:3], strict=True) for x, y in zip(r[:3], q[:3], strict=True))
        return 4 * lin * arm + sum(ex.length(ex.sub(ex.apply(m, middle), ex.apply(n, middle))) for m, n in steps)


@dataclass(frozen=True)
class Truth:
    """What is known of a first contact.

    status   "FREE", "CONTACT" or "INITIAL_CONTACT"; time and slack: the true time within +- slack.
    initial  what a start in contact is; None where not known.
    normal   the only one there is, from b towards a, any length; None where there are several.
    graze    they do not press: a normal need not be told.
    """

    status: str
    span: tuple[F, F]
    a: Posed
    b: Posed
    time: F | None = None
    slack: F = F(0)
    initial: str | None = None
    normal: ex.Vector | None = None
    graze: bool = False


def first(truth: Truth) -> Judge:
    def judge(hit: Any) -> str | None:
        status = hit.status.name
        if status == "UNDECIDED":
            reached = hit.free_until
            if reached is None or truth.status == "FREE":
                return None
            when = truth.span[0] if truth.status == "INITIAL_CONTACT" else truth.time
            if when is not None and F(reached) > when + truth.slack:
                return f"UNDECIDED with free_until {reached!r} past the contact at {float(when)!r}"
            return None
        if status != truth.status:
            at = "" if truth.time is None else f" at {truth.time} = {float(truth.time)!r}"
            return f"{status}{'' if hit.time is None else f' at {hit.time!r}'}, true is {truth.status}{at}"
        if status == "FREE":
            return None
        if status == "INITIAL_CONTACT":
            wrong = F(hit.time) != truth.span[0] and abs(F(hit.time) - truth.span[0]) > abs(truth.span[0]) / 2**52
            if wrong:
                return f"INITIAL_CONTACT at {hit.time!r}, the span starts at {truth.span[0]}"
            if truth.initial and hit.initial != truth.initial and not (hit.initial is None and _meshed(truth)):
                return f"initial {hit.initial!r}, true is {truth.initial!r}"
            return point_wrong(hit, truth, truth.span[0], from_apart=truth.initial == "touching")
        return time_wrong(hit, truth) or point_wrong(hit, truth, truth.time) or normal_wrong(hit, truth)

    return judge


def _meshed(truth: Truth) -> bool:
    """None is allowed at the start of a polyhedron, where many triangles touch."""
    return bool(truth.a.body.corners or truth.b.body.corners)


def time_wrong(hit: Any, truth: Truth) -> str | None:
    lo, hi = map(F, hit.time_interval)
    t, slack, span = truth.time, truth.slack, truth.span
    assert t is not None
    if not lo - slack <= t <= hi + slack:
        return f"time_interval {hit.time_interval} without the true time {t} = {float(t)!r}"
    rounding = max(abs(t), abs(span[0]), abs(span[1])) / 2**50
    width = WIDTH * (span[1] - span[0]) + rounding
    if hi - lo > width:
        return f"time_interval {hit.time_interval} is {float(hi - lo)!r} wide"
    if not lo <= F(hit.time) <= hi:
        return f"time {hit.time!r} outside its interval {hit.time_interval}"
    if isinstance(hit.time_exact, F) and abs(hit.time_exact - t) > slack:
        return f"time_exact {hit.time_exact}, true is {t}"
    return None


def point_wrong(hit: Any, truth: Truth, t: F | None, from_apart: bool = True) -> str | None:
    if hit.point is None or t is None:
        return None
    p = tuple(F(float(x)) for x in hit.point)
    when = max(abs(float(x)) for x in p)
    spans = float(WIDTH) * 3 + 4e-16 * float(max(map(abs, truth.span)) / (truth.span[1] - truth.span[0]))
    loose = sum(x.way(truth.span) for x in (truth.a, truth.b)) * spans + 4e-15 * when
    floor = min((float(x.body.size) for x in (truth.a, truth.b) if x.body.size), default=0.0)
    for name, x in (("a", truth.a), ("b", truth.b)):
        q = x.back(t, p)
        allowed = 1e-9 * (float(x.body.size) or floor) + loose
        off = x.body.off(q)
        if off > allowed:
            return f"point {hit.point.tolist()} is {off:.3g} off {name}, of size {float(x.body.size):.3g}"
        if from_apart:
            depth = x.body.depth(q)
            if depth > allowed:
                return f"point {hit.point.tolist()} is {depth:.3g} inside {name}, of size {float(x.body.size):.3g}"
    return None


def normal_wrong(hit: Any, truth: Truth) -> str | None:
    if hit.normal is None:
        if truth.normal is not None and not truth.graze:
            return "no normal, though there is exactly one"
        return None
    norm = ex.length(hit.normal)
    if abs(norm - 1) > 1e-9:
        return f"normal {hit.normal.tolist()} of length {norm!r}"
    if truth.normal is not None:
        true = [float(x) / ex.length(truth.normal) for x in truth.normal]
        across = ex.length(ex.sub(hit.normal, true))
        if across > 1e-6:
            return f"normal {hit.normal.tolist()}, true is {true}"
    return radial_wrong(hit, truth)


def radial_wrong(hit: Any, truth: Truth) -> str | None:
    """The normal of a ball is along its radius to the point told."""
    t = F(hit.time)
    p = tuple(F(float(x)) for x in hit.point)
    for x, sign in ((truth.a, 1), (truth.b, -1)):
        columns = [[row[j] for row in x.body.place[:3]] for j in range(3)]
        if x.body.kind != "sphere" or any(ex.dot(c, c) != 1 for c in columns):
            continue
        centre = ex.apply(x.motion.pose(t), [row[3] for row in x.body.place[:3]])
        radius = [sign * float(v) for v in ex.sub(centre, p)]
        half = float(x.body.size) / 2
        loose = 1e-6 + 1e-11 * (sum(y.way(truth.span) for y in (truth.a, truth.b)) + max(map(abs, hit.point))) / half
        across = ex.length([n - v / half for n, v in zip(hit.normal, radius, strict=True)])
        if across > loose + 1e-9 * float(max(truth.a.body.size, truth.b.body.size)) / half:
            return f"normal {hit.normal.tolist()}, the ball's is {[v / half for v in radius]}"
    return None


def intervals(truth: Truth, expected: Sequence[tuple[F, F]], slack: F = F(0)) -> Judge:
    """All times of contact, each end within +- slack; in order, disjoint."""

    def judge(found: Any) -> str | None:
        listed = [(tuple(map(F, x.start_interval)), tuple(map(F, x.end_interval))) for x in found]
        if found.status.name == "UNDECIDED":
            known = found.free_until
            if expected and not listed and known is not None and F(known) > expected[0][1] + slack:
                return f"UNDECIDED, free until {known!r}, past the contact at {float(expected[0][0])!r}"
            return None
        if len(listed) != len(expected):
            true = [(float(p), float(q)) for p, q in expected]
            return f"intervals {[(x.start, x.end) for x in found]}, true are {true}"
        width = WIDTH * (truth.span[1] - truth.span[0]) + max(map(abs, truth.span)) / 2**50
        for x, (start, end), true in zip(found, listed, expected, strict=True):
            for (lo, hi), t, name in ((start, true[0], "start"), (end, true[1], "end")):
                if not lo - slack <= t <= hi + slack:
                    return f"{name} in {(float(lo), float(hi))}, true is {t} = {float(t)!r}"
                if hi - lo > width:
                    return f"{name} in {(float(lo), float(hi))}, {float(hi - lo)!r} wide"
            for exactly, t in ((x.start_exact, true[0]), (x.end_exact, true[1])):
                if isinstance(exactly, F) and abs(exactly - t) > slack:
                    return f"exact end {exactly}, true is {t}"
        return None

    return judge
