"""`first_contact` and `contact_intervals` of ruled surfaces, moving or deforming, in exact arithmetic.

One of the two may be a polyhedron: its triangles are pieces (`contact.ruled.triangles`).  Or a solid of planes and
quadrics: signs of polynomials tell what it holds of a piece (`contact.ruled_solid.solid_conditions`).  Solids, and
convex polyhedra where that settles it, are met in doubles with proofs first (`contact.ruled_solid.certified`).
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cmp_to_key, partial
from typing import Any

import numpy as np
from flint import arb, ctx, fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.contact.models.answer import element as element_of_solid
from firstcontact.contact.models.answer import interval_of
from firstcontact.contact.named import element as element_of_piece
from firstcontact.contact.polyhedra.answers import MOST_OTHERS
from firstcontact.contact.ruled import certified, posed
from firstcontact.contact.ruled.triangles import MOST_PAIRS, Interior, near_pairs, triangles_of
from firstcontact.contact.ruled_solid.solid_conditions import SolidConditions
from firstcontact.contact.ruled_solid.solid_times import HeldTimes, solid_times
from firstcontact.contact.ruled_solid.solid_touches import lies, most_of, solid_touch
from firstcontact.contact.signs import starts
from firstcontact.contact.signs.conditions import conditions
from firstcontact.contact.signs.shared_points import Contact
from firstcontact.contact.signs.sheets import MOST_DEGREE, TooLarge, between
from firstcontact.contact.signs.times import Times
from firstcontact.contact.signs.touches import Touch, touch
from firstcontact.errors import InputError, UnsupportedPair
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import below, exact_value, fraction, precision, to_double
from firstcontact.exact.times.instants import enclose
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative.clocks import StraightClock
from firstcontact.motion.relative.polynomial import PolynomialPiece, relative_pieces
from firstcontact.motion.span import common_span
from firstcontact.result import (
    ContactIntervals,
    ContactSet,
    Element,
    ElementPair,
    FirstContact,
    Stats,
    Status,
)
from firstcontact.search.rulings.directrices import DirectrixPiece, directrix_pieces, sides_from
from firstcontact.search.trees.touch import carried_normal
from firstcontact.work import Progress, Spent, Work

BITS = 128
QUICK_DEGREE = 80
"""Of equations that elimination may lead to where the search in doubles takes the pair too."""
MESH_BOXES = 5_000
"""Boxes for a piece and a triangle after which elimination is asked instead."""
NEARBY = fmpq(1, 2**30)
"""Part of the span around a time proved in doubles in which it is decided exactly."""
_ORDER = {"vertex": 0, "apex": 0, "edge": 1, "directrix": 1, "end_ruling": 2, "face": 3}


@dataclass(frozen=True)
class _Pair:
    """Two ruled pieces, or one and a solid, over one piece of their motion; numbers: which pieces of their bodies.

    touch   what meets at a contact
    """

    motion: PolynomialPiece
    times: Times | HeldTimes
    numbers: tuple[int, int]
    touch: Callable[[Contact], Touch]


@dataclass(frozen=True)
class _End:
    """A time: a value of the motion's parameter, or an end of the piece of motion."""

    motion: PolynomialPiece
    root: AlgebraicRoot
    time: fmpq | None

    @classmethod
    def of(cls, motion: PolynomialPiece, root: AlgebraicRoot) -> _End:
        assert motion.end is not None
        if motion.clock.compare(root, motion.start) <= 0:
            return cls(motion, root, motion.start)
        return cls(motion, root, motion.end if motion.clock.compare(root, motion.end) >= 0 else None)

    def compare(self, other: _End) -> int:
        """Of two ends in one piece of motion."""
        if self.time is not None and other.time is not None:
            return int(self.time > other.time) - int(self.time < other.time)
        return self.root.compare(other.root)

    def value(self, exact: bool) -> tuple[float, tuple[float, float], Any]:
        """(nearest double, enclosure, exact time)."""
        if self.time is not None:
            time = self.time
            return *enclose(lambda: time), fraction(time) if exact else None
        rational = self.root.rational
        if rational is not None and isinstance(self.motion.clock, StraightClock):
            found = enclose(lambda: rational)
        else:
            found = enclose(lambda: self.motion.time_of(self.root.enclosure(ctx.prec)))
        return *found, self.motion.exact_time(self.root) if exact else None


def contact_intervals(
    a: Any, b: Any, span: Any, exact: bool, budget: int | None = None, progress: Progress | None = None,
    tolerance: float = 1e-12,
) -> ContactIntervals:
    """All closed times at which the bodies share a point; in doubles, with proofs, where elimination goes too far.

    tolerance: as part of the span, against solids of planes and quadrics only.
    """
    begin = clock.perf_counter()
    first, last = _span(a, b, span)
    shared = {"a": a, "b": b, "span": (to_double(first), to_double(last))}
    work = Work(budget, progress, below(first))
    if _is_with_model(a, b):
        from firstcontact.contact.ruled_solid import first as solid_answers

        return solid_answers.contact_intervals(a, b, first, last, exact, tolerance, work, begin, shared)
    return _exact_intervals(a, b, first, last, exact, tolerance, budget, work, begin, shared)


def _exact_intervals(
    a: Any, b: Any, first: fmpq, last: fmpq, exact: bool, tolerance: float, budget: int | None, work: Work,
    begin: float, shared: dict[str, Any],
) -> ContactIntervals:
    """Of surfaces, or a surface and a polyhedron; in doubles, with proofs, where elimination goes too far."""
    if not exact and _is_with_convex(a, b):
        from firstcontact.contact.ruled_solid import first as solid_answers

        return solid_answers.contact_intervals(a, b, first, last, False, tolerance, work, begin, shared)
    quick = None if exact else certified.pieces_of(a, b, first, last)
    try:
        windows, reason = all_windows(a, b, first, last, work, MOST_DEGREE if quick is None else QUICK_DEGREE)
    except UnsupportedPair as refusal:
        if exact:
            raise
        try:
            if quick is None:
                return posed.contact_intervals(a, b, first, last, tolerance, work, begin, shared)
            proved = certified.contact_intervals(quick, first, last, tolerance, work, begin, shared)
        except UnsupportedPair:
            raise refusal from None
        if proved.reason != "precision":
            return proved
        try:
            windows, reason = all_windows(a, b, first, last, work, MOST_DEGREE)
        except UnsupportedPair:
            return proved
    return as_intervals(windows, reason, first, last, exact, work, begin, shared)


def all_windows(
    a: Any, b: Any, first: fmpq, last: fmpq, work: Work, most_degree: int
) -> tuple[list[tuple[_End, _End]], str | None]:
    """All closed windows of contact, as far as the budget goes: then the reason is "budget"."""
    windows: list[tuple[_End, _End]] = []
    interior = Interior.of(a, b)
    try:
        for motion, pairs in _pieces(a, b, first, last, work, most_degree):
            found_here = _joined([w for pair in pairs for w in _windows(pair)])
            if interior is not None:
                found_here = _joined([*found_here, *_inside(interior, motion, found_here)])
            for start, end in found_here:
                if windows and start.time is not None and windows[-1][1].time == start.time:
                    windows[-1] = windows[-1][0], end
                else:
                    windows.append((start, end))
    except Spent:
        return windows, "budget"
    return windows, None


def as_intervals(
    windows: list[tuple[_End, _End]], reason: str | None, first: fmpq, last: fmpq, exact: bool, work: Work,
    begin: float, shared: dict[str, Any],
) -> ContactIntervals:
    intervals = tuple(interval_of(start, end, exact) for start, end in windows)
    at_start = bool(windows) and windows[0][0].time == first
    status = Status.FREE if not windows else Status.INITIAL_CONTACT if at_start else Status.CONTACT
    until = intervals[0].start if intervals else to_double(last)
    if reason is not None:
        status, until = Status.UNDECIDED, work.free_until
    return ContactIntervals(intervals, status, until, reason, _stats(work, begin), **shared)


def first_contact(
    a: Any, b: Any, span: Any, exact: bool, method: str, tolerance: float, budget: int | None = None,
    progress: Progress | None = None,
) -> FirstContact:
    """The first shared point: exactly; in doubles, with proofs, on request and where elimination leads far."""
    first, last = _span(a, b, span)
    found = _first_contact(a, b, first, last, exact, method, tolerance, budget, progress)
    if method != "auto" or budget is not None or not starts.is_open(found):
        return found

    def at_rest(p: Any, q: Any) -> FirstContact:
        return _first_contact(p, q, first, first, False, "algebraic", tolerance, None, progress)

    return starts.told_at_rest(found, first, at_rest)


def _first_contact(
    a: Any, b: Any, first: fmpq, last: fmpq, exact: bool, method: str, tolerance: float, budget: int | None,
    progress: Progress | None,
) -> FirstContact:
    begin = clock.perf_counter()
    shared = {"a": a, "b": b, "span": (to_double(first), to_double(last))}
    algebraic = exact or method == "algebraic"
    if _is_with_model(a, b):
        from firstcontact.contact.ruled_solid import first as solid_answers

        return solid_answers.first_contact(a, b, first, last, exact, method, tolerance, budget, progress, shared, begin)
    if not algebraic and _is_with_convex(a, b):
        certain = method == "certified"
        found = _on_convex(a, b, first, last, certain, tolerance, budget, progress, shared, begin)
        if found is not None:
            return found
    if not algebraic and method != "certified" and any(isinstance(shape_of(x), Polyhedron) for x in (a, b)):
        found = _on_mesh(a, b, first, last, tolerance, budget, progress, shared, begin)
        if found is not None:
            return found
    quick = None if algebraic else certified.pieces_of(a, b, first, last)
    if method == "certified" and not exact:
        return _proved(quick, a, b, first, last, tolerance, budget, progress, shared, begin)
    most_degree = MOST_DEGREE if quick is None else QUICK_DEGREE
    try:
        return decided(a, b, first, last, exact, most_degree, budget, progress, shared, begin)
    except UnsupportedPair as refusal:
        if algebraic:
            raise
        try:
            found = _proved(quick, a, b, first, last, tolerance, budget, progress, shared, begin)
        except UnsupportedPair:
            raise refusal from None
    if quick is None or found.reason != "precision":
        return found
    return _exactly(found, lambda: decided(a, b, first, last, False, MOST_DEGREE, budget, progress, shared, begin))


def _proved(
    quick: certified.Pieces | None, a: Any, b: Any, first: fmpq, last: fmpq, tolerance: float, budget: int | None,
    progress: Progress | None, shared: dict[str, Any], begin: float,
) -> FirstContact:
    """The first contact of two surfaces in doubles; raises UnsupportedPair for what they do not take."""
    if quick is not None:
        found = certified.first_contact(quick, first, last, tolerance, budget, shared)
    else:
        found = posed.first_contact(a, b, first, last, tolerance, Work(budget, progress, below(first)), shared)
    return replace(found, stats=found.stats + Stats(seconds=clock.perf_counter() - begin))


def _exactly(proved: FirstContact, decide: Callable[[], FirstContact]) -> FirstContact:
    """What exact arithmetic says, or what doubles have proved where equations are too large for it."""
    try:
        return decide()
    except UnsupportedPair:
        return proved


def _is_with_model(a: Any, b: Any) -> bool:
    """Whether one of the bodies is a solid of planes and quadrics."""
    return any(isinstance(shape_of(x), CompositeQuadric) for x in (a, b))


def _is_with_convex(a: Any, b: Any) -> bool:
    """Whether one of the bodies is a polyhedron that is a solid of planes, too."""
    from firstcontact.contact.reduce import is_small_and_convex

    return any(isinstance(shape_of(x), Polyhedron) and is_small_and_convex(shape_of(x)) for x in (a, b))


def _on_convex(
    a: Any, b: Any, first: fmpq, last: fmpq, certain: bool, tolerance: float, budget: int | None,
    progress: Progress | None, shared: dict[str, Any], begin: float,
) -> FirstContact | None:
    """In doubles, and exactly what they leave open unless `certain`; None where doubles do not take the bodies."""
    from firstcontact.contact.ruled_solid import certified as solids

    try:
        proved = solids.first_contact(a, b, first, last, tolerance, budget)
    except UnsupportedPair:
        return None
    if certain or _is_settled(proved):
        return proved
    return _exactly(proved, lambda: decided(a, b, first, last, False, MOST_DEGREE, budget, progress, shared, begin))


def _on_mesh(
    a: Any, b: Any, first: fmpq, last: fmpq, tolerance: float, budget: int | None, progress: Progress | None,
    shared: dict[str, Any], begin: float,
) -> FirstContact | None:
    """In doubles, and what meets exactly, around the time proved, where equations are small; None where they fail.

    Elimination over all the span takes every triangle that the surface comes near.
    """
    try:
        work = Work(budget, progress, below(first))
        proved = posed.first_contact(a, b, first, last, tolerance, work, shared, MESH_BOXES)
    except UnsupportedPair:
        return None
    proved = replace(proved, stats=proved.stats + Stats(seconds=clock.perf_counter() - begin))
    if proved.status is Status.UNDECIDED and proved.reason == "precision":
        return None
    if proved.time_interval is None or proved.initial == "containment":
        return proved
    room = NEARBY * (last - first)
    lo, hi = (exact_value(t) for t in proved.time_interval)
    lo, hi = max(first, lo - room), min(last, hi + room)
    found = _exactly(proved, lambda: decided(a, b, lo, hi, False, QUICK_DEGREE, budget, progress, shared, begin))
    return found if found.status is proved.status else proved


def _is_settled(proved: FirstContact) -> bool:
    """Whether exact arithmetic has nothing to add: the bodies are free, the budget is spent or one point touches."""
    if proved.status is Status.CONTACT:
        return proved.contact_set is not None
    return proved.status is Status.FREE or proved.reason == "budget"


def decided(
    a: Any, b: Any, first: fmpq, last: fmpq, exact: bool, most_degree: int, budget: int | None,
    progress: Progress | None, shared: dict[str, Any], begin: float,
) -> FirstContact:
    """The first contact in exact arithmetic; raises TooLarge beyond the degree."""
    work = Work(budget, progress, below(first))
    interior = Interior.of(a, b)
    try:
        for motion, pairs in _pieces(a, b, first, last, work, most_degree):
            starts = [(start, pair, lasts) for pair in pairs for start, lasts in _starts(pair)]
            earliest = min((start for start, _, _ in starts), key=cmp_to_key(_End.compare), default=None)
            if interior is not None and motion.start == first and (earliest is None or earliest.time != first):
                end = AlgebraicRoot.of(motion.u_hi) if earliest is None else earliest.root  # type: ignore[arg-type]
                if interior.holds(motion, _inner(motion, AlgebraicRoot.of(motion.u_lo), end)):
                    return _contained(first, exact, shared, _stats(work, begin))
            if earliest is not None:
                now = [(pair, lasts) for start, pair, lasts in starts if start.compare(earliest) == 0]
                work.budget = None  # it is for the time; what meets then is found in any case
                found = _contact(earliest, now, exact, earliest.time == first, shared, interior)
                return replace(found, stats=_stats(work, begin))
    except Spent:
        stats = _stats(work, begin)
        return FirstContact(Status.UNDECIDED, free_until=work.free_until, reason="budget", stats=stats, **shared)
    return FirstContact(Status.FREE, free_until=to_double(last), stats=_stats(work, begin), **shared)


def _span(a: Any, b: Any, span: Any) -> tuple[fmpq, fmpq]:
    first, last = common_span(a, b, span)
    if last is None:
        raise UnsupportedPair("ruled surfaces need a bounded span; give span=(first, last)")
    return first, last


def _pieces(
    a: Any, b: Any, first: fmpq, last: fmpq, work: Work, most_degree: int
) -> Iterator[tuple[PolynomialPiece, list[_Pair]]]:
    """The pieces of the relative motion in time order, with the pairs of pieces of the surfaces that may meet."""
    if isinstance(shape_of(b), CompositeQuadric):
        yield from _pieces_with_solid(a, b, first, last, work, most_degree)
        return
    parts_a, parts_b = _parts(a), _parts(b)
    numbers = [(i, j) for i in range(len(parts_a)) for j in range(len(parts_b))]
    if any(isinstance(shape_of(x), Polyhedron) for x in (a, b)):
        numbers = near_pairs(parts_a, parts_b, first, last)
        if len(numbers) > MOST_PAIRS:
            raise TooLarge(
                f"{a!r} and {b!r}: {len(numbers)} pairs of a piece and a triangle come near each other, too many for "
                "exact arithmetic"
            )
    if not numbers:
        yield from ((motion, []) for motion in relative_pieces(a, b, first, last))
        return
    combined = [(i, j, parts_a[i], parts_b[j]) for i, j in numbers]
    for steps in zip(*(directrix_pieces(x, y, first, last) for _, _, x, y in combined), strict=True):
        work.free_until = below(steps[0].motion.start)
        found = [_pair(*pair, step, work, most_degree) for pair, step in zip(combined, steps, strict=True)]
        yield steps[0].motion, found


def _pair(i: int, j: int, x: Any, y: Any, step: DirectrixPiece, work: Work, most_degree: int) -> _Pair:
    motion, span = step.motion, _span_of(step.motion)
    joined = shape_of(x).joined, shape_of(y).joined
    times = Times(conditions(x, y, step, span), span, work, most_degree)
    return _Pair(motion, times, (i, j), lambda contact: touch(contact, joined))


def _span_of(motion: PolynomialPiece) -> tuple[fmpq, fmpq]:
    if not motion.exact:
        raise UnsupportedPair(f"{motion.of}: the pose before this step is irrational; such steps are not supported")
    assert motion.u_hi is not None
    return motion.u_lo, motion.u_hi


def _pieces_with_solid(
    a: Any, b: Any, first: fmpq, last: fmpq, work: Work, most_degree: int
) -> Iterator[tuple[PolynomialPiece, list[_Pair]]]:
    """As `_pieces`, of a ruled body and a solid of planes and quadrics."""
    pieces: tuple[RuledSurface, ...] = shape_of(a).pieces
    numbers = range(len(pieces))
    near = [i for i, _ in near_pairs(_parts(a), [b], first, last)] if len(pieces) > 1 else numbers
    for motion in relative_pieces(a, b, first, last):
        work.free_until = below(motion.start)
        found = []
        for i in near:
            span, sides = _span_of(motion), sides_from(pieces[i], motion)
            held = SolidConditions.of(pieces[i], sides, shape_of(b), span)
            touches = partial(solid_touch, joined=pieces[i].joined)
            for times in solid_times(held, span, work, most_degree):
                found.append(_Pair(motion, times, (i, 0), touches))
        yield motion, found


def _parts(body: Any) -> list[Any]:
    shape = shape_of(body)
    pieces: tuple[RuledSurface, ...]
    if isinstance(shape, Polyhedron):
        pieces = triangles_of(shape)
    elif hasattr(shape, "pieces"):
        pieces = shape.pieces
    else:
        raise InputError(f"{body!r} is no ruled surface")
    return [Moving(piece, body.motion) if isinstance(body, Moving) else piece for piece in pieces]


def _windows(pair: _Pair) -> Iterator[tuple[_End, _End]]:
    """Closed windows of contact within the piece of motion, whose parameter may reach beyond it."""
    motion = pair.motion
    assert motion.end is not None
    for start, end in pair.times.windows():
        if motion.clock.compare(end, motion.start) >= 0 and motion.clock.compare(start, motion.end) <= 0:
            yield _End.of(motion, start), _End.of(motion, end)


def _starts(pair: _Pair) -> Iterator[tuple[_End, bool]]:
    """The first time of contact in the piece of motion, if there is one, and whether contact lasts after it."""
    motion = pair.motion
    assert motion.end is not None
    for wall, touched, after in pair.times.states():
        if motion.clock.compare(wall, motion.end) > 0:
            return
        if after or (touched and motion.clock.compare(wall, motion.start) >= 0):
            # a cell that begins before the piece does may end before it, too
            if motion.clock.compare(wall, motion.start) < 0 and _next_wall(pair, wall) < 0:
                continue
            yield _End.of(motion, wall), after
            return


def _next_wall(pair: _Pair, wall: AlgebraicRoot) -> int:
    """How the end of the cell after the wall compares with the start of the piece of motion."""
    later = [x for x in pair.times.candidates if x.compare(wall) > 0]
    end = later[0] if later else AlgebraicRoot.of(pair.times.span[1])
    return pair.motion.clock.compare(end, pair.motion.start)


def _by_start(x: tuple[_End, _End], y: tuple[_End, _End]) -> int:
    return x[0].compare(y[0])


def _joined(windows: list[tuple[_End, _End]]) -> list[tuple[_End, _End]]:
    """The union of closed windows in one piece of motion."""
    found: list[tuple[_End, _End]] = []
    for start, end in sorted(windows, key=cmp_to_key(_by_start)):
        if found and start.compare(found[-1][1]) <= 0:
            if end.compare(found[-1][1]) > 0:
                found[-1] = found[-1][0], end
        else:
            found.append((start, end))
    return found


def _inside(
    interior: Interior, motion: PolynomialPiece, windows: list[tuple[_End, _End]]
) -> Iterator[tuple[_End, _End]]:
    """The windows between those of contact of the surfaces in which the solid holds a piece."""
    assert motion.u_hi is not None and motion.end is not None
    walls = [AlgebraicRoot.of(motion.u_lo), *(end.root for w in windows for end in w), AlgebraicRoot.of(motion.u_hi)]
    for k, (lo, hi) in enumerate(zip(walls[::2], walls[1::2], strict=True)):
        at_start, at_end = k == 0, k == len(windows)
        if windows and ((at_start and windows[0][0].time == motion.start) or
                        (at_end and windows[-1][1].time == motion.end)):  # fmt: skip
            continue
        if interior.holds(motion, _inner(motion, lo, hi)):
            yield _End.of(motion, lo), _End.of(motion, hi)


def _inner(motion: PolynomialPiece, lo: AlgebraicRoot, hi: AlgebraicRoot) -> fmpq:
    """A parameter between two walls within the piece of motion; of an instant, its own."""
    if lo.compare(hi) >= 0 or motion.start == motion.end:
        return motion.u_lo
    while True:
        x = between(lo, hi)
        root = AlgebraicRoot.of(x)
        assert motion.end is not None
        if motion.clock.compare(root, motion.start) < 0:
            lo = root
        elif motion.clock.compare(root, motion.end) > 0:
            hi = root
        else:
            return x


def _contained(first: fmpq, exact: bool, shared: dict[str, Any], stats: Stats) -> FirstContact:
    """The result for a start at which the solid holds a piece, and the surfaces share no point."""
    start = shared["span"][0]
    return FirstContact(
        Status.INITIAL_CONTACT, start, (start, start), fraction(first) if exact else None, initial="containment",
        free_until=start, stats=stats, **shared,
    )  # fmt: skip


def _stats(work: Work, begin: float) -> Stats:
    return Stats(0, 0, 0, work.done, clock.perf_counter() - begin)


# -- what meets -----------------------------------------------------------------------------------------------


def _contact(
    start: _End, pairs: list[tuple[_Pair, bool]], exact: bool, initial: bool, shared: dict[str, Any],
    interior: Interior | None,
) -> FirstContact:
    """The result at the first time, the lowest (kind, index) of the pairs of elements first."""
    time, interval, known = start.value(exact)
    touches: dict[tuple[tuple[int, int], ...], tuple[ElementPair, Touch]] = {}
    for pair, lasts in pairs:
        at_start = initial and start.root.rational == pair.times.span[0]
        for contact in pair.times.contact_at_start() if at_start else pair.times.contacts_from(start.root, lasts):
            found = pair.touch(contact)
            named = [
                _named(shared[x], kind, number, x)
                for x, kind, number in zip("ab", found.elements, pair.numbers, strict=True)
            ]
            key = tuple((_ORDER[e.kind], e.index) for e in named if e is not None)
            touches.setdefault(key, (ElementPair(*named), found))  # type: ignore[arg-type]
    status = Status.INITIAL_CONTACT if initial else Status.CONTACT
    answer = FirstContact(status, time, interval, known, free_until=interval[0], **shared)
    if initial:
        how = _lies([pair for pair, _ in pairs]) if interior is None else _overlap(start, interior)
        answer = replace(answer, initial=how)
    if not touches:
        return answer
    (lowest, best), *rest = (touches[key] for key in sorted(touches))
    if lowest.element_b is None:  # inside a solid of planes and quadrics
        lowest = ElementPair(None, None)  # type: ignore[arg-type]
    pose = _pose_of_b(start, shared["b"], time)
    point = pose[:3, :3] @ best.point + pose[:3, 3]
    shown = None
    if not rest and (len(best.shared) > 1 or (not initial and pairs[0][0].times.is_isolated(start.root))):
        shown = _contact_set(best.shared @ pose[:3, :3].T + pose[:3, 3])
    normal = None if best.normal is None or initial else carried_normal(pose, best.normal)
    return replace(
        answer, point=point, normal=normal, element_a=lowest.element_a, element_b=lowest.element_b,
        others=tuple(p for p, _ in rest[:MOST_OTHERS]), multiplicity=len(touches),
        contact_set=shown,
    )  # fmt: skip


def _overlap(start: _End, interior: Interior) -> str | None:
    """How a surface meets a polyhedron at the start; None where that may hold inner points that were not found."""
    if start.root.rational is None:
        return None
    if interior.is_convex:
        return interior.lies(start.motion, start.root.rational)
    return "overlapping" if interior.shares_inner_points(start.motion, start.root.rational) else None


def _lies(pairs: list[_Pair]) -> str:
    """How surfaces in contact at the start lie to each other, or a surface to a solid of planes and quadrics."""
    held = (pair.times.conditions for pair in pairs)
    return most_of(lies(c, pairs[0].motion.u_lo) for c in held if isinstance(c, SolidConditions))


def _contact_set(points: np.ndarray) -> ContactSet:
    return ContactSet("point" if len(points) == 1 else "segment", points)


def _named(body: Any, element: tuple[str, int], number: int, which: str) -> Element | None:
    """None for a point inside a solid of planes and quadrics."""
    kind, index = element
    shape = shape_of(body)
    if isinstance(shape, CompositeQuadric):
        return None if index is None else element_of_solid(shape, index, which)  # type: ignore[arg-type]
    return element_of_piece(body, kind, index, number, which)


def _pose_of_b(start: _End, b: Any, time: float) -> np.ndarray:
    frame = start.motion.frame
    if frame is None:  # bodies that turn about one line at different speeds
        return np.asarray(b.motion(time), float)
    u = start.root.enclosure(BITS)
    with precision(BITS):
        rows = [[x(u) for x in row] for row in frame]
        return np.array([[float((x / arb(rows[3][3])).mid()) for x in row] for row in rows])
