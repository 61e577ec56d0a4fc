"""Laws that hold whatever the truth is, written as text behind the text of a scene.

A trial asks the library twice (or more) and compares the answers with each other: it knows no truth, so it cannot see
a mistake that both answers make.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction as F
from random import Random
from typing import Any

from .scene import Scene


@dataclass(frozen=True, slots=True)
class Trial:
    """One law on one scene.

    source  text behind the scene's own.
    calls   expressions whose answers judge(...) compares; what is wrong in one line, or None.
    """

    law: str
    source: str
    calls: tuple[str, ...]
    judge: Callable[..., str | None]


WHOLE = "fc.first_contact(a, b, span)"
TRIED = 3
"""Laws tried on a scene: all of them would be slower than the scene itself by far."""

CARRIED = '''
def mapped(P, v, w):
    return [sum(P[i][j] * F(str(v[j])) for j in range(3)) + w * P[i][3] for i in range(3)]

def times(A, B):
    return [[sum(A[i][k] * B[k][j] for k in range(4)) for j in range(4)] for i in range(4)]

def carried(m, P, Q, k):
    """The motion m of a body as that of the body under P = (similarity with the factor k), Q its inverse."""
    kind = type(m).__name__
    if kind == "Translation":
        return fc.Translation(mapped(P, m.vector, 0))
    if kind in ("Rotation", "Screw"):
        turn = {m.unit: F(str(m.angle))}
        if kind == "Screw":
            turn["advance"] = F(str(m.advance)) * k
        return getattr(fc, kind)(mapped(P, m.axis, 0), mapped(P, m.point, 1), **turn)
    if kind == "RationalMotion":
        return fc.RationalMotion([times(times(P, [[F(str(x)) for x in r] for r in C]), Q) for C in m.coefficients])
    ends = [F(0)] + [F(str(end)) for end in m.ends]
    return fc.Sequence([carried(s, P, Q, k) for s in m.steps], durations=[u - v for v, u in zip(ends, ends[1:])])

def placed(body, P, Q, k):
    if isinstance(body, fc.Moving):
        return body.body.transformed(P).moving(carried(body.motion, P, Q, k))
    return body.transformed(P)

'''
CARRIED_KINDS = {"Translation", "Rotation", "Screw", "RationalMotion", "Sequence"}

REVERSED = '''
def backwards(m):
    """The motion m with the clock running backwards from 0."""
    kind = type(m).__name__
    if kind == "Translation":
        return fc.Translation([-F(str(x)) for x in m.vector])
    turn = {m.unit: -F(str(m.angle))}
    if kind == "Screw":
        turn["advance"] = -F(str(m.advance))
    return getattr(fc, kind)([F(str(x)) for x in m.axis], [F(str(x)) for x in m.point], **turn)

def back(body):
    return body.body.moving(backwards(body.motion)) if isinstance(body, fc.Moving) else body

'''
REVERSED_KINDS = {"Translation", "Rotation", "Screw"}


def trials(scene: Scene, names: dict[str, Any], rng: Random) -> list[Trial]:
    """Some of the laws that can be tried on the scene, whose text has been run in `names`."""
    import firstcontact as fc

    a, b = names["a"], names["b"]
    motions = {type(body.motion).__name__ for body in (a, b) if isinstance(body, fc.Moving)}
    span = names.get("span")
    meshes = all(isinstance(getattr(body, "body", body), fc.Polyhedron) for body in (a, b))
    if not any(question.call.startswith("fc.first_contact(") for question in scene.questions):
        return []
    makers: list[Callable[[], Trial | None]] = [
        lambda: _swapped(_size(a, b)), lambda: _split(rng, _span(a, b, span)), lambda: _split_at_contact(),
        lambda: _exact(), lambda: _tolerances(), lambda: _budgets(rng),
    ]
    if motions <= CARRIED_KINDS:
        makers += [lambda: _placed(rng), lambda: _scaled(rng)]
    finite = all(math.isfinite(float(end)) for end in _span(a, b, span))
    if finite:
        makers += [lambda: _intervals()]
        if motions <= REVERSED_KINDS:
            makers += [lambda: _reversed(_span(a, b, span))]
    if meshes and motions <= {"Translation", "Rotation"}:
        makers += [lambda: _engines(rng)]
    chosen = rng.sample(makers, min(TRIED, len(makers)))
    return [trial for trial in (make() for make in chosen) if trial is not None]


def _span(a: Any, b: Any, span: Any) -> tuple[Any, Any]:
    if span is not None:
        return span[0], span[1]
    spans = [_exact_span(body.motion) for body in (a, b) if hasattr(body, "motion")] or [(0.0, 1.0)]
    return max(s[0] for s in spans), min(s[1] for s in spans)


def _exact_span(motion: Any) -> tuple[Any, Any]:
    """Sequences may end at a time that is no double, and land there."""
    return (F(0), F(str(motion.ends[-1]))) if type(motion).__name__ == "Sequence" else motion.span


def _size(a: Any, b: Any) -> float:
    """The largest finite extent of the bodies at rest; 1 where both are unbounded."""
    extents = []
    for body in (a, b):
        lower, upper = getattr(body, "body", body).bounds()
        extents += [float(high - low) for low, high in zip(lower, upper, strict=True)]
    return max((x for x in extents if math.isfinite(x)), default=1.0)


def _clock(x: Any) -> str:
    """A time as text."""
    if isinstance(x, F):
        return number(x)
    return repr(x) if math.isfinite(x) else f"float('{x!r}')"


# ---- what two answers have in common ----


def _meet(p: tuple[float, float], q: tuple[float, float]) -> bool:
    return p[0] <= q[1] and q[0] <= p[1]


def _same(one: Any, two: Any, initial: bool = True) -> str | None:
    """What keeps two first contacts from being one, but for elements, point and normal."""
    s, t = one.status.name, two.status.name
    if "UNDECIDED" in (s, t):
        for open_, other in ((one, two), (two, one)):
            if open_.status.name == "UNDECIDED" and other.status.name in ("CONTACT", "INITIAL_CONTACT"):
                if open_.free_until is not None and open_.free_until > other.time_interval[1]:
                    return f"UNDECIDED but free until {open_.free_until!r}; {other.status.name} at {other.time!r}"
        return None
    if s != t:
        return f"{s} (at {one.time!r}) and {t} (at {two.time!r})"
    if s == "FREE":
        return None
    if not _meet(one.time_interval, two.time_interval):
        return f"{s} at {one.time_interval} and {two.time_interval}"
    if initial and s == "INITIAL_CONTACT" and None not in (one.initial, two.initial) and one.initial != two.initial:
        return f"initial {one.initial!r} and {two.initial!r}"
    return None


def _alone(hit: Any) -> bool:
    """Whether the answer says that one pair of elements meets, and no other.  Of meshes all pairs are listed always."""
    meshes = all(type(getattr(x, "body", x)).__name__ == "Polyhedron" for x in (hit.a, hit.b))
    told = hit.contact_set == "point" or (meshes and hit.contact_set is None)
    return hit.status.name == "CONTACT" and hit.multiplicity == 1 and told


def _element(element: Any) -> tuple[str, int]:
    return element.kind, element.index


# ---- the laws ----


def _swapped(size: float) -> Trial:
    def judge(one: Any, two: Any) -> str | None:
        wrong = _same(one, two)
        if wrong or not (_alone(one) and _alone(two)):
            return wrong
        if (_element(one.element_a), _element(one.element_b)) != (_element(two.element_b), _element(two.element_a)):
            return f"elements {one.element_a}, {one.element_b} and {two.element_a}, {two.element_b}"
        place = max(abs(x) for x in one.point)
        if max(abs(one.point - two.point)) > 1e-9 * size + 8 * math.ulp(place):
            return f"points {one.point.tolist()} and {two.point.tolist()}"
        if (one.normal is None) != (two.normal is None):
            return f"normals {one.normal} and {two.normal}"
        if one.normal is not None and max(abs(one.normal + two.normal)) > 1e-9:
            return f"normals {one.normal.tolist()} and {two.normal.tolist()}"
        return None

    return Trial("swap", "", (WHOLE, "fc.first_contact(b, a, span)"), judge)


def _split(rng: Random, span: tuple[Any, Any]) -> Trial | None:
    first, last = float(span[0]), float(span[1])
    part = rng.choice((0.5, 0.25, 0.75, 0.375, 0.125, 0.9))
    middle = first + part * (last - first) if math.isfinite(last) else first + rng.choice((0.5, 1.0, 4.0))
    if not first < middle < last:
        return None
    return _halves(f"first, middle, last = {_clock(span[0])}, {middle!r}, {_clock(span[1])}\n")


def _split_at_contact() -> Trial:
    text = "hit = fc.first_contact(a, b, span)\nfirst, last = hit.span\n"
    text += "inner = hit.time is not None and first < hit.time < last\n"
    text += "middle = hit.time if inner else (first + min(last, first + 1)) / 2\n"
    return _halves(text, "split at the contact")


def _halves(text: str, law: str = "split") -> Trial:
    def judge(whole: Any, one: Any, two: Any) -> str | None:
        if one.status.name != "FREE":
            if whole.status.name == "FREE" and one.status.name != "UNDECIDED":
                return f"FREE in the whole span, {one.status.name} at {one.time!r} in its first part"
            if one.status.name == "UNDECIDED" and whole.status.name == "FREE":
                return None
            return _same(whole, one)
        if whole.status.name == "INITIAL_CONTACT":
            return "INITIAL_CONTACT in the whole span, FREE in its first part"
        if two.status.name == "INITIAL_CONTACT":
            # the bodies meet at the middle, which belongs to both parts
            return f"the first part is FREE, the second one begins with INITIAL_CONTACT at {two.time!r}"
        return _same(whole, two)

    calls = (WHOLE, "fc.first_contact(a, b, (first, middle))", "fc.first_contact(a, b, (middle, last))")
    return Trial(law, text, calls, judge)


QUATERNIONS = (
    (1, 2, 2, 4), (2, 1, 0, 0), (1, 1, 1, 1), (3, 0, 1, 0), (1, 1, 0, 0), (4, 2, 2, 1), (0, 1, 2, 2), (0, 1, 0, 0),
)


def rotation(q: tuple[int, int, int, int]) -> list[list[F]]:
    """The rotation matrix of the quaternion w, x, y, z of any length, exact."""
    w, x, y, z = (F(c) for c in q)
    n = w * w + x * x + y * y + z * z
    return [
        [(w * w + x * x - y * y - z * z) / n, 2 * (x * y - w * z) / n, 2 * (x * z + w * y) / n],
        [2 * (x * y + w * z) / n, (w * w - x * x + y * y - z * z) / n, 2 * (y * z - w * x) / n],
        [2 * (x * z - w * y) / n, 2 * (y * z + w * x) / n, (w * w - x * x - y * y + z * z) / n],
    ]


def _matrix(name: str, rows: list[list[F]]) -> str:
    cells = ["[" + ", ".join(number(x) for x in row) + "]" for row in rows]
    return f"{name} = [" + ", ".join(cells) + "]\n"


def number(x: Any) -> str:
    """An exact number as program text."""
    x = F(x)
    return str(x.numerator) if x.denominator == 1 else f"F({x.numerator}, {x.denominator})"


def _placed(rng: Random) -> Trial:
    turn = rotation(rng.choice(QUATERNIONS))
    shift = [F(rng.randint(-40, 40), rng.choice((1, 2, 3, 8))) for _ in range(3)]
    forth = [[*turn[i], shift[i]] for i in range(3)] + [[F(0), F(0), F(0), F(1)]]
    transposed = [[turn[j][i] for j in range(3)] for i in range(3)]
    away = [-sum(transposed[i][j] * shift[j] for j in range(3)) for i in range(3)]
    back = [[*transposed[i], away[i]] for i in range(3)] + [[F(0), F(0), F(0), F(1)]]
    text = CARRIED + _matrix("P", forth) + _matrix("Q", back)
    text += "c, d = placed(a, P, Q, 1), placed(b, P, Q, 1)\n"

    def judge(one: Any, two: Any) -> str | None:
        wrong = _same(one, two)
        if wrong or not (_alone(one) and _alone(two)):
            return wrong
        if (_element(one.element_a), _element(one.element_b)) != (_element(two.element_a), _element(two.element_b)):
            return f"elements {one.element_a}, {one.element_b} and {two.element_a}, {two.element_b}"
        return None

    return Trial("common placement", text, (WHOLE, "fc.first_contact(c, d, span)"), judge)


def _scaled(rng: Random) -> Trial:
    power = rng.choice((-120, -60, -40, -20, -3, 1, 20, 40, 60, 120))
    text = CARRIED + f"k = F(2) ** {power}\n"
    text += "P = [[k, 0, 0, 0], [0, k, 0, 0], [0, 0, k, 0], [0, 0, 0, 1]]\n"
    text += "Q = [[1 / k, 0, 0, 0], [0, 1 / k, 0, 0], [0, 0, 1 / k, 0], [0, 0, 0, 1]]\n"
    text += "c, d = placed(a, P, Q, k), placed(b, P, Q, k)\n"
    return Trial("scale by a power of two", text, (WHOLE, "fc.first_contact(c, d, span)"), _same)


def _listed(answer: Any) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    return [(interval.start_interval, interval.end_interval) for interval in answer.intervals]


def _reversed(span: tuple[Any, Any]) -> Trial:
    def judge(forth: Any, back: Any) -> str | None:
        if "UNDECIDED" in (forth.status.name, back.status.name):
            return None
        there = _listed(forth)
        here = [((-q[1], -q[0]), (-p[1], -p[0])) for p, q in reversed(_listed(back))]
        same = len(there) == len(here)
        if not same or not all(_meet(p[i], q[i]) for p, q in zip(there, here, strict=True) for i in (0, 1)):
            return f"intervals {there} and, backwards, {here}"
        return None

    first, last = span
    text = REVERSED + f"forth = ({_clock(first)}, {_clock(last)})\nahead = (-forth[1], -forth[0])\n"
    calls = ("fc.contact_intervals(a, b, span)", "fc.contact_intervals(back(a), back(b), ahead)")
    return Trial("time reversal", text, calls, judge)


def _engines(rng: Random) -> Trial:
    engine = rng.choice(("boxes", "lifted", "composed", "sweep"))

    def judge(one: Any, two: Any) -> str | None:
        wrong = _same(one, two)
        if wrong or one.status.name != "CONTACT" or two.status.name != "CONTACT":
            return wrong
        if one.time != two.time or one.multiplicity != two.multiplicity:
            return f"time {one.time!r} x{one.multiplicity} and {two.time!r} x{two.multiplicity}"
        pairs = [(_element(hit.element_a), _element(hit.element_b)) for hit in (one, two)]
        return None if pairs[0] == pairs[1] else f"elements {pairs[0]} and {pairs[1]}"

    return Trial(f"engine {engine}", "", (WHOLE, f"fc.first_contact(a, b, span, engine={engine!r})"), judge)


def _exact() -> Trial:
    def judge(one: Any, two: Any) -> str | None:
        wrong = _same(one, two)
        if wrong or two.status.name != "CONTACT" or two.time_exact is None:
            return wrong
        value = float(two.time_exact)
        width = two.time_interval[1] - two.time_interval[0] + 1e-14 * abs(value)
        if not two.time_interval[0] - width <= value <= two.time_interval[1] + width:
            return f"time_exact {value!r} outside {two.time_interval}"
        return None

    return Trial("exact", "", (WHOLE, "fc.first_contact(a, b, span, exact=True)"), judge)


def _tolerances() -> Trial:
    calls = tuple(f"fc.first_contact(a, b, span, tolerance={tolerance})" for tolerance in ("1e-6", "1e-12"))
    return Trial("tolerance", "", calls, _same)


def _budgets(rng: Random) -> Trial:
    budget = rng.choice((1, 2, 5, 10, 50, 200, 1000))
    return Trial("budget", "", (WHOLE, f"fc.first_contact(a, b, span, budget={budget})"), _same)


def _intervals() -> Trial:
    def judge(hit: Any, all_: Any) -> str | None:
        s, t = hit.status.name, all_.status.name
        if "UNDECIDED" in (s, t):
            if t == "UNDECIDED" and not all_.intervals and s in ("CONTACT", "INITIAL_CONTACT"):
                if all_.free_until is not None and all_.free_until > hit.time_interval[1]:
                    return f"no interval until {all_.free_until!r}, first contact at {hit.time!r}"
            if s == "FREE" and all_.intervals or s == "UNDECIDED" and hit.free_until is not None and any(
                interval.start_interval[1] < hit.free_until for interval in all_.intervals
            ):
                return f"{s} until {hit.free_until!r} and intervals {_listed(all_)}"
            return None
        if (s == "FREE") != (len(all_.intervals) == 0):
            return f"first contact {s} at {hit.time!r}, intervals {_listed(all_)}"
        if s == "FREE":
            return None
        if not _meet(hit.time_interval, all_.intervals[0].start_interval):
            return f"first contact in {hit.time_interval}, intervals {_listed(all_)}"
        ends = [x for interval in all_.intervals for x in (interval.start, interval.end)]
        if any(x > y for x, y in zip(ends, ends[1:], strict=False)):
            return f"intervals out of order or overlapping: {_listed(all_)}"
        return None

    return Trial("intervals", "", (WHOLE, "fc.contact_intervals(a, b, span)"), judge)
