"""`first_contact` and `contact_intervals` of two ruled surfaces, or of one and a polyhedron: which way answers.

Elimination is asked first where degrees are small, else a search in doubles with proofs; a polyhedron goes by its
triangles, and as a solid of planes where it is convex and small.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.in_turn import first_in_turn, intervals_in_turn
from firstcontact.contact.leading import leads
from firstcontact.contact.named import element
from firstcontact.contact.reduce import is_small_and_convex
from firstcontact.contact.ruled import certified, posed
from firstcontact.contact.ruled.crossing import Renamed, across
from firstcontact.contact.ruled.in_one_plane import in_one_plane
from firstcontact.contact.ruled.triangles import MOST_PAIRS, Interior, near_pairs, parts_of
from firstcontact.contact.ruled_solid import certified as by_search
from firstcontact.contact.ruled_solid.level_pieces import first_of_level, intervals_of_level
from firstcontact.contact.signs import exactly
from firstcontact.contact.signs.conditions import conditions
from firstcontact.contact.signs.exactly import PiecePair, span_of
from firstcontact.contact.signs.sheets import Reach, TooLarge
from firstcontact.contact.signs.starts import with_start
from firstcontact.contact.signs.times import Times
from firstcontact.contact.signs.touches import touch
from firstcontact.contact.swapped import swapped
from firstcontact.contact.ways import Passed, R, Way, answered, tried
from firstcontact.exact.numbers import below
from firstcontact.motion.moving import shape_of
from firstcontact.motion.relative.polynomial import PolynomialPiece, relative_pieces
from firstcontact.result import ContactIntervals, Element, FirstContact, Status
from firstcontact.search.rulings.directrices import DirectrixPiece, directrix_pieces
from firstcontact.work import Query, Work

if TYPE_CHECKING:
    from firstcontact.body.kinds import RuledBody

SETUP = 8
"""Decisions of a time that take as long as the equations of a pair: of many triangles these are most of the work."""


@intervals_of_level
def intervals(query: Query) -> ContactIntervals:
    """All closed times at which the bodies share a point; in doubles, with proofs, where elimination goes too far.

    tolerance: as part of the span, of the certified path only.
    """
    flat = in_one_plane(query)
    if flat is None:
        return _all_contacts(query)
    return answered([
        Way("in one plane", lambda *_: flat.intervals(_all_contacts, first)),
        Way("in space", lambda *_: _all_contacts(query)),
    ], query)  # fmt: skip


def _all_contacts(query: Query) -> ContactIntervals:
    if _is_with_convex(query):
        return intervals_in_turn(query, _of_convex, _all_of_convex, _all_exactly)
    return intervals_in_turn(query, _in_doubles, _all_in_doubles, _all_exactly)


@first_of_level
def first(query: Query) -> FirstContact:
    """The first shared point."""
    flat = in_one_plane(query)
    if flat is None:
        return _first_shared(query)
    return answered([
        Way("in one plane", lambda *_: flat.first(_first_shared)), Way("in space", lambda *_: _first_shared(query))
    ], query)  # fmt: skip


def _first_shared(query: Query) -> FirstContact:
    return with_start(query, _first_contact)


def _first_contact(query: Query) -> FirstContact:
    if _is_with_convex(query):
        return first_in_turn(query, _of_convex, _exactly, _is_told)
    return first_in_turn(query, _in_doubles, _exactly, _is_told)


def _in_doubles(query: Query) -> FirstContact:
    pieces = certified.pieces_of(query)
    return posed.first(query, query.work()) if pieces is None else certified.first(pieces, query)


def _all_in_doubles(query: Query, work: Work) -> ContactIntervals:
    pieces = certified.pieces_of(query)
    return posed.intervals(query, work) if pieces is None else certified.intervals(pieces, query, work)


def _of_convex(query: Query) -> FirstContact:
    """By features of the solid, or of what that does not take by its triangles."""
    found = tried(lambda: by_search.first(query))
    return _in_doubles(query) if isinstance(found, Passed) else found


def _all_of_convex(query: Query, work: Work) -> ContactIntervals:
    found = tried(lambda: by_search.intervals(query, work, lambda: first(query.at_start)))
    return _all_in_doubles(query, work) if isinstance(found, Passed) else found


def _is_with_convex(query: Query) -> bool:
    """Whether one of the bodies is a polyhedron that is a solid of planes, too."""
    shapes: list[Any] = [shape_of(x) for x in query.bodies]
    return any(isinstance(shape, Polyhedron) and is_small_and_convex(shape) for shape in shapes)


def _is_told(proved: FirstContact) -> bool:
    """Whether exact arithmetic has nothing to add but to a start: the bodies are free, or one point touches."""
    if proved.status is Status.CONTACT:
        return proved.contact_set is not None
    return proved.status is not Status.UNDECIDED


# -- in exact arithmetic --------------------------------------------------------------------------------------


def _exactly(query: Query, reach: Reach) -> FirstContact:
    """Of the leading body as a, so that the same is told in either order.  Raises TooLarge beyond the degree."""
    work = query.work()

    def asked(query: Query) -> FirstContact:
        return exactly.first(query, _pieces(query, work, reach), Interior.of(*query.bodies), work)

    if leads(*query.bodies):
        return _in_either_order(query, asked, swapped)
    return swapped(_in_either_order(replace(query, a=query.b, b=query.a), asked, swapped))


def _all_exactly(query: Query, work: Work, reach: Reach) -> ContactIntervals:
    """Raises TooLarge beyond the degree."""

    def asked(query: Query) -> ContactIntervals:
        windows = exactly.all_windows(_pieces(query, work, reach), Interior.of(*query.bodies))
        return exactly.as_intervals(*windows, query, work)

    def back(found: ContactIntervals) -> ContactIntervals:
        return replace(found, a=query.a, b=query.b)

    told: ContactIntervals = _in_either_order(query, asked, back)
    return told


def _in_either_order(query: Query, asked: Callable[[Query], R], back: Callable[[R], R]) -> R:
    """The answer; in the other order of the bodies, taken back, where equations are too large: b's motion may be so."""
    try:
        return asked(query)
    except TooLarge as refusal:
        try:
            return back(asked(replace(query, a=query.b, b=query.a)))
        except TooLarge:
            raise refusal from None


def _pieces(query: Query, work: Work, reach: Reach) -> Iterator[tuple[PolynomialPiece, list[PiecePair]]]:
    """The pieces of the relative motion in time order, with the pairs of pieces of the surfaces that may meet."""
    a, b, first, last = query.a, query.b, query.first, query.end
    parts_a, parts_b = parts_of(a), parts_of(b)
    numbers = [(0, 0)]
    if len(parts_a) * len(parts_b) > 1:
        numbers = near_pairs(parts_a, parts_b, first, last)
        if len(numbers) > MOST_PAIRS:
            raise TooLarge(
                f"{a!r} and {b!r}: {len(numbers)} pairs of pieces and triangles come near each other, too many for "
                "exact arithmetic"
            )
    if not numbers:
        yield from ((motion, []) for motion in relative_pieces(a, b, first, last))
        return
    combined = [(i, j, *across(parts_a[i], parts_b[j])) for i, j in numbers]
    for steps in zip(*(directrix_pieces(x, y, first, last) for _, _, x, y, _ in combined), strict=True):
        work.free_until = below(steps[0].motion.start)
        found = [_pair(query, pair, step, work, reach) for pair, step in zip(combined, steps, strict=True)]
        yield steps[0].motion, found


def _pair(
    query: Query,
    pair: tuple[int, int, RuledBody, RuledBody, tuple[Renamed, Renamed]],
    step: DirectrixPiece,
    work: Work,
    reach: Reach,
) -> PiecePair:
    i, j, x, y, names = pair
    span = span_of(step.motion)
    joined = shape_of(x).joined, shape_of(y).joined
    times = Times(conditions(x, y, step, span), span, work, reach)
    work.step(SETUP * times.steps)
    of = {"a": (query.a, i, names[0]), "b": (query.b, j, names[1])}

    def named(known: tuple[str, int], which: str) -> Element | None:
        body, number, renamed = of[which]
        return element(body, *renamed(known), number, which)

    return PiecePair(step.motion, times, lambda contact: touch(contact, joined), named)
