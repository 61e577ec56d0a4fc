"""`first_contact` and `contact_intervals` of composite quadric models."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid.carriers import Plane
from firstcontact.contact import upright_parts
from firstcontact.contact.later import told_later
from firstcontact.contact.models.advancing import ignoring_advance
from firstcontact.contact.models.algorithm import CandidateSearch, Meeting, Root
from firstcontact.contact.models.answer import contact_of, listed, world_time
from firstcontact.contact.models.at_contact import contact_then, surfaces_there
from firstcontact.contact.models.at_rest import is_containment, overlap_around
from firstcontact.contact.models.certified import both_bounded, near_models, settle
from firstcontact.contact.models.exact_windows import decided_intervals
from firstcontact.contact.models.idle_turns import ignoring_idle_turns
from firstcontact.contact.models.intervals import certified_intervals
from firstcontact.contact.models.last_instant import landing
from firstcontact.contact.models.moving_pair import MovingPair
from firstcontact.contact.models.square_subproblems import needs_systems
from firstcontact.contact.models.standing import prisms_on_common_plane
from firstcontact.contact.reduce import as_model
from firstcontact.contact.ways import Passed, Way, answered, decided, is_proved, tried
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.fields.roots import AlgebraicRoot
from firstcontact.exact.numbers import above, below, fraction, simplest, to_double
from firstcontact.motion.moving import Moving, shape_of
from firstcontact.motion.relative.pieces import placement_at
from firstcontact.motion.relative.polynomial import relative_pieces
from firstcontact.motion.steps import steps_of
from firstcontact.result import ContactIntervals, FirstContact, Status
from firstcontact.search.convex.advance import Advance, advance
from firstcontact.search.convex.convex import is_of_pieces
from firstcontact.timeline.answers import proved_intervals
from firstcontact.work import Query, Spent, Work

if TYPE_CHECKING:
    from firstcontact.body.kinds import Body, Model
    from firstcontact.body.solid.composite_quadric import CompositeQuadric

QUICK_STEPS = 4000
"""Subproblems and candidates that algebra looks at before doubles are asked for intervals: a second at most.
Systems of four equations take longer than doubles do."""
QUICK_FIRST = 400
"""The same of a first contact that strides leave open: a twentieth of a second."""
FEW_PAIRS = 100
"""Of surfaces, of which algebra is asked then."""
FEW_STEPS = 8
"""Of a way, of which algebra is asked before balls."""
SURELY = 2.0**-30
"""Of a body's size: by how much it is made smaller and larger to see whether rounded poses tell how it starts."""


@ignoring_idle_turns
def first(query: Query) -> FirstContact:
    """The first contact over the span: certified in doubles where that settles it, else decided exactly.

    exact, or method "algebraic": exactly at once; "algebraic" judges and lists every subproblem too.
    """
    models = _models(query)
    strides = query.is_auto and query.budget is None  # alone, at first
    near = cache(partial(both_bounded, models, query.span))
    seen: FirstContact | None = None  # the contact that doubles prove, though not all that is shared

    def in_doubles(close_up: bool, query: Query, _: Advance | None) -> FirstContact | Passed:
        nonlocal seen
        seen, told, proved = settle(models, query, close_up=close_up)
        if seen is not None and told:
            return seen
        if proved.status == "initial":
            return _start(query, models, proved)
        if query.is_spent(proved.reason):
            return _undecided(query, proved, "budget")
        if proved.status == "open" and query.is_enough(proved.free_until):
            return _undecided(query, proved, "precision")
        return Passed(proved.reason or proved.status, proved)

    def at_last_instant(query: Query, proved: Advance) -> FirstContact | Passed:
        landed = _landed(query, *models, proved)
        return Passed("no landing") if landed is None else landed

    def as_proved(query: Query, proved: Advance) -> FirstContact:
        return _proved_only(query, models, proved) if seen is None else seen

    return answered([
        Way("in doubles", partial(in_doubles, not strides), lambda query, _: not query.is_algebraic),
        Way("soon exactly", _soon_exactly, lambda _, proved: strides and _may_soon_be_exact(proved, near)),
        Way("in balls", partial(in_doubles, True), lambda _, proved: strides and _may_be_closed_up(proved, near)),
        Way("exactly, at the contact", _at_contact, _is_contact),
        Way("exactly", _exactly),
        Way("at the last instant", at_last_instant, _has_a_later_instant),
        Way("as polyhedra", _as_polyhedra, lambda query, _: seen is None and not query.is_algebraic),
        Way("what doubles proved", as_proved, is_proved),
    ], query)  # fmt: skip


def _may_be_closed_up(proved: Advance | None, near: Callable[[], tuple[Model, Model]]) -> bool:
    """Whether strides were taken, and left it open."""
    is_open = proved is not None and proved.status == "open"
    return is_open and all(is_of_pieces(shape_of(x)) for x in near())


def _may_soon_be_exact(proved: Advance | None, near: Callable[[], tuple[Model, Model]]) -> bool:
    """Whether algebra is asked of that before it is looked at in balls: of few surfaces it takes less."""
    if not _may_be_closed_up(proved, near):
        return False
    a, b = near()
    pairs = len(shape_of(a).surfaces) * len(shape_of(b).surfaces)
    return pairs <= FEW_PAIRS and not needs_systems(a) and not needs_systems(b)


def _soon_exactly(query: Query, _: Advance) -> FirstContact | Passed:
    own = query.limited(QUICK_FIRST)
    found = _decided(own, own.work())
    return Passed(str(found.reason)) if found.status is Status.UNDECIDED else found


def _start(query: Query, models: tuple[Model, Model], proved: Advance) -> FirstContact:
    """A start in contact that doubles prove; how the bodies lie then, and what touches, is worked out when it is read.
    """
    start = query.span[0]
    found = FirstContact(
        Status.INITIAL_CONTACT, start, (start, start), free_until=start, stats=query.stats(proved.steps, proved.gaps),
        **query.shared,
    )  # fmt: skip
    asked = replace(query, budget=None, progress=None)

    def told() -> FirstContact:
        exactly = tried(partial(_exactly, asked, proved))
        return _proved_only(asked, models, proved) if isinstance(exactly, Passed) else exactly

    return told_later(found, told)


def _has_a_later_instant(query: Query, proved: Advance | None) -> bool:
    """Whether the last instant is another one than the start, whose contact is told as such."""
    return proved is not None and query.last != query.first


def _is_contact(query: Query, proved: Advance | None) -> bool:
    return proved is not None and proved.status == "contact"


def _at_contact(query: Query, proved: Advance) -> FirstContact | Passed:
    """All that touches at a contact that is proved."""
    assert proved.time_interval is not None
    a, b = near_models(_models(query), query.span)
    work = query.work()
    work.done = proved.spent
    try:
        found, search = contact_then(
            query.bodies, (shape_of(a), shape_of(b)), proved, surfaces_there((a, b), proved.time_interval),
            query.shared, work,
        )  # fmt: skip
    except Spent:
        return _undecided(query, proved, "budget")
    if found is None or search is None:
        return Passed("algebra does not tell")
    return replace(found, stats=query.stats(proved.steps, proved.gaps + len(search.tasks), len(search.verdicts)))


def _exactly(query: Query, proved: Advance | None) -> FirstContact | Passed:
    """What exact arithmetic says, unless it denies a proof."""
    work = query.work()
    if proved is not None:
        work.done = proved.spent
    decided = _decided(query, work)
    if proved is not None and _denies(decided, proved):
        return Passed("it denies what doubles proved")
    return decided


def _as_polyhedra(query: Query, _: object) -> FirstContact | Passed:
    """Of solids of planes under motions without rational poses: what doubles left open, as meshes."""
    from firstcontact.contact.mesh_model import as_polyhedra  # curved solids need not load meshes

    if not as_polyhedra.are_of_planes(*query.bodies):
        return Passed("they are not both of planes")
    found = as_polyhedra.first(query)
    return Passed(found.reason) if isinstance(found, Passed) else found


def _planar_intervals(query: Query, _: object) -> ContactIntervals | Passed:
    from firstcontact.contact.mesh_model import as_polyhedra

    if not as_polyhedra.are_of_planes(*query.bodies):
        return Passed("they are not both of planes")
    return as_polyhedra.intervals(query)


def _undecided(query: Query, proved: Advance, reason: str) -> FirstContact:
    stats = query.stats(proved.steps, proved.gaps)
    return FirstContact(
        Status.UNDECIDED, free_until=proved.free_until, reason=reason, stats=stats, **query.shared
    )


def _proved_only(query: Query, models: tuple[Model, Model], proved: Advance) -> FirstContact:
    """What the certified path proved, but for contacts, where exact arithmetic does not take the pair or denies it."""
    start = query.span[0]
    if proved.status == "initial" or proved.free_until <= start:
        there = _at_start(query)
        if there.status is Status.INITIAL_CONTACT:
            return there
        if proved.status == "initial":  # proved for the true pose, though its doubles do not touch
            return replace(
                there, status=Status.INITIAL_CONTACT, time=start, time_interval=(start, start), free_until=start
            )
        if there.status is Status.FREE and proved.reason == "precision" and _starts_rational(query):
            return _from_apart(query, models, proved)
    if proved.reason not in ("precision", "budget", None):
        raise UnsupportedPair(f"it is not decided: {proved.reason}")
    return _undecided(query, proved, proved.reason or "precision")


def _from_apart(query: Query, models: tuple[Model, Model], before: Advance) -> FirstContact:
    """What doubles tell of bodies that exact arithmetic knows to be apart at the start, as close fits are hidden.

    before: what they told when they did not know that.
    """
    left = None if query.budget is None else max(query.budget - before.spent, 0)
    seen, _, proved = settle(models, replace(query, budget=left), apart=True)
    if seen is None:
        seen = _landed(query, *models, proved)
    return _undecided(query, proved, proved.reason or "precision") if seen is None else seen


def _landed(query: Query, a: Model, b: Model, proved: Advance) -> FirstContact | None:
    """CONTACT where the bodies are proved free up to the last instant, or up to one of a graze, and touch then."""
    start, end = query.span
    free_until, instant = proved.free_until, query.end
    if proved.graze is not None:
        instant = simplest(*proved.graze)
    elif proved.status != "open" or above(instant) - free_until > query.tolerance * (end - start):
        return None
    found = landing(a, b, instant)
    if found is None:
        return None
    pair = found[0].pair
    seen = contact_of(*found, False, {**query.shared, "a": pair.a, "b": pair.b})
    return replace(
        seen, a=query.a, b=query.b, time=to_double(instant), time_interval=(free_until, above(instant)),
        free_until=free_until, stats=query.stats(proved.steps, proved.gaps),
    )  # fmt: skip


def _denies(answer: FirstContact, proved: Advance) -> bool:
    """Whether the answer has no contact where one is proved."""
    if proved.status == "initial":
        return answer.status is not Status.INITIAL_CONTACT
    if proved.status != "contact":
        return False
    assert proved.time_interval is not None and answer.free_until is not None
    return answer.status is Status.FREE or answer.free_until > proved.time_interval[1]


def _at_start(query: Query) -> FirstContact:
    """The answer for the start alone: exact where the poses then are rational, else in the poses as doubles.

    Those tell how the bodies touch or overlap where it is the same for one that is a little smaller or larger.
    """
    start = query.span[0]
    there = [(placement_at(body, query.first), body) for body in query.bodies]
    rational = _starts_rational(query)
    x, y = (pose.place(shape_of(body)) if rational else _rounded(body, start) for pose, body in there)

    def decided(x: CompositeQuadric) -> FirstContact:
        return _decided(replace(query, a=x, b=y, last=query.first, exact=False, method="auto"), Work())

    found = decided(x)
    told = rational or found.initial is None or all(decided(z).initial == found.initial for z in _smaller_and_larger(x))
    return replace(found, initial=found.initial if told else None, **query.shared)


def _starts_rational(query: Query) -> bool:
    return all(placement_at(body, query.first).is_exact for body in query.bodies)


def _rounded(body: Any, t: float) -> Any:
    return body.at(t) if isinstance(body, Moving) else body


def _smaller_and_larger(body: CompositeQuadric) -> list[CompositeQuadric]:
    """By more than rounding of poses moves it."""
    lo, hi = body.bounds()
    middle = np.where(np.isfinite(lo + hi), 0.5 * (lo + hi), 0.0)
    poses = []
    for factor in (1.0 - SURELY, 1.0 + SURELY):
        pose = np.diag([factor, factor, factor, 1.0])
        pose[:3, 3] = (1.0 - factor) * middle
        poses.append(pose)
    return [body.transformed(pose) for pose in poses]


def _models(query: Query) -> tuple[Model, Model]:
    """Both as models, at rest or moving as they were.  UnsupportedPair for two that are unbounded."""
    models = _as_model(query.a), _as_model(query.b)
    a: Any = shape_of(models[0])
    b: Any = shape_of(models[1])
    if not (a.bounded or b.bounded):
        raise UnsupportedPair(f"{a!r} and {b!r} are both unbounded; one of them must be bounded")
    return models


def _as_model(body: Body) -> Any:
    shape: Any = shape_of(body)
    if not isinstance(shape, Polyhedron):
        return body
    return Moving(as_model(shape), body.motion) if isinstance(body, Moving) else as_model(shape)


def _decided(query: Query, work: Work) -> FirstContact:
    """The answer of exact arithmetic; method "algebraic" lists all subproblems."""
    with_list = query.method == "algebraic"
    searches: list[CandidateSearch] = []
    answer: FirstContact | None = None
    try:
        for search in _searches(query, work):
            searches.append(search)
            if answer is None:
                answer = _answer(search, len(searches) == 1, query)
            if answer is not None and not with_list:
                break
    except Spent:
        answer = FirstContact(Status.UNDECIDED, free_until=work.free_until, reason="budget", **query.shared)
    work.budget = None  # it is for the answer; a list that was asked for is complete
    if answer is None:
        answer = FirstContact(Status.FREE, free_until=query.span[1], **query.shared)
        if searches and searches[-1].may_share_a_point_at_end():  # an event was missed: never call that free
            answer = FirstContact(
                Status.UNDECIDED, free_until=query.span[0], reason="precision", **query.shared
            )
    evaluations = sum(len(search.verdicts) for search in searches)
    stats = query.stats(0, sum(len(s.tasks) for s in searches), evaluations)
    return replace(answer, stats=stats, subproblems=listed(searches, query.b) if with_list else ())


@ignoring_idle_turns
@ignoring_advance
def intervals(query: Query) -> ContactIntervals:
    """All closed times of contact: of solids of planes as polyhedra, many times as quick; of others by algebra where
    that is soon done, else certified in doubles, else by algebra.

    tolerance: as part of the span, of the certified path only; algebra is exact.
    """
    models = _models(query)
    surfaces = (surface for model in models for surface in shape_of(model).surfaces)
    planar = not query.is_algebraic and all(isinstance(surface, Plane) for surface in surfaces)
    free_until = query.span[0]
    shared = query.work()

    def work(own: Query) -> Work:
        """The one account of the caller's budget; else one of that way's own."""
        return own.work() if query.budget is None else shared

    def if_free(query: Query, _: None) -> ContactIntervals | Passed:
        nonlocal free_until
        seen = _at_little_cost(query, models)
        free_until = seen.free_until
        if seen.status != "free":
            return Passed("not free")
        return ContactIntervals.free(query.stats(), **query.shared)

    def soon_decided(query: Query, _: None) -> ContactIntervals | Passed:
        return decided(by_algebra(query, work(query.limited(QUICK_STEPS))), query)

    def in_doubles(query: Query, _: None) -> ContactIntervals | Passed:
        done, pair = work(query), prisms_on_common_plane(*models) or models
        found = certified_intervals(
            pair, query.first, query.end, query.tolerance, done, lambda: _touching_at_start(query)
        )
        return decided(proved_intervals(found, done, query), query)

    def by_algebra(query: Query, account: Work) -> ContactIntervals:
        return decided_intervals(query, _searches(query, account, free_until), account, free_until)

    return answered([
        Way("in doubles, if free", if_free, lambda query, _: not query.is_algebraic and query.budget is None),
        Way("as polyhedra", _planar_intervals, lambda query, _: planar and query.budget is None),
        Way("soon exactly", soon_decided, lambda query, _: query.is_auto and _may_soon_be_listed(query, models)),
        Way("in doubles", in_doubles, lambda query, _: not query.is_algebraic),
        Way("exactly", lambda query, _: by_algebra(query, work(query)), lambda query, _: not query.is_certified),
        Way("as polyhedra", _planar_intervals, lambda query, _: planar and query.budget is not None),
        Way("by upright parts", partial(upright_parts.intervals, ask=intervals), upright_parts.may_be_asked),
    ], query)  # fmt: skip


def _may_soon_be_listed(query: Query, models: tuple[Model, Model]) -> bool:
    """Whether algebra is asked before balls: it looks at every step of a long way anew."""
    steps = (steps_of(x.motion) for x in query.bodies if isinstance(x, Moving))
    is_long = any(next(islice(own, FEW_STEPS, None), None) is not None for own in steps)
    return not is_long and not any(map(needs_systems, models))


def _at_little_cost(query: Query, models: tuple[Model, Model]) -> Advance:
    """How far the advancement of convex pieces, of those that cover the models where they are no unions of such, proves
    that there is no contact."""
    near = both_bounded(models, query.span)
    seen = advance(*near, query.first, query.end, close_up=False)
    return advance(*near, query.first, query.end, covering=True, close_up=False) if seen.beyond else seen


def _touching_at_start(query: Query) -> np.ndarray | None:
    """A common point at the start, where poses are rational then; None where none is known."""
    found = tried(partial(_at_start, query)) if _starts_rational(query) else None
    return found.point if isinstance(found, FirstContact) else None


def _searches(query: Query, work: Work, free_until: float = -math.inf) -> Iterator[CandidateSearch]:
    """One for every piece of the relative motion, in time order; all before the one given last is settled.

    free_until: a time before which the models are proved apart; pieces that end before it are left out.
    """
    models = _models(query)
    if query.method != "algebraic":  # that lists all subproblems
        models = near_models(models, query.span)
    model_a, model_b = map(shape_of, models)
    for piece in relative_pieces(query.a, query.b, query.first, query.end):
        assert piece.end is not None
        if above(piece.end) < free_until:
            continue
        if not piece.exact:
            raise UnsupportedPair(f"{piece.of}: the pose before this step is irrational; such steps are not supported")
        work.free_until = below(piece.start)
        yield CandidateSearch(MovingPair(model_a, model_b, piece), work)


def _answer(search: CandidateSearch, at_start: bool, query: Query) -> FirstContact | None:
    """The answer if the piece has one; None when it is free."""
    if at_start:
        touching = search.at_start()
        if touching or search.overlaps_after_start() or search.coincides_at_start():
            return _initial(search, touching or [], query)
        if touching is None or search.may_share_a_point_after_start():
            return _open(search, AlgebraicRoot.of(search.pair.piece.u_lo), query)
    meetings = search.first()
    if not meetings:
        stopped = search.stop()
        return None if stopped is None else _open(search, stopped[0].root, query)
    root = meetings[0].candidate.root
    if query.exact and not isinstance(root, AlgebraicRoot):
        return _open(search, root, query)
    return contact_of(search, meetings, query.exact, query.shared)


def _open(search: CandidateSearch, root: Root, query: Query) -> FirstContact:
    """UNDECIDED: nothing was found before the root's enclosure, and exact arithmetic does not reach further."""
    until = world_time(search.pair, AlgebraicRoot.of(root.lo))[1][0]
    return FirstContact(
        Status.UNDECIDED, free_until=max(until, query.span[0]), reason="precision", **query.shared
    )


def _initial(search: CandidateSearch, touching: list[Meeting], query: Query) -> FirstContact:
    """INITIAL_CONTACT; whether the interiors overlap is asked of the start itself, where its pose is rational."""
    pair, start = search.pair, query.span[0]
    u = pair.piece.u_lo if search.starts_rational else search.moment_after_start()
    kind = "touching"
    if overlap_around(pair, u, [m.shared.at for m in touching]):
        kind = "containment" if not touching and is_containment(pair, u) else "overlapping"
    exactly = fraction(pair.piece.start) if query.exact else None
    found = FirstContact(Status.INITIAL_CONTACT, start, (start, start), exactly, **query.shared)
    if touching:
        point = contact_of(search, touching, False, query.shared)
        found = replace(
            found, point=point.point, element_a=point.element_a, element_b=point.element_b, others=point.others,
            multiplicity=point.multiplicity, contact_set=point.contact_set,
        )  # fmt: skip
    return replace(found, initial=kind, free_until=start)
