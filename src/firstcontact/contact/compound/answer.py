"""One answer about two bodies out of the answers about their pieces."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

from firstcontact.body.compound.compound import CompoundPiece, about_models
from firstcontact.contact.compound.windows import CompoundSide, PairWindow
from firstcontact.result import (
    MOST_OTHERS,
    ContactIntervals,
    Element,
    ElementPair,
    FirstContact,
    Stats,
    Status,
)
from firstcontact.timeline.answers import union
from firstcontact.work import Query

Sides = tuple[CompoundSide, CompoundSide]


@dataclass(frozen=True)
class PieceAnswer:
    """An answer about two pieces of two bodies."""

    sides: Sides
    window: PairWindow
    found: FirstContact

    @cached_property
    def named(self) -> list[ElementPair]:
        """The pairs of elements that touch, by the names of the bodies; none of walls between pieces."""
        found = self.found
        if found.element_a is None or found.element_b is None:
            return []
        pairs = [ElementPair(found.element_a, found.element_b), *found.others]
        a, b = self.sides
        named = []
        for pair in pairs:
            one = _element(a, a.pieces[self.window.a], pair.element_a, "a")
            other = _element(b, b.pieces[self.window.b], pair.element_b, "b")
            if one is not None and other is not None:
                named.append(ElementPair(one, other))
        return named


def combined(
    query: Query, sides: Sides, told: Sequence[PieceAnswer], is_within_deviation: Callable[[], bool | None]
) -> FirstContact:
    """The first contact of the bodies; is_within_deviation: of a start in contact, asked when it is first read."""
    stats = query.stats()
    for x in told:
        stats = stats + replace(x.found.stats, seconds=0.0, ways=())
    problems = tuple(problem for x in told for problem in x.found.subproblems)
    known: dict[str, Any] = {**query.shared, **about_models(*query.bodies), "subproblems": problems}
    initial = [x for x in told if x.found.status is Status.INITIAL_CONTACT]
    if initial:
        found = _initial(query, sides, initial, {**known, "stats": stats})
        if found.initial == "touching":
            return found
        later = "within_deviation"
        given = {field.name: getattr(found, field.name) for field in fields(found) if field.name != later}
        return FirstContact.deferring(given, lambda: {later: is_within_deviation()}, later)
    open_ = [x.found for x in told if x.found.status is Status.UNDECIDED]
    met = [x for x in told if x.found.status is Status.CONTACT]
    until = min((x.free_until for x in open_ if x.free_until is not None), default=math.inf)
    if not met:
        if open_:
            reason = next(x.reason for x in open_ if x.free_until == until)
            return FirstContact(Status.UNDECIDED, free_until=until, reason=reason, stats=stats, **known)
        return FirstContact(Status.FREE, free_until=query.span[1], stats=stats, **known)
    lo = min(min(_interval(x)[0] for x in met), until)
    hi = min(_interval(x)[1] for x in met)
    if hi - lo > query.tolerance * _width(query) and until == lo:
        reason = next(x.reason for x in open_ if x.free_until == until)
        return FirstContact(Status.UNDECIDED, free_until=until, reason=reason, stats=stats, **known)
    return _contact(sides, [x for x in met if _interval(x)[0] <= hi], (lo, hi), {**known, "stats": stats})


def _width(query: Query) -> float:
    lo, hi = query.span
    return hi - lo if math.isfinite(hi) else max(1.0, abs(lo))


def _interval(x: PieceAnswer) -> tuple[float, float]:
    assert x.found.time_interval is not None
    return x.found.time_interval


def _contact(
    sides: Sides, met: list[PieceAnswer], interval: tuple[float, float], known: dict[str, Any]
) -> FirstContact:
    """CONTACT of those pieces that may all touch first: told of the earliest whose elements are the bodies' own."""
    ordered = sorted(met, key=lambda x: (x.found.time, x.window.a, x.window.b))
    first = next((x for x in ordered if x.named), ordered[0])
    pairs = list(dict.fromkeys(pair for x in ordered for pair in x.named)) or [_nameless(sides)]
    own = len(ordered) == 1
    found = first.found
    assert found.time is not None
    told = {
        **known, "status": found.status, "time": min(max(found.time, interval[0]), interval[1]),
        "time_interval": interval, "time_exact": found.time_exact, "initial": None, "reason": None,
        "element_a": pairs[0].element_a, "element_b": pairs[0].element_b, "others": tuple(pairs[1 : 1 + MOST_OTHERS]),
        "multiplicity": max(found.multiplicity, len(pairs)) if own else len(pairs), "free_until": interval[0],
        "stats": replace(known["stats"], ways=found.stats.ways),
    }  # fmt: skip

    def place() -> dict[str, object]:
        return {"point": found.point, "normal": found.normal, "contact_set": found.contact_set if own else None}

    return FirstContact.deferring(told, place)


def _element(side: CompoundSide, piece: CompoundPiece | None, element: Element, which: str) -> Element | None:
    return element if piece is None else piece.element(element, side.name or which)


def _nameless(sides: Sides) -> ElementPair:
    """Faces without a number, where pieces touch in the walls between them alone."""
    names = [side.name or which for side, which in zip(sides, "ab", strict=True)]
    return ElementPair(*(Element("face", name, -1, name) for name in names))


def _initial(query: Query, sides: Sides, met: list[PieceAnswer], known: dict[str, Any]) -> FirstContact:
    """INITIAL_CONTACT.  How the bodies lie to each other follows from their pieces, but for one inside the other."""
    kinds = {x.found.initial for x in met}
    kind: str | None
    if kinds == {"touching"} or all(len(side.pieces) == 1 for side in sides):
        kind = met[0].found.initial
    elif kinds & {"overlapping", "containment"}:
        kind = None if _one_may_hold_the_other(query) else "overlapping"
    else:
        kind = None
    first = next((x for x in met if x.named), met[0])
    pairs = list(dict.fromkeys(pair for x in met for pair in x.named))
    start = query.span[0]
    return replace(
        first.found, initial=kind, time=start, time_interval=(start, start), free_until=start,
        element_a=pairs[0].element_a if pairs else None, element_b=pairs[0].element_b if pairs else None,
        others=tuple(pairs[1 : 1 + MOST_OTHERS]), multiplicity=len(pairs),
        contact_set=first.found.contact_set if len(met) == 1 else None, **known,
    )  # fmt: skip


def _one_may_hold_the_other(query: Query) -> bool:
    """By their boxes at the start."""
    start = query.span[0]
    (lo, hi), (low, high) = (body.bounds((start, start)) for body in query.bodies)
    return bool(((lo >= low) & (hi <= high)).all() or ((low >= lo) & (high <= hi)).all())


def joined(query: Query, told: Sequence[ContactIntervals]) -> ContactIntervals:
    """All times at which some pieces are in contact: the union of theirs."""
    stats: Stats = query.stats()
    for found in told:
        stats = stats + replace(found.stats, seconds=0.0, ways=())
    ways = next((found.stats.ways for found in told if len(found)), ())
    known: dict[str, Any] = {**query.shared, **about_models(*query.bodies), "stats": replace(stats, ways=ways)}
    open_ = [x for x in told if x.status is Status.UNDECIDED]
    until = min((x.free_until for x in open_ if x.free_until is not None), default=math.inf)
    merged = union([interval for x in told for interval in x if interval.start <= until])
    if open_:
        reason = next(x.reason for x in open_ if x.free_until == until)
        return ContactIntervals(tuple(merged), Status.UNDECIDED, until, reason, **known)
    start = query.span[0]
    at_start = any(x.status is Status.INITIAL_CONTACT and x.span[0] == start for x in told)
    status = Status.FREE if not merged else Status.INITIAL_CONTACT if at_start else Status.CONTACT
    until = merged[0].start_interval[0] if merged else query.span[1]
    return ContactIntervals(tuple(merged), status, until, **known)
