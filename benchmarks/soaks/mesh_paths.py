"""Polyhedra under motions that brute force does not follow: truth by construction, or by samples.

Over a plate that is wider than all that goes on above it, a body meets it when its lowest point has come down, however
it turns and shifts meanwhile: only the height has to be known, and that is chosen.  Everything is then laid askew.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction as F
from random import Random
from typing import Any

from . import judges, shapes
from .brute import Mesh, Point, minus, moved, piece_times, plus, start_of, times
from .choices import direction, hollow, notched, off, open_mesh, random_turn, small, solid, span_text, spot, thin
from .laws import QUATERNIONS, rotation
from .poses import (
    REST,
    UNIT,
    Path,
    applied,
    carried,
    inverse,
    product,
    rational,
    rigid,
    sequence,
    shift,
    trajectory,
    turn,
)
from .scene import Kind, Question, Scene
from .shapes import text, vector
from .turning import Axis, Speed

FIRST = "fc.first_contact(a, b, span)"
ABOUT_Z = ((1, 0, 0, 0), (4, 0, 0, 3), (3, 0, 0, 4), (12, 0, 0, 5), (4, 0, 0, -3), (1, 0, 0, 0))
WHOLE = ((1, 0, 0, 0), (1, 2, 2, 4), (1, 1, 1, 1), (4, 2, 2, 1), (2, 3, 6, 0), (3, 4, 0, 0), (4, 0, 3, 0), (1, 0, 0, 0),
         (2, -1, 2, 4), (6, 2, 0, 3))
"""Quaternions of whole length."""


# ---- over a plate ----


def _askew(rng: Random) -> list[list[Any]]:
    """A rational rigid placement that keeps lengths of axes rational."""
    place = [F(rng.randint(-9, 9), rng.choice((1, 1, 2, 3))) for _ in range(3)]
    if rng.random() < 0.5:
        return rigid(UNIT, place)
    return rigid(rotation(rng.choice(QUATERNIONS)), place)


def _whole(v: Point) -> tuple[int, int, int]:
    """The direction as integers, of the same sense."""
    bottom = 1
    for x in v:
        bottom = bottom * F(x).denominator // _common(bottom, F(x).denominator)
    return tuple(int(F(x) * bottom) for x in v)  # type: ignore[return-value]


def _common(m: int, n: int) -> int:
    while n:
        m, n = n, m % n
    return m


def _low(body: Mesh) -> tuple[F, F]:
    heights = [p[2] for p in body.vertices]
    return min(heights), max(heights)


Heights = list[tuple[F, F]]
"""(time, height of the lowest point over the plate), between which it runs linearly."""


def _meets(heights: Heights, thick: F) -> list[tuple[F, F]]:
    """Closed intervals of the times at which the height lies in [-thick, 0]."""
    found: list[list[F]] = []
    for (s, g), (t, h) in zip(heights, heights[1:], strict=False):
        lo, hi = s, t
        if g == h:
            if not -thick <= g <= 0:
                continue
        else:
            ends = sorted(s + (x - g) / (h - g) * (t - s) for x in (F(0), -thick))
            lo, hi = max(s, ends[0]), min(t, ends[1])
            if lo > hi:
                continue
        if found and lo <= found[-1][1]:
            found[-1][1] = max(found[-1][1], hi)
        else:
            found.append([lo, hi])
    return [(lo, hi) for lo, hi in found]


def _fall(rng: Random) -> tuple[F, F]:
    """Height at 0 and at 1: lands within, at the end, just not, or begins on or in the plate."""
    start = F(rng.choice((1, 2, 3, 5)), rng.choice((1, 1, 2)))
    kind = rng.random()
    if kind < 0.5:
        return start, start - start / F(rng.choice(("1/2", "1/3", "3/4", "5/7", "1/4")))
    if kind < 0.65:
        return start, F(0)
    if kind < 0.8:
        return start, F(rng.choice((-1, 1)), 2 ** rng.choice((10, 20, 30, 40, 50)))
    if kind < 0.87:
        return F(0), rng.choice((start, -start, F(0)))
    if kind < 0.94:
        return F(-1, 2 ** rng.choice((1, 10, 30, 50))), rng.choice((start, -start))
    return start, start + 1


def _aside(rng: Random) -> tuple[F, F]:
    return F(rng.randint(-2, 2)), F(rng.randint(-2, 2), rng.choice((1, 2)))


def _z_axis(rng: Random) -> Axis:
    return Axis((0, 0, rng.choice((1, 1, -1))), (*_aside(rng), F(rng.randint(-1, 1))))


def _rate(rng: Random) -> Speed:
    rate = F(rng.choice(("1/4", "1/2", "-1/4", "1", "-2", "1/3", "1/7", "3/8")))
    return Speed(rate, "turns") if rng.random() < 0.7 else Speed(6 * rate, "radians")


def _placed_turn(axis: Axis, speed: Speed, advance: F, askew: Any) -> Path:
    way, point = carried(tuple(map(F, axis.way)), axis.point, askew)  # type: ignore[arg-type]
    return turn(Axis(_whole(way), point), speed, advance)


def _screw(rng: Random, askew: Any) -> tuple[Path, Heights]:
    axis = _z_axis(rng)
    start, end = _fall(rng)
    path = _placed_turn(axis, _rate(rng), (end - start) * axis.way[2], askew)
    return path, [(F(0), start), (F(1), end)]


def _steps(rng: Random, askew: Any) -> tuple[Path, Heights]:
    steps, durations = [], []
    height = F(rng.choice((1, 2, 3)))
    heights = [(F(0), height)]
    for n in range(rng.randint(2, 4)):
        fall = F(0)
        kind = rng.choice("stst" if n else "srts")
        if kind in "st":
            fall = rng.choice((height, height, height / 2, height * F(3, 2), F(-1, 2), height - F(1, 2**40)))
        if kind == "t":
            way, _ = carried((*_aside(rng), -fall), (F(0), F(0), F(0)), askew)
            steps.append(shift(way))
        else:
            axis = _z_axis(rng)
            steps.append(_placed_turn(axis, _rate(rng), -fall * axis.way[2], askew))
        durations.append(F(rng.choice(("1", "1/2", "1/3", "2"))))
        height -= fall
        heights.append((heights[-1][0] + durations[-1], height))
    return sequence(steps, durations), heights


def _keys(rng: Random, askew: Any) -> tuple[Path, Heights]:
    """Poses turned about the vertical; `between` where there are two."""
    count = rng.choice((2, 2, 3, 4))
    moments = [F(0)]
    for _ in range(count - 1):
        moments.append(moments[-1] + (F(1) if count == 2 else F(rng.choice(("1", "1/2", "3")))))
    start, end = _fall(rng)
    heights = [start, *(rng.choice((F(0), start, start / 2, F(1, 2**30))) for _ in range(count - 2)), end]
    turns = [rng.choice(ABOUT_Z) for _ in range(count)]
    places = [(*_aside(rng), h) for h in heights]
    path = trajectory(moments, places, turns)
    return path, list(zip(moments, heights, strict=True))


def _curve(rng: Random, askew: Any) -> tuple[Path, list[tuple[F, F]] | None, F]:
    """A rational motion whose height is g(t) = e ((t - m)^2 - d^2) + gap: (path, contacts, height at 0)."""
    e = F(rng.choice((1, 2, 4)))
    middle = F(rng.choice(("1/2", "1/4", "1/3", "1", "3/5", "0")))
    reach, gap = rng.choice((
        (F(0), F(0)), (F(0), F(0)), (F(1, 4), F(0)), (F(1, 5), F(0)), (F(1, 2 ** rng.choice((10, 20, 26))), F(0)),
        (F(0), F(1, 2 ** rng.choice((10, 30, 50)))),
    ))
    coefficients = [e * (middle * middle - reach * reach) + gap, -2 * e * middle, e]
    k = rng.choice((F(0), F(0), F(1), F(1, 2), F(-2, 3)))
    x, y = _aside(rng), _aside(rng)
    # (1 + k^2 t^2) times a turn by 2 atan(k t) about z and the shift (x0 t + x1 t^2, ..., g(t))
    entries: dict[tuple[int, int], list[F]] = {
        (0, 0): [F(1), F(0), -k * k], (1, 1): [F(1), F(0), -k * k], (0, 1): [F(0), -2 * k], (1, 0): [F(0), 2 * k],
        (2, 2): [F(1), F(0), k * k], (3, 3): [F(1), F(0), k * k],
    }
    stretch = rng.choice((F(0), F(0), F(1, 2), F(2)))
    if stretch and k == 0:
        entries[0, 0] = [F(1), stretch]
        entries[2, 2] = [F(1), stretch / 2]
    weight = entries[3, 3]
    for row, polynomial in ((0, [F(0), *x]), (1, [F(0), *y]), (2, coefficients)):
        entries[row, 3] = _times(polynomial, weight)
    degree = max(len(p) for p in entries.values())
    matrices = []
    for n in range(degree):
        m = [[F(0)] * 4 for _ in range(4)]
        for (i, j), p in entries.items():
            if n < len(p):
                m[i][j] = p[n]
        matrices.append(product(product(askew, m), inverse(askew)))
    while all(cell == 0 for row in matrices[-1] for cell in row):
        matrices.pop()
    contacts: list[tuple[F, F]] = []
    if gap == 0:
        lo, hi = max(middle - reach, F(0)), min(middle + reach, F(1))
        if lo <= hi:
            contacts.append((lo, hi))
    return rational(matrices), contacts, coefficients[0]


def _times(p: Sequence[F], q: Sequence[F]) -> list[F]:
    total = [F(0)] * (len(p) + len(q) - 1)
    for i, x in enumerate(p):
        for j, y in enumerate(q):
            total[i + j] += x * y
    return total


def _over_plate(kind: str) -> Callable[[Random], Scene]:
    def make(rng: Random) -> Scene:
        body = rng.choice((solid, solid, small, notched, thin, hollow))(rng)
        body = body.mapped(random_turn(rng, 0.2))
        low, high = _low(body)
        body = moved(body, (F(0), F(0), -low), 1)
        tall = high - low
        wide = 40 + int(4 * max(abs(x) for p in body.vertices for x in p))
        thick = rng.choice((0, 1, 4))
        if kind == "curve" and tall < F(1, 4):  # what is thinner may sink below a sheet
            thick = max(thick, 1)
        if thick:
            plate = moved(shapes.box(2 * wide, 2 * wide, thick, polygons=rng.random() < 0.5), (-wide, -wide, -thick), 1)
        else:
            plate = moved(shapes.sheet(2 * wide, 2 * wide), (-wide, -wide, 0), 1)
        askew = _askew(rng) if kind != "keys" else rigid(UNIT, (F(0), F(0), F(0)))
        deep = tall + thick
        slack = F(0)
        if kind == "curve":
            path, contacts, height = _curve(rng, askew)
        else:
            path, heights = {"screw": _screw, "steps": _steps, "keys": _keys}[kind](rng, askew)
            contacts, height = _meets(heights, deep), heights[0][1]
        first, last = path.span
        raised = body if kind in ("curve", "keys") else moved(body, (F(0), F(0), height), 1)
        a, b = raised.mapped(lambda p: applied(askew, p)), plate.mapped(lambda p: applied(askew, p))
        initial = start_of(path.moved(a, first), b) if contacts and contacts[0][0] == first else None
        lines = [f"a = {text(a)}.moving({path.text})", f"b = {text(b)}"]
        swapped = rng.random() < 0.3
        if swapped:
            lines = [f"b = {text(a)}.moving({path.text})", f"a = {text(b)}"]
        source = "\n".join([*lines, "span = None"]) + "\n"

        def poses(t: F) -> tuple[Mesh, Mesh]:
            pair = path.moved(a, t), b
            return pair[::-1] if swapped else pair

        up = minus(applied(askew, (0, 0, 1)), applied(askew, (0, 0, 0)))
        way = times(1 if swapped else -1, up)
        touches = len(contacts) > 0 and kind == "curve" and contacts[0][0] == contacts[0][1]
        time = contacts[0][0] if contacts else None
        truth = judges.Truth((first, last), time, initial, slack, poses, None if touches else lambda _: way, False)
        questions = [Question(FIRST, judges.first_contact(truth))]
        if rng.random() < 0.4 and contacts is not None:
            judge = judges.intervals(contacts, (first, last))
            questions.append(Question("fc.contact_intervals(a, b, span)", judge))
        return Scene(source, path.kind, tuple(questions))

    return make


# ---- samples ----


def _any_axis(rng: Random, screw: bool) -> Axis:
    ways = ((0, 0, 1), (1, 0, 0), (1, 2, 2), (3, 0, 4)) if screw else ((0, 0, 1), (1, 1, 1), (1, -1, 0), (2, 1, 2))
    return Axis(rng.choice(ways), direction(rng, 2))


def _motion(rng: Random, depth: int = 0) -> Path:
    simple, joined = ("shift", "turn", "screw"), ("between", "keys", "sequence")
    kind = rng.choice(simple if depth else simple + joined)
    if kind == "shift":
        return shift(direction(rng, 6))
    if kind == "turn":
        return turn(_any_axis(rng, False), _rate(rng))
    if kind == "screw":
        return turn(_any_axis(rng, True), _rate(rng), F(rng.choice((-4, -1, 1, 2, 5))))
    if kind == "sequence":
        steps = [_motion(rng, 1) for _ in range(rng.randint(2, 3))]
        parts = [F(rng.choice((1, 2, 1)), 4) for _ in steps]
        return sequence(steps, [p / sum(parts) for p in parts])
    while True:
        count = 2 if kind == "between" else 3
        turns = rng.sample(WHOLE, count)
        if all(sum(x * y for x, y in zip(p, q, strict=True)) for p, q in zip(turns, turns[1:], strict=False)):
            break
    places = [times(F(1, 2), direction(rng, 6)) for _ in turns]
    return trajectory([F(k, count - 1) for k in range(count)], places, turns)


def _sampled(both: float) -> Callable[[Random], Scene]:
    def make(rng: Random) -> Scene:
        makers = (solid, solid, small, notched, open_mesh, thin)
        a, b = rng.choice(makers)(rng), rng.choice(makers)(rng)
        a = a.mapped(random_turn(rng, 0.2))
        ours = _motion(rng)
        theirs = _motion(rng) if rng.random() < both else REST
        # a point of one on a point of the other at some time, so that most scenes have a contact
        t = F(rng.choice((1, 1, 2, 3, 4)), rng.choice((4, 5, 4)))
        t = min(t, F(1))
        meeting = theirs.moved(b, t)
        target = plus(spot(rng, meeting), times(off(rng), direction(rng)))
        wanted = applied(inverse(ours.pose(t)), target)
        if any(F(x).denominator.bit_length() > 60 for x in wanted):
            wanted = tuple(F(round(float(x) * 2**20), 2**20) for x in wanted)  # type: ignore[assignment]
        a = moved(a, minus(wanted, spot(rng, a)), 1)
        lines = []
        for name, body, path in (("a", a, ours), ("b", b, theirs)):
            lines.append(f"{name} = {text(body)}" + ("" if path is REST else f".moving({path.text})"))
        first, last = F(0), F(1)
        if rng.random() < 0.2:
            first, last = F(1, 4), F(3, 4)
        source = "\n".join([*lines, f"span = {span_text(rng, first, last)}"]) + "\n"

        def poses(t: F) -> tuple[Mesh, Mesh]:
            return ours.moved(a, t), theirs.moved(b, t)

        samples = sorted(first + (last - first) * F(rng.randint(1, 10**6), 10**6) for _ in range(5))
        kinds = sorted({path.kind for path in (ours, theirs)} - {"rest"})
        judge = judges.sampled(poses, (first, last), samples, first == 0)
        return Scene(source, ", ".join(kinds), (Question(FIRST, judge),))

    return make


# ---- both alike ----


def _alike(rng: Random) -> Scene:
    """One motion for both: what they do at the start they do at all times."""
    a, b = (rng.choice((solid, notched, open_mesh, hollow))(rng) for _ in "ab")
    a = a.mapped(random_turn(rng, 0.2))
    a = moved(a, minus(plus(spot(rng, b), times(off(rng), direction(rng))), spot(rng, a)), 1)
    path = _motion(rng)
    source = f"a = {text(a)}.moving({path.text})\nb = {text(b)}.moving({path.text})\nspan = None\n"
    initial = start_of(a, b)
    span = path.span
    truth = judges.Truth(span, F(0) if initial else None, initial, F(0), None)
    questions = [Question(FIRST, judges.first_contact(truth))]
    if rng.random() < 0.4:
        judge = judges.intervals([span] if initial else [], span)
        questions.append(Question("fc.contact_intervals(a, b, span)", judge))
    return Scene(source, f"{path.kind}, alike", tuple(questions))


# ---- pairs of elements ----


def _pairs(rng: Random) -> Scene:
    """contact_pairs of translated triangle meshes, every pair by brute force."""
    makers = (lambda r: shapes.random_tetrahedron(r), lambda r: shapes.box(1, 2, 2), lambda r: shapes.sheet(3, 2, 1),
              lambda r: shapes.octahedron(2, 2, 1))
    a, b = rng.choice(makers)(rng), rng.choice(makers)(rng)
    a = a.mapped(random_turn(rng, 0.3))
    v = direction(rng, 6)
    a = moved(a, minus(plus(spot(rng, b), times(off(rng), direction(rng))), plus(spot(rng, a), times(F(1, 2), v))), 1)
    source = f"a = {text(a)}.moving(fc.Translation({vector(v)}))\nb = {text(b)}\nspan = (0.0, 1.0)\n"
    due: set[tuple[tuple[str, int], tuple[str, int]]] = set()
    parts = [
        {"vertex": [(i,) for i in range(len(m.vertices))], "edge": m.numbered_edges(), "face": list(m.pieces)}
        for m in (a, b)
    ]
    for kind, other in (("vertex", "face"), ("edge", "edge"), ("face", "vertex")):
        first = Mesh(a.vertices, tuple(parts[0][kind]), ())
        second = Mesh(b.vertices, tuple(parts[1][other]), ())
        for (i, j), (lo, hi) in piece_times(first, second, v).items():
            if lo <= 1 and hi >= 0:
                due.add(((kind, i), (other, j)))
    return Scene(source, "translation", (Question("fc.contact_pairs(a, b, span)", judges.pairs(due)),))


PLATE = "over a plate wider than the motion, whatever turns meanwhile: "
PATHS: tuple[Kind, ...] = (
    Kind(
        "meshes/screwed on a plate", "mesh, mesh", _over_plate("screw"),
        PLATE + "screws that seat flat, on an edge or a vertex, at the last instant, by 2**-50 not, or begin there",
        "contacts with walls",
    ),
    Kind(
        "meshes/steps to a plate", "mesh, mesh", _over_plate("steps"),
        PLATE + "sequences of turns, screws and shifts that land at the end of a step, within one, or rest there",
        "steps that jump",
    ),
    Kind(
        "meshes/poses over a plate", "mesh, mesh", _over_plate("keys"), PLATE + "poses joined by linear quaternions",
        "turns about axes that lie askew",
    ),
    Kind(
        "meshes/curves over a plate", "mesh, mesh", _over_plate("curve"),
        PLATE + "rational motions, also stretching, that graze (double roots), miss by 2**-50, or dip in",
        "degrees above 4",
    ),
    Kind(
        "meshes/any motion", "mesh, mesh", _sampled(0.0),
        "contacts missed or told too early by more than some 1e-9 of the size, in poses computed from the definitions",
        "grazing contacts that are missed, times off by less than 1e-10 of the span",
    ),
    Kind(
        "meshes/any two motions", "mesh, mesh", _sampled(1.0), "the same where both bodies move, each in its own way",
        "as above",
    ),
    Kind(
        "meshes/alike", "mesh, mesh", _alike, "one motion for both, whatever it is: rest",
        "motions that are equal but written differently",
    ),
    Kind(
        "meshes/pairs", "mesh, mesh", _pairs, "element pairs that are missing from contact_pairs or never meet",
        "the list of those that pierce at the start; many elements", laws=False,
    ),
)
