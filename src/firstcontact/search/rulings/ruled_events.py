"""First contact of two moving ruled pieces: searched in floats with proved bounds, its event refined in balls.

The search leaves the earliest instant at which contact is certain and a time before which it is excluded (see
`kernels.rulings.search`).  Its event is then a zero of a square system over exact numbers; Krawczyk's test gives its
time.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import NamedTuple

import numpy as np
from flint import arb, fmpq

from firstcontact.exact.numbers import (
    above,
    ball_bounds,
    below,
    dyadic,
    exact_value,
    nearest_double,
    precision,
    to_double,
)
from firstcontact.exact.systems.isolation import isolated
from firstcontact.exact.systems.ruled_systems import ContactSystem, Curve
from firstcontact.exact.systems.square_systems import Zero, certified
from firstcontact.kernels.rulings.models import ALL_STRATA, MOST_DEGREE, OFF, ROWS, WIDTH
from firstcontact.kernels.rulings.search import (
    ALL_EVENTS,
    AT_REST,
    COUNTERS,
    DONE,
    FIRST_EVENT,
    FOUND,
    MOST_FOUND,
    PART_P,
    PART_Q,
    SLICE_SPENT,
    SPENT,
    STRATUM,
    SURE,
    VISITS,
    WAITING,
    search,
)
from firstcontact.search.rulings.ruled_pieces import RuledPiece
from firstcontact.work import WORTH

ROOM = 1 << 15
"""Boxes that may wait at a time."""
SLICE = 2000
"""Boxes after which a compiled search comes back for a moment, so that it can be interrupted."""
BITS = 96
"""Of the enclosures of events."""
REGULAR = 1e-9
"""Pivots below this, in rows of unit length, leave a parameter free."""
FEW, MANY = 40, 200
"""Boxes looked at in balls: for all that touch each other, then for one."""
REACH, STAGES = 256.0, 10
"""Widths of the answer over which balls look for events at first, and how often they do."""
STEPS, RANK = 40, 1e-9
"""Newton's steps to a common point at most; slopes below this part of the largest one move nothing."""
LEAST_PART = 2.0**-20
"""Of the span, below which it is not searched in shorter parts."""
ROUNDINGS = 16 * 2.0**-52
"""Times closer than this part of the largest one are not told apart by the search."""


@dataclass(frozen=True)
class RuledEvent:
    """A contact at an end of a stratum's contact set.

    parameters   u, s, v, t in doubles; u, v are None at infinity.
    sides        for u, s, v, t: 0 inside, -1 at the low end, 1 at the high end.
    normal       (3,) unit, from Q towards P; None where the surfaces have none in common.
    zero         the simple zero of the square system, which can be refined; None where the system is singular.
    """

    time: float
    time_interval: tuple[float, float]
    point: np.ndarray
    normal: np.ndarray | None
    parameters: tuple[float | None, float, float | None, float]
    sides: tuple[int, int, int, int]
    zero: Zero | None

    @property
    def elements(self) -> tuple[str, str]:
        """Kinds, of P and of Q: "face", "directrix", "end_ruling" or "vertex"."""
        return outermost(*self.sides[:2])[0], outermost(*self.sides[2:])[0]


@dataclass(frozen=True)
class RuledContact:
    """What the search proved.

    status         "free": no contact in the span; "contact"; "initial": contact at the start; "open".
    free_until     no contact at any time before it.
    time           first contact, the nearest double; time_interval (lo, hi): no contact before lo, one at or before hi.
    reason         of "open": "precision" or "budget".
    latest         of "open": a time until which there is certainly a contact, or None.
    isolated       whether the event's point is proved to be all that the pieces share at the time of contact.
    """

    status: str
    free_until: float
    time: float | None = None
    time_interval: tuple[float, float] | None = None
    event: RuledEvent | None = None
    reason: str | None = None
    latest: float | None = None
    boxes: int = 0
    isolated: bool = False


@dataclass(frozen=True)
class Listed:
    """Where in time an event may be; is_contact: it is a point of both pieces, a zero of the system."""

    time: arb
    kind: np.ndarray
    is_contact: bool = False
    zero: Zero | None = None
    system: ContactSystem | None = None


class Held(NamedTuple):
    """A narrow box (5, 2) around a contact, and its parts and stratum."""

    box: np.ndarray
    kind: np.ndarray


class RulingSearch:
    """Two pieces, and room for the search between them.

    most: boxes, one in balls counting as WORTH others, after which balls are not asked any more.
    """

    def __init__(self, p: RuledPiece, q: RuledPiece, most: float = math.inf) -> None:
        self.p, self.q, self.most = p, q, most
        (self.table_p, self.domain_p), (self.table_q, self.domain_q) = p.arrays, q.arrays
        self.boxes, self.kinds = np.empty((ROOM, 5, 2)), np.empty((ROOM, 3), np.int64)
        self.keys, self.heap, self.slots = np.empty(ROOM), np.empty((ROOM, 2), np.int64), np.empty(ROOM, np.int64)
        self.found, self.found_kinds = np.empty((MOST_FOUND, 5, 2)), np.zeros((MOST_FOUND, 4), np.int64)
        self.times, self.limit = np.zeros((MOST_FOUND, 2)), np.zeros(2)
        self.counters = np.zeros(COUNTERS, np.int64)
        self.workspace = np.zeros((ROWS, WIDTH))
        self.workspace[OFF, :2] = np.add(p.off, q.off)
        self.powers = np.zeros((MOST_DEGREE + 1, MOST_DEGREE + 1))
        self.visits = self.looked = 0
        """Boxes in doubles and in balls."""

    @property
    def done(self) -> int:
        return self.visits + WORTH * self.looked

    @property
    def spent(self) -> int:
        """What budgets count: balls where they are limited."""
        return self.visits if self.most == math.inf else self.done

    @property
    def balls(self) -> float:
        """How many boxes in balls may still be looked at."""
        return max(self.most - self.done, 0) // WORTH

    def run(self, lo: float, hi: float, mode: int, width: float, budget: int) -> int:
        """Search [lo, hi] (AT_REST: for contact at all of these times); times are not split below `width`."""
        n = 0
        for i in range(len(self.table_p)):
            for j in range(len(self.table_q)):
                self.boxes[n] = (-1, 1), (0, 1), (-1, 1), (0, 1), (lo, hi)
                self.kinds[n] = i, j, ALL_STRATA
                self.keys[n], self.heap[n] = lo, (n, 0)
                n += 1
        return self._run(n, lo, hi, mode, width, budget)

    def _run(self, n: int, lo: float, hi: float, mode: int, width: float, budget: int) -> int:
        """Search the first n boxes, in slices."""
        self.limit[:] = np.inf
        self.counters[:] = 0
        while True:
            outcome = search(
                self.table_p, self.domain_p, self.table_q, self.domain_q, mode, self.boxes, self.kinds, self.keys,
                self.heap, self.slots, n, max(hi - lo, width), width, min(int(self.counters[VISITS]) + SLICE, budget),
                self.found, self.found_kinds, self.times, self.limit, self.counters, self.workspace, self.powers,
            )  # fmt: skip
            if outcome != SLICE_SPENT:
                break
            if self.counters[VISITS] >= budget:
                self.limit[0], outcome = min(self.limit[0], self.keys[0]), SPENT
                break
            n = int(self.counters[WAITING])
        self.visits += int(self.counters[VISITS])
        return int(outcome)

    @property
    def count(self) -> int:
        return int(self.counters[FOUND])

    def at_rest(self, lo: float, hi: float, width: float, budget: int = 20_000) -> bool | None:
        """True: a contact at all of these times; False: none at any; None: not decided."""
        outcome = self.run(lo, hi, AT_REST, width, budget)
        if self.count and self.found_kinds[self.count - 1, SURE]:
            return True
        return False if outcome == DONE and not self.count else None

    def held(
        self, lo: float, hi: float, width: float, budget: int, near: Held | None = None, reach: float = 0.0
    ) -> Held | None:
        """A contact proved at all of these times; None without a proof.

        near, reach: looked for that near to another one only, in u, s, v and t of a part.
        """
        if near is None:
            self.run(lo, hi, AT_REST, width, budget)
        else:
            limits = np.array([(to_double(x), to_double(y)) for x, y in self._limits(near.kind)])
            room = reach + (near.box[:4, 1] - near.box[:4, 0])
            self.boxes[0, :4, 0] = np.maximum(near.box[:4, 0] - room, limits[:, 0])
            self.boxes[0, :4, 1] = np.minimum(near.box[:4, 1] + room, limits[:, 1])
            self.boxes[0, 4], self.kinds[0], self.keys[0], self.heap[0] = (lo, hi), near.kind, lo, (0, 0)
            self._run(1, lo, hi, AT_REST, width, budget)
        return self.proved()

    def proved(self) -> Held | None:
        """The contact that `at_rest` has found."""
        row = self.count - 1
        if row < 0 or not self.found_kinds[row, SURE]:
            return None
        return Held(self.found[row].copy(), self.found_kinds[row, :3].copy())

    def event(self, row: int) -> RuledEvent:
        """The certain contact in a row of the boxes found."""
        box, kind = self.found[row], self.found_kinds[row]
        lo, hi = (float(t) for t in self.times[row])
        time, x = 0.5 * (lo + hi), 0.5 * (box[:, 0] + box[:, 1])
        system = self._system(box, kind)
        zero = None if system is None else self._zero(system, box, kind)
        if system is not None and zero is not None:
            return self._event(zero, system, kind)
        return self._described(kind, self._common(kind, x), time, (lo, hi), zero)

    def start(self, row: int) -> RuledEvent:
        """The certain contact at the earliest of its times in a row of the boxes found, which tells of one at rest."""
        box, kind = self.found[row], self.found_kinds[row]
        lo, hi = box[4].tolist()
        x = self._common(kind, np.array([*(0.5 * (box[:4, 0] + box[:4, 1])), lo]))
        return self._described(kind, x, lo, (lo, hi), None)

    def _common(self, kind: np.ndarray, x: np.ndarray) -> np.ndarray:
        """(u, s, v, t, time) with the parameters near x at which the pieces meet at that time.

        Newton's method by least steps within the pieces; what is fixed in the stratum stays.  Where it leads to no
        point of both (at a time a little before a contact), that where they come nearest on the way.
        """
        system = ContactSystem(self._curves(kind), [None] * 4, ())
        limits = np.array([[to_double(c) for c in ends] for ends in self._limits(kind)])
        fixed = [k for k in range(4) if not kind[STRATUM] >> k & 1]
        limits[fixed] = x[fixed, None]
        best, least = x, math.inf
        for _ in range(STEPS):
            with precision(BITS):
                here = [arb(c) for c in x.tolist()]
                gap = np.array([float(c.mid()) for c in system.values(here)])
                slopes = np.array([[float(c.mid()) for c in row[:4]] for row in system.jacobian(here)])
            size = float(np.abs(gap).max())
            if not size < least or not np.all(np.isfinite(slopes)):
                break
            best, least = x, size
            x = np.append(x[:4] + _least_step(slopes, gap, limits - x[:4, None]), x[4])
        return best

    def _system(self, box: np.ndarray, kind: np.ndarray) -> ContactSystem | None:
        """A regular square system of the stratum near the box; parameters that nothing fixes stay in their middle."""
        middle = 0.5 * (box[:, 0] + box[:, 1])
        stratum = [k for k in range(4) if kind[STRATUM] >> k & 1]
        values = [None if k in stratum else exact_value(middle[k]) for k in range(4)]
        curves = self._curves(kind)
        full = ContactSystem(curves, values, list(combinations(stratum, 3)))
        columns = [*stratum, 4]
        with precision(64):
            chosen = _pivots(full.jacobian([arb(middle[k]) for k in columns]))
        solved = {columns[k] for k in chosen.values()}
        if 4 not in solved or not all(k in chosen for k in range(3)):
            return None
        values = [None if k in solved else exact_value(middle[k]) for k in range(4)]
        return ContactSystem(curves, values, [m for k, m in enumerate(full.minors) if 3 + k in chosen])

    def earliest(
        self, lo: float, width: float, reach: float, enough: float, budget: int
    ) -> tuple[float, RuledEvent | None] | None:
        """(a time before which all is free, the contact then), from lo on, in balls; None where they do not tell.

        Without a contact there is none up to lo + reach.  What starts later than anything else by `enough` is left out.
        """
        listed = self.listed(lo, width, reach, budget, enough=enough)
        if listed is None:
            return None
        if not listed:
            return lo + reach, None
        return max(lo, min(_low(x.time) for x in listed)), self._first_of(listed)

    def _first_of(self, listed: list[Listed]) -> RuledEvent | None:
        """The earliest that is a contact, of several at one time that of the lowest stratum."""
        first: Listed | None = None
        for x in listed:
            if x.is_contact and (first is None or x.time < first.time
                                 or (x.time.overlaps(first.time) and _rank(x.kind) < _rank(first.kind))):  # fmt: skip
                first = x
        if first is None:
            return None
        assert first.zero is not None and first.system is not None
        return self._event(first.zero, first.system, first.kind)

    def begun(self, lo: float, hi: float, width: float, budget: int) -> tuple[float, RuledEvent, bool] | None:
        """(a time before which all is free, the event at which contact begins, whether one point is proved to be all
        that the pieces share then), where nothing meets before lo and something does by hi.

        Each point shared at the first time of contact is where contact of its stratum begins, so an event: where all
        that may be one up to hi is one simple zero, there is no other.
        """
        listed = self.listed(lo, width, hi - lo + width, budget)
        event = self._first_of(listed) if listed else None
        if listed is None or event is None or event.time_interval[0] > hi:  # another one, not proved, is the first
            return None
        return max(lo, min(_low(x.time) for x in listed)), event, len(listed) == 1

    def listed(
        self, lo: float, width: float, reach: float, budget: int, most: int = MOST_FOUND, enough: float = math.inf
    ) -> list[Listed] | None:
        """All events from lo to lo + reach, and more that may be none, in balls.

        None where that takes more than `budget` boxes in doubles, leaves more than `most` of them to balls or takes
        more balls than there are.  What starts later than anything else by `enough` is left out.
        """
        outcome = self.run(lo, lo + reach, ALL_EVENTS, max(width, reach / 64), budget)
        if outcome != DONE or self.count > most:
            return None
        found: list[Listed] = []
        earliest = math.inf
        for boxes, kind in _groups(self.found[: self.count], self.found_kinds[: self.count]):
            for box, trials in _in_turn(boxes):
                if box[4, 0] > earliest + enough:
                    break
                if self.balls < 1:
                    return None
                own = self._listed(box, kind, trials)
                if own is None:
                    continue
                found += own
                earliest = min([earliest, *(_low(x.time) for x in own)])
                if trials < MANY:
                    break
        return found

    def _listed(self, box: np.ndarray, kind: np.ndarray, trials: int) -> list[Listed] | None:
        """The events of a box; None where fewer than MANY trials do not isolate them all."""
        system = self._square(box, kind)
        if system is None:
            start, end = (arb(exact_value(t)) for t in box[4].tolist())
            return None if trials < MANY else [Listed(start.union(end), kind)]
        isolation = isolated(system, [_ball_box(box[[*system.free, 4]])], int(min(trials, self.balls)))
        self.looked += isolation.looked
        if isolation.left and trials < MANY:
            return None
        found = [Listed(left[-1], kind) for left in isolation.left]
        for zero in isolation.zeros:
            inside = self._is_inside(system, zero, kind)
            if inside is not False:
                found.append(Listed(zero.balls(BITS)[-1], kind, bool(inside), zero, system))
        return found

    def _square(self, box: np.ndarray, kind: np.ndarray) -> ContactSystem | None:
        """A system in all free parameters whose zeros hold all events in the box; None where it is singular there.

        None for a box that stands for many strata, too: the system of one says nothing of the others.
        """
        if kind[STRATUM] == ALL_STRATA:
            return None
        system = self._system(box, kind)
        free = tuple(k for k in range(4) if kind[STRATUM] >> k & 1)
        return system if system is not None and system.free == free else None

    def _event(self, zero: Zero, system: ContactSystem, kind: np.ndarray) -> RuledEvent:
        balls = zero.balls(BITS)
        with precision(BITS + 64):
            interval = ball_bounds(balls[-1])
            near = nearest_double(balls[-1])
            time = float(balls[-1].mid()) if near is None else near
            everywhere, moment = system.everywhere(balls)
            x = np.array([float(c.mid()) for c in (*everywhere, moment)])
        return self._described(kind, x, time, interval, zero)

    def _is_inside(self, system: ContactSystem, zero: Zero, kind: np.ndarray) -> bool | None:
        """Whether a zero surely lies on both pieces; None where balls do not tell."""
        limits = self._limits(kind)
        with precision(BITS + 64):
            x, _ = system.everywhere(zero.balls(BITS))
            if any(x[k] < arb(limits[k][0]) or x[k] > arb(limits[k][1]) for k in system.free):
                return False
            return all(arb(limits[k][0]) <= x[k] <= arb(limits[k][1]) for k in system.free) or None

    def _limits(self, kind: np.ndarray) -> tuple[tuple[fmpq, fmpq], ...]:
        part_p, part_q = self.p.parts[kind[PART_P]], self.q.parts[kind[PART_Q]]
        return (part_p.lowest, part_p.highest), (fmpq(0), fmpq(1)), (part_q.lowest, part_q.highest), (fmpq(0), fmpq(1))

    def _curves(self, kind: np.ndarray) -> tuple[Curve, Curve, Curve, Curve]:
        return (*self.p.curves(int(kind[PART_P])), *self.q.curves(int(kind[PART_Q])))

    def _zero(self, system: ContactSystem, box: np.ndarray, kind: np.ndarray) -> Zero | None:
        """The only zero near the box, if it surely lies on both pieces."""
        ranges = box[[*system.free, 4]]
        centre = [exact_value(0.5 * (lo + hi)) for lo, hi in ranges]
        radii = [exact_value((hi - lo) + 1e-12 * (1.0 + abs(lo))) for lo, hi in ranges]
        zero = certified(system, centre, radii, 128)
        if zero is None:
            return None
        return zero if self._is_inside(system, zero, kind) else None

    def _described(
        self, kind: np.ndarray, x: np.ndarray, time: float, interval: tuple[float, float], zero: Zero | None
    ) -> RuledEvent:
        free = int(kind[STRATUM])
        sides = tuple(0 if free >> k & 1 else (1 if x[k] > 0.5 else -1) for k in range(4))
        point, normal = _geometry(self, kind, x, free)
        part_p, part_q = self.p.parts[kind[PART_P]], self.q.parts[kind[PART_Q]]
        return RuledEvent(
            time, interval, point, normal,
            (part_p.in_doubles(x[0]), float(x[1]), part_q.in_doubles(x[2]), float(x[3])),
            (part_p.side(sides[0]), sides[1], part_q.side(sides[2]), sides[3]), zero,
        )  # fmt: skip


def _least_step(slopes: np.ndarray, gap: np.ndarray, room: np.ndarray) -> np.ndarray:
    """The shortest step (n,) for which slopes @ step is nearest to -gap, each part of it within its room (n, 2)."""
    step, free = np.zeros(len(room)), np.ones(len(room), bool)
    for _ in room:
        rest = gap + slopes[:, ~free] @ step[~free]
        step[free] = np.linalg.lstsq(slopes[:, free], -rest, rcond=RANK)[0]
        beyond = free & ((step < room[:, 0]) | (step > room[:, 1]))
        step = np.clip(step, room[:, 0], room[:, 1])
        if not beyond.any():
            break
        free &= ~beyond
    return step


def _rank(kind: np.ndarray) -> int:
    """Of events at one time that of the lowest stratum, the least degenerate, comes first."""
    return int(kind[STRATUM]).bit_count()


def _groups(boxes: np.ndarray, kinds: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """(boxes, kind) of those of one stratum that touch each other, in order of time: near one event may be many."""
    order = np.argsort(boxes[:, 4, 0], kind="stable")
    boxes, kinds = boxes[order], kinds[order]
    group, hulls = np.arange(len(boxes)), boxes.copy()  # hulls[k] is that of a group where group[k] = k
    for k, hull in enumerate(hulls):
        touch = (kinds[:k, :SURE] == kinds[k, :SURE]).all(axis=1) & (group[:k] == np.arange(k))
        touch &= ((hulls[:k, :, 0] <= hull[:, 1]) & (hull[:, 0] <= hulls[:k, :, 1])).all(axis=1)
        near = np.flatnonzero(touch)
        hull[:, 0] = np.minimum(hull[:, 0], hulls[near, :, 0].min(axis=0, initial=np.inf))
        hull[:, 1] = np.maximum(hull[:, 1], hulls[near, :, 1].max(axis=0, initial=-np.inf))
        group[np.isin(group, near)] = k
    for k in np.unique(group):
        yield boxes[group == k], kinds[k]


def _in_turn(boxes: np.ndarray) -> Iterator[tuple[np.ndarray, int]]:
    """The hull of all with a few boxes to look at, then, unless that settles it, each."""
    if len(boxes) > 1:
        yield np.stack([boxes[:, :, 0].min(axis=0), boxes[:, :, 1].max(axis=0)], axis=1), FEW
    for box in boxes:
        yield box, MANY


def _low(time: arb) -> float:
    """A double below all of the ball."""
    with precision(BITS + 64):
        return below(dyadic(arb(time.lower())))


def _ball_box(sides: np.ndarray) -> list[arb]:
    """With a little room."""
    found = []
    for lo, hi in sides:
        m = 0.5 * (lo + hi)
        half = exact_value(0.5 * (hi - lo) * (1.0 + 1e-15) + 1e-15 * (1.0 + abs(m)))
        found.append(arb(exact_value(m), arb(half)))
    return found


def _pivots(slopes: list[list[arb]]) -> dict[int, int]:
    """Columns solved for by elimination with full pivoting, by row; the first three rows come first."""
    rows = [[float(c.mid()) for c in row] for row in slopes]
    rows = [[c / max(math.hypot(*row), 1e-300) for c in row] for row in rows]
    chosen: dict[int, int] = {}
    for step in range(min(len(rows), len(rows[0]))):
        taken = chosen.values()
        size, i, j = max(
            (abs(c), -i, -j) for i, row in enumerate(rows) if i not in chosen and (i < 3 or step >= 3)
            for j, c in enumerate(row) if j not in taken
        )  # fmt: skip
        i, j = -i, -j
        if not size >= REGULAR:
            break
        chosen[i] = j
        for k, row in enumerate(rows):
            if k != i:
                rows[k] = [c - row[j] / rows[i][j] * d for c, d in zip(row, rows[i], strict=True)]
    return chosen


def _geometry(s: RulingSearch, kind: np.ndarray, x: np.ndarray, free: int) -> tuple[np.ndarray, np.ndarray | None]:
    """The point, and the unit normal from Q towards P across all free directions."""
    system = ContactSystem(s._curves(kind), [exact_value(c) for c in x[:4]], ())
    with precision(96):
        p, q = system.jets([arb(float(x[4]))], 1)
        vectors = [np.array([float(c.mid()) for c in v]) for v in (p.point, p.x, p.s, q.x, q.s, p.t, q.t)]
    point, across, moved = vectors[0], vectors[1:5], vectors[5] - vectors[6]
    directions = np.array([v / max(float(np.linalg.norm(v)), 1e-300) for k, v in enumerate(across) if free >> k & 1])
    _, sizes, axes = np.linalg.svd(directions)
    if len(sizes) < 2 or sizes[1] < 1e-9:
        return point, None
    normal = axes[2]
    # P comes towards Q
    return point, normal if float(normal @ moved) <= 0 else -normal


def outermost(u: int, s: int, joined: Collection[str] = ()) -> tuple[str, int]:
    """Kind and number of a piece's element at these sides (-1, 0, 1); joined: borders that belong to the face."""
    u, s = (0 if side and f"{name}{int(side > 0)}" in joined else side for name, side in (("u", u), ("s", s)))
    i, j = int(u > 0), int(s > 0)
    if u:
        return ("vertex", 2 * i + j) if s else ("end_ruling", i)
    return ("directrix", j) if s else ("face", 0)


def first_event(
    p: RuledPiece, q: RuledPiece, first: fmpq, last: fmpq, tolerance: float = 1e-12, budget: int = 200_000
) -> RuledContact:
    """The first contact of two pieces over the closed [first, last]; budget: boxes in doubles at most."""
    return first_event_of(RulingSearch(p, q), first, last, tolerance, budget)


def first_event_of(s: RulingSearch, first: fmpq, last: fmpq, tolerance: float, budget: int) -> RuledContact:
    """As `first_event`; what the search has looked at before does not count."""
    budget += s.spent
    lo, hi = below(first), above(last)
    width = max(0.1 * tolerance * (hi - lo), ROUNDINGS * max(abs(lo), abs(hi)))
    start = s.at_rest(lo, above(first), width, budget - s.spent)
    if start:
        return RuledContact("initial", lo, lo, (lo, above(first)), s.start(s.count - 1), boxes=s.done)
    if start is None:
        return RuledContact("open", lo, reason="budget" if s.spent >= budget else "precision", boxes=s.done)
    part = max((budget - s.spent) // 8, 1)
    begin, end, stage, whole = lo, hi, 0, tolerance * (hi - lo)
    while stage < STAGES:
        outcome = s.run(begin, end, FIRST_EVENT, width, min(part, budget - s.spent))
        answer = _answer(s, outcome, first, last, whole)
        if answer.status == "contact" or (answer.status == "free" and end >= hi):
            return answer
        if answer.status == "free":
            begin, end = end, min(end + 2.0 * (end - begin), hi)
            continue
        begin = max(answer.free_until, begin)
        if answer.reason == "budget":  # boxes that are long in time may crowd out early ones: a shorter part
            if s.spent >= budget or end - begin < LEAST_PART * (hi - lo):
                return answer
            end = begin + 0.125 * (end - begin)
            continue
        if begin >= hi:
            return answer
        reach = min(REACH * 4.0**stage * whole, hi - begin)
        settled = s.earliest(begin, width, reach, whole, max(budget - s.spent, 1))
        if settled is None:
            return replace(answer, reason="budget") if s.balls < 1 else answer
        free, event = settled
        if event is not None:
            return _settled(answer, free, event, last, whole, s)
        if free < begin + reach:
            return replace(answer, free_until=free)
        begin, end, stage = free, max(end, min(free + reach, hi)), stage + 1
        if begin >= hi:
            return RuledContact("free", above(last), boxes=s.done)
    return RuledContact("open", begin, reason="precision", boxes=s.done)


def told_event_of(s: RulingSearch, first: fmpq, last: fmpq, tolerance: float, budget: int) -> RuledContact:
    """As `first_event_of`, with the tightest enclosure of the time, and whether one point is proved to be all of a
    contact."""
    most = s.spent + budget
    found = first_event_of(s, first, last, tolerance, budget)
    if found.status != "contact":
        return found
    assert found.time_interval is not None
    (lo, hi), left = found.time_interval, most - s.spent
    begun = s.begun(lo, hi, tolerance * float(last - first), left) if left > 0 else None
    if begun is None:
        return replace(found, boxes=s.done)
    lo, event, alone = begun
    hi = min(hi, event.time_interval[1])
    time = min(max(event.time, lo), hi)
    return replace(found, free_until=lo, time=time, time_interval=(lo, hi), event=event, isolated=alone, boxes=s.done)


def _settled(
    answer: RuledContact, free: float, event: RuledEvent, last: fmpq, width: float, s: RulingSearch
) -> RuledContact:
    """The answer with what balls have told."""
    hi = event.time_interval[1]
    if hi - free > width or not exact_value(hi) <= last:
        return replace(answer, free_until=max(free, answer.free_until), boxes=s.done)
    time = min(max(event.time, free), hi)
    return RuledContact("contact", free, time, (free, hi), replace(event, time=time), boxes=s.done)


def _answer(s: RulingSearch, outcome: int, first: fmpq, last: fmpq, width: float) -> RuledContact:
    free_until, latest = (float(x) for x in s.limit)
    if outcome == DONE and free_until == math.inf:
        return RuledContact("free", above(last), boxes=s.done)
    reason = "precision" if outcome == DONE else "budget"
    if latest == math.inf:
        return RuledContact("open", free_until, reason=reason, boxes=s.done)
    sure = [k for k in range(s.count) if s.found_kinds[k, SURE] and s.times[k, 0] <= latest]
    # of several at this time the one of the lowest stratum, the least degenerate
    row = min(sure, key=lambda k: (_rank(s.found_kinds[k]), float(s.times[k, 1]), k))
    event = s.event(row)
    hi = min(latest, event.time_interval[1])
    if not exact_value(hi) <= last:
        return RuledContact("open", free_until, reason=reason, boxes=s.done)
    if hi - free_until > width:
        return RuledContact("open", free_until, reason=reason, latest=hi, boxes=s.done)
    time = min(max(event.time, free_until), hi)
    return RuledContact("contact", free_until, time, (free_until, hi), replace(event, time=time), boxes=s.done)
