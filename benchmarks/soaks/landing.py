"""Two convex bodies that touch along a common normal at a chosen time: the place of contact first, then the motions.

At that time a plane has one body on either side, both in it at the point of contact.  Earlier the plane, carried along
with one of the bodies, must stay clear of the other: its gap is the closed support function of that body, which is
looked at closely enough to be sure (the spans are shortened to where it is).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction as F
from random import Random
from typing import Any

from . import exact as ex
from .paths import Between, Rest, Rolling, Shift, Steps, Turn, moved
from .scene import Question, Scene
from .solid_shapes import Body, Feature
from .verdicts import Posed, Truth, first, intervals

Maker = Callable[[Random, F], Body]
TIMES = (F(1, 2), F(1, 4), F(3, 4), F(3, 8), F(1, 3), F(2, 3), F(3, 5), F(7, 8), F(1))


@dataclass(frozen=True)
class Touch:
    """Bodies in the places in which they touch; `normal` from b towards a, any length."""

    a: Body
    b: Body
    on_a: Feature
    on_b: Feature
    point: ex.Vector
    normal: ex.Vector

    @property
    def one_normal(self) -> ex.Vector | None:
        return self.normal if self.on_a.smooth or self.on_b.smooth else None

    @property
    def size(self) -> F:
        return max(self.a.size, self.b.size)


def scales(rng: Random) -> tuple[F, F, F]:
    """Of the scene and of both bodies, powers of four."""
    s = F(4) ** rng.choice((0, 0, 0, 0, rng.randint(-3, 3), rng.randint(-20, 20)))
    small = F(4) ** -rng.choice((0, 0, 0, 0, 1, 2, 5, 8))
    return (s, s * small, s) if rng.random() < 0.5 else (s, s, s * small)


def bake(rng: Random, body: Body) -> Body:
    """Polyhedra have their places in their vertices, at times."""
    return body.baked() if body.corners and rng.random() < 0.6 else body


def touch(rng: Random, makers: Sequence[Maker], others: Sequence[Maker], s: F, sa: F, sb: F) -> Touch:
    a, b = rng.choice(makers)(rng, sa), rng.choice(others)(rng, sb)
    assert a.feature and b.feature
    fa, fb = a.feature(rng), b.feature(rng)
    n = ex.unit(rng) if rng.random() < 0.4 else fb.normal
    offset = rng.choice((0, 0, 1, 1, 3, 1000)) if min(sa, sb) == s else rng.choice((0, 1))
    p = tuple(s * offset * F(rng.randint(-6, 6), 2) for _ in range(3))
    back = ex.scale(-1, n)
    ma = ex.bringing(fa.normal, back, rng) if fa.normal != back or rng.random() < 0.7 else ex.IDENTITY
    mb = ex.bringing(fb.normal, n, rng) if fb.normal != n or rng.random() < 0.3 else ex.IDENTITY
    a = a.placed(ex.product(ex.shifting(p), ex.product(ma, ex.shifting(ex.scale(-1, fa.point)))))
    b = b.placed(ex.product(ex.shifting(p), ex.product(mb, ex.shifting(ex.scale(-1, fb.point)))))
    if rng.random() < 0.15:  # sheared together, so that no axes are left
        lin = [[F(int(i == j)) + F(rng.randint(-1, 1), 4) * (i != j) for j in range(3)] for i in range(3)]
        shear = [*([*row, p[i] - ex.dot(row, p)] for i, row in enumerate(lin)), ex.IDENTITY[3]]
        a, b = a.placed(shear), b.placed(shear)
        n = ex.pull(ex.inverse(shear), n)
    a, b = bake(rng, a), bake(rng, b)
    return Touch(a, b, fa, fb, p, n)  # type: ignore[arg-type]


def gap(a: Posed, b: Posed, normal: ex.Vector, level: F, t: float) -> float:
    """Of a above the plane normal . x = level that goes along with b, in the frame of b at rest."""
    relative = ex.product(ex.inverse(b.motion.quick(t)), a.motion.quick(t))
    n = [float(x) for x in normal]
    down = [-x for x in ex.pull(relative, n)]
    shift = [relative[i][3] for i in range(3)]
    return -a.body.reach(down) + ex.dot(n, shift) - float(level)


def clear_from(a: Posed, b: Posed, normal: ex.Vector, level: F, start: F, when: F, graze: bool = False) -> F | None:
    """From when on the plane is known to be clear of a until `when`; None where it is not just before."""
    size = ex.length(normal) * float(a.body.size + b.body.size)
    steps = 64
    length = float(when - start)
    rate = gap(a, b, normal, level, float(when) - length / steps) / length * steps
    if not graze:
        for k in (8, 10, 13, 16):
            here = gap(a, b, normal, level, float(when) - length * 2.0**-k) / length * 2.0**k
            if here < 0.3 * rate or here < 2e-3 * size:
                return None
    clear = when
    for k in range(1, steps + 1):
        if gap(a, b, normal, level, float(when) - length * k / steps) < 2e-3 * size * min(1.0, k / steps) * 0.1:
            return None if k < 5 else clear
        clear = when - (when - start) * k / steps
    return start


def speed(rng: Random, s: F) -> ex.Vector:
    return tuple(s * F(rng.randint(-12, 12), rng.choice((1, 1, 2))) for _ in range(3))  # type: ignore[return-value]


QUATERNIONS = tuple(
    tuple(F(x, d) for x in v) for *v, d in
    ((3, 0, 0, 4, 5), (0, 4, 0, 3, 5), (0, 0, 5, 12, 13), (1, 2, 0, 2, 3), (2, 3, 0, 6, 7), (1, 4, 4, 4, 7),
     (0, 0, 0, 1, 1), (1, 1, 1, 1, 2), (2, 4, 5, 6, 9))
)


def path(rng: Random, kind: str, when: F, touching: Touch, s: F) -> Any:
    """A motion with a rational pose at `when`, of about the speed s."""
    near = tuple(touching.point[i] + s * F(rng.randint(-12, 12), 2) for i in range(3))
    if kind == "translation":
        if rng.random() < 0.3:
            length = s * rng.choice((-1, 1)) * rng.choice((1, 4))
            return Shift(ex.scale(length / F(max(map(abs, touching.normal))), touching.normal))
        return Shift(speed(rng, s))
    if kind in ("rotation", "screw"):
        quarters = rng.choice((1, 1, 2, 3, -1, -1, -2, -3, 4, 5))
        advance = s * F(rng.randint(-20, 20), 2) if kind == "screw" else None
        return Turn(ex.unit(rng), near, F(quarters, 4) / when, advance, rng.choice((1, 1, 2, 15)), rng.random() < 0.5)
    if kind == "rational":
        axis = tuple(F(rng.randint(-2, 2)) for _ in range(3))
        axis = axis if any(axis) else (F(0), F(0), F(1))
        k = F(rng.randint(1, 4), 2) * rng.choice((1, -1))
        still = rng.random() < 0.5
        return Rolling(axis, near, (F(1), F(1)), (F(0), k), ex.scale(F(int(not still)), speed(rng, s)))  # type: ignore[arg-type]
    if kind in ("between", "trajectory"):
        q, r = rng.sample(QUATERNIONS, 2)
        if sum(x * y for x, y in zip(q, r, strict=True)) < 0:
            r = tuple(-x for x in r)
        times = (F(0), F(rng.randint(1, 3))) if kind == "trajectory" else None
        return Between(q, r, speed(rng, s), speed(rng, s), times, kind)  # type: ignore[arg-type]
    assert kind == "sequence"
    early = rng.choice(("screw", "screw", "rotation", "translation", "rational"))
    firsts = [path(rng, early, F(1), touching, s)]
    if rng.random() < 0.3:
        firsts.append(path(rng, rng.choice(("screw", "rotation", "translation")), F(1), touching, s))
    last = rng.choice(("translation", "translation", "rotation", "screw"))
    durations = tuple(rng.choice((F(1), F(2), F(1, 2))) for _ in range(len(firsts) + 1))
    part = rng.choice(TIMES)
    return (Steps((*firsts, path(rng, last, part, touching, s)), durations), sum(durations[:-1]) + part * durations[-1])


KINDS = ("translation", "rotation", "screw", "rational", "between", "trajectory", "sequence")


def landed(rng: Random, kind: str, t: Touch, s: F) -> tuple[Posed, Posed, F, F] | None:
    """Motions that bring the bodies into their places at a time, and from when on they are known to be apart."""
    when = rng.choice(TIMES)
    xa = path(rng, kind, when, t, s)
    if isinstance(xa, tuple):
        xa, when = xa
    if kind == "trajectory":
        when = when * xa.times[1]
    xb: Any = Rest()
    both = rng.random()
    if both < 0.1:
        xb = path(rng, "translation", when, t, s)
    elif both < 0.16:
        xb = path(rng, "rotation", when, t, s)
    elif both < 0.2 and isinstance(xa, Turn):
        xb = replace(xa, turns=-xa.turns)
    if not (xa.sure(when) and xb.sure(when)):
        return None
    pose_b = xb.pose(when)
    b = Posed(t.b.placed(ex.inverse(pose_b)), xb)
    normal = ex.pull(pose_b, t.normal)
    level = ex.dot(normal, ex.apply(ex.inverse(pose_b), t.point))
    for way in (xa, _reversed(xa)):
        if way is None:
            continue
        a = Posed(t.a.placed(ex.inverse(way.pose(when))), way)
        if a.body.corners:
            a = Posed(bake(rng, a.body), way)
        clear = clear_from(a, b, normal, level, F(0), when)
        if clear is not None:
            return a, b, when, clear
    return None


def _reversed(x: Any) -> Any:
    if isinstance(x, Shift):
        return Shift(ex.scale(-1, x.vector))
    if isinstance(x, Turn):
        return replace(x, turns=-x.turns, advance=None if x.advance is None else -x.advance)
    if isinstance(x, Rolling):
        return replace(x, imaginary=(x.imaginary[0], -x.imaginary[1]), vector=ex.scale(-1, x.vector))
    if isinstance(x, Between):
        if x.times:
            return None
        return replace(x, first=x.last, last=x.first, start=x.end, end=x.start)
    if isinstance(x, Steps):
        return Steps((*x.steps[:-1], _reversed(x.steps[-1])), x.durations)
    return None


def end_of(a: Posed, b: Posed) -> F:
    """Of the motions' own span."""
    ends = [sum(x.motion.durations) if isinstance(x.motion, Steps) else x.motion.times[1]
            if isinstance(x.motion, Between) and x.motion.times else F(1) for x in (a, b) if x.motion.kind != "rest"]
    return min(ends)


def program(rng: Random, a: Posed, b: Posed, span: tuple[F, F] | None, names: bool = False) -> str:
    lines = [f"{name} = {moved(x.body.text() + (f'.named({name!r})' if names else ''), x.motion)}"
             for name, x in (("a", a), ("b", b))]
    return "\n".join([*lines, f"span = {ex.texts(span) if span else None}"])


def calls(rng: Random, truth: Truth, expected: Sequence[tuple[F, F]] | None = None, exactly: bool = True,
          slack: F = F(0)) -> tuple[Question, ...]:
    """The questions: the default, at times in exact arithmetic or by algebra alone, and intervals where known."""
    ask = [Question("fc.first_contact(a, b, span)", first(truth))]
    dice = rng.random()
    if exactly and dice < 0.15:
        ask.append(Question("fc.first_contact(a, b, span, exact=True)", first(truth)))
    elif exactly and dice < 0.2:
        ask.append(Question('fc.first_contact(a, b, span, method="algebraic")', first(truth)))
    if expected is not None and rng.random() < 0.5:
        more = ", exact=True" if exactly and rng.random() < 0.3 else ""
        ask.append(Question(f"fc.contact_intervals(a, b, span{more})", intervals(truth, expected, slack)))
    return tuple(ask)


def flipped(rng: Random, a: Posed, b: Posed, normal: ex.Vector | None) -> tuple[Posed, Posed, ex.Vector | None]:
    """The other body as a, half the time."""
    if rng.random() < 0.5:
        return a, b, normal
    return b, a, None if normal is None else ex.scale(-1, normal)


def rational_motion(*bodies: Posed) -> bool:
    kinds = {x.motion.kind for x in bodies}
    return not kinds & {"screw", "sequence"} and not ("rotation" in kinds and kinds - {"rotation", "rest"})


def landing(rng: Random, makers: Sequence[Maker], others: Sequence[Maker], kinds: Sequence[str] = KINDS) -> Scene:
    """A first contact from apart at a chosen time."""
    while True:
        s, sa, sb = scales(rng)
        t = touch(rng, makers, others, s, sa, sb)
        if t.b.support and rng.random() < 0.5:
            t = Touch(t.b, t.a, t.on_b, t.on_a, t.point, ex.scale(-1, t.normal))
        kind = rng.choice(kinds)
        found = landed(rng, kind, t, s)
        if found is None:
            continue
        a, b, when, clear = found
        end = end_of(a, b)
        if when > end:
            continue
        start = F(0)
        own = clear == 0
        if not own:
            start = _dyadic(clear + (when - clear) / 16)
        elif rng.random() < 0.2:
            start = _dyadic(when * F(rng.randint(1, 15), 16))
        if start >= when:
            continue
        span = (start, end)
        shape = rng.choice(("whole", "whole", "whole", "ends there", "ends before", "starts there"))
        status, initial = "CONTACT", None
        if shape == "ends there":
            span = (start, when)
        elif shape == "ends before":
            before = when - (when - start) * rng.choice((F(1, 8), F(1, 2**20), F(1, 2**36)))
            span, status = (start, _dyadic(before, 2**50)), "FREE"
            if not start < span[1] < when:
                continue
        elif shape == "starts there":
            if when == end:
                continue
            span, status, initial = (when, end), "INITIAL_CONTACT", "touching"
        first_a, first_b, normal = flipped(rng, a, b, t.one_normal)
        if any(F(float(x)) != x for x in span):  # spans are doubles
            continue
        time = when if status == "CONTACT" else None
        truth = Truth(status, span, first_a, first_b, time, initial=initial, normal=normal)
        written = None if span == (F(0), end) and rng.random() < 0.5 else span
        source = program(rng, first_a, first_b, written, rng.random() < 0.2)
        kind = a.motion.kind if b.motion.kind == "rest" else f"{a.motion.kind}, {b.motion.kind}"
        return Scene(source, kind, calls(rng, truth, exactly=rational_motion(a, b)))


def _dyadic(x: F, parts: int = 4096) -> F:
    return F(int(x * parts), parts)
