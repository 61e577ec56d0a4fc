"""`first_contact` and `contact_intervals` of a ruled surface and a solid of planes and quadrics: which way answers.

First contacts are certified in doubles at first, in a few ms, and decided exactly where that leaves something open;
intervals the other way round, as elimination is the shorter way to them where degrees are small.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from flint import fmpq

from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.contact.in_turn import first_in_turn, intervals_in_turn
from firstcontact.contact.models.answer import element as element_of_solid
from firstcontact.contact.named import element
from firstcontact.contact.ruled.triangles import near_pairs, parts_of
from firstcontact.contact.ruled_solid import certified
from firstcontact.contact.ruled_solid.level_pieces import first_of_level, intervals_of_level
from firstcontact.contact.ruled_solid.solid_conditions import SolidConditions
from firstcontact.contact.ruled_solid.solid_times import solid_times
from firstcontact.contact.ruled_solid.solid_touches import lies, solid_touch
from firstcontact.contact.signs import exactly
from firstcontact.contact.signs.exactly import PiecePair, span_of
from firstcontact.contact.signs.sheets import Reach
from firstcontact.contact.signs.starts import with_start
from firstcontact.contact.signs.whole_rulings import cut_to
from firstcontact.contact.swapped import swapped
from firstcontact.exact.numbers import below
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.polynomial import PolynomialPiece, relative_pieces
from firstcontact.result import ContactIntervals, Element, FirstContact, Status
from firstcontact.search.rulings.directrices import sides_from
from firstcontact.work import Query, Work

if TYPE_CHECKING:
    from firstcontact.contact.signs.conditions import SignConditions


@first_of_level
def first(query: Query) -> FirstContact:
    """The first shared point; in doubles, and exactly what they leave open or do not take, as the method allows."""
    return with_start(query, _first_contact)


def _first_contact(query: Query) -> FirstContact:
    return first_in_turn(query, certified.first, _exactly, _is_told)


def _exactly(query: Query, reach: Reach) -> FirstContact:
    work, (ordered, is_turned) = query.work(), _solid_last(query)
    found = exactly.first(ordered, _pieces(ordered, work, reach), None, work)
    return replace(swapped(found) if is_turned else found, a=query.a, b=query.b)


def _is_told(proved: FirstContact) -> bool:
    """Whether exact arithmetic has nothing to add to what was proved about a surface and a solid, but to a start."""
    if proved.status is Status.CONTACT:
        return proved.element_a is not None
    return proved.status is not Status.UNDECIDED


def _solid_last(query: Query) -> tuple[Query, bool]:
    """The query with the solid as b and whole rulings cut, and whether the bodies changed places."""
    is_turned = isinstance(shape_of(query.a), CompositeQuadric)
    ruled, solid = query.bodies[::-1] if is_turned else query.bodies
    return replace(query, a=cut_to(ruled, solid, query.span), b=solid), is_turned


@intervals_of_level
def intervals(query: Query) -> ContactIntervals:
    """All closed times of contact."""
    def decide(query: Query, work: Work, reach: Reach) -> ContactIntervals:
        ordered, _ = _solid_last(query)
        windows = exactly.all_windows(_pieces(ordered, work, reach), None)
        return exactly.as_intervals(*windows, query, work)

    def in_doubles(query: Query, work: Work) -> ContactIntervals:
        return certified.intervals(query, work, lambda: first(query.at_start))

    return intervals_in_turn(query, certified.first, in_doubles, decide)


def _pieces(query: Query, work: Work, reach: Reach) -> Iterator[tuple[PolynomialPiece, list[PiecePair]]]:
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
            for times in solid_times(held, span, work, reach):
                found.append(PiecePair(motion, times, touches, named, partial(_lies, times.conditions)))
        yield motion, found


def _named(query: Query, number: int, known: tuple[str, Any], which: str) -> Element | None:
    """None for a point inside the solid, b."""
    kind, index = known
    if which == "a":
        return element(query.a, kind, index, number, which)
    return None if index is None else element_of_solid(shape_of(query.b), index, which)


def _lies(conditions: SignConditions, t: fmpq) -> str:
    return lies(conditions, t) if isinstance(conditions, SolidConditions) else "touching"
