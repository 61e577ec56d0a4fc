"""Moving ruled pieces: first contact and times of contact in floats with proofs, and the linear models under them."""

from __future__ import annotations

import itertools
import random
from fractions import Fraction

import numpy as np
import pytest
from flint import arb, fmpq

import firstcontact as fc
from firstcontact.contact.ruled import certified
from firstcontact.contact.ruled.intervals import certified_intervals
from firstcontact.exact.numbers import precision
from firstcontact.exact.systems.ruled_systems import ContactSystem
from firstcontact.kernels.rulings.linear_models import REST
from firstcontact.kernels.rulings.models import (
    GAP,
    MINORS,
    MOST_DEGREE,
    ROWS,
    WIDTH,
    difference_models,
    minor_models,
)
from firstcontact.search.rulings.ruled_events import RuledContact, RulingSearch, first_event, first_event_of
from firstcontact.search.rulings.ruled_pieces import RuledPiece
from firstcontact.work import WORTH, Query, Work
from ruled_vectors import Vector, value, vectors

UNIT = (-1, 1)
MOVING = {v.name[:3]: v for v in vectors("moving")}
# Starts of contact that the search can only bracket: graze at one instant, contact of edges only, coplanar pieces.
BRACKETED = {"m03": 1e-6, "m08": 1e-9, "m09": 1e-9}
ELEMENTS = {
    "m01": ("face", "directrix"), "m02": ("face", "face"), "m05": ("vertex", "face"), "m07": ("face", "vertex"),
    "m10": ("vertex", "face"), "m11": ("face", "vertex"), "m12": ("face", "directrix"),
    "m13": ("directrix", "face"), "m14": ("face", "vertex"), "m15": ("directrix", "face"),
}  # fmt: skip


def pieces(vector: Vector) -> tuple[RuledPiece, RuledPiece, fmpq, fmpq]:
    first, last = (exact(t) for t in vector.span)
    return RuledPiece.of(vector.p.sides, vector.p.u), RuledPiece.of(vector.q.sides, vector.q.u), first, last


def exact(x: object) -> fmpq:
    f = Fraction(str(x))
    return fmpq(f.numerator, f.denominator)


def ends(vector: Vector) -> list[tuple[float, float]]:
    forms = vector.expected["exact"] or vector.expected["collision_T"]
    return [(float(value(a).mid()), float(value(b).mid())) for a, b in forms]


# -- known answers ------------------------------------------------------------------------------------------


@pytest.mark.share(3)
@pytest.mark.parametrize("name", sorted(MOVING))
def test_first_contact_of_vectors(name: str) -> None:
    p, q, first, last = pieces(MOVING[name])
    found, known = first_event(p, q, first, last), ends(MOVING[name])
    span = float(last - first)
    if name == "m04":
        assert found.status == "free" and not known
    elif name == "m16":
        assert found.status == "initial" and found.time == 0.0
    elif name in ("m03", "m08", "m09"):
        near = BRACKETED[name] if name != "m03" else 1e-20  # a graze that balls come near
        assert found.status == "open" and known[0][0] - near < found.free_until <= known[0][0]
    else:
        assert found.status == "contact" and found.time_interval is not None and found.event is not None
        lo, hi = found.time_interval
        assert lo <= known[0][0] <= hi and hi - lo <= 1e-12 * span
        assert abs(found.time - known[0][0]) <= 2e-16 * max(1.0, abs(known[0][0]))
        assert found.event.zero is not None and found.event.elements == ELEMENTS.get(name, found.event.elements)


@pytest.mark.share(12)
@pytest.mark.parametrize("name", sorted(MOVING))
def test_times_of_contact_of_vectors(name: str) -> None:
    p, q, first, last = pieces(MOVING[name])
    found, known = certified_intervals(p, q, first, last), ends(MOVING[name])
    width = 1e-12 * float(last - first)
    if name in ("m03", "m08", "m09"):
        assert not found.intervals and found.reason == "precision"
        assert known[0][0] - BRACKETED[name] <= found.until <= known[0][0]
        return
    assert len(found.intervals) == len(known)
    for interval, (start, end) in zip(found.intervals, known, strict=True):
        assert interval.start[0] <= start <= interval.start[1] <= interval.start[0] + width
        assert interval.end[0] <= end <= interval.end[1]
        assert interval.open == (name == "m16") and (interval.open or interval.end[1] <= interval.end[0] + width)
    assert found.reason == ("precision" if name == "m16" else None)


def test_whole_parameter_lines() -> None:
    """The example of Chen, Shen and Yuan (2011) with all real u and v, infinity included."""
    p, q, first, last = pieces(MOVING["m01"])
    found = first_event(RuledPiece(p.first, p.second, None), RuledPiece(q.first, q.second, None), first, last)
    assert found.status == "contact" and found.time == -(0.5**0.5) and found.event is not None
    assert np.allclose(found.event.parameters, (1, 0.5**0.5, 2**0.5 - 1, 0), atol=1e-15)
    assert np.allclose(found.event.point, (-1 + 0.5**0.5, 0.5**0.5, 0.5), atol=1e-15)


def test_long_way_around() -> None:
    """A contact at u = infinity: on the circle, the point opposite to u = 0."""
    circle = [[[1], [0], [-1]], [[0], [2], [0]], [[0], [0], [0]], [[1], [0], [1]]]
    raised = [*circle[:2], circle[3], circle[3]]
    wall = [[[-3, 1]], [[-1], [2]], [[-1]], [[1]]], [[[-3, 1]], [[-1], [2]], [[2]], [[1]]]
    found = first_event(RuledPiece(circle, raised, None), RuledPiece(*wall, (fmpq(0), fmpq(1))), fmpq(0), fmpq(3))
    assert found.status == "contact" and found.time == 2.0 and found.event is not None
    assert found.event.parameters[0] is None or abs(found.event.parameters[0]) > 1e12


# -- soundness ----------------------------------------------------------------------------------------------


def some_piece(r: random.Random, degree: int, in_time: int, rational: bool, away: int = 0) -> RuledPiece:
    """Random directrices; the piece comes along x from `away` at T = 0 to its place at T = 1."""

    def curve() -> list:
        size = range(degree + 1), range(in_time + 1)
        x, y, z = ([[fmpq(r.randint(-8, 8), 4) for _ in size[1]] for _ in size[0]] for _ in range(3))
        w = [[fmpq(1)], [fmpq(0)], [fmpq(1)]] if rational else [[fmpq(1)]]
        shift = [[away * c for c in row] + [-away * c for c in row] for row in w]
        return [added(x, shift), y, z, w]

    u = r.choice([(fmpq(0), fmpq(1)), (fmpq(-1), fmpq(1)), (fmpq(-3), fmpq(2))])
    return RuledPiece(curve(), curve(), u)


def added(a: list, b: list) -> list:
    rows = itertools.zip_longest(a, b, fillvalue=[])
    return [[x + y for x, y in itertools.zip_longest(m, n, fillvalue=fmpq(0))] for m, n in rows]


def times(a: list, b: list) -> list:
    """Product of two coefficient tables."""
    n, m = len(a) + len(b) - 1, max(map(len, a)) + max(map(len, b)) - 1
    table = [[fmpq(0)] * m for _ in range(n)]
    for (i, row), (k, other) in itertools.product(enumerate(a), enumerate(b)):
        for (j, x), (h, y) in itertools.product(enumerate(row), enumerate(other)):
            table[i + k][j + h] += x * y
    return table


def at(directrix: list, u: fmpq, t: fmpq) -> list[fmpq]:
    x, y, z, w = (sum((a * u**i * t**j for i, j, a in terms(c)), fmpq(0)) for c in directrix)
    return [x / w, y / w, z / w]


def terms(table: list) -> list[tuple[int, int, fmpq]]:
    return [(i, j, a) for i, row in enumerate(table) for j, a in enumerate(row)]


def ruled(piece: RuledPiece, u: fmpq, s: fmpq, t: fmpq) -> list[fmpq]:
    return [(1 - s) * a + s * b for a, b in zip(at(piece.first, u, t), at(piece.second, u, t), strict=True)]


@pytest.mark.share(6)
@pytest.mark.parametrize("seed", range(6))
def test_models_enclose(seed: int) -> None:
    """P - Q and the determinants at exact points of random boxes lie in their models."""
    r = random.Random(seed)
    p, q = some_piece(r, 3, 2, seed % 2 == 0), some_piece(r, 2, 1, seed % 3 == 0)
    (table_p, _), (table_q, _) = p.arrays, q.arrays
    w, powers = np.zeros((ROWS, WIDTH)), np.zeros((MOST_DEGREE + 1, MOST_DEGREE + 1))
    for _ in range(20):
        i, j, size = r.randrange(len(p.parts)), r.randrange(len(q.parts)), 2.0 ** -r.randint(0, 20)
        lo = np.array([r.uniform(*ends) for ends in ((-1, 0), (0, 0.5), (-1, 0), (0, 0.5), (-2, 2))])
        box = np.column_stack([lo, lo + 0.4 * size * np.array([r.random() for _ in range(5)])])
        if not difference_models(table_p, i, table_q, j, box, w, powers):
            continue
        assert minor_models(15, w) == 4
        system = contact_system(p, q, i, j)
        for _ in range(5):
            place = [fmpq(*x.as_integer_ratio()) for x in (r.uniform(a, b) for a, b in box)]
            e = [float((x - middle(b)) / half(b)) for x, b in zip(place, box, strict=True)]
            with precision(200):
                known = system.values([arb(x) for x in place])
            for row, true in zip([*range(GAP, GAP + 3), *range(MINORS, MINORS + 4)], known, strict=True):
                off = abs(w[row, 0] + w[row, 1:6] @ e - float(true))
                assert off <= w[row, REST] + 1e-14 * (abs(float(true)) + np.abs(w[row]).sum())


def middle(box: np.ndarray) -> fmpq:
    return fmpq(*(0.5 * (box[0] + box[1])).as_integer_ratio())


def half(box: np.ndarray) -> fmpq:
    return fmpq(*(box[1] - box[0]).as_integer_ratio()) / 2


def contact_system(p: RuledPiece, q: RuledPiece, i: int, j: int) -> ContactSystem:
    """All parameters free, all determinants, in the order of the kernels."""
    minors = [(0, 1, 2), (0, 1, 3), (2, 3, 0), (2, 3, 1)]
    return ContactSystem((*p.curves(i), *q.curves(j)), [None] * 4, minors)


def test_jacobian_of_event_systems() -> None:
    r = random.Random(3)
    p, q = some_piece(r, 3, 2, True), some_piece(r, 2, 1, False)
    system = contact_system(p, q, 0, 0)
    with precision(400):
        x = [arb(fmpq(r.randint(-9, 9), 10)) for _ in range(5)]
        slopes, step = system.jacobian(x), arb(2) ** -100
        for k in range(5):
            moved = system.values([c + step if i == k else c for i, c in enumerate(x)])
            for row, after, before in zip(slopes, moved, system.values(x), strict=True):
                assert abs(float((after - before) / step - row[k])) < 1e-20


# -- oracle and laws ----------------------------------------------------------------------------------------


def some_pair(seed: int) -> tuple[RuledPiece, RuledPiece, fmpq, fmpq]:
    r = random.Random(seed)
    p = some_piece(r, r.choice([1, 2, 3]), r.choice([0, 1, 2]), r.random() < 0.4, r.choice([4, 8, -6]))
    return p, some_piece(r, r.choice([1, 2]), r.choice([0, 1]), r.random() < 0.4), fmpq(0), fmpq(2)


def in_doubles(directrix: list, u: np.ndarray, t: float) -> np.ndarray:
    x, y, z, w = (sum(float(a) * u**i * t**j for i, j, a in terms(c)) for c in directrix)
    return np.stack([np.broadcast_to(c / w, u.shape) for c in (x, y, z)], axis=-1)


def distance(p: RuledPiece, q: RuledPiece, t: float, n: int = 60, levels: int = 12) -> float:
    """An upper bound of the distance at a time: that of sampled rulings, samples narrowed about the closest."""
    (a, b), (c, d) = ((float(x) for x in piece.u) for piece in (p, q))
    u, v, best = np.linspace(a, b, n), np.linspace(c, d, n), np.inf
    for _ in range(levels):
        sides = [in_doubles(d, x, t) for piece, x in ((p, u), (q, v)) for d in (piece.first, piece.second)]
        found = between_segments(*sides)
        i, j = np.unravel_index(np.argmin(found), found.shape)
        best = min(best, float(found[i, j]))
        step_u, step_v = (4 * (x[-1] - x[0]) / len(x) for x in (u, v))
        u = np.clip(np.linspace(u[i] - step_u, u[i] + step_u, 15), a, b)
        v = np.clip(np.linspace(v[j] - step_v, v[j] + step_v, 15), c, d)
    return best


def between_segments(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """(n, m) distances of n segments ab from m segments cd."""
    x, y, r = (b - a)[:, None], (d - c)[None], a[:, None] - c[None]
    xx, yy, xy, xr, yr = (np.maximum((m * n).sum(-1), 1e-300) if m is n else (m * n).sum(-1)
                          for m, n in ((x, x), (y, y), (x, y), (x, r), (y, r)))  # fmt: skip
    s = np.clip((xy * yr - xr * yy) / np.maximum(xx * yy - xy * xy, 1e-14 * xx * yy), 0, 1)
    t = np.clip((xy * s + yr) / yy, 0, 1)
    s = np.clip((xy * t - xr) / xx, 0, 1)
    return np.linalg.norm(r + s[..., None] * x - t[..., None] * y, axis=-1)


PAIRS = [0, 1, 2, 3, 4, 5, 6, 7]


@pytest.mark.parametrize("seed", PAIRS)
def test_against_sampling(seed: int) -> None:
    """No sampled rulings meet before the contact; at it, they do."""
    p, q, first, last = some_pair(seed)
    found = first_event(p, q, first, last)
    assert found.status in ("free", "contact", "initial")
    until = min(found.free_until, 2.0)
    for t in np.linspace(0.0, until, 6)[:-1] if until > 0 else []:
        assert distance(p, q, t) > 1e-9
    if found.status == "contact":
        assert found.event is not None
        u, s, v, t = (exact(x) for x in found.event.parameters)
        gap = [x - y for x, y in zip(ruled(p, u, s, exact(found.time)), ruled(q, v, t, exact(found.time)), strict=True)]
        assert all(abs(float(c)) < 1e-11 for c in gap)


def rotated(piece: RuledPiece, scale: fmpq | int = 1) -> RuledPiece:
    """Under a common rational motion: a turn about z, T the tangent of half its angle, and a shift; scaled."""

    def moved(d: list) -> list:
        x, y, z, w = d
        c, s, one, shift = [[1, 0, -1]], [[0, 2]], [[1, 0, 1]], [[0, 3, 1]]
        minus = [[0, -2]]
        rows = [added(times(x, c), times(y, minus)), added(times(x, s), times(y, c)),
                added(times(z, one), times(w, shift))]  # fmt: skip
        return [*([[scale * a for a in line] for line in row] for row in rows), times(w, one)]

    return RuledPiece(moved(piece.first), moved(piece.second), piece.u)


def same_time(a: RuledContact, b: RuledContact, width: float = 4e-12) -> bool:
    if a.status != b.status or a.time is None or b.time is None:
        return a.status == b.status
    return abs(a.time - b.time) <= width


@pytest.mark.parametrize("seed", PAIRS[:4])
def test_laws_of_first_contact(seed: int) -> None:
    p, q, first, last = some_pair(seed)
    found = first_event(p, q, first, last)
    assert same_time(found, first_event(q, p, first, last))
    assert same_time(found, first_event(rotated(p), rotated(q), first, last))
    small = fmpq(1, 2**30)
    assert same_time(found, first_event(rotated(p, small), rotated(q, small), first, last))
    half = (first + last) / 2
    early = first_event(p, q, first, half)
    later = early if early.status != "free" else first_event(p, q, half, last)
    if later.status != "initial" or later is early:
        assert same_time(found, later)


@pytest.mark.parametrize("name", ["m07", "m13", "m15"])
def test_times_of_contact_backwards(name: str) -> None:
    p, q, first, last = pieces(MOVING[name])
    found = certified_intervals(p, q, first, last).intervals
    backwards = certified_intervals(p.reversed(), q.reversed(), -last, -first).intervals
    assert len(found) == len(backwards) > 0
    for x, y in zip(found, reversed(backwards), strict=True):
        assert -y.end[1] <= x.start[1] and x.start[0] <= -y.end[0]
        assert -y.start[1] <= x.end[1] and x.end[0] <= -y.start[0]


# Directrices of P, those of Q, ranges of u and v: surfaces that cross at small angles.
STEEP = {
    "quartic": (
        "((3*u-2*u**2-3*u**4)/(4+8*u**2)+9*T, (3-u+3*u**2-4*u**3+2*u**4)/(4+8*u**2)+T, "
        "(-2+4*u-2*u**2+4*u**3+4*u**4)/(4+8*u**2)+3*T)",
        "(u**2/4+9*T, (1+2*u-4*u**2)/4+T, (-2+u**2)/4+3*T)", (0, 3),
        "((3+2*u+4*u**2)/4+2, (-4-3*u+2*u**2)/4-1, (-1+4*u-2*u**2)/4+3)", "(7/4, -3/4, 15/4)", UNIT),
    "cubic cone": (
        "((3-4*u+2*u**2)/(4+4*u**2)+9*T, (3+2*u-3*u**2)/(4+4*u**2)-2*T, (3-4*u+2*u**2)/(4+4*u**2)-2*T)",
        "(1/(1+2*u**2)+9*T, (4*u-1)/(4+8*u**2)-2*T, (2*u-3)/(4+8*u**2)-2*T)", (0, 3),
        "((-2+3*u-2*u**2+u**3)/4+3, (-1+4*u**2)/4-2, (2-2*u-3*u**3)/4+1)", "(15/4, -5/4, 1)", (0, 3)),
}  # fmt: skip


@pytest.mark.share(2)
@pytest.mark.parametrize("name", STEEP)
def test_steep_surfaces_are_followed_to_the_end_of_contact(name: str) -> None:
    """Rounding errors of doubles hide where contact ends: it is told with time running backwards, and in balls."""
    first, second, u, third, fourth, v = STEEP[name]
    p, q = fc.RuledSurface(first, second, u=u), fc.RuledSurface(third, fourth, u=v)
    (x,) = found = fc.contact_intervals(p, q, (0, 1))
    assert found.reason is None and all(hi - lo <= 2e-12 for lo, hi in (x.start_interval, x.end_interval))
    hit = fc.first_contact(p, q, (0, 1), method="certified")
    assert hit.time_interval[0] <= x.start_interval[1] and x.start_interval[0] <= hit.time_interval[1]
    sides = RuledPiece.of(p.sides, p.u), RuledPiece.of(q.sides, q.u)
    for share, meets in ((-1e-3, False), (0.1, True), (0.5, True), (0.9, True), (1.001, False)):
        t = x.start + share * (x.end - x.start)
        assert (distance(*sides, t, 300, 40) < 1e-7) == meets


# Narrow boxes that stand for many strata were taken for faces, and free as these do not touch; ranges narrowed
# to 1e-311 lost their rounding errors to underflow.
CORNERS = {
    "corner on corner": ("(u, 2-T, 1-T+T**2)", "(u, 3-T, 1-T+T**2)", UNIT, "(u, 1, -u)", (1, 1)),
    "corner on edge": ("(u, -T, -2-T+T**2)", "(u, 1-T, -2-T+T**2)", (0, 1), "(u, 1, u)", (-1, -1)),
    "edge along edge": ("(u+2-T, 0, 0)", "(u+2-T, -2, 1)", (0, 1), "(u, 1, 2)", (1, 2)),
}


@pytest.mark.parametrize("name", CORNERS)
def test_corners_that_meet_are_not_passed_over(name: str) -> None:
    first, second, u, edge, (start, end) = CORNERS[name]
    p, q = fc.RuledSurface(first, second, u=u), fc.RuledSurface("(u, 0, 0)", edge, u=UNIT)
    query = Query(p, q, fmpq(-2), fmpq(2))
    pieces = certified.pieces_of(query)
    assert pieces is not None
    for found in (
        fc.first_contact(p, q, (-2, 2), method="certified"),
        certified.intervals(pieces, query, Work()),
    ):
        assert found.status is not fc.Status.FREE and start - 1e-12 <= found.free_until <= start
    (x,) = fc.contact_intervals(p, q, (-2, 2))
    assert (x.start, x.end) == (start, end)


def test_a_touch_at_the_last_instant_is_seen_backwards_too() -> None:
    """The same of surfaces that elimination leaves to doubles at first."""
    cap = fc.RuledSurface("(u, u**2, 0)", "(u-1, u**2+2*u+1, 2)", u=UNIT).translated((-1, -3, 0))
    leaf = fc.RuledSurface("(u-u**2, -2*u, 2-2*u**2)", "(2+u, 1-u, -1-2*u)")
    (x,) = fc.contact_intervals(cap.moving(fc.Translation((3, 7, -1))), leaf)
    assert (x.start, x.end) == (0, 0)
    back = cap.translated((3, 7, -1)).moving(fc.Translation((-3, -7, 1)))
    (y,) = fc.contact_intervals(back, leaf)
    assert (y.start, y.end) == (1, 1)


def test_budget_leaves_the_rest_open() -> None:
    p, q, first, last = pieces(MOVING["m02"])
    found = first_event(p, q, first, last, budget=200)
    assert found.status == "open" and found.reason == "budget" and 0 <= found.free_until <= 1.5


def test_zeros_are_refined() -> None:
    """The known contact of the first example, enclosed in balls as small as asked for."""
    p, q, first, last = pieces(MOVING["m01"])
    event = first_event(p, q, first, last).event
    assert event is not None and event.zero is not None
    for bits in (96, 400, 1000):
        time = event.zero.balls(bits)[-1]
        with precision(4 * bits):
            assert time.contains(-arb(0.5).sqrt()) and time.rad() < arb(2) ** -bits


@pytest.mark.thorough
def test_balls_count_in_a_budget() -> None:
    """What doubles leave open of a graze took a second in balls, however small the budget."""
    p, q, first, last = pieces(MOVING["m03"])
    whole = RulingSearch(p, q)
    first_event_of(whole, first, last, 1e-12, 200_000)
    assert whole.looked > 0 and whole.spent == whole.visits
    budget = whole.visits + WORTH * (whole.looked // 2)
    cut = RulingSearch(p, q, budget)
    found = first_event_of(cut, first, last, 1e-12, budget)
    assert cut.looked <= max(whole.looked // 2, 1) and cut.spent == cut.visits + WORTH * cut.looked <= 1.2 * budget
    assert found.status == "open" and found.reason == "budget"


def test_models_near_the_end_of_a_ruling_lack_little() -> None:
    """Next to the apex of a cone u moves nothing, so that what a model in u leaves out is small there, too."""
    cone = [[[0], [1]], [[0], [0], [4]], [[1]], [[1]]], [[[3]], [[0]], [[5]], [[1]]]
    wall = [[[0], [1]], [[0]], [[0]], [[1]]], [[[0], [1]], [[0]], [[9]], [[1]]]
    p, q = (RuledPiece(*sides, (fmpq(0), fmpq(1))) for sides in (cone, wall))
    search = RulingSearch(p, q)
    for away in (0.5, 1e-3, 1e-6):
        box = np.array([(-1.0, 0.0), (1.0 - away, 1.0), (0.1, 0.2), (0.1, 0.2), (0.0, 0.0)])
        assert difference_models(search.table_p, 0, search.table_q, 0, box, search.workspace, search.powers)
        assert np.all(search.workspace[GAP : GAP + 3, REST] <= 4 * away + 1e-12)
