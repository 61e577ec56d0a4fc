"""Polyhedra.

Translations of all kinds are decided by exact brute force over all pieces (`brute`), so their scenes may be as
degenerate as random small numbers make them: a point of one body is laid on a point of the other at a chosen time,
exactly or off by as little as 2**-50, mostly with faces and edges along the axes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction as F
from random import Random
from typing import Any

from . import judges, turning
from .brute import Mesh, Point, contact_times, cross, minus, moved, plus, start_of, times
from .choices import (
    SPANS,
    Maker,
    direction,
    hollow,
    notched,
    off,
    open_mesh,
    random_turn,
    small,
    solid,
    span_text,
    spot,
    thin,
    when,
)
from .mesh_paths import PATHS
from .scene import Kind, Question, Scene
from .shapes import number, text, vector
from .turning import Axis, Speed, posed, turned

Grown = Callable[[Random], tuple[Callable[[Point], Point], Callable[[Point], Point]]]
"""A change of places, and what it makes of directions."""

FIRST = "fc.first_contact(a, b, span)"


# ---- translations ----


def _movers(rng: Random, a: Mesh, b: Mesh, v: Point, floats: bool) -> tuple[str, Point, Point]:
    """The lines that define a and b, of which a moves by v as seen from b; and their velocities."""
    names = rng.choice(((None, None), (None, None), ("pin", "plate"), ("same", "same")))
    first, second = text(a, floats, names[0]), text(b, floats, names[1])
    zero: Point = (F(0), F(0), F(0))
    who = rng.choice("aaabc")
    ours, theirs = {"a": (v, zero), "b": (zero, times(-1, v))}.get(who, (None, None)) or (None, None)
    if ours is None or theirs is None:
        theirs = direction(rng)
        ours = plus(theirs, v)
    lines = []
    for name, body, way in (("a", first, ours), ("b", second, theirs)):
        if any(way) or rng.random() < 0.1:
            body += f".moving(fc.Translation({vector(way, floats)}))"
        lines.append(f"{name} = {body}")
    return "\n".join(lines), ours, theirs


def _translation(
    makers: Sequence[Maker], share: float = 0.3, *, endless: bool = False, grown: Grown | None = None, more: bool = True
) -> Callable[[Random], Scene]:
    def make(rng: Random) -> Scene:
        a, b = rng.choice(makers)(rng), rng.choice(makers)(rng)
        a = a.mapped(random_turn(rng, share))
        v = times(rng.choice((1, 1, 2, 5, 20)), direction(rng, rng.choice((4, 8))))
        if rng.random() < 0.05:
            v = (F(0), F(0), F(0))
        first, last = rng.choice(SPANS)
        end: F | None = last
        if endless:
            end = None
            first = rng.choice((F(0), F(0), F(-3), F(2)))
            last = first + rng.choice((4, 1024))
        meeting = when(rng, (first, last))
        shift = minus(plus(spot(rng, b), times(off(rng), direction(rng))), plus(spot(rng, a), times(meeting, v)))
        a = moved(a, shift, 1)
        if grown:
            change, linear = grown(rng)
            a, b, v = a.mapped(change), b.mapped(change), linear(v)
        if rng.random() < 0.5:
            a, b, v = b, a, times(-1, v)
        floats = rng.random() < 0.4
        bodies, ours, theirs = _movers(rng, a, b, v, floats)
        source = f"{bodies}\nspan = {span_text(rng, first, end)}\n"
        return _judged(rng, source, a, b, (ours, theirs), (first, end), more)

    return make


def _judged(rng: Random, source: str, a: Mesh, b: Mesh, ways: Any, span: Any, more: bool) -> Scene:
    """The scene of a and b with these velocities, and its questions."""
    ours, theirs = ways
    v = minus(ours, theirs)
    first, last = span
    contacts = contact_times(a, b, v, first, last)
    time = contacts[0][0] if contacts else None
    initial = start_of(moved(a, v, first), b) if time == first else None

    def poses(t: F) -> tuple[Mesh, Mesh]:
        return moved(a, ours, t), moved(b, theirs, t)

    truth = judges.Truth((first, last), time, initial, F(0), poses, (lambda _: v) if any(v) else None)
    questions = [Question(FIRST, judges.first_contact(truth))]
    if more and rng.random() < 0.4:
        questions.append(Question("fc.contact_intervals(a, b, span)", judges.intervals(contacts, (first, last))))
    if rng.random() < 0.15:
        questions.append(Question("fc.first_contact(a, b, span, exact=True)", judges.first_contact(truth)))
    return Scene(source, "translation" if any(v) else "rest", tuple(questions))


def _scales(rng: Random) -> tuple[Callable[[Point], Point], Callable[[Point], Point]]:
    """Sizes and places far from one."""
    power = rng.choice((-300, -200, -40, -20, 20, 40, 100))
    place: Point = (F(0), F(0), F(0))
    if rng.random() < 0.6:
        power = rng.choice((-10, -20, -30))
        place = tuple(F(rng.choice((-1, 1, 0)) * rng.choice((10**6, 2**20, 12345678))) for _ in range(3))
    size = F(2) ** power
    return lambda p: plus(times(size, p), place), lambda p: times(size, p)


# ---- rotations about one axis ----

WAYS = ((0, 0, 1), (0, 0, 1), (1, 0, 0), (0, -1, 0), (0, 0, 2), (1, 2, 2), (3, 0, 4), (1, 1, 1), (1, 1, 0), (1, -2, 0))
RATES = tuple(F(x) for x in ("1/4", "1/4", "1/2", "1/2", "1", "1", "-1/4", "-1/2", "-1", "1/8", "1/3", "1/6", "-5/12",
                             "3/4", "2", "-3", "7/2", "5/4"))
TURN_SPANS: tuple[tuple[F, F], ...] = (
    (F(0), F(1)), (F(0), F(1)), (F(0), F(1)), (F(1, 2), F(1)), (F(1, 4), F(1)), (F(-1), F(1)), (F(0), F(1, 2)),
    (F(-1), F(0)), (F(1, 2), F(3, 2)), (F(1), F(2)),
)


def _landing(rng: Random, axis: Axis, end: F) -> tuple[Any, Any]:
    """C and S of a rational pose to meet in: that at the end of the span, at a part of a turn, or another."""
    for turns in (end, F(rng.choice((1, 2, 3)), 4), F(rng.choice((1, 2)), 3), F(1, 2)):
        pose = axis.exact(turns)
        if pose and not isinstance(pose[0], turning.Surd) and not isinstance(pose[1], turning.Surd):
            if rng.random() < 0.5:
                return pose
    u = F(rng.choice((-3, -2, -1, 1, 2, 3)), rng.choice((1, 2, 3, 4)))
    return (1 - axis.square * u * u) / (1 + axis.square * u * u), 2 * u / (1 + axis.square * u * u)


def _angle(rng: Random, speed: Speed) -> str:
    if speed.unit == "radians":
        return f"radians={number(speed.rate)}"
    return f"degrees={number(360 * speed.rate)}" if rng.random() < 0.4 else f"turns={number(speed.rate)}"


def _rotation(
    makers: Sequence[Maker], share: float = 0.2, *, grown: Grown | None = None, intervals: float = 0.1,
) -> Callable[[Random], Scene]:
    def make(rng: Random) -> Scene:
        a, b = rng.choice(makers)(rng), rng.choice(makers)(rng)
        a = a.mapped(random_turn(rng, share))
        place: Point = tuple(F(rng.choice((0, 0, 1, -2, 3)), rng.choice((1, 1, 2, 3))) for _ in range(3))  # type: ignore
        axis = Axis(rng.choice(WAYS), place)
        b = moved(b, direction(rng, 6), 1)
        speed = Speed(rng.choice(RATES), "turns")
        first, last = rng.choice(TURN_SPANS)
        if axis.exact(speed.rate * first) is None:
            first = F(0)
            last = max(last, F(1))
        if rng.random() < 0.15:
            speed, first, last = Speed(F(rng.choice((1, 2, 3, -1, 6)), rng.choice((1, 2))), "radians"), F(0), F(1)
        end = speed.rate * last if speed.unit == "turns" else F(1, 7)
        c, s = _landing(rng, axis, end)
        shift = minus(plus(spot(rng, b), times(off(rng), direction(rng))), spot(rng, a))
        a = posed(moved(a, shift, 1), axis, c, -s)
        if grown:
            change, _ = grown(rng)
            a, b, axis = a.mapped(change), b.mapped(change), Axis(axis.way, change(axis.point))
        return _turned_scene(rng, a, b, axis, speed, (first, last), intervals)

    return make


def _turned_scene(
    rng: Random, a: Mesh, b: Mesh, axis: Axis, speed: Speed, span: tuple[F, F], intervals: float
) -> Scene:
    """a turns with `speed` as seen from b: a alone, b alone, or both about the axis."""
    first, last = span
    ours, theirs = speed, Speed(F(0), speed.unit)
    who = rng.choice("aaabc")
    if who == "b":
        ours, theirs = theirs, Speed(-speed.rate, speed.unit)
    elif who == "c":
        theirs = Speed(F(rng.choice((1, -1, 2)), rng.choice((1, 2, 4))), speed.unit)
        ours = Speed(speed.rate + theirs.rate, speed.unit)
    names = rng.choice(((None, None), (None, None), ("lid", "box"), ("same", "same")))
    floats = rng.random() < 0.3
    lines = []
    for name, body, own, called in (("a", a, ours, names[0]), ("b", b, theirs, names[1])):
        line = text(body, floats, called)
        if own.rate:
            way = vector(times(rng.choice((1, 1, 2, F(1, 2))), axis.way))
            line += f".moving(fc.Rotation({way}, {vector(axis.point, floats)}, {_angle(rng, own)}))"
        lines.append(f"{name} = {line}")
    clock = span_text(rng, first, last) if any("moving" in line for line in lines) else "(0, 1)"
    source = "\n".join([*lines, f"span = {clock}"]) + "\n"

    answer = turning.first_contact(a, b, axis, speed, first, last)
    assert answer is not None

    def poses(t: F) -> tuple[Mesh, Mesh]:
        return turned(a, axis, ours.turns() * t), turned(b, axis, theirs.turns() * t)

    sign = (speed.rate > 0) - (speed.rate < 0)

    def velocity(x: Any) -> Sequence[Any]:
        arm = minus(x, axis.point)
        way = times(sign, cross(axis.way, arm))
        # near the axis the rounding of the point decides
        return way if max(map(abs, way)) > F(1, 10**6) * max(map(abs, arm)) else (0, 0, 0)

    sharp = False
    if answer.time is not None and speed.unit == "turns":
        exact = [axis.exact(own.rate * answer.time) for own in (ours, theirs)] if answer.exact else [None]
        sharp = all(p is not None and not any(isinstance(x, turning.Surd) for x in p) for p in exact)
    slack = F(0) if answer.exact else turning.NEAR
    truth = judges.Truth((first, last), answer.time, answer.initial, slack, poses, velocity, sharp)
    questions = [Question(FIRST, judges.first_contact(truth))]
    if rng.random() < intervals:
        windows = turning.contact_times(a, b, axis, speed, first, last)
        if windows is not None:
            judge = judges.intervals(windows, (first, last), turning.NEAR)
            questions.append(Question("fc.contact_intervals(a, b, span)", judge))
    if rng.random() < 0.15:
        questions.append(Question("fc.first_contact(a, b, span, exact=True)", judges.first_contact(truth)))
    return Scene(source, "rotation", tuple(questions))


KINDS: tuple[Kind, ...] = (
    *PATHS,
    Kind(
        "meshes/translated solids", "mesh, mesh", _translation([solid]),
        "status, time to the last bit, initial, point, elements and normal of convex solids that meet in features of "
        "all kinds, before, at and after the ends of the span",
        "anything that needs more than some dozen triangles: trees, engines for many elements, budgets",
    ),
    Kind(
        "meshes/translated notches", "mesh, mesh", _translation([notched, solid], 0.2),
        "polygons that are not convex or have holes, parts that slide through them, flat diagonals",
        "planes that are exact only up to rounding",
    ),
    Kind(
        "meshes/translated shells", "mesh, mesh", _translation([hollow, solid], 0.2),
        "containment: solids in solids, voids, loose cores, passage from inside to the wall", "deep nesting",
    ),
    Kind(
        "meshes/translated surfaces", "mesh, mesh", _translation([open_mesh, open_mesh, solid]),
        "open surfaces, bare edges, points, triangles that share no vertices; equal points; which own an inside",
        "surfaces of many pieces",
    ),
    Kind(
        "meshes/translated slivers", "mesh, mesh", _translation([thin, thin, solid], 0.15),
        "needles, ridges that are flat or 2**-60 high or deep, vertices that no double holds",
        "planes through more than four corners that are flat but for rounding",
    ),
    Kind(
        "meshes/translated far and small", "mesh, mesh", _translation([solid, open_mesh, thin], 0.2, grown=_scales),
        "under- and overflow, cancellation far from the origin", "sizes beyond 2**100 and below 2**-300",
    ),
    Kind(
        "meshes/translated for ever", "mesh, mesh", _translation([solid, open_mesh], 0.2, endless=True),
        "spans without end, contacts that never end, late contacts", "times beyond 2**20",
    ),
    Kind(
        "meshes/turned solids", "mesh, mesh", _rotation([solid, small], intervals=0.15),
        "first contacts of turning solids laid on one another at parts of a turn, at Pythagorean angles and at the "
        "last instant; spans that begin in mid-turn, several turns, both about one axis", "many triangles",
    ),
    Kind(
        "meshes/turned surfaces", "mesh, mesh", _rotation([open_mesh, open_mesh, solid], 0.1),
        "edges, points and sheets that turn, also within their own plane and through the axis", "many pieces",
    ),
    Kind(
        "meshes/turned shells and notches", "mesh, mesh", _rotation([hollow, notched, solid], 0.1, intervals=0.02),
        "containment and polygons with holes under rotations", "deep nesting",
    ),
    Kind(
        "meshes/turned slivers", "mesh, mesh", _rotation([thin, solid], 0.1),
        "needles and nearly flat ridges under rotations", "rounded planes",
    ),
    Kind(
        "meshes/turned far and small", "mesh, mesh", _rotation([solid, open_mesh], 0.1, grown=_scales, intervals=0.03),
        "under- and overflow of angles, axes far from the origin", "sizes beyond 2**100 and below 2**-300",
    ),
)
