"""`first_contact` and `contact_intervals` of composite quadric models."""

from __future__ import annotations

import time as clock
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from flint import fmpq

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.contact.mesh_model.first import first_contact_of_mesh
from firstcontact.contact.mesh_model.mesh_intervals import intervals_of_mesh
from firstcontact.contact.models.algorithm import Meeting, Root, Search, between
from firstcontact.contact.models.answer import contact_of, interval_of, listed, world_time
from firstcontact.contact.models.at_rest import is_containment, overlap_around
from firstcontact.contact.models.certified import both_bounded, contact, settle
from firstcontact.contact.models.idle_turns import without_idle_turn
from firstcontact.contact.models.intervals import Found, certified_intervals
from firstcontact.contact.models.last_instant import landing
from firstcontact.contact.models.moving_pair import Pair
from firstcontact.contact.models.standing import prisms_on_common_plane
from firstcontact.contact.reduce import as_model, is_small_and_convex
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import above, below, fraction, simplest, to_double
from firstcontact.exact.systems.square_systems import OpenRoot
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative.pieces import placement_at
from firstcontact.motion.relative.polynomial import relative_pieces
from firstcontact.motion.span import common_span
from firstcontact.result import ContactInterval, ContactIntervals, FirstContact, Stats, Status
from firstcontact.search.convex.advance import Advance, advance
from firstcontact.work import Progress, Spent, Work

SURELY = 2.0**-30
"""Of a body's size: by how much it is made smaller and larger to see whether rounded poses tell how it starts."""


def first_contact(
    a: Any, b: Any, span: Any, exact: bool, method: str, tolerance: float, budget: int | None,
    progress: Progress | None = None,
) -> FirstContact:
    """The first contact over the span: certified in doubles where that settles it, else decided exactly.

    exact, or method "algebraic": exactly at once; "algebraic" judges and lists every subproblem too.
    """
    begin = clock.perf_counter()
    x, y = without_idle_turn(a), without_idle_turn(b)
    if x is not a or y is not b:
        return _with(first_contact(x, y, span, exact, method, tolerance, budget, progress), a=a, b=b)
    if _goes_by_triangles(a) or _goes_by_triangles(b):
        first, last = bounded_span(a, b, span)
        exact = exact or method == "algebraic"
        return first_contact_of_mesh(a, b, first, last, exact, tolerance, Work(budget, progress))
    models = _models(a, b)
    first, last = _span(models, span)
    shared = {"a": a, "b": b, "span": (to_double(first), to_double(last))}
    if exact or method == "algebraic":
        work = Work(budget, progress, below(first))
        return _decided(a, b, first, last, exact, method == "algebraic", work, begin, shared)
    answer, proved = settle(models, first, last, tolerance, budget, begin, shared)
    if answer is not None:
        return answer
    if proved.reason == "budget" and budget is not None:
        stats = _with_time(Stats(proved.steps, proved.gaps), begin)
        return FirstContact(Status.UNDECIDED, free_until=proved.free_until, reason="budget", stats=stats, **shared)
    work = Work(budget, progress, below(first))
    work.done = proved.steps
    try:
        decided = _decided(a, b, first, last, False, False, work, begin, shared)
    except UnsupportedPair as refusal:
        landed = _landed(*models, last, tolerance, proved, begin, shared)
        return landed if landed is not None else _proved_only(a, b, models, first, proved, refusal, begin, shared)
    if proved.status == "contact" and _is_after(decided, proved):  # a proof is not given up
        return _proved_only(a, b, models, first, proved, None, begin, shared)
    return decided


def _proved_only(
    a: Any, b: Any, models: tuple[Any, Any], first: fmpq, proved: Advance, refusal: UnsupportedPair | None,
    begin: float, shared: dict[str, Any],
) -> FirstContact:
    """What the certified path proved, where exact arithmetic does not take the pair or contradicts."""
    if proved.status == "contact":  # only what it shares is open
        seen, _ = contact(both_bounded(models, shared["span"]), proved, begin, shared)
        if seen is not None:
            return seen
    if proved.status == "initial" or proved.free_until <= shared["span"][0]:
        start = _at_start(a, b, first, begin, shared)
        if start.status is Status.INITIAL_CONTACT:
            return start
        if proved.status == "initial":  # proved for the true pose, though its doubles do not touch
            return _with(start, status=Status.INITIAL_CONTACT, time=shared["span"][0])
    if proved.reason not in ("precision", "budget", None):
        raise UnsupportedPair(
            f"{refusal}; without them it is not decided either: {proved.reason}"
        ) from refusal
    stats = _with_time(Stats(proved.steps, proved.gaps), begin)
    reason = proved.reason or "precision"
    return FirstContact(Status.UNDECIDED, free_until=proved.free_until, reason=reason, stats=stats, **shared)


def _landed(
    a: Any, b: Any, last: fmpq, tolerance: float, proved: Advance, begin: float, shared: dict[str, Any]
) -> FirstContact | None:
    """CONTACT where the bodies are proved free up to the last instant, or up to one of a graze, and touch then."""
    (start, end), free_until, instant = shared["span"], proved.free_until, last
    if proved.graze is not None:
        instant = simplest(*proved.graze)
    elif proved.status != "open" or above(last) - free_until > tolerance * (end - start):
        return None
    found = landing(a, b, instant)
    if found is None:
        return None
    pair = found[0].pair
    seen = contact_of(*found, False, {**shared, "a": pair.a, "b": pair.b})
    return _with(
        seen, a=shared["a"], b=shared["b"], time=to_double(instant), time_interval=(free_until, above(instant)),
        free_until=free_until, stats=_with_time(Stats(proved.steps, proved.gaps), begin),
    )  # fmt: skip


def _is_after(answer: FirstContact, proved: Advance) -> bool:
    """Whether the answer denies the proved contact."""
    assert proved.time_interval is not None and answer.free_until is not None
    return answer.status is Status.FREE or answer.free_until > proved.time_interval[1]


def _at_start(a: Any, b: Any, first: fmpq, begin: float, shared: dict[str, Any]) -> FirstContact:
    """The answer for the start alone: exact where the poses then are rational, else in the poses as doubles.

    Those tell how the bodies touch or overlap where it is the same for one that is a little smaller or larger.
    """
    start = shared["span"][0]
    there = [(placement_at(body, first), body) for body in (a, b)]
    rational = all(pose.is_exact for pose, _ in there)
    x, y = (pose.place(shape_of(body)) if rational else _rounded(body, start) for pose, body in there)

    def decided(x: Any) -> FirstContact:
        return _decided(x, y, first, first, False, False, Work(), begin, {**shared, "span": (start, start)})

    found = decided(x)
    told = rational or found.initial is None or all(decided(z).initial == found.initial for z in _smaller_and_larger(x))
    return _with(found, initial=found.initial if told else None, **shared)


def _rounded(body: Any, t: float) -> Any:
    return body.at(t) if isinstance(body, Moving) else body


def _smaller_and_larger(body: Any) -> list[Any]:
    """By more than rounding of poses moves it."""
    lo, hi = body.bounds()
    middle = np.where(np.isfinite(lo + hi), 0.5 * (lo + hi), 0.0)
    poses = []
    for factor in (1.0 - SURELY, 1.0 + SURELY):
        pose = np.diag([factor, factor, factor, 1.0])
        pose[:3, 3] = (1.0 - factor) * middle
        poses.append(pose)
    return [body.transformed(pose) for pose in poses]


def _models(a: Any, b: Any) -> tuple[Any, Any]:
    """Both as models, at rest or moving as they were."""
    return _as_model(a), _as_model(b)


def _as_model(body: Any) -> Any:
    shape: Any = shape_of(body)
    if not isinstance(shape, Polyhedron):
        return body
    return Moving(as_model(shape), body.motion) if isinstance(body, Moving) else as_model(shape)


def _with_time(stats: Stats, begin: float) -> Stats:
    return stats + Stats(seconds=clock.perf_counter() - begin)


def _decided(
    a: Any, b: Any, first: fmpq, last: fmpq, exact: bool, with_list: bool, work: Work, begin: float,
    shared: dict[str, Any],
) -> FirstContact:
    """The answer of exact arithmetic."""
    searches: list[Search] = []
    answer: FirstContact | None = None
    try:
        for search in _searches(a, b, first, last, work):
            searches.append(search)
            if answer is None:
                answer = _answer(search, len(searches) == 1, exact, shared)
            if answer is not None and not with_list:
                break
    except Spent:
        answer = FirstContact(Status.UNDECIDED, free_until=work.free_until, reason="budget", **shared)
    work.budget = None  # it is for the answer; a list that was asked for is complete
    if answer is None:
        answer = FirstContact(Status.FREE, free_until=to_double(last), **shared)
        if searches and searches[-1].may_share_a_point_at_end():  # an event was missed: never call that free
            answer = FirstContact(Status.UNDECIDED, free_until=shared["span"][0], reason="precision", **shared)
    evaluations = sum(len(search.verdicts) for search in searches)
    stats = Stats(0, sum(len(s.tasks) for s in searches), 0, evaluations, clock.perf_counter() - begin)
    return _with(answer, stats=stats, subproblems=listed(searches, b) if with_list else ())


def contact_intervals(
    a: Any, b: Any, span: Any, exact: bool, budget: int | None = None, progress: Progress | None = None,
    tolerance: float = 1e-12,
) -> ContactIntervals:
    """All closed times of contact: by algebra, or certified in doubles where algebra does not take the pair.

    tolerance: as part of the span, of the certified path only; algebra is exact.
    """
    begin = clock.perf_counter()
    x, y = without_idle_turn(a), without_idle_turn(b)
    if x is not a or y is not b:
        return replace(contact_intervals(x, y, span, exact, budget, progress, tolerance), a=a, b=b)
    if _goes_by_triangles(a) or _goes_by_triangles(b):
        return _intervals_of_mesh(a, b, span, exact, Work(budget, progress), tolerance)
    models = _models(a, b)
    first, last = _span(models, span)
    shared = {"a": a, "b": b, "span": (to_double(first), to_double(last))}
    if not exact and budget is None and _is_free(a, b, first, last, shared["span"]):
        stats = Stats(seconds=clock.perf_counter() - begin)
        return ContactIntervals((), Status.FREE, shared["span"][1], None, stats, **shared)
    try:
        return _decided_intervals(a, b, first, last, exact, Work(budget, progress, below(first)), begin, shared)
    except UnsupportedPair as refusal:
        if exact:
            raise
        work = Work(budget, progress, below(first))
        try:
            standing = prisms_on_common_plane(*models)
            found = certified_intervals(
                standing or models, first, last, tolerance, work,
                lambda: _touching_at_start(a, b, first, begin, shared),
            )  # fmt: skip
        except UnsupportedPair as other:
            raise UnsupportedPair(f"{refusal}; {other}") from other
    return proved_intervals(found, work, begin, shared)


def _is_free(a: Any, b: Any, first: fmpq, last: fmpq, span: tuple[float, float]) -> bool:
    """Whether the advancement of convex pieces proves, at little cost, that there is no contact at all."""
    return advance(*both_bounded(_models(a, b), span), first, last).status == "free"


def _intervals_of_mesh(a: Any, b: Any, span: Any, exact: bool, work: Work, tolerance: float) -> ContactIntervals:
    begin = clock.perf_counter()
    if exact:
        raise UnsupportedPair("contact intervals of meshes with curved models are not exact; drop exact=True")
    first, last = bounded_span(a, b, span)
    shared = {"a": a, "b": b, "span": (to_double(first), to_double(last))}

    def at_start() -> np.ndarray | None:
        return first_contact_of_mesh(a, b, first, first, False, tolerance, Work()).point

    found = intervals_of_mesh(a, b, first, last, tolerance, work, at_start)
    return proved_intervals(found, work, begin, shared)


def proved_intervals(found: Found, work: Work, begin: float, shared: dict[str, Any]) -> ContactIntervals:
    """What the certified path found, as a result."""
    first, last = shared["span"]
    intervals = []
    for x in found.intervals:
        start, end = ((max(lo, first) + 0.0, min(hi, last) + 0.0) for lo, hi in (x.start, x.end))  # never -0.0
        intervals.append(ContactInterval(_middle(start), end[0] if x.open else _middle(end), start, end))
    status, until = Status.FREE, last
    if intervals:
        until = intervals[0].start_interval[0]
        status = Status.INITIAL_CONTACT if intervals[0].start_interval == (first, first) else Status.CONTACT
    if found.reason is not None:
        status, until = Status.UNDECIDED, max(first, found.until)
    stats = Stats(work.done, seconds=clock.perf_counter() - begin)
    return ContactIntervals(tuple(intervals), status, until, found.reason, stats, **shared)


def _middle(interval: tuple[float, float]) -> float:
    lo, hi = interval
    return min(max(lo + 0.5 * (hi - lo), lo), hi)


def _touching_at_start(a: Any, b: Any, first: fmpq, begin: float, shared: dict[str, Any]) -> np.ndarray | None:
    """A common point at time 0, when moving bodies still stand as they are; None where none is known."""
    poses = [x.motion(0.0) for x in (a, b) if isinstance(x, Moving)]
    if first != 0 or not all(np.array_equal(pose, np.eye(4)) for pose in poses):
        return None
    return _at_start(a, b, first, begin, shared).point


def _decided_intervals(
    a: Any, b: Any, first: fmpq, last: fmpq, exact: bool, work: Work, begin: float, shared: dict[str, Any]
) -> ContactIntervals:
    """The answer of exact arithmetic: between two candidates the models overlap all the time or not at all."""
    found: list[tuple[_End, _End]] = []
    tests = evaluations = 0
    reason = None
    try:
        for search in _searches(a, b, first, last, work):
            for start, end in list(_windows(search)):
                if found and found[-1][1].is_same_time(start):
                    found[-1] = found[-1][0], end
                else:
                    found.append((start, end))
            tests, evaluations = tests + len(search.tasks), evaluations + len(search.verdicts)
    except Spent:
        reason = "budget"
    intervals = tuple(interval_of(start, end, exact) for start, end in found)
    at_start = bool(found) and found[0][0].is_at(first)
    status = Status.FREE if not found else Status.INITIAL_CONTACT if at_start else Status.CONTACT
    until = intervals[0].start if intervals else to_double(last)
    if reason is not None:
        status, until = Status.UNDECIDED, work.free_until
    stats = Stats(0, tests, 0, evaluations, clock.perf_counter() - begin)
    return ContactIntervals(intervals, status, until, reason, stats, **shared)


def bounded_span(a: Any, b: Any, span: Any) -> tuple[fmpq, fmpq]:
    first, last = common_span(a, b, span)
    if last is None:
        raise UnsupportedPair("curved models need a bounded span; give span=(first, last)")
    return first, last


def _span(models: tuple[Any, Any], span: Any) -> tuple[fmpq, fmpq]:
    first, last = bounded_span(*models, span)
    a: Any = shape_of(models[0])
    b: Any = shape_of(models[1])
    if not (a.bounded or b.bounded):
        raise UnsupportedPair(f"{a!r} and {b!r} are both unbounded; one of them must be bounded")
    return first, last


def _model(body: Any) -> CompositeQuadric:
    shape: Any = shape_of(body)
    return as_model(shape) if isinstance(shape, Polyhedron) else shape


def _goes_by_triangles(body: Any) -> bool:
    shape: Any = shape_of(body)
    return isinstance(shape, Polyhedron) and not is_small_and_convex(shape)


def _searches(a: Any, b: Any, first: fmpq, last: fmpq, work: Work) -> Iterator[Search]:
    """One for every piece of the relative motion, in time order; all before the one given last is settled."""
    model_a, model_b = _model(a), _model(b)
    for piece in relative_pieces(a, b, first, last):
        if not piece.exact:
            raise UnsupportedPair(f"{piece.of}: the pose before this step is irrational; such steps are not supported")
        work.free_until = below(piece.start)
        yield Search(Pair(model_a, model_b, piece), work)


def _answer(search: Search, at_start: bool, exact: bool, shared: dict[str, Any]) -> FirstContact | None:
    """The answer if the piece has one; None when it is free."""
    if at_start:
        touching = search.at_start()
        if touching or search.overlaps_after_start() or search.coincides_at_start():
            return _initial(search, touching, exact, shared)
        if search.may_share_a_point_after_start():
            return _open(search, AlgebraicRoot.of(search.pair.piece.u_lo), shared)
    meetings = search.first()
    if not meetings:
        stopped = search.stop()
        return None if stopped is None else _open(search, stopped[0].root, shared)
    root = meetings[0].candidate.root
    if exact and not isinstance(root, AlgebraicRoot):
        return _open(search, root, shared)
    return contact_of(search, meetings, exact, shared)


def _open(search: Search, root: Root, shared: dict[str, Any]) -> FirstContact:
    """UNDECIDED: nothing was found before the root's enclosure, and exact arithmetic does not reach further."""
    until = world_time(search.pair, AlgebraicRoot.of(root.lo))[1][0]
    return FirstContact(
        Status.UNDECIDED, free_until=max(until, shared["span"][0]), reason="precision", **shared
    )


def _initial(search: Search, touching: list[Meeting], exact: bool, shared: dict[str, Any]) -> FirstContact:
    """INITIAL_CONTACT; whether the interiors overlap is asked of the start itself, where its pose is rational."""
    pair, start = search.pair, shared["span"][0]
    u = pair.piece.u_lo if search.starts_rational else search.moment_after_start()
    kind = "touching"
    if overlap_around(pair, u, [m.shared.at for m in touching]):
        kind = "containment" if not touching and is_containment(pair, u) else "overlapping"
    found = FirstContact(
        Status.INITIAL_CONTACT, start, (start, start), fraction(pair.piece.start) if exact else None, **shared
    )
    if touching:
        point = contact_of(search, touching, False, shared)
        found = _with(
            found, point=point.point, element_a=point.element_a, element_b=point.element_b, others=point.others,
            multiplicity=point.multiplicity, contact_set=point.contact_set,
        )  # fmt: skip
    return _with(found, initial=kind, free_until=start)


def _with(answer: FirstContact, **changes: Any) -> FirstContact:
    return replace(answer, **changes)


class _End:
    """An end of an interval of contact: a root of the piece's u, or one of the piece's ends."""

    def __init__(self, search: Search, root: Root | None, time: fmpq | None = None) -> None:
        self.search, self.root, self.time = search, root, time

    def is_at(self, time: fmpq) -> bool:
        if self.root is None:
            return self.time == time
        return self.search.pair.piece.clock.compare(self.root, time) == 0

    def is_same_time(self, other: _End) -> bool:
        """For an end of one piece and a start of the next: they can only meet where the pieces do."""
        return self.is_at(other.search.pair.piece.start) and other.is_at(other.search.pair.piece.start)

    def value(self, exact: bool) -> tuple[float, tuple[float, float], Any]:
        if self.root is None:
            assert self.time is not None
            t = to_double(self.time)
            return t, (t, t), fraction(self.time) if exact else None
        t, around = world_time(self.search.pair, self.root)
        known = exact and isinstance(self.root, AlgebraicRoot)
        return t, around, self.search.pair.piece.exact_time(self.root) if known else None


def _windows(search: Search) -> Iterator[tuple[_End, _End]]:
    """The closed windows of contact in one piece: between two candidates nothing changes."""
    piece = search.pair.piece
    start: _End | None = None
    if any(isinstance(candidate.root, OpenRoot) for candidate in search.candidates):
        raise UnsupportedPair("an edge of degree 4 leaves a stretch of time undecided; its intervals are not supported")
    lo = piece.u_lo
    before = _End(search, None, piece.start)
    for group in search.groups():
        root = group[0].root
        if piece.clock.compare(root, piece.start) > 0:
            if _share(search, between(lo, root)):
                start = start or before
            elif start is not None:
                yield start, before
                start = None
        here = _End(search, root)
        if start is None and search.meetings(group):
            start = here
        before, lo = here, search.beyond(root)
    assert piece.u_hi is not None and piece.end is not None
    if before.root is None or piece.clock.compare(before.root, piece.end) < 0:
        if _share(search, (lo + piece.u_hi) / 2):
            yield start or before, _End(search, None, piece.end)
            return
    if start is not None:
        yield start, before


def _share(search: Search, u: fmpq) -> bool:
    """Whether the models share a point at u, which is no candidate."""
    shared = search.share_a_point(u)
    if shared is None:
        raise UnsupportedPair("the models come so close that it is not proved whether they touch")
    return shared
