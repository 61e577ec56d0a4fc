"""`first_contact` and `contact_intervals` of a ruled surface and a solid of planes and quadrics: which way answers.

First contacts are certified in doubles at first, in a few ms, and decided exactly where that leaves something open;
intervals the other way round, as elimination is the shorter way to them where degrees are small.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

from flint import fmpq

from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.contact.models.answer import element as element_of_solid
from firstcontact.contact.named import element
from firstcontact.contact.ruled.triangles import near_pairs, parts_of
from firstcontact.contact.ruled_solid import certified
from firstcontact.contact.ruled_solid.solid_conditions import SolidConditions
from firstcontact.contact.ruled_solid.solid_times import solid_times
from firstcontact.contact.ruled_solid.solid_touches import lies, solid_touch
from firstcontact.contact.signs import exactly
from firstcontact.contact.signs.exactly import PiecePair, span_of
from firstcontact.contact.signs.sheets import MOST_DEGREE, QUICK_DEGREE
from firstcontact.contact.signs.starts import with_start
from firstcontact.contact.signs.whole_rulings import cut_to
from firstcontact.contact.swapped import swapped
from firstcontact.contact.ways import Passed, Way, answered
from firstcontact.exact.numbers import below
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.polynomial import PolynomialPiece, relative_pieces
from firstcontact.result import ContactIntervals, Element, FirstContact, Status
from firstcontact.search.rulings.directrices import sides_from
from firstcontact.work import Query, Work

SMALL_DEGREE = 150
"""Of equations for times that elimination may lead to before doubles are asked for intervals."""
QUICK_BUDGET = 50_000
"""Boxes that the search in doubles looks at before exact arithmetic is asked for a first contact."""


def first(query: Query) -> FirstContact:
    """The first shared point; in doubles, and exactly what they leave open or do not take, as the method allows."""
    return with_start(query, _first_contact)


def _first_contact(query: Query) -> FirstContact:
    return answered([
        Way("in doubles", _in_doubles, lambda query, _: not query.is_algebraic),
        Way("exactly", _exactly, lambda query, _: query.exact or query.method != "certified"),
        Way("in doubles, on and on", lambda query, _: certified.first(query), _is_cut_short),
    ], query)  # fmt: skip


def _in_doubles(query: Query, _: None) -> FirstContact | Passed:
    """Cut short where exact arithmetic may be asked too."""
    quick = QUICK_BUDGET if query.budget is None and query.method == "auto" else query.budget
    proved = certified.first(replace(query, budget=quick))
    if query.method == "certified" or _is_told(proved) or query.is_spent(proved.reason):
        return proved
    return Passed(proved.reason or "it is not told what touches", proved)


def _exactly(query: Query, proved: FirstContact | None) -> FirstContact:
    known = proved is not None and proved.status is Status.CONTACT
    work, (ordered, is_turned) = query.work(), _solid_last(query)
    stretches = _pieces(ordered, work, QUICK_DEGREE if known else MOST_DEGREE)
    found = exactly.first(ordered, stretches, None, work)
    return replace(swapped(found) if is_turned else found, a=query.a, b=query.b)


def _is_cut_short(query: Query, proved: FirstContact | None) -> bool:
    return proved is not None and proved.reason == "budget" and not query.is_spent(proved.reason)


def _is_told(proved: FirstContact) -> bool:
    """Whether exact arithmetic has nothing to add to what was proved about a surface and a solid."""
    if proved.status is Status.INITIAL_CONTACT:
        return proved.initial is not None
    if proved.status is Status.CONTACT:
        return proved.element_a is not None
    return proved.status is Status.FREE


def _solid_last(query: Query) -> tuple[Query, bool]:
    """The query with the solid as b and whole rulings cut, and whether the bodies changed places."""
    is_turned = isinstance(shape_of(query.a), CompositeQuadric)
    ruled, solid = query.bodies[::-1] if is_turned else query.bodies
    return replace(query, a=cut_to(ruled, solid, query.span), b=solid), is_turned


def intervals(query: Query) -> ContactIntervals:
    """All closed times of contact."""
    def decide(work: Work, most_degree: int) -> ContactIntervals:
        ordered, _ = _solid_last(query)
        windows = exactly.all_windows(_pieces(ordered, work, most_degree), None)
        return exactly.as_intervals(*windows, query, work)

    return in_turn(query, decide)


def in_turn(query: Query, decide: Callable[[Work, int], ContactIntervals]) -> ContactIntervals:
    """What `decide(work, most_degree)` tells by elimination where degrees are small, else doubles, else elimination."""
    work = query.work()

    def in_doubles(query: Query, _: None) -> ContactIntervals | Passed:
        proved = certified.intervals(query, work)
        told = proved.status is not Status.UNDECIDED or query.is_spent(proved.reason)
        return proved if told else Passed(str(proved.reason), proved)

    return answered([
        Way("exactly, low degrees", lambda query, _: decide(work, SMALL_DEGREE), lambda query, _: not query.exact),
        Way("in doubles", in_doubles, lambda query, _: not query.exact),
        Way("exactly", lambda query, _: decide(work, MOST_DEGREE)),
    ], query)  # fmt: skip


def _pieces(query: Query, work: Work, most_degree: int) -> Iterator[tuple[PolynomialPiece, list[PiecePair]]]:
    """The pieces of the relative motion in time order, with the ruled pieces that the solid, b, may meet."""
    a, b, first, last = query.a, query.b, query.first, query.end
    pieces: tuple[RuledSurface, ...] = shape_of(a).pieces
    numbers = range(len(pieces))
    near = [i for i, _ in near_pairs(parts_of(a), [b], first, last)] if len(pieces) > 1 else numbers
    for motion in relative_pieces(a, b, first, last):
        work.free_until = below(motion.start)
        found = []
        for i in near:
            span, sides = span_of(motion), sides_from(pieces[i], motion)
            held = SolidConditions.of(pieces[i], sides, shape_of(b), span)
            touches, named = partial(solid_touch, joined=pieces[i].joined), partial(_named, query, i)
            for times in solid_times(held, span, work, most_degree):
                found.append(PiecePair(motion, times, touches, named, partial(_lies, times.conditions)))
        yield motion, found


def _named(query: Query, number: int, known: tuple[str, Any], which: str) -> Element | None:
    """None for a point inside the solid, b."""
    kind, index = known
    if which == "a":
        return element(query.a, kind, index, number, which)
    return None if index is None else element_of_solid(shape_of(query.b), index, which)


def _lies(conditions: Any, t: fmpq) -> str:
    return lies(conditions, t) if isinstance(conditions, SolidConditions) else "touching"
