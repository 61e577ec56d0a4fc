"""Judges of first contacts and contact intervals of polyhedra, whose truth is known."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction as F
from typing import Any

from .brute import Mesh, cross, distance, dot, inside, share, start_of, whole
from .scene import Judge

Poses = Callable[[Any], tuple[Mesh, Mesh]]
"""The two bodies in the world at a time, exact or to many more digits than a double has."""


@dataclass(frozen=True)
class Truth:
    """What is known of a first contact.

    time      None: free.  slack: how far `time` may be from the truth (0: exact).
    initial   what the bodies do at the start: None (apart), "touching", ..., "any".
    poses     see Poses; None where they are not known to more digits than the library's.
    velocity  of a's point against b's, where two bodies meet.
    sharp     whether the poses at `time` are exact.
    """

    span: tuple[F, F | None]
    time: F | None
    initial: str | None = None
    slack: F = F(0)
    poses: Poses | None = None
    velocity: Callable[[Any], Sequence[Any]] | None = None
    sharp: bool = True


def exactly(x: float) -> F | None:
    return F(float(x)) if math.isfinite(x) else None


def _late(free_until: Any, truth: Truth) -> bool:
    if truth.time is None or free_until is None:
        return False
    at = exactly(free_until)
    return at is None or at > truth.time + truth.slack


def enclosure(interval: Any, value: float, time: F, slack: F, span: tuple[F, F | None], what: str) -> str | None:
    """What is wrong with (lo, hi) and the double nearest the truth."""
    lo, hi = exactly(interval[0]), exactly(interval[1])
    if lo is not None and lo > time + slack or hi is not None and hi < time - slack:
        return f"{what} in {interval!r}, true {float(time)!r}"
    if lo is None or hi is None:
        return None if abs(time) > F(2) ** 1023 else f"{what} in {interval!r}, true {float(time)!r}"
    length = max(F(1), abs(time)) if span[1] is None else span[1] - span[0]
    if hi - lo > F(1, 10**12) * length + 8 * F(math.ulp(float(time))):
        return f"{what} in {interval!r}: too wide"
    if slack == 0 and float(value) != float(time):
        return f"{what} {value!r}, the double nearest the truth is {float(time)!r}"
    if slack and abs(exactly(value) - time) > slack + F(math.ulp(float(time))):
        return f"{what} {value!r}, true {float(time)!r}"
    return None


def first_contact(truth: Truth) -> Judge:
    """The judge of fc.first_contact."""

    def judge(hit: Any) -> str | None:
        status = hit.status.name
        if status == "UNDECIDED":
            if _late(hit.free_until, truth):
                return f"UNDECIDED, but free until {hit.free_until!r}; true contact {float(truth.time)!r}"
            return None
        due = "FREE" if truth.time is None else "CONTACT" if truth.initial is None else "INITIAL_CONTACT"
        if status != due:
            when = "" if truth.time is None else f" at {float(truth.time)!r}"
            return f"{status}, true {due}{when} {truth.initial or ''}"
        if truth.time is None:
            return None
        wrong = enclosure(hit.time_interval, hit.time, truth.time, truth.slack, truth.span, "time")
        if wrong:
            return wrong
        if status == "INITIAL_CONTACT":
            if truth.initial != "any" and hit.initial not in (None, truth.initial):  # None says that none was proved
                return f"initial {hit.initial!r}, true {truth.initial!r}"
            if hit.normal is not None:
                return f"normal {hit.normal.tolist()} at a start in contact"
        if truth.poses is None:
            return None
        return _where(hit, truth)

    return judge


def _where(hit: Any, truth: Truth) -> str | None:
    """What is wrong with point, normal and elements."""
    initial = hit.status.name == "INITIAL_CONTACT"
    bodies = truth.poses(truth.time)
    if hit.point is None:
        return None if initial else "no point"
    rounding = _rounding((*bodies, *truth.poses(truth.span[0])))
    for body, side in zip(bodies, "ab", strict=True):
        off = distance(hit.point, body)
        if off > 1e-9 * size(body) + rounding and not (initial and body.solid and _within(hit.point, body)):
            return f"point {hit.point.tolist()} is {off:.3g} off body {side}, whose size is {size(body):.3g}"
    if initial:
        return None
    elements = (hit.element_a, hit.element_b)
    pieces = [body.element(e.kind, e.index) for body, e in zip(bodies, elements, strict=True)]
    if truth.sharp and not _meet(bodies, pieces):
        return f"elements {elements[0]} and {elements[1]} share no point at that time"
    for body, element, side in zip(bodies, pieces, "ab", strict=True):
        off = min(distance(hit.point, Mesh(body.vertices, (p,), ())) for p in element)
        if off > 1e-9 * size(body) + rounding:
            return f"point {hit.point.tolist()} is {off:.3g} off the element of {side}"
    normal = hit.normal
    if normal is None:
        return None
    if abs(math.sqrt(dot(normal, normal)) - 1) > 1e-9:
        return f"normal {normal.tolist()} is no unit vector"
    if truth.velocity is not None:
        # next to an axis the rounding of the point is all there is of its way
        speed = _unit(truth.velocity(_meeting_place(bodies, pieces) or [F(float(x)) for x in hit.point]))
        if dot(normal, speed) > 1e-9:
            return f"normal {normal.tolist()} points from a towards b"
    leans = [_lean(bodies, (pair.element_a, pair.element_b), normal) for pair in (hit, *hit.others)]
    return leans[0] if None not in leans else None


def _lean(bodies: Sequence[Mesh], elements: Sequence[Any], normal: Any) -> str | None:
    """An element that the normal is not across: it is across both of one of the pairs that are told."""
    for body, e in zip(bodies, elements, strict=True):
        for piece in body.element(e.kind, e.index) if e.kind != "vertex" else ():
            for i in piece[1:]:
                d = _unit([x - y for x, y in zip(body.vertices[i], body.vertices[piece[0]], strict=True)])
                if any(d) and abs(dot(d, normal)) > 1e-8:
                    return f"normal {normal.tolist()} is not across {e.kind} {e.index}"
    return None


def _meeting_place(bodies: Sequence[Mesh], pieces: Sequence[Any]) -> list[Any] | None:
    """Where a vertex is, if one touches, or two edges cross; None where that is not one point."""
    both = list(zip(bodies, pieces, strict=True))
    corners = [body.vertices[p[0]] for body, piece in both for p in piece if len(p) == 1]
    if corners:
        return list(corners[0])
    if any(len(piece) != 1 or len(piece[0]) != 2 for piece in pieces):
        return None
    (p, d), (q, e) = ((x, [v - u for u, v in zip(x, y, strict=True)]) for x, y in (
        [body.vertices[i] for i in piece[0]] for body, piece in both))
    n = cross(d, e)
    if not any(n):
        return None
    share = dot(cross([v - u for u, v in zip(p, q, strict=True)], e), n) / dot(n, n)
    return [x + share * y for x, y in zip(p, d, strict=True)]


def _unit(v: Sequence[Any]) -> list[float]:
    most = max(abs(F(x)) for x in v)
    if most == 0:
        return [0.0, 0.0, 0.0]
    u = [float(F(x) / most) for x in v]
    length = math.sqrt(dot(u, u))
    return [x / length for x in u]


def _within(point: Any, body: Mesh) -> bool:
    try:
        return inside(tuple(F(float(x)) for x in point), body.vertices, body.pieces)
    except AssertionError:
        return True


def _meet(bodies: tuple[Mesh, Mesh], pieces: Sequence[Sequence[tuple[int, ...]]]) -> bool:
    a, b = bodies
    _, places = whole(*a.vertices, *b.vertices)
    first, second = places[: len(a.vertices)], places[len(a.vertices) :]
    return any(share([first[i] for i in p], [second[j] for j in q]) for p in pieces[0] for q in pieces[1])


def size(body: Mesh) -> float:
    """The largest side of the box of a body."""
    return max(float(max(p[k] for p in body.vertices) - min(p[k] for p in body.vertices)) for k in range(3))


def _rounding(bodies: Sequence[Mesh]) -> float:
    """Of a point that a pose in doubles has carried as far as a body has come since the span began."""
    return 16 * math.ulp(max(abs(float(x)) for body in bodies for p in body.vertices for x in p))


def intervals(times: Sequence[tuple[F, F | None]], span: tuple[F, F | None], slack: F = F(0)) -> Judge:
    """The judge of fc.contact_intervals."""

    def judge(answer: Any) -> str | None:
        listed = answer.intervals
        status = answer.status.name
        shown = [(interval.start, interval.end) for interval in listed]
        if status == "UNDECIDED":
            until = None if answer.free_until is None else exactly(answer.free_until)
            missing = [t for t, _ in times[len(listed) :]]
            if until is not None and missing and missing[0] + slack < until and not listed:
                return f"UNDECIDED until {answer.free_until!r}, but contact from {float(missing[0])!r}"
            return None
        if len(listed) != len(times):
            return f"intervals {shown}, true {[(float(s), None if e is None else float(e)) for s, e in times]}"
        if (status == "FREE") != (not times):
            return f"status {status} with intervals {shown}"
        for interval, (start, end) in zip(listed, times, strict=True):
            wrong = enclosure(interval.start_interval, interval.start, start, slack, span, "start")
            if not wrong and end is not None:
                wrong = enclosure(interval.end_interval, interval.end, end, slack, span, "end")
            if not wrong and end is None and interval.end != math.inf:
                wrong = f"end {interval.end!r} of a contact without end"
            if wrong:
                return wrong
        return None

    return judge


def pairs(due: set[tuple[tuple[str, int], tuple[str, int]]]) -> Judge:
    """The judge of fc.contact_pairs: exactly these pairs of (kind, index)."""

    def judge(answer: Any) -> str | None:
        listed = {
            ((p.element_a.kind, p.element_a.index), (p.element_b.kind, p.element_b.index)) for p in answer.pairs
        }
        if listed - due:
            return f"pairs that never meet: {sorted(listed - due)[:3]}"
        if due - listed:
            return f"pairs that are missing: {sorted(due - listed)[:3]}"
        return None

    return judge


def sampled(poses: Poses, span: tuple[F, F], samples: Sequence[F], exact_start: bool) -> Judge:
    """The judge of a first contact of which only poses are known, to some 100 digits.

    Bodies that meet in a sampled pose tell that the first contact is no later; a point on both of them at the time of
    the answer tells that it is no earlier.  A pose before the answer is sampled at steps that shrink towards it.
    """
    first, last = span
    met: dict[F, str | None] = {}

    def meets(t: F) -> str | None:
        if t not in met:
            met[t] = start_of(*(body.mapped(_rounded) for body in poses(t)))
        return met[t]

    def judge(hit: Any) -> str | None:
        status = hit.status.name
        start = meets(first)
        if exact_start:
            if start and status not in ("INITIAL_CONTACT", "UNDECIDED"):
                return f"{status}, but the bodies start {start}"
            if not start and status == "INITIAL_CONTACT":
                return "INITIAL_CONTACT of bodies apart"
        if status == "INITIAL_CONTACT":
            known = exact_start and start != "any"
            return f"initial {hit.initial!r}, true {start!r}" if known and hit.initial != start else None
        if status == "UNDECIDED":
            until = last if hit.free_until is None else exactly(hit.free_until)
            late = [t for t in samples if hit.free_until is not None and t < until and meets(t)]
            return f"free until {hit.free_until!r}, but {meets(late[0])} at {float(late[0])!r}" if late else None
        before = list(samples)
        if status == "CONTACT":
            lo = exactly(hit.time_interval[0])
            before = [t for t in samples if t < lo]
            before += [lo - (last - first) / 10**k for k in (2, 4, 7, 10) if lo - (last - first) / 10**k > first]
        for t in before:
            if meets(t):
                when = "" if status == "FREE" else f" at {hit.time!r}"
                return f"{status}{when}, but the bodies are {meets(t)} at {float(t)!r}"
        if status == "CONTACT":
            time = exactly(hit.time)
            if not first <= time <= last:
                return f"time {hit.time!r} outside of the span"
            return _where(hit, Truth(span, time, poses=poses, sharp=False))
        return None

    return judge


def _rounded(p: Sequence[Any]) -> tuple[F, F, F]:
    return tuple(F(round(x * 2**100), 2**100) for x in p)  # type: ignore[return-value]
